"""Adhesive impacts beside closed forms, a second program, and boundary elements in time without an Abel transform.

`python validation/adhesion.py` prints the tables of validation/adhesion.md. It takes some ten minutes. With
`--random 10000` it solves so many random impacts instead and prints what became of them; with `--second` it prints
the table of the second program alone, `tests/adhesive_elements.py`.

In the boundary elements the attraction is a uniform stress on the disc whose gap is below the range, the contact
follows from complementarity for each ring, and the memory is that of displacements of the surface. Nothing of this is
in the package.
"""

from __future__ import annotations

import argparse
import math
import sys
import time
import warnings
from collections import Counter
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
from boundary_elements import disc, pressures, rings
from numpy.polynomial import chebyshev
from scipy.optimize import brentq, minimize_scalar

import restitution as rs
from restitution.contact.adhesion import Static, maugis_number, static_contact
from restitution.impact.dugdale import Problem, scales
from restitution.impact.status import Status
from restitution.indentation.attraction import Sticky
from restitution.indentation.solid import compliance_of

sys.path.append(str(Path(__file__).resolve().parents[1] / "tests"))
from adhesive_elements import adhesive_restitution

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
# Reduced modulus, work of adhesion, stress and velocity of unit balls that a second program solves too.
SECOND = (
    ("A7", STANDARD, 0.02, 0.1, 0.5),
    ("A1", STANDARD, 0.02, 0.3, 0.5),
    ("A8", STANDARD, 0.02, 0.8, 0.5),
    ("A2", STANDARD, 0.05, 1.0, 1.0),
    ("thin", STANDARD, 0.02, 2.11161, 0.8),
    ("fast", rs.PronySeries(1.0, [4.0], [0.03]), 0.02, 0.5, 0.8),
    ("three terms", rs.PronySeries(0.5, [2.0, 1.0, 0.5], [3.0, 0.3, 0.05]), 0.01, 0.25, 0.6),
    ("liquid", rs.PronySeries(0.0, [3.0, 1.0], [1.0, 10.0]), 0.01, 0.3, 0.5),
    ("slow", rs.PronySeries(1.0, [1.0], [4.0]), 0.01, 0.8, 0.4),
    ("elastic", rs.PronySeries(1.0, [], []), 0.01, 0.05, 0.15),
    ("A6", rs.PronySeries(1.0, [], []), 0.01, 0.157768, 0.1217),
)


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
        weights = disc(np.array([c]), surface.edges[1:]) - np.append(0.0, disc(np.array([c]), surface.edges[1:-1]))
        there = firm * (float(weights @ p) - stress * (4.0 / math.pi) * c) + float(np.interp(c, r, rest))
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
    for name, modulus, work, stress, velocity, prototype in ROWS:
        problem = Problem(Sticky(rs.Parabola(1.0), modulus, rs.Adhesion(work, stress)), 1.0, velocity)
        width, duration = scales(problem)
        ends = (problem.march(width, duration, count).motion[-1, 2] for count in (100, 200, 400, 800))
        each = [-speed / velocity for speed in ends]
        rs.solve(impact(modulus, work, stress, velocity))
        start = time.process_time()
        result = rs.solve(impact(modulus, work, stress, velocity))
        spent = 1e3 * (time.process_time() - start)
        cells = [f"{e:.6f}" for e in each]
        e, error = float(result.restitution_coefficient), float(result.restitution_error)
        residual = float(result.energy.residual)
        print(f"| {name} | {prototype} | {' | '.join(cells)} | {e:.8f} | {error:.0e} | {residual:.0e} | {spent:.0f} |")


def second_program() -> None:
    """Print e by a second program and by marches of many elements, each of them extrapolated, and by `solve`."""
    print("| row | lambda at rest, at once | jumps | second program | marches | difference | `solve` at 1e-6 |")
    print("|---|---|---|---|---|---|---|")
    for name, modulus, work, stress, velocity in SECOND:
        problem = Problem(Sticky(rs.Parabola(1.0), modulus, rs.Adhesion(work, stress)), 1.0, velocity)
        width, duration = scales(problem)
        ours = [-problem.march(width, duration, count).motion[-1, 2] / velocity for count in (6400, 12800)]
        solid = modulus.equilibrium_modulus, modulus.branch_moduli, modulus.relaxation_times
        others = [
            adhesive_restitution(solid, work, stress, velocity, width=1.3 * width, elements=count)
            for count in (3200, 6400)
        ]
        march, other = ((4.0 * fine - rough) / 3.0 for rough, fine in (ours, [e for e, _ in others]))
        result = rs.solve(impact(modulus, work, stress, velocity))
        static, glass = (float(value) for value in result.maugis_numbers)
        print(
            f"| {name} | {static:.2f}, {glass:.2f} | {len(result.jumps)}, {others[1][1]} | {other:.8f} | {march:.8f} "
            f"| {other - march:.0e} | {float(result.restitution_coefficient) - other:.0e} |",
            flush=True,
        )


def boundary_elements() -> None:
    """Print e by boundary elements with more and more rings."""
    print("| row | 50 rings | 100 | 200 | elements |")
    print("|---|---|---|---|---|")
    for (name, modulus, work, stress, velocity, _), radius in zip(ROWS[1:3], (1.1, 0.9), strict=True):
        each = [by_rings(modulus, work, stress, velocity, radius, count, 2 * count) for count in (50, 100, 200)]
        e = float(rs.solve(impact(modulus, work, stress, velocity)).restitution_coefficient)
        print(f"| {name} | {' | '.join(f'{value:.5f}' for value in each)} | {e:.6f} |", flush=True)


def static_loss(lam: float, work: float = 0.01) -> float:
    """Return the loss of an elastic ball in jumps over (w^5 R^4/E*^2)^(1/3) by quadrature, for lambda of 2 and more.

    The ball jumps in at the depth -h0, and out where the depth of the static contact is least. The loss is the work of
    the pull between both, of Maugis' closed forms.
    """
    stress = lam / float(maugis_number(work, 1.0, 1.0, 1.0))
    adhesion, unit = rs.Adhesion(work, stress), work ** (1.0 / 3.0)

    def at(radius: float) -> Static:
        return static_contact(rs.Parabola(1.0), 1.0, adhesion, radius)

    highest: Any = minimize_scalar(
        lambda a: at(a).depth, bounds=(0.3 * unit, 2.0 * unit), method="bounded", options={"xatol": 1e-12}
    )
    out = float(highest.x)
    into: Any = brentq(lambda a: at(a).depth + work / stress, out, 4.0 * unit, xtol=1e-15)
    places = chebyshev.chebpts2(32)
    states = [at(out + 0.5 * (into - out) * (x + 1.0)) for x in places]
    depth, force = (
        chebyshev.Chebyshev.fit(places, [getattr(state, name) for state in states], 31, domain=[-1.0, 1.0])
        for name in ("depth", "force")
    )
    pull = (force * depth.deriv()).integ()
    return float(pull(-1.0) - pull(1.0)) / work ** (5.0 / 3.0)


def extrapolated_loss() -> float:
    """Return the loss in the limit of JKR: errors are powers of 1/lambda."""
    losses = [static_loss(100.0 * 2.0**n) for n in range(5)]
    for power in range(1, 5):
        share = 2.0**power
        losses = [(share * after - before) / (share - 1.0) for before, after in pairwise(losses)]
    return losses[0]


def limits() -> None:
    """Print the loss in jumps of elastic balls over Maugis' parameter, by the march and by quadrature."""
    print("| lambda | rtol | e | loss over (w^5 R^4/E*^2)^(1/3) | by quadrature | estimated error of e |")
    print("|---|---|---|---|---|---|")
    work = 0.01
    sticks = math.sqrt(2.0 * JKR_LOSS * work ** (5.0 / 3.0))
    for lam in (0.25, 0.5, 1.0, 2.0, 4.0, 8.0, 16.0, 30.0, 100.0, 300.0, 1000.0):
        stress, rtol = lam / float(maugis_number(work, 1.0, 1.0, 1.0)), 1e-5
        result = rs.solve(impact(rs.PronySeries(1.0, [], []), work, stress, 1.5 * sticks), rtol=rtol)
        loss, e = float(result.radiated_energy) / work ** (5.0 / 3.0), float(result.restitution_coefficient)
        static = f"{static_loss(lam):.4f}" if lam >= 2.0 else ""
        print(f"| {lam:g} | {rtol:g} | {e:.5f} | {loss:.4f} | {static} | {float(result.restitution_error):.0e} |")
    print(f"| JKR | | {math.sqrt(1.0 - 1.0 / 1.5**2):.5f} | {JKR_LOSS:.7f} | {extrapolated_loss():.7f} | |")


def thin_rings() -> None:
    """Print e and processor time over lambda at the instantaneous modulus, of elastic and of viscoelastic balls."""
    print("| lambda | elastic, 1e-4 | time [ms] | 1e-5 | time | viscoelastic, 1e-4 | time | 1e-5 | time |")
    print("|---|---|---|---|---|---|---|---|---|")
    elastic = rs.PronySeries(1.0, [], [])
    sticks = math.sqrt(2.0 * JKR_LOSS * 0.01 ** (5.0 / 3.0))
    for lam in (1.0, 3.0, 10.0, 20.0, 50.0, 100.0, 300.0):
        cells = []
        for modulus, work, velocity in ((elastic, 0.01, 1.5 * sticks), (STANDARD, 0.02, 0.8)):
            stress = lam / float(maugis_number(work, 1.0, modulus.instantaneous_modulus, 1.0))
            for rtol in (1e-4, 1e-5):
                start = time.process_time()
                result = rs.solve(impact(modulus, work, stress, velocity), rtol=rtol)
                spent = 1e3 * (time.process_time() - start)
                cells.append(f"{float(result.restitution_coefficient):.6f} | {spent:.0f}")
        print(f"| {lam:g} | {' | '.join(cells)} |", flush=True)


def random_impact(rng: np.random.Generator) -> rs.Impact:
    """Return a body of any material and of one of three profiles, near and above its sticking velocity."""
    count = int(rng.integers(0, 4))
    moduli = 10.0 ** rng.uniform(-1, 1.5, count)
    work, lam = 10.0 ** rng.uniform((-4, -1), (-1, 0.5))
    glass = 1.0 + moduli.sum()
    velocity = math.sqrt(2.0 * JKR_LOSS * work ** (5.0 / 3.0)) * 10.0 ** rng.uniform(0.0, 1.2)
    times = 3.0 * velocity**-0.2 * glass**-0.4 * 10.0 ** rng.uniform(-2, 1.5, count)
    profile = [rs.Parabola(1.0), rs.Sphere(10.0), rs.PowerLaw(3.0, 0.5)][int(rng.integers(3))]
    stress = lam / float(maugis_number(work, 1.0, 1.0, 1.0))
    equilibrium = float(count == 0 or rng.random() < 0.8)
    shear = rs.PronySeries(0.25 * equilibrium, 0.25 * moduli, times)
    adhesion = rs.Adhesion(work, stress)
    return rs.Impact(rs.Material(shear, bulk=math.inf), profile, 1.0, velocity, adhesion=adhesion)


def random_impacts(count: int, rtol: float, minutes: float) -> None:
    """Print what becomes of random impacts: ends, largest residual of the energy, largest e, least energy."""
    ends, worst, fastest, least, spent = Counter[str](), 0.0, 0.0, 0.0, []
    start = time.monotonic()
    for n in range(count):
        impact = random_impact(np.random.default_rng([23, n]))
        before = time.process_time()
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            result = rs.solve(impact, rtol=rtol, errors="warn")
        spent.append(time.process_time() - before)
        status = Status(int(np.asarray(result.status)))
        ends[status.name] += 1
        if status.failed:
            print(f"impact {n}: {status.name}", flush=True)
        if status == Status.SEPARATED:
            energy = result.energy
            residual = abs(float(energy.residual))
            if residual > 10.0 * rtol:
                print(f"impact {n}: energy within {residual:.1e}, e = {float(result.restitution_coefficient):.4f}")
            worst, fastest = max(worst, residual), max(fastest, float(result.restitution_coefficient))
            parts = energy.dissipated, energy.radiated, energy.stored
            least = min(least, *(float(np.asarray(part) / energy.kinetic_in) for part in parts))
        if time.monotonic() - start > 60.0 * minutes:
            break
    print(f"{len(spent)} impacts at rtol = {rtol:g}: {dict(ends)}")
    print(f"energy closes within {worst:.1e}, largest e {fastest:.7f}, least part of the energy {least:.1e}")
    print(
        f"mean time {1e3 * np.mean(spent):.0f} ms, median {1e3 * np.median(spent):.0f} ms, longest {max(spent):.1f} s"
    )


def main() -> int:
    """Print all tables, or what becomes of random impacts."""
    parser = argparse.ArgumentParser(description=main.__doc__)
    parser.add_argument("--random", type=int, metavar="COUNT", help="number of random impacts")
    parser.add_argument("--rtol", type=float, default=1e-4, help="tolerance of random impacts")
    parser.add_argument("--minutes", type=float, default=40.0, help="time after which no further one begins")
    parser.add_argument("--second", action="store_true", help="the second program alone")
    options = parser.parse_args()
    if options.second:
        second_program()
        return 0
    if options.random:
        random_impacts(options.random, options.rtol, options.minutes)
        return 0
    rows()
    print()
    limits()
    print()
    thin_rings()
    print()
    second_program()
    print()
    boundary_elements()
    return 0


if __name__ == "__main__":
    sys.exit(main())
