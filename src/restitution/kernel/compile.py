"""Compilation of the kernel, and the cache of its machine code."""

import gc
import sys
from collections.abc import Callable, Generator
from contextlib import contextmanager
from threading import current_thread, main_thread
from typing import Any

import llvmlite.binding as llvm
import numba
import numpy as np
from numba.core import codegen, compiler, config, event, targetconfig, typed_passes, types, untyped_passes
from numba.core.compiler_lock import global_compiler_lock

from restitution.kernel.cache import cache_folder
from restitution.kernel.plain import with_plain_calls
from restitution.kernel.storage import MachineCode

# Without reference counts (`_nrt`) an impact costs 37 -> 30 us; the kernel therefore allocates nothing.
# Only `contract`: full fastmath removes the NaN checks on which the status codes depend and is no faster.
_FLAGS: dict[str, Any] = {"_nrt": False, "nogil": True, "fastmath": {"contract"}, "error_model": "numpy"}


class _Part(codegen.JITCodeLibrary):
    """Code of a function that only the kernel calls: entry points optimise it, and make its machine code.

    Numba would do both at each level of calls, each time with all that is called below.
    """

    def _optimize_final_module(self) -> None:
        pass

    def _finalize_final_module(self) -> None:
        self._finalized = True

    def get_pointer_to_function(self, name: str) -> int:
        self._ensure_finalized()
        return 0

    @property
    def codegen(self) -> Any:
        return _NoEnvironment


class _NoEnvironment:
    """Place for the Python objects of a function, which a function without machine code does not need."""

    @staticmethod
    def set_env(*_: Any) -> None:
        pass


# Passes of numba for closures and for expressions of whole arrays; the kernel contains no such thing.
_NEEDLESS = (untyped_passes.InlineClosureLikes, typed_passes.InlineOverloads, typed_passes.NopythonRewrites)


class _Whole(codegen.JITCodeLibrary):
    """Code of an entry point. Nobody else calls its parts, so that LLVM may change what they are handed.

    Numba passes a named tuple as some hundred numbers, in each call. LLVM leaves out what a part does not use.
    """

    def _optimize_final_module(self) -> None:
        for function in self._final_module.functions:
            if not function.is_declaration and function.linkage == llvm.Linkage.linkonce_odr:
                function.linkage = "internal"
        super()._optimize_final_module()


class _WholeCompiler(compiler.Compiler):
    def __init__(self, typingctx: Any, targetctx: Any, library: Any, *arguments: Any) -> None:
        if library is None:
            library = _Whole(targetctx.codegen(), "entry point")
            library.enable_object_caching()
        super().__init__(typingctx, targetctx, library, *arguments)


class _PartCompiler(compiler.Compiler):
    def __init__(self, typingctx: Any, targetctx: Any, library: Any, *arguments: Any) -> None:
        part = _Part(targetctx.codegen(), "part") if library is None else library
        super().__init__(typingctx, targetctx, part, *arguments)

    def define_pipelines(self) -> list[Any]:
        pipelines = super().define_pipelines()
        for steps in pipelines:
            steps.passes = [step for step in steps.passes if step[0] not in _NEEDLESS]
        return pipelines


# Versions of numba with which parts were tried. Others make machine code of each function.
_FIRST, _BEYOND = (0, 61), (0, 69)
_PARTS: dict[str, Any] = {"pipeline_class": _PartCompiler} if _FIRST <= numba.version_info.short < _BEYOND else {}
_WHOLE: dict[str, Any] = {"pipeline_class": _WholeCompiler} if _PARTS else {}
_INNER: dict[str, Any] = {"no_cpython_wrapper": True, "no_cfunc_wrapper": True} | _PARTS


@contextmanager
def _known_operations() -> Generator[None]:
    """Find the types of each operation once, with the versions of numba with which this was tried.

    Numba tries all versions of an operator again at each place where it stands, those for text, sets and dates first.
    It keeps none of the answers and has no setting, and a compiler of its own class is not asked: the types of
    operations stand in tables that all compilers of a process share. So their common class answers from here while
    the kernel is compiled, under the lock of all compilers, and as before for anyone afterwards.
    """
    if not _PARTS:
        yield
        return
    plain, known = types.BaseFunction.get_call_type, {}

    def get_call_type(self: Any, context: Any, arguments: Any, named: Any) -> Any:
        if named:
            return plain(self, context, arguments, named)
        # The code of a few operations depends on how the function is compiled in which they stand.
        flags = targetconfig.ConfigStack.top_or_none()
        key = id(self), context, arguments, flags is not None and flags.forceinline
        if key not in known:
            known[key] = self, plain(self, context, arguments, named)
        return known[key][1]

    with global_compiler_lock:
        types.BaseFunction.get_call_type = get_call_type
        try:
            yield
        finally:
            types.BaseFunction.get_call_type = plain


# Size of a frame in words, half of the piece of memory that CPython allocates for it.
_ROOM = 2**15


def _with_room(function: Callable[..., Any]) -> Callable[..., Any]:
    """Wrap a function such that all frames of its calls lie in one large piece of memory, without garbage collection.

    CPython stores frames in pieces of 16 kB. If a call that numba makes a million times crosses the end of a piece,
    each call allocates and frees one: compilation takes 10 to 16 s, depending on the depth of the call stack. The
    search for garbage among the objects of the compiler takes 2 s more.
    """

    def call(*arguments: Any, **named: Any) -> Any:
        collects = gc.isenabled()
        gc.disable()
        try:
            with _known_operations():
                return function(*arguments, **named)
        finally:
            if collects:
                gc.enable()

    call.__code__ = call.__code__.replace(co_stacksize=_ROOM)
    return call


def write_note(text: str) -> None:
    """Write a note on standard error; the command line replaces this by its own form of notes."""
    print(f"note: {text}", file=sys.stderr, flush=True)


class _Announcement(event.Listener):
    """A note at the first compilation of a process, where somebody reads it: on a terminal or in a notebook."""

    is_written = False

    def on_start(self, event: Any) -> None:
        # Windows has no standard error where there is no console.
        watched = getattr(sys.stderr, "isatty", bool)() or type(sys.stderr).__module__ == "ipykernel.iostream"
        if watched and not self.is_written:
            self.is_written = True
            when = "after an installation" if cache_folder() else "of each process, as no folder can keep the result,"
            write_note(f"compiling, as the first impact and the first indentation {when} do; each takes 10 to 40 s")

    def on_end(self, event: Any) -> None:
        pass


_announcement = _Announcement()


def _announced(function: Callable[..., Any]) -> Callable[..., Any]:
    def call(*arguments: Any, **named: Any) -> Any:
        # Numba has this event only where the cache has no machine code.
        with event.install_listener("numba:compile", _announcement):
            return function(*arguments, **named)

    return call


@contextmanager
def _interruptible() -> Generator[None]:
    """Let Ctrl-C end the block also within a callback of LLVM.

    Python only prints what a callback raises. The compiler then goes on, or stops later for want of the result.
    """
    if current_thread() is not main_thread():
        # Only the main thread hears of Ctrl-C.
        yield
        return
    is_interrupted, show = False, sys.unraisablehook

    def hear(lost: Any) -> None:
        nonlocal is_interrupted
        if issubclass(lost.exc_type, KeyboardInterrupt):
            is_interrupted = True
        else:
            show(lost)

    sys.unraisablehook = hear
    try:
        yield
    except Exception:
        if not is_interrupted:
            raise
    finally:
        sys.unraisablehook = show
    if is_interrupted:
        raise KeyboardInterrupt


def entry_point(function: Callable[..., Any]) -> Any:
    """Compile an entry point of the kernel on its first call, and cache its machine code if possible."""
    if config.DISABLE_JIT:
        # An iteration that diverges leaves the range of a double before it is given up; machine code does not warn.
        return np.errstate(over="ignore", invalid="ignore")(function)
    dispatcher: Any = cached(numba.njit(**_WHOLE, **_FLAGS)(function), function)
    # Numba calls this for new types of arguments.
    compile_for = _with_room(_interruptible()(_announced(dispatcher._compile_for_args)))
    dispatcher._compile_for_args = with_plain_calls(dispatcher, compile_for)
    return dispatcher


def compiled(function: Callable[..., Any]) -> Any:
    """Compile a stage of an impact, which only the kernel calls, as a separate function.

    One large function takes twice as long to compile.
    """
    # Stated, since numba hands `forceinline` down from a caller to what it compiles for it.
    dispatcher = numba.njit(forceinline=False, **_INNER, **_FLAGS)(function)
    if not _PARTS:
        dispatcher = cached(dispatcher, function)
    return dispatcher if config.DISABLE_JIT else _without_literals(dispatcher)


def _without_literals(dispatcher: Any) -> Any:
    """Compile a function once for all integers and booleans; numba has a signature of its own for each constant."""
    template = dispatcher.get_call_template
    dispatcher.get_call_template = lambda arguments, named: template(
        tuple(types.unliteral(kind) for kind in arguments), {key: types.unliteral(kind) for key, kind in named.items()}
    )
    return dispatcher


def machine_code_is_kept() -> bool:
    """Return whether functions are compiled, and the cache keeps what the compiler makes."""
    return not config.DISABLE_JIT and config.OPT > 0 and cache_folder() is not None


def cached(dispatcher: Any, function: Callable[..., Any]) -> Any:
    """Cache the machine code of a compiled function until a source in its folder changes.

    Without optimisation (`NUMBA_OPT=0`), addresses of this process stay in the code, and nothing can be cached.
    """
    if machine_code_is_kept():
        dispatcher._cache = MachineCode(function)
    return dispatcher


def inlined(function: Callable[..., Any]) -> Any:
    """Compile a piece of the kernel into its callers, where the sizes that they pass are constants."""
    dispatcher = numba.njit(forceinline=True, **_INNER, **_FLAGS)(function)
    return dispatcher if config.DISABLE_JIT else _without_literals(dispatcher)
