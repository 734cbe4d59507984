"""Evolution of the contact: growth (Lee and Radok), shrinkage and end (Ting), recovery of the surface."""

from __future__ import annotations

import math

import numpy as np
from numpy.polynomial.polynomial import polyval
from numpy.typing import NDArray

from restitution.errors import InputError
from restitution.indentation.history import NO_FORCE
from restitution.kernel.growing import BEYOND_PROFILE, Elements, grow, turning_point
from restitution.kernel.indentation import Recovery, recover
from restitution.kernel.memory import DEPTH, TERMS, Contact, Scratch, allocate, quadrature, remember, segment_rates
from restitution.kernel.shrinking import Past, end_of_contact, innermost_load_rises, regrowth, write_depth_memory
from restitution.material.prony import Retardation

Array = NDArray[np.float64]

# Memory of 1 GB.
_MOST_ELEMENTS = 1 << 20
# Rounding of a load over the sum of the moduli and the largest rate, and of a time over the duration.
_LOAD_ROUNDING = 1e-14
_TIME_ROUNDING = 4e-16


class Reloading(InputError):
    """The contact grows again, which the theory excludes; `value` is the time, in units of the duration or in s."""


def scratch(contact: Contact) -> Scratch:
    """Scratch space of a contact, for one call at a time."""
    modes = contact.moduli.size
    return Scratch(np.empty(TERMS), np.empty(TERMS), np.empty((2, TERMS)), np.empty(modes), np.empty((2, TERMS + 1)))


def grow_contact(contact: Contact, work: Scratch, tolerance: float, deepest: float) -> Past:
    """Growing contact and its memory, without the end of contact.

    The tolerance of depth and force is relative to the largest; the profile ends at the depth `deepest` [m].
    """
    m = contact.values.shape[0]
    by_depth, punch = contact.control == DEPTH, contact.path.exponent == 0.0
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
    elements = _allocated(0) if punch else _elements(contact, work, first, turning, tolerance, deepest)
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
    """Segment in which a prescribed depth starts to fall by more than the rounding of a fitted function."""
    ends = contact.values.sum(axis=1)
    highest = np.maximum.accumulate(ends)
    fallen = np.flatnonzero(highest - ends > tolerance)
    return int(np.argmax(ends[: fallen[0]])) + 1 if fallen.size else ends.size


def _allocated(room: int) -> Elements:
    return Elements(
        np.empty(room), np.empty(room), np.empty(room, dtype=np.int64), np.zeros(room + 1), np.zeros(room + 1),
        np.empty((room, TERMS)), np.empty((room, TERMS)),
    )  # fmt: skip


def _elements(
    contact: Contact, work: Scratch, first: int, turning: float, tolerance: float, deepest: float
) -> Elements:
    """Elements of the growing contact up to the turning point in the segment `first`."""
    m = contact.values.shape[0]
    segments = first + (1 if first < m and turning > contact.knots[first] else 0)
    room = 4 * m + 252
    while room <= _MOST_ELEMENTS:
        room *= 4
        elements = _allocated(room)
        count = grow(contact, quadrature(), work, segments, turning, tolerance, elements)
        if count == BEYOND_PROFILE:
            wanted = f"must not press the tip deeper than {deepest:g} m, where the profile ends"
            raise InputError("force", wanted=wanted)
        if count >= 0:
            return Elements(*(a[: count + 1] if a.shape == (room + 1,) else a[:count] for a in elements))
    raise InputError("history", wanted=f"needs more than {_MOST_ELEMENTS} elements; smooth or thin it, or loosen rtol")


def check_points(contact: Contact, past: Past) -> tuple[NDArray[np.int64], Array]:
    """Segments of the shrinking contact, and ascending times in them at which its state is checked."""
    m = contact.values.shape[0]
    low = np.maximum(contact.knots[past.first : m], past.turning)[:, None]
    high = contact.knots[past.first + 1 :, None]
    width = high - low
    fractions = np.linspace(0.0, 1.0, 9)
    inner = np.where((width > 0.02) | (np.arange(9) % 4 == 0), width * fractions, np.inf)
    inner[width[:, 0] == 0.0, 1:] = np.inf
    # A mode reacts to a kink within its relaxation time.
    modes = 1.0 / contact.rates
    near = np.where((modes < width) & (modes > 1e-4 * width), modes, np.inf)
    offsets = np.concatenate([inner, 0.25 * near, near], axis=1)
    times = np.sort(np.where(np.isfinite(offsets), np.minimum(low + offsets, high), np.inf), axis=1)
    places = np.broadcast_to(np.arange(past.first, m)[:, None], times.shape)
    given = np.isfinite(times)
    return places[given].astype(np.int64), times[given]


def end_of_force(contact: Contact) -> float:
    """Time at which a prescribed force has fallen to zero; infinite where it does not."""
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
    contact: Contact, past: Past, work: Scratch, tolerance: float
) -> tuple[Past, NDArray[np.int64], Array]:
    """Contact with its end, and the segments and times of the checks; one that grows before is refused."""
    places, times = check_points(contact, past)
    if contact.control == DEPTH:
        past = past._replace(end=end_of_contact(contact, past, work, places, times))
    else:
        past = past._replace(end=end_of_force(contact))
    if contact.path.exponent != 0.0 and places.size:
        rounding_allowance = _rounding(contact, past)
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
    contact: Contact, past: Past, work: Scratch, places: NDArray[np.int64], times: Array, tolerance: float,
    creep: Retardation,
) -> None:  # fmt: skip
    """Refuse a depth at which the recovering surface reaches the indenter again after the contact."""
    if not innermost_load_rises(contact, past, work, places, times, tolerance, _rounding(contact, past)):
        return
    # The rounding of the times moves a steep history.
    rounding_allowance = tolerance + 1e-15 * _largest_rate(contact, past)

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


def _rounding(contact: Contact, past: Past) -> float:
    """Rounding of the rate of the load while the contact shrinks; the times round the decay of fast modes."""
    relative = _LOAD_ROUNDING + _TIME_ROUNDING * float(np.max(contact.rates, initial=0.0))
    return relative * (contact.equilibrium + float(contact.moduli.sum())) * _largest_rate(contact, past)


def depth_rounding(past: Past) -> tuple[float, float]:
    """Largest change of the depth within the rounding of a time of the growing contact, and that time."""
    elements = past.elements
    if past.total == 0:
        return 0.0, 0.0
    rounding = _TIME_ROUNDING * (elements.starts + elements.lengths) * elements.depth_rates[:, 0]
    worst = int(np.argmax(rounding))
    return float(rounding[worst]), float(elements.starts[worst])


def _largest_rate(contact: Contact, past: Past) -> float:
    """Estimate of the largest rate of the prescribed history after the growth of the contact; at least 1."""
    widths = np.diff(contact.knots)[past.first :]
    steps = np.abs(contact.values[past.first :, 1:]).sum(axis=1)
    return float(np.max(np.divide(steps, widths, out=np.zeros_like(steps), where=widths > 0.0), initial=1.0))


def _prescribed(contact: Contact, places: NDArray[np.int64], times: Array) -> Array:
    width = contact.knots[places + 1] - contact.knots[places]
    u = np.divide(times - contact.knots[places], width, out=np.ones_like(times), where=width > 0.0)
    return polyval(u, contact.values[places].T, tensor=False)


def recovering_surface(contact: Contact, past: Past, work: Scratch, creep: Retardation, times: Array) -> Array:
    """Depth of the surface under the tip after the contact, which ended under a prescribed depth.

    With the load gone it is a sum of exponentials at the retardation times.
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


def recover_depth(contact: Contact, past: Past, work: Scratch, tolerance: float) -> Recovery:
    """Depth of the shrinking contact under a prescribed force; empty where the contact does not shrink."""
    count, room = 0, 512
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
            if room > _MOST_ELEMENTS:
                raise InputError("force", wanted="needs too many elements; smooth or thin the history, or loosen rtol")
    level = allocate(contact.recoveries, count)
    remember(lengths[:count], q[:count], np.zeros(count), level, work.sweep)
    return Recovery(starts[:count], lengths[:count], q[:count], level)
