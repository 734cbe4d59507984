// Answers without a server: the paper's standard solid from the shipped interpolant.
import { groups, instantaneousPoissonRatio } from "./interpolant.js";
import { logspace } from "./map.js";
import { digits } from "./units.js";

const SHOWN = new Set(["impact", "velocity"]);

export class LocalAnswers {
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
    const material = Object.fromEntries(["equilibrium_modulus", "branch_modulus", "viscosity", "poisson_ratio"].map((name) => [name, state[`material.${name}`]]));
    const { nu, p2, p3 } = state.entry === "groups"
      ? { nu: state["groups.nu"], p2: state["groups.p2"], p3: state["groups.p3"] }
      : groups({ ...material, mass, radius: state["body.radius"], velocity });
    return { nu, p2, p3, restitution_coefficient: this.paper.restitution(nu, p2, p3), instantaneous_poisson_ratio: instantaneousPoissonRatio(nu, p2) };
  }

  impact(state) {
    const numbers = this.numbers(state);
    if (Number.isFinite(numbers.restitution_coefficient)) return { ok: true, numbers };
    const names = ["nu", "p2", "p3"];
    const words = names.map((name) => `${name} = ${digits(numbers[name], 3)}`).join(", ");
    const ranges = names.map((name) => this.paper.about[name].map((end) => Number(end.toPrecision(3))).join(" to ")).join(", ");
    return { ok: false, error: `${words} lie outside the plane of the paper (${ranges}); the program itself has no limits of p2 and p3`, field: null };
  }

  // p3 grows as the fifth root of the velocity.
  velocity(state) {
    const { nu, p2, p3 } = this.numbers(state);
    const { low, high } = this.schema.inputs.find((input) => input.key === "impact.velocity");
    const velocity = [...logspace([low, high], 64)];
    const e = velocity.map((speed) => {
      const value = this.paper.restitution(nu, p2, p3 * (speed / state["impact.velocity"]) ** 0.2);
      return Number.isFinite(value) ? value : null;
    });
    return { ok: true, curves: { velocity: { velocity, restitution_coefficient: e } } };
  }
}
