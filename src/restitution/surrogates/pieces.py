"""Chebyshev series of functions on pieces of an interval, which are halved until the error is small."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.polynomial.chebyshev import chebpts1, chebpts2, chebvander

from restitution.checks import Array
from restitution.surrogates.velocity import DEEPEST, Pieces

Piece = tuple[int, int]

DEGREE = 12
MOST = 512
"""Degree of the series, and the most pieces."""

# Random points in each piece for the measurement of the error, and a factor for the error between them.
_FRESH = 16
_BETWEEN_POINTS = 2.0
# The ends are nodes, so that neighbouring pieces join. The error is largest half-way between the nodes.
_NODES, _BETWEEN = chebpts2(DEGREE + 1), chebpts1(DEGREE)
_TO_COEFFICIENTS = np.linalg.inv(chebvander(_NODES, DEGREE))


class NotMet(Exception):
    """Error of 512 pieces, or of a piece halved twelve times, above the tolerance: function, place and error."""

    def __init__(self, function: int, place: float, error: float) -> None:
        super().__init__(f"error {error:.2g} of function {function} at {place:g}")
        self.function, self.place, self.error = function, place, error


def build_pieces(
    sample: Callable[[Array], Array],
    deviation: Callable[[Array, Array], Array],
    low: float,
    high: float,
    tolerance: float,
    report: Callable[[int, int], None] | None = None,
) -> tuple[Pieces, Array]:
    """Interpolate functions on pieces of an interval, halved until the error is at most the tolerance.

    `sample` returns values, shape (n_function, n), at n points, and `deviation` the error of each from approximate and
    exact values. The second result is twice the largest error of each function at points that are no nodes.
    """
    rng = np.random.default_rng(20)
    # Pieces as (level, place); they begin at the share place 2^-level of the interval.
    open_: list[Piece] = [(0, 0)]
    accurate: dict[Piece, tuple[Array, Array]] = {}
    while open_:
        following: list[Piece] = []
        levels, places = np.array(open_).T
        width = (high - low) * 0.5**levels
        left = low + width * places
        fresh = rng.uniform(-1.0, 1.0, (len(open_), _FRESH))
        fixed = np.broadcast_to(np.concatenate([_NODES, _BETWEEN]), (len(open_), 2 * DEGREE + 1))
        local = np.hstack([fixed, fresh])
        # Rounding must not move a point out of the interval.
        points = np.clip(left[:, None] + 0.5 * width[:, None] * (local + 1.0), low, high)
        values = sample(points.ravel()).reshape(-1, *points.shape)
        coefficients = values[:, :, : DEGREE + 1] @ _TO_COEFFICIENTS.T
        tested = slice(DEGREE + 1, None)
        approximate = np.einsum("pcd,fpd->fpc", chebvander(local[:, tested], DEGREE), coefficients)
        errors = _BETWEEN_POINTS * np.nan_to_num(deviation(approximate, values[:, :, tested]), nan=np.inf)
        for n, (level, place) in enumerate(open_):
            here = errors[:, n]
            if np.all(here <= tolerance):
                accurate[level, place] = coefficients[:, n], here.max(axis=1)
                continue
            if level == DEEPEST or len(accurate) + len(following) > MOST:
                function, at = np.unravel_index(np.argmax(here), here.shape)
                raise NotMet(int(function), float(points[n, tested][at]), float(here[function, at]))
            following += [(level + 1, 2 * place), (level + 1, 2 * place + 1)]
        open_ = following
        if report is not None:
            report(len(accurate), len(accurate) + len(open_))
    ordered = sorted(accurate, key=lambda piece: piece[1] * 0.5 ** piece[0])
    lefts = [low + (high - low) * place * 0.5**level for level, place in ordered]
    series, error = zip(*(accurate[piece] for piece in ordered), strict=True)
    return Pieces(np.array([*lefts, high]), np.stack(series, axis=1)), np.max(error, axis=0)
