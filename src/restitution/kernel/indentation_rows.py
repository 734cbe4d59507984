"""Many indentations under prescribed depths, one after another: a material, a history and a contact point each."""

from typing import Any, NamedTuple

from restitution.kernel.compile import compiled, entry_point
from restitution.kernel.growing import Past, depth_rounding, grow_contact
from restitution.kernel.indentation import Recovery, sample
from restitution.kernel.memory import Memory, Quadrature, ScaledContact, Scratch, Segments
from restitution.kernel.outcome import (
    BEYOND_PROFILE,
    GROWS_AGAIN,
    IN_CONTACT,
    NO_TOUCH,
    NOT_RESOLVED,
    OVERFLOW,
    SEPARATED,
    TOUCHES_AGAIN,
    TOUCHES_AT_START,
)
from restitution.kernel.shrinking import check_points, end_of_contact, innermost_load_rises, load_rounding, regrowth

# Share of the tolerance for the elements, as errors of the past add up.
ELEMENT_SHARE = 0.05
# Range of depths, radii and forces: their squares must be normal numbers.
SMALLEST, LARGEST = 1e-150, 1e150


class Room(NamedTuple):
    """Arrays for the longest history and the most modes of many indentations, which are computed one by one."""

    contact: ScaledContact
    segments: Segments
    past: Past
    work: Scratch
    places: Any  # Segments of the checks
    times: Any  # Times of the checks
    moments: Any  # (N,): scaled times of the samples
    columns: Any  # (5, N)


class Rows(NamedTuple):
    """Many indentations: one material, history and contact point in each row; in SI."""

    equilibria: Any  # (n,): E*(t) = equilibrium + viscosity delta(t) + sum moduli_k exp(-t/times_k)
    viscosities: Any  # (n,)
    moduli: Any  # (n, K): 0 if a row has fewer modes
    times: Any  # (n, K)
    contact_points: Any  # (n,): depth reading at touch, which is subtracted
    curves: Any  # (n,): index of the history


class Histories(NamedTuple):
    """Prescribed depths as straight lines between points, and the times of the samples; c histories one by one."""

    points: Any  # (c + 1,): index of the first point of each history, and the number of points
    knots: Any  # (P,): times, and depths there; the same time twice is a jump
    depths: Any
    samples: Any  # (c + 1,): index of the first sample of each history, and the number of samples
    times: Any  # (S,): ascending


@compiled
def _indent(
    quadrature: Quadrature, rtol: float, rows: Rows, row: int, histories: Histories, deepest: float, unit: float,
    radius: float, room: Room, recovery: Recovery, force: Any,
) -> int:  # fmt: skip
    """Write the force of one row at the samples of its history; return how the indentation ended."""
    curve, touch_depth = rows.curves[row], rows.contact_points[row]
    begin, end = histories.points[curve], histories.points[curve + 1]
    j, knots, depths = begin, histories.knots, histories.depths
    while j < end and depths[j] <= touch_depth:
        j += 1
    if j == begin:
        return TOUCHES_AT_START
    if j == end:
        return NO_TOUCH
    peak = 0.0
    for i in range(j, end):
        peak = max(peak, depths[i] - touch_depth)
    if peak > deepest:
        return BEYOND_PROFILE
    low = touch_depth - depths[j - 1]
    touch = knots[j - 1] + low / (low + depths[j] - touch_depth) * (knots[j] - knots[j - 1])
    duration = knots[end - 1] - touch
    m = end - j
    contact, path = room.contact, room.contact.path
    length = unit if path.exponent < 0.0 else peak
    contact.knots[0] = 0.0
    for i in range(m):
        contact.knots[i + 1] = (knots[j + i] - touch) / duration
        start = depths[j + i - 1] - touch_depth if i > 0 else 0.0
        contact.values[i, 0] = start / length
        contact.values[i, 1] = (depths[j + i] - touch_depth - start) / length
        if contact.knots[i + 1] == contact.knots[i] and rows.viscosities[row] > 0.0:
            return OVERFLOW
    typical = rows.equilibria[row] + rows.viscosities[row] / duration
    for k in range(rows.moduli.shape[1]):
        typical += rows.moduli[row, k] * min(1.0, rows.times[row, k] / duration)
    if path.exponent >= 0.0:
        radius *= length ** (0.5 * path.exponent)
    load = 2.0 * typical * radius * length
    # Comparisons with NaN are false.
    if not (SMALLEST < length < LARGEST and SMALLEST < radius < LARGEST and SMALLEST < load < LARGEST):
        return OVERFLOW
    K, shortest = 0, 1.0
    for k in range(rows.moduli.shape[1]):
        if rows.moduli[row, k] > 0.0:
            contact.moduli[K] = rows.moduli[row, k] / typical
            contact.rates[K] = duration / rows.times[row, k]
            if not contact.moduli[K] * contact.rates[K] < LARGEST:
                return OVERFLOW
            shortest = min(shortest, rows.times[row, k] / duration)
            K += 1
    rates = contact.rates[:K]
    contact = ScaledContact(
        contact.control, contact.knots[: m + 1], contact.values[:m], rows.equilibria[row] / typical,
        contact.moduli[:K], rates, rows.viscosities[row] / typical / duration, shortest,
        contact.glass, contact.compliances, contact.recoveries, contact.level, contact.slope, path,
    )  # fmt: skip
    work, past = room.work, room.past
    depth = Memory(rates, past.depth.begin, past.depth.polynomial, past.depth.transient)
    integral = Memory(rates, past.integral.begin, past.integral.polynomial, past.integral.transient)
    past = Past(past.elements, past.total, depth, integral, past.first, past.turning, past.end)
    total, first, turning = grow_contact(contact, quadrature, work, ELEMENT_SHARE * rtol, room.segments, past)
    if total < 0:
        return NOT_RESOLVED
    past = Past(past.elements, total, depth, integral, first, turning, past.end)
    rounding, _ = depth_rounding(past)
    if rounding > rtol:
        return NOT_RESOLVED
    count = check_points(contact, past, room.places, room.times)
    places, checks = room.places[:count], room.times[:count]
    separation = end_of_contact(contact, past, work, places, checks)
    past = Past(past.elements, total, depth, integral, first, turning, separation)
    allowed, growth = rtol + 10.0 * rounding, load_rounding(contact, past)
    if path.exponent != 0.0 and regrowth(contact, past, work, places, checks, allowed, growth) >= 0:
        return GROWS_AGAIN
    if past.end < 1.0 and innermost_load_rises(contact, past, work, places, checks, rtol, growth):
        return TOUCHES_AGAIN
    first_sample, last_sample = histories.samples[curve], histories.samples[curve + 1]
    n = first_sample
    while n < last_sample and histories.times[n] < touch:
        force[n - first_sample] = 0.0
        n += 1
    early = n
    for n in range(early, last_sample):
        room.moments[n - early] = min((histories.times[n] - touch) / duration, 1.0)
    sample(contact, past, recovery, work, room.moments[: last_sample - early], room.columns)
    for n in range(early, last_sample):
        # A force near zero may have either sign by rounding; there is no adhesion.
        force[n - first_sample] = max(room.columns[2, n - early], 0.0) * load
    return SEPARATED if past.end <= 1.0 else IN_CONTACT


@entry_point
def indent_rows(
    quadrature: Quadrature, rtol: float, rows: Rows, histories: Histories, deepest: float, unit: float, radius: float,
    room: Room, recovery: Recovery, forces: Any, statuses: Any,
) -> None:  # fmt: skip
    """Write the forces of each row at the samples of its history, and how the indentation ended.

    The profile `room.contact.path` ends at the depth `deepest`. A table is in units of the depth `unit` and of the
    contact radius `radius` at that depth. For a power law `radius` is its coefficient.
    """
    for row in range(rows.curves.shape[0]):
        statuses[row] = _indent(
            quadrature, rtol, rows, row, histories, deepest, unit, radius, room, recovery, forces[row]
        )  # fmt: skip
