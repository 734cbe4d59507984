"""Effective moduli of single bounces: each bounce is one point of a DMA table of the reduced modulus."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, ClassVar, NamedTuple

import numpy as np
from numpy.typing import NDArray

from restitution.checks import Array
from restitution.errors import InputError
from restitution.identification.observations import doubtful_balls, mean_table
from restitution.impact.closed_forms import HERTZ_TIME_FACTOR
from restitution.material.fit import DynamicTable
from restitution.quantities import INPUTS, MODULI, NUMBER, OUTPUTS, Quantity, dataset
from restitution.result import Result, Summary, Table, draw

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.figure import Figure

    from restitution.identification.impacts import Rebounds
    from restitution.material.viscoelastic import Material

# Fits to exact impacts of random materials. Polynomials of L = -ln e without a constant, lowest power first.
_FREQUENCY = 1.13 * math.pi
LOSS = 0.815
_STORAGE_FREQUENCY = 1.3 * math.pi
_BY_TIME = (-0.213, -0.061)
_BY_FORCE = (1.038, -0.484)
_TIME_BY_FORCE = (-0.53, 0.175)
# Bounces for which the formulas were compared with the exact solver.
_LOWEST, _HIGHEST = 0.15, 0.995


class FormulaError(NamedTuple):
    """Relative errors of the formulas of one bounce: those of 95 % of the random materials of a family are smaller."""

    loss_tangent: float
    storage_by_time: float  # storage modulus from the contact time
    storage_by_force: float  # storage modulus from the peak force


FORMULA_ERRORS = {
    "broad spectrum": FormulaError(0.025, 0.005, 0.01),
    "power law": FormulaError(0.03, 0.005, 0.01),
    "fractional Zener": FormulaError(0.20, 0.03, 0.04),
    "two relaxation times": FormulaError(0.30, 0.09, 0.12),
    "single relaxation time": FormulaError(0.30, 0.09, 0.12),
}
"""Errors of the formulas by family of material; `validation/effective_moduli.py` measures them."""


@dataclass(frozen=True, eq=False, repr=False)
class PointModuli(Result):
    """Complex reduced moduli, one from each bounce or oscillation; arrays of shape (n,)."""

    points: ClassVar[str]

    angular_frequency: Array  # [rad/s]
    storage_modulus: Array  # E*' [Pa]
    loss_modulus: Array  # E*'' [Pa]
    loss_tangent: Array  # tan delta [-]
    storage_modulus_error: Array
    loss_modulus_error: Array
    loss_tangent_error: Array
    statements: tuple[str, ...]  # errors of the method, and missing measurements, in words

    def dynamic_table(self, poisson_ratio: float | None = None) -> DynamicTable | None:
        """Return a table for `rs.fit_prony`, in ascending frequency; points of the same frequency are averaged.

        Parameters
        ----------
        poisson_ratio : float, optional
            Constant Poisson ratio nu in [-1, 0.5]. The moduli are then those in shear, G = E* (1 - nu)/2, and
            otherwise the reduced ones, E*.

        Returns
        -------
        DynamicTable or None
            None if no point has a frequency and a modulus.
        """
        moduli = self.storage_modulus, np.maximum(self.loss_modulus, 0.0)
        source = f"effective moduli of {self.points}"
        return mean_table(self.angular_frequency, *moduli, poisson_ratio, source, self.statements)

    def plot(self, data: DynamicTable | Material | None = None, *, poisson_ratio: float = 0.5) -> Figure:
        """Return a figure of the moduli over frequency, with a measured DMA table or the curve of a material.

        A table in shear or tension is converted to the reduced modulus with a constant Poisson ratio.
        """
        return draw("material.bounce_moduli", self, data, poisson_ratio)

    @property
    def _short(self) -> str:
        return f"{self.storage_modulus.size} {self.points}"


@dataclass(frozen=True, eq=False, repr=False)
class EffectiveModuli(PointModuli):
    """Complex reduced modulus from each bounce; arrays of shape (n,), one entry for each bounce.

    The angular frequency is 1.13 pi over the contact time. Values are NaN if neither time nor force was measured; the
    loss tangent is known for all bounces. The errors are standard errors from the noise of the
    measurement alone, NaN if the noise is unknown.
    """

    _numbers = (
        "angular_frequency", "storage_modulus", "loss_modulus", "loss_tangent", "storage_modulus_error",
        "loss_modulus_error", "loss_tangent_error", "velocity", "restitution_coefficient", "statements",
    )  # fmt: skip

    points: ClassVar[str] = "bounces"

    velocity: Array  # of the impacts [m/s]
    restitution_coefficient: Array

    def to_dataset(self) -> xr.Dataset:
        """Table of the bounces over the dimension `bounce`, with units, without columns that have no number."""
        bounce = Quantity("bounce", NUMBER, "number of the bounce")
        columns: dict[str, tuple[Any, Quantity]] = {"bounce": (np.arange(self.velocity.size), bounce)}
        for name in ("velocity", "restitution_coefficient", *_TABLE):
            columns[name] = getattr(self, name), _QUANTITIES[name]
            if name in _MODULI:
                words = f"standard error of the {_QUANTITIES[name].words}"
                columns[f"{name}_error"] = getattr(self, f"{name}_error"), _QUANTITIES[name]._replace(words=words)
        kept = {name: column for name, column in columns.items() if not np.all(np.isnan(column[0]))}
        return dataset("bounce", kept, {"statements": "\n".join(self.statements)})

    def summary(self, title: str = "") -> Summary:
        """Return a table of the bounces, which `print` and notebooks show."""
        columns = {name: getattr(self, name) for name in ("velocity", "restitution_coefficient", *_TABLE)}
        columns = {name: values for name, values in columns.items() if not np.all(np.isnan(values))}
        heads = tuple(f"{_QUANTITIES[name].words} [{_QUANTITIES[name].unit or '-'}]" for name in columns)
        rows = [tuple(f"{value:.5g}" for value in row) for row in zip(*columns.values(), strict=True)]
        return Summary(title or "Moduli of single bounces", Table(heads, rows), self.statements)


_MODULI = ("storage_modulus", "loss_modulus", "loss_tangent")
_TABLE = ("angular_frequency", *_MODULI)
_QUANTITIES = {**INPUTS, **OUTPUTS, **MODULI}


def moduli_of_rebounds(rebounds: Rebounds) -> EffectiveModuli:
    """Return the moduli of bounces by the formulas of `effective_moduli`, which has their sources."""
    if rebounds.counter_material is not None:
        rule = "must be rigid: the formulas give the modulus of the contact of both bodies; use identify"
        raise InputError("counter_material", rule=rule)
    if rebounds.adhesion:
        rule = "must be left out: the formulas take all losses for those of the material; use identify"
        raise InputError("adhesion", rule=rule)
    if rebounds.profile.path_exponent != 1.0:
        raise InputError("profile", rule="must be a parabola: the formulas of one bounce are valid only for it")
    v, mass, radius = rebounds.velocity, rebounds.mass, np.asarray(rebounds.profile.path_coefficient) ** 2
    e = rebounds.measured["restitution_coefficient"]
    unknown = np.full(e.shape, np.nan)
    duration, force = (rebounds.measured.get(name, unknown) for name in ("contact_time", "max_force"))
    e_error, time_error, force_error = (
        _relative_error(rebounds, name, values)
        for name, values in (("restitution_coefficient", e), ("contact_time", duration), ("max_force", force))
    )
    v_error = np.nan_to_num(_relative_error(rebounds, "velocity", v))
    loss = -np.log(e)
    with np.errstate(all="ignore"):  # numbers too large or too small for the formulas are refused below
        by_force, timed = np.isnan(duration), ~np.isnan(duration) | ~np.isnan(force)
        depth = np.where(by_force, 1.25 * mass * v * v / force, v * duration / HERTZ_TIME_FACTOR)
        hertz = 0.9375 * mass * v * v / np.sqrt(radius) * depth**-2.5
        duration = np.where(by_force, HERTZ_TIME_FACTOR * depth / v * np.exp(_poly(_TIME_BY_FORCE, loss)), duration)
        omega, by_time, tangent = moduli_of_bounces(loss, hertz, duration)
        storage = np.where(by_force, hertz * np.exp(_poly(_BY_FORCE, loss)), by_time)
        # Derivatives of the logarithm of the storage modulus with respect to those of e, v, and the time or the force.
        shift = 2.0 / math.pi * LOSS / (1.0 + tangent**2) * math.log(_FREQUENCY / _STORAGE_FREQUENCY)
        by_e = -np.where(by_force, _slope(_BY_FORCE, loss), _slope(_BY_TIME, loss) + shift)
        by_v = np.where(by_force, -3.0, -0.5)
        other = np.where(by_force, force_error, time_error)
        storage_error = np.sqrt((by_e * e_error) ** 2 + (by_v * v_error) ** 2 + (2.5 * other) ** 2)
        tangent_error = LOSS * e_error
        # Both factors of the loss modulus vary with e.
        without_e = storage_error**2 - (by_e * e_error) ** 2
        loss_error = np.sqrt(((LOSS - tangent * by_e) * e_error) ** 2 + tangent**2 * without_e)
    beyond = timed & ~((storage > 0.0) & (storage < math.inf))
    if beyond.any():
        n = int(np.argmax(beyond))
        rule = "must be finite and > 0: compare the units of mass, radius, velocity, contact time and force"
        raise InputError("storage_modulus", float(storage[n]), rule, "Pa", index=(n,))
    return EffectiveModuli(
        omega, storage, storage * tangent, tangent, storage * storage_error, storage * loss_error,
        tangent_error,
        (*_statements(loss, storage, by_force & np.isfinite(force)), *doubtful_balls(mass, rebounds.profile)), v, e,
    )  # fmt: skip


def moduli_of_bounces(loss: Array, elastic: Array, contact_time: Array) -> tuple[Array, Array, Array]:
    """Return angular frequency [rad/s], storage modulus [Pa] and loss tangent of bounces with the losses L = -ln e.

    `elastic` is the modulus [Pa] of an elastic body of the same contact time [s].
    """
    tangent = LOSS * loss
    # The storage modulus is known at 1.3 pi/T and moves by its local slope.
    slope = 2.0 / math.pi * np.arctan(tangent)
    moved = _poly(_BY_TIME, loss) + slope * math.log(_FREQUENCY / _STORAGE_FREQUENCY)
    return _FREQUENCY / contact_time, elastic * np.exp(moved), tangent


def _poly(coefficients: tuple[float, float], x: Array) -> Array:
    return coefficients[0] * x + coefficients[1] * x * x


def _slope(coefficients: tuple[float, float], x: Array) -> Array:
    return coefficients[0] + 2.0 * coefficients[1] * x


def _relative_error(rebounds: Rebounds, name: str, values: Array) -> Array:
    deviations = rebounds.noise.of(name, values)
    return np.full(values.shape, np.nan) if deviations is None else deviations / values


def _statements(loss: Array, storage: Array, by_force: NDArray[np.bool_]) -> tuple[str, ...]:
    """Return errors of the formulas, and missing measurements, in words."""
    lines: list[str] = []
    count, missing = loss.size, int(np.isnan(storage).sum())
    if missing:
        bounces = "All bounces" if missing == count else f"{missing} of {count} bounces"
        lines.append(
            f"{bounces} give only the loss tangent, at 1.13 pi over a contact time that was not measured. The "
            "coefficient of restitution determines no modulus and no time: give one contact time, force or modulus."
        )
    smooth, single = FORMULA_ERRORS["broad spectrum"], FORMULA_ERRORS["single relaxation time"]
    pairs = [("the loss tangent", smooth.loss_tangent, single.loss_tangent)]
    if missing < count:
        which = "storage_by_force" if np.any(by_force) else "storage_by_time"
        pairs.append(("the storage modulus", getattr(smooth, which), getattr(single, which)))
    listed = ", ".join(f"of {what} {100 * least:.2g} % and {100 * most:.2g} %" for what, least, most in pairs)
    lines.append(f"Errors of the formulas for a broad spectrum and for a single relaxation time: {listed}.")
    outside = int(((loss > -math.log(_LOWEST)) | (loss < -math.log(_HIGHEST))).sum())
    if outside:
        lines.append(
            f"{outside} of {count} bounces are outside {_LOWEST:g} <= e <= {_HIGHEST:g}, where the errors hold."
        )
    return tuple(lines)
