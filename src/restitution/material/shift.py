"""Time-temperature shift: how much slower or faster a material relaxes at another temperature."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Protocol, runtime_checkable

import numpy as np
from numpy.typing import ArrayLike, NDArray

from restitution.kernel.validation import finite, positive

Array = NDArray[np.float64]

GAS_CONSTANT = 8.31446261815324
"""Molar gas constant R [J/(mol K)], exact in the SI of 2019."""

_LN10 = math.log(10.0)


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

    Raises
    ------
    ValueError
        If a number is out of range; from `factor` at or below the Vogel temperature T0 - C2.

    Notes
    -----
    J. Am. Chem. Soc. 77 (1955) 3701. Valid from the glass transition to about 100 K above it.

    Examples
    --------
    >>> print(round(WLF(298.0, 8.61, 200.4).factor(308.0), 6))
    0.389744
    """

    reference_temperature: float
    c1: float
    c2: float

    def __post_init__(self) -> None:
        positive("reference_temperature", self.reference_temperature, "K")
        positive("c1", self.c1)
        positive("c2", self.c2, "K")

    def factor(self, temperature: float) -> float:
        """Shift factor a_T [-] at the temperature T [K]."""
        difference = float(positive("temperature", temperature, "K")) - self.reference_temperature
        if difference <= -self.c2:
            raise ValueError(
                f"temperature = {temperature:g} K: must be > {self.reference_temperature - self.c2:g} K, "
                "where the WLF law diverges"
            )
        return _from_log10(-self.c1 * difference / (self.c2 + difference))


@dataclass(frozen=True)
class Arrhenius:
    """Shift factor ln a_T = (Q/R) (1/T - 1/T0) of a thermally activated process.

    Parameters
    ----------
    reference_temperature
        T0 > 0 [K].
    activation_energy
        Q > 0 [J/mol].

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

    def __post_init__(self) -> None:
        positive("reference_temperature", self.reference_temperature, "K")
        positive("activation_energy", self.activation_energy, "J/mol")

    def factor(self, temperature: float) -> float:
        """Shift factor a_T [-] at the temperature T [K]."""
        number = float(positive("temperature", temperature, "K"))
        inverse = (self.reference_temperature - number) / (number * self.reference_temperature)
        return _from_log10(self.activation_energy / GAS_CONSTANT * inverse / _LN10)


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
        logs = np.atleast_1d(finite("log10_factors", log10_factors))
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
        if not low <= number <= high:
            raise ValueError(
                f"temperature = {number:g} K: must be in [{low:g}, {high:g}] K, the table's range"
            )
        return _from_log10(float(np.interp(number, self.temperatures, self.log10_factors)))

    def __eq__(self, other: object) -> bool:
        if not isinstance(other, ShiftTable):
            return NotImplemented
        return np.array_equal(self.temperatures, other.temperatures) and np.array_equal(
            self.log10_factors, other.log10_factors
        )

    def __hash__(self) -> int:
        return hash((self.temperatures.tobytes(), self.log10_factors.tobytes()))


def _from_log10(exponent: float) -> float:
    if abs(exponent) > 300.0:
        raise ValueError(
            f"temperature: log10 of the shift factor is {exponent:.0f}, beyond what numbers can hold"
        )
    return 10.0**exponent
