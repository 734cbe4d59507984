from pathlib import Path

import numpy as np
import pytest

from restitution.impact.solve import standard_solid_restitution
from restitution.paper import computation as module
from restitution.paper.computation import Computation
from restitution.paper.inputs import draw_inputs

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
    assert Computation(seed=1).solve(table["nu"], inputs) == pytest.approx(
        table["restitution"], rel=1e-9, abs=1e-12
    )


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
        "velocity": "m s-1",
        "equilibrium_modulus": "Pa",
        "branch_modulus": "Pa",
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
