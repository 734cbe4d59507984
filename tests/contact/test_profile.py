import copy
import math
import pickle

import numpy as np
import pytest
from scipy.integrate import quad

from refusals import named
from restitution import Impact, Material, PronySeries, Tabulated, solve
from restitution.contact.profiles import (
    Cone,
    FlatEndedParabola,
    FlatPunch,
    Parabola,
    PowerLaw,
    Sphere,
    TruncatedCone,
    sphere_mass,
)

RADII = np.linspace(0.0, 0.4, 33)

TABLES = (
    Tabulated(RADII, np.sqrt(0.25 + RADII**2) - 0.5),
    Tabulated([0.0, 0.05, 0.1, 0.21, 0.4], [0.0, 0.01, 0.05, 0.2, 0.6]),
    Tabulated([0.0, 0.1, 0.2, 0.3, 0.4], [0.0, 0.0, 0.08, 0.21, 0.4]),
)
CONE = 1.0 / math.tan(1.1)

# Profiles with the radius of their flat face and the slope f'(r) of their flank.
PROFILES = {
    "parabola": (Parabola(radius=0.7), 0.0, lambda r: r / 0.7),
    "sphere": (Sphere(radius=0.7), 0.0, lambda r: r / math.sqrt(0.49 - r * r)),
    "cone": (Cone(half_angle=1.1), 0.0, lambda r: CONE),
    "power 1.5": (PowerLaw(exponent=1.5, coefficient=2.0), 0.0, lambda r: 3.0 * r**0.5),
    "power 3.7": (PowerLaw(exponent=3.7, coefficient=2.0), 0.0, lambda r: 7.4 * r**2.7),
    "truncated cone": (TruncatedCone(radius=0.1, half_angle=1.1), 0.1, lambda r: CONE),
    "flat-ended parabola": (FlatEndedParabola(radius=0.7, face_radius=0.1), 0.1, lambda r: r / 0.7),
    "table, round": (TABLES[0], 0.0, TABLES[0]._flank.derivative()),
    "table, kinked": (TABLES[1], 0.0, TABLES[1]._flank.derivative()),
    "table, face": (TABLES[2], 0.1, TABLES[2]._flank.derivative()),
}
CASES = pytest.mark.parametrize(("profile", "face", "slope"), PROFILES.values(), ids=PROFILES.keys())


def abel(profile, x, slope, face):
    """Integral of f'(x cos psi) over the flank: the definition of g/x, with r = x cos(psi)."""
    breaks = getattr(profile, "_flank", None)
    breaks = [] if breaks is None else [math.acos(r / x) for r in breaks.x if face < r < x]
    end = math.acos(face / x)
    total = 0.0
    for low, high in zip([0.0, *sorted(breaks)], [*sorted(breaks), end], strict=True):
        value, _ = quad(lambda psi: float(slope(x * math.cos(psi))), low, high, epsabs=0, epsrel=1e-13, limit=200)
        total += value
    return total


@CASES
@pytest.mark.parametrize("x", [0.02, 0.1001, 0.17, 0.39])
def test_transform_is_the_abel_integral(profile, face, slope, x):
    if x <= face:
        assert profile.transform(x) == 0.0
        return
    assert profile.transform(x) == pytest.approx(x * abel(profile, x, slope, face), rel=2e-12)
    assert profile.transform(-x) == profile.transform(x)


@CASES
@pytest.mark.parametrize("x", [0.02, 0.13, 0.39])
def test_force_integral_is_the_integral_of_the_transform(profile, face, slope, x):
    if x <= face:
        return
    # Pi = a g(a) - int_0^a g dx, by parts; in y with x^2 = b^2 + y^2, where g has no branch point.
    end = math.sqrt(x * x - face * face)
    area, _ = quad(
        lambda y: float(profile.transform(math.hypot(face, y))) * y / math.hypot(face, y),
        0.0,
        end,
        epsabs=0,
        epsrel=1e-10,
        limit=400,
    )
    assert profile.force_integral(x) == pytest.approx(x * float(profile.transform(x)) - area, rel=1e-9)


@CASES
@pytest.mark.parametrize("x", [0.13, 0.37])
def test_shape_has_the_slope(profile, face, slope, x):
    step = 3e-4 * x
    ends = profile.shape(np.array([x - 2 * step, x - step, x + step, x + 2 * step]))
    derivative = (8.0 * (ends[2] - ends[1]) - (ends[3] - ends[0])) / (12.0 * step)
    # Truncation (3e-4)^4 times derivatives of order 5, and rounding 1e-16/3e-4: both below 1e-11.
    assert derivative == pytest.approx(float(slope(x)), rel=1e-9, abs=1e-11)
    assert profile.shape(-x) == profile.shape(x)


@CASES
def test_contact_radius_inverts_the_transform(profile, face, slope):
    radii = np.array([face + 1e-6, 0.11, 0.2, 0.3999])
    depths = profile.transform(radii)
    np.testing.assert_allclose(profile.contact_radius(depths), radii, rtol=1e-13)
    np.testing.assert_allclose(profile.transform(profile.contact_radius(depths[1:])), depths[1:], rtol=1e-13)
    tiny = np.array([1e-12, 1e-8])
    if face == 0.0:
        np.testing.assert_allclose(profile.transform(profile.contact_radius(tiny)), tiny, rtol=1e-13)
    assert profile.contact_radius(0.0) == face
    assert profile.contact_radius(-1e-3) == 0.0


@CASES
def test_force_integral_at_depth(profile, face, slope):
    depths = profile.transform(np.array([0.11, 0.2, 0.3999]))
    over_radius = profile.force_integral(profile.contact_radius(depths))
    np.testing.assert_allclose(profile.force_integral_at_depth(depths), over_radius, rtol=1e-13)
    assert profile.force_integral_at_depth(0.0) == 0.0
    assert profile.force_integral_at_depth(-1.0) == 0.0
    # dPi/dd = a holds to 1e-9 even at depths where the closed forms in a would suffer from cancellation.
    for depth in (1e-9, 1e-5, float(depths[1])):
        low, high = profile.force_integral_at_depth(np.array([0.9999, 1.0001]) * depth)
        assert (high - low) / (2e-4 * depth) == pytest.approx(float(profile.contact_radius(depth)), rel=1e-8)


@CASES
def test_shape_of_the_result_follows_the_argument(profile, face, slope):
    integrals = (profile.force_integral, profile.force_integral_at_depth)
    for method in (profile.shape, profile.transform, profile.contact_radius, *integrals):
        assert np.shape(method(0.003)) == ()
        assert np.shape(method([0.003])) == (1,)
        assert np.shape(method(np.full((2, 3), 0.003))) == (2, 3)
        assert np.shape(method(np.empty(0))) == (0,)


@CASES
def test_equality_hash_and_copies(profile, face, slope):
    for twin in (copy.deepcopy(profile), pickle.loads(pickle.dumps(profile))):
        assert twin == profile
        assert hash(twin) == hash(profile)
        assert twin.transform(0.2) == profile.transform(0.2)
    assert profile != Parabola(radius=0.123)
    with pytest.raises(AttributeError):
        profile.radius = 1.0


def test_arrays_of_parameters_compare_whole():
    assert Parabola(radius=[1.0, 2.0]) == Parabola(radius=[1.0, 2.0])
    assert Parabola(radius=[1.0, 2.0]) != Parabola(radius=[1.0, 3.0])
    assert Parabola(radius=[1.0, 2.0]) != Parabola(radius=1.0)


@pytest.mark.parametrize(
    ("exponent", "factor"),
    # kappa_n of Popov and Hess (2015), Table 3.1, in closed form: pi/2, 2, 3 pi/4, 8/3, 15 pi/16, 16/5.
    [(1, math.pi / 2), (2, 2.0), (3, 0.75 * math.pi), (4, 8 / 3), (5, 15 * math.pi / 16), (6, 16 / 5)],
)
def test_power_law_factor(exponent, factor):
    assert PowerLaw(exponent, 3.0).transform(0.5) == pytest.approx(3.0 * factor * 0.5**exponent, rel=1e-15)


def test_power_law_factor_at_large_exponents_is_continuous_and_asymptotic():
    low, high = PowerLaw([299.999999, 300.000001], 1.0).transform(1.0)
    assert high / low == pytest.approx(1.0, rel=1e-8)
    # Stirling: kappa_n = sqrt(pi n/2) (1 + 1/(4n) + 1/(32 n^2) + ...)
    for n, tolerance in ((380.0, 1e-9), (5000.0, 1e-11)):
        expected = math.sqrt(0.5 * math.pi * n) * (1 + 0.25 / n + 1 / (32 * n * n))
        assert PowerLaw(n, 1.0).transform(1.0) == pytest.approx(expected, rel=tolerance)


@pytest.mark.parametrize(
    "profile", [Parabola(0.3), Cone(1.2), PowerLaw(0.7, 0.2), PowerLaw(3.3, 5.0), FlatPunch(0.02)]
)
def test_path_law_of_the_power_laws(profile):
    depth = np.array([1e-9, 1e-4, 0.3])
    path = profile.path_coefficient * np.sqrt(depth) ** profile.path_exponent
    np.testing.assert_allclose(path, profile.contact_radius(depth), rtol=1e-14)
    assert isinstance(profile.path_exponent, float)
    assert isinstance(profile.path_coefficient, float)


def test_other_profiles_have_no_path_law():
    for name in ("sphere", "truncated cone", "flat-ended parabola", "table, round"):
        assert PROFILES[name][0].path_exponent is None
        assert PROFILES[name][0].path_coefficient is None


@pytest.mark.parametrize(
    ("make", "single"),
    [
        (lambda: Parabola([0.1, 0.2]), lambda i: Parabola([0.1, 0.2][i])),
        (lambda: Cone([1.0, 1.2]), lambda i: Cone([1.0, 1.2][i])),
        (lambda: PowerLaw(1.5, [2.0, 3.0]), lambda i: PowerLaw(1.5, [2.0, 3.0][i])),
        (lambda: PowerLaw([1.5, 2.5], 3.0), lambda i: PowerLaw([1.5, 2.5][i], 3.0)),
        (lambda: FlatPunch([0.5, 0.6]), lambda i: FlatPunch([0.5, 0.6][i])),
        (lambda: Sphere([0.5, 0.6]), lambda i: Sphere([0.5, 0.6][i])),
        (lambda: TruncatedCone([0.01, 0.02], 1.2), lambda i: TruncatedCone([0.01, 0.02][i], 1.2)),
        (lambda: FlatEndedParabola([1.0, 2.0], 0.02), lambda i: FlatEndedParabola([1.0, 2.0][i], 0.02)),
    ],
)
def test_arrays_of_parameters_broadcast(make, single):
    profile, depth = make(), np.array([[0.01], [0.02], [0.05]])
    a = profile.contact_radius(depth)
    assert a.shape == (3, 2)
    for i in range(2):
        np.testing.assert_allclose(a[:, i], single(i).contact_radius(depth[:, 0]), rtol=1e-15)
        column = profile.force_integral_at_depth(depth)[:, i]
        np.testing.assert_allclose(column, single(i).force_integral_at_depth(depth[:, 0]), rtol=1e-15)
    if profile.path_exponent is not None:
        assert np.ndim(profile.path_coefficient) == 1
        path = profile.path_coefficient * np.sqrt(depth) ** profile.path_exponent
        np.testing.assert_allclose(np.broadcast_to(path, a.shape), a, rtol=1e-14)


def test_hertz_and_sneddon_forces():
    # F = (4/3) E* sqrt(R) d^(3/2) and F = (2/pi) E* tan(alpha) d^2, each F = 2 E* Pi, at E* = 1.
    depth = 3e-4
    hertz = 4 / 3 * math.sqrt(0.02) * depth**1.5
    assert 2 * Parabola(0.02).force_integral_at_depth(depth) == pytest.approx(hertz, rel=1e-15)
    sneddon = 2 / math.pi * math.tan(1.2) * depth**2
    assert 2 * Cone(1.2).force_integral_at_depth(depth) == pytest.approx(sneddon, rel=1e-14)


def test_flat_punch():
    punch = FlatPunch(0.02)
    np.testing.assert_array_equal(punch.transform([0.0, 0.02, 0.03]), [0.0, 0.0, math.inf])
    np.testing.assert_array_equal(punch.shape([-0.03, 0.01, 0.03]), [math.inf, 0.0, math.inf])
    np.testing.assert_array_equal(punch.contact_radius([-1.0, 0.0, 5.0]), [0.0, 0.02, 0.02])
    with pytest.raises(ValueError, match="force_integral_at_depth"):
        punch.force_integral(0.02)


@pytest.mark.parametrize(
    ("make", "expected"),
    [
        (lambda: Parabola(-1.0), ("radius", -1.0)),
        (lambda: Parabola([1.0, math.nan]), ("radius", 1, math.nan)),
        (lambda: Parabola("big"), ("radius", "big")),
        (lambda: Sphere(0.0), ("radius", 0.0)),
        (lambda: Cone(0.0), ("half_angle", 0.0)),
        (lambda: Cone(70.0), ("half_angle", 70.0)),
        (lambda: PowerLaw(0.0, 1.0), ("exponent", 0.0)),
        (lambda: PowerLaw(2.0, math.inf), ("coefficient", math.inf)),
        (lambda: FlatPunch(-2.0), ("radius", -2.0)),
        (lambda: TruncatedCone(1.0, 2.0), ("half_angle", 2.0)),
        (lambda: TruncatedCone(0.0, 1.0), ("radius", 0.0)),
        (lambda: FlatEndedParabola(1.0, -1.0), ("face_radius", -1.0)),
    ],
)
def test_bad_parameters(make, expected):
    assert named(make) == expected


def test_an_exponent_near_zero_gives_an_infinite_path_exponent():
    assert PowerLaw(1e-308, 1e4).path_exponent == np.inf


# L, the root of L tanh(L) = d, for R = 1, and ((1 + u^2) L - u)/2 with u = tanh(L): mpmath, 40 digits.
SPHERE_ROOTS = {
    1e-14: (1.00000000000000167e-7, 6.66666666666665999e-22),
    1e-6: (0.0010000001666666972, 6.66666599999999161e-10),
    0.01: (0.100166972559055508, 0.000665999921121290966),
    0.3: (0.576662216545076424, 0.106248778292466807),
    1.0: (1.19967864025773383, 0.599839320128866917),
    3.0: (3.01448277603377281, 2.50243698968065569),
    20.0: (20.0000000000000002, 19.5),
}


@pytest.mark.parametrize("depth", SPHERE_ROOTS)
def test_sphere_against_high_precision(depth):
    rapidity, force_integral = SPHERE_ROOTS[depth]
    ball = Sphere(radius=1.0)
    assert ball.contact_radius(depth) == pytest.approx(math.tanh(rapidity), rel=4e-16)
    assert ball.force_integral_at_depth(depth) == pytest.approx(force_integral, rel=2e-15)
    scaled = Sphere(radius=3.0)
    assert scaled.contact_radius(3.0 * depth) == pytest.approx(3.0 * math.tanh(rapidity), rel=6e-16)
    assert scaled.force_integral_at_depth(3.0 * depth) == pytest.approx(9.0 * force_integral, rel=2e-15)


def test_small_contacts_of_a_sphere_are_those_of_the_parabola():
    ball, parabola = Sphere(0.01), Parabola(0.01)
    a = 1e-6
    # g = (x^2/R)(1 + u^2/3 + ...) and Pi = (2 a^3/(3R))(1 + 2 u^2/5 + ...), u = a/R = 1e-4
    assert ball.transform(a) / parabola.transform(a) == pytest.approx(1 + 1e-8 / 3, rel=1e-15)
    assert ball.force_integral(a) / parabola.force_integral(a) == pytest.approx(1 + 4e-9, rel=1e-15)
    assert ball.shape(1e-9) == pytest.approx(0.5e-16, rel=1e-13)


def test_force_integral_is_smooth_where_the_series_ends():
    below, above = Sphere(1.0).force_integral(np.array([0.25 - 1e-9, 0.25 + 1e-9]))
    # dPi/da = a g'(a) with g' = artanh(a) + a/(1 - a^2).
    slope = 0.25 * (math.atanh(0.25) + 0.25 / (1.0 - 0.25**2))
    assert (above - below) / 2e-9 == pytest.approx(slope, rel=1e-6)


def test_equator_of_a_sphere():
    ball = Sphere(radius=2.0)
    assert ball.shape(2.0) == 2.0
    assert ball.max_contact_radius == 2.0
    for method in (ball.transform, ball.force_integral):
        np.testing.assert_array_equal(method([2.0, 3.0]), [math.inf, math.inf])
    assert ball.shape(2.1) == math.inf
    assert ball.contact_radius(1e4) == 2.0


def test_force_of_a_sphere_below_that_of_the_parabola():
    # The docstring states 0.4 % at a depth of 0.04 R, where the parabola has a/R = 0.2.
    ratio = Sphere(1.0).force_integral_at_depth(0.04) / Parabola(1.0).force_integral_at_depth(0.04)
    assert ratio == pytest.approx(0.996, abs=1e-4)


@pytest.mark.parametrize("depth", [30.0, 300.0, 3000.0])
def test_deep_spheres_are_solved_to_the_tolerance(depth):
    """Beyond a few radii a sphere acts as a cylinder with a rounded edge, whose full width acts on fast modes."""
    random = np.random.default_rng(int(depth))
    for _ in range(5):
        terms = random.integers(1, 8)
        moduli, times = 10.0 ** random.uniform(-3.0, 3.0, terms), depth * 10.0 ** random.uniform(-6.0, 2.0, terms)
        series = PronySeries(1.0, moduli, times)
        # The energy of a cylinder of radius 1 pressed in to this depth, with the modulus after this time.
        mass = 8.0 * float(series.relaxation_modulus(depth)) * depth**2
        impact = Impact(Material(series, np.inf), Sphere(1.0), mass, 1.0)
        fine, e = solve(impact, rtol=1e-12), solve(impact, rtol=1e-9).restitution_coefficient
        assert fine.max_indentation_depth > 0.1 * depth
        assert abs(e - fine.restitution_coefficient) < 1e-9 * max(e, 1e-3)


def test_a_mass_beyond_the_range_of_numbers_is_infinite():
    assert sphere_mass(1e3, np.array([1e103])).tolist() == [np.inf]


# d/(b cot alpha): a/b and Pi/(b^2 cot alpha) from the root of theta = D cos(theta): mpmath, 40 digits.
CONE_ROOTS = {
    1e-6: (1.0000000000005, 1.00000000000016662e-6),
    0.3: (1.04285405283759788, 0.304367770896564567),
    40.0: (26.101566508434243, 535.072531936488088),
    1e8: (63661977.8733779067, 3183098925499884.27),
}


@pytest.mark.parametrize("depth", CONE_ROOTS)
def test_truncated_cone_against_high_precision(depth):
    face, slope = 0.002, 1 / math.tan(1.2)
    tip = TruncatedCone(radius=face, half_angle=1.2)
    radius, force_integral = CONE_ROOTS[depth]
    # A few roundings, including those of the argument.
    assert tip.contact_radius(depth * face * slope) == pytest.approx(radius * face, rel=2e-15)
    result = tip.force_integral_at_depth(depth * face * slope)
    assert result == pytest.approx(force_integral * face**2 * slope, rel=4e-15)


def test_deep_contacts_are_those_of_the_full_cone_or_parabola():
    depth = 1e6
    cone, tip = Cone(1.2), TruncatedCone(1e-6, 1.2)
    assert tip.contact_radius(depth) == pytest.approx(float(cone.contact_radius(depth)), rel=1e-11)
    parabola, worn = Parabola(2.0), FlatEndedParabola(2.0, 1e-6)
    assert worn.force_integral_at_depth(1.0) == pytest.approx(float(parabola.force_integral_at_depth(1.0)), rel=1e-12)


@pytest.mark.parametrize("tip", [TruncatedCone(0.01, 1.2), FlatEndedParabola(0.5, 0.01)])
def test_shallow_contacts_are_those_of_the_punch(tip):
    depth = np.array([1e-30, 1e-12, 1e-9])
    np.testing.assert_allclose(tip.force_integral_at_depth(depth), 0.01 * depth, rtol=1e-9)
    np.testing.assert_array_equal(tip.transform([0.0, 0.005, 0.01]), 0.0)
    np.testing.assert_array_equal(tip.shape([0.0, 0.005, 0.01]), 0.0)


def test_worn_ball_in_closed_form():
    # F = 2 E* Pi = (2/(3R)) E* (2 a^2 + b^2) sqrt(a^2 - b^2) with R = 2, b = 0.3, a = 0.5: the root is 0.4.
    worn = FlatEndedParabola(radius=2.0, face_radius=0.3)
    assert worn.transform(0.5) == pytest.approx(0.5 * 0.4 / 2.0, rel=1e-15)
    assert 2 * worn.force_integral(0.5) == pytest.approx(2 / 6 * (0.5 + 0.09) * 0.4, rel=1e-15)
