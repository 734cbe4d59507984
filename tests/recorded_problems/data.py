"""Fits, identifications, files and cases."""

from __future__ import annotations

import contextlib
import io
import json
import math
import runpy
import sys
import tempfile
from functools import partial
from pathlib import Path
from typing import Any
from unittest import mock

import numpy as np

import restitution as rs
from recorded_problems.draws import material, of_impact, of_prony, of_validity, power, series
from recorded_problems.registry import Random, problem

EXAMPLES = Path(__file__).resolve().parents[2] / "examples"
INCOMPRESSIBLE = {"poisson_ratio": 0.5}
TRUTH = rs.standard_solid(1e6, 1e7, 1e4, poisson_ratio=0.5)


def of_fit(result: Any) -> dict[str, Any]:
    """Numbers of an identification."""
    estimates = result.parameters | result.nuisances
    item = {name: (each.value, each.standard_error, *each.interval) for name, each in estimates.items()}
    return {
        "value": {name: np.array([row[0]], dtype=float) for name, row in item.items()},
        "standard_error": {name: np.array([row[1]], dtype=float) for name, row in item.items()},
        "interval": {name: np.array(row[2:], dtype=float) for name, row in item.items()},
        "chi2": result.chi2,
        "degrees_of_freedom": result.degrees_of_freedom,
        "window": np.array(result.window, dtype=float),
        "functionals": {name: [each.value] for name, each in result.functionals.items() if each.value is not None},
    }


def bounced(random: Random, radius: Any, velocity: Any, target: Any = TRUTH, noise: float = 0.01) -> dict[str, Any]:
    """Measured restitution, contact time and largest force of steel balls."""
    mass = 7800.0 * 4.0 / 3.0 * np.pi * np.asarray(radius) ** 3
    result = rs.solve(rs.Impact(target, rs.Parabola(radius), mass, velocity))
    scatter = lambda values: values * np.exp(noise * random.standard_normal(np.shape(values)))  # noqa: E731
    return {
        "restitution_coefficient": np.minimum(scatter(result.restitution_coefficient), 1.0),
        "contact_time": scatter(result.contact_time),
        "max_force": scatter(result.max_force),
        "radius": radius,
        "mass": mass,
        "velocity": velocity,
    }


def rebounds(random: Random, *names: str, **options: Any) -> Any:
    """Rebounds with the measured quantities of these names."""
    radius, velocity = np.repeat([0.002, 0.008, 0.03], 6), np.tile(np.geomspace(0.1, 3.0, 6), 3)
    rows = bounced(random, radius, velocity)
    measured = ("restitution_coefficient", *names)
    noise = rs.Noise(**dict.fromkeys(measured, "1 %"))
    kept = {name: rows[name] for name in ("velocity", "radius", "mass", *measured)}
    return rs.Rebounds(noise=noise, **kept, **options)


def identify(data: Any, model: Any = rs.standard_solid, **options: Any) -> dict[str, Any]:
    """Numbers of the material that fits."""
    return of_fit(rs.identify(data, model, **({"fixed": INCOMPRESSIBLE} | options)))


# Estimates are known to parts of their standard errors, and the ends of profiles less exactly.
LOOSE: dict[str, Any] = {"rtol": 1e-3, "standard_error": 1e-2, "interval": 2e-2}
VAGUE: dict[str, Any] = {"rtol": 2e-2}


@problem("identification", ["contact_time", "max_force", "both", "none", "robust", "prior"], slow=["none"], **LOOSE)
def from_rebounds(random: Random, kind: str) -> Any:
    names = {"max_force": ("max_force",), "both": ("contact_time", "max_force"), "none": ()}.get(
        kind, ("contact_time",)
    )
    options: dict[str, Any] = {
        "robust": {"loss": "soft_l1"},
        "prior": {"prior": {"viscosity": rs.LogNormal(1e4, 0.1)}},
    }
    return identify(rebounds(random, *names), **options.get(kind, {}))


@problem(
    "identification",
    ["kelvin_voigt", "2 terms", "spectrum", "springpot"],
    slow=["spectrum", "2 terms", "springpot"],
    **VAGUE,
)
def model(random: Random, kind: str) -> Any:
    data = rebounds(random, "contact_time")
    if kind == "kelvin_voigt":
        return identify(data, rs.kelvin_voigt)
    if kind == "2 terms":
        return identify(data, rs.generalised_maxwell, terms=2, profiles=False)
    if kind == "springpot":
        return identify(data, rs.springpot, fixed={})
    result = rs.identify(data, "spectrum", fixed=INCOMPRESSIBLE)
    return result.moduli(np.geomspace(1e2, 1e4, 5))


@problem("identification", ["force", "acceleration"], **LOOSE)
def from_a_force_history(random: Random, kind: str) -> Any:
    mass = 0.0327
    result = rs.solve(rs.Impact(TRUTH, rs.Parabola(0.01), mass, 1.0))
    time = np.linspace(0.0, 1.6, 160) * result.contact_time
    inside = (time >= 0.3 * result.contact_time) & (time < 1.3 * result.contact_time)
    force = np.zeros(time.size)
    force[inside] = result.sample(time[inside] - 0.3 * result.contact_time)["force"]
    force += 2e-3 * result.max_force * random.standard_normal(time.size)
    record = {"force": force} if kind == "force" else {"acceleration": force / mass}
    return identify(rs.ForceHistory(time, **record, radius=0.01, mass=mass, velocity=1.0))


@problem("identification", ["triangle", "approach", "spring", "layer", "cone"], **LOOSE)
def from_an_indentation(random: Random, kind: str) -> Any:
    gel = rs.standard_solid(200.0 / 3.0, 800.0 / 3.0, 80.0, poisson_ratio=0.5)
    tip: Any = rs.Cone(1.2) if kind == "cone" else rs.Parabola(2.5e-6)
    if kind == "layer":
        tip = rs.Layer(tip, 3e-6)
    time = np.linspace(0.0, 1.4 if kind == "approach" else 2.8, 160)
    height = np.interp(time, [0.0, 1.4, 2.8], [0.0, 0.9e-6, 0.0])
    force = rs.indent(gel, tip, depth=height - 0.3e-6, time=time).force
    stiffness = 0.05 if kind == "spring" else None
    height = height + (force / stiffness if stiffness else 0.0)
    force = force + 3e-12 * random.standard_normal(time.size)
    return identify(rs.IndentationCurve(time, height, force, profile=tip, spring_constant=stiffness))


@problem("identification", ["known noise", "air"], slow=["air"], **LOOSE)
def from_bounce_times(random: Random, kind: str) -> Any:
    target = rs.standard_solid(1e6, 2e5, 200.0, poisson_ratio=0.5)
    hit = rs.drop(rs.Body(None, 0.01, 0.0327), rs.Body(target), 0.3)
    time = rs.bounces(hit, max_bounces=10).touch_time + 5e-5 * random.standard_normal(10)
    options: Any = {"air_density": 1.2} if kind == "air" else {"noise": rs.Noise(time=5e-5), "drop_height": 0.3}
    return identify(rs.BounceTimes(time, radius=0.01, mass=0.0327, **options), rs.kelvin_voigt)


@problem("identification", ["dynamic", "relaxation", "with rebounds"], **LOOSE)
def from_moduli(random: Random, kind: str) -> Any:
    omega = np.geomspace(1.0, 1e5, 25)
    noise = lambda: np.exp(0.01 * random.standard_normal(omega.size))  # noqa: E731
    series = TRUTH.shear
    table: Any = rs.DynamicTable(omega, series.storage_modulus(omega) * noise(), series.loss_modulus(omega) * noise(),
                                 deformation="shear")  # fmt: skip
    if kind == "relaxation":
        time = np.geomspace(1e-5, 1.0, 25)
        table = rs.RelaxationTable(time, series.relaxation_modulus(time) * noise(), deformation="shear")
    return identify([table, rebounds(random)] if kind == "with rebounds" else table)


@problem("identification", slow=[0], **LOOSE)
def over_temperatures(random: Random, _: int) -> Any:
    shifted = rs.Material(TRUTH.shear, math.inf, shift=rs.WLF(298.0, 8.6, 200.0), temperature=298.0)
    parts = []
    for kelvin in (288.0, 298.0, 313.0):
        rows = bounced(random, np.repeat([0.004, 0.02], 4), np.tile(np.geomspace(0.1, 3.0, 4), 2), shifted.at(kelvin))
        rows.pop("max_force")
        noise = rs.Noise(restitution_coefficient="1 %", contact_time="1 %")
        parts.append(rs.Rebounds(noise=noise, temperature=kelvin, **rows))
    return identify(parts, shift=rs.WLF(298.0, 8.6, 200.0), profiles=False)


@problem("identification", rtol=1e-3)
def comparison(random: Random, _: int) -> Any:
    result = rs.identify.compare(  # type: ignore[attr-defined]
        rebounds(random, "contact_time"), [rs.standard_solid, rs.kelvin_voigt], fixed=INCOMPRESSIBLE, profiles=False
    )
    return {name: item.chi2 for name, item in result.results.items()}


@problem("identification", rtol=1e-3)
def prediction(random: Random, _: int) -> Any:
    result = rs.identify(rebounds(random, "contact_time"), rs.standard_solid, fixed=INCOMPRESSIBLE)
    hit = rs.Impact(TRUTH, rs.Parabola(0.01), 0.03, [0.2, 2.0])
    coordinates = result.coordinates + 0.01 * random.normal(size=(3, result.coordinates.size))
    return {
        "predict": result.predict(hit),
        "moduli": result.moduli(np.geomspace(1e2, 1e4, 4)),
        "log_probability": result.log_probability(coordinates),
        "profile": result.interval(0.9),
    }


@problem("identification", rtol=1e-3)
def identify_map(random: Random, _: int) -> Any:
    gel = rs.standard_solid(200.0 / 3.0, 800.0 / 3.0, 80.0, poisson_ratio=0.5)
    tip, time = rs.Parabola(2.5e-6), np.linspace(0.0, 2.8, 120)
    height = np.interp(time, [0.0, 1.4, 2.8], [0.0, 1.4e-6, 0.0])
    force = rs.indent(gel, tip, depth=height - 0.4e-6, time=time).force
    curves = [
        rs.IndentationCurve(time, height, force + 1e-11 * random.standard_normal(time.size), profile=tip)
        for _ in range(4)
    ]
    return rs.identify_map(curves, rs.standard_solid, fixed=INCOMPRESSIBLE, shape=(2, 2), progress=False)


@problem("identification")
def effective_moduli(random: Random, _: int) -> Any:
    return rs.effective_moduli(rebounds(random, "contact_time", "max_force")).to_dataset()


@problem("identification", ["E", "D"], rtol=1e-6)
def design(random: Random, criterion: Any) -> Any:
    guess = partial(rs.standard_solid, 1e6, power(random, 6.5, 7.5), 1e4, poisson_ratio=0.5)
    candidates = {"velocity": [0.03, 0.1, 0.3, 1.0, 3.0], "radius": [0.003, 0.01, 0.03], "density": 7800.0}
    plan = rs.design(guess, candidates, n=12, criterion=criterion)
    numbers = {name: getattr(plan, name) for name in ("radius", "velocity", "repeats", "restitution_coefficient")}
    return numbers | {"errors": plan.standard_errors, "gains": list(plan.gains.values())}


OMEGA = np.geomspace(0.1, 100.0, 16)


def isotherms(random: Random, kind: str) -> Any:
    """Isotherms of a broad spectrum, shifted by the law of Plazek or of Arrhenius, with scatter."""
    times = 10.0 ** (np.linspace(-6.0, 6.0, 13) + random.normal(0.0, 0.2, 13))
    moduli = 10.0 ** (7.0 - 0.2 * np.arange(13) + random.normal(0.0, 0.2, 13))
    polymer = rs.PronySeries(moduli[-1], moduli, times)
    kelvin = np.array([373.15, 376.0, 380.0, 386.0, 394.0, 404.0])
    law: Any = rs.Arrhenius(373.15, 3e5) if kind == "arrhenius" else rs.WLF(373.15, 10.7, 29.9)
    scatter = lambda: np.exp(0.01 * random.normal(size=OMEGA.size))  # noqa: E731
    tables = []
    for item in kelvin:
        factor = law.factor(item)
        if kind == "relaxation":
            t = 1.0 / OMEGA[::-1]
            tables.append(rs.RelaxationTable(t, polymer.relaxation_modulus(t / factor) * scatter(), temperature=item))
            continue
        storage, loss = polymer.storage_modulus(OMEGA * factor), polymer.loss_modulus(OMEGA * factor)
        tables.append(rs.DynamicTable(OMEGA, storage * scatter(), loss * scatter(), temperature=item))
    return rs.Isotherms(tables)


@problem("master curve", ["free", "wlf", "arrhenius", "vertical", "relaxation"], rtol=1e-5, errors=1e-3,
         constants=1e-3)  # fmt: skip
def superposed(random: Random, kind: str) -> Any:
    shift: Any = kind if kind in ("wlf", "arrhenius") else "free"
    curve = isotherms(random, kind).superposed(reference_temperature=373.15, shift=shift, vertical=kind == "vertical")
    names = ("log10_factors", "errors", "log10_vertical_factors", "constants", "misfit")
    return {name: getattr(curve, name) for name in names}


@problem("master curve", rtol=1e-2)
def fit_of_a_master_curve(random: Random, _: int) -> Any:
    curve = isotherms(random, "wlf").superposed(reference_temperature=373.15, shift="wlf")
    result = rs.fit_prony(curve.data).material(bulk_modulus=3e9, deformation="shear")
    return {"E*": rs.reduced_modulus(result).relaxation_modulus(np.geomspace(1e-2, 1e2, 5))}


@problem("fit", ["relaxation", "dynamic", "liquid", "all of the loss"], rtol=1e-6)
def fit_prony(random: Random, kind: str) -> Any:
    truth = series(random, 6, liquid=kind == "liquid", times=(-3.0, 2.0))
    x = np.geomspace(1e-3, 1e3, 41)
    noise = lambda: np.exp(0.005 * random.normal(size=x.size))  # noqa: E731
    if kind == "relaxation":
        table: Any = rs.RelaxationTable(x, truth.relaxation_modulus(x) * noise(), deformation="tension")
    else:
        table = rs.DynamicTable(x, truth.storage_modulus(x) * noise(), truth.loss_modulus(x) * noise())
    options: Any = {"liquid": {"liquid": True}, "all of the loss": {"loss_weight": 1.0}}.get(kind, {})
    result = rs.fit_prony(table, **options)
    t = np.geomspace(1e-2, 1e2, 7)
    return {"misfit": result.misfit, "window": result.window, "modulus": result.series.relaxation_modulus(t)}


@problem("fit", ["tension", "shear", "round trip"])
def conversion(random: Random, kind: str) -> Any:
    item, bulk = series(random, 5), power(random, 7.0, 9.0)
    if kind == "tension":
        return of_prony(rs.tension_from_shear(item, bulk_modulus=bulk))
    if kind == "shear":
        return of_prony(rs.shear_from_tension(item, poisson_ratio=random.uniform(0.2, 0.5)))
    relaxing = rs.tension_from_shear(item, bulk_modulus=series(random, 3).scaled(10.0))
    return {"tension": of_prony(relaxing), "shear": rs.shear_from_tension(relaxing, bulk_modulus=1e12)}


# Text of small tables, with units, decimal commas and other separators.
FILES = {
    "relaxation": "t,E\ns,MPa\n" + "".join(f"{t:.6g},{1 + 2 * math.exp(-t / 0.1):.9g}\n" for t in np.geomspace(1e-3, 10, 9)),
    "dynamic": "frequency [Hz];G' [kPa];tan delta\n0,1;220,7;0,141\n1;259,7;0,0889\n10;290,1;0,07\n100;331,5;0,081\n",
    "loss modulus": "# DMA\nomega_rad/s,E'_MPa,E''_MPa\n0.1,1.0,0.1\n1,1.3,0.2\n10,1.9,0.3\n100,2.4,0.25\n",
    "terms": "# E0 = 8 MPa\nrelaxation_time_s,relative_modulus\n1e-3,0.2\n1e-1,0.3\n10,0.1\n",
    "shift": "T [degC],log aT\n0,1.5\n25,0\n50,-1.1\n",
    "isotherms": "omega,G',G'',T\nrad/s,Pa,Pa,degC\n" + "".join(
        f"{w},{1e6 * (1 + w / (1 + w)) * f},{3e5 * w / (1 + w * w) * f + 1e4},{T}\n"
        for T, f in ((20, 1.3), (30, 1.0)) for w in (0.1, 1.0, 10.0)),
}  # fmt: skip


COLUMNS = ("time", "modulus", "angular_frequency", "storage_modulus", "loss_modulus", "temperature", "temperatures",
           "log10_factors", "reference_temperature", "relaxation_times", "moduli", "equilibrium_modulus",
           "instantaneous_modulus", "window")  # fmt: skip


@problem("file", FILES)
def table(random: Random, kind: str) -> Any:
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "table.csv"
        path.write_text(FILES[kind])
        result: Any = rs.read_material(path)
    item = lambda result: {name: getattr(result, name) for name in COLUMNS if hasattr(result, name)}  # noqa: E731
    return item(result) | {"tables": [item(part) for part in getattr(result, "tables", ())]}


@problem("file", ["deck.inp", "deck.txt"])
def card(random: Random, name: str) -> Any:
    with tempfile.TemporaryDirectory() as folder:
        path = rs.write_material(material(random, "bulk relaxes"), Path(folder) / name)
        return {"lines": len(path.read_text().splitlines()), "again": rs.read_material(path)}


@problem("file")
def workbook(random: Random, _: int) -> Any:
    import openpyxl

    with tempfile.TemporaryDirectory() as folder:
        book, path = openpyxl.Workbook(), Path(folder) / "table.xlsx"
        sheet: Any = book.active
        for line in FILES["relaxation"].splitlines():
            sheet.append([float(item) if item[0].isdigit() else item for item in line.split(",")])
        book.save(path)
        result: Any = rs.read_material(path)
    return {"time": result.time, "modulus": result.modulus}


@problem("file", ["balls", "sound", "afm_curve"])
def observations(random: Random, name: str) -> Any:
    options: Any = {"balls": {}, "sound": {"radius": 0.02, "mass": 0.03351},
                  "afm_curve": {"profile": rs.Parabola(2.5e-6)}}[name]  # fmt: skip
    result: Any = rs.read_observations(EXAMPLES / "identification" / f"{name}.csv", **options)
    names = ("time", "velocity", "restitution_coefficient", "contact_time", "radius", "mass", "depth", "force", "size")
    return {item: getattr(result, item) for item in names if hasattr(result, item)}


@problem("case", ["rubber_ball", "two_beads", "epoxy", "coated_plate", "rubber_pad", "beads", "dropped_ball"],
         rtol=1e-7)  # fmt: skip
def read_case(random: Random, name: str) -> Any:
    case = rs.read_case(EXAMPLES / f"{name}.toml")
    result = case.solve()
    return of_impact(result) | {"validity": of_validity(result)}


@problem("case")
def bounces_of_a_case(random: Random, _: int) -> Any:
    return rs.read_case(EXAMPLES / "dropped_ball.toml").bounces().to_dataset()


def command(*arguments: str) -> dict[str, Any]:
    """Numbers that a command prints as JSON."""
    printed = io.StringIO()
    with (
        mock.patch.object(sys, "argv", ["restitution", *arguments, "--json"]),
        contextlib.redirect_stdout(printed),
        contextlib.redirect_stderr(io.StringIO()),
        contextlib.suppress(SystemExit),
    ):
        runpy.run_module("restitution", run_name="__main__")
    return json.loads(printed.getvalue())


# The residual of the energies is rounding alone.
RESIDUAL: dict[str, Any] = {"energy_residual": math.inf, "energy.residual": math.inf}


@problem(
    "case",
    [
        "solve two_beads",
        "indent afm_indent",
        "indent creep_indent",
        "bounce dropped_ball",
        "resilience rubber_pad",
        "calibrate two_beads --target liggghts --velocity 0.02 0.2",
        "design identification/design",
        "moduli identification/balls.csv",
    ],
    rtol=1e-6,
    **RESIDUAL,
)
def command_line(random: Random, line: str) -> Any:
    verb, name, *options = line.split()
    return command(verb, str(EXAMPLES / (name if "." in name else f"{name}.toml")), *options)


@problem("case", ["identify balls", "identify sound", "identify afm_curve"], slow=["identify sound"], rtol=1e-2)
def identification_file(random: Random, line: str) -> Any:
    verb, name = line.split()
    return command(verb, str(EXAMPLES / "identification" / f"{name}.toml"))
