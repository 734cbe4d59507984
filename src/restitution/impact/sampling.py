"""Methods that follow one impact in steps: what they leave, in SI."""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np

from restitution.impact.batch import Batch
from restitution.impact.history import Trajectory
from restitution.impact.problem import Impact
from restitution.impact.result import EnergyBudget


class Sampled(NamedTuple):
    """One impact, and the motion that was sampled.

    Attributes
    ----------
    fields : dict of str to float
        Members of an `ImpactResult`, and the status.
    trajectory : Trajectory
        The samples.
    dissipated, stored : float
        Energies [J]; NaN where the method does not find them.
    impact : Impact
    """

    fields: dict[str, Any]
    trajectory: Trajectory
    dissipated: float
    stored: float
    impact: Impact

    def budget(self) -> EnergyBudget:
        """Where the energy went."""
        kinetic = 0.5 * float(self.impact.mass) * float(self.impact.velocity) ** 2
        out = kinetic * self.fields["restitution_coefficient"] ** 2
        work = float(self.impact.external_force) * self.fields["residual_indentation_depth"]
        residual = (out + self.dissipated + self.stored - kinetic - work) / kinetic
        return EnergyBudget(kinetic, out, self.dissipated, self.stored, residual)


def by_elements(impact: Impact, n_elements: int | None, time_step: float | None) -> Sampled:
    """Solve one impact by the paper's elements and explicit Euler."""
    from restitution.impact.elements import solve_elements

    solution = solve_elements(
        impact, n_elements=800 if n_elements is None else n_elements, time_step=time_step
    )
    return _sampled(impact, solution, (1.0, 1.0, 1.0, 1.0, 1.0), solution.dissipated, solution.stored)


def by_reference(impact: Impact, rtol: float) -> Sampled:
    """Solve one impact by the reduced equations through SciPy."""
    from restitution.impact.reference import solve_reference

    row = Batch.from_impact(impact).scaled().row(0)
    profile = impact.profile

    def radius(s: Any) -> Any:
        return profile.contact_radius(np.asarray(s) ** 2 * row.length) / row.radius

    solution = solve_reference(row, rtol=rtol, contact_radius=None if row.table is None else radius)
    force = float(impact.mass) * float(impact.velocity) / row.time
    units = (row.time, row.length, float(impact.velocity), force, row.radius)
    return _sampled(impact, solution, units, math.nan, math.nan)


def _sampled(
    impact: Impact,
    solution: Any,
    units: tuple[float, float, float, float, float],
    dissipated: float,
    stored: float,
) -> Sampled:
    """Motion given in units of time, length, velocity, force and contact radius."""
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
    return Sampled(fields, trajectory, float(dissipated), float(stored), impact)
