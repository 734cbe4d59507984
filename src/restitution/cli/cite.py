"""The command `restitution cite`: BibTeX of what cases used."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import Annotated, Any

from restitution.cli import tables
from restitution.cli.options import JsonWithoutUnits, argument, target
from restitution.cli.terminal import user_input
from restitution.files import whole_file


def cite(
    cases: Annotated[list[Path] | None, argument("CASE.toml", "Files of impacts, indentations, sweeps.")] = None,
    json: JsonWithoutUnits = False,
    out: Annotated[Path | None, target("Write a BibTeX file", "--out", ".bib")] = None,
) -> None:
    """Print what to cite, in BibTeX: the methods, materials and profile transforms that cases used.

    Without a case, the program and the paper that it reproduces.
    """
    with user_input():
        from restitution.citation.cite import citations, cite, entries

        subjects = [_read(case) for case in cases or []]
        if json:
            used = citations(*subjects)
            tables.write_json([{"key": key, "used_for": use, "bibtex": entries()[key]} for key, use in used.items()])
        text = cite(*subjects) + "\n"
    if out is not None:
        with whole_file(out) as partial:
            partial.write_text(text, encoding="utf-8")
    elif not json:
        sys.stdout.write(text)


def _read(path: Path) -> Any:
    """Impact, indentation or sweep of a case file."""
    from restitution.case.impact import read_case
    from restitution.case.indentation import read_indentation
    from restitution.case.section import read_toml
    from restitution.case.sweep import read_sweep

    content = read_toml(path)
    if "indentation" in content:
        return read_indentation(path)
    return read_sweep(path) if {"axes", "samples"} & content.keys() else read_case(path)
