"""The messages of the socket: what the page asks, and what it is answered."""

from __future__ import annotations

import base64
import json
import math
import time
from collections.abc import Callable, Mapping
from functools import cache
from importlib.metadata import version
from typing import Any, NamedTuple, Never

import numpy as np

from restitution.errors import InputError
from restitution.explorer import answers, downloads, dropped_files, paper
from restitution.explorer.inputs import MOST_TERMS, describe, inputs
from restitution.explorer.presets import PRESETS
from restitution.explorer.state import State, one_line
from restitution.explorer.units import systems
from restitution.impact.status import SolverError
from restitution.quantities import BOUNCES, HISTORY, INPUTS, MODULI, OUTPUTS, VALIDITY

LONGEST = 65_536
"""Most characters of a message without a file."""

LONGEST_FILE_MESSAGE = LONGEST + (4 * dropped_files.LONGEST) // 3
"""Most characters of a message with files, whose bytes are in base64."""

BUG = "this is a mistake in the program; please report it"

_LONGEST_ID = 64
_GROUPS = {
    "material": "Material", "body": "Body", "impact": "Impact", "bounces": "Bounces", "indentation": "Indentation",
}  # fmt: skip


class Request(NamedTuple):
    """A request of the page."""

    id: int | float | str | None
    kind: str
    content: Mapping[str, Any]


def _refuse(wanted: str, field: str = "message") -> Never:
    raise InputError(field, wanted=wanted)


def read(text: str | None) -> Request:
    """Return the request of a message; an `InputError` refuses what is none."""
    if text is None:
        _refuse("must be text")
    if len(text) > LONGEST_FILE_MESSAGE:
        _refuse(f"has {len(text)} characters: must have at most {LONGEST_FILE_MESSAGE}")
    try:
        content = json.loads(text, parse_constant=lambda name: _refuse(f"{name} is no number"))
    except (ValueError, RecursionError) as error:
        if isinstance(error, InputError):
            raise
        raise InputError("message", wanted="must be JSON") from None
    if not isinstance(content, dict):
        _refuse("must be an object")
    name, kind = content.get("id"), content.get("kind")
    if not (name is None or _is_id(name)):
        _refuse("must be a finite number or a short text", "id")
    if not isinstance(kind, str) or kind not in _KINDS:
        _refuse(f"must be one of {', '.join(_KINDS)}", "kind")
    if kind != "file" and len(text) > LONGEST:
        _refuse(f"has {len(text)} characters: must have at most {LONGEST}")
    if not isinstance(content.get("state", {}), dict):
        _refuse("must be an object", "state")
    return Request(name, kind, content)


def number_of(text: str | None) -> Any:
    """Return the number of a message that could not be read, if it has one."""
    try:
        found = json.loads(text or "")["id"]
    except (ValueError, RecursionError, KeyError, TypeError):
        return None
    return found if _is_id(found) else None


def _is_id(value: Any) -> bool:
    """Whether an answer can repeat a value as the number of its request."""
    if isinstance(value, bool) or not isinstance(value, int | float | str) or len(str(value)) > _LONGEST_ID:
        return False
    return isinstance(value, str) or math.isfinite(value)


def answer(request: Request) -> str:
    """Return the answer to a request as JSON; one that fails has its reason in one line."""
    started = time.thread_time()
    try:
        # Extreme numbers overflow on their way to a status or a refusal.
        with np.errstate(all="ignore"):
            found = _KINDS[request.kind](request.content)
        found = {"ok": True, "cost": time.thread_time() - started} | found
    except InputError as error:
        found = refusal(error)
    except SolverError as error:
        found = {"ok": False, "error": " ".join(str(error).split()), "field": None}
    except (ValueError, ArithmeticError, MemoryError, RuntimeError) as error:
        reason = " ".join(str(error).split()) or type(error).__name__
        found = {"ok": False, "error": f"cannot be computed: {reason[:200]}", "field": None}
    except Exception as error:
        found = failure(request.id, request.kind, error)
    try:
        return json.dumps({"id": request.id, "kind": request.kind} | found, allow_nan=False, default=_doubles)
    except (TypeError, ValueError) as error:
        return json.dumps(failure(request.id, request.kind, error))


def failure(number: int | float | str | None, kind: str, error: Exception) -> dict[str, Any]:
    """Return the answer to a request that a mistake of the program ended."""
    what = f"{type(error).__name__}: {' '.join(str(error).split())[:200]}"
    return {"id": number, "kind": kind, "ok": False, "error": f"{what}; {BUG}", "field": None}


def _doubles(values: np.ndarray) -> dict[str, str]:
    """Numbers in base64, little-endian, which take a tenth of the time of decimals."""
    return {"doubles": base64.b64encode(values.astype("<f8").tobytes()).decode("ascii")}


def refusal(error: InputError) -> dict[str, Any]:
    """Return the part of an answer that names a wrong input."""
    return {"ok": False, "error": one_line(error), "field": error.field if error.field in inputs() else None}


def _of_state(kind: Callable[[Mapping[str, Any]], dict[str, Any]]) -> Callable[[Mapping[str, Any]], dict[str, Any]]:
    return lambda content: kind(content.get("state", {}))


_KINDS: dict[str, Callable[[Mapping[str, Any]], dict[str, Any]]] = {
    **{name: _of_state(kind) for name, kind in answers.KINDS.items()},
    "paper": lambda _: paper.answer(),
    "file": dropped_files.read,
    "download": downloads.download,
}


def schema(state: State | None = None, title: str | None = None) -> str:
    """Return the message at connect: everything that the page may ask for and show, and the state at the start."""
    return json.dumps({"kind": "schema"} | _about() | {"state": state or {}, "title": title}, allow_nan=False)


_FURTHER = {
    "turning_time": ("time of the largest depth", "t_m", "time"),
    "contact_end_time": ("end of the contact", "t_end", "time"),
    "work": ("work of the indenter", "W", "energy"),
    "relaxation_modulus": ("reduced relaxation modulus", "E*(t)", "modulus"),
    "shear_modulus": ("relaxation modulus in shear", "G(t)", "modulus"),
    "nu": ("static Poisson ratio", "ν", "dimensionless number"),
    "doubtful": ("an assumption is doubtful", "", "dimensionless number"),
    "displacement": ("displacement of the surface", "w", "length"),
    "drop_height": ("height of the release", "h", "length"),
    "total_time": ("time of the last touch", "t", "time"),
    "n_bounces": ("number of bounces", "n", "dimensionless number"),
    "bounce": ("bounce", "n", "dimensionless number"),
}


@cache
def _about() -> dict[str, Any]:
    registries = INPUTS | MODULI | BOUNCES | dict(VALIDITY) | HISTORY | OUTPUTS
    outputs = {name: describe(one) for name, one in registries.items()}
    units = systems()
    for system in units.values():
        # A geometry of a user may have a dimension of its own.
        for one in (*inputs().values(), *registries.values()):
            quantity: Any = getattr(one, "quantity", one)
            if quantity is not None:
                system.setdefault(quantity.dimension.name, {"unit": quantity.unit, "factor": 1.0, "offset": 0.0})
    for name, (words, symbol, dimension) in _FURTHER.items():
        unit = units["SI"][dimension]["unit"]
        outputs[name] = {"words": words, "symbol": symbol, "dimension": dimension, "unit": unit}
    return {
        "version": version("restitution"),
        "inputs": [one.describe() for one in inputs().values()],
        "groups": [{"name": name, "words": words} for name, words in _GROUPS.items()],
        "outputs": outputs,
        "units": units,
        "presets": [{"name": name, "words": words, "state": state} for name, (words, state) in PRESETS.items()],
        "limits": {"file_characters": dropped_files.LONGEST, "message_characters": LONGEST, "terms": MOST_TERMS},
    }
