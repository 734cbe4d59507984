// The body that falls, presses and flies back: once to scale, once the contact enlarged.
import { colours } from "./theme.js";
import { element } from "./inputs.js";
import { phrase } from "./units.js";

const FLIGHT = 0.6; // The enlarged picture shows this part of the contact time before and after it.

export class Ball {
  constructor(root, clock, outputs) {
    this.clock = clock;
    this.outputs = outputs;
    this.scene = new Scene("The body, to scale");
    this.zoom = new Scene("The contact, enlarged");
    this.readout = element("p", { className: "readout" });
    root.append(this.scene.root, this.zoom.root, this.readout);
    this.scene.onSize = this.zoom.onSize = () => this.draw();
    clock.onTick(() => this.draw());
  }

  // `radius` is that of the body, null where it has none.
  show(answer, radius) {
    this.answer = answer;
    this.surface = null;
    this.prepared = answer.curves.history && prepare(answer, radius);
    this.draw();
  }

  showSurface(surface) {
    this.surface = surface;
    this.draw();
  }

  draw() {
    if (!this.answer || !this.prepared) {
      this.scene.clear();
      this.zoom.clear();
      this.readout.textContent = this.answer?.status?.message ?? "";
      return;
    }
    const { phase } = this.clock;
    this.scene.paint((pen) => this.whole(pen, phase));
    this.zoom.paint((pen) => this.contact(pen, phase));
    const [depth, force] = [this.at("indentation_depth"), this.at("force")];
    const { time, indentation_depth, force: forces } = this.outputs;
    this.readout.textContent = `t = ${phrase(this.clock.time, time, 3)}   d = ${phrase(depth, indentation_depth, 3)}   `
      + `F = ${phrase(force, forces, 3)}   shown ${slow(this.clock.slowness)}`;
  }

  at(name) {
    const { time, [name]: values } = this.answer.curves.history;
    return interpolate(time, values, this.clock.time);
  }

  // Depth of the lowest point of the body; negative above the surface.
  depth(phase, reach) {
    const { velocity, rebound, end } = this.prepared;
    if (phase < 0) return phase * reach * velocity;
    if (phase > 1) return end - (phase - 1) * reach * rebound;
    return this.at("indentation_depth");
  }

  whole(pen, phase) {
    const { radius, e, profile, round } = this.prepared;
    const palette = colours();
    const { ctx, width, height, em } = pen;
    const scale = height / (6.1 * radius);
    const ground = height - 0.75 * radius * scale;
    const middle = width / 2;
    const flight = 3 * radius * scale;
    ctx.fillStyle = palette.ground;
    ctx.fillRect(0, ground, width, height - ground);
    line(ctx, palette.muted, 1.5, [[0, ground], [width, ground]]);
    const body = (lift, alpha) => {
      ctx.globalAlpha = alpha;
      outline(ctx, round ? null : profile, radius, middle, ground - lift, scale);
      ctx.fillStyle = palette.body;
      ctx.fill();
      ctx.strokeStyle = palette.ink;
      ctx.lineWidth = 1.5;
      ctx.stroke();
      ctx.globalAlpha = 1;
    };
    const lift = phase < 0 ? -phase * flight : phase > 1 ? e * (phase - 1) * flight : -this.depth(phase, 0) * scale;
    for (let n = 4; n > 0; n--) {
      if (phase < 0 && n / 4 > -phase) body((n / 4) * flight, 0.1);
      if (phase > 1 && n / 4 < phase - 1) body((e * n * flight) / 4, 0.1);
    }
    body(lift, 1);
    ctx.font = `${0.8 * em}px ${palette.font}`;
    ctx.textBaseline = "middle";
    const level = (share, words, right) => {
      const y = ground - share * flight;
      line(ctx, palette.muted, 1, [[0, y], [width, y]], [4, 4]);
      ctx.textAlign = right ? "right" : "left";
      ctx.fillStyle = palette.ink;
      ctx.fillText(words, right ? width - 5 : 5, y - 0.7 * em);
    };
    level(1, "start");
    if (phase > 0.999) level(e, `e = ${e.toFixed(3)}`, true);
  }

  contact(pen, phase) {
    const { extent, stretch, reach, maxForce, profile, radius } = this.prepared;
    const palette = colours();
    const { ctx, width, height, em } = pen;
    const scale = width / (2 * extent);
    const ground = 0.56 * height;
    const x = (r) => width / 2 + r * scale;
    const y = (depth) => ground + depth * scale * stretch;
    const depth = this.depth(phase, reach);
    const inside = phase >= 0 && phase <= 1;
    const edge = inside ? this.at("contact_radius") : 0;
    const dip = this.dip(phase, depth, edge);
    const count = 160;
    ctx.beginPath();
    ctx.moveTo(0, height);
    for (let n = -count; n <= count; n++) ctx.lineTo(x((n / count) * extent), y(dip(Math.abs((n / count) * extent))));
    ctx.lineTo(width, height);
    ctx.closePath();
    ctx.fillStyle = palette.ground;
    ctx.fill();
    ctx.strokeStyle = palette.muted;
    ctx.lineWidth = 2;
    ctx.stroke();
    ctx.beginPath();
    for (let n = -count; n <= count; n++) {
      const r = (n / count) * extent;
      ctx.lineTo(x(r), Math.max(y(depth - shapeAt(profile, Math.abs(r), radius)), -10));
    }
    ctx.lineTo(width + 10, -10);
    ctx.lineTo(-10, -10);
    ctx.closePath();
    ctx.fillStyle = palette.body;
    ctx.fill();
    ctx.strokeStyle = palette.ink;
    ctx.lineWidth = 2;
    ctx.stroke();
    if (edge > 0) {
      for (const side of [-1, 1]) {
        line(ctx, palette.accent, 2.5, [[x(side * edge), y(dip(edge)) + 3], [x(side * edge), y(dip(edge)) + 0.9 * em]]);
      }
    }
    ctx.font = `${0.85 * em}px ${palette.font}`;
    if (inside) this.arrow(ctx, palette, em, width / 2, y(depth), (0.42 * height * this.at("force")) / maxForce);
    ruler(ctx, palette, em, width, height, scale, this.outputs.indentation_depth);
    if (stretch > 1) {
      ctx.textAlign = "right";
      ctx.fillStyle = palette.ink;
      ctx.fillText(`heights × ${stretch}`, width - 8, height - 0.9 * em);
    }
  }

  // Displacement of the surface over the radius.
  dip(phase, depth, edge) {
    const { profile, radius } = this.prepared;
    const within = (r) => depth - shapeAt(profile, r, radius);
    const { surface } = this;
    if (surface) {
      const last = surface.time.at(-1);
      const time = phase <= 1 ? this.clock.time : this.clock.length + (phase - 1) * (last - this.clock.length);
      const row = blend(surface.time, surface.displacement, time);
      const outside = (r) => interpolate(surface.radius, row, r);
      return (r) => (phase < 0 ? 0 : r < edge ? within(r) : edge > 0 ? Math.max(outside(r), within(r)) : outside(r));
    }
    return (r) => (r < edge ? within(r) : edge > 0 ? (within(edge) * 2 * Math.asin(edge / r)) / Math.PI : 0);
  }

  arrow(ctx, palette, em, left, tip, length) {
    if (length < 4) return;
    const start = tip - 4;
    const end = start - length;
    line(ctx, palette.ink, 3, [[left, start], [left, end + 8]]);
    ctx.beginPath();
    ctx.moveTo(left, end);
    ctx.lineTo(left - 6, end + 11);
    ctx.lineTo(left + 6, end + 11);
    ctx.fillStyle = palette.ink;
    ctx.fill();
    ctx.textAlign = "left";
    ctx.textBaseline = "middle";
    ctx.fillText(`F = ${phrase(this.at("force"), this.outputs.force, 3)}`, left + 10, Math.max(Math.min(end + 10, tip - 1.5 * em), 0.8 * em));
  }
}

class Scene {
  constructor(words) {
    this.canvas = element("canvas");
    this.canvas.setAttribute("aria-hidden", "true");
    this.root = element("div", { className: "scene" }, this.canvas, element("p", { className: "caption" }, words));
    this.onSize = () => {};
    new ResizeObserver(() => this.fit()).observe(this.canvas);
  }

  fit() {
    const { clientWidth: width, clientHeight: height } = this.canvas;
    const ratio = devicePixelRatio;
    if (this.canvas.width === Math.round(width * ratio) && this.canvas.height === Math.round(height * ratio)) return;
    this.canvas.width = Math.round(width * ratio);
    this.canvas.height = Math.round(height * ratio);
    this.size = { width, height };
    this.onSize();
  }

  clear() {
    this.canvas.getContext("2d").clearRect(0, 0, this.canvas.width, this.canvas.height);
  }

  paint(draw) {
    if (!this.size?.width) return;
    const ctx = this.canvas.getContext("2d");
    this.clear();
    ctx.save();
    ctx.scale(devicePixelRatio, devicePixelRatio);
    draw({ ctx, ...this.size, em: colours().em });
    ctx.restore();
  }
}

function prepare({ curves, numbers }, known) {
  const { shape, history } = curves;
  const widest = Math.max(...history.contact_radius);
  const deepest = Math.max(...history.indentation_depth);
  const contactTime = history.time.at(-1);
  const ratio = deepest / widest;
  const radius = known ?? shape.radius.at(-1);
  const n = shape.radius.findIndex((r) => r > 0.05 * radius);
  return {
    // A height that is infinite comes as null.
    profile: { ...shape, height: shape.height.map((one) => one ?? 1e3 * radius) },
    radius,
    round: known !== null && n > 0 && Math.abs(shape.height[n] / (shape.radius[n] ** 2 / (2 * radius)) - 1) < 0.1,
    e: numbers.restitution_coefficient,
    velocity: history.indentation_velocity[0],
    rebound: numbers.rebound_velocity,
    end: history.indentation_depth.at(-1),
    extent: 2.3 * widest,
    reach: FLIGHT * contactTime,
    maxForce: numbers.max_force,
    stretch: ratio >= 0.12 ? 1 : [2, 5, 10, 20, 50, 100, 200, 500, 1000].find((one) => one * ratio >= 0.2) ?? 1000,
  };
}

// Height of the body over its lowest point; beyond the table, a ball or the last slope.
function shapeAt(profile, r, radius) {
  const { radius: radii, height } = profile;
  if (r <= radii.at(-1)) return interpolate(radii, height, r);
  const n = radii.length - 1;
  const slope = (height[n] - height[n - 1]) / (radii[n] - radii[n - 1]);
  return height[n] + slope * (r - radii[n]) + (r - radii[n]) ** 2 / (2 * radius);
}

// The outline of the whole body: a circle for a round body, else its profile with a lid.
function outline(ctx, profile, radius, left, bottom, scale) {
  ctx.beginPath();
  if (!profile) {
    ctx.arc(left, bottom - radius * scale, radius * scale, 0, 2 * Math.PI);
    return;
  }
  const top = 2 * radius;
  const count = 120;
  const half = Array.from({ length: count + 1 }, (_, n) => (n / count) * radius).filter((r) => shapeAt(profile, r, radius) < top);
  const widest = half.at(-1);
  for (const r of [...half.toReversed().map((one) => -one), ...half]) ctx.lineTo(left + r * scale, bottom - shapeAt(profile, Math.abs(r), radius) * scale);
  ctx.lineTo(left + widest * scale, bottom - top * scale);
  ctx.lineTo(left - widest * scale, bottom - top * scale);
  ctx.closePath();
}

function line(ctx, colour, width, points, dash = []) {
  ctx.strokeStyle = colour;
  ctx.lineWidth = width;
  ctx.setLineDash(dash);
  ctx.beginPath();
  for (const [x, y] of points) ctx.lineTo(x, y);
  ctx.stroke();
  ctx.setLineDash([]);
}

// A bar of a round length.
function ruler(ctx, palette, em, width, height, scale, quantity) {
  const rough = (0.22 * width) / scale;
  const power = Math.pow(10, Math.floor(Math.log10(rough)));
  const length = [5, 2, 1].map((one) => one * power).find((one) => one <= rough) ?? power;
  const y = height - 0.7 * em;
  line(ctx, palette.ink, 2, [[8, y - 4], [8, y], [8 + length * scale, y], [8 + length * scale, y - 4]]);
  ctx.textAlign = "left";
  ctx.textBaseline = "middle";
  ctx.fillStyle = palette.ink;
  ctx.fillText(phrase(Number(length.toPrecision(3)), quantity, 1), 8, y - em);
}

const slow = (factor) => (factor >= 1.5 ? `${Number(factor.toPrecision(2)).toLocaleString("en")} times slower`
  : factor <= 0.67 ? `${Number((1 / factor).toPrecision(2)).toLocaleString("en")} times faster` : "in real time");

export function interpolate(xs, ys, x) {
  if (x <= xs[0]) return ys[0];
  if (x >= xs.at(-1)) return ys.at(-1);
  let [low, high] = [0, xs.length - 1];
  while (high - low > 1) {
    const middle = (low + high) >> 1;
    if (xs[middle] <= x) low = middle;
    else high = middle;
  }
  const share = (x - xs[low]) / (xs[high] - xs[low]);
  return ys[low] + share * (ys[high] - ys[low]);
}

function blend(times, rows, time) {
  const place = interpolate(times, times.map((_, n) => n), time);
  const n = Math.min(Math.floor(place), rows.length - 2);
  return rows[n].map((one, k) => one + (place - n) * (rows[n + 1][k] - one));
}
