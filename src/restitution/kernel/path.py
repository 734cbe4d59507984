"""Profile in the form of the kernel: contact radius over the square root of the depth."""

import math
from typing import Any, NamedTuple

import numpy as np

from restitution.kernel.compile import compiled, inlined
from restitution.kernel.lanes import (
    WIDTH,
    at_least,
    broadcast,
    exp,
    from_lane,
    log,
    read8,
    root,
    where_positive,
    write8,
)
from restitution.kernel.references import by_reference

# Places in one cell from which a calculation of all eight lanes is faster than one after another.
_FEW = 2

# Exponents that stand for a table, and for one without bends, whose a(s) is smooth at s = 0 as well.
TABLE, SMOOTH_TABLE = -1.0, -2.0
# Smallest rho over the width of a cell for which da/ds is the slope over rho; closer to a kink both vanish.
_AT_KINK = 1e-6


@by_reference
class Path(NamedTuple):
    """Contact radius a(s) with depth d = s^2, dimensionless.

    Of several profiles the arrays have one more axis in front, and `end` is an array.
    """

    exponent: float  # p of a = s^p; or `TABLE` or `SMOOTH_TABLE`, < 0, where the table below holds instead
    end: Any  # End of the table in s
    edges: Any  # (n_cells + 1,): ends of the table's cells in s, rising from 0
    finder: Any  # (n_bins + 1,): the cells that hold the ends of equal bins in s
    # (n_cells, 3): of each cell the origin of rho = sqrt(s - origin), negative where rho = s, then rho at its start,
    # and its width
    cells: Any
    radius: Any  # (n_cells, n): polynomial coefficients of a over the cell's own coordinate in [0, 1], constant first
    integral: Any  # (n_cells, n + 4): the same for `Pi = int_0^s a 2 s ds`
    kinks: Any  # (n_kinks,): places; beyond a kink `a = smooth + strength (s - kink)^power`
    strengths: Any  # (n_kinks,): their strengths
    power: float


_STACKED = ("end", "edges", "finder", "cells", "radius", "integral", "kinks", "strengths")


def power_path(exponent: float) -> Path:
    """Return the path a = s^p of parabola (p = 1), cone (2), flat punch (0) or r^n (2/n)."""
    none, nothing = np.zeros((0, 1)), np.zeros(0)
    finder = np.zeros(1, dtype=np.int64)
    return Path(float(exponent), 1e30, np.zeros(1), finder, none, none, none, nothing, nothing, 1.5)


def table_path(table: Any, exponent: float = TABLE) -> Path:
    """Return the path of a `restitution.contact.table.PathTable`, or of several in one."""
    # A view with strides would make a second version of all compiled functions that take a path.
    edges, end = table.edges, table.edges[..., -1].copy()
    (*several, count), bins = edges[..., 1:].shape, 2 * (edges.shape[-1] - 1) + 1
    # The first bin that begins in each cell.
    marks = np.ceil(edges[..., :-1] * ((bins - 1) / end[..., None])).reshape(-1, count).astype(np.int64)
    marks = np.minimum(marks, bins - 1) + bins * np.arange(len(marks))[:, None]
    finder = np.bincount(marks.ravel(), minlength=bins * len(marks)).reshape(*several, bins).cumsum(axis=-1) - 1
    low, high = table.ends
    # Cells without a width have one value, at the end.
    cells = np.stack([table.origin, low, np.where(high > low, high - low, 1.0)], axis=-1)
    return Path(
        exponent, end if several else float(end), edges, finder.astype(np.int64), cells, table.radius,
        table.force_integral, table.kinks, table.strengths, float(table.power),
    )  # fmt: skip


def several_paths(path: Path) -> Path:
    """Return a single path as one of several."""
    return path._replace(**{name: np.array(getattr(path, name))[None] for name in _STACKED})


def single_path(paths: Path, n: int) -> Path:
    """Return path n of several."""
    return Path(
        paths.exponent, paths.end[n], paths.edges[n], paths.finder[n], paths.cells[n], paths.radius[n],
        paths.integral[n], paths.kinks[n], paths.strengths[n], paths.power,
    )  # fmt: skip


path_inside: Any = inlined(single_path)


@inlined
def _cell(path: Path, s: float) -> int:
    """Return the cell of the table that contains s."""
    bins = path.finder.shape[0] - 1
    place = int(min(max(0.0, s * (bins / path.end)), bins - 1.0))
    cell = path.finder[place]
    above = path.finder[place + 1] + 1
    # A bin may contain many of the narrow cells around a kink.
    while above - cell > 1:
        middle = (cell + above) // 2
        if s >= path.edges[middle]:
            cell = middle
        else:
            above = middle
    return cell


@compiled
def cells_between(path: Path, low: float, high: float) -> int:
    """Return the number of ends of cells from one s to a larger one."""
    return _cell(path, high) - _cell(path, low)


@compiled
def _table(path: Path, s: float) -> tuple[float, float, float]:
    """Contact radius a, Pi and da/ds at s from the table; not inlined, to keep the code of power laws short."""
    return _cell_values(path, _cell(path, s), s)


@inlined
def _cell_values(path: Path, cell: int, s: float) -> tuple[float, float, float]:
    """Return the contact radius a, Pi and da/ds at s in a given cell."""
    origin, low, width = path.cells[cell, 0], path.cells[cell, 1], path.cells[cell, 2]
    rho = max(s, 0.0)
    steepness = 1.0
    if origin >= 0.0:
        rho = math.sqrt(max(s - origin, 0.0))
        # At a kink the slope vanishes together with rho, and da/ds is finite.
        steepness = 0.5 / max(rho, _AT_KINK * width)
    y = (rho - low) / width
    a = 0.0
    slope = 0.0
    for n in range(path.radius.shape[1] - 1, -1, -1):
        slope = slope * y + a
        a = a * y + path.radius[cell, n]
    integral = 0.0
    for n in range(path.integral.shape[1] - 1, -1, -1):
        integral = integral * y + path.integral[cell, n]
    return a, integral, slope / width * steepness


@inlined
def radius_and_integral(path: Path, s: float) -> tuple[float, float]:
    """Return the contact radius a and Pi at s."""
    p = path.exponent
    # The common case, without a power.
    if p == 1.0:
        return s, (2.0 / 3.0) * s * s * s
    if p >= 0.0:
        a = max(s, 0.0) ** p
        return a, 2.0 / (p + 2.0) * s * s * a
    a, integral, _ = _table(path, s)
    return a, integral


@inlined
def radii_and_integrals(path: Path, s: Any, scratch: Any) -> Any:
    """Return the contact radii a and Pi at eight s; `scratch` has two rows."""
    p = path.exponent
    if p == 1.0:
        a = s
    elif p == 0.0:
        a = broadcast(1.0)
    elif p == 2.0:
        a = s * s
    elif p > 0.0:
        a = where_positive(s, exp(at_least(p * log(at_least(s, 1e-300)), -700.0)))
    else:
        return table_radii_and_integrals(path, s, scratch)
    return a, (2.0 / (p + 2.0)) * (s * s * a)


@compiled
def table_radii_and_integrals(path: Path, s: Any, scratch: Any) -> Any:
    """Contact radii a and Pi at eight s from the table; consecutive places in one cell are evaluated together."""
    lane = 0
    while lane < WIDTH:
        first, cell = lane, _cell(path, s[lane])
        lane += 1
        # Neighbouring nodes mostly lie in one cell.
        while lane < WIDTH and path.edges[cell] <= s[lane] < path.edges[cell + 1]:
            lane += 1
        if lane - first < _FEW:
            for i in range(first, lane):
                scratch[0, i], scratch[1, i], _ = _cell_values(path, cell, s[i])
            continue
        origin, low, width = path.cells[cell, 0], path.cells[cell, 1], path.cells[cell, 2]
        rho = at_least(s, 0.0) if origin < 0.0 else root(at_least(s - origin, 0.0))
        y = (rho - low) / width
        a, integral = broadcast(0.0), broadcast(0.0)
        for n in range(path.radius.shape[1] - 1, -1, -1):
            a = a * y + path.radius[cell, n]
        for n in range(path.integral.shape[1] - 1, -1, -1):
            integral = integral * y + path.integral[cell, n]
        write8(scratch, 0, 0, from_lane(first, a, read8(scratch, 0, 0)))
        write8(scratch, 1, 0, from_lane(first, integral, read8(scratch, 1, 0)))
    return read8(scratch, 0, 0), read8(scratch, 1, 0)


@inlined
def radius_slope(path: Path, s: float, a: float) -> float:
    """Return the slope da/ds at s > 0, where the radius is a."""
    if path.exponent >= 0.0:
        return path.exponent * a / s
    return _table(path, s)[2]
