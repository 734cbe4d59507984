"""Errors of e over the tolerance, and refusals, of random impacts of every kind, against `rtol = 1e-12`.

The size is the number of impacts of most kinds: five times as many have fast branches, a fifth are on layers. 240 take
a minute.

Usage: python validation/tolerance.py [--seed 1] [--size 50000] [--kinds "fast branches" impedance] [--workers 4]
"""

import argparse
import math
import os
import sys
import warnings
from collections.abc import Callable, Sequence
from concurrent.futures import ProcessPoolExecutor, as_completed
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from endurance import draw_profile, draw_series
from rich.progress import track
from tips import draw_tip

import restitution as rs
from restitution.errors import InputError
from restitution.impact.status import SolverError

sys.path.insert(0, str(Path(__file__).parents[1] / "tests"))

from scipy_oracle import solve_by_scipy

RTOL, FINEST, FLOOR = (1e-6, 1e-9), 1e-12, 1e-3
IMPACTS = 24  # of one problem
SHARE = {"fast branches": 5.0, "layers": 0.2}  # number of impacts over that of other kinds
COMPARED = 20  # problems for each impact that SciPy solves too
MOST_TERMS, SHORTEST = 12, 1e-9  # of a material that SciPy solves: terms, and relaxation time over the contact time

Random = np.random.Generator
Problem = rs.Impact | list[rs.Impact]


def power(random: Random, low: float, high: float, size: int | None = None) -> Any:
    """Numbers with even logarithms."""
    return 10.0 ** random.uniform(low, high, size)


def draw_material(random: Random, most: int = 20, dashpot: float = 0.1) -> rs.Material:
    """Material of 1 to `most` terms over 14 decades; bulk modulus infinite, constant, zero or of several terms."""
    shear = draw_series(random, int(random.integers(1, most + 1)), random.random() < 0.05, random.random() < dashpot)
    kind = random.integers(4)
    several = draw_series(random, int(random.integers(1, most + 1)), False, False)
    return rs.Material(shear, (math.inf, power(random, -3.0, 3.0), 0.0, several)[kind])


def draw_fast_series(random: Random) -> rs.PronySeries:
    """Series of 1 to 20 terms from 1e-14 s on: close to each other or not, strong as a dashpot or weak."""
    terms = int(random.integers(1, 21))
    times = power(random, -14.0, 2.0, terms)
    if random.random() < 0.4:
        near = random.random(terms) < 0.5
        times[near] = power(random, -14.0, -2.0) * power(random, 0.0, random.uniform(0.0, 3.0), int(near.sum()))
    moduli = power(random, -3.0, 3.0, terms)
    strong = random.random(terms) < random.random()
    moduli[strong] = power(random, -8.0, 1.0, int(strong.sum())) / times[strong]
    return rs.PronySeries(power(random, -3.0, 3.0), moduli, times)


def varied(random: Random, material: rs.Material, profile: object, **options: object) -> rs.Impact:
    """Impacts of one body over six decades of mass and velocity."""
    mass, velocity = power(random, -2.0, 2.0), power(random, -2.0, 2.0, IMPACTS)
    return rs.Impact(material, profile, mass, velocity, **options)


def plain(random: Random) -> Problem:
    return varied(random, draw_material(random), draw_profile(random, int(random.integers(7))))


def tip(random: Random) -> Problem:
    profile = draw_tip(int(random.integers(2**31)))
    depth = np.minimum(power(random, -1.5, 0.2, IMPACTS), 0.4 * float(profile.max_depth))
    return rs.Impact(draw_material(random), profile, profile.contact_radius(depth) * depth**2, 1.0)


def layer(random: Random) -> Problem:
    size = power(random, -2.0, 2.0)
    kind = random.integers(3)
    profile = (rs.Parabola(size), rs.Cone(random.uniform(0.2, 1.5)), rs.PowerLaw(4.0, size**-3.0))[kind]
    base, material = ("bonded", "frictionless")[random.integers(2)], draw_material(random)
    if base == "bonded":
        material = rs.Material(material.shear, math.inf)
    return varied(random, material, rs.Layer(profile, size * power(random, -1.0, 1.5), base))


def ellipsoid(random: Random) -> Problem:
    return varied(random, draw_material(random), rs.Ellipsoid(*power(random, -2.0, 2.0, 2)))


def pyramid(random: Random) -> Problem:
    return varied(random, draw_material(random), rs.Pyramid(random.uniform(0.2, 1.4), int(random.choice([3, 4, 6]))))


def force_law(random: Random) -> Problem:
    depth, exponent = np.geomspace(1e-3, 1.0, 60), random.uniform(1.0, 2.5)
    force = depth**exponent * (1.0 + random.uniform(0.0, 1.0) * depth)
    law = rs.ForceLaw(depth, force, 1.0, 0.5, exponent)
    shear = draw_material(random).shear
    # The energy of the body is a share of what the law takes up.
    velocity, share = power(random, -2.0, 2.0, IMPACTS), power(random, -6.0, 0.0, IMPACTS)
    return rs.Impact(
        rs.Material(shear, math.inf), law, shear.equilibrium_modulus * share / velocity**2 + 1e-9, velocity
    )


def weight(random: Random) -> Problem:
    free = varied(random, draw_material(random), draw_profile(random, int(random.integers(7))))
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        force = np.nan_to_num(rs.solve(free, rtol=1e-4, errors="warn", workers=1).max_force, nan=1.0)
    return rs.Impact(free.material, free.profile, free.mass, free.velocity,
                     external_force=force * power(random, -6.0, 1.0, IMPACTS))  # fmt: skip


def two_bodies(random: Random) -> Problem:
    """A solid and a counter material; half of the counter materials have a parallel dashpot."""
    profile = draw_profile(random, int(random.integers(7)))
    masses, velocities = power(random, -2.0, 2.0, IMPACTS), power(random, -2.0, 2.0, IMPACTS)
    return [
        rs.Impact(draw_material(random, 10), profile, *body, counter_material=draw_material(random, 10, 0.5))
        for body in zip(masses, velocities, strict=True)
    ]


def impedance(random: Random) -> Problem:
    free = varied(random, draw_material(random), draw_profile(random, int(random.integers(7))))
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        time = rs.solve(free, rtol=1e-4, errors="warn", workers=1).contact_time
    scale = free.mass / np.where(np.isfinite(time), time, 1.0)
    return rs.Impact(free.material, free.profile, free.mass, free.velocity,
                     impedance=scale * power(random, -1.5, 2.0, IMPACTS))  # fmt: skip


def fractional(random: Random) -> Problem:
    exponent, modulus, other = random.uniform(0.05, 0.95), *power(random, -3.0, 3.0, 2)
    model = (
        lambda: rs.fractional_kelvin_voigt(modulus, other, exponent),
        lambda: rs.fractional_maxwell(modulus, power(random, -6.0, 2.0), exponent),
        lambda: rs.fractional_zener(modulus, other, power(random, -6.0, 2.0), exponent),
    )
    shear = model[random.integers(3)]()
    bulk = (math.inf, power(random, -3.0, 3.0), model[random.integers(3)]())[random.integers(3)]
    window = power(random, -10.0, -5.0), power(random, 0.0, 2.0)
    material = rs.FractionalMaterial(shear, bulk).within(window)
    return varied(random, material, draw_profile(random, int(random.integers(7))))


def fast_branches(random: Random) -> Problem:
    """Each impact has a material of its own; a fifth have a deformable body, a tenth a dashpot."""
    profile, impacts = draw_profile(random, int(random.integers(7))), []
    for mass, velocity in zip(power(random, -2.0, 2.0, IMPACTS), power(random, -2.0, 2.0, IMPACTS), strict=True):
        shear = draw_fast_series(random)
        if random.random() < 0.1:
            shear = rs.PronySeries(shear.equilibrium_modulus, shear.branch_moduli, shear.relaxation_times,
                                   parallel_viscosity=power(random, -8.0, 1.0))  # fmt: skip
        bulk = (math.inf, power(random, -3.0, 3.0), draw_fast_series(random))[random.integers(3)]
        counter = rs.Material(draw_fast_series(random), math.inf) if random.random() < 0.2 else None
        impacts.append(rs.Impact(rs.Material(shear, bulk), profile, mass, velocity, counter_material=counter))
    return impacts


KINDS: dict[str, Callable[[Random], Problem]] = {
    "fast branches": fast_branches,
    "two bodies": two_bodies,
    "fractional materials": fractional,
    "impedance": impedance,
    "plain profiles, 1 to 20 terms": plain,
    "constant force": weight,
    "measured tips": tip,
    "ellipsoids": ellipsoid,
    "pyramids": pyramid,
    "force laws": force_law,
    "layers": layer,
}
NOT_COMPARED = ("measured tips", "layers", "impedance", "fractional materials")


class Row(NamedTuple):
    """Outcome of one problem; each list has a number for each tolerance, the finest one last."""

    kind: str
    number: int
    drawn: int  # impacts; 0 if the package refuses the problem as such
    compared: Sequence[int]
    above: Sequence[int]
    worst: Sequence[float]  # largest error of e over rtol max(e, 1e-3)
    refused: Sequence[int]
    lost: Sequence[int]  # refused although e > 1e-3 is known from another tolerance
    split: int  # impacts whose status differs between two tolerances that solve it
    time: Sequence[float]  # largest relative error of the contact time where e > 1e-3
    force: Sequence[float]  # the same of the largest force, of all impacts


def draw(kind: str, seed: int, number: int) -> Problem | None:
    """Problem of a kind; None if the package refuses it."""
    random = np.random.default_rng([seed, list(KINDS).index(kind), number])
    try:
        return KINDS[kind](random)
    except (InputError, ValueError):
        return None


def judge(kind: str, seed: int, number: int) -> Row:
    """Solve a problem at all tolerances."""
    warnings.simplefilter("ignore")
    problem = draw(kind, seed, number)
    try:
        result = problem and [rs.solve(problem, rtol=r, errors="warn", workers=1) for r in (*RTOL, FINEST)]
    except InputError:
        result = None
    none = [0] * (len(RTOL) + 1)
    if not result:
        return Row(kind, number, 0, none, none, none, none, none, 0, none, none)
    e, status = (np.array([getattr(solution, name) for solution in result])
                 for name in ("restitution_coefficient", "status"))  # fmt: skip
    solved, largest_e = np.isfinite(e), np.nanmax(np.nan_to_num(e), axis=0)
    error = np.abs(e - e[-1]) / np.maximum(e[-1], FLOOR) / np.array([*RTOL, FINEST])[:, None]
    differs = sum(np.any(status[solved[:, n], n] != status[solved[:, n], n][0]) for n in range(e.shape[1]) if
                  solved[:, n].any())  # fmt: skip

    def largest(name: str, where: np.ndarray) -> list[float]:
        values = np.array([getattr(solution, name) for solution in result])
        with np.errstate(all="ignore"):
            relative = np.where(where & np.isfinite(values), np.abs(values / values[-1] - 1.0), 0.0)
        return np.nan_to_num(relative).max(axis=1).tolist()

    return Row(
        kind, number, e.shape[1], (solved & solved[-1]).sum(axis=1).tolist(), (error > 1.0).sum(axis=1).tolist(),
        np.nan_to_num(error).max(axis=1).tolist(), (~solved).sum(axis=1).tolist(),
        (~solved & (largest_e > FLOOR)).sum(axis=1).tolist(), int(differs), largest("contact_time", e[-1] > FLOOR),
        largest("max_force", solved[-1]),
    )  # fmt: skip


def by_scipy(kind: str, seed: int, number: int) -> float | None:
    """Difference of e from SciPy's over max(e, 1e-3), both at 1e-10, of the first impact that SciPy can solve."""
    warnings.simplefilter("ignore")
    problem = draw(kind, seed, number)
    if problem is None:
        return None
    if not isinstance(problem, list):
        force = np.broadcast_to(problem.external_force, (IMPACTS,))
        mass, velocity = (np.broadcast_to(values, (IMPACTS,)) for values in (problem.mass, problem.velocity))
        problem = [rs.Impact(problem.material, problem.profile, float(mass[0]), float(velocity[0]),
                             external_force=float(force[0]))]  # fmt: skip
    for impact in problem:
        series = impact.reduced_modulus
        try:
            time = float(rs.solve(impact, rtol=1e-4).contact_time)
            if series.n_branches > MOST_TERMS or np.min(series.relaxation_times, initial=time) < SHORTEST * time:
                continue
            e, other = (
                float(method(impact, rtol=1e-10).restitution_coefficient) for method in (rs.solve, solve_by_scipy)
            )
        except (SolverError, InputError, ValueError):
            continue
        return abs(e - other) / max(other, FLOOR)
    return None


def lines(rows: list[Row], kind: str) -> str:
    """Line of the table."""
    rows_of_kind = [row for row in rows if row.kind == kind]
    drawn = sum(row.drawn for row in rows_of_kind)

    def total(name: str, n: int) -> int:
        return sum(getattr(row, name)[n] for row in rows_of_kind)

    def worst(name: str) -> str:
        return ", ".join(f"{max(getattr(row, name)[n] for row in rows_of_kind):.2g}" for n in range(len(RTOL)))

    three = range(len(RTOL) + 1)
    compared = sum(total("compared", n) for n in range(len(RTOL)))
    above = sum(total("above", n) for n in range(len(RTOL)))
    refused = ", ".join(f"{total('refused', n):,}" for n in three)
    lost = ", ".join(f"{total('lost', n):,}" for n in three)
    split = sum(row.split for row in rows_of_kind)
    return (f"| {kind} | {drawn:,} | {compared:,} | {above:,} | {worst('worst')} | {refused} | {lost} | {split:,} "
            f"| {worst('time')} | {worst('force')} |")  # fmt: skip


def page(rows: list[Row], differences: list[float], seed: int) -> list[str]:
    """Lines of the page."""
    table = [
        f"Seed {seed}. Errors are those at `rtol` = 1e-6 and 1e-9 against 1e-12; those of e over `rtol max(e, 1e-3)`.",
        "Refusals are those at 1e-6, 1e-9 and 1e-12; *lost* are those with e > 1e-3. *Split* are impacts with another",
        "status at another tolerance. The errors of the contact time are those where e > 1e-3.",
        "",
        "| impacts | drawn | compared | above | worst | refused | lost | split | contact time | largest force |",
        "|" + "---|" * 10,
        *(lines(rows, kind) for kind in KINDS if any(row.kind == kind for row in rows)),
        "",
    ]
    if differences:
        table += [
            f"SciPy (`tests/scipy_oracle.py`) solves {len(differences):,} of these impacts too, both at",
            f"`rtol = 1e-10`: the largest difference of e over max(e, 1e-3) is {max(differences):.1e}, the median "
            f"{np.median(differences):.1e}.",
        ]
    return table


def main() -> None:
    """Write `tolerance.md`."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--size", type=int, default=20_000)
    parser.add_argument("--kinds", nargs="+", default=list(KINDS), choices=list(KINDS))
    parser.add_argument("--workers", type=int, default=os.cpu_count())
    parser.add_argument("--out", type=Path, default=Path(__file__).with_suffix(".md"))
    options = parser.parse_args()
    kinds, rows, differences = options.kinds, list[Row](), list[float]()
    judge("fast branches", 0, 0)  # compiles
    with ProcessPoolExecutor(options.workers) as pool:
        for kind in kinds:
            count = math.ceil(options.size * SHARE.get(kind, 1.0) / IMPACTS)
            tasks = [pool.submit(judge, kind, options.seed, n) for n in range(count)]
            rows += [task.result() for task in track(as_completed(tasks), kind, len(tasks))]
            if kind not in NOT_COMPARED:
                tasks = [pool.submit(by_scipy, kind, options.seed, n) for n in range(0, count, COMPARED)]
                results = [task.result() for task in track(as_completed(tasks), "against SciPy", len(tasks))]
                differences += [difference for difference in results if difference is not None]
            # After each kind, so that an interrupted run leaves a table.
            options.out.write_text("\n".join(page(rows, differences, options.seed)) + "\n")
    for kind in kinds:
        for n, rtol in enumerate(RTOL):
            row = max((row for row in rows if row.kind == kind), key=lambda row: row.worst[n])
            print(f"{kind}, {rtol:g}: worst {row.worst[n]:.3g} in problem {row.number}")


if __name__ == "__main__":
    main()
