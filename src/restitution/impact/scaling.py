"""Dimensionless numbers of impacts for the kernel."""

from __future__ import annotations

import math
from dataclasses import replace
from functools import lru_cache, reduce
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from restitution.checks import Array
from restitution.contact.table import Rows, Samples, Tables

if TYPE_CHECKING:
    from restitution.contact.geometry import Geometry
    from restitution.contact.table import PathTable
    from restitution.impact.batch import Batch


# Smaller units lose digits, or vanish in products.
_SMALLEST = 1e-300


def viscosity_unit(equilibrium_modulus: Any, mass: Any, velocity: Any, radius: Any) -> Any:
    """Return the viscosity `(m^2 Ginf^3/(v0 R))^(1/5)` [Pa s], for which p3 = 1; all in SI."""
    # Roots first: the cube of a modulus may overflow.
    return equilibrium_modulus**0.6 * mass**0.4 / (velocity**0.2 * radius**0.2)


class ScaledImpact(NamedTuple):
    """One impact in units of a length L, the time L/v0 and the mass m, with d = s^2.

    `F = equilibrium Pi + viscosity a v + sum moduli_k Y_k`, `v' = -(F - external_force)`, `Y_k' = -Y_k/times_k + a v`.
    If the target moves, v is here the velocity of the indentation, and v + admittance F obeys the second equation.
    The contact radius is a = s^p with the `exponent` p, or that of the `table` of the profile. `first` is the
    scale of s for the first steps; `length`, `time` and `radius` are the units [m], [s], [m].
    """

    equilibrium: float
    moduli: Array
    times: Array
    viscosity: float
    external_force: float
    admittance: float
    exponent: float
    table: PathTable | None
    first: float
    length: float
    time: float
    radius: float


class ScaledBlock(NamedTuple):
    """Scaled impacts of one kind of profile as arrays.

    Row n has the modes offsets[n] to offsets[n + 1], and the table which[n] of several unless there are none.
    """

    firsts: Array
    equilibria: Array
    viscosities: Array
    external_forces: Array
    admittances: Array
    offsets: NDArray[np.int64]
    moduli: Array
    times: Array
    exponent: float
    tables: PathTable | None
    which: NDArray[np.intp]
    length: Array
    time: Array
    radius: Array

    @property
    def size(self) -> int:
        """Number of impacts."""
        return self.firsts.size

    @property
    def most_modes(self) -> int:
        """Largest number of modes of a row."""
        return int(np.diff(self.offsets).max(initial=0))

    def row(self, n: int) -> ScaledImpact:
        """Return impact n."""
        modes = slice(int(self.offsets[n]), int(self.offsets[n + 1]))
        return ScaledImpact(
            float(self.equilibria[n]), self.moduli[modes], self.times[modes], float(self.viscosities[n]),
            float(self.external_forces[n]), float(self.admittances[n]), self.exponent,
            self.tables and self.tables.single(int(self.which[n])), float(self.firsts[n]),
            float(self.length[n]), float(self.time[n]), float(self.radius[n]),
        )  # fmt: skip

    def part(self, start: int, stop: int) -> ScaledBlock:
        """Return the impacts from `start` to `stop` as a block."""
        rows = slice(start, stop)
        modes = slice(int(self.offsets[start]), int(self.offsets[stop]))
        return ScaledBlock(
            self.firsts[rows], self.equilibria[rows], self.viscosities[rows], self.external_forces[rows],
            self.admittances[rows], self.offsets[start : stop + 1] - self.offsets[start], self.moduli[modes],
            self.times[modes], self.exponent, self.tables, self.which[rows], self.length[rows], self.time[rows],
            self.radius[rows],
        )  # fmt: skip


def _sums(rows: Array) -> Array:
    """Return the sums of rows, term by term, so that the zeros of a row with fewer branches change no bit."""
    return rows.cumsum(axis=1)[:, -1] if rows.shape[1] else np.zeros(len(rows))


def power_block(batch: Batch) -> ScaledBlock:
    """Scale impacts of a power-type profile a = c s^p.

    The length L is the depth that an elastic body would reach with the modulus at the time scale of the impact. All
    numbers are then of order one where the materials allow it.
    """
    p, power = batch.exponent or 0.0, 1.0 / (2.0 + 0.5 * (batch.exponent or 0.0))
    # Without a row there may be no coefficients.
    coefficients: Any = batch.masses if batch.coefficients is None else batch.coefficients
    # A row that overflows here fails in the kernel.
    with np.errstate(all="ignore"):
        # 2 E c L^(2 + p/2) = (p + 2)(p + 4)/8 m v0^2 for an elastic body whose largest depth is L.
        energy = (p + 2.0) * (p + 4.0) / 16.0 * batch.masses * batch.velocities * batch.velocities / coefficients
        glass = batch.equilibria + _sums(batch.moduli)
        only_viscous = (energy / (batch.viscosities * batch.velocities)) ** (1.0 / (1.0 + 0.5 * p))
        # Roots first: the energy over a modulus is a volume, which may overflow where the length does not.
        root = energy**power
        length = np.where(glass > 0.0, root / glass**power, only_viscous)
        for _ in range(6):
            duration = (1.5 * length / batch.velocities)[:, None]
            relaxing = _sums(batch.moduli * (batch.times / (batch.times + duration)))
            length = root / (batch.equilibria + relaxing + batch.viscosities / duration[:, 0]) ** power
        radius = coefficients * length ** (0.5 * p)
    return _block(batch, np.full(length.size, 1.0), (length, radius), p, None, np.zeros(length.size, np.intp))


def _block(
    batch: Batch, firsts: Array, sizes: tuple[Array, Any], exponent: float, tables: PathTable | None,
    which: NDArray[np.intp],
) -> ScaledBlock:  # fmt: skip
    """Divide impacts by the units of their depth and their radius; NaN where a unit has no normal number."""
    length, radius = sizes
    with np.errstate(all="ignore"):
        time = length / batch.velocities
        # The scaled force of 1 Pa at depth and radius 1.
        factor = 2.0 * radius * time * (time / batch.masses)
        energy, force = batch.masses * batch.velocities * batch.velocities, batch.masses * batch.velocities / time
        units = length, time, radius, energy, force, factor
        normal = reduce(np.logical_and, [(unit > _SMALLEST) & (unit < 1.0 / _SMALLEST) for unit in units])
        factor = np.where(normal, factor, np.nan)
        branches = batch.moduli != 0.0
        return ScaledBlock(
            firsts, batch.equilibria * factor, batch.viscosities * factor / time, batch.forces / force,
            batch.masses / time / batch.impedances, np.concatenate([[0], np.cumsum(branches.sum(axis=1))]),
            (batch.moduli * factor[:, None])[branches], (batch.times / time[:, None])[branches],
            exponent, tables, which, length, time, radius,
        )  # fmt: skip


# Error of the table of a profile over the tolerance of e, and the limits of this error. Finer tables resolve kinks
# that do not matter, at the cost of small steps; coarser tables save nothing.
_TABLE_SHARE, _TABLE_LEAST, _TABLE_MOST = 1e-2, 1e-12, 1e-10
# Octaves of the depth whose rows share a table.
_OCTAVES = 2
# Relative tolerance of the estimated depth, and the most steps of the search: bisections alone need fewer.
_DEPTH_TOLERANCE, _MOST_STEPS = 1e-4, 40


def table_block(batch: Batch, depth_factors: Array, rtol: float) -> ScaledBlock:
    """Scale impacts of geometries without a power law, by tables that suffice for the tolerance `rtol` of e.

    The table of a row reaches to its factor of `depth_factors` times the estimated largest depth, or further. The end
    is the length L of the row.
    """
    from restitution.kernel.path import SMOOTH_TABLE, TABLE

    profile, depth_unit, radius_unit = batch.profile, batch.depth_units, batch.radius_units
    assert profile is not None
    # A row whose depth and radius are multiples obeys the same equations with other numbers of the body.
    with np.errstate(all="ignore"):  # a row that overflows here fails in the kernel
        batch = replace(
            batch, masses=batch.masses / radius_unit, velocities=batch.velocities / depth_unit,
            forces=batch.forces / (depth_unit * radius_unit), impedances=batch.impedances / radius_unit,
        )  # fmt: skip
    if isinstance(profile, Rows):
        samples, which, sampled = profile.samples, profile.which, profile.sampled[profile.which]
    else:
        samples, which = _of_profile(_samples, profile), np.zeros(batch.size, np.intp)
        sampled = which
    with np.errstate(all="ignore"):
        depths = _elastic_depth(batch, samples, sampled)
    error = min(max(_TABLE_SHARE * rtol, _TABLE_LEAST), _TABLE_MOST)

    if isinstance(profile, Rows):
        deepest, least = np.zeros((2, profile.sampled.size))
        least[:] = np.inf
        np.maximum.at(deepest, which, depth_factors * depths)
        np.minimum.at(least, which, depths)
        tables, lengths, radii = profile.tables(deepest, least, error)
    else:
        # A table depends on the level of the depth of its rows alone, and so do the bits of a row.
        _, exponents = np.frexp(depths)
        levels: Any = exponents // _OCTAVES + 1j * depth_factors
        if levels.size > 1:
            levels, which = np.unique(levels, return_inverse=True)
        tables, lengths, radii = _tables_of_levels(profile, levels.tolist(), error)
    sizes = lengths[which], radii[which]
    with np.errstate(all="ignore"):
        first = np.sqrt(depths / sizes[0])
    block = _block(batch, first, sizes, SMOOTH_TABLE if batch.smooth else TABLE, tables, which)
    return block._replace(length=block.length * depth_unit, radius=block.radius * radius_unit)


def _tables_of_levels(profile: Geometry, levels: list[complex], rtol: float) -> Tables:
    """Return the tables for depths of some levels; the imaginary part is the factor by which they reach further."""
    from restitution.contact.table import joined

    most, tables = float(profile.max_depth), list[Tables]()
    for level in levels:
        least = 2.0 ** (_OCTAVES * level.real - 1.0)
        length = min(level.imag * 2.0**_OCTAVES * least, most)
        tables.append(_of_profile(_path_table, profile, length, min(least, length), rtol))
    if len(tables) == 1:
        return tables[0]
    return Tables(joined([each.table for each in tables]), *np.hstack([each[1:] for each in tables]))


def _of_profile(function: Any, profile: Geometry, *arguments: float) -> Any:
    """Call a function with a cache, or without its cache for a profile that has no hash."""
    try:
        hash(profile)
    except TypeError:
        return function.__wrapped__(profile, *arguments)
    return function(profile, *arguments)


@lru_cache(maxsize=128)
def _path_table(profile: Geometry, depth_max: float, depth_min: float, rtol: float) -> Tables:
    """Return the table as one of several."""
    from restitution.contact.table import path_table, scaled

    radius = float(profile.stiffness_radius(depth_max))
    table = scaled(path_table(profile, depth_max, rtol, depth_min=depth_min), depth_max, radius)
    return Tables(table.several, np.array([depth_max]), np.array([radius]))


@lru_cache(maxsize=32)
def _samples(profile: Geometry) -> Samples:
    """Return the force integrals of a geometry over the logarithm of the depth."""
    most = min(float(profile.max_depth), 1e100)
    knots = np.linspace(-300.0, math.log(most), math.ceil(300.0 + math.log(most)) + 1)
    # Rounding must not exceed the last depth of a profile.
    with np.errstate(all="ignore"):
        integrals = profile.force_integral_at_depth(np.minimum(np.exp(knots), most))
    return Samples(knots, knots[None], np.log(np.maximum(integrals, 1e-300))[None])


def _elastic_depth(batch: Batch, samples: Samples, which: NDArray[np.intp]) -> Array:
    """Estimate the depth [m] at which an elastic body with the modulus at the time scale of the impact turns."""
    # Measured tips are slow to evaluate, and only the first step depends on the estimate.
    knots = samples.knots
    low, high = np.full(batch.size, knots[0]), np.full(batch.size, knots[-1])
    # Nothing stops a weight on a liquid.
    weight = np.where(batch.equilibria > 0.0, batch.forces, 0.0)
    x = before = 0.5 * (low + high)
    last, slope = np.zeros(batch.size), np.full(batch.size, 2.0)
    # A row that has converged stays, so that it does not depend on the others.
    moves = np.ones(batch.size, dtype=bool)
    # The secant of the energies in logarithms, within a bracket.
    for _ in range(_MOST_STEPS):
        depth, integral = samples.at(x, which)
        duration = 1.5 * depth / batch.velocities
        relaxed = _sums(batch.moduli * batch.times / (batch.times + duration[:, None]))
        modulus = batch.equilibria + relaxed + batch.viscosities / duration
        # The exponent 2/5 of the parabola is good enough for all profiles.
        stored = 0.4 * 2.0 * modulus * integral * depth
        excess = np.log(stored / (0.5 * batch.masses * batch.velocities * batch.velocities + weight * depth))
        low, high = np.where(excess > 0.0, low, x), np.where(excess > 0.0, x, high)
        slope = np.where(x == before, slope, (excess - last) / (x - before))
        now = x - excess / slope
        now = np.where((now > low) & (now < high), now, 0.5 * (low + high))
        before, last, x = x, excess, np.where(moves, now, x)
        moves &= np.abs(x - before) >= _DEPTH_TOLERANCE
        if not moves.any():
            break
    return samples.at(x, which)[0]
