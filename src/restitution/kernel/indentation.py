"""Contact under a prescribed history at given times: growth, shrinkage, and after the end.

Under a prescribed depth the force follows from the past. Under a prescribed force the depth of the shrinking contact
follows by creep: d - d_m = int J(t - t') dq(t') with

    q(t) = E d1 + sum E_k X_k H_k(t1) - (the same for t1 = t_m).

q is cut into elements like the rates of the growing contact (docs/theory/indentation.md).
"""

import math
from typing import Any, NamedTuple

from restitution.kernel.compile import compiled, entry_point, inlined
from restitution.kernel.growing import (
    Past,
    growing_contact,
    length_within,
    root_of_depth,
)
from restitution.kernel.memory import (
    DEPTH,
    SHORTEST_ELEMENT,
    TERMS,
    TIME_ROUNDING,
    Memory,
    Quadrature,
    ScaledContact,
    Scratch,
    expand,
    legendre_slopes,
    legendre_values,
    prescribed,
    recall,
    recall_rate,
    truncation_error,
    variation,
)
from restitution.kernel.path import radius_and_integral
from restitution.kernel.references import by_reference
from restitution.kernel.shrinking import (
    equal_contact,
    innermost_load,
    remaining,
    shrinking_contact,
)


@by_reference
class Recovery(NamedTuple):
    """Depth of the shrinking contact under a prescribed force: q over elements, and its memory."""

    starts: Any  # (E,)
    lengths: Any  # (E,)
    q: Any  # (E, TERMS): legendre coefficients
    level: Memory  # Memory of q at the rates `recoveries`


@entry_point
def recover(
    contact: ScaledContact, past: Past, quadrature: Quadrature, work: Scratch, tolerance: float, recovery: Recovery
) -> int:
    """Cut q of the shrinking contact under a prescribed force into elements, without their memory.

    Returns the number of elements, or -1 without room.
    """
    starts, lengths, q = recovery.starts, recovery.lengths, recovery.q
    room = starts.shape[0]
    m = contact.values.shape[0]
    r = 0
    e, t1 = past.total - 1, past.turning
    for i in range(past.first, m):
        b = max(contact.knots[i], past.turning)
        stop = contact.knots[i + 1]
        h = stop - b
        while b < stop:
            if r == room:
                return -1
            h = length_within(h, stop - b)
            e_next, t1_next = e, t1
            for j in range(TERMS):
                t = b + 0.5 * h * (1.0 + quadrature.nodes[j])
                e_next, t1_next, value = _load_at(contact, past, work, i, t, e_next, t1_next)
                work.samples[0, j] = value
            expand(quadrature, work.samples[0], q[r])
            # A fast mode may relax between a kink and the first node, which only the values at the ends show.
            _, _, first = _load_at(contact, past, work, i, b, e, t1)
            t = stop if h == stop - b else b + h
            _, _, last = _load_at(contact, past, work, i, t, e_next, t1_next)
            for n in range(TERMS):
                first -= q[r, n] if n % 2 == 0 else -q[r, n]
                last -= q[r, n]
            truncation = max(truncation_error(q[r]), abs(first), abs(last))
            # The times are rounded, and the values of a steep q scatter by that.
            allowed = tolerance * max(1.0, contact.shortest / h) + TIME_ROUNDING * b / h * variation(work.samples[0])
            # Shorter elements have no distinct nodes.
            if truncation > allowed and h > SHORTEST_ELEMENT * b:
                h *= 0.5
                continue
            starts[r], lengths[r] = b, h
            b = stop if h == stop - b else b + h
            e, t1 = e_next, t1_next
            r += 1
            h *= 2.0
    return r


@inlined
def _load_after_contact(contact: ScaledContact, past: Past, t: float) -> tuple[float, float]:
    """Load q at time t after the contact, and its rate."""
    q = -contact.equilibrium * past.elements.depths[past.total]
    rate = 0.0
    for k in range(contact.moduli.shape[0]):
        left = contact.moduli[k] * math.exp(-(t - past.turning) * contact.rates[k])
        left *= past.depth.begin[past.total, k]
        q -= left
        rate += contact.rates[k] * left
    return q, rate


@inlined
def _load_before(
    contact: ScaledContact, past: Past, work: Scratch, t: float, e: int, t1: float, depth: float
) -> tuple[float, float]:
    """Load at time t from before t1 in element e, E d1 + sum E_k X_k H_k; and the rate at which the modes lose it."""
    load, fading = remaining(contact, past, work, past.depth, t, e, t1, depth - past.elements.depths[e])
    return contact.equilibrium * depth + load, fading


@compiled
def _load_since_turning(
    contact: ScaledContact, past: Past, work: Scratch, t: float, force: float, e: int, t1: float
) -> tuple[int, float, float]:
    """Element and instant t1 of equal contact, and q, at time t under this force; the search starts at t1 in e."""
    q, _ = _load_after_contact(contact, past, t)
    # Without force d1 = H_k(t1) = 0.
    if force > 0.0:
        equal = equal_contact(contact, past, work, t, force, e, t1)
        e, t1 = equal.element, equal.time
        q += _load_before(contact, past, work, t, e, t1, equal.depth)[0]
    return e, t1, q


@compiled
def _load_at(
    contact: ScaledContact, past: Past, work: Scratch, i: int, t: float, e: int, t1: float
) -> tuple[int, float, float]:
    """Return the element and instant of equal contact, and q, at time t in segment i under the prescribed force."""
    force = prescribed(contact, i, t)[0] if t < past.end else 0.0
    return _load_since_turning(contact, past, work, t, force, e, t1)


@compiled
def _creep(
    contact: ScaledContact, past: Past, recovery: Recovery, work: Scratch, r: int, t: float
) -> tuple[float, float]:
    """Return the depth by creep alone at time t in element r of the recovery, and its rate."""
    elapsed = t - recovery.starts[r]
    legendre_values(2.0 * elapsed / recovery.lengths[r] - 1.0, work.basis)
    legendre_slopes(recovery.lengths[r], work.basis, work.slopes)
    depth = past.elements.depths[past.total]
    rate = 0.0
    for j in range(contact.compliances.shape[0]):
        depth += contact.compliances[j] * recall(recovery.level, r, j, elapsed, work.basis)
        rate += contact.compliances[j] * recall_rate(recovery.level, r, j, elapsed, work.slopes)
    return depth, rate


@entry_point
def sample(contact: ScaledContact, past: Past, recovery: Recovery, work: Scratch, times: Any, columns: Any) -> None:
    """Write depth, its rate, force, stiffness radius and s of the approach with that radius at ascending times.

    At the time of a jump they are those behind it.
    """
    m = contact.values.shape[0]
    by_depth = contact.control == DEPTH
    punch = contact.path.exponent == 0.0
    i, e, r = 0, 0, 0
    place, t1 = past.total - 1, past.turning
    before, t1_rate = past.turning, 0.0
    for n in range(times.shape[0]):
        t = times[n]
        while i + 1 < m and t >= contact.knots[i + 1]:
            i += 1
        value, rate, _ = prescribed(contact, i, t)
        depth, force, s1 = value, 0.0, 0.0
        depth_1, growth = 0.0, 0.0
        # The contact radius never changes: the equations of the growing contact hold throughout.
        if punch:
            if by_depth:
                force = innermost_load(contact, past, work, i, t)[0]
            else:
                force = value
                depth, rate, _, _ = growing_contact(contact, work, i, t)
        elif t < past.turning or past.first == m:
            depth, rate, integral, integral_rate = growing_contact(contact, work, i, t)
            s1 = math.sqrt(max(depth, 0.0))
            force = value
            if by_depth:
                while e + 1 < past.total and t >= past.elements.starts[e + 1]:
                    e += 1
                force = contact.equilibrium * integral + contact.viscosity * integral_rate
                force += remaining(contact, past, work, past.integral, t, e, t, 0.0)[0]
        else:
            if t < past.end:
                guess = t1 + t1_rate * (t - before)
                now = shrinking_contact(contact, past, work, i, t, place, guess)
                place, t1, depth_1 = now.equal.element, now.equal.time, now.equal.depth
                force, growth, slope = now.force, now.growth, now.equal.slope
                before = t
                # dt1/dt, which predicts t1 of the next time.
                t1_rate = growth / slope if slope > 0.0 and growth < 0.0 else 0.0
                s1 = math.sqrt(max(depth_1, 0.0))
            if not by_depth:
                while r + 1 < recovery.starts.shape[0] and t >= recovery.starts[r + 1]:
                    r += 1
                depth, rate = _creep(contact, past, recovery, work, r, t)
                q, q_rate = _load_after_contact(contact, past, t)
                if t < past.end:
                    before_t1, fading = _load_before(contact, past, work, t, place, t1, depth_1)
                    q += before_t1
                    a = radius_and_integral(contact.path, s1)[0]
                    # d/dt of E d1 + sum E_k X_k H_k: phi d1' = (phi Pi1')/a, less what the modes lose.
                    q_rate += growth / a - fading if a > 0.0 else 0.0
                depth += contact.glass * q
                rate += contact.glass * q_rate
        columns[0, n] = depth
        columns[1, n] = rate
        separated = t >= past.end
        columns[2, n] = 0.0 if separated else force
        columns[3, n] = 0.0 if separated else radius_and_integral(contact.path, s1)[0]
        columns[4, n] = s1


@inlined
def _through_growing_jump(
    contact: ScaledContact, past: Past, i: int, load: float, glass: float, fractions: Any, columns: Any
) -> None:
    """Write depth and force in a jump of the growing contact; `load` is the load of the spring before it."""
    by_depth = contact.control == DEPTH
    start, jump = contact.values[i, 0], contact.values[i, 1]
    e = 0
    depth, integral, force = 0.0, 0.0, 0.0
    if contact.path.exponent == 0.0:
        for k in range(contact.moduli.shape[0]):
            load += contact.moduli[k] * (past.depth.begin[i, k] if by_depth else 0.0)
        integral = start
        if not by_depth:
            integral = contact.glass * start
            for j in range(contact.compliances.shape[0]):
                integral += contact.compliances[j] * contact.level.begin[i, j]
        force = load
    else:
        while past.elements.segments[e] != i:
            e += 1
        integral = past.elements.integrals[e]
        force = contact.equilibrium * integral
        for k in range(contact.moduli.shape[0]):
            force += contact.moduli[k] * past.integral.begin[e, k]
    for n in range(fractions.shape[0]):
        if by_depth:
            depth = start + fractions[n] * jump
            now = radius_and_integral(contact.path, math.sqrt(max(depth, 0.0)))[1]
            columns[0, n], columns[1, n] = depth, max(force + glass * (now - integral), 0.0)
        else:
            now = integral + contact.glass * fractions[n] * jump
            columns[0, n] = root_of_depth(contact.path, now) ** 2
            columns[1, n] = start + fractions[n] * jump


@entry_point
def through_jump(
    contact: ScaledContact, past: Past, recovery: Recovery, work: Scratch, i: int, fractions: Any, columns: Any
) -> None:
    """Write depth and force at ascending shares in [0, 1] of the jump that is segment i."""
    K = contact.moduli.shape[0]
    by_depth = contact.control == DEPTH
    t = contact.knots[i]
    start, jump = contact.values[i, 0], contact.values[i, 1]
    glass = contact.equilibrium
    load = contact.equilibrium * start
    for k in range(K):
        glass += contact.moduli[k]
    place, t1 = past.total - 1, past.turning
    if contact.path.exponent == 0.0 or i < past.first:
        _through_growing_jump(contact, past, i, load, glass, fractions, columns)
        return
    if by_depth:
        for k in range(K):
            load += contact.moduli[k] * past.depth.begin[past.total + i - past.first, k]
        for n in range(fractions.shape[0]):
            target = load + glass * fractions[n] * jump
            equal = equal_contact(contact, past, work, t, target, place, t1)
            place, t1 = equal.element, equal.time
            step = equal.integral - past.elements.integrals[place]
            left, _ = remaining(contact, past, work, past.integral, t, place, t1, step)
            columns[0, n] = start + fractions[n] * jump
            columns[1, n] = contact.equilibrium * equal.integral + left if target > 0.0 else 0.0
        return
    r = 0
    while r + 1 < recovery.starts.shape[0] and t >= recovery.starts[r + 1]:
        r += 1
    creep = _creep(contact, past, recovery, work, r, t)[0]
    for n in range(fractions.shape[0]):
        force = start + fractions[n] * jump
        place, t1, q = _load_since_turning(contact, past, work, t, force, place, t1)
        columns[0, n] = creep + contact.glass * q
        columns[1, n] = force


# Many indentations under prescribed depths, one after another: a material, a history and a contact point each.

# Share of the tolerance for the elements, as errors of the past add up.
ELEMENT_SHARE = 0.05
# Range of depths, radii and forces: their squares must be normal numbers.
SMALLEST, LARGEST = 1e-150, 1e150
