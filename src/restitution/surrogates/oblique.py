"""Surrogate of an impact with friction: e over the velocity, e_t over the velocity and the slope v_c/(mu v0).

e_t depends on friction and tangential velocity by the slope alone, e does not depend on them. Up to the slope at which
the glassy contact begins to slide, the first variable is log v0 and the second the slope over that one. From there to
the slope of full sliding, the second is the root of the rest up to it, in which e_t has no kink. Beyond, e_t has a
closed form.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any, ClassVar, NamedTuple

import numba
import numpy as np

from restitution.checks import Array, Numeric, common_shape, finite, nonnegative, one_of, positive, within
from restitution.errors import InputError
from restitution.quantities import VELOCITY, check
from restitution.surrogates.boxes import Boxes, Pieces, box_value, fill, ready
from restitution.surrogates.standard_solid import compiled
from restitution.surrogates.velocity import (
    OBLIQUE_,
    OUTPUTS,
    ROUNDING,
    Surrogate,
    check_pieces,
    lookup_table,
    scalar_function,
    value,
    values,
)

E_T = "tangential_restitution_coefficient"

_HEADS = ("e_t without slip", "v_c/(mu v) of full sliding")


class Sliding(NamedTuple):
    """Tangential half of an impact over its velocity.

    Attributes
    ----------
    mobility : float
        1 + 1/kappa, the mass over that of the contact point.
    pull : float
        Constant force over the mass [m/s^2].
    start : float
        Slope v_c/(mu v0) from which all slides at first touch.
    limit : Pieces
        Logarithm of the slope of full sliding over the logarithm of the velocity.
    sticks, slips : Boxes
        e_t over the logarithm of the velocity and the second variable, below and above `start`.
    """

    mobility: float
    pull: float
    start: float
    limit: Pieces
    sticks: Boxes
    slips: Boxes


class Rebound(NamedTuple):
    """Velocities after an impact: away from the surface and along it [m/s], and spin [rad/s]."""

    velocity: Numeric
    tangential_velocity: Numeric
    spin: Numeric


@compiled
def tangential_value(v: float, sliding: float, friction: float, table: Any) -> float:
    """Return e_t at a normal velocity and that of the contact point along the surface; NaN outside the range.

    It keeps to Coulomb's law, and the contact point gains no energy, whatever the error of the series.
    """
    e_table, time_table, limit_table, sticks, slips, start, mobility, pull = table
    e = value(v, e_table)
    # Not a number is no friction either.
    if math.isnan(e) or math.isnan(sliding) or not friction >= 0.0:
        return math.nan
    slope = abs(sliding)
    if slope > 0.0:
        if friction == 0.0:
            return -1.0
        slope /= friction * v
    impulse = 1.0 + e
    if pull != 0.0:
        impulse += pull * value(v, time_table) / v
    most = mobility * impulse / slope - 1.0 if slope > 0.0 else 1.0
    limit = max(value(v, limit_table), start)
    if slope >= limit:
        return min(most, 1.0)
    x = math.log(v)
    if slope < start:
        e_t = box_value(x, slope / start, sticks)
    else:
        e_t = box_value(x, math.sqrt((limit - slope) / (limit - start)), slips)
    return min(max(e_t, -1.0), most, 1.0)


@compiled
def tangential_values(v: Any, sliding: Any, friction: Any, out: Any, table: Any) -> None:
    """Write e_t at arrays of velocities and friction."""
    for n in range(v.size):
        out[n] = tangential_value(v[n], sliding[n], friction[n], table)


@dataclass(frozen=True, eq=False, repr=False, kw_only=True)
class ObliqueSurrogate(Surrogate):
    """Outputs of an impact with friction by interpolation; `surrogate` returns them.

    Besides what a `Surrogate` has, e_t and the rebound, for all velocities along the surface and all coefficients of
    friction: e_t depends on them by the slope ``v_c/(mu v0)`` alone, and e not at all.

    Attributes
    ----------
    friction, gyration, radius : float
        Coefficient of friction, moment of inertia over m R^2 [-], and radius [m] of the impact, NaN of two bodies.
    sliding : Sliding
        e_t over the velocity and the slope.

    Notes
    -----
    `error` has that of e_t too, which is absolute: twice the largest difference from the solver at points that were
    not used to build it, plus twice the tolerance of the solves, plus what the error of e adds. Results never break
    Coulomb's law, ``|impulse ratio| <= mu``, and the contact point never gains energy, ``|e_t| <= 1``. The validity
    report is that of the friction and of the tangential velocity of the impact.
    """

    _numbers = (*Surrogate._numbers, "friction", "gyration", "radius")
    _names: ClassVar[tuple[str, ...]] = (*OUTPUTS, E_T)

    friction: float
    gyration: float
    radius: float
    sliding: Sliding = field(repr=False)

    def __post_init__(self) -> None:
        super().__post_init__()
        check_pieces(self.sliding.limit, 1)
        ends = np.log(self.velocity)
        for low, high in (
            self.sliding.limit.edges[[0, -1]], *((box.low[0], box.high[0]) for box in self.sliding[-2:])
        ):  # fmt: skip
            if np.abs(np.subtract((low, high), ends)).max() > ROUNDING * max(1.0, np.abs(ends).max()):
                raise InputError("sliding", rule="must have the range of velocities")

    def tangential_restitution_coefficient(
        self, velocity: Any, tangential_velocity: Any, spin: Any = 0.0, *, friction: Any = None
    ) -> Any:
        """Return e_t = -v_c'/v_c [-] of the contact point.

        Parameters
        ----------
        velocity : float or array
            Normal velocity v0 [m/s], within the range.
        tangential_velocity : float or array
            Velocity v_x [m/s] of the centre along the surface; of two bodies that of their contact points.
        spin : float or array
            Spin w [rad/s]; the contact point has the velocity v_c = v_x + R w.
        friction : float or array, optional
            Coefficient of friction, >= 0; that of the impact by default.

        Returns
        -------
        float or array
            e_t in the common shape; where the contact point rests, its limit for small velocities.
        """
        return self._tangential(velocity, tangential_velocity, spin, friction)[0]

    def impulse_ratio(self, velocity: Any, tangential_velocity: Any, spin: Any = 0.0, *, friction: Any = None) -> Any:
        """Return the tangential over the normal impulse [-], in the direction against v_c.

        Its size is at most the coefficient of friction. For the parameters, see `tangential_restitution_coefficient`.
        """
        e_t, v, point = self._tangential(velocity, tangential_velocity, spin, friction)
        normal = 1.0 + np.asarray(self.restitution_coefficient(v))
        if self.sliding.pull:
            normal = normal + self.sliding.pull * np.asarray(self.contact_time(v)) / v
        return ((1.0 + e_t) * point / (self.sliding.mobility * v * normal))[()]

    def full_sliding(self, velocity: Any) -> Any:
        """Return the slope v_c/(mu v0) [-] from which all of the contact slides to the end, at v0 [m/s]."""
        v = np.asarray(within("velocity", velocity, *self.velocity, VELOCITY.unit))
        limits = np.empty(v.shape)
        values(v.reshape(-1), limits.reshape(-1), self._sliding_table[2])
        return np.maximum(limits, self.sliding.start)[()]

    def rebound(self, velocity: Any, tangential_velocity: Any, spin: Any = 0.0, *, friction: Any = None) -> Rebound:
        """Return the velocities and the spin after the impact; the latter is NaN where the body has no radius.

        For the parameters, see `tangential_restitution_coefficient`.

        Examples
        --------
        >>> import restitution as rs
        >>> rubber = rs.standard_solid(1e6, 1e7, 1e3, poisson_ratio=0.5)
        >>> ball = rs.Impact(rubber, rs.Parabola(0.01), mass=0.005, velocity=1.0, friction=0.5)
        >>> e = rs.surrogate(ball, velocity=(0.9, 1.0), rtol=1e-3)
        >>> after = e.rebound(1.0, 0.6, spin=20.0)
        >>> print(f"{after.velocity:.3f} {after.tangential_velocity:.3f} {after.spin:.1f}")
        0.234 0.347 -43.3
        """
        e_t, v, point = self._tangential(velocity, tangential_velocity, spin, friction)
        change, kappa = (1.0 + e_t) * point, self.gyration
        along = np.asarray(tangential_velocity, dtype=np.float64) - kappa / (1.0 + kappa) * change
        after = np.asarray(spin, dtype=np.float64) - change / ((1.0 + kappa) * self.radius)
        away = np.broadcast_to(np.asarray(self.restitution_coefficient(v)) * v, np.shape(e_t))
        return Rebound(away[()], along[()], after[()])

    def compiled(self, output: str = "restitution_coefficient") -> Any:
        """Return an output as a function compiled by numba; see `Surrogate.compiled`.

        That of "tangential_restitution_coefficient" takes the normal velocity, that of the contact point along the
        surface [m/s], and the coefficient of friction.
        """
        if one_of("output", output, self._names) != E_T:
            return scalar_function(self._tables[output])
        table = self._sliding_table

        @numba.njit(error_model="numpy")
        def of_velocities(v: float, sliding: float, friction: float) -> float:
            return tangential_value(v, sliding, friction, table)

        return of_velocities

    def _tangential(self, velocity: Any, along: Any, spin: Any, friction: Any) -> tuple[Any, Any, Any]:
        """Return e_t, the normal velocity, and that of the contact point."""
        v = within("velocity", velocity, *self.velocity, VELOCITY.unit)
        point, turning = check("tangential_velocity", along), check("spin", spin)
        if np.any(turning):
            if math.isnan(self.radius):
                rule = "must be 0 for a body without a radius; give the velocity of the contact points"
                raise InputError("spin", spin, rule, "rad/s")
            point = point + self.radius * turning
        mu = self.friction if friction is None else check("friction", friction)
        numbers = {"velocity": v, "tangential_velocity": point, "friction": mu}
        shape = common_shape({name: np.shape(each) for name, each in numbers.items()})
        columns = [np.array(np.broadcast_to(each, shape), dtype=np.float64, order="C") for each in numbers.values()]
        out = np.empty(shape)
        tangential_values(*(each.reshape(-1) for each in columns), out.reshape(-1), self._sliding_table)
        return out[()], columns[0][()], columns[1][()]

    @cached_property
    def _sliding_table(self) -> tuple[Any, ...]:
        tables, sliding = self._tables, self.sliding
        limit = lookup_table(sliding.limit, 0, *self.velocity, math.inf)
        return (
            tables["restitution_coefficient"], tables["contact_time"], limit, ready(sliding.sticks),
            ready(sliding.slips), sliding.start, sliding.mobility, sliding.pull,
        )  # fmt: skip

    def _columns_of(self, speeds: Array) -> list[Any]:
        rest = self.tangential_restitution_coefficient(speeds, 0.0)
        return [*super()._columns_of(speeds), rest, self.full_sliding(speeds)]

    @property
    def _heads(self) -> tuple[str, ...]:
        return (*super()._heads, *_HEADS)

    @property
    def _version(self) -> int:
        return OBLIQUE_

    def _content(self) -> dict[str, Any]:
        sliding = self.sliding
        return {
            "friction": str(self.friction) if math.isinf(self.friction) else self.friction,
            "gyration": self.gyration,
            "radius": None if math.isnan(self.radius) else self.radius,
            "sliding": {
                "mobility": sliding.mobility, "pull": sliding.pull, "start": sliding.start,
                "log_velocity_edges": sliding.limit.edges.tolist(),
                "chebyshev_coefficients_of_log_limit": sliding.limit.coefficients[0].tolist(),
                "sticks": _boxes_content(sliding.sticks), "slips": _boxes_content(sliding.slips),
            },
        }  # fmt: skip

    @classmethod
    def _further(cls, content: dict[str, Any]) -> dict[str, Any]:
        part = content["sliding"]
        mobility, start = (float(positive(f"sliding.{name}", part[name])) for name in ("mobility", "start"))
        series = np.asarray(finite("sliding.limit", part["chebyshev_coefficients_of_log_limit"]))
        limit = Pieces(np.asarray(finite("sliding.log_velocity_edges", part["log_velocity_edges"])), series[None])
        friction = check("friction", float(content["friction"]))
        sticks, slips = (_boxes_of(f"sliding.{name}", part[name]) for name in ("sticks", "slips"))
        pull = float(nonnegative("sliding.pull", part["pull"]))
        return {
            "friction": float(friction),
            "gyration": float(positive("gyration", content["gyration"])),
            "radius": math.nan if content["radius"] is None else float(positive("radius", content["radius"])),
            "sliding": Sliding(mobility, pull, start, limit, sticks, slips),
        }


def _boxes_content(boxes: Boxes) -> dict[str, Any]:
    return {name: part.tolist() for name, part in boxes._asdict().items()}


def _boxes_of(name: str, content: dict[str, Any]) -> Boxes:
    """Return the boxes of a file, checked: that they fit each other, and fill the rectangle."""
    low, high, coefficients = (
        np.asarray(finite(f"{name}.{part}", content[part])) for part in ("low", "high", "coefficients")
    )
    levels, places = (np.asarray(content[part], dtype=np.int64) for part in ("levels", "places"))
    boxes = Boxes(low, high, levels, places, coefficients)
    if not fill(boxes):
        raise InputError(name, rule="must be boxes that fill their rectangle")
    return boxes
