"""Identification of a material from measured impacts, indentations and moduli."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from itertools import chain
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike

from restitution import checks
from restitution.checks import Array, function, one_of, truth, whole
from restitution.errors import InputError
from restitution.identification.fit import EQUALLY_GOOD, Loss, estimate
from restitution.identification.observations import Moduli, Observations, as_observations, doubtful_balls
from restitution.identification.parameters import MOST_TERMS, SPECTRUM, OfData, parameter_names, parameters
from restitution.identification.result import Identification
from restitution.identification.uncertainty import (
    MODULUS_NAMES,
    Estimate,
    Uncertainty,
    banded,
    nuisance_estimates,
    settled,
)
from restitution.material.master_curve import Isotherms
from restitution.quantities import MODULI, Quantity
from restitution.result import Result, Summary, Table

if TYPE_CHECKING:
    import xarray

    from restitution.identification.spectrum import Spectrum


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
    """Return the material that fits measured data, with errors.

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

    With adhesion a valley of fits has many small minima. Without profiles, intervals then hold all fits that are as
    good along each parameter with an error above 5 %, if a work, a stress or a range is such a parameter, each with
    what its chi2 leaves of the interval.

    Data with `adhesion=True` add the work of adhesion and its stress to the unknowns, or the range where an argument
    names that: `work`, `stress` and `range` of `restitution.Adhesion`, also in `fixed`, `bounds`, `start` and `prior`.

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
    >>> solid = rs.identify(balls, rs.standard_solid, fixed={"poisson_ratio": 0.5})
    >>> print(round(solid.parameters["branch_modulus"].value / 1e7, 4))
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
        if any(record.adhesion for record in sets):
            raise InputError("adhesion", rule="must be left out for a spectrum; take a model with constants")
        return spectrum(sets, **dict(fixed or {}))
    space = parameters(
        model, fixed=fixed, bounds=bounds, start=start, prior=prior, shift=shift,
        terms=whole("terms", terms, 1, MOST_TERMS),
        of_data=OfData(_middle_temperature(sets), any(record.adhesion for record in sets)),
    )  # fmt: skip
    if not any(record.fixes_time for record in sets):
        bulk = [parameter.name for parameter in space.free if parameter.name in ("bulk_modulus", "poisson_ratio")]
        if bulk and bulk[0] not in space.prior:
            raise InputError(bulk[0], rule="must be in fixed: restitution coefficients alone do not show it")
    if progress is not None:
        function("progress", progress, "must be a function of the steps done and of all", 2)
    report = progress or (lambda done, steps: None)
    uncertainty, estimates = settled(
        Uncertainty(estimate(sets, space, loss)), lambda uncertainty: _estimates(uncertainty, profiles, report)
    )
    result = Identification(uncertainty, estimates, nuisance_estimates(uncertainty))
    return replace(result, warnings=_warnings(result, profiles))


def _estimates(
    uncertainty: Uncertainty, profiles: bool | None, report: Callable[[int, int], None]
) -> dict[str, Estimate]:
    names, estimates = uncertainty.estimation.problem.space.names, dict[str, Estimate]()
    report(1, len(names) + 1)
    for k, name in enumerate(names):
        estimates[name] = uncertainty.estimate(k, profiles)
        report(k + 2, len(names) + 1)
    return estimates


def _observations(data: Any) -> list[Observations]:
    single = not isinstance(data, Sequence)
    items: list[Any] = [data] if single else list(data)
    each = (_isotherms(record) if isinstance(record, Isotherms) else [record] for record in items)
    sets = [as_observations(record, n) for n, record in enumerate(chain.from_iterable(each))]
    if not sets:
        raise InputError("data", rule="must hold at least one set of data")
    return sets


def _isotherms(measured: Isotherms) -> list[Observations]:
    """Return one set of moduli for each temperature."""
    sets = [Moduli(table, temperature=table.temperature) for table in measured.tables]
    for record in sets:
        record.series = measured
    return list(sets)


def _middle_temperature(sets: Sequence[Observations]) -> float | None:
    """Return the median of the temperatures of the data [K]."""
    levels = [getattr(record, "temperature", None) for record in sets]
    temperatures = [np.ravel(level) for level in levels if level is not None]
    return float(np.median(np.concatenate(temperatures))) if temperatures else None


def _warnings(result: Identification, profiles: bool | None) -> tuple[str, ...]:
    """Return doubts about a fit."""
    from scipy.special import gammainc

    estimation, problem, freedom = result.estimation, result.problem, result.degrees_of_freedom
    lines: list[str] = []
    if freedom > 0 and not any(record.scaled for record in problem.data) and estimation.loss == "linear":
        share, ratio = float(gammainc(0.5 * freedom, 0.5 * result.chi2)), result.reduced_chi2
        if share > 0.995:
            cause = ", or the search ended in a poor minimum: give start" if problem.space.adhesion else ""
            lines.append(f"chi2/dof = {ratio:.3g} is too large for this noise: the model or the noise is wrong{cause}")
        elif share < 0.005:
            lines.append(f"chi2/dof = {ratio:.3g} is too small for this noise, which is stated too large")
    if not estimation.fit.converged:
        lines.append("the search ended before its tolerance: give start, or bounds")
    if result.runs_test < 0.005:
        lines.append(f"the residuals have too few changes of sign (p = {result.runs_test:.1g}): the model is wrong")
    here = estimation.fit.coordinates[None]
    for record, nuisances in zip(problem.data, problem.nuisances(here), strict=True):
        lines += doubtful_balls(getattr(record, "mass", None), getattr(record, "profile", None))
        lines += record.doubts(problem.materials(here), nuisances)
    if profiles is False and (unseen := result.uncertainty.unseen_adhesion):
        lines.append(
            f"the data hardly show {' and '.join(unseen)}: intervals are those over the fits along a few lines "
            "that are as good; profiles=True follows the best fit at each value"
        )
    # Another minimum may have other values of the parameters; the best one for each parameter is named.
    stated = np.array([estimate.determined for estimate in result.parameters.values()])
    n, best, named = problem.n_parameters, estimation.fit, set[int]()
    for other in estimation.fits:
        apart = np.where(stated, np.abs(other.coordinates[:n] - best.coordinates[:n]), 0.0)
        k, gain = int(np.argmax(apart)), best.cost - other.cost
        if apart[k] > math.log(2.0) and gain > -EQUALLY_GOOD and k not in named:
            named.add(k)
            value = float(problem.space.free[k].outward(other.coordinates[k]))
            well = "almost as well" if gain < 0.0 else f"better by {gain:.2g} in chi2, but is less plausible"
            lines.append(f"another minimum fits {well}, with {problem.space.names[k]} = {value:.3g}")
    return tuple(dict.fromkeys(lines))


# Comparison of several models of the material that are fitted to the same data.

# Models of a smaller weight do not count in the band.
_LEAST_WEIGHT = 0.01


@dataclass(frozen=True, eq=False, repr=False)
class Comparison(Result):
    """Models fitted to the same data, best first; `plot` shows their moduli over frequency.

    Attributes
    ----------
    results : dict of str to Identification or Spectrum
        Fits by the name of the model.
    criterion : dict of str to float
        Akaike's criterion with its correction for few data, AICc, less that of the best model. NaN for a spectrum,
        which has no likelihood.
    weights : dict of str to float
        Akaike weights exp(-AICc/2), of sum 1.
    refused : dict of str to str
        Models that cannot be fitted to the data or with the options, and the reason.
    """

    _numbers = ("criterion", "weights", "statements", "results")
    _picture = "identification.comparison"

    results: dict[str, Identification | Spectrum]
    criterion: dict[str, float]
    weights: dict[str, float]
    refused: dict[str, str] = field(default_factory=dict)

    def moduli(self, angular_frequency: ArrayLike, *, level: float = 0.95) -> xarray.Dataset:
        """Return E* of the best model; the band covers the bands of all models with a weight above 1 %."""
        omega = np.atleast_1d(checks.positive("angular_frequency", angular_frequency, "rad/s"))
        plausible = [result for name, result in self.results.items() if not self.weights[name] < _LEAST_WEIGHT]
        tables = [result.moduli(omega, level=level) for result in plausible]
        columns: dict[Quantity, tuple[Array, Array, Array]] = {}
        for name in MODULUS_NAMES:
            low, high = (np.array([table[f"{name}_{end}"].to_numpy() for table in tables]) for end in ("low", "high"))
            columns[MODULI[name]] = tables[0][name].to_numpy(), np.nanmin(low, axis=0), np.nanmax(high, axis=0)
        bands = banded(MODULI["angular_frequency"], omega, level, columns)
        return bands.assign_attrs(models=len(tables))

    @property
    def statements(self) -> tuple[str, ...]:
        """Result of the comparison, in words."""
        best, *others = self.results
        lines = [f"{best} describes the data best."]
        close = [name for name in others if self.weights[name] >= _LEAST_WEIGHT]
        if close:
            lines.append(f"The data do not exclude {', '.join(close)}: quote the band of all of them.")
        result = self.results[best]
        if result.reduced_chi2 > 2.0:
            lines.append(f"Even its chi2/dof is {result.reduced_chi2:.3g}: none of the models describes the data.")
        return tuple(lines)

    def summary(self, title: str = "") -> Summary:
        """Return a table of the models, the best first, which `print` and notebooks show."""
        rows: list[tuple[str, ...]] = []
        for name, result in self.results.items():
            unknowns = (
                f"{result.coordinates.size}"
                if isinstance(result, Identification)
                else f"{result.effective_parameters:.1f}"
            )
            rows.append((name, unknowns, f"{result.reduced_chi2:.3g}", f"{self.criterion[name]:.1f}",
                         f"{self.weights[name]:.3f}"))  # fmt: skip
        lines = [*(f"{name}: not fitted, {reason}" for name, reason in self.refused.items()), *self.statements]
        table = Table(("model", "unknowns", "chi2/dof", "AICc", "weight"), rows)
        return Summary(title or "Comparison of models", table, lines)

    @property
    def _short(self) -> str:
        return ", ".join(f"{name} {self.weights[name]:.3f}" for name in self.results)


def compare(
    data: Any, models: Sequence[Any] | Mapping[str, Any], *,
    progress: Callable[[int, int], None] | None = None, **options: Any,
) -> Comparison:  # fmt: skip
    """Fit several models to the same data.

    Parameters
    ----------
    data : observations, table of moduli, or list of them
        As in `restitution.identify`.
    models : sequence or dict
        Models as in `restitution.identify`, also "spectrum"; pairs of a model and further options, such as
        ``(generalised_maxwell, {"terms": 3})``; or a dict of these by name.
    progress : callable, optional
        Called with (models done, all models).
    **options
        Options of `restitution.identify` for all models. Entries of `fixed`, `bounds`, `start` and `prior` are ignored
        for models that do not have the parameter.

    Returns
    -------
    Comparison
        Best model first.

    Notes
    -----
    AICc = -2 ln L + 2k + 2k(k + 1)/(n - k - 1) for k unknowns and n data (Burnham and Anderson, *Model Selection and
    Multimodel Inference*, 2nd ed. (2002), ch. 2). Noise of unknown size enters by its estimate.

    Examples
    --------
    >>> import restitution as rs
    >>> from restitution.material.fit import RelaxationTable
    >>> t = np.geomspace(1e-3, 1.0, 20)
    >>> table = RelaxationTable(t, 1e6 + 2e6 * np.exp(-t / 0.05) + 1e3 * np.sin(t * 1e5), "shear")
    >>> both = rs.identify.compare(table, [rs.elastic, rs.standard_solid], fixed={"poisson_ratio": 0.5})
    >>> list(both.results)
    ['standard_solid', 'elastic']
    """
    named = list(models.items()) if isinstance(models, Mapping) else [(None, model) for model in models]
    if not named:
        raise InputError("models", rule="must name at least one model")
    adhesion = any(record.adhesion for record in _observations(data))
    report = progress or (lambda done, models: None)
    results, criteria, refused = dict[str, Any](), dict[str, float](), dict[str, str]()
    for n, (name, choice) in enumerate(named):
        report(n, len(named))
        model, more = choice if isinstance(choice, tuple) else (choice, {})
        settings = {key: value for key, value in {**options, **more}.items() if value is not None}
        arguments = parameter_names(model, settings.get("shift"), adhesion=adhesion)
        for key in ("fixed", "bounds", "start", "prior"):
            if key in settings:
                settings[key] = {
                    place: value for place, value in settings[key].items() if place.partition("[")[0] in arguments
                }
        label = name or (model if isinstance(model, str) else getattr(model, "__name__", "model"))
        if label in results:
            label = f"{label} {len(results) + 1}"
        try:
            result: Any = identify(data, model, **settings)
        except InputError as error:
            refused[label] = str(error)
            continue
        results[label] = result
        criteria[label] = _criterion(result) if isinstance(result, Identification) else math.nan
    report(len(named), len(named))
    if not results:
        raise InputError("models", list(refused), f"fit none of the data: {next(iter(refused.values()))}")
    least = min(filter(math.isfinite, criteria.values()), default=0.0)
    shares = {
        name: math.exp(-0.5 * (criterion - least)) if math.isfinite(criterion) else math.nan
        for name, criterion in criteria.items()
    }
    total = sum(share for share in shares.values() if math.isfinite(share)) or 1.0
    order = sorted(results, key=lambda name: criteria[name] if math.isfinite(criteria[name]) else math.inf)
    return Comparison(
        {name: results[name] for name in order}, {name: criteria[name] - least for name in order},
        {name: shares[name] / total for name in order}, refused,
    )  # fmt: skip


identify.compare = compare  # pyright: ignore[reportFunctionMemberAccess]


def _criterion(result: Identification) -> float:
    """Return AICc of a fit; infinite if it has too few data."""
    problem, n = result.problem, result.problem.n_data
    sets = zip(problem.data, problem.factors, result.residuals, strict=True)
    # The logarithm of a Gaussian density has that of the standard deviation.
    value = sum(float((residuals**2).sum()) + 2.0 * residuals.size * math.log(factor) for _, factor, residuals in sets)
    k = result.coordinates.size + len(problem.unknown_sizes)
    return value + 2.0 * k + 2.0 * k * (k + 1.0) / (n - k - 1.0) if n > k + 1 else math.inf
