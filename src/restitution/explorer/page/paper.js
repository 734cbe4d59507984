// The tab of the paper: its figures over the three numbers, with the present point, and its claims.
import { formula } from "./formula.js";
import { element } from "./elements.js";
import { instantaneousPoissonRatio } from "./interpolant.js";
import { logspace, planePicture } from "./map.js";
import { Panel } from "./panel.js";
import { digits } from "./units.js";

const FINE = 161;

export class PaperTab {
  constructor(root, app) {
    this.app = app;
    const pick = (p2, p3, done) => app.goTo(p2, p3, done);
    this.maps = ["3", "4"].map((name) => new Panel({ name: `figure-${name}`, title: `Figure ${name}`, onPick: pick }));
    this.lines = ["5", "6"].map((name) => new Panel({ name: `figure-${name}`, title: `Figure ${name}`, onPick: (p3, e, done) => app.goTo(this.p2[name], p3, done) }));
    this.present = element("section", { className: "card present" });
    this.claims = element("section", { className: "card claims" });
    root.append(this.present, element("div", { className: "grid" }, ...[...this.maps, ...this.lines].map((panel) => panel.root), this.claims));
    this.p2 = { 5: 1e-2, 6: 1e-3 };
  }

  // The answer of kind "paper" is asked for once.
  receive(answer) {
    this.answer = answer;
    for (const name of ["5", "6"]) this.p2[name] = answer.figures[name].p2;
    this.claims.replaceChildren(element("h3", {}, "Claims of the paper"),
      element("ol", {}, ...answer.claims.map((claim) => element("li", {},
        element("q", {}, ...formula(claim.statement)), element("p", {},
          element("span", { className: `sign ${claim.holds ? "ok" : "doubtful"}`, ariaHidden: "true" }, claim.holds ? "✓" : "!"),
          element("strong", {}, claim.holds ? " Confirmed. " : " Not confirmed. "), ...formula(claim.finding))))),
      element("p", { className: "note" }, "These are the numbers that \"restitution reproduce\" writes."),
      element("p", { className: "note" }, answer.references ?? ""));
    this.draw();
  }

  draw() {
    const { paper } = this.app;
    if (!paper || !this.answer) return;
    const { nu, p2, p3 } = this.app.numbers ?? {};
    const known = nu !== null && nu !== undefined && p2 !== null && p3 !== null;
    this.show(known, nu, p2, p3);
    const levels = this.answer.levels?.length ? this.answer.levels : undefined;
    const point = known ? [{ x: p2, y: p3, colour: "accent" }] : [];
    this.maps.forEach((panel, n) => {
      const own = this.answer.figures[["3", "4"][n]].nu;
      const words = own === 0.5 ? "in the incompressible limit, ν = 0.5" : `at ν = ${own}`;
      panel.heading.textContent = `Figure ${3 + n}: restitution coefficient ${words}`;
      const there = known ? paper.restitution(own, p2, p3) : NaN;
      panel.show({ ...planePicture(paper, own, point, levels),
        note: `${Number.isFinite(there) ? `At the present p₂ and p₃: e = ${digits(there)}, and the instantaneous Poisson ratio is `
          + `${digits(instantaneousPoissonRatio(own, p2), 3)}. ` : ""}Press a place to go there.`,
        summary: Number.isFinite(there) ? `At the present p₂ and p₃ e is ${digits(there)}.` : "" });
    });
    this.lines.forEach((panel, n) => this.curves(panel, ["5", "6"][n], known, nu, p3));
  }

  curves(panel, name, known, nu, p3) {
    const { paper } = this.app;
    const p2 = this.p2[name];
    panel.heading.textContent = `Figure ${name}: restitution coefficient over p₃ at p₂ = ${p2}`;
    const fine = logspace(paper.about.p3, FINE);
    const ratios = this.answer.poisson_ratios;
    const curve = (ratio, style) => ({ x: fine, y: Float64Array.from(fine, (one) => paper.restitution(ratio, p2, one)), ...style });
    const curves = ratios.map((ratio) => {
      const glass = instantaneousPoissonRatio(ratio, p2);
      return curve(ratio, { colour: "pinned", width: glass < 0 ? 1 : 2, dash: glass < 0 ? "dashed" : "solid",
        letter: String(ratio).replace("-", "−"), apart: true });
    });
    if (known) curves.push(curve(nu, { width: 2.6, label: `the present ν = ${digits(nu, 4)} (instantaneous ${digits(instantaneousPoissonRatio(nu, p2), 3)})` }));
    const e = known ? paper.restitution(nu, p2, p3) : NaN;
    panel.show({ curves, marks: Number.isFinite(e) ? [{ x: p3, y: e, colour: "accent" }] : [],
      x: { label: "p₃", log: true }, y: { label: "e" },
      ranges: { x: paper.about.p3, y: [0, 1] },
      note: "The numbers at the curves are Poisson ratios. Dashed: the instantaneous Poisson ratio is negative.",
      columns: [{ name: "p3", unit: "", values: [...fine] }, ...curves.map((one, n) => ({ name: `e at nu = ${ratios[n] ?? nu}`, unit: "", values: [...one.y] }))],
      summary: Number.isFinite(e) ? `At p₃ = ${digits(p3, 3)} e is ${digits(e)}.` : "" });
  }

  show(known, nu, p2, p3) {
    const { app } = this;
    const parts = [element("h3", {}, "The present point")];
    if (known) {
      const e = app.numbers.restitution_coefficient;
      const limit = app.paper.restitution(0.5, p2, p3);
      const glass = instantaneousPoissonRatio(nu, p2);
      parts.push(element("p", {}, `ν = ${digits(nu, 4)}, p₂ = ${digits(p2, 3)}, p₃ = ${digits(p3, 3)}: the restitution coefficient is ${digits(e)}`
        + `${Number.isFinite(limit) ? `, and ${digits(limit)} in the incompressible limit` : ""}. `
        + `The instantaneous Poisson ratio is ${digits(glass, 3)}${glass < 0 ? "; no polymer is known to have a negative one." : "."}`));
      if (!Number.isFinite(app.paper.restitution(nu, p2, p3))) parts.push(element("p", { className: "note" }, "The point lies outside the plane of the figures."));
    } else parts.push(element("p", {}, "The figures are those of a standard solid under a round body. The present setting is another one."));
    if (app.state.get("entry") !== "groups" || !known) {
      const button = element("button", { type: "button" }, "Use the paper's three numbers");
      button.addEventListener("click", () => app.useGroups());
      parts.push(button);
    }
    const key = parts.map((one) => one.textContent).join("|");
    if (key === this.shown) return;
    this.shown = key;
    this.present.replaceChildren(...parts);
  }
}
