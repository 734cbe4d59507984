"""Cache of machine code: renewed after any edit, private to the user, and optional."""

import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

from restitution import RestitutionWarning, files

PACKAGE = Path(__file__).resolve().parents[2] / "src" / "restitution"
SOLVE = "import restitution as rs; print(repr(rs.standard_solid_restitution(0.3, 0.1, 1.0)))"


def _run(code: str, root: Path, **environment: str) -> str:
    variables = {key: value for key, value in os.environ.items() if not key.startswith("NUMBA_")}
    # Single solves are compiled, too.
    variables["NUMBA_DISABLE_JIT"] = "0"
    answer = subprocess.run(
        [sys.executable, "-c", code],
        env=variables | {"PYTHONPATH": str(root)} | environment,
        capture_output=True,
        text=True,
        timeout=300,
        check=False,
    )
    assert answer.returncode == 0, answer.stderr
    return answer.stdout


def _copy(root: Path) -> Path:
    shutil.copytree(PACKAGE, root / "restitution", ignore=shutil.ignore_patterns("__pycache__"))
    return root


def test_source_hash_depends_on_every_kernel_source(tmp_path):
    from restitution.kernel.cache import source_hash

    folder = _copy(tmp_path) / "restitution" / "kernel"
    for source in sorted(folder.glob("*.py")):
        before = source_hash.__wrapped__(folder)
        source.write_text(source.read_text() + "\n")
        assert source_hash.__wrapped__(folder) != before, source.name


def test_import_loads_nothing_heavy(tmp_path):
    code = "import sys, restitution; print({'scipy', 'numba', 'xarray', 'pint', 'matplotlib'} & set(sys.modules))"
    assert _run(code, PACKAGE.parent) == "set()\n"


WHOLE = """
from restitution.kernel.compile import entry_point
from restitution.kernel.part import half

@entry_point
def quarter(x):
    return half(half(x))
"""
PART = """
from restitution.kernel.compile import compiled

@compiled
def half(x):
    return 0.5 * x
"""


@pytest.mark.slow
def test_edit_of_a_callee_in_another_file_takes_effect(tmp_path: Path) -> None:
    # Two more modules of the kernel: its solver of impacts takes ten seconds and more, twice.
    root = _copy(tmp_path)
    kernel = root / "restitution" / "kernel"
    (kernel / "whole.py").write_text(WHOLE)
    (kernel / "part.py").write_text(PART)
    code = "from restitution.kernel.whole import quarter as q; print(q(1.0), sum(q.stats.cache_hits.values()))"
    assert [_run(code, root) for _ in range(2)] == ["0.25 0\n", "0.25 1\n"]
    (kernel / "part.py").write_text(PART.replace("0.5", "3.0"))
    assert [_run(code, root) for _ in range(2)] == ["9.0 0\n", "9.0 1\n"]


QUARTER = """
import llvmlite
llvmlite.__version__ += "VERSION"
from restitution.kernel.whole import quarter
# Where the cache has hits, the compiler was not called.
print(quarter(1.0), sum(quarter.stats.cache_hits.values()))
"""


@pytest.mark.slow
def test_bitcode_takes_the_place_of_the_compiler(tmp_path: Path) -> None:
    root = _copy(tmp_path)
    kernel, caches = root / "restitution" / "kernel", iter(range(9))
    (kernel / "whole.py").write_text(WHOLE)
    (kernel / "part.py").write_text(PART)

    def quarter(version: str = "", **environment: str) -> str:
        cache = tmp_path / f"cache{next(caches)}"
        answer = _run(QUARTER.replace("VERSION", version), root, NUMBA_CACHE_DIR=str(cache), **environment)
        # Machine code is kept in any case.
        assert list(cache.glob("*.nbc"))
        return answer

    assert quarter() == "0.25 0\n"
    assert quarter(RESTITUTION_BITCODE=str(kernel / "bitcode")) == "0.25 0\n"
    assert quarter() == "0.25 1\n"
    # Another processor, another LLVM, other sources.
    assert quarter(NUMBA_CPU_NAME="generic", NUMBA_CPU_FEATURES="") == "0.25 1\n"
    assert quarter(version="0") == "0.25 0\n"
    (kernel / "part.py").write_text(PART.replace("0.5", "3.0"))
    assert quarter() == "9.0 0\n"


@pytest.mark.slow
def test_the_kernel_runs_without_a_cache_folder(tmp_path):
    root = _copy(tmp_path)
    blocked = tmp_path / "file"
    blocked.write_text("")
    # Nobody, not even root, can create a folder below a plain file.
    answer = _run(SOLVE, root, NUMBA_CACHE_DIR=str(blocked / "cache"))
    assert float(answer) == pytest.approx(0.434356162547, rel=1e-9)


ROOM = """
import sys
from numba.core import event
from restitution.kernel.compile import compiled, entry_point

# Prints the size, in words, of the largest frame on the stack where the compiler starts.
class Listener(event.Listener):
    def on_start(self, _):
        frame, largest = sys._getframe(), 0
        while frame is not None:
            largest = max(largest, frame.f_code.co_stacksize)
            frame = frame.f_back
        print(largest)
    def on_end(self, _):
        pass

@compiled
def half(x):
    return 0.5 * x

@entry_point
def quarter(x):
    return half(half(x))

with event.install_listener("numba:compile", Listener()):
    assert quarter(2.0) == 0.5
"""


def test_the_compiler_runs_above_a_frame_of_32768_words(tmp_path):
    # CPython allocates a piece of stack of twice the size of such a frame; its usual pieces have 2048 words.
    assert _run(ROOM, PACKAGE.parent, NUMBA_CACHE_DIR=str(tmp_path)).split() == ["32768", "32768"]


WATCHED = """
import sys
from restitution.kernel.compile import entry_point

class Stream:
    def __init__(self, tty): self.tty, self.text = tty, ""
    def isatty(self): return self.tty
    def write(self, text): self.text += text
    def flush(self): pass

class Notebook(Stream): pass
Notebook.__module__ = "ipykernel.iostream"

@entry_point
def one(x): return x + 1.0

@entry_point
def two(x): return x + 2.0

sys.stderr = stream = STREAM
assert (one(1.0), two(1.0)) == (2.0, 3.0)
print(stream.text.replace("of each process, as no folder can keep the result,", "WITHOUT A CACHE"), end="")
"""


NOTE = "note: compiling, as the first impact and the first indentation {} do; each takes 10 to 40 s\n"


@pytest.mark.slow
def test_one_line_on_a_terminal_announces_the_compilation_of_a_process(tmp_path):
    # Only the functions of a file can be cached.
    script = tmp_path / "script.py"
    script.write_text(WATCHED.replace("STREAM", "Stream(True)"))
    code, cache = f"import runpy; runpy.run_path({str(script)!r})", str(tmp_path / "cache")
    assert _run(code, PACKAGE.parent, NUMBA_CACHE_DIR=cache) == NOTE.format("after an installation")
    assert _run(code, PACKAGE.parent, NUMBA_CACHE_DIR=cache) == ""


def test_a_notebook_has_the_line_too_and_learns_that_nothing_is_kept(tmp_path):
    (tmp_path / "file").write_text("")
    code, blocked = WATCHED.replace("STREAM", "Notebook(False)"), str(tmp_path / "file" / "cache")
    assert _run(code, PACKAGE.parent, NUMBA_CACHE_DIR=blocked) == NOTE.format("WITHOUT A CACHE")


def test_nobody_is_told_of_a_compilation_where_nobody_watches(tmp_path):
    code = WATCHED.replace("STREAM", "Stream(False)")
    assert _run(code, PACKAGE.parent, NUMBA_CACHE_DIR=str(tmp_path)) == ""


INTERRUPTED = """
import signal
import sys
from numba.core.codegen import CPUCodeLibrary
from restitution.kernel.compile import entry_point

# A shell that runs the tests in the background makes its children ignore the signal.
signal.signal(signal.SIGINT, signal.default_int_handler)
CPUCodeLibrary.HOOK = lambda *_: signal.raise_signal(signal.SIGINT)

@entry_point
def one(x): return x + 1.0

try:
    print(one(1.0))
except KeyboardInterrupt:
    print("interrupted", sys.unraisablehook is sys.__unraisablehook__)
"""


@pytest.mark.parametrize("hook", ["_object_compiled_hook", "_object_getbuffer_hook"])
def test_an_interrupt_in_a_callback_of_llvm_ends_the_compilation(tmp_path: Path, hook: str) -> None:
    # Python prints what a callback raises, and goes on: numba then misses the machine code or, from the other
    # callback, makes it nevertheless.
    script = tmp_path / "script.py"
    script.write_text(INTERRUPTED.replace("HOOK", hook))
    code = f"import runpy; runpy.run_path({str(script)!r})"
    assert _run(code, PACKAGE.parent, NUMBA_CACHE_DIR=str(tmp_path / "cache")) == "interrupted True\n"


FOLDER = "from restitution.kernel.cache import cache_folder; print(cache_folder())"


def test_a_folder_that_others_may_write_is_not_used(tmp_path: Path) -> None:
    root = _copy(tmp_path / "package")
    open_ = tmp_path / "open"
    open_.mkdir()
    open_.chmod(0o777)
    quiet = f"import warnings; warnings.simplefilter('ignore'); {FOLDER}"
    assert _run(quiet, root, NUMBA_CACHE_DIR=str(open_)) == "None\n"
    (root / "restitution" / "kernel" / "__pycache__").mkdir(exist_ok=True)
    (root / "restitution" / "kernel" / "__pycache__").chmod(0o775)
    answer = _run(FOLDER, root, XDG_CACHE_HOME=str(tmp_path / "cache"))
    assert answer == f"{tmp_path / 'cache' / 'restitution'}\n"
    assert (tmp_path / "cache" / "restitution").stat().st_mode & 0o777 == 0o700


def test_a_folder_of_another_user_is_not_used(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    from restitution.kernel import cache as module

    monkeypatch.setenv("NUMBA_CACHE_DIR", str(tmp_path))
    assert module.cache_folder.__wrapped__() == str(tmp_path)
    monkeypatch.setattr(os, "geteuid", lambda: tmp_path.stat().st_uid + 1)
    with pytest.warns(RestitutionWarning, match="others own it"):
        assert module.cache_folder.__wrapped__() is None


def test_a_relative_cache_home_is_ignored(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("HOME", str(tmp_path))
    monkeypatch.setenv("XDG_CACHE_HOME", "relative")
    assert files.user_cache() == tmp_path / ".cache" / "restitution"
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "absolute"))
    assert files.user_cache() == tmp_path / "absolute" / "restitution"


def test_no_cache_folder_without_a_home(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    from restitution.kernel import cache as module

    def no_home() -> Path:
        raise RuntimeError("Could not determine home directory.")

    monkeypatch.delenv("XDG_CACHE_HOME", raising=False)
    monkeypatch.delenv("NUMBA_CACHE_DIR", raising=False)
    monkeypatch.setattr(Path, "home", no_home)
    monkeypatch.setattr(module, "_is_mine_alone", lambda _: False)
    assert module.cache_folder.__wrapped__() is None


KNOWN = "from restitution.kernel.cache import has_machine_code as known; print({})"


@pytest.mark.slow
def test_machine_code_is_known_by_function_and_sources(tmp_path: Path) -> None:
    root, cache = _copy(tmp_path / "package"), str(tmp_path / "cache")
    both = KNOWN.format("known('material.tiny.half'), known('material.tiny.third'), known('kernel.tiny.half')")
    source = root / "restitution" / "material" / "tiny.py"
    source.write_text(
        "from restitution.kernel.compile import entry_point\n"
        "@entry_point\ndef half(x):\n    return 0.5 * x\n"
        "@entry_point\ndef third(x):\n    return x / 3.0\n"
    )
    assert _run(both, root, NUMBA_CACHE_DIR=cache) == "False False False\n"
    _run("from restitution.material.tiny import half; half(1.0)", root, NUMBA_CACHE_DIR=cache)
    assert _run(both, root, NUMBA_CACHE_DIR=cache) == "True False False\n"
    assert _run(KNOWN.format("'numba' in __import__('sys').modules"), root, NUMBA_CACHE_DIR=cache) == "False\n"
    source.write_text(source.read_text() + "\n")
    assert _run(both, root, NUMBA_CACHE_DIR=cache) == "False False False\n"


MANY = 40
CALL_MANY = f"""
import sys, time
from pathlib import Path
import functions

if len(sys.argv) > 1:
    Path(sys.argv[1]).touch()
    until = time.monotonic() + 60.0
    while not Path(sys.argv[2]).exists() and time.monotonic() < until:
        time.sleep(0.001)
called = [getattr(functions, f"multiply_{{n}}") for n in range({MANY})]
print([multiply(2.0) for multiply in called])
if len(sys.argv) == 1:
    print(sum(sum(multiply.stats.cache_hits.values()) for multiply in called))
"""


@pytest.mark.slow
def test_two_processes_compile_at_the_same_time(tmp_path: Path) -> None:
    # Both come to many small functions at almost the same moment, to the large ones of the kernel only once.
    (tmp_path / "functions.py").write_text(
        "from restitution.kernel.compile import entry_point\n"
        + "".join(f"@entry_point\ndef multiply_{n}(x):\n    return {n}.0 * x\n" for n in range(MANY))
    )
    cache, paths = str(tmp_path / "cache"), os.pathsep.join([str(PACKAGE.parent), str(tmp_path)])
    variables = {key: value for key, value in os.environ.items() if not key.startswith("NUMBA_")}
    variables |= {"NUMBA_CACHE_DIR": cache, "NUMBA_DISABLE_JIT": "0", "PYTHONPATH": paths}
    marks = [str(tmp_path / name) for name in ("first", "second")]
    processes = [
        subprocess.Popen(
            [sys.executable, "-c", CALL_MANY, *order],
            env=variables, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True,
        )
        for order in (marks, marks[::-1])
    ]  # fmt: skip
    ends = [process.communicate(timeout=300) for process in processes]
    products = f"{[2.0 * n for n in range(MANY)]}\n"
    assert [(process.returncode, end[0]) for process, end in zip(processes, ends, strict=True)] == [
        (0, products)
    ] * 2, ends
    assert _run(CALL_MANY, tmp_path, NUMBA_CACHE_DIR=cache, PYTHONPATH=paths) == f"{products}{MANY}\n"


STAGES = """
from restitution.kernel.compile import compiled, entry_point

@compiled
def half(x):
    return 0.5 * x

@entry_point
def quarter(x):
    return half(half(x))

print(quarter(1.0))
"""


@pytest.mark.slow
@pytest.mark.parametrize("level", ["0", "1", "max"])
def test_the_kernel_compiles_at_every_level_of_optimisation(tmp_path, level):
    # Without optimisation numba can cache no function that calls another, and warns.
    source = tmp_path / "stages.py"
    source.write_text(STAGES)
    folder = tmp_path / "cache"
    code = (
        f"import sys, warnings; warnings.simplefilter('error'); sys.path.insert(0, {str(tmp_path)!r}); import stages"
    )
    assert _run(code, PACKAGE.parent, NUMBA_OPT=level, NUMBA_CACHE_DIR=str(folder)) == "0.25\n"


@pytest.mark.slow
def test_a_solve_without_optimisation(tmp_path):
    assert float(_run(SOLVE, PACKAGE.parent, NUMBA_OPT="0", NUMBA_CACHE_DIR=str(tmp_path))) == pytest.approx(
        0.434356162547, rel=1e-9
    )


def test_constants_are_no_signatures_of_their_own():
    import numba

    from restitution.kernel.compile import compiled

    @compiled
    def add_to(number, total):
        return number + total

    @numba.njit
    def both(number):
        return add_to(1, number) + add_to(number, number)

    assert both(2) == 7
    assert [tuple(map(str, kinds)) for kinds in getattr(add_to, "signatures", [])] in ([("int64", "int64")], [])


LINKED = """
import sys
import numba
from numba.core import event, types
if sys.argv[1] == "other":
    numba.version_info = numba.version_info._replace(short=(99, 0))
from restitution.kernel.compile import compiled, entry_point, inlined

plain, is_numba_as_it_is = types.BaseFunction.get_call_type, True

class Listener(event.Listener):
    def on_start(self, _):
        global is_numba_as_it_is
        is_numba_as_it_is &= types.BaseFunction.get_call_type is plain
    def on_end(self, _):
        pass

@inlined
def half(x):
    return 0.5 * x

@compiled
def quarter(x):
    return half(half(x))

@compiled
def eighth(x):
    return half(quarter(x))

@entry_point
def both(x):
    return eighth(x) + quarter(x)

@entry_point
def sixteenth(x):
    return half(eighth(x))

@numba.njit
def of_a_user(x):
    return eighth(x) + both(x)

with event.install_listener("numba:compile", Listener()):
    numbers = both(8.0), sixteenth(8.0), of_a_user(8.0)
assert types.BaseFunction.get_call_type is plain
print(*numbers, sum(both.stats.cache_hits.values()), is_numba_as_it_is)
"""


@pytest.mark.slow
@pytest.mark.parametrize(
    ("version", "cached"),
    [("tried", ["both", "sixteenth"]), ("other", ["both", "eighth", "quarter", "sixteenth"])],
)
def test_stages_are_linked_into_entry_points(tmp_path: Path, version: str, cached: list[str]) -> None:
    # Of a version of numba that was not tried, only the documented interface is used. Functions of users may call
    # stages in both ways.
    script, cache = tmp_path / "script.py", tmp_path / "cache"
    script.write_text(LINKED)
    code = f"import runpy, sys; sys.argv = ['', {version!r}]; runpy.run_path({str(script)!r})"
    alone = version == "other"
    for hits in (0, 1):
        assert _run(code, PACKAGE.parent, NUMBA_CACHE_DIR=str(cache)) == f"3.0 0.5 4.0 {hits} {alone or hits > 0}\n"
        for kind in ("nbi", "nbc"):
            names = [path.name.split("-")[0] for path in cache.glob(f"*.{kind}")]
            assert sorted(names) == [f"script.{name}" for name in cached]
