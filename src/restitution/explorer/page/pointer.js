// The pointer on a picture: the values of the nearest curve, a drag to a part of the picture, a click to its place.
import { draw, words } from "./drawing.js";
import { colours } from "./theme.js";
import { digits, unitText } from "./units.js";

// Distances in sizes of the text: from the pointer to a curve that it reads, and least length of a side of a part.
const [NEAR, LEAST] = [3.5, 0.8];
// A click on a part of the picture waits for a second one, which shows the whole again.
const PAUSE = 280;

export class Pointer {
  // pick(x, y, done) goes to a place; about(x, y) is what a picture has there besides its curves.
  constructor(figure, { onPick, about }) {
    Object.assign(this, { figure, onPick, about, at: null, from: null });
    const { svg, root } = figure;
    if (onPick) root.classList.add("pickable");
    const on = (kind, act) => svg.addEventListener(kind, act);
    on("pointerdown", (event) => this.down(event));
    on("pointermove", (event) => this.moved(event));
    on("pointerup", (event) => this.up(event));
    on("pointercancel", () => this.leave());
    on("pointerleave", () => this.leave());
    on("dblclick", () => {
      clearTimeout(this.picking);
      figure.zoom(null);
    });
  }

  place({ clientX, clientY }) {
    const { left, top } = this.figure.svg.getBoundingClientRect();
    const { box } = this.figure;
    return [clientX - left - box.left, clientY - top - box.top];
  }

  pick(event, done) {
    if (this.figure.curves.length) this.onPick?.(...this.figure.values(...this.place(event)), done);
  }

  // A finger goes to the places on which it moves; a drag of the mouse marks a part.
  down(event) {
    if (!event.target.matches(".over") || event.button > 0) return;
    this.figure.svg.setPointerCapture(event.pointerId);
    if (event.pointerType === "touch") this.pick(event, false);
    else this.from = this.place(event);
  }

  moved(event) {
    const held = this.figure.svg.hasPointerCapture(event.pointerId);
    if (held && event.pointerType === "touch") this.pick(event, false);
    this.at = held || event.target.matches(".over") ? this.place(event) : null;
    this.draw();
  }

  up(event) {
    if (event.pointerType === "touch") {
      if (this.figure.svg.hasPointerCapture(event.pointerId)) this.pick(event, true);
      this.leave();
      return;
    }
    if (!this.from) return;
    const part = this.part(this.place(event));
    this.from = null;
    clearTimeout(this.picking);
    if (part) this.figure.zoom(part);
    else if (this.figure.part) this.picking = setTimeout(() => this.pick(event, true), PAUSE);
    else this.pick(event, true);
    this.draw();
  }

  leave() {
    Object.assign(this, { at: null, from: null });
    this.draw();
  }

  // The ranges between the start of a drag and a place; a side that is short is that of the picture, and a click has
  // none.
  part([x, y]) {
    const { figure, from } = this;
    const wide = (a, b) => Math.abs(a - b) > LEAST * colours().em;
    const [across, up] = [wide(from[0], x), wide(from[1], y)];
    if (!across && !up) return null;
    const [low, high] = [figure.values(Math.min(from[0], x), Math.max(from[1], y)), figure.values(Math.max(from[0], x), Math.min(from[1], y))];
    return { x: across ? [low[0], high[0]] : figure.shown.x, y: up ? [low[1], high[1]] : figure.shown.y };
  }

  draw() {
    const layer = this.figure.layer("hover");
    if (!layer) return;
    draw(layer, !this.at || !this.figure.x ? [] : this.from ? this.marked() : this.read());
  }

  marked() {
    const part = this.part(this.at);
    if (!part) return [];
    const [left, top] = this.figure.place(part.x[0], part.y[1]);
    const [right, bottom] = this.figure.place(part.x[1], part.y[0]);
    const { accent } = colours();
    return [["rect", { x: left, y: top, width: right - left, height: bottom - top, fill: accent, "fill-opacity": 0.12, stroke: accent }]];
  }

  // The nearest place on a curve, with its values in words.
  read() {
    const { figure } = this;
    const palette = colours();
    const near = nearest(figure, this.at, NEAR * palette.em);
    if (!near && !this.about) return [];
    const [x, y] = near?.place ?? this.at;
    const values = figure.values(x, y);
    const { x: across, y: up } = figure.options;
    const said = [spoken(values[0], across), spoken(values[1], up, near?.curve.symbol), this.about?.(...values)].filter(Boolean).join(", ");
    const letter = near?.curve.letter && !this.about ? `${near.curve.letter}: ` : "";
    const right = x > figure.box.width / 2;
    const above = y > 2 * palette.em ? y - 1.1 * palette.em : y + 1.3 * palette.em;
    return [
      ["circle", { cx: x, cy: y, r: 0.26 * palette.em, fill: "none", stroke: palette.ink, "stroke-width": 2 }],
      words(letter + said, right ? x + 4 : x - 4, above, 0.85 * palette.em, palette.ink, { anchor: right ? "end" : "start", edge: palette.card, wide: 0.6 }),
    ];
  }
}

function spoken(value, { symbol, unit }, name = symbol) {
  const text = [digits(value, 4), unitText(unit?.unit ?? "")].filter(Boolean).join(" ");
  return name ? `${name} = ${text}` : text;
}

// The place on a curve or a mark that is nearest to a place in the box, if one is within a distance.
function nearest(figure, [left, top], reach) {
  let hit = null;
  const tryPlace = (place, curve) => {
    const distance = Math.hypot(place[0] - left, place[1] - top);
    if (distance < reach) [reach, hit] = [distance, { place, curve }];
  };
  const { width, height } = figure.box;
  const inside = ([x, y]) => x >= -1 && x <= width + 1 && y >= -1 && y <= height + 1;
  for (const curve of figure.curves) {
    let before = null;
    for (let n = 0; n < curve.x.length; n++) {
      const place = figure.place(curve.x[n], curve.y[n]);
      const drawn = place.every(Number.isFinite);
      if (drawn) {
        const foot = before ? footOf(before, place, [left, top]) : place;
        if (inside(foot)) tryPlace(foot, curve);
      }
      before = drawn ? place : null;
    }
  }
  for (const mark of figure.marks) if (mark.y !== undefined && inside(figure.place(mark.x, mark.y))) tryPlace(figure.place(mark.x, mark.y), mark);
  return hit;
}

// The point of a segment that is nearest to a place.
function footOf([x0, y0], [x1, y1], [x, y]) {
  const [dx, dy] = [x1 - x0, y1 - y0];
  const share = Math.min(Math.max(((x - x0) * dx + (y - y0) * dy) / (dx * dx + dy * dy || 1), 0), 1);
  return [x0 + share * dx, y0 + share * dy];
}
