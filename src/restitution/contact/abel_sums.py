"""Sums of the Abel integrals of a piecewise polynomial profile over its pieces and groups of pieces, compiled."""

import math
from typing import Any

import numba

from restitution.kernel.compile import cached


def _fast(function: Any) -> Any:
    # Sums in any order, so that they take vector instructions. A NaN is possible nowhere.
    flags: dict[str, Any] = {"_nrt": False, "nogil": True, "error_model": "numpy", "fastmath": {"contract", "reassoc"}}
    return cached(numba.njit(**flags)(function), function)


@_fast
def add_integrals(
    x: Any, y: Any, breaks: Any, slopes: Any, rule: Any, far_from: Any, nodes: Any, masses: Any, starts: Any,
    group_far_from: Any, group_nodes: Any, group_masses: Any, sums: Any,
) -> None:  # fmt: skip
    """Add ``int f' dpsi``, ``int (f' + r f'') dpsi`` and ``int f' r^2 dpsi`` with r = x cos(psi) over all pieces.

    Parameters
    ----------
    x, y
        Radii within the breaks, and ``sqrt(x^2 - b^2)`` with the first break b, shape (m,).
    breaks, slopes
        Breaks, shape (n + 1,), and coefficients of f' over r - break in each piece, lowest power first, shape (n, k).
    rule
        Nodes and weights in [0, 1] for the angle over a near piece, shape (2, n_near).
    far_from, nodes, masses
        Radius from which each piece is far, the nodes over r that then serve, and the masses there of the three
        integrands, shapes (n,), (n, n_far) and (n, 3, n_far).
    starts
        Number of the first group of each level, from pairs of the level below on, and of all groups at the end. The
        first level has four pieces in each group.
    group_far_from, group_nodes, group_masses
        The same for the groups. In each level it rises, so that the far groups are the first ones.
    sums
        Results of the shape (m, 3).
    """
    order = slopes.shape[1]
    for n in range(x.shape[0]):
        here = x[n]
        depth = inner = load = 0.0
        done = 0
        for level in range(starts.shape[0] - 2, -1, -1):
            done *= 2
            group, end = starts[level] + done, starts[level + 1]
            while group < end and here > group_far_from[group]:
                for i in range(group_nodes.shape[1]):
                    r = group_nodes[group, i]
                    inverse = 1.0 / math.sqrt((here - r) * (here + r))
                    depth += inverse * group_masses[group, 0, i]
                    inner += inverse * group_masses[group, 1, i]
                    load += inverse * group_masses[group, 2, i]
                group += 1
            done = group - starts[level]
        for piece in range(4 * done, breaks.shape[0] - 1):
            start, end_ = breaks[piece], breaks[piece + 1]
            if here <= start and piece > 0:
                break
            if here > far_from[piece]:
                for i in range(nodes.shape[1]):
                    r = nodes[piece, i]
                    inverse = 1.0 / math.sqrt((here - r) * (here + r))
                    depth += inverse * masses[piece, 0, i]
                    inner += inverse * masses[piece, 1, i]
                    load += inverse * masses[piece, 2, i]
                continue
            # Near the edge b of a face, y has digits that are lost in x - b.
            opposite = y[n] if piece == 0 else math.sqrt((here - start) * (here + start))
            upper = math.atan2(opposite, start)
            beyond = max(here, end_)
            lower = math.atan2(math.sqrt((beyond - end_) * (beyond + end_)), end_)
            width = upper - lower
            for i in range(rule.shape[1]):
                r = here * math.cos(lower + width * rule[0, i])
                offset = max(r - start, 0.0)
                first = second = 0.0
                for k in range(order - 1, -1, -1):
                    second = second * offset + first
                    first = first * offset + slopes[piece, k]
                weight = width * rule[1, i]
                depth += weight * first
                inner += weight * (first + r * second)
                load += weight * first * r * r
        sums[n, 0], sums[n, 1], sums[n, 2] = depth, inner, load


@_fast
def evaluate_series(root: Any, cell: Any, low: Any, high: Any, series: Any, values: Any) -> None:
    """Values of the Chebyshev series of cells from `low` to `high` at places `root`.

    `series` has the shape (n_cell, 3, n_term) and `values` (m, 3).
    """
    for n in range(root.shape[0]):
        own = cell[n]
        t = (2.0 * root[n] - low[own] - high[own]) / (high[own] - low[own])
        for q in range(3):
            one = two = 0.0
            for k in range(series.shape[2] - 1, 0, -1):
                one, two = series[own, q, k] + 2.0 * t * one - two, one
            values[n, q] = series[own, q, 0] + t * one - two
