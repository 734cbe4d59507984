"""Observations: measured values, their noise, and the residuals of a material."""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from collections.abc import Mapping
from dataclasses import replace
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from restitution import checks
from restitution.contact.profile import Parabola
from restitution.errors import InputError
from restitution.material.columns import MaterialColumns
from restitution.material.fit import DynamicTable

Array = NDArray[np.float64]

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
    def given(noise: Any) -> Noise:
        """Return a noise, or none at all for None; other types are refused."""
        return Noise() if noise is None else checks.instance("noise", noise, Noise, "must be a Noise")

    def of(self, name: str, values: Array, scale: Array | float | None = None) -> Array | None:
        """Standard deviations of values in SI, shape (n,); None if unknown.

        A relative one refers to each value, or to `scale` if it is given.
        """
        if name not in self.deviations:
            return None
        given = self.deviations[name]
        parts = given if isinstance(given, tuple) else (given,)
        square = np.zeros(np.shape(values))
        for part in parts:
            size = self._part(name, part, np.abs(values) if scale is None else np.asarray(scale))
            if np.shape(size) not in ((), np.shape(values)):
                raise InputError(f"noise.{name}", wanted=f"must be one number, or {np.size(values)} numbers")
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


def hollow_balls(mass: Any, profile: Any) -> list[str]:
    """Doubt about balls that are too light to be solid, in words."""
    if mass is None or not isinstance(profile, Parabola):
        return []
    with np.errstate(all="ignore"):  # a radius may be so small that its cube is zero
        density = float(np.min(mass / (4.0 / 3.0 * math.pi * np.asarray(profile.radius) ** 3)))
    if density >= _LIGHTEST:
        return []
    return [f"a ball of this mass and radius has {density:.0f} kg/m^3: a hollow one that deforms is no half-space"]


class Observations(ABC):
    """Measured data of one kind, in the form that `identify` needs.

    A subclass checks its data once, in its constructor, and converts them to SI. All methods take many materials at
    once: m rows of `MaterialColumns`, and an array of shape (m, n_nuisance) of the nuisances in their order.
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

    fixes_time: bool = True
    """Whether the data contain a time, a force or a modulus; the restitution coefficient alone does not."""

    @property
    @abstractmethod
    def size(self) -> int:
        """Number of residuals n."""

    @abstractmethod
    def residuals(self, materials: MaterialColumns, nuisances: Array) -> Array:
        """Residuals (fit - data) over their standard deviations, whitened, shape (m, n); NaN where a row fails."""

    @abstractmethod
    def curves(self, materials: MaterialColumns, nuisances: Array) -> list[Curve]:
        """Measured and fitted values for the first row."""

    @abstractmethod
    def window(self) -> tuple[float, float]:
        """Lowest and highest angular frequency [rad/s] of the data."""

    def contact_times(self, materials: MaterialColumns) -> Array | None:
        """Contact times [s] on each material, shape (m, n), NaN without separation; None for data of another kind."""
        return None

    def effective_moduli(self) -> DynamicTable | None:
        """Approximate storage and loss part of E* from the data, for a start; None if unknown."""
        return None

    def moduli_by_temperature(self) -> list[DynamicTable]:
        """The effective moduli, a table for each temperature."""
        table = self.effective_moduli()
        return [] if table is None else [replace(table, temperature=getattr(self, "temperature", table.temperature))]

    def assumed_moduli(self, modulus: float) -> DynamicTable | None:
        """The same from a loss tangent alone, at an assumed magnitude [Pa]; None without a loss tangent."""
        return None

    def linear_estimates(self, materials: MaterialColumns, nuisances: Array) -> dict[str, tuple[float, str]]:
        """Unknowns that were projected out, for the first row: value and SI unit by name."""
        return {}
