"""Impacts as columns of numbers in SI, for the exact method."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, fields, replace
from functools import cached_property, partial
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from restitution.checks import Array, Numeric, Places
from restitution.contact.geometry import Geometry, depth_of_integral
from restitution.contact.profiles import Profile
from restitution.contact.table import Rows
from restitution.errors import InputError
from restitution.impact.members import shape_of
from restitution.impact.scaling import ScaledBlock, power_block, table_block
from restitution.impact.solution import (
    Progress,
    Solution,
    Stored,
    pressure_unit,
    solve_forces,
    solve_scaled,
    solve_stored,
)
from restitution.impact.status import Status
from restitution.kernel.outcome import MAX_DEPTH, OUTCOME, STATUS
from restitution.material.prony import PronySeries
from restitution.quantities import BODY, ENERGIES, OUTPUTS, derived

if TYPE_CHECKING:
    from restitution.impact.problem import Impact

# Error of the table of a profile that counts as rounding.
_TABLE_ROUNDING = 1e-11
# Depth to which the table of a profile reaches at first, over the estimated largest one.
_DEPTH_FACTOR = 4.0
# Tolerance of tables where that of the solution matters less.
_TABLE_RTOL = 1e-9


@dataclass(frozen=True, eq=False)
class Batch:
    """Impacts of one kind of profile, one in each row, in SI units.

    The arrays have the shape (n,), moduli [Pa] and times [s] of the branches of E*(t) the shape (n, n_branch); a
    modulus of 0 means no branch. The stiffness radius is a = c s^p, s = sqrt(d), with the coefficients c and the
    exponent p; a geometry without a power law replaces both. The contact radius is a, or a times the ratios.
    Targets do not move by default: one impedance for all.

    Examples
    --------
    >>> ones = np.ones(3)
    >>> batch = Batch(4.0 * ones, 0.0 * ones, np.empty((3, 0)), np.empty((3, 0)), ones, ones, 0.0 * ones, ones, 1.0)
    >>> batch.solve(1e-9)["restitution_coefficient"].round(9).tolist()
    [1.0, 1.0, 1.0]
    """

    equilibria: Array
    viscosities: Array
    moduli: Array
    times: Array
    masses: Array
    velocities: Array
    forces: Array
    coefficients: Array | None = None
    exponent: float | None = None
    profile: Geometry | None = None
    ratios: Array | None = None
    has_pressure: bool = True
    impedances: Array = field(default_factory=lambda: np.array([math.inf]))
    # Depth and radius [m] of each row that are 1 in a profile of unit size.
    depth_units: Any = 1.0
    radius_units: Any = 1.0
    # Whether the tables of the profile count as smooth.
    smooth: bool = False

    @classmethod
    def from_impact(cls, impact: Impact, reduced_moduli: PronySeries | None = None) -> Batch:
        """Return the rows of an impact that is not split, in the order of its raveled shape."""
        if impact.is_split:
            rule = f"must be a single one, as this one of shape {impact.shape} has materials or geometries apart"
            raise InputError("impact", rule=rule)
        impact.refuse_adhesion()
        moduli = impact.reduced_moduli if reduced_moduli is None else reduced_moduli
        profile = impact.profile
        exponent = profile.path_exponent
        unit, depth, radius = profile.similar
        if isinstance(unit, Rows):
            unit = unit.raveled(impact.shape)
        power = exponent is not None
        units = {} if power or unit is profile else {
            "depth_units": flat(depth, impact.shape), "radius_units": flat(radius, impact.shape)
        }  # fmt: skip
        return cls(
            *(moduli if moduli.shape == impact.shape else moduli.broadcast_to(impact.shape)).columns,
            *(flat(getattr(impact, name), impact.shape) for name in BODY[:3]),
            coefficients=flat(profile.path_coefficient, impact.shape) if power else None,
            exponent=float(np.asarray(exponent)) if power else None,
            profile=None if power else unit,
            ratios=_ratios(profile, impact.shape) if power else None,
            has_pressure=profile.image is not None,
            impedances=flat(impact.impedance, impact.shape),
            smooth=profile.smooth,
            **units,
        )

    @classmethod
    def from_impacts(cls, impacts: Sequence[Impact]) -> list[tuple[Places, Batch]]:
        """Return batches of single impacts of similar profiles and moduli, with the places of their rows."""
        return cls.joined([(np.array([n]), cls.from_impact(impact)) for n, impact in enumerate(impacts)])

    @classmethod
    def parts(cls, impact: Impact | Sequence[Impact]) -> list[tuple[Places, Batch]]:
        """Return batches of the rows of an impact, or of single impacts, with their places."""
        if isinstance(impact, Sequence):
            return cls.from_impacts(impact)
        return cls.joined([(places, cls.from_impact(part)) for places, part in impact.parts()])

    @classmethod
    def joined(cls, batches: Sequence[tuple[Places, Batch]]) -> list[tuple[Places, Batch]]:
        """Join batches of one exponent, or of similar profiles, and one number of branches; others stay alone."""
        alone: list[tuple[Places, Batch]] = []
        kinds: dict[Any, list[tuple[Places, Batch]]] = {}
        for member in batches:
            batch = member[1]
            kind = batch.exponent, batch.moduli.shape[1], batch.ratios is None, batch.has_pressure, batch.smooth
            kind = *kind, batch.profile
            is_similar = np.ndim(batch.depth_units) and not isinstance(batch.profile, Rows)
            same = kinds.setdefault(kind, []) if batch.profile is None or is_similar else alone
            same.append(member)
        return [*(_join(members) for members in kinds.values()), *alone]

    @property
    def size(self) -> int:
        """Number of impacts."""
        return self.masses.size

    def row(self, n: int) -> Batch:
        """Return one row, where the profile is the same for all."""
        arrays = {name: value for name, value in vars(self).items() if isinstance(value, np.ndarray)}
        rows = {name: value[n : n + 1] for name, value in arrays.items() if value.shape[:1] == (self.size,)}
        return replace(self, **rows)

    def scaled(self, depth_factor: Numeric = _DEPTH_FACTOR, rtol: float = 0.0) -> ScaledBlock:
        """Return the dimensionless numbers of the impacts; see `restitution.impact.scaling.table_block`."""
        # Without a row there is nothing to tabulate.
        if self.profile is not None and self.size:
            return table_block(self, np.broadcast_to(depth_factor, self.masses.shape), rtol)
        return power_block(self)

    def solve(
        self, rtol: float, *, workers: int | None = None, progress: Progress | None = None,
        energy: bool = False, pressure: bool = False,
    ) -> dict[str, Array]:  # fmt: skip
        """Solve the impacts by the exact method.

        Parameters
        ----------
        rtol, workers, progress
            See `restitution.solve`.
        energy, pressure : bool
            Whether to add the energies, and the largest pressure, which takes some 3 ms for each impact.

        Returns
        -------
        dict of str to array, shape (n,)
            `restitution.quantities.OUTPUTS` by name, and `status`; NaN where there is no result.
        """
        search = pressure and self.has_pressure and not bool(np.all(self.singular))

        def run(block: ScaledBlock) -> Array:
            return solve_scaled(block, rtol, workers=workers, progress=progress, budget=energy, pressure=search)

        columns = self.columns(*self.solved(run, rtol), energy, pressure)
        bodies = self.masses, self.velocities, self.forces, flat(self.impedances, self.masses.shape)
        outputs = derived(columns | dict(zip(BODY, bodies, strict=True)))
        return {name: outputs[name] for name in (*OUTPUTS, "status") if name in outputs}

    def max_contact_radii(self, rtol: float) -> Array:
        """Largest contact radii [m], shape (n,), of a solution whose tolerance is not that of its tables."""
        # Long elements from the start are enough for the radius, but need the checks of a table with bends.
        batch = replace(self, smooth=False)
        block, outcomes = batch.solved(lambda block: solve_scaled(block, rtol, approaches=True), _TABLE_RTOL)
        return self.columns(block, outcomes)["max_contact_radius"]

    @property
    def singular(self) -> NDArray[np.bool_]:
        """Whether the pressure of a row is infinite: with a dashpot, under a sharp tip, at the edge of a flat face."""
        if self.profile is None:
            return (self.viscosities > 0.0) | (not 0.0 < (self.exponent or 0.0) < 2.0)
        # At a sharp tip or a flat face of radius b, g - g(b) ~ (x - b)^m with m <= 1.
        assert isinstance(self.profile, Profile)
        b = float(self.profile.contact_radius(0.0))
        near = b * (1.0 + 1e-6 * np.array([1.0, 4.0])) if b > 0.0 else np.array([1e-100, 4e-100])
        low, high = self.profile.transform(near)
        return (self.viscosities > 0.0) | (not math.isfinite(high) or (high > 0.0 and high <= 4.001 * low))

    def solve_stored(self, rtol: float) -> tuple[dict[str, Array], Solution | None]:
        """Solve a batch of one impact; the solution is None unless the body separates."""
        kept: Stored | None = None

        def run(block: ScaledBlock) -> Array:
            nonlocal kept
            outcomes, kept = solve_stored(block, rtol)
            return outcomes

        block, outcomes = self.solved(run, rtol)
        separates = outcomes[0, STATUS] == Status.SEPARATED
        return self.columns(block, outcomes), self._solution(0, block, kept) if separates else None

    def solve_row(self, n: int, rtol: float) -> tuple[Status, Solution | None]:
        """Solve one row of several, with the solution if the body separates. Power laws are scaled for all at once."""
        if self.profile is not None:
            columns, solution = self.row(n).solve_stored(rtol)
            return Status(int(columns["status"][0])), solution
        block = self._power_block.part(n, n + 1)
        outcomes, kept = solve_stored(block, rtol)
        return Status(int(outcomes[0, STATUS])), self._solution(n, block, kept)

    @cached_property
    def _power_block(self) -> ScaledBlock:
        return power_block(self)

    def _solution(self, n: int, block: ScaledBlock, kept: Stored | None) -> Solution | None:
        """Return the solution of a row, from its block of one impact; None without stored halves."""
        if kept is None:
            return None
        mass, velocity = float(self.masses[n]), float(self.velocities[n])
        contact_radii, pressures = (partial(self._of_row, n, name) for name in ("contact_radii", "pressures"))
        return Solution(block.row(0), mass, velocity, kept, contact_radii, pressures)

    def _of_row(self, n: int, method: str, *numbers: Any) -> Array:
        """Call a method of a row, which many solutions never need."""
        return getattr(self.row(n), method)(*numbers)

    def sample_forces(self, times: Array, rtol: float) -> Array:
        """Return the forces [N] at ascending times [s] since first touch, shape (n, n_time).

        They are 0 outside the contact, and NaN for a body that does not separate.
        """
        forces = times

        def run(block: ScaledBlock) -> Array:
            nonlocal forces
            outcomes, forces = solve_forces(block, rtol, times / block.time[:, None])
            return outcomes

        block, outcomes = self.solved(run, rtol)
        forces[outcomes[:, STATUS] != Status.SEPARATED] = np.nan
        return forces * (self.masses * self.velocities / block.time)[:, None]

    def solved(self, run: Callable[[ScaledBlock], Array], rtol: float) -> tuple[ScaledBlock, Array]:
        """Scale and solve; repeat with a longer table of the profile if the table was too short."""
        factors = np.full(self.size, _DEPTH_FACTOR)
        while True:
            block = self.scaled(factors, rtol)
            outcomes = run(block)
            if self.profile is None or not self.size:
                return block, outcomes
            deep = (outcomes[:, STATUS] == Status.TOO_DEEP) | (outcomes[:, MAX_DEPTH] > 1.0)
            if deep.any():
                ends = block.length >= (1.0 - 1e-12) * self.profile.max_depth * self.depth_units
                again = deep & ~ends & (factors < 1e4)
                if again.any():
                    factors[again] *= 8.0
                    continue
            depth = np.where(np.isfinite(outcomes[:, MAX_DEPTH]), outcomes[:, MAX_DEPTH], 1.0)
            # No table is accurate enough for a profile with too sharp joints.
            rough, most = np.zeros(self.size, dtype=bool), max(rtol, _TABLE_ROUNDING)
            assert block.tables is not None
            for k in np.flatnonzero(np.max(block.tables.errors, axis=1) > most).tolist():
                rows = block.which == k
                rough[rows] = block.tables.single(k).error_at(depth[rows]) > most
            for rows, status in ((rough, Status.NOT_ACCURATE), (deep, Status.TOO_DEEP)):
                if not rows.any():
                    continue
                outcomes[rows, :STATUS] = np.nan
                outcomes[rows, STATUS] = status
            return block, outcomes

    def columns(
        self, block: ScaledBlock, outcomes: Array, energy: bool = False, pressure: bool = False
    ) -> dict[str, Array]:
        """Return outcomes in SI by name, with the energies and the largest pressure on request, and the status."""
        columns = dict(zip(OUTCOME, outcomes.T, strict=False))
        status, e = columns["status"], columns["restitution_coefficient"]
        stays = (status == Status.SINKS_IN) | (status == Status.CAPTURED)
        residual = columns["residual_indentation_depth"] * block.length
        unknown = stays & np.isnan(residual)
        if np.any(unknown):
            residual = np.where(unknown, self.rest_depth(), residual)
        depth, radius = columns["max_indentation_depth"] * block.length, columns["max_contact_radius"] * block.radius
        # A body that is captured on its way back creeps on, to a depth that may exceed that of the turning point.
        further = unknown & (residual > depth) & np.isfinite(residual)
        if np.any(further):
            depth = np.where(further, residual, depth)
            radius = np.where(further, self._stiffness_radius(np.where(further, depth, 0.0)), radius)
        radius = self.contact_radii(radius, depth)
        result = {
            "restitution_coefficient": e,
            "contact_time": np.where(stays, np.inf, columns["contact_time"] * block.time),
            "max_indentation_depth": depth,
            "max_force": columns["max_force"] * self.masses * self.velocities / block.time,
            "max_contact_radius": radius,
            "residual_indentation_depth": residual,
        }
        if energy:
            with np.errstate(over="ignore", invalid="ignore"):
                n, unit = len(columns), self.masses * self.velocities * self.velocities
                result |= {name: unit * outcomes[:, n + i] for i, name in enumerate(ENERGIES)}
        if pressure:
            # If every pressure is infinite there is no such column, and the last one is replaced.
            with np.errstate(over="ignore", invalid="ignore", divide="ignore"):
                peak = pressure_unit(self.masses, self.velocities, block) * outcomes[:, -1]
            result["max_pressure"] = np.where(np.isnan(columns["max_force"]), np.nan, self.pressures(peak))
        return result | {"status": status}

    def pressures(self, peak: Any) -> Array:
        """Return the largest pressures [Pa] for those, as far as finite, of profiles with the same stiffness radii."""
        if not self.has_pressure:
            return np.full(self.size, np.nan)
        peak = np.where(self.singular, np.inf, peak)
        return peak if self.ratios is None else peak / self.ratios**2

    def contact_radii(self, stiffness_radius: Array, depth: Array) -> Array:
        """Return the contact radii [m] for stiffness radii [m] and the depths [m] of the approach that have them."""
        if self.profile is None or isinstance(self.profile, Profile):
            return stiffness_radius if self.ratios is None else stiffness_radius * self.ratios
        is_finite = np.isfinite(depth) & np.isfinite(stiffness_radius)
        scaled = depth / self.depth_units, stiffness_radius / self.radius_units
        place = (np.where(is_finite, length, 0.0) for length in scaled)
        return np.where(is_finite, self.profile.contact_radius_at(*place) * self.radius_units, stiffness_radius)

    def _stiffness_radius(self, depth: Array) -> Array:
        """Return the stiffness radius [m] at depths [m]."""
        if self.profile is None:
            return np.asarray(self.coefficients) * depth ** (0.5 * (self.exponent or 0.0))
        return self.profile.stiffness_radius(depth / self.depth_units) * self.radius_units

    def rest_depth(self) -> Array:
        """Return the depth [m] at which the relaxed foundation carries the external force; infinite on a liquid."""
        with np.errstate(divide="ignore", invalid="ignore"):
            integral = self.forces / (2.0 * self.equilibria)
            if self.profile is None:
                power = 0.5 * (self.exponent or 0.0) + 1.0
                return (integral * power / np.asarray(self.coefficients)) ** (1.0 / power)
        return depth_of_integral(self.profile, integral / (self.depth_units * self.radius_units)) * self.depth_units


def solve_columns(
    impact: Impact | list[Impact], rtol: float, *, workers: int | None = None, progress: Progress | None = None,
    energy: bool = False, pressure: bool = False,
) -> dict[str, Any]:  # fmt: skip
    """Return the outputs of impacts by name, raveled; see `Batch.solve`. With adhesion these are all."""
    if (impact[0] if isinstance(impact, list) else impact).adhesion is not None:
        from restitution.impact.adhesive import adhesive_columns

        return adhesive_columns(impact, rtol, workers=workers, progress=progress)
    columns, done, count = dict[str, Any](), 0, math.prod(shape_of(impact))

    def advance(finished: int, _: int) -> None:
        if progress is not None:
            progress(done + finished, count)

    for places, batch in Batch.parts(impact):
        solved = batch.solve(rtol, workers=workers, progress=advance, energy=energy, pressure=pressure)
        for name, values in solved.items():
            columns.setdefault(name, np.empty(count))[places] = values
        done += batch.size
    return columns


def shaped(values: Any, shape: tuple[int, ...]) -> Any:
    """Return a column in the shape of the impacts; a float for a single impact."""
    column = np.asarray(values, dtype=np.float64)
    return column.reshape(shape) if shape else float(column.reshape(-1)[0])


def flat(value: Any, shape: tuple[int, ...]) -> Array:
    """Return numbers, broadcast to a shape and raveled."""
    column = np.asarray(value, dtype=np.float64)
    return (column if column.shape == shape else np.broadcast_to(column, shape)).reshape(-1)


def _ratios(geometry: Geometry, shape: tuple[int, ...]) -> Array | None:
    """Return the ratios of the contact radius to the stiffness radius of a power law; None where they are one."""
    if isinstance(geometry, Profile):
        return None
    return flat(geometry.contact_radius(1.0) / geometry.stiffness_radius(1.0), shape)


def _join(members: list[tuple[Places, Batch]]) -> tuple[Places, Batch]:
    if len(members) == 1:
        return members[0]
    batches = [batch for _, batch in members]
    names = [field.name for field in fields(Batch) if isinstance(getattr(batches[0], field.name), np.ndarray)]
    columns: dict[str, Any] = {name: np.concatenate([getattr(batch, name) for batch in batches]) for name in names}
    columns["impedances"] = np.concatenate([flat(batch.impedances, batch.masses.shape) for batch in batches])
    return np.concatenate([places for places, _ in members]), replace(batches[0], **columns)
