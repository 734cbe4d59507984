"""Signs of progress: a line while the kernel compiles, a bar with the time left."""

from __future__ import annotations

import sys
from collections.abc import Callable, Generator
from contextlib import contextmanager
from threading import Timer

from restitution.cli.exit_codes import tell

# Loading the compiled kernel from its cache takes about 0.3 s, compiling it 10 s and more.
_SUSPICIOUS = 1.5


@contextmanager
def compilation() -> Generator[None]:
    """Print a note on a terminal if the block takes long because the kernel is compiled."""
    if not sys.stderr.isatty():
        yield
        return
    timer = Timer(_SUSPICIOUS, _explain)
    timer.daemon = True
    timer.start()
    try:
        yield
    finally:
        timer.cancel()


def _explain() -> None:
    from restitution.impact.exact import is_ready

    if not is_ready():
        tell("note", "compiling the kernel, as the first solve after an installation does", "cyan")


@contextmanager
def progress_bar(words: str, rate: str = "") -> Generator[Callable[[int, int], None]]:
    """Yield a function of (done, total) that draws a bar with the time left, on a terminal only.

    `rate` is the unit of the speed that is shown, such as "impacts/s".
    """
    from rich.console import Console
    from rich.progress import (
        BarColumn,
        Progress,
        ProgressColumn,
        Task,
        TaskProgressColumn,
        TextColumn,
        TimeElapsedColumn,
        TimeRemainingColumn,
    )
    from rich.text import Text

    class RateColumn(ProgressColumn):
        def render(self, task: Task) -> Text:
            speed = task.finished_speed or task.speed
            return Text(f"{speed:.3g} {rate}" if speed and rate else "")

    console = Console(stderr=True)
    columns = (
        TextColumn("{task.description}"),
        BarColumn(),
        TaskProgressColumn(),
        TimeElapsedColumn(),
        TextColumn("left"),
        TimeRemainingColumn(),
        RateColumn(),
    )
    with Progress(*columns, console=console, disable=not console.is_terminal, transient=True) as bar:
        # Until the first report the kernel is loaded or compiled.
        task = bar.add_task("preparing the kernel", total=None)
        yield lambda done, total: bar.update(task, description=words, completed=done, total=total)
