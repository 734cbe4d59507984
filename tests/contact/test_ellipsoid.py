"""Elliptical contacts against the table of layers.md, the displacement under Hertz' pressure, and mpmath."""

import math

import mpmath
import numpy as np
import pytest

import restitution as rs
from refusals import in_one_line

# Some of the impacts are deep.
pytestmark = pytest.mark.filterwarnings("ignore::restitution.errors.RestitutionWarning")
SOLID = rs.Material(rs.PronySeries(1.0, [10.0], [0.1]), math.inf)

# layers.md, section 4: B/A, then b/a, R_eff/R_g, a/sqrt(R_g d), b/sqrt(R_g d).
TABLE = [
    (2, 0.630595701428, 1.02008645732, 1.25517347877, 0.791507000262),
    (5, 0.345999086637, 1.10998599938, 1.67259479367, 0.578716270926),
    (100, 0.0549840180571, 2.05938814149, 3.91882110611, 0.215472530461),
]


def with_ratio(ratio, mean=1.0):
    """Ellipsoid with a ratio of radii and their geometric mean."""
    return rs.Ellipsoid(mean * math.sqrt(ratio), mean / math.sqrt(ratio))


@pytest.mark.parametrize(("ratio", "axes", "radius", "a", "b"), TABLE)
def test_table_of_the_design_page(ratio, axes, radius, a, b):
    gap, depth = with_ratio(ratio, 0.03), 1e-5
    assert gap.axis_ratio == pytest.approx(axes, rel=1e-11)
    assert gap.effective_radius == pytest.approx(radius * 0.03, rel=1e-11)
    result = gap.semi_axes(gap.contact_radius(depth))
    assert result == pytest.approx(np.array([a, b]) * math.sqrt(0.03 * depth), rel=1e-11)
    swapped = rs.Ellipsoid(gap.radius_2, gap.radius_1)
    assert (swapped.axis_ratio, swapped.effective_radius) == (gap.axis_ratio, gap.effective_radius)


def test_axis_ratio_against_40_digits():
    random = np.random.default_rng(20261122)
    ratios = np.concatenate([[1 + 1e-12, 1.0001, 1e6], 10 ** random.uniform(0.0, 6.0, 40)])
    gap = rs.Ellipsoid(ratios, 1.0)
    with mpmath.workdps(40):
        for ratio, result in zip(ratios, gap.axis_ratio, strict=True):
            k = mpmath.mpf(float(result))
            error = mpmath.elliprd(0, 1, k**2) / mpmath.elliprd(0, k**2, 1) / mpmath.mpf(float(ratio)) - 1
            # The ratio falls with a power of k between 1.5 and 2; k itself is the exponential of up to -8.
            assert abs(error) < 5e-15


@pytest.mark.parametrize("ratio", [1.0, 1.7, 20.0, 400.0])
def test_pressure_of_hertz_displaces_the_surface_by_the_depth_minus_the_gap(ratio):
    # Along every chord through a point, sqrt(1 - x^2/a^2 - y^2/b^2) is the root of a quadratic C - 2 B s - A s^2,
    # with the integral pi (B^2 + A C)/(2 A^(3/2)); the integral over all directions converges geometrically.
    gap, depth = with_ratio(ratio, 0.8), 1e-3
    a, b = gap.semi_axes(gap.contact_radius(depth))
    angle = np.pi * np.arange(20_000) / 20_000
    cosine, sine = np.cos(angle), np.sin(angle)
    # F = 2 E* Pi = (2/3) pi a b p0 with E* = 1
    peak = 3 * gap.force_integral_at_depth(depth) / (math.pi * a * b)
    for x, y in [(0.0, 0.0), (0.7 * a, 0.0), (-0.3 * a, 0.8 * b)]:
        quadratic = cosine**2 / a**2 + sine**2 / b**2
        half = x * cosine / a**2 + y * sine / b**2
        rest = 1 - x**2 / a**2 - y**2 / b**2
        displaced = peak / math.pi * np.mean(math.pi**2 * (half**2 + quadratic * rest) / (2 * quadratic**1.5))
        expected = depth - x**2 / (2 * gap.radius_1) - y**2 / (2 * gap.radius_2)
        assert displaced == pytest.approx(expected, rel=1e-12, abs=1e-12 * depth)


def test_circle_is_a_parabola():
    ball, gap = rs.Parabola(0.03), rs.Ellipsoid(0.03, 0.03)
    depth = np.array([0.0, 1e-6, 1e-3])
    assert gap.axis_ratio == 1.0
    assert gap.contact_radius(depth) == pytest.approx(ball.contact_radius(depth), rel=4e-16)
    assert gap.force_integral_at_depth(depth) == pytest.approx(ball.force_integral_at_depth(depth), rel=8e-16)
    result, same = (rs.solve(rs.Impact(SOLID, body, 1.0, 1.0)) for body in (gap, ball))
    for name, value in same.outputs.items():
        # The residual of the energy balance is rounding.
        assert result.outputs[name] == pytest.approx(value, rel=1e-12, abs=1e-12), name


def test_impact_against_boundary_elements_in_time():
    # layers.md, section 3: E* = 4 + 40 exp(-t/0.1), B/A = 5.
    result = rs.solve(rs.Impact(SOLID, with_ratio(5.0), mass=1.0, velocity=1.0), rtol=1e-11)
    assert result.restitution_coefficient == pytest.approx(0.2172055364, abs=1e-10)


def test_elastic_pressure_and_semi_axes_of_a_result():
    gap = rs.Ellipsoid(0.1, 0.004)
    result = rs.solve(rs.Impact(rs.Material(1e6, math.inf), gap, mass=0.01, velocity=0.3))
    a, b = result.max_semi_axes
    # The error of the largest pressure is about 1e-5.
    assert result.max_pressure == pytest.approx(1.5 * result.max_force / (math.pi * a * b), rel=3e-5)
    assert b / a == pytest.approx(gap.axis_ratio)
    axes = gap.semi_axes(result.history.contact_radius)
    assert axes.shape == (2, result.history.time.size)
    assert axes.max(axis=1) == pytest.approx([a, b], rel=1e-6)


def test_semi_axes_of_results_of_all_shapes():
    # Hertz's ellipse of the radii 0.1 and 0.004 (the table above has its ratio); a disc has two equal ones.
    radii = np.array([0.1, 0.004])
    gap, disc, tip = rs.Ellipsoid(*radii), rs.Parabola(0.01), rs.Pyramid(1.4, 4)
    listed = rs.solve(
        [rs.Impact(rs.Material(1e6, math.inf), item, mass=0.01, velocity=0.3) for item in (gap, disc, tip)]
    )
    assert listed.max_semi_axes.shape == (2, 3)
    assert listed.max_semi_axes[:, 0].prod() == pytest.approx(listed.max_contact_radius[0] ** 2)
    assert listed.max_semi_axes[:, 1] == pytest.approx(listed.max_contact_radius[1])
    assert np.isnan(listed.max_semi_axes[:, 2]).all()
    many = rs.solve(rs.Impact(rs.Material(1e6, math.inf), rs.Ellipsoid(0.1, [[0.004], [0.1]]), 0.01, [0.1, 0.2, 0.3]))
    assert many.max_semi_axes.shape == (2, 2, 3)
    assert many.max_semi_axes[:, 0, 2] == pytest.approx(listed.max_semi_axes[:, 0])
    assert many.max_semi_axes[0, 1] == pytest.approx(many.max_semi_axes[1, 1])
    assert many.to_dict()["max_semi_axes"] == many.max_semi_axes.tolist()


def test_pressure_with_memory_and_of_many_impacts():
    gap = rs.Ellipsoid(2.0, [0.05, 0.5, 2.0])
    result = rs.solve(rs.Impact(SOLID, gap, mass=1.0, velocity=1.0))
    ball = rs.solve(rs.Impact(SOLID, rs.Parabola(gap.effective_radius), mass=1.0, velocity=1.0))
    assert result.restitution_coefficient == pytest.approx(ball.restitution_coefficient, rel=1e-12)
    # Stretched axes keep the force: the pressure times the area is that of the parabola.
    stretched = ball.outputs["max_pressure"] * (ball.max_contact_radius / result.max_contact_radius) ** 2
    assert result.outputs["max_pressure"] == pytest.approx(stretched, rel=1e-12)
    single = rs.solve(rs.Impact(SOLID, rs.Ellipsoid(2.0, 0.5), mass=1.0, velocity=1.0))
    assert single.max_pressure == pytest.approx(result.outputs["max_pressure"][1], rel=1e-4)
    listed = rs.solve([rs.Impact(SOLID, item, 1.0, 1.0) for item in (rs.Ellipsoid(2.0, 0.5), rs.Parabola(1.0))])
    assert listed.outputs["max_pressure"][0] == pytest.approx(single.max_pressure, rel=1e-4)
    assert listed.max_contact_radius[0] == pytest.approx(single.max_contact_radius, rel=1e-9)


@pytest.mark.parametrize("angle", [0.2, 1.0, math.pi / 2, 3.0])
def test_crossed_cylinders_have_the_curvatures_of_their_gap(angle):
    # Hessian of the gap, whose eigenvalues are the principal curvatures.
    radii = 0.01, 0.07
    axes = np.array([[1.0, 0.0], [math.cos(angle), math.sin(angle)]])
    hessian = sum(np.outer(axis, axis) / radius for axis, radius in zip(axes, radii, strict=True))
    gap = rs.crossed_cylinders(*radii, angle=angle)
    assert sorted([1 / gap.radius_1, 1 / gap.radius_2]) == pytest.approx(np.linalg.eigvalsh(hessian), rel=1e-12)


def test_gaps_of_two_bodies():
    random = np.random.default_rng(3)
    for _ in range(20):
        first, second = 10 ** random.uniform(-3, 0, 2), 10 ** random.uniform(-3, 0, 2)
        # A hollow that is flatter than the other body.
        second[1] = -10 * first.max()
        angle = random.uniform(0, math.pi)
        turn = np.array([[math.cos(angle), -math.sin(angle)], [math.sin(angle), math.cos(angle)]])
        hessian = np.diag(1 / first) + turn @ np.diag(1 / second) @ turn.T
        gap = rs.Ellipsoid.of_bodies(first, second, angle=angle)
        assert sorted([1 / gap.radius_1, 1 / gap.radius_2]) == pytest.approx(np.linalg.eigvalsh(hessian), rel=1e-11)
    # Nearly parallel axes: the curvature along the contact is a small difference of large numbers.
    gap = rs.crossed_cylinders(1.0, 1.0, angle=2e-3)
    assert max(gap.radius_1, gap.radius_2) == pytest.approx(1 / (2 * math.sin(1e-3) ** 2), rel=1e-13)
    ball_on_roller = rs.Ellipsoid.of_bodies((0.01, 0.01), (0.05, math.inf))
    assert (ball_on_roller.radius_1, ball_on_roller.radius_2) == (0.01, pytest.approx(1 / 120))


@pytest.mark.parametrize(
    ("make", "field", "text"),
    [
        (lambda: rs.Ellipsoid(0.0, 1.0), "radius_1", ""),
        (lambda: rs.Ellipsoid(1.0, math.inf), "radius_2", ""),
        (lambda: rs.Ellipsoid(1.0, [1.0, math.nan]), "radius_2", ""),
        (lambda: rs.Ellipsoid(10e3, 5e-3), "radius_1/radius_2", "must be at most 1e+06"),
        (lambda: rs.Ellipsoid([1.0, 2.0], [1.0, 2.0, 3.0]), "radius_1, radius_2", "radius_1 (2,), radius_2 (3,)"),
        (lambda: rs.crossed_cylinders(1.0, 1.0, angle=0.0), "angle", ""),
        (lambda: rs.crossed_cylinders(1.0, 1.0, angle=90.0), "angle", ""),
        (lambda: rs.crossed_cylinders(0.0, 1.0), "radii_1", "must be of a size"),
        (lambda: rs.crossed_cylinders([1.0, 2.0], 1.0), "radius_1", ""),
        (lambda: rs.crossed_cylinders(1.0, 2.0, angle=1e-7), "radius_1/radius_2", ""),
        (lambda: rs.Ellipsoid.of_bodies((1.0, 1.0), (-0.5, 2.0)), "radii_1, radii_2, angle", "in a single point"),
        (lambda: rs.Ellipsoid.of_bodies((1.0, math.inf), (2.0, math.inf)), "radii_1, radii_2, angle", ""),
        (lambda: rs.Ellipsoid.of_bodies(1.0, (1.0, 1.0)), "radii_1", "must be a pair"),
        (lambda: rs.Ellipsoid.of_bodies((1.0, 1.0), (0.0, 1.0)), "radii_2", ""),
    ],
)  # fmt: skip
def test_bad_input_is_refused(make, field, text):
    caught = in_one_line(make)
    assert caught.field == field
    assert text in str(caught)


def test_pressure_along_both_axes():
    gap = rs.Ellipsoid(2.0, 0.1)
    result = rs.solve(rs.Impact(SOLID, gap, mass=1.0, velocity=1.0))
    nodes, weights = np.polynomial.legendre.leggauss(60)
    for share in (0.3, 1.0, 1.4):
        t = share * result.turning_time
        history = result.sample([t])
        radius, force = float(history.contact_radius[0]), float(history.force[0])
        a, b = gap.semi_axes(radius)
        along, across = result.pressure(gap.mean_radius([0.5 * a, 0.0], [0.0, 0.5 * b]), t)
        assert along == pytest.approx(across, rel=1e-9)
        assert result.pressure(gap.mean_radius(1.001 * a, 0.0), t) == 0.0
        # Its integral over the ellipse is the force: F = 2 pi a b int p u du with r = u sqrt(a b), u = 1 - w^2.
        w = 0.5 + 0.5 * nodes
        p = result.pressure(radius * (1 - w**2), t)
        assert 2 * math.pi * a * b * np.sum(0.5 * weights * p * (1 - w**2) * 2 * w) == pytest.approx(force, rel=1e-6)


def test_pictures():
    page = rs.solve(rs.Impact(SOLID, rs.Ellipsoid(1.0, 0.5), mass=1.0, velocity=1.0)).plot()
    assert len(page.axes) == 6


def test_validity_report_has_the_strain_of_the_more_curved_direction():
    gap = rs.Ellipsoid(np.array([0.1, 0.002]), 0.01)
    result = rs.solve(rs.Impact(rs.Material(1e6, math.inf), gap, mass=0.01, velocity=0.3))
    a, b = gap.semi_axes(result.max_contact_radius)
    assert np.all(b / [0.01, 0.002] > a / [0.1, 0.01])
    assert result.validity["small_strain"].value == pytest.approx((b / [0.01, 0.002]).max())
    # No radius is that of a ball of this mass.
    assert result.validity["density"].value is None
