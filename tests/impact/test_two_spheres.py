"""Two equal spheres of any material move as one sphere on a rigid wall."""

import math

import numpy as np
import pytest

from restitution import Body, Material, PronySeries, burgers, collision, kelvin_voigt, solve, standard_solid

MATERIALS = {
    "standard solid": standard_solid(1e6, 1e7, 1e3, poisson_ratio=0.45, density=1200.0),
    "dashpot": kelvin_voigt(1e6, 300.0, poisson_ratio=0.3, density=1200.0),
    "liquid": burgers(1e7, 1e4, 3e6, 500.0, bulk_modulus=1e9, density=1200.0),
    "shear and bulk relax": Material(
        PronySeries(1e5, [1e6, 3e6, 2e6], [1e-5, 3e-4, 1e-2]),
        PronySeries(3e6, [2e7, 1e6], [1e-4, 1e-1]),
        density=1200.0,
    ),
}


@pytest.mark.parametrize("name", MATERIALS)
def test_mirror_images(name):
    """Each ball hits the plane of symmetry like a rigid wall, at half of the relative velocity."""
    ball = Body(MATERIALS[name], radius=0.01)
    pair = solve(collision(ball, ball, velocity=1.6))
    wall = solve(collision(ball, Body(None), velocity=0.8))
    assert 0.05 < wall.restitution_coefficient < 0.95
    assert pair.restitution_coefficient == pytest.approx(wall.restitution_coefficient, rel=2e-9)
    assert pair.contact_time == pytest.approx(wall.contact_time, rel=1e-9)
    for extreme, factor in (("max_indentation_depth", 2.0), ("max_force", 1.0), ("max_contact_radius", 1.0)):
        assert getattr(pair, extreme) == pytest.approx(factor * getattr(wall, extreme), rel=1e-8)
    # The force is the same, and the depth of the pair is twice as large. Times end just before separation, where the
    # radius falls as a root of time.
    times = np.linspace(0.0, 1.0 - 1e-6, 41) * min(pair.contact_time, wall.contact_time)
    two, item = pair.sample(times), wall.sample(times)
    for quantity, factor in (
        ("indentation_depth", 2.0), ("indentation_velocity", 2.0), ("force", 1.0), ("contact_radius", 1.0),
        ("kinetic_energy", 2.0), ("stored_energy", 2.0), ("dissipated_energy", 2.0),
    ):  # fmt: skip
        if quantity == "contact_radius":
            # a^2 falls linearly to zero at the end, so that the error of a is the root of that of the time.
            two[quantity], item[quantity] = two[quantity] ** 2, item[quantity] ** 2
        largest = float(np.abs(two[quantity]).max())
        np.testing.assert_allclose(
            two[quantity], factor * item[quantity], rtol=0.0, atol=2e-8 * largest, err_msg=quantity
        )
    r, t = np.linspace(0.0, 0.95, 7) * wall.max_contact_radius, 0.6 * wall.contact_time
    np.testing.assert_allclose(pair.pressure(r, t), wall.pressure(r, t), rtol=1e-6)
    np.testing.assert_allclose(
        pair.surface_displacement(r, 1.5 * wall.contact_time),
        2.0 * wall.surface_displacement(r, 1.5 * wall.contact_time),
        rtol=1e-6,
        atol=1e-8 * pair.max_indentation_depth,
    )


def test_compliances_of_a_pair_add():
    """Half-spaces with compliances 1 and 1/n have the modulus n/(n + 1) together."""
    soft, factor = MATERIALS["shear and bulk relax"], 3.0

    def scaled(share):
        return Material(soft.shear.scaled(share), soft.bulk.scaled(share), density=soft.density)

    ball = Body(soft, radius=0.01)
    pair = solve(collision(ball, Body(scaled(factor)), velocity=0.8))
    whole = solve(
        collision(Body(scaled(factor / (factor + 1.0)), radius=0.01), Body(None, mass=math.inf), velocity=0.8)
    )
    assert pair.restitution_coefficient == pytest.approx(whole.restitution_coefficient, rel=2e-9)
    assert pair.max_force == pytest.approx(whole.max_force, rel=1e-8)
