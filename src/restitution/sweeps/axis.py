"""Axes of a sweep: values on a line, on a logarithmic one, or from a list."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any, Protocol, TypeGuard

import numpy as np
from numpy.typing import NDArray

from restitution.checks import finite, positive
from restitution.sweeps.schema import INPUTS

Array = NDArray[Any]

MOST_POINTS = 10**8
"""Points along one axis, whose values as coordinates must fit in memory; several axes may make more."""


class Axis(Protocol):
    """One dimension of a sweep, along which one quantity varies, or several together."""

    @property
    def size(self) -> int:
        """Number of points."""
        ...

    @property
    def scale(self) -> str:
        """How it is spaced: "linear", "logarithmic", "list" or "samples"."""
        ...

    def names(self, dimension: str) -> tuple[str, ...]:
        """Names of the quantities that it sets, as the axis of that dimension."""
        ...

    def columns(self, dimension: str, start: int, stop: int) -> dict[str, Array]:
        """Values of its quantities from one point to another."""
        ...

    def corners(self, dimension: str) -> list[dict[str, Array]]:
        """Values that show whether something is wrong with it."""
        ...

    def describe(self) -> Any:
        """What distinguishes it from others, in types that JSON has."""
        ...


@dataclass(frozen=True)
class Linear:
    """Axis of n values from low to high at equal distances.

    Parameters
    ----------
    low, high : float
        First and last value, in SI units; low may be the larger one.
    n : int
        Number of values, from 1 to 10^8.

    Raises
    ------
    ValueError
        If a number is not finite, or n is not from 1 to 10^8.

    Examples
    --------
    >>> Linear(0.0, 1.0, 5).values(0, 5).tolist()
    [0.0, 0.25, 0.5, 0.75, 1.0]
    """

    low: float
    high: float
    n: int
    scale = "linear"

    def __post_init__(self) -> None:
        finite("low", self.low)
        finite("high", self.high)
        count(self.n)

    @property
    def size(self) -> int:
        """Number of values."""
        return self.n

    def names(self, dimension: str) -> tuple[str, ...]:
        """Return the name of the dimension."""
        return (dimension,)

    def values(self, start: int, stop: int) -> Array:
        """Values from one place to another."""
        share = np.arange(start, stop) / max(self.n - 1, 1)
        # Both ends to the last bit.
        return self.low * (1.0 - share) + self.high * share

    def columns(self, dimension: str, start: int, stop: int) -> dict[str, Array]:
        """Values by name."""
        return {dimension: self.values(start, stop)}

    def corners(self, dimension: str) -> list[dict[str, Array]]:
        """First and last value."""
        return [self.columns(dimension, 0, 1), self.columns(dimension, self.n - 1, self.n)]

    def describe(self) -> Any:
        """Kind and numbers."""
        return {self.scale: [float(self.low), float(self.high)], "n": int(self.n)}


@dataclass(frozen=True)
class Logarithmic(Linear):
    """Axis of n values from low to high at equal ratios.

    Parameters
    ----------
    low, high : float
        First and last value, > 0, in SI units; low may be the larger one.
    n : int
        Number of values, from 1 to 10^8.

    Raises
    ------
    ValueError
        If an end is not finite and > 0, or n is not from 1 to 10^8.

    Examples
    --------
    >>> Logarithmic(0.01, 100.0, 3).values(0, 3).tolist()
    [0.01, 1.0, 100.0]
    """

    scale = "logarithmic"

    def __post_init__(self) -> None:
        positive("low", self.low)
        positive("high", self.high)
        count(self.n)

    def values(self, start: int, stop: int) -> Array:
        """Values from one place to another."""
        place = np.arange(start, stop)
        logs = Linear(math.log10(self.low), math.log10(self.high), self.n).values(start, stop)
        values = 10.0**logs
        values[place == 0] = self.low
        values[(place == self.n - 1) & (place > 0)] = self.high
        return values


@dataclass(frozen=True)
class Listed:
    """Axis of given values: numbers in SI units, or objects such as materials."""

    items: tuple[Any, ...]
    scale = "list"

    @property
    def size(self) -> int:
        """Number of values."""
        return len(self.items)

    @cached_property
    def is_numeric(self) -> bool:
        """Whether all values are numbers."""
        return all(map(_is_number, self.items))

    @cached_property
    def array(self) -> Array:
        """Numbers as float64, objects as they are."""
        if self.is_numeric:
            return np.array(self.items, dtype=np.float64)
        array = np.empty(len(self.items), dtype=object)
        array[:] = self.items
        return array

    def labels(self, dimension: str) -> list[str]:
        """Words for values that are not numbers, all different."""
        words = [
            _text(item) or f"{dimension.replace('_', ' ')} {n}" for n, item in enumerate(self.items, start=1)
        ]
        return [word if words.count(word) == 1 else f"{word} ({n})" for n, word in enumerate(words, start=1)]

    def names(self, dimension: str) -> tuple[str, ...]:
        """Return the name of the dimension."""
        return (dimension,)

    def columns(self, dimension: str, start: int, stop: int) -> dict[str, Array]:
        """Values by name."""
        return {dimension: self.array[start:stop]}

    def corners(self, dimension: str) -> list[dict[str, Array]]:
        """First and last number; all objects."""
        places = {0, self.size - 1} if self.is_numeric else range(self.size)
        return [self.columns(dimension, place, place + 1) for place in sorted(places)]

    def describe(self) -> Any:
        """All values."""
        from restitution.sweeps.description import describe

        return {"list": [describe(item) for item in self.items]}


def as_axis(name: str, given: Any) -> Axis | None:
    """Return what was given for an axis as one; None if it is a single value.

    Raises
    ------
    ValueError
        If a value is out of the range of the quantity.
    TypeError
        If the quantity is a number and what is given holds none.
    """
    known = INPUTS.get(key_of(name))
    if isinstance(given, Linear):
        axis: Axis = given
        _check(name, given.values(0, min(given.n, 1)), "first value")
        _check(name, given.values(given.n - 1, given.n), "last value")
        return axis
    if isinstance(given, np.ndarray) and given.ndim != 1:
        raise ValueError(f"{name}: has shape {given.shape}; an axis is one-dimensional")
    if isinstance(given, (str, bytes, Mapping)) or not isinstance(given, (Sequence, np.ndarray)):
        if _is_number(given):
            _check(name, float(given), "")
        elif known is not None:
            raise TypeError(
                f"{name} = {given!r}: must be a number, a sequence of them, Linear or Logarithmic"
            )
        return None
    listed = Listed(tuple(given.tolist() if isinstance(given, np.ndarray) else given))
    if listed.size == 0:
        raise ValueError(f"{name}: must hold at least one value")
    if listed.is_numeric:
        _check(name, listed.array, "")
    elif known is not None:
        place, item = next((n, item) for n, item in enumerate(listed.items) if not _is_number(item))
        raise TypeError(f"{name}[{place}] = {item!r}: must be a number")
    return listed


def _check(name: str, values: Any, which: str) -> None:
    known = INPUTS.get(key_of(name))
    label = f"{name}, {which}" if which else name
    unit = "" if known is None or known.variable.unit == "1" else known.variable.unit
    if which:
        values = float(values[0])
    (known.check if known else finite)(label, values, unit)


def key_of(name: str) -> str:
    """Return the quantity that a name ends in, such as that of a key of a case file or of a list's entry."""
    return name.partition("[")[0].rpartition(".")[2]


def count(n: Any) -> None:
    """Refuse what is no number of points."""
    if isinstance(n, bool) or not isinstance(n, (int, np.integer)) or n < 1:
        raise ValueError(f"n = {n!r}: must be a whole number >= 1")
    if n > MOST_POINTS:
        raise ValueError(f"n = {n}: must be at most {MOST_POINTS}, the most points along one axis")


def _is_number(item: Any) -> TypeGuard[float]:
    return isinstance(item, (int, float, np.number)) and not isinstance(item, bool)


def _text(item: Any) -> str:
    """Return what an object or the table that describes it is called, if anything."""
    if isinstance(item, (str, int, float)):
        return str(item)
    if isinstance(item, Mapping):
        return next((str(item[key]) for key in ("name", "library", "file") if item.get(key)), "")
    return str(getattr(item, "name", None) or "")
