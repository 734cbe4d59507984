"""Bouncing balls in the N-body code REBOUND with e(v) of this package, compared with `rs.bounces`.

Install REBOUND beside this package with `pip install rebound` (written for version 5.2) and run as
`python validation/rebound_spheres.py`; prints tables and writes them to `rebound_spheres.md` beside this file. Takes
half a minute.
"""

from __future__ import annotations

import math
import sys
from functools import cache
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

import restitution as rs

if Path(__file__).parent == Path(sys.path[0]).resolve():
    # This file has the name of the module that it imports.
    sys.path.pop(0)

RADIUS, DENSITY, GRAVITY, HEIGHT = 0.01, 1200.0, 9.81, 0.5
RUBBER = rs.standard_solid(1e6, 1e6, 1e2, poisson_ratio=0.45, density=DENSITY)
BALL, WALL = rs.Body(RUBBER, radius=RADIUS), rs.Body(None)
STEP = 2e-6
"""Time step [s]; collisions are found at the end of one."""

INTRODUCTION = """\
# The N-body code REBOUND: instantaneous collisions

Made by `validation/rebound_spheres.py` with REBOUND {version}. Its spheres are hard and their collisions take no time.
A function of the user gives e for the impact velocity, here `rs.solve`. A rubber ball (R = {radius:g} m,
{density:g} kg/m^3, Ginf = G1 = 1 MPa, eta = 100 Pa s, nu = 0.45) falls {height:g} m onto a rigid wall.
"""

BOUNCES = """
## A dropped ball

The table compares the heights and times of the touches from three sources. REBOUND has a time step of {step:g} s
and finds a collision at the end of the step in which spheres overlap. The parabolas are those of a hard ball with
the same e(v). In `rs.bounces` the weight acts during the contact, contacts have a duration, and flights begin below
the surface.

{table}

REBOUND and the parabolas agree within the error of a time step. The soft ball of `rs.bounces` rises less, because
it starts from its imprint and because of its weight. It is later by the contact times, minus the time that its
lower flights save. The hard ball bounces for ever, and its e tends to 1 as the velocity decreases. The soft ball
rests after {count} touches: {ended}.
"""

PAIR = """
## Two balls

A ball of R = {radius:g} m collides head on with a ball of half its size at rest. Both are of the rubber above. The
table compares the velocities [m/s] after the collision: by REBOUND with e of `rs.collision`, and by the impulse of
the contact force over time from `result.sample`.

{table}
"""


class Touches(NamedTuple):
    """Times [s] of the touches and the largest height [m] after each."""

    times: Any
    heights: Any


@cache
def rebound_module() -> Any:
    """The package REBOUND; ends the script with one line if it is absent."""
    try:
        import rebound
    except ImportError as error:
        sys.exit(f"REBOUND is absent ({error}): pip install rebound")
    return rebound


@cache
def restitution(velocity: float) -> float:
    """Return e of the ball on the wall, without its weight."""
    return float(rs.solve(rs.collision(BALL, WALL, velocity=velocity)).restitution_coefficient)


def by_rebound(count: int) -> Touches:
    """The first touches of the dropped ball in REBOUND."""
    simulation = rebound_module().Simulation()
    simulation.gravity, simulation.integrator, simulation.dt = "none", "leapfrog", STEP
    simulation.collision, simulation.collision_resolve = "direct", "hardsphere"
    simulation.add(m=1e12, r=1.0, z=-1.0)
    simulation.add(m=BALL.mass, r=RADIUS, z=RADIUS + HEIGHT)
    touches: list[float] = []

    def weight(pointer: Any) -> None:
        pointer.contents.particles[1].az -= GRAVITY

    def returned(pointer: Any, velocity: float) -> float:
        touches.append(pointer.contents.t)
        return restitution(abs(velocity))

    simulation.additional_forces = weight
    simulation.coefficient_of_restitution = returned
    heights: list[float] = []
    ball = simulation.particles[1]
    while len(heights) < count:
        before = len(touches)
        simulation.steps(1)
        if len(touches) > before:
            # The ball flies freely from here on.
            heights.append(ball.z - RADIUS + ball.vz**2 / (2.0 * GRAVITY))
    return Touches(np.array(touches), np.array(heights))


def by_hand(count: int) -> Touches:
    """The touches of a hard ball: parabolas between them."""
    velocity = math.sqrt(2.0 * GRAVITY * HEIGHT)
    times, heights = [velocity / GRAVITY], []
    for _ in range(count):
        velocity *= restitution(velocity)
        heights.append(velocity**2 / (2.0 * GRAVITY))
        times.append(times[-1] + 2.0 * velocity / GRAVITY)
    return Touches(np.array(times[:count]), np.array(heights))


def bounce_table(soft: rs.Bounces, count: int) -> str:
    """Lines of the table of a dropped ball."""
    hard, engine = by_hand(count), by_rebound(count)
    lines = [
        "| touch | REBOUND: time | height | parabolas: time | height | rs.bounces: time | height | "
        "later by | contact times so far |",
        "|---|---|---|---|---|---|---|---|---|",
    ]
    passed = np.concatenate([[0.0], np.cumsum(soft.contact_time)])
    for n in range(count):
        lines.append(
            f"| {n + 1} | {engine.times[n]:.6f} | {engine.heights[n]:.6f} | {hard.times[n]:.6f} | "
            f"{hard.heights[n]:.6f} "
            f"| {soft.touch_time[n]:.6f} | {soft.height[n]:.6f} | {soft.touch_time[n] - hard.times[n]:.6f} "
            f"| {passed[n]:.6f} |"
        )
        print(lines[-1], flush=True)
    return "\n".join(lines)


def pair_table(velocities: list[float]) -> str:
    """Lines of the table of two balls."""
    small = rs.Body(RUBBER, radius=0.5 * RADIUS)
    lines = ["| impact velocity | e | REBOUND | | by the impulse | |", "|---|---|---|---|---|---|"]
    for velocity in velocities:
        result = rs.solve(rs.collision(BALL, small, velocity=velocity))
        simulation = rebound_module().Simulation()
        simulation.gravity, simulation.integrator, simulation.dt = "none", "leapfrog", 1e-6
        simulation.collision, simulation.collision_resolve = "direct", "hardsphere"
        simulation.add(m=BALL.mass, r=RADIUS, x=-RADIUS - 1e-7, vx=velocity)
        simulation.add(m=small.mass, r=small.radius, x=small.radius)
        simulation.coefficient_of_restitution = lambda _, v, e=result.restitution_coefficient: e
        simulation.integrate(1e-3)
        velocities = [particle.vx for particle in simulation.particles]
        # Gauss's rule on many pieces, because the force has a root at both ends.
        edges = result.contact_time * 0.5 * (1.0 - np.cos(np.linspace(0.0, math.pi, 101)))
        nodes, weights = np.polynomial.legendre.leggauss(8)
        times = edges[:-1, None] + np.diff(edges)[:, None] * (0.5 + 0.5 * nodes)
        force = result.sample(times.ravel()).force.values.reshape(times.shape)
        impulse = float(np.sum(0.5 * np.diff(edges)[:, None] * weights * force))
        expected = [velocity - impulse / BALL.mass, impulse / small.mass]
        lines.append(
            f"| {velocity:g} | {result.restitution_coefficient:.9f} | {velocities[0]:.9f} | {velocities[1]:.9f} "
            f"| {expected[0]:.9f} | {expected[1]:.9f} |"
        )
        print(lines[-1], flush=True)
    return "\n".join(lines)


def main() -> None:
    """Write `rebound_spheres.md`."""
    soft = rs.bounces(rs.drop(BALL, WALL, height=HEIGHT, gravity=GRAVITY), gravity=GRAVITY)
    text = [
        INTRODUCTION.format(
            version=rebound_module().__version__, radius=RADIUS, density=DENSITY, height=HEIGHT
        ),
        BOUNCES.format(
            step=STEP, table=bounce_table(soft, 10),
            count=soft.n_bounces, ended=soft.ended.message,
        ),
        PAIR.format(radius=RADIUS, table=pair_table([0.01, 0.1, 1.0])),
    ]  # fmt: skip
    Path(__file__).with_suffix(".md").write_text("".join(text), encoding="utf-8")


if __name__ == "__main__":
    main()
