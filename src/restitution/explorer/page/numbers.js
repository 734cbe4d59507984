// The numbers of the present setting, and the assumptions of the theory with theirs.
import { element, sentence } from "./elements.js";
import { superscript, symbolNodes, withUnit } from "./units.js";

const STATES = { ok: ["✓", "holds"], doubtful: ["!", "doubtful"], unknown: ["?", "not checked"], note: ["i", "note"] };

// Numbers of a standard solid alone.
const WHERE_KNOWN = new Set(["p2", "p3"]);

export class Numbers {
  constructor(root, names, outputs) {
    this.outputs = outputs;
    this.tiles = new Map();
    const list = element("dl", { className: names.length <= 6 ? "tiles few" : "tiles" });
    for (const name of names) {
      const value = element("dd");
      value.dataset.output = name;
      const { words, symbol } = outputs[name] ?? { words: name };
      const tile = element("div", { className: "tile" },
        element("dt", {}, `${sentence(words)} `, ...(symbol ? symbolNodes(symbol) : [])), value);
      this.tiles.set(name, { tile, value });
      list.append(tile);
    }
    root.append(list);
  }

  show(numbers) {
    for (const [name, { tile, value }] of this.tiles) {
      const found = numbers[name];
      tile.hidden = found === undefined || (found === null && WHERE_KNOWN.has(name));
      if (tile.hidden) continue;
      const { text, unit } = withUnit(found, this.outputs[name] ?? { unit: "" });
      if (value.dataset.value === String(found ?? "") && value.shown === text + unit) continue;
      value.dataset.value = found ?? "";
      value.shown = text + unit;
      value.replaceChildren(text, ...(unit ? [element("span", { className: "unit" }, ` ${unit}`)] : []));
    }
  }
}

export class Assumptions {
  constructor(root) {
    this.summary = element("summary");
    this.list = element("ul", { className: "assumptions" });
    this.box = element("details", { className: "card checks" }, this.summary, this.list);
    this.box.open = true;
    root.append(this.box);
  }

  show(validity, notes = []) {
    const doubtful = validity.filter((one) => one.state === "doubtful").length;
    const words = doubtful ? `${doubtful} of the assumptions ${doubtful === 1 ? "is" : "are"} doubtful` : "No assumption is doubtful";
    if (this.summary.textContent !== words) this.summary.textContent = words;
    this.box.dataset.state = doubtful ? "doubtful" : "ok";
    const key = JSON.stringify([validity, notes]);
    if (key === this.key) return;
    this.key = key;
    this.list.replaceChildren(
      ...validity.map((one) => row(one.state, withTitle(one), one.state === "doubtful" ? one.advice : "", one.kind)),
      ...notes.map((note) => row("note", note)));
  }
}

// Doubts and notes of a tab that has no list of all assumptions, in the same form.
export class Notes {
  constructor(root) {
    this.box = element("ul", { className: "card notes assumptions" });
    root.append(this.box);
  }

  show(warnings, notes) {
    const rows = [...warnings.map((one) => row("doubtful", one)), ...notes.filter(Boolean).map((one) => row("note", one))];
    this.box.replaceChildren(...rows);
    this.box.hidden = !rows.length;
  }
}

const withTitle = ({ title, message }) => (message.startsWith(title) ? message : `${title}: ${message}`);

// Powers of ten and cubic metres of a message, as they are printed.
const printed = (text) => text.replace(/e([+-]\d+)/g, (_, power) => `·10${superscript(Number(power))}`).replaceAll("kg/m3", "kg/m³");

function row(state, message, advice = "", kind = "") {
  const [sign, words] = STATES[state] ?? STATES.unknown;
  const mark = element("span", { className: `sign ${state}` }, sign);
  mark.setAttribute("role", "img");
  mark.setAttribute("aria-label", words);
  const item = element("li", {}, mark, element("span", {}, printed(sentence(message)), ...(advice ? [". ", element("em", {}, advice)] : [])));
  if (kind) item.dataset.check = kind;
  return item;
}
