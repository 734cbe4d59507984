"""Relaxation spectrum without a model: smooth on a logarithmic grid of times, only inside the measured window."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike

from restitution import checks
from restitution.checks import Array
from restitution.errors import InputError
from restitution.identification.impacts import Rebounds
from restitution.identification.observations import Curve, Observations, nuisances_of
from restitution.identification.uncertainty import MODULUS_NAMES, banded, limits, modulus_functions, quantile
from restitution.material.conversion import bulk_factor
from restitution.material.prony import PronySeries
from restitution.material.viscoelastic import Material
from restitution.quantities import MODULI, check_single
from restitution.result import Result, Summary, Table

if TYPE_CHECKING:
    import xarray as xr


_A_DECADE = 2
# The grid extends beyond the window of the data by this factor: a branch has effects a decade from its time.
_BEYOND = 30.0
# The moduli are given within the window, widened by this factor on both sides.
_PROMISE = 2.0
_LEAST_IMPACTS, _LEAST_VALUES = 8, 16
_STEP = 1e-4
_WEIGHTS = tuple(10.0**power for power in range(4, -5, -1))


@dataclass(frozen=True, eq=False, repr=False)
class Spectrum(Result):
    """Smooth relaxation spectrum of the reduced modulus, from `rs.identify(data, "spectrum")`.

    `plot` shows data and fit, residuals, and moduli with bands.
    """

    _numbers = (
        "relaxation_times", "branch_moduli", "equilibrium_modulus", "poisson_ratio", "weight", "chi2",
        "effective_parameters", "window", "nuisances", "statements",
    )  # fmt: skip
    _picture = "identification.overview"
    relaxation_times: Array  # of the grid [s], shape (n,)
    branch_moduli: Array  # of the reduced modulus E*(t) [Pa], shape (n,)
    equilibrium_modulus: float  # of E*(t) [Pa]
    poisson_ratio: float  # constant
    weight: float  # of the squared second differences of the logarithms of the branch moduli
    chi2: float  # sum of squares of the residuals over their standard deviations
    effective_parameters: float  # trace of the influence matrix: the number that the data determine
    covariance: Array  # of the logarithms of the equilibrium modulus and of the branch moduli
    window: tuple[float, float]  # lowest and highest angular frequency [rad/s] of the data
    residuals: tuple[Array, ...]  # of each set of data, over their standard deviations
    nuisances: dict[str, float]  # unknowns of the measurements, by name
    data: tuple[Observations, ...] = field(repr=False)

    @property
    def degrees_of_freedom(self) -> float:
        """Number of data less the effective parameters and the nuisances."""
        return sum(map(len, self.residuals)) - self.effective_parameters

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
        shear = self.reduced_modulus.scaled(0.5 * (1.0 - self.poisson_ratio))
        factor = float(bulk_factor(np.asarray(self.poisson_ratio)))
        bulk = math.inf if math.isinf(factor) else shear.scaled(factor)
        low, high = self.window
        return Material(shear, bulk, window=(1.0 / high, 1.0 / low), assumptions="smooth spectrum of measured data")

    @property
    def curves(self) -> list[tuple[str, list[Curve]]]:
        """Measured and fitted values of each set of data, with its label."""
        materials, values = self.material.reshaped((1, 1)), iter(self.nuisances.values())
        return [
            (record.label, record.curves(materials, np.array([[next(values) for _ in record.nuisances]])))
            for record in self.data
        ]

    def moduli(self, angular_frequency: ArrayLike, *, level: float = 0.95) -> xr.Dataset:
        """Return reduced moduli over frequency with bands; NaN outside half to twice the window of the data."""
        omega = np.atleast_1d(np.asarray(checks.positive("angular_frequency", angular_frequency, "rad/s")))
        width = quantile(float(checks.between("level", level, 0.0, 1.0)))
        points = self._theta + np.vstack([np.zeros(self._theta.size), _STEP * np.eye(self._theta.size)])
        logs = np.log(modulus_functions(_series(points, self.relaxation_times), omega))
        slopes = (logs[1:] - logs[0]) / _STEP
        errors = np.sqrt(np.maximum(np.einsum("pkn,pq,qkn->kn", slopes, self.covariance, slopes), 0.0))
        low, high = self.window[0] / _PROMISE, self.window[1] * _PROMISE
        values = np.where((omega >= low) & (omega <= high), np.exp(logs[0]), np.nan)
        both = zip(values, *limits(values, errors, width), strict=True)
        quantities = (MODULI[name] for name in MODULUS_NAMES)
        return banded(MODULI["angular_frequency"], omega, level, dict(zip(quantities, both, strict=True)))

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
        values = modulus_functions(_series(self._theta[None], self.relaxation_times), omega)[0].T
        rows = [
            (f"{w:.4g}", f"{row[0]:.4g}", f"{row[1]:.4g}", f"{row[3]:.4f}")
            for w, row in zip(omega, values, strict=True)
        ]
        table = Table(("omega [rad/s]", "storage [Pa]", "loss [Pa]", "tan delta"), rows)
        return Summary(title or "Relaxation spectrum", table, self.statements)

    @property
    def _short(self) -> str:
        return f"{self.relaxation_times.size} relaxation times, chi2 = {self.chi2:.4g}"

    @property
    def _theta(self) -> Array:
        """Logarithms of the moduli."""
        return np.log(np.append(self.equilibrium_modulus, self.branch_moduli))


def _series(theta: Array, times: Array) -> PronySeries:
    """Return reduced moduli of logarithms of shape (m, 1 + n)."""
    values = np.exp(theta)
    return PronySeries.from_checked(values[:, 0], values[:, 1:], np.broadcast_to(times, (len(values), times.size)))


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
    problem = _Problem(sets, nu)
    theta, weight = problem.solve()
    jacobian, residuals = problem.jacobian(theta), problem.residuals(theta[None])[0]
    n, k = residuals.size, problem.times.size
    inverse, effective = _influence(jacobian, problem.penalty, weight)
    chi2 = float(residuals @ residuals)
    scale = chi2 / max(n - effective, 1.0) if any(record.scaled for record in sets) else 1.0
    ends = np.cumsum([record.size for record in sets])[:-1]
    prefixes = [f"{record.label or n}: " if len(sets) > 1 else "" for n, record in enumerate(sets)]
    names = [
        prefix + nuisance.name for prefix, record in zip(prefixes, sets, strict=True) for nuisance in record.nuisances
    ]
    return Spectrum(
        problem.times, np.exp(theta[1 : k + 1]), float(np.exp(theta[0])), nu, weight, chi2 / scale, effective,
        scale * inverse[: k + 1, : k + 1], problem.window, tuple(np.split(residuals / math.sqrt(scale), ends)),
        dict(zip(names, (theta[k + 1 :] * problem.steps).tolist(), strict=True)), sets,
    )  # fmt: skip


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


class _Problem:
    """Residuals of the data over logarithms of the moduli and the nuisances, and the penalty."""

    def __init__(self, sets: Sequence[Observations], poisson_ratio: float) -> None:
        self.sets = sets
        self.shear_factor = 0.5 * (1.0 - poisson_ratio)
        self.bulk_factor = float(bulk_factor(np.asarray(poisson_ratio)))
        tables = [table for record in sets if (table := record.effective_moduli()) is not None]
        ends = [end for record in sets for end in record.window() if math.isfinite(end)]
        ends += [float(end) for table in tables for end in table.angular_frequency[[0, -1]]] if not ends else []
        low, high = self.window = min(ends), max(ends)
        decades = math.log10(high / low * _BEYOND**2)
        self.times = np.geomspace(1.0 / (high * _BEYOND), _BEYOND / low, math.ceil(_A_DECADE * decades) + 1)
        nuisances = [nuisance for record in sets for nuisance in record.nuisances]
        self.steps = np.array([nuisance.step for nuisance in nuisances])
        self._last = np.empty(0), np.empty((0, 0))
        k = self.times.size
        self.penalty = np.zeros((k - 2, 1 + k + len(nuisances)))
        self.penalty[:, 1 : k + 1] = np.diff(np.eye(k), 2, axis=0)
        storage = np.concatenate([table.storage_modulus for table in tables])
        loss = np.concatenate([table.loss_modulus for table in tables])
        # The loss modulus of a flat spectrum is pi/2 times the modulus per unit of the logarithm of time.
        branch = 2.0 / math.pi * float(np.median(loss)) * math.log(10.0) / _A_DECADE
        moduli = np.full(k, max(branch, 1e-4 * float(np.median(storage))))
        start = np.append(0.5 * float(np.median(storage)), moduli)
        self.start = np.append(np.log(start), [nuisance.start / nuisance.step for nuisance in nuisances])

    def residuals(self, theta: Array) -> Array:
        """Return residuals at points of shape (m, p), shape (m, n)."""
        k = self.times.size + 1
        reduced = _series(theta[:, :k], self.times).reshaped((len(theta), 1))
        shear = reduced.scaled(self.shear_factor)
        bulk = math.inf if math.isinf(self.bulk_factor) else shear.scaled(self.bulk_factor)
        materials = Material(shear, bulk)
        # At a constant Poisson ratio E* is a multiple of the shear modulus: no roots of dozens of branches.
        materials.__dict__["_reduced"] = reduced
        each = zip(self.sets, nuisances_of(self.sets, theta[:, k:]), strict=True)
        return np.hstack([record.residuals(materials, nuisances) for record, nuisances in each])

    def jacobian(self, theta: Array, base: Array | None = None) -> Array:
        """Return derivatives by forward differences, shape (n, p); those of the last point are kept."""
        if not np.array_equal(theta, self._last[0]):
            here = self.residuals(theta[None])[0] if base is None else base
            slopes = np.nan_to_num((self.residuals(theta + _STEP * np.eye(theta.size)) - here) / _STEP).T
            self._last = theta.copy(), slopes
        return self._last[1]

    def solve(self) -> tuple[Array, float]:
        """Return the minimum of least generalised cross-validation; weights fall from the smoothest spectrum."""
        theta, best, rises = self.start.copy(), (math.inf, self.start, 1.0), 0
        for weight in _WEIGHTS:
            # A smooth spectrum without an equilibrium modulus is no start for rougher ones.
            theta[0] = max(theta[0], self.start[0] - 3.0)
            theta = self._minimum(theta, weight)
            score = self._score(theta, weight)
            if score < best[0]:
                best, rises = (score, theta, weight), 0
            else:
                rises += 1
            if rises > 1:
                break
        return best[1], best[2]

    def _minimum(self, theta: Array, weight: float) -> Array:
        from scipy.optimize import least_squares

        rough, kept = math.sqrt(weight) * self.penalty, dict[bytes, Array]()

        def residuals(at: Array) -> Array:
            kept.clear()
            kept[at.tobytes()] = values = self.residuals(at[None])[0]
            return np.append(values, rough @ at)

        def jacobian(at: Array) -> Array:
            return np.vstack([self.jacobian(at, kept.get(at.tobytes())), rough])

        if not np.all(np.isfinite(residuals(theta))):
            raise InputError("data", rule="are too far from those of a material with a smooth spectrum")
        slopes: Any = jacobian
        return least_squares(residuals, theta, slopes, method="trf", ftol=1e-3, xtol=1e-3, gtol=1e-6, max_nfev=10).x

    def _score(self, theta: Array, weight: float) -> float:
        """Return the generalised cross-validation of the problem linearised at its minimum."""
        residuals = self.residuals(theta[None])[0]
        influence = _influence(self.jacobian(theta, residuals), self.penalty, weight)[1]
        return float(residuals @ residuals) / (residuals.size - influence) ** 2


def _influence(jacobian: Array, penalty: Array, weight: float) -> tuple[Array, float]:
    """Return the covariance of the parameters at unit noise, and the trace of the influence matrix."""
    gram = jacobian.T @ jacobian
    inverse: Any = np.linalg.pinv(gram + weight * penalty.T @ penalty, rcond=1e-14, hermitian=True)
    return inverse, float(np.trace(inverse @ gram))
