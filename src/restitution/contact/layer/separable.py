"""Effective modulus of a bonded layer whose Poisson ratio relaxes: a separable approximation."""

from __future__ import annotations

from functools import lru_cache

import numpy as np

from restitution.contact.geometry import Array
from restitution.errors import InputError
from restitution.material.prony import PronySeries
from restitution.material.viscoelastic import Material, reduced_modulus

# Place of the stiffness between the centre and the edge of the largest contact; fitted to six finite-element impacts.
_PLACE = 0.8
# Real points of the Carson transform, decades beyond the relaxation times, relaxation times of the fit in each.
_POINTS, _BEYOND, _PER_DECADE = 61, 2.0, 6
# Poisson ratios at which the stiffness is computed, and the largest relative misfit.
_RATIOS, _MISFIT = 14, 1e-3
_NODES, _PER_RADIUS = 24, 8


def effective_modulus(material: Material, size: float) -> PronySeries:
    """Reduced modulus [Pa] that gives a layer of the static Poisson ratio the stiffness of the relaxing one.

    Parameters
    ----------
    material : Material
        Material with a Poisson ratio that changes in time.
    size : float
        Largest contact radius over the thickness, a_max/h.

    Notes
    -----
    The Carson transform ``E*(s) kappa(x; nu(s))/kappa(x; nu_static)`` at ``x = 0.8 a_max/h``, as a Prony series by
    nonnegative least squares. A flat punch of this size has exactly this modulus.
    """
    from scipy.optimize import nnls

    series, bulk = reduced_modulus(material), material.bulk
    parts = [series, material.shear, *([bulk] if isinstance(bulk, PronySeries) else [])]
    if any(part.parallel_viscosity > 0.0 for part in parts):
        wanted = "must have no parallel dashpot on a bonded layer, where its Poisson ratio relaxes to -1"
        raise InputError("material", wanted=wanted)
    known = np.concatenate([part.relaxation_times for part in parts])
    low, high = known.min() / 10.0**_BEYOND, known.max() * 10.0**_BEYOND
    s = 1.0 / np.geomspace(low, high, _POINTS)
    shear = np.asarray(material.shear.carson_transform(s))
    volume = np.asarray(bulk.carson_transform(s)) if isinstance(bulk, PronySeries) else np.full(s.shape, bulk)
    poisson_ratio = (3.0 * volume - 2.0 * shear) / (6.0 * volume + 2.0 * shear)
    ratios = np.append(poisson_ratio, material.poisson_ratio)
    stiffness = _stiffness(ratios, _PLACE * size)
    target = np.asarray(series.carson_transform(s)) * stiffness[:-1] / stiffness[-1]
    times = np.geomspace(low, high, max(2, round(_PER_DECADE * np.log10(high / low))))
    times = np.unique(np.concatenate([times, series.relaxation_times]))
    share = s[:, None] / (s[:, None] + 1.0 / times)
    weights, _ = nnls(share / target[:, None], 1.0 - series.equilibrium_modulus / target, maxiter=100 * times.size)
    kept = weights > 0.0
    found = PronySeries(series.equilibrium_modulus, weights[kept], times[kept])
    misfit = float(np.max(np.abs(np.asarray(found.carson_transform(s)) / target - 1.0)))
    if misfit > _MISFIT:
        wanted = f"must have a stiffness on the layer that only relaxes: a Prony series misses it by {misfit:.2g}"
        raise InputError("material", wanted=wanted)
    return found


def _stiffness(poisson_ratio: Array, radius: float) -> Array:
    """Stiffness kappa of a flat punch of a radius in units of the thickness, for many Poisson ratios."""
    low, high = float(poisson_ratio.min()), float(poisson_ratio.max())
    angle = np.pi * (np.arange(_RATIOS) + 0.5) / _RATIOS
    nodes = 0.5 * (low + high) + 0.5 * (high - low) * np.cos(angle)
    values = np.log([_punch(float(one), radius) for one in nodes])
    fit = np.polynomial.Chebyshev.fit(nodes, values, _RATIOS - 1, domain=[low, high])
    return np.exp(fit(poisson_ratio))


@lru_cache(maxsize=256)
def _punch(poisson_ratio: float, radius: float) -> float:
    # Numba takes half a second to import.
    from restitution.contact.layer.compliance import LineKernel
    from restitution.contact.layer.line_loads import solve_line_loads

    kernel, count = LineKernel(poisson_ratio), int(_NODES + _PER_RADIUS * radius)
    nodes, weights = np.polynomial.legendre.leggauss(count)
    nodes, weights = 0.5 + 0.5 * nodes, 0.5 * weights
    lines, ends = np.empty((1, 2, count)), np.empty((1, 2))
    space = np.empty((count, count)), np.empty(count)
    solve_line_loads(kernel.cells, kernel.per_unit, np.array([radius]), nodes, weights, *space, lines, ends)
    return float(ends[0, 0]) / radius
