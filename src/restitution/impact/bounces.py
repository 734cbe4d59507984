"""Bounces of a falling body until it comes to rest."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from enum import StrEnum
from functools import cached_property
from typing import TYPE_CHECKING, Any, NamedTuple, Self

import numpy as np

from restitution.checks import Array, function, nonnegative, single, truth, whole
from restitution.errors import InputError, InputTypeError
from restitution.impact.adhesion import AdhesiveResult
from restitution.impact.adhesive import attraction_numbers
from restitution.impact.oblique import ObliqueResult, sliding_numbers
from restitution.impact.problem import STANDARD_GRAVITY, Impact, fall_velocity
from restitution.impact.result import ImpactResult
from restitution.impact.solve import solve, solve_exact
from restitution.impact.status import Status
from restitution.material.prony import PronySeries
from restitution.quantities import (
    BOUNCES,
    CONTACT_TANGENT,
    INPUTS,
    NUMBER,
    OBLIQUE,
    OUTPUTS,
    SOLVER_RTOL,
    Quantity,
    check_single,
    dataset,
)
from restitution.result import Result, Summary
from restitution.units import VELOCITY, in_words
from restitution.validity import COLUMNS, Validity, validity

if TYPE_CHECKING:
    import xarray

    from restitution.indentation.surface import Surface


# Share of an imprint that may be left at the next touch without a warning.
_UNRECOVERED = 0.01


class Ending(StrEnum):
    """Why a series of bounces ended."""

    CAPTURED = "captured", "the weight holds the body in contact"
    STUCK = "stuck", "the attraction holds the body in contact"
    SUNK = "sunk", "the material is a liquid and the body sinks in"
    BELOW_SURFACE = "below surface", "the body does not rise above the undeformed surface"
    LIFTED = "lifted", "the recovering surface meets the body on its way up"
    LOW = "low", "the next rise would be lower than min_height"
    MAX_BOUNCES = "max bounces", "max_bounces is reached; the body would bounce on"
    STOPPED = "stopped", "the argument stop ended the series; the body would bounce on"
    UNSOLVED = "unsolved", "the next touch of the imprint could not be solved; another rtol may do"

    message: str

    def __new__(cls, word: str, message: str) -> Self:
        """Make a member, whose value is the word."""
        member = str.__new__(cls, word)
        member._value_, member.message = word, message
        return member


_OUTPUTS = ("restitution_coefficient", "rebound_velocity", "contact_time", "residual_indentation_depth")
_COLUMNS = {
    "touch_time": BOUNCES["touch_time"]._replace(words="time of touch since release"),
    "velocity": INPUTS["velocity"],
    **{name: OUTPUTS[name] for name in _OUTPUTS},
    "height": BOUNCES["height"],
}
_TANGENT = {"loss_tangent": CONTACT_TANGENT}
_REBOUND = ("tangential_restitution_coefficient", "rebound_tangential_velocity", "rebound_spin")
_SLIDING = {
    "place": BOUNCES["place"],
    **{name: INPUTS[name] for name in ("tangential_velocity", "spin")},
    **{name: OBLIQUE[name] for name in _REBOUND},
}


@dataclass(frozen=True, eq=False, repr=False)
class Bounces(Result):
    """Bounces of a falling body, arrays of shape (n_bounce,), in SI.

    `plot` shows the height over time, the restitution over the velocity, and the height of each bounce.

    Attributes
    ----------
    touch_time : array
        Time [s] from the release to the touch.
    velocity : array
        Impact velocity v0 [m/s].
    restitution_coefficient : array
        e [-]; 0 where the body stays.
    rebound_velocity : array
        e v0 [m/s].
    contact_time : array
        Contact time [s]; infinite where the body stays.
    residual_indentation_depth : array
        Depth [m] at separation. If the body stays: the static depth under its weight, or under the attraction alone,
        infinite in a liquid.
    height : array
        Greatest height [m] of the lowest point over the undeformed surface after the bounce; 0 where the body stays,
        negative where it does not leave its imprint.
    drop_height : float
        Height [m] of the release.
    gravity : float
        Acceleration of free fall [m/s^2].
    ended : Ending
        "captured": the weight holds the body. "stuck": the attraction alone does. "sunk": the material is a liquid and
        the body sinks in. "below surface": the body does not rise above the undeformed surface. "low": the next height
        is below `min_height`. "max bounces", "stopped": the body would bounce on. "unsolved": so it would, but its
        next touch on the same spot could not be solved; a warning has the reason.
    impact : Impact
        The first impact.
    validity : Validity
        Report on the assumptions of the theory: the worst of each over all bounces.
    notes : tuple of str
        Warnings about a surface that has not recovered at a touch, or about a touch that could not be solved.
    """

    _numbers = (*_COLUMNS, *_TANGENT, "drop_height", "gravity", "ended", "warnings", "validity")
    _picture = "impact.bounces_overview"
    _listed = tuple((_COLUMNS | _TANGENT).items())

    touch_time: Array
    velocity: Array
    restitution_coefficient: Array
    rebound_velocity: Array
    contact_time: Array
    residual_indentation_depth: Array
    height: Array
    drop_height: float
    gravity: float
    ended: Ending
    impact: Impact
    validity: Validity
    notes: tuple[str, ...]

    @property
    def warnings(self) -> list[str]:
        """Doubtful assumptions, with numbers, and `notes`."""
        return [*self.validity.warnings, *self.notes]

    @property
    def n_bounces(self) -> int:
        """Number of touches; the body may stay after the last one."""
        return self.touch_time.size

    @cached_property
    def loss_tangent(self) -> Array:
        """Loss tangent [-] of the reduced modulus at pi over each contact time; NaN where the body stays."""
        series, stays = self.impact.reduced_modulus, ~np.isfinite(self.contact_time)
        omega = math.pi / np.where(stays, 1.0, self.contact_time)
        return np.where(stays, np.nan, series.loss_modulus(omega) / series.storage_modulus(omega))

    def to_dataset(self) -> xarray.Dataset:
        """Return the dataset of all columns over `bounce`, with units."""
        attributes = {"drop_height": self.drop_height, "gravity": self.gravity, "ended": str(self.ended)}
        columns = {name: (getattr(self, name), quantity) for name, quantity in self._listed}
        numbers = {"bounce": (np.arange(1, self.n_bounces + 1), Quantity("bounce", NUMBER, "bounce"))}
        return dataset("bounce", numbers | columns, attributes)

    def summary(self, title: str = "") -> Summary:
        """Return the table of the bounces and their warnings, which `print` and notebooks show."""
        from restitution.impact.result import of_bounces

        return of_bounces(self, title)

    @property
    def _short(self) -> str:
        return f"{self.n_bounces} from {in_words(self.drop_height, 'm')}, {self.ended}"


@dataclass(frozen=True, eq=False, repr=False, kw_only=True)
class ObliqueBounces(Bounces):
    """Bounces of a body with friction, which moves along the surface and spins; `plot` shows its path.

    Attributes
    ----------
    place : array
        Place x [m] of each touch along the surface, from that of the release.
    tangential_velocity, spin : array
        Tangential velocity of the centre [m/s] and spin [rad/s] before each bounce.
    rebound_tangential_velocity, rebound_spin : array
        The same after it.
    tangential_restitution_coefficient : array
        e_t [-].
    """

    _numbers = (*Bounces._numbers, *_SLIDING)
    _listed = tuple((_COLUMNS | _TANGENT | _SLIDING).items())

    place: Array
    tangential_velocity: Array
    spin: Array
    tangential_restitution_coefficient: Array
    rebound_tangential_velocity: Array
    rebound_spin: Array


def bounces(
    impact: Impact,
    *,
    height: float | None = None,
    gravity: float = STANDARD_GRAVITY,
    with_weight: bool = True,
    max_bounces: int = 1000,
    min_height: float | None = None,
    same_spot: bool = False,
    stop: Callable[[], bool] | None = None,
    rtol: float = 1e-9,
) -> Bounces:
    """Return the bounces of a body under gravity, until it rests.

    Parameters
    ----------
    impact : Impact
        A single impact of the body on ground that does not move, such as that of `drop`. Its external force is
        replaced by the weight or by zero. With friction the body has the radius of a ball; its tangential velocity
        and spin are those of the release, and each bounce changes them.
    height : float, optional
        Height [m] of the release, > 0; by default the height that gives the velocity of `impact`.
    gravity : float
        Acceleration of free fall g [m/s^2], > 0.
    with_weight : bool
        Whether the weight m g also acts during contact. It must be False where the target has an impedance, as the
        weight would drive such a target for ever.
    max_bounces : int
        Largest number of bounces, >= 1.
    min_height : float, optional
        Height [m], >= 0, below which a rise ends the series; by default a millionth of the first height.
    same_spot : bool
        Whether each touch finds the imprint that earlier ones have left, as it is then; a fresh surface by default.
        The series then also goes on below the undeformed surface.
    stop : callable, optional
        Called without arguments after each bounce; the series ends where it returns True.
    rtol : float
        See `solve`.

    Returns
    -------
    Bounces
        A row for each touch; with friction `ObliqueBounces`.

    Raises
    ------
    InputError
        If a number is out of range, `impact` is not a single impact, friction meets `same_spot` or a body without
        the radius of a ball, or adhesion meets `same_spot`.
    SolverError
        If the solve of a bounce fails.

    Notes
    -----
    The surface is taken to have recovered before each touch, unless they are on the same spot, and a target with an
    impedance to have come back. The flights are free, without air resistance, from the depth at separation to the
    undeformed surface, or to the imprint on the axis as it then is. With adhesion the range of the attraction is left
    out against the heights, and a body that sticks ends the series.

    Examples
    --------
    >>> import restitution as rs
    >>> rubber = rs.standard_solid(1e6, 1e6, 1e2, poisson_ratio=0.45, density=1200.0)
    >>> impact = rs.drop(rs.Body(rubber, radius=0.01), rs.Body(None), height=0.5)
    >>> flight = rs.bounces(impact)
    >>> print(flight.ended, flight.n_bounces, flight.height[:3].round(4))
    captured 29 [0.3141 0.2002 0.1293]

    A superball that is thrown along the floor comes back:

    >>> ball = rs.vary(impact, {"friction": 1.0, "tangential_velocity": 1.0, "spin": 300.0})
    >>> print(rs.bounces(ball, max_bounces=3).rebound_tangential_velocity.round(2))
    [-0.39 -0.11 -0.15]
    """
    single("rtol", SOLVER_RTOL.check(rtol))
    whole("max_bounces", max_bounces)
    if stop is not None:
        function("stop", stop, "must be a function without arguments", 0)
    g = check_single("gravity", gravity)
    first, start = _first_impact(impact, height, g, with_weight)
    least = 1e-6 * start if min_height is None else min_height
    floor = single("min_height", nonnegative("min_height", least, "m"), "m")
    if truth("same_spot", same_spot) and first.friction is not None:
        raise InputError("same_spot", same_spot, "must be False with friction, which moves the body along")
    if same_spot and first.adhesion is not None:
        raise InputError("same_spot", same_spot, "must be False with adhesion, which begins on a fresh surface")
    series = _series_on_one_spot(first, g, rtol) if same_spot else _series(first, g, rtol)
    touches, ending, notes = list[_Touch](), None, list[str]()
    while ending is None:
        try:
            touches.append(next(series))
        except InputError as error:
            # What has been solved stays, as nothing that was given is wrong.
            if not (same_spot and touches):
                raise
            ending = Ending.UNSOLVED
            notes.append(f"touch {len(touches) + 1}, at rtol = {rtol:g}; {error}")
            break
        stopped = stop is not None and stop()
        ending = _ending(touches[-1], floor, len(touches) == max_bounces, stopped)
    columns, flights = _columns(touches, g)
    bodies: dict[str, Any] = {"mass": impact.mass, "impedance": impact.impedance}
    kind: Any = Bounces
    if first.friction is not None:
        kind = ObliqueBounces
        bodies |= sliding_numbers([touch.impact for touch in touches], columns)
        columns |= _sliding(touches, columns)
    if first.adhesion is not None:
        widths = [touch.result.zone_width for touch in touches if isinstance(touch.result, AdhesiveResult)]
        bodies |= attraction_numbers(first, {"zone_width": np.array(widths)})
    report = validity(impact.contact, **{name: columns[name] for name in (*COLUMNS, "velocity")}, **bodies)
    if not same_spot:
        notes += _recovery(impact.reduced_modulus, float(np.min(flights, initial=math.inf)))
    return kind(
        **{name: columns[name] for name in (*_COLUMNS, *_SLIDING) if name in columns},
        drop_height=start, gravity=g, ended=ending, impact=first, validity=report,
        notes=tuple(notes),
    )  # fmt: skip


class _Touch(NamedTuple):
    """An impact of the series, and the rise after it."""

    impact: Impact
    result: ImpactResult
    height: float  # greatest height [m] over the undeformed surface, 0 where the body stays
    in_imprint: bool = False  # whether the body may go on below the undeformed surface
    is_lifted: bool = False  # whether the surface meets the body before it falls


def _first_impact(impact: Impact, height: float | None, gravity: float, with_weight: bool) -> tuple[Impact, float]:
    """Return the first impact of the series and the height [m] of the release."""
    if not isinstance(impact, Impact):
        raise InputTypeError("impact", impact, "must be an Impact")
    if impact.shape:
        raise InputError("impact", rule=f"must be a single impact, not an array of shape {impact.shape}")
    if truth("with_weight", with_weight) and math.isfinite(impact.impedance):
        rule = "must be False where the target has an impedance, as the weight would drive such a target for ever"
        raise InputError("with_weight", with_weight, rule)
    if impact.friction is not None and not (impact.is_single_body and np.isfinite(impact.profile.ball_radius)):
        raise InputError(
            "friction", impact.friction, "must be None for bounces of a body without the radius of a ball"
        )
    if height is None:
        velocity = float(impact.velocity)
        start = velocity * velocity / (2.0 * gravity)
        if not math.isfinite(start):
            raise InputError("velocity", velocity, "must be that of a fall from a finite height", VELOCITY.unit)
    else:
        start = check_single("drop_height", height, "height")
        velocity = float(fall_velocity(start, gravity))
    weight = float(impact.mass) * gravity if with_weight else 0.0
    return replace(impact, velocity=velocity, external_force=weight), start


def _series(first: Impact, gravity: float, rtol: float) -> Iterator[_Touch]:
    """Yield one impact after another of a body that falls back from each rise. The caller ends the series."""
    impact = first
    while True:
        result = solve_exact(impact, rtol) if first.adhesion is None else solve(impact, rtol=rtol)
        height = _rise(result, impact, gravity)
        yield _Touch(impact, result, height)
        velocity = float(fall_velocity(height, gravity))
        if isinstance(result, ObliqueResult):
            along, spin = result.rebound_tangential_velocity, result.rebound_spin
            impact = replace(first, velocity=velocity, tangential_velocity=along, spin=spin)
        else:
            impact = replace(first, velocity=velocity)


def _series_on_one_spot(first: Impact, gravity: float, rtol: float) -> Iterator[_Touch]:
    """Yield one impact after another on the imprint of the earlier ones."""
    impact, result = first, solve_exact(first, rtol)
    while True:
        rise, left, flight, velocity = _rise(result, impact, gravity), None, 0.0, 1.0
        if result.status is Status.SEPARATED:
            left = result.surface()
            flight = _flight(left, result, gravity)
            velocity = gravity * flight - float(result.rebound_velocity)
        yield _Touch(impact, result, rise, in_imprint=True, is_lifted=velocity <= 0.0)
        impact = replace(first, velocity=velocity)
        result = solve(impact, rtol=max(rtol, 1e-11), surface=None if left is None else left.after(flight))


def _flight(surface: Surface, result: ImpactResult, gravity: float) -> float:
    """Return the time [s] from separation until the body meets the recovering surface again."""
    from scipy.optimize import brentq

    away, depth = float(result.rebound_velocity), float(result.residual_indentation_depth)

    def gap(time: float) -> float:
        return surface.depth_after(time) - (depth - away * time + 0.5 * gravity * time * time)

    longest = 2.0 * away / gravity
    # The body is back at the depth of separation, and the surface is not below it.
    low, high = 1e-6 * longest, longest
    for share in np.geomspace(1e-6, 1.0, 49)[1:]:
        if gap(share * longest) <= 0.0:
            high = share * longest
            break
        low = share * longest
    if gap(low) <= 0.0:
        return low
    if gap(high) >= 0.0:
        return high
    touch: Any = brentq(gap, low, high, xtol=1e-15 * longest)
    return float(touch)


def _rise(result: ImpactResult, impact: Impact, gravity: float) -> float:
    """Return the greatest height [m] over the undeformed surface after an impact; 0 where the body stays."""
    if result.status is not Status.SEPARATED:
        return 0.0
    away, depth = float(result.rebound_velocity), float(result.residual_indentation_depth)
    # By the change of momentum m (v0 + v1) the target has moved this change over its impedance.
    depth += float(impact.mass) * (float(impact.velocity) + away) / float(impact.impedance)
    return away**2 / (2.0 * gravity) - depth


def _ending(touch: _Touch, floor: float, is_last: bool, is_stopped: bool) -> Ending | None:
    """Return why the series ends after a touch, or None if it goes on; `floor` is the least height [m] of a rise."""
    # In an imprint the rise counts from the separation.
    depth = float(touch.result.residual_indentation_depth)
    reasons = {
        Ending.STUCK: touch.result.status == Status.CAPTURED and _sticks(touch.impact),
        Ending.CAPTURED: touch.result.status == Status.CAPTURED,
        Ending.SUNK: touch.result.status == Status.SINKS_IN,
        Ending.BELOW_SURFACE: touch.height <= 0.0 and not touch.in_imprint,
        # Of a low rise rounding may decide whether the surface meets the body before it falls.
        Ending.LOW: touch.height + max(depth, 0.0) * touch.in_imprint < floor,
        Ending.LIFTED: touch.is_lifted,
        Ending.MAX_BOUNCES: is_last,
        Ending.STOPPED: is_stopped,
    }
    return next((ending for ending, holds in reasons.items() if holds), None)


def _sticks(impact: Impact) -> bool:
    """Return whether a body that a contact holds would stay without its weight, too."""
    if impact.adhesion is None or not np.any(impact.external_force):
        return impact.adhesion is not None
    return solve(replace(impact, external_force=0.0), rtol=1e-3).status == Status.CAPTURED


def _columns(touches: list[_Touch], gravity: float) -> tuple[dict[str, Array], Array]:
    """Return the columns of the table and of its validity, and the durations [s] of the flights between touches."""
    names = (*COLUMNS, "velocity", *_OUTPUTS)
    columns = {name: np.array([getattr(touch.result, name) for touch in touches]) for name in names}
    columns["height"] = np.array([touch.height for touch in touches])
    flights = (columns["rebound_velocity"][:-1] + columns["velocity"][1:]) / gravity
    durations = np.append(columns["velocity"][0] / gravity, columns["contact_time"][:-1] + flights)
    columns["touch_time"] = np.cumsum(durations)
    return columns, flights


def _sliding(touches: list[_Touch], columns: dict[str, Array]) -> dict[str, Array]:
    """Return the columns of the tangential motion."""
    before, after = ("tangential_velocity", "spin"), _REBOUND
    motion = {name: np.array([float(getattr(touch.impact, name)) for touch in touches]) for name in before}
    motion |= {name: np.array([float(getattr(touch.result, name)) for touch in touches]) for name in after}
    along, rebound = motion["tangential_velocity"], motion["rebound_tangential_velocity"]
    ways = np.array([touch.result.way for touch in touches if isinstance(touch.result, ObliqueResult)])
    flights = np.diff(columns["touch_time"]) - columns["contact_time"][:-1]
    steps = ways[:-1] + rebound[:-1] * flights
    return motion | {"place": np.cumsum(np.append(along[0] * columns["touch_time"][0], steps))}


def _recovery(series: PronySeries, flight: float) -> list[str]:
    """Return the warnings about a surface that has not recovered after the shortest flight [s]."""
    if math.isinf(flight) or series.is_elastic:
        return []
    if series.is_liquid:
        return ["recovery: the surface of a liquid keeps an imprint, but each touch is taken to be on a fresh surface"]
    _, _, compliances, times = series.retardation
    left = float(compliances @ np.exp(-flight / times)) * series.equilibrium_modulus
    if left <= _UNRECOVERED:
        return []
    return [
        f"recovery: the shortest flight lasts {flight / times.max():.2g} of the longest retardation time, and up to "
        f"{100 * left:.2g} % of an imprint is left at the next touch, which is taken to be on a fresh surface"
    ]
