"""Evolution of the contact: growth (Lee and Radok), shrinkage and end (Ting), recovery of the surface."""

from __future__ import annotations

import math
from contextvars import ContextVar

import numpy as np
from numpy.polynomial.polynomial import polyval
from numpy.typing import NDArray

from restitution.contact.geometry import Geometry
from restitution.errors import InputError
from restitution.indentation.history import NO_FORCE
from restitution.kernel.growing import BEYOND_PROFILE, TOO_STEEP, Elements, Past, depth_rounding, grow_contact
from restitution.kernel.indentation import Recovery, recover
from restitution.kernel.memory import DEPTH, TERMS, ScaledContact, Scratch, Segments, allocate, quadrature, remember
from restitution.kernel.shrinking import (
    check_points,
    end_of_contact,
    innermost_load_rises,
    largest_rate,
    load_rounding,
    regrowth,
    write_depth_memory,
)
from restitution.material.prony import Retardation

Array = NDArray[np.float64]

# Memory of 1 GB; a caller may allow less.
MOST_ELEMENTS = ContextVar("most_elements", default=1 << 20)


class Reloading(InputError):
    """The contact grows again, which the theory excludes; `value` is the time, in units of the duration or in s."""


def scratch(modes: int) -> Scratch:
    """Scratch space of a contact with this number of modes, for one call at a time."""
    return Scratch(np.empty(TERMS), np.empty(TERMS), np.empty((2, TERMS)), np.empty(modes), np.empty((2, TERMS + 1)))


def room_for(rates: Array, segments: int, elements: int) -> tuple[Segments, Past]:
    """Arrays for a history of `segments` and a growing contact of `elements`, with modes of these rates."""
    grown = Elements(
        np.empty(elements), np.empty(elements), np.empty(elements, dtype=np.int64), np.zeros(elements + 1),
        np.zeros(elements + 1), np.empty((elements, TERMS)), np.empty((elements, TERMS)),
    )  # fmt: skip
    depth, integral = allocate(rates, elements + segments), allocate(rates, elements)
    pieces = Segments(np.empty(segments), np.empty((segments, TERMS)), np.empty((segments, TERMS)))
    return pieces, Past(grown, 0, depth, integral, segments, 1.0, math.inf)


def grown_contact(contact: ScaledContact, work: Scratch, tolerance: float, profile: Geometry) -> Past:
    """Growing contact and its memory, without the end of contact.

    The tolerance of depth and force is relative to the largest; the depth is at most that of the profile.
    """
    m = contact.values.shape[0]
    room = 0
    while room < MOST_ELEMENTS.get():
        room = min(max(4 * room, 16 * m + 1008), MOST_ELEMENTS.get())
        segments, past = room_for(contact.rates, m, room)
        total, first, turning = grow_contact(contact, quadrature(), work, tolerance, segments, past)
        if total == BEYOND_PROFILE:
            deepest = float(np.min(profile.max_depth))
            wanted = f"must not press the tip deeper than {deepest:g} m, {profile.end}"
            raise InputError("force", wanted=wanted)
        if total == TOO_STEEP:
            raise InputError("history", wanted="rises too steeply for the digits of its times; smooth it")
        if total >= 0:
            elements = Elements(*(a[: total + 1] if a.shape == (room + 1,) else a[:total] for a in past.elements))
            return past._replace(elements=elements, total=total, first=first, turning=turning)
    raise InputError("history", wanted=f"needs over {MOST_ELEMENTS.get()} elements; smooth or thin it, or loosen rtol")


def points_of_checks(contact: ScaledContact, past: Past) -> tuple[NDArray[np.int64], Array]:
    """Segments of the shrinking contact, and ascending times in them at which its state is checked."""
    room = (9 + 2 * contact.rates.size) * max(contact.values.shape[0] - past.first, 0)
    places, times = np.empty(room, dtype=np.int64), np.empty(room)
    count = check_points(contact, past, places, times)
    return places[:count], times[:count]


def end_of_force(contact: ScaledContact) -> float:
    """Time at which a prescribed force has fallen to zero; infinite if it does not."""
    ends = contact.values.sum(axis=1)
    falls = np.cumsum(ends < contact.values[:, 0]) > 0
    zero = np.flatnonzero(falls & (ends <= NO_FORCE * ends.max()))
    if not zero.size:
        return math.inf
    n = int(zero[0])
    later = np.flatnonzero(ends[n + 1 :] > NO_FORCE * ends.max())
    if later.size:
        wanted = "the contact is over and is loaded again, which is outside the theory"
        raise Reloading("time", float(contact.knots[n + 1 + later[0]]), wanted)
    return float(contact.knots[n + 1])


def shrink_contact(
    contact: ScaledContact, past: Past, work: Scratch, tolerance: float
) -> tuple[Past, NDArray[np.int64], Array]:
    """Contact with its end, and the segments and times of the checks; refuse a contact that grows again before."""
    places, times = points_of_checks(contact, past)
    if contact.control == DEPTH:
        past = past._replace(end=end_of_contact(contact, past, work, places, times))
    else:
        past = past._replace(end=end_of_force(contact))
    if contact.path.exponent != 0.0 and places.size:
        rounding_allowance = load_rounding(contact, past)
        tolerance += 10.0 * depth_rounding(past)[0]
        n = regrowth(contact, past, work, places, times, tolerance, rounding_allowance)
        if n >= 0:
            low, high = float(times[max(n - 1, 0)]), float(times[n])
            for _ in range(3):
                finer = np.linspace(low, high, 33)
                same = np.full(33, places[n])
                found = regrowth(contact, past, work, same, finer, 0.1 * tolerance, rounding_allowance)
                if found < 0:
                    break
                low, high = float(finer[max(found - 1, 0)]), float(finer[found])
            wanted = (
                "the contact grows again before it has ended; the theory holds for one loading and one unloading. "
            )
            raise Reloading("time", high, wanted + "Fit a smooth curve to measured data first")
    return past, places, times


def check_recontact(
    contact: ScaledContact, past: Past, work: Scratch, places: NDArray[np.int64], times: Array, tolerance: float,
    creep: Retardation,
) -> None:  # fmt: skip
    """Refuse a depth at which the recovering surface reaches the indenter again after the contact."""
    if not innermost_load_rises(contact, past, work, places, times, tolerance, load_rounding(contact, past)):
        return
    # The rounding of the times moves a steep history.
    rounding_allowance = tolerance + 1e-15 * largest_rate(contact, past)

    def caught(segments: NDArray[np.int64], moments: Array) -> NDArray[np.intp]:
        surface = recovering_surface(contact, past, work, creep, moments)
        return np.flatnonzero(_prescribed(contact, segments, moments) > surface + rounding_allowance)

    share = np.linspace(0.0, 1.0, 65)
    for i in range(past.first, contact.values.shape[0]):
        low, high = max(float(contact.knots[i]), past.end), float(contact.knots[i + 1])
        if high <= low:
            continue
        moments = low + (high - low) * share
        found = caught(np.full(share.size, i), moments)
        if not found.size:
            continue
        for _ in range(3):
            n = int(found[0])
            if n == 0:
                break
            moments = moments[n - 1] + (moments[n] - moments[n - 1]) * share
            found = caught(np.full(share.size, i), moments)
        wanted = (
            "the contact is over and the recovering surface reaches the indenter again, which is outside the theory"
        )
        raise Reloading("time", float(moments[found[0]]), wanted)


def _prescribed(contact: ScaledContact, places: NDArray[np.int64], times: Array) -> Array:
    width = contact.knots[places + 1] - contact.knots[places]
    u = np.divide(times - contact.knots[places], width, out=np.ones_like(times), where=width > 0.0)
    return polyval(u, contact.values[places].T, tensor=False)


def recovering_surface(contact: ScaledContact, past: Past, work: Scratch, creep: Retardation, times: Array) -> Array:
    """Depth of the surface under the tip after the contact, which ended under a prescribed depth.

    Without load it is a sum of exponentials at the retardation times.
    """
    n = int(np.searchsorted(contact.knots, past.end, side="left"))
    jumps = n + 1 < contact.knots.size and contact.knots[n] == contact.knots[n + 1] == past.end
    i = n if jumps else max(n - 1, past.first)
    depth = float(contact.values[i, 0] if jumps else _prescribed(contact, np.array([i]), np.array([past.end]))[0])
    write_depth_memory(contact, past, work, i, past.end)
    loads = np.append(contact.moduli * work.now, contact.equilibrium * depth)
    rates = np.append(contact.rates, 0.0)
    surface = np.full(times.size, depth if contact.equilibrium == 0.0 else 0.0)
    elapsed = times - past.end
    for compliance, time in zip(creep.branch_compliances, creep.retardation_times, strict=True):
        amplitude = compliance * float(np.sum(loads / (1.0 - rates * time)))
        surface += amplitude * np.exp(-elapsed / time)
    if creep.fluidity > 0.0:
        surface -= creep.fluidity * float(np.sum(loads[:-1] / contact.rates))
    return surface


def recover_depth(contact: ScaledContact, past: Past, work: Scratch, tolerance: float) -> Recovery:
    """Depth of the shrinking contact under a prescribed force; empty if the contact does not shrink."""
    count, room = 0, min(512, MOST_ELEMENTS.get())
    starts, lengths, q = np.empty(0), np.empty(0), np.empty((0, TERMS))
    if contact.control != DEPTH and past.turning < 1.0 and contact.path.exponent != 0.0:
        compliance = contact.glass + float(
            np.sum(np.where(contact.recoveries > 0.0, 1.0, 0.0) * contact.compliances
                   * -np.expm1(-contact.recoveries) / np.maximum(contact.recoveries, 1e-300))
            + np.sum(contact.compliances[contact.recoveries == 0.0])
        )  # fmt: skip
        allowed = tolerance * float(past.elements.depths[past.total]) / compliance
        allowed += (contact.equilibrium + float(contact.moduli.sum())) * depth_rounding(past)[0]
        while True:
            starts, lengths, q = np.empty(room), np.empty(room), np.empty((room, TERMS))
            count = recover(contact, past, quadrature(), work, allowed, starts, lengths, q)
            if count >= 0:
                break
            room *= 4
            if room > MOST_ELEMENTS.get():
                raise InputError("force", wanted="needs too many elements; smooth or thin the history, or loosen rtol")
    level = allocate(contact.recoveries, count)
    remember(lengths[:count], q[:count], level, work.sweep)
    return Recovery(starts[:count], lengths[:count], q[:count], level)
