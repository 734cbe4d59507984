"""A sweep before it runs: what is varied over which points, what is wanted, and what tells it from others."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, fields
from functools import cached_property
from importlib.metadata import version
from typing import Any

import numpy as np
from numpy.typing import NDArray

from restitution.doubts import Tally
from restitution.impact.batch import Batch
from restitution.impact.status import Status
from restitution.quantities import QUADRATURES, STATUS, VALIDITY, needs
from restitution.sweeps.batches import Assembly
from restitution.sweeps.fingerprint import describe, hash_of, text_of
from restitution.sweeps.grid import Grid, Index
from restitution.sweeps.varied import Template
from restitution.validity import COLUMNS

Array = NDArray[Any]
Tick = Callable[[int], None]

# Points that are made and solved at a time: memory stays small however large the chunk.
_BLOCK = 4096
# Each material takes a report of its own: of more of them in a block, only a sample is checked.
_MOST_MATERIALS = 16


class Interrupted(Exception):
    """Raised by `tick` to end the work on a chunk."""


@dataclass(frozen=True)
class Plan:
    """A sweep before it runs.

    Attributes
    ----------
    template : Template
        What is varied.
    grid : Grid
        The points.
    outputs : tuple of str
        What is wanted.
    rtol : float
        Tolerance of e.
    title : str
        What it is about.
    source : str
        Text that it was read from, or nothing.
    """

    template: Template
    grid: Grid
    outputs: tuple[str, ...]
    rtol: float
    title: str = ""
    source: str = ""

    @cached_property
    def description(self) -> dict[str, Any]:
        """What tells its numbers from those of others."""
        return {
            "base": self.template.describe(),
            "axes": {name: axis.describe() for name, axis in self.grid.axes.items()},
            "fixed": {name: describe(value) for name, value in self.grid.fixed.items()},
            "outputs": list(self.outputs),
            "rtol": self.rtol,
            "chunk": list(self.grid.chunk_shape),
            "version": version("restitution"),
        }

    @cached_property
    def attributes(self) -> dict[str, Any]:
        """Attributes of the result: what it is, and how it was made."""
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
        """Names of what is computed; the status last."""
        return (*self.outputs, STATUS)

    @cached_property
    def assembly(self) -> Assembly:
        """What makes impacts of values along the axes."""
        return Assembly(self.template, self.grid.names)

    def __getstate__(self) -> dict[str, Any]:
        # What is derived from these is made anew where the plan arrives.
        return {field.name: getattr(self, field.name) for field in fields(self)}

    def check(self) -> None:
        """Refuse axes whose ends make no impact.

        Raises
        ------
        ValueError
            In one line.
        """
        for point in self.grid.corners():
            for _ in self.assembly.parts(point, 1, _go_on, strict=True):
                pass

    def compute(self, index: Index, tick: Tick = lambda _: None, tally: Tally | None = None) -> dict[str, Array]:
        """Compute a chunk.

        Parameters
        ----------
        index : tuple of int
            Which chunk.
        tick : callable
            Called with the number of points done since the last call; ends the work by raising.
        tally : Tally, optional
            Counts the impacts that exceed the assumptions of the theory.

        Returns
        -------
        dict of str to array
            `variables` in the shape of the chunk; NaN where there is no result.
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
                for places, numbers, is_own in self.assembly.validity(columns, n, found, tick, most):
                    for name in wanted:
                        results[name][start + places] = getattr(numbers, name)
                    if tally is not None:
                        tally.add(numbers, with_material=is_own)
            # Points that are not admissible are done too.
            tick(n - counted)
        shaped = {name: values.reshape(points.shape) for name, values in results.items()}
        return shaped | {STATUS: status.reshape(points.shape)}

    def _solve(self, batch: Batch, tick: Tick) -> dict[str, Array]:
        done = 0

        def progress(finished: int, _: int) -> None:
            nonlocal done
            tick(finished - done)
            done = finished

        energy, pressure = needs(self.outputs, QUADRATURES), needs(self.outputs, {"max_pressure"})
        return batch.solve(self.rtol, workers=1, progress=progress, energy=energy, pressure=pressure)


def _go_on(_: int) -> None:
    pass
