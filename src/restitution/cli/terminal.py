"""Standard error and exit codes of the commands: errors, warnings, notes and progress.

0: done. 2: bad input, the command line's included. 3: a solver that failed. 70: a mistake in the program, which
should be reported; `--debug` or RESTITUTION_TRACEBACK=1 shows the traceback. Ctrl-C ends the run by its signal, which
shells show as 130.
"""

from __future__ import annotations

import errno
import inspect
import os
import sys
import traceback
import warnings
from collections.abc import Callable, Generator, Sequence
from contextlib import contextmanager
from functools import wraps
from importlib import import_module
from pathlib import Path
from tempfile import TemporaryFile
from typing import Annotated, Any, cast, get_args

import typer
from typer.core import TyperCommand, TyperGroup

from restitution.errors import InputError, InputTypeError, RestitutionWarning
from restitution.files import TABLES
from restitution.impact.status import SolverError
from restitution.units import Dimension, to_si

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
    """Input that cannot be used; each line of the message is one mistake.

    It is no ValueError, which typer would turn into the refusal of a parameter.
    """


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
    except (InputError, BadInput) as error:
        report("error", *str(error).split("\n"))
        return BAD_INPUT
    except Exception as error:
        if os.environ.get("RESTITUTION_TRACEBACK", "") not in ("", "0"):
            traceback.print_exception(error)
        if isinstance(error, _OF_INPUT):
            report("error", " ".join(_reason(error).split()))
            return BAD_INPUT
        what = f"{type(error).__name__}: {error}".splitlines()[0][:200]
        hint = "this is a mistake in the program; please report it, with what --debug prints"
        report("error", " ".join(f"{what}; {hint}".split()))
        return BUG


@contextmanager
def collected_warnings() -> Generator[list[str]]:
    """Yield a list that has the warnings of the block after its end, each once."""
    messages: list[str] = []
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always", RestitutionWarning)
        yield messages
    messages += dict.fromkeys(str(warning.message) for warning in caught)


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
def single_solve() -> Generator[None]:
    """Solve one problem in the block, without the compiler where there is no machine code.

    Its result is evaluated there, by `to_dict`: energies and pressures are computed on first use.
    """
    from restitution.kernel.plain import single_problem

    with compilation(), single_problem():
        yield


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


class _Plain:
    """Help without the types that typer shows for options without a value, <bool>, and for arguments, <list[Path]>."""

    def get_params(self, ctx: Any) -> list[Any]:
        parameters: list[Any] = super().get_params(ctx)  # pyright: ignore[reportAttributeAccessIssue]
        for parameter in parameters:
            if getattr(parameter, "is_flag", False):
                parameter.metavar = ""
            if parameter.param_type_name == "argument":
                parameter.display_type_rich = lambda ctx: None
        return parameters


# Names of what stands for a quantity in the help.
_QUANTITIES = {"LENGTH", "MASS", "TIME", "DENSITY", "VELOCITY", "TEMPERATURE", "MODULUS", "LOW HIGH", "NAME=LOW:HIGH"}
_UNITS = 'A plain number is in SI. Numbers with a unit: 10mm, 5g, 2MPa, 1cm/s, 30deg, 23degC, or "10 mm" in quotes.'


class Command(_Plain, TyperCommand):
    """A command; where it takes quantities, the last line of its help says how to write them."""

    def __init__(self, *arguments: Any, **options: Any) -> None:
        super().__init__(*arguments, **options)
        if any(getattr(each, "metavar", None) in _QUANTITIES for each in self.params):
            self.epilog = _UNITS


class Commands(_Plain, TyperGroup):
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


# Options and arguments that several commands share, and how the shell completes them.


def option(words: str, metavar: str | None = None, *names: str, **settings: Any) -> Any:
    """Return an option with its help, without its default."""
    return typer.Option(*names, help=words, metavar=metavar, show_default=False, **settings)


def argument(metavar: str, words: str, **settings: Any) -> Any:
    """Return an argument with its help, without its default."""
    return typer.Argument(metavar=metavar, help=words, show_default=False, **settings)


def read_quantity(option: str, text: str, dimension: Dimension) -> float:
    """Return a number, or a text with a unit, in SI."""
    try:
        return float(text)
    except ValueError:
        try:
            return to_si(text, dimension)
        except InputError as error:
            raise BadInput(f'{option} "{text}": {error.rule}') from None


def quantity(name: str, dimension: Dimension, words: str, metavar: str = "") -> Any:
    """Return an option that takes a number with a unit; the command gets it in SI."""
    metavar = metavar or dimension.name.upper()
    return option(words, metavar, name, parser=lambda text: read_quantity(name, text, dimension))


def ends(name: str, dimension: Dimension, words: str) -> Any:
    """Return an option that takes the lowest and the highest number with a unit."""
    return quantity(name, dimension, words, "LOW HIGH")


def taking(**options: Any) -> Callable[[Callable[..., Any]], Callable[..., Any]]:
    """Return a decorator of a command, which gets the options that are given as further keyword arguments.

    Each option is an annotation of its type with an `option`; its default is None, or False for a flag.
    """

    def with_options(command: Callable[..., Any]) -> Callable[..., Any]:
        @wraps(command)
        def call(**arguments: Any) -> Any:
            return command(**{name: value for name, value in arguments.items() if name not in options or value})

        parameters = inspect.signature(command, eval_str=True).parameters.values()
        named = [parameter for parameter in parameters if parameter.kind is not inspect.Parameter.VAR_KEYWORD]
        for name, annotation in options.items():
            default = False if get_args(annotation)[0] is bool else None
            keyword = inspect.Parameter.KEYWORD_ONLY
            named.append(inspect.Parameter(name, keyword, default=default, annotation=annotation))
        call.__signature__ = inspect.Signature(named)  # pyright: ignore[reportAttributeAccessIssue]
        call.__annotations__ = {parameter.name: parameter.annotation for parameter in named}
        return call

    return with_options


def completed(*registries: str, sign: str = "") -> Callable[[str], list[str]]:
    """Return a completion of the names of registries of the package; help must load nothing heavy."""

    def complete(incomplete: str) -> list[str]:
        choices: list[str] = []
        for registry in registries:
            module, _, name = registry.rpartition(".")
            content: Any = getattr(import_module(f"restitution.{module}"), name)
            choices += cast("list[str]", content() if callable(content) else list(content))
        return [f"{name}{sign}" for name in choices if name.startswith(incomplete)]

    return complete


def check_target(option: str, path: Path | None, suffixes: tuple[str, ...]) -> Path | None:
    """Refuse, before any work is done, a file that could not be written in the end."""
    # A store may exist already.
    if path is None or (path.suffix.lower() == ".zarr" and ".zarr" in suffixes):
        return path
    if path.suffix.lower() not in suffixes:
        raise BadInput(f"{option} {path}: must end in {_either(suffixes)}")
    if not path.parent.is_dir():
        raise BadInput(f"{option} {path}: no such folder: {path.parent}")
    if path.is_dir():
        raise BadInput(f"{option} {path}: is a folder")
    try:
        # Permissions alone do not show it: nobody writes to /proc.
        with TemporaryFile(dir=path.parent):
            return path
    except OSError:
        raise BadInput(f"{option} {path}: nothing can be written to the folder {path.parent}") from None


def target(words: str, name: str, *suffixes: str) -> Any:
    """Return an option for a file that the command writes."""
    words = f"{words}: {_either(suffixes)}."
    return option(words, "FILE", name, callback=lambda path: check_target(name, path, suffixes))


def _either(choices: Sequence[str]) -> str:
    *most, last = choices
    return f"{', '.join(most)} or {last}" if most else last


Extrapolate = Annotated[
    bool,
    typer.Option("--extrapolate", help="Go beyond the times for which the material is known, with a warning."),
]
PICTURES = (".png", ".pdf", ".svg")
CaseFile = Annotated[Path, argument("CASE.toml", "Case file.")]
CaseOrOptions = Annotated[Path | None, argument("CASE.toml", "Case file; or give --material and what it asks for.")]
_WITHOUT_FILE = "Without a case file"


def text(words: str, metavar: str, *names: str, **settings: Any) -> Any:
    """Return an option in place of a key of a case file, whose value is a text with a unit."""
    return Annotated[str | None, option(words, metavar, *names, rich_help_panel=_WITHOUT_FILE, **settings)]


def _flag(name: str, words: str) -> Any:
    return Annotated[bool, option(words, None, name, rich_help_panel=_WITHOUT_FILE)]


BALL: dict[str, Any] = {
    "material": text(
        "File of the material, as `restitution material` reads it, or a name of the library.", "FILE|NAME",
        autocompletion=completed("material.library.names"),
    ),
    "temperature": text("Temperature of the material.", "TEMPERATURE"),
    "shift": text("Shift factors over temperature, for moduli at one.", "FILE"),
    "wlf": text('Law of Williams, Landel and Ferry, e.g. "20 degC, 8.86, 101.6".', "T0,C1,C2"),
    "frequency": text("Frequency of a temperature ramp that does not state it.", "FREQUENCY"),
    "tension": _flag("--tension", "The moduli are those in tension."),
    "shear": _flag("--shear", "The moduli are those in shear."),
    "poisson_ratio": text("Poisson ratio, in [-1, 0.5]; 0.5 is incompressible.", "NUMBER"),
    "bulk_modulus": text("Bulk modulus, in place of the Poisson ratio.", "MODULUS"),
    "instantaneous_modulus": text("For Prony terms without it.", "MODULUS"),
    "equilibrium_modulus": text("For Prony terms without it.", "MODULUS"),
    "radius": text("Radius of the ball.", "LENGTH"),
    "mass": text("Mass of the ball.", "MASS"),
    "density": text("Its density, in place of the mass.", "DENSITY"),
    "velocity": text("Velocity at the first touch.", "VELOCITY"),
    "drop_height": text("Height of the fall, in place of the velocity.", "LENGTH"),
    "thickness": text("Thickness, for a layer on a rigid base.", "LENGTH"),
    "base": text("Hold of the layer: bonded, the default, or frictionless.", "BASE"),
}  # fmt: skip
"""Options in place of a case file."""
Json = Annotated[bool, typer.Option("--json", help="Print JSON, in SI, in place of text.")]
JsonWithoutUnits = Annotated[bool, typer.Option("--json", help="Print JSON in place of text.")]
Plot = Annotated[Path | None, target("Draw the result", "--plot", *PICTURES)]
Points = Annotated[
    Path | None,
    option(
        "Measured e over velocity, or drop and rebound heights, to draw on the curve of e over velocity.", "FILE.csv"
    ),
]
Picture = Annotated[Path | None, target("Picture", "--out", *PICTURES)]
History = Annotated[
    Path | None, target("Write depth, velocity, force and contact radius over time", "--history", *TABLES)
]
_OUTPUTS = completed("quantities.SWEEP_OUTPUTS")
Outputs = Annotated[
    list[str] | None, option("Output to show; may be repeated.", "NAME", "--output", autocompletion=_OUTPUTS)
]
Workers = Annotated[int | None, typer.Option(min=1, help="Threads or processes; all cores if not given.")]
