"""Names of other projects that docstrings use, with their places, so that links to them need no network to build.

A reference that is neither here nor in this project fails the build. The nightly check of links opens each of them.
"""

import re
import zlib
from pathlib import Path

DOCS = Path(__file__).parent
FOLDER = DOCS / "_build" / "inventories"

# Each line is the type of a name, the name, and its place below the address; $ is the name.
PROJECTS = {
    "python": (
        "https://docs.python.org/3/",
        """
        py:class dict library/stdtypes.html#$
        py:class float library/functions.html#$
        py:class functools.partial library/functools.html#$
        py:class int library/functions.html#$
        py:class list library/stdtypes.html#$
        py:class pathlib.Path library/pathlib.html#$
        py:class str library/stdtypes.html#$
        py:class tuple library/stdtypes.html#$
        py:data None library/constants.html#$
        py:function callable library/functions.html#$
        std:label bltin-boolean-values library/stdtypes.html#$
        std:term iterable glossary.html#term-$
        std:term mapping glossary.html#term-$
        std:term sequence glossary.html#term-$
        """,
    ),
    "numpy": (
        "https://numpy.org/doc/stable/",
        """
        py:module numpy reference/index.html#module-$
        py:class numpy.ndarray reference/generated/numpy.ndarray.html#$
        py:class numpy.random.Generator reference/random/generator.html#$
        std:term array_like glossary.html#term-$
        """,
    ),
    "xarray": (
        "https://docs.xarray.dev/en/stable/",
        """
        py:class xarray.DataArray generated/xarray.DataArray.html#$
        py:class xarray.Dataset generated/xarray.Dataset.html#$
        """,
    ),
    "matplotlib": (
        "https://matplotlib.org/stable/",
        """
        py:class matplotlib.axes.Axes api/_as_gen/matplotlib.axes.Axes.html#$
        py:class matplotlib.figure.Figure api/_as_gen/matplotlib.figure.Figure.html#$
        """,
    ),
}

# Words in the types of docstrings that are no names.
WORDS = {
    "optional", "of", "or", "to", "and", "pair", "pairs", "shape", "shapes", "path", "path-like", "them", "names",
    "arrays", "table", "moduli", "observations", "collection",
    "n", "m", "modes", "n_output", "n_input", "n_velocity", "n_radius",
}  # fmt: skip

ALIASES = {
    "DataArray": "xarray.DataArray",
    "Generator": "numpy.random.Generator",
    "Path": "pathlib.Path",
    "mapping": ":term:`python:mapping`",
}


def inventory(project: str, lines: str) -> bytes:
    """Return names and places in the format of Sphinx."""
    head = f"# Sphinx inventory version 2\n# Project: {project}\n# Version: \n# compressed using zlib\n"
    names = [line.split() for line in lines.strip().splitlines()]
    body = "".join(f"{name} {kind} 1 {place} -\n" for kind, name, place in names)
    return head.encode() + zlib.compress(body.encode())


def mapping() -> dict[str, tuple[str, str]]:
    """Write the inventories, and return the address and the file of each project."""
    FOLDER.mkdir(parents=True, exist_ok=True)
    for project, (_, lines) in PROJECTS.items():
        (FOLDER / f"{project}.inv").write_bytes(inventory(project, lines))
    return {project: (address, str(FOLDER / f"{project}.inv")) for project, (address, _) in PROJECTS.items()}


def aliases() -> dict[str, str]:
    """Return the full name of each class of the reference and of other projects."""
    page = (DOCS / "api" / "index.md").read_text(encoding="utf-8")
    names = re.findall(r"^   ~?([\w.]+)$", page, flags=re.MULTILINE)
    ours = {name.rpartition(".")[2]: f"restitution.{name}" for name in names}
    return {name: full for name, full in ours.items() if name[0].isupper()} | ALIASES
