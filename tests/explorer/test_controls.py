"""The controls of the page in a browser, and its table of inputs."""

import random
from contextlib import suppress

import numpy as np
import pytest

import random_messages
import restitution as rs
from chromium import BASE, MARKS, ball, number, until, value_of, wait_for
from restitution.explorer.inputs import settled

pytest.importorskip("playwright", reason="the browser tests need the package playwright")
pytest.importorskip("uvicorn", reason="the browser tests need restitution[web]")
pytestmark = MARKS


def test_every_slider_moves_by_the_keyboard(opened):
    page = opened()
    sliders = page.locator(".control.number:visible")
    keys = [sliders.nth(n).get_attribute("data-key") for n in range(sliders.count())]
    assert {"material.viscosity", "material.poisson_ratio", "body.radius", "body.mass", "impact.velocity"} <= set(keys)
    for key in keys:
        about = page.evaluate(f"explorer.state.byKey.get({key!r})")
        slider = page.locator(f"[data-key='{key}'] input[type=range]")
        page.evaluate(f"explorer.state.set({{{key!r}: {about['default']!r}}}, true)")

        def moved(press, start, slider=slider, key=key):
            page.evaluate(f"explorer.state.set({{{key!r}: {start!r}}}, true)")
            slider.press(press)
            return value_of(page, key)

        start = about["low"] if about["default"] == 0.0 else about["default"]
        up = moved("ArrowRight", start)
        ten = moved("PageUp", start)
        if about["scale"] == "log":
            # Values have four digits.
            assert np.log10(up / start) == pytest.approx(about["step"], abs=5e-4)
            assert np.log10(ten / start) == pytest.approx(10 * about["step"], abs=5e-4)
        elif about["scale"] == "poisson":
            # From 0.4 on, a step of the slider is a tenth of its length over the rest to 0.5, as a logarithm.
            assert 0.4 < start < 0.5
            for value, steps in ((up, 1), (ten, 10)):
                assert np.log((0.5 - start) / (0.5 - value)) == pytest.approx(10 * steps * about["step"], rel=2e-2)
        else:
            assert up - start == pytest.approx(min(about["step"], about["high"] - start))
            assert ten - start == pytest.approx(min(10 * about["step"], about["high"] - start))
        assert moved("ArrowLeft", about["high"]) < about["high"]
        assert moved("PageDown", about["high"]) < moved("ArrowLeft", about["high"])
        assert moved("End", start) == about["high"]
        assert moved("Home", start) == (0.0 if about["least"] == 0.0 and about["scale"] == "log" else about["low"])
        page.evaluate(f"explorer.state.set({{{key!r}: {BASE.get(key, about['default'])!r}}}, true)")
    wait_for(page, "restitution_coefficient", rs.solve(ball()).restitution_coefficient)


def test_a_slider_moves_by_the_mouse_and_the_numbers_follow(opened):
    page = opened()
    for key, name in (("impact.velocity", "velocity"), ("material.viscosity", "viscosity"), ("body.mass", "mass")):
        slider = page.locator(f"[data-key='{key}'] input[type=range]")
        slider.scroll_into_view_if_needed()
        box = slider.bounding_box()
        across = box["y"] + box["height"] / 2
        page.mouse.move(box["x"] + 0.5 * box["width"], across)
        page.mouse.down()
        for share in (0.5, 0.55, 0.6):
            page.mouse.move(box["x"] + share * box["width"], across)
        page.mouse.up()
        value = value_of(page, key)
        assert value != BASE[key]
        wait_for(page, "restitution_coefficient", rs.solve(ball(**{name: value})).restitution_coefficient)
        page.evaluate("base => explorer.state.set(base, true)", BASE)


def test_a_number_can_be_typed_in_each_system_of_units(opened):
    page = opened()
    for units, shown in (("SI", "20"), ("mm-g-ms", "20"), ("AFM", "20000")):
        page.locator("#units").select_option(units)
        field = page.locator("#input-body-radius-number")
        field.fill(shown)
        field.press("Enter")
        assert value_of(page, "body.radius") == pytest.approx(0.02)
        wait_for(page, "restitution_coefficient", rs.solve(ball(radius=0.02)).restitution_coefficient)
        page.evaluate("explorer.state.set({'body.radius': 0.01}, true)")


def typed(page, name, text):
    field = page.locator(f"input[aria-label='{name}, as a number']:visible")
    field.fill(text)
    field.press("Enter")


def test_a_typed_number_keeps_its_unit(opened):
    page = opened()
    key, name = "material.equilibrium_modulus", "Equilibrium shear modulus"
    unit = page.locator(f"[data-key='{key}'] .unit")
    page.evaluate(f"explorer.state.set({{'{key}': 1e7}}, true)")
    for text, value, shown in (
        ("0", 0.0, "MPa"), ("10", 1e7, "MPa"), ("0.5", 5e5, "MPa"), ("20 kPa", 2e4, "kPa"), ("3", 3e3, "kPa"),
        ("2,5 MPa", 2.5e6, "MPa"),
    ):  # fmt: skip
        typed(page, name, text)
        assert value_of(page, key) == pytest.approx(value, rel=1e-12)
        assert unit.inner_text() == shown
    typed(page, name, "3 kg")
    assert "Write a number" in page.locator(f"[data-key='{key}']").inner_text()
    # A slider chooses a unit that suits.
    page.evaluate(f"explorer.state.set({{'{key}': 3e9}}, true)")
    assert unit.inner_text() == "GPa"
    for name, text, key, value in (
        ("Mass", "250 mg", "body.mass", 2.5e-4), ("Radius", "12 um", "body.radius", 1.2e-5),
        ("Impact velocity", "30 mm/s", "impact.velocity", 0.03), ("Shear viscosity of the branch", "2 kPa s", "material.viscosity", 2e3),
    ):  # fmt: skip
        typed(page, name, text)
        assert value_of(page, key) == pytest.approx(value, rel=1e-12)


def test_a_height_of_fall_is_a_velocity(opened):
    page = opened({"page.tab": "bounce"})
    typed(page, "Height of the release", "1 m")
    assert value_of(page, "impact.velocity") == pytest.approx(np.sqrt(2 * 9.80665), rel=1e-9)
    until(page, "Math.abs(explorer.last.bounces.numbers.drop_height - 1) < 1e-9")
    assert "leaves it out" in page.locator("#view-bounce .notes").inner_text()
    page.get_by_role("tab", name="Impact").click()
    assert page.locator("[data-key=drop_height]").is_hidden()


def test_relaxation_times_over_many_decades_have_no_prefix(opened):
    page = opened({"material.model": "prony", "bulk": "series"})
    page.evaluate(
        """explorer.state.set({ "material.shear.branch_moduli": [1e6, 1e6], "material.shear.relaxation_times": [1e-7, 1e5] }, true)"""
    )
    control = page.locator("[data-key='material.shear.relaxation_times']")
    assert control.locator("label").get_attribute("data-unit") == "[s]"
    assert control.locator("textarea").input_value() == "1e-7  100000"
    for key, symbol in (("equilibrium_modulus", "K"), ("branch_moduli", "K")):
        assert page.locator(f"[data-key='material.bulk.{key}'] label .symbol").inner_text().startswith(symbol)


@pytest.mark.parametrize("key", ["material.model", "profile.type"])
def test_every_choice_is_solved_and_drawn(opened, key):
    page = opened()
    options = page.evaluate(f"explorer.state.byKey.get({key!r}).options.map(option => option.value)")
    assert len(options) > 5
    # The first one is that of the start.
    for option in options[1:]:
        until(page, "explorer.backend.sent.size === 0")
        page.evaluate(f"explorer.last.impact = null; explorer.state.set({{{key!r}: {option!r}}}, true)")
        # An empty series, with which "prony" begins, may be refused.
        until(page, "explorer.last.impact || !document.getElementById('problem').hidden")
        assert page.evaluate("Boolean(explorer.last.impact)") or option == "prony"
        page.evaluate("base => explorer.state.set({...explorer.state.defaults, ...base}, true)", BASE)


def test_page_and_server_show_the_same_inputs(opened):
    """Both follow the conditions of one table; the page evaluates them to draw, and the server to solve."""
    page = opened()
    rng = random.Random(11)
    states = []
    while len(states) < 300:
        state = random_messages.state(rng)
        with suppress(rs.InputError):
            settled(state)
            states.append({key: value for key, value in state.items() if key != "page.tab"})
    shown = page.evaluate(
        """states => states.map((state) => {
          const page = explorer.state;
          const values = page.settled({ ...page.defaults, ...state });
          return Object.fromEntries(page.inputs.filter((input) => page.shown(input, values)).map(({ key }) => [key, values[key]]));
        })""",
        states,
    )
    for state, shown_values in zip(states, shown, strict=True):
        values = settled(state)
        # The server keeps the choices that the paper's numbers fix.
        assert {key: values[key] for key in values if key in shown_values} == shown_values
        assert values.keys() - shown_values.keys() <= {"material.model", "bulk"}


@pytest.mark.parametrize(
    ("key", "text", "rule"),
    [
        ("body.mass", "-1 kg", "body.mass = -1 kg: must be in [1e-15, 1e+08] kg"),
        ("material.poisson_ratio", "0.7", "material.poisson_ratio = 0.7: must be in [-1, 0.5]"),
        ("impact.velocity", "1e9", "impact.velocity = 1000000000 m/s: must be in [1e-09, 1e+07] m/s"),
    ],
)
def test_a_number_that_the_server_refuses_is_named_at_its_input(opened, key, text, rule):
    page = opened()
    control = page.locator(f"[data-key='{key}']")
    field = control.locator("input[type=text]")
    field.fill(text)
    field.press("Enter")
    control.locator(".fault:visible").wait_for()
    assert control.locator(".fault").inner_text() == page.locator("#problem").inner_text() == rule
    assert field.get_attribute("aria-invalid") == "true"
    page.get_by_role("button", name="Undo").click()
    control.locator(".fault").wait_for(state="hidden")
    assert field.get_attribute("aria-invalid") == "false"
    # An address has the same words.
    page.evaluate(f"location.hash = '{key}={text.split()[0]}'")
    page.locator("#problem:visible").wait_for()
    assert page.locator("#problem").inner_text() == rule


def test_a_list_that_is_too_long_is_refused_by_the_server(opened):
    page = opened({"material.model": "prony"})
    control = page.locator("[data-key='material.shear.branch_moduli']")
    field = control.locator("textarea")
    field.fill("1 2,5 3")
    field.press("Tab")
    assert "Write numbers" in control.locator(".fault").inner_text()
    field.fill(" ".join(["1"] * 51))
    field.press("Tab")
    page.locator("#problem:visible").wait_for()
    assert "must be a list of at most 50 numbers" in control.locator(".fault").inner_text()


def test_the_constants_and_the_three_numbers_describe_the_same_case(opened):
    page = opened({"material.viscosity": 1e4})
    e = number(page, "restitution_coefficient")
    page.get_by_label("Described by").select_option("groups")
    until(
        page,
        f"explorer.asked.impact.includes('groups') && Math.abs(explorer.numbers.restitution_coefficient - {e!r}) < 1e-5",
    )
    page.get_by_label("Described by").select_option("constants")
    assert value_of(page, "material.viscosity") == pytest.approx(1e4, rel=1e-5)
    assert value_of(page, "material.branch_modulus") == pytest.approx(1e7, rel=1e-5)
