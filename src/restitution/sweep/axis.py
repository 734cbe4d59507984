"""Axes of a sweep: values on a line, on a logarithmic one, from a list, or drawn at random."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any, Literal, Protocol

import numpy as np
from numpy.typing import NDArray

from restitution.kernel.validation import finite, positive
from restitution.sweep.distribution import Distribution
from restitution.sweep.schema import ALIASES, INPUTS

Array = NDArray[Any]
Method = Literal["sobol", "latin_hypercube"]

# Draws are shares of 2^-30; half of one keeps the ends, where a normal distribution is infinite, away.
_HALF_SHARE = 2.0**-31
_MOST_SOBOL = 2**30


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
        Number of values, >= 1.

    Raises
    ------
    ValueError
        If a number is not finite, or n < 1.

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
        _count(self.n)

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
        Number of values, >= 1.

    Raises
    ------
    ValueError
        If an end is not finite and > 0, or n < 1.

    Examples
    --------
    >>> Logarithmic(0.01, 100.0, 3).values(0, 3).tolist()
    [0.01, 1.0, 100.0]
    """

    scale = "logarithmic"

    def __post_init__(self) -> None:
        positive("low", self.low)
        positive("high", self.high)
        _count(self.n)

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
        return all(
            isinstance(item, (int, float, np.number)) and not isinstance(item, bool) for item in self.items
        )

    @cached_property
    def array(self) -> Array:
        """Numbers as float64, objects as they are."""
        if self.is_numeric:
            return np.array(self.items, dtype=np.float64)
        array = np.empty(len(self.items), dtype=object)
        array[:] = self.items
        return array

    @cached_property
    def labels(self) -> list[str]:
        """Words for values that are not numbers, all different."""
        words = [str(getattr(item, "name", None) or _text(item, n)) for n, item in enumerate(self.items)]
        return [word if words.count(word) == 1 else f"{word} ({n})" for n, word in enumerate(words)]

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
        from restitution.sweep.description import describe

        return {"list": [describe(item) for item in self.items]}


@dataclass(frozen=True)
class Samples:
    """Axis of random draws, along which several quantities vary together, each with its distribution.

    Parameters
    ----------
    n : int
        Number of draws; of Sobol points a power of two is balanced best.
    distributions : dict of str to Distribution
        By name of the quantity: `Uniform`, `LogUniform`, `Normal`, `LogNormal`.
    method : {"sobol", "latin_hypercube"}
        Scrambled Sobol points, or a Latin hypercube (which holds all draws in memory).
    seed : int
        Seed of the generator: the same seed gives the same draws.

    Raises
    ------
    ValueError
        If a number is out of range, or a distribution does not fit its quantity.

    Notes
    -----
    Both methods spread draws more evenly than chance does: a mean over n draws of a smooth function is wrong
    by about 1/n rather than 1/sqrt(n). `scipy.stats.qmc` makes the points.

    Examples
    --------
    >>> from restitution.sweep.distribution import LogNormal, Uniform
    >>> draws = Samples(4, {"mass": Uniform(1.0, 2.0), "radius": LogNormal(0.01, 0.1)}, seed=1)
    >>> sorted(draws.columns("draw", 0, 4))
    ['mass', 'radius']
    """

    n: int
    distributions: Mapping[str, Distribution]
    method: Method = "sobol"
    seed: int = 0
    _hypercube: dict[str, Any] = field(default_factory=dict, repr=False, compare=False)
    scale = "samples"

    def __post_init__(self) -> None:
        _count(self.n)
        if self.method not in ("sobol", "latin_hypercube"):
            raise ValueError(f"method = {self.method!r}: must be 'sobol' or 'latin_hypercube'")
        if self.method == "sobol" and self.n > _MOST_SOBOL:
            raise ValueError(f"n = {self.n}: there are {_MOST_SOBOL} Sobol points")
        if isinstance(self.seed, bool) or not isinstance(self.seed, int) or self.seed < 0:
            raise ValueError(f"seed = {self.seed!r}: must be a whole number >= 0")
        if not self.distributions:
            raise ValueError("distributions: must name at least one quantity")
        named = {ALIASES.get(name, name): one for name, one in self.distributions.items()}
        object.__setattr__(self, "distributions", named)
        for name, distribution in named.items():
            if not isinstance(distribution, Distribution):
                raise TypeError(f"{name} = {distribution!r}: must be a distribution")
            try:
                self._drawn(name, np.array([0.5]))
            except ValueError as error:
                raise ValueError(f"{name}: {error}") from None

    @property
    def size(self) -> int:
        """Number of draws."""
        return self.n

    def names(self, dimension: str) -> tuple[str, ...]:
        """Return the names of the quantities drawn."""
        return tuple(self.distributions)

    def columns(self, dimension: str, start: int, stop: int) -> dict[str, Array]:
        """Values by name."""
        shares = self._shares(start, stop)
        return {name: self._drawn(name, shares[:, place]) for place, name in enumerate(self.distributions)}

    def corners(self, dimension: str) -> list[dict[str, Array]]:
        """All medians; that some draws are out of range is no fault."""
        return [{name: self._drawn(name, np.array([0.5])) for name in self.distributions}]

    def describe(self) -> Any:
        """Kind, seed and distributions."""
        from restitution.sweep.description import describe

        drawn = {name: describe(distribution) for name, distribution in self.distributions.items()}
        return {"samples": drawn, "n": self.n, "method": self.method, "seed": self.seed}

    def _drawn(self, name: str, shares: Array) -> Array:
        known = INPUTS.get(_key(name))
        low, high = (known.low, known.high) if known else (-math.inf, math.inf)
        return self.distributions[name].quantiles(shares, low, high)

    def _shares(self, start: int, stop: int) -> Array:
        from scipy.stats import qmc

        # Newer versions of SciPy call it rng and take both.
        options: dict[str, Any] = {"seed": self.seed}
        dimensions = len(self.distributions)
        if self.method == "latin_hypercube":
            if "shares" not in self._hypercube:
                self._hypercube["shares"] = qmc.LatinHypercube(dimensions, **options).random(self.n)
            shares = self._hypercube["shares"][start:stop]
        else:
            points = qmc.Sobol(dimensions, scramble=True, **options)
            if start:
                points.fast_forward(start)
                shares = points.random(stop - start)
            else:
                # The first by itself: SciPy warns of first draws whose number is no power of two.
                first = points.random(1)
                shares = np.concatenate([first, points.random(stop - 1)]) if stop > 1 else first
        return np.clip(shares, _HALF_SHARE, 1.0 - _HALF_SHARE)

    def __getstate__(self) -> dict[str, Any]:
        return self.__dict__ | {"_hypercube": {}}


def as_axis(name: str, given: Any) -> Axis | None:
    """Return what was given for an axis as one; None if it is a single value.

    Raises
    ------
    ValueError
        If a value is out of the range of the quantity.
    """
    if isinstance(given, Samples):
        return given
    if isinstance(given, Linear):
        axis: Axis = given
        _check(name, given.values(0, min(given.n, 1)), "first value")
        _check(name, given.values(given.n - 1, given.n), "last value")
        return axis
    if isinstance(given, np.ndarray) and given.ndim != 1:
        raise ValueError(f"{name}: has shape {given.shape}; an axis is one-dimensional")
    if isinstance(given, (str, bytes, Mapping)) or not isinstance(given, (Sequence, np.ndarray)):
        if isinstance(given, (int, float, np.number)) and not isinstance(given, bool):
            _check(name, float(given), "")
        return None
    listed = Listed(tuple(given.tolist() if isinstance(given, np.ndarray) else given))
    if listed.size == 0:
        raise ValueError(f"{name}: must hold at least one value")
    if listed.is_numeric:
        _check(name, listed.array, "")
    return listed


def _check(name: str, values: Any, which: str) -> None:
    known = INPUTS.get(_key(name))
    label = f"{name}, {which}" if which else name
    unit = "" if known is None or known.variable.unit == "1" else known.variable.unit
    if which:
        values = float(values[0])
    (known.check if known else finite)(label, values, unit)


def _key(name: str) -> str:
    return name.partition("[")[0].rpartition(".")[2]


def _count(n: Any) -> None:
    if isinstance(n, bool) or not isinstance(n, (int, np.integer)) or n < 1:
        raise ValueError(f"n = {n!r}: must be a whole number >= 1")


def _text(item: Any, place: int) -> str:
    if isinstance(item, Mapping) and item.get("name"):
        return str(item["name"])
    return str(item) if isinstance(item, (str, int, float)) else f"{type(item).__name__} {place}"
