"""The commands for single cases: `solve`, `bounce`, `indent`, `oscillate`, `tap`, `cite` and so on."""

from __future__ import annotations

import sys
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Literal

import typer

import restitution as rs
from restitution.cli import tables
from restitution.cli import terminal as cli
from restitution.cli.terminal import argument, quantity, target
from restitution.files import TABLES, write_table, write_text
from restitution.units import TIME

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from restitution.propagation.result import UncertaintyResult


@cli.taking(**cli.BALL)
def solve(
    case: cli.CaseOrOptions = None,
    json: cli.Json = False,
    plot: cli.Plot = None,
    pressure_at: Annotated[
        list[float] | None,
        quantity("--pressure-at", TIME, 'Time of a pressure curve, e.g. "0.2 ms"; may be repeated. Default: four.'),
    ] = None,
    history: cli.History = None,
    points: cli.Points = None,
    extrapolate: cli.Extrapolate = False,
    save: Annotated[
        Path | None, target("Write the case file of --material and the other options", "--save", ".toml")
    ] = None,
    **options: Any,
) -> None:
    """Solve the impact that a case file describes, or that of a ball on the material of a file.

    The impact is normal, or has friction, an angle and a spin.

    Without a case file, --material and what it asks for describe the impact, and --save writes the file.
    Values such as "10 +- 0.5 MPa" give e and the other outputs their standard deviations.
    Example: restitution solve examples/rubber_ball.toml --plot picture.png
    """
    from restitution.impact.window import require_known

    for name, value in (("--pressure-at", pressure_at), ("--points", points)):
        if value and plot is None:
            raise cli.BadInput(f"{name}: give --plot FILE as well")
    if pressure_at and points:
        raise cli.BadInput("--points: the picture is that of e over velocity; leave --pressure-at out")
    measured = None if points is None else rs.read_points(points)
    with cli.single_solve():
        problem = _problem(case, options, save)
        require_known(problem.impact, extrapolate=extrapolate)
        result = problem.solve()
        uncertain, bands = _propagated(problem), problem.bands(result)
        result.to_dict()
    for time in pressure_at or []:
        if result.status == rs.Status.SEPARATED and not 0.0 <= time <= result.contact_time:
            end = f"{result.contact_time:.6g} s"
            raise cli.BadInput(f"--pressure-at {time:g} s: must be within the contact, which lasts {end}")
    title, notes = problem.title or str(case), problem.notes(result.impact, scattered=True)
    lines = [*map(str, bands), *(() if uncertain is None else uncertain.lines)]
    more: dict[str, Any] = {"energy_residual": result.energy.residual}
    if bands:
        more["restitution_bands"] = [band.to_dict() for band in bands]
    if uncertain is not None:
        more["uncertainty"] = uncertain
    tables.answer(result, title, problem.arrangement, *lines, json=json, notes=notes, **more)
    if uncertain is not None and not json:
        cli.report("warning", *uncertain.warnings)
    if history is not None:
        tables.write_history(result, history, title)
    if plot is not None and measured is not None:
        _draw_points(problem, measured, plot)
    elif plot is not None:
        tables.require_end(result, "--plot", plot)
        tables.save_picture(_picture(result, pressure_at or None, problem.title or ""), plot)


def _picture(result: rs.ImpactResult, pressure_at: list[float] | None, title: str) -> Figure:
    """Draw one impact; that of the normal motion for a picture of the pressure."""
    from restitution.plot import impact, oblique

    if isinstance(result, rs.ObliqueResult) and pressure_at is None:
        return oblique.overview(result, title=title)
    return impact.overview(result, pressure_at, title=title)


def _problem(case: Path | None, options: dict[str, Any], save: Path | None) -> rs.Case:
    """Return the case of a file, or of options, which a file is to keep."""
    if case is not None:
        excess = [f"--{name.replace('_', '-')}" for name in options] + ["--save"] * (save is not None)
        if excess:
            raise cli.BadInput(f"{', '.join(excess)}: {case} describes the impact; change it there, or leave it out")
        return rs.read_case(case)
    if not options:
        raise cli.BadInput("give a case file, or --material FILE and what it asks for (see: restitution solve --help)")
    from restitution.case.options import case_of_options, write_case

    deformations = [name for name in ("tension", "shear") if options.pop(name, False)]
    if len(deformations) > 1:
        raise cli.BadInput("--tension, --shear: give one of both")
    if deformations:
        options["deformation"] = deformations[0]
    problem = case_of_options(options)
    if save is not None:
        write_case(problem, save)
    return problem


def _draw_points(problem: rs.Case, measured: rs.ReboundPoints, plot: Path) -> None:
    """Draw e of a case over velocity with measured points, and say how far they are from it."""
    from restitution.plot.rebounds import distance, velocities

    impact = problem.over(velocities(measured, float(problem.impact.velocity)))
    impact = replace(impact, velocity=float(problem.impact.velocity))
    with cli.compilation():
        tables.save_picture(rs.plot_restitution(impact, measured), plot)
        size = distance(impact, measured)
    count = measured.velocity.size
    cli.report("note", f"{count} measured points; the root mean square of computed minus measured e is {size:.3g}")


def _propagated(problem: rs.Case) -> UncertaintyResult | None:
    """Return the outputs with standard deviations; None, without loading what it takes, where the file has none."""
    if not problem.states_deviations:
        return None
    from restitution.case.uncertainty import propagate_case

    return propagate_case(problem)


def standard_solid(
    nu: Annotated[float, typer.Option("--nu", help="Static Poisson ratio, in [-1, 0.5]; 0.5 is incompressible.")],
    p2: Annotated[float, typer.Option("--p2", help="Ratio of the moduli, Ginf/G1, > 0.")],
    p3: Annotated[float, typer.Option("--p3", help="Dimensionless viscosity, eta (v0 R/(m^2 Ginf^3))^(1/5), > 0.")],
    method: Annotated[Literal["exact", "elements"], typer.Option(help="How to solve it.")] = "exact",
    rtol: Annotated[
        float, typer.Option(help="Relative tolerance of the restitution coefficient, 1e-12 to 1e-2.")
    ] = 1e-9,
    json: cli.JsonWithoutUnits = False,
) -> None:
    """Solve the paper's problem: a rigid sphere hits a half-space of the compressible standard solid.

    All numbers are dimensionless: mass, radius, velocity and equilibrium shear modulus are 1.
    Example: restitution standard-solid --nu 0.45 --p2 0.01 --p3 1
    """
    from restitution.checks import positive, within
    from restitution.impact.result import of_impact

    within("nu", nu, -1.0, 0.5)
    positive("p2", p2)
    positive("p3", p3)
    with cli.single_solve():
        solid = rs.standard_solid(1.0, 1.0 / p2, p3, poisson_ratio=nu)
        impact = rs.Impact(material=solid, profile=rs.Parabola(radius=1.0), mass=1.0, velocity=1.0)
        result = rs.solve(impact, method=method, rtol=rtol)
        result.to_dict()
    # Mass and radius are 1 in dimensionless groups, which do not determine strain and density.
    validity = rs.Validity((result.validity["poisson_ratio"],))
    doubts = {"warnings": [*validity.warnings, *result.notes]}
    if json:
        energy = {"energy_residual": result.energy.residual, "validity": validity}
        tables.write_json(result.to_dict() | energy | doubts)
        return
    title = f"Standard solid: nu = {nu:g}, p2 = {p2:g}, p3 = {p3:g}"
    tables.show(replace(of_impact(result, title, dimensionless=True), **doubts))


def bounce(
    case: cli.CaseFile,
    json: cli.Json = False,
    plot: cli.Plot = None,
    out: Annotated[Path | None, target("Write a row for each bounce", "--out", *TABLES)] = None,
    extrapolate: cli.Extrapolate = False,
) -> None:
    """Let a body fall and bounce until it rests: time, height and restitution of each bounce.

    The case file gives the drop height or the velocity of the first impact. The weight acts during contact too,
    unless the file has weight = false. Each touch is on a fresh surface, unless it has same_spot = true.
    Example: restitution bounce examples/dropped_ball.toml
    """
    from restitution.impact.window import require_known

    with cli.single_solve():
        problem = rs.read_case(case)
        result = problem.bounces()
        require_known(result.impact, result.velocity, extrapolate=extrapolate)
        result.to_dict()
    title, notes = problem.title or str(case), problem.notes(result.impact)
    more = {"n_bounces": result.n_bounces, "ended": str(result.ended)}
    tables.answer(result, title, json=json, plot=plot, notes=notes, **more)
    if out is not None:
        write_table(result.to_dataset(), out)


def indent(
    case: cli.CaseFile,
    json: cli.Json = False,
    plot: cli.Plot = None,
    history: cli.History = None,
    extrapolate: cli.Extrapolate = False,
) -> None:
    """Move an indenter over any history: force under a prescribed depth, or depth under a prescribed force.

    The case file has the sections profile, material and indentation. The contact may end and begin again.
    Example: restitution indent examples/afm_indent.toml --plot curve.png
    """
    from restitution.impact.window import require_known_times

    with cli.single_solve():
        from restitution.case.indentation import read_indentation

        problem = read_indentation(case)
        result = problem.solve()
        require_known_times(result.validity["window"], extrapolate=extrapolate)
        result.to_dict()
    tables.answer(result, problem.title or str(case), json=json, plot=plot, notes=problem.notes())
    if history is not None:
        write_table(result.sample(n_points=problem.n_points), history)


def oscillate(
    case: cli.CaseFile,
    json: cli.Json = False,
    plot: cli.Plot = None,
    out: Annotated[Path | None, target("Write a row for each oscillation, or time of one", "--out", *TABLES)] = None,
) -> None:
    """Oscillate an indenter about a mean depth or force: harmonics, and how far the reading of moduli is off.

    The case file has the sections profile, material and oscillation, and axes for many oscillations.
    Example: restitution oscillate examples/oscillation.toml --plot loop.png
    """
    with cli.single_solve():
        from restitution.case.oscillation import read_oscillation

        problem = read_oscillation(case)
        result = problem.solve()
        result.to_dict()
    tables.answer(result, problem.title or str(case), json=json, plot=plot, notes=problem.notes())
    if out is not None:
        write_table(result.history if isinstance(result, rs.Oscillation) else result.to_dataset(), out)


def tap(
    case: cli.CaseFile,
    json: cli.Json = False,
    plot: cli.Plot = None,
    out: Annotated[Path | None, target("Write a row for each distance", "--out", *TABLES)] = None,
) -> None:
    """Tap a surface with a cantilever: amplitude, phase, forces and loss over the distance.

    The case file has the sections profile, material and tapping.
    Example: restitution tap examples/tapping.toml --plot curves.png
    """
    from restitution.case.oscillation import read_tapping

    problem = read_tapping(case)
    with cli.compilation(), cli.progress_bar("tapping", rate="distances/s") as progress:
        result = problem.solve(progress)
    tables.answer(result, problem.title or str(case), json=json, plot=plot, notes=problem.notes())
    if out is not None:
        write_table(result.to_dataset(), out)


def cite(
    cases: Annotated[list[Path] | None, argument("CASE.toml", "Files of impacts, indentations, sweeps.")] = None,
    json: cli.JsonWithoutUnits = False,
    out: Annotated[Path | None, target("Write a BibTeX file", "--out", ".bib")] = None,
) -> None:
    """Print what to cite, in BibTeX: the methods, materials and profile transforms that cases used.

    Without a case, the program and the paper that it reproduces. Example: restitution cite examples/epoxy.toml
    """
    from restitution.case.indentation import read_indentation
    from restitution.case.section import read_toml
    from restitution.case.sweep import read_sweep
    from restitution.citation.cite import citations, cite, entries

    subjects: list[Any] = []
    for case in cases or []:
        content = read_toml(case)
        is_sweep = "axes" in content or "samples" in content
        read = read_indentation if "indentation" in content else read_sweep if is_sweep else rs.read_case
        subjects.append(read(case))
    if json:
        used = citations(*subjects)
        tables.write_json([{"key": key, "used_for": use, "bibtex": entries()[key]} for key, use in used.items()])
    text = cite(*subjects) + "\n"
    if out is not None:
        write_text(out, text)
    elif not json:
        sys.stdout.write(text)
