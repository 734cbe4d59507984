"""The command `restitution`: argument parsing and printing only."""

from __future__ import annotations

import io
import os
import signal
import sys
import warnings
from enum import StrEnum
from pathlib import Path
from typing import Annotated

import typer

from restitution.cli import bounce, cite, indent, material, surrogate, sweep, tables
from restitution.cli.exit_codes import INTERRUPTED, BadInput, Commands, tell, user_input, warn
from restitution.cli.progress import compilation, progress_bar
from restitution.impact.status import Status

app = typer.Typer(
    cls=Commands,
    name="restitution",
    help="Impact of bodies on viscoelastic ones: coefficient of restitution, contact time, force and energy.",
    epilog="Exit codes: 0 done, 2 bad input, 3 the solver failed, 70 a mistake in the program. "
    "Ctrl-C ends the run by its signal (shells show 130).",
    no_args_is_help=True,
    pretty_exceptions_enable=False,
)


class Method(StrEnum):
    """How an impact is solved."""

    exact = "exact"
    elements = "elements"
    reference = "reference"


def _print_version(wanted: bool) -> None:
    if wanted:
        print(f"restitution {tables.version()}")
        raise typer.Exit


@app.callback()
def _options(
    version: Annotated[
        bool,
        typer.Option("--version", callback=_print_version, is_eager=True, help="Print the version and exit."),
    ] = False,
    debug: Annotated[
        bool, typer.Option("--debug", help="Show the traceback of a mistake in the program.")
    ] = False,
) -> None:
    if debug:
        os.environ["RESTITUTION_TRACEBACK"] = "1"


@app.command("standard-solid")
def standard_solid(
    nu: Annotated[
        float, typer.Option("--nu", help="Static Poisson ratio, in [-1, 0.5]; 0.5 is incompressible.")
    ],
    p2: Annotated[float, typer.Option("--p2", help="Ratio of the moduli, Ginf/G1, > 0.")],
    p3: Annotated[
        float, typer.Option("--p3", help="Dimensionless viscosity, eta (v0 R/(m^2 Ginf^3))^(1/5), > 0.")
    ],
    method: Annotated[Method, typer.Option(help="How to solve it.")] = Method.exact,
    rtol: Annotated[float, typer.Option(help="Relative tolerance of the restitution coefficient.")] = 1e-9,
    json: tables.Json = False,
) -> None:
    """Solve the paper's problem: a rigid sphere hits a half-space of the compressible standard solid.

    All numbers are dimensionless: mass, radius, velocity and equilibrium shear modulus are 1.
    """
    from restitution.checks import positive, within
    from restitution.contact.profile import Parabola
    from restitution.impact.problem import Impact
    from restitution.impact.solve import solve as solve_impact
    from restitution.material.classical import standard_solid as material

    with user_input():
        within("nu", nu, -1.0, 0.5)
        positive("p2", p2)
        positive("p3", p3)
        solid = material(1.0, 1.0 / p2, p3, poisson_ratio=nu)
        impact = Impact(material=solid, profile=Parabola(radius=1.0), mass=1.0, velocity=1.0)
        with compilation():
            result = solve_impact(impact, method=method.value, rtol=rtol)
    title = f"Standard solid: nu = {nu:g}, p2 = {p2:g}, p3 = {p3:g}"
    tables.show(result, title, in_json=json, dimensionless=True)


@app.command("solve")
def solve(
    case: Annotated[Path, typer.Argument(metavar="CASE.toml", help="Case file.", show_default=False)],
    json: tables.Json = False,
    plot: Annotated[
        Path | None,
        typer.Option(metavar="FILE", help="Draw the impact: .png, .pdf or .svg.", show_default=False),
    ] = None,
    pressure_at: Annotated[
        list[str] | None,
        typer.Option(
            metavar="TIME",
            help='When to draw the pressure, e.g. "0.2 ms"; may be repeated. Four instants if not given.',
            show_default=False,
        ),
    ] = None,
    history: Annotated[
        Path | None,
        typer.Option(
            metavar="FILE", help="Write depth, velocity, force, contact radius over time: .nc or .csv."
        ),
    ] = None,
) -> None:
    """Solve the impact that a case file describes."""
    tables.check_target("--plot", plot, tables.PICTURES)
    tables.check_target("--history", history, tables.TABLES)
    with user_input():
        from restitution.case.impact import read_case
        from restitution.quantities import TIME

        times = [tables.read_quantity("--pressure-at", time, TIME) for time in pressure_at or []]
        if times and plot is None:
            raise BadInput("--pressure-at: give --plot FILE as well")
        problem = read_case(case)
        with compilation():
            result = problem.solve()
        for text, time in zip(pressure_at or [], times, strict=True):
            if result.status == Status.SEPARATED and not 0.0 <= time <= result.contact_time:
                raise BadInput(
                    f'--pressure-at "{text}": must be within the contact, which lasts {result.contact_time:.6g} s'
                )
    tables.show(result, problem.title or str(case), in_json=json, bodies=problem.arrangement)
    if not json:
        for line in problem.notes(result):
            tell("note", line, "cyan")
    if history is not None:
        tables.write_history(result, history, problem.title or str(case))
    if plot is not None:
        tables.write_plot(result, plot, times or None, problem.title or "")


app.command("bounce")(bounce.bounce)
app.command("indent")(indent.indent)
app.command("cite")(cite.cite)
app.command("material")(material.material)
app.command("surrogate")(surrogate.surrogate)
app.command("sweep")(sweep.sweep)
app.command("plot")(sweep.plot)
app.command("map")(sweep.map_)


@app.command("reproduce")
def reproduce(
    out: Annotated[Path, typer.Option(metavar="DIR", help="Folder for figures, data and claims.")] = Path(
        "reproduction"
    ),
    quick: Annotated[bool, typer.Option("--quick", help="Coarse grids, for a first look.")] = False,
    seed: Annotated[
        int | None, typer.Option(min=0, help="Seed of the random inputs.", show_default=False)
    ] = None,
    workers: Annotated[int | None, typer.Option(min=1, help="Threads; all cores if not given.")] = None,
) -> None:
    """Compute and draw the paper's figures 3 to 6 and four more, and judge its claims."""
    from restitution.paper import reproduction

    with user_input(), progress_bar("reproducing") as progress:
        made = reproduction.reproduce(
            out,
            quick=quick,
            seed=reproduction.DEFAULT_SEED if seed is None else seed,
            workers=workers,
            progress=progress,
        )
    for claim in made.claims:
        print(f"{'holds' if claim.holds else 'does not hold'}: {claim.statement}")
    print(f"{made.solves} impacts, {len(made.files)} files in {made.folder}, {made.seconds:.1f} s")


def main() -> None:
    """Run the command line; ends the process with one of its exit codes."""
    if isinstance(sys.stdout, io.TextIOWrapper):
        # A terminal or file that has no µ is no reason to fail; standard error does the same by default.
        sys.stdout.reconfigure(errors="backslashreplace")
    warnings.showwarning = lambda message, *_, **__: warn(str(message))
    try:
        app()
    except SystemExit as end:
        if end.code == INTERRUPTED and sys.platform != "win32":
            # What started the command learns that the user stopped it, not that it failed with a code of its own.
            signal.signal(signal.SIGINT, signal.SIG_DFL)
            sys.stderr.flush()
            os.kill(os.getpid(), signal.SIGINT)
        raise
