"""The contact under a prescribed history at given times: growing, shrinking, and after it.

Under a prescribed depth the force follows from the past. Under a prescribed force the depth of the shrinking contact does,
by creep: d - d_m = int J(t - t') dphi(t') with

    phi(t) = E d1 + sum E_k X_k H_k(t1) - (the same for t1 = t_m),

which is cut into elements as the rates of the growing contact are.
"""

import math
from typing import Any, NamedTuple

from restitution.kernel.compile import compiled, entry_point, inlined
from restitution.kernel.growing import grown, root_of_depth
from restitution.kernel.memory import (
    TERMS,
    Memory,
    Quadrature,
    legendre_slopes,
    legendre_values,
    recall,
    recall_rate,
)
from restitution.kernel.path import radius_and_integral
from restitution.kernel.prescribed import DEPTH, Contact, Scratch, prescribed, tail
from restitution.kernel.shrinking import Past, center, equal_contact, remaining, shrunk


class Recovery(NamedTuple):
    """Depth of the shrinking contact under a prescribed force: phi over elements, and its memory.

    Attributes
    ----------
    starts, lengths : ndarray, shape (E,)
    phi : ndarray, shape (E, TERMS)
        Legendre coefficients.
    level : Memory
        Memory of phi at the rates `recoveries`.
    """

    starts: Any
    lengths: Any
    phi: Any
    level: Memory


@entry_point
def recover(
    contact: Contact,
    past: Past,
    quadrature: Quadrature,
    work: Scratch,
    tolerance: float,
    starts: Any,
    lengths: Any,
    phi: Any,
) -> int:
    """Cut phi of the shrinking contact under a prescribed force into elements; returns their number, -1 without room."""
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
            h = min(h, stop - b)
            if h > 0.75 * (stop - b):
                h = stop - b
            e_next, t1_next = e, t1
            least, most = math.inf, -math.inf
            for j in range(TERMS):
                t = b + 0.5 * h * (1.0 + quadrature.nodes[j])
                force = prescribed(contact, i, t)[0] if t < past.end else 0.0
                e_next, t1_next, value = _phi(contact, past, work, t, force, e_next, t1_next)
                work.samples[0, j] = value
                least, most = min(least, value), max(most, value)
            for n in range(TERMS):
                total = 0.0
                for j in range(TERMS):
                    total += quadrature.coefficients[n, j] * work.samples[0, j]
                phi[r, n] = total
            # What the nodes have missed shows at the ends: a fast mode answers to a kink before the first of them.
            force = prescribed(contact, i, b)[0] if b < past.end else 0.0
            _, _, first = _phi(contact, past, work, b, force, e, t1)
            t = stop if h == stop - b else b + h
            force = prescribed(contact, i, t)[0] if t < past.end else 0.0
            _, _, last = _phi(contact, past, work, t, force, e_next, t1_next)
            for n in range(TERMS):
                first -= phi[r, n] if n % 2 == 0 else -phi[r, n]
                last -= phi[r, n]
            missing = max(tail(phi[r]), abs(first), abs(last))
            # The times themselves are rounded: a steep phi cannot be smoother than that.
            allowed = tolerance * max(1.0, contact.shortest / h) + 1e-15 * b / h * (most - least)
            if missing > allowed and h > 1e-14 * b:
                h *= 0.5
                continue
            starts[r], lengths[r] = b, h
            b = stop if h == stop - b else b + h
            e, t1 = e_next, t1_next
            r += 1
            h *= 2.0
    return r


@inlined
def _lost(contact: Contact, past: Past, t: float) -> tuple[float, float]:
    """Phi at time t if the contact were over, and its rate."""
    phi = -contact.equilibrium * past.elements.depths[past.total]
    rate = 0.0
    for k in range(contact.moduli.shape[0]):
        left = contact.moduli[k] * math.exp(-(t - past.turning) * contact.rates[k])
        left *= past.depth.begin[past.total, k]
        phi -= left
        rate += contact.rates[k] * left
    return phi, rate


@compiled
def _phi(
    contact: Contact, past: Past, work: Scratch, t: float, force: float, e: int, t1: float
) -> tuple[int, float, float]:
    """Element and instant of equal contact, from which to start too, and phi, at time t under this force."""
    phi, _ = _lost(contact, past, t)
    if force > 0.0:
        e, t1, depth, _, _, _ = equal_contact(contact, past, work, t, force, e, t1)
        by = depth - past.elements.depths[e]
        phi += contact.equilibrium * depth + remaining(contact, past, work, past.depth, t, e, t1, by)[0]
    return e, t1, phi


@compiled
def _crept(
    contact: Contact, past: Past, recovery: Recovery, work: Scratch, r: int, t: float
) -> tuple[float, float]:
    """Part of the depth at time t in element r of the recovery that is due to creep, and its rate."""
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
def sample(contact: Contact, past: Past, recovery: Recovery, work: Scratch, times: Any, columns: Any) -> None:
    """Sample the contact at ascending times; at a jump, what is behind it.

    Parameters
    ----------
    contact, past, recovery, work
        What `restitution.indentation` has put together.
    times : ndarray, shape (n,)
        From 0 to the end of the history.
    columns : ndarray, shape (4, n)
        Written: depth, its rate, force, contact radius.
    """
    m = contact.values.shape[0]
    by_depth = contact.control == DEPTH
    punch = contact.path.exponent == 0.0
    i = 0
    e = 0
    r = 0
    place, t1 = past.total - 1, past.turning
    before, t1_rate = past.turning, 0.0
    for n in range(times.shape[0]):
        t = times[n]
        while i + 1 < m and t >= contact.knots[i + 1]:
            i += 1
        value, rate, _ = prescribed(contact, i, t)
        depth, force, s1 = value, 0.0, 0.0
        depth_1, growth = 0.0, 0.0
        if punch:
            if by_depth:
                force = center(contact, past, work, i, t)[0]
            else:
                force = value
                depth, rate, _, _ = grown(contact, work, i, t)
        elif t < past.turning or past.first == m:
            depth, rate, integral, integral_rate = grown(contact, work, i, t)
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
                place, t1, depth_1, force, growth, _, slope = shrunk(contact, past, work, i, t, place, guess)
                before = t
                t1_rate = growth / slope if slope > 0.0 and growth < 0.0 else 0.0
                s1 = math.sqrt(max(depth_1, 0.0))
            if not by_depth:
                phi, phi_rate = _lost(contact, past, t)
                if t < past.end:
                    by = depth_1 - past.elements.depths[place]
                    load, fading = remaining(contact, past, work, past.depth, t, place, t1, by)
                    phi += contact.equilibrium * depth_1 + load
                    a = radius_and_integral(contact.path, s1)[0]
                    phi_rate += growth / a - fading if a > 0.0 else 0.0
                while r + 1 < recovery.starts.shape[0] and t >= recovery.starts[r + 1]:
                    r += 1
                depth, rate = _crept(contact, past, recovery, work, r, t)
                depth += contact.glass * phi
                rate += contact.glass * phi_rate
        columns[0, n] = depth
        columns[1, n] = rate
        open_ = t >= past.end
        columns[2, n] = 0.0 if open_ else force
        columns[3, n] = 0.0 if open_ else radius_and_integral(contact.path, s1)[0]


@entry_point
def through_jump(
    contact: Contact, past: Past, recovery: Recovery, work: Scratch, i: int, shares: Any, columns: Any
) -> None:
    """Follow depth and force through the jump of segment i.

    Parameters
    ----------
    contact, past, recovery, work
        As for `sample`.
    i : int
        Segment of length 0.
    shares : ndarray, shape (n,)
        Shares of the jump, ascending in [0, 1].
    columns : ndarray, shape (2, n)
        Written: depth and force.
    """
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
        e = 0
        depth, integral, force = 0.0, 0.0, 0.0
        if contact.path.exponent == 0.0:
            for k in range(K):
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
            for k in range(K):
                force += contact.moduli[k] * past.integral.begin[e, k]
        for n in range(shares.shape[0]):
            if by_depth:
                depth = start + shares[n] * jump
                now = radius_and_integral(contact.path, math.sqrt(max(depth, 0.0)))[1]
                columns[0, n], columns[1, n] = depth, max(force + glass * (now - integral), 0.0)
            else:
                now = integral + contact.glass * shares[n] * jump
                columns[0, n] = root_of_depth(contact.path, now) ** 2
                columns[1, n] = start + shares[n] * jump
        return
    if by_depth:
        for k in range(K):
            load += contact.moduli[k] * past.depth.begin[past.total + i - past.first, k]
        for n in range(shares.shape[0]):
            target = load + glass * shares[n] * jump
            place, t1, _, integral, _, _ = equal_contact(contact, past, work, t, target, place, t1)
            by = integral - past.elements.integrals[place]
            left, _ = remaining(contact, past, work, past.integral, t, place, t1, by)
            columns[0, n] = start + shares[n] * jump
            columns[1, n] = contact.equilibrium * integral + left if target > 0.0 else 0.0
        return
    r = 0
    while r + 1 < recovery.starts.shape[0] and t >= recovery.starts[r + 1]:
        r += 1
    crept = _crept(contact, past, recovery, work, r, t)[0]
    for n in range(shares.shape[0]):
        force = start + shares[n] * jump
        place, t1, phi = _phi(contact, past, work, t, force, place, t1)
        columns[0, n] = crept + contact.glass * phi
        columns[1, n] = force
