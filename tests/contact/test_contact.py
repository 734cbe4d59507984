"""A contact holds two materials and a profile and refuses other objects."""

import math
import pickle

import pytest

from refusals import in_one_line
from restitution import FractionalMaterial, Material, Parabola, PronySeries, springpot
from restitution.contact.geometry import Contact
from restitution.errors import InputTypeError

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
    ("given", "field"),
    [
        ((1e6, Parabola(0.01)), "material"),
        ((STEEL, 0.01), "profile"),
        ((STEEL, Parabola(0.01), "steel"), "counter_material"),
        ((GEL, Parabola(0.01)), "material"),
        ((STEEL, Parabola(0.01), GEL), "counter_material"),
    ],
)
def test_other_types_are_refused_by_name(given, field):
    error = in_one_line(lambda: Contact(*given))
    assert (type(error), error.field) == (InputTypeError, field)


def test_contacts_of_equal_parts_are_equal_and_can_be_sent():
    contact = Contact(RUBBER, Parabola(0.01), STEEL)
    assert contact == Contact(RUBBER, Parabola(0.01), STEEL)
    assert hash(contact) == hash(pickle.loads(pickle.dumps(contact)))
    assert contact != Contact(RUBBER, Parabola(0.02), STEEL)
