// The tab of a ball that bounces to rest.
import { picture } from "./curves.js";
import { element } from "./elements.js";
import { Notes, Numbers } from "./numbers.js";
import { Panel } from "./panel.js";
import { phrase } from "./units.js";

export class BounceTab {
  constructor(root, app) {
    this.app = app;
    this.numbers = new Numbers(root, ["n_bounces", "drop_height", "total_time", "restitution_coefficient"], app.schema.outputs);
    this.flight = new Panel({ name: "flight", title: "Height over time" });
    this.flight.root.classList.add("wide");
    this.series = new Panel({ name: "bounces", title: "Restitution coefficient of each bounce" });
    this.heights = new Panel({ name: "heights", title: "Height after each bounce" });
    const grid = element("div", { className: "grid" }, this.flight.root, this.series.root, this.heights.root);
    root.append(grid);
    this.notes = new Notes(grid);
  }

  receive(answer) {
    this.answer = answer;
    const { outputs } = this.app.schema;
    const pinned = this.app.pins.of("bounces");
    const sets = (name) => [answer, ...pinned.map((pin) => pin.answer)].map((one, n) => ({ ...pinned[n - 1], table: one.curves[name] }));
    const first = answer.curves.bounces.restitution_coefficient[0];
    this.numbers.show({ ...answer.numbers, restitution_coefficient: first ?? null });
    const { n_bounces: count, total_time: time } = answer.numbers;
    this.flight.show({ ...picture(sets("flight"), "time", [{ name: "height" }], outputs, { xWords: "time", words: "height" }),
      summary: `${count} bounces in ${phrase(time, outputs.total_time)}.` });
    const most = Math.max(...sets("bounces").map(({ table }) => table.bounce.length));
    const x = [0.5, most + 0.5];
    const dots = (shown) => ({ ...shown, ranges: { x }, x: { ...shown.x, whole: true }, marks: shown.curves.filter((curve) => curve.colour === "accent").flatMap(({ x, y }) =>
      x.slice(0, 60).map((one, n) => ({ x: one, y: y[n], colour: "accent" })).filter((mark) => mark.y !== null)) });
    const series = dots(picture(sets("bounces"), "bounce", [{ name: "restitution_coefficient" }], outputs, { words: "e" }));
    // A bounce that ends the series by capture is a dot, and no part of the curve.
    for (const curve of series.curves) if (curve.y.at(-1) === 0) curve.y = curve.y.with(-1, null);
    this.series.show({ ...series, ranges: { x, y: [0, 1] } });
    this.heights.show(dots(picture(sets("bounces"), "bounce", [{ name: "height" }], outputs, { yLog: true, words: "height" })));
    this.notes.show(answer.warnings ?? [], [answer.status?.message, ...(answer.notes ?? [])]);
  }
}
