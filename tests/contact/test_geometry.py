"""Geometries that are no profile on a half-space: what they give to the solvers, and what is refused."""

from dataclasses import dataclass, field, replace
from typing import Annotated

import numpy as np
import pytest

import restitution as rs
from restitution.contact.geometry import Geometry
from restitution.quantities import INPUTS
from scipy_oracle import solve_by_scipy

# Some of the impacts are deep.
pytestmark = pytest.mark.filterwarnings("ignore::restitution.errors.RestitutionWarning")
RUBBER = rs.Material(rs.PronySeries(1e6, [4e6, 3e6], [1e-4, 2e-3]), bulk=5e7, density=1100.0)


@dataclass(frozen=True, eq=False)
class Widened(Geometry):
    """Stiffness of a parabola or a sphere, with a contact radius that is larger by a factor."""

    radius: Annotated[float, INPUTS["radius"]]
    factor: float = 1.5
    kind: type = rs.Parabola
    power: bool = field(default=True)

    @property
    def _body(self):
        return self.kind(self.radius)

    @property
    def path_exponent(self):
        return self._body.path_exponent if self.power else None

    @property
    def path_coefficient(self):
        return self._body.path_coefficient if self.power else None

    def stiffness_radius(self, depth):
        return self._body.contact_radius(depth)

    def force_integral_at_depth(self, depth):
        return self._body.force_integral_at_depth(depth)

    def contact_radius(self, depth):
        return self.factor * self.stiffness_radius(depth)


GEOMETRIES = [Widened(0.01), Widened(0.01, power=False), Widened(0.01, kind=rs.Sphere, power=False)]


@pytest.mark.parametrize("geometry", GEOMETRIES)
def test_the_stiffness_radius_decides_the_impact_and_the_contact_radius_is_the_own(geometry):
    impact = rs.Impact(RUBBER, geometry, mass=0.005, velocity=2.0)
    found, same = rs.solve(impact), rs.solve(replace(impact, profile=geometry._body))
    assert found.restitution_coefficient == pytest.approx(same.restitution_coefficient, rel=1e-9)
    assert found.max_contact_radius == pytest.approx(1.5 * same.max_contact_radius, rel=1e-8)
    times = np.linspace(0.0, min(found.contact_time, same.contact_time), 9)
    history, half_space = found.sample(times), same.sample(times)
    # Near separation the radius falls like a root of the time that is left.
    assert history.contact_radius.values[:-1] == pytest.approx(1.5 * half_space.contact_radius.values[:-1], rel=1e-6)
    assert history.force.values == pytest.approx(half_space.force.values, abs=1e-7 * float(same.max_force))
    assert history.stored_energy.values == pytest.approx(half_space.stored_energy.values, abs=1e-6 * 0.01)
    many = rs.solve([impact, replace(impact, profile=geometry._body)])
    assert many.max_contact_radius == pytest.approx([1.5 * same.max_contact_radius, same.max_contact_radius], rel=1e-8)


@pytest.mark.parametrize("geometry", GEOMETRIES)
def test_scipy_and_indentations_give_the_own_contact_radius(geometry):
    impact = rs.Impact(RUBBER, geometry, mass=0.005, velocity=2.0)
    slow = solve_by_scipy(impact, 1e-6)
    assert slow.max_contact_radius == pytest.approx(rs.solve(impact).max_contact_radius, rel=1e-5)
    for depth, force in ((rs.triangle(1e-3, 1e-3), None), (None, rs.triangle(10.0, 1e-3))):
        found = rs.indent(RUBBER, geometry, depth=depth, force=force)
        same = rs.indent(RUBBER, geometry._body, depth=depth, force=force)
        assert found.max_contact_radius == pytest.approx(1.5 * same.max_contact_radius, rel=1e-7)
        times = np.linspace(0.01, 0.99, 12) * same.contact_end_time
        radii = [one.sample(times).contact_radius.values for one in (found, same)]
        assert radii[0] == pytest.approx(1.5 * radii[1], rel=1e-6)


def test_sweeps_give_the_own_contact_radius():
    impact = rs.Impact(RUBBER, GEOMETRIES[0], mass=0.005, velocity=2.0)
    outputs = ["max_contact_radius", "max_indentation_depth", "max_pressure"]
    swept = rs.sweep(impact, {"radius": [0.01, 0.02], "velocity": [1.0, 3.0]}, outputs=outputs)
    expected = 1.5 * np.sqrt(swept.radius * swept.max_indentation_depth)
    assert swept.max_contact_radius.values == pytest.approx(expected.values, rel=1e-8)
    assert np.isnan(swept.max_pressure).all()


@pytest.mark.parametrize("geometry", GEOMETRIES)
def test_what_needs_a_half_space_is_refused(geometry):
    impact = rs.Impact(RUBBER, geometry, mass=0.005, velocity=2.0)
    result = rs.solve(impact)
    assert np.isnan(result.max_pressure)
    assert np.isnan(rs.solve(replace(impact, velocity=np.array([1.0, 2.0]))).outputs["max_pressure"]).all()
    for refused in (
        lambda: result.pressure(0.0, 1e-4),
        lambda: result.surface_displacement(0.0, 1e-4),
        lambda: rs.solve(impact, "elements"),
    ):
        with pytest.raises(rs.InputError) as caught:
            refused()
        assert caught.value.field == "profile"
        assert geometry.obstacle in caught.value.rule


def test_geometries_are_equal_if_their_parameters_are():
    assert GEOMETRIES[0] == Widened(0.01)
    assert hash(GEOMETRIES[0]) == hash(Widened(0.01))
    assert GEOMETRIES[0] != GEOMETRIES[1]
    assert GEOMETRIES[0] != rs.Parabola(0.01)
    with pytest.raises(rs.InputError):
        Widened(-1.0)
