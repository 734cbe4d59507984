// The body that falls, presses and flies back: once to scale, once the contact enlarged.
import { draw, filled, lines, node, round, words } from "./drawing.js";
import { element } from "./elements.js";
import { colours } from "./theme.js";
import { phrase } from "./units.js";

const FLIGHT = 0.6; // The enlarged picture shows this part of the contact time before and after it.

const GAP = "The enlarged contact is the gap between both balls, pressed into a half-space; all motions are relative to the second ball.";

export class Ball {
  constructor(root, clock, outputs) {
    Object.assign(this, { root, clock, outputs });
    this.scene = new Scene("The body, to scale", () => this.draw());
    this.zoom = new Scene("The contact, enlarged", () => this.draw());
    this.readout = element("p", { className: "readout" });
    this.note = element("p", { className: "note", hidden: true });
    root.append(this.scene.root, this.zoom.root, this.note, this.readout);
    clock.onTick(() => this.draw());
  }

  // `body` is half the width and half the height of a round body, else null; `second` is the radius of a ball that it
  // hits, else null.
  show(answer, body, second) {
    this.answer = answer;
    this.surface = null;
    this.prepared = answer.curves.history && prepare(answer, body, second);
    const { semi_axis: axis, unknown } = answer.curves.shape;
    const slides = Boolean(answer.curves.history?.stick_radius);
    this.note.hidden = !unknown && !second && !slides;
    const rings = "Blue: the disc of the contact that sticks; orange: the ring around it that slips. ";
    this.note.textContent = unknown ? `${unknown}; the dashed line is the surface before the impact.` : (slides ? rings : "") + (second ? GAP : "");
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
    this.scene.show((view) => this.whole(view, phase));
    this.zoom.show((view) => this.contact(view, phase));
    const [depth, force] = [this.at("indentation_depth"), this.at("force")];
    const { time, indentation_depth, force: forces } = this.outputs;
    const captured = this.prepared.captured && phase > 0.999 ? "   captured" : "";
    this.readout.textContent = `t = ${phrase(this.clock.time, time, 3)}   d = ${phrase(depth, indentation_depth, 3)}   `
      + `F = ${phrase(force, forces, 3)}   shown ${slow(this.clock.slowness)}${captured}`;
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

  whole({ width, height, palette }, phase) {
    const { radius, across, e, round: isRound } = this.prepared;
    const { em, thickness } = palette;
    const scale = Math.min(height / (6.1 * radius), width / (2.3 * across));
    const ground = height - 0.75 * radius * scale;
    const { sideways } = this.prepared;
    // At grazing angles the flight is shorter, so that the body stays in the picture.
    const room = Math.max(width / 2 - across * scale, 0) / scale;
    const flight = Math.min(3 * radius, sideways.most > 0 ? room / sideways.most : Infinity) * scale;
    const moved = (at) => flight * (at < 0 ? sideways.before * at : at > 1 ? sideways.after * (at - 1) : 0);
    const turned = (at) => (flight / scale) * (at < 0 ? sideways.spin * at : at > 1 ? sideways.rebound_spin * (at - 1) : 0);
    const body = (lift, opacity, at = phase) => {
      const style = { fill: palette.body, stroke: palette.ink, "stroke-width": round(1.5 * thickness), opacity };
      return isRound ? ["ellipse", { cx: round(width / 2 + moved(at)), cy: round(ground - lift - radius * scale), rx: round(across * scale), ry: round(radius * scale), ...style }]
        : ["path", { d: outline(this.prepared, width / 2 + moved(at), ground - lift, scale), ...style }];
    };
    const lift = phase < 0 ? -phase * flight : phase > 1 && !this.prepared.captured ? e * (phase - 1) * flight : -this.depth(phase, 0) * scale;
    // Where the body was a moment ago, or will be.
    const ghosts = [4, 3, 2, 1].flatMap((n) => (phase < 0 && n / 4 > -phase ? [body((n / 4) * flight, 0.1, -n / 4)]
      : phase > 1 && n / 4 < phase - 1 ? [body((e * n * flight) / 4, 0.1, 1 + n / 4)] : []));
    // A radius of the body shows how it turns: a positive spin moves the lowest point to the right.
    const mark = () => {
      const [left, centre, angle] = [width / 2 + moved(phase), ground - lift - radius * scale, turned(phase)];
      return line(palette.ink, 1.5 * thickness, [[left, centre], [left - across * scale * Math.sin(angle), centre - radius * scale * Math.cos(angle)]]);
    };
    const level = (share, text, right) => {
      const y = ground - share * flight;
      return [line(palette.muted, thickness, [[0, y], [width, y]], true),
        words(text, right ? width - 5 : 5, y - 0.7 * em, 0.8 * em, palette.ink, { anchor: right ? "end" : "start" })];
    };
    return [
      ...this.below(palette, ground, width, height, scale),
      ...ghosts,
      body(lift, 1),
      ...(sideways.shown && isRound ? [mark()] : []),
      ...level(1, "start", false),
      ...(phase > 0.999 ? level(e, `e = ${e.toFixed(3)}`, true) : []),
    ];
  }

  // What the body hits: a half-space, a layer on its base, or a ball.
  below(palette, ground, width, height, scale) {
    const { second, profile } = this.prepared;
    const edge = { stroke: palette.muted, "stroke-width": round(1.5 * palette.thickness) };
    if (second) return [["circle", { cx: round(width / 2), cy: round(ground + second * scale), r: round(second * scale), fill: palette.ground, ...edge }]];
    return [
      ["rect", { x: 0, y: round(ground), width, height: round(height - ground), fill: palette.ground }],
      ...baseOf(palette, ground + (profile.thickness ?? Infinity) * scale, width, height),
      line(palette.muted, 1.5 * palette.thickness, [[0, ground], [width, ground]]),
    ];
  }

  contact({ width, height, palette }, phase) {
    const { extent, stretch, reach, maxForce, profile } = this.prepared;
    const { em, thickness } = palette;
    const scale = width / (2 * extent);
    const ground = 0.56 * height;
    const x = (r) => width / 2 + r * scale;
    const y = (depth) => ground + depth * scale * stretch;
    const depth = this.depth(phase, reach);
    const inside = this.touches(phase);
    const edge = inside ? this.at("contact_radius") * profile.semi_axis : 0;
    const dip = this.dip(phase, depth, edge);
    // The ends of both outlines lie outside the picture.
    const count = 160;
    const radii = Array.from({ length: 2 * count + 1 }, (_, n) => 1.03 * extent * (n / count - 1));
    const [left, right, below] = [x(radii[0]), x(radii.at(-1)), height + 10];
    const surface = [[left, below], ...radii.map((r) => [x(r), y(dip(Math.abs(r)))]), [right, below]];
    const body = [...radii.map((r) => [x(r), Math.max(y(depth - shapeAt(profile, Math.abs(r))), -10)]), [right, -10], [left, -10]];
    const wide = round(2 * thickness);
    return [
      ["path", { d: `${lines(surface)}Z`, fill: palette.ground, ...(profile.semi_axis !== null && { stroke: palette.muted, "stroke-width": wide }) }],
      ...baseOf(palette, y(profile.thickness ?? Infinity), width, height),
      line(palette.muted, thickness, [[0, ground], [width, ground]], true),
      ["path", { d: `${lines(body)}Z`, fill: palette.body, stroke: palette.ink, "stroke-width": wide }],
      ...(edge > 0 ? [-1, 1].map((side) => line(palette.accent, 2.5 * thickness, [[x(side * edge), y(dip(edge)) + 3], [x(side * edge), y(dip(edge)) + 0.9 * em]])) : []),
      ...(inside ? this.rings(edge).map(([from, to, colour]) => this.band(from, to, palette[colour], 4 * thickness, (r) => [x(r), y(dip(Math.abs(r)))])).flat() : []),
      ...(inside ? this.arrow(palette, width / 2, y(depth), (0.42 * height * this.at("force")) / maxForce) : []),
      ...ruler(palette, width, height, scale, this.outputs.indentation_depth),
      ...(stretch > 1 ? [words(`heights × ${stretch}`, width - 8, height - 0.9 * em, 0.85 * em, palette.ink, { anchor: "end" })] : []),
    ];
  }

  // A body that is captured stays where its motion ends.
  touches(phase) {
    return phase >= 0 && (phase <= 1 || this.prepared.captured);
  }

  // The outer radius of the ring of attraction.
  get zone() {
    const { phase } = this.clock;
    return this.touches(phase) && this.answer.curves.history.zone_radius ? this.at("zone_radius") : 0;
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
    const { zone } = this;
    if (zone > 0) {
      // The gap grows from nothing to the range of the attraction, and the surface falls back beyond it.
      const gap = (r) => profile.range * Math.min(Math.max((r - edge) / (zone - edge || zone), 0), 1);
      return (r) => (r <= zone ? within(r) + gap(r) : ((within(zone) + profile.range) * 2 * Math.asin(zone / r)) / Math.PI);
    }
    return (r) => (r < edge ? within(r) : edge > 0 ? (within(edge) * 2 * Math.asin(edge / r)) / Math.PI : 0);
  }

  // Rings of the contact with their colours: where it sticks and where it slips, or where the surfaces attract.
  rings(edge) {
    const { zone } = this;
    if (zone > 0) return [[edge, zone, "second"]];
    if (!this.answer.curves.history.stick_radius) return [];
    const stick = Math.min(this.at("stick_radius"), edge);
    return [[0, stick, "accent"], [stick, edge, "second"]];
  }

  band(from, to, colour, thickness, place) {
    if (!(to > from)) return [];
    const radii = Array.from({ length: 25 }, (_, n) => from + (n / 24) * (to - from));
    return [-1, 1].map((side) => line(colour, thickness, radii.map((r) => place(side * r))));
  }

  arrow({ ink, em, thickness }, left, tip, length) {
    if (length < 4) return [];
    const start = tip - 4;
    const end = start - length;
    return [
      line(ink, 3 * thickness, [[left, start], [left, end + 8]]),
      ["path", { d: `${lines([[left, end], [left - 6, end + 11], [left + 6, end + 11]])}Z`, fill: ink }],
      words(`F = ${phrase(this.at("force"), this.outputs.force, 3)}`, left + 10, Math.max(Math.min(end + 10, tip - 1.5 * em), 0.8 * em), 0.85 * em, ink),
    ];
  }
}

// A picture that is drawn anew at each moment.
class Scene {
  constructor(text, onSize) {
    this.svg = node("svg", { "aria-hidden": true });
    this.caption = element("p", { className: "caption" }, text);
    this.root = element("div", { className: "scene" }, this.svg, this.caption);
    this.size = filled(this.svg, this.svg, onSize);
  }

  show(shapes) {
    if (this.size.width) draw(this.svg, shapes({ ...this.size, palette: colours() }));
  }
}

function prepare({ curves, numbers, status }, body, second) {
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
    profile: { ...shape, curvature, height: shape.height.map((height) => height ?? 1e3 * radius) },
    radius,
    across,
    second,
    captured: status.name === "CAPTURED",
    round: second !== null || (body !== null && n > 0 && Math.abs(shape.height[n] / ((shape.radius[n] ** 2 * curvature) / 2) - 1) < 0.1),
    e: numbers.restitution_coefficient,
    velocity: history.indentation_velocity[0],
    rebound: numbers.rebound_velocity,
    sideways: sidewaysOf(numbers, history.indentation_velocity[0]),
    end: history.indentation_depth.at(-1),
    extent: 2.3 * widest,
    reach: FLIGHT * contactTime,
    maxForce: numbers.max_force,
    stretch: ratio >= 0.12 ? 1 : [2, 5, 10, 20, 50, 100, 200, 500, 1000].find((factor) => factor * ratio >= 0.2) ?? 1000,
  };
}

// Motion along the surface, and turns in the flight by its own length, over the impact velocity; none in a normal impact.
function sidewaysOf(numbers, velocity) {
  const shown = numbers.tangential_velocity !== undefined;
  const over = (name) => (shown ? (numbers[name] ?? 0) / velocity : 0);
  const [before, after] = [over("tangential_velocity"), over("rebound_tangential_velocity")];
  return { shown, before, after, spin: over("spin"), rebound_spin: over("rebound_spin"), most: Math.max(Math.abs(before), Math.abs(after)) };
}

// Height of the body over its lowest point; beyond the table, the last slope and the curvature of the body.
function shapeAt({ radius, height, curvature }, r) {
  if (r <= radius.at(-1)) return interpolate(radius, height, r);
  const n = radius.length - 1;
  const slope = (height[n] - height[n - 1]) / (radius[n] - radius[n - 1]);
  return height[n] + slope * (r - radius[n]) + ((r - radius[n]) ** 2 * curvature) / 2;
}

// The rigid base of a layer, where it is in the picture.
const baseOf = ({ muted }, top, width, height) => (top < height
  ? [["rect", { x: 0, y: round(top), width, height: round(height - top), fill: muted }]] : []);

// The outline of a body that is not round: its profile with a lid.
function outline({ profile, radius, across }, left, bottom, scale) {
  const top = 2 * radius;
  const count = 120;
  const half = Array.from({ length: count + 1 }, (_, n) => (n / count) * across).filter((r) => shapeAt(profile, r) < top);
  const widest = half.at(-1);
  const lower = [...half.toReversed().map((r) => -r), ...half].map((r) => [r, shapeAt(profile, Math.abs(r))]);
  return `${lines([...lower, [widest, top], [-widest, top]].map(([r, h]) => [left + r * scale, bottom - h * scale]))}Z`;
}

function line(stroke, width, points, dashed = false) {
  return ["path", { d: lines(points), fill: "none", stroke, "stroke-width": round(width), ...(dashed && { "stroke-dasharray": "4 4" }) }];
}

// A bar of a round length.
function ruler({ ink, em, thickness }, width, height, scale, quantity) {
  const rough = (0.22 * width) / scale;
  const power = Math.pow(10, Math.floor(Math.log10(rough)));
  const length = [5, 2, 1].map((digit) => digit * power).find((size) => size <= rough) ?? power;
  const y = height - 0.7 * em;
  return [
    line(ink, 2 * thickness, [[8, y - 4], [8, y], [8 + length * scale, y], [8 + length * scale, y - 4]]),
    words(phrase(Number(length.toPrecision(3)), quantity, 1), 8, y - em, 0.85 * em, ink),
  ];
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
  return rows[n].map((value, k) => value + (place - n) * (rows[n + 1][k] - value));
}
