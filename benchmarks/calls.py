"""Python calls of the package for one impact, one sweep and one fit, and the functions that a number passes.

    python benchmarks/calls.py

Calls of a second run count, in which nothing is imported or compiled. They do not depend on the load of the machine;
the time of one `solve` is the shortest of 50. Comprehensions and generators are parts of their function. A function
holds a number if a variable of it, or an array or a list in a variable, has this number, or a text with it, before the
kernel is called first.
"""

from __future__ import annotations

import sys
import tempfile
import time
from collections import Counter
from collections.abc import Callable, Generator
from contextlib import contextmanager
from pathlib import Path
from types import CodeType, FrameType
from typing import Any

import numpy as np
from numba.core.dispatcher import Dispatcher

import restitution as rs
from restitution.case.impact import read_case

EXAMPLES = Path(__file__).resolve().parents[1] / "examples"
PACKAGE = str(Path(rs.__file__).parent)
KERNEL = str(Path(PACKAGE) / "kernel")
MARKER = 1.2345678901
_PARTS = "<genexpr>", "<listcomp>", "<dictcomp>", "<setcomp>"

CASE = """
[body]
mass = "5 g"
[profile]
type = "parabola"
radius = "1 cm"
[material]
model = "generalised_maxwell"
equilibrium_modulus = "1 MPa"
branch_moduli = "[10, 3] MPa"
relaxation_times = "[%s, 100] ms"
poisson_ratio = 0.45
[impact]
velocity = "%s m/s"
"""


def calls(work: Callable[[], Any]) -> tuple[Counter[CodeType], int]:
    """Calls by code of the package outside the kernel, and the number of all, of the second run of `work`."""
    work()
    result: Counter[CodeType] = Counter()

    def note(frame: FrameType, event: str, _: object) -> None:
        if event == "call" and frame.f_code.co_name not in _PARTS:
            result[frame.f_code] += 1

    sys.setprofile(note)
    try:
        work()
    finally:
        sys.setprofile(None)
    return Counter({code: n for code, n in result.items() if is_outside(code)}), result.total()


def is_outside(code: CodeType) -> bool:
    """Whether code belongs to the package and not to its kernel."""
    return code.co_filename.startswith(PACKAGE) and not code.co_filename.startswith(KERNEL)


@contextmanager
def kernel_calls() -> Generator[list[str]]:
    """Names of the compiled functions that Python calls meanwhile; `solve_block` is one impact or an array of them."""
    names: list[str] = []
    places = [
        (module, name, value)
        for key, module in list(sys.modules.items())
        if key.startswith("restitution")
        for name, value in vars(module).items()
        if isinstance(value, Dispatcher)
    ]

    def counted(function: Any, name: str) -> Callable[..., Any]:
        def call(*arguments: Any, **named: Any) -> Any:
            names.append(name)
            return function(*arguments, **named)

        return call

    for module, name, function in places:
        setattr(module, name, counted(function, name))
    try:
        yield names
    finally:
        for module, name, function in places:
            setattr(module, name, function)


def _is_marked(value: Any, depth: int = 2) -> bool:
    if isinstance(value, str):
        return str(MARKER) in value
    if isinstance(value, float | np.floating):
        return f"{value:.10e}".startswith(str(MARKER))
    if isinstance(value, np.ndarray) and value.dtype == np.float64:
        return value.size < 1000 and any(_is_marked(number) for number in value.ravel().tolist())
    if isinstance(value, dict):
        value = list(value.values())
    return depth > 0 and isinstance(value, list | tuple) and any(_is_marked(part, depth - 1) for part in value)


def holders(work: Callable[[], Any]) -> list[str]:
    """Functions that hold the marker on its way to the first call of the kernel, in the order of their ends."""
    import restitution.kernel.impact as kernel

    work()
    results: dict[str, None] = {}

    def note(frame: FrameType, event: str, _: object) -> None:
        code = frame.f_code
        if event == "return" and is_outside(code) and any(map(_is_marked, frame.f_locals.values())):
            module = str(Path(code.co_filename).relative_to(PACKAGE).with_suffix(""))
            results[f"{module}: {code.co_qualname.split('.<locals>')[0]}"] = None

    def arrive(*_: object) -> None:
        raise KeyboardInterrupt

    solve_block, kernel.solve_block = kernel.solve_block, arrive
    sys.setprofile(note)
    try:
        work()
    except KeyboardInterrupt:
        pass
    finally:
        sys.setprofile(None)
        kernel.solve_block = solve_block
    return list(results)


def answer(file: Path) -> tuple[Any, ...]:
    """All numbers of the impact of a case file: the walk that the counts are about."""
    result = read_case(file).solve()
    return result.outputs, result.validity


def table(file: Path) -> str:
    """The table that `restitution solve` prints."""
    result = read_case(file).solve()
    return str(result.summary())


def sweep() -> Any:
    """Twenty velocities in memory."""
    ball = read_case(EXAMPLES / "rubber_ball.toml").impact
    return rs.sweep(ball, {"velocity": np.geomspace(0.1, 10.0, 20)})


def fit() -> Any:
    """Identify the example of three balls."""
    from restitution.case.identification import read_identification

    return read_identification(EXAMPLES / "identification" / "balls.toml").solve()


def main() -> None:
    """Print the numbers."""
    ball, plate = EXAMPLES / "rubber_ball.toml", EXAMPLES / "coated_plate.toml"
    works: dict[str, Callable[[], Any]] = {
        "read_case, solve, outputs, validity": lambda: answer(ball),
        "the same with the table": lambda: table(ball),
        "an impact on a layer": lambda: answer(plate),
        "a sweep of 20 velocities": sweep,
        "a fit": fit,
    }
    for name, work in works.items():
        package, total = calls(work)
        with kernel_calls() as kernel:
            work()
        counts = f"{package.total()} calls of {len(package)} functions of the package, {total} of all libraries"
        print(f"{name}: {counts}; {len(kernel)} of the kernel ({package.total() / len(kernel):.0f} for each)")
        if "--most" in sys.argv:
            for code, n in package.most_common(25):
                print(f"    {n:5d} {Path(code.co_filename).relative_to(PACKAGE)}: {code.co_qualname}")
    impact = read_case(ball).impact
    print(f"rs.solve of an impact: {shortest(lambda: rs.solve(impact)) * 1e3:.2f} ms")
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder) / "case.toml"
        for name, numbers in {"velocity": ("4", MARKER), "relaxation time": (MARKER, "4")}.items():
            file.write_text(CASE % numbers, encoding="utf-8")
            result = holders(lambda: read_case(file).solve())
            print(f"{name}: held by {len(result)} functions", *result, sep="\n    ")


def shortest(work: Callable[[], Any], repeats: int = 50) -> float:
    """Shortest time [s] of several calls."""
    times = []
    for _ in range(repeats):
        start = time.perf_counter()
        work()
        times.append(time.perf_counter() - start)
    return min(times)


if __name__ == "__main__":
    main()
