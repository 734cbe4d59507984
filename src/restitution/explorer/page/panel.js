// A card with one picture: title, legend, menu to save it, and a sentence for readers of the screen.
import { dashOf, Figure } from "./figure.js";
import { element } from "./inputs.js";
import { saveMenu } from "./save.js";

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
      element("header", {}, this.heading, saveMenu(this)), this.legend, this.figure.root, this.note, this.summary);
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
    const key = named.map((curve) => [curve.label, curve.colour, curve.dash, curve.letter].join()).join("|");
    if (key === this.key) return;
    this.key = key;
    this.legend.hidden = !named.length;
    this.legend.replaceChildren(...named.map((curve) => element("li", {}, sample(curve), curve.label)));
  }
}

function sample(curve) {
  const svg = document.createElementNS("http://www.w3.org/2000/svg", "svg");
  svg.setAttribute("viewBox", "0 0 26 8");
  svg.setAttribute("aria-hidden", "true");
  const line = document.createElementNS("http://www.w3.org/2000/svg", "path");
  line.setAttribute("d", "M1 4H25");
  line.setAttribute("class", `stroke-${curve.colour ?? "accent"}`);
  line.setAttribute("stroke-dasharray", dashOf(curve).join(" "));
  line.setAttribute("stroke-width", curve.width ?? 2);
  svg.append(line);
  return svg;
}
