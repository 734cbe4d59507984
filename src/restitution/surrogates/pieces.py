"""Piecewise Chebyshev interpolants of several functions of one variable, built adaptively."""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

DEGREE = 12
DEEPEST = 12
MOST = 512
"""Halvings of a piece, and pieces, at most."""

_FRESH = 32

_ANGLES = np.linspace(0.0, np.pi, DEGREE + 1)
# Ends included, so that neighbours agree where they meet.
_NODES = np.cos(_ANGLES)
# Half-way between the nodes, where the error of the interpolant is largest.
_BETWEEN = np.cos(0.5 * (_ANGLES[1:] + _ANGLES[:-1]))
# The first and the last node and coefficient count half.
_HALVES = np.where(np.arange(DEGREE + 1) % DEGREE == 0, 0.5, 1.0)
_TO_COEFFICIENTS = (
    2.0 / DEGREE * _HALVES[:, None] * np.cos(np.outer(np.arange(DEGREE + 1), _ANGLES)) * _HALVES
)


class Pieces(NamedTuple):
    """Chebyshev series on the pieces of an interval.

    Attributes
    ----------
    edges : array, shape (n_piece + 1,)
        Ends of the pieces, increasing.
    coefficients : array, shape (n_function, n_piece, degree + 1)
        Of the Chebyshev polynomials in the local variable, which runs from -1 to 1 over a piece.
    """

    edges: Array
    coefficients: Array


class NotMet(Exception):
    """The tolerance was not met.

    Attributes
    ----------
    function : int
        Which function.
    place : float
        Where, in its variable.
    error : float
        Error there.
    """

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
    """Interpolate functions piece by piece, halving pieces until the error is met.

    Parameters
    ----------
    sample : callable
        Takes points, shape (n,), and returns values, shape (n_function, n).
    deviation : callable
        Takes approximate and exact values and returns the error of each, in their shape.
    low, high : float
        The interval.
    tolerance : float
        Largest error allowed.
    report : callable, optional
        Called with (pieces that meet it, all pieces) after each round.

    Returns
    -------
    pieces : Pieces
        The interpolants.
    error : array, shape (n_function,)
        Largest error at points that made no interpolant: half-way between those that did, and at random ones.

    Raises
    ------
    NotMet
        If it is still missed after a piece was halved twelve times, or by 512 pieces.
    """
    rng = np.random.default_rng(20)
    # Pieces as (level, place): place times 2^-level of the interval is where they begin.
    open_, done = [(0, 0)], dict[tuple[int, int], Array]()
    worst: dict[tuple[int, int], Array] = {}
    while open_:
        levels, places = np.array(open_).T
        width = (high - low) * 0.5**levels
        left = low + width * places
        drawn = rng.uniform(-1.0, 1.0, (len(open_), _FRESH))
        between = np.broadcast_to(_BETWEEN, (len(open_), DEGREE))
        local = np.hstack([np.broadcast_to(_NODES, (len(open_), DEGREE + 1)), between, drawn])
        points = left[:, None] + 0.5 * width[:, None] * (local + 1.0)
        # Rounding must not carry a point out of the interval.
        values = sample(np.clip(points, low, high).ravel()).reshape(-1, *points.shape)
        coefficients = values[:, :, : DEGREE + 1] @ _TO_COEFFICIENTS.T
        checked = local[:, DEGREE + 1 :]
        basis = np.cos(np.arange(DEGREE + 1) * np.arccos(checked)[..., None])
        approximate = np.einsum("pcd,fpd->fpc", basis, coefficients)
        errors = deviation(approximate, values[:, :, DEGREE + 1 :])
        chosen = np.nan_to_num(errors[:, :, :DEGREE], nan=np.inf).max(axis=2)
        fresh = np.nan_to_num(errors[:, :, DEGREE:], nan=np.inf).max(axis=2)
        following: list[tuple[int, int]] = []
        for n, (level, place) in enumerate(open_):
            # Half the tolerance is kept for what lies between the points at which it is tested.
            if np.all(chosen[:, n] <= 0.5 * tolerance) and np.all(fresh[:, n] <= tolerance):
                done[level, place] = coefficients[:, n]
                worst[level, place] = np.maximum(chosen[:, n], fresh[:, n])
            elif level == DEEPEST or len(done) + len(following) > MOST:
                both = np.maximum(chosen[:, n], fresh[:, n])
                function = int(np.argmax(both))
                at = int(np.argmax(errors[function, n]))
                raise NotMet(function, float(points[n, DEGREE + 1 + at]), float(both[function]))
            else:
                following += [(level + 1, 2 * place), (level + 1, 2 * place + 1)]
        open_ = following
        if report is not None:
            report(len(done), len(done) + len(open_))
    ordered = sorted(done, key=lambda piece: piece[1] * 0.5 ** piece[0])
    lefts = [low + (high - low) * place * 0.5**level for level, place in ordered]
    pieces = Pieces(np.array([*lefts, high]), np.stack([done[piece] for piece in ordered], axis=1))
    return pieces, np.max([worst[piece] for piece in ordered], axis=0)
