"""The explorer in a browser: Debian's Chromium, driven by Playwright."""

import shutil
import threading
from contextlib import contextmanager
from functools import partial
from http.server import SimpleHTTPRequestHandler, ThreadingHTTPServer
from pathlib import Path
from urllib.parse import urlencode

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
        context = browser.new_context(reduced_motion="reduce", accept_downloads=True, **options)
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
        assert check.message[20:] in page.locator(f"[data-check={check.kind}]").inner_text()


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


def test_a_failing_solve_shows_its_line_and_keeps_the_picture(opened):
    page = opened({"material.model": "maxwell", "material.maxwell_modulus": 1e6, "bulk": "bulk_modulus"})
    before = number(page, "restitution_coefficient")
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
    assert number(page, "restitution_coefficient") == before
    page.evaluate("explorer.state.set({'body.mass': 0.005}, true)")
    page.wait_for_selector("#problem", state="hidden")
    assert "stale" not in page.locator("#view-impact").get_attribute("class")


DROP = """([name, text]) => {
  const files = new DataTransfer();
  files.items.add(new File([text], name));
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


def test_bad_files_are_refused_in_one_line(opened):
    page = opened()
    before = page.url
    for name, text in (
        ("notes.csv", "a,b\nx,y\n"),
        ("empty.csv", ""),
        ("picture.png", "\x89PNG\x00\x01"),
        ("case.toml", "[body]\nmas = 1\n"),
    ):
        page.evaluate("explorer.files.say('')")
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
    page.get_by_label("Impact velocity, as a number").fill("2")
    page.get_by_label("Impact velocity, as a number").press("Enter")
    with serving(port=port, token="same"):
        page.wait_for_selector("#connection", state="hidden")
        wait_for(page, "restitution_coefficient", rs.solve(ball(velocity=2.0)).restitution_coefficient)
    with serving(port=port, token="another"):
        until(page, "document.getElementById('connection').textContent.includes('terminal')")
    page.context.close()


def test_pinned_settings_stay_in_the_address(opened):
    page = opened()
    field = page.get_by_label("Impact velocity, as a number")
    for speed in ("0.5", "0.25", "0.125", "2"):
        page.get_by_role("button", name="Pin this setting").click()
        field.fill(speed)
        field.press("Enter")
    assert page.get_by_role("button", name="Pin this setting").is_disabled()
    again = opened(start=page.url)
    until(again, "document.querySelectorAll('#compare tbody tr').length === 5")
    until(again, "!document.querySelector('#compare').textContent.includes('…')")
    e = rs.solve(ball(velocity=0.5)).restitution_coefficient
    assert f"{e:.4g}" in again.locator("#compare tbody tr").nth(2).inner_text()
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


def test_files_of_a_picture_and_of_the_case(opened, tmp_path):
    page = opened()
    until(page, "explorer.tabs.impact.force.columns?.length")
    result = rs.solve(ball())

    def saved(words):
        page.locator("[data-panel=force] summary").click()
        with page.expect_download() as waiting:
            page.locator("[data-panel=force]").get_by_role("button", name=words).click()
        path = tmp_path / waiting.value.suggested_filename
        waiting.value.save_as(path)
        return path

    table = saved("CSV")
    assert table.read_text().splitlines()[0] == "time [s],force [N]"
    time, force = np.loadtxt(table, delimiter=",", skiprows=1).T
    np.testing.assert_allclose(force, result.sample(time).force, rtol=1e-9, atol=1e-9 * result.max_force)
    assert saved("PNG").read_bytes().startswith(b"\x89PNG")
    svg = saved("SVG").read_text()
    assert svg.startswith("<svg")
    assert "normal force F [N]" in svg
    page.locator("#save-menu summary").click()
    with page.expect_download() as waiting:
        page.get_by_role("button", name="Download case.toml").click()
    path = tmp_path / waiting.value.suggested_filename
    waiting.value.save_as(path)
    again = rs.solve(rs.read_case(path).impact)
    assert again.restitution_coefficient == pytest.approx(result.restitution_coefficient, rel=1e-9)


def test_the_python_that_is_copied_gives_the_same_number(opened, address):
    page = opened({"impact.velocity": 0.5})
    page.context.grant_permissions(["clipboard-read", "clipboard-write"], origin=address.split("/?")[0])
    page.locator("#save-menu summary").click()
    page.get_by_role("button", name="Copy as Python").click()
    page.get_by_role("button", name="Copied").wait_for()
    names = {}
    exec(page.evaluate("navigator.clipboard.readText()"), names)
    assert names["result"].restitution_coefficient == pytest.approx(number(page, "restitution_coefficient"), rel=1e-9)


def test_bounces_and_indentation_are_those_of_the_package(opened):
    page = opened({"page.tab": "bounce", "material.viscosity": 1e4})
    e = rs.solve(ball(viscosity=1e4)).restitution_coefficient
    until(page, "explorer.last.bounces")
    first = page.evaluate("explorer.last.bounces.curves.bounces.restitution_coefficient[0]")
    assert first == pytest.approx(e, rel=0.05)  # the weight acts in contact
    page = opened(
        {"page.tab": "indentation", "material.viscosity": 1e6, "indentation.radius": 2e-6, "indentation.depth": 4e-7}
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
    found = axe.Axe().run(page).response["violations"]
    assert [(one["id"], [node["target"] for node in one["nodes"]]) for one in found] == []
    wide = page.evaluate("document.documentElement.scrollWidth - document.documentElement.clientWidth")
    assert wide <= 0


def test_the_static_page_needs_no_server_of_ours(opened, tmp_path):
    from restitution.explorer.static import write_static

    write_static(tmp_path)
    handler = partial(QuietHandler, directory=str(tmp_path))
    with ThreadingHTTPServer(("127.0.0.1", 0), handler) as server:
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
        server.shutdown()


def test_a_frame_in_a_notebook_shows_the_impact(browser, tmp_path):
    handler = partial(QuietHandler, directory=str(tmp_path))
    impact = ball(velocity=0.7)
    with rs.explore(impact) as explorer, ThreadingHTTPServer(("127.0.0.1", 0), handler) as server:
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
