"""Laws of one element of the foundation: the paper's standard solid, and any Prony series.

Both classes hold the inner state of all elements as arrays and have the same methods. Forces, energies and powers are
per unit length of the foundation. `advance` is one step of explicit Euler.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from numpy.typing import NDArray

from restitution.material.prony import PronySeries
from restitution.material.viscoelastic import Material

Array = NDArray[np.float64]


class StandardSolidElement:
    """Equations (8) of the paper, see `restitution.impact.elements`: standard solid in shear, elastic in bulk.

    Ginf parallel to G1 and eta in series has the displacement u2. In series with that, K0 + Ginf/3 parallel to G1/3
    and eta/3 in series has the displacement u - u2; for an infinite K0, `u2 = u`.
    """

    def __init__(self, ginf: float, g1: float, eta: float, k0: float) -> None:
        self.ginf, self.g1, self.eta, self.k0 = ginf, g1, eta, k0
        self.u1 = self.u2 = self.u3 = np.zeros(0)

    def grow(self, size: int) -> None:
        """Make room for `size` elements; new ones are undeformed."""
        self.u1, self.u2, self.u3 = (padded(x, size) for x in (self.u1, self.u2, self.u3))

    def advance(self, u: Array, du: Array, step: float) -> None:
        """Advance u1, u2, u3 by a step [s] to the displacements u [m], which have grown by du [m]."""
        n, ginf, g1, k0 = u.size, self.ginf, self.g1, self.k0
        u1, u2, u3 = self.u1[:n], self.u2[:n], self.u3[:n]
        # The first of (8) gives u3 = u2 + lag after the step, the second u1, and the third then u2.
        lag = u3 - u2 - (step * g1 / self.eta) * u3
        u1 += du - (step * g1 / self.eta) * (u1 - u2)
        if math.isinf(k0):
            u2[:] = u
        else:
            stiffness = g1 + ginf + (ginf / 3.0 + k0) + g1 / 3.0
            u2[:] = ((ginf / 3.0 + k0) * u + (g1 / 3.0) * u1 - g1 * lag) / stiffness
        u3[:] = u2 + lag

    def line_load(self, u: Array, v: float) -> Array:
        """Force per length 4 (Ginf u2 + G1 u3) [N/m] at the displacements u [m] and the velocity v [m/s]."""
        n = u.size
        return 4.0 * (self.ginf * self.u2[:n] + self.g1 * self.u3[:n])

    def dissipation(self, u: Array, v: float) -> Array:
        """Power per length [W/m] that the dashpots eta and eta/3 dissipate."""
        n = u.size
        power = self.u3[:n] ** 2
        if not math.isinf(self.k0):
            power += (self.u1[:n] - self.u2[:n]) ** 2 / 3.0
        return (4.0 * self.g1**2 / self.eta) * power

    def energy(self, u: Array) -> Array:
        """Energy per length [J/m] of the five springs."""
        n = u.size
        u1, u2, u3 = self.u1[:n], self.u2[:n], self.u3[:n]
        energy = self.g1 * u3**2 + self.ginf * u2**2
        if not math.isinf(self.k0):
            energy += (self.ginf / 3.0 + self.k0) * (u2 - u) ** 2 + (self.g1 / 3.0) * (u2 - u1) ** 2
        return 2.0 * energy

    def inner(self, n: int) -> dict[str, Array]:
        """Inner displacements [m] of the first n elements by name."""
        return {"u1": self.u1[:n].copy(), "u2": self.u2[:n].copy(), "u3": self.u3[:n].copy()}


class MaxwellElement:
    """Spring, dashpot and Maxwell branches in parallel: the reduced relaxation modulus E*(t).

    With `w_k' = u' - w_k/tau_k` the force is `F/dx = E_inf u + viscosity u' + sum E_k w_k`.
    """

    def __init__(self, series: PronySeries) -> None:
        self.equilibrium, self.viscosity = series.equilibrium_modulus, series.parallel_viscosity
        self.moduli, self.times = series.branch_moduli, series.relaxation_times[:, None]
        self.w = np.zeros((self.moduli.size, 0))

    def grow(self, size: int) -> None:
        """Make room for `size` elements; new ones are undeformed."""
        self.w = padded(self.w, size)

    def advance(self, u: Array, du: Array, step: float) -> None:
        """Advance w_k by a step [s] in which the displacements u grow by du [m]."""
        w = self.w[:, : u.size]
        w += du - (step / self.times) * w

    def line_load(self, u: Array, v: float) -> Array:
        """Force per length [N/m] of spring, dashpot and branches."""
        return self.equilibrium * u + self.viscosity * v + self.moduli @ self.w[:, : u.size]

    def dissipation(self, u: Array, v: float) -> Array:
        """Power per length [W/m] that all dashpots dissipate."""
        return self.viscosity * v**2 + (self.moduli / self.times[:, 0]) @ self.w[:, : u.size] ** 2

    def energy(self, u: Array) -> Array:
        """Energy per length [J/m] of all springs."""
        return 0.5 * (self.equilibrium * u**2 + self.moduli @ self.w[:, : u.size] ** 2)

    def inner(self, n: int) -> dict[str, Array]:
        """Return nothing: the paper's element has no such branches."""
        return {}


def element_law(
    material: Material, counter_material: Material | None, series: PronySeries
) -> StandardSolidElement | MaxwellElement:
    """Return the paper's element for the paper's material, and the element of the reduced modulus for any other."""
    shear, bulk = material.shear.simplified(), material.bulk
    rigid, relaxing = counter_material is None, isinstance(bulk, PronySeries) and not bulk.is_elastic
    if not rigid or relaxing or shear.n_branches != 1 or shear.parallel_viscosity > 0.0:
        return MaxwellElement(series)
    branch = float(shear.branch_moduli[0])
    viscosity = branch * float(shear.relaxation_times[0])
    k0 = bulk.equilibrium_modulus if isinstance(bulk, PronySeries) else math.inf
    return StandardSolidElement(shear.equilibrium_modulus, branch, viscosity, k0)


def padded(array: NDArray[Any], size: int) -> NDArray[Any]:
    """Return the array with zeros added to its last axis up to `size`."""
    return np.pad(array, [(0, 0)] * (array.ndim - 1) + [(0, size - array.shape[-1])])
