// A picture of curves over two axes, with marks and a cursor of time.
import { Axis, rangeOf } from "./axis.js";
import { draw, filled, lines, node, round, words } from "./drawing.js";
import { element } from "./elements.js";
import { Pointer } from "./pointer.js";
import { colours } from "./theme.js";
import { back, convert } from "./units.js";

const DASHES = { solid: [], dashed: [7, 4], dotted: [2, 3], dashdot: [8, 3, 2, 3] };

// Places along a curve for its letter, best first.
const SHARES = [0.5, 0.4, 0.6, 0.3, 0.7, 0.22, 0.78, 0.14, 0.86, 0.07, 0.93];

// Sizes over the size of the page's text; the width of a character is that of most fonts.
const [ABOVE, BELOW, BESIDE, TITLE, CHARACTER] = [0.7, 3.4, 0.9, 1.5, 0.62];
const TICK = 5;
const PLAIN = { factor: 1 };

export function strokeOf(curve) {
  const palette = colours();
  const dash = DASHES[curve.dash ?? "solid"].map((part) => round(part * palette.thickness)).join(" ");
  return { fill: "none", stroke: palette[curve.colour ?? "accent"], "stroke-width": round((curve.width ?? 2) * palette.thickness), ...(dash && { "stroke-dasharray": dash }) };
}

export class Figure {
  // options: x and y as {label, short, symbol, unit, log, whole, room}, and those of the pointer
  constructor(options) {
    Object.assign(this, { options, curves: [], marks: [], part: null, visible: true, stale: false });
    this.svg = node("svg", { "aria-hidden": true });
    this.root = element("div", { className: "plot" }, this.svg);
    this.size = filled(this.svg, this.root, () => this.redraw());
    new IntersectionObserver(([seen]) => this.appear(seen.isIntersecting), { rootMargin: "200px" }).observe(this.root);
    this.pointer = new Pointer(this, options);
  }

  // Replaces what is drawn. Ranges follow from the curves unless they are given.
  show({ curves, marks = [], image = null, x = this.options.x, y = this.options.y, ranges = {} }) {
    Object.assign(this.options, { x, y });
    Object.assign(this, { curves, marks, image });
    this.ranges = {
      x: ranges.x ?? rangeOf(curves, "x", x.log, { room: x.room ?? false }),
      y: ranges.y ?? rangeOf(curves, "y", y.log, { words: marks.some(({ label }) => label) }),
    };
    if (this.visible) this.redraw();
    else this.later();
  }

  // The ranges that are shown: those of the curves, or of a part, which is kept in SI as units change with the sliders.
  get shown() {
    const { ranges, part, options } = this;
    const of = (key) => part?.[key].map((value) => convert(value, options[key].unit ?? PLAIN)) ?? ranges[key];
    return { x: of("x"), y: of("y") };
  }

  // Shows a part {x, y} of the picture, or the whole again.
  zoom(part) {
    const of = (key) => part[key].map((value) => back(value, this.options[key].unit ?? PLAIN));
    this.part = part && { x: of("x"), y: of("y") };
    this.redraw();
  }

  // A picture out of sight waits until the page rests or until it is seen.
  later() {
    this.stale = true;
    clearTimeout(this.timer);
    this.timer = setTimeout(() => this.stale && this.redraw(), 400);
  }

  appear(visible) {
    this.visible = visible;
    if (!visible) return;
    if (this.stale) this.redraw();
    else this.point();
  }

  redraw() {
    const { size, options } = this;
    this.stale = false;
    if (!size.width || !this.ranges) return;
    const ranges = this.shown;
    const palette = colours();
    const { em } = palette;
    const height = size.height - (ABOVE + BELOW) * em;
    this.y = new Axis(ranges.y, height, size.height / (3.2 * em), options.y);
    const longest = Math.max(2, ...this.y.labels.map(({ length }) => length));
    const left = round((TITLE + BESIDE + CHARACTER * longest) * em);
    this.box = { left, top: round(ABOVE * em), width: size.width - left - BESIDE * em, height };
    this.x = new Axis(ranges.x, this.box.width, size.width / (5.5 * em), options.x);
    const box = { width: round(this.box.width), height: round(height) };
    const place = { transform: `translate(${left} ${this.box.top})` };
    draw(this.svg, [
      ["g", place, this.axes(palette)],
      // A picture within the picture ends at its edges.
      ["svg", { x: left, y: this.box.top, ...box }, [
        ...(this.image ? [["image", { ...this.whole(), preserveAspectRatio: "none", href: this.image }]] : []),
        ...this.curves.map((curve) => ["path", { d: this.path(curve), ...strokeOf(curve), "stroke-linejoin": "round", "stroke-linecap": "round" },
          [["title", {}, curve.label ?? curve.letter ?? ""]]]),
      ]],
      ["g", place, [...this.letters(palette), ...this.marked(palette)]],
      ["rect", { class: "over", ...place, ...box, fill: "none", "pointer-events": "all" }],
      ["g", { class: "cursor", ...place, "pointer-events": "none" }],
      ["g", { class: "hover", ...place, "pointer-events": "none" }],
    ]);
    this.point();
    this.pointer.draw();
  }

  layer(name) {
    return this.svg.querySelector(`.${name}`);
  }

  // Where the whole picture is, in the box of a part.
  whole() {
    const [left, top] = this.place(this.ranges.x[0], this.ranges.y[1]);
    const [right, bottom] = this.place(this.ranges.x[1], this.ranges.y[0]);
    return { x: round(left), y: round(top), width: round(right - left), height: round(bottom - top) };
  }

  // From the values of a point to its place in the box, and back.
  place(x, y) {
    return [this.x.at(x), this.box.height - this.y.at(y)];
  }

  values(left, top) {
    return [this.x.value(left), this.y.value(this.box.height - top)];
  }

  axes(palette) {
    const { em, grid, muted } = palette;
    const { left, width, height } = this.box;
    const { x, y } = this.options;
    const across = this.x.ticks.map((tick) => round(this.x.at(tick)));
    const up = this.y.ticks.map((tick) => round(height - this.y.at(tick)));
    // A label that is longer than its axis is given by its symbol.
    const title = ({ label, short }, room) => (short && 0.5 * em * label.length > room ? short : label);
    const turned = `rotate(-90 ${round(0.75 * em - left)} ${round(height / 2)})`;
    const [name, attributes, text] = words(title(y, this.size.height - 3 * em), 0.75 * em - left, height / 2, 0.95 * em, muted, { anchor: "middle" });
    return [
      ["path", { d: across.map((at) => `M${at} 0V${round(height) + TICK}`).join("") + up.map((at) => `M${-TICK} ${at}H${round(width)}`).join(""),
        fill: "none", stroke: grid, "shape-rendering": "crispEdges" }],
      ...across.map((at, n) => words(this.x.labels[n], at, height + TICK + 0.85 * em, 0.88 * em, muted, { anchor: "middle" })),
      ...up.map((at, n) => words(this.y.labels[n], -TICK - 4, at, 0.88 * em, muted, { anchor: "end" })),
      words(title(x, this.size.width - 4 * em), width / 2, height + 2.6 * em, 0.95 * em, muted, { anchor: "middle" }),
      [name, { ...attributes, transform: turned }, text],
    ];
  }

  path({ x, y }) {
    return lines(Array.from(x, (value, n) => this.place(value, y[n])));
  }

  // The letters of the curves, off the lines of the marks and off each other; for some there may be no place.
  letters(palette) {
    const { width, height } = this.box;
    const size = 0.85 * palette.em;
    const taken = this.marks.filter((mark) => mark.y === undefined).map((mark) => ({ x: this.x.at(mark.x), y: height / 2, wide: 2, high: height }));
    return this.curves.filter(({ letter }) => letter).flatMap((curve) => {
      const [wide, high] = [0.5 * CHARACTER * size * curve.letter.length + 3, 0.6 * palette.em];
      const last = curve.x.length - 1;
      const free = ([x, y]) => x > wide && x + wide < width && y > high && y + high < height
        && taken.every((box) => Math.abs(box.x - x) > box.wide + 1.3 * wide || Math.abs(box.y - y) > box.high + 1.3 * high);
      const places = SHARES.map((share) => Math.round(share * last)).filter((n) =>
        curve.y[n] !== null && free(this.place(curve.x[n], curve.y[n])));
      // Curves over common places have their letters where the next one is farthest.
      const gap = (n) => Math.min(...this.curves.filter((other) => other.apart && other !== curve).map((other) => Math.abs(other.y[n] - curve.y[n])));
      const n = curve.apart ? places.sort((a, b) => gap(b) - gap(a))[0] : places[0];
      if (n === undefined) return [];
      const [x, y] = this.place(curve.x[n], curve.y[n]);
      taken.push({ x, y, wide, high });
      const colour = curve.colour === "pinned" ? "muted" : curve.colour ?? "accent";
      return [words(curve.letter, x, y, size, palette[colour], { anchor: "middle", edge: palette.card })];
    });
  }

  marked(palette) {
    const inside = this.marks.filter((mark) => this.x.has(mark.x) && (mark.y === undefined || this.y.has(mark.y)));
    return inside.flatMap((mark) => (mark.y === undefined ? this.level(mark, palette) : this.dot(mark, palette)));
  }

  // A dot, on a bar of its standard deviation to both sides.
  dot(mark, { [mark.colour ?? "ink"]: stroke, card, thickness }) {
    const [cx, cy] = this.place(mark.x, mark.y).map(round);
    const size = mark.size ?? 1;
    const circle = ["circle", { cx, cy, r: round(5.5 * size * thickness), fill: card, stroke, "stroke-width": round(2.5 * size * thickness) }];
    if (!mark.spread) return [circle];
    const ends = [-1, 1].map((side) => this.place(mark.x, mark.y + side * mark.spread));
    return [["path", { d: lines(ends), fill: "none", stroke, "stroke-width": round(1.5 * thickness) }], circle];
  }

  // A line at a value, with its words to the right if there is room, else to the left, else up to the edge.
  level(mark, palette) {
    const colour = palette[mark.colour ?? "ink"];
    const { width, height } = this.box;
    const x = round(this.x.at(mark.x));
    const size = 0.85 * palette.em;
    const wide = 0.54 * size * (mark.label ?? "").length + 5;
    const [from, anchor] = x + wide < width ? [x + 5, "start"] : x > wide ? [x - 5, "end"] : [width, "end"];
    return [
      ["path", { d: `M${x} 0V${round(height)}`, fill: "none", stroke: colour, "stroke-width": 1.5, "stroke-dasharray": "4 3" }],
      words(mark.label ?? "", from, 0.55 * palette.em, size, colour, { anchor, edge: palette.card, wide: 0.6 }),
    ];
  }

  // Moves a line to x, and a dot to each point [x, y]; nothing else is drawn again.
  cursor(x, points = []) {
    this.cursorAt = { x, points };
    if (this.visible) this.point();
  }

  point() {
    if (!this.box || !this.cursorAt) return;
    const { muted, ink, card, em } = colours();
    const { x, points } = this.cursorAt;
    const at = x === null ? null : this.x.at(x);
    const seen = (place) => place.every(Number.isFinite) && place[0] >= 0 && place[0] <= this.box.width && place[1] >= 0 && place[1] <= this.box.height;
    draw(this.layer("cursor"), [
      ...(x === null || !this.x.has(x) ? [] : [["line", { x1: at, x2: at, y1: 0, y2: this.box.height, stroke: muted, "stroke-width": 1.5 }]]),
      ...points.map((point) => this.place(...point)).filter(seen).map(([cx, cy]) =>
        ["circle", { cx, cy, r: 0.24 * em, fill: ink, stroke: card, "stroke-width": 2 }]),
    ]);
  }
}
