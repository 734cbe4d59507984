"""Scaling of SI input: the groups of the paper, the force law in scaled units, blocks."""

import math

import numpy as np
import pytest
from hypothesis import assume, example, given, settings
from hypothesis import strategies as st

from restitution import Impact, InputError, Material, PronySeries, SolverError, Status, solve, standard_solid
from restitution.contact.profiles import Cone, FlatPunch, Parabola, PowerLaw, Sphere
from restitution.impact.batch import Batch
from restitution.impact.problem import dimensionless_groups
from strategies import logarithmic

SOLID = standard_solid(2.0, 5.0, 3.0, poisson_ratio=0.25)
PRONY = Material(PronySeries(2e5, [1e6, 3e6], [1e-4, 1e-2], parallel_viscosity=20.0), math.inf)


def scale(impact, **options):
    return Batch.from_impact(impact).scaled(**options)


def test_groups_by_hand():
    # p3 = 3 (4 * 0.5/(2^2 2^3))^(1/5) = 3/16^(1/5)
    groups = dimensionless_groups(Impact(SOLID, Parabola(0.5), mass=2.0, velocity=4.0))
    assert groups.p1 == pytest.approx(0.25, abs=1e-15)
    assert groups.p2 == pytest.approx(0.4, rel=1e-15)
    assert groups.p3 == pytest.approx(3.0 / 16.0**0.2, rel=1e-15)
    assert isinstance(groups.p3, float)


def test_groups_of_arrays_and_of_huge_moduli():
    stiff = standard_solid(1e90, 1e90, 1e54, poisson_ratio=0.5)
    groups = dimensionless_groups(Impact(stiff, Parabola(1.0), mass=[1.0, 32.0], velocity=1.0))
    assert groups.p3 == pytest.approx([1.0, 0.25], rel=1e-12)


@pytest.mark.parametrize(
    ("impact", "reason"),
    [
        (Impact(SOLID, Parabola(1.0), 1.0, 1.0, counter_material=SOLID), "both bodies deform"),
        (Impact(SOLID, Cone(1.2), 1.0, 1.0), "the profile is not a parabola"),
        (Impact(SOLID, Sphere(1.0), 1.0, 1.0), "the profile is not a parabola"),
        (Material(PronySeries(1.0, [1.0, 1.0], [1.0, 2.0]), 1.0), "the shear modulus has 2 branches, not 1"),
        (Material(1.0, 1.0), "the shear modulus has 0 branches, not 1"),
        (
            Material(PronySeries(1.0, [1.0], [1.0], parallel_viscosity=1.0), math.inf),
            "the shear modulus has a parallel",
        ),
        (Material(PronySeries(0.0, [1.0], [1.0]), 1.0), "the equilibrium modulus is 0"),
        (Material(PronySeries(1.0, [1.0], [1.0]), PronySeries(1.0, [1.0], [1.0])), "the bulk relaxes"),
        (Impact(SOLID, Parabola(1.0), 1.0, 1.0, external_force=1.0), "a constant force acts"),
        (
            Impact(standard_solid(1.0, 1.0, 1.0, poisson_ratio=0.5), Parabola(1.0), 1.0, 1.0, impedance=3.0),
            "the target",
        ),
    ],
)
def test_groups_are_refused_where_they_do_not_hold(impact, reason):
    with pytest.raises(ValueError, match=f": here {reason}"):
        dimensionless_groups(Impact(impact, Parabola(1.0), 1.0, 1.0) if isinstance(impact, Material) else impact)


def test_zero_branches_and_merged_times_are_still_a_standard_solid():
    same = Material(PronySeries(2.0, [3.0, 0.0, 2.0], [0.6, 1.0, 0.6]), SOLID.bulk)
    first = dimensionless_groups(Impact(SOLID, Parabola(1.0), 1.0, 1.0))
    other = dimensionless_groups(Impact(same, Parabola(1.0), 1.0, 1.0))
    assert other == pytest.approx(first, rel=1e-14)


@pytest.mark.parametrize(
    "profile",
    [Parabola(0.02), Cone(1.3), FlatPunch(0.01), PowerLaw(4.0, 1e4), Sphere(0.02)],
    ids=lambda p: type(p).__name__,
)
def test_force_law_in_scaled_units(profile):
    """F = 2 (E Pi + eta a v + ...) in SI against the scaled law at the same state."""
    impact = Impact(PRONY, profile, mass=0.3, velocity=0.7, external_force=2.9)
    row = scale(impact).row(0)
    series = impact.reduced_modulus
    depth, velocity = 1e-3, 0.2
    force_unit = 0.3 * 0.7 / row.time
    assert row.time == pytest.approx(row.length / 0.7, rel=1e-15)
    assert row.external_force * force_unit == pytest.approx(2.9, rel=1e-14)
    assert row.times * row.time == pytest.approx(series.relaxation_times, rel=1e-14)
    a, integral = float(profile.contact_radius(depth)), float(profile.force_integral_at_depth(depth))
    scaled_integral = integral / (row.radius * row.length)
    scaled_radius = a / row.radius
    elastic = force_unit * row.equilibrium * scaled_integral
    assert elastic == pytest.approx(2.0 * series.equilibrium_modulus * integral, rel=1e-13)
    branches = force_unit * row.moduli * scaled_integral
    assert branches == pytest.approx(2.0 * series.branch_moduli * integral, rel=1e-13)
    viscous = force_unit * row.viscosity * scaled_radius * velocity / 0.7
    assert viscous == pytest.approx(2.0 * series.parallel_viscosity * a * velocity, rel=1e-13)
    if row.table is None:
        assert scaled_radius == pytest.approx((depth / row.length) ** (0.5 * row.exponent), rel=1e-14)


@settings(max_examples=60, deadline=None)
@given(
    mass=logarithmic(1e-12, 1e6),
    radius=logarithmic(1e-9, 1e3),
    velocity=logarithmic(1e-6, 1e4),
    modulus=logarithmic(1e2, 1e12),
)
def test_groups_determine_the_scaled_impact(mass, radius, velocity, modulus):
    """At equal p1, p2, p3 the scaled input of the kernel is the same up to rounding."""
    time = (mass**2 / (radius * velocity * modulus**2)) ** 0.2
    material = standard_solid(modulus, 7.0 * modulus, 0.4 * modulus * time, poisson_ratio=0.3)
    impact = Impact(material, Parabola(radius), mass, velocity)
    assert dimensionless_groups(impact).p3 == pytest.approx(0.4, rel=1e-12)
    unit = Impact(standard_solid(1.0, 7.0, 0.4, poisson_ratio=0.3), Parabola(1.0), 1.0, 1.0)
    result, expected = scale(impact).row(0), scale(unit).row(0)
    assert result.equilibrium == pytest.approx(expected.equilibrium, rel=1e-12)
    assert result.moduli == pytest.approx(expected.moduli, rel=1e-12)
    assert result.times == pytest.approx(expected.times, rel=1e-12)


def test_rows_parts_and_lists_equal_single_impacts():
    several = scale(Impact(PRONY, Parabola([0.01, 0.02, 0.03]), 0.1, 2.0, external_force=1.0))
    impacts = [Impact(PRONY, Parabola(radius), 0.1, 2.0, external_force=1.0) for radius in (0.01, 0.02, 0.03)]
    assert several.size == 3
    assert several.most_modes == 2
    blocks = [(several, 0), (Batch.from_impacts(impacts)[0][1].scaled(), 0), (several.part(1, 3), 1)]
    for block, first in blocks:
        for n in range(block.size):
            row, alone = block.row(n), scale(impacts[first + n]).row(0)
            for name in alone._fields:
                assert np.array_equal(getattr(row, name), getattr(alone, name)), name


def test_impacts_of_similar_depth_share_the_table_of_a_profile():
    masses = (4.1e-3, 4.2e-3, 3e2)
    tables = [scale(Impact(SOLID, Sphere(0.5), mass=mass, velocity=1.0)).tables for mass in masses]
    assert tables[1] is tables[0]
    assert tables[2] is not tables[0]
    assert scale(Impact(SOLID, Sphere(0.6), mass=masses[0], velocity=1.0)).tables is not tables[0]


@pytest.mark.parametrize("profile", [Sphere([0.5, 0.6]), PowerLaw([2.0, 3.0], 1.0)])
def test_a_batch_refuses_what_has_no_common_table_or_power(profile):
    with pytest.raises(InputError, match=r"^impact: .* of shape \(2,\) has materials or geometries apart$"):
        scale(Impact(SOLID, profile, mass=0.004, velocity=1.0))


def test_an_array_of_no_dimension_is_a_number():
    item = scale(Impact(SOLID, Sphere(np.array(0.5)), mass=0.004, velocity=1.0))
    assert item.length == scale(Impact(SOLID, Sphere(0.5), mass=0.004, velocity=1.0)).length


@settings(max_examples=60, deadline=None)
@given(
    st.sampled_from([Parabola, FlatPunch, Sphere, lambda _: Cone(1.2)]),
    st.floats(-95.0, 95.0),
    st.floats(-150.0, 150.0),
    st.floats(-150.0, 150.0),
)
@example(lambda _: Cone(1.2), -24.0, 104.0, 0.0)  # the volume overflows, the energy and the length do not
def test_units_do_not_change_the_result_unless_the_impact_fails(profile, modulus, length, time):
    """In extreme units m v^2 and other products overflow or lose digits as subnormal numbers."""

    def impact(modulus, length, time):
        mass, velocity = modulus * length * time * time, 0.8 * (length / time)
        solid = Material(PronySeries(modulus, [3.0 * modulus], [0.3 * time]), 2.0 * modulus)
        return Impact(solid, profile(length), mass, velocity)

    expected = solve(impact(1.0, 1.0, 1.0))
    units = 10.0**modulus, 10.0**length, 10.0**time
    mass, velocity = units[0] * units[1] * units[2] * units[2], units[1] / units[2]
    assume(min(mass, velocity, units[0] * units[1]) > 1e-290 and max(mass, velocity) < 1e290)
    try:
        result = solve(impact(*units))
    except (InputError, SolverError) as error:
        result = error
    if isinstance(result, InputError):
        assert result.field in ("radius", "relaxation_times")
        return
    if isinstance(result, SolverError):
        assert result.status is Status.NOT_FINITE
        energy = mass * velocity * velocity
        # The scales of the impact are these within some orders of magnitude.
        assert not all(1e-290 < x < 1e290 for x in (*units, energy, energy / units[1], units[2] / mass))
        return
    assert result.restitution_coefficient == pytest.approx(expected.restitution_coefficient, rel=2e-9)
    assert result.contact_time / units[2] == pytest.approx(expected.contact_time, rel=1e-8)
    assert result.max_indentation_depth / units[1] == pytest.approx(expected.max_indentation_depth, rel=1e-8)
    energy = result.energy
    assert energy.dissipated / energy.kinetic_in == pytest.approx(
        expected.energy.dissipated / expected.energy.kinetic_in, rel=1e-7
    )
    assert abs(energy.residual) < 1e-8
