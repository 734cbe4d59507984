"""One impact, and blocks of them: step control, turning point, separation."""

import math
from typing import Any, NamedTuple

from restitution.kernel.approach import approach_element
from restitution.kernel.compile import kernel, part, stage
from restitution.kernel.dense import combine, lagrange, lagrange_lanes, times
from restitution.kernel.lanes import WIDTH, at_least, from_lane, largest, load, smallest, spread, store, total
from restitution.kernel.path import Path, radii_and_integrals, radius_and_integral
from restitution.kernel.radau import Scheme
from restitution.kernel.rebound import rebound_element
from restitution.kernel.workspace import (
    BACK_LENGTH,
    BACK_START,
    BASIS,
    DELAY,
    F_,
    INTEGRAL,
    LENGTH,
    MODES_,
    N_APPROACH,
    N_FACTOR,
    N_REBOUND,
    S_,
    START,
    T_,
    UNKNOWN,
    V_,
    VALUES,
    Work,
)

MAX_ELEMENTS = 2000
# Share of the elastic amplitude at the turning point to which the tolerance of the rebound refers at least: of a
# body that loses much, and of one that loses little.
KAPPA, KAPPA_ELASTIC = 0.03, 0.3
# Weight of an error of the time in the rebound, as F dt, beside that of the velocity.
TIME_WEIGHT = 0.4
# Weight of an error of the force in the approach, times the scale of the depth.
FORCE_WEIGHT = 0.1
# Factor by which the tail counts more where fast modes carry all of the force.
STIFF = 15.0
# How often a solve that fails is tried, each time with a finer tolerance.
_TRIALS = 5
# First step over the scale of s.
FIRST = 0.35

# Status codes; `restitution.impact.status` gives them names and words.
SEPARATED, SINKS_IN, CAPTURED, TOO_MANY_STEPS, STEP_TOO_SMALL, NOT_FINITE, TOO_DEEP = 0, 1, 2, 3, 4, 5, 7

# Columns of an outcome.
OUTCOME = (
    "restitution_coefficient",
    "contact_time",
    "max_indentation_depth",
    "max_force",
    "max_contact_radius",
    "residual_indentation_depth",
    "turning_time",
    "status",
    "factorisations",
)


class Problem(NamedTuple):
    """One impact in units in which mass and impact velocity are 1, d = s^2 and a = a(s).

    F = equilibrium Pi + viscosity a v + sum moduli_k Y_k, and v' = -(F - load).
    """

    equilibrium: float
    moduli: Any
    times: Any
    viscosity: float
    load: float
    path: Path


@part
def interpolate(scheme: Scheme, work: Work, table: Any, x: float, row: Any) -> None:
    """Write the rows of an element at x into `row`."""
    basis = work.vectors[BASIS]
    lagrange(scheme.c, scheme.weights, WIDTH + 1, x, basis)
    for n in range(row.shape[0]):
        row[n] = basis[0] * table[n, 0] + total(load(basis, 1) * load(table[n], 1))


@part
def interpolate_lanes(scheme: Scheme, work: Work, tables: Any, sigma: Any, hint: int, rows: Any) -> int:
    """Write the rows of the approach at eight falling sigma into `rows`; return the element of the last.

    `tables` holds the elements of the approach. The search for the element of the first starts at `hint`.
    """
    lane = 0
    place = hint
    while lane < WIDTH:
        place = seek(work.places, place, sigma[lane])
        start, length = work.places[START, place], work.places[LENGTH, place]
        lagrange_lanes(scheme.c, scheme.weights, WIDTH + 1, (sigma - start) / length, work.basis)
        table = tables[place]
        for n in range(rows.shape[0]):
            value = combine(work.basis, WIDTH + 1, table[n])
            if lane > 0:
                value = from_lane(lane, value, load(rows[n], 0))
            store(rows[n], 0, value)
        lane += 1
        while lane < WIDTH and (place == 0 or sigma[lane] >= start):
            lane += 1
    return place


@part
def seek(places: Any, element: int, sigma: float) -> int:
    """Element of the approach that holds sigma, searched from `element` down."""
    while element > 0 and sigma < places[START, element]:
        element -= 1
    return element


@part
def _tail(scheme: Scheme, row: Any) -> float:
    """Size of the last two Legendre coefficients of a row over an element, the second to last with weight 0.05."""
    values = load(row, 1)
    before = scheme.tail[0, 0] * row[0] + total(load(scheme.tail[0], 1) * values)
    last = scheme.tail[1, 0] * row[0] + total(load(scheme.tail[1], 1) * values)
    return abs(last) + 0.05 * abs(before)


@part
def _value(scheme: Scheme, work: Work, row: Any, x: float) -> float:
    """Value at x of the interpolant of a row over an element."""
    basis = work.vectors[BASIS]
    lagrange(scheme.c, scheme.weights, WIDTH + 1, x, basis)
    return basis[0] * row[0] + total(load(basis, 1) * load(row, 1))


@stage
def _zero_of_velocity(scheme: Scheme, work: Work, row: Any) -> float:
    """Where in [0, 1] the velocity of an approach element passes zero (bracketed secant)."""
    low, high = 0.0, 1.0
    f_low, f_high = row[0], row[WIDTH]
    x = 0.5
    for _ in range(100):
        x = low + (high - low) * f_low / (f_low - f_high)
        x = min(max(x, low + 0.01 * (high - low)), high - 0.01 * (high - low))
        f = _value(scheme, work, row, x)
        if f > 0.0:
            low, f_low = x, f
        else:
            high, f_high = x, f
        if abs(f) < 1e-17 or high - low < 1e-15:
            break
    return x


@part
def _predict_approach(problem: Problem, scheme: Scheme, work: Work, element: int, h: float) -> None:
    """Predict s at the nodes: the last element continued, or a parabola after a jump of the step."""
    table = work.approach[element]
    s0, v0 = table[S_, 0], table[V_, 0]
    slope = -2.0 * s0 * (table[F_, 0] - problem.load)
    ratio = 0.0 if element == 0 else h / work.places[LENGTH, element - 1]
    x = h * load(scheme.c, 1)
    s = spread(0.0)
    if 0.0 < ratio <= 2.5:
        lagrange_lanes(scheme.c, scheme.weights, WIDTH + 1, 1.0 + ratio * load(scheme.c, 1), work.basis)
        s = combine(work.basis, WIDTH + 1, work.approach[element - 1, S_])
    if not smallest(s) > 0.2 * s0:
        s = s0 + x * (v0 + (0.5 * slope) * x)
    if not smallest(s) > 0.2 * s0:
        s = s0 + (0.1 * abs(v0)) * x
    store(work.vectors[UNKNOWN], 0, s)


@stage
def approach(
    problem: Problem, scheme: Scheme, work: Work, tolerance: float, accept: float, first: float
) -> int:
    """Solve the approach up to the turning point; leave it in `work.approach` and the turning state in `work.turning`."""
    S = WIDTH
    rows = work.turning.shape[0]
    exponent = -1.0 / (S + 1.0)
    h = first
    # a(s) of parabola, cone and flat punch is smooth at s = 0; elsewhere the first element is no better than its tail.
    exact_start = problem.path.exponent in (0.0, 1.0, 2.0)
    force_scale = FORCE_WEIGHT * (first / FIRST) ** 2
    if not exact_start:
        h *= 0.1
    # Read back, as numba would compile for a constant 0 what it compiles for all numbers.
    work.counts[N_APPROACH] = 0
    element = work.counts[N_APPROACH]
    table = work.approach[0]
    for n in range(rows):
        table[n, 0] = 0.0
    table[V_, 0] = 1.0
    for n in range(MODES_ + 1, rows, 2):
        table[n, 0] = 1.0
    # A flat face meets a dashpot at once.
    table[F_, 0] = problem.viscosity * radius_and_integral(problem.path, 0.0)[0]
    sigma = 0.0
    attempts = 0
    while True:
        attempts += 1
        if element >= work.approach.shape[0] - 1 or attempts > 4 * work.approach.shape[0]:
            return TOO_MANY_STEPS
        if not h > 1e-15 * sigma + 1e-150:
            return STEP_TOO_SMALL
        table = work.approach[element]
        if element > 0:
            slope = -2.0 * table[S_, 0] * (table[F_, 0] - problem.load)
            if slope < 0.0:
                h = min(h, 1.35 * table[V_, 0] / -slope)
        if problem.path.exponent < 0.0:
            # Never far beyond the end of the table, where its polynomials mean nothing.
            end = problem.path.end
            if table[S_, 0] > end:
                return TOO_DEEP
            h = min(h, 0.01 * end + (end - table[S_, 0]) / table[V_, 0])
        _predict_approach(problem, scheme, work, element, h)
        iterations = approach_element(problem, scheme, work, table, h, accept)
        work.counts[N_FACTOR] += 1
        if iterations < 0:
            h *= 0.3
            continue
        # What may come back, down to where the tolerance of e asks for no more digits, or rounding leaves none.
        amplitude = min(math.sqrt(table[V_, S] ** 2 + max(table[F_, S], 0.0) * table[S_, S] ** 2), 1.0)
        allowed = max(tolerance * amplitude, min(0.02 * accept, 1e-13))
        # Where modes faster than the step carry the force, the order of the method falls to that of its stages, and
        # the error at the end of the element is as large as inside: measured, the tail then is 1/10 of it.
        stiff = 0.0
        for k in range(problem.moduli.shape[0]):
            z = 2.0 * h * table[S_, S] / problem.times[k]
            stiff += problem.moduli[k] * table[MODES_ + 2 * k, S] * z / (z + 10.0)
        stiff = min(abs(stiff) / max(table[F_, S], 1e-300), 1.0)
        error = (1.0 + STIFF * stiff) * _tail(scheme, table[V_]) / allowed
        if element == 0 and not exact_start:
            error *= 20.0 * tolerance / accept
        # The velocity alone does not tell where the force between the nodes is rough, as at the edge of a flat end.
        error = max(error, force_scale * _tail(scheme, table[F_]) / tolerance)
        if not error <= 1.0:
            h *= max(0.1, 0.75 * error**exponent) if error < math.inf else 0.1
            continue
        work.places[START, element] = sigma
        work.places[LENGTH, element] = h
        if table[V_, S] <= 0.0:
            break
        sigma += h
        element += 1
        for n in range(rows):
            work.approach[element, n, 0] = table[n, S]
        # A constant force that the foundation balances all along an element: what moves on is creep, which never turns.
        rest = 1e-7 * problem.load
        creeps = abs(table[F_, 0] - problem.load) < rest and abs(table[F_, S] - problem.load) < rest
        # What the tolerance of e cannot tell; a force that does not fade with the velocity would drive the body back.
        least = 0.02 * accept
        fades = 2.0 * table[F_, S] * table[V_, 0] < table[F_, 0] * least
        slow = table[V_, S] < 1e-14 or (fades and 2.0 * table[V_, S] < least)
        stops = problem.equilibrium == 0.0 and (creeps or slow)
        if stops or (creeps and table[V_, S] < 1e-6):
            for n in range(rows):
                work.turning[n] = table[n, S]
            work.counts[N_APPROACH] = element - 1
            work.turning_place[0] = sigma
            return SINKS_IN if stops else CAPTURED
        h *= min(6.0, 0.75 * max(error, 1e-30) ** exponent)
    x = _zero_of_velocity(scheme, work, table[V_])
    sigma += x * h
    interpolate(scheme, work, table, x, work.turning)
    work.counts[N_APPROACH] = element
    work.turning_place[0] = sigma
    return SEPARATED


@stage
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
    share = min(max((recoverable - 0.6) / 0.3, 0.0), 1.0)
    amplitude = (KAPPA + (KAPPA_ELASTIC - KAPPA) * share) * math.sqrt(recoverable)
    for k in range(N):
        if work.turning[F_] * problem.times[k] * problem.moduli[k] > 0.1 * tolerance * amplitude * glass:
            h = min(h, 0.7 * problem.times[k] / (2.0 * s_m))
    position = 0.0
    delay = 0.0
    attempts = 0
    previous = 0.0
    while True:
        attempts += 1
        if element >= work.rebound.shape[0] - 1 or attempts > 4 * work.rebound.shape[0]:
            return TOO_MANY_STEPS
        if not h > 1e-15 * sigma_m:
            # Under a constant force the edge of contact may turn back outwards: q vanishes, dt/dlambda diverges.
            if problem.load > 0.0 and element > 0 and work.slopes[element - 1, S - 1] > 1e3 * s_m:
                return CAPTURED
            return STEP_TOO_SMALL
        left = sigma_m - position
        final = h >= 0.999 * left
        if final:
            h = left
        elif h > 0.6 * left:
            h = 0.5 * left
        table = work.rebound[element]
        sigma = left - h * load(scheme.c, 1)
        if final:
            sigma = at_least(sigma, 0.0)
        place = interpolate_lanes(scheme, work, work.approach, sigma, hint, work.past)
        Pi = radii_and_integrals(problem.path, load(work.past[S_], 0), work.vectors[VALUES:])[1]
        store(work.vectors[INTEGRAL], 0, Pi)
        _predict_rebound(problem, scheme, work, element, h, previous)
        iterations = rebound_element(problem, scheme, work, table, h, delay, accept)
        work.counts[N_FACTOR] += 1
        if iterations < 0:
            h *= 0.3
            continue
        scale = max(abs(table[V_, S]), amplitude)
        # Taken from the pace: as a difference of times it would be rounding after a long contact.
        duration = work.vectors[VALUES]
        duration[0] = 0.0
        store(duration, 1, h * times(scheme.columns, load(work.vectors[UNKNOWN], 0)))
        # An error of the time shifts all that follows, which the force now turns into velocity. The time itself is
        # known to what rounding leaves of a place in a short element.
        tail = _tail(scheme, duration)
        error = max(_tail(scheme, table[V_]), TIME_WEIGHT * table[F_, 0] * tail) / (tolerance * scale)
        error = max(error, tail / (table[T_, S] * max(tolerance, 1e-14 * sigma_m / h)))
        if not error <= 1.0:
            h *= max(0.1, 0.75 * error**exponent) if error < math.inf else 0.1
            continue
        work.places[BACK_START, element] = position
        work.places[BACK_LENGTH, element] = h
        store(work.slopes[element], 0, load(work.vectors[UNKNOWN], 0))
        previous = h
        hint = place
        delay = work.vectors[DELAY, S - 1]
        if problem.load > 0.0 and table[V_, S] >= 0.0:
            return CAPTURED
        if final:
            break
        position += h
        element += 1
        for n in range(rows):
            work.rebound[element, n, 0] = table[n, S]
        h *= min(6.0, 0.75 * max(error, 1e-30) ** exponent)
    work.counts[N_REBOUND] = element
    return SEPARATED


@part
def _predict_rebound(
    problem: Problem, scheme: Scheme, work: Work, element: int, h: float, previous: float
) -> None:
    """Predict u = dt/dlambda at the nodes: u/s1 of the last element continued.

    At the turning point, where X_k = 1: -q = phi v1 + eta (F - w), so that u -> 2 s1 unless a dashpot acts.
    """
    s1 = at_least(load(work.past[S_], 0), 1e-12)
    if element == 0:
        braking = problem.viscosity * (work.turning[F_] - problem.load)
        share = spread(1.0)
        if braking > 0.0:
            glass = problem.equilibrium
            for k in range(problem.moduli.shape[0]):
                glass += problem.moduli[k]
            driving = glass * at_least(load(work.past[V_], 0), 0.0)
            share = driving / (driving + braking)
        store(work.vectors[UNKNOWN], 0, 2.0 * s1 * share)
        return
    ratios = work.vectors[VALUES]
    store(ratios, 0, load(work.slopes[element - 1], 0) / load(work.rebound[element - 1, S_], 1))
    x = 1.0 + (h / previous) * load(scheme.c, 1)
    end = ratios[WIDTH - 1]
    if h <= 2.0 * previous:
        lagrange_lanes(scheme.c[1:], scheme.extrapolation, WIDTH, x, work.basis)
        ratio = combine(work.basis, WIDTH, ratios)
    else:
        # After a jump of the step: a parabola through the ends and the middle.
        middle = WIDTH // 2
        x0, x1 = scheme.c[1], scheme.c[middle + 1]
        first = (ratios[middle] - ratios[0]) / (x1 - x0)
        second = ((end - ratios[middle]) / (1.0 - x1) - first) / (1.0 - x0)
        ratio = ratios[0] + (x - x0) * (first + (x - x1) * second)
    if not (smallest(ratio) > 0.1 * end and largest(ratio) < 10.0 * end):
        ratio = spread(end)
    store(work.vectors[UNKNOWN], 0, ratio * s1)


@stage
def _peak_force(scheme: Scheme, work: Work) -> float:
    """Largest force of the approach: the best node, then its polynomial at eight places at a time."""
    S = WIDTH
    last = work.counts[N_APPROACH]
    best = 0.0
    where = 0
    node = 0
    for element in range(last + 1):
        for j in range(S + 1):
            inside = element < last or work.approach[element, V_, j] >= 0.0
            if inside and work.approach[element, F_, j] > best:
                best, where, node = work.approach[element, F_, j], element, j
    best = max(best, work.turning[F_])
    for element in range(max(where - 1, 0), min(where + 1, last) + 1):
        if element != where and not ((node == 0 and element < where) or (node == S and element > where)):
            continue
        row = work.approach[element, F_]
        high = 1.0
        if element == last:
            high = (work.turning_place[0] - work.places[START, element]) / work.places[LENGTH, element]
        low = 0.0
        if element == where:
            if node > 0:
                low = scheme.c[node - 1]
            if node < S:
                high = min(high, scheme.c[node + 1])
        for _ in range(12):
            x = low + (high - low) * load(scheme.c, 1)
            lagrange_lanes(scheme.c, scheme.weights, S + 1, x, work.basis)
            F = combine(work.basis, S + 1, row)
            top = 0
            for j in range(1, S):
                if F[j] > F[top]:
                    top = j
            best = max(best, F[top])
            low, high = (x[top - 1] if top > 0 else low), x[min(top + 1, S - 1)]
    return best


@stage
def _resting_place(problem: Problem, s: float) -> float:
    """Where the foundation alone carries the load, at s or deeper; 0 beyond the end of a table."""
    low, high = s, s
    while problem.equilibrium * radius_and_integral(problem.path, high)[1] < problem.load:
        low, high = high, 1.5 * high
        if high > problem.path.end:
            return 0.0
    for _ in range(60):
        middle = 0.5 * (low + high)
        if problem.equilibrium * radius_and_integral(problem.path, middle)[1] < problem.load:
            low = middle
        else:
            high = middle
    return high


@kernel
def solve_block(
    scheme: Scheme,
    tolerance: float,
    accept: float,
    firsts: Any,
    equilibria: Any,
    viscosities: Any,
    loads: Any,
    offsets: Any,
    moduli: Any,
    times: Any,
    path: Path,
    work: Work,
    outcomes: Any,
) -> None:
    """Solve a block of impacts that share a profile; row n has the modes offsets[n] to offsets[n + 1].

    Parameters
    ----------
    scheme : Scheme
        Collocation scheme.
    tolerance, accept : float
        Error of an element, and the largest last step of the Newton iteration.
    firsts : ndarray, shape (n,)
        Scale of s of each impact.
    equilibria, viscosities, loads : ndarray, shape (n,)
        See `Problem`.
    offsets : ndarray of int, shape (n + 1,)
        Where each row's modes begin.
    moduli, times : ndarray
        The modes of all rows.
    path : Path
        The profile.
    work : Work
        Scratch space for the largest number of modes of a row; holds the stored halves of the last impact afterwards.
    outcomes : ndarray, shape (n, 9)
        Written: columns `OUTCOME`; NaN where there is no result.
    """
    for n in range(offsets.shape[0] - 1):
        low, high = offsets[n], offsets[n + 1]
        problem = Problem(equilibria[n], moduli[low:high], times[low:high], viscosities[n], loads[n], path)
        outcome = outcomes[n]
        for column in range(outcome.shape[0]):
            outcome[column] = math.nan
        work.counts[N_FACTOR] = 0
        status = TOO_MANY_STEPS
        finer, sharper = tolerance, accept
        if high > low and viscosities[n] > 0.0:
            # Modes follow the force that the dashpot makes at once: such kinks inside elements are errors at their end.
            finer = min(finer, max(2.0 * accept, 1e-13))
        elif high > low and radius_and_integral(path, 0.0)[0] > 0.0:
            # The same of fast modes under a flat face, which is met at full width.
            finer = min(finer, max(200.0 * accept, 1e-12))
        weighed = loads[n] == 0.0
        trial = 0
        while trial < _TRIALS:
            trial += 1
            status = approach(problem, scheme, work, finer, sharper, FIRST * firsts[n])
            # A constant force drives a body into a liquid for ever; without one it comes to rest.
            if status in (SEPARATED, CAPTURED) or (status == SINKS_IN and loads[n] == 0.0):
                s = work.turning[S_]
                outcome[3] = _peak_force(scheme, work)
                if status == CAPTURED:
                    s = _resting_place(problem, s)
                    if not s > 0.0:
                        status = TOO_DEEP
                    outcome[3] = max(outcome[3], loads[n])
                outcome[2] = s * s
                outcome[4] = radius_and_integral(problem.path, s)[0]
                outcome[6] = work.turning[T_]
                if status != SEPARATED:
                    outcome[5] = s * s
            if status == SEPARATED:
                status = rebound(problem, scheme, work, finer, sharper)
            if status == SEPARATED and not weighed:
                # The work of a weight passes through the velocity in between, whose error e feels enlarged.
                weighed = True
                e = max(-work.rebound[work.counts[N_REBOUND], V_, WIDTH], 1e-3)
                enlarged = (1.0 + 2.0 * loads[n] * outcome[2]) / (e * e)
                if enlarged > 2.0:
                    finer, sharper = max(tolerance / enlarged, 1e-14), max(accept / enlarged, 2e-14)
                    trial = 0
                    continue
            if status < TOO_MANY_STEPS or status == TOO_DEEP:
                break
            # Coarse elements may leave a turning point from which no rebound starts; finer ones do not. Where a tenth of
            # rtol is asked for, because of kinks, half of it will do should rounding be in the way.
            finer *= 5.0 if trial == 1 and finer < 3.0 * accept else 0.1
        if status == SEPARATED:
            last = work.counts[N_REBOUND]
            outcome[0] = -work.rebound[last, V_, WIDTH]
            outcome[1] = work.rebound[last, T_, WIDTH]
            depth = outcome[2]
            for element in range(last + 1):
                speed = load(work.slopes[element], 0) * load(work.rebound[element, V_], 1)
                depth += work.places[BACK_LENGTH, element] * total(load(scheme.A[WIDTH - 1], 0) * speed)
            outcome[5] = depth
            # By what an elastic body exceeds what the force has given it, is error.
            outcome[0] = min(outcome[0], math.sqrt(max(1.0 + 2.0 * loads[n] * depth, 0.0)))
        elif status in (SINKS_IN, CAPTURED):
            outcome[0] = 0.0
        outcome[7] = status
        outcome[8] = work.counts[N_FACTOR]
