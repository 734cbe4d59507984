"""Effective modulus of a bonded layer whose Poisson ratio relaxes: a separable approximation."""

from __future__ import annotations

from functools import lru_cache

import numpy as np

from restitution.contact.geometry import Array
from restitution.contact.layer.compliance import LineKernel
from restitution.errors import InputError
from restitution.material.prony import PronySeries
from restitution.material.viscoelastic import Material, reduced_modulus

# Factors beyond the relaxation times: a thin layer of a liquid takes 40^2 times longer to become incompressible. The
# fit is the same for all radii, so that its result is smooth over them.
_BEFORE, _BEYOND = 1e-2, 1e5
# Real points of the Carson transform and relaxation times of the fit in a decade, and largest relative misfit.
_POINTS, _PER_DECADE, _MISFIT = 12, 10, 3e-3
# The logarithm of the stiffness is smooth over ln(1 - 2 nu + shift), even where a thin layer is nearly incompressible:
# the shift, and the number of nodes, which grows with the length of the interval.
_SHIFT, _FEWEST, _PER_UNIT = 1e-3, 6, 2
_NODES, _PER_RADIUS = 24, 8


def effective_modulus(material: Material, radius: float) -> PronySeries:
    """Reduced modulus [Pa] that gives a layer of the static Poisson ratio the stiffness of the relaxing one.

    Parameters
    ----------
    material : Material
        Material with a Poisson ratio that changes in time.
    radius : float
        Radius x of a flat punch over the thickness; 0 gives the modulus of the material.

    Notes
    -----
    The Carson transform ``E*(s) kappa(x; nu(s))/kappa(x; nu_static)`` as a Prony series by nonnegative least squares.
    A flat punch of this radius has exactly this modulus.
    """
    from scipy.optimize import nnls

    series, bulk = reduced_modulus(material), material.bulk
    if radius == 0.0:
        return series
    parts = [series, material.shear, *([bulk] if isinstance(bulk, PronySeries) else [])]
    known = np.concatenate([part.relaxation_times for part in parts])
    low, high = known.min() * _BEFORE, known.max() * _BEYOND
    decades = np.log10(high / low)
    s = 1.0 / np.geomspace(low, high, round(_POINTS * decades))
    shear = np.asarray(material.shear.carson_transform(s))
    volume = np.asarray(bulk.carson_transform(s)) if isinstance(bulk, PronySeries) else np.full(s.shape, bulk)
    poisson_ratio = (3.0 * volume - 2.0 * shear) / (6.0 * volume + 2.0 * shear)
    stiffness = _stiffness(np.append(poisson_ratio, material.poisson_ratio), radius)
    target = np.asarray(series.carson_transform(s)) * stiffness[:-1] / stiffness[-1]
    times = np.geomspace(low, high, round(_PER_DECADE * decades))
    times = np.unique(np.concatenate([times, series.relaxation_times]))
    share = s[:, None] / (s[:, None] + 1.0 / times)
    matrix, right = share / target[:, None], 1.0 - series.equilibrium_modulus / target
    weights, _ = nnls(matrix, right, maxiter=100 * times.size)
    # Some versions of nnls take the normal equations, which have half of the digits.
    weights[weights > 0.0] = np.linalg.lstsq(matrix[:, weights > 0.0], right)[0]
    kept = weights > 0.0
    found = PronySeries(series.equilibrium_modulus, weights[kept], times[kept])
    misfit = float(np.max(np.abs(np.asarray(found.carson_transform(s)) / target - 1.0)))
    if misfit > _MISFIT:
        wanted = f"must have a stiffness on the layer that only relaxes: a Prony series misses it by {misfit:.2g}"
        raise InputError("material", wanted=wanted)
    return found


def _stiffness(poisson_ratio: Array, radius: float) -> Array:
    """Stiffness radius of a flat punch, both in units of the thickness, for many Poisson ratios."""
    # Numba takes half a second to import.
    from restitution.contact.layer.line_loads import solve_line_loads

    place = np.log(1.0 + _SHIFT - 2.0 * poisson_ratio)
    low, high = place.min(), place.max()
    count = _FEWEST + round(_PER_UNIT * (high - low))
    places = 0.5 * (low + high) + 0.5 * (high - low) * np.polynomial.chebyshev.chebpts1(count)
    nodes, weights = _gauss(int(_NODES + _PER_RADIUS * radius))
    gauss = np.array([radius]), 0.5 + 0.5 * nodes, 0.5 * weights
    space = np.empty((nodes.size, nodes.size)), np.empty(nodes.size), np.empty((1, 2, nodes.size))
    ends, values = np.empty((1, 2)), np.empty(count)
    for n, one in enumerate(0.5 * (1.0 + _SHIFT - np.exp(places))):
        kernel = _line_kernel(float(one))
        solve_line_loads(kernel.cells, kernel.per_unit, *gauss, *space, ends)
        values[n] = np.log(ends[0, 0])
    return np.exp(np.polynomial.Chebyshev.fit(places, values, count - 1, domain=[low, high])(place))


# Contacts of many sizes on one material have the same Poisson ratios.
_line_kernel, _gauss = lru_cache(maxsize=64)(LineKernel), lru_cache(maxsize=64)(np.polynomial.legendre.leggauss)
