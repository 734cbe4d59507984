"""What steps and cells miss where elements begin to slip or come to rest, beyond the second order.

The errors of the scheme of `tangential.py` are powers of the step, but jump with the places of four events within a
step or cell, so that no extrapolation removes them. Each of them has a closed form:

* the load has a kink at the stick radius, within a cell: `kink`;
* where the front turns, its kink stays behind among elements that stick, and decays with them: `turned`, `note_front`;
* slip ends within a step, and the load then leaves the line of slip as a square of time: `end_slips`;
* the disc that sticks vanishes within a step, and the force meets that of full sliding as a power of 3/2:
  `added_impulse`.

What the trapezoidal rule with step h adds to the integral of ``u^p``, whose zero lies y steps beyond the last point,
is ``h^(p+1) zeta(-p, y)``, Hurwitz's function: Bernoulli's polynomials for whole p.
"""

import math
from typing import Any

from restitution.kernel.compile import compiled, inlined
from restitution.kernel.lanes import WIDTH, absolute, broadcast, largest, read8, total, where_positive, write8
from restitution.kernel.sliding import (
    AGE,
    CHANGE_,
    DECAY_,
    ENDED_SLIP_,
    F_,
    FRONT_,
    FRONT_LOAD_,
    FRONT_WAY_,
    IMPULSE_,
    KNOWN_,
    LIMIT_,
    LOAD_,
    NORMAL_F_,
    NORMAL_T_,
    RADIUS_,
    RATE_,
    SLIDES_,
    SLIPPED_,
    STEADY_,
    STICK_,
    TRIAL_,
    TURNED_,
    TURNED_LOAD_,
    TURNED_WAY_,
    U_,
    WEIGHT_,
    Modes,
    Room,
    is_stuck,
)

# Steps over a relaxation time below which a mode keeps what it has in the step of a rest.
_SLOW = 0.05
# Shares of the contact radius that stick one step before the disc vanishes: below the first the force meets that of
# full sliding as a power, above the second as a line.
_POWER, _LINE = 0.88, 0.98


@inlined
def _beyond_last(last: float, before: float, first: float) -> float:
    """Return by how much the sum over a number that falls to zero is too large, from its last three values.

    The number is a parabola up to its zero, which lies less than a step beyond the last value, and zero from there.
    A twelfth of the slope, which does not depend on the place of the zero, is left out. The last term, which does not
    either, takes that slope a cell further inside. It makes the error of third order of elastic solids small.
    """
    if not before > last > 0.0:
        return 0.0
    bend = 0.5 * (first - 2.0 * before + last)
    slope = before - last - bend
    fall = math.sqrt(max(slope * slope - 4.0 * bend * last, 0.0))
    y = min(2.0 * last / (slope + fall), 1.0) if slope + fall > 0.0 else 1.0
    return y * (1.0 - y) * (0.5 * fall + bend * (y - 0.5) / 3.0) + bend / 6.0


@inlined
def _left(nodes: Any, i: int, sign: float, slope: float, way: float) -> float:
    """Return what is left up to the limit of an element, over its cell."""
    return nodes[WEIGHT_, i] * (nodes[LIMIT_, i] - sign * (nodes[TRIAL_, i] + slope * way))


@compiled
def kink(nodes: Any, core: int, count: int, slope: float, way: float) -> tuple[float, int]:
    """Return what the trapezoidal rule misses of the cell with the stick radius, and the element before it."""
    j = count - 1
    while j - WIDTH > core:
        start = j + 1 - WIDTH
        if largest(read8(nodes, LIMIT_, start) - absolute(read8(nodes, TRIAL_, start) + slope * way)) >= 0.0:
            break
        j -= WIDTH
    while j > core and not is_stuck(nodes, j, slope, way):
        j -= 1
    if j < core + 1 or j >= count - 1:
        return 0.0, j
    sign = 1.0 if nodes[TRIAL_, j + 1] + slope * way > 0.0 else -1.0
    left, before = _left(nodes, j, sign, slope, way), _left(nodes, j - 1, sign, slope, way)
    first = _left(nodes, j - 2, sign, slope, way) if j > core + 1 else 2.0 * before - left
    return sign * _beyond_last(left, before, first), j


@compiled
def turned(tangential: Modes, front: int, room: Room) -> float:
    """Return what the trapezoidal rule misses of the cell in which the front turned, at the end of a step.

    `front` is the last element that sticks now. All elements beside the kink follow the body, so that it only decays.
    """
    crease, missed = room.crease, room.missed
    if front <= crease[TURNED_]:
        crease[TURNED_], crease[TURNED_WAY_] = -1.0, 0.0
        for k in range(missed.shape[0]):
            missed[k, TURNED_LOAD_] = 0.0
    force, other = tangential.equilibrium * crease[TURNED_WAY_], tangential.equilibrium * crease[FRONT_WAY_]
    for k in range(missed.shape[0]):
        missed[k, TURNED_LOAD_] *= room.factors[k, DECAY_]
        missed[k, FRONT_LOAD_] *= room.factors[k, DECAY_]
        force += missed[k, TURNED_LOAD_]
        other += missed[k, FRONT_LOAD_]
    # A front that goes outwards leaves nothing more: what it passes has no kink.
    if crease[KNOWN_] > 0.0 and front > crease[FRONT_] and abs(other) > abs(force):
        force, crease[TURNED_], crease[TURNED_WAY_] = other, crease[FRONT_], crease[FRONT_WAY_]
        for k in range(missed.shape[0]):
            missed[k, TURNED_LOAD_] = missed[k, FRONT_LOAD_]
    crease[KNOWN_] = 0.0
    return force


@inlined
def _bent(row: Any, j: int, cells: tuple[float, float, float], share: float) -> float:
    """Return what the trapezoidal rule misses of a number with a kink in the middle one of three cells."""
    inner, _, outer = cells
    return 0.5 * share * ((row[j] - row[j - 1]) / inner - (row[j + 2] - row[j + 1]) / outer)


@compiled
def note_front(core: int, last: int, whole: int, room: Room) -> None:
    """Write what the trapezoidal rule misses of the displacement and of the modes in the cell with the front."""
    nodes, crease, radius = room.nodes, room.crease, room.nodes[RADIUS_]
    crease[FRONT_], crease[KNOWN_] = last, 0.0
    if last < core + 1 or last + 3 >= whole:
        return
    sign = 1.0 if nodes[LOAD_, last + 1] > 0.0 else -1.0
    left = nodes[LIMIT_, last] - sign * nodes[LOAD_, last]
    before = nodes[LIMIT_, last - 1] - sign * nodes[LOAD_, last - 1]
    cells = radius[last] - radius[last - 1], radius[last + 1] - radius[last], radius[last + 2] - radius[last + 1]
    if not (before > left > 0.0 and cells[0] > 0.0 and cells[2] > 0.0):
        return
    reach = min(left * cells[0] / (before - left), cells[1])
    share = reach * (cells[1] - reach)
    crease[KNOWN_], crease[FRONT_WAY_] = 1.0, _bent(nodes[U_], last, cells, share)
    for k in range(room.missed.shape[0]):
        room.missed[k, FRONT_LOAD_] = _bent(room.tangential[k], last, cells, share)


@inlined
def _zeta(y: float) -> float:
    """Return Hurwitz's zeta(-3/2, y) for y from 0 to 1, by the formula of Euler and Maclaurin from y + 4 on."""
    value = 0.0
    for k in range(4):
        value += (y + k) * math.sqrt(y + k)
    a = y + 4.0
    r = math.sqrt(a)
    return value + a * r * (0.5 - 0.4 * a) - 0.125 * r - (1.0 / 1920.0) / (a * r)


@inlined
def _vanish(friction: float, N: int, n: int, room: Room) -> float:
    """Return what the trapezoidal rule over times adds to the impulse as the disc that sticks vanishes in step n.

    What is left of the force up to that of full sliding follows from the last two steps. The square of the stick
    radius falls along a line, unless all of a contact that shrinks begins to slip at once.
    """
    motion, samples, time = room.motion, room.samples, room.samples[NORMAL_T_]
    if motion[n + 1, STICK_] > 0.0 or motion[n, STICK_] == 0.0 or n < 2 or n == 2 * N - 1:
        return 0.0
    sign = 1.0 if motion[n + 1, F_] > 0.0 else -1.0
    rest = friction * samples[NORMAL_F_, n + 1] - sign * motion[n + 1, F_]
    last = friction * samples[NORMAL_F_, n] - sign * motion[n, F_] - rest
    first = friction * samples[NORMAL_F_, n - 1] - sign * motion[n - 1, F_] - rest
    if not first > last > 0.0:
        return 0.0
    dt, before = time[n + 1] - time[n], time[n] - time[n - 1]
    root = (last / first) ** (2.0 / 3.0)
    reach = min(root / (1.0 - root) * before, dt)
    ratio = dt / (reach + before)
    power = first * ratio * math.sqrt(ratio) * dt * _zeta(reach / dt)
    slope = (first - last) / before
    y = min(last / (slope * dt), 1.0)
    line = slope * dt * dt * (0.5 * y * (1.0 - y) - 1.0 / 12.0)
    # The radius one step before the disc vanishes.
    edges = room.nodes[RADIUS_, n if n < N else 2 * N - n], room.nodes[RADIUS_, n - 1 if n <= N else 2 * N - n + 1]
    here = min(5.0 * y, 1.0)
    sticks = here * motion[n, STICK_] / edges[0] + (1.0 - here) * motion[n - 1, STICK_] / edges[1]
    share = min(max((_LINE - sticks) / (_LINE - _POWER), 0.0), 1.0)
    return -sign * (line + share * (power - line))


@compiled
def added_impulse(friction: float, N: int, n: int, room: Room) -> float:
    """Return what the trapezoidal rule over times adds to the impulse in step n."""
    impulse = room.crease[IMPULSE_] + _vanish(friction, N, n, room)
    room.crease[IMPULSE_] = 0.0
    return impulse


@inlined
def _rest(tangential: Modes, factors: Any, dt: float, x: float, slip: float, fall: float, earlier: float) -> float:
    """Return what a march adds to the impulse of an element that has come to rest, at x after the start of a step.

    The trapezoidal rule misses how its load leaves the line of slip, and fast modes have the slip of the whole step
    until they forget it. `earlier` is the rate of slip in the last step, `fall` its slope.
    """
    y = 1.0 - x / dt
    second, third = y * (y - 1.0) + 1.0 / 6.0, y * (y - 0.5) * (y - 1.0)
    square = fall * dt * dt
    impulse = -square * (tangential.equilibrium * third * dt / 6.0 + 0.5 * tangential.viscosity * second)
    for k in range(tangential.times.shape[0]):
        tau, modulus, z = tangential.times[k], tangential.moduli[k], dt / tangential.times[k]
        if z < _SLOW:
            impulse -= square * modulus * dt * third / 6.0
        else:
            decay, since, loss = factors[k, DECAY_], math.exp(-y * z), 1.0 - factors[k, DECAY_]
            line = 0.5 * second + (0.5 - y) / z + 1.0 / (z * z)
            impulse -= square * modulus * tau * (line - since / (loss * z))
            kept = factors[k, STEADY_] * slip + factors[k, CHANGE_] * (slip - dt * earlier)
            kept += modulus * fall * tau * tau * (since - (1.0 + x / tau) * decay)
            impulse -= dt * kept / loss
    return impulse


@inlined
def _last_slip(rates: tuple[float, float, float], steps: tuple[float, float, float]) -> tuple[float, float, float]:
    """Return when slip ends, since the start of a step, what it slips until then, and the slope of the rate there.

    `rates` are the means over the two last steps and over this one, if the slip went on. The slip is a cubic. The rate
    may have vanished in the last step. It is a line where the first rate is 0, or bends too much.
    """
    (first, earlier, later), (earliest, before, dt) = rates, steps
    change = (later - earlier) * 2.0 / (dt + before)
    start, bend = earlier + 0.5 * before * change, 0.0
    if first != 0.0 and earliest > 0.0:
        bend = (0.5 * change - (earlier - first) / (before + earliest)) / (dt + before + earliest)
        if abs(bend) * 12.0 * (dt + before) > abs(change):
            bend = 0.0
    x, fall = min(max(-start / change, -before), dt), change
    for _ in range(2):
        rate = start + change * x + bend * (3.0 * x * x + 2.0 * x * (before - dt) - before * dt)
        fall = change + bend * (6.0 * x + 2.0 * (before - dt))
        x = min(max(x - rate / fall, -before), dt)
    return x, x * (start + 0.5 * change * x + bend * (x + before) * (x - dt)), fall


@compiled
def end_slips(
    tangential: Modes, span: tuple[int, int], slope: float, way: float, steps: tuple[float, float, float],
    pace: float, room: Room,
) -> bool:  # fmt: skip
    """Write the slip of elements that come to rest in this step, or did so in the last one; return whether any do.

    The sum over whole steps would be off by a number of second order that jumps with their places. Loads without a
    displacement then are those after the slip. `pace` is the velocity of the body in the last step.
    """
    (first, end), dt, nodes = span, steps[2], room.nodes
    some, stops = False, broadcast(0.0)
    for i in range(first, end, WIDTH):
        inside = read8(nodes, LIMIT_, i) - absolute(read8(nodes, TRIAL_, i) + slope * way)
        stops = stops + where_positive(read8(nodes, SLIDES_, i) - (1.0 - 0.5 / AGE), where_positive(inside, inside))
        write8(nodes, ENDED_SLIP_, i, broadcast(0.0))
    if total(stops) == 0.0:
        return False
    for i in range(first, end):
        load, limit, earlier = nodes[TRIAL_, i] + slope * way, nodes[LIMIT_, i], pace - nodes[RATE_, i]
        sign = 1.0 if nodes[LOAD_, i] > 0.0 else -1.0
        if nodes[SLIDES_, i] == 1.0 and abs(load) < limit and sign * earlier > 0.0:
            rates = sign * max(sign * nodes[SLIPPED_, i], 0.0), earlier, (load - sign * limit) / (slope * dt)
            x, slip, fall = _last_slip(rates, steps)
            nodes[ENDED_SLIP_, i] = slip
            nodes[TRIAL_, i] -= slope * slip
            impulse = _rest(tangential, room.factors, dt, x, slip, fall, earlier)
            room.crease[IMPULSE_] += nodes[WEIGHT_, i] * impulse
            some = True
    return some
