import copy
import math
import pickle

import numpy as np
import pytest
from scipy.integrate import quad

from refusals import in_one_line
from restitution import Tabulated
from restitution.contact.profiles import Cone, FlatEndedParabola, FlatPunch, Parabola, PowerLaw, Sphere, TruncatedCone

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
    ("make", "field", "value", "limits"),
    [
        (lambda: Parabola(-1.0), "radius", -1.0, "> 0"),
        (lambda: Parabola([1.0, math.nan]), "radius", math.nan, "> 0"),
        (lambda: Sphere(0.0), "radius", 0.0, "> 0"),
        (lambda: Cone(0.0), "half_angle", 0.0, "> 0 and < 1.5708 rad"),
        (lambda: Cone(70.0), "half_angle", 70.0, "> 0 and < 1.5708 rad"),
        (lambda: PowerLaw(0.0, 1.0), "exponent", 0.0, "> 0"),
        (lambda: PowerLaw(2.0, math.inf), "coefficient", math.inf, "> 0"),
        (lambda: FlatPunch(-2.0), "radius", -2.0, "> 0"),
        (lambda: TruncatedCone(1.0, 2.0), "half_angle", 2.0, "> 0 and < 1.5708 rad"),
        (lambda: TruncatedCone(0.0, 1.0), "radius", 0.0, "> 0"),
        (lambda: FlatEndedParabola(1.0, -1.0), "face_radius", -1.0, "> 0"),
    ],
)
def test_bad_parameters(make, field, value, limits):
    error = in_one_line(make)
    assert error.field == field
    assert error.value == pytest.approx(value, nan_ok=True)
    assert error.rule.endswith(limits)


def test_wrong_type():
    with pytest.raises(TypeError, match="radius = 'big'"):
        Parabola("big")


def test_an_exponent_near_zero_gives_an_infinite_path_exponent():
    assert PowerLaw(1e-308, 1e4).path_exponent == np.inf
