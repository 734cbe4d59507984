"""Windows of time: fractional materials that hold over a contact, and refusal of contacts beyond what is known."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from restitution import validity
from restitution.checks import Array, function, single_nonnegative, truth
from restitution.errors import ABSENT, InputError, InputTypeError
from restitution.impact.batch import solve_columns
from restitution.impact.problem import Impact
from restitution.impact.status import SolverError, Status
from restitution.material.fractional import Window
from restitution.units import VELOCITY
from restitution.validity import Check, Numbers, Validity

WAY_OUT = "--extrapolate (in Python extrapolate=True) goes beyond"

# Times need few digits.
_RTOL = 1e-6
# Decades around the velocities in which admissible velocities are searched, points of a search, and rounds of it: the
# last step is then 10^(24/48/16^3), a hundredth of a per cent.
_DECADES, _POINTS, _ROUNDS = 12, 49, 3
_SLOWEST, _FASTEST = 1e-9, 1e5  # m/s


def require_known(impact: Impact, velocity: ArrayLike | None = None, *, extrapolate: bool = False) -> None:
    """Raise if contacts last longer, or begin faster, than the times for which the materials are known.

    The contacts are those of an impact, or of all its bodies at other velocities [m/s].
    """
    if truth("extrapolate", extrapolate) or impact.contact.window is None:
        return
    velocities = np.unique(np.asarray(impact.velocity if velocity is None else velocity, dtype=np.float64))
    check = validity_of(impact if velocity is None else _at(impact, velocities))["window"]
    if not check.exceeded:
        return
    admissible = admissible_velocities(impact, velocities)
    rule = (
        "must be another, but no velocity is admissible"
        if admissible is None
        else f"must be {_range(*admissible)} m/s"
    )
    ends = [float(f"{end:.6g}") for end in (velocities[0], velocities[-1])]
    raise _error(check, "velocity", ends if velocities.size > 1 else ends[0], f"{rule}; ", VELOCITY.unit)


def require_separation(statuses: Array, velocity: Array, span: tuple[float, float]) -> None:
    """Raise if at one of the velocities [m/s] of a range a solve failed, or the body does not separate."""
    bad = np.flatnonzero(statuses != Status.SEPARATED)
    if not bad.size:
        return
    failed = bad[statuses[bad] >= Status.TOO_MANY_STEPS]
    first = (failed if failed.size else bad)[0]
    status = Status(int(statuses[first]))
    if status.failed:
        raise SolverError(status, f"at velocity = {velocity[first]:.6g} m/s")
    good = velocity[statuses == Status.SEPARATED]
    advice = f"; of those sampled, it separates from {good.min():.3g} to {good.max():.3g} m/s" if good.size else ""
    rule = f"must be a range in which the body separates; at {velocity[first]:.6g} m/s: {status.name}: "
    raise InputError("velocity", list(span), f"{rule}{status.message}{advice}", VELOCITY.unit)


def validity_of(impact: Impact) -> Validity:
    """Report on the worst of the contacts of an impact, from a solution of few digits."""
    return validity.report(_numbers(impact))


def require_known_times(check: Check, *, extrapolate: bool = False) -> None:
    """Raise if the check of a window is exceeded, where a velocity is no way out."""
    if check.exceeded and not extrapolate:
        raise _error(check, "window", ABSENT, "")


def _error(check: Check, field: str, value: Any, rule: str, unit: str = "") -> InputError:
    return InputError(field, value, f"{rule}{check.message.removeprefix('window: ')}; {WAY_OUT}", unit)


def admissible_velocities(impact: Impact, near: ArrayLike) -> tuple[float, float] | None:
    """Lowest and highest velocity [m/s] whose contacts lie within the window of the materials, nearest to some.

    An end is 0 or infinite where there is no limit within twelve decades; None if there is no such velocity.
    """
    ends = np.log([np.min(near), np.max(near)])
    reach = _DECADES * math.log(10.0)
    slowest, fastest = min(ends[0], math.log(_SLOWEST)), max(ends[1], math.log(_FASTEST))
    speeds = np.linspace(max(ends[0] - reach, slowest), min(ends[1] + reach, fastest), _POINTS)
    # The window may be narrower than the grid: the least excess is refined first.
    ratio = _ratios(impact, speeds)
    for _ in range(_ROUNDS):
        if np.any(ratio <= 1.0) or not np.any(np.isfinite(ratio)):
            break
        best = int(np.nanargmin(ratio))
        speeds = np.linspace(speeds[max(best - 1, 0)], speeds[min(best + 1, speeds.size - 1)], _POINTS)
        ratio = _ratios(impact, speeds)
    inside = np.less_equal(ratio, 1.0)
    good = np.flatnonzero(inside)
    if not good.size:
        return None
    start = good[np.argmin(np.abs(speeds[good] - ends.mean()))]
    bad = np.flatnonzero(~inside)
    below, above = bad[bad < start], bad[bad > start]
    low = _edge(impact, speeds[below[-1] + 1], speeds[below[-1]]) if below.size else 0.0
    high = _edge(impact, speeds[above[0] - 1], speeds[above[0]]) if above.size else math.inf
    return low, high


def _edge(impact: Impact, good: float, bad: float) -> float:
    """Return the last admissible velocity [m/s] between logarithms of an admissible one and of one that is not."""
    for _ in range(_ROUNDS):
        between = np.linspace(good, bad, 17)
        outside = np.flatnonzero(~np.less_equal(_ratios(impact, between), 1.0))
        first = int(outside[0]) if outside.size else 16
        if first == 0:
            break
        good, bad = float(between[first - 1]), float(between[first])
    return math.exp(good)


def _ratios(impact: Impact, log_velocity: Array) -> Array:
    """Return the ratio of the window for each velocity, the worst of all impacts; NaN where one is not solved."""
    return _numbers(_at(impact, np.exp(log_velocity))).window_ratio.reshape(log_velocity.size, -1).max(axis=1)


def _at(impact: Impact, velocity: Array) -> Impact:
    """Return all bodies of an impact at each of some velocities [m/s]."""
    others = replace(impact, velocity=1.0).shape
    return replace(impact, velocity=velocity.reshape(-1, *(1,) * len(others)))


def compared(impact: Impact, outputs: Mapping[str, Any]) -> Numbers:
    """Return the numbers of the report for the contacts of an impact that were solved with these outputs."""
    columns = {name: outputs[name].reshape(impact.shape) for name in validity.COLUMNS}
    columns |= {name: getattr(impact, name) for name in ("velocity", "mass", "impedance")}
    if impact.adhesion is not None:
        from restitution.impact.adhesive import attraction_numbers

        columns |= attraction_numbers(impact, {"zone_width": outputs["zone_width"].reshape(impact.shape)})
    return validity.numbers(impact.contact, **columns)


def _numbers(impact: Impact) -> Numbers:
    """Return the numbers of the report for the contacts of an impact, from a solution of few digits."""
    return compared(impact, solve_columns(impact, _RTOL))


def _range(low: float, high: float) -> str:
    """Return a range in words, with ends of three digits within it."""
    bottom, top = _rounded(low, up=True), _rounded(high, up=False)
    if low and high < math.inf:
        return f"in [{bottom:g}, {top:g}]"
    return f">= {bottom:g}" if low else f"<= {top:g}"


def _rounded(value: float, *, up: bool) -> float:
    """Return a number with three digits that is not below another one, or not above it."""
    if value in (0.0, math.inf):
        return value
    step = 10.0 ** (math.floor(math.log10(value)) - 2)
    return (math.ceil if up else math.floor)(value / step * (1.0 + (-1e-9 if up else 1e-9))) * step


# Impacts of fractional materials, which hold within a window of time.

# Window of the first solution, which gives the contact time only: from a picosecond to about four months.
_WIDE = Window(1e-12, 1e7, 1e-2)
# Largest number of windows; a second one has always been enough.
_MOST = 5
# Start of a window over the contact time: faster processes act as springs or dashpots. A window may be used for
# contacts as short as the second share of the contact for which it was made.
_SHORTEST, _MARGIN = 1e-6, 1e-2


def window_around(contact_time: ArrayLike, longest: float = 0.0) -> Window:
    """Window of time of impacts: from a millionth of the contact time [s] to twice that time, or to the longest.

    Examples
    --------
    >>> window_around([1e-3, 5e-3])
    Window(low=1e-09, high=0.01, rtol=0.0)
    """
    times = np.atleast_1d(np.asarray(contact_time, dtype=np.float64))
    finite = times[np.isfinite(times)]
    if not finite.size:
        # A captured body has no contact time.
        return _WIDE._replace(rtol=0.0)
    high = 2.0 * float(finite.max()) if finite.size == times.size else _WIDE.high
    return Window(_SHORTEST * float(finite.min()), max(high, longest))


def for_contact(build: Callable[[Window], Impact], *, longest: float = 0.0) -> Impact:
    """Return the impact whose fractional materials hold over its own contact.

    Parameters
    ----------
    build : callable
        Takes a window of time and returns the impact, single or an array, of materials that hold within the window,
        `FractionalMaterial.within(window)`.
    longest : float
        A time [s] that the window must also contain, such as the time between two bounces.

    Returns
    -------
    Impact
        Its materials have the `window`, and the number of terms and the error in their `assumptions`.

    Raises
    ------
    InputTypeError
        If `build` does not return an impact.

    Notes
    -----
    A first solution, with materials accurate to one per cent at all times, gives the contact time. The window then
    reaches from a millionth of this time to twice this time; faster and slower processes are kept by their moments.

    Examples
    --------
    >>> import restitution as rs
    >>> gel = rs.FractionalMaterial(rs.springpot(1e4, 0.2), bulk=2e9)
    >>> impact = rs.for_contact(
    ...     lambda window: rs.Impact(gel.within(window), rs.Parabola(0.01), mass=0.005, velocity=1.0)
    ... )
    >>> result = rs.solve(impact)
    >>> low, high = result.impact.material.window
    >>> print(low < 1e-5 * result.contact_time, high > result.contact_time)
    True True
    >>> print(result.impact.material.assumptions)
    34 Prony terms stand for the fractional model, relative error ...e-07
    """
    longest = single_nonnegative("longest", longest, "s")
    function("build", build, "must be a function of a window that returns an Impact", 1)
    impact, touches = _solved(build, _WIDE)
    for _ in range(_MOST):
        window = window_around(touches, longest)
        impact, touches = _solved(build, window)
        needed = window_around(touches)
        if window.low <= needed.low / _MARGIN and window.high >= 0.5 * needed.high:
            break
    return impact


def _solved(build: Callable[[Window], Impact], window: Window) -> tuple[Impact, Array]:
    """Return the impact of materials that hold within a window, and its contact times [s]."""
    impact: Any = build(window)
    if not isinstance(impact, Impact):
        raise InputTypeError("build", impact, "must return an Impact")
    return impact, solve_columns(impact, 1e-6)["contact_time"]
