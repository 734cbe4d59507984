"""The explorer in a browser: Debian's Chromium, driven by Playwright."""

import re
import shutil
import threading
import xml.etree.ElementTree as ET
from contextlib import contextmanager
from functools import partial
from http.server import SimpleHTTPRequestHandler, ThreadingHTTPServer
from pathlib import Path
from urllib.parse import urlencode

import matplotlib.pyplot as plt
import numpy as np
import pytest

import restitution as rs

pytest.importorskip("playwright", reason="the browser tests need the package playwright")
pytest.importorskip("uvicorn", reason="the browser tests need restitution[web]")
CHROMIUM = shutil.which("chromium")
pytestmark = [
    pytest.mark.slow,
    pytest.mark.skipif(CHROMIUM is None, reason="the browser tests need Chromium: apt-get install chromium"),
]
OPTIONS = [
    "--no-sandbox", "--disable-gpu", "--disable-quic", "--no-first-run", "--disable-background-networking",
    "--disable-component-update", "--disable-sync",
]  # fmt: skip
EXAMPLES = Path(__file__).parents[2] / "examples"
# The examples of the page may change; these tests start here.
BASE = {
    "material.equilibrium_modulus": 1e6, "material.branch_modulus": 1e7, "material.viscosity": 1e3,
    "material.poisson_ratio": 0.49, "material.density": 1100.0, "body.radius": 0.01, "body.mass": 0.005,
    "impact.velocity": 1.0,
}  # fmt: skip
TABS = ("impact", "paper", "bounce", "indentation")
SHOWN = 1e-12
"""The page has each number of the solver to the last digits of its decimal form."""


class QuietHandler(SimpleHTTPRequestHandler):
    def log_message(self, *_):
        pass


class FileServer(ThreadingHTTPServer):
    # The page asks for all its files at once.
    request_queue_size = 100


@contextmanager
def serving(state=None, title=None, port=0, token=None):
    from restitution.explorer import launch

    running = launch.listen(state, title, port=port)
    if token is not None:
        object.__setattr__(running.access, "token", token)
    thread = launch.in_thread(running)
    yield running
    running.stop()
    thread.join()


@pytest.fixture(scope="module")
def browser():
    from playwright.sync_api import sync_playwright

    with sync_playwright() as driver:
        browser = driver.chromium.launch(executable_path=CHROMIUM, args=OPTIONS)
        yield browser
        browser.close()


@pytest.fixture(scope="module")
def address():
    from restitution.explorer import launch

    # A first solve compiles for longer than a page waits.
    launch.warm_up()
    with serving() as running:
        yield running.address


@pytest.fixture
def opened(browser, address):
    """Open the page with a state; afterwards no error was logged, and every request went to the server."""
    errors, hosts, allowed, contexts = [], set(), {""}, []

    def open_page(state=None, start=address, **options):
        allowed.add(start.split("/")[2])
        context = browser.new_context(**({"reduced_motion": "reduce", "accept_downloads": True} | options))
        contexts.append(context)
        page = context.new_page()
        page.on("console", lambda message: errors.append(message.text) if message.type == "error" else None)
        page.on("pageerror", lambda error: errors.append(str(error)))
        page.on("request", lambda request: hosts.add(request.url.split("/")[2] if "//" in request.url else ""))
        page.goto(start if "#" in start else f"{start}#{urlencode(BASE | (state or {}))}")
        page.wait_for_selector("[data-output][data-value]:visible, .present p")
        return page

    yield open_page
    for context in contexts:
        context.close()
    assert errors == []
    assert hosts <= allowed


def until(page, condition):
    """Wait for a condition in JavaScript; the page's policy forbids Playwright's own way, which evaluates texts."""
    for _ in range(1500):
        if page.evaluate(condition):
            return
        page.wait_for_timeout(20)
    raise TimeoutError(condition)


def number(page, name):
    text = page.locator(f"[data-output={name}]:visible").first.get_attribute("data-value")
    return float(text) if text else np.nan


def wait_for(page, name, wanted, rtol=SHOWN):
    """Wait until the page shows a number."""
    found = f"[...document.querySelectorAll('[data-output={name}]')].map(one => Number(one.dataset.value))"
    until(page, f"{found}.some(one => Math.abs(one - {wanted!r}) <= {rtol} * Math.abs({wanted!r}))")


def ball(**changes):
    """The impact of `BASE`, with changes."""
    values = {key.partition(".")[2]: value for key, value in BASE.items()} | changes
    names = ("equilibrium_modulus", "branch_modulus", "viscosity", "poisson_ratio", "density")
    material = rs.standard_solid(**{name: values[name] for name in names})
    return rs.Impact(material, rs.Parabola(values["radius"]), mass=values["mass"], velocity=values["velocity"])


def value_of(page, key):
    return page.evaluate(f"explorer.state.get({key!r})")


def test_numbers_of_a_link_are_those_of_the_solver(opened):
    page = opened({"material.viscosity": 1e4, "impact.velocity": 0.37, "body.mass": 0.012})
    result = rs.solve(ball(viscosity=1e4, velocity=0.37, mass=0.012))
    wait_for(page, "restitution_coefficient", result.restitution_coefficient)
    for name in ("contact_time", "max_force", "max_indentation_depth", "max_contact_radius"):
        assert number(page, name) == pytest.approx(getattr(result, name), rel=SHOWN)
    material = result.impact.material
    assert number(page, "instantaneous_poisson_ratio") == pytest.approx(material.instantaneous_poisson_ratio)
    assert page.locator("[data-check]").count() == 6
    for check in result.validity:
        printed = check.message.replace("e+03", "·10³").replace("kg/m3", "kg/m³")
        assert printed[20:] in page.locator(f"[data-check={check.kind}]").inner_text()


PYRAMID = """
title = "Three faces"
body = {mass = 0.005}
impact = {velocity = 1.0}
profile = {type = "pyramid", face_angle = 1.3, sides = 3}
material = {model = "standard_solid", equilibrium_modulus = 1e6, branch_modulus = 1e7, viscosity = 1e3, bulk_modulus = 1e9}
"""


@pytest.mark.parametrize("text", [(EXAMPLES / "rubber_ball.toml").read_text(), PYRAMID])
def test_a_case_of_the_command_line_is_the_start(opened, tmp_path, text):
    from restitution.explorer.state import of_case

    path = tmp_path / "case.toml"
    path.write_text(text)
    case = rs.read_case(path)
    with serving(of_case(case), case.title) as running:
        page = opened(start=f"{running.address}#")
        wait_for(page, "restitution_coefficient", case.solve().restitution_coefficient, 1e-9)
        assert page.locator("#case-title").inner_text() == case.title
        assert page.title().startswith(case.title)
        # The page would report that its server is gone.
        page.close()


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


def test_a_link_keeps_every_input(opened):
    page = opened()
    state = page.evaluate(
        """() => {
          const value = (input) => ({
            number: () => Number((input.low + 0.3 * (input.high - input.low)).toPrecision(5)),
            choice: () => input.options.at(-1).value,
            list: () => [1.5, 2.5],
          })[input.type]();
          const patch = Object.fromEntries(explorer.schema.inputs.map((input) => [input.key, value(input)]));
          explorer.state.set({ ...patch, "material.model": "prony", bulk: "series" }, true);
          return explorer.state.case();
        }"""
    )
    assert len(state) > 40
    again = opened(start=page.url)
    assert again.evaluate("explorer.state.case()") == state


def test_the_newest_input_wins(opened):
    page = opened()
    until(page, "explorer.backend.sent.size === 0")
    page.evaluate(
        """() => {
          window.drawn = [];
          const draw = explorer.draw.bind(explorer);
          explorer.draw = (answer) => {
            if (answer.kind === "impact") drawn.push(answer.id);
            draw(answer);
          };
          for (let n = 1; n <= 200; n++) explorer.state.set({ "impact.velocity": n / 100 }, false);
          window.newest = Math.max(...[...explorer.backend.sent.values()].map((one) => one.id));
        }"""
    )
    wait_for(page, "restitution_coefficient", rs.solve(ball(velocity=2.0)).restitution_coefficient)
    until(page, "explorer.backend.sent.size === 0")
    drawn = page.evaluate("drawn.filter((id) => id <= newest)")
    assert drawn == sorted(drawn)
    assert drawn[-1] == page.evaluate("newest")
    assert value_of(page, "impact.velocity") == 2.0
    assert number(page, "restitution_coefficient") == pytest.approx(
        rs.solve(ball(velocity=2.0)).restitution_coefficient, rel=SHOWN
    )


@pytest.mark.parametrize("motion", ["reduce", "no-preference"])
def test_the_slow_motion_plays_unless_motion_is_unwanted(opened, motion):
    page = opened(reduced_motion=motion)
    assert page.evaluate("explorer.tabs.impact.clock.playing") == (motion != "reduce")
    assert page.locator(".play").inner_text() == ("Play" if motion == "reduce" else "Pause")
    shown = page.locator(".readout").inner_text()
    if motion == "reduce":
        page.get_by_role("button", name="Play").click()
    until(page, f"document.querySelector('.readout').textContent !== {shown!r}")
    page.get_by_role("button", name="Pause").click()
    assert not page.evaluate("explorer.tabs.impact.clock.playing")


CURSOR = """name => {
  const { plot, dots } = explorer.tabs.impact[name].figure;
  const place = (dot) => new DOMMatrix(getComputedStyle(dot).transform);
  const [line, ...others] = dots;
  return {
    line: line.hidden ? null : plot.posToVal(place(line).e, "x"),
    dots: others.filter((dot) => !dot.hidden).map((dot) => [plot.posToVal(place(dot).e, "x"), plot.posToVal(place(dot).f, "y")]),
  };
}"""


@pytest.mark.parametrize("share", [0.25, 0.5, 0.75])
def test_all_curves_show_the_time_of_the_slow_motion(opened, share):
    # N, mm and ms have no prefix; the energies are in g mm^2/ms^2 = mJ.
    page = opened({"page.units": "mm-g-ms"})
    result = rs.solve(ball())
    t = (share - 0.2) / 0.6 * result.contact_time
    at = result.sample(np.array([t]))
    time, depth, force = 1e3 * t, 1e3 * float(at.indentation_depth[0]), float(at.force[0])
    energies = [1e3 * float(at[f"{name}_energy"][0]) for name in ("kinetic", "stored", "dissipated")]
    wanted = {
        "force": [time, [[time, force]]],
        "loop": [None, [[depth, force]]],
        "energy": [time, [[time, energy] for energy in energies]],
    }
    # Each picture is out of sight before, and stands still when it comes into sight.
    page.get_by_label("Time of the slow motion").fill(str(1000 * share))
    assert page.evaluate("explorer.tabs.impact.clock.time") == pytest.approx(t, rel=1e-9)
    for name, (line, dots) in wanted.items():
        page.locator(f"[data-panel={name}] .plot").scroll_into_view_if_needed()
        until(page, f"explorer.tabs.impact.{name}.figure.visible && !explorer.tabs.impact.{name}.figure.stale")
        found = page.evaluate(CURSOR, name)
        assert found["line"] == (None if line is None else pytest.approx(line, rel=1e-5))
        # Straight lines between 121 points.
        peak = [1.0, result.energy[0] * 1e3 if name == "energy" else result.max_force]
        np.testing.assert_allclose(found["dots"][: len(dots)] / np.array(peak), dots / np.array(peak), atol=1e-3)


def test_a_failing_solve_shows_its_line_and_keeps_the_picture(opened):
    page = opened({"material.model": "maxwell", "material.maxwell_modulus": 1e6, "bulk": "bulk_modulus"})
    before = number(page, "restitution_coefficient")
    until(page, "explorer.backend.sent.size === 0")
    until(page, "explorer.tabs.impact.force.figure.visible && !explorer.tabs.impact.force.figure.stale")
    picture_of_force = "explorer.tabs.impact.force.figure.plot.root.querySelector('canvas')?.toDataURL()"
    drawn = page.evaluate(picture_of_force)
    field = page.get_by_label("Impact velocity, as a number")
    field.fill("fast")
    field.press("Enter")
    assert "Write a number" in page.locator("[data-key='impact.velocity']").inner_text()
    page.evaluate("explorer.state.set({'body.mass': -1}, true)")
    page.wait_for_selector("#problem:visible")
    line = page.locator("#problem").inner_text()
    assert "body.mass" in line
    assert "\n" not in line.strip()
    assert page.locator("[data-key='body.mass'] .fault").is_visible()
    assert "stale" in page.locator("#view-impact").get_attribute("class")
    for picture in (".plot", ".scenes", ".tiles"):
        style = "getComputedStyle(document.querySelector('#view-impact " + picture + "')).filter"
        assert page.evaluate(style) == "grayscale(1)"
    assert number(page, "restitution_coefficient") == before
    assert page.evaluate(picture_of_force) == drawn
    page.evaluate("explorer.state.set({'body.mass': 0.005}, true)")
    page.wait_for_selector("#problem", state="hidden")
    assert "stale" not in page.locator("#view-impact").get_attribute("class")


DROP = """(list) => {
  const files = new DataTransfer();
  for (let n = 0; n < list.length; n += 2) {
    const [name, text] = list.slice(n);
    files.items.add(new File([typeof text === "string" ? text : new Uint8Array(text)], name));
  }
  for (const kind of ["dragenter", "dragover", "drop"]) {
    document.dispatchEvent(new DragEvent(kind, { dataTransfer: files, bubbles: true, cancelable: true }));
  }
}"""


def test_a_dropped_dma_table_becomes_the_material(opened, tmp_path):
    page = opened()
    page.evaluate(DROP, ["beads_dma.csv", (EXAMPLES / "beads_dma.csv").read_text()])
    until(page, "explorer.state.get('material.model') === 'prony'")
    case = tmp_path / "case.toml"
    case.write_text(
        f"body = {{mass = 0.005, radius = 0.01}}\nimpact = {{velocity = 1.0}}\n"
        f"material = {{file = {str(EXAMPLES / 'beads_dma.csv')!r}, poisson_ratio = 0.49}}\n"
    )
    result = rs.solve(rs.read_case(case).impact)
    until(page, f"Math.abs(explorer.numbers.restitution_coefficient - {result.restitution_coefficient!r}) < 1e-8")
    assert page.locator("#file-message").is_visible()


def test_a_dropped_case_replaces_the_three_numbers_of_the_paper(opened):
    page = opened({"entry": "groups"})
    path = EXAMPLES / "rubber_ball.toml"
    page.evaluate(DROP, [path.name, path.read_text()])
    wait_for(page, "restitution_coefficient", rs.read_case(path).solve().restitution_coefficient)


@pytest.mark.parametrize("key", ["page.tab", "page.units"])
def test_a_link_with_unknown_names_shows_the_impact(opened, key):
    page = opened({key: "constructor"})
    wait_for(page, "restitution_coefficient", rs.solve(ball()).restitution_coefficient)


@pytest.mark.parametrize("encoding", ["utf-16", "cp1252"])
def test_files_of_instruments_have_other_encodings(opened, encoding):
    page = opened()
    # The name of the temperature has a letter that is no ASCII.
    text = "# at 23 °C\n" + (EXAMPLES / "beads_dma.csv").read_text()
    page.evaluate(DROP, ["µ.csv", [*text.encode(encoding)]])
    until(page, "explorer.state.get('material.model') === 'prony'")


def test_bad_files_are_refused_in_one_line(opened):
    page = opened()
    before = page.url
    for name, text in (
        ("notes.csv", "a,b\nx,y\n"),
        ("empty.csv", ""),
        ("picture.png", "\x89PNG\x00\x01"),
        ("case.toml", "[body]\nmas = 1\n"),
    ):
        page.evaluate("explorer.files.show('')")
        page.evaluate(DROP, [name, text])
        page.wait_for_selector("#file-message[data-bad=true]:visible")
        words = page.locator("#file-message").inner_text()
        assert words.strip()
        assert "Traceback" not in words
    assert page.url == before


def test_back_forward_undo_and_redo(opened):
    page = opened()
    field = page.get_by_label("Impact velocity, as a number")
    for speed in ("2", "3"):
        field.fill(speed)
        field.press("Enter")
    e = {v: rs.solve(ball(velocity=v)).restitution_coefficient for v in (1.0, 2.0, 3.0)}
    wait_for(page, "restitution_coefficient", e[3.0])
    page.go_back()
    wait_for(page, "restitution_coefficient", e[2.0])
    page.get_by_role("button", name="Undo").click()
    wait_for(page, "restitution_coefficient", e[1.0])
    assert page.get_by_role("button", name="Undo").is_disabled()
    page.go_forward()
    wait_for(page, "restitution_coefficient", e[2.0])
    page.get_by_role("button", name="Redo").click()
    wait_for(page, "restitution_coefficient", e[3.0])
    assert page.get_by_role("button", name="Redo").is_disabled()
    page.reload()
    wait_for(page, "restitution_coefficient", e[3.0])
    # An address that is typed is a step, too.
    page.evaluate("location.hash = location.hash.replace('velocity=3', 'velocity=2')")
    wait_for(page, "restitution_coefficient", e[2.0])
    page.get_by_role("button", name="Undo").click()
    wait_for(page, "restitution_coefficient", e[3.0])


def test_a_tab_shows_what_was_changed_on_another_one(opened):
    page = opened({"page.tab": "impact"}, viewport={"width": 360, "height": 760})
    until(page, "explorer.last.velocity && explorer.last.surface")
    page.get_by_role("tab", name="Paper").click()
    page.evaluate("explorer.state.set({'material.viscosity': 300}, true)")
    result = rs.solve(ball(viscosity=300.0))
    until(page, f"Math.abs(explorer.numbers.restitution_coefficient - {result.restitution_coefficient!r}) < 1e-9")
    assert f"e = {result.restitution_coefficient:.4f}" in page.locator("#strip").inner_text()
    assert page.evaluate("explorer.last.surface === null")
    page.get_by_role("tab", name="Impact").click()
    curve = "explorer.last.velocity.curves.velocity"
    slowest = rs.solve(ball(viscosity=300.0, velocity=page.evaluate(f"{curve}.velocity[0]")))
    until(page, f"Math.abs({curve}.restitution_coefficient[0] - {slowest.restitution_coefficient!r}) < 1e-5")
    until(page, "explorer.last.surface")
    page.get_by_role("tab", name="Indentation").click()
    until(page, "explorer.last.indentation")
    assert page.locator("#strip").inner_text().startswith("F = ")


def test_two_pages_do_not_disturb_each_other(opened):
    first, second = opened({"impact.velocity": 2.0}), opened({"impact.velocity": 4.0})
    for page, velocity in ((first, 2.0), (second, 4.0)):
        wait_for(page, "restitution_coefficient", rs.solve(ball(velocity=velocity)).restitution_coefficient)
    first.locator("[data-key='impact.velocity'] input[type=range]").press("Home")
    wait_for(first, "restitution_coefficient", rs.solve(ball(velocity=1e-3)).restitution_coefficient)
    assert number(second, "restitution_coefficient") == pytest.approx(
        rs.solve(ball(velocity=4.0)).restitution_coefficient
    )


def test_the_page_notices_that_the_server_is_gone_and_comes_back(browser):
    page = browser.new_context(reduced_motion="reduce").new_page()
    with serving(token="same") as running:
        page.goto(f"{running.address}#{urlencode(BASE)}")
        page.wait_for_selector("[data-output][data-value]:visible")
        port = running.port
    page.wait_for_selector("#connection:visible")
    assert "does not answer" in page.locator("#connection").inner_text()
    for speed in ("3", "2"):
        page.get_by_label("Impact velocity, as a number").fill(speed)
        page.get_by_label("Impact velocity, as a number").press("Enter")
    with serving(port=port, token="same"):
        page.wait_for_selector("#connection", state="hidden")
        wait_for(page, "restitution_coefficient", rs.solve(ball(velocity=2.0)).restitution_coefficient)
    with serving(port=port, token="another"):
        until(page, "document.getElementById('connection').textContent.includes('terminal')")
    page.context.close()


def test_pinned_settings_stay_in_the_address(opened):
    page = opened()
    for velocity in (0.5, 0.25, 0.125, 2.0):
        page.get_by_role("button", name="Pin this setting").click()
        page.evaluate(f"explorer.state.set({{'impact.velocity': {velocity}}}, true)")
    assert page.get_by_role("button", name="Pin this setting").is_disabled()
    again = opened(start=page.url)
    until(again, "document.querySelectorAll('#compare tbody tr').length === 5")
    until(again, "!document.querySelector('#compare').textContent.includes('…')")
    e = rs.solve(ball(velocity=0.5)).restitution_coefficient
    assert f"{e:.4g}" in again.locator("#compare tbody tr").nth(2).inner_text()
    # Each picture has each of their curves, in grey and with its letter.
    forces = [rs.solve(ball(velocity=velocity)).max_force for velocity in (1.0, 0.5, 0.25, 0.125)]
    for panel in ("force", "loop", "energy", "relaxation", "moduli", "velocity"):
        until(again, f"explorer.tabs.impact.{panel}.columns.filter(one => /^[A-D]: /.test(one.name)).length >= 8")
        curves = again.evaluate(f"explorer.tabs.impact.{panel}.figure.curves.filter(one => one.letter)")
        assert [curve["letter"] for curve in curves] == list("DCBA")
        assert {curve["colour"] for curve in curves} == {"pinned"}
        if panel in ("force", "loop"):
            # The largest of 121 points.
            assert [max(curve["y"]) for curve in curves[::-1]] == pytest.approx(forces, rel=1e-3)
    again.get_by_role("tab", name="Bounce").click()
    until(again, "document.querySelector('#compare thead').textContent.includes('h')")
    until(again, "!document.querySelector('#compare').textContent.includes('…')")
    height = 0.5**2 / (2 * 9.80665)
    assert f"{1e3 * height:.4g} mm" in again.locator("#compare tbody tr").nth(2).inner_text()
    again.get_by_role("tab", name="Impact").click()
    again.get_by_role("button", name="Go to setting B").click()
    wait_for(again, "restitution_coefficient", e)
    again.get_by_role("button", name="Remove setting A").click()
    until(again, "document.querySelectorAll('#compare tbody tr').length === 4")


def test_the_map_leads_to_the_place_that_is_pressed(opened):
    page = opened({"page.tab": "paper", "entry": "groups", "groups.nu": 0.45})
    over = page.locator("[data-panel=figure-3] .u-over")
    over.click(position={"x": 60, "y": 40})
    p2, p3 = (value_of(page, f"groups.{name}") for name in ("p2", "p3"))
    box = over.bounding_box()
    assert np.log10(p2) == pytest.approx(-3 + 4 * 60 / box["width"], abs=0.02)
    assert np.log10(p3) == pytest.approx(2 - 4 * 40 / box["height"], abs=0.02)
    e = rs.standard_solid_restitution(0.45, p2, p3)
    until(page, f"Math.abs(explorer.numbers.restitution_coefficient - {float(e)!r}) < 1e-7")


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


def saved_as(page, panel, words, folder):
    """Save a picture by its menu, and return the path of the file."""
    page.locator(f"{panel} summary").click()
    with page.expect_download() as waiting:
        page.locator(panel).get_by_role("button", name=words).click()
    path = folder / waiting.value.suggested_filename
    waiting.value.save_as(path)
    return path


# The file has SI in all systems.
@pytest.mark.parametrize("units", ["SI", "AFM"])
def test_files_of_a_picture_and_of_the_case(opened, tmp_path, units):
    page = opened({"page.units": units})
    until(page, "explorer.tabs.impact.force.columns?.length")
    result = rs.solve(ball())

    def saved(words):
        return saved_as(page, "[data-panel=force]", words, tmp_path)

    table = saved("CSV")
    assert table.read_text().splitlines()[0] == "time [s],force [N]"
    time, force = np.loadtxt(table, delimiter=",", skiprows=1).T
    np.testing.assert_allclose(force, result.sample(time).force, rtol=1e-9, atol=1e-9 * result.max_force)
    drawn = plt.imread(saved("PNG"))
    svg = saved("SVG").read_text()
    root = ET.fromstring(svg)
    # Two pixels for one, with more than an empty page.
    assert drawn.shape[:2] == (2 * int(float(root.get("height"))), 2 * int(float(root.get("width"))))
    assert len(np.unique(drawn.reshape(-1, drawn.shape[2]), axis=0)) > 20
    assert f"normal force F [{'N' if units == 'SI' else 'nN'}]" in svg
    page.locator("#save-menu summary").click()
    with page.expect_download() as waiting:
        page.get_by_role("button", name="Download case.toml").click()
    path = tmp_path / waiting.value.suggested_filename
    waiting.value.save_as(path)
    again = rs.solve(rs.read_case(path).impact)
    assert again.restitution_coefficient == pytest.approx(result.restitution_coefficient, rel=1e-9)


SVG = "{http://www.w3.org/2000/svg}"


def scenes_of(path):
    """The whole body and the contact, of a slow motion saved as SVG."""
    return ET.parse(path).getroot().findall(f"{SVG}svg")


def points_of(path):
    """Points of a path without arcs."""
    return np.array(re.findall(r"[ML](-?[\d.]+) (-?[\d.]+)", path.get("d")), dtype=float)


def enlarged(scene):
    """The enlarged contact in metres: outline of the body (x, depth), and the x of the ends of the contact."""
    parts = list(scene)
    paths = [one for one in parts if one.tag == f"{SVG}path"]
    bar = next(n for n, one in enumerate(parts) if one.tag == f"{SVG}path" and one.get("d").startswith("M8 "))
    length, unit = parts[bar + 1].text.split()
    left, right = points_of(parts[bar])[1:3, 0]
    scale = float(length) * {"mm": 1e-3, "µm": 1e-6}[unit] / (right - left)
    stretch = next((float(one.text.split()[-1]) for one in parts if "heights" in (one.text or "")), 1.0)
    (ground,) = [one for one in paths if one.get("stroke-dasharray")]
    middle = float(scene.get("width")) / 2
    # The last two points close the outline above the picture.
    body = points_of([one for one in paths if one.get("fill") != "none" and len(points_of(one)) > 100][-1])[:-2]
    body = body[body[:, 1] > -10.0]
    edges = [points_of(one) for one in paths if one.get("stroke-width") and len(points_of(one)) == 2]
    ends = [line[0, 0] - middle for line in edges if line[0, 0] == line[1, 0] != middle]
    zero = points_of(ground)[0, 1]
    x, depth = (body[:, 0] - middle) * scale, (body[:, 1] - zero) * scale / stretch
    return x, depth, np.array(ends) * scale, scale


ELLIPSOID = {"profile.type": "ellipsoid", "profile.radius_1": 0.05, "profile.radius_2": 0.01}


@pytest.mark.parametrize("share", [0.35, 0.7])
@pytest.mark.parametrize("state", [{}, ELLIPSOID])
def test_the_slow_motion_is_saved_as_it_is(opened, tmp_path, state, share):
    page = opened(state)
    profile = rs.Ellipsoid(0.05, 0.01) if state else rs.Parabola(0.01)
    result = rs.solve(rs.Impact(ball().material, profile, mass=0.005, velocity=1.0))
    wait_for(page, "restitution_coefficient", result.restitution_coefficient)
    page.evaluate(f"explorer.tabs.impact.clock.to({share})")
    whole, contact = scenes_of(saved_as(page, ".stage", "SVG", tmp_path))
    at = result.sample(np.array([(share - 0.2) / 0.6 * result.contact_time]))
    depth, mean = float(at.indentation_depth[0]), float(at.contact_radius[0])
    x, found, ends, scale = enlarged(contact)
    # Rounded to 0.01 pixels; a straight line between 61 points of the body and 121 times is off by a few times that.
    assert x.size > 200
    curvature = 1 / (0.05 if state else 0.01)
    assert found == pytest.approx(depth - curvature * x**2 / 2, abs=0.1 * scale)
    widest = profile.semi_axes(mean)[0] if state else mean
    assert sorted(ends) == pytest.approx([-widest, widest], abs=0.1 * scale)
    # The whole body: its half-axes, and its lowest point under the ground.
    arc = next(one.get("d") for one in whole if "A" in (one.get("d") or ""))
    _, middle, across, up = (float(one) for one in re.match(r"M([\d.]+) ([\d.]+)A([\d.]+) ([\d.]+) ", arc).groups())
    assert across / up == pytest.approx(np.sqrt(5.0) if state else 1.0, rel=1e-3)
    ground = float(whole.find(f"{SVG}rect").get("y"))
    assert middle + up - ground == pytest.approx(depth / 0.01 * up, abs=0.1)
    table = saved_as(page, ".stage", "CSV", tmp_path)
    assert table.read_text().splitlines()[0] == "time [s],indentation_depth [m],contact_radius [m],force [N]"
    time, *columns = np.loadtxt(table, delimiter=",", skiprows=1).T
    history = result.sample(time)
    for name, values in zip(("indentation_depth", "contact_radius", "force"), columns, strict=True):
        np.testing.assert_allclose(values, history[name], rtol=1e-9, atol=1e-9 * float(history[name].max()))
    drawn = plt.imread(saved_as(page, ".stage", "PNG", tmp_path))
    assert len(np.unique(drawn.reshape(-1, drawn.shape[2]), axis=0)) > 20


def test_the_slow_motion_of_a_pyramid_says_what_is_not_known(opened, tmp_path):
    page = opened({"profile.type": "pyramid", "profile.face_angle": 1.2})
    result = rs.solve(rs.Impact(ball().material, rs.Pyramid(1.2), mass=0.005, velocity=1.0))
    wait_for(page, "restitution_coefficient", result.restitution_coefficient)
    assert "surface around a pyramid is not known" in page.locator(".scenes .note").inner_text()
    page.evaluate("explorer.tabs.impact.clock.to(0.5)")
    _, contact = scenes_of(saved_as(page, ".stage", "SVG", tmp_path))
    x, found, ends, scale = enlarged(contact)
    depth = float(result.sample(np.array([0.5 * result.contact_time])).indentation_depth[0])
    assert found == pytest.approx(depth - np.abs(x) / np.tan(1.2), abs=0.1 * scale)
    assert ends.size == 0


def test_a_body_that_stays_has_a_line_in_place_of_the_slow_motion(opened):
    page = opened({"material.model": "maxwell", "material.viscosity": 1.0, "bulk": "bulk_modulus"})
    until(page, "explorer.last.impact.curves.history === null")
    assert "no rebound to show" in page.locator(".readout").inner_text()
    for part in (".play", ".stage summary", ".stage canvas"):
        assert page.locator(part).first.is_hidden()


def test_a_note_on_the_material_is_no_doubt(opened):
    page = opened({"material.model": "fractional_zener"})
    until(page, "explorer.last.impact.notes.length > 0")
    page.wait_for_selector(".sign.note")
    doubtful = page.locator("[data-check] .sign.doubtful").count()
    summary = page.locator(".checks summary").inner_text()
    assert summary == ("No assumption is doubtful" if not doubtful else summary)
    assert (f"{doubtful} of" in summary) == bool(doubtful)


def test_the_labels_have_one_size_on_all_screens(opened):
    sizes = []
    for ratio in (1, 2):
        page = opened(device_scale_factor=ratio)
        until(page, "explorer.tabs.impact.force.figure.plot")
        axes = page.evaluate("explorer.tabs.impact.force.figure.plot.axes.map(one => [one.font[0], one.labelFont[0]])")
        sizes.append([float(re.match(r"([\d.]+)px", font)[1]) / ratio for axis in axes for font in axis])
    assert sizes[0] == sizes[1]
    assert min(sizes[0]) >= 12


MAP = "explorer.tabs.impact.map.figure"


def test_a_finger_moves_a_slider_and_the_map(opened):
    page = opened(viewport={"width": 360, "height": 760}, has_touch=True, is_mobile=True, device_scale_factor=2)
    page.locator("#settings-box summary").tap()
    slider = page.locator("[data-key='impact.velocity'] input[type=range]")
    slider.scroll_into_view_if_needed()
    box = slider.bounding_box()
    page.touchscreen.tap(box["x"] + 0.9 * box["width"], box["y"] + box["height"] / 2)
    assert value_of(page, "impact.velocity") > 2.0
    velocity = value_of(page, "impact.velocity")
    wait_for(page, "restitution_coefficient", rs.solve(ball(velocity=velocity)).restitution_coefficient)
    page.locator("#settings-box summary").tap()
    over = page.locator("[data-panel=map] .u-over")
    over.scroll_into_view_if_needed()
    until(page, f"(({{visible, stale, curves}}) => visible && !stale && curves.length)({MAP})")
    box = over.bounding_box()
    page.touchscreen.tap(box["x"] + 0.5 * box["width"], box["y"] + 0.25 * box["height"])
    until(
        page,
        "Math.abs(Math.log10(explorer.numbers.p3) - 1) < 0.05 && Math.abs(Math.log10(explorer.numbers.p2) + 1) < 0.05",
    )


def test_the_python_that_is_copied_gives_the_same_number(opened, address, capsys):
    page = opened({"impact.velocity": 0.5})
    page.context.grant_permissions(["clipboard-read", "clipboard-write"], origin=address.split("/?")[0])

    def copied():
        page.locator("#save-menu summary").click()
        page.get_by_role("button", name="Copy as Python").click()
        page.get_by_role("button", name="Copied").wait_for()
        page.get_by_role("button", name="Copy as Python").wait_for()
        page.locator("#save-menu summary").click()
        names = {}
        exec(page.evaluate("navigator.clipboard.readText()"), names)
        return names["result"]

    e = number(page, "restitution_coefficient")
    assert copied().restitution_coefficient == pytest.approx(e, rel=1e-9)
    page.get_by_role("tab", name="Bounce").click()
    until(page, "explorer.last.bounces")
    capsys.readouterr()
    assert copied().restitution_coefficient == pytest.approx(e, rel=1e-9)
    assert str(rs.bounces(ball(velocity=0.5))) in capsys.readouterr().out
    page.get_by_role("tab", name="Indentation").click()
    until(page, "explorer.last.indentation")
    assert copied().max_force == pytest.approx(number(page, "max_force"), rel=1e-5)


def test_bounces_and_indentation_are_those_of_the_package(opened):
    page = opened({"page.tab": "bounce", "material.viscosity": 1e4})
    e = rs.solve(ball(viscosity=1e4)).restitution_coefficient
    until(page, "explorer.last.bounces")
    first = page.evaluate("explorer.last.bounces.curves.bounces.restitution_coefficient[0]")
    assert first == pytest.approx(e, rel=0.05)  # the weight acts in contact
    page = opened(
        {
            "page.tab": "indentation",
            "material.viscosity": 1e6,
            "indentation.radius": 2e-6,
            "indentation.depth": 4e-7,
            "indentation.loading_time": 1.0,
            "indentation.unloading_time": 1.0,
        }
    )
    material = ball(viscosity=1e6).material
    found = rs.indent(material, rs.Parabola(2e-6), depth=rs.triangle(4e-7, 1.0))
    until(page, "explorer.last.indentation")
    assert number(page, "max_force") == pytest.approx(found.max_force, rel=1e-6)


@pytest.mark.parametrize("tab", TABS)
@pytest.mark.parametrize(("width", "scheme"), [(360, "dark"), (1280, "light")])
def test_no_violation_of_accessibility(opened, tab, width, scheme):
    axe = pytest.importorskip("axe_playwright_python.sync_playwright", reason="needs axe-playwright-python")
    state = {"page.tab": tab, "page.pins": "page.tab=impact&impact.velocity=0.5|page.tab=impact&impact.velocity=2"}
    page = opened(state, color_scheme=scheme, viewport={"width": width, "height": 800})
    if tab == "paper":
        page.wait_for_selector(".claims li")

    def violations():
        found = axe.Axe().run(page).response["violations"]
        return [(one["id"], [node["target"] for node in one["nodes"]]) for one in found]

    assert violations() == []
    wide = page.evaluate("document.documentElement.scrollWidth - document.documentElement.clientWidth")
    assert wide <= 0
    # A failed solve leaves what it greys readable.
    page.evaluate("explorer.state.set({'material.poisson_ratio': 7}, true)")
    page.wait_for_selector("#problem:visible")
    assert violations() == []


def test_the_static_page_needs_no_server_of_ours(opened, tmp_path):
    from restitution.explorer.static import write_static

    write_static(tmp_path)
    handler = partial(QuietHandler, directory=str(tmp_path))
    with FileServer(("127.0.0.1", 0), handler) as server:
        threading.Thread(target=server.serve_forever, daemon=True).start()
        page = opened(
            {"page.tab": "impact", "entry": "groups", "groups.nu": 0.45, "groups.p2": 0.02, "groups.p3": 0.7},
            f"http://127.0.0.1:{server.server_port}/",
        )
        assert number(page, "restitution_coefficient") == pytest.approx(
            float(rs.standard_solid_surrogate(0.45, 0.02, 0.7)), rel=1e-9
        )
        page.locator("[data-key='groups.p3'] input[type=range]").press("ArrowRight")
        p3 = value_of(page, "groups.p3")
        wait_for(page, "restitution_coefficient", float(rs.standard_solid_surrogate(0.45, 0.02, p3)), 1e-9)
        assert page.get_by_role("tab").evaluate_all("tabs => tabs.filter(one => one.checkVisibility()).length") == 2
        page.get_by_role("tab", name="Paper").click()
        page.wait_for_selector(".claims li")
        page.wait_for_load_state("networkidle")
        # A page that outlives its server logs an error.
        page.context.close()
        server.shutdown()


def test_a_frame_in_a_notebook_shows_the_impact(browser, tmp_path):
    handler = partial(QuietHandler, directory=str(tmp_path))
    impact = ball(velocity=0.7)
    with rs.explore(impact) as explorer, FileServer(("127.0.0.1", 0), handler) as server:
        (tmp_path / "index.html").write_text(f"<!doctype html><title>notebook</title>{explorer._repr_html_()}")
        threading.Thread(target=server.serve_forever, daemon=True).start()
        page = browser.new_context(reduced_motion="reduce").new_page()
        # For a browser another site than that of the explorer, whose page may then have no storage.
        page.goto(f"http://localhost:{server.server_port}/")
        shown = page.frame_locator("iframe").locator("[data-output=restitution_coefficient][data-value]").first
        shown.wait_for()
        expected = rs.solve(impact).restitution_coefficient
        assert float(shown.get_attribute("data-value")) == pytest.approx(expected, rel=1e-9)
        page.context.close()
        server.shutdown()


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


def test_numbers_are_grey_while_the_server_is_gone_and_come_back(browser):
    context = browser.new_context(reduced_motion="reduce")
    page = context.new_page()
    with serving() as running:
        page.goto(f"{running.address}#{urlencode(BASE)}")
        page.wait_for_selector("[data-output][data-value]:visible")
    page.wait_for_selector("#connection:visible")
    assert "stale" in page.locator("#view-impact").get_attribute("class")
    page.evaluate("explorer.state.set({'impact.velocity': 2}, true)")
    # A new server has another token; a page of its address brings the old one back, with its state.
    with serving(port=running.port) as again:
        assert again.access.token != running.access.token
        context.new_page().goto(again.address)
        page.wait_for_url(lambda url: again.access.token in url)
        until(page, "!document.getElementById('view-impact').classList.contains('stale')")
        wait_for(page, "restitution_coefficient", rs.solve(ball(velocity=2.0)).restitution_coefficient)
        assert value_of(page, "impact.velocity") == 2.0
        assert again.access.token in page.url
        context.close()


def test_what_an_address_has_beyond_inputs_is_named(opened):
    page = opened({"material.viscosity": "abc", "nothing": 3, "bulk": "steel"})
    words = page.locator("#address-message").inner_text()
    for one in ("material.viscosity=abc", "nothing=3", "bulk=steel"):
        assert one in words
    assert value_of(page, "material.viscosity") == 3e3
    assert opened().locator("#address-message").is_hidden()


def test_what_a_file_does_not_state_is_asked_for(opened, tmp_path):
    page = opened()
    text = "t,modulus\ns,MPa\n" + "".join(f"{t},{5 + 20 * np.exp(-t / 0.01)}\n" for t in np.geomspace(1e-4, 1, 30))
    page.evaluate(DROP, ["relaxation.csv", text])
    form = page.locator("#file-message form")
    form.wait_for()
    assert value_of(page, "material.model") == "standard_solid"
    form.locator("select").select_option("tension")
    form.get_by_role("button").click()
    until(
        page,
        "explorer.state.get('material.model') !== 'standard_solid' || explorer.state.get('bulk') !== 'poisson_ratio'",
    )
    path = tmp_path / "relaxation.csv"
    path.write_text(text)
    case = tmp_path / "case.toml"
    case.write_text(
        "body = {mass = 0.005, radius = 0.01}\nimpact = {velocity = 1.0}\n"
        "material = {file = 'relaxation.csv', poisson_ratio = 0.49, deformation = 'tension'}\n"
    )
    wait_for(page, "restitution_coefficient", rs.read_case(case).solve().restitution_coefficient, 1e-8)


def test_a_case_and_its_table_are_dropped_together(opened):
    page = opened()
    names = ("epoxy_prony.csv", "epoxy.toml")
    page.evaluate(DROP, [part for name in names for part in (name, (EXAMPLES / name).read_text())])
    wait_for(page, "restitution_coefficient", rs.read_case(EXAMPLES / "epoxy.toml").solve().restitution_coefficient)


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


def test_formulas_of_the_claims_are_typeset(opened):
    page = opened({"page.tab": "paper"})
    page.wait_for_selector(".claims li")
    words = page.locator(".claims ol").inner_text()
    for ascii in ("Ginf", "nu_0", "eta", "^", "e-1"):
        assert ascii not in words.replace("\n", "")
    assert page.locator(".claims sub").count() > 10
    assert page.locator(".claims sup").count() > 3


def test_a_static_page_of_a_file_says_why_it_does_not_run(browser, tmp_path):
    from restitution.explorer.static import write_static

    write_static(tmp_path)
    page = browser.new_context().new_page()
    page.goto((tmp_path / "index.html").as_uri())
    assert "file on disk" in page.locator(".starting").inner_text()
    page.context.close()


def test_the_first_example_of_the_indentation_has_hysteresis(opened, address):
    page = opened(start=f"{address}#page.tab=indentation")
    until(page, "explorer.last.indentation")
    found = page.evaluate("explorer.last.indentation.numbers")
    # The work that stays is a large part of the largest force times the largest depth.
    assert found["work"] > 0.1 * found["max_force"] * found["max_indentation_depth"]


@pytest.mark.parametrize("width", [360, 1280, 1920])
@pytest.mark.parametrize("tab", TABS)
def test_nothing_is_wider_than_the_screen(opened, tab, width):
    page = opened({"page.tab": tab}, viewport={"width": width, "height": 900})
    until(page, "document.querySelectorAll('.plot canvas').length > 1")
    assert page.evaluate("document.documentElement.scrollWidth - document.documentElement.clientWidth") <= 0
