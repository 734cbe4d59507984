// The tab of a ball that bounces to rest.
import { picture } from "./curves.js";
import { element, sentence } from "./inputs.js";
import { Numbers } from "./numbers.js";
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
    this.note = element("ul", { className: "card notes" });
    root.append(element("div", { className: "grid" }, this.flight.root, this.series.root, this.heights.root, this.note));
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
    this.series.show({ ...dots(picture(sets("bounces"), "bounce", [{ name: "restitution_coefficient" }], outputs)), ranges: { x, y: [0, 1] } });
    this.heights.show(dots(picture(sets("bounces"), "bounce", [{ name: "height" }], outputs, { yLog: true, words: "height" })));
    const words = [answer.status.message, ...(answer.warnings ?? [])].filter(Boolean);
    this.note.replaceChildren(...words.map((one) => element("li", {}, sentence(one))));
    this.note.hidden = !words.length;
  }
}
