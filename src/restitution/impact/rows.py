"""Many impacts as columns of plain numbers, and what came of them in SI."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from restitution.impact.exact import Progress, outcome_columns, solve_scaled
from restitution.impact.scaling import ScaledBlock, power_block
from restitution.impact.status import Status

Array = NDArray[np.float64]

# The energy comes from a finer solve, so that its own quadrature does not hide the error of the reported one.
_BUDGET_REFINEMENT = 1e-2


class Rows(NamedTuple):
    """Impacts of rigid or deformable bodies with one kind of power-type profile, a row each; SI.

    Attributes
    ----------
    equilibria, viscosities : array, shape (n,)
        Of the reduced modulus E*(t) [Pa], [Pa s].
    moduli, times : array, shape (n, n_branch)
        Its branch moduli [Pa] and relaxation times [s].
    coefficients : array, shape (n,)
        c [m^(1 - p/2)] of the contact radius a = c s^p, s = sqrt(d).
    exponent : float
        p.
    masses, velocities, forces : array, shape (n,)
        [kg], [m/s], [N].
    """

    equilibria: Array
    viscosities: Array
    moduli: Array
    times: Array
    coefficients: Array
    exponent: float
    masses: Array
    velocities: Array
    forces: Array


def join_rows(parts: list[Rows]) -> Rows:
    """Put rows of one exponent and one number of branches together."""
    if len(parts) == 1:
        return parts[0]
    columns = [
        parts[0].exponent if name == "exponent" else np.concatenate([getattr(part, name) for part in parts])
        for name in Rows._fields
    ]
    return Rows(*columns)  # pyright: ignore[reportArgumentType]


def solve_rows(
    rows: Rows,
    rtol: float,
    *,
    workers: int | None = None,
    progress: Progress | None = None,
    energy: bool = False,
) -> dict[str, Array]:
    """Solve impacts given as columns by the exact method.

    Parameters
    ----------
    rows : Rows
        The impacts.
    rtol : float
        The error of e stays below `rtol max(e, 1e-3)`.
    workers : int, optional
        Threads; all cores where left out. The results do not depend on it.
    progress : callable, optional
        Called with (impacts done, all impacts).
    energy : bool
        Whether to add the columns of `energy_columns`, which take a second, finer solve.

    Returns
    -------
    dict of str to array, shape (n,)
        The columns of `si_columns`.
    """
    block = power_block(*rows)
    outcomes = solve_scaled(block, rtol, workers=workers, progress=progress)
    columns = si_columns(outcomes, block, rows.masses, rows.velocities)
    if energy:
        given = rows.masses, rows.velocities, rows.forces
        columns |= energy_columns(block, rtol, *given, columns["restitution_coefficient"], workers)
    return columns


def si_columns(outcomes: Array, block: ScaledBlock, mass: Array, velocity: Array) -> dict[str, Array]:
    """Turn the outcomes of a block into SI, by name; NaN where there is no result."""
    columns = outcome_columns(outcomes)
    statuses = columns["status"]
    stays = (statuses == Status.SINKS_IN) | (statuses == Status.CAPTURED)
    return {
        "restitution_coefficient": columns["restitution_coefficient"],
        "contact_time": np.where(stays, np.inf, columns["contact_time"] * block.time),
        "max_indentation_depth": columns["max_indentation_depth"] * block.length,
        "max_force": columns["max_force"] * mass * velocity / block.time,
        "max_contact_radius": columns["max_contact_radius"] * block.radius,
        "residual_indentation_depth": columns["residual_indentation_depth"] * block.length,
        "status": statuses,
    }


def energy_columns(
    block: ScaledBlock,
    rtol: float,
    mass: Array,
    velocity: Array,
    force: Array,
    restitution: Array,
    workers: int | None,
) -> dict[str, Array]:
    """Energy budget [J] of solved impacts, from a finer solve; `restitution` is what was reported."""
    finer = max(rtol * _BUDGET_REFINEMENT, 1e-13)
    outcomes = solve_scaled(block, finer, workers=workers, budget=True)
    # Rounding may keep the finer solve from its end; the residual of the reported one is as honest.
    for n in np.flatnonzero((outcomes[:, 7] >= Status.TOO_MANY_STEPS) & np.isfinite(restitution)):
        outcomes[n] = solve_scaled(block.part(int(n), int(n) + 1), rtol, workers=1, budget=True)[0]
    # A row that failed is NaN, or too large to be squared.
    with np.errstate(invalid="ignore", over="ignore"):
        kinetic = 0.5 * mass * velocity**2
        dissipated, stored = 2.0 * kinetic * outcomes[:, -2], 2.0 * kinetic * outcomes[:, -1]
        out = kinetic * restitution**2
        work = force * outcomes[:, 5] * block.length
        residual = (out + dissipated + stored - kinetic - work) / kinetic
    return {
        "kinetic_in": kinetic,
        "kinetic_out": out,
        "dissipated": dissipated,
        "stored": stored,
        "residual": residual,
    }
