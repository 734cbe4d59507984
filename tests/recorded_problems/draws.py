"""Random materials and profiles of a ball with a radius of some 10 mm, and the numbers of an impact."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

import numpy as np

import restitution as rs
from recorded_problems.registry import Random

NUMBERS = (
    "restitution_coefficient",
    "contact_time",
    "max_indentation_depth",
    "max_force",
    "max_contact_radius",
    "residual_indentation_depth",
    "rebound_velocity",
    "status",
)
ENERGIES = ("kinetic_in", "kinetic_out", "dissipated", "stored", "radiated")


def power(random: Random, low: float, high: float, size: Any = None) -> Any:
    """Numbers between 10**low and 10**high, spread over their orders of magnitude."""
    return 10.0 ** random.uniform(low, high, size)


def series(random: Random, count: int, *, liquid: bool = False, times: tuple[float, float] = (-5.0, 0.0)) -> Any:
    """Prony series in shear of some MPa."""
    moduli = power(random, 4.5, 6.5, count)
    return rs.PronySeries(0.0 if liquid else power(random, 5.5, 6.5), moduli, power(random, *times, count))


def solid(random: Random, **bulk: Any) -> Any:
    """Standard solid, by default with a random Poisson ratio."""
    modulus, branch, time = power(random, 5.5, 6.5), power(random, 5.5, 7.0), power(random, -4.0, -2.0)
    return rs.standard_solid(modulus, branch, branch * time, **(bulk or {"poisson_ratio": random.uniform(0.3, 0.5)}))


def rubber(random: Random) -> Any:
    """Incompressible material with five branches."""
    return rs.Material(series(random, 5), math.inf)


def materials(random: Random) -> dict[str, Callable[[], Any]]:
    """Materials by their kinds."""
    modulus, other, time = power(random, 5.5, 6.5), power(random, 5.5, 7.0), power(random, -4.0, -2.0)
    window, exponent = (1e-8, 1e2), random.uniform(0.1, 0.6)
    window_of = lambda shear, bulk: rs.FractionalMaterial(shear, bulk).within(window)  # noqa: E731
    return {
        "elastic": lambda: rs.elastic(youngs_modulus=modulus, poisson_ratio=0.4),
        "standard solid, Poisson ratio": lambda: solid(random),
        "standard solid, bulk modulus": lambda: solid(random, bulk_modulus=power(random, 6.5, 9.5)),
        "standard solid, nu = -1": lambda: solid(random, bulk_modulus=0.0),
        "maxwell": lambda: rs.maxwell(other, 30.0 * other * time, bulk_modulus=power(random, 7.0, 9.0)),
        "maxwell, incompressible": lambda: rs.maxwell(other, 30.0 * other * time, bulk_modulus=math.inf),
        "kelvin_voigt": lambda: rs.kelvin_voigt(modulus, 0.1 * modulus * time, poisson_ratio=0.5),
        "kelvin_voigt, bulk viscosity": lambda: rs.kelvin_voigt(
            modulus, 0.1 * modulus * time, bulk_modulus=3.0 * modulus, bulk_viscosity=0.2 * modulus * time
        ),
        "burgers": lambda: rs.burgers(
            other, 50.0 * other * time, modulus, modulus * time, bulk_modulus=power(random, 7.0, 9.0)
        ),
        "generalised_maxwell": lambda: rs.generalised_maxwell(
            modulus, power(random, 5.0, 6.5, 4), power(random, -5.0, 0.0, 4), poisson_ratio=0.45
        ),
        "3 branches": lambda: rs.Material(series(random, 3), power(random, 6.5, 9.0)),
        "12 branches": lambda: rs.Material(series(random, 12), math.inf),
        "25 branches, liquid": lambda: rs.Material(series(random, 25, liquid=True, times=(-6.0, 3.0)), 2e9),
        "bulk relaxes alike": lambda: (lambda shear: rs.Material(shear, shear.scaled(3.0)))(series(random, 4)),
        "bulk relaxes": lambda: rs.Material(series(random, 4), series(random, 5).scaled(4.0)),
        "bulk of zero": lambda: rs.Material(series(random, 3), 0.0),
        "parallel dashpot": lambda: rs.Material(
            rs.PronySeries(modulus, [other], [time], parallel_viscosity=0.02 * modulus * time), 1e8
        ),
        "equal times": lambda: rs.Material(
            rs.PronySeries(modulus, [other, 0.5 * other, modulus], [time, time, time * (1.0 + 1e-12)]), math.inf
        ),
        "springpot": lambda: window_of(rs.springpot(modulus * 0.1**exponent, exponent), 2e9),
        "fractional_kelvin_voigt": lambda: window_of(
            rs.fractional_kelvin_voigt(modulus, modulus * time**exponent, exponent), math.inf
        ),
        "fractional_maxwell": lambda: window_of(rs.fractional_maxwell(other, 30.0 * time, exponent), math.inf),
        "fractional_zener": lambda: window_of(rs.fractional_zener(modulus, other, time, exponent), 1e8),
        "from tension": lambda: rs.Material(rs.shear_from_tension(series(random, 4), bulk_modulus=2e7), 2e7),
        "shifted": lambda: rs.Material(series(random, 6), 2e9, shift=rs.WLF(298.0, 8.61, 200.4), temperature=298.0).at(
            random.uniform(270.0, 320.0)
        ),
        "shifted by a table": lambda: rs.Material(
            series(random, 6), 2e9, shift=rs.ShiftTable([280.0, 300.0, 320.0], [1.1, 0.0, -0.8]), temperature=300.0
        ).at(random.uniform(281.0, 319.0)),
        "shifted by Arrhenius": lambda: rs.Material(
            series(random, 6), 2e9, shift=rs.Arrhenius(298.0, 8e4), temperature=298.0
        ).at(random.uniform(270.0, 320.0)),
    }


MATERIALS = tuple(materials(np.random.default_rng()))


def material(random: Random, kind: str) -> Any:
    """Material of a kind."""
    return materials(random)[kind]()


def measured_tip(random: Random, size: float, points: int, noise: float) -> Any:
    """Tip close to a parabola of radius `size`, with noise of its heights, or in steps if noise is negative."""
    r = np.linspace(0.0, 1.5 * size, points)
    f = r**2 / (2.0 * size)
    f = f * (1.0 + noise * random.normal(size=r.size)) if noise >= 0.0 else -noise * np.round(f / -noise)
    f = np.maximum.accumulate(f)
    return rs.Tabulated(r, f - f[0])


def force_law(exponent: float | None) -> Any:
    """Force law of an elastic twin of 1 MPa with 41 rows."""
    depth = np.linspace(0.0, 4e-3, 41)
    force = 4.0 / 3.0 * 1e6 / 0.75 * np.sqrt(0.01) * depth**1.5 * (1.0 + 0.3 * np.sqrt(depth / 4e-3))
    return rs.ForceLaw(depth, force, 1e6, 0.5, exponent)


def profiles(random: Random) -> dict[str, Callable[[], Any]]:
    """Geometries by their kinds."""
    size = power(random, -2.2, -1.8)
    ball, thick = rs.Parabola(size), size * power(random, -0.7, 0.5)
    return {
        "parabola": lambda: ball,
        "sphere": lambda: rs.Sphere(size),
        "cone": lambda: rs.Cone(random.uniform(0.8, 1.4)),
        "power law 4": lambda: rs.PowerLaw(4.0, 0.1 * size**-3.0),
        "power law": lambda: rs.PowerLaw(random.uniform(1.2, 3.0), 10.0),
        "flat punch": lambda: rs.FlatPunch(0.2 * size),
        "flat-ended parabola": lambda: rs.FlatEndedParabola(size, 0.1 * size),
        "truncated cone": lambda: rs.TruncatedCone(0.1 * size, random.uniform(1.0, 1.4)),
        "tabulated": lambda: measured_tip(random, size, 60, 0.0),
        "noisy tip": lambda: measured_tip(random, size, 150, 1e-4),
        "tip in steps": lambda: measured_tip(random, size, 120, -1e-4 * size),
        "ellipsoid": lambda: rs.Ellipsoid(size, size * power(random, 0.0, 1.5)),
        "crossed cylinders": lambda: rs.crossed_cylinders(size, 3.0 * size, angle=random.uniform(0.3, 1.5)),
        "ellipsoid of bodies": lambda: rs.Ellipsoid.of_bodies(
            [size, 2.0 * size], [3.0 * size, math.inf], angle=random.uniform(0.0, 1.5)
        ),
        "pyramid 3": lambda: rs.Pyramid(random.uniform(0.9, 1.4), 3),
        "pyramid 4": lambda: rs.Pyramid(random.uniform(0.9, 1.4)),
        "pyramid 6": lambda: rs.Pyramid(random.uniform(0.9, 1.4), 6),
        "force law, exponent": lambda: force_law(1.5),
        "force law": lambda: force_law(None),
        "layer, bonded": lambda: rs.Layer(ball, thick),
        "layer, strict": lambda: rs.Layer(ball, thick, strict=True),
        "layer, frictionless": lambda: rs.Layer(ball, thick, "frictionless"),
        "layer under a cone": lambda: rs.Layer(rs.Cone(random.uniform(0.9, 1.4)), thick, "frictionless"),
        "layer under a power law": lambda: rs.Layer(rs.PowerLaw(3.0, 10.0), thick),
        "layer under a sphere": lambda: rs.Layer(rs.Sphere(size), thick),
        "layer under a flat end": lambda: rs.Layer(rs.FlatEndedParabola(size, 0.1 * size), thick),
        "layer under a punch": lambda: rs.Layer(rs.FlatPunch(0.2 * size), thick),
        "layer under a table": lambda: rs.Layer(measured_tip(random, size, 40, 0.0), thick, "frictionless"),
        "layers of several thicknesses": lambda: rs.Layer(ball, thick * np.array([0.5, 1.0, 4.0])),
        "layers, frictionless, several": lambda: rs.Layer(ball, thick * np.array([0.5, 1.0, 4.0]), "frictionless"),
        "parabolas": lambda: rs.Parabola(size * np.array([0.5, 1.0, 2.0])),
        "spheres": lambda: rs.Sphere(size * np.array([0.5, 1.0, 2.0])),
        "cones": lambda: rs.Cone(np.array([0.9, 1.1, 1.3])),
        "power laws": lambda: rs.PowerLaw(2.5, np.array([5.0, 10.0, 20.0])),
        "ellipsoids": lambda: rs.Ellipsoid(size, size * np.array([1.0, 2.0, 20.0])),
        "pyramids": lambda: rs.Pyramid(np.array([0.9, 1.1, 1.3])),
    }


PROFILES = tuple(profiles(np.random.default_rng()))


def profile(random: Random, kind: str) -> Any:
    """Geometry of a kind."""
    return profiles(random)[kind]()


def of_impact(result: Any, *, energy: bool = True) -> dict[str, Any]:
    """Numbers of an impact, single or an array."""
    numbers = {name: getattr(result, name) for name in NUMBERS} | {"zero_overlap_time": result.zero_overlap_time}
    if energy:
        numbers |= {f"energy.{name}": getattr(result.energy, name) for name in ENERGIES}
    return numbers


def of_prony(series: Any) -> dict[str, Any]:
    """Functions of a Prony series."""
    t, omega = np.geomspace(1e-6, 1e2, 7), np.geomspace(1e-2, 1e6, 7)
    return {
        "series": series,
        "relaxation_modulus": series.relaxation_modulus(t),
        "creep_compliance": series.creep_compliance(t),
        "storage_modulus": series.storage_modulus(omega),
        "loss_modulus": series.loss_modulus(omega),
        "loss_tangent": series.loss_tangent(omega),
    }


def of_validity(result: Any) -> dict[str, Any]:
    """Numbers that the validity report compares with their limits."""
    return {name: check["value"] for name, check in result.validity.to_dict().items()}
