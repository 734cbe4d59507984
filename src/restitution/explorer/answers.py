"""The answers of the explorer: numbers, curves and sections of impacts, bounces and indentations; the paper."""

from __future__ import annotations

import base64
import json
import math
import time
import warnings
from collections.abc import Callable, Mapping
from contextlib import suppress
from functools import cache, lru_cache
from importlib.resources import as_file, files
from pathlib import Path
from typing import Any, cast

import numpy as np
from numpy.typing import NDArray

import restitution as rs
from restitution import validity
from restitution.case.impact import Case, CaseFile, notes_on
from restitution.case.indentation import IndentationCase, IndentationFile
from restitution.case.oscillation import TappingCase, TappingFile
from restitution.case.section import read_sections
from restitution.checks import Array
from restitution.contact.profiles import Cone, Parabola, Profile
from restitution.errors import InputError, RestitutionWarning
from restitution.explorer.inputs import State, case_content, indentation_content, inputs, tapping_content
from restitution.impact.batch import solve_columns
from restitution.impact.bounces import Ending
from restitution.impact.window import compared, window_around
from restitution.indentation.cantilever import MOST_MODES
from restitution.indentation.solve import MOST_ELEMENTS, indent
from restitution.indentation.tapping import COLUMNS, MODES, TappingStatus, tap
from restitution.material.fractional import Window
from restitution.paper import figures
from restitution.quantities import ADHESION, BUDGET, DEFAULT_OUTPUTS, INDENTATION, Quantity
from restitution.result import nullable, plain
from restitution.surrogates import standard_solid
from restitution.variation import vary

Answer = dict[str, Any]

TIME_LIMIT = 0.1
"""Time [s] that one answer may take; longer curves get fewer points."""

# Tolerance of curves. Single impacts have the default of `solve`.
_RTOL = 1e-6
# Tolerance of e_t, and of impacts with adhesion, which leaves time for the rest of an answer.
_FRONT_RTOL = 1e-4
_POINTS = 121
# Points of a curve over the velocity, and shares of the time for them; times, and least number of them, of a surface.
_SPEEDS, _SHARES, _STICKING_SPEEDS = 61, (0.2, 0.7), 5
_TIMES, _LEAST_ROWS = 25, 4
# Points of the body and of the surface, and flat punches that compose the surface around an ellipse.
_BODY, _SURFACE, _PUNCHES = 61, 25, 200
# Imprint over the largest depth that is not shown.
_SMALL = 1e-4
# Relative error of a fractional material whose curve is drawn.
_FRACTIONAL = 1e-4
# Decades of time on each side of the contact time, and points of a curve of moduli.
_DECADES, _MODULI = 3.0, 61
_MOST_BOUNCES, _LEAST_RISE = 200, 1e-4
_WEIGHT = "the weight presses in each of these contacts; the tab Impact leaves it out, so its e differs"
_MORE = "a series ends after {} bounces or {:g} s of work; the body would bounce on"
# Shares of the time of an answer for a series without and with friction, whose bounces take ten times as long.
_BOUNCES, _SPINNING_BOUNCES = 0.5, 5.0
# Points of all flights of a series, and of each flight at least.
_FLIGHT_POINTS, _LEAST_POINTS = 400, 17
# Most elements of an indentation times terms of its material; with many terms it has a coarser tolerance.
_ELEMENTS, _MANY_TERMS, _COARSE_RTOL = 12_000, 20, 1e-4
# Tolerance of taps, and most taps at a distance times terms of the material.
_TAPPING_RTOL, _TAPS, _FEWEST_TAPS = 1e-5, 400, 30

_OUTPUTS = (
    "restitution_coefficient", "contact_time", "max_force", "max_indentation_depth", "max_contact_radius",
    "residual_indentation_depth", "rebound_velocity",
)  # fmt: skip
_OBLIQUE = (
    "tangential_restitution_coefficient", "rebound_angle", "rebound_spin", "rebound_tangential_velocity",
    "impulse_ratio",
)  # fmt: skip


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


def numbers_of(values: Mapping[str, Any]) -> dict[str, Any]:
    """Return numbers as JSON has them; infinite and unknown numbers become None."""
    return plain(values, nullable)


@lru_cache(maxsize=16)
def _solved(text: str) -> Any:
    problem = _case(text).impact
    with warnings.catch_warnings():
        # The page has them among the assumptions.
        warnings.simplefilter("ignore", RestitutionWarning)
        fronts = problem.friction is not None or problem.adhesion is not None
        return rs.solve(problem, rtol=_FRONT_RTOL) if fronts else rs.solve(problem)


def _result(state: Mapping[str, Any]) -> Any:
    return _solved(json.dumps(case_content(state)))


def impact(state: Mapping[str, Any]) -> Answer:
    """Return the numbers of an impact, its history, and the moduli of the contact."""
    result = _result(state)
    numbers: State = {name: getattr(result, name) for name in _OUTPUTS}
    separated = result.status == rs.Status.SEPARATED
    numbers |= dict(zip(BUDGET, result.energy, strict=True))
    problem = result.impact
    if problem.friction is not None:
        numbers |= {name: getattr(result, name) for name in _OBLIQUE}
        numbers |= {name: getattr(problem, name) for name in ("tangential_velocity", "spin")}
    if problem.adhesion is not None:
        numbers |= {name: getattr(result, name) for name in ADHESION}
    material, series = problem.material, problem.reduced_modulus
    numbers |= {name: getattr(material, name) for name in ("poisson_ratio", "instantaneous_poisson_ratio")}
    numbers |= dict.fromkeys(("loss_tangent", "nu", "p2", "p3"))
    if problem.is_single_body:  # of two balls the page has no reduced radius and mass
        with suppress(InputError):  # which any other problem than the paper's causes
            numbers |= dict(zip(("nu", "p2", "p3"), map(float, rs.dimensionless_groups(problem)), strict=True))
    contact_time = float(result.contact_time)
    omega = math.pi / contact_time
    curves: dict[str, Any] = {"history": None, "shape": body_section(result)}
    # A captured body has no contact time; its oscillation has a scale of time.
    scale = contact_time if separated else float(result.max_indentation_depth) / float(result.velocity)
    if separated or problem.adhesion is not None:
        history = result._columns(n_points=_POINTS)
        # A body that is held at once has no motion to show.
        curves["history"] = history if history["time"][-1] > 0.0 else None
    if separated:
        numbers["loss_tangent"] = float(series.loss_modulus(omega) / series.storage_modulus(omega))
    if math.isfinite(scale) and scale > 0.0:
        curves |= _moduli(series, material.shear, scale)
    return {
        "numbers": numbers_of(numbers),
        "status": _ending(result.status),
        "validity": [_row(check) for check in result.validity],
        "notes": [*result.notes, *notes_on(material, None)],
        "curves": curves,
        "marks": numbers_of({"contact_time": contact_time, "angular_frequency": omega if separated else math.nan}),
    }  # fmt: skip


def _ending(status: rs.Status | rs.IndentationStatus) -> dict[str, str]:
    return {"name": status.name, "message": status.message}


def _row(check: validity.Check) -> dict[str, Any]:
    title, _, message = check.message.partition(": ")
    state = "doubtful" if check.exceeded else "ok" if check.value is not None else "unknown"
    numbers = numbers_of({"value": check.value, "limit": check.threshold})
    return {"kind": check.kind, "title": title, "state": state, "message": message, "advice": check.advice} | numbers


def _moduli(series: Any, shear: Any, scale: float) -> dict[str, Any]:
    """Return the relaxation moduli over time and complex moduli over frequency, about a time [s]."""
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
    """Return the restitution, contact time and peaks over the velocities of the slider."""
    started = time.thread_time()
    slider = inputs()["impact.velocity"].slider
    assert slider is not None
    speeds = np.geomspace(slider.low, slider.high, _SPEEDS)
    problem, every = _wide(state), np.arange(_SPEEDS)
    columns = {name: np.empty(_SPEEDS) for name in (*DEFAULT_OUTPUTS, "doubtful")}
    solved = np.zeros(_SPEEDS, dtype=np.bool_)

    def solve_further(chosen: NDArray[np.bool_]) -> None:
        for name, values in _columns(problem, speeds[chosen & ~solved]).items():
            columns[name][chosen & ~solved] = values
        solved[chosen] = True

    built = time.thread_time()
    # A curve with a velocity below which the body sticks would be wrong with its ends alone.
    solve_further(every % (_SPEEDS - 1 if problem.adhesion is None else _STICKING_SPEEDS) == 0)
    # After both ends as many others as the time suffices for, in two steps, as they may take longer.
    for share in _SHARES:
        now = time.thread_time()
        most = solved.sum() * (1.0 + (started + share * TIME_LIMIT - now) / max(now - built, 1e-6))
        finer = (solved | (every % n == 0) for n in range(1, _SPEEDS))
        chosen = next((places for places in finer if places.sum() <= most), solved)
        if not np.array_equal(chosen, solved):
            solve_further(chosen)
    curve = {"velocity": speeds} | columns
    return {"curves": {"velocity": {name: values[solved] for name, values in curve.items()}}}


def _wide(state: Mapping[str, Any], longest: float = 0.0) -> Any:
    """Return the impact of a state, with fractional materials that hold for all velocities of the slider."""
    case = case_of(state)
    if not case.sections.needs_window:
        return case.impact
    low, high = cast("Any", case.impact.material.window)
    # The contact time changes by less than this over the slider.
    return case.sections.build(Window(0.1 * low, max(10.0 * high, longest), _FRACTIONAL))


def _columns(problem: Any, speeds: Array) -> dict[str, Array]:
    """Return the outputs at some velocities [m/s], and whether an assumption of the theory is doubtful there."""
    impacts = vary(problem, {"velocity": speeds})
    outputs = solve_columns(impacts, _RTOL if problem.adhesion is None else _FRONT_RTOL, workers=1)
    solved = outputs["status"] < rs.Status.TOO_MANY_STEPS
    excess = np.array([*validity.excess(compared(impacts, outputs)).values()])
    columns = {name: np.where(solved, outputs[name], np.nan) for name in DEFAULT_OUTPUTS}
    return columns | {"doubtful": np.any(excess > 1.0, axis=0).astype(np.float64)}


def surface(state: Mapping[str, Any]) -> Answer:
    """Return the surface of the half-space over time, during the contact and after it."""
    late = _clock(0.5)
    result = _result(state)
    section = surface_section(result) if result.status == rs.Status.SEPARATED else None
    if section is None:
        return {"curves": {"surface": None}}
    contact_time, depth = float(result.contact_time), float(result.residual_indentation_depth)
    grid = 2.0 * contact_time * np.linspace(0.0, 1.0, _TIMES)
    radius, displacement = section
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
    """Return the bounces until the body rests, and its height over time."""
    state = {key: value for key, value in state.items() if key != "impact.external_force"}
    sections = case_of(state).sections
    motion = sections.impact
    share, rtol = (_BOUNCES, _RTOL) if motion.friction is None else (_SPINNING_BOUNCES, _FRONT_RTOL)
    late = _clock(share)
    if sections.counter_body is not None or motion.impedance is not None:
        raise InputError("target", rule="must be a half-space or a layer for a body that bounces")
    problem = _wide(state, 2.0 * motion.impact_velocity / motion.gravity)
    result = rs.bounces(
        problem, gravity=motion.gravity, max_bounces=_MOST_BOUNCES, stop=late, rtol=rtol,
        same_spot=sections.bounces.same_spot,
        min_height=_LEAST_RISE * motion.impact_velocity**2 / (2.0 * motion.gravity),
    )  # fmt: skip
    table = result.to_dataset()
    columns = {str(name): table[name].values for name in table.variables}
    numbers = {"n_bounces": result.n_bounces, "drop_height": result.drop_height, "total_time": result.touch_time[-1]}
    message = result.ended.message
    if result.ended in (Ending.STOPPED, Ending.MAX_BOUNCES):
        message = _MORE.format(_MOST_BOUNCES, share * TIME_LIMIT)
    return {
        "numbers": numbers_of(numbers),
        "status": {"name": str(result.ended), "message": message},
        "warnings": result.warnings,
        "notes": [_WEIGHT] if sections.adhesion is None else [],
        "curves": {"bounces": columns, "flight": _flight(result)},
    }


def _flight(series: Any) -> dict[str, Array]:
    """Return the height of the lowest point over time: parabolas between the touches, which last no time here."""
    count = max(_FLIGHT_POINTS // series.n_bounces, _LEAST_POINTS)
    half, share = 0.5 * series.gravity, np.linspace(0.0, 1.0, count)
    fall, starts = share * series.touch_time[0], (series.touch_time + series.contact_time)[:-1, None]
    flight = share * (series.touch_time[1:, None] - starts)
    depth, speed = series.residual_indentation_depth[:-1, None], series.rebound_velocity[:-1, None]
    heights = np.append(series.drop_height - half * fall**2, -depth + speed * flight - half * flight**2)
    return {"time": np.append(fall, starts + flight), "height": heights}


def indentation_case(state: Mapping[str, Any]) -> IndentationCase:
    """Return the case of the indentation of a state."""
    sections = read_sections(IndentationFile, Path(), indentation_content(state))
    name, history = sections.indentation.read(Path())
    window = window_around(history.stop - history.start)._replace(rtol=_FRACTIONAL)
    material, profile = sections.material.build(window), cast("Any", sections.profile.build(None))
    return IndentationCase(Path(), None, material, profile, None, name, history, _POINTS, {})


def indentation(state: Mapping[str, Any]) -> Answer:
    """Return the numbers of an indentation and its history."""
    case = indentation_case(state)
    terms = sum(getattr(part, "n_branches", 0) for part in (case.material.shear, case.material.bulk))
    rtol = _RTOL if terms <= _MANY_TERMS else _COARSE_RTOL
    limit = MOST_ELEMENTS.set(_ELEMENTS // max(terms, 10))
    try:
        with warnings.catch_warnings():
            # The result has the warnings.
            warnings.simplefilter("ignore", RestitutionWarning)
            result = indent(case.material, case.profile, rtol=rtol, **{case.prescribed: cast("Any", case.history)})
    finally:
        MOST_ELEMENTS.reset(limit)
    names = ("time", "indentation_depth", "force", "contact_radius")
    return {
        "numbers": numbers_of({name: getattr(result, name) for name in INDENTATION}),
        "status": _ending(result.status),
        "warnings": result.warnings,
        "curves": {"history": {name: result.history[name].values for name in names}},
    }


def tapping_case(state: Mapping[str, Any]) -> TappingCase:
    """Return the case of the tapping of a state."""
    sections = read_sections(TappingFile, Path(), tapping_content(state))
    window = window_around(1.0 / sections.tapping.frequency)._replace(rtol=_FRACTIONAL)
    material, profile = sections.material.build(window), cast("Any", sections.profile.build(None))
    return TappingCase(Path(), None, material, profile, None, sections.tapping.options)


def mode_swings() -> dict[str, Quantity]:
    """Return the columns of the ways of the higher modes, from the second mode on."""
    words = "half of the way of mode"
    return {f"mode_swing_{n}": MODES["mode_swing"]._replace(words=f"{words} {n}") for n in range(2, MOST_MODES + 2)}


def tapping(state: Mapping[str, Any]) -> Answer:
    """Return amplitude, phase, forces and loss of a tapping cantilever over the distance."""
    case = tapping_case(state)
    # Each tap takes the longer the more terms there are.
    most = max(_TAPS // max(case.material.shear.n_branches, 1), _FEWEST_TAPS)
    options: dict[str, Any] = case.options | {"max_taps": most, "rtol": _TAPPING_RTOL}
    result = tap(case.material, case.profile, **options)
    # Numbers of taps that are not steady are no part of a curve.
    steady = result.status <= TappingStatus.FREE
    columns = {name: np.where(steady, getattr(result, name), np.nan) for name in COLUMNS}
    columns["distance"], columns["loss_per_tap"] = result.distance, columns.pop("dissipated")
    # The first mode has nearly all of the amplitude.
    swings = zip(mode_swings(), result.mode_swing.T[1:], strict=False)
    columns |= {name: np.where(steady, swing, np.nan) for name, swing in swings}
    count = int(np.sum(~steady))
    return {
        "numbers": numbers_of({name: values[-1] for name, values in columns.items()})
        | {"free_amplitude": result.free_amplitude},
        "warnings": [f"{count} of {steady.size} distances have no steady taps after {most}"] * (count > 0),
        "notes": ["the numbers are those at the smallest distance"],
        "curves": {"tapping": columns},
    }


_SKETCH = (
    "Orange: the ring in which the surfaces attract each other. Its gap ends at the range of the attraction; the "
    "surface beyond the contact is a sketch"
)


def body_section(result: Any) -> dict[str, Any] | None:
    """Return the lower surface of the body along the long semi-axis, and this over the contact radius if known.

    Where the surface around the body is `unknown`, words say so; a layer has a `thickness` [m].
    """
    tip: Any = result.impact.profile
    profile, semi_axis, most = tip, 1.0, float(result.max_contact_radius)
    about: dict[str, Any] = {"unknown": None, "thickness": None, "range": None}
    if isinstance(tip, rs.Layer):
        profile, semi_axis = tip.profile, None
        about = {"unknown": "The surface of a layer around the body is not known", "thickness": float(tip.thickness)}
    elif result.impact.adhesion is not None:
        # Between the edges of contact and zone the gap grows from zero to the range.
        about |= {"unknown": _SKETCH, "range": float(result.impact.adhesion.range)}
    elif isinstance(tip, rs.Ellipsoid):
        profile, semi_axis = Parabola(max(tip.radius_1, tip.radius_2)), float(tip.semi_axes(1.0)[0])
        most *= semi_axis
    elif isinstance(tip, rs.Pyramid):
        # Across two faces: at a right angle to both, or, of three faces, at 60 deg.
        slope = tip.slope * (math.sin(math.pi / 3.0) if tip.sides == 3 else 1.0)
        profile, semi_axis, most = Cone(math.atan(1.0 / slope)), None, float(result.max_indentation_depth) / slope
        about["unknown"] = "A section through two faces. The surface around a pyramid is not known"
    if not isinstance(profile, Profile):
        return None
    radius = np.linspace(0.0, 3.0 * most if 0.0 < most < math.inf else 1.0, _BODY)
    with np.errstate(all="ignore"):
        return {"radius": radius, "height": np.asarray(profile.shape(radius)), "semi_axis": semi_axis} | about


def surface_section(result: Any) -> tuple[Array, Callable[[float], Array]] | None:
    """Return distances [m] from the axis and the displacement of the surface [m] there over the time [s]."""
    tip, section = result.impact.profile, body_section(result)
    if section is None or section["unknown"] is not None:
        return None
    radius = np.linspace(0.0, section["radius"][-1], _SURFACE)
    if isinstance(tip, Profile):
        return radius, lambda t: result.surface_displacement(radius, t)
    from scipy.special import elliprf

    # The depths u(x) of the foundation are those of nested flat punches. A punch with the semi-axes a and k a moves
    # the surface at p a on its long axis by R_F(p^2 - 1, p^2, p^2 - 1 + k^2)/R_F(0, 1, k^2) of its own depth.
    ends = np.linspace(0.0, float(tip.stiffness_radius(result.max_indentation_depth)), _PUNCHES + 1)
    axis = tip.semi_axes(tip.contact_radius(1.0) / tip.stiffness_radius(1.0))[0] * 0.5 * (ends[1:] + ends[:-1])
    p, k = np.maximum(radius[:, None] / axis, 1.0) ** 2, tip.axis_ratio**2
    share = elliprf(p - 1.0, p, p - 1.0 + k) / elliprf(0.0, 1.0, k)

    def displacement(t: float) -> Array:
        line = result._fields.line_displacement(t)
        return np.zeros(_SURFACE) if line is None else share @ -np.diff(np.append(line(ends[:-1]), 0.0))

    return radius, displacement


KINDS: dict[str, Callable[[Mapping[str, Any]], Answer]] = {
    answer.__name__: answer for answer in (impact, velocity, surface, bounces, indentation, tapping)
}
"""Answers that follow from the state alone."""


@cache
def paper() -> dict[str, Any]:
    """Return the claims as `restitution reproduce` has judged them, and what figures 3 to 6 need."""
    record = json.loads((files("restitution.paper") / "claims.json").read_text(encoding="utf-8"))
    planes = {str(n): {"nu": nu} for n, nu in figures.PLANES.items()}
    return {
        "claims": record["claims"],
        "levels": list(figures.LEVELS),
        "poisson_ratios": [*figures.POISSON_RATIOS, 0.5],
        "figures": planes | {str(n): {"p2": 10.0**power} for n, power in figures.CURVES.items()},
        "guessed": record["guessed"],
        "references": record["references"],
    }


@cache
def interpolant() -> str:
    """Return the interpolant of the paper's restitution coefficient as JSON, for its evaluation by the page.

    The coefficients are 32-bit floats, little-endian, in base64.
    """
    source = files("restitution.surrogates") / "data" / "standard_solid.npz"
    with as_file(source) as path, np.load(path) as data:
        levels, places = data["levels"].astype(int).tolist(), data["places"].astype(int).tolist()
        coefficients = base64.b64encode(data["coefficients"].astype("<f4").tobytes()).decode("ascii")
    low, high = (corner.tolist() for corner in standard_solid.corners())
    content = {
        "nu": [-1.0, 0.5], "p2": standard_solid.P2, "p3": standard_solid.P3, "error": standard_solid.STATED_ERROR,
        "terms": standard_solid.TERMS, "low": low, "high": high, "levels": levels, "places": places,
        "coefficients": coefficients,
    }  # fmt: skip
    return json.dumps(content, separators=(",", ":"))
