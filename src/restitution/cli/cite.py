"""The command `restitution cite`: BibTeX of what cases used."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import Annotated, Any

from restitution.cli import tables
from restitution.cli.exit_codes import user_input
from restitution.cli.options import Json, argument, option


def cite(
    cases: Annotated[list[Path] | None, argument("CASE.toml...", "Files of impacts, indentations, sweeps.")] = None,
    json: Json = False,
    out: Annotated[Path | None, option("Write a BibTeX file: .bib.", metavar="FILE")] = None,
) -> None:
    """Print what to cite, in BibTeX: the methods, materials and profile transforms that cases used.

    Without a case, the program and the paper that it reproduces.
    """
    tables.check_target("--out", out, (".bib",))
    with user_input():
        from restitution.citation.bibliography import entries
        from restitution.citation.cite import citations, cite

        subjects = [_read(case) for case in cases or []]
        if json:
            content = [
                {"key": key, "used_for": uses, "bibtex": entries()[key]} for key, uses in citations(*subjects).items()
            ]
            tables.write_json(content)
        text = cite(*subjects) + "\n"
    if out is not None:
        from restitution.files import whole_file

        with whole_file(out) as partial:
            partial.write_text(text, encoding="utf-8")
    elif not json:
        sys.stdout.write(text)


def _read(path: Path) -> Any:
    """What a case file describes: an impact, an indentation, or a sweep."""
    from restitution.case.impact import read_case
    from restitution.case.indentation import read_indentation
    from restitution.case.section import read_toml
    from restitution.case.sweep import read_sweep

    content = read_toml(path)
    if "indentation" in content:
        return read_indentation(path)
    return read_sweep(path) if {"axes", "samples"} & content.keys() else read_case(path)
