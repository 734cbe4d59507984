"""Conversion of texts with units, against the definitions of the units."""

import math
import re
from pathlib import Path
from typing import Any

import pytest

from cases import case_file
from refusals import named, refusal
from restitution import units
from restitution.case.identification import DesignFile, IdentificationFile
from restitution.case.impact import CaseFile, read_case
from restitution.case.indentation import IndentationFile
from restitution.case.section import Section
from restitution.errors import InputError
from restitution.quantities import (
    ANGLE,
    DENSITY,
    LENGTH,
    MASS,
    MODULUS,
    MOLAR_ENERGY,
    NUMBER,
    TEMPERATURE,
    TEMPERATURE_DIFFERENCE,
    TIME,
    VELOCITY,
    VISCOSITY,
    Dimension,
)
from restitution.units import to_si, unit_registry


@pytest.mark.parametrize(
    ("text", "kind", "number"),
    [
        ("10 mm", LENGTH, 0.01),
        ("10mm", LENGTH, 0.01),
        ("1e-2 m", LENGTH, 0.01),
        ("-.5 m", LENGTH, -0.5),
        ("\N{MINUS SIGN}20 °C", TEMPERATURE, 253.15),
        # The inch is 25.4 mm, the pound 0.45359237 kg (international yard and pound agreement, 1959).
        ("1 in", LENGTH, 0.0254),
        ("1 lb/in^3", DENSITY, 0.45359237 / 0.0254**3),
        # psi: pound-force, with standard gravity 9.80665 m/s^2, per square inch.
        ("1 psi", MODULUS, 0.45359237 * 9.80665 / 0.0254**2),
        ("2 N/mm2", MODULUS, 2e6),
        ("2 N/mm²", MODULUS, 2e6),
        ("3 kPa s", VISCOSITY, 3e3),
        ("3 kPa·s", VISCOSITY, 3e3),
        ("3 kPa*s", VISCOSITY, 3e3),
        ("1100 kg m-3", DENSITY, 1100.0),
        ("36 km/h", VELOCITY, 10.0),
        ("45 %", NUMBER, 0.45),
        ("0.45", NUMBER, 0.45),
        ("90 min", TIME, 5400.0),
        ("180 deg", NUMBER, math.pi),
        ("25 °C", TEMPERATURE, 298.15),
        ("25 degC", TEMPERATURE, 298.15),
        ("25 degC", TEMPERATURE_DIFFERENCE, 25.0),
        ("180 deg", ANGLE, math.pi),
        ("100 kcal/mol", MOLAR_ENERGY, 418.4e3),
        ("77 degF", TEMPERATURE, 298.15),
        ("inf GPa", MODULUS, math.inf),
    ],
)
def test_a_text_becomes_a_number_in_si(text: str, kind: Dimension, number: float) -> None:
    # The factor of the unit and the product are rounded once each.
    assert to_si(text, kind) == pytest.approx(number, rel=4e-16, abs=0.0)


def test_the_table_of_common_units_agrees_with_pint() -> None:
    assert len(units._UNITS) > 60
    for name, unit in units._UNITS.items():
        parsed = units._pint_unit(re.sub(r"(\w)([23])$", r"\1^\2", name), unit.dimension)
        si = unit_registry().Quantity(3.0, parsed).to(unit.dimension.unit).magnitude
        assert to_si(f"3 {name}", unit.dimension) == pytest.approx(si, rel=4e-16), name


@pytest.mark.parametrize(
    ("text", "kind", "message"),
    [
        ("10 s", LENGTH, 'is a time, not a length; write e.g. "10 mm", or a plain number in m'),
        ("10", LENGTH, 'has no unit; write e.g. "10 mm", or a plain number in m'),
        ("10 deg", LENGTH, 'is a dimensionless number, not a length; write e.g. "10 mm", or a plain number in m'),
        ("ten mm", LENGTH, 'cannot be read as a number and a unit; write e.g. "10 mm", or a plain number in m'),
        ("1,5 mm", LENGTH, 'must have a point in place of the comma; write e.g. "10 mm", or a plain number in m'),
        ("", LENGTH, 'cannot be read as a number and a unit; write e.g. "10 mm", or a plain number in m'),
        ("2 mpa", MODULUS, "unknown unit 'mpa', did you mean MPa? write e.g. \"2 MPa\", or a plain number in Pa"),
        ("1 m/ss", VELOCITY, "unknown unit 'm/ss', did you mean m/s? write e.g. \"1 m/s\", or a plain number in m/s"),
        ("1 mss", TIME, "unknown unit 'mss', did you mean ms? write e.g. \"1 ms\", or a plain number in s"),
        ("1 mss", MASS, "unknown unit 'mss'; write e.g. \"5 g\", or a plain number in kg"),
        ("60 ShoreA", MODULUS, "unknown unit 'ShoreA'; write e.g. \"2 MPa\", or a plain number in Pa"),
        ("1 fur\nlong)", LENGTH, "unknown unit 'fur\\nlong)'; write e.g. \"10 mm\", or a plain number in m"),
        # Spellings of instruments.
        (
            "25 C",
            TEMPERATURE,
            'is an electric charge, not a temperature; write e.g. "20 degC", or a plain number in K',
        ),
        ("3 -", NUMBER, "unknown unit '-'; write a plain number"),
        ("1 Hz", TIME, 'is a frequency, not a time; write e.g. "1 ms", or a plain number in s'),
        ("3 MPa m^3", MODULUS, 'is an energy, not a modulus; write e.g. "2 MPa", or a plain number in Pa'),
        ("1 kPa s", MODULUS, 'is a viscosity, not a modulus; write e.g. "2 MPa", or a plain number in Pa'),
        (
            "1 cm^-1",
            LENGTH,
            'is a quantity of dimension 1 / [length], not a length; write e.g. "10 mm", or a plain number in m',
        ),
        ("0.45 m", NUMBER, "is a length, not a dimensionless number; write a plain number"),
    ],
)
def test_invalid_quantities_are_refused_in_one_line(text: str, kind: Dimension, message: str) -> None:
    assert str(refusal(lambda: to_si(text, kind))) == message


@pytest.mark.parametrize(
    ("text", "kind", "meant"),
    [
        ("5 G", MODULUS, "GPa"),
        ("5 k", MODULUS, "kPa"),
        ("3 gpa", MODULUS, "GPa"),
        ("2 u", TIME, "us"),
        ("5 G", MASS, "g"),
    ],
)
def test_a_unit_that_was_cut_off_or_has_other_capitals_is_guessed(text: str, kind: Dimension, meant: str) -> None:
    assert f"did you mean {meant}?" in str(refusal(lambda: to_si(text, kind)))


@pytest.mark.parametrize("text", ["1 +- 0.05 m/s", "1 m/s +- 5 %", "(1 ± 0.05) m/s"])
def test_a_standard_deviation_is_refused_by_name(text: str) -> None:
    assert "standard deviation here" in str(refusal(lambda: to_si(text, VELOCITY)))


@pytest.mark.parametrize("text", ["1 m^9^9^9^9", "1 m**(9**9**9**9)", "9**9**9**9 m", "1 m^99999999"])
def test_nested_powers_are_refused_at_once(text: str) -> None:
    with pytest.raises(ValueError, match="unknown unit"):
        to_si(text, LENGTH)


@pytest.mark.parametrize("file", [CaseFile, IndentationFile, IdentificationFile, DesignFile])
def test_case_files_have_a_json_schema(file: type[Section]) -> None:
    assert file.model_json_schema()["type"] == "object"


def test_json_schema_has_every_form_of_profile_and_material() -> None:
    schema = CaseFile.model_json_schema()

    def keys(form: dict[str, Any]) -> set[str]:
        return set(
            schema["$defs"][form["$ref"].rpartition("/")[2]]["properties"] if "$ref" in form else form["properties"]
        )

    profiles, materials = (
        [keys(form) for form in schema["properties"][name]["anyOf"]] for name in ("profile", "material")
    )
    assert {"type", "half_angle"} <= next(form for form in profiles if "half_angle" in form)
    assert all({"base", "strict"} <= form for form in profiles if "thickness" in form)
    assert [form for form in profiles if "file" in form and {"r", "f"} <= form]
    assert [form for form in materials if {"model", "equilibrium_modulus", "viscosity", "density"} <= form]
    assert [form for form in materials if "library" in form]


def test_json_schema_has_units() -> None:
    sections = CaseFile.model_json_schema()["$defs"]
    fields = {name: sections["ImpactSection"]["properties"][name]["anyOf"][0] for name in ("velocity", "drop_height")}
    assert {name: field["unit"] for name, field in fields.items()} == {"velocity": "m/s", "drop_height": "m"}


@pytest.mark.parametrize("text", ["1 mPa", "500000 mPa", "1 millipascal"])
def test_a_modulus_in_millipascal_is_refused(text: str) -> None:
    with pytest.raises(InputError, match="did you mean MPa"):
        to_si(text, MODULUS)


def test_soft_moduli_and_viscosities_in_millipascal_seconds_are_read() -> None:
    assert to_si("0.001 Pa", MODULUS) == 0.001
    assert to_si("1 mPa s", VISCOSITY) == 0.001


def test_a_case_names_the_modulus_that_is_in_millipascal(tmp_path: Path) -> None:
    case = tmp_path / "case.toml"
    case_file(case, material='model = "elastic"\nshear_modulus = "1 mPa"\npoisson_ratio = 0.3')
    assert named(lambda: read_case(case)) == ("material.shear_modulus", "1 mPa")
