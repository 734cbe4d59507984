"""Indentation curves in files of atomic force microscopes, read with the package afmformats."""

from __future__ import annotations

import importlib
import math
from collections.abc import Callable, Generator, Mapping
from contextlib import contextmanager
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

from restitution import checks
from restitution.checks import Array
from restitution.contact.geometry import Geometry
from restitution.errors import InputError, InputTypeError, cut
from restitution.files import path_of
from restitution.identification.curves import IndentationCurve
from restitution.identification.observations import Noise

_HEIGHTS = ("height (measured)", "height (piezo)")
_FORCE_FACTORS = ("spring constant", "sensitivity")


def read_curves(
    path: str | Path,
    *,
    profile: Geometry,
    spring_constant: Any = None,
    sensitivity: Any = None,
    metadata: Mapping[str, Any] | None = None,
    noise: Noise | None = None,
) -> list[Callable[[], IndentationCurve]]:
    """Return curves of a file, as functions that each read one curve, for `identify_map`.

    Parameters
    ----------
    path : str or Path
        File in one of the formats of afmformats.
    profile : Geometry
        Profile of the indenter, or another geometry, such as a pyramid.
    spring_constant : float, optional
        Spring constant of the cantilever [N/m]; by default that of the file.
    sensitivity : float, optional
        Sensitivity of the deflection [m/V], or [m/A] for NT-MDT; by default that of the file.
    metadata : mapping, optional
        Further metadata by the names of afmformats, for files that lack them, such as
        ``{"rate approach": 2000, "rate retract": 1000}``, the points per second of a file without times.
    noise : Noise, optional
        See `IndentationCurve`.

    Raises
    ------
    InputError
        If the package afmformats is missing or cannot read the file, or the file needs metadata that are not given.
        The functions raise it if a curve has no force, height, time or spring constant, or `IndentationCurve` refuses
        it.

    Notes
    -----
    The height of the file decreases towards the surface; the depth of the curve is its negative. The force is the
    spring constant times the sensitivity times the reading, so it changes with a given constant that differs from
    that of the file. A file without times has equally spaced points in each segment, at the rates of its metadata.
    """
    if not isinstance(profile, Geometry):
        raise InputTypeError("profile", profile, "must be a Geometry, such as Parabola(radius)")
    source = path_of(path)
    stated = _metadata(spring_constant, sensitivity, metadata)
    try:
        afmformats: Any = importlib.import_module("afmformats")
    except ImportError:
        raise InputError("", rule="needs the package afmformats: pip install afmformats", where=str(source)) from None
    try:
        with _in_one_line(str(source)):
            curves = list(afmformats.load_data(source))
    except _MissingMetadataError as missing:
        absent = [name for name in missing.names if name not in stated]
        if absent:
            raise InputError("", rule=_advice(absent), where=str(source)) from None
        with _in_one_line(str(source)):
            curves = list(afmformats.load_data(source, meta_override=stated))
    return [partial(_curve, curve, profile, stated, noise) for curve in curves]


class _MissingMetadataError(Exception):
    """Metadata without which afmformats does not read a file."""

    def __init__(self, names: list[str]) -> None:
        super().__init__(names)
        self.names = names


@contextmanager
def _in_one_line(where: str) -> Generator[None]:
    """Refuse a file or curve for whatever error of the reader."""
    try:
        yield
    except (KeyboardInterrupt, SystemExit, GeneratorExit):
        raise
    # The errors of afmformats derive from BaseException; its readers raise many more for damaged files.
    except BaseException as error:
        names = getattr(error, "meta_keys", None)
        if names:
            raise _MissingMetadataError([str(name) for name in names]) from None
        reason = " ".join(str(error).split()) or type(error).__name__
        raise InputError("", rule=f"cannot be read: {cut(reason)}", where=where) from None


def _metadata(spring_constant: Any, sensitivity: Any, metadata: Any) -> dict[str, Any]:
    """Return given metadata by the names of afmformats."""
    if metadata is not None and not isinstance(metadata, Mapping):
        raise InputTypeError("metadata", metadata, 'must be a mapping, such as {"rate approach": 2000}')
    entries = {str(name): value for name, value in (metadata or {}).items()}
    for name, value, unit in zip(_FORCE_FACTORS, (spring_constant, sensitivity), ("N/m", "m/V"), strict=True):
        key = name.replace(" ", "_")
        if value is not None and name in entries:
            raise InputError(key, value, "must be given once, not in metadata as well")
        if value is not None or name in entries:
            entries[name] = checks.single_positive(key, entries.get(name, value), unit)
    return entries


def _advice(names: list[str]) -> str:
    """Return advice on metadata that a file lacks."""
    arguments = {"spring constant": "spring_constant=... [N/m]", "sensitivity": "sensitivity=... [m/V]"}
    forms = [arguments.get(name, f'metadata={{"{name}": ...}}') for name in names]
    return f"does not state the {' and the '.join(names)}: give {' and '.join(forms)}"


def _curve(data: Any, profile: Geometry, metadata: dict[str, Any], noise: Noise | None) -> IndentationCurve:
    label = f"{Path(data.path).name}[{data.enum}]"
    stated = dict(data.metadata)
    entries = stated | metadata
    height = next((name for name in _HEIGHTS if name in data), None)
    if height is None or "force" not in data:
        raise InputError("", rule=f"has no column {'height' if height is None else 'force'}", where=label)
    if "spring constant" not in entries:
        raise InputError("spring_constant", rule=f"must be given, as {label} does not state it")
    try:
        with _in_one_line(label):
            factor = math.prod(entries[name] / stated[name] for name in _FORCE_FACTORS if name in stated)
            force, depth = factor * np.asarray(data["force"]), -np.asarray(data[height])
            time = np.asarray(data["time"]) if "time" in data else _times(data, label, entries)
    except _MissingMetadataError as missing:
        raise InputError("", rule=_advice(missing.names), where=label) from None
    try:
        return IndentationCurve(
            time, depth, force, profile=profile, spring_constant=entries["spring constant"], noise=noise, label=label
        )
    except InputError as error:
        raise error.within(where=label) from None


def _times(data: Any, label: str, metadata: Mapping[str, Any]) -> Array:
    """Return times [s] of the points of an approach and a retraction, from their rates."""
    if "segment" not in data or not {"rate approach", "rate retract"} <= metadata.keys():
        rule = 'has no column time: give metadata={"rate approach": ..., "rate retract": ...}, in points per second'
        raise InputError("", rule=rule, where=label)
    segment = np.asarray(data["segment"])
    parts = np.unique(segment)
    if parts.size > 2:
        rule = f"has no column time and {parts.size} segments: must have an approach and a retraction"
        raise InputError("", rule=rule, where=label)
    names = ("rate approach", "rate retract")
    rates = [checks.single_positive(f"metadata[{name!r}]", metadata[name], "Hz") for name in names]
    return np.cumsum(np.where(segment == parts[0], 1.0 / rates[0], 1.0 / rates[1]))
