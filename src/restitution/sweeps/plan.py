"""Plan of a sweep: what varies over which points, the outputs, and a description with a hash."""

from __future__ import annotations

import contextlib
import dataclasses
import functools
import hashlib
import inspect
import json
import math
import os
import warnings
from collections.abc import Callable, Collection, Iterator, Mapping, Sequence
from enum import Enum
from functools import cached_property
from importlib.metadata import version
from pathlib import Path
from threading import Lock
from types import CodeType, ModuleType
from typing import TYPE_CHECKING, Any, NamedTuple, Protocol, runtime_checkable

import numpy as np
from numpy.typing import NDArray

from restitution.contact.profiles import Parabola
from restitution.errors import InputError, InputTypeError, RestitutionWarning
from restitution.impact.adhesive import adhesive_columns, attraction_numbers
from restitution.impact.batch import Batch
from restitution.impact.oblique import normal_rtol, sliding_numbers, solve_sliding
from restitution.impact.problem import Impact, require_outputs
from restitution.impact.status import Status
from restitution.material.classical import standard_solid
from restitution.quantities import (
    ENERGIES,
    NOT_COMPUTED,
    OBLIQUE,
    STATUS,
    SWEEP_OUTPUTS,
    VALIDITY,
    input_attributes,
    needs,
)
from restitution.sweeps.grid import Grid, Index, Listed, Region, Values, boxes, halves, lengths, part_of
from restitution.tally import Tally
from restitution.validity import COLUMNS, Numbers, numbers
from restitution.variation import HeldElastic, check_names, check_rivals, varied

if TYPE_CHECKING:
    import xarray as xr


Array = NDArray[Any]
Tick = Callable[[int], None]

# Points that are built and solved at a time, which limits the memory for chunks of any size.
_BLOCK = 4096
# Impacts that are kept, one for each combination of the quantities that need separate impacts.
_MOST_PREPARED = 4096
# Numbers of an impact that the validity report takes, and those that a problem without dimensions has.
_BODIES = ("velocity", "mass", "impedance")
_OF_ADHESION = ("zone_width",)
_RATIOS = ("poisson_ratio", "instantaneous_poisson_ratio", "lowest_poisson_ratio", "highest_poisson_ratio")
# In a description the hash represents a longer array.
_LONG_AXIS = 1000


# What a sweep varies: an impact, a function that builds impacts, or the paper's problem without dimensions.

Vary = Callable[[Values], Impact]
"""Returns an impact with other numbers in SI, which broadcast."""


class Template(Protocol):
    """What a sweep varies."""

    @property
    def dimensionless(self) -> bool:
        """Whether the bodies are dimensionless, so that only the Poisson ratio can be checked."""
        ...

    def builds_with(self, names: tuple[str, ...]) -> tuple[str, ...]:
        """Return the names whose combinations need a separate impact each; refuse unknown names."""
        ...

    def prepare(self, values: Values) -> Vary:
        """Return how one combination of their values varies with the other names, or raise an `InputError`."""
        ...


@dataclasses.dataclass(frozen=True)
class ImpactTemplate:
    """A single impact; axes set numbers of the body, the profile and the material."""

    impact: Impact
    held: HeldElastic = "bulk_modulus"
    dimensionless: bool = False

    def __post_init__(self) -> None:
        if self.impact.shape:
            rule = f"has shape {self.impact.shape}; must be a single impact, axes make the others"
            raise InputError("base", rule=rule)

    def builds_with(self, names: tuple[str, ...]) -> tuple[str, ...]:
        check_names(self.impact, names)
        return ()

    def prepare(self, values: Values) -> Vary:
        return functools.partial(varied, self.impact, held=self.held)


@dataclasses.dataclass(frozen=True)
class BuilderTemplate:
    """A function that builds a single impact from values of axes, by the names of its arguments."""

    build: Callable[..., Impact]
    held: HeldElastic = "bulk_modulus"
    dimensionless = False

    def builds_with(self, names: tuple[str, ...]) -> tuple[str, ...]:
        try:
            parameters = inspect.signature(self.build).parameters.values()
        except (TypeError, ValueError):  # some functions and types in C have no signature
            raise InputTypeError("base", self.build, "must be a function with named parameters") from None
        if any(each.kind is each.VAR_KEYWORD for each in parameters):
            return names
        check_rivals(tuple(name for name in names if all(name != each.name for each in parameters)))
        for each in parameters:
            if each.default is each.empty and each.name not in names:
                raise InputError("axes", rule=f"must have {each.name!r}, which the function takes")
        return tuple(each.name for each in parameters if each.name in names)

    def prepare(self, values: Values) -> Vary:
        impact = self.build(**values)
        if not isinstance(impact, Impact):
            raise InputTypeError("base", rule=f"returned {impact!r}; must return an Impact")
        if impact.shape:
            raise InputTypeError("base", rule=f"returned an impact of shape {impact.shape}; must return a single one")
        return functools.partial(varied, impact, held=self.held)


def dimensionless_template(names: Collection[str]) -> ImpactTemplate:
    """Return an impact of mass, radius, velocity and equilibrium modulus 1; axes set nu, p2, p3, or are refused."""
    if missing := [name for name in ("poisson_ratio", "p2", "p3") if name not in names]:
        raise InputError("axes", rule=f"must have {', '.join(missing)} where no impact is given")
    solid = standard_solid(1.0, 1.0, 1.0, poisson_ratio=0.5)
    return ImpactTemplate(Impact(solid, Parabola(1.0), mass=1.0, velocity=1.0), dimensionless=True)


Part = tuple[Any, Impact, Batch | None]
"""Places of rows, their impacts, and the impacts as a batch; None with adhesion."""


class Impacts(NamedTuple):
    """Impacts of a part of a sweep: the shape to which their points are reduced, and what one batch holds of them."""

    shape: tuple[int, ...]
    parts: list[Part]


class Interrupted(Exception):
    """Raised by `tick` to end the work on a chunk."""


@dataclasses.dataclass(frozen=True)
class Plan:
    """A sweep before it runs: the template, the points, and the names of the requested outputs."""

    template: Template
    grid: Grid
    outputs: tuple[str, ...]
    rtol: float  # tolerance of e
    title: str = ""
    source: str = ""  # text that the sweep was read from

    @cached_property
    def description(self) -> dict[str, Any]:
        """Everything on which the results depend."""
        return {
            "base": describe(self.template),
            "axes": describe(self.grid.axes),
            "fixed": describe(self.grid.fixed),
            "outputs": list(self.outputs),
            "rtol": self.rtol,
            "chunk": list(self.grid.chunk_shape),
            "version": version("restitution"),
        }

    @cached_property
    def attributes(self) -> dict[str, Any]:
        """Attributes of the result."""
        release = version("restitution")
        return {
            **({"title": self.title} if self.title else {}),
            "source": f"restitution {release}",
            "version": release,
            "method": "exact",
            "rtol": self.rtol,
            **({"case": self.source} if self.source else {}),
            "sweep": text_of(self.description),
            "hash": hash_of(self.description),
        }

    @property
    def variables(self) -> tuple[str, ...]:
        """Names of the computed variables; the status last."""
        return (*self.outputs, STATUS)

    @property
    def slides(self) -> bool:
        """Whether the sweep has outputs of the tangential motion."""
        return not set(OBLIQUE).isdisjoint(self.outputs)

    @property
    def adheres(self) -> bool:
        """Whether the first impact has adhesion."""
        parts = self._impacts(next(self.grid.corners())).parts
        return any(impact.adhesion is not None for _, impact, _ in parts)

    @cached_property
    def _apart(self) -> tuple[str, ...]:
        """Quantities whose combinations need a separate impact each."""
        return self.template.builds_with(self.grid.names)

    @cached_property
    def _prepared(self) -> dict[tuple[Any, ...], Vary]:
        """Impacts of some combinations."""
        return {}

    def __getstate__(self) -> dict[str, Any]:
        # Another process derives the properties again.
        return {field.name: getattr(self, field.name) for field in dataclasses.fields(self)}

    @property
    def impact(self) -> Impact:
        """The impact of the template itself."""
        return self.template.prepare({})({})

    def check(self) -> None:
        """Refuse axes whose ends give no admissible impact, with an `InputError`."""
        for point in self.grid.corners():
            for _, impact, _ in self._impacts(point).parts:
                require_outputs(impact, self.outputs)

    def _impacts(self, values: Values) -> Impacts:
        """Return the impacts of values of all quantities, which broadcast."""
        first = {name: values[name] for name in self._apart}
        # The lists of objects exist as long as the sweep, so that an identity belongs to a single object.
        key = tuple(value if isinstance(value, float) else id(value) for value in first.values())
        vary = self._prepared.get(key)
        if vary is None:
            # Another thread may clear it too.
            if len(self._prepared) >= _MOST_PREPARED:
                self._prepared.clear()
            self._prepared[key] = vary = self.template.prepare(first)
        impact = vary({name: value for name, value in values.items() if name not in first})
        parts = impact.parts()
        if impact.adhesion is not None:
            return Impacts(impact.shape, [(places, part, None) for places, part in parts])
        return Impacts(impact.shape, [(places, part, Batch.from_impact(part)) for places, part in parts])

    def _admissible(self, chunk: Values, region: Region, tick: Tick) -> Iterator[tuple[Region, Impacts]]:
        """Yield the impacts of a part of a chunk, by parts of it; points that are not admissible belong to none.

        `tick` is called from time to time with 0, and ends the work by raising.
        """
        tick(0)
        values, pieces = part_of(chunk, region), None
        for name, value in values.items():
            if isinstance(value, np.ndarray) and (name in self._apart or value.dtype == object):
                if value.size > 1:
                    pieces = halves(region, value.shape.index(value.size))
                    break
                values[name] = value.item()
        if pieces is None:
            try:
                impacts = self._impacts(values)
            except ValueError:
                pieces = halves(region) if math.prod(lengths(region)) > 1 else ()
            else:
                yield region, impacts
                return
        for piece in pieces:
            yield from self._admissible(chunk, piece, tick)

    def compute(self, index: Index, tick: Tick = lambda _: None, tally: Tally | None = None) -> dict[str, Array]:
        """Compute a chunk: `variables` in its shape, NaN where there is no result.

        `tick` is called with the number of points done since the last call, and ends the work by raising. `tally`
        counts the impacts that exceed the assumptions of the theory.
        """
        chunk, shape = self.grid.values(index), lengths(self.grid.region(index))
        results = {name: np.full(shape, np.nan) for name in self.outputs}
        results[STATUS] = np.full(shape, Status.INADMISSIBLE, dtype=np.int8)
        checked = set(VALIDITY).intersection(self.outputs)
        for region in boxes(tuple(slice(0, n) for n in shape), _BLOCK):
            regions = list(self._admissible(chunk, region, tick))
            starts = np.cumsum([0, *(math.prod(impacts.shape) for _, impacts in regions)])
            parts = [
                (start + places, part, batch)
                for start, (_, impacts) in zip(starts, regions, strict=False)
                for places, part, batch in impacts.parts
            ]
            rows = self._solve(parts, int(starts[-1]), tick)
            if parts and (checked or tally is not None):
                numbers = self._numbers(parts, rows)
                rows |= {name: getattr(numbers, name) for name in checked}
                if tally is not None:
                    tally.add(self._counted(numbers, rows))
            for (region_of, impacts), start, stop in zip(regions, starts[:-1], starts[1:], strict=True):
                for name in results:
                    results[name][region_of] = rows[name][start:stop].reshape(impacts.shape)
            # Points that are not admissible, or that some axis does not change, also count as done.
            tick(math.prod(lengths(region)) - int(starts[-1]))
        return results

    def _solve(self, parts: list[Part], count: int, tick: Tick) -> dict[str, Array]:
        """Return the outputs of all rows of the parts of impacts."""
        done = 0

        def progress(finished: int, _: int) -> None:
            nonlocal done
            tick(finished - done)
            done = finished

        energy, pressure = needs(self.outputs, ENERGIES), needs(self.outputs, {"max_pressure"})
        rows = {name: np.full(count, np.nan) for name in (*self.outputs, *COLUMNS, *_OF_ADHESION, STATUS)}
        batches = [(places, batch) for places, _, batch in parts if batch is not None]
        for places, batch in Batch.joined(batches):
            done = 0
            report, rtol = (None, normal_rtol(self.rtol)) if self.slides else (progress, self.rtol)
            columns = batch.solve(rtol, workers=1, progress=report, energy=energy, pressure=pressure)
            for name in rows.keys() & columns.keys():
                rows[name][places] = columns[name]
        for places, impact, batch in parts:
            if batch is None:
                done, columns = 0, adhesive_columns(impact, self.rtol, workers=1, progress=progress)
                for name in rows.keys() & columns.keys():
                    rows[name][places] = columns[name]
        for places, impact, _ in parts if self.slides else ():
            done, at = 0, places.reshape(-1)
            normal = {name: rows[name][at] for name in (*COLUMNS, STATUS)}
            columns = solve_sliding(impact, normal, self.rtol, 1, progress).columns
            for name in rows.keys() & columns.keys():
                rows[name][at] = columns[name]
        return rows

    def _numbers(self, parts: list[Part], rows: dict[str, Array]) -> Numbers:
        """Return the numbers of the validity report for all rows of the parts of impacts."""
        singles = [(places, part) for places, part, _ in parts if _is_plain(part)]
        kinds: list[tuple[Any, Any, dict[str, Any]]] = []
        if singles:
            bodies = {name: np.array([getattr(part, name) for _, part in singles]) for name in _BODIES}
            places = np.concatenate([places for places, _ in singles])
            kinds.append((places, [part.contact for _, part in singles], bodies))
        for places, part, _ in parts:
            if not _is_plain(part):
                bodies = {name: getattr(part, name) for name in _BODIES}
                at = places.reshape(part.shape)
                if part.friction is not None:
                    bodies |= sliding_numbers(part, {name: rows[name][at] for name in COLUMNS})
                if part.adhesion is not None:
                    bodies |= attraction_numbers(part, {name: rows[name][at] for name in _OF_ADHESION})
                kinds.append((at, part.contact, bodies))
        columns = {name: np.empty(rows[STATUS].size) for name in Numbers._fields}
        for places, contact, bodies in kinds:
            compared = numbers(contact, **{name: rows[name][places] for name in COLUMNS}, **bodies)
            for name, column in columns.items():
                column[places.reshape(-1)] = getattr(compared, name)
        if self.template.dimensionless:
            # Without dimensions there are no other assumptions.
            columns |= {name: np.full(column.size, np.nan) for name, column in columns.items() if name not in _RATIOS}
        return Numbers(**columns)

    def _counted(self, numbers: Numbers, rows: dict[str, Array]) -> Numbers:
        """Return the rows that count: of impacts without dimensions those with a result."""
        if not self.template.dimensionless:
            return numbers
        there = ~np.isnan(rows["contact_time"])
        return Numbers(*(column[there] for column in numbers))


def _is_plain(impact: Impact) -> bool:
    """Return whether an impact is a single one without friction and adhesion; many of these make one report."""
    return not impact.shape and impact.friction is None and impact.adhesion is None


@runtime_checkable
class Described(Protocol):
    """A dataclass with its own description, if its fields do not identify it."""

    def describe(self) -> Any:
        """Return a description that identifies it, in the types of JSON."""


def describe(value: Any) -> Any:
    """Return a description that identifies a value, in the types of JSON; floats to the last bit.

    Takes numbers, texts, sequences, mappings, arrays, dataclasses such as `Impact`, and functions; refuses others.

    Examples
    --------
    >>> from restitution.contact.profiles import Parabola
    >>> describe(Parabola(radius=0.01))
    {'type': 'Parabola', 'radius': 0.01}
    """
    if value is None or isinstance(value, (bool, int, str)):
        return value
    if isinstance(value, Enum):
        return value.name
    if isinstance(value, (float, np.number)):
        return float(value)
    if isinstance(value, np.ndarray):
        if value.size > _LONG_AXIS and value.dtype != object:
            return {"shape": list(value.shape), "sha256": hashlib.sha256(value.tobytes()).hexdigest()}
        return describe(value.tolist())
    if isinstance(value, Path):
        return str(value)
    if dataclasses.is_dataclass(value) and not isinstance(value, type):
        if isinstance(value, Described):
            return value.describe()
        fields = {
            field.name: describe(getattr(value, field.name))
            for field in dataclasses.fields(value)
            if field.compare and getattr(value, field.name) is not None
        }
        return {"type": type(value).__name__, **fields}
    if isinstance(value, Mapping):
        return {str(key): describe(item) for key, item in value.items()}
    if isinstance(value, (set, frozenset)):
        return sorted(map(describe, value), key=str)
    if isinstance(value, Sequence):
        return [describe(item) for item in value]
    if isinstance(value, functools.partial):
        return {"partial": describe(value.func), "arguments": describe([*value.args, value.keywords])}
    if callable(value):
        return _describe_function(value)
    raise InputTypeError("axes", value, "must be a number, a text, a dataclass or a function, or consist of these")


def _describe_function(function: Callable[..., Any]) -> Any:
    """Describe a function by its name, its source, its defaults, and the variables outside it that it uses."""
    function = inspect.unwrap(function)
    name = getattr(function, "__qualname__", type(function).__qualname__)
    code = getattr(function, "__code__", None)
    text, used = "", dict(getattr(function, "__dict__", {}))
    try:
        text = inspect.getsource(function)
    except (OSError, TypeError):
        if code is not None:
            constants = [value for value in code.co_consts if not isinstance(value, CodeType)]
            text = repr((code.co_code.hex(), code.co_names, constants))
    with contextlib.suppress(TypeError, ValueError):
        variables = inspect.getclosurevars(function)
        used |= {**variables.nonlocals, **variables.globals}
    for name_of in ("__defaults__", "__kwdefaults__", "__self__"):
        used[name_of] = getattr(function, name_of, None)
    held: dict[str, Any] = {}
    for key, value in used.items():
        if isinstance(value, (ModuleType, type)):
            continue
        try:
            # Functions that it calls count by their names, because they may call each other.
            held[key] = value.__qualname__ if inspect.isroutine(value) else describe(value)
        except (TypeError, ValueError, RecursionError):
            held[key] = "?"
    return {"function": name, "text": text, "holds": held}


def text_of(description: Any) -> str:
    """Return a description as JSON, the same for the same description."""
    return json.dumps(description, ensure_ascii=False, separators=(",", ":"))


def hash_of(description: Any) -> str:
    """Return the SHA-256 of a description."""
    return hashlib.sha256(text_of(description).encode()).hexdigest()


# The result of a sweep as an xarray.Dataset: its variables, and results that stay in memory.

# Linux grants more memory than there is, and ends a process that uses it.
_SHARE_OF_MEMORY = 0.5
# Time of an impact on one core [s], as in docs/sweeps.md, and time of a sweep [h] from which a store is advised.
_PER_IMPACT, _PER_OBLIQUE, _PER_ADHESIVE, _LONG = 3e-5, 6e-3, 0.05, 1.0
# Attribute of a coordinate of numbers that represent words.
_LABELS = "labels"
_STATUS_ATTRIBUTES: dict[str, Any] = {"long_name": "how the solve ended", **Status.attributes()}


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
        seconds = _PER_ADHESIVE if plan.adheres else _PER_OBLIQUE if plan.slides else _PER_IMPACT
        hours = n * seconds / 3600.0 / cores
        takes, time = f"{n} points take {needed / 1e9:.3g} GB", f"about {hours:.2g} h on {cores} cores"
        why = f"{takes}, too much for the memory of this machine; give out=, a store, which takes any number"
        refusal = InputError("axes", rule=f"{why} ({time}) and resumes")
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
        values = {name: part for name, _, part in coordinate_blocks(grid, max(grid.shape, default=1))}
        dataset = xr.Dataset(
            {name: (field.dimensions, self._arrays[name], field.attributes) for name, field in self._fields.items()},
            {name: (field.dimensions, values[name], field.attributes) for name, field in fields.items()},
            self._plan.attributes | self._tally.attributes(grid.n_points),
        )
        return in_words(dataset)


def _memory() -> float:
    """Return the memory [bytes] of the machine, or of the control group of this process; infinite if unknown."""
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
