"""Random draws along an axis: several quantities, each with its distribution."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from restitution.sweeps.axis import count, key_of
from restitution.sweeps.distribution import Distribution
from restitution.sweeps.schema import ALIASES, INPUTS

Array = NDArray[Any]
Method = Literal["sobol", "latin_hypercube"]

# Draws are shares of 2^-30; half of one keeps the ends, where a normal distribution is infinite, away.
_HALF_SHARE = 2.0**-31


@dataclass(frozen=True)
class Samples:
    """Axis of random draws, along which several quantities vary together, each with its distribution.

    Parameters
    ----------
    n : int
        Number of draws, from 1 to 10^8; of Sobol points a power of two is balanced best.
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
    >>> from restitution.sweeps.distribution import LogNormal, Uniform
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
        count(self.n)
        if self.method not in ("sobol", "latin_hypercube"):
            raise ValueError(f"method = {self.method!r}: must be 'sobol' or 'latin_hypercube'")
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
        from restitution.sweeps.description import describe

        drawn = {name: describe(distribution) for name, distribution in self.distributions.items()}
        return {"samples": drawn, "n": self.n, "method": self.method, "seed": self.seed}

    def _drawn(self, name: str, shares: Array) -> Array:
        known = INPUTS.get(key_of(name))
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
