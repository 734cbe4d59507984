"""Elements of the rim of a steady oscillation: when each leaves and touches, once a period.

In units of the period and of the amplitude an element has the displacement `u = c + sin(2 pi t)`, with its offset
c = (mean - s)/amplitude. Its state repeats after a period. Given the times of leaving and of the touch before, the
periodic state is linear in the loads; both times are where the load vanishes and where the gap closes.

What a period changes of a slow part w_j is small. It is written by integrals, which have all digits:

    w_j' = -sum_k L_jk rho_k l_k + c_j eta u'   in contact,   L_jk = c_j/(r_j - rho_k),   w_j' = -r_j w_j   in flight.
"""

import math
from typing import Any, NamedTuple

from restitution.kernel.compile import compiled, entry_point, inlined
from restitution.kernel.elimination import solve_linear
from restitution.kernel.panels import Solid
from restitution.kernel.record import Solids, solid_at
from restitution.kernel.references import by_reference

# Periods that are followed before each try of Newton's method, such tries, and iterations of one.
_FOLLOWED, _TRIES, _NEWTON, _HALVINGS = 4, 10, 40, 40
# Refinements of the way from an element to the next one, each into four times as many steps.
_REFINEMENTS = 4
# Step of derivatives, change of times and residual at which Newton's method ends, and violation of a sign.
_STEP, _SMALL, _SOLVED, _ALLOWED = 1e-7, 1e-11, 1e-10, 1e-7
# Rounding of loads and gaps over their scales, and the shortest contact and the shortest flight of a solution.
_BLUR, _SHORTEST = 1e-13, 1e-7
_CHECKS = 48
# Real and imaginary part of the stiffness that follows for ever, over the amplitude; the scale of loads.
RE, IM, SCALE = range(3)


@by_reference
class Room(NamedTuple):
    """Arrays for one element."""

    stiffness: Any  # (3,)
    driven: Any  # (2, K): complex loads of branches that follow for ever
    parts: Any  # (J,): w_j at the touch
    excess: Any  # (K,): loads at the touch less those of `driven`
    loads: Any  # (K,)
    decay: Any  # (K,)
    matrix: Any  # (J, J + 1)
    times: Any  # (2,): leaving, touching


@inlined
def _drive(work: Room, k: int, t: float) -> float:
    angle = 2.0 * math.pi * t
    return work.driven[0, k] * math.sin(angle) + work.driven[1, k] * math.cos(angle)


@compiled
def _load(solid: Solid, work: Room, offset: float, t: float, touching: float) -> float:
    """Load at a time after the touch."""
    angle = 2.0 * math.pi * t
    q = solid.equilibrium * offset + work.stiffness[RE] * math.sin(angle) + work.stiffness[IM] * math.cos(angle)
    for k in range(solid.rates.shape[0]):
        q += math.exp(-solid.rates[k] * (t - touching)) * work.excess[k]
    return q


@compiled
def _gap(solid: Solid, work: Room, offset: float, t: float, leaving: float) -> float:
    """Gap at a time after leaving; `parts` are those of the displacement at leaving."""
    value = -offset - math.sin(2.0 * math.pi * t)
    for j in range(solid.recoveries.shape[0]):
        value += math.exp(-solid.recoveries[j] * (t - leaving)) * work.parts[j]
    return value


@inlined
def _touch(solid: Solid, work: Room, touching: float) -> None:
    """Write the excess of the loads from the parts of the displacement at the touch."""
    for k in range(solid.rates.shape[0]):
        value = -_drive(work, k, touching)
        for j in range(solid.recoveries.shape[0]):
            value += solid.moduli_of[k, j] * work.parts[j]
        work.excess[k] = value


@inlined
def _leave(solid: Solid, work: Room, offset: float, leaving: float, touching: float) -> None:
    """Write the parts of the displacement at leaving from the excess of the loads at the touch."""
    for k in range(solid.rates.shape[0]):
        fading = math.exp(-solid.rates[k] * (leaving - touching))
        work.loads[k] = _drive(work, k, leaving) + fading * work.excess[k]
    u = offset + math.sin(2.0 * math.pi * leaving)
    for j in range(solid.recoveries.shape[0]):
        value = solid.displacement[j] * u
        for k in range(solid.rates.shape[0]):
            value += solid.loads[j, k] * work.loads[k]
        work.parts[j] = value


@compiled
def _first_below(solid: Solid, work: Room, offset: float, start: float, is_load: bool, shares: Any) -> float:
    """First time within a period at which the load, or the gap, falls below zero; else that of its least value."""
    blur = _BLUR * (work.stiffness[SCALE] if is_load else 1.0 + abs(offset))
    above, last, least, lowest = False, start, start, math.inf
    for n in range(shares.shape[0]):
        t = start + shares[n]
        value = _load(solid, work, offset, t, start) if is_load else _gap(solid, work, offset, t, start)
        if value < lowest:
            lowest, least = value, t
        if above and value < -blur:
            low, high = last, t
            for _ in range(_HALVINGS):
                middle = 0.5 * (low + high)
                value = (
                    _load(solid, work, offset, middle, start) if is_load else _gap(solid, work, offset, middle, start)
                )
                if value < 0.0:
                    high = middle
                else:
                    low = middle
            return high
        above = above or value > blur
        last = t
    return least


@inlined
def _dashpot(solid: Solid, j: int) -> float:
    """Return c_j eta, the share of a change of the displacement in contact in a part."""
    if solid.viscosity == 0.0:
        return 0.0
    if solid.rates.shape[0] == 0:
        return solid.displacement[j]
    far = 0
    for k in range(solid.rates.shape[0]):
        if abs(solid.recoveries[j] - solid.rates[k]) > abs(solid.recoveries[j] - solid.rates[far]):
            far = k
    return solid.viscosity * solid.loads[j, far] * (solid.recoveries[j] - solid.rates[far])


@compiled
def _periodic(solid: Solid, work: Room, offset: float, leaving: float, touching: float) -> None:
    """Write the parts of the displacement at the touch that repeat after a period, and the excess of the loads."""
    K, J, matrix = solid.rates.shape[0], solid.recoveries.shape[0], work.matrix
    contact, flight = leaving - touching, touching + 1.0 - leaving
    # Integrals of the sine and of the cosine over the contact.
    both, half = math.pi * (leaving + touching), math.sin(math.pi * contact) / math.pi
    sine, cosine = math.sin(both) * half, math.cos(both) * half
    moved = 2.0 * math.pi * cosine
    for k in range(K):
        # Share of the excess that relaxes in contact, and what relaxes if there is none at the touch.
        work.decay[k] = -math.expm1(-solid.rates[k] * contact)
        held = work.driven[0, k] * sine + work.driven[1, k] * cosine
        work.loads[k] = solid.rates[k] * held - work.decay[k] * _drive(work, k, touching)
    for j in range(J):
        recovery = math.exp(-solid.recoveries[j] * flight)
        change = _dashpot(solid, j) * moved
        for k in range(K):
            change -= solid.loads[j, k] * work.loads[k]
        matrix[j, J] = recovery * change
        largest = 0.0
        for i in range(J):
            value = 0.0
            for k in range(K):
                value += solid.loads[j, k] * work.decay[k] * solid.moduli_of[k, i]
            own = -math.expm1(-solid.recoveries[j] * flight) if i == j else 0.0
            matrix[j, i] = own + recovery * value
            largest = max(largest, abs(matrix[j, i]))
        # Slow parts have small rows.
        for i in range(J + 1 if largest > 0.0 else 0):
            matrix[j, i] /= largest
    is_solved = solve_linear(matrix, J)
    for j in range(J):
        work.parts[j] = matrix[j, J] if is_solved else math.nan
    _touch(solid, work, touching)


@compiled
def _residuals(solid: Solid, work: Room, offset: float, leaving: float, touching: float) -> tuple[float, float]:
    """Load at leaving and gap at the touch of the periodic state, over their scales."""
    _periodic(solid, work, offset, leaving, touching)
    gap = -offset - math.sin(2.0 * math.pi * touching)
    for j in range(solid.recoveries.shape[0]):
        gap += work.parts[j]
    return _load(solid, work, offset, leaving, touching) / work.stiffness[SCALE], gap


@compiled
def _newton(solid: Solid, work: Room, offset: float) -> float:
    """Move `times` to the periodic state by Newton's method; return the residual, infinite without a solution."""
    leaving, touching = work.times[0], work.times[1]
    for _ in range(_NEWTON):
        p, q = _residuals(solid, work, offset, leaving, touching)
        a, c = _residuals(solid, work, offset, leaving + _STEP, touching)
        e, f = _residuals(solid, work, offset, leaving - _STEP, touching)
        b, d = _residuals(solid, work, offset, leaving, touching + _STEP)
        g, h = _residuals(solid, work, offset, leaving, touching - _STEP)
        a, c, b, d = (a - e) / (2.0 * _STEP), (c - f) / (2.0 * _STEP), (b - g) / (2.0 * _STEP), (d - h) / (2.0 * _STEP)
        determinant = a * d - b * c
        if determinant == 0.0 or math.isnan(determinant):
            return math.inf
        first, second = (d * p - b * q) / determinant, (a * q - c * p) / determinant
        # Neither phase may vanish.
        most = 0.5 * min(leaving - touching, touching + 1.0 - leaving)
        leaving -= min(max(first, -most), most)
        touching -= min(max(second, -most), most)
        if max(abs(first), abs(second)) < _SMALL:
            break
    length = leaving - touching
    if not _SHORTEST < length < 1.0 - _SHORTEST:
        return math.inf
    p, q = _residuals(solid, work, offset, leaving, touching)
    work.times[0], work.times[1] = leaving, touching
    return max(abs(p), abs(q))


@compiled
def _violation(solid: Solid, work: Room, offset: float) -> float:
    """Largest pull in contact and largest overlap in flight of the periodic state, over their scales."""
    leaving, touching = work.times[0], work.times[1]
    _periodic(solid, work, offset, leaving, touching)
    worst = 0.0
    for n in range(_CHECKS):
        t = touching + (leaving - touching) * (n + 0.5) / _CHECKS
        worst = max(worst, -_load(solid, work, offset, t, touching) / work.stiffness[SCALE])
    _leave(solid, work, offset, leaving, touching)
    for n in range(_CHECKS):
        t = leaving + (touching + 1.0 - leaving) * (n + 0.5) / _CHECKS
        worst = max(worst, -_gap(solid, work, offset, t, leaving))
    return worst


@compiled
def _solved(solid: Solid, work: Room, offset: float) -> bool:
    """Move `times` to a periodic state whose loads and gaps are not negative; return whether there is one."""
    return _newton(solid, work, offset) <= _SOLVED and _violation(solid, work, offset) <= _ALLOWED


@compiled
def _continued(solid: Solid, work: Room, before: float, offset: float) -> bool:
    """Move `times` from the periodic state of another offset; return whether it is reached."""
    leaving, touching = work.times[0], work.times[1]
    steps = 1
    for _ in range(_REFINEMENTS):
        work.times[0], work.times[1] = leaving, touching
        done = True
        for n in range(steps):
            if not _solved(solid, work, before + (offset - before) * (n + 1.0) / steps):
                done = False
                break
        if done:
            return True
        steps *= 4
    return False


@compiled
def _followed(solid: Solid, work: Room, offset: float, shares: Any) -> float:
    """Move `times` to the periodic state from a virgin surface, period by period; return the residual."""
    touching = math.asin(min(max(-offset, -1.0), 1.0)) / (2.0 * math.pi)
    leaving = touching
    for j in range(solid.recoveries.shape[0]):
        work.parts[j] = 0.0
    for _ in range(_TRIES):
        for _ in range(_FOLLOWED):
            _touch(solid, work, touching)
            leaving = _first_below(solid, work, offset, touching, True, shares)
            _leave(solid, work, offset, leaving, touching)
            touching = _first_below(solid, work, offset, leaving, False, shares) - 1.0
            _periodic(solid, work, offset, leaving, touching)
        work.times[0], work.times[1] = leaving, touching
        if _solved(solid, work, offset):
            return 0.0
        _periodic(solid, work, offset, leaving, touching)
    # Newton's method may leave for a contact, or a flight, without a length; then the iterates are kept.
    work.times[0], work.times[1] = leaving, touching
    violation = _violation(solid, work, offset)
    p, q = _residuals(solid, work, offset, leaving, touching)
    # Loads of a short phase are small in proportion to it, and so is what its times contribute.
    length = leaving - touching
    short = min(max(min(length, 1.0 - length), 0.0), 1.0)
    return max(max(abs(p), abs(q)) * short, violation * min(max(length, 0.0), 1.0))


@entry_point
def settle_rims(
    solids: Solids, offsets: Any, shares: Any, work: Room, times: Any, excess: Any, residuals: Any
) -> None:
    """Write the times of leaving and touching (n, m, 2) of elements, their loads (n, m, K), and residuals (n,).

    The elements of a row begin at the edge.
    """
    K = solids.rates.shape[1]
    for i in range(offsets.shape[0]):
        solid = solid_at(solids, i)
        omega = 2.0 * math.pi
        work.stiffness[RE], work.stiffness[IM] = solid.equilibrium, omega * solid.viscosity
        for k in range(K):
            # E i w/(i w + rho)
            factor = solid.moduli[k] * omega / (omega * omega + solid.rates[k] * solid.rates[k])
            work.driven[0, k], work.driven[1, k] = factor * omega, factor * solid.rates[k]
            work.stiffness[RE] += work.driven[0, k]
            work.stiffness[IM] += work.driven[1, k]
        work.stiffness[SCALE] = math.hypot(work.stiffness[RE], work.stiffness[IM])
        residuals[i] = 0.0
        solved = False
        for m in range(offsets.shape[1]):
            # The state changes little from an element to the next one.
            if solids.recoveries.shape[1] == 0:
                # The surface of an elastic body is that of the indenter, or flat.
                work.times[1] = math.asin(min(max(-offsets[i, m], -1.0), 1.0)) / (2.0 * math.pi)
                work.times[0] = 0.5 - work.times[1]
            elif not (solved and _continued(solid, work, offsets[i, m - 1], offsets[i, m])):
                residual = _followed(solid, work, offsets[i, m], shares)
                solved = residual == 0.0
                if not residual <= residuals[i]:
                    residuals[i] = residual
            times[i, m, 0], times[i, m, 1] = work.times[0], work.times[1]
            _periodic(solid, work, offsets[i, m], work.times[0], work.times[1])
            for k in range(K):
                excess[i, m, k] = work.excess[k]
