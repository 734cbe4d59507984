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
from typing import Any, NamedTuple

import numba
import numpy as np
from numpy.typing import ArrayLike, NDArray

from restitution.checks import Array, common_shape, within
from restitution.kernel.compile import cached

P2 = (1e-3, 10.0)
P3 = (1e-2, 100.0)
"""Ends of the plane."""

STATED_ERROR = 1e-6
"""Bound of the error of e."""

TERMS = 8
"""Terms of a series, in each of its three variables."""

# Powers of ten at the ends of the plane may be off by rounding.
_SLACK = 1e-12
_SLOPES = (0.5, 0.07)
_INVERSE_LN10 = 1.0 / math.log(10.0)


def compiled(function: Any, **flags: Any) -> Any:
    """Compile a function on its first call, and cache its machine code if possible."""
    return cached(numba.njit(nogil=True, error_model="numpy", **flags)(function), function)


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
    values = {
        "nu": within("nu", nu, -1.0, 0.5),
        "p2": within("p2", p2, P2[0] * (1.0 - _SLACK), P2[1] * (1.0 + _SLACK)),
        "p3": within("p3", p3, P3[0] * (1.0 - _SLACK), P3[1] * (1.0 + _SLACK)),
    }
    shape = common_shape({name: np.shape(group) for name, group in values.items()})
    # Copies, as the compiler makes a version for each kind of views.
    columns = [np.array(np.broadcast_to(group, shape), order="C").reshape(-1) for group in values.values()]
    e = np.empty(columns[0].size)
    restitution(*columns, _boxes(), e)
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


class Boxes(NamedTuple):
    """Tensor Chebyshev series of three variables in boxes, ready for look-up.

    From the corner `low` on, a grid with `scale` cells per unit of each variable contains the box of each cell. A box
    has the `middle`, `inverse` is that of half its width, and `coefficients` have the shape (n_box, TERMS, TERMS**2).
    """

    low: Array
    scale: Array
    cells: NDArray[np.int16]
    middle: Array
    inverse: Array
    coefficients: NDArray[np.float32]


def ready_boxes(levels: Any, places: Any, coefficients: Any) -> tuple[Any, ...]:
    """Prepare boxes for look-up: `Boxes` as a plain tuple.

    They begin at `low + (high - low) places/2^levels` and are `(high - low)/2^levels` wide, between the `corners`.
    """
    low, high = corners()
    cells = cell_grid(levels, places)
    width = (high - low) * 0.5**levels
    scale, middle, inverse = np.array(cells.shape) / (high - low), low + width * (places + 0.5), 2.0 / width
    return tuple(Boxes(low, scale, cells, middle, inverse, coefficients.reshape(-1, TERMS, TERMS * TERMS)))


def cell_grid(levels: Any, places: Any) -> NDArray[np.int16]:
    """Return the box of each cell of a grid of the smallest width along each variable; -1 where there is none."""
    finest = levels.max(axis=0)
    cells = np.full(tuple(2**finest), -1, dtype=np.int16)
    for n, (level, place) in enumerate(zip(levels, places, strict=True)):
        first = place * 2 ** (finest - level)
        cells[tuple(slice(a, a + 2**b) for a, b in zip(first, finest - level, strict=True))] = n
    return cells


# Multiplications and additions may be fused, because no other code must reproduce the last bit.
_FLAGS: dict[str, Any] = {"fastmath": {"contract"}, "forceinline": True}


@partial(compiled, **_FLAGS)
def _polynomials(t: float, terms: Any, variable: int) -> None:
    """Write the Chebyshev polynomials of one variable into their row; a slice would count references."""
    terms[variable, 0] = 1.0
    terms[variable, 1] = t
    for k in range(2, TERMS):
        terms[variable, k] = 2.0 * t * terms[variable, k - 1] - terms[variable, k - 2]


@partial(compiled, **_FLAGS)
def box_value(x: float, y: float, z: float, terms: Any, rows: Any, boxes: Any) -> float:
    """Return the value of boxes at a point; `terms` (3, TERMS) and `rows` (TERMS^2,) are scratch."""
    low, scale, cells, middle, inverse, c = boxes
    i = min(max(int((x - low[0]) * scale[0]), 0), cells.shape[0] - 1)
    j = min(max(int((y - low[1]) * scale[1]), 0), cells.shape[1] - 1)
    k = min(max(int((z - low[2]) * scale[2]), 0), cells.shape[2] - 1)
    box = cells[i, j, k]
    _polynomials((x - middle[box, 0]) * inverse[box, 0], terms, 0)
    _polynomials((y - middle[box, 1]) * inverse[box, 1], terms, 1)
    _polynomials((z - middle[box, 2]) * inverse[box, 2], terms, 2)
    t0, t1, t2, t3 = terms[0, 0], terms[0, 1], terms[0, 2], terms[0, 3]
    t4, t5, t6, t7 = terms[0, 4], terms[0, 5], terms[0, 6], terms[0, 7]
    # One explicit loop over a whole row uses the vector units: 70 ns instead of 210 ns.
    for m in range(TERMS * TERMS):
        rows[m] = (
            c[box, 0, m] * t0 + c[box, 1, m] * t1 + c[box, 2, m] * t2 + c[box, 3, m] * t3
            + c[box, 4, m] * t4 + c[box, 5, m] * t5 + c[box, 6, m] * t6 + c[box, 7, m] * t7
        )  # fmt: skip
    total = 0.0
    for b in range(TERMS):
        over_z = 0.0
        for m in range(TERMS):
            over_z += rows[TERMS * b + m] * terms[2, m]
        total += over_z * terms[1, b]
    return total


@partial(compiled, fastmath={"contract"})
def restitution(nu: Any, p2: Any, p3: Any, boxes: Any, out: Any) -> None:
    """Write the restitution coefficient at arrays of nu, p2, p3 within the plane."""
    terms, rows = np.empty((3, TERMS)), np.empty(TERMS * TERMS)
    for n in range(out.size):
        q = 1.0 + 1.0 / p2[n]
        log_q = math.log(q)
        r = ((1.0 + nu[n]) + 2.0 * q * (1.0 - 2.0 * nu[n])) / (3.0 * (1.0 - nu[n]))
        x = math.log(r) / log_q
        y = math.log(p2[n]) * _INVERSE_LN10
        slope = _SLOPES[0] if x < 0.5 else _SLOPES[1]
        z = (math.log(p2[n] * p3[n]) + (0.4 + slope * x) * log_q) * _INVERSE_LN10
        out[n] = box_value(x, y, z, terms, rows, boxes)


@cache
def _boxes() -> tuple[Any, ...]:
    data_file = files("restitution.surrogates") / "data" / "standard_solid.npz"
    with as_file(data_file) as path, np.load(path) as data:
        levels, places = data["levels"].astype(np.int64), data["places"].astype(np.int64)
        return ready_boxes(levels, places, data["coefficients"])
