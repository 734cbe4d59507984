"""The equations of one impact for SciPy's `solve_ivp`, in as few operations as NumPy allows.

A parabola on a Prony series without dashpot, in units of mass and impact velocity, with a = s. These are the equations
of `tests/scipy_oracle.py` with free tolerances, without contact time, peaks and events other than the turning
point. The time is therefore that of the integration alone.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from scipy.integrate import solve_ivp

from restitution.impact.scaling import ScaledImpact


class Reference(NamedTuple):
    """Restitution coefficient and evaluations of the right-hand side."""

    restitution_coefficient: float
    evaluations: int


class Unsuited(Exception):
    """The method fails or needs too many evaluations, as an explicit method for stiff equations."""


def solve(impact: ScaledImpact, method: str, rtol: float, most: int = 1_000_000) -> Reference:
    """Restitution coefficient by a method of `solve_ivp` at its own tolerance `rtol`.

    Raises
    ------
    Unsuited
        If the right-hand side is evaluated more often than `most`, or the step falls to rounding level.
    """
    equilibrium, moduli, rates = impact.equilibrium, impact.moduli, 1.0 / impact.times
    n = moduli.size
    atol = 1e-3 * rtol
    count = 0

    def evaluated() -> None:
        nonlocal count
        count += 1
        if count > most:
            raise Unsuited

    # y = (s, t, v, Y_k, W_k) over sigma, Pi = 2 s^3/3.
    def approach(_: float, y: np.ndarray) -> np.ndarray:
        evaluated()
        s, v = y[0], y[2]
        dt = 2.0 * s
        force = equilibrium * (2.0 / 3.0) * s**3 + moduli @ y[3 : 3 + n]
        dy = np.empty_like(y)
        dy[0], dy[1], dy[2] = v, dt, -dt * force
        dy[3 : 3 + n] = dt * (s * v - rates * y[3 : 3 + n])
        dy[3 + n :] = dy[2] - dt * rates * y[3 + n :]
        return dy

    def turns(_: float, y: np.ndarray) -> float:
        return y[2]

    turns.terminal = True
    start = np.concatenate([[0.0, 0.0, 1.0], np.zeros(n), np.ones(n)])
    there = solve_ivp(
        approach, (0.0, np.inf), start, method=method, rtol=rtol, atol=atol, events=turns, dense_output=True
    )
    if there.status < 0:
        raise Unsuited(there.message)
    end, past = there.t[-1], there.sol

    # z = (t, v, W_k) over lambda.
    def rebound(way: float, z: np.ndarray) -> np.ndarray:
        evaluated()
        y = past(end - way)
        s, v1, v = y[0], y[2], z[1]
        fading = np.exp(-rates * max(z[0] - y[1], 0.0))
        weighted = moduli * fading
        force = equilibrium * (2.0 / 3.0) * s**3 + weighted @ y[3 : 3 + n]
        q = equilibrium * v + moduli @ z[2:] + weighted @ (v1 - y[3 + n :])
        dz = np.empty_like(z)
        dt = -2.0 * s * v1 * (equilibrium + weighted.sum()) / q
        dz[0], dz[1] = dt, -force * dt
        dz[2:] = dt * (-force - rates * z[2:])
        return dz

    # dt/dlambda is 0/0 at the turning point, with the limit 2 s; close to it the response is glassy.
    y, way = past(end), 1e-9 * end
    after = 2.0 * y[0] * way
    force = equilibrium * (2.0 / 3.0) * y[0] ** 3 + moduli @ y[3 : 3 + n]
    begin = np.concatenate([[y[1] + after, -force * after], y[3 + n :] - after * (force + rates * y[3 + n :])])
    back = solve_ivp(rebound, (way, end), begin, method=method, rtol=rtol, atol=atol, first_step=0.1 * way)
    if back.status < 0:
        raise Unsuited(back.message)
    return Reference(-float(back.y[1, -1]), count)
