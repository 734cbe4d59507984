"""A body that falls, and bounces until it comes to rest."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from enum import StrEnum
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from restitution.checks import nonnegative, positive
from restitution.impact.collision import Body, collision
from restitution.impact.problem import STANDARD_GRAVITY, Impact
from restitution.impact.result import dataset
from restitution.impact.solve import solve
from restitution.impact.status import Status
from restitution.material.prony import PronySeries
from restitution.pictures import draw
from restitution.quantities import INPUTS, LENGTH, NUMBER, OUTPUTS, TIME, Quantity
from restitution.validity import COLUMNS, Numbers, Validity, numbers, report, together

if TYPE_CHECKING:
    import xarray
    from matplotlib.figure import Figure

Array = NDArray[np.float64]

# What may be left of a long creep when the body comes back before a warning is due.
_UNRECOVERED = 0.01


class Ending(StrEnum):
    """Why a series of bounces ended."""

    CAPTURED = "captured"
    SUNK = "sunk"
    BELOW_SURFACE = "below surface"
    LOW = "low"
    MAX_BOUNCES = "max bounces"

    @property
    def message(self) -> str:
        """What that means."""
        return _MEANING[self]


_MEANING = {
    Ending.CAPTURED: "the weight holds the body in contact",
    Ending.SUNK: "the material is a liquid and the body sinks in",
    Ending.BELOW_SURFACE: "the body does not rise above the undeformed surface",
    Ending.LOW: "the next rise would be lower than min_height",
    Ending.MAX_BOUNCES: "as many bounces as were asked for; the body would bounce on",
}

_COLUMNS = {
    "touch_time": Quantity("touch_time", TIME, "time of touch since release", "$t$"),
    "velocity": INPUTS["velocity"],
    "restitution_coefficient": OUTPUTS["restitution_coefficient"],
    "rebound_velocity": OUTPUTS["rebound_velocity"],
    "contact_time": OUTPUTS["contact_time"],
    "residual_indentation_depth": OUTPUTS["residual_indentation_depth"],
    "height": Quantity("height", LENGTH, "height reached after the bounce", "$h$"),
}
_NUMBER = Quantity("bounce", NUMBER, "bounce")


@dataclass(frozen=True, eq=False)
class Bounces:
    """Bounces of a falling body, arrays of shape (n_bounce,), in SI.

    Attributes
    ----------
    touch_time : array
        Time [s] from the release to the touch.
    velocity : array
        Impact velocity v0 [m/s].
    restitution_coefficient : array
        e [-]; 0 for a bounce from which the body does not come back.
    rebound_velocity : array
        e v0 [m/s].
    contact_time : array
        Contact time [s]; infinite where the body stays.
    residual_indentation_depth : array
        Depth [m] at separation; of a body that stays, the depth at which its weight rests, infinite in a liquid.
    height : array
        Greatest height [m] of the lowest point over the undeformed surface after the bounce; 0 where the body
        stays, negative where it does not come out of its imprint.
    drop_height : float
        Height [m] of the release.
    gravity : float
        Acceleration of free fall [m/s2].
    ended : Ending
        "captured": the weight holds the body. "sunk": the material is a liquid and swallows it. "below
        surface": it does not rise above the undeformed surface. "low": the next height is below the floor.
        "max bounces": it would bounce on.
    impact : Impact
        The first touch.
    validity : Validity
        Report on the assumptions of the theory: the worst of each over all bounces.
    notes : tuple of str
        Whether the surface has recovered at each touch.
    """

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
        """Where the assumptions are doubtful, that the surface has recovered at each touch among them."""
        return [*self.validity.warnings, *self.notes]

    @property
    def n_bounces(self) -> int:
        """Number of bounces, the last one included from which the body does not come back."""
        return self.touch_time.size

    def to_dataset(self) -> xarray.Dataset:
        """All numbers over `bounce`, with units."""
        attributes = {"drop_height": self.drop_height, "gravity": self.gravity, "ended": str(self.ended)}
        columns = {name: (getattr(self, name), quantity) for name, quantity in _COLUMNS.items()}
        numbers = {"bounce": (np.arange(1, self.n_bounces + 1), _NUMBER)}
        return dataset("bounce", numbers | columns, attributes)

    def plot(self) -> Figure:
        """Figure of the bounces: height over time, restitution over velocity, height of each bounce."""
        return draw("bounces", self)


def drop(
    body: Body, ground: Body, height: Any, *, gravity: Any = STANDARD_GRAVITY, with_weight: bool = True
) -> Impact:
    """Impact of a body that falls from rest onto ground that does not move.

    Parameters
    ----------
    body : Body
        What falls, of finite mass m.
    ground : Body
        What it falls on, of infinite mass: a wall, or a ball that is held.
    height : float or array
        Height h [m] of its lowest point over the undeformed surface, > 0.
    gravity : float or array
        Acceleration of free fall g [m/s2], > 0.
    with_weight : bool
        Whether the weight m g acts during contact too.

    Returns
    -------
    Impact
        With the velocity sqrt(2 g h).

    Raises
    ------
    ValueError
        If a number is out of range, the body is immovable or the ground is not.

    Notes
    -----
    Without resistance of the air.

    Examples
    --------
    >>> from restitution.material.classical import standard_solid
    >>> rubber = standard_solid(1e6, 1e7, 1e3, poisson_ratio=0.45, density=1200.0)
    >>> impact = drop(Body(rubber, radius=0.01), Body(None), height=0.5, gravity=9.81)
    >>> print(round(impact.velocity, 6), round(impact.external_force, 6))
    3.132092 0.04931
    """
    fall = np.asarray(positive("height", height, "m"))
    acceleration = np.asarray(positive("gravity", gravity, "m/s2"))
    if isinstance(body, Body) and not np.all(np.isfinite(np.asarray(body.mass, dtype=np.float64))):
        raise ValueError("body: has an infinite mass; a body that falls needs a finite one")
    if isinstance(ground, Body) and np.any(np.isfinite(np.asarray(ground.mass, dtype=np.float64))):
        raise ValueError(f"ground: has a mass of {ground.mass} kg; ground that does not move has an infinite one")
    impact = collision(body, ground, np.sqrt(2.0 * acceleration * fall))
    return replace(impact, external_force=impact.mass * acceleration) if with_weight else impact


def bounces(
    impact: Impact,
    *,
    height: float | None = None,
    gravity: float = STANDARD_GRAVITY,
    with_weight: bool = True,
    max_bounces: int = 1000,
    min_height: float | None = None,
    rtol: float = 1e-9,
) -> Bounces:
    """Bounces of a body under gravity, until it rests.

    Parameters
    ----------
    impact : Impact
        A single impact of the body on ground that does not move, such as `drop` makes. Its external force is replaced
        by the weight or by zero.
    height : float, optional
        Height [m] from which it is released, > 0; left out, the one that gives the velocity of `impact`.
    gravity : float
        Acceleration of free fall g [m/s2], > 0.
    with_weight : bool
        Whether the weight m g acts during contact too.
    max_bounces : int
        Number of bounces after which to stop, >= 1.
    min_height : float, optional
        Floor [m], >= 0: a body that would rise less high ends the series; a millionth of the first height
        where left out.
    rtol : float
        See `solve`.

    Returns
    -------
    Bounces
        A row for each touch.

    Raises
    ------
    ValueError
        If a number is out of its range, or `impact` is an array of them.
    SolverError
        If the solve of a bounce fails.

    Notes
    -----
    Each touch meets a fresh surface: what the last one left has recovered during the flight. The flights are
    free, from the depth at separation to the undeformed surface, without resistance of the air.

    Examples
    --------
    >>> import restitution as rs
    >>> rubber = rs.standard_solid(1e6, 1e6, 1e2, poisson_ratio=0.45, density=1200.0)
    >>> impact = rs.drop(rs.Body(rubber, radius=0.01), rs.Body(None), height=0.5)
    >>> found = rs.bounces(impact)
    >>> print(found.ended, found.n_bounces, found.height[:3].round(4))
    captured 29 [0.3141 0.2002 0.1293]
    """
    if not isinstance(impact, Impact):
        raise TypeError(f"impact = {impact!r}: must be an Impact")
    if impact.shape:
        raise ValueError(f"impact has shape {impact.shape}: must be a single one")
    if isinstance(max_bounces, bool) or not hasattr(max_bounces, "__index__"):
        raise TypeError(f"max_bounces = {max_bounces!r}: must be an integer")
    if max_bounces < 1:
        raise ValueError(f"max_bounces = {max_bounces}: must be >= 1")
    g = _number("gravity", positive("gravity", gravity, "m/s2"))
    if height is None:
        velocity = float(impact.velocity)
        start = velocity**2 / (2.0 * g)
    else:
        start = _number("height", positive("height", height, "m"))
        velocity = math.sqrt(2.0 * g * start)
    floor = 1e-6 * start if min_height is None else _number("min_height", nonnegative("min_height", min_height, "m"))
    first = replace(impact, velocity=velocity, external_force=float(impact.mass) * g if with_weight else 0.0)

    rows: list[tuple[float, ...]] = []
    flights: list[float] = []
    reports: list[Numbers] = []
    time = velocity / g
    while True:
        result = solve(replace(first, velocity=velocity), rtol=rtol)
        columns = {name: getattr(result, name) for name in COLUMNS}
        reports.append(numbers(impact.contact, **columns, velocity=velocity, mass=impact.mass))
        away, depth = float(result.rebound_velocity), float(result.residual_indentation_depth)
        stays = result.status is not Status.SEPARATED
        rise = 0.0 if stays else away**2 / (2.0 * g) - depth
        rows.append(
            (
                time,
                velocity,
                float(result.restitution_coefficient),
                away,
                float(result.contact_time),
                depth,
                rise,
            )
        )
        ending = _ending(result.status, rise, floor, len(rows) == max_bounces)
        if ending is not None:
            break
        velocity = math.sqrt(2.0 * g * rise)
        flights.append((away + velocity) / g)
        time += float(result.contact_time) + flights[-1]
    notes = tuple(_recovery(impact.reduced_modulus, min(flights, default=math.inf)))
    worst = report(together(reports))
    return Bounces(
        *np.array(rows).T,
        drop_height=start,
        gravity=g,
        ended=ending,
        impact=first,
        validity=worst,
        notes=notes,
    )


def _ending(status: Any, rise: float, floor: float, last: bool) -> Ending | None:
    if status == Status.CAPTURED:
        return Ending.CAPTURED
    if status == Status.SINKS_IN:
        return Ending.SUNK
    if rise <= 0.0:
        return Ending.BELOW_SURFACE
    if rise < floor:
        return Ending.LOW
    return Ending.MAX_BOUNCES if last else None


def _recovery(series: PronySeries, flight: float) -> list[str]:
    """Warnings about a surface that has not recovered after the shortest flight [s]."""
    if math.isinf(flight) or series.is_elastic:
        return []
    if series.is_liquid:
        return ["recovery: the surface of a liquid keeps an imprint, but each bounce is taken to meet a fresh one"]
    _, _, compliances, times = series.retardation
    left = float(compliances @ np.exp(-flight / times)) * series.equilibrium_modulus
    if left <= _UNRECOVERED:
        return []
    return [
        f"recovery: the shortest flight lasts {flight / times.max():.2g} of the longest retardation time, "
        f"and up to {100 * left:.2g} % of an imprint is left at the next touch, which is taken to meet a "
        "fresh surface"
    ]


def _number(name: str, value: Any) -> float:
    if np.ndim(value):
        raise ValueError(f"{name} has shape {np.shape(value)}: must be a single number")
    return float(value)
