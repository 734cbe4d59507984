"""The command `restitution`: argument parsing and printing only."""

from __future__ import annotations

import io
import os
import signal
import sys
import warnings
from pathlib import Path
from typing import Annotated

import typer

from restitution.cli import case, explorer, identification, laws, material, rebound_resilience, sweep, tables
from restitution.cli import terminal as cli
from restitution.cli.terminal import option
from restitution.cli.warm_up import warm_up

_FOLDER = Path("reproduction")
app = typer.Typer(
    cls=cli.Commands,
    name="restitution",
    help="Impact of bodies on viscoelastic ones: coefficient of restitution, contact time, force and energy.",
    epilog="Exit codes: 0 done, 2 bad input, 3 the solver failed, 70 a mistake in the program. "
    "Ctrl-C ends the run by its signal (shells show 130).",
    no_args_is_help=True,
    pretty_exceptions_enable=False,
)


def _print_version(asked: bool) -> None:
    if asked:
        print(f"restitution {tables.version()}")
        raise typer.Exit


@app.callback()
def _options(
    version: Annotated[
        bool, typer.Option("--version", callback=_print_version, is_eager=True, help="Print the version and exit.")
    ] = False,
    debug: Annotated[bool, typer.Option("--debug", help="Show the traceback of a mistake in the program.")] = False,
) -> None:
    if debug:
        os.environ["RESTITUTION_TRACEBACK"] = "1"


_SOLVE, _DATA, _CODES, _MORE = "Solve", "From data to a material", "For other codes", "Explore, reproduce, cite"
_COMMANDS = {
    _SOLVE: (
        *(
            case.solve,
            case.bounce,
            case.indent,
            case.oscillate,
            case.tap,
            sweep.sweep,
            sweep.plot,
            sweep.map_,
        ),
        *(rebound_resilience.resilience, case.standard_solid),
    ),
    _DATA: (
        *(material.material, identification.bounces, identification.identify, identification.design),
        identification.moduli,
    ),
    _CODES: (laws.calibrate, laws.export, sweep.surrogate),
    _MORE: (explorer.explore, case.cite, warm_up),
}
for _panel, _commands in _COMMANDS.items():
    for _command in _commands:
        app.command(_command.__name__.rstrip("_").replace("_", "-"), cls=cli.Command, rich_help_panel=_panel)(_command)


@app.command("reproduce", cls=cli.Command, rich_help_panel=_MORE)
def reproduce(
    out: Annotated[Path, typer.Option("--out", metavar="DIR", help="Folder for figures, data and claims.")] = _FOLDER,
    quick: Annotated[bool, typer.Option("--quick", help="Coarse grids, for a first look.")] = False,
    seed: Annotated[int | None, option("Seed of the random inputs; always the same if not given.", min=0)] = None,
    workers: cli.Workers = None,
) -> None:
    """Compute and draw the paper's figures 3 to 6, and judge its claims.

    Example: restitution reproduce --quick
    """
    from restitution.paper import reproduction

    with cli.progress_bar("reproducing") as progress:
        chosen = reproduction.DEFAULT_SEED if seed is None else seed
        result = reproduction.reproduce(out, quick=quick, seed=chosen, workers=workers, progress=progress)
    for claim in result.claims:
        print(f"{'holds' if claim.holds else 'does not hold'}: {claim.statement}")
    print(f"{result.solves} impacts, {len(result.files)} files in {result.folder}, {result.seconds:.1f} s")


def main() -> None:
    """Run the command line; ends the process with one of its exit codes."""
    if isinstance(sys.stdout, io.TextIOWrapper):
        # A terminal or file that has no µ is no reason to fail; standard error does the same by default.
        sys.stdout.reconfigure(errors="backslashreplace")
    warnings.showwarning = lambda message, *_, **__: cli.report("warning", str(message))
    # The report of a result has this warning too.
    warnings.filterwarnings("ignore", "separability: ")
    try:
        app()
    except SystemExit as end:
        if end.code == cli.INTERRUPTED and sys.platform != "win32":
            # Shells and scripts recognise an interrupted command by the signal, not by an exit code.
            signal.signal(signal.SIGINT, signal.SIG_DFL)
            sys.stderr.flush()
            os.kill(os.getpid(), signal.SIGINT)
        raise
