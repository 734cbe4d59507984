"""Results as tables for people, as JSON for programs, and as files for both."""

from __future__ import annotations

import json
import math
import re
import sys
from collections.abc import Sequence
from enum import Enum
from pathlib import Path
from typing import TYPE_CHECKING, Any, cast

from restitution.cli.terminal import BadInput, report
from restitution.errors import InputError
from restitution.files import write_table
from restitution.impact.status import Status

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.figure import Figure

    from restitution.impact.result import ImpactResult
    from restitution.quantities import Dimension


def version() -> str:
    """Version of the package."""
    from importlib.metadata import version

    return version("restitution")


def write_json(content: Any) -> None:
    """Print JSON in SI on standard output, with the version; a number that is infinite or NaN becomes null."""
    if isinstance(content, dict):
        content = {**content, "version": version()}
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


def show(result: ImpactResult, title: str, *, in_json: bool, dimensionless: bool = False, bodies: str = "") -> None:
    """Print the result of an impact: as JSON, or as a table with its warnings on standard error."""
    validity = result.validity
    if dimensionless:
        # Mass and radius are 1 in dimensionless groups, which do not determine strain and density.
        validity = type(validity)((validity["poisson_ratio"],))
    if in_json:
        content = result.to_dict() | {"energy_residual": result.energy.residual}
        content |= {"warnings": [*validity.warnings, *result.notes], "validity": validity.to_dict()}
        write_json(content)
        return
    _print_impact(result, title, dimensionless)
    if bodies:
        print(bodies)
    report("warning", *validity.warnings)
    status = cast("Status", result.status)
    report("warning", *result.notes, *([] if status == Status.SEPARATED else [status.message]))


def _print_impact(result: ImpactResult, title: str, dimensionless: bool) -> None:
    from restitution.quantities import OUTPUTS

    # A number below the tolerance times the largest of its kind is rounding.
    tolerance = 1e-9 if result.rtol is None else float(result.rtol)
    noise = {"m": tolerance * float(result.max_indentation_depth), "J": tolerance * float(result.energy.kinetic_in)}
    found = [(OUTPUTS[name], float(value)) for name, value in result.outputs.items() if name != "energy_residual"]
    values = [
        (one.words, plain_symbol(one.symbol), 0.0 if abs(value) < noise.get(one.unit, 0.0) else value, one.unit)
        for one, value in found
    ]
    long, short = result.max_semi_axes
    if short < long:
        words = "semi-axis of the largest contact"
        values += [(f"long {words}", "a", float(long), "m"), (f"short {words}", "b", float(short), "m")]
    values.append(("back at the undeformed surface", "t_0", float(result.zero_overlap_time), "s"))
    print_values(title, values, dimensionless)
    stated = "" if result.rtol is None else f", rtol {result.rtol:g}"
    residual = float(result.energy.residual)
    balance = f", energy residual {residual:.1e}" if math.isfinite(residual) else ""
    print(f"method {result.method}{stated}{balance}")


def plain_symbol(symbol: str) -> str:
    r"""Return a symbol of matplotlib's notation as plain text: d_max for $d_\mathrm{max}$."""
    return re.sub(r"\\mathrm|[${}\\]", "", symbol)


def print_values(title: str, values: Sequence[tuple[str, str, float, str]], dimensionless: bool = False) -> None:
    """Print rows of words, symbol and value, with the unit if there is one."""
    n = 3 if dimensionless else 4
    rows = [(words, symbol, *_for_people(value, "" if n == 3 else unit))[:n] for words, symbol, value, unit in values]
    print_rows(title, ("quantity", "symbol", "value", "unit")[:n], rows, right="value")


def print_rows(title: str, columns: tuple[str, ...], rows: Sequence[tuple[str, ...]], right: str = "") -> None:
    """Print rows of text under their columns; the column `right` is aligned to the right."""
    from rich import box
    from rich.console import Console
    from rich.table import Table
    from rich.text import Text

    table = Table(box=box.SIMPLE_HEAD)
    for n, head in enumerate(columns):
        least = min(16, max(map(len, " ".join((head, *(row[n] for row in rows))).split()), default=1))
        table.add_column(Text(head), overflow="fold", justify="right" if head == right else "left", min_width=least)
    for row in rows:
        table.add_row(*map(Text, row))
    console = Console(highlight=False)
    # A line that is too long for the terminal is better broken by it than cut off by the table.
    console.width = max(console.width, 100)
    print(title)
    console.print(table)


def print_dataset(title: str, dataset: xr.Dataset) -> None:
    """Print columns over one dimension, in prefixed units; columns without numbers are left out."""
    from restitution.plot.labels import scaled

    (dimension,) = dataset.sizes
    columns: dict[str, list[str]] = {}
    for name in dict.fromkeys((dimension, *dataset.coords, *dataset.data_vars)):
        one = scaled(dataset[name])
        texts = ["-" if math.isnan(x) else f"{x:.4g}" for x in one.values.tolist()]
        if dataset[name].dtype.kind == "i" and name == dimension:
            columns[str(name)] = [str(n + 1) for n in range(len(texts))]
        elif set(texts) != {"-"}:
            # Blanks let a narrow column break its heading.
            columns[f"{str(name).replace('_', ' ')} [{one.unit or '-'}]"] = texts
    print_rows(title, tuple(columns), list(zip(*columns.values(), strict=True)))


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
    write_table(result.history.assign_attrs(attributes), path)


def save_picture(figure: Figure, path: Path) -> None:
    """Write a picture, whole or not at all."""
    from restitution.plot.style import save_figure

    save_figure(figure, path)
