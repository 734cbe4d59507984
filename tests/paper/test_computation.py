from pathlib import Path

import numpy as np
import pytest

from restitution.impact.solve import standard_solid_restitution
from restitution.paper import computation as module
from restitution.paper.computation import RANGES, Computation, draw_inputs, glassy_poisson_ratio

AXES = {"poisson_ratio": [0.0, 0.45, 0.5], "p2": [0.01, 0.1], "p3": [0.1, 1.0, 10.0]}


def test_points_by_random_si_inputs_equal_the_dimensionless_call() -> None:
    e = Computation(seed=3).dataset("some", 1, AXES)["restitution_coefficient"].values
    direct = standard_solid_restitution(*np.meshgrid(*AXES.values(), indexing="ij"))
    # Either solve of a point may be off by the tolerance.
    assert e == pytest.approx(direct, rel=2e-9)


def test_points_match_the_reference_table(shared_reference: Path) -> None:
    table = np.genfromtxt(shared_reference / "standard_solid.csv", delimiter=",", names=True)
    inputs = draw_inputs(table["p2"], table["p3"], np.random.default_rng(1))
    # The table is good to 12 digits.
    assert Computation(seed=1).solve(table["nu"], inputs) == pytest.approx(table["restitution"], rel=1e-9, abs=1e-12)


def test_every_variable_says_its_unit_and_meaning() -> None:
    dataset = Computation(seed=3).dataset("some", 1, {**AXES, "draw": [0, 1]})
    units = {name: dataset[name].attrs["units"] for name in dataset.variables}
    assert units == {
        "poisson_ratio": "1",
        "p2": "1",
        "p3": "1",
        "draw": "1",
        "restitution_coefficient": "1",
        "mass": "kg",
        "radius": "m",
        "velocity": "m/s",
        "equilibrium_modulus": "Pa",
        "branch_modulus": "Pa",
        "glassy_poisson_ratio": "1",
        "viscosity": "Pa s",
    }
    assert all(dataset[name].attrs["long_name"] for name in dataset.variables)


def test_attributes_say_how_it_was_made() -> None:
    attributes = Computation(seed=3, rtol=1e-8).dataset("some", 1, AXES).attrs
    assert attributes["title"] == "some"
    assert (attributes["seed"], attributes["rtol"]) == (3, 1e-8)
    assert attributes["version"]


def test_streams_and_seeds_draw_differently_but_agree_in_e() -> None:
    first, stream, seed = (
        Computation(seed=seed).dataset("some", number, AXES) for seed, number in ((3, 1), (3, 2), (4, 1))
    )
    for other in (stream, seed):
        assert not np.any(np.isclose(first["mass"], other["mass"]))
        assert first["restitution_coefficient"].values == pytest.approx(
            other["restitution_coefficient"].values, rel=1e-9
        )


def test_blocks_and_workers_change_nothing_and_all_work_is_reported(monkeypatch: pytest.MonkeyPatch) -> None:
    whole = Computation(seed=3).dataset("some", 1, AXES)
    monkeypatch.setattr(module, "_BLOCK", 7)
    steps: list[int] = []
    pieces = Computation(seed=3, workers=2, advance=steps.append).dataset("some", 1, AXES)
    assert pieces.identical(whole)
    assert steps == [7, 7, 4]


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


def test_glassy_poisson_ratios_of_the_paper() -> None:
    # By hand: nu = 0.49, p2 = 1e-3: K = 49.67 Ginf, G0 = 1001 Ginf, (149 - 2002)/(298 + 2002).
    assert glassy_poisson_ratio(0.49, 1e-3) == pytest.approx((149.0 - 2002.0) / (298.0 + 2002.0), rel=1e-12)
    assert glassy_poisson_ratio(0.5, 1e-3) == 0.5
    assert glassy_poisson_ratio(-1.0, 0.1) == -1.0
