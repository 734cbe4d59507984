"""Shape and numbers of what is solved at once: one impact, an array of impacts, or a list."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING

import numpy as np

from restitution.checks import Numeric

if TYPE_CHECKING:
    from restitution.impact.problem import Impact


def shape_of(impact: Impact | list[Impact]) -> tuple[int, ...]:
    """Return the shape of the results of an impact or of a list."""
    return (len(impact),) if isinstance(impact, list) else impact.shape


def single_of(impact: Impact | list[Impact], place: int) -> Impact:
    """Return the impact at a place of the raveled shape."""
    if isinstance(impact, list):
        return impact[place]
    return impact.take(np.asarray(place)) if impact.shape else impact


def of_each(impact: Impact | list[Impact], numbers: Callable[[Impact], Sequence[Numeric]]) -> list[Numeric]:
    """Return some numbers of an array of impacts, or columns of those of each impact of a list."""
    if isinstance(impact, list):
        return [np.array(column, dtype=np.float64) for column in zip(*map(numbers, impact), strict=True)]
    return list(numbers(impact))
