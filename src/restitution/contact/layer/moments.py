"""Sums of masses times Chebyshev polynomials, compiled."""

from typing import Any

from restitution.kernel.compile import entry_point, inlined


@inlined
def _add(count: int, space: Any, sums: Any) -> None:
    """Sums over `count` masses, the last row of `space`, of polynomials of 2 x^2 - 1; x is the row before it."""
    twice, even, odd, x, masses = space[0], space[1], space[2], space[3], space[4]
    for i in range(count):
        place = 2.0 * x[i] * x[i] - 1.0
        twice[i], even[i], odd[i] = 2.0 * place, place, 1.0
    for k in range(sums.shape[0]):
        total = 0.0
        for i in range(count):
            total += masses[i] * odd[i]
            now = twice[i] * odd[i] - even[i]
            even[i] = odd[i]
            odd[i] = now
        sums[k] = total


@entry_point
def condense(starts: Any, inner: Any, x: Any, masses: Any, weights: Any, space: Any, found: Any) -> None:
    """Write masses at the nodes of [0, b] that have the same moments as those of the cells before each start b.

    Parameters
    ----------
    starts
        Starts b of the cells, shape (n,).
    inner, weights
        Nodes over b, and the matrix from moments to masses at the nodes, (n_term, n_term).
    x, masses
        Nodes and masses of each cell, shape (n, n_node).
    space
        Space of the shape (5, n_term + n_node).
    found
        Masses, shape (n, n_term); those of the first start are 0.
    """
    terms, more = inner.shape[0], x.shape[1]
    for n in range(x.shape[0] - 1):
        end = starts[n + 1]
        for i in range(terms):
            space[3, i] = inner[i] * starts[n] / end
            space[4, i] = found[n, i]
        for i in range(more):
            space[3, terms + i] = x[n, i] / end
            space[4, terms + i] = masses[n, i]
        sums = found[n + 1]
        _add(terms + more, space, sums)
        for i in range(terms):
            space[4, i] = 0.0
            for k in range(terms):
                space[4, i] += sums[k] * weights[k, i]
        for i in range(terms):
            sums[i] = space[4, i]


@entry_point
def add_moments(
    radius: Any, own: Any, starts: Any, inner: Any, before: Any, x: Any, masses: Any, space: Any, moments: Any
) -> None:
    """Write the moments of the masses before the cell `own` of each radius, and of further ones at x."""
    terms, more = inner.shape[0], x.shape[1]
    for n in range(radius.shape[0]):
        a = radius[n] if radius[n] > 0.0 else 1.0
        for i in range(terms):
            space[3, i] = inner[i] * starts[own[n]] / a
            space[4, i] = before[own[n], i]
        for i in range(more):
            space[3, terms + i] = min(x[n, i] / a, 1.0)
            space[4, terms + i] = masses[n, i]
        _add(terms + more, space, moments[n])
