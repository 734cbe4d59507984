"""Kinks of a profile: elements end at the kinks that matter.

Beyond a kink `a = smooth + strength z^p` with z = s - kink and a half-integer p >= 3/2. The force has a term z^(p+1),
or z^p with a dashpot, and the velocity one of z^(p+2), or z^(p+1) if the target moves. An element that contains the
kink loses its order. The end of an element that begins there is only as accurate as its inside.
"""

from typing import Any

from restitution.kernel.collocation import Scheme, combine, crossing, interpolate_lanes, value
from restitution.kernel.compile import compiled, inlined
from restitution.kernel.lanes import WIDTH, absolute, largest, read8, total
from restitution.kernel.path import cells_between, table_radii_and_integrals
from restitution.kernel.workspace import INTEGRAL, MODES_, S_, UNKNOWN, V_, VALUES, Problem, Work

# Approximate distance between nodes over the length of an element, which does not resolve a kink within it.
SPACING = 1.0 / 6.0
_TAIL = 2e-5  # bound of the tail of z^(p+2) over its value at the end of an element
_FEW_CELLS = 1  # ends of cells of the table within an element up to which a(s) counts as smooth
_MEAN = 0.5  # share of the acceleration in the first estimate of a path
_TURNING = 0.6  # path of a decelerating body to its turning point over v^2/|dv/dsigma|, with a margin
_NEGLIGIBLE = 0.1  # share of the allowed effect below which the distance to a kink does not matter
_NO_TAIL = 1e-300


@inlined
def kink_effect(problem: Problem, glass: float, kink: int, v: float, z: float, h: float) -> float:
    """Bound of the changes of velocity and s due to a kink up to z beyond it, at velocity v within h of sigma."""
    path = problem.path
    s, p = path.kinks[kink], path.power
    radius = abs(path.strengths[kink]) * z**p
    # Pi changes by int strength z^p 2 s dz; the modes add at most the glassy modulus, the dashpot eta a v.
    force = (glass * 2.0 * s * z / (p + 1.0) + problem.viscosity * v) * radius
    return (2.0 * s + problem.admittance) * force * min(z / v, h)


@compiled
def next_kink(
    problem: Problem, glass: float, first: int, s: float, v: float, slope: float, h: float, allowed: float
) -> int:
    """Return the first kink, from `first` on, that matters to an element of length h from s; -1 if there is none."""
    kinks = problem.path.kinks
    reach = h * v + max(_MEAN * slope, 0.0) * h * h
    # A body that slows down does not reach further than its turning point.
    if slope < 0.0:
        reach = min(reach, _TURNING * v * v / -slope)
    kink = first
    while kink < kinks.shape[0] and kinks[kink] < s + reach:
        z = min(s + reach - kinks[kink], SPACING * reach)
        if kink_effect(problem, glass, kink, v, z, h) > allowed:
            return kink
        kink += 1
    return -1


@inlined
def length_beyond(problem: Problem, glass: float, kink: int, v: float, h: float, allowed: float) -> float:
    """Return the length, at most h, of an element that begins at a kink, such that its tail is about `allowed`."""
    tail = _TAIL * kink_effect(problem, glass, kink, v, h * v, h)
    p = problem.path.power
    power = 1.0 / (p + 1.0) if problem.viscosity > 0.0 or problem.admittance > 0.0 else 1.0 / (p + 2.0)
    return h * min(1.0, (allowed / max(tail, _NO_TAIL)) ** power)


@inlined
def passed(kinks: Any, first: int, s: float) -> int:
    """Return the first kink beyond s, from `first` on."""
    kink = first
    while kink < kinks.shape[0] and kinks[kink] <= s:
        kink += 1
    return kink


@compiled
def length_correction(
    problem: Problem,
    scheme: Scheme,
    work: Work,
    table: Any,
    glass: float,
    target: int,
    h: float,
    allowed: float,
) -> float:
    """Factor of the length with which a solved element ends at a kink; 1 if the difference does not matter."""
    end = problem.path.kinks[target]
    s, v = table[S_, WIDTH], table[V_, WIDTH]
    top = 1.0
    # Only the part up to the turning point belongs to the approach.
    if v <= 0.0:
        top = crossing(scheme, work, table[V_], 0.0, 1.0)
        s = value(scheme, work, table[S_], top)
        if s <= end:
            return 1.0
    if kink_effect(problem, glass, target, table[V_, 0], abs(s - end), h) <= _NEGLIGIBLE * allowed:
        return 1.0
    if s > end:
        return crossing(scheme, work, table[S_], end, top)
    return 1.0 + min((end - s) / (v * h), 1.0)


@inlined
def _missed(scheme: Scheme, h: float, at_nodes: Any, between: Any, noise: float) -> float:
    """Return the errors of the integral of a rate over the two parts of an element, less the noise of the table."""
    early, late = read8(scheme.missed, 0, 0) * at_nodes, read8(scheme.missed, 1, 0) * between
    last = total(read8(scheme.c, 1) * early + read8(scheme.between, 0) * late)
    missed = abs(last) + abs(total(early + late) - last)
    return h * (missed - noise * largest(absolute(at_nodes)))


@compiled
def missed_approach(problem: Problem, scheme: Scheme, work: Work, table: Any, h: float, noise: float) -> float:
    """Return the error of the velocity in an element of the approach due to a rough a(s), less the noise of the table.

    Modes that relax within the element act as a dashpot.
    """
    if cells_between(problem.path, table[S_, 0], largest(read8(table, S_, 1))) <= _FEW_CELLS:
        return 0.0
    elastic, viscosity = problem.equilibrium, problem.viscosity
    for k in range(problem.moduli.shape[0]):
        slow = problem.times[k] / (problem.times[k] + 2.0 * h * table[S_, WIDTH])
        elastic += problem.moduli[k] * slow
        viscosity += problem.moduli[k] * (1.0 - slow) * problem.times[k]
    a, Pi = read8(work.vectors, VALUES, 0), read8(work.vectors, VALUES + 1, 0)
    at_nodes = 2.0 * read8(table, S_, 1) * (elastic * Pi + viscosity * a * read8(table, V_, 1))
    s = combine(scheme.at_between, WIDTH + 1, table[S_])
    v = combine(scheme.at_between, WIDTH + 1, table[V_])
    a, Pi = table_radii_and_integrals(problem.path, s, work.vectors[VALUES:])
    between = 2.0 * s * (elastic * Pi + viscosity * a * v)
    return _missed(scheme, h, at_nodes, between, noise)


@compiled
def missed_rebound(
    problem: Problem, scheme: Scheme, work: Work, table: Any, left: float, h: float, hint: int, noise: float
) -> float:
    """Return the same error in an element of the rebound, which starts at the place `left` of the approach."""
    if cells_between(problem.path, table[S_, WIDTH], table[S_, 0]) <= _FEW_CELLS:
        return 0.0
    phi = problem.equilibrium
    for k in range(problem.moduli.shape[0]):
        phi += problem.moduli[k] * table[MODES_ + 2 * k, 0]
    u = work.vectors[UNKNOWN]
    at_nodes = phi * read8(u, 0) * read8(work.vectors, INTEGRAL, 0)
    interpolate_lanes(scheme, work, work.approach, left - h * read8(scheme.between, 0), hint, work.past[:1])
    Pi = table_radii_and_integrals(problem.path, read8(work.past, S_, 0), work.vectors[VALUES:])[1]
    between = phi * combine(scheme.at_between_inner, WIDTH, u) * Pi
    return _missed(scheme, h, at_nodes, between, noise)
