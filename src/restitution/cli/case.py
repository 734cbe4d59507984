"""The commands for single cases: `solve`, `standard-solid`, `bounce`, `indent` and `cite`."""

from __future__ import annotations

import sys
from dataclasses import replace
from enum import StrEnum
from pathlib import Path
from typing import Annotated, Any

import typer

from restitution.cli import tables
from restitution.cli.options import (
    CaseFile,
    Extrapolate,
    History,
    Json,
    JsonWithoutUnits,
    Plot,
    argument,
    option,
    target,
)
from restitution.cli.terminal import BadInput, compilation, report, user_input
from restitution.files import TABLES, whole_file, write_table
from restitution.impact.status import Status


class Method(StrEnum):
    """How an impact is solved."""

    exact = "exact"
    elements = "elements"
    reference = "reference"


def solve(
    case: CaseFile,
    json: Json = False,
    plot: Plot = None,
    pressure_at: Annotated[
        list[str] | None,
        option('Time of a pressure curve, e.g. "0.2 ms"; may be repeated. Four times if not given.', metavar="TIME"),
    ] = None,
    history: History = None,
    extrapolate: Extrapolate = False,
) -> None:
    """Solve the impact that a case file describes.

    Example: restitution solve examples/rubber_ball.toml --plot picture.png
    """
    with user_input():
        from restitution.case.impact import read_case
        from restitution.impact.window import require_known
        from restitution.quantities import TIME

        times = [tables.read_quantity("--pressure-at", time, TIME) for time in pressure_at or []]
        if times and plot is None:
            raise BadInput("--pressure-at: give --plot FILE as well")
        problem = read_case(case)
        with compilation():
            require_known(problem.impact, extrapolate=extrapolate)
            result = problem.solve()
        for text, time in zip(pressure_at or [], times, strict=True):
            if result.status == Status.SEPARATED and not 0.0 <= time <= result.contact_time:
                end = f"{result.contact_time:.6g} s"
                raise BadInput(f'--pressure-at "{text}": must be within the contact, which lasts {end}')
    title = problem.title or str(case)
    if json:
        tables.write_json(result.to_dict() | {"energy_residual": result.energy.residual})
    else:
        tables.show(result.summary(title), *filter(None, [problem.arrangement]))
        report("note", *problem.notes(result.impact))
    if history is not None:
        tables.write_history(result, history, title)
    if plot is not None:
        tables.require_end(result, "--plot", plot)
        from restitution.plot.impact import overview

        tables.save_picture(overview(result, times or None, title=problem.title or ""), plot)


def standard_solid(
    nu: Annotated[float, typer.Option("--nu", help="Static Poisson ratio, in [-1, 0.5]; 0.5 is incompressible.")],
    p2: Annotated[float, typer.Option("--p2", help="Ratio of the moduli, Ginf/G1, > 0.")],
    p3: Annotated[float, typer.Option("--p3", help="Dimensionless viscosity, eta (v0 R/(m^2 Ginf^3))^(1/5), > 0.")],
    method: Annotated[Method, typer.Option(help="How to solve it.")] = Method.exact,
    rtol: Annotated[float, typer.Option(help="Relative tolerance of the restitution coefficient.")] = 1e-9,
    json: JsonWithoutUnits = False,
) -> None:
    """Solve the paper's problem: a rigid sphere hits a half-space of the compressible standard solid.

    All numbers are dimensionless: mass, radius, velocity and equilibrium shear modulus are 1.
    Example: restitution standard-solid --nu 0.45 --p2 0.01 --p3 1
    """
    from restitution.checks import positive, within
    from restitution.contact.profile import Parabola
    from restitution.impact.problem import Impact
    from restitution.impact.solve import solve as solve_impact
    from restitution.impact.summary import of_impact
    from restitution.material.classical import standard_solid as material
    from restitution.validity import Validity

    with user_input():
        within("nu", nu, -1.0, 0.5)
        positive("p2", p2)
        positive("p3", p3)
        solid = material(1.0, 1.0 / p2, p3, poisson_ratio=nu)
        impact = Impact(material=solid, profile=Parabola(radius=1.0), mass=1.0, velocity=1.0)
        with compilation():
            result = solve_impact(impact, method=method.value, rtol=rtol)
    # Mass and radius are 1 in dimensionless groups, which do not determine strain and density.
    validity = Validity((result.validity["poisson_ratio"],))
    doubts = [*validity.warnings, *result.notes]
    if json:
        content = result.to_dict() | {"energy_residual": result.energy.residual}
        tables.write_json(content | {"warnings": doubts, "validity": validity.to_dict()})
        return
    title = f"Standard solid: nu = {nu:g}, p2 = {p2:g}, p3 = {p3:g}"
    tables.show(replace(of_impact(result, title, dimensionless=True), warnings=doubts))


def bounce(
    case: CaseFile,
    json: Json = False,
    plot: Plot = None,
    out: Annotated[Path | None, target("Write a row for each bounce", "--out", *TABLES)] = None,
    extrapolate: Extrapolate = False,
) -> None:
    """Let a body fall and bounce until it rests: time, height and restitution of each bounce.

    The case file gives the drop height or the velocity of the first impact. The weight acts during contact too,
    unless the file has weight = false. Example: restitution bounce examples/dropped_ball.toml
    """
    with user_input():
        from restitution.case.impact import read_case
        from restitution.impact.window import require_known

        problem = read_case(case)
        with compilation():
            found = problem.bounces()
            require_known(found.impact, found.velocity, extrapolate=extrapolate)
    table = found.to_dataset()
    if json:
        content = {"n_bounces": found.n_bounces, "ended": str(found.ended), "drop_height": found.drop_height}
        content |= {"gravity": found.gravity} | {str(name): one.values.tolist() for name, one in table.items()}
        tables.write_json(content | {"warnings": found.warnings, "validity": found.validity.to_dict()})
    else:
        tables.show(found.summary(problem.title or str(case)))
        report("note", *problem.notes(found.impact))
    if out is not None:
        write_table(table, out)
    if plot is not None:
        tables.save_picture(found.plot(), plot)


def indent(
    case: CaseFile, json: Json = False, plot: Plot = None, history: History = None, extrapolate: Extrapolate = False
) -> None:
    """Press an indenter in and pull it back: force under a prescribed depth, or depth under a prescribed force.

    The case file has the sections profile, material and indentation. A second loading in contact is refused.
    Example: restitution indent examples/afm_indent.toml --plot curve.png
    """
    with user_input():
        from restitution.case.indentation import read_indentation
        from restitution.impact.window import require_known_times

        problem = read_indentation(case)
        with compilation():
            result = problem.solve()
        require_known_times(result.validity["window"], extrapolate=extrapolate)
    if json:
        tables.write_json(result.to_dict())
    else:
        tables.show(result.summary(problem.title or str(case)))
        report("note", *problem.notes())
    if history is not None:
        write_table(result.sample(n_points=problem.n_points), history)
    if plot is not None:
        tables.save_picture(result.plot(), plot)


def cite(
    cases: Annotated[list[Path] | None, argument("CASE.toml", "Files of impacts, indentations, sweeps.")] = None,
    json: JsonWithoutUnits = False,
    out: Annotated[Path | None, target("Write a BibTeX file", "--out", ".bib")] = None,
) -> None:
    """Print what to cite, in BibTeX: the methods, materials and profile transforms that cases used.

    Without a case, the program and the paper that it reproduces. Example: restitution cite examples/epoxy.toml
    """
    with user_input():
        from restitution.case.impact import read_case
        from restitution.case.indentation import read_indentation
        from restitution.case.section import read_toml
        from restitution.case.sweep import read_sweep
        from restitution.citation.cite import citations, cite, entries

        subjects: list[Any] = []
        for case in cases or []:
            content = read_toml(case)
            is_sweep = "axes" in content or "samples" in content
            read = read_indentation if "indentation" in content else read_sweep if is_sweep else read_case
            subjects.append(read(case))
        if json:
            used = citations(*subjects)
            tables.write_json([{"key": key, "used_for": use, "bibtex": entries()[key]} for key, use in used.items()])
        text = cite(*subjects) + "\n"
    if out is not None:
        with whole_file(out) as partial:
            partial.write_text(text, encoding="utf-8")
    elif not json:
        sys.stdout.write(text)
