"""Static adhesive contact of elastic bodies against Maugis' closed forms, and the limits of JKR and DMT."""

import math

import numpy as np
import pytest
from scipy.optimize import minimize_scalar

import restitution as rs
from refusals import in_one_line
from restitution.contact.adhesion import maugis_number, rest, static_contact


def maugis(modulus, radius, stress, a, c):
    """Depth, force and range h0 of Maugis (1992), J. Colloid Interface Sci. 150, 243."""
    m, root = c / a, math.sqrt((c - a) * (c + a))
    depth = a * a / radius - 2.0 * stress / modulus * root
    force = 4.0 / 3.0 * modulus * a**3 / radius - 2.0 * stress * (c * c * math.acos(a / c) + a * root)
    bent = math.sqrt(m * m - 1.0)
    reach = a * a / (math.pi * radius) * (bent + (m * m - 2.0) * math.acos(1.0 / m))
    reach += 4.0 * stress * a / (math.pi * modulus) * (bent * math.acos(1.0 / m) - m + 1.0)
    return depth, force, reach


def test_a_parabola_has_the_closed_forms_of_maugis():
    rng = np.random.default_rng(5)
    for _ in range(100):
        modulus, radius, work = 10.0 ** rng.uniform((3, -6, -3), (10, -1, 0))
        lam, size = 10.0 ** rng.uniform((-1.5, -0.5), (1.5, 1.0))
        stress = lam / float(maugis_number(work, 1.0, modulus, radius))
        a = size * (work * radius**2 / modulus) ** (1.0 / 3.0)
        result = static_contact(rs.Parabola(radius), modulus, rs.Adhesion(work, stress), a)
        depth, force, reach = maugis(modulus, radius, stress, a, result.edge)
        scale = abs(depth) + a * a / radius
        assert result.depth == pytest.approx(depth, abs=1e-12 * scale)
        assert result.force == pytest.approx(force, abs=1e-11 * (abs(force) + work * radius))
        assert reach == pytest.approx(work / stress, rel=1e-9)


def pull_off(lam):
    """Largest pull at rest over pi w R of a unit ball."""
    work = 0.01
    adhesion = rs.Adhesion(work, lam / float(maugis_number(work, 1.0, 1.0, 1.0)))
    profile = rs.Parabola(1.0)
    result = minimize_scalar(
        lambda a: static_contact(profile, 1.0, adhesion, a).force, bounds=(1e-4, 0.5), method="bounded",
        options={"xatol": 1e-7},
    )  # fmt: skip
    return -result.fun / (math.pi * work)


def test_the_pull_off_force_lies_between_the_limits_and_tends_to_jkr():
    # Johnson, Kendall and Roberts: 1.5 pi w R; Derjaguin, Muller and Toporov: 2 pi w R.
    assert pull_off(0.8255) == pytest.approx(1.629, abs=5e-4)
    assert 1.95 < pull_off(0.02) <= 2.0
    lams = np.array([20.0, 40.0, 80.0])
    values = np.array([pull_off(lam) for lam in lams])
    # The thickness of the zone, some 1/lambda^2, times half-integer powers: Aitken's extrapolation needs no exponent.
    first, second = np.diff(values)
    assert values[-1] - second * second / (second - first) == pytest.approx(1.5, abs=1e-4)


def test_a_contact_without_load_is_at_rest():
    adhesion = rs.Adhesion(0.05, 1e6)
    for profile in (rs.Parabola(1e-3), rs.Sphere(1e-3), rs.Cone(0.8), rs.PowerLaw(3.0, 1e6)):
        result = rest(profile, 1e6, adhesion, 1e-5)
        scale = 1e6 * result.radius * abs(result.depth)
        assert abs(result.force) < 1e-9 * scale
        assert static_contact(profile, 1e6, adhesion, 1.01 * result.radius).force > 0.0


def test_the_gap_at_the_edge_is_the_range():
    # By quadrature of the inverse Abel transform, h = (2/pi) int_a^c H/sqrt(c^2 - x^2) dx, over x = c sin(u).
    adhesion, modulus = rs.Adhesion(0.05, 2e6), 1e7
    profile = rs.Sphere(1e-4)
    result = static_contact(profile, modulus, adhesion, 8e-6)
    c = result.edge
    start = math.asin(result.radius / c)
    u = start + (0.5 * math.pi - start) * (np.arange(20000) + 0.5) / 20000
    x = c * np.sin(u)
    gap = profile.transform(x) - result.depth - 2.0 * adhesion.stress / modulus * np.sqrt((c - x) * (c + x))
    assert 2.0 / math.pi * gap.mean() * (0.5 * math.pi - start) == pytest.approx(adhesion.range, rel=1e-6)


def test_work_is_stress_times_range():
    assert rs.Adhesion(0.05, stress=1e8).range == pytest.approx(5e-10)
    assert rs.Adhesion(0.05, range=2e-10).stress == pytest.approx(2.5e8)
    assert rs.Adhesion([0.02, 0.04]).stress.tolist() == pytest.approx([5e7, 1e8])


@pytest.mark.parametrize(
    ("numbers", "field"),
    [
        ({"work": 0.0}, "work"),
        ({"work": 0.05, "stress": -1.0}, "stress"),
        ({"work": 0.05, "range": math.nan}, "range"),
        ({"work": 0.05, "stress": 1e8, "range": 1e-9}, "stress, range"),
    ],
)
def test_numbers_out_of_range_are_refused(numbers, field):
    assert in_one_line(lambda: rs.Adhesion(**numbers)).field == field
