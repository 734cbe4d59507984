"""Prescribed depth or force and the contact under it, in dimensionless numbers for the kernel."""

from typing import Any, NamedTuple

from restitution.kernel.compile import entry_point, inlined
from restitution.kernel.memory import TERMS, Memory, Quadrature
from restitution.kernel.path import Path

DEPTH, FORCE = 0, 1
# Rounding of a time over the time itself, and of Legendre coefficients over the largest of an element: a few units in
# the last place.
TIME_ROUNDING = COEFFICIENT_ROUNDING = 1e-15
# Length of the shortest element over the time of its start: its nodes must be distinct numbers.
SHORTEST_ELEMENT = 1e-14


class Contact(NamedTuple):
    """Materials, profile and prescribed history; dimensionless, first touch at t = 0, F = E Pi for an elastic body.

    Attributes
    ----------
    control : int
        DEPTH or FORCE: which of the two is prescribed.
    knots : ndarray, shape (m + 1,)
        Times at which the segments of the history start, and its end; two equal ones enclose a jump.
    values : ndarray, shape (m, n)
        Coefficients of the prescribed quantity over u = (t - knots[i])/(knots[i + 1] - knots[i]), constant first.
    equilibrium, moduli, rates, viscosity : float or ndarray
        E(t) = equilibrium + viscosity delta(t) + sum moduli_k exp(-rates_k t).
    shortest : float
        Shortest relaxation time, or the duration where that is less.
    glass, compliances, recoveries : float or ndarray
        J(t) = glass + sum compliances_j (1 - exp(-recoveries_j t))/recoveries_j; a recovery of 0 is flow.
    level, slope : Memory
        Memory of F and of F' over the segments, at the rates `recoveries`; under a prescribed force only.
    path : Path
        The profile.
    """

    control: int
    knots: Any
    values: Any
    equilibrium: float
    moduli: Any
    rates: Any
    viscosity: float
    shortest: float
    glass: float
    compliances: Any
    recoveries: Any
    level: Memory
    slope: Memory
    path: Path


class Scratch(NamedTuple):
    """Scratch space of K modes.

    Attributes
    ----------
    basis : ndarray, shape (TERMS,)
        Legendre polynomials.
    slopes : ndarray, shape (TERMS,)
        Their derivatives by time.
    samples : ndarray, shape (2, TERMS)
        Rates at the nodes of an element.
    now : ndarray, shape (K,)
        Memory of the depth.
    sweep : ndarray, shape (2, TERMS + 1)
        For `remember`.
    """

    basis: Any
    slopes: Any
    samples: Any
    now: Any
    sweep: Any


@inlined
def prescribed(contact: Contact, i: int, t: float) -> tuple[float, float, float]:
    """Prescribed quantity, its rate and the rate of that, in segment i at time t; the value behind a jump."""
    h = contact.knots[i + 1] - contact.knots[i]
    u = 1.0 if h == 0.0 else (t - contact.knots[i]) / h
    value = 0.0
    rate = 0.0
    curvature = 0.0
    for n in range(contact.values.shape[1] - 1, -1, -1):
        curvature = curvature * u + rate
        rate = rate * u + value
        value = value * u + contact.values[i, n]
    if h == 0.0:
        return value, 0.0, 0.0
    return value, rate / h, 2.0 * curvature / (h * h)


@entry_point
def segment_rates(contact: Contact, quadrature: Quadrature, first: int, rates: Any, levels: Any) -> None:
    """Write the Legendre coefficients of the prescribed rate and value over the segments from `first` on."""
    for i in range(first, contact.values.shape[0]):
        h = contact.knots[i + 1] - contact.knots[i]
        for n in range(TERMS):
            rates[i - first, n] = 0.0
            levels[i - first, n] = 0.0
        if h == 0.0:
            continue
        for j in range(TERMS):
            t = contact.knots[i] + 0.5 * h * (1.0 + quadrature.nodes[j])
            value, rate, _ = prescribed(contact, i, t)
            for n in range(TERMS):
                rates[i - first, n] += quadrature.coefficients[n, j] * rate
                levels[i - first, n] += quadrature.coefficients[n, j] * value
        drop_rounding(rates[i - first])
        drop_rounding(levels[i - first])


@inlined
def truncation_error(coefficients: Any) -> float:
    """Truncation error of a Legendre series, about: the size of its last two coefficients."""
    return abs(coefficients[TERMS - 1]) + abs(coefficients[TERMS - 2])


@inlined
def variation(values: Any) -> float:
    """Difference of the largest and the smallest of the values at the nodes of an element."""
    least = values[0]
    most = values[0]
    for n in range(1, TERMS):
        least = min(least, values[n])
        most = max(most, values[n])
    return most - least


@inlined
def drop_rounding(coefficients: Any) -> None:
    """Set coefficients to zero that are rounding, which makes the memory of a short series cheaper."""
    size = 0.0
    for n in range(TERMS):
        size = max(size, abs(coefficients[n]))
    for n in range(TERMS - 1, -1, -1):
        if abs(coefficients[n]) > COEFFICIENT_ROUNDING * size:
            return
        coefficients[n] = 0.0
