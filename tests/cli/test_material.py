"""The command material: tables, JSON, pictures and refusals."""

import json
import re
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from cases import case_file, isotherms_file
from commands import done, refused, words
from restitution import library

pytestmark = pytest.mark.usefixtures("folder")


def shown(*arguments: str) -> Any:
    return json.loads(done("material", *arguments, "--json").stdout)


def test_the_library_is_listed() -> None:
    listed = {line[0] for line in words("material", "--list") if line}
    assert set(library.names()) <= listed
    assert shown("--list")["ice"] == library.get("ice").source


def test_a_material_of_the_library_at_a_temperature() -> None:
    content = shown("polyisobutylene", "--at", "0 degC")
    # Ferry's shift factors: log10 aT = -8.61 (T - 298)/(200.4 + T - 298).
    factor = 10 ** (8.61 * 24.85 / (200.4 - 24.85))
    times = library.get("polyisobutylene").shear.relaxation_times * factor
    np.testing.assert_allclose(content["prony_shear"]["relaxation_times_s"], times, rtol=1e-12)
    assert content["temperature_K"] == 273.15
    assert content == shown("polyisobutylene", "--at", "273.15")
    assert ["temperature", "[°C]", "0"] in words("material", "polyisobutylene", "--at", "273.15")


def test_relaxation_data_are_fitted() -> None:
    t = np.geomspace(1e-3, 1e3, 61)
    rows = "\n".join(f"{a:.9g},{3 + 4 * np.exp(-a):.9g}" for a in t)
    Path("data.txt").write_text(f"t,E\ns,MPa\n{rows}\n")
    content = shown("data.txt", "--plot", "p.png")
    assert content["kind"] == "relaxation modulus over time"
    assert (content["points"], content["deformation"]) == (61, "tension")
    assert content["window_s"] == pytest.approx([1e-3, 1e3])
    assert content["relative_misfit"] < 2e-3
    fit = content["prony_tension"]
    assert fit["equilibrium_modulus_Pa"] == pytest.approx(3e6, rel=5e-3)
    assert fit["equilibrium_modulus_Pa"] + sum(fit["branch_moduli_Pa"]) == pytest.approx(7e6, rel=1e-2)
    assert Path("p.png").read_bytes().startswith(b"\x89PNG")
    rows = words("material", "data.txt")
    first = next(row for row in rows if row[:1] == ["0.001"])
    assert float(first[1]) == pytest.approx(7e6, rel=1e-2)


def test_dynamic_data_are_fitted(shared_reference: Path) -> None:
    file = shared_reference / "materials" / "polymer_dma_master_curve.csv"
    content = shown(str(file), "--plot", "p.svg")
    assert content["kind"] == "storage and loss modulus over frequency"
    assert content["points"] == 206
    # The data cover about 1e-12 to 1e14 Hz; the window is 1/omega.
    assert content["window_s"][1] == pytest.approx(1 / (2 * np.pi * 1e-12), rel=1e-12)
    assert Path("p.svg").read_text().startswith("<?xml")


def test_terms_decks_and_shift_factors() -> None:
    Path("terms.csv").write_text("relaxation_time_s,relative_modulus\n1,0.5\n")
    content = shown("terms.csv")
    assert (content["kind"], content["relative"], content["sum"]) == ("Prony terms", True, 0.5)
    table = done("material", "terms.csv").stdout
    assert "relaxation [-]" in table
    assert "[Pa]" not in table

    Path("deck.inp").write_text("*ELASTIC, MODULI=INSTANTANEOUS\n 9, 0.5\n*VISCOELASTIC, TIME=PRONY\n 0.5, 0, 2\n")
    content = shown("deck.inp")
    assert [content[key] for key in ("kind", "terms_in_shear", "terms_in_bulk")] == ["deck of a solver", 1, 0]
    # G0 = E/3 = 3, and half of it relaxes.
    assert content["prony_shear"]["equilibrium_modulus_Pa"] == 1.5

    Path("shift.csv").write_text("T_C,log_aT\n0,1\n20,0\n40,-2\n")
    content = shown("shift.csv", "--plot", "p.pdf")
    assert content["reference_temperature_K"] == pytest.approx(293.15)
    assert content["log10_factors"] == [1.0, 0.0, -2.0]
    assert Path("p.pdf").read_bytes().startswith(b"%PDF")
    assert ["40", "-2"] in words("material", "shift.csv")


@pytest.mark.parametrize("name", library.names())
def test_every_material_of_the_library_is_shown(name: str) -> None:
    assert words("material", name)[0] == [name]


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ([], r"material: give a file or a name, or --list"),
        (["steal"], r"steal: no such file, and no material of the library; did you mean steel\?"),
        (["none.csv"], r"none\.csv: no such file"),
        (["bad.csv"], r"bad\.csv: line 3: E = 'half': .*"),
        (["."], r"\.: cannot be read: Is a directory"),
        (["steel", "--at", "300"], r"temperature = 300 K: .*"),
        (["polyisobutylene", "--at", "90"], r"temperature = 90 K: .*"),
        (["polyisobutylene", "--at", "20 m"], r'--at "20 m": .*'),
        (["bad.csv", "--plot", "p.gif"], r"--plot p\.gif: .*"),
    ],
)
def test_bad_input_is_one_line(arguments: list[str], message: str) -> None:
    Path("bad.csv").write_text("t,E\n1,2\n2,half\n")
    assert re.fullmatch(message, refused("material", *arguments))


def test_a_material_of_a_deck_by_its_name() -> None:
    Path("deck.inp").write_text(
        "*MATERIAL, NAME=soft\n*ELASTIC\n 9, 0.5\n*VISCOELASTIC, TIME=PRONY\n 0.5, 0, 2\n"
        "*MATERIAL, NAME=hard\n*ELASTIC\n 3e9, 0.5\n"
    )
    assert refused("material", "deck.inp").endswith("soft or hard")
    content = shown("deck.inp", "--material-name", "hard")
    assert (content["name"], content["terms_in_shear"]) == ("hard", 0)
    # G = E/3.
    assert content["prony_shear"]["equilibrium_modulus_Pa"] == pytest.approx(1e9)
    message = "--material-name hard: steel is no deck of a solver, whose materials have names"
    assert refused("material", "steel", "--material-name", "hard") == message


def factors(text: str = "T,log aT\ndegC,-\n0,2.0\n20,0.0\n40,-1.5\n") -> None:
    Path("shift.csv").write_text(text)


def test_a_file_at_a_temperature_of_its_shift_factors() -> None:
    Path("terms.csv").write_text("relaxation_time_s,shear_modulus_MPa\n1e-3,2\n1.0,3\n")
    factors()
    plain = shown("terms.csv")
    content = shown("terms.csv", "--at", "10 degC", "--shift", "shift.csv")
    # Half way between 0 and 20 degrees: log10 aT = 1.
    assert content["shift_factor"] == pytest.approx(10.0, rel=1e-12)
    assert content["temperature_K"] == 283.15
    np.testing.assert_allclose(content["prony_shear"]["relaxation_times_s"], [1e-2, 10.0], rtol=1e-12)
    assert content["prony_shear"]["branch_moduli_Pa"] == plain["prony_shear"]["branch_moduli_Pa"]


@pytest.mark.parametrize("kind", ["relaxation", "dynamic"])
def test_data_are_shifted_with_the_fit(kind: str, monkeypatch: pytest.MonkeyPatch) -> None:
    from restitution.plot import material as pictures

    x = np.geomspace(1e-3, 1e3, 31)
    if kind == "relaxation":
        header, columns = "t,G\ns,MPa", (x, 3 + 4 * np.exp(-x))
    else:
        header = "frequency,storage,loss\nrad/s,MPa,MPa"
        columns = (x, 3 + 4 * x**2 / (1 + x**2), 4 * x / (1 + x**2))
    rows = "\n".join(",".join(f"{number:.9g}" for number in row) for row in zip(*columns, strict=True))
    Path("data.csv").write_text(f"{header}\n{rows}\n")
    factors()
    drawn: list[Any] = []
    keep = pictures.overview
    monkeypatch.setattr(
        pictures,
        "overview",
        lambda *arguments, **options: (drawn.append(arguments[2]), keep(*arguments, **options))[1],
    )
    content = shown("data.csv", "--at", "313.15", "--shift", "shift.csv", "--plot", "p.png")
    # log10 aT = -1.5 at 40 degrees.
    factor = 10.0**-1.5
    assert content["window_s"] == pytest.approx([1e-3 * factor, 1e3 * factor], rel=1e-6)
    (data,) = drawn
    drawn_abscissa, expected = (
        (data.time, x * factor) if kind == "relaxation" else (data.angular_frequency, x / factor)
    )
    np.testing.assert_allclose(drawn_abscissa, expected, rtol=1e-8)


def test_a_shift_table_gives_its_factor_at_a_temperature() -> None:
    factors()
    assert shown("shift.csv", "--at", "40 degC")["shift_factor"] == pytest.approx(10.0**-1.5, rel=1e-12)


def test_the_materials_of_a_case_at_a_temperature() -> None:
    shear = 'shear = { equilibrium_modulus = "1 MPa", branch_moduli = "[2] MPa", relaxation_times = "[3] ms" }\n'
    shift = 'shift = { reference_temperature = "20 degC", c1 = 10.0, c2 = "100 K" }\n'
    block = f'name = "block"\n{shear}bulk_modulus = "1 GPa"\n{shift}'
    case_file("case.toml", material=block, counter_material='library = "steel"')
    block, steel = shown("case.toml", "--at", "45 degC", "--plot", "p.png")
    # log10 aT = -10 * 25/(100 + 25) = -2.
    assert block["prony_shear"]["relaxation_times_s"] == pytest.approx([3e-5], rel=1e-12)
    assert (block["kind"], block["temperature_K"]) == ("material of case.toml", 318.15)
    assert steel["kind"] == "counter_material of case.toml"
    assert Path("p.png").exists()
    printed = words("material", "case.toml")
    assert ["block"] in printed
    assert ["steel"] in printed


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (
            ["terms.csv", "--at", "300"],
            "--at: a file of moduli has no law of the shift; give its shift factors by --shift FILE",
        ),
        (["terms.csv", "--shift", "shift.csv"], "--shift shift.csv: give --at TEMPERATURE as well"),
        (
            ["terms.csv", "--shift", "terms.csv", "--at", "300"],
            "--shift terms.csv: must hold temperatures and shift factors",
        ),
        (["terms.csv", "--shift", "shift.csv", "--at", "400"], "temperature = 400 K: "),
    ],
)
def test_bad_temperatures_of_files(arguments: list[str], message: str) -> None:
    Path("terms.csv").write_text("relaxation_time_s,shear_modulus_MPa\n1e-3,2\n1.0,3\n")
    factors()
    assert refused("material", *arguments).startswith(message)


def test_several_temperatures_become_a_master_curve() -> None:
    isotherms_file("dma.csv")
    options = "--reference-temperature", "20 degC", "--superposition", "wlf", "--plot", "p.png"
    content = shown("dma.csv", *options)
    assert content["kind"] == "storage and loss modulus over frequency, at 4 temperatures"
    assert (content["reference_temperature_K"], content["superposition"]) == (293.15, "wlf")
    assert content["c1"] == pytest.approx(9.0, rel=0.02)
    assert content["c2_K"] == pytest.approx(110.0, rel=0.02)
    assert content["log10_factors"] == pytest.approx([0.9, 0.0, -0.75, -1.3846], abs=0.01)
    assert content["temperatures_K"] == pytest.approx([283.15, 293.15, 303.15, 313.15])
    assert len(content["standard_errors"]) == 4
    assert Path("p.png").read_bytes().startswith(b"\x89PNG")
    rows = words("material", "dma.csv")
    assert ["superposition", "free"] in rows
    # The third of four temperatures is the default.
    assert any(row[:2] == ["30", "0"] for row in rows)
    warm = shown("dma.csv", "--at", "40 degC")
    assert np.log10(warm["shift_factor"]) == pytest.approx(-1.3846 + 0.75, abs=0.02)


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["dma.csv", "--superposition", "vft"], r"--superposition.*vft.*free.*wlf.*arrhenius"),
        (["dma.csv", "--reference-temperature", "80 degC"], r"reference_temperature = 353.15 K: "),
        (["dma.csv", "--at", "80 degC"], r"^temperature = 353.15 K: "),
        (["ice", "--superposition", "wlf"], "--superposition: ice must have moduli at several temperatures"),
        (["t.csv", "--reference-temperature", "300"], "--reference-temperature: t.csv must have moduli at several"),
    ],
)
def test_refused_superpositions(arguments: list[str], message: str) -> None:
    isotherms_file("dma.csv")
    Path("t.csv").write_text("t,E\n1,3\n10,2\n100,1\n1000,1\n")
    assert re.search(message, refused("material", *arguments))
