"""The section of a case file on bounces, and the bounces of the body that the file describes."""

from __future__ import annotations

from typing import TYPE_CHECKING, Annotated

import numpy as np
from pydantic import StrictInt, model_validator

from restitution.case.quantity import LENGTH, nonnegative, refuse
from restitution.case.section import CaseError, Section

if TYPE_CHECKING:
    from restitution.case.file import Case
    from restitution.impact.bounces import Bounces
    from restitution.impact.problem import Impact


class BouncesSection(Section):
    """When a body that bounces is followed no further."""

    max_bounces: StrictInt = 1000
    min_height: Annotated[float, nonnegative(LENGTH)] | None = None

    @model_validator(mode="after")
    def _check(self) -> BouncesSection:
        if self.max_bounces < 1:
            refuse("must be >= 1", "max_bounces")
        return self


def bounces_of(case: Case) -> Bounces:
    """Bounces of the body of a case until it rests, under the gravity of the file.

    Its weight acts during contact too unless the file says `weight = false`. Where the file gives a velocity,
    it is that of the first touch.

    Parameters
    ----------
    case
        A case file.

    Raises
    ------
    CaseError
        If the file asks for a force other than the weight, or a method that does not bounce.
    SolverError
        If the solve of a bounce fails.
    """
    from restitution.case.schema import window_around

    impact, sections = case.sections.impact, case.sections
    if impact.force is not None:
        raise CaseError(f"{case.path}: impact.force: a body that bounces has its weight alone; give weight")
    if sections.solver.method != "exact":
        raise CaseError(
            f'{case.path}: solver.method = "{sections.solver.method}": bounces are solved by method = "exact"'
        )
    found = _found(case, case.impact)
    if sections.needs_window:
        # Slow bounces touch for longer than the first, for which the window was chosen.
        touches = found.contact_time[np.isfinite(found.contact_time)]
        if touches.size:
            low, high = window_around(float(touches.min())), window_around(float(touches.max()))
            found = _found(case, sections.build(low._replace(high=high.high)))
    return found


def _found(case: Case, impact: Impact) -> Bounces:
    from restitution.impact.bounces import bounces

    motion, section = case.sections.impact, case.sections.bounces
    rtol = case.sections.solver.rtol
    try:
        return bounces(
            impact,
            height=motion.drop_height,
            gravity=motion.gravity,
            with_weight=motion.weight is not False,
            max_bounces=section.max_bounces,
            min_height=section.min_height,
            **({} if rtol is None else {"rtol": rtol}),
        )
    except ValueError as error:
        where = "solver." if str(error).startswith("rtol") else ""
        raise CaseError(f"{case.path}: {where}{error}") from None
