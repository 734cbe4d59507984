// The controls, made from the schema: a slider and a number for each quantity, a list of choices, a list of numbers.
import { convert, back, phrase, symbolNodes, unitFor, unitText } from "./units.js";

const CASE = ["material", "body", "impact"];
const GROUPS = { impact: CASE, paper: CASE, bounce: [...CASE, "bounces"], indentation: ["material", "indentation"] };

export class Inputs {
  constructor(schema, state, root) {
    this.state = state;
    this.root = root;
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
      }
      this.groups.push(box);
      root.append(box);
    }
    state.onChange(() => this.update());
    this.update();
  }

  update() {
    const tab = this.state.get("page.tab");
    const groups = Object.hasOwn(GROUPS, tab) ? GROUPS[tab] : CASE;
    const belongs = (input) => groups.includes(input.group) || (tab === "indentation" && input.key.startsWith("profile."));
    // What stays as it is is left alone: a frame of the browser costs more than a solve.
    for (const control of this.controls) {
      const hidden = !(belongs(control.input) && this.state.shown(control.input) && control.useful());
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

  refresh() {
    const value = this.state.get(this.input.key);
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
    this.low = this.log ? Math.log10(input.low) : input.low;
    this.high = this.log ? Math.log10(input.high) : input.high;
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
    return this.log ? Math.log10(Math.max(value, this.input.low)) : value;
  }

  // A position of the slider as a value of few digits; zero lies below the lowest one where it is allowed.
  value(position) {
    if (this.log && this.input.least === 0 && position < this.low - 1e-9) return 0;
    const inside = Math.min(Math.max(position, this.low), this.high);
    if (inside === this.low) return this.input.low;
    if (inside === this.high) return this.input.high;
    if (this.log) return Number(Math.pow(10, inside).toPrecision(4));
    return Number((Math.round(inside / this.input.step) * this.input.step).toPrecision(10));
  }

  key(event) {
    const steps = { ArrowRight: 1, ArrowUp: 1, ArrowLeft: -1, ArrowDown: -1, PageUp: 10, PageDown: -10 }[event.key];
    const value = this.state.get(this.input.key);
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

  // A typed number is in the unit beside it, which stays the same while it is typed.
  typed() {
    const value = back(Number(this.field.value.trim().replace("−", "-").replace(",", ".")), this.shownUnit);
    const { least = -Infinity, most = Infinity } = this.input;
    if (this.field.value.trim() === "" || !Number.isFinite(value)) this.fault("Write a number.", true);
    else if (value < least || value > most) {
      this.fault(`Must be from ${phrase(least, this.input)} to ${phrase(most, this.input)}.`, true);
    } else this.put(Number(value.toPrecision(12)), true);
  }

  update() {
    const value = this.state.get(this.input.key);
    this.shownUnit = unitFor(this.input, value);
    const text = editable(convert(value, this.shownUnit));
    this.slider.value = this.position(value);
    this.slider.style.setProperty("--share", `${(100 * (this.position(value) - this.low)) / (this.high - this.low)}%`);
    const unit = unitText(this.shownUnit.unit);
    this.slider.setAttribute("aria-valuetext", unit ? `${text} ${unit}` : text);
    if (document.activeElement !== this.field || Number(this.field.value) !== Number(text)) this.field.value = text;
    this.unit.textContent = unit;
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
    if (values.some((value) => !Number.isFinite(value))) this.fault("Write numbers with spaces between them.", true);
    else this.state.set({ [this.input.key]: values }, true);
  }

  update() {
    const values = this.state.get(this.input.key) ?? [];
    this.listUnit = unitFor(this.input, Math.max(0, ...values.map(Math.abs)));
    if (document.activeElement !== this.field) this.field.value = values.map((value) => editable(convert(value, this.listUnit))).join("  ");
    const unit = unitText(this.listUnit.unit);
    this.field.setAttribute("aria-label", `${sentence(this.input.words)}, list of numbers${unit ? ` in ${unit}` : ""}`);
    this.root.querySelector("label").dataset.unit = unit ? `[${unit}]` : "";
  }
}

const editable = (value) => (Math.abs(value) >= 1e6 || (value !== 0 && Math.abs(value) < 1e-4)
  ? value.toExponential(3).replace(/\.?0+e/, "e").replace("e+", "e") : String(Number(value.toPrecision(5))));

export const sentence = (words) => words.charAt(0).toUpperCase() + words.slice(1);

export function element(name, properties = {}, ...children) {
  const node = Object.assign(document.createElement(name), properties);
  node.append(...children);
  return node;
}
