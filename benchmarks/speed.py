"""Time of an impact by domain, profile, number of terms, tolerance, number of points and threads."""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence
from functools import partial
from typing import Any

import numpy as np
from problems import Problems, even_prony, of_profile, plane, random_prony, wide
from timing import best, evenly, in_array_calls, one_by_one

import restitution as rs
from restitution.contact.table import path_table

RTOL = 1e-8

Note = Callable[[str], None]


def domains(points: int, alone: int, repeats: int, note: Note) -> list[dict[str, Any]]:
    """Mean, median and worst time and the errors in the three domains with targets."""
    masses = 200
    cases: list[tuple[str, Problems, float]] = [
        ("paper's plane", plane(points), RTOL),
        ("paper's plane", plane(points), 1e-9),
        ("wide domain", wide(points), RTOL),
        ("10 to 20 terms", random_prony(points // masses, masses), RTOL),
    ]
    rows = []
    for name, problems, rtol in cases:
        mean, error, share = in_array_calls(problems, rtol, repeats)
        chosen = evenly(problems, alone)
        times = one_by_one(problems, chosen, rtol, copies=256, repeats=repeats)
        row = {
            "domain": name,
            "rtol": rtol,
            "impacts": problems.size,
            "mean": mean,
            "error": error,
            "share": share,
        }
        rows.append(row | {"times": [round(x, 9) for x in times.tolist()]})
        note(f"{name}, rtol {rtol:g}: mean {1e6 * mean:.1f}, worst {1e6 * times.max():.1f} us, error {share:.2f} rtol")
    return rows


def tips() -> dict[str, rs.PowerLaw | rs.Tabulated]:
    """Profiles to be compared; the first is the reference."""
    r = np.linspace(0.0, 12.0, 241)
    return {
        "parabola": rs.Parabola(1.0),
        "cone": rs.Cone(np.pi / 4),
        "power law, n = 4": rs.PowerLaw(4.0, 1.0),
        "power law, n = 1.5": rs.PowerLaw(1.5, 1.0),
        "flat punch": rs.FlatPunch(1.0),
        "tabulated: a parabola at 241 points": rs.Tabulated(r, 0.5 * r**2),
        "tabulated: a rounded cone at 241 points": rs.Tabulated(r, np.sqrt(1.0 + r**2) - 1.0),
        "sphere (solved by a table)": rs.Sphere(20.0),
        "truncated cone (solved by a table)": rs.TruncatedCone(1.0, np.pi / 4),
    }


def profiles(materials: int, masses: int, repeats: int, note: Note) -> list[dict[str, Any]]:
    """Mean time for each profile, and the time of its table, which is included in the mean."""
    rows = []
    for name, profile in tips().items():
        problems = of_profile(profile, materials, masses)
        exact, result = problems.solve(1e-11), problems.solve(RTOL)
        seconds = best(partial(problems.solve, RTOL), repeats) / problems.size
        table = 0.0
        if profile.path_exponent is None:
            table = best(partial(path_table, profile, 4.0), repeats)
        error = float((np.abs(result - exact) / np.maximum(exact, 1e-3)).max())
        rows.append({"profile": name, "seconds": seconds, "table": table, "error": error, "masses": masses})
        note(f"{name}: {1e6 * seconds:.1f} us, {error:.1e}, table {1e3 * table:.2f} ms")
    return rows


def terms(counts: Sequence[int], masses: int, repeats: int, note: Note) -> list[dict[str, Any]]:
    """Mean time over the number of terms of the Prony series."""
    rows = []
    for count in counts:
        problems = even_prony(count, masses)
        problems.solve(RTOL)
        seconds = best(partial(problems.solve, RTOL), repeats) / masses
        rows.append({"terms": count, "seconds": seconds})
        note(f"{count} terms: {1e6 * seconds:.1f} us")
    return rows


def tolerances(points: int, repeats: int, note: Note) -> list[dict[str, Any]]:
    """Mean time and largest error over the tolerance."""
    problems = plane(points)
    exact = problems.solve(1e-12)
    rows = []
    for exponent in range(4, 13):
        rtol = 10.0**-exponent
        seconds = best(partial(problems.solve, rtol), repeats) / points
        error = np.abs(problems.solve(rtol) - exact)
        share = float((error / (rtol * np.maximum(exact, 1e-3))).max())
        rows.append({"rtol": rtol, "seconds": seconds, "error": float(error.max()), "share": share})
        note(f"rtol {rtol:g}: {1e6 * seconds:.1f} us, {error.max():.1e}")
    return rows


def sizes(counts: Sequence[int], note: Note) -> list[dict[str, Any]]:
    """Time of one call over its number of points, on one thread."""
    rows = []
    for count in counts:
        problems = plane(count)
        # As many repeats as fit into some seconds.
        repeats = min(50, max(1, 200_000 // count))
        seconds = best(partial(problems.solve, RTOL), repeats)
        rows.append({"points": count, "seconds": seconds})
        note(f"{count} points: {seconds:.3g} s")
    return rows


def threads(points: int, counts: Sequence[int], repeats: int, note: Note) -> list[dict[str, Any]]:
    """Wall-clock time of one call for each number of threads, in alternating order."""
    problems = plane(points)
    shortest = dict.fromkeys(counts, float("inf"))
    for _ in range(repeats):
        for workers in counts:
            start = time.perf_counter()
            problems.solve(RTOL, workers)
            shortest[workers] = min(shortest[workers], time.perf_counter() - start)
    for workers, seconds in shortest.items():
        note(f"{workers} threads: {seconds:.3g} s")
    return [{"workers": workers, "points": points, "seconds": s} for workers, s in shortest.items()]


def surrogate(points: int, repeats: int, note: Note) -> dict[str, Any]:
    """Time of a query of the paper's coefficient by the shipped interpolant, in an array call on one thread."""
    sample = plane(points)

    def query() -> Any:
        return rs.standard_solid_surrogate(sample.nu, sample.p2, sample.p3)

    error = float(np.abs(query() - sample.solve(1e-9)).max())
    seconds = best(query, repeats) / points
    note(f"surrogate: {1e9 * seconds:.0f} ns, {error:.1e}")
    return {"points": points, "seconds": seconds, "error": error}
