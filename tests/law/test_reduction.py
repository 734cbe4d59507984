"""Laws with fewer terms keep the restitution coefficient to the error that they state."""

import math

import numpy as np
import pytest

from refusals import in_one_line, named
from restitution import ContactLaw, Impact, Material, Parabola, PronySeries, contact_law, springpot
from restitution.impact.batch import Batch
from stepping import collide

VELOCITIES = np.array([0.3, 1.0, 3.0])


def law_of(series: PronySeries, velocity=VELOCITIES) -> ContactLaw:
    """Law of a ball of 5 g on an incompressible half-space, a contact of about 5 ms."""
    return contact_law(Impact(Material(series, math.inf), Parabola(0.01), 0.005, velocity))


def assert_stated_error_holds(full: ContactLaw, short: ContactLaw) -> None:
    exact = Batch.from_impact(full.impact).solve(1e-8)
    for velocity, e, time in zip(VELOCITIES, exact["restitution_coefficient"], exact["contact_time"], strict=True):
        simulated = collide(short, 0.005, velocity, time / 800).restitution_coefficient
        # Velocity Verlet with 800 steps adds its own error.
        assert abs(simulated - e) <= short.restitution_error + 1e-4


def test_more_terms_are_nearer():
    full = law_of(springpot(2e4, 0.3).prony((1e-7, 1e1), rtol=1e-4).series)
    assert full.modulus.n_branches > 15
    assert full.restitution_error == 0.0
    laws = [full.reduced(terms) for terms in (1, 2, 3, 4)]
    errors = [law.restitution_error for law in laws]
    assert [law.modulus.n_branches for law in laws] == [1, 2, 3, 4]
    assert errors == sorted(errors, reverse=True)
    assert errors[1] < 1e-3
    assert errors[3] < 1e-4
    for law in laws:
        assert_stated_error_holds(full, law)


def test_terms_far_from_the_contact_become_springs_and_dashpots():
    # The middle term alone relaxes within the contact of some 5 ms.
    full = law_of(PronySeries(1e5, [1e5, 2e5, 1e5], [1e-7, 2e-3, 1e4]))
    short = full.reduced(1)
    assert short.restitution_error < 1e-3
    assert short.modulus.equilibrium_modulus == pytest.approx(4.0 * 2e5, rel=0.02)
    assert short.modulus.relaxation_times[0] == pytest.approx(2e-3, rel=0.02)


def test_a_dashpot_stays():
    full = law_of(PronySeries(1e5, [1e5, 2e5, 1e5], [1e-3, 2e-3, 4e-3], parallel_viscosity=50.0))
    short = full.reduced(2)
    assert short.modulus.n_branches == 1
    assert short.modulus.parallel_viscosity == pytest.approx(200.0, rel=0.05)
    assert_stated_error_holds(full, short)
    assert full.reduced(1).modulus.n_branches == 0


def test_a_law_of_few_terms_is_not_changed():
    law = law_of(PronySeries(1e5, [1e5, 2e5], [1e-3, 2e-3]))
    assert law.reduced(2) is law
    assert law.reduced(1).restitution_error > 0.0


def test_refusals():
    law = law_of(PronySeries(1e5, [1e5, 2e5], [1e-3, 2e-3]))
    assert named(lambda: law.reduced(0)) == ("terms", 0)
    sinks = Impact(Material(PronySeries(1e5, [1e5] * 3, [1e-3, 2e-3, 4e-3]), math.inf), Parabola(0.01), 0.005, 1e-6)
    heavy = Impact(sinks.material, sinks.profile, 0.005, 1e-6, external_force=10.0)
    assert in_one_line(lambda: contact_law(heavy).reduced(1)).field == "impact"
