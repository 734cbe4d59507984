"""Sweeps over layers: the thickness, the profile and the material as axes, against single impacts."""

from __future__ import annotations

import warnings
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import restitution as rs
from cases import case_file
from restitution.case.sweep import read_sweep
from restitution.impact.batch import Batch
from restitution.impact.status import Status
from restitution.quantities import BUDGET
from restitution.sweeps.run import run

pytestmark = pytest.mark.filterwarnings(r"ignore:(small strain|density|Poisson ratio)")

RNG = np.random.default_rng(12)
R = np.linspace(0.0, 0.004, 9)
OUTPUTS = ("restitution_coefficient", "contact_time", "max_force", "max_contact_radius")


def solid(poisson_ratio: float = 0.5) -> rs.Material:
    return rs.standard_solid(1e6, 3e6, 2e3, poisson_ratio=poisson_ratio)


def compare(table: Any, point: dict[str, int], single: rs.ImpactResult, rtol: float = 1e-8) -> None:
    for name in OUTPUTS:
        assert float(table[name].isel(point)) == pytest.approx(getattr(single, name), rel=rtol)


@pytest.mark.parametrize("base", ["bonded", "frictionless"])
@pytest.mark.parametrize(
    ("profile", "axis"),
    [(rs.Parabola(0.005), "radius"), (rs.Cone(1.35), "half_angle"), (rs.Sphere(0.01), "radius")],
    ids=lambda profile: type(profile).__name__,
)
def test_thickness_and_profile_as_axes(profile: Any, axis: str, base: Any) -> None:
    thickness = np.exp(RNG.uniform(np.log(1e-3), np.log(0.3), 3)).tolist()
    numbers = (getattr(profile, axis) * RNG.uniform(0.9, 1.1, 2)).tolist()
    ball = rs.Impact(solid(), rs.Layer(profile, thickness=0.01, base=base), mass=0.01, velocity=0.05)
    table = rs.sweep(ball, {"thickness": thickness, axis: numbers, "velocity": [0.01, 0.1]}, OUTPUTS)
    for i, h in enumerate(thickness):
        for j, number in enumerate(numbers):
            layer = rs.Layer(replace(profile, **{axis: number}), thickness=h, base=base)
            single = rs.solve(replace(ball, profile=layer, velocity=0.1))
            compare(table, {"thickness": i, axis: j, "velocity": 1}, single)


@pytest.mark.parametrize("outer", ["thickness", "velocity"])
@pytest.mark.parametrize(
    "profile",
    [rs.Sphere(0.01), rs.Tabulated(R, R**2 / 0.02 + np.sin(800.0 * R) ** 2 * 2e-6), rs.TruncatedCone(3e-4, 1.4)],
    ids=lambda profile: type(profile).__name__,
)
def test_many_thicknesses_share_their_tables(profile: Any, outer: str) -> None:
    ball = rs.Impact(solid(), rs.Layer(profile, thickness=0.01), mass=0.01, velocity=0.05)
    thickness = np.exp(RNG.uniform(np.log(5e-4), np.log(0.1), 80)).tolist()
    axes: Any = {"thickness": thickness, "velocity": [0.01, 0.1]}
    names = sorted(axes, key=lambda name: name != outer)
    table = rs.sweep(ball, {name: axes[name] for name in names}, OUTPUTS)
    for i in RNG.integers(0, 80, 3):
        thin = rs.Layer(profile, thickness=float(table.thickness[i]))
        compare(table, {"thickness": int(i), "velocity": 1}, rs.solve(replace(ball, profile=thin, velocity=0.1)))


def test_energies_are_those_of_each_layer() -> None:
    ball = rs.Impact(solid(), rs.Layer(rs.Sphere(0.01), thickness=0.01), mass=0.01, velocity=0.05)
    thickness = [0.02, 0.001, 0.005]
    table = rs.sweep(ball, {"thickness": thickness}, [*OUTPUTS, *BUDGET])
    for i, h in enumerate(thickness):
        single = rs.solve(replace(ball, profile=rs.Layer(rs.Sphere(0.01), thickness=h)))
        *energies, residual = (float(table[name][i]) for name in BUDGET)
        assert energies == pytest.approx(list(single.energy)[:-1], rel=1e-7, abs=1e-9 * single.energy[0])
        assert abs(residual) < 1e-8


def test_an_inaccurate_table_fails_its_own_impacts(monkeypatch: pytest.MonkeyPatch) -> None:
    layers = rs.Layer(rs.Sphere(0.01), thickness=np.array([0.02, 0.001, 0.005]))
    scaled = Batch.scaled

    def rough(self: Batch, *arguments: Any) -> Any:
        block = scaled(self, *arguments)
        assert block.tables is not None
        block.tables.errors[1] = 1.0
        return block

    monkeypatch.setattr(Batch, "scaled", rough)
    batch = Batch.from_impact(rs.Impact(solid(), layers, mass=0.01, velocity=0.05))
    columns = batch.solve(1e-9, workers=1)
    assert np.isnan(columns["restitution_coefficient"]).tolist() == [False, False, True]
    assert columns["status"][2] == Status.NOT_ACCURATE


@pytest.mark.parametrize(("base", "ratios"), [("bonded", [0.49995, 0.5]), ("frictionless", [0.3, 0.5])])
def test_the_poisson_ratio_as_an_axis(base: Any, ratios: list[float]) -> None:
    layer = rs.Layer(rs.Parabola(0.005), thickness=0.001, base=base)
    ball = rs.Impact(solid(), layer, mass=0.01, velocity=0.05)
    table = rs.sweep(ball, {"poisson_ratio": ratios, "thickness": [0.001, 0.01]}, OUTPUTS)
    for i, nu in enumerate(ratios):
        compare(
            table, {"poisson_ratio": i, "thickness": 0}, rs.solve(replace(ball, material=solid(nu), profile=layer))
        )


def test_a_poisson_ratio_that_begins_to_relax_is_counted_in_one_warning() -> None:
    ball = rs.Impact(solid(), rs.Layer(rs.Parabola(0.005), thickness=0.001), mass=0.01, velocity=0.05)
    ratios, thickness = [0.5, 0.4, 0.3], [0.001, 0.01]
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        table = rs.sweep(ball, {"poisson_ratio": ratios, "thickness": thickness}, OUTPUTS)
    texts = [str(warning.message) for warning in caught if getattr(warning.message, "kind", "") == "separability"]
    assert len(texts) == 1
    assert (
        "relaxes from -0.0714 to 0.3, and a bonded layer is approximate then; exceeded in 4 of 6 impacts" in texts[0]
    )
    for i, nu in enumerate(ratios):
        for j, h in enumerate(thickness):
            single = replace(ball, material=solid(nu), profile=rs.Layer(rs.Parabola(0.005), thickness=h))
            with warnings.catch_warnings():
                warnings.simplefilter("ignore")
                compare(table, {"poisson_ratio": i, "thickness": j}, rs.solve(single))


def test_the_radius_of_a_case_is_that_of_the_tip_and_of_the_mass(tmp_path: Path) -> None:
    file, constants = tmp_path / "coat.toml", "equilibrium_modulus = 2e6\nbranch_modulus = 4e6\nviscosity = 1e3"
    case_file(
        file, body='density = "7800 kg/m^3"\nradius = "5 mm"', profile='thickness = "2 mm"',
        material=f"{constants}\npoisson_ratio = 0.5", impact='velocity = "0.1 m/s"',
        axes='thickness = ["1 mm", "50 mm"]\nradius = ["3 mm", "8 mm"]',
    )  # fmt: skip
    table = run(read_sweep(file))
    material = rs.standard_solid(2e6, 4e6, 1e3, poisson_ratio=0.5)
    for i, h in enumerate([1e-3, 50e-3]):
        for j, radius in enumerate([3e-3, 8e-3]):
            mass = 7800.0 * 4.0 / 3.0 * np.pi * radius**3
            single = rs.solve(rs.Impact(material, rs.Layer(rs.Parabola(radius), thickness=h), mass, 0.1))
            restitution = float(table.restitution_coefficient[i, j])
            assert restitution == pytest.approx(single.restitution_coefficient, rel=1e-8)


def test_a_surrogate_over_the_velocity() -> None:
    ball = rs.Impact(solid(), rs.Layer(rs.Parabola(0.005), thickness=0.003), mass=0.01, velocity=0.05)
    surrogate = rs.surrogate(ball, (0.01, 0.1), rtol=1e-6)
    velocity = float(RNG.uniform(0.01, 0.1))
    expected = rs.solve(replace(ball, velocity=velocity)).restitution_coefficient
    assert float(surrogate.restitution_coefficient(velocity)) == pytest.approx(expected, abs=2e-6)
