"""Contact radius of the first approach over the depth, and its integral, from the constants of a law."""

import math

from numpy.typing import NDArray

from restitution.kernel.compile import compiled
from restitution.law.nodes import (
    BRANCHES,
    CELLS,
    COEFFICIENT,
    CONSTANTS,
    EXPONENT,
    INTEGRAL_TERMS,
    RADIUS_TERMS,
)


@compiled
def table_value(law: NDArray, depth: float, terms: int, before: int) -> float:
    """Value of the piecewise polynomials of `terms` coefficients that follow those of `before` coefficients."""
    branches = int(law[BRANCHES])
    cells = int(law[CELLS])
    ends = law[CONSTANTS + 2 * branches :]
    place = math.sqrt(depth)
    low = 0
    high = cells
    while high - low > 1:
        middle = (low + high) // 2
        if place < ends[middle]:
            high = middle
        else:
            low = middle
    cell = ends[cells + 1 + 3 * low :]
    if cell[0] >= 0.0:
        place = math.sqrt(max(place - cell[0], 0.0))
    place = (place - cell[1]) / cell[2]
    coefficients = ends[cells + 1 + (3 + before) * cells + terms * low :]
    value = 0.0
    for n in range(terms):
        value = value * place + coefficients[terms - 1 - n]
    return value


@compiled
def radius_at(law: NDArray, depth: float) -> float:
    """Contact radius of the first approach at a depth >= 0."""
    exponent = law[EXPONENT]
    if exponent == 1.0:
        return law[COEFFICIENT] * math.sqrt(depth)
    if exponent == 0.0:
        return law[COEFFICIENT]
    if exponent == 2.0:
        return law[COEFFICIENT] * depth
    if exponent > 0.0:
        return law[COEFFICIENT] * math.pow(depth, 0.5 * exponent)
    return table_value(law, depth, RADIUS_TERMS, 0)


@compiled
def integral_at(law: NDArray, depth: float) -> float:
    """Integral of the contact radius over the depth, from 0 to a depth >= 0."""
    exponent = law[EXPONENT]
    if exponent >= 0.0:
        return 2.0 / (exponent + 2.0) * depth * radius_at(law, depth)
    return table_value(law, depth, INTEGRAL_TERMS, RADIUS_TERMS)
