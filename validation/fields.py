"""Errors of pressure and surface displacement during impacts, against closed forms. It takes some seconds."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

import restitution as rs

Array = NDArray[np.float64]
SHARES = np.linspace(0.05, 0.95, 25)
INSIDE = np.array([0.0, 0.1, 0.5, 0.9, 0.99])
OUTSIDE = np.array([1.001, 1.5, 3.0, 20.0])
ELASTIC = rs.Material(1.3, 2.1)
SOLID = rs.Material(rs.PronySeries(1.0, [4.0, 2.0, 1.0], [0.02, 0.3, 20.0]), 3.0)
DASHPOT = rs.Material(rs.PronySeries(1.0, [3.0], [0.5], parallel_viscosity=0.1), math.inf)


def states(result: rs.ImpactResult) -> list[tuple[float, float, float, float]]:
    """Time, contact radius, depth and force at instants of a contact."""
    results = result.sample(SHARES * result.contact_time)
    names = ("contact_radius", "indentation_depth", "force")
    columns = [results.time.values, *(results[name].values for name in names)]
    return [tuple(map(float, row)) for row in zip(*columns, strict=True)]


def worst(values: Array, expected: Array) -> float:
    """Largest relative difference."""
    return float(np.max(np.abs(values / expected - 1.0)))


def hertz() -> list[tuple[str, float]]:
    """Hertz's pressure, Johnson's surface outside the contact, Boussinesq's point force far away."""
    result = rs.solve(rs.Impact(ELASTIC, rs.Parabola(2.0), 1.0, 1.0), rtol=1e-12)
    modulus = result.impact.reduced_modulus.equilibrium_modulus
    ellipse = inside = outside = far = 0.0
    for t, a, depth, force in states(result):
        r = a * INSIDE
        ellipse = max(ellipse, worst(result.pressure(r, t), modulus / math.pi * np.sqrt((a - r) * (a + r))))
        inside = max(inside, worst(result.surface_displacement(r, t), depth - r**2 / 4.0))
        arcs = (2.0 - OUTSIDE**2) * np.arcsin(1.0 / OUTSIDE) + np.sqrt(OUTSIDE**2 - 1.0)
        outside = max(outside, worst(result.surface_displacement(a * OUTSIDE, t), a**2 / (2.0 * math.pi) * arcs))
        point = force / (math.pi * modulus * 1e4 * a)
        far = max(far, worst(result.surface_displacement(np.array([1e4 * a]), t), np.array([point])))
    return [
        ("Hertz: pressure", ellipse),
        ("Hertz: surface in contact", inside),
        ("Hertz: surface outside, to 20 a", outside),
        ("Boussinesq's point force: surface at 10 000 a", far),
    ]


def punch() -> list[tuple[str, float]]:
    """Flat punch on a solid with a dashpot: Boussinesq's pressure and surface at every instant."""
    result = rs.solve(rs.Impact(DASHPOT, rs.FlatPunch(0.4), 1.0, 1.0), rtol=1e-12)
    pressure = surface = 0.0
    for t, a, depth, force in states(result):
        r = a * INSIDE
        pressure = max(pressure, worst(result.pressure(r, t), force / (2.0 * math.pi * a * np.sqrt(a**2 - r**2))))
        outside = 2.0 * depth / math.pi * np.arcsin(1.0 / OUTSIDE)
        surface = max(surface, worst(result.surface_displacement(a * OUTSIDE, t), outside))
    return [
        ("Boussinesq's punch on a viscoelastic solid: pressure", pressure),
        ("Boussinesq's punch on a viscoelastic solid: surface outside", surface),
    ]


def carried(result: rs.ImpactResult) -> float:
    """Largest relative difference of the integral of the pressure and the force."""
    nodes, weights = np.polynomial.legendre.leggauss(8)
    # Nodes are dense near the axis, where the pressure under a cone has a logarithmic singularity.
    edges = 0.5 * math.pi * np.linspace(0.0, 1.0, 201) ** 2
    half = 0.5 * np.diff(edges)[:, None]
    angle = (edges[:-1, None] + half * (1.0 + nodes)).ravel()
    weight = (half * weights).ravel()
    largest = 0.0
    for t, a, _, force in states(result):
        p = result.pressure(a * np.sin(angle), t)
        total = float(np.sum(weight * p * 2.0 * math.pi * a**2 * np.sin(angle) * np.cos(angle)))
        largest = max(largest, abs(total / force - 1.0))
    return largest


def main() -> None:
    """Write `fields.md`."""
    rows = [*hertz(), *punch()]
    for name, tip in (("sphere", rs.Parabola(1.0)), ("cone", rs.Cone(1.1))):
        result = rs.solve(rs.Impact(SOLID, tip, 1.0, 1.0), rtol=1e-12)
        rows.append((f"{name} on a solid of three branches: integral of the pressure over the force", carried(result)))
    lines = [
        "| what | largest relative error |",
        "|---|---|",
        *(f"| {what} | {error:.0e} |" for what, error in rows),
    ]
    Path(__file__).with_suffix(".md").write_text("\n".join(lines) + "\n", encoding="utf-8")


if __name__ == "__main__":
    main()
