"""Contact laws of random problems under random histories: forces, work, and the header in C under sanitizers.

Usage: python validation/law_random.py [--laws 200] [--steps 20000] [--seed 1]

A law has a random material (1 to 20 terms over twelve decades of time, some liquids, some with a parallel dashpot)
and a random profile. Its histories of depth are random walks, vibrations and white noise, with steps that differ by
decades. Every force must be finite and not negative, and a vibration must not return more work than it took. The
header is compiled with every compiler of C on this machine, all warnings as errors, with the address and
undefined-behaviour sanitizers, and must give the forces of Python to rounding.
"""

from __future__ import annotations

import argparse
import shutil
import subprocess
import tempfile
from collections import Counter, defaultdict
from pathlib import Path

import numpy as np
from rich.progress import track

import restitution as rs

FLAGS = ["-std=c99", "-pedantic", "-Wall", "-Wextra", "-Wshadow", "-Werror", "-O1", "-fsanitize=address,undefined"]
PROGRAM = """\
#include <stdio.h>
#include <stdlib.h>
#include "law.h"

int main(void)
{
    double *state = malloc(LAW_SIZE * sizeof *state), depth, dt;
    if (!state)
        return 1;
    law_start(state, 0.0);
    while (scanf("%lf %lf", &depth, &dt) == 2)
        printf("%.17g\\n", law_step(state, depth, dt));
    free(state);
    return 0;
}
"""


def random_material(rng: np.random.Generator) -> rs.Material:
    """Material of 1 to 20 terms, a tenth liquids, a fifth with a dashpot."""
    terms = int(rng.integers(1, 21))
    moduli, times = 10.0 ** rng.uniform(4.0, 9.0, terms), 10.0 ** rng.uniform(-9.0, 3.0, terms)
    rest = 0.0 if rng.random() < 0.1 else 10.0 ** rng.uniform(3.0, 8.0)
    dashpot = 10.0 ** rng.uniform(-1.0, 3.0) if rng.random() < 0.2 else 0.0
    series = rs.PronySeries(rest, moduli, times, parallel_viscosity=dashpot)
    return rs.Material(series, bulk=10.0 ** rng.uniform(7.0, 11.0))


def random_profile(rng: np.random.Generator):
    """One of six profiles, of the size of a bead."""
    radius = 10.0 ** rng.uniform(-4.0, -1.0)
    r = np.sort(rng.uniform(0.0, radius, 30))
    makers = {
        "Parabola": lambda: rs.Parabola(radius),
        "Cone": lambda: rs.Cone(rng.uniform(0.1, 1.5)),
        "PowerLaw": lambda: rs.PowerLaw(rng.uniform(0.6, 6.0), 1.0),
        "FlatPunch": lambda: rs.FlatPunch(radius),
        "TruncatedCone": lambda: rs.TruncatedCone(0.2 * radius, rng.uniform(0.3, 1.5)),
        "Tabulated": lambda: rs.Tabulated(np.append(0.0, r), np.append(0.0, r**2 / (2.0 * radius))),
    }
    return makers[str(rng.choice(list(makers)))]()


def history(
    rng: np.random.Generator, kind: str, size: float, time: float, steps: int
) -> tuple[np.ndarray, np.ndarray]:
    """Depths [m] up to `size`, and steps [s] about a hundredth of `time`."""
    dt = time / 100.0 * 10.0 ** rng.uniform(-2.0, 1.0, steps)
    if kind == "walk":
        depth = np.cumsum(rng.normal(size=steps))
    elif kind == "vibration":
        # Equal and short steps: the work is a sum of trapezoids, whose error would hide that of the law.
        dt = np.full(steps, time / 1000.0)
        phase = 2.0 * np.pi * np.cumsum(dt) / time
        depth = np.sin(phase[:, None] * [1.0, 2.7, 0.31] + rng.uniform(0.0, 6.0, 3)).sum(axis=1)
    else:
        depth = rng.normal(size=steps)
    depth = depth - np.quantile(depth, rng.uniform(0.1, 0.7))
    return size * depth / np.abs(depth).max(), dt


def c_forces(folder: Path, compiler: str, depth: np.ndarray, dt: np.ndarray) -> np.ndarray:
    """Forces [N] of the header in a folder; a warning or a finding of a sanitizer raises."""
    subprocess.run([compiler, *FLAGS, "main.c", "-o", "main", "-lm"], cwd=folder, check=True)
    lines = "".join(f"{x!r} {y!r}\n" for x, y in zip(depth.tolist(), dt.tolist(), strict=True))
    run = subprocess.run([folder / "main"], input=lines, capture_output=True, text=True, check=True)
    assert not run.stderr, run.stderr
    return np.array(run.stdout.split(), dtype=float)


def main(laws: int, steps: int, seed: int) -> str:
    rng = np.random.default_rng(seed)
    compilers = [name for name in ("gcc", "clang") if shutil.which(name)]
    counts: dict[str, Counter[str]] = defaultdict(Counter)
    difference, least, compiled = 0.0, 0.0, Counter[str]()
    for n in track(range(laws), description="Laws"):
        profile, material = random_profile(rng), random_material(rng)
        impact = rs.Impact(
            material, profile, mass=10.0 ** rng.uniform(-6.0, 0.0), velocity=10.0 ** rng.uniform(-2.0, 0.5)
        )
        try:
            solved = rs.solve(impact)
        except (rs.SolverError, rs.InputError):  # the body stays, or goes deeper than a table reaches
            solved = None
        if solved is None or not np.isfinite(solved.contact_time):
            counts["not solved"]["laws"] += 1
            continue
        law = rs.contact_law(impact)
        size = min(float(solved.max_indentation_depth), law.max_depth)
        for kind in ("walk", "vibration", "white noise"):
            depth, dt = history(rng, kind, size, float(solved.contact_time), steps)
            state = law.start()
            force = np.array([law.step(state, x, y) for x, y in zip(depth.tolist(), dt.tolist(), strict=True)])
            counts[kind]["histories"] += 1
            counts[kind]["forces"] += force.size
            counts[kind]["not finite"] += int((~np.isfinite(force)).sum())
            counts[kind]["negative"] += int((force < 0.0).sum())
            motion = np.diff(depth, prepend=0.0)
            mean = 0.5 * (force + np.append(0.0, force[:-1]))
            work = np.cumsum(mean * motion)
            if kind == "vibration":
                least = min(least, float(work.min() / max(work.max(), 1e-300)))
        if n % 5 == 0:
            with tempfile.TemporaryDirectory() as name:
                folder = Path(name)
                law.to_c(folder / "law.h", name="law")
                (folder / "main.c").write_text(PROGRAM)
                for compiler in compilers:
                    forces = c_forces(folder, compiler, depth, dt)
                    compiled[compiler] += 1
                    difference = max(difference, float(np.abs(forces - force).max() / force.max()))
    rows = "\n".join(
        f"| {kind} | {count['histories']} | {count['forces']:,} | {count['not finite']} | {count['negative']} |"
        for kind, count in counts.items()
        if kind != "not solved"
    )
    headers = (
        ", ".join(f"{number} with {name}" for name, number in compiled.items()) or "none, as no compiler is there"
    )
    return f"""\
# Contact laws of random problems

Made by `python validation/law_random.py --laws {laws} --steps {steps} --seed {seed}`. {laws} laws,
{counts["not solved"]["laws"]} of them left out because the body of their impact
stays, or goes deeper than a table of its profile.

| history | histories | forces | not finite | negative |
|---|---|---|---|---|
{rows}

Least work of the contact on the way of a vibration, over its largest (trapezoids over the steps): {least:.1e}.

Headers in C, compiled without a warning and run under the sanitizers for addresses and undefined behaviour: {headers}.
Largest difference from the forces of Python, over the largest force: {difference:.1e}.
"""


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--laws", type=int, default=200)
    parser.add_argument("--steps", type=int, default=20_000)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--out", type=Path, default=Path(__file__).with_suffix(".md"))
    arguments = parser.parse_args()
    text = main(arguments.laws, arguments.steps, arguments.seed)
    arguments.out.write_text(text, encoding="utf-8")
    print(text)
