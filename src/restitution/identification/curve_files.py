"""Indentation curves in files of atomic force microscopes, read with the package afmformats."""

from __future__ import annotations

import importlib
import logging
import math
import re
import tempfile
import threading
import warnings
import zipfile
from collections.abc import Callable, Container, Generator, Mapping
from contextlib import contextmanager
from functools import partial
from pathlib import Path
from typing import Any, Literal, NamedTuple

import numpy as np
from numpy.typing import NDArray

from restitution import checks
from restitution.checks import Array, Numeric
from restitution.contact.geometry import Geometry
from restitution.errors import InputError, InputTypeError, RestitutionWarning, cut
from restitution.files import path_of
from restitution.identification.curves import IndentationCurve
from restitution.identification.observations import Noise

_TIP = "tip position"
# Columns that give the depth, best first; the first has the deflection subtracted already.
_DEPTHS = (_TIP, "height (measured)", "height (piezo)")
_FORCE_FACTORS = ("spring constant", "sensitivity")
_RATES = ("rate approach", "rate retract")
# The list of archives that afmformats keeps open is not safe for threads.
_ARCHIVES = threading.Lock()


def read_curves(
    path: str | Path,
    *,
    profile: Geometry,
    spring_constant: Any = None,
    sensitivity: Any = None,
    rate: Any = None,
    duration: Any = None,
    metadata: Mapping[str, Any] | None = None,
    noise: Noise | None = None,
) -> CurveFile:
    """Return curves of a file, as functions that each read one curve, for `identify_map`.

    Parameters
    ----------
    path : str or Path
        File in one of the formats of afmformats, or a zip archive of such files.
    profile : Geometry
        Profile of the indenter, or another geometry, such as a pyramid.
    spring_constant : float, optional
        Spring constant k of the cantilever [N/m]; by default that of the file.
    sensitivity : float, optional
        Sensitivity of the deflection [m/V], or [m/A] for NT-MDT; by default that of the file.
    rate, duration : float or sequence of float, optional
        Points per second [Hz], or the time that the record lasts [s]: one number, or one for each segment. One of
        them, for a file without times; it replaces the times of a file.
    metadata : mapping, optional
        Further metadata by the names of afmformats, for files that lack them.
    noise : Noise, optional
        See `IndentationCurve`.

    Returns
    -------
    CurveFile
        List of functions without arguments that each return an `IndentationCurve`. Its attribute `source` is a text
        that states where depth and time come from, and whether the deflection was subtracted. The method `read` of the
        list returns all curves that can be read, and warns of each of the others.

    Raises
    ------
    InputError
        If the package afmformats is missing or cannot read the file, or the file needs metadata that are not given.
        The functions raise it if a curve has no force, height, time or spring constant, or `IndentationCurve` refuses
        it.

    Notes
    -----
    The depth is that of the tip, d = -(z + F/k), where the height z decreases towards the surface and F/k is the
    deflection. A column "tip position" is z + F/k already, so nothing is subtracted from it. If a file names a
    segment as the approach, and its height increases there, the height has the other sign. The force is k times the
    sensitivity times the reading, so it changes with a given constant that differs from that of the file. All
    segments are read: approaches, holds, retractions. A file without times has equally spaced points in each segment.

    Examples
    --------
    >>> import restitution as rs
    >>> curves = rs.read_curves("gel.jpk-force-map", profile=rs.Parabola(2.5e-6))  # doctest: +SKIP
    >>> curves[0]().source  # doctest: +SKIP
    'depth: -height (measured) less force / (0.061 N/m); time: of the file; 3 segments'
    """
    if not isinstance(profile, Geometry):
        raise InputTypeError("profile", profile, "must be a Geometry, such as Parabola(radius)")
    if rate is not None and duration is not None:
        raise InputError("duration", duration, "must not be given beside rate")
    options = _Options(
        profile,
        _metadata(spring_constant, sensitivity, metadata),
        None if rate is None else checks.positive("rate", rate, "Hz"),
        None if duration is None else checks.positive("duration", duration, "s"),
        noise,
    )
    source = path_of(path)
    with _in_one_line(str(source)):
        is_archive = source.suffix.lower() == ".zip"
        curves = _archived(source, options) if is_archive else _in_file(source, source.name, options)
    return CurveFile(CurveReader(label, fetch, options) for label, fetch in curves)


class CurveFile(list["CurveReader"]):
    """Curves of a file, as functions that each read one curve."""

    def read(self, segment: Literal["approach"] | None = None, *, adhesion: bool = False) -> list[IndentationCurve]:
        """Return the curves that can be read, or their first approaches, and warn of each of the others in one line.

        If there are only others, the first of their errors is raised.
        """
        curves, refused = list[IndentationCurve](), list[InputError]()
        for reader in self:
            try:
                curves.append(reader(segment, adhesion=adhesion))
            except InputError as error:
                refused.append(error)
        if refused and not curves:
            raise refused[0]
        for error in refused:
            warnings.warn(RestitutionWarning("refused", str(error)), stacklevel=2)
        return curves


class FileCurve(IndentationCurve):
    """Indentation curve of a file; `source` states where depth and time come from."""

    source: str = ""


class CurveReader:
    """Function that reads one curve of a file."""

    def __init__(self, label: str, fetch: Callable[[], Record], options: _Options) -> None:
        self.label, self._fetch, self._options = label, fetch, options

    def record(self) -> Record:
        """Return what the file has."""
        with _in_one_line(self.label):
            record = self._fetch()
            _check_lengths(record.columns)
            return record

    def __call__(self, segment: Literal["approach"] | None = None, *, adhesion: bool = False) -> FileCurve:
        """Return the curve, or its first approach, perhaps with adhesion; see `IndentationCurve`."""
        record, options = self.record(), self._options
        try:
            _check_complete(record, options)
            time, of_time = _times(record, options)
            depth, force, spring, of_depth = _depth_and_force(record, options)
            curve = FileCurve(
                time, depth, force, profile=options.profile, spring_constant=spring, noise=options.noise,
                segment=segment, adhesion=adhesion, label=self.label,
            )  # fmt: skip
        except InputError as error:
            raise error.within(where=self.label) from None
        count = record.segments[0].size
        curve.source = f"depth: {of_depth}; time: {of_time}; {count} segment{'s' if count > 1 else ''}"
        return curve

    def __repr__(self) -> str:
        return f"CurveReader({self.label})"


class _Options(NamedTuple):
    """Arguments of `read_curves`."""

    profile: Geometry
    metadata: dict[str, Any]  # by the names of afmformats
    rate: Numeric | None
    duration: Numeric | None
    noise: Noise | None


class Record(NamedTuple):
    """One curve as the file has it."""

    columns: dict[str, Array]  # some of "time", "segment", "force", and one that gives the depth
    metadata: dict[str, Any]
    approach: int | None  # number of the segment that the file names an approach
    absent: list[str]  # factors of the force, without which it is unknown

    @property
    def depth(self) -> str | None:
        """Name of the column that gives the depth."""
        return next((name for name in _DEPTHS if name in self.columns), None)

    @property
    def segments(self) -> tuple[NDArray[np.intp], NDArray[np.intp]]:
        """Numbers of points of the segments, and for each point the place of its segment among them."""
        size = max((column.size for column in self.columns.values()), default=0)
        number = self.columns.get("segment", np.zeros(size))
        place = np.cumsum(np.diff(number, prepend=number[:1]) != 0)
        return np.bincount(place), place


def _needed(available: Container[str], absent: list[str]) -> list[str]:
    """Return the names of the columns to read, without the force if a factor of it is absent."""
    depth = [name for name in _DEPTHS if name in available][:1]
    names = ("time", "segment") if absent else ("time", "segment", "force")
    return [name for name in names if name in available] + depth


Fetchers = list[tuple[str, Callable[[], Record]]]


def _in_file(source: Path, name: str, options: _Options) -> Fetchers:
    """Return for each curve its label and the function that reads its columns."""
    # The upper layer of afmformats refuses files of JPK with other segments than approach, one pause and retraction.
    curves = _jpk(source, options) if source.suffix.startswith(".jpk-") else _loaded(source, options)
    return [(f"{name}[{number}]", fetch) for number, fetch in curves]


def _archived(source: Path, options: _Options) -> Fetchers:
    """Return the curves of all files in an archive; a file that cannot be read is refused alone."""
    endings: tuple[str, ...] = tuple(_library("afmformats").supported_extensions)
    fetchers = Fetchers()
    with (
        zipfile.ZipFile(source) as archive,
        tempfile.TemporaryDirectory(ignore_cleanup_errors=True) as folder,
    ):
        for member in archive.namelist():
            if not member.endswith(endings):
                continue
            name = f"{source.name}/{member}"
            try:
                with _in_one_line(name):
                    listed = _in_file(Path(archive.extract(member, folder)), name, options)
            except InputError as error:
                fetchers.append((name, partial(_refuse, error)))
                continue
            fetchers += [(label, _at_once(label, fetch)) for label, fetch in listed]
    if not fetchers:
        raise InputError("", rule=f"must hold files that afmformats reads: {', '.join(endings)}")
    return fetchers


def _at_once(label: str, fetch: Callable[[], Record]) -> Callable[[], Record]:
    """Read the columns, or keep the error of reading them; return a function that returns or raises it."""
    try:
        with _in_one_line(label):
            record = fetch()
    except InputError as error:
        return partial(_refuse, error)
    return lambda: record


def _refuse(error: InputError) -> Record:
    raise error


def _loaded(source: Path, options: _Options) -> list[tuple[int, Callable[[], Record]]]:
    """Return the number of each curve in a file, and the function that reads its columns."""
    afmformats, absent = _library("afmformats"), list[str]()
    with _in_silence():
        try:
            curves = list(afmformats.load_data(source))
        # The errors of afmformats derive from BaseException.
        except BaseException as error:
            names = [str(name) for name in getattr(error, "meta_keys", ())]
            if not names:
                raise
            # With any number in place of what is absent, it is known what else is.
            absent = [name for name in names if name not in options.metadata]
            override = dict.fromkeys(absent, 1.0) | options.metadata
            curves = list(afmformats.load_data(source, meta_override=override))
    if source.suffix == ".ibw":
        return [(curve.enum, partial(_igor_record, source, curve)) for curve in curves]
    return [(curve.enum, partial(_loaded_record, curve, absent)) for curve in curves]


def _loaded_record(data: Any, absent: list[str]) -> Record:
    metadata = dict(data.metadata)
    columns = {name: np.asarray(data[name]) for name in _needed(data, absent)}
    approach = 1 if metadata.get("imaging mode") == "stress-relaxation" else 0
    several = "segment" in columns and np.ptp(columns["segment"]) > 0
    return Record(columns, metadata, approach if several else None, absent)


def _igor_record(source: Path, data: Any) -> Record:
    """Return a record of Asylum Research with the segments that stand in the note of the file."""
    record = _loaded_record(data, [])
    note: bytes = _library("igor2.binarywave").load(source)["wave"]["note"]
    lines = dict(line.split(":", 1) for line in note.decode("utf-8", "replace").split("\r") if ":" in line)
    # The last point of each segment, and 1 towards the surface, 0 for a hold, -1 away; the first entry is the start.
    last = [int(index) for index in re.findall(r"\d+", lines.get("Indexes", ""))[1:]]
    way = re.findall(r"-?\d+", lines.get("Direction", ""))
    if not last or len(last) != len(way):
        return record
    numbers = np.arange(record.segments[1].size)
    segment = np.minimum(np.searchsorted(last, numbers), len(last) - 1)
    # A hold may have another rate, and the note does not prove which rate was used.
    uniform = "0" not in way or float(lines.get("UseDwellRate", 0)) == 0.0
    times = {"time": numbers / record.metadata[_RATES[0]]} if uniform else {}
    rates = {} if uniform else dict.fromkeys(_RATES)
    approach = way.index("1") if "1" in way else None
    return record._replace(
        columns=record.columns | {"segment": segment} | times, metadata=record.metadata | rates, approach=approach
    )


def _jpk(source: Path, options: _Options) -> list[tuple[int, Callable[[], Record]]]:
    """Return the number of each curve in a file of JPK, and the function that reads its columns."""
    reader = _library("afmformats.formats.fmt_jpk.jpk_reader").JPKReader(source)
    reader.set_metadata({name: options.metadata[name] for name in _FORCE_FACTORS if name in options.metadata})
    # The method that this replaces knows three styles of segments, and needs entries that no column depends on.
    reader.get_metadata = reader.get_metadata_jpk_primary
    numbers = enumerate(reader.get_index_numbers())
    return [(int(number), partial(_jpk_record, reader, index)) for index, number in numbers]


def _jpk_record(reader: Any, index: int) -> Record:
    with _ARCHIVES:
        segments = _jpk_segments(reader, index)
        parts = [reader.get_metadata(index, segment) for segment in segments]
        absent = [name for name in _FORCE_FACTORS if not all(name in part for part in parts)]
        columns, counts = dict[str, Array](), list[int]()
        for column in _needed(_jpk_columns(reader, index, segments), absent):
            values = [reader.get_data(column, index, segment) for segment in segments]
            columns[column], counts = np.concatenate(values), [value.size for value in values]
        styles = [reader.get_metadata_jpk_secondary(index, segment).get("curve type") for segment in segments]
    if counts:
        columns["segment"] = np.repeat(segments, counts)
    if counts and all("duration" in part for part in parts):
        steps = [part["duration"] / max(count, 1) for part, count in zip(parts, counts, strict=True)]
        columns["time"] = _spaced(steps, counts)
    return Record(columns, dict(parts[0]), segments[styles.index("extend")] if "extend" in styles else None, absent)


def _jpk_segments(reader: Any, index: int) -> list[int]:
    """Return the numbers of the segments of a curve."""
    pattern = re.compile(re.escape(f"{reader.get_index_path(index)}segments/") + r"(\d+)/")
    segments = sorted(int(match[1]) for name in reader.files if (match := pattern.fullmatch(name)))
    if not segments:
        raise InputError("", rule="has no segments")
    return segments


def _jpk_columns(reader: Any, index: int, segments: list[int]) -> list[str]:
    """Return the names of the columns that all segments have."""
    channels: dict[str, list[str]] = _library("afmformats.formats.fmt_jpk.jpk_data").JPK_COLUMNS
    names = set(reader.files)
    folders = [f"{reader.get_index_segment_path(index, segment)}channels/" for segment in segments]
    return [
        column
        for column, choices in channels.items()
        if all(any(f"{folder}{choice}.dat" in names for choice in choices) for folder in folders)
    ]


def _library(name: str) -> Any:
    """Return afmformats or a module of it."""
    try:
        return importlib.import_module(name)
    except ImportError:
        raise InputError("", rule="needs the package afmformats: pip install afmformats") from None


@contextmanager
def _in_silence() -> Generator[None]:
    """Keep warnings and logged tracebacks of afmformats off the screen; for the main thread alone."""
    logger = logging.getLogger("afmformats")
    level = logger.level
    logger.setLevel(logging.CRITICAL + 1)
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            yield
    finally:
        logger.setLevel(level)


@contextmanager
def _in_one_line(where: str) -> Generator[None]:
    """Refuse a file or curve for whatever error of the reader."""
    try:
        yield
    except (KeyboardInterrupt, SystemExit, GeneratorExit):
        raise
    except InputError as error:
        raise (error if error.where else error.within(where=where)) from None
    # The errors of afmformats derive from BaseException; its readers raise many more for damaged files.
    except BaseException as error:
        reason = " ".join(str(error).split()) or type(error).__name__
        reason = f"no entry {reason}" if isinstance(error, KeyError) else reason
        raise InputError("", rule=f"cannot be read: {cut(reason)}", where=where) from None


def _metadata(spring_constant: Any, sensitivity: Any, metadata: Any) -> dict[str, Any]:
    """Return given metadata by the names of afmformats."""
    if metadata is not None and not isinstance(metadata, Mapping):
        raise InputTypeError("metadata", metadata, 'must be a mapping, such as {"spring constant": 0.05}')
    entries = {str(name): value for name, value in (metadata or {}).items()}
    for name, value, unit in zip(_FORCE_FACTORS, (spring_constant, sensitivity), ("N/m", "m/V"), strict=True):
        key = name.replace(" ", "_")
        if value is not None and name in entries:
            raise InputError(key, value, "must be given once, not in metadata as well")
        if value is not None or name in entries:
            entries[name] = checks.single_positive(key, entries.get(name, value), unit)
    for name in _RATES:
        if name in entries:
            entries[name] = checks.single_positive(f"metadata[{name!r}]", entries[name], "Hz")
    return entries


def _check_lengths(columns: Mapping[str, Array]) -> None:
    """Refuse columns of different lengths, without points, and of more than one dimension."""
    shapes = {name: np.shape(column) for name, column in columns.items()}
    if any(shape != next(iter(shapes.values())) or len(shape) != 1 or shape == (0,) for shape in shapes.values()):
        words = ", ".join(f"{name} {' x '.join(map(str, shape))}" for name, shape in shapes.items())
        raise InputError("", rule=f"must have columns of equal length > 0, not {words}")


def _check_complete(record: Record, options: _Options) -> None:
    """Refuse a record for everything that it lacks, with what would help."""
    # The readings of NT-MDT are currents.
    unit = "m/A" if "NT-MDT" in str(record.metadata.get("format")) else "m/V"
    remedies = {"spring constant": "spring_constant=... [N/m]", "sensitivity": f"sensitivity=... [{unit}]"}
    absent = list(record.absent)
    bends = record.depth != _TIP or "sensitivity" in {*record.metadata} & {*options.metadata}
    if bends and "spring constant" not in {*absent, *record.metadata, *options.metadata}:
        absent.append("spring constant")
    lacks = {f"no {name}": remedies.get(name, f'metadata={{"{name}": ...}}') for name in absent}
    without_rate = options.rate is None and options.duration is None
    if without_rate and "time" not in record.columns and not _rates(record, options):
        each = f" (one number, or one for each of {record.segments[0].size} segments)"
        lacks["no column time"] = f"rate=... [Hz] or duration=... [s]{each}"
    missing = [f"no column {' or '.join(_DEPTHS)}"] * (record.depth is None)
    missing += ["no column force"] * ("force" not in record.columns and not record.absent)
    if missing:
        raise InputError("", rule=f"has {_listed(missing)}")
    if lacks:
        raise InputError("", rule=f"has {_listed(list(lacks))}: give {_listed(list(lacks.values()))}")


def _listed(words: list[str]) -> str:
    return " and ".join([", ".join(words[:-1]), words[-1]]) if len(words) > 1 else words[0]


def _depth_and_force(record: Record, options: _Options) -> tuple[Array, Array, float | None, str]:
    """Return depth and force, the spring constant if the deflection is still to be subtracted, and words for it."""
    stated, source = record.metadata, record.depth or ""
    ratios = {
        name: options.metadata[name] / stated[name]
        for name in _FORCE_FACTORS
        if name in {*stated} & {*options.metadata} and stated[name]
    }
    force = math.prod(ratios.values()) * record.columns["force"]
    height, sign = record.columns[source], "-"
    spring = (stated | options.metadata).get("spring constant")
    if record.approach is not None:
        approach = height[record.columns["segment"] == record.approach]
        if approach.size and approach[-1] - approach[0] > 0.5 * np.ptp(height):
            height, sign = -height, ""
    if source != _TIP:
        return -height, force, spring, f"{sign}{source} less force / ({spring:.6g} N/m)"
    words = f"{sign}{source}, from which the file has subtracted the deflection"
    ratio = ratios.get("sensitivity", 1.0)
    if ratio != 1.0:
        # The deflection grows with the sensitivity.
        height, words = height + (1.0 - 1.0 / ratio) * force / spring, f"{words}, scaled by {ratio:.6g}"
    return -height, force, None, words


def _times(record: Record, options: _Options) -> tuple[Array, str]:
    """Return times [s], and words for where they come from."""
    counts, place = record.segments
    if options.rate is not None:
        steps = 1.0 / _each("rate", options.rate, counts.size)
        return _spaced(steps, counts), "from rate"
    if options.duration is not None:
        # One number is the duration of all points, else each segment has its own.
        points = place.size if np.ndim(options.duration) == 0 else counts
        return _spaced(_each("duration", options.duration, counts.size) / points, counts), "from duration"
    if "time" in record.columns:
        return record.columns["time"], "of the file"
    return _spaced(1.0 / np.array(_rates(record, options)), counts), "from the rate of the metadata"


def _rates(record: Record, options: _Options) -> list[float] | None:
    """Return the rates [Hz] of the segments if the metadata determine them."""
    approach, retract = ((record.metadata | options.metadata).get(name) for name in _RATES)
    count = record.segments[0].size
    if not approach or not retract or count > 2 or (count == 1 and approach != retract):
        return None
    return [float(approach), float(retract)][:count]


def _each(name: str, value: Numeric, count: int) -> Array:
    """Return a number for each segment."""
    if np.ndim(value) > 0 and np.shape(value) != (count,):
        raise InputError(name, np.asarray(value).tolist(), f"must be one number, or one for each of {count} segments")
    return np.broadcast_to(value, count)


def _spaced(steps: Any, counts: Any) -> Array:
    """Return times of segments with these steps and numbers of points; a segment ends one step after its last."""
    each = np.repeat(steps, counts)
    return np.cumsum(each) - each
