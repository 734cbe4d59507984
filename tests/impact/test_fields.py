"""Pressure and surface displacement, also after separation, against closed forms and hereditary integrals."""

import functools
import math
from functools import partial
from itertools import pairwise

import numpy as np
import pytest

from refusals import named
from restitution import Impact, ImpactResult, Material, PronySeries, Status, Tabulated, solve
from restitution.contact.profiles import Cone, FlatEndedParabola, FlatPunch, Parabola, PowerLaw, Sphere, TruncatedCone

# Many of these bodies exceed the limits of the theory.
pytestmark = pytest.mark.filterwarnings(r"ignore:.*; exceeded in \d+ of")

ELASTIC = Material(1.3, 2.1)
SOLID = Material(PronySeries(1.0, [4.0, 2.0, 1.0], [0.02, 0.3, 20.0]), 3.0)
LIQUID = Material(PronySeries(0.0, [4.0, 1.0], [0.1, 2.0]), 5.0)
VISCOUS = Material(PronySeries(1.0, [3.0], [0.5], parallel_viscosity=0.1), math.inf)
# Instants before and after the turning point of all these impacts, over the contact time.
SHARES = (0.02, 0.2, 0.4, 0.6, 0.8, 0.97)
TABLE = np.linspace(0.0, 3.0, 61)
PROFILES = [
    Parabola(1.0),
    Sphere(2.0),
    Cone(1.1),
    FlatPunch(0.4),
    PowerLaw(4.0, 2.0),
    TruncatedCone(0.3, 1.0),
    FlatEndedParabola(1.0, 0.2),
    Tabulated(TABLE, TABLE**2 / 2.0),
]


def name(profile) -> str:
    return type(profile).__name__


@functools.cache
def impact(material, profile=None, **options) -> ImpactResult:
    return solve(Impact(material, profile or Parabola(1.0), 1.0, 1.0, **options), rtol=1e-12)


def motion(result: ImpactResult, t) -> dict[str, np.ndarray]:
    solution = result.sample(np.atleast_1d(t))
    return {key: solution[key].values for key in solution.data_vars}


# Slow for hundreds of nodes.
legendre = functools.lru_cache(np.polynomial.legendre.leggauss)


def gauss(low: float, high: float, n: int) -> tuple[np.ndarray, np.ndarray]:
    nodes, weights = legendre(n)
    return low + 0.5 * (high - low) * (nodes + 1.0), 0.5 * (high - low) * weights


def contact_rule(result: ImpactResult, end: float) -> tuple[np.ndarray, np.ndarray]:
    """Gauss rule over the time from 0 to `end`, in the root of time at both ends, split at the turning point."""
    turn = result._solution.turning_time
    y, w = gauss(0.0, math.sqrt(min(turn, end)), 400)
    times, weights = [y**2], [2.0 * y * w]
    if end > turn:
        last = result.contact_time
        y, w = gauss(math.sqrt(max(last - end, 0.0)), math.sqrt(last - turn), 400)
        times, weights = [*times, last - y**2], [*weights, 2.0 * y * w]
    return np.concatenate(times), np.concatenate(weights)


# Elastic: Hertz and Boussinesq


@pytest.mark.parametrize("share", SHARES)
def test_hertz(share):
    result = impact(ELASTIC, Parabola(2.0))
    modulus = result.impact.reduced_modulus.equilibrium_modulus
    t = share * result.contact_time
    state = motion(result, t)
    a, depth = float(state["contact_radius"][0]), float(state["indentation_depth"][0])
    assert a == pytest.approx(math.sqrt(2.0 * depth), rel=1e-9)
    r = a * np.array([0.0, 0.1, 0.5, 0.9, 0.99])
    ellipse = 2.0 * modulus / (math.pi * 2.0) * np.sqrt(a**2 - r**2)
    assert result.pressure(r, t) == pytest.approx(ellipse, rel=2e-8)
    assert result.surface_displacement(r, t) == pytest.approx(depth - r**2 / 4.0, rel=1e-9)
    ratio = np.array([1.001, 1.5, 3.0, 20.0])
    # Johnson, Contact Mechanics (1985), eq. 3.42a
    outside = a**2 / (math.pi * 2.0) * ((2.0 - ratio**2) * np.arcsin(1.0 / ratio) + np.sqrt(ratio**2 - 1.0))
    assert result.surface_displacement(ratio * a, t) == pytest.approx(outside, rel=1e-8)
    assert np.all(result.pressure(ratio * a, t) == 0.0)
    # Boussinesq's point force; Hertz's field differs by the order of (a/r)^2.
    far = 1e4 * a
    point = float(state["force"][0]) / (math.pi * modulus * far)
    assert result.surface_displacement(far, t) == pytest.approx(point, rel=1e-7)


def test_no_imprint_after_an_elastic_impact():
    result = impact(ELASTIC)
    late = 1.1 * result.contact_time
    assert result.surface_displacement([0.0, 0.3], late) == pytest.approx(0.0, abs=1e-11)
    assert result.pressure(0.0, late) == 0.0


@pytest.mark.parametrize("material", [SOLID, LIQUID, VISCOUS], ids=["solid", "liquid", "dashpot"])
@pytest.mark.parametrize("share", [0.1, 0.5, 0.9])
def test_flat_punch(material, share):
    a = 0.4
    result = impact(material, FlatPunch(a))
    assert result.status is Status.SEPARATED
    t = share * result.contact_time
    state = motion(result, t)
    depth, force = float(state["indentation_depth"][0]), float(state["force"][0])
    r = a * np.array([0.0, 0.3, 0.8, 0.999])
    punch = force / (2.0 * math.pi * a * np.sqrt(a**2 - r**2))
    assert result.pressure(r, t) == pytest.approx(punch, rel=1e-9)
    assert result.pressure(a, t) == math.inf
    assert result.surface_displacement(r, t) == pytest.approx(depth, rel=1e-9)
    outside = 2.0 * depth / math.pi * np.arcsin(1.0 / np.array([1.1, 2.0, 9.0]))
    assert result.surface_displacement(a * np.array([1.1, 2.0, 9.0]), t) == pytest.approx(outside, rel=1e-9)


# Viscoelastic


@pytest.mark.parametrize("profile", PROFILES, ids=name)
@pytest.mark.parametrize("material", [SOLID, LIQUID, VISCOUS], ids=["solid", "liquid", "dashpot"])
def test_line_load_carries_the_force(profile, material):
    result = impact(material, profile)
    times = result.contact_time * np.array(SHARES)
    forces = motion(result, times)["force"]
    for t, force in zip(times, forces, strict=True):
        load = result._fields.line_load(float(t))
        assert load.integral == pytest.approx(force, rel=1e-9, abs=1e-10 * result.max_force)


@pytest.mark.parametrize("share", [0.3, 0.7])
def test_pressure_carries_the_force(share):
    result = impact(SOLID)
    t = share * result.contact_time
    state = motion(result, t)
    a = float(state["contact_radius"][0])
    # p is sqrt(a^2 - r^2) times a function with kinks: a composite rule in the angle.
    rules = [gauss(low, high, 8) for low, high in pairwise(np.linspace(0.0, 0.5 * math.pi, 101))]
    angle, weight = (np.concatenate(columns) for columns in zip(*rules, strict=True))
    r = a * np.sin(angle)
    force = np.sum(weight * result.pressure(r, t) * 2.0 * math.pi * r * a * np.cos(angle))
    assert force == pytest.approx(float(state["force"][0]), rel=1e-9)


@pytest.mark.parametrize("profile", PROFILES, ids=name)
def test_surface_follows_the_body_in_contact(profile):
    result = impact(SOLID, profile)
    for share in SHARES:
        t = share * result.contact_time
        state = motion(result, t)
        a, depth = float(state["contact_radius"][0]), float(state["indentation_depth"][0])
        r = a * np.array([0.0, 0.2, 0.7, 0.999])
        assert result.surface_displacement(r, t) == pytest.approx(
            depth - profile.shape(r), rel=1e-8, abs=1e-9 * result.max_indentation_depth
        )
        assert np.all(result.pressure(r, t) > 0.0)
        # Outside the contact the surface is displaced inwards and lies below the body.
        beyond = a * np.array([1.01, 1.3])
        displaced = result.surface_displacement(beyond, t)
        assert np.all(displaced > 0.0)
        assert np.all(displaced > depth - profile.shape(beyond))


@pytest.mark.parametrize("material", [SOLID, VISCOUS], ids=["solid", "dashpot"])
def test_line_load_is_the_hereditary_integral(material):
    """q = int E*(t - t') d' dt' from first touch at x, by quadrature of the sampled motion."""
    result = impact(material)
    series = result.impact.reduced_modulus
    turn = result._solution.turning_time
    for x, t in ((0.0, 0.8 * turn), (0.3, 0.8 * turn), (0.0, 1.2 * turn), (0.2, 1.2 * turn)):
        touch = 0.0
        if x > 0.0:
            low, high = 0.0, turn
            for _ in range(60):
                touch = 0.5 * (low + high)
                early = result._solution.at(touch).indentation_depth[0] < x**2
                low, high = (touch, high) if early else (low, touch)
        rules = [gauss(touch, min(t, turn), 80)]
        if t > turn:
            rules.append(gauss(turn, t, 80))
        then, weight = (np.concatenate(columns) for columns in zip(*rules, strict=True))
        velocity = motion(result, then)["indentation_velocity"]
        decay = np.exp(-(t - then)[:, None] / series.relaxation_times) @ series.branch_moduli
        expected = np.sum(weight * velocity * (series.equilibrium_modulus + decay))
        expected += series.parallel_viscosity * float(motion(result, t)["indentation_velocity"][0])
        assert float(result._fields.line_load(t)(x)) == pytest.approx(expected, rel=1e-7)


@pytest.mark.parametrize("profile", [Parabola(1.0), Cone(1.1), FlatEndedParabola(1.0, 0.2)], ids=name)
@pytest.mark.parametrize("material", [SOLID, LIQUID, VISCOUS], ids=["solid", "liquid", "dashpot"])
@pytest.mark.parametrize("share", [0.3, 0.8, 1.0, 1.3, 5.0])
def test_far_surface_creeps_under_the_force_history(profile, material, share):
    """w pi r -> int J*(t - t') dF(t') far away, during and after contact: only the force matters there."""
    result = impact(material, profile)
    t = share * result.contact_time
    then, weight = contact_rule(result, min(t, result.contact_time))
    retardation = result.impact.reduced_modulus.retardation
    rate = retardation.branch_compliances / retardation.retardation_times
    creep = np.exp(-(t - then)[:, None] / retardation.retardation_times) @ rate + retardation.fluidity
    force_now = float(motion(result, t)["force"][0]) if share < 1.0 else 0.0
    expected = retardation.instantaneous_compliance * force_now
    expected += np.sum(weight * creep * motion(result, then)["force"])
    far = 1e4 * result.max_contact_radius
    assert math.pi * far * result.surface_displacement(far, t) == pytest.approx(expected, rel=1e-7)


@pytest.mark.parametrize("profile", [FlatEndedParabola(0.02, 20.0), TruncatedCone(200.0, 0.1)], ids=name)
def test_flat_ended_bodies_with_a_steep_flank_are_flat_punches(profile):
    # a exceeds the radius of the face by less than 1e-9.
    result = impact(SOLID, profile)
    a = profile.contact_radius(0.0)
    assert result.max_contact_radius == pytest.approx(a, rel=1e-9)
    for share in (0.3, 0.8):
        t = share * result.contact_time
        force = float(motion(result, t)["force"][0])
        r = a * np.array([0.0, 0.3, 0.8, 0.99])
        punch = force / (2.0 * math.pi * a * np.sqrt(a**2 - r**2))
        assert result.pressure(r, t) == pytest.approx(punch, rel=1e-7)


def test_sphere_pressed_in_up_to_its_equator():
    result = solve(Impact(SOLID, Sphere(0.01), 1.0, 1.0))
    assert result.max_contact_radius == pytest.approx(0.01, rel=1e-12)
    t = np.array([0.3, 0.8]) * result.contact_time
    assert np.all(result.pressure(np.array([[0.0], [0.005], [0.0099]]), t) > 0.0)
    for moment, force in zip(t, motion(result, t)["force"], strict=True):
        assert result._fields.line_load(moment).integral == pytest.approx(force, rel=1e-8)


# After separation


def test_imprint_of_a_single_branch_decays_with_its_retardation_time():
    # theta = tau (Einf + E1)/Einf = 0.2 * 5
    result = impact(Material(PronySeries(1.0, [4.0], [0.2]), math.inf))
    end = result.contact_time
    fade = np.exp(-np.array([0.0, 0.5, 3.0]) / 1.0)
    imprint = result.surface_displacement(0.0, end + np.array([0.0, 0.5, 3.0]))
    assert imprint == pytest.approx(result.residual_indentation_depth * fade, rel=1e-9)
    # After separation the whole surface recovers in proportion.
    r = np.array([[0.1], [0.4], [1.0], [5.0]])
    assert result.surface_displacement(r, end + 3.0)[:, 0] == pytest.approx(
        result.surface_displacement(r, end)[:, 0] * fade[2], rel=1e-8
    )


def test_imprint_of_a_flat_punch_keeps_its_shape():
    result = impact(Material(PronySeries(1.0, parallel_viscosity=0.5), math.inf), FlatPunch(0.4))
    # theta = viscosity/modulus = 0.5
    depth = result.residual_indentation_depth * math.exp(-1.0)
    t = result.contact_time + 0.5
    assert result.surface_displacement([0.0, 0.39], t) == pytest.approx(depth, rel=1e-9)
    assert result.surface_displacement(0.8, t) == pytest.approx(depth / 3.0, rel=1e-9)


@pytest.mark.parametrize("time", [1e-9, 1e9])
@pytest.mark.parametrize("profile", [Parabola(1.0), PowerLaw(4.0, 2.0)], ids=name)
def test_an_imprint_as_small_as_the_error_of_the_depth(time, profile):
    result = solve(Impact(Material(PronySeries(1.0, [4.0], [time]), math.inf), profile, 1.0, 1.0))
    imprint = result.surface_displacement(0.0, result.contact_time)
    # e has the tolerance 1e-9, and the depth that of its largest value.
    assert imprint == pytest.approx(result.residual_indentation_depth, abs=1e-9 * result.max_indentation_depth)


def test_the_imprint_in_a_liquid_follows_from_the_impulse():
    result = impact(LIQUID)
    flow = result.impact.reduced_modulus.flow_viscosity
    # int F dt = m v0 (1 + e)
    displaced = (1.0 + result.restitution_coefficient) / flow
    far = 1e4 * result.max_contact_radius
    late = 1e4 * result.contact_time
    assert math.pi * far * result.surface_displacement(far, late) == pytest.approx(displaced, rel=1e-8)


def test_surface_is_continuous_at_separation():
    result = impact(SOLID)
    end, r = result.contact_time, np.array([0.0, 0.05, 0.3, 0.7, 2.0])
    before, after = (result.surface_displacement(r, end * (1.0 + step)) for step in (-1e-9, 1e-9))
    assert after == pytest.approx(before, rel=1e-7)
    assert after[0] == pytest.approx(result.residual_indentation_depth, rel=1e-7)


def test_two_bodies_share_the_displacement():
    # Two equal bodies are as compliant as one of half the modulus.
    half = Material(PronySeries(0.5, [2.0, 1.0, 0.5], [0.02, 0.3, 20.0]), 1.5)
    pair = solve(Impact(SOLID, Parabola(1.0), 1.0, 1.0, counter_material=SOLID), rtol=1e-12)
    alone = solve(Impact(half, Parabola(1.0), 1.0, 1.0), rtol=1e-12)
    t = alone.contact_time * np.array([0.3, 0.8, 1.5])
    r = np.array([[0.0], [0.4], [2.0]])
    assert pair.surface_displacement(r, t) == pytest.approx(alone.surface_displacement(r, t), rel=1e-8)
    assert pair.pressure(r, t) == pytest.approx(alone.pressure(r, t), rel=1e-7)


def test_weight_changes_the_field_as_it_changes_the_motion():
    result = impact(SOLID, external_force=0.3)
    t = np.array([0.2, 0.8]) * result.contact_time
    state = motion(result, t)
    assert result.surface_displacement(0.0, t) == pytest.approx(state["indentation_depth"], rel=1e-9)


def test_si_units():
    """The same numbers in other units of length, mass and time."""
    first = impact(SOLID)
    length, mass, time = 3e-3, 2e-5, 7e-4
    stress = mass / (length * time**2)
    shear = SOLID.shear.scaled(stress, time_factor=time)
    other = solve(Impact(Material(shear, 3.0 * stress), Parabola(length), mass, length / time), rtol=1e-12)
    t, r = first.contact_time * np.array([0.3, 0.8, 1.2]), np.array([[0.0], [0.2], [0.9]])
    assert other.pressure(r * length, t * time) == pytest.approx(first.pressure(r, t) * stress, rel=1e-7)
    assert other.surface_displacement(r * length, t * time) == pytest.approx(
        first.surface_displacement(r, t) * length, rel=1e-8
    )


# Calls


def test_radius_and_time_broadcast():
    result = impact(SOLID)
    t = result.contact_time * np.array([0.2, 0.5, 1.5])
    grid = result.pressure(np.array([[0.0], [0.1]]), t)
    assert grid.shape == (2, 3)
    assert grid[1, 0] == result.pressure(0.1, t[0])
    assert np.all(grid[:, 2] == 0.0)
    assert np.shape(result.pressure(0.1, t[0])) == ()
    assert result.surface_displacement([0.0, 0.1, 0.2], t).shape == (3,)
    assert result.pressure([], t[0]).shape == (0,)
    assert result.pressure(0.0, 0.0) == 0.0
    assert result.surface_displacement(0.0, 0.0) == 0.0


@pytest.mark.parametrize(
    ("r", "t", "expected"),
    [
        (-0.1, 1.0, ("r", -0.1)),
        (0.1, -1.0, ("t", -1.0)),
        (math.nan, 1.0, ("r", math.nan)),
        (0.1, [1.0, math.inf], ("t", 1, math.inf)),
    ],
)
def test_bad_radii_and_times_are_refused(r, t, expected):
    result = impact(SOLID)
    for field in (result.pressure, result.surface_displacement):
        assert named(partial(field, r, t)) == expected


def test_fields_need_a_single_exact_impact_that_separates():
    several = solve(Impact(SOLID, Parabola(1.0), 1.0, [1.0, 2.0]))
    with pytest.raises(ValueError, match=r"^impact: must be a single one: .* of an array of shape \(2,\)$"):
        several.pressure(0.0, 0.1)
    assert named(lambda: solve([Impact(SOLID, Parabola(1.0), 1.0, 1.0)]).surface_displacement(0.0, 0.1)) == ("impact",)
    with pytest.raises(ValueError, match=r"^method: must be 'exact' .* of 'elements'$"):
        solve(Impact(SOLID, Parabola(1.0), 1.0, 1.0), "elements").pressure(0.0, 0.1)
    stays = solve(Impact(Material(PronySeries(0.0, parallel_viscosity=1.0), math.inf), FlatPunch(1.0), 1.0, 1.0))
    assert named(lambda: stays.pressure(0.0, 0.1)) == ("contact_time", math.inf)


# Zero overlap


@pytest.mark.parametrize("force", [0.0, 0.05])
def test_body_is_back_at_the_surface_at_zero_overlap(force):
    result = impact(SOLID, external_force=force)
    flight = result.zero_overlap_time - result.contact_time
    assert flight > 0.0
    depth = result.residual_indentation_depth - result.rebound_velocity * flight + 0.5 * force * flight**2
    assert depth == pytest.approx(0.0, abs=1e-14)


def test_zero_overlap_of_arrays_and_of_bodies_that_do_not_come_back():
    elastic = impact(ELASTIC)
    assert elastic.zero_overlap_time == pytest.approx(elastic.contact_time, rel=1e-9)
    several = solve(Impact(SOLID, Parabola(1.0), 1.0, [0.5, 1.0]))
    assert several.zero_overlap_time.shape == (2,)
    assert several.zero_overlap_time[1] == solve(Impact(SOLID, Parabola(1.0), 1.0, 1.0)).zero_overlap_time
    listed = solve([Impact(SOLID, Parabola(1.0), 1.0, 1.0), Impact(ELASTIC, Parabola(1.0), 1.0, 1.0)])
    assert listed.zero_overlap_time[0] == several.zero_overlap_time[1]
    sunk = solve(Impact(Material(PronySeries(0.0, parallel_viscosity=1.0), math.inf), FlatPunch(1.0), 1.0, 1.0))
    assert sunk.zero_overlap_time == math.inf
