"""Histories by boundary elements in time, which assume no disc of contact, beside `restitution.indent`.

`python validation/boundary_elements.py` prints the tables of validation/boundary_elements.md. It takes some three
minutes. The surface is divided into rings of constant pressure; the contact at each instant follows from
complementarity, `p >= 0`, `gap >= 0`, `p gap = 0`, for each ring alone. Nothing of this is in the package: no Abel
transform, no independent elements, no front.
"""

from __future__ import annotations

import math
import sys
from dataclasses import dataclass
from itertools import pairwise
from typing import Any

import numpy as np
from scipy.special import ellipe, ellipkm1

import restitution as rs

# E*(t) = 1 + 4 exp(-t) and the programs D1 and D2 of tests/indentation/test_any_history.py.
STANDARD = rs.PronySeries(1.0, [4.0], [1.0])
D1 = [0.0, 1.0, 1.3, 1.6, 2.0, 3.0, 4.2], [0.0, 1.0, 0.7, 0.9, 0.6, 1.2, 0.0]
D2 = [0.0, 1.0, 1.5, 2.5, 3.0, 4.0, 4.5], [0.0, 1.0, 0.0, 1.0, 0.0, 1.2, 0.0]


def disc(r: Any, radius: Any) -> Any:
    """Displacement at r of a disc of this radius with unit pressure, for E* = 1 (Johnson 1985, 3.29)."""
    inside, ratio = r <= radius, np.minimum(r, radius) / np.maximum(r, radius)
    m = ratio**2
    within = radius * ellipe(m)
    beyond = r * (ellipe(m) - (1.0 - m) * ellipkm1(np.maximum(1.0 - m, 1e-300)))
    return 4.0 / math.pi * np.where(inside, within, beyond)


@dataclass
class Rings:
    """Rings of equal width up to a radius."""

    edges: Any
    middles: Any
    areas: Any
    influence: Any  # displacement at the middles for unit pressures, for E* = 1


def rings(count: int, radius: float) -> Rings:
    """Return the rings and their influence."""
    edges = np.linspace(0.0, radius, count + 1)
    middles = 0.5 * (edges[1:] + edges[:-1])
    outer = disc(middles[:, None], edges[None, 1:])
    inner = np.concatenate([np.zeros((count, 1)), disc(middles[:, None], edges[None, 1:-1])], axis=1)
    return Rings(edges, middles, math.pi * np.diff(edges**2), outer - inner)


def pressures(influence: Any, lift: Any, touches: Any) -> tuple[Any, Any]:
    """Return p >= 0 with `influence p + lift >= 0` and equality under pressure, and where the contact is.

    Rings change their state until all signs are right (Kunisch, Hintermueller, Ito: a primal-dual active set).
    """
    for _ in range(200):
        p = np.zeros(lift.size)
        if touches.any():
            p[touches] = np.linalg.solve(influence[np.ix_(touches, touches)], -lift[touches])
        gap = influence @ p + lift
        after = np.where(touches, p > 0.0, gap < -1e-14)
        if np.array_equal(after, touches):
            return p, touches
        touches = after
    raise RuntimeError("the contact of a step was not found")


@dataclass
class Run:
    """Times, forces and contact radii of a program, and the steps whose contact is not a disc."""

    times: Any
    forces: Any
    radii: Any
    not_discs: int
    worst_outside: float  # pressure of these over the largest


def follow(series: rs.PronySeries, times: Any, depths: Any, profile: Any, radius: float, count: int) -> Run:
    """Solve a program of straight lines with a number of rings, and half as many steps for each line.

    Displacements are linear over a step, so that branches follow exactly: second order. A law E*(t) on displacements:
    `A p = Einf w + sum l_k`, `l_k' = E_k w' - l_k/tau_k`.
    """
    mesh, steps = rings(count, radius), count // 2
    shape, moduli, rates = profile(mesh.middles), series.branch_moduli, 1.0 / series.relaxation_times
    w, loads = np.zeros(count), np.zeros((moduli.size, count))
    touches = np.zeros(count, dtype=bool)
    kept: list[tuple[float, float, float]] = [(float(times[0]), 0.0, 0.0)]
    strays, worst, largest = 0, 0.0, 0.0
    for n in range(len(times) - 1):
        # The first steps after a kink are the shortest: the contact may turn or begin with a root of the time.
        share = np.linspace(0.0, 1.0, steps + 1) ** 2
        for before, now in pairwise(share):
            step = (times[n + 1] - times[n]) * (now - before)
            depth = depths[n] + (depths[n + 1] - depths[n]) * now
            decay = np.exp(-rates * step)
            tangent = series.equilibrium_modulus + float(moduli @ (-np.expm1(-rates * step) / (rates * step)))
            old = series.equilibrium_modulus * w + decay @ loads
            lift = w - old / tangent - depth + shape
            p, touches = pressures(mesh.influence / tangent, lift, touches)
            rise = (mesh.influence @ p - old) / tangent
            loads = decay[:, None] * loads + np.outer(moduli * -np.expm1(-rates * step) / (rates * step), rise)
            w = w + rise
            largest = max(largest, float(p.max()))
            last = int(np.flatnonzero(touches)[-1]) + 1 if touches.any() else 0
            if not touches[:last].all():
                strays += 1
                worst = max(worst, float(p.max()) / largest)
            force = float(mesh.areas @ p)
            kept.append((float(times[n] + (times[n + 1] - times[n]) * now), force, float(mesh.edges[last])))
    columns = np.array(kept).T
    return Run(columns[0], columns[1], columns[2], strays, worst)


def half_space(series: rs.PronySeries) -> rs.Material:
    """Incompressible half-space whose reduced modulus E* = 4 G is this series."""
    return rs.Material(series.scaled(0.25), math.inf)


def compare(series: rs.PronySeries, times: Any, depths: Any, tip: Any, profile: Any, counts: Any) -> list[Any]:
    """Return for each count the largest differences of force, over the largest force, and of radius, in rings."""
    exact = rs.indent(half_space(series), tip, depth=np.array(depths), time=np.array(times), rtol=1e-10)
    rows = []
    for count in counts:
        reach = 1.1 * float(tip.contact_radius(max(depths)))
        run = follow(series, times, depths, profile, reach, count)
        sample = exact.sample(run.times[1:])
        force = np.abs(run.forces[1:] - sample.force.values).max() / exact.max_force
        contact = (sample.force.values > 1e-6 * exact.max_force) & (run.forces[1:] > 0.0)
        radius = np.abs(run.radii[1:] - sample.contact_radius.values)[contact].max() * count / reach
        rows.append((force, radius, run.not_discs, run.worst_outside))
    return rows


def programs(count: int) -> Any:
    """Random solids and liquids of one to four terms under random programs."""
    rng = np.random.default_rng(11)
    for _ in range(count):
        terms, size = int(rng.integers(1, 5)), int(rng.integers(3, 7))
        series = rs.PronySeries(
            float(rng.random() < 0.75), 10.0 ** rng.uniform(-1.0, 1.0, terms), 10.0 ** rng.uniform(-1.0, 1.0, terms)
        )
        times = np.concatenate([[0.0], np.cumsum(rng.uniform(0.2, 1.0, size))])
        depths = np.concatenate([[0.0, rng.uniform(0.5, 1.0)], rng.uniform(-0.3, 1.0, size - 1)])
        yield series, times, depths


def main(small: bool) -> None:
    """Print both tables."""
    counts = (50, 100) if small else (100, 200, 400)
    tips = {
        "parabola": (rs.Parabola(1.0), lambda r: 0.5 * r * r),
        "cone": (rs.Cone(1.0), lambda r: r / math.tan(1.0)),
    }
    head = " | ".join(str(count) for count in counts)
    print(f"| program | tip | {head} | radius [rings] |\n|---|---|{'---|' * (len(counts) + 1)}")
    for name, (times, depths) in {"D1": D1, "D2": D2}.items():
        for tip, (profile, shape) in tips.items():
            rows = compare(STANDARD, times, depths, profile, shape, counts)
            errors = " | ".join(f"{row[0]:.1e}" for row in rows)
            print(f"| {name} | {tip} | {errors} | {max(row[1] for row in rows):.1f} |", flush=True)
    number, count = (4, 50) if small else (100, 100)
    profile, shape = tips["parabola"]
    rows = [compare(series, t, d, profile, shape, (count,))[0] for series, t, d in programs(number)]
    errors = np.array([row[0] for row in rows])
    print(f"\n{number} random programs, {count} rings: median {np.median(errors):.1e}, largest {errors.max():.1e}.")
    strays, share = sum(row[2] for row in rows), max(row[3] for row in rows)
    print(f"Steps with a contact other than a disc: {strays}; their largest pressure over that of a run: {share:.0e}")


if __name__ == "__main__":
    main("--small" in sys.argv)
