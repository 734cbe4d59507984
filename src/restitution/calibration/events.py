"""Law of event-driven and N-body codes, which take the coefficient of restitution over velocity itself: REBOUND."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from restitution.calibration.collisions import Collisions

Array = NDArray[np.float64]

REBOUND = "rebound"
WORDS = "REBOUND, coefficient_of_restitution of collision_resolve = hardsphere"
SOURCE = "REBOUND documentation, page Collisions"

SNIPPET = """\
import numpy as np

VELOCITY = np.array([{velocity}])
RESTITUTION = np.array([{restitution}])


def coefficient_of_restitution(simulation, velocity):
    return float(np.interp(np.log(abs(velocity) + 1e-300), np.log(VELOCITY), RESTITUTION))


sim.collision_resolve = "hardsphere"
sim.coefficient_of_restitution = coefficient_of_restitution
"""


@dataclass(frozen=True, eq=False)
class TableLaw:
    """Coefficients of restitution over velocity [m/s], between which the code interpolates over log v."""

    velocity: Array
    restitution_coefficient: Array

    def rebound(self, velocity: Any, mass: Any, radius: Any) -> tuple[Array, Array]:
        """Coefficient of restitution [-] and contact time [s], which is zero, at v0 [m/s]."""
        shape = np.broadcast_shapes(np.shape(velocity), np.shape(mass), np.shape(radius))
        e = np.interp(np.log(velocity), np.log(self.velocity), self.restitution_coefficient)
        return np.broadcast_to(e, shape), np.zeros(shape)

    @property
    def text(self) -> str:
        """The snippet."""
        columns = self.velocity, self.restitution_coefficient
        return SNIPPET.format(**{
            name: ", ".join(f"{x:.8g}" for x in column)
            for name, column in zip(("velocity", "restitution"), columns, strict=True)
        })  # fmt: skip


def table(wanted: Collisions) -> TableLaw:
    """Return the table nearest to collisions: for several radii the middle, by ratios, at each velocity."""
    e = wanted.restitution_coefficient
    return TableLaw(wanted.velocity, np.sqrt(e.min(axis=1) * e.max(axis=1)))
