"""Temperature ramps at one frequency, made of known series and laws of the shift."""

import json
import math
from pathlib import Path

import numpy as np
import pytest

from cases import case_file
from commands import done, refused
from refusals import in_one_line, named, warns
from restitution import (
    WLF,
    Arrhenius,
    Impact,
    InputError,
    Material,
    Parabola,
    PronySeries,
    ShiftTable,
    TemperatureRamp,
    read_case,
    solve,
)
from restitution.material.readers import parse

LAW = WLF(233.15, 15.0, 60.0)
TIMES = np.logspace(-5, 3, 33)
SERIES = PronySeries(1e6, 4e7 / (1.0 + (TIMES / 0.1) ** 0.6), TIMES)
KELVIN = np.arange(205.15, 313.0, 1.0)
OMEGA = 2.0 * math.pi * 2.0


def moduli() -> tuple[np.ndarray, np.ndarray]:
    reduced = OMEGA * 10.0 ** (-15.0 * (KELVIN - 233.15) / (60.0 + KELVIN - 233.15))
    return SERIES.storage_modulus(reduced), SERIES.loss_modulus(reduced)


def ramp(omega: float | None = OMEGA) -> TemperatureRamp:
    return TemperatureRamp(KELVIN, *moduli(), omega, "shear")


def text(names: str, units: str, *columns: np.ndarray, mark: str = ",") -> str:
    rows = zip(*(column.tolist() for column in columns), strict=True)
    return "\n".join([names, units, *(mark.join(map(repr, row)) for row in rows)]) + "\n"


def plain(frequency: bool = True) -> str:
    storage, loss = moduli()
    columns = (KELVIN - 273.15, storage / 1e6, loss / 1e6)
    if frequency:
        # An instrument measures its frequency with some scatter.
        columns = (*columns, 2.0 + 1e-3 * (-1.0) ** np.arange(KELVIN.size))
    return text("T,G',G''" + ",f" * frequency, "°C,MPa,MPa" + ",Hz" * frequency, *columns)


def trios() -> str:
    storage, loss = moduli()
    names = "Variables\tTemperature\tFrequency\tTan(delta)\tStorage modulus"
    lines = ["[Step]", "Step name\tTemperature ramp - 1", names, "Units\t°C\tHz\t\tPa"]
    rows = zip(KELVIN.tolist(), (loss / storage).tolist(), storage.tolist(), strict=True)
    return "\n".join([*lines, *(f"Data point\t{t - 273.15!r}\t2.0\t{tan!r}\t{g!r}" for t, tan, g in rows)])


@pytest.mark.parametrize("law", [LAW, Arrhenius(233.15, 2e5), ShiftTable([210.0, 233.15, 290.0], [2.0, 0.0, -9.0])])
def test_a_given_law_reduces_the_frequency(law) -> None:
    with warns("ramp"):
        data, shift = ramp().reduced(law)
    assert shift is law
    inside = (KELVIN > 210.0) & (KELVIN < 290.0) if isinstance(law, ShiftTable) else KELVIN > 0.0
    expected = OMEGA * law.factor(KELVIN[inside])
    np.testing.assert_allclose(data.angular_frequency, expected[::-1], rtol=1e-12)
    np.testing.assert_array_equal(data.storage_modulus, moduli()[0][inside][::-1])
    assert data.temperature == pytest.approx(law.reference_temperature)
    assert any("°C are used" in note for note in data.notes) == (not inside.all())


def test_universal_constants_hold_about_the_peak_of_the_loss_modulus() -> None:
    with warns("ramp"):
        data, shift = ramp().reduced()
    glass = float(KELVIN[np.argmax(moduli()[1])])
    assert ramp().glass_transition == shift.reference_temperature == glass
    rise = KELVIN[(glass <= KELVIN) & (glass + 100.0 >= KELVIN)] - glass
    np.testing.assert_allclose(
        data.angular_frequency[::-1], OMEGA * 10.0 ** (-17.44 * rise / (51.6 + rise)), rtol=1e-9
    )
    assert len(data.notes) == 1
    with pytest.raises(InputError):
        shift.factor(glass - 1.0)


def test_the_warning_has_the_shifts_of_other_polymers() -> None:
    with pytest.warns(match="ramp: one frequency") as caught:
        ramp().reduced()
    # 50 K above: 17.44*50/101.6 = 8.58; the extremes are polyisobutylene, 16.53*50/154.4, and 27.15*50/114.17.
    assert all(number in str(caught[0].message) for number in ("-8.6", "-5.4 to -11.9"))


def test_a_ramp_without_a_peak_or_a_frequency_is_refused() -> None:
    storage, loss = moduli()
    warm = ramp().glass_transition + 5.0 < KELVIN
    part = TemperatureRamp(KELVIN[warm], storage[warm], loss[warm], OMEGA)
    assert named(part.reduced) == ("shift",)
    assert named(lambda: ramp(None).reduced(LAW)) == ("frequency",)
    assert named(lambda: ramp().reduced(LAW, angular_frequency=1.0)) == ("frequency", pytest.approx(0.5 / math.pi))
    with warns("ramp"):
        data, _ = ramp(None).reduced(LAW, angular_frequency=OMEGA)
    assert data.angular_frequency.max() == pytest.approx(OMEGA * LAW.factor(KELVIN[0]))


@pytest.mark.parametrize("source", [plain(), plain().replace("T,", "Temperatur,").replace("G'", "Speichermodul", 1)
                                    .replace("G''", "Verlustmodul", 1), trios(), plain(frequency=False)])  # fmt: skip
def test_files_are_read(source: str) -> None:
    table = parse(source)
    assert isinstance(table, TemperatureRamp)
    storage, loss = moduli()
    np.testing.assert_allclose(table.temperatures, KELVIN, rtol=1e-12)
    np.testing.assert_allclose(table.storage_modulus, storage, rtol=1e-12)
    np.testing.assert_allclose(table.loss_modulus, loss, rtol=1e-12)
    if source == plain(frequency=False):
        assert table.angular_frequency is None
    else:
        assert table.angular_frequency == pytest.approx(OMEGA, rel=1e-3)


def test_a_cooling_ramp_and_repeated_temperatures_are_read() -> None:
    lines = plain().splitlines()
    table = parse("\n".join([*lines[:2], lines[-1], *lines[:1:-1]]))
    np.testing.assert_allclose(table.temperatures, KELVIN, rtol=1e-12)


def test_what_is_no_ramp_is_refused() -> None:
    assert "holds several temperature ramps" in str(in_one_line(lambda: parse(trios() + "\n" + trios(), "x")))
    assert "must have at least 4 temperatures" in str(in_one_line(lambda: parse("T,E',E''\n°C,Pa,Pa\n1,2,1\n2,2,1\n")))


@pytest.mark.usefixtures("folder")
@pytest.mark.filterwarnings("ignore:.*one frequency")
def test_the_rebound_is_that_of_the_material_where_the_law_is_its_own() -> None:
    Path("ramp.csv").write_text(plain(frequency=False), encoding="utf-8")
    file = 'file = "ramp.csv"\npoisson_ratio = 0.5\nfrequency = "2 Hz"\ntemperature = "-5 degC"\n'
    case_file("ramp.toml", material=file + "shift = { reference_temperature = 233.15, c1 = 15.0, c2 = 60.0 }")
    measured = read_case("ramp.toml").solve().restitution_coefficient
    truth = Material(SERIES, math.inf, shift=LAW, temperature=233.15).at(268.15)
    exact = float(solve(Impact(truth, Parabola(0.01), mass=0.005, velocity=1.0)).restitution_coefficient)
    # Relative errors of the fit are those of e, or smaller.
    misfit = read_case("ramp.toml").sections.material.fit.misfit
    assert misfit < 0.05
    assert measured == pytest.approx(exact, rel=misfit)
    options = ["--material", "ramp.csv", "--frequency", "2 Hz", "--wlf", "233.15, 15, 60", "--temperature", "-5 degC"]
    ball = ["--poisson-ratio", "0.5", "--radius", "10 mm", "--mass", "5 g", "--velocity", "1"]
    answer = json.loads(done("solve", *options, *ball, "--json", "--save", "saved.toml").stdout)
    assert answer["restitution_coefficient"] == measured
    assert read_case("saved.toml").solve().restitution_coefficient == measured


@pytest.mark.usefixtures("folder")
def test_all_that_a_ramp_lacks_is_asked_for() -> None:
    Path("ramp.csv").write_text(plain(frequency=False), encoding="utf-8")
    message = refused("solve", "--material", "ramp.csv", "--radius", "1 cm", "--mass", "5 g", "--velocity", "1")
    assert all(option in message for option in ("--frequency", "--temperature", "--poisson-ratio", "from -68 to"))
    case_file("ramp.toml", material='file = "ramp.csv"')
    with pytest.raises(InputError) as caught:
        read_case("ramp.toml")
    fields = [mistake.field for mistake in caught.value.mistakes]
    assert fields == ["material", "material.frequency", "material.temperature"]


@pytest.mark.usefixtures("folder")
@pytest.mark.filterwarnings("ignore:.*one frequency")
def test_the_command_material_shows_a_ramp() -> None:
    Path("ramp.csv").write_text(plain(), encoding="utf-8")
    content = json.loads(done("material", "ramp.csv", "--at", "0 degC", "--json", "--plot", "p.png").stdout)
    assert content["kind"] == "storage and loss modulus over temperature"
    assert content["frequency_Hz"] == pytest.approx(2.0, rel=1e-3)
    assert content["reference_temperature_K"] == ramp().glass_transition
    assert Path("p.png").read_bytes().startswith(b"\x89PNG")
