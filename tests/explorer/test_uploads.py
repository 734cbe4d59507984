"""Files that are dropped onto the page in a browser."""

import numpy as np
import pytest

import restitution as rs
from checkout import EXAMPLES
from chromium import MARKS, until, value_of, wait_for

pytest.importorskip("playwright", reason="the browser tests need the package playwright")
pytest.importorskip("uvicorn", reason="the browser tests need restitution[web]")
pytestmark = MARKS

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
