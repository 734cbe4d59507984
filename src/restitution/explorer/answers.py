"""The answers of the explorer: numbers and curves of an impact, of bounces and of an indentation."""

from __future__ import annotations

import json
import math
import time
from collections.abc import Callable, Mapping
from contextlib import suppress
from dataclasses import replace
from functools import lru_cache
from pathlib import Path
from typing import Any, cast

import numpy as np
from numpy.typing import NDArray

from restitution import validity
from restitution.case.impact import Case, CaseFile, notes_on
from restitution.case.indentation import IndentationCase, IndentationFile
from restitution.case.section import read_sections
from restitution.errors import InputError
from restitution.explorer import section
from restitution.explorer.inputs import inputs
from restitution.explorer.state import State, case_content, indentation_content
from restitution.impact.batch import Batch
from restitution.impact.bounces import Ending
from restitution.impact.bounces import bounces as series_of_bounces
from restitution.impact.problem import window_around
from restitution.impact.result import ImpactResult
from restitution.impact.scaling import dimensionless_groups
from restitution.impact.solve import solve
from restitution.impact.status import Status
from restitution.indentation.evolution import MOST_ELEMENTS
from restitution.indentation.result import IndentationStatus
from restitution.indentation.solve import indent
from restitution.material.fractional import Window
from restitution.quantities import BUDGET

Array = NDArray[np.float64]
Answer = dict[str, Any]

TIME_LIMIT = 0.1
"""Time [s] that one answer may take; longer curves get fewer points."""

# Tolerance of curves. Single impacts have the default of `solve`.
_RTOL = 1e-6
_POINTS = 121
# Points of a curve over the velocity, and shares of the time for them; times, and least number of them, of a surface.
_SPEEDS, _SHARES = 61, (0.2, 0.7)
_TIMES, _LEAST_ROWS = 25, 4
# Imprint over the largest depth that is not shown.
_SMALL = 1e-4
# Relative error of a fractional material whose curve is drawn.
_FRACTIONAL = 1e-4
# Decades of time on each side of the contact time, and points of a curve of moduli.
_DECADES, _MODULI = 3.0, 61
_MOST_BOUNCES, _LEAST_RISE = 200, 1e-4
_WEIGHT = "the weight presses in each of these contacts; the tab Impact leaves it out, so its e differs"
_MORE = f"a series ends after {_MOST_BOUNCES} bounces or {0.5 * TIME_LIMIT:g} s of work; the body would bounce on"
# Points of all flights of a series, and least number of one.
_FLIGHT_POINTS, _LEAST_POINTS = 400, 17
# Most elements of an indentation times terms of its material; with many terms it has a coarser tolerance.
_ELEMENTS, _MANY_TERMS, _COARSE_RTOL = 12_000, 20, 1e-4

_OUTPUTS = (
    "restitution_coefficient", "contact_time", "max_force", "max_indentation_depth", "max_contact_radius",
    "residual_indentation_depth", "rebound_velocity",
)  # fmt: skip
_CURVE = ("restitution_coefficient", "contact_time", "max_force", "max_indentation_depth")


def _clock(share: float) -> Callable[[], bool]:
    """Return a function that is true once a share of the time of an answer is spent, from now on."""
    end = time.thread_time() + share * TIME_LIMIT
    return lambda: time.thread_time() > end


@lru_cache(maxsize=64)
def _case(text: str) -> Case:
    sections = read_sections(CaseFile, Path(), json.loads(text))
    return Case(Path(), None, sections.build(), {}, sections)


def case_of(state: Mapping[str, Any]) -> Case:
    """Return the case of a state."""
    return _case(json.dumps(case_content(state)))


def plain(values: Any) -> Any:
    """Return numbers as JSON has them; an infinite or unknown one becomes None."""
    if isinstance(values, Mapping):
        return {key: plain(value) for key, value in values.items()}
    if isinstance(values, list | tuple):
        return [plain(value) for value in values]
    if isinstance(values, float | np.floating):
        return float(values) if math.isfinite(values) else None
    return int(values) if isinstance(values, np.integer) else values


@lru_cache(maxsize=16)
def _solved(text: str) -> ImpactResult:
    return solve(_case(text).impact)


def _result(state: Mapping[str, Any]) -> ImpactResult:
    return _solved(json.dumps(case_content(state)))


def impact(state: Mapping[str, Any]) -> Answer:
    """Numbers of an impact, its history, and the moduli of the contact."""
    result = _result(state)
    numbers: State = {name: getattr(result, name) for name in _OUTPUTS}
    separated = result.status == Status.SEPARATED
    numbers |= dict(zip(BUDGET, result.energy, strict=True))
    problem = cast("Any", result.impact)
    material, series = problem.material, problem.reduced_modulus
    numbers |= {name: getattr(material, name) for name in ("poisson_ratio", "instantaneous_poisson_ratio")}
    numbers |= dict.fromkeys(("loss_tangent", "nu", "p2", "p3"))
    with suppress(InputError):  # which any other problem than the paper's causes
        numbers |= dict(zip(("nu", "p2", "p3"), map(float, dimensionless_groups(problem)), strict=True))
    contact_time = float(result.contact_time)
    omega = math.pi / contact_time
    curves: dict[str, Any] = {"history": None, "shape": section.body(result)}
    # A captured body has no contact time; its oscillation has a scale of time.
    scale = contact_time if separated else float(result.max_indentation_depth) / float(result.velocity)
    if separated:
        curves["history"] = cast("Any", result)._columns(n_points=_POINTS)
        numbers["loss_tangent"] = float(series.loss_modulus(omega) / series.storage_modulus(omega))
    if math.isfinite(scale) and scale > 0.0:
        curves |= _moduli(series, material.shear, scale)
    return {
        "numbers": plain(numbers),
        "status": _ending(cast("Status", result.status)),
        "validity": [_row(check) for check in result.validity],
        "notes": [*result.notes, *notes_on(material, None)],
        "curves": curves,
        "marks": plain({"contact_time": contact_time, "angular_frequency": omega if separated else math.nan}),
    }  # fmt: skip


def _ending(status: Status | IndentationStatus) -> dict[str, str]:
    return {"name": status.name, "message": status.message}


def _row(check: validity.Check) -> dict[str, Any]:
    title, _, message = check.message.partition(": ")
    state = "doubtful" if check.exceeded else "ok" if check.value is not None else "unknown"
    numbers = plain({"value": check.value, "limit": check.threshold})
    return {"kind": check.kind, "title": title, "state": state, "message": message, "advice": check.advice} | numbers


def _moduli(series: Any, shear: Any, scale: float) -> dict[str, Any]:
    """Relaxation moduli over time and complex moduli over frequency, about a time [s]."""
    times = scale * np.logspace(-_DECADES, _DECADES, _MODULI)
    omega = math.pi / times[::-1]
    storage, loss = series.storage_modulus(omega), series.loss_modulus(omega)
    relaxation = {
        "time": times, "relaxation_modulus": series.relaxation_modulus(times),
        "shear_modulus": shear.relaxation_modulus(times),
    }  # fmt: skip
    moduli = {"angular_frequency": omega, "storage_modulus": storage, "loss_modulus": loss}
    with np.errstate(divide="ignore", invalid="ignore"):
        return {"relaxation": relaxation, "moduli": moduli | {"loss_tangent": loss / storage}}


def velocity(state: Mapping[str, Any]) -> Answer:
    """Restitution, contact time and peaks over the velocities of the slider."""
    started = time.thread_time()
    slider = inputs()["impact.velocity"].slider
    assert slider is not None
    speeds = np.geomspace(slider.low, slider.high, _SPEEDS)
    problem, every = _wide(state), np.arange(_SPEEDS)
    columns = {name: np.empty(_SPEEDS) for name in (*_CURVE, "doubtful")}
    solved = np.zeros(_SPEEDS, dtype=np.bool_)

    def solve_further(wanted: NDArray[np.bool_]) -> None:
        for name, values in _columns(problem, speeds[wanted & ~solved]).items():
            columns[name][wanted & ~solved] = values
        solved[wanted] = True

    built = time.thread_time()
    solve_further(every % (_SPEEDS - 1) == 0)
    # After both ends as many others as the time suffices for, in two steps, as they may take longer.
    for share in _SHARES:
        now = time.thread_time()
        most = solved.sum() * (1.0 + (started + share * TIME_LIMIT - now) / max(now - built, 1e-6))
        finer = (solved | (every % n == 0) for n in range(1, _SPEEDS))
        wanted = next((places for places in finer if places.sum() <= most), solved)
        if not np.array_equal(wanted, solved):
            solve_further(wanted)
    return {"curves": {"velocity": {name: one[solved] for name, one in ({"velocity": speeds} | columns).items()}}}


def _wide(state: Mapping[str, Any], longest: float = 0.0) -> Any:
    """Impact of a state, with fractional materials that hold for all velocities of the slider."""
    case = case_of(state)
    if not case.sections.needs_window:
        return case.impact
    low, high = cast("Any", case.impact.material.window)
    # The contact time changes by less than this over the slider.
    return case.sections.build(Window(0.1 * low, max(10.0 * high, longest), _FRACTIONAL))


def _columns(problem: Any, speeds: Array) -> dict[str, Array]:
    impacts = replace(problem, velocity=speeds)
    found = Batch.from_impact(impacts).solve(_RTOL, workers=1)
    found = {name: np.array(values, dtype=np.float64) for name, values in found.items()}
    failed = found["status"] >= Status.TOO_MANY_STEPS
    given = {name: found[name] for name in validity.COLUMNS} | {"velocity": speeds, "mass": problem.mass}
    doubtful = np.zeros(speeds.size)
    for values in validity.excess(validity.numbers(problem.contact, **given)).values():
        doubtful = np.maximum(doubtful, np.nan_to_num(values) > 1.0)
    return {name: np.where(failed, np.nan, found[name]) for name in _CURVE} | {"doubtful": doubtful}


def surface(state: Mapping[str, Any]) -> Answer:
    """Surface of the half-space over time, during the contact and after it."""
    late = _clock(0.5)
    result = _result(state)
    found = section.surface(result) if result.status == Status.SEPARATED else None
    if found is None:
        return {"curves": {"surface": None}}
    contact_time, depth = float(result.contact_time), float(result.residual_indentation_depth)
    grid = 2.0 * contact_time * np.linspace(0.0, 1.0, _TIMES)
    radius, displacement = found
    # No imprint that a picture could show is left.
    recovered = depth < _SMALL * float(result.max_indentation_depth)
    rows: dict[int, Array] = {}
    # 0, 16, 8, 24, 4, ...: the rows are spread over all times whenever the time is up.
    for n in sorted(range(_TIMES), key=lambda n: (n & -n) or _TIMES, reverse=True):
        if recovered and grid[n] > contact_time:
            rows[n] = np.zeros(radius.size)
        elif len(rows) < _LEAST_ROWS or not late():
            rows[n] = displacement(float(grid[n]))
    places = sorted(rows)
    return {"curves": {"surface": {"time": grid[places], "radius": radius, "displacement": [rows[n] for n in places]}}}


def bounces(state: Mapping[str, Any]) -> Answer:
    """Bounces until the body rests, and its height over time."""
    late = _clock(0.5)
    state = {key: value for key, value in state.items() if key != "impact.external_force"}
    motion = case_of(state).sections.impact
    problem = _wide(state, 2.0 * motion.impact_velocity / motion.gravity)
    found = series_of_bounces(
        problem, gravity=motion.gravity, max_bounces=_MOST_BOUNCES, stop=late, rtol=_RTOL,
        min_height=_LEAST_RISE * motion.impact_velocity**2 / (2.0 * motion.gravity),
    )  # fmt: skip
    table = found.to_dataset()
    columns = {str(name): table[name].values for name in table.variables}
    numbers = {"n_bounces": found.n_bounces, "drop_height": found.drop_height, "total_time": found.touch_time[-1]}
    message = _MORE if found.ended in (Ending.STOPPED, Ending.MAX_BOUNCES) else found.ended.message
    return {
        "numbers": plain(numbers),
        "status": {"name": str(found.ended), "message": message},
        "warnings": found.warnings,
        "notes": [_WEIGHT],
        "curves": {"bounces": columns, "flight": _flight(found)},
    }


def _flight(found: Any) -> dict[str, Array]:
    """Height of the lowest point over time: parabolas between the touches, which last no time here."""
    count = max(_FLIGHT_POINTS // found.n_bounces, _LEAST_POINTS)
    half, share = 0.5 * found.gravity, np.linspace(0.0, 1.0, count)
    fall, starts = share * found.touch_time[0], (found.touch_time + found.contact_time)[:-1, None]
    flight = share * (found.touch_time[1:, None] - starts)
    depth, speed = found.residual_indentation_depth[:-1, None], found.rebound_velocity[:-1, None]
    heights = np.append(found.drop_height - half * fall**2, -depth + speed * flight - half * flight**2)
    return {"time": np.append(fall, starts + flight), "height": heights}


_INDENTATION = (
    "max_force", "max_indentation_depth", "max_contact_radius", "turning_time", "contact_end_time",
    "residual_indentation_depth", "work",
)  # fmt: skip


def indentation_case(state: Mapping[str, Any]) -> IndentationCase:
    """Return the case of the indentation of a state."""
    sections = read_sections(IndentationFile, Path(), indentation_content(state))
    name, history = sections.indentation.read(Path())
    window = window_around(history.stop - history.start)._replace(rtol=_FRACTIONAL)
    material, profile = sections.material.build(window), cast("Any", sections.profile.build(None))
    return IndentationCase(Path(), None, material, profile, None, name, history, _POINTS, {})


def indentation(state: Mapping[str, Any]) -> Answer:
    """Numbers of an indentation and its history."""
    case = indentation_case(state)
    terms = sum(getattr(one, "n_branches", 0) for one in (case.material.shear, case.material.bulk))
    rtol = _RTOL if terms <= _MANY_TERMS else _COARSE_RTOL
    limit = MOST_ELEMENTS.set(_ELEMENTS // max(terms, 10))
    try:
        result = indent(case.material, case.profile, rtol=rtol, **{case.prescribed: cast("Any", case.history)})
    finally:
        MOST_ELEMENTS.reset(limit)
    names = ("time", "indentation_depth", "force", "contact_radius")
    return {
        "numbers": plain({name: getattr(result, name) for name in _INDENTATION}),
        "status": _ending(result.status),
        "warnings": result.warnings,
        "curves": {"history": {name: result.history[name].values for name in names}},
    }


KINDS: dict[str, Callable[[Mapping[str, Any]], Answer]] = {
    one.__name__: one for one in (impact, velocity, surface, bounces, indentation)
}
"""Answers that follow from the state alone."""
