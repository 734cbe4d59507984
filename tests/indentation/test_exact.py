"""Indentations compared with a quadrature of the integral equations that shares no code with the kernel."""

import math
from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.optimize import brentq

from restitution import Cone, History, Material, Parabola, PowerLaw, PronySeries, Sphere, indent
from strategies import logarithmic, prony_series

_NODES, _WEIGHTS = np.polynomial.legendre.leggauss(20)
_HALF = np.concatenate([[0.0], 0.5 * 2.0 ** -np.arange(54.0)[::-1]])
_EDGES = np.concatenate([_HALF, 1.0 - _HALF[-2::-1]])


def integral(function, *ends):
    """Gauss quadrature on panels that shrink towards both ends of each interval, in case the integrand has a root."""
    total = 0.0
    for low, high in pairwise(ends):
        if high > low:
            edges = low + (high - low) * _EDGES
            half = 0.5 * np.diff(edges)
            nodes = edges[:-1, None] + half[:, None] * (1.0 + _NODES)
            total += np.sum(half[:, None] * _WEIGHTS * function(nodes.ravel()).reshape(nodes.shape))
    return total


class Quadrature:
    """Lee and Radok, and Ting, for a depth and its rate as functions of time; `eta` is a dashpot in parallel."""

    def __init__(self, series, profile, depth, rate, knots, turning):
        self.series, self.profile, self.eta = series, profile, series.parallel_viscosity
        self.depth, self.rate, self.knots, self.turning = depth, rate, np.asarray(knots), turning

    def modulus(self, t):
        """E(t) without the dashpot; times below zero, from rounding, count as zero."""
        series = self.series
        decay = np.exp(-np.maximum(t, 0.0)[..., None] / series.relaxation_times)
        return series.equilibrium_modulus + decay @ series.branch_moduli

    def ends(self, low, high):
        inner = np.union1d(self.knots, [self.turning])
        return [low, *inner[(inner > low) & (inner < high)], high]

    def force(self, t, t1=None):
        """Force at t; t1 is the instant of equal contact."""
        growing = t1 is None
        until = t if growing else t1
        total = integral(
            lambda x: self.modulus(t - x) * self.profile.contact_radius(self.depth(x)) * self.rate(x),
            *self.ends(0.0, until),
        )
        if growing:
            total += self.eta * np.ravel(self.profile.contact_radius(self.depth(t)) * self.rate(t))[0]
        return 2.0 * total

    def load(self, t1, t):
        """Residual of Ting's condition, zero at t if t1 is the instant of equal contact."""
        memory = integral(lambda x: self.modulus(t - x) * self.rate(x), *self.ends(t1, t))
        return memory + self.eta * np.ravel(self.rate(t))[0]

    def equal_contact(self, t):
        return brentq(lambda t1: self.load(t1, t), 0.0, self.turning, xtol=1e-16, rtol=1e-15)

    def end(self, stop):
        return brentq(lambda t: self.load(0.0, t), self.turning * (1.0 + 1e-9), stop, xtol=1e-15)


def polyline(knots, values):
    slopes = np.diff(values) / np.diff(knots)

    def rate(t):
        return slopes[np.clip(np.searchsorted(knots, t, side="right") - 1, 0, slopes.size - 1)]

    return (lambda t: np.interp(t, knots, values)), rate


def half_space(series):
    """Incompressible half-space whose reduced modulus E* = 4 G is this series."""
    return Material(series.scaled(0.25), math.inf)


SOLID = PronySeries(1.0, [4.0, 2.0, 0.5], [0.003, 0.3, 20.0])
LIQUID = PronySeries(0.0, [3.0, 1.0], [0.1, 2.0])
DAMPED = PronySeries(1.0, [2.0], [0.5], parallel_viscosity=0.05)
TRIANGLE = ([0.0, 1.0, 2.5], [0.0, 0.1, 0.0])
TRAPEZOID = ([0.0, 0.5, 1.5, 2.0], [0.0, 0.1, 0.1, 0.0])
BENT = ([0.0, 0.6, 1.0, 1.4, 2.0], [0.0, 0.02, 0.1, 0.07, -0.1])


@pytest.mark.parametrize("rtol", [1e-4, 1e-8, 1e-11])
@pytest.mark.parametrize(
    ("series", "profile", "history"),
    [
        (SOLID, Parabola(1.0), TRIANGLE),
        (LIQUID, Cone(1.2), TRAPEZOID),
        (DAMPED, PowerLaw(4.0, 2.0), BENT),
        (SOLID, Sphere(1.0), BENT),
        (LIQUID, PowerLaw(0.7, 1.0), TRIANGLE),
    ],
    ids=["parabola", "cone", "blunt", "sphere", "sharp"],
)
def test_force_under_a_depth(series, profile, history, rtol):
    knots, values = map(np.array, history)
    depth, rate = polyline(knots, values)
    turning = knots[values.argmax()]
    exact = Quadrature(series, profile, depth, rate, knots, turning)
    result = indent(half_space(series), profile, depth=values, time=knots, rtol=rtol)
    assert result.turning_time == pytest.approx(turning, rel=1e-14)
    assert result.contact_end_time == pytest.approx(exact.end(knots[-1]), rel=1e-12)
    growing = turning * np.array([0.01, 0.3, 0.77, 0.999])
    shrinking = turning + (result.contact_end_time - turning) * np.array([1e-3, 0.2, 0.6, 0.95])
    forces = [exact.force(t) for t in growing]
    radii = list(profile.contact_radius(depth(growing)))
    for t in shrinking:
        t1 = exact.equal_contact(t)
        forces.append(exact.force(t, t1))
        radii.append(float(profile.contact_radius(depth(t1))))
    sampled = result.sample(np.concatenate([growing, shrinking]))
    # Relative to the largest value. Errors of the quadrature and rounding are below 1e-12.
    assert np.abs(sampled.force - forces).max() <= max(rtol, 1e-12) * max(forces)
    assert np.abs(sampled.contact_radius - radii).max() <= max(rtol, 1e-12) * max(radii)


@pytest.mark.parametrize(
    ("series", "profile", "history"),
    [
        (SOLID, Parabola(1.0), ([0.0, 1.0, 2.5], [0.0, 1.0, 0.0])),
        (LIQUID, Cone(1.2), ([0.0, 0.5, 1.0, 2.0], [0.0, 1.0, 1.0, 0.0])),
        (DAMPED, Parabola(1.0), ([0.0, 1.0, 1.5, 2.5], [0.0, 1.0, 0.5, 0.0])),
        (SOLID, Sphere(4.0), ([0.0, 1.0, 2.5], [0.0, 1.0, 0.0])),
    ],
    ids=["parabola", "cone", "damped", "sphere"],
)
def test_depth_under_a_force(series, profile, history):
    """The computed depth and radius give the prescribed force by Lee and Radok, and Ting."""
    knots, values = map(np.array, history)
    result = indent(half_space(series), profile, force=values, time=knots, rtol=1e-10)
    assert result.contact_end_time == pytest.approx(knots[-1], rel=1e-14)
    assert knots[values.argmax()] <= result.turning_time < knots[-1]
    exact = Quadrature(
        series,
        profile,
        lambda t: result.sample(np.atleast_1d(t)).indentation_depth.values,
        lambda t: result.sample(np.atleast_1d(t)).indentation_velocity.values,
        knots,
        result.turning_time,
    )
    for t in result.turning_time * np.array([0.03, 0.5, 0.98]):
        assert exact.force(t) == pytest.approx(np.interp(t, knots, values), rel=1e-8)
        at = result.sample([t])
        assert at.contact_radius.item() == pytest.approx(
            float(profile.contact_radius(at.indentation_depth.item())), rel=1e-12
        )
    for share in (0.1, 0.5, 0.9):
        t = result.turning_time + share * (knots[-1] - result.turning_time)
        radius = result.sample([t]).contact_radius.item()
        t1 = brentq(
            lambda x, radius=radius: result.sample([x]).contact_radius.item() - radius,
            0.0, result.turning_time * (1.0 - 1e-12), xtol=1e-15,
        )  # fmt: skip
        assert exact.force(t, t1) == pytest.approx(np.interp(t, knots, values), rel=1e-8)
        assert abs(exact.load(t1, t)) <= 1e-8 * series.relaxation_modulus(0.01) * result.max_indentation_depth


def triangle_of(series, profile, *, depth=0.1, loading=1.0, unloading=1.5, rtol=1e-10):
    history = History.from_points([0.0, loading, loading + unloading], [0.0, depth, 0.0])
    return indent(half_space(series), profile, depth=history, rtol=rtol)


def columns(result, shares):
    return result.sample(shares * result.prescribed_history.stop)[["force", "contact_radius"]].to_array().values


SHARES = np.linspace(0.0, 1.0, 23)[1:-1]
SERIES = prony_series(max_branches=12, times=(1e-4, 1e4), moduli=(1e-2, 1e2), near_equal=True)


@given(SERIES, logarithmic(1e-6, 1e6), logarithmic(1e-6, 1e6))
@settings(max_examples=15)
def test_results_do_not_depend_on_the_units(series, stiffer, slower):
    first = triangle_of(series, Parabola(1.0))
    other = triangle_of(
        PronySeries(
            series.equilibrium_modulus * stiffer, series.branch_moduli * stiffer, series.relaxation_times * slower
        ),
        Parabola(1.0),
        loading=slower,
        unloading=1.5 * slower,
    )
    assert other.contact_end_time == pytest.approx(first.contact_end_time * slower, rel=1e-11)
    force, radius = columns(first, SHARES)
    force_2, radius_2 = columns(other, SHARES)
    assert force_2 / stiffer == pytest.approx(force, abs=1e-9 * force.max())
    assert radius_2 == pytest.approx(radius, abs=1e-9 * radius.max())


@given(SERIES, st.sampled_from([0.0, 1.0, 2.0]), logarithmic(1e-8, 1.0))
@settings(max_examples=15)
def test_scaling_with_the_depth_for_power_laws(series, p, depth):
    """For a = c d^(p/2), the force is proportional to d^(1 + p/2); the end of contact does not depend on the depth."""
    profile = {0.0: PowerLaw(8.0, 1.0), 1.0: Parabola(1.0), 2.0: Cone(1.0)}[p]
    power = 1.0 + 0.5 * float(profile.path_exponent)
    first, other = triangle_of(series, profile, depth=1.0), triangle_of(series, profile, depth=depth)
    assert other.contact_end_time == pytest.approx(first.contact_end_time, rel=1e-12)
    force, force_2 = columns(first, SHARES)[0], columns(other, SHARES)[0]
    assert force_2 == pytest.approx(force * depth**power, abs=2e-10 * force.max() * depth**power)


@given(SERIES, st.floats(0.05, 0.95))
@settings(max_examples=15)
def test_splitting_a_branch_changes_nothing(series, share):
    halves = PronySeries(
        series.equilibrium_modulus,
        np.concatenate([series.branch_moduli * share, series.branch_moduli * (1.0 - share)]),
        np.concatenate([series.relaxation_times, series.relaxation_times]),
    )
    first, other = triangle_of(series, Parabola(1.0)), triangle_of(halves, Parabola(1.0))
    force, radius = columns(first, SHARES)
    force_2, radius_2 = columns(other, SHARES)
    assert force_2 == pytest.approx(force, abs=2e-10 * force.max())
    assert radius_2 == pytest.approx(radius, abs=2e-10 * radius.max())


@given(prony_series(max_branches=12, times=(1e-6, 1e6), viscosity=None), st.floats(0.1, 10.0))
@settings(max_examples=25)
def test_loops_lose_energy_and_contacts_end_early(series, unloading):
    result = triangle_of(series, Parabola(1.0), unloading=unloading, rtol=1e-8)
    assert 1.0 <= result.contact_end_time <= 1.0 + unloading
    assert result.work >= -1e-8 * result.max_force * 0.1
    assert np.all(result.force >= 0.0)
    glass = series.equilibrium_modulus + series.branch_moduli.sum()
    springs = 2.0 * float(Parabola(1.0).force_integral_at_depth(0.1)) * glass
    dashpot = 2.0 * series.parallel_viscosity * math.sqrt(0.1) * 0.1
    assert result.max_force <= (springs + dashpot) * (1.0 + 1e-8)


@pytest.mark.parametrize("tau", 10.0 ** -np.arange(2.0, 9.0))
def test_equal_contact_of_a_fast_fluid(tau):
    """Ting's condition for a Maxwell fluid under a triangle: exp(-x) - exp(-x - y) = 1 - exp(-x).

    x and y are the times from the turning point to t and from t1 to the turning point, over tau.
    """
    fluid = Material(PronySeries(0.0, [1.0], [tau]), math.inf)
    result = indent(fluid, Cone(1.0), depth=[0.0, 1.0, 0.0], time=[0.0, 1.0, 2.0], rtol=1e-11)
    t = 1.0 + tau * np.array([1e-3, 1e-2, 0.05, 0.1, 0.2, 0.3, 0.5, 0.6])
    y = -np.log1p(-np.expm1((t - 1.0) / tau))
    radius = result.sample(t).contact_radius.values / result.max_contact_radius
    np.testing.assert_allclose(radius, 1.0 - tau * y, rtol=0.0, atol=2e-15)


@pytest.mark.parametrize("tau", [1e-6, 1e-8, 1e-10])
def test_velocity_of_a_fast_solid_is_that_of_an_elastic_one(tau):
    """Hertz: F = 4/3 E* sqrt(R) d^(3/2) with the equilibrium modulus, up to a lag of about tau."""
    solid = Material(PronySeries(0.25, [5.0], [tau]), math.inf)
    result = indent(solid, Parabola(1.0), force=[0.0, 1.0, 0.0], time=[0.0, 1.0, 2.0], rtol=1e-10)
    t = np.linspace(1.1, 1.9, 50)
    # An incompressible body: E = 3 G and E* = E/(1 - 1/4).
    stiffness = 4.0 / 3.0 * (4.0 * 0.25)
    velocity = -2.0 / 3.0 * (2.0 - t) ** (-1.0 / 3.0) * stiffness ** (-2.0 / 3.0)
    lag = 100.0 * 21.0 * tau
    np.testing.assert_allclose(result.sample(t).indentation_velocity, velocity, rtol=1e-8 + lag)
