"""The points of a sweep: named axes, their product, and the chunks that it is computed in."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from restitution.checks import whole
from restitution.errors import InputError
from restitution.quantities import ALIASES, STATUS, SWEEP_OUTPUTS
from restitution.sweeps.axes import Axis, Linear, Listed, read_axis
from restitution.sweeps.samples import Samples

Array = NDArray[Any]
Index = tuple[int, ...]

_LARGEST_CHUNK = 65536
_SMALLEST_CHUNK = 1024
# So many chunks keep the cores of one machine evenly busy where the sweep is small.
_CHUNKS = 64


@dataclass(frozen=True)
class Grid:
    """Product of named axes, in chunks.

    Attributes
    ----------
    axes : dict of str to Axis
        Axis of each dimension, in the order of the dimensions.
    fixed : dict of str to object
        Quantities that all points share.
    chunk_shape : tuple of int
        Points of a chunk along each dimension; those at the ends may be smaller.
    """

    axes: dict[str, Axis]
    fixed: dict[str, Any]
    chunk_shape: tuple[int, ...]

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
        """Indices of all chunks, the last dimension running fastest."""
        return _indices(self.chunk_counts)

    def region(self, index: Index) -> tuple[slice, ...]:
        """Where a chunk lies."""
        return tuple(
            slice(i * part, min((i + 1) * part, n))
            for i, part, n in zip(index, self.chunk_shape, self.shape, strict=True)
        )

    def size(self, index: Index) -> int:
        """Number of points of a chunk."""
        return math.prod(part.stop - part.start for part in self.region(index))

    def points(self, index: Index) -> Points:
        """Return the points of a chunk."""
        region = self.region(index)
        along = [
            axis.columns(dim, part.start, part.stop)
            for (dim, axis), part in zip(self.axes.items(), region, strict=True)
        ]
        return Points(tuple(part.stop - part.start for part in region), along, self.fixed)

    def corners(self) -> Iterator[dict[str, Array]]:
        """Points that show what is wrong with an axis: its ends, the others being at their first."""
        first = Points((), [], self.fixed).part(0, 1)
        ends = {dim: axis.corners(dim) for dim, axis in self.axes.items()}
        for values in ends.values():
            first |= values[0]
        yield first
        for values in ends.values():
            for changed in values[1:]:
                yield first | changed


@dataclass(frozen=True)
class Points:
    """Points of a chunk; `part` gives the values of all quantities at some of them.

    Attributes
    ----------
    shape : tuple of int
        Points along each dimension.
    along : list of dict
        Values of the quantities along each dimension.
    fixed : dict
        Quantities that all points share.
    """

    shape: tuple[int, ...]
    along: list[dict[str, Array]]
    fixed: dict[str, Any]

    @property
    def size(self) -> int:
        """Number of points."""
        return math.prod(self.shape)

    def part(self, start: int, stop: int) -> dict[str, Array]:
        """Values of all quantities from one point to another, in the order of the raveled chunk."""
        columns: dict[str, Array] = {}
        for name, value in self.fixed.items():
            column = np.empty(stop - start, dtype=np.float64 if isinstance(value, float) else object)
            column.fill(value)
            columns[name] = column
        places = np.unravel_index(np.arange(start, stop), self.shape) if self.shape else ()
        for quantities, place in zip(self.along, places, strict=True):
            for name, values in quantities.items():
                columns[name] = values[place]
        return columns


def make_grid(axes: Mapping[str, Any], chunk: int | Mapping[str, int] | None = None) -> Grid:
    """Return the grid of the given axes.

    Parameters
    ----------
    axes : dict
        By name of the quantity: `Linear`, `Logarithmic`, a sequence, or a single value; by name of the
        dimension: `Samples`.
    chunk : int or dict of str to int, optional
        Points of a chunk, or points along each dimension.

    Returns
    -------
    Grid

    Raises
    ------
    InputError
        If a value is out of range, or a quantity is set twice.

    Examples
    --------
    >>> grid = make_grid({"velocity": [0.1, 1.0, 10.0], "nu": [0.3, 0.5], "mass": 0.01})
    >>> grid.dimensions, grid.shape, grid.fixed
    (('velocity', 'poisson_ratio'), (3, 2), {'mass': 0.01})
    """
    made: dict[str, Axis] = {}
    fixed: dict[str, Any] = {}
    taken: set[str] = {*SWEEP_OUTPUTS, STATUS}
    for given_name, given in axes.items():
        name = ALIASES.get(given_name, given_name)
        axis: Any = given if isinstance(given, Samples) else read_axis(name, given)
        is_axis = isinstance(axis, (Samples, Linear, Listed))
        for one in {name, *axis.names(name)} if is_axis else {name}:
            if one in taken:
                why = "is an output" if one in SWEEP_OUTPUTS or one == STATUS else "is set by another axis too"
                raise InputError("axes", wanted=f"{one} {why}")
            taken.add(one)
        if is_axis:
            made[name] = axis
        else:
            fixed[name] = axis
    shape = tuple(axis.size for axis in made.values())
    return Grid(made, fixed, _chunk_shape(tuple(made), shape, chunk))


def _indices(counts: tuple[int, ...]) -> Iterator[Index]:
    # As np.ndindex, which newer versions of NumPy give a list of each dimension.
    if not counts:
        yield ()
        return
    for first in range(counts[0]):
        for rest in _indices(counts[1:]):
            yield (first, *rest)


def _chunk_shape(
    dimensions: tuple[str, ...], shape: tuple[int, ...], chunk: int | Mapping[str, int] | None
) -> tuple[int, ...]:
    if isinstance(chunk, Mapping):
        for name, size in chunk.items():
            if name not in dimensions:
                raise InputError("chunk", name, f"must name a dimension; there are {', '.join(dimensions)}")
            whole(f"chunk.{name}", size, 1)
        return tuple(min(chunk.get(name, n), n) for name, n in zip(dimensions, shape, strict=True))
    if chunk is not None:
        whole("chunk", chunk, 1)
    room = chunk or min(_LARGEST_CHUNK, max(_SMALLEST_CHUNK, math.prod(shape) // _CHUNKS))
    parts: list[int] = []
    for n in reversed(shape):
        parts.append(min(n, max(room, 1)))
        room //= parts[-1]
    return tuple(reversed(parts))
