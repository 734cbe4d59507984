"""Compliance of an elastic layer on a rigid base, in Hankel space and as the kernel of its line load.

Lengths are in units of the thickness h. A pressure p(k) in Hankel space displaces the surface of the layer by
``u(k) = (2/(E* k)) K(kh) p(k)``; K = 1 is the half-space. The line load q(x) of the foundation obeys ``q(x) -
int m(x - y) q(y) dy = E* u(x)`` with ``m(t) = (1/pi) int_0^inf (1 - K(z)) cos(zt) dz``.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from restitution.contact.geometry import Array

# The integrand is below 1e-19 beyond; nodes of a panel, and panels for each period of the fastest cosine.
_LAST, _NODES, _PANELS = 26.0, 16, 1.2
# Ends of the intervals of t on which m(t) has a Chebyshev series. Its singularities are at t = +-2i, +-4i, ...
_ENDS = np.array([0.0, 1.0, 2.0, 4.0, 8.0, 16.0, 32.0, 80.0])
_DEGREE = 26
# Cells of equal width that replace the series: quick to find, and their degree is 1e-16 there.
_CELLS, _CELL_DEGREE = 8, 9


def missing_compliance(z: Array, poisson_ratio: float | None) -> Array:
    """Missing compliance 1 - K(z) [-] of a bonded layer of a Poisson ratio, or on a frictionless base for None.

    Examples
    --------
    A thin layer of the Poisson ratio 0 has K = z/2.

    >>> print(1.0 - missing_compliance(np.array([1e-6]), 0.0) / 1.0)
    [5.e-07]
    """
    fast = np.exp(-2.0 * z)
    if poisson_ratio is None:
        return (
            2.0 * fast * (2.0 * z - np.expm1(-2.0 * z)) / np.where(z > 0.0, 4.0 * z * fast - np.expm1(-4.0 * z), 1.0)
        )
    n = 3.0 - 4.0 * poisson_ratio
    square = 1.0 + n * n + 4.0 * z * z
    return fast * (2.0 * n * fast + square + 4.0 * z) / (n * (1.0 + fast * fast) + square * fast)


class LineKernel:
    """Kernel m(t) of the line load for |t| <= 80, by piecewise polynomials that are exact to rounding.

    Attributes
    ----------
    cells : array
        Coefficients of polynomials over cells of equal width in t, over [-1, 1] in each, highest power first.
    per_unit : float
        Cells for each unit of t.
    """

    def __init__(self, poisson_ratio: float | None) -> None:
        nodes, weights = np.polynomial.legendre.leggauss(_NODES)
        panels = math.ceil(_LAST * _ENDS[-1] * _PANELS / (2.0 * math.pi))
        width = _LAST / panels
        z = (width * (np.arange(panels)[:, None] + 0.5 + 0.5 * nodes)).ravel()
        load = np.tile(0.5 * width / math.pi * weights, panels) * missing_compliance(z, poisson_ratio)
        angle = np.pi * (np.arange(_DEGREE + 1) + 0.5) / (_DEGREE + 1)
        low, high = _ENDS[:-1, None], _ENDS[1:, None]
        t = 0.5 * (low + high) + 0.5 * (high - low) * np.cos(angle)
        # Pairwise sums: errors of m grow 1e5-fold on thin incompressible layers.
        values = np.sum(np.cos(t.ravel()[:, None] * z) * load, axis=1).reshape(t.shape)
        basis: Any = np.cos(np.arange(_DEGREE + 1)[:, None] * angle) * (2.0 / (_DEGREE + 1))
        basis[0] *= 0.5
        self.series: Array = values @ basis.T
        place = np.cos(np.pi * (np.arange(_CELL_DEGREE + 1) + 0.5) / (_CELL_DEGREE + 1))
        centre = (np.arange(int(_CELLS * _ENDS[-1])) + 0.5)[:, None]
        samples: Any = np.linalg.solve(
            np.vander(place, increasing=True), self.exact((centre + 0.5 * place) / _CELLS).T
        )
        self.cells: Array = np.ascontiguousarray(samples[::-1])
        self.per_unit = float(_CELLS)

    def exact(self, t: Array) -> Array:
        """Kernel at t in [0, 80] from its series."""
        piece = np.clip(np.searchsorted(_ENDS, t, side="right") - 1, 0, len(_ENDS) - 2)
        low, high = _ENDS[piece], _ENDS[piece + 1]
        place = (2.0 * t - low - high) / (high - low)
        value: Any = np.polynomial.chebyshev.chebval(place, np.moveaxis(self.series[piece], -1, 0), tensor=False)
        return value
