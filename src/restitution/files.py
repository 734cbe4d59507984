"""Files that are whole or absent: written beside their place, then moved there in one step."""

from __future__ import annotations

import os
from collections.abc import Generator
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    import xarray as xr


@contextmanager
def whole_file(path: Path | str) -> Generator[Path]:
    """Yield the path of a partial file, which becomes `path` when the block ends and vanishes when it fails.

    An interrupt (Ctrl-C) counts as a failure: `path` is then what it was before, or absent.

    Parameters
    ----------
    path : path-like
        The file to be written; its folder must exist.

    Yields
    ------
    pathlib.Path
        Where to write, in the same folder, so that the last step is a rename within one file system.

    Raises
    ------
    OSError
        If the file cannot be written; the error then names `path`. All else that the block raises passes through.

    Examples
    --------
    >>> import tempfile
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     with whole_file(f"{folder}/note.txt") as partial:
    ...         _ = partial.write_text("all of it")
    ...     [(entry.name, entry.read_text()) for entry in Path(folder).iterdir()]
    [('note.txt', 'all of it')]
    """
    path = Path(path)
    # The process number keeps two runs into one folder from writing the same partial file.
    partial = path.with_name(f".{path.name}.{os.getpid()}.part")
    try:
        yield partial
        os.replace(partial, path)
    except BaseException as error:
        with suppress(OSError):
            partial.unlink(missing_ok=True)
        if isinstance(error, OSError) and error.strerror and error.filename in (None, str(partial)):
            raise OSError(error.errno, error.strerror, str(path)) from error
        raise


def write_netcdf(dataset: xr.Dataset, path: Path | str) -> None:
    """Write a dataset as NetCDF, whole or not at all.

    Parameters
    ----------
    dataset : xarray.Dataset
        What to write.
    path : path-like
        The file; its folder must exist.

    Raises
    ------
    OSError
        If it cannot be written.
    """
    # The HDF5 library ends the process where the disk is full.
    content = dataset.to_netcdf(None, engine="h5netcdf")
    with whole_file(path) as partial:
        partial.write_bytes(content)
