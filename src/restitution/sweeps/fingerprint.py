"""What distinguishes one problem from another, as text: the ground of a sweep's hash."""

from __future__ import annotations

import dataclasses
import hashlib
import inspect
import json
from collections.abc import Callable, Mapping, Sequence
from enum import Enum
from pathlib import Path
from typing import Any

import numpy as np

# Longer arrays, such as measured profiles, are told apart by their hash.
_LONG = 1000


def describe(value: Any) -> Any:
    """Return what distinguishes a value from others, in types that JSON has; floats to the last bit.

    Parameters
    ----------
    value : object
        Numbers, text, sequences, mappings, arrays, dataclasses such as `Impact`, functions.

    Returns
    -------
    object
        Plain numbers, text, lists and dictionaries.

    Raises
    ------
    TypeError
        If it is something else.

    Examples
    --------
    >>> from restitution.contact.profile import Parabola
    >>> describe(Parabola(radius=0.01))
    {'type': 'Parabola', 'radius': 0.01}
    """
    if value is None or isinstance(value, (bool, int, str)):
        return value
    if isinstance(value, Enum):
        return value.name
    if isinstance(value, (float, np.number)):
        return float(value)
    if isinstance(value, np.ndarray):
        if value.size > _LONG:
            return {"shape": list(value.shape), "sha256": hashlib.sha256(value.tobytes()).hexdigest()}
        return value.tolist()
    if isinstance(value, Path):
        return str(value)
    if dataclasses.is_dataclass(value) and not isinstance(value, type):
        fields = {
            field.name: describe(getattr(value, field.name))
            for field in dataclasses.fields(value)
            if field.compare and getattr(value, field.name) is not None
        }
        return {"type": type(value).__name__, **fields}
    if isinstance(value, Mapping):
        return {str(key): describe(item) for key, item in value.items()}
    if isinstance(value, (Sequence, set, frozenset)):
        return [describe(item) for item in value]
    if callable(value):
        return _function(value)
    raise TypeError(f"{value!r}: cannot be told apart from others; use numbers, text and dataclasses")


def _function(function: Callable[..., Any]) -> Any:
    """Describe a function by its name, its text and what it holds on to."""
    function = inspect.unwrap(function)
    try:
        text = inspect.getsource(function)
    except (OSError, TypeError):
        text = ""
    name = getattr(function, "__qualname__", type(function).__qualname__)
    cells = getattr(function, "__closure__", None) or ()
    held: list[Any] = []
    for cell in cells:
        try:
            held.append(describe(cell.cell_contents))
        except (TypeError, ValueError):
            held.append("?")
    return {"function": name, "text": text, "holds": held}


def text_of(description: Any) -> str:
    """Return a description as JSON, the same for the same description."""
    return json.dumps(description, ensure_ascii=False, separators=(",", ":"))


def hash_of(description: Any) -> str:
    """Return the SHA-256 of a description."""
    return hashlib.sha256(text_of(description).encode()).hexdigest()
