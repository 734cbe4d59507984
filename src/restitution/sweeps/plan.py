"""Plan of a sweep: quantities and points, outputs, and a description with a hash."""

from __future__ import annotations

import contextlib
import dataclasses
import functools
import hashlib
import inspect
import json
from collections.abc import Callable, Mapping, Sequence
from enum import Enum
from functools import cached_property
from importlib.metadata import version
from pathlib import Path
from types import CodeType, ModuleType
from typing import Any, Protocol, runtime_checkable

import numpy as np
from numpy.typing import NDArray

from restitution.doubts import Tally
from restitution.errors import InputTypeError
from restitution.impact.batch import Batch
from restitution.impact.status import Status
from restitution.quantities import ENERGIES, STATUS, VALIDITY, needs
from restitution.sweeps.grid import Grid, Index
from restitution.sweeps.templates import Assembly, Template
from restitution.validity import COLUMNS, Numbers, together

Array = NDArray[Any]
Tick = Callable[[int], None]

# Points that are built and solved at a time, which limits the memory for chunks of any size.
_BLOCK = 4096
# Each material needs its own report: if a block has more materials, a sample is checked.
_MOST_MATERIALS = 16
# In a description the hash represents a longer array.
_LONG = 1000


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
        made = version("restitution")
        return {
            **({"title": self.title} if self.title else {}),
            "source": f"restitution {made}",
            "version": made,
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

    @cached_property
    def assembly(self) -> Assembly:
        """Builder of impacts from values along the axes."""
        return Assembly(self.template, self.grid.names)

    def __getstate__(self) -> dict[str, Any]:
        # Another process derives the properties again.
        return {field.name: getattr(self, field.name) for field in dataclasses.fields(self)}

    def check(self) -> None:
        """Refuse axes whose ends give no admissible impact, with an `InputError`."""
        for point in self.grid.corners():
            for _ in self.assembly.parts(point, 1, _go_on, strict=True):
                pass

    def compute(self, index: Index, tick: Tick = lambda _: None, tally: Tally | None = None) -> dict[str, Array]:
        """Compute a chunk: `variables` in its shape, NaN where there is no result.

        `tick` is called with the number of points done since the last call, and ends the work by raising. `tally`
        counts the impacts that exceed the assumptions of the theory.
        """
        points = self.grid.points(index)
        results = {name: np.full(points.size, np.nan) for name in self.outputs}
        status = np.full(points.size, Status.INADMISSIBLE, dtype=np.int8)
        wanted = set(VALIDITY).intersection(self.outputs)
        for start in range(0, points.size, _BLOCK):
            stop = min(start + _BLOCK, points.size)
            n, counted = stop - start, 0
            columns = points.part(start, stop)
            found = {name: np.full(n, np.nan) for name in COLUMNS}
            for places, part in self.assembly.parts(columns, n, tick):
                solved = self._solve(part, tick)
                for name in set(solved).intersection(self.outputs):
                    results[name][start + places] = solved[name]
                status[start + places] = solved[STATUS]
                for name in found:
                    found[name][places] = solved[name]
                counted += places.size
            if wanted or tally is not None:
                most = None if wanted else _MOST_MATERIALS
                compared: dict[bool, list[Numbers]] = {}
                for places, numbers, is_own in self.assembly.validity(columns, n, found, tick, most):
                    for name in wanted:
                        results[name][start + places] = getattr(numbers, name)
                    compared.setdefault(is_own, []).append(numbers)
                for is_own, rows in compared.items():
                    if tally is not None:
                        tally.add(together(rows), with_material=is_own)
            # Points that are not admissible also count as done.
            tick(n - counted)
        shaped = {name: values.reshape(points.shape) for name, values in results.items()}
        return shaped | {STATUS: status.reshape(points.shape)}

    def _solve(self, batch: Batch, tick: Tick) -> dict[str, Array]:
        done = 0

        def progress(finished: int, _: int) -> None:
            nonlocal done
            tick(finished - done)
            done = finished

        energy, pressure = needs(self.outputs, ENERGIES), needs(self.outputs, {"max_pressure"})
        return batch.solve(self.rtol, workers=1, progress=progress, energy=energy, pressure=pressure)


def _go_on(_: int) -> None:
    pass


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
    >>> from restitution.contact.profile import Parabola
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
        if value.size > _LONG and value.dtype != object:
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
            constants = [one for one in code.co_consts if not isinstance(one, CodeType)]
            text = repr((code.co_code.hex(), code.co_names, constants))
    with contextlib.suppress(TypeError, ValueError):
        variables = inspect.getclosurevars(function)
        used |= {**variables.nonlocals, **variables.globals}
    for name_of in ("__defaults__", "__kwdefaults__", "__self__"):
        used[name_of] = getattr(function, name_of, None)
    held: dict[str, Any] = {}
    for key, one in used.items():
        if isinstance(one, (ModuleType, type)):
            continue
        try:
            # Functions that it calls count by their names, because they may call each other.
            held[key] = one.__qualname__ if inspect.isroutine(one) else describe(one)
        except (TypeError, ValueError, RecursionError):
            held[key] = "?"
    return {"function": name, "text": text, "holds": held}


def text_of(description: Any) -> str:
    """Return a description as JSON, the same for the same description."""
    return json.dumps(description, ensure_ascii=False, separators=(",", ":"))


def hash_of(description: Any) -> str:
    """Return the SHA-256 of a description."""
    return hashlib.sha256(text_of(description).encode()).hexdigest()
