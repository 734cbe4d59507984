"""Random oblique impacts of standard solids, and of any others: how many fail, and whether one gains energy.

Run as `python validation/oblique_random.py --impacts 1000000 --out random`. The impacts go to stores of 10 000 in this
folder, each with a seed of its own. The same call goes on after an interrupt, and `--minutes` ends it: it then counts
the stores that are complete. It writes its numbers into `oblique_random.md` beside this file.

`python validation/oblique_random.py --relaxing 40000` draws solids whose bulk relaxes as well, and second bodies. It
takes some minutes, and writes into `oblique_relaxing.md`.
"""

from __future__ import annotations

import argparse
import time
import warnings
from pathlib import Path
from typing import Any

import numpy as np

import restitution as rs

RTOL = 1e-4
PART = 10_000
OUTPUTS = (
    "restitution_coefficient", "tangential_restitution_coefficient", "impulse_ratio", "tangential_energy_in",
    "tangential_energy_out", "friction_energy", "tangential_dissipated_energy", "tangential_stored_energy",
    "tangential_energy_residual", "tangential_error",
)  # fmt: skip
PARTS = OUTPUTS[5:8]
# Mass, radius, velocity and equilibrium modulus are 1.
DRAWN: dict[str, rs.Uniform | rs.LogUniform] = {
    "poisson_ratio": rs.Uniform(-0.9, 0.5), "p2": rs.LogUniform(1e-3, 10.0), "p3": rs.LogUniform(1e-3, 100.0),
    "friction": rs.LogUniform(0.03, 3.0), "angle": rs.Uniform(0.02, 1.5), "spin": rs.Uniform(-3.0, 3.0),
    "gyration": rs.Uniform(0.1, 0.67),
}  # fmt: skip
HEAD = """{impacts:,} random impacts of a rigid ball on a standard solid by `validation/oblique_random.py`, to
`rtol = 1e-4`: static Poisson ratio from -0.9 to 0.5, $p_2$ from $10^{{-3}}$ to 10, $p_3$ from $10^{{-3}}$ to 100,
friction from 0.03 to 3, angles from 0.02 to 1.5, spins from -3 to 3 of the velocity over the radius, gyration from 0.1
to 0.67.
"""
RELAXING = """{impacts:,} random impacts of a ball by `validation/oblique_random.py --relaxing`, to `rtol = 1e-4`: one
to three terms over 4.5 decades in shear, and the same in bulk for 70 % of the materials, so that $E^*/G^*$ rises or
falls with the age of a load; liquids; a second, unlike body for 40 %; friction from 0.03 to 3, and velocities along
the surface and spins from -3 to 3 of the normal velocity. Bodies that sink in are counted alone.
"""
TABLE = """
| | |
|---|---|
| status | {status} |
| $e_t$ | from {low:.6f} to {high:.6f} |
| impacts that gain energy, $\\lvert e_t\\rvert > 1$ | {gain} |
| impulse ratio above the friction coefficient by at most | {over:.1e} |
| least part of the energy (friction, material, stored) over that before | {least:.1e} |
| residual of the energy: median, 99 %, largest | {median:.1e}, {most:.1e}, {largest:.1e} |
| residuals above 10 rtol | {open} |
| largest stated error of $e_t$ over rtol | {error:.2f} |
"""


def solve(ball: rs.Impact, part: int, folder: Path, workers: int | None) -> Any:
    """Solve the impacts of one store, or what is left of them."""

    def progress(done: int, size: int) -> None:
        print(f"\r{part * PART + done} impacts", end="", flush=True)

    draws = {"draw": rs.Samples(PART, DRAWN, rng=7 + part)}
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", rs.RestitutionWarning)
        return rs.sweep(ball, draws, OUTPUTS, out=folder / f"{part:03d}.zarr", rtol=RTOL, workers=workers,
                        progress=progress).load()  # fmt: skip


def numbers(result: Any, friction: Any) -> dict[str, Any]:
    """Return the columns of outputs that a page needs."""
    columns = {name: np.asarray(result[name]) for name in (*OUTPUTS, "status")}
    status = columns["status"]
    good = status == rs.Status.SEPARATED
    energy = columns["tangential_energy_in"][good]
    return {
        "status": status,
        "e_t": columns["tangential_restitution_coefficient"][good],
        "over": columns["impulse_ratio"][good] / np.asarray(friction)[good] - 1.0,
        "least": np.min([columns[name][good] / energy for name in PARTS], axis=0),
        "residual": np.abs(columns["tangential_energy_residual"][good]),
        "error": columns["tangential_error"][good],
    }


def write(name: str, head: str, whole: dict[str, Any]) -> None:
    """Write a page beside this file."""
    status, residual = whole["status"], whole["residual"]
    counts = ", ".join(
        f"{rs.Status(int(code)).name} {np.count_nonzero(status == code):,}" for code in np.unique(status)
    )
    median, most, largest = np.quantile(residual, [0.5, 0.99, 1.0])
    gain = np.count_nonzero(np.abs(whole["e_t"]) > 1.0)
    page = head.format(impacts=status.size) + TABLE.format(
        status=counts, low=whole["e_t"].min(), high=whole["e_t"].max(), gain=gain,
        over=whole["over"].max(), least=whole["least"].min(), median=median, most=most, largest=largest,
        open=np.count_nonzero(residual > 10.0 * RTOL), error=whole["error"].max() / RTOL,
    )  # fmt: skip
    print(f"\n{page}")
    Path(__file__).with_name(name).write_text(page, encoding="utf-8")


def random_impact(random: np.random.Generator) -> rs.Impact:
    """Return an impact of a random solid, whose bulk may relax, with a second body or without."""

    def series(size: float) -> rs.PronySeries:
        count = random.integers(1, 4)
        equilibrium = size * 10.0 ** random.uniform(-1.0, 1.0) if random.random() < 0.85 else 0.0
        moduli, times = size * 10.0 ** random.uniform(-1.0, 1.0, count), 10.0 ** random.uniform(-3.0, 1.5, count)
        return rs.PronySeries(equilibrium, moduli, times)

    def material() -> rs.Material:
        bulk = 10.0 ** random.uniform(-0.5, 1.0)
        return rs.Material(series(1.0), bulk=series(2.0 * bulk) if random.random() < 0.7 else 3.0 * bulk)

    counter = material() if random.random() < 0.4 else None
    return rs.Impact(
        material(), rs.Parabola(1.0), mass=1.0, velocity=1.0, friction=10.0 ** random.uniform(-1.5, 0.5),
        tangential_velocity=random.uniform(-3.0, 3.0), spin=random.uniform(-3.0, 3.0),
        gyration=random.uniform(0.1, 0.67), counter_material=counter,
    )  # fmt: skip


def relaxing(impacts: int) -> dict[str, Any]:
    """Return the columns of random solids, solved one by one."""
    random, rows = np.random.default_rng(7), list[dict[str, float]]()
    for count in range(impacts):
        impact = random_impact(random)
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", rs.RestitutionWarning)
            result = rs.solve(impact, rtol=RTOL, errors="warn")
        row = {name: float(getattr(result, name)) for name in OUTPUTS}
        rows.append(row | {"status": float(result.status), "friction": float(np.asarray(impact.friction))})
        if count % 100 == 0:
            print(f"\r{count} impacts", end="", flush=True)
    whole = {name: np.array([row[name] for row in rows]) for name in rows[0]}
    return numbers(whole, whole["friction"])


def main() -> None:
    """Solve the impacts, and count."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--impacts", type=int, default=1_000_000)
    parser.add_argument("--out", type=Path)
    parser.add_argument("--workers", type=int)
    parser.add_argument("--minutes", type=float, default=float("inf"))
    parser.add_argument("--relaxing", type=int)
    options = parser.parse_args()
    if options.relaxing:
        write("oblique_relaxing.md", RELAXING, relaxing(options.relaxing))
        return
    if options.out is None:
        parser.error("--out FOLDER is where the stores go")
    options.out.mkdir(parents=True, exist_ok=True)
    ball = rs.Impact(rs.standard_solid(1.0, 1.0, 1.0, poisson_ratio=0.5), rs.Parabola(1.0), mass=1.0, velocity=1.0)
    begin, parts, columns = time.monotonic(), -(-options.impacts // PART), list[dict[str, Any]]()
    for part in range(parts):
        if time.monotonic() - begin > 60.0 * options.minutes:
            break
        result = solve(ball, part, options.out, options.workers)
        columns.append(numbers(result, result.friction))
    write("oblique_random.md", HEAD, {name: np.concatenate([each[name] for each in columns]) for name in columns[0]})


if __name__ == "__main__":
    main()
