"""Bonded layers whose Poisson ratio relaxes: the separable approximation."""

import math
import warnings
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

import restitution as rs
from refusals import named
from restitution.contact.layer import moduli as moduli_module
from restitution.contact.layer.moduli import EffectiveModuli, effective_moduli, effective_modulus
from restitution.impact.batch import Batch
from restitution.law.law import reduced_series
from restitution.material.prony import PronySeries
from restitution.material.viscoelastic import reduced_modulus
from restitution.tally import Tally
from restitution.validity import numbers

# Static Poisson ratio, p2, thickness, e by finite elements in time, and errors in per cent of e, of the contact time
# and of the largest force: with E*(t), and with the effective modulus. Independent programs; table of the theory page.
approximate = pytest.mark.filterwarnings("ignore::restitution.errors.RestitutionWarning")
ROWS = [
    (0.45, 0.1, 0.9, 0.44074, (-11, -7.5, 8.0), (0.1, -0.4, 4.7)),
    (0.45, 0.1, 0.3, 0.57033, (-14, -20, 22), (-0.5, -4.1, 9.7)),
    (0.49, 0.1, 0.4, 0.47230, (-15, -9, 8), (-0.4, -1.2, 5.7)),
    (0.30, 0.1, 0.4, 0.44060, (0.9, -11, 9), (0.0, -2.5, 2.5)),
    (0.45, 1.0, 0.3, 0.93595, (-2.6, -6.7, 8.0), (-0.1, -1.3, 3.6)),
    (0.30, 1.0, 0.4, 0.91571, (-1.6, -4.2, 4.3), (-0.1, -0.7, 1.4)),
]


def solid(poisson_ratio, p2=0.1):
    return rs.standard_solid(1.0, 1.0 / p2, 1.0, poisson_ratio=poisson_ratio)


def of_contact(material, result, layer):
    """The modulus of an impact or indentation, from the largest contact of a first solution."""
    return effective_moduli(material).at(np.array([0.8 * result.max_contact_radius / layer.thickness])).row(0)


def on_layer(material, thickness: Any = 0.4, **body: Any) -> Any:
    layer = rs.Layer(rs.Parabola(1.0), thickness=thickness, strict=False)
    arguments: Any = {"mass": 1.0, "velocity": 1.0} | body
    return rs.Impact(material, layer, **arguments)


def solved(impact, *options: Any, **named: Any) -> Any:
    return rs.solve(impact, *options, **named)


def random_material(rng) -> Any:
    """Material whose Poisson ratio relaxes, a liquid now and then, with a bulk modulus that may relax."""
    shear = rs.PronySeries(
        rng.choice([0.0, 1.0]), 10.0 ** rng.uniform(-1.0, 1.0, 2), 10.0 ** rng.uniform(-3.0, 0.0, 2)
    )
    bulk = rs.PronySeries(rng.uniform(1.0, 30.0), 10.0 ** rng.uniform(-1.0, 1.0, 1), 10.0 ** rng.uniform(-2.0, 0.0, 1))
    return rs.Material(shear, bulk if rng.random() < 0.5 else rng.uniform(1.0, 30.0))


def random_layer(rng) -> Any:
    profiles = rs.Parabola(rng.uniform(0.5, 2.0)), rs.Cone(rng.uniform(0.8, 1.3)), rs.Sphere(rng.uniform(2.0, 4.0))
    return rs.Layer(profiles[rng.integers(3)], thickness=10.0 ** rng.uniform(-0.5, 0.5))


def ordinary(material, series):
    """Material of the same static Poisson ratio, constant in time, with a given reduced modulus."""
    nu = material.poisson_ratio
    shear = series.scaled(0.5 * (1.0 - nu))
    return rs.Material(shear, shear.scaled(2.0 / 3.0 * (1.0 + nu) / (1.0 - 2.0 * nu)) if nu < 0.5 else math.inf)


def punch_stiffness(size, poisson_ratio):
    """Stiffness kappa of a flat punch, by Gauss nodes over cosines: layers.md, section 2, with other quadratures."""
    x, w = np.polynomial.legendre.leggauss(int(40 + 8 * size))
    y, w = 0.5 * size * (x + 1.0), 0.5 * size * w
    cells = int(20 + 20 * size)
    nodes, weights = np.polynomial.legendre.leggauss(12)
    z = (30.0 / cells * (np.arange(cells)[:, None] + 0.5 + 0.5 * nodes)).ravel()
    n = 3.0 - 4.0 * poisson_ratio
    compliance = (2 * n * np.sinh(2 * z) - 4 * z) / (2 * n * np.cosh(2 * z) + 1 + n * n + 4 * z * z)
    lines = np.cos(np.outer(y, z))
    kernel = (2.0 / np.pi) * (lines * (np.tile(15.0 / cells * weights, cells) * (1.0 - compliance))) @ lines.T
    return float(w @ np.linalg.solve(np.eye(y.size) - kernel * w, np.ones(y.size))) / size


@approximate
@pytest.mark.parametrize(("poisson_ratio", "p2", "thickness", "e", "first", "second"), ROWS)
def test_impacts_have_the_stated_differences_from_finite_elements(poisson_ratio, p2, thickness, e, first, second):
    impact = on_layer(solid(poisson_ratio, p2), thickness)
    result = solved(impact)
    # The errors are printed to 0.1 %.
    assert result.restitution_coefficient == pytest.approx(e * (1.0 + 0.01 * second[0]), rel=7e-4)
    # E*(t) errs by whole per cent, which the finite elements link with the approximation.
    plain = Batch.from_impact(impact, reduced_modulus(impact.material)).solve(1e-9)
    for name, error, other in zip(
        ("restitution_coefficient", "contact_time", "max_force"), first, second, strict=True
    ):
        ratio = getattr(result, name) / plain[name][0]
        assert ratio == pytest.approx((1.0 + 0.01 * other) / (1.0 + 0.01 * error), rel=0.01)


def test_a_flat_punch_has_the_effective_modulus():
    rng = np.random.default_rng(8)
    for _ in range(5):
        material = random_material(rng)
        # A thin layer that is nearly incompressible is the hardest.
        size, s = 10.0 ** rng.uniform(-1.0, 1.4), 10.0 ** rng.uniform(-2.0, 4.0)
        shear, bulk = material.shear.carson_transform(s), material.bulk.carson_transform(s)
        ratio = (3.0 * bulk - 2.0 * shear) / (6.0 * bulk + 2.0 * shear)
        stiffness = [punch_stiffness(size, nu) for nu in (ratio, material.poisson_ratio)]
        expected = reduced_modulus(material).carson_transform(s) * stiffness[0] / stiffness[1]
        assert effective_modulus(material, size).carson_transform(s) == pytest.approx(expected, rel=5e-4)


@pytest.mark.slow
def test_a_thin_layer_of_a_liquid_is_incompressible_after_a_long_time():
    material, size = rs.Material(rs.PronySeries(0.0, [10.0], [0.1]), 20.0), 25.0
    result = effective_modulus(material, size)
    # Compressible until 1 - 2 nu, about G/K, falls below (h/a)^2.
    for s in (1e-4, 1e-3, 1e-2, 0.1):
        shear = material.shear.carson_transform(s)
        ratio = (60.0 - 2.0 * shear) / (120.0 + 2.0 * shear)
        share = punch_stiffness(size, ratio) / punch_stiffness(size, 0.5)
        expected = reduced_modulus(material).carson_transform(s) * share
        assert result.carson_transform(s) == pytest.approx(expected, rel=5e-4)


def test_a_constant_poisson_ratio_leaves_the_modulus_as_it_is():
    shear = rs.PronySeries(1.0, [5.0], [0.1])
    material = rs.Material(shear, shear.scaled(2.0))
    impact = on_layer(material)
    assert impact.profile.separable
    assert impact.reduced_modulus == reduced_modulus(material)
    # The approximation itself has the same limit.
    result = effective_modulus(rs.Material(shear, rs.PronySeries(2.0, [10.0 + 1e-7], [0.1])), 1.0)
    for s in (1e-2, 1.0, 10.0, 1e4):
        assert result.carson_transform(s) == pytest.approx(impact.reduced_modulus.carson_transform(s), rel=1e-6)


@approximate
def test_an_impact_is_that_of_an_ordinary_material_with_the_effective_modulus():
    rng = np.random.default_rng(9)
    for _ in range(4):
        material, layer = random_material(rng), random_layer(rng)
        impact = rs.Impact(
            material, layer, mass=10.0 ** rng.uniform(-1.0, 1.0), velocity=10.0 ** rng.uniform(-1.5, 0.0)
        )
        first = solved(replace(impact, material=ordinary(material, reduced_modulus(material))))
        series = of_contact(material, first, layer)
        expected = solved(replace(impact, material=ordinary(material, series)))
        result = solved(impact)
        for name in ("restitution_coefficient", "contact_time", "max_force", "max_contact_radius"):
            assert getattr(result, name) == pytest.approx(getattr(expected, name), rel=1e-8)
        assert expected.impact.profile.separable
        assert not result.impact.profile.separable


@approximate
def test_the_same_impact_has_the_same_numbers_alone_in_a_list_in_an_array_and_in_a_sweep():
    rng = np.random.default_rng(10)
    names = ("restitution_coefficient", "contact_time", "max_force", "max_contact_radius", "dissipated_energy")
    for _ in range(4):
        impact = rs.Impact(random_material(rng), random_layer(rng), mass=rng.uniform(0.1, 2.0), velocity=1.0)
        velocities = np.sort(10.0 ** rng.uniform(-1.5, 0.0, 3))
        alone = [solved(replace(impact, velocity=velocity)).outputs for velocity in velocities.tolist()]
        ways = [
            solved([replace(impact, velocity=velocity) for velocity in velocities.tolist()]).outputs,
            solved(replace(impact, velocity=velocities)).outputs,
            rs.sweep(impact, {"velocity": velocities}, names),
        ]
        for way in ways:
            for name in names:
                # The table of a profile is that of the deepest impact, with the error of the default tolerance.
                np.testing.assert_allclose(np.asarray(way[name]), [outputs[name] for outputs in alone], rtol=2e-9)


@approximate
def test_an_array_of_thicknesses_has_an_effective_modulus_for_each():
    thickness = np.array([[0.3], [0.9]])
    impact = on_layer(solid(0.45), thickness, velocity=np.array([0.2, 1.0]))
    result = solved(impact).restitution_coefficient
    for i, j in np.ndindex(2, 2):
        single = on_layer(solid(0.45), thickness[i, 0], velocity=impact.velocity[j])
        assert result[i, j] == pytest.approx(solved(single).restitution_coefficient, rel=1e-9)
    with pytest.raises(rs.InputError, match=r"^impact: must be a single one"):
        _ = impact.reduced_modulus


@approximate
def test_impacts_that_end_deep_in_the_layer_keep_their_status_beside_others():
    result = solved(on_layer(solid(0.3), velocity=[1.0, 1e9]))
    assert [rs.Status(int(status)).name for status in result.status] == ["SEPARATED", "TOO_DEEP"]
    assert result.restitution_coefficient[0] == pytest.approx(solved(on_layer(solid(0.3))).restitution_coefficient)


@approximate
@pytest.mark.parametrize("name", ["depth", "force"])
def test_an_indentation_has_the_effective_modulus_of_its_largest_contact(name):
    rng = np.random.default_rng(11)
    for _ in range(2):
        material, layer = random_material(rng), random_layer(rng)
        history: Any = {name: rs.triangle(rng.uniform(0.01, 0.05), 10.0 ** rng.uniform(-2.0, 0.0))}
        first = rs.indent(ordinary(material, reduced_modulus(material)), layer, **history)
        series = of_contact(material, first, layer)
        expected = rs.indent(ordinary(material, series), layer, **history)
        result = rs.indent(material, layer, **history)
        for item in ("max_force", "max_indentation_depth", "contact_end_time", "work"):
            assert getattr(result, item) == pytest.approx(getattr(expected, item), rel=1e-6)


@approximate
def test_bounces_surrogates_and_contact_laws_take_the_approximation():
    impact = on_layer(solid(0.45, 1.0), thickness=2.0, velocity=3.0)
    series = rs.bounces(impact, with_weight=False, gravity=0.1, max_bounces=2)
    for n in range(2):
        single = solved(replace(impact, velocity=series.velocity[n]))
        assert series.restitution_coefficient[n] == pytest.approx(single.restitution_coefficient, rel=1e-9)
    curve = rs.surrogate(impact, (0.1, 1.0), rtol=1e-6)
    speed = float(np.random.default_rng(12).uniform(0.1, 1.0))
    assert curve(speed) == pytest.approx(solved(replace(impact, velocity=speed)).restitution_coefficient, rel=1e-6)
    law = rs.contact_law(impact)
    assert law.modulus == impact.reduced_modulus
    assert all("a bonded layer is approximate then" in item.warnings[-1] for item in (series, curve))


def test_a_reduced_law_keeps_the_poisson_ratio_of_its_layer():
    # One term for one branch: the reduced series is the series itself, so that there is no error.
    impact = on_layer(ordinary(solid(0.3), rs.PronySeries(1.0, [10.0], [0.1])))
    series, error = reduced_series(impact, impact.reduced_modulus, 1)
    assert error < 1e-6
    assert series.relaxation_times == pytest.approx([0.1], rel=1e-4)


def test_a_flat_punch_is_exact():
    punch = rs.Layer(rs.FlatPunch(0.5), thickness=0.4, strict=True)
    material = solid(0.3)
    series = effective_modulus(material, 0.5 / 0.4)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        result = rs.indent(material, punch, depth=rs.triangle(0.1, 1.0))
        expected = rs.indent(ordinary(material, series), punch, depth=rs.triangle(0.1, 1.0))
        impact = rs.Impact(material, punch, mass=1.0, velocity=1.0)
        e = solved(impact).restitution_coefficient
    assert result.max_force == pytest.approx(expected.max_force, rel=1e-6)
    assert e == pytest.approx(
        solved(replace(impact, material=ordinary(material, series))).restitution_coefficient, rel=1e-8
    )


def layer_warnings(action) -> list[str]:
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        action()
    return [str(warning.message) for warning in caught if "bonded layer is approximate" in str(warning.message)]


def test_the_approximation_is_named_once_with_its_size():
    material, impact = solid(0.3), on_layer(solid(0.3))
    text = "separability: the Poisson ratio relaxes from -0.443 to 0.3, and a bonded layer is approximate then"
    advice = ". Expect errors of some 0.5 % of e, 4 % of the contact time and 10 % of the force."
    half_space = replace(impact, profile=rs.Parabola(1.0))
    tries = [
        ("", lambda: solved(impact)),
        ("", lambda: rs.indent(material, impact.profile, depth=rs.triangle(0.1, 1.0))),
        ("; exceeded in 2 of 2 impacts", lambda: solved(replace(impact, velocity=[0.5, 1.0]))),
        ("; exceeded in 1 of 2 impacts", lambda: solved([impact, half_space])),
        ("; exceeded in 2 of 2 impacts", lambda: rs.sweep(impact, {"velocity": [0.5, 1.0]})),
    ]
    for counts, action in tries:
        assert layer_warnings(action) == [text + counts + advice]
    assert layer_warnings(lambda: rs.contact_law(impact)) == [
        f"contact{text}{advice}".replace("separability:", " law:", 1)
    ]
    # Nothing is solved yet.
    assert layer_warnings(lambda: replace(impact, material=solid(0.4))) == []
    assert "separability" not in solved(half_space).validity.to_dict()
    frictionless = replace(impact, profile=replace(impact.profile, base="frictionless"))
    assert layer_warnings(lambda: solved(frictionless)) == []


def test_a_poisson_ratio_that_leaves_the_range_of_its_ends_is_named():
    # (3K - 2G)/(6K + 2G) is 0.35 at both ends, where K = 3 G, and 0.2273 for G = 2 and K = 3.
    material = rs.Material(rs.PronySeries(1.0, [1.0], [1e2]), rs.PronySeries(3.0, [3.0], [1e-4]))
    words = "the Poisson ratio relaxes from 0.35 to 0.35, by way of 0.228, and a bonded layer"
    assert layer_warnings(lambda: rs.contact_law(on_layer(material)))[0].startswith(f"contact law: {words}")
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        assert words in rs.solve(on_layer(material)).validity["separability"].message


def test_a_tally_counts_the_approximation():
    contact, tally = on_layer(solid(0.3)).contact, Tally()
    tally.add(numbers(contact, max_contact_radius=0.1, max_indentation_depth=0.01, velocity=1.0, contact_time=0.1))
    check = tally.report(2)["separability"]
    assert check.message.endswith("exceeded in 1 of 1 impacts checked, of 2")
    assert (check.value, check.threshold) == pytest.approx((-0.443, 0.3), abs=1e-3)


def test_strict_layers_refuse_the_approximation():
    strict = rs.Layer(rs.Parabola(1.0), thickness=0.4, strict=True)
    rubber = rs.Impact(solid(0.5), strict, mass=1.0, velocity=1.0)
    dashpot = rs.kelvin_voigt(1.0, 1.0, bulk_modulus=3.0)
    with pytest.raises(rs.InputError, match=r"^material: must have a Poisson ratio .* or stays above 0\.498"):
        replace(rubber, material=solid(0.3))
    with pytest.raises(rs.InputError, match=r"^material: must have no parallel dashpot on a bonded layer"):
        on_layer(dashpot)
    begun = {"progress": lambda *_: pytest.fail("work began")}
    assert named(lambda: rs.sweep(rubber, {"poisson_ratio": [0.3, 0.5]}, **begun)) == ("material",)
    assert named(lambda: rs.indent(solid(0.3), strict, depth=rs.triangle(0.1, 1.0))) == ("material",)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        solved(replace(rubber, material=solid(0.3), profile=replace(strict, base="frictionless")))


@approximate
def test_interpolated_moduli_give_the_restitution_of_the_direct_fit():
    rng = np.random.default_rng(13)
    for _ in range(6):
        material, thickness = random_material(rng), 10.0 ** rng.uniform(-1.2, 0.5)
        speed = thickness * math.sqrt(material.shear.instantaneous_modulus)
        impact = on_layer(material, thickness, velocity=10.0 ** rng.uniform(-2.5, 0.0, 3) * speed)
        series = reduced_modulus(material)
        radii = 0.8 * Batch.from_impact(impact, series).max_contact_radii(1e-9) / thickness
        direct = PronySeries.stacked([effective_modulus(material, radius) for radius in radii.tolist()])
        expected, result = Batch.from_impact(impact, direct).solve(1e-9), solved(impact)
        # The approximation itself has errors of 0.5 % of e, 4 % of the time and 10 % of the force.
        assert result.restitution_coefficient == pytest.approx(expected["restitution_coefficient"], abs=6e-4)
        ends = np.isfinite(expected["contact_time"])
        assert result.contact_time[ends] == pytest.approx(expected["contact_time"][ends], rel=3e-3)
        assert result.max_force == pytest.approx(expected["max_force"], rel=5e-4)


@pytest.mark.slow
@approximate
def test_a_thin_layer_of_a_liquid_with_many_times_is_not_refused():
    # The stiffness varies so much over the radius that what the splines combine does not only relax.
    shear = rs.PronySeries(0.0, 10.0 ** np.linspace(7.0, 4.0, 20), 10.0 ** np.linspace(-8.0, 0.0, 20))
    material, times = rs.Material(shear, 3e7), np.geomspace(1e-7, 1e-1, 7)
    radii = np.array([3.0, 10.0, 25.0])
    result = effective_moduli(material).at(radii).column.relaxation_modulus(times)
    expected = [effective_modulus(material, radius).relaxation_modulus(times) for radius in radii.tolist()]
    np.testing.assert_allclose(result, expected, rtol=5e-3)


def test_interpolated_moduli_are_those_of_the_punch_alone_and_beside_others():
    rng = np.random.default_rng(14)
    material = random_material(rng)
    radii = 10.0 ** rng.uniform(-3.0, 0.9, 40)
    many = EffectiveModuli(material).at(radii)
    for n in rng.permutation(radii.size).tolist():
        # Each with nodes of its own.
        item = EffectiveModuli(material) if n < 3 else effective_moduli(material)
        alone = item.at(radii[n : n + 1]).row(0)
        assert alone.branch_moduli.tolist() == many.row(n).branch_moduli.tolist()
        assert alone.relaxation_times.tolist() == many.row(n).relaxation_times.tolist()


def test_interpolated_moduli_are_smooth_and_start_at_the_modulus_of_the_material():
    material, times = solid(0.45), np.geomspace(1e-3, 1e2, 30)
    nodes = 0.25 * np.expm1(0.2 * np.arange(1, 12))
    sides = [effective_moduli(material).at(nodes * (1.0 + side)) for side in (-1e-9, 1e-9)]
    below, above = (side.column.relaxation_modulus(times) for side in sides)
    np.testing.assert_allclose(below, above, rtol=1e-7)
    start = effective_moduli(material).at(np.zeros(1)).row(0)
    for s in (1e-2, 1.0, 1e2):
        assert start.carson_transform(s) == pytest.approx(reduced_modulus(material).carson_transform(s), rel=5e-4)


def test_merged_terms_have_the_moments_of_the_others():
    rng = np.random.default_rng(16)
    moduli, times = 10.0 ** rng.uniform(-3.0, 1.0, (7, 50)), np.sort(10.0 ** rng.uniform(-1.0, 0.0, 7))
    # One term, two, three, and none.
    moduli[1:, 0] = moduli[2:, 1] = moduli[3:, 2] = moduli[:, 3] = 0.0
    result, places = moduli_module._merged(moduli, times)
    assert np.all(result >= 0.0)
    assert np.all(np.isfinite(places))
    y = np.log(times)[:, None]
    for power in range(6):
        expected, moments = np.sum(moduli * y**power, axis=0), np.sum(result * np.log(places) ** power, axis=0)
        np.testing.assert_allclose(moments, expected, rtol=1e-7, atol=1e-7)
    s = np.geomspace(1e-3, 1e3, 40)[:, None, None]
    transforms = [
        np.sum(weights * s * tau / (1.0 + s * tau), axis=1)
        for weights, tau in ((moduli, times[:, None]), (result, places))
    ]
    assert np.all(np.abs(transforms[1] - transforms[0]) <= 1e-5 * np.sum(moduli, axis=0))


# Versions of nonnegative least squares find other terms far from those of the material, each of its own.
@pytest.mark.parametrize(("branches", "most"), [(1, 6), (2, 11), (10, 16)])
def test_merged_terms_are_few_and_change_little(monkeypatch, branches, most):
    times = np.geomspace(1e-5, 1e-1, branches) if branches > 1 else [1e-3]
    material = rs.Material(rs.PronySeries(1e6, np.full(branches, 1e7 / branches), times), 3e7)
    places = np.random.default_rng(17).uniform(0.05, 0.7, 8)
    merged = effective_moduli(material).at(places)
    monkeypatch.setattr(moduli_module, "_MERGED", 1000)
    expected, s = effective_moduli(material).at(places), np.geomspace(1.0, 1e6, 50)
    assert merged.n_branches <= most
    for n in range(places.size):
        transform, other = (series.row(n).carson_transform(s) for series in (merged, expected))
        np.testing.assert_allclose(transform, other, rtol=1e-5)


@approximate
@pytest.mark.parametrize("profile", [rs.Parabola(1.0), rs.Cone(1.1)])
def test_smooth_tables_keep_the_tolerance(profile):
    rng = np.random.default_rng(18)
    for poisson_ratio in (0.3, 0.45, 0.49):
        layer = rs.Layer(profile, thickness=10.0 ** rng.uniform(-0.7, 0.5))
        impact = rs.Impact(
            solid(poisson_ratio, 10.0 ** rng.uniform(-1.5, 0.0)), layer, 1.0, 10.0 ** rng.uniform(-2, 0, 20)
        )
        assert impact.profile.smooth
        e, expected = (solved(impact, rtol=rtol).restitution_coefficient for rtol in (1e-9, 1e-12))
        np.testing.assert_allclose(e, expected, rtol=1e-9)
    assert not replace(impact, profile=replace(layer, profile=rs.Sphere(2.0))).profile.smooth
    assert not replace(impact, material=ordinary(impact.material, impact.material.shear)).profile.smooth


@approximate
@pytest.mark.parametrize("force", [0.0, 0.5])
def test_approaches_alone_have_the_contact_radii_of_whole_impacts(force):
    rng = np.random.default_rng(15)
    for material in (solid(0.3), solid(0.45, 0.01), rs.Material(rs.PronySeries(0.0, [10.0], [0.1]), 20.0)):
        # The last ones are captured under the force, or end beyond the tables.
        velocity = np.append(10.0 ** rng.uniform(-2.0, 0.0, 4), [1e-6, 1e9])
        impact = rs.Impact(material, random_layer(rng), 1.0, velocity, external_force=force)
        batch = Batch.from_impact(impact, reduced_modulus(material))
        expected = batch.solve(1e-9)["max_contact_radius"]
        # The tables of the approaches have a tolerance of their own, below that of the impacts.
        for rtol in (1e-9, 1e-6):
            np.testing.assert_allclose(batch.max_contact_radii(rtol), expected, rtol=rtol)
