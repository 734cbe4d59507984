"""Isotropic linear-viscoelastic material: shear and bulk relaxation."""

from __future__ import annotations

import math
from dataclasses import dataclass, fields, replace
from typing import Any

import numpy as np

from restitution.checks import finite, nonnegative, positive
from restitution.material.prony import PronySeries
from restitution.material.shift import Shift


@dataclass(frozen=True, init=False, repr=False)
class Material:
    """Isotropic linear-viscoelastic material, given by its shear and bulk relaxation moduli.

    Parameters
    ----------
    shear
        Relaxation modulus in shear G(t) [Pa]; a number means elastic. Not zero throughout.
    bulk
        Relaxation modulus in bulk K(t) [Pa]; a number means elastic, `math.inf` incompressible, 0 a Poisson
        ratio of -1.
    density
        Mass density rho [kg/m3], used only to judge whether the impact is quasi-static.
    name
        What to call the material.
    shift
        Law of the time-temperature shift, for `at`.
    temperature
        Temperature of the moduli [K]; the reference of `shift` unless given.
    source
        Where the numbers come from.
    window
        Shortest and longest time [s] for which the moduli are meant.
    assumptions
        What was assumed beside the source.

    Raises
    ------
    ValueError
        If a number is out of range.
    TypeError
        If a modulus is neither a number nor a `PronySeries`.

    Examples
    --------
    >>> rubber = Material(PronySeries(1e6, [5e6], [1e-4]), bulk=2e9, density=1100.0)
    >>> print(round(rubber.poisson_ratio, 5), round(rubber.instantaneous_poisson_ratio, 5))
    0.49975 0.4985
    """

    shear: PronySeries
    bulk: PronySeries | float
    density: float | None
    name: str | None
    shift: Shift | None
    temperature: float | None
    source: str | None
    window: tuple[float, float] | None
    assumptions: str | None

    def __init__(
        self,
        shear: PronySeries | float,
        bulk: PronySeries | float,
        *,
        density: float | None = None,
        name: str | None = None,
        shift: Shift | None = None,
        temperature: float | None = None,
        source: str | None = None,
        window: tuple[float, float] | None = None,
        assumptions: str | None = None,
    ) -> None:
        shear = _series("shear", shear)
        if shear.equilibrium_modulus == 0 and shear.parallel_viscosity == 0 and not shear.branch_moduli.any():
            raise ValueError("shear = 0 Pa: must not be zero throughout")
        bulk = math.inf if _is_infinite(bulk) else _series("bulk", bulk)
        if density is not None:
            density = float(positive("density", density, "kg/m3"))
        if temperature is not None:
            temperature = float(positive("temperature", temperature, "K"))
        elif shift is not None:
            temperature = shift.reference_temperature
        if window is not None:
            low, high = (float(positive("window", time, "s")) for time in window)
            if low >= high:
                raise ValueError(f"window = ({low:g}, {high:g}) s: must ascend")
            window = (low, high)
        self.__dict__.update(
            shear=shear,
            bulk=bulk,
            density=density,
            name=name,
            shift=shift,
            temperature=temperature,
            source=source,
            window=window,
            assumptions=assumptions,
        )

    def at(self, temperature: float) -> Material:
        """Material at another temperature [K]: every time is multiplied by the ratio of the shift factors.

        The moduli themselves and the density stay (thermorheologically simple, without a vertical shift).

        Raises
        ------
        ValueError
            If the material has no `shift`, or the temperature is outside its range.

        Examples
        --------
        >>> from restitution.material.shift import WLF
        >>> warm = Material(PronySeries(0.0, [1e9], [1.0]), 2e9, shift=WLF(300.0, 10.0, 100.0))
        >>> print(round(warm.at(325.0).shear.relaxation_times[0], 12))
        0.01
        """
        if self.shift is None or self.temperature is None:
            raise ValueError(f"temperature = {temperature:g} K: the material has no law of the shift")
        factor = self.shift.factor(temperature) / self.shift.factor(self.temperature)
        bulk, window = self.bulk, self.window
        return replace(
            self,
            shear=self.shear.scaled(1.0, time_factor=factor),
            bulk=bulk.scaled(1.0, time_factor=factor) if isinstance(bulk, PronySeries) else bulk,
            temperature=temperature,
            window=None if window is None else (window[0] * factor, window[1] * factor),
        )

    def __repr__(self) -> str:
        named = {field.name: getattr(self, field.name) for field in fields(self)}
        given = ", ".join(f"{name}={value!r}" for name, value in named.items() if value is not None)
        return f"Material({given})"

    @property
    def is_incompressible(self) -> bool:
        """Whether the bulk modulus is infinite."""
        return not isinstance(self.bulk, PronySeries)

    @property
    def poisson_ratio(self) -> float:
        """Static Poisson ratio nu = (3K - 2G)/(6K + 2G), that of the equilibrium moduli."""
        if not isinstance(self.bulk, PronySeries):
            return 0.5
        shear, bulk = self.shear.equilibrium_modulus, self.bulk.equilibrium_modulus
        if shear == 0 and bulk == 0:
            shear, bulk = self.shear.flow_viscosity, self.bulk.flow_viscosity
        return poisson_ratio(shear, bulk)

    @property
    def instantaneous_poisson_ratio(self) -> float:
        """Poisson ratio nu = (3K - 2G)/(6K + 2G) of the instantaneous moduli."""
        if not isinstance(self.bulk, PronySeries):
            return 0.5
        shear, bulk = self.shear.instantaneous_modulus, self.bulk.instantaneous_modulus
        if math.isinf(shear) and math.isinf(bulk):
            shear, bulk = self.shear.parallel_viscosity, self.bulk.parallel_viscosity
        return poisson_ratio(shear, bulk)

    @property
    def shear_wave_speed(self) -> float | None:
        """Speed sqrt(G/rho) [m/s] of the slowest shear wave: G at equilibrium, instantaneous if that is 0."""
        if self.density is None:
            return None
        return math.sqrt((self.shear.equilibrium_modulus or self.shear.instantaneous_modulus) / self.density)

    @property
    def pressure_wave_speed(self) -> float | None:
        """Speed sqrt((K + 4G/3)/rho) [m/s] of the slowest pressure wave, of moduli chosen as for shear."""
        if self.density is None:
            return None
        if not isinstance(self.bulk, PronySeries):
            return math.inf
        shear = self.shear.equilibrium_modulus or self.shear.instantaneous_modulus
        bulk = self.bulk.equilibrium_modulus or self.bulk.instantaneous_modulus
        return math.sqrt((bulk + 4.0 / 3.0 * shear) / self.density)

    @property
    def slowest_wave_speed(self) -> float | None:
        """Speed of the slowest bulk wave [m/s], which is always the shear wave; None without a density."""
        return self.shear_wave_speed


def poisson_ratio(shear_modulus: float, bulk_modulus: float) -> float:
    """Poisson ratio nu = (3K - 2G)/(6K + 2G) of two elastic moduli [Pa], of which one may be infinite.

    Examples
    --------
    >>> poisson_ratio(3.0, 5.0)
    0.25
    """
    if math.isinf(bulk_modulus):
        return 0.5
    if math.isinf(shear_modulus):
        return -1.0
    ratio = shear_modulus / bulk_modulus if bulk_modulus > shear_modulus else None
    if ratio is not None:
        return (3.0 - 2.0 * ratio) / (6.0 + 2.0 * ratio)
    ratio = bulk_modulus / shear_modulus
    return (3.0 * ratio - 2.0) / (6.0 * ratio + 2.0)


def bulk_from_poisson_ratio(shear_modulus: float, ratio: float) -> float:
    """Bulk modulus K = 2G(1 + nu)/(3(1 - 2 nu)) [Pa]; infinite for nu = 1/2.

    Parameters
    ----------
    shear_modulus
        G > 0 [Pa].
    ratio
        Poisson ratio nu in [-1, 0.5].

    Raises
    ------
    ValueError
        If nu is outside [-1, 0.5].

    Examples
    --------
    >>> print(round(bulk_from_poisson_ratio(3.0, 0.25), 12))
    5.0
    """
    number = float(finite("poisson_ratio", ratio))
    if not -1.0 <= number <= 0.5:
        raise ValueError(f"poisson_ratio = {number:g}: must be in [-1, 0.5]")
    if number == 0.5:
        return math.inf
    if shear_modulus == 0:
        raise ValueError("poisson_ratio: is 0.5 for a liquid (equilibrium_modulus = 0 Pa); give bulk_modulus")
    return 2.0 * shear_modulus * (1.0 + number) / (3.0 * (1.0 - 2.0 * number))


def _is_infinite(value: Any) -> bool:
    return isinstance(value, (int, float)) and value == math.inf


def _series(name: str, value: Any) -> PronySeries:
    if isinstance(value, PronySeries):
        return value
    modulus = nonnegative(name, value, "Pa")
    if isinstance(modulus, np.ndarray):
        raise TypeError(f"{name} = {value!r}: must be a number or a PronySeries")
    return PronySeries(float(modulus))
