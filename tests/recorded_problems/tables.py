"""Sweeps over axes of all sorts, and surrogates."""

from __future__ import annotations

import math
import tempfile
from pathlib import Path
from typing import Any

import numpy as np

import restitution as rs
from recorded_problems.draws import material, power, profile, rubber, series, solid
from recorded_problems.registry import Random, problem

ENERGIES = ("restitution_coefficient", "dissipated_energy", "stored_energy", "radiated_energy", "kinetic_energy_out")
VELOCITIES = rs.Logarithmic(0.01, 0.3, 4)


def ball(item: Any, geometry: Any = None, **options: Any) -> Any:
    """Impact of a ball, the base of a sweep."""
    return rs.Impact(item, geometry or rs.Parabola(0.01), 0.005, 0.2, **options)


# Axes of a sweep over a standard solid, and its further arguments.
SOLID_AXES: dict[str, tuple[dict[str, Any], dict[str, Any]]] = {
    "velocity": ({"velocity": rs.Logarithmic(0.01, 0.3, 12)}, {}),
    "mass, radius": ({"mass": rs.Linear(0.002, 0.01, 3), "radius": [0.01, 0.02, 0.04]}, {}),
    "external_force": ({"external_force": [0.0, 0.01, 0.05], "velocity": VELOCITIES}, {}),
    "impedance": ({"impedance": [1.0, 10.0, math.inf], "velocity": VELOCITIES}, {}),
    "nu": ({"nu": [0.3, 0.45, 0.48, 0.5], "radius": [0.01, 0.02]}, {}),
    "bulk_modulus": ({"bulk_modulus": rs.Logarithmic(1e6, 1e9, 4), "velocity": VELOCITIES}, {}),
    "equilibrium_modulus": ({"equilibrium_modulus": rs.Logarithmic(1e5, 1e6, 4)}, {}),
    "equilibrium_modulus, nu held": ({"equilibrium_modulus": rs.Logarithmic(1e5, 1e6, 4)}, {"held": "poisson_ratio"}),
    "branch_modulus": ({"branch_modulus": rs.Logarithmic(1e6, 1e7, 4), "viscosity": [1e2, 1e3]}, {}),
    "p2, p3": ({"p2": [0.1, 1.0], "p3": [0.1, 1.0, 10.0]}, {}),
    "relaxation_time": ({"relaxation_time": rs.Logarithmic(1e-5, 1e-2, 4), "velocity": VELOCITIES}, {}),
    "energies": ({"velocity": VELOCITIES}, {"outputs": ENERGIES}),
    "pressure": ({"velocity": VELOCITIES}, {"outputs": ("max_pressure", "max_contact_radius")}),
    "validity": ({"velocity": VELOCITIES}, {"outputs": ("strain_number", "window_ratio", "zero")[:2]}),
}


@problem("sweep", SOLID_AXES, pressure=1e-7)
def over(random: Random, kind: str) -> Any:
    axes, options = SOLID_AXES[kind]
    return rs.sweep(ball(solid(random, poisson_ratio=0.45)), axes, **options)


@problem("sweep", ["branches", "temperature", "materials", "counter materials", "bulk modulus that relaxes"])
def over_materials(random: Random, kind: str) -> Any:
    shifted = rs.Material(series(random, 5), 2e9, shift=rs.WLF(298.0, 8.61, 200.4), temperature=298.0)
    several = [material(random, name) for name in ("3 branches", "12 branches", "kelvin_voigt", "springpot")]
    base, axes = {
        "branches": lambda: (
            rubber(random),
            {"branch_moduli[0]": [1e5, 1e6], "relaxation_times[1]": rs.Logarithmic(1e-4, 1e-2, 3)},
        ),
        "temperature": lambda: (shifted, {"temperature": rs.Linear(280.0, 320.0, 4), "velocity": VELOCITIES}),
        "materials": lambda: (rubber(random), {"material": several, "velocity": VELOCITIES}),
        "counter materials": lambda: (rubber(random), {"counter_material": several, "velocity": VELOCITIES}),
        "bulk modulus that relaxes": lambda: (
            material(random, "bulk relaxes"),
            {"bulk_modulus": rs.Logarithmic(1e7, 1e9, 3), "velocity": VELOCITIES},
        ),
    }[kind]()
    return rs.sweep(ball(base), axes)


@problem("sweep", ["thickness", "thickness and radius", "radius_1", "face_angle", "half_angle", "face_radius",
                   "exponent", "sphere", "table", "law"])  # fmt: skip
def over_geometries(random: Random, kind: str) -> Any:
    pad = rs.Layer(rs.Parabola(0.01), 0.005, "frictionless")
    geometry, axes = {
        "thickness": lambda: (rs.Layer(rs.Parabola(0.01), 0.005), {"thickness": rs.Logarithmic(0.002, 0.2, 5)}),
        "thickness and radius": lambda: (pad, {"thickness": rs.Logarithmic(0.002, 0.2, 3), "radius": [0.01, 0.02]}),
        "radius_1": lambda: (rs.Ellipsoid(0.01, 0.03), {"radius_1": [0.01, 0.02, 0.2]}),
        "face_angle": lambda: (rs.Pyramid(1.0), {"face_angle": [1.0, 1.2, 1.3]}),
        "half_angle": lambda: (rs.Cone(1.0), {"half_angle": [1.0, 1.2, 1.3]}),
        "face_radius": lambda: (rs.FlatEndedParabola(0.01, 1e-3), {"face_radius": [1e-4, 1e-3]}),
        "exponent": lambda: (rs.PowerLaw(2.0, 10.0), {"exponent": [1.5, 2.0, 3.0], "coefficient": [5.0, 10.0]}),
        "sphere": lambda: (rs.Sphere(0.01), {"radius": rs.Linear(0.01, 0.02, 3)}),
        "table": lambda: (profile(random, "tabulated"), {"mass": [1e-3, 2e-3]}),
        "law": lambda: (profile(random, "force law, exponent"), {"mass": [1e-3, 2e-3]}),
    }[kind]()
    return rs.sweep(ball(solid(random, poisson_ratio=0.5), geometry), axes | {"velocity": VELOCITIES})


@problem("sweep", ["sobol", "latin_hypercube"])
def samples(random: Random, method: Any) -> Any:
    draws = rs.Samples(
        16,
        {
            "mass": rs.LogNormal(0.005, 0.05),
            "branch_modulus": rs.Normal(1e7, 1e6),
            "radius": rs.Uniform(0.009, 0.011),
            "velocity": rs.LogUniform(0.05, 0.2),
        },
        method=method,
        rng=3,
    )
    return rs.sweep(ball(solid(random)), {"draw": draws, "external_force": [0.0, 0.01]})


@problem("sweep")
def function(random: Random, _: int) -> Any:
    target = rubber(random)

    def sphere(radius: float) -> Any:
        return rs.Impact(target, rs.Parabola(radius), 4600.0 * radius**3, 1.0)

    return rs.sweep(sphere, {"radius": rs.Linear(0.005, 0.02, 4), "velocity": VELOCITIES})


@problem("sweep")
def plane_of_the_paper(random: Random, _: int) -> Any:
    axes = {"nu": [0.3, 0.45], "p2": rs.Logarithmic(0.1, 10.0, 6), "p3": rs.Logarithmic(0.01, 100.0, 6)}
    return rs.sweep(None, axes, ("restitution_coefficient",))


@problem("sweep")
def store(random: Random, _: int) -> Any:
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "sweep.zarr"
        rs.sweep(ball(solid(random)), {"velocity": VELOCITIES, "mass": [0.004, 0.005]}, out=path, chunk=3)
        return {name: column.values for name, column in rs.open_sweep(path).load().data_vars.items()}


@problem("surrogate", ["standard solid", "cone", "sphere", "layer", "force", "two bodies"], rtol=1e-8, error=math.inf)
def surrogate(random: Random, kind: str) -> Any:
    target = solid(random, poisson_ratio=0.5)
    hit = {
        "standard solid": lambda: ball(target),
        "cone": lambda: ball(target, rs.Cone(1.2)),
        "sphere": lambda: ball(target, rs.Sphere(0.01)),
        "layer": lambda: ball(target, rs.Layer(rs.Parabola(0.01), 0.005)),
        "force": lambda: ball(target, external_force=1e-4),
        "two bodies": lambda: ball(target, counter_material=rubber(random)),
    }[kind]()
    result = rs.surrogate(hit, velocity=(0.05, 0.5))
    v = power(random, math.log10(0.05), math.log10(0.5), 8)
    values = {"restitution_coefficient": result(v), "time": result.contact_time(v), "force": result.max_force(v)}
    values["table"] = result.sample(9)
    with tempfile.TemporaryDirectory() as folder:
        again = rs.Surrogate.load(result.save(Path(folder) / "e.json"))
    assert np.array_equal(again(v), values["restitution_coefficient"])
    return values | {"error": result.error}
