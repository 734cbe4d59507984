"""Folder of the machine code of the kernel, and what it holds; without numba, which takes half a second to import."""

import hashlib
import os
import stat
import sys
import tempfile
import warnings
from functools import cache
from pathlib import Path

from restitution.errors import RestitutionWarning
from restitution.files import user_cache


@cache
def source_hash(folder: Path = Path(__file__).parent) -> str:
    """Hash of all kernel sources, because numba's own cache misses an edit of a function in another file."""
    digest = hashlib.sha256()
    for source in sorted(folder.glob("*.py")):
        digest.update(source.name.encode())
        digest.update(source.read_bytes())
    return digest.hexdigest()


def _is_mine_alone(folder: Path) -> bool:
    """Return whether a folder belongs to the user of this process and nobody else may write to it."""
    if not hasattr(os, "geteuid"):
        # Windows has access control lists, by which other users cannot write to the home directory by default.
        return True
    status = folder.stat()
    return status.st_uid == os.geteuid() and not status.st_mode & (stat.S_IWGRP | stat.S_IWOTH)


@cache
def cache_folder() -> str | None:
    """First folder for machine code to which only the user may write; None if the kernel must be compiled every time.

    The cache contains pickles: anyone who can write them can run code as the user who reads them.
    """
    chosen = os.environ.get("NUMBA_CACHE_DIR")
    candidates = [Path(chosen)] if chosen else [Path(__file__).parent / "__pycache__", user_cache()]
    for folder in candidates:
        if folder is None:
            continue
        try:
            folder.mkdir(mode=0o700, parents=True, exist_ok=True)
            if not _is_mine_alone(folder):
                if chosen:
                    what = f"NUMBA_CACHE_DIR = {chosen}: is not used, for others own it or may write it"
                    warnings.warn(RestitutionWarning("cache", what), stacklevel=2)
                continue
            with tempfile.TemporaryFile(dir=folder):
                return str(folder)
        except OSError:
            continue
    return None


def stamp(folder: Path) -> str:
    """Return the part of the names of cached files that stands for the sources of a folder."""
    return source_hash(folder)[:12]


def has_machine_code(*functions: str) -> bool:
    """Return whether the cache has machine code of functions, such as "kernel.impact.solve_block", of these sources.

    Of another processor or another version of numba it is of no use, and is compiled again.
    """
    chosen = cache_folder()
    if chosen is None:
        return False
    python = f"py{sys.version_info[0]}{sys.version_info[1]}{getattr(sys, 'abiflags', '')}"
    for function in functions:
        folder, module, name = function.rsplit(".", 2)
        sources = stamp(Path(__file__).parents[1] / folder)
        if not any(Path(chosen).glob(f"{module}.{name}-*-{sources}.{python}.nbi")):
            return False
    return True
