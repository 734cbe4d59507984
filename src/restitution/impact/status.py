"""Status of a solve, and the error of a failed one."""

from collections.abc import Sequence

from restitution.kernel import outcome
from restitution.result import Outcome


class Status(Outcome):
    """End of an impact; `message` explains it, with a remedy for a failure."""

    SEPARATED = outcome.SEPARATED, "the body separated; the result is within the tolerance"
    SINKS_IN = (
        outcome.SINKS_IN,
        "the material is a liquid at long times; the body sinks in, with less than 1e-6 of its velocity: e = 0",
    )
    CAPTURED = (
        outcome.CAPTURED,
        "adhesion, the constant force, or a target that leaves the body less than 1e-6 of its velocity, holds it: "
        "e = 0",
    )
    TOO_MANY_STEPS = (
        outcome.TOO_MANY_STEPS,
        "the step limit was reached before separation; loosen rtol or check for extreme relaxation times",
    )
    STEP_TOO_SMALL = (
        outcome.STEP_TOO_SMALL,
        "the step size fell to rounding level; loosen rtol or check for extreme relaxation times",
    )
    NOT_FINITE = (
        outcome.NOT_FINITE,
        "a number overflowed or lost its digits; check for extreme moduli, masses, velocities or relaxation times",
    )
    NOT_ACCURATE = outcome.NOT_ACCURATE, "the requested tolerance was not reached; loosen rtol"
    TOO_DEEP = outcome.TOO_DEEP, "the indentation is deeper than the profile; extend the profile"
    INADMISSIBLE = (
        outcome.INADMISSIBLE,
        "the numbers of this impact are out of range; check the combination of values along the axes",
    )

    @property
    def failed(self) -> bool:
        """Whether there is no trustworthy result."""
        return self >= Status.TOO_MANY_STEPS


class SolverError(RuntimeError):
    """Error of a solve without a trustworthy result; its attribute `status` is the reason.

    A `cause` takes the place of the message of the status, where another remedy helps.
    """

    def __init__(self, status: Status, detail: str = "", *, cause: str = "") -> None:
        super().__init__(f"{status.name}: {cause or status.message}" + (f" ({detail})" if detail else ""))
        self.status = status


def failures(counts: Sequence[int], total: int) -> str:
    """Return how many of `total` impacts failed and why, from the count of each status; empty if none failed."""
    failed = [status for status in Status if counts[status] and status.failed]
    listed = ", ".join(f"{counts[status]} {status.name}" for status in failed)
    number = sum(counts[status] for status in failed)
    return f"{number} of {total} impacts failed and are NaN: {listed}" if failed else ""
