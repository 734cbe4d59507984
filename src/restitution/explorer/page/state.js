// The state: one flat object of inputs. The address of the page holds it, so that a link is a case.
import { ofTab } from "./storage.js";

const PAUSE = 350;

export class State {
  // `given` is the case of the command line.
  constructor(inputs, given = {}) {
    Object.assign(this, { inputs, given });
    this.defaults = inputs.defaults;
    this.listeners = [];
    this.values = this.read(location.hash);
    // A page that is opened anew has no steps after it.
    this.index = history.state?.index ?? 0;
    this.last = history.state ? Math.max(this.index, Number(ofTab.getItem("last") ?? 0)) : 0;
    history.replaceState({ index: this.index }, "", this.link());
    addEventListener("popstate", () => this.moved());
    addEventListener("hashchange", () => this.moved());
  }

  // An address without a state is the case that was given. What cannot be read stands in `ignored`.
  read(hash) {
    const given = [...new URLSearchParams(hash.replace(/^#/, ""))];
    const values = { ...this.defaults, ...(given.length ? {} : this.given) };
    this.ignored = [];
    for (const [key, text] of given) {
      const value = key.startsWith("page.") ? text : this.inputs.read(key, text);
      if (value !== undefined) values[key] = value;
      else this.ignored.push(`${key}=${text}`.slice(0, 100));
    }
    return this.inputs.settled(values);
  }

  link(values = this.values) {
    const parts = new URLSearchParams();
    parts.set("page.tab", values["page.tab"] ?? "impact");
    for (const [key, value] of Object.entries(values)) {
      if (key === "page.tab" || value === undefined || value === null || String(value) === String(this.defaults[key] ?? "")) continue;
      parts.set(key, Array.isArray(value) ? value.join(",") : value);
    }
    return `#${parts}`;
  }

  options(input) {
    return this.inputs.options(input, this.values);
  }

  shown(input) {
    return this.inputs.shown(input, this.values);
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
    if (Object.entries(patch).every(([key, value]) => String(this.values[key] ?? "") === String(value ?? ""))) {
      if (done) this.commit();
      return;
    }
    this.values = this.inputs.settled({ ...this.values, ...patch });
    this.notify();
    clearTimeout(this.timer);
    if (done) this.commit();
    else this.timer = setTimeout(() => this.commit(), PAUSE);
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
    this.values = this.read(location.hash);
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
