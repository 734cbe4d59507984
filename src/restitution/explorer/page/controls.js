// The controls of the inputs: a slider and a number for each quantity, a list of choices, a list of numbers.
import { element, sentence } from "./elements.js";
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
    Object.assign(this, { state, tab });
    const make = { number: NumberControl, choice: ChoiceControl, list: ListControl };
    this.groups = schema.groups.map(({ name, words }) => {
      const controls = schema.inputs.filter((input) => input.group === name).flatMap((input) => {
        const control = new make[input.type](input, state);
        return input.key === "impact.gravity" ? [control, new HeightControl(schema.drop_height, state)] : [control];
      });
      const box = element("fieldset", { className: "group" }, element("legend", {}, words), ...controls.map(({ root }) => root));
      return { box, controls };
    }).filter(({ controls }) => controls.length);
    root.append(...this.groups.map(({ box }) => box));
    state.onChange(() => this.update());
    this.update();
  }

  update() {
    const tab = this.tab();
    // What stays as it is is left alone: a frame of the browser costs more than a solve.
    const hide = (node, hidden) => hidden !== node.hidden && Object.assign(node, { hidden });
    for (const { box, controls } of this.groups) {
      for (const control of controls) {
        hide(control.root, !(control.input.tabs.includes(tab) && this.state.shown(control.input) && control.useful()));
        if (!control.root.hidden) control.refresh();
      }
      hide(box, controls.every(({ root }) => root.hidden));
    }
  }

  // Marks the input that an error names.
  fault(field, message) {
    for (const { controls } of this.groups) {
      for (const control of controls) control.fault(control.input.key === field ? message : "");
    }
  }
}

class Control {
  // `field` is where a value is typed or chosen.
  constructor(input, state, field) {
    Object.assign(this, { input, state, field });
    this.id = `input-${input.key.replaceAll(".", "-")}`;
    this.note = element("p", { className: "fault", id: `${this.id}-fault`, hidden: true });
    field.setAttribute("aria-describedby", this.note.id);
    this.root = element("div", { className: `control ${input.type}` });
    this.root.dataset.key = input.key;
  }

  get label() {
    const words = element("label", { htmlFor: this.id, id: `${this.id}-label` }, sentence(this.input.words));
    if (this.input.symbol) words.append(" ", element("span", { className: "symbol" }, ...symbolNodes(this.input.symbol)));
    return words;
  }

  useful() {
    return true;
  }

  get current() {
    return this.state.get(this.input.key);
  }

  put(value, done) {
    this.state.set({ [this.input.key]: value }, done);
  }

  refresh() {
    const value = this.current;
    const key = `${value} ${JSON.stringify(unitFor(this.input, Array.isArray(value) ? value[0] : value))} ${this.available}`;
    if (key === this.seen) return;
    this.seen = key;
    this.fault("", true);
    this.update();
  }

  // What was typed here and cannot be read stays named until another value comes.
  fault(message, unread = false) {
    if (!message && this.unread && !unread) return;
    this.unread = unread && Boolean(message);
    if (this.note.textContent === message) return;
    this.note.hidden = !message;
    this.note.textContent = message;
    this.field.ariaInvalid = String(Boolean(message));
  }
}

class NumberControl extends Control {
  constructor(input, state) {
    super(input, state, element("input", { type: "text", inputMode: "decimal", autocomplete: "off", spellcheck: false }));
    this.log = input.scale === "log";
    this.scale = SCALES[input.scale];
    this.low = this.scale.to(input.low);
    this.high = this.scale.to(input.high);
    this.slider = element("input", { type: "range", id: this.id, min: this.low, max: this.high, step: "any" });
    this.field.id = `${this.id}-number`;
    this.field.ariaLabel = `${sentence(input.words)}, as a number`;
    this.unit = element("span", { className: "unit" });
    this.root.append(this.label, element("span", { className: "number" }, this.field, this.unit), this.slider, this.note);
    this.slider.addEventListener("input", () => this.put(this.value(Number(this.slider.value)), false));
    this.slider.addEventListener("change", () => this.state.commit());
    this.slider.addEventListener("keydown", (event) => this.key(event));
    this.field.addEventListener("change", () => this.read());
    this.field.addEventListener("keydown", (event) => ["ArrowUp", "ArrowDown"].includes(event.key) && this.key(event));
  }

  position(value) {
    return this.scale.to(this.log ? Math.max(value, this.input.low) : value);
  }

  // A position of the slider as a value of few digits; zero lies below the lowest one where it is allowed.
  value(position) {
    if (this.log && this.input.least === 0 && position < this.low - 1e-9) return 0;
    if (position <= this.low) return this.input.low;
    return position >= this.high ? this.input.high : this.scale.from(position, this.input.step);
  }

  key(event) {
    const steps = { ArrowRight: 1, ArrowUp: 1, ArrowLeft: -1, ArrowDown: -1, PageUp: 10, PageDown: -10, Home: -Infinity, End: Infinity }[event.key];
    if (steps === undefined) return;
    const place = this.current === 0 && this.log ? this.low - this.input.step : this.position(this.current);
    this.put(this.value(place + steps * this.input.step), false);
    event.preventDefault();
  }

  // A typed number is in the unit beside it, unless it has its own; either one stays until the value changes otherwise.
  read() {
    const number = typed(this.field.value, this.input, this.shownUnit);
    if (!number) {
      const unit = unitText(this.shownUnit.unit);
      this.fault(unit ? `Write a number, or a number with a unit such as ${unit}.` : "Write a number.", true);
      return;
    }
    const value = Number(number.value.toPrecision(12));
    this.kept = { value, unit: number.unit, system: systemName() };
    this.seen = null;
    this.put(value, true);
  }

  // Zero has no size to choose a unit by.
  unitOf(value) {
    const kept = this.kept?.system === systemName() ? this.kept : null;
    if (kept && (kept.value === value || value === 0)) return kept.unit;
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

// The height from which a body falls to have the velocity of the impact: another way to set the velocity. One below
// zero becomes a velocity below zero, which the server refuses.
class HeightControl extends NumberControl {
  get current() {
    return this.state.get("impact.velocity") ** 2 / (2 * this.state.get("impact.gravity"));
  }

  put(value, done) {
    const speed = Math.sqrt(2 * Math.abs(value) * this.state.get("impact.gravity"));
    this.state.set({ "impact.velocity": Math.sign(value) * Number(speed.toPrecision(12)) }, done);
  }
}

class ChoiceControl extends Control {
  constructor(input, state) {
    super(input, state, element("select"));
    this.field.id = this.id;
    this.root.append(this.label, this.field, this.note);
    this.field.addEventListener("change", () => state.set({ ...input.convert?.(this.field.value), [input.key]: this.field.value }, true));
  }

  get available() {
    return this.state.options(this.input).map((option) => option.value).join();
  }

  // A choice of one thing is none.
  useful() {
    return this.state.options(this.input).length > 1;
  }

  update() {
    const { available } = this;
    if (available !== this.names) {
      this.names = available;
      this.field.replaceChildren(...this.state.options(this.input).map(({ value, words }) => element("option", { value }, words)));
    }
    this.field.value = this.current;
  }
}

class ListControl extends Control {
  constructor(input, state) {
    super(input, state, element("textarea", { rows: 3, spellcheck: false }));
    this.field.id = this.id;
    this.root.append(this.label, this.field, this.note);
    this.field.addEventListener("change", () => this.read());
  }

  read() {
    // A comma within a number may be a decimal one, which is refused.
    const values = this.field.value.split(/[,;]?\s+|;/).filter(Boolean).map((text) => back(Number(text), this.listUnit));
    if (values.every(Number.isFinite)) this.put(values, true);
    else this.fault("Write numbers with spaces between them.", true);
  }

  update() {
    const values = this.current ?? [];
    // A prefix that suits the largest number would hide the size of the smallest one.
    const sizes = values.map(Math.abs).filter(Boolean);
    const wide = sizes.length && Math.max(...sizes) > 1e3 * Math.min(...sizes);
    this.listUnit = unitFor(this.input, wide || !sizes.length ? 1 : Math.max(...sizes));
    if (document.activeElement !== this.field) this.field.value = values.map((value) => editable(convert(value, this.listUnit))).join("  ");
    const unit = unitText(this.listUnit.unit);
    this.field.ariaLabel = `${sentence(this.input.words)}, list of numbers${unit ? ` in ${unit}` : ""}`;
    this.root.querySelector("label").dataset.unit = unit ? `[${unit}]` : "";
  }
}

const editable = (value) => (Math.abs(value) >= 1e6 || (value !== 0 && Math.abs(value) < 1e-4)
  ? value.toExponential(3).replace(/\.?0+e/, "e").replace("e+", "e") : String(Number(value.toPrecision(5))));
