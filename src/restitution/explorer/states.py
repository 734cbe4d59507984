"""States of the page from case files, impacts and materials; what the page does not have is refused."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

import numpy as np

import restitution as rs
from restitution.case.impact import CaseFile
from restitution.case.indentation import IndentationCase, IndentationFile, read_indentation
from restitution.case.oscillation import TappingCase, TappingFile, read_tapping
from restitution.case.section import read_sections, read_toml
from restitution.contact.geometry import BALL_ON_TARGET, Geometry
from restitution.errors import InputError
from restitution.explorer.inputs import (
    BALL,
    HALF_SPACE,
    INFINITE,
    LAYER,
    MODES,
    NEAREST,
    OBLIQUE,
    PLATE,
    RIGID,
    SAME,
    SAMPLE,
    SIDES,
    SOFT,
    SPOT,
    State,
    flat,
    inputs,
    settled,
)
from restitution.impact.problem import SOLID_BALL
from restitution.material.models import constants_of
from restitution.variation import is_standard_solid

_NO_OTHER = "is not shown by the explorer; leave it out"


def of_file(path: Path) -> tuple[State, str | None]:
    """Return the state and the title of a case file of an impact, an indentation or tapping."""
    content = read_toml(path)
    if "tapping" in content:
        case = read_tapping(path)
        return _of_tapping(case, read_sections(TappingFile, path, content)), case.title
    if "indentation" in content:
        sections = read_sections(IndentationFile, path, content)
        return of_indentation(read_indentation(path), sections), sections.title
    case = rs.read_case(path)
    return of_case(case), case.title


def _refuse(extra: Mapping[str, bool]) -> None:
    """Refuse a case with parts that the page does not have."""
    for key in filter(extra.get, extra):
        raise InputError(key, rule=_NO_OTHER)


def of_case(case: rs.Case) -> State:
    """Return the state of a case file; refuse one that the page cannot show."""
    sections = case.sections
    written: dict[str, Any] = sections.model_dump(include={"body", "profile", "material"}, exclude_none=True)
    values: State = {"impact.velocity": float(case.impact.velocity), "impact.gravity": sections.impact.gravity}
    written["profile"].pop("strict", None)
    values |= flat({"profile": written["profile"], "body": written["body"]})
    values |= _of_target(sections, case.impact)
    values["mass_from"] = "density" if "body.density" in values else "mass"
    values["impact.external_force"] = float(case.impact.external_force)
    values["impact.body_size"] = float(case.impact.body_size or 0.0)
    values["impact.material_of"] = sections.impact.material_of or SOFT
    values[SPOT] = SAME if sections.bounces.same_spot else "fresh"
    values |= _of_sliding(case.impact) | _of_adhesion(case.impact)
    return values | _of_section(written["material"], lambda: case.impact.material)


def _of_target(sections: CaseFile, impact: rs.Impact) -> State:
    """Return the state of the target of a case file; refuse one that the page does not have."""
    second = sections.counter_body
    values: State = {"target": LAYER if sections.profile.on_layer else HALF_SPACE}
    if math.isfinite(impact.impedance):
        values = {"target": PLATE, "impact.impedance": float(impact.impedance)}
    if second is not None:
        if second.radius is None:
            raise InputError("counter_body", rule=f"without a radius {_NO_OTHER}")
        mass = float(second.kilograms)
        values = {"target": BALL, "counter_body.radius": float(second.radius), "counter_body.mass": mass}
    return values | {"partner": _partner_of(impact)}


def _partner_of(impact: rs.Impact) -> str:
    """Return the choice of the material of the other body; refuse one that the page does not have."""
    counter = impact.counter_material
    if counter is None:
        return RIGID
    if counter == impact.material:
        return SAME
    for name in rs.library.names():
        if rs.library.get(name) == counter:
            return name
    rule = "must be the same material or one of the library at its reference temperature, on the page"
    raise InputError("counter_material", rule=rule)


def of_indentation(case: IndentationCase, sections: IndentationFile) -> State:
    """Return the state of the case file of an indentation; refuse one that the page cannot show."""
    indentation = sections.indentation
    spring = sections.indentation.spring_constant is not None
    _refuse({
        "counter_material": case.counter_material is not None, "indentation.spring_constant": spring,
    })  # fmt: skip
    if indentation.shape is None:
        raise InputError("indentation", rule="must have a shape over time: the page shows no list of points")
    written: dict[str, Any] = sections.model_dump(include={"profile", "material", "indentation"}, exclude_none=True)
    profile, course = written["profile"], written["indentation"]
    course.pop("n_points", None)
    values = _of_tip(profile) | flat({"indentation": course})
    if indentation.shape == "triangle":
        values = {"indentation.unloading_time": course["loading_time"], "indentation.hold_time": 0.0} | values
    if indentation.shape == "cycles":
        values = {"indentation.unloading_time": course["loading_time"], "indentation.valley": 0.0} | values
    if indentation.shape == "hold":
        values.setdefault("indentation.rise_time", 0.0)
    values["prescribed"] = case.prescribed
    return values | _of_section(written["material"], lambda: case.material) | {"page.tab": "indentation"}


def _of_tip(profile: dict[str, Any]) -> State:
    """Return the state of the tip in a section of the profile."""
    values = {SAMPLE: LAYER if "thickness" in profile else HALF_SPACE} | flat({"profile": profile})
    for name in ("thickness", "base"):
        if (key := f"profile.{name}") in values:
            values[f"indentation.{name}"] = values.pop(key)
    if "profile.radius" in values and Geometry.registered[profile["type"]].body_radius:
        values["indentation.radius"] = values.pop("profile.radius")
    return values


def _of_tapping(case: TappingCase, sections: TappingFile) -> State:
    """Return the state of the case file of tapping; refuse one that the page cannot show."""
    tapping, options = sections.tapping, case.options
    _refuse({
        "counter_material": case.counter_material is not None,
        **{f"tapping.{name}": name in options for name in ("drive", "intermolecular_distance")},
        "tapping.modes": tapping.modes is not None,
        "tapping.resonance_frequency": options.get("resonance_frequency", tapping.frequency) != tapping.frequency,
    })  # fmt: skip
    written: dict[str, Any] = sections.model_dump(include={"profile", "material"}, exclude_none=True)
    names = ("spring_constant", "quality_factor", "frequency", "free_amplitude", "hamaker")
    values = _of_tip(written["profile"]) | {f"tapping.{name}": options[name] for name in names if name in options}
    values[MODES] = tapping.beam_quality_factors or []
    values[NEAREST] = min(options["distance"]) / options["free_amplitude"]
    return values | _of_section(written["material"], lambda: case.material) | {"page.tab": "tapping"}


def _of_section(section: Mapping[str, Any], built: Callable[[], rs.Material]) -> State:
    """Return the state of the section of a material, or of the material if the page has not all of its keys."""
    material = flat({"material": section})
    infinite = material.get("material.bulk_modulus") == math.inf
    if infinite:
        del material["material.bulk_modulus"]
    material.pop("material.name", None)
    bulk = "bulk_modulus" if "material.bulk_modulus" in material else "poisson_ratio"
    form = "library" if "material.library" in material else material.get("material.model")
    state = material | {"material.model": form, "bulk": INFINITE if infinite else bulk}
    if form is None or not material.keys() <= inputs().keys() or not material.keys() <= settled(state).keys():
        return of_material(built())
    return state


def of_impact(impact: rs.Impact) -> State:
    """Return the state of an impact; refuse one that the page cannot show."""
    if not isinstance(impact, rs.Impact):
        raise InputError("impact", rule="must be an Impact or the name of a case file")
    if impact.shape:
        raise InputError("impact", rule=f"must be a single impact, but has shape {impact.shape}")
    names = {profile: name for name, profile in Geometry.registered.items()}
    values: State = {"mass_from": "mass", "partner": _partner_of(impact)}
    profile = impact.profile
    if isinstance(profile, rs.Layer):
        values |= {"target": LAYER, "profile.thickness": float(profile.thickness), "profile.base": profile.base}
        profile = profile.profile
    elif not math.isinf(impact.impedance):
        values |= {"target": PLATE, "impact.impedance": float(impact.impedance)}
    elif not impact.is_single_body:
        rule = "must have one ball: of two, the page has the radii and masses, and takes them from a case file"
        raise InputError("impact", rule=rule)
    kind = type(profile)
    if kind not in names or names[kind] not in {option.value for option in inputs()["profile.type"].options}:
        raise InputError("impact", rule=f"has a profile that the explorer does not show: {kind.__name__}")
    values["profile.type"] = names[kind]
    for name in constants_of(kind):
        key = "body.radius" if name == "radius" and kind.body_radius else f"profile.{name}"
        values[key] = float(getattr(profile, name))
    if isinstance(profile, rs.Pyramid):
        values[SIDES] = profile.sides
    for name in ("velocity", "external_force"):
        values[f"impact.{name}"] = float(getattr(impact, name))
    values["impact.body_size"] = float(impact.body_size or 0.0)
    values["impact.material_of"] = "body" if impact.diameters == BALL_ON_TARGET[::-1] else SOFT
    values |= {"body.mass": float(impact.mass)} | _of_sliding(impact) | _of_adhesion(impact)
    return values | of_material(impact.material)


def _of_adhesion(impact: rs.Impact) -> State:
    """Return the state of the adhesion."""
    if (adhesion := impact.adhesion) is None:
        return {}
    numbers = {f"adhesion.{name}": float(getattr(adhesion, name)) for name in ("work", adhesion.held)}
    return {"sticking": adhesion.held} | numbers


def _of_sliding(impact: rs.Impact) -> State:
    """Return the state of friction, angle and spin; refuse those that the page does not have."""
    if impact.friction is None:
        return {}
    friction, gyration = float(impact.friction), float(impact.gyration)
    if not math.isfinite(friction):
        raise InputError("friction", friction, "must be finite on the page")
    if gyration != SOLID_BALL:
        raise InputError("gyration", gyration, f"must be {SOLID_BALL:g} on the page, that of a solid ball")
    angle = math.atan2(float(impact.tangential_velocity), float(impact.velocity))
    values = {"motion": OBLIQUE, "impact.friction": friction, "impact.angle": angle}
    return values | ({"impact.spin": float(impact.spin)} if impact.spin else {})


def of_material(material: rs.Material) -> State:
    """Return the state of a material as a standard solid, or else as Prony series in shear and in bulk."""
    shear, bulk = material.shear, material.bulk
    if is_standard_solid(material) and shear.equilibrium_modulus > 0.0:
        branch, duration = float(shear.branch_moduli[0]), float(shear.relaxation_times[0])
        values: State = {
            "material.model": "standard_solid", "material.equilibrium_modulus": shear.equilibrium_modulus,
            "material.branch_modulus": branch, "material.viscosity": branch * duration,
        }  # fmt: skip
    else:
        values = {"material.model": "prony"} | _of_series("shear", shear)
    if material.density is not None:
        values["material.density"] = material.density
    if not isinstance(bulk, rs.PronySeries):
        return values | {"bulk": INFINITE}
    if bulk.is_elastic:
        return values | {"bulk": "bulk_modulus", "material.bulk_modulus": bulk.equilibrium_modulus}
    return values | {"bulk": "series"} | _of_series("bulk", bulk)


def _of_series(part: str, series: rs.PronySeries) -> State:
    names = ("equilibrium_modulus", "branch_moduli", "relaxation_times", "parallel_viscosity")
    return {f"material.{part}.{name}": np.asarray(getattr(series, name)).tolist() for name in names}
