"""The growing contact under a prescribed history, up to where it starts to shrink."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

if TYPE_CHECKING:
    from restitution.kernel.growing import Elements
    from restitution.kernel.prescribed import Contact, Scratch
    from restitution.kernel.shrinking import Past

Array = NDArray[np.float64]

_MOST_ELEMENTS = 1 << 20


def scratch(contact: Contact) -> Scratch:
    """Scratch space of a contact; one at a time may use it."""
    from restitution.kernel.memory import TERMS
    from restitution.kernel.prescribed import Scratch

    return Scratch(
        np.empty(TERMS), np.empty((2, TERMS)), np.empty(contact.moduli.size), np.empty((2, TERMS + 1))
    )


def grow_contact(contact: Contact, work: Scratch, tolerance: float, deepest: float) -> Past:
    """Growing contact and its memory; the end of contact is not yet known.

    Parameters
    ----------
    contact, work
        What is pressed into what; scratch space.
    tolerance : float
        Of depth and force over the largest.
    deepest : float
        Depth [m] at which the profile ends, for the message.

    Raises
    ------
    ValueError
        If the history has more pieces than there is room for, or a force presses the body deeper than its profile is known.
    """
    from restitution.kernel.growing import turning_point
    from restitution.kernel.memory import TERMS, allocate, quadrature, remember
    from restitution.kernel.prescribed import DEPTH, segment_rates
    from restitution.kernel.shrinking import Past

    m = contact.values.shape[0]
    by_depth = contact.control == DEPTH
    punch = contact.path.exponent == 0.0
    lengths, steps = np.diff(contact.knots), contact.values[:, 1:].sum(axis=1)
    rates, levels = np.empty((m, TERMS)), np.empty((m, TERMS))
    first, turning = m, 1.0
    if not by_depth:
        segment_rates(contact, quadrature(), 0, rates, levels)
        remember(lengths, rates, steps, contact.slope, work.sweep)
        remember(lengths, levels, np.zeros(m), contact.level, work.sweep)
        if not punch:
            first, turning = turning_point(contact, work, m)
    elif punch:
        # The contact radius never changes, so that there is nothing to look up in the past.
        first, turning = 0, 0.0
    else:
        first = _turning_segment(contact, tolerance)
        turning = float(contact.knots[first])
    elements = _no_elements() if punch else _cut(contact, work, first, turning, tolerance, deepest)
    all_lengths, all_rates, jumps = elements.lengths, elements.depth_rates, np.diff(elements.depths)
    if by_depth and first < m:
        segment_rates(contact, quadrature(), first, rates, levels)
        all_lengths = np.concatenate([all_lengths, lengths[first:]])
        all_rates = np.concatenate([all_rates, rates[: m - first]])
        jumps = np.concatenate([jumps, steps[first:]])
    depth = allocate(contact.rates, all_lengths.size)
    remember(all_lengths, all_rates, jumps, depth, work.sweep)
    integral = allocate(contact.rates, elements.lengths.size)
    remember(elements.lengths, elements.integral_rates, np.diff(elements.integrals), integral, work.sweep)
    return Past(elements, elements.lengths.size, depth, integral, first, turning, math.inf)


def _turning_segment(contact: Contact, tolerance: float) -> int:
    """Segment in which a prescribed depth starts to fall; the falls of a fitted function's rounding are none."""
    ends = contact.values.sum(axis=1)
    highest = np.maximum.accumulate(ends)
    fallen = np.flatnonzero(highest - ends > tolerance)
    if not fallen.size:
        return ends.size
    return int(np.argmax(ends[: fallen[0]])) + 1


def _cut(
    contact: Contact, work: Scratch, first: int, turning: float, tolerance: float, deepest: float
) -> Elements:
    from restitution.kernel.growing import TOO_DEEP, Elements, grow
    from restitution.kernel.memory import TERMS, quadrature

    m = contact.values.shape[0]
    segments = first + (1 if first < m and turning > contact.knots[first] else 0)
    room = 4 * m + 252
    while room <= _MOST_ELEMENTS:
        room *= 4
        elements = Elements(
            np.empty(room), np.empty(room), np.empty(room, dtype=np.int64), np.empty(room + 1),
            np.empty(room + 1), np.empty((room, TERMS)), np.empty((room, TERMS)),
        )  # fmt: skip
        count = grow(contact, quadrature(), work, segments, turning, tolerance, elements)
        if count == TOO_DEEP:
            raise ValueError(
                f"force: presses the tip deeper than {deepest:g} m, where the profile ends; must be less"
            )
        if count >= 0:
            starts, lengths, places, depths, integrals, depth_rates, integral_rates = elements
            return Elements(
                starts[:count], lengths[:count], places[:count], depths[: count + 1], integrals[: count + 1],
                depth_rates[:count], integral_rates[:count],
            )  # fmt: skip
    raise ValueError(f"history: needs more than {_MOST_ELEMENTS} elements; smooth or thin it, or loosen rtol")


def _no_elements() -> Elements:
    from restitution.kernel.growing import Elements
    from restitution.kernel.memory import TERMS

    none, rates = np.empty(0), np.empty((0, TERMS))
    return Elements(none, none, np.empty(0, dtype=np.int64), np.zeros(1), np.zeros(1), rates, rates)
