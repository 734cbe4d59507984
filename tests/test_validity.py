"""Validity report: each assumption against an independent source and at its limit, for every kind of result."""

import json
import math
import pickle
import warnings
from dataclasses import replace
from functools import partial

import numpy as np
import pytest
from scipy.integrate import quad
from scipy.optimize import brentq

import restitution as rs
from refusals import in_one_line, named
from restitution.contact.geometry import Contact
from restitution.contact.radiation import radiation
from restitution.quantities import VALIDITY
from restitution.validity import (
    DENSITY_LIMITS,
    RADIATION_LIMIT,
    SIZE_LIMIT,
    STRAIN_LIMIT,
    numbers,
    report,
    together,
    validity,
)

# Arrays and lists of impacts warn; the tests read the warnings from the results.
pytestmark = pytest.mark.filterwarnings(r"ignore:.*; exceeded in \d+ of")

KINDS = ["small_strain", "half_space", "waves", "window", "poisson_ratio", "density"]


def of_impact(impact, result, **more):
    contact = Contact(impact.material, impact.profile, impact.counter_material)
    return numbers(
        contact,
        max_contact_radius=result.max_contact_radius,
        max_indentation_depth=result.max_indentation_depth,
        velocity=impact.velocity,
        contact_time=result.contact_time,
        mass=impact.mass,
        max_force=result.max_force,
        restitution_coefficient=result.restitution_coefficient,
        residual_indentation_depth=result.residual_indentation_depth,
        **more,
    )


def solved(material, profile, mass, velocity, counter_material=None, **more):
    impact = rs.Impact(material, profile, mass, velocity, counter_material=counter_material)
    return of_impact(impact, rs.solve(impact), **more)


def report_of(profile=None, material=None, **options):
    """Report of a contact that is far from every limit, apart from the given quantities."""
    options = {
        "max_contact_radius": 1e-4, "max_indentation_depth": 1e-6, "velocity": 1e-3, "contact_time": 3e-3, **options
    }  # fmt: skip
    contact = Contact(material or rs.Material(1e6, 1e9), profile or rs.Parabola(0.01))
    return validity(contact, **options)


def lamb(poisson_ratio):
    """Lamb's integral over the cuts and the pole of the compliance of a half-space under a point force."""
    longitudinal = (1 - 2 * poisson_ratio) / (2 * (1 - poisson_ratio))

    def body(angle):
        k, c = math.sin(angle), math.cos(angle)
        if k * k < longitudinal:
            a = math.sqrt(longitudinal - k * k)
            return k * a * c / ((2 * k * k - 1) ** 2 + 4 * k * k * a * c)
        a = k * k - longitudinal
        return 4 * k**3 * a * c * c / ((2 * k * k - 1) ** 4 + 16 * k**4 * a * c * c)

    edge = math.asin(math.sqrt(longitudinal))
    waves = quad(body, 0, edge)[0] + quad(body, edge, math.pi / 2)[0]

    def rayleigh(x):
        return (2 * x - 1) ** 2 - 4 * x * math.sqrt((x - longitudinal) * (x - 1))

    x = brentq(rayleigh, 1 + 1e-9, 3)
    root = math.sqrt((x - longitudinal) * (x - 1))
    slope = 4 * (2 * x - 1) - 4 * root - 2 * x * (2 * x - 1 - longitudinal) / root
    return (waves + math.pi * math.sqrt(x - longitudinal) / (2 * abs(slope))) / (2 * math.pi)


@pytest.mark.parametrize("poisson_ratio", [-0.99, -0.7, -0.3, 0.05, 0.263, 0.33, 0.47, 0.4999])
def test_radiation_is_the_integral_of_lamb(poisson_ratio):
    assert radiation(poisson_ratio) == pytest.approx(lamb(poisson_ratio), rel=1e-8)


def test_integral_of_lamb():
    # An independent quadrature of the cuts and the pole, to nine digits.
    printed = {
        0.0: 0.213963975, 0.1: 0.185563886, 0.2: 0.159864402, 0.25: 0.148133877, 0.3: 0.137227073,
        0.35: 0.127225029, 0.4: 0.118243553, 0.45: 0.110474339, 0.49: 0.105421371, 0.5: 0.104424264,
    }  # fmt: skip
    assert [lamb(nu) for nu in printed] == pytest.approx(list(printed.values()), abs=6e-10)
    assert radiation(list(printed)) == pytest.approx(list(printed.values()), rel=1e-8)


def radiated_share(impact):
    """Share of the energy that leaves, from the slopes of the force of the history."""
    result = rs.solve(impact)
    history = result.sample(n_points=3001)
    slopes = np.diff(history.force) / np.diff(history.time)
    pulse = float((slopes**2 * np.diff(history.time)).sum())
    shear, phase = impact.material.shear, impact.material.shear.relaxation_times / result.contact_time
    storage = shear.equilibrium_modulus + float((shear.branch_moduli * phase**2 / (1.0 + phase**2)).sum())
    speed = math.sqrt(storage / impact.material.density)
    beta = lamb(impact.material.poisson_ratio)
    return beta * pulse / (impact.material.density * speed**3) / (0.5 * impact.mass * impact.velocity**2), result


def test_share_of_energy_of_an_elastic_impact():
    # 1 - e = 1.9897683 beta k v0/(rho c^3 sqrt(d)) for a Hertz impact; the share is twice that.
    rubber, radius, velocity = rs.Material(1e6, 3e6, density=1000.0), 0.01, 0.03
    impact = rs.Impact(rubber, rs.Parabola(radius), 0.004, velocity)
    share, result = radiated_share(impact)
    stiffness = 4 / 3 * impact.reduced_modulus.equilibrium_modulus * math.sqrt(radius)
    speed, depth = math.sqrt(1e6 / 1000.0), result.max_indentation_depth
    loss = 1.9897683 * lamb(rubber.poisson_ratio) * stiffness * velocity / (1000.0 * speed**3 * math.sqrt(depth))
    assert result.validity["waves"].value == pytest.approx(2.0 * loss, rel=1e-6)
    assert share == pytest.approx(2.0 * loss, rel=1e-4)


@pytest.mark.parametrize(("branch", "time"), [(1e7, 1e-3), (1e7, 1e-4), (1e8, 1e-4), (1e6, 1e-4)])
def test_share_of_energy_follows_the_skewness_of_the_force(branch, time):
    # At 0.1 ms the integral is 1.5 times that of a Hertz impact of the same force and time.
    rubber = rs.Material(rs.PronySeries(1e6, [branch], [time]), math.inf, density=1.0)
    share, result = radiated_share(rs.Impact(rubber, rs.Parabola(0.01), 0.005, 1.0))
    assert result.validity["waves"].value == pytest.approx(share, rel=0.1)


def test_waves_that_return_before_the_contact_ends_are_kept():
    rubber = rs.Material(1e6, math.inf, density=1000.0)
    impact = rs.Impact(rubber, rs.Parabola(0.01), 0.004, 1.0)
    result = rs.solve(impact)
    deep = 0.5 * math.sqrt(1e6 / 1000.0) * result.contact_time
    waves = result.validity["waves"]
    assert waves.exceeded
    assert f"{deep:.3g} m" in waves.message
    assert result.validity_on(1.001 * deep)["waves"].value == waves.value
    stated = rs.solve(replace(impact, body_size=0.999 * deep)).validity
    assert stated == result.validity_on(0.999 * deep)
    assert stated["waves"].value == 0.0
    assert not stated["waves"].exceeded
    assert "return" in stated["waves"].message
    assert stated["half_space"].value == pytest.approx(result.max_contact_radius / (0.999 * deep))


def test_a_thin_layer_keeps_its_waves():
    rubber = rs.Material(1e6, math.inf, density=1000.0)
    pads = [rs.Layer(rs.Parabola(0.01), thickness, "frictionless") for thickness in (0.01, 1.0)]
    thin, thick = (rs.solve(rs.Impact(rubber, pad, 0.004, 1.0)) for pad in pads)
    speed = math.sqrt(1e6 / 1000.0)
    assert 2.0 * 0.01 / speed < thin.contact_time
    assert thick.contact_time < 2.0 * 1.0 / speed
    assert thin.validity["waves"].value == 0.0
    assert thick.validity["waves"].exceeded


@pytest.mark.parametrize("size", [0.0, -0.01, math.nan, [0.01, 0.02]])
def test_a_size_of_the_target_that_is_none_is_refused(size):
    impact = partial(rs.Impact, RUBBER, rs.Parabola(0.01), 0.005, 1.0, body_size=size)
    assert in_one_line(impact).field == "body_size"


@pytest.mark.parametrize("ratio", [0.003, 0.01])
def test_share_of_energy_of_equal_bodies(ratio):
    # An elastic ball on a half-space of its own material, nu = 1/4: 0.84 (v/c)^(3/5).
    # K = 5 G/3 at nu = 1/4.
    solid = rs.Material(1.2e9, 2e9, density=1200.0)
    wave = math.sqrt(1.2e9 / 1200.0)
    mass = 4 / 3 * math.pi * 1200.0 * 0.01**3
    result = solved(solid, rs.Parabola(0.01), mass, ratio * wave, counter_material=solid)
    assert result.mach_number[0] == pytest.approx(ratio)
    assert result.radiated_energy_ratio[0] == pytest.approx(0.84 * ratio**0.6, rel=0.02)


@pytest.mark.parametrize("denser", [1.0, 7.0])
def test_share_of_energy_of_a_rigid_ball_on_rubber(denser):
    # 2.22 (rho_ball/rho)^(-1/5) (v/c)^(3/5)
    rubber = rs.Material(1e6, math.inf, density=1000.0)
    velocity = 0.002 * math.sqrt(1e6 / 1000.0)
    mass = 4 / 3 * math.pi * 1000.0 * denser * 0.01**3
    result = solved(rubber, rs.Parabola(0.01), mass, velocity)
    assert result.radiated_energy_ratio[0] == pytest.approx(2.22 * denser**-0.2 * 0.002**0.6, rel=0.01)


def test_wave_speed_follows_the_modulus_at_the_contact_time():
    # Polyisobutylene at 293 K: 22 m/s, not the 1099 m/s of the glass (G(T) = 0.45 MPa).
    rubber = rs.library.get("polyisobutylene").at(293.0)
    rubber = rs.Material(rubber.shear, rubber.bulk, density=920.0)
    result = solved(rubber, rs.Parabola(0.005), 0.004, 10.0)
    assert result.wave_speed[0] == pytest.approx(math.sqrt(0.45e6 / 920.0), rel=0.3)
    assert report(result)["waves"].exceeded


def test_the_slower_body_counts_in_either_order():
    light, heavy = (rs.Material(modulus, math.inf, density=1000.0) for modulus in (1e6, 1e9))
    pairs = [solved(a, rs.Parabola(0.1), 1e-3, 0.5, b) for a, b in ((light, heavy), (heavy, light))]
    for result in pairs:
        assert result.mach_number[0] == pytest.approx(0.5 / math.sqrt(1000.0))
    assert pairs[0].radiated_energy_ratio[0] == pytest.approx(pairs[1].radiated_energy_ratio[0], rel=1e-9)


def test_waves_are_not_checked_without_a_density():
    assert report_of()["waves"].value is None
    hard = rs.Material(1e9, math.inf, density=1000.0)
    impact = solved(hard, rs.Parabola(0.1), 1e-3, 0.01, rs.Material(1e6, math.inf))
    check = report(impact)["waves"]
    assert check.value is None
    assert not check.exceeded
    assert "density" in check.message


def test_waves_without_a_mass_compare_the_velocity():
    check = report_of(material=rs.Material(1e6, 1e9, density=1000.0), velocity=1.0)["waves"]
    assert check.value == pytest.approx(1.0 / math.sqrt(1000.0))
    assert check.exceeded


def test_strain_of_a_sphere_does_not_saturate():
    # Ginf = 10 kPa at 100 m/s: d/R = 61 where a/R ends at 1.
    result = solved(rs.Material(1e4, math.inf), rs.Sphere(0.005), 0.004, 100.0)
    check = report(result)["small_strain"]
    assert check.value > 10.0
    assert "no such contact" in check.message
    assert "Discard" in check.advice


@pytest.mark.parametrize(
    ("radius", "depth", "value", "buried"),
    [(1e-3, 1e-4, 0.1, False), (3e-3, 9e-4, 0.3, False), (3e-3, 3e-3, 1.0, False), (9e-3, 1.1e-2, 11 / 9, True),
     (1.1e-2, 1.21e-2, 1.1, True)],
)  # fmt: skip
def test_strain_of_a_round_body(radius, depth, value, buried):
    check = report_of(max_contact_radius=radius, max_indentation_depth=depth)["small_strain"]
    assert check.value == pytest.approx(value)
    assert check.exceeded == (value > STRAIN_LIMIT)
    assert ("no such contact" in check.message) == buried


@pytest.mark.parametrize("profile", [rs.Cone(1.2), rs.FlatPunch(1e-3), rs.FlatEndedParabola(0.01, 1e-3)])
def test_strain_of_other_bodies_is_depth_over_contact_radius(profile):
    check = report_of(profile, max_contact_radius=2e-3, max_indentation_depth=1e-3)["small_strain"]
    assert check.value == 0.5
    assert "d/a" in check.message
    assert "representative" not in check.message


def test_depth_over_contact_radius_is_a_over_r_for_a_parabola():
    ball = rs.Parabola(0.02)
    assert ball.transform(3e-3) / 3e-3 == pytest.approx(3e-3 / 0.02)


def test_softness_of_the_exact_sphere_at_the_limit():
    # The limit is based on these 0.4 %.
    depth = STRAIN_LIMIT**2
    ratio = rs.Sphere(1.0).force_integral_at_depth(depth) / rs.Parabola(1.0).force_integral_at_depth(depth)
    assert 1 - ratio == pytest.approx(0.004, abs=1e-4)


@pytest.mark.parametrize(("ratio", "excess"), [(0.1, 12.91), (0.2, 29.79), (0.5, 115.6)])
def test_half_space_against_the_exact_layer(ratio, excess):
    # Force of a parabola on a bonded incompressible layer over that on a half-space, at sqrt(R d)/h.
    check = report_of(max_contact_radius=ratio * 0.01, body_size=0.01)["half_space"]
    assert check.value == pytest.approx(ratio)
    assert check.exceeded
    shown = float(check.message.split("would be ")[1].split(" %")[0])
    assert shown == pytest.approx(excess, rel=0.04)


def test_half_space_at_the_limit_and_without_a_size():
    assert not report_of(max_contact_radius=SIZE_LIMIT * 0.01, body_size=0.01)["half_space"].exceeded
    assert "more than 100 %" in report_of(max_contact_radius=0.01, body_size=0.01)["half_space"].message
    assert report_of()["half_space"].value is None
    assert "no size" in report_of()["half_space"].message


@pytest.mark.parametrize(
    ("window", "exceeded"),
    [((1e-4, 1.0), False), ((4e-4, 1.0), True), ((1e-6, 2e-3), True), ((1e-2, 1.0), True), (None, False)],
)
def test_window_of_the_material(window, exceeded):
    # d/v0 = 1 ms and T = 3 ms: the contact needs 0.33 ms to 3 ms.
    check = report_of(material=rs.Material(1e6, 1e9, window=window))["window"]
    assert check.exceeded == exceeded
    assert (check.value is None) == (window is None)
    assert window is None or ("0.003 s" in check.message and f"{window[0]:.3g} s" in check.message)


def test_window_of_a_polymer_that_begins_after_the_contact():
    polymer = rs.library.relaxation_polymer
    result = solved(polymer, rs.Parabola(0.005), 0.004, 1.0)
    assert report(result)["window"].exceeded
    assert result.contact_time[0] < polymer.window[0]


@pytest.mark.parametrize(("nu", "p2", "glass"), [(0.49, 1e-3, -0.806), (0.45, 1e-2, -0.665), (0.499, 1e-2, 0.405)])
def test_instantaneous_poisson_ratio_of_the_paper(nu, p2, glass):
    # nu_0 = (3K - 2G_0)/(6K + 2G_0) of the curves of its figures 5 and 6.
    rubber = rs.standard_solid(1e6, 1e6 / p2, 1e3, poisson_ratio=nu)
    check = report_of(material=rubber)["poisson_ratio"]
    assert check.value == pytest.approx(glass, abs=6e-4)
    assert check.exceeded == (glass < 0)
    ratio = 2 * (1 + nu) / (3 * (1 - 2 * nu)) / (1 + 1 / p2)
    assert f"K/G0 = {ratio:.3g}" in check.message


def test_a_poisson_ratio_that_dips_between_its_ends_is_doubtful():
    # The bulk relaxes before the shear: between 1e-6 s and 1 s the moduli are K = 1e7 and G = 1.01e8.
    material = rs.Material(rs.PronySeries(1e6, [1e8], [1.0]), rs.PronySeries(1e7, [1e9], [1e-6]))
    assert material.instantaneous_poisson_ratio == pytest.approx(material.poisson_ratio, rel=1e-12)
    check = report_of(material=material)["poisson_ratio"]
    assert check.exceeded
    assert check.words == "lowest Poisson ratio"
    assert check.value == pytest.approx((3.0 * 1e7 - 2.0 * 1.01e8) / (6.0 * 1e7 + 2.0 * 1.01e8), abs=0.01)
    assert "lowest one over time is -0.65" in check.message


def solved_report(material, counter_material):
    return report(solved(material, rs.Parabola(0.01), 0.004, 1.0, counter_material))


def test_a_body_of_negative_poisson_ratio_by_choice_hides_no_other_one():
    auxetic = rs.elastic(shear_modulus=1e6, poisson_ratio=-0.6)
    doubtful = rs.standard_solid(1e6, 1e7, 1e3, poisson_ratio=0.4)
    glass = doubtful.instantaneous_poisson_ratio
    assert glass == pytest.approx(-0.16)
    for pair in ((auxetic, doubtful), (doubtful, auxetic)):
        check = solved_report(*pair)["poisson_ratio"]
        assert check.exceeded
        assert check.value == glass


def test_a_constant_negative_poisson_ratio_is_not_doubtful():
    assert not report_of(material=rs.elastic(shear_modulus=1e6, poisson_ratio=-0.3))["poisson_ratio"].exceeded
    assert report_of(material=rs.Material(1e6, math.inf))["poisson_ratio"].value == 0.5


@pytest.mark.parametrize(
    ("mass", "radius", "exceeded"), [(0.004, 0.005, False), (5.0, 0.01, True), (0.005, 10.0, True)]
)
def test_a_mass_in_grams_or_a_radius_in_millimetres_gives_an_absurd_density(mass, radius, exceeded):
    check = report_of(rs.Parabola(radius), mass=mass)["density"]
    assert check.value == pytest.approx(mass / (4 / 3 * math.pi * radius**3))
    assert check.exceeded == exceeded


def test_density_of_two_equal_balls_is_not_that_of_the_reduced_one():
    steel = rs.library.steel
    ball = rs.Body(steel, radius=0.01)
    impact = rs.collision(ball, ball, velocity=0.1)
    result = of_impact(impact, rs.solve(impact))
    assert result.mean_density[0] == pytest.approx(4 * steel.density)
    assert result.mean_density[0] > DENSITY_LIMITS[1]
    assert not report(result)["density"].exceeded


def test_no_limit_is_exceeded_far_from_the_limits():
    result = report_of()
    assert result.warnings == []
    assert [check.kind for check in result] == KINDS


def test_worst_of_an_array_and_of_several_contacts():
    first = solved(rs.Material(1e6, math.inf), rs.Parabola([[0.01], [0.02]]), 0.005, [0.1, 5.0])
    second = solved(rs.Material(1e6, math.inf, density=1000.0), rs.Cone(1.2), 0.005, 1.0)
    assert first.strain_number.shape == (4,)
    both = together([first, second])
    assert report(both)["small_strain"].value == pytest.approx(max(first.strain_number.max(), second.strain_number[0]))
    assert report(both)["waves"].value == pytest.approx(second.radiated_energy_ratio[0])


def test_contacts_that_were_not_solved_are_left_out():
    bad = dict.fromkeys(("max_contact_radius", "max_indentation_depth", "contact_time"), math.nan)
    result = report_of(**bad)
    assert result.warnings == []
    assert result["small_strain"].value is None
    some = report_of(max_contact_radius=[math.nan, 3e-3], max_indentation_depth=[math.nan, 9e-4])
    assert some["small_strain"].value == pytest.approx(0.3)


def test_the_time_of_a_contact_without_an_end_follows_from_its_depth():
    result = report_of(material=rs.Material(1e6, 1e9, window=(1e-6, 1e-3)), contact_time=math.inf)
    # 2.943 d/v0
    assert result["window"].value == pytest.approx(2.9432751843e-3 / 1e-3)


def test_columns_are_registered_quantities():
    result = solved(rs.Material(1e6, 1e9, density=1000.0), rs.Parabola(0.01), 0.005, [0.1, 1.0], body_size=0.01)
    table = {name: getattr(result, name) for name in VALIDITY}
    assert list(table) == list(VALIDITY)
    for name, values in table.items():
        assert values.shape == (2,)
        quantity = VALIDITY[name]
        reference = values[np.isfinite(values)]
        assert np.all((reference >= quantity.low) & (reference <= quantity.high)), name


def test_report_is_plain_data():
    result = report_of(max_contact_radius=3e-3, max_indentation_depth=9e-4, mass=1.0)
    assert pickle.loads(pickle.dumps(result)) == result
    assert list(json.loads(json.dumps(result.to_dict()))) == KINDS
    assert result.to_dict()["small_strain"]["value"] == result["small_strain"].value
    assert result.warnings == [f"{check.message}. {check.advice}" for check in result if check.exceeded]
    assert named(lambda: result["wave"]) == ("kind", "wave")


def test_report_as_text_and_as_html():
    result = report_of(max_contact_radius=3e-3, max_indentation_depth=9e-4)
    lines = str(result).splitlines()
    assert len(lines) == 1 + len(KINDS) + 2
    assert result["small_strain"].advice in str(result)
    page = result._repr_html_()
    assert page.count("<tr>") == 1 + len(KINDS)
    assert "above the limit 0.2" in page


def test_the_share_of_radiated_energy_is_compared_with_its_limit():
    rubber = rs.Material(1e6, math.inf, density=1000.0)
    for velocity, exceeded in ((1e-4, False), (1.0, True)):
        check = report(solved(rubber, rs.Parabola(0.01), 0.005, velocity))["waves"]
        assert check.threshold == RADIATION_LIMIT
        assert check.exceeded == exceeded == (check.value > RADIATION_LIMIT)


# SOUND, stiff and slow, is far from every limit. Each entry below exceeds one limit.
SOUND = rs.Impact(
    rs.standard_solid(1e9, 1e9, 1e4, poisson_ratio=0.4, density=1e3), rs.Parabola(0.01), mass=0.005, velocity=1e-3
)
WINDOWED = replace(SOUND.material, window=(1e-12, 1e-10))
DOUBTFUL = {
    "small_strain": replace(SOUND, material=rs.standard_solid(1e2, 1e2, 1e-2, poisson_ratio=0.4), velocity=1.0),
    "waves": replace(SOUND, material=replace(SOUND.material, density=1e5), velocity=3.0),
    "window": replace(SOUND, material=WINDOWED),
    "poisson_ratio": replace(SOUND, material=rs.standard_solid(1e9, 1e11, 1e5, poisson_ratio=0.4)),
    "density": replace(SOUND, mass=1.0),
}


def of_sweep(impact):
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        table = rs.sweep(impact, {"velocity": [0.5 * impact.velocity, impact.velocity]})
    return json.loads(table.attrs["validity"])["checks"], [str(item.message) for item in caught]


def of_indentation(impact):
    depth = rs.solve(impact).max_indentation_depth
    history = rs.triangle(depth, depth / impact.velocity)
    return of_result(rs.indent(impact.material, impact.profile, depth=history))


def of_result(result):
    return result.validity.to_dict(), result.warnings


RESULTS = {
    "impact": lambda impact: of_result(rs.solve(impact)),
    "array": lambda impact: of_result(rs.solve(replace(impact, velocity=[0.1 * impact.velocity, impact.velocity]))),
    "list": lambda impact: of_result(rs.solve([SOUND, impact])),
    "elements": lambda impact: of_result(rs.solve(impact, method="elements", n_elements=50)),
    "bounces": lambda impact: of_result(rs.bounces(impact, max_bounces=2)),
    "sweep": of_sweep,
    "surrogate": lambda impact: of_result(
        rs.surrogate(impact, (0.5 * impact.velocity, impact.velocity), 1e-3, extrapolate=True)
    ),
    "indentation": of_indentation,
}


@pytest.mark.parametrize("kind", [None, *DOUBTFUL])
@pytest.mark.parametrize("result", RESULTS)
def test_every_result_warns_of_every_assumption(result, kind):
    checks, words = RESULTS[result](DOUBTFUL[kind] if kind else SOUND)
    assert list(checks) == KINDS
    exceeded = [item for item in KINDS if checks[item]["exceeded"]]
    if (result, kind) == ("indentation", "density"):
        # A prescribed indentation has no mass.
        assert checks["density"]["value"] is None
        return
    assert exceeded == ([kind] if kind else [])
    if kind:
        (message,) = words
        assert message.startswith(checks[kind]["message"])
        assert message.endswith(checks[kind]["advice"])
        assert f"{checks[kind]['value']:.3g}" in message or kind == "window"


RUBBER = rs.standard_solid(2e6, 2e7, 1e3, poisson_ratio=0.45, density=1100.0)


def waves_of(impact):
    return rs.solve(impact).validity["waves"]


def test_waves_name_the_body_that_is_deep():
    _ball, ground, steel = rs.Body(RUBBER, 0.015), rs.Body(RUBBER), rs.Body(None, 0.015, 0.1)
    rigid = rs.Impact(RUBBER, rs.Parabola(0.015), 0.1, 1.0)
    # Each body that radiates, with its place in the message.
    named = {
        "in the target if it is deeper": rs.collision(steel, ground, 1.0),
        "in the target if": rigid,
        "in the target, which is deeper": replace(rigid, body_size=1.0),
        "in the layer, which is deeper": replace(rigid, profile=rs.Layer(rs.Parabola(0.015), 1.0, "frictionless")),
        # So light and slow a contact that a wave does not cross the ball meanwhile.
        "in the ball, which is deeper": rs.collision(rs.Body(RUBBER, 0.015, 1e-9), rs.Body(None), 1.0),
        "in the first ball, which": rs.collision(rs.Body(RUBBER, 0.015, 1e-9), rs.Body(rs.library.steel, 0.02), 1.0),
        "in the second ball, which": rs.collision(rs.Body(rs.library.steel, 0.02), rs.Body(RUBBER, 0.015, 1e-9), 1.0),
    }
    for words, impact in named.items():
        check = waves_of(impact)
        assert check.exceeded, words
        assert words in check.message
    assert "soft body" in waves_of(rigid).advice
    assert "state" not in waves_of(replace(rigid, body_size=1.0)).advice


def test_a_soft_ball_keeps_its_waves():
    ball = rs.Body(RUBBER, 0.015)
    for impact in (rs.drop(ball, rs.Body(None), 0.05), rs.collision(rs.Body(None), ball, 1.0)):
        check = waves_of(impact)
        result = rs.solve(impact)
        # A wave runs through the ball and back before the contact ends.
        speed = math.sqrt(float(RUBBER.shear.storage_modulus(1.0 / result.contact_time)) / 1100.0)
        assert speed * result.contact_time > 2.0 * 0.03
        assert check.value == 0.0
        assert "the ball is not deeper" in check.message
        # The same numbers with the roles exchanged.
        assert waves_of(replace(impact, diameters=(math.inf, 2.0))).exceeded
    assert waves_of(rs.collision(ball, ball, 1.0)).value == 0.0


def test_waves_of_a_soft_ball_leave_a_soft_target():
    # Of two equal materials the half-space radiates, in either order, and a stated size is that of the flat body.
    ball, ground = rs.Body(RUBBER, 0.015), rs.Body(RUBBER)
    pair = [rs.collision(*item, velocity=1.0) for item in ((ball, ground), (ground, ball))]
    checks = [waves_of(item) for item in pair]
    assert checks[0].value == pytest.approx(checks[1].value, rel=1e-12)
    assert all("in the target if" in item.message for item in checks)
    assert all(waves_of(replace(item, body_size=0.04)).value == 0.0 for item in pair)


@pytest.mark.parametrize("diameters", [(2.0,), (0.0, 2.0), (-1.0, 2.0), (math.nan, 1.0)])
def test_diameters_that_are_none_are_refused(diameters):
    impact = partial(rs.Impact, RUBBER, rs.Parabola(0.015), 0.1, 1.0, diameters=diameters)
    assert in_one_line(impact).field == "diameters"
