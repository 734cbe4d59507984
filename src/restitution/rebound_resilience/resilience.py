"""Rebound resilience of a material in a standard test."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace
from typing import Any, cast

import numpy as np
from numpy.typing import ArrayLike, NDArray

from restitution import validity
from restitution.checks import items, single, single_positive, within
from restitution.contact.contact import Contact
from restitution.contact.geometry import Geometry
from restitution.contact.layer.layer import Base, Layer
from restitution.contact.profile import Parabola
from restitution.errors import InputError, InputTypeError
from restitution.impact.batch import solve_columns
from restitution.impact.problem import STANDARD_GRAVITY, Impact
from restitution.impact.status import SolverError, Status
from restitution.material.viscoelastic import Material
from restitution.quantities import INPUTS, check, check_single, known
from restitution.rebound_resilience.result import COLUMNS, Resilience
from restitution.rebound_resilience.standards import STANDARDS

Array = NDArray[np.float64]

BASES = ("bonded", "frictionless", "half-space")
"""Ways to hold the pad. The holder of a test is between bonded and frictionless; a half-space is a thick pad."""


def resilience(
    material: Material,
    standard: str = "ISO 4662",
    *,
    temperature: ArrayLike | None = None,
    base: str | Sequence[str] | None = None,
    thickness: float | None = None,
    tip_radius: float | None = None,
    mass: float | None = None,
    rtol: float = 1e-9,
) -> Resilience:
    """Rebound resilience R = e^2 of a material in a standard test, at temperatures.

    Parameters
    ----------
    material : Material
        Material of the pad.
    standard : {"ISO 4662", "DIN 53512", "ASTM D7121", "ASTM D2632", "ISO 8307", "ASTM D3574"}
        The test: indentor, mass, velocity and thickness of the pad, with the source of each number in
        `result.standard.sources`.
    temperature : float or array, optional
        Temperatures [K]; the material needs a shift. By default that of the material.
    base : str or sequence of str
        How the pad is held: "bonded", "frictionless", between which the holder of a test is, or "half-space", a thick
        pad. By default all that hold for the material: a bonded pad needs a Poisson ratio that is constant in time,
        or near 1/2.
    thickness : float, optional
        Thickness of the pad [m] in place of that of the standard, from 0.1 mm to 1 m.
    tip_radius : float, optional
        Radius of the indentor [m] in place of that of the standard.
    mass : float, optional
        Mass of the indentor [kg] in place of that of the standard. ASTM D2632 needs the radius and the mass, because
        no reliable source had them.
    rtol : float
        Relative error of the coefficient of restitution, from 1e-12 to 1e-2.

    Returns
    -------
    Resilience
        R in per cent, contact time, depth, contact radius, force and loss tangent, with a table and a picture.

    Raises
    ------
    InputError
        If the standard or base is not known, a number is out of range, or a temperature is given without a shift.
    SolverError
        If a solve fails.

    Notes
    -----
    The impact is that of a rigid parabola of the radius of the indentor, without friction. The weight acts where the
    body falls. These tests are at the edge of small strain: a/R is near 1 for soft rubber. R is a trend then, not a
    certificate; `result.warnings` has the numbers.

    Examples
    --------
    >>> import math
    >>> import restitution as rs
    >>> rubber = rs.Material(rs.PronySeries(1e6, [2e5, 8e5], [1e-3, 1e-4]), math.inf)
    >>> result = rs.resilience(rubber, "ASTM D7121", base="half-space")
    >>> print(result.rebound_resilience.round(1))
    [77.5]
    """
    if not isinstance(material, Material):
        raise InputTypeError("material", material, "must be a Material")
    test = STANDARDS[known("standard", standard, STANDARDS)]
    named = [base] if isinstance(base, str) else [] if base is None else items("base", base, "must be names of bases")
    bases = tuple(known("base", one, BASES) for one in named)
    if base is not None and not bases:
        raise InputError("base", wanted="must name at least one")
    single("rtol", within("rtol", rtol, 1e-12, 1e-2))
    radius = test.radius if tip_radius is None else single_positive("tip_radius", tip_radius, "m")
    weighed = test.mass if mass is None else check_single("mass", mass)
    if radius is None or weighed is None:
        name = "tip_radius" if radius is None else "mass"
        raise InputError(name, wanted=f"must be given: no reliable source had that of {test.name}")
    size = test.thickness if thickness is None else check_single("thickness", thickness)
    within("thickness", size, 1e-4, 1.0, INPUTS["thickness"].unit)
    given = {"radius": tip_radius, "mass": mass, "thickness": thickness}
    sources = {name: source for name, source in test.sources.items() if given.get(name) is None}
    test = replace(test, radius=radius, mass=weighed, thickness=size, sources=sources)
    temperatures = None if temperature is None else np.atleast_1d(check("temperature", temperature))
    if temperatures is not None and (temperatures.ndim != 1 or not temperatures.size):
        raise InputError("temperature", wanted="must be a number or a list of numbers", unit="K")
    bases, notes = _bases(material, radius, size) if base is None else (bases, ())
    if not bases:
        raise InputError("base", wanted=f"must be another: {'; '.join(notes)}")
    force = weighed * STANDARD_GRAVITY if test.falls else 0.0
    impacts = [
        Impact(one, geometry, weighed, test.velocity, external_force=force, body_size=stated)
        for one in ([material] if temperatures is None else [material.at(float(t)) for t in temperatures])
        for geometry, stated in (_pad(held, radius, size) for held in bases)
    ]
    columns = solve_columns(impacts, rtol)
    for status in columns["status"]:
        if Status(int(status)).failed:
            raise SolverError(Status(int(status)))
    found = _columns(columns, impacts, len(bases))
    return Resilience(test, material, bases, temperatures, validity=_validity(columns, impacts), notes=notes, **found)


def _bases(material: Material, radius: float, thickness: float) -> tuple[tuple[str, ...], tuple[str, ...]]:
    """Ways to hold a pad of a material, and why others are left out."""
    bases, notes = list[str](), list[str]()
    for base in BASES:
        try:
            Contact(material, _pad(base, radius, thickness)[0])
        except InputError as error:
            notes.append(f"a {base} pad is left out: {error}")
        else:
            bases.append(base)
    return tuple(bases), tuple(notes)


def _pad(base: str, radius: float, thickness: float) -> tuple[Geometry, float | None]:
    """Geometry of the contact, and the size of the pad where the geometry does not contain it."""
    if base == "half-space":
        return Parabola(radius), thickness
    return Layer(Parabola(radius), thickness, cast("Base", base), strict=True), None


def _columns(columns: dict[str, Array], impacts: list[Impact], n_bases: int) -> dict[str, Array]:
    time = columns["contact_time"]
    omega = math.pi / np.where(np.isfinite(time), time, 1.0)
    tangent = [
        one.reduced_modulus.loss_modulus(rate) / one.reduced_modulus.storage_modulus(rate)
        for one, rate in zip(impacts, omega, strict=True)
    ]
    found: dict[str, Any] = {
        **columns,
        "rebound_resilience": 100.0 * columns["restitution_coefficient"] ** 2,
        "loss_tangent": np.where(np.isfinite(time), tangent, np.nan),
    }
    return {name: found[name].reshape(-1, n_bases) for name in COLUMNS}


def _validity(columns: dict[str, Array], impacts: list[Impact]) -> validity.Validity:
    outputs = {name: columns[name] for name in validity.COLUMNS}
    velocity, mass = (np.array([getattr(one, name) for one in impacts]) for name in ("velocity", "mass"))
    found = validity.numbers([one.contact for one in impacts], **outputs, velocity=velocity, mass=mass)
    # The indentor is the tip of a heavier body.
    return validity.Validity(tuple(check for check in validity.report(found) if check.kind != "density"))
