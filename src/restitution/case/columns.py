"""Columns of a CSV file: a header that names the quantities and their units, numbers below."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from restitution.case.quantity import Kind, to_si
from restitution.material.sheet import FileError, Sheet, read_sheet

# Symbols that stand for the names.
_SYMBOLS = {"t": "time", "d": "depth", "F": "force"}


def read_columns(folder: str | Path, name: str, kinds: Mapping[str, Kind]) -> dict[str, NDArray[np.float64]]:
    r"""Read the columns of a CSV file.

    The header names each quantity once, in any order, by its name or its symbol. Units stand behind an
    underscore or in brackets, as in ``r_um,f [nm]``, or in a second line, ``um,nm``; without them the numbers
    are in SI. Separators, decimal commas and comments are those of tables of materials.

    Parameters
    ----------
    folder : str or Path
        Folder that a relative name starts from.
    name : str
        Name of the file.
    kinds : mapping
        Name and kind of each column.

    Returns
    -------
    dict
        A column in SI for each name.

    Raises
    ------
    ValueError
        If the file cannot be read or is malformed; one line, with the number of the line to blame.

    Examples
    --------
    >>> import tempfile
    >>> from restitution.case.quantity import LENGTH
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     _ = Path(folder, "tip.csv").write_text("r,f\nmm,um\n0,0\n1,2\n")
    ...     read_columns(folder, "tip.csv", {"r": LENGTH, "f": LENGTH})
    {'r': array([0.   , 0.001]), 'f': array([0.e+00, 2.e-06])}
    """
    sheet = read_sheet("", _text(Path(folder, name)), lambda tail: True)
    names = [_name(label, kinds) for label in sheet.labels]
    for label, column in zip(sheet.labels, names, strict=True):
        if column is None:
            raise FileError("", sheet.header_line, f"unknown column {label!r}; {_forms(kinds)}")
    if sorted(filter(None, names)) != sorted(kinds):
        raise FileError("", sheet.header_line, f"must name {len(kinds)} columns; {_forms(kinds)}")
    return {column: _column(sheet, i, column, kinds[column]) for i, column in enumerate(filter(None, names))}


def names_column(folder: str | Path, name: str, column: str) -> bool:
    """Whether the header of a CSV file names a column; not of a file that cannot be read."""
    try:
        sheet = read_sheet("", _text(Path(folder, name)), lambda tail: True)
    except ValueError:
        return False
    return column in [_SYMBOLS.get(label, label) for label in sheet.labels]


def _text(path: Path) -> str:
    try:
        return path.read_text(encoding="utf-8-sig")
    except FileNotFoundError:
        raise ValueError(f"no such file: {path}") from None
    except OSError as error:
        raise ValueError(f"cannot be read: {error.strerror}") from None
    except ValueError:
        raise ValueError("cannot be read: not a text file in UTF-8") from None


def _name(label: str, kinds: Mapping[str, Kind]) -> str | None:
    name = _SYMBOLS.get(label, label)
    return name if name in kinds else None


def _forms(kinds: Mapping[str, Kind]) -> str:
    """Headers that are understood."""
    units = {name: kind.example.split()[-1] for name, kind in kinds.items()}
    behind = ",".join(f"{name}_{unit}" for name, unit in units.items())
    brackets = ",".join(f"{name} [{unit}]" for name, unit in units.items())
    return f'write e.g. "{behind}", "{brackets}", or "{",".join(units)}" and the units in a second line'


def _column(sheet: Sheet, index: int, name: str, kind: Kind) -> NDArray[np.float64]:
    unit = (sheet.units[index] or "").strip()
    try:
        factor = 1.0 if unit in ("", "-", kind.unit) else to_si(f"1 {unit}", kind)
    except ValueError as error:
        raise FileError("", sheet.unit_line, f"unit {unit!r} of {name}: {error}") from None
    for row in sheet.rows:
        if not np.isfinite(row.values[index] * factor):
            raise FileError("", row.line, f"{name} = {row.cells[index]}: must be finite")
    return np.array([row.values[index] * factor for row in sheet.rows])
