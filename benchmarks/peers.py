"""Times and errors of the paper's elements, of SciPy's integrators and of LAMMPS."""

from __future__ import annotations

import json
import math
import os
import subprocess
from collections.abc import Callable
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import Any

import compiled_elements
import numpy as np
import scipy_impact
from problems import StandardSolids, plane
from scipy.integrate import solve_ivp
from timing import best, clock, one_by_one

import restitution as rs
from restitution.impact.batch import Batch
from restitution.material.conversion import reduced_standard_solid

SEED = 11
EXACT = 1e-12
OURS = [10.0**-n for n in range(2, 13)]
SCIPY_METHODS = ("Radau", "LSODA", "DOP853")
SCIPY = [10.0**-n for n in range(3, 12)]
ELEMENTS = [25 * 2**n for n in range(10)]
"""Elements in contact at most; the time step goes with their number."""

Note = Callable[[str], None]


def sample(count: int) -> tuple[StandardSolids, Any]:
    """Points of the paper's plane on which all methods are compared, and e there."""
    points = plane(count, SEED)
    return points, points.solve(EXACT)


def ours(count: int, note: Note) -> list[dict[str, Any]]:
    """Time and largest error by tolerance."""
    points, exact = sample(count)
    rows = []
    for rtol in OURS:
        times = one_by_one(points, range(count), rtol, copies=256, repeats=5)
        errors = np.abs(points.solve(rtol) - exact)
        rows.append({"rtol": rtol, "seconds": times.tolist(), "errors": errors.tolist()})
        note(f"ours {rtol:g}: {1e6 * times.mean():.1f} us, {errors.max():.1e}")
    return rows


def scipy(count: int, most: int, note: Note) -> dict[str, list[dict[str, Any]]]:
    """Time and error of each impact by method and tolerance; the error is None if `most` evaluations were too few."""
    points, exact = sample(count)
    ones = np.ones(count)
    reduced = reduced_standard_solid(points.nu, ones, 1.0 / points.p2, points.p2 * points.p3)
    batch = Batch(*reduced.columns, ones, ones, 0.0 * ones, ones, 1.0)
    block = batch.scaled()
    results: dict[str, list[dict[str, Any]]] = {}
    for method in SCIPY_METHODS:
        for rtol in SCIPY:
            seconds, errors = [], []
            for n in range(count):
                start = clock()
                try:
                    e = scipy_impact.solve(block.row(n), method, rtol, most).restitution_coefficient
                except scipy_impact.Unsuited:
                    e = None
                seconds.append(clock() - start)
                errors.append(None if e is None else abs(e - exact[n]))
            results.setdefault(method, []).append({"rtol": rtol, "seconds": seconds, "errors": errors})
            note(f"{method} {rtol:g}: {1e3 * np.mean(seconds):.1f} ms, {max(x for x in errors if x is not None):.1e}")
    return results


def elements(count: int, errors: list[float], longest: float, note: Note) -> dict[str, list[Any]]:
    """Time of each impact by the element method with the fewest elements, doubled, that meet an error of e.

    In NumPy, the public call, which runs once more with half the elements to estimate its error; and compiled, given
    the largest depth. None where the method refuses, or where more than `longest` seconds would be needed.
    """
    points, exact = sample(count)
    compiled_elements.restitution(0.3, 0.1, 1.0, 1.0, 16, 10**6)
    results: dict[str, list[Any]] = {"elements": [], "elements, compiled": []}
    for n in range(count):
        nu, p2, p3 = (float(column[n]) for column in (points.nu, points.p2, points.p3))
        solid = rs.standard_solid(1.0, 1.0 / p2, p3, poisson_ratio=nu)
        impact = rs.Impact(solid, rs.Parabola(1.0), mass=1.0, velocity=1.0)
        depth = float(rs.solve(impact).max_indentation_depth)

        methods = (partial(_in_numpy, impact), partial(_compiled, nu, p2, p3, depth))
        for (name, rows), method in zip(results.items(), methods, strict=True):
            rows.append(_refined(method, float(exact[n]), errors, longest))
            note(f"{name}, {n + 1} of {count}: {rows[-1]}")
    return results


def _in_numpy(impact: rs.Impact, many: int) -> float:
    """Restitution coefficient by so many elements; NaN where they need too many steps."""
    try:
        return rs.solve(impact, method="elements", n_elements=many).restitution_coefficient
    except ValueError:
        return math.nan


def _compiled(nu: float, p2: float, p3: float, depth: float, many: int) -> float:
    return compiled_elements.restitution(nu, p2, p3, depth, many, 10**8)[0]


def _refined(method: Callable[[int], float], exact: float, errors: list[float], longest: float) -> dict[str, Any]:
    """Number of elements and time [s] with which each error is met, and the error that came out; None for never."""
    row: dict[str, Any] = {str(error): None for error in errors}
    expected = sorted(errors, reverse=True)
    for many in ELEMENTS:
        start = clock()
        error = abs(method(many) - exact)
        spent = clock() - start
        while expected and error <= expected[0]:
            row[str(expected.pop(0))] = {"elements": many, "seconds": spent, "error": error}
        # The next takes four times as long.
        if not expected or math.isnan(error) or 4.0 * spent > longest:
            break
    return row


SHEAR_MODULUS, RADIUS, DENSITY, VELOCITY = 1.0e6, 0.005, 1100.0, 1.0
LOSS = 0.3
"""b = (3/2) tau (k/m)^(2/5) v0^(1/5) of the law F = k (d^(3/2) + (3/2) tau d^(1/2) v)."""


def lammps(python: Path, pairs: int, steps: list[int], repeats: int, note: Note) -> dict[str, Any]:
    """Time of a collision of two Kelvin-Voigt balls in LAMMPS with its error, and here.

    The error of LAMMPS is that against the exact solution of its own law, which has no memory.
    """
    mass = 0.5 * DENSITY * 4.0 / 3.0 * math.pi * RADIUS**3
    modulus, root = 2.0 * SHEAR_MODULUS, math.sqrt(RADIUS / 2.0)
    stiffness = 4.0 / 3.0 * modulus * root
    depth = rs.closed_forms.elastic_max_indentation_depth(modulus, root, mass, VELOCITY)
    unit = (stiffness / mass) ** 0.4 * VELOCITY**0.2
    tau = LOSS / (1.5 * unit)
    settings = {
        "radius": RADIUS,
        "mass": 2.0 * mass,
        "velocity": VELOCITY,
        "reduced_modulus": modulus,
        "retardation_time": tau,
        "elastic_contact_time": float(rs.closed_forms.elastic_contact_time(depth, VELOCITY)),
        "pairs": pairs,
        "steps": steps,
        "repeats": repeats,
    }
    script = Path(__file__).with_name("lammps_pairs.py")
    # One thread, as the rest.
    environment = os.environ | {"OMP_NUM_THREADS": "1"}
    environment.pop("PYTHONPATH", None)
    done = subprocess.run(
        [str(python), "-I", str(script)], input=json.dumps(settings), capture_output=True, text=True, env=environment
    )  # fmt: skip
    if done.returncode != 0:
        raise RuntimeError(done.stderr.strip().splitlines()[-1])
    result = json.loads(done.stdout)
    law = memoryless_restitution(LOSS)
    for run in result["runs"]:
        run["error"] = max(abs(run["lowest"] - law), abs(run["highest"] - law))
        note(f"LAMMPS {run['style']} {run['steps']} steps: {1e6 * run['seconds']:.1f} us, {run['error']:.1e}")
    rubber = rs.kelvin_voigt(SHEAR_MODULUS, SHEAR_MODULUS * tau, poisson_ratio=0.5, density=DENSITY)
    ball = rs.Body(rubber, radius=RADIUS)
    collision = rs.collision(ball, ball, velocity=np.full(pairs, VELOCITY))
    exact = rs.solve(collision, rtol=EXACT, workers=1).restitution_coefficient
    here = []
    for rtol in (1e-4, 1e-8):
        e = rs.solve(collision, rtol=rtol, workers=1).restitution_coefficient
        seconds = best(partial(rs.solve, collision, rtol=rtol, workers=1), repeats) / pairs
        here.append({"rtol": rtol, "seconds": seconds, "error": float(np.abs(e - exact).max())})
        note(f"ours {rtol:g}: {1e6 * seconds:.1f} us")
    solid = rs.standard_solid(SHEAR_MODULUS, SHEAR_MODULUS, SHEAR_MODULUS * tau, poisson_ratio=0.5, density=DENSITY)
    asked = [
        _asked(material, rs.collision(*[rs.Body(body, radius=RADIUS)] * 2, velocity=VELOCITY), pairs, repeats)
        for material, body in (("Kelvin-Voigt", rubber), ("standard solid", solid))
    ]
    for row in asked:
        note(f"surrogate, {row['material']}: {1e6 * row['seconds']:.2f} us, {row['error']:.1e}")
    return result | {
        "loss": LOSS, "pairs": pairs, "law": law, "exact": float(exact[0]), "ours": here, "surrogates": asked,
    }  # fmt: skip


def _asked(material: str, collision: rs.Impact, pairs: int, repeats: int) -> dict[str, Any]:
    """Time of a collision of many, all at other velocities, by a surrogate good to 1e-8 that is built for them."""
    slow, fast = 0.1 * VELOCITY, VELOCITY
    velocity = slow * (fast / slow) ** np.random.default_rng(8).uniform(size=pairs)

    build = partial(rs.surrogate, collision, velocity=(slow, fast), rtol=1e-8, workers=1)
    restitution = build()
    exact = rs.solve(replace(collision, velocity=velocity), rtol=EXACT).restitution_coefficient
    return {
        "material": material,
        "slow": slow,
        "fast": fast,
        "seconds": best(lambda: build()(velocity), repeats) / pairs,
        "again": best(partial(restitution, velocity), repeats) / pairs,
        "error": float(np.abs(restitution(velocity) - exact).max()),
    }


def memoryless_restitution(loss: float) -> float:
    """Restitution coefficient of F = d^(3/2) + b d^(1/2) v, until the overlap is zero, with m = v0 = 1."""

    def motion(_: float, y: Any) -> Any:
        root = math.sqrt(max(y[0], 0.0))
        return [y[1], -root * (y[0] + loss * y[1])]

    def apart(t: float, y: Any) -> float:
        return y[0] if t > 0.0 else 1.0

    apart.terminal = True
    result = solve_ivp(motion, (0.0, 1e3), [0.0, 1.0], method="DOP853", rtol=1e-12, atol=1e-14, events=apart)
    return -float(result.y[1, -1])
