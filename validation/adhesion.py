"""Adhesive impacts beside closed forms, and by boundary elements in time, which use no Abel transform.

`python validation/adhesion.py` prints the tables of validation/adhesion.md. It takes some ten minutes. In the boundary
elements the attraction is a uniform stress on the disc whose gap is below the range, the contact follows from
complementarity for each ring, and the memory is that of displacements of the surface. Nothing of this is in the
package.
"""

from __future__ import annotations

import math
import sys
import time
from typing import Any

import numpy as np
from boundary_elements import disc, pressures, rings

import restitution as rs
from restitution.contact.adhesion import maugis_number
from restitution.impact.dugdale import Problem, scales
from restitution.indentation.attraction import Sticky
from restitution.indentation.solid import compliance_of

STANDARD = rs.PronySeries(1.0, [4.0], [1.0])
# Reduced modulus, work of adhesion, stress and velocity of unit balls; e where a prototype with fixed steps has it.
ROWS = (
    ("A0", STANDARD, 1e-6, 0.001, 1.0, 0.628797),
    ("A7", STANDARD, 0.02, 0.1, 0.5, 0.246534),
    ("A1", STANDARD, 0.02, 0.3, 0.5, 0.32045),
    ("A8", STANDARD, 0.02, 0.8, 0.5, 0.2795),
    ("A2", STANDARD, 0.05, 1.0, 1.0, 0.3707),
    ("A6", rs.PronySeries(1.0, [], []), 0.01, 0.157768, 0.1217, 0.9412),
)
JKR_LOSS = 7.0921960


def impact(modulus: rs.PronySeries, work: float, stress: float, velocity: float) -> rs.Impact:
    """Return the impact of a rigid unit ball of unit mass on a half-space with this reduced modulus."""
    shear = rs.PronySeries(0.25 * modulus.equilibrium_modulus, 0.25 * modulus.branch_moduli, modulus.relaxation_times)
    material = rs.Material(shear, bulk=math.inf)
    return rs.Impact(material, rs.Parabola(1.0), 1.0, velocity, adhesion=rs.Adhesion(work, stress))


def by_rings(
    modulus: rs.PronySeries, work: float, stress: float, velocity: float, radius: float, count: int, steps: int
) -> float:
    """Return e by boundary elements; `steps` in each unit of time."""
    soft, weights, rates = compliance_of(modulus)
    surface, dt, reach = rings(count, radius), 1.0 / steps, work / stress
    r, width = surface.middles, radius / count
    z = rates * dt
    fade, mean = np.exp(-z), -np.expm1(-z) / z
    rise, fall = dt * (1.0 - mean) / z, dt * (mean - fade) / z
    firm = soft + float(weights @ rise)
    memory, before = np.zeros((rates.size, count)), np.zeros(count)
    touches = np.zeros(count, dtype=bool)
    depth, speed, force, edge = -reach, velocity, 0.0, 0.0

    def state(c: float) -> tuple[float, Any, Any]:
        """Return the gap at the edge over the range, the pressures, and where the contact is."""
        pull = stress * disc(r, c) if c > 0.0 else np.zeros(count)
        lift = rest - depth + 0.5 * r * r - firm * pull
        p, contact = pressures(firm * surface.influence, lift, touches)
        own = disc(np.array([c]), surface.edges[1:]) - np.append(0.0, disc(np.array([c]), surface.edges[1:-1]))
        there = firm * (float(own @ p) - stress * (4.0 / math.pi) * c) + float(np.interp(c, r, rest))
        return there - depth + 0.5 * c * c - reach, p, contact

    for n in range(40 * steps):
        depth += dt * speed - 0.5 * dt * dt * force
        rest = weights @ (fade[:, None] * memory + fall[:, None] * before) if rates.size else np.zeros(count)
        way = 1.0 if state(edge)[0] < 0.0 else -1.0
        low = edge
        while True:
            high = max(low + 0.5 * way * width, 0.0)
            if way * state(high)[0] >= 0.0 or high == 0.0:
                break
            low = high
        for _ in range(24):
            middle = 0.5 * (low + high)
            low, high = (middle, high) if way * state(middle)[0] < 0.0 else (low, middle)
        edge = high
        _, p, touches = state(edge)
        after = surface.influence @ p - (stress * disc(r, edge) if edge > 0.0 else 0.0)
        memory = fade[:, None] * memory + fall[:, None] * before + rise[:, None] * after
        before = after
        new = float(surface.areas @ p) - math.pi * stress * edge * edge
        speed -= 0.5 * dt * (force + new)
        force = new
        if edge == 0.0 and speed < 0.0 and n > 10:
            return -speed / velocity
    raise RuntimeError("the body did not leave")


def rows() -> None:
    """Print e of the rows for each number of elements, its extrapolation, and the time."""
    print(
        "| row | prototype | 100 | 200 | 400 | 800 | e at rtol 1e-6 | estimated error | energy residual | time [ms] |"
    )
    print("|---|---|---|---|---|---|---|---|---|---|")
    for name, modulus, work, stress, velocity, known in ROWS:
        problem = Problem(Sticky(rs.Parabola(1.0), modulus, rs.Adhesion(work, stress)), 1.0, velocity)
        width, duration = scales(problem)
        ends = (problem.march(width, duration, count).motion[-1, 2] for count in (100, 200, 400, 800))
        each = [-speed / velocity for speed in ends]
        start = time.process_time()
        result = rs.solve(impact(modulus, work, stress, velocity))
        spent = 1e3 * (time.process_time() - start)
        cells = [f"{e:.6f}" for e in each]
        e, error = float(result.restitution_coefficient), float(result.restitution_error)
        residual = float(result.energy.residual)
        print(f"| {name} | {known} | {' | '.join(cells)} | {e:.8f} | {error:.0e} | {residual:.0e} | {spent:.0f} |")


def boundary_elements() -> None:
    """Print e by boundary elements with more and more rings."""
    print("| row | 50 rings | 100 | 200 | elements |")
    print("|---|---|---|---|---|")
    for (name, modulus, work, stress, velocity, _), radius in zip(ROWS[1:3], (1.1, 0.9), strict=True):
        each = [by_rings(modulus, work, stress, velocity, radius, count, 2 * count) for count in (50, 100, 200)]
        e = float(rs.solve(impact(modulus, work, stress, velocity)).restitution_coefficient)
        print(f"| {name} | {' | '.join(f'{value:.5f}' for value in each)} | {e:.6f} |", flush=True)


def limits() -> None:
    """Print the loss in jumps of elastic balls over Maugis' parameter."""
    print("| lambda | rtol | e | loss over (w^5 R^4/E*^2)^(1/3) | estimated error of e |")
    print("|---|---|---|---|---|")
    work = 0.01
    sticks = math.sqrt(2.0 * JKR_LOSS * work ** (5.0 / 3.0))
    for lam in (0.25, 0.5, 1.0, 2.0, 4.0, 8.0, 16.0):
        stress = lam / float(maugis_number(work, 1.0, 1.0, 1.0))
        rtol = 1e-5 if lam < 5.0 else 1e-4 if lam < 10.0 else 1e-3
        result = rs.solve(impact(rs.PronySeries(1.0, [], []), work, stress, 1.5 * sticks), rtol=rtol)
        loss, e = float(result.radiated_energy) / work ** (5.0 / 3.0), float(result.restitution_coefficient)
        print(f"| {lam:g} | {rtol:g} | {e:.5f} | {loss:.4f} | {float(result.restitution_error):.0e} |")
    print(f"| JKR | | {math.sqrt(1.0 - 1.0 / 1.5**2):.5f} | {JKR_LOSS:.4f} | |")


def main() -> int:
    """Print all tables."""
    rows()
    print()
    limits()
    print()
    boundary_elements()
    return 0


if __name__ == "__main__":
    sys.exit(main())
