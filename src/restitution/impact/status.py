"""Status of a solve, and the error of a failed one."""

from collections.abc import Sequence
from enum import IntEnum

from restitution.kernel import outcome


class Status(IntEnum):
    """End of an impact; `message` explains it, with a remedy for a failure."""

    SEPARATED = outcome.SEPARATED
    SINKS_IN = outcome.SINKS_IN
    CAPTURED = outcome.CAPTURED
    TOO_MANY_STEPS = outcome.TOO_MANY_STEPS
    STEP_TOO_SMALL = outcome.STEP_TOO_SMALL
    NOT_FINITE = outcome.NOT_FINITE
    NOT_ACCURATE = outcome.NOT_ACCURATE
    TOO_DEEP = outcome.TOO_DEEP
    INADMISSIBLE = outcome.INADMISSIBLE

    @property
    def message(self) -> str:
        """Explanation and, for a failure, the remedy."""
        return _MESSAGES[self]

    @property
    def failed(self) -> bool:
        """Whether there is no trustworthy result."""
        return self >= Status.TOO_MANY_STEPS


_MESSAGES = {
    Status.SEPARATED: "the body separated; the result is within the tolerance",
    Status.SINKS_IN: (
        "the material is a liquid at long times; the body sinks in, with less than 1e-6 of its velocity: e = 0"
    ),
    Status.CAPTURED: (
        "the constant force, or a target that leaves the body less than 1e-6 of its velocity, holds it: e = 0"
    ),
    Status.TOO_MANY_STEPS: (
        "the step limit was reached before separation; loosen rtol or check for extreme relaxation times"
    ),
    Status.STEP_TOO_SMALL: "the step size fell to rounding level; loosen rtol or check for extreme relaxation times",
    Status.NOT_FINITE: (
        "a number overflowed or lost its digits; check for extreme moduli, masses, velocities or relaxation times"
    ),
    Status.NOT_ACCURATE: "the requested tolerance was not reached; loosen rtol",
    Status.TOO_DEEP: "the indentation is deeper than the profile; extend the profile",
    Status.INADMISSIBLE: "the numbers of this impact are out of range; check the combination of values along the axes",
}


class SolverError(RuntimeError):
    """Error of a solve without a trustworthy result; its attribute `status` is the reason."""

    def __init__(self, status: Status, detail: str = "") -> None:
        super().__init__(f"{status.name}: {status.message}" + (f" ({detail})" if detail else ""))
        self.status = status


def failures(counts: Sequence[int], total: int) -> str:
    """Return how many of `total` impacts failed and why, from the count of each status; empty if none failed."""
    failed = [status for status in Status if status.failed and counts[status]]
    listed = ", ".join(f"{counts[status]} {status.name}" for status in failed)
    number = sum(counts[status] for status in failed)
    return f"{number} of {total} impacts failed and are NaN: {listed}" if failed else ""
