"""A profile given as a table, for instance a measured tip."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Annotated, Any

import numpy as np
from numpy.typing import ArrayLike

from restitution.checks import finite
from restitution.contact.abel import AbelTransform
from restitution.contact.geometry import Array, Kinks, as_array
from restitution.contact.profile import Profile
from restitution.errors import InputError
from restitution.quantities import LENGTH, Quantity

if TYPE_CHECKING:
    from scipy.interpolate import PPoly

# Points per interval of the table at which g is checked to rise; its inverse starts from them.
_SAMPLES = 8
# Share of the depth by which g may fall, far below the accuracy of measured tips.
_LEVEL = 1e-7
# A tip whose slope at r = 0 is below this fraction of its secant slope over the first interval is round.
_ROUND_TIP = 0.1


@dataclass(frozen=True, eq=False)
class Tabulated(Profile, case_name="tabulated"):
    """Profile through the points (r_i, f_i) of a table.

    Parameters
    ----------
    r : array
        Radii r_i [m], shape ``(n_points,)``, n_points >= 2, strictly rising from 0.
    f : array
        Heights f_i [m], shape ``(n_points,)``, f_0 = 0, never falling. Leading zeros are a flat face.

    Raises
    ------
    ValueError
        If the table is not valid (shape, NaN, order, sign), if it is flat or becomes so flat that the contact would
        not be a full circle (g falls), or if a method is called for a place beyond the end of the table.

    Notes
    -----
    Between the points f is a spline in r of degree five, or three where that is not monotone, or else the monotone
    cubic of Fritsch and Carlson (1980). At the edge of a flat face its slope jumps. A tip whose slope at r = 0 is
    nearly zero is taken as round (f even and smooth). g and Pi are the exact transform of this interpolant
    (`AbelTransform`), which follows noise in the table and does not smooth it.

    Examples
    --------
    >>> import numpy as np
    >>> r = np.linspace(0, 0.002, 21)
    >>> tip = Tabulated(r, r**2 / 0.02)
    >>> round(float(tip.contact_radius(1e-4)), 12)
    0.001
    """

    sources = (("fritsch1980", "interpolation of the measured profile"), ("sneddon1965", "transform of the profile"))

    r: Annotated[Array, Quantity("r", LENGTH, "radii of points of the profile", "$r$", 0.0)]
    f: Annotated[Array, Quantity("f", LENGTH, "heights of points of the profile", "$f$", 0.0)]
    _flank: Any = field(init=False, repr=False, compare=False)
    _order: int = field(init=False, repr=False, compare=False)
    _transform: AbelTransform = field(init=False, repr=False, compare=False)
    _samples: tuple[Array, Array] = field(init=False, repr=False, compare=False)

    def __post_init__(self) -> None:
        r, f = _checked_table(self.r, self.f)
        object.__setattr__(self, "r", r)
        object.__setattr__(self, "f", f)
        face = int(np.flatnonzero(f == 0.0)[-1])
        falls_at = 0.0
        for pieces, order in _interpolants(r[face:], f[face:]):
            transform = AbelTransform(pieces)
            falls = transform.falls()
            if not falls.size:
                y, depth, slope = _sampled(transform, pieces.x)
                falls = np.append(y[:-1][np.diff(depth) <= 0.0], _falling(transform, y, slope))
                if not falls.size:
                    made = {"_flank": pieces, "_order": order, "_transform": transform, "_samples": (y, depth)}
                    break
            falls_at = math.hypot(transform.face, float(falls[0]))
        else:
            wanted = "g(x) must rise for the contact to be a full circle; smooth or thin the table"
            raise InputError("", wanted=f"f rises too little beyond r = {falls_at:g} m: {wanted}")
        for name, value in made.items():
            object.__setattr__(self, name, value)

    def shape(self, r: ArrayLike) -> Array:
        """Profile f(r) [m]."""
        r = self._inside("r", np.abs(as_array(r)))
        return np.where(r > self._transform.face, self._flank(r), 0.0)

    def transform(self, x: ArrayLike) -> Array:
        """Transformed profile g(x) [m]."""
        x = self._inside("x", np.abs(as_array(x)))
        return self._transform(self._transform.beyond_face(x.ravel())).depth.reshape(x.shape)[()]

    def contact_radius(self, depth: ArrayLike) -> Array:
        """Contact radius a = g^-1(d) [m]; that of the flat face, if there is one, at d = 0."""
        depth = as_array(depth)
        y = self._inverse(depth).reshape(depth.shape)
        a = np.minimum(np.hypot(self._transform.face, y), self.r[-1])
        return np.where(depth >= 0.0, a, 0.0)[()]

    def force_integral(self, contact_radius: ArrayLike) -> Array:
        """Force integral Pi(a) [m^2]."""
        a = self._inside("contact_radius", as_array(contact_radius))
        return self._transform(self._transform.beyond_face(a.ravel())).force_integral.reshape(a.shape)[()]

    def force_integral_at_depth(self, depth: ArrayLike) -> Array:
        """Force integral int_0^d a dd [m^2] at depth d [m]."""
        depth = as_array(depth)
        return self._transform(self._inverse(depth)).force_integral.reshape(depth.shape)[()]

    @property
    def max_contact_radius(self) -> float:
        """Last radius [m] of the table."""
        return float(self.r[-1])

    @property
    def max_depth(self) -> float:
        """Depth [m] at which the contact reaches the end of the table."""
        return float(self._samples[1][-1])

    @property
    def joints(self) -> Array:
        """Radii [m] of the joints of the interpolant."""
        return np.asarray(self._flank.x[1:-1])

    @property
    def kinks(self) -> Kinks:
        """Depths of the joints of the interpolant, where one of its derivatives jumps.

        A jump J of the k-th derivative of f at r_j adds ``J sqrt(r_j/2) B(k, 1/2)/(k-1)! (x - r_j)^(k-1/2)`` to g(x)
        beyond it, to leading order, and takes ``(1/g')`` times that from a(d).
        """
        k = self._order
        slopes = self._flank.derivative(k)
        joints = slopes.x[1:-1]
        ends = np.polynomial.polynomial.polyval(np.diff(slopes.x)[:-1], slopes.c[::-1, :-1], tensor=False)
        jump = slopes.c[-1, 1:] - ends
        beta = math.gamma(k) * math.gamma(0.5) / math.gamma(k + 0.5)
        strength = -jump * np.sqrt(0.5 * joints) * beta / math.gamma(k)
        # Where g hardly rises this is only an order of magnitude.
        y = self._transform.beyond_face(joints)
        slope = self._transform(y).slope * joints / y
        slope = np.maximum(slope, 1e-3 * np.max(slope, initial=0.0))
        return Kinks(self.transform(joints), strength / slope ** (k + 0.5), k - 0.5)

    def _inside(self, name: str, radius: Array) -> Array:
        if np.any(radius > self.r[-1]):
            worst = float(np.max(radius))
            raise InputError("", wanted=f"{name} = {worst:g} m: must be <= {self.r[-1]:g} m, where the table ends")
        return radius

    def _inverse(self, depth: Array) -> Array:
        """Return flat y with g = depth, by Newton's method kept inside a bracket."""
        if np.any(depth > self.max_depth):
            worst = float(np.max(depth))
            raise InputError("", wanted=f"depth = {worst:g} m: must be <= {self.max_depth:g} m, where the table ends")
        depth = np.maximum(depth, 0.0).ravel()
        y_known, depth_known = self._samples
        upper = np.clip(np.searchsorted(depth_known, depth), 1, len(y_known) - 1)
        low, high = y_known[upper - 1].copy(), y_known[upper].copy()
        y = low + (high - low) * (depth - depth_known[upper - 1]) / (depth_known[upper] - depth_known[upper - 1])
        active = np.flatnonzero((depth > 0.0) & (depth < depth_known[-1]))
        # Bisection alone would need 60 steps for the digits of y, and more for the exponent of a tiny depth.
        for _ in range(200):
            if not active.size:
                break
            here = y[active]
            found = self._transform(here)
            residual = found.depth - depth[active]
            above = residual > 0.0
            high[active[above]] = here[above]
            low[active[~above]] = here[~above]
            # Newton's method in the logarithms, because near the tip g is a power of y over many decades.
            reached = np.maximum(found.depth, 1e-300)
            power = np.where(found.slope > 0.0, here * found.slope / reached, np.inf)
            trial = here * (depth[active] / reached) ** (1.0 / power)
            # Where g falls between the samples, only the bracket is reliable.
            tight = (np.abs(trial - here) <= 4e-16 * here) & (found.slope > 0.0)
            inside = (trial > low[active]) & (trial < high[active])
            y[active] = np.where(inside | tight, trial, 0.5 * (low[active] + high[active]))
            active = active[~tight & (high[active] - low[active] > 4e-16 * here)]
        return y


def _sampled(transform: AbelTransform, breaks: Array) -> tuple[Array, Array, Array]:
    edges = transform.beyond_face(breaks)
    fractions = np.arange(1, _SAMPLES + 1) / _SAMPLES
    y = np.append(0.0, (edges[:-1, None] + np.diff(edges)[:, None] * fractions).ravel())
    found = transform(y)
    return y, found.depth, found.slope


def _falling(transform: AbelTransform, y: Array, slope: Array) -> Array:
    """Places y at which g falls between the samples, found near the minima of its slope in three refinements."""
    least = np.flatnonzero((slope[1:-1] <= slope[:-2]) & (slope[1:-1] <= slope[2:])) + 1
    if not least.size:
        return y[least]
    columns = np.arange(least.size)
    low, high = y[least - 1], y[least + 1]
    fall, reached = np.zeros(least.size), np.zeros(least.size)
    for _ in range(3):
        here = low + np.linspace(0.0, 1.0, 2 * _SAMPLES + 1)[:, None] * (high - low)
        found = transform(here[1:-1].ravel())
        depth = found.depth.reshape(-1, least.size)
        fall = np.maximum(fall, np.max(np.maximum.accumulate(depth) - depth, axis=0))
        reached = np.max(depth, axis=0)
        best = np.argmin(found.slope.reshape(-1, least.size), axis=0) + 1
        low, high = here[best - 1, columns], here[best + 1, columns]
    return low[fall > _LEVEL * reached]


def _checked_table(r: Any, f: Any) -> tuple[Array, Array]:
    radii, heights = np.asarray(finite("r", r, "m")), np.asarray(finite("f", f, "m"))
    if radii.ndim != 1 or radii.shape != heights.shape or radii.size < 2:
        raise InputError(
            "", wanted=f"r, f of shapes {radii.shape}, {heights.shape}: must be two columns of equal length >= 2"
        )
    for name, values in (("r", radii), ("f", heights)):
        extreme = (values != 0.0) & ~((np.abs(values) >= 1e-100) & (np.abs(values) <= 1e100))
        if np.any(extreme):
            i = int(np.argmax(extreme))
            raise InputError(name, float(values[i]), "must be 0 or of a size in [1e-100, 1e+100] m", "m", index=(i,))
    if radii[0] != 0.0 or heights[0] != 0.0:
        raise InputError(
            "", wanted=f"r[0], f[0] = {radii[0]:g}, {heights[0]:g} m: the table must start at r = 0, f = 0"
        )
    for name, values, bad, rule in (
        ("r", radii, np.diff(radii) <= 0.0, "must rise strictly"),
        ("f", heights, np.diff(heights) < 0.0, "must never fall"),
    ):
        if np.any(bad):
            i = int(np.argmax(bad))
            raise InputError("", wanted=f"{name}[{i + 1}] = {values[i + 1]:g} m after {values[i]:g} m: {name} {rule}")
    if heights[-1] == 0.0:
        raise InputError("", wanted="f = 0 m everywhere: must rise; a flat face alone is a FlatPunch")
    return radii, heights


def _interpolants(r: Array, f: Array) -> Iterator[tuple[PPoly, int]]:
    """Yield monotone interpolants of f(r), the smoothest first, and the order of the derivative that jumps first."""
    from scipy.interpolate import PchipInterpolator, PPoly

    for degree in (5, 3):
        pieces = _spline(r, f, degree)
        if pieces is not None and _rises(pieces):
            yield pieces, degree
    if len(r) == 2:
        yield PPoly(np.array([[f[1] / (r[1] - r[0])], [0.0]]), r), 2
    else:
        monotone = PchipInterpolator(r, f)
        yield PPoly(monotone.c, monotone.x), 2


def _spline(r: Array, f: Array, degree: int) -> PPoly | None:
    if len(r) <= degree:
        return None
    pieces = _free_spline(r, f, degree)
    if r[0] == 0.0 and abs(pieces.derivative()(r[:1])[0]) < _ROUND_TIP * f[1] / r[1]:
        mirrored = _free_spline(np.append(-r[:0:-1], r), np.append(f[:0:-1], f), degree)
        keep = np.flatnonzero(mirrored.x >= 0.0)
        pieces = type(mirrored)(mirrored.c[:, keep[:-1]].copy(), mirrored.x[keep])
        # Odd derivatives that are continuous at r = 0 vanish there; rounding would leave a tiny cone. The highest one,
        # of |r|^5 or |r|^3, jumps and is kept.
        pieces.c[-2:0:-2, 0] = 0.0
    pieces.c[-1, 0] = 0.0
    return pieces


def _free_spline(r: Array, f: Array, degree: int) -> PPoly:
    from scipy.interpolate import PPoly, make_interp_spline

    polynomial: Any = PPoly.from_spline(make_interp_spline(r, f, k=degree))
    used = np.flatnonzero(np.diff(polynomial.x) > 0.0)
    return PPoly(polynomial.c[:, used].copy(), np.append(polynomial.x[used], polynomial.x[-1]))


def _rises(pieces: Any) -> bool:
    breaks = pieces.x
    samples = (breaks[:-1, None] + np.diff(breaks)[:, None] * np.linspace(0.0, 1.0, 17)).ravel()
    slopes = pieces.derivative()(samples)
    return bool(np.min(slopes) >= -1e-12 * np.max(slopes))
