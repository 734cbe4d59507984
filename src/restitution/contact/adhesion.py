"""Adhesion of two surfaces by Dugdale's law, and the contact of an elastic body at rest."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Any, ClassVar, NamedTuple

import numpy as np
from numpy.typing import NDArray

from restitution.axes import Axes, align, spread_array
from restitution.checks import Array, Numeric, common_shape
from restitution.contact.profiles import Profile
from restitution.errors import InputError
from restitution.quantities import ADHESION_INPUTS
from restitution.units import in_words

RANGE = 0.4e-9
"""Range of the attraction [m] where none is given: a distance of atoms."""

# Largest range of an attraction over the radius of a round tip; that of surfaces is nanometres to microns.
_FARTHEST = 100.0
# Nodes over the angle of the zone, and relative tolerance of a root.
_NODES, _EPSILON = np.polynomial.legendre.leggauss(48), 4.0 * np.finfo(float).eps


@dataclass(frozen=True, eq=False)
class Adhesion:
    """Attraction of two surfaces by Dugdale's law: a constant stress sigma0 where the gap is below the range h0.

    Parameters
    ----------
    work : float or array
        Work of adhesion w = sigma0 h0 [J/m^2], > 0.
    stress : float or array, optional
        Stress of the attraction sigma0 [Pa], > 0.
    range : float or array, optional
        Range of the attraction h0 [m], > 0, in place of the stress; 0.4 nm if neither is given.

    Raises
    ------
    InputError
        If a number is out of range, or both stress and range are given.

    Notes
    -----
    Maugis (1992), J. Colloid Interface Sci. 150, 243. A smooth potential with the same work of adhesion and the same
    largest stress gives nearly the same contact; roughness is no part of it and usually lowers the work of adhesion.

    Examples
    --------
    >>> import restitution as rs
    >>> sticky = rs.Adhesion(work=0.05)
    >>> print(f"{sticky.stress:.4g} Pa over {sticky.range:.2g} m")
    1.25e+08 Pa over 4e-10 m
    """

    work: Numeric
    stress: Numeric | None = None
    range: Numeric | None = None
    held: str = field(default="range", init=False, repr=False)
    """Which of stress and range was given, and stays where the work changes."""

    axes: ClassVar[Axes | None] = None
    """Names of the axes of an array; None where they have no names."""

    def __post_init__(self) -> None:
        if self.stress is not None and self.range is not None:
            raise InputError("stress, range", rule="must be one of them, as work = stress range")
        align(self, ("work", "stress", "range"))
        work = ADHESION_INPUTS["work"].check(self.work)
        if self.stress is not None:
            object.__setattr__(self, "held", "stress")
            stress = ADHESION_INPUTS["stress"].check(self.stress)
            reach: Any = work / np.asarray(stress)
        else:
            reach = ADHESION_INPUTS["range"].check(RANGE if self.range is None else self.range)
            stress = work / np.asarray(reach)
        for name, value in (("work", work), ("stress", stress), ("range", reach)):
            object.__setattr__(self, name, np.asarray(value) if np.ndim(value) else float(value))
        _ = self.shape

    @property
    def shape(self) -> tuple[int, ...]:
        """Shape of an array; () for one."""
        return common_shape({name: np.shape(getattr(self, name)) for name in ("work", "stress", "range")})

    def changed(self, numbers: Mapping[str, Any]) -> Adhesion:
        """Return the adhesion with other numbers by name; a work alone keeps the stress or the range that was given.

        Examples
        --------
        >>> import restitution as rs
        >>> print(rs.Adhesion(0.05, stress=1e6).changed({"work": 0.1}).range)
        1.00...e-07
        """
        held = next((name for name in ("stress", "range") if name in numbers), self.held)
        return Adhesion(numbers.get("work", self.work), **{held: numbers.get(held, getattr(self, held))})

    def take(self, shape: tuple[int, ...], places: NDArray[np.intp]) -> Adhesion:
        """Return rows of an array, raveled from a larger shape, in the shape of the places."""
        return self._each(lambda value: np.broadcast_to(value, shape).reshape(-1)[places][()])

    def spread(self, names: tuple[Any, ...], axes: Axes | None = None) -> Adhesion:
        """Return an array over axes of other names; its own are `axes`."""
        target = axes or self.axes
        assert target is not None
        return self._each(lambda value: spread_array(value, target, names, self.shape))

    def _each(self, change: Callable[[Any], Any]) -> Adhesion:
        numbers = {name: getattr(self, name) for name in ("work", self.held)}
        return Adhesion(**{name: change(value) if np.ndim(value) else value for name, value in numbers.items()})


def maugis_number(work: Any, stress: Any, modulus: Any, radius: Any) -> Any:
    """Return Maugis' parameter ``lambda = sigma0 (9 R/(2 pi w E*^2))^(1/3)`` of a round body.

    Below 0.1 the limit of Derjaguin, Muller and Toporov holds, above 5 that of Johnson, Kendall and Roberts.
    """
    return stress * np.cbrt(9.0 * radius / (2.0 * math.pi * work * modulus * modulus))


class Static(NamedTuple):
    """Adhesive contact of an elastic body at rest: depth [m], force [N], contact radius and edge of the zone [m]."""

    depth: float
    force: float
    radius: float
    edge: float


def static_contact(profile: Profile, modulus: float, adhesion: Adhesion, radius: float) -> Static:
    """Return the elastic contact with a contact radius [m]; the reduced modulus E* is in [Pa].

    For a parabola these are the equations of Maugis (1992).
    """
    from scipy.optimize import brentq

    stress, reach = float(adhesion.stress or 0.0), float(adhesion.range or 0.0)
    undisturbed = float(profile.transform(radius))
    points, weights = _NODES

    def excess(edge: float) -> float:
        """Return int_a^c H/sqrt(c^2 - x^2) dx - pi h0/2."""
        start = math.asin(radius / edge)
        half = 0.5 * (0.5 * math.pi - start)
        angles = start + half * (points + 1.0)
        gap: Array = np.asarray(profile.transform(edge * np.sin(angles))) - undisturbed
        pull = 2.0 * stress / modulus * (math.sqrt(edge * edge - radius * radius) - edge * np.cos(angles))
        return half * float(weights @ (gap + pull)) - 0.5 * math.pi * reach

    low, high = radius, 1.001 * radius + reach * modulus / stress
    while excess(high) < 0.0:
        low, high = high, 2.0 * high - 0.5 * radius
    if not excess(high) >= 0.0:
        # The profile ends within the zone.
        return Static(math.nan, math.nan, radius, math.nan)
    edge: Any = brentq(excess, low, high, xtol=_EPSILON * high)
    zone = math.sqrt((edge - radius) * (edge + radius))
    lift = 2.0 * stress / modulus * zone
    pull = edge * edge * math.acos(radius / edge) - radius * zone
    force = 2.0 * modulus * (float(profile.force_integral(radius)) - lift * radius) - 2.0 * stress * pull
    return Static(undisturbed - lift, force, radius, edge)


def rest(profile: Profile, modulus: float, adhesion: Adhesion, radius: float, load: float = 0.0) -> Static:
    """Return the contact that carries a load [N], NaN where the profile ends; `radius` [m] is a first guess."""
    from scipy.optimize import brentq

    def force(radius: float) -> float:
        return static_contact(profile, modulus, adhesion, radius).force - load

    low = high = radius
    while force(high) < 0.0:
        high *= 2.0
    while force(low) > 0.0:
        low *= 0.5
    ends = force(low), force(high)
    if math.isnan(sum(ends)):
        return Static(math.nan, load, math.nan, math.nan)
    root: Any = brentq(force, low, high, xtol=_EPSILON * low)
    return static_contact(profile, modulus, adhesion, root)


def require_smooth(profile: Profile) -> None:
    """Refuse a profile with a flat face or an edge, for which the theory has no front of contact."""
    if np.any(np.asarray(profile.contact_radius(0.0)) > 0.0) or profile.joints.size:
        raise InputError("profile", profile, "must be smooth, without a flat face, for adhesion")


def require_near(profile: Profile, adhesion: Adhesion) -> None:
    """Refuse a range of the attraction far beyond the radius of a round tip, mostly a slip of unit of the stress."""
    reach, radius = np.broadcast_arrays(np.asarray(adhesion.range), np.asarray(profile.tip_radius))
    far = np.argwhere(reach > _FARTHEST * radius)
    if len(far):
        index = tuple(int(n) for n in far[0])
        rule = f"must be at most {_FARTHEST:g} radii of the tip, {in_words(_FARTHEST * float(radius[index]), 'm')}"
        if adhesion.held == "stress":
            rule += "; it is the work over the stress, which is too small"
        raise InputError("adhesion.range", float(reach[index]), rule, "m", index=index)
