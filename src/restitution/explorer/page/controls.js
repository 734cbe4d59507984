// The controls of the inputs: a slider and a number for each quantity, a list of choices, a list of numbers.
import { element, sentence } from "./elements.js";
import { fault } from "./inputs.js";
import { convert, back, symbolNodes, systemName, typed, unitFor, unitText } from "./units.js";

// The scale of the Poisson ratio is linear up to here, and logarithmic in 0.5 - nu from here on.
const LINEAR = 0.4;
const REST = 0.5 - LINEAR;
const NEAREST = 1e-5;
const SCALES = {
  linear: { to: (value) => value, from: (place, step) => Number((Math.round(place / step) * step).toPrecision(10)) },
  log: { to: Math.log10, from: (place) => Number(Math.pow(10, place).toPrecision(4)) },
  poisson: {
    to: (value) => (value <= LINEAR ? value : LINEAR + REST * Math.log(REST / Math.max(0.5 - value, NEAREST))),
    from: (place, step) => (place <= LINEAR ? SCALES.linear.from(place, step)
      : Number((0.5 - Number((REST * Math.exp((LINEAR - place) / REST)).toPrecision(3))).toPrecision(12))),
  },
};

export class Controls {
  // tab() is the name of the tab that is shown.
  constructor(schema, state, root, tab) {
    Object.assign(this, { state, root, tab });
    this.controls = [];
    this.groups = [];
    for (const group of schema.groups) {
      const inputs = schema.inputs.filter((input) => input.group === group.name);
      if (!inputs.length) continue;
      const box = element("fieldset", { className: "group" }, element("legend", {}, group.words));
      for (const input of inputs) {
        const make = { number: NumberControl, choice: ChoiceControl, list: ListControl }[input.type];
        const control = new make(input, state);
        this.controls.push(control);
        box.append(control.root);
        if (input.key === "impact.gravity") {
          this.controls.push(new HeightControl(schema.drop_height, state));
          box.append(this.controls.at(-1).root);
        }
      }
      this.groups.push(box);
      root.append(box);
    }
    state.onChange(() => this.update());
    this.update();
  }

  update() {
    const tab = this.tab();
    // What stays as it is is left alone: a frame of the browser costs more than a solve.
    for (const control of this.controls) {
      const hidden = !(control.input.tabs.includes(tab) && this.state.shown(control.input) && control.useful());
      if (hidden !== control.root.hidden) control.root.hidden = hidden;
      if (!hidden) control.refresh();
    }
    for (const box of this.groups) {
      const hidden = [...box.children].every((one) => one.hidden || !one.matches(".control"));
      if (hidden !== box.hidden) box.hidden = hidden;
    }
  }

  // Marks the input that an error names.
  fault(field, message) {
    for (const control of this.controls) control.fault(message && control.input.key === field ? message : "");
  }
}

class Control {
  constructor(input, state) {
    this.input = input;
    this.state = state;
    this.id = `input-${input.key.replaceAll(".", "-")}`;
    this.note = element("p", { className: "fault", id: `${this.id}-fault`, hidden: true });
    this.root = element("div", { className: `control ${input.type}` });
    this.root.dataset.key = input.key;
  }

  label(target) {
    const words = element("label", { htmlFor: target, id: `${this.id}-label` }, sentence(this.input.words));
    if (this.input.symbol) words.append(" ", element("span", { className: "symbol" }, ...symbolNodes(this.input.symbol)));
    return words;
  }

  useful() {
    return true;
  }

  get current() {
    return this.state.get(this.input.key);
  }

  refresh() {
    const value = this.current;
    const key = `${value} ${JSON.stringify(unitFor(this.input, Array.isArray(value) ? value[0] : value))} ${this.available}`;
    if (key === this.seen) return;
    this.seen = key;
    this.fault("", true);
    this.update();
  }

  // A fault of what was typed here stays until another value comes.
  fault(message, typed = false) {
    if (!message && this.typedFault && !typed) return;
    this.typedFault = typed && Boolean(message);
    if ((this.message ?? "") === message) return;
    this.message = message;
    this.note.hidden = !message;
    this.note.textContent = message;
    const field = this.field ?? this.select;
    field?.setAttribute("aria-invalid", message ? "true" : "false");
    if (message) field?.setAttribute("aria-describedby", this.note.id);
    else field?.removeAttribute("aria-describedby");
  }
}

class NumberControl extends Control {
  constructor(input, state) {
    super(input, state);
    this.log = input.scale === "log";
    this.scale = SCALES[input.scale];
    this.low = this.scale.to(input.low);
    this.high = this.scale.to(input.high);
    this.slider = element("input", { type: "range", id: this.id, min: this.low, max: this.high, step: "any" });
    this.field = element("input", { type: "text", inputMode: "decimal", id: `${this.id}-number`, autocomplete: "off", spellcheck: false });
    this.field.setAttribute("aria-label", `${sentence(input.words)}, as a number`);
    this.unit = element("span", { className: "unit" });
    this.root.append(this.label(this.id), element("span", { className: "number" }, this.field, this.unit), this.slider, this.note);
    this.slider.addEventListener("input", () => this.put(this.value(Number(this.slider.value)), false));
    this.slider.addEventListener("change", () => this.state.commit());
    this.slider.addEventListener("keydown", (event) => this.key(event));
    this.field.addEventListener("change", () => this.typed());
    this.field.addEventListener("keydown", (event) => {
      if (event.key === "ArrowUp" || event.key === "ArrowDown") this.key(event);
    });
  }

  position(value) {
    return this.scale.to(this.log ? Math.max(value, this.input.low) : value);
  }

  // A position of the slider as a value of few digits; zero lies below the lowest one where it is allowed.
  value(position) {
    if (this.log && this.input.least === 0 && position < this.low - 1e-9) return 0;
    const inside = Math.min(Math.max(position, this.low), this.high);
    if (inside === this.low) return this.input.low;
    if (inside === this.high) return this.input.high;
    return this.scale.from(inside, this.input.step);
  }

  key(event) {
    const steps = { ArrowRight: 1, ArrowUp: 1, ArrowLeft: -1, ArrowDown: -1, PageUp: 10, PageDown: -10 }[event.key];
    const value = this.current;
    const now = value === 0 && this.log ? this.low - this.input.step : this.position(value);
    if (steps !== undefined) this.put(this.value(now + steps * this.input.step), false);
    else if (event.key === "Home") this.put(this.input.least === 0 ? 0 : this.input.low, false);
    else if (event.key === "End") this.put(this.input.high, false);
    else return;
    event.preventDefault();
  }

  put(value, done) {
    this.state.set({ [this.input.key]: value }, done);
  }

  // A typed number is in the unit beside it, unless it has its own; either one stays until the value changes otherwise.
  typed() {
    const found = typed(this.field.value, this.input, this.shownUnit);
    const unit = unitText(this.shownUnit.unit);
    const value = found && Number(found.value.toPrecision(12));
    const refused = found ? fault(this.input, value) : unit ? `Write a number, or a number with a unit such as ${unit}.` : "Write a number.";
    if (refused) {
      this.fault(refused, true);
      return;
    }
    this.kept = { value, unit: found.unit, system: systemName() };
    this.seen = null;
    this.put(value, true);
  }

  // Zero has no size to choose a unit by.
  unitOf(value) {
    if (this.kept?.system !== systemName()) this.kept = null;
    if (this.kept?.value === value || (this.kept && value === 0)) return this.kept.unit;
    const unit = unitFor(this.input, value);
    this.kept = { value, unit, system: systemName() };
    return unit;
  }

  update() {
    const value = this.current;
    this.shownUnit = this.unitOf(value);
    const text = editable(convert(value, this.shownUnit));
    this.slider.value = this.position(value);
    this.slider.style.setProperty("--share", `${(100 * (this.position(value) - this.low)) / (this.high - this.low)}%`);
    const unit = unitText(this.shownUnit.unit);
    this.slider.setAttribute("aria-valuetext", unit ? `${text} ${unit}` : text);
    if (document.activeElement !== this.field || Number(this.field.value) !== Number(text)) this.field.value = text;
    this.unit.textContent = unit;
  }
}

// The height from which a body falls to have the velocity of the impact: another way to set the velocity.
class HeightControl extends NumberControl {
  get current() {
    return this.state.get("impact.velocity") ** 2 / (2 * this.state.get("impact.gravity"));
  }

  put(value, done) {
    this.state.set({ "impact.velocity": Number(Math.sqrt(2 * value * this.state.get("impact.gravity")).toPrecision(12)) }, done);
  }
}

class ChoiceControl extends Control {
  constructor(input, state) {
    super(input, state);
    this.select = element("select", { id: this.id });
    this.root.append(this.label(this.id), this.select, this.note);
    this.select.addEventListener("change", () => state.set({ ...input.convert?.(this.select.value), [input.key]: this.select.value }, true));
  }

  get available() {
    return this.state.options(this.input).map((option) => option.value).join();
  }

  // A choice of one thing is none.
  useful() {
    return this.state.options(this.input).length > 1;
  }

  update() {
    const options = this.state.options(this.input);
    const names = options.map((option) => option.value).join();
    if (names !== this.names) {
      this.names = names;
      this.select.replaceChildren(...options.map((option) => element("option", { value: option.value }, option.words)));
    }
    this.select.value = this.state.get(this.input.key);
  }
}

class ListControl extends Control {
  constructor(input, state) {
    super(input, state);
    this.field = element("textarea", { id: this.id, rows: 3, spellcheck: false });
    this.root.append(this.label(this.id), this.field, this.note);
    this.field.addEventListener("change", () => this.typed());
  }

  typed() {
    const unit = this.listUnit;
    // A comma within a number may be a decimal one, which is refused.
    const values = this.field.value.split(/[,;]?\s+|;/).filter(Boolean).map((text) => back(Number(text), unit));
    const refused = fault(this.input, values);
    if (refused) this.fault(refused, true);
    else this.state.set({ [this.input.key]: values }, true);
  }

  update() {
    const values = this.state.get(this.input.key) ?? [];
    // A prefix that suits the largest number would hide the size of the smallest one.
    const sizes = values.map(Math.abs).filter(Boolean);
    const wide = sizes.length && Math.max(...sizes) > 1e3 * Math.min(...sizes);
    this.listUnit = unitFor(this.input, wide || !sizes.length ? 1 : Math.max(...sizes));
    if (document.activeElement !== this.field) this.field.value = values.map((value) => editable(convert(value, this.listUnit))).join("  ");
    const unit = unitText(this.listUnit.unit);
    this.field.setAttribute("aria-label", `${sentence(this.input.words)}, list of numbers${unit ? ` in ${unit}` : ""}`);
    this.root.querySelector("label").dataset.unit = unit ? `[${unit}]` : "";
  }
}

const editable = (value) => (Math.abs(value) >= 1e6 || (value !== 0 && Math.abs(value) < 1e-4)
  ? value.toExponential(3).replace(/\.?0+e/, "e").replace("e+", "e") : String(Number(value.toPrecision(5))));
