"""Impact on the surface that an earlier contact has left."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from restitution.errors import InputError
from restitution.impact.batch import Batch
from restitution.impact.problem import Impact
from restitution.impact.solution import PanelMotion
from restitution.impact.status import Status
from restitution.indentation.drive import Drive
from restitution.indentation.history import History
from restitution.indentation.panels import PanelSolution
from restitution.indentation.surface import Surface, check_surface
from restitution.kernel.plain import single_problem

# Contact times of the first run, its factor, and the longest.
_FIRST, _FACTOR, _MOST = 8.0, 2.0, 1e7
# Rounds in which a modulus and the duration of an impact follow from each other.
_ROUNDS = 4
# Share of the impact velocity below which a body in a liquid is at rest.
_REST = 1e-6
# Force on a body that stays, over what holds it, less 1, in the second half of a run; and times that are looked at.
_UNSTEADY, _SAMPLES = 0.1, 201
# First step over the time to the largest depth.
_FIRST_STEP = 0.15


def fresh_depth(impact: Impact) -> float | None:
    """Return about the largest depth [m] of an impact on a fresh surface: that of an elastic body.

    Its modulus is that of the material at the duration of the impact. None with an external force, for a liquid, which
    may not rebound, and for profiles without a power law.
    """
    profile, series = impact.contact.profile, impact.reduced_modulus
    exponent, coefficient = profile.path_exponent, profile.path_coefficient
    if np.any(impact.external_force) or series.is_liquid or exponent is None or coefficient is None:
        return None
    mass, velocity, p = float(impact.mass), float(impact.velocity), float(exponent)
    # 2 E c d^(2 + p/2) = (p + 2)(p + 4)/8 m v^2 with a = c d^(p/2).
    energy = (p + 2.0) * (p + 4.0) / 16.0 * mass * velocity**2 / float(coefficient)
    equilibrium, viscosity = float(series.equilibrium_modulus), float(series.parallel_viscosity)
    moduli, times = series.branch_moduli, series.relaxation_times
    modulus, depth = equilibrium + float(moduli.sum()), 0.0
    for _ in range(_ROUNDS):
        depth = (energy / modulus) ** (1.0 / (2.0 + 0.5 * p))
        duration = 1.5 * depth / velocity
        modulus = equilibrium + float(moduli @ (times / (times + duration))) + viscosity / duration
    return depth


@single_problem()
def panels_of_impact(impact: Impact, surface: Surface | None, deepest: float, rtol: float) -> PanelSolution:
    """Return the motion of an impact from the touch to separation, or to rest, by panels.

    `deepest` is about the largest depth [m] of the same impact on a fresh surface, from which the scales follow;
    without its force where that presses the body into a liquid for ever.
    """
    if math.isfinite(float(impact.impedance)):
        rule = "must be infinite for an imprint, which the theory of moving targets does not have"
        raise InputError("impedance", float(impact.impedance), rule, "kg/s")
    level = 0.0 if surface is None else surface.depth
    velocity, push = float(impact.velocity), float(impact.external_force)
    reach = deepest + level
    peak = min(2.0 * reach, float(impact.profile.max_depth))
    # A deep imprint says nothing about the time of a contact, and a force makes the body faster.
    scale = deepest / math.hypot(velocity, math.sqrt(push * deepest / float(impact.mass)))
    time = _FIRST * 3.0 * scale
    while True:
        history = History(np.array([0.0, time]), np.array([[push, 0.0]]))
        drive = Drive(
            history, False, peak, mass=float(impact.mass), velocity=velocity, touches=True, once=True, depth=level,
            first=_FIRST_STEP * scale,
        )  # fmt: skip
        solution = PanelSolution(
            impact.contact.profile, impact.reduced_modulus, drive, rtol, None if surface is None else surface.marks
        )
        if solution.max_depth > float(impact.profile.max_depth):
            raise _too_deep(impact)
        stays = _settles(solution, push) if push > 0.0 else abs(solution.end_state[1]) < _REST * velocity
        if stays or solution.stop < time or time > _MOST * reach / velocity:
            return solution
        time *= _FACTOR


def _too_deep(impact: Impact) -> InputError:
    """Return the error of a body that goes deeper than its profile is described."""
    deepest = float(impact.profile.max_depth)
    rule = f"is described to a depth of {deepest:.3g} m, {impact.profile.end}, and the body goes deeper"
    return InputError("profile", rule=rule)


def _settles(solution: PanelSolution, push: float) -> bool:
    """Return whether a body that a force holds hardly oscillates any more: it never leaves from then on.

    Steps that go on to the end of the oscillation would find nothing but rounding.
    """
    times = np.linspace(0.5 * (solution.history.start + solution.stop), solution.stop, _SAMPLES)
    return bool(np.all(np.abs(solution.at(times)[2] - push) < _UNSTEADY * push))


def solve_on_surface(impact: Impact, surface: Surface, deepest: float, rtol: float) -> dict[str, Any]:
    """Return the outputs of an impact on a surface, its status, and its motion."""
    check_surface(surface, impact.contact)
    solution = panels_of_impact(impact, surface, deepest, rtol)
    parted = not solution.touches_at_end
    depth, rate = solution.end_state
    status = Status.SEPARATED if parted else Status.CAPTURED
    largest, radius = [solution.largest(column) for column in (0, 2)], solution.max_contact_radius
    if not parted and impact.reduced_modulus.is_liquid:
        status = Status.SINKS_IN
        if np.any(impact.external_force):
            # It sinks for ever, so that the end of the run is arbitrary.
            depth, largest, radius = math.inf, [math.nan, math.nan], math.nan
    elif not parted:
        # It creeps on, to the depth at which the relaxed body carries the force.
        depth = float(Batch.from_impact(impact).rest_depth()[0])
        if not depth <= float(impact.profile.max_depth):
            raise _too_deep(impact)
        largest = [max(pair) for pair in zip(largest, (depth, float(impact.external_force)), strict=True)]
        radius = max(radius, float(impact.contact.profile.contact_radius(depth)))
    return {
        "restitution_coefficient": max(-rate / float(impact.velocity), 0.0) if parted else 0.0,
        "contact_time": solution.stop if parted else math.inf,
        "max_indentation_depth": largest[0],
        "max_force": largest[1],
        "max_contact_radius": radius,
        "residual_indentation_depth": depth,
        "status": status,
        "motion": PanelMotion(solution, surface) if parted else None,
    }
