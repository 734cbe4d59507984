"""Axes of a sweep: values on a line, on a logarithmic one, or from a list."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any, Protocol, TypeGuard

import numpy as np
from numpy.typing import NDArray

from restitution.checks import finite, number, positive, whole
from restitution.errors import InputError, InputTypeError
from restitution.quantities import INPUTS, key_of

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
        words = [_text(item) or f"{dimension.replace('_', ' ')} {n}" for n, item in enumerate(self.items, start=1)]
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
        from restitution.sweeps.fingerprint import describe

        return {"list": [describe(item) for item in self.items]}


def read_axis(name: str, given: Any) -> Any:
    """Return what is given for an axis as one; a single value as it is, as a float in SI if it is a number.

    Raises
    ------
    InputError
        If a value is outside the range of the quantity, is masked, or has another dimension.
    """
    known = INPUTS.get(key_of(name))
    if isinstance(given, Linear):
        for place in {0, given.n - 1}:
            value = float(given.values(place, place + 1)[0])
            known.check(value, name) if known else finite(name, value)
        return given
    if known is not None:
        values = known.check(given, name)
    elif _holds_numbers(given):
        values = finite(name, given)
    elif isinstance(given, (str, bytes, Mapping)) or not isinstance(given, (Sequence, np.ndarray)):
        return given
    else:
        values = np.empty(len(given), dtype=object)
        values[:] = list(given)
    if not isinstance(values, np.ndarray):
        return values
    if values.ndim != 1 or values.size == 0:
        raise InputError(name, wanted=f"must be one-dimensional and hold a value, but has shape {values.shape}")
    return Listed(tuple(values.tolist()))


def _holds_numbers(given: Any) -> bool:
    if isinstance(given, (str, bytes, Mapping, bool)) or given is None or callable(given):
        return False
    if isinstance(given, Sequence):
        return len(given) > 0 and all(map(_is_number, given))
    try:
        number("", given)
    except InputTypeError:
        # A masked array is one of numbers, and is refused with its name.
        return isinstance(given, np.ma.MaskedArray)
    return True


def count(n: Any) -> None:
    """Refuse what is no number of points."""
    whole("n", n, 1, MOST_POINTS)


def _is_number(item: Any) -> TypeGuard[float]:
    return isinstance(item, (int, float, np.number)) and not isinstance(item, bool)


def _text(item: Any) -> str:
    """Return what an object or the table that describes it is called, if anything."""
    if isinstance(item, (str, int, float)):
        return str(item)
    if isinstance(item, Mapping):
        return next((str(item[key]) for key in ("name", "library", "file") if item.get(key)), "")
    return str(getattr(item, "name", None) or "")
