// The body that falls, presses and flies back: once to scale, once the contact enlarged.
import { colours } from "./theme.js";
import { element } from "./inputs.js";
import { phrase } from "./units.js";

const FLIGHT = 0.6; // The enlarged picture shows this part of the contact time before and after it.

export class Ball {
  constructor(root, clock, outputs) {
    this.root = root;
    this.clock = clock;
    this.outputs = outputs;
    this.scene = new Scene("The body, to scale");
    this.zoom = new Scene("The contact, enlarged");
    this.readout = element("p", { className: "readout" });
    this.note = element("p", { className: "note", hidden: true },
      "A section through two faces. The surface around a pyramid is not known; the dashed line is the surface before the impact.");
    root.append(this.scene.root, this.zoom.root, this.note, this.readout);
    this.scene.onSize = this.zoom.onSize = () => this.draw();
    clock.onTick(() => this.draw());
  }

  // `body` is half the width and half the height of a round body, else null.
  show(answer, body) {
    this.answer = answer;
    this.surface = null;
    this.prepared = answer.curves.history && prepare(answer, body);
    const { semi_axis: axis } = answer.curves.shape;
    this.note.hidden = axis !== null;
    this.zoom.caption.textContent = axis > 1 ? "The contact along its long axis, enlarged" : "The contact, enlarged";
    this.draw();
  }

  showSurface(surface) {
    this.surface = surface;
    this.draw();
  }

  draw() {
    if (!this.answer) return;
    this.root.classList.toggle("none", !this.prepared);
    if (!this.prepared) {
      this.readout.textContent = `There is no rebound to show: ${this.answer.status.message}.`;
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
    const { radius, across, e, round } = this.prepared;
    const palette = colours();
    const { ctx, width, height, em } = pen;
    const scale = Math.min(height / (6.1 * radius), width / (2.3 * across));
    const ground = height - 0.75 * radius * scale;
    const middle = width / 2;
    const flight = 3 * radius * scale;
    ctx.fillStyle = palette.ground;
    ctx.fillRect(0, ground, width, height - ground);
    line(ctx, palette.muted, 1.5, [[0, ground], [width, ground]]);
    const body = (lift, alpha) => {
      ctx.globalAlpha = alpha;
      ctx.beginPath();
      if (round) ctx.ellipse(middle, ground - lift - radius * scale, across * scale, radius * scale, 0, 0, 2 * Math.PI);
      else outline(ctx, this.prepared, middle, ground - lift, scale);
      ctx.fillStyle = palette.body;
      ctx.fill();
      ctx.strokeStyle = palette.ink;
      ctx.lineWidth = 1.5 * palette.thickness;
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
    const { extent, stretch, reach, maxForce, profile } = this.prepared;
    const palette = colours();
    const { ctx, width, height, em } = pen;
    const scale = width / (2 * extent);
    const ground = 0.56 * height;
    const x = (r) => width / 2 + r * scale;
    const y = (depth) => ground + depth * scale * stretch;
    const depth = this.depth(phase, reach);
    const inside = phase >= 0 && phase <= 1;
    const edge = inside ? this.at("contact_radius") * profile.semi_axis : 0;
    const dip = this.dip(phase, depth, edge);
    // The ends of both outlines lie outside the picture.
    const count = 160;
    const radii = Array.from({ length: 2 * count + 1 }, (_, n) => 1.03 * extent * (n / count - 1));
    const [left, right, below] = [x(radii[0]), x(radii.at(-1)), height + 10];
    ctx.beginPath();
    ctx.moveTo(left, below);
    for (const r of radii) ctx.lineTo(x(r), y(dip(Math.abs(r))));
    ctx.lineTo(right, below);
    ctx.closePath();
    ctx.fillStyle = palette.ground;
    ctx.fill();
    ctx.strokeStyle = palette.muted;
    ctx.lineWidth = 2 * palette.thickness;
    if (profile.semi_axis !== null) ctx.stroke();
    line(ctx, palette.muted, 1, [[0, ground], [width, ground]], [4, 4]);
    ctx.beginPath();
    for (const r of radii) ctx.lineTo(x(r), Math.max(y(depth - shapeAt(profile, Math.abs(r))), -10));
    ctx.lineTo(right, -10);
    ctx.lineTo(left, -10);
    ctx.closePath();
    ctx.fillStyle = palette.body;
    ctx.fill();
    ctx.strokeStyle = palette.ink;
    ctx.lineWidth = 2 * palette.thickness;
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
    const { profile } = this.prepared;
    const within = (r) => depth - shapeAt(profile, r);
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
    this.caption = element("p", { className: "caption" }, words);
    this.root = element("div", { className: "scene" }, this.canvas, this.caption);
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

  paint(draw) {
    if (!this.size?.width) return;
    const ctx = this.canvas.getContext("2d");
    ctx.clearRect(0, 0, this.canvas.width, this.canvas.height);
    this.draw = draw;
    ctx.save();
    ctx.scale(devicePixelRatio, devicePixelRatio);
    draw({ ctx, ...this.size, em: colours().em });
    ctx.restore();
  }
}

function prepare({ curves, numbers }, body) {
  const { shape, history } = curves;
  // The shape ends at three times the half-width of the largest contact.
  const widest = shape.radius.at(-1) / 3;
  const deepest = Math.max(...history.indentation_depth);
  const contactTime = history.time.at(-1);
  const ratio = deepest / widest;
  const [across, radius] = body ?? [3 * widest, 3 * widest];
  const curvature = radius / across ** 2;
  const n = shape.radius.findIndex((r) => r > 0.05 * across);
  return {
    // A height that is infinite comes as null.
    profile: { ...shape, curvature, height: shape.height.map((one) => one ?? 1e3 * radius) },
    radius,
    across,
    round: body !== null && n > 0 && Math.abs(shape.height[n] / ((shape.radius[n] ** 2 * curvature) / 2) - 1) < 0.1,
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

// Height of the body over its lowest point; beyond the table, the last slope and the curvature of the body.
function shapeAt({ radius, height, curvature }, r) {
  if (r <= radius.at(-1)) return interpolate(radius, height, r);
  const n = radius.length - 1;
  const slope = (height[n] - height[n - 1]) / (radius[n] - radius[n - 1]);
  return height[n] + slope * (r - radius[n]) + ((r - radius[n]) ** 2 * curvature) / 2;
}

// The outline of a body that is not round: its profile with a lid.
function outline(ctx, { profile, radius, across }, left, bottom, scale) {
  const top = 2 * radius;
  const count = 120;
  const half = Array.from({ length: count + 1 }, (_, n) => (n / count) * across).filter((r) => shapeAt(profile, r) < top);
  const widest = half.at(-1);
  for (const r of [...half.toReversed().map((one) => -one), ...half]) ctx.lineTo(left + r * scale, bottom - shapeAt(profile, Math.abs(r)) * scale);
  ctx.lineTo(left + widest * scale, bottom - top * scale);
  ctx.lineTo(left - widest * scale, bottom - top * scale);
  ctx.closePath();
}

function line(ctx, colour, width, points, dash = []) {
  const { thickness } = colours();
  ctx.strokeStyle = colour;
  ctx.lineWidth = width * thickness;
  ctx.setLineDash(dash.map((part) => part * thickness));
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
