"""The door: an impact with other numbers by name equals one that is made from them, and a sweep over them."""

import math
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
import xarray as xr

import restitution as rs
from cases import RUBBER
from refusals import in_one_line
from restitution.variation import numbers_by_name

# Large velocities exceed the limits of the theory on purpose.
pytestmark = pytest.mark.filterwarnings("ignore::restitution.errors.RestitutionWarning")
RNG = np.random.default_rng()
BALL = rs.Impact(RUBBER, rs.Parabola(0.01), mass=0.005, velocity=0.5)
SERIES = rs.Material(rs.PronySeries(1e6, [4e6, 3e6], [1e-4, 2e-3]), bulk=rs.PronySeries(1e8, [2e8], [1e-3]))
# Each has a random number in its range, and makes the impact from it without `vary`.
SINGLES: dict[str, tuple[tuple[float, float], Any]] = {
    "velocity": ((0.1, 1.0), lambda x: replace(BALL, velocity=x)),
    "mass": ((1e-3, 1e-2), lambda x: replace(BALL, mass=x)),
    "external_force": ((0.0, 1.0), lambda x: replace(BALL, external_force=x)),
    "impedance": ((10.0, 100.0), lambda x: replace(BALL, impedance=x)),
    "radius": ((5e-3, 2e-2), lambda x: replace(BALL, profile=rs.Parabola(x))),
    "poisson_ratio": ((0.1, 0.5), lambda x: solid(poisson_ratio=x)),
    "nu": ((0.1, 0.5), lambda x: solid(poisson_ratio=x)),
    "bulk_modulus": ((1e7, 1e9), lambda x: solid(poisson_ratio=None, bulk_modulus=x)),
    "branch_modulus": ((5e6, 2e7), lambda x: solid(branch_modulus=x)),
    "viscosity": ((5e2, 2e3), lambda x: solid(viscosity=x)),
    "relaxation_time": ((5e-5, 2e-4), lambda x: solid(viscosity=1e7 * x)),
    "p2": ((0.05, 0.5), lambda x: solid(branch_modulus=1e6 / x)),
    "branch_moduli[0]": ((5e6, 2e7), lambda x: solid(branch_modulus=x, viscosity=x * 1e-4)),
    "relaxation_times[0]": ((5e-5, 2e-4), lambda x: solid(viscosity=1e7 * x)),
    "material": ((), lambda x: replace(BALL, material=x)),
    "counter_material": ((), lambda x: replace(BALL, counter_material=x)),
}  # fmt: skip


def solid(**numbers: Any) -> rs.Impact:
    constants = {"equilibrium_modulus": 1e6, "branch_modulus": 1e7, "viscosity": 1e3, "poisson_ratio": 0.45}
    return replace(BALL, material=rs.standard_solid(**constants | numbers))


def coefficient(impact: rs.Impact) -> Any:
    return rs.solve(impact).restitution_coefficient


@pytest.mark.parametrize("name", SINGLES)
def test_a_number_by_name_is_that_of_the_constructor(name):
    ends, build = SINGLES[name]
    value = RNG.uniform(*ends) if ends else SERIES
    assert coefficient(rs.vary(BALL, {name: value})) == pytest.approx(coefficient(build(value)), rel=1e-11)


@pytest.mark.parametrize("held", ["bulk_modulus", "poisson_ratio"])
def test_what_is_held_while_the_equilibrium_modulus_changes(held):
    kept = {"bulk_modulus": RUBBER.bulk.equilibrium_modulus} if held == "bulk_modulus" else {"poisson_ratio": 0.45}
    constants = {"poisson_ratio": None} | kept
    expected = solid(equilibrium_modulus=3e6, **constants)
    result = rs.vary(BALL, {"equilibrium_modulus": 3e6}, held=held)
    assert coefficient(result) == pytest.approx(coefficient(expected), rel=1e-11)


def test_arrays_and_sweeps_have_the_bits_of_single_impacts():
    names = [name for name in SINGLES if SINGLES[name][0] and name not in ("nu", "impedance", "p2", "bulk_modulus")]
    for _ in range(6):
        chosen = list(RNG.permutation(names)[:3])
        rivals = {"viscosity", "relaxation_time", "relaxation_times[0]"}, {"branch_modulus", "branch_moduli[0]"}
        if any(len(pair & set(chosen)) > 1 for pair in rivals):
            continue
        values = {name: RNG.uniform(*SINGLES[name][0], RNG.integers(1, 4)) for name in chosen}
        arrays = {n: v.reshape([-1 if k == i else 1 for k in range(3)]) for i, (n, v) in enumerate(values.items())}
        together = coefficient(rs.vary(BALL, arrays))
        swept = rs.sweep(BALL, values).restitution_coefficient.values
        named = coefficient(rs.vary(BALL, {n: xr.DataArray(v, dims=n, coords={n: v}) for n, v in values.items()}))
        assert named.dims == tuple(chosen)
        for index in np.ndindex(together.shape):
            single = rs.vary(BALL, {n: float(v[i]) for (n, v), i in zip(values.items(), index, strict=True)})
            assert coefficient(single) == together[index] == swept[index] == named.values[index], chosen


def test_the_groups_of_the_paper_follow():
    axes = {"nu": RNG.uniform(0.1, 0.5, 3), "p2": RNG.uniform(0.01, 1.0, 3), "p3": RNG.uniform(0.1, 10.0, 3)}
    # The groups determine e, for bodies and materials of all sizes.
    sizes = {"velocity": 0.3, "radius": 0.03, "mass": 0.02, "equilibrium_modulus": 3e6}
    result = coefficient(rs.vary(BALL, axes | sizes))
    np.testing.assert_allclose(result, rs.standard_solid_restitution(*axes.values()), rtol=1e-9)


def test_temperatures_shift_the_materials():
    shift = rs.WLF(300.0, 10.0, 100.0)
    impact = replace(BALL, material=replace(SERIES, shift=shift, temperature=300.0))
    warm = RNG.uniform(305.0, 330.0, 4)
    result = coefficient(rs.vary(impact, {"temperature": warm}))
    for n, temperature in enumerate(warm):
        alone = coefficient(replace(impact, material=impact.material.at(float(temperature))))
        assert result[n] == pytest.approx(alone, rel=1e-11)


def test_numbers_of_layers_and_of_their_profiles():
    pad = replace(BALL, profile=rs.Layer(rs.Sphere(0.01), 0.02))
    numbers = {"thickness": RNG.uniform(0.01, 0.03, (3, 1)), "radius": RNG.uniform(0.005, 0.02, 2)}
    result = rs.vary(pad, numbers)
    assert result.shape == (3, 2)
    e = coefficient(result)
    for index in np.ndindex(3, 2):
        layer = rs.Layer(rs.Sphere(float(numbers["radius"][index[1]])), float(numbers["thickness"][index[0], 0]))
        assert e[index] == pytest.approx(coefficient(replace(BALL, profile=layer)), rel=1e-9)


def test_an_incompressible_row_stands_beside_a_bulk_that_relaxes():
    impact = replace(BALL, material=SERIES)
    result = rs.vary(impact, {"bulk_modulus": [1e8, math.inf]})
    rigid = replace(impact, material=rs.Material(SERIES.shear, math.inf))
    assert coefficient(result) == pytest.approx([coefficient(impact), coefficient(rigid)], rel=1e-11)


@pytest.mark.parametrize(
    ("field", "numbers"),
    [
        ("numbers", {"veloicty": 1.0}),
        ("numbers", {"poisson_ratio": 0.3, "bulk_modulus": 1e8}),
        ("velocity", {"velocity": -1.0}),
        ("poisson_ratio", {"poisson_ratio": 0.6}),
        ("material", {"material": 1e6}),
        ("axes", {"branch_moduli[3]": 1e6}),
        *(
            ("numbers", {name: 1e6})
            for name in (
                "branch_moduli",
                "branch_moduli[x]",
                "branch_moduli[-1]",
                "branch_moduli[00]",
                "relaxation_times[0",
                "viscosity[0]",
            )
        ),
        ("numbers", {"branch_modulus": 1e6, "branch_moduli[0]": 2e6}),
        ("numbers", {"viscosity": 1e3, "relaxation_times[0]": 1e-3}),
        ("numbers", 3.0),
    ],
)
def test_what_cannot_be_varied_is_refused(field, numbers):
    assert in_one_line(lambda: rs.vary(BALL, numbers)).field == field


@pytest.mark.parametrize("name", [*(name for name in SINGLES if "material" not in name), "p3"])
def test_numbers_come_back_by_name(name: str) -> None:
    (low, high), make = SINGLES[name] if name != "p3" else ((0.01, 1.0), lambda x: rs.vary(BALL, {"p3": x}))
    x = float(RNG.uniform(low, high))
    result = numbers_by_name(make(x), [name])
    assert list(result.values()) == pytest.approx([x], rel=1e-12)
    if name == "p3":
        assert result["p3"] == pytest.approx(float(rs.dimensionless_groups(make(x)).p3), rel=1e-12)
