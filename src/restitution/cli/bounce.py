"""The command `restitution bounce`: a body falls, and bounces until it rests."""

from __future__ import annotations

import math
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from restitution.cli import tables
from restitution.cli.exit_codes import tell, user_input, warn
from restitution.cli.progress import compilation

if TYPE_CHECKING:
    from restitution.impact.bounces import Bounces

# Bounces that a screen holds; of more, the first and the last are shown.
_SHOWN, _LAST = 24, 4


def bounce(
    case: Annotated[Path, typer.Argument(metavar="CASE.toml", help="Case file.", show_default=False)],
    json: tables.Json = False,
    plot: Annotated[
        Path | None,
        typer.Option(
            metavar="FILE", help="Draw height and restitution: .png, .pdf or .svg.", show_default=False
        ),
    ] = None,
    out: Annotated[
        Path | None,
        typer.Option(metavar="FILE", help="Write a row for each bounce: .nc or .csv.", show_default=False),
    ] = None,
) -> None:
    """Let the body of a case file fall and bounce until it rests: time, height and restitution of each bounce.

    The drop height is that of the file, or the one that gives its velocity. The weight acts during contact too
    unless the file says weight = false.
    """
    tables.check_target("--plot", plot, tables.PICTURES)
    tables.check_target("--out", out, tables.TABLES)
    with user_input():
        from restitution.case.impact import read_case

        problem = read_case(case)
        with compilation():
            found = problem.bounces()
    if json:
        tables.write_json(_content(found), found)
    else:
        _print(found, problem.title or str(case))
        for warning in found.warnings:
            warn(warning)
        for line in problem.notes(found):
            tell("note", line, "cyan")
    if out is not None:
        from restitution.files import write_table

        write_table(found.to_dataset(), out)
    if plot is not None:
        from restitution.plot.bounces import overview
        from restitution.plot.style import save_figure

        save_figure(overview(found), plot)


def _content(found: Bounces) -> dict[str, Any]:
    columns = {str(name): column.values.tolist() for name, column in found.to_dataset().data_vars.items()}
    return {
        "n_bounces": found.n_bounces,
        "ended": str(found.ended),
        "drop_height": found.drop_height,
        "gravity": found.gravity,
        **columns,
        "warnings": found.warnings,
    }


def _print(found: Bounces, title: str) -> None:
    from restitution.plot.labels import scaled_unit

    heights, times = scaled_unit(found.drop_height, "m"), scaled_unit(found.contact_time, "s")
    titles = (
        "bounce",
        "touch at [s]",
        "velocity [m/s]",
        "restitution e",
        f"contact time [{times.unit}]",
        f"rises to [{heights.unit}]",
    )
    count = found.n_bounces
    shown = list(range(count))
    if count > _SHOWN:
        shown = [*range(_SHOWN - _LAST), -1, *range(count - _LAST, count)]
    rows = [
        (
            str(n + 1),
            f"{found.touch_time[n]:.6g}",
            f"{found.velocity[n]:.4g}",
            f"{found.restitution_coefficient[n]:.6g}",
            f"{found.contact_time[n] * times.factor:.4g}"
            if math.isfinite(found.contact_time[n])
            else "stays",
            f"{found.height[n] * heights.factor:.4g}",
        )
        if n >= 0
        else ("…",) * len(titles)
        for n in shown
    ]
    tables.print_rows(f"{title}, from {found.drop_height * heights.factor:.6g} {heights.unit}", titles, rows)
    print(
        f"{count} bounce{'s' * (count != 1)} in {found.touch_time[-1]:.6g} s; {found.ended}: {found.ended.message}"
    )
