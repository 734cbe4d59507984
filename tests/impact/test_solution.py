"""One solve serves the result, its history, energies and fields; results can be pickled."""

import multiprocessing
import pickle

import numpy as np
import pytest

import restitution as rs
from cases import RUBBER
from restitution.errors import InputTypeError
from restitution.kernel import impact as kernel

# Many of these bodies exceed the limits of the theory.
pytestmark = pytest.mark.filterwarnings(r"ignore:.*; exceeded in \d+ of")

BALL = rs.Impact(RUBBER, rs.Parabola(0.01), mass=0.005, velocity=1.0, external_force=0.05)
SPHERE = rs.Impact(RUBBER, rs.Sphere(0.01), mass=0.005, velocity=1.0)


@pytest.mark.parametrize("impact", [BALL, SPHERE], ids=["power law", "table"])
def test_an_impact_is_solved_once(impact: rs.Impact, monkeypatch: pytest.MonkeyPatch) -> None:
    calls = []
    solve_block = kernel.solve_block

    def counted(*arguments: object) -> object:
        calls.append(arguments)
        return solve_block(*arguments)

    monkeypatch.setattr(kernel, "solve_block", counted)
    result = rs.solve(impact)
    _ = result.history, result.energy, result.zero_overlap_time, result.to_dict()
    result.sample([0.5 * result.contact_time])
    result.pressure(0.0, 0.5 * result.contact_time)
    result.surface_displacement(0.0, 2.0 * result.contact_time)
    assert len(calls) == 1


@pytest.mark.parametrize("rtol", [1e-4, 1e-6, 1e-9, 1e-11])
def test_errors_of_history_energy_and_pressure_follow_the_tolerance(rtol: float) -> None:
    coarse, fine = rs.solve(BALL, rtol=rtol), rs.solve(BALL, rtol=1e-12)
    times = np.linspace(0.02, 0.98, 49) * fine.contact_time
    result, expected = coarse.sample(times), fine.sample(times)
    for name, values in expected.data_vars.items():
        error = np.abs(result[name].values - values.values).max() / np.abs(values.values).max()
        assert error < 1000.0 * rtol, name
    r = np.linspace(0.0, 0.3, 5)[:, None] * fine.max_contact_radius
    pressures = fine.pressure(r, times[4:-4:4])
    assert np.abs(coarse.pressure(r, times[4:-4:4]) - pressures).max() < 1000.0 * rtol * pressures.max()
    assert abs(coarse.energy.residual) < 10.0 * rtol


@pytest.mark.parametrize(
    ("impact", "method"),
    [
        (BALL, "exact"),
        (SPHERE, "exact"),
        (rs.Impact(RUBBER, rs.Parabola(0.01), 0.005, [0.5, 1.0]), "exact"),
        ([BALL, SPHERE], "exact"),
        (BALL, "elements"),
    ],
    ids=["single", "table", "array", "list", "elements"],
)
def test_results_can_be_pickled(impact: rs.Impact, method: str) -> None:
    result = rs.solve(impact, method, n_elements=50 if method == "elements" else None)
    for item in (result, pickle.loads(pickle.dumps(result))):
        sent = pickle.loads(pickle.dumps(item))
        assert np.array_equal(sent.restitution_coefficient, result.restitution_coefficient)
        assert np.array_equal(sent.energy.dissipated, result.energy.dissipated, equal_nan=True)
        if not np.shape(result.status):
            assert sent.history.identical(result.history)
    if method == "exact" and not np.shape(result.status):
        t = 0.4 * result.contact_time
        assert pickle.loads(pickle.dumps(result)).pressure(0.0, t) == result.pressure(0.0, t)


@pytest.mark.slow
def test_impacts_are_solved_by_other_processes() -> None:
    with multiprocessing.get_context("spawn").Pool(2) as pool:
        results = pool.map(rs.solve, [BALL, SPHERE])
    for result, impact in zip(results, [BALL, SPHERE], strict=True):
        assert result.restitution_coefficient == rs.solve(impact).restitution_coefficient
        assert result.history.force.max() > 0.0


class _Case:
    impact = BALL


@pytest.mark.parametrize(
    ("options", "advice"),
    [
        ("CASE.toml", "read_case"),
        (_Case(), "take its attribute impact"),
        ({"mass": 1}, "not a dict"),
        (3, "or a list of them"),
        ([BALL, 3], "must be an Impact"),
    ],
)
def test_other_objects_are_refused_with_advice(options: object, advice: str) -> None:
    with pytest.raises(InputTypeError, match=advice) as caught:
        rs.solve(options)  # type: ignore[arg-type]
    assert caught.value.field == "impact"


def test_a_gain_of_energy_by_a_coarse_method_is_noted() -> None:
    elastic = rs.Impact(rs.Material(1e6, 1e9), rs.Parabola(0.01), mass=0.005, velocity=1.0)
    coarse = rs.solve(elastic, "elements", n_elements=20)
    assert coarse.restitution_coefficient > 1.0
    assert any("gains energy" in note for note in coarse.notes)
