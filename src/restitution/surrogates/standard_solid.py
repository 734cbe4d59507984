"""The paper's restitution coefficient by interpolation over the plane of its figures.

The reduced modulus of the compressible standard solid relaxes at tau and at tau r, with r from 1 (incompressible) to
q = 1 + 1/p2, the glassy over the equilibrium shear modulus (nu = -1). In these coordinates e is smooth::

    x = log r/log q                             from 0 to 1 as nu goes from 1/2 to -1
    y = log10 p2
    z = log10(p2 p3) + (2/5 + c x) log10 q

Here p2 p3 is tau over a time scale of the impact at the equilibrium modulus, and q^(2/5) converts this scale to the
glassy modulus. For small p2, e nearly has a kink at a certain value of that ratio, and q^(c x) follows the kink as x
changes: c = 1/2, half-way from tau to tau r, for x < 1/2; beyond, where the other branch causes the kink, c = 0.07.
"""

from __future__ import annotations

import math
from functools import cache, partial
from importlib.resources import as_file, files
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from restitution.checks import Array, within
from restitution.errors import InputError
from restitution.surrogates.evaluation import TERMS, Boxes, box_value, compiled, ready_boxes

P2 = (1e-3, 10.0)
P3 = (1e-2, 100.0)
"""Ends of the plane."""

STATED_ERROR = 1e-6
"""Bound of the error of e."""

# Powers of ten at the ends of the plane may be off by rounding.
_SLACK = 1e-12
_SLOPES = (0.5, 0.07)
_INVERSE_LN10 = 1.0 / math.log(10.0)


def standard_solid_surrogate(nu: ArrayLike, p2: ArrayLike, p3: ArrayLike) -> Any:
    """Interpolate the restitution coefficient e(p1, p2, p3) of a rigid sphere on a compressible standard solid.

    The same as `standard_solid_restitution` to an absolute error of 1e-6, over the plane of the paper's figures and
    for all Poisson ratios, in about 0.1 us per point.

    Parameters
    ----------
    nu : array_like
        p1, static Poisson ratio, in [-1, 0.5]; 0.5 means incompressible.
    p2 : array_like
        Equilibrium over branch modulus, Ginf/G1, in [1e-3, 10].
    p3 : array_like
        `eta (v0 R/(m^2 Ginf^3))^(1/5)`, in [1e-2, 100].

    Returns
    -------
    float or ndarray
        e, in the common shape of the three.

    Raises
    ------
    InputError
        If a number is out of range; nothing is extrapolated.

    Notes
    -----
    Tensor Chebyshev series in boxes, in the coordinates of `restitution.surrogates.standard_solid`. The data come with
    the package; `validation/standard_solid_surrogate.py` makes them and measures the error at 200 000 random points.

    Examples
    --------
    >>> print(round(standard_solid_surrogate(0.49, 1e-3, 10.0), 5))
    0.21971
    """
    values = (
        within("nu", nu, -1.0, 0.5),
        within("p2", p2, P2[0] * (1.0 - _SLACK), P2[1] * (1.0 + _SLACK)),
        within("p3", p3, P3[0] * (1.0 - _SLACK), P3[1] * (1.0 + _SLACK)),
    )
    shapes = [np.shape(group) for group in values]
    try:
        shape = np.broadcast_shapes(*shapes)
    except ValueError:
        raise InputError("nu, p2, p3", rule=f"must have shapes that broadcast, not {shapes}") from None
    columns = [np.broadcast_to(group, shape).reshape(-1) for group in values]
    e = np.empty(columns[0].size)
    restitution(*columns, *_boxes(), e)
    return e.reshape(shape) if shape else float(e[0])


def corners() -> tuple[Array, Array]:
    """Return the lowest and highest x, y, z."""
    (y_low, y_high), (z_low, z_high) = np.log10([P2, P3])
    x = np.array([0.0, 0.5 - 1e-12, 0.5, 1.0])
    low, high = np.array([0.0, y_low, z_low]), np.array([1.0, y_high, z_high])
    # z grows with y and, in each half, with x.
    low[2] += _shift(x, y_low).min()
    high[2] += _shift(x, y_high).max()
    return low, high


def groups(points: Array) -> tuple[Array, Array, Array]:
    """Return nu, p2, p3 at points x, y, z, shape (n, 3)."""
    x, y, z = points.T
    q = 1.0 + 10.0**-y
    r = q**x
    # r = ((1 + nu) + 2 q (1 - 2 nu))/(3 (1 - nu)), solved for nu.
    nu = (1.0 + 2.0 * q - 3.0 * r) / (4.0 * q - 1.0 - 3.0 * r)
    return np.clip(nu, -1.0, 0.5), 10.0**y, 10.0 ** (z - _shift(x, y))


def _shift(x: Any, y: Any) -> Any:
    """Return z - log10 p3."""
    return y + (0.4 + np.where(x < 0.5, *_SLOPES) * x) * np.log10(1.0 + 10.0**-y)


@partial(compiled, fastmath={"contract"})
def restitution(
    nu: Any, p2: Any, p3: Any, low: Any, scale: Any, cells: Any, middle: Any, inverse: Any, c: Any, out: Any
) -> None:
    """Write the restitution coefficient at arrays of nu, p2, p3 within the plane; the rest are arrays of the boxes."""
    terms, rows = np.empty((3, TERMS)), np.empty(TERMS * TERMS)
    for n in range(out.size):
        q = 1.0 + 1.0 / p2[n]
        log_q = math.log(q)
        r = ((1.0 + nu[n]) + 2.0 * q * (1.0 - 2.0 * nu[n])) / (3.0 * (1.0 - nu[n]))
        x = math.log(r) / log_q
        y = math.log(p2[n]) * _INVERSE_LN10
        slope = _SLOPES[0] if x < 0.5 else _SLOPES[1]
        z = (math.log(p2[n] * p3[n]) + (0.4 + slope * x) * log_q) * _INVERSE_LN10
        out[n] = box_value(x, y, z, terms, rows, low, scale, cells, middle, inverse, c)


@cache
def _boxes() -> Boxes:
    data_file = files("restitution.surrogates") / "data" / "standard_solid.npz"
    with as_file(data_file) as path, np.load(path) as data:
        levels, places = data["levels"].astype(np.int64), data["places"].astype(np.int64)
        return ready_boxes(*corners(), levels, places, data["coefficients"])
