"""Rebound of the body (Graham, Ting): the stored approach is walked backwards in lambda, index 1 on its values.

    dt/dlambda = u,  u psi + 2 s1 v1 phi = 0,  phi = E + sum E_k X_k,  X_k = exp(-(t - t1)/tau_k),
    psi = E v - eta (F - w) + sum E_k [W_k + X_k (v1 - W1_k)],  F = E Pi1 + sum E_k X_k Y1_k,
    dv/dlambda = -(F - w) u,  dW_k/dlambda = -(u/tau_k) W_k + dv/dlambda.

The unknown is u at the nodes; nothing is divided by psi. The first line is 0/0 at lambda = 0, where no node lies.
Stored elements hold s1, v, t, F and, of each mode, X_k and W_k.
"""

import math
from typing import Any

from restitution.kernel.approach import ATTEMPTS, KINK_TAIL, LAG, LEAST_NOISE, ROUGH, TABLE_NOISE
from restitution.kernel.compile import compiled, inlined
from restitution.kernel.control import CONVERGED, DIVERGED, FACTOR, ON_FAILURE, grown, newton_verdict, shrunk
from restitution.kernel.dense import combine, interpolate_lanes, invert, invert_modes, lagrange_lanes, matvec, tail
from restitution.kernel.kinks import missed_rebound
from restitution.kernel.lanes import WIDTH, absolute, at_least, broadcast, exp, largest, read8, smallest, write8
from restitution.kernel.outcome import CAPTURED, SEPARATED, STEP_TOO_SMALL, TOO_MANY_STEPS
from restitution.kernel.path import radii_and_integrals
from restitution.kernel.radau import Scheme
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

# Newton's method: size of a step below which it may be rounding, at most and over the velocity of the approach, of
# which little is left at the turning point, and the least such velocity; rounds in all; largest step and least u over
# the largest u.
ROUNDING, NOISE, _LEAST_VELOCITY = 1e-9, 1e-14, 1e-12
_MOST_ITERATIONS = 14
_LARGEST_STEP, _LEAST_PACE = 1e3, 1e-9
# First guess: least s1; longest element over the last one that continues the polynomial of u/s1; factor to both sides
# by which u/s1 may change.
_LEAST_S, _FARTHEST, _MOST_CHANGE = 1e-12, 2.0, 10.0
# Share of the elastic amplitude at the turning point to which the tolerance of the rebound refers at least: of a body
# whose elastic energy there is below `_LOSSY` of the kinetic energy before, and of one where it is above
# `_NEARLY_ELASTIC`.
KAPPA, KAPPA_ELASTIC = 0.03, 0.3
_LOSSY, _NEARLY_ELASTIC = 0.6, 0.9
# Weight of an error of the time, as F dt, beside that of the velocity; rounding of a place over the length of an
# element.
TIME_WEIGHT, _PLACE_ROUNDING = 0.4, 1e-14
# Length of an element: the first, over the shortest relaxation time that matters and the share of the force's
# tolerance from which a mode matters; the shortest over sigma at the turning point; share of the rest from which it is
# one element, and share from which it is two halves; factor to which a length beyond a kink is exceeded.
_OF_RELAXATION, _MATTERS = 0.7, 0.1
_SHORTEST, _WHOLE, _HALVED, _BEYOND_KINK = 1e-15, 0.999, 0.6, 1.01
# Capture: dt/dlambda over s at the turning point, and length of an element over sigma there, where the edge turns
# outwards.
_PAUSE, _PAUSE_LENGTH = 1e3, 1e-9


@inlined
def rebound_element(
    problem: Problem, scheme: Scheme, work: Work, table: Any, h: float, delay: float, accept: float
) -> int:
    """Solve one element of length h from the first column of `table` and t - t1 = `delay`; fill the others.

    `work.vectors[UNKNOWN]` holds the predicted u at the nodes, `work.past` the stored approach there and
    `work.vectors[INTEGRAL]` its Pi; `work.vectors[DELAY]` receives t - t1. Returns the number of Newton iterations, or
    -1 where they do not converge.
    """
    A, unit = scheme.columns, scheme.identity
    N = problem.moduli.shape[0]
    B, X, W, past = work.inverses, work.modes[0], work.modes[1], work.past
    J, G, M = work.matrices[JACOBIAN], work.matrices[SUM], work.matrices[WEIGHTED]
    v0 = table[V_, 0]
    eta, external_force, equilibrium = problem.viscosity, problem.external_force, problem.equilibrium
    v1, r1 = read8(past, V_, 0), 2.0 * read8(past, S_, 0)
    past_depth_slope = r1 * v1
    # Integrated by itself: as a difference of times it would lose the digits that fast modes feel.
    elapsed = delay + h * matvec(A, r1)
    Pi = read8(work.vectors, INTEGRAL, 0)
    u = read8(work.vectors, UNKNOWN, 0)
    rounding = ROUNDING + NOISE / max(v1[WIDTH - 1], _LEAST_VELOCITY)
    previous = math.inf
    largest_u = 0.0
    drift = 0.0
    refactor = True
    renewed = False
    final_round = False
    iterations = 0
    while True:
        iterations += 1
        if iterations > _MOST_ITERATIONS:
            return -1
        duration = h * matvec(A, u)
        F = equilibrium * Pi
        phi = broadcast(equilibrium)
        memory = broadcast(0.0)
        phi_t = broadcast(0.0)
        F_t = broadcast(0.0)
        psi_t = broadcast(0.0)
        for k in range(N):
            inverse = 1.0 / problem.times[k]
            x = exp(at_least((elapsed + duration) * -inverse, -700.0))
            write8(X, k, 0, x)
            x = problem.moduli[k] * x
            force_k = x * read8(past, MODES_ + 2 * k, 0)
            memory_k = x * (v1 - read8(past, MODES_ + 1 + 2 * k, 0))
            F = F + force_k
            phi = phi + x
            memory = memory + memory_k
            if refactor:
                F_t = F_t - force_k * inverse
                phi_t = phi_t - x * inverse
                psi_t = psi_t - memory_k * inverse
        v = v0 - h * matvec(A, (F - external_force) * u)
        psi = equilibrium * v - eta * (F - external_force) + memory
        mode_slope = broadcast(0.0)
        if refactor:
            for k in range(N):
                rate = (h / problem.times[k]) * u
                for j in range(WIDTH):
                    write8(B, k, j, 0, read8(unit, j, 0) + read8(A, j, 0) * rate[j])
            invert_modes(B, N)
            for j in range(WIDTH):
                write8(G, j, 0, equilibrium * read8(unit, j, 0))
                write8(M, j, 0, broadcast(0.0))
        for k in range(N):
            E = problem.moduli[k]
            start = v + (table[MODES_ + 1 + 2 * k, 0] - v0)
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
                # After one round fast modes lag behind u by as much as the chord step, which then says nothing.
                lags = not final_round and h * largest_u > LAG * problem.times[k]
                for _ in range(2 if lags else 1):
                    defect = start - Wk - (h / problem.times[k]) * matvec(A, u * Wk)
                    Wk = Wk + matvec(B[k], defect)
            write8(W, k, 0, Wk)
            psi = psi + E * Wk
        if final_round:
            break
        residual = u * psi + past_depth_slope * phi
        if refactor:
            # C = dv/du; the modes' share of psi follows v through their inverses, G, and u itself, M.
            row = (h * u) * F_t
            net = F - external_force
            direct = h * (u * (psi_t - eta * F_t) + past_depth_slope * phi_t)
            for j in range(WIDTH):
                column = read8(A, j, 0)
                change = -h * (column * net[j] + matvec(A, row * column))
                change = matvec(G, change) + read8(M, j, 0) - read8(unit, j, 0) * mode_slope[j]
                write8(J, j, 0, u * change + direct * column + read8(unit, j, 0) * psi[j])
            invert(work.matrices, JACOBIAN)
        step = matvec(J, residual)
        largest_u = largest(absolute(u - step))
        u = at_least(u - step, _LEAST_PACE * largest_u)
        size = largest(absolute(step)) / largest_u
        if not size < _LARGEST_STEP:
            return -1
        drift = size if refactor else drift
        verdict = newton_verdict(size, previous, drift, refactor, renewed, rounding, accept)
        if verdict == DIVERGED:
            return -1
        if verdict == CONVERGED:
            # One more round refines the modes with the final unknowns: left out, e is off by 2e-8.
            final_round = True
            refactor = False
            continue
        refactor = verdict == FACTOR
        renewed = renewed or (refactor and size < rounding)
        previous = size
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
def rebound(problem: Problem, scheme: Scheme, work: Work, tolerance: float, accept: float) -> int:
    """Solve the rebound from the turning state to separation; leave it in `work.rebound`."""
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
    table[V_, 0] = 0.0
    s_m = work.turning[S_]
    h = min(work.places[LENGTH, max(hint - 1, 0)], sigma_m)
    glass = problem.equilibrium
    for k in range(N):
        table[MODES_ + 2 * k, 0] = 1.0
        glass += problem.moduli[k]
    # Elastic energy at the turning point over the kinetic energy before: near 1 where little is lost.
    recoverable = 0.8 * table[F_, 0] * s_m * s_m
    elastic_share = min(max((recoverable - _LOSSY) / (_NEARLY_ELASTIC - _LOSSY), 0.0), 1.0)
    amplitude = (KAPPA + (KAPPA_ELASTIC - KAPPA) * elastic_share) * math.sqrt(recoverable)
    for k in range(N):
        if work.turning[F_] * problem.times[k] * problem.moduli[k] > _MATTERS * tolerance * amplitude * glass:
            h = min(h, _OF_RELAXATION * problem.times[k] / (2.0 * s_m))
    kink = work.counts[N_APPROACH]
    position = 0.0
    delay = 0.0
    attempts = 0
    previous = 0.0
    while True:
        attempts += 1
        if element >= work.rebound.shape[0] - 1 or attempts > ATTEMPTS * work.rebound.shape[0]:
            return TOO_MANY_STEPS
        # Under a constant force the edge of contact may turn outwards again: psi vanishes, dt/dlambda diverges as the
        # inverse root of the distance to that place. Rounding would stop the elements in front of it.
        paused = element > 0 and work.slopes[element - 1, S - 1] > _PAUSE * s_m
        if problem.external_force > 0.0 and paused and h < _PAUSE_LENGTH * sigma_m:
            return CAPTURED
        if not h > _SHORTEST * sigma_m:
            return STEP_TOO_SMALL
        left = sigma_m - position
        # Elements end where the approach passed a kink.
        while kink > 0 and (work.places[AT_KINK, kink] == 0.0 or work.places[START, kink] >= left):
            kink -= 1
        ahead = left - work.places[START, kink] if kink > 0 else left
        if kink > 0 and h > ahead - work.places[LENGTH, kink]:
            # What the approach could not do in one element beyond a kink cannot be done here either.
            beyond = work.places[LENGTH, kink]
            h = min(h, ahead) if ahead <= _BEYOND_KINK * beyond else min(h, max(0.5 * ahead, ahead - beyond))
        ends = h >= _WHOLE * ahead
        final = ends and kink == 0
        if ends:
            h = ahead
        elif h > _HALVED * ahead and kink == 0:
            h = 0.5 * ahead
        table = work.rebound[element]
        sigma = left - h * read8(scheme.c, 1)
        if final:
            sigma = at_least(sigma, 0.0)
        place = interpolate_lanes(scheme, work, work.approach, sigma, hint, work.past)
        Pi = radii_and_integrals(problem.path, read8(work.past, S_, 0), work.vectors[VALUES:])[1]
        write8(work.vectors, INTEGRAL, 0, Pi)
        _predict(problem, scheme, work, element, h, previous)
        iterations = rebound_element(problem, scheme, work, table, h, delay, accept)
        work.counts[N_FACTOR] += 1
        if iterations < 0:
            h *= ON_FAILURE
            continue
        scale = max(abs(table[V_, S]), amplitude)
        # Taken from the pace: as a difference of times it would be rounding after a long contact.
        duration = work.vectors[VALUES]
        duration[0] = 0.0
        write8(duration, 1, h * matvec(scheme.columns, read8(work.vectors, UNKNOWN, 0)))
        # An error of the time shifts all that follows, which the force now turns into velocity. The time itself is
        # known to what rounding leaves of a place in a short element.
        late = tail(scheme, duration)
        weight = max(tolerance / (KINK_TAIL * accept), 1.0) if ends and kink > 0 else 1.0
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
        if problem.external_force > 0.0 and table[V_, S] >= 0.0:
            return CAPTURED
        if final:
            break
        position += h
        if ends:
            position = sigma_m - work.places[START, kink]
            kink -= 1
        element += 1
        for n in range(rows):
            work.rebound[element, n, 0] = table[n, S]
        h *= grown(error, exponent)
    work.counts[N_REBOUND] = element
    return SEPARATED


@inlined
def _predict(problem: Problem, scheme: Scheme, work: Work, element: int, h: float, previous: float) -> None:
    """Predict u = dt/dlambda at the nodes: u/s1 of the last element continued.

    At the turning point, where X_k = 1: -psi = phi v1 + eta (F - w), so that u -> 2 s1 unless a dashpot acts.
    """
    s1 = at_least(read8(work.past, S_, 0), _LEAST_S)
    if element == 0:
        braking = problem.viscosity * (work.turning[F_] - problem.external_force)
        pace_ratio = broadcast(1.0)
        if braking > 0.0:
            glass = problem.equilibrium
            for k in range(problem.moduli.shape[0]):
                glass += problem.moduli[k]
            contact = glass * at_least(read8(work.past, V_, 0), 0.0)
            pace_ratio = contact / (contact + braking)
        write8(work.vectors, UNKNOWN, 0, 2.0 * s1 * pace_ratio)
        return
    ratios = work.vectors[VALUES]
    write8(ratios, 0, read8(work.slopes, element - 1, 0) / read8(work.rebound, element - 1, S_, 1))
    x = 1.0 + (h / previous) * read8(scheme.c, 1)
    end = ratios[WIDTH - 1]
    if h <= _FARTHEST * previous:
        lagrange_lanes(scheme.c[1:], scheme.extrapolation, WIDTH, x, work.basis)
        ratio = combine(work.basis, WIDTH, ratios)
    else:
        # After a jump of the step: a parabola through the ends and the middle.
        middle = WIDTH // 2
        x0, x1 = scheme.c[1], scheme.c[middle + 1]
        first = (ratios[middle] - ratios[0]) / (x1 - x0)
        second = ((end - ratios[middle]) / (1.0 - x1) - first) / (1.0 - x0)
        ratio = ratios[0] + (x - x0) * (first + (x - x1) * second)
    if not (smallest(ratio) > end / _MOST_CHANGE and largest(ratio) < _MOST_CHANGE * end):
        ratio = broadcast(end)
    write8(work.vectors, UNKNOWN, 0, ratio * s1)
