"""Comparison of several models of the material that are fitted to the same data."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from restitution import checks
from restitution.display import Shown, Summary, Table
from restitution.errors import InputError
from restitution.identification.arguments import parameter_names
from restitution.identification.bands import MODULUS_NAMES, banded
from restitution.identification.identify import identify
from restitution.identification.result import Identification
from restitution.pictures import draw
from restitution.quantities import MODULI, Quantity

if TYPE_CHECKING:
    import xarray
    from matplotlib.figure import Figure

    from restitution.identification.spectrum import Spectrum

Array = NDArray[np.float64]

# Models of a smaller weight do not count in the band.
_LEAST_WEIGHT = 0.01


@dataclass(frozen=True, eq=False, repr=False)
class Comparison(Shown):
    """Models fitted to the same data, best first.

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

    results: dict[str, Identification | Spectrum]
    criterion: dict[str, float]
    weights: dict[str, float]
    refused: dict[str, str] = field(default_factory=dict)

    def moduli(self, angular_frequency: ArrayLike, *, level: float = 0.95) -> xarray.Dataset:
        """Reduced modulus E* of the best model; the band covers the bands of all models with a weight above 1 %."""
        omega = np.atleast_1d(checks.positive("angular_frequency", angular_frequency, "rad/s"))
        plausible = [one for name, one in self.results.items() if not self.weights[name] < _LEAST_WEIGHT]
        tables = [one.moduli(omega, level=level) for one in plausible]
        columns: dict[Quantity, tuple[Array, Array, Array]] = {}
        for name in MODULUS_NAMES:
            low, high = (np.array([table[f"{name}_{end}"].to_numpy() for table in tables]) for end in ("low", "high"))
            columns[MODULI[name]] = tables[0][name].to_numpy(), np.nanmin(low, axis=0), np.nanmax(high, axis=0)
        found = banded(MODULI["angular_frequency"], omega, level, columns)
        return found.assign_attrs(models=len(tables))

    @property
    def statements(self) -> tuple[str, ...]:
        """Result of the comparison, in words."""
        best, *others = self.results
        lines = [f"{best} describes the data best."]
        close = [name for name in others if self.weights[name] >= _LEAST_WEIGHT]
        if close:
            lines.append(f"The data do not exclude {', '.join(close)}: quote the band of all of them.")
        found = self.results[best]
        if found.reduced_chi2 > 2.0:
            lines.append(f"Even its chi2/dof is {found.reduced_chi2:.3g}: none of the models describes the data.")
        return tuple(lines)

    def plot(self) -> Figure:
        """Figure of the moduli of all models over frequency."""
        return draw("identification.comparison", self)

    def to_dict(self) -> dict[str, Any]:
        """All numbers as a dict for JSON."""
        return {
            "criterion": self.criterion,
            "weights": self.weights,
            "statements": list(self.statements),
            "results": {name: one.to_dict() for name, one in self.results.items()},
        }

    def summary(self, title: str = "") -> Summary:
        """Table of the models, the best first, which `print` and notebooks show."""
        rows: list[tuple[str, ...]] = []
        for name, one in self.results.items():
            unknowns = (
                f"{one.coordinates.size}" if isinstance(one, Identification) else f"{one.effective_parameters:.1f}"
            )
            rows.append((name, unknowns, f"{one.reduced_chi2:.3g}", f"{self.criterion[name]:.1f}",
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
    named = list(models.items()) if isinstance(models, Mapping) else [(None, one) for one in models]
    if not named:
        raise InputError("models", wanted="must name at least one model")
    report = progress or (lambda done, models: None)
    results, criteria, refused = dict[str, Any](), dict[str, float](), dict[str, str]()
    for n, (name, given) in enumerate(named):
        report(n, len(named))
        model, more = given if isinstance(given, tuple) else (given, {})
        own = {key: value for key, value in {**options, **more}.items() if value is not None}
        known = parameter_names(model, own.get("shift"))
        for key in ("fixed", "bounds", "start", "prior"):
            if key in own:
                own[key] = {place: one for place, one in own[key].items() if place.partition("[")[0] in known}
        label = name or (model if isinstance(model, str) else getattr(model, "__name__", "model"))
        if label in results:
            label = f"{label} {len(results) + 1}"
        try:
            found: Any = identify(data, model, **own)
        except InputError as error:
            refused[label] = str(error)
            continue
        results[label] = found
        criteria[label] = _criterion(found) if isinstance(found, Identification) else math.nan
    report(len(named), len(named))
    if not results:
        raise InputError("models", list(refused), f"fit none of the data: {next(iter(refused.values()))}")
    least = min(filter(math.isfinite, criteria.values()), default=0.0)
    shares = {
        name: math.exp(-0.5 * (one - least)) if math.isfinite(one) else math.nan for name, one in criteria.items()
    }
    total = sum(one for one in shares.values() if math.isfinite(one)) or 1.0
    order = sorted(results, key=lambda name: criteria[name] if math.isfinite(criteria[name]) else math.inf)
    return Comparison(
        {name: results[name] for name in order}, {name: criteria[name] - least for name in order},
        {name: shares[name] / total for name in order}, refused,
    )  # fmt: skip


def _criterion(found: Identification) -> float:
    """AICc of a fit; infinite if it has too few data."""
    problem, n = found.problem, found.problem.n_data
    sets = zip(problem.data, problem.factors, found.residuals, strict=True)
    # The logarithm of a Gaussian density has that of the standard deviation.
    value = sum(float((own**2).sum()) + 2.0 * own.size * math.log(factor) for _, factor, own in sets)
    k = found.coordinates.size + len(problem.unknown_sizes)
    return value + 2.0 * k + 2.0 * k * (k + 1.0) / (n - k - 1.0) if n > k + 1 else math.inf
