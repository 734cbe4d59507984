"""Impacts of all materials, profiles and options, their histories and fields, and other methods."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

import restitution as rs
from recorded_problems.draws import (
    MATERIALS,
    PROFILES,
    force_law,
    material,
    of_impact,
    of_prony,
    of_validity,
    power,
    profile,
    rubber,
    solid,
)
from recorded_problems.registry import Random, problem


@problem("material", MATERIALS)
def impact_on(random: Random, kind: str) -> Any:
    item, mass = material(random, kind), power(random, -3.0, -1.5)
    ball = rs.Parabola(power(random, -2.3, -1.7))
    single = rs.solve(rs.Impact(item, ball, mass, power(random, -1.5, 0.0)))
    several = rs.solve(rs.Impact(item, ball, mass, power(random, -2.0, 0.0, 4)))
    return {"single": of_impact(single), "several": of_impact(several, energy=False)}


@problem("material", MATERIALS[1:24:4])
def functions_of(random: Random, kind: str) -> Any:
    target = material(random, kind)
    t = np.geomspace(1e-6, 10.0, 7)
    result = {
        "shear": of_prony(target.shear),
        "reduced": of_prony(rs.reduced_modulus(target)),
        "nu": target.poisson_ratio,
    }
    result["instantaneous_nu"] = target.instantaneous_poisson_ratio
    return result | {"nu(t)": target.relaxation_poisson_ratio(t)}


@problem("material", rs.library.names())
def library(random: Random, name: str) -> Any:
    target = rs.library.get(name)
    t = np.geomspace(1e-8, 10.0, 5)
    hit = rs.solve(rs.Impact(target, rs.Parabola(0.005), 0.004, power(random, -2.0, 0.0)), errors="warn")
    speed = {} if target.density is None else {"wave_speed": target.wave_speed(t)}
    return of_impact(hit, energy=False) | speed | {"nu(t)": target.relaxation_poisson_ratio(t), "material": target}


@problem("profile", PROFILES)
def impact_of(random: Random, kind: str) -> Any:
    geometry = profile(random, kind)
    target = solid(random, poisson_ratio=0.5) if "layer" in kind or "law" in kind else solid(random)
    mass = power(random, -3.0, -2.0)
    if np.all(np.isfinite(getattr(geometry, "max_contact_radius", math.inf))):
        mass = 0.3 * mass
    hit = rs.Impact(target, geometry, mass, power(random, -2.0, -0.5))
    result = rs.solve(hit, errors="warn")
    branches = rs.solve(rs.Impact(rubber(random), geometry, mass, power(random, -2.0, -0.5)), errors="warn")
    depth = 1e-4 * np.array([0.0, 0.3, 1.0])
    plain = np.size(result.contact_time) == 1 and "layer" not in kind
    radius = {"contact_radius": geometry.contact_radius(depth)} if plain else {}
    return {"solid": of_impact(result), "branches": of_impact(branches, energy=False)} | radius


@problem("profile", ["bonded", "frictionless"], slow=["bonded"])
def layer_that_changes_its_poisson_ratio(random: Random, base: str) -> Any:
    soft = rs.Material(rs.PronySeries(2e5, [2e5, 5e5], [1e-3, 1e-4]), power(random, 5.8, 6.5))
    target = rs.Layer(rs.Parabola(0.01), power(random, -2.5, -2.0), base)  # type: ignore[arg-type]
    return of_impact(rs.solve(rs.Impact(soft, target, 0.005, power(random, -2.0, -0.5, 3))))


@problem("options", ["parabola", "sphere", "cone", "ellipsoid", "pyramid 4", "tabulated"])
def two_bodies(random: Random, kind: str) -> Any:
    hit = rs.Impact(
        material(random, "3 branches"), profile(random, kind), power(random, -3.0, -2.0), power(random, -2.0, -0.5),
        counter_material=material(random, "12 branches"),
    )  # fmt: skip
    return of_impact(rs.solve(hit)) | {"reduced": hit.reduced_modulus}


@problem("options", range(3))
def collision(random: Random, number: int) -> Any:
    first = rs.Body(solid(random), power(random, -2.5, -2.0), power(random, -3.0, -2.0))
    other = rs.Body(material(random, "bulk relaxes"), power(random, -2.5, -2.0), power(random, -3.0, -2.0))
    return of_impact(rs.solve(rs.collision(first, other, power(random, -2.0, -0.5, 1 + 2 * number))))


@problem("options", range(2))
def drop(random: Random, number: int) -> Any:
    ball = rs.Body(None, 0.01, 0.02)
    hit = rs.drop(ball, rs.Body(rubber(random)), power(random, -3.0, -1.0), with_weight=number == 0)
    return of_impact(rs.solve(hit))


@problem("options", ["parabola", "cone", "sphere", "layer, bonded"])
def constant_force(random: Random, kind: str) -> Any:
    hit = rs.Impact(
        solid(random, poisson_ratio=0.5), profile(random, kind), 0.005, 0.2,
        external_force=np.array([1e-3, 1e-2, 0.05, 50.0]),
    )  # fmt: skip
    return of_impact(rs.solve(hit, errors="warn"), energy=False)


@problem("options", ["parabola", "cone", "ellipsoid", "layer, bonded"])
def impedance(random: Random, kind: str) -> Any:
    geometry = profile(random, kind)
    target = solid(random, poisson_ratio=0.5)
    hit = rs.Impact(target, geometry, 0.005, 0.2, impedance=power(random, 0.5, 3.0, 4))
    single = rs.Impact(target, geometry, 0.005, 0.2, impedance=power(random, 0.5, 3.0))
    return {"several": of_impact(rs.solve(hit), energy=False), "single": of_impact(rs.solve(single))}


@problem("options")
def plates_and_rods(random: Random, _: int) -> Any:
    glass, steel = rs.library.get("soda_lime_glass"), rs.library.get("steel")
    pane, rod = rs.plate_impedance(glass, [0.003, 0.004, 0.02]), rs.rod_impedance(steel, power(random, -5.0, -3.0))
    knock = rs.Impact(glass, rs.Parabola(0.003), 0.9e-3, 0.05, counter_material=steel, impedance=pane)
    return of_impact(rs.solve(knock)) | {"pane": pane, "rod": rod}


@problem("options", range(3))
def arrays(random: Random, number: int) -> Any:
    mass = power(random, -3.0, -2.0, (3, 1))
    ball = rs.Parabola(power(random, -2.3, -1.7, 4)) if number else rs.Cone(random.uniform(0.9, 1.3, 4))
    force = 0.01 * random.uniform(size=4) if number == 2 else 0.0
    return of_impact(rs.solve(rs.Impact(rubber(random), ball, mass, power(random, -2.0, 0.0), external_force=force)))


@problem("options", ["one profile", "all profiles", "random materials"])
def lists(random: Random, kind: str) -> Any:
    if kind == "all profiles":
        target = solid(random, poisson_ratio=0.5)
        impacts = [rs.Impact(target, profile(random, name), 2e-3, 0.05) for name in PROFILES[:27:2]]
    elif kind == "one profile":
        impacts = [rs.Impact(rubber(random), rs.Parabola(0.01), 0.01, v) for v in power(random, -2.0, 0.0, 6)]
    else:
        impacts = [
            rs.Impact(material(random, name), rs.Sphere(0.01), 2e-3, power(random, -2.0, -0.5))
            for name in MATERIALS[:20]
        ]
    return of_impact(rs.solve(impacts, errors="warn"), energy=False)


@problem("options", [1e-4, 1e-6, 1e-8, 1e-11], rtol=1e-3)
def tolerances(random: Random, rtol: float) -> Any:
    hit = rs.Impact(rubber(random), rs.Parabola(0.01), 0.01, power(random, -2.0, 0.0, 4))
    return of_impact(rs.solve(hit, rtol=rtol))


@problem("options", ["springpot", "zener"])
def for_contact(random: Random, kind: str) -> Any:
    shear = rs.springpot(1e6, random.uniform(0.1, 0.4)) if kind == "springpot" else rs.fractional_zener(
        1e6, 1e7, 1e-3, random.uniform(0.3, 0.7))  # fmt: skip
    gel = rs.FractionalMaterial(shear, 2e9)
    hit = rs.for_contact(lambda window: rs.Impact(gel.within(window), rs.Parabola(0.01), 0.0327, 0.3))
    return of_impact(rs.solve(hit)) | {"material": hit.material}


@problem("options", ["captured", "too deep", "beyond the table", "sinks in", "nearly all energy"])
def extremes(random: Random, kind: str) -> Any:
    ball = rs.Parabola(0.01)
    liquid = rs.maxwell(1e6, power(random, 1.0, 3.0), bulk_modulus=math.inf)
    hits = {
        "captured": lambda: rs.Impact(solid(random), ball, 0.005, 0.01, external_force=power(random, 0.0, 3.0, 3)),
        "too deep": lambda: rs.Impact(solid(random), rs.Sphere(0.001), power(random, -3.0, 0.0, 4), 1.0),
        "beyond the table": lambda: rs.Impact(
            solid(random, poisson_ratio=0.5), force_law(1.5), power(random, -3.0, 1.0, 6), 1.0
        ),
        "sinks in": lambda: rs.Impact(liquid, ball, 0.005, 0.1, external_force=1.0),
        "nearly all energy": lambda: rs.Impact(
            rs.standard_solid(1e4, 1e7, 1e5 * power(random, -1.0, 0.0), poisson_ratio=0.5), ball, 0.005, 0.1
        ),
    }
    return of_impact(rs.solve(hits[kind](), errors="warn"), energy=False)


# The times of the columns follow the steps of the solver, whose number depends on rounding.
HISTORY: dict[str, Any] = {"rtol": 1e-7, "columns.": math.inf}


@problem("history", ["parabola", "sphere", "cone", "tabulated", "ellipsoid", "pyramid 4", "layer, bonded",
                     "force law, exponent", "flat-ended parabola"], **HISTORY)  # fmt: skip
def history(random: Random, kind: str) -> Any:
    hit = rs.Impact(solid(random, poisson_ratio=0.5), profile(random, kind), 2e-3, power(random, -1.5, -0.7))
    result = rs.solve(hit)
    times = np.sort(random.uniform(0.0, 1.0, 9)) * result.contact_time
    return {
        "sample": result.sample(times), "turning_time": result.turning_time, "validity": of_validity(result),
        "columns": result.sample(n_points=41),
    }  # fmt: skip


@problem("history", ["12 branches", "kelvin_voigt", "bulk relaxes", "springpot"], rtol=1e-7)
def history_on(random: Random, kind: str) -> Any:
    hit = rs.Impact(material(random, kind), rs.Parabola(0.01), 2e-3, 0.1, external_force=0.01)
    result = rs.solve(hit)
    times = np.sort(random.uniform(0.0, 1.0, 9)) * result.contact_time
    return {"sample": result.sample(times), "turning_time": result.turning_time, "validity": of_validity(result)}


@problem("history", ["parabola", "sphere", "cone", "ellipsoid", "tabulated"], rtol=1e-7)
def pressure(random: Random, kind: str) -> Any:
    geometry = profile(random, kind)
    result = rs.solve(rs.Impact(solid(random, poisson_ratio=0.5), geometry, 2e-3, power(random, -1.5, -0.7)))
    r = result.max_contact_radius * np.linspace(0.05, 1.2, 5)
    t = result.contact_time * np.array([0.2, 0.5, 0.8])
    numbers = {"max_pressure": result.max_pressure}
    if kind == "ellipsoid":
        return numbers | {"semi_axes": result.max_semi_axes}
    return numbers | {
        "pressure": result.pressure(r[:, None], t),
        "surface": result.surface_displacement(r[:, None], t),
    }


@problem(
    "method", ["parabola", "cone", "sphere", "tabulated", "ellipsoid", "flat-ended parabola"], slow=["cone", "sphere"]
)
def elements(random: Random, kind: str) -> Any:
    hit = rs.Impact(solid(random), profile(random, kind), 2e-3, power(random, -1.5, -0.7))
    return of_impact(rs.solve(hit, method="elements", n_elements=200))


@problem("method", [50, 100, 400])
def several_elements(random: Random, number: int) -> Any:
    hit = rs.Impact(solid(random), rs.Parabola(0.01), 2e-3, power(random, -1.5, -0.7), external_force=1e-3)
    return of_impact(rs.solve(hit, method="elements", n_elements=number))


@problem("method")
def element_history(random: Random, _: int) -> Any:
    hit = rs.Impact(solid(random), rs.Parabola(0.01), 2e-3, power(random, -1.5, -0.7))
    return rs.element_history(hit, n_elements=60, n_times=12)


@problem("paper", ["exact", "elements"], slow=["elements"])
def plane(random: Random, method: Any) -> Any:
    nu, p2, p3 = random.uniform(0.0, 0.5, 12), power(random, -2.0, 1.0, 12), power(random, -2.0, 2.0, 12)
    n = 12 if method == "exact" else 2
    return rs.standard_solid_restitution(nu[:n], p2[:n], p3[:n], method=method)


@problem("paper")
def surrogate_of_the_plane(random: Random, _: int) -> Any:
    nu, p2, p3 = random.uniform(0.0, 0.5, 12), power(random, -2.0, 1.0, 12), power(random, -2.0, 2.0, 12)
    return rs.standard_solid_surrogate(nu, p2, p3)


@problem("paper")
def closed_forms(random: Random, _: int) -> Any:
    forms = rs.closed_forms
    modulus, mass, velocity = power(random, 5.0, 7.0, 3), power(random, -3.0, -1.0, 3), power(random, -2.0, 0.0, 3)
    depth = forms.elastic_max_indentation_depth(modulus, np.sqrt(0.01), mass, velocity, path_exponent=0.5)
    damping, nu = power(random, -2.0, 0.5, 4), random.uniform(-0.5, 0.5, 4)
    return {
        "depth": depth,
        "time": forms.elastic_contact_time(depth, velocity, path_exponent=0.5),
        "force": forms.elastic_max_force(depth, mass, velocity, path_exponent=0.5),
        "kelvin_voigt": forms.kelvin_voigt_first_order_restitution(1e-5, depth, velocity, path_exponent=0.5),
        "hunter": forms.hunter_restitution(1e6, [1e5, 2e5], [1.0, 3.0], 1e-3),
        "punch_kelvin_voigt": forms.flat_punch_kelvin_voigt_restitution(damping),
        "punch_maxwell": forms.flat_punch_maxwell_restitution(damping),
        "small_p3": forms.standard_solid_small_p3_slope(nu),
        "large_p3": forms.standard_solid_large_p3_slope(nu, power(random, -2.0, 1.0, 4)),
        "equivalent_p3": forms.equivalent_incompressible_p3(damping),
        "mueller_poeschel": forms.mueller_poeschel_restitution(damping),
        "groups": rs.dimensionless_groups(rs.Impact(solid(random), rs.Parabola(0.01), mass, velocity)),
    }
