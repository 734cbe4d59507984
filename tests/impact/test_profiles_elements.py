"""The element method converges to the exact solution at first order for every profile.

The elements use the transform g(x) of a profile only; the exact solution uses its inverse over the depth, in
the closed form or as a table.
"""

import math

import numpy as np
import pytest

from restitution import Impact, Material, PronySeries, Tabulated, solve, standard_solid
from restitution.contact.profiles import (
    Cone,
    FlatEndedParabola,
    FlatPunch,
    Parabola,
    PowerLaw,
    Profile,
    Sphere,
    TruncatedCone,
)
from restitution.impact.elements import solve_elements

SOLID = standard_solid(1.0, 10.0, 1.0, poisson_ratio=0.3)
RELAXING = Material(PronySeries(1.0, [2.0, 6.0], [0.1, 2.0]), PronySeries(2.0, [3.0], [0.5]))
RADII = np.linspace(0.0, 2.0, 41)
PROFILES: dict[str, Profile] = {
    "parabola": Parabola(1.0),
    "sphere": Sphere(1.0),
    "cone": Cone(1.2),
    "cusp": PowerLaw(0.7, 0.5),
    "power 4": PowerLaw(4.0, 0.5),
    "flat punch": FlatPunch(0.5),
    "truncated cone": TruncatedCone(0.3, 1.2),
    "flat-ended parabola": FlatEndedParabola(1.0, 0.3),
    "tabulated round tip": Tabulated(RADII, RADII**2 / 2.0 + 0.05 * RADII**4),
    "tabulated flat face": Tabulated(np.append(0.0, RADII + 0.3), np.append(0.0, 0.5 * RADII)),
    "tabulated rough tip": Tabulated(
        [0.0, 0.1, 0.3, 0.4, 0.7, 1.0, 1.5, 2.0], [0.0, 0.008, 0.03, 0.1, 0.25, 0.5, 1.3, 2.4]
    ),
}


def errors(impact: Impact, numbers: tuple[int, ...]) -> dict[str, np.ndarray]:
    """Relative errors of the element method for several numbers of elements."""
    exact = solve(impact)
    result = [solve_elements(impact, n_elements=n) for n in numbers]
    return {
        name: np.array([getattr(item, name) / getattr(exact, name) - 1.0 for item in result])
        for name in ("restitution_coefficient", "contact_time", "max_indentation_depth", "max_force")
    }


# The slow test below has all profiles; test_elements.py has the others.
@pytest.mark.parametrize(
    "name",
    [
        "sphere", "cusp", "power 4", "truncated cone", "flat-ended parabola", "tabulated round tip",
        "tabulated flat face",
    ],
)  # fmt: skip
def test_elements_converge_to_the_exact_value(name):
    coarse, fine = errors(Impact(SOLID, PROFILES[name], 1.0, 1.0), (32, 64))["restitution_coefficient"]
    # The error is about 0.2/n. With few elements it depends on their position at the edge of a flat face.
    assert 0.1 / 64 < fine < 0.3 / 64
    assert math.log2(coarse / fine) == pytest.approx(1.0, abs=0.12)
    # Extrapolation removes nine tenths of the error or more.
    assert abs(2.0 * fine - coarse) < 0.12 * fine


@pytest.mark.slow
@pytest.mark.parametrize("name", PROFILES)
def test_first_order_throughout(name):
    numbers = (100, 200, 400)
    result = errors(Impact(RELAXING, PROFILES[name], 1.0, 1.0), numbers)
    restitution = result["restitution_coefficient"]
    order = -np.polyfit(np.log(numbers), np.log(np.abs(restitution)), 1)[0]
    assert order == pytest.approx(1.0, abs=0.05)
    assert abs(2.0 * restitution[-1] - restitution[-2]) < 4e-5
    for quantity in ("max_indentation_depth", "max_force"):
        assert np.abs(result[quantity] * numbers).max() < 1.0
    # The last element separates late, at the depth of its width: (dx)^0.7 for the cusp.
    assert np.abs(result["contact_time"] * np.power(numbers, 0.7)).max() < 0.8


def test_elements_stay_within_a_table():
    """The grid of elements may extend beyond the end of a table."""
    r = np.linspace(0.0, 0.7, 15)
    short, whole = Impact(SOLID, Tabulated(r, r**2 / 2.0), 1.0, 1.0), Impact(SOLID, Parabola(1.0), 1.0, 1.0)
    result, expected = (solve_elements(impact, n_elements=32).restitution_coefficient for impact in (short, whole))
    # The estimates of the largest depth differ, and so do the time steps.
    assert result == pytest.approx(expected, rel=1e-6)
    deep = Impact(SOLID, Tabulated(r[:10], r[:10] ** 2 / 2.0), 1.0, 1.0)
    with pytest.raises(ValueError, match=r"0\.2025 m"):
        solve_elements(deep, n_elements=32)
