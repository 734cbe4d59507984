"""Time of a step of the contact law with adhesion over that of the law without, in numba and in C.

Run as `python benchmarks/adhesive_law.py`; prints a table. It takes half a minute and needs a C compiler, `cc`. The
contact is a grain of a polymer that its wall attracts, with Maugis' parameter 2.5 and velocity Verlet.
"""

from __future__ import annotations

import shutil
import subprocess
import tempfile
import time
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import numba

import restitution as rs

POLYMER = rs.standard_solid(1e9, 1e9, 20.0, poisson_ratio=0.35)
GRAIN = rs.Impact(POLYMER, rs.Parabola(5e-6), mass=2.5e-12, velocity=0.3, adhesion=rs.Adhesion(0.05, stress=1e8))
ELEMENTS, STEPS, REPEATS = (20, 50, 100, 200), 100, 30

PROGRAM = """\
#include <stdio.h>
#include <time.h>
#include "law.h"

int main(void)
{
    double state[LAW_SIZE], least = 1e9;
    for (int repeat = 0; repeat < REPEATS; repeat++) {
        double depth = -LAW_RANGE, velocity = VELOCITY, force = 0.0;
        int steps = 0;
        law_start(state, depth);
        clock_t begin = clock();
        while (force != 0.0 || velocity > 0.0) {
            depth += velocity * STEP - 0.5 * force / MASS * STEP * STEP;
            double before = force;
            force = law_step(state, depth, STEP);
            velocity -= 0.5 * (before + force) / MASS * STEP;
            steps++;
        }
        least = fmin(least, (double)(clock() - begin) / CLOCKS_PER_SEC / steps);
    }
    printf("%.17g\\n", least);
    return 0;
}
"""


def in_numba(law: Any, depth: float, dt: float) -> tuple[float, float]:
    """Time [s] of a step, and e."""
    advance, mass, speed = law.compiled, float(GRAIN.mass), float(GRAIN.velocity)

    @numba.njit
    def thrown(state: Any, depth: float) -> tuple[float, int]:
        velocity, force, steps = speed, 0.0, 0
        while force != 0.0 or velocity > 0.0:
            depth += velocity * dt - 0.5 * force / mass * dt * dt
            before = force
            force = advance(state, depth, dt)
            velocity -= 0.5 * (before + force) / mass * dt
            steps += 1
        return -velocity / speed, steps

    return least(thrown, law, depth)


def least(thrown: Callable[[Any, float], tuple[float, int]], law: Any, depth: float) -> tuple[float, float]:
    """Least processor time [s] of a step, and e."""
    shortest, e = float("inf"), 0.0
    for _ in range(REPEATS):
        state = law.start()
        begin = time.process_time()
        e, steps = thrown(state, depth)
        shortest = min(shortest, (time.process_time() - begin) / steps)
    return shortest, e


def in_c(law: Any, dt: float) -> float:
    """Time [s] of a step of the header, by the compiler with -O2."""
    numbers = {"REPEATS": REPEATS, "STEP": dt, "MASS": float(GRAIN.mass), "VELOCITY": float(GRAIN.velocity)}
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        law.to_c(folder / "law.h", name="law")
        (folder / "main.c").write_text(PROGRAM)
        defined = [f"-D{key}={value!r}" for key, value in numbers.items()]
        subprocess.run(["cc", "-std=c99", "-O2", *defined, "main.c", "-o", "main", "-lm"], cwd=folder, check=True)
        return float(subprocess.run([folder / "main"], capture_output=True, text=True, check=True).stdout)


def main() -> str:
    """Return the table."""
    exact = rs.solve(GRAIN, rtol=1e-5)
    dt = float(exact.contact_time) / STEPS
    plain, _ = in_numba(rs.contact_law(replace(GRAIN, adhesion=None)), 0.0, dt)
    lines = [f"Law without adhesion: {1e9 * plain:.0f} ns a step in numba; {STEPS} steps in a contact.", ""]
    lines += ["| elements | numbers of a state | error of e | numba [ns] | C [ns] | numba over the law without |"]
    lines += ["|---|---|---|---|---|---|"]
    for elements in ELEMENTS:
        law = rs.contact_law(GRAIN, elements=elements)
        taken, e = in_numba(law, -float(GRAIN.adhesion.range), dt)
        c = f"{1e9 * in_c(law, dt):.0f}" if shutil.which("cc") else "no compiler"
        lines.append(
            f"| {elements} | {law.state_size} | {e - float(exact.restitution_coefficient):.1e} | {1e9 * taken:.0f} "
            f"| {c} | {taken / plain:.0f} |"
        )
    return "\n".join(lines)


if __name__ == "__main__":
    print(main())
