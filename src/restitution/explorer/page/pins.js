// Up to four pinned settings. Their curves stay in grey, with a letter; a table compares their numbers.
import { element, sentence } from "./elements.js";
import { phrase, symbolNodes } from "./units.js";

const LETTERS = ["A", "B", "C", "D"];
const DASHES = ["dashed", "dotted", "dashdot", "solid"];
const COMPARED = {
  impact: ["restitution_coefficient", "contact_time", "max_force", "max_indentation_depth", "max_contact_radius", "instantaneous_poisson_ratio"],
  bounces: ["n_bounces", "drop_height", "total_time"],
  indentation: ["max_force", "max_indentation_depth", "max_contact_radius", "contact_end_time", "work"],
};

export class Pins {
  // ask(kind, values, channel) asks for the answer of a pinned setting.
  constructor(root, state, outputs, ask) {
    Object.assign(this, { root, state, outputs, ask });
    this.pins = [];
    this.button = element("button", { type: "button", className: "pin" }, "Pin this setting");
    this.button.addEventListener("click", () => this.add());
    state.onChange(() => this.read());
    this.read();
  }

  links() {
    return (this.state.get("page.pins") ?? "").split("|").filter(Boolean).slice(0, LETTERS.length);
  }

  // The pins are a part of the address; those that stay keep their answers.
  read() {
    const links = this.links();
    this.button.disabled = links.length >= LETTERS.length;
    if (links.join() === this.pins.map((pin) => pin.link).join()) return;
    const before = this.pins;
    this.pins = links.map((link, n) => {
      const kept = before.find((pin) => pin.link === link);
      return { link, letter: LETTERS[n], dash: DASHES[n], values: kept?.values ?? this.state.read(`#${link}`), answers: kept?.answers ?? {} };
    });
  }

  add() {
    const { "page.pins": pins, ...values } = this.state.values;
    const link = this.state.link(values).slice(1);
    if (this.links().includes(link)) return;
    this.state.set({ "page.pins": [...this.links(), link].join("|") }, true);
  }

  remove(pin) {
    this.state.set({ "page.pins": this.links().filter((link) => link !== pin.link).join("|") }, true);
  }

  // The answers of this kind that are there; those that are missing are asked for.
  of(kind) {
    for (const pin of this.pins) {
      if (pin.answers[kind] === undefined) {
        pin.answers[kind] = null;
        this.ask(kind, pin.values, pin.link);
      }
    }
    return this.pins.filter((pin) => pin.answers[kind]?.ok).map((pin) => ({ answer: pin.answers[kind], letter: pin.letter, dash: pin.dash }));
  }

  receive(answer, channel) {
    const pin = this.pins.find((one) => one.link === channel);
    if (pin) pin.answers[answer.kind] = answer;
    return Boolean(pin);
  }

  // The numbers of the answers of this kind; `present` is null where none is there.
  table(kind, present) {
    this.root.hidden = !this.pins.length || !present;
    if (this.root.hidden) return;
    const compared = COMPARED[kind];
    this.of(kind);
    const differing = this.state.inputs.list.filter((input) => input.type !== "list" && this.pins.some((pin) =>
      pin.values[input.key] !== this.state.get(input.key)));
    const cell = (name, text, properties = {}) => element(name, properties, text);
    const head = element("tr", {}, cell("th", "Setting", { scope: "col" }),
      ...compared.map((name) => element("th", { scope: "col", title: this.outputs[name].words }, ...symbolNodes(this.outputs[name].symbol))),
      ...differing.map((input) => cell("th", sentence(input.words), { scope: "col" })), cell("th", "", { className: "actions" }));
    head.lastChild.append(element("span", { className: "sr-only" }, "Actions"));
    const row = (letter, numbers, values, pin) => {
      const made = element("tr", {}, cell("th", letter, { scope: "row" }),
        ...compared.map((name) => cell("td", numbers === undefined ? "…" : phrase(numbers?.[name], this.outputs[name] ?? {}))),
        ...differing.map((input) => cell("td", input.type === "choice"
          ? input.options.find((option) => option.value === values[input.key])?.words ?? "" : phrase(values[input.key], input))));
      const actions = element("td", { className: "actions" });
      if (pin) {
        const go = element("button", { type: "button" }, "Go to it");
        go.setAttribute("aria-label", `Go to setting ${letter}`);
        go.addEventListener("click", () => this.state.set({ ...this.state.case(pin.values) }, true));
        const drop = element("button", { type: "button" }, "Remove");
        drop.setAttribute("aria-label", `Remove setting ${letter}`);
        drop.addEventListener("click", () => this.remove(pin));
        actions.append(go, " ", drop);
      }
      made.append(actions);
      return made;
    };
    const body = element("tbody", {}, row("Present", present, this.state.values),
      ...this.pins.map((pin) => row(pin.letter, pin.answers[kind] ? pin.answers[kind].numbers ?? null : undefined, pin.values, pin)));
    const table = element("table", {}, element("caption", {}, "Compared settings"), element("thead", {}, head), body);
    const box = element("div", { className: "scroll", tabIndex: 0 }, table);
    box.setAttribute("role", "region");
    box.setAttribute("aria-label", "Compared settings");
    const focused = this.root.contains(document.activeElement) ? document.activeElement.getAttribute("aria-label") : null;
    this.root.replaceChildren(box);
    if (focused) this.root.querySelector(`[aria-label="${focused}"]`)?.focus();
  }
}
