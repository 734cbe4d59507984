"""Times of oblique impacts over those of normal ones, and of the contact law with friction over that without.

`python benchmarks/oblique.py` takes a minute and writes `tables/oblique.md`. Both times of a ratio are processor times
of one thread in one run. Impacts are timed in pieces of 20, arrays and loops of single calls alike, and all kinds in
alternation. The least time of each piece over six rounds counts. On a loaded machine it is the lower the shorter a
piece is, so that pieces of all kinds have the same number of impacts; only arrays of normal ones, and of those without
slip, are as short as a whole.
"""

from __future__ import annotations

import math
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numba
import numpy as np

import restitution as rs

FOLDER = Path(__file__).parent
COUNT, PIECE, ROUNDS, RTOL, STEPS = 200, 20, 6, 1e-6, 200_000


def impacts() -> tuple[Any, Any]:
    """Normal impacts of random standard solids, as in the paper's plane, and random v_c0/(mu v0)."""
    rng = np.random.default_rng(3)
    p2, p3 = 10.0 ** rng.uniform(-2.0, 0.0, COUNT), 10.0 ** rng.uniform(-1.0, 1.0, COUNT)
    solid = rs.standard_solid(np.ones(COUNT), 1.0 / p2, p3, poisson_ratio=rng.uniform(0.0, 0.5, COUNT))
    return rs.Impact(solid, rs.Parabola(1.0), 1.0, 1.0), 10.0 ** rng.uniform(-0.5, 0.7, COUNT)


def spent(call: Callable[[], Any]) -> float:
    """Processor time [s] of a call."""
    begin = time.process_time()
    call()
    return time.process_time() - begin


def least(call: Callable[[], Any]) -> float:
    """Least processor time [s] of three calls."""
    return min(spent(call) for _ in range(3))


def of_impacts() -> list[tuple[str, float]]:
    normal, theta = impacts()
    friction = 0.3
    rough = rs.vary(normal, {"friction": friction, "tangential_velocity": theta * friction})
    sticking = rs.vary(normal, {"friction": math.inf, "tangential_velocity": 1.0})

    def arrays(impact: rs.Impact, size: int = PIECE) -> list[Callable[[], Any]]:
        parts = [impact.take(np.arange(start, start + size)) for start in range(0, COUNT, size)]
        return [lambda part=part: rs.solve(part, rtol=RTOL, errors="warn", workers=1) for part in parts]

    def one_by_one(impact: rs.Impact) -> list[Callable[[], Any]]:
        singles = [impact.take(np.asarray(n)) for n in range(COUNT)]
        parts = [singles[start : start + PIECE] for start in range(0, COUNT, PIECE)]
        return [lambda part=part: [rs.solve(each, rtol=RTOL, errors="warn") for each in part] for part in parts]

    kinds = {
        "normal, an array": arrays(normal, COUNT),
        "normal, one by one": one_by_one(normal),
        "oblique, an array": arrays(rough),
        "oblique, one by one": one_by_one(rough),
        "without slip, an array": arrays(sticking, COUNT),
        "without slip, one by one": one_by_one(sticking),
    }
    # The first round compiles.
    rounds = [{name: [spent(call) for call in calls] for name, calls in kinds.items()} for _ in range(1 + ROUNDS)]
    return [(name, float(np.min([each[name] for each in rounds[1:]], axis=0).sum()) / COUNT) for name in kinds]


def of_law() -> list[tuple[str, float]]:
    """Time [s] of one step of a contact that is loaded and unloaded, of two branches."""
    solid = rs.standard_solid(1e6, 1e7, 1e3, poisson_ratio=0.45)
    impact = rs.Impact(solid, rs.Parabola(0.01), 0.005, 1.0)
    law = rs.contact_law(impact, friction=0.3)
    press, drag = law.compiled, law.compiled_slide

    @numba.njit
    def smooth(state: Any, depths: Any, dt: float) -> float:
        total = 0.0
        for n in range(depths.size):
            total += press(state, depths[n], dt)
        return total

    @numba.njit
    def rough(state: Any, depths: Any, dt: float, way: Any, pull: Any) -> float:
        total = 0.0
        for n in range(depths.size):
            drag(state, press(state, depths[n], dt), way, dt, pull)
            total += pull[0]
        return total

    # Contacts of 50 steps, as in a code with 50 steps in a contact.
    depths = 1e-4 * np.tile(np.sin(np.linspace(0.0, math.pi, 50)), STEPS // 50)
    way, pull = np.array([1e-7, 0.0]), np.zeros(2)
    smooth(law.start(), depths, 1e-5)
    rough(law.start(), depths, 1e-5, way, pull)
    return [
        ("contact law, one step", least(lambda: smooth(law.start(), depths, 1e-5)) / depths.size),
        (
            "contact law with friction, one step",
            least(lambda: rough(law.start(), depths, 1e-5, way, pull)) / depths.size,
        ),
    ]


def main() -> None:
    solved, stepped = of_impacts(), of_law()
    bases = {"normal, an array": solved[0][1], "normal, one by one": solved[1][1]}
    lines = ["| what | time | over normal impacts in an array | over normal impacts one by one |", "|---|---|---|---|"]
    for name, seconds in solved:
        ratios = " | ".join(f"{seconds / base:.3g}" for base in bases.values())
        lines.append(f"| {name} | {1e6 * seconds:.3g} µs | {ratios} |")
    lines += ["", "| what | time | over the law without friction |", "|---|---|---|"]
    lines += [f"| {name} | {1e9 * s:.3g} ns | {s / stepped[0][1]:.3g} |" for name, s in stepped]
    text = "\n".join([*lines, ""])
    print(text)
    (FOLDER / "tables" / "oblique.md").write_text(text, encoding="utf-8")


if __name__ == "__main__":
    main()
