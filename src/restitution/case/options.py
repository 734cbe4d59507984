"""A case from the options of a command: the file of a material, a ball and a velocity, without a case file."""

from __future__ import annotations

import json
import os
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any, cast

from restitution.case.impact import Case, case_of
from restitution.case.section import CaseError
from restitution.errors import InputError
from restitution.files import path_of, write_text
from restitution.material import library
from restitution.material.cards import PronyTerms, ViscoelasticDeck
from restitution.material.hardness import read_hardness
from restitution.material.master_curve import Isotherms
from restitution.material.readers import read_material
from restitution.material.shift import ShiftTable
from restitution.material.temperature_ramp import TemperatureRamp
from restitution.quantities import advice
from restitution.units import TEMPERATURE, celsius, to_si

KEYS = {
    "material": "material.file",
    "temperature": "material.temperature",
    "shift": "material.shift",
    "frequency": "material.frequency",
    "deformation": "material.deformation",
    "poisson_ratio": "material.poisson_ratio",
    "bulk_modulus": "material.bulk_modulus",
    "instantaneous_modulus": "material.instantaneous_modulus",
    "equilibrium_modulus": "material.equilibrium_modulus",
    "radius": "body.radius",
    "mass": "body.mass",
    "density": "body.density",
    "velocity": "impact.velocity",
    "drop_height": "impact.drop_height",
    "thickness": "profile.thickness",
    "base": "profile.base",
}
"""Keys of a case file by the names of the options that set them."""

# Where names of files start, and what messages call the case.
_HERE = Path("options")
# A table is at the temperature that it states, within this difference [K].
_SAME_TEMPERATURE = 1.0


def case_of_options(options: Mapping[str, str]) -> Case:
    """Return the case that options describe, whose content a case file would have; names of options as in `KEYS`.

    Raises
    ------
    CaseError
        If options are missing, all in one line, or if a value is not admissible, a line for each.

    Examples
    --------
    >>> case = case_of_options({"material": "epoxy", "radius": "10 mm", "density": "7800 kg/m^3", "velocity": "1"})
    >>> case.content["body"], round(case.impact.mass, 6)
    ({'radius': '10 mm', 'density': '7800 kg/m^3'}, 0.032673)
    """
    name = options.get("material", "")
    of_library = name in library.names() and not Path(name).exists()
    material = None if of_library or not name else _read(name)
    if missing := [*_missing_of_body(options), *_missing_of_material(options, material, of_library)]:
        raise CaseError(InputError("", rule=f"missing: {'; '.join(missing)}"))
    content: dict[str, Any] = {"title": _title(options)}
    for option, key in KEYS.items():
        if option in options:
            section, _, field = key.partition(".")
            content.setdefault(section, {})[field] = _value(options[option])
    if "wlf" in options:
        content["material"]["shift"] = _wlf(options)
    if of_library:
        content["material"]["library"] = content["material"].pop("file")
    elif _is_at(material, options):
        del content["material"]["temperature"]
    try:
        return case_of(content, _HERE)
    except CaseError as error:
        raise CaseError(*map(_of_option, error.mistakes)) from None


def write_case(case: Case, path: str | Path) -> Path:
    """Write the case file of a case; the names of its files start in the folder of the path."""
    path = path_of(path)
    lines: list[str] = []
    for section, content in case.content.items():
        if not isinstance(content, dict):
            lines.append(f"{section} = {_toml(content)}")
            continue
        lines += ["", f"[{section}]"]
        for key, value in cast("dict[str, Any]", content).items():
            if key in ("file", "shift") and isinstance(value, str):
                value = _relative(case.path.parent / value, path.parent)
            lines.append(f"{key} = {_toml(value)}")
    return write_text(path, "\n".join(lines) + "\n")


def _read(name: str) -> Any:
    path = Path(name)
    if path.suffix.lower() == ".toml":
        raise CaseError(InputError("--material", name, "is a case file; give it alone"))
    if not path.exists() and read_hardness(name) is not None:
        rule = "a hardness is a modulus without a loss, with which e = 1; `restitution material` shows its range"
        raise CaseError(InputError("--material", name, rule))
    if not path.exists() and not path.suffix:
        rule = f"no such file, and no material of the library; {advice(name, library.names())}"
        raise CaseError(InputError("--material", name, rule))
    try:
        return read_material(path)
    except InputError as error:
        raise CaseError(error) from None


def _missing_of_body(options: Mapping[str, str]) -> Iterator[str]:
    """Yield the options of the body and its motion that are missing."""
    if "radius" not in options:
        yield "--radius"
    if not {"mass", "density"} & options.keys():
        yield "--mass, or --density of a solid ball"
    if not {"velocity", "drop_height"} & options.keys():
        yield "--velocity or --drop-height"


def _missing_of_material(options: Mapping[str, str], material: Any, of_library: bool) -> Iterator[str]:
    """Yield the options without which the file does not determine a material."""
    if "material" not in options:
        yield "--material FILE, or a name of the library"
        return
    if of_library or isinstance(material, ViscoelasticDeck | ShiftTable):
        return
    name = Path(options["material"]).name
    if not {"poisson_ratio", "bulk_modulus"} & options.keys():
        yield "--poisson-ratio (0.5: incompressible) or --bulk-modulus"
    if material.deformation is None and "deformation" not in options:
        yield f"--tension or --shear, as {name} does not state which moduli it has"
    if isinstance(material, PronyTerms):
        ends = material.instantaneous_modulus, material.equilibrium_modulus
        stated = {"instantaneous_modulus", "equilibrium_modulus"} & options.keys()
        if ends == (None, None) and not stated:
            yield "--instantaneous-modulus or --equilibrium-modulus"
    elif isinstance(material, Isotherms) and "temperature" not in options:
        low, high = (celsius(kelvin, 4) for kelvin in material.temperatures[[0, -1]])
        yield f"--temperature, as {name} has several from {low} to {high} °C"
    elif isinstance(material, TemperatureRamp):
        if material.angular_frequency is None and "frequency" not in options:
            yield f"--frequency, as {name} does not state it"
        if "temperature" not in options:
            low, high = (celsius(kelvin, 4) for kelvin in material.temperatures[[0, -1]])
            yield f"--temperature, as {name} has all from {low} to {high} °C"
    one_alone = not isinstance(material, Isotherms | TemperatureRamp) and not _is_at(material, options)
    if one_alone and "temperature" in options and not {"shift", "wlf"} & options.keys():
        yield f"--shift or --wlf for --temperature, as {name} has moduli at one alone"


def _is_at(material: Any, options: Mapping[str, str]) -> bool:
    """Return whether a table is at the temperature that is asked for, so that it needs no shift."""
    stated = getattr(material, "temperature", None)
    if stated is None or "temperature" not in options or "shift" in options:
        return False
    try:
        kelvin = to_si(options["temperature"], TEMPERATURE)
    except InputError:
        return False
    return abs(kelvin - stated) < _SAME_TEMPERATURE


def _wlf(options: Mapping[str, str]) -> dict[str, float | str]:
    """Return the section of a law of WLF, whose reference and constants stand in one option."""
    parts = [part.strip() for part in options["wlf"].split(",")]
    if "shift" in options:
        raise CaseError(InputError("--wlf", rule="is a law of the shift, and so is --shift; give one of both"))
    if len(parts) != 3 or not all(parts):
        rule = 'must be a temperature and two constants, e.g. "20 degC, 8.86, 101.6"'
        raise CaseError(InputError("--wlf", options["wlf"], rule))
    return dict(zip(("reference_temperature", "c1", "c2"), map(_value, parts), strict=True))


def _title(options: Mapping[str, str]) -> str:
    at = f" at {options['temperature']}" if "temperature" in options else ""
    return f"{Path(options['material']).name}{at}"


def _value(text: str) -> float | str:
    """Return a plain number as such, and a text with a unit as it is."""
    try:
        return float(text)
    except ValueError:
        return text


def _of_option(mistake: InputError) -> InputError:
    """Return a mistake of the case under the name of the option."""
    option = next((name for name, key in KEYS.items() if key == mistake.field), None)
    if mistake.field.startswith("material.shift."):
        option = "wlf"
    if option in (None, "deformation"):
        return mistake
    return InputError(f"--{option.replace('_', '-')}", mistake.value, mistake.rule, mistake.unit)


def _relative(file: Path, folder: Path) -> str:
    try:
        return Path(os.path.relpath(file, folder)).as_posix()
    except ValueError:  # another drive of Windows
        return str(file.resolve())


def _toml(value: float | str | dict[str, Any]) -> str:
    if isinstance(value, dict):
        return "{ " + ", ".join(f"{key} = {_toml(part)}" for key, part in value.items()) + " }"
    if isinstance(value, float):
        return repr(value)
    return json.dumps(value, ensure_ascii=False).replace("\x7f", "\\u007f")
