"""Sources of the methods, materials and profiles of a problem, in BibTeX."""

from __future__ import annotations

import re
from collections.abc import Iterator
from functools import cache, singledispatch
from importlib.resources import files
from typing import Any

import numpy as np

import restitution as rs
from restitution.case.indentation import IndentationCase
from restitution.contact.geometry import Geometry
from restitution.errors import InputTypeError
from restitution.sweeps.plan import Plan

Reason = tuple[str, str]

_ENTRY = re.compile(r"^@\w+\{(?P<key>\w+),\n.*?^\}$", re.DOTALL | re.MULTILINE)

_CONTACT = (
    ("lee1960", "contact of viscoelastic bodies while it grows"),
    ("ting1966", "contact of viscoelastic bodies while it shrinks"),
    ("graham1967", "contact of viscoelastic bodies while it shrinks"),
    ("popov2015", "method of dimensionality reduction"),
)
_FRICTION = (
    ("mindlin1953", "contact that partly slips"),
    ("maw1976", "oblique impact with partial slip"),
)
_METHODS: dict[str, tuple[Reason, ...]] = {
    "": (),
    "adhesion": (),
    "exact": (("hairer1996", "collocation by Radau IIA"),),
    "elements": (("willert", "elements with explicit Euler"),),
}
_DERIVATIONS = {
    "fractional": ("mainardi2010", "fractional model"),
    "fit": ("lawson1974", "Prony fit by non-negative least squares"),
}
_PROGRAM = (("restitution", "this program"), ("willert", "the paper that the program reproduces"))


@cache
def entries() -> dict[str, str]:
    """Return the BibTeX entries by their keys, in alphabetical order."""
    from importlib.metadata import version

    text = files("restitution.citation").joinpath("references.bib").read_text(encoding="utf-8")
    text = text.replace("VERSION", version("restitution"))
    return {match["key"]: match[0] for match in _ENTRY.finditer(text)}


def cite(*subjects: Any) -> str:
    """Return the BibTeX of what a problem used: methods, sources of the materials, transforms of the profiles.

    Parameters
    ----------
    *subjects : Impact, ImpactResult, IndentationResult, Bounces, Resilience, Case, Material or Geometry
        Problems, results, or parts of them; what case files of impacts, indentations and sweeps become.
        Without any, the program and the paper that it reproduces.

    Returns
    -------
    str
        The entries, each once, under a comment with its purpose.

    Raises
    ------
    TypeError
        If a subject is something else.

    Examples
    --------
    >>> import restitution as rs
    >>> print(cite(rs.library.get("epoxy")))
    % data of epoxy
    @article{simon2000,
      author = {Simon, S. L. and McKenna, G. B. and Sindt, O.},
      title = {Modeling the evolution of the dynamic mechanical properties of a commercial epoxy during ...},
      journal = {Journal of Applied Polymer Science},
      volume = {76},
      pages = {495--508},
      year = {2000}
    }
    """
    texts = entries()
    return "\n\n".join(f"% {'; '.join(uses)}\n{texts[key]}" for key, uses in citations(*subjects).items())


def citations(*subjects: Any) -> dict[str, list[str]]:
    """Return the keys of the sources that problems used, and what each is cited for.

    Examples
    --------
    >>> from restitution.contact.profiles import Cone
    >>> citations(Cone(half_angle=1.2))
    {'love1939': ['contact of a cone'], 'sneddon1965': ['transform of the profile']}
    """
    purposes: dict[str, list[str]] = {}
    for subject in subjects or (None,):
        for key, use in _reasons(subject) if subjects else _PROGRAM:
            uses = purposes.setdefault(key, [])
            if use not in uses:
                uses.append(use)
    return purposes


@singledispatch
def _reasons(subject: Any) -> Iterator[Reason]:
    raise InputTypeError("subject", subject, "must be an Impact, a result, a Case, a Material or a profile")


def _problem(method: str, *contacts: rs.Impact | rs.IndentationResult | IndentationCase) -> Iterator[Reason]:
    yield _PROGRAM[0]
    yield from _METHODS[method]
    for contact in contacts:
        yield from _CONTACT
        yield from _reasons(contact.profile)
        if isinstance(contact, rs.Impact) and np.any(np.isfinite(contact.impedance)):
            yield "zener1941", "target that recedes under the impact"
        if isinstance(contact, rs.Impact) and contact.friction is not None:
            yield from _FRICTION
        if isinstance(contact, rs.Impact) and contact.adhesion is not None:
            yield "maugis1992", "adhesive contact with an attraction of constant stress"
        for material in (contact.material, contact.counter_material):
            if material is not None:
                if _is_standard_solid(material):
                    yield "willert", "impact on the compressible standard solid"
                yield from _reasons(material)


@_reasons.register(rs.Impact)
@_reasons.register(rs.IndentationResult)
@_reasons.register(IndentationCase)
def _(subject: Any) -> Iterator[Reason]:
    return _problem("", subject)


@_reasons.register
def _(subject: rs.ImpactResult) -> Iterator[Reason]:
    return _problem(subject.method, *(subject.impact if isinstance(subject.impact, list) else [subject.impact]))


@_reasons.register
def _(subject: rs.Bounces) -> Iterator[Reason]:
    return _problem("exact", subject.impact)


@_reasons.register
def _(subject: rs.Case) -> Iterator[Reason]:
    return _problem(subject.sections.solver.method, subject.impact)


@_reasons.register
def _(subject: Plan) -> Iterator[Reason]:
    return _problem("exact", subject.impact)


@_reasons.register
def _(subject: rs.Resilience) -> Iterator[Reason]:
    yield from (_PROGRAM[0], *_METHODS["exact"], *_CONTACT)
    yield from ((key, f"numbers of {subject.standard.name}") for key in subject.standard.keys)
    yield from _reasons(subject.material)


@_reasons.register
def _(subject: Geometry) -> Iterator[Reason]:
    yield from subject.sources
    if isinstance(subject, rs.Layer):
        yield from subject.profile.sources


@_reasons.register
def _(subject: rs.Material) -> Iterator[Reason]:
    for name in rs.library.names():
        if _is(subject, rs.library.get(name)):
            yield from ((key, f"data of {name}") for key in rs.library.citation_keys(name))
    if subject.derivation is not None:
        yield _DERIVATIONS[subject.derivation]
    shift = subject.shift
    if isinstance(shift, (rs.WLF, rs.Arrhenius)) and np.any(subject.temperature != shift.reference_temperature):
        for key in ("williams1955", "ferry1980") if isinstance(shift, rs.WLF) else ("ferry1980",):
            yield key, "time-temperature shift"


def _is(material: rs.Material, entry: rs.Material) -> bool:
    """Return whether a material is one of the library, perhaps under another name, density or temperature."""
    same = np.all(material.shear.equilibrium_modulus == entry.shear.equilibrium_modulus)
    return bool(same) and material.source is not None and material.source == entry.source


def _is_standard_solid(material: rs.Material) -> bool:
    shear, bulk = material.shear, material.bulk
    constant = not isinstance(bulk, rs.PronySeries) or bulk.is_elastic
    solid = (np.asarray(shear.equilibrium_modulus) > 0) & (np.asarray(shear.parallel_viscosity) == 0) & constant
    return shear.n_branches == 1 and bool(np.all(solid))
