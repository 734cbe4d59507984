"""Result of an identification: estimates, intervals, moduli and predictions with bands."""

from __future__ import annotations

import json
import math
from collections.abc import Callable
from dataclasses import asdict, dataclass, replace
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike

from restitution import checks
from restitution.checks import Array
from restitution.contact.adhesion import Adhesion
from restitution.errors import InputError
from restitution.files import path_of, whole_file
from restitution.identification.fit import Estimation, EstimationProblem
from restitution.identification.impacts import Rebounds
from restitution.identification.observations import Curve, Observations
from restitution.identification.prediction import predicted
from restitution.identification.records import BounceTimes, ForceHistory
from restitution.identification.statements import knowledge
from restitution.identification.uncertainty import (
    FAR,
    MODULUS_NAMES,
    UNDETERMINED,
    Estimate,
    FlatDirection,
    LikelihoodProfile,
    Uncertainty,
    banded,
    headline,
    limits,
    modulus_functions,
)
from restitution.impact.problem import Impact
from restitution.material.fractional import FractionalMaterial
from restitution.material.prony import PronySeries
from restitution.material.viscoelastic import RIGID, Material, reduced_modulus
from restitution.quantities import MODULI, Quantity, choice
from restitution.result import Result, Summary, plain

if TYPE_CHECKING:
    import xarray


# Case files of identified materials, which `restitution solve` reads.

# Contact time over its beginning, a third of depth over velocity, at most; 8.8 for an elastic ball.
_BEGINNING = 14.0


def write_material(result: Identification, path: str | Path) -> Path:
    """Write the best material with its errors as comments, its adhesion, and the first ball that rebounds, if any."""
    path = path_of(path)
    low, high = result.window
    comments = [
        f"Identified from {', '.join(record.label or repr(record) for record in result.data)}",
        f"chi2/dof = {result.reduced_chi2:.4g}, {result.degrees_of_freedom} degrees of freedom",
        f"holds from {low:.4g} to {high:.4g} rad/s" if math.isfinite(low) else "the data contain no time",
        *(f"{name} = {estimate.words}" for name, estimate in result.parameters.items()),
        f"covariance of the logarithms of {', '.join(result.parameters)}:",
        *(" ".join(f"{value:.4e}" for value in row) for row in result.covariance),
    ]
    lines = [f"# {line}" for comment in comments for line in comment.splitlines()]
    lines += ["", "[material]"]
    if math.isfinite(low):
        shortest, longest = known_times(result)
        # The commands refuse contacts beyond it.
        lines.append(f"window = [{shortest!r}, {longest!r}]")
    if result.undetermined:
        # Results warn of them.
        lines.append(f"undetermined = {json.dumps(list(result.undetermined))}")
    lines += [f"{key} = {_value(value)}" for key, value in _section(result).items()]
    if (adhesion := result.adhesion) is not None:
        numbers = {name: getattr(adhesion, name) for name in result.problem.space.adhesion}
        lines += ["", "[adhesion]", *(f"{name} = {value!r}" for name, value in numbers.items())]
    balls = next((record for record in result.data if isinstance(record, Rebounds)), None)
    if balls is not None and balls.radius is not None and balls.counter_material is None:
        place = int(np.argmax(balls.restitution_coefficient > 0.0))  # the first that does not stick
        radius, mass, velocity = (float(column[place]) for column in (balls.radius, balls.mass, balls.velocity))
        lines += ["", "[body]", f"radius = {radius!r}", f"mass = {mass!r}"]
        lines += ["", "[profile]", 'type = "parabola"', "", "[impact]", f"velocity = {velocity!r}"]
    with whole_file(path) as partial:
        partial.write_text("\n".join(lines) + "\n", encoding="utf-8")
    return Path(path)


def known_times(result: Identification) -> tuple[float, float]:
    """Return the shortest and longest time [s] for which the data determine the material.

    An impact that lasts T contributes the frequency pi/T, and determines the material from its beginning to T.
    """
    low, high = result.window
    if not all(isinstance(record, Rebounds | BounceTimes | ForceHistory) for record in result.data):
        return 1.0 / high, 1.0 / low
    return math.pi / high / _BEGINNING, math.pi / low


def _section(result: Identification) -> dict[str, Any]:
    """Return keys of the material: constants of a model of the package, or else relaxation functions."""
    space = result.problem.space
    if space.entry is not None:
        numbers = space.constants(space.arguments(result.coordinates[None, : result.problem.n_parameters]))
        names = [name for name in space.entry.constants if name in numbers]
        return {"model": space.entry.name} | {name: np.asarray(numbers[name]).tolist() for name in names}
    material = result.materials.row(0, 0)
    bulk = material.bulk if isinstance(material.bulk, PronySeries) else RIGID
    constant = {"bulk_modulus": float(bulk.equilibrium_modulus)}
    return {"shear": material.shear} | (constant if bulk.is_elastic else {"bulk": bulk})


def _value(value: Any) -> str:
    if isinstance(value, PronySeries):
        parts = {
            "equilibrium_modulus": value.equilibrium_modulus,
            "branch_moduli": value.branch_moduli.tolist(),
            "relaxation_times": value.relaxation_times.tolist(),
            "parallel_viscosity": value.parallel_viscosity,
        }
        return "{ " + ", ".join(f"{name} = {_value(part)}" for name, part in parts.items()) + " }"
    return json.dumps(value).replace("Infinity", "inf")


_LEVEL = 0.95


@dataclass(frozen=True, eq=False, repr=False)
class FittedResult(Result):
    """Least squares of measured data: residuals, curves, and functions of the coordinates with bands."""

    uncertainty: Uncertainty

    @property
    def estimation(self) -> Estimation:
        """Best fit, the other fits, and the residuals with their derivatives."""
        return self.uncertainty.estimation

    @property
    def problem(self) -> EstimationProblem:
        """Data and unknowns of the fit."""
        return self.estimation.problem

    @property
    def data(self) -> tuple[Observations, ...]:
        """Sets of data."""
        return self.problem.data

    @property
    def coordinates(self) -> Array:
        """Coordinates of the best fit."""
        return self.estimation.fit.coordinates

    @cached_property
    def materials(self) -> Material:
        """The best material as an array of shape (1, 1)."""
        return self.problem.materials(self.coordinates[None])

    @cached_property
    def covariance(self) -> Array:
        """Covariance of the coordinates of the parameters."""
        n = self.problem.n_parameters
        return self.uncertainty.covariance[:n, :n]

    @property
    def residuals(self) -> tuple[Array, ...]:
        """Residuals of each set of data over their standard deviations."""
        return tuple(np.split(self.estimation.residuals, np.cumsum([record.size for record in self.data]))[:-1])

    @property
    def chi2(self) -> float:
        """Sum of the squared residuals, without priors."""
        return float(sum((part**2).sum() for part in self.residuals))

    @cached_property
    def curves(self) -> list[tuple[str, list[Curve]]]:
        """Measured and fitted values of each set of data, with its label."""
        nuisances = self.problem.nuisances(self.coordinates[None])
        return [
            (record.label, record.curves(self.materials, values))
            for record, values in zip(self.data, nuisances, strict=True)
        ]

    def _level(self, level: float) -> float:
        return checks.single("level", checks.between("level", level, 0.0, 1.0))

    def _banded(
        self, axis: Quantity, x: Array, quantities: list[Quantity], functions: Callable[[Array], Array], level: float
    ) -> xarray.Dataset:
        """Return functions of the coordinates, shape (m, n_quantity, n_x), with bands of their logarithms."""
        values, errors = self.uncertainty.linearised(functions)
        low, high = limits(values, errors, self.uncertainty.quantile(self._level(level)))
        most = [1.0 if quantity.name == "restitution_coefficient" else math.inf for quantity in quantities]
        high = np.minimum(high, np.array(most)[:, None])
        return banded(axis, x, level, dict(zip(quantities, zip(values, low, high, strict=True), strict=True)))


@dataclass(frozen=True, eq=False, repr=False)
class Identification(FittedResult):
    """Material identified from measured data; see `restitution.identify`.

    `plot` shows data and fit, residuals, profiles, and moduli with bands.

    Attributes
    ----------
    parameters, nuisances : dict of str to Estimate
        Constants of the model, and unknowns of the measurements, by name.
    names : tuple of str
        Coordinates of the fit: the unknowns in the order of `coordinates` and `covariance`.
    coordinates : array
        Best fit: logarithms of the parameters (logits of exponents and Poisson ratios), then the nuisances.
    covariance, correlation : array
        Of the coordinates of the parameters.
    chi2, reduced_chi2 : float
        Sum of squares of the residuals over their standard deviations, and the same over the degrees of freedom.
    warnings : tuple of str
        Doubts about the fit.

    Examples
    --------
    >>> import restitution as rs
    >>> from restitution.material.fit import RelaxationTable
    >>> t = np.geomspace(1e-3, 1.0, 20)
    >>> table = RelaxationTable(t, 1e6 + 2e6 * np.exp(-t / 0.05), "shear")
    >>> solid = rs.identify(table, rs.standard_solid, fixed={"poisson_ratio": 0.5})
    >>> print(round(solid.parameters["branch_modulus"].value / 2e6, 6))
    1.0
    """

    _numbers = (
        "parameters", "nuisances", "functionals", "chi2", "reduced_chi2", "covariance", "window", "flat_directions",
        "statements", "undetermined", "warnings",
    )  # fmt: skip
    _picture = "identification.overview"

    parameters: dict[str, Estimate]
    nuisances: dict[str, Estimate]
    warnings: tuple[str, ...] = ()

    @property
    def flat_directions(self) -> tuple[FlatDirection, ...]:
        """Common changes of the parameters that the data do not determine."""
        return self.uncertainty.flat_directions

    @property
    def names(self) -> tuple[str, ...]:
        """Names of the unknowns."""
        return (*self.problem.space.names, *self.nuisances)[: self.coordinates.size]

    @cached_property
    def material(self) -> Material | FractionalMaterial:
        """Material of the best fit, which holds within the window; `undetermined` names its unknown constants."""
        material = self.problem.space.material(self.coordinates[: self.problem.n_parameters])
        low, high = self.window
        if not isinstance(material, Material):
            return material
        material = replace(material, undetermined=self.undetermined or None)
        if 0.0 < low < high:
            return replace(material, window=known_times(self), assumptions="identified from measured data")
        return material

    @cached_property
    def adhesion(self) -> Adhesion | None:
        """Adhesion of the best fit; None if no surfaces of the data adhere."""
        return self.problem.space.surfaces(self.coordinates[: self.problem.n_parameters])

    @property
    def undetermined(self) -> tuple[str, ...]:
        """Names of the parameters that the data do not determine within a factor of 3."""
        return tuple(name for name, estimate in self.parameters.items() if estimate.factor > UNDETERMINED)

    @property
    def correlation(self) -> Array:
        """Correlation of the coordinates of the parameters."""
        size = np.sqrt(np.diag(self.covariance))
        return self.covariance / size / size[:, None]

    @property
    def degrees_of_freedom(self) -> int:
        """Number of data less that of the unknowns."""
        return self.problem.n_data - self.coordinates.size

    @property
    def reduced_chi2(self) -> float:
        """chi2 over the degrees of freedom; about 1 by construction if the size of the noise is unknown."""
        return self.chi2 / self.degrees_of_freedom if self.degrees_of_freedom > 0 else math.nan

    @property
    def goodness_of_fit(self) -> str:
        """Number of data and chi2, in words."""
        words = f"{self.problem.n_data} data, chi2 {self.chi2:.4g} of {self.degrees_of_freedom} degrees of freedom"
        return f"{words}, by an estimate of the noise from the scatter" if self.problem.unknown_sizes else words

    @cached_property
    def window(self) -> tuple[float, float]:
        """Lowest and highest angular frequency [rad/s] of the data; NaN if they contain no time."""
        ends = np.array([record.window() for record in self.data])
        finite = ends[np.isfinite(ends).all(axis=1)]
        if not finite.size and not any(direction.exact for direction in self.flat_directions):
            # The others follow from a known modulus or time.
            times = [series[0] for record in self.data if (series := record.contact_times(self.materials)) is not None]
            times = [series[np.isfinite(series)] for series in times if np.any(np.isfinite(series))]
            finite = math.pi / np.array([[time.max(), time.min()] for time in times])
        return (float(finite[:, 0].min()), float(finite[:, 1].max())) if finite.size else (math.nan, math.nan)

    @property
    def runs_test(self) -> float:
        """Probability of so few changes of sign along all curves, if the residuals were independent."""
        runs = mean = variance = 0.0
        for _, curves in self.curves:
            for curve in curves:
                good = np.isfinite(curve.measured) & np.isfinite(curve.fitted)
                signs = (curve.fitted - curve.measured)[good][np.argsort(curve.x[good], kind="stable")] > 0.0
                up, down = float(signs.sum()), float((~signs).sum())
                n = up + down
                if min(up, down) == 0.0 or n < 3:
                    continue
                pairs = 2.0 * up * down
                runs += 1.0 + float((signs[1:] != signs[:-1]).sum())
                mean += pairs / n + 1.0
                variance += pairs * (pairs - n) / (n * n * (n - 1.0))
        if variance <= 0.0:
            return math.nan
        return 0.5 * math.erfc((mean - runs) / math.sqrt(2.0 * variance))

    @cached_property
    def statements(self) -> tuple[str, ...]:
        """Statements on what the data determine and what they do not determine."""
        n, contacts = self.problem.n_parameters, [record for record in self.data if isinstance(record, Rebounds)]
        impacts, window = contacts[0] if contacts else None, self.window
        if impacts is not None and not all(map(math.isfinite, window)):
            times = impacts.contact_times(self.materials)
            window = math.pi / float(np.nanmax(times)), math.pi / float(np.nanmin(times))
        # Impacts of one power law without a force have a further invariance.
        powers = [record.profile.path_exponent for record in contacts if not np.any(record.external_force)]
        alike = len(powers) == len(self.data) and all(power == powers[0] is not None for power in powers)
        # Directions that no datum determines may lead out of the range of numbers.
        with np.errstate(over="ignore", divide="ignore", invalid="ignore"):
            return tuple(
                knowledge(
                    self.names, self.estimation.jacobian, self.problem.materials, self.coordinates[:n], window,
                    exponent=float(np.asarray(powers[0])) if alike else None, impacts=impacts,
                    unseen=self.uncertainty.unseen,
                )[1]
            )  # fmt: skip

    def profile(self, name: str, level: float = _LEVEL) -> LikelihoodProfile:
        """Return the profile of one parameter: the least sum of squares for each of its values, with the interval."""
        return self.uncertainty.profile(self._place(name), self._level(level))

    def interval(self, level: float = _LEVEL) -> dict[str, tuple[float, float]]:
        """Return the profile intervals of all parameters in SI; an open end is that of the admissible range."""
        share = self._level(level)
        return {name: self.uncertainty.estimate(k, True, share).interval for k, name in enumerate(self.parameters)}

    def _place(self, name: str) -> int:
        return list(self.parameters).index(choice("name", name, self.parameters))

    def moduli(self, angular_frequency: ArrayLike, *, level: float = _LEVEL) -> xarray.Dataset:
        """Return storage and loss part, magnitude and loss tangent of E* over frequency, with bands.

        The variables `..._low` and `..._high` are the ends of the band. The variable `inside` is false outside
        `window`, where no data support the moduli.
        """
        omega = np.atleast_1d(checks.positive("angular_frequency", angular_frequency, "rad/s")).ravel()

        def functions(coordinates: Array) -> Array:
            return modulus_functions(reduced_modulus(self.problem.materials(coordinates)), omega)

        quantities = [MODULI[name] for name in MODULUS_NAMES]
        bands = self._banded(MODULI["angular_frequency"], omega, quantities, functions, level)
        low, high = self.window
        return bands.assign(inside=("angular_frequency", (omega >= low) & (omega <= high)))

    def predict(self, impact: Impact, *, level: float = _LEVEL) -> xarray.Dataset:
        """Return outputs of impacts on the identified material, with bands; the material of `impact` is not used.

        Where the surfaces of the data adhere, those of the impacts adhere as well, with the identified work and
        stress, and the adhesion of `impact` is not used. Where no surfaces of the data adhere, it counts as known.

        Notes
        -----
        Bands follow from slopes at the best fit: of the logarithms of outputs, with adhesion of e^2 and of the
        logarithms of the others. The band of e begins at 0 where a body may stick, and ends at 0 where it sticks for
        sure. A contact that may not end has an infinite end of the band of its time, and one that may end though the
        best one does not has 0 as the other end.

        Warns
        -----
        RestitutionWarning
            If contacts are shorter or longer than those of the data.
        """
        checks.instance("impact", impact, Impact, "must be an Impact")
        if self.problem.space.adhesion:
            impact = replace(impact, adhesion=self.adhesion)
        return predicted(self.uncertainty, impact, self.window, self._level(level))

    @cached_property
    def functionals(self) -> dict[str, Estimate]:
        """Best determined quantities: e, moduli and loss tangent at the middle of the window.

        The loss tangent at pi over the contact time is that of the middle bounce. Its frequency moves with the
        contact time of the material, so that it is known also where no modulus is.
        """
        low, high = self.window
        estimates: dict[str, Estimate] = {}
        balls = next((record for record in self.data if isinstance(record, Rebounds)), None)
        if balls is not None:
            middle = int(np.argsort(balls.velocity)[balls.velocity.size // 2])

            def restitution(coordinates: Array) -> Array:
                return balls.predicted(self.problem.materials(coordinates))["restitution_coefficient"][:, middle]

            name = f"restitution_coefficient at {balls.velocity[middle]:.3g} m/s"
            estimates[name] = self._functional(*self.uncertainty.linearised(restitution), "")
        contacts = next((record for record in self.data if record.contact_times(self.materials) is not None), None)
        if contacts is not None:
            times = contacts.contact_times(self.materials)
            assert times is not None
            middle = int(np.argsort(times[0])[np.isfinite(times[0]).sum() // 2])

            def tangent(coordinates: Array) -> Array:
                materials = self.problem.materials(coordinates)
                times = contacts.contact_times(materials)
                assert times is not None
                moduli = reduced_modulus(materials).complex_modulus(math.pi / times[:, [middle]])[:, 0]
                return moduli.imag / moduli.real

            name = "loss_tangent at pi over the contact time"
            estimates[name] = self._functional(*self.uncertainty.linearised(tangent), "")
        if math.isfinite(low):
            omega = np.array([math.sqrt(low * high)])

            def moduli(coordinates: Array) -> Array:
                return modulus_functions(reduced_modulus(self.problem.materials(coordinates)), omega)[..., 0]

            of_modulus = dict(zip(MODULUS_NAMES, zip(*self.uncertainty.linearised(moduli), strict=True), strict=True))
            for name in ("absolute_modulus", "loss_modulus", "loss_tangent"):
                estimates[f"{name} at {omega[0]:.3g} rad/s"] = self._functional(*of_modulus[name], MODULI[name].unit)
        return estimates

    def _functional(self, value: Any, error: Any, unit: str) -> Estimate:
        number, spread = float(value), float(error)
        reach = self.uncertainty.quantile() * spread
        if number == 0.0 or (number == 1.0 and spread == 0.0):  # nothing relaxes in this model
            return Estimate(number, 0.0, (number, number), True, unit)
        if not reach < FAR:
            return Estimate(None, None, (0.0, math.inf), False, unit, (True, True))
        ends = number * math.exp(-reach), number * math.exp(reach)
        return Estimate(number, number * spread, ends, True, unit)

    def log_probability(self, coordinates: ArrayLike) -> Any:
        """Return the log-probability of coordinates of shape (n_unknown,) or (m, n_unknown), up to a constant.

        The coordinates are those of `coordinates`; the value is -inf outside the bounds. The noise is normal, also if
        the fit has another loss. For samplers such as emcee (with ``vectorize=True``).
        """
        points = checks.number("coordinates", coordinates)
        if points.ndim not in (1, 2) or points.shape[-1] != self.coordinates.size:
            rule = f"must have {self.coordinates.size} numbers in its last axis, not the shape {points.shape}"
            raise InputError("coordinates", rule=rule)
        rows = np.atleast_2d(points)
        logs = np.full(len(rows), -np.inf)
        inside = np.all((rows >= self.problem.low) & (rows <= self.problem.high), axis=1)
        if np.any(inside):
            sums = (self.problem.residuals(rows[inside]) ** 2).sum(axis=1)
            logs[inside] = np.where(np.isfinite(sums), -0.5 * sums, -np.inf)
        return logs if points.ndim > 1 else float(logs[0])

    def to_dict(self) -> dict[str, Any]:
        """Return all numbers as a dict for JSON.

        `posterior` is for other programs: the posterior is nearly normal in its coordinates, with the means there and
        the matrix `covariance`. Each has its name, unit and transform (log, logit between `between`, or linear), its
        bounds in SI, and the prior of the user, with the name of the distribution.
        """
        space = self.problem.space
        head = {"model": space.model.__name__, "fixed": plain(dict(space.fixed)), "posterior": self._posterior()}
        return head | super().to_dict()

    def _posterior(self) -> list[dict[str, Any]]:
        space, entries = self.problem.space, list[dict[str, Any]]()
        for place, parameter in enumerate(space.free):
            low, high = (float(parameter.outward(ends[place])) for ends in (self.problem.low, self.problem.high))
            quantity, prior = parameter.quantity, space.prior.get(parameter.name)
            entry: dict[str, Any] = {"name": parameter.name, "unit": quantity.unit, "transform": parameter.kind}
            if parameter.kind == "logit":
                entry["between"] = [quantity.low, quantity.high]
            entry |= {"mean": float(self.coordinates[place]), "bounds": [low, high], "prior": None}
            if prior is not None:
                entry["prior"] = {"distribution": type(prior).__name__} | asdict(prior)
            entries.append(plain(entry))
        return entries

    def to_toml(self, path: str | Path) -> Path:
        """Write the material as the section of a case file, with the first impact of the data where there is one.

        Comments hold the window, the covariance of the logarithms and the names of the data. `restitution solve` reads
        the file. Parameters that are not determined within a factor of 3 stand at the best fit; the key `undetermined`
        has their names, and results warn of them.
        """
        return write_material(self, path)

    def summary(self, title: str = "") -> Summary:
        """Return statements, estimates and warnings, which `print` and notebooks show."""
        lines = [headline(self.parameters), *self.statements]
        lines += [f"{name} = {estimate.words}" for group in (self.functionals, self.parameters, self.nuisances)
                  for name, estimate in group.items()]  # fmt: skip
        lines.append("A good chi2 does not prove the model: compare several with restitution.identify.compare.")
        return Summary(title or self._short, lines=lines, warnings=self.warnings)

    @property
    def _short(self) -> str:
        return f"{self.problem.space.model.__name__}: {self.goodness_of_fit}"
