"""The command `restitution indent`: one prescribed indentation."""

from __future__ import annotations

import math
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from restitution.cli import tables
from restitution.cli.exit_codes import tell, user_input, warn
from restitution.cli.progress import compilation

if TYPE_CHECKING:
    from restitution.indentation.result import IndentationResult

_ROWS = (
    ("largest force", "max_force", "F_max", "N"),
    ("largest indentation depth", "max_indentation_depth", "d_max", "m"),
    ("largest contact radius", "max_contact_radius", "a_max", "m"),
    ("contact grows until", "turning_time", "t_m", "s"),
    ("contact ends at", "contact_end_time", "t_end", "s"),
    ("depth at the end of contact", "residual_indentation_depth", "d_end", "m"),
    ("work of the indenter", "work", "W", "J"),
)


def indent(
    case: Annotated[Path, typer.Argument(metavar="CASE.toml", help="Case file.", show_default=False)],
    json: tables.Json = False,
    plot: Annotated[
        Path | None,
        typer.Option(metavar="FILE", help="Draw the indentation: .png, .pdf or .svg.", show_default=False),
    ] = None,
    history: Annotated[
        Path | None,
        typer.Option(
            metavar="FILE", help="Write depth, velocity, force, contact radius over time: .nc or .csv."
        ),
    ] = None,
) -> None:
    """Press an indenter in and pull it back: force under a prescribed depth, or depth under a prescribed force.

    The case file has the sections profile, material and indentation. Loading again before the bodies have parted is refused.
    """
    tables.check_target("--plot", plot, tables.PICTURES)
    tables.check_target("--history", history, tables.TABLES)
    with user_input():
        from restitution.case.indentation import read_indentation

        problem = read_indentation(case)
        with compilation():
            result = problem.solve()
    if json:
        tables.write_json(result.to_dict(), result)
    else:
        _print(result, problem.title or str(case))
        for warning in result.warnings:
            warn(warning)
        for line in problem.notes():
            tell("note", line, "cyan")
    if history is not None:
        from restitution.files import write_table

        write_table(result.sample(n_points=problem.n_points), history)
    if plot is not None:
        from restitution.plot.indentation import overview
        from restitution.plot.style import save_figure

        save_figure(overview(result), plot)


def _print(result: IndentationResult, title: str) -> None:
    from restitution.plot.labels import scaled_unit

    rows: list[tuple[str, ...]] = []
    for words, attribute, symbol, unit in _ROWS:
        value = float(getattr(result, attribute))
        if math.isfinite(value):
            scale = scaled_unit(value, unit)
            rows.append((words, symbol, f"{value * scale.factor:.6g}", scale.unit))
        else:
            rows.append((words, symbol, "-", ""))
    tables.print_rows(title, ("quantity", "symbol", "value", "unit"), rows)
    print(f"prescribed {result.prescribed}, {result.status.message}, rtol {result.rtol:g}")
