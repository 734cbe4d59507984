"""Geometries that are no profile on a half-space: what they give to the solvers, and what is refused."""

import math
import pickle
from dataclasses import dataclass, field, replace
from typing import Annotated

import numpy as np
import pytest

import restitution as rs
from refusals import in_one_line
from restitution import FractionalMaterial, Material, Parabola, PronySeries, springpot
from restitution.contact.geometry import Contact, Geometry
from restitution.errors import InputTypeError
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


ELLIPSOID, PYRAMID, BALL = rs.Ellipsoid(0.02, 0.005), rs.Pyramid(1.4, 3), rs.Parabola(0.01)
DEPTHS = np.linspace(1e-4, 5e-3, 60)
# E* = 4 for the incompressible twin, whose force is 2 E* Pi.
LAW = rs.ForceLaw(DEPTHS, 8.0 * BALL.force_integral_at_depth(DEPTHS), modulus=3.0, poisson_ratio=0.5)
# Each with a profile of the same stiffness, and its contact radius over the stiffness radius; NaN if it is not known.
BODIES = {
    "widened": (Widened(0.01), BALL, 1.5),
    "widened, by a table": (Widened(0.01, power=False), BALL, 1.5),
    "widened sphere": (Widened(0.01, kind=rs.Sphere, power=False), rs.Sphere(0.01), 1.5),
    "ellipsoid": (
        ELLIPSOID,
        rs.Parabola(ELLIPSOID.effective_radius),
        float(ELLIPSOID.contact_radius(1.0) / ELLIPSOID.stiffness_radius(1.0)),
    ),
    "pyramid": (PYRAMID, rs.Cone(math.atan(0.5 * math.pi * PYRAMID.constant * math.tan(1.4))), math.nan),
    "force law": (LAW, BALL, math.nan),
}
CASES = pytest.mark.parametrize(("geometry", "body", "factor"), BODIES.values(), ids=BODIES)


def approx(expected, rel):
    return pytest.approx(expected, rel=rel, nan_ok=True)


@CASES
def test_the_stiffness_radius_decides_the_impact_and_the_contact_radius_is_the_own(geometry, body, factor):
    impact = rs.Impact(RUBBER, geometry, mass=0.005, velocity=2.0)
    result, same = rs.solve(impact), rs.solve(replace(impact, profile=body))
    assert result.restitution_coefficient == pytest.approx(same.restitution_coefficient, rel=1e-9)
    assert result.max_contact_radius == approx(factor * same.max_contact_radius, 1e-8)
    times = np.linspace(0.0, min(result.contact_time, same.contact_time), 9)
    history, half_space = result.sample(times), same.sample(times)
    # Near separation the radius falls like a root of the time that is left.
    assert history.contact_radius.values[1:-1] == approx(factor * half_space.contact_radius.values[1:-1], 1e-6)
    assert history.force.values == pytest.approx(half_space.force.values, abs=1e-7 * float(same.max_force))
    assert history.stored_energy.values == pytest.approx(half_space.stored_energy.values, abs=1e-6 * 0.01)
    many = rs.solve([impact, replace(impact, profile=body)])
    assert many.max_contact_radius == approx([factor * same.max_contact_radius, same.max_contact_radius], 1e-8)


@CASES
def test_scipy_and_indentations_give_the_own_contact_radius(geometry, body, factor):
    impact = rs.Impact(RUBBER, geometry, mass=0.005, velocity=2.0)
    slow, fast = solve_by_scipy(impact, 1e-6), rs.solve(impact)
    assert slow.restitution_coefficient == pytest.approx(fast.restitution_coefficient, rel=1e-5)
    assert slow.max_contact_radius == approx(fast.max_contact_radius, 1e-5)
    for depth, force in ((rs.triangle(1e-3, 1e-3), None), (None, rs.triangle(10.0, 1e-3))):
        result = rs.indent(RUBBER, geometry, depth=depth, force=force)
        same = rs.indent(RUBBER, body, depth=depth, force=force)
        assert result.max_force == pytest.approx(same.max_force, rel=1e-7)
        assert result.max_contact_radius == approx(factor * same.max_contact_radius, 1e-7)
        times = np.linspace(0.01, 0.99, 12) * same.contact_end_time
        radii = [item.sample(times).contact_radius.values for item in (result, same)]
        assert radii[0] == approx(factor * radii[1], 1e-6)


@CASES
def test_bounces_and_contact_laws(geometry, body, factor):
    impact = rs.Impact(RUBBER, geometry, mass=0.005, velocity=2.0, external_force=0.05)
    exact = rs.solve(replace(impact, profile=body)).restitution_coefficient
    bounces = rs.bounces(impact, gravity=10.0, max_bounces=2)
    assert bounces.restitution_coefficient[0] == pytest.approx(exact, rel=1e-8)
    law = rs.contact_law(impact)
    assert law.modulus == impact.reduced_modulus
    assert law.max_depth <= geometry.max_depth


def test_sweeps_give_the_own_contact_radius():
    impact = rs.Impact(RUBBER, Widened(0.01), mass=0.005, velocity=2.0)
    outputs = ["max_contact_radius", "max_indentation_depth", "max_pressure"]
    swept = rs.sweep(impact, {"radius": [0.01, 0.02], "velocity": [1.0, 3.0]}, outputs=outputs)
    expected = 1.5 * np.sqrt(swept.radius * swept.max_indentation_depth)
    assert swept.max_contact_radius.values == pytest.approx(expected.values, rel=1e-8)
    assert np.isnan(swept.max_pressure).all()


@CASES
def test_what_needs_a_half_space_is_refused(geometry, body, factor):
    impact = rs.Impact(RUBBER, geometry, mass=0.005, velocity=2.0)
    result = rs.solve(impact)
    refused = [lambda: result.surface_displacement(0.0, 1e-4), lambda: rs.solve(impact, "elements")]
    # The pressure of an ellipsoid is that of a parabola on stretched axes.
    if geometry.image is None:
        assert np.isnan(result.max_pressure)
        assert np.isnan(rs.solve(replace(impact, velocity=np.array([1.0, 2.0]))).outputs["max_pressure"]).all()
        refused.append(lambda: result.pressure(0.0, 1e-4))
    for call in refused:
        error = in_one_line(call)
        assert error.field == "profile"
        assert geometry.obstacle in error.rule


def test_geometries_are_equal_if_their_parameters_are():
    geometry = Widened(0.01)
    assert geometry == Widened(0.01)
    assert hash(geometry) == hash(Widened(0.01))
    assert geometry != Widened(0.01, power=False)
    assert geometry != BALL
    with pytest.raises(rs.InputError):
        Widened(-1.0)


STEEL = Material(8e10, 1.6e11)
RUBBER = Material(PronySeries(1e6, [1e7], [1e-4]), math.inf, window=(1e-6, 1.0))
GEL = FractionalMaterial(springpot(1e4, 0.3), bulk=math.inf)


def test_compliances_of_both_bodies_add():
    soft = Material(3.0, math.inf)
    # An incompressible spring G is E* = 4 G; two equal ones in series are half as stiff.
    assert Contact(soft, Parabola(0.01)).reduced_modulus == PronySeries(12.0)
    assert Contact(soft, Parabola(0.01), soft).reduced_modulus == PronySeries(6.0)


@pytest.mark.parametrize(
    ("materials", "window"),
    [((STEEL, None), None), ((STEEL, RUBBER), (1e-6, 1.0)), ((GEL.within((1e-8, 1e-2)), RUBBER), (1e-6, 1e-2))],
)
def test_window_is_the_common_window_of_both_materials(materials, window):
    assert Contact(materials[0], Parabola(0.01), materials[1]).window == window


@pytest.mark.parametrize(
    ("arguments", "field"),
    [
        ((1e6, Parabola(0.01)), "material"),
        ((STEEL, 0.01), "profile"),
        ((STEEL, Parabola(0.01), "steel"), "counter_material"),
        ((GEL, Parabola(0.01)), "material"),
        ((STEEL, Parabola(0.01), GEL), "counter_material"),
    ],
)
def test_other_types_are_refused_by_name(arguments, field):
    error = in_one_line(lambda: Contact(*arguments))
    assert (type(error), error.field) == (InputTypeError, field)


def test_contacts_of_equal_parts_are_equal_and_can_be_sent():
    contact = Contact(RUBBER, Parabola(0.01), STEEL)
    assert contact == Contact(RUBBER, Parabola(0.01), STEEL)
    assert hash(contact) == hash(pickle.loads(pickle.dumps(contact)))
    assert contact != Contact(RUBBER, Parabola(0.02), STEEL)
