"""The exact method: blocks of scaled impacts through the compiled kernel, on a pool of threads."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterator
from concurrent.futures import ThreadPoolExecutor, wait
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

if TYPE_CHECKING:
    from restitution.impact.scaling import ScaledBlock
    from restitution.kernel.impact import Problem
    from restitution.kernel.path import Path
    from restitution.kernel.workspace import Work

Array = NDArray[np.float64]
Progress = Callable[[int, int], None]

STAGES = 6
# Impacts a task: some 10 ms, so that Ctrl-C and progress are prompt and the pool's own cost is lost in it.
_CHUNK = 512


def element_tolerance(rtol: float) -> float:
    """Tolerance of one element that keeps the error of e below rtol max(e, 1e-3); measured in validation/."""
    return 2.5e-7 * (rtol / 1e-9) ** (0.5 if rtol > 1e-9 else 0.8)


def newton_tolerance(rtol: float) -> float:
    """Largest accepted last step of the Newton iteration, relative."""
    return rtol


def kernel_path(block: ScaledBlock) -> Path:
    """Return the profile of a block as the kernel takes it."""
    from restitution.kernel.path import Path, power_path

    table = block.table
    if table is None:
        return power_path(block.exponent)
    length, radius = float(block.length[0]), float(block.radius[0])
    inverse_cell = table.radius.shape[0] * length**0.5 / table.s_max
    return Path(-1.0, inverse_cell, table.radius / radius, table.force_integral / (radius * length))


def solve_scaled(
    block: ScaledBlock,
    rtol: float,
    *,
    workers: int | None = None,
    progress: Progress | None = None,
    budget: bool = False,
) -> Array:
    """Solve a block of impacts.

    Parameters
    ----------
    block : ScaledBlock
        The impacts.
    rtol : float
        Relative tolerance of e.
    workers : int, optional
        Number of threads; all cores where left out. The results do not depend on it.
    progress : callable, optional
        Called with (impacts done, all impacts).
    budget : bool
        Whether to add the energy dissipated and stored as two more columns.

    Returns
    -------
    array, shape (n, 9) or (n, 11)
        Columns `restitution.kernel.impact.OUTCOME`, scaled; then the energies in units of m v0^2.
    """
    from restitution.kernel.energy import allocate_ledger, budget_block
    from restitution.kernel.impact import MAX_ELEMENTS, OUTCOME, solve_block
    from restitution.kernel.radau import radau
    from restitution.kernel.workspace import allocate

    scheme, path = radau(STAGES), kernel_path(block)
    outcomes = np.empty((block.size, len(OUTCOME) + (2 if budget else 0)))
    tolerance, accept = element_tolerance(rtol), newton_tolerance(rtol)

    def run(start: int, stop: int) -> int:
        part = block.part(start, stop)
        problem = (
            scheme, tolerance, accept, part.firsts, part.equilibria, part.viscosities, part.loads, part.offsets,
            part.moduli, part.times, path, allocate(STAGES, part.most_modes, MAX_ELEMENTS),
        )  # fmt: skip
        if budget:
            ledger = allocate_ledger(STAGES, part.most_modes, MAX_ELEMENTS)
            budget_block(*problem, ledger, outcomes[start:stop])
        else:
            solve_block(*problem, outcomes[start:stop])
        return stop - start

    workers = workers or os.cpu_count() or 1
    if block.size <= _CHUNK or workers == 1:
        done = 0
        for start, stop in _chunks(block.size):
            done += run(start, stop)
            if progress is not None:
                progress(done, block.size)
        return outcomes
    # The first chunk alone compiles; threads that start together would each do so.
    done = run(0, _CHUNK)
    with ThreadPoolExecutor(workers) as pool:
        pending = {pool.submit(run, start, stop) for start, stop in _chunks(block.size, _CHUNK)}
        try:
            while pending:
                finished, pending = wait(pending, timeout=0.2, return_when="FIRST_COMPLETED")
                done += sum(future.result() for future in finished)
                if progress is not None:
                    progress(done, block.size)
        except BaseException:
            pool.shutdown(wait=False, cancel_futures=True)
            raise
    return outcomes


def solve_stored(block: ScaledBlock, rtol: float) -> tuple[Array, Problem, Work]:
    """Solve a block of one impact and return its outcome with the stored approach and rebound."""
    from restitution.kernel.impact import MAX_ELEMENTS, OUTCOME, Problem, solve_block
    from restitution.kernel.radau import radau
    from restitution.kernel.workspace import allocate

    outcomes = np.empty((1, len(OUTCOME)))
    path = kernel_path(block)
    work = allocate(STAGES, block.most_modes, MAX_ELEMENTS)
    solve_block(
        radau(STAGES), element_tolerance(rtol), newton_tolerance(rtol), block.firsts, block.equilibria,
        block.viscosities, block.loads, block.offsets, block.moduli, block.times, path, work, outcomes,
    )  # fmt: skip
    row = block.row(0)
    problem = Problem(row.equilibrium, row.moduli, row.times, row.viscosity, row.load, path)
    return outcomes[0], problem, work


def _chunks(size: int, start: int = 0) -> Iterator[tuple[int, int]]:
    for low in range(start, size, _CHUNK):
        yield low, min(low + _CHUNK, size)


def is_ready() -> bool:
    """Whether the kernel is compiled in this process."""
    from restitution.kernel.compile import is_compiled
    from restitution.kernel.impact import solve_block

    return is_compiled(solve_block)


def outcome_columns(outcomes: Any) -> dict[str, Array]:
    """Name the columns of an outcome."""
    from restitution.kernel.impact import OUTCOME

    return {name: outcomes[:, n] for n, name in enumerate(OUTCOME)}
