"""The coefficient of restitution over velocity, with measured points on the computed curve."""

from __future__ import annotations

import warnings
from dataclasses import replace
from typing import TYPE_CHECKING, Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from numpy.typing import ArrayLike

from restitution.checks import Array, instance
from restitution.errors import InputError, InputTypeError, RestitutionWarning
from restitution.impact.problem import Impact
from restitution.impact.solve import solve
from restitution.plot import sticking, style
from restitution.quantities import INPUTS, OUTPUTS, RESTITUTION, check

if TYPE_CHECKING:
    from restitution.case.observations import ReboundPoints

_POINTS, _MARGIN, _DECADE = 60, 1.25, 10.0
# Tolerances of the curve: that of `solve`, and one that a picture needs where a solve takes many times as long.
_RTOL, _WITH_ADHESION = 1e-9, 1e-4


def draw_points(ax: Axes, points: ReboundPoints, factor: float = 1.0) -> Axes:
    """Draw measured e over velocity, times a factor, with standard deviations and a legend."""
    speeds, (low, high) = points.velocity * factor, ax.get_xlim()
    ax.errorbar(
        speeds, points.restitution_coefficient, points.deviation, fmt="o", color=style.VERMILION,
        markersize=4, capsize=2, label="measured", zorder=5,
    )  # fmt: skip
    # No point lies outside of the picture, or on its frame.
    ax.set_xlim(min(low, float(speeds.min()) / _MARGIN), max(high, float(speeds.max()) * _MARGIN))
    return style.legend(ax)


def require_points(points: object) -> None:
    """Refuse what is neither measured points nor None."""
    from restitution.case.observations import ReboundPoints

    if not isinstance(points, (ReboundPoints, type(None))):
        raise InputTypeError("points", points, "must be ReboundPoints, as read_points returns them")


def velocities(points: ReboundPoints | None, *others: float) -> tuple[float, float]:
    """Return the lowest and highest velocity [m/s] of a picture of points and of further velocities."""
    values = [*others, *(() if points is None else points.velocity.tolist())]
    return min(values) / _MARGIN, max(values) * _MARGIN


def plot_restitution(
    impact: Impact, points: ReboundPoints | None = None, *, velocity: ArrayLike | None = None
) -> Figure:
    """Return a figure of e over velocity, with measured points.

    Parameters
    ----------
    impact
        A single impact, whose velocity has a mark on the curve.
    points
        Measured points, as `read_points` returns them.
    velocity
        Velocities of the curve [m/s]; by default those of the points and of the impact, and a quarter beyond.

    Raises
    ------
    InputError
        If there are several impacts, or a velocity is out of range.

    Examples
    --------
    >>> import restitution as rs
    >>> solid = rs.standard_solid(1e6, 1e7, 1e4, poisson_ratio=0.5)
    >>> ball = rs.Impact(solid, rs.Parabola(0.01), mass=0.005, velocity=1.0)
    >>> figure = plot_restitution(ball, velocity=[0.1, 0.3, 1.0])
    >>> figure.axes[0].get_xlabel()
    'impact velocity $v_0$ [m/s]'
    """
    instance("impact", impact, Impact, "must be an Impact")
    require_points(points)
    if impact.shape:
        raise InputError("impact", rule=f"must be one, not an array of shape {impact.shape}")
    speed = float(impact.velocity)
    low, high = velocities(points, speed)
    speeds: Array = np.geomspace(low, high, _POINTS)
    if velocity is not None:
        speeds = np.atleast_1d(np.asarray(check("velocity", velocity)))
        if speeds.ndim != 1 or not speeds.size:
            raise InputError(
                "velocity", rule=f"must be one-dimensional and hold a value, but has shape {speeds.shape}"
            )
    many = solve(replace(impact, velocity=np.append(speeds, speed)), rtol=_WITH_ADHESION if impact.adhesion else _RTOL)
    e = np.asarray(many.restitution_coefficient, dtype=np.float64)
    across: Any = style.axis(INPUTS["velocity"], [float(speeds[-1])])
    with style.page("A", 5.2, 4.0) as (figure, (ax,)):
        places, rows = sticking.broken(speeds * across.factor, e[:-1], logarithmic=True)
        ax.plot(places, rows[0], color=style.BLUE, label="computed")
        sticking.draw_threshold(ax, speeds * across.factor, e[:-1], across.unit)
        ax.plot(speed * across.factor, e[-1], "o", color=style.BLUE, markersize=6, markerfacecolor="white")
        if speeds[-1] >= _DECADE * speeds[0]:
            ax.set_xscale("log")
        if points is not None:
            draw_points(ax, points, across.factor)
        ax.set_ylim(0.0, 1.05)
        style.labelled(ax, across.label, OUTPUTS[RESTITUTION].label(""))
    return figure


def distance(impact: Impact, points: ReboundPoints) -> float:
    """Return the root mean square of the computed minus the measured e [-] at the velocities of points."""
    with warnings.catch_warnings():
        # The curve has the warnings.
        warnings.simplefilter("ignore", RestitutionWarning)
        computed = np.asarray(solve(replace(impact, velocity=points.velocity)).restitution_coefficient)
    return float(np.sqrt(np.mean((computed - points.restitution_coefficient) ** 2)))
