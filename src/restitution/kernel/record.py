"""Force of a measured depth: elements of order two, one for each step of the record, over any history.

The depth is a straight line in each step. An element is named by s, the depth at which the undeformed surface touches
it. Elements lie in two stacks whose tops are the edge of the contact: those that follow the body, from the axis
outwards, and free ones from the edge outwards. Between two neighbours loads and displacements are linear over s. Each
has what it had when it changed state, and the instant; what it has later follows exactly, as in
`restitution.kernel.panels`:

    following:  l_k(t) = exp(-rho_k (t - t_i)) g_k + E_k h_k(t)         free:  w_j(t) = exp(-r_j (t - t_i)) w_j

A step moves the edge to a place where the load or the gap is zero at its end. It adds one element there, and erases
those that it sweeps, unless they are far apart. The load falls from the axis to zero at the edge, so that by parts

    F/2 = int q da = Einf Pi(s) + sum_k L_k,    L_k = -int a dl_k,    Pi(s) = int a ds

with all integrals from the axis to the edge. Each element has the L_k up to itself. As differences between elements
only decay, `L_k(t) = exp(-rho_k (t - t_i)) L_k(t_i)`: a step costs the same however many elements there are.

Forces are continuous in the contact point and in the moduli: where the edge passes an element, both ways of counting
agree.
"""

import math
from typing import Any, NamedTuple

import numpy as np

from restitution.kernel.compile import compiled, entry_point, inlined
from restitution.kernel.panels import Solid, leave, touch
from restitution.kernel.path import Path, radius_and_integral
from restitution.kernel.references import by_reference

# Largest force.
LARGEST = 1e150
# How a record ended: solved, in contact at its start, deeper than the profile, or with a number that is not finite.
SOLVED, TOUCHES_AT_START, BEYOND_PROFILE, NOT_FINITE = range(4)
FOLLOWING, FREE = 0, 1
# State between two steps: time, depth, rate that a dashpot in parallel feels, and the part of F/2 by the fast modes of
# the newest element. Of the elements that a step sweeps, some are kept that are this far apart.
TIME, DEPTH, DRAG, FAST, GRAIN = range(5)
# Turnings, touches and separations of one step, at most.
_EVENTS = 12
# Grain, over the largest depth.
_GRAIN = 0.01
# Iterations for an instant at which a quantity is zero, and for the depth of a tip on a spring.
_ROOT, _SPRING = 60, 8
# A rate below this share of its terms is rounding.
_ROUNDING = 1e-10


@by_reference
class Tip(NamedTuple):
    """Indenter: a(s) = radius times that of the path, at s in units of `depth`."""

    path: Path
    depth: float
    radius: float
    deepest: float  # depth at which it ends


@by_reference
class Solids(NamedTuple):
    """Many `Solid`, the numbers of each in a row."""

    equilibrium: Any  # (n,)
    viscosity: Any
    moduli: Any  # (n, K)
    rates: Any
    recoveries: Any  # (n, J)
    displacement: Any
    loads: Any  # (n, J, K)
    moduli_of: Any  # (n, K, J)


@by_reference
class Records(NamedTuple):
    """Depths of c records, one after the other; in SI."""

    first: Any  # (c + 1,): index of the first sample of each, and the number of all
    times: Any  # (P,)
    depths: Any  # of the tip, or of the base of its spring
    parts: Any  # (P,): number of equal steps from the sample before
    rates: Any  # (P,): rate of the depth from the sample before, without its noise
    drags: Any  # (P,): the same at the sample
    gains: Any  # (P,): noise of this rate over that of the depth
    compliances: Any  # (c,): of the spring; 0 without one


@by_reference
class Stack(NamedTuple):
    """Elements, the top last."""

    s: Any  # (N,)
    radius: Any  # (N,): a(s)
    integral: Any  # (N,): Pi(s)
    time: Any  # (N,): of the change of state
    parts: Any  # (N, K) or (N, J): g_k or w_j
    sums: Any  # (N, K): L_k up to the element


@by_reference
class Room(NamedTuple):
    """Arrays for one record."""

    following: Stack
    free: Stack
    counts: Any  # (2,): numbers of elements in the stacks
    state: Any  # (5,)
    shared: Any  # (K,): h_k
    before: Any  # (K,): h_k at the start of the step
    loads: Any  # (K,)
    lower: Any  # (J,): w_j of the inner one
    upper: Any  # (J,)
    touched: Any  # (J,)


def room(samples: int, K: int, J: int) -> Room:
    """Return arrays for a number of steps, branches and rates of recovery.

    A step adds one element, and an event within it one more, but most turnings erase some; a full stack makes room.
    """
    n = samples + _EVENTS

    def stack(quantities: int) -> Stack:
        return Stack(
            np.empty(n), np.empty(n), np.empty(n), np.empty(n), np.empty((n, quantities)), np.empty((n, K))
        )  # fmt: skip

    return Room(
        stack(K), stack(J), np.zeros(2, dtype=np.int64), np.zeros(5), np.zeros(K), np.empty(K), np.empty(K),
        np.empty(J), np.empty(J), np.empty(J),
    )  # fmt: skip


@inlined
def radii(tip: Tip, s: float) -> tuple[float, float]:
    """Contact radius and Pi of an element."""
    a, integral = radius_and_integral(tip.path, math.sqrt(max(s, 0.0) / tip.depth))
    return tip.radius * a, tip.radius * tip.depth * integral


@inlined
def _faded(rate: float, elapsed: float) -> float:
    return math.exp(-rate * elapsed)


@compiled
def load(solid: Solid, work: Room, i: int, t: float, depth: float) -> float:
    """Line load of a following element; `shared` is that of this time."""
    stack = work.following
    q = solid.equilibrium * (depth - stack.s[i]) + solid.viscosity * work.state[DRAG]
    for k in range(solid.rates.shape[0]):
        q += _faded(solid.rates[k], t - stack.time[i]) * stack.parts[i, k] + solid.moduli[k] * work.shared[k]
    return q


@compiled
def gap(solid: Solid, work: Room, i: int, t: float, depth: float, parts: Any) -> float:
    """Gap of a free element, whose w_j are written."""
    stack = work.free
    value = stack.s[i] - depth
    for j in range(solid.recoveries.shape[0]):
        parts[j] = _faded(solid.recoveries[j], t - stack.time[i]) * stack.parts[i, j]
        value += parts[j]
    return value


@compiled
def closing(solid: Solid, work: Room, t: float, rate: float) -> tuple[float, float]:
    """Rate at which the gap of the edge would close if it were free, and the size of its terms."""
    stack, i = work.free, work.counts[FREE] - 1
    value, size = rate, abs(rate)
    for j in range(solid.recoveries.shape[0]):
        r = solid.recoveries[j]
        term = r * _faded(r, t - stack.time[i]) * stack.parts[i, j]
        value += term
        size += abs(term)
    return value, size


@compiled
def pass_time(solid: Solid, work: Room, elapsed: float, rate: float) -> None:
    """Advance what all following elements share by a time."""
    for k in range(solid.rates.shape[0]):
        x = solid.rates[k] * elapsed
        work.before[k] = work.shared[k]
        work.shared[k] = math.exp(-x) * work.shared[k] + rate * elapsed * _mean(x)


@inlined
def _mean(x: float) -> float:
    """Return (1 - exp(-x))/x."""
    return -math.expm1(-x) / x if x > 0.0 else 1.0


@inlined
def _push(tip: Tip, stack: Stack, counts: Any, which: int, s: float, t: float) -> int:
    """Add an element, and return its place; the last one of a full stack makes room."""
    i = min(counts[which], stack.s.shape[0] - 1)
    stack.s[i], stack.time[i] = s, t
    stack.radius[i], stack.integral[i] = radii(tip, s)
    counts[which] = i + 1
    return i


@inlined
def _mean_radius(inner: int, outer: int, stack: Stack) -> float:
    """Mean of a(s) between two elements."""
    width = stack.s[outer] - stack.s[inner]
    mean = 0.5 * (stack.radius[outer] + stack.radius[inner])
    if width > 1e-9 * stack.s[outer]:
        mean = (stack.integral[outer] - stack.integral[inner]) / width
    return mean


@inlined
def _mean_place(x: float) -> float:
    """Mean place, from 0 to 1 at the edge, less 1/2, where differences are exp(-x (1 - place)) times a constant."""
    if x < 1e-2:
        return x / 12.0
    return 1.0 / -math.expm1(-x) - 1.0 / x - 0.5 if x < 700.0 else 0.5 - 1.0 / x


@inlined
def _follow(solid: Solid, tip: Tip, work: Room, s: float, t: float) -> int:
    """Add an element that follows from now on with the loads `work.loads`, and return its place."""
    stack = work.following
    i = _push(tip, stack, work.counts, FOLLOWING, s, t)
    mean, passed = _mean_radius(i - 1, i, stack), t - stack.time[i - 1]
    for k in range(solid.rates.shape[0]):
        fading, rest = _faded(solid.rates[k], passed), work.loads[k] - solid.moduli[k] * work.shared[k]
        stack.sums[i, k] = fading * stack.sums[i - 1, k] + (fading * stack.parts[i - 1, k] - rest) * mean
        stack.parts[i, k] = rest
    return i


@compiled
def caught(solid: Solid, tip: Tip, work: Room, i: int, begin: float, end: float, depth: float, rate: float) -> None:
    """Let a free element follow from the instant at which its gap vanishes; `depth` is that at the start of a step."""
    low, high, passed = 0.0, end - begin, end - begin
    for _ in range(_ROOT):
        passed = 0.5 * (low + high)
        if gap(solid, work, i, begin + passed, depth + rate * passed, work.touched) > 0.0:
            low = passed
        else:
            high = passed
    touch(solid, work.touched, work.loads)
    rest = end - begin - passed
    for k in range(solid.rates.shape[0]):
        x = solid.rates[k] * rest
        work.loads[k] = math.exp(-x) * work.loads[k] + solid.moduli[k] * rate * rest * _mean(x)
    _follow(solid, tip, work, work.free.s[i], end)


@compiled
def grow(solid: Solid, tip: Tip, work: Room, begin: float, t: float, depth: float, rate: float) -> None:
    """Move the edge outwards to the place where the gap is zero at the end of a step."""
    free, stack, counts = work.free, work.following, work.counts
    top = counts[FREE] - 1
    inner = gap(solid, work, top, t, depth, work.lower)
    if inner >= 0.0:
        return
    J, s, elapsed = solid.recoveries.shape[0], free.s[top], t - begin
    share, further, kept, top = 1.0, depth, s, top - 1
    while top >= 0:
        outer = gap(solid, work, top, t, depth, work.upper)
        if outer >= 0.0:
            share, further = inner / (inner - outer), free.s[top]
            break
        inner, s = outer, free.s[top]
        for j in range(J):
            work.lower[j] = work.upper[j]
        if s - kept > work.state[GRAIN]:
            caught(solid, tip, work, top, begin, t, depth - rate * elapsed, rate)
            kept = s
        top -= 1
    counts[FREE] = top + 1
    if top < 0:
        # Beyond all elements lies virgin surface.
        for j in range(J):
            work.upper[j] = 0.0
    for j in range(J):
        work.lower[j] += share * (work.upper[j] - work.lower[j])
    s += share * (further - s)
    i = _push(tip, free, counts, FREE, s, t)
    for j in range(J):
        free.parts[i, j] = work.lower[j]
    touch(solid, work.lower, work.loads)
    i = _follow(solid, tip, work, s, t)
    width = stack.radius[i] - stack.radius[i - 1]
    for k in range(solid.rates.shape[0]):
        less = _faded(solid.rates[k], t - stack.time[i - 1]) * stack.parts[i - 1, k] - stack.parts[i, k]
        work.state[FAST] += less * width * _mean_place(solid.rates[k] * elapsed)


@inlined
def _free(solid: Solid, tip: Tip, work: Room, s: float, t: float, depth: float) -> None:
    """Add a free element that leaves now with the loads `work.loads`."""
    i = _push(tip, work.free, work.counts, FREE, s, t)
    leave(solid, depth - s, work.loads, work.free.parts[i])


@compiled
def leaving(
    solid: Solid, tip: Tip, work: Room, i: int, begin: float, end: float, depth: float, rate: float
) -> float:  # fmt: skip
    """Free an element when its load vanishes, and return this instant; `depth` is that at the start of a step."""
    stack, K = work.following, solid.rates.shape[0]
    low, high, passed = 0.0, end - begin, end - begin
    for _ in range(_ROOT):
        passed = 0.5 * (low + high)
        q = solid.equilibrium * (depth + rate * passed - stack.s[i]) + solid.viscosity * work.state[DRAG]
        for k in range(K):
            x = solid.rates[k] * passed
            common = math.exp(-x) * work.before[k] + rate * passed * _mean(x)
            fading = _faded(solid.rates[k], begin + passed - stack.time[i])
            work.loads[k] = fading * stack.parts[i, k] + solid.moduli[k] * common
            q += work.loads[k]
        if q >= 0.0:
            low = passed
        else:
            high = passed
    _free(solid, tip, work, stack.s[i], begin + passed, depth + rate * passed)
    return begin + passed


@compiled
def retreat(solid: Solid, tip: Tip, work: Room, begin: float, t: float, depth: float, rate: float) -> bool:
    """Move the edge inwards to the place where the load is zero at the end of a step; return whether there is one.

    In a step of no length, where the rate jumps, all elements are kept that are swept.
    """
    stack, counts = work.following, work.counts
    K, inner, share = solid.rates.shape[0], 0.0, 0.0
    i = last = counts[FOLLOWING] - 1
    outer, kept = load(solid, work, i, t, depth), stack.s[i]
    grain = work.state[GRAIN] if t > begin else -1.0
    if outer >= 0.0:
        return True
    while i > 0:
        inner = load(solid, work, i - 1, t, depth)
        if i < last and kept - stack.s[i] > grain:
            leaving(solid, tip, work, i, begin, t, depth - rate * (t - begin), rate)
            kept = stack.s[i]
        if inner >= 0.0:
            break
        outer = inner
        i -= 1
    counts[FOLLOWING] = i
    if i == 0:
        return False
    share = inner / (inner - outer)
    for k in range(K):
        low, high = (
            _faded(solid.rates[k], t - stack.time[i - 1]) * stack.parts[i - 1, k],
            _faded(solid.rates[k], t - stack.time[i]) * stack.parts[i, k],
        )
        work.loads[k] = low + share * (high - low) + solid.moduli[k] * work.shared[k]
    s = stack.s[i - 1] + share * (stack.s[i] - stack.s[i - 1])
    _follow(solid, tip, work, s, t)
    _free(solid, tip, work, s, t, depth)
    return True


@compiled
def touch_axis(solid: Solid, tip: Tip, work: Room, begin: float, end: float, depth: float, rate: float) -> float:
    """Let the axis follow the body when its gap vanishes, and return this instant."""
    free, counts = work.free, work.counts
    if counts[FREE] == 0:
        i = _push(tip, free, counts, FREE, 0.0, begin)
        for j in range(solid.recoveries.shape[0]):
            free.parts[i, j] = 0.0
    top = counts[FREE] - 1
    low, high, passed = 0.0, end - begin, end - begin
    for _ in range(_ROOT):
        passed = 0.5 * (low + high)
        if gap(solid, work, top, begin + passed, depth + rate * passed, work.lower) > 0.0:
            low = passed
        else:
            high = passed
    touch(solid, work.lower, work.loads)
    i = _push(tip, work.following, counts, FOLLOWING, 0.0, begin + passed)
    for k in range(solid.rates.shape[0]):
        work.shared[k] = 0.0
        work.following.parts[i, k], work.following.sums[i, k] = work.loads[k], 0.0
    return begin + passed


@compiled
def turning(solid: Solid, work: Room, begin: float, end: float, rate: float, first: float) -> float:
    """Return the instant at which the edge turns; `first` is the rate at which its gap would close at the start."""
    low, high, middle = begin, end, end
    for _ in range(_ROOT):
        middle = 0.5 * (low + high)
        if closing(solid, work, middle, rate)[0] * first > 0.0:
            low = middle
        else:
            high = middle
    return middle


@compiled
def settle(solid: Solid, tip: Tip, work: Room) -> None:
    """Let elements leave whose load a rate that jumps has taken away, as that of a dashpot in parallel."""
    t, depth = work.state[TIME], work.state[DEPTH]
    pass_time(solid, work, 0.0, 0.0)
    if work.counts[FOLLOWING] > 0 and not retreat(solid, tip, work, t, t, depth, 0.0):
        leaving(solid, tip, work, 0, t, t, depth, 0.0)
        work.counts[FOLLOWING] = 0


@compiled
def advance(solid: Solid, tip: Tip, work: Room, end: float, depth: float) -> None:
    """Move along a straight line of the depth to its end."""
    state, counts = work.state, work.counts
    rate = (depth - state[DEPTH]) / (end - state[TIME])
    for _ in range(_EVENTS):
        begin, start, stop = state[TIME], state[DEPTH], end
        if not begin < end:
            break
        state[FAST] = 0.0
        if counts[FOLLOWING] == 0:
            top = counts[FREE] - 1
            closed = gap(solid, work, top, end, depth, work.lower) < 0.0 if top >= 0 else depth > 0.0
            if closed:
                stop = touch_axis(solid, tip, work, begin, end, start, rate)
        else:
            if solid.viscosity > 0.0:
                settle(solid, tip, work)
                if counts[FOLLOWING] == 0:
                    continue
            first, size = closing(solid, work, begin, rate)
            last = closing(solid, work, end, rate)[0]
            if first * last < 0.0 and abs(first) > _ROUNDING * size:
                stop = turning(solid, work, begin, end, rate, first)
                last = first
            there = depth if stop == end else start + rate * (stop - begin)
            pass_time(solid, work, stop - begin, rate)
            if last > 0.0:
                grow(solid, tip, work, begin, stop, there, rate)
            elif not retreat(solid, tip, work, begin, stop, there, rate):
                stop = leaving(solid, tip, work, 0, begin, stop, start, rate)
                counts[FOLLOWING] = 0
        state[DEPTH] = depth if stop == end else start + rate * (stop - begin)
        state[TIME] = stop


@compiled
def half_force(solid: Solid, work: Room) -> float:
    """Return F/2 now."""
    i = work.counts[FOLLOWING] - 1
    if i < 0:
        return 0.0
    stack, t = work.following, work.state[TIME]
    value = solid.equilibrium * stack.integral[i] + work.state[FAST]
    for k in range(solid.rates.shape[0]):
        value += _faded(solid.rates[k], t - stack.time[i]) * stack.sums[i, k]
    if solid.viscosity > 0.0:
        # A growing contact with a dashpot has a load at its edge, and so has one whose rate changes.
        value += load(solid, work, i, t, work.state[DEPTH]) * stack.radius[i]
    return max(value, 0.0)


@compiled
def on_a_spring(solid: Solid, tip: Tip, work: Room, end: float, base: float, compliance: float) -> float:
    """Return the depth of a tip whose spring has its base at a depth, d = base - compliance F.

    F is that at the end of a step: what the elements in contact have then, and q grows from zero over new ones.
    """
    i = work.counts[FOLLOWING] - 1
    if i < 0:
        return base
    stack, elapsed = work.following, end - work.state[TIME]
    s, start = stack.s[i], work.state[DEPTH]
    force, edge = solid.equilibrium * stack.integral[i], solid.equilibrium * (start - s)
    stiffness = solid.equilibrium + solid.viscosity / elapsed
    for k in range(solid.rates.shape[0]):
        rho = solid.rates[k]
        fading = _faded(rho, end - stack.time[i])
        force += fading * stack.sums[i, k]
        edge += fading * stack.parts[i, k] + solid.moduli[k] * math.exp(-rho * elapsed) * work.shared[k]
        stiffness += solid.moduli[k] * _mean(rho * elapsed)
    change, mean = 0.0, stack.radius[i]
    for _ in range(_SPRING):
        slope = 2.0 * compliance * mean
        change = (base - start - 2.0 * compliance * force - slope * edge) / (1.0 + slope * stiffness)
        if change > 0.0:
            integral = radii(tip, s + change)[1]
            mean = (integral - stack.integral[i]) / change
        else:
            mean = stack.radius[i]
    return start + change


@compiled
def stiffness(solid: Solid, work: Room, elapsed: float, gain: float) -> float:
    """Change of the force over a change of the depth at the end of a step of this length."""
    i = work.counts[FOLLOWING] - 1
    if i < 0:
        return 0.0
    value, drag = solid.equilibrium, solid.viscosity * gain
    for k in range(solid.rates.shape[0]):
        value += solid.moduli[k] * _mean(solid.rates[k] * elapsed)
    return 2.0 * math.sqrt(value * value + drag * drag) * work.following.radius[i]


@inlined
def solid_at(solids: Solids, n: int) -> Solid:
    """One of many solids."""
    return Solid(
        solids.equilibrium[n], solids.viscosity[n], solids.moduli[n], solids.rates[n], 0.0, solids.recoveries[n],
        solids.displacement[n], solids.loads[n], solids.moduli_of[n],
    )  # fmt: skip


@compiled
def follow(
    solid: Solid, tip: Tip, records: Records, record: int, contact_point: float, work: Room, forces: Any, slopes: Any
) -> int:
    """Write the force at each sample of a record, whose surface is at a depth reading; return how it ended.

    The slopes are those of the force over the depth of that sample alone.
    """
    first, last = records.first[record], records.first[record + 1]
    compliance = records.compliances[record]
    work.counts[FOLLOWING], work.counts[FREE] = 0, 0
    work.state[TIME], work.state[DEPTH] = records.times[first], records.depths[first] - contact_point
    if work.state[DEPTH] > 0.0:
        return TOUCHES_AT_START
    deepest = 0.0
    for n in range(first, last):
        deepest = max(deepest, records.depths[n] - contact_point)
    work.state[GRAIN] = _GRAIN * deepest
    forces[0], slopes[0] = 0.0, 0.0
    for n in range(first + 1, last):
        begin, start = records.times[n - 1], records.depths[n - 1] - contact_point
        elapsed, moved = records.times[n] - begin, records.depths[n] - contact_point - start
        for part in range(records.parts[n]):
            share = (part + 1.0) / records.parts[n]
            end = records.times[n] if part + 1 == records.parts[n] else begin + share * elapsed
            depth, work.state[DRAG] = start + share * moved, records.rates[n]
            if compliance > 0.0:
                depth = on_a_spring(solid, tip, work, end, depth, compliance)
                work.state[DRAG] = (depth - work.state[DEPTH]) / (end - work.state[TIME])
            if depth > tip.deepest:
                return BEYOND_PROFILE
            advance(solid, tip, work, end, depth)
            # After an abundance of events: the line is left early.
            work.state[TIME], work.state[DEPTH] = end, depth
        if solid.viscosity > 0.0 and compliance == 0.0:
            work.state[DRAG] = records.drags[n]
            if n + 1 < last and records.drags[n] == records.rates[n + 1]:
                settle(solid, tip, work)
        force = 2.0 * half_force(solid, work)
        if not force < LARGEST:
            return NOT_FINITE
        forces[n - first] = force
        slope = stiffness(solid, work, elapsed, records.gains[n])
        slopes[n - first] = slope / (1.0 + compliance * slope)
    return SOLVED


@entry_point
def record_forces(
    solids: Solids, tip: Tip, records: Records, places: Any, contact_points: Any, work: Room, results: Any, status: Any
) -> None:
    """Write forces and slopes of each row, a solid on a record with a contact point, and how it ended."""
    for n in range(places.shape[0]):
        status[n] = follow(
            solid_at(solids, n), tip, records, places[n], contact_points[n], work, results[0, n], results[1, n]
        )
