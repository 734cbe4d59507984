"""Standard error and exit codes of the commands: errors, warnings, notes and progress.

0: done. 2: bad input, the command line's included. 3: a solver that failed. 70: a mistake in the program, which
should be reported; `--debug` or RESTITUTION_TRACEBACK=1 shows the traceback. Ctrl-C ends the run by its signal, which
shells show as 130.
"""

from __future__ import annotations

import errno
import os
import sys
import traceback
import warnings
from collections.abc import Callable, Generator
from contextlib import contextmanager
from typing import Any, cast

import typer
from typer.core import TyperGroup

from restitution.errors import InputTypeError, RestitutionWarning
from restitution.impact.status import SolverError

DONE = 0
BAD_INPUT = 2
SOLVER_FAILED = 3
BUG = 70
INTERRUPTED = 130

# Errors that input can cause. A TypeError without a field, an AttributeError and the like are mistakes of the program.
_OF_INPUT = (ValueError, InputTypeError, ArithmeticError, MemoryError, RuntimeError)

_COLOURS = {"error": "red", "warning": "yellow", "note": "cyan"}

# Base class of the errors for unknown options and missing arguments, which typer does not export.
_UsageProblem = cast("type[Exception]", typer.BadParameter.__mro__[2])


class BadInput(Exception):
    """Input that cannot be used; each line of the message is one mistake."""


@contextmanager
def user_input() -> Generator[None]:
    """Turn errors that the input causes into `BadInput`; a `SolverError` passes."""
    try:
        yield
    except SolverError:
        raise
    except _OF_INPUT as error:
        raise BadInput(_reason(error)) from error


def _reason(error: BaseException) -> str:
    match error:
        case MemoryError():
            return "the input needs more memory than there is"
        case RecursionError():
            return "the input is nested too deeply"
        case OverflowError():
            return f"numbers leave the range of a double ({error})"
        case _:
            return str(error) or type(error).__name__


def report(kind: str, *messages: str) -> None:
    """Write each message on standard error as a line that begins with its kind: "error", "warning" or "note"."""
    from rich.console import Console
    from rich.text import Text

    console = Console(stderr=True, highlight=False)
    for message in messages:
        console.print(Text.assemble((f"{kind}:", f"bold {_COLOURS[kind]}"), " ", message), soft_wrap=True)


def exit_code(command: Callable[[], Any]) -> int:
    """Run a command and return its exit code; an error is one line on standard error."""
    try:
        code = command()
        if code == INTERRUPTED:
            raise KeyboardInterrupt
        return code if isinstance(code, int) else DONE
    except _UsageProblem as error:
        problem: Any = error
        # Without any argument, typer shows the help alone.
        if message := " ".join(problem.format_message().split()):
            where = problem.ctx.command_path if getattr(problem, "ctx", None) else "restitution"
            report("error", f"{message} (see: {where} --help)")
        return BAD_INPUT
    except BadInput as error:
        report("error", *str(error).split("\n"))
        return BAD_INPUT
    except SolverError as error:
        report("error", str(error))
        return SOLVER_FAILED
    except OSError as error:
        if error.errno == errno.EINTR:
            raise
        reason = error.strerror or str(error) or type(error).__name__
        report("error", f"{error.filename}: {reason}" if error.filename else reason)
        return BAD_INPUT
    except (KeyboardInterrupt, typer.Abort):
        report("error", "interrupted; every file written is whole")
        return INTERRUPTED
    except (typer.Exit, SystemExit):
        raise
    except _OF_INPUT as error:
        return _show(error, _reason(error), BAD_INPUT)
    except Exception as error:
        what = f"{type(error).__name__}: {error}".splitlines()[0][:200]
        hint = "this is a mistake in the program; please report it, with what --debug prints"
        return _show(error, f"{what}; {hint}", BUG)


def _show(error: Exception, message: str, code: int) -> int:
    if os.environ.get("RESTITUTION_TRACEBACK", "") not in ("", "0"):
        traceback.print_exception(error)
    report("error", " ".join(message.split()))
    return code


@contextmanager
def collected_warnings() -> Generator[list[str]]:
    """Yield a list that has the warnings of the block after its end, each once."""
    messages: list[str] = []
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always", RestitutionWarning)
        yield messages
    messages += dict.fromkeys(str(one.message) for one in caught)


@contextmanager
def compilation() -> Generator[None]:
    """Give the kernel's note on its compilation the form of the other notes."""
    from restitution.kernel import compile as compiler

    plain = compiler.write_note
    compiler.write_note = lambda text: report("note", text)
    try:
        yield
    finally:
        compiler.write_note = plain


@contextmanager
def progress_bar(
    words: str, rate: str = "", begin: str = "preparing the kernel"
) -> Generator[Callable[[int, int], None]]:
    """Yield a function of (done, total) that draws a bar with the time left, on a terminal only.

    `rate` is the unit of the speed that is shown, such as "impacts/s"; `begin` is shown until the first report.
    """
    from rich.console import Console
    from rich.progress import Progress, ProgressColumn, Task
    from rich.text import Text

    class RateColumn(ProgressColumn):
        def render(self, task: Task) -> Text:
            speed = task.finished_speed or task.speed
            return Text(f"{speed:.3g} {rate}" if speed and rate else "")

    console = Console(stderr=True)
    columns = (*Progress.get_default_columns(), RateColumn())
    with Progress(*columns, console=console, disable=not console.is_terminal, transient=True) as bar:
        # Until the first report the kernel is loaded or compiled.
        task = bar.add_task(begin, total=None)
        yield lambda done, total: bar.update(task, description=words, completed=done, total=total)


@contextmanager
def _patient_with_readers() -> Generator[None]:
    """End without an error where the reader of the pipe, such as `head`, closes it."""
    try:
        yield
        sys.stdout.flush()
    except (BrokenPipeError, SystemExit) as error:
        # Rich turns a broken pipe into an exit with code 1.
        if isinstance(error, SystemExit) and not isinstance(error.__context__, BrokenPipeError):
            raise
        # Otherwise the interpreter fails on the closed pipe when it ends.
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        raise typer.Exit(DONE) from None


class Commands(TyperGroup):
    """The commands; each ends with one of the exit codes, without a traceback for bad input."""

    def make_context(self, *args: Any, **extra: Any) -> Any:
        with _patient_with_readers():
            return super().make_context(*args, **extra)

    def invoke(self, ctx: Any) -> Any:
        with _patient_with_readers():
            return super().invoke(ctx)

    def main(self, *args: Any, standalone_mode: bool = True, **extra: Any) -> Any:
        parse = super().main
        if not standalone_mode:
            return parse(*args, standalone_mode=False, **extra)
        sys.exit(exit_code(lambda: parse(*args, standalone_mode=False, **extra)))
