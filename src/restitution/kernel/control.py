"""Control of Newton's method and of the length of elements, the same for approach and rebound."""

import math

from restitution.kernel.compile import inlined

# What follows a step of Newton's method: a chord step, one with new inverses, or the end.
CHORD, FACTOR, CONVERGED, DIVERGED = range(4)

# Contraction from which new inverses are cheaper than more chord steps, and the worst that is believed.
_SLOW, _WORST = 0.25, 0.9
# A chord step so much longer than the last, and of such a size, will not come back.
_GROWTH, _LARGE = 2.0, 1e-3
# Share of the length that the tail asks for; the most that a length grows or shrinks by at once; least error.
_SAFETY, _MOST, _LEAST, _NO_ERROR = 0.75, 6.0, 0.1, 1e-30
# Factor of the length where Newton's method fails.
ON_FAILURE = 0.3


@inlined
def newton_verdict(
    size: float, previous: float, drift: float, full_step: bool, renewed: bool, rounding: float, accept: float
) -> int:
    """Judge a step of relative size `size` after one of size `previous`.

    Chord steps, with old inverses, contract no faster than the unknown has drifted since these were made, which the
    first one may hide. After a full step its size alone is known. Steps below `rounding` that do not shrink, although
    the inverses were renewed there, are rounding.
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
    return FACTOR if slow else CHORD


@inlined
def shrunk(error: float, exponent: float) -> float:
    """Factor of the length of an element whose error, over what is allowed, is above 1 or not a number."""
    return max(_LEAST, _SAFETY * error**exponent) if error < math.inf else _LEAST


@inlined
def grown(error: float, exponent: float) -> float:
    """Factor from an element that was accepted to the next."""
    return min(_MOST, _SAFETY * max(error, _NO_ERROR) ** exponent)
