"""Effective modulus of a bonded layer whose Poisson ratio relaxes: a separable approximation.

Its Carson transform is ``E*(s) kappa(x; nu(s))/kappa(x; nu_static)`` for a flat punch of the radius x, in units of the
thickness. Moduli of many contacts are interpolated over x between nodes that depend neither on the contacts nor on
the material, so that each contact has the same modulus alone and beside others.
"""

from __future__ import annotations

from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from restitution.contact.geometry import Array
from restitution.contact.layer.compliance import LineKernel
from restitution.errors import InputError
from restitution.material.columns import PronyColumns
from restitution.material.prony import PronySeries
from restitution.material.viscoelastic import Material, reduced_modulus

# Factors beyond the relaxation times: a thin layer of a liquid takes 40^2 times longer to become incompressible. The
# times are the same for all radii, so that the result is smooth over them.
_BEFORE, _BEYOND = 1e-2, 1e5
# Real points of the Carson transform and relaxation times of the fit in a decade, and largest relative misfit.
_POINTS, _PER_DECADE, _MISFIT = 12, 10, 3e-3
# Every second time makes fewer terms; it is enough where the misfit is not above this.
_COARSE, _ENOUGH = 2, 2e-4
# The logarithm of the stiffness is smooth over ln(1 - 2 nu + shift), even where a thin layer is nearly incompressible.
# Its series has 1e-7 for all Poisson ratios from -1 to 1/2.
_SHIFT, _RATIOS = 1e-3, 20
_NODES, _PER_RADIUS = 24, 8
# Nodes x of the interpolation are at equal distances of ln(1 + x/scale). The last one is at 37.
_SCALE, _DISTANCE, _LAST = 0.25, 0.2, 25
# Cubic polynomials continue beyond the nodes.
_NEXT = 4.0, -6.0, 4.0, -1.0


class _Spectrum:
    """Points s of the Carson transform of a material, its values there, and the relaxation times of fits."""

    def __init__(self, material: Material) -> None:
        self.series, bulk = reduced_modulus(material), material.bulk
        parts = [self.series, material.shear, *([bulk] if isinstance(bulk, PronySeries) else [])]
        known = np.concatenate([part.relaxation_times for part in parts])
        low, high = known.min() * _BEFORE, known.max() * _BEYOND
        decades = np.log10(high / low)
        s = 1.0 / np.geomspace(low, high, round(_POINTS * decades))
        shear = np.asarray(material.shear.carson_transform(s))
        volume = np.asarray(bulk.carson_transform(s)) if isinstance(bulk, PronySeries) else np.full(s.shape, bulk)
        self._poisson_ratio = np.append((3.0 * volume - 2.0 * shear) / (6.0 * volume + 2.0 * shear), 0.0)
        self._poisson_ratio[-1] = material.poisson_ratio
        self._modulus = np.asarray(self.series.carson_transform(s))
        grid = np.geomspace(low, high, round(_PER_DECADE * decades))
        self.times, place = np.unique(np.append(grid, self.series.relaxation_times), return_index=True)
        self.coarse = np.flatnonzero((place % _COARSE == 0) | (place >= grid.size))
        self._shares = s[:, None] / (s[:, None] + 1.0 / self.times)

    def transform(self, radius: float) -> Array:
        """Carson transform [Pa] of the effective modulus for a punch of a radius over the thickness."""
        if radius == 0.0:
            return self._modulus
        ratio = self._poisson_ratio
        logarithm = _stiffness(radius)(np.log(1.0 + _SHIFT - 2.0 * ratio))
        return self._modulus * np.exp(logarithm[:-1] - logarithm[-1])

    def moduli(self, transform: Array) -> Array:
        """Branch moduli [Pa] >= 0 at the times, mostly zeros, whose series has a Carson transform [Pa]."""
        found, misfit = self.fitted(transform, np.arange(self.times.size))
        if misfit > _MISFIT:
            wanted = f"must have a stiffness on the layer that only relaxes: a Prony series misses it by {misfit:.2g}"
            raise InputError("material", wanted=wanted)
        return found

    def fitted(self, transform: Array, places: NDArray[np.intp]) -> tuple[Array, float]:
        """Branch moduli [Pa] by nonnegative least squares over some of the times, and the largest relative misfit."""
        from scipy.optimize import nnls

        matrix = self._shares[:, places] / transform[:, None]
        right = 1.0 - self.series.equilibrium_modulus / transform
        weights, _ = nnls(matrix, right, maxiter=100 * places.size)
        # Some versions of nnls take the normal equations, which have half of the digits.
        weights[weights > 0.0] = np.maximum(np.linalg.lstsq(matrix[:, weights > 0.0], right)[0], 0.0)
        moduli = np.zeros(self.times.size)
        moduli[places] = weights
        return moduli, float(np.max(np.abs(matrix @ weights - right)))


class EffectiveModuli:
    """Effective moduli of a material for flat punches of all radii up to 37 thicknesses, interpolated.

    Cubic B-splines over ``ln(1 + x/scale)`` combine the branch moduli of four fits at the same relaxation times. The
    splines are positive, so the moduli are as well. The fits are those of the values less a sixth of their second
    difference, which makes the sum exact for cubic polynomials.
    """

    def __init__(self, material: Material) -> None:
        self._spectrum = _Spectrum(material)
        self._transforms: dict[int, Array] = {}
        self._moduli: dict[int, Array] = {}
        self._between: dict[int, tuple[Array, Array]] = {}

    def at(self, radius: Array) -> PronyColumns:
        """Reduced moduli [Pa] for punches of radii over the thickness, shape (n,)."""
        place = np.log1p(radius / _SCALE) / _DISTANCE
        first = np.floor(place).astype(np.intp)
        t = place - first
        square, rest = t * t, 1.0 - t
        splines = np.array(
            [rest * rest * rest, (3.0 * t - 6.0) * square + 4.0, ((3.0 - 3.0 * t) * t + 3.0) * t + 1.0, square * t]
        )
        chosen = {one: self._interval(one) for one in np.unique(first).tolist()}
        most = max((times.size for times, _ in chosen.values()), default=0)
        moduli, times = np.zeros((radius.size, most)), np.ones((radius.size, most))
        for one, (own, nodes) in chosen.items():
            rows = np.flatnonzero(first == one)
            a, b, c, d = splines[:, rows, None]
            # Term by term, so that a row does not depend on the others.
            moduli[rows, : own.size] = a * nodes[0] + b * nodes[1] + c * nodes[2] + d * nodes[3]
            times[rows, : own.size] = own
        equilibria = np.full(radius.size, self._spectrum.series.equilibrium_modulus)
        return PronyColumns(equilibria, np.zeros(radius.size), moduli, times)

    def _interval(self, n: int) -> tuple[Array, Array]:
        """Relaxation times [s] between two nodes, and a sixth of the branch moduli [Pa] at the four nodes around."""
        if n not in self._between:
            nodes = np.array([self._node(n + k) for k in range(-1, 3)])
            kept = np.flatnonzero(nodes.any(axis=0))
            self._between[n] = self._spectrum.times[kept], nodes[:, kept] / 6.0
        return self._between[n]

    def _node(self, n: int) -> Array:
        """Branch moduli [Pa] of the fit at a node."""
        if n not in self._moduli:
            before, here, after = (self._transform(n + k) for k in (-1, 0, 1))
            target, spectrum = here - (before - 2.0 * here + after) / 6.0, self._spectrum
            found, misfit = spectrum.fitted(target, spectrum.coarse)
            if misfit > _ENOUGH:
                found, misfit = spectrum.fitted(target, np.arange(spectrum.times.size))
            if misfit > _MISFIT:
                # What the splines combine need not relax; the stiffness itself must.
                spectrum.moduli(here)
            self._moduli[n] = found
        return self._moduli[n]

    def _transform(self, n: int) -> Array:
        """Carson transform [Pa] at a node."""
        if n not in self._transforms:
            if 0 <= n <= _LAST:
                found = self._spectrum.transform(float(_SCALE * np.expm1(_DISTANCE * n)))
            else:
                inward = 1 if n < 0 else -1
                near = (factor * self._transform(n + (k + 1) * inward) for k, factor in enumerate(_NEXT))
                found = np.sum(list(near), axis=0)
            self._transforms[n] = found
        return self._transforms[n]


effective_moduli = lru_cache(maxsize=64)(EffectiveModuli)
"""The effective moduli of a material, whose nodes are computed once."""


@lru_cache(maxsize=64)
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
    if radius == 0.0:
        return reduced_modulus(material)
    spectrum = _Spectrum(material)
    weights = spectrum.moduli(spectrum.transform(radius))
    kept = weights > 0.0
    return PronySeries(spectrum.series.equilibrium_modulus, weights[kept], spectrum.times[kept])


@lru_cache(maxsize=64)
def _stiffness(radius: float) -> np.polynomial.Chebyshev:
    """Series of the logarithm of the stiffness of a flat punch over ``ln(1 - 2 nu + shift)``."""
    # Numba takes half a second to import.
    from restitution.contact.layer.line_loads import solve_line_loads

    low, high = np.log(_SHIFT), np.log(3.0 + _SHIFT)
    places = 0.5 * (low + high) + 0.5 * (high - low) * np.polynomial.chebyshev.chebpts1(_RATIOS)
    nodes, weights = np.polynomial.legendre.leggauss(int(_NODES + _PER_RADIUS * radius))
    gauss = np.array([radius]), 0.5 + 0.5 * nodes, 0.5 * weights
    space = np.empty((nodes.size, nodes.size)), np.empty(nodes.size), np.empty((1, 2, nodes.size))
    ends, values = np.empty((1, 2)), np.empty(_RATIOS)
    for n, one in enumerate(0.5 * (1.0 + _SHIFT - np.exp(places))):
        kernel = _line_kernel(float(one))
        solve_line_loads(kernel.cells, kernel.per_unit, *gauss, *space, ends)
        values[n] = np.log(ends[0, 0])
    return np.polynomial.Chebyshev.fit(places, values, _RATIOS - 1, domain=[low, high])


# All materials have the same places of the Poisson ratio.
_line_kernel = lru_cache(maxsize=_RATIOS)(LineKernel)
