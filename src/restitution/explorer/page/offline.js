// Answers without a server: the paper's standard solid from the shipped interpolant.
import { groups, instantaneousPoissonRatio } from "./interpolant.js";
import { logspace } from "./map.js";
import { digits } from "./units.js";

const SHOWN = new Set(["impact", "velocity"]);

export class Offline {
  constructor(schema, paper, claims, receive) {
    Object.assign(this, { schema, paper, claims, receive });
  }

  ask(kind, { state }, channel = "main") {
    const asked = { kind, state, channel };
    if (kind === "paper") this.receive({ kind, ok: true, ...this.claims }, asked);
    else if (SHOWN.has(kind)) this.receive({ kind, ...this[kind](state) }, asked);
  }

  numbers(state) {
    const mass = state.mass_from === "density" ? (state["body.density"] * 4 * Math.PI * state["body.radius"] ** 3) / 3 : state["body.mass"];
    const velocity = state["impact.velocity"];
    const own = state.entry === "groups"
      ? { nu: state["groups.nu"], p2: state["groups.p2"], p3: state["groups.p3"] }
      : groups({
        equilibrium_modulus: state["material.equilibrium_modulus"], branch_modulus: state["material.branch_modulus"], viscosity: state["material.viscosity"],
        poisson_ratio: state["material.poisson_ratio"], mass, radius: state["body.radius"], velocity,
      });
    const e = this.paper.restitution(own.nu, own.p2, own.p3);
    return { ...own, restitution_coefficient: e, poisson_ratio: own.nu, instantaneous_poisson_ratio: instantaneousPoissonRatio(own.nu, own.p2), rebound_velocity: e * velocity };
  }

  impact(state) {
    const numbers = this.numbers(state);
    if (Number.isFinite(numbers.restitution_coefficient)) return { ok: true, numbers };
    const [p2, p3] = ["p2", "p3"].map((name) => this.paper.about[name].map((one) => Number(one.toPrecision(3))).join(" to "));
    const words = `p2 = ${digits(numbers.p2, 3)} and p3 = ${digits(numbers.p3, 3)} lie outside the plane of the paper (${p2}, ${p3})`;
    return { ok: false, error: `${words}; the program itself has no such limit`, field: null };
  }

  // p3 grows as the fifth root of the velocity.
  velocity(state) {
    const { nu, p2, p3 } = this.numbers(state);
    const { low, high } = this.schema.inputs.find((input) => input.key === "impact.velocity");
    const velocity = [...logspace([low, high], 64)];
    const e = velocity.map((one) => {
      const found = this.paper.restitution(nu, p2, p3 * (one / state["impact.velocity"]) ** 0.2);
      return Number.isFinite(found) ? found : null;
    });
    return { ok: true, curves: { velocity: { velocity, restitution_coefficient: e } } };
  }
}
