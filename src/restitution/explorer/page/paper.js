// The tab of the paper: its figures over the three numbers, with the present point, and its claims.
import { formula } from "./formula.js";
import { button, element } from "./elements.js";
import { instantaneousPoissonRatio } from "./interpolant.js";
import { logspace, planePicture } from "./map.js";
import { Panel } from "./panel.js";
import { digits } from "./units.js";

const FINE = 161;
const [PLANES, CURVES] = [["3", "4"], ["5", "6"]];

export class PaperTab {
  constructor(root, app) {
    this.app = app;
    const panel = (name, onPick, about) => new Panel({ name: `figure-${name}`, title: `Figure ${name}`, onPick, about });
    this.maps = PLANES.map((name) => panel(name, (p2, p3, done) => app.goTo(p2, p3, done),
      (p2, p3) => `e = ${digits(app.paper.restitution(this.answer.figures[name].nu, p2, p3))}`));
    this.lines = CURVES.map((name) => panel(name, (p3, e, done) => app.goTo(this.answer.figures[name].p2, p3, done)));
    this.present = element("section", { className: "card present" });
    this.claims = element("section", { className: "card claims" });
    root.append(this.present, element("div", { className: "grid" }, ...[...this.maps, ...this.lines].map((panel) => panel.root), this.claims));
  }

  // The answer of kind "paper" is asked for once.
  receive(answer) {
    this.answer = answer;
    const claim = ({ statement, holds, finding }) => element("li", {},
      element("q", {}, ...formula(statement)), element("p", {},
        element("span", { className: `sign ${holds ? "ok" : "doubtful"}`, ariaHidden: "true" }, holds ? "✓" : "!"),
        element("strong", {}, holds ? " Confirmed. " : " Not confirmed. "), ...formula(finding)));
    this.claims.replaceChildren(element("h3", {}, "Claims of the paper"), element("ol", {}, ...answer.claims.map(claim)),
      element("p", { className: "note" }, "These are the numbers that \"restitution reproduce\" writes."),
      element("p", { className: "note" }, answer.references ?? ""));
    this.draw();
  }

  draw() {
    const { paper, numbers } = this.app;
    if (!paper || !this.answer) return;
    // The present point; null where the setting is not that of the paper.
    const point = Number.isFinite(numbers?.p2) && numbers.p3 !== null ? { nu: numbers.nu, p2: numbers.p2, p3: numbers.p3 } : null;
    this.show(point);
    this.maps.forEach((panel, n) => this.plane(panel, PLANES[n], point));
    this.lines.forEach((panel, n) => this.curves(panel, CURVES[n], point));
  }

  plane(panel, name, point) {
    const { paper } = this.app;
    const { nu } = this.answer.figures[name];
    panel.heading.textContent = `Figure ${name}: restitution coefficient ${nu === 0.5 ? "in the incompressible limit, ν = 0.5" : `at ν = ${nu}`}`;
    const e = point ? paper.restitution(nu, point.p2, point.p3) : NaN;
    const there = Number.isFinite(e) ? `At the present p₂ and p₃: e = ${digits(e)}, and the instantaneous Poisson ratio is `
      + `${digits(instantaneousPoissonRatio(nu, point.p2), 3)}. ` : "";
    panel.show({ ...planePicture(paper, nu, point ? [{ x: point.p2, y: point.p3, colour: "accent" }] : [], this.answer.levels),
      note: `${there}Press a place to go there.`, summary: there && `At the present p₂ and p₃ e is ${digits(e)}.` });
  }

  curves(panel, name, point) {
    const { paper } = this.app;
    const { p2 } = this.answer.figures[name];
    panel.heading.textContent = `Figure ${name}: restitution coefficient over p₃ at p₂ = ${p2}`;
    const fine = logspace(paper.about.p3, FINE);
    const curve = (nu, style) => ({ nu, x: fine, y: Float64Array.from(fine, (p3) => paper.restitution(nu, p2, p3)), ...style });
    const curves = this.answer.poisson_ratios.map((nu) => {
      const negative = instantaneousPoissonRatio(nu, p2) < 0;
      return curve(nu, { colour: "pinned", width: negative ? 1 : 2, dash: negative ? "dashed" : "solid", letter: String(nu).replace("-", "−"), apart: true });
    });
    if (point) {
      const glass = digits(instantaneousPoissonRatio(point.nu, p2), 3);
      curves.push(curve(point.nu, { width: 2.6, label: `the present ν = ${digits(point.nu, 4)} (instantaneous ${glass})` }));
    }
    const e = point ? paper.restitution(point.nu, p2, point.p3) : NaN;
    panel.show({ curves, marks: Number.isFinite(e) ? [{ x: point.p3, y: e, colour: "accent" }] : [],
      x: { label: "p₃", symbol: "p₃", log: true }, y: { label: "e", symbol: "e" },
      ranges: { x: paper.about.p3, y: [0, 1] },
      note: "The numbers at the curves are Poisson ratios. Dashed: the instantaneous Poisson ratio is negative.",
      columns: [{ name: "p3", unit: "", values: [...fine] }, ...curves.map(({ nu, y }) => ({ name: `e at nu = ${nu}`, unit: "", values: [...y] }))],
      summary: Number.isFinite(e) ? `At p₃ = ${digits(point.p3, 3)} e is ${digits(e)}.` : "" });
  }

  show(point) {
    const { app } = this;
    const lines = [];
    if (point) {
      const { nu, p2, p3 } = point;
      const limit = app.paper.restitution(0.5, p2, p3);
      const glass = instantaneousPoissonRatio(nu, p2);
      lines.push(element("p", {}, `ν = ${digits(nu, 4)}, p₂ = ${digits(p2, 3)}, p₃ = ${digits(p3, 3)}: the restitution coefficient is ${digits(app.numbers.restitution_coefficient)}`
        + `${Number.isFinite(limit) ? `, and ${digits(limit)} in the incompressible limit` : ""}. `
        + `The instantaneous Poisson ratio is ${digits(glass, 3)}${glass < 0 ? "; no polymer is known to have a negative one." : "."}`));
      if (!Number.isFinite(app.paper.restitution(nu, p2, p3))) lines.push(element("p", { className: "note" }, "The point lies outside the plane of the figures."));
    } else lines.push(element("p", {}, "The figures are those of a standard solid under a round body. The present setting is another one."));
    if (app.state.get("entry") !== "groups" || !point) lines.push(button("Use the paper's three numbers", () => app.useGroups()));
    const words = lines.map(({ textContent }) => textContent).join("|");
    if (words === this.words) return;
    this.words = words;
    this.present.replaceChildren(element("h3", {}, "The present point"), ...lines);
  }
}
