"""Bounces, prescribed indentations, contact laws, calibrations and rebound resilience."""

from __future__ import annotations

import math
import tempfile
from pathlib import Path
from typing import Any

import numpy as np

import restitution as rs
from recorded_problems.draws import material, of_validity, power, profile, rubber, series, solid
from recorded_problems.registry import Random, problem

# Rounding decides whether the turning time falls on a time of the columns, which then have one row less. Under a force
# it also decides whether the velocity of first touch is infinite or huge.
INDENTATION: dict[str, Any] = {"rtol": 1e-7, "columns.": math.inf}
PAD = rs.Material(
    rs.PronySeries(0.6e6, [0.06e6, 0.08e6, 0.12e6, 0.25e6, 0.8e6, 3e6], [1.0, 0.1, 1e-2, 1e-3, 1e-4, 1e-5]),
    math.inf,
    shift=rs.WLF(293.0, 6.0, 100.0),
)


@problem("bounces", ["parabola", "cone", "layer, bonded", "ellipsoid", "tabulated"])
def bounces(random: Random, kind: str) -> Any:
    stiff = rs.standard_solid(2.5e7, 2.5e7, 2.5e3, poisson_ratio=0.5)
    hit = rs.Impact(stiff, profile(random, kind), 0.005, power(random, -1.0, 0.0))
    result = rs.bounces(hit, max_bounces=25)
    return {"table": result.to_dataset(), "validity": of_validity(result)}


@problem("bounces", ["captured", "no weight", "height", "gravity"])
def bounces_until(random: Random, kind: str) -> Any:
    options: dict[str, Any] = {
        "captured": {},
        "no weight": {"with_weight": False, "max_bounces": 12},
        "height": {"height": power(random, -2.0, -1.0), "max_bounces": 12, "min_height": 1e-6},
        "gravity": {"height": 0.05, "gravity": 1.62},
    }[kind]
    hit = rs.Impact(rubber(random), rs.Parabola(0.01), 0.005, power(random, -0.5, 0.3))
    result = rs.bounces(hit, **options)
    return {"table": result.to_dataset(), "height": result.height, "n": result.n_bounces, "drop": result.drop_height}


def of_indentation(result: Any, random: Random) -> dict[str, Any]:
    """Numbers of an indentation."""
    low, high = result.time[0], result.time[-1]
    moments = np.sort(random.uniform(low, high, 7))
    names = ("max_force", "max_indentation_depth", "max_contact_radius", "residual_indentation_depth", "turning_time",
             "contact_end_time", "work", "status")  # fmt: skip
    names += ("dissipated", "stored") if result.prescribed == "depth" else ()
    columns = ("time", "indentation_depth", "indentation_velocity", "force", "contact_radius")
    return {name: getattr(result, name) for name in names} | {
        "columns": {name: getattr(result, name) for name in columns},
        "sample": result.sample(moments),
        "validity": of_validity(result),
    }


DEPTHS = ("triangle", "slow unloading", "trapezoid", "ramp", "hold", "hold after a ramp", "sine_arch", "points",
          "function", "number")  # fmt: skip


def history(kind: str, peak: float, time: float) -> dict[str, Any]:
    """Arguments of a history."""
    moments = np.linspace(0.0, 2.0 * time, 41)
    return {
        "triangle": lambda: {"depth": rs.triangle(peak, time)},
        "slow unloading": lambda: {"depth": rs.triangle(peak, time, unloading_time=3.0 * time)},
        "trapezoid": lambda: {"depth": rs.triangle(peak, time, hold_time=0.5 * time)},
        "ramp": lambda: {"depth": rs.ramp(peak, time)},
        "hold": lambda: {"depth": rs.hold(peak, time)},
        "hold after a ramp": lambda: {"depth": rs.hold(peak, time, rise_time=0.2 * time)},
        "sine_arch": lambda: {"depth": rs.sine_arch(peak, time)},
        "points": lambda: {
            "depth": peak * np.interp(moments, [0.0, time, 2.0 * time], [-0.2, 1.0, -0.2]),
            "time": moments,
        },
        "function": lambda: {
            "depth": lambda t: peak * (1.0 - (t / time - 1.0) ** 2),
            "time": np.linspace(0.0, 2.0 * time, 9),
        },
        "number": lambda: {"depth": peak, "time": np.linspace(0.0, time, 9)},
    }[kind]()


@problem("indentation", DEPTHS, **INDENTATION)
def prescribed_depth(random: Random, kind: str) -> Any:
    options = history(kind, power(random, -4.5, -3.5), power(random, -3.0, 0.0))
    ball = rs.Parabola(power(random, -2.3, -1.7))
    return of_indentation(rs.indent(rubber(random), ball, **options), random)


@problem("indentation", ["3 branches", "maxwell", "bulk relaxes", "kelvin_voigt", "springpot", "25 branches, liquid"],
         **INDENTATION)  # fmt: skip
def depth_on(random: Random, kind: str) -> Any:
    options = history("sine_arch", power(random, -4.5, -3.5), power(random, -3.0, -1.0))
    other = material(random, "3 branches") if kind == "bulk relaxes" else None
    result = rs.indent(material(random, kind), rs.Parabola(0.01), counter_material=other, **options)
    return of_indentation(result, random)


@problem("indentation", ["sphere", "cone", "power law", "flat punch", "flat-ended parabola", "noisy tip", "ellipsoid",
                         "pyramid 4", "force law, exponent", "layer, bonded", "layer, frictionless",
                         "layer under a flat end"], **INDENTATION)  # fmt: skip
def depth_of(random: Random, kind: str) -> Any:
    options = history("triangle", power(random, -4.5, -3.5), power(random, -3.0, -1.0))
    return of_indentation(rs.indent(solid(random, poisson_ratio=0.5), profile(random, kind), **options), random)


@problem("indentation", ["triangle", "steps", "sine_arch", "hold"], **INDENTATION)
def prescribed_force(random: Random, kind: str) -> Any:
    peak, time = power(random, -2.0, 0.0), power(random, -3.0, 0.0)
    force: Any = {
        "triangle": {"force": rs.triangle(peak, time)},
        "steps": {"force": [0.0, peak, peak, 0.0, 0.0], "time": np.array([0.0, 0.0, 1.0, 1.0, 3.0]) * time},
        "sine_arch": {"force": rs.sine_arch(peak, time)},
        "hold": {"force": rs.hold(peak, time, rise_time=0.1 * time)},
    }[kind]
    return of_indentation(rs.indent(rubber(random), rs.Parabola(0.01), **force), random)


@problem("indentation", ["cone", "ellipsoid", "layer, bonded", "force law, exponent"], **INDENTATION)
def force_of(random: Random, kind: str) -> Any:
    force = rs.triangle(power(random, -2.0, -0.5), power(random, -3.0, 0.0))
    result = rs.indent(solid(random, poisson_ratio=0.5), profile(random, kind), force=force)
    return of_indentation(result, random)


@problem("indentation")
def histories(random: Random, _: int) -> Any:
    time = np.cumsum(random.uniform(0.1, 1.0, 6))
    target = rs.History.from_points(time, random.normal(size=6))
    arch = rs.sine_arch(2.0, 3.0)
    moments = np.linspace(target.start, target.stop, 9)
    return {"points": target(moments), "rate": target.rate(moments), "arch": arch(np.linspace(0.0, 3.0, 7))}


@problem("law", ["standard solid", "5 branches", "parallel dashpot", "cone", "sphere", "layer"], rtol=1e-8)
def contact_law(random: Random, kind: str) -> Any:
    profiles = {"cone": lambda: rs.Cone(1.2), "sphere": lambda: rs.Sphere(0.01),
                "layer": lambda: rs.Layer(rs.Parabola(0.01), 0.005)}  # fmt: skip
    targets = {"5 branches": lambda: rubber(random), "parallel dashpot": lambda: material(random, "parallel dashpot")}
    target = targets.get(kind, lambda: solid(random, poisson_ratio=0.5))()
    hit = rs.Impact(target, profiles.get(kind, lambda: rs.Parabola(0.01))(), 0.005, 0.1)
    exact, law = rs.solve(hit), rs.contact_law(hit)
    dt = exact.contact_time / 50.0
    state, depth, velocity, force, forces = law.start(), 0.0, 0.1, 0.0, []
    for _ in range(140):  # a spring far above the contact pushes the body back, so that it loads again
        depth += velocity * dt - 0.5 * force / 0.005 * dt**2
        before, force = force, float(law.step(state, depth, dt))
        pull = -0.1 if depth < 0.0 else 0.0
        velocity -= 0.5 * (before + force) / 0.005 * dt + 0.02 * pull
        forces.append(force)
    return {"force": np.array(forces), "depth": depth, "velocity": velocity, "size": law.state_size}


@problem("law", [1, 2], rtol=1e-5)
def reduced_law(random: Random, terms: int) -> Any:
    law = rs.contact_law(rs.Impact(rubber(random), rs.Parabola(0.01), 0.005, np.array([0.05, 0.5])))
    small = law.reduced(terms, extrapolate=True)
    return {"modulus": small.modulus, "error": small.restitution_error}


@problem("law")
def law_in_c(random: Random, _: int) -> Any:
    law = rs.contact_law(rs.Impact(rubber(random), rs.Parabola(0.01), 0.005, 0.1))
    with tempfile.TemporaryDirectory() as folder:
        text = law.to_c(Path(folder) / "law.h").read_text()
    return {"lines": len(text.splitlines()), "constants": law.constants}


TARGETS = ("lammps-viscoelastic", "lammps-tsuji", "lammps-coeff-restitution", "liggghts", "kratos-dem",
           "mercury-bshp", "yade-mindlin", "mujoco-solref", "rebound")  # fmt: skip


@problem("calibration", TARGETS, rtol=1e-6, slow=["lammps-tsuji", "mujoco-solref"])
def calibrate(random: Random, target: str) -> Any:
    grain = rs.standard_solid(1e6, power(random, 6.0, 6.8), 500.0, poisson_ratio=0.49, density=1100.0)
    bead = rs.Body(grain, radius=0.001)
    law = rs.calibrate((bead, bead), target, velocity=(0.02, 0.2), points=9)
    result = {"e": law.restitution_coefficient(np.array([0.03, 0.1])), "error": law.largest_error}
    return result | {"parameters": {name: parameter.value for name, parameter in law.parameters.items()}}


@problem("calibration", ["wall", "radius", "restitution"], rtol=1e-6)
def calibrate_with(random: Random, kind: str) -> Any:
    target = rs.standard_solid(1e6, power(random, 6.0, 6.8), 500.0, poisson_ratio=0.49, density=1100.0)
    bead = rs.Body(target, radius=0.001)
    options: Any = {"wall": {"contact": "wall"}, "radius": {"radius": (0.001, 0.003)},
                    "restitution": {"restitution": 0.7}}[kind]  # fmt: skip
    law = rs.calibrate((bead, bead), "lammps-viscoelastic", velocity=(0.02, 0.2), points=9, **options)
    return {
        "error": law.largest_error,
        "parameters": {name: parameter.value for name, parameter in law.parameters.items()},
    }


@problem("resilience", ["ISO 4662", "DIN 53512", "ASTM D2632", "ISO 8307", "ASTM D3574"])
def resilience(random: Random, standard: str) -> Any:
    options: Any = {"tip_radius": 0.005, "mass": 0.028} if standard == "ASTM D2632" else {}
    result = rs.resilience(PAD, standard, temperature=random.uniform(270.0, 330.0, 2), **options)
    return {"table": result.to_dataset(), "validity": of_validity(result), "frequency": result.frequency}


@problem("resilience", ["bonded", "frictionless", "half-space"])
def resilience_on(random: Random, base: str) -> Any:
    rest = rs.Material(series(random, 4), math.inf)
    return rs.resilience(rest, "ASTM D7121", base=base, thickness=power(random, -2.3, -1.7)).to_dataset()


@problem("resilience")
def implied_loss_tangent(random: Random, _: int) -> Any:
    return [rs.implied_loss_tangent(item) for item in random.uniform(5.0, 95.0, 6)]
