"""The pictures of the page in a browser, and their files."""

import re
import xml.etree.ElementTree as ET

import matplotlib.pyplot as plt
import numpy as np
import pytest

import restitution as rs
from chromium import MARKS, ball, until, value_of, wait_for

pytest.importorskip("playwright", reason="the browser tests need the package playwright")
pytest.importorskip("uvicorn", reason="the browser tests need restitution[web]")
pytestmark = MARKS


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
  const { figure } = explorer.tabs.impact[name];
  const at = (...names) => (node) => figure.values(...names.map((name) => Number(node.getAttribute(name))));
  const [line] = [...figure.svg.querySelectorAll(".cursor line")].map(at("x1", "y1"));
  return { line: line ? line[0] : null, dots: [...figure.svg.querySelectorAll(".cursor circle")].map(at("cx", "cy")) };
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
    places = {
        "force": [time, [[time, force]]],
        "loop": [None, [[depth, force]]],
        "energy": [time, [[time, energy] for energy in energies]],
    }
    # Each picture is out of sight before, and stands still when it comes into sight.
    page.get_by_label("Time of the slow motion").fill(str(1000 * share))
    assert page.evaluate("explorer.tabs.impact.clock.time") == pytest.approx(t, rel=1e-9)
    for name, (line, dots) in places.items():
        page.locator(f"[data-panel={name}] .plot").scroll_into_view_if_needed()
        until(page, f"explorer.tabs.impact.{name}.figure.visible && !explorer.tabs.impact.{name}.figure.stale")
        cursor = page.evaluate(CURSOR, name)
        assert cursor["line"] == (None if line is None else pytest.approx(line, rel=1e-5))
        # Straight lines between 121 points.
        peak = [1.0, result.energy[0] * 1e3 if name == "energy" else result.max_force]
        np.testing.assert_allclose(cursor["dots"][: len(dots)] / np.array(peak), dots / np.array(peak), atol=1e-3)


def test_the_map_leads_to_the_place_that_is_pressed(opened):
    page = opened({"page.tab": "paper", "entry": "groups", "groups.nu": 0.45})
    over = page.locator("[data-panel=figure-3] .over")
    over.click(position={"x": 60, "y": 40})
    p2, p3 = (value_of(page, f"groups.{name}") for name in ("p2", "p3"))
    box = over.bounding_box()
    assert np.log10(p2) == pytest.approx(-3 + 4 * 60 / box["width"], abs=0.02)
    assert np.log10(p3) == pytest.approx(2 - 4 * 40 / box["height"], abs=0.02)
    e = rs.standard_solid_restitution(0.45, p2, p3)
    until(page, f"Math.abs(explorer.numbers.restitution_coefficient - {float(e)!r}) < 1e-7")


def pointed(page, panel, x, y):
    """Put the pointer on the values x, y of a picture, and return what it says there."""
    page.locator(f"[data-panel={panel}] .plot").scroll_into_view_if_needed()
    figure = f"explorer.tabs.impact.{panel}.figure"
    until(page, f"{figure}.x && {figure}.visible && !{figure}.stale")
    left, top = page.evaluate(f"{figure}.place({x!r}, {y!r})")
    box = page.locator(f"[data-panel={panel}] .over").bounding_box()
    page.mouse.move(box["x"] + left, box["y"] + top)
    return page.locator(f"[data-panel={panel}] .hover").text_content()


@pytest.mark.parametrize("share", [0.2, 0.6, 0.85])
def test_the_pointer_reads_the_nearest_curve(opened, share):
    page = opened({"page.units": "mm-g-ms"})
    result = rs.solve(ball())
    time = share * float(result.contact_time)
    force = float(result.sample(np.array([time])).force[0])
    # The pointer is beside the curve; what is read lies on it.
    words = pointed(page, "force", 1e3 * time, 1.02 * force)
    t, f = (float(part) for part in re.fullmatch(r"t = (\S+) ms, F = (\S+) N", words).groups())
    assert f == pytest.approx(float(result.sample(np.array([1e-3 * t])).force[0]), rel=5e-3)
    assert 1e3 * time == pytest.approx(t, rel=0.05)
    # The plane of the paper says e besides.
    words = pointed(page, "map", 0.3, 3.0)
    p2, p3, e = (float(part) for part in re.fullmatch(r"p₂ = (\S+), p₃ = (\S+), e = (\S+)", words).groups())
    assert e == pytest.approx(float(rs.standard_solid_restitution(0.49, p2, p3)), abs=2e-3)
    page.mouse.move(1, 1)
    assert page.locator("[data-panel=map] .hover *").count() == 0


def dragged(page, panel, start, end):
    _ = pointed(page, panel, *start)
    page.mouse.down()
    _ = pointed(page, panel, *end)
    page.mouse.up()


def test_a_drag_shows_a_part_and_two_clicks_the_whole(opened):
    page = opened({"page.units": "mm-g-ms"})
    shown = "explorer.tabs.impact.force.figure.shown"
    until(page, "explorer.tabs.impact.force.figure.ranges")
    whole = page.evaluate(shown)
    moment = page.evaluate("explorer.tabs.impact.clock.time")
    dragged(page, "force", (0.2, 3.0), (0.6, 8.0))
    part = page.evaluate(shown)
    assert part["x"] == pytest.approx([0.2, 0.6], abs=2e-3)
    assert part["y"] == pytest.approx([3.0, 8.0], abs=2e-2)
    # Ticks and the curve are those of the part, in other units too, and no time was picked.
    assert page.evaluate("explorer.tabs.impact.force.figure.x.ticks.every((tick) => tick >= 0.199 && tick <= 0.601)")
    assert page.evaluate("explorer.tabs.impact.clock.time") == moment
    page.locator("#units").select_option("AFM")
    assert page.evaluate(shown)["x"] == pytest.approx([2e-4, 6e-4], rel=1e-2)
    page.locator("#units").select_option("mm-g-ms")
    # A drag to the side alone keeps the other range.
    dragged(page, "force", (0.3, 5.0), (0.5, 5.0))
    part = page.evaluate(shown)
    assert part["x"] == pytest.approx([0.3, 0.5], abs=2e-3)
    assert part["y"] == pytest.approx([3.0, 8.0], abs=2e-2)
    page.locator("[data-panel=force] .over").dblclick()
    assert page.evaluate(shown) == whole
    page.wait_for_timeout(400)
    assert page.evaluate("explorer.tabs.impact.clock.time") == moment
    # A click goes to its time.
    _ = pointed(page, "force", 0.25, 5.0)
    page.mouse.down()
    page.mouse.up()
    assert page.evaluate("explorer.tabs.impact.clock.time") == pytest.approx(0.25e-3, rel=1e-2)


def test_ranges_can_be_typed(opened):
    page = opened({"page.units": "mm-g-ms"})
    shown = "explorer.tabs.impact.moduli.figure.shown"
    page.locator("[data-panel=moduli] .plot").scroll_into_view_if_needed()
    until(page, "!explorer.tabs.impact.moduli.figure.stale")
    whole = page.evaluate(shown)
    page.locator("[data-panel=moduli] summary[aria-label^=Range]").click()
    low = page.locator("[data-panel=moduli]").get_by_label("Across, from")
    # The browser announces after the click that the box is open.
    until(page, "document.querySelector('[data-panel=moduli] [aria-label=\"Across, from\"]').value !== ''")
    assert float(low.input_value()) == pytest.approx(whole["x"][0], rel=1e-4)
    for text, good in (("1,5", True), ("-1", False), ("1e9", False), ("a", False)):
        low.fill(text)
        low.press("Tab")
        assert low.get_attribute("aria-invalid") == str(not good).lower()
        assert page.evaluate(shown)["x"] == pytest.approx([1.5, whole["x"][1]], rel=1e-4)
    page.get_by_role("button", name="The whole picture").click()
    assert page.evaluate(shown) == whole


POINTS = [(0.05, 0.44), (0.4, 0.3), (3.0, 0.29)]


def test_own_points_stand_on_the_curve(opened, tmp_path):
    from restitution.plot.rebounds import distance

    table = "velocity [cm/s],e,sd_e\n" + "".join(f"{100 * v},{e},0.01\n" for v, e in POINTS)
    page = opened()
    until(page, "explorer.last.velocity")
    assert "Drop, open or paste" in page.locator("[data-panel=velocity]").inner_text()
    page.evaluate("""(text) => {
      const clipboardData = new DataTransfer();
      clipboardData.setData("text/plain", text);
      document.body.dispatchEvent(new ClipboardEvent("paste", { clipboardData, bubbles: true }));
    }""", table)  # fmt: skip
    until(page, "explorer.tabs.impact.velocity.figure.marks.length === 4")
    drawn = page.evaluate(
        "explorer.tabs.impact.velocity.figure.marks.slice(0, 3).map(({ x, y, spread }) => [x, y, spread])"
    )
    assert drawn == [pytest.approx([v, e, 0.01]) for v, e in POINTS]
    path = tmp_path / "points.csv"
    path.write_text(table)
    size = distance(ball(), rs.read_points(path))
    words = page.locator("[data-panel=velocity] .note:visible").inner_text()
    result = re.fullmatch(r"3 measured points; the root .* e is about (\S+)\.\s*Remove", words)
    # Straight lines between the 61 points of the curve, and two digits.
    assert float(result[1]) == pytest.approx(size, rel=0.05)
    # A link has them; a pinned setting has none of its own.
    again = opened(start=page.url)
    until(again, "explorer.tabs.impact.velocity.figure.marks.length === 4")
    again.get_by_role("button", name="Pin this setting").click()
    assert "points" not in value_of(again, "page.pins")
    assert "measured velocity [m/s]" in saved_as(again, "[data-panel=velocity]", "CSV", tmp_path).read_text()
    again.get_by_role("button", name="Remove", exact=True).first.click()
    until(again, "explorer.tabs.impact.velocity.figure.marks.length === 1")
    assert "page.points" not in again.url


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
    over = page.locator("[data-panel=map] .over")
    over.scroll_into_view_if_needed()
    until(page, f"(({{visible, stale, curves}}) => visible && !stale && curves.length)({MAP})")
    box = over.bounding_box()
    page.touchscreen.tap(box["x"] + 0.5 * box["width"], box["y"] + 0.25 * box["height"])
    until(
        page,
        "Math.abs(Math.log10(explorer.numbers.p3) - 1) < 0.05 && Math.abs(Math.log10(explorer.numbers.p2) + 1) < 0.05",
    )


def test_the_labels_have_one_size_on_all_screens(opened):
    sizes = []
    for ratio in (1, 2):
        page = opened(device_scale_factor=ratio)
        until(page, "document.querySelector('[data-panel=force] .plot text')")
        texts = "[...document.querySelectorAll('[data-panel=force] .plot text')]"
        sizes.append(page.evaluate(f"{texts}.map(node => parseFloat(getComputedStyle(node).fontSize))"))
    assert sizes[0] == sizes[1]
    assert min(sizes[0]) >= 12


def saved_as(page, panel, words, folder):
    """Save a picture by its menu, and return the path of the file."""
    page.locator(f"{panel} summary[aria-label^=Save]").click()
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


def test_the_picture_of_a_file_is_the_one_on_the_screen(opened, tmp_path):
    page = opened({"page.pins": "page.tab=impact&impact.velocity=0.5"}, color_scheme="dark")
    until(page, "explorer.tabs.impact.energy.figure.curves.length === 4")
    page.locator("[data-panel=energy] .plot").scroll_into_view_if_needed()
    until(page, "!explorer.tabs.impact.energy.figure.stale")
    drawn = page.evaluate(
        "[...explorer.tabs.impact.energy.figure.svg.querySelectorAll('path')].map(node => [node.getAttribute('d'), node.getAttribute('stroke')])"
    )
    root = ET.parse(saved_as(page, "[data-panel=energy]", "SVG", tmp_path)).getroot()
    paths = [[node.get("d"), node.get("stroke")] for node in root.iter(f"{SVG}path")]
    # The samples of the legend come before the picture.
    assert paths[-len(drawn) :] == drawn
    assert len(paths) == len(drawn) + 3
    words = [node.text for node in root.iter(f"{SVG}text")]
    assert words[:4] == ["Energies over time", "kinetic", "stored", "dissipated"]
    assert "A" in words
    assert [node.text for node in root.iter(f"{SVG}title")] == ["A", "dissipated", "stored", "kinetic"]
    # The cursor of time is no part of it.
    assert not [node for node in root.iter() if node.get("class") == "cursor"]


def scale_of(labels, places, log):
    """Value at a place [pixels] of an axis, from its labels."""
    powers = str.maketrans("⁻⁰¹²³⁴⁵⁶⁷⁸⁹", "-0123456789")
    values = [
        float(label.replace("10", "1e", 1).translate(powers)) if label[-1] in "⁻⁰¹²³⁴⁵⁶⁷⁸⁹" else float(label)
        for label in labels
    ]
    slope, start = np.polyfit(places, np.log10(values) if log else values, 1)
    return lambda place: 10 ** (slope * place + start) if log else slope * place + start


@pytest.mark.parametrize(
    ("panel", "logs"), [("force", (False, False)), ("velocity", (True, False)), ("moduli", (True, True))]
)
def test_curves_stand_where_the_labels_of_the_axes_say(opened, tmp_path, panel, logs):
    page = opened({"page.units": "mm-g-ms"})
    until(page, f"explorer.tabs.impact.{panel}.figure.curves.some(curve => curve.colour === 'accent')")
    curve = page.evaluate(f"explorer.tabs.impact.{panel}.figure.curves.find(curve => curve.colour === 'accent')")
    page.locator(f"[data-panel={panel}] .plot").scroll_into_view_if_needed()
    until(page, f"!explorer.tabs.impact.{panel}.figure.stale")
    root = ET.parse(saved_as(page, f"[data-panel={panel}]", "SVG", tmp_path)).getroot()
    plot = root.findall(f"{SVG}svg")[-1]
    texts = [node for node in plot.find(f"{SVG}g") if node.tag == f"{SVG}text" and not node.get("transform")]
    # The title of the x axis is the last one.
    across = [node for node in texts if node.get("text-anchor") == "middle"][:-1]
    up = [node for node in texts if node.get("text-anchor") == "end"]
    x = scale_of([node.text for node in across], [float(node.get("x")) for node in across], logs[0])
    # The base line of a label is a third of its size below its middle.
    y = scale_of(
        [node.text for node in up],
        [float(node.get("y")) - 0.34 * float(node.get("font-size")) for node in up],
        logs[1],
    )
    drawn = [node for node in plot.find(f"{SVG}svg") if node[0].text == curve.get("label", "")][-1]
    places = points_of(drawn)
    kept = [n for n, value in enumerate(curve["y"]) if value is not None]
    for shown, values, log in ((x(places[:, 0]), curve["x"], logs[0]), (y(places[:, 1]), curve["y"], logs[1])):
        values = np.array([values[n] for n in kept], dtype=float)
        # Pixels have two digits.
        scale = np.abs(values) if log else np.abs(values).max()
        np.testing.assert_allclose((shown - values) / scale, 0.0, atol=1e-3)


def scenes_of(path):
    """The whole body and the contact, of a slow motion saved as SVG."""
    return ET.parse(path).getroot().findall(f"{SVG}svg")


def points_of(path):
    """Points of a path without arcs."""
    return np.array(re.findall(r"[ML](-?[\d.]+) (-?[\d.]+)", path.get("d")), dtype=float)


def enlarged(scene):
    """The enlarged contact in metres: outline of the body (x, depth), and the x of the ends of the contact."""
    parts = list(scene)
    paths = [part for part in parts if part.tag == f"{SVG}path"]
    bar = next(n for n, part in enumerate(parts) if part.tag == f"{SVG}path" and part.get("d").startswith("M8 "))
    length, unit = parts[bar + 1].text.split()
    left, right = points_of(parts[bar])[1:3, 0]
    scale = float(length) * {"mm": 1e-3, "µm": 1e-6}[unit] / (right - left)
    stretch = next((float(part.text.split()[-1]) for part in parts if "heights" in (part.text or "")), 1.0)
    (ground,) = [part for part in paths if part.get("stroke-dasharray")]
    middle = float(scene.get("width")) / 2
    # The last two points close the outline above the picture.
    body = points_of([part for part in paths if part.get("fill") != "none" and len(points_of(part)) > 100][-1])[:-2]
    body = body[body[:, 1] > -10.0]
    edges = [points_of(part) for part in paths if part.get("stroke-width") and len(points_of(part)) == 2]
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
    x, cursor, ends, scale = enlarged(contact)
    # Rounded to 0.01 pixels; a straight line between 61 points of the body and 121 times is off by a few times that.
    assert x.size > 200
    curvature = 1 / (0.05 if state else 0.01)
    assert cursor == pytest.approx(depth - curvature * x**2 / 2, abs=0.1 * scale)
    widest = profile.semi_axes(mean)[0] if state else mean
    assert sorted(ends) == pytest.approx([-widest, widest], abs=0.1 * scale)
    # The whole body: its half-axes, and its lowest point under the ground.
    middle, across, up = (float(whole.find(f"{SVG}ellipse").get(name)) for name in ("cy", "rx", "ry"))
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


@pytest.mark.parametrize("share", [0.1, 0.95])
def test_a_body_that_comes_at_an_angle_moves_sideways_and_turns(opened, tmp_path, share):
    """The way to the side over that upwards is the tangent of the angle; a radius turns by spin times time."""
    spin = 40.0
    page = opened({"motion": "oblique", "impact.friction": 0.4, "impact.angle": 0.5, "impact.spin": spin})
    result = rs.solve(rs.vary(ball(), {"friction": 0.4, "angle": 0.5, "spin": spin}), rtol=1e-4)
    wait_for(page, "tangential_restitution_coefficient", result.tangential_restitution_coefficient, 1e-6)
    page.evaluate(f"explorer.tabs.impact.clock.to({share})")
    whole, _ = scenes_of(saved_as(page, ".stage", "SVG", tmp_path))
    left, centre, radius = (float(whole.find(f"{SVG}ellipse[@opacity='1']").get(name)) for name in ("cx", "cy", "rx"))
    lift = float(whole.find(f"{SVG}rect").get("y")) - centre - radius
    moved = left - 0.5 * float(whole.get("width"))
    before = share < 0.2
    tangent = -np.tan(0.5) if before else np.tan(result.rebound_angle)
    assert moved == pytest.approx(lift * tangent, abs=0.05)
    # The time of the flight, for a ball of 10 mm, at the velocity of the picture.
    time = lift / radius * 0.01 / (1.0 if before else result.rebound_velocity)
    angle = -spin * time if before else result.rebound_spin * time
    mark = [points_of(part) for part in whole.findall(f"{SVG}path") if len(points_of(part)) == 2]
    (mark,) = [line for line in mark if abs(line[0, 0] - left) < 0.02 and abs(line[0, 1] - centre) < 0.02]
    turned = (mark[1] - mark[0]) / radius
    assert turned == pytest.approx([-np.sin(angle), -np.cos(angle)], abs=2e-3)


# Radii of the first and the last point of each line of 25 points, which only rings of the contact have.
RINGS = """() => {
  const { zoom, prepared } = explorer.tabs.impact.ball;
  const { width } = zoom.size;
  const places = (path) => path.getAttribute("d").split(/[ML]/).slice(1).map((pair) => Number(pair.split(" ")[0]));
  return [...zoom.svg.querySelectorAll("path")].map(places).filter(({ length }) => length === 25)
    .map((line) => [line[0], line.at(-1)].map((x) => ((x - width / 2) * 2 * prepared.extent) / width));
}"""
BEAD = {
    "material.equilibrium_modulus": 1e6, "material.branch_modulus": 4e6, "material.viscosity": 40.0,
    "material.poisson_ratio": 0.5, "body.radius": 1e-5, "body.mass": 4.6e-12, "impact.velocity": 0.4,
    "sticking": "stress", "adhesion.stress": 1e6,
}  # fmt: skip


def test_the_enlarged_contact_shows_where_it_sticks_slips_or_attracts(opened):
    soft = rs.standard_solid(1e6, 4e6, 40.0, poisson_ratio=0.5)
    bead = rs.Impact(soft, rs.Parabola(1e-5), mass=4.6e-12, velocity=0.4, adhesion=rs.Adhesion(0.05, stress=1e6))
    oblique = rs.vary(ball(), {"friction": 0.4, "angle": 0.5})
    for state, impact, names in (
        (BEAD, bead, ("contact_radius", "zone_radius")),
        ({"motion": "oblique", "impact.friction": 0.4, "impact.angle": 0.5}, oblique, ("stick_radius", "contact_radius")),
    ):  # fmt: skip
        page = opened(state)
        result = rs.solve(impact, rtol=1e-4)
        wait_for(page, "restitution_coefficient", result.restitution_coefficient, 1e-6)
        page.evaluate("explorer.tabs.impact.clock.to(0.5)")
        columns = result._columns(n_points=121)
        time = 0.5 * columns["time"][-1]
        inner, outer = (float(np.interp(time, columns["time"], columns[name])) for name in names)
        assert 0.0 < inner < outer
        rings = page.evaluate(RINGS)
        expected = [[-inner, -outer], [inner, outer]]
        if "stick_radius" in names:
            expected = [[0.0, -inner], [0.0, inner], *expected]
        np.testing.assert_allclose(rings, expected, rtol=0, atol=2e-3 * outer)
        assert "orange" in page.locator(".scenes .note").inner_text().lower()


def test_a_captured_bead_stays(opened):
    page = opened(BEAD | {"impact.velocity": 0.2})
    until(page, "explorer.last.impact.status.name === 'CAPTURED'")
    page.evaluate("explorer.tabs.impact.clock.to(0.95)")
    assert page.locator(".readout").inner_text().endswith("captured")
    ends = page.evaluate(RINGS)
    end = page.evaluate(
        "['contact_radius', 'zone_radius'].map((name) => explorer.last.impact.curves.history[name].at(-1))"
    )
    np.testing.assert_allclose(ends[1], end, rtol=0, atol=2e-3 * end[1])


def test_the_slow_motion_of_a_pyramid_says_what_is_not_known(opened, tmp_path):
    page = opened({"profile.type": "pyramid", "profile.face_angle": 1.2})
    result = rs.solve(rs.Impact(ball().material, rs.Pyramid(1.2), mass=0.005, velocity=1.0))
    wait_for(page, "restitution_coefficient", result.restitution_coefficient)
    assert "surface around a pyramid is not known" in page.locator(".scenes .note").inner_text()
    page.evaluate("explorer.tabs.impact.clock.to(0.5)")
    _, contact = scenes_of(saved_as(page, ".stage", "SVG", tmp_path))
    x, cursor, ends, scale = enlarged(contact)
    depth = float(result.sample(np.array([0.5 * result.contact_time])).indentation_depth[0])
    assert cursor == pytest.approx(depth - np.abs(x) / np.tan(1.2), abs=0.1 * scale)
    assert ends.size == 0


def test_a_body_that_stays_has_a_line_in_place_of_the_slow_motion(opened):
    page = opened({"material.model": "maxwell", "material.viscosity": 1.0, "bulk": "bulk_modulus"})
    until(page, "explorer.last.impact.curves.history === null")
    assert "no rebound to show" in page.locator(".readout").inner_text()
    for part in (".play", ".stage summary", ".stage svg"):
        assert page.locator(part).first.is_hidden()
