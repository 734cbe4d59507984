"""The points of a sweep: axes, random draws, their product, and its chunks."""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any, Literal, Protocol, runtime_checkable

import numpy as np
from numpy.typing import NDArray

from restitution.checks import finite, mapping, one_of, positive, single, whole
from restitution.errors import InputError, InputTypeError
from restitution.quantities import ADHESION_INPUTS, ALIASES, INPUTS, STATUS, SWEEP_OUTPUTS, key_of

Array = NDArray[Any]
Index = tuple[int, ...]
Region = tuple[slice, ...]
"""Part of a grid: from where to where along each dimension."""
Values = dict[str, Any]
"""Values of quantities by name: arrays, which broadcast against each other, and single values."""

# Coordinates must fit in memory; several axes may make more points.
MOST_POINTS = 10**8

_LARGEST_CHUNK = 65536
_SMALLEST_CHUNK = 1024
# Points of a chunk of impacts that take some 50 ms each, so that small sweeps use all cores.
_SLOW_CHUNK = 16
# Number of chunks that keeps the cores of one machine evenly busy in a small sweep.
_CHUNKS = 64


class Axis(ABC):
    """One dimension of a sweep, along which one quantity varies, or several together."""

    # Spacing: "linear", "logarithmic", "list" or "samples".
    scale = "list"

    @property
    @abstractmethod
    def size(self) -> int:
        """Number of points."""

    @abstractmethod
    def columns(self, dimension: str, start: int, stop: int) -> dict[str, Array]:
        """Return the values of each quantity at the points from `start` to `stop`."""

    def names(self, dimension: str) -> tuple[str, ...]:
        """Return the names of the quantities that it sets as the axis of the dimension."""
        return (dimension,)

    def corners(self, dimension: str) -> list[dict[str, Array]]:
        """Return the values that show whether the axis is admissible: those at its ends."""
        return [self.columns(dimension, place, place + 1) for place in sorted({0, self.size - 1})]


@dataclass(frozen=True)
class Linear(Axis):
    """Axis of n values from low to high at equal distances.

    Parameters
    ----------
    low, high : float
        First and last value, in SI units; low may be larger than high.
    n : int
        Number of values, from 1 to 10^8.

    Raises
    ------
    InputError
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
        check = positive if isinstance(self, Logarithmic) else finite
        for name in ("low", "high"):
            object.__setattr__(self, name, single(name, check(name, getattr(self, name))))
        object.__setattr__(self, "n", whole("n", self.n, 1, MOST_POINTS))

    @property
    def size(self) -> int:
        return self.n

    def values(self, start: int, stop: int) -> Array:
        """Return the values at the points from `start` to `stop`."""
        share = np.arange(start, stop) / max(self.n - 1, 1)
        # Both ends are exact to the last bit.
        return self.low * (1.0 - share) + self.high * share

    def columns(self, dimension: str, start: int, stop: int) -> dict[str, Array]:
        return {dimension: self.values(start, stop)}


@dataclass(frozen=True)
class Logarithmic(Linear):
    """Axis of n values from low to high at equal ratios.

    Parameters and errors are those of `Linear`; both ends must be > 0.

    Examples
    --------
    >>> Logarithmic(0.01, 100.0, 3).values(0, 3).tolist()
    [0.01, 1.0, 100.0]
    """

    scale = "logarithmic"

    def values(self, start: int, stop: int) -> Array:
        place = np.arange(start, stop)
        values = 10.0 ** Linear(math.log10(self.low), math.log10(self.high), self.n).values(start, stop)
        values[place == 0] = self.low
        values[(place == self.n - 1) & (place > 0)] = self.high
        return values


@dataclass(frozen=True, eq=False)
class Listed(Axis):
    """Axis of given values: an array of floats in SI units, or of objects such as materials."""

    items: Array

    @property
    def size(self) -> int:
        return self.items.size

    @property
    def is_numeric(self) -> bool:
        """Whether the values are numbers."""
        return self.items.dtype != object

    def labels(self, dimension: str) -> list[str]:
        """Return words for objects, all different."""
        words = [_text(item) or f"{dimension.replace('_', ' ')} {n}" for n, item in enumerate(self.items, start=1)]
        return [word if words.count(word) == 1 else f"{word} ({n})" for n, word in enumerate(words, start=1)]

    def columns(self, dimension: str, start: int, stop: int) -> dict[str, Array]:
        return {dimension: self.items[start:stop]}

    def corners(self, dimension: str) -> list[dict[str, Array]]:
        if self.is_numeric:
            return super().corners(dimension)
        return [self.columns(dimension, place, place + 1) for place in range(self.size)]


def read_axis(name: str, entry: Any) -> Any:
    """Return the values of a quantity as an axis, a single number as a float in SI, a single object unchanged."""
    quantity = INPUTS.get(key_of(name))
    if isinstance(entry, Axis):
        for column in entry.corners(name) if isinstance(entry, Linear) else ():
            value = float(column[name][0])
            quantity.check(value, name) if quantity else finite(name, value)
        return entry
    values: Any
    if quantity is not None:
        values = quantity.check(entry, name)
    elif isinstance(entry, (str, bytes, Mapping)) or callable(entry):
        return entry
    elif isinstance(entry, Sequence) and not all(map(_is_number, entry)):
        values = _objects(entry)
    else:
        try:
            values = finite(name, entry)
        except InputTypeError:
            if isinstance(entry, np.ma.MaskedArray):
                raise
            if not isinstance(entry, np.ndarray):
                return entry
            values = _objects(entry)
    if not isinstance(values, np.ndarray):
        return values
    if values.ndim != 1 or values.size == 0:
        raise InputError(name, rule=f"must be one-dimensional and hold a value, but has shape {values.shape}")
    return Listed(values)


def _is_number(item: Any) -> bool:
    return isinstance(item, (int, float, np.number)) and not isinstance(item, bool)


def _objects(values: Sequence[Any] | Array) -> Array:
    array = np.empty(len(values), dtype=object)
    array[:] = list(values)
    return array


def _text(item: Any) -> str:
    """Return the name of an object, or of the table that describes it; empty if it has none."""
    if isinstance(item, (str, int, float)):
        return str(item)
    if isinstance(item, Mapping):
        return next((str(item[key]) for key in ("name", "library", "file") if item.get(key)), "")
    return str(getattr(item, "name", None) or "")


@dataclass(frozen=True)
class Grid:
    """Product of named axes, in chunks."""

    axes: dict[str, Axis]
    fixed: dict[str, Any]  # quantities that all points share
    chunk_shape: tuple[int, ...]  # points along each dimension; chunks at the ends may be smaller

    @property
    def dimensions(self) -> tuple[str, ...]:
        """Names of the dimensions."""
        return tuple(self.axes)

    @property
    def shape(self) -> tuple[int, ...]:
        """Number of points along each dimension."""
        return tuple(axis.size for axis in self.axes.values())

    @property
    def n_points(self) -> int:
        """Number of points."""
        return math.prod(self.shape)

    @property
    def names(self) -> tuple[str, ...]:
        """Names of all quantities that are set."""
        return (*self.fixed, *(name for dim, axis in self.axes.items() for name in axis.names(dim)))

    @property
    def chunk_counts(self) -> tuple[int, ...]:
        """Number of chunks along each dimension."""
        return tuple(-(-n // part) for n, part in zip(self.shape, self.chunk_shape, strict=True))

    @property
    def n_chunks(self) -> int:
        """Number of chunks."""
        return math.prod(self.chunk_counts)

    def chunks(self) -> Iterator[Index]:
        """Yield the indices of all chunks, the last dimension running fastest."""
        # Iterators of products hold a list of each dimension.
        return (tuple(map(int, np.unravel_index(n, self.chunk_counts))) for n in range(self.n_chunks))

    def region(self, index: Index) -> Region:
        """Return the slices of a chunk."""
        return tuple(
            slice(i * part, min((i + 1) * part, n))
            for i, part, n in zip(index, self.chunk_shape, self.shape, strict=True)
        )

    def size(self, index: Index) -> int:
        """Return the number of points of a chunk."""
        return math.prod(lengths(self.region(index)))

    def values(self, index: Index) -> Values:
        """Return the values of all quantities in a chunk; arrays broadcast to its shape."""
        values = dict(self.fixed)
        for place, ((dimension, axis), part) in enumerate(zip(self.axes.items(), self.region(index), strict=True)):
            shape = [1] * len(self.axes)
            shape[place] = -1
            columns = axis.columns(dimension, part.start, part.stop)
            values |= {name: column.reshape(shape) for name, column in columns.items()}
        return values

    def corners(self) -> Iterator[Values]:
        """Yield points that show whether the axes are admissible: each end, with the others at their first value."""
        ends = [[_single(point) for point in axis.corners(dimension)] for dimension, axis in self.axes.items()]
        first = dict(self.fixed)
        for values in ends:
            first |= values[0]
        yield first
        yield from (first | point for values in ends for point in values[1:])


def _single(point: dict[str, Array]) -> Values:
    """Return the values of a point whose columns have one row."""
    return {name: column[0] if column.dtype == object else float(column[0]) for name, column in point.items()}


def part_of(values: Values, region: Region) -> Values:
    """Return the values in a part of a chunk."""

    def cut(column: Array) -> Array:
        places = (part if n > 1 else slice(None) for part, n in zip(region, column.shape, strict=True))
        return column[tuple(places)]

    return {name: cut(value) if isinstance(value, np.ndarray) else value for name, value in values.items()}


def boxes(region: Region, most: int) -> Iterator[Region]:
    """Yield parts of at most a number of points, halved along their longest dimension.

    Examples
    --------
    >>> [[(part.start, part.stop) for part in box] for box in boxes((slice(0, 2), slice(0, 5)), 4)]
    [[(0, 2), (0, 2)], [(0, 2), (2, 3)], [(0, 2), (3, 5)]]
    """
    if math.prod(lengths(region)) <= most:
        yield region
        return
    for half in halves(region):
        yield from boxes(half, most)


def halves(region: Region, place: int | None = None) -> tuple[Region, Region]:
    """Return both halves of a part along a dimension, by default its longest."""
    sizes = lengths(region)
    place = sizes.index(max(sizes)) if place is None else place
    start, stop = region[place].start, region[place].stop
    middle = (start + stop) // 2
    parts = slice(start, middle), slice(middle, stop)
    return (*region[:place], parts[0], *region[place + 1 :]), (*region[:place], parts[1], *region[place + 1 :])


def lengths(region: Region) -> tuple[int, ...]:
    """Return the number of points along each dimension of a part."""
    return tuple(part.stop - part.start for part in region)


def make_grid(
    axes: Mapping[str, Any], chunk: int | Mapping[str, int] | None = None, *, adhesive: bool = False
) -> Grid:
    """Return the grid of axes and single values; `axes` and `chunk` are those of `restitution.sweep`.

    Adhesive impacts are slow, and have smaller chunks.

    Examples
    --------
    >>> grid = make_grid({"velocity": [0.1, 1.0, 10.0], "nu": [0.3, 0.5], "mass": 0.01})
    >>> grid.dimensions, grid.shape, grid.fixed
    (('velocity', 'poisson_ratio'), (3, 2), {'mass': 0.01})
    """
    grid: dict[str, Axis] = {}
    fixed: dict[str, Any] = {}
    taken: set[str] = {*SWEEP_OUTPUTS, STATUS}
    for alias, entry in axes.items():
        name = ALIASES.get(alias, alias)
        axis = read_axis(name, entry)
        (grid if isinstance(axis, Axis) else fixed)[name] = axis
        for quantity in {name, *axis.names(name)} if isinstance(axis, Axis) else {name}:
            if quantity in taken:
                is_output = quantity in SWEEP_OUTPUTS or quantity == STATUS
                why = "is an output" if is_output else "is set by another axis too"
                raise InputError("axes", rule=f"{quantity} {why}")
            taken.add(quantity)
    shape = tuple(axis.size for axis in grid.values())
    least = _SLOW_CHUNK if adhesive or any(key_of(name) in ADHESION_INPUTS for name in axes) else _SMALLEST_CHUNK
    return Grid(grid, fixed, _chunk_shape(tuple(grid), shape, chunk, least))


def _chunk_shape(
    dimensions: tuple[str, ...], shape: tuple[int, ...], chunk: int | Mapping[str, int] | None, least: int
) -> tuple[int, ...]:
    if isinstance(chunk, Mapping):
        for name, size in chunk.items():
            if name not in dimensions:
                raise InputError("chunk", name, f"must name a dimension; there are {', '.join(dimensions)}")
            whole(f"chunk.{name}", size, 1)
        return tuple(min(chunk.get(name, n), n) for name, n in zip(dimensions, shape, strict=True))
    if chunk is not None:
        whole("chunk", chunk, 1)
    every = math.prod(shape)
    room = min(chunk, every) if chunk else min(_LARGEST_CHUNK, max(least, every // _CHUNKS))
    # Nearly as long along each dimension, so that a slice along any of them touches few chunks.
    parts = dict[int, int]()
    for rank, n in sorted(enumerate(shape), key=lambda item: item[1]):
        parts[rank] = min(n, max(1, int((room * (1.0 + 1e-12)) ** (1.0 / (len(shape) - len(parts))))))
        room //= parts[rank]
    return tuple(parts[rank] for rank in range(len(shape)))


# Random draws along an axis: several quantities, each with its distribution.

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


def _seed(rng: Any) -> int:
    """Return the seed that a number is, or that a generator draws; every chunk of a sweep begins with it."""
    if rng is None or isinstance(rng, np.random.Generator):
        return int(np.random.default_rng(rng).integers(2**63))
    return whole("rng", rng, 0)


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
    rng : int, numpy.random.Generator or None
        Seed of the draws: the same one gives the same draws. A generator gives a seed of its own, None a fresh one;
        `rng` is this seed afterwards, so that a sweep can be repeated.

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
    >>> from restitution.sweeps.grid import LogNormal, Uniform
    >>> draws = Samples(4, {"mass": Uniform(1.0, 2.0), "radius": LogNormal(0.01, 0.1)}, rng=1)
    >>> sorted(draws.columns("draw", 0, 4))
    ['mass', 'radius']
    """

    n: int
    distributions: Mapping[str, Distribution]
    method: Method = "sobol"
    rng: int | np.random.Generator | None = 0
    _hypercube: dict[str, Any] = field(default_factory=dict, repr=False, compare=False)
    scale = "samples"

    def __post_init__(self) -> None:
        object.__setattr__(self, "n", whole("n", self.n, 1, MOST_POINTS))
        one_of("method", self.method, ("sobol", "latin_hypercube"))
        object.__setattr__(self, "rng", _seed(self.rng))
        given = mapping("distributions", self.distributions)
        if not given:
            raise InputError("distributions", rule="must name at least one quantity")
        named = {ALIASES.get(name, name): drawn for name, drawn in given.items()}
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
        """Return all medians; some draws may be out of range."""
        return [{name: self._drawn(name, np.array([0.5])) for name in self.distributions}]

    def _drawn(self, name: str, shares: Array) -> Array:
        quantity = INPUTS.get(key_of(name))
        low, high = (quantity.low, quantity.high) if quantity else (-math.inf, math.inf)
        try:
            return self.distributions[name].quantiles(shares, low, high)
        except InputError as error:
            raise error.within(name) from None

    def _shares(self, start: int, stop: int) -> Array:
        from scipy.stats import qmc

        # Newer versions of SciPy call it rng and take both.
        options: dict[str, Any] = {"seed": self.rng}
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
