"""Random oblique impacts of standard solids: how many fail, and whether one gains energy.

Run as `python validation/oblique_random.py --impacts 20000 --out random.zarr`. The impacts go to a store, from which
the same call resumes after an interrupt. It prints what `oblique_random.md` beside this file has.
"""

from __future__ import annotations

import argparse
import time
import warnings
from pathlib import Path

import numpy as np

import restitution as rs

RTOL = 1e-4
OUTPUTS = (
    "restitution_coefficient", "tangential_restitution_coefficient", "impulse_ratio", "tangential_energy_in",
    "tangential_energy_out", "friction_energy", "tangential_dissipated_energy", "tangential_stored_energy",
    "tangential_energy_residual",
)  # fmt: skip
PARTS = OUTPUTS[5:8]
# Mass, radius, velocity and equilibrium modulus are 1.
DRAWN: dict[str, rs.Uniform | rs.LogUniform] = {
    "poisson_ratio": rs.Uniform(-0.9, 0.5), "p2": rs.LogUniform(1e-3, 10.0), "p3": rs.LogUniform(1e-3, 100.0),
    "friction": rs.LogUniform(0.03, 3.0), "angle": rs.Uniform(0.02, 1.5), "spin": rs.Uniform(-3.0, 3.0),
    "gyration": rs.Uniform(0.1, 0.67),
}  # fmt: skip


def main() -> None:
    """Solve the impacts, and count."""
    parser = argparse.ArgumentParser()
    parser.add_argument("--impacts", type=int, default=20_000)
    parser.add_argument("--out", type=Path, required=True)
    parser.add_argument("--workers", type=int)
    options = parser.parse_args()
    ball = rs.Impact(rs.standard_solid(1.0, 1.0, 1.0, poisson_ratio=0.5), rs.Parabola(1.0), mass=1.0, velocity=1.0)
    start, before = (time.perf_counter(), time.process_time()), list[int]()

    def progress(done: int, size: int) -> None:
        before.append(done) if not before else None
        print(f"\r{done} of {size}", end="", flush=True)

    with warnings.catch_warnings():
        warnings.simplefilter("ignore", rs.RestitutionWarning)
        found = rs.sweep(ball, {"draw": rs.Samples(options.impacts, DRAWN, seed=7)}, OUTPUTS, out=options.out,
                         rtol=RTOL, workers=options.workers, progress=progress).load()  # fmt: skip
    wall, processor = time.perf_counter() - start[0], time.process_time() - start[1]
    solved = options.impacts - before[0]
    status = found.status.values
    good = status == rs.Status.SEPARATED
    e_t, ratio = found.tangential_restitution_coefficient.values[good], found.impulse_ratio.values[good]
    energy = found.tangential_energy_in.values[good]
    least = min(float(np.min(found[name].values[good] / energy)) for name in PARTS)
    residual = np.abs(found.tangential_energy_residual.values[good])
    shares = np.quantile(residual, [0.5, 0.99, 1.0])
    print(f"\n{solved} impacts in {wall:.0f} s, {processor:.0f} s of processor time: "
          f"{1e3 * processor / max(solved, 1):.2f} ms each")  # fmt: skip
    print({rs.Status(int(code)).name: int(np.count_nonzero(status == code)) for code in np.unique(status)})
    print(f"e_t from {e_t.min():.6f} to {e_t.max():.6f}; above 1 or below -1: {np.count_nonzero(np.abs(e_t) > 1.0)}")
    print(f"impulse ratio above friction by at most {np.max(ratio / found.friction.values[good]) - 1.0:.1e}")
    print(f"least part of the energy {least:.1e}; residual: median {shares[0]:.1e}, 99 % {shares[1]:.1e}, "
          f"largest {shares[2]:.1e}")  # fmt: skip


if __name__ == "__main__":
    main()
