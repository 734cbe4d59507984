"""The numbers and curves of the page are those of the package, at inputs drawn at random."""

import random
import re
import tomllib
from collections.abc import Callable
from dataclasses import replace
from itertools import count
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

import random_messages as fuzz
import restitution as rs
from checkout import EXAMPLES
from refusals import in_one_line
from restitution.explorer import answers
from restitution.explorer import inputs as sliders
from restitution.explorer.downloads import download
from restitution.explorer.inputs import MOST_TERMS, PRESETS, inputs, nested, settled
from restitution.explorer.states import of_case, of_file, of_impact
from restitution.material.models import material_models
from restitution.parallel import ended_by
from restitution.quantities import BUDGET

MODELS = [option.value for option in inputs()["material.model"].options]
PROFILES = [option.value for option in inputs()["profile.type"].options]


TIME_LIMIT = answers.TIME_LIMIT


@pytest.fixture(autouse=True)
def patient(monkeypatch: pytest.MonkeyPatch) -> None:
    """Let curves be fine on a slow machine too."""
    monkeypatch.setattr(answers, "TIME_LIMIT", 1e3)


def drawn(seed: int, **fixed: Any) -> dict[str, Any]:
    """A state on the sliders, within a few decades of the defaults."""
    rng, state = random.Random(seed), {}
    for key, control in inputs().items():
        if control.options:
            state[key] = rng.choice(control.options).value
        elif control.slider and control.slider.logarithmic and control.default > 0.0:
            state[key] = control.default * 3.0 ** rng.uniform(-1.0, 1.0)
        elif control.slider:
            low, high = (max(control.slider.low, 0.0), min(control.slider.high, control.default + 1.0))
            state[key] = rng.uniform(low, high)
    state |= {f"material.shear.{name}": [10.0 ** (sign * k) for k in range(3)] for name, sign in _SERIES}
    state["material.temperature"] = rng.uniform(290.0, 300.0)
    return state | {"impact.external_force": 0.0, "material.library": "polyisobutylene"} | fixed


_SERIES = (("branch_moduli", 1), ("relaxation_times", -1))


def case_file(state: dict[str, Any], folder: Path, what: str = "case") -> Path:
    answer = download({"what": what, "state": state})
    path = folder / answer["name"]
    path.write_text(answer["text"], encoding="utf-8")
    return path


@pytest.mark.parametrize("model", MODELS)
def test_numbers_are_those_of_solve_for_every_material(model, tmp_path):
    state = drawn(1, **{"entry": "constants", "material.model": model, "profile.type": "parabola"})
    answer = answers.impact(state)
    expected: Any = rs.read_case(case_file(state, tmp_path)).solve()
    numbers = answer["numbers"]
    assert numbers["restitution_coefficient"] == pytest.approx(expected.restitution_coefficient, rel=1e-12)
    for name in ("contact_time", "max_force", "max_indentation_depth", "max_contact_radius"):
        value = getattr(expected, name)
        assert numbers[name] == (pytest.approx(value, rel=1e-12) if np.isfinite(value) else None)
    assert [numbers[name] for name in BUDGET] == answers.numbers_of(list(expected.energy))
    assert numbers["instantaneous_poisson_ratio"] == expected.impact.material.instantaneous_poisson_ratio
    assert [row["kind"] for row in answer["validity"] if row["state"] == "doubtful"] == [
        check.kind for check in expected.validity if check.exceeded
    ]
    if expected.status != rs.Status.SEPARATED:
        assert answer["curves"]["history"] is None
        return
    history = expected.sample(answer["curves"]["history"]["time"])
    for name, values in answer["curves"]["history"].items():
        np.testing.assert_array_equal(values, history[name].values)


@pytest.mark.parametrize("profile", PROFILES)
def test_numbers_are_those_of_solve_for_every_profile(profile, tmp_path):
    state = drawn(2, **{"entry": "constants", "material.model": "standard_solid", "profile.type": profile})
    expected: Any = rs.read_case(case_file(state, tmp_path)).solve()
    answer = answers.impact(state)
    assert answer["numbers"]["restitution_coefficient"] == expected.restitution_coefficient
    shape = answer["curves"]["shape"]
    if profile in ("ellipsoid", "pyramid"):
        return
    heights = expected.impact.profile.shape(shape["radius"])
    np.testing.assert_array_equal(shape["height"], heights)


def test_the_papers_numbers_give_the_papers_restitution():
    rng = random.Random(3)
    for _ in range(20):
        nu, p2, p3 = rng.uniform(-0.9, 0.5), 10.0 ** rng.uniform(-3, 1), 10.0 ** rng.uniform(-2, 2)
        state = drawn(rng.randrange(1000), entry="groups", **{"groups.nu": nu, "groups.p2": p2, "groups.p3": p3})
        numbers = answers.impact(state)["numbers"]
        assert numbers["restitution_coefficient"] == pytest.approx(
            rs.standard_solid_restitution(nu, p2, p3), rel=1e-8, abs=2e-12
        )
        assert [numbers[name] for name in ("nu", "p2", "p3")] == pytest.approx([nu, p2, p3], rel=1e-9)


@pytest.mark.parametrize("state", [{}, {"material.model": "fractional_zener"}, {"profile.type": "truncated_cone"}])
def test_the_curve_over_velocity_is_that_of_solve(state):
    curve = answers.velocity(state)["curves"]["velocity"]
    velocities = curve["velocity"]
    assert velocities.size == 61
    chosen = [0, velocities.size // 2, velocities.size - 1]
    # A fractional material has a relative error of 1e-4 in a curve; all others have the tolerance of the solver.
    rtol = 1e-3 if "material.model" in state else 2e-6
    for n in chosen:
        # A fractional material of its own for this contact.
        expected = rs.solve(answers.case_of(state | {"impact.velocity": float(velocities[n])}).impact)
        assert curve["restitution_coefficient"][n] == pytest.approx(expected.restitution_coefficient, rel=rtol)
        assert curve["contact_time"][n] == pytest.approx(expected.contact_time, rel=rtol)
        # The share of energy in waves, the strain and the others are compared with their limits.
        assert bool(curve["doubtful"][n]) == bool(expected.validity.warnings)


def ticking(monkeypatch: pytest.MonkeyPatch, step: float) -> None:
    """Let each look at the clock take some time [s]."""
    looks = count()
    monkeypatch.setattr(answers, "TIME_LIMIT", TIME_LIMIT)
    monkeypatch.setattr(answers, "time", SimpleNamespace(thread_time=lambda: step * next(looks)))


# In 70 ms: the case and two points, which take a step each, and as many others as possible.
@pytest.mark.parametrize(("step", "points"), [(1e-3, 61), (9e-3, 6), (30e-3, 2)])
def test_curves_over_velocity_get_fewer_points_when_they_take_long(monkeypatch, step, points):
    fine = answers.velocity({})["curves"]["velocity"]
    ticking(monkeypatch, step)
    coarse = answers.velocity({})["curves"]["velocity"]
    assert len(coarse["velocity"]) == points
    places = np.searchsorted(fine["velocity"], coarse["velocity"])
    np.testing.assert_array_equal(fine["velocity"][places], coarse["velocity"])
    np.testing.assert_allclose(fine["restitution_coefficient"][places], coarse["restitution_coefficient"], rtol=1e-6)


# Four rows, and more of a step each in 50 ms.
@pytest.mark.parametrize(("step", "rows"), [(1e-3, 25), (12e-3, 8), (60e-3, 4)])
def test_surfaces_get_fewer_rows_when_they_take_long(monkeypatch, step, rows):
    fine = answers.surface({})["curves"]["surface"]
    ticking(monkeypatch, step)
    coarse = answers.surface({})["curves"]["surface"]
    assert len(coarse["time"]) == len(coarse["displacement"]) == rows
    places = np.searchsorted(fine["time"], coarse["time"])
    np.testing.assert_array_equal(np.array(fine["displacement"])[places], coarse["displacement"])


# Bounces of a step each in 50 ms.
@pytest.mark.parametrize(("step", "bounces"), [(12e-3, 5), (60e-3, 1)])
def test_series_of_bounces_end_when_they_take_long(monkeypatch, step, bounces):
    state = {"material.viscosity": 300.0}
    whole = answers.bounces(state)
    ticking(monkeypatch, step)
    head = answers.bounces(state)
    assert head["numbers"]["n_bounces"] == bounces
    assert head["status"]["name"] == "stopped"
    assert head["status"]["message"].endswith("or 0.05 s of work; the body would bounce on")
    np.testing.assert_array_equal(head["curves"]["bounces"]["height"], whole["curves"]["bounces"]["height"][:bounces])


@pytest.mark.parametrize(
    "material",
    [{"material.model": "library", "material.temperature": 320.0}, {"material.model": "fractional_maxwell"}],
)
def test_indentations_of_many_terms_have_a_tolerance_of_1e_4(material, tmp_path):
    from restitution.case.indentation import read_indentation

    state = material | {"prescribed": "force"}
    expected = read_indentation(case_file(state, tmp_path, "indentation")).solve()
    answer = answers.indentation(state)["numbers"]
    for name in ("max_force", "max_indentation_depth", "max_contact_radius", "work"):
        # A fractional material is approximated to 1e-4 as well.
        assert answer[name] == pytest.approx(getattr(expected, name), rel=2e-4, abs=0.0)


def test_indentations_of_too_many_elements_are_refused(monkeypatch):
    monkeypatch.setattr(answers, "_ELEMENTS", 20)
    with pytest.raises(rs.InputError, match="needs over 2 elements"):
        answers.indentation({})


def test_tapping_is_that_of_the_package(tmp_path):
    from restitution.case.oscillation import read_tapping

    state = PRESETS["tapping"][1] | {"tapping.nearest": 0.6}
    answer = answers.tapping(state)
    # The free amplitude is 20 nm.
    distances = 20e-9 * np.linspace(1.0, 0.6, 21)
    material = rs.standard_solid(1e6, 4e6, 40.0, poisson_ratio=0.5)
    cantilever = {"spring_constant": 1.0, "quality_factor": 50.0, "frequency": 5e4, "free_amplitude": 20e-9}
    expected = rs.tap(material, rs.Parabola(10e-9), distances, **cantilever)
    curve = answer["curves"]["tapping"]
    assert curve["distance"] == pytest.approx(distances, rel=1e-12)
    steady = np.isfinite(curve["amplitude"])
    assert steady.sum() >= 19
    assert bool(answer["warnings"]) == (not steady.all())
    for name, scale in (("amplitude", 20e-9), ("phase", 1.0), ("max_force", expected.max_force.max())):
        # The page has a tolerance of 1e-5.
        np.testing.assert_allclose(curve[name][steady], getattr(expected, name)[steady], rtol=0, atol=1e-3 * scale)
    assert answer["numbers"]["phase"] == curve["phase"][-1]
    path = case_file(state, tmp_path, "tapping")
    assert read_tapping(path).options["distance"] == pytest.approx(distances, rel=1e-12)
    again, _ = of_file(path)
    keys = [key for key in settled(state) if key.startswith("tapping.") and key != "tapping.beam_quality_factors"]
    assert [settled(again)[key] for key in keys] == pytest.approx([settled(state)[key] for key in keys], rel=1e-12)
    names: dict[str, Any] = {}
    exec(download({"what": "tapping python", "state": state})["text"], names)
    assert names["result"].phase == pytest.approx(expected.phase, abs=1e-9)


LAYERS = {"bonded": ({}, "bonded"), "free": ({"indentation.base": "frictionless"}, "frictionless")}


@pytest.mark.parametrize("name", LAYERS)
def test_tips_press_on_layers_too(name, tmp_path):
    choice, base = LAYERS[name]
    layer = {"sample": "layer", "indentation.thickness": 1.5e-6} | choice
    state = PRESETS["gel"][1] | layer
    gel = rs.standard_solid(300.0, 1200.0, 300.0, poisson_ratio=0.5)
    tip = rs.Layer(rs.Parabola(2.5e-6), 1.5e-6, base)
    expected = rs.indent(gel, tip, depth=rs.triangle(5e-7, 1.0))
    answer = answers.indentation(state)
    assert answer["numbers"]["max_force"] == pytest.approx(expected.max_force, rel=1e-5)
    assert expected.max_force > 1.2 * answers.indentation(state | {"sample": "half_space"})["numbers"]["max_force"]
    again, _ = of_file(case_file(state, tmp_path, "indentation"))
    assert {key: settled(again)[key] for key in settled(layer) if key in layer} == layer
    names: dict[str, Any] = {}
    exec(download({"what": "indentation python", "state": state})["text"], names)
    assert names["result"].max_force == pytest.approx(expected.max_force, rel=1e-9)
    # The target of an impact is another one.
    assert (
        answers.indentation(state | {"sample": "half_space", "target": "layer"})["numbers"]
        == (answers.indentation(state | {"sample": "half_space"})["numbers"])
    )


def test_a_layer_whose_poisson_ratio_relaxes_has_a_warning_or_no_taps():
    layer = {"sample": "layer", "indentation.thickness": 1e-6, "material.poisson_ratio": 0.4}
    lines = answers.indentation(PRESETS["gel"][1] | layer)["warnings"]
    assert sum(line.startswith("separability: ") for line in lines) == 1
    assert in_one_line(lambda: answers.tapping(PRESETS["tapping"][1] | layer)).field == "profile"


TAPS: dict[str, tuple[dict[str, Any], Callable[[], dict[str, Any]]]] = {
    "van der Waals": ({"tapping.hamaker": 1e-19}, lambda: {"hamaker": 1e-19}),
    "modes": (
        {"tapping.beam_quality_factors": [150.0, 250.0]},
        lambda: {"modes": rs.beam_modes(spring_constant=1.0, frequency=5e4, quality_factors=[150.0, 250.0])},
    ),
}


@pytest.mark.parametrize("name", TAPS)
def test_taps_with_further_forces_and_modes_are_those_of_the_package(name, tmp_path):
    choice, options = TAPS[name]
    state = PRESETS["tapping"][1] | {"tapping.nearest": 0.8} | choice
    distances = 20e-9 * np.linspace(1.0, 0.8, 21)
    material = rs.standard_solid(1e6, 4e6, 40.0, poisson_ratio=0.5)
    cantilever = {"spring_constant": 1.0, "quality_factor": 50.0, "frequency": 5e4, "free_amplitude": 20e-9}
    expected = rs.tap(material, rs.Parabola(10e-9), distances, **cantilever, **options())
    curve = answers.tapping(state)["curves"]["tapping"]
    assert np.isfinite(curve["amplitude"]).all()
    np.testing.assert_allclose(curve["amplitude"], expected.amplitude, rtol=0, atol=1e-3 * 20e-9)
    swings = [values for column, values in curve.items() if column.startswith("mode_swing_")]
    assert len(swings) == expected.mode_swing.shape[1] - 1
    for swing, exact in zip(swings, expected.mode_swing.T[1:], strict=True):
        np.testing.assert_allclose(swing, exact, rtol=0, atol=1e-2 * exact.max())
    again, _ = of_file(case_file(state, tmp_path, "tapping"))
    assert {key: settled(again)[key] for key in choice} == choice
    names: dict[str, Any] = {}
    exec(download({"what": "tapping python", "state": state})["text"], names)
    assert names["result"].amplitude == pytest.approx(expected.amplitude, rel=1e-9)


def test_the_van_der_waals_force_needs_a_round_tip_on_a_half_space():
    for other in ({"profile.type": "cone"}, {"sample": "layer"}):
        assert "tapping.hamaker" not in settled({"tapping.hamaker": 1e-19} | other)
    field = in_one_line(lambda: answers.tapping({"tapping.beam_quality_factors": [0.1]})).field
    assert "beam_quality_factors" in str(field)


def test_tapping_ends_within_a_distance():
    checks: list[int] = []

    def end():
        checks.append(1)
        if len(checks) == 5:
            raise TimeoutError

    # The first distance has more than five taps.
    with pytest.raises(TimeoutError), ended_by(end):
        answers.tapping(PRESETS["tapping"][1])
    assert len(checks) == 5


def test_the_surface_is_that_of_the_result():
    curve = answers.surface({})["curves"]["surface"]
    result: Any = rs.solve(answers.case_of({}).impact)
    radius, time = curve["radius"], curve["time"]
    displacement = result.surface_displacement(radius[None, :], time[:, None])
    scale = result.max_indentation_depth
    np.testing.assert_allclose(curve["displacement"], displacement, rtol=0, atol=1e-6 * scale)
    inside = time <= result.contact_time
    # At the centre the surface touches the body.
    depth = result.sample(time[inside]).indentation_depth
    np.testing.assert_allclose(np.array(curve["displacement"])[inside, 0], depth, atol=1e-6 * scale)


def test_bounces_are_those_of_the_package():
    state = {"material.viscosity": 300.0, "impact.gravity": 1.62, "impact.external_force": 1.0}
    answer = answers.bounces(state)
    impact = answers.case_of(state | {"impact.external_force": 0.0}).impact
    count = answer["numbers"]["n_bounces"]
    expected = rs.bounces(impact, gravity=1.62, max_bounces=count, min_height=0.0)
    for name in ("touch_time", "height", "restitution_coefficient"):
        np.testing.assert_allclose(answer["curves"]["bounces"][name], getattr(expected, name), rtol=1e-4)
    flight = answer["curves"]["flight"]
    assert np.all(np.diff(flight["time"]) >= 0.0)
    # The greatest heights between the touches are those of the table.
    points = flight["height"].size // count
    flights = flight["height"][points:].reshape(-1, points).max(axis=1)
    np.testing.assert_allclose(flights, expected.height[: flights.size], rtol=1e-2)


def test_bounces_on_one_spot_are_those_of_the_package():
    state = {"material.viscosity": 300.0, "bounces.spot": "same"}
    answer = answers.bounces(state)
    impact = answers.case_of(state).impact
    count = min(answer["numbers"]["n_bounces"], 5)
    expected = rs.bounces(impact, max_bounces=count, min_height=0.0, same_spot=True)
    result = answer["curves"]["bounces"]["restitution_coefficient"][:count]
    np.testing.assert_allclose(result, expected.restitution_coefficient, rtol=1e-4)
    assert (
        answer["curves"]["bounces"]["restitution_coefficient"][1]
        != answers.bounces(state | {"bounces.spot": "fresh"})["curves"]["bounces"]["restitution_coefficient"][1]
    )


@pytest.mark.parametrize("prescribed", ["depth", "force"])
@pytest.mark.parametrize("shape", [option.value for option in inputs()["indentation.shape"].options])
def test_indentations_are_those_of_the_package(prescribed, shape, tmp_path):
    from restitution.case.indentation import read_indentation

    state = PRESETS["gel"][1] | {"prescribed": prescribed, "indentation.shape": shape}
    answer = answers.indentation(state)
    expected = read_indentation(case_file(state, tmp_path, "indentation")).solve()
    for name in ("max_force", "max_indentation_depth", "work"):
        assert answer["numbers"][name] == pytest.approx(getattr(expected, name), rel=1e-5, abs=0.0)
    history = expected.sample(answer["curves"]["history"]["time"])
    scale = float(history["force"].max())
    np.testing.assert_allclose(answer["curves"]["history"]["force"], history["force"].values, atol=1e-5 * scale)


@pytest.mark.parametrize("seed", range(12))
def test_a_state_is_a_case_and_back(seed, tmp_path):
    state = drawn(seed)
    path = case_file(state, tmp_path)
    again = of_case(rs.read_case(path))
    assert (
        download({"what": "case", "state": again})["text"].splitlines().sort() == path.read_text().splitlines().sort()
    )
    expected = answers.impact(state)["numbers"]
    assert answers.impact(again)["numbers"]["restitution_coefficient"] == pytest.approx(
        expected["restitution_coefficient"], rel=1e-9
    )
    # Without the model: as series.
    impact = answers.case_of(state).impact
    series = of_impact(impact)
    assert answers.impact(series)["numbers"]["restitution_coefficient"] == pytest.approx(
        expected["restitution_coefficient"], rel=1e-9
    )


@pytest.mark.parametrize("seed", range(12))
def test_the_python_text_gives_the_same_impact(seed, capsys):
    state = drawn(seed)
    names: dict[str, Any] = {}
    exec(download({"what": "python", "state": state})["text"], names)
    assert names["result"].restitution_coefficient == pytest.approx(
        answers.impact(state)["numbers"]["restitution_coefficient"], rel=1e-9
    )
    assert "restitution coefficient" in capsys.readouterr().out


@pytest.mark.parametrize("name", PRESETS)
def test_presets_can_be_solved(name):
    state = PRESETS[name][1]
    assert answers.impact(state)["status"]["name"] == "SEPARATED"
    assert answers.indentation(state)["numbers"]["max_force"] > 0.0


EXAMPLE_FILES = {
    name: preset["file"]
    for name, preset in tomllib.loads(Path(sliders.__file__).with_name("sliders.toml").read_text())["presets"].items()
    if "file" in preset
}


@pytest.mark.parametrize("name", EXAMPLE_FILES)
def test_examples_of_the_page_are_the_case_files(name):
    state, title = of_file(EXAMPLES / EXAMPLE_FILES[name])
    words, preset = PRESETS[name]
    assert title is not None
    assert words.lower() == title.lower()
    expected, result = settled(state), settled(preset)
    assert expected.keys() == result.keys()
    for key, value in expected.items():
        assert result[key] == (pytest.approx(value, rel=1e-12) if isinstance(value, float) else value)


def test_symbols_are_letters():
    shown = [control.describe()["symbol"] for control in inputs().values() if control.quantity is not None]
    assert [symbol for symbol in shown if any(len(word) > 3 for word in re.findall("[a-z]+", symbol))] == []


def test_the_first_page_has_no_warning():
    assert [row["kind"] for row in answers.impact({})["validity"] if row["state"] == "doubtful"] == []


def test_inputs_depend_on_earlier_ones_and_lie_on_their_sliders():
    seen: set[str] = set()
    for key, control in inputs().items():
        for when in (control.when, *(option.when for option in control.options)):
            assert when.keys() <= seen
            assert all(set(values) <= {option.value for option in inputs()[of].options} for of, values in when.items())
        seen.add(key)
        assert control.check(control.default) == control.default
        if control.slider is not None:
            least, most = control.ends
            assert least <= control.slider.low < control.slider.high <= most
            assert control.quantity is not None
            control.quantity.check(control.slider.low)
            control.quantity.check(control.slider.high)


def test_long_lists_are_refused():
    for key in ("material.shear.branch_moduli", "material.bulk.relaxation_times"):
        assert inputs()[key].check([1.0] * MOST_TERMS) == [1.0] * MOST_TERMS
        with pytest.raises(rs.InputError, match=f"must be a list of at most {MOST_TERMS} numbers"):
            answers.impact({key: [1.0] * (MOST_TERMS + 1)})


def test_every_model_and_profile_of_the_package_can_be_chosen():
    assert {*material_models()} - set(MODELS) == {"generalised_maxwell"}
    assert {"parabola", "sphere", "cone", "flat_punch", "power_law"} <= set(PROFILES)


def test_a_choice_that_is_not_available_is_replaced():
    values = settled({"entry": "groups", "material.model": "maxwell", "profile.type": "cone", "bulk": "series"})
    assert (values["material.model"], values["profile.type"], values["bulk"]) == (
        "standard_solid",
        "parabola",
        "poisson_ratio",
    )
    assert "material.viscosity" not in values
    assert settled({"material.model": "maxwell", "bulk": "poisson_ratio"})["bulk"] == "bulk_modulus"
    assert nested(values)["groups"]["p2"] == inputs()["groups.p2"].default


def test_cases_that_the_page_cannot_show_are_refused_in_one_line(tmp_path):
    text = case_file({}, tmp_path).read_text()
    path = tmp_path / "two.toml"
    for key, section in (
        ("counter_body", "mass = 1.0"),
        ("counter_material", "model = 'elastic'\nyoungs_modulus = 1e9\npoisson_ratio = 0.3"),
    ):  # fmt: skip
        path.write_text(f"{text}\n[{key}]\n{section}\n")
        assert in_one_line(lambda: of_case(rs.read_case(path))).field == key
    impact = answers.case_of({}).impact
    with pytest.raises(rs.InputError, match="single impact"):
        of_impact(replace(impact, velocity=[1.0, 2.0]))
    tip = rs.Tabulated(np.array([0.0, 1e-3, 2e-3]), np.array([0.0, 1e-4, 4e-4]))
    with pytest.raises(rs.InputError, match="Tabulated"):
        of_impact(replace(impact, profile=tip))


@pytest.mark.parametrize("tapping", [False, pytest.param(True, marks=pytest.mark.slow)])
def test_random_states_are_solved_or_refused_in_one_line(tapping, monkeypatch):
    rng = random.Random(5)
    from restitution.explorer.server import BUG, Request, answer

    # A curve of tapping may take seconds; ten taps at each distance have the same ways to end.
    monkeypatch.setattr(answers, "_TAPS", 10)
    monkeypatch.setattr(answers, "_FEWEST_TAPS", 10)
    for number in range(60):
        request = fuzz.request(rng, number)
        if (request["kind"] == "tapping") != tapping:
            continue
        text = answer(Request(number, request["kind"], request))
        assert BUG not in text


@pytest.mark.parametrize("share", [0.1, 0.4, 0.7])
def test_the_section_of_an_ellipsoid_is_along_its_long_axis(share):
    from scipy.integrate import quad

    state = {"profile.type": "ellipsoid", "profile.radius_1": 0.004, "profile.radius_2": 0.03}
    result: Any = rs.solve(answers.case_of(state).impact)
    shape = answers.impact(state)["curves"]["shape"]
    largest = result.impact.profile.semi_axes(result.max_contact_radius)[0]
    assert shape["radius"][-1] == pytest.approx(3.0 * largest)
    assert shape["height"] == pytest.approx(np.square(shape["radius"]) / 0.06)
    radius, displacement = answers.surface_section(result)  # pyright: ignore[reportGeneralTypeIssues]
    t = share * result.contact_time
    depth, mean = (float(result.sample(np.array([t]))[name][0]) for name in ("indentation_depth", "contact_radius"))
    a, b = result.impact.profile.semi_axes(mean)
    assert shape["semi_axis"] * mean == pytest.approx(a)
    # 200 punches.
    tolerance = depth / 200
    inside = radius < a
    assert inside.sum() > 3
    assert displacement(t)[inside] == pytest.approx(depth - radius[inside] ** 2 / 0.06, abs=tolerance)
    if t > result.turning_time:
        return

    # Hertz: Johnson, Contact Mechanics (1985), equation 4.25, with x^2 = (a^2 + s)(1 - u) as the lower end.
    def hertz(x: float) -> float:
        def integrand(s: float) -> float:
            return (1.0 - x**2 / (a**2 + s)) / np.sqrt((a**2 + s) * (b**2 + s) * s)

        low = max(x**2 - a**2, 0.0)
        # s = low + q^2 removes the root at s = 0.
        return quad(lambda q: 2.0 * q * integrand(low + q**2), 0.0, np.inf, epsabs=0.0, epsrel=1e-8)[0]

    expected = [depth * hertz(x) / hertz(0.0) for x in radius[~inside]]
    assert displacement(t)[~inside] == pytest.approx(expected, abs=tolerance)


def test_the_surface_under_a_circular_ellipsoid_is_that_under_a_parabola():
    round_body = {"profile.type": "ellipsoid", "profile.radius_1": 0.01, "profile.radius_2": 0.01}
    curves = [answers.surface(state)["curves"]["surface"] for state in (round_body, {"body.radius": 0.01})]
    # Each has as many rows as it has time for.
    common = np.intersect1d(curves[0]["time"], curves[1]["time"])
    answer, expected = (np.array(curve["displacement"])[np.isin(curve["time"], common)] for curve in curves)
    np.testing.assert_allclose(answer, expected, rtol=0, atol=np.max(expected) / 200)


@pytest.mark.parametrize("sides", ["3", "4", "6"])
def test_the_section_of_a_pyramid_is_across_two_faces(sides):
    state = {"profile.type": "pyramid", "profile.face_angle": 1.3, "profile.sides": sides}
    shape = answers.impact(state)["curves"]["shape"]
    result: Any = rs.solve(answers.case_of(state).impact)
    # The plane of the section holds the normals of two faces of four and six, and is at 30 deg to two of three.
    slope = (np.sqrt(0.75) if sides == "3" else 1.0) / np.tan(1.3)
    assert shape["height"] == pytest.approx(slope * np.array(shape["radius"]))
    assert shape["height"][-1] == pytest.approx(3.0 * result.max_indentation_depth)
    assert shape["semi_axis"] is None
    assert answers.surface(state)["curves"]["surface"] is None


@pytest.mark.parametrize("sides", [3, 4, 6])
def test_a_pyramid_keeps_its_faces(sides, tmp_path):
    material = rs.standard_solid(1e6, 1e7, 1e3, poisson_ratio=0.49)
    impact = rs.Impact(material, rs.Pyramid(1.2, sides=sides), mass=0.005, velocity=1.0)
    expected = rs.solve(impact).max_force
    state = of_impact(impact)
    assert answers.impact(state)["numbers"]["max_force"] == pytest.approx(expected, rel=1e-12)
    case = rs.read_case(case_file(state, tmp_path))
    assert of_case(case)["profile.sides"] == sides
    names: dict[str, Any] = {}
    exec(download({"what": "python", "state": state})["text"], names)
    for solved in (case.solve(), names["result"]):
        assert solved.max_force == pytest.approx(expected, rel=1e-12)


TARGETS: list[tuple[dict[str, Any], Any]] = [
    ({"target": "layer", "profile.base": "frictionless", "profile.thickness": 0.003},
     lambda soft: rs.Impact(soft, rs.Layer(rs.Parabola(0.01), 0.003, "frictionless"), mass=0.005, velocity=0.3)),
    ({"target": "plate", "impact.impedance": 20.0},
     lambda soft: rs.Impact(soft, rs.Parabola(0.01), mass=0.005, velocity=0.3, impedance=20.0)),
    ({"partner": "steel"},
     lambda soft: rs.Impact(soft, rs.Parabola(0.01), 0.005, 0.3, counter_material=rs.library.get("steel"))),
    ({"partner": "same", "impact.material_of": "body"},
     lambda soft: rs.Impact(soft, rs.Parabola(0.01), 0.005, 0.3, counter_material=soft, diameters=(2.0, np.inf))),
    ({"target": "ball", "partner": "same", "counter_body.radius": 0.02, "counter_body.mass": 0.01},
     lambda soft: rs.collision(rs.Body(soft, 0.01, 0.005), rs.Body(soft, 0.02, 0.01), 0.3)),
    ({"target": "ball", "counter_body.radius": 0.02, "counter_body.mass": 0.01},
     lambda soft: rs.collision(rs.Body(soft, 0.01, 0.005), rs.Body(None, 0.02, 0.01), 0.3)),
]  # fmt: skip


@pytest.mark.parametrize(("target", "built"), TARGETS)
def test_other_targets_are_those_of_the_package(target, built, tmp_path):
    state = {"body.mass": 0.005, "impact.velocity": 0.3, "body.radius": 0.01, **target}
    soft = rs.standard_solid(1e7, 1e8, 3e3, poisson_ratio=0.49, density=1100.0)
    expected = rs.solve(built(soft)).restitution_coefficient
    answer = answers.impact(state)
    assert answer["numbers"]["restitution_coefficient"] == pytest.approx(expected, rel=1e-12)
    # The three numbers of the paper are those of a rigid ball on a half-space, or of one ball of two materials.
    assert answer["numbers"]["p2"] is None
    path = case_file(state, tmp_path)
    again = settled(of_case(rs.read_case(path)))
    assert {key: again[key] for key in target} == target
    names: dict[str, Any] = {}
    exec(download({"what": "python", "state": state})["text"], names)
    assert names["result"].restitution_coefficient == pytest.approx(expected, rel=1e-9)
    curve = answers.velocity(state)["curves"]["velocity"]
    e = np.interp(np.log(0.3), np.log(curve["velocity"]), curve["restitution_coefficient"])
    # Straight lines between 61 points.
    assert e == pytest.approx(expected, rel=5e-3)
    if state.get("target", "half_space") in ("plate", "ball"):
        assert in_one_line(lambda: answers.bounces(state)).field == "target"
    if state.get("target") == "ball":
        assert in_one_line(lambda: of_impact(built(soft))).field == "impact"
    else:
        result = settled(of_impact(built(soft)))
        assert {key: result[key] for key in target} == target


@pytest.mark.parametrize("held", ["stress", "range"])
def test_adhesion_is_that_of_the_package(held, tmp_path):
    value = {"stress": 1e6, "range": 5e-8}[held]
    state = PRESETS["bead"][1] | {"sticking": held, f"adhesion.{held}": value, "impact.velocity": 0.4}
    soft = rs.standard_solid(1e6, 4e6, 40.0, poisson_ratio=0.5, density=1100.0)
    adhesion = rs.Adhesion(0.05, **{held: value})
    bead = rs.Impact(soft, rs.Parabola(1e-5), 4.6e-12, 0.4, adhesion=adhesion, diameters=(2.0, np.inf))
    # The solver knows e to the tolerance that is asked for.
    expected = rs.solve(bead, rtol=1e-6)
    answer = answers.impact(state)
    numbers, curves = answer["numbers"], answer["curves"]
    assert numbers["restitution_coefficient"] == pytest.approx(expected.restitution_coefficient, rel=2e-4)
    assert numbers["pull_off_force"] == pytest.approx(expected.pull_off_force, rel=1e-2)
    assert curves["shape"]["range"] == pytest.approx(5e-8)
    assert np.all(curves["history"]["zone_radius"] >= curves["history"]["contact_radius"])
    for again in (of_impact(bead), of_case(rs.read_case(case_file(state, tmp_path)))):
        result = settled(again)
        assert [result[key] for key in ("sticking", "adhesion.work", f"adhesion.{held}")] == [held, 0.05, value]
    names: dict[str, Any] = {}
    exec(download({"what": "python", "state": state})["text"], names)
    assert names["result"].restitution_coefficient == pytest.approx(expected.restitution_coefficient, rel=1e-5)
    assert answers.surface(state)["curves"]["surface"] is None
    bounces = answers.bounces(state)
    first = bounces["curves"]["bounces"]["restitution_coefficient"][0]
    assert first == pytest.approx(expected.restitution_coefficient, rel=2e-4)
    assert bounces["status"]["name"] == "stuck"
    assert not bounces["notes"]


def test_a_slow_bead_sticks(monkeypatch):
    state = PRESETS["bead"][1]
    threshold = rs.sticking_velocity(answers.case_of(state).impact, rtol=1e-2)
    slow = answers.impact(state | {"impact.velocity": 0.9 * float(threshold)})
    assert slow["status"]["name"] == "CAPTURED"
    assert slow["numbers"]["restitution_coefficient"] == 0.0
    assert slow["curves"]["history"]["indentation_velocity"][0] == pytest.approx(0.9 * float(threshold))
    # Held at once, without a motion to show.
    assert answers.impact(state | {"impact.velocity": 0.01})["curves"]["history"] is None
    ticking(monkeypatch, 1.0)
    curve = answers.velocity(state)["curves"]["velocity"]
    assert len(curve["velocity"]) == 13
    np.testing.assert_array_equal(curve["restitution_coefficient"] == 0.0, curve["velocity"] < threshold)


def test_adhesion_needs_a_smooth_profile_that_comes_straight():
    for other in (
        {"profile.type": "flat_punch"}, {"target": "layer"}, {"target": "plate"}, {"motion": "oblique"},
        {"entry": "groups"},
    ):  # fmt: skip
        assert "adhesion.work" not in settled({"sticking": "stress"} | other)
    assert "impact.external_force" in settled({"sticking": "stress"})


def test_the_sections_of_a_layer_and_of_a_ball() -> None:
    shape = answers.impact({"target": "layer", "profile.thickness": 0.003})["curves"]["shape"]
    assert (shape["semi_axis"], shape["thickness"]) == (None, 0.003)
    assert "layer" in shape["unknown"]
    assert shape["height"] == pytest.approx(np.square(shape["radius"]) / 0.02)
    assert answers.surface({"target": "layer"})["curves"]["surface"] is None


OBLIQUE = {"motion": "oblique", "impact.friction": 0.4, "impact.angle": -0.6, "impact.spin": 25.0}


def test_an_oblique_impact_is_that_of_the_package(tmp_path: Path) -> None:
    state = (
        drawn(3, **{"entry": "constants", "material.model": "standard_solid", "profile.type": "parabola"})
        | {"target": "half_space", "partner": "rigid", "sticking": "none"}
        | OBLIQUE
    )
    answer = answers.impact(state)
    path = case_file(state, tmp_path)
    problem = rs.read_case(path).impact
    result = rs.solve(problem, rtol=1e-4)
    assert isinstance(result, rs.ObliqueResult)
    for name in ("tangential_restitution_coefficient", "rebound_spin", "rebound_tangential_velocity"):
        assert answer["numbers"][name] == getattr(result, name)
    assert answer["numbers"]["spin"] == 25.0
    assert len(answer["curves"]["history"]["stick_radius"]) == len(answer["curves"]["history"]["time"])
    assert {"coupling", "travel"} <= {row["kind"] for row in answer["validity"]}
    # The page reads it again, and hands it out as Python.
    for again in (of_impact(problem), of_case(rs.read_case(path))):
        assert {key: again[key] for key in OBLIQUE} == OBLIQUE | {"impact.angle": pytest.approx(-0.6, rel=1e-15)}
    names: dict[str, Any] = {}
    exec(download({"what": "python", "state": state})["text"], names)
    results = next(value for value in names.values() if isinstance(value, rs.ObliqueResult))
    assert results.rebound_spin == pytest.approx(result.rebound_spin, rel=1e-3)
    # Friction changes no height, and turns the ball.
    straight, turning = (answers.bounces(other) for other in (state | {"motion": "straight"}, state))
    series = rs.bounces(problem, gravity=state["impact.gravity"], max_bounces=3, min_height=0.0, rtol=1e-5)
    count = min(series.n_bounces, straight["numbers"]["n_bounces"], turning["numbers"]["n_bounces"])
    columns = turning["curves"]["bounces"]
    assert columns["height"][: count - 1] == pytest.approx(
        straight["curves"]["bounces"]["height"][: count - 1], rel=1e-3
    )
    for name in ("place", "rebound_spin"):
        scale = np.nanmax(np.abs(series.to_dataset()[name]))
        np.testing.assert_allclose(columns[name][:count], series.to_dataset()[name][:count], rtol=0, atol=2e-3 * scale)
    assert settled(state | {"bounces.spot": "same"})["bounces.spot"] == "fresh"


def test_an_oblique_impact_needs_a_profile_and_a_solid_ball() -> None:
    assert settled(OBLIQUE | {"profile.type": "pyramid"})["motion"] == "straight"
    assert settled(OBLIQUE | {"entry": "groups"})["motion"] == "straight"
    assert "impact.spin" not in settled(OBLIQUE | {"profile.type": "cone"})
    ball = rs.Impact(rs.Material(1e6, np.inf), rs.Parabola(0.01), mass=0.01, velocity=1.0, friction=0.1, gyration=0.6)
    assert in_one_line(lambda: of_impact(ball)).field == "gyration"
    assert in_one_line(lambda: of_impact(replace(ball, friction=np.inf))).field == "friction"
