"""Result of an identification: estimates, intervals, moduli and predictions with bands."""

from __future__ import annotations

import math
import warnings
from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from restitution import checks
from restitution.display import Shown, Summary
from restitution.errors import InputError, RestitutionWarning
from restitution.identification.bands import FAR, MODULUS_NAMES, banded, limits, modulus_functions
from restitution.identification.estimation import Estimation, EstimationProblem
from restitution.identification.material_file import known_times
from restitution.identification.observations import Curve, Observations
from restitution.identification.profiles import LikelihoodProfile
from restitution.identification.rebounds import Rebounds
from restitution.identification.uncertainty import UNDETERMINED, Estimate, FlatDirection, Uncertainty, headline
from restitution.impact.batch import Batch
from restitution.impact.problem import Impact
from restitution.material.columns import MaterialColumns
from restitution.material.fractional import FractionalMaterial
from restitution.material.viscoelastic import Material
from restitution.pictures import draw
from restitution.quantities import DEFAULT_OUTPUTS, MODULI, NUMBER, OUTPUTS, Quantity

if TYPE_CHECKING:
    import xarray
    from matplotlib.figure import Figure

Array = NDArray[np.float64]

_LEVEL = 0.95


@dataclass(frozen=True, eq=False, repr=False)
class Identification(Shown):
    """Material identified from measured data; see `restitution.identify`.

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
    >>> found = rs.identify(table, rs.standard_solid, fixed={"poisson_ratio": 0.5})
    >>> print(round(found.parameters["branch_modulus"].value / 2e6, 6))
    1.0
    """

    uncertainty: Uncertainty
    parameters: dict[str, Estimate]
    nuisances: dict[str, Estimate]
    warnings: tuple[str, ...] = ()

    @property
    def estimation(self) -> Estimation:
        """Best fit, the other fits, and the Jacobian."""
        return self.uncertainty.estimation

    @property
    def flat_directions(self) -> tuple[FlatDirection, ...]:
        """Common changes of the parameters that the data do not determine."""
        return self.uncertainty.flat_directions

    @property
    def problem(self) -> EstimationProblem:
        """Data and unknowns of the fit."""
        return self.estimation.problem

    @property
    def data(self) -> tuple[Observations, ...]:
        """Sets of data."""
        return self.problem.data

    @property
    def names(self) -> tuple[str, ...]:
        """Names of the unknowns."""
        return (*self.problem.space.names, *self.nuisances)[: self.coordinates.size]

    @property
    def coordinates(self) -> Array:
        """Coordinates of the best fit."""
        return self.estimation.fit.coordinates

    @cached_property
    def columns(self) -> MaterialColumns:
        """The best material as columns of one row."""
        return self.problem.columns(self.coordinates[None])

    @cached_property
    def material(self) -> Material | FractionalMaterial:
        """Material of the best fit, which holds within the window; `undetermined` names its unknown constants."""
        made = self.problem.space.material(self.coordinates[: self.problem.n_parameters])
        low, high = self.window
        if not isinstance(made, Material):
            return made
        made = replace(made, undetermined=self.undetermined or None)
        if 0.0 < low < high:
            return replace(made, window=known_times(self), assumptions="identified from measured data")
        return made

    @property
    def undetermined(self) -> tuple[str, ...]:
        """Names of the parameters that the data do not determine within a factor of 3."""
        return tuple(name for name, one in self.parameters.items() if one.factor > UNDETERMINED)

    @cached_property
    def covariance(self) -> Array:
        """Covariance of the coordinates of the parameters."""
        n = self.problem.n_parameters
        return self.uncertainty.covariance[:n, :n]

    @property
    def correlation(self) -> Array:
        """Correlation of the coordinates of the parameters."""
        size = np.sqrt(np.diag(self.covariance))
        return self.covariance / size / size[:, None]

    @cached_property
    def residuals(self) -> tuple[Array, ...]:
        """Residuals of each set of data over their standard deviations."""
        found, at = self.problem.residuals(self.coordinates[None])[0], 0
        parts: list[Array] = []
        for one in self.data:
            parts.append(found[at : at + one.size])
            at += one.size
        return tuple(parts)

    @property
    def chi2(self) -> float:
        """Sum of the squared residuals, without priors."""
        return float(sum((part**2).sum() for part in self.residuals))

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

    @property
    def curves(self) -> list[tuple[str, list[Curve]]]:
        """Measured and fitted values of each set of data, with its label."""
        nuisances = self.problem.nuisances(self.coordinates[None])
        return [(one.label, one.curves(self.columns, own)) for one, own in zip(self.data, nuisances, strict=True)]

    @cached_property
    def window(self) -> tuple[float, float]:
        """Lowest and highest angular frequency [rad/s] of the data; NaN if they contain no time."""
        ends = np.array([one.window() for one in self.data])
        known = ends[np.isfinite(ends).all(axis=1)]
        if not known.size and not any(one.exact for one in self.flat_directions):
            # The others follow from a known modulus or time.
            times = [found[0] for one in self.data if (found := one.contact_times(self.columns)) is not None]
            times = [found[np.isfinite(found)] for found in times if np.any(np.isfinite(found))]
            known = math.pi / np.array([[time.max(), time.min()] for time in times])
        return (float(known[:, 0].min()), float(known[:, 1].max())) if known.size else (math.nan, math.nan)

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
        # It imports `Identification` for its types.
        from restitution.identification.statements import statements

        # Directions that no datum determines may lead out of the range of numbers.
        with np.errstate(over="ignore", divide="ignore", invalid="ignore"):
            return tuple(statements(self))

    def profile(self, name: str, level: float = _LEVEL) -> LikelihoodProfile:
        """Profile of one parameter: the least sum of squares for each of its values, with the interval."""
        return self.uncertainty.profile(self._place(name), self._level(level))

    def interval(self, level: float = _LEVEL) -> dict[str, tuple[float, float]]:
        """Profile intervals of all parameters in SI; an open end is that of the admissible range."""
        share = self._level(level)
        return {name: self.uncertainty.estimate(k, True, share).interval for k, name in enumerate(self.parameters)}

    def _place(self, name: str) -> int:
        if name not in self.parameters:
            raise InputError("name", name, f"must be one of {', '.join(self.parameters)}")
        return list(self.parameters).index(name)

    def _level(self, level: float) -> float:
        return float(checks.between("level", level, 0.0, 1.0))

    def moduli(self, angular_frequency: ArrayLike, *, level: float = _LEVEL) -> xarray.Dataset:
        """Storage and loss part, magnitude and loss tangent of the reduced modulus E* over frequency, with bands.

        The variables `..._low` and `..._high` are the ends of the band. The variable `inside` is false outside
        `window`, where no data support the moduli.
        """
        omega = np.atleast_1d(checks.positive("angular_frequency", angular_frequency, "rad/s"))

        def functions(coordinates: Array) -> Array:
            return modulus_functions(self.problem.columns(coordinates).reduced, omega)

        quantities = [MODULI[name] for name in MODULUS_NAMES]
        found = self._banded(MODULI["angular_frequency"], omega, quantities, functions, level)
        low, high = self.window
        return found.assign(inside=("angular_frequency", (omega >= low) & (omega <= high)))

    def predict(self, impact: Impact, *, level: float = _LEVEL) -> xarray.Dataset:
        """Outputs of impacts on the identified material, with bands; the material of `impact` is not used.

        Warns
        -----
        RestitutionWarning
            If contacts are shorter or longer than those of the data.
        """
        if not isinstance(impact, Impact):
            raise InputError("impact", impact, "must be an Impact")

        def functions(coordinates: Array) -> Array:
            columns, rows = self.problem.columns(coordinates), list[Array]()
            for n in range(columns.size):
                bulk = columns.bulk.equilibria[n]
                made = Material(columns.shear.row(n), math.inf if math.isinf(bulk) else columns.bulk.row(n))
                found = Batch.from_impact(replace(impact, material=made)).solve(1e-9, workers=1)
                rows.append(np.stack([found[name] for name in DEFAULT_OUTPUTS]))
            return np.stack(rows)

        velocity = np.broadcast_to(np.asarray(impact.velocity, dtype=np.float64), impact.shape).reshape(-1)
        axis = Quantity("impact", NUMBER, "number of the impact")
        numbers = np.arange(velocity.size, dtype=np.float64)
        found = self._banded(axis, numbers, [OUTPUTS[name] for name in DEFAULT_OUTPUTS], functions, level)
        low, high = self.window
        frequency = math.pi / found["contact_time"].to_numpy()
        inside = (frequency > low * (1.0 - 1e-9)) & (frequency < high * (1.0 + 1e-9))
        if math.isfinite(low) and not np.all(inside):
            outside = int((~inside).sum())
            text = (f"{outside} of {velocity.size} impacts leave the window of the data, contact times from "
                    f"{math.pi / high:.3g} to {math.pi / low:.3g} s")  # fmt: skip
            warnings.warn(RestitutionWarning("window", text), stacklevel=2)
        return found.assign_coords(velocity=("impact", velocity))

    def _banded(
        self, axis: Quantity, x: Array, quantities: list[Quantity], functions: Callable[[Array], Array], level: float
    ) -> xarray.Dataset:
        """Functions of the coordinates, shape (m, n_quantity, n_x), with bands of their logarithms."""
        values, errors = self.uncertainty.linearised(functions)
        low, high = limits(values, errors, self.uncertainty.quantile(self._level(level)))
        most = [1.0 if one.name == "restitution_coefficient" else math.inf for one in quantities]
        high = np.minimum(high, np.array(most)[:, None])
        return banded(axis, x, level, dict(zip(quantities, zip(values, low, high, strict=True), strict=True)))

    @cached_property
    def functionals(self) -> dict[str, Estimate]:
        """Best determined quantities: e, moduli and loss tangent at the middle of the window.

        The loss tangent at pi over the contact time is that of the middle bounce. Its frequency moves with the
        contact time of the material, so that it is known also where no modulus is.
        """
        low, high = self.window
        found: dict[str, Estimate] = {}
        balls = next((one for one in self.data if isinstance(one, Rebounds)), None)
        if balls is not None:
            middle = int(np.argsort(balls.velocity)[balls.velocity.size // 2])

            def restitution(coordinates: Array) -> Array:
                columns = self.problem.columns(coordinates)
                return balls.predicted(columns)["restitution_coefficient"][:, middle]

            name = f"restitution_coefficient at {balls.velocity[middle]:.3g} m/s"
            found[name] = self._functional(*self.uncertainty.linearised(restitution), "")
        contacts = next((one for one in self.data if one.contact_times(self.columns) is not None), None)
        if contacts is not None:
            times = contacts.contact_times(self.columns)
            assert times is not None
            middle = int(np.argsort(times[0])[np.isfinite(times[0]).sum() // 2])

            def tangent(coordinates: Array) -> Array:
                columns = self.problem.columns(coordinates)
                own = contacts.contact_times(columns)
                assert own is not None
                moduli = columns.reduced.complex_modulus(math.pi / own[:, middle])
                return np.diagonal(moduli.imag / moduli.real)

            name = "loss_tangent at pi over the contact time"
            found[name] = self._functional(*self.uncertainty.linearised(tangent), "")
        if math.isfinite(low):
            omega = np.array([math.sqrt(low * high)])

            def moduli(coordinates: Array) -> Array:
                return modulus_functions(self.problem.columns(coordinates).reduced, omega)[..., 0]

            of_modulus = dict(zip(MODULUS_NAMES, zip(*self.uncertainty.linearised(moduli), strict=True), strict=True))
            for name in ("absolute_modulus", "loss_modulus", "loss_tangent"):
                found[f"{name} at {omega[0]:.3g} rad/s"] = self._functional(*of_modulus[name], MODULI[name].unit)
        return found

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
        """Logarithm of the probability of coordinates of shape (n_unknown,) or (m, n_unknown), up to a constant.

        The coordinates are those of `coordinates`; the value is -inf outside the bounds. The noise is normal, also if
        the fit has another loss. For samplers such as emcee (with ``vectorize=True``).
        """
        given = np.asarray(coordinates, dtype=np.float64)
        rows = np.atleast_2d(given)
        found = np.full(len(rows), -np.inf)
        inside = np.all((rows >= self.problem.low) & (rows <= self.problem.high), axis=1)
        if np.any(inside):
            sums = (self.problem.residuals(rows[inside]) ** 2).sum(axis=1)
            found[inside] = np.where(np.isfinite(sums), -0.5 * sums, -np.inf)
        return found if given.ndim > 1 else float(found[0])

    def plot(self) -> Figure:
        """Figure of data and fit, residuals, profiles, and moduli with bands."""
        return draw("identification.overview", self)

    def to_dict(self) -> dict[str, Any]:
        """All numbers as a dict for JSON."""
        low, high = self.window
        return {
            "model": self.problem.space.model.__name__,
            "parameters": {name: one._asdict() for name, one in self.parameters.items()},
            "nuisances": {name: one._asdict() for name, one in self.nuisances.items()},
            "functionals": {name: one._asdict() for name, one in self.functionals.items()},
            "fixed": {name: np.asarray(value).tolist() for name, value in self.problem.space.fixed.items()},
            "chi2": self.chi2,
            "reduced_chi2": self.reduced_chi2,
            "covariance": self.covariance.tolist(),
            "window": [low, high],
            "flat_directions": [one._asdict() for one in self.flat_directions],
            "statements": list(self.statements),
            "undetermined": list(self.undetermined),
            "warnings": list(self.warnings),
        }

    def to_toml(self, path: str | Path) -> Path:
        """Write the material as the section of a case file, with the first impact of the data where there is one.

        Comments hold the window, the covariance of the logarithms and the names of the data. `restitution solve` reads
        the file. Parameters that are not determined within a factor of 3 stand at the best fit; the key `undetermined`
        has their names, and results warn of them.
        """
        from restitution.identification.material_file import write_material

        return write_material(self, path)

    def summary(self, title: str = "") -> Summary:
        """Statements, estimates and warnings, which `print` and notebooks show."""
        lines = [headline(self.parameters), *self.statements]
        lines += [f"{name} = {one.words}" for group in (self.functionals, self.parameters, self.nuisances)
                  for name, one in group.items()]  # fmt: skip
        lines.append("A good chi2 does not prove the model: compare several with restitution.identify.compare.")
        return Summary(title or self._short, lines=lines, warnings=self.warnings)

    @property
    def _short(self) -> str:
        return f"{self.problem.space.model.__name__}: {self.goodness_of_fit}"
