"""Files that are complete or absent, also after a power cut: written beside their place, then renamed."""

from __future__ import annotations

import os
import secrets
import shutil
import sys
from collections.abc import Generator
from contextlib import contextmanager, suppress
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import TYPE_CHECKING, Any

from restitution.errors import InputError, InputTypeError

if TYPE_CHECKING:
    import xarray as xr

TABLES = (".csv", ".nc")
"""Suffixes of the files that `write_table` writes."""

PARTIAL = ".*.part"
"""Pattern of the names of partial files."""


def path_of(value: Any, name: str = "path") -> Path:
    """Return the path of a file or folder; refuse other types by the name of the argument."""
    if not isinstance(value, str | os.PathLike):
        raise InputTypeError(name, value, "must be the name of a file or folder")
    if "\0" in str(value):
        raise InputError(name, value, "must be the name of a file or folder, without a null character")
    return Path(value)


@contextmanager
def readable_again(path: Path) -> Generator[Path]:
    """Yield the path of a file that can be opened more than once: a copy of what comes through a pipe.

    Whoever opens the path has the message of a file that cannot be read.
    """
    if not path.exists() or path.is_file() or path.is_dir():
        yield path
        return
    with TemporaryDirectory() as folder:
        copy = Path(folder, path.name)
        with path.open("rb") as pipe, copy.open("wb") as file:
            shutil.copyfileobj(pipe, file)
        yield copy


def user_cache() -> Path | None:
    """Return the folder for caches in the home directory, or None without a home."""
    if sys.platform == "win32":
        stated, beside_home = os.environ.get("LOCALAPPDATA"), "AppData/Local"
    elif sys.platform == "darwin":
        stated, beside_home = None, "Library/Caches"
    else:
        stated, beside_home = os.environ.get("XDG_CACHE_HOME"), ".cache"
    # By the XDG standard a relative path must be ignored.
    if stated and Path(stated).is_absolute():
        return Path(stated) / "restitution"
    try:
        return Path.home() / beside_home / "restitution"
    except RuntimeError:
        return None


@contextmanager
def whole_file(path: Path | str) -> Generator[Path]:
    """Yield the path of a partial file, which becomes `path` at the end of the block and is removed on failure.

    The folder must exist. An interrupt (Ctrl-C) counts as a failure: `path` is then unchanged or absent. An
    `OSError` names `path`.
    """
    path = Path(path)
    if not path.name:
        raise InputError("path", str(path), "must be the name of a file")
    # In the same folder, so that the last step is a rename. The random name keeps others from linking it beforehand.
    partial = path.with_name(f".{secrets.token_hex(8)}.part")
    flags = os.O_CREAT | os.O_EXCL | os.O_RDWR | getattr(os, "O_NOFOLLOW", 0)
    try:
        os.close(os.open(partial, flags, 0o666))
        yield partial
        to_disk(partial)
        os.replace(partial, path)
        to_disk(path.parent)
    except BaseException as error:
        with suppress(OSError):
            partial.unlink(missing_ok=True)
        if isinstance(error, OSError) and error.strerror and error.filename in (None, str(partial)):
            raise OSError(error.errno, error.strerror, str(path)) from error
        raise


def write_text(path: Path | str, text: str) -> Path:
    """Write a text, whole or not at all; return the path."""
    path = path_of(path)
    with whole_file(path) as partial:
        partial.write_text(text, encoding="utf-8")
    return path


def to_disk(path: Path) -> None:
    """Wait until the content of a file, or the names in a folder, are on the disk."""
    folder = path.is_dir()
    # Windows opens no folders, and some network file systems cannot synchronise them.
    with suppress(*([OSError] if folder else [])):
        handle = os.open(path, os.O_RDONLY if folder else os.O_RDWR)
        try:
            os.fsync(handle)
        finally:
            os.close(handle)


def write_netcdf(dataset: xr.Dataset, path: Path | str) -> None:
    """Write a dataset as NetCDF, whole or not at all, into an existing folder."""
    # The HDF5 library ends the process if the disk is full.
    content = dataset.to_netcdf(None, engine="h5netcdf")
    with whole_file(path) as partial:
        partial.write_bytes(content)


def write_table(dataset: xr.Dataset, path: Path | str) -> Path:
    """Write a result as a table: CSV or NetCDF, whole or not at all.

    Parameters
    ----------
    dataset : xarray.Dataset
        A history, the result of a sweep, samples of a surrogate.
    path : path-like
        The file, in an existing folder. `.csv`: a row for each point, with the units in the header. `.nc`: NetCDF with
        all dimensions and attributes.

    Returns
    -------
    pathlib.Path
        `path`.

    Raises
    ------
    InputError
        If the name ends otherwise.
    OSError
        If the file cannot be written.

    Examples
    --------
    >>> import tempfile
    >>> import xarray as xr
    >>> force = xr.Dataset(
    ...     {"force": ("time", [0.0, 2.5], {"units": "N"})}, {"time": ("time", [0.0, 1e-3], {"units": "s"})}
    ... )
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     print(write_table(force, f"{folder}/force.csv").read_text())
    time [s],force [N]
    0.0,0.0
    0.001,2.5
    <BLANKLINE>
    """
    path = path_of(path)
    if not hasattr(dataset, "data_vars"):
        raise InputTypeError("dataset", dataset, "must be a Dataset")
    suffix = path.suffix.lower()
    if suffix not in TABLES:
        raise InputError("path", str(path), f"must end in {' or '.join(TABLES)}")
    if suffix == ".nc":
        write_netcdf(dataset, path)
        return path
    # A dataset without dimensions is one row.
    rows: Any = (dataset if dataset.sizes else dataset.expand_dims("point")).to_dataframe().reset_index()
    if "point" not in dataset.dims:
        rows = rows.drop(columns="point", errors="ignore")
    rows = rows[[*(name for name in dataset.coords), *dataset.data_vars]]
    units = {name: dataset[name].attrs.get("units", "") for name in rows.columns}
    rows.columns = [f"{name} [{unit}]" if unit else name for name, unit in units.items()]
    with whole_file(path) as partial:
        rows.to_csv(partial, index=False, lineterminator="\n")
    return path
