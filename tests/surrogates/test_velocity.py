"""Surrogates over the velocity against closed forms and against solves that were not used to build them."""

import contextlib
import json
import math
import os
import pickle
from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import Any

import numba
import numpy as np
import pytest
from hypothesis import HealthCheck, assume, given, settings
from hypothesis import strategies as st

import restitution as rs
from cases import BALL, RUBBER
from refusals import in_one_line, named
from restitution.impact.closed_forms import (
    elastic_contact_time,
    elastic_max_force,
    elastic_max_indentation_depth,
    flat_punch_maxwell_restitution,
)
from restitution.surrogates.velocity import content_hash
from strategies import logarithmic, materials

# Many of these bodies exceed the limits of the theory.
pytestmark = pytest.mark.filterwarnings(r"ignore:.*; exceeded in \d+ of")

OUTPUTS = ("restitution_coefficient", "contact_time", "max_force")
EPOXY = rs.Impact(rs.library.get("epoxy"), rs.Parabola(0.01), mass=0.01, velocity=1.0)
# A kink over the velocity: in fast impacts the cone around the flat face is in contact, too.
KINK = replace(BALL, profile=rs.TruncatedCone(1e-4, 1.2))
PRESSED = replace(BALL, external_force=1e-7, counter_material=RUBBER)


@pytest.fixture(scope="module")
def ball() -> rs.Surrogate:
    return rs.surrogate(BALL)


def drawn(low: float, high: float, n: int, seed: int = 7) -> np.ndarray:
    return np.exp(np.random.default_rng(seed).uniform(np.log(low), np.log(high), n))


@pytest.mark.parametrize(
    ("impact", "rtol"), [(BALL, 1e-3), (BALL, 1e-6), (BALL, 1e-10), (EPOXY, 1e-6), (KINK, 1e-4), (PRESSED, 1e-7)]
)
def test_error_is_below_the_stated_error_at_other_points(impact: rs.Impact, rtol: float) -> None:
    curve = rs.surrogate(impact, velocity=(1e-3, 10.0), rtol=rtol)
    v = drawn(1e-3, 10.0, 800)
    exact = rs.solve(replace(impact, velocity=v), rtol=max(1e-5 * rtol, 1e-12))
    for name in OUTPUTS:
        truth = getattr(exact, name)
        floor = 1e-3 if name == "restitution_coefficient" else 0.0
        error = np.abs(getattr(curve, name)(v) - truth) / np.maximum(truth, floor)
        assert error.max() <= rtol
        assert curve.error[name] <= rtol
        # The stated error also holds at points that were not used to measure it.
        assert error.max() <= curve.error[name]


def test_shallow_impacts_with_a_tabulated_profile_are_accurate() -> None:
    curve = rs.surrogate(KINK, velocity=(1e-3, 100.0), rtol=1e-10)
    for v in (1e-3, 3e-3, 0.02):
        alone = rs.solve(replace(KINK, velocity=v), rtol=1e-12)
        for name in OUTPUTS:
            assert getattr(curve, name)(v) == pytest.approx(getattr(alone, name), rel=1e-10)


def test_elastic_body_agrees_with_hertz() -> None:
    steel = rs.elastic(shear_modulus=8e10, poisson_ratio=0.3)
    curve = rs.surrogate(rs.Impact(steel, rs.Parabola(0.01), mass=0.03, velocity=1.0), velocity=(1e-3, 1.0))
    v = drawn(1e-3, 1.0, 50)
    modulus = 2.0 * 8e10 / (1.0 - 0.3)
    depth = elastic_max_indentation_depth(modulus, 0.1, 0.03, v)
    assert curve(v) == pytest.approx(1.0, abs=1e-10)
    assert curve(v).max() <= 1.0
    assert curve.contact_time(v) == pytest.approx(elastic_contact_time(depth, v), rel=1e-9)
    assert curve.max_force(v) == pytest.approx(elastic_max_force(depth, 0.03, v), rel=1e-9)


def test_flat_punch_on_a_maxwell_liquid_has_a_constant_e() -> None:
    liquid = rs.PronySeries(0.0, [1e5], [0.5])
    impact = rs.Impact(rs.Material(liquid, math.inf), rs.FlatPunch(0.01), mass=0.1, velocity=1.0)
    stiffness = 2.0 * 4.0 * 1e5 * 0.01
    ratio = 1.0 / (2.0 * math.sqrt(stiffness / 0.1) * 0.5)
    assert rs.surrogate(impact)(drawn(1e-3, 10.0, 50)) == pytest.approx(
        flat_punch_maxwell_restitution(ratio), rel=1e-7
    )


def test_values_have_the_shape_of_the_velocities(ball: rs.Surrogate) -> None:
    assert isinstance(ball(1), float)
    assert isinstance(ball.max_force(np.float64(0.5)), float)
    grid = np.array([[0.1, 1.0, 2.0], [1e-3, 10.0, 5.0]])
    for function in (ball, ball.contact_time, ball.max_force):
        assert function(grid).shape == (2, 3)
        assert function(grid)[0, 1] == function(1.0)
        assert function(grid.T)[1, 0] == function(1.0)
    assert ball([]).shape == (0,)


@pytest.mark.parametrize(
    ("velocity", "place"), [(9.99e-4, (9.99e-4,)), ([1.0, 10.1], (1, 10.1)), (math.nan, (math.nan,)), (-1.0, (-1.0,))]
)
def test_nothing_is_extrapolated(ball: rs.Surrogate, velocity: object, place: tuple[float, ...]) -> None:
    for function in (ball, ball.contact_time, ball.max_force):
        assert named(partial(function, velocity)) == ("velocity", *place)


def test_compiled_forms_in_a_loop_and_in_a_callback_for_c_give_the_same_bits(ball: rs.Surrogate) -> None:
    e, time = ball.compiled(), ball.compiled("contact_time")

    @numba.njit
    def loop(v):
        out = np.empty(v.size)
        for n in range(v.size):
            out[n] = time(v[n])
        return out

    called = numba.cfunc("float64(float64)")(lambda v: e(v) + 0.0 * time(v)).ctypes
    v = drawn(1e-3, 10.0, 1000)
    assert np.array_equal(loop(v), ball.contact_time(v))
    assert list(map(called, v[:20].tolist())) == ball(v[:20]).tolist()
    assert math.isnan(called(11.0))
    assert math.isnan(called(9e-4))
    assert named(lambda: ball.compiled("depth")) == ("output", "depth")


def test_threads_and_other_processes_give_the_same_values(ball: rs.Surrogate) -> None:
    v = drawn(1e-3, 10.0, 1000)
    fresh = replace(ball)
    with ThreadPoolExecutor(4) as pool:
        rows = list(pool.map(lambda _: fresh(v), range(8)))
    assert all(np.array_equal(row, ball(v)) for row in [*rows, pickle.loads(pickle.dumps(ball))(v)])


def test_results_do_not_depend_on_the_number_of_workers() -> None:
    alone, shared = (rs.surrogate(BALL, (0.1, 1.0), 1e-8, workers=n) for n in (1, 2))
    assert np.array_equal(alone.pieces.coefficients, shared.pieces.coefficients)
    assert alone.error == shared.error


def test_progress_ends_with_all_pieces() -> None:
    reports = []
    curve = rs.surrogate(KINK, (1e-3, 10.0), 1e-4, progress=lambda *report: reports.append(report))
    n = curve.pieces.edges.size - 1
    assert n > 1
    assert reports[-1] == (n, n)


def test_the_velocity_of_the_given_impact_does_not_matter(ball: rs.Surrogate) -> None:
    other = rs.surrogate(replace(BALL, velocity=[3.0, 4.0]))
    assert np.array_equal(other.pieces.coefficients, ball.pieces.coefficients)
    assert other.problem == ball.problem
    assert ball.problem["mass"] == 0.005
    assert ball.problem["profile"] == {"type": "Parabola", "radius": 0.01}


def test_warnings_of_validity_are_kept(ball: rs.Surrogate) -> None:
    (warning,) = ball.warnings
    assert warning.startswith("small strain: ")
    assert ball.validity["small_strain"].exceeded
    assert rs.surrogate(BALL, (1e-3, 1e-2)).warnings == []


def test_a_range_with_captured_bodies_is_refused() -> None:
    message = str(in_one_line(lambda: rs.surrogate(replace(BALL, external_force=0.05))))
    assert message.startswith("velocity = [0.001, 10.0] m/s: must be a range in which the body separates; at ")
    assert "CAPTURED" in message
    low, high = (float(word) for word in message.split("separates from ")[1].removesuffix(" m/s").split(" to "))
    assert rs.surrogate(replace(BALL, external_force=0.05), (low * 1.01, high))(1.0) > 0.0


def test_a_liquid_into_which_the_body_sinks_is_refused() -> None:
    honey = rs.Material(rs.PronySeries(0.0, [1e5], [1e-4]), math.inf)
    with pytest.raises(ValueError, match="SINKS_IN"):
        rs.surrogate(rs.Impact(honey, rs.FlatPunch(0.01), mass=0.1, velocity=1.0))


def test_an_unattainable_tolerance_is_reported_with_numbers(monkeypatch: pytest.MonkeyPatch) -> None:
    from restitution.surrogates import boxes

    monkeypatch.setattr(boxes, "OF_PIECES", boxes.OF_PIECES._replace(deepest=0))
    with pytest.raises(rs.SolverError) as caught:
        rs.surrogate(KINK, (1e-3, 10.0), 1e-6)
    assert caught.value.status is rs.Status.NOT_ACCURATE
    message = str(caught.value)
    assert "rtol = 1e-06" in message
    velocity = float(message.split("at velocity = ")[1].split(" m/s")[0])
    error = float(message.split("off by ")[1].split(",")[0])
    assert 1e-3 <= velocity <= 10.0
    assert 1e-6 < error < 1.0


def test_an_indentation_beyond_the_table_is_reported() -> None:
    tip = rs.Tabulated([0.0, 1e-4, 2e-4], [0.0, 1e-6, 4e-6])
    with pytest.raises(rs.SolverError, match=r"TOO_DEEP: .* \(at velocity = .* m/s\)"):
        rs.surrogate(replace(BALL, profile=tip), velocity=(1.0, 2.0))


@pytest.mark.parametrize(
    ("arguments", "expected"),
    [
        ((BALL, 1.0), ("velocity", 1.0)),
        ((BALL, (0.0, 1.0)), ("velocity", 0, 0.0)),
        ((BALL, (0.1, math.inf)), ("velocity", 1, math.inf)),
        ((BALL, (0.1, 1.0), 1e-11), ("rtol", 1e-11)),
        ((RUBBER,), ("impact", RUBBER)),
    ],
)
def test_bad_input_is_one_line(arguments: tuple, expected: tuple) -> None:
    assert named(lambda: rs.surrogate(*arguments)) == expected


def test_a_surrogate_is_of_one_impact_in_a_range() -> None:
    for arguments, message in (
        ((BALL, (0.1, 0.1)), "velocity = (0.1, 0.1): must be the lowest and the highest, which differ"),
        ((replace(BALL, mass=[1.0, 2.0]),), "impact: must be a single impact, but has shape (2,) beside its velocity"),
    ):
        assert str(in_one_line(partial(rs.surrogate, *arguments))) == message


def test_the_file_is_plain_json(ball: rs.Surrogate, tmp_path: Path) -> None:
    content = json.loads(ball.save(tmp_path / "ball.json").read_text())
    assert content["format_version"] == 2
    assert content["units"] == {
        "velocity": "m/s",
        "restitution_coefficient": "1",
        "contact_time": "s",
        "max_force": "N",
    }
    edges = content["log_velocity_edges"]
    for v in drawn(1e-3, 10.0, 30):
        x = math.log(v)
        n = max(k for k in range(len(edges) - 1) if edges[k] <= x or k == 0)
        t = (2.0 * x - edges[n] - edges[n + 1]) / (edges[n + 1] - edges[n])
        for name in OUTPUTS:
            series = np.polynomial.chebyshev.chebval(t, content["chebyshev_coefficients_of_log"][name][n])
            assert math.exp(series) == pytest.approx(getattr(ball, name)(v), rel=1e-13)


def test_a_failed_write_keeps_the_old_file(
    ball: rs.Surrogate, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    path = tmp_path / "ball.json"
    path.write_text("before")

    def full(*_: object, **__: object) -> None:
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(os, "replace", full)
    with pytest.raises(OSError, match="No space left"):
        ball.save(path)
    assert path.read_text() == "before"
    assert [entry.name for entry in tmp_path.iterdir()] == ["ball.json"]


def rehashed(content: dict[str, Any]) -> dict[str, Any]:
    """Content with its correct hash, as another program may write it."""
    return content | {"sha256": content_hash({key: value for key, value in content.items() if key != "sha256"})}


@pytest.mark.parametrize(
    ("change", "field"),
    [
        ({"format": "something"}, ""),
        ({"format_version": 1}, "format_version"),
        ({"format_version": True}, "format_version"),
        ({"velocity": None}, "velocity"),
        ({"velocity": [2.0, 1.0]}, "velocity"),
        # An edited range must not lead to extrapolation.
        ({"velocity": [1e-3, 1000.0]}, "velocity"),
        ({"log_velocity_edges": [0.0, 0.3, 1.0, 2.0]}, "log_velocity_edges"),
        ({"log_velocity_edges": [math.log(1e-3), 0.0, math.log(10.0)]}, "chebyshev_coefficients_of_log"),
        ({"chebyshev_coefficients_of_log": {}}, ""),
        ({"chebyshev_coefficients_of_log": {name: [[]] for name in OUTPUTS}}, "chebyshev_coefficients_of_log"),
        ({"chebyshev_coefficients_of_log": {name: [[[1.0]]] for name in OUTPUTS}}, "chebyshev_coefficients_of_log"),
        ({"error": None}, ""),
        ({"error": dict.fromkeys(OUTPUTS, -1.0)}, "error.restitution_coefficient"),
        ({"error": dict.fromkeys(OUTPUTS, "1e999")}, "error.restitution_coefficient"),
        ({"rtol": -5}, "rtol"),
        ({"validity": 3}, ""),
        ({"problem": 3}, ""),
    ],
)
def test_other_files_are_refused_in_one_line(
    ball: rs.Surrogate, tmp_path: Path, change: dict[str, object], field: str
) -> None:
    path = ball.save(tmp_path / "ball.json")
    path.write_text(json.dumps(rehashed(json.loads(path.read_text()) | change)))
    error = in_one_line(lambda: rs.Surrogate.load(path))
    assert (error.field, error.where) == (field, str(path))


def test_every_edited_digit_is_noticed(ball: rs.Surrogate, tmp_path: Path) -> None:
    path = ball.save(tmp_path / "ball.json")
    text = path.read_text()
    places = [n for n, letter in enumerate(text) if letter.isdigit()]
    for n in np.random.default_rng(1).choice(places, 300):
        edited = text[:n] + str((int(text[n]) + 1) % 10) + text[n + 1 :]
        # A leading 9 becomes a leading 0, which is no JSON.
        with contextlib.suppress(json.JSONDecodeError):
            if json.loads(edited) == json.loads(text):
                continue  # a seventeenth digit without effect
        path.write_text(edited)
        with pytest.raises(rs.InputError):
            rs.Surrogate.load(path)
    # The hash does not depend on the layout of the file.
    path.write_text(json.dumps(dict(reversed(json.loads(text).items()))))
    assert rs.Surrogate.load(path)(0.5) == ball(0.5)


def test_files_that_are_not_json(tmp_path: Path) -> None:
    path = tmp_path / "x.json"
    for text in ("{", "[1, 2]", "", "[" * 100_000):
        path.write_text(text)
        assert in_one_line(lambda: rs.Surrogate.load(path)).where == str(path)
    with pytest.raises(FileNotFoundError):
        rs.Surrogate.load(tmp_path / "absent.json")


@settings(max_examples=25, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(
    material=materials(max_branches=4, times=(1e-4, 1e2), moduli=(1e4, 1e8)),
    radius=logarithmic(1e-3, 1e-1),
    mass=logarithmic(1e-4, 1.0),
    low=logarithmic(1e-3, 1.0),
    ratio=logarithmic(2.0, 100.0),
    rtol=st.sampled_from([1e-3, 1e-6]),
)
def test_any_material_and_its_file(
    tmp_path: Path, material: rs.Material, radius: float, mass: float, low: float, ratio: float, rtol: float
) -> None:
    impact = rs.Impact(material, rs.Parabola(radius), mass=mass, velocity=1.0)
    assume(float(impact.reduced_modulus.instantaneous_modulus) > 0.0)
    curve = rs.surrogate(impact, (low, low * ratio), rtol)
    v = np.append(drawn(low, low * ratio, 30), curve.velocity)
    e, time, force = curve(v), curve.contact_time(v), curve.max_force(v)
    assert np.all((e > 0.0) & (e <= 1.0))
    order = np.argsort(v)
    # For any material a faster impact is shorter and has a larger force.
    assert np.all(np.diff(time[order]) < 2.0 * rtol * time.max())
    assert np.all(np.diff(force[order]) > -2.0 * rtol * force.max())
    again = rs.Surrogate.load(curve.save(tmp_path / "any.json"))
    assert (again.velocity, again.rtol, again.error) == (curve.velocity, curve.rtol, curve.error)
    assert (again.warnings, again.problem) == (curve.warnings, curve.problem)
    for name, values in zip(OUTPUTS, (e, time, force), strict=True):
        assert np.array_equal(getattr(again, name)(v), values)
    assert again.save(tmp_path / "again.json").read_bytes() == (tmp_path / "any.json").read_bytes()


def test_a_single_piece_takes_few_solves_and_its_error_includes_that_of_the_solver(monkeypatch):
    from restitution.surrogates import build

    counts, solved = [], build._solved

    def counted(impacts, speeds, accuracy, workers):
        counts.append(speeds.size)
        return solved(impacts, speeds, accuracy, workers)

    monkeypatch.setattr(build, "_solved", counted)
    curve = rs.surrogate(BALL, (0.1, 1.0), 1e-8)
    assert sum(counts) <= 100
    # The tolerance of the solves is 1e-12, and the error of the largest force is up to 14 times as large.
    assert min(curve.error.values()) >= 1.4e-11
