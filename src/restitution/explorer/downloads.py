"""A state as a case file and as Python, to be copied."""

from __future__ import annotations

import json
import math
from collections.abc import Callable, Mapping
from typing import Any

from restitution.case.material import is_fractional
from restitution.checks import one_of
from restitution.contact.geometry import BALL_ON_TARGET
from restitution.contact.layer.layer import Layer
from restitution.explorer.answers import case_of, indentation_case, tapping_case
from restitution.explorer.inputs import case_content, indentation_content, tapping_content
from restitution.material import fractional
from restitution.material.models import constants_of
from restitution.material.prony import PronySeries


def download(content: Mapping[str, Any]) -> dict[str, Any]:
    """Return the name, type and text of a file that states the case of a request."""
    what = one_of("what", content.get("what"), _FILES)
    state = content.get("state", {})
    if what == "python":
        return {"name": "impact.py", "type": "text/x-python", "text": python(state)}
    if what == "indentation python":
        return {"name": "indentation.py", "type": "text/x-python", "text": indentation_python(state)}
    if what == "tapping python":
        return {"name": "tapping.py", "type": "text/x-python", "text": tapping_python(state)}
    # What the page shows can be read again.
    built, content_of = _BUILDERS[what]
    _, table = built(state), content_of(state)
    return {"name": f"{what}.toml", "type": "application/toml", "text": toml(table)}


_BUILDERS: dict[str, tuple[Callable[[Mapping[str, Any]], Any], Callable[[Mapping[str, Any]], dict[str, Any]]]] = {
    "case": (case_of, case_content), "indentation": (indentation_case, indentation_content),
    "tapping": (tapping_case, tapping_content),
}  # fmt: skip
_FILES = (*_BUILDERS, "python", "indentation python", "tapping python")


def toml(content: Mapping[str, Any]) -> str:
    """Return the text of a case file."""
    lines: list[str] = []
    for section, table in content.items():
        lines += [f"[{section}]", *(f"{key} = {_toml_value(value)}" for key, value in table.items()), ""]
    return "\n".join(lines)


def _toml_value(value: Any) -> str:
    if isinstance(value, Mapping):
        return "{ " + ", ".join(f"{key} = {_toml_value(item)}" for key, item in value.items()) + " }"
    return json.dumps(value).replace("Infinity", "inf")


def python(state: Mapping[str, Any]) -> str:
    """Return the text of a program that solves the impact of a state."""
    case = case_of(state)
    content = case_content(state)
    problem = case.impact
    arguments: dict[str, Any] = {"mass": problem.mass, "velocity": problem.velocity}
    for name in ("external_force", "body_size"):
        if value := getattr(problem, name):
            arguments[name] = value
    if math.isfinite(problem.impedance):
        arguments["impedance"] = problem.impedance
    if problem.friction is not None:
        arguments |= {name: getattr(problem, name) for name in ("friction", "tangential_velocity", "spin")}
    if problem.diameters != BALL_ON_TARGET:
        arguments["diameters"] = problem.diameters
    fractional = case.sections.needs_window
    material = _material(content["material"], problem.material, fractional)
    lines = ["import restitution as rs", "", f"material = {material}"]
    within = ".within(window)" if fractional else ""
    numbers, counter = _keywords(arguments), content.get("counter_material", {})
    if "library" in counter and counter != content["material"]:
        numbers += f", counter_material={_material(counter, problem.counter_material, False)}"
    elif problem.counter_material is not None:
        numbers += f", counter_material=material{within}"
    if problem.adhesion is not None:
        numbers += f", adhesion=rs.Adhesion({_keywords(content['adhesion'])})"
    impact = f"rs.Impact(material{within}, {_profile(problem.profile)}, {numbers})"
    lines.append(f"impact = rs.for_contact(lambda window: {impact})" if within else f"impact = {impact}")
    return "\n".join([*lines, "result = rs.solve(impact)", "print(result)", "print(result.validity)", ""])


def _profile(profile: Any) -> str:
    """Return the text of a profile, on a layer too."""
    if isinstance(profile, Layer):
        return f"rs.Layer(rs.{profile.profile!r}, {profile.thickness!r}, {profile.base!r})"
    return f"rs.{profile!r}"


def indentation_python(state: Mapping[str, Any]) -> str:
    """Return the text of a program that solves the indentation of a state."""
    case, content = indentation_case(state), indentation_content(state)
    course = dict(content["indentation"])
    shape, largest = course.pop("shape"), course.pop(case.prescribed)
    material = _windowed(content["material"], case.material)
    arguments = ", ".join([repr(largest), _keywords(course)])
    lines = [
        "import restitution as rs", "", f"material = {material}",
        f"profile = {_profile(case.profile)}", f"{case.prescribed} = rs.{shape}({arguments})",
        f"result = rs.indent(material, profile, {case.prescribed}={case.prescribed})", "print(result)", "",
    ]  # fmt: skip
    return "\n".join(lines)


def tapping_python(state: Mapping[str, Any]) -> str:
    """Return the text of a program that solves the tapping of a state."""
    case, content = tapping_case(state), tapping_content(state)
    arguments = dict(content["tapping"])
    factors = arguments.pop("beam_quality_factors", None)
    numbers = _keywords(arguments)
    if factors is not None:
        beam = {name: arguments[name] for name in ("spring_constant", "frequency")} | {"quality_factors": factors}
        numbers += f", modes=rs.beam_modes({_keywords(beam)})"
    lines = [
        "import restitution as rs", "", f"material = {_windowed(content['material'], case.material)}",
        f"profile = {_profile(case.profile)}", f"result = rs.tap(material, profile, {numbers})", "print(result)", "",
    ]  # fmt: skip
    return "\n".join(lines)


def _windowed(section: Mapping[str, Any], material: Any) -> str:
    """Return the text of a material, within its window of time if it is fractional."""
    needs_window = is_fractional(section)
    text = _material(section, material, needs_window)
    return f"{text}.within({tuple(material.window)!r})" if needs_window else text


def _material(section: Mapping[str, Any], material: Any, needs_window: bool) -> str:
    if "library" in section:
        text = f"rs.library.get({section['library']!r})"
        return f"{text}.at({section['temperature']!r})" if "temperature" in section else text
    density = "" if material.density is None else f", density={material.density!r}"
    bulk: Any = material.bulk
    bulk = bulk if isinstance(bulk, float) or not bulk.is_elastic else bulk.equilibrium_modulus
    if needs_window:
        names = constants_of(getattr(fractional, section["model"])).keys() & section.keys()
        model = f"rs.{section['model']}({_keywords({name: section[name] for name in section if name in names})})"
        return f"rs.FractionalMaterial({model}, {_python_value(bulk)}{density})"
    if "model" in section:
        return f"rs.{section['model']}({_keywords({k: v for k, v in section.items() if k != 'model'})})"
    return f"rs.Material({_python_value(material.shear)}, {_python_value(bulk)}{density})"


def _keywords(values: Mapping[str, Any]) -> str:
    return ", ".join(f"{name}={_python_value(value)}" for name, value in values.items())


def _python_value(value: Any) -> str:
    if isinstance(value, PronySeries):
        return f"rs.{value!r}"
    if isinstance(value, tuple):
        return f"({', '.join(map(_python_value, value))})"
    return 'float("inf")' if value == math.inf else repr(value)
