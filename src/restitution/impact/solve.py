"""Solution of impacts, exactly or by the elements of the paper."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from contextlib import nullcontext
from dataclasses import replace
from functools import partial
from os import PathLike
from typing import Any, Literal

import numpy as np
from numpy.typing import ArrayLike

from restitution.axes import Axes, aligned
from restitution.checks import Array, common_shape, function, items, one_of, single, whole, within
from restitution.errors import InputError, InputTypeError
from restitution.impact.batch import Batch, flat, shaped, solve_columns
from restitution.impact.members import shape_of
from restitution.impact.oblique import ObliqueResult, Sliding, join_sliding, normal_rtol
from restitution.impact.problem import Impact
from restitution.impact.result import ImpactResult
from restitution.impact.solution import PanelMotion, Progress, Sampled, Solution, Trajectory
from restitution.impact.status import SolverError, Status, failures
from restitution.indentation.surface import Surface
from restitution.kernel.outcome import OUTCOME
from restitution.kernel.plain import single_problem
from restitution.material.conversion import reduced_standard_solid
from restitution.quantities import IMPACT_OUTPUTS, OUTPUTS, SOLVER_RTOL, STATUS, check
from restitution.validity import warn

Method = Literal["exact", "elements"]
Errors = Literal["raise", "warn"]


def solve(
    impact: Impact | Sequence[Impact],
    method: Method = "exact",
    *,
    rtol: float = 1e-9,
    surface: Surface | None = None,
    errors: Errors | None = None,
    workers: int | None = None,
    progress: Progress | None = None,
    n_elements: int | None = None,
    time_step: float | None = None,
) -> ImpactResult:
    """Return the restitution coefficient, contact time, peaks, energy and history of impacts.

    Parameters
    ----------
    impact : Impact, or sequence of Impact
        One impact, an array of impacts (an `Impact` with arrays), or a list of single ones. All or none of a list
        have friction, and all or none adhesion.
    method : {"exact", "elements"}
        "exact": collocation of the reduced equations, of any accuracy. "elements": the elements and the explicit Euler
        scheme of the paper, of first order, without friction.
    rtol : float
        The error of e stays below `rtol max(e, 1e-3)`, down to rounding errors of about 1e-12; in [1e-12, 1e-2]. The
        other results have no tolerance of their own; the page Validation has their measured errors. With adhesion
        it is at least 1e-6, see `AdhesiveResult`.
    surface : Surface, optional
        Surface that an earlier impact or indentation of this body has left, from `surface()` of its result: a single
        impact begins there, at the surface as it is at the axis. A fresh surface by default. The errors of e and of
        the rest, over their largest values, are then about `rtol`, which must be at least 1e-11.
    errors : {"raise", "warn"}, optional
        "raise": a failed solve raises. "warn": its results are NaN with its status, and a warning counts such solves.
        The default is to raise for a single impact and to warn for several.
    workers : int, optional
        Number of threads for several impacts; by default the number of cores. Results do not depend on it.
    progress : callable, optional
        Called with (impacts done, all impacts).
    n_elements, time_step : int, float, optional
        For the element method: largest number of elements in contact, time step [s].

    Returns
    -------
    ImpactResult
        Numbers for a single impact, arrays for several. With friction an `ObliqueResult`, which has e_t, the spin
        and the angle of the rebound as well; with adhesion an `AdhesiveResult`.

    Raises
    ------
    InputError
        If an option is out of range, or friction meets the elements or a surface.
    SolverError
        If a solve fails and `errors` is "raise".

    Warns
    -----
    RestitutionWarning
        For several impacts: how many failed, and how many exceed the limit of each assumption of the theory. For a
        single impact, see `ImpactResult.validity`; only the approximation on a bonded layer has a warning.

    Examples
    --------
    >>> import restitution as rs
    >>> solid = rs.standard_solid(1.0, 10.0, 1.0, poisson_ratio=0.3)
    >>> impact = rs.Impact(material=solid, profile=rs.Parabola(radius=1.0), mass=1.0, velocity=1.0)
    >>> print(round(rs.solve(impact).restitution_coefficient, 8))
    0.43435616
    """
    _check_options(method, rtol, errors, workers, progress)
    if method != "elements" and not (n_elements is None and time_step is None):
        raise InputError("n_elements, time_step", rule=f"belong to method 'elements', not to {method!r}")
    if isinstance(impact, Impact):
        if impact.friction is not None and (method != "exact" or surface is not None):
            raise InputError("friction", rule='must be None for method "elements" and on a surface with an imprint')
        with nullcontext() if impact.shape else single_problem():
            if not impact.shape:
                impact.contact.warn_if_approximate()
            if impact.adhesion is not None:
                return _solve_adhesive(impact, method, rtol, surface, errors, workers, progress)
            if surface is not None:
                return _solve_on(impact, method, surface, rtol, errors, progress)
            if method == "exact":
                return solve_exact(impact, rtol, errors, workers, progress)
            return _solve_by_elements(impact, n_elements, time_step)
    impacts = _as_list(impact)
    if surface is not None:
        raise InputError("surface", rule="belongs to a single impact, not to a list")
    if method != "exact":
        raise InputError("method", method, "must be 'exact' for a list; other methods take one impact at a time")
    if impacts[0].adhesion is not None:
        return _solve_adhesive(impacts, method, rtol, surface, errors, workers, progress)
    return solve_exact(impacts, rtol, errors, workers, progress)


def _as_list(impact: Any) -> list[Impact]:
    """Return the impacts of a sequence; refuse other types, with advice."""
    if isinstance(impact, (str, PathLike)):
        raise InputTypeError("impact", impact, "must be an Impact; solve(read_case(path).impact) solves a case file")
    if isinstance(getattr(impact, "impact", None), Impact):
        kind = type(impact).__name__
        raise InputTypeError("impact", rule=f"must be an Impact, not a {kind}; take its attribute impact")
    if isinstance(impact, Mapping):
        raise InputTypeError("impact", rule="must be an Impact, not a dict; write Impact(**numbers)")
    impacts = items("impact", impact, "must be an Impact or a list of them")
    for n, member in enumerate(impacts):
        if not isinstance(member, Impact):
            raise InputTypeError("impact", member, "must be an Impact", index=(n,))
        if member.shape:
            raise InputError("impact", rule=f"has shape {member.shape}; a list takes single impacts", index=(n,))
    if not impacts:
        raise InputError("impact", rule="must hold at least one impact")
    if len({member.friction is None for member in impacts}) > 1:
        raise InputError("impact", rule="must all have friction, or none of them; 0 is that of a smooth contact")
    if len({member.adhesion is None for member in impacts}) > 1:
        raise InputError("impact", rule="must all have adhesion, or none of them; solve both kinds apart")
    return impacts


def standard_solid_restitution(
    nu: ArrayLike,
    p2: ArrayLike,
    p3: ArrayLike,
    *,
    method: Method = "exact",
    rtol: float = 1e-9,
    errors: Errors | None = None,
    workers: int | None = None,
    progress: Progress | None = None,
) -> Any:
    """Restitution coefficient e(p1, p2, p3) of a rigid sphere on a compressible standard solid (the paper's eq. 11).

    Parameters
    ----------
    nu : array_like
        p1, static Poisson ratio [-], in [-1, 0.5]; 0.5 means incompressible.
    p2, p3 : array_like
        Equilibrium over branch modulus Ginf/G1 and `eta (v0 R/(m^2 Ginf^3))^(1/5)` [-], > 0.
    method, rtol, errors, workers, progress
        See `solve`.

    Returns
    -------
    float or ndarray
        e, in the common shape of the three.

    Raises
    ------
    InputError
        If a number is out of range.
    SolverError
        If a solve fails and `errors` is "raise" (the default for single numbers).

    Examples
    --------
    >>> print(round(standard_solid_restitution(0.49, 1e-3, 10.0), 6))
    0.219706
    """
    numbers, axes = aligned({"nu": nu, "p2": p2, "p3": p3})
    nu, p2, p3 = numbers.values()
    groups = check("poisson_ratio", nu, "nu"), check("p2", p2), check("p3", p3)
    _check_options(method, rtol, errors, workers, progress)
    shape = common_shape({name: np.shape(x) for name, x in zip(numbers, groups, strict=True)})
    p1, p2, p3 = (flat(x, shape) for x in groups)
    if method != "exact":
        triples = zip(p1, p2, p3, strict=True)
        return _named(shaped([_standard_solid_by_elements(*triple) for triple in triples], shape), axes)
    ones = np.ones(p1.size)
    with np.errstate(over="ignore", under="ignore"):
        reduced = reduced_standard_solid(p1, ones, 1.0 / p2, p2 * p3)
    batch = Batch(*reduced.columns, ones, ones, 0.0 * ones, ones, 1.0)
    with nullcontext() if shape else single_problem():
        outputs = batch.solve(rtol, workers=workers, progress=progress)
    judge(outputs["status"], errors or ("warn" if shape else "raise"))
    return _named(shaped(outputs["restitution_coefficient"], shape), axes)


def _named(e: Any, axes: Axes | None) -> Any:
    name = "restitution_coefficient"
    return e if axes is None else axes.array(e, name, OUTPUTS[name].attributes)


def _standard_solid_by_elements(nu: float, p2: float, p3: float) -> float:
    from restitution.contact.profiles import Parabola
    from restitution.material.classical import standard_solid

    material = standard_solid(1.0, 1.0 / p2, p3, poisson_ratio=nu)
    result = solve(Impact(material, Parabola(radius=1.0), mass=1.0, velocity=1.0), "elements")
    return float(result.restitution_coefficient)


def _check_options(method: Any, rtol: Any, errors: Any, workers: Any, progress: Any) -> None:
    single("rtol", SOLVER_RTOL.check(rtol))
    one_of("method", method, ("exact", "elements"))
    if errors is not None:
        one_of("errors", errors, ("raise", "warn"))
    if workers is not None:
        whole("workers", workers)
    if progress is not None:
        function("progress", progress, "must be callable with (impacts done, all impacts)", 2)


def judge(statuses: Array, errors: Errors, stacklevel: int = 3) -> None:
    """Raise an error or warn if solves failed."""
    kinds = statuses.astype(np.int64)
    message = failures(np.bincount(kinds, minlength=len(Status)).tolist(), kinds.size)
    if message and errors == "raise":
        first = int(np.argmax(kinds >= Status.TOO_MANY_STEPS))
        raise SolverError(Status(kinds[first]), f"impact {first} of {kinds.size}" if kinds.size > 1 else "")
    warn({"failed": message} if message else {}, stacklevel)


def solve_exact(
    impact: Impact | list[Impact], rtol: float, errors: Errors | None = None, workers: int | None = None,
    progress: Progress | None = None,
) -> ImpactResult:  # fmt: skip
    """Solve impacts by the exact method; see `solve`, which checks the options."""
    shape = shape_of(impact)
    solution, has_friction = None, (impact if isinstance(impact, Impact) else impact[0]).friction is not None
    of_normal = normal_rtol(rtol) if has_friction else rtol
    if shape or isinstance(impact, list):
        columns = solve_columns(impact, of_normal, workers=workers, progress=progress)
    else:
        columns, solution = Batch.from_impact(impact).solve_stored(of_normal)
        most = float(impact.profile.max_depth)
        if columns["status"][0] == Status.TOO_DEEP and math.isfinite(most):
            rule = f"is described to a depth of {most:.3g} m, {impact.profile.end}, and the body goes deeper"
            raise InputError("profile", rule=rule)
        if progress is not None:
            progress(1, 1)
    sliding = join_sliding(impact, columns, rtol, workers, progress, solution)
    judge(columns["status"], errors or ("warn" if shape else "raise"), stacklevel=4)
    columns = {
        name: column for name, column in columns.items() if name == STATUS or IMPACT_OUTPUTS[name].derive is None
    }
    result = _result(impact, "exact", rtol, columns, solution, shape, sliding=sliding)
    if shape:
        warn({check.kind: check.warning for check in result.validity if check.exceeded}, stacklevel=3)
    return result


def _result(
    impact: Impact | list[Impact], method: str, rtol: float | None, fields: dict[str, Any],
    solution: Solution | Sampled | PanelMotion | None, shape: tuple[int, ...] = (), notes: tuple[str, ...] = (),
    sliding: Sliding | None = None, began_on: Surface | None = None,
) -> ImpactResult:  # fmt: skip
    numbers: dict[str, Any] = {
        name: shaped(values, shape) if shape else float(np.asarray(values).item()) for name, values in fields.items()
    }
    status: Any = numbers.pop("status")
    status = status.astype(np.int64) if isinstance(status, np.ndarray) else Status(int(status))
    axes = None if isinstance(impact, list) else impact.axes
    if axes is not None:
        numbers = {name: axes.array(values, name, IMPACT_OUTPUTS[name].attributes) for name, values in numbers.items()}
        status = axes.array(status, STATUS, Status.attributes())
    again = None if axes is None or rtol is None else partial(solve_exact, rtol=rtol)
    options: dict[str, Any] = {
        "status": status, "impact": impact, "method": method, "rtol": rtol, "_solution": solution, "_again": again
    }  # fmt: skip
    if sliding is not None:
        return ObliqueResult(**numbers, **options, notes=sliding.notes, _march=sliding.march)
    return ImpactResult(**numbers, **options, notes=notes, began_on=began_on)


def _solve_on(
    impact: Impact, method: str, surface: Surface, rtol: float, errors: Errors | None, progress: Progress | None
) -> ImpactResult:
    """Solve one impact on a surface with an imprint."""
    from restitution.impact.repeated import fresh_depth, solve_on_surface

    if impact.shape:
        raise InputError("surface", rule=f"belongs to a single impact, not to an array of shape {impact.shape}")
    one_of("method", method, ("exact",), "an imprint takes the exact method")
    within("rtol", rtol, 1e-11, 1e-2)
    # Only scales follow from this depth.
    deepest = fresh_depth(impact)
    if deepest is None:
        fresh = solve_exact(impact, max(rtol, 1e-6), errors)
        if fresh.status is Status.SINKS_IN and impact.external_force:
            fresh = solve_exact(replace(impact, external_force=0.0), max(rtol, 1e-6), errors)
        deepest = float(np.asarray(fresh.max_indentation_depth))
    fields = solve_on_surface(impact, surface, deepest, rtol)
    motion = fields.pop("motion")
    if progress is not None:
        progress(1, 1)
    return _result(impact, "panels", rtol, fields, motion, began_on=surface)


def _solve_adhesive(
    impact: Impact | list[Impact], method: str, rtol: float, surface: Surface | None, errors: Errors | None,
    workers: int | None, progress: Progress | None,
) -> ImpactResult:  # fmt: skip
    """Solve impacts with adhesion."""
    from restitution.impact.adhesion import solve_with_adhesion

    one_of("method", method, ("exact",), "adhesion has a method of its own")
    if surface is not None:
        raise InputError("surface", rule="must be left out with adhesion, which begins on a fresh surface")
    return solve_with_adhesion(impact, rtol, errors, workers, progress)


def _solve_by_elements(impact: Impact, n_elements: int | None, time_step: float | None) -> ImpactResult:
    """Solve one impact by the element method."""
    from restitution.impact.elements import solve_elements

    if impact.shape:
        rule = f"must be 'exact' for an array of shape {impact.shape}; other methods take one impact at a time"
        raise InputError("method", "elements", rule)
    solution = solve_elements(impact, n_elements=800 if n_elements is None else n_elements, time_step=time_step)
    e, mass, velocity = solution.restitution_coefficient, float(impact.mass), float(impact.velocity)
    work = float(impact.external_force) * np.nan_to_num(solution.residual_indentation_depth, posinf=0.0)
    notes = []
    if 0.5 * mass * (e * velocity) ** 2 > (0.5 * mass * velocity**2 + work) * (1.0 + 1e-9):
        notes.append(f"accuracy: e = {e:.6g} gains energy; take more elements")
    trajectory = Trajectory(
        solution.time, solution.indentation_depth, solution.indentation_velocity, solution.force,
        solution.contact_radius,
    )  # fmt: skip
    samples = Sampled(trajectory, solution.dissipated, solution.stored, solution.radiated)
    fields = {name: value for name, value in solution._asdict().items() if name in OUTCOME}
    return _result(impact, "elements", None, fields, samples, notes=tuple(notes))
