// The tab of one impact: the ball, the numbers, and all curves with a common cursor of time.
import { rangeOf } from "./axis.js";
import { Ball, interpolate } from "./ball.js";
import { Clock, timeControl } from "./clock.js";
import { files, menu } from "./downloads.js";
import { element } from "./elements.js";
import { planePicture } from "./map.js";
import { Measured } from "./measured.js";
import { Assumptions, Numbers } from "./numbers.js";
import { Panel, picture } from "./panel.js";
import { back, convert, digits, phrase } from "./units.js";

const TILES = ["restitution_coefficient", "contact_time", "max_force", "max_indentation_depth", "max_contact_radius",
  "tangential_restitution_coefficient", "rebound_angle", "rebound_spin", "impulse_ratio", "pull_off_force", "touching_time", "zone_width", "instantaneous_poisson_ratio", "loss_tangent", "p2", "p3"];
const MOTION = ["time", "indentation_depth", "contact_radius", "force"];
const ENERGIES = [
  { name: "kinetic_energy", label: "kinetic", colour: "accent" },
  { name: "stored_energy", label: "stored", colour: "second", dash: "dashed" },
  { name: "dissipated_energy", label: "dissipated", colour: "third", dash: "dashdot" },
  { name: "radiated_energy", label: "radiated", colour: "ink", dash: "dotted" },
  { name: "jump_energy", label: "lost in jumps", colour: "ink", dash: "dotted" },
];
const SHEAR = [
  { name: "relaxation_modulus", label: "reduced modulus E*(t)", colour: "accent" },
  { name: "shear_modulus", label: "shear modulus G(t)", colour: "second", dash: "dashed" },
];
const MODULI = [
  { name: "storage_modulus", label: "storage modulus", colour: "accent" },
  { name: "loss_modulus", label: "loss modulus", colour: "second", dash: "dashed" },
];
const LOGS = { xLog: true, yLog: true, words: "modulus" };

export class ImpactTab {
  constructor(root, app) {
    this.app = app;
    this.clock = new Clock();
    this.outputs = app.schema.outputs;
    this.numbers = new Numbers(root, TILES, this.outputs);
    const columns = () => MOTION.map((name) => ({ name, unit: this.outputs[name].unit, values: this.answer.curves.history[name] }));
    this.stage = element("section", { className: "card stage" }, element("header", {},
      element("h3", { id: "stage-title" }, "Slow motion"), menu("Slow motion", files("slow-motion", () => this.stage, columns))));
    this.stage.setAttribute("aria-labelledby", "stage-title");
    const scenes = element("div", { className: "scenes" });
    this.stage.append(scenes, timeControl(this.clock));
    this.ball = new Ball(scenes, this.clock, this.outputs);
    const pickTime = (x) => this.clock.toTime(back(x, this.scales.force.across));
    this.velocity = new Panel({ name: "velocity", title: "Restitution coefficient over velocity", x: { log: true }, onPick: (x, y, done) => this.pickVelocity(x, done) });
    this.measured = new Measured(app.state);
    this.velocity.root.append(this.measured.root);
    this.force = new Panel({ name: "force", title: "Force over time", onPick: pickTime });
    this.loop = new Panel({ name: "loop", title: "Force over depth" });
    this.energy = new Panel({ name: "energy", title: "Energies over time", onPick: pickTime });
    this.relaxation = new Panel({ name: "relaxation", title: "Relaxation of the material" });
    this.moduli = new Panel({ name: "moduli", title: "Moduli over frequency" });
    this.map = new Panel({ name: "map", title: "The paper's plane", onPick: (p2, p3, done) => app.goTo(p2, p3, done),
      about: (p2, p3) => `e = ${digits(app.paper.restitution(this.mapNu, p2, p3))}` });
    const panels = [this.velocity, this.force, this.loop, this.energy, this.relaxation, this.moduli, this.map];
    const grid = element("div", { className: "grid" }, this.stage, ...panels.map((panel) => panel.root));
    root.append(grid);
    this.assumptions = new Assumptions(grid);
    this.clock.onTick(() => this.tick());
    this.clock.start();
  }

  // Tables of curves of the present setting and of the pinned ones.
  sets(kind, name) {
    const present = kind === "impact" ? this.answer : this.velocities;
    const pins = this.app.pins.of(kind);
    return [...(present ? [{ answer: present }] : []), ...pins].map((set) => ({ ...set, table: set.answer.curves[name] }));
  }

  receive(answer) {
    if (answer.kind === "impact") this.show(answer);
    else if (answer.kind === "surface") this.ball.showSurface(answer.curves.surface);
    else {
      this.velocities = answer;
      this.showVelocity();
    }
  }

  show(answer) {
    this.answer = answer;
    const { numbers, curves, marks } = answer;
    this.numbers.show(numbers);
    // A page without a server has no shape and no curves over time.
    for (const panel of [this.force, this.loop, this.energy]) panel.root.hidden = !curves?.history;
    for (const panel of [this.relaxation, this.moduli]) panel.root.hidden = !curves?.[panel.name];
    this.stage.hidden = !curves?.shape;
    this.assumptions.box.hidden = !answer.validity;
    if (answer.validity) this.assumptions.show(answer.validity, answer.notes);
    this.showMap(numbers);
    this.showVelocity();
    if (!curves) return;
    if (curves.history) this.showHistory(numbers);
    if (curves.shape) this.ball.show(answer, this.app.body(), this.app.second());
    if (curves.moduli) this.showModuli(numbers, marks);
    this.clock.span(numbers.contact_time ?? curves.history?.time.at(-1) ?? 1);
  }

  showModuli(numbers, marks) {
    const { outputs } = this;
    const marked = (value, unit, label) => (value ? [{ x: convert(value, unit), label }] : []);
    const relaxation = picture(this.sets("impact", "relaxation"), "time", SHEAR, outputs, { ...LOGS, xWords: "time" });
    this.relaxation.show({ ...relaxation, marks: marked(marks.contact_time, relaxation.across, "contact time"),
      summary: `The contact time ${phrase(marks.contact_time, outputs.contact_time)} is marked.` });
    const moduli = picture(this.sets("impact", "moduli"), "angular_frequency", MODULI, outputs, LOGS);
    this.moduli.show({ ...moduli, marks: marked(marks.angular_frequency, moduli.across, "π over contact time"),
      summary: `The loss tangent at the frequency of the contact is ${digits(numbers.loss_tangent, 3)}.` });
  }

  showHistory(numbers) {
    const { outputs } = this;
    const sets = this.sets("impact", "history");
    const words = (name) => phrase(numbers[name], outputs[name]);
    const force = picture(sets, "time", [{ name: "force" }], outputs);
    this.force.show({ ...force, summary: `The largest force is ${words("max_force")}; the contact lasts ${words("contact_time")}.` });
    const loop = picture(sets, "indentation_depth", [{ name: "force" }], outputs, { xRoom: true });
    this.loop.show({ ...loop, summary: `The largest depth is ${words("max_indentation_depth")}; the area of the loop is the energy lost.` });
    const energies = ENERGIES.filter(({ name }) => sets[0].table[name]?.some(Boolean));
    const energy = picture(sets, "time", energies, outputs, { words: "energy" });
    this.energy.show({ ...energy, summary: `Of ${words("kinetic_energy_in")}, ${words("dissipated_energy")} is dissipated.` });
    this.scales = { force, loop, energy };
  }

  // Where an assumption is doubtful, the curve is dashed.
  showVelocity() {
    const { outputs } = this;
    const sets = this.sets("velocity", "velocity");
    if (!sets.length) return;
    const shown = picture(sets, "velocity", [{ name: "restitution_coefficient" }], outputs, { xLog: true, words: "e" });
    const doubtful = this.velocities?.curves.velocity.doubtful ?? [];
    const curves = shown.curves.flatMap((curve) => (curve.colour === "accent" ? parted(curve, doubtful.map(Boolean)) : [curve]));
    const [v, e] = [this.app.state.get("impact.velocity"), this.answer?.numbers.restitution_coefficient];
    const marks = v && Number.isFinite(e) ? [{ x: convert(v, shown.across), y: e, colour: "accent" }] : [];
    this.velocityUnit = shown.across;
    const points = this.measured.marks(shown.across);
    this.measured.show(this.velocities?.curves.velocity);
    const most = Math.max(1, ...points.map(({ y, spread = 0 }) => y + spread));
    this.velocity.show({ ...shown, curves, marks: [...points, ...marks], columns: [...shown.columns, ...this.measured.columns()],
      ranges: { x: rangeOf([...curves, { x: points.map(({ x }) => x) }], "x", true, { room: points.length > 0 }), y: [0, 1.06 * most] }, summary: `At ${phrase(v, outputs.velocity ?? {})} the restitution coefficient is ${digits(e)}.` });
  }

  pickVelocity(x, done) {
    const { low, high } = this.app.state.byKey.get("impact.velocity");
    const value = Math.min(Math.max(back(x, this.velocityUnit), low), high);
    this.app.state.set({ "impact.velocity": Number(value.toPrecision(3)) }, done);
  }

  // A map of another Poisson ratio comes after the other pictures; out of sight it waits until the sliders rest.
  showMap(numbers, later = false) {
    const { paper } = this.app;
    const { nu, p2, p3 } = numbers;
    clearTimeout(this.mapTimer);
    this.map.root.hidden = !paper || !Number.isFinite(p2) || p3 === null;
    if (this.map.root.hidden) return;
    if (!later && nu !== this.mapNu) {
      this.mapTimer = setTimeout(() => this.showMap(numbers, true), this.map.figure.visible ? 0 : 400);
      return;
    }
    this.mapNu = nu;
    const words = `ν = ${digits(nu, 4)}, p₂ = ${digits(p2, 3)}, p₃ = ${digits(p3, 3)}`;
    this.map.show({ ...planePicture(paper, nu, [{ x: p2, y: p3, colour: "accent" }]),
      note: `Isolines of e at ${words}. Press a place to go there.`, summary: words });
  }

  tick() {
    const history = this.answer?.curves?.history;
    if (!history || !this.scales) return;
    const { time } = this.clock;
    const at = (name, unit) => convert(interpolate(history.time, history[name], time), unit);
    const { force, loop, energy } = this.scales;
    const now = convert(time, force.across);
    this.force.figure.cursor(now, [[now, at("force", force.up)]]);
    this.loop.figure.cursor(null, [[at("indentation_depth", loop.across), at("force", loop.up)]]);
    this.energy.figure.cursor(now, ENERGIES.filter(({ name }) => history[name]).map(({ name }) => [now, at(name, energy.up)]));
  }
}

// A curve as two: dotted where `doubtful` is true, up to the next point on each side, and as it is elsewhere.
function parted(curve, doubtful) {
  if (!doubtful.some(Boolean)) return [curve];
  const near = doubtful.map((here, n) => here || doubtful[n - 1] || doubtful[n + 1]);
  const piece = (there, style) => ({ ...curve, ...style, y: curve.y.map((y, n) => (there[n] ? y : null)) });
  return [piece(near, { dash: "dotted", label: "an assumption is doubtful" }),
    piece(doubtful.map((here) => !here), { label: "no assumption is doubtful" })];
}
