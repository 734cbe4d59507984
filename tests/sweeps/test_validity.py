"""Validity report of a sweep: numbers and counts equal those of single results."""

import json
import warnings
from dataclasses import replace

import numpy as np
import pytest

import restitution as rs
from restitution.limits import RADIATION_LIMIT
from restitution.quantities import VALIDITY

# Many of these bodies exceed the limits of the theory.
pytestmark = pytest.mark.filterwarnings(r"ignore:.*; exceeded in \d+ of")

RUBBER = rs.standard_solid(1e6, 1e7, 1e3, poisson_ratio=0.45, density=1100.0)
BALL = rs.Impact(RUBBER, rs.Parabola(0.01), mass=0.005, velocity=1.0)
OUTPUTS = ("restitution_coefficient", *VALIDITY)


@pytest.mark.parametrize(
    ("base", "axes"),
    [
        (BALL, {"velocity": [0.1, 3.0], "radius": [0.005, 0.02]}),
        (BALL, {"poisson_ratio": [0.3, 0.45], "mass": [0.001, 0.01], "viscosity": [1e2, 1e4]}),
        (rs.Impact(RUBBER, rs.Sphere(0.01), 0.005, 1.0), {"velocity": [0.1, 3.0], "radius": [0.005, 0.02]}),
        (lambda modulus: rs.Impact(rs.Material(modulus, 1e9), rs.Cone(1.2), 0.005, 1.0), {"modulus": [1e5, 1e6]}),
    ],
)  # fmt: skip
def test_numbers_equal_those_of_single_results(base, axes):
    table = rs.sweep(base, axes, OUTPUTS)
    names = list(axes)
    for index in np.ndindex(*table.restitution_coefficient.shape):
        values = {name: axes[name][i] for name, i in zip(names, index, strict=True)}
        report = rs.solve(rs.vary(base, values) if isinstance(base, rs.Impact) else base(**values)).validity
        for kind, name in (("small_strain", "strain_number"), ("poisson_ratio", "instantaneous_poisson_ratio")):
            assert float(table[name][index]) == pytest.approx(report[kind].value, rel=1e-9)
        if report["waves"].value is not None:
            assert float(table.radiated_energy_ratio[index]) == pytest.approx(report["waves"].value, rel=1e-6)


def test_numbers_have_units():
    table = rs.sweep(BALL, {"velocity": [1.0, 2.0]}, ["mean_density", "strain_number"])
    assert table.mean_density.attrs["units"] == "kg/m^3"
    assert table.strain_number.attrs["units"] == "1"
    assert float(table.mean_density[0]) == pytest.approx(0.005 / (4 / 3 * np.pi * 0.01**3))


def swept(base, axes, **options):
    """Result of a sweep, and its warnings by kind."""
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        table = rs.sweep(base, axes, **options)
    return table, {warning.message.kind: str(warning.message) for warning in caught}


def test_counts_equal_those_of_single_results(tmp_path):
    material = replace(RUBBER, window=(1e-3, 1e-1))
    ball, speeds = replace(BALL, material=material), np.geomspace(0.01, 20.0, 40)
    expected: dict[str, int] = {}
    worst: dict[str, float] = {}
    for v in speeds:
        for check in rs.solve(replace(ball, velocity=v)).validity:
            expected[check.kind] = expected.get(check.kind, 0) + check.exceeded
            if check.kind == "small_strain":
                worst["small_strain"] = max(worst.get("small_strain", 0.0), check.value)
    for out in (None, tmp_path / "a.zarr"):
        table, texts = swept(ball, {"velocity": speeds}, chunk=7, out=out)
        stored = json.loads(table.attrs["validity"])
        assert stored["impacts"] == 40
        assert {kind: check["exceeded_in"] for kind, check in stored["checks"].items()} == expected
        assert stored["checks"]["small_strain"]["value"] == pytest.approx(worst["small_strain"], rel=1e-9)
        assert set(texts) == {kind for kind, count in expected.items() if count}
        assert 0 < expected["small_strain"] < 40
        assert f"exceeded in {expected['small_strain']} of 40 impacts" in texts["small_strain"]
    # The store keeps the counts of each chunk. A missing count is computed again.
    (tmp_path / "a.zarr" / "validity" / "c-2").unlink()
    again, repeated = swept(ball, {"velocity": speeds}, chunk=7, out=tmp_path / "a.zarr")
    assert again.attrs["validity"] == table.attrs["validity"]
    assert repeated == texts


def test_every_material_is_checked():
    n = 300
    axes = {"viscosity": np.geomspace(1e2, 1e4, n), "radius": [0.005, 0.01]}
    table, texts = swept(replace(BALL, velocity=3.0), axes, outputs=["radiated_energy_ratio"])
    checks = json.loads(table.attrs["validity"])["checks"]
    assert checks["small_strain"]["checked"] == checks["waves"]["checked"] == 2 * n
    assert checks["waves"]["exceeded_in"] == int((table.radiated_energy_ratio > RADIATION_LIMIT).sum()) == 2 * n
    assert "exceeded in 600 of 600 impacts. " in texts["small_strain"]


def test_every_impact_of_a_builder_is_checked():
    def build(viscosity):
        rubber = rs.standard_solid(1e6, 1e7, viscosity, poisson_ratio=0.45, density=1100.0)
        return replace(BALL, material=rubber, velocity=3.0)

    _, texts = swept(build, {"viscosity": np.geomspace(1e2, 1e4, 40)})
    assert "exceeded in 40 of 40 impacts. " in texts["small_strain"]


@pytest.mark.parametrize(
    "axes",
    [
        {"p3": [0.1, 1.0]},
        {"p2": [0.01, 0.1], "p3": [0.1, 1.0]},
        {"p3": [0.1, 1.0], "velocity": [0.1, 1.0], "radius": [0.01, 0.02]},
        {"mass": [0.001, 0.005], "equilibrium_modulus": [1e6, 2e6], "p3": 0.5},
    ],
)
def test_numbers_over_the_dimensionless_viscosity(axes):
    table = rs.sweep(BALL, axes, OUTPUTS)
    varied = {name: values for name, values in axes.items() if isinstance(values, list)}
    for index in np.ndindex(*table.restitution_coefficient.shape):
        at = axes | {name: values[i] for (name, values), i in zip(varied.items(), index, strict=True)}
        mass, v, radius = at.get("mass", 0.005), at.get("velocity", 1.0), at.get("radius", 0.01)
        modulus = at.get("equilibrium_modulus", 1e6)
        # p3 = eta (v R/(m^2 Ginf^3))^(1/5); the bulk modulus is constant.
        eta = at["p3"] * (mass**2 * modulus**3 / (v * radius)) ** 0.2
        branch = modulus / at["p2"] if "p2" in at else 1e7
        shear = rs.PronySeries(modulus, [branch], [eta / branch])
        impact = rs.Impact(replace(RUBBER, shear=shear), rs.Parabola(radius), mass, v)
        report = rs.solve(impact).validity
        for kind, name in (
            ("small_strain", "strain_number"),
            ("waves", "radiated_energy_ratio"),
            ("poisson_ratio", "instantaneous_poisson_ratio"),
            ("density", "mean_density"),
        ):
            assert float(table[name][index]) == pytest.approx(report[kind].value, rel=1e-6)


def test_without_dimensions_only_the_poisson_ratio_is_checked():
    table, texts = swept(None, {"nu": [0.3], "p2": [1e-3, 1e3], "p3": [1.0, 2.0]}, outputs=OUTPUTS)
    checks = json.loads(table.attrs["validity"])["checks"]
    assert [kind for kind, check in checks.items() if check["value"] is not None] == ["poisson_ratio"]
    assert checks["poisson_ratio"]["exceeded_in"] == 2
    assert set(texts) == {"poisson_ratio"}
    glass = [
        rs.standard_solid(1.0, 1.0 / p2, 1.0, poisson_ratio=0.3).instantaneous_poisson_ratio for p2 in (1e-3, 1e3)
    ]
    assert table.instantaneous_poisson_ratio[0, :, 1].values == pytest.approx(glass)
    assert table.strain_number.isnull().all()
