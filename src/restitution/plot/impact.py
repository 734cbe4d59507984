"""The pages of an impact and of a body that bounces, and the contact pressure over the radius."""

from __future__ import annotations

from dataclasses import replace
from math import inf, isfinite
from typing import TYPE_CHECKING, Any, cast

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from numpy.typing import ArrayLike

from restitution.checks import Array, number
from restitution.errors import InputError
from restitution.plot import history as curves
from restitution.plot import style
from restitution.quantities import BODY, DEFAULT_OUTPUTS, INPUTS, OUTPUTS, RESTITUTION, Quantity
from restitution.units import LENGTH, NUMBER, PRESSURE, TIME, in_words, scaled_unit

if TYPE_CHECKING:
    from restitution.impact.bounces import Bounces, ObliqueBounces
    from restitution.impact.result import ImpactResult


_POINTS = 241
_FLIGHT_POINTS = 40
# Pressures are unbounded at the edge of a flat face and under the tip of a cone. Closer than this they do not set the
# scale.
_RIM = 0.03
# If the edge carries a load, the pressure beyond this share of the radius is infinite, or zero by rounding.
_LAST = 1.0 - 1e-6
# An abscissa that spans so much is logarithmic.
_DECADE = 10.0
_RADIUS, _PRESSURE = Quantity("r", LENGTH, "radius", "$r$"), Quantity("p", PRESSURE, "pressure", "$p$")
_HEIGHT, _REACHED = Quantity("height", LENGTH, "height"), Quantity("height", LENGTH, "height reached")
_RELEASED = Quantity("time", TIME, "time since the release")
_PLACE = Quantity("place", LENGTH, "place along the surface", "$x$")
_NUMBER = Quantity("number", NUMBER, "bounce (0: the release)")
_COLORS = (style.SKY_BLUE, style.BLUE, style.VERMILION, style.ORANGE, style.GREEN, style.PURPLE, style.BLACK)


def overview(
    result: ImpactResult, times: ArrayLike | None = None, *, title: str = "", figure: Figure | None = None
) -> Figure:
    """Draw one impact on a page: force, loop, depth, contact radius, pressure at some instants, energies.

    Only the exact method has the pressure and the energies over time. A bar shows the final energies of the element
    method. The radius and the pressure are left out where they are not known.

    Parameters
    ----------
    result : ImpactResult
        The result of one impact, not of an array of them.
    times : array_like, optional
        Times [s] at which to show the pressure, at most seven; four by default.
    title : str
        A line above the restitution coefficient and the contact time.
    figure : matplotlib.figure.Figure, optional
        An empty figure to draw into, e.g. `matplotlib.pyplot.figure()`; a new one by default.

    Returns
    -------
    matplotlib.figure.Figure
        A notebook shows it; `figure.savefig(...)` writes it.
    """
    history, exact = result.history, result.method == "exact"
    budget = not exact and isfinite(result.energy.dissipated)
    # The contact area of some geometries is not known.
    profile = result.impact.profile if not isinstance(result.impact, list) else None
    has_pressure = exact and profile is not None and profile.image is not None
    drawn = [curves.force_time, curves.force_indentation, curves.depth_time]
    if np.isfinite(history["contact_radius"].values).any():
        drawn.append(curves.contact_radius_time)
    rows, heights = ["AB", "CD" if len(drawn) == 4 else "CC"], [1.0, 1.0]
    if exact or budget:
        rows, heights = [*rows, "EF" if has_pressure else "EE"], [*heights, 1.0 if exact else 0.62]
    e, duration = float(result.restitution_coefficient), in_words(float(result.contact_time), TIME.unit)
    numbers = rf"$e = {e:.4g}$,  contact time {duration}"
    options: dict[str, Any] = {"height": 0.3 + 2.4 * sum(heights), "heights": heights, "figure": figure}
    title = f"{title}\n{numbers}" if title else numbers
    with style.page(";".join(rows), title=title, **options) as (page, panels):
        for draw, ax in zip(drawn, panels, strict=False):
            draw(ax, history)
        if has_pressure:
            pressure_radius(panels[-2], result, times)
        if exact:
            curves.energy_area(panels[-1], history)
        elif budget:
            curves.energy_bar(panels[-1], result.energy)
    return page


def of_several(result: ImpactResult) -> Figure:
    """Draw e, contact time, depth and force of several impacts over their velocity, or over what varies instead.

    Where more than one number varies the points have no line.
    """
    shape, problem = np.shape(result.status), result.impact
    impacts = problem if isinstance(problem, list) else [problem]
    columns = {name: [np.asarray(getattr(impact, name), dtype=np.float64) for impact in impacts] for name in BODY}
    inputs = {
        name: np.stack(values) if isinstance(problem, list) else np.broadcast_to(values[0], shape).ravel()
        for name, values in columns.items()
    }
    varied = [name for name, values in inputs.items() if np.unique(values).size > 1]
    name = next((name for name in ("velocity", *varied) if name in varied), "")
    x = inputs[name] if name else np.arange(1.0, np.prod(shape) + 1.0)
    alone = dict.fromkeys(BODY, 1.0) | {"external_force": 0.0, "impedance": inf}
    profiles = isinstance(problem, list) or replace(problem, **alone).shape != ()
    order = np.argsort(x, kind="stable")
    across = INPUTS[name] if name else Quantity("", NUMBER, "number of the impact")
    look: dict[str, Any] = style.markers(x.size)
    if profiles or len(varied) > 1:
        look = {"linestyle": "", "marker": "o", "markersize": 3}
    with style.page("AB;CD", height=5.0) as (page, axes):
        for ax, output in zip(axes, DEFAULT_OUTPUTS, strict=True):
            values = np.asarray(getattr(result, output), dtype=np.float64).ravel()[order]
            values = np.where(np.isfinite(values), values, np.nan)
            style.draw(ax, (across, x[order]), (OUTPUTS[output], values), color=style.BLUE, **look)
            if x.min() > 0.0 and x.max() >= _DECADE * x.min():
                ax.set_xscale("log")
        axes[0].set_ylim(0.0, 1.05)
    return page


def instants(result: ImpactResult) -> Array:
    """Return four instants [s]: half the approach, the turning point, a third and two thirds of the rebound."""
    turning, end = float(result.turning_time), float(result.contact_time)
    return np.array([0.5 * turning, turning, (2.0 * turning + end) / 3.0, (turning + 2.0 * end) / 3.0])


def pressure_radius(ax: Axes, result: ImpactResult, times: ArrayLike | None = None) -> Axes:
    """Draw the contact pressure p [Pa] over the radius r [m] at some times; dashed after the turning point.

    The result is that of one impact, solved by the exact method. The times [s], at most seven, lie within the contact;
    `instants` chooses them by default.
    """
    moments = np.atleast_1d(instants(result) if times is None else number("times", times, TIME.unit)).ravel()
    end = float(result.contact_time)
    if not 1 <= moments.size <= len(_COLORS):
        raise InputError("times", moments.size, f"must be 1 to {len(_COLORS)} times, to keep the curves distinct")
    if (outside := moments[~((moments > 0.0) & (moments < end))]).size:
        rule = f"must be within the contact, which lasts {in_words(end, TIME.unit)}"
        raise InputError("times", float(outside[0]), rule, TIME.unit)
    radii = np.asarray(result.sample(moments)["contact_radius"].values)
    # The points are dense close to the edge, where the pressure changes fast.
    share = _LAST * np.sin(np.linspace(0.0, 0.5 * np.pi, _POINTS))
    inner = (share >= _RIM) & (share <= 1.0 - _RIM)
    curves = [np.asarray(result.pressure(share * a, t)) for a, t in zip(radii, moments, strict=True)]
    top = max(float(curve[inner].max()) for curve in curves)
    across, up, clock = style.axis(_RADIUS, radii), style.axis(_PRESSURE, top), scaled_unit(moments, TIME.unit)
    for a, t, curve, color in zip(radii, moments, curves, _COLORS, strict=False):
        ax.plot(
            share * a * across.factor,
            np.where(np.isfinite(curve), curve, np.nan) * up.factor,
            color=color,
            linestyle="--" if t > result.turning_time else "-",
            label=f"{t * clock.factor:.3g} {clock.unit}",
        )
    finite = max(float(curve[np.isfinite(curve)].max()) for curve in curves)
    # Beyond the contact there is room for the legend.
    ax.set(ylim=(0.0, 1.05 * min(finite, 1.1 * top) * up.factor), xlim=(0.0, 1.45 * radii.max() * across.factor))
    ax.legend(title="$t$", loc="upper right")
    return style.labelled(ax, across.label, up.label)


def flight(bounces: Bounces) -> tuple[Array, Array]:
    """Return the times [s] and heights [m] of the lowest point over the undeformed surface, from the release on.

    The height is NaN during contact, so that a line through it has gaps.

    Examples
    --------
    >>> import restitution as rs
    >>> rubber = rs.standard_solid(1e6, 1e6, 1e2, poisson_ratio=0.45, density=1200.0)
    >>> rebounds = rs.bounces(rs.drop(rs.Body(rubber, radius=0.01), rs.Body(None), height=0.5), max_bounces=3)
    >>> time, height = flight(rebounds)
    >>> print(height[0], bool(np.nanmin(height) < 0.0))
    0.5 True
    """
    g = bounces.gravity
    fall = np.linspace(0.0, bounces.touch_time[0], _FLIGHT_POINTS)
    times, heights = [fall], [bounces.drop_height - 0.5 * g * fall**2]
    leaves = bounces.touch_time + bounces.contact_time
    ends = np.append(bounces.touch_time[1:], leaves[-1] + bounces.rebound_velocity[-1] / g)
    columns = leaves, ends, bounces.rebound_velocity, bounces.residual_indentation_depth
    for start, end, speed, depth in zip(*columns, strict=True):
        if not np.isfinite(start):
            break
        since = np.linspace(0.0, end - start, _FLIGHT_POINTS)
        times += [np.array([start]), start + since]
        heights += [np.array([np.nan]), speed * since - 0.5 * g * since**2 - depth]
    return np.concatenate(times), np.concatenate(heights)


def height_time(ax: Axes, bounces: Bounces) -> Axes:
    """Draw the height [m] over time [s]."""
    time, height = flight(bounces)
    style.draw(ax, (_RELEASED, time), (_HEIGHT, height), color=style.BLUE)
    ax.axhline(0.0, color=style.GREY, linewidth=0.8)
    ax.set_xlim(0.0, None)
    return ax


def restitution_velocity(ax: Axes, bounces: Bounces) -> Axes:
    """Draw the restitution coefficient e of each bounce over its impact velocity [m/s]."""
    velocity, e = (INPUTS["velocity"], bounces.velocity), (OUTPUTS[RESTITUTION], bounces.restitution_coefficient)
    # The imprint of earlier bounces may push a slow body off.
    ax.set(xscale="log", ylim=(0.0, max(1.0, 1.05 * float(np.max(bounces.restitution_coefficient)))))
    return style.draw(ax, velocity, e, "o", color=style.VERMILION, markersize=4, clip_on=False)


def bounce_heights(ax: Axes, bounces: Bounces) -> Axes:
    """Draw the height [m] of each bounce that rises out of its imprint."""
    from matplotlib.ticker import MaxNLocator

    heights = np.append(bounces.drop_height, bounces.height)
    (rises,) = np.nonzero(heights > 0.0)
    style.draw(ax, (_NUMBER, rises), (_REACHED, heights[rises]), "o", color=style.GREEN, markersize=4)
    ax.set(yscale="log", xlim=(-0.5, bounces.n_bounces + 0.5))
    ax.xaxis.set_major_locator(MaxNLocator(integer=True, min_n_ticks=1))
    return ax


def bounces_overview(bounces: Bounces) -> Figure:
    """Draw the height over time, the restitution coefficients and the heights of `restitution.bounces`."""
    count = f"{bounces.n_bounces} bounce{'s' * (bounces.n_bounces != 1)}"
    title = f"{count}; {bounces.ended}: {bounces.ended.message}"
    oblique, series = hasattr(bounces, "spin"), cast("Any", bounces)
    drawn = (path, spins, bounce_heights) if oblique else (height_time, restitution_velocity, bounce_heights)
    with style.page("AA;BC", height=5.0, title=title) as (page, panels):
        for draw, ax in zip(drawn, panels, strict=True):
            draw(ax, series)
    return page


def path(ax: Axes, bounces: ObliqueBounces) -> Axes:
    """Draw the height [m] over the place along the surface [m]."""
    time, height = flight(bounces)
    leaves = bounces.touch_time + bounces.contact_time
    flights = np.append(bounces.touch_time[1:] - leaves[:-1], 0.0)
    ends = np.append(bounces.place[1:], bounces.place[-1])
    knots = np.stack([bounces.touch_time, leaves], axis=1).ravel()
    places = np.stack([bounces.place, ends - bounces.rebound_tangential_velocity * flights], axis=1).ravel()
    finite = np.isfinite(knots) & np.isfinite(places)
    knots, places = np.append(0.0, knots[finite]), np.append(0.0, places[finite])
    beyond = np.where(time > knots[-1], (time - knots[-1]) * bounces.rebound_tangential_velocity[-1], 0.0)
    style.draw(ax, (_PLACE, np.interp(time, knots, places) + beyond), (_HEIGHT, height), color=style.BLUE)
    ax.axhline(0.0, color=style.GREY, linewidth=0.8)
    return ax


def spins(ax: Axes, bounces: ObliqueBounces) -> Axes:
    """Draw the spin [rad/s] after the release and each bounce."""
    turning = np.append(bounces.spin[0], bounces.rebound_spin)
    style.draw(ax, (_NUMBER, np.arange(turning.size)), (INPUTS["spin"], turning), "o", color=style.VERMILION)
    ax.axhline(0.0, color=style.GREY, linewidth=0.8)
    return ax
