"""Inputs that are changed by small steps, and impacts as a function of them."""

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
from restitution.numerics.coordinates import Coordinate
from restitution.numerics.differences import BESIDE, BOTH, DOWNWARD, LONG_STEP, UPWARD
from restitution.quantities import CONSTANTS, INPUTS, TEMPERATURE, Quantity, key_of
from restitution.units import NUMBER
from restitution.variation import HeldElastic, numbers_by_name, varied

# Step [K] of temperatures, whose logarithm is no scale of relaxation.
_KELVIN = 0.5
# Step of a number at an end of its range over the length of the range.
_AT_END = 5e-4


@dataclass(frozen=True, eq=False)
class Input(Coordinate):
    """A number that is changed by small steps.

    Attributes
    ----------
    value : array
        Value in SI, in the shape of the impacts or ().
    step : float
        Usual step of its coordinate.
    """

    value: Array
    step: float

    def sides(self, share: float = 1.0) -> NDArray[np.intp]:
        """Return on which sides of each value the points lie: on one alone where the range ends."""
        reach = 4.0 * share * self.step if self.kind == "linear" else 0.0
        sides = np.where(self.value - reach < self.quantity.low, UPWARD, BOTH)
        return np.where(self.value + reach > self.quantity.high, DOWNWARD, sides)

    def points(self, share: float = 1.0) -> Array:
        """Return the values beside the value, shape (8, ...); `share` is that of the usual step."""
        return self.moved(self.value, np.moveaxis(BESIDE[self.sides(share)], -1, 0) * (share * self.step))

    def pace(self, share: float = 1.0) -> Array:
        """Return the derivative of the value by the place."""
        return share * self.step * self.slope(self.value)


def input_of(name: str, quantity: Quantity, value: Any, step: float | None = None) -> Input:
    """Return a number as an input; by default with a step of its logarithm, or logit, or of a size that suits it.

    A given `step` is in SI.
    """
    number = np.asarray(value, dtype=np.float64)
    if not np.all(np.isfinite(number)):
        rule = "must be finite: a number that is infinite has no derivative"
        hint = "; take poisson_ratio for an incompressible material" if key_of(name) == "bulk_modulus" else ""
        raise InputError(name, math.inf, rule + hint, quantity.unit)
    length = quantity.high - quantity.low
    if step is None and quantity.dimension is TEMPERATURE:
        step = _KELVIN
    if step is None and math.isfinite(length) and np.any((number <= quantity.low) | (number >= quantity.high)):
        step = _AT_END * length
    if step is not None:
        return Input(name, quantity, "linear", number, step)
    if not math.isfinite(length) and np.any(number == 0.0):
        raise InputError(name, 0.0, "has no step of its own at 0; give steps={name: step in SI}", quantity.unit)
    return Input(name, quantity, "logit" if math.isfinite(length) else "log", number, LONG_STEP)


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
    inputs = tuple(input_of(name, quantity_of(name), value, step_of(name, steps)) for name, value in numbers.items())
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
