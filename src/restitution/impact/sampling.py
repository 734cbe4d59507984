"""Methods that follow one impact in steps: the paper's elements, and the reference through SciPy."""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from restitution.impact.batch import Batch
from restitution.impact.problem import Impact
from restitution.impact.solution import Trajectory, within_contact


class Sampled(NamedTuple):
    """The motion that was sampled, and the energies.

    Attributes
    ----------
    trajectory : Trajectory
        The samples.
    dissipated, stored : float
        Energies at the end [J]; NaN where the method does not compute them.
    """

    trajectory: Trajectory
    dissipated: float = math.nan
    stored: float = math.nan

    def at(self, times: ArrayLike | None) -> Trajectory:
        """Samples as they are, or joined by straight lines at the given times [s]."""
        if times is None:
            return self.trajectory
        knots = self.trajectory.time
        t = within_contact(times, float(knots[-1]))
        columns: dict[str, Any] = {
            name: None if values is None else np.interp(t, knots, values)
            for name, values in self.trajectory._asdict().items()
        }
        return Trajectory(**columns)


def by_elements(impact: Impact, n_elements: int | None, time_step: float | None) -> tuple[dict[str, Any], Sampled]:
    """Solve one impact by the paper's elements and explicit Euler; return outputs by name and the samples."""
    from restitution.impact.elements import solve_elements

    solution = solve_elements(impact, n_elements=800 if n_elements is None else n_elements, time_step=time_step)
    fields, trajectory = _in_si(solution, (1.0, 1.0, 1.0, 1.0, 1.0))
    return fields, Sampled(trajectory, float(solution.dissipated), float(solution.stored))


def by_reference(impact: Impact, rtol: float) -> tuple[dict[str, Any], Sampled]:
    """Solve one impact by the reduced equations through SciPy; return outputs by name and the samples."""
    from restitution.impact.reference import solve_reference

    row = Batch.from_impact(impact).scaled().row(0)
    profile = impact.profile

    def radius(s: Any) -> Any:
        return profile.contact_radius(np.asarray(s) ** 2 * row.length) / row.radius

    solution = solve_reference(row, rtol=rtol, contact_radius=None if row.table is None else radius)
    velocity = float(impact.velocity)
    force = float(impact.mass) * velocity / row.time
    fields, trajectory = _in_si(solution, (row.time, row.length, velocity, force, row.radius))
    return fields, Sampled(trajectory)


def _in_si(solution: Any, units: tuple[float, float, float, float, float]) -> tuple[dict[str, Any], Trajectory]:
    """Outputs and motion, given in units of time, length, velocity, force and contact radius."""
    time, length, velocity, force, radius = units
    trajectory = Trajectory(
        solution.time * time, solution.indentation_depth * length, solution.velocity * velocity,
        solution.force * force, solution.contact_radius * radius,
    )  # fmt: skip
    fields: dict[str, Any] = {
        "restitution_coefficient": solution.restitution_coefficient,
        "contact_time": solution.contact_time * time,
        "max_indentation_depth": solution.max_indentation_depth * length,
        "max_force": solution.max_force * force,
        "max_contact_radius": solution.max_contact_radius * radius,
        "residual_indentation_depth": solution.residual_indentation_depth * length,
        "status": int(solution.status),
    }
    return fields, trajectory
