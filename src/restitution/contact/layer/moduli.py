"""Effective moduli of a bonded layer whose Poisson ratio relaxes: a separable approximation."""

from __future__ import annotations

from functools import cache, lru_cache
from typing import Any

import numpy as np
from numpy.typing import NDArray

from restitution.checks import Array
from restitution.contact.layer.punch import LineKernel
from restitution.errors import InputError
from restitution.material.prony import PronySeries
from restitution.material.viscoelastic import Material, reduced_modulus

# The Carson transform is ``E*(s) kappa(x; nu(s))/kappa(x; nu_static)`` for a flat punch of the radius x, in units of
# the thickness. Moduli of many contacts are interpolated over x between nodes that depend neither on the contacts nor
# on the material, so that each contact has the same modulus alone and beside others.

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
# Neighbouring terms are merged into three with the same moments of ln(tau), in which the transform is so smooth that
# it changes by some 1e-5 at most. A group has a relaxation time of the material, its others up to `_TOGETHER` further,
# and all times of the fit closer to these than `_CLOSE`, in ln(tau). Variances below `_NO_WIDTH` are rounding.
_MERGED, _TOGETHER, _CLOSE, _NO_WIDTH, _LEAST = 3, 1.1, 1.0, 1e-9, 1e-300
_THIRDS = 0.0, 2.0 * np.pi / 3.0, 4.0 * np.pi / 3.0
# Nodes x of the interpolation are at equal distances of ln(1 + x/scale); the last is at 37.
_SCALE, _DISTANCE, _LAST = 0.25, 0.2, 25
# Cubic polynomials continue beyond the nodes.
_NEXT = 4.0, -6.0, 4.0, -1.0


class _Spectrum:
    """Points s of the Carson transform of a material, its values there, and the relaxation times of fits."""

    def __init__(self, material: Material) -> None:
        self.series, bulk = reduced_modulus(material), material.bulk
        parts = [self.series, material.shear, *([bulk] if isinstance(bulk, PronySeries) else [])]
        part_times = np.concatenate([part.relaxation_times for part in parts])
        low, high = part_times.min() * _BEFORE, part_times.max() * _BEYOND
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
        self.groups = _groups(np.log(np.sort(self.series.relaxation_times)), np.log(self.times))

    def transform(self, radius: float) -> Array:
        """Return the Carson transform [Pa] of the effective modulus for a punch of a radius over the thickness."""
        if radius == 0.0:
            return self._modulus
        ratio = self._poisson_ratio
        logarithm = _stiffness(radius)(np.log(1.0 + _SHIFT - 2.0 * ratio))
        return self._modulus * np.exp(logarithm[:-1] - logarithm[-1])

    def moduli(self, transform: Array) -> Array:
        """Return branch moduli [Pa] >= 0 at the times, mostly zeros, whose series has a Carson transform [Pa]."""
        fit, misfit = self.fitted(transform, np.arange(self.times.size))
        if misfit > _MISFIT:
            rule = f"must have a stiffness on the layer that only relaxes: a Prony series misses it by {misfit:.2g}"
            raise InputError("material", rule=rule)
        return fit

    def fitted(self, transform: Array, places: NDArray[np.intp]) -> tuple[Array, float]:
        """Return branch moduli [Pa] by nonnegative least squares over some times, and the largest relative misfit."""
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
        # Each node is computed once for each material.
        self._transform, self._node = cache(self._transform_at), cache(self._node_at)
        self._interval = cache(self._interval_at)

    def at(self, radius: Array) -> PronySeries:
        """Return reduced moduli [Pa] for punches of radii over the thickness, shape (n,)."""
        place = np.log1p(radius / _SCALE) / _DISTANCE
        first = np.floor(place).astype(np.intp)
        t = place - first
        square, rest = t * t, 1.0 - t
        splines = np.array(
            [rest * rest * rest, (3.0 * t - 6.0) * square + 4.0, ((3.0 - 3.0 * t) * t + 3.0) * t + 1.0, square * t]
        )
        chosen: list[tuple[NDArray[np.intp], Array, Array]] = []
        for interval in np.unique(first).tolist():
            rows = np.flatnonzero(first == interval)
            chosen.append((rows, *self._within(interval, splines[:, rows])))
        most = max((len(weights) for _, weights, _ in chosen), default=0)
        moduli, times = np.zeros((radius.size, most)), np.ones((radius.size, most))
        for rows, weights, places in chosen:
            moduli[rows, : len(weights)], times[rows, : len(weights)] = weights.T, places.T
        equilibria = np.full(radius.size, self._spectrum.series.equilibrium_modulus)
        return PronySeries.from_checked(equilibria, moduli, times)

    def _within(self, n: int, splines: Array) -> tuple[Array, Array]:
        """Return branch moduli [Pa] and relaxation times [s] of rows between two nodes, shape (n_branch, n_row)."""
        parts: list[tuple[Array, Array]] = []
        for times, nodes in self._interval(n):
            # Term by term, so that a row does not depend on the others.
            moduli: Any = sum(spline * node[:, None] for spline, node in zip(splines, nodes, strict=True))
            merge = times.size > _MERGED
            parts.append(_merged(moduli, times) if merge else (moduli, np.broadcast_to(times[:, None], moduli.shape)))
        moduli, times = zip(*parts, strict=True)
        return np.concatenate(moduli), np.concatenate(times)

    def _interval_at(self, n: int) -> list[tuple[Array, Array]]:
        """Return relaxation times [s] between two nodes, and a sixth of the moduli [Pa] at four nodes, by group."""
        nodes = np.array([self._node(n + k) for k in range(-1, 3)])
        kept, spectrum = np.flatnonzero(nodes.any(axis=0)), self._spectrum
        parts = np.split(kept, 1 + np.flatnonzero(np.diff(spectrum.groups[kept])))
        return [(spectrum.times[part], nodes[:, part] / 6.0) for part in parts]

    def _node_at(self, n: int) -> Array:
        """Return branch moduli [Pa] of the fit at a node."""
        before, here, after = (self._transform(n + k) for k in (-1, 0, 1))
        target, spectrum = here - (before - 2.0 * here + after) / 6.0, self._spectrum
        fit, misfit = spectrum.fitted(target, spectrum.coarse)
        if misfit > _ENOUGH:
            fit, misfit = spectrum.fitted(target, np.arange(spectrum.times.size))
        if misfit > _MISFIT:
            # What the splines combine need not relax; the stiffness itself must.
            spectrum.moduli(here)
        return fit

    def _transform_at(self, n: int) -> Array:
        """Return the Carson transform [Pa] at a node."""
        if 0 <= n <= _LAST:
            return self._spectrum.transform(float(_SCALE * np.expm1(_DISTANCE * n)))
        inward = 1 if n < 0 else -1
        near = (factor * self._transform(n + (k + 1) * inward) for k, factor in enumerate(_NEXT))
        return np.sum(list(near), axis=0)


def _groups(sizes: Array, logs: Array) -> NDArray[np.intp]:
    """Return the number of the group of each ln(tau), for the ascending ones of a material; negative for none."""
    starts = sizes[:1].tolist()
    for size in sizes.tolist():
        if size > starts[-1] + _TOGETHER:
            starts.append(size)
    ends = np.append(sizes[np.searchsorted(sizes, starts[1:]) - 1], sizes[-1])
    distances = np.abs(logs[:, None] - np.clip(logs[:, None], starts, ends))
    near = np.min(distances, axis=1) < _CLOSE
    return np.where(near, np.argmin(distances, axis=1), -1 - np.arange(logs.size))


def _merged(moduli: Array, times: Array) -> tuple[Array, Array]:
    """Return moduli [Pa] and times [s], shape (3, n), of the Gauss rule of moduli (n_branch, n) over ln(tau)."""
    middle = 0.5 * (np.log(times[0]) + np.log(times[-1]))
    y = (np.log(times) - middle)[:, None]
    # Python's sum goes row by row: a column does not depend on the others.
    total: Any = sum(moduli)
    weights = moduli / np.maximum(total, _LEAST)
    mean: Any = sum(weights * y)
    # Orthogonal polynomials p and q of the degrees 1 and 2, and the coefficients of their recurrence.
    p = y - mean
    square = weights * p * p
    first: Any = np.maximum(sum(square), _NO_WIDTH)
    skew: Any = sum(square * p) / first
    q = (p - skew) * p - first
    square = weights * q * q
    second: Any = np.maximum(sum(square) / first, _NO_WIDTH)
    far: Any = sum(square * p) / (first * second)
    # Zeros of the polynomial of the degree 3, the eigenvalues of a matrix, by cosines; as distances from the mean.
    centre = (skew + far) / 3.0
    a, b, c = -centre, skew - centre, far - centre
    scale = np.sqrt((a * a + b * b + c * c + 2.0 * (first + second)) / 6.0)
    cubic = 0.5 * (a * (b * c - second) - first * c) / (scale * scale * scale)
    angle = np.arccos(np.clip(cubic, -1.0, 1.0)) / 3.0
    places = np.array([centre + 2.0 * scale * np.cos(angle + turn) for turn in _THIRDS])
    q = (places - skew) * places - first
    shares = 1.0 / (1.0 + places * places / first + q * q / (first * second))
    return total * shares, np.exp(middle + mean + places)


effective_moduli = lru_cache(maxsize=64)(EffectiveModuli)
"""The effective moduli of a material, whose nodes are computed once."""


@lru_cache(maxsize=64)
def effective_modulus(material: Material, radius: float) -> PronySeries:
    """Return the reduced modulus [Pa] that gives a layer of the static Poisson ratio the true stiffness.

    The Carson transform ``E*(s) kappa(x; nu(s))/kappa(x; nu_static)`` of a flat punch of the radius x over the
    thickness, as a Prony series by nonnegative least squares. Such a punch has exactly this modulus.
    """
    if radius == 0.0:
        return reduced_modulus(material)
    spectrum = _Spectrum(material)
    weights = spectrum.moduli(spectrum.transform(radius))
    kept = weights > 0.0
    return PronySeries(spectrum.series.equilibrium_modulus, weights[kept], spectrum.times[kept])


@lru_cache(maxsize=64)
def _stiffness(radius: float) -> np.polynomial.Chebyshev:
    """Return series of the logarithm of the stiffness of a flat punch over ``ln(1 - 2 nu + shift)``."""
    # Numba takes half a second to import.
    from restitution.contact.loops import solve_line_loads

    low, high = np.log(_SHIFT), np.log(3.0 + _SHIFT)
    places = 0.5 * (low + high) + 0.5 * (high - low) * np.polynomial.chebyshev.chebpts1(_RATIOS)
    nodes, weights = np.polynomial.legendre.leggauss(int(_NODES + _PER_RADIUS * radius))
    gauss = np.array([radius]), 0.5 + 0.5 * nodes, 0.5 * weights
    space, lines = (np.empty((nodes.size, nodes.size)), np.empty(nodes.size)), np.empty((1, 2, nodes.size))
    ends, values = np.empty((1, 2)), np.empty(_RATIOS)
    for n, ratio in enumerate(0.5 * (1.0 + _SHIFT - np.exp(places))):
        kernel = _line_kernel(float(ratio))
        solve_line_loads(kernel.cells, kernel.per_unit, *gauss, space, lines, ends)
        values[n] = np.log(ends[0, 0])
    return np.polynomial.Chebyshev.fit(places, values, _RATIOS - 1, domain=[low, high])


# All materials have the same places of the Poisson ratio.
_line_kernel = lru_cache(maxsize=_RATIOS)(LineKernel)
