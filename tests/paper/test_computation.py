"""Computed points of the paper: values, random inputs, attributes."""

import warnings
from pathlib import Path

import numpy as np
import pytest

import restitution as rs
from restitution.impact.scaling import viscosity_unit
from restitution.impact.status import SolverError, Status
from restitution.paper import figures
from restitution.paper.claims import compute_collapse
from restitution.paper.figures import BODIES, Computation, instantaneous_poisson_ratio

AXES = {"poisson_ratio": [0.0, 0.45, 0.5], "p2": [0.01, 0.1], "p3": [0.1, 1.0, 10.0]}


def test_points_match_the_reference_table(shared_reference: Path) -> None:
    table = np.genfromtxt(shared_reference / "standard_solid.csv", delimiter=",", names=True)
    axes = {"poisson_ratio": table["nu"], "p2": table["p2"], "p3": table["p3"]}
    axes = {name: np.unique(values) for name, values in axes.items()}
    e = Computation(seed=1).sweep("some", axes)["restitution_coefficient"]
    for nu, p2, p3, expected in zip(*(table[name] for name in ("nu", "p2", "p3", "restitution")), strict=True):
        # The table has 12 digits.
        restitution = float(e.sel(poisson_ratio=nu, p2=p2, p3=p3))
        assert restitution == pytest.approx(expected, rel=1e-9, abs=1e-12)


def test_every_variable_has_its_unit_and_meaning() -> None:
    dataset = compute_collapse(Computation(seed=3), 3, 2)
    units = {name: dataset[name].attrs["units"] for name in dataset.variables}
    assert units == {
        "poisson_ratio": "1",
        "p2": "1",
        "p3": "1",
        "restitution_coefficient": "1",
        "mass": "kg",
        "radius": "m",
        "velocity": "m/s",
        "equilibrium_modulus": "Pa",
        "instantaneous_poisson_ratio": "1",
        "viscosity": "Pa s",
        "spread": "1",
        "relative_spread": "1",
    }
    assert all(dataset[name].attrs["long_name"] for name in dataset.variables)


def test_attributes_describe_the_computation() -> None:
    attributes = Computation(seed=3, rtol=1e-8).sweep("some", AXES).attrs
    assert attributes["title"] == "some"
    assert (attributes["seed"], attributes["rtol"]) == (3, 1e-8)
    assert attributes["version"]


def test_other_seeds_give_other_bodies_of_the_same_restitution() -> None:
    first, same, other = (compute_collapse(Computation(seed=seed), 3, 4) for seed in (3, 3, 4))
    assert first.identical(same)
    assert not np.any(np.isclose(first["mass"], other["mass"]))
    e, e_other = (dataset["restitution_coefficient"].values for dataset in (first, other))
    assert e == pytest.approx(e_other, rel=1e-9)


def test_viscosities_of_the_draws_have_the_group_of_equation_11() -> None:
    dataset = compute_collapse(Computation(seed=3), 3, 4)
    m, r, v, g = (dataset[name] for name in BODIES)
    p3 = dataset["viscosity"] * (v * r / (m**2 * g**3)) ** 0.2
    assert (p3 / dataset["p3"]).values == pytest.approx(1.0, rel=1e-12)
    assert viscosity_unit(8.0, 2.0, 4.0, 16.0) == pytest.approx((4.0 * 512.0 / 64.0) ** 0.2, rel=1e-14)


def test_workers_do_not_matter_and_progress_is_complete() -> None:
    steps: list[int] = []
    whole = Computation(seed=3, workers=1).sweep("some", AXES)
    assert Computation(seed=3, workers=2, advance=steps.append).sweep("some", AXES).identical(whole)
    assert sum(steps) == 18
    assert min(steps) > 0


def test_random_inputs_span_their_decades() -> None:
    drawn = rs.Samples(64, BODIES, rng=5).columns("draw", 0, 64)
    free = np.log10([drawn[name] for name in BODIES])
    # The narrowest distribution has three decades.
    assert np.all(np.ptp(free, axis=1) > 2.8)
    # The correlation of 64 independent draws is about 1/sqrt(64) = 0.125.
    assert np.abs(np.corrcoef(free) - np.eye(4)).max() < 0.4


@pytest.mark.filterwarnings(r"ignore:.*; exceeded in \d+ of")
def test_failed_impacts_are_errors_and_doubtful_random_bodies_are_not(monkeypatch: pytest.MonkeyPatch) -> None:
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        compute_collapse(Computation(seed=3), 3, 2)
    table = rs.sweep(None, AXES)
    table["status"][1, 1, 1] = Status.TOO_MANY_STEPS
    monkeypatch.setattr(figures, "sweep", lambda *_, **__: table)
    with pytest.raises(SolverError, match=r"TOO_MANY_STEPS.*some: impact 10"):
        Computation(seed=3).sweep("some", AXES)


def test_instantaneous_poisson_ratios_of_the_paper() -> None:
    # By hand: nu = 0.49, p2 = 1e-3: K = 49.67 Ginf, G0 = 1001 Ginf, (149 - 2002)/(298 + 2002).
    assert instantaneous_poisson_ratio(0.49, 1e-3) == pytest.approx((149.0 - 2002.0) / (298.0 + 2002.0), rel=1e-12)
    assert instantaneous_poisson_ratio(0.5, 1e-3) == 0.5
    assert instantaneous_poisson_ratio(-1.0, 0.1) == -1.0
