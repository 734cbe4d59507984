import numpy as np
import pytest
from hypothesis import given

from restitution.material.conversion import series_connection
from restitution.material.prony import PronySeries
from strategies import prony_series

pytestmark = pytest.mark.plain


def test_two_liquids_and_a_liquid_on_a_solid_stay_liquid():
    liquid, other = PronySeries(0.0, [1.0], [1.0]), PronySeries(0.0, [2.0], [5.0])
    assert series_connection(liquid, other).is_liquid
    assert series_connection(liquid, PronySeries(1.0, [1.0], [2.0])).is_liquid
    # Fluidities add: 1/eta = 1/(1*1) + 1/(2*5).
    assert series_connection(liquid, other).flow_viscosity == pytest.approx(10.0 / 11.0, rel=1e-15, abs=0)


def test_springs_and_dashpots():
    assert series_connection(PronySeries(3.0), PronySeries(6.0)) == PronySeries(2.0)
    two = series_connection(PronySeries(0.0, parallel_viscosity=3.0), PronySeries(0.0, parallel_viscosity=6.0))
    assert two == PronySeries(0.0, parallel_viscosity=2.0)
    assert series_connection(PronySeries(3.0), PronySeries(0.0)) == PronySeries(0.0)


@given(prony_series(max_branches=8), prony_series(max_branches=8))
def test_creep_compliances_add(first, second):
    t = np.geomspace(1e-8, 1e8, 33)
    total = first.creep_compliance(t) + second.creep_compliance(t)
    connected = series_connection(first, second)
    assert connected.creep_compliance(t) == pytest.approx(total, rel=1e-12, abs=0)


@given(prony_series(liquid=None, viscosity=None), prony_series(liquid=None, viscosity=None))
def test_no_more_branches_than_roots(first, second):
    connected = series_connection(first, second)
    assert connected.n_branches <= first.n_branches + second.n_branches + 1
