"""Exit codes of the commands, and the line of an error.

0: done. 2: bad input, the command line's included. 3: a solver that failed. 70: a mistake in the program, which
should be reported; `--debug` or RESTITUTION_TRACEBACK=1 shows the traceback. Ctrl-C ends the run by its signal, which
shells show as 130.
"""

from __future__ import annotations

import errno
import os
import sys
import traceback
from collections.abc import Callable, Generator
from contextlib import contextmanager
from typing import Any, cast

import typer
from typer.core import TyperGroup

from restitution.errors import InputTypeError
from restitution.impact.status import SolverError

DONE = 0
BAD_INPUT = 2
SOLVER_FAILED = 3
BUG = 70
INTERRUPTED = 130

# Errors that input can cause. A TypeError without a field, an AttributeError and the like are mistakes of the program.
_OF_INPUT = (ValueError, InputTypeError, ArithmeticError, MemoryError, RuntimeError)

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
    text = str(error)
    if isinstance(error, MemoryError):
        return "the input needs more memory than there is"
    if isinstance(error, RecursionError):
        return "the input is nested too deeply"
    if isinstance(error, OverflowError):
        return f"numbers leave the range of a double ({text})"
    return text or type(error).__name__


def tell(kind: str, message: str, colour: str) -> None:
    """Write one line on standard error, coloured where that is a terminal."""
    from rich.console import Console
    from rich.text import Text

    console = Console(stderr=True, highlight=False)
    console.print(Text.assemble((f"{kind}:", f"bold {colour}"), " ", message), soft_wrap=True)


def warn(message: str) -> None:
    """Write a warning on standard error."""
    tell("warning", message, "yellow")


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
            tell("error", f"{message} (see: {where} --help)", "red")
        return BAD_INPUT
    except BadInput as error:
        for line in str(error).split("\n"):
            tell("error", line, "red")
        return BAD_INPUT
    except SolverError as error:
        tell("error", str(error), "red")
        return SOLVER_FAILED
    except OSError as error:
        if error.errno == errno.EINTR:
            raise
        reason = error.strerror or str(error) or type(error).__name__
        tell("error", f"{error.filename}: {reason}" if error.filename else reason, "red")
        return BAD_INPUT
    except (KeyboardInterrupt, typer.Abort):
        tell("error", "interrupted; every file written is whole", "red")
        return INTERRUPTED
    except (typer.Exit, SystemExit):
        raise
    except _OF_INPUT as error:
        return _show(error, _reason(error), BAD_INPUT)
    except Exception as error:
        what = f"{type(error).__name__}: {error}".splitlines()[0][:200]
        hint = "this is a mistake in the program; please report it, with what --debug prints"
        return _show(error, f"{what}; {hint}", BUG)


def debugging() -> bool:
    """Whether tracebacks are wanted."""
    return os.environ.get("RESTITUTION_TRACEBACK", "") not in ("", "0")


def _show(error: Exception, message: str, code: int) -> int:
    if debugging():
        traceback.print_exception(error)
    tell("error", " ".join(message.split()), "red")
    return code


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
        """Parse the command line, which may print help."""
        with _patient_with_readers():
            return super().make_context(*args, **extra)

    def invoke(self, ctx: Any) -> Any:
        """Run a command."""
        with _patient_with_readers():
            return super().invoke(ctx)

    def main(self, *args: Any, standalone_mode: bool = True, **extra: Any) -> Any:
        """Parse the command line and run the command."""
        parse = super().main
        if not standalone_mode:
            return parse(*args, standalone_mode=False, **extra)
        sys.exit(exit_code(lambda: parse(*args, standalone_mode=False, **extra)))
