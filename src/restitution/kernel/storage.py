"""Machine code of entry points on disk, and bitcode of LLVM in a wheel, which becomes machine code in seconds."""

import os
from collections.abc import Callable
from pathlib import Path
from typing import Any

import llvmlite
import llvmlite.binding as llvm
from numba.core import caching

from restitution.kernel.cache import cache_folder, source_hash, stamp

BITCODE = Path(__file__).parent / "bitcode"
"""Folder of the bitcode; a source tree has none."""

WRITE_BITCODE = "RESTITUTION_BITCODE"
"""Environment variable with a folder: the compiler also writes bitcode there."""


class _Locator(caching._CacheLocator):  # pyright: ignore[reportPrivateUsage]
    """Place of the machine code of one function."""

    def __init__(self, py_func: Callable[..., Any], folder: str) -> None:
        # Numba reads `_py_file` for its warnings.
        self._py_file = py_func.__code__.co_filename
        self._line = py_func.__code__.co_firstlineno
        self._sources = Path(self._py_file).parent
        self._folder = folder

    def get_cache_path(self) -> str:
        return self._folder

    def get_source_stamp(self) -> str:
        return source_hash(self._sources)

    def get_disambiguator(self) -> str:
        # The name of the file contains the hash, because numba unpickles an index before it compares the stamp, and
        # classes of another version may be missing.
        return f"{self._line}-{stamp(self._sources)}"

    @classmethod
    def from_function(cls, py_func: Callable[..., Any], py_file: str) -> "_Locator | None":
        folder = cache_folder()
        return None if folder is None else cls(py_func, folder)


class _BitcodeLocator(_Locator):
    @classmethod
    def from_function(cls, py_func: Callable[..., Any], py_file: str) -> "_Locator":
        return cls(py_func, os.environ.get(WRITE_BITCODE) or str(BITCODE))


class _MachineCodeForm(caching.CompileResultCacheImpl):
    _locator_classes = [_Locator]  # noqa: RUF012 (the base class declares it so)


# Place of the notes on types behind the library in what numba stores of a function.
_NOTES = 5


class _BitcodeForm(caching.CompileResultCacheImpl):
    _locator_classes = [_BitcodeLocator]  # noqa: RUF012

    def reduce(self, cres: Any) -> Any:
        (name, kind, (_, bitcode)), *rest = super().reduce(cres)
        # The notes on types are for reading, and have paths and addresses.
        rest[_NOTES] = ""
        return (name, kind, bitcode), *rest

    def rebuild(self, target_context: Any, payload: Any) -> Any:
        """Return the stored form of machine code for this processor."""
        (name, kind, bitcode), *rest = payload
        code = target_context.codegen()._tm.emit_object(llvm.parse_bitcode(bitcode))
        return (name, kind, (code, bitcode)), *rest


class _Bitcode(caching.FunctionCache):
    """Bitcode of a function: for one Python, numba and llvmlite, and for any processor of a kind."""

    _impl_class = _BitcodeForm

    def _index_key(self, sig: Any, codegen: Any) -> Any:
        whole, (triple, *_), code = super()._index_key(sig, codegen)
        return whole, (triple, llvmlite.__version__), code


class MachineCode(caching.FunctionCache):
    """Machine code of a function, which is made from bitcode where a wheel has it."""

    _impl_class = _MachineCodeForm

    def __init__(self, py_func: Callable[..., Any]) -> None:
        super().__init__(py_func)
        self._bitcode = _Bitcode(py_func)

    def load_overload(self, sig: Any, target_context: Any) -> Any:
        """Return the function for a signature, or None if it has to be compiled."""
        known = super().load_overload(sig, target_context)
        if known is None and not os.environ.get(WRITE_BITCODE):
            stored = self._bitcode.load_overload(sig, target_context)
            if stored is not None:
                self._impl.locator.ensure_cache_path()
                self._cache_file.save(self._index_key(sig, target_context.codegen()), stored)
                known = self._impl.rebuild(target_context, stored)
        return known

    def save_overload(self, sig: Any, data: Any) -> None:
        """Keep what the compiler has made."""
        super().save_overload(sig, data)
        if os.environ.get(WRITE_BITCODE):
            self._bitcode.save_overload(sig, data)
