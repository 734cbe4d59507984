"""The contact law as a C99 header: its compiled functions, translated by `c_code`, and constants of one law."""

from __future__ import annotations

from collections.abc import Sequence
from importlib.resources import files
from string import Template
from textwrap import indent, wrap

from restitution.kernel import adhesion, contact_law, course, dissipation, edge, waiting, zone
from restitution.law import slide, step
from restitution.law.c_code import WIDTH, translated

_VALUES = {"nan": "NAN", "inf": "INFINITY"}


# The tangential half, behind the normal one.
_SLIDE = """

/* Constants of friction; see the module restitution.law.slide. */
static const double {name}_grip[{count}] = {{
{constants}
}};
"""
_CALL = """

/* Advance the tangential half of a contact after {name}_step, which has returned the force: way [m] of the contact
   points past each other in the step, and pull [N], the force that resists it, along two axes at right angles. */
static inline void {name}_slide(double *state, double force, const double *way, double dt, double *pull)
{{
    {name}_drag({name}_constants, {name}_grip, state, force, way, dt, pull);
}}
"""


def header(
    name: str,
    paragraphs: Sequence[str],
    constants: Sequence[tuple[float, str]],
    size: int,
    grip: Sequence[tuple[float, str]] = (),
) -> str:
    """Return the text of a header.

    Parameters
    ----------
    name
        Start of all names in the header.
    paragraphs
        What the law is.
    constants, size
        The constants, each with its meaning, and the length of a state.
    grip
        The constants of friction, if the law has a tangential force.
    """
    modules, entries = ([step, slide], ["step", "slide"]) if grip else ([step], ["step"])
    upper, parts = name.upper(), translated(name, modules, entries)
    slid = _SLIDE.format(name=name, count=len(grip), constants=_listed(grip)).rstrip() if grip else ""
    return _filled(
        "contact_law",
        text=_commented(paragraphs), guard=f"{upper}_H", upper=upper, name=name, size=size, count=len(constants),
        places=parts.places, numbers=parts.numbers, constants=_listed(constants), slid=slid,
        call=_CALL.format(name=name).rstrip() if grip else "", functions=parts.functions,
    )  # fmt: skip


def adhesive_header(
    name: str, paragraphs: Sequence[str], constants: Sequence[tuple[float, str]], size: int, reach: float
) -> str:
    """Return the text of a header of a law with adhesion; `reach` is the range [m] of the attraction.

    The other parameters are those of `header`.
    """
    modules = [zone, waiting, edge, course, dissipation, adhesion, contact_law]
    parts, upper = translated(name, modules, ["advance"]), name.upper()
    elements, modes = (int(constants[place][0]) for place in (contact_law.ELEMENTS, contact_law.MODES))
    return _filled(
        "adhesive_law",
        text=_commented(paragraphs), guard=f"{upper}_H", upper=upper, name=name, size=size, count=len(constants),
        places=parts.places, numbers=parts.numbers, constants=_listed(constants), structures=parts.structures,
        functions=parts.functions, elements=elements, modes=modes, reach=repr(reach),
    )  # fmt: skip


def _filled(template: str, **texts: object) -> str:
    source = files("restitution.law").joinpath(f"{template}.h.template").read_text(encoding="utf-8")
    return Template(source).substitute({key: str(text) for key, text in texts.items()})


def _commented(paragraphs: Sequence[str]) -> str:
    return "\n".join(line for text in paragraphs for line in wrap(_safe(text), WIDTH) or [""])


def _listed(constants: Sequence[tuple[float, str]]) -> str:
    entries = [f"{_VALUES.get(repr(value), repr(value))}, /* {_safe(meaning)} */" for value, meaning in constants]
    return indent("\n".join(entries), "    ")


def _safe(text: str) -> str:
    """Return a text that does not end a comment."""
    return text.replace("*/", "* /").replace("/*", "/ *")
