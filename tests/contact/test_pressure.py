import math
from itertools import pairwise

import numpy as np
import pytest
from scipy.integrate import quad

from restitution import Cone, FlatEndedParabola, FlatPunch, Parabola, PowerLaw, Sphere, Tabulated, TruncatedCone
from restitution.contact.pressure import line_function, pressure, surface_displacement

RADII = np.linspace(0.0, 0.5, 11)
# Profiles with the radii where g is not smooth.
PROFILES = {
    "parabola": (Parabola(1.0), ()),
    "sphere": (Sphere(1.0), ()),
    "cone": (Cone(1.3), ()),
    "power 3.3": (PowerLaw(3.3, 1.0), ()),
    "power 0.7": (PowerLaw(0.7, 1.0), ()),
    "truncated cone": (TruncatedCone(0.1, 1.3), (0.1,)),
    "flat-ended parabola": (FlatEndedParabola(1.0, 0.1), (0.1,)),
    "table": (Tabulated(RADII, np.sqrt(1 + RADII**2) - 1), RADII),
}
CASES = pytest.mark.parametrize(("profile", "breaks"), PROFILES.values(), ids=PROFILES.keys())


def elastic(profile, breaks, a, reduced_modulus=1.0):
    depth = float(profile.transform(a))
    line = line_function(lambda x: reduced_modulus * (depth - profile.transform(x)), a, breakpoints=breaks)
    return line, depth


def force_of_pressure(load, breaks):
    """Integral of 2 pi r p by quadrature with nodes clustered at both ends of each piece."""
    nodes, weights = np.polynomial.legendre.leggauss(80)
    edges = np.array([0.0, *(b for b in breaks if 0.0 < b < load.extent), load.extent])
    total = 0.0
    for low, high in pairwise(edges):
        outer = 0.5 * math.pi * (nodes + 1)
        inner = 0.5 * math.pi * (1 - np.cos(outer))
        r = low + 0.5 * (high - low) * (1 - np.cos(inner))
        jacobian = 0.125 * math.pi**2 * (high - low) * np.sin(outer) * np.sin(inner)
        total += float(np.sum(weights * jacobian * 2 * math.pi * r * pressure(load, r)))
    return total


def test_hertz_ellipse():
    a, modulus = 0.3, 7.0
    load, _ = elastic(Parabola(2.0), (), a, modulus)
    r = np.array([0.0, 1e-9, 0.1, 0.2, 0.299999, 0.3 * (1 - 1e-12)])
    expected = 2 * modulus / (math.pi * 2.0) * np.sqrt((a - r) * (a + r))
    # The slope of a fit of degree ten amplifies rounding by about its square; seen: 4e-13.
    np.testing.assert_allclose(pressure(load, r), expected, rtol=2e-12)
    assert pressure(load, a) == 0.0
    assert pressure(load, 0.31) == 0.0


def test_love_and_sneddon_cone():
    # p = (E*/2) cot(alpha) arccosh(a/r), infinite on the axis.
    load, _ = elastic(Cone(1.3), (), 0.5)
    r = np.array([1e-12, 1e-5, 0.1, 0.4999])
    np.testing.assert_allclose(pressure(load, r), 0.5 / math.tan(1.3) * np.arccosh(0.5 / r), rtol=1e-11)
    assert pressure(load, 0.0) == math.inf


@pytest.mark.parametrize("n", [0.7, 1.02, 1.1, 1.5, 1.9, 2.5, 3.3])
def test_power_law_at_its_tip(n):
    # p(0) = E* kappa_n A n a^(n-1)/(pi (n-1)); off the axis (E*/pi) int_r^a g'(x)/sqrt(x^2 - r^2) dx with x = r cosh y.
    profile, a, modulus = PowerLaw(n, 2.0), 0.3, 5.0
    load, _ = elastic(profile, (), a, modulus)
    factor = modulus * float(profile.transform(1.0)) * n / math.pi
    axis = factor * a ** (n - 1.0) / (n - 1.0) if n > 1.0 else math.inf
    assert pressure(load, 0.0, tip_exponent=n) == pytest.approx(axis, rel=3e-9)
    for r in (1e-9, 1e-5, 1e-2):
        end = math.acosh(a / r)
        integral = quad(lambda y, r=r: (r * math.cosh(y)) ** (n - 1.0), 0.0, end, epsrel=1e-12, epsabs=0.0, limit=200)[
            0
        ]
        assert pressure(load, r, tip_exponent=n) == pytest.approx(factor * integral, rel=3e-9)


def test_boussinesq_flat_punch():
    # q = E* d: p = E* d/(pi sqrt(a^2 - r^2)), w = (2 d/pi) arcsin(a/r) outside.
    a, depth, modulus = 0.02, 1e-5, 3.0
    load = line_function(lambda x: modulus * depth - FlatPunch(a).transform(x), a)
    r = np.array([0.0, 0.01, 0.019999])
    expected = modulus * depth / math.pi / np.sqrt((a - r) * (a + r))
    # The slope of a fit of degree ten amplifies rounding by about its square; seen: 4e-13.
    np.testing.assert_allclose(pressure(load, r), expected, rtol=2e-12)
    assert pressure(load, a) == math.inf
    field = line_function(lambda x: np.full_like(x, depth), a)
    np.testing.assert_allclose(surface_displacement(field, r), depth, rtol=1e-14)
    r = np.array([0.02, 0.02 * (1 + 1e-12), 0.021, 1.0, 1e6])
    expected = 2 * depth / math.pi * np.arctan2(a, np.sqrt((r - a) * (r + a)))
    np.testing.assert_allclose(surface_displacement(field, r), expected, rtol=1e-13)


def test_sneddon_outside_the_parabola():
    # w = (1/(pi R)) ((2 a^2 - r^2) arcsin(a/r) + a sqrt(r^2 - a^2)) (Johnson 1985, eq. 3.42a).
    a, radius = 0.3, 2.0
    field, _ = elastic(Parabola(radius), (), a)
    r = np.array([0.3, 0.31, 0.5, 2.0])
    expected = ((2 * a * a - r * r) * np.arcsin(a / r) + a * np.sqrt(r * r - a * a)) / (math.pi * radius)
    np.testing.assert_allclose(surface_displacement(field, r), expected, rtol=1e-12)


@CASES
@pytest.mark.parametrize("a", [0.11, 0.4])
def test_pressure_carries_the_force(profile, breaks, a):
    load, depth = elastic(profile, breaks, a)
    assert load.integral == pytest.approx(2 * float(profile.force_integral_at_depth(depth)), rel=1e-10)
    assert force_of_pressure(load, breaks) == pytest.approx(load.integral, rel=1e-9)


@CASES
@pytest.mark.parametrize("a", [0.11, 0.4])
def test_surface_follows_the_indenter_inside_the_contact_only(profile, breaks, a):
    field, depth = elastic(profile, breaks, a)
    r = np.linspace(0.0, a, 101)
    # Accurate to 1e-9 of the depth, because the line function is only a fit near a branch point of g.
    inside = depth - profile.shape(r)
    np.testing.assert_allclose(surface_displacement(field, r), inside, rtol=0, atol=1e-9 * depth)
    outside = np.linspace(1.02, 1.2, 10) * a
    assert np.all(profile.shape(outside) - depth + surface_displacement(field, outside) > 0.0)


def test_edge_of_a_dashpot():
    # Kelvin-Voigt on the way in: q = E (d - x^2/R) + eta v jumps at the edge; ellipse and punch superpose.
    a = 0.5
    load = line_function(lambda x: (a * a - x * x) + 0.3, a)
    r = np.array([0.0, 0.2, 0.49])
    root = np.sqrt(a * a - r * r)
    np.testing.assert_allclose(pressure(load, r), 2 / math.pi * root + 0.3 / (math.pi * root), rtol=2e-12)
    assert force_of_pressure(load, ()) == pytest.approx(load.integral, rel=1e-9)
    assert pressure(line_function(lambda x: -1.0 + 0.0 * x, a), a) == -math.inf


@pytest.mark.parametrize("r", [0.0, 1e-7, 0.2, 0.9, 0.999, 0.99999])
def test_boundary_layer(r):
    # Relaxation much faster than the contact leaves a thin layer in the line load at the edge.
    width = 1e-3
    load = line_function(lambda x: 1.0 - np.exp((x - 1.0) / width), 1.0)

    def integrand(u):
        x = math.hypot(r, u)
        return math.exp((x - 1.0) / width) / width / x

    end = math.sqrt((1.0 - r) * (1.0 + r))
    inner = [math.sqrt(x * x - r * r) for x in (0.95, 0.98, 0.99, 0.997) if x > r]
    pieces = zip([0.0, *inner], [*inner, end], strict=True)
    expected = sum(quad(integrand, low, high, epsrel=1e-13, epsabs=0)[0] for low, high in pieces)
    assert pressure(load, r) == pytest.approx(expected / math.pi, rel=1e-10)


def test_kinked_displacement_of_the_rebound():
    # Contact up to 0.3 and an imprint up to 0.6: the two parts of the imprint superpose.
    field = line_function(lambda x: np.where(x <= 0.3, 0.5 - x, 0.4 - 2 / 3 * x), 0.6, breakpoints=[0.3])
    whole = line_function(lambda x: 0.4 - 2 / 3 * x, 0.6)
    extra = line_function(lambda x: 0.1 - x / 3, 0.3)
    r = np.array([0.0, 0.1, 0.299, 0.31, 0.59, 0.7])
    both = surface_displacement(whole, r) + surface_displacement(extra, r)
    np.testing.assert_allclose(surface_displacement(field, r), both, rtol=1e-12)


@pytest.mark.parametrize("function", [pressure, surface_displacement])
def test_shapes_and_bad_radii(function):
    line = line_function(lambda x: 1 - x, 1.0)
    assert np.shape(function(line, 0.3)) == ()
    assert np.shape(function(line, np.full((2, 3), 0.3))) == (2, 3)
    assert np.shape(function(line, [])) == (0,)
    for bad in (-0.1, math.nan):
        with pytest.raises(ValueError, match=r"r = .* m: must be >= 0"):
            function(line, [0.1, bad])


def test_a_polynomial_is_one_exact_cell():
    line = line_function(lambda x: 3.0 - x**2 + 0.5 * x**7, extent=2.0)
    assert line.edges.tolist() == [0.0, 2.0]
    x = np.linspace(0.0, 2.0, 33)
    np.testing.assert_allclose(line(x), 3.0 - x**2 + 0.5 * x**7, rtol=1e-13, atol=1e-13)
    assert line(-0.7) == line(0.7)
    assert line(2.000001) == 0.0
    assert line.edge_value == pytest.approx(63.0, rel=1e-14)
    # 2 (6 - 8/3 + 16)
    assert line.integral == pytest.approx(2 * (6 - 8 / 3 + 16), rel=1e-14)


@pytest.mark.parametrize(
    ("function", "breakpoints", "integral"),
    [
        (np.exp, (), 2 * (math.e - 1)),
        (lambda x: np.exp(-x / 1e-3), (), 2e-3),
        (lambda x: np.sqrt(np.maximum(x - 0.3, 0.0)), (0.3,), 4 / 3 * 0.7**1.5),
        (lambda x: np.sqrt(x), (), 4 / 3),
        (lambda x: np.where(x < 0.25, 1.0, 0.0) + x, (0.25,), 1.5),
        (lambda x: np.abs(x - 1 / 3), (), 2 * (1 / 18 + 2 / 9)),
    ],
)
def test_integrals_of_rough_functions(function, breakpoints, integral):
    line = line_function(function, 1.0, breakpoints=breakpoints)
    assert line.integral == pytest.approx(integral, rel=1e-11)


def test_cells_away_from_the_axis_double_at_most():
    line = line_function(lambda x: 1.0 + x, 1.0, breakpoints=[1e-6, 0.4])
    ratio = line.edges[2:] / line.edges[1:-1]
    assert np.max(ratio) <= 2.0
    assert 1e-6 in line.edges
    assert 0.4 in line.edges


def test_breakpoints_outside_or_at_the_ends_are_ignored():
    line = line_function(lambda x: x, 1.0, breakpoints=[-1.0, 0.0, 1e-20, 0.5, 0.5, 1.0, 3.0])
    assert line.edges.tolist() == [0.0, 0.5, 1.0]


def test_slope():
    line = line_function(lambda x: x**3, 2.0, breakpoints=[1.0])
    # d/dx at both ends of the second cell, t = -1 and 1, from its Chebyshev coefficients.
    signs = (-1.0) ** np.arange(line.slope.shape[1])
    np.testing.assert_allclose([line.slope[1] @ signs, line.slope[1].sum()], [3.0, 12.0], rtol=1e-12)


@pytest.mark.parametrize(
    ("function", "extent", "message"),
    [
        (lambda x: x, 0.0, "extent = 0 m"),
        (lambda x: x / np.zeros_like(x + 0.0) if False else x * np.nan, 1.0, "must return 11 finite values"),
        (lambda x: 1.0, 1.0, "must return 11 finite values"),
        (lambda x: np.sin(1e6 * x), 1.0, "unresolved by 4000 cells"),
    ],
)
def test_bad_line_functions(function, extent, message):
    with pytest.raises(ValueError, match=message):
        line_function(function, extent)
