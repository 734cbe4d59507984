"""Blocks of impacts: approach, rebound, outcome, and further trials after a failure."""

import math
from typing import Any

from restitution.kernel.approach import FIRST, approach
from restitution.kernel.collocation import Scheme, combine, lagrange_lanes
from restitution.kernel.compile import compiled, entry_point
from restitution.kernel.lanes import WIDTH, read8, total
from restitution.kernel.outcome import (
    CAPTURED,
    CONTACT_TIME,
    FACTORISATIONS,
    LEAST_RESTITUTION,
    MAX_DEPTH,
    MAX_FORCE,
    MAX_RADIUS,
    RESIDUAL_DEPTH,
    RESTITUTION,
    SEPARATED,
    SINKS_IN,
    STATUS,
    TOO_DEEP,
    TOO_MANY_STEPS,
)
from restitution.kernel.path import TABLE, radius_and_integral
from restitution.kernel.rebound import first_length, rebound
from restitution.kernel.workspace import (
    BACK_LENGTH,
    F_,
    LENGTH,
    N_APPROACH,
    N_FACTOR,
    N_REBOUND,
    S_,
    START,
    T_,
    V_,
    Problem,
    Problems,
    Work,
    problem_inside,
)

MAX_ELEMENTS = 2000
_TRIALS = 6  # the last one is patient
_FINER = 0.1  # factor of the tolerance after a failed trial
# Factor after a failed first trial whose tolerance was below `_NEAR_ROUNDING` times Newton's, perhaps due to rounding.
_COARSER, _NEAR_ROUNDING = 5.0, 3.0
# Largest tolerance of an element over Newton's, and its lower limit, where elements lose their order: where modes
# follow the immediate force of a dashpot, and where a flat face touches material with fast modes.
_WITH_DASHPOT, _WITH_FLAT_FACE = (2.0, 1e-13), (200.0, 1e-12)
# Factor of the tolerance where a(s) is a table, with bends that are no kinks.
_WITH_TABLE = 0.4
# Impacts under a constant force, or on a target that moves: smallest e, largest amplification of the error without a
# second solve, and smallest tolerances of a second solve.
_LEAST_E, _MOST_ENLARGED, _LEAST_TOLERANCES = 1e-3, 2.0, (1e-12, 2e-14)
# Smallest tolerance of the first solve on a target that moves, and e, over that of a held body, which shows that the
# body is held.
_FIRST_ON_TARGET, _SURELY_HELD = 1e-9, 0.5
_NEARLY_HELD = 4.0  # further amplification where a target takes nearly all energy, much of it before the turning point
_PEAK_ROUNDS = 12  # of the search for the largest force; each divides the interval by about three
_BISECTIONS = 60  # of the search for the depth at rest
_GROWTH = 1.5  # factor by which its interval grows before


@compiled
def _peak_force(scheme: Scheme, work: Work) -> float:
    """Return the largest force of the approach: the largest value at a node, then a search on the polynomial."""
    S = WIDTH
    last = work.counts[N_APPROACH]
    best = 0.0
    where = 0
    node = 0
    for element in range(last + 1):
        for j in range(S + 1):
            # Beyond the turning point the last element is a continuation of the approach, not a part of it.
            inside = element < last or work.approach[element, V_, j] >= 0.0
            if inside and work.approach[element, F_, j] > best:
                best, where, node = work.approach[element, F_, j], element, j
    best = max(best, work.turning[F_])
    for element in range(max(where - 1, 0), min(where + 1, last) + 1):
        # A largest value at the end of an element may rise further in its neighbour.
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
        for _ in range(_PEAK_ROUNDS):
            x = low + (high - low) * read8(scheme.c, 1)
            lagrange_lanes(scheme.c, scheme.weights, S + 1, x, work.basis)
            F = combine(work.basis, S + 1, row)
            top = 0
            for j in range(1, S):
                if F[j] > F[top]:
                    top = j
            best = max(best, F[top])
            low, high = (x[top - 1] if top > 0 else low), x[min(top + 1, S - 1)]
    return best


@compiled
def _resting_place(problem: Problem, s: float) -> float:
    """Place, not before s, at which the foundation alone carries the load; 0 if it is beyond the end of a table."""
    low, high = s, s
    while problem.equilibrium * radius_and_integral(problem.path, high)[1] < problem.external_force:
        low, high = high, _GROWTH * high
        if high > problem.path.end:
            return 0.0
    for _ in range(_BISECTIONS):
        middle = 0.5 * (low + high)
        if problem.equilibrium * radius_and_integral(problem.path, middle)[1] < problem.external_force:
            low = middle
        else:
            high = middle
    return high


@compiled
def _depth_left(scheme: Scheme, work: Work, depth: float) -> float:
    """Return the depth at the end of the stored rebound from that of the turning point."""
    for element in range(work.counts[N_REBOUND] + 1):
        speed = read8(work.slopes, element, 0) * read8(work.rebound, element, V_, 1)
        depth += work.places[BACK_LENGTH, element] * total(read8(scheme.A, WIDTH - 1, 0) * speed)
    return depth


@compiled
def _enlarged(problem: Problem, e: float, depth: float, peak: float) -> float:
    """Return the factor by which e enlarges relative errors of the velocity.

    The work of a constant force makes the velocity in between larger than e. A target that moves takes energy that
    the foundation has at the turning point.
    """
    if problem.external_force > 0.0:
        e = max(e, _LEAST_E)
        return (1.0 + 2.0 * problem.external_force * depth) / (e * e)
    return math.sqrt(peak * depth) / max(e, _LEAST_E)


@compiled
def _first_tolerance(problem: Problem, tolerance: float, accept: float) -> float:
    """Return the tolerance of the elements where they do not lose their order, or the lower one where they do."""
    finer = tolerance * (_WITH_TABLE if problem.path.exponent == TABLE else 1.0)
    modes = problem.moduli.shape[0]
    if modes > 0 and problem.viscosity > 0.0:
        finer = min(finer, max(_WITH_DASHPOT[0] * accept, _WITH_DASHPOT[1]))
    elif modes > 0 and radius_and_integral(problem.path, 0.0)[0] > 0.0:
        finer = min(finer, max(_WITH_FLAT_FACE[0] * accept, _WITH_FLAT_FACE[1]))
    return finer


@compiled
def _there(problem: Problem, scheme: Scheme, work: Work, status: int, outcome: Any) -> int:
    """Write the largest values of an approach that ended with this status; return it, or TOO_DEEP."""
    s = work.turning[S_]
    outcome[MAX_FORCE] = _peak_force(scheme, work)
    if status == CAPTURED:
        s = _resting_place(problem, s)
        if not s > 0.0:
            status = TOO_DEEP
        outcome[MAX_FORCE] = max(outcome[MAX_FORCE], problem.external_force)
    outcome[MAX_DEPTH] = s * s
    outcome[MAX_RADIUS] = radius_and_integral(problem.path, s)[0]
    if status != SEPARATED:
        outcome[RESIDUAL_DEPTH] = s * s
    return status


@compiled
def _back(problem: Problem, scheme: Scheme, work: Work, finer: float, sharper: float, outcome: Any) -> int:
    """Solve the rebound and write the depth that is left; return the status."""
    status = rebound(problem, scheme, work, finer, sharper, math.inf)
    if status == SEPARATED:
        # A body that loses much on its way back shows only now how small an error matters.
        e = max(-work.rebound[work.counts[N_REBOUND], V_, WIDTH], _LEAST_E)
        if first_length(problem, work, sharper, e) < work.places[BACK_LENGTH, 0]:
            status = rebound(problem, scheme, work, finer, sharper, e)
    if status in (SEPARATED, SINKS_IN):
        outcome[RESIDUAL_DEPTH] = _depth_left(scheme, work, outcome[MAX_DEPTH])
    return status


@compiled
def _write_end(problem: Problem, work: Work, status: int, outcome: Any) -> None:
    """Write how an impact ended, its contact time and e."""
    if status == SEPARATED:
        last = work.counts[N_REBOUND]
        force, e = problem.external_force, -work.rebound[last, V_, WIDTH]
        outcome[CONTACT_TIME] = work.rebound[last, T_, WIDTH]
        if force == 0.0 and e < LEAST_RESTITUTION and (problem.admittance > 0.0 or problem.equilibrium == 0.0):
            status = SINKS_IN if problem.equilibrium == 0.0 else CAPTURED
        # More than the velocity of an elastic body under this force is a numerical error.
        outcome[RESTITUTION] = min(e, math.sqrt(max(1.0 + 2.0 * force * outcome[RESIDUAL_DEPTH], 0.0)))
    if status in (SINKS_IN, CAPTURED):
        outcome[RESTITUTION] = 0.0
    outcome[STATUS] = status


@entry_point
def solve_block(
    scheme: Scheme, tolerance: float, accept: float, problems: Problems, work: Work, outcomes: Any
) -> None:
    """Solve impacts.

    `tolerance` limits the tail of an element and `accept` the last step of Newton's method. Row n of `outcomes`
    receives the columns `outcome.OUTCOME`, with NaN if there is no result. `work` has room for the largest number of
    modes; afterwards it contains the last impact.
    """
    for n in range(problems.firsts.shape[0]):
        problem = problem_inside(problems, n)
        force, admittance = problem.external_force, problem.admittance
        outcome = outcomes[n]
        for column in range(outcome.shape[0]):
            outcome[column] = math.nan
        work.counts[N_FACTOR] = 0
        status = TOO_MANY_STEPS
        least = _first_tolerance(problem, tolerance, accept)
        finer, sharper = least, accept
        refined = force == 0.0 and admittance == 0.0
        # The first solve only shows by how much the target enlarges errors; the second has the accuracy.
        if admittance > 0.0:
            finer = max(finer, _FIRST_ON_TARGET)
        trial, begin = 0, finer
        while trial < _TRIALS:
            trial += 1
            patient = trial == _TRIALS
            finer = begin if patient else finer
            status = approach(problem, scheme, work, finer, sharper, FIRST * problems.firsts[n], patient)
            # In a liquid a constant force moves the body for ever; without a force it comes to rest.
            if status in (SEPARATED, CAPTURED) or (status == SINKS_IN and force == 0.0):
                status = _there(problem, scheme, work, status, outcome)
            if status == SEPARATED:
                status = _back(problem, scheme, work, finer, sharper, outcome)
            if status == SEPARATED and not refined:
                refined = True
                e = -work.rebound[work.counts[N_REBOUND], V_, WIDTH]
                enlarged = _enlarged(problem, e, outcome[MAX_DEPTH], outcome[MAX_FORCE])
                enlarged = enlarged if enlarged > _MOST_ENLARGED else 1.0
                if admittance > 0.0 and e < _LEAST_E:
                    enlarged *= _NEARLY_HELD
                needed = max(least / enlarged, _LEAST_TOLERANCES[0])
                if needed < finer and not (admittance > 0.0 and e < _SURELY_HELD * LEAST_RESTITUTION):
                    finer = begin = needed
                    sharper = max(accept / enlarged, _LEAST_TOLERANCES[1])
                    trial = 0
                    continue
            # These are results: another tolerance would not change them.
            if status < TOO_MANY_STEPS or status == TOO_DEEP:
                break
            # From a turning point of coarse elements a rebound may fail to start; finer ones succeed.
            finer *= _COARSER if trial == 1 and finer < _NEAR_ROUNDING * accept else _FINER
        _write_end(problem, work, status, outcome)
        outcome[FACTORISATIONS] = work.counts[N_FACTOR]
