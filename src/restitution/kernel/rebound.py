"""Rebound of the body (Graham, Ting) over lambda, along the stored approach backwards; index 1 marks its values.

    dt/dlambda = u,  u psi + 2 s1 v1 phi = 0,  phi = E + sum E_k X_k,  X_k = exp(-(t - t1)/tau_k),
    psi = E v - eta (F - F0) + sum E_k [W_k + X_k (v1 - W1_k)],  F = E Pi1 + sum E_k X_k Y1_k,
    dv/dlambda = -(F - F0) u,  dW_k/dlambda = -(u/tau_k) W_k + dv/dlambda.

Here v is the velocity of the indentation. If the target moves with the velocity z F, the rates of v get the term
-z dF/dlambda, with `dF/dlambda = -2 s1 v1 a1 phi + F_t u` and `F_t = -sum E_k X_k Y1_k/tau_k`. With a dashpot the
first line becomes `u (psi - eta z F_t) + 2 s1 v1 phi (1 + eta z a1) = 0`.

The unknown is u at the nodes; nothing is divided by psi. The first line is 0/0 at lambda = 0, where there is no node.
Stored elements contain s1, v, t, F and, for each mode, X_k and W_k.
"""

import math
from typing import Any

from restitution.kernel.approach import ATTEMPTS, KINK_TAIL, LEAST_NOISE, ROUGH, TABLE_NOISE, is_held
from restitution.kernel.collocation import (
    Scheme,
    combine,
    interpolate_lanes,
    invert,
    lagrange_lanes,
    matvec,
    product,
    tail,
    value,
)
from restitution.kernel.compile import compiled, inlined
from restitution.kernel.element import (
    CONVERGED,
    DIVERGED,
    FACTOR,
    LAG,
    ON_FAILURE,
    factor_modes,
    first_round,
    grown,
    next_round,
    refined,
    shrunk,
)
from restitution.kernel.kinks import missed_rebound
from restitution.kernel.lanes import WIDTH, absolute, at_least, broadcast, exp, largest, read8, root, smallest, write8
from restitution.kernel.outcome import CAPTURED, SEPARATED, SINKS_IN, STEP_TOO_SMALL, TOO_MANY_STEPS
from restitution.kernel.path import radii_and_integrals
from restitution.kernel.workspace import (
    AT_KINK,
    BACK_LENGTH,
    BACK_START,
    DELAY,
    F_,
    INTEGRAL,
    JACOBIAN,
    LENGTH,
    MODES_,
    N_APPROACH,
    N_FACTOR,
    N_REBOUND,
    RADIUS,
    S_,
    START,
    SUM,
    T_,
    UNKNOWN,
    V_,
    VALUES,
    WEIGHTED,
    Problem,
    Work,
)  # fmt: skip

# Newton's method.
ROUNDING = 1e-9  # relative size of a step below which it may be rounding
NOISE = 1e-14  # further part of it over the velocity of the approach, which vanishes at the turning point
_LEAST_VELOCITY = 1e-12  # smallest velocity for this part
_FORCE_NOISE, _LEAST_SPEED = 1e-15, 1e-9  # the same of the force over the velocity of a body on a target that moves
_MOST_ITERATIONS = 14
_LARGEST_STEP, _LEAST_PACE = 1e3, 1e-9  # largest step and smallest u, over the largest u
# First guess of u.
_LEAST_S, _LEAST_SPRING = 1e-12, 1e-30
_SHARES = 3  # rounds that decide which modes have relaxed
_FARTHEST = 2.0  # length over that of the last element up to which the polynomial of u/s1 is continued
_MOST_CHANGE = 10.0  # largest factor by which u/s1 may change
# Smallest share of the elastic amplitude at the turning point to which the tolerance refers: `KAPPA` if the elastic
# energy there is below `_LOSSY` of the initial kinetic energy, `KAPPA_ELASTIC` if it is above `_NEARLY_ELASTIC`, and
# in between by linear interpolation.
KAPPA, KAPPA_ELASTIC = 0.03, 0.3
_LOSSY, _NEARLY_ELASTIC = 0.6, 0.9
# Error of an element.
TIME_WEIGHT = 0.4  # weight of an error of the time, as F dt
_PLACE_ROUNDING = 1e-14  # rounding of a place over sigma at the turning point
# Length of an element.
_OF_RELAXATION = 0.7  # first element over the shortest relaxation time that matters
# Modes matter from this delay of the edge of contact on, times the force over the velocity that counts, over Newton's
# tolerance, which is a twentieth of rtol. Shorter delays than the last number are never resolved.
_MATTERS, _LEAST_DELAY = 10.0, 1e-13
# Largest u of the first element over s at the turning point, which should be 2, and smallest u over the largest one.
_MOST_PACE, _STANDSTILL = 4.0, 1e-6
_NEAR = 1e-8  # way from the turning point, over sigma there, on which the velocity is linear
_SHORTEST = 1e-15  # over sigma at the turning point
_WHOLE = 0.999  # share of the rest from which an element covers all of it
_HALVED = 0.6  # share of the rest from which it is divided into two elements
_BEYOND_KINK = 1.01  # factor by which an element may exceed that of the approach beyond a kink
# Capture, where the edge of contact turns outwards.
_PAUSE = 1e3  # dt/dlambda over s at the turning point
_PAUSE_LENGTH = 1e-9  # length of an element over sigma at the turning point


@inlined
def rebound_element(
    problem: Problem, scheme: Scheme, work: Work, table: Any, h: float, delay: float, accept: float
) -> int:
    """Solve one element of length h from the first column of `table` and t - t1 = `delay`; fill the other columns.

    `work.vectors[UNKNOWN]` contains the predicted u at the nodes, `work.past` the stored approach there, and
    `work.vectors[RADIUS]` and `[INTEGRAL]` its a and Pi; `work.vectors[DELAY]` receives t - t1. Returns the number of
    Newton iterations, or -1 if they do not converge.
    """
    A, unit = scheme.columns, scheme.identity
    N = problem.moduli.shape[0]
    B, X, W, past = work.inverses, work.modes[0], work.modes[1], work.past
    J, G, M = work.matrices[JACOBIAN], work.matrices[SUM], work.matrices[WEIGHTED]
    v0 = table[V_, 0]
    eta, external_force, equilibrium = problem.viscosity, problem.external_force, problem.equilibrium
    z = problem.admittance
    brake = eta * z
    v1, r1 = read8(past, V_, 0), 2.0 * read8(past, S_, 0)
    # 2 s1 v1 (1 + eta z a1).
    past_depth_slope = r1 * v1 * (1.0 + brake * read8(work.vectors, RADIUS, 0))
    # The delay is integrated: a difference of times would lose digits that matter for fast modes.
    elapsed = delay + h * matvec(A, r1)
    Pi = read8(work.vectors, INTEGRAL, 0)
    u = read8(work.vectors, UNKNOWN, 0)
    # The velocity that a moving target takes has the rounding of the force.
    rounding = ROUNDING + NOISE / max(v1[WIDTH - 1], _LEAST_VELOCITY)
    rounding += _FORCE_NOISE * z * table[F_, 0] / max(abs(v0), _LEAST_SPEED)
    largest_u = 0.0
    newton, iterations = first_round(), 0
    while True:
        iterations += 1
        if iterations > _MOST_ITERATIONS:
            return -1
        refactor, final_round = newton.verdict == FACTOR, newton.verdict == CONVERGED
        # dt/dlambda = u.
        duration = h * matvec(A, u)
        F = equilibrium * Pi
        phi = broadcast(equilibrium)
        memory = broadcast(0.0)
        phi_t = broadcast(0.0)
        F_t = broadcast(0.0)
        psi_t = broadcast(0.0)
        for k in range(N):
            inverse = 1.0 / problem.times[k]
            # Below exp(-700) the share is zero to rounding, and exp would underflow.
            x = exp(at_least((elapsed + duration) * -inverse, -700.0))
            write8(X, k, 0, x)
            x = problem.moduli[k] * x
            force_k = x * read8(past, MODES_ + 2 * k, 0)
            memory_k = x * (v1 - read8(past, MODES_ + 1 + 2 * k, 0))
            F = F + force_k
            phi = phi + x
            memory = memory + memory_k
            # The rates serve the Jacobian, and psi itself has F_t only with a dashpot on a target that moves.
            if refactor or brake > 0.0:
                F_t = F_t - force_k * inverse
                phi_t = phi_t - x * inverse
                psi_t = psi_t - (memory_k + (brake * inverse) * force_k) * inverse
        gained = -h * matvec(A, (F - external_force) * u) - z * (F - table[F_, 0])
        v = v0 + gained
        # eta dv/dt = -eta (F - F0) - eta z dF/dt; the part of dF/dt through lambda stands in `past_depth_slope`.
        psi = equilibrium * v - eta * (F - external_force) + memory - brake * F_t
        mode_slope = broadcast(0.0)
        if refactor:
            factor_modes(problem, scheme, work, u, h)
            for j in range(WIDTH):
                write8(G, j, 0, equilibrium * read8(unit, j, 0))
                write8(M, j, 0, broadcast(0.0))
        for k in range(N):
            E = problem.moduli[k]
            # W_k of a fast mode is far smaller than v: from v - v0 it would be rounding.
            start = table[MODES_ + 1 + 2 * k, 0] + gained
            if refactor:
                Wk = matvec(B[k], start)
                weight = E * Wk / u
                for j in range(WIDTH):
                    column = read8(B, k, j, 0)
                    write8(G, j, 0, read8(G, j, 0) + E * column)
                    write8(M, j, 0, read8(M, j, 0) + column * weight[j])
                mode_slope = mode_slope + weight
            else:
                Wk = read8(W, k, 0)
                # After a single update, fast modes lag behind u by the size of the chord step, which would be useless.
                lags = not final_round and h * largest_u > LAG * problem.times[k]
                for _ in range(2 if lags else 1):
                    Wk = refined(problem, scheme, work, k, start, Wk, u, h)
            write8(W, k, 0, Wk)
            psi = psi + E * Wk
        if final_round:
            break
        # Multiplied by psi, which vanishes at the turning point and where the contact may grow again.
        residual = u * psi + past_depth_slope * phi
        if refactor:
            # C = dv/du; the modes' share of psi follows v through their inverses, G, and u itself, M.
            row = (h * u) * F_t
            net = F - external_force
            direct = h * (u * (psi_t - eta * F_t) + past_depth_slope * phi_t)
            for j in range(WIDTH):
                column = read8(A, j, 0)
                change = -h * (column * net[j] + matvec(A, row * column)) - (h * z) * (F_t * column)
                change = matvec(G, change) + read8(M, j, 0) - read8(unit, j, 0) * mode_slope[j]
                write8(J, j, 0, u * change + direct * column + read8(unit, j, 0) * psi[j])
            invert(work.matrices, JACOBIAN)
        step = matvec(J, residual)
        largest_u = largest(absolute(u - step))
        # Time never runs backwards, and the Jacobian divides by u.
        u = at_least(u - step, _LEAST_PACE * largest_u)
        size = largest(absolute(step)) / largest_u
        # The negation catches NaN as well.
        if not size < _LARGEST_STEP:
            return -1
        # After convergence one more round refines the modes with the final unknowns; without it e has errors of 2e-8.
        newton = next_round(newton, size, rounding, accept)
        if newton.verdict == DIVERGED:
            return -1
    write8(work.vectors, UNKNOWN, 0, u)
    write8(table, S_, 1, read8(past, S_, 0))
    write8(table, V_, 1, v)
    write8(table, T_, 1, table[T_, 0] + duration)
    write8(work.vectors, DELAY, 0, elapsed + duration)
    write8(table, F_, 1, F)
    for k in range(N):
        write8(table, MODES_ + 2 * k, 1, read8(X, k, 0))
        write8(table, MODES_ + 1 + 2 * k, 1, read8(W, k, 0))
    return iterations


@compiled
def first_layer(problem: Problem, least: float) -> float:
    """Return the shortest relaxation time of a mode that delays the edge of contact by more than `least`.

    At this time all faster modes have relaxed, so a mode delays the edge by its viscosity over the springs that are
    left: the slower modes and its own. Over all springs, a strong faster mode would hide it.
    """
    N = problem.moduli.shape[0]
    shortest = math.inf
    for k in range(N):
        tau = problem.times[k]
        if tau < shortest:
            springs = problem.equilibrium
            for j in range(N):
                if problem.times[j] >= tau:
                    springs += problem.moduli[j]
            # The delay is E_k tau_k over the springs that have not relaxed at tau_k.
            if problem.moduli[k] * tau > least * springs:
                shortest = tau
    return shortest


@inlined
def elastic_velocity(work: Work) -> float:
    """Least velocity to which the tolerance refers: a share of what the energy at the turning point may give back."""
    # Over the initial kinetic energy: close to 1 for small losses. It is 2/5 F d under a parabola.
    recoverable = 0.8 * work.turning[F_] * work.turning[S_] ** 2
    elastic_share = min(max((recoverable - _LOSSY) / (_NEARLY_ELASTIC - _LOSSY), 0.0), 1.0)
    return (KAPPA + (KAPPA_ELASTIC - KAPPA) * elastic_share) * math.sqrt(recoverable)


@compiled
def first_length(problem: Problem, work: Work, accept: float, counts: float) -> float:
    """Longest first element that resolves all modes that matter, if a velocity of `counts` matters at the end."""
    velocity = _MATTERS * accept * min(elastic_velocity(work), counts)
    layer = first_layer(problem, max(velocity / work.turning[F_], _LEAST_DELAY))
    return _OF_RELAXATION * layer / (2.0 * work.turning[S_])


@compiled
def turning_slope(scheme: Scheme, work: Work) -> float:
    """Return the rate of the velocity over -sigma at the turning point."""
    last = work.counts[N_APPROACH]
    length, v = work.places[LENGTH, last], work.approach[last, V_]
    slopes = work.vectors[VALUES]
    for j in range(WIDTH + 1):
        slopes[j] = product(scheme.derivative[j], v)
    return -value(scheme, work, slopes, (work.turning_place[0] - work.places[START, last]) / length) / length


@compiled
def rebound(problem: Problem, scheme: Scheme, work: Work, tolerance: float, accept: float, counts: float) -> int:
    """Solve the rebound from the turning state to separation; store it in `work.rebound`.

    `counts` is the velocity at its end that matters, infinite if it is unknown.
    """
    S = WIDTH
    N = problem.moduli.shape[0]
    rows = work.turning.shape[0]
    exponent = -1.0 / (S + 1.0)
    sigma_m = work.turning_place[0]
    work.counts[N_REBOUND] = 0
    element = work.counts[N_REBOUND]
    hint = work.counts[N_APPROACH]
    table = work.rebound[0]
    for n in range(rows):
        table[n, 0] = work.turning[n]
    # The interpolated velocity at the turning point is rounding.
    table[V_, 0] = 0.0
    s_m = work.turning[S_]
    h = min(work.places[LENGTH, max(hint - 1, 0)], sigma_m)
    for k in range(N):
        table[MODES_ + 2 * k, 0] = 1.0
    amplitude = elastic_velocity(work)
    h = min(h, first_length(problem, work, accept, counts))
    kink = work.counts[N_APPROACH]
    rough_end = problem.path.exponent > 0.0 and problem.path.exponent not in (1.0, 2.0)
    position = 0.0
    delay = 0.0
    attempts = 0
    previous = 0.0
    while True:
        attempts += 1
        if element >= work.rebound.shape[0] - 1 or attempts > ATTEMPTS * work.rebound.shape[0]:
            return TOO_MANY_STEPS
        # Under a constant force the contact may grow again. There psi vanishes, dt/dlambda diverges as the inverse
        # root of the distance in lambda, and rounding would stop the elements before that instant.
        paused = element > 0 and work.slopes[element - 1, S - 1] > _PAUSE * s_m
        if problem.external_force > 0.0 and paused and h < _PAUSE_LENGTH * sigma_m:
            return CAPTURED
        table = work.rebound[element]
        # Under a constant force even a body without energy is driven on.
        if problem.external_force == 0.0 and is_held(problem, table[V_, 0], table[F_, 0], s_m):
            work.counts[N_REBOUND] = element - 1
            return SINKS_IN if problem.equilibrium == 0.0 else CAPTURED
        if not h > _SHORTEST * sigma_m:
            return STEP_TOO_SMALL
        left = sigma_m - position
        # Elements end where the approach passed a kink.
        while kink > 0 and (work.places[AT_KINK, kink] == 0.0 or work.places[START, kink] >= left):
            kink -= 1
        ahead = left - work.places[START, kink] if kink > 0 else left
        if kink > 0 and h > ahead - work.places[LENGTH, kink]:
            # Beyond a kink, elements are no longer than those of the approach.
            beyond = work.places[LENGTH, kink]
            h = min(h, ahead) if ahead <= _BEYOND_KINK * beyond else min(h, max(0.5 * ahead, ahead - beyond))
        ends = h >= _WHOLE * ahead
        final = ends and kink == 0
        if ends:
            h = ahead
        elif h > _HALVED * ahead and kink == 0:
            h = 0.5 * ahead
        sigma = left - h * read8(scheme.c, 1)
        # Rounding of the last place must not lie before first touch.
        if final:
            sigma = at_least(sigma, 0.0)
        place = interpolate_lanes(scheme, work, work.approach, sigma, hint, work.past)
        if position + h < _NEAR * sigma_m:
            # So close to its zero, the interpolated velocity is rounding.
            way = position + h * read8(scheme.c, 1)
            write8(work.past, V_, 0, turning_slope(scheme, work) * way)
        a, Pi = radii_and_integrals(problem.path, read8(work.past, S_, 0), work.vectors[VALUES:])
        write8(work.vectors, RADIUS, 0, a)
        write8(work.vectors, INTEGRAL, 0, Pi)
        _predict(problem, scheme, work, element, h, previous)
        iterations = rebound_element(problem, scheme, work, table, h, delay, accept)
        work.counts[N_FACTOR] += 1
        # Behind the turning point the edge of contact retreats no faster than it advanced, and all the time. Newton's
        # method can find another root, or end where u is kept above zero.
        paces = read8(work.vectors, UNKNOWN, 0)
        most = largest(paces)
        astray = element == 0 and not (smallest(paces) > _STANDSTILL * most and most < _MOST_PACE * s_m)
        if iterations < 0 or astray:
            h *= ON_FAILURE
            continue
        scale = max(abs(table[V_, S]), amplitude)
        # The duration follows from the pace: after a long contact a difference of times would be rounding.
        duration = work.vectors[VALUES]
        duration[0] = 0.0
        write8(duration, 1, h * matvec(scheme.columns, read8(work.vectors, UNKNOWN, 0)))
        # An error of the time shifts the rest of the rebound, which changes the velocity by F dt. The time itself has
        # the rounding of a place over the length of the element.
        late = tail(scheme, duration)
        rough = ends and (kink > 0 or rough_end)
        weight = max(tolerance / (KINK_TAIL * accept), 1.0) if rough else 1.0
        error = max(tail(scheme, table[V_]), TIME_WEIGHT * table[F_, 0] * late) / (tolerance * scale)
        error = max(weight * error, late / (table[T_, S] * max(tolerance, _PLACE_ROUNDING * sigma_m / h)))
        if problem.path.exponent < 0.0:
            rough = missed_rebound(problem, scheme, work, table, left, h, hint, TABLE_NOISE * accept + LEAST_NOISE)
            error = max(error, rough / (ROUGH * accept * scale))
        if not error <= 1.0:
            h *= shrunk(error, exponent)
            continue
        work.places[BACK_START, element] = position
        work.places[BACK_LENGTH, element] = h
        write8(work.slopes, element, 0, read8(work.vectors, UNKNOWN, 0))
        previous = h
        hint = place
        delay = work.vectors[DELAY, S - 1]
        # The body turns inwards before the contact has ended.
        if problem.external_force > 0.0 and table[V_, S] >= 0.0:
            return CAPTURED
        if final:
            break
        position += h
        # The exact place of the kink: a sum of lengths would miss it by rounding.
        if ends:
            position = sigma_m - work.places[START, kink]
            kink -= 1
        element += 1
        for n in range(rows):
            work.rebound[element, n, 0] = table[n, S]
        h *= grown(error, exponent)
    work.counts[N_REBOUND] = element
    return SEPARATED


@compiled
def _relaxed_share(problem: Problem, ahead: float) -> float:
    """Time D/E of the dashpot and the springs of `_predict`, if the approach takes the time `ahead` up to its end."""
    t = ahead
    ratio = 0.0
    for _ in range(_SHARES):
        springs, dashpot = problem.equilibrium, problem.viscosity
        for k in range(problem.moduli.shape[0]):
            # A mode that is slower than the way back is a spring, a faster one a dashpot.
            if problem.times[k] > t:
                springs += problem.moduli[k]
            else:
                dashpot += problem.moduli[k] * problem.times[k]
        ratio = dashpot / max(springs, _LEAST_SPRING)
        # The time back to equal contact, from dt/dt1 = t1/(t1^2 + ratio^2)^(1/2).
        t = ahead * (ahead / (ratio + math.sqrt(ratio * ratio + ahead * ahead)))
    return ratio


@compiled
def _predict(problem: Problem, scheme: Scheme, work: Work, element: int, h: float, previous: float) -> None:
    """Predict u = dt/dlambda at the nodes by extrapolation of u/s1 from the last element.

    Behind the turning point v1 = F t1 and v = -F t. Modes that have relaxed are a dashpot D beside the springs E of
    the others: (E t + D) dt = E t1 dt1, so that dt/dt1 = t1/(t1^2 + (D/E)^2)^(1/2).
    """
    s1 = at_least(read8(work.past, S_, 0), _LEAST_S)
    if element == 0:
        v1 = at_least(read8(work.past, V_, 0), 0.0)
        late = _relaxed_share(problem, 2.0 * work.turning[S_] * h) * (work.turning[F_] - problem.external_force)
        pace = 2.0 * s1
        # Without dashpots the edge returns as it came, u = 2 s1.
        if late > 0.0:
            pace = pace * v1 / root(v1 * v1 + late * late)
        write8(work.vectors, UNKNOWN, 0, pace)
        return
    ratios = work.vectors[VALUES]
    write8(ratios, 0, read8(work.slopes, element - 1, 0) / read8(work.rebound, element - 1, S_, 1))
    x = 1.0 + (h / previous) * read8(scheme.c, 1)
    end = ratios[WIDTH - 1]
    if h <= _FARTHEST * previous:
        lagrange_lanes(scheme.c[1:], scheme.extrapolation, WIDTH, x, work.basis)
        ratio = combine(work.basis, WIDTH, ratios)
    else:
        # After a large change of the length: a parabola through the ends and the middle.
        middle = WIDTH // 2
        x0, x1 = scheme.c[1], scheme.c[middle + 1]
        first = (ratios[middle] - ratios[0]) / (x1 - x0)
        second = ((end - ratios[middle]) / (1.0 - x1) - first) / (1.0 - x0)
        ratio = ratios[0] + (x - x0) * (first + (x - x1) * second)
    # u/s1 is nearly constant over neighbouring elements; a polynomial that leaves this range is no guess.
    if not (smallest(ratio) > end / _MOST_CHANGE and largest(ratio) < _MOST_CHANGE * end):
        ratio = broadcast(end)
    write8(work.vectors, UNKNOWN, 0, ratio * s1)
