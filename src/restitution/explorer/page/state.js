// The inputs as the server states them, and the state: one flat object of their values. The address of the page holds
// it, so that a link is a case. The page finds out which inputs and options are there; the server alone checks values.
import { ofTab } from "./elements.js";

const PAUSE = 350;

const holds = (when, values) => Object.entries(when ?? {}).every(([key, choices]) => choices.includes(values[key]));

export class State {
  // `start` is the case of the command line.
  constructor(inputs, start = {}) {
    Object.assign(this, { inputs, start });
    this.byKey = new Map(inputs.map((input) => [input.key, input]));
    this.defaults = Object.fromEntries(inputs.map((input) => [input.key, input.default]));
    this.listeners = [];
    this.open();
    // A page that is opened anew has no steps after it.
    this.index = history.state?.index ?? 0;
    this.last = history.state ? Math.max(this.index, Number(ofTab.getItem("last") ?? 0)) : 0;
    history.replaceState({ index: this.index }, "", this.link());
    addEventListener("popstate", () => this.moved());
    addEventListener("hashchange", () => this.moved());
  }

  options(input, values = this.values) {
    return input.options.filter((option) => holds(option.when, values));
  }

  shown(input, values = this.values) {
    return holds(input.when, values);
  }

  // A choice whose option is not available takes the first that is.
  settled(values) {
    const settled = { ...values };
    for (const input of this.inputs.filter(({ type }) => type === "choice")) {
      settled[input.key] = String(settled[input.key]);
      const free = this.options(input, settled);
      if (free.length && !free.some(({ value }) => value === settled[input.key])) settled[input.key] = free[0].value;
    }
    return settled;
  }

  // The values of the address; what cannot be read stands in `ignored`.
  open() {
    this.ignored = [];
    this.values = this.read(location.hash, this.ignored);
  }

  // An address without a state is the case of the start.
  read(hash, ignored = []) {
    const parts = [...new URLSearchParams(hash.replace(/^#/, ""))];
    const values = { ...this.defaults, ...(parts.length ? {} : this.start) };
    for (const [key, text] of parts) {
      const value = key.startsWith("page.") ? text : this.valueOf(this.byKey.get(key), text);
      if (value !== undefined) values[key] = value;
      else ignored.push(`${key}=${text}`.slice(0, 100));
    }
    return this.settled(values);
  }

  // A text as the value of an input; undefined if it is none.
  valueOf(input, text) {
    if (input?.type === "choice") return input.options.find(({ value }) => value === text)?.value;
    const number = (part) => (part.trim() ? Number(part) : NaN);
    const value = input?.type !== "list" ? number(text) : text ? text.split(",").map(number) : [];
    return input && [value].flat().every(Number.isFinite) ? value : undefined;
  }

  link(values = this.values) {
    const parts = new URLSearchParams({ "page.tab": values["page.tab"] ?? "impact" });
    for (const [key, value] of Object.entries(values)) {
      // A list has its numbers with commas between them.
      if (key !== "page.tab" && String(value ?? "") !== String(this.defaults[key] ?? "")) parts.set(key, value);
    }
    return `#${parts}`;
  }

  get(key) {
    return this.values[key];
  }

  // What the server takes: everything but the page's own keys.
  case(values = this.values) {
    return Object.fromEntries(Object.entries(values).filter(([key]) => !key.startsWith("page.")));
  }

  // `done` ends a step of undo at once; otherwise a pause ends it.
  set(patch, done = false) {
    const same = Object.entries(patch).every(([key, value]) => String(this.values[key] ?? "") === String(value ?? ""));
    if (!same) {
      this.values = this.settled({ ...this.values, ...patch });
      this.notify();
      clearTimeout(this.timer);
    }
    if (done) this.commit();
    else if (!same) this.timer = setTimeout(() => this.commit(), PAUSE);
  }

  commit() {
    clearTimeout(this.timer);
    const link = this.link();
    if (link === location.hash) return;
    this.step();
    history.pushState({ index: this.index }, "", link);
    this.notify();
  }

  step() {
    this.index += 1;
    this.last = this.index;
    ofTab.setItem("last", this.last);
  }

  // To another entry of the history, or to an address that was typed, which is a new one.
  moved() {
    clearTimeout(this.timer);
    if (history.state) this.index = history.state.index;
    else {
      this.step();
      history.replaceState({ index: this.index }, "");
    }
    this.open();
    this.notify();
  }

  get canUndo() {
    return this.index > 0;
  }

  get canRedo() {
    return this.index < this.last;
  }

  undo() {
    this.commit();
    if (this.canUndo) history.back();
  }

  redo() {
    if (this.canRedo) history.forward();
  }

  onChange(listener) {
    this.listeners.push(listener);
  }

  notify() {
    for (const listener of this.listeners) listener(this);
  }
}
