"""Tangential half of an oblique impact: elements that stick or slip, on the stored normal solution.

Element i, touched at t_i, carries the tangential load `q = Ginf u + eta u' + sum p_k` with its displacement u and
`p_k' = -p_k/tau_k + G_k u'`. It follows the body, `u' = v`, as long as `abs(q) <= mu q_z`; else q is that limit, and u
follows from q: displacements of the surface, not of the body, drive the memory. The body obeys `v' = -mobility F` with
`F = int q dx`. All is scaled as the normal impact.

There are N equal steps in sigma and N in lambda: element i is touched at step i and leaves at step 2N - i. A step has
one unknown, the way Du of the body. The force is piecewise linear in it and rises, so that Newton's method ends after
few steps. The scheme is of second order, also for relaxation times far below the step: the surface velocity is linear
over two steps, and the first step of each element is divided.

Elements that have stuck for a while are a core (`sliding.py`), where they slip from the edge inwards. The others are
followed one by one, eight in a vector. The energy dissipated in the material is the work on the surface less what
elements store when they leave.
"""

import math
from typing import Any, NamedTuple

from restitution.kernel.compile import compiled, entry_point, inlined
from restitution.kernel.lanes import (
    WIDTH,
    absolute,
    at_least,
    broadcast,
    exp,
    largest,
    read8,
    smallest,
    total,
    where_positive,
    write8,
)
from restitution.kernel.path import radius_and_integral
from restitution.kernel.sliding import (
    ACTIVE_,
    AGE,
    ALONE_,
    BEFORE_,
    CHANGE_,
    DECAY_,
    END_,
    ENDED_SLIP_,
    F_,
    FADING_,
    FIRST_,
    FIRST_CHANGE_,
    FRICTION_,
    GAPS_,
    LAST_LIMIT_,
    LAST_LOAD_,
    LAST_RATE_,
    LAST_WAY_,
    LENGTH_,
    LIMIT_,
    LOAD_,
    LOADS_,
    LONGEST_PART,
    MEAN_,
    N_CORE,
    N_CREASE,
    N_LEAVING,
    N_MOTION,
    N_SUMS,
    NORMAL_D_,
    NORMAL_H_,
    NORMAL_T_,
    NORMAL_V_,
    OF_OTHER_,
    OF_PART_,
    OF_STEP_,
    PRESS_DECAY_,
    PRESS_GAIN_,
    PRESSED_,
    RADIUS_,
    RATE_,
    RUBBED_,
    SHARE_,
    SLIDES_,
    SLIP_,
    SLIPPED_,
    START_,
    STEADY_,
    STICK_,
    STORED_,
    T_,
    TOUCHED_,
    TRIAL_,
    TURNED_,
    TURNED_LOAD_,
    U_,
    V_,
    VISCOUS_,
    WAY_,
    WEIGHT_,
    WORK_,
    Halves,
    Modes,
    Room,
    advance_core,
    core_force,
    core_load,
    is_stuck,
    join,
    release,
    remember,
    sample,
    set_factors,
    set_losses,
    whole_lanes,
)
from restitution.kernel.switching import added_impulse, end_slips, kink, note_front, turned
from restitution.kernel.workspace import S_

# Parts of the first step of an element: the first over the shortest time, its least size over the step, and growth.
_FIRST_PART, _LEAST_PART, _GROWTH = 0.25, 2e-6, 1.3
# Parts of the last step of an element.
_LAST_PARTS = 16
# Parts over a relaxation time below which a mode is slow.
_SLOW = 1e-3
_MAX_ITERATIONS = 60
# Stuck elements outside of the core, which has whole lanes.
_RIM = 4
_ROUNDING = 1e-14
# Load over its limit up to which the youngest element counts as stuck.
_STUCK = 0.999
# Share of the elements that may slip within the radius that sticks without being counted.
_GAP = 0.02
# Columns of the results of a march.
N_RESULTS = 5


class Step(NamedTuple):
    """One step: its number and length, that of the step before, and the elements before it and at its end."""

    n: int
    dt: float
    before: float
    earliest: float
    count: int
    whole: int
    slope: float  # of the load over the way
    lag: float  # of the load over the last rate
    pull: float  # the way is free - pull F
    free: float
    guess: float
    pace: float  # velocity of the body in the last step
    ended: float  # the same at its end


@inlined
def _within(load: float, limit: float) -> float:
    """Return a load between its limits."""
    return min(max(load, -limit), limit)


@compiled
def _first_step(
    solids: tuple[Modes, Modes], friction: float, dt: float, speeds: tuple[float, float, float, float],
    room: Room,
) -> None:  # fmt: skip
    """Follow an element over its first step in parts, and write `touch` and `young`.

    Fast modes, in which an element may slip before it sticks, make a layer at the edge that is thinner than the step.
    The loads of all ages are those of the elements that are touched within the step. `speeds` are those of the body
    along the surface and into it, each at the start and at the end.
    """
    tangential, normal = solids
    along, along_end, into, into_end = speeds
    shortest = dt
    for k in range(tangential.times.shape[0]):
        shortest = min(shortest, tangential.times[k])
        room.young[k] = 0.0
    for k in range(normal.times.shape[0]):
        shortest = min(shortest, normal.times[k])
        room.part[PRESSED_, k] = 0.0
    if tangential.viscosity > 0.0 or normal.viscosity > 0.0:
        shortest = 0.0
    way, depth, age, load, rate, before = 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
    mean, rubbed, work, slope, lag = 0.0, 0.0, 0.0, 0.0, 0.0
    part_before, two_before, kind, inverse, pace = -1.0, -1.0, OF_PART_, 0.0, 0.0
    part = max(_FIRST_PART * shortest, _LEAST_PART * dt)
    while age < dt:
        part = min(part, LONGEST_PART * dt)
        if age + part > dt * (1.0 - 1e-9):
            part = dt - age
        middle = (age + 0.5 * part) / dt
        body = part * (along + middle * (along_end - along))
        # Most parts are as long as the two before them.
        if part != part_before or before != two_before:
            kind = OF_PART_
            if part != LONGEST_PART * dt:
                kind = OF_OTHER_
                for k in range(tangential.times.shape[0]):
                    room.losses[k, kind] = -math.expm1(-part / tangential.times[k])
                for k in range(normal.times.shape[0]):
                    room.pressing_losses[k, kind] = -math.expm1(-part / normal.times[k])
            slope, lag = set_factors(tangential, part, before, room.losses, kind, room.part_factors)
            part_before, two_before, inverse, pace = part, before, 1.0 / slope, 1.0 / part
        trial = tangential.equilibrium * way - lag * rate
        for k in range(tangential.times.shape[0]):
            trial += room.part_factors[k, DECAY_] * room.young[k]
        speed, pull = into + middle * (into_end - into), (into_end - into) / dt
        depth += part * speed
        limit = normal.equilibrium * depth + normal.viscosity * (speed + 0.5 * part * pull)
        for k in range(normal.times.shape[0]):
            tau, loss = normal.times[k], room.pressing_losses[k, kind]
            room.part[PRESSED_, k] += (
                normal.moduli[k] * tau * loss * (speed - 0.5 * part * pull) - loss * room.part[PRESSED_, k]
            )
            room.part[PRESSED_, k] += normal.moduli[k] * tau * pull * (part - tau * loss)
            limit += room.part[PRESSED_, k]
        after = _within(trial + slope * body, friction * max(limit, 0.0))
        moved = (after - trial) * inverse
        rubbed += (body - moved) * 0.5 * (load + after)
        work += moved * 0.5 * (load + after)
        mean += 0.5 * part * (load + after)
        for k in range(tangential.times.shape[0]):
            room.young[k] = _advanced(room.part_factors[k], room.young[k], moved, rate * part)
        way, load, rate, before, age = way + moved, after, moved * pace, part, age + part
        part *= _GROWTH
    room.touch[FIRST_], room.touch[MEAN_], room.touch[WAY_] = load, mean / dt, way
    room.touch[RUBBED_], room.touch[WORK_] = rubbed, work


@inlined
def _leave(node: int, limit: float, body: Any, steps: tuple[float, float], lane: int, room: Room) -> int:
    """Note the state of an element at the start of its last step; return how many are noted."""
    nodes, leaving = room.nodes, room.leaving
    leaving[LAST_WAY_, lane], leaving[LAST_RATE_, lane] = nodes[U_, node], nodes[RATE_, node]
    leaving[LAST_LOAD_, lane], leaving[LAST_LIMIT_, lane] = nodes[LOAD_, node], limit
    leaving[START_, lane], leaving[END_, lane] = body
    leaving[BEFORE_, lane], leaving[LENGTH_, lane] = steps
    leaving[SHARE_, lane] = nodes[WEIGHT_, node]
    for k in range(room.fading.shape[0]):
        room.fading[k, FADING_, lane] = room.tangential[k, node]
    return lane + 1


@inlined
def _last_factors(tangential: Modes, k: int, part: Any, shares: Any, fading: Any) -> Any:
    """Write the factors of a mode over the first and the other parts of last steps; return those in the load.

    They are those of `set_factors`, whose shares of the two kinds of parts are given.
    """
    tau, modulus = tangential.times[k], tangential.moduli[k]
    ratio = (1.0 / tau) * part
    # Differences of nearly equal terms, for slow modes.
    slow = where_positive(_SLOW - ratio, broadcast(1.0))
    fast, small = 1.0 - slow, where_positive(slow, ratio)
    loss = small * (1.0 - small * (0.5 - small * (1.0 / 6.0 - (1.0 / 24.0) * small)))
    loss = loss + fast * (1.0 - exp(at_least(-1.0 * ratio, -700.0)))
    change = fast * (tau * (part - 0.5 * part * loss - tau * loss)) + (1.0 / 12.0) * (small * part * part)
    steady = (modulus * tau) * (loss / part)
    first, other = modulus * (change * shares[0]), modulus * (change * shares[1])
    write8(fading, k, DECAY_, 0, 1.0 - loss)
    write8(fading, k, STEADY_, 0, steady)
    write8(fading, k, FIRST_CHANGE_, 0, first)
    write8(fading, k, CHANGE_, 0, other)
    return steady, first, other


@compiled
def _last_steps(tangential: Modes, room: Room) -> None:
    """Follow eight elements over their last steps in parts, and add their energies; their limits fall to 0.

    The load may reach the limit only shortly before the element leaves. Its energies depend on how it drops. The body
    does not feel them, so that they wait until there are eight.
    """
    leaving, fading, sums = room.leaving, room.fading, room.sums
    part = (1.0 / _LAST_PARTS) * read8(leaving, LENGTH_, 0)
    pace = 1.0 / part
    shares = 2.0 / (part * (part + read8(leaving, BEFORE_, 0))), pace * pace
    lags = (0.5 * tangential.viscosity) * (part * shares[0]), (0.5 * tangential.viscosity) * (part * shares[1])
    fixed = tangential.equilibrium + tangential.viscosity * pace
    lag, other_lag, slope, other_slope = lags[0], lags[1], fixed + lags[0], fixed + lags[1]
    for k in range(tangential.times.shape[0]):
        steady, first, other = _last_factors(tangential, k, part, shares, fading)
        lag, other_lag = lag + first, other_lag + other
        slope, other_slope = slope + (steady + first), other_slope + (steady + other)
    load, limit = read8(leaving, LAST_LOAD_, 0), read8(leaving, LAST_LIMIT_, 0)
    way, moved = read8(leaving, LAST_WAY_, 0), part * read8(leaving, LAST_RATE_, 0)
    start, end = part * read8(leaving, START_, 0), part * read8(leaving, END_, 0)
    inverse, rubbed, work, column = 1.0 / slope, broadcast(0.0), broadcast(0.0), FIRST_CHANGE_
    for m in range(_LAST_PARTS):
        trial, usual = tangential.equilibrium * way - lag * moved, moved
        for k in range(tangential.times.shape[0]):
            trial = trial + read8(fading, k, DECAY_, 0) * read8(fading, k, FADING_, 0)
        going = start + ((m + 0.5) / _LAST_PARTS) * (end - start)
        free = trial + slope * going
        above, below = _beyond(free, (1.0 - (m + 1.0) / _LAST_PARTS) * limit)
        after = free - above + below
        moved, mean = inverse * (after - trial), 0.5 * (load + after)
        rubbed, work = rubbed + (going - moved) * mean, work + moved * mean
        for k in range(tangential.times.shape[0]):
            mode = read8(fading, k, DECAY_, 0) * read8(fading, k, FADING_, 0) + read8(fading, k, STEADY_, 0) * moved
            write8(fading, k, FADING_, 0, mode + read8(fading, k, column, 0) * (moved - usual))
        way, load = way + moved, after
        if m == 0:
            lag, slope, inverse, column = other_lag, other_slope, 1.0 / other_slope, CHANGE_
    energy = tangential.equilibrium * (way * way)
    for k in range(tangential.times.shape[0]):
        mode = read8(fading, k, FADING_, 0)
        energy = energy + (1.0 / tangential.moduli[k]) * (mode * mode)
    weight = read8(leaving, SHARE_, 0)
    stored = total(0.5 * weight * energy)
    sums[FRICTION_] += total(weight * rubbed)
    sums[VISCOUS_] += total(weight * work) - stored
    sums[STORED_] += stored
    write8(leaving, SHARE_, 0, broadcast(0.0))


@inlined
def _advanced(factors: Any, load: float, moved: float, usual: float) -> float:
    """Return the load of a mode after a displacement; `usual` is that of its last rate."""
    return factors[DECAY_] * load + factors[STEADY_] * moved + factors[CHANGE_] * (moved - usual)


@inlined
def _end_weight(ratio: float) -> float:
    """Return what the trapezoidal rule misses of a saturating mode beyond the first step, over its load there.

    The mode has the load `1 - exp(-age/tau)`, the step is `ratio` tau long.
    """
    if ratio < 1e-2:
        return (1.0 - 0.5 * ratio) / 12.0
    decay = math.exp(-min(ratio, 700.0))
    return decay * (0.5 + decay / (1.0 - decay) - 1.0 / ratio) / (1.0 - decay)


@inlined
def _set_gains(pressing: Modes, n: int, room: Room) -> None:
    """Write what a step leaves of the normal loads of modes, and adds to them."""
    part, samples = room.part, room.samples
    for k in range(pressing.times.shape[0]):
        decay, memory = 1.0 - room.pressing_losses[k, OF_STEP_], NORMAL_H_ + k
        part[PRESS_DECAY_, k] = decay
        part[PRESS_GAIN_, k] = pressing.moduli[k] * (samples[memory, n + 1] - decay * samples[memory, n])


@compiled
def _set_loads(
    solids: tuple[Modes, Modes], friction: float, n: int, span: tuple[int, int], lag: float,
    room: Room,
) -> None:  # fmt: skip
    """Write the loads without a displacement in this step, and the limits, of a span of the elements.

    A span begins at whole lanes. Lanes beyond its end have elements without contact, whose numbers mean nothing.
    """
    (tangential, pressing), (first, end), nodes, part = solids, span, room.nodes, room.part
    drag, depth = pressing.viscosity * room.samples[NORMAL_V_, n + 1], room.samples[NORMAL_D_, n + 1]
    for i in range(first, end, WIDTH):
        load = tangential.equilibrium * read8(nodes, U_, i) - lag * read8(nodes, RATE_, i)
        for k in range(tangential.times.shape[0]):
            load = load + room.factors[k, DECAY_] * read8(room.tangential, k, i)
        limit = pressing.equilibrium * (depth - read8(nodes, TOUCHED_, i)) + drag
        for k in range(pressing.times.shape[0]):
            pressed = part[PRESS_DECAY_, k] * read8(room.normal, k, i) + part[PRESS_GAIN_, k]
            write8(room.normal, k, i, pressed)
            limit = limit + pressed
        write8(nodes, TRIAL_, i, load)
        write8(nodes, LIMIT_, i, friction * at_least(limit, 0.0))


@inlined
def _beyond(load: Any, limit: Any) -> tuple[Any, Any]:
    """Return by how much loads are above their limits, and below them on the other side."""
    above, below = load - limit, -1.0 * limit - load
    return where_positive(above, above), where_positive(below, below)


@compiled
def _way(
    nodes: Any, span: tuple[int, int], slope: float, fixed: float, stiff: float, free: float, pull: float, guess: float
) -> Any:
    """Return the way of the body in a step, and the force at its end, by Newton's method within a bracket.

    The way is ``free - pull F``. Outside of the span of elements the force is `fixed`, and `stiff` times the way.
    """
    first, end = span
    way, low, high, force = guess, -math.inf, math.inf, fixed
    for _ in range(_MAX_ITERATIONS):
        loads, stuck = broadcast(0.0), broadcast(0.0)
        for i in range(first, end, WIDTH):
            load, weight = read8(nodes, TRIAL_, i) + slope * way, read8(nodes, ACTIVE_, i)
            above, below = _beyond(load, read8(nodes, LIMIT_, i))
            loads = loads + weight * (load - above + below)
            stuck = stuck + (weight - where_positive(above + below, weight))
        force = fixed + stiff * way + total(loads)
        stiffness = stiff + slope * total(stuck)
        rest = way - free + pull * force
        if abs(rest) <= _ROUNDING * (abs(free) + pull * abs(force)):
            break
        low, high = (low, min(high, way)) if rest > 0.0 else (max(low, way), high)
        after = way - rest / (1.0 + pull * stiffness)
        if not low < after < high:
            after = 0.5 * (low + high)
        if after == way:
            break
        way = after
    return way, force


@compiled
def _advance(
    tangential: Modes, N: int, span: tuple[int, int], slope: float, way: float, steps: tuple[float, float],
    pace: float, room: Room,
) -> Any:  # fmt: skip
    """Advance the core and a span of elements; return the last element that sticks and the largest velocity of slip.

    `pace` is the velocity of the body in the last step.
    """
    (first, end), (_, dt) = span, steps
    nodes, sums, factors = room.nodes, room.sums, room.factors
    inverse, rate, unit = 1.0 / slope, 1.0 / dt, broadcast(1.0)
    lost, pulled, sticking, fastest = broadcast(0.0), broadcast(0.0), broadcast(0.0), broadcast(0.0)
    for i in range(first, end, WIDTH):
        trial, weight, ended = read8(nodes, TRIAL_, i), read8(nodes, ACTIVE_, i), read8(nodes, ENDED_SLIP_, i)
        load = trial + slope * way
        above, below = _beyond(load, read8(nodes, LIMIT_, i))
        over, bounded, age = above + below, load - above + below, read8(nodes, SLIDES_, i) - 1.0 / AGE
        slip = where_positive(over, way - inverse * (bounded - trial))
        moved = way - (slip + ended)
        write8(nodes, SLIDES_, i, age + where_positive(over, 1.0 - age))
        sticking = sticking + where_positive(weight, unit - where_positive(over, unit))
        mean = (0.5 * weight) * (read8(nodes, LOAD_, i) + bounded)
        lost, pulled = lost + mean * (slip + ended), pulled + mean
        faster = where_positive(weight, absolute(slip + ended)) - fastest
        fastest = fastest + where_positive(faster, faster)
        write8(nodes, LOAD_, i, bounded)
        write8(nodes, U_, i, read8(nodes, U_, i) + moved)
        change = moved - dt * read8(nodes, RATE_, i)
        write8(nodes, SLIPPED_, i, pace - read8(nodes, RATE_, i))
        for k in range(tangential.times.shape[0]):
            mode = factors[k, DECAY_] * read8(room.tangential, k, i) + factors[k, STEADY_] * moved
            write8(room.tangential, k, i, mode + factors[k, CHANGE_] * change)
        # An element whose slip has ended follows the body.
        write8(nodes, RATE_, i, rate * (way - slip))
    advance_core(tangential, way, pace, dt, room)
    last, stuck = end - 1, first + int(total(sticking))
    while last + 1 - WIDTH >= first and smallest(read8(nodes, SLIDES_, last + 1 - WIDTH)) == 1.0:
        last -= WIDTH
    while last >= first and nodes[SLIDES_, last] == 1.0:
        last -= 1
    sums[FRICTION_] += total(lost)
    sums[VISCOUS_] += way * total(pulled) - total(lost)
    sums[GAPS_] += dt if last + 1 - stuck > 1.0 + _GAP * (N + 1) else 0.0
    return last, largest(fastest) / dt


@inlined
def _front(solids: tuple[Modes, Modes], friction: float, n: int, body: Any, room: Room) -> Any:
    """Take in the element touched at step n; return the force of the cell up to the edge, and that of later ages.

    `body` are the velocities of the body along the surface at both ends of the step.
    """
    dt, nodes, touch = room.samples[NORMAL_T_, n + 1] - room.samples[NORMAL_T_, n], room.nodes, room.touch
    speeds = body[0], body[1], room.samples[NORMAL_V_, n], room.samples[NORMAL_V_, n + 1]
    _first_step(solids, friction, dt, speeds, room)
    cell, load = room.nodes[RADIUS_, n + 1] - room.nodes[RADIUS_, n], touch[FIRST_]
    force, layer = (nodes[WEIGHT_, n] - 0.5 * cell) * load + cell * touch[MEAN_], 0.0
    tangential, pressing = solids
    # Beyond the first step the layer is that of the stuck or of the slipping load.
    if abs(load) < _STUCK * friction * _limit_at_touch(pressing, n, room):
        for k in range(tangential.times.shape[0]):
            layer += cell * _end_weight(dt / tangential.times[k]) * room.young[k]
    else:
        sign = 1.0 if load > 0.0 else -1.0
        for k in range(pressing.times.shape[0]):
            layer += sign * friction * cell * _end_weight(dt / pressing.times[k]) * room.part[PRESSED_, k]
    return force, layer


@inlined
def _limit_at_touch(pressing: Modes, n: int, room: Room) -> float:
    """Return the normal load of the element touched at step n after this step, apart from that of a dashpot."""
    limit = pressing.equilibrium * (room.samples[NORMAL_D_, n + 1] - room.nodes[TOUCHED_, n])
    for k in range(pressing.times.shape[0]):
        limit += room.part[PRESSED_, k]
    return limit


@inlined
def _take_in(pressing: Modes, n: int, friction: float, pace: float, room: Room) -> bool:
    """Write the state of the element touched at step n after its first step, and its energies; return if it sticks.

    `pace` is the velocity of the body.
    """
    nodes, touch, sums = room.nodes, room.touch, room.sums
    dt = room.samples[NORMAL_T_, n + 1] - room.samples[NORMAL_T_, n]
    nodes[U_, n], nodes[LOAD_, n] = touch[WAY_], touch[FIRST_]
    limit = _limit_at_touch(pressing, n, room)
    nodes[LIMIT_, n] = friction * (limit + pressing.viscosity * room.samples[NORMAL_V_, n + 1])
    for k in range(pressing.times.shape[0]):
        room.normal[k, n] = room.part[PRESS_GAIN_, k]
    for k in range(room.young.shape[0]):
        room.tangential[k, n] = room.young[k]
    nodes[ACTIVE_, n], nodes[SLIPPED_, n] = nodes[WEIGHT_, n], 0.0
    sums[FRICTION_] += nodes[WEIGHT_, n] * touch[RUBBED_]
    sums[VISCOUS_] += nodes[WEIGHT_, n] * touch[WORK_]
    # An element that slipped before it stuck follows the body since.
    sticks = abs(touch[FIRST_]) < _STUCK * nodes[LIMIT_, n]
    nodes[RATE_, n] = pace if sticks else touch[WAY_] / dt
    nodes[SLIDES_, n] = 1.0 - 1.0 / AGE if sticks else 1.0
    return sticks


@compiled
def _clear_rows(rows: Any, first: int) -> None:
    """Write zeros to eight numbers of each row."""
    for n in range(rows.shape[0]):
        write8(rows, n, first, broadcast(0.0))


@compiled
def _clear(path: Any, steps: int, velocity: float, room: Room) -> None:
    """Write the elements with their weights, and the state at first touch."""
    nodes = room.nodes
    for i in range(0, steps + 1 + WIDTH, WIDTH):
        _clear_rows(nodes, i)
        _clear_rows(room.tangential, i)
        _clear_rows(room.normal, i)
    for i in range(steps + 1):
        s = max(room.samples[S_, i], 0.0)
        nodes[RADIUS_, i], nodes[TOUCHED_, i] = radius_and_integral(path, s)[0], s * s
    for i in range(steps + 1):
        below = nodes[RADIUS_, i - 1] if i > 0 else -nodes[RADIUS_, 0]
        nodes[WEIGHT_, i] = 0.5 * (nodes[RADIUS_, min(i + 1, steps)] - below)
    for m in range(N_SUMS):
        room.sums[m] = 0.0
    for m in range(N_LEAVING):
        write8(room.leaving, m, 0, broadcast(0.0 if m == SHARE_ else 1.0))
    for m in range(N_CORE):
        room.core[m] = 0.0
    for m in range(N_CREASE):
        room.crease[m] = -1.0 if m == TURNED_ else 0.0
    for k in range(room.missed.shape[0]):
        room.missed[k, TURNED_LOAD_] = 0.0
    for k in range(room.lump.shape[0]):
        room.lump[k, LOADS_], room.lump[k, ALONE_] = 0.0, 0.0
        write8(room.fading, k, FADING_, 0, broadcast(0.0))
    for m in range(N_MOTION):
        room.motion[0, m] = velocity if m == V_ else 0.0


@compiled
def _shrink_core(solids: tuple[Modes, Modes], friction: float, step: Step, core: int, room: Room) -> int:
    """Let the outermost lanes go from the core, and write their loads and limits; return the first element outside."""
    first = release(solids, step.n, (whole_lanes(core - 1 - step.count // 32), core), (step.pace, step.ended), room)
    _set_loads(solids, friction, step.n, (first, core), step.lag, room)
    return first


@inlined
def _settle(solids: tuple[Modes, Modes], friction: float, step: Step, core: int, fixed: float, room: Room) -> Any:
    """Find the way of the body in a step; `fixed` is the force of the elements touched in it.

    Return the core, the way, the force at the end, that of the cell with the stick radius, and the sum of the forces
    of the core at both ends. The core shrinks until an element beyond it sticks: then all within it do.
    """
    nodes, slope = room.nodes, step.slope
    while core > 0 and not (is_stuck(nodes, core, slope, step.guess) and is_stuck(nodes, core + 1, slope, step.guess)):
        core = _shrink_core(solids, friction, step, core, room)
    missed, front = kink(nodes, core, step.count, slope, step.guess)
    missed += turned(solids[0], front, room)
    fixed, way = fixed + missed, step.guess
    while True:
        held = core_load(solids[0], step.ended, room)
        inner, stiff = core_force(solids[0], step.lag * step.pace, slope, room)
        span = core, step.whole
        way, force = _way(nodes, span, slope, fixed + inner, stiff, step.free, step.pull, way)
        if core == 0 or is_stuck(nodes, core, slope, way):
            break
        core = _shrink_core(solids, friction, step, core, room)
    steps = step.earliest, step.before, step.dt
    if step.n > 1 and end_slips(solids[0], span, slope, way, steps, step.pace, room):
        way, force = _way(nodes, span, slope, fixed + inner, stiff, step.free, step.pull, way)
    return core, way, force, missed, held + inner + stiff * way


@compiled
def _march(
    N: int, solids: tuple[Modes, Modes], mobility: float, friction: float, velocity: float, keeps: bool, room: Room
) -> None:
    """Follow the contact point from first touch to separation."""
    tangential, pressing = solids
    nodes, sums = room.nodes, room.sums
    v, force, before, earliest, paces, core, missed, lane = velocity, 0.0, 0.0, 0.0, (0.0, 0.0), 0, 0.0, 0
    for n in range(2 * N):
        dt, grows = room.samples[NORMAL_T_, n + 1] - room.samples[NORMAL_T_, n], n < N
        # In the rebound the last of the elements leaves at the end of the step.
        count = n if grows else 2 * N - n
        whole = count if grows else count - 1
        pull, free = 0.25 * mobility * dt * dt, dt * v - 0.25 * mobility * dt * dt * force
        guess = free - pull * force
        layer, fixed = 0.0, 0.0
        set_losses(tangential, dt, room.losses)
        set_losses(pressing, dt, room.pressing_losses)
        _set_gains(pressing, n, room)
        if grows:
            fixed, layer = _front(solids, friction, n, (v, 2.0 * guess / dt - v), room)
        if core > whole - _RIM:
            core = release(solids, n, (whole_lanes(whole - _RIM), core), paces, room)
        slope, lag = set_factors(tangential, dt, before, room.losses, OF_STEP_, room.factors)
        limit = nodes[LIMIT_, count - 1] if count > 0 else 0.0
        _set_loads(solids, friction, n, (core, count), lag, room)
        if not grows:
            nodes[LIMIT_, count - 1], nodes[ACTIVE_, count - 1] = 0.0, 0.0
        step = Step(n, dt, before, earliest, count, whole, slope, lag, pull, free, guess, paces[0], paces[1])
        core, way, after, bent, inside = _settle(solids, friction, step, core, fixed + layer, room)
        if not grows:
            lane = _leave(count - 1, limit, (v, 2.0 * way / dt - v), (before, dt), lane, room)
            if lane == WIDTH:
                _last_steps(tangential, room)
                lane = 0
        # What the quadrature over places misses of the loads, that over times misses of their work.
        sums[VISCOUS_] += 0.5 * way * (missed + layer + bent + inside)
        last, slip = _advance(tangential, N, (core, whole), slope, way, (before, dt), paces[0], room)
        pace = way * (1.0 / dt)
        if grows:
            sticks = _take_in(pressing, n, friction, pace, room)
            # The youngest element counts where all others stick, as the stuck region is a disc.
            last = n if last == n - 1 and sticks else last
        motion = room.motion[n + 1]
        motion[T_], motion[F_], motion[SLIP_] = room.samples[NORMAL_T_, n + 1], after, slip
        motion[STICK_] = room.nodes[RADIUS_, last] if last >= 0 else 0.0
        added = added_impulse(friction, N, n, room)
        v -= mobility * (0.5 * dt * (force + after) - added)
        motion[V_] = v
        sums[VISCOUS_] -= added * pace
        share = dt / (dt + before) if before > 0.0 else 0.0
        paces, force, missed = (pace, pace + share * (pace - paces[0])), after, layer + bent
        earliest, before = before, dt
        core = join(core, min(last, whole) - _RIM, room.samples[NORMAL_T_, n + 1], pace, room) if keeps else 0
        note_front(core, last, whole, room)
    _last_steps(tangential, room)


@entry_point
def march(
    halves: Halves, counts: Any, solids: tuple[Modes, Modes], mobility: float, velocity: float, keeps: bool,
    room: Room, results: Any,
) -> None:  # fmt: skip
    """Follow the contact point of an oblique impact from first touch to separation, with several numbers of steps.

    `solids` are the tangential and the normal relaxation, `velocity` is that of the contact point along the surface
    over the friction, which is 1, and ``v' = -mobility F``. `keeps` is whether elements that stick slip from the edge
    inwards alone. `results` has a row for each number of steps: the velocity at separation, the energies lost by
    friction, dissipated and stored, and 1 if any element ever stuck. The state and the motion of the last march are in
    `room`.
    """
    remember(halves, solids[1].times, room)
    for m in range(counts.shape[0]):
        steps = counts[m]
        sample(halves, steps, room)
        _clear(halves.path, steps, velocity, room)
        _march(steps, solids, mobility, 1.0, velocity, keeps, room)
        result, stuck = results[m], 0.0
        for n in range(1, 2 * steps + 1):
            stuck = 1.0 if room.motion[n, STICK_] > 0.0 else stuck
        result[0], result[4] = room.motion[2 * steps, V_], stuck
        result[1], result[2], result[3] = room.sums[FRICTION_], room.sums[VISCOUS_], room.sums[STORED_]
