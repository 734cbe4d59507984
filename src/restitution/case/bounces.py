"""The section of a case file on bounces, and the bounces of the body that the file describes."""

from __future__ import annotations

from typing import TYPE_CHECKING, Annotated

from pydantic import StrictInt, model_validator

from restitution.case.quantity import LENGTH, nonnegative, refuse
from restitution.case.section import CaseError, Section

if TYPE_CHECKING:
    from restitution.case.file import Case
    from restitution.impact.bounces import Bounces


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
    from restitution.impact.bounces import bounces
    from restitution.impact.window import for_contact

    motion, sections = case.sections.impact, case.sections
    if motion.external_force is not None:
        raise CaseError(
            f"{case.path}: impact.external_force: a body that bounces has its weight alone; give weight"
        )
    if sections.solver.method != "exact":
        raise CaseError(
            f'{case.path}: solver.method = "{sections.solver.method}": bounces are solved by method = "exact"'
        )
    impact = case.impact
    if sections.needs_window:
        # What a touch leaves has the time of a flight to recover.
        impact = for_contact(sections.build, longest=2.0 * motion.impact_velocity / motion.gravity)
    rtol = sections.solver.rtol
    try:
        return bounces(
            impact,
            height=motion.drop_height,
            gravity=motion.gravity,
            with_weight=motion.weight is not False,
            max_bounces=sections.bounces.max_bounces,
            min_height=sections.bounces.min_height,
            **({} if rtol is None else {"rtol": rtol}),
        )
    except ValueError as error:
        where = "solver." if str(error).startswith("rtol") else ""
        raise CaseError(f"{case.path}: {where}{error}") from None
