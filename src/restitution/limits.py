"""Limits of the assumptions of the theory, and the words of a report for a number beside its limit."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

import numpy as np

from restitution.contact.geometry import approximation
from restitution.quantities import VALIDITY
from restitution.units import in_words

Threshold = float | tuple[float, float]

# Bodies that deform; `Numbers.wave_body` is a place here. The first is a target under a rigid body.
BODIES = "target", "target", "layer", "ball", "first ball", "second ball", "indenter"
BESIDE_RIGID, TARGET, LAYER, BALL, _, _, INDENTER = range(len(BODIES))
TITLES = {
    "small_strain": "small strain", "half_space": "half-space", "waves": "waves",
    "window": "window", "poisson_ratio": "Poisson ratio", "density": "density", "separability": "separability",
    "constants": "constants", "coupling": "coupling", "travel": "travel", "attraction": "attraction",
    "range": "range", "roughness": "roughness",
}  # fmt: skip

# Representative strain 0.2 a/R = 4 % (Tabor 1951); an exact sphere is there 0.4 % softer than its parabola.
STRAIN_LIMIT = 0.2
# Largest shear strain over a/R = d/a, in an incompressible half-space under a parabola.
_SHEAR = 0.7
# A bonded incompressible layer of thickness h is then 6 % stiffer than a half-space.
SIZE_LIMIT = 0.05
# Share of the energy that waves carry away; e falls by half of it at most.
RADIATION_LIMIT = 0.05
# Velocity over wave speed, where no mass is known.
SPEED_LIMIT = 0.01
# Dundurs' parameter over friction: up to it v_c'/(mu v0) of an elastic impact changes by some 0.03.
COUPLING_LIMIT = 0.3
# Way of the centre in contact over the largest contact radius, up to which the patch counts as at rest.
TRAVEL_LIMIT = 0.5
# Slope of the surfaces in the attracted ring, (4/pi) sigma0/E* of a thin one: a strain of the same size.
SLOPE_LIMIT = 0.2
# Range of the attraction over the largest depth, from which its form matters as much as its work.
RANGE_LIMIT = 1.0
# From below any foam to above osmium.
DENSITY_LIMITS = (1.0, 3e4)
# Difference of two Poisson ratios that is rounding.
_ROUNDING = 1e-9
# Constants that are not determined: some, or all moduli and times but for a common scale.
SOME, SCALE = 1.0, 2.0


def dips(lowest: Any, instantaneous: Any, static: Any) -> Any:
    """Return whether a Poisson ratio is lower between its ends than at both, as it may be where both moduli relax."""
    return lowest < np.minimum(instantaneous, static) - _ROUNDING


def poisson_excess(lowest: Any, instantaneous: Any, static: Any, *_: Any) -> Any:
    """Return how far a Poisson ratio falls below zero, or below a negative static one, which is a choice."""
    least = np.where(dips(lowest, instantaneous, static), lowest, instantaneous)
    return np.minimum(static, 0.0) - least


def _small_strain(worst: Any, exceeded: bool) -> tuple[str, str]:
    number = "max(a/R, d/a)" if worst.round_body else "d/a" if math.isnan(worst.slope) else "the slope of the faces"
    text = f"{number} is {_beside(worst.strain_number, STRAIN_LIMIT)}"
    if worst.no_such_contact > 0.0:
        text += "; a body of this radius has no such contact"
        return text, "Discard the result: the contact radius, or the depth, exceeds the radius of the body."
    if worst.is_layer_strain > 0.0:
        text = (
            f"the strain number of the layer is {_beside(worst.strain_number, STRAIN_LIMIT)}; the body is pressed in "
        )
        text += f"by {100 * worst.layer_strain:.2g} % of the thickness, with shear strains of some "
        text += f"{100 * _SHEAR * worst.strain_number:.2g} %"
        return text, "Take a lower velocity or depth, or a thicker layer, or read the numbers as a trend."
    if worst.round_body:
        text += f"; the representative strain is about {20 * worst.strain_number:.2g} %"
    return text, "Take a lower velocity or depth, or a larger or blunter body, or read the numbers as a trend."


def _half_space(worst: Any, exceeded: bool) -> tuple[str, str]:
    x = worst.contact_size_ratio
    # Expansion for a parabola on a bonded incompressible layer; the exact factor at 0.5 is 2.156.
    more = f"{np.polynomial.Polynomial([0, 112.7, 148.17, 147.0, 100.5])(x):.0f} %" if x <= 0.5 else "more than 100 %"
    text = f"contact radius over size of the target is {_beside(x, SIZE_LIMIT)}; "
    text += f"a bonded incompressible layer would be {more} stiffer"
    return text, "Solve the layer (rs.Layer), take a thicker target, or read the result as that of a thick target."


def _waves(worst: Any, exceeded: bool) -> tuple[str, str]:
    share, deep = worst.radiated_energy_ratio, f"{0.5 * worst.wave_speed * worst.contact_time:.3g} m"
    place = 0 if math.isnan(worst.wave_body) else int(worst.wave_body)
    body = BODIES[place]
    if share == 0.0:
        return f"they return in contact, as the {body} is not deeper than {deep}, or count by its impedance", ""
    has_size = math.isfinite(worst.wave_size)
    text = f"{VALIDITY['radiated_energy_ratio'].words} is {_beside(share, RADIATION_LIMIT)}, in the {body}"
    text += f"{', which is' if has_size else ' if it is'} deeper than c T/2 = {deep}; v0/c = {worst.mach_number:.3g}"
    if math.isnan(share):
        text = f"{VALIDITY['mach_number'].words} is {_beside(worst.mach_number, SPEED_LIMIT)}, in the {body}"
    advice = (
        "Expect a lower rebound" if has_size else f"Expect a lower rebound where the {body} is deep, or state its size"
    )
    if place == BESIDE_RIGID and worst.round_body and not has_size:
        advice += ", or that the ball is the soft body"
    return f"{text}; c = {worst.wave_speed:.3g} m/s", f"{advice}; take a lower velocity."


def _window(worst: Any, exceeded: bool) -> tuple[str, str]:
    text = f"the contact lasts {worst.contact_time:.3g} s and its beginning {worst.shortest_time:.3g} s, "
    text += f"the material is known from {worst.window_low:.3g} s to {worst.window_high:.3g} s"
    text += f", which is short by a factor of {worst.window_ratio:.3g}" if exceeded else ""
    return text, "Measure at these times, or shift data of other temperatures; the modulus is extrapolated."


def _poisson_ratio(worst: Any, exceeded: bool) -> tuple[str, str]:
    value, limit, lowest = worst.instantaneous_poisson_ratio, min(worst.poisson_ratio, 0.0), worst.lowest_poisson_ratio
    if dips(lowest, value, worst.poisson_ratio):
        text = f"the lowest one over time is {lowest:.3g}, {'below' if exceeded else 'not below'} "
        text += f"the limit {limit:.3g}; the instantaneous one is {value:.3g}, the static one "
        text += f"{worst.poisson_ratio:.4g}"
        return text, "Let the bulk modulus relax less, or not before the shear modulus; polymers have 0.3 to 0.5."
    ratio = 2.0 * (1.0 + value) / (3.0 * (1.0 - 2.0 * value)) if value < 0.5 else math.inf
    text = f"the instantaneous one is {value:.3g}, {'below' if exceeded else 'not below'} the limit {limit:.3g}; "
    text += f"the static one is {worst.poisson_ratio:.4g}, K/G0 = {ratio:.3g}"
    return text, "Raise the bulk modulus or lower the instantaneous shear modulus; polymers have 0.3 to 0.4."


def _density(worst: Any, exceeded: bool) -> tuple[str, str]:
    low, high = DENSITY_LIMITS
    limits = f"{'outside' if exceeded else 'within'} {low:g} to {high * worst.density_factor:g} kg/m^3"
    text = f"a ball of this mass and radius has {worst.mean_density:.3g} kg/m^3, {limits}"
    return text, "Compare the units of mass (kg) and radius (m), unless a heavy body with a small tip is meant."


def _separability(worst: Any, exceeded: bool) -> tuple[str, str]:
    ends = worst.instantaneous_poisson_ratio, worst.poisson_ratio
    return approximation(*ends, worst.lowest_poisson_ratio, worst.highest_poisson_ratio)


def _constants(worst: Any, exceeded: bool) -> tuple[str, str]:
    text = "data behind the material do not determine all of its constants; "
    if worst.undetermined_constants >= SCALE:
        text += "contact time, depth, force, pressure and radius are not determined, only the restitution coefficient"
        return text, "Measure a contact time, a force or a modulus, and identify the material again."
    text += "outputs are determined only for contacts like those of the data"
    return text, "Stay near those contacts, or add the measurement that `restitution identify` names."


def _coupling(worst: Any, exceeded: bool) -> tuple[str, str]:
    text = f"{VALIDITY['coupling_number'].words} is {_beside(worst.coupling_number, COUPLING_LIMIT)}"
    if exceeded:
        text += "; normal and tangential displacements are not independent then"
    return text, "Expect e_t to be off by some hundredths or more; take more friction, or bodies of like compliance."


def _travel(worst: Any, exceeded: bool) -> tuple[str, str]:
    text = f"the body moves by {worst.travel_number:.3g} contact radii during contact, "
    text += f"{'above' if exceeded else 'not above'} the limit {TRAVEL_LIMIT:g}"
    return text, "Expect rolling and ploughing on fresh material, which are left out; take a lower speed."


def _attraction(worst: Any, exceeded: bool) -> tuple[str, str]:
    at_rest = "infinite" if math.isinf(worst.maugis_number) else f"{worst.maugis_number:.3g}"
    text = f"{VALIDITY['zone_slope'].words} is {_beside(worst.zone_slope, SLOPE_LIMIT)}; the ring is "
    text += f"{100.0 * worst.zone_ratio:.2g} % of the contact radius wide"
    if not math.isnan(worst.maugis_number):
        text += f", lambda {at_rest} at rest and {worst.instantaneous_maugis_number:.3g} at once, where DMT is below "
        text += "0.1 and JKR above 5"
    advice = "Take a lower stress of the same work, or read the numbers as those of a model of the edge: strains "
    return text, advice + "there are not small."


def _range(worst: Any, exceeded: bool) -> tuple[str, str]:
    text = f"{VALIDITY['range_ratio'].words} is {_beside(worst.range_ratio, RANGE_LIMIT)}; the range is "
    text += in_words(float(worst.attraction_range), "m")
    return text, "Vary the range at the same work: the form of the attraction matters as much as its work."


_ROUGHNESS = "the surfaces count as smooth: heights must be small against the range, or the work be that of rough ones"

# The quantity that is compared, its limit, the reason if it is not known (without one it is left out then), and the
# text with advice if it is.
KINDS: dict[str, tuple[str, Threshold, str, Callable[[Any, bool], tuple[str, str]]]] = {
    "small_strain": ("strain_number", STRAIN_LIMIT, "no contact radius is known", _small_strain),
    "half_space": ("contact_size_ratio", SIZE_LIMIT, "no size of the target is given", _half_space),
    "waves": ("radiated_energy_ratio", RADIATION_LIMIT, "the density of a material is missing", _waves),
    "window": ("window_ratio", 1.0, "no material states its window", _window),
    "poisson_ratio": ("instantaneous_poisson_ratio", 0.0, "no contact was solved", _poisson_ratio),
    "density": ("mean_density", DENSITY_LIMITS, "the body is no ball of a known mass", _density),
    "separability": ("instantaneous_poisson_ratio", math.nan, "", _separability),
    "constants": ("undetermined_constants", 0.0, "", _constants),
    "coupling": ("coupling_number", COUPLING_LIMIT, "", _coupling),
    "travel": ("travel_number", TRAVEL_LIMIT, "", _travel),
    "attraction": ("zone_slope", SLOPE_LIMIT, "the surfaces do not touch", _attraction),
    "range": ("range_ratio", RANGE_LIMIT, "no contact was solved", _range),
    "roughness": ("attraction_range", math.nan, _ROUGHNESS, _range),
}
OF_ADHESION = ("attraction", "range", "roughness")


def _beside(value: float, limit: float) -> str:
    return f"{value:.3g}, {'above' if value > limit else 'not above'} the limit {limit:g}"
