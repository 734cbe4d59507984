"""Coordinates in which numbers take steps and scatter: logarithms, logits, or the numbers themselves."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Literal

import numpy as np

from restitution.checks import Array
from restitution.quantities import Quantity

Kind = Literal["log", "logit", "linear"]


@dataclass(frozen=True)
class Coordinate:
    """A number that is changed by its logarithm, by the logit of its place in its range, or by itself.

    Attributes
    ----------
    name : str
        Such as "viscosity" or "branch_moduli[0]".
    quantity : Quantity
        What it is, with its range.
    kind : {"log", "logit", "linear"}
        How its coordinate follows from it.
    """

    name: str
    quantity: Quantity
    kind: Kind

    def inward(self, value: Any) -> Any:
        """Return the coordinate of a value."""
        x = np.asarray(value, dtype=np.float64)
        if self.kind == "log":
            return np.log(x)[()]
        low, high = self.quantity.low, self.quantity.high
        return np.log((x - low) / (high - x))[()] if self.kind == "logit" else x[()]

    def outward(self, coordinate: Any) -> Any:
        """Return the value at a coordinate."""
        z = np.asarray(coordinate, dtype=np.float64)
        if self.kind == "log":
            return np.exp(z)[()]
        low, high = self.quantity.low, self.quantity.high
        return (low + (high - low) / (1.0 + np.exp(-z)))[()] if self.kind == "logit" else z[()]

    def moved(self, value: Array, change: Array) -> Array:
        """Return values after changes of their coordinates; those without a change keep all their digits."""
        if self.kind == "linear":
            return value + change
        if self.kind == "log":
            return value * np.exp(change)
        low, high = self.quantity.low, self.quantity.high
        with np.errstate(divide="ignore", invalid="ignore"):
            moved = low + (high - low) / (1.0 + (high - value) / (value - low) / np.exp(change))
        return np.where(change == 0.0, value, moved)

    def slope(self, value: Any) -> Any:
        """Return the derivative of the value by its coordinate."""
        x = np.asarray(value, dtype=np.float64)
        if self.kind == "linear":
            return np.ones(x.shape)[()]
        low, high = self.quantity.low, self.quantity.high
        return (x if self.kind == "log" else (x - low) * (high - x) / (high - low))[()]
