// Measured restitution coefficients over velocity. The address has them, as "velocity_e_deviation velocity_e ...".
import { interpolate } from "./ball.js";
import { button, element } from "./elements.js";
import { convert, digits } from "./units.js";

// A curve of fewer points is no measure of the distance.
const FEWEST = 20;

export const pointsText = (rows) => rows.map((row) => row.map((value) => Number(value.toPrecision(6))).join("_")).join(" ");

const rowsOf = (text) => (text ?? "").split(" ").map((row) => row.split("_").map(Number))
  .filter(([velocity, e, deviation = 0]) => velocity > 0 && e >= 0 && deviation >= 0 && Number.isFinite(velocity * e * deviation));

export class Measured {
  constructor(state) {
    this.state = state;
    this.words = element("span");
    this.remove = button("Remove", () => state.set({ "page.points": "" }, true));
    this.root = element("p", { className: "note live" }, this.words, " ", this.remove);
  }

  get rows() {
    return rowsOf(this.state.get("page.points"));
  }

  // The marks of a picture over velocity, in a unit, and the columns of its file.
  marks(unit) {
    return this.rows.map(([velocity, y, spread]) => ({ x: convert(velocity, unit), y, spread, symbol: "e", colour: "second", size: 0.65 }));
  }

  columns() {
    const { rows } = this;
    return rows.length ? [{ name: "measured velocity", unit: "m/s", values: rows.map(([velocity]) => velocity) },
      { name: "measured restitution_coefficient", unit: "", values: rows.map(([, e]) => e) }] : [];
  }

  // How far the computed curve {velocity, restitution_coefficient} is from the points.
  show(curve) {
    const { rows } = this;
    const speeds = curve?.velocity ?? [];
    const logs = speeds.map(Math.log);
    const within = rows.filter(([velocity]) => velocity >= speeds[0] && velocity <= speeds.at(-1));
    const misses = within.map(([velocity, e]) => interpolate(logs, curve.restitution_coefficient, Math.log(velocity)) - e);
    const size = Math.sqrt(misses.reduce((sum, miss) => sum + miss ** 2, 0) / misses.length);
    const beyond = rows.length - within.length;
    const distance = misses.length && speeds.length >= FEWEST && Number.isFinite(size)
      ? `; the root mean square of computed minus measured e is about ${digits(size, 2)}${beyond ? `, without ${beyond} beyond the curve` : ""}` : "";
    const words = rows.length ? `${rows.length} measured point${rows.length > 1 ? "s" : ""}${distance}.`
      : "Drop, open or paste a table of velocity and e to see your own points here.";
    if (words !== this.words.textContent) this.words.textContent = words;
    this.remove.hidden = !rows.length;
  }
}
