"""Named materials with source, window and assumptions; each is an attribute too: `library.epoxy`."""

from __future__ import annotations

import tomllib
from functools import cache
from importlib.resources import files
from typing import Any

from restitution import quantities
from restitution.errors import InputError
from restitution.material.cards import PronyTerms
from restitution.material.classical import elastic
from restitution.material.conversion import shear_and_bulk
from restitution.material.readers import MaterialFile, parse
from restitution.material.shift import WLF, ShiftTable
from restitution.material.viscoelastic import Material

__all__ = ["get", "names"]

_CONSTANTS = ("shear_modulus", "youngs_modulus", "poisson_ratio", "bulk_modulus")
_ABOUT = ("density", "temperature", "source", "assumptions")


def names() -> list[str]:
    """Return names of all materials, in alphabetical order.

    Examples
    --------
    >>> "epoxy" in names()
    True
    """
    return list(_entries())


def get(name: str) -> Material:
    """Return the material of that name, with its `source`, `window` and `assumptions`.

    Parameters
    ----------
    name
        One of `names()`.

    Raises
    ------
    InputError
        If there is no such material; the message names the nearest one, or all.

    Examples
    --------
    >>> material = get("polyisobutylene")
    >>> material.shear.n_branches, material.shear.is_liquid, material.temperature
    (30, True, 298.0)
    >>> print(round(material.at(273.15).shear.relaxation_times[0] / material.shear.relaxation_times[0], 3))
    16.55
    """
    quantities.choice("material", name, names())
    return _build(name)


def citation_keys(name: str) -> list[str]:
    """Return keys of the sources of a material in `restitution/citation/references.bib`."""
    return _entries()[name]["cite"]


def __getattr__(name: str) -> Material:
    if name.startswith("_"):
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    try:
        return get(name)
    except InputError as error:
        raise AttributeError(str(error)) from None


def __dir__() -> list[str]:
    return sorted([*__all__, *_entries()])


def _text(name: str) -> str:
    return files("restitution.material").joinpath("data", name).read_text(encoding="utf-8")


@cache
def _entries() -> dict[str, dict[str, Any]]:
    return dict(sorted(tomllib.loads(_text("library.toml")).items()))


def _file(name: str) -> MaterialFile:
    return parse(_text(f"{name}.csv"), name)


@cache
def _build(name: str) -> Material:
    entry = _entries()[name]
    window, shift = entry.get("window"), None
    if "terms" in entry:
        terms = _file(entry["terms"])
        assert isinstance(terms, PronyTerms)
        window = window or terms.window
        shear, bulk = shear_and_bulk(terms.series(), entry["bulk_modulus"], None, terms.deformation, None)
    else:
        solid = elastic(**{key: entry[key] for key in _CONSTANTS if key in entry})
        shear, bulk = solid.shear, solid.bulk
    if "shift_factors" in entry:
        shift = _file(entry["shift_factors"])
        assert isinstance(shift, ShiftTable)
    elif "shift" in entry:
        law = entry["shift"]
        shift = WLF(**law | {"temperature_range": tuple(law["temperature_range"])})
    about = {key: entry.get(key) for key in _ABOUT}
    return Material(shear, bulk, name=name, shift=shift, window=window, **about)
