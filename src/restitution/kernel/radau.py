"""Coefficients of Radau IIA collocation with S nodes, accurate to rounding and computed once."""

from functools import cache
from typing import Any, NamedTuple

import numpy as np
from numpy.polynomial import legendre
from numpy.typing import NDArray

from restitution.kernel.workspace import aligned

Array = NDArray[np.float64]


class Scheme(NamedTuple):
    """Coefficients of the S-stage Radau IIA method on the unit element."""

    c: Array  # (S + 1,): zero and the S nodes; the last node is 1
    A: Array  # (S, S): Butcher matrix, `A_ij = int_0^c_i l_j`
    columns: Array  # (S, S): the columns of A
    square: Array  # (S, S): the columns of its square
    identity: Array  # (S, S)
    weights: Array  # (S + 1,): weights of interpolation on `c`: `l_j(x) = weights_j prod_(i != j) (x - c_i)`
    # (2, S + 1): rows that map values at `c` to the Legendre coefficients of degree S - 1 and S of their interpolant
    tail: Array
    extrapolation: Array  # (S,): weights of interpolation on the S nodes without zero
    derivative: Array  # (S + 1, S + 1): maps values at `c` to the slopes of their interpolant there
    between: Array  # (S,): places between the nodes, about halfway
    at_between: Array  # (S + 1, S): columns of the interpolation from `c` to `between`
    at_between_inner: Array  # (S, S): the same from the nodes without zero
    # (2, S): weights at the nodes and at `between` of the rule on both of them less that of the method: on an
    # integrand, what the method misses
    missed: Array

    @property
    def order(self) -> int:
        """Declared order of the method at the end of an element, 2 S - 1."""
        return 2 * len(self.A) - 1

    @property
    def stage_order(self) -> int:
        """Declared order of the dense output, S + 1."""
        return len(self.A) + 1


def _nodes(stages: int) -> Array:
    """Roots of P_S - P_(S-1) on [0, 1] by Newton from the eigenvalues; the last one is 1 (Hairer & Wanner, IV.5)."""
    series = np.zeros(stages + 1)
    series[stages], series[stages - 1] = 1.0, -1.0
    x = np.sort(legendre.legroots(series).real)
    slope = legendre.legder(series)
    for _ in range(3):
        x -= legendre.legval(x, series) / legendre.legval(x, slope)
    x[-1] = 1.0
    return (x + 1.0) / 2.0


def _lagrange_weights(x: Array) -> Array:
    difference = x[:, None] - x[None, :]
    np.fill_diagonal(difference, 1.0)
    return 1.0 / difference.prod(axis=1)


def _interpolation(x: Array, places: Array) -> NDArray[np.floating[Any]]:
    """Columns of the matrix that maps values at x to those of their interpolant at given places."""
    degree = len(x) - 1
    basis = legendre.legvander(2.0 * x - 1.0, degree)
    return np.linalg.solve(basis.T, legendre.legvander(2.0 * places - 1.0, degree).T)


def _differentiation(x: Array, weights: Array) -> Array:
    """Barycentric differentiation matrix (Berrut & Trefethen, SIAM Review 46 (2004) 501, section 9.3)."""
    difference = x[:, None] - x[None, :]
    np.fill_diagonal(difference, 1.0)
    matrix = weights[None, :] / weights[:, None] / difference
    np.fill_diagonal(matrix, 0.0)
    np.fill_diagonal(matrix, -matrix.sum(axis=1))
    return matrix


def _aligned(array: NDArray[np.floating[Any]]) -> Array:
    """Copy that is aligned to the processor's cache lines, like the scratch space of the kernel."""
    copy = aligned(*array.shape)
    copy[...] = array
    return copy


@cache
def radau(stages: int) -> Scheme:
    """Coefficients of the Radau IIA method with S = `stages`, from 2 to 12.

    Its order is 2 S - 1 at the end of an element and S + 1 inside, and it is A-stable and stiffly accurate (E. Hairer,
    G. Wanner, Solving Ordinary Differential Equations II, 2nd ed., Springer 1996, IV.5).

    Examples
    --------
    >>> radau(2).A.round(4).tolist()
    [[0.4167, -0.0833], [0.75, 0.25]]
    """
    if not 2 <= stages <= 12:
        raise ValueError(f"stages = {stages}: must be in [2, 12]")
    nodes = _nodes(stages)
    # A in the Legendre basis, because the monomial basis is ill conditioned.
    values = legendre.legvander(2.0 * nodes - 1.0, stages - 1)
    integrals = np.empty_like(values)
    for degree in range(stages):
        antiderivative = legendre.legint(np.eye(stages)[degree], lbnd=-1.0) / 2.0
        integrals[:, degree] = legendre.legval(2.0 * nodes - 1.0, antiderivative)
    A = np.linalg.solve(values.T, integrals.T).T
    points = np.concatenate([[0.0], nodes])
    tail = np.linalg.inv(legendre.legvander(2.0 * points - 1.0, stages))[stages - 1 :]
    weights = _lagrange_weights(points)
    # Halfway in the angle, in which the nodes are almost equally spaced.
    angle = np.arccos(1.0 - 2.0 * points)
    between = 0.5 - 0.5 * np.cos(0.5 * (angle[1:] + angle[:-1]))
    both = np.concatenate([nodes, between])
    rule = np.linalg.solve(legendre.legvander(2.0 * both - 1.0, 2 * stages - 1).T, np.eye(2 * stages)[0])
    missed = (rule - np.append(A[-1], np.zeros(stages))).reshape(2, stages)
    arrays = [
        points, A, A.T, (A @ A).T, np.eye(stages), weights, tail, _lagrange_weights(nodes),
        _differentiation(points, weights), between, _interpolation(points, between), _interpolation(nodes, between),
        missed,
    ]  # fmt: skip
    return Scheme(*(_aligned(array) for array in arrays))
