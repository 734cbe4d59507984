"""Many materials as columns of numbers, one material in each row."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import Any, Literal, NamedTuple

import numpy as np
from numpy.typing import NDArray

from restitution.errors import InputError
from restitution.material.conversion import bulk_factor, series_connection, tension_from_shear
from restitution.material.fractional import FractionalMaterial, FractionalModel, log_spectrum
from restitution.material.prony import PronySeries
from restitution.material.viscoelastic import Material, reduced_modulus

Array = NDArray[np.float64]

# Step of the logarithm of time between the terms of a fractional model, and how far they reach beyond its window. The
# trapezoidal rule then errs by 3e-9, and the two terms in place of all beyond by the square of the reach.
_STEP, _REACH = 0.5, 1e3
_LN_EPS = 37.0


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

    @classmethod
    def springs(cls, moduli: Array) -> PronyColumns:
        """Columns of constant moduli of shape (n,)."""
        return cls(moduli, np.zeros(moduli.size), np.empty((moduli.size, 0)), np.empty((moduli.size, 0)))

    @classmethod
    def from_fractional(cls, models: Sequence[FractionalModel], window: tuple[float, float]) -> PronyColumns:
        """Columns of fractional models, good within a window of times [s], on relaxation times of all rows.

        The spectrum is integrated by the trapezoidal rule at fixed times, so that the columns are smooth functions of
        the constants. One branch of the same first two moments stands for all that is slower, and one for all that is
        faster, than a thousandth of the window.
        """
        alpha, spring, coefficient, equilibria = np.array(
            [[one.exponent, one.series_modulus, one.coefficient, one.equilibrium_modulus] for one in models],
            dtype=np.float64,
        ).T
        bounded = np.isfinite(spring)
        unit = np.where(bounded, 1.0, window[0])
        scale = coefficient * unit**-alpha
        unit[bounded] = (coefficient / spring)[bounded] ** (1.0 / alpha[bounded])
        scale[bounded] = spring[bounded]
        # The poles of a bounded spectrum near the real axis take smaller steps.
        delta = min((math.pi * (1.0 - a) / a for a in alpha[bounded]), default=math.pi)
        step = _STEP * 0.5 ** max(math.ceil(math.log2(0.5 * math.pi / (1.4 * delta))), 0)
        first, last = math.log(window[0] / _REACH), math.log(window[1] * _REACH)
        count = math.ceil((last - first) / step)
        before = math.ceil(_LN_EPS / (1.0 - float(alpha.max())) / step)
        after = math.ceil(_LN_EPS / float(alpha.min()) / step)
        places = np.arange(-before, count + after + 1)
        logs = first + step * places
        u: Any = np.log(unit)[:, None] - logs
        spectrum = np.where(bounded[:, None], *(log_spectrum(alpha[:, None], kind, u) for kind in (True, False)))
        weights = np.log(scale * step)[:, None] + spectrum
        inside = (places >= 0) & (places <= count)
        moduli, times = np.exp(weights[:, inside]), np.exp(logs[inside])
        # Moments of viscosity where the time is short, and of the modulus and its rate where it is long.
        fast, slow = logs[places < 0] - first, last - logs[places > count]
        viscosity, square = (np.exp(weights[:, places < 0] + power * fast).sum(axis=1) for power in (1.0, 2.0))
        modulus, rate = (np.exp(weights[:, places > count] + power * slow).sum(axis=1) for power in (0.0, 1.0))
        ends = np.stack([viscosity * (viscosity / square), modulus], axis=1)
        end_times = np.stack([math.exp(first) * square / viscosity, math.exp(last) * modulus / rate], axis=1)
        moduli = np.hstack([ends[:, :1], moduli, ends[:, 1:]])
        times = np.hstack([end_times[:, :1], np.broadcast_to(times, (alpha.size, times.size)), end_times[:, 1:]])
        return cls(equilibria, np.zeros(alpha.size), moduli, times)

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

    def in_series(self, other: PronySeries) -> PronyColumns:
        """Columns of the contact with a body of the reduced modulus `other`: 1/E* is the sum of both 1/E*."""
        if not (other.is_elastic and _is_plain(self)):
            return PronyColumns.stacked([series_connection(self.row(n), other) for n in range(self.size)])
        modulus = np.full(self.size, other.equilibrium_modulus)
        moduli, times = _transformed(self, modulus, 1.0, 1.0, 1.0)
        equilibria = self.equilibria / (1.0 + self.equilibria / modulus)
        return PronyColumns(equilibria, np.zeros(self.size), moduli, times)

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
        # These forms stay finite for all times from 0 to infinity.
        with np.errstate(over="ignore", divide="ignore"):
            x = angular_frequency[:, None] * self.times[:, None, :]
            shares = 1.0 / (1.0 + 1.0 / x**2) + 1j / (x + 1.0 / x)
        branches = np.einsum("nmk,nk->nm", shares, self.moduli)
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
    def from_materials(
        cls, materials: Sequence[Material | FractionalMaterial], window: tuple[float, float] = (1e-6, 1.0)
    ) -> MaterialColumns:
        """Columns of materials; their own shifts are kept where all have one.

        Fractional materials hold within a window of times [s].
        """
        if all(isinstance(one, FractionalMaterial) and isinstance(one.bulk, int | float) for one in materials):
            shear = PronyColumns.from_fractional([one.shear for one in materials], window)  # pyright: ignore[reportArgumentType]
            return cls.from_shear(shear, np.array([one.bulk for one in materials], dtype=np.float64))
        plain = [one.within(window) if isinstance(one, FractionalMaterial) else one for one in materials]
        shear = PronyColumns.stacked([one.shear for one in plain])
        bulks = [_elastic_bulk(one) for one in plain]

        def shift(temperature: float) -> Array:
            return np.array([one.at(temperature).shear.relaxation_times[0] / one.shear.relaxation_times[0]
                             for one in plain])  # fmt: skip

        kept = shift if all(one.shift is not None and one.shear.n_branches for one in plain) else None
        if None not in bulks:
            return cls.from_shear(shear, np.array(bulks, dtype=np.float64), kept)
        reduced = PronyColumns.stacked([reduced_modulus(one) for one in plain])
        return cls(shear, bulk_columns(plain), reduced, kept)

    @classmethod
    def from_shear(
        cls, shear: PronyColumns, bulk_modulus: Array, shift: Callable[[float], Array] | None = None
    ) -> MaterialColumns:
        """Columns of materials with elastic bulk moduli [Pa], shape (n,), which may be infinite."""
        return cls(shear, PronyColumns.springs(bulk_modulus), _reduced(shear, bulk_modulus), shift)

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
        # A trial shift may have infinite factors: such rows are NaN.
        with np.errstate(invalid="ignore", over="ignore"):
            shear, bulk, reduced = (one.scaled(1.0, factor) for one in (self.shear, self.bulk, self.reduced))
        return replace(self, shear=shear, bulk=bulk, reduced=reduced, shift=None)

    def modulus(self, deformation: Literal["shear", "tension"]) -> PronyColumns:
        """Relaxation moduli in shear, or in tension."""
        if deformation == "shear":
            return self.shear
        elastic = not (self.bulk.moduli.any() or self.bulk.viscosities.any())
        if elastic and _is_plain(self.shear):
            return _tension(self.shear, self.bulk.equilibria)
        bulks = [np.inf if np.isinf(k) else self.bulk.row(n) for n, k in enumerate(self.bulk.equilibria)]
        return PronyColumns.stacked(
            [tension_from_shear(self.shear.row(n), bulk_modulus=bulk) for n, bulk in enumerate(bulks)]
        )


def _elastic_bulk(material: Material) -> float | None:
    """Bulk modulus [Pa] of a material; None where it relaxes or has no fast formula."""
    bulk = material.bulk
    if not isinstance(bulk, PronySeries):
        return math.inf
    mixed = material.shear.parallel_viscosity > 0.0 and material.shear.n_branches > 0
    return None if mixed or not bulk.is_elastic else bulk.equilibrium_modulus


def _is_plain(shear: PronyColumns) -> bool:
    """Whether no row has both branches and a dashpot in parallel."""
    return not bool(np.any((shear.viscosities > 0.0) & shear.moduli.any(axis=1)))


def _reduced(shear: PronyColumns, bulk: Array) -> PronyColumns:
    """Reduced moduli E* = 4G(3K + G)/(3K + 4G) = G + 9K/4 - (27 K^2/4)/(3K + 4G), in Carson transforms."""
    rigid = np.isinf(bulk)
    own = np.where(rigid, 4.0, 1.0)
    with np.errstate(invalid="ignore", divide="ignore"):
        ratio = shear.equilibria / bulk
        soft = np.where(ratio > 1.0, bulk / shear.equilibria, 0.0)
        part = np.where(ratio > 1.0, (3.0 * soft + 1.0) / (3.0 * soft + 4.0), (3.0 + ratio) / (3.0 + 4.0 * ratio))
    moduli, times = _transformed(shear, bulk, 3.0, 4.0, 27.0 / 4.0)
    return PronyColumns(
        4.0 * shear.equilibria * part, shear.viscosities * own,
        np.hstack([shear.moduli * own[:, None], np.where(rigid[:, None], 0.0, moduli)]),
        np.hstack([shear.times, times]),
    )  # fmt: skip


def _tension(shear: PronyColumns, bulk: Array) -> PronyColumns:
    """Moduli in tension E = 9K - 81 K^2/(9K + 3G), in Carson transforms."""
    rigid = np.isinf(bulk)
    with np.errstate(invalid="ignore", divide="ignore"):
        equilibria = np.where(bulk > 0.0, 9.0 * shear.equilibria / (3.0 + shear.equilibria / bulk), 0.0)
    moduli, times = _transformed(shear, bulk, 9.0, 3.0, 81.0)
    if moduli.shape[1] == shear.moduli.shape[1]:
        moduli = np.where(rigid[:, None], 3.0 * shear.moduli, moduli)
        times = np.where(rigid[:, None], shear.times, times)
    return PronyColumns(equilibria, np.where(rigid, 3.0 * shear.viscosities, 0.0), moduli, times)


def _transformed(shear: PronyColumns, bulk: Array, a: float, b: float, factor: float) -> tuple[Array, Array]:
    """Branch moduli and times of -factor K^2/(a K + b G): its poles are the roots of a K + b G."""
    stiff = np.where(np.isinf(bulk), 1.0, bulk)
    constant = a * stiff + b * shear.equilibria
    n, k = shear.moduli.shape
    # A row with a dashpot has no branch.
    damped, soft = shear.viscosities > 0.0, ~np.isinf(bulk)
    moduli, times = np.zeros((n, max(k, int(damped.any())))), np.ones((n, max(k, int(damped.any()))))
    if np.any(damped):
        moduli[damped, 0] = (factor * stiff * (stiff / constant))[damped]
        times[damped, 0] = (b * shear.viscosities / constant)[damped]
    soft &= ~damped
    if k and np.any(soft):
        times[soft], slopes = _roots(constant[soft], b * shear.moduli[soft], shear.times[soft])
        moduli[soft] = factor * stiff[soft, None] * (stiff[soft, None] / slopes)
    return moduli, times


def _roots(constant: Array, weights: Array, times: Array) -> tuple[Array, Array]:
    """Roots 1/lambda of S = c + sum w_k s/(s + lambda_k) at s = -lambda, and lambda S', both of shape (n, n_branch).

    With the time of a root (1 + 1/y) tau_k, where y > p and p is the pole at the next larger time, S is a convex and
    decreasing function of y. The linear part in y and the term of that pole are kept, the rest is replaced by its
    tangent: a bound from below, so that the iteration is monotone.
    """
    n, k = times.shape
    order = np.argsort(-times, axis=1)
    tau, w = np.take_along_axis(times, order, axis=1), np.take_along_axis(weights, order, axis=1)
    total = constant + w.sum(axis=1)
    absent = w <= 0.0
    w = np.where(absent, 1e-18 * total[:, None], w)
    if k > 1:  # equal times have a gap of rounding size
        tau = tau * np.cumprod(np.where(np.diff(tau, axis=1, prepend=np.inf) > -1e-12 * tau, 1.0 - 1e-12, 1.0), axis=1)
    with np.errstate(all="ignore"):
        rho = tau[:, :, None] / tau[:, None, :]
        apart = (tau[:, None, :] - tau[:, :, None]) / tau[:, None, :]
        own = np.broadcast_to(np.eye(k, dtype=bool), rho.shape)
        above = np.broadcast_to(np.eye(k, k=-1, dtype=bool), rho.shape)
        other = np.where(own | above, 0.0, w[:, None, :])
        pole, share = np.zeros((n, k)), np.zeros((n, k))
        if k > 1:
            pole[:, 1:] = tau[:, 1:] / (tau[:, :-1] - tau[:, 1:])
            share[:, 1:] = w[:, :-1] * tau[:, :-1] / (tau[:, :-1] - tau[:, 1:])
        weight, level = share * pole, constant[:, None] + share
        y = np.maximum(constant / w.sum(axis=1), 0.0)[:, None] + 2.0 * pole
        last = np.zeros((n, k), dtype=bool)
        for _ in range(60):
            bottom = apart * y[:, :, None] - rho
            value = (other * y[:, :, None] / bottom).sum(axis=2)
            slope = -(other * rho / (bottom * bottom)).sum(axis=2)
            linear = w - slope
            q = level + value - slope * y - linear * pole
            root = np.sqrt(q * q + 4.0 * linear * weight)
            z = np.where(q > 0.0, (q + root) / (2.0 * linear), 2.0 * weight / (root - q))
            new = pole + z
            # The step after one of this size is below rounding.
            done = np.abs(new - y) <= 1e-10 * new
            y = new
            if k == 1 or bool(np.all(last | ~np.isfinite(new))):
                break
            last = done
        terms = np.where(own, -y[:, :, None], y[:, :, None] / (apart * y[:, :, None] - rho))
        found = tau * (1.0 + 1.0 / y)
        slopes = (w[:, None, :] * terms * (terms - 1.0)).sum(axis=2)
    return found, np.where(absent, np.inf, slopes)


def bulk_columns(materials: Sequence[Material]) -> PronyColumns:
    """Bulk relaxation of materials, infinite where they are incompressible."""
    rigid = PronySeries.from_checked(np.inf, np.empty(0), np.empty(0))
    return PronyColumns.stacked([one.bulk if isinstance(one.bulk, PronySeries) else rigid for one in materials])


def reduced_standard_solid(
    poisson_ratio: Array, equilibrium_modulus: Array, branch_modulus: Array, relaxation_time: Array
) -> PronyColumns:
    """Reduced moduli of standard solids in shear with the bulk modulus of a static Poisson ratio; arrays (n,)."""
    # Beyond the range of numbers an impact fails with NOT_FINITE.
    with np.errstate(over="ignore", invalid="ignore"):
        bulk = equilibrium_modulus * bulk_factor(poisson_ratio)
        none = np.zeros(equilibrium_modulus.shape)
        return _reduced(
            PronyColumns(equilibrium_modulus, none, branch_modulus[:, None], relaxation_time[:, None]), bulk
        )
