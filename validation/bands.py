"""Bands of e for contacts beyond the data: how many of made materials lie in them.

Each material is known over twelve decades. Its moduli over three decades of frequency, which end within half a decade
before to one and a half after a contact of a steel ball, are fitted, and the fit is asked for its band.

Run: python validation/bands.py [number of materials]
"""

from __future__ import annotations

import math
import sys
import warnings

import numpy as np

import restitution as rs

TIMES = np.logspace(-9, 3, 37)


def power_law(rng: np.random.Generator) -> rs.PronySeries:
    """A spectrum of the power -0.1 to -0.5 of time."""
    return rs.PronySeries(1e6, 1e6 * (TIMES / 1e-3) ** -rng.uniform(0.1, 0.5), TIMES)


def transition(rng: np.random.Generator) -> rs.PronySeries:
    """A glass transition with a peak at 0.1 µs to 0.1 ms, and a glass of about 0.6 GPa."""
    decades = np.log10(TIMES) - rng.uniform(-7.0, -4.0)
    return rs.PronySeries(1e6, (1e8 * np.exp(-0.5 * decades**2) + 2e5) * math.log(10.0) / 3.0, TIMES)


def distances(count: int, seed: int = 0) -> np.ndarray:
    """Distance of the exact e from the band, zero inside, and the width of the band, shape (n, 2)."""
    rng, rows = np.random.default_rng(seed), []
    for number in range(count):
        series = (power_law, transition)[number % 2](rng)
        exact = rs.solve(rs.Impact(rs.Material(series, math.inf), rs.Parabola(0.01), mass=0.0327, velocity=1.0))
        low = float(exact.contact_time) * 10.0 ** rng.uniform(-0.5, 1.5)
        omega = np.geomspace(1e-3 / low, 1.0 / low, 31)
        table = rs.DynamicTable(omega, series.storage_modulus(omega), series.loss_modulus(omega), "shear")
        material = rs.fit_prony(table).material(poisson_ratio=0.5)
        band = rs.restitution_band(rs.Impact(material, rs.Parabola(0.01), mass=0.0327, velocity=1.0))
        if band is not None:
            e = float(exact.restitution_coefficient)
            rows.append((max(band.low - e, e - band.high, 0.0), band.high - band.low))
    return np.array(rows)


if __name__ == "__main__":
    warnings.simplefilter("ignore", rs.RestitutionWarning)
    outside, width = distances(int(sys.argv[1]) if len(sys.argv) > 1 else 300).T
    print(f"{(outside == 0.0).sum()} of {outside.size} inside, {(outside < 0.01).sum()} within 0.01")
    print(f"farthest outside {outside.max():.4f}, mean width {width.mean():.2f}")
