// The tab of one impact: the ball, the numbers, and all curves with a common cursor of time.
import { Ball, interpolate } from "./ball.js";
import { Clock, timeControl } from "./clock.js";
import { picture } from "./curves.js";
import { files, menu } from "./downloads.js";
import { element } from "./elements.js";
import { planePicture } from "./map.js";
import { Assumptions, Numbers } from "./numbers.js";
import { Panel } from "./panel.js";
import { convert, digits, phrase } from "./units.js";

const TILES = ["restitution_coefficient", "contact_time", "max_force", "max_indentation_depth", "max_contact_radius",
  "instantaneous_poisson_ratio", "loss_tangent"];
const MOTION = ["time", "indentation_depth", "contact_radius", "force"];
const ENERGIES = [
  { name: "kinetic_energy", label: "kinetic", colour: "accent" },
  { name: "stored_energy", label: "stored", colour: "second", dash: "dashed" },
  { name: "dissipated_energy", label: "dissipated", colour: "third", dash: "dashdot" },
  { name: "radiated_energy", label: "radiated", colour: "ink", dash: "dotted" },
];
const SHEAR = [
  { name: "relaxation_modulus", label: "reduced modulus E*(t)", colour: "accent" },
  { name: "shear_modulus", label: "shear modulus G(t)", colour: "second", dash: "dashed" },
];
const MODULI = [
  { name: "storage_modulus", label: "storage modulus", colour: "accent" },
  { name: "loss_modulus", label: "loss modulus", colour: "second", dash: "dashed" },
];

export class ImpactTab {
  constructor(root, app) {
    this.app = app;
    this.clock = new Clock();
    const { outputs } = app.schema;
    this.numbers = new Numbers(root, [...TILES, "p2", "p3"], outputs);
    const stage = element("section", { className: "card stage" }, element("header", {},
      element("h3", { id: "stage-title" }, "Slow motion"),
      menu("Slow motion", files("slow-motion", () => stage,
        () => MOTION.map((name) => ({ name, unit: outputs[name].unit, values: this.answer.curves.history[name] }))))));
    stage.setAttribute("aria-labelledby", "stage-title");
    const scenes = element("div", { className: "scenes" });
    stage.append(scenes, timeControl(this.clock));
    this.ball = new Ball(scenes, this.clock, outputs);
    const pickTime = (x) => this.clock.toTime((x - (this.across.offset ?? 0)) / this.across.factor);
    this.force = new Panel({ name: "force", title: "Force over time", onPick: pickTime });
    this.loop = new Panel({ name: "loop", title: "Force over depth" });
    this.energy = new Panel({ name: "energy", title: "Energies over time", onPick: pickTime });
    this.velocity = new Panel({ name: "velocity", title: "Restitution coefficient over velocity", x: { log: true }, onPick: (x, y, done) => this.pickVelocity(x, done) });
    this.relaxation = new Panel({ name: "relaxation", title: "Relaxation of the material" });
    this.moduli = new Panel({ name: "moduli", title: "Moduli over frequency" });
    this.map = new Panel({ name: "map", title: "The paper's plane", onPick: (p2, p3, done) => app.goTo(p2, p3, done) });
    const grid = element("div", { className: "grid" });
    grid.append(stage, ...[this.velocity, this.force, this.loop, this.energy, this.relaxation, this.moduli, this.map].map((panel) => panel.root));
    root.append(grid);
    this.assumptions = new Assumptions(grid);
    this.clock.onTick(() => this.tick());
    this.clock.start();
  }

  sets(kind, name) {
    const present = kind === "impact" ? this.answer : this.velocities;
    const own = present ? [{ table: present.curves[name] }] : [];
    return [...own, ...this.app.pins.of(kind).map((pin) => ({ ...pin, table: pin.answer.curves[name] }))];
  }

  receive(answer) {
    if (answer.kind === "impact") this.show(answer);
    else if (answer.kind === "velocity") this.showVelocity(answer);
    else if (answer.kind === "surface") this.ball.showSurface(answer.curves.surface);
  }

  show(answer) {
    this.answer = answer;
    const { numbers, curves, marks } = answer;
    const { outputs } = this.app.schema;
    this.numbers.show(numbers);
    const live = Boolean(curves);
    for (const panel of [this.force, this.loop, this.energy]) panel.root.hidden = !curves?.history;
    for (const panel of [this.relaxation, this.moduli]) panel.root.hidden = !curves?.[panel.name];
    // A page without a server has no shape and no history.
    this.ball.scene.root.closest(".stage").hidden = !curves?.shape;
    this.assumptions.box.hidden = !answer.validity;
    if (answer.validity) this.assumptions.show(answer.validity, answer.notes);
    this.showMap(numbers);
    this.markVelocity();
    if (!live) return;
    if (curves.history) this.showHistory(numbers, outputs);
    if (curves.shape) this.ball.show(answer, this.app.body());
    if (curves.moduli) this.showModuli(numbers, marks, outputs);
    this.clock.span(numbers.contact_time ?? 1);
  }

  showModuli(numbers, marks, outputs) {
    const relaxation = picture(this.sets("impact", "relaxation"), "time", SHEAR, outputs, { xLog: true, yLog: true, xWords: "time", words: "modulus" });
    const marked = (value, unit, label) => (value ? [{ x: convert(value, unit), label }] : []);
    this.relaxation.show({ ...relaxation, marks: marked(marks.contact_time, relaxation.across, "contact time"),
      summary: `The contact time ${phrase(marks.contact_time, outputs.contact_time)} is marked.` });
    const moduli = picture(this.sets("impact", "moduli"), "angular_frequency", MODULI, outputs, { xLog: true, yLog: true, words: "modulus" });
    this.moduli.show({ ...moduli, marks: marked(marks.angular_frequency, moduli.across, "π over contact time"),
      summary: `The loss tangent at the frequency of the contact is ${digits(numbers.loss_tangent, 3)}.` });
  }

  showHistory(numbers, outputs) {
    const sets = this.sets("impact", "history");
    const force = picture(sets, "time", [{ name: "force" }], outputs);
    this.across = force.across;
    this.force.show({ ...force, summary: `The largest force is ${phrase(numbers.max_force, outputs.max_force)}; the contact lasts ${phrase(numbers.contact_time, outputs.contact_time)}.` });
    const loop = picture(sets, "indentation_depth", [{ name: "force" }], outputs, { xRoom: true });
    this.loop.show({ ...loop, summary: `The largest depth is ${phrase(numbers.max_indentation_depth, outputs.max_indentation_depth)}; the area of the loop is the energy lost.` });
    const energies = ENERGIES.filter(({ name }) => sets[0].table[name]?.some(Boolean));
    const energy = picture(sets, "time", energies, outputs, { words: "energy" });
    this.energy.show({ ...energy, summary: `Of ${phrase(numbers.kinetic_energy_in, outputs.kinetic_energy_in)}, ${phrase(numbers.dissipated_energy, outputs.dissipated_energy)} is dissipated.` });
    this.scales = { force, loop, energy };
  }

  showVelocity(answer) {
    this.velocities = answer;
    this.markVelocity();
  }

  // Where an assumption is doubtful, the curve is dashed.
  markVelocity() {
    const { outputs } = this.app.schema;
    const sets = this.sets("velocity", "velocity");
    if (!sets.length) return;
    const shown = picture(sets, "velocity", [{ name: "restitution_coefficient" }], outputs, { xLog: true, words: "e" });
    const doubtful = this.velocities?.curves.velocity.doubtful ?? [];
    const own = shown.curves.findIndex((curve) => curve.colour === "accent");
    if (own >= 0) shown.curves.splice(own, 1, ...parted(shown.curves[own], doubtful));
    const [v, e] = [this.app.state.get("impact.velocity"), this.answer?.numbers.restitution_coefficient];
    const marks = v && e !== null && e !== undefined ? [{ x: convert(v, shown.across), y: e, colour: "accent" }] : [];
    this.velocityUnit = shown.across;
    this.velocity.show({ ...shown, marks, ranges: { y: [0, 1.06] }, summary: `At ${phrase(v, outputs.velocity ?? {})} the restitution coefficient is ${digits(e)}.` });
  }

  pickVelocity(x, done) {
    const value = x / this.velocityUnit.factor;
    const { low, high } = this.app.state.inputs.byKey.get("impact.velocity");
    this.app.state.set({ "impact.velocity": Number(Math.min(Math.max(value, low), high).toPrecision(3)) }, done);
  }

  // A map of another Poisson ratio comes after the other pictures; out of sight it waits until the sliders rest.
  showMap(numbers, later = false) {
    const { paper } = this.app;
    const known = paper && numbers.p2 !== null && numbers.p2 !== undefined && numbers.p3 !== null;
    this.map.root.hidden = !known;
    clearTimeout(this.mapTimer);
    if (!known) return;
    if (!later && numbers.nu !== this.mapNu) {
      this.mapTimer = setTimeout(() => this.showMap(numbers, true), this.map.figure.visible ? 0 : 400);
      return;
    }
    this.mapNu = numbers.nu;
    const words = `ν = ${digits(numbers.nu, 4)}, p₂ = ${digits(numbers.p2, 3)}, p₃ = ${digits(numbers.p3, 3)}`;
    this.map.show({
      ...planePicture(paper, numbers.nu, [{ x: numbers.p2, y: numbers.p3, colour: "accent" }]),
      note: `Isolines of e at ${words}. Press a place to go there.`,
      summary: words,
    });
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

// A curve as pieces: dashed where `doubtful` is 1. Each piece begins at the end of the one before.
function parted(curve, doubtful) {
  if (!doubtful.some(Boolean)) return [curve];
  const piece = (wanted, style) => ({
    ...curve, ...style,
    y: curve.y.map((y, n) => (Boolean(doubtful[n]) === wanted || (wanted && Boolean(doubtful[n - 1]) !== Boolean(doubtful[n])) || (wanted && Boolean(doubtful[n + 1]) !== Boolean(doubtful[n])) ? y : null)),
  });
  return [piece(true, { dash: "dotted", label: "an assumption is doubtful" }), piece(false, { label: "no assumption is doubtful" })];
}
