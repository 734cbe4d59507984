"""Relaxation spectrum without a model: smooth on a logarithmic grid of times, only inside the measured window."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike

from restitution import checks
from restitution.checks import Array
from restitution.errors import InputError
from restitution.identification.fit import Estimation, EstimationProblem, Fit, minimise
from restitution.identification.impacts import Rebounds
from restitution.identification.observations import Observations
from restitution.identification.parameters import Parameters
from restitution.identification.result import FittedResult
from restitution.identification.uncertainty import MODULUS_NAMES, Uncertainty, modulus_functions, nuisance_estimates
from restitution.material.conversion import bulk_factor
from restitution.material.prony import PronySeries
from restitution.material.viscoelastic import Material
from restitution.numerics.differences import FORWARD
from restitution.quantities import MODULI, check_single
from restitution.result import Summary, Table

if TYPE_CHECKING:
    import xarray as xr


_A_DECADE = 2
# The grid extends beyond the window of the data by this factor: a branch has effects a decade from its time.
_BEYOND = 30.0
# The moduli are given within the window, widened by this factor on both sides.
_PROMISE = 2.0
_LEAST_IMPACTS, _LEAST_VALUES = 8, 16
# A spectrum has no constants of a model.
_NO_MODEL = Parameters(Material, (), {}, {}, {})
_WEIGHTS = tuple(10.0**power for power in range(4, -5, -1))


@dataclass(frozen=True, eq=False)
class SpectrumProblem(EstimationProblem):
    """Residuals over the logarithms of E*_inf and of the branch moduli of E* on a grid, and over the nuisances."""

    times: Array  # of the grid [s]
    poisson_ratio: float  # constant
    frequencies: tuple[float, float]  # lowest and highest angular frequency [rad/s] of the data
    weight: float = 1.0  # of the squared second differences of the logarithms of the branch moduli

    @property
    def n_parameters(self) -> int:
        """Number of moduli."""
        return 1 + self.times.size

    def reduced_modulus(self, coordinates: Array) -> PronySeries:
        """Return E* at coordinates of shape (m, n_unknown), shape (m, 1)."""
        values = np.exp(coordinates[:, None, : self.n_parameters])
        times = np.broadcast_to(self.times, values[..., 1:].shape)
        return PronySeries.from_checked(values[..., 0], values[..., 1:], times)

    def materials(self, coordinates: Array) -> Material:
        """Return materials of the constant Poisson ratio, shape (m, 1)."""
        reduced = self.reduced_modulus(coordinates)
        shear = reduced.scaled(0.5 * (1.0 - self.poisson_ratio))
        factor = float(bulk_factor(np.asarray(self.poisson_ratio)))
        materials = Material(shear, math.inf if math.isinf(factor) else shear.scaled(factor))
        # At a constant Poisson ratio E* is a multiple of the shear modulus: no roots of dozens of branches.
        materials.__dict__["_reduced"] = reduced
        return materials

    def penalties(self, coordinates: Array) -> Array:
        """Return the weighted second differences."""
        return math.sqrt(self.weight) * np.diff(coordinates[:, 1 : self.n_parameters], 2, axis=1)

    def influence(self, jacobian: Array) -> float:
        """Return the trace of the influence matrix: the number of parameters that the data determine."""
        data = jacobian[: self.n_data]
        inverse: Any = np.linalg.pinv(jacobian.T @ jacobian, rcond=1e-14, hermitian=True)
        return float(np.trace(inverse @ (data.T @ data)))


@dataclass(frozen=True, eq=False, repr=False)
class Spectrum(FittedResult):
    """Smooth relaxation spectrum of the reduced modulus, from `rs.identify(data, "spectrum")`.

    `plot` shows data and fit, residuals, and moduli with bands.
    """

    _numbers = (
        "relaxation_times", "branch_moduli", "equilibrium_modulus", "poisson_ratio", "weight", "chi2",
        "effective_parameters", "window", "nuisances", "statements",
    )  # fmt: skip
    _picture = "identification.overview"
    effective_parameters: float  # trace of the influence matrix: the number that the data determine
    nuisances: dict[str, float]  # unknowns of the measurements, by name

    @property
    def problem(self) -> SpectrumProblem:
        """Data and unknowns of the fit."""
        problem = self.estimation.problem
        assert isinstance(problem, SpectrumProblem)
        return problem

    @property
    def relaxation_times(self) -> Array:
        """Relaxation times of the grid [s], shape (n,)."""
        return self.problem.times

    @property
    def branch_moduli(self) -> Array:
        """Branch moduli of E*(t) [Pa], shape (n,)."""
        return np.exp(self.coordinates[1 : self.problem.n_parameters])

    @property
    def equilibrium_modulus(self) -> float:
        """Equilibrium modulus of E*(t) [Pa]."""
        return float(np.exp(self.coordinates[0]))

    @property
    def poisson_ratio(self) -> float:
        """Constant Poisson ratio."""
        return self.problem.poisson_ratio

    @property
    def weight(self) -> float:
        """Weight of the squared second differences of the logarithms of the branch moduli."""
        return self.problem.weight * self.problem.factors[0] ** 2

    @property
    def window(self) -> tuple[float, float]:
        """Lowest and highest angular frequency [rad/s] of the data."""
        return self.problem.frequencies

    @property
    def degrees_of_freedom(self) -> float:
        """Number of data less the effective parameters and the nuisances."""
        return self.problem.n_data - self.effective_parameters

    @property
    def reduced_chi2(self) -> float:
        """chi2 over the degrees of freedom."""
        return self.chi2 / self.degrees_of_freedom

    @property
    def reduced_modulus(self) -> PronySeries:
        """E*(t) as a Prony series."""
        return PronySeries(self.equilibrium_modulus, self.branch_moduli, self.relaxation_times)

    @property
    def material(self) -> Material:
        """Material with a constant Poisson ratio, valid in the window of the data."""
        low, high = self.window
        each = self.materials.row(0, 0)
        return replace(each, window=(1.0 / high, 1.0 / low), assumptions="smooth spectrum of measured data")

    def moduli(self, angular_frequency: ArrayLike, *, level: float = 0.95) -> xr.Dataset:
        """Return reduced moduli over frequency with bands; NaN outside half to twice the window of the data."""
        omega = np.atleast_1d(np.asarray(checks.positive("angular_frequency", angular_frequency, "rad/s")))
        low, high = self.window[0] / _PROMISE, self.window[1] * _PROMISE

        def functions(coordinates: Array) -> Array:
            moduli = modulus_functions(self.problem.reduced_modulus(coordinates), omega)
            return np.where((omega >= low) & (omega <= high), moduli, np.nan)

        quantities = [MODULI[name] for name in MODULUS_NAMES]
        return self._banded(MODULI["angular_frequency"], omega, quantities, functions, level)

    @property
    def statements(self) -> tuple[str, ...]:
        """Range of the moduli, and doubts about the spectrum, in words."""
        low, high = self.window[0] / _PROMISE, self.window[1] * _PROMISE
        lines = [
            f"Moduli and bands hold from {low:.3g} to {high:.3g} rad/s, half to twice the window of the data, "
            "if the spectrum is smooth. A single relaxation time may err by more, also with a good chi-square."
        ]
        if self.reduced_chi2 > 1.5:
            lines.append(
                f"The reduced chi-square is {self.reduced_chi2:.2g}: the material may have single relaxation times. "
                "Compare a model with few terms."
            )
        return tuple(lines)

    def to_dict(self) -> dict[str, Any]:
        """Return all numbers as plain Python objects, for JSON."""
        return {"model": "spectrum"} | super().to_dict()

    def summary(self, title: str = "") -> Summary:
        """Return a table of the moduli within the window, which `print` and notebooks show."""
        omega = np.geomspace(*self.window, 4)
        values = modulus_functions(self.problem.reduced_modulus(self.coordinates[None]), omega)[0].T
        rows = [
            (f"{w:.4g}", f"{row[0]:.4g}", f"{row[1]:.4g}", f"{row[3]:.4f}")
            for w, row in zip(omega, values, strict=True)
        ]
        table = Table(("omega [rad/s]", "storage [Pa]", "loss [Pa]", "tan delta"), rows)
        return Summary(title or "Relaxation spectrum", table, self.statements)

    @property
    def _short(self) -> str:
        return f"{self.relaxation_times.size} relaxation times, chi2 = {self.chi2:.4g}"


def spectrum(data: Observations | Sequence[Observations], *, poisson_ratio: float = 0.5) -> Spectrum:
    """Return a smooth relaxation spectrum that fits data.

    Parameters
    ----------
    data : Observations or sequence
        Measured data with at least 8 impacts, and at least one contact time, force or modulus.
    poisson_ratio : float
        Constant Poisson ratio; it affects only data in shear or tension, and the material.

    Returns
    -------
    Spectrum
        On a grid of two relaxation times a decade.

    Raises
    ------
    InputError
        If there are fewer than 8 impacts, or the data contain no time, force or modulus.

    Notes
    -----
    Least squares of the residuals and of the weighted second differences of the logarithms of the branch moduli
    (Tikhonov regularisation; Honerkamp and Weese, Rheol. Acta 32 (1993) 65). The weights are a factor of ten apart;
    the one with the least generalised cross-validation is taken (Golub, Heath and Wahba, Technometrics 21 (1979) 215).
    """
    sets = (data,) if isinstance(data, Observations) else tuple(data)
    nu = check_single("poisson_ratio", poisson_ratio)
    _refuse(sets)
    problem, start = _problem(sets, nu)
    best, rises, theta = (math.inf, problem, start), 0, start
    # From the smoothest spectrum to rougher ones, until two of them are worse.
    for weight in _WEIGHTS:
        problem = replace(problem, weight=weight)
        # A smooth spectrum without an equilibrium modulus is no start for rougher ones.
        theta[0] = max(theta[0], start[0] - 3.0)
        theta = minimise(problem, theta, tolerance=1e-2).coordinates
        values = problem.residuals(FORWARD.points(theta, problem.steps))
        if not np.all(np.isfinite(residuals := values[0, : problem.n_data])):
            raise InputError("data", rule="are too far from those of a material with a smooth spectrum")
        influence = problem.influence(np.nan_to_num(FORWARD.slopes(values, problem.steps)).T)
        score = float(residuals @ residuals) / (residuals.size - influence) ** 2
        best, rises = ((score, problem, theta.copy()), 0) if score < best[0] else (best, rises + 1)
        if rises > 1:
            break
    _, problem, theta = best
    residuals, jacobian = problem.linearised(theta)
    effective = problem.influence(jacobian)
    if problem.unknown_sizes:
        measured = residuals[: problem.n_data]
        # The weight of the differences is relative to that of the data.
        scale = math.sqrt(float(measured @ measured) / max(measured.size - effective, 1.0))
        problem = replace(problem, factors=(scale,) * len(sets), weight=problem.weight / scale**2)
        residuals, jacobian = residuals / scale, jacobian / scale
    fit = Fit(theta, float((residuals**2).sum()))
    uncertainty = Uncertainty(Estimation(problem, "linear", fit, (fit,), residuals, jacobian))
    estimates = nuisance_estimates(uncertainty).items()
    # Unknowns without an error were projected out.
    nuisances = {name: float(each.value or 0.0) for name, each in estimates if each.standard_error is not None}
    return Spectrum(uncertainty, effective, nuisances)


def _refuse(sets: Sequence[Observations]) -> None:
    impacts = sum(record.velocity.size for record in sets if isinstance(record, Rebounds))
    if all(isinstance(record, Rebounds) for record in sets) and impacts < _LEAST_IMPACTS:
        raise InputError("data", impacts, f"must hold at least {_LEAST_IMPACTS} impacts for a spectrum")
    values = sum(record.size for record in sets)
    if values < _LEAST_VALUES and not impacts >= _LEAST_IMPACTS:
        raise InputError("data", values, f"must hold at least {_LEAST_VALUES} values for a spectrum")
    if not any(record.fixes_time for record in sets):
        rule = "must hold a contact time, a force or a modulus: e alone determines no modulus and no time"
        raise InputError("data", rule=rule)


def _problem(sets: Sequence[Observations], poisson_ratio: float) -> tuple[SpectrumProblem, Array]:
    """Return the problem on the grid of the data, and a start: a flat spectrum with their loss modulus."""
    tables = [table for record in sets if (table := record.effective_moduli()) is not None]
    ends = [end for record in sets for end in record.window() if math.isfinite(end)]
    ends += [float(end) for table in tables for end in table.angular_frequency[[0, -1]]] if not ends else []
    low, high = min(ends), max(ends)
    decades = math.log10(high / low * _BEYOND**2)
    times = np.geomspace(1.0 / (high * _BEYOND), _BEYOND / low, math.ceil(_A_DECADE * decades) + 1)
    storage = float(np.median(np.concatenate([table.storage_modulus for table in tables])))
    loss = float(np.median(np.concatenate([table.loss_modulus for table in tables])))
    # The loss modulus of a flat spectrum is pi/2 times the modulus per unit of the logarithm of time.
    branch = max(2.0 / math.pi * loss * math.log(10.0) / _A_DECADE, 1e-4 * storage)
    touches = [nuisance.start / nuisance.step for record in sets for nuisance in record.nuisances]
    start = np.array([math.log(0.5 * storage), *[math.log(branch)] * times.size, *touches])
    nowhere = np.full(start.size, math.inf)
    problem = SpectrumProblem(
        tuple(sets),
        _NO_MODEL,
        -nowhere,
        nowhere,
        (0.0, math.inf),
        (1.0,) * len(sets),
        times,
        poisson_ratio,
        (low, high),
    )
    return problem, start
