"""Commands of one solve: the kernel as plain Python where that is faster than its compilation.

One solve takes about a second without machine code, and the compiler takes ten to forty. So as long as there is no
machine code, these commands run the same functions without numba. Together they may take `PATIENCE` in this way; then
the next one compiles. A solve that takes as long alone begins again with the compiler, before anything is written.
"""

from __future__ import annotations

import os
import signal
import sys
import time
from collections.abc import Generator
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import TYPE_CHECKING

from restitution.cli.terminal import compilation
from restitution.kernel.cache import cache_folder, has_machine_code, stamp

if TYPE_CHECKING:
    from restitution.result import Result

PATIENCE = 10.0
"""Processor time [s] of one command without the compiler."""

ENTRY_POINTS = {
    "solve": ("kernel.impact.solve_block", "kernel.stored.energy_budget", "kernel.stored.peak_pressure"),
    "standard-solid": ("kernel.impact.solve_block", "kernel.stored.energy_budget", "kernel.stored.peak_pressure"),
    "bounce": ("kernel.impact.solve_block",),
    "indent": ("kernel.growing.grow_contact", "kernel.program.run"),
    "oscillate": ("material.secular.secular_rows", "kernel.rim.settle_rims"),
}
"""Functions of the kernel whose machine code a command would load."""

# Numba reads this when it is imported.
_SWITCH = "NUMBA_DISABLE_JIT"
_processes = False


def allow() -> None:
    """Let commands switch the compiler off: this process ends after one of them."""
    global _processes
    _processes = True


@contextmanager
def single_solve(command: str) -> Generator[None]:
    """Solve one problem in the block, and write nothing there: it may begin again."""
    if not is_plain(command):
        with compilation():
            yield
        return
    os.environ[_SWITCH] = "1"
    begin = time.process_time()
    try:
        with _within(PATIENCE):
            yield
    finally:
        write_spent(command, _spent(command) + time.process_time() - begin)


def complete(result: Result) -> None:
    """Evaluate what a result finds on first use, such as energies and the largest pressure, before it is written."""
    result.to_dict()


def is_plain(command: str) -> bool:
    """Return whether a command runs without the compiler; a user who has set the switch has decided."""
    if not _processes or "numba" in sys.modules or _SWITCH in os.environ:
        return False
    return not has_machine_code(*ENTRY_POINTS[command]) and _spent(command) < PATIENCE


@contextmanager
def _within(seconds: float) -> Generator[None]:
    """Begin the process again, with the compiler, if the block takes more processor time than this."""
    if not hasattr(signal, "setitimer"):
        # Windows has no clock that interrupts a calculation.
        yield
        return
    signal.signal(signal.SIGVTALRM, _begin_again)
    signal.setitimer(signal.ITIMER_VIRTUAL, seconds)
    try:
        yield
    finally:
        signal.setitimer(signal.ITIMER_VIRTUAL, 0.0)


def _begin_again(*_: object) -> None:
    os.execve(sys.executable, [sys.executable, *sys.orig_argv[1:]], os.environ | {_SWITCH: "0"})


def note_of(command: str) -> Path | None:
    """Return the file with the processor time that a command has taken; None where nothing can be kept."""
    folder = cache_folder()
    return None if folder is None else Path(folder) / f"plain.{command}-{stamp(Path(__file__).parents[1] / 'kernel')}"


def _spent(command: str) -> float:
    """Return the processor time [s] that a command has taken without the compiler."""
    note = note_of(command)
    with suppress(OSError, ValueError):
        return float(note.read_text("ascii")) if note else 0.0
    return 0.0


def write_spent(command: str, seconds: float) -> None:
    """Keep the processor time [s] that a command has taken without the compiler."""
    note = note_of(command)
    with suppress(OSError):
        if note:
            note.write_text(f"{seconds:.2f}", "ascii")
