"""Moments of masses on [0, a]: sums of the masses times Chebyshev polynomials of 2 (x/a)^2 - 1, compiled."""

from typing import Any

from restitution.kernel.compile import entry_point, inlined


@inlined
def _moments(a: float, b: float, nodes: Any, before: Any, x: Any, masses: Any, space: Any, moments: Any) -> None:
    """Write the moments of the masses `before` at the nodes of [0, b] and of further masses at x."""
    twice, even, odd, mass = space[0], space[1], space[2], space[3]
    few = nodes.shape[0]
    count = few + x.shape[0]
    for i in range(count):
        share = nodes[i] * b / a if i < few else min(x[i - few] / a, 1.0)
        place = 2.0 * share * share - 1.0
        twice[i], even[i], odd[i] = 2.0 * place, place, 1.0
        mass[i] = before[i] if i < few else masses[i - few]
    for k in range(moments.shape[0]):
        total = 0.0
        for i in range(count):
            total += mass[i] * odd[i]
            now = twice[i] * odd[i] - even[i]
            even[i] = odd[i]
            odd[i] = now
        moments[k] = total


@entry_point
def condense(starts: Any, nodes: Any, x: Any, masses: Any, weights: Any, space: Any, found: Any) -> None:
    """Write masses at the nodes of [0, b] with the same moments as those of the cells before each start b.

    Parameters
    ----------
    starts
        Starts b of the cells, shape (n,).
    nodes, weights
        Nodes over b, shape (n_term,), and the matrix from moments to masses there, shape (n_term, n_term).
    x, masses
        Places and masses of each cell, shape (n, n_place).
    space
        Space of the shape (4, n_term + n_place).
    found
        Masses, shape (n, n_term), which are 0 at first.
    """
    terms = nodes.shape[0]
    for n in range(1, starts.shape[0]):
        before, after = found[n - 1], found[n]
        _moments(starts[n], starts[n - 1], nodes, before, x[n - 1], masses[n - 1], space, after)
        for i in range(terms):
            space[0, i] = 0.0
            for k in range(terms):
                space[0, i] += after[k] * weights[k, i]
        for i in range(terms):
            after[i] = space[0, i]


@entry_point
def add_moments(
    radius: Any, own: Any, starts: Any, nodes: Any, before: Any, x: Any, masses: Any, space: Any, moments: Any
) -> None:
    """Write the moments at each radius > 0 of the masses before its cell, number `own`, and of further ones at x."""
    for n in range(radius.shape[0]):
        cell = own[n]
        _moments(radius[n], starts[cell], nodes, before[cell], x[n], masses[n], space, moments[n])
