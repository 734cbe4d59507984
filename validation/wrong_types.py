"""Objects of wrong and of unusual types for every parameter of the public functions.

Each public function has a call that works. A bad call has one object in place of one argument: an object of another
type, of another shape, of a foreign unit, or one whose methods raise. It must return, or raise an `InputError` (or a
`SolverError`) of one line. A good call has a number in another container, such as a quantity of pint or a masked
array, and must give the same result to 1e-12. Calls in threads and pickled results must have the same bits.

    python validation/wrong_types.py --seed 1 --calls 7000 --out validation/wrong_types.md
"""

from __future__ import annotations

import argparse
import datetime
import decimal
import fractions
import functools
import inspect
import io
import os
import pathlib
import pickle
import random
import tempfile
import time
import warnings
from collections import Counter
from collections.abc import Callable, Iterator
from concurrent.futures import ThreadPoolExecutor
from contextlib import redirect_stderr, redirect_stdout
from typing import Any, NamedTuple

import numpy as np
import pandas as pd
import pint
import xarray as xr

import restitution as rs

UNITS = pint.UnitRegistry()
ADMISSIBLE = (rs.InputError, rs.SolverError, OSError)


class Call(NamedTuple):
    """A function with arguments that work; whether numbers at the ends of the range of a double are tried too."""

    name: str
    function: Callable[..., Any]
    arguments: dict[str, Any]
    extreme: bool = True


class Hostile:
    """Object whose conversions raise."""

    def __array__(self, *_: Any, **__: Any) -> Any:
        raise RuntimeError("no array")

    def __float__(self) -> float:
        raise RuntimeError("no float")

    def __repr__(self) -> str:
        raise RuntimeError("no text")

    __str__ = __repr__

    def __len__(self) -> int:
        raise RuntimeError("no length")

    def __bool__(self) -> bool:
        raise RuntimeError("no truth")

    def __eq__(self, other: object) -> bool:
        raise RuntimeError("no comparison")

    def __hash__(self) -> int:
        raise RuntimeError("no hash")


class Endless:
    """Iterable whose iteration raises."""

    def __iter__(self) -> Iterator[Any]:
        raise RuntimeError("no iteration")


EXTREME = ("1e308", "5e-324")


def bad_objects() -> dict[str, Any]:
    """Objects of types, shapes and units that are wrong for most parameters."""
    return {
        "None": None,
        "True": True,
        "text": "abc",
        "number as text": "1",
        "empty text": "",
        "bytes": b"1",
        "bytearray": bytearray(b"1"),
        "list": [1.0, 2.0],
        "empty list": [],
        "nested list": [[1.0], [2.0, 3.0]],
        "list of texts": ["a", "b"],
        "list of None": [None, 1.0],
        "tuple of one": (1.0,),
        "tuple of three": (1.0, "a", None),
        "set": {1.0},
        "dict": {"a": 1},
        "dict of a list": {"a": [1, 2]},
        "dict with a key of another type": {1: 2.0},
        "range": range(3),
        "generator": (x for x in (1.0,)),
        "Endless": Endless(),
        "Hostile": Hostile(),
        "list of Hostile": [Hostile()],
        "object": object(),
        "type": int,
        "function": lambda: 1.0,
        "function of one": lambda x: "a",
        "module": np,
        "nan": float("nan"),
        "inf": float("inf"),
        "-1": -1.0,
        "0": 0,
        "1e308": 1e308,
        "5e-324": 5e-324,
        "10**400": 10**400,
        "complex": 1 + 2j,
        "Decimal NaN": decimal.Decimal("sNaN"),
        "Fraction": fractions.Fraction(1, 3),
        "datetime": datetime.datetime(2020, 1, 1),
        "timedelta": datetime.timedelta(seconds=1),
        "timedelta64": np.timedelta64(1, "s"),
        "datetime64": np.datetime64("2020-01-01"),
        "void": np.void(b"ab"),
        "array": np.array([1, 2]),
        "array of no dimension": np.array(1.0),
        "empty array": np.empty(0),
        "array of shape (2, 0, 3)": np.empty((2, 0, 3)),
        "array of objects": np.array([object(), None], dtype=object),
        "array of texts": np.array(["a", "b"]),
        "array of booleans": np.array([True, False]),
        "complex array": np.array([1j, 2.0]),
        "record array": np.zeros(2, dtype=[("a", float), ("b", int)]),
        "masked": np.ma.masked,
        "masked array": np.ma.array([1.0, 2.0], mask=[True, False]),
        "matrix": np.ones((2, 2)),
        "Series": pd.Series(["a", "b"]),
        "Series of NA": pd.Series([pd.NA, 1], dtype="Int64"),
        "DataFrame": pd.DataFrame({"a": [0.0, 1.0], "b": [1.0, 2.0]}),
        "NA": pd.NA,
        "NaT": pd.NaT,
        "Timestamp": pd.Timestamp("2020-01-01"),
        "DataArray": xr.DataArray([1.0], attrs={"units": "furlong"}),
        "Dataset": xr.Dataset({"a": ("x", [1.0])}),
        "quantity of a foreign unit": UNITS.Quantity(1.0, "candela"),
        "quantity without a unit": UNITS.Quantity(5.0, "dimensionless"),
        "quantities": [UNITS.Quantity(1.0, "candela"), 2.0],
        "unit": UNITS.meter,
        "path": pathlib.Path("no such file"),
        "file": io.StringIO("a"),
        "material": rs.elastic(shear_modulus=1e6, poisson_ratio=0.3),
        "profile": rs.Parabola(0.01),
    }


class Sub(np.ndarray[Any, Any]):
    """Subclass of an array."""


def good_objects(values: np.ndarray[Any, Any], unit: str) -> dict[str, Any]:
    """The same numbers in containers that users have; `values` are exact in single precision."""
    strided = np.repeat(values, 2)[::2]
    read_only = values.copy()
    read_only.setflags(write=False)
    results: dict[str, Any] = {
        "list": values.tolist(),
        "tuple": tuple(values.tolist()),
        "integers and numbers": [*values.tolist()[:-1], np.float32(values[-1])],
        "fractions": [fractions.Fraction(value) for value in values.tolist()],
        "decimals": [decimal.Decimal(value) for value in values.tolist()],
        "strided": strided,
        "reversed twice": values[::-1].copy()[::-1],
        "read-only": read_only,
        "big-endian": values.astype(">f8"),
        "subclass": values.view(Sub),
        "objects": values.astype(object),
        "masked array": np.ma.array(values),
        "Series": pd.Series(values),
        "Series with an odd index": pd.Series(values, index=[7, 3, 9][: values.size]),
        "Series Float64": pd.Series(values, dtype="Float64"),
        "Index": pd.Index(values),
        "DataArray": xr.DataArray(values),
        "DataArray with a unit": xr.DataArray(1e3 * values, attrs={"units": f"milli{unit}"}),
        "pint": UNITS.Quantity(values, unit),
        "pint, another unit": UNITS.Quantity(1e3 * values, f"milli{unit}"),
        "list of pint": [UNITS.Quantity(value, unit) for value in values],
        "memoryview": memoryview(values),
    }
    for kind in (np.float16, np.float32, np.longdouble):
        results[kind.__name__] = values.astype(kind)
    return results


_MATERIAL = rs.standard_solid(1e6, 1e7, 1e3, poisson_ratio=0.45)
_BALL = rs.Parabola(0.01)
# Slow enough for small strain, so that no call warns.
_IMPACT = rs.Impact(_MATERIAL, _BALL, mass=0.005, velocity=0.5)
_TIMES = np.geomspace(1e-3, 1.0, 12)
_TABLE = {"time": _TIMES, "modulus": 1e6 * (1.0 + 9.0 * np.exp(-_TIMES / 0.05))}


@functools.cache
def calls() -> list[Call]:
    """Public functions and classes with arguments that work and take little time."""
    body = rs.Body(_MATERIAL, 0.01, 0.005)
    ground = rs.Body(None)
    shift = rs.WLF(293.15, 17.4, 51.6)
    fractional = rs.FractionalMaterial(rs.fractional_maxwell(1e6, 1e-3, 0.4), 1e9)
    ball = {"radius": 0.01, "mass": 0.03}
    rebounds = rs.Rebounds([0.5, 1.0], [0.8, 0.78], **ball, contact_time=[1.1e-3, 0.96e-3])
    time = np.linspace(0.0, 2.8, 200)
    depth = np.interp(time, [0.0, 1.4, 2.8], [0.0, 1.4e-6, 0.0])
    force = np.maximum(depth - 4e-7, 0.0) ** 1.5
    curve = rs.IndentationCurve(time, depth, force, profile=rs.Parabola(2.5e-6))
    fixed = {"poisson_ratio": 0.5, "viscosity": 1e3, "branch_modulus": 1e3}
    omega = 2.0 * np.pi * np.geomspace(0.1, 100.0, 8)
    dma = {"angular_frequency": omega, "storage_modulus": 1e6 * omega**0.1, "loss_modulus": 2e5 * omega**0.1}
    candidates = {"velocity": [0.1, 1.0], "radius": 0.01, "mass": 0.005}
    solid = {"equilibrium_modulus": 1e6, "branch_modulus": 1e7, "viscosity": 1e3, "poisson_ratio": 0.45}
    two_radii = {"radius_1": 0.01, "radius_2": 0.02}
    series = rs.PronySeries(1e6, [1e7], [1e-3])
    return [
        Call("Arrhenius", rs.Arrhenius, {"activation_energy": 8e4, "reference_temperature": 293.15}),
        Call("Body", rs.Body, {"material": _MATERIAL, "radius": 0.01, "mass": 0.005}),
        Call("BounceTimes", rs.BounceTimes, {"time": [0.0, 0.4, 0.7, 0.95], **ball}),
        Call("Cone", rs.Cone, {"half_angle": 1.2}),
        Call("DynamicTable", rs.DynamicTable, dma),
        Call("Ellipsoid", rs.Ellipsoid, two_radii),
        Call("FlatEndedParabola", rs.FlatEndedParabola, {"radius": 0.01, "face_radius": 1e-3}),
        Call("FlatPunch", rs.FlatPunch, {"radius": 0.01}),
        Call("ForceLaw", rs.ForceLaw, {
            "depth": np.linspace(0.0, 1e-3, 12), "force": 1e4 * np.linspace(0.0, 1e-3, 12) ** 1.5,
            "modulus": 1e6, "poisson_ratio": 0.5,
        }),
        Call("FractionalMaterial.within", fractional.within, {"window": (1e-4, 1.0)}),
        Call("History.from_points", rs.History.from_points, {"time": [0.0, 1.0], "values": [0.0, 1e-6]}),
        Call("History.from_function", rs.History.from_function, {"function": lambda t: 1e-6 * t, "time": [0.0, 1.0]}),
        Call("Impact", rs.Impact, {"material": _MATERIAL, "profile": _BALL, "mass": 0.005, "velocity": 1.0}),
        Call("IndentationCurve", rs.IndentationCurve, {
            "time": time, "depth": depth, "force": force, "profile": rs.Parabola(2.5e-6),
        }),
        Call("Layer", rs.Layer, {"profile": _BALL, "thickness": 1e-3}),
        Call("Linear", rs.Linear, {"low": 0.1, "high": 1.0, "n": 3}),
        Call("LogNormal", rs.LogNormal, {"median": 1.0, "sigma": 0.1}),
        Call("LogUniform", rs.LogUniform, {"low": 0.1, "high": 1.0}),
        Call("Logarithmic", rs.Logarithmic, {"low": 0.1, "high": 1.0, "n": 3}),
        Call("Material", rs.Material, {"shear": series, "bulk": 1e9}),
        Call("Noise", rs.Noise, {"force": 1e-11}),
        Call("Normal", rs.Normal, {"mean": 1.0, "standard_deviation": 0.1}),
        Call("Parabola", rs.Parabola, {"radius": 0.01}),
        Call("PowerLaw", rs.PowerLaw, {"exponent": 2.0, "coefficient": 50.0}),
        Call("PronySeries", rs.PronySeries, {
            "equilibrium_modulus": 1e6, "branch_moduli": [1e7], "relaxation_times": [1e-3],
        }),
        Call("Pyramid", rs.Pyramid, {"face_angle": 1.2}),
        Call("Rebounds", rs.Rebounds, {"velocity": [0.5, 1.0], "restitution_coefficient": [0.8, 0.78], **ball}),
        Call("RelaxationTable", rs.RelaxationTable, _TABLE),
        Call("ShiftTable", rs.ShiftTable, {
            "temperatures": [273.0, 293.0, 313.0], "log10_factors": [1.0, 0.0, -1.0],
        }),
        Call("Sphere", rs.Sphere, {"radius": 0.01}),
        Call("Tabulated", rs.Tabulated, {"r": [0.0, 1e-3, 2e-3], "f": [0.0, 5e-5, 2e-4]}),
        Call("TruncatedCone", rs.TruncatedCone, {"radius": 1e-3, "half_angle": 1.2}),
        Call("Uniform", rs.Uniform, {"low": 0.1, "high": 1.0}),
        Call("WLF", rs.WLF, {"c1": 17.4, "c2": 51.6, "reference_temperature": 293.15}),
        Call("bounces", rs.bounces, {"impact": _IMPACT, "max_bounces": 2}),
        Call("burgers", rs.burgers, {
            "maxwell_modulus": 1e6, "maxwell_viscosity": 1e3, "kelvin_modulus": 1e6, "kelvin_viscosity": 1e3,
            "bulk_modulus": 1e9,
        }),
        Call("calibrate", rs.calibrate, {"problem": _IMPACT, "target": "lammps-tsuji", "velocity": (0.5, 1.0)}),
        Call("cite", rs.cite, {"subject": _IMPACT}),
        Call("collision", rs.collision, {"body_1": body, "body_2": body, "velocity": 1.0}),
        Call("contact_law", rs.contact_law, {"problem": _IMPACT}),
        Call("crossed_cylinders", rs.crossed_cylinders, two_radii),
        Call("design", rs.design, {
            "model_at_guess": functools.partial(rs.standard_solid, **solid), "candidates": candidates, "n": 4,
        }),
        Call("dimensionless_groups", rs.dimensionless_groups, {"impact": _IMPACT}),
        Call("drop", rs.drop, {"body": body, "ground": ground, "height": 0.1}),
        Call("effective_moduli", rs.effective_moduli, {"data": rebounds}),
        Call("elastic", rs.elastic, {"shear_modulus": 1e6, "poisson_ratio": 0.3}),
        Call("fit_prony", rs.fit_prony, {"data": rs.RelaxationTable(**_TABLE)}),
        Call("for_contact", rs.for_contact, {"build": lambda window: _IMPACT}),
        Call("fractional_maxwell", rs.fractional_maxwell, {
            "branch_modulus": 1e7, "relaxation_time": 1e-3, "exponent": 0.4,
        }),
        Call("generalised_maxwell", rs.generalised_maxwell, {
            "equilibrium_modulus": 1e6, "branch_moduli": [1e7], "relaxation_times": [1e-3], "poisson_ratio": 0.45,
        }),
        Call("hold", rs.hold, {"value": 1e-6, "duration": 1.0}),
        Call("identify", rs.identify, {
            "data": rebounds, "model": rs.standard_solid, "fixed": {"poisson_ratio": 0.5, "viscosity": 1e3},
            "profiles": False,
        }),
        Call("identify_map", rs.identify_map, {"curves": [curve], "model": rs.standard_solid, "fixed": fixed}),
        Call("implied_loss_tangent", rs.implied_loss_tangent, {"rebound_resilience": 50.0}),
        Call("indent", rs.indent, {
            "material": _MATERIAL, "profile": _BALL, "depth": [0.0, 1e-6], "time": [0.0, 1.0],
        }),
        Call("kelvin_voigt", rs.kelvin_voigt, {"shear_modulus": 1e6, "viscosity": 1e3, "poisson_ratio": 0.4}),
        Call("library.get", rs.library.get, {"name": "steel"}),
        Call("maxwell", rs.maxwell, {"shear_modulus": 1e6, "viscosity": 1e3, "bulk_modulus": 1e9}),
        Call("open_sweep", rs.open_sweep, {"path": "none.zarr"}),
        Call("plate_impedance", rs.plate_impedance, {"material": rs.library.get("steel"), "thickness": 0.01}),
        Call("plot_sweep", rs.plot_sweep, {"dataset": rs.sweep(_IMPACT, {"velocity": [0.1, 0.5]})}),
        Call("ramp", rs.ramp, {"value": 1e-6, "duration": 1.0}),
        Call("read_case", rs.read_case, {"path": "none.toml"}),
        Call("read_curves", rs.read_curves, {"path": "none.jpk", "profile": _BALL}),
        Call("read_material", rs.read_material, {"path": "none.csv"}),
        Call("read_observations", rs.read_observations, {"path": "none.csv"}),
        Call("reduced_modulus", rs.reduced_modulus, {"material": _MATERIAL}),
        Call("resilience", rs.resilience, {"material": rs.library.get("steel")}),
        Call("rod_impedance", rs.rod_impedance, {"material": rs.library.get("steel"), "area": 0.01}),
        Call("shear_from_tension", rs.shear_from_tension, {"tension": series, "poisson_ratio": 0.4}),
        Call("sine_arch", rs.sine_arch, {"peak": 1e-6, "duration": 1.0}),
        Call("solve", rs.solve, {"impact": _IMPACT, "method": "exact", "rtol": 1e-6}),
        Call("springpot", rs.springpot, {"coefficient": 1e6, "exponent": 0.4}),
        Call("standard_solid", rs.standard_solid, solid),
        Call("standard_solid_restitution", rs.standard_solid_restitution, {"nu": 0.4, "p2": 0.1, "p3": 1.0}),
        Call("standard_solid_surrogate", rs.standard_solid_surrogate, {"nu": 0.4, "p2": 0.1, "p3": 1.0}),
        Call("surrogate", rs.surrogate, {"impact": _IMPACT, "velocity": (0.9, 1.0), "rtol": 1e-2}),
        Call("Surrogate.load", rs.Surrogate.load, {"path": "none.json"}),
        Call("sweep", rs.sweep, {"base": _IMPACT, "axes": {"velocity": [0.5, 1.0]}, "outputs": ["max_force"]}),
        Call("tension_from_shear", rs.tension_from_shear, {"shear": series, "poisson_ratio": 0.4}),
        Call("triangle", rs.triangle, {"peak": 1e-6, "loading_time": 1.0}),
        Call("write_material", rs.write_material, {"material": _MATERIAL, "path": "m.inp"}),
        Call("write_table", rs.write_table, {"dataset": xr.Dataset({"a": ("x", [1.0])}), "path": "t.csv"}),
        Call("ImpactResult.sample", rs.solve(_IMPACT).sample, {}),
        Call("ContactLaw.to_c", rs.contact_law(_IMPACT).to_c, {"path": "law.h", "name": "law"}),
        Call("WLF.factor", shift.factor, {"temperature": 300.0}),
        *(call._replace(extreme=False) for call in (*_methods(), *_further())),
    ]  # fmt: skip


def _methods() -> list[Call]:
    """Methods of public objects that take numbers, names or files."""
    series, law, report = rs.PronySeries(1e6, [1e7], [1e-3]), rs.contact_law(_IMPACT), rs.solve(_IMPACT)
    rubber, history = rs.library.get("polyisobutylene"), rs.History.from_points([0.0, 1.0, 2.0], [0.0, 1e-6, 0.0])
    pressed = rs.indent(_MATERIAL, _BALL, depth=[0.0, 1e-6, 0.0], time=[0.0, 1.0, 2.0])
    rebounds = rs.Rebounds(
        [0.5, 1.0, 0.7], [0.8, 0.78, 0.79], radius=0.01, mass=0.03, contact_time=[1.1e-3, 0.96e-3, 1e-3]
    )
    fixed = {"poisson_ratio": 0.5, "viscosity": 1e3}
    fit = rs.identify(rebounds, rs.standard_solid, fixed=fixed, profiles=False)
    surrogate, code = (
        rs.surrogate(_IMPACT, (0.5, 1.0), rtol=1e-2),
        rs.calibrate(_IMPACT, "liggghts", velocity=(0.5, 1)),
    )
    by, depth, frequency = rs.derivatives(_IMPACT, ["velocity"]), {"depth": 1e-5}, {"angular_frequency": 1.0}
    pair = ("restitution_coefficient", "velocity")
    return [
        Call("Material.at", rubber.at, {"temperature": 300.0}),
        Call("Material.shift_factor", rubber.shift_factor, {"temperature": 300.0}),
        Call("Material.relaxation_poisson_ratio", _MATERIAL.relaxation_poisson_ratio, {"time": 1.0}),
        Call("Material.wave_speed", rs.library.get("steel").wave_speed, {"time": 1.0}),
        Call("PronySeries.complex_modulus", series.complex_modulus, frequency),
        Call("PronySeries.loss_tangent", series.loss_tangent, frequency),
        Call("PronySeries.relaxation_modulus", series.relaxation_modulus, {"time": 1.0}),
        Call("PronySeries.creep_compliance", series.creep_compliance, {"time": 1.0}),
        Call("PronySeries.carson_transform", series.carson_transform, {"s": 1.0}),
        Call("PronySeries.plot", series.plot, {"window": (1e-3, 1.0)}),
        Call("Parabola.contact_radius", _BALL.contact_radius, depth),
        Call("Parabola.shape", _BALL.shape, {"r": 1e-4}),
        Call("Parabola.transform", _BALL.transform, {"x": 1e-4}),
        Call("Ellipsoid.contact_radius", rs.Ellipsoid(0.01, 0.02).contact_radius, depth),
        Call("Pyramid.force_integral_at_depth", rs.Pyramid(face_angle=1.2).force_integral_at_depth, depth),
        Call("ImpactResult.pressure", report.pressure, {"r": 1e-5, "t": 1e-4}),
        Call("ImpactResult.surface", report.surface, {"after": 1.0}),
        Call("ImpactResult.surface_displacement", report.surface_displacement, {"r": 1e-5, "t": 1e-4}),
        Call("ImpactResult.to_dataset", report.to_dataset, {"outputs": ["max_force"]}),
        Call("ImpactResult.validity_on", report.validity_on, {"body_size": 0.1}),
        Call("ImpactResult.plot", report.plot, {"times": [1e-4]}),
        Call("IndentationResult.sample", pressed.sample, {"times": [0.1]}),
        Call("IndentationResult.imprint", pressed.imprint, {"time": 1.9, "radius": 1e-5}),
        Call("History", history, {"time": 0.5}),
        Call("History.until", history.until, {"time": 0.5}),
        Call("ContactLaw.start", law.start, {"contacts": 3}),
        Call("ContactLaw.reduced", law.reduced, {"terms": 1}),
        Call("Surrogate", surrogate, {"velocity": 0.6}),
        Call("Surrogate.compiled", surrogate.compiled, {"output": "max_force"}),
        Call("Surrogate.sample", surrogate.sample, {"n": 5}),
        Call("Surrogate.save", surrogate.save, {"path": "s.json"}),
        Call("Identification.interval", fit.interval, {"level": 0.9}),
        Call("Identification.moduli", fit.moduli, frequency),
        Call("Identification.predict", fit.predict, {"impact": _IMPACT}),
        Call("Identification.profile", fit.profile, {"name": "branch_modulus"}),
        Call("Identification.log_probability", fit.log_probability, {"coordinates": fit.coordinates}),
        Call("Identification.to_toml", fit.to_toml, {"path": "a.toml"}),
        Call("Calibration.contact_time", code.contact_time, {"velocity": 0.6, "radius": 0.01}),
        Call("Calibration.to_json", code.to_json, {"path": "c.json"}),
        Call("Validity[]", report.validity.__getitem__, {"kind": "waves"}),
        Call("Derivatives[]", by.__getitem__, {"pair": pair}),
    ]


def _further() -> list[Call]:
    """Public functions and classes beside those of impacts and materials in `calls`."""
    grain = rs.Impact(
        rs.standard_solid(1e9, 1e9, 10.0, poisson_ratio=0.35), rs.Parabola(5e-6), mass=6e-13, velocity=0.5,
        adhesion=rs.Adhesion(work=0.05, stress=1e7),
    )  # fmt: skip
    time, kelvin, two = np.linspace(0.0, 1.6e-3, 40), [270.0, 280.0, 290.0], np.ones(2)
    mode = {"spring_constant": 1.0, "frequency": 5e4}
    return [
        Call("Adhesion", rs.Adhesion, {"work": 0.05, "stress": 1e8}),
        Call("CantileverMode", rs.CantileverMode, mode | {"quality_factor": 50.0}),
        Call("CreepTable", rs.CreepTable, {"time": _TIMES, "compliance": 2e-6 - 1e-6 * np.exp(-_TIMES)}),
        Call("ForceHistory", rs.ForceHistory, {
            "time": time, "force": 59.0 * np.sin(np.pi * time / 1.6e-3), "radius": 0.01, "mass": 0.03, "velocity": 1.0,
        }),
        Call("Isotherms", rs.Isotherms, {"tables": [
            rs.RelaxationTable(_TIMES, _TABLE["modulus"], temperature=each) for each in (293.0, 303.0)
        ]}),
        Call("Oscillations", rs.Oscillations, {
            "frequency": [1.0, 2.0], "depth": 1e-5 * two, "depth_amplitude": 1e-6 * two,
            "force_amplitude": 1e-3 * two, "phase": 0.1 * two, "radius": 0.01,
        }),
        Call("Samples", rs.Samples, {"n": 4, "distributions": {"velocity": rs.Normal(1.0, 0.1)}}),
        Call("TemperatureRamp", rs.TemperatureRamp, {
            "temperatures": kelvin, "storage_modulus": [3e6, 2e6, 1e6], "loss_modulus": [3e5, 2e5, 1e5],
        }),
        Call("beam_modes", rs.beam_modes, mode | {"quality_factors": [50.0, 100.0]}),
        Call("cycles", rs.cycles, {"peak": 1e-6, "loading_time": 1.0, "count": 2}),
        Call("derivatives", rs.derivatives, {"impact": _IMPACT, "names": ["velocity"]}),
        Call("dundurs_parameter", rs.dundurs_parameter, {"material": _MATERIAL}),
        Call("element_history", rs.element_history, {"impact": _IMPACT, "n_elements": 50, "n_times": 10}),
        Call("hollow_gyration", rs.hollow_gyration, {"inner_radius": 0.01, "outer_radius": 0.02}),
        Call("oscillate", rs.oscillate, {
            "material": _MATERIAL, "profile": _BALL, "depth": 1e-5, "amplitude": 1e-6, "frequency": 1.0,
        }),
        Call("plot_restitution", rs.plot_restitution, {"impact": _IMPACT}),
        Call("read_bounces", rs.read_bounces, {"path": "none.wav"}),
        Call("read_points", rs.read_points, {"path": "none.csv"}),
        Call("reduced_shear_modulus", rs.reduced_shear_modulus, {"material": _MATERIAL}),
        Call("restitution_band", rs.restitution_band, {"impact": _IMPACT}),
        Call("shore_modulus", rs.shore_modulus, {"hardness": 60.0, "scale": "A"}),
        Call("sticking_velocity", rs.sticking_velocity, {"impact": grain, "rtol": 1e-2}),
        Call("uncertainty", rs.uncertainty, {"impact": _IMPACT, "inputs": {"velocity": 0.01}}),
        Call("vary", rs.vary, {"impact": _IMPACT, "numbers": {"velocity": 0.1}}),
    ]  # fmt: skip


def parameters(call: Call) -> list[str]:
    """Names of the parameters of a function: those that it has, and those of its good call."""
    kinds = (inspect.Parameter.POSITIONAL_OR_KEYWORD, inspect.Parameter.KEYWORD_ONLY)
    try:
        signature = inspect.signature(call.function).parameters.values()
        results = [each.name for each in signature if each.kind in kinds and not each.name.startswith("_")]
    except (TypeError, ValueError):
        results = []
    return list(dict.fromkeys([*results, *call.arguments]))


def run(call: Call, arguments: dict[str, Any]) -> tuple[str, Any]:
    """Call a function: the name and text of a foreign exception, or an empty text and the result."""
    try:
        with warnings.catch_warnings(), redirect_stdout(io.StringIO()), redirect_stderr(io.StringIO()):
            warnings.simplefilter("error")
            # What the package warns of is no fault; NumPy's own warnings are.
            warnings.simplefilter("ignore", UserWarning)
            if call.name == "cite":
                return "", call.function(arguments["subject"])
            return "", call.function(**arguments)
    except ADMISSIBLE as error:
        try:
            return ("" if "\n" not in str(error) or " faults" in str(error) else f"lines: {error}"), None
        except Exception as second:
            return f"{type(second).__name__} in the message", None
    except Exception as error:
        try:
            return f"{type(error).__name__}: {' '.join(str(error).split())[:100]}", None
        except Exception:
            return type(error).__name__, None


def bad_calls(count: int | None, seed: int, names: set[str] | None = None) -> tuple[int, Counter[str], float]:
    """Number of bad calls, foreign exceptions by function, parameter and object, and the longest time [s]."""
    every = [
        (call, name, kind)
        for call in calls()
        if names is None or call.name in names
        for name in parameters(call)
        for kind in bad_objects()
        if call.extreme or kind not in EXTREME
    ]
    chosen = every if count is None or count >= len(every) else random.Random(seed).sample(every, count)
    faults: Counter[str] = Counter()
    longest = 0.0
    unused: dict[str, Any] = {}
    for call, name, kind in chosen:
        # Each object serves once, as a call may use it up; to make all of them takes longer than most calls.
        if kind not in unused:
            unused = bad_objects()
        start = time.perf_counter()
        fault, _ = run(call, call.arguments | {name: unused.pop(kind)})
        longest = max(longest, time.perf_counter() - start)
        if fault:
            faults[f"`{call.name}({name}=<{kind}>)`: {fault}"] += 1
    return len(chosen), faults, longest


def good_calls(seed: int) -> tuple[int, list[str]]:
    """Number of good calls, and those whose result differs by more than 1e-12 from that of plain numbers."""
    rng = np.random.default_rng(seed)
    wrong: list[str] = []
    number = 0
    for field, unit in (("velocity", "m/s"), ("mass", "kg"), ("radius", "m")):
        # Multiples of 2^-10 are exact in half precision; a thousandth is not, but the product with 1e3 is.
        values = np.sort(rng.integers(64, 1024, 3)) / 1024.0
        plain = _restitution(field, values)
        for kind, argument in good_objects(values, {"m/s": "meter/second", "kg": "gram", "m": "meter"}[unit]).items():
            number += 1
            scale = 1e-3 if unit == "kg" and kind in _WITH_UNIT else 1.0
            expected = plain if scale == 1.0 else _restitution(field, scale * values)
            try:
                result = _restitution(field, argument)
                error = float(np.max(np.abs(np.asarray(result) / expected - 1.0)))
            except Exception as fault:
                wrong.append(f"`{field}` as {kind}: {type(fault).__name__}: {fault}")
                continue
            if not error <= 1e-12:
                wrong.append(f"`{field}` as {kind}: differs by {error:.1e}")
    return number, wrong


_WITH_UNIT = ("DataArray with a unit", "pint", "pint, another unit", "list of pint")


def _restitution(field: str, values: Any) -> Any:
    arguments: dict[str, Any] = {"velocity": 1.0, "mass": 0.005, "radius": 0.01} | {field: values}
    radius = arguments.pop("radius")
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", UserWarning)
        return rs.solve(rs.Impact(_MATERIAL, rs.Parabola(radius), **arguments)).restitution_coefficient


def same_bits(seed: int, count: int = 200) -> list[str]:
    """Results in threads and after a pickle that differ from those in this thread."""
    velocities = np.random.default_rng(seed).uniform(0.01, 10.0, count).tolist()
    impacts = [rs.Impact(_MATERIAL, _BALL, mass=0.005, velocity=each) for each in velocities]
    plain = [rs.solve(each).restitution_coefficient for each in impacts]
    with ThreadPoolExecutor(8) as pool:
        threaded = [each.restitution_coefficient for each in pool.map(rs.solve, impacts)]
    pickled = [rs.solve(pickle.loads(pickle.dumps(each))).restitution_coefficient for each in impacts[:20]]
    wrong = [f"thread: velocity {v!r}" for v, a, b in zip(velocities, plain, threaded, strict=True) if a != b]
    wrong += [f"pickle: velocity {v!r}" for v, a, b in zip(velocities, plain, pickled, strict=False) if a != b]
    return wrong


def main() -> None:
    """Run and write the table."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--calls", type=int, help="number of bad calls, all by default")
    parser.add_argument("--out", type=pathlib.Path)
    options = parser.parse_args()
    out = None if options.out is None else options.out.resolve()
    with tempfile.TemporaryDirectory() as folder:
        os.chdir(folder)
        bad, faults, longest = bad_calls(options.calls, options.seed)
        os.chdir("/")
    good, differ = good_calls(options.seed)
    bits = same_bits(options.seed)
    lines = [
        "# Wrong and unusual types",
        "",
        f"Made by `python validation/wrong_types.py --seed {options.seed}`: public functions and methods, every "
        f"parameter with each of {len(bad_objects())} objects of a wrong type.",
        "",
        "| calls | number | faults |",
        "|---|---|---|",
        f"| bad: return, or an InputError of one line | {bad} | {sum(faults.values())} |",
        f"| good: the same e to 1e-12 | {good} | {len(differ)} |",
        f"| 8 threads, pickles: the same bits | 220 | {len(bits)} |",
        "",
        f"The longest bad call took {longest:.1f} s.",
        *(f"* {line}" for line in (*sorted(faults), *differ, *bits)),
    ]
    print("\n".join(lines))
    if out is not None:
        out.write_text("\n".join(lines) + "\n", encoding="utf-8")


if __name__ == "__main__":
    main()
