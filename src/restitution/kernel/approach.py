"""Approach of the body (Lee and Radok): elements of collocation in sigma, where dt = 2 s dsigma and d = s^2.

    ds/dsigma = v,  dv/dsigma = -2 s (F - F0),  dY_k/dsigma = -2 s Y_k/tau_k + dPi/dsigma,
    dW_k/dsigma = -2 s W_k/tau_k + dv/dsigma,  F = E Pi + eta a v + sum E_k Y_k.

Here v is the velocity of the indentation. If the target moves with the velocity z F, that of the body is v + z F, and
the second equation gets the term -z dF/dsigma.

Every right-hand side is smooth at first touch. The modes are linear and are eliminated: only s at the nodes is
unknown. Stored elements contain s, v, t, F and, for each mode, Y_k and W_k.
"""

import math
from typing import Any

from restitution.kernel.collocation import (
    Scheme,
    combine,
    crossing,
    interpolate,
    invert,
    lagrange_lanes,
    matvec,
    product,
    tail,
)
from restitution.kernel.compile import compiled, inlined
from restitution.kernel.element import (
    CONVERGED,
    DIVERGED,
    FACTOR,
    LAG,
    ON_FAILURE,
    add_dashpot,
    dashpot_coupling,
    factor_modes,
    first_round,
    grown,
    next_round,
    refined,
    shrunk,
    target_jacobian,
)
from restitution.kernel.kinks import (
    SPACING,
    kink_effect,
    length_beyond,
    length_correction,
    missed_approach,
    next_kink,
    passed,
)
from restitution.kernel.lanes import WIDTH, absolute, broadcast, largest, read8, smallest, write8
from restitution.kernel.outcome import (
    CAPTURED,
    LEAST_RESTITUTION,
    SEPARATED,
    SINKS_IN,
    STEP_TOO_SMALL,
    TOO_DEEP,
    TOO_MANY_STEPS,
)
from restitution.kernel.path import SMOOTH_TABLE, radii_and_integrals, radius_and_integral
from restitution.kernel.workspace import (
    AT_KINK,
    COUPLING,
    DIAGONAL,
    F_,
    FORCE,
    JACOBIAN,
    LENGTH,
    MODES_,
    N_APPROACH,
    N_FACTOR,
    RADIUS,
    S_,
    SLOPE,
    SPEED,
    START,
    SUM,
    T_,
    UNKNOWN,
    V_,
    VALUES,
    Problem,
    Work,
)  # fmt: skip

# Newton's method.
ROUNDING = 1e-9  # relative size of a step below which it may be rounding
_MOST_ITERATIONS = 12
_REFINEMENT = 0.1  # error of W_k, over `accept`, at which its refinement ends
_MOST_REFINEMENTS = 6
# First guess of s.
_FARTHEST = 2.5  # length over that of the last element up to which its polynomial is continued; beyond it diverges
_LEAST_GUESS = 0.2  # smallest accepted guess over s at the start
_SLOW_GUESS = 0.1  # velocity of the last resort over that at the start
# Length of an element.
FIRST = 0.35  # first element over the scale of s
ROUGH_START = 0.1  # factor of the first element if a(s) is not smooth at s = 0
_SHORTEST = 1e-15  # over sigma
_SHORTEST_FIRST = 1e-150
_PAST_TURNING = 1.35  # longest element over the length to the turning point at constant deceleration
_PAST_TABLE = 0.01  # range beyond the end of a table, over that end, in which its polynomials may be used
ATTEMPTS = 4  # largest number of attempts over the room for elements
# Error of an element.
# Length over that of the first trial, and roughness over its own, at which the force is as rough as before, and the
# largest roughness that may be rounding: an unresolved layer is rougher.
_MUCH_SHORTER, _AS_ROUGH, _MOST_ROUGH = 0.3, 0.5, 10.0
FORCE_WEIGHT = 0.1  # weight of the force, times the scale of the depth
STIFF = 15.0  # additional weight of the tail where fast modes carry all of the force
_HALF_STIFF = 10.0  # length over the relaxation time of a mode from which half of its force counts as fast
_NO_GAIN = 20.0  # factor of the tail of a first element that is no more accurate at its end than inside
_LEAST_ALLOWED = 0.02  # smallest tolerance over `accept`, within the next two numbers
# Rounding of the velocity, which is that of the initial one however slow the body has become: the force of a fast mode
# with the viscosity eta has the rounding of its impulse eta Pi, which is about 1 where it has stopped the body.
_LEAST_ROUNDED, _ROUNDED = 2e-14, 1e-13
# Kinks, over `accept`, which is a twentieth of rtol.
KINK_EFFECT = 1.0  # error of the velocity due to a kink inside an element
KINK_TAIL = 4.0  # tail of an element that begins at a kink
_MOST_MISSED = 6  # solves that may miss the end at a kink
_CORRECTION = (0.5, 2.0)  # smallest and largest factor of the predicted length to a kink
_WHOLE = 0.999  # share of the longest element that counts as all of it
# Rough tables, over `accept`.
ROUGH = 0.02  # velocity that an element may miss where a(s) is rough between its nodes
TABLE_NOISE, LEAST_NOISE = 0.2, 1e-12  # error of the table, and a constant part of it
# End without a turning point.
_BALANCED = 1e-7  # net force over the constant force below which a body is in balance
_CREEPING = 1e-4  # the same below which it creeps
_CREPT = 0.01  # smallest share of s that a creeping body covers within an element
_AT_REST = 1e-6  # velocity below which a body in balance is at rest
_GOES_ON = -1


@inlined
def approach_element(problem: Problem, scheme: Scheme, work: Work, table: Any, h: float, accept: float) -> int:
    """Solve one element of length h from the first column of `table`; fill the other columns.

    `work.vectors[UNKNOWN]` contains the predicted s at the nodes. Returns the number of Newton iterations, or -1 if
    they do not converge.
    """
    A, unit = scheme.columns, scheme.identity
    N = problem.moduli.shape[0]
    vectors, B, Y, G, J = (
        work.vectors, work.inverses, work.modes[0], work.matrices[SUM], work.matrices[JACOBIAN],
    )  # fmt: skip
    eta, external_force, equilibrium = problem.viscosity, problem.external_force, problem.equilibrium
    z = problem.admittance
    # Without both, v = v0 - h A g is eliminated from s = s0 + h A v.
    implicit = eta > 0.0 or z > 0.0
    s0, v0, F0 = table[S_, 0], table[V_, 0], table[F_, 0]
    Pi0 = radius_and_integral(problem.path, s0)[1]
    straight = s0 + (h * v0) * read8(scheme.c, 1)
    newton, iterations = first_round(), 0
    s = read8(vectors, UNKNOWN, 0)
    v = broadcast(v0)
    while True:
        iterations += 1
        # s <= 0 has no contact radius. The negation also catches NaN.
        if iterations > _MOST_ITERATIONS or not smallest(s) > 0.0:
            return -1
        refactor, final_round = newton.verdict == FACTOR, newton.verdict == CONVERGED
        r = 2.0 * s
        a, Pi = radii_and_integrals(problem.path, s, vectors[VALUES:])
        F = equilibrium * Pi
        # dF/ds at the nodes: dPi/ds = a dd/ds = 2 s a.
        slope = (equilibrium * a) * r
        if refactor:
            factor_modes(problem, scheme, work, r, h)
            for j in range(WIDTH):
                write8(G, j, 0, broadcast(0.0))
        for k in range(N):
            E = problem.moduli[k]
            # B_k Y_k = Pi - Pi_0 + Y_k0.
            start = Pi + (table[MODES_ + 2 * k, 0] - Pi0)
            if refactor:
                Yk = matvec(B[k], start)
                # dY/ds, as B depends on s: (h/tau) B^-1 A diag(r) = 1 - B^-1.
                mode_slope = E * Yk / s
                weight = (E * a) * r + mode_slope
                for j in range(WIDTH):
                    write8(G, j, 0, read8(G, j, 0) + read8(B, k, j, 0) * weight[j])
                slope = slope - mode_slope
            else:
                Yk = read8(Y, k, 0)
                # After a single update, fast modes lag behind s by the size of the chord step, which would be useless.
                lags = not final_round and h * r[WIDTH - 1] > LAG * problem.times[k]
                for _ in range(2 if lags else 1):
                    Yk = refined(problem, scheme, work, k, start, Yk, r, h)
            write8(Y, k, 0, Yk)
            F = F + E * Yk
        if implicit:
            write8(vectors, UNKNOWN, 0, s)
            write8(vectors, FORCE, 0, F)
            write8(vectors, RADIUS, 0, a)
            add_dashpot(problem, scheme, work, v0, F0, h)
            F, v = read8(vectors, FORCE, 0), read8(vectors, SPEED, 0)
        g = r * (F - external_force)
        # The modes now belong to the accepted s. Another residual would only measure rounding.
        if final_round:
            break
        # An explicit v is exact for these s, so that A^2 acts on g at once. Otherwise `add_dashpot` solved for v.
        residual = s - s0 - h * matvec(A, v) if implicit else s - straight + (h * h) * matvec(scheme.square, g)
        if refactor:
            # dg/ds of g = 2 s (F - F0), without the coupling of the nodes by the modes, which is G.
            diagonal = r * slope + 2.0 * (F - external_force)
            if implicit:
                dashpot_coupling(problem, scheme, work)
                diagonal = diagonal + r * read8(vectors, RADIUS, 0)
            for j in range(WIDTH):
                column = r * read8(G, j, 0) + read8(unit, j, 0) * diagonal[j]
                column = matvec(work.matrices[COUPLING] if implicit else scheme.square, column)
                write8(J, j, 0, read8(unit, j, 0) + (h * h) * column)
            if z > 0.0:
                write8(vectors, SLOPE, 0, slope)
                write8(vectors, DIAGONAL, 0, diagonal)
                target_jacobian(problem, scheme, work, h)
            invert(work.matrices, JACOBIAN)
        step = matvec(J, residual)
        s = s - step
        size = largest(absolute(step)) / max(s0, largest(s))
        # A step as large as s itself starts far from the root; a shorter element starts nearer. Catches NaN too.
        if not size < 1.0:
            return -1
        # After convergence one more round refines the modes with the final unknowns; without it e has errors of 2e-8.
        newton = next_round(newton, size, ROUNDING, accept)
        if newton.verdict == DIVERGED:
            return -1
    # v + z F is the velocity of the body, with the rate -(F - F0).
    gained = -h * matvec(A, g) - z * (F - F0)
    v = v0 + gained
    write8(table, S_, 1, s)
    write8(table, V_, 1, v)
    write8(table, T_, 1, table[T_, 0] + h * matvec(A, r))
    write8(table, F_, 1, F)
    # The inverses belong to an earlier s: each refinement multiplies the error by the drift since then.
    rounds = 1
    power = newton.drift * newton.drift
    while power > _REFINEMENT * accept and rounds < _MOST_REFINEMENTS:
        power *= newton.drift
        rounds += 1
    for k in range(N):
        # W_k of a fast mode is far smaller than v: from v - v0 it would be rounding.
        start = table[MODES_ + 1 + 2 * k, 0] + gained
        Wk = matvec(B[k], start)
        for _ in range(rounds):
            Wk = refined(problem, scheme, work, k, start, Wk, r, h)
        write8(table, MODES_ + 2 * k, 1, read8(Y, k, 0))
        write8(table, MODES_ + 1 + 2 * k, 1, Wk)
    return iterations


@inlined
def is_held(problem: Problem, v: float, F: float, s: float) -> bool:
    """Return whether a body in a liquid, or on a target that moves, keeps less energy than counts for its e.

    The force fades, so the foundation gives back less than its work F d on the way out.
    """
    speed = v + problem.admittance * F
    fades = problem.admittance > 0.0 or problem.equilibrium == 0.0
    return fades and speed * speed + 2.0 * F * s * s < LEAST_RESTITUTION**2


@inlined
def _predict(scheme: Scheme, work: Work, element: int, slope: float, h: float) -> None:
    """Predict s at the nodes by extrapolation of the last element, or by a parabola if the length jumps."""
    table = work.approach[element]
    s0, v0 = table[S_, 0], table[V_, 0]
    ratio = 0.0 if element == 0 else h / work.places[LENGTH, element - 1]
    x = h * read8(scheme.c, 1)
    s = broadcast(0.0)
    # There is nothing to continue before the first element.
    if 0.0 < ratio <= _FARTHEST:
        lagrange_lanes(scheme.c, scheme.weights, WIDTH + 1, 1.0 + ratio * read8(scheme.c, 1), work.basis)
        s = combine(work.basis, WIDTH + 1, work.approach[element - 1, S_])
    # The continued polynomial may fall to zero: then a parabola with the known velocity and its rate.
    if not smallest(s) > _LEAST_GUESS * s0:
        s = s0 + x * (v0 + (0.5 * slope) * x)
    if not smallest(s) > _LEAST_GUESS * s0:
        s = s0 + (_SLOW_GUESS * abs(v0)) * x
    write8(work.vectors, UNKNOWN, 0, s)


@compiled
def _length_to(scheme: Scheme, work: Work, element: int, end: float, slope: float, h: float) -> float:
    """Return the predicted length, at most h, of an element that ends at s = end."""
    table = work.approach[element]
    s0, v0 = table[S_, 0], table[V_, 0]
    inside = v0 * v0 + 2.0 * slope * (end - s0)
    # Root of s0 + v0 x + slope x^2/2 = end, in the form without cancellation.
    length = min(2.0 * (end - s0) / (v0 + math.sqrt(max(inside, 0.0))), h)
    for _ in range(2):
        _predict(scheme, work, element, slope, length)
        reached = work.vectors[UNKNOWN, WIDTH - 1] - s0
        if reached > 0.0:
            length = min(length * min(max((end - s0) / reached, _CORRECTION[0]), _CORRECTION[1]), h)
    return length


@compiled
def _write_touch(problem: Problem, table: Any) -> None:
    """Write the state at first touch to the first column of `table`."""
    rows = table.shape[0]
    for n in range(rows):
        table[n, 0] = 0.0
    # A dashpot under a flat face has a force at once, which moves the target at once.
    drag = problem.viscosity * radius_and_integral(problem.path, 0.0)[0]
    table[V_, 0] = 1.0 / (1.0 + problem.admittance * drag)
    for n in range(MODES_ + 1, rows, 2):
        table[n, 0] = table[V_, 0]
    table[F_, 0] = drag * table[V_, 0]


@compiled
def _stiff_share(problem: Problem, table: Any, h: float) -> float:
    """Share of the force at the end of an element that modes faster than the element carry."""
    force = 0.0
    for k in range(problem.moduli.shape[0]):
        z = 2.0 * h * table[S_, WIDTH] / problem.times[k]
        force += problem.moduli[k] * table[MODES_ + 2 * k, WIDTH] * z / (z + _HALF_STIFF)
    return min(abs(force) / max(table[F_, WIDTH], 1e-300), 1.0)


@compiled
def _end_without_turning(problem: Problem, table: Any) -> int:
    """Judge whether a body comes to rest in an element: SINKS_IN, CAPTURED, or `_GOES_ON`.

    If the foundation balances the constant force along the whole element, the body creeps and never turns. An
    oscillation that seems balanced over a hundredth of the depth has more kinetic energy than the work of the force.
    """
    S, force = WIDTH, problem.external_force
    unbalanced = max(abs(table[F_, 0] - force), abs(table[F_, S] - force))
    balanced = unbalanced < _BALANCED * force
    creeps = unbalanced < _CREEPING * force and table[S_, S] - table[S_, 0] > _CREPT * table[S_, S]
    creeps = creeps and table[V_, S] ** 2 < force * table[S_, S] ** 2
    held = is_held(problem, table[V_, S], table[F_, S], table[S_, S])
    # Without a spring nothing brings the body back, and it sinks in. A spring holds it.
    if problem.equilibrium == 0.0 and (balanced or creeps or held):
        return SINKS_IN
    return CAPTURED if held or creeps or (balanced and table[V_, S] < _AT_REST) else _GOES_ON


@compiled
def approach(
    problem: Problem, scheme: Scheme, work: Work, tolerance: float, accept: float, first: float, patient: bool
) -> int:
    """Solve the approach up to the turning point; store it in `work.approach` and `work.turning`.

    `patient` takes a force that stays rough in much shorter elements for rounding.
    """
    S, rows = WIDTH, work.turning.shape[0]
    exponent = -1.0 / (S + 1.0)
    h = first
    # a(s) of parabola, cone and flat punch is smooth at s = 0, on a layer too. For other profiles the end of the first
    # element is only as accurate as its inside.
    exact_start = problem.path.exponent in (0.0, 1.0, 2.0, SMOOTH_TABLE)
    force_scale = FORCE_WEIGHT * (first / FIRST) ** 2
    if not exact_start:
        h *= ROUGH_START
    # Read back from the array: for a constant 0 numba would compile the loop a second time.
    work.counts[N_APPROACH] = 0
    element = work.counts[N_APPROACH]
    _write_touch(problem, work.approach[0])
    sigma, attempts = 0.0, 0
    glass = problem.equilibrium
    for k in range(problem.moduli.shape[0]):
        glass += problem.moduli[k]
    kinks = problem.path.kinks
    # First kink ahead, kink at the start of the element, kink at its intended end, and solves that missed this end.
    ahead, behind, target, missed = element, -1, -1, 0
    unhindered = h
    # Roughness of the force over the first trial of an element that is too long for it, and its length.
    first_rough, rough_length = 0.0, 0.0
    while True:
        attempts += 1
        if element >= work.approach.shape[0] - 1 or attempts > ATTEMPTS * work.approach.shape[0]:
            return TOO_MANY_STEPS
        # A shorter element would not change sigma. The negation also catches a length that is NaN.
        if not h > _SHORTEST * sigma + _SHORTEST_FIRST:
            return STEP_TOO_SMALL
        table = work.approach[element]
        slope = -2.0 * table[S_, 0] * (table[F_, 0] - problem.external_force)
        # dv/dsigma then contains z dF/dsigma, which is not stored: take the slope at the end of the last element.
        if problem.admittance > 0.0 and element > 0:
            slope = product(scheme.derivative[S], work.approach[element - 1, V_]) / work.places[LENGTH, element - 1]
        # The element need not reach far beyond the turning point.
        if element > 0 and slope < 0.0:
            h = min(h, _PAST_TURNING * table[V_, 0] / -slope)
        if problem.path.exponent < 0.0:
            # Elements must not extend far beyond the table, where its polynomials are meaningless.
            end = problem.path.end
            if table[S_, 0] > end:
                return TOO_DEEP
            h = min(h, _PAST_TABLE * end + (end - table[S_, 0]) / table[V_, 0])
            # After a miss, `h` and `target` are those of the correction, which a new search would undo.
            if missed == 0:
                if behind >= 0:
                    h = length_beyond(problem, glass, behind, table[V_, 0], h, KINK_TAIL * accept)
                unhindered = h
                target = next_kink(problem, glass, ahead, table[S_, 0], table[V_, 0], slope, h, KINK_EFFECT * accept)
                if target >= 0:
                    h = _length_to(scheme, work, element, kinks[target], slope, h)
        _predict(scheme, work, element, slope, h)
        iterations = approach_element(problem, scheme, work, table, h, accept)
        work.counts[N_FACTOR] += 1
        if iterations < 0:
            h *= ON_FAILURE
            missed = 0
            continue
        # The tolerance refers to the recoverable part of the motion, down to a limit set by `accept` and rounding.
        amplitude = min(math.sqrt(table[V_, S] ** 2 + max(table[F_, S], 0.0) * table[S_, S] ** 2), 1.0)
        allowed = max(tolerance * amplitude, min(max(_LEAST_ALLOWED * accept, _LEAST_ROUNDED), _ROUNDED))
        # Where modes faster than the step carry the force, the order falls to that of the stages, and the error at the
        # end of the element is as large as inside: about ten times the tail, by measurement.
        error = (1.0 + STIFF * _stiff_share(problem, table, h)) * tail(scheme, table[V_]) / allowed
        # a(s) is no polynomial there, so the end of the element is only as accurate as its inside.
        if element == 0 and not exact_start:
            error *= _NO_GAIN * tolerance / accept
        if behind >= 0:
            error *= max(tolerance / (KINK_TAIL * accept), 1.0)
        # The velocity alone does not show a rough force between the nodes, as at the edge of a flat end.
        roughness = force_scale * tail(scheme, table[F_]) / tolerance
        # Remember the first trial that was too rough, to see whether shorter ones become smoother.
        if roughness > 1.0 and first_rough == 0.0:
            first_rough, rough_length = roughness, h
        elif (
            patient
            and roughness < _MOST_ROUGH
            and h < _MUCH_SHORTER * rough_length
            and roughness > _AS_ROUGH * first_rough
        ):
            # Roughness would shrink with the element: this is the rounding of fast modes at its start, which decays.
            roughness = 0.0
        error = max(error, roughness)
        if problem.path.exponent < 0.0:
            rough = missed_approach(problem, scheme, work, table, h, TABLE_NOISE * accept + LEAST_NOISE)
            error = max(error, rough / (ROUGH * accept * amplitude))
        # The negation rejects NaN as well.
        if not error <= 1.0:
            h *= shrunk(error, exponent)
            missed = 0
            continue
        if target >= 0:
            correction = length_correction(problem, scheme, work, table, glass, target, h, KINK_EFFECT * accept)
            beyond_reach = correction > 1.0 and h >= _WHOLE * unhindered
            if correction != 1.0 and missed < _MOST_MISSED and not beyond_reach:
                missed += 1
                h = min(h * correction, unhindered)
                continue
            if correction != 1.0:
                target = -1
        missed = 0
        work.places[AT_KINK, element] = 1.0 if behind >= 0 else 0.0
        work.places[START, element] = sigma
        work.places[LENGTH, element] = h
        # The turning point lies within this element, which is therefore the last.
        if table[V_, S] <= 0.0:
            break
        first_rough, rough_length = 0.0, 0.0
        sigma += h
        element += 1
        for n in range(rows):
            work.approach[element, n, 0] = table[n, S]
        ending = _end_without_turning(problem, table)
        if ending != _GOES_ON:
            for n in range(rows):
                work.turning[n] = table[n, S]
            work.counts[N_APPROACH] = element - 1
            work.turning_place[0] = sigma
            return ending
        h *= grown(error, exponent)
        behind = target
        if target >= 0:
            h = max(h, unhindered)
            ahead = target + 1
        # An element may end slightly beyond a kink. The next element and the rebound then treat its end as the kink.
        before = ahead
        ahead = passed(kinks, ahead, table[S_, S])
        if ahead > before:
            z = table[S_, S] - kinks[ahead - 1] + h * table[V_, S]
            if kink_effect(problem, glass, ahead - 1, table[V_, S], SPACING * z, h) > KINK_EFFECT * accept:
                behind = ahead - 1
    # The turning point is the zero of the polynomial of the velocity.
    x = crossing(scheme, work, table[V_], 0.0, 1.0)
    sigma += x * h
    interpolate(scheme, work, table, x, work.turning)
    work.counts[N_APPROACH] = element
    work.turning_place[0] = sigma
    return SEPARATED
