"""Rebound of a law without memory, F = k d^p + c d^q v: coefficient of restitution and contact time over its loss."""

from __future__ import annotations

from functools import cache
from typing import Any, Literal, NamedTuple

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
End = Literal["force", "overlap"]

# Losses of the table. Below them e = exp(-C b); above them the rebound is too slow to be of use.
_LOWEST = 1e-4
_NODES = 56
_DEGREE = 7
_RTOL = 1e-12


class Shape(NamedTuple):
    """Exponents of a law F = k d^p + c d^q v: of the spring (p) and of the dashpot (q)."""

    spring: float
    dashpot: float


VISCOELASTIC = Shape(1.5, 0.5)
"""Kuwabara and Kono (1987), Brilliantov and others (1996)."""

CONSTANT = Shape(1.5, 0.25)
"""Tsuji and others (1992): e is the same at every velocity."""

LINEAR = Shape(1.0, 0.0)
"""Linear spring and dashpot."""

# Largest losses of the table, with e of about 1e-5. With a pull, the overlap never vanishes from the critical loss on.
_HIGHEST = {
    (VISCOELASTIC, "overlap"): 12.0, (CONSTANT, "overlap"): 0.965 * 5.0**0.5, (LINEAR, "overlap"): 0.965 * 2.0,
}  # fmt: skip
_CRITICAL = {(CONSTANT, "overlap"): 5.0**0.5, (LINEAR, "overlap"): 2.0}
_HIGHEST_BY_FORCE = 1e3


def scales(shape: Shape, stiffness: Any, mass: Any, velocity: Any) -> tuple[Any, Any]:
    """Length [m] and time [s] in which k, m and v0 are 1: L = (m v0^2/k)^(1/(p+1)), L/v0."""
    length = (mass * velocity**2 / stiffness) ** (1.0 / (shape.spring + 1.0))
    return length, length / velocity


def loss(shape: Shape, stiffness: Any, damping: Any, mass: Any, velocity: Any) -> Any:
    """Loss b = c L^(q-p) v0/k [-], the only number on which the rebound depends."""
    length, _ = scales(shape, stiffness, mass, velocity)
    return damping * length ** (shape.dashpot - shape.spring) * velocity / stiffness


def rebound(shape: Shape, end: End, losses: Any) -> tuple[Array, Array]:
    """Coefficient of restitution and contact time over L/v0 at losses >= 0.

    The contact ends at zero force in the rebound ("force"), or pulls until zero overlap ("overlap"). Where the overlap
    never vanishes, e is 0 and the time infinite.
    """
    table, top = _table(shape, end), _HIGHEST.get((shape, end), _HIGHEST_BY_FORCE)
    b = np.asarray(losses, dtype=np.float64)
    log_loss, log_time = np.moveaxis(table(_place(shape, end, np.clip(b, _LOWEST, top))), -1, 0)
    # Below the table both logarithms are proportional to b.
    small = np.minimum(b / _LOWEST, 1.0)
    e, time = np.exp(-np.exp(log_loss) * small), elastic_time(shape) * np.exp(log_time * small)
    return np.where(b > top, 0.0, e), np.where(b > top, np.inf, time)


@cache
def elastic_time(shape: Shape) -> float:
    """Contact time over L/v0 without loss."""
    return one_rebound(shape, "overlap", 0.0)[1]


def one_rebound(shape: Shape, end: End, b: float) -> tuple[float, float]:
    """Coefficient of restitution and contact time at one loss, by integration of the equation of motion."""
    from scipy.integrate import solve_ivp

    p, q = 4.0 * shape.spring, 4.0 * shape.dashpot

    # With d = x^4 and dt = 4 x^3 ds all terms are powers of x, so that the motion is smooth at first touch.
    def motion(_: float, y: Array) -> tuple[float, float, float]:
        x, v = max(y[0], 0.0), y[1]
        return v, -4.0 * x**3 * (x**p + b * x**q * v), 4.0 * x**3

    def force(_: float, y: Array) -> float:
        return max(y[0], 0.0) ** (p - q) + b * y[1]

    def overlap(s: float, y: Array) -> float:
        return y[0] if s > 0.0 else 1.0

    event: Any = force if end == "force" and b > 0.0 else overlap
    event.terminal, event.direction = True, -1.0
    found = solve_ivp(motion, (0.0, 1e6), (0.0, 1.0, 0.0), "DOP853", rtol=_RTOL, atol=1e-14, events=event)
    _, v, time = found.y[:, -1]
    return -float(v), float(time)


def _place(shape: Shape, end: End, b: Any) -> Any:
    """Variable of the table: log b, stretched towards the critical loss."""
    return np.log(b) - np.log1p(-b / _CRITICAL.get((shape, end), np.inf))


@cache
def _table(shape: Shape, end: End) -> Any:
    """Spline of log(-log e) and the logarithm of the time over that without loss."""
    from scipy.interpolate import make_interp_spline

    highest = _HIGHEST.get((shape, end), _HIGHEST_BY_FORCE)
    places = np.linspace(_place(shape, end, _LOWEST), _place(shape, end, highest), _NODES)
    losses = 1.0 / (np.exp(-places) + 1.0 / _CRITICAL.get((shape, end), np.inf))
    e, time = np.transpose([one_rebound(shape, end, float(b)) for b in losses])
    return make_interp_spline(
        places, np.stack([np.log(-np.log(e)), np.log(time / elastic_time(shape))], axis=-1), k=_DEGREE
    )
