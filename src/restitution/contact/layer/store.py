"""Flat punches on layers: shipped, or computed once and kept in memory and in the user's cache."""

from __future__ import annotations

import hashlib
from contextlib import suppress
from functools import cache, lru_cache
from importlib.resources import as_file, files
from pathlib import Path

import numpy as np

from restitution.contact.layer.punch import Punches, punches
from restitution.files import user_cache, whole_file

# A file has some 70 kB. Older files are removed.
_MOST_FILES = 64
_FIELDS = ("stiffness", "edge", "softness", "ends")

SHIPPED = {None: "frictionless.npz", 0.5: "incompressible.npz"}
"""Files of the package by the Poisson ratio, made by `validation/flat_punches.py`."""


@lru_cache(maxsize=32)
def stored_punches(poisson_ratio: float | None) -> Punches:
    """Flat punches on a bonded layer of a Poisson ratio, or on a frictionless base for None.

    Those of a frictionless or a bonded incompressible layer come with the package. Others are read from the user's
    cache. Where there is none, or its content is damaged, they are computed and, if possible, written. The name of a
    file contains the inputs and a hash of the sources.
    """
    if poisson_ratio in SHIPPED:
        with as_file(files("restitution.contact.layer") / "data" / SHIPPED[poisson_ratio]) as path:
            shipped = _read(path)
        if shipped is not None:
            return shipped
    folder = user_cache()
    if folder is None:
        return punches(poisson_ratio)
    name = "frictionless" if poisson_ratio is None else float(poisson_ratio).hex().replace("-", "m")
    path = folder / "layers" / f"{name}-{_source_hash()}.npz"
    found = _read(path)
    if found is None:
        found = punches(poisson_ratio)
        with suppress(OSError):
            path.parent.mkdir(mode=0o700, parents=True, exist_ok=True)
            write(path, found)
            every = sorted(path.parent.glob("*.npz"), key=lambda one: one.stat().st_mtime, reverse=True)
            for old in every[_MOST_FILES:]:
                old.unlink(missing_ok=True)
    return found


@cache
def _source_hash() -> str:
    digest = hashlib.sha256()
    for source in sorted(Path(__file__).parent.glob("*.py")):
        digest.update(source.read_bytes())
    return digest.hexdigest()[:16]


def _read(path: Path) -> Punches | None:
    """Return the content of a file; None if there is none or it is damaged, which its check sums show."""
    # Damaged archives raise errors of many kinds.
    try:
        with path.open("rb") as stream, np.load(stream, allow_pickle=False) as file:
            n = len(file["ends"]) - 1
            resolvent, load = (tuple(file[f"{name}{i}"] for i in range(n)) for name in ("resolvent", "load"))
            return Punches(file["stiffness"], file["edge"], resolvent, load, file["softness"], file["ends"])
    except Exception:
        return None


def write(path: Path, found: Punches) -> None:
    """Write a file in one step; its bytes depend on the numbers only."""
    arrays = {name: getattr(found, name) for name in _FIELDS}
    for name, panels in (("resolvent", found.resolvent), ("load", found.load)):
        arrays |= {f"{name}{i}": panel for i, panel in enumerate(panels)}
    with whole_file(path) as partial, partial.open("wb") as file:
        np.savez(file, **arrays)
