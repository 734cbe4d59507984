// A picture of curves: uPlot draws axes and grid, this module the curves, marks and the cursor of time.
import uPlot from "./uplot.js";
import { ticks, tickLabels } from "./ticks.js";
import { colours, onTheme } from "./theme.js";

const DASHES = { solid: [], dashed: [7, 4], dotted: [2, 3], dashdot: [8, 3, 2, 3] };

// Places along a curve for its letter, best first.
const SHARES = [0.5, 0.4, 0.6, 0.3, 0.7, 0.22, 0.78, 0.14, 0.86, 0.07, 0.93];

export const dashOf = (curve) => DASHES[curve.dash ?? "solid"];

export class Figure {
  // options: title, words (what a reader of the screen hears), x and y as {label, log}, height, onPick(x, y)
  constructor(options) {
    this.options = options;
    this.curves = [];
    this.marks = [];
    this.bands = null;
    this.ranges = { x: [1, 10], y: [1, 10] };
    this.root = document.createElement("div");
    this.root.className = "plot";
    this.dots = [];
    this.visible = true;
    this.stale = false;
    this.size = { width: 0, height: 0 };
    new ResizeObserver(() => this.fit()).observe(this.root);
    new IntersectionObserver(([seen]) => this.appear(seen.isIntersecting), { rootMargin: "200px" }).observe(this.root);
    onTheme(() => this.rebuild());
  }

  // Replaces what is drawn. Ranges follow from the curves unless they are given.
  show({ curves, marks = [], bands = null, x = this.options.x, y = this.options.y, ranges = {} }) {
    Object.assign(this.options, { x, y });
    this.curves = curves;
    this.bands = bands;
    this.ranges = {
      x: ranges.x ?? (x.room ? padded(extent(curves, "x"), false) : extent(curves, "x", x.log)),
      y: ranges.y ?? padded(extent(curves, "y", y.log), y.log, marks.some(({ label }) => label)),
    };
    this.marks = marks.filter((mark) => ["x", "y"].every((key) => mark[key] === undefined
      || (mark[key] >= this.ranges[key][0] && mark[key] <= this.ranges[key][1])));
    if (!this.visible) this.later();
    else this.redraw();
  }

  get kind() {
    return `${Boolean(this.options.x.log)} ${Boolean(this.options.y.log)}`;
  }

  redraw() {
    this.stale = false;
    if (this.kind !== this.built) this.rebuild();
    else if (this.plot) this.plot.setData([null, [[0], [0]]]);
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

  fit() {
    const { clientWidth: width, clientHeight: height } = this.root;
    if (!width || !height || (width === this.size.width && height === this.size.height)) return;
    this.size = { width, height };
    if (this.plot && this.kind === this.built) this.plot.setSize(this.size);
    else this.rebuild();
  }

  rebuild() {
    if (!this.size.width) return;
    this.stale = false;
    this.built = this.kind;
    this.plot?.destroy();
    this.dots = [];
    const palette = colours();
    const em = parseFloat(getComputedStyle(this.root).fontSize);
    // uPlot enlarges whole numbers of pixels only on a screen of high resolution.
    const font = (share) => `${Math.round(share * em)}px ${palette.font}`;
    const axis = (key, side, size) => ({
      side,
      scale: key,
      label: () => this.label(key, em),
      labelSize: 1.5 * em,
      labelFont: font(0.95),
      labelGap: 0,
      font: font(0.88),
      stroke: palette.muted,
      size,
      gap: 4,
      grid: { stroke: palette.grid, width: 1 },
      ticks: { stroke: palette.grid, width: 1, size: 5 },
      splits: (u, index, low, high) => ticks(low, high, this.options[key], this.count(key, em)),
      filter: (u, marks) => marks,
      values: (u, marks) => tickLabels(marks, this.options[key].log),
    });
    this.plot = new uPlot({
      mode: 2,
      ...this.size,
      padding: [0.7 * em, 0.9 * em, 0, 0],
      legend: { show: false },
      cursor: { show: false },
      scales: {
        x: { time: false, distr: this.options.x.log ? 3 : 1, range: () => this.ranges.x },
        y: { distr: this.options.y.log ? 3 : 1, range: () => this.ranges.y },
      },
      axes: [axis("x", 2, 1.9 * em), axis("y", 3, (u, values) => this.width(values, em))],
      series: [{}, { facets: [{ scale: "x", auto: true }, { scale: "y", auto: true }], paths: () => this.paint(), points: { show: false } }],
      hooks: { ready: [() => this.listen()], draw: [() => this.point()] },
    }, [null, [[0], [0]]], this.root);
    this.plot.root.setAttribute("aria-hidden", "true");
  }

  // A label that is longer than its axis is given by its symbol.
  label(key, em) {
    const { label, short } = this.options[key];
    const room = key === "x" ? this.size.width - 4 * em : this.size.height - 3 * em;
    return short && 0.5 * em * label.length > room ? short : label;
  }

  count(key, em) {
    return key === "x" ? this.size.width / (5.5 * em) : this.size.height / (3.2 * em);
  }

  width(values, em) {
    const longest = Math.max(2, ...(values ?? []).map((text) => (text ?? "").length));
    return (0.62 * longest + 0.9) * em;
  }

  place(x, y, pixels = false) {
    return [this.plot.valToPos(x, "x", pixels), this.plot.valToPos(y, "y", pixels)];
  }

  paint() {
    const u = this.plot;
    if (!u) return null;
    const { ctx, bbox } = u;
    const ratio = devicePixelRatio;
    const palette = colours();
    ctx.save();
    ctx.beginPath();
    ctx.rect(bbox.left, bbox.top, bbox.width, bbox.height);
    ctx.clip();
    ctx.lineJoin = ctx.lineCap = "round";
    if (this.bands) {
      ctx.globalAlpha = this.bands.alpha ?? 1;
      ctx.drawImage(this.bands.image, bbox.left, bbox.top, bbox.width, bbox.height);
      ctx.globalAlpha = 1;
    }
    for (const curve of this.curves) {
      ctx.strokeStyle = palette[curve.colour ?? "accent"];
      ctx.lineWidth = (curve.width ?? 2) * ratio * palette.thickness;
      ctx.setLineDash(dashOf(curve).map((part) => part * ratio * palette.thickness));
      ctx.stroke(this.path(curve));
    }
    ctx.setLineDash([]);
    ctx.font = `${0.85 * palette.em * ratio}px ${palette.font}`;
    // Labels stay off the lines of the marks and off each other.
    const taken = this.marks.filter((mark) => mark.y === undefined).map((mark) => ({
      x: u.valToPos(mark.x, "x", true), y: bbox.top + bbox.height / 2, wide: 2 * ratio, high: bbox.height }));
    for (const curve of this.curves) if (curve.letter) this.letter(ctx, curve, palette, ratio, taken);
    ctx.restore();
    ctx.save();
    ctx.font = `${0.85 * palette.em * ratio}px ${palette.font}`;
    for (const mark of this.marks) this.mark(ctx, mark, palette, ratio);
    ctx.restore();
    return null;
  }

  path(curve) {
    const path = new Path2D();
    let pen = false;
    for (let n = 0; n < curve.x.length; n++) {
      const [x, y] = [curve.x[n], curve.y[n]];
      if (x === null || y === null || !Number.isFinite(x) || !Number.isFinite(y)
        || (this.options.x.log && x <= 0) || (this.options.y.log && y <= 0)) {
        pen = false;
        continue;
      }
      const [left, top] = this.place(x, y, true);
      if (pen) path.lineTo(left, top);
      else path.moveTo(left, top);
      pen = true;
    }
    return path;
  }

  // Writes the letter of a curve at a place that no other has; there may be none.
  letter(ctx, curve, palette, ratio, taken) {
    const [wide, high] = [ctx.measureText(curve.letter).width / 2 + 3 * ratio, 0.6 * palette.em * ratio];
    const { bbox } = this.plot;
    const last = curve.x.length - 1;
    const free = ([x, y]) => x - wide > bbox.left && x + wide < bbox.left + bbox.width
      && y - high > bbox.top && y + high < bbox.top + bbox.height
      && taken.every((one) => Math.abs(one.x - x) > one.wide + 1.3 * wide || Math.abs(one.y - y) > one.high + 1.3 * high);
    const places = SHARES.map((share) => Math.round(((curve.at ?? 0) + share + 1) % 1 * last)).filter((n) =>
      curve.y[n] !== null && free(this.place(curve.x[n], curve.y[n], true)));
    // Curves over common places have their letters where the next one is farthest.
    const gap = (n) => Math.min(...this.curves.filter((one) => one.apart && one !== curve).map((one) => Math.abs(one.y[n] - curve.y[n])));
    curve.placed = curve.apart ? places.sort((a, b) => gap(b) - gap(a))[0] : places[0];
    if (curve.placed === undefined) return;
    const [x, y] = this.place(curve.x[curve.placed], curve.y[curve.placed], true);
    taken.push({ x, y, wide, high });
    ctx.textAlign = "center";
    ctx.textBaseline = "middle";
    ctx.lineWidth = 4 * ratio;
    ctx.strokeStyle = palette.card;
    ctx.strokeText(curve.letter, x, y);
    ctx.fillStyle = palette[curve.colour === "pinned" ? "muted" : curve.colour ?? "accent"];
    ctx.fillText(curve.letter, x, y);
  }

  mark(ctx, mark, palette, ratio) {
    const { bbox } = this.plot;
    ctx.strokeStyle = ctx.fillStyle = palette[mark.colour ?? "ink"];
    ctx.lineWidth = 1.5 * ratio;
    if (mark.y === undefined) {
      const left = this.plot.valToPos(mark.x, "x", true);
      ctx.setLineDash([4 * ratio, 3 * ratio]);
      ctx.beginPath();
      ctx.moveTo(left, bbox.top);
      ctx.lineTo(left, bbox.top + bbox.height);
      ctx.stroke();
      ctx.setLineDash([]);
      // The words stand to the right of the line if there is room.
      const [gap, high] = [5 * ratio, 1.1 * palette.em * ratio];
      const wide = ctx.measureText(mark.label ?? "").width;
      mark.before = left + gap + wide > bbox.left + bbox.width;
      const from = mark.before ? left - gap - wide : left + gap;
      ctx.textAlign = "left";
      ctx.textBaseline = "middle";
      ctx.fillStyle = palette.card;
      ctx.fillRect(from - 2 * ratio, bbox.top, wide + 4 * ratio, high);
      ctx.fillStyle = palette[mark.colour ?? "ink"];
      ctx.fillText(mark.label ?? "", from, bbox.top + high / 2);
      return;
    }
    const [left, top] = this.place(mark.x, mark.y, true);
    ctx.beginPath();
    ctx.arc(left, top, 5.5 * ratio * palette.thickness, 0, 2 * Math.PI);
    ctx.fillStyle = palette.card;
    ctx.fill();
    ctx.lineWidth = 2.5 * ratio * palette.thickness;
    ctx.stroke();
  }

  // Moves a line to x, and a dot to each point [x, y]; nothing is drawn again.
  cursor(x, points = []) {
    this.pointer = { x, points };
    if (this.visible) this.point();
  }

  point() {
    if (!this.plot || !this.pointer) return;
    const { x, points } = this.pointer;
    const over = this.plot.over;
    while (this.dots.length < points.length + 1) {
      const dot = document.createElement("div");
      dot.className = this.dots.length ? "cursor-dot" : "cursor-line";
      over.append(dot);
      this.dots.push(dot);
    }
    const [line, ...dots] = this.dots;
    line.hidden = x === null;
    if (x !== null) line.style.transform = `translateX(${this.plot.valToPos(x, "x")}px)`;
    dots.forEach((dot, n) => {
      dot.hidden = !points[n];
      if (!points[n]) return;
      const [left, top] = this.place(...points[n]);
      dot.style.transform = `translate(${left}px, ${top}px)`;
    });
  }

  // A click or a drag on the picture goes to the values there.
  listen() {
    const pick = this.options.onPick;
    if (!pick) return;
    const over = this.plot.over;
    over.classList.add("pickable");
    const send = (event, done) => {
      if (!this.curves.length) return;
      const box = over.getBoundingClientRect();
      const x = Math.min(Math.max(event.clientX - box.left, 0), box.width);
      const y = Math.min(Math.max(event.clientY - box.top, 0), box.height);
      pick(this.plot.posToVal(x, "x"), this.plot.posToVal(y, "y"), done);
    };
    over.addEventListener("pointerdown", (event) => {
      over.setPointerCapture(event.pointerId);
      send(event, false);
    });
    over.addEventListener("pointermove", (event) => event.buttons && send(event, false));
    over.addEventListener("pointerup", (event) => send(event, true));
  }
}

function extent(curves, key, log) {
  let [low, high] = [Infinity, -Infinity];
  for (const curve of curves) {
    for (const value of curve[key]) {
      if (value === null || !Number.isFinite(value) || (log && value <= 0)) continue;
      if (value < low) low = value;
      if (value > high) high = value;
    }
  }
  if (!(low <= high)) return log ? [0.1, 10] : [0, 1];
  if (low === high) return log ? [low / 2, high * 2] : [low - (Math.abs(low) || 1) / 2, high + (Math.abs(high) || 1) / 2];
  return [low, high];
}

// The words of a line stand above the curves.
function padded([low, high], log, words = false) {
  if (log) {
    const room = Math.pow(high / low, 0.05);
    return [low / room, high * (words ? room ** 3 : room)];
  }
  const room = 0.06 * (high - low);
  return [low >= 0 && low < 0.3 * high ? 0 : low - room, high + room];
}
