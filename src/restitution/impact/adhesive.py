"""Outputs of adhesive impacts as columns: one march for each, and the numbers that decide it."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

import numpy as np

from restitution.checks import Array, Numeric
from restitution.contact.adhesion import maugis_number, rest
from restitution.impact.dugdale import NUMBERS, Problem, Solved, first_width, solve_adhesive
from restitution.impact.members import of_each, shape_of, single_of
from restitution.impact.solution import Progress
from restitution.impact.status import Status
from restitution.indentation.attraction import UNLOADED, Load, March, Sticky, sticky
from restitution.parallel import on_threads
from restitution.quantities import BODY, IMPACT_OUTPUTS, STATUS, derived
from restitution.units import in_words

if TYPE_CHECKING:
    from restitution.impact.problem import Impact

_STORED = ("restitution_coefficient", "zone_width", *(name for name in NUMBERS if name != "energy"))

LEAST_RTOL = 1e-6
"""Smallest tolerance of e with adhesion."""

# Maugis' parameter at the static modulus from which the zone is too thin for the elements, and its advised value.
_THINNEST, _ADVISED = 1000.0, 5.0
# Range over depth beyond which rounding of the range hides the depth, as gaps have the sum of both.
_FARTHEST = 1e9


def maugis_numbers(impact: Impact) -> tuple[Numeric, Numeric]:
    """Return Maugis' parameter with the static and with the instantaneous reduced modulus, in the shape of impacts."""
    adhesion, series = impact.adhesion, impact.contact.reduced_modulus
    assert adhesion is not None
    with np.errstate(divide="ignore"):
        both = (
            maugis_number(adhesion.work, adhesion.stress, np.asarray(modulus), impact.profile.tip_radius)
            for modulus in (series.equilibrium_modulus, series.instantaneous_modulus)
        )
        static, glass = (np.broadcast_to(each, impact.shape)[()] for each in both)
    return static, glass


def attraction_numbers(impact: Impact | list[Impact], columns: Mapping[str, Any]) -> dict[str, Any]:
    """Return the columns of the validity report that belong to the attraction."""

    def numbers(single: Impact) -> list[Any]:
        assert single.adhesion is not None
        return [*maugis_numbers(single), single.adhesion.range]

    names = "maugis_number", "instantaneous_maugis_number", "attraction_range"
    return dict(zip(names, of_each(impact, numbers), strict=True)) | {"zone_width": columns["zone_width"]}


def problem_of(impact: Impact) -> Problem:
    """Return the numbers of a single impact; refuse what the theory does not have."""
    assert impact.adhesion is not None
    body, force = sticky(impact.contact, impact.adhesion), float(impact.external_force)
    load = Load(force, _least_energy(body, force)) if force > 0.0 else UNLOADED
    return Problem(body, float(impact.mass), float(impact.velocity), load)


def _least_energy(body: Sticky, force: float) -> float:
    """Return a bound [J] below which no body leaves under a constant force.

    A surface without load that is still indented has the least energy where it has the shape of a contact without
    adhesion on an elastic body of the compliance ``Jinf - J0``. With the force this energy is -int d dF >= -d F.
    """
    from restitution.indentation.panels import largest_depth
    from restitution.material.prony import PronySeries

    glass, static = float(body.modulus.instantaneous_modulus), float(body.modulus.equilibrium_modulus)
    if not glass > static:
        return 0.0
    if static == 0.0:
        # A liquid may always leave.
        return -math.inf
    depth = largest_depth(PronySeries(glass * static / (glass - static)), body.profile, force, 0.0)
    # Beyond the profile no depth is a bound.
    return -math.inf if depth >= float(body.profile.max_depth) else -force * depth


def unresolved(impact: Impact) -> str:
    """Return why elements do not resolve the zone of a single impact; empty if they do."""
    assert impact.adhesion is not None
    largest = float(np.asarray(maugis_numbers(impact)[1]))
    if largest > _THINNEST:
        stress = float(np.asarray(impact.adhesion.stress)) * _ADVISED / largest
        return (
            f"Maugis' lambda is {largest:.3g} at the instantaneous modulus, and the zone too thin for the elements "
            f"above {_THINNEST:g}; a stress of {in_words(stress, 'Pa')} has lambda = {_ADVISED:g}, nearly that of JKR"
        )
    reach, problem = float(np.asarray(impact.adhesion.range)), problem_of(impact)
    depth = float(problem.body.profile.transform(first_width(problem)))
    if reach > _FARTHEST * depth:
        sizes = f"{in_words(reach, 'm')}, and a depth of some {in_words(depth, 'm')}"
        return f"the range of the attraction is {sizes} is lost in its rounding; take a larger stress"
    return ""


def adhesive_columns(
    impact: Impact | list[Impact], rtol: float, *, workers: int | None = None, progress: Progress | None = None
) -> dict[str, Array]:
    """Return all outputs of adhesive impacts by name, raveled, and their status."""
    columns, _ = marched(impact, max(rtol, LEAST_RTOL), workers, progress)
    numbers = of_each(impact, lambda single: [getattr(single, name) for name in BODY])
    shape = shape_of(impact)
    bodies = {name: np.broadcast_to(each, shape).reshape(-1) for name, each in zip(BODY, numbers, strict=True)}
    outputs = balanced(impact, columns | bodies)
    return {name: outputs[name] for name in (*IMPACT_OUTPUTS, STATUS) if name in outputs}


def balanced(impact: Impact | list[Impact], columns: Mapping[str, Any]) -> dict[str, Any]:
    """Return columns of outputs and of `BODY` with all outputs that follow; a force works from the depth -h0 on."""
    (reach,) = of_each(impact, _range)
    outputs, way = derived(columns), np.broadcast_to(reach, shape_of(impact))
    residual = outputs["energy_residual"]
    work = columns["external_force"] * way.reshape(np.shape(residual))
    return outputs | {"energy_residual": residual - work / outputs["kinetic_energy_in"]}


def _range(impact: Impact) -> list[Any]:
    assert impact.adhesion is not None
    return [impact.adhesion.range]


def marched(
    impact: Impact | list[Impact], rtol: float, workers: int | None, progress: Progress | None
) -> tuple[dict[str, Array], March | None]:
    """Return the stored outputs of impacts by name, raveled, with the error of e; and the march of a single impact."""
    shape = shape_of(impact)
    count, names = math.prod(shape), (*_STORED, "restitution_error")
    columns = {name: np.full(count, np.nan) for name in names}
    columns[STATUS] = np.full(count, int(Status.NOT_ACCURATE))
    kept: list[March | None] = []
    done = 0

    def run(place: int) -> None:
        nonlocal done
        single = single_of(impact, place)
        done += 1
        if unresolved(single):
            return
        solved = _solved(problem_of(single), rtol)
        columns[STATUS][place], columns["restitution_error"][place] = int(solved.status), solved.error
        if not solved.status.failed:
            for name, value in solved.numbers.items():
                columns[name][place] = value
        if not shape:
            kept.append(solved.march)

    def report() -> None:
        if progress is not None:
            progress(done, count)

    # The first impact compiles the kernel.
    for place in range(min(count, 1)):
        run(place)
        report()
    if count > 1:
        on_threads(run, range(1, count), workers, report)
    return columns, kept[0] if kept else None


def _solved(problem: Problem, rtol: float) -> Solved:
    """Return one solved impact with its stored outputs as numbers."""
    solved = solve_adhesive(problem, rtol)
    if solved.status == Status.CAPTURED:
        solved = _at_rest(problem, solved)
    numbers = dict(solved.numbers)
    # An elastic body gains nothing by the error of its energy.
    numbers["restitution_coefficient"] = math.sqrt(min(max(numbers.pop("energy"), 0.0), 1.0))
    numbers["zone_width"] = math.nan if solved.march is None else _zone_width(solved.march)
    return solved._replace(numbers=numbers)


def _zone_width(march: March) -> float:
    """Return the width [m] of the ring around the largest contact; NaN without touch."""
    *_, zone, radius, _, _ = march.motion.T
    place = int(np.argmax(radius))
    return float(zone[place] - radius[place]) if radius[place] > 0.0 else math.nan


def _at_rest(problem: Problem, solved: Solved) -> Solved:
    """Return the result of a captured body with the depth at which it comes to rest, that of a profile with room."""
    body, march, force = problem.body, solved.march, problem.load.force
    static = float(body.modulus.equilibrium_modulus)
    numbers = dict(solved.numbers)
    depth = radius = math.inf
    if static > 0.0:
        assert march is not None
        held = rest(body.profile, static, body.adhesion, march.widest, force)
        depth, radius = held.depth, held.radius
        if math.isnan(depth):
            return solved._replace(status=Status.TOO_DEEP)
    numbers |= {
        "residual_indentation_depth": depth, "contact_time": math.inf, "touching_time": math.inf,
        "max_indentation_depth": max(numbers["max_indentation_depth"], depth),
        "max_contact_radius": max(numbers["max_contact_radius"], radius),
        "max_force": max(numbers["max_force"], force),
        "dissipated_energy": math.nan, "radiated_energy": math.nan, "stored_energy": math.nan,
    }  # fmt: skip
    return solved._replace(numbers=numbers)
