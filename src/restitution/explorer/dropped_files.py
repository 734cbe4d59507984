"""Files that are dropped onto the page: tables of a material, and case files."""

from __future__ import annotations

import tempfile
import warnings
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from restitution.case.impact import Case, CaseFile, notes_on
from restitution.case.material import FileSection
from restitution.case.section import Section, read_sections, read_toml
from restitution.errors import InputError, RestitutionWarning
from restitution.explorer.inputs import MOST_TERMS, inputs
from restitution.explorer.state import State, flat, of_case, of_material, one_line, settled
from restitution.material.fit import DynamicTable, RelaxationTable
from restitution.material.readers import parse
from restitution.material.viscoelastic import Material

LONGEST = 1_000_000
"""Most characters of a file."""

FILE_KEYS = frozenset({"file", "terms", "shift"})
"""Keys of a case file that may name another file, which would be one of the server."""

_LONGEST_NAME, _MOST_ROWS = 100, 1000


class _File(Section):
    """A file with a material alone."""

    material: FileSection


def read(content: Mapping[str, Any]) -> dict[str, Any]:
    """Return the state that a file describes, and what it holds in one line."""
    name, text = content.get("name"), content.get("text")
    if not isinstance(name, str) or not isinstance(text, str):
        raise InputError("file", wanted="must have a name and a text")
    name = " ".join(name.split())[:_LONGEST_NAME] or "file"
    if len(text) > LONGEST:
        raise InputError(name, wanted=f"has {len(text)} characters: must have at most {LONGEST}")
    with tempfile.TemporaryDirectory(prefix="restitution-") as folder, warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always", RestitutionWarning)
        path = Path(folder, "dropped.toml" if name.lower().endswith(".toml") else "dropped.txt")
        path.write_bytes(text.encode("utf-8", "replace"))
        try:
            state, words, notes = _case(path) if path.suffix == ".toml" else _material(path, text, content)
            _ = settled(state)
        except InputError as error:
            raise InputError("", wanted=_named(one_line(error), path, name)) from None
    notes = [_named(note, path, name) for note in [*notes, *(str(one.message) for one in caught)]]
    # The paper's numbers would hide the material.
    return {"state": state | {"entry": "constants"}, "words": f"{name}: {words}", "notes": list(dict.fromkeys(notes))}


def _named(line: str, path: Path, name: str) -> str:
    """Return a line that names the dropped file in place of the copy."""
    for text in (f"{path}: ", str(path), path.name):
        line = line.replace(text, f"{name}: " if text.endswith(": ") else name)
    return line if line.startswith(name) else f"{name}: {line}"


def _case(path: Path) -> tuple[State, str, list[str]]:
    """State of a case file, which must name no other file."""
    content = read_toml(path)
    for key, value in flat(content).items():
        if key.rpartition(".")[2] in FILE_KEYS:
            raise InputError(key, value, "names another file, which the page has not; drop that file instead")
    sections = read_sections(CaseFile, path, content)
    case = Case(path, sections.title, sections.build(), {}, sections)
    return of_case(case), f"case file{'' if case.title is None else f', {case.title[:_LONGEST_NAME]}'}", []


def _material(path: Path, text: str, content: Mapping[str, Any]) -> tuple[State, str, list[str]]:
    """State of the material in a table or in the deck of a solver."""
    about = parse(text, str(path))
    notes = [*getattr(about, "notes", ()), *_thinned(about, path)]
    section: dict[str, Any] = {"file": path.name}
    given = settled(content.get("state", {}))
    if type(about).__name__ != "ViscoelasticDeck":
        bulk = "bulk_modulus" if "material.bulk_modulus" in given else "poisson_ratio"
        section[bulk] = given.get(f"material.{bulk}", inputs()["material.poisson_ratio"].default)
        section["deformation"] = getattr(about, "deformation", None) or content.get("deformation", "shear")
    made = read_sections(_File, path, {"material": section}).material
    material = made.build()
    for key in ("shear", "bulk"):
        count = getattr(getattr(material, key), "n_branches", 0)
        if count > MOST_TERMS:
            raise InputError("", wanted=f"has {count} terms in {key}: must have at most {MOST_TERMS}")
    state = of_material(material)
    return state, _words(made, material), [*notes, *notes_on(material, None)]


def _thinned(data: Any, path: Path) -> list[str]:
    """Write a table with more rows than a fit has time for anew, with fewer, and return a note of it."""
    columns = [values for values in vars(data).values() if isinstance(values, np.ndarray)]
    if not isinstance(data, RelaxationTable | DynamicTable) or columns[0].size <= _MOST_ROWS:
        return []
    x = columns[0]
    rows = np.unique(np.searchsorted(x[:-1], np.geomspace(x[x > 0.0][0], x[-1], _MOST_ROWS)))
    header = "time,modulus\ns,Pa" if len(columns) == 2 else "omega,storage modulus,loss modulus\nrad/s,Pa,Pa"
    np.savetxt(path, np.transpose(columns)[rows], delimiter=",", header=header, comments="")
    return [f"{rows.size} of its {x.size} rows are used, evenly over the logarithm of time or frequency"]


def _words(made: FileSection, material: Material) -> str:
    terms = f"{material.shear.n_branches} terms in shear"
    return terms if made.fit is None else f"data fitted by {terms}"
