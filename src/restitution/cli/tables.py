"""Results as tables for people, as JSON for programs, and as files for both."""

from __future__ import annotations

import json
import math
import sys
from collections.abc import Sequence
from pathlib import Path
from shutil import get_terminal_size
from typing import TYPE_CHECKING, Any, cast

from restitution.cli.terminal import BadInput, report
from restitution.files import write_table
from restitution.impact.status import Status
from restitution.result import Result, Summary, Table, nullable, plain
from restitution.units import MASS, VELOCITY

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.figure import Figure

    from restitution.impact.result import ImpactResult


def version() -> str:
    """Return the version of the package."""
    from importlib.metadata import version

    return version("restitution")


def write_json(content: Any) -> None:
    """Print JSON in SI on standard output, with the version; a number that is infinite or NaN becomes null."""
    content = plain(content, nullable)
    if isinstance(content, dict):
        content["version"] = version()
    # Not through rich, which would break lines at the width of the terminal.
    sys.stdout.write(json.dumps(content, indent=2, ensure_ascii=False, allow_nan=False) + "\n")


def answer(
    result: Result,
    title: str = "",
    *lines: str,
    json: bool,
    plot: Path | None = None,
    notes: Sequence[str] = (),
    **more: Any,
) -> None:
    """Print a result, as JSON with further entries or as a summary with further lines, and draw its picture."""
    if json:
        write_json(result.to_dict() | more)
    else:
        show(result.summary(title), *lines)
        report("note", *notes)
    if plot is not None:
        save_picture(result.plot(), plot)


def show(summary: Summary, *lines: str) -> None:
    """Print a summary and further lines, with the warnings on standard error."""
    print("\n".join([summary.text(get_terminal_size().columns), *lines]))
    report("warning", *summary.warnings)


def print_rows(title: str, columns: tuple[str, ...], rows: Sequence[tuple[str, ...]]) -> None:
    """Print rows of text under their columns."""
    show(Summary(title, Table(columns, rows)))


def print_dataset(title: str, dataset: xr.Dataset, *lines: str) -> None:
    """Print columns over one dimension, in prefixed units, and further lines; leave out columns without numbers."""
    from restitution.quantities import scaled

    (dimension,) = dataset.sizes
    columns: dict[str, list[str]] = {}
    for name in dict.fromkeys((dimension, *dataset.coords, *dataset.data_vars)):
        column = scaled(dataset[name])
        texts = ["-" if math.isnan(x) else f"{x:.4g}" for x in column.values.tolist()]
        if dataset[name].dtype.kind == "i" and name == dimension:
            columns[str(name)] = [str(n + 1) for n in range(len(texts))]
        elif set(texts) != {"-"}:
            # Blanks let a narrow column break its heading.
            columns[f"{str(name).replace('_', ' ')} [{column.unit or '-'}]"] = texts
    show(Summary(title, Table(tuple(columns), list(zip(*columns.values(), strict=True))), lines))


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
        "mass_units": MASS.unit,
        "velocity": float(impact.velocity),
        "velocity_units": VELOCITY.unit,
        "material": impact.material.name or repr(impact.material),
        "profile": repr(impact.profile),
    }
    write_table(result.history.assign_attrs(attributes), path)


def save_picture(figure: Figure, path: Path) -> None:
    """Write a picture, whole or not at all."""
    # Matplotlib takes 0.3 s to import.
    from restitution.plot.style import save_figure

    save_figure(figure, path)
