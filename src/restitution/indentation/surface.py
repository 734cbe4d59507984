"""State of the elements of a surface: displacements, stored energy, and the imprint that a contact leaves."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, field
from functools import cached_property
from typing import TYPE_CHECKING, NamedTuple, cast

import numpy as np
from numpy.polynomial import chebyshev
from numpy.typing import ArrayLike, NDArray
from scipy.optimize import brentq

from restitution.checks import Array, nonnegative, single_nonnegative
from restitution.contact.profiles import Profile
from restitution.errors import InputError, InputTypeError
from restitution.indentation.solid import solid_of
from restitution.indentation.work import integral
from restitution.kernel.panels import FROZEN, Solid, Stack
from restitution.units import LENGTH

if TYPE_CHECKING:
    from restitution.contact.geometry import Contact, Geometry
    from restitution.material.prony import PronySeries

# Middle of an imprint, over its radius.
_MIDDLE = 0.3
# Error of integrals over elements.
_RTOL = 1e-10


def share_of_step(kind: NDArray[np.int64], z: Array) -> Array:
    """Return the share of its step that has passed at places z, shape (P, n), of panels; see `kernel.panels.share`."""
    power = np.abs(kind)[:, None]
    passed: Array = np.where(kind[:, None] > 0, z**power, 1.0 - (1.0 - z) ** power)
    passed[kind == FROZEN] = 0.0
    return passed


def pace_of_step(kind: NDArray[np.int64], z: Array) -> Array:
    """Return the slope of the share over z."""
    power = np.maximum(np.abs(kind), 1)[:, None]
    pace: Array = power * np.where(kind[:, None] > 0, z, 1.0 - z) ** (power - 1)
    pace[kind == FROZEN] = 0.0
    return pace


class Panels(NamedTuple):
    """Elements that changed state in the steps of a run, arrays over P panels; see `restitution.kernel.panels`."""

    coefficients: Array  # (P, Q, N): Chebyshev coefficients over z
    start: Array  # (P,)
    length: Array  # (P,)
    kind: NDArray[np.int64]  # (P,)
    end: Array  # (P,)
    follows: bool

    @property
    def size(self) -> int:
        """Number of panels."""
        return self.end.size

    @property
    def sign(self) -> float:
        """1 if their elements run outwards, -1 inwards."""
        return 1.0 if self.follows else -1.0

    def part(self, p: int) -> Panels:
        """Return panel p alone."""
        return self.some(slice(p, p + 1))

    def some(self, rows: slice | NDArray[np.intp]) -> Panels:
        """Return some of the panels."""
        return Panels(
            self.coefficients[rows], self.start[rows], self.length[rows], self.kind[rows], self.end[rows], self.follows
        )


def panels_of(stack: Stack, count: int, follows: bool) -> Panels:
    """Return the panels of a stack of the kernel."""
    return Panels(
        stack.coefficients[:count], stack.start[:count], stack.length[:count], stack.kind[:count], stack.end[:count],
        follows,
    )  # fmt: skip


class Elements:
    """Elements of a surface at one instant, under the body or free.

    Parameters
    ----------
    profile : Geometry
        Profile of the body.
    solid : Solid
        Modulus of the material.
    following, free : Panels
        Those of the contact from the axis outwards, and the free ones from the outermost inwards.
    length, radius, energy : float
        Units of the numbers in panels: depth [m], stiffness radius [m], and energy over `int (stress depth) da` [J].
    time, depth : float
        The instant, and the depth of the body.
    memory : array
        h_k of the contact.
    """

    def __init__(
        self, profile: Geometry, solid: Solid, following: Panels, free: Panels, length: float, radius: float,
        energy: float, time: float, depth: float, memory: Array,
    ) -> None:  # fmt: skip
        self._profile, self._solid, self._following, self._free = profile, solid, following, free
        self._length, self._unit, self._energy = length, radius, energy
        self._time, self._depth, self._memory = time, depth, memory

    @cached_property
    def stored(self) -> float:
        """Energy [J] in the springs of the material, `2 int [Einf u^2/2 + sum l_k^2/(2 E_k)] da`."""
        return self._sum(1, lambda radius: radius) * self._energy

    def displacement(self, radius: Array) -> Array:
        """Return the displacement [m] of the surface at radii [m], positive into the body.

        `w(r) = 2/pi int_0^r W(x) dx/sqrt(r^2 - x^2)`, where W is the displacement of the elements.
        """
        if not isinstance(self._profile, Profile):
            raise InputError("profile", self._profile, f"has no surface displacement: {self._profile.obstacle}")
        r = np.asarray(radius, dtype=np.float64) / self._unit
        total = np.zeros(r.shape)
        for place in np.ndindex(r.shape):
            most = max(float(r[place]), 1e-300)
            total[place] = self._sum(0, lambda x, most=most: np.arcsin(np.minimum(x / most, 1.0)), most)
        return total * (2.0 / math.pi * self._length)

    def _sum(self, row: int, weight: Callable[[Array], Array], kink: float = math.inf) -> float:
        """Return `int V dw = -int w dV` over all elements, with a weight w(a), zero at a = 0 and smooth up to a kink.

        V is their displacement, row 0, or their stored energy, row 1, and zero beyond them. By parts a flat face, a
        radius that is no smooth function of y, and the root at the radius of a displacement need no rules.
        """
        total, edge, before = 0.0, 0.0, 0.0
        for panels in (self._following, self._free):
            if panels.size:
                total -= panels.sign * self._inside(panels, row, weight, kink)
                # From the axis on: following panels from the first, free ones from the last.
                order = slice(None, None, 1 if panels.follows else -1)
                y, values, _ = self._at(panels, panels.end[:, None] * np.array([0.0, 1.0]))
                weights = weight(self._radius(y))[order, order].ravel()
                ends = values[row, order, order].ravel()
                # At joints V jumps by the errors of panels.
                total -= edge * (ends[0] - before) + float(weights[1:-1:2] @ (ends[2::2] - ends[1:-1:2]))
                edge, before = float(weights[-1]), float(ends[-1])
        return total + edge * before

    def _inside(self, panels: Panels, row: int, weight: Callable[[Array], Array], kink: float) -> float:
        """Return the sum over panels of `int w dV` over z."""

        def slope(u: Array) -> Array:
            place = np.minimum(u.astype(np.intp), panels.size - 1)
            some = panels.some(place)
            y, _, slopes = self._at(some, (some.end * (u - place))[:, None])
            result: Array = weight(self._radius(y[:, 0])) * slopes[row, :, 0] * some.end
            return result

        # Where the kink lies next to the end of a panel, no point of a quadrature may be before it.
        radii = self._radius(self._at(panels, panels.end[:, None] * np.array([0.0, 1.0]))[0])
        edges: list[float] = list(range(panels.size + 1))
        for n in np.flatnonzero((radii.min(axis=1) < kink) & (kink < radii.max(axis=1))).tolist():
            part = panels.part(n), kink
            # Signs may differ from those of the radii by rounding.
            if self._beyond(0.0, *part) * self._beyond(1.0, *part) < 0.0:
                edges.append(n + cast(float, brentq(self._beyond, 0.0, 1.0, args=part, xtol=1e-15)))
        return integral(slope, np.unique(edges), _RTOL, 0.0)

    def _beyond(self, share: float, panel: Panels, radius: float) -> float:
        """Return by how much the element at a share of a panel is outside of a radius."""
        return float(self._radius(self._at(panel, panel.end[:, None] * share)[0])[0, 0]) - radius

    def axis_depth_at(self, time: float) -> float:
        """Return the displacement [m] of the element at the axis at a time, while it is free."""
        if self._axis is None:
            return 0.0
        panel, place = self._axis
        later = panel._replace(start=panel.start - (time - self._time))
        return float(self._at(later, place)[1][0, 0, 0]) * self._length

    @property
    def _axis(self) -> tuple[Panels, Array] | None:
        """The panel at the axis, and the place of the axis in it; None on virgin surface."""
        if self._following.size:
            return self._following.part(0), np.zeros((1, 1))
        last = self._free.size - 1
        return (self._free.part(last), self._free.end[last:, None]) if last >= 0 else None

    def _radius(self, y: Array) -> Array:
        return np.asarray(self._profile.stiffness_radius(y * y * self._length)) / self._unit

    def _at(self, panels: Panels, z: Array) -> tuple[Array, Array, Array]:
        """Return y of elements at places z, shape (P, n), of panels; displacement and stored energy over da; slopes.

        The second and third have the shape (2, P, n); slopes are those over z.
        """
        solid, follows = self._solid, panels.follows
        rates = (solid.rates if follows else solid.recoveries)[:, None, None]
        coefficients = panels.coefficients[:, : 1 + rates.size]
        basis = chebyshev.chebvander(2.0 * z - 1.0, coefficients.shape[-1] - 1)
        row = np.einsum("pqk,pnk->qpn", coefficients, basis)
        rises = np.einsum("pqk,pnk->qpn", chebyshev.chebder(coefficients, scl=2.0, axis=2), basis[..., :-1])
        passed, pace = share_of_step(panels.kind, z), pace_of_step(panels.kind, z)
        length = panels.length[:, None]
        decay = np.exp(-rates * (self._time - panels.start[:, None] - length * passed))
        loads, pulls = row[1:] * decay, (rises[1:] + row[1:] * rates * (length * pace)) * decay
        y = np.maximum(row[0], 0.0)
        if follows:
            displacement, slope = self._depth - y * y, -2.0 * y * rises[0]
            loads = loads + (solid.moduli * self._memory)[:, None, None]
        else:
            displacement, slope = loads.sum(axis=0), pulls.sum(axis=0)
            loads, pulls = (np.tensordot(solid.moduli_of, parts, 1) for parts in (loads, pulls))
        moduli = solid.moduli[:, None, None]
        energy = 0.5 * (solid.equilibrium * displacement**2 + np.sum(loads**2 / moduli, axis=0))
        power = solid.equilibrium * displacement * slope + np.sum(loads * pulls / moduli, axis=0)
        return y, np.stack([displacement, energy]), np.stack([slope, power])


class Imprint(NamedTuple):
    """Free panels of a surface without load, the innermost on top; in SI."""

    coefficients: Array  # (P, 1 + J, N): Chebyshev coefficients of y [m^(1/2)] and parts of the displacement [m]
    start: Array  # (P,): time [s] since the instant of the surface, negative
    length: Array  # (P,): [s]
    kind: NDArray[np.int64]  # (P,)
    end: Array  # (P,)
    joint: NDArray[np.int64]  # (P,)

    def some(self, rows: slice) -> Imprint:
        """Return some of the panels."""
        return Imprint(
            self.coefficients[rows], self.start[rows], self.length[rows], self.kind[rows], self.end[rows],
            self.joint[rows],
        )  # fmt: skip

    def axis_depth(self, recoveries: Array) -> float:
        """Return the displacement [m] of the innermost element now; `recoveries` are the rates r_j [1/s]."""
        if not self.end.size:
            return 0.0
        end, kind, degrees = float(self.end[-1]), int(self.kind[-1]), np.arange(self.coefficients.shape[2])
        basis = np.cos(math.acos(2.0 * end - 1.0) * degrees)
        share = 0.0 if kind == FROZEN else end**kind if kind > 0 else 1.0 - (1.0 - end) ** -kind
        passed = float(self.start[-1]) + float(self.length[-1]) * share
        return float(np.exp(passed * recoveries) @ (self.coefficients[-1, 1:] @ basis))

    def gap(self, recoveries: Array) -> float:
        """Return the least gap between the surface now and a tip that meets it at the axis, over y^2 [m].

        It is 1 for a flat surface, and 0 for an imprint of the shape of the tip. Errors of the surface move the front
        by themselves over the gap. The middle of the imprint, where gaps are small, does not count.
        """
        if not self.end.size:
            return 1.0
        y, displacement = self._inner_ends(recoveries)
        outer = y > _MIDDLE * y[0]
        return float(np.min(1.0 + (displacement[outer] - displacement[-1]) / y[outer] ** 2, initial=1.0))

    def _inner_ends(self, recoveries: Array) -> tuple[Array, Array]:
        """Return y [m^(1/2)] and the displacement [m] now at the inner end of each panel."""
        basis = chebyshev.chebvander(2.0 * self.end - 1.0, self.coefficients.shape[2] - 1)
        y, parts = self.coefficients[:, 0], self.coefficients[:, 1:]
        passed = self.start + self.length * share_of_step(self.kind, self.end[:, None])[:, 0]
        decays = np.exp(passed[:, None] * recoveries)
        return np.einsum("pk,pk->p", y, basis), np.einsum("pjk,pk,pj->p", parts, basis, decays)

    def around(self, inner: Imprint) -> Imprint:
        """Return these panels and those further inside."""
        return Imprint(
            np.concatenate([self.coefficients, inner.coefficients]), np.append(self.start, inner.start),
            np.append(self.length, inner.length), np.append(self.kind, inner.kind), np.append(self.end, inner.end),
            np.append(self.joint, inner.joint),
        )  # fmt: skip


def read_imprint(free: Stack, count: int, now: float, length: float, time: float) -> Imprint:
    """Return free panels of the kernel, whose units of length [m] and time [s] are given, as an imprint."""
    coefficients = free.coefficients[:count] * length
    coefficients[:, 0] = free.coefficients[:count, 0] * math.sqrt(length)
    return Imprint(
        coefficients, (free.start[:count] - now) * time, free.length[:count] * time, free.kind[:count].copy(),
        free.end[:count].copy(), free.joint[:count].copy(),
    )  # fmt: skip


def write_imprint(free: Stack, imprint: Imprint, length: float, time: float) -> None:
    """Write an imprint into free panels of the kernel, at time zero there."""
    count = imprint.end.size
    free.coefficients[:count] = imprint.coefficients / length
    free.coefficients[:count, 0] = imprint.coefficients[:, 0] / math.sqrt(length)
    free.start[:count], free.length[:count] = imprint.start / time, imprint.length / time
    free.kind[:count], free.end[:count], free.joint[:count] = imprint.kind, imprint.end, imprint.joint


@dataclass(frozen=True, eq=False)
class Surface:
    """Surface that a contact has left: free of load, with an imprint that recovers.

    `surface=` of `indent` and `solve` lets the same body meet it again at the same spot.

    Attributes
    ----------
    contact : Contact
        Materials and profile of the contacts before.
    time : float
        Time [s] since the end of the last result.
    marks : Imprint
        The elements of the surface, the innermost last: arrays of Chebyshev coefficients, over a coordinate z of each
        panel, of y [m^(1/2)], with the element's depth y^2 in the undeformed body, and of the parts w_j [m] of its
        displacement. `start`, `length` and `kind` give the instants at which they left the contact, and `end` the
        largest z that is left. `imprint` evaluates them.

    Notes
    -----
    The elements of the surface, each named by the depth at which the undeformed surface touches it, have the
    displacement `W = sum w_j exp(-r_j t)` with the retardation rates r_j. They are the exact state of a half-space
    after any history under one axisymmetric body.

    Examples
    --------
    >>> import restitution as rs
    >>> gel = rs.standard_solid(70.0, 270.0, 80.0, poisson_ratio=0.5)
    >>> first = rs.indent(gel, rs.Parabola(2.5e-6), depth=rs.triangle(1e-6, 1.0))
    >>> surface = first.surface(after=0.5)
    >>> print(f"{surface.depth:.3e} m deep at the axis")
    2.757e-07 m deep at the axis
    """

    contact: Contact
    time: float
    _series: PronySeries = field(repr=False)
    marks: Imprint = field(repr=False)

    def after(self, time: float) -> Surface:
        """Return the surface a further time [s] later."""
        passed = single_nonnegative("time", time, "s")
        imprint = self.marks._replace(start=self.marks.start - passed)
        return Surface(self.contact, self.time + passed, self._series, imprint)

    @cached_property
    def _elements(self) -> Elements:
        free = Panels(*self.marks[:5], False)
        none, profile = np.empty(0), self.contact.profile
        return Elements(
            profile, solid_of(self._series), free.some(slice(0, 0)), free, 1.0, 1.0, 2.0, 0.0, 0.0, none,
        )  # fmt: skip

    def depth_after(self, time: float) -> float:
        """Return the depth [m] of the surface at the axis a time [s] later."""
        return self._elements.axis_depth_at(time)

    @property
    def depth(self) -> float:
        """Depth [m] of the surface at the axis, where the next contact begins."""
        return self.marks.axis_depth(solid_of(self._series).recoveries)

    @property
    def stored(self) -> float:
        """Energy [J] that is left in the springs of the material, which dissipates while the surface recovers."""
        return self._elements.stored

    def imprint(self, radius: ArrayLike) -> Array:
        """Return the displacement [m] of the surface at radii [m] from the axis, positive into the body.

        Raises
        ------
        InputError
            If the body is not axisymmetric, or a radius is negative.
        """
        return self._elements.displacement(np.asarray(nonnegative("radius", radius, LENGTH.unit)))[()]


def check_surface(surface: Surface, contact: Contact) -> None:
    """Refuse a surface that another contact has left."""
    if not isinstance(surface, Surface):
        raise InputTypeError("surface", surface, "must be a Surface, such as surface() of a result")
    for name in ("material", "counter_material", "profile"):
        mine, theirs = getattr(surface.contact, name), getattr(contact, name)
        if mine is not theirs and mine != theirs:
            raise InputError("surface", rule=f"has another {name}; an imprint serves the body that made it")
