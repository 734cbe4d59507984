"""Distributions of an uncertain quantity: the value below which a given share of the draws lies."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Protocol, runtime_checkable

import numpy as np
from numpy.typing import NDArray

from restitution.checks import finite, positive

Array = NDArray[np.float64]

# A distribution of which more lies outside the range of its quantity is not meant.
_MOST_OUTSIDE = 0.5


@runtime_checkable
class Distribution(Protocol):
    """Distribution of one quantity."""

    def quantiles(self, shares: Array, low: float, high: float) -> Array:
        """Values below which the shares of the draws lie, shape (n,), all within [low, high].

        Raises
        ------
        ValueError
            If the distribution does not fit the range [low, high] of the quantity.
        """
        ...


def _inside(what: object, ends: tuple[float, float], low: float, high: float) -> None:
    if not (low <= ends[0] and ends[1] <= high):
        raise ValueError(f"{what}: must lie in [{low:g}, {high:g}]")


def _ascending(low: float, high: float) -> None:
    if not low < high:
        raise ValueError(f"low = {low:g}, high = {high:g}: must ascend")


@dataclass(frozen=True)
class Uniform:
    """Uniform distribution between two ends.

    Parameters
    ----------
    low, high : float
        Ends, in the unit of the quantity.

    Examples
    --------
    >>> Uniform(1.0, 3.0).quantiles(np.array([0.25]), 0.0, np.inf).tolist()
    [1.5]
    """

    low: float
    high: float

    def __post_init__(self) -> None:
        _ascending(float(finite("low", self.low)), float(finite("high", self.high)))

    def quantiles(self, shares: Array, low: float, high: float) -> Array:
        """Values below which the shares of the draws lie."""
        _inside(self, (self.low, self.high), low, high)
        return self.low + shares * (self.high - self.low)


@dataclass(frozen=True)
class LogUniform:
    """Distribution whose logarithm is uniform: every decade is equally likely.

    Parameters
    ----------
    low, high : float
        Ends > 0, in the unit of the quantity.

    Examples
    --------
    >>> print(round(float(LogUniform(1.0, 100.0).quantiles(np.array([0.5]), 0.0, np.inf)[0]), 12))
    10.0
    """

    low: float
    high: float

    def __post_init__(self) -> None:
        _ascending(float(positive("low", self.low)), float(positive("high", self.high)))

    def quantiles(self, shares: Array, low: float, high: float) -> Array:
        """Values below which the shares of the draws lie."""
        _inside(self, (self.low, self.high), low, high)
        return self.low * np.exp(shares * math.log(self.high / self.low))


@dataclass(frozen=True)
class Normal:
    """Normal distribution, cut off where the quantity has no admissible values.

    Parameters
    ----------
    mean : float
        Mean, in the unit of the quantity.
    standard_deviation : float
        Standard deviation > 0, in the same unit.

    Examples
    --------
    >>> print(round(float(Normal(10.0, 1.0).quantiles(np.array([0.841344746]), 0.0, np.inf)[0]), 6))
    11.0
    """

    mean: float
    standard_deviation: float

    def __post_init__(self) -> None:
        finite("mean", self.mean)
        positive("standard_deviation", self.standard_deviation)

    def quantiles(self, shares: Array, low: float, high: float) -> Array:
        """Values below which the shares of the draws lie."""
        from scipy.special import ndtr, ndtri

        below, above = (float(ndtr((end - self.mean) / self.standard_deviation)) for end in (low, high))
        if above - below < 1.0 - _MOST_OUTSIDE:
            raise ValueError(f"{self}: most of it lies outside [{low:g}, {high:g}]")
        values = self.mean + self.standard_deviation * ndtri(below + shares * (above - below))
        # The ends themselves may be excluded, such as a mass of zero.
        return np.clip(values, np.nextafter(low, math.inf), np.nextafter(high, -math.inf))


@dataclass(frozen=True)
class LogNormal:
    """Distribution whose logarithm is normal.

    Parameters
    ----------
    median : float
        Median > 0, in the unit of the quantity.
    sigma : float
        Standard deviation of the natural logarithm, > 0; 0.1 is about 10 % of scatter.

    Examples
    --------
    >>> print(float(LogNormal(5.0, 0.1).quantiles(np.array([0.5]), 0.0, np.inf)[0]))
    5.0
    """

    median: float
    sigma: float

    def __post_init__(self) -> None:
        positive("median", self.median)
        positive("sigma", self.sigma)

    def quantiles(self, shares: Array, low: float, high: float) -> Array:
        """Values below which the shares of the draws lie."""
        from scipy.special import ndtri

        if not (low <= 0.0 and high == math.inf):
            raise ValueError(f"{self}: must be of a quantity that takes all positive values")
        return self.median * np.exp(self.sigma * ndtri(shares))
