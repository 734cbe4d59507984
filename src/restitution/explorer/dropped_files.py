"""Files that are dropped onto the page: tables of a material, measured points, case files with their tables."""

from __future__ import annotations

import base64
import binascii
import tempfile
import warnings
from collections.abc import Mapping, Sequence
from operator import itemgetter
from pathlib import Path
from typing import Any

import numpy as np

import restitution as rs
from restitution.case.impact import notes_on
from restitution.case.material import FileSection
from restitution.case.observations import has_points
from restitution.case.section import Section, read_sections, read_toml
from restitution.errors import InputError, RestitutionWarning
from restitution.explorer.inputs import MOST_TERMS, State, flat, inputs, one_line, settled
from restitution.explorer.states import of_file, of_material
from restitution.material.cards import PronyTerms, ViscoelasticDeck
from restitution.units import celsius

LONGEST = 1_000_000
"""Most bytes of all files of a message."""

FILE_KEYS = frozenset({"file", "terms", "shift"})
"""Keys of a case file that may name another file, which would be one of the server."""

# A case file of the page has no long tables.
_LONGEST_CASE, _MOST_FILES = 65_536, 5
_LONGEST_NAME, _MOST_ROWS = 100, 1000
# The address of the page has the measured points.
_MOST_POINTS = 300
# A temperature ramp has no single temperature.
_ROOM = "20 degC"

Question = dict[str, Any]


class _File(Section):
    """A file with a material alone."""

    material: FileSection


def read(content: Mapping[str, Any]) -> dict[str, Any]:
    """Return the state or the points that files describe, what they hold in one line, and what the page has to ask.

    The content has `files`, each with a name and its bytes in base64, the `state` of the page, and the `answers` to
    the questions. The first file is that of the case or of the material. A question without an answer on which the
    numbers depend leaves out the state.
    """
    names, files = _files(content.get("files"))
    name, answers = names[0], content.get("answers", {})
    if not isinstance(answers, dict) or not all(isinstance(text, str) for text in answers.values()):
        raise InputError("answers", rule="must be texts")
    with tempfile.TemporaryDirectory(prefix="restitution-") as folder, warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always", RestitutionWarning)
        path = Path(folder, "dropped.toml" if name.lower().endswith(".toml") else "dropped.txt")
        for copy, data in zip([path.name, *names[1:]], files, strict=True):
            Path(folder, copy).write_bytes(data)
        try:
            if path.suffix == ".toml":
                answer = _case(path, set(names[1:]))
            elif has_points(path):
                answer = _points(path)
            else:
                answer = _material(path, settled(content.get("state", {})), answers)
            if "state" in answer:
                _ = settled(answer["state"])
        except InputError as error:
            raise InputError("", rule=_named(one_line(error), path, name)) from None
    notes = [_named(note, path, name) for note in [*answer["notes"], *(str(warning.message) for warning in caught)]]
    return answer | {"words": f"{name}: {answer['words']}", "notes": list(dict.fromkeys(notes))}


def _files(items: Any) -> tuple[list[str], list[bytes]]:
    """Return the names and contents of the files of a message; a name has no folder."""
    if not isinstance(items, list) or not 0 < len(items) <= _MOST_FILES or not all(isinstance(g, dict) for g in items):
        raise InputError("files", rule=f"must be a list of 1 to {_MOST_FILES} files")
    names: list[str] = []
    contents: list[bytes] = []
    for file in items:
        name, data = file.get("name"), file.get("data")
        if not isinstance(name, str) or not isinstance(data, str):
            raise InputError("file", rule="must have a name and its bytes in base64")
        try:
            contents.append(base64.b64decode(data, validate=True))
        except (binascii.Error, ValueError):
            raise InputError("file", rule="must have its bytes in base64") from None
        names.append(" ".join(name.split())[:_LONGEST_NAME] or "file")
    for name in names[1:]:
        if Path(name).name != name or not name.isprintable() or name.startswith(("dropped.", ".")):
            raise InputError("file", name, "must be a plain name")
    if (size := sum(map(len, contents))) > LONGEST:
        raise InputError(names[0], rule=f"has {size} bytes: must have at most {LONGEST}")
    return names, contents


def _named(line: str, path: Path, name: str) -> str:
    """Return a line that names the dropped file in place of the copy."""
    for text in (f"{path}: ", str(path), path.name):
        line = line.replace(text, f"{name}: " if text.endswith(": ") else name)
    line = line.replace(f"{path.parent}/", "")
    return line if line.startswith(name) else f"{name}: {line}"


def _case(path: Path, dropped: set[str]) -> dict[str, Any]:
    """Return the state of a case file, which may name only files that were dropped with it."""
    if (size := path.stat().st_size) > _LONGEST_CASE:
        raise InputError("", rule=f"has {size} bytes: a case file must have at most {_LONGEST_CASE}")
    content = read_toml(path)
    for key, value in flat(content).items():
        if key.rpartition(".")[2] in FILE_KEYS and value not in dropped:
            raise InputError(key, value, "names another file, which the page has not; drop both files together")
    state, title = of_file(path)
    words = f"case file{'' if title is None else f', {title[:_LONGEST_NAME]}'}"
    # The paper's numbers would hide the material.
    return {"state": state | {"entry": "constants"}, "words": words, "notes": [], "questions": []}


def _points(path: Path) -> dict[str, Any]:
    """Return measured coefficients of restitution, as rows of a velocity [m/s], e and perhaps its deviation."""
    points = rs.read_points(path)
    if (count := points.velocity.size) > _MOST_POINTS:
        raise InputError("", rule=f"has {count} points: must have at most {_MOST_POINTS}")
    rows = np.transpose([column for column in points if column is not None])
    return {"points": rows.tolist(), "words": f"{count} measured points", "notes": [], "questions": []}


_DEFORMATION: Question = {
    "key": "deformation", "words": "The moduli are those of", "options": [["shear", "shear"], ["tension", "tension"]],
}  # fmt: skip
_ENDS: list[Question] = [
    {"key": "instantaneous_modulus", "words": "Instantaneous modulus, with its unit"},
    {"key": "equilibrium_modulus", "words": "Equilibrium modulus, with its unit"},
]
_FREQUENCY: Question = {"key": "frequency", "words": "Frequency, with its unit", "value": "1 Hz"}
_TEMPERATURE: Question = {"key": "temperature", "words": "Temperature, with its unit"}


def _material(path: Path, state: State, answers: Mapping[str, str]) -> dict[str, Any]:
    """Return the state of the material in a table or a deck, and the open questions; its bulk is as in the state."""
    about = rs.read_material(path)
    notes = [*getattr(about, "notes", ()), *_thinned(about, path)]
    questions = _questions(about)
    stated = {key: text for key in map(itemgetter("key"), questions) if (text := answers.get(key, "").strip())}
    is_open = any(question["key"] not in (*stated, "temperature") for question in questions)
    if is_open and not stated.keys() & {"instantaneous_modulus", "equilibrium_modulus"}:
        return {"questions": questions, "words": "is not used yet, as it does not state everything", "notes": notes}
    section: dict[str, Any] = {"file": path.name}
    if not isinstance(about, ViscoelasticDeck):
        bulk = "bulk_modulus" if "material.bulk_modulus" in state else "poisson_ratio"
        section[bulk] = state.get(f"material.{bulk}", inputs()["material.poisson_ratio"].default)
        if bulk == "poisson_ratio" and section[bulk] < 0.5:
            notes.append(f"the Poisson ratio {section[bulk]:g} is constant in time; a bulk modulus is the alternative")
    if isinstance(about, rs.TemperatureRamp):
        stated.setdefault("temperature", _ROOM)
    built = read_sections(_File, path, {"material": section | stated}).material
    material = built.build()
    if isinstance(about, rs.Isotherms | rs.TemperatureRamp):
        degrees = celsius(material.temperature or 0.0, 4)
        notes.append(f"the moduli are those at {degrees} °C")
        questions = [*questions[:-1], _TEMPERATURE | {"value": f"{degrees} degC"}]
    for key in ("shear", "bulk"):
        count = getattr(getattr(material, key), "n_branches", 0)
        if count > MOST_TERMS:
            raise InputError("", rule=f"has {count} terms in {key}: must have at most {MOST_TERMS}")
    notes += notes_on(material, None)
    terms = f"{material.shear.n_branches} terms in shear"
    words = terms if built.fit is None else f"data fitted by {terms}"
    # The paper's numbers would hide the material.
    state = of_material(material) | {"entry": "constants"}
    return {"state": state, "words": words, "notes": notes, "questions": questions}


def _questions(about: Any) -> list[Question]:
    """Return what a file of a material does not state, and what may be chosen afterwards."""
    questions: list[Question] = []
    if not isinstance(about, ViscoelasticDeck) and getattr(about, "deformation", None) is None:
        questions.append(_DEFORMATION)
    ends = getattr(about, "instantaneous_modulus", None), getattr(about, "equilibrium_modulus", None)
    if isinstance(about, PronyTerms) and about.relative and ends == (None, None):
        questions += _ENDS
    if isinstance(about, rs.TemperatureRamp):
        return [*questions, *([] if about.angular_frequency else [_FREQUENCY]), _TEMPERATURE]
    return [*questions, _TEMPERATURE] if isinstance(about, rs.Isotherms) else questions


def _thinned(data: Any, path: Path) -> Sequence[str]:
    """Write a table with more rows than a fit has time for anew, with fewer, and return a note of it."""
    columns = [values for values in vars(data).values() if isinstance(values, np.ndarray)]
    if not isinstance(data, rs.RelaxationTable | rs.DynamicTable | rs.CreepTable) or columns[0].size <= _MOST_ROWS:
        return []
    x = columns[0]
    rows = np.unique(np.searchsorted(x[:-1], np.geomspace(x[x > 0.0][0], x[-1], _MOST_ROWS)))
    letter = {"shear": "G", "tension": "E"}.get(str(data.deformation))
    creep = {"G": "J(t)", "E": "D(t)"}.get(letter or "", "compliance")
    header = (f"time,{creep}\ns,1/Pa" if isinstance(data, rs.CreepTable)
              else f"time,{letter or 'modulus'}\ns,Pa" if len(columns) == 2
              else f"omega,{letter}',{letter}''\nrad/s,Pa,Pa" if letter
              else "omega,storage modulus,loss modulus\nrad/s,Pa,Pa")  # fmt: skip
    np.savetxt(path, np.transpose(columns)[rows], delimiter=",", header=header, comments="")
    return [f"{rows.size} of its {x.size} rows are used, evenly over the logarithm of time or frequency"]
