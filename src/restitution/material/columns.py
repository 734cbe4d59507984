"""Many materials as columns of numbers, one material in each row."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import Any, Literal, NamedTuple

import numpy as np
from numpy.typing import NDArray

from restitution.errors import InputError
from restitution.material.conversion import bulk_factor, tension_from_shear
from restitution.material.prony import PronySeries
from restitution.material.viscoelastic import Material, reduced_modulus

Array = NDArray[np.float64]


class PronyColumns(NamedTuple):
    """Prony series of n materials; the first four columns of `restitution.impact.batch.Batch`."""

    equilibria: Array  # [Pa], shape (n,)
    viscosities: Array  # of a dashpot in parallel [Pa s], shape (n,)
    moduli: Array  # [Pa], shape (n, n_branch); 0 where there is no branch
    times: Array  # [s], shape (n, n_branch)

    @classmethod
    def stacked(cls, series: Sequence[PronySeries]) -> PronyColumns:
        """Columns of series that may differ in the number of branches."""
        most = max((one.n_branches for one in series), default=0)
        moduli, times = np.zeros((len(series), most)), np.ones((len(series), most))
        for n, one in enumerate(series):
            moduli[n, : one.n_branches], times[n, : one.n_branches] = one.branch_moduli, one.relaxation_times
        equilibria = np.array([one.equilibrium_modulus for one in series], dtype=np.float64)
        viscosities = np.array([one.parallel_viscosity for one in series], dtype=np.float64)
        return cls(equilibria, viscosities, moduli, times)

    @property
    def size(self) -> int:
        """Number of materials."""
        return self.equilibria.size

    def take(self, rows: Any) -> PronyColumns:
        """Columns of the materials with these numbers, which may repeat."""
        return PronyColumns(*(column[rows] for column in self))

    def repeated(self, n: int) -> PronyColumns:
        """Views of one material's columns as those of n materials."""
        return self if n == 1 else PronyColumns(*(np.broadcast_to(one, (n, *one.shape[1:])) for one in self))

    def row(self, n: int) -> PronySeries:
        """Series of material n."""
        there = self.moduli[n] > 0.0
        return PronySeries(
            float(self.equilibria[n]), self.moduli[n, there], self.times[n, there],
            parallel_viscosity=float(self.viscosities[n]),
        )  # fmt: skip

    def scaled(self, factor: Any = 1.0, time_factor: Any = 1.0) -> PronyColumns:
        """Moduli times `factor`, times times `time_factor`, both numbers or of shape (n,)."""
        modulus, time = np.asarray(factor, dtype=np.float64), np.asarray(time_factor, dtype=np.float64)
        return PronyColumns(
            self.equilibria * modulus, self.viscosities * modulus * time,
            self.moduli * modulus[..., None], self.times * time[..., None],
        )  # fmt: skip

    def relaxation_modulus(self, time: Array) -> Array:
        """Moduli [Pa] at times > 0 [s] of shape (m,), shape (n, m)."""
        decays = np.exp(-time[:, None] / self.times[:, None, :])
        return self.equilibria[:, None] + np.einsum("nmk,nk->nm", decays, self.moduli)

    def storage_modulus(self, angular_frequency: Array) -> Array:
        """Storage moduli [Pa], each at its own angular frequency >= 0 [rad/s], shape (n,)."""
        with np.errstate(over="ignore", divide="ignore"):
            x = angular_frequency[:, None] * self.times
            return self.equilibria + (self.moduli / (1.0 + (1.0 / x) ** 2)).sum(axis=1)

    def complex_modulus(self, angular_frequency: Array) -> NDArray[np.complex128]:
        """Moduli E' + i E'' [Pa] at angular frequencies [rad/s] of shape (m,), shape (n, m)."""
        x = 1j * angular_frequency[:, None] * self.times[:, None, :]
        branches = np.einsum("nmk,nk->nm", x / (1.0 + x), self.moduli)
        return self.equilibria[:, None] + 1j * angular_frequency * self.viscosities[:, None] + branches


@dataclass(frozen=True, eq=False)
class MaterialColumns:
    """Isotropic materials, one in each row: shear and bulk relaxation, and the reduced modulus of a contact.

    Attributes
    ----------
    shear : PronyColumns
        Relaxation modulus in shear G(t).
    bulk : PronyColumns
        Relaxation modulus in bulk K(t); infinite equilibrium moduli for incompressible materials.
    reduced : PronyColumns
        Reduced modulus E*(t) in the contact with a rigid body.
    shift : callable, optional
        Maps a temperature [K] to the factors, shape (n,), by which all relaxation times grow from those of the
        columns to those at this temperature.
    """

    shear: PronyColumns
    bulk: PronyColumns
    reduced: PronyColumns
    shift: Callable[[float], Array] | None = None

    @classmethod
    def from_materials(cls, materials: Sequence[Material]) -> MaterialColumns:
        """Columns of materials of any kind; their own shifts are kept where all have one."""

        def shift(temperature: float) -> Array:
            return np.array([one.at(temperature).shear.relaxation_times[0] / one.shear.relaxation_times[0]
                             for one in materials])  # fmt: skip

        shifts = all(one.shift is not None and one.shear.n_branches for one in materials)
        return cls(
            PronyColumns.stacked([one.shear for one in materials]), bulk_columns(materials),
            PronyColumns.stacked([reduced_modulus(one) for one in materials]), shift if shifts else None,
        )  # fmt: skip

    @property
    def size(self) -> int:
        """Number of materials."""
        return self.shear.size

    def at(self, temperature: float | None) -> MaterialColumns:
        """Columns at another temperature [K]; the same ones where none is given."""
        if temperature is None:
            return self
        if self.shift is None:
            raise InputError("temperature", temperature, "must not be given for a model without a shift", "K")
        factor = self.shift(temperature)
        shear, bulk, reduced = (one.scaled(1.0, factor) for one in (self.shear, self.bulk, self.reduced))
        return replace(self, shear=shear, bulk=bulk, reduced=reduced, shift=None)

    def modulus(self, deformation: Literal["shear", "tension"]) -> PronyColumns:
        """Relaxation moduli in shear, or in tension."""
        if deformation == "shear":
            return self.shear
        if np.all(np.isinf(self.bulk.equilibria)):
            return self.shear.scaled(3.0)
        bulks = [np.inf if np.isinf(k) else self.bulk.row(n) for n, k in enumerate(self.bulk.equilibria)]
        return PronyColumns.stacked(
            [tension_from_shear(self.shear.row(n), bulk_modulus=bulk) for n, bulk in enumerate(bulks)]
        )


def bulk_columns(materials: Sequence[Material]) -> PronyColumns:
    """Bulk relaxation of materials, infinite where they are incompressible."""
    rigid = PronySeries.from_checked(np.inf, np.empty(0), np.empty(0))
    return PronyColumns.stacked([one.bulk if isinstance(one.bulk, PronySeries) else rigid for one in materials])


def reduced_standard_solid(
    poisson_ratio: Array, equilibrium_modulus: Array, branch_modulus: Array, relaxation_time: Array
) -> PronyColumns:
    """Reduced moduli of standard solids in shear with a constant bulk modulus; arrays of shape (n,).

    From `E* = 4 G (3K + G)/(3K + 4G) = G + 9K/4 - (27 K^2/4)/(3K + 4G)` in Carson transforms. With K the bulk modulus
    of the static Poisson ratio nu in [-1, 0.5], G0 = Ginf + G1 [Pa] and tau = eta/G1 [s]::

        E*inf = 2 Ginf/(1 - nu)
        E1 = G1,                                                tau1 = tau
        E2 = (27 K^2/4) [1/(3K + 4 Ginf) - 1/(3K + 4 G0)],      tau2 = tau (3K + 4 G0)/(3K + 4 Ginf)

    For nu = 1/2 both branches are one, E1 = 4 G1 at tau, and for nu = -1 the second vanishes: its modulus is 0.
    """
    # In units of Ginf: Ginf/K rather than K, which is infinite for nu = 1/2; K/Ginf where it is the small one.
    soft, K = poisson_ratio < 0.2, bulk_factor(poisson_ratio)
    with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
        ratio = branch_modulus / equilibrium_modulus
        equilibrated = np.where(soft, 3.0 * K + 4.0, 3.0 + 4.0 / K)
        glassy = np.where(soft, 3.0 * K + 4.0 * (1.0 + ratio), 3.0 + 4.0 * (1.0 + ratio) / K)
        second = np.where(soft, 27.0 * K**2, 27.0) * branch_modulus / (equilibrated * glassy)
        second_time = relaxation_time * glassy / equilibrated
    equilibrium = 2.0 * equilibrium_modulus / (1.0 - poisson_ratio)
    incompressible = poisson_ratio == 0.5
    first = np.where(incompressible, 4.0, 1.0) * branch_modulus
    moduli = np.column_stack([first, np.where(incompressible, 0.0, second)])
    times = np.column_stack([relaxation_time, second_time])
    return PronyColumns(equilibrium, np.zeros(equilibrium.shape), moduli, times)
