"""Solution of one impact: approach, rebound and memory of the foundation.

An element of the foundation that is touched at t0(x) has in branch k the elongation
`w_k = H_k(t) - exp(-(t - t0)/tau_k) H_k(t0)`, `H_k = int_0^t exp(-(t - t')/tau_k) d' dt'`. The memory H_k and the
energies are integrated once, in `restitution.kernel.stored`, for the budget, the history and the fields.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property, lru_cache
from threading import Lock, local
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from restitution.checks import Array, Places, finite
from restitution.contact.table import evaluate
from restitution.errors import InputError
from restitution.impact.scaling import ScaledBlock, ScaledImpact
from restitution.impact.status import Status
from restitution.kernel.outcome import OUTCOME, STATUS
from restitution.kernel.plain import single_problem
from restitution.parallel import on_threads

if TYPE_CHECKING:
    from restitution.indentation.panels import PanelSolution
    from restitution.indentation.surface import Surface
    from restitution.kernel.collocation import Scheme
    from restitution.kernel.path import Path
    from restitution.kernel.sliding import Halves
    from restitution.kernel.stored import Ledger
    from restitution.kernel.workspace import Problem, Problems, Work


# The exact method: blocks of scaled impacts in the compiled kernel, on a pool of threads.

Progress = Callable[[int, int], None]

STAGES = 8
# Impacts in a task: about 10 ms, so that Ctrl-C and progress are prompt and the overhead of the pool is negligible.
_CHUNK = 512
_KEPT = local()
# Members of the room of the kernel that a solved impact does not need.
_SCRATCH = ("vectors", "basis", "matrices", "inverses", "modes", "past")
_NO_SCRATCH: dict[str, Any] = dict.fromkeys(_SCRATCH)

# Measured tolerances of an element that keep the error of e below rtol max(e, 1e-3): the error at the end of an
# element falls faster than the error inside it.
_RTOL = (-14.0, -12.0, -11.0, -10.0, -9.0, -8.0, -6.0, -4.0, -2.0)
_ELEMENT_TOLERANCE = (-12.0, -9.2, -8.3, -7.75, -7.1, -6.4, -5.3, -4.6, -4.4)
# Tolerances of an element and of Newton's method over that of the radius of an approach, by measurement: the radius is
# far more accurate than the inside of an element.
_TAIL, _NEWTON = 1e3, 10.0


@lru_cache
def element_tolerance(rtol: float) -> float:
    """Return the tolerance of one element that keeps the error of e below rtol max(e, 1e-3); see validation/."""
    return float(10.0 ** np.interp(math.log10(rtol), _RTOL, _ELEMENT_TOLERANCE))


def newton_tolerance(rtol: float) -> float:
    """Return the largest accepted relative error of the Newton iteration; below 2e-14 there is only rounding."""
    return min(max(5e-2 * rtol, 2e-14), 1e-7)


def kernel_paths(block: ScaledBlock) -> Path:
    """Return the geometries of a block for the kernel; row n has the geometry which[n]."""
    from restitution.kernel.path import table_path

    return _power_paths(block.exponent) if block.tables is None else table_path(block.tables, block.exponent)


@lru_cache
def _power_paths(exponent: float) -> Path:
    """Return the geometry of a power law as one of several; a fit solves thousands of blocks with it."""
    from restitution.kernel.path import power_path, several_paths

    return several_paths(power_path(exponent))


def solve_scaled(
    block: ScaledBlock, rtol: float, *, workers: int | None = None, progress: Progress | None = None,
    budget: bool = False, pressure: bool = False, approaches: bool = False,
) -> Array:  # fmt: skip
    """Solve a block of impacts, or their approaches; return columns `restitution.kernel.outcome.OUTCOME`, scaled.

    On request, further columns are the energies dissipated, stored and radiated, in units of m v0^2, and the largest
    pressure; see `restitution.kernel.stored`. Approaches have the columns of `restitution.kernel.turning`. The other
    options are those of `restitution.solve`.
    """
    paths = kernel_paths(block)
    outcomes = np.empty((block.size, len(OUTCOME)))
    further = np.full((block.size, 3 * budget + pressure), np.nan)

    done, lock = 0, Lock()

    def run(chunk: tuple[int, int]) -> None:
        nonlocal done
        start, stop = chunk
        part = block.part(start, stop)
        work = _kept_work(part.most_modes)
        if further.shape[1]:
            _solve_each(part, paths, rtol, work, outcomes[start:stop], further[start:stop], budget, pressure)
        else:
            (_turn_part if approaches else _solve_part)(part, paths, rtol, work, outcomes[start:stop])
        with lock:
            done += stop - start

    def report() -> None:
        if progress is not None:
            progress(done, block.size)

    chunks = ((start, min(start + _CHUNK, block.size)) for start in range(0, block.size, _CHUNK))
    if block.size <= _CHUNK or workers == 1:
        for chunk in chunks:
            run(chunk)
            report()
    else:
        # The first chunk compiles alone; threads that start together would each compile.
        run(next(chunks))
        report()
        on_threads(run, chunks, workers, report)
    return np.hstack([outcomes, further])


def _kept_work(modes: int) -> Work:
    """Return scratch space that this thread keeps for the next block; new memory costs as much as ten impacts."""
    work: Work | None = getattr(_KEPT, "work", None)
    if work is None or work.inverses.shape[0] != modes:
        from restitution.kernel.impact import MAX_ELEMENTS
        from restitution.kernel.workspace import allocate

        work = _KEPT.work = allocate(modes, MAX_ELEMENTS)
    return work


def _turn_part(block: ScaledBlock, paths: Path, rtol: float, work: Work, outcomes: Array) -> None:
    """Solve the approaches of a block in one call of the kernel, and whole impacts where there is no turning point."""
    from restitution.kernel.collocation import radau
    from restitution.kernel.turning import turning_block

    turning_block(radau(STAGES), _TAIL * rtol, _NEWTON * rtol, _problems(block, paths), work, outcomes)
    for n in np.flatnonzero(outcomes[:, STATUS] != Status.SEPARATED).tolist():
        _solve_part(block.part(n, n + 1), paths, rtol, work, outcomes[n : n + 1])


def _solve_part(block: ScaledBlock, paths: Path, rtol: float, work: Work, outcomes: Array) -> None:
    """Solve a block in one call of the kernel."""
    from restitution.kernel.collocation import radau
    from restitution.kernel.impact import solve_block

    problems = _problems(block, paths)
    solve_block(radau(STAGES), element_tolerance(rtol), newton_tolerance(rtol), problems, work, outcomes)
    outcomes[np.isnan(block.equilibria), STATUS] = Status.NOT_FINITE


def _solve_each(
    block: ScaledBlock, paths: Path, rtol: float, work: Work, outcomes: Array, further: Array,
    budget: bool, pressure: bool,
) -> None:  # fmt: skip
    """Solve a block one by one, with the energies in units of m v0^2 and the largest pressure."""
    from restitution.kernel.collocation import radau
    from restitution.kernel.impact import MAX_ELEMENTS
    from restitution.kernel.stored import allocate_ledger, energy_budget, graded_rule, peak_pressure

    rules = graded_rule(4), graded_rule(8)
    ledger = allocate_ledger(block.most_modes, MAX_ELEMENTS) if budget else None
    for n in range(block.size):
        _solve_part(block.part(n, n + 1), paths, rtol, work, outcomes[n : n + 1])
        status = outcomes[n, STATUS]
        if budget and status == Status.SEPARATED:
            further[n, :3] = energy_budget(_problem(block, n, paths), radau(STAGES), work, ledger)
        if pressure and status in (Status.SEPARATED, Status.CAPTURED):
            further[n, -1] = peak_pressure(_problem(block, n, paths), radau(STAGES), work, *rules)


@dataclass(frozen=True, eq=False)
class Stored:
    """Problem and stored halves, approach and rebound, of one impact that ended in separation.

    `halves` is without scratch space, which few solutions need and `work` has.
    """

    problem: Problem
    halves: Work

    @cached_property
    def work(self) -> Work:
        """The stored halves with scratch space of their own, as others may use theirs at the same time."""
        from restitution.kernel.workspace import allocate

        scratch = allocate(self.problem.moduli.size, 0)
        return self.halves._replace(**{name: getattr(scratch, name) for name in _SCRATCH})

    @cached_property
    @single_problem()
    def ledger(self) -> Ledger:
        """Memory of the foundation, and energies, along both halves."""
        from restitution.kernel.collocation import radau
        from restitution.kernel.stored import allocate_ledger, energy_budget

        approach, rebound = len(self.halves.approach), len(self.halves.rebound)
        ledger = allocate_ledger(self.problem.moduli.size, max(approach, rebound))
        energy_budget(self.problem, radau(STAGES), self.work, ledger)
        return ledger._replace(approach=ledger.approach[:approach], rebound=ledger.rebound[:rebound])

    @property
    def energies(self) -> tuple[float, float, float]:
        """Energies dissipated, stored in elements when they leave, and radiated, in units of m v0^2."""
        end = self.ledger.rebound[-1, :, -1]
        return float(end[-4]), float(end[-1]), float(end[-3])

    @property
    @single_problem()
    def peak_pressure(self) -> float:
        """Largest pressure, scaled; see `restitution.kernel.stored`."""
        from restitution.kernel.collocation import radau
        from restitution.kernel.stored import graded_rule, peak_pressure

        return float(peak_pressure(self.problem, radau(STAGES), self.work, graded_rule(4), graded_rule(8)))


def solve_stored(block: ScaledBlock, rtol: float) -> tuple[Array, Stored | None]:
    """Solve a block of one impact; return its outcome, and the stored halves if it ends in separation."""
    from restitution.kernel.workspace import N_APPROACH, N_REBOUND

    outcomes, paths, work = np.empty((1, len(OUTCOME))), kernel_paths(block), _kept_work(block.moduli.size)
    _solve_part(block, paths, rtol, work, outcomes)
    if outcomes[0, STATUS] != Status.SEPARATED:
        return outcomes, None
    approach, rebound = work.counts[N_APPROACH] + 1, work.counts[N_REBOUND] + 1
    halves = work._replace(
        **_NO_SCRATCH, approach=work.approach[:approach].copy(), rebound=work.rebound[:rebound].copy(),
        places=work.places[:, : max(approach, rebound)].copy(), slopes=work.slopes[:rebound].copy(),
        turning=work.turning.copy(), turning_place=work.turning_place.copy(), counts=work.counts.copy(),
    )  # fmt: skip
    return outcomes, Stored(_problem(block, 0, paths), halves)


def solve_forces(block: ScaledBlock, rtol: float, times: Array) -> tuple[Array, Array]:
    """Solve a block; return its outcomes, and the scaled forces at ascending times, both of shape (n, n_time).

    The forces are 0 outside the contact, and NaN where the body does not separate.
    """
    from restitution.kernel.collocation import radau
    from restitution.kernel.stored import sample_forces

    outcomes, forces = np.empty((block.size, len(OUTCOME))), np.full(times.shape, np.nan)
    paths, work = kernel_paths(block), _kept_work(block.most_modes)
    for n in range(block.size):
        _solve_part(block.part(n, n + 1), paths, rtol, work, outcomes[n : n + 1])
        if outcomes[n, STATUS] == Status.SEPARATED:
            sample_forces(radau(STAGES), work, times[n], forces[n])
    return outcomes, forces


def _problems(block: ScaledBlock, paths: Path) -> Problems:
    from restitution.kernel.workspace import Problems

    return Problems(
        block.firsts, block.equilibria, block.viscosities, block.external_forces, block.admittances, block.offsets,
        block.moduli, block.times, paths, block.which,
    )  # fmt: skip


def _problem(block: ScaledBlock, n: int, paths: Path) -> Problem:
    from restitution.kernel.path import single_path
    from restitution.kernel.workspace import Problem

    modes, path = slice(block.offsets[n], block.offsets[n + 1]), single_path(paths, int(block.which[n]))
    return Problem(
        block.equilibria[n], block.moduli[modes], block.times[modes], block.viscosities[n], block.external_forces[n],
        block.admittances[n], path,
    )  # fmt: skip


# Columns of a half: s, v, t, F, then the memory H_k; the first of these, without decay, is the depth.
S_, V_, T_, F_, D_ = 0, 1, 2, 3, 4
H_ = 4


class Trajectory(NamedTuple):
    """Motion from first touch to separation, arrays of shape (n,); `restitution.quantities.HISTORY` has the units."""

    time: Array
    indentation_depth: Array
    indentation_velocity: Array
    force: Array
    contact_radius: Array
    kinetic_energy: Array | None = None
    stored_energy: Array | None = None
    dissipated_energy: Array | None = None
    radiated_energy: Array | None = None
    body_velocity: Array | None = None
    target_displacement: Array | None = None


class Half(NamedTuple):
    """E elements of S + 1 points of the approach in sigma, or of the rebound in lambda, scaled.

    `columns`, shape (E, S + 1, n), are s, v, t, F, H_k; s of the rebound is that of the approach with the same contact
    radius. `energies` are Y_k, Z_k and the energies dissipated and radiated in the approach; in the rebound, these
    two, the energy per length of an element that leaves, and `int a` over it. `share` is the part of the last element
    that belongs to the half; in the approach this element extends past the turning point.
    """

    starts: Array
    lengths: Array
    columns: Array
    energies: Array
    share: float


@dataclass(frozen=True, eq=False)
class Solution:
    """Motion of one impact that ended in separation, and memory of its foundation, as polynomials over elements."""

    units: ScaledImpact
    mass: float
    velocity: float
    stored: Stored
    contact_radii: Callable[[Array, Array], Array]
    pressures: Callable[[Any], Array]

    @cached_property
    def energies(self) -> tuple[float, float, float]:
        """Energies dissipated, stored in elements when they leave, and radiated [J]."""
        unit = self.mass * self.velocity * self.velocity
        dissipated, stored, radiated = self.stored.energies
        return unit * dissipated, unit * stored, unit * radiated

    @cached_property
    def max_pressure(self) -> float:
        """Largest contact pressure [Pa]; infinite or NaN for some profiles and materials, which need no search."""
        limit = float(self.pressures(1.0)[0])
        if not math.isfinite(limit):
            return limit
        peak = float(pressure_unit(self.mass, self.velocity, self.units)) * self.stored.peak_pressure
        return float(self.pressures(peak)[0])

    @property
    def sigma_m(self) -> float:
        """Length of the approach in sigma."""
        return float(self.stored.halves.turning_place[0])

    @property
    def deepest(self) -> float:
        """Largest s, the square root of the scaled depth."""
        return float(self.stored.halves.turning[S_])

    @property
    def end(self) -> float:
        """Scaled time of separation."""
        return float(self.stored.halves.rebound[-1, T_, -1])

    @property
    def contact_time(self) -> float:
        """Contact time [s]."""
        return self.end * self.units.time

    @property
    def turning_time(self) -> float:
        """Time [s] at which the indentation is deepest."""
        return float(self.stored.halves.turning[T_]) * self.units.time

    @cached_property
    def scheme(self) -> Scheme:
        """Collocation scheme of the kernel."""
        from restitution.kernel.collocation import radau

        return radau(STAGES)

    @cached_property
    def rates(self) -> Array:
        """Rates of decay 1/tau_k; the first is that of the spring in parallel, 0."""
        return np.append(0.0, 1.0 / self.units.times)

    @cached_property
    def moduli(self) -> Array:
        """Moduli of the branches; the first is that of the spring in parallel."""
        return np.append(self.units.equilibrium, self.units.moduli)

    @cached_property
    def halves(self) -> Halves:
        """Both halves for the kernel."""
        from restitution.kernel.sliding import Halves
        from restitution.kernel.workspace import BACK_LENGTH, BACK_START

        work, scheme = self.stored.halves, self.scheme
        first, back = len(work.approach), len(work.rebound)
        starts, lengths = np.concatenate(
            [work.places[:BACK_START, :first], work.places[BACK_START : BACK_LENGTH + 1, :back]], axis=1
        )
        rows = np.concatenate([work.approach, work.rebound])
        paces = np.concatenate([2.0 * work.approach[:, S_, 1:], work.slopes])
        return Halves(
            scheme.c, scheme.weights, scheme.columns, scheme.identity, starts, lengths, rows, paces, first,
            self.sigma_m, self.stored.problem.path,
        )  # fmt: skip

    @cached_property
    def approach(self) -> Half:
        """The approach, over sigma."""
        from restitution.kernel.workspace import LENGTH, START

        work, memory = self.stored.halves, self.stored.ledger.approach
        starts, lengths = work.places[START, : len(memory)], work.places[LENGTH, : len(memory)]
        columns = np.concatenate([work.approach[:, : F_ + 1], memory[:, :-2:3]], axis=1)
        energies = np.concatenate([memory[:, 1:-2:3], memory[:, 2:-2:3], memory[:, -2:]], axis=1)
        share = (self.sigma_m - float(starts[-1])) / float(lengths[-1])
        return Half(starts, lengths, np.moveaxis(columns, 1, 2), np.moveaxis(energies, 1, 2), share)

    @cached_property
    def rebound(self) -> Half:
        """The rebound, over lambda."""
        from restitution.kernel.workspace import BACK_LENGTH, BACK_START

        work, memory = self.stored.halves, self.stored.ledger.rebound
        starts, lengths = work.places[BACK_START, : len(memory)], work.places[BACK_LENGTH, : len(memory)]
        columns = np.concatenate([work.rebound[:, : F_ + 1], memory[:, :-4]], axis=1)
        return Half(starts, lengths, np.moveaxis(columns, 1, 2), np.moveaxis(memory[:, -4:], 1, 2), 1.0)

    def times(self, n_points: int) -> Array:
        """Return `n_points` times [s] from first touch to separation, as dense as the solver's own steps."""
        work = self.stored.halves
        knots = np.concatenate([work.approach[:, T_, 0], work.rebound[:, T_, 0], [self.end]])
        knots = np.unique(np.clip(knots, 0.0, self.end))
        # Half of the points evenly over time, half over steps: this shows thin layers and long creep.
        passed = 0.5 * (np.linspace(0.0, 1.0, knots.size) + knots / self.end)
        times = np.interp(np.linspace(0.0, 1.0, n_points), passed, knots) * self.units.time
        times[-1] = self.contact_time
        return times

    def at(self, times: ArrayLike) -> Trajectory:
        """Return motion and energies at times [s] from 0 to the contact time; others are an `InputError`."""
        moments = within_contact(times, self.contact_time)
        t = np.minimum(moments / self.units.time, self.end)
        motion, energies = np.empty((t.size, 4)), np.empty((t.size, 3))
        coming = t <= float(self.stored.halves.turning[T_])
        places = self.find(self.approach, T_, t[coming])
        state = self.interpolate(self.approach.columns, *places)
        motion[coming] = np.column_stack([state[:, S_] ** 2, state[:, V_], state[:, F_], state[:, S_]])
        n = self.rates.size
        Y, Z, spent = np.split(self.interpolate(self.approach.energies, *places), (n, 2 * n), 1)
        # At first touch the difference is rounding.
        squares = np.maximum(2.0 * state[:, H_:] * Y - Z, 0.0)
        energies[coming] = np.column_stack([0.5 * squares @ self.moduli, spent])

        places = self.find(self.rebound, T_, t[~coming])
        state = self.interpolate(self.rebound.columns, *places)
        sigma = np.maximum(self.sigma_m - self.position(self.rebound, *places), 0.0)
        sigma[t[~coming] >= self.end] = 0.0
        squares, density, s1 = self._foundation(state, sigma)
        motion[~coming] = np.column_stack([state[:, D_], state[:, V_], state[:, F_], s1])
        lost, radiated, _, released = self.interpolate(self.rebound.energies, *places).T
        kept = 0.5 * squares @ self.moduli + released - self.radius(s1) * density
        energies[~coming] = np.column_stack([kept, lost, radiated])

        velocity, unit = motion[:, 1] * self.velocity, self.mass * self.velocity * self.velocity
        body_velocity = velocity + (self.units.admittance * self.velocity) * np.maximum(motion[:, 2], 0.0)
        trajectory = Trajectory(
            np.minimum(moments, self.contact_time), motion[:, 0] * self.units.length, velocity,
            np.maximum(motion[:, 2], 0.0) * (self.mass * self.velocity / self.units.time),
            self.contact_radii(self.radius(motion[:, 3]) * self.units.radius, motion[:, 3] ** 2 * self.units.length),
            0.5 * self.mass * body_velocity * body_velocity,
            energies[:, 0] * unit, energies[:, 1] * unit,
        )  # fmt: skip
        if self.units.admittance == 0.0:
            return trajectory
        # By momentum: the target moves with F/Z.
        moved = (self.units.admittance * self.units.time) * (self.velocity - body_velocity)
        return trajectory._replace(
            radiated_energy=energies[:, 2] * unit, body_velocity=body_velocity, target_displacement=moved
        )

    def _foundation(self, state: Array, sigma: Array) -> tuple[Array, Array, Array]:
        """Return integrals of w_k^2, energy per length at the edge of contact, and s, for the approach at sigma."""
        places, n = self.places(self.approach, sigma), self.rates.size
        past = self.interpolate(self.approach.columns, *places)
        Y, Z = np.split(self.interpolate(self.approach.energies, *places)[:, : 2 * n], 2, axis=1)
        decay = np.exp(np.minimum((past[:, T_] - state[:, T_])[:, None] * self.rates, 0.0))
        edge = state[:, H_:] - decay * past[:, H_:]
        s = np.where(sigma > 0.0, np.maximum(past[:, S_], 0.0), 0.0)
        squares = self.radius(s)[:, None] * edge**2 + decay * (2.0 * state[:, H_:] * Y - decay * Z)
        return squares, 0.5 * edge**2 @ self.moduli, s

    def basis(self, x: Array) -> Array:
        """Return the Lagrange basis of an element at x in [0, 1], shape (n, S + 1)."""
        c = self.scheme.c
        below, above = np.ones((c.size, x.size)), np.ones((c.size, x.size))
        for j in range(1, c.size):
            below[j] = below[j - 1] * (x - c[j - 1])
            above[-1 - j] = above[-j] * (x - c[-j])
        basis = np.ascontiguousarray((below * above).T) * self.scheme.weights
        # Exactly one at a node.
        return basis / basis.sum(axis=1, keepdims=True)

    def interpolate(self, columns: Array, element: Places, x: Array) -> Array:
        """Return columns, shape (E, S + 1, n), at the places x in elements."""
        basis, rows = self.basis(x)[..., None], columns[element]
        # One after the other, so that the bits of a point do not depend on the number of points.
        total = basis[:, 0] * rows[:, 0]
        for j in range(1, rows.shape[1]):
            total += basis[:, j] * rows[:, j]
        return total

    @single_problem()
    def find(self, half: Half, column: int, values: Array) -> tuple[Places, Array]:
        """Return the elements, and the places in them, where a rising column takes these values."""
        from restitution.kernel.stored import find_rising

        order = np.argsort(values)
        elements, places = np.empty(values.size, dtype=np.intp), np.empty(values.size)
        rows = np.ascontiguousarray(half.columns[..., column])
        find_rising(self.scheme, self.stored.work, rows, half.share, values[order], elements, places)
        back = np.argsort(order)
        return elements[back], places[back]

    def approach_at(self, sigma: Array) -> Array:
        """Return the columns of the approach at sigma, shape (n, 5 + N)."""
        return self.interpolate(self.approach.columns, *self.places(self.approach, sigma))

    def places(self, half: Half, position: Array) -> tuple[Places, Array]:
        """Return the elements that contain positions in sigma or lambda, and the places in them."""
        element = np.clip(np.searchsorted(half.starts, position, side="right") - 1, 0, half.starts.size - 1)
        return element, (position - half.starts[element]) / half.lengths[element]

    def position(self, half: Half, element: Places, x: Array) -> Array:
        """Return the positions in sigma or lambda of places in elements."""
        return half.starts[element] + x * half.lengths[element]

    def radius(self, s: Array) -> Array:
        """Return the scaled stiffness radius at s, the square root of the scaled depth, any shape."""
        units = self.units
        if units.table is None:
            return np.maximum(s, 0.0) ** units.exponent
        return evaluate(units.table, s)[0]


class SampledSolution(NamedTuple):
    """History, arrays of shape (n_time,), and results of one impact by a method in steps.

    In SI units. The history of a body that does not separate ends when its status is decided. `stored` is the energy
    in elements when they leave, `restitution_error` an estimate of the error of e.
    """

    time: Array
    indentation_depth: Array
    indentation_velocity: Array
    force: Array
    contact_radius: Array
    restitution_coefficient: float
    contact_time: float
    max_indentation_depth: float
    max_force: float
    max_contact_radius: float
    residual_indentation_depth: float
    status: Status
    dissipated: float = math.nan
    stored: float = math.nan
    radiated: float = math.nan
    time_step: float = math.nan
    restitution_error: float = math.nan


class Sampled(NamedTuple):
    """Samples of the motion, and the energies dissipated, stored and radiated [J], NaN where the method has none."""

    trajectory: Trajectory
    dissipated: float = math.nan
    stored: float = math.nan
    radiated: float = math.nan

    def at(self, times: ArrayLike | None) -> Trajectory:
        """Return the samples, or linear interpolants at the given times [s]."""
        if times is None:
            return self.trajectory
        knots = self.trajectory.time
        t = within_contact(times, float(knots[-1]))
        return Trajectory(*(np.interp(t, knots, values) for values in self.trajectory if values is not None))


class PanelMotion:
    """Motion of an impact by panels, in SI, from the touch of a surface to the separation.

    Parameters
    ----------
    panels : PanelSolution
        Solution, with the surface at the end.
    surface : Surface
        The surface at the touch.
    """

    # Samples of the motion, beside knots and turnings, over the history in which the impact is looked for.
    _POINTS = 2001
    radiated = 0.0

    def __init__(self, panels: PanelSolution, surface: Surface) -> None:
        self.panels, self._surface = panels, surface

    @cached_property
    def stored(self) -> float:
        """Energy [J] that the impact leaves in the surface."""
        return self.panels.elements.stored - self._surface.stored

    @property
    def dissipated(self) -> float:
        """Energy [J] that the material dissipates."""
        return self.panels.work - self.stored

    def at(self, times: ArrayLike | None) -> Trajectory:
        """Return the motion at given times [s], or at even ones."""
        end = self.panels.stop
        if times is None:
            moments = self.panels.times(self._POINTS)
            moments = np.append(moments[moments < end], end)
        else:
            moments = np.minimum(within_contact(times, end), end)
        return Trajectory(moments, *self.panels.at(moments, before=True))


def pressure_unit(mass: Any, velocity: Any, units: ScaledImpact | ScaledBlock) -> Any:
    """Return the unit of the scaled pressure [Pa]."""
    return mass * velocity / (units.time * 2.0 * math.pi * units.radius) / units.radius


def within_contact(times: ArrayLike, contact_time: float) -> Array:
    """Return times [s], shape (n,); refuse times outside the contact."""
    moments = np.atleast_1d(np.asarray(finite("times", times, "s"), dtype=np.float64))
    if moments.ndim != 1:
        raise InputError("times", rule=f"must be one column, not of shape {moments.shape}")
    outside = (moments < 0.0) | (moments > contact_time * (1.0 + 1e-12))
    if np.any(outside):
        rule = f"must be in [0, {contact_time:g}] s, the duration of contact"
        raise InputError("times", float(moments[outside][0]), rule, "s")
    return moments
