"""Results show themselves: the table of the command line, warnings, one short line, HTML."""

import json
import math
import pickle
import re
from html.parser import HTMLParser
from pathlib import Path

import numpy as np
import pytest

import restitution as rs
from cases import FAST, case_file
from commands import done
from restitution import RelaxationTable, RestitutionWarning
from restitution.identification.map import MapStatus
from restitution.impact.bounces import Ending
from restitution.result import Summary, Table, nullable, of_values, plain
from restitution.units import scaled_unit

RUBBER = rs.standard_solid(1e6, 1e7, 1e3, poisson_ratio=0.45, density=1100.0)
# Grams were meant: the contact is far too large.
HEAVY = rs.Impact(RUBBER, rs.Parabola(0.01), mass=5.0, velocity=1.0)
BALL = rs.Impact(RUBBER, rs.Parabola(0.01), mass=0.005, velocity=1.0)


def results():
    speeds = [1.0, 2.0, 4.0]
    rebounds = rs.Rebounds(
        speeds, rs.solve([rs.Impact(RUBBER, rs.Parabola(0.01), 0.005, v) for v in speeds]).restitution_coefficient,
        radius=0.01, mass=0.005, contact_time=[1e-3, 9e-4, 8e-4],
    )  # fmt: skip
    times = np.geomspace(1e-3, 1.0, 20)
    table = RelaxationTable(times, 1e6 + 2e6 * np.exp(-times / 0.05), "shear")
    depth = rs.triangle(1e-6, 1.0)
    return {
        "impact": rs.solve(HEAVY),
        "array": rs.solve(rs.Impact(RUBBER, rs.Parabola(0.01), 0.005, np.array([0.1, 1.0]))),
        "list": rs.solve([BALL, HEAVY]),
        "indentation": rs.indent(RUBBER, rs.Parabola(2.5e-6), depth=depth),
        "bounces": rs.bounces(rs.drop(rs.Body(RUBBER, 0.01), rs.Body(None), 0.5), max_bounces=40),
        "calibration": rs.calibrate(BALL, "lammps-viscoelastic", (0.1, 1.0), points=3),
        "surrogate": rs.surrogate(BALL, (0.5, 1.0), 1e-3),
        "resilience": rs.resilience(rs.Material(RUBBER.shear, math.inf), "ASTM D7121", base="half-space"),
        "identification": rs.identify(table, rs.standard_solid, fixed={"poisson_ratio": 0.5}),
        "moduli": rs.effective_moduli(rebounds),
    }


@pytest.fixture(scope="module")
def shown():
    with pytest.warns(RestitutionWarning):
        return results()


class Tags(HTMLParser):
    """Balance of tags, and the text between them."""

    def __init__(self):
        super().__init__()
        self.open, self.cells = [], []

    def handle_starttag(self, tag, attrs):
        if tag != "br":
            self.open.append(tag)

    def handle_endtag(self, tag):
        assert self.open.pop() == tag

    def handle_data(self, data):
        self.cells.append(data)


def test_print_shows_the_table_of_the_command_line_and_its_warnings(tmp_path: Path):
    material = f'{FAST}density = "1100 kg/m3"'
    case_file(tmp_path / "ball.toml", body='mass = "5 kg"\nradius = "10 mm"', material=material)
    answer = done("solve", str(tmp_path / "ball.toml"))
    lines = str(rs.solve(HEAVY)).splitlines()
    printed = answer.stdout.splitlines()
    # The title is that of the file, and the last line describes the bodies of the file.
    assert lines[1 : len(printed) - 1] == printed[1:-1]
    assert lines[len(printed) - 1 :] == answer.stderr.splitlines()
    assert any(line.startswith("warning: small strain") for line in lines)


KINDS = ("impact", "array", "list", "indentation", "bounces", "calibration", "surrogate", "resilience",
         "identification", "moduli")  # fmt: skip


@pytest.mark.parametrize("kind", KINDS)
def test_every_result_shows_itself_with_its_warnings(shown, kind):
    item = shown[kind]
    text, page = str(item), item._repr_html_()
    parser = Tags()
    parser.feed(page)
    parser.close()
    assert parser.open == []
    cells = "\n".join(parser.cells)
    assert item.summary().title in cells
    for line in getattr(item, "warnings", ()):
        assert f"warning: {line}" in text
        assert line in cells
    for row in [] if item.summary().table is None else item.summary().table.rows:
        assert all(cell in text for word in row for cell in word.split())
        assert all(cell in parser.cells for cell in row if cell)
    short = repr(item)
    assert "\n" not in short
    assert len(short) < 250
    count = len(getattr(item, "warnings", ()))
    assert (f"; {count} warning" in short) == (count > 0)


def test_print_is_whole_in_a_notebook(shown, monkeypatch):
    """There rich displays a table at once, whatever its file is."""
    expected = str(shown["impact"])
    monkeypatch.setattr("rich.console._is_jupyter", lambda: True)
    assert str(shown["impact"]) == expected


def test_an_array_shows_its_range(shown):
    result = shown["array"]
    row = next(row for row in result.summary().table.rows if row[1] == "T")
    factor, unit = scaled_unit(result.contact_time, "s")
    assert float(row[2]) == pytest.approx(factor * min(result.contact_time), rel=1e-5)
    assert float(row[3]) == pytest.approx(factor * max(result.contact_time), rel=1e-5)
    assert row[4] == unit
    assert "2 SEPARATED" in str(result)


def test_a_body_that_stays_shows_why():
    stays = rs.solve(rs.Impact(RUBBER, rs.Parabola(0.01), 0.005, 0.1, external_force=50.0))
    assert stays.status.name == "CAPTURED"
    assert f"warning: {stays.status.message}" in str(stays)
    assert "inf" in str(stays)


def test_text_of_others_is_no_html():
    summary = Summary("<b>a & b", Table(("<x>",), [("<script>",)]), ["1 < 2"], "<pre>", ["<w>"])
    assert not re.search(r"<script|<x>|<w>|<b>a", summary.html)
    assert all(part in summary.html for part in ("&lt;script&gt;", "1 &lt; 2", "&lt;w&gt;"))


def test_numbers_that_are_not_finite_have_no_unit():
    table = of_values([("a", "a", math.nan, "s"), ("b", "b", math.inf, "Pa"), ("c", "c", 2.5e-4, "m")])
    assert [row[2:] for row in table.rows] == [("-", ""), ("inf", ""), ("250", "µm")]


@pytest.mark.parametrize("right", ["", "second of all"])
@pytest.mark.parametrize("words", ["", "a longer text with blanks that is broken over lines, as it is wider than all"])
def test_a_long_table_has_the_lines_of_its_layout_by_rich(right, words):
    random = np.random.default_rng(1)
    cells = 10.0 ** random.uniform(-9.0, 9.0, (520, 3))
    rows = [tuple(f"{x:.4g}" if x > 1e-6 else "-" for x in row) for row in cells]
    rows[260] = (rows[260][0], f"{rows[260][1]} {words}".strip(), rows[260][2])
    table = Table(("first", "second of all", "a third column [unit]"), rows, right)
    for width in (100, 140):
        assert table.text(width) == table._layout(rows, width)


@pytest.mark.parametrize("count", [3, 520])
def test_a_table_of_many_columns_loses_no_cell(count):
    random = np.random.default_rng(2)
    rows = [tuple(f"{x:.6f}(75)" for x in row) for row in random.uniform(1.0, 9.0, (count, 12))]
    columns = tuple(f"column {n} [{unit}]" for n, unit in enumerate(["m/s", "MPa", "krad/s"] * 4))
    words = Table(columns, rows).text(80).split()
    assert words[-12 * count :] == [cell for row in rows for cell in row]
    assert sorted(words[: -12 * count]) == sorted(["─" * (len(max(words, key=len))), *" ".join(columns).split()])


@pytest.mark.parametrize("kind", [rs.Status, rs.IndentationStatus, MapStatus, Ending])
def test_an_outcome_is_its_code_and_carries_its_message(kind):
    for outcome in kind:
        assert kind(outcome.value) is outcome
        assert pickle.loads(pickle.dumps(outcome)) is outcome
        assert outcome.message or outcome is MapStatus.FITTED


@pytest.mark.filterwarnings("ignore::restitution.errors.RestitutionWarning")
def test_results_are_plain_numbers_by_name():
    velocity = np.array([0.5, 1.0])
    many = rs.solve(rs.Impact(RUBBER, rs.Parabola(0.01), 0.005, velocity))
    series = rs.bounces(rs.Impact(RUBBER, rs.Parabola(0.01), 0.005, 1.0))
    surrogate = rs.surrogate(rs.Impact(RUBBER, rs.Parabola(0.01), 0.005, 1.0), velocity=(0.5, 1.0), rtol=1e-3)
    for result, name in ((many, "contact_time"), (series, "touch_time"), (surrogate, "velocity")):
        content = json.loads(json.dumps(plain(result, nullable), allow_nan=False))
        stated = [None if math.isinf(number) else number for number in np.asarray(getattr(result, name)).tolist()]
        assert content[name] == stated
        assert content["warnings"] == list(result.warnings)
