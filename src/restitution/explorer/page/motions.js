// The tabs of a ball that bounces to rest, of a prescribed indentation, and of a cantilever that taps.
import { element } from "./elements.js";
import { Notes, Numbers } from "./numbers.js";
import { Panel, picture } from "./panel.js";
import { phrase } from "./units.js";

class MotionTab {
  // `panels` are the titles of the pictures by their names.
  constructor(root, app, tiles, panels) {
    this.app = app;
    this.numbers = new Numbers(root, tiles, app.schema.outputs);
    this.panels = Object.fromEntries(Object.entries(panels).map(([name, title]) => [name, new Panel({ name, title })]));
    const grid = element("div", { className: "grid" }, ...Object.values(this.panels).map((panel) => panel.root));
    root.append(grid);
    this.notes = new Notes(grid);
  }

  receive(answer) {
    // A table of curves of the present setting and of the pinned ones.
    const pins = this.app.pins.of(answer.kind);
    const sets = (name) => [{ answer }, ...pins].map((set) => ({ ...set, table: set.answer.curves[name] }));
    this.draw(answer, sets, this.app.schema.outputs);
    this.notes.show(answer.warnings ?? [], [answer.status?.message, ...(answer.notes ?? [])]);
  }
}

export class BounceTab extends MotionTab {
  constructor(root, app) {
    super(root, app, ["n_bounces", "drop_height", "total_time", "restitution_coefficient"],
      { flight: "Height over time", bounces: "Restitution coefficient of each bounce", heights: "Height after each bounce", spin: "Spin after each bounce", place: "Place of each touch" });
    this.panels.flight.root.classList.add("wide");
  }

  draw({ numbers, curves }, sets, outputs) {
    this.numbers.show({ ...numbers, restitution_coefficient: curves.bounces.restitution_coefficient[0] ?? null });
    this.panels.flight.show({ ...picture(sets("flight"), "time", [{ name: "height" }], outputs, { xWords: "time", words: "height" }),
      summary: `${numbers.n_bounces} bounces in ${phrase(numbers.total_time, outputs.total_time)}.` });
    const most = Math.max(...sets("bounces").map(({ table }) => table.bounce.length));
    const x = [0.5, most + 0.5];
    const dotted = (name, axes) => {
      const shown = picture(sets("bounces"), "bounce", [{ name }], outputs, axes);
      const present = shown.curves.filter(({ colour }) => colour === "accent");
      const marks = present.flatMap((curve) => curve.x.slice(0, 60).map((at, n) => ({ x: at, y: curve.y[n], colour: "accent" })));
      return { ...shown, ranges: { x }, x: { ...shown.x, whole: true }, marks: marks.filter(({ y }) => y !== null) };
    };
    const series = dotted("restitution_coefficient", { words: "e" });
    // A bounce that ends the series by capture is a dot, and no part of the curve.
    for (const curve of series.curves) if (curve.y.at(-1) === 0) curve.y = curve.y.with(-1, null);
    // The imprint of earlier bounces may push a slow ball off.
    const top = Math.max(1, ...series.curves.flatMap(({ y }) => y));
    this.panels.bounces.show({ ...series, ranges: { x, y: [0, top] } });
    this.panels.heights.show(dotted("height", { yLog: true, words: "height" }));
    // Friction moves the body sideways, and turns it.
    const turns = Boolean(curves.bounces.rebound_spin);
    for (const name of ["spin", "place"]) this.panels[name].root.hidden = !turns;
    if (!turns) return;
    this.panels.spin.show(dotted("rebound_spin"));
    this.panels.place.show(dotted("place"));
  }
}

// A triangle, cycles or a hold, as an atomic force microscope makes it.
export class IndentationTab extends MotionTab {
  constructor(root, app) {
    super(root, app, ["max_force", "max_indentation_depth", "max_contact_radius", "residual_indentation_depth", "contact_end_time", "work", "dissipated"],
      { "force-depth": "Force over depth", "force-time": "Force over time", "depth-time": "Depth over time", "radius-time": "Contact radius over time" });
  }

  draw({ numbers, curves }, sets, outputs) {
    this.numbers.show(numbers);
    const words = (name) => phrase(numbers[name], outputs[name]);
    const show = (panel, x, name, summary, axes) =>
      this.panels[panel].show({ ...picture(sets("history"), x, [{ name }], outputs, axes), summary });
    const force = `The largest force is ${words("max_force")}`;
    show("force-depth", "indentation_depth", "force", `${force} at a depth of up to ${words("max_indentation_depth")}.`, { xRoom: true });
    show("force-time", "time", "force", `${force}.`);
    show("depth-time", "time", "indentation_depth", `The depth at separation is ${words("residual_indentation_depth")}.`);
    show("radius-time", "time", "contact_radius", "");
    this.panels["radius-time"].root.hidden = curves.history.contact_radius.every((radius) => radius === null);
  }
}

const FORCES = [
  { name: "max_force", label: "largest", colour: "accent" },
  { name: "mean_force", label: "mean", colour: "second", dash: "dashed" },
];

const MODE_STYLES = [{ colour: "accent" }, { colour: "second", dash: "dashed" }, { colour: "second", dash: "dotted" }];

// A cantilever over the distance of its rest from the surface, in steady taps.
export class TappingTab extends MotionTab {
  constructor(root, app) {
    super(root, app, ["amplitude", "phase", "max_force", "loss_per_tap", "contact_share", "max_indentation_depth"],
      { amplitude: "Amplitude over distance", phase: "Phase over distance", forces: "Force over distance", loss: "Loss per tap over distance",
        modes: "Way of the higher modes over distance" });
  }

  draw({ numbers, curves }, sets, outputs) {
    this.numbers.show(numbers);
    const show = (panel, ys, words) => this.panels[panel].show({
      ...picture(sets("tapping"), "distance", ys, outputs, { xRoom: true, words }),
      summary: `At the smallest distance: ${ys.map(({ name }) => phrase(numbers[name], outputs[name])).join(", ")}.`,
    });
    show("amplitude", [{ name: "amplitude" }]);
    show("phase", [{ name: "phase" }]);
    show("forces", FORCES, "force");
    show("loss", [{ name: "loss_per_tap" }]);
    const higher = Object.keys(curves.tapping).filter((name) => name.startsWith("mode_swing_"));
    this.panels.modes.root.hidden = !higher.length;
    if (higher.length) show("modes", higher.map((name, n) => ({ name, label: `mode ${n + 2}`, ...MODE_STYLES[n % MODE_STYLES.length] })), "half of the way");
  }
}
