"""The contact law with friction in velocity Verlet, against the exact tangential restitution.

Run as `python validation/law_friction.py`; prints a table and writes it to `law_friction.md` beside this file. It
takes a minute.
"""

from __future__ import annotations

import math
import sys
from pathlib import Path
from typing import Any

import numba
import numpy as np

import restitution as rs
from restitution.law.slide import slide
from restitution.law.step import step

sys.path.append(str(Path(__file__).resolve().parent))
import pages
from oblique_balls import rough, smooth

COUNTS = (25, 50, 100, 200, 400)
# Poisson ratio, p2, p3 and v_c0/(mu v0).
ROWS = (
    (0.5, 0.1, 1.0, 1.0),
    (0.3, 0.1, 1.0, 2.0),
    (0.5, 0.1, 1.0, 4.0),
    (0.3, 0.01, 1.0, 1.5),
    (0.45, 0.01, 0.1, 1.0),
)
RANDOM, FRICTION = 1000, 0.3


@numba.njit
def throw(law, grip, state, mobility, along, dt, way, pull):
    """Velocity and tangential velocity of the contact point after an impact with m = v0 = 1, least work done."""
    depth, v, point, force, before, work, least = state[2], 1.0, along, 0.0, 0.0, 0.0, 0.0
    while force > 0.0 or v > 0.0:
        v, point = v - 0.5 * dt * force, point - 0.5 * dt * mobility * before
        depth += v * dt
        way[0] = point * dt
        force = step(law, state, depth, dt)
        slide(law, grip, state, force, way, dt, pull)
        work += 0.5 * (before + pull[0]) * way[0]
        least, before = min(least, work), pull[0]
        v, point = v - 0.5 * dt * force, point - 0.5 * dt * mobility * before
    return v, point, least


def exact(nu: float, p2: float, p3: float, theta: float, friction: float) -> tuple[Any, float, float]:
    """The normal impact, its contact time and e_t."""
    impact = smooth(rs.standard_solid(1.0, 1.0 / p2, p3, poisson_ratio=nu))
    result = rough(impact, friction, theta)
    return impact, float(result.contact_time), float(result.tangential_restitution_coefficient)


def by_law(impact: Any, time: float, theta: float, friction: float, steps: int, gap: float, nodes: int) -> Any:
    """e_t and the least work over the tangential energy, with first touch at a share of a step."""
    law, dt = rs.contact_law(impact, friction=friction, max_nodes=nodes), time / steps
    along, state = theta * friction, law.start(depth=-gap * dt)
    _, point, least = throw(law.constants, law.grip, state, 3.5, along, dt, np.zeros(2), np.zeros(2))
    return -point / along, least / (along * along / 7.0)


def main() -> None:
    lines = [
        "Largest error of $e_t$ of a solid ball with friction 0.3 by the contact law in velocity Verlet, over first "
        "touches",
        "at three places within a step (`validation/law_friction.py`):",
        "",
        "| $\\nu$, $p_2$, $p_3$ | $v_{c0}/(\\mu v_0)$ | exact $e_t$ | "
        + " | ".join(f"{n} steps" for n in COUNTS)
        + " | order |",
        "|---" * (len(COUNTS) + 4) + "|",
    ]
    for nu, p2, p3, theta in ROWS:
        impact, time, e_t = exact(nu, p2, p3, theta, FRICTION)
        errors = [
            max(abs(by_law(impact, time, theta, FRICTION, n, gap, 500)[0] - e_t) for gap in (0.0, 0.3, 0.6))
            for n in COUNTS
        ]
        order = -np.polyfit(np.log(COUNTS), np.log(errors), 1)[0]
        cells = " | ".join(f"{error:.1e}" for error in errors)
        lines.append(f"| {nu:g}, {p2:g}, {p3:g} | {theta:g} | {e_t:.6f} | {cells} | {order:.2f} |")
    rng, result = np.random.default_rng(7), []
    for _ in range(RANDOM):
        nu, p2, p3 = rng.uniform(-0.9, 0.5), 10.0 ** rng.uniform(-3.0, 1.0), 10.0 ** rng.uniform(-2.0, 2.0)
        theta, friction = 10.0 ** rng.uniform(-1.0, 1.0), 10.0 ** rng.uniform(-1.5, 0.5)
        impact, time, e_t = exact(nu, p2, p3, theta, friction)
        if math.isfinite(e_t):
            runs = [by_law(impact, time, theta, friction, n, float(rng.uniform()), 64) for n in (50, 100)]
            result.append(
                [abs(value - e_t) for value, _ in runs]
                + [max(abs(value) for value, _ in runs)]
                + [min(least for _, least in runs)]
            )
    table = np.array(result)
    fifty, hundred = (np.quantile(table[:, k], (0.5, 0.99, 1.0)) for k in range(2))
    lines += [
        "",
        f"Of {len(table)} random impacts (Poisson ratio from -0.9 to 0.5, $p_2$ from $10^{{-3}}$ to 10, $p_3$ from",
        "$10^{-2}$ to 100, $v_{c0}/(\\mu v_0)$ from 0.1 to 10), with 64 nodes and 50 steps per contact, the error of",
        f"$e_t$ has the median {fifty[0]:.1e}, the 99th percentile {fifty[1]:.1e} and the maximum {fifty[2]:.1e};",
        f"with 100 steps {hundred[0]:.1e}, {hundred[1]:.1e} and {hundred[2]:.1e}. The largest $|e_t|$ is "
        f"{table[:, 2].max():.3f}.",
        "No contact ever returned more work than it had got: the least work is "
        f"{table[:, 3].min():.1g} of the tangential energy.",
    ]
    pages.write(__file__, lines)


if __name__ == "__main__":
    main()
