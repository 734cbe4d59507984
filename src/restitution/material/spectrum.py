"""Relaxation spectra of springpots and their quadrature over the logarithm of the rate."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

# ln(eps) = -37: what is smaller than exp(-37) of the whole is left out.
_LN_EPS = 37.0
_TAIL_NODES = 3


def log_spectrum(exponent: float, bounded: bool, log_rates: Array) -> Array:
    """Logarithm of the spectrum H, with R(t) = int H exp(-lambda t) dln(lambda), at ln(lambda).

    Bounded: that of E_alpha(-t^alpha), H = sin(pi alpha)/pi x/(1 + 2x cos(pi alpha) + x^2), x = lambda^alpha
    (Mainardi, *Fractional Calculus and Waves in Linear Viscoelasticity* (2010), appendix E). Unbounded:
    that of the power law t^-alpha/Gamma(1 - alpha), H = sin(pi alpha)/pi lambda^alpha.
    """
    angle = math.pi * exponent
    scale = math.log(math.sin(angle) / math.pi)
    if not bounded:
        return scale + exponent * log_rates
    # H is even in ln(lambda): 1/(4 sinh^2 + 4 cos^2), where nothing cancels as alpha nears 1.
    half = np.abs(0.5 * exponent * log_rates)
    growth = -np.expm1(-2.0 * half)
    return scale - 2.0 * half - np.log(growth * growth + 4.0 * math.cos(0.5 * angle) ** 2 * np.exp(-2.0 * half))


def log_grid(exponent: float, bounded: bool, step: float, low: float, high: float) -> tuple[Array, Array]:
    """Nodes u of a trapezoidal rule from u = low to u >= high, and their weights; the error is exp(-pi^2/step).

    H exp(-lambda t) is analytic and bounded for |Im u| < pi/2, save for the poles of the bounded H at
    u = +-i pi (1 - alpha)/alpha = +-i delta. Where these are nearer, the rule is in the variable
    w = u + asinh(u/delta), which moves them away from the real axis and costs a few terms close to u = 0.
    """
    delta = math.pi * (1.0 - exponent) / exponent
    if not bounded or delta >= 0.5 * math.pi:
        count = max(math.ceil((high - low) / step), 0) + 1
        nodes = low + step * np.arange(count, dtype=np.float64)
        return nodes, np.full(nodes.size, step)
    start, end = (u + math.asinh(u / delta) for u in (low, high))
    w = start + step * np.arange(max(math.ceil((end - start) / step), 0) + 1)
    size = np.abs(w)
    u = np.maximum(size - np.arcsinh(size / delta), 0.0)
    for _ in range(60):
        # Concave, so Newton's steps approach from below.
        change = (size - u - np.arcsinh(u / delta)) / (1.0 + 1.0 / np.hypot(u, delta))
        u = u + change
        if np.all(np.abs(change) <= 1e-14 * size):
            break
    return np.copysign(u, w), step / (1.0 + 1.0 / np.hypot(u, delta))


def mittag_leffler(time: Array, exponent: float) -> Array:
    """Mittag-Leffler function E_alpha(-t^alpha) at t >= 0, by the trapezoidal rule over its spectrum, to 1e-12."""
    flat = time.ravel()
    result = np.empty_like(flat)
    reach = _LN_EPS / exponent
    for i, t in enumerate(flat):
        late = math.log(t) if t > 0 else -math.inf
        top = min(reach, math.log(45.0) - late)
        bottom = min(-reach - max(late, 0.0), top)
        u, steps = log_grid(exponent, True, math.pi**2 / _LN_EPS, bottom, top)
        decay = np.exp(np.minimum(u + late, 7.0)) if t > 0 else np.zeros(u.size)
        result[i] = steps @ np.exp(log_spectrum(exponent, True, u) - decay)
    return result.reshape(time.shape)


def discretise(
    exponent: float, bounded: bool, low: float, high: float, tolerance: float, coarseness: float
) -> tuple[Array, Array]:
    """Branch moduli and relaxation times of a spectrum that matter between two times, in its unit of time.

    The `coarseness` is a factor on the step that theory gives for the tolerance; 1 is safe.
    """
    digits = math.log(4.0 / tolerance)
    step = coarseness * math.pi**2 / digits
    # exp(-lambda t) of a slower term is a polynomial in the window; a faster term has decayed before it.
    first = math.log(tolerance ** (0.5 / _TAIL_NODES) / high)
    last = math.log(max(digits, 4.0) / low)
    # A bounded spectrum has its peak at u = 0.
    deepest = (min(first, 0.0) if bounded else first) - _LN_EPS / exponent
    highest = last + _LN_EPS / (1.0 - exponent)
    u, steps = log_grid(exponent, bounded, step, deepest, highest)
    logs = np.log(steps) + log_spectrum(exponent, bounded, u)
    slow, fast = u < first, u > last
    inside = ~(slow | fast)
    rates, shares = _gauss(np.exp(u[slow] - first), np.exp(logs[slow]))
    # A fast branch acts through its viscosity, so its weight is multiplied by its time.
    times, viscosities = _gauss(np.exp(last - u[fast]), np.exp(logs[fast] + last - u[fast]))
    return (
        np.concatenate((viscosities / times, np.exp(logs[inside])[::-1], shares)),
        np.concatenate((times * math.exp(-last), np.exp(-u[inside])[::-1], math.exp(-first) / rates)),
    )


def _gauss(points: Array, weights: Array) -> tuple[Array, Array]:
    """Nodes and weights of the Gauss rule of a discrete positive measure, by the Lanczos process.

    Golub and Welsch, Math. Comp. 23 (1969) 221.
    """
    keep = weights > weights.max() * 1e-300
    points, weights = points[keep], weights[keep]
    total = weights.sum()
    vector, previous = np.sqrt(weights / total), np.zeros(points.size)
    diagonal, beside = [], []
    link = 0.0
    for _ in range(min(_TAIL_NODES, points.size)):
        image = points * vector - link * previous
        diagonal.append(float(image @ vector))
        image = image - diagonal[-1] * vector
        link = float(np.sqrt(image @ image))
        if link <= 1e-14 * abs(diagonal[0]):
            break
        beside.append(link)
        previous, vector = vector, image / link
    beside = beside[: len(diagonal) - 1]
    matrix = np.diag(diagonal) + np.diag(beside, 1) + np.diag(beside, -1)
    nodes, vectors = np.linalg.eigh(matrix)
    return np.asarray(nodes, dtype=np.float64), total * np.asarray(vectors[0], dtype=np.float64) ** 2
