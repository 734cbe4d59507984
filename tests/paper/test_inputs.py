import numpy as np
import pytest

from restitution.impact.scaling import dimensionless_groups
from restitution.paper.inputs import RANGES, draw_inputs, impacts


def test_drawn_inputs_have_the_groups_of_equation_11() -> None:
    p2, p3 = np.meshgrid(np.logspace(-3, 1, 7), np.logspace(-2, 2, 9))
    mass, radius, velocity, modulus, branch, viscosity = draw_inputs(p2, p3, np.random.default_rng(5))
    assert modulus / branch == pytest.approx(p2, rel=1e-14)
    assert viscosity * (velocity * radius / (mass**2 * modulus**3)) ** 0.2 == pytest.approx(p3, rel=1e-14)


def test_every_free_input_spans_its_decades_independently() -> None:
    inputs = draw_inputs(np.full(4000, 0.1), 1.0, np.random.default_rng(5))
    free = np.log10([inputs.mass, inputs.radius, inputs.velocity, inputs.equilibrium_modulus])
    for values, (low, high) in zip(free, RANGES.values(), strict=True):
        span = np.log10(high / low)
        assert span >= 3.0
        assert values.min() == pytest.approx(np.log10(low), abs=0.01 * span)
        assert values.max() == pytest.approx(np.log10(high), abs=0.01 * span)
    # Independent draws correlate by about 1/sqrt(4000) = 0.016; five times that does not happen by chance.
    correlation = np.corrcoef(free) - np.eye(4)
    assert np.abs(correlation).max() < 0.08


def test_draws_follow_the_generator_alone() -> None:
    first, same, other = (draw_inputs([0.1, 1.0], 1.0, np.random.default_rng(seed)) for seed in (1, 1, 2))
    assert np.array_equal(first, same)
    assert not np.any(np.isclose(first.mass, other.mass))


@pytest.mark.parametrize("nu", [-1.0, 0.3, 0.499])
def test_impacts_carry_their_inputs_and_groups(nu: float) -> None:
    inputs = draw_inputs([[0.01, 0.1, 1.0]], [[0.5], [2.0]], np.random.default_rng(5))
    made = impacts(nu, inputs)
    assert [impact.mass for impact in made] == inputs.mass.ravel().tolist()
    assert [impact.velocity for impact in made] == inputs.velocity.ravel().tolist()
    groups = np.array([dimensionless_groups(impact) for impact in made])
    expected = [(nu, p2, p3) for p3 in (0.5, 2.0) for p2 in (0.01, 0.1, 1.0)]
    assert groups == pytest.approx(np.array(expected), rel=1e-12)


def test_half_is_the_incompressible_limit() -> None:
    (impact,) = impacts(0.5, draw_inputs([0.1], 1.0, np.random.default_rng(5)))
    assert impact.material.is_incompressible
