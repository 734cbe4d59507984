"""DataArrays as numbers: their dimensions and coordinates reach the results, and rows keep the bits of single solves."""

import copy
import pickle
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
import xarray as xr

import restitution as rs
from refusals import in_one_line
from restitution.axes import Axes, aligned, axes_of, spread_array

# Large velocities exceed the limits of the theory on purpose.
pytestmark = pytest.mark.filterwarnings("ignore::restitution.errors.RestitutionWarning")
RNG = np.random.default_rng()


def along(name: str, low: float, high: float, units: str = "", factor: float = 1.0) -> xr.DataArray:
    """Two to four numbers of random size, in random order, whose coordinates are their values in SI."""
    values = RNG.uniform(low, high, RNG.integers(2, 5))
    return xr.DataArray(values * factor, dims=name, coords={name: values}, attrs={"units": units} if units else {})


def solid(viscosity: Any = 1e3, modulus: Any = 1e6, **rest: Any) -> rs.Material:
    return rs.standard_solid(modulus, 1e7, viscosity, poisson_ratio=0.45, **rest)


def places(array: xr.DataArray) -> list[dict[str, Any]]:
    """Coordinates of some random elements."""
    return [{name: array[name].values[RNG.integers(array.sizes[name])] for name in array.dims} for _ in range(4)]


def test_dimensions_of_all_numbers_reach_the_result():
    viscosity, radius = along("viscosity", 500.0, 2e3), along("radius", 0.005, 0.02, "mm", 1e3)
    velocity = along("velocity", 0.5, 2.0)
    impact = rs.Impact(solid(viscosity), rs.Parabola(radius), mass=0.005, velocity=velocity)
    result = rs.solve(impact)
    e = result.restitution_coefficient
    assert e.dims == ("viscosity", "radius", "velocity")
    assert e.attrs["long_name"] == "restitution coefficient"
    for at in places(e):
        alone = rs.Impact(solid(at["viscosity"]), rs.Parabola(at["radius"]), 0.005, at["velocity"])
        # Millimetres round.
        assert float(e.sel(at)) == pytest.approx(rs.solve(alone).restitution_coefficient, rel=1e-12)
        assert float(e.sel(at)) == result.sel(at).restitution_coefficient
    xr.testing.assert_identical(result.to_dataset().restitution_coefficient, e)
    assert result.max_pressure.dims == result.energy.dissipated.dims == result.zero_overlap_time.dims == e.dims


def test_a_dimension_that_two_numbers_share_is_one():
    velocity = along("case", 0.5, 2.0)
    mass = velocity.copy(data=RNG.uniform(0.001, 0.01, velocity.size))
    result = rs.solve(rs.Impact(solid(), rs.Sphere(0.01), mass, velocity))
    assert result.restitution_coefficient.dims == ("case",)
    for m, v, e in zip(mass.values, velocity.values, result.restitution_coefficient.values, strict=True):
        assert e == rs.solve(rs.Impact(solid(), rs.Sphere(0.01), float(m), float(v))).restitution_coefficient


def test_materials_geometries_and_layers_have_axes():
    density, temperature = along("density", 900.0, 1200.0), along("temperature", 305.0, 340.0)
    branches = xr.DataArray(RNG.uniform(1e6, 1e7, (2, 3)), dims=("batch", "branch"))
    series = rs.PronySeries(1e6, branches, [1e-4, 1e-3, 1e-2])
    material = rs.Material(series, 1e9, density=density, shift=rs.WLF(300.0, 10.0, 100.0)).at(temperature)
    assert series.axes.names == ("batch",)
    assert material.axes.names == ("batch", "density", "temperature")
    assert replace(material, name="copy").axes.names == material.axes.names
    thickness = along("thickness", 0.01, 0.03)
    layer = rs.Layer(rs.Sphere(along("radius", 0.005, 0.02)), thickness, base="frictionless")
    assert set(layer.axes.names) == {"thickness", "radius"}
    result = rs.solve(rs.Impact(material, layer, mass=0.005, velocity=1.0))
    assert result.contact_time.dims == ("batch", "density", "temperature", "thickness", "radius")
    at = {"batch": 1, "density": 0, "temperature": 1, "thickness": 1, "radius": 0}
    warm = rs.Material(series.row(1), 1e9, shift=material.shift).at(float(temperature[1]))
    single = rs.Layer(rs.Sphere(float(layer.numbers["radius"].ravel()[0])), float(thickness[1]), base="frictionless")
    alone = rs.solve(rs.Impact(warm, single, mass=0.005, velocity=1.0))
    # The tables of many thicknesses are made together and differ by rounding.
    assert float(result.contact_time.isel(at)) == pytest.approx(alone.contact_time, rel=1e-9)


def test_collisions_and_falls_keep_the_axes_of_their_bodies():
    radius, density = along("radius", 0.005, 0.02), along("density", 900.0, 1200.0)
    ball = rs.Body(solid(density=density), radius=radius)
    height = along("height", 0.1, 0.5)
    fall = rs.drop(ball, rs.Body(None), height)
    e = rs.solve(fall).restitution_coefficient
    assert e.dims == ("density", "radius", "height")
    for at in places(e):
        single = rs.Body(solid(density=at["density"]), radius=at["radius"])
        alone = rs.drop(single, rs.Body(None), at["height"])
        assert float(e.sel(at)) == rs.solve(alone).restitution_coefficient
    speed = along("velocity", 0.5, 2.0)
    both = rs.collision(ball, rs.Body(solid(density=1000.0), radius=along("other", 0.01, 0.02)), speed)
    e = rs.solve(both).restitution_coefficient
    assert e.dims == ("density", "radius", "other", "velocity")
    for at in places(e):
        bodies = (
            rs.Body(solid(density=d), radius=r) for d, r in ((at["density"], at["radius"]), (1000.0, at["other"]))
        )
        assert float(e.sel(at)) == rs.solve(rs.collision(*bodies, at["velocity"])).restitution_coefficient


def test_the_standard_solid_takes_them_too():
    nu, p3 = along("nu", 0.1, 0.5), along("p3", 0.1, 10.0)
    e = rs.standard_solid_restitution(nu, 0.1, p3)
    assert e.dims == ("nu", "p3")
    for at in places(e):
        assert float(e.sel(at)) == rs.standard_solid_restitution(at["nu"], 0.1, at["p3"])


def test_some_of_the_impacts_by_coordinates():
    velocity = xr.DataArray([0.5, 1.0, 2.0], dims="velocity", coords={"velocity": [0.5, 1.0, 2.0]})
    result = rs.solve(
        rs.Impact(solid(along("viscosity", 500.0, 2e3).sortby("viscosity")), rs.Parabola(0.01), 0.005, velocity)
    )
    item = result.sel({"viscosity": 1000.0, "velocity": 1.4}, method="nearest")
    assert item.velocity == 1.0
    assert item.history.sizes == {"time": 401}
    rows = result.sel(velocity=[2.0, 0.5])
    assert rows.restitution_coefficient.dims == ("viscosity", "velocity")
    expected = result.restitution_coefficient.sel(velocity=[2.0, 0.5])
    xr.testing.assert_identical(rows.restitution_coefficient, expected)
    assert rows.impact.sel(velocity=2.0).axes.names == ("viscosity",)


def test_a_result_with_axes_can_be_shown_pickled_and_copied():
    result = rs.solve(rs.Impact(solid(), rs.Parabola(0.01), 0.005, along("velocity", 0.5, 2.0)))
    assert "restitution coefficient" in str(result)
    assert len(result.to_dict()["restitution_coefficient"]) == result.velocity.size
    assert result.plot().axes
    again = copy.deepcopy(pickle.loads(pickle.dumps(result)))
    xr.testing.assert_identical(again.restitution_coefficient, result.restitution_coefficient)
    first = float(result.velocity[0])
    assert again.sel(velocity=first).contact_time == float(result.contact_time[0])


def test_numbers_without_names_give_arrays():
    result = rs.solve(rs.Impact(solid(xr.DataArray(1e3)), rs.Parabola(0.01), 0.005, [0.5, 1.0]))
    assert type(result.restitution_coefficient) is np.ndarray
    assert result.to_dataset().restitution_coefficient.dims == ("dim_0",)
    with pytest.raises(rs.InputError, match="must have named axes"):
        result.sel(velocity=0.5)


@pytest.mark.parametrize(
    ("field", "build"),
    [
        ("mass", lambda v: rs.Impact(solid(), rs.Parabola(0.01), [0.005, 0.006], v)),
        ("profile, velocity", lambda v: rs.Impact(solid(), rs.Parabola(v[:1] * 0.01), 0.005, v)),
        ("velocity", lambda v: rs.Impact(solid(), rs.Parabola(0.01), 0.005, -v)),
        ("velocity", lambda v: rs.Impact(solid(), rs.Parabola(0.01), 0.005, v.assign_attrs(units="kg"))),
        ("indexers", lambda v: rs.Impact(solid(), rs.Parabola(0.01), 0.005, v).sel(nonsense=1.0)),
        ("indexers", lambda v: rs.Impact(solid(), rs.Parabola(0.01), 0.005, v).sel(velocity=7.0)),
        (
            "velocity",
            lambda v: replace(rs.Impact(solid(v * 1e3), rs.Parabola(0.01), 0.005, 1.0), velocity=[1.0, 2.0, 3.0]),
        ),
    ],
)
def test_what_does_not_fit_is_refused(field, build):
    velocity = xr.DataArray([0.5, 1.0], dims="velocity", coords={"velocity": [0.5, 1.0]})
    assert in_one_line(lambda: build(velocity)).field == field


def test_arrays_over_random_dimensions_spread_as_xarray_broadcasts():
    for _ in range(30):
        sizes = dict(zip("abcd", RNG.integers(1, 4, 4), strict=True))
        arrays = []
        for _ in range(3):
            names = RNG.permutation(list("abcd"))[: RNG.integers(0, 4)]
            arrays.append(xr.DataArray(RNG.normal(size=[sizes[name] for name in names]), dims=tuple(names)))
        values, axes = aligned(dict(zip("xyz", arrays, strict=True)))
        if axes is None:
            assert not any(array.dims for array in arrays)
            continue
        expected = sum(arrays, start=xr.DataArray(0.0))
        total = np.broadcast_to(sum(np.asarray(value) for value in values.values()), axes.shape)
        np.testing.assert_array_equal(total, expected.transpose(*axes.names).values)
        names = tuple(RNG.permutation([*axes.names, "more"]))
        spread = spread_array(total, axes, names, total.shape)
        assert spread.shape == tuple(dict(zip(axes.names, axes.shape, strict=True)).get(name, 1) for name in names)
        there = [name for name in names if name in axes.names]
        np.testing.assert_array_equal(spread.reshape(spread.size), expected.transpose(*there).values.ravel())


def test_a_list_has_one_dimension_that_is_no_axis():
    moduli = xr.DataArray(np.ones((2, 3)), dims=("temperature", "branch"))
    assert axes_of(moduli).names == ("temperature", "branch")
    assert axes_of(moduli, is_list=True).names == ("temperature",)
    assert axes_of(moduli[0], is_list=True) is None
    assert isinstance(axes_of(rs.PronySeries(1.0, moduli, np.ones(3))), Axes)
