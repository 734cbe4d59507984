"""Curves from files of atomic force microscopes, read with the package afmformats."""

from __future__ import annotations

import importlib
from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

from restitution.contact.geometry import Geometry
from restitution.errors import InputError
from restitution.identification.curve import IndentationCurve
from restitution.identification.observations import Noise

_HEIGHTS = ("height (measured)", "height (piezo)")


def read_curves(
    path: str | Path, *, profile: Geometry, spring_constant: float | None = None, noise: Noise | None = None
) -> list[Callable[[], IndentationCurve]]:
    """Curves of a file, as functions that each read one curve, for `identify_map`.

    Parameters
    ----------
    path : str or Path
        File in one of the formats of afmformats.
    profile : Geometry
        Profile of the indenter, or another geometry, such as a pyramid.
    spring_constant : float, optional
        Spring constant of the cantilever [N/m]; by default that of the file.
    noise : Noise, optional
        See `IndentationCurve`.

    Raises
    ------
    InputError
        If the package afmformats is missing or cannot read the file. The functions raise it if a curve has no force,
        height, time or spring constant, or `IndentationCurve` refuses it.

    Notes
    -----
    The height of the file decreases towards the surface; the depth of the curve is its negative.
    """
    try:
        afmformats: Any = importlib.import_module("afmformats")
    except ImportError:
        raise InputError("path", str(path), "needs the package afmformats: pip install afmformats") from None
    try:
        found = list(afmformats.load_data(path))
    # The readers raise errors of many types for damaged files.
    except Exception as error:
        reason = " ".join(str(error).split()) or type(error).__name__
        raise InputError("path", str(path), f"cannot be read: {reason}") from None
    return [partial(_curve, one, profile, spring_constant, noise) for one in found]


def _curve(data: Any, profile: Geometry, spring_constant: float | None, noise: Noise | None) -> IndentationCurve:
    label = f"{Path(data.path).name}[{data.enum}]"
    height = next((name for name in _HEIGHTS if name in data), None)
    missing = [name for name in ("time", "force") if name not in data] + (["height"] if height is None else [])
    if missing or height is None:
        raise InputError(label, wanted=f"has no column {missing[0]}")
    if spring_constant is None:
        spring_constant = dict(data.metadata).get("spring constant")
    if spring_constant is None:
        raise InputError("spring_constant", wanted=f"must be given, as {label} does not state it")
    time, force, depth = data["time"], data["force"], -np.asarray(data[height])
    try:
        return IndentationCurve(
            time, depth, force, profile=profile, spring_constant=spring_constant, noise=noise, label=label
        )
    except InputError as error:
        raise error.within(where=label) from None
