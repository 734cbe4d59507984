"""Compiled loops of profiles and layers, apart from their callers because numba takes half a second to import."""

import math
from typing import Any

import numba

from restitution.kernel.compile import cached, entry_point, inlined

# Polynomials of a(s) in the cells of a path table, compiled.


@entry_point
def fit_cells(depth: Any, radius: Any, deepest: Any, origin: Any, rule: Any, place: Any, results: Any) -> None:
    """Fit a polynomial to each cell of several tables and compare it with the values between its nodes.

    `depth` and `radius` hold n nodes of each cell and then n Gauss nodes, shape (n_table, n_cell, 2 n), and `rule` the
    slopes from values at the nodes, and weights, at the Gauss nodes of a cell of width 1; `place` is space for 2 n
    numbers. Results: ends (s and rho at the start, and the width in rho), coefficients over the share of the width,
    lowest power first, and sums (``int a dd``, ``int |delta a| dd`` and the largest error of a).
    """
    slopes, weights = rule
    ends, coefficients, sums = results
    n = weights.shape[0]
    for table in range(depth.shape[0]):
        for cell in range(depth.shape[1]):
            start = origin[table, cell]
            for i in range(2 * n):
                s = math.sqrt(depth[table, cell, i] / deepest[table])
                if i == 0:
                    ends[table, cell, 0] = s
                place[i] = s if start < 0.0 else math.sqrt(max(s - start, 0.0))
            low = place[0]
            width = place[n - 1] - low
            ends[table, cell, 1], ends[table, cell, 2] = low, width
            for i in range(2 * n):
                place[i] = (place[i] - low) / width
            # Divided differences, then powers (Bjorck and Pereyra 1970).
            for i in range(n):
                coefficients[table, cell, i] = radius[table, cell, i]
            for k in range(n - 1):
                for i in range(n - 1, k, -1):
                    rise = coefficients[table, cell, i] - coefficients[table, cell, i - 1]
                    coefficients[table, cell, i] = rise / (place[i] - place[i - k - 1])
            for k in range(n - 2, -1, -1):
                for i in range(k, n - 1):
                    coefficients[table, cell, i] -= place[k] * coefficients[table, cell, i + 1]
            gain = missed = largest = 0.0
            for j in range(n):
                value = 0.0
                pace = 0.0
                for i in range(n - 1, -1, -1):
                    value = value * place[n + j] + coefficients[table, cell, i]
                    pace += slopes[j, i] * depth[table, cell, i]
                error = abs(value - radius[table, cell, n + j])
                gain += weights[j] * pace * radius[table, cell, n + j]
                missed += weights[j] * pace * error
                largest = max(largest, error)
            sums[table, cell, 0], sums[table, cell, 1], sums[table, cell, 2] = gain, missed, largest


# Sums of the Abel integrals of a piecewise polynomial profile over its pieces and groups of pieces, compiled.


def _fast(function: Any) -> Any:
    # Sums in any order, so that they take vector instructions. A NaN is possible nowhere.
    flags: dict[str, Any] = {"_nrt": False, "nogil": True, "error_model": "numpy", "fastmath": {"contract", "reassoc"}}
    return cached(numba.njit(**flags)(function), function)


@_fast
def add_integrals(x: Any, y: Any, breaks: Any, slopes: Any, rule: Any, pieces: Any, groups: Any, sums: Any) -> None:
    """Add ``int f' dpsi``, ``int (f' + r f'') dpsi`` and ``int f' r^2 dpsi`` with r = x cos(psi) over all pieces.

    `x` are radii within the breaks, `y` are ``sqrt(x^2 - b^2)`` with the first break b, and `slopes` the coefficients
    of f' over r - break in each piece. From the first numbers of `pieces` on, their nodes with masses of the three
    integrands serve in place of the near `rule` over the angle. The `groups` begin with the number of the first one of
    each level: the first level has four pieces in a group, each next one two groups. In a level the radii from which
    they are far rise, so that the far groups are the first ones. The `sums` have the shape (m, 3).
    """
    far_from, nodes, masses = pieces
    starts, group_far_from, group_nodes, group_masses = groups
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
    """Return values of the Chebyshev series of cells from `low` to `high` at places `root`.

    `series` has the shape (n_cell, 3, n_term) and `values` (m, 3).
    """
    for n in range(root.shape[0]):
        cell_of = cell[n]
        t = (2.0 * root[n] - low[cell_of] - high[cell_of]) / (high[cell_of] - low[cell_of])
        for q in range(3):
            first = second = 0.0
            for k in range(series.shape[2] - 1, 0, -1):
                first, second = series[cell_of, q, k] + 2.0 * t * first - second, first
            values[n, q] = series[cell_of, q, 0] + t * first - second


# Line loads of flat punches on a layer: the symmetric linear system of the integral equation, compiled.
#
# The library routines of NumPy start threads for systems of this size, which costs up to a hundred times more than the
# solution where other processes use the cores.


@inlined
def _kernel(cells: Any, per_unit: float, t: float) -> float:
    """Return the kernel m(t) from its polynomials over cells of equal width, highest power first."""
    place = t * per_unit
    cell = int(place)
    place = 2.0 * (place - cell) - 1.0
    value = cells[0, cell]
    for k in range(1, cells.shape[0]):
        value = value * place + cells[k, cell]
    return value


@entry_point
def solve_line_loads(
    cells: Any, per_unit: float, radii: Any, nodes: Any, weights: Any, space: Any, loads: Any, ends: Any
) -> None:
    """Write the resolvent r and the load w at the nodes a x_j of each radius a, and ``int w dx`` and w(a).

    `cells` are polynomials of m(t), highest power first, `per_unit` of them for a unit of t, and x_j and weights are
    Gauss nodes on [0, 1]; `space` is that for n^2 and for n numbers. Results: `loads`, shape (n_radius, 2, n), and
    `ends`, shape (n_radius, 2).
    """
    matrix, roots = space
    n = nodes.shape[0]
    for k in range(radii.shape[0]):
        a = radii[k]
        for i in range(n):
            roots[i] = math.sqrt(a * weights[i])
        for i in range(n):
            for j in range(i, n):
                m = _kernel(cells, per_unit, a * abs(nodes[i] - nodes[j]))
                m += _kernel(cells, per_unit, a * (nodes[i] + nodes[j]))
                matrix[i, j] = -roots[i] * roots[j] * m
            matrix[i, i] += 1.0
            m = _kernel(cells, per_unit, a * (1.0 - nodes[i])) + _kernel(cells, per_unit, a * (1.0 + nodes[i]))
            loads[k, 0, i], loads[k, 1, i] = roots[i] * m, roots[i]
        # Cholesky's factors row by row, along which the memory lies, with the substitution of both right-hand sides.
        for i in range(n):
            scale = 1.0 / math.sqrt(matrix[i, i])
            for j in range(i, n):
                matrix[i, j] *= scale
            for side in range(2):
                loads[k, side, i] *= scale
            for row in range(i + 1, n):
                factor = matrix[i, row]
                for j in range(row, n):
                    matrix[row, j] -= factor * matrix[i, j]
                for side in range(2):
                    loads[k, side, row] -= factor * loads[k, side, i]
        for side in range(2):
            for i in range(n - 1, -1, -1):
                total = loads[k, side, i]
                for j in range(i + 1, n):
                    total -= matrix[i, j] * loads[k, side, j]
                loads[k, side, i] = total / matrix[i, i]
        ends[k, 0], ends[k, 1] = 0.0, 1.0
        for i in range(n):
            m = _kernel(cells, per_unit, a * (1.0 - nodes[i])) + _kernel(cells, per_unit, a * (1.0 + nodes[i]))
            ends[k, 0] += roots[i] * loads[k, 1, i]
            ends[k, 1] += roots[i] * m * loads[k, 1, i]
            for side in range(2):
                loads[k, side, i] /= roots[i]


# Moments of masses on [0, a]: sums of the masses times Chebyshev polynomials of 2 (x/a)^2 - 1, compiled.


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
def condense(starts: Any, nodes: Any, x: Any, masses: Any, weights: Any, space: Any, moments: Any) -> None:
    """Write masses at the nodes of [0, b] with the same moments as those of the cells before each start b.

    `x` and `masses` are those of each cell, shape (n, n_place), `weights` the matrix from moments to masses, and
    `space` has the shape (4, n_term + n_place). The results, shape (n, n_term), are 0 at first.
    """
    terms = nodes.shape[0]
    for n in range(1, starts.shape[0]):
        before, after = moments[n - 1], moments[n]
        _moments(starts[n], starts[n - 1], nodes, before, x[n - 1], masses[n - 1], space, after)
        for i in range(terms):
            space[0, i] = 0.0
            for k in range(terms):
                space[0, i] += after[k] * weights[k, i]
        for i in range(terms):
            after[i] = space[0, i]


@entry_point
def add_moments(radius: Any, cells: Any, condensed: Any, x: Any, masses: Any, space: Any, moments: Any) -> None:
    """Write the moments at each radius > 0 of the masses before its cell, and of further ones at x.

    `condensed` are the starts of all cells, and the nodes and masses that stand for what is before.
    """
    starts, nodes, before = condensed
    for n in range(radius.shape[0]):
        cell = cells[n]
        _moments(radius[n], starts[cell], nodes, before[cell], x[n], masses[n], space, moments[n])


# Series over the panels of a/h, compiled: contacts of one profile on layers of many thicknesses.

MOST = 128
"""Contacts that are evaluated together."""


@inlined
def _panel(panels: Any, radius: float) -> int:
    """Return the panel that contains a radius over the thickness; beyond its end, the last panel."""
    last = panels.shape[0] - 2
    panel = 0
    while panel < last and radius >= panels[panel + 1]:
        panel += 1
    return panel


@entry_point
def on_layers(
    thickness: Any, radius: Any, panels: Any, stiffness: Any, edge: Any, series: Any, scratch: Any, means: Any
) -> None:
    """Write ln kappa, ln w(a) and a mean over the profile for every contact on every layer, shape (3, n_layer, n).

    `stiffness` and `edge` are series over each of the panels of a/h, of an even number of terms, and `series` those of
    the mean of each contact, shape (n_panel, n_term, n); `scratch` has the shape (6, `MOST`).
    """
    n, terms = radius.shape[0], stiffness.shape[1]
    twice, even, odd, kappa, edges, mean = scratch[0], scratch[1], scratch[2], scratch[3], scratch[4], scratch[5]
    for layer in range(thickness.shape[0]):
        per_unit = 1.0 / thickness[layer]
        first = 0
        while first < n:
            # Neighbours in one panel.
            panel = _panel(panels, radius[first] * per_unit)
            low, high = panels[panel], panels[panel + 1]
            count = 1
            while count < MOST and first + count < n and _panel(panels, radius[first + count] * per_unit) == panel:
                count += 1
            for i in range(count):
                place = (2.0 * radius[first + i] * per_unit - low - high) / (high - low)
                twice[i] = 2.0 * place
                even[i], odd[i] = 1.0, place
                kappa[i] = stiffness[panel, 0] + stiffness[panel, 1] * place
                edges[i] = edge[panel, 0] + edge[panel, 1] * place
                mean[i] = series[panel, 0, first + i] + series[panel, 1, first + i] * place
            # Two terms at a time, since reading and writing cost more than the products.
            for k in range(2, terms, 2):
                for i in range(count):
                    now = twice[i] * odd[i] - even[i]
                    after = twice[i] * now - odd[i]
                    even[i] = now
                    odd[i] = after
                    kappa[i] += stiffness[panel, k] * now + stiffness[panel, k + 1] * after
                    edges[i] += edge[panel, k] * now + edge[panel, k + 1] * after
                    mean[i] += series[panel, k, first + i] * now + series[panel, k + 1, first + i] * after
            for i in range(count):
                means[0, layer, first + i] = kappa[i]
                means[1, layer, first + i] = edges[i]
                means[2, layer, first + i] = mean[i]
            first += count
