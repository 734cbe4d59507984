"""The command `warm-up`: every entry point of the kernel is compiled by a small problem."""

from __future__ import annotations

import os
import subprocess
import sys
import warnings
from collections.abc import Callable, Generator
from contextlib import contextmanager
from typing import TYPE_CHECKING

import restitution as rs
from restitution.cli import terminal as cli

if TYPE_CHECKING:
    from restitution.contact.geometry import Geometry


def warm_up() -> None:
    """Compile the whole kernel, so that no later command and no Python process waits for it.

    A minute after an installation or an update, half of it on two processors; seconds if it is compiled.
    Example: restitution warm-up
    """
    from restitution.kernel.cache import cache_folder
    from restitution.kernel.compile import machine_code_is_kept

    folder = cache_folder()
    if folder is None:
        raise cli.BadInput("no folder can keep machine code; set NUMBA_CACHE_DIR to one that only you may write")
    if not machine_code_is_kept():
        raise cli.BadInput("NUMBA_DISABLE_JIT or NUMBA_OPT = 0 is set, with which no machine code is kept")
    total, done = sum(PROBLEMS.values()), 0
    with cli.progress_bar("compiling", begin="compiling") as progress, _beside() as other:
        progress(0, total)
        for problem, share in PROBLEMS.items():
            solve([problem])
            if other and not done:
                # What it has compiled is only loaded here, and what it could not is compiled.
                other.wait()
            done += share
            progress(done, total)
    print(f"the kernel is compiled; its machine code is in {folder}")


def solve(problems: list[Callable[[], None]]) -> None:
    """Solve problems, compiled."""
    from restitution.kernel.plain import compiled_only

    # The problems are small, not physical.
    with warnings.catch_warnings(), compiled_only():
        warnings.simplefilter("ignore", rs.RestitutionWarning)
        for problem in problems:
            problem()


@contextmanager
def _beside() -> Generator[subprocess.Popen[bytes] | None]:
    """Let another process solve what has few functions in common with the first problem, if there is a processor."""
    if (os.cpu_count() or 1) < 2:
        yield None
        return
    nothing = subprocess.DEVNULL
    with subprocess.Popen(
        [sys.executable, "-P", "-c", CODE_BESIDE], stdin=nothing, stdout=nothing, stderr=nothing
    ) as other:
        try:
            yield other
        finally:
            other.terminate()


def _ball(profile: Geometry | None = None) -> rs.Impact:
    rubber = rs.standard_solid(1e6, 1e7, 1e3, poisson_ratio=0.45)
    return rs.Impact(rubber, profile or rs.Parabola(radius=0.01), mass=0.005, velocity=1.0)


def _impacts() -> None:
    import numpy as np

    from restitution.impact.batch import Batch

    result = rs.solve(_ball())
    result.to_dict()
    _ = result.history
    for friction in (0.3, np.inf):
        rs.solve(rs.vary(_ball(), {"friction": friction, "tangential_velocity": 1.0}), rtol=1e-3)
    Batch.from_impact(_ball()).sample_forces(np.array([0.0, 1e-4]), 1e-6)


def _geometries() -> None:
    import numpy as np

    radii, sphere = np.linspace(0.0, 0.01, 7), rs.Sphere(radius=0.01)
    rs.solve(_ball(rs.Tabulated(radii, 50.0 * radii**2)))
    for thickness in (0.004, np.linspace(0.004, 0.006, 9)):
        rs.solve(_ball(rs.Layer(sphere, thickness=thickness)))


def _gel_and_tip() -> tuple[rs.Material, rs.Parabola]:
    return rs.Material(rs.PronySeries(60.0, [250.0], [0.3]), bulk=float("inf")), rs.Parabola(radius=2.5e-6)


def _indentations() -> None:
    import numpy as np

    from restitution.indentation.records import Record, RecordBlock

    gel, tip = _gel_and_tip()
    rs.indent(gel, tip, depth=rs.triangle(1e-6, 1.0)).sample()
    rs.indent(gel, tip, depth=[0.0, 1e-6, -2e-7, -1.9e-7], time=[0.0, 1.0, 2.0, 3.0])
    creep = rs.indent(gel, tip, force=rs.History.from_points([0.0, 0.0, 1.0, 2.0], [0.0, 1e-9, 1e-9, 0.0]))
    creep.to_dict()
    rs.oscillate(gel, tip, depth=1e-6, amplitude=1e-7, frequency=1.0)
    block = RecordBlock(tip, [Record(np.linspace(0.0, 1.0, 20), np.linspace(-1e-7, 1e-6, 20))], 1e-6)
    block.forces(rs.PronySeries([60.0], [[250.0]], [[0.3]]), np.zeros(1))


def _histories() -> None:
    gel, tip = _gel_and_tip()
    surface = None
    # Each contact leaves panels until they are so many that they are merged.
    for share in (1.0, 0.9, 0.8, 0.7):
        history = rs.cycles(share * 1e-6, 1.0, 2, valley=2e-7)
        surface = rs.indent(gel, tip, depth=history, surface=surface).surface(after=0.01)
    rs.solve(_ball(), surface=rs.solve(_ball()).surface())
    polymer = rs.standard_solid(2e6, 8e6, 1e3, poisson_ratio=0.5)
    rs.tap(
        polymer, rs.Parabola(radius=1e-8), 4e-8, free_amplitude=5e-8, quality_factor=3.0, spring_constant=5.0,
        frequency=5e4, max_taps=12, rtol=1e-4,
    )  # fmt: skip


def _attractions() -> None:
    import numpy as np

    from restitution.indentation.attraction import Program, sticky

    gel, tip = _gel_and_tip()
    attraction = rs.Adhesion(work=1e-4, range=1e-7)
    body = sticky(rs.Impact(gel, tip, mass=1e-12, velocity=1e-3).contact, attraction)
    body.march(3e-6, 1e-2, 8, mass=1e-12, velocity=1e-3)
    body.follow(3e-6, Program(np.array([0.0, 1.0]), np.array([0.0, 3e-7])), 8)


def _laws() -> None:
    law = rs.contact_law(_ball())
    law.step(law.start(), 1e-6, 1e-6)
    rough = rs.contact_law(_ball(), friction=0.3)
    rough.step(rough.start(), 1e-6, 1e-6, way=0.0)
    gel, tip = _gel_and_tip()
    attraction = rs.Adhesion(work=1e-4, range=1e-7)
    sticky = rs.contact_law(rs.Impact(gel, tip, mass=1e-12, velocity=1e-3, adhesion=attraction), elements=10)
    sticky.step(sticky.start(), 0.0, 1e-6)
    rs.standard_solid_surrogate(0.3, 0.1, 1.0)
    rs.surrogate(_ball(), velocity=(0.5, 1.0), rtol=1e-3)(0.7)


PROBLEMS: dict[Callable[[], None], int] = {
    _indentations: 28, _impacts: 15, _geometries: 7, _histories: 2, _attractions: 6, _laws: 9,
}  # fmt: skip
"""Problems that call all entry points, with shares of the time."""

BESIDE: list[Callable[[], None]] = [_impacts, _geometries, _attractions, _laws]
"""Problems for a process beside the one that solves the first, which takes nearly half of the time."""

CODE_BESIDE = "from restitution.cli import warm_up; warm_up.solve(warm_up.BESIDE)"
"""Code of that process."""
