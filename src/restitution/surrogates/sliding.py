"""Construction of the tangential half of surrogates of impacts with friction."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace
from functools import partial
from typing import Any

import numpy as np

from restitution.checks import Array
from restitution.impact.oblique import TANGENTIAL_RTOL, Sliders, contact_point
from restitution.impact.problem import Impact
from restitution.impact.solution import Progress
from restitution.impact.status import SolverError, Status
from restitution.impact.tangential import Slider
from restitution.parallel import on_threads
from restitution.surrogates.boxes import NotMet, build_boxes, build_pieces
from restitution.surrogates.oblique import E_T, ObliqueSurrogate, Sliding
from restitution.surrogates.velocity import Surrogate, lookup_table, value

# The solves are more accurate than the tolerance by this factor, down to that of the solver, and count this often in
# the error.
_FINER, _SOLVER_SHARE = 0.1, 2.0
# Tolerance of the slope of full sliding, which is a variable: e_t is nearly level there. Random points beyond it, the
# largest distance from it, and the factor for the error between them.
_SLOPE_RTOL, _BEYOND, _FURTHEST, _BETWEEN = 1e-4, 32, 0.2, 2.0


def with_friction(
    surrogate: Surrogate, impact: Impact, rtol: float, workers: int | None, progress: Progress | None
) -> ObliqueSurrogate:
    """Return a surrogate of the normal half of an impact with the tangential one."""
    accuracy = max(_FINER * rtol, TANGENTIAL_RTOL)
    ends = np.log(surrogate.velocity)
    mobility = 1.0 + 1.0 / float(impact.gyration)
    each = partial(_at_each, impact.normal, workers)
    log_limits = partial(_log_limits, each, mobility)
    try:
        limit, _ = build_pieces(log_limits, _relative, float(ends[0]), float(ends[1]), _SLOPE_RTOL)
    except NotMet as failure:
        raise _missed("the slope of full sliding", failure.place[0], failure.error, _SLOPE_RTOL) from None
    firsts = list[float]()
    each(ends[:1], lambda slider, _: firsts.append(slider.first_slope))
    (start,) = firsts
    low, high = np.array([ends[0], 0.0]), np.array([ends[1], 1.0])
    table = lookup_table(limit, 0, *surrogate.velocity, math.inf)
    # Beyond full sliding the error of e counts; the slope is above the mobility, unless the body turns very easily.
    share = _SOLVER_SHARE * accuracy + mobility / max(mobility, start) * surrogate.error["restitution_coefficient"]

    def slope_of(x: Array, y: Array, *, slips: bool) -> Array:
        if not slips:
            return start * y
        most = np.array([max(value(v, table), start) for v in np.exp(x).clip(*surrogate.velocity)])
        return most - (most - start) * y * y

    def sample(x: Array, y: Array, *, slips: bool) -> Array:
        return _restitutions(each, x, slope_of(x, y, slips=slips), mobility, accuracy)

    parts, errors = [], []
    for slips in (False, True):
        try:
            part, error = build_boxes(partial(sample, slips=slips), low, high, rtol - share, progress)
        except NotMet as failure:
            slope = float(slope_of(*np.array(failure.place)[:, None], slips=slips)[0])
            raise _missed(f"e_t at v_c/(mu v0) = {slope:.6g}", failure.place[0], failure.error, rtol) from None
        parts.append(part)
        errors.append(error)
    sliding = Sliding(mobility, float(impact.external_force) / float(impact.mass), start, limit, *parts)
    result = ObliqueSurrogate(
        surrogate.velocity, surrogate.rtol, surrogate.error, surrogate.validity, surrogate.problem, surrogate.pieces,
        friction=float(np.asarray(impact.friction, dtype=np.float64)), gyration=float(impact.gyration),
        radius=float(contact_point(impact)[1]), sliding=sliding,
    )  # fmt: skip
    beyond = _error_beyond(result, each, accuracy)
    if not beyond + share <= rtol:
        raise _missed("e_t beyond full sliding", ends[0], beyond + share, rtol)
    stated = surrogate.error | {E_T: max(*errors, beyond) + share}
    return replace(result, error=stated)


def _at_each(
    impact: Impact, workers: int | None, log_velocity: Array, work: Callable[[Slider, Any], None], rtol: float = 1e-9
) -> None:
    """Call `work` with the solver at each velocity, and the places that have this velocity."""
    logs, place_of = np.unique(log_velocity, return_inverse=True)

    velocities = np.exp(logs)
    sliders = Sliders(replace(impact, velocity=velocities))

    def run(n: int) -> None:
        status, slider = sliders.solve(n, rtol)
        if slider is None:
            raise SolverError(status, f"at velocity = {velocities[n]:.6g} m/s")
        work(slider, np.flatnonzero(place_of == n))

    # The first impact compiles the kernel.
    run(0)
    if logs.size > 1:
        on_threads(run, range(1, logs.size), workers, lambda: None)


def _log_limits(each: Callable[..., None], mobility: float, log_velocity: Array) -> Array:
    """Return the logarithm of the slope of full sliding, as a row."""
    limits = np.empty((1, log_velocity.size))

    def work(slider: Slider, places: Any) -> None:
        limits[0, places] = math.log(slider.sliding_slope(mobility))

    each(log_velocity, work)
    return limits


def _relative(approximate: Array, exact: Array) -> Array:
    """Return the relative error of numbers by their logarithms."""
    return np.abs(np.expm1(approximate - exact))


def _restitutions(
    each: Callable[..., None], log_velocity: Array, slopes: Array, mobility: float, accuracy: float
) -> Array:
    """Return e_t at velocities and slopes."""
    out = np.empty(slopes.size)

    def work(slider: Slider, places: Any) -> None:
        for n in places.tolist():
            motion = slider.solve(float(slopes[n]), mobility, accuracy)
            if not motion.error <= accuracy:
                where = f"at velocity = {math.exp(log_velocity[n]):.6g} m/s, v_c/(mu v0) = {slopes[n]:.6g}"
                raise SolverError(Status.NOT_ACCURATE, where)
            out[n] = motion.restitution

    each(log_velocity, work)
    return out


def _error_beyond(result: ObliqueSurrogate, each: Callable[..., None], accuracy: float) -> float:
    """Return twice the largest error of e_t at slopes somewhat beyond that of full sliding."""
    rng = np.random.default_rng(23)
    low, high = result.velocity
    log_velocity = rng.uniform(math.log(low), math.log(high), _BEYOND)
    speeds = np.exp(log_velocity).clip(low, high)
    slopes = result.full_sliding(speeds) * (1.0 + rng.uniform(0.0, _FURTHEST, _BEYOND))
    exact = _restitutions(each, log_velocity, slopes, result.sliding.mobility, accuracy)
    approximate = result.tangential_restitution_coefficient(speeds, slopes * speeds, friction=1.0)
    return _BETWEEN * float(np.abs(approximate - exact).max())


def _missed(what: str, log_velocity: float, error: float, rtol: float) -> SolverError:
    """Return the error of a tolerance that is not reached."""
    where = f"surrogate: {what} at velocity = {math.exp(log_velocity):.6g} m/s is off by {error:.2g}, rtol = {rtol:g}"
    return SolverError(Status.NOT_ACCURATE, where)
