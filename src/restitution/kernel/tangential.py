"""Tangential half of an oblique impact: elements that stick or slip, on the stored normal solution.

Element i, touched at t_i, carries the tangential load `q = Ginf u + eta u' + sum p_k` with its displacement u and
`p_k' = -p_k/tau_k + G_k u'`. It follows the body, `u' = v`, as long as `abs(q) <= mu q_z`; else q is that limit, and u
follows from q: displacements of the surface, not of the body, drive the memory. The body obeys `v' = -mobility F` with
`F = int q dx`. All is scaled as the normal impact.

There are N equal steps in sigma and N in lambda: element i is touched at step i and leaves at step 2N - i. A step has
one unknown, the way Du of the body. The force is piecewise linear in it and rises, so that Newton's method ends after
few steps. The scheme is of second order, also for relaxation times far below the step: the surface velocity is linear
over two steps, and the first step of each element is divided.
"""

import math
from typing import Any, NamedTuple

import numpy as np

from restitution.kernel.compile import compiled, entry_point, inlined

# Rows of `nodes`: displacement, its rate in the last step, load, load without a displacement in this step, limit of
# the load, displacement of this step, weight of the quadrature over x, two rows of terms of a sum.
U_, RATE_, LOAD_, TRIAL_, LIMIT_, MOVED_, WEIGHT_, FIRST_TERMS_, SECOND_TERMS_, N_NODES = range(10)
# Columns of `factors` of a mode: decay over the step, 1 - decay, load of a constant rate and of a change of the rate.
DECAY_, LOSS_, STEADY_, CHANGE_, N_FACTORS = range(5)
# Members of `sums`: energies lost by friction, dissipated in the material, and stored in elements when they leave;
# impulse; time in which elements slip within the radius that sticks; whether any element ever stuck.
FRICTION_, VISCOUS_, STORED_, IMPULSE_, GAPS_, STUCK_, N_SUMS = range(7)
# Columns of `motion`: velocity of the contact point, force, radius that sticks, largest velocity of slip.
V_, F_, STICK_, SLIP_, N_MOTION = range(5)
# Members of `touch`: load of an element after its first step, mean load of the ages up to it, displacement, energies
# lost by friction and in the material.
FIRST_, MEAN_, WAY_, RUBBED_, SPENT_, N_TOUCH = range(6)

# Parts of the first step of an element: the first over the shortest time, its least size over the step, growth, the
# longest over the step.
_FIRST_PART, _LEAST_PART, _GROWTH, _LONGEST_PART = 0.25, 2e-6, 1.3, 0.125
# Parts of the last step of an element.
_LAST_PARTS = 16
_MAX_ITERATIONS = 60
_ROUNDING = 1e-14
# Load over its limit up to which the youngest element counts as stuck.
_STUCK = 0.999
# Share of the elements that may slip within the radius that sticks without being counted.
_GAP = 0.02


class Modes(NamedTuple):
    """Scaled relaxation of the line load in one direction."""

    equilibrium: float
    viscosity: float
    moduli: Any
    times: Any


class Normal(NamedTuple):
    """Normal solution at the 2N + 1 times of the steps, and the places of the N + 1 elements."""

    times: Any
    velocities: Any
    depths: Any
    memory: Any  # (K, 2N + 1): H_k
    radii: Any  # (N + 1,)
    touched: Any  # (N + 1,): depths at which the elements are touched


class Room(NamedTuple):
    """State and results of one march with N steps in each half."""

    nodes: Any  # (N_NODES, N + 1)
    tangential: Any  # (modes, N + 1): p_k
    normal: Any  # (modes, N + 1): the same of the normal load
    part: Any  # (modes,): normal loads within the first step of an element
    factors: Any  # (modes, N_FACTORS)
    touch: Any  # (N_TOUCH,)
    motion: Any  # (2N + 1, N_MOTION)
    sums: Any  # (N_SUMS,)


def allocate_room(steps: int, tangential: int, normal: int) -> Room:
    """Return room for a march."""
    return Room(
        np.zeros((N_NODES, steps + 1)), np.zeros((tangential, steps + 1)), np.zeros((normal, steps + 1)),
        np.zeros(normal), np.zeros((tangential, N_FACTORS)), np.zeros(N_TOUCH), np.zeros((2 * steps + 1, N_MOTION)),
        np.zeros(N_SUMS),
    )  # fmt: skip


@compiled
def _set_factors(modes: Modes, dt: float, before: float, factors: Any) -> tuple[float, float]:
    """Write the factors of the modes over a step; return the slope of the load over the way, and over the last rate.

    A rate that is linear over this step and the one before, of length `before`, adds `J slope` to the memory of a
    mode, with `J = int_0^dt exp(-(dt - t)/tau) (t - dt/2) dt`. With `before` = 0 the rate is constant.
    """
    share = 2.0 / ((dt + before) * dt) if before > 0.0 else 0.0
    slope, lag = (
        modes.equilibrium + modes.viscosity * (1.0 / dt + 0.5 * dt * share),
        0.5 * modes.viscosity * dt * share,
    )
    for k in range(modes.times.shape[0]):
        tau = modes.times[k]
        loss = -math.expm1(-dt / tau)
        # The difference of nearly equal terms, for slow modes.
        change = tau * (dt - 0.5 * dt * loss - tau * loss) if dt > 1e-3 * tau else dt * dt * dt / (12.0 * tau)
        factors[k, DECAY_], factors[k, LOSS_] = 1.0 - loss, loss
        factors[k, STEADY_], factors[k, CHANGE_] = modes.moduli[k] * tau * loss / dt, modes.moduli[k] * change * share
        slope += factors[k, STEADY_] + factors[k, CHANGE_]
        lag += factors[k, CHANGE_]
    return slope, lag * dt


@inlined
def _dissipated(modulus: float, tau: float, loss: float, load: float, rate: float, dt: float) -> float:
    """Return the energy that a mode dissipates over a step at a constant rate, times `modulus tau`."""
    steady = modulus * tau * rate
    rest = load - steady
    return steady * steady * dt + rest * tau * loss * (2.0 * steady + 0.5 * rest * (2.0 - loss))


@inlined
def _within(load: float, limit: float) -> float:
    """Return a load between its limits."""
    return min(max(load, -limit), limit)


@compiled
def _first_step(
    solids: tuple[Modes, Modes], friction: float, node: int, dt: float, speeds: tuple[float, float, float, float],
    room: Room,
) -> None:  # fmt: skip
    """Follow an element over its first step in parts, and write `touch` and its modes.

    Fast modes, in which an element may slip before it sticks, make a layer at the edge that is thinner than the step.
    The loads of all ages are those of the elements that are touched within the step. `speeds` are those of the body
    along the surface and into it, each at the start and at the end.
    """
    tangential, normal = solids
    along, along_end, into, into_end = speeds
    shortest = dt
    for k in range(tangential.times.shape[0]):
        shortest = min(shortest, tangential.times[k])
        room.tangential[k, node] = 0.0
    for k in range(normal.times.shape[0]):
        shortest = min(shortest, normal.times[k])
        room.part[k] = 0.0
    if tangential.viscosity > 0.0 or normal.viscosity > 0.0:
        shortest = 0.0
    way, depth, age, load, rate, before = 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
    mean, rubbed, spent = 0.0, 0.0, 0.0
    part = max(_FIRST_PART * shortest, _LEAST_PART * dt)
    while age < dt:
        part = min(part, _LONGEST_PART * dt)
        if age + part > dt * (1.0 - 1e-9):
            part = dt - age
        middle = (age + 0.5 * part) / dt
        body = part * (along + middle * (along_end - along))
        slope, lag = _set_factors(tangential, part, before, room.factors)
        trial = tangential.equilibrium * way - lag * rate
        for k in range(tangential.times.shape[0]):
            trial += room.factors[k, DECAY_] * room.tangential[k, node]
        speed, pull = into + middle * (into_end - into), (into_end - into) / dt
        depth += part * speed
        limit = normal.equilibrium * depth + normal.viscosity * (speed + 0.5 * part * pull)
        for k in range(normal.times.shape[0]):
            tau = normal.times[k]
            loss = -math.expm1(-part / tau)
            room.part[k] += normal.moduli[k] * tau * loss * (speed - 0.5 * part * pull) - loss * room.part[k]
            room.part[k] += normal.moduli[k] * tau * pull * (part - tau * loss)
            limit += room.part[k]
        after = _within(trial + slope * body, friction * max(limit, 0.0))
        moved = (after - trial) / slope
        rubbed += (body - moved) * 0.5 * (load + after)
        mean += 0.5 * part * (load + after)
        spent += _advance_modes(tangential, room, node, moved, rate * part, part)
        way, load, rate, before, age = way + moved, after, moved / part, part, age + part
        part *= _GROWTH
    room.touch[FIRST_], room.touch[MEAN_], room.touch[WAY_] = load, mean / dt, way
    room.touch[RUBBED_], room.touch[SPENT_] = rubbed, spent


@compiled
def _last_step(tangential: Modes, node: int, dt: float, before: float, limit: float, body: Any, room: Room) -> None:
    """Follow an element over its last step in parts, and add its energies; its limit falls from `limit` to 0.

    The load may reach the limit only shortly before the element leaves. Its energies depend on how it drops.
    """
    nodes, sums, weight = room.nodes, room.sums, room.nodes[WEIGHT_, node]
    part, load, rate, way = dt / _LAST_PARTS, nodes[LOAD_, node], nodes[RATE_, node], nodes[U_, node]
    slope, lag = _set_factors(tangential, part, before, room.factors)
    for m in range(_LAST_PARTS):
        if m == 1:
            slope, lag = _set_factors(tangential, part, part, room.factors)
        trial = tangential.equilibrium * way - lag * rate
        for k in range(tangential.times.shape[0]):
            trial += room.factors[k, DECAY_] * room.tangential[k, node]
        going = part * (body[0] + (m + 0.5) / _LAST_PARTS * (body[1] - body[0]))
        after = _within(trial + slope * going, limit * (1.0 - (m + 1.0) / _LAST_PARTS))
        moved = (after - trial) / slope
        sums[FRICTION_] += weight * (going - moved) * 0.5 * (load + after)
        sums[VISCOUS_] += weight * _advance_modes(tangential, room, node, moved, rate * part, part)
        way, load, rate = way + moved, after, moved / part
    energy = tangential.equilibrium * way * way
    for k in range(tangential.times.shape[0]):
        energy += room.tangential[k, node] ** 2 / tangential.moduli[k]
    sums[STORED_] += 0.5 * weight * energy


@inlined
def _advance_modes(modes: Modes, room: Room, node: int, moved: float, usual: float, dt: float) -> float:
    """Advance the modes of one element by a displacement; return the energy that it dissipates."""
    spent = modes.viscosity * moved * moved / dt
    for k in range(modes.times.shape[0]):
        load, factors = room.tangential[k, node], room.factors[k]
        modulus, tau = modes.moduli[k], modes.times[k]
        spent += _dissipated(modulus, tau, factors[LOSS_], load, moved / dt, dt) / (modulus * tau)
        load = factors[DECAY_] * load + factors[STEADY_] * moved + factors[CHANGE_] * (moved - usual)
        room.tangential[k, node] = load
    return spent


@inlined
def _end_weight(ratio: float) -> float:
    """Return what the trapezoidal rule misses of a saturating mode beyond the first step, over its load there.

    The mode has the load `1 - exp(-age/tau)`, the step is `ratio` tau long.
    """
    if ratio < 1e-2:
        return (1.0 - 0.5 * ratio) / 12.0
    decay = math.exp(-min(ratio, 700.0))
    return decay * (0.5 + decay / (1.0 - decay) - 1.0 / ratio) / (1.0 - decay)


@compiled
def _set_loads(
    normal: Normal, solids: tuple[Modes, Modes], friction: float, n: int, count: int, lag: float, room: Room
) -> None:
    """Write the loads without a displacement in this step, and the limits, of the first `count` elements."""
    tangential, pressing = solids
    trials, limits, nodes = room.nodes[TRIAL_], room.nodes[LIMIT_], room.nodes
    drag, depth = pressing.viscosity * normal.velocities[n + 1], normal.depths[n + 1]
    for i in range(count):
        trials[i] = tangential.equilibrium * nodes[U_, i] - lag * nodes[RATE_, i]
        limits[i] = pressing.equilibrium * (depth - normal.touched[i]) + drag
    for k in range(tangential.times.shape[0]):
        decay, loads = room.factors[k, DECAY_], room.tangential[k]
        for i in range(count):
            trials[i] += decay * loads[i]
    dt = normal.times[n + 1] - normal.times[n]
    for k in range(pressing.times.shape[0]):
        decay, loads = math.exp(-dt / pressing.times[k]), room.normal[k]
        gain = pressing.moduli[k] * (normal.memory[k, n + 1] - decay * normal.memory[k, n])
        for i in range(count):
            loads[i] = decay * loads[i] + gain
            limits[i] += loads[i]
    for i in range(count):
        limits[i] = friction * max(limits[i], 0.0)


@compiled
def _kink(radii: Any, nodes: Any, count: int, slope: float, way: float) -> float:
    """Return what the trapezoidal rule misses of the cell in which the stick radius lies.

    There the load has a kink, and what is left up to the limit falls to zero along a line.
    """
    j, sign = count - 1, 0.0
    while j > 0:
        load = nodes[TRIAL_, j] + slope * way
        if abs(load) <= nodes[LIMIT_, j]:
            break
        sign = 1.0 if load > 0.0 else -1.0
        j -= 1
    if j < 1 or j >= count - 1:
        return 0.0
    left = nodes[LIMIT_, j] - sign * (nodes[TRIAL_, j] + slope * way)
    before = nodes[LIMIT_, j - 1] - sign * (nodes[TRIAL_, j - 1] + slope * way)
    cell = radii[j + 1] - radii[j]
    if not before > left > 0.0:
        return 0.0
    reach = left * (radii[j] - radii[j - 1]) / (before - left)
    return sign * 0.5 * left * max(cell - reach, 0.0)


@inlined
def _sum(terms: Any, count: int) -> float:
    """Return the sum of the first terms, by four sums side by side, which take a fraction of the time of one."""
    one, two, three, four = 0.0, 0.0, 0.0, 0.0
    whole = count - count % 4
    for i in range(0, whole, 4):
        one, two, three, four = one + terms[i], two + terms[i + 1], three + terms[i + 2], four + terms[i + 3]
    for i in range(whole, count):
        one += terms[i]
    return (one + three) + (two + four)


@compiled
def _way(nodes: Any, count: int, slope: float, fixed: float, free: float, pull: float, guess: float) -> Any:
    """Return the way of the body in a step, and the force at its end, by Newton's method within a bracket.

    The way is ``free - pull F``; `fixed` is the part of the force that does not depend on it.
    """
    trials, limits, weights = nodes[TRIAL_], nodes[LIMIT_], nodes[WEIGHT_]
    loads, stuck = nodes[FIRST_TERMS_], nodes[SECOND_TERMS_]
    way, low, high, force = guess, -math.inf, math.inf, fixed
    for _ in range(_MAX_ITERATIONS):
        for i in range(count):
            load = trials[i] + slope * way
            bounded = min(max(load, -limits[i]), limits[i])
            loads[i] = weights[i] * bounded
            stuck[i] = weights[i] if bounded == load else 0.0
        force, stiffness = fixed + _sum(loads, count), _sum(stuck, count)
        rest = way - free + pull * force
        if abs(rest) <= _ROUNDING * (abs(free) + pull * abs(force)):
            break
        low, high = (low, min(high, way)) if rest > 0.0 else (max(low, way), high)
        after = way - rest / (1.0 + pull * slope * stiffness)
        if not low < after < high:
            after = 0.5 * (low + high)
        if after == way:
            break
        way = after
    return way, force


@compiled
def _advance(tangential: Modes, radii: Any, count: int, slope: float, way: float, dt: float, room: Room) -> Any:
    """Advance the first `count` elements; return the stick radius and the largest velocity of slip."""
    nodes, sums = room.nodes, room.sums
    weights, moved, rates = nodes[WEIGHT_], nodes[MOVED_], nodes[RATE_]
    trials, limits, loads, terms = nodes[TRIAL_], nodes[LIMIT_], nodes[LOAD_], nodes[FIRST_TERMS_]
    inverse = 1.0 / slope
    for i in range(count):
        load = trials[i] + slope * way
        bounded = min(max(load, -limits[i]), limits[i])
        moved[i] = way if bounded == load else (bounded - trials[i]) * inverse
        terms[i] = weights[i] * (way - moved[i]) * 0.5 * (loads[i] + bounded)
        loads[i] = bounded
    lost = _sum(terms, count)
    last, stuck, fastest = -1, 0, 0.0
    for i in range(count):
        nodes[U_, i] += moved[i]
        slip = abs(way - moved[i])
        fastest = max(fastest, slip)
        if slip == 0.0:
            last, stuck = i, stuck + 1
    spent, pace = 0.0, 1.0 / dt
    for k in range(tangential.times.shape[0]):
        modulus, tau, modes = tangential.moduli[k], tangential.times[k], room.tangential[k]
        decay, loss = room.factors[k, DECAY_], room.factors[k, LOSS_]
        steady, change = room.factors[k, STEADY_], room.factors[k, CHANGE_]
        for i in range(count):
            terms[i] = weights[i] * _dissipated(modulus, tau, loss, modes[i], moved[i] * pace, dt)
            modes[i] = decay * modes[i] + steady * moved[i] + change * (moved[i] - rates[i] * dt)
        spent += _sum(terms, count) / (modulus * tau)
    for i in range(count):
        rates[i] = moved[i] * pace
        terms[i] = tangential.viscosity * weights[i] * rates[i] * moved[i]
    spent += _sum(terms, count)
    sums[FRICTION_] += lost
    sums[VISCOUS_] += spent
    sums[GAPS_] += dt if last + 1 - stuck > 1.0 + _GAP * radii.shape[0] else 0.0
    return last, fastest / dt


@compiled
def _front(normal: Normal, solids: tuple[Modes, Modes], friction: float, n: int, body: Any, room: Room) -> float:
    """Take in the element touched at step n; return the force of it and of the cell up to the edge.

    `body` are the velocities of the body along the surface at both ends of the step.
    """
    dt, nodes, touch = normal.times[n + 1] - normal.times[n], room.nodes, room.touch
    speeds = body[0], body[1], normal.velocities[n], normal.velocities[n + 1]
    _first_step(solids, friction, n, dt, speeds, room)
    cell, load = normal.radii[n + 1] - normal.radii[n], touch[FIRST_]
    force = (nodes[WEIGHT_, n] - 0.5 * cell) * load + cell * touch[MEAN_]
    tangential, pressing = solids
    # Beyond the first step the layer is that of the stuck or of the slipping load.
    if abs(load) < _STUCK * friction * _limit_at_touch(pressing, room, normal.depths[n + 1] - normal.touched[n]):
        for k in range(tangential.times.shape[0]):
            force += cell * _end_weight(dt / tangential.times[k]) * room.tangential[k, n]
    else:
        sign = 1.0 if load > 0.0 else -1.0
        for k in range(pressing.times.shape[0]):
            force += sign * friction * cell * _end_weight(dt / pressing.times[k]) * room.part[k]
    return force


@inlined
def _limit_at_touch(pressing: Modes, room: Room, depth: float) -> float:
    """Return the normal load of an element after its first step, apart from that of a dashpot."""
    limit = pressing.equilibrium * depth
    for k in range(pressing.times.shape[0]):
        limit += room.part[k]
    return limit


@inlined
def _take_in(normal: Normal, pressing: Modes, n: int, friction: float, room: Room) -> None:
    """Write the state of the element touched at step n after its first step, and its energies."""
    nodes, touch, sums = room.nodes, room.touch, room.sums
    dt = normal.times[n + 1] - normal.times[n]
    nodes[U_, n], nodes[LOAD_, n], nodes[RATE_, n] = touch[WAY_], touch[FIRST_], touch[WAY_] / dt
    limit = _limit_at_touch(pressing, room, normal.depths[n + 1] - normal.touched[n])
    nodes[LIMIT_, n] = friction * (limit + pressing.viscosity * normal.velocities[n + 1])
    for k in range(pressing.times.shape[0]):
        decay = math.exp(-dt / pressing.times[k])
        room.normal[k, n] = pressing.moduli[k] * (normal.memory[k, n + 1] - decay * normal.memory[k, n])
    sums[FRICTION_] += nodes[WEIGHT_, n] * touch[RUBBED_]
    sums[VISCOUS_] += nodes[WEIGHT_, n] * touch[SPENT_]


@inlined
def _clear(normal: Normal, room: Room, velocity: float) -> None:
    """Write the weights and the state at first touch."""
    radii, last = normal.radii, normal.radii.shape[0] - 1
    for i in range(last + 1):
        below = radii[i - 1] if i > 0 else -radii[0]
        above = radii[i + 1] if i < last else radii[last]
        room.nodes[U_, i], room.nodes[RATE_, i], room.nodes[LOAD_, i] = 0.0, 0.0, 0.0
        room.nodes[WEIGHT_, i] = 0.5 * (above - below)
    for m in range(N_SUMS):
        room.sums[m] = 0.0
    for m in range(N_MOTION):
        room.motion[0, m] = velocity if m == V_ else 0.0


@entry_point
def march(
    normal: Normal, tangential: Modes, pressing: Modes, mobility: float, friction: float, velocity: float, room: Room
) -> None:
    """Follow the contact point of an oblique impact from first touch to separation; the results are in `room`.

    `velocity` is that of the contact point along the surface, ``v' = -mobility F``.
    """
    N, solids = normal.radii.shape[0] - 1, (tangential, pressing)
    nodes, sums = room.nodes, room.sums
    _clear(normal, room, velocity)
    v, force, before = velocity, 0.0, 0.0
    for n in range(2 * N):
        dt, grows = normal.times[n + 1] - normal.times[n], n < N
        # In the rebound the last of the elements leaves at the end of the step.
        count = n if grows else 2 * N - n
        pull, free = 0.25 * mobility * dt * dt, dt * v - 0.25 * mobility * dt * dt * force
        guess = free - pull * force
        fixed = _front(normal, solids, friction, n, (v, 2.0 * guess / dt - v), room) if grows else 0.0
        slope, lag = _set_factors(tangential, dt, before, room.factors)
        limit = nodes[LIMIT_, count - 1] if count > 0 else 0.0
        _set_loads(normal, solids, friction, n, count, lag, room)
        if not grows:
            nodes[LIMIT_, count - 1] = 0.0
        fixed += _kink(normal.radii, nodes, count, slope, guess)
        whole = count if grows else count - 1
        way, after = _way(nodes, whole, slope, fixed, free, pull, guess)
        last, slip = _advance(tangential, normal.radii, whole, slope, way, dt, room)
        if grows:
            _take_in(normal, pressing, n, friction, room)
            # The youngest element counts where all others stick, as the stuck region is a disc.
            if last == n - 1 and abs(nodes[LOAD_, n]) < _STUCK * nodes[LIMIT_, n]:
                last = n
        else:
            _last_step(tangential, count - 1, dt, before, limit, (v, 2.0 * way / dt - v), room)
        v -= 0.5 * mobility * dt * (force + after)
        sums[IMPULSE_] += 0.5 * dt * (force + after)
        if last >= 0:
            sums[STUCK_] = 1.0
        force, before = after, dt
        room.motion[n + 1, V_], room.motion[n + 1, F_] = v, force
        room.motion[n + 1, STICK_] = normal.radii[last] if last >= 0 else 0.0
        room.motion[n + 1, SLIP_] = slip
