"""Compilation of the kernel, and the cache of its machine code."""

import hashlib
import os
import stat
import sys
import tempfile
import warnings
from collections.abc import Callable
from functools import cache
from pathlib import Path
from typing import Any

import numba
from numba.core import caching, config

from restitution.errors import RestitutionWarning

# Without reference counts (`_nrt`) an impact costs 37 -> 30 us; the kernel therefore allocates nothing.
# `contract` alone: full fastmath removes the NaN checks that the status codes rest on and gains nothing more.
_FLAGS: dict[str, Any] = {"_nrt": False, "nogil": True, "fastmath": {"contract"}, "error_model": "numpy"}
_INNER: dict[str, Any] = {"no_cpython_wrapper": True, "no_cfunc_wrapper": True}


@cache
def source_hash(folder: Path = Path(__file__).parent) -> str:
    """Hash of all kernel sources: numba's own cache misses an edit in a callee of another file."""
    digest = hashlib.sha256()
    for source in sorted(folder.glob("*.py")):
        digest.update(source.name.encode())
        digest.update(source.read_bytes())
    return digest.hexdigest()


def _user_cache() -> Path | None:
    """Folder for caches in the home directory; None where there is no home."""
    if sys.platform == "win32":
        stated, beside_home = os.environ.get("LOCALAPPDATA"), "AppData/Local"
    elif sys.platform == "darwin":
        stated, beside_home = None, "Library/Caches"
    else:
        stated, beside_home = os.environ.get("XDG_CACHE_HOME"), ".cache"
    # The XDG standard says that a relative path must be ignored.
    if stated and Path(stated).is_absolute():
        return Path(stated) / "restitution"
    try:
        return Path.home() / beside_home / "restitution"
    except RuntimeError:
        return None


def _is_mine_alone(folder: Path) -> bool:
    """Whether a folder belongs to the user of this process and nobody else may write it."""
    if not hasattr(os, "geteuid"):
        # Windows has access control lists; the home directory is closed to others by default.
        return True
    status = folder.stat()
    return status.st_uid == os.geteuid() and not status.st_mode & (stat.S_IWGRP | stat.S_IWOTH)


@cache
def cache_folder() -> str | None:
    """First folder for machine code that the user alone may write; None where the kernel must be compiled anew.

    The cache holds pickles: whoever may write it can run code as the user that reads it.
    """
    own = os.environ.get("NUMBA_CACHE_DIR")
    candidates = [Path(own)] if own else [Path(__file__).parent / "__pycache__", _user_cache()]
    for folder in candidates:
        if folder is None:
            continue
        try:
            folder.mkdir(mode=0o700, parents=True, exist_ok=True)
            if not _is_mine_alone(folder):
                if own:
                    what = f"NUMBA_CACHE_DIR = {own}: is not used, for others own it or may write it"
                    warnings.warn(RestitutionWarning("cache", what), stacklevel=2)
                continue
            with tempfile.TemporaryFile(dir=folder):
                return str(folder)
        except OSError:
            continue
    return None


class _Locator(caching._CacheLocator):  # pyright: ignore[reportPrivateUsage]
    def __init__(self, py_func: Callable[..., Any], folder: str) -> None:
        self._line = py_func.__code__.co_firstlineno
        self._sources = Path(py_func.__code__.co_filename).parent
        self._folder = folder

    def get_cache_path(self) -> str:
        return self._folder

    def get_source_stamp(self) -> str:
        return source_hash(self._sources)

    def get_disambiguator(self) -> str:
        # The name of the file holds the hash: numba unpickles an index before it compares the stamp, and the
        # classes of another version may be gone.
        return f"{self._line}-{source_hash(self._sources)[:12]}"

    @classmethod
    def from_function(cls, py_func: Callable[..., Any], py_file: str) -> "_Locator | None":
        folder = cache_folder()
        return None if folder is None else cls(py_func, folder)


class _CacheImpl(caching.CompileResultCacheImpl):
    _locator_classes = [_Locator]  # noqa: RUF012 (the base class declares it so)


class _KernelCache(caching.FunctionCache):
    _impl_class = _CacheImpl


# Words of a frame, half of the piece of memory that it comes with.
_ROOM = 2**15


def _with_room(function: Callable[..., Any]) -> Callable[..., Any]:
    """Call a function in a way that gives room to the frames of all that it calls.

    CPython keeps frames in pieces of 16 kB. If the end of one falls on a call that numba makes a million times, each
    call allocates and frees a piece: the kernel compiles in 10 to 16 s, depending on the depth of the caller.
    """

    def call(*arguments: Any, **named: Any) -> Any:
        return function(*arguments, **named)

    call.__code__ = call.__code__.replace(co_stacksize=_ROOM)
    return call


def entry_point(function: Callable[..., Any]) -> Any:
    """Compile an entry point of the kernel on its first call, and keep its machine code where that is possible."""
    dispatcher: Any = cached(numba.njit(**_FLAGS)(function), function)
    if not config.DISABLE_JIT:
        # Numba's own code calls this for new types of arguments.
        dispatcher._compile_for_args = _with_room(dispatcher._compile_for_args)
    return dispatcher


def compiled(function: Callable[..., Any]) -> Any:
    """Compile a stage of an impact, which only the kernel calls, as a function of its own.

    One giant function takes twice as long to compile; so do wrappers for calls from Python.
    """
    return cached(numba.njit(**_INNER, **_FLAGS)(function), function)


def cached(dispatcher: Any, function: Callable[..., Any]) -> Any:
    """Keep the machine code of a compiled function until a source in its folder changes."""
    if not config.DISABLE_JIT and cache_folder() is not None:
        dispatcher._cache = _KernelCache(function)
    return dispatcher


def inlined(function: Callable[..., Any]) -> Any:
    """Compile a piece of the kernel into its callers, so that the sizes which they pass are constants in it."""
    return numba.njit(forceinline=True, **_INNER, **_FLAGS)(function)


def is_compiled(dispatcher: Any) -> bool:
    """Whether an entry point has machine code in this process already (always true without compilation)."""
    return bool(config.DISABLE_JIT) or bool(dispatcher.signatures)
