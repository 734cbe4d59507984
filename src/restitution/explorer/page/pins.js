// Up to four pinned settings. Their curves stay in grey, with a letter; a table compares their numbers.
import { button, element, sentence } from "./elements.js";
import { phrase, symbolNodes } from "./units.js";

const LETTERS = ["A", "B", "C", "D"];
const DASHES = ["dashed", "dotted", "dashdot", "solid"];
const COMPARED = {
  impact: ["restitution_coefficient", "contact_time", "max_force", "max_indentation_depth", "max_contact_radius", "instantaneous_poisson_ratio"],
  bounces: ["n_bounces", "drop_height", "total_time"],
  indentation: ["max_force", "max_indentation_depth", "max_contact_radius", "contact_end_time", "work"],
  tapping: ["amplitude", "phase", "max_force", "loss_per_tap"],
};

export class Pins {
  // ask(kind, values, channel) asks for the answer of a pinned setting.
  constructor(root, state, outputs, ask) {
    Object.assign(this, { root, state, outputs, ask });
    this.pins = [];
    this.button = button("Pin this setting", () => this.add(), { className: "pin" });
    state.onChange(() => this.read());
    this.read();
  }

  get links() {
    return (this.state.get("page.pins") ?? "").split("|").filter(Boolean).slice(0, LETTERS.length);
  }

  set links(links) {
    this.state.set({ "page.pins": links.join("|") }, true);
  }

  // The pins are a part of the address; those that stay keep their answers.
  read() {
    const { links, pins } = this;
    this.button.disabled = links.length >= LETTERS.length;
    if (links.join() === pins.map((pin) => pin.link).join()) return;
    this.pins = links.map((link, n) => {
      const { values, answers } = pins.find((pin) => pin.link === link) ?? { values: this.state.read(`#${link}`), answers: {} };
      return { link, letter: LETTERS[n], dash: DASHES[n], values, answers };
    });
  }

  add() {
    const { "page.pins": pins, "page.points": points, ...values } = this.state.values;
    const link = this.state.link(values).slice(1);
    if (!this.links.includes(link)) this.links = [...this.links, link];
  }

  // The answers of this kind that are there; those that are missing are asked for.
  of(kind) {
    for (const pin of this.pins) {
      if (pin.answers[kind] === undefined) {
        pin.answers[kind] = null;
        this.ask(kind, pin.values, pin.link);
      }
    }
    return this.pins.filter((pin) => pin.answers[kind]?.ok).map(({ answers, letter, dash }) => ({ answer: answers[kind], letter, dash }));
  }

  receive(answer, channel) {
    const pin = this.pins.find(({ link }) => link === channel);
    if (pin) pin.answers[answer.kind] = answer;
    return Boolean(pin);
  }

  // The numbers of the answers of this kind; `present` is null where none is there.
  table(kind, present) {
    this.root.hidden = !this.pins.length || !present;
    if (this.root.hidden) return;
    this.of(kind);
    const { state, outputs } = this;
    const names = COMPARED[kind];
    const differing = state.inputs.filter(({ key, type }) => type !== "list" && this.pins.some((pin) => pin.values[key] !== state.get(key)));
    const column = (properties, ...words) => element("th", { scope: "col", ...properties }, ...words);
    const head = element("tr", {}, column({}, "Setting"),
      ...names.map((name) => column({ title: outputs[name].words }, ...symbolNodes(outputs[name].symbol))),
      ...differing.map((input) => column({}, sentence(input.words))),
      element("th", { className: "actions" }, element("span", { className: "sr-only" }, "Actions")));
    const shown = (input, value) => (input.type === "choice" ? input.options.find((option) => option.value === value)?.words ?? "" : phrase(value, input));
    const row = (letter, numbers, values, ...actions) => element("tr", {}, element("th", { scope: "row" }, letter),
      ...names.map((name) => element("td", {}, numbers === undefined ? "…" : phrase(numbers?.[name], outputs[name] ?? {}))),
      ...differing.map((input) => element("td", {}, shown(input, values[input.key]))),
      element("td", { className: "actions" }, ...actions));
    const rows = this.pins.map(({ link, letter, values, answers }) =>
      row(letter, answers[kind] ? answers[kind].numbers ?? null : undefined, values,
        button("Go to it", () => state.set(state.case(values), true), { ariaLabel: `Go to setting ${letter}` }), " ",
        button("Remove", () => { this.links = this.links.filter((other) => other !== link); }, { ariaLabel: `Remove setting ${letter}` })));
    const table = element("table", {}, element("caption", {}, "Compared settings"), element("thead", {}, head),
      element("tbody", {}, row("Present", present, state.values), ...rows));
    const box = element("div", { className: "scroll", tabIndex: 0, role: "region", ariaLabel: "Compared settings" }, table);
    const focused = this.root.contains(document.activeElement) ? document.activeElement.ariaLabel : null;
    this.root.replaceChildren(box);
    if (focused) this.root.querySelector(`[aria-label="${focused}"]`)?.focus();
  }
}
