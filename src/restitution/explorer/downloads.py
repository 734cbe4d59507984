"""A state as a case file and as Python, to be copied."""

from __future__ import annotations

import json
import math
from collections.abc import Mapping
from typing import Any

from restitution.checks import one_of
from restitution.contact.profile import Profile
from restitution.explorer.answers import case_of, indentation_case
from restitution.explorer.state import case_content, indentation_content
from restitution.material.models import constants_of, material_models


def download(content: Mapping[str, Any]) -> dict[str, Any]:
    """Return the name, type and text of a file that states the case of a request."""
    what = one_of("what", content.get("what"), ("case", "indentation", "python"))
    state = content.get("state", {})
    if what == "python":
        return {"name": "impact.py", "type": "text/x-python", "text": python(state)}
    # What the page shows can be read again.
    _ = case_of(state) if what == "case" else indentation_case(state)
    table = case_content(state) if what == "case" else indentation_content(state)
    return {"name": f"{what}.toml", "type": "application/toml", "text": toml(table)}


def toml(content: Mapping[str, Any]) -> str:
    """Return the text of a case file."""
    lines: list[str] = []
    for section, table in content.items():
        lines += [f"[{section}]", *(f"{key} = {_toml_value(value)}" for key, value in table.items()), ""]
    return "\n".join(lines)


def _toml_value(value: Any) -> str:
    if isinstance(value, Mapping):
        return "{ " + ", ".join(f"{key} = {_toml_value(one)}" for key, one in value.items()) + " }"
    return json.dumps(value).replace("Infinity", "inf")


def python(state: Mapping[str, Any]) -> str:
    """Return the text of a program that solves the impact of a state."""
    case = case_of(state)
    content = case_content(state)
    impact = case.impact
    profile = content["profile"]
    kind = Profile.registered[profile["type"]]
    given = {name: getattr(impact.profile, name) for name in constants_of(kind)}
    arguments = {"mass": impact.mass, "velocity": impact.velocity}
    if impact.external_force:
        arguments["external_force"] = impact.external_force
    fractional = case.sections.needs_window
    material = _material(content["material"], case)
    window = ".within(window)" if fractional else ""
    call = f"rs.Impact({'solid' if fractional else 'material'}{window}, rs.{kind.__name__}({_keywords(given)}), "
    call += f"{_keywords(arguments)})"
    lines = ["import restitution as rs", ""]
    if fractional:
        lines += [f"solid = {material}", f"impact = rs.for_contact(lambda window: {call})"]
    else:
        lines += [f"material = {material}", f"impact = {call}"]
    return "\n".join([*lines, "result = rs.solve(impact)", "print(result)", "print(result.validity)", ""])


def _material(section: Mapping[str, Any], case: Any) -> str:
    if "library" in section:
        found = f"rs.library.get({section['library']!r})"
        return f"{found}.at({section['temperature']!r})" if "temperature" in section else found
    if "model" in section:
        assert section["model"] in material_models()
        return f"rs.{section['model']}({_keywords({k: v for k, v in section.items() if k != 'model'})})"
    material = case.impact.material
    series = [one if isinstance(one, float) else f"rs.{one!r}" for one in (material.shear, material.bulk)]
    shear, bulk = (_python_value(one) if isinstance(one, float) else one for one in series)
    density = "" if material.density is None else f", density={material.density!r}"
    return f"rs.Material({shear}, {bulk}{density})"


def _keywords(values: Mapping[str, Any]) -> str:
    return ", ".join(f"{name}={_python_value(value)}" for name, value in values.items())


def _python_value(value: Any) -> str:
    return 'float("inf")' if value == math.inf else repr(value)
