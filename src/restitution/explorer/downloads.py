"""A state as a case file and as Python, to be copied."""

from __future__ import annotations

import json
import math
from collections.abc import Mapping
from typing import Any

from restitution.checks import one_of
from restitution.contact.geometry import Geometry
from restitution.explorer.answers import case_of, indentation_case
from restitution.explorer.state import case_content, indentation_content
from restitution.material import fractional
from restitution.material.models import constants_of
from restitution.material.prony import PronySeries


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
    problem = case.impact
    kind = Geometry.registered[content["profile"]["type"]]
    names = {*constants_of(kind), *content["profile"]} - {"type"}
    given = {name: getattr(problem.profile, name) for name in sorted(names)}
    arguments = {"mass": problem.mass, "velocity": problem.velocity}
    if problem.external_force:
        arguments["external_force"] = problem.external_force
    lines = ["import restitution as rs", "", f"material = {_material(content['material'], case)}"]
    within = ".within(window)" if case.sections.needs_window else ""
    impact = f"rs.Impact(material{within}, rs.{kind.__name__}({_keywords(given)}), {_keywords(arguments)})"
    lines.append(f"impact = rs.for_contact(lambda window: {impact})" if within else f"impact = {impact}")
    return "\n".join([*lines, "result = rs.solve(impact)", "print(result)", "print(result.validity)", ""])


def _material(section: Mapping[str, Any], case: Any) -> str:
    if "library" in section:
        found = f"rs.library.get({section['library']!r})"
        return f"{found}.at({section['temperature']!r})" if "temperature" in section else found
    material = case.impact.material
    density = "" if material.density is None else f", density={material.density!r}"
    bulk: Any = material.bulk
    bulk = bulk if isinstance(bulk, float) or not bulk.is_elastic else bulk.equilibrium_modulus
    if case.sections.needs_window:
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
    return 'float("inf")' if value == math.inf else repr(value)
