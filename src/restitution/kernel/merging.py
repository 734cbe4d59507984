"""Merging of the panels of a free surface: one polynomial in place of several that have the same displacements."""

from typing import Any

from restitution.kernel.compile import compiled, entry_point
from restitution.kernel.panels import NODES, Scheme, polynomials, to_coefficients, value_of

# Places between the nodes at which a merged panel is compared.
_CHECKS = 25
_ITERATIONS = 60


@compiled
def write_parts(panels: Any, first: int, last: int, y: float, parts: Any, basis: Any, slopes: Any) -> None:
    """Write the polynomials of the panel that holds y, which falls from panel to panel and over z in each."""
    p = first
    while p < last:
        # y at the outer end of the next panel.
        top, sign = 0.0, 1.0
        for n in range(NODES):
            top += sign * panels[p + 1, 0, n]
            sign = -sign
        if top < y:
            break
        p += 1
    low, high, z = 0.0, 1.0, 0.5
    for _ in range(_ITERATIONS):
        polynomials(z, basis, slopes)
        value, slope = value_of(panels[p, 0], basis) - y, value_of(panels[p, 0], slopes)
        if value > 0.0:
            low = z
        else:
            high = z
        target = z - value / slope if slope < 0.0 else 2.0
        if not low < target < high:
            target = 0.5 * (low + high)
        if abs(target - z) <= 1e-15:
            break
        z = target
    polynomials(z, basis, slopes)
    for j in range(parts.shape[0]):
        parts[j] = value_of(panels[p, 1 + j], basis)


@compiled
def fit(rule: Scheme, panels: Any, first: int, last: int, tolerance: float, row: Any, values: Any, parts: Any,
        basis: Any, slopes: Any) -> bool:  # fmt: skip
    """Write one panel in place of several; whether it differs by less than the tolerance."""
    top, bottom, sign = 0.0, 0.0, 1.0
    for n in range(NODES):
        top += sign * panels[first, 0, n]
        bottom += panels[last, 0, n]
        sign = -sign
    J = panels.shape[1] - 1
    for i in range(NODES):
        # The outermost elements are functions of the root of the distance from the edge.
        share = rule.c[i] * rule.c[i] if first == 0 else rule.c[i]
        values[0, i] = top - (top - bottom) * share
        write_parts(panels, first, last, values[0, i], parts, basis, slopes)
        for j in range(J):
            values[1 + j, i] = parts[j]
    for q in range(J + 1):
        to_coefficients(rule, values[q], row[q])
        if q > 0 and abs(row[q, NODES - 1]) + abs(row[q, NODES - 2]) > tolerance:
            return False
    for n in range(_CHECKS):
        z = (n + 0.5) / _CHECKS
        share = z * z if first == 0 else z
        write_parts(panels, first, last, top - (top - bottom) * share, parts, basis, slopes)
        polynomials(z, basis, slopes)
        for j in range(J):
            if not abs(value_of(row[1 + j], basis) - parts[j]) <= tolerance:
                return False
    return True


@entry_point
def merge_panels(
    rule: Scheme, panels: Any, tolerance: float, merged: Any, firsts: Any, pending: Any, values: Any, parts: Any,
    room: Any,
) -> int:  # fmt: skip
    """Write few panels in place of many, and the first that each replaces; return their number.

    Those from the outermost on are tried at once, then halves. `pending` holds two integers for each level of halves.
    """
    count, level = 0, 1
    pending[0, 0], pending[0, 1] = 0, panels.shape[0] - 1
    while level > 0:
        level -= 1
        first, last = pending[level, 0], pending[level, 1]
        if first == last:
            for q in range(panels.shape[1]):
                for n in range(NODES):
                    merged[count, q, n] = panels[first, q, n]
        elif not fit(rule, panels, first, last, tolerance, merged[count], values, parts, room[0], room[1]):
            middle = (first + last) // 2
            pending[level, 0], pending[level, 1] = middle + 1, last
            pending[level + 1, 0], pending[level + 1, 1] = first, middle
            level += 2
            continue
        firsts[count] = first
        count += 1
    return count
