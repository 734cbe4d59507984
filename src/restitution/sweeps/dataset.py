"""The result of a sweep as an xarray.Dataset: its variables, and results that stay in memory."""

from __future__ import annotations

import contextlib
import math
import os
import warnings
from collections.abc import Iterator
from pathlib import Path
from threading import Lock
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from restitution.doubts import Tally
from restitution.errors import InputError, RestitutionWarning
from restitution.impact.status import Status
from restitution.quantities import NOT_COMPUTED, STATUS, SWEEP_OUTPUTS, input_attributes
from restitution.sweeps.grid import Grid, Index, Listed
from restitution.sweeps.plan import Plan

if TYPE_CHECKING:
    import xarray as xr

Array = NDArray[Any]

# Linux grants more memory than there is, and ends a process that uses it.
_SHARE_OF_MEMORY = 0.5
# Time of an impact on one core [s], as in docs/sweeps.md, and time of a sweep [h] from which a store is advised.
_PER_IMPACT, _LONG = 3e-5, 1.0
# Attribute of a coordinate of numbers that represent words.
_LABELS = "labels"
_STATUS_ATTRIBUTES: dict[str, Any] = {
    "long_name": "how the solve ended",
    "flag_values": [int(status) for status in Status],
    "flag_meanings": " ".join(status.name.lower() for status in Status),
}


class Field(NamedTuple):
    """A variable of the result; `fill` is the value of points that are not computed yet."""

    dimensions: tuple[str, ...]
    dtype: str
    fill: float
    attributes: dict[str, Any]


def output_fields(plan: Plan) -> dict[str, Field]:
    """Return the computed variables of a sweep by name."""
    dimensions = plan.grid.dimensions
    fields = {name: Field(dimensions, "float64", np.nan, SWEEP_OUTPUTS[name].attributes) for name in plan.outputs}
    return fields | {STATUS: Field(dimensions, "int8", NOT_COMPUTED, _STATUS_ATTRIBUTES)}


def coordinate_fields(grid: Grid) -> dict[str, Field]:
    """Return the quantities along the axes, and the numbers that all points share, by name."""
    fields = {
        name: Field((), "float64", np.nan, input_attributes(name))
        for name, value in grid.fixed.items()
        if isinstance(value, float)
    }
    for dimension, axis in grid.axes.items():
        for name in axis.names(dimension):
            attributes: dict[str, Any] = input_attributes(name) | {"scale": axis.scale}
            if isinstance(axis, Listed) and not axis.is_numeric:
                labels = {_LABELS: axis.labels(dimension)}
                fields[name] = Field((dimension,), "int32", NOT_COMPUTED, attributes | labels)
            else:
                fields[name] = Field((dimension,), "float64", np.nan, attributes)
    return fields


def coordinate_blocks(grid: Grid, size: int) -> Iterator[tuple[str, Any, Any]]:
    """Yield the values of the coordinates in pieces: name, place, values; numbers represent words."""
    for name, value in grid.fixed.items():
        if isinstance(value, float):
            yield name, ..., value
    for dimension, axis in grid.axes.items():
        for start in range(0, axis.size, size):
            stop = min(start + size, axis.size)
            for name, values in axis.columns(dimension, start, stop).items():
                yield name, slice(start, stop), np.arange(start, stop) if values.dtype == object else values


class InMemory:
    """Results of a sweep in memory, without a path."""

    path = None

    def __init__(self, plan: Plan) -> None:
        self._plan = plan
        self._tally, self._lock = Tally(), Lock()
        self._fields = output_fields(plan)
        n = plan.grid.n_points
        needed = n * sum(np.dtype(field.dtype).itemsize for field in self._fields.values())
        cores = os.cpu_count() or 1
        hours = n * _PER_IMPACT / 3600.0 / cores
        takes, time = f"{n} points take {needed / 1e9:.3g} GB", f"about {hours:.2g} h on {cores} cores"
        why = f"{takes}, too much for the memory of this machine; give out=, a store, which takes any number"
        refusal = InputError("axes", wanted=f"{why} ({time}) and resumes")
        if needed > _SHARE_OF_MEMORY * _memory():
            raise refusal
        if hours > _LONG:
            what = f"{takes} and {time}, and an interrupt loses them; with out=, a store, the same call resumes"
            warnings.warn(RestitutionWarning("long", what), stacklevel=4)
        try:
            self._arrays = {k: np.full(plan.grid.shape, v.fill, dtype=v.dtype) for k, v in self._fields.items()}
        except MemoryError:
            raise refusal from None

    def keep(self, index: Index, results: dict[str, Array], tally: Tally) -> None:
        """Keep the results of a chunk."""
        with self._lock:
            self._tally.merge(tally)
        for name, values in results.items():
            self._arrays[name][self._plan.grid.region(index)] = values

    def statuses(self) -> Iterator[Array]:
        """Yield all statuses."""
        yield self._arrays[STATUS]

    def dataset(self) -> xr.Dataset:
        """Return the results with their coordinates."""
        import xarray as xr

        grid = self._plan.grid
        fields = coordinate_fields(grid)
        shapes = {name: [grid.axes[dim].size for dim in field.dimensions] for name, field in fields.items()}
        values = {name: np.empty(shapes[name], field.dtype) for name, field in fields.items()}
        for name, place, part in coordinate_blocks(grid, max(grid.shape, default=1)):
            values[name][place] = part
        dataset = xr.Dataset(
            {name: (field.dimensions, self._arrays[name], field.attributes) for name, field in self._fields.items()},
            {name: (field.dimensions, values[name], field.attributes) for name, field in fields.items()},
            self._plan.attributes | self._tally.attributes(grid.n_points),
        )
        return in_words(dataset)


def _memory() -> float:
    """Memory for this process [bytes]: that of the machine, or of its control group; infinite if it is not known."""
    try:
        whole = float(os.sysconf("SC_PAGE_SIZE")) * os.sysconf("SC_PHYS_PAGES")
    except (AttributeError, ValueError, OSError):
        return math.inf
    for limit in ("/sys/fs/cgroup/memory.max", "/sys/fs/cgroup/memory/memory.limit_in_bytes"):
        # Without a limit the file is absent or holds a word.
        with contextlib.suppress(OSError, ValueError):
            whole = min(whole, float(Path(limit).read_text()))
    return whole


def in_words(dataset: xr.Dataset) -> xr.Dataset:
    """Replace coordinates of numbers that represent words by these words."""
    for name, coordinate in dataset.coords.items():
        if _LABELS in coordinate.attrs:
            attributes = dict(coordinate.attrs)
            words = np.array(attributes.pop(_LABELS))[coordinate.values]
            dataset = dataset.assign_coords({name: (coordinate.dims, words, attributes)})
    return dataset
