"""Time-temperature shift: the ratio of the relaxation times at two temperatures."""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from dataclasses import dataclass, field
from typing import Any, ClassVar, Protocol, Self, runtime_checkable

import numpy as np
from numpy.typing import ArrayLike

from restitution.checks import Array, Numeric, pair, refuse, single_positive, within
from restitution.errors import InputError
from restitution.quantities import check, check_single

GAS_CONSTANT = 8.31446261815324
"""Molar gas constant R [J/(mol K)], exact in the SI of 2019."""

# Decades of the shift factor that a double can hold, with some to spare for the times.
_DECADES = 300.0


@runtime_checkable
class Shift(Protocol):
    """Law of the shift factor a_T: relaxation times at T are a_T times those at the reference."""

    @property
    def reference_temperature(self) -> float:
        """Temperature [K] at which a_T = 1."""
        ...

    def factor(self, temperature: ArrayLike) -> Any:
        """Return the shift factor a_T [-] at the temperatures T [K]."""
        ...


@dataclass(frozen=True)
class _Law(ABC):
    """Formula for the shift factor, with a reference temperature and a range of temperatures."""

    _units: ClassVar[dict[str, str]]

    reference_temperature: float
    temperature_range: tuple[float, float] | None = field(default=None, kw_only=True)

    def __post_init__(self) -> None:
        for name, unit in self._units.items():
            object.__setattr__(self, name, single_positive(name, getattr(self, name), unit))
        if self.temperature_range is None:
            return
        ends = pair("temperature_range", self.temperature_range, "must be two temperatures [K]")
        low, high = (check_single("temperature", limit, "temperature_range") for limit in ends)
        if not low <= self.reference_temperature <= high or low == high:
            rule = f"must ascend and hold {self.reference_temperature:g} K, the reference_temperature"
            raise InputError("temperature_range", f"({low:g}, {high:g})", rule, "K")
        object.__setattr__(self, "temperature_range", (low, high))

    @classmethod
    def from_checked(cls, **constants: Any) -> Self:
        """Return a law of admissible constants, which are not checked and may be arrays."""
        law = object.__new__(cls)
        vars(law).update(temperature_range=None, **constants)
        return law

    def factor_or_nan(self, temperature: Numeric) -> Any:
        """Return the shift factor a_T [-] at the temperatures T [K], NaN where it leaves the range of numbers."""
        low, high = self._ends
        with np.errstate(all="ignore"):
            factor = np.power(10.0, self._decades(temperature))
        return np.where((temperature >= np.asarray(low)) & (temperature <= np.asarray(high)), factor, np.nan)

    def factor(self, temperature: ArrayLike) -> Any:
        """Return the shift factor a_T [-] at the temperatures T [K]."""
        number = check("temperature", temperature)
        if self.temperature_range is not None:
            _within(number, *self.temperature_range, "the range of the law")
        _within(number, *self._ends, f"where the shift factor is between 1e-{_DECADES:g} and 1e{_DECADES:g}")
        return _power(self._decades(number))

    @property
    @abstractmethod
    def _ends(self) -> tuple[Numeric, Numeric]:
        """Temperatures where a_T is as large and as small as numbers allow."""

    @abstractmethod
    def _decades(self, temperature: Numeric) -> Numeric:
        """Return the logarithm log10 a_T."""


@dataclass(frozen=True)
class WLF(_Law):
    """Shift factor log10 a_T = -C1 (T - T0)/(C2 + T - T0) of Williams, Landel and Ferry.

    Parameters
    ----------
    reference_temperature
        T0 > 0 [K].
    c1, c2
        C1 > 0 [-] and C2 > 0 [K].
    temperature_range
        Lowest and highest admissible temperature [K]; without it, all above the Vogel temperature T0 - C2.

    Raises
    ------
    InputError
        If a number is out of range; from `factor` outside the range of temperatures.

    Notes
    -----
    J. Am. Chem. Soc. 77 (1955) 3701. Valid from the glass transition to about 100 K above it.

    Examples
    --------
    >>> law = WLF(298.0, 8.61, 200.4, temperature_range=(202.0, 400.0))
    >>> print(round(law.factor(308.0), 6))
    0.389744
    >>> law.factor(500.0)
    Traceback (most recent call last):
        ...
    restitution.errors.InputError: temperature = 500 K: must be in [202, 400] K, the range of the law
    """

    _units: ClassVar[dict[str, str]] = {"reference_temperature": "K", "c1": "", "c2": "K"}

    c1: float
    c2: float

    @property
    def _ends(self) -> tuple[Numeric, Numeric]:
        # Where log10 a_T is x: T = T0 - x C2/(C1 + x).
        low = self.reference_temperature - _DECADES * self.c2 / (self.c1 + _DECADES)
        with np.errstate(divide="ignore"):
            high = self.reference_temperature + _DECADES * self.c2 / np.maximum(self.c1 - _DECADES, 0.0)
        return low, high

    def _decades(self, temperature: Numeric) -> Numeric:
        rise = temperature - self.reference_temperature
        return -self.c1 * rise / (self.c2 + rise)


@dataclass(frozen=True)
class Arrhenius(_Law):
    """Shift factor ln a_T = (Q/R) (1/T - 1/T0) of a thermally activated process.

    Parameters
    ----------
    activation_energy
        Q > 0 [J/mol].
    reference_temperature, temperature_range
        As in `WLF`, also the errors; without a range, all temperatures are admissible.

    Notes
    -----
    Ferry, *Viscoelastic Properties of Polymers*, 3rd ed. (1980), ch. 11. Used below the glass transition.

    Examples
    --------
    >>> print(round(Arrhenius(300.0, 100e3).factor(310.0), 6))
    0.274377
    """

    _units: ClassVar[dict[str, str]] = {"reference_temperature": "K", "activation_energy": "J/mol"}

    activation_energy: float

    @property
    def _slope(self) -> float:
        return self.activation_energy / (GAS_CONSTANT * math.log(10.0))

    @property
    def _ends(self) -> tuple[Numeric, Numeric]:
        middle, reach = 1.0 / self.reference_temperature, _DECADES / self._slope
        with np.errstate(divide="ignore"):
            return 1.0 / (middle + reach), 1.0 / np.maximum(middle - reach, 0.0)

    def _decades(self, temperature: Numeric) -> Numeric:
        reference = self.reference_temperature
        return self._slope * (reference - temperature) / (temperature * reference)


@dataclass(frozen=True, init=False, eq=False)
class ShiftTable:
    """Shift factors measured at some temperatures; log10 a_T is linear between them.

    Parameters
    ----------
    temperatures
        Temperatures [K], strictly ascending, shape (n,), n >= 2.
    log10_factors
        log10 a_T [-], strictly descending, shape (n,); must pass through 0.
    notes
        Remarks of the reader: units that were assumed, columns that are not used.

    Raises
    ------
    InputError
        If the table is malformed; from `factor` outside the range measured.

    Examples
    --------
    >>> table = ShiftTable([290.0, 300.0, 310.0], [1.0, 0.0, -0.5])
    >>> print(table.reference_temperature, table.factor(290.0))
    300.0 10.0
    """

    temperatures: Array
    log10_factors: Array
    notes: tuple[str, ...] = field(default=(), repr=False)

    def __init__(self, temperatures: ArrayLike, log10_factors: ArrayLike, *, notes: tuple[str, ...] = ()) -> None:
        kelvin = np.atleast_1d(check("temperature", temperatures, "temperatures"))
        logs = np.atleast_1d(within("log10_factors", log10_factors, -_DECADES, _DECADES))
        if kelvin.ndim != 1 or kelvin.shape != logs.shape or kelvin.size < 2:
            names, shapes = "temperatures, log10_factors", f"shapes {kelvin.shape} and {logs.shape}"
            raise InputError(names, shapes, "must be one-dimensional, of equal length, at least 2")
        _ascending("temperatures", kelvin, 1.0, "must be strictly ascending", "K")
        _ascending("log10_factors", logs, -1.0, "must be strictly descending")
        if logs[0] < 0 or logs[-1] > 0:
            ends = f"{logs[0]:g} to {logs[-1]:g}"
            raise InputError("log10_factors", ends, "must pass through 0, at the reference")
        self.__dict__.update(temperatures=kelvin, log10_factors=logs, notes=notes)

    @property
    def reference_temperature(self) -> float:
        """Temperature [K] at which a_T = 1."""
        return float(np.interp(0.0, self.log10_factors[::-1], self.temperatures[::-1]))

    def factor(self, temperature: ArrayLike) -> Any:
        """Return the shift factor a_T [-] at the temperatures T [K] within the table."""
        number = check("temperature", temperature)
        _within(number, float(self.temperatures[0]), float(self.temperatures[-1]), "the range of the table")
        return _power(np.interp(number, self.temperatures, self.log10_factors))

    def __eq__(self, other: object) -> bool:
        if not isinstance(other, ShiftTable):
            return NotImplemented
        pairs = (self.temperatures, other.temperatures), (self.log10_factors, other.log10_factors)
        return all(np.array_equal(*pair) for pair in pairs)

    def __hash__(self) -> int:
        return hash((*self.temperatures.tolist(), *self.log10_factors.tolist()))


def _ascending(name: str, values: Array, sign: float, rule: str, unit: str = "") -> None:
    refuse(name, values, np.append(False, ~(sign * np.diff(values) > 0)), rule, unit)


def _power(decades: ArrayLike) -> Any:
    """Return the power of ten; by the loop of arrays also for one number, as its last bit might differ."""
    factor = np.power(10.0, np.asarray(decades))
    return factor if factor.ndim else float(factor)


def _within(temperature: Numeric, low: Any, high: Any, what: str) -> None:
    values = np.asarray(temperature)
    end = f"in [{low:g}, {high:g}]" if math.isfinite(high) else f">= {low:g}"
    refuse("temperature", values, ~((values >= low) & (values <= high)), f"must be {end} K, {what}", "K")
