"""The numbers of the codes: what they mean in each code, units, and the inverse of the fits."""

import math

import numpy as np
import pytest

from restitution import closed_forms, units
from restitution.calibration.laws import (
    CONSTANT,
    HUNT_CROSSLEY,
    LAWS,
    Setting,
    TypedLaw,
    coefficient_strength,
    inverse,
    rebound,
    thornton_strength,
    tsuji_strength,
)

RNG = np.random.default_rng(12)


def test_coefficient_is_that_of_a_contact_with_pull():
    e = RNG.uniform(0.05, 0.99, 10)
    restitution, _ = rebound(CONSTANT, "overlap", [coefficient_strength(x) for x in e])
    np.testing.assert_allclose(restitution, e, atol=2e-6)


def test_thornton_is_that_of_a_contact_without_pull():
    """The fit of Thornton and others (2013) gives the coefficient within their accuracy."""
    e = RNG.uniform(0.05, 0.99, 10)
    restitution, _ = rebound(CONSTANT, "force", [thornton_strength(x) for x in e])
    np.testing.assert_allclose(restitution, e, atol=5e-3)


@pytest.mark.parametrize("function", [coefficient_strength, thornton_strength, tsuji_strength])
def test_strength_falls_with_e_and_is_inverted(function):
    low, high = 0.001, 0.999
    values = [function(x) for x in np.linspace(low, high, 300)]
    assert np.all(np.diff(values) < 0.0)
    e = RNG.uniform(low, high)
    assert inverse(function, function(e), low, high) == pytest.approx(e, abs=1e-9)


def test_tsuji_is_the_documented_polynomial():
    """Page pair_style granular of LAMMPS: alpha(1) is the sum of the coefficients, alpha(0) the first one."""
    assert tsuji_strength(0.0) == 1.2728
    assert tsuji_strength(1.0) == pytest.approx(1.2728 - 4.2783 + 11.087 - 22.348 + 27.467 - 18.022 + 4.8218)


def force(name, modulus, strength, depth, velocity, mass, radius):
    """Force of a code, written from its documentation."""
    reduced = modulus
    if name == "lammps-viscoelastic":
        return (
            4 / 3 * reduced * math.sqrt(radius) * depth**1.5 + strength * mass * math.sqrt(radius * depth) * velocity
        )
    if name == "mercury-bshp":
        stiffness = 4 / 3 * reduced * math.sqrt(radius * depth)
        return stiffness * depth + 1.5 * strength * stiffness * velocity
    if name == "yade-mindlin":
        kno = 4 / 3 * reduced * math.sqrt(radius)
        kn, a = 1.5 * kno * math.sqrt(depth), 2.0 * strength * (kno / mass) ** -0.4 / 3.0
        return kno * depth**1.5 + a * kn * velocity
    if name == "kratos-dem":
        kn = 2.0 * reduced * math.sqrt(radius * depth)
        return 2 / 3 * kn * depth + 2.0 * strength / math.sqrt(6.0) * math.sqrt(mass * kn) * velocity
    if name == "liggghts":
        sn = 2.0 * reduced * math.sqrt(radius * depth)
        beta = strength / math.sqrt(5.0)
        return (
            4 / 3 * reduced * math.sqrt(radius * depth) * depth
            + 2.0 * math.sqrt(5 / 6) * beta * math.sqrt(sn * mass) * velocity
        )
    if name in ("lammps-tsuji", "lammps-coeff-restitution"):
        normal = 4 / 3 * reduced * math.sqrt(radius) * depth**1.5
        return normal + strength * math.sqrt(mass * normal / depth) * velocity
    if name == "drake":
        # Modeling Compliant Contact: two geometries of stiffness 2 k in series, f = k x (1 + d v).
        return modulus * depth * (1.0 + strength * velocity)
    if name == "drake-sap":
        return modulus * (depth + strength * velocity)
    return mass * (modulus * depth + strength * velocity)


@pytest.mark.parametrize("name", LAWS)
def test_force_is_that_of_the_code(name):
    law = LAWS[name]
    modulus, strength, depth, velocity, mass, radius = np.exp(RNG.uniform(-2.0, 2.0, 6))
    stiffness = TypedLaw(law, modulus, strength, law.end).stiffness(mass, radius)
    ours = stiffness * depth**law.shape.spring
    ours += strength * law.dashpot(stiffness, mass, radius) * depth**law.shape.dashpot * velocity
    assert ours == pytest.approx(force(name, modulus, strength, depth, velocity, mass, radius), rel=1e-12)


def test_drake_bounds_the_velocity_of_the_rebound():
    """Hunt and Crossley (1975): d v0 (1 + e) = ln((1 + d v0)/(1 - d v0 e)), so that e v0 stays below 1/d."""
    b = np.exp(RNG.uniform(-4.0, 6.0, 20))
    assert np.all(b * rebound(HUNT_CROSSLEY, "force", b)[0] < 1.0 + 1e-6)
    b = np.exp(RNG.uniform(-4.0, 1.0, 20))
    e, _ = rebound(HUNT_CROSSLEY, "force", b)
    np.testing.assert_allclose(b * (1.0 + e), np.log1p(b) - np.log1p(-b * e), rtol=1e-6)


def test_yade_gives_en_at_vn():
    """en is the Pade approximant at vn for every size."""
    law, en, vn = LAWS["yade-mindlin"], RNG.uniform(0.3, 0.95), RNG.uniform(0.1, 3.0)
    setting = Setting(vn, 1.0, 0.3, 1.0, 0.0, en)
    modulus, strength = law.naive(setting)
    assert law.typed(modulus, strength, setting)["en"].value == pytest.approx(en, rel=1e-12)
    mass, radius = np.exp(RNG.uniform(-5.0, 5.0, 2))
    typed_law = TypedLaw(law, modulus, strength, "force")
    assert typed_law.rebound(vn, mass, radius)[0] == pytest.approx(en, abs=7e-4)
    assert math.sqrt(typed_law.loss(vn, mass, radius)) == pytest.approx(
        inverse(lambda x: float(closed_forms.mueller_poeschel_restitution(x)), en, 0.0, 1e3), rel=1e-9
    )


@pytest.mark.parametrize("name", ["si", "cgs", "micro"])
def test_units_round_trip(name):
    """A force computed with numbers in a unit system is that in SI (page units of LAMMPS)."""
    system = units.SYSTEMS[name]
    modulus, damping, mass, radius, depth, velocity = np.exp(RNG.uniform(-3.0, 3.0, 6))
    eta = units.Dimension("damping per area", "1/(m s)", powers=units.Powers(0, -1, -1))
    converted = [
        system.convert(*number)
        for number in zip(
            (modulus, damping, mass, radius, depth, velocity),
            (units.MODULUS, eta, units.MASS, units.LENGTH, units.LENGTH, units.VELOCITY),
            strict=True,
        )
    ]
    e, eta_n0, m, r, d, v = converted
    inside = force("lammps-viscoelastic", e, eta_n0, d, v, m, r)
    outside = force("lammps-viscoelastic", modulus, damping, depth, velocity, mass, radius)
    assert system.convert(outside, units.FORCE) == pytest.approx(inside, rel=1e-12)


def test_micro_units_are_those_of_lammps():
    """Page units of LAMMPS: picograms, micrometers, microseconds; its pressure is 1e3 Pa, its velocity 1 m/s."""
    assert units.MICRO.convert(1e3, units.PRESSURE) == pytest.approx(1.0)
    assert units.MICRO.convert(1.0, units.VELOCITY) == pytest.approx(1.0)
    assert units.CGS.convert(0.1, units.PRESSURE) == pytest.approx(1.0)
    damping = units.Dimension("damping per area", "1/(m s)", powers=units.Powers(0, -1, -1))
    assert list(map(units.CGS.unit, (units.MODULUS, units.NUMBER, damping))) == ["g/(cm s^2)", "", "1/(cm s)"]


def test_powers_of_a_dimension_are_those_of_its_unit():
    registry = units.unit_registry()
    base = [registry.Quantity(number, unit) for number, unit in ((2.0, "kg"), (3.0, "m"), (5.0, "s"))]
    for dimension in vars(units).values():
        if isinstance(dimension, units.Dimension) and not {"K", "J/mol"} & {dimension.unit}:
            size = registry.Quantity(1.0, dimension.unit or "dimensionless").to_base_units().units
            powers = dimension.powers
            unit = base[0] ** powers.mass * base[1] ** powers.length * base[2] ** powers.time
            assert unit.dimensionality == size.dimensionality, dimension
