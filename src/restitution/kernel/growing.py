"""Growing contact under a prescribed depth or force, in elements on which its rates are polynomials.

While the contact grows, d = g(a) and (Lee and Radok)

    F(t) = int E(t - t') dPi(t'),    Pi(t) = int J(t - t') dF(t').

The elements become shorter towards first touch, where the rates are not smooth, and towards every sudden change of
the force.
"""

import math
from typing import Any, NamedTuple

from restitution.kernel.compile import compiled, entry_point, inlined
from restitution.kernel.memory import (
    DEPTH,
    FORCE,
    SHORTEST_ELEMENT,
    TERMS,
    TIME_ROUNDING,
    Memory,
    Quadrature,
    ScaledContact,
    Scratch,
    Segments,
    drop_rounding,
    expand,
    expand_segments,
    legendre_values,
    prescribed,
    recall,
    remember,
    truncation_error,
    variation,
)
from restitution.kernel.path import Path, radius_and_integral
from restitution.kernel.references import by_reference

NO_ROOM, BEYOND_PROFILE, TOO_STEEP = -1, -2, -3
# Length of the shortest element over the duration: at first touch, where the rates are powers of time.
FIRST_ELEMENT = 1e-60
# Rounding of the rate of Pi over Pi/t and the rate of the force; a smaller fall is not a turning point.
RATE_ROUNDING = 1e-13
# Largest number of coarse elements in a segment: with more of them, the rounding of the times hides the contact.
_MOST_COARSE = 1000
# An element that would cover this share of the rest of its segment covers all of it.
_MOST_OF_REST = 0.75
# Search for a turning point in a segment: number of even steps, and of all places.
_EVEN_STEPS = 16.0
_PLACES = 64
# First place after the start of a segment, over its length, and the ratio of the next places.
_FIRST_PLACE = 1e-12
_RATIO = 2.5
_BISECTIONS = 80
# Newton's method: largest number of steps; a step of this size over the unknown is rounding.
NEWTON_ROUNDS = 200
NEWTON_ROUNDING = 4e-16
# Rounding of a time over the duration.
CLOCK_ROUNDING = 4e-16


@by_reference
class Elements(NamedTuple):
    """Elements of the growing contact."""

    starts: Any  # (E,): length 0: depth and Pi jump, by the first coefficients of their rates
    lengths: Any  # (E,)
    segments: Any  # (E,): the segment of the history that an element lies in
    depths: Any  # (E + 1,): d and Pi at the start of each element, and at the end of the last
    integrals: Any  # (E + 1,)
    depth_rates: Any  # (E, TERMS): legendre coefficients of d' and Pi'
    integral_rates: Any  # (E, TERMS)


@by_reference
class Past(NamedTuple):
    """The growing contact and its memory."""

    elements: Elements
    total: int  # Number of elements
    depth: Memory  # H_k over the elements and, under a prescribed depth, over the rest of the history
    integral: Memory  # Y_k over the elements
    first: int  # Segment of the history in which the contact starts to shrink
    turning: float  # Time of that; the end of the history if the contact only grows
    end: float  # Time at which the contact ends; infinite if it does not


@compiled
def root_of_depth(path: Path, integral: float) -> float:
    """Return the root s of the depth at which Pi has this value."""
    if integral <= 0.0:
        return 0.0
    p = path.exponent
    if p == 1.0:
        return (1.5 * integral) ** (1.0 / 3.0)
    # Pi = int a 2 s ds = 2 s^(p + 2)/(p + 2).
    if p >= 0.0:
        return (0.5 * (p + 2.0) * integral) ** (1.0 / (p + 2.0))
    low, high = 0.0, path.end
    s = high
    for _ in range(NEWTON_ROUNDS):
        a, value = radius_and_integral(path, s)
        if value > integral:
            high = s
        else:
            low = s
        # Newton in the logarithms: Pi is nearly a power of s.
        step = math.exp((integral - value) / integral) if value <= 0.0 else integral / value
        power = 2.0 * s * s * a / value if value > 0.0 else 2.0
        trial = s * step ** (1.0 / power) if power > 0.0 else 0.0
        # A table may have parts in which Pi is far from a power; there bisection goes on.
        if not low <= trial <= high:
            trial = 0.5 * (low + high)
        if abs(trial - s) <= NEWTON_ROUNDING * s:
            return trial
        s = trial
    return s


@inlined
def growing_contact(contact: ScaledContact, work: Scratch, i: int, t: float) -> tuple[float, float, float, float]:
    """Return the depth, its rate, Pi and its rate of the growing contact, in segment i at time t."""
    if contact.control == DEPTH:
        value, rate, _ = prescribed(contact, i, t)
        a, integral = radius_and_integral(contact.path, math.sqrt(max(value, 0.0)))
        return value, rate, integral, a * rate
    return _growing_contact_by_force(contact, work, i, t)


@compiled
def _growing_contact_by_force(
    contact: ScaledContact, work: Scratch, i: int, t: float
) -> tuple[float, float, float, float]:
    """Return the creep under the prescribed force."""
    value, rate, _ = prescribed(contact, i, t)
    h = contact.knots[i + 1] - contact.knots[i]
    elapsed = t - contact.knots[i]
    legendre_values(2.0 * elapsed / h - 1.0, work.basis)
    integral = contact.glass * value
    integral_rate = contact.glass * rate
    for j in range(contact.compliances.shape[0]):
        integral += contact.compliances[j] * recall(contact.level, i, j, elapsed, work.basis)
        integral_rate += contact.compliances[j] * recall(contact.slope, i, j, elapsed, work.basis)
    s = root_of_depth(contact.path, integral)
    a = radius_and_integral(contact.path, s)[0]
    # dPi = a dd.
    if a > 0.0:
        return s * s, integral_rate / a, integral, integral_rate
    return s * s, math.inf if integral_rate > 0.0 else 0.0, integral, integral_rate


@inlined
def _turning_segment(contact: ScaledContact, tolerance: float) -> int:
    """Find the segment in which a prescribed depth starts to fall by more than the rounding of a fitted function."""
    m = contact.values.shape[0]
    first, highest = 0, -math.inf
    for i in range(m):
        end = 0.0
        for n in range(contact.values.shape[1]):
            end += contact.values[i, n]
        if end > highest:
            first, highest = i, end
        # A fitted function may ripple by its own error at a hold.
        elif highest - end > tolerance:
            return first + 1
    return m


@compiled
def turning_point(contact: ScaledContact, work: Scratch, segments: int) -> tuple[int, float]:
    """Find the turning point under a prescribed force: the segment, and the time in it.

    The contact grows as long as Pi grows: beyond the largest force if creep outweighs the unloading.
    """
    last = contact.knots[segments]
    unloading = False
    for i in range(segments):
        b = contact.knots[i]
        h = contact.knots[i + 1] - b
        # The contact cannot shrink before the force falls for the first time.
        step = 0.0
        for n in range(1, contact.values.shape[1]):
            step += contact.values[i, n]
        unloading = unloading or step < 0.0
        if not unloading:
            continue
        # A material with glassy compliance yields at once, so a drop of the force ends the growth; a dashpot delays
        # it.
        if h == 0.0:
            if step < 0.0 and (contact.glass > 0.0 or _rate(contact, work, i + 1, b) < 0.0):
                return i, b
            continue
        low = b
        # Even places, and places near the start for fast recoveries.
        step = h / _EVEN_STEPS
        offset = 0.0
        for n in range(_PLACES):
            t = b + offset
            if t > b + h or t > last:
                t = b + h
            if _rate(contact, work, i, t) < 0.0:
                # Pi falls from the start of the segment on: the kink itself is the turning point.
                if offset == 0.0:
                    return i, b
                high = t
                for _ in range(_BISECTIONS):
                    middle = 0.5 * (low + high)
                    if _rate(contact, work, i, middle) < 0.0:
                        high = middle
                    else:
                        low = middle
                return i, high
            low = t
            if t >= b + h:
                break
            offset = (_FIRST_PLACE * h if n == 0 else _RATIO * offset) if offset < step else offset + step
    return segments, last


@inlined
def _rate(contact: ScaledContact, work: Scratch, i: int, t: float) -> float:
    """Return the rate of Pi plus its rounding: negative if Pi falls by more than rounding."""
    rate = prescribed(contact, i, t)[1]
    _, _, integral, integral_rate = growing_contact(contact, work, i, t)
    # Behind a jump at first touch Pi may be less than zero by rounding.
    mean = max(integral, 0.0) / t if t > 0.0 else 0.0
    return integral_rate + RATE_ROUNDING * (mean + contact.glass * abs(rate))


@inlined
def length_within(h: float, rest: float) -> float:
    """Return the length of the next element of a segment: h, or all of the rest where h would leave a sliver."""
    return rest if h > _MOST_OF_REST * rest else h


@inlined
def _write_jump(
    contact: ScaledContact, work: Scratch, elements: Elements, e: int, i: int, depth: float, integral: float
) -> tuple[float, float]:
    """Write element e, the jump that is segment i, from this depth and Pi; return those behind it."""
    b = contact.knots[i]
    elements.starts[e], elements.lengths[e], elements.segments[e] = b, 0.0, i
    elements.depths[e], elements.integrals[e] = depth, integral
    for n in range(TERMS):
        elements.depth_rates[e, n] = 0.0
        elements.integral_rates[e, n] = 0.0
    depth, _, integral, _ = growing_contact_at(contact, work, i, b)
    elements.depth_rates[e, 0] = depth - elements.depths[e]
    elements.integral_rates[e, 0] = integral - elements.integrals[e]
    return depth, integral


@inlined
def _sample_rates(contact: ScaledContact, quadrature: Quadrature, work: Scratch, i: int, b: float, h: float) -> None:
    """Write the rates of d and Pi at the nodes of an element from b on to `work.samples`."""
    for j in range(TERMS):
        t = b + 0.5 * h * (1.0 + quadrature.nodes[j])
        _, work.samples[0, j], _, work.samples[1, j] = growing_contact(contact, work, i, t)


@inlined
def _largest_integral(path: Path) -> float:
    """Pi at the end of a table: the sum of the coefficients of its last cell."""
    largest = 0.0
    for n in range(path.integral.shape[1]):
        largest += path.integral[path.integral.shape[0] - 1, n]
    return largest


@compiled
def grow(
    contact: ScaledContact,
    quadrature: Quadrature,
    work: Scratch,
    segments: int,
    end: float,
    tolerance: float,
    elements: Elements,
) -> int:
    """Cut the growing contact up to the turning point at `end`, which cuts the last of the segments, into elements.

    The tolerance is that of d and Pi over the largest, and of their rates where the modes forget faster than within an
    element. Returns the number of elements; NO_ROOM; BEYOND_PROFILE where a force presses the body deeper than the
    table of its profile reaches; or TOO_STEEP where even the shortest elements are too coarse.
    """
    room = elements.starts.shape[0]
    e, depth, integral = 0, 0.0, 0.0
    _, _, most, _ = growing_contact_at(contact, work, segments - 1, end)
    # Creep decides how deep a force presses; a power law has no end, a table has.
    if contact.control == FORCE and contact.path.exponent < 0.0 and most > _largest_integral(contact.path):
        return BEYOND_PROFILE
    largest = root_of_depth(contact.path, most) ** 2
    for i in range(segments):
        b = contact.knots[i]
        stop = min(contact.knots[i + 1], end)
        # A jump is an element of no length, whose first coefficients are the steps of d and Pi.
        if contact.knots[i + 1] == b:
            if e == room:
                return NO_ROOM
            depth, integral = _write_jump(contact, work, elements, e, i, depth, integral)
            e += 1
            elements.depths[e], elements.integrals[e] = depth, integral
            continue
        h, n_coarse = stop - b, 0
        while b < stop:
            if e == room:
                return NO_ROOM
            if n_coarse > _MOST_COARSE:
                return TOO_STEEP
            h = length_within(h, stop - b)
            _sample_rates(contact, quadrature, work, i, b, h)
            expand(quadrature, work.samples[0], elements.depth_rates[e])
            expand(quadrature, work.samples[1], elements.integral_rates[e])
            end_depth, _, end_integral, _ = growing_contact(contact, work, i, stop if h == stop - b else b + h)
            rate, integral_rate = (end_depth - depth) / h, (end_integral - integral) / h
            # A fast mode may relax between a kink and the first node, which only the mean of the rate shows. The times
            # are rounded, and the values of a steep history scatter by that.
            rounded = TIME_ROUNDING * (b + h) / most * variation(work.samples[1])
            mean_error = abs(elements.integral_rates[e, 0] - integral_rate) * h / most - rounded
            truncation = truncation_error(elements.integral_rates[e]) / most - rounded / h
            # Under a prescribed depth the depth itself is a polynomial, and exact.
            if contact.control == FORCE:
                rounded = TIME_ROUNDING * (b + h) / largest * variation(work.samples[0])
                mean_error = max(mean_error, abs(elements.depth_rates[e, 0] - rate) * h / largest - rounded)
                truncation = max(truncation, truncation_error(elements.depth_rates[e]) / largest - rounded / h)
            coarse = truncation * end > tolerance * max(1.0, contact.shortest / h) or mean_error > tolerance
            if coarse and h > SHORTEST_ELEMENT * b + FIRST_ELEMENT * stop:
                h *= 0.5
                continue
            n_coarse += coarse
            elements.starts[e], elements.lengths[e], elements.segments[e] = b, h, i
            elements.depths[e], elements.integrals[e] = depth, integral
            b = stop if h == stop - b else b + h
            # The mean of the rate: its sum over elements then gives d and Pi without an error that adds up.
            elements.depth_rates[e, 0] = rate
            elements.integral_rates[e, 0] = integral_rate
            depth, integral = end_depth, end_integral
            drop_rounding(elements.depth_rates[e])
            drop_rounding(elements.integral_rates[e])
            e += 1
            elements.depths[e], elements.integrals[e] = depth, integral
            h *= 2.0
    return e


@compiled
def growing_contact_at(contact: ScaledContact, work: Scratch, i: int, t: float) -> tuple[float, float, float, float]:
    """Return the depth, its rate, Pi and its rate as `growing_contact`, also behind a jump."""
    if contact.control == FORCE and contact.knots[i + 1] == contact.knots[i]:
        integral = contact.glass * (contact.values[i, 0] + contact.values[i, 1])
        for j in range(contact.compliances.shape[0]):
            integral += contact.compliances[j] * contact.level.begin[i, j]
        s = root_of_depth(contact.path, integral)
        return s * s, 0.0, integral, 0.0
    return growing_contact(contact, work, i, t)


@entry_point
def grow_contact(
    contact: ScaledContact, quadrature: Quadrature, work: Scratch, tolerance: float, segments: Segments, past: Past
) -> tuple[int, int, float]:
    """Write the growing contact and its memory to the arrays of `past`, which may be longer than needed.

    Returns the number of elements or a status of `grow`; the segment in which the contact starts to shrink; and
    the time of that. The tolerance is that of `grow`.
    """
    m = contact.values.shape[0]
    by_depth, punch = contact.control == DEPTH, contact.path.exponent == 0.0
    first, turning, total = m, 1.0, 0
    if not by_depth:
        expand_segments(contact, quadrature, 0, segments)
        remember(segments.lengths, segments.rates, contact.slope, work.sweep)
        remember(segments.lengths, segments.levels, contact.level, work.sweep)
        if not punch:
            first, turning = turning_point(contact, work, m)
    elif punch:
        # The contact radius never changes, so that no instant of equal contact is needed.
        first, turning = 0, 0.0
    else:
        first = _turning_segment(contact, tolerance)
        turning = contact.knots[first]
    elements = past.elements
    if not punch:
        cut = 1 if first < m and turning > contact.knots[first] else 0
        total = grow(contact, quadrature, work, first + cut, turning, tolerance, elements)
        if total < 0:
            return total, first, turning
    for k in range(contact.rates.shape[0]):
        past.depth.begin[0, k] = 0.0
        past.integral.begin[0, k] = 0.0
    remember(elements.lengths[:total], elements.depth_rates, past.depth, work.sweep)
    remember(elements.lengths[:total], elements.integral_rates, past.integral, work.sweep)
    if by_depth:
        expand_segments(contact, quadrature, first, segments)
        memory = past.depth
        rest = Memory(memory.rates, memory.begin[total:], memory.polynomial[total:], memory.transient[total:])
        remember(segments.lengths[first:m], segments.rates[first:], rest, work.sweep)
    return total, first, turning


@entry_point
def depth_rounding(past: Past) -> tuple[float, float]:
    """Return the largest change of the depth within the rounding of a time of the growing contact, and that time."""
    elements = past.elements
    worst, moment = 0.0, 0.0
    for e in range(past.total):
        if elements.lengths[e] > 0.0:
            change = CLOCK_ROUNDING * (elements.starts[e] + elements.lengths[e]) * elements.depth_rates[e, 0]
            if change > worst:
                worst, moment = change, elements.starts[e]
    return worst, moment
