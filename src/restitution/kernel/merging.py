"""Merging of panels: one polynomial in place of several that have the same displacements or loads."""

import math
from typing import Any

from restitution.kernel.compile import compiled, entry_point, inlined
from restitution.kernel.driver import FOLLOWING, FREE_PANELS, FRONT, TIME, Problem, Room
from restitution.kernel.panels import (
    FORGOTTEN,
    FROZEN,
    NODES,
    Scheme,
    Stack,
    polynomials,
    share,
    to_coefficients,
    value_of,
)

# Places between the nodes at which a merged panel is compared.
_CHECKS = 25
_ITERATIONS = 60
# Panels next to the front that are not merged, and their distance from it over the front.
_NEAR, _APART = 4, 0.002
# Tolerances over that of a step, one after the other.
_SHARES = (0.1, 0.3, 1.0, 3.0)


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


@compiled
def merge_rows(
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


@entry_point
def merge_panels(
    rule: Scheme, panels: Any, tolerance: float, merged: Any, firsts: Any, pending: Any, values: Any, parts: Any,
    room: Any,
) -> int:  # fmt: skip
    """Write few panels in place of many, and the first that each replaces; return their number."""
    return merge_rows(rule, panels, tolerance, merged, firsts, pending, values, parts, room)


@compiled
def write_now(
    rule: Scheme, panels: Stack, p: int, rates: Any, now: float, sign: float, row: Any, values: Any, basis: Any,
    slopes: Any,
) -> None:  # fmt: skip
    """Write the polynomials of a panel, over what is left of it, of y with a sign and of its parts as they are now."""
    for i in range(NODES):
        z = panels.end[p] * rule.c[i]
        polynomials(z, basis, slopes)
        elapsed = now - panels.start[p] - panels.length[p] * share(panels.kind[p], z)[0]
        values[0, i] = sign * value_of(panels.coefficients[p, 0], basis)
        for q in range(1, row.shape[0]):
            decay = math.exp(max(-rates[(q - 1) % rates.shape[0]] * elapsed, FORGOTTEN))
            values[q, i] = decay * value_of(panels.coefficients[p, q], basis)
    for q in range(row.shape[0]):
        to_coefficients(rule, values[q], row[q])


@inlined
def copy_rows(source: Any, first: int, target: Any, second: int) -> None:
    """Copy the polynomials of a panel; a slice would be copied through memory that the kernel does not have."""
    for q in range(source.shape[1]):
        for n in range(NODES):
            target[second, q, n] = source[first, q, n]


@compiled
def move_panel(panels: Stack, source: int, target: int) -> None:
    """Let a panel take the place of another one."""
    copy_rows(panels.coefficients, source, panels.coefficients, target)
    panels.start[target], panels.length[target] = panels.start[source], panels.length[source]
    panels.kind[target], panels.end[target] = panels.kind[source], panels.end[source]
    panels.joint[target] = panels.joint[source]


@compiled
def thin(problem: Problem, room: Room, follows: bool, tolerance: float) -> None:
    """Put few panels in place of many on a stack, except near the front, where load or gap have a zero.

    A merged panel holds what its elements have now, within a tolerance, and a kink that is not felt goes.
    """
    rule, solid, now, basis, slopes = problem.rule, problem.solid, room.state[TIME], room.basis[0], room.basis[1]
    panels, place, rates, spare = room.free, FREE_PANELS, solid.recoveries, room.spare_free
    if follows:
        panels, place, rates, spare = room.following, FOLLOWING, solid.rates, room.spare_following
    count, m, front, quantities = room.places[place], 0, room.state[FRONT], panels.coefficients.shape[1]
    while m < count - _NEAR:
        polynomials(panels.end[m], basis, slopes)
        if abs(value_of(panels.coefficients[m, 0], basis) - front) < _APART * front:
            break
        m += 1
    if m < 2:
        return
    # From the outermost, y falls.
    sign = -1.0 if follows else 1.0
    merged, firsts, values = spare[1], room.firsts, room.spare_values[:quantities]
    for p in range(m):
        write_now(rule, panels, p, rates, now, sign, spare[0, p], values, basis, slopes)
    size = merge_rows(
        rule, spare[0, :m], tolerance, merged, firsts, room.pending, values, room.spare_parts[: quantities - 1],
        room.basis,
    )  # fmt: skip
    for n in range(size):
        first = firsts[n]
        if (firsts[n + 1] if n + 1 < size else m) == first + 1:
            move_panel(panels, first, n)
            continue
        panels.joint[n] = panels.joint[first]
        copy_rows(merged, n, panels.coefficients, n)
        for i in range(NODES):
            panels.coefficients[n, 0, i] *= sign
        panels.start[n], panels.length[n], panels.kind[n], panels.end[n] = now, 0.0, FROZEN, 1.0
    for p in range(m, count):
        move_panel(panels, p, p - m + size)
    room.places[place] = count - m + size


@compiled
def thin_out(problem: Problem, room: Room) -> None:
    """Merge panels of both stacks; with a larger tolerance, where many remain, as steps leave errors of fronts."""
    before = room.places[FOLLOWING] + room.places[FREE_PANELS]
    for n in range(len(_SHARES)):
        for follows in (False, True):
            thin(problem, room, follows, _SHARES[n] * problem.scales.tolerance)
        if 2 * (room.places[FOLLOWING] + room.places[FREE_PANELS]) < before:
            break
