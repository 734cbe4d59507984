"""Fading memory of a piecewise polynomial: M_k(t) = int_0^t exp(-(t - t') r_k) f(t') dt', exact for polynomials.

On an element of length h, x in [-1, 1], with z = r_k h, the memory solves `M' = h f/2 - z M/2` and is a polynomial plus a
transient c exp(-r_k (t - b)). Both forms below are exact for the polynomial f; they differ in what rounding leaves of them:

* z <= 2: no transient. The Legendre coefficients solve a tridiagonal system, backwards as by Olver for minimal solutions.
* z > 2: the polynomial that solves the equation, by the recurrence from the highest coefficient down, and the transient.
"""

import math
from functools import cache
from typing import Any, NamedTuple

import numpy as np
from numpy.polynomial import legendre
from numpy.typing import NDArray

from restitution.kernel.compile import entry_point, inlined

Array = NDArray[np.float64]

# Number of Legendre coefficients of an element: resolves exp(-2 (1 + x)/2) to 1e-13.
TERMS = 12
_STIFF = 2.0
# P_(n+1) = _ASCENT[n] x P_n - _DESCENT[n] P_(n-1)
_ASCENT = np.array([(2 * n + 1) / (n + 1) for n in range(TERMS)])
_DESCENT = np.array([n / (n + 1) for n in range(TERMS)])


class Quadrature(NamedTuple):
    """Gauss nodes of an element and what maps values there to Legendre coefficients.

    Attributes
    ----------
    nodes : ndarray, shape (TERMS,)
        In [-1, 1].
    weights : ndarray, shape (TERMS,)
    coefficients : ndarray, shape (TERMS, TERMS)
        Row n maps the values at the nodes to the coefficient of P_n.
    """

    nodes: Array
    weights: Array
    coefficients: Array


@cache
def quadrature() -> Quadrature:
    """Gauss-Legendre quadrature with TERMS nodes."""
    nodes, weights = legendre.leggauss(TERMS)
    degrees = np.arange(TERMS)[:, None]
    coefficients = (degrees + 0.5) * weights * legendre.legvander(nodes, TERMS - 1).T
    return Quadrature(nodes, weights, np.ascontiguousarray(coefficients))


class Memory(NamedTuple):
    """Memory of K modes over E elements.

    Attributes
    ----------
    rates : ndarray, shape (K,)
        r_k.
    begin : ndarray, shape (E + 1, K)
        Values at the start of each element, and at the end of the last.
    polynomial : ndarray, shape (E, K, TERMS)
        Legendre coefficients.
    transient : ndarray, shape (E, K)
        Amplitude c of the transient.
    """

    rates: Any
    begin: Any
    polynomial: Any
    transient: Any


def allocate(rates: Array, elements: int) -> Memory:
    """Room for the memory of modes of these rates over a number of elements."""
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
    """Write the derivatives of P_0 to P_(TERMS-1) by the time in an element of this length, from their values."""
    slopes[0] = 0.0
    slopes[1] = 2.0 / length
    for n in range(1, TERMS - 1):
        slopes[n + 1] = slopes[n - 1] + (2 * n + 1) * 2.0 / length * values[n]


@entry_point
def remember(lengths: Any, f: Any, jumps: Any, memory: Memory, sweep: Any) -> None:
    """Fill the memory of f.

    Parameters
    ----------
    lengths : ndarray, shape (E,)
        Lengths of the elements; 0 where the integral of f jumps.
    f : ndarray, shape (E, TERMS)
        Legendre coefficients of f.
    jumps : ndarray, shape (E,)
        What the integral of f jumps by in an element of length 0.
    memory : Memory
        `begin[0]` holds the values at the start; the rest is written.
    sweep : ndarray, shape (2, TERMS + 1)
        Scratch space.
    """
    begin, polynomial, transient = memory.begin, memory.polynomial, memory.transient
    up, shift = sweep[0], sweep[1]
    for e in range(lengths.shape[0]):
        h = lengths[e]
        terms = TERMS
        while terms > 1 and f[e, terms - 1] == 0.0:
            terms -= 1
        for k in range(memory.rates.shape[0]):
            if h == 0.0:
                transient[e, k] = 0.0
                begin[e + 1, k] = begin[e, k] + jumps[e]
                for n in range(TERMS):
                    polynomial[e, k, n] = 0.0
                continue
            z = 0.5 * h * memory.rates[k]
            if 2.0 * z > _STIFF:
                derivative_2 = 0.0
                derivative_1 = 0.0
                value_1 = 0.0
                start = 0.0
                end = 0.0
                for n in range(TERMS - 1, -1, -1):
                    if n >= terms:
                        polynomial[e, k, n] = 0.0
                        continue
                    # Coefficients of the derivative: y'_n/(2n + 1) = y_(n+1) + y'_(n+2)/(2n + 5).
                    derivative = value_1 + derivative_2
                    value = (0.5 * h * f[e, n] - (2 * n + 1) * derivative) / z
                    polynomial[e, k, n] = value
                    end += value
                    start += value if n % 2 == 0 else -value
                    derivative_2 = derivative_1
                    derivative_1 = derivative
                    value_1 = value
                c = begin[e, k] - start
                transient[e, k] = c
                begin[e + 1, k] = end + c * math.exp(-2.0 * z)
                continue
            transient[e, k] = 0.0
            # y_n = shift_n + up_n y_(n-1) from the top down; then y(-1) gives y_0.
            up[TERMS] = 0.0
            shift[TERMS] = 0.0
            for n in range(TERMS - 1, 0, -1):
                above = 1.0 / (2 * n + 3)
                below = 1.0 / (2 * n - 1)
                source = f[e, n - 1] * below
                if n + 1 < TERMS:
                    source -= f[e, n + 1] * above
                pivot = 1.0 / (1.0 - z * above * up[n + 1])
                shift[n] = (0.5 * h * source + z * above * shift[n + 1]) * pivot
                up[n] = -z * below * pivot
            factor = 1.0
            rest = 0.0
            sum_factor = 1.0
            sum_rest = 0.0
            for n in range(1, TERMS):
                rest = shift[n] + up[n] * rest
                factor *= up[n]
                if n % 2 == 0:
                    sum_factor += factor
                    sum_rest += rest
                else:
                    sum_factor -= factor
                    sum_rest -= rest
            value = (begin[e, k] - sum_rest) / sum_factor
            end = value
            polynomial[e, k, 0] = value
            for n in range(1, TERMS):
                value = shift[n] + up[n] * value
                polynomial[e, k, n] = value
                end += value
            begin[e + 1, k] = end


@inlined
def recall(memory: Memory, e: int, k: int, elapsed: float, basis: Any) -> float:
    """Memory of mode k at the time `elapsed` after the start of element e, where the Legendre polynomials are `basis`."""
    value = 0.0
    for n in range(TERMS):
        value += basis[n] * memory.polynomial[e, k, n]
    c = memory.transient[e, k]
    if c != 0.0:
        value += c * math.exp(-elapsed * memory.rates[k])
    return value


@inlined
def recall_rate(memory: Memory, e: int, k: int, elapsed: float, slopes: Any) -> float:
    """Rate of the memory of mode k; f - r_k M without its cancellation where the mode is fast."""
    rate = 0.0
    for n in range(TERMS):
        rate += slopes[n] * memory.polynomial[e, k, n]
    c = memory.transient[e, k]
    if c != 0.0:
        rate -= memory.rates[k] * c * math.exp(-elapsed * memory.rates[k])
    return rate
