"""A Prony series with few terms for the impacts of a longer one: first its modulus, then the impacts themselves."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from restitution.errors import InputError
from restitution.impact.batch import Batch
from restitution.impact.problem import Impact
from restitution.material.columns import PronyColumns
from restitution.material.prony import PronySeries

Array = NDArray[np.float64]

# Band of the fit over pi/T, number of frequencies, and distance in log(frequency) at which their weight falls.
_LOW, _HIGH, _COUNT, _WIDTH = 0.3, 10.0, 60, 0.7
# Times are within the band times this and its reciprocal: beyond, a term is a spring or a dashpot.
_BEYOND = 1e-2
# Ratio of the last to the first time of each start, whose middle is this share of the contact time.
_SPANS, _MIDDLE = (1.0, 10.0, 100.0, 1e4), 0.3
# Cost of a change of a constant by a factor e, beside errors of the impacts.
_STIFFNESS = 1e-3


def reduced_series(impact: Impact, series: PronySeries, terms: int) -> tuple[PronySeries, float]:
    """Series of at most `terms` branches, a parallel dashpot counted, and its largest error of e at the impacts."""
    # SciPy takes 0.2 s to import.
    from scipy.optimize import least_squares

    exact = Batch.from_impact(impact).solve(1e-8)
    if not np.all(np.isfinite(exact["contact_time"])):
        raise InputError("impact", wanted="must separate: the contact time is the scale of the reduced terms")
    start = _of_modulus(series, exact["contact_time"], terms)
    count = start.n_branches

    def changed(logarithms: Array) -> PronySeries:
        factors = np.exp(logarithms)
        moduli, times = start.branch_moduli * factors[2 : 2 + count], start.relaxation_times * factors[2 + count :]
        viscosity = start.parallel_viscosity * factors[1]
        return PronySeries(start.equilibrium_modulus * factors[0], moduli, times, parallel_viscosity=viscosity)

    def errors(logarithms: Array) -> dict[str, Array]:
        found = Batch.from_impact(impact, PronyColumns.stacked([changed(logarithms)])).solve(1e-8)
        names = ("restitution_coefficient", "contact_time", "max_force")
        return {name: found[name] - exact[name] for name in names}

    def residuals(logarithms: Array) -> Array:
        of_impacts = errors(logarithms)
        relative = [of_impacts[name] / exact[name] for name in ("contact_time", "max_force")]
        return np.concatenate([of_impacts["restitution_coefficient"], *relative, _STIFFNESS * logarithms])

    best = least_squares(residuals, np.zeros(2 + 2 * count), diff_step=1e-4, max_nfev=20).x
    return changed(best), float(np.abs(errors(best)["restitution_coefficient"]).max())


def _of_modulus(series: PronySeries, contact_time: Array, terms: int) -> PronySeries:
    """Series whose complex modulus is nearest at the frequencies pi/T, and near at those around them."""
    from scipy.optimize import least_squares, nnls

    first, last = math.pi / contact_time.max(), math.pi / contact_time.min()
    omega = np.geomspace(_LOW * first, _HIGH * last, _COUNT)
    modulus = series.carson_transform(1j * omega)
    outside = np.log(omega / np.clip(omega, first, last)) / _WIDTH
    weights = 1.0 / (np.abs(modulus) * np.sqrt(1.0 + outside**2))
    fixed = [np.ones(_COUNT)] + [1j * omega / last] * (series.parallel_viscosity > 0.0)
    data = _parts(weights * modulus)

    def columns(logarithms: Array) -> Array:
        s = 1j * omega[:, None] * np.exp(logarithms)
        return _parts(weights[:, None] * np.column_stack([*fixed, s / (1.0 + s)]))

    def residuals(logarithms: Array) -> Array:
        matrix = columns(logarithms)
        return matrix @ nnls(matrix, data)[0] - data

    free, middle = terms - len(fixed) + 1, _MIDDLE * math.sqrt(contact_time.min() * contact_time.max())
    starts = [np.log(middle) + np.linspace(-0.5, 0.5, free + 2)[1:-1] * math.log(span) for span in _SPANS]
    bounds = np.log(_BEYOND / omega[-1]), -np.log(_BEYOND * omega[0])
    fits = [least_squares(residuals, start, diff_step=1e-4, bounds=bounds) for start in starts] if free else []
    logarithms = min(fits, key=lambda fit: fit.cost).x if fits else np.zeros(0)
    spring, *others = nnls(columns(logarithms), data)[0]
    viscosity = others.pop(0) / last if len(fixed) > 1 else 0.0
    return PronySeries(spring, others, np.exp(logarithms), parallel_viscosity=viscosity).simplified()


def _parts(values: NDArray[np.complex128]) -> Array:
    """Return real and imaginary parts, one below the other."""
    return np.concatenate([values.real, values.imag])
