"""Files that are dropped onto the page: tables of materials and case files, good and bad."""

import base64
import json
from io import BytesIO
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import restitution as rs
from checkout import EXAMPLES
from refusals import in_one_line
from restitution.case.impact import CaseFile
from restitution.explorer import answers, dropped_files
from restitution.explorer.downloads import download
from restitution.explorer.inputs import settled

TIMES = np.geomspace(1e-5, 1e2, 40)
OMEGA = np.geomspace(1e-2, 1e5, 40)
SERIES = rs.PronySeries(3e6, [9e6, 4e6], [1e-3, 0.3])


def table(*columns: np.ndarray, names: str, units: str) -> str:
    rows = [",".join(f"{value:.9g}" for value in row) for row in zip(*columns, strict=True)]
    return "\n".join([names, units, *rows]) + "\n"


DMA = table(
    OMEGA, 1e-6 * SERIES.storage_modulus(OMEGA), 1e-6 * SERIES.loss_modulus(OMEGA), names="omega,G',G''", units="rad/s,MPa,MPa"
)  # fmt: skip
RELAXATION = table(TIMES, 1e-6 * SERIES.relaxation_modulus(TIMES), names="t,G", units="s,MPa")


def dropped(
    content: str | bytes, name: str = "data.csv", *others: tuple[str, bytes], **further: Any
) -> dict[str, Any]:
    content = content.encode("utf-8", "replace") if isinstance(content, str) else content
    files = [{"name": title, "data": base64.b64encode(data).decode()} for title, data in ((name, content), *others)]
    return dropped_files.read({"files": files, "state": {"bulk": "incompressible"}} | further)


@pytest.mark.parametrize("text", [DMA, RELAXATION], ids=["dynamic", "relaxation"])
def test_a_table_becomes_a_series_that_fits_it(text):
    page = {"bulk": "incompressible", "entry": "groups"}
    answer = dropped(text, state=page)
    state = settled(page | answer["state"])
    series = rs.PronySeries(
        *(state[f"material.shear.{name}"] for name in ("equilibrium_modulus", "branch_moduli", "relaxation_times"))
    )
    # The fit is good to 2e-3 of the modulus at each time.
    np.testing.assert_allclose(series.relaxation_modulus(TIMES[5:]), SERIES.relaxation_modulus(TIMES[5:]), rtol=1e-2)
    assert answer["words"].startswith("data.csv: data fitted by")
    assert "/" not in answer["words"]


def test_creep_becomes_the_series_whose_compliance_fits_it():
    x = 0.5e-3 * np.arange(1.0, 3001.0)
    for times in (TIMES, x):
        text = table(times, 1e6 * SERIES.creep_compliance(times), names="t,J", units="s,1/MPa")
        state = settled(dropped(text)["state"])
        series = rs.PronySeries(
            *(state[f"material.shear.{name}"] for name in ("equilibrium_modulus", "branch_moduli", "relaxation_times"))
        )
        # Nine digits of the file, a misfit of 2e-3, and half a decade at each end, which the data do not hold.
        inside = times[(times > 4.0 * times[0]) & (times < 0.25 * times[-1])]
        np.testing.assert_allclose(series.creep_compliance(inside), SERIES.creep_compliance(inside), rtol=1e-2)


def test_a_ramp_asks_for_its_frequency_and_has_room_temperature():
    kelvin = np.arange(220.0, 330.0, 2.0)
    reduced = rs.WLF(240.0, 17.44, 51.6, temperature_range=(200.0, 400.0)).factor(kelvin)
    columns = kelvin - 273.15, 1e-6 * SERIES.storage_modulus(reduced), 1e-6 * SERIES.loss_modulus(reduced)
    text = table(*columns, names="T,G',G''", units="°C,MPa,MPa")
    assert [question["key"] for question in dropped(text)["questions"]] == ["frequency", "temperature"]
    warm, hot = (dropped(text, answers={"frequency": "1 Hz"} | more) for more in ({}, {"temperature": "40 degC"}))
    assert any("moduli are those at 20 °C" in note for note in warm["notes"])
    assert any("universal constants" in note for note in warm["notes"])
    times = [settled(answer["state"])["material.shear.relaxation_times"] for answer in (warm, hot)]
    assert times[1][0] < times[0][0]


@pytest.mark.parametrize("dynamic", [False, True])
def test_a_long_table_has_fewer_rows_evenly_over_the_logarithm(dynamic):
    # Evenly over time or frequency, as instruments write them: most rows are in the last decade.
    x = 0.5e-3 * np.arange(1.0, 20_001.0) * (1e3 if dynamic else 1.0)
    moduli = [SERIES.storage_modulus(x), SERIES.loss_modulus(x)] if dynamic else [SERIES.relaxation_modulus(x)]
    names, units = ("omega,G',G''", "rad/s,Pa,Pa") if dynamic else ("t,G", "s,Pa")
    answer = dropped(table(x, *moduli, names=names, units=units))
    (note,) = (note for note in answer["notes"] if "rows are used" in note)
    used = int(note.split()[1])
    # The first decades have fewer rows than wanted.
    assert 500 < used < 1000
    assert note.startswith(f"data.csv: {used} of its 20000 rows are used")
    state = settled(answer["state"])
    series = rs.PronySeries(
        *(state[f"material.shear.{name}"] for name in ("equilibrium_modulus", "branch_moduli", "relaxation_times"))
    )
    omega = np.geomspace(x[0], x[-1], 30) if dynamic else 1.0 / np.geomspace(4.0 * x[0], x[-1], 30)
    np.testing.assert_allclose(series.storage_modulus(omega), SERIES.storage_modulus(omega), rtol=1e-2)
    short = table(x[:999], *(column[:999] for column in moduli), names=names, units=units)
    assert not [note for note in dropped(short)["notes"] if "rows are used" in note]


def test_a_dropped_table_gives_the_restitution_of_the_command_line(tmp_path):
    state = {"material.poisson_ratio": 0.45, "bulk": "poisson_ratio"}
    answer = dropped(DMA, state=state)
    (tmp_path / "data.csv").write_text(DMA)
    text = download({"what": "case", "state": {}})["text"]
    content = (
        text[: text.index("[material]")] + "[material]\nfile = 'data.csv'\npoisson_ratio = 0.45\ndensity = 1100.0\n"
    )
    (tmp_path / "ball.toml").write_text(content)
    expected = rs.read_case(tmp_path / "ball.toml").solve()
    numbers = answers.impact(state | answer["state"])["numbers"]
    assert numbers["restitution_coefficient"] == pytest.approx(expected.restitution_coefficient, rel=1e-9)


def test_the_deformation_of_a_table_counts():
    text = RELAXATION.replace("t,G", "t,modulus")
    state = {"bulk": "poisson_ratio", "material.poisson_ratio": 0.5}
    shear, tension = (
        dropped(text, state=state, answers={"deformation": kind})["state"] for kind in ("shear", "tension")
    )
    # E = 3 G where incompressible.
    key = "material.shear.equilibrium_modulus"
    assert tension[key] == pytest.approx(shear[key] / 3.0, rel=1e-9)
    with pytest.raises(rs.InputError, match="deformation"):
        dropped(text, answers={"deformation": "torsion"})


@pytest.mark.parametrize(
    "text", ["", "x", "a,b\n1,2\n", "t,E\ns,MPa\n1,x\n", "t,E\ns,MPa\n1,1\n", "t,E\nfoo,MPa\n1,1\n", "\0", "\ud800"]
)
def test_a_bad_table_is_one_line_that_names_it(text):
    line = str(in_one_line(lambda: dropped(text, "my data.csv")))
    assert line.startswith("my data.csv: ")
    assert "/" not in line.replace("my data.csv", "")


def test_a_case_file_becomes_its_state(tmp_path):
    state = {"material.model": "kelvin_voigt", "impact.velocity": 0.25, "profile.type": "sphere"}
    text = download({"what": "case", "state": state})["text"]
    answer = dropped(text, "my.toml")
    assert settled(answer["state"])["material.model"] == "kelvin_voigt"
    numbers, expected = (answers.impact(content)["numbers"] for content in (answer["state"], state))
    assert numbers == expected


FILES = [
    "[material]\nfile = '{path}'\n", "[profile]\nfile = '{path}'\n", "[material]\nshift = '{path}'\n",
    "[material.shear]\nterms = '{path}'\n", "[material]\nbulk = {{ terms = '{path}' }}\n",
    "[counter_material]\nfile = '{path}'\n", "[counter_body.material]\nfile = '{path}'\n",
]  # fmt: skip


@pytest.mark.parametrize("section", FILES)
def test_a_case_file_cannot_read_files_of_the_server(section, tmp_path):
    secret = tmp_path / "secret.csv"
    secret.write_text(RELAXATION)
    text = "[body]\nmass = 1.0\nradius = 1.0\n[impact]\nvelocity = 1.0\n" + section.format(path=secret)
    with pytest.raises(rs.InputError, match="names another file"):
        dropped(text, "a.toml")


def test_all_keys_that_read_files_are_known():
    def keys(schema: Any) -> set[str]:
        if isinstance(schema, list):
            return set().union(*map(keys, schema))
        if not isinstance(schema, dict):
            return set()
        here = {key for key, value in schema.get("properties", {}).items() if '"path"' in json.dumps(value)}
        return here.union(*map(keys, schema.values()))

    answer = keys(CaseFile.model_json_schema())
    assert {"file", "terms", "shift"} <= answer
    # Sections that contain such a key are no keys of files themselves.
    assert (
        answer - {"material", "counter_material", "counter_body", "profile", "shear", "bulk"}
        <= dropped_files.FILE_KEYS
    )


TERMS = table(np.geomspace(1e-9, 1e9, 60), np.full(60, 1.0), names="tau,G", units="s,MPa")


@pytest.mark.parametrize(
    ("text", "name", "message"),
    [
        ("1" * 1_000_001, "data.csv", "must have at most 1000000"),
        (TERMS, "data.csv", "has 60 terms in shear: must have at most 50"),
        # A case file of many tables is refused before it is read.
        ("".join(f"[a{n}]\n" for n in range(100_000)), "a.toml", "a case file must have at most 65536"),
    ],
    ids=["bytes", "terms", "tables"],
)
def test_large_files_are_refused(text, name, message):
    with pytest.raises(rs.InputError, match=message):
        dropped(text, name)


def test_nothing_is_left_of_a_dropped_file(monkeypatch, tmp_path):
    import tempfile

    monkeypatch.setattr(tempfile, "tempdir", str(tmp_path))
    dropped(DMA)
    assert list(Path(tmp_path).iterdir()) == []


EPOXY = (EXAMPLES / "epoxy.toml").read_bytes(), (EXAMPLES / "epoxy_prony.csv").read_bytes()


def test_moduli_without_a_deformation_are_asked_for_and_not_guessed():
    answer = dropped(RELAXATION.replace("t,G", "t,modulus"))
    assert "state" not in answer
    (question,) = answer["questions"]
    assert (question["key"], [value for value, _ in question["options"]]) == ("deformation", ["shear", "tension"])
    assert not dropped(RELAXATION)["questions"]


def test_a_case_and_the_table_that_it_names_are_dropped_together():
    with pytest.raises(rs.InputError, match="drop both files together"):
        dropped(EPOXY[0], "epoxy.toml")
    answer = dropped(EPOXY[0], "epoxy.toml", ("epoxy_prony.csv", EPOXY[1]))
    expected = rs.read_case(EXAMPLES / "epoxy.toml").solve().restitution_coefficient
    numbers = answers.impact(answer["state"])["numbers"]
    assert numbers["restitution_coefficient"] == pytest.approx(expected, rel=1e-9)


def test_terms_without_an_end_modulus_ask_for_it():
    asked = [question["key"] for question in dropped(EPOXY[1], "epoxy_prony.csv")["questions"]]
    assert asked == ["deformation", "instantaneous_modulus", "equilibrium_modulus"]
    stated = {"deformation": "shear", "instantaneous_modulus": "891 MPa", "equilibrium_modulus": "4.9 MPa"}
    state = dropped(EPOXY[1], "epoxy_prony.csv", answers=stated)["state"]
    series = rs.read_case(EXAMPLES / "epoxy.toml").impact.material.shear
    assert state["material.shear.equilibrium_modulus"] == pytest.approx(4.9e6, rel=1e-12)
    np.testing.assert_allclose(state["material.shear.branch_moduli"], series.branch_moduli, rtol=1e-12)


@pytest.mark.parametrize("name", ["../secret.csv", "/etc/passwd", "dropped.toml", ".hidden", "a/b.csv"])
def test_a_second_file_has_a_plain_name(name):
    with pytest.raises(rs.InputError, match="must be a plain name"):
        dropped(EPOXY[0], "epoxy.toml", (name, EPOXY[1]))


def test_a_workbook_is_read_as_on_the_command_line():
    excel = pytest.importorskip("openpyxl")
    book, written = excel.Workbook(), BytesIO()
    for row in [line.split(",") for line in DMA.splitlines()]:
        book.active.append([float(cell) if cell[0].isdigit() else cell for cell in row])
    book.save(written)
    assert dropped(written.getvalue(), "data.xlsx")["state"] == dropped(DMA)["state"]


def shifted(temperatures: dict[float, float]) -> str:
    """Sweeps of `SERIES` at temperatures [degC] with given shift factors, between the same frequencies."""
    rows, omega = ["T,omega,G',G''", "degC,rad/s,MPa,MPa"], np.geomspace(0.1, 1e3, 25)
    for temperature, factor in temperatures.items():
        moduli = SERIES.storage_modulus(factor * omega), SERIES.loss_modulus(factor * omega)
        rows += [f"{temperature},{w:.9g},{a / 1e6:.9g},{b / 1e6:.9g}" for w, a, b in zip(omega, *moduli, strict=True)]
    return "\n".join(rows) + "\n"


def test_the_temperature_of_a_master_curve_is_stated_and_can_be_set():
    factors = {10.0: 10.0, 20.0: 1.0, 30.0: 0.1}
    text = shifted(factors)
    first = dropped(text)
    assert any("the moduli are those at 20 °C" in note for note in first["notes"])
    (question,) = first["questions"]
    assert (question["key"], question["value"]) == ("temperature", "20 degC")
    omega = np.geomspace(1.0, 100.0, 20)
    for temperature, factor in factors.items():
        answer = dropped(text, answers={"temperature": f"{temperature} degC"})
        assert any(f"the moduli are those at {temperature:g} °C" in note for note in answer["notes"])
        names = ("equilibrium_modulus", "branch_moduli", "relaxation_times")
        series = rs.PronySeries(*(answer["state"][f"material.shear.{name}"] for name in names))
        # The fit is good to 1 %, and so is the shift.
        expected = SERIES.storage_modulus(factor * omega)
        np.testing.assert_allclose(series.storage_modulus(omega), expected, rtol=3e-2)


def test_a_constant_poisson_ratio_is_stated():
    answer = dropped(DMA, state={"bulk": "poisson_ratio", "material.poisson_ratio": 0.45})
    assert any("Poisson ratio 0.45 is constant in time" in note for note in answer["notes"])
    state = answer["state"]
    assert state["bulk"] == "series"
    # nu = (3 K - 2 G)/(6 K + 2 G) at both ends of the time.
    for name in ("equilibrium_modulus", "branch_moduli"):
        K, G = (np.array(state[f"material.{part}.{name}"]) for part in ("bulk", "shear"))
        np.testing.assert_allclose((3 * K - 2 * G) / (6 * K + 2 * G), 0.45, rtol=1e-9)


@pytest.mark.parametrize(
    "state",
    [{}, {"material.model": "fractional_zener"}, {"profile.type": "cone", "prescribed": "force"},
     {"material.model": "library"}, {"indentation.shape": "hold"}, {"indentation.shape": "sine_arch"},
     {"indentation.shape": "cycles", "indentation.count": 4.0, "indentation.valley": 0.3}],
)  # fmt: skip
def test_the_case_of_an_indentation_opens_again(state):
    text = download({"what": "indentation", "state": state})["text"]
    answer = dropped(text, "indentation.toml")
    assert answer["state"]["page.tab"] == "indentation"
    expected = answers.indentation(state)["numbers"]
    assert answers.indentation(answer["state"])["numbers"] == expected
    names: dict[str, Any] = {}
    exec(download({"what": "indentation python", "state": state})["text"], names)
    # A fractional material has another number of terms in the program.
    assert names["result"].max_force == pytest.approx(expected["max_force"], rel=1e-4)


def test_the_size_of_the_target_is_that_of_the_case():
    text = download({"what": "case", "state": {}})["text"].replace("[impact]", "[impact]\nbody_size = '1 mm'")
    answer = dropped(text, "a.toml")
    assert answer["state"]["impact.body_size"] == 1e-3
    (check,) = (row for row in answers.impact(answer["state"])["validity"] if row["kind"] == "half_space")
    assert check["state"] == "doubtful"
    again = download({"what": "case", "state": answer["state"]})["text"]
    assert "body_size = 0.001" in again
    assert "body_size=0.001" in download({"what": "python", "state": answer["state"]})["text"]


def test_a_soft_ball_of_a_case_keeps_its_waves():
    # The README's first example: a rubber ball on a rigid plate.
    text = (EXAMPLES / "rubber_ball.toml").read_text()
    state = dropped(text, "ball.toml")["state"]
    (waves,) = (row for row in answers.impact(state)["validity"] if row["kind"] == "waves")
    assert waves["state"] == "ok"
    again = dropped(download({"what": "case", "state": state})["text"], "again.toml")["state"]
    assert again["impact.material_of"] == "body"
    names: dict[str, Any] = {}
    exec(download({"what": "python", "state": state})["text"], names)
    assert not names["result"].validity["waves"].exceeded
    hard = state | {"impact.material_of": "target"}
    (waves,) = (row for row in answers.impact(hard)["validity"] if row["kind"] == "waves")
    assert waves["state"] == "doubtful"


@pytest.mark.parametrize(
    ("text", "rows"),
    [
        ("velocity [cm/s],e,sd_e\n50,0.8,0.01\n20,0.9,0.02\n", [[0.5, 0.8, 0.01], [0.2, 0.9, 0.02]]),
        ("v_in [m/s],v_out [m/s]\n2,1\n", [[2.0, 0.5]]),
        # v = sqrt(2 g h) and e = sqrt(h'/h).
        ("drop height [cm],rebound height [cm]\n100,64\n", [[np.sqrt(2.0 * 9.80665), 0.8]]),
    ],
)
def test_measured_points_are_read_as_by_the_command(text, rows):
    answer = dropped(text)
    np.testing.assert_allclose(answer["points"], rows, rtol=1e-12)
    assert answer["words"] == f"data.csv: {len(rows)} measured points"
    assert "state" not in answer


def test_bad_points_are_refused_in_one_line():
    header = "velocity [m/s],e\n"
    for text, words in (
        (header + "1,a\n", "data.csv: "), (header + "-1,0.5\n", "velocity"),
        (header + "1,0.5\n" * 301, "has 301 points: must have at most 300"),
    ):  # fmt: skip
        assert words in str(in_one_line(lambda text=text: dropped(text)))
