"""Identification of a material from measured impacts, indentations and moduli."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from itertools import chain
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from restitution.checks import function, one_of, truth, whole
from restitution.errors import InputError
from restitution.identification.arguments import SPECTRUM, parameters
from restitution.identification.estimation import EQUALLY_GOOD, Loss, estimate, minimise, moved, ranks
from restitution.identification.observations import Observations, hollow_balls
from restitution.identification.result import Identification
from restitution.identification.tables import Moduli, as_observations
from restitution.identification.uncertainty import Estimate, Uncertainty
from restitution.material.isotherms import Isotherms

if TYPE_CHECKING:
    from restitution.identification.comparison import Comparison

Array = NDArray[np.float64]

# A profile that finds a point this much better than the fit moves the fit there.
_BETTER, _RESTARTS = 1e-2, 3
_LOSSES = ("linear", "soft_l1", "huber", "cauchy")


def identify(
    data: Any,
    model: Any,
    *,
    fixed: Mapping[str, Any] | None = None,
    bounds: Mapping[str, Any] | None = None,
    start: Mapping[str, Any] | None = None,
    prior: Mapping[str, Any] | None = None,
    shift: Any = None,
    terms: int = 2,
    loss: Loss = "linear",
    profiles: bool | None = None,
    progress: Callable[[int, int], None] | None = None,
) -> Any:
    """Material that fits measured data, with errors.

    Parameters
    ----------
    data : observations, table of moduli, or list of them
        `Rebounds`, `ForceHistory`, `BounceTimes`, `IndentationCurve`, `RelaxationTable`, `DynamicTable`,
        `Isotherms`, in any mixture.
    model : callable or str
        Function that returns a `Material` or a `FractionalMaterial`, such as `standard_solid`, or the name of a model
        of the package. Its arguments are the unknowns. Positive ones enter as logarithms. The name "spectrum" takes a
        smooth spectrum of relaxation times instead.
    fixed : dict
        Known arguments by name, such as ``{"poisson_ratio": 0.47}``.
    bounds, start : dict
        Pairs of ends, and first values, by name. By default both follow from the data.
    prior : dict
        `Normal`, `LogNormal`, `Uniform` or `LogUniform` by name.
    shift : type or Shift, optional
        Time-temperature shift: `WLF` or `Arrhenius` with unknown constants, or a shift with its numbers.
    terms : int
        Number of terms of a model with lists, such as `generalised_maxwell`.
    loss : {"linear", "soft_l1", "huber", "cauchy"}
        Loss function of the residuals; all but the first reduce the weight of outliers.
    profiles : bool, optional
        Whether intervals are from profiles: for all parameters, for none, or by default for parameters with a standard
        error above 5 %.
    progress : callable, optional
        Called with (steps done, all steps) of a parametric model: the fit, then the interval of each parameter.

    Returns
    -------
    Identification or Spectrum
        Estimates with intervals; the value is `None` if the data do not determine it.

    Raises
    ------
    InputError
        If the data have fewer values than there are unknowns, or an argument is wrong.

    Notes
    -----
    Least squares in the logarithms of the parameters, from starts that follow from the data. A parameter counts as
    determined if both ends of its interval lie within a factor of 1000 of the estimate. A small chi2 does not prove a
    model: compare several models with `identify.compare`.

    The ends of a profile are where the least chi2 exceeds the minimum by 1.96^2. A profile may flatten beyond such an
    end, if the data hardly show the size of some parameter: the root of the excess is below 1.8 times 1.96 at five
    times the stated error, in place of 5. The end is then where it is 1.8 times 1.96, as a chance excess would
    otherwise exclude values at many errors.

    Two materials may fit equally well. One with a negative instantaneous Poisson ratio is taken only if its chi2 is
    smaller by 18.4 (odds of 10 000) where the bulk modulus or the Poisson ratio is unknown and has no prior, and
    by 3.84 where one is known. `warnings` has the other minimum.

    Examples
    --------
    >>> import restitution as rs
    >>> v = np.geomspace(0.01, 0.2, 8)
    >>> solid = rs.standard_solid(1e6, 1e7, 1e4, poisson_ratio=0.5)
    >>> exact = rs.solve(rs.Impact(solid, rs.Parabola(0.01), 0.033, v))
    >>> balls = rs.Rebounds(
    ...     v, exact.restitution_coefficient, radius=0.01, mass=0.033, contact_time=exact.contact_time,
    ...     noise=rs.Noise(restitution_coefficient="1 %", contact_time="1 %"),
    ... )
    >>> found = rs.identify(balls, rs.standard_solid, fixed={"poisson_ratio": 0.5})
    >>> print(round(found.parameters["branch_modulus"].value / 1e7, 4))
    1.0
    """
    one_of("loss", loss, _LOSSES)
    if profiles is not None:
        truth("profiles", profiles)
    sets = _observations(data)
    if isinstance(model, str) and model == SPECTRUM:
        from restitution.identification.spectrum import spectrum

        for name in fixed or {}:
            if name != "poisson_ratio":
                raise InputError("fixed", name, "is no argument of a spectrum; only poisson_ratio is")
        return spectrum(sets, **dict(fixed or {}))
    space = parameters(
        model, fixed=fixed, bounds=bounds, start=start, prior=prior, shift=shift, terms=whole("terms", terms),
        temperature=_middle_temperature(sets),
    )  # fmt: skip
    if not any(one.fixes_time for one in sets):
        bulk = [one.name for one in space.free if one.name in ("bulk_modulus", "poisson_ratio")]
        if bulk and bulk[0] not in space.prior:
            raise InputError(bulk[0], wanted="must be in fixed: restitution coefficients alone do not show it")
    if progress is not None:
        function("progress", progress, "must be a function of the steps done and of all", 2)
    report = progress or (lambda done, steps: None)
    uncertainty = Uncertainty(estimate(sets, space, loss))
    found = _estimates(uncertainty, profiles, report)
    for _ in range(_RESTARTS):
        estimation, better = uncertainty.estimation, uncertainty.best
        rank, other = ranks(estimation.problem, (estimation.fit, better))
        if other > rank - _BETTER:
            break
        uncertainty = Uncertainty(moved(estimation, minimise(estimation.problem, better.coordinates, loss)))
        found = _estimates(uncertainty, profiles, report)
    result = Identification(uncertainty, found, _nuisances(uncertainty))
    return replace(result, warnings=_warnings(result))


def _estimates(
    uncertainty: Uncertainty, profiles: bool | None, report: Callable[[int, int], None]
) -> dict[str, Estimate]:
    names, found = uncertainty.estimation.problem.space.names, dict[str, Estimate]()
    report(1, len(names) + 1)
    for k, name in enumerate(names):
        found[name] = uncertainty.estimate(k, profiles)
        report(k + 2, len(names) + 1)
    return found


def _compare(data: Any, models: Any, **options: Any) -> Comparison:
    from restitution.identification.comparison import compare

    return compare(data, models, **options)


_compare.__doc__ = "Fit several models to the same data; see `restitution.identification.comparison.compare`."
identify.compare = _compare  # pyright: ignore[reportFunctionMemberAccess]


def _observations(data: Any) -> list[Observations]:
    single = not isinstance(data, Sequence)
    given: list[Any] = [data] if single else list(data)
    each = (_isotherms(one) if isinstance(one, Isotherms) else [one] for one in given)
    sets = [as_observations(one, n) for n, one in enumerate(chain.from_iterable(each))]
    if not sets:
        raise InputError("data", wanted="must hold at least one set of data")
    return sets


def _isotherms(measured: Isotherms) -> list[Observations]:
    """One set of moduli for each temperature."""
    sets = [Moduli(table, temperature=table.temperature) for table in measured.tables]
    for one in sets:
        one.series = measured
    return list(sets)


def _middle_temperature(sets: Sequence[Observations]) -> float | None:
    """Median of the temperatures of the data [K]."""
    levels = [getattr(one, "temperature", None) for one in sets]
    given = [np.ravel(level) for level in levels if level is not None]
    return float(np.median(np.concatenate(given))) if given else None


def _nuisances(uncertainty: Uncertainty) -> dict[str, Estimate]:
    """Unknowns of the measurements: those of the fit, with errors, then those that were projected out."""
    problem, fit = uncertainty.estimation.problem, uncertainty.estimation.fit
    columns, found, at = problem.columns(fit.coordinates[None]), dict[str, Estimate](), problem.n_parameters
    quantile = uncertainty.quantile()
    for n, (one, own) in enumerate(zip(problem.data, problem.nuisances(fit.coordinates[None]), strict=True)):
        prefix = f"{one.label or n}: " if len(problem.data) > 1 else ""
        for k, nuisance in enumerate(one.nuisances):
            value, error = float(own[0, k]), float(uncertainty.standard_errors[at]) * nuisance.step
            at += 1
            reach = quantile * error
            found[prefix + nuisance.name] = Estimate(value, error, (value - reach, value + reach), True, nuisance.unit)
        for name, (value, unit) in one.linear_estimates(columns, own).items():
            found[prefix + name] = Estimate(value, None, (-math.inf, math.inf), True, unit)
    return found


def _warnings(found: Identification) -> tuple[str, ...]:
    """Doubts about a fit."""
    from scipy.special import gammainc

    estimation, problem, freedom = found.estimation, found.problem, found.degrees_of_freedom
    lines: list[str] = []
    if freedom > 0 and not any(one.scaled for one in problem.data) and estimation.loss == "linear":
        share, ratio = float(gammainc(0.5 * freedom, 0.5 * found.chi2)), found.reduced_chi2
        if share > 0.995:
            lines.append(f"chi2/dof = {ratio:.3g} is too large for this noise: the model or the noise is wrong")
        elif share < 0.005:
            lines.append(f"chi2/dof = {ratio:.3g} is too small for this noise, which is stated too large")
    if not estimation.fit.converged:
        lines.append("the search ended before its tolerance: give start, or bounds")
    if found.runs_test < 0.005:
        lines.append(f"the residuals have too few changes of sign (p = {found.runs_test:.1g}): the model is wrong")
    for one in problem.data:
        lines += hollow_balls(getattr(one, "mass", None), getattr(one, "profile", None))
    # The parameters with a value may have another one in another minimum.
    stated = np.array([one.determined for one in found.parameters.values()])
    n, best = problem.n_parameters, estimation.fit
    for other in estimation.fits:
        apart = np.where(stated, np.abs(other.coordinates[:n] - best.coordinates[:n]), 0.0)
        k, gain = int(np.argmax(apart)), best.cost - other.cost
        if apart[k] > math.log(2.0) and gain > -EQUALLY_GOOD:
            value = float(problem.space.free[k].outward(other.coordinates[k]))
            well = "almost as well" if gain < 0.0 else f"better by {gain:.2g} in chi2, but is less plausible"
            lines.append(f"another minimum fits {well}, with {problem.space.names[k]} = {value:.3g}")
    return tuple(dict.fromkeys(lines))
