"""A profile given as a table, for instance a measured tip."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass, field
from functools import cached_property
from typing import TYPE_CHECKING, Annotated, Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from restitution.checks import Array, finite, refuse
from restitution.contact.geometry import Kinks, as_array
from restitution.contact.profiles import Profile
from restitution.errors import InputError
from restitution.numerics.refine import refine, to_chebyshev
from restitution.parallel import on_threads
from restitution.quantities import LENGTH, Quantity

if TYPE_CHECKING:
    from scipy.interpolate import PPoly


# The transform g(x) of a piecewise polynomial profile, by quadrature of the Abel integral to rounding.

# Near x a piece is integrated over the angle, where f' is a polynomial of degree <= 4 in a cosine over at most a
# quarter turn. Two of its widths away from x, eight nodes over r are at rounding level (9.9^-16).
_NEAR_RULE = 0.5 * np.array(np.polynomial.legendre.leggauss(10)) + np.array([[0.5], [0.0]])
_FAR_NODES = 8
_FAR = 2.0
# Four pieces make a group, two groups one of the next level. Two of its widths away, the nodes of a group take the
# place of those of its parts, at rounding level too. So an integral costs the logarithm of the number of pieces.
_GROUP = 4
_GROUP_NODES = 16
# Integrals that a thread computes at a time.
_BLOCK = 10_000
_DEGREE = 20
# Error of the series of g, its slope and Pi; Newton's method needs no more accurate slope.
_TAILS = np.array([1e-12, 1e-8, 1e-12])
_MAX_SPLITS = 6


class Transformed(NamedTuple):
    """Transform at some contact radii: g [m], dg/dy [-] with y = sqrt(x^2 - b^2), and Pi [m^2]."""

    depth: Array
    slope: Array
    force_integral: Array


class AbelTransform:
    """Transform of a profile that is flat for r < b, with a flank f(r) of degree <= 5 from b = flank.x[0] on.

    With r = x cos(psi), over each piece: ``g = x int f' dpsi``, ``g' = int (f' + r f'') dpsi + f'(b) b/sqrt(x^2 -
    b^2)``, ``Pi = int f' r^2 dpsi``; the last from the other order of integration in Pi = a g(a) - int g dx.

    All are functions of y = sqrt(x^2 - b^2), in which g is smooth at b. Beyond the first piece they are kept as
    Chebyshev series in the root of the distance to the last break before x, where g has a half-integer power.
    """

    def __init__(self, flank: PPoly) -> None:
        # A copy, as the compiler makes a second version for arrays that are read-only.
        self._breaks: Array = np.array(flank.x)
        self.face = float(self._breaks[0])
        self._first: Any = flank.derivative()
        self._second: Any = self._first.derivative()
        nodes, weights = np.polynomial.legendre.leggauss(_FAR_NODES)
        widths = np.diff(self._breaks)
        self._far_from = self._breaks[1:] + _FAR * widths
        self._far_nodes = self._breaks[:-1, None] + widths[:, None] * (0.5 + 0.5 * nodes)
        first, second = self._first(self._far_nodes), self._second(self._far_nodes)
        integrands = np.stack([first, first + self._far_nodes * second, first * self._far_nodes**2], axis=1)
        self._far_masses = (0.5 * widths[:, None] * weights)[:, None] * integrands
        self._slopes = np.ascontiguousarray(self._first.c[::-1].T)
        self._groups = self._grouped()

    def _grouped(self) -> tuple[NDArray[np.intp], Array, Array, Array]:
        """Return the first group of each level, and for each group the radius from which it is far, nodes and masses.

        The masses there, in place of those of their parts, follow from Lagrange polynomials at Chebyshev nodes.
        """
        places, lagrange = to_chebyshev(_GROUP_NODES)
        size, parts, nodes, masses = _GROUP, _GROUP, self._far_nodes, self._far_masses
        levels: list[tuple[Array, Array, Array]] = []
        while count := (len(self._breaks) - 1) // size:
            edges = self._breaks[: count * size + 1 : size]
            widths = np.diff(edges)[:, None]
            place = (nodes[: count * parts].reshape(count, -1) - edges[:-1, None]) / widths
            basis = np.polynomial.chebyshev.chebvander(2.0 * place - 1.0, _GROUP_NODES - 1)
            whole = np.swapaxes(masses[: count * parts].reshape(count, parts, 3, -1), 1, 2).reshape(count, 3, -1)
            masses = whole @ basis @ lagrange
            nodes = edges[:-1, None] + widths * (0.5 + 0.5 * places)
            levels.append((np.maximum.accumulate(edges[1:] + _FAR * widths[:, 0]), nodes, masses))
            size, parts = 2 * size, 2
        starts = np.cumsum([0, *(len(level[0]) for level in levels)])
        if not levels:
            return starts, np.empty(0), np.empty((0, _GROUP_NODES)), np.empty((0, 3, _GROUP_NODES))
        far_from, nodes, masses = (np.concatenate(parts) for parts in zip(*levels, strict=True))
        return starts, far_from, nodes, masses

    def __call__(self, y: Array) -> Transformed:
        """Transform at flat y [m] within the breaks."""
        # Numba takes half a second to import.
        from restitution.contact.loops import evaluate_series

        x = self._radius(y)
        values = np.empty((len(y), 3))
        near = x <= self._breaks[1]
        values[near] = self._integrated(y[near])
        far = np.flatnonzero(~near)
        if far.size:
            piece, root = self._located(x[far])
            # Just before a break the sum may round up into the next piece.
            place = np.minimum(piece + root, np.nextafter(piece + 1.0, 0.0))
            cells, series = self._series
            pieces, low, high = cells
            cell = np.clip(np.searchsorted(pieces + low, place, side="right") - 1, 0, pieces.size - 1)
            far_values = np.empty((far.size, 3))
            evaluate_series(root, cell, low, high, series, far_values)
            values[far] = far_values
        return Transformed(*values.T)

    def beyond_face(self, x: Array) -> Array:
        """Return y = sqrt(x^2 - b^2) [m], 0 under the face."""
        return np.sqrt(np.maximum((x - self.face) * (x + self.face), 0.0))

    def _radius(self, y: Array) -> Array:
        # The hypotenuse must not round beyond the last break, where the integrals would miss the root.
        return np.minimum(np.hypot(self.face, y), self._breaks[-1])

    def _located(self, x: Array) -> tuple[NDArray[np.intp], Array]:
        piece = np.clip(np.searchsorted(self._breaks, x, side="right") - 1, 1, len(self._breaks) - 2)
        start, end = self._breaks[piece], self._breaks[piece + 1]
        return piece, np.sqrt(np.clip((x - start) / (end - start), 0.0, 1.0))

    @cached_property
    def _series(self) -> tuple[Array, Array]:
        """Piece, start and end of each cell beyond the first piece, and its Chebyshev coefficients."""
        scale = self._integrated(self.beyond_face(self._breaks[-1:]))[0]
        nodes, matrix = to_chebyshev(_DEGREE + 1)

        def fit(cells: Array) -> tuple[Array, Array]:
            piece, low, high = cells[:, 0].astype(np.intp), cells[:, 1:2], cells[:, 2:]
            root = 0.5 * (low + high) + 0.5 * (high - low) * nodes
            start, end = self._breaks[piece][:, None], self._breaks[piece + 1][:, None]
            y = self.beyond_face((start + (end - start) * root * root).ravel())
            values = self._integrated(y).reshape(len(cells), _DEGREE + 1, 3)
            coefficients = np.swapaxes(values, 1, 2) @ matrix.T
            tail = np.max(np.abs(coefficients[..., -2:]) / scale[:, None], axis=-1)
            return np.all(tail <= _TAILS, axis=1), coefficients

        first = np.array([(k, 0.0, 1.0) for k in range(1, len(self._breaks) - 1)])
        (cells, series), _ = refine(first, fit, _MAX_SPLITS)
        order = np.lexsort((cells[:, 1], cells[:, 0]))
        return np.ascontiguousarray(cells[order].T), series[order]

    def _integrated(self, y: Array) -> Array:
        from restitution.contact.loops import add_integrals

        x, y, sums = self._radius(y), np.ascontiguousarray(y), np.empty((len(y), 3))

        def run(start: int) -> None:
            rows = slice(start, start + _BLOCK)
            pieces = self._far_from, self._far_nodes, self._far_masses
            add_integrals(x[rows], y[rows], self._breaks, self._slopes, _NEAR_RULE, pieces, self._groups, sums[rows])

        if len(y) <= _BLOCK:
            run(0)
        else:
            on_threads(run, range(0, len(y), _BLOCK), None, lambda: None)
        inner = sums[:, 1]
        if self.face > 0.0:
            inner = (y * inner + self._first.c[-1, 0] * self.face) / x
        elif np.any(y == 0.0):
            inner = np.where(y == 0.0, 0.5 * math.pi * self._first.c[-1, 0], inner)
        return np.stack([x * sums[:, 0], inner, sums[:, 2]], axis=1)


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
            y, depth, slope = _sampled(transform, pieces.x)
            falls = np.append(y[:-1][np.diff(depth) <= 0.0], _falling(transform, y, slope))
            if not falls.size:
                parts = {"_flank": pieces, "_order": order, "_transform": transform, "_samples": (y, depth)}
                break
            falls_at = math.hypot(transform.face, float(falls[0]))
        else:
            rule = "g(x) must rise for the contact to be a full circle; smooth or thin the table"
            raise InputError("", rule=f"f rises too little beyond r = {falls_at:g} m: {rule}")
        for name, value in parts.items():
            object.__setattr__(self, name, value)

    def shape(self, r: ArrayLike) -> Array:
        """Return the profile f(r) [m]."""
        r = self._inside("r", np.abs(as_array(r)))
        return np.where(r > self._transform.face, self._flank(r), 0.0)

    def transform(self, x: ArrayLike) -> Array:
        """Return the transformed profile g(x) [m]."""
        x = self._inside("x", np.abs(as_array(x)))
        return self._transform(self._transform.beyond_face(x.ravel())).depth.reshape(x.shape)[()]

    def contact_radius(self, depth: ArrayLike) -> Array:
        """Return the contact radius a = g^-1(d) [m]; that of the flat face, if there is one, at d = 0."""
        depth = as_array(depth)
        y = self._inverse(depth).reshape(depth.shape)
        a = np.minimum(np.hypot(self._transform.face, y), self.r[-1])
        return np.where(depth >= 0.0, a, 0.0)[()]

    def force_integral(self, contact_radius: ArrayLike) -> Array:
        """Return the force integral Pi(a) [m^2]."""
        a = self._inside("contact_radius", as_array(contact_radius))
        return self._transform(self._transform.beyond_face(a.ravel())).force_integral.reshape(a.shape)[()]

    def force_integral_at_depth(self, depth: ArrayLike) -> Array:
        """Return the force integral int_0^d a dd [m^2] at depth d [m]."""
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
            raise InputError("", rule=f"{name} = {worst:g} m: must be <= {self.r[-1]:g} m, where the table ends")
        return radius

    def _inverse(self, depth: Array) -> Array:
        """Return flat y with g = depth, by Newton's method kept inside a bracket."""
        if np.any(depth > self.max_depth):
            worst = float(np.max(depth))
            raise InputError("", rule=f"depth = {worst:g} m: must be <= {self.max_depth:g} m, where the table ends")
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
            transformed = self._transform(here)
            residual = transformed.depth - depth[active]
            above = residual > 0.0
            high[active[above]] = here[above]
            low[active[~above]] = here[~above]
            # Newton's method in the logarithms, because near the tip g is a power of y over many decades.
            reached = np.maximum(transformed.depth, 1e-300)
            power = np.where(transformed.slope > 0.0, here * transformed.slope / reached, np.inf)
            trial = here * (depth[active] / reached) ** (1.0 / power)
            # Where g falls between the samples, only the bracket is reliable.
            tight = (np.abs(trial - here) <= 4e-16 * here) & (transformed.slope > 0.0)
            inside = (trial > low[active]) & (trial < high[active])
            y[active] = np.where(inside | tight, trial, 0.5 * (low[active] + high[active]))
            active = active[~tight & (high[active] - low[active] > 4e-16 * here)]
        return y


def _sampled(transform: AbelTransform, breaks: Array) -> tuple[Array, Array, Array]:
    edges = transform.beyond_face(breaks)
    fractions = np.arange(1, _SAMPLES + 1) / _SAMPLES
    y = np.append(0.0, (edges[:-1, None] + np.diff(edges)[:, None] * fractions).ravel())
    transformed = transform(y)
    return y, transformed.depth, transformed.slope


def _falling(transform: AbelTransform, y: Array, slope: Array) -> Array:
    """Return places y at which g falls between the samples, near minima of its slope, by three refinements."""
    least = np.flatnonzero((slope[1:-1] <= slope[:-2]) & (slope[1:-1] <= slope[2:])) + 1
    if not least.size:
        return y[least]
    columns = np.arange(least.size)
    low, high = y[least - 1], y[least + 1]
    fall, reached = np.zeros(least.size), np.zeros(least.size)
    for _ in range(3):
        here = low + np.linspace(0.0, 1.0, 2 * _SAMPLES + 1)[:, None] * (high - low)
        transformed = transform(here[1:-1].ravel())
        depth = transformed.depth.reshape(-1, least.size)
        fall = np.maximum(fall, np.max(np.maximum.accumulate(depth) - depth, axis=0))
        reached = np.max(depth, axis=0)
        best = np.argmin(transformed.slope.reshape(-1, least.size), axis=0) + 1
        low, high = here[best - 1, columns], here[best + 1, columns]
    return low[fall > _LEVEL * reached]


def _checked_table(r: Any, f: Any) -> tuple[Array, Array]:
    radii, heights = np.asarray(finite("r", r, "m")), np.asarray(finite("f", f, "m"))
    if radii.ndim != 1 or radii.shape != heights.shape or radii.size < 2:
        raise InputError(
            "", rule=f"r, f of shapes {radii.shape}, {heights.shape}: must be two columns of equal length >= 2"
        )
    for name, values in (("r", radii), ("f", heights)):
        extreme = (values != 0.0) & ~((np.abs(values) >= 1e-100) & (np.abs(values) <= 1e100))
        refuse(name, values, extreme, "must be 0 or of a size in [1e-100, 1e+100] m", "m")
    if radii[0] != 0.0 or heights[0] != 0.0:
        raise InputError("", rule=f"r[0], f[0] = {radii[0]:g}, {heights[0]:g} m: the table must start at r = 0, f = 0")
    for name, values, bad, rule in (
        ("r", radii, np.diff(radii) <= 0.0, "must rise strictly"),
        ("f", heights, np.diff(heights) < 0.0, "must never fall"),
    ):
        if np.any(bad):
            i = int(np.argmax(bad))
            raise InputError("", rule=f"{name}[{i + 1}] = {values[i + 1]:g} m after {values[i]:g} m: {name} {rule}")
    if heights[-1] == 0.0:
        raise InputError("", rule="f = 0 m everywhere: must rise; a flat face alone is a FlatPunch")
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
