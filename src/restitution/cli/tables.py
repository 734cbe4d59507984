"""Results as tables for people, as JSON for programs, and as files for both."""

from __future__ import annotations

import json
import math
import sys
from collections.abc import Sequence
from enum import Enum
from pathlib import Path
from typing import TYPE_CHECKING, Any, cast

from restitution.cli.exit_codes import BadInput, tell, warn
from restitution.errors import InputError
from restitution.impact.status import Status

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.figure import Figure

    from restitution.impact.result import ImpactResult
    from restitution.quantities import Dimension

_ROWS = (
    ("restitution coefficient", "restitution_coefficient", "e", ""),
    ("contact time", "contact_time", "T", "s"),
    ("largest indentation depth", "max_indentation_depth", "d_max", "m"),
    ("largest force", "max_force", "F_max", "N"),
    ("largest contact radius", "max_contact_radius", "a_max", "m"),
    ("largest contact pressure", "max_pressure", "p_max", "Pa"),
    ("residual indentation depth", "residual_indentation_depth", "d_end", "m"),
    ("rebound velocity", "rebound_velocity", "v_end", "m/s"),
    ("back at the undeformed surface", "zero_overlap_time", "t_0", "s"),
)
_ENERGY_ROWS = (
    ("kinetic energy before", "kinetic_in", "", "J"),
    ("kinetic energy after", "kinetic_out", "", "J"),
    ("energy dissipated", "dissipated", "", "J"),
    ("energy still stored", "stored", "", "J"),
)

PICTURES = (".png", ".pdf", ".svg")
TABLES = (".nc", ".csv")


def version() -> str:
    """Version of the package."""
    from importlib.metadata import version

    return version("restitution")


def write_json(content: Any, result: Any = None) -> None:
    """Print JSON in SI on standard output, with the validity report of a result and the version.

    An infinite number, or one that is not a number, becomes null.
    """
    if isinstance(content, dict):
        report = getattr(result, "validity", None)
        content = {
            **content,
            **({} if report is None else {"validity": report.to_dict()}),
            "version": version(),
        }
    # Not through rich, which would break lines at the width of the terminal.
    sys.stdout.write(json.dumps(_plain(content), indent=2, ensure_ascii=False, allow_nan=False) + "\n")


def _plain(value: Any) -> Any:
    if isinstance(value, dict):
        return {key: _plain(item) for key, item in value.items()}
    if isinstance(value, list | tuple):
        return [_plain(item) for item in value]
    if isinstance(value, Enum):
        return value.name
    return None if isinstance(value, float) and not math.isfinite(value) else value


def print_remarks(warnings: Sequence[str], notes: Sequence[str] = ()) -> None:
    """Write warnings and notes on standard error, a line each."""
    for warning in warnings:
        warn(warning)
    for note in notes:
        tell("note", note, "cyan")


def show(
    result: ImpactResult,
    title: str,
    *,
    in_json: bool,
    dimensionless: bool = False,
    bodies: str = "",
    notes: Sequence[str] = (),
) -> None:
    """Print the result of an impact: as JSON, or as a table with its warnings and notes on standard error."""
    if in_json:
        write_json(result.to_dict() | {"energy_residual": result.energy.residual}, result)
        return
    _print_impact(result, title, dimensionless)
    if bodies:
        print(bodies)
    # Mass and radius are 1 in dimensionless groups, which do not determine strain and density.
    exceeded = [check for check in result.validity if check.exceeded]
    valid = [one.warning for one in exceeded if not dimensionless or one.kind == "poisson_ratio"]
    status = cast("Status", result.status)
    ending = [] if status == Status.SEPARATED else [status.message]
    print_remarks([*valid, *result.notes, *ending], notes)


def _print_impact(result: ImpactResult, title: str, dimensionless: bool) -> None:
    # A number below the tolerance times the largest of its kind is rounding.
    tolerance = 1e-9 if result.rtol is None else float(result.rtol)
    noise = {
        "m": tolerance * float(result.max_indentation_depth),
        "J": tolerance * float(result.energy.kinetic_in),
    }
    values: list[tuple[str, str, float, str]] = []
    for source, rows in ((result, _ROWS), (result.energy, _ENERGY_ROWS)):
        for words, attribute, symbol, unit in rows:
            value = float(getattr(source, attribute))
            values.append((words, symbol, 0.0 if abs(value) < noise.get(unit, 0.0) else value, unit))
    print_values(title, values, dimensionless)
    stated = "" if result.rtol is None else f", rtol {result.rtol:g}"
    residual = float(result.energy.residual)
    balance = f", energy residual {residual:.1e}" if math.isfinite(residual) else ""
    print(f"method {result.method}{stated}{balance}")


def print_values(title: str, values: Sequence[tuple[str, str, float, str]], dimensionless: bool = False) -> None:
    """Print rows of words, symbol and value, with the unit if there is one."""
    rows = [
        (words, symbol, *_for_people(value, "" if dimensionless else unit)) for words, symbol, value, unit in values
    ]
    columns = ("quantity", "symbol", "value", "unit")[: 3 if dimensionless else 4]
    print_rows(title, columns, [row[: len(columns)] for row in rows], right="value")


def print_rows(title: str, columns: tuple[str, ...], rows: Sequence[tuple[str, ...]], right: str = "") -> None:
    """Print rows of text under their columns; the column `right` is aligned to the right."""
    from rich import box
    from rich.console import Console
    from rich.table import Table
    from rich.text import Text

    table = Table(box=box.SIMPLE_HEAD)
    for column in columns:
        table.add_column(Text(column), overflow="fold", justify="right" if column == right else "left")
    for row in rows:
        table.add_row(*map(Text, row))
    console = Console(highlight=False)
    # A line that is too long for the terminal is better broken by it than cut off by the table.
    console.width = max(console.width, 100)
    print(title)
    console.print(table)


def _for_people(value: float, unit: str) -> tuple[str, str]:
    if math.isnan(value) or (unit and math.isinf(value)):
        return ("-" if math.isnan(value) else "inf"), ""
    if unit == "":
        return f"{value:.8g}", ""
    from restitution.plot.labels import scaled_unit

    scale = scaled_unit(value, unit)
    return f"{value * scale.factor:.6g}", scale.unit


def read_quantity(option: str, text: str, dimension: Dimension) -> float:
    """Return in SI what a user wrote: a number, or a text with a unit."""
    try:
        return float(text)
    except ValueError:
        from restitution.case.quantity import to_si

        try:
            return to_si(text, dimension)
        except InputError as error:
            raise BadInput(f'{option} "{text}": {error.wanted}') from None


def check_target(option: str, path: Path | None, suffixes: tuple[str, ...]) -> None:
    """Refuse, before any work is done, a file that could not be written in the end."""
    if path is None:
        return
    if path.suffix.lower() not in suffixes:
        raise BadInput(f"{option} {path}: must end in {' or '.join(suffixes)}")
    if not path.parent.is_dir():
        raise BadInput(f"{option} {path}: no such folder: {path.parent}")
    if path.is_dir():
        raise BadInput(f"{option} {path}: is a folder")


def require_end(result: ImpactResult, option: str, path: Path) -> None:
    """Refuse to show a contact that has no last instant, and so no history."""
    status = cast("Status", result.status)
    if status != Status.SEPARATED:
        raise BadInput(f"{option} {path}: there is no whole contact to show: {status.message}")


def write_history(result: ImpactResult, path: Path, title: str = "") -> None:
    """Write the history of an impact, whole or not at all: NetCDF, or CSV with the units in the header."""
    from restitution.impact.problem import Impact

    require_end(result, "--history", path)
    impact = result.impact
    assert isinstance(impact, Impact)
    attributes = {
        "title": title,
        "version": version(),
        "mass": float(impact.mass),
        "mass_units": "kg",
        "velocity": float(impact.velocity),
        "velocity_units": "m/s",
        "material": impact.material.name or repr(impact.material),
        "profile": repr(impact.profile),
    }
    save_table(result.history.assign_attrs(attributes), path)


def save_table(dataset: xr.Dataset, path: Path | None) -> None:
    """Write a dataset as a table, if there is a path."""
    if path is not None:
        from restitution.files import write_table

        write_table(dataset, path)


def save_picture(figure: Figure, path: Path) -> None:
    """Write a picture, whole or not at all."""
    from restitution.plot.style import save_figure

    save_figure(figure, path)
