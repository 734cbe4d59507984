"""The exact method: blocks of scaled impacts in the compiled kernel, on a pool of threads."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property
from threading import Lock, local
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from restitution.impact.status import Status
from restitution.kernel.outcome import OUTCOME, STATUS
from restitution.parallel import on_threads

if TYPE_CHECKING:
    from restitution.impact.scaling import ScaledBlock
    from restitution.kernel.energy import Ledger
    from restitution.kernel.path import Path
    from restitution.kernel.workspace import Problem, Work

Array = NDArray[np.float64]
Progress = Callable[[int, int], None]

STAGES = 8
# Impacts in a task: about 10 ms, so that Ctrl-C and progress are prompt and the overhead of the pool is negligible.
_CHUNK = 512
_KEPT = local()

# Measured tolerances of an element that keep the error of e below rtol max(e, 1e-3): the error at the end of an
# element falls faster than the error inside it.
_RTOL = (-14.0, -12.0, -11.0, -10.0, -9.0, -8.0, -6.0, -4.0, -2.0)
_ELEMENT_TOLERANCE = (-12.0, -9.2, -8.3, -7.75, -7.1, -6.4, -5.3, -4.6, -4.4)


def element_tolerance(rtol: float) -> float:
    """Return the tolerance of one element that keeps the error of e below rtol max(e, 1e-3); see validation/."""
    return float(10.0 ** np.interp(math.log10(rtol), _RTOL, _ELEMENT_TOLERANCE))


def newton_tolerance(rtol: float) -> float:
    """Return the largest accepted relative error of the Newton iteration; below 2e-14 there is only rounding."""
    return min(max(5e-2 * rtol, 2e-14), 1e-7)


def kernel_paths(block: ScaledBlock) -> Path:
    """Return the geometries of a block for the kernel; row n has the geometry which[n]."""
    from restitution.kernel.path import power_path, several_paths, table_path

    return several_paths(power_path(block.exponent)) if block.tables is None else table_path(block.tables)


def solve_scaled(
    block: ScaledBlock, rtol: float, *, workers: int | None = None, progress: Progress | None = None,
    budget: bool = False, pressure: bool = False, approaches: bool = False,
) -> Array:  # fmt: skip
    """Solve a block of impacts, or their approaches; return columns `restitution.kernel.outcome.OUTCOME`, scaled.

    On request, further columns are the energies dissipated, stored and radiated, in units of m v0^2, and the largest
    pressure; see `restitution.kernel.pressure`. Approaches have the columns of `restitution.kernel.turning`. The other
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
    """Scratch space that this thread keeps for the next block; new memory costs as much as ten impacts."""
    from restitution.kernel.impact import MAX_ELEMENTS
    from restitution.kernel.workspace import allocate

    work: Work | None = getattr(_KEPT, "work", None)
    if work is None or work.inverses.shape[0] != modes:
        work = _KEPT.work = allocate(modes, MAX_ELEMENTS)
    return work


def _turn_part(block: ScaledBlock, paths: Path, rtol: float, work: Work, outcomes: Array) -> None:
    """Solve the approaches of a block in one call of the kernel, and whole impacts where there is no turning point."""
    from restitution.kernel.radau import radau
    from restitution.kernel.turning import turning_block

    turning_block(
        radau(STAGES), element_tolerance(rtol), newton_tolerance(rtol), block.firsts, block.equilibria,
        block.viscosities, block.external_forces, block.admittances, block.offsets, block.moduli, block.times, paths,
        block.which, work, outcomes,
    )  # fmt: skip
    for n in np.flatnonzero(outcomes[:, STATUS] != Status.SEPARATED).tolist():
        _solve_part(block.part(n, n + 1), paths, rtol, work, outcomes[n : n + 1])


def _solve_part(block: ScaledBlock, paths: Path, rtol: float, work: Work, outcomes: Array) -> None:
    """Solve a block in one call of the kernel."""
    from restitution.kernel.impact import solve_block
    from restitution.kernel.radau import radau

    solve_block(
        radau(STAGES), element_tolerance(rtol), newton_tolerance(rtol), block.firsts, block.equilibria,
        block.viscosities, block.external_forces, block.admittances, block.offsets, block.moduli, block.times, paths,
        block.which, work, outcomes,
    )  # fmt: skip
    outcomes[np.isnan(block.equilibria), STATUS] = Status.NOT_FINITE


def _solve_each(
    block: ScaledBlock, paths: Path, rtol: float, work: Work, outcomes: Array, further: Array,
    budget: bool, pressure: bool,
) -> None:  # fmt: skip
    """Solve a block one by one, with the energies in units of m v0^2 and the largest pressure."""
    from restitution.kernel.energy import allocate_ledger, energy_budget
    from restitution.kernel.impact import MAX_ELEMENTS
    from restitution.kernel.pressure import graded_rule, peak_pressure
    from restitution.kernel.radau import radau

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
    """Problem and stored halves, approach and rebound, of one impact that ended in separation."""

    problem: Problem
    work: Work

    @cached_property
    def ledger(self) -> Ledger:
        """Memory of the foundation, and energies, along both halves."""
        from restitution.kernel.energy import allocate_ledger, energy_budget
        from restitution.kernel.radau import radau

        approach, rebound = len(self.work.approach), len(self.work.rebound)
        ledger = allocate_ledger(self.problem.moduli.size, max(approach, rebound))
        energy_budget(self.problem, radau(STAGES), self.work, ledger)
        return ledger._replace(approach=ledger.approach[:approach], rebound=ledger.rebound[:rebound])

    @property
    def energies(self) -> tuple[float, float, float]:
        """Energies dissipated, stored in elements when they leave, and radiated, in units of m v0^2."""
        end = self.ledger.rebound[-1, :, -1]
        return float(end[-4]), float(end[-1]), float(end[-3])

    @property
    def peak_pressure(self) -> float:
        """Largest pressure, scaled; see `restitution.kernel.pressure`."""
        from restitution.kernel.pressure import graded_rule, peak_pressure
        from restitution.kernel.radau import radau

        return float(peak_pressure(self.problem, radau(STAGES), self.work, graded_rule(4), graded_rule(8)))


def solve_stored(block: ScaledBlock, rtol: float) -> tuple[Array, Stored | None]:
    """Solve a block of one impact; return its outcome, and the stored halves if it ends in separation."""
    from restitution.kernel.impact import MAX_ELEMENTS
    from restitution.kernel.workspace import N_APPROACH, N_REBOUND, allocate

    outcomes, paths = np.empty((1, len(OUTCOME))), kernel_paths(block)
    work = allocate(block.most_modes, MAX_ELEMENTS)
    _solve_part(block, paths, rtol, work, outcomes)
    if outcomes[0, STATUS] != Status.SEPARATED:
        return outcomes, None
    approach, rebound = work.counts[N_APPROACH] + 1, work.counts[N_REBOUND] + 1
    kept = work._replace(
        approach=work.approach[:approach].copy(), rebound=work.rebound[:rebound].copy(),
        places=work.places[:, : max(approach, rebound)].copy(), slopes=work.slopes[:rebound].copy(),
    )  # fmt: skip
    return outcomes, Stored(_problem(block, 0, paths), kept)


def solve_forces(block: ScaledBlock, rtol: float, times: Array) -> tuple[Array, Array]:
    """Solve a block; return its outcomes, and the scaled forces at ascending times, both of shape (n, n_time).

    The forces are 0 outside the contact, and NaN where the body does not separate.
    """
    from restitution.kernel.radau import radau
    from restitution.kernel.sampling import sample_forces

    outcomes, forces = np.empty((block.size, len(OUTCOME))), np.full(times.shape, np.nan)
    paths, work = kernel_paths(block), _kept_work(block.most_modes)
    for n in range(block.size):
        _solve_part(block.part(n, n + 1), paths, rtol, work, outcomes[n : n + 1])
        if outcomes[n, STATUS] == Status.SEPARATED:
            sample_forces(radau(STAGES), work, times[n], forces[n])
    return outcomes, forces


def _problem(block: ScaledBlock, n: int, paths: Path) -> Problem:
    from restitution.kernel.path import single_path
    from restitution.kernel.workspace import Problem

    modes, path = slice(block.offsets[n], block.offsets[n + 1]), single_path(paths, int(block.which[n]))
    return Problem(
        block.equilibria[n], block.moduli[modes], block.times[modes], block.viscosities[n], block.external_forces[n],
        block.admittances[n], path,
    )  # fmt: skip
