"""Impacts on the spot that earlier ones have hit: a reference row, energies, and series of bounces."""

import math
from dataclasses import replace

import numpy as np
import pytest

import restitution as rs
from restitution import Body, Impact, InputError, Material, Parabola, PronySeries, bounces, drop, solve

# E*(t) = 1 + 4 exp(-t).
SOLID = Material(PronySeries(0.25, [1.0], [1.0]), math.inf)
IMPACT = Impact(SOLID, Parabola(1.0), mass=1.0, velocity=1.0)
# e, duration, depth at separation, largest force and depth of four impacts, each half a unit of time after the
# separation before; by panels of two orders.
ROW_I1 = [
    (0.628798624830, 1.49786438792, 0.249903891283, 1.9866188382, 0.5435801867),
    (0.69607026067, 1.3461228716, 0.38805568029, 2.2589409254, 0.6923966103),
    (0.73383345137, 1.2882875774, 0.47508028710, 2.4058202673, 0.7885142388),
    (0.75816696328, 1.2626413373, 0.53355907131, 2.4953261313, 0.8547575737),
]


def series_of_impacts(count, rtol=1e-9):
    """Results of impacts on one spot."""
    results = [solve(IMPACT, rtol=rtol)]
    while len(results) < count:
        results.append(solve(IMPACT, rtol=rtol, surface=results[-1].surface(after=0.5)))
    return results


def test_four_impacts_on_one_spot():
    """Row I1."""
    for result, (e, duration, depth, force, deepest) in zip(series_of_impacts(4), ROW_I1, strict=True):
        assert result.restitution_coefficient == pytest.approx(e, abs=1e-9)
        assert result.contact_time == pytest.approx(duration, abs=4e-9)
        assert result.residual_indentation_depth == pytest.approx(depth, abs=2e-9)
        assert result.max_force == pytest.approx(force, abs=4e-9)
        assert result.max_indentation_depth == pytest.approx(deepest, abs=2e-9)


def test_energies_of_a_second_impact_balance():
    """The surface brings stored energy with it, which relaxes while the next contact lasts."""
    first, second = series_of_impacts(2)
    assert second.began_on is not None
    assert second.began_on.time == 0.5
    energy, e = second.energy, float(second.restitution_coefficient)
    assert energy.kinetic_in == 0.5
    assert energy.kinetic_out == pytest.approx(0.5 * e * e, rel=1e-12)
    assert energy.kinetic_out + energy.dissipated + energy.stored == pytest.approx(0.5, abs=1e-8)
    # What is stored at the end is the change since the surface before.
    after = second.surface()
    assert energy.stored == pytest.approx(after.stored - second.began_on.stored, abs=1e-8)
    assert first.surface().stored > second.began_on.stored > 0.0


def test_a_history_at_any_time_follows_the_law_of_motion():
    """m dv/dt = -F, by central differences around times that are no samples of the solver."""
    second = series_of_impacts(2)[1]
    times = np.sort(np.random.default_rng(3).uniform(0.01, 0.99, 20)) * second.contact_time
    step = 1e-4
    rates = [second.sample(times + way).indentation_velocity.values for way in (-step, step)]
    forces = second.sample(times).force.values
    # The error is step^2/6 times the second derivative of the force, which is about that over the square of a time.
    np.testing.assert_allclose((rates[1] - rates[0]) / (2.0 * step), -forces, atol=1e-6)


def test_the_weight_works_from_the_imprint_on():
    """Energies balance to the tolerance, with the work of the force along the way from the first to the last depth."""
    heavy = replace(IMPACT, external_force=0.05)
    second = solve(heavy, surface=solve(heavy).surface(after=0.5))
    assert abs(second.energy.residual) < 1e-8
    assert second.outputs["energy_residual"] == second.energy.residual


def test_a_surface_that_has_recovered_is_a_fresh_one():
    again = solve(IMPACT, surface=solve(IMPACT).surface(after=200.0))
    # The retardation time is 5: exp(-40) of the imprint is left.
    assert again.restitution_coefficient == pytest.approx(ROW_I1[0][0], abs=2e-9)
    assert again.contact_time == pytest.approx(ROW_I1[0][1], abs=1e-8)


def test_an_elastic_body_has_no_imprint():
    impact = replace(IMPACT, material=Material(1.0, 2.0))
    result = solve(impact)
    for _ in range(3):
        surface = result.surface()
        assert abs(surface.depth) <= 1e-8
        result = solve(impact, surface=surface)
        assert result.restitution_coefficient == pytest.approx(1.0, abs=1e-9)


def test_samples_of_a_second_impact():
    """m v' = -F, and the surface lies at the depth at which the contact begins."""
    second = series_of_impacts(2)[1]
    surface = second.began_on
    history = second.sample(np.linspace(0.0, float(second.contact_time), 2001))
    assert history.indentation_depth[0] == pytest.approx(surface.depth, rel=1e-9)
    assert history.indentation_velocity[0] == pytest.approx(1.0, rel=1e-9)
    change = np.trapezoid(history.force, history.time)
    assert change == pytest.approx(1.0 + float(second.restitution_coefficient), rel=1e-5)


# Bounces


def thrown(material, height, radius=0.01):
    return drop(Body(material, radius=radius), Body(None), height=height)


def test_a_surface_that_recovers_within_the_flight_makes_the_bounces_of_fresh_spots():
    """A retardation time of 0.2 ms and flights of 0.1 s."""
    impact = thrown(rs.standard_solid(1e6, 1e6, 1e2, poisson_ratio=0.45, density=1200.0), 0.05)
    fresh, same = bounces(impact, max_bounces=4), bounces(impact, max_bounces=4, same_spot=True)
    for name in ("restitution_coefficient", "contact_time", "height", "touch_time"):
        assert getattr(same, name) == pytest.approx(getattr(fresh, name), rel=1e-7), name
    assert same.ended == fresh.ended == "max bounces"


@pytest.mark.parametrize("with_weight", [True, False])
def test_each_bounce_on_one_spot_is_an_impact_on_the_surface_before(with_weight):
    """The flight from separation to the imprint, as it then is, follows from both ends."""
    gravity = 0.5
    result = bounces(IMPACT, gravity=gravity, with_weight=with_weight, max_bounces=4, same_spot=True)
    weight = gravity if with_weight else 0.0
    impact = replace(IMPACT, external_force=weight)
    alone = solve(impact)
    assert result.restitution_coefficient[0] == pytest.approx(alone.restitution_coefficient, abs=1e-9)
    for n in range(1, result.n_bounces):
        flight = result.touch_time[n] - result.touch_time[n - 1] - result.contact_time[n - 1]
        away, depth = float(alone.rebound_velocity), float(alone.residual_indentation_depth)
        surface = alone.surface(after=flight)
        assert depth - away * flight + 0.5 * gravity * flight**2 == pytest.approx(surface.depth, abs=1e-8)
        assert result.velocity[n] == pytest.approx(gravity * flight - away, rel=1e-8)
        alone = solve(replace(impact, velocity=result.velocity[n]), surface=surface)
        assert result.restitution_coefficient[n] == pytest.approx(alone.restitution_coefficient, abs=1e-7)
    assert not any("recovery" in warning for warning in result.warnings)


@pytest.mark.slow
@pytest.mark.parametrize("weak", [False, True])
def test_a_body_comes_to_rest_in_its_imprint(weak):
    """Its static depth is that of Hertz under its weight, whatever came before.

    With little loss it oscillates for a thousand contact times, which are not followed.
    """
    if weak:
        impact = Impact(Material(PronySeries(0.25, [0.01], [0.02]), math.inf), Parabola(20.0), 1.0, 0.1)
        result, modulus, radius, weight = bounces(impact, gravity=0.6, same_spot=True), 1.0, 20.0, 0.6
    else:
        impact = thrown(rs.standard_solid(1e6, 1e6, 1e3, poisson_ratio=0.45, density=1200.0), 0.05)
        result, modulus, radius = bounces(impact, same_spot=True), 2.0 * 1e6 / (1.0 - 0.45), 0.01
        weight = float(impact.external_force)
    assert result.ended == "captured"
    assert math.isinf(result.contact_time[-1])
    hertz = (0.75 * weight / (modulus * math.sqrt(radius))) ** (2.0 / 3.0)
    assert result.residual_indentation_depth[-1] == pytest.approx(hertz, rel=1e-9)


FLUID = Impact(Material(PronySeries(0.0, [0.1], [12.0]), math.inf), Parabola(20.0), mass=1.0, velocity=0.2)


@pytest.mark.slow
def test_late_touches_of_a_long_series_keep_their_accuracy():
    """A liquid takes the shape of the body, so that errors of the surface move the front by themselves over the gap.

    That falls to 1e-5 of the depth.
    """
    coarse, fine = (
        bounces(FLUID, gravity=0.006, with_weight=False, same_spot=True, rtol=rtol) for rtol in (1e-8, 1e-9)
    )
    assert coarse.ended == fine.ended == "low"
    assert coarse.n_bounces == fine.n_bounces > 60
    assert coarse.restitution_coefficient[:60] == pytest.approx(fine.restitution_coefficient[:60], rel=1e-7)
    assert coarse.restitution_coefficient == pytest.approx(fine.restitution_coefficient, rel=1e-3)
    assert coarse.residual_indentation_depth == pytest.approx(fine.residual_indentation_depth, rel=1e-6)


def test_a_slow_body_on_a_fresh_imprint_may_gain_energy():
    """The surface rises towards it, and returns energy of the impacts before; all of it is theirs."""
    impact = thrown(rs.standard_solid(1e6, 1e6, 1e3, poisson_ratio=0.45, density=1200.0), 0.05)
    result = bounces(impact, same_spot=True, with_weight=False, max_bounces=18)
    assert result.restitution_coefficient.max() > 1.0
    energy = 0.5 * float(impact.mass) * result.rebound_velocity**2
    assert np.all(np.diff(energy) < 0.0)
    # The picture shows all of them.
    assert result.plot().axes[1].get_ylim()[1] > result.restitution_coefficient.max()


def test_a_surface_that_meets_the_body_on_its_way_up_ends_the_bounces():
    """The last flight is below the path of the body, as long as it rises, until both meet."""
    result = bounces(IMPACT, gravity=1.0, with_weight=False, same_spot=True)
    assert result.ended == "lifted"
    alone = solve(IMPACT)
    for n in range(1, result.n_bounces):
        flight = result.touch_time[n] - result.touch_time[n - 1] - result.contact_time[n - 1]
        alone = solve(replace(IMPACT, velocity=result.velocity[n]), surface=alone.surface(after=flight))
    away, depth = float(alone.rebound_velocity), float(alone.residual_indentation_depth)
    times = np.linspace(0.0, away, 1001)[1:]
    gaps = [alone.surface(after=time).depth - (depth - away * time + 0.5 * time**2) for time in times]
    assert gaps[0] > 0.0 > gaps[-1]


# Errors


def test_impacts_that_have_no_surface_are_refused():
    surface = solve(IMPACT).surface()
    calls = {
        "surface": [
            lambda: solve(replace(IMPACT, velocity=[1.0, 2.0]), surface=surface),
            lambda: solve([IMPACT, IMPACT], surface=surface),
            lambda: solve(replace(IMPACT, profile=Parabola(2.0)), surface=surface),
            lambda: solve(replace(IMPACT, material=Material(1.0, 2.0)), surface=surface),
        ],
        "method": [lambda: solve(IMPACT, "elements", surface=surface), lambda: solve(IMPACT, "elements").surface()],
        "impedance": [
            lambda: solve(replace(IMPACT, impedance=3.0), surface=surface),
            lambda: solve(replace(IMPACT, impedance=3.0)).surface(),
        ],
        "rtol": [lambda: solve(IMPACT, surface=surface, rtol=1e-12)],
        "after": [lambda: solve(IMPACT).surface(after=-1.0)],
        "contact_time": [lambda: solve(replace(IMPACT, velocity=0.01, external_force=1.0)).surface()],
    }
    for field, several in calls.items():
        for call in several:
            with pytest.raises(InputError) as caught:
                call()
            assert caught.value.field == field
            assert "\n" not in str(caught.value)
    with pytest.raises(TypeError, match="surface"):
        solve(IMPACT, surface=3)
    with pytest.raises(TypeError, match="same_spot"):
        bounces(IMPACT, same_spot="yes")


def bounces_of_elements(impact, push, contacts, count, steps):
    """Restitution of a ball on equal elements of a Maxwell liquid, with velocity Verlet; 0 where it does not leave.

    The surface of such a liquid stays as it is without load: each touch has the velocity of the rebound before.
    """
    series, radius, mass, velocity = impact.reduced_modulus, impact.profile.radius, impact.mass, impact.velocity
    modulus, time = float(series.branch_moduli[0]), float(series.relaxation_times[0])
    # Duration and depth of an elastic impact (Hertz), within factors.
    depth = 2.0 * (15.0 * mass * velocity**2 / (16.0 * modulus * math.sqrt(radius))) ** 0.4
    spacing = math.sqrt(4.0 * depth * radius) / count
    s = ((np.arange(count) + 0.5) * spacing) ** 2 / radius
    u, d, ratios = np.zeros(count), 0.0, []
    for _ in range(contacts):
        speed = (15.0 * mass * velocity**2 / (16.0 * modulus * math.sqrt(radius))) ** 0.4 / velocity
        step, rate, loads, force = 3.0 * speed / steps, velocity, np.zeros(count), 0.0
        decay, gain = math.exp(-step / time), -modulus * time / step * math.expm1(-step / time)
        for n in range(40 * steps):
            before = (push - force) / mass
            d += step * rate + 0.5 * step * step * before
            trial = decay * loads + gain * (d - s - u)
            touches = trial > 0.0
            u = np.where(touches, d - s, u - decay * loads / gain)
            loads = np.where(touches, trial, 0.0)
            force = 2.0 * spacing * float(loads.sum())
            rate += 0.5 * step * (before + (push - force) / mass)
            if n > 2 and not touches.any():
                break
        else:
            return [*ratios, 0.0]
        ratios.append(-rate / velocity)
        velocity, d = -rate, float(u[0] + s[0])
    return ratios


@pytest.mark.slow
@pytest.mark.parametrize(("velocity", "ended"), [(0.1, "sunk"), (0.5, "sunk"), (2.0, "low")])
def test_a_liquid_under_weight_beside_elements(velocity, ended):
    """A ball of 5 g bounces in its own imprint until the weight holds it, or its rebounds are too low."""
    liquid = Material(PronySeries(0.0, [1e6], [1e-3]), bulk=math.inf)
    ball = Impact(liquid, Parabola(0.01), 0.005, velocity)
    result = bounces(ball, gravity=9.81, same_spot=True)
    assert result.ended == ended
    numbers = (ball, 0.005 * 9.81, result.n_bounces)
    coarse, fine = (bounces_of_elements(*numbers, 200 * n, 500 * n) for n in (1, 2))
    assert len(coarse) == len(fine) == result.n_bounces
    # Steps end the contact up to a step late, so that errors are of first order in part.
    change = np.abs(np.array(fine) - coarse)
    assert np.all(np.abs(result.restitution_coefficient - fine) < 1e-3 + 2.0 * change)


@pytest.mark.slow
def test_a_long_series_on_a_liquid_beside_elements():
    """Errors of steps and elements are of first order in part, and as small for late touches as for early ones."""
    result = bounces(FLUID, gravity=0.006, with_weight=False, same_spot=True)
    coarse, fine = (bounces_of_elements(FLUID, 0.0, result.n_bounces, 200 * n, 500 * n) for n in (1, 2))
    change = np.abs(np.array(fine) - coarse)
    assert np.all(np.abs(result.restitution_coefficient - fine) < 1e-5 + 2.0 * change)


def test_a_touch_that_cannot_be_solved_ends_the_series(monkeypatch):
    """The touches before it stay; the first impact is on a fresh surface, and its error is the caller's."""
    whole = bounces(IMPACT, gravity=0.5, with_weight=False, max_bounces=6, same_spot=True)
    left = iter([False] * 3)

    def fails_at_the_fifth_touch(*args, **options):
        if next(left, True):
            raise InputError("time", 2.5, "leads to a contact that could not be solved there", "s")
        return solve(*args, **options)

    monkeypatch.setattr("restitution.impact.bounces.solve", fails_at_the_fifth_touch)
    result = bounces(IMPACT, gravity=0.5, with_weight=False, max_bounces=6, same_spot=True)
    assert result.ended == "unsolved"
    assert np.array_equal(result.restitution_coefficient, whole.restitution_coefficient[:4])
    assert "touch 5" in result.warnings[-1]
    assert "could not be solved" in result.warnings[-1]
    assert "unsolved" in str(result)


def test_two_relaxation_times_under_weight_end_sunk():
    liquid = Material(PronySeries(0.0, [1e6, 2e5], [1e-4, 1e-2]), bulk=math.inf)
    result = bounces(Impact(liquid, Parabola(0.01), 0.005, 0.5), gravity=9.81, same_spot=True)
    assert result.ended == "sunk"
    assert result.restitution_coefficient[-1] == 0.0
    assert math.isinf(result.residual_indentation_depth[-1])
    # The first is that on a fresh surface, and the others fall from there.
    assert np.all(np.diff(result.restitution_coefficient) < 0.0)
