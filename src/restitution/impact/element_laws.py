"""What one element of the foundation does: the paper's standard solid, and any Prony series.

All quantities are per unit length of the foundation, arrays over the elements; an explicit Euler step each.
"""

from __future__ import annotations

import math
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from restitution.material.prony import PronySeries
from restitution.material.viscoelastic import Material

Array = NDArray[np.float64]


class ElementLaw(Protocol):
    """Inner state of the elements, with room for as many as `grow` has made."""

    def grow(self, size: int) -> None:
        """Make room for `size` elements; new ones are undeformed."""
        ...

    def advance(self, u: Array, du: Array, step: float) -> None:
        """Step the inner state by `step` [s] to the displacements u [m], which have grown by du [m]."""
        ...

    def line_load(self, u: Array, v: float) -> Array:
        """Force per length [N/m] at the displacements u [m] and the velocity v [m/s]."""
        ...

    def dissipation(self, u: Array, v: float) -> Array:
        """Power per length [W/m] that the dashpots dissipate."""
        ...

    def energy(self, u: Array) -> Array:
        """Energy per length [J/m] that the springs store."""
        ...

    def inner(self, n: int) -> dict[str, Array]:
        """Inner displacements [m] of the first n elements, by name."""
        ...


class StandardSolidElement:
    """Equations (8) of the paper: standard solid in shear, elastic in bulk.

    Parameters
    ----------
    equilibrium_modulus : float
        Ginf [Pa].
    branch_modulus : float
        G1 [Pa].
    viscosity : float
        eta [Pa s].
    bulk_modulus : float
        K0 [Pa]; infinite for the incompressible form, in which `u2 = u`.

    Notes
    -----
    Ginf beside G1 and eta in series carries the displacement u2; in series with that, K0 + Ginf/3 beside G1/3
    and eta/3 in series carries u - u2::

        0 = eta (u3' - u2') + G1 u3
        0 = (eta/3)(u1' - u') + (G1/3)(u1 - u2)
        0 = G1 u3 + Ginf u2 + (Ginf/3 + K0)(u2 - u) + (G1/3)(u2 - u1)
        F/dx = 4 (Ginf u2 + G1 u3)
    """

    def __init__(
        self, equilibrium_modulus: float, branch_modulus: float, viscosity: float, bulk_modulus: float
    ) -> None:
        self.ginf, self.g1, self.eta, self.k0 = equilibrium_modulus, branch_modulus, viscosity, bulk_modulus
        self.u1 = self.u2 = self.u3 = np.zeros(0)

    def grow(self, size: int) -> None:
        """Make room for `size` elements."""
        self.u1, self.u2, self.u3 = (padded(x, size) for x in (self.u1, self.u2, self.u3))

    def advance(self, u: Array, du: Array, step: float) -> None:
        """Step u1, u2, u3 in time."""
        n, ginf, g1, k0 = u.size, self.ginf, self.g1, self.k0
        u1, u2, u3 = self.u1[:n], self.u2[:n], self.u3[:n]
        # From the first of (8), u3 = u2 + lag after the step; from the second, u1; then, from the third, u2.
        lag = u3 - u2 - (step * g1 / self.eta) * u3
        u1 += du - (step * g1 / self.eta) * (u1 - u2)
        if math.isinf(k0):
            u2[:] = u
        else:
            stiffness = g1 + ginf + (ginf / 3.0 + k0) + g1 / 3.0
            u2[:] = ((ginf / 3.0 + k0) * u + (g1 / 3.0) * u1 - g1 * lag) / stiffness
        u3[:] = u2 + lag

    def line_load(self, u: Array, v: float) -> Array:
        """Force per length 4 (Ginf u2 + G1 u3)."""
        n = u.size
        return 4.0 * (self.ginf * self.u2[:n] + self.g1 * self.u3[:n])

    def dissipation(self, u: Array, v: float) -> Array:
        """Power per length of the dashpots eta and eta/3."""
        n = u.size
        power = self.u3[:n] ** 2
        if not math.isinf(self.k0):
            power += (self.u1[:n] - self.u2[:n]) ** 2 / 3.0
        return (4.0 * self.g1**2 / self.eta) * power

    def energy(self, u: Array) -> Array:
        """Energy per length of the five springs."""
        n = u.size
        u1, u2, u3 = self.u1[:n], self.u2[:n], self.u3[:n]
        energy = self.g1 * u3**2 + self.ginf * u2**2
        if not math.isinf(self.k0):
            energy += (self.ginf / 3.0 + self.k0) * (u2 - u) ** 2 + (self.g1 / 3.0) * (u2 - u1) ** 2
        return 2.0 * energy

    def inner(self, n: int) -> dict[str, Array]:
        """Displacements u1, u2, u3."""
        return {"u1": self.u1[:n].copy(), "u2": self.u2[:n].copy(), "u3": self.u3[:n].copy()}


class MaxwellElement:
    """Spring, dashpot and Maxwell branches in parallel, which are the reduced relaxation modulus.

    Parameters
    ----------
    series : PronySeries
        Reduced relaxation modulus E*(t) [Pa].

    Notes
    -----
    ::

        w_k' = u' - w_k/tau_k,        F/dx = E_inf u + viscosity u' + sum E_k w_k
    """

    def __init__(self, series: PronySeries) -> None:
        self.equilibrium, self.viscosity = series.equilibrium_modulus, series.parallel_viscosity
        self.moduli, self.times = series.branch_moduli, series.relaxation_times[:, None]
        self.w = np.zeros((self.moduli.size, 0))

    def grow(self, size: int) -> None:
        """Make room for `size` elements."""
        self.w = padded(self.w, size)

    def advance(self, u: Array, du: Array, step: float) -> None:
        """Step w_k in time."""
        w = self.w[:, : u.size]
        w += du - (step / self.times) * w

    def line_load(self, u: Array, v: float) -> Array:
        """Force per length of spring, dashpot and branches."""
        return self.equilibrium * u + self.viscosity * v + self.moduli @ self.w[:, : u.size]

    def dissipation(self, u: Array, v: float) -> Array:
        """Power per length of all dashpots."""
        return self.viscosity * v**2 + (self.moduli / self.times[:, 0]) @ self.w[:, : u.size] ** 2

    def energy(self, u: Array) -> Array:
        """Energy per length of all springs."""
        return 0.5 * (self.equilibrium * u**2 + self.moduli @ self.w[:, : u.size] ** 2)

    def inner(self, n: int) -> dict[str, Array]:
        """Return nothing: the branches have no place in the paper's element."""
        return {}


def element_law(material: Material, counter_material: Material | None, series: PronySeries) -> ElementLaw:
    """Return the paper's element where the material is the paper's, and else that of the reduced modulus."""
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
    more = np.zeros((*array.shape[:-1], size - array.shape[-1]), dtype=array.dtype)
    return np.concatenate([array, more], axis=-1)
