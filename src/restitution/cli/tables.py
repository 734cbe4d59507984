"""Results as tables for people, as JSON for programs, and as files for both."""

from __future__ import annotations

import json
import math
import sys
from collections.abc import Sequence
from enum import Enum
from pathlib import Path
from shutil import get_terminal_size
from typing import TYPE_CHECKING, Any, cast

from restitution.cli.terminal import BadInput, report
from restitution.display import Summary, Table
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


def show(summary: Summary, *lines: str) -> None:
    """Print a summary and further lines, with the warnings on standard error."""
    print("\n".join([summary.text(_width()), *lines]))
    report("warning", *summary.warnings)


def _width() -> int:
    """Columns of the terminal."""
    return get_terminal_size().columns


def print_rows(title: str, columns: tuple[str, ...], rows: Sequence[tuple[str, ...]], right: str = "") -> None:
    """Print rows of text under their columns; the column `right` is aligned to the right."""
    print(Summary(title, Table(columns, rows, right)).text(_width()))


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
