"""The profile as the kernel sees it: contact radius over the square root of the depth."""

from typing import Any, NamedTuple

import numpy as np

from restitution.kernel.compile import part, stage
from restitution.kernel.lanes import WIDTH, at_least, exp, load, log, spread, where_positive


class Path(NamedTuple):
    """Contact radius a(s) with depth d = s^2, dimensionless.

    Attributes
    ----------
    exponent : float
        p of a = s^p; negative where the table below holds instead.
    inverse_cell : float
        Reciprocal width of the table's cells in s.
    radius : ndarray, shape (n_cells, n)
        Polynomial coefficients of a over the cell's own coordinate in [0, 1], constant first.
    integral : ndarray, shape (n_cells, n + 2)
        The same for `Pi = int_0^s a 2 s ds`.
    """

    exponent: float
    inverse_cell: float
    radius: Any
    integral: Any


def power_path(exponent: float) -> Path:
    """Return the path a = s^p of parabola (p = 1), cone (2), flat punch (0) or r^n (2/n)."""
    return Path(float(exponent), 0.0, np.zeros((0, 1)), np.zeros((0, 1)))


@stage
def _table(path: Path, s: float) -> tuple[float, float, float]:
    """Contact radius a, Pi and da/ds at s from the table; out of line, which keeps the code of the power laws short."""
    y = max(s, 0.0) * path.inverse_cell
    cell = min(int(y), path.radius.shape[0] - 1)
    y -= cell
    a = 0.0
    slope = 0.0
    for n in range(path.radius.shape[1] - 1, -1, -1):
        slope = slope * y + a
        a = a * y + path.radius[cell, n]
    integral = 0.0
    for n in range(path.integral.shape[1] - 1, -1, -1):
        integral = integral * y + path.integral[cell, n]
    return a, integral, slope * path.inverse_cell


@part
def radius_and_integral(path: Path, s: float) -> tuple[float, float]:
    """Contact radius a and Pi at s."""
    p = path.exponent
    if p == 1.0:
        return s, (2.0 / 3.0) * s * s * s
    if p >= 0.0:
        a = max(s, 0.0) ** p
        return a, 2.0 / (p + 2.0) * s * s * a
    a, integral, _ = _table(path, s)
    return a, integral


@part
def radii_and_integrals(path: Path, s: Any, scratch: Any) -> Any:
    """Contact radii a and Pi at eight s; `scratch` has two rows."""
    p = path.exponent
    if p == 1.0:
        a = s
    elif p == 0.0:
        a = spread(1.0)
    elif p == 2.0:
        a = s * s
    elif p > 0.0:
        a = where_positive(s, exp(at_least(p * log(at_least(s, 1e-300)), -700.0)))
    else:
        return _tables(path, s, scratch)
    return a, (2.0 / (p + 2.0)) * (s * s * a)


@part
def _tables(path: Path, s: Any, scratch: Any) -> Any:
    """The same from the table."""
    for i in range(WIDTH):
        scratch[0, i], scratch[1, i], _ = _table(path, s[i])
    return load(scratch[0], 0), load(scratch[1], 0)


@part
def radius_slope(path: Path, s: float, a: float) -> float:
    """Slope da/ds at s > 0, where the radius is a."""
    if path.exponent >= 0.0:
        return path.exponent * a / s
    return _table(path, s)[2]
