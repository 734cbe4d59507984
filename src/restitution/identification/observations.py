"""Observations: measured values, their noise, and the residuals of a material."""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from collections.abc import Mapping, Sequence
from dataclasses import replace
from functools import lru_cache
from typing import Any, Literal, NamedTuple

import numpy as np
from numpy.typing import NDArray

from restitution import checks
from restitution.checks import Array
from restitution.contact.geometry import Geometry
from restitution.contact.profiles import Parabola
from restitution.errors import ABSENT, InputError, InputTypeError
from restitution.limits import DENSITY_LIMITS
from restitution.material.conversion import series_connection, tension_from_shear
from restitution.material.fit import DynamicTable, RelaxationTable
from restitution.material.prony import PronySeries
from restitution.material.viscoelastic import Material, reduced_modulus, single_material
from restitution.quantities import check, check_single

# Lightest solid ball [kg/m^3]; rubbers and polymers have 850 and more.
_LIGHTEST = 500.0


class Noise:
    """Standard deviations of measured quantities.

    Parameters
    ----------
    **deviations
        By the name of the quantity: a number or an array in SI (absolute), a text such as "1.5 %" (relative), or a
        tuple of both, which are added in quadrature. Other quantities have noise of unknown size.

    Examples
    --------
    >>> noise = Noise(restitution_coefficient=0.003, contact_time="2 %")
    >>> noise.of("contact_time", np.array([1e-3, 2e-3]))
    array([2.e-05, 4.e-05])
    """

    def __init__(self, **deviations: Any) -> None:
        self.deviations: Mapping[str, Any] = dict(deviations)

    @staticmethod
    def from_argument(noise: Any) -> Noise:
        """Return a noise, or none at all for None; other types are refused."""
        return Noise() if noise is None else checks.instance("noise", noise, Noise, "must be a Noise")

    def of(self, name: str, values: Array, scale: Array | float | None = None) -> Array | None:
        """Return standard deviations of values in SI, shape (n,); None if unknown.

        A relative one refers to each value, or to `scale` if it is given.
        """
        if name not in self.deviations:
            return None
        deviation = self.deviations[name]
        parts = deviation if isinstance(deviation, tuple) else (deviation,)
        square = np.zeros(np.shape(values))
        for part in parts:
            size = self._part(name, part, np.abs(values) if scale is None else np.asarray(scale))
            if np.shape(size) not in ((), np.shape(values)):
                raise InputError(f"noise.{name}", rule=f"must be one number, or {np.size(values)} numbers")
            square += size**2
        return np.sqrt(square)

    def _part(self, name: str, part: Any, size: Array) -> Any:
        if not isinstance(part, str):
            return checks.positive(f"noise.{name}", part)
        text = part.strip()
        try:
            share = float(text.removesuffix("%")) / 100.0
        except ValueError:
            share = math.nan
        if not text.endswith("%") or not 0.0 < share < math.inf:
            raise InputError(f"noise.{name}", part, 'must be a number in SI, or a share such as "1.5 %"')
        return share * size

    def __repr__(self) -> str:
        return f"Noise({', '.join(f'{name}={value!r}' for name, value in self.deviations.items())})"


def noise_of(noise: Any, measured: Sequence[str], further: Sequence[str] = ()) -> Noise:
    """Return a noise, which is that of all measured quantities or of none, and perhaps of further ones."""
    noise = Noise.from_argument(noise)
    for name in noise.deviations:
        if name not in (*measured, *further):
            raise InputError(f"noise.{name}", rule=f"was not measured; measured are {', '.join(measured)}")
    missing = [name for name in measured if name not in noise.deviations]
    if 0 < len(missing) < len(measured):
        raise InputError(f"noise.{missing[0]}", rule="must be given, as that of another quantity is")
    return noise


class Nuisance(NamedTuple):
    """Unknown of a measurement that is not a property of the material, but is estimated with it."""

    name: str  # such as "contact_point"
    unit: str  # SI
    start: float
    low: float
    high: float
    step: float  # a change that moves the data by about their noise


class Curve(NamedTuple):
    """Measured and fitted values of one observation, for pictures and reports."""

    name: str  # of the quantity, in `restitution.quantities`
    x_name: str
    x: Array
    measured: Array
    fitted: Array
    deviation: Array | None  # standard deviation, None where unknown
    bodies: tuple[
        tuple[str, Array], ...
    ] = ()  # quantities that distinguish the bodies of the values, if there are several


def doubtful_balls(mass: Any, profile: Any) -> list[str]:
    """Return doubt about balls whose mass does not go with their radius, or is too light for a solid one, in words."""
    if mass is None or not isinstance(profile, Parabola):
        return []
    with np.errstate(all="ignore"):  # a radius may be so small that its cube is zero
        density = mass / (4.0 / 3.0 * math.pi * np.asarray(profile.radius) ** 3)
    low, high = DENSITY_LIMITS
    worst = float(np.min(density))
    worst = worst if worst < low else float(np.max(density))
    if not low <= worst <= high:
        rule = "compare the units of mass (kg) and radius (m), unless a heavy body with a small tip is meant"
        return [f"a ball of this mass and radius has {worst:.3g} kg/m^3, outside {low:g} to {high:g} kg/m^3: {rule}"]
    if np.min(density) >= _LIGHTEST:
        return []
    hollow = "a hollow one that deforms is no half-space"
    return [f"a ball of this mass and radius has {np.min(density):.0f} kg/m^3: {hollow}"]


def modulus(materials: Material, temperature: Any = None, deformation: str | None = None) -> PronySeries:
    """Return moduli of materials in shear or in tension, by default the reduced ones, perhaps at temperatures [K]."""
    if deformation == "shear":
        series = materials.shear
    elif deformation == "tension":
        series = tension_from_shear(materials.shear, bulk_modulus=materials.bulk)
    else:
        series = reduced_modulus(materials)
    # A shift multiplies all times, and so also those of moduli that were converted before.
    if temperature is None:
        return series
    factor = materials.shift_factor(temperature)
    series = series.broadcast_to(np.broadcast_shapes(series.shape, np.shape(factor)))
    # A trial shift may be NaN, and its times are not checked: such rows have no result.
    with np.errstate(invalid="ignore", over="ignore"):
        times, viscosity = series.relaxation_times * np.asarray(factor)[..., None], series.parallel_viscosity * factor
    return PronySeries.from_checked(series.equilibrium_modulus, series.branch_moduli, times, viscosity)


def counter_of(material: Any) -> Material | Literal["same"] | None:
    """Return the material of the other body; refuse what is none."""
    if material is None or (isinstance(material, str) and material == "same"):
        return material
    if not isinstance(material, Material):
        raise InputTypeError("counter_material", material, 'must be a Material or "same"')
    single_material("counter_material", material)
    return material


# Each trial of a fit needs it.
@lru_cache(maxsize=8)
def _reduced(material: Material) -> PronySeries:
    return reduced_modulus(material)


def contact_modulus(reduced: PronySeries, counter: Material | str | None) -> PronySeries:
    """Return the reduced moduli of contacts with another body, from those with a rigid one."""
    if counter is None:
        return reduced
    return series_connection(reduced, _reduced(counter)) if isinstance(counter, Material) else reduced.scaled(0.5)


def alone_of(pair: NDArray[np.complex128], omega: Array, counter: Material | str | None) -> NDArray[np.complex128]:
    """Return the reduced complex moduli [Pa] of a body from those of its contact with another body."""
    if counter is None:
        return pair
    if not isinstance(counter, Material):
        return 2.0 * pair
    alone = 1.0 / pair - 1.0 / np.asarray(_reduced(counter).complex_modulus(omega))
    # By noise, the contact may be as stiff as the other body alone.
    alone = np.where(alone.real > 0.1 * (1.0 / pair).real, alone, 0.1 / pair)
    return np.asarray(1.0 / alone, dtype=np.complex128)


def mean_table(
    angular_frequency: Array, storage: Array, loss: Array, poisson_ratio: float | None, source: str,
    notes: tuple[str, ...] = (),
) -> DynamicTable | None:  # fmt: skip
    """Return reduced moduli, or those in shear, as a table in ascending frequency; None if all are NaN.

    Moduli of the same frequency are averaged.
    """
    there = np.isfinite(storage)
    if not np.any(there):
        return None
    factor = 1.0
    if poisson_ratio is not None:
        factor = 0.5 * (1.0 - check_single("poisson_ratio", poisson_ratio))
    # Frequencies that differ by rounding are the same.
    omega, place = np.unique(np.exp(np.round(np.log(angular_frequency[there]), 9)), return_inverse=True)
    count = np.bincount(place)
    first, second = (factor * np.bincount(place, part[there]) / count for part in (storage, loss))
    return DynamicTable(omega, first, second, None if poisson_ratio is None else "shear", source, notes)


def number_or_none(name: str, value: Any) -> float | None:
    """Return an input as a single number in SI, or None if there is none."""
    return None if value is None else check_single(name, value)


def profile_of(radius: Any, profile: Any) -> Geometry:
    """Return the profile of bodies: parabolas of these radii [m], or `profile`."""
    if (radius is None) == (profile is None):
        raise InputError("radius, profile", rule="exactly one must be given")
    if profile is None:
        return Parabola(check("radius", radius))
    if not isinstance(profile, Geometry) or profile.needs_poisson_ratio:
        raise InputTypeError("profile", profile, "must be a Geometry that needs no Poisson ratio, no bonded layer")
    if np.ndim(profile.stiffness_radius(0.0) if profile.path_exponent is None else profile.path_exponent):
        raise InputError("profile", rule="must be a single profile; give several as several sets of data")
    return profile


def columns_over_time(columns: Mapping[str, tuple[Any, str]]) -> list[Array]:
    """Return finite columns, given with their units, of one shape (n,); the first of them must ascend."""
    arrays = [np.atleast_1d(checks.finite(name, values, unit)) for name, (values, unit) in columns.items()]
    time, (name, (_, unit)) = arrays[0], next(iter(columns.items()))
    if time.ndim != 1 or any(values.shape != time.shape for values in arrays):
        shapes = " and ".join(str(values.shape) for values in arrays)
        raise InputError(", ".join(columns), rule=f"must be columns of equal length, not of shapes {shapes}")
    falls = np.flatnonzero(np.diff(time) <= 0.0)
    if falls.size:
        place = int(falls[0]) + 1
        raise InputError(name, float(time[place]), "must be ascending", unit, index=(place,))
    return arrays


def nuisances_of(data: Sequence[Observations], coordinates: Array) -> list[Array]:
    """Return the nuisances of each set of data, shape (m, n_nuisance), from all of them over their steps."""
    parts, first = list[Array](), 0
    for record in data:
        steps = np.array([nuisance.step for nuisance in record.nuisances])
        parts.append(coordinates[:, first : first + steps.size] * steps)
        first += steps.size
    return parts


class Observations(ABC):
    """Measured data of one kind, in the form that `identify` needs.

    A subclass checks its data once, in its constructor, and converts them to SI. All methods take many materials at
    once, an array of shape (m, 1), and an array of shape (m, n_nuisance) of the nuisances in their order.
    Unknowns that enter linearly (gain, baseline, slope) do not count as nuisances: the subclass projects them out.
    """

    label: str = ""
    """Name of the data in messages, such as the name of a file."""

    nuisances: tuple[Nuisance, ...] = ()
    """Unknowns of the measurement that enter nonlinearly."""

    scaled: bool = False
    """Whether the size of the noise is unknown: `residuals` are then known except for one common factor."""

    series: object = None
    """Measurement to which several sets belong: an unknown size of the noise is the same for all of them."""

    adhesion: bool = False
    """Whether the surfaces adhere, so that the fit has the work and the stress of adhesion."""
    jumps: bool = False
    """Whether a record over time shows jumps of adhesion, whose places make many minima of a fit."""

    fixes_time: bool = True
    """Whether the data contain a time, a force or a modulus; the restitution coefficient alone does not."""

    @property
    @abstractmethod
    def size(self) -> int:
        """Number of residuals n."""

    @abstractmethod
    def residuals(self, materials: Material, nuisances: Array) -> Array:
        """Return whitened residuals (fit - data) over deviations, shape (m, n); NaN where a row fails."""

    @abstractmethod
    def curves(self, materials: Material, nuisances: Array) -> list[Curve]:
        """Return measured and fitted values for the first row."""

    @abstractmethod
    def window(self) -> tuple[float, float]:
        """Return the lowest and highest angular frequency [rad/s] of the data."""

    def contact_times(self, materials: Material) -> Array | None:
        """Return contact times [s] on each material, shape (m, n), NaN without separation; None for other data."""
        return None

    def effective_moduli(self) -> DynamicTable | None:
        """Return approximate storage and loss part of E* from the data, for a start; None if unknown."""
        return None

    def moduli_by_temperature(self) -> list[DynamicTable]:
        """Return the effective moduli, a table for each temperature."""
        table = self.effective_moduli()
        return [] if table is None else [replace(table, temperature=getattr(self, "temperature", table.temperature))]

    def refined(self, materials: Material, nuisances: Array) -> Observations:
        """Return the data with deviations and elements for residuals near the fit of the first row."""
        return self

    def assumed_contact(self, modulus: float) -> tuple[float, float] | None:
        """Return a work of adhesion [J/m^2] and a radius [m] of the surface for a start; None without adhesion.

        The magnitude of E* [Pa] is assumed.
        """
        return None

    def assumed_moduli(self, modulus: float) -> DynamicTable | None:
        """Return the same from a loss tangent alone, at an assumed magnitude [Pa]; None without a loss tangent."""
        return None

    def linear_estimates(self, materials: Material, nuisances: Array) -> dict[str, tuple[float, str]]:
        """Return unknowns that were projected out, for the first row: value and SI unit by name."""
        return {}

    def doubts(self, materials: Material, nuisances: Array) -> list[str]:
        """Return doubts about the fit of the first row, in words."""
        return []


class ForceRecord(Observations):
    """Force over time beside a baseline, a sum of columns whose factors are projected out of the residuals."""

    time: Array

    def __repr__(self) -> str:
        return f"{type(self).__name__}({self.time.size} samples)"

    @abstractmethod
    def forces(self, materials: Material, nuisances: Array) -> Array:
        """Return forces [N] at the times of the record, without gain and baseline, shape (m, n)."""

    @property
    def size(self) -> int:
        """Number of samples."""
        return self.time.size

    def _set_record(
        self, time: Array, force: Array, deviations: Array, gain: float | None = 1.0, ar1: float = 0.0,
        **baseline: tuple[Array, str],
    ) -> None:  # fmt: skip
        """Set measured forces [N], their deviations, and the columns of the baseline with the units of their factors.

        The gain is the measured over the true force, None if it is unknown; `ar1` is the correlation of the noise of
        successive samples.
        """
        self.time, self.force, self.deviations, self.gain, self.ar1 = time, force, deviations, gain, ar1
        self._units = {name: unit for name, (_, unit) in baseline.items()}
        self._columns = np.stack([column for column, _ in baseline.values()])
        self.basis, self._triangle = np.linalg.qr(self._whitened(self._columns).T)
        self._data = self._projected(force)

    def _whitened(self, values: Array) -> Array:
        scaled = values / self.deviations
        if not self.ar1:
            return scaled
        rest = (scaled[..., 1:] - self.ar1 * scaled[..., :-1]) / math.sqrt(1.0 - self.ar1**2)
        return np.concatenate([scaled[..., :1], rest], axis=-1)

    def _projected(self, forces: Array) -> Array:
        """Return whitened forces without the part that a baseline explains."""
        values = self._whitened(forces)
        return values - (values @ self.basis) @ self.basis.T

    def _gains(self, projected: Array) -> Any:
        """Return the gains of rows, shape (m, 1), by least squares if they are unknown."""
        if self.gain is not None:
            return self.gain
        return (projected @ self._data / (projected * projected).sum(axis=1))[:, None]

    def residuals(self, materials: Material, nuisances: Array) -> Array:
        """Return residuals of the samples, whitened; NaN where a row has no result."""
        return self._compared(self.forces(materials, nuisances))

    def _compared(self, forces: Array) -> Array:
        projected = self._projected(forces)
        return self._gains(projected) * projected - self._data

    def _linear(self, materials: Material, nuisances: Array) -> tuple[Array, Array, float]:
        """Return the fitted force, the factors of the baseline, and the gain of the first row."""
        forces = self.forces(materials, nuisances)[:1]
        gain = float(np.squeeze(self._gains(self._projected(forces))))
        left = self._whitened(self.force - gain * forces[0]) @ self.basis
        factors: Any = np.linalg.solve(self._triangle, left)
        return gain * forces[0] + factors @ self._columns, factors, gain

    def curves(self, materials: Material, nuisances: Array) -> list[Curve]:
        """Return measured and fitted force over time."""
        fitted = self._linear(materials, nuisances)[0]
        return [Curve("force", "time", self.time, self.force, fitted, None if self.scaled else self.deviations)]

    def linear_estimates(self, materials: Material, nuisances: Array) -> dict[str, tuple[float, str]]:
        """Return the factors of the baseline, and the gain if it is unknown."""
        _, factors, gain = self._linear(materials, nuisances)
        estimates = {
            name: (float(factor), unit) for factor, (name, unit) in zip(factors, self._units.items(), strict=True)
        }
        return estimates if self.gain is not None else estimates | {"gain": (gain, "")}


# Relaxation and dynamic tables as observations of a material.


class Moduli(Observations):
    """Measured relaxation or dynamic moduli of the material.

    Parameters
    ----------
    table : RelaxationTable or DynamicTable
        Measured moduli.
    deformation : {"shear", "tension"}, optional
        Needed if the table does not state it.
    temperature : float, optional
        Temperature [K] of the measurement, for a model with a shift.
    noise : Noise, optional
        Relative standard deviations, as texts such as "2 %": of `modulus`, or of `storage_modulus` and
        `loss_modulus`, the latter relative to the magnitude of E*. Without it the size of the noise is estimated.

    Examples
    --------
    >>> table = RelaxationTable(np.array([0.1, 1.0]), np.array([3e6, 2e6]), "shear")
    >>> Moduli(table, noise=Noise(modulus="1 %")).size
    2
    """

    def __init__(
        self,
        table: RelaxationTable | DynamicTable,
        *,
        deformation: Literal["shear", "tension"] | None = None,
        temperature: float | None = None,
        noise: Noise | None = None,
    ) -> None:
        if not isinstance(table, RelaxationTable | DynamicTable):
            raise InputTypeError(
                "table", table, "must be a RelaxationTable or a DynamicTable, as read_material returns"
            )
        self.table, self.temperature, self.label = table, temperature, table.source
        kind = deformation or table.deformation
        if kind not in ("shear", "tension"):
            rule = 'must be "shear" or "tension", as the data do not state it'
            raise InputError("deformation", ABSENT if kind is None else kind, rule, where=table.source)
        self.deformation: Literal["shear", "tension"] = kind
        names = ("storage_modulus", "loss_modulus") if isinstance(table, DynamicTable) else ("modulus",)
        if isinstance(table, RelaxationTable):
            # At time 0 the modulus of a dashpot is infinite.
            inside = table.time > 0.0
            self._at, values = table.time[inside], [table.modulus[inside]]
            sizes = values
        else:
            inside = table.angular_frequency > 0.0
            self._at = table.angular_frequency[inside]
            values = [table.storage_modulus[inside], table.loss_modulus[inside]]
            sizes = [np.hypot(*values)] * 2
        self._values, self._names = np.concatenate(values), names
        noise = noise_of(noise, names)
        self.scaled = not noise.deviations
        noise = Noise(**dict.fromkeys(names, "1 %")) if self.scaled else noise
        self._deviations = np.concatenate([noise.of(*row) for row in zip(names, values, sizes, strict=True)])  # pyright: ignore

    @property
    def size(self) -> int:
        """Number of measured values."""
        return self._values.size

    def _predicted(self, materials: Material) -> Array:
        series = modulus(materials, self.temperature, self.deformation)
        if isinstance(self.table, RelaxationTable):
            return series.relaxation_modulus(self._at)
        moduli = series.complex_modulus(self._at)
        return np.hstack([moduli.real, moduli.imag])

    def residuals(self, materials: Material, nuisances: Array) -> Array:
        """Return residuals of the moduli; of the storage moduli, then of the loss moduli."""
        return (self._predicted(materials) - self._values) / self._deviations

    def curves(self, materials: Material, nuisances: Array) -> list[Curve]:
        """Return moduli over time or angular frequency."""
        x_name = "time" if isinstance(self.table, RelaxationTable) else "angular_frequency"
        fitted, n = self._predicted(materials)[0], self._at.size
        parts = (slice(k * n, (k + 1) * n) for k in range(len(self._names)))
        return [
            Curve(name, x_name, self._at, self._values[part], fitted[part],
                  None if self.scaled else self._deviations[part])
            for name, part in zip(self._names, parts, strict=True)
        ]  # fmt: skip

    def window(self) -> tuple[float, float]:
        """Return the lowest and highest angular frequency, or the reciprocals of the times [rad/s]."""
        ends = float(self._at.min()), float(self._at.max())
        return ends if isinstance(self.table, DynamicTable) else (1.0 / ends[1], 1.0 / ends[0])

    def effective_moduli(self) -> DynamicTable:
        """Return the moduli themselves; from a relaxation with delta = -(pi/2) dln G/dln t at omega = 1/t."""
        n = self._at.size
        if isinstance(self.table, DynamicTable):
            return DynamicTable(self._at, self._values[:n], self._values[n:], self.deformation, self.label)
        slope = np.gradient(np.log(self._values), np.log(self._at)) if n > 1 else np.zeros(n)
        phase = np.clip(-0.5 * math.pi * slope, 1e-3, 1.5)
        size = self._values[::-1]
        return DynamicTable(
            1.0 / self._at[::-1], size * np.cos(phase[::-1]), size * np.sin(phase[::-1]), self.deformation, self.label
        )

    def __repr__(self) -> str:
        return f"Moduli({type(self.table).__name__} of {self._at.size} in {self.deformation})"


def as_observations(data: object, place: int) -> Observations:
    """Return one set of data; a table of moduli becomes `Moduli`."""
    if isinstance(data, Observations):
        return data
    if isinstance(data, RelaxationTable | DynamicTable):
        return Moduli(data)
    raise InputTypeError("data", data, "must be Rebounds, a table of moduli, or another kind of data", index=(place,))
