"""The result of a sweep in a Zarr store (format 3), of which every chunk is whole or absent."""

from __future__ import annotations

import asyncio
import contextlib
import json
import os
import shutil
import warnings
from collections.abc import Generator, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
import zarr
from numpy.typing import NDArray
from zarr.storage import LocalStore

from restitution.files import whole_file
from restitution.sweeps.dataset import (
    Field,
    coordinate_blocks,
    coordinate_fields,
    in_words,
    output_fields,
)
from restitution.sweeps.grid import Index
from restitution.sweeps.plan import Plan
from restitution.sweeps.schema import OUTPUTS, STATUS

if TYPE_CHECKING:
    import xarray as xr

Array = NDArray[Any]

# Of coordinates; chunks of the outputs are those of the sweep.
_COORDINATE_CHUNK = 2**20


class _WholeFiles(LocalStore):
    """A folder whose files are written whole or not at all, whatever the version of Zarr."""

    async def set(self, key: str, value: Any) -> None:
        await asyncio.to_thread(_write, self.root / key, value.to_bytes())


def _write(path: Path, content: bytes) -> None:
    path.parent.mkdir(parents=True, exist_ok=True)
    with whole_file(path) as partial:
        partial.write_bytes(content)


class Store:
    """A Zarr store that takes the chunks of one sweep.

    The record of what is done is the variable `status`, of which a chunk is written after those of the rest.

    Parameters
    ----------
    path : Path
        Folder of the store, which `prepare` has made.
    plan : Plan
        The sweep.
    """

    def __init__(self, path: Path, plan: Plan) -> None:
        self._path = path
        self._plan = plan
        group = zarr.open_group(_WholeFiles(path), mode="r+", zarr_format=3)
        self._arrays: dict[str, Any] = {name: group[name] for name in plan.variables}

    def keep(self, index: Index, results: dict[str, Array]) -> None:
        """Write the results of a chunk."""
        region = self._plan.grid.region(index)
        # The status last: it tells that the others are there.
        for name in self._plan.variables:
            self._arrays[name][region] = results[name]

    def done(self) -> set[Index]:
        """Return the chunks that are written."""
        folder = self._path / STATUS / "c"
        if folder.is_file():
            return {()}
        depth = len(self._plan.grid.shape)
        return set(_indices(folder, depth)) if folder.is_dir() and depth else set()

    def statuses(self) -> Iterator[Array]:
        """Yield the statuses chunk by chunk."""
        for index in self._plan.grid.chunks():
            yield np.asarray(self._arrays[STATUS][self._plan.grid.region(index)])

    def sweep_up(self) -> None:
        """Remove what killed writers left of files that they had not finished."""
        for left in self._path.rglob(".*.part"):
            left.unlink(missing_ok=True)


def _indices(folder: Path, depth: int) -> Iterator[Index]:
    with os.scandir(folder) as entries:
        for entry in entries:
            if entry.name.isdecimal():
                place = int(entry.name)
                if depth == 1:
                    yield (place,)
                else:
                    for rest in _indices(Path(entry.path), depth - 1):
                        yield (place, *rest)


def prepare(path: Path, plan: Plan) -> Path:
    """Make the store of a sweep, or accept that of the same sweep.

    Parameters
    ----------
    path : Path
        Where.
    plan : Plan
        The sweep.

    Returns
    -------
    Path
        The path from the root of the file system.

    Raises
    ------
    ValueError
        If something else is there.
    OSError
        If it cannot be made.
    """
    path = path.absolute()
    if path.exists():
        _require_same(path, plan)
        return path
    if not path.parent.is_dir():
        raise ValueError(f"out = {path}: no such folder: {path.parent}")
    partial = path.with_name(f".{path.name}.part")
    try:
        shutil.rmtree(partial, ignore_errors=True)
        _create(partial, plan)
        partial.rename(path)
    except BaseException:
        shutil.rmtree(partial, ignore_errors=True)
        raise
    return path


def _require_same(path: Path, plan: Plan) -> None:
    attributes = attributes_of(path)
    if attributes is None:
        raise ValueError(f"out = {path}: is there already and holds no sweep; choose another name")
    if attributes["hash"] == plan.attributes["hash"]:
        return
    theirs, mine = json.loads(attributes["sweep"]), json.loads(plan.attributes["sweep"])
    differing = [name for name in mine if mine[name] != theirs.get(name)]
    if differing == ["version"]:
        why = f"of version {theirs.get('version')}, not {mine['version']}"
    else:
        why = f"another one in {', '.join(differing)}"
    raise ValueError(f"out = {path}: holds a sweep already, {why}; choose another name")


def attributes_of(path: Path) -> dict[str, Any] | None:
    """Return the attributes of a sweep's store; None if there is none."""
    try:
        content = json.loads((path / "zarr.json").read_text(encoding="utf-8"))
        attributes = content["attributes"]
    except (OSError, ValueError, KeyError, TypeError):
        return None
    return attributes if isinstance(attributes, dict) and {"hash", "sweep"} <= attributes.keys() else None


def _create(path: Path, plan: Plan) -> None:
    files = _WholeFiles(path)
    group = zarr.create_group(files, zarr_format=3, attributes=plan.attributes)
    grid = plan.grid
    coordinates = coordinate_fields(grid)
    for name, field in coordinates.items():
        shape = tuple(grid.axes[dimension].size for dimension in field.dimensions)
        _create_array(group, name, field, shape, tuple(min(n, _COORDINATE_CHUNK) for n in shape))
    # Those that are not named as their dimension are found by the attribute alone.
    others = " ".join(name for name, field in coordinates.items() if field.dimensions != (name,))
    for name, field in output_fields(plan).items():
        named = field._replace(attributes=field.attributes | ({"coordinates": others} if others else {}))
        _create_array(group, name, named, grid.shape, grid.chunk_shape)
    for name, place, values in coordinate_blocks(grid, _COORDINATE_CHUNK):
        target: Any = group[name]
        target[... if place is None else place] = values
    with warnings.catch_warnings():
        # That other readers may not know of it; those open the arrays one by one.
        warnings.simplefilter("ignore")
        zarr.consolidate_metadata(files, zarr_format=3)


def _create_array(group: Any, name: str, field: Field, shape: Any, chunks: Any) -> None:
    group.create_array(
        name,
        shape=shape,
        chunks=chunks,
        dtype=field.dtype,
        fill_value=field.fill,
        attributes=field.attributes,
        dimension_names=list(field.dimensions),
    )


@contextmanager
def sole_writer(path: Path) -> Generator[None]:
    """Keep other processes on the same machine from writing the same store at the same time.

    Raises
    ------
    ValueError
        If another one is writing.
    """
    try:
        import fcntl
    except ImportError:
        yield
        return
    folder = os.open(path, os.O_RDONLY)
    try:
        # Some file systems, such as those over a network, have no locks on folders.
        with contextlib.suppress(OSError):
            try:
                fcntl.flock(folder, fcntl.LOCK_EX | fcntl.LOCK_NB)
            except BlockingIOError:
                raise ValueError(f"out = {path}: another process is writing it") from None
        yield
    finally:
        os.close(folder)


def open_sweep(path: str | Path) -> xr.Dataset:
    """Result of a sweep from its store, loaded piece by piece when asked for.

    Parameters
    ----------
    path : str or Path
        Folder of the store.

    Returns
    -------
    xarray.Dataset
        Where a sweep is unfinished, the outputs are NaN and the status is -1.

    Raises
    ------
    ValueError
        If there is no sweep.
    """
    import xarray as xr

    if attributes_of(Path(path)) is None:
        raise ValueError(f"{path}: {'holds no sweep' if Path(path).exists() else 'no such folder'}")
    dataset = xr.open_zarr(str(path), chunks=None, consolidated=True)
    # Zarr has its members in the order of the alphabet.
    outputs = [name for name in (*OUTPUTS, STATUS) if name in dataset]
    return in_words(dataset[outputs])
