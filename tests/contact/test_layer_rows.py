"""Tables of many thicknesses tables together, against the geometry of each thickness, which has its own tables."""

from typing import Any

import numpy as np
import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st

import restitution as rs
from restitution.contact.layer import contacts as module
from restitution.contact.layer.contacts import contacts
from restitution.contact.layer.layer import LayerRows
from restitution.contact.table import evaluate

R = np.linspace(0.0, 6.0, 13)
PROFILES = {
    "sphere": rs.Sphere(1.0),
    "truncated": rs.TruncatedCone(0.1, 1.2),
    "worn": rs.FlatEndedParabola(2.0, 0.3),
    "measured": rs.Tabulated(R, R**2 / 4.0 + R**3 / 40.0),
    "joints": rs.Tabulated(np.array([0.0, 0.3, 0.5, 0.9, 2.0, 5.0]), np.array([0.0, 0.0, 0.05, 0.2, 1.2, 8.0])),
}
RTOL = 1e-10


def single(profile: Any, thickness: float, nu: float | None) -> Any:
    base: Any = "frictionless" if nu is None else "bonded"
    bulk = np.inf if nu == 0.5 else 2.0 * (1.0 + (nu or 0.0)) / (3.0 * (1.0 - 2.0 * (nu or 0.0)))
    return rs.Layer(profile, thickness, base).between(rs.Material(1.0, bulk), None)


def compare(rows: LayerRows, tables: Any, least: Any, chosen: Any) -> None:
    heights = np.unique(rows.thickness)
    for k in chosen:
        table, depth_unit, radius_unit = tables.table.single(k), tables.depth[k], tables.radius[k]
        layer = single(rows.profile, float(heights[k]), rows.poisson_ratio)
        s = np.sqrt(np.linspace(max(float(least[k]) / depth_unit, 0.01), 1.0, 120))
        radius, _, integral = evaluate(table, s)
        depth = np.minimum(s * s * depth_unit, layer.max_depth)
        # The stated error of the table, and that of the layer with the rounding of the depth at the end.
        bound = RTOL + max(RTOL, float(table.error_at(s[0] * s[0])))
        assert integral * depth_unit * radius_unit == pytest.approx(layer.force_integral_at_depth(depth), rel=bound)
        exact = layer.stiffness_radius(depth)
        # Forces depend on the radius through its integral; at joints the radius alone has larger errors.
        assert np.max(np.abs(radius * radius_unit - exact)) <= (table.radius_error + 1e-9) * 3.0 * exact[-1]


@settings(deadline=None, max_examples=5)
@given(
    name=st.sampled_from(sorted(PROFILES)),
    nu=st.sampled_from([0.5, 0.3, None]),
    low=st.floats(0.1, 2.0),
    span=st.floats(1.5, 300.0),
    seed=st.integers(0, 1000),
)
# Rounding of the depth at a joint tables the force 4e-9 wrong behind it.
@example(name="joints", nu=0.5, low=0.3125, span=2.0, seed=0)
def test_tables_of_many_thicknesses_are_those_of_each(name, nu, low, span, seed):
    rng = np.random.default_rng(seed)
    thickness = low * span ** rng.uniform(0.0, 1.0, 90)
    rows = LayerRows(PROFILES[name], thickness, nu)
    least = np.full(90, 0.02) * rng.uniform(0.1, 1.0)
    tables = rows.tables(np.full(90, 0.2), least, RTOL)
    # Each table, and the last terms of the interpolation over ln h, which may be three times as large.
    assert max(tables.table.single(k).error_at(0.1) for k in range(90)) < 4.0 * RTOL
    compare(rows, tables, least, rng.integers(0, 90, 2))


def test_tables_that_are_interpolated_start_exactly_at_the_kinks():
    rng = np.random.default_rng(0)
    rows = LayerRows(PROFILES["joints"], 0.109375 * 2.0 ** rng.uniform(0.0, 1.0, 90), 0.5)
    least = np.full(90, 0.02) * rng.uniform(0.1, 1.0)
    compare(rows, rows.tables(np.full(90, 0.2), least, RTOL), least, range(0, 90, 18))


@pytest.mark.parametrize("name", ["worn", "joints"])
def test_tables_do_not_depend_on_earlier_ones(name, monkeypatch):
    # Thin layers halve the cells that thick ones have.
    monkeypatch.setattr(module, "_TYPICAL", np.array([1e3]))
    rng = np.random.default_rng(5)
    profile, arguments = PROFILES[name], (np.full(40, 0.2), np.full(40, 0.02), RTOL)
    rows = [LayerRows(profile, 0.3 * 100.0 ** rng.uniform(0.0, 1.0, 40), 0.5) for _ in range(3)]
    alone = []
    for row in rows:
        contacts.cache_clear()
        alone.append(row.tables(*arguments))
    contacts.cache_clear()
    for row, expected in zip([*rows, *rows], [*alone, *alone], strict=True):
        result = row.tables(*arguments)
        for x, y in zip([*result.table, *result[1:]], [*expected.table, *expected[1:]], strict=True):
            assert np.array_equal(x, y)
    assert contacts.cache_info().hits
    contacts.cache_clear()


@pytest.mark.parametrize("name", ["sphere", "joints"])
def test_an_interpolation_that_is_not_accurate_is_not_used(name, monkeypatch):
    rows = LayerRows(PROFILES[name], np.geomspace(0.3, 3.0, 40), 0.5)
    arguments = np.full(40, 0.2), np.full(40, 0.02), RTOL
    smooth = rows.tables(*arguments)
    monkeypatch.setattr(module, "_NODES", 100)
    direct = rows.tables(*arguments)
    # Six nodes leave a tail.
    monkeypatch.setattr(module, "_NODES", -4)
    coarse = rows.tables(*arguments)
    for n in range(40):
        fine, full, coarse_table = (result.table.single(n) for result in (smooth, direct, coarse))
        assert all(np.array_equal(x, y) for x, y in zip(full, coarse_table, strict=True))
        s = np.linspace(0.05, 1.0, 50)
        assert evaluate(fine, s)[2] == pytest.approx(evaluate(full, s)[2], abs=5.0 * RTOL)
    assert not np.array_equal(smooth.table.radius, direct.table.radius)
    assert np.max(smooth.table.errors) > 0.5 * np.max(direct.table.errors)


@settings(deadline=None, max_examples=30)
@given(exponent=st.floats(-10.0, -8.0))
def test_tables_reach_the_end_of_a_tiny_profile(exponent):
    # The logarithm of the last depth has the largest rounding errors there.
    unit = 10.0**exponent
    profile = rs.Tabulated(unit * np.array([0.0, 0.3, 0.5, 1.0]), unit * np.array([0.0, 0.05, 0.2, 0.9]))
    rows = LayerRows(profile, unit * np.array([2.0, 3.0]), 0.5)
    tables = rows.tables(np.full(2, 1e3 * unit), np.full(2, 0.01 * unit), 1e-6)
    assert tables.depth == pytest.approx(rows.max_depth, rel=1e-10)


def test_tables_end_where_the_contact_is_forty_thicknesses_wide():
    # The face has a radius of 0.3, so that 40 h is beyond it.
    thickness = np.array([0.01, 0.02, 0.03, 0.5])
    rows = LayerRows(PROFILES["worn"], thickness, 0.3).raveled((4,))
    tables = rows.tables(np.full(4, 10.0), np.full(4, 0.01), RTOL)
    assert tables.depth[:3].tolist() == pytest.approx(rows.max_depth[:3].tolist(), rel=1e-10)


def test_kinks_are_those_of_single_layers():
    thickness = np.array([0.5, 1.0, 4.0])
    tables = LayerRows(PROFILES["joints"], thickness, 0.3).tables(np.full(3, 0.5), np.full(3, 0.05), RTOL)
    for n, (h, depth, radius) in enumerate(zip(thickness, tables.depth, tables.radius, strict=True)):
        table = tables.table.single(n)
        kinks = single(PROFILES["joints"], float(h), 0.3).kinks
        place = np.sqrt(kinks.depth / depth)
        near = np.array([int(np.argmin(np.abs(place - kink))) for kink in table.kinks])
        assert near.size
        assert table.kinks == pytest.approx(place[near], rel=1e-9)
        # A single layer has the slope of the depth from differences between its samples.
        strength = kinks.strength[near] * depth**kinks.power / radius * (2.0 * place[near]) ** kinks.power
        assert table.strengths == pytest.approx(strength, rel=0.01)


def test_rows_have_the_values_of_single_layers():
    thickness = np.array([[0.5, 2.0], [1.0, 0.5]])
    rows = LayerRows(PROFILES["sphere"], thickness, 0.3).raveled((2, 2))
    depth = np.array([0.1, 0.2, 0.3, 0.4])
    layers: list[Any] = [single(PROFILES["sphere"], h, 0.3) for h in thickness.ravel()]
    for name in ("stiffness_radius", "force_integral_at_depth", "contact_radius"):
        expected = [float(getattr(layer, name)(d)) for layer, d in zip(layers, depth, strict=True)]
        assert getattr(rows, name)(depth) == pytest.approx(expected, rel=1e-14)
    stiffness = rows.stiffness_radius(depth)
    assert rows.contact_radius_at(depth, stiffness) == pytest.approx(rows.contact_radius(depth), rel=1e-10)
    assert rows.max_depth == pytest.approx([layer.max_depth for layer in layers], rel=1e-11)
    several: Any = rs.Layer(PROFILES["sphere"], thickness).between(rs.Material(1.0, 2.6 / 1.2), None)
    assert several.stiffness_radius(depth.reshape(2, 2)).ravel().tolist() == rows.stiffness_radius(depth).tolist()
    assert several.stiffness_radius(0.1).shape == (2, 2)


def test_layers_under_bodies_of_several_sizes_end_where_each_of_them_ends():
    radii = [1.0, 2.0]
    several = single(rs.Sphere(radii), 0.5, 0.5)
    each = [single(rs.Sphere(radius), 0.5, 0.5) for radius in radii]
    assert several.max_depth.tolist() == [layer.max_depth for layer in each]
    assert single(rs.FlatPunch([0.1, 0.2]), 0.5, 0.5).max_depth == np.inf
    with pytest.raises(rs.InputError, match=r"^thickness\[0\] = 0\.001 m: must be above 0\.005 m"):
        single(rs.FlatPunch([0.1, 0.2]), 0.001, 0.5).stiffness_radius(0.1)
