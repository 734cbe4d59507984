"""Fading memory of a piecewise polynomial: M_k(t) = int_0^t exp(-(t - t') r_k) f(t') dt', exact for polynomials.

On an element of length h, x in [-1, 1], with z = r_k h, the memory solves `M' = h f/2 - z M/2`. It is a polynomial
plus a transient c exp(-r_k (t - b)). Both forms below are exact for the polynomial f and differ in their rounding:

* z <= 2: no transient. The Legendre coefficients solve a tridiagonal system, by Olver's method for minimal solutions.
* z > 2: the polynomial that solves the equation, by a recurrence from the highest coefficient down, and the
  transient.
"""

import math
from functools import cache
from typing import Any, NamedTuple

import numpy as np
from numpy.polynomial import legendre

from restitution.checks import Array
from restitution.kernel.compile import compiled, entry_point, inlined
from restitution.kernel.path import Path
from restitution.kernel.references import by_reference

DEPTH, FORCE = 0, 1
# Rounding of a time over the time itself, and of Legendre coefficients over the largest of an element: a few units in
# the last place.
TIME_ROUNDING = COEFFICIENT_ROUNDING = 1e-15
# Length of the shortest element over the time of its start: its nodes must be distinct numbers.
SHORTEST_ELEMENT = 1e-14
# Number of Legendre coefficients of an element: resolves exp(-2 (1 + x)/2) to 1e-13.
TERMS = 12
# Largest z without a transient.
_STIFF = 2.0
# P_(n+1) = _ASCENT[n] x P_n - _DESCENT[n] P_(n-1)
_ASCENT = np.array([(2 * n + 1) / (n + 1) for n in range(TERMS)])
_DESCENT = np.array([n / (n + 1) for n in range(TERMS)])


@by_reference
class Quadrature(NamedTuple):
    """Gauss nodes of an element, and the matrix from values there to Legendre coefficients."""

    nodes: Array  # (TERMS,): in [-1, 1]
    weights: Array  # (TERMS,)
    coefficients: Array  # (TERMS, TERMS): row n maps the values at the nodes to the coefficient of P_n


@cache
def quadrature() -> Quadrature:
    """Gauss-Legendre quadrature with TERMS nodes."""
    nodes, weights = legendre.leggauss(TERMS)
    degrees = np.arange(TERMS)[:, None]
    coefficients = (degrees + 0.5) * weights * legendre.legvander(nodes, TERMS - 1).T
    return Quadrature(nodes, weights, np.ascontiguousarray(coefficients))


class Memory(NamedTuple):
    """Memory of K modes over E elements."""

    rates: Any  # (K,): r_k
    begin: Any  # (E + 1, K): values at the start of each element, and at the end of the last
    polynomial: Any  # (E, K, TERMS): legendre coefficients
    transient: Any  # (E, K): amplitude c of the transient


def allocate(rates: Array, elements: int) -> Memory:
    """Return the arrays for the memory of modes with these rates over a number of elements."""
    K = rates.size
    return Memory(rates, np.zeros((elements + 1, K)), np.empty((elements, K, TERMS)), np.empty((elements, K)))


@inlined
def legendre_values(x: float, basis: Any) -> None:
    """Write P_0(x) to P_(TERMS-1)(x)."""
    basis[0] = 1.0
    basis[1] = x
    for n in range(1, TERMS - 1):
        basis[n + 1] = _ASCENT[n] * x * basis[n] - _DESCENT[n] * basis[n - 1]


@inlined
def legendre_slopes(length: float, values: Any, slopes: Any) -> None:
    """Write the time derivatives of P_0 to P_(TERMS-1) in an element of this length, from their values `basis`."""
    slopes[0] = 0.0
    slopes[1] = 2.0 / length
    for n in range(1, TERMS - 1):
        slopes[n + 1] = slopes[n - 1] + (2 * n + 1) * 2.0 / length * values[n]


@entry_point
def remember(lengths: Any, f: Any, memory: Memory, sweep: Any) -> None:
    """Fill the memory of f, whose Legendre coefficients are rows of `f`, over elements of these lengths.

    If a length is 0, the integral of f has a jump: the first of the coefficients. `memory.begin[0]` is input, the
    rest is written; `sweep` is scratch space.
    """
    begin, polynomial, transient = memory.begin, memory.polynomial, memory.transient
    for e in range(lengths.shape[0]):
        h = lengths[e]
        terms = TERMS
        while terms > 1 and f[e, terms - 1] == 0.0:
            terms -= 1
        for k in range(memory.rates.shape[0]):
            # A jump passes undiminished into the memory, as no time goes by.
            if h == 0.0:
                transient[e, k] = 0.0
                begin[e + 1, k] = begin[e, k] + f[e, 0]
                for n in range(TERMS):
                    polynomial[e, k, n] = 0.0
                continue
            z = 0.5 * h * memory.rates[k]
            # A fast mode follows the polynomial and forgets its start; the recurrence downwards is stable for it.
            if 2.0 * z > _STIFF:
                start, end = _fast_series(f[e], 0.5 * h, z, terms, polynomial[e, k])
                c = begin[e, k] - start
                transient[e, k] = c
                begin[e + 1, k] = end + c * math.exp(-2.0 * z)
                continue
            transient[e, k] = 0.0
            begin[e + 1, k] = _slow_series(f[e], 0.5 * h, z, begin[e, k], polynomial[e, k], sweep)


@inlined
def _fast_series(f: Any, half: float, z: float, terms: int, y: Any) -> tuple[float, float]:
    """Write the polynomial y that solves y' = half f - z y; return its values at the ends of the element."""
    derivative_2, derivative_1, value_1 = 0.0, 0.0, 0.0
    start, end = 0.0, 0.0
    for n in range(TERMS - 1, -1, -1):
        if n >= terms:
            y[n] = 0.0
            continue
        # Coefficients of the derivative: y'_n/(2n + 1) = y_(n+1) + y'_(n+2)/(2n + 5).
        derivative = value_1 + derivative_2
        value = (half * f[n] - (2 * n + 1) * derivative) / z
        y[n] = value
        end += value
        start += value if n % 2 == 0 else -value
        derivative_2, derivative_1, value_1 = derivative_1, derivative, value
    return start, end


@inlined
def _slow_series(f: Any, half: float, z: float, start: float, y: Any, sweep: Any) -> float:
    """Write the polynomial y of y' = half f - z y that begins at `start`; return its value at the end.

    y_n = shift_n + up_n y_(n-1) from the top down; then y(-1) gives y_0.
    """
    up, shift = sweep[0], sweep[1]
    up[TERMS], shift[TERMS] = 0.0, 0.0
    for n in range(TERMS - 1, 0, -1):
        above = 1.0 / (2 * n + 3)
        below = 1.0 / (2 * n - 1)
        source = f[n - 1] * below
        if n + 1 < TERMS:
            source -= f[n + 1] * above
        pivot = 1.0 / (1.0 - z * above * up[n + 1])
        shift[n] = (half * source + z * above * shift[n + 1]) * pivot
        up[n] = -z * below * pivot
    factor, rest = 1.0, 0.0
    sum_factor, sum_rest = 1.0, 0.0
    for n in range(1, TERMS):
        rest = shift[n] + up[n] * rest
        factor *= up[n]
        sign = 1.0 if n % 2 == 0 else -1.0
        sum_factor += sign * factor
        sum_rest += sign * rest
    value = (start - sum_rest) / sum_factor
    end = value
    y[0] = value
    for n in range(1, TERMS):
        value = shift[n] + up[n] * value
        y[n] = value
        end += value
    return end


@inlined
def recall(memory: Memory, e: int, k: int, elapsed: float, basis: Any) -> float:
    """Memory of mode k at the time `elapsed` after the start of element e; `basis` are Legendre polynomials there."""
    value = 0.0
    for n in range(TERMS):
        value += basis[n] * memory.polynomial[e, k, n]
    c = memory.transient[e, k]
    # Slow modes have no transient, and exp is the dearest operation here.
    if c != 0.0:
        value += c * math.exp(-elapsed * memory.rates[k])
    return value


@inlined
def recall_rate(memory: Memory, e: int, k: int, elapsed: float, slopes: Any) -> float:
    """Return the rate of the memory of mode k: f - r_k M, but without cancellation in fast modes."""
    rate = 0.0
    for n in range(TERMS):
        rate += slopes[n] * memory.polynomial[e, k, n]
    c = memory.transient[e, k]
    if c != 0.0:
        rate -= memory.rates[k] * c * math.exp(-elapsed * memory.rates[k])
    return rate


@by_reference
class ScaledContact(NamedTuple):
    """Materials, profile and prescribed history; dimensionless, first touch at t = 0, F = E Pi for an elastic body."""

    control: int  # DEPTH or FORCE: which of the two is prescribed
    # (m + 1,): times at which the segments of the history start, and its end; two equal ones enclose a jump
    knots: Any
    # (m, n): coefficients of the prescribed quantity over u = (t - knots[i])/(knots[i + 1] - knots[i]), constant first
    values: Any
    equilibrium: float  # E(t) = equilibrium + viscosity delta(t) + sum moduli_k exp(-rates_k t)
    moduli: Any
    rates: Any
    viscosity: float
    shortest: float  # Shortest relaxation time, at most the duration
    glass: float  # J(t) = glass + sum compliances_j (1 - exp(-recoveries_j t))/recoveries_j; a recovery of 0 is flow
    compliances: Any
    recoveries: Any
    level: Memory  # Memory of F at the rates `recoveries` over the segments; only under a prescribed force
    slope: Memory  # The same of F'
    path: Path  # The profile


@by_reference
class Scratch(NamedTuple):
    """Scratch space of K modes."""

    basis: Any  # (TERMS,): legendre polynomials
    slopes: Any  # (TERMS,): their derivatives by time
    samples: Any  # (2, TERMS): rates at the nodes of an element
    now: Any  # (K,): memory of the depth
    sweep: Any  # (2, TERMS + 1): for `remember`


@inlined
def prescribed(contact: ScaledContact, i: int, t: float) -> tuple[float, float, float]:
    """Return the prescribed quantity and its first two derivatives in segment i at time t; behind a jump."""
    h = contact.knots[i + 1] - contact.knots[i]
    u = 1.0 if h == 0.0 else (t - contact.knots[i]) / h
    value, rate, curvature = 0.0, 0.0, 0.0
    for n in range(contact.values.shape[1] - 1, -1, -1):
        curvature = curvature * u + rate
        rate = rate * u + value
        value = value * u + contact.values[i, n]
    if h == 0.0:
        return value, 0.0, 0.0
    return value, rate / h, 2.0 * curvature / (h * h)


@by_reference
class Segments(NamedTuple):
    """The prescribed quantity over the m segments of its history: Legendre coefficients of its rate and value."""

    lengths: Any  # (m,)
    rates: Any  # (m, TERMS); the jump and zeros if the length is 0
    levels: Any  # (m, TERMS); zeros if the length is 0


@compiled
def expand_segments(contact: ScaledContact, quadrature: Quadrature, first: int, segments: Segments) -> None:
    """Write the lengths and the Legendre coefficients of the segments from `first` on."""
    for i in range(first, contact.values.shape[0]):
        h = contact.knots[i + 1] - contact.knots[i]
        segments.lengths[i] = h
        for n in range(TERMS):
            segments.rates[i, n] = 0.0
            segments.levels[i, n] = 0.0
        if h == 0.0:
            for n in range(1, contact.values.shape[1]):
                segments.rates[i, 0] += contact.values[i, n]
            continue
        for j in range(TERMS):
            t = contact.knots[i] + 0.5 * h * (1.0 + quadrature.nodes[j])
            value, rate, _ = prescribed(contact, i, t)
            for n in range(TERMS):
                segments.rates[i, n] += quadrature.coefficients[n, j] * rate
                segments.levels[i, n] += quadrature.coefficients[n, j] * value
        drop_rounding(segments.rates[i])
        drop_rounding(segments.levels[i])


@inlined
def expand(quadrature: Quadrature, samples: Any, coefficients: Any) -> None:
    """Write the Legendre coefficients of the polynomial with these values at the nodes."""
    for n in range(TERMS):
        coefficients[n] = 0.0
        for j in range(TERMS):
            coefficients[n] += quadrature.coefficients[n, j] * samples[j]


@inlined
def truncation_error(coefficients: Any) -> float:
    """Estimate of the truncation error of a Legendre series: the size of its last two coefficients."""
    return abs(coefficients[TERMS - 1]) + abs(coefficients[TERMS - 2])


@inlined
def variation(values: Any) -> float:
    """Return the difference of the largest and the smallest of the values at the nodes of an element."""
    least, most = values[0], values[0]
    for n in range(1, TERMS):
        least = min(least, values[n])
        most = max(most, values[n])
    return most - least


@inlined
def drop_rounding(coefficients: Any) -> None:
    """Set the last coefficients to zero if they are rounding, which makes the memory of a short series cheaper."""
    size = 0.0
    for n in range(TERMS):
        size = max(size, abs(coefficients[n]))
    for n in range(TERMS - 1, -1, -1):
        if abs(coefficients[n]) > COEFFICIENT_ROUNDING * size:
            return
        coefficients[n] = 0.0
