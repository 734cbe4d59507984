"""Inputs that are changed by small steps: their coordinates, and the points that their derivatives take."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from restitution.axes import Axes
from restitution.checks import Array, single_positive
from restitution.errors import InputError
from restitution.impact.problem import Impact
from restitution.numerics.differences import CENTRAL, DOWNWARD, PLACES, UPWARD
from restitution.quantities import CONSTANTS, INPUTS, TEMPERATURE, Quantity, key_of
from restitution.units import NUMBER
from restitution.variation import HeldElastic, numbers_by_name, varied

STEP = 0.02
"""Step of the logarithm of a positive number, or of the logit of a number between two finite ends."""

# Step [K] of temperatures, whose logarithm is no scale of relaxation.
_KELVIN = 0.5
# Step of a number at an end of its range over the length of the range.
_AT_END = 5e-4


@dataclass(frozen=True, eq=False)
class Input:
    """A number that is changed by small steps.

    Attributes
    ----------
    name : str
        Its name.
    quantity : Quantity
        What it is, with its range.
    value : array
        Value in SI, in the shape of the impacts or ().
    step : float, optional
        Step in SI; by default one of the logarithm, or of the logit, or of a size that suits the quantity.
    """

    name: str
    quantity: Quantity
    value: Array
    step: float | None = None

    def __post_init__(self) -> None:
        value = np.asarray(self.value, dtype=np.float64)
        object.__setattr__(self, "value", value)
        if not np.all(np.isfinite(value)):
            rule = "must be finite: a number that is infinite has no derivative"
            hint = "; take poisson_ratio for an incompressible material" if key_of(self.name) == "bulk_modulus" else ""
            raise InputError(self.name, math.inf, rule + hint, self.quantity.unit)
        if self._absolute is None and np.any(value == 0.0) and (self._at_end.any() or not self._is_between):
            rule = "has no step of its own at 0; give steps={name: step in SI}"
            raise InputError(self.name, 0.0, rule, self.quantity.unit)

    @property
    def _is_between(self) -> bool:
        return math.isfinite(self.quantity.low) and math.isfinite(self.quantity.high)

    @property
    def _at_end(self) -> Any:
        return (self.value <= self.quantity.low) | (self.value >= self.quantity.high)

    @property
    def _absolute(self) -> float | None:
        """Step in SI, where it is neither one of the logarithm nor of the logit."""
        if self.step is not None:
            return self.step
        if self.quantity.dimension is TEMPERATURE:
            return _KELVIN
        if self._is_between and np.any(self._at_end):
            return _AT_END * (self.quantity.high - self.quantity.low)
        return None

    def sides(self, share: float = 1.0) -> NDArray[np.intp]:
        """Return on which sides of each value the points lie: on one alone where the range ends."""
        reach = 4.0 * share * (self._absolute or 0.0)
        sides = np.where(self.value - reach < self.quantity.low, UPWARD, CENTRAL)
        return np.where(self.value + reach > self.quantity.high, DOWNWARD, sides)

    def points(self, share: float = 1.0) -> Array:
        """Return the values at the places of the sides, shape (9, ...); `share` is that of the usual step."""
        places = np.moveaxis(PLACES[self.sides(share)], -1, 0) * share
        if (step := self._absolute) is not None:
            return self.value + places * step
        at = np.broadcast_to(self.value, places.shape)
        grown = np.exp(places * STEP)
        if not self._is_between:
            return at * grown
        low, high = self.quantity.low, self.quantity.high
        moved = low + (high - low) / (1.0 + (high - at) / (at - low) / grown)
        return np.where(places == 0.0, at, moved)

    def pace(self, share: float = 1.0) -> Array:
        """Return the derivative of the value by the place."""
        if (step := self._absolute) is not None:
            return np.full(self.value.shape, share * step)
        if not self._is_between:
            return share * STEP * self.value
        low, high = self.quantity.low, self.quantity.high
        return share * STEP * (self.value - low) * (high - self.value) / (high - low)


@dataclass(frozen=True, eq=False)
class Model:
    """Impacts as a function of inputs.

    Attributes
    ----------
    inputs : tuple of Input
        The inputs.
    build : callable
        Function from values of all inputs by name, of shape ``(n, *shape)``, or (n,) for single impacts, to an array
        of impacts of shape (n, size), or a list of n impacts.
    shape, axes
        Shape of the impacts, and the names of their axes.
    adhesive : bool
        Whether the impacts have adhesion, whose tolerance has an end.
    """

    inputs: tuple[Input, ...]
    build: Callable[[Mapping[str, Array]], Impact | list[Impact]]
    shape: tuple[int, ...] = ()
    axes: Axes | None = None
    adhesive: bool = False


def model_of(
    impact: Impact, names: Any, held: HeldElastic = "bulk_modulus", steps: Mapping[str, Any] | None = None
) -> Model:
    """Return impacts as a function of their numbers by the names of `vary`."""
    flat = impact.take(np.arange(math.prod(impact.shape))) if impact.shape else impact
    numbers = numbers_by_name(flat, names)
    inputs = tuple(
        Input(name, quantity_of(name), np.asarray(value), step_of(name, steps)) for name, value in numbers.items()
    )
    return Model(inputs, lambda values: varied(flat, values, held), impact.shape, impact.axes,
                 impact.adhesion is not None)  # fmt: skip


def quantity_of(name: str) -> Quantity:
    """Return the quantity of a name; a number that no quantity of the package has is positive."""
    key = key_of(name)
    quantity = INPUTS.get(key) or CONSTANTS.get(key)
    return quantity or Quantity(name, NUMBER, name.replace("_", " "), "", 0.0, open=True)


def step_of(name: str, steps: Mapping[str, Any] | None) -> float | None:
    """Return the step in SI that a user gives for an input."""
    return None if steps is None or name not in steps else single_positive(f"steps.{name}", steps[name])
