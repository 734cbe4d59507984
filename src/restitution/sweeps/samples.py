"""Random draws along an axis: several quantities, each with its distribution."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any, Literal, Protocol, runtime_checkable

import numpy as np
from numpy.typing import NDArray

from restitution.checks import finite, one_of, positive, single, whole
from restitution.errors import InputError, InputTypeError
from restitution.quantities import ALIASES, INPUTS, key_of
from restitution.sweeps.grid import MOST_POINTS, Axis

Array = NDArray[Any]
Method = Literal["sobol", "latin_hypercube"]

# Draws are multiples of 2^-30. Half of this keeps them away from 0 and 1, where the quantiles are infinite.
_HALF_SHARE = 2.0**-31
# Refuse a distribution with more than this share outside the admissible range.
_MOST_OUTSIDE = 0.5


@runtime_checkable
class Distribution(Protocol):
    """Distribution of one quantity."""

    def quantiles(self, shares: Array, low: float, high: float) -> Array:
        """Return the quantiles of the shares, shape (n,); refuse a range [low, high] that does not fit."""
        ...


def _inside(distribution: Any, low: float, high: float) -> None:
    if not (low <= distribution.low and distribution.high <= high):
        raise InputError("", distribution, f"must lie in [{low:g}, {high:g}]")


def _ascending(low: Any, high: Any) -> None:
    if not low < high:
        raise InputError("low", low, f"must be < high = {high:g}")


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
        _ascending(single("low", finite("low", self.low)), single("high", finite("high", self.high)))

    def quantiles(self, shares: Array, low: float, high: float) -> Array:
        """Return the quantiles of the shares."""
        _inside(self, low, high)
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
        _ascending(single("low", positive("low", self.low)), single("high", positive("high", self.high)))

    def quantiles(self, shares: Array, low: float, high: float) -> Array:
        """Return the quantiles of the shares."""
        _inside(self, low, high)
        return self.low * np.exp(shares * (math.log(self.high) - math.log(self.low)))


@dataclass(frozen=True)
class Normal:
    """Normal distribution, truncated to the admissible range of the quantity.

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
        """Return the quantiles of the shares."""
        from scipy.special import ndtr, ndtri

        below, above = (float(ndtr((end - self.mean) / self.standard_deviation)) for end in (low, high))
        if above - below < 1.0 - _MOST_OUTSIDE:
            raise InputError("", self, f"lies mostly outside [{low:g}, {high:g}]")
        values = self.mean + self.standard_deviation * ndtri(below + shares * (above - below))
        # An end may be excluded, such as a mass of zero.
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
        """Return the quantiles of the shares."""
        from scipy.special import ndtri

        if not (low <= 0.0 and high == math.inf):
            raise InputError("", self, "is for quantities that take all positive values")
        return self.median * np.exp(self.sigma * ndtri(shares))


@dataclass(frozen=True)
class Samples(Axis):
    """Axis of random draws, along which several quantities vary together, each with its distribution.

    Parameters
    ----------
    n : int
        Number of draws, from 1 to 10^8. A power of two balances Sobol points best.
    distributions : dict of str to Distribution
        By name of the quantity: `Uniform`, `LogUniform`, `Normal`, `LogNormal`.
    method : {"sobol", "latin_hypercube"}
        Scrambled Sobol points, or a Latin hypercube (which holds all draws in memory).
    seed : int
        Seed of the generator: the same seed gives the same draws.

    Raises
    ------
    InputError
        If a number is out of range, or a distribution does not fit its quantity.

    Notes
    -----
    Both methods of `scipy.stats.qmc` spread draws more evenly than random numbers. The error of a mean over n draws of
    a smooth function is about 1/n instead of 1/sqrt(n).

    Examples
    --------
    >>> from restitution.sweeps.samples import LogNormal, Uniform
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
        object.__setattr__(self, "n", whole("n", self.n, 1, MOST_POINTS))
        one_of("method", self.method, ("sobol", "latin_hypercube"))
        object.__setattr__(self, "seed", whole("seed", self.seed, 0))
        if not self.distributions:
            raise InputError("distributions", wanted="must name at least one quantity")
        named = {ALIASES.get(name, name): one for name, one in self.distributions.items()}
        object.__setattr__(self, "distributions", named)
        for name, distribution in named.items():
            if not isinstance(distribution, Distribution):
                raise InputTypeError(name, distribution, "must be a distribution")
            self._drawn(name, np.array([0.5]))

    @property
    def size(self) -> int:
        return self.n

    def names(self, dimension: str) -> tuple[str, ...]:
        return tuple(self.distributions)

    def columns(self, dimension: str, start: int, stop: int) -> dict[str, Array]:
        shares = self._shares(start, stop)
        return {name: self._drawn(name, shares[:, place]) for place, name in enumerate(self.distributions)}

    def corners(self, dimension: str) -> list[dict[str, Array]]:
        """All medians; some draws may be out of range."""
        return [{name: self._drawn(name, np.array([0.5])) for name in self.distributions}]

    def _drawn(self, name: str, shares: Array) -> Array:
        known = INPUTS.get(key_of(name))
        low, high = (known.low, known.high) if known else (-math.inf, math.inf)
        try:
            return self.distributions[name].quantiles(shares, low, high)
        except InputError as error:
            raise error.within(name) from None

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
            # SciPy warns if the number of first draws is not a power of two.
            shares = points.fast_forward(start).random(stop - start) if start else points.random(1)
            if not start and stop > 1:
                shares = np.concatenate([shares, points.random(stop - 1)])
        return np.clip(shares, _HALF_SHARE, 1.0 - _HALF_SHARE)

    def __getstate__(self) -> dict[str, Any]:
        return self.__dict__ | {"_hypercube": {}}
