"""Tapping on polyisobutylene beside a published simulation, whose law holds on the approach only.

The published numbers are those of https://github.com/ealopez/TappingMode_Simulations (MIT licence, E. A. Lopez-Guerra
2017, doi:10.5281/zenodo.1087460), which M. Nikfarjam et al., Beilstein J. Nanotechnol. 9 (2018) 1116, used. This file
has those of four of its 45 distances, and an implementation of its law that shares no code with it.

Run as `python validation/tapping.py`; prints a table and writes it to `tapping.md` beside this file. It takes some
ten minutes.
"""

from __future__ import annotations

import math
from pathlib import Path

import numba
import numpy as np
from numpy.typing import NDArray

import restitution as rs
from restitution.indentation import tapping
from restitution.indentation.solve import contact_of

Array = NDArray[np.float64]

# Shear modulus [Pa] over relaxation time [s]: PIB/PIB.txt there, without the terms below ten of its steps, which it
# leaves out.
TERMS = np.array([
    [4.851911e-09, 8.227107e08], [2.249711e-08, 6.314586e08], [9.652457e-08, 3.606929e08], [3.832186e-07, 1.533294e08],
    [1.671136e-06, 4.521882e07], [7.195991e-06, 2.230038e07], [2.888032e-05, 6.100996e06], [1.478849e-04, 2.606182e06],
    [5.871274e-04, 1.107880e06], [2.360628e-03, 2.816315e05], [9.355184e-03, 1.288454e05], [4.028387e-02, 6.354216e04],
    [1.798397e-01, 7.212026e03], [8.160072e-01, 1.336453e04], [3.292734e00, 9.275610e04], [1.302560e01, 4.566990e04],
    [5.846602e01, 1.315000e05], [2.966924e02, 8.110155e04], [1.045648e03, 1.389663e05], [5.277607e03, 1.068347e05],
    [2.635032e04, 1.276189e05], [8.797344e04, 6.263134e04], [4.123520e05, 3.093785e04], [1.830927e06, 1.384156e-01],
    [7.757038e06, 1.322139e-01],
])  # fmt: skip
RADIUS, STIFFNESS, FREQUENCY, QUALITY, AMPLITUDE = 10e-9, 5.8, 45e3, 167.0, 350e-9
HAMAKER, CUTOFF = 2e-19, 0.2e-9
TAPS = 845

# Distance, amplitude, phase [deg], peak force [nN], depth of the tip and of the surface before the touch, loss [aJ];
# lengths in nm. From all samples of the last ten periods in the folders PIB/1stMode and PIB/1stmode.
PUBLISHED = [
    (300.0, 324.168, -71.06, 97.33, 23.963, 20.598, 241.4),
    (200.0, 238.043, -47.54, 147.07, 37.592, 32.905, 517.5),
    (100.0, 144.636, -30.73, 141.27, 44.044, 39.104, 532.9),
    (0.0, 49.205, -18.76, 93.61, 48.617, 44.090, 334.5),
]
UNITS = np.array([1e9, 180.0 / math.pi, 1e9, 1e9, 1e9, 1e18])

TEXT = """\
Made by `validation/tapping.py`. A tip of {radius:g} nm taps on polyisobutylene: k = {stiffness:g} N/m,
f = {frequency:g} kHz, Q = {quality:g}, {amplitude:g} nm of free amplitude, {taps} taps from rest, and the numbers of
the last one. The material has no equilibrium modulus, and 25 terms up to 90 days; the surface therefore sinks from tap
to tap, and no steady state is reached.

Published are the numbers of a simulation
([TappingMode_Simulations](https://github.com/ealopez/TappingMode_Simulations), MIT; used by Nikfarjam et al.,
Beilstein J. Nanotechnol. 9 (2018) 1116). It has the law of Lee and Radok in contact, also while the contact shrinks,
where this law does not hold, and a surface of one element outside of it; three modes of the cantilever (45, 280 and
792 kHz; 5.8, 210 and 1797 N/m) and a van der Waals force (H = 0.2 aJ, a0 = 0.2 nm). *Its law* is a computation of this
script with the same law, one mode and no van der Waals force. *Exact* is this package, one mode. So the second and
third lines of each distance differ by the law alone; the fourth line has the van der Waals force in addition. The
depths exceed the radius of the tip, beyond the small strains of both theories: the table compares the theories, and
not these with a polymer.

{table}

{words}
"""


@numba.njit(cache=False)
def last_tap(
    moduli: Array, times: Array, mass: float, damping: float, push: float, omega: float, distance: float, steps: int
) -> Array:
    """Return numbers of the last tap by the law of the published simulation, which holds on the approach only.

    In contact F = 16/3 sqrt(R) sum G (p - p_k) with p = d^(3/2) and p_k' = (p - p_k)/tau_k. Outside, the surface is
    at x = sum G x_k/sum G with x_k = p_k^(2/3), x_k' = (x - x_k)/tau_k.
    """
    step = 2.0 * math.pi / omega / steps
    p, decay = np.zeros(times.size), 1.0 - np.exp(-step / times)
    glass, factor = moduli.sum(), 16.0 / 3.0 * math.sqrt(RADIUS)
    z, z_before, force, surface = 0.0, 0.0, 0.0, 0.0
    cosine, sine, most, deepest, level, loss = 0.0, 0.0, 0.0, 0.0, 1.0, 0.0
    for n in range(TAPS * steps):
        time = (n + 1) * step
        rate = (z - z_before) / step
        acceleration = (push * math.cos(omega * time) + force - damping * rate - STIFFNESS * z) / mass
        z, z_before = 2.0 * z - z_before + acceleration * step * step, z
        depth, force_before = -(distance + z), force
        free = 0.0
        for k in range(times.size):
            free += moduli[k] * p[k] ** (2.0 / 3.0)
        free /= glass
        if depth > free:
            surface = depth
            target, force = depth**1.5, 0.0
            for k in range(times.size):
                force += factor * moduli[k] * (target - p[k])
                p[k] += decay[k] * (target - p[k])
        else:
            surface, force = free, 0.0
            for k in range(times.size):
                x = p[k] ** (2.0 / 3.0)
                p[k] = (x + decay[k] * (surface - x)) ** 1.5
        if n >= (TAPS - 1) * steps:
            cosine += 2.0 / steps * z * math.cos(omega * time)
            sine += 2.0 / steps * z * math.sin(omega * time)
            most, deepest, level = max(most, force), max(deepest, depth), min(level, surface)
            loss -= 0.5 * (force + force_before) * (z - z_before)
    return np.array([math.hypot(cosine, sine), math.atan2(-sine, cosine), most, deepest, level, loss])


def exact(distance: float, pull: tapping.Pull) -> Array:
    """Return the same numbers by this package, tap for tap."""
    material = rs.Material(rs.PronySeries(0.0, TERMS[:, 1], TERMS[:, 0]), math.inf)
    lever = tapping.cantilever(STIFFNESS, QUALITY, FREQUENCY, None, AMPLITUDE, None)
    tapper = tapping.Tapper(contact_of(material, rs.Parabola(RADIUS), None), lever, pull, 1e-7)
    start = tapping.Start(-distance, 0.0)
    for _ in range(TAPS - 1):
        start = tapper.end(tapper.run(distance, start))
    numbers = tapping.numbers_of_tap(tapper, distance, tapper.run(distance, start))
    names = ("amplitude", "phase", "max_force", "max_indentation_depth")
    return np.array([*(numbers[name] for name in names), start.level, numbers["dissipated"]])


def main() -> None:
    """Write the table."""
    lever = tapping.cantilever(STIFFNESS, QUALITY, FREQUENCY, None, AMPLITUDE, None)
    pull = tapping.Pull(HAMAKER * RADIUS / 6.0, CUTOFF)
    head = ["distance [nm]", "", "amplitude [nm]", "phase [deg]", "peak force [nN]", "depth [nm]", "surface [nm]",
            "loss [aJ]"]  # fmt: skip
    lines = ["| " + " | ".join(head) + " |", "|" + "---|" * len(head)]
    rows: list[list[Array]] = []
    for distance, *published in PUBLISHED:
        place = 1e-9 * distance
        law = last_tap(TERMS[:, 1], TERMS[:, 0], lever.mass, lever.damping, lever.push, lever.omega, place, 20_000)
        rows.append([np.array(published), law * UNITS, exact(place, tapping.Pull()) * UNITS,
                     exact(place, pull) * UNITS])  # fmt: skip
        for words, row in zip(("published", "its law", "exact", "exact, with the pull"), rows[-1], strict=True):
            cells = [f"{value:.{digits}f}" for value, digits in zip(row, (2, 2, 1, 2, 2, 0), strict=True)]
            lines.append("| " + " | ".join([f"{distance:g}" if words == "published" else "", words, *cells]) + " |")
            print(lines[-1], flush=True)
    data = np.array(rows)
    words = statement(data[:, 1] / data[:, 2] - 1.0, data)
    text = TEXT.format(
        radius=1e9 * RADIUS, stiffness=STIFFNESS, frequency=1e-3 * FREQUENCY, quality=QUALITY,
        amplitude=1e9 * AMPLITUDE, taps=TAPS, table="\n".join(lines), words=words,
    )  # fmt: skip
    print(words)
    Path(__file__).with_suffix(".md").write_text(text, encoding="utf-8")


def statement(law: Array, data: Array) -> str:
    """Return by how much the law differs from the exact contact, in words."""

    def ends(values: Array) -> str:
        return f"{100.0 * values.min():+.0f} to {100.0 * values.max():+.0f} %"

    pushed = data[:, :, 3] - data[:, :, 4]
    return (
        f"By its law alone the peak force differs by {ends(law[:, 2])}, the depth of the tip by {ends(law[:, 3])}, "
        f"the depth of the tip below the surface before the touch by {ends(pushed[:, 1] / pushed[:, 2] - 1.0)}, the "
        f"loss by {ends(law[:, 5])}, and the phase by up to "
        f"{np.abs(data[:, 1, 1] - data[:, 2, 1]).max():.1f} degrees. "
        f"All of the published simulation beside the exact contact with the pull: peak force "
        f"{ends(data[:, 0, 2] / data[:, 3, 2] - 1.0)}, depth {ends(data[:, 0, 3] / data[:, 3, 3] - 1.0)}, loss "
        f"{ends(data[:, 0, 5] / data[:, 3, 5] - 1.0)}."
    )


if __name__ == "__main__":
    main()
