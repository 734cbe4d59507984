"""Arrays of materials and geometries: each row has the numbers of a single impact, whatever stands beside it."""

import math
from typing import Any

import numpy as np
import pytest

import restitution as rs

# Large velocities exceed the limits of the theory on purpose.
pytestmark = pytest.mark.filterwarnings("ignore::restitution.errors.RestitutionWarning")
NAMES = ("restitution_coefficient", "contact_time", "max_indentation_depth", "max_force", "max_contact_radius")
RNG = np.random.default_rng()


def sizes(*shape: int) -> Any:
    return RNG.uniform(0.005, 0.02, shape)


def angles(*shape: int) -> Any:
    return RNG.uniform(1.2, 1.5, shape)


def exponents(*shape: int) -> Any:
    return RNG.choice([1.0, 1.5, 2.0, 2.7], shape)


GEOMETRIES = {
    "sphere": lambda: rs.Sphere(RNG.choice(sizes(2), 4)),
    "power law": lambda: rs.PowerLaw(exponents(4), RNG.uniform(20.0, 80.0)),
    "cone": lambda: rs.Cone(angles(4)),
    "truncated cone": lambda: rs.TruncatedCone(0.1 * sizes(4), angles(3, 1)),
    "flat-ended parabola": lambda: rs.FlatEndedParabola(sizes(1), 0.1 * sizes(4)),
    "flat punch": lambda: rs.FlatPunch(sizes(4)),
    "ellipsoid": lambda: rs.Ellipsoid(sizes(4), sizes(3, 1)),
    "pyramid": lambda: rs.Pyramid(angles(4)),
    "parabola on layers": lambda: rs.Layer(rs.Parabola(sizes(4)), sizes(3, 1)),
    "sphere on layers": lambda: rs.Layer(rs.Sphere(RNG.choice(sizes(2), 4)), sizes(3, 1), base="frictionless"),
    "punch on layers": lambda: rs.Layer(rs.FlatPunch(sizes(4)), sizes(3, 1)),
    "power law on layers": lambda: rs.Layer(rs.PowerLaw(exponents(4), 50.0), sizes(3, 1)),
}
# NumPy rounds powers of arrays and of single numbers in different ways. The tables of many thicknesses under a sphere
# are made together.
ROUNDING = {"power law": 1e-12, "power law on layers": 1e-12, "sphere on layers": 1e-9}


def material(*shape: int) -> rs.Material:
    return rs.standard_solid(1e6, RNG.uniform(5e6, 2e7, shape), RNG.uniform(5e2, 2e3), poisson_ratio=0.45)


@pytest.mark.parametrize("kind", GEOMETRIES)
@pytest.mark.parametrize("rows", [(), (3, 1), (4,)])
def test_rows_of_geometries_and_materials_are_single_impacts(kind, rows):
    impact = rs.Impact(material(*rows), GEOMETRIES[kind](), mass=0.005, velocity=RNG.uniform(0.1, 0.5, (3, 1)))
    result = rs.solve(impact)
    rtol = ROUNDING.get(kind, 0.0)
    for n in RNG.choice(math.prod(impact.shape), 3, replace=False):
        row = impact.take(np.array(n))
        assert row.shape == ()
        alone = rs.solve(row)
        for name in NAMES:
            rows_of = np.ravel(getattr(result, name))
            np.testing.assert_allclose(rows_of[n], getattr(alone, name), rtol=rtol, atol=0.0, err_msg=name)


@pytest.mark.parametrize("kind", GEOMETRIES)
def test_arrays_of_geometries_have_the_methods_of_single_ones(kind):
    geometry = GEOMETRIES[kind]().between(material(), None)
    depths = RNG.uniform(1e-5, 1e-3, (3, 4))
    shape = np.broadcast_shapes(geometry.rows, depths.shape)
    for name in ("stiffness_radius", "force_integral_at_depth", "contact_radius"):
        together = np.broadcast_to(getattr(geometry, name)(depths), shape)
        alone = [getattr(geometry.take(shape, np.array(n)), name)(d) for n, d in enumerate(depths.ravel())]
        np.testing.assert_allclose(together.ravel(), alone, rtol=1e-11, err_msg=name)


@pytest.mark.parametrize("kind", GEOMETRIES)
def test_an_array_without_rows_has_no_results(kind):
    geometry = GEOMETRIES[kind]()
    empty = geometry.changed({name: np.empty((0,)) for name in geometry.numbers})
    assert rs.solve(rs.Impact(material(), empty, 0.005, 1.0)).restitution_coefficient.shape == (0,)
