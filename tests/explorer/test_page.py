"""The page in a browser: links, tabs, pinned settings, the server that comes and goes, and pages without one."""

import threading
from functools import partial
from http.server import SimpleHTTPRequestHandler, ThreadingHTTPServer
from urllib.parse import urlencode

import pytest

import restitution as rs
from checkout import EXAMPLES
from chromium import BASE, MARKS, SHOWN, ball, number, serving, until, value_of, wait_for

pytest.importorskip("playwright", reason="the browser tests need the package playwright")
pytest.importorskip("uvicorn", reason="the browser tests need restitution[web]")
pytestmark = MARKS

TABS = ("impact", "paper", "bounce", "indentation", "tapping")


class QuietHandler(SimpleHTTPRequestHandler):
    def log_message(self, *_):
        pass


class FileServer(ThreadingHTTPServer):
    # The page asks for all its files at once.
    request_queue_size = 100


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
        printed = check.message.replace("e+03", "·10³").replace("kg/m^3", "kg/m³")
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
    from restitution.explorer.states import of_case

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
          window.newest = Math.max(...[...explorer.backend.sent.values()].map((request) => request.id));
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


def test_a_failing_solve_shows_its_line_and_keeps_the_picture(opened):
    page = opened({"material.model": "maxwell", "material.maxwell_modulus": 1e6, "bulk": "bulk_modulus"})
    before = number(page, "restitution_coefficient")
    until(page, "explorer.backend.sent.size === 0")
    until(page, "explorer.tabs.impact.force.figure.visible && !explorer.tabs.impact.force.figure.stale")
    picture_of_force = "explorer.tabs.impact.force.figure.svg.outerHTML"
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


@pytest.mark.parametrize("key", ["page.tab", "page.units"])
def test_a_link_with_unknown_names_shows_the_impact(opened, key):
    page = opened({key: "constructor"})
    wait_for(page, "restitution_coefficient", rs.solve(ball()).restitution_coefficient)


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
        until(
            again, f"explorer.tabs.impact.{panel}.columns.filter(column => /^[A-D]: /.test(column.name)).length >= 8"
        )
        curves = again.evaluate(f"explorer.tabs.impact.{panel}.figure.curves.filter(column => column.letter)")
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


def test_a_note_on_the_material_is_no_doubt(opened):
    page = opened({"material.model": "fractional_zener"})
    until(page, "explorer.last.impact.notes.length > 0")
    page.wait_for_selector(".sign.note")
    doubtful = page.locator("[data-check] .sign.doubtful").count()
    summary = page.locator(".checks summary").inner_text()
    assert summary == ("No assumption is doubtful" if not doubtful else summary)
    assert (f"{doubtful} of" in summary) == bool(doubtful)


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
    numbers = rs.indent(material, rs.Parabola(2e-6), depth=rs.triangle(4e-7, 1.0))
    until(page, "explorer.last.indentation")
    assert number(page, "max_force") == pytest.approx(numbers.max_force, rel=1e-6)


@pytest.mark.parametrize("tab", TABS)
@pytest.mark.parametrize(("width", "scheme"), [(360, "dark"), (1280, "light")])
def test_no_violation_of_accessibility(opened, tab, width, scheme):
    axe = pytest.importorskip("axe_playwright_python.sync_playwright", reason="needs axe-playwright-python")
    state = {"page.tab": tab, "page.pins": "page.tab=impact&impact.velocity=0.5|page.tab=impact&impact.velocity=2"}
    page = opened(state, color_scheme=scheme, viewport={"width": width, "height": 800})
    if tab == "paper":
        page.wait_for_selector(".claims li")

    def violations():
        numbers = axe.Axe().run(page).response["violations"]
        return [(violation["id"], [node["target"] for node in violation["nodes"]]) for violation in numbers]

    assert violations() == []
    wide = page.evaluate("document.documentElement.scrollWidth - document.documentElement.clientWidth")
    assert wide <= 0
    # A failed solve leaves what it greys readable.
    page.evaluate("explorer.state.set({'material.poisson_ratio': 7}, true)")
    page.wait_for_selector("#problem:visible")
    assert violations() == []


def test_the_static_page_needs_no_server_of_ours(opened, tmp_path):
    from restitution.explorer.launch import write_static

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
        assert page.get_by_role("tab").evaluate_all("tabs => tabs.filter(tab => tab.checkVisibility()).length") == 2
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
    for part in ("material.viscosity=abc", "nothing=3", "bulk=steel"):
        assert part in words
    assert value_of(page, "material.viscosity") == 3e3
    assert opened().locator("#address-message").is_hidden()


def test_formulas_of_the_claims_are_typeset(opened):
    page = opened({"page.tab": "paper"})
    page.wait_for_selector(".claims li")
    words = page.locator(".claims ol").inner_text()
    for ascii in ("Ginf", "nu_0", "eta", "^", "e-1"):
        assert ascii not in words.replace("\n", "")
    assert page.locator(".claims sub").count() > 10
    assert page.locator(".claims sup").count() > 3


def test_a_static_page_of_a_file_says_why_it_does_not_run(browser, tmp_path):
    from restitution.explorer.launch import write_static

    write_static(tmp_path)
    page = browser.new_context().new_page()
    page.goto((tmp_path / "index.html").as_uri())
    assert "file on disk" in page.locator(".starting").inner_text()
    page.context.close()


def test_the_first_example_of_the_indentation_has_hysteresis(opened, address):
    page = opened(start=f"{address}#page.tab=indentation")
    until(page, "explorer.last.indentation")
    numbers = page.evaluate("explorer.last.indentation.numbers")
    # The work that stays is a large part of the largest force times the largest depth.
    assert numbers["work"] > 0.1 * numbers["max_force"] * numbers["max_indentation_depth"]


@pytest.mark.parametrize("width", [360, 1280, 1920])
@pytest.mark.parametrize("tab", TABS)
def test_nothing_is_wider_than_the_screen(opened, tab, width):
    page = opened({"page.tab": tab}, viewport={"width": width, "height": 900})
    until(page, "document.querySelectorAll('.plot path').length > 1")
    assert page.evaluate("document.documentElement.scrollWidth - document.documentElement.clientWidth") <= 0
