"""Control of Newton's method and of the length of elements, for approach and rebound."""

import math

from restitution.kernel.compile import inlined

# Verdict on a step of Newton's method: next a chord step, next a step with new inverses, or the end.
CHORD, FACTOR, CONVERGED, DIVERGED = range(4)

_SLOW = 0.25  # contraction from which new inverses cost less than more chord steps
_MOST_CHORDS = 6.0  # chord steps ahead from which new inverses cost less
_WORST = 0.9  # largest contraction for the estimate of the remaining error
# A chord step diverges if it is longer than the last by the first factor and larger than the second number.
_GROWTH, _LARGE = 2.0, 1e-3
_SAFETY = 0.75  # factor on the length according to the tail
_MOST, _LEAST = 6.0, 0.1  # largest and smallest change of the length at once
_NO_ERROR = 1e-30
ON_FAILURE = 0.3  # factor of the length if Newton's method fails


@inlined
def newton_verdict(
    size: float, previous: float, drift: float, full_step: bool, renewed: bool, rounding: float, accept: float
) -> int:
    """Judge a step of relative size `size` after one of size `previous`.

    Chord steps with old inverses contract no faster than the drift of the unknown since the inverses were computed,
    which the first step may hide. After a full step only its size is available. New inverses cost less than many chord
    steps that contract slowly. Steps below `rounding` that do not
    shrink with renewed inverses are rounding.
    """
    contraction = max(size / previous, drift)
    remaining = size if full_step else size * contraction / (1.0 - min(contraction, _WORST))
    slow = size > _SLOW * previous
    if remaining <= accept or (slow and renewed and size < rounding):
        return CONVERGED
    if full_step:
        return CHORD
    if size > _GROWTH * previous and size > _LARGE:
        return DIVERGED
    many = size * (size / previous) ** _MOST_CHORDS > accept
    return FACTOR if slow or many else CHORD


@inlined
def shrunk(error: float, exponent: float) -> float:
    """Factor of the length of an element whose error over the tolerance is above 1 or not a number."""
    return max(_LEAST, _SAFETY * error**exponent) if error < math.inf else _LEAST


@inlined
def grown(error: float, exponent: float) -> float:
    """Factor of the length from an accepted element to the next."""
    return min(_MOST, _SAFETY * max(error, _NO_ERROR) ** exponent)
