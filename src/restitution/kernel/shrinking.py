"""Shrinking contact under a prescribed depth or force (Ting; Graham): its radius, its end, and whether it grows again.

Let t1 be the instant of the growing contact with the same radius. With the memories H_k of d and Y_k of Pi, and with
X_k = exp(-(t - t1)/tau_k),

    E d1 + sum E_k X_k H_k(t1) = E d + eta d' + sum E_k H_k(t)      (depth prescribed),
    E Pi1 + sum E_k X_k Y_k(t1) = F                                 (force prescribed),

one equation for t1, whose left-hand side rises with t1. In the first case the other left-hand side is the force.
"""

import math
from typing import Any, NamedTuple

from restitution.kernel.compile import compiled, entry_point, inlined
from restitution.kernel.growing import (
    CLOCK_ROUNDING,
    NEWTON_ROUNDING,
    NEWTON_ROUNDS,
    Past,
    growing_contact,
    root_of_depth,
)
from restitution.kernel.memory import (
    DEPTH,
    TIME_ROUNDING,
    Memory,
    ScaledContact,
    Scratch,
    legendre_values,
    prescribed,
    recall,
)
from restitution.kernel.path import radius_and_integral
from restitution.kernel.references import by_reference

# The search for an instant ends if the estimate of the step after the next, or the width of the interval, is rounding:
# both over the time.
_NEXT_STEP = 1e-16
_SPACING = 2e-16
# Even checks of the state in a segment; only one in `_STRIDE` of them in a segment shorter than `_SHORT`.
_SHARES = 9
_STRIDE = 4
_SHORT = 0.02
# A mode whose relaxation time is longer than this share of a segment is checked at a quarter of that time, and at it.
_QUICK = 1e-4
# Rounding of a load over the sum of the moduli and the largest rate.
_LOAD_ROUNDING = 1e-14


class Equal(NamedTuple):
    """Instant t1 at which the growing contact had the same radius as at t, and values there."""

    element: int
    time: float  # t1
    depth: float
    integral: float  # Pi
    modulus: float  # E(t - t1)
    slope: float  # Derivative of the left-hand side of the equation for t1


class Shrunk(NamedTuple):
    """Shrinking contact at an instant."""

    equal: Equal
    force: float
    # Rate of the right-hand side of the equation for t1 less that of the left at constant t1, not positive. Over the
    # modulus it is the rate of d1, over the slope that of t1.
    growth: float


@by_reference
class Checks(NamedTuple):
    """Instants at which the shrinking contact is checked."""

    segments: Any  # (n,): of the history
    times: Any  # (n,): ascending


@inlined
def equal_contact(
    contact: ScaledContact, past: Past, work: Scratch, t: float, target: float, e: int, t1: float
) -> Equal:
    """Find the instant t1 at which the growing contact had the same radius as at t; start from t1 in element e.

    `target` is the right-hand side of the equation for t1.
    """
    elements = past.elements
    direction = 0
    while e > 0 and t1 < elements.starts[e]:
        e -= 1
    while True:
        if elements.lengths[e] == 0.0:
            side, equal = _equal_in_jump(contact, past, t, target, e)
        else:
            side, equal = _equal_in_element(contact, past, work, t, target, e, t1)
        # The left-hand side rises with t1, so the side shows the way. A search that would turn back has t1 at the
        # border of two elements.
        if side < 0 and e > 0 and direction <= 0:
            e -= 1
            t1 = elements.starts[e] + elements.lengths[e]
            direction = -1
        elif side > 0 and e + 1 < past.total and direction >= 0:
            e += 1
            t1 = elements.starts[e]
            direction = 1
        else:
            return equal


@compiled
def _equal_in_jump(contact: ScaledContact, past: Past, t: float, target: float, e: int) -> tuple[int, Equal]:
    """Return the side of the jump e on which t1 lies, or 0 within it; equal contact in the jump."""
    elements = past.elements
    by_depth = contact.control == DEPTH
    memory = past.depth if by_depth else past.integral
    low = elements.depths[e] if by_depth else elements.integrals[e]
    jump = (elements.depths[e + 1] if by_depth else elements.integrals[e + 1]) - low
    base = contact.equilibrium * low
    modulus = contact.equilibrium
    for k in range(contact.moduli.shape[0]):
        X = math.exp(-(t - elements.starts[e]) * contact.rates[k])
        base += contact.moduli[k] * X * memory.begin[e, k]
        modulus += contact.moduli[k] * X
    # In a jump no mode relaxes: the left-hand side rises in proportion to the share of the jump.
    x = (target - base) / (modulus * jump)
    side = 1 if x > 1.0 else (0 if x >= 0.0 else -1)
    x = min(max(x, 0.0), 1.0)
    depth = elements.depths[e] + x * (elements.depths[e + 1] - elements.depths[e])
    integral = elements.integrals[e] + x * (elements.integrals[e + 1] - elements.integrals[e])
    # Depth and Pi do not rise in proportion: the one that the equation determines gives the other.
    if by_depth:
        integral = radius_and_integral(contact.path, math.sqrt(max(depth, 0.0)))[1]
    else:
        depth = root_of_depth(contact.path, integral) ** 2
    return side, Equal(e, elements.starts[e], depth, integral, modulus, math.inf)


@inlined
def _equal_in_element(
    contact: ScaledContact, past: Past, work: Scratch, t: float, target: float, e: int, t1: float
) -> tuple[int, Equal]:
    """Return the side of element e on which t1 lies, or 0 within it; equal contact in the element.

    Newton's method from t1, kept inside a bracket.
    """
    elements = past.elements
    by_depth = contact.control == DEPTH
    memory = past.depth if by_depth else past.integral
    b, h, segment = elements.starts[e], elements.lengths[e], elements.segments[e]
    low, high = b, b + h
    low_known, high_known = False, False
    t1 = min(max(t1, low), high)
    # The left-hand side bends over the shortest relaxation time.
    scale = min(h, contact.shortest)
    previous, side = scale, 0
    modulus, slope = 0.0, 0.0
    for _ in range(NEWTON_ROUNDS):
        depth, depth_rate, integral, integral_rate = growing_contact(contact, work, segment, t1)
        legendre_values(2.0 * (t1 - b) / h - 1.0, work.basis)
        value = contact.equilibrium * (depth if by_depth else integral)
        modulus = contact.equilibrium
        for k in range(contact.moduli.shape[0]):
            X = contact.moduli[k] * math.exp(-(t - t1) * contact.rates[k])
            value += X * recall(memory, e, k, t1 - b, work.basis)
            modulus += X
        slope = modulus * (depth_rate if by_depth else integral_rate)
        residual = value - target
        if residual == 0.0:
            break
        # The left-hand side is too large already at the start of the element: t1 lies before it.
        if residual > 0.0:
            if t1 <= b:
                side = -1
                break
            high, high_known = t1, True
        else:
            if t1 >= b + h:
                side = 1
                break
            low, low_known = t1, True
        # Newton, else bisection; an end that was not tried yet is tried first.
        trial = t1 - residual / slope if slope > 0.0 else (-math.inf if residual > 0.0 else math.inf)
        if trial <= low:
            trial = 0.5 * (low + high) if low_known else low
        elif trial >= high:
            trial = 0.5 * (low + high) if high_known else high
        elif low_known and high_known and abs(trial - t1) > 0.5 * previous:
            trial = 0.5 * (low + high)
        step = abs(trial - t1)
        # Newton's next step is about step^2/scale, or step^3/previous^2 where that is more.
        done = step <= TIME_ROUNDING * t or step * max(step / scale, (step / previous) ** 2) <= _NEXT_STEP * t
        t1 = trial
        if done and low < t1 < high:
            break
        if low_known and high_known and high - low <= _SPACING * high:
            break
        previous = step
    depth, _, integral, _ = growing_contact(contact, work, segment, t1)
    return side, Equal(e, t1, depth, integral, modulus, slope)


@inlined
def remaining(
    contact: ScaledContact, past: Past, work: Scratch, memory: Memory, t: float, e: int, t1: float, step: float
) -> tuple[float, float]:
    """Return the part of the load of the modes at t1, in element e, that has not relaxed by t; and its rate of decay.

    If the element is a jump, `step` is the part of the jump up to t1 in the quantity of `memory`.
    """
    b, h = past.elements.starts[e], past.elements.lengths[e]
    if h > 0.0:
        legendre_values(2.0 * (t1 - b) / h - 1.0, work.basis)
    load = 0.0
    fading = 0.0
    for k in range(contact.moduli.shape[0]):
        value = recall(memory, e, k, t1 - b, work.basis) if h > 0.0 else memory.begin[e, k] + step
        value *= contact.moduli[k] * math.exp(-(t - t1) * contact.rates[k])
        load += value
        fading += contact.rates[k] * value
    return load, fading


@inlined
def innermost_load(contact: ScaledContact, past: Past, work: Scratch, i: int, t: float) -> tuple[float, float]:
    """Load of the innermost element under a prescribed depth, and its rate; write the memory to `work.now`.

    Valid in segments of the shrinking contact, and for a flat punch in the whole history.
    """
    value, rate, curvature = prescribed(contact, i, t)
    e = past.total + i - past.first
    b = contact.knots[i]
    h = contact.knots[i + 1] - b
    # Behind the jump.
    if h == 0.0:
        for k in range(contact.moduli.shape[0]):
            work.now[k] = past.depth.begin[e + 1, k]
    else:
        legendre_values(2.0 * (t - b) / h - 1.0, work.basis)
        for k in range(contact.moduli.shape[0]):
            work.now[k] = recall(past.depth, e, k, t - b, work.basis)
    load = contact.equilibrium * value + contact.viscosity * rate
    load_rate = contact.equilibrium * rate + contact.viscosity * curvature
    for k in range(contact.moduli.shape[0]):
        load += contact.moduli[k] * work.now[k]
        load_rate += contact.moduli[k] * (rate - contact.rates[k] * work.now[k])
    return load, load_rate


@entry_point
def write_depth_memory(contact: ScaledContact, past: Past, work: Scratch, i: int, t: float) -> None:
    """Write the memory of the depth at time t in segment i of the shrinking contact to `work.now`; before a jump."""
    if contact.knots[i + 1] == contact.knots[i]:
        for k in range(contact.moduli.shape[0]):
            work.now[k] = past.depth.begin[past.total + i - past.first, k]
        return
    innermost_load(contact, past, work, i, t)


@inlined
def shrinking_contact(
    contact: ScaledContact, past: Past, work: Scratch, i: int, t: float, e: int, t1: float
) -> Shrunk:
    """Return the shrinking contact at time t in segment i; the search begins at t1 in element e."""
    value, rate, _ = prescribed(contact, i, t)
    # Depth prescribed: the equation of the displacement gives t1. Force prescribed: that of the force (see above).
    if contact.control == DEPTH:
        target, growth = innermost_load(contact, past, work, i, t)
    else:
        target, growth = value, rate
    equal = equal_contact(contact, past, work, t, target, e, t1)
    e, t1 = equal.element, equal.time
    step = equal.integral - past.elements.integrals[e]
    load, fading = remaining(contact, past, work, past.integral, t, e, t1, step)
    force = value
    if contact.control == DEPTH:
        force = contact.equilibrium * equal.integral + load
        _, fading = remaining(contact, past, work, past.depth, t, e, t1, equal.depth - past.elements.depths[e])
    return Shrunk(equal, force, growth + fading)


@entry_point
def check_points(contact: ScaledContact, past: Past, checks: Checks) -> int:
    """Write the checks; return their number.

    A segment has room for `_SHARES` times and two of each mode.
    """
    places, times = checks.segments, checks.times
    count = 0
    for i in range(past.first, contact.values.shape[0]):
        low, high = max(contact.knots[i], past.turning), contact.knots[i + 1]
        width = high - low
        start = count
        for n in range(_SHARES if width > 0.0 else 1):
            if n % _STRIDE == 0 or width > _SHORT:
                times[count] = min(low + width * (n / (_SHARES - 1.0)), high)
                count += 1
        for k in range(contact.rates.shape[0]):
            # A mode reacts to a kink within its relaxation time.
            near = 1.0 / contact.rates[k]
            if _QUICK * width < near < width:
                times[count] = min(low + 0.25 * near, high)
                times[count + 1] = min(low + near, high)
                count += 2
        for n in range(start, count):
            places[n] = i
            t, p = times[n], n
            while p > start and times[p - 1] > t:
                times[p] = times[p - 1]
                p -= 1
            times[p] = t
    return count


@entry_point
def load_rounding(contact: ScaledContact, past: Past) -> float:
    """Return the rounding of the rate of the load while the contact shrinks; times are rounded in fast modes."""
    fastest, moduli = 0.0, contact.equilibrium
    for k in range(contact.rates.shape[0]):
        fastest = max(fastest, contact.rates[k])
        moduli += contact.moduli[k]
    return (_LOAD_ROUNDING + CLOCK_ROUNDING * fastest) * moduli * largest_rate(contact, past)


@entry_point
def largest_rate(contact: ScaledContact, past: Past) -> float:
    """Estimate of the largest rate of the prescribed history after the growth of the contact; at least 1."""
    largest = 1.0
    for i in range(past.first, contact.values.shape[0]):
        width, change = contact.knots[i + 1] - contact.knots[i], 0.0
        for n in range(1, contact.values.shape[1]):
            change += abs(contact.values[i, n])
        if width > 0.0:
            largest = max(largest, change / width)
    return largest


@entry_point
def end_of_contact(contact: ScaledContact, past: Past, work: Scratch, checks: Checks) -> float:
    """Time at which the load of the innermost element falls to zero under a prescribed depth, or infinity."""
    places, times = checks.segments, checks.times
    low = 0.0
    for n in range(times.shape[0]):
        i, t = places[n], times[n]
        if t == 0.0 or innermost_load(contact, past, work, i, t)[0] > 0.0:
            low = t
            continue
        if n > 0 and places[n - 1] == i and t > low:
            high = t
            t = 0.5 * (low + high)
            for _ in range(NEWTON_ROUNDS):
                load, rate = innermost_load(contact, past, work, i, t)
                if load > 0.0:
                    low = t
                else:
                    high = t
                trial = t - load / rate if rate < 0.0 else low
                if not low < trial < high:
                    trial = 0.5 * (low + high)
                if abs(trial - t) <= NEWTON_ROUNDING * t or high - low <= NEWTON_ROUNDING * high:
                    break
                t = trial
        return t
    return math.inf


@entry_point
def regrowth(
    contact: ScaledContact, past: Past, work: Scratch, checks: Checks, tolerance: float, rounding: float
) -> int:
    """Return the index of the first check at which the shrinking contact grows again, or -1.

    `tolerance` is a harmless growth of the depth at equal contact, `rounding` the rounding of the rate of the load.
    """
    times = checks.times
    e, t1 = past.total - 1, past.turning
    least = math.inf
    for n in range(times.shape[0]):
        if times[n] >= past.end:
            break
        now = shrinking_contact(contact, past, work, checks.segments[n], times[n], e, t1)
        e, t1 = now.equal.element, now.equal.time
        ahead = times[n + 1] - times[n] if n + 1 < times.shape[0] else 0.0
        # Between two checks the contact may have grown and shrunk; the depth at equal contact shows it.
        if now.equal.depth > least + tolerance:
            return n
        # phi d1' = growth: a small rate matters only if it lasts up to the next check.
        if now.growth > rounding and now.growth * ahead > tolerance * now.equal.modulus:
            return n
        least = min(least, now.equal.depth)
    return -1


@entry_point
def innermost_load_rises(
    contact: ScaledContact, past: Past, work: Scratch, checks: Checks, tolerance: float, rounding: float
) -> bool:
    """Return whether the innermost element would be loaded again after the contact if it stuck to the indenter.

    If not, the surface cannot reach the indenter again. It cannot reach an indenter above the undeformed surface
    either.
    """
    least = 0.0
    for n in range(checks.times.shape[0]):
        i, t = checks.segments[n], checks.times[n]
        if t <= past.end:
            continue
        load, rate = innermost_load(contact, past, work, i, t)
        above = prescribed(contact, i, t)[0] <= 0.0
        # An indenter above the undeformed surface is out of reach, whatever the load of a glued element would be.
        if above:
            least = min(least, load)
        elif load > least + tolerance or rate > tolerance + rounding:
            return True
        least = min(least, load)
    return False
