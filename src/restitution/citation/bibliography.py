"""The sources by their keys, in BibTeX."""

from __future__ import annotations

import re
from functools import cache
from importlib.resources import files

_ENTRY = re.compile(r"^@(?P<kind>\w+)\{(?P<key>\w+),\n.*?^\}$", re.DOTALL | re.MULTILINE)


@cache
def entries() -> dict[str, str]:
    """BibTeX entries by their keys, in alphabetical order.

    Examples
    --------
    >>> print(entries()["lawson1974"])
    @book{lawson1974,
      author = {Lawson, C. L. and Hanson, R. J.},
      title = {Solving Least Squares Problems},
      publisher = {Prentice-Hall},
      year = {1974}
    }
    """
    from importlib.metadata import version

    text = files("restitution.citation").joinpath("references.bib").read_text(encoding="utf-8")
    text = text.replace("VERSION", version("restitution"))
    return {match["key"]: match[0] for match in _ENTRY.finditer(text)}
