// The numbers of the present setting, and the assumptions of the theory with theirs.
import { element, sentence } from "./elements.js";
import { superscript, symbolNodes, withUnit } from "./units.js";

const STATES = { ok: ["✓", "holds"], doubtful: ["!", "doubtful"], unknown: ["?", "not checked"], note: ["i", "note"] };

// Numbers of a standard solid alone.
const OF_SOLID = new Set(["p2", "p3"]);

export class Numbers {
  constructor(root, names, outputs) {
    this.tiles = names.map((name) => {
      const quantity = outputs[name];
      const value = element("dd");
      value.dataset.output = name;
      const tile = element("div", { className: "tile" },
        element("dt", {}, `${sentence(quantity.words)} `, ...(quantity.symbol ? symbolNodes(quantity.symbol) : [])), value);
      return { name, quantity, tile, value };
    });
    root.append(element("dl", { className: names.length <= 6 ? "tiles few" : "tiles" }, ...this.tiles.map(({ tile }) => tile)));
  }

  show(numbers) {
    for (const { name, quantity, tile, value } of this.tiles) {
      const number = numbers[name];
      tile.hidden = number === undefined || (number === null && OF_SOLID.has(name));
      if (tile.hidden) continue;
      const { text, unit } = withUnit(number, quantity);
      if (value.dataset.value === String(number ?? "") && value.shown === text + unit) continue;
      value.dataset.value = number ?? "";
      value.shown = text + unit;
      value.replaceChildren(text, ...(unit ? [element("span", { className: "unit" }, ` ${unit}`)] : []));
    }
  }
}

export class Assumptions {
  constructor(root) {
    this.summary = element("summary");
    this.list = element("ul", { className: "assumptions" });
    this.box = element("details", { className: "card checks", open: true }, this.summary, this.list);
    root.append(this.box);
  }

  show(validity, notes = []) {
    const key = JSON.stringify([validity, notes]);
    if (key === this.key) return;
    this.key = key;
    const count = validity.filter(({ state }) => state === "doubtful").length;
    this.summary.textContent = count ? `${count} of the assumptions ${count === 1 ? "is" : "are"} doubtful` : "No assumption is doubtful";
    this.box.dataset.state = count ? "doubtful" : "ok";
    this.list.replaceChildren(
      ...validity.map(({ state, title, message, advice, kind }) =>
        row(state, message.startsWith(title) ? message : `${title}: ${message}`, state === "doubtful" ? advice : "", kind)),
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
    const rows = [...warnings.map((words) => row("doubtful", words)), ...notes.filter(Boolean).map((words) => row("note", words))];
    this.box.replaceChildren(...rows);
    this.box.hidden = !rows.length;
  }
}

// Powers of ten and cubic metres of a message, as they are printed.
const printed = (text) => text.replace(/e([+-]\d+)/g, (_, power) => `·10${superscript(Number(power))}`).replaceAll("kg/m^3", "kg/m³");

function row(state, message, advice = "", kind = "") {
  const [sign, words] = STATES[state];
  const mark = element("span", { className: `sign ${state}`, role: "img", ariaLabel: words }, sign);
  const item = element("li", {}, mark, element("span", {}, printed(sentence(message)), ...(advice ? [". ", element("em", {}, advice)] : [])));
  if (kind) item.dataset.check = kind;
  return item;
}
