"""Time-temperature shift: the ratio of the relaxation times at two temperatures."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import Protocol, runtime_checkable

import numpy as np
from numpy.typing import ArrayLike, NDArray

from restitution.checks import positive, within

Array = NDArray[np.float64]

GAS_CONSTANT = 8.31446261815324
"""Molar gas constant R [J/(mol K)], exact in the SI of 2019."""

_LN10 = math.log(10.0)
# Decades of the shift factor that numbers can hold, with some to spare for the times.
_DECADES = 300.0


@runtime_checkable
class Shift(Protocol):
    """Law of the shift factor a_T: relaxation times at T are a_T times those at the reference."""

    @property
    def reference_temperature(self) -> float:
        """Temperature [K] at which a_T = 1."""
        ...

    def factor(self, temperature: float) -> float:
        """Shift factor a_T [-] at the temperature T [K]."""
        ...


@dataclass(frozen=True)
class WLF:
    """Shift factor log10 a_T = -C1 (T - T0)/(C2 + T - T0) of Williams, Landel and Ferry.

    Parameters
    ----------
    reference_temperature
        T0 > 0 [K].
    c1
        C1 > 0 [-].
    c2
        C2 > 0 [K].
    temperature_range
        Lowest and highest admissible temperature [K]; without it, all above the Vogel
        temperature T0 - C2.

    Raises
    ------
    ValueError
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
    ValueError: temperature = 500 K: must be in [202, 400] K, the range of the law
    """

    reference_temperature: float
    c1: float
    c2: float
    temperature_range: tuple[float, float] | None = field(default=None, kw_only=True)

    def __post_init__(self) -> None:
        positive("reference_temperature", self.reference_temperature, "K")
        positive("c1", self.c1)
        positive("c2", self.c2, "K")
        _check_range(self.temperature_range, self.reference_temperature)

    def factor(self, temperature: float) -> float:
        """Shift factor a_T [-] at the temperature T [K]."""
        number, reference = float(positive("temperature", temperature, "K")), self.reference_temperature
        c1, c2 = self.c1, self.c2
        # Where log10 a_T is x: T = T0 - x C2/(C1 + x).
        low = reference - _DECADES * c2 / (c1 + _DECADES)
        high = reference + _DECADES * c2 / (c1 - _DECADES) if c1 > _DECADES else math.inf
        _check(number, self.temperature_range, (low, high))
        return 10.0 ** (-c1 * (number - reference) / (c2 + number - reference))


@dataclass(frozen=True)
class Arrhenius:
    """Shift factor ln a_T = (Q/R) (1/T - 1/T0) of a thermally activated process.

    Parameters
    ----------
    reference_temperature
        T0 > 0 [K].
    activation_energy
        Q > 0 [J/mol].
    temperature_range
        Lowest and highest temperature [K] for which the law is meant; all without it.

    Raises
    ------
    ValueError
        If a number is out of range; from `factor` outside the range of temperatures.

    Notes
    -----
    Ferry, *Viscoelastic Properties of Polymers*, 3rd ed. (1980), ch. 11. Used below the glass transition.

    Examples
    --------
    >>> print(round(Arrhenius(300.0, 100e3).factor(310.0), 6))
    0.274377
    """

    reference_temperature: float
    activation_energy: float
    temperature_range: tuple[float, float] | None = field(default=None, kw_only=True)

    def __post_init__(self) -> None:
        positive("reference_temperature", self.reference_temperature, "K")
        positive("activation_energy", self.activation_energy, "J/mol")
        _check_range(self.temperature_range, self.reference_temperature)

    def factor(self, temperature: float) -> float:
        """Shift factor a_T [-] at the temperature T [K]."""
        number, reference = float(positive("temperature", temperature, "K")), self.reference_temperature
        slope = self.activation_energy / (GAS_CONSTANT * _LN10)
        low, inverse = 1.0 / (1.0 / reference + _DECADES / slope), 1.0 / reference - _DECADES / slope
        _check(number, self.temperature_range, (low, 1.0 / inverse if inverse > 0 else math.inf))
        return 10.0 ** (slope * (reference - number) / (number * reference))


@dataclass(frozen=True, eq=False)
class ShiftTable:
    """Shift factors measured at some temperatures, log10 a_T being linear between them.

    Parameters
    ----------
    temperatures
        Temperatures [K], strictly ascending, shape (n,), n >= 2.
    log10_factors
        log10 a_T [-], strictly descending, shape (n,); must pass through 0.

    Raises
    ------
    ValueError
        If the table is malformed; from `factor` outside the range measured.

    Examples
    --------
    >>> table = ShiftTable([290.0, 300.0, 310.0], [1.0, 0.0, -0.5])
    >>> print(table.reference_temperature, table.factor(290.0))
    300.0 10.0
    """

    temperatures: Array
    log10_factors: Array

    def __init__(self, temperatures: ArrayLike, log10_factors: ArrayLike) -> None:
        kelvin = np.atleast_1d(positive("temperatures", temperatures, "K"))
        logs = np.atleast_1d(within("log10_factors", log10_factors, -_DECADES, _DECADES))
        if kelvin.ndim != 1 or kelvin.shape != logs.shape or kelvin.size < 2:
            raise ValueError(
                f"temperatures has shape {kelvin.shape} and log10_factors {logs.shape}: "
                "must be one-dimensional, of equal length, at least 2"
            )
        for name, steps in (("temperatures", np.diff(kelvin)), ("-log10_factors", -np.diff(logs))):
            if not (steps > 0).all():
                where = int(np.argmin(steps > 0)) + 1
                raise ValueError(f"{name} does not ascend at entry {where}: must be strictly ascending")
        if logs[0] < 0 or logs[-1] > 0:
            raise ValueError(
                f"log10_factors runs from {logs[0]:g} to {logs[-1]:g}: must pass through 0, at the reference"
            )
        self.__dict__.update(temperatures=kelvin, log10_factors=logs)

    @property
    def reference_temperature(self) -> float:
        """Temperature [K] at which a_T = 1."""
        return float(np.interp(0.0, self.log10_factors[::-1], self.temperatures[::-1]))

    def factor(self, temperature: float) -> float:
        """Shift factor a_T [-] at the temperature T [K] within the table."""
        number = float(positive("temperature", temperature, "K"))
        low, high = float(self.temperatures[0]), float(self.temperatures[-1])
        _within(number, low, high, "the range of the table")
        return 10.0 ** float(np.interp(number, self.temperatures, self.log10_factors))

    def __eq__(self, other: object) -> bool:
        if not isinstance(other, ShiftTable):
            return NotImplemented
        return np.array_equal(self.temperatures, other.temperatures) and np.array_equal(
            self.log10_factors, other.log10_factors
        )

    def __hash__(self) -> int:
        return hash((self.temperatures.tobytes(), self.log10_factors.tobytes()))


def _check_range(limits: tuple[float, float] | None, reference: float) -> None:
    if limits is None:
        return
    low, high = (float(positive("temperature_range", limit, "K")) for limit in limits)
    if not low <= reference <= high or low == high:
        raise ValueError(
            f"temperature_range = ({low:g}, {high:g}) K: must ascend and hold {reference:g} K, the "
            "reference_temperature"
        )


def _check(temperature: float, limits: tuple[float, float] | None, ends: tuple[float, float]) -> None:
    if limits is not None:
        _within(temperature, *limits, "the range of the law")
    _within(temperature, *ends, "where the shift factor is between 1e-300 and 1e300")


def _within(temperature: float, low: float, high: float, what: str) -> None:
    if not low <= temperature <= high:
        end = f"in [{low:g}, {high:g}]" if math.isfinite(high) else f">= {low:g}"
        raise ValueError(f"temperature = {temperature:g} K: must be {end} K, {what}")
