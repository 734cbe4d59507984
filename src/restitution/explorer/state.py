"""The state of the page: a flat table of inputs, which is a case file and back."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from restitution.case.impact import Case, read_case
from restitution.case.indentation import IndentationCase, IndentationFile, read_indentation
from restitution.case.section import CaseError, read_sections, read_toml
from restitution.contact.analytic import sphere_mass
from restitution.contact.contact import BALL_ON_TARGET
from restitution.contact.geometry import Geometry
from restitution.contact.pyramid import Pyramid
from restitution.errors import InputError
from restitution.explorer.inputs import inputs
from restitution.impact.problem import Impact
from restitution.impact.scaling import viscosity_unit
from restitution.material.models import constants_of
from restitution.material.prony import PronySeries

if TYPE_CHECKING:
    from restitution.material.viscoelastic import Material

State = dict[str, Any]

_PAGE, _SIDES, _INFINITE = "page.", "profile.sides", "incompressible"
# The body that deforms unless the case states it.
_SOFT = "target"
_NO_OTHER = "is not shown by the explorer, which has a rigid body on a half-space"


def checked(state: Mapping[str, Any]) -> State:
    """Return the checked values of a state; the page's own keys are dropped, and unknown ones are refused."""
    known, values = inputs(), {}
    for key, value in state.items():
        if key.startswith(_PAGE):
            continue
        if key not in known:
            raise InputError(key[:100], wanted="is no input of the explorer")
        values[key] = known[key].check(value)
    return values


def settled(state: Mapping[str, Any]) -> State:
    """Return the values of all inputs that are shown in a state.

    A choice that is not available is replaced by the first one that is.
    """
    given, values = checked(state), {}
    for key, one in inputs().items():
        value = given.get(key, one.default)
        if one.options:
            available = [option.value for option in one.options if _holds(option.when, values)]
            value = value if value in available else available[0] if available else value
        # A choice that is hidden decides as well.
        if one.options or _holds(one.when, values):
            values[key] = value
    hidden = [key for key, one in inputs().items() if one.options and not _holds(one.when, values)]
    return {key: value for key, value in values.items() if key not in hidden or key in _DECIDING}


# Choices that the paper's numbers fix.
_DECIDING = ("material.model", "bulk")


def _holds(when: Mapping[str, Any], values: State) -> bool:
    return all(values.get(key) in wanted for key, wanted in when.items())


def nested(values: Mapping[str, Any]) -> dict[str, Any]:
    """Return a table of key paths as tables within tables.

    >>> nested({"body.mass": 1.0, "body.radius": 2.0})
    {'body': {'mass': 1.0, 'radius': 2.0}}
    """
    content: dict[str, Any] = {}
    for key, value in values.items():
        *sections, name = key.split(".")
        table = content
        for section in sections:
            table = table.setdefault(section, {})
        table[name] = int(value) if key == _SIDES else value
    return content


def flat(content: Mapping[str, Any], prefix: str = "") -> State:
    """Return tables within tables as one table of key paths."""
    values: State = {}
    for key, value in content.items():
        values |= flat(value, f"{prefix}{key}.") if isinstance(value, Mapping) else {f"{prefix}{key}": value}
    return values


def case_content(state: Mapping[str, Any]) -> dict[str, Any]:
    """Return the content of the case file of an impact."""
    values = settled(state)
    content = {section: nested(values).get(section, {}) for section in ("body", "profile", "impact")}
    for key in ("external_force", "body_size"):
        if not content["impact"].get(key):
            content["impact"].pop(key, None)
    if content["impact"]["material_of"] == _SOFT:
        del content["impact"]["material_of"]
    return content | {"material": _material(values)}


def indentation_content(state: Mapping[str, Any]) -> dict[str, Any]:
    """Return the content of the case file of an indentation."""
    values = settled(state)
    content = nested(values)
    indentation, profile = content["indentation"], content["profile"]
    if "radius" in indentation:
        profile["radius"] = indentation.pop("radius")
    return {"profile": profile, "material": _material(values), "indentation": indentation}


def _material(values: State) -> dict[str, Any]:
    """Return the section of the material."""
    section: dict[str, Any] = nested(values)["material"]
    model, bulk = section.pop("model"), values["bulk"]
    if model not in ("library", "prony"):
        section["model"] = model
    if model != "library" and bulk == _INFINITE:
        section["bulk_modulus"] = math.inf
    if values["entry"] == "groups":
        section |= _from_groups(values)
    return section


def _from_groups(values: State) -> dict[str, float]:
    """Return the constants of the standard solid that the paper's three numbers determine."""
    modulus, radius = values["material.equilibrium_modulus"], values["body.radius"]
    mass = values["body.mass"] if "body.mass" in values else sphere_mass(values["body.density"], radius)
    unit = viscosity_unit(modulus, mass, values["impact.velocity"], radius)
    return {
        "branch_modulus": modulus / values["groups.p2"],
        "viscosity": values["groups.p3"] * float(unit),
        "poisson_ratio": values["groups.nu"],
    }


def of_file(path: Path) -> tuple[State, str | None]:
    """Return the state and the title of a case file of an impact or of an indentation."""
    content = read_toml(path)
    if "indentation" in content:
        sections = read_sections(IndentationFile, path, content)
        return of_indentation(read_indentation(path), sections), sections.title
    case = read_case(path)
    return of_case(case), case.title


def of_case(case: Case) -> State:
    """Return the state of a case file; refuse one that the page cannot show."""
    sections = case.sections
    given = {key: getattr(sections, key) is not None for key in ("counter_material", "counter_body")}
    given |= {"profile.thickness": sections.profile.on_layer, "impact.impedance": math.isfinite(case.impact.impedance)}
    for key in filter(given.get, given):
        raise InputError(key, wanted=f"{_NO_OTHER}; leave it out")
    written: dict[str, Any] = sections.model_dump(include={"body", "profile", "material"}, exclude_none=True)
    values: State = {"impact.velocity": float(case.impact.velocity), "impact.gravity": sections.impact.gravity}
    values |= flat({"profile": written["profile"], "body": written["body"]})
    values["mass_from"] = "density" if "body.density" in values else "mass"
    values["impact.external_force"] = float(case.impact.external_force)
    values["impact.body_size"] = float(case.impact.body_size or 0.0)
    values["impact.material_of"] = sections.impact.material_of or _SOFT
    return values | _of_section(written["material"], lambda: case.impact.material)


def of_indentation(case: IndentationCase, sections: IndentationFile) -> State:
    """Return the state of the case file of an indentation; refuse one that the page cannot show."""
    indentation = sections.indentation
    given = {
        "counter_material": case.counter_material is not None,
        "profile.thickness": sections.profile.on_layer,
        "indentation": indentation.shape is None,
    }
    wanted = {"indentation": "must have a shape over time: the page shows no list of points"}
    for key in filter(given.get, given):
        raise InputError(key, wanted=wanted.get(key, f"{_NO_OTHER}; leave it out"))
    written: dict[str, Any] = sections.model_dump(include={"profile", "material", "indentation"}, exclude_none=True)
    profile, course = written["profile"], written["indentation"]
    course.pop("n_points", None)
    values = flat({"profile": profile, "indentation": course})
    if "profile.radius" in values and Geometry.registered[profile["type"]].body_radius:
        values["indentation.radius"] = values.pop("profile.radius")
    if indentation.shape == "triangle":
        values = {"indentation.unloading_time": course["loading_time"], "indentation.hold_time": 0.0} | values
    if indentation.shape == "hold":
        values.setdefault("indentation.rise_time", 0.0)
    values["prescribed"] = case.prescribed
    return values | _of_section(written["material"], lambda: case.material) | {"page.tab": "indentation"}


def _of_section(section: Mapping[str, Any], built: Callable[[], Material]) -> State:
    """Return the state of the section of a material, or of the material if the page has not all of its keys."""
    material = flat({"material": section})
    infinite = material.get("material.bulk_modulus") == math.inf
    if infinite:
        del material["material.bulk_modulus"]
    material.pop("material.name", None)
    bulk = "bulk_modulus" if "material.bulk_modulus" in material else "poisson_ratio"
    form = "library" if "material.library" in material else material.get("material.model")
    found = material | {"material.model": form, "bulk": _INFINITE if infinite else bulk}
    if form is None or not material.keys() <= inputs().keys() or not material.keys() <= settled(found).keys():
        return of_material(built())
    return found


def of_impact(impact: Impact) -> State:
    """Return the state of an impact; refuse one that the page cannot show."""
    if not isinstance(impact, Impact):
        raise InputError("impact", wanted="must be an Impact or the name of a case file")
    if impact.shape:
        raise InputError("impact", wanted=f"must be a single impact, but has shape {impact.shape}")
    if impact.counter_material is not None or not math.isinf(impact.impedance):
        raise InputError("impact", wanted=_NO_OTHER)
    names = {profile: name for name, profile in Geometry.registered.items()}
    kind = type(impact.profile)
    if kind not in names or names[kind] not in {one.value for one in inputs()["profile.type"].options}:
        raise InputError("impact", wanted=f"has a profile that the explorer does not show: {kind.__name__}")
    values: State = {"profile.type": names[kind], "mass_from": "mass"}
    for name in constants_of(kind):
        key = "body.radius" if name == "radius" and kind.body_radius else f"profile.{name}"
        values[key] = float(getattr(impact.profile, name))
    if isinstance(impact.profile, Pyramid):
        values[_SIDES] = impact.profile.sides
    for name in ("velocity", "external_force"):
        values[f"impact.{name}"] = float(getattr(impact, name))
    values["impact.body_size"] = float(impact.body_size or 0.0)
    values["impact.material_of"] = "body" if impact.diameters == BALL_ON_TARGET[::-1] else _SOFT
    return values | {"body.mass": float(impact.mass)} | of_material(impact.material)


def of_material(material: Material) -> State:
    """Return the state of a material as a standard solid, or else as Prony series in shear and in bulk."""
    shear, bulk = material.shear, material.bulk
    solid = shear.n_branches == 1 and shear.equilibrium_modulus > 0.0 and shear.parallel_viscosity == 0.0
    if solid and (not isinstance(bulk, PronySeries) or bulk.is_elastic):
        branch, duration = float(shear.branch_moduli[0]), float(shear.relaxation_times[0])
        constants = {"equilibrium_modulus": shear.equilibrium_modulus, "branch_modulus": branch}
        values: State = {f"material.{name}": value for name, value in constants.items()}
        values |= {"material.model": "standard_solid", "material.viscosity": branch * duration}
    else:
        values = {"material.model": "prony"} | _of_series("shear", shear)
    if material.density is not None:
        values["material.density"] = material.density
    if not isinstance(bulk, PronySeries):
        return values | {"bulk": _INFINITE}
    if bulk.is_elastic:
        return values | {"bulk": "bulk_modulus", "material.bulk_modulus": bulk.equilibrium_modulus}
    return values | {"bulk": "series"} | _of_series("bulk", bulk)


def _of_series(part: str, series: PronySeries) -> State:
    names = ("equilibrium_modulus", "branch_moduli", "relaxation_times", "parallel_viscosity")
    return {f"material.{part}.{name}": np.asarray(getattr(series, name)).tolist() for name in names}


def one_line(error: InputError) -> str:
    """Return an error as one line, the first one of several mistakes."""
    first = error.mistakes[0] if isinstance(error, CaseError) else error
    return " ".join(str(CaseError(first)).split())
