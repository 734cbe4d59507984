"""Construction of surrogates of impacts over their velocity."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np

from restitution import validity
from restitution.checks import Array, function, single, within
from restitution.errors import InputError, InputTypeError
from restitution.impact.adhesion import sticking_velocity
from restitution.impact.adhesive import LEAST_RTOL
from restitution.impact.batch import solve_columns
from restitution.impact.oblique import sliding_numbers
from restitution.impact.problem import Impact
from restitution.impact.solution import Progress
from restitution.impact.status import SolverError, Status
from restitution.impact.window import compared, require_known, require_separation
from restitution.quantities import VELOCITY
from restitution.result import plain
from restitution.surrogates.boxes import NotMet, build_pieces
from restitution.surrogates.velocity import NEAR, OUTPUTS, Surrogate, velocity_range
from restitution.variation import vary

# Tolerance by default; the smallest one, with friction that of e_t, and with adhesion; that of e over that of e_t.
_RTOL, _LEAST, _LEAST_SLIDING, _LEAST_ADHESIVE, _NORMAL_SHARE = 1e-6, 1e-10, 1e-5, 1e-4, 0.1
# Below this e its error is absolute, as for the solver.
_SMALL = 1e-3
# The solves are more accurate than `rtol` by this factor, down to the smallest tolerance.
_FINER = 1e-4
_FINEST = 1e-12
# With adhesion: how much more accurate the solves are, the tolerance of the sticking velocity, and the e below which
# errors are those of e^2.
_FINER_ADHESIVE, _STICKING_RTOL, _SLOW = 1e-2, 1e-4, 0.1
# The tolerance of a solve is that of e. The error of the largest force has narrow peaks of up to 14 tolerances over
# the velocity, which few points would find (validation/surrogate_error.md).
_SOLVER_SHARE = 20.0
# Velocities this far apart share the table of a profile.
_TABLE_RATIO = 8.0


def surrogate(
    impact: Impact,
    velocity: tuple[float, float] = (1e-3, 10.0),
    rtol: float | None = None,
    *,
    extrapolate: bool = False,
    workers: int | None = None,
    progress: Progress | None = None,
) -> Surrogate:
    """Return the restitution coefficient, contact time and peak force over the velocity, with a stated error.

    With friction also e_t over the normal and the tangential velocity and the coefficient of friction.

    Parameters
    ----------
    impact : Impact
        A single impact; its own velocity does not matter. Its friction and tangential velocity are defaults.
    velocity : tuple of float
        Lowest and highest impact velocity v0 [m/s], > 0.
    rtol : float, optional
        Largest error, relative to max(e, 1e-3) for e and relative for the others; from 1e-10 to 1e-2, and 1e-6 by
        default. With adhesion it is from 1e-4 on, which is the default, see `Surrogate`. With friction it is that of
        e_t, absolute, from 1e-5 on, which is the default, and that of e a tenth of it, see `ObliqueSurrogate`.
    extrapolate : bool
        Whether the contacts may lie beyond the times for which the material is known, with a warning in the result.
    workers : int, optional
        Number of threads, by default that of the cores. The result does not depend on it.
    progress : callable, optional
        Called with (pieces within the tolerance, all pieces).

    Returns
    -------
    Surrogate
        Call it with velocities. Its `.error` is twice the error at velocities that were not used to build it, plus
        that of the solves. With friction an `ObliqueSurrogate`.

    Raises
    ------
    InputError
        If a number is out of range, the contacts lie outside the window of the material, or the body does not separate
        at a velocity of the range.
    SolverError
        If a solve fails, or if 512 pieces, or one of 1/4096 of the range, miss the tolerance. The message has the
        velocity and the error.

    Examples
    --------
    >>> import restitution as rs
    >>> solid = rs.standard_solid(1e6, 1e7, 1e3, poisson_ratio=0.45)
    >>> ball = rs.Impact(solid, rs.Parabola(0.01), mass=0.005, velocity=1.0)
    >>> e = rs.surrogate(ball, velocity=(0.1, 1.0), rtol=1e-6)
    >>> e.error["restitution_coefficient"] < 1e-6
    True
    >>> half = rs.Impact(solid, rs.Parabola(0.01), mass=0.005, velocity=0.5)
    >>> abs(e(0.5) / rs.solve(half).restitution_coefficient - 1.0) < 1e-6
    True
    """
    if not isinstance(impact, Impact):
        raise InputTypeError("impact", impact, "must be an Impact")
    low, high = velocity_range(velocity)
    if progress is not None:
        function("progress", progress, "must be callable with (impacts done, all impacts)", 2)
    impact = vary(impact, {"velocity": 1.0})
    if impact.shape:
        raise InputError("impact", rule=f"must be a single impact, but has shape {impact.shape} beside its velocity")
    slides = impact.friction is not None
    least = _LEAST_SLIDING if slides else _LEAST if impact.adhesion is None else _LEAST_ADHESIVE
    tolerance = max(_RTOL, least) if rtol is None else single("rtol", within("rtol", rtol, _LEAST, 1e-2))
    if tolerance < least:
        raise InputError(
            "rtol", tolerance, f"must be in [{least:g}, 0.01] with {'friction' if slides else 'adhesion'}"
        )
    if not slides:
        return _normal(impact, (low, high), tolerance, extrapolate, workers, progress)
    from restitution.surrogates.sliding import with_friction

    normal = _normal(impact, (low, high), _NORMAL_SHARE * tolerance, extrapolate, workers, progress)
    return replace(with_friction(normal, impact, tolerance, workers, progress), rtol=tolerance)


def _normal(
    impact: Impact, span: tuple[float, float], tolerance: float, extrapolate: bool, workers: int | None,
    progress: Progress | None,
) -> Surrogate:  # fmt: skip
    """Return the surrogate of the normal motion of a single impact."""
    (low, high), adhesive = span, impact.adhesion is not None
    sticking = _sticking(impact, low, high, workers) if adhesive else 0.0
    start = max(low, sticking * (1.0 + NEAR))
    require_known(impact, (start, high), extrapolate=extrapolate)
    accuracy = max(_FINER_ADHESIVE * tolerance, LEAST_RTOL) if adhesive else max(_FINER * tolerance, _FINEST)
    share = _SOLVER_SHARE * accuracy
    reports: list[validity.Validity] = []

    def sample(log_velocity: Array) -> Array:
        speeds = np.clip(sticking + np.exp(log_velocity), start, high)
        impacts = vary(impact, {"velocity": speeds})
        columns = _solved(impacts, speeds, accuracy, workers)
        require_separation(columns["status"], speeds, (start, high))
        if not reports:
            # The first round covers the whole range.
            numbers = compared(impacts, columns)
            if impacts.friction is not None:
                numbers = numbers._replace(**sliding_numbers(impacts, columns))
            reports.append(validity.report(numbers))
        return np.log([columns[name] for name in OUTPUTS])

    try:
        deviation = _deviation_of_adhesive if adhesive else _deviation
        first, last = np.log([NEAR * sticking if sticking else low, high - sticking]).tolist()
        pieces, error = build_pieces(sample, deviation, first, last, tolerance - share, progress)
    except NotMet as failure:
        name = list(OUTPUTS)[failure.function]
        where = f"surrogate: {name} at velocity = {sticking + np.exp(failure.place[0]):.6g} m/s"
        what = f"{where} is off by {failure.error:.2g}, rtol = {tolerance:g}"
        raise SolverError(Status.NOT_ACCURATE, what) from None
    from restitution.sweeps.plan import describe

    problem = plain(describe(impact), _text_of_infinity)
    del problem["velocity"]
    errors = {name: float(largest) + share for name, largest in zip(OUTPUTS, error, strict=True)}
    return Surrogate((low, high), tolerance, errors, reports[0], problem, pieces, sticking)


def _sticking(impact: Impact, low: float, high: float, workers: int | None) -> float:
    """Return the velocity [m/s] up to which bodies stick in a range of velocities, 0 if none does."""
    ends = vary(impact, {"velocity": [low, high]})
    statuses = solve_columns(ends, _STICKING_RTOL, workers=workers)["status"]
    if statuses[0] != Status.CAPTURED:
        return 0.0
    require_separation(statuses[1:], np.array([high]), (low, high))
    threshold = float(sticking_velocity(vary(impact, {"velocity": high}), rtol=_STICKING_RTOL))
    if not low <= threshold < high / (1.0 + 2.0 * NEAR):
        rule = f"must reach further above the sticking velocity, {threshold:.5g} m/s"
        raise InputError("velocity", [low, high], rule, VELOCITY.unit)
    return threshold


def _solved(impacts: Impact, speeds: Array, accuracy: float, workers: int | None) -> dict[str, Array]:
    """Return the outputs of impacts at an array of speeds [m/s]."""
    if impacts.profile.path_exponent is not None or impacts.adhesion is not None:
        return solve_columns(impacts, accuracy, workers=workers)
    # The error of the table of a profile is relative to the deepest impact and could be 1e-7 for a shallow one.
    place = np.floor(np.log(speeds / speeds.min()) / np.log(_TABLE_RATIO))
    columns: dict[str, Array] = {}
    for part in (np.flatnonzero(place == k) for k in np.unique(place)):
        outputs = solve_columns(impacts.take(part), accuracy, workers=workers)
        for name, values in outputs.items():
            columns.setdefault(name, np.empty(speeds.size))[part] = values
    return columns


def _text_of_infinity(value: Any) -> Any:
    """Return the text "inf" for an infinite modulus, a number that JSON does not have."""
    return str(value) if isinstance(value, float) and not np.isfinite(value) else value


def _deviation(approximate: Array, exact: Array) -> Array:
    """Return the error of logarithms of the outputs, as `Surrogate.error` counts it; outputs along the first axis."""
    error = np.abs(np.expm1(approximate - exact))
    e = np.exp(exact[0])
    error[0] *= e / np.maximum(e, _SMALL)
    return error


def _deviation_of_adhesive(approximate: Array, exact: Array) -> Array:
    """Return the error of logarithms of the outputs, as the tolerance of an adhesive impact counts it."""
    e = np.exp(exact[0])
    error = np.abs(np.expm1(approximate - exact))
    error[0] *= e
    return error * np.minimum(1.0, e / _SLOW)
