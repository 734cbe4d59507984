// A card with one picture: title, legend, menu to save it, and a sentence for readers of the screen; and the curves of
// several settings in it, the present one in colour, the pinned ones in grey.
import { Figure, strokeOf } from "./figure.js";
import { element } from "./elements.js";
import { node } from "./drawing.js";
import { files, menu } from "./downloads.js";
import { rangeMenu } from "./ranges.js";
import { axisLabel, convert, plainSymbol, unitFor } from "./units.js";

let count = 0;

export class Panel {
  constructor({ title, name, ...options }) {
    this.name = name;
    this.figure = new Figure({ x: { label: "" }, y: { label: "" }, ...options });
    this.heading = element("h3", { id: `panel-${count++}` }, title);
    this.legend = element("ul", { className: "legend" });
    this.note = element("p", { className: "note", hidden: true });
    this.summary = element("p", { className: "sr-only" });
    const saved = files(name, () => this.root, () => (typeof this.columns === "function" ? this.columns() : this.columns));
    this.root = element("section", { className: "card picture" },
      element("header", {}, this.heading, rangeMenu(title, this.figure), menu(title, saved)), this.legend, this.figure.root, this.note, this.summary);
    this.root.setAttribute("aria-labelledby", this.heading.id);
    this.root.dataset.panel = name;
  }

  // `columns` are those of the CSV file: [{name, unit, values}], in SI units.
  show({ columns = [], summary = "", note = "", ...picture }) {
    this.columns = columns;
    this.figure.show(picture);
    this.summary.textContent = summary;
    this.note.textContent = note;
    this.note.hidden = !note;
    // The present curves are drawn last, and named first.
    const named = picture.curves.filter((curve) => curve.label).reverse();
    const key = JSON.stringify(named.map((curve) => [curve.label, strokeOf(curve)]));
    if (key === this.key) return;
    this.key = key;
    this.legend.hidden = !named.length;
    this.legend.replaceChildren(...named.map((curve) => element("li", {}, sample(curve), curve.label)));
  }
}

function sample(curve) {
  const svg = node("svg", { viewBox: "0 0 26 8", "aria-hidden": true });
  svg.append(node("path", { d: "M1 4H25", ...strokeOf(curve) }));
  return svg;
}

const largest = (columns) => columns.flat().reduce((most, value) => Math.max(most, Math.abs(value ?? 0)), 0);

// The curves of settings in common units. `sets` holds {table, letter, dash}, the present one first; `ys` are the names
// of columns with their styles.
export function picture(sets, x, ys, outputs, axes = {}) {
  const tables = sets.filter(({ table }) => table);
  const unitOf = (names) => unitFor(outputs[names[0]], largest(tables.flatMap(({ table }) => names.map((name) => table[name] ?? []))));
  const [across, up] = [unitOf([x]), unitOf(ys.map(({ name }) => name))];
  const converted = (values, unit) => values.map((value) => (value === null ? null : convert(value, unit)));
  const labels = (name, unit, words) => ({
    unit,
    symbol: plainSymbol(outputs[name].symbol),
    label: words ? axisLabel({ symbol: "" }, unit, words) : axisLabel(outputs[name], unit), short: axisLabel(outputs[name], unit, ""),
  });
  // Of a pinned setting only the first curve is shown.
  const curves = tables.flatMap(({ table, letter, dash }) => (letter ? ys.slice(0, 1) : ys).map((style) => ({
    x: converted(table[x], across),
    y: converted(table[style.name], up),
    symbol: plainSymbol(outputs[style.name].symbol),
    ...(letter ? { colour: "pinned", dash, width: 1.6, letter }
      : { colour: "accent", width: 2.4, ...style, label: ys.length > 1 ? style.label : undefined }),
  }))).reverse();
  return {
    curves,
    across,
    up,
    x: { ...labels(x, across, axes.xWords), log: axes.xLog, room: axes.xRoom },
    y: { ...labels(ys[0].name, up, axes.words), log: axes.yLog },
    columns: tables.flatMap(({ table, letter }) => [x, ...ys.map(({ name }) => name)].map((name) => ({
      name: letter ? `${letter}: ${name}` : name, unit: outputs[name].unit, values: table[name],
    }))),
  };
}
