"""Surrogates over the velocity: sampled with the exact method until their error is met."""

from __future__ import annotations

from dataclasses import replace
from typing import Any, cast

import numpy as np
from numpy.typing import NDArray

from restitution import validity
from restitution.checks import within
from restitution.impact.exact import Progress
from restitution.impact.problem import Impact
from restitution.impact.status import SolverError, Status
from restitution.surrogates.pieces import NotMet, build_pieces
from restitution.surrogates.velocity import OUTPUTS, Surrogate, velocity_range

Array = NDArray[np.float64]

# Below this e its error is absolute, as that of the solver is.
_SMALL = 1e-3
# So much better than the interpolants are the solves that make and judge them.
_FINER = 1e-4
_FINEST = 1e-12
# Velocities this far apart share the table of a profile.
_TABLE_RATIO = 8.0


def surrogate(
    impact: Impact,
    velocity: tuple[float, float] = (1e-3, 10.0),
    rtol: float = 1e-6,
    *,
    workers: int | None = None,
    progress: Progress | None = None,
) -> Surrogate:
    """Restitution coefficient, contact time and peak force over the velocity, with a stated error.

    Parameters
    ----------
    impact : Impact
        A single impact; its own velocity does not matter.
    velocity : tuple of float
        Lowest and highest impact velocity v0 [m/s], > 0.
    rtol : float
        Largest error: of e relative to max(e, 1e-3), of the others relative; from 1e-10 to 1e-2.
    workers : int, optional
        Threads; all cores where left out. The result does not depend on it.
    progress : callable, optional
        Called with (pieces that meet the tolerance, all pieces).

    Returns
    -------
    Surrogate
        Call it with velocities; `.error` is what was measured at velocities not used to build it.

    Raises
    ------
    ValueError
        If a number is out of range, or the body does not separate at a velocity of the range.
    SolverError
        If a solve fails, or the tolerance is not met by 512 pieces, or by one of 1/4096 of the range: the message says
        where, and what error is left.

    Examples
    --------
    >>> import restitution as rs
    >>> solid = rs.standard_solid(1e6, 1e7, 1e3, poisson_ratio=0.45)
    >>> ball = rs.Impact(solid, rs.Parabola(0.01), mass=0.005, velocity=1.0)
    >>> e = rs.surrogate(ball, velocity=(0.1, 1.0), rtol=1e-6)
    >>> e.error["restitution_coefficient"] < 1e-6
    True
    >>> abs(e(0.5) / rs.solve(replace(ball, velocity=0.5)).restitution_coefficient - 1.0) < 1e-6
    True
    """
    if not isinstance(impact, Impact):
        raise TypeError(f"impact = {impact!r}: must be an Impact")
    low, high = velocity_range(velocity)
    tolerance = cast("float", within("rtol", rtol, 1e-10, 1e-2))
    shape = replace(impact, velocity=1.0).shape
    if shape:
        raise ValueError(f"impact: has shape {shape} beside its velocity; a surrogate takes a single impact")

    accuracy = max(_FINER * tolerance, _FINEST)
    reports: list[validity.Validity] = []

    def sample(log_velocity: Array) -> Array:
        speeds = np.clip(np.exp(log_velocity), low, high)
        impacts = replace(impact, velocity=speeds)
        columns = _solved(impacts, speeds, accuracy, workers)
        _refuse_what_stays(speeds, columns["status"], (low, high))
        if not reports:
            # The first round covers the whole range.
            found = {name: columns[name] for name in validity.COLUMNS}
            reports.append(validity.validity(impact.contact, **found, velocity=speeds, mass=impact.mass))
        return np.log([columns[name] for name in OUTPUTS])

    try:
        pieces, error = build_pieces(
            sample, _deviation, np.log(low), np.log(high), tolerance - accuracy, progress
        )
    except NotMet as failure:
        name = list(OUTPUTS)[failure.function]
        raise SolverError(
            Status.NOT_ACCURATE,
            f"surrogate: {name} at velocity = {np.exp(failure.place):.6g} m/s is off by {failure.error:.2g}, "
            f"rtol = {tolerance:g}",
        ) from None
    from restitution.sweeps.description import describe

    problem = _plain(describe(replace(impact, velocity=1.0)))
    del problem["velocity"]
    errors = {name: float(one) + accuracy for name, one in zip(OUTPUTS, error, strict=True)}
    return Surrogate((low, high), tolerance, errors, reports[0], problem, pieces)


def _solved(impacts: Impact, speeds: Array, accuracy: float, workers: int | None) -> dict[str, Array]:
    """Solve an impact at an array of speeds."""
    from restitution.impact.batch import Batch

    if impacts.profile.path_exponent is not None:
        return Batch.from_impact(impacts).solve(accuracy, workers=workers)
    # The error of a profile's table is relative to its deepest impact: 1e-7 of a shallow one beside one far deeper.
    place = np.floor(np.log(speeds / speeds.min()) / np.log(_TABLE_RATIO))
    columns: dict[str, Array] = {}
    for part in (np.flatnonzero(place == k) for k in np.unique(place)):
        part_of = Batch.from_impact(replace(impacts, velocity=speeds[part]))
        solved = part_of.solve(accuracy, workers=workers)
        for name, values in solved.items():
            columns.setdefault(name, np.empty(speeds.size))[part] = values
    return columns


def _plain(value: Any) -> Any:
    """Return a description in which an infinite modulus is the text "inf", for JSON has no such number."""
    if isinstance(value, dict):
        return {key: _plain(item) for key, item in value.items()}
    if isinstance(value, list):
        return [_plain(item) for item in value]
    return value if not isinstance(value, float) or np.isfinite(value) else str(value)


def _deviation(approximate: Array, exact: Array) -> Array:
    """Error of logarithms of the outputs, as `Surrogate.error` counts it; outputs along the first axis."""
    error = np.abs(np.expm1(approximate - exact))
    e = np.exp(exact[0])
    error[0] *= e / np.maximum(e, _SMALL)
    return error


def _refuse_what_stays(speeds: Array, statuses: Array, velocity: tuple[float, float]) -> None:
    """Raise where the body does not separate, or a solve failed."""
    bad = np.flatnonzero(statuses != Status.SEPARATED)
    if bad.size == 0:
        return
    failed = bad[statuses[bad] >= Status.TOO_MANY_STEPS]
    first = (failed if failed.size else bad)[0]
    status = Status(int(statuses[first]))
    if status.failed:
        raise SolverError(status, f"at velocity = {speeds[first]:.6g} m/s")
    good = speeds[statuses == Status.SEPARATED]
    advice = (
        f"; of those sampled, it separates from {good.min():.3g} to {good.max():.3g} m/s" if good.size else ""
    )
    raise ValueError(
        f"velocity = {list(velocity)} m/s: must be a range in which the body separates; at {speeds[first]:.6g} m/s: "
        f"{status.name}: {status.message}{advice}"
    )
