// A card with one picture: title, legend, menu to save it, and a sentence for readers of the screen.
import { Figure, strokeOf } from "./figure.js";
import { element } from "./elements.js";
import { node } from "./drawing.js";
import { files, menu } from "./downloads.js";

let number = 0;

export class Panel {
  constructor({ title, name, ...options }) {
    number += 1;
    this.name = name;
    this.title = title;
    this.figure = new Figure({ x: { label: "" }, y: { label: "" }, ...options });
    this.heading = element("h3", { id: `panel-${number}` }, title);
    this.legend = element("ul", { className: "legend" });
    this.note = element("p", { className: "note", hidden: true });
    this.summary = element("p", { className: "sr-only" });
    this.root = element("section", { className: "card picture" },
      element("header", {}, this.heading, menu(title, files(name, () => this.root, () => (typeof this.columns === "function" ? this.columns() : this.columns)))), this.legend, this.figure.root, this.note, this.summary);
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
    this.draw(picture.curves);
  }

  draw(curves) {
    // The present curves are drawn last, and named first.
    const named = curves.filter((curve) => curve.label).reverse();
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
