"""Windows of fractional materials: around the contact, wide enough, and a closed form."""

import math
import re

import numpy as np
import pytest
from scipy.optimize import brentq
from scipy.special import rgamma

from refusals import named
from restitution import FlatPunch, FractionalMaterial, Parabola, bounces, fractional_zener, solve, springpot
from restitution.impact.problem import Body, Impact, drop
from restitution.impact.window import for_contact, window_around

# Many of these bodies exceed the limits of the theory.
pytestmark = pytest.mark.filterwarnings(r"ignore:.*; exceeded in \d+ of")

GEL = FractionalMaterial(springpot(1e4, 0.3), bulk=math.inf, density=1000.0, name="gel")
ZENER = FractionalMaterial(fractional_zener(1e6, 1e7, 1e-3, 0.5), bulk=1e9, rtol=1e-7)


def ball(window, material=ZENER, **changes):
    numbers = {"mass": 0.005, "velocity": 1.0} | changes
    return Impact(material.within(window), Parabola(0.01), **numbers)


def mittag_leffler(order: float, other: float, z: float) -> float:
    """E_(order, other)(-z) by its series, for z of order one."""
    k = np.arange(120)
    with np.errstate(under="ignore"):
        return float(np.sum((-z) ** k * rgamma(order * k + other)))


@pytest.mark.parametrize("exponent", [0.1, 0.3, 0.5, 0.7])
def test_flat_punch_on_a_springpot(exponent):
    """m d'' = -K D^alpha d, with K = 8 a V/m: v = v0 E_(2-alpha,1)(-K t^(2-alpha)) until d'' = 0."""
    order = 2.0 - exponent
    z = brentq(lambda z: mittag_leffler(order, order, z), 0.5, 11.0, xtol=1e-14)
    reference = -mittag_leffler(order, 1.0, z)
    material = FractionalMaterial(springpot(1e4, exponent), bulk=math.inf, rtol=1e-8)
    impact = for_contact(lambda window: Impact(material.within(window), FlatPunch(0.01), 0.02, 1.0))
    result = solve(impact)
    assert result.restitution_coefficient == pytest.approx(reference, rel=3e-8)
    stiffness = 8.0 * 0.01 * 1e4 / 0.02
    assert result.contact_time == pytest.approx((z / stiffness) ** (1.0 / order), rel=3e-8)


def test_window_is_that_of_the_contact():
    impact = for_contact(ball)
    duration = solve(impact).contact_time
    # The window comes from a first solution, which is accurate to a per cent.
    assert impact.material.window == pytest.approx((1e-6 * duration, 2.0 * duration), rel=0.01)
    assert re.fullmatch(
        r"\d+ Prony terms stand for the fractional model, relative error \d\.\de-08", impact.material.assumptions
    )
    assert (impact.material.density, impact.material.name) == (None, None)
    assert GEL.within((1e-3, 1.0)).density == 1000.0


def test_a_wider_window_changes_nothing():
    duration = solve(for_contact(ball)).contact_time
    wide = solve(ball((1e-9 * duration, 1e3 * duration)))
    assert solve(for_contact(ball)).restitution_coefficient == pytest.approx(wide.restitution_coefficient, rel=1e-7)


def test_one_window_for_an_array_of_impacts():
    impact = for_contact(lambda window: ball(window, velocity=[1e-3, 10.0]))
    times = solve(impact).contact_time
    low, high = impact.material.window
    assert low == pytest.approx(1e-6 * times.min(), rel=0.01)
    assert high == pytest.approx(2.0 * times.max(), rel=0.01)


def test_two_fractional_bodies_and_their_bounces():
    def fall(window):
        return drop(Body(GEL.within(window), radius=0.02), Body(ZENER.within(window)), height=0.01)

    impact = for_contact(fall, longest=0.5)
    assert impact.material.window[1] == 0.5
    assert impact.counter_material.window == impact.material.window
    result = bounces(impact, max_bounces=3)
    assert result.contact_time[np.isfinite(result.contact_time)].max() < 0.5


def test_a_captured_body_has_a_wide_window():
    held = for_contact(lambda window: ball(window, external_force=5e3))
    assert solve(held).restitution_coefficient == 0.0
    assert held.material.window == (1e-12, 1e7)


def test_windows_of_contact_times():
    assert window_around(1e-3) == (1e-9, 2e-3, 0.0)
    assert window_around([1e-3, math.nan, 4e-3])[0] == 1e-9
    assert window_around([1e-3, math.inf]) == (1e-9, 1e7, 0.0)
    assert window_around(math.inf) == (1e-12, 1e7, 0.0)
    assert window_around(1e-3, longest=0.5) == (1e-9, 0.5, 0.0)


def test_invalid_input_is_refused():
    with pytest.raises(
        TypeError, match=r"^material: .* within a window of time: material\.within\(window\), or for_con"
    ):
        Impact(ZENER, Parabola(0.01), 0.005, 1.0)
    solid = ZENER.within((1e-6, 1.0))
    assert named(lambda: Impact(solid, Parabola(0.01), 1.0, 1.0, counter_material=ZENER)) == ("counter_material",)
    with pytest.raises(TypeError, match=r"^build = 3: must return an Impact"):
        for_contact(lambda window: 3)
    assert named(lambda: for_contact(ball, longest=-1.0)) == ("longest", -1.0)
