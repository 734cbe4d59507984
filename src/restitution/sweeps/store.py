"""Result of a sweep in a Zarr store (format 3), whose chunks contain checksums."""

from __future__ import annotations

import contextlib
import json
import os
import tempfile
import warnings
from collections.abc import Generator, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

import google_crc32c
import numpy as np
import zarr
from numpy.typing import NDArray
from zarr.codecs import Crc32cCodec, ZstdCodec
from zarr.storage import LocalStore

from restitution.errors import InputError, RestitutionWarning
from restitution.files import PARTIAL, path_of, whole_file
from restitution.quantities import NOT_COMPUTED, STATUS, SWEEP_OUTPUTS
from restitution.sweeps.grid import Index
from restitution.sweeps.plan import Field, Plan, coordinate_blocks, coordinate_fields, hash_of, in_words, output_fields
from restitution.tally import Tally

if TYPE_CHECKING:
    import xarray as xr

Array = NDArray[Any]

# Values of a coordinate in one file; chunks of the outputs are those of the sweep.
_COORDINATE_CHUNK = 2**20
# Bytes of a checksum.
_CHECKSUM = 4
_TALLIES = "validity"
# Attribute with the hash of the others.
_SIGNATURE = "checksum"
_REPAIR = "the command or call that made the sweep repairs it"


def _refusal(path: Path, rule: str) -> InputError:
    return InputError("", rule=rule, where=str(path))


def _is_intact(content: bytes) -> bool:
    """Return whether the checksum at the end of a chunk matches its content."""
    body, checksum = content[:-_CHECKSUM], content[-_CHECKSUM:]
    return len(body) > 0 and google_crc32c.value(body) == int.from_bytes(checksum, "little")


def _place(index: Index) -> str:
    return "/".join(("c", *map(str, index)))


class _Record(NamedTuple):
    """What is known of the chunks at one place: their checksums by variable, and the tally of their impacts.

    The checksum inside a chunk does not depend on its variable and its place; the record binds it to both.
    """

    place: str
    checksums: dict[str, str]
    tally: Tally

    @staticmethod
    def file(root: Path, place: str) -> Path:
        """Return the file of the record of a place."""
        return root / _TALLIES / place.replace("/", "-")

    @classmethod
    def of(cls, place: str, chunks: dict[str, bytes], tally: Tally) -> _Record:
        """Return the record of chunks by variable."""
        return cls(place, {name: content[-_CHECKSUM:].hex() for name, content in chunks.items()}, tally)

    @property
    def content(self) -> bytes:
        """Content of the file."""
        body = "\n".join((self.place, json.dumps(self.checksums), self.tally.to_text())).encode()
        return body + google_crc32c.value(body).to_bytes(_CHECKSUM, "little")

    @classmethod
    def read(cls, file: Path) -> _Record | None:
        """Read a file; None if it is absent, damaged, or that of another place."""
        try:
            content = file.read_bytes()
            if not _is_intact(content):
                return None
            place, checksums, tally = content[:-_CHECKSUM].decode().split("\n")
            record = cls(place, json.loads(checksums), Tally.from_text(tally))
        except (OSError, ValueError, TypeError):
            return None
        return record if file.name == place.replace("/", "-") else None

    def binds(self, name: str, content: bytes) -> bool:
        """Return whether a chunk is intact, and that of this variable and place."""
        return _is_intact(content) and self.checksums.get(name) == content[-_CHECKSUM:].hex()


def _write(path: Path, content: bytes) -> None:
    path.parent.mkdir(parents=True, exist_ok=True)
    with whole_file(path) as partial:
        partial.write_bytes(content)


class _HeldFiles(LocalStore):
    """A folder whose new files are held in memory by their keys."""

    def __init__(self, root: Path) -> None:
        super().__init__(root)
        self.held: dict[str, bytes] = {}

    async def set(self, key: str, value: Any) -> None:
        self.held[key] = value.to_bytes()

    def set_sync(self, key: str, value: Any) -> None:
        # Newer versions of Zarr call this method.
        self.held[key] = value.to_bytes()


class _CheckedFiles(LocalStore):
    """A folder that refuses damaged chunks, and absent chunks unless they are not computed yet."""

    async def get(self, key: str, *arguments: Any, **named: Any) -> Any:
        return self._checked(key, await super().get(key, *arguments, **named))

    def get_sync(self, key: str, *arguments: Any, **named: Any) -> Any:
        # Newer versions of Zarr call this method.
        files: Any = super()
        return self._checked(key, files.get_sync(key, *arguments, **named))

    def _checked(self, key: str, value: Any) -> Any:
        name, _, place = key.partition("/")
        if place.split("/")[0] != "c":
            return value
        is_output = name in (*SWEEP_OUTPUTS, STATUS)
        if is_output and not (self.root / STATUS / place).is_file():
            # Not computed yet, whatever an interrupted writer has left.
            return None
        if value is None:
            raise _refusal(self.root, f"{key} is absent; {_REPAIR}")
        content = value.to_bytes()
        if not _is_intact(content):
            raise _refusal(self.root, f"{key} is damaged; {_REPAIR}")
        if is_output:
            record = _Record.read(file := _Record.file(self.root, place))
            if record is None:
                raise _refusal(self.root, f"{file.relative_to(self.root)} is damaged or absent; {_REPAIR}")
            if not record.binds(name, content):
                raise _refusal(self.root, f"{key} is damaged: it is another chunk; {_REPAIR}")
        return value


class Store:
    """A Zarr store for the chunks of one sweep; `opened` makes or checks it.

    The variable `status` records the finished chunks: its chunk is written after those of the other variables. The
    folder `validity` has a record for each chunk: its place, the checksums of its variables, and a tally of doubtful
    assumptions.
    """

    def __init__(self, path: Path, plan: Plan) -> None:
        self.path = path
        self._plan = plan
        self._files = files = _HeldFiles(path)
        # A chunk of NaN is also written, because an absent one counts as not computed.
        with zarr.config.set({"array.write_empty_chunks": True}):
            arrays: dict[str, Any] = {name: zarr.open_array(files, path=name, mode="r+") for name in plan.variables}
        self._arrays = arrays

    def keep(self, index: Index, results: dict[str, Array], tally: Tally) -> None:
        """Write the results of a chunk."""
        region, place, chunks = self._plan.grid.region(index), _place(index), dict[str, bytes]()
        for name in self._plan.variables:
            self._arrays[name][region] = results[name]
            chunks[name] = self._files.held.pop(f"{name}/{place}")
        _write(_Record.file(self.path, place), _Record.of(place, chunks, tally).content)
        # The status is the last column.
        for name, content in chunks.items():
            _write(self.path / name / place, content)

    def done(self) -> set[Index]:
        """Return the chunks whose variables are all stored and intact; remove the remains of other chunks."""
        done: set[Index] = set()
        for index in self._plan.grid.chunks():
            place = _place(index)
            chunks = {name: self.path / name / place for name in self._plan.variables}
            record = _Record.read(file := _Record.file(self.path, place))
            broken = [chunk for name, chunk in chunks.items() if not record or not _is_bound(record, name, chunk)]
            if not broken and self._arrays[STATUS][self._plan.grid.region(index)].min() > NOT_COMPUTED:
                done.add(index)
                continue
            for chunk in (chunks[STATUS], *broken, *([] if record else [file])):
                _clear(chunk, self.path)
        return done

    def statuses(self) -> Iterator[Array]:
        """Yield the statuses chunk by chunk."""
        for index in self._plan.grid.chunks():
            yield np.asarray(self._arrays[STATUS][self._plan.grid.region(index)])

    def sweep_up(self) -> None:
        """Remove unfinished files of killed writers."""
        for left in self.path.rglob(PARTIAL):
            left.unlink(missing_ok=True)

    def dataset(self) -> xr.Dataset:
        """Return the stored result."""
        self.sweep_up()
        return open_sweep(self.path)


def _is_bound(record: _Record, name: str, chunk: Path) -> bool:
    try:
        return record.binds(name, chunk.read_bytes())
    except OSError:
        return False


def _clear(file: Path, root: Path) -> None:
    """Remove a file of a store, if it is there; refuse a foreign file or folder in its place."""
    for folder in file.relative_to(root).parents:
        if (root / folder).exists() and not (root / folder).is_dir():
            raise _refusal(root, f"{folder} must be a folder; remove it")
    if file.is_dir():
        raise _refusal(root, f"{file.relative_to(root)} must be a file; remove it")
    file.unlink(missing_ok=True)


@contextmanager
def opened(path: Path, plan: Plan) -> Generator[Store]:
    """Open the store of a sweep for writing by a single process; make, check and repair it first.

    An `InputError` refuses another object at the path, and a store that another process is writing.
    """
    path = path.absolute()
    if not path.exists():
        if not path.parent.is_dir():
            raise _refusal(path, f"no such folder: {path.parent}")
        with contextlib.suppress(FileExistsError):
            path.mkdir()
    if not path.is_dir():
        raise _refusal(path, "is there already and holds no sweep; choose another name")
    with sole_writer(path):
        try:
            if any(not entry.match(PARTIAL) for entry in path.iterdir()):
                _require_same(path, plan)
                if link := next((entry for entry in path.rglob("*") if entry.is_symlink()), None):
                    where = link.relative_to(path)
                    raise _refusal(path, f"{where} is a link, so that chunks would go elsewhere; remove it")
            store = _restored(path, plan)
        except BaseException:
            # Only a folder that is still empty is removed.
            with contextlib.suppress(OSError):
                path.rmdir()
            raise
        store.sweep_up()
        yield store


def _restored(path: Path, plan: Plan) -> Store:
    """Return the store with the metadata and axes of a new one."""
    with tempfile.TemporaryDirectory(prefix="restitution-") as folder:
        _create(Path(folder), plan)
        # The metadata of the store are written first: they identify a store whose creation was interrupted.
        for entry in sorted(Path(folder).rglob("*"), key=lambda entry: len(entry.parts)):
            there = path / entry.relative_to(folder)
            if entry.is_dir():
                continue
            content = entry.read_bytes()
            if not there.is_file() or there.read_bytes() != content:
                _clear(there, path)
                _write(there, content)
    return Store(path, plan)


def _require_same(path: Path, plan: Plan) -> None:
    with contextlib.suppress(OSError):
        # Other damaged metadata are repaired.
        if plan.attributes["hash"].encode() in (path / "zarr.json").read_bytes():
            return
    attributes = attributes_of(path)
    if attributes is None:
        raise _refusal(path, "is there already and holds no sweep; choose another name")
    theirs = _parsed(attributes["sweep"])
    if not theirs:
        raise _refusal(path, "holds a sweep whose zarr.json is damaged; choose another name")
    mine = json.loads(plan.attributes["sweep"])
    differing = [name for name in mine if mine[name] != theirs.get(name)]
    if differing:
        why = f"another one in {', '.join(differing)}"
        if differing == ["version"]:
            why = f"of version {theirs.get('version')}, not {mine['version']}"
        raise _refusal(path, f"holds a sweep already, {why}; choose another name")


def _parsed(text: Any) -> dict[str, Any]:
    """Return the object of a JSON text or file; an empty one if it is damaged."""
    try:
        content = json.loads(text.read_text(encoding="utf-8") if isinstance(text, Path) else text)
    except (OSError, ValueError, TypeError, RecursionError):
        return {}
    return content if isinstance(content, dict) else {}


def attributes_of(path: Path) -> dict[str, Any] | None:
    """Return the attributes of the store of a sweep; None if there is no store."""
    attributes = _parsed(path / "zarr.json").get("attributes")
    return attributes if isinstance(attributes, dict) and {"hash", "sweep"} <= attributes.keys() else None


def _create(path: Path, plan: Plan) -> None:
    files = LocalStore(path)
    attributes = plan.attributes | {_SIGNATURE: hash_of(plan.attributes)}
    group = zarr.create_group(files, zarr_format=3, attributes=attributes)
    grid = plan.grid
    coordinates = coordinate_fields(grid)
    for name, field in coordinates.items():
        shape = tuple(grid.axes[dimension].size for dimension in field.dimensions)
        _create_array(group, name, field, shape, tuple(min(n, _COORDINATE_CHUNK) for n in shape))
    # Readers find coordinates with another name than their dimension by this attribute.
    others = " ".join(name for name, field in coordinates.items() if field.dimensions != (name,))
    for name, field in output_fields(plan).items():
        named = field._replace(attributes=field.attributes | ({"coordinates": others} if others else {}))
        _create_array(group, name, named, grid.shape, grid.chunk_shape)
    for name, place, values in coordinate_blocks(grid, _COORDINATE_CHUNK):
        target: Any = group[name]
        target[place] = values
    with warnings.catch_warnings():
        # Zarr warns that other readers may ignore these metadata; they open the arrays one by one.
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
        compressors=[ZstdCodec(), Crc32cCodec()],
    )


@contextmanager
def sole_writer(path: Path) -> Generator[None]:
    """Refuse a store that another process on the same machine is writing."""
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
                raise _refusal(path, "another process is writing it") from None
        yield
    finally:
        os.close(folder)


def open_sweep(path: str | Path) -> xr.Dataset:
    """Return the result of a sweep from its store, loaded piece by piece on access.

    Parameters
    ----------
    path : path-like
        Folder of the store.

    Returns
    -------
    xarray.Dataset
        Impacts that are not computed yet have NaN and the status -1; a warning counts their chunks.

    Raises
    ------
    InputError
        If there is no sweep, or it is damaged. Each chunk is checked when it is loaded.
    """
    import xarray as xr

    path = path_of(path)
    attributes = attributes_of(path)
    if attributes is None:
        raise _refusal(path, "holds no sweep" if path.exists() else "no such folder")
    _require_metadata(path, attributes)
    files = _CheckedFiles(path, read_only=True)
    try:
        dataset = xr.open_zarr(files, chunks=None, consolidated=True)
        status = zarr.open_array(files, path=STATUS, mode="r")
        missing = status.nchunks - status.nchunks_initialized
    except InputError:
        raise
    except Exception as error:  # Zarr and its codecs have errors of many unrelated types
        raise _refusal(path, f"is damaged ({' '.join(str(error).split())}); {_REPAIR}") from error
    if missing:
        what = f"{path}: {missing} of {status.nchunks} chunks are not computed yet, and are NaN"
        warnings.warn(RestitutionWarning("unfinished", what), stacklevel=2)
    del dataset.attrs[_SIGNATURE]
    # Zarr sorts its members by name.
    outputs = [name for name in (*SWEEP_OUTPUTS, STATUS) if name in dataset]
    tally = Tally()
    for file in sorted((path / _TALLIES).glob("*")):
        record = _Record.read(file)
        if record is None:
            raise _refusal(path, f"{file.relative_to(path)} is damaged; {_REPAIR}")
        tally.merge(record.tally)
    return in_words(dataset[outputs].assign_attrs(tally.attributes(dataset[STATUS].size)))


def _require_metadata(path: Path, attributes: dict[str, Any]) -> None:
    """Raise if the attributes of a store, or one of the two copies of the metadata of its arrays, were changed."""
    if attributes.pop(_SIGNATURE, None) != hash_of(attributes):
        raise _refusal(path, f"zarr.json is damaged; {_REPAIR}")
    try:
        copies = _parsed(path / "zarr.json")["consolidated_metadata"]["metadata"].items()
    except (KeyError, TypeError, AttributeError):
        raise _refusal(path, f"the metadata are damaged; {_REPAIR}") from None
    for name, copy in copies:
        if not copy or _parsed(path / name / "zarr.json") != copy:
            raise _refusal(path, f"{name}/zarr.json is damaged; {_REPAIR}")
