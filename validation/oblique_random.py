"""Random oblique impacts of standard solids: how many fail, and whether one gains energy.

Run as `python validation/oblique_random.py --impacts 1000000 --out random`. The impacts go to stores of 10 000 in this
folder, each with a seed of its own. The same call goes on after an interrupt, and `--minutes` ends it: it then counts
the stores that are complete. It writes its numbers into `oblique_random.md` beside this file.
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
PAGE = """{impacts:,} random impacts of a rigid ball on a standard solid by `validation/oblique_random.py`, to
`rtol = 1e-4`: static Poisson ratio from -0.9 to 0.5, $p_2$ from $10^{{-3}}$ to 10, $p_3$ from $10^{{-3}}$ to 100,
friction from 0.03 to 3, angles from 0.02 to 1.5, spins from -3 to 3 of the velocity over the radius, gyration from 0.1
to 0.67.

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


def numbers(result: Any) -> dict[str, Any]:
    """Return the columns of a store that the page needs."""
    status = result.status.values
    good = status == rs.Status.SEPARATED
    energy = result.tangential_energy_in.values[good]
    return {
        "status": status,
        "e_t": result.tangential_restitution_coefficient.values[good],
        "over": result.impulse_ratio.values[good] / result.friction.values[good] - 1.0,
        "least": np.min([result[name].values[good] / energy for name in PARTS], axis=0),
        "residual": np.abs(result.tangential_energy_residual.values[good]),
        "error": result.tangential_error.values[good],
    }


def main() -> None:
    """Solve the impacts, and count."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--impacts", type=int, default=1_000_000)
    parser.add_argument("--out", type=Path, required=True)
    parser.add_argument("--workers", type=int)
    parser.add_argument("--minutes", type=float, default=float("inf"))
    options = parser.parse_args()
    options.out.mkdir(parents=True, exist_ok=True)
    ball = rs.Impact(rs.standard_solid(1.0, 1.0, 1.0, poisson_ratio=0.5), rs.Parabola(1.0), mass=1.0, velocity=1.0)
    begin, parts, columns = time.monotonic(), -(-options.impacts // PART), list[dict[str, Any]]()
    for part in range(parts):
        if time.monotonic() - begin > 60.0 * options.minutes:
            break
        columns.append(numbers(solve(ball, part, options.out, options.workers)))
    whole = {name: np.concatenate([each[name] for each in columns]) for name in columns[0]}
    status, residual = whole["status"], whole["residual"]
    counts = ", ".join(
        f"{rs.Status(int(code)).name} {np.count_nonzero(status == code):,}" for code in np.unique(status)
    )
    median, most, largest = np.quantile(residual, [0.5, 0.99, 1.0])
    page = PAGE.format(
        impacts=status.size, status=counts, low=whole["e_t"].min(), high=whole["e_t"].max(),
        gain=np.count_nonzero(np.abs(whole["e_t"]) > 1.0), over=whole["over"].max(), least=whole["least"].min(),
        median=median, most=most, largest=largest, open=np.count_nonzero(residual > 10.0 * RTOL),
        error=whole["error"].max() / RTOL,
    )  # fmt: skip
    print(f"\n{page}")
    Path(__file__).with_suffix(".md").write_text(page, encoding="utf-8")


if __name__ == "__main__":
    main()
