"""Construction of surrogates over the velocity by Chebyshev series on pieces, halved until the error is small."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.polynomial.chebyshev import chebpts1, chebpts2, chebvander

from restitution import validity
from restitution.checks import Array, function, single, within
from restitution.errors import InputError, InputTypeError
from restitution.impact.adhesion import sticking_velocity
from restitution.impact.adhesive import LEAST_RTOL
from restitution.impact.batch import solve_columns
from restitution.impact.problem import Impact
from restitution.impact.solution import Progress
from restitution.impact.status import SolverError, Status
from restitution.impact.window import compared, require_known, require_separation
from restitution.quantities import VELOCITY
from restitution.result import plain
from restitution.surrogates.velocity import DEEPEST, NEAR, OUTPUTS, Pieces, Surrogate, velocity_range
from restitution.variation import vary

Piece = tuple[int, int]

DEGREE = 12
MOST = 512
"""Degree of the series, and the most pieces."""

# Below this e its error is absolute, as for the solver.
_SMALL = 1e-3
# The solves are more accurate than `rtol` by this factor, down to the smallest tolerance.
_FINER = 1e-4
_FINEST = 1e-12
# With adhesion: the smallest tolerance, how much more accurate the solves are, the tolerance of the sticking velocity,
# and the e below which errors are those of e^2.
_LEAST_ADHESIVE, _FINER_ADHESIVE, _STICKING_RTOL, _SLOW = 1e-4, 1e-2, 1e-4, 0.1
# The tolerance of a solve is that of e. The error of the largest force has narrow peaks of up to 14 tolerances over
# the velocity, which few points would find (validation/surrogate_error.md).
_SOLVER_SHARE = 20.0
# Velocities this far apart share the table of a profile.
_TABLE_RATIO = 8.0

# Random points in each piece for the measurement of the error, and a factor for the error between them.
_FRESH = 16
_BETWEEN_POINTS = 2.0
# The ends are nodes, so that neighbouring pieces join. The error is largest half-way between the nodes.
_NODES, _BETWEEN = chebpts2(DEGREE + 1), chebpts1(DEGREE)
_TO_COEFFICIENTS = np.linalg.inv(chebvander(_NODES, DEGREE))


def surrogate(
    impact: Impact,
    velocity: tuple[float, float] = (1e-3, 10.0),
    rtol: float = 1e-6,
    *,
    extrapolate: bool = False,
    workers: int | None = None,
    progress: Progress | None = None,
) -> Surrogate:
    """Return the restitution coefficient, contact time and peak force over the velocity, with a stated error.

    Parameters
    ----------
    impact : Impact
        A single impact; its own velocity does not matter.
    velocity : tuple of float
        Lowest and highest impact velocity v0 [m/s], > 0.
    rtol : float
        Largest error, relative to max(e, 1e-3) for e and relative for the others; from 1e-10 to 1e-2. With adhesion at
        least 1e-4, see `Surrogate`.
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
        that of the solves.

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
    tolerance = single("rtol", within("rtol", rtol, 1e-10, 1e-2))
    adhesive = impact.adhesion is not None
    if adhesive:
        tolerance = max(tolerance, _LEAST_ADHESIVE)
    if progress is not None:
        function("progress", progress, "must be callable with (impacts done, all impacts)", 2)
    impact = vary(impact, {"velocity": 1.0})
    if impact.shape:
        raise InputError("impact", rule=f"must be a single impact, but has shape {impact.shape} beside its velocity")
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
            reports.append(validity.report(compared(impacts, columns)))
        return np.log([columns[name] for name in OUTPUTS])

    try:
        deviation = _deviation_of_adhesive if adhesive else _deviation
        first, last = np.log([NEAR * sticking if sticking else low, high - sticking]).tolist()
        pieces, error = build_pieces(sample, deviation, first, last, tolerance - share, progress)
    except NotMet as failure:
        name = list(OUTPUTS)[failure.function]
        where = f"surrogate: {name} at velocity = {sticking + np.exp(failure.place):.6g} m/s"
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


class NotMet(Exception):
    """Error of 512 pieces, or of a piece halved twelve times, above the tolerance: function, place and error."""

    def __init__(self, function: int, place: float, error: float) -> None:
        super().__init__(f"error {error:.2g} of function {function} at {place:g}")
        self.function, self.place, self.error = function, place, error


def build_pieces(
    sample: Callable[[Array], Array],
    deviation: Callable[[Array, Array], Array],
    low: float,
    high: float,
    tolerance: float,
    report: Callable[[int, int], None] | None = None,
) -> tuple[Pieces, Array]:
    """Interpolate functions on pieces of an interval, halved until the error is at most the tolerance.

    `sample` returns values, shape (n_function, n), at n points, and `deviation` the error of each from approximate and
    exact values. The second result is twice the largest error of each function at points that are no nodes.
    """
    rng = np.random.default_rng(20)
    # Pieces as (level, place); they begin at the share place 2^-level of the interval.
    open_: list[Piece] = [(0, 0)]
    accurate: dict[Piece, tuple[Array, Array]] = {}
    while open_:
        following: list[Piece] = []
        levels, places = np.array(open_).T
        width = (high - low) * 0.5**levels
        left = low + width * places
        fresh = rng.uniform(-1.0, 1.0, (len(open_), _FRESH))
        fixed = np.broadcast_to(np.concatenate([_NODES, _BETWEEN]), (len(open_), 2 * DEGREE + 1))
        local = np.hstack([fixed, fresh])
        # Rounding must not move a point out of the interval.
        points = np.clip(left[:, None] + 0.5 * width[:, None] * (local + 1.0), low, high)
        values = sample(points.ravel()).reshape(-1, *points.shape)
        coefficients = values[:, :, : DEGREE + 1] @ _TO_COEFFICIENTS.T
        tested = slice(DEGREE + 1, None)
        approximate = np.einsum("pcd,fpd->fpc", chebvander(local[:, tested], DEGREE), coefficients)
        errors = _BETWEEN_POINTS * np.nan_to_num(deviation(approximate, values[:, :, tested]), nan=np.inf)
        for n, (level, place) in enumerate(open_):
            here = errors[:, n]
            if np.all(here <= tolerance):
                accurate[level, place] = coefficients[:, n], here.max(axis=1)
                continue
            if level == DEEPEST or len(accurate) + len(following) > MOST:
                function, at = np.unravel_index(np.argmax(here), here.shape)
                raise NotMet(int(function), float(points[n, tested][at]), float(here[function, at]))
            following += [(level + 1, 2 * place), (level + 1, 2 * place + 1)]
        open_ = following
        if report is not None:
            report(len(accurate), len(accurate) + len(open_))
    ordered = sorted(accurate, key=lambda piece: piece[1] * 0.5 ** piece[0])
    lefts = [low + (high - low) * place * 0.5**level for level, place in ordered]
    series, error = zip(*(accurate[piece] for piece in ordered), strict=True)
    return Pieces(np.array([*lefts, high]), np.stack(series, axis=1)), np.max(error, axis=0)
