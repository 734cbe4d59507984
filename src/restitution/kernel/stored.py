"""Evaluations of the stored halves of an impact: energies, samples at given times, and the largest pressure."""

import math
from typing import Any, NamedTuple

import numpy as np

from restitution.kernel.collocation import (
    Scheme,
    combine,
    interpolate,
    interpolate_at,
    interpolate_lanes,
    invert,
    lagrange,
    lagrange_lanes,
    matvec,
    product,
    value,
)
from restitution.kernel.compile import compiled, entry_point, inlined
from restitution.kernel.element import write_matrix
from restitution.kernel.lanes import WIDTH, at_least, read8, total, write8
from restitution.kernel.path import radii_and_integrals, radius_and_integral
from restitution.kernel.workspace import (
    BACK_LENGTH,
    BACK_START,
    BASIS,
    COUPLING,
    F_,
    LENGTH,
    MODES_,
    N_APPROACH,
    N_REBOUND,
    S_,
    START,
    T_,
    V_,
    VALUES,
    Problem,
    Work,
)

# Energy budget of an impact: dissipation in the dashpots of the foundation, and energy stored at separation.
#
# Quadrature over the foundation from the stored halves of a solved impact, in the generalised Maxwell form of the
# reduced modulus. An element at x, touched at t0(x), carries in mode k the elongation
# `w_k = H_k(t) - exp(-(t - t0)/tau_k) H_k(t0)` with `H_k = int_0^t exp(-(t - t')/tau_k) d' dt'`. Over the elements
# in contact, with `P_k = int_0^a exp(-(t - t0)/tau_k) H_k(t0) dx` and Q_k the same of the squares,
#
#     int_0^a w_k^2 dx = a H_k^2 - 2 H_k P_k + Q_k.
#
# By parts, so that da/dsigma, singular at blunt tips, does not appear: `P_k = a H_k - Y_k`, `Q_k = a H_k^2 - Z_k`,
#
#     dH_k = -(H_k/tau_k) dt + dd,  dY_k = -(Y_k/tau_k) dt + a dd,  dZ_k = -(2 Z_k/tau_k) dt + 2 a H_k dd.
#
# In the rebound P_k and Q_k are those at the instant t1 of equal contact radius, times X_k and X_k^2. Hence
#
#     int_0^a w_k^2 dx = 2 H_k Y_k - Z_k                                     in the approach,
#     int_0^a w_k^2 dx = a (H_k - X_k H1_k)^2 + X_k (2 H_k Y1_k - X_k Z1_k)  in the rebound.
#
# H_k is integrated separately, because it would lose digits for slow modes if computed from W_k. Mode 0 is the
# parallel spring: it never decays, and its H is the depth. All values are stored along both halves, for histories and
# fields.

# Last element, where a(s) has a root at the end.
_PARTS = 24  # the last part is 1e-7 of the element
_SHARE = 0.5  # part over what is left of the element


class Ledger(NamedTuple):
    """Memory and energies along an impact with N modes and E elements of S = 8 stages in each half."""

    # (E, 3 (N + 1) + 2, S + 1): H_k, Y_k, Z_k of each mode in turn; last the energies dissipated and radiated
    approach: Any
    # (E, N + 5, S + 1): H_k; then the energies dissipated and radiated, the energy per length of an element that
    # leaves, and `int a` over it
    rebound: Any
    slope: Any  # (S + 1,): slope of the energy per length
    past: Any  # (3 (N + 1), S): the memory at the instants t1 of a rebound element's nodes
    present: Any  # (3 (N + 1) + 2,): the approach's rows at the turning point


def allocate_ledger(N: int, elements: int) -> Ledger:
    """Return room for the energy budget."""
    rows = 3 * (N + 1)
    return Ledger(
        np.zeros((elements, rows + 2, WIDTH + 1)),
        np.zeros((elements, N + 5, WIDTH + 1)),
        np.zeros(WIDTH + 1),
        np.zeros((rows, WIDTH)),
        np.zeros(rows + 2),
    )


@inlined
def _decay_matrix(scheme: Any, work: Any, pace: Any, rate: float, h: float) -> None:
    """Write the matrix that solves y' = -rate pace y + source over an element into `matrices[COUPLING]`."""
    write_matrix(scheme, work.matrices, COUPLING, (h * rate) * pace)
    invert(work.matrices, COUPLING)


@inlined
def _propagated(scheme: Any, work: Any, source: Any, h: float, start: float) -> Any:
    """Return the solution at the nodes from `start`, with the matrix of `_decay_matrix`."""
    return matvec(work.matrices[COUPLING], start + h * matvec(scheme.columns, source))


@compiled
def _approach(problem: Problem, scheme: Scheme, work: Work, ledger: Ledger) -> None:
    """Fill the ledger along the approach, and its state at the turning point."""
    N = problem.moduli.shape[0]
    for element in range(work.counts[N_APPROACH] + 1):
        table, memory = work.approach[element], ledger.approach[element]
        for n in range(memory.shape[0]):
            memory[n, 0] = ledger.approach[element - 1, n, WIDTH] if element > 0 else 0.0
        h = work.places[LENGTH, element]
        s, v, F = read8(table, S_, 1), read8(table, V_, 1), read8(table, F_, 1)
        a, Pi = radii_and_integrals(problem.path, s, work.vectors[VALUES:])
        pace = 2.0 * s
        source = pace * v
        power = problem.viscosity * (a * v * source)
        if element == 0:
            # a(s) may have an infinite slope at first touch: int v dPi by parts, and so Y below.
            power = (problem.viscosity * Pi) * (pace * (F - problem.external_force))
            power = power - (problem.viscosity * problem.admittance) * (F * a * source)
        for k in range(N + 1):
            rows = memory[3 * k : 3 * k + 3]
            # Sources: dd of H, a dd of Y, 2 a H dd of Z, which decays at twice the rate.
            rate = 1.0 / problem.times[k - 1] if k > 0 else 0.0
            _decay_matrix(scheme, work, pace, rate, h)
            H = _propagated(scheme, work, source, h, rows[0, 0])
            if element == 0:
                Y = Pi - _propagated(scheme, work, rate * (pace * Pi), h, 0.0)
            else:
                Y = _propagated(scheme, work, source * a, h, rows[1, 0])
            _decay_matrix(scheme, work, pace, 2.0 * rate, h)
            Z = _propagated(scheme, work, 2.0 * (source * a * H), h, rows[2, 0])
            write8(rows, 0, 1, H)
            write8(rows, 1, 1, Y)
            write8(rows, 2, 1, Z)
            if k > 0:
                power = power + (problem.moduli[k - 1] * rate) * ((2.0 * (H * Y) - Z) * pace)
        lost = memory[3 * (N + 1)]
        dissipated = lost[0] + h * matvec(scheme.columns, power)
        if element == 0:
            dissipated = dissipated + problem.viscosity * ((v + problem.admittance * F) * Pi)
        write8(lost, 1, dissipated)
        _radiate(problem, scheme, memory[3 * (N + 1) + 1], F, pace, h)
    last = work.counts[N_APPROACH]
    x = (work.turning_place[0] - work.places[START, last]) / work.places[LENGTH, last]
    interpolate(scheme, work, ledger.approach[last], min(x, 1.0), ledger.present)


@inlined
def _radiate(problem: Problem, scheme: Scheme, radiated: Any, F: Any, pace: Any, h: float) -> None:
    """Continue the energy z F^2 dt that the target carries away over an element."""
    write8(radiated, 1, radiated[0] + (h * problem.admittance) * matvec(scheme.columns, F * F * pace))


@compiled
def _last_element(
    problem: Problem, scheme: Scheme, work: Work, ledger: Ledger, sigma: float, h: float
) -> tuple[float, float]:
    """Return the energy dissipated and stored in the last element, which begins at `sigma`.

    At its end a(s) of a blunt tip has an infinite slope, and panels shrink towards it. H_k, X_k, the velocity and the
    density are smooth and are interpolated from the nodes; the contact radius is evaluated at each place.
    """
    N = problem.moduli.shape[0]
    past = ledger.past
    element = work.counts[N_REBOUND]
    table, slopes, history = work.rebound[element], work.slopes[element], ledger.rebound[element]
    weights = read8(scheme.A, WIDTH - 1, 0)
    dissipated = 0.0
    stored = 0.0
    low = 0.0
    place = work.counts[N_APPROACH]
    for n in range(_PARTS):
        high = 1.0 if n == _PARTS - 1 else low + _SHARE * (1.0 - low)
        x = low + (high - low) * read8(scheme.c, 1)
        there = at_least(sigma - h * x, 0.0)
        interpolate_lanes(scheme, work, ledger.approach, there, place, past)
        place = interpolate_lanes(scheme, work, work.approach, there, place, work.past)
        a = radii_and_integrals(problem.path, read8(work.past, S_, 0), work.vectors[VALUES:])[0]
        lagrange_lanes(scheme.c[1:], scheme.extrapolation, WIDTH, x, work.basis)
        pace = combine(work.basis, WIDTH, slopes)
        lagrange_lanes(scheme.c, scheme.weights, WIDTH + 1, x, work.basis)
        v = combine(work.basis, WIDTH + 1, table[V_])
        power = problem.viscosity * (a * v * v)
        for k in range(N):
            H = combine(work.basis, WIDTH + 1, history[k + 1])
            X = combine(work.basis, WIDTH + 1, table[MODES_ + 2 * k])
            power = power + (problem.moduli[k] / problem.times[k]) * _squares(past, k + 1, a, H, X)
        dissipated += h * (high - low) * total(weights * power * pace)
        stored += (high - low) * total(weights * a * combine(work.basis, WIDTH + 1, ledger.slope))
        low = high
    return dissipated, stored


@inlined
def _squares(past: Any, k: int, a: Any, H: Any, X: Any) -> Any:
    """Return the integral of w_k^2 over the elements in contact."""
    left = H - X * read8(past, 3 * k, 0)
    return a * (left * left) + X * (2.0 * (H * read8(past, 3 * k + 1, 0)) - X * read8(past, 3 * k + 2, 0))


@compiled
def _rebound(problem: Problem, scheme: Scheme, work: Work, ledger: Ledger) -> None:
    """Fill the ledger along the rebound, after the approach."""
    N = problem.moduli.shape[0]
    past = ledger.past
    sigma_m = work.turning_place[0]
    last = work.counts[N_REBOUND]
    place = work.counts[N_APPROACH]
    first = ledger.rebound[0]
    for k in range(1, N + 1):
        first[k, 0] = ledger.present[3 * k]
    first[0, 0] = work.turning[S_] ** 2
    first[N + 1, 0] = ledger.present[3 * (N + 1)]
    first[N + 2, 0] = ledger.present[3 * (N + 1) + 1]
    first[N + 3, 0] = 0.0
    first[N + 4, 0] = 0.0
    for element in range(last + 1):
        table, rows = work.rebound[element], ledger.rebound[element]
        if element > 0:
            for n in range(rows.shape[0]):
                rows[n, 0] = ledger.rebound[element - 1, n, WIDTH]
        h = work.places[BACK_LENGTH, element]
        start = sigma_m - work.places[BACK_START, element]
        sigma = start - h * read8(scheme.c, 1)
        if element == last:
            sigma = at_least(sigma, 0.0)
        interpolate_lanes(scheme, work, ledger.approach, sigma, place, past)
        place = interpolate_lanes(scheme, work, work.approach, sigma, place, work.past)
        s1, v, pace = read8(work.past, S_, 0), read8(table, V_, 1), read8(work.slopes, element, 0)
        a = radii_and_integrals(problem.path, s1, work.vectors[VALUES:])[0]
        source = pace * v
        power = problem.viscosity * (a * v * v)
        d = rows[0, 0] + h * matvec(scheme.columns, source)
        write8(rows, 0, 1, d)
        density = (0.5 * problem.equilibrium) * ((d - s1 * s1) * (d - s1 * s1))
        for k in range(N):
            rate = 1.0 / problem.times[k]
            _decay_matrix(scheme, work, pace, rate, h)
            H = _propagated(scheme, work, source, h, rows[k + 1, 0])
            write8(rows, k + 1, 1, H)
            X = read8(table, MODES_ + 2 * k, 1)
            power = power + (problem.moduli[k] * rate) * _squares(past, k + 1, a, H, X)
            left = H - X * read8(past, 3 * k + 3, 0)
            density = density + (0.5 * problem.moduli[k]) * (left * left)
        lost, leaving, released = rows[N + 1], rows[N + 3], rows[N + 4]
        _radiate(problem, scheme, rows[N + 2], read8(table, F_, 1), pace, h)
        write8(leaving, 1, density)
        for i in range(WIDTH + 1):
            ledger.slope[i] = product(scheme.derivative[i], leaving)
        # Elements store - int density da = int a d(density) at separation, without the singular a'(s), core included.
        write8(lost, 1, lost[0] + h * matvec(scheme.columns, power * pace))
        write8(released, 1, released[0] + matvec(scheme.columns, a * read8(ledger.slope, 1)))
        if element == last:
            end = _last_element(problem, scheme, work, ledger, start, h)
            lost[WIDTH] = lost[0] + end[0]
            released[WIDTH] = released[0] + end[1]


@entry_point
def energy_budget(problem: Problem, scheme: Scheme, work: Work, ledger: Ledger) -> tuple[float, float, float]:
    """Energy dissipated in an impact, stored at its end, and radiated, in units of m v0^2; fills the ledger.

    `work` contains an impact that ended in separation. The function is a separate entry point, so that it is compiled
    only if the energy is requested.
    """
    _approach(problem, scheme, work, ledger)
    _rebound(problem, scheme, work, ledger)
    N = problem.moduli.shape[0]
    rows = ledger.rebound[work.counts[N_REBOUND]]
    return rows[N + 1, WIDTH], rows[N + 4, WIDTH], rows[N + 2, WIDTH]


# Largest contact pressure over the contact and over time.
#
# At the time t of the approach, at the radius r = a(t_r), in units of m v0^2/(2 pi L a_1^2),
#
#     p(r, t) = int_(t_r)^t E(t - t') dd(t')/sqrt(a(t')^2 - r^2),   E(t) = equilibrium + sum moduli_k exp(-t/times_k).
#
# In the rebound the pressure only falls, because the depth falls and the modulus relaxes. Places in sigma represent
# time and radius. The pressure is finite without a parallel dashpot if the profile has neither a sharp tip nor a sharp
# edge.

# Quadrature rule.
_FIRST_EDGES = (0.0, 1 / 256, 1 / 64, 1 / 16, 1 / 4, 0.5, 0.65)  # ends of the first cells
_CELL_RATIO = 0.25  # ratio of the last cells; the integrand is an inverse root at their end
_LAST_CELLS = 12  # the smallest cell is 6e-8
_POWER = 8  # of the places
# Search for the largest pressure.
_EARLIEST = math.log(1e-4)  # smallest sigma over that at the turning point
_YOUNGEST = math.log(1e-12)  # smallest age over the square of sigma at the turning point
_GRID = 18  # points of the first grid in each direction
_GRADING = 2  # power of the grid, which is denser towards the turning point and the axis
_RIDGE = 2.0  # additional range of ages over that of times: a ridge may be inclined
_PRESSURE_ROUNDS = 11  # of each search around the best point of the grid
_GOLDEN = 0.5 * (math.sqrt(5.0) - 1.0)


class Rule(NamedTuple):
    """A quadrature rule on [0, 1], from the end to the start, and scratch space for the motion at a node."""

    places: Any
    weights: Any
    row: Any


def graded_rule(n: int) -> Rule:
    """Rule with n nodes per cell and shorter cells towards both ends.

    For power laws close to a cone, with an exponent m -> 1, the integrand on the axis rises as sigma^(1 - 2/m) towards
    0: hence the power there.
    """
    nodes, weights = np.polynomial.legendre.leggauss(n)
    edges = np.concatenate([_FIRST_EDGES, 1.0 - _CELL_RATIO ** np.arange(1.0, _LAST_CELLS + 1.0), [1.0]])
    half = 0.5 * np.diff(edges)[:, None]
    y = (edges[:-1, None] + half * (1.0 + nodes)).ravel()[::-1]
    return Rule(y**_POWER, (half * weights).ravel()[::-1] * _POWER * y ** (_POWER - 1), np.empty(3))


@compiled
def _pressure(problem: Problem, scheme: Scheme, work: Work, rule: Rule, time: float, age: float) -> float:
    """Pressure at the logarithms of sigma and of the age of the contact at the radius, a difference of sigma^2.

    A peak close to the edge has a constant age as the contact grows. An age above that of the contact means the axis.
    """
    now = work.turning_place[0] * math.exp(time)
    touch = math.sqrt(max(now * now - work.turning_place[0] ** 2 * math.exp(age), 0.0))
    row = rule.row
    element = interpolate_at(scheme, work, work.counts[N_APPROACH], now, row)
    t = row[T_]
    interpolate_at(scheme, work, element, touch, row)
    r = radius_and_integral(problem.path, max(row[S_], 0.0))[0]
    total = 0.0
    for n in range(rule.places.shape[0]):
        sigma = touch + (now - touch) * rule.places[n]
        element = interpolate_at(scheme, work, element, sigma, row)
        a = radius_and_integral(problem.path, max(row[S_], 0.0))[0]
        # Rounding may put the first places inside the radius, where the root has no value.
        if a > r:
            since = max(t - row[T_], 0.0)
            modulus = problem.equilibrium
            for k in range(problem.moduli.shape[0]):
                modulus += problem.moduli[k] * math.exp(-since / problem.times[k])
            total += rule.weights[n] * modulus * row[S_] * row[V_] / math.sqrt((a - r) * (a + r))
    return 2.0 * (now - touch) * total


@compiled
def _over_ages(problem: Problem, scheme: Scheme, work: Work, rule: Rule, time: float, window: Any) -> float:
    """Return the largest pressure at a time over a window of ages, by golden-section search."""
    low, high = window
    left, right = high - _GOLDEN * (high - low), low + _GOLDEN * (high - low)
    of_left = _pressure(problem, scheme, work, rule, min(time, 0.0), left)
    of_right = _pressure(problem, scheme, work, rule, min(time, 0.0), right)
    for _ in range(_PRESSURE_ROUNDS):
        if of_left > of_right:
            high, right, of_right = right, left, of_left
            left = high - _GOLDEN * (high - low)
            of_left = _pressure(problem, scheme, work, rule, min(time, 0.0), left)
        else:
            low, left, of_left = left, right, of_right
            right = low + _GOLDEN * (high - low)
            of_right = _pressure(problem, scheme, work, rule, min(time, 0.0), right)
    return max(of_left, of_right)


@entry_point
def peak_pressure(problem: Problem, scheme: Scheme, work: Work, coarse: Rule, fine: Rule) -> float:
    """Return the largest pressure of an impact from its stored approach.

    A grid, dense towards the turning point and the axis, locates the maximum, and a search around its best point
    gives the value.
    """
    largest, time, age = 0.0, 0.0, 0.0
    i_best, j_best = 0, 0
    for i in range(_GRID):
        for j in range(_GRID):
            here = _EARLIEST * (i / (_GRID - 1.0)) ** _GRADING, _YOUNGEST * (j / (_GRID - 1.0)) ** _GRADING
            pressure = _pressure(problem, scheme, work, coarse, here[0], here[1])
            if pressure > largest:
                largest, time, age, i_best, j_best = pressure, here[0], here[1], i, j
    step_time = _EARLIEST * (i_best**_GRADING - (i_best + 1.0) ** _GRADING) / (_GRID - 1.0) ** _GRADING
    step_age = _YOUNGEST * (j_best**_GRADING - (j_best + 1.0) ** _GRADING) / (_GRID - 1.0) ** _GRADING
    # The maximum may lie on a narrow ridge: search for the best age at each time.
    window = age - step_age - _RIDGE * step_time, age + step_age + _RIDGE * step_time
    low, high = time - step_time, time + step_time
    left, right = high - _GOLDEN * (high - low), low + _GOLDEN * (high - low)
    of_left = _over_ages(problem, scheme, work, fine, left, window)
    of_right = _over_ages(problem, scheme, work, fine, right, window)
    for _ in range(_PRESSURE_ROUNDS):
        if of_left > of_right:
            high, right, of_right = right, left, of_left
            left = high - _GOLDEN * (high - low)
            of_left = _over_ages(problem, scheme, work, fine, left, window)
        else:
            low, left, of_left = left, right, of_right
            right = low + _GOLDEN * (high - low)
            of_right = _over_ages(problem, scheme, work, fine, right, window)
    return max(of_left, of_right)


# Values of the stored halves of an impact at given times.

# Newton steps at most, and the last one at which the place counts as found.
_ROUNDS, _STEP = 80, 1e-15


@inlined
def _differentiate(scheme: Scheme, work: Work, row: Any) -> None:
    """Leave the slopes of a row at the nodes in `vectors[VALUES]`."""
    for i in range(WIDTH + 1):
        work.vectors[VALUES, i] = product(scheme.derivative[i], row)


@compiled
def _place(scheme: Scheme, work: Work, row: Any, level: float, end: float) -> float:
    """Place in [0, end] of an element at which an increasing row has a level, or else an end; by Newton."""
    basis, slopes = work.vectors[BASIS], work.vectors[VALUES]
    low, high = 0.0, end
    if level <= row[0]:
        return low
    # The start is the same whatever the other levels are, and so are the bits of the place.
    x = 0.5 * end
    if end == 1.0:  # a row may fall beyond a smaller end
        if level >= row[WIDTH]:
            return end
        x = (level - row[0]) / (row[WIDTH] - row[0])
    for _ in range(_ROUNDS):
        lagrange(scheme.c, scheme.weights, WIDTH + 1, x, basis)
        excess = product(basis, row) - level
        if excess > 0.0:
            high = x
        else:
            low = x
        slope = product(basis, slopes)
        step = excess / slope if slope > 0.0 else 2.0
        if abs(step) < _STEP or high - low < _STEP:
            break
        x -= step
        if not low <= x <= high:
            x = 0.5 * (low + high)
    return min(x, end)


@entry_point
def find_rising(scheme: Scheme, work: Work, rows: Any, share: float, levels: Any, elements: Any, places: Any) -> None:
    """Write the elements, and the places in them, at which a row that increases over E elements has ascending levels.

    `rows` has the shape (E, S + 1). The part `share` of the last element belongs to the row.
    """
    last, element = rows.shape[0] - 1, 0
    _differentiate(scheme, work, rows[0])
    for n in range(levels.shape[0]):
        while element < last and rows[element + 1, 0] <= levels[n]:
            element += 1
            _differentiate(scheme, work, rows[element])
        x = _place(scheme, work, rows[element], levels[n], share if element == last else 1.0)
        elements[n], places[n] = element, x


@compiled
def _sample(
    scheme: Scheme, work: Work, half: Any, last: int, share: float, end: float, times: Any, forces: Any, n: int
) -> int:
    """Write the forces of a half, from time n on, until its end; return the first time beyond."""
    element = 0
    _differentiate(scheme, work, half[0, T_])
    while n < times.shape[0] and times[n] < end:
        while element < last and half[element + 1, T_, 0] <= times[n]:
            element += 1
            _differentiate(scheme, work, half[element, T_])
        x = _place(scheme, work, half[element, T_], times[n], share if element == last else 1.0)
        forces[n] = max(value(scheme, work, half[element, F_], x), 0.0)
        n += 1
    return n


@entry_point
def sample_forces(scheme: Scheme, work: Work, times: Any, forces: Any) -> None:
    """Write the forces at ascending times; they are 0 before first touch and after separation."""
    n = 0
    while n < times.shape[0] and times[n] <= 0.0:
        forces[n] = 0.0
        n += 1
    last = work.counts[N_APPROACH]
    share = (work.turning_place[0] - work.places[START, last]) / work.places[LENGTH, last]
    n = _sample(scheme, work, work.approach, last, share, work.turning[T_], times, forces, n)
    last = work.counts[N_REBOUND]
    n = _sample(scheme, work, work.rebound, last, 1.0, work.rebound[last, T_, WIDTH], times, forces, n)
    forces[n:] = 0.0
