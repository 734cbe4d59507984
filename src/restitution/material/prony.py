"""Prony series: a relaxation modulus as a sum of decaying exponentials."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from restitution.checks import nonnegative, single_nonnegative, single_positive
from restitution.errors import InputError
from restitution.material.secular import secular_roots
from restitution.pictures import draw
from restitution.quantities import check, check_single

if TYPE_CHECKING:
    from matplotlib.figure import Figure

Array = NDArray[np.float64]

MAX_BRANCHES = 1000
"""Largest number of branches: conversions and contacts take memory and time with its square."""

EXTREME = 1e100
"""Moduli, times and their reciprocals beyond this are refused, as their products would overflow."""
_NEGLIGIBLE = 1e-60


def in_range(name: str, value: Any, unit: str, extreme: float = EXTREME) -> None:
    """Refuse a number >= 0 that is neither zero nor within an extreme and its reciprocal."""
    if value != 0.0 and not 1.0 / extreme <= value <= extreme:
        raise InputError(name, value, f"must be in [{1.0 / extreme:g}, {extreme:g}] {unit}", unit)


class Retardation(NamedTuple):
    """Creep compliance J(t) = J_g + t/eta + sum J_k (1 - exp(-t/tau_k)) that belongs to a Prony series."""

    instantaneous_compliance: float  # J_g [1/Pa], 0 with a dashpot in parallel
    fluidity: float  # 1/eta [1/(Pa s)], 0 for a solid
    branch_compliances: Array  # J_k > 0 [1/Pa], shape (n_term,)
    retardation_times: Array  # tau_k [s], ascending, shape (n_term,)


@dataclass(frozen=True, eq=False, repr=False, init=False)
class PronySeries:
    """Relaxation modulus R(t) = R_inf + eta delta(t) + sum R_k exp(-t/tau_k) [Pa].

    The spring R_inf, the Maxwell branches (R_k, tau_k) and the dashpot eta stand in parallel. Immutable.

    Parameters
    ----------
    equilibrium_modulus
        Long-time modulus R_inf >= 0 [Pa]; 0 for a liquid.
    branch_moduli, relaxation_times
        R_k >= 0 [Pa] and tau_k > 0 [s] of the branches, shape (n_branch,) each, in any order.
    parallel_viscosity
        Viscosity eta >= 0 of a dashpot in parallel [Pa s].

    Raises
    ------
    InputError
        If a number is out of range or the two lists differ in length.

    Notes
    -----
    Ferry, *Viscoelastic Properties of Polymers*, 3rd ed. (1980), ch. 3.

    Examples
    --------
    >>> series = PronySeries(1e6, [2e6, 3e6], [1e-3, 1.0])
    >>> series.instantaneous_modulus
    6000000.0
    >>> print(series.relaxation_modulus(0.0), series.storage_modulus(0.0))
    6000000.0 1000000.0
    """

    equilibrium_modulus: float
    branch_moduli: Array
    relaxation_times: Array
    parallel_viscosity: float

    def __init__(
        self,
        equilibrium_modulus: float,
        branch_moduli: ArrayLike = (),
        relaxation_times: ArrayLike = (),
        *,
        parallel_viscosity: float = 0.0,
    ) -> None:
        equilibrium = check_single("equilibrium_modulus", equilibrium_modulus)
        dashpot = check_single("parallel_viscosity", parallel_viscosity)
        moduli = np.atleast_1d(check("branch_moduli", branch_moduli))
        times = np.atleast_1d(check("relaxation_times", relaxation_times))
        if moduli.ndim != 1 or times.shape != moduli.shape:
            names, shapes = "branch_moduli, relaxation_times", f"shapes {moduli.shape} and {times.shape}"
            raise InputError(names, shapes, "must be one-dimensional and of equal length")
        if moduli.size > MAX_BRANCHES:
            raise InputError("branch_moduli", moduli.size, f"must be at most {MAX_BRANCHES} branches")
        with np.errstate(over="ignore"):
            glass = equilibrium + float(moduli.sum())
        in_range("equilibrium_modulus + sum of branch_moduli", glass, "Pa")
        in_range("parallel_viscosity", dashpot, "Pa s", EXTREME**2)
        for time in (times.min(), times.max()) if times.size else ():
            in_range("relaxation_times", float(time), "s")
        self._fill(equilibrium, moduli, times, dashpot)

    def _fill(self, equilibrium: float, moduli: Array, times: Array, viscosity: float) -> None:
        moduli.setflags(write=False)
        times.setflags(write=False)
        self.__dict__.update(equilibrium_modulus=equilibrium, branch_moduli=moduli)
        self.__dict__.update(relaxation_times=times, parallel_viscosity=viscosity)

    @classmethod
    def from_checked(cls, equilibrium: float, moduli: Array, times: Array, viscosity: float = 0.0) -> PronySeries:
        """Series of admissible numbers, which are neither checked nor copied."""
        series = object.__new__(cls)
        series._fill(equilibrium, moduli, times, viscosity)
        return series

    @property
    def window(self) -> tuple[float, float] | None:
        """Shortest and longest time [s] of the data to which the series was fitted; None without data."""
        return self.__dict__.get("_window")

    def known_within(self, window: tuple[float, float] | None) -> PronySeries:
        """The same series, known for times [s] within a window; a material that is made from it keeps the window."""
        series = PronySeries.from_checked(
            self.equilibrium_modulus, self.branch_moduli, self.relaxation_times, self.parallel_viscosity
        )
        series.__dict__["_window"] = window
        return series

    @property
    def n_branches(self) -> int:
        """Number of branches as given, those with zero modulus included."""
        return self.branch_moduli.size

    @property
    def instantaneous_modulus(self) -> float:
        """Glass modulus R_0 = R_inf + sum R_k [Pa]; infinite with a dashpot in parallel."""
        if self.parallel_viscosity > 0:
            return float("inf")
        return self.equilibrium_modulus + float(self.branch_moduli.sum())

    @property
    def flow_viscosity(self) -> float:
        """Viscosity eta + sum R_k tau_k [Pa s] of the steady flow of a liquid."""
        return self.parallel_viscosity + float(self.branch_moduli @ self.relaxation_times)

    @property
    def is_zero(self) -> bool:
        """Whether the function is zero at all times."""
        return self.equilibrium_modulus == 0 and self.is_elastic

    @property
    def is_elastic(self) -> bool:
        """Whether nothing relaxes: a spring alone."""
        return self.parallel_viscosity == 0 and not self.branch_moduli.any()

    @property
    def is_liquid(self) -> bool:
        """Whether the equilibrium modulus is zero, so that a load makes it flow for ever."""
        return self.equilibrium_modulus == 0

    def plot(self, window: tuple[float, float] | None = None) -> Figure:
        """Figure of the relaxation modulus over time, and of storage and loss modulus over frequency.

        The window is the shortest and the longest time [s], by default a decade beyond the relaxation times.
        """
        return draw("material.overview", {"modulus": self}, window)

    def relaxation_modulus(self, time: ArrayLike) -> Any:
        """Relaxation modulus R(t) [Pa] at the times t >= 0 [s], any shape; infinite at t = 0 with a dashpot.

        Examples
        --------
        >>> PronySeries(1.0, [2.0], [3.0]).relaxation_modulus([0.0, 3.0])
        array([3.        , 1.73575888])
        """
        t = np.asarray(nonnegative("time", time, "s"))
        with np.errstate(over="ignore"):
            decays = np.exp(-t[..., None] / self.relaxation_times)
        value = self.equilibrium_modulus + decays @ self.branch_moduli
        return np.where(t == 0, np.inf, value)[()] if self.parallel_viscosity > 0 else value[()]

    def creep_compliance(self, time: ArrayLike) -> Any:
        """Creep compliance J(t) [1/Pa], the strain under a unit step of stress, at the times t >= 0 [s].

        Examples
        --------
        >>> PronySeries(0.0, [2.0], [3.0]).creep_compliance([0.0, 6.0])
        array([0.5, 1.5])
        """
        t = np.asarray(nonnegative("time", time, "s"))
        glass, fluidity, compliances, times = self.retardation
        with np.errstate(over="ignore"):
            return (glass + fluidity * t - np.expm1(-t[..., None] / times) @ compliances)[()]

    @cached_property
    def retardation(self) -> Retardation:
        """Retardation spectrum: 1/R(s) of the Carson transform R(s), in partial fractions."""
        own = self.simplified()
        if own.is_zero:
            raise InputError("equilibrium_modulus", 0.0, "must be > 0, as nothing else carries a load", "Pa")
        ends = own.equilibrium_modulus, own.parallel_viscosity
        roots = secular_roots(*ends, own.branch_moduli[::-1], own.relaxation_times[::-1])
        glass = 0.0 if own.parallel_viscosity > 0 else 1.0 / own.instantaneous_modulus
        fluidity = 1.0 / own.flow_viscosity if own.is_liquid else 0.0
        return Retardation(glass, fluidity, 1.0 / roots.slopes[::-1], roots.times[::-1])

    def storage_modulus(self, angular_frequency: ArrayLike) -> Any:
        """Storage modulus R'(omega) [Pa] at the angular frequencies omega >= 0 [rad/s], any shape.

        Examples
        --------
        >>> series = PronySeries(1.0, [2.0], [0.5])
        >>> print(series.storage_modulus(2.0), series.loss_modulus(2.0), series.loss_tangent(2.0))
        2.0 1.0 0.5
        """
        return self._dynamic(angular_frequency)[0]

    def loss_modulus(self, angular_frequency: ArrayLike) -> Any:
        """Loss modulus R''(omega) [Pa] at the angular frequencies omega >= 0 [rad/s], any shape."""
        return self._dynamic(angular_frequency)[1]

    def loss_tangent(self, angular_frequency: ArrayLike) -> Any:
        """Loss tangent R''/R' at the angular frequencies omega > 0 [rad/s]; infinite for a dashpot alone."""
        storage, loss = self._dynamic(angular_frequency)
        with np.errstate(divide="ignore", invalid="ignore"):
            return np.divide(loss, storage)[()]

    def _dynamic(self, angular_frequency: ArrayLike) -> tuple[Any, Any]:
        omega = np.asarray(nonnegative("angular_frequency", angular_frequency, "rad/s"))
        with np.errstate(over="ignore", divide="ignore"):
            x = omega[..., None] * self.relaxation_times
            storage = self.equilibrium_modulus + (1.0 / (1.0 + (1.0 / x) ** 2)) @ self.branch_moduli
            loss = self.parallel_viscosity * omega + (1.0 / (x + 1.0 / x)) @ self.branch_moduli
        return storage[()], loss[()]

    def carson_transform(self, s: ArrayLike) -> Any:
        """Carson transform s int_0^inf R(t) exp(-s t) dt [Pa] at real or complex s [1/s], any shape.

        Equals R_inf + eta s + sum R_k s tau_k/(1 + s tau_k); at s = i omega it is the complex modulus.

        Examples
        --------
        >>> print(PronySeries(1.0, [2.0], [0.5]).carson_transform(2.0))
        2.0
        """
        point = np.asarray(s)
        share = point[..., None] / (point[..., None] + 1.0 / self.relaxation_times)
        return (self.equilibrium_modulus + self.parallel_viscosity * point + share @ self.branch_moduli)[()]

    def simplified(self) -> PronySeries:
        """Same function in its shortest form: no negligible branches, equal times merged, times ascending.

        A branch is negligible if it changes the Carson transform at no s > 0 by more than the fraction 1e-60.

        Examples
        --------
        >>> PronySeries(1.0, [2.0, 0.0, 3.0], [5.0, 1.0, 5.0]).simplified()
        PronySeries(1.0, [5.0], [5.0])
        """
        moduli, times = self.branch_moduli, self.relaxation_times
        keep = moduli > moduli.max(initial=0.0) * _NEGLIGIBLE
        if keep.all() and (times[1:] > times[:-1]).all():
            return self
        if not keep.all():
            # Its share of R(s) is largest at s = 1/tau_k.
            with np.errstate(over="ignore"):
                keep = moduli > _NEGLIGIBLE * self.carson_transform(1.0 / times)
        times, where = np.unique(times[keep], return_inverse=True)
        moduli = np.bincount(where, moduli[keep], times.size).astype(np.float64)
        made = PronySeries.from_checked(self.equilibrium_modulus, moduli, times, self.parallel_viscosity)
        return made if self.window is None else made.known_within(self.window)

    def scaled(self, factor: float, *, time_factor: float = 1.0) -> PronySeries:
        """Series with every modulus times `factor` >= 0 and every time times `time_factor` > 0.

        Examples
        --------
        >>> PronySeries(1.0, [2.0], [3.0]).scaled(2.0, time_factor=0.1)
        PronySeries(2.0, [4.0], [0.30000000000000004])
        """
        factor = single_nonnegative("factor", factor)
        stretch = single_positive("time_factor", time_factor)
        # The new series refuses numbers that overflow.
        with np.errstate(over="ignore"):
            moduli, times = self.branch_moduli * factor, self.relaxation_times * stretch
        viscosity = self.parallel_viscosity * factor * stretch
        made = PronySeries(self.equilibrium_modulus * factor, moduli, times, parallel_viscosity=viscosity)
        if self.window is None:
            return made
        return made.known_within((self.window[0] * stretch, self.window[1] * stretch))

    def _key(self) -> tuple[float, float, bytes, bytes]:
        # Adding 0.0 makes one of the two zeros.
        arrays = (self.branch_moduli + 0.0).tobytes(), self.relaxation_times.tobytes()
        return self.equilibrium_modulus, self.parallel_viscosity, *arrays

    def __eq__(self, other: object) -> bool:
        return self._key() == other._key() if isinstance(other, PronySeries) else NotImplemented

    def __hash__(self) -> int:
        return hash(self._key())

    def __repr__(self) -> str:
        moduli, times = self.branch_moduli.tolist(), self.relaxation_times.tolist()
        dashpot = f", parallel_viscosity={self.parallel_viscosity!r}" if self.parallel_viscosity > 0 else ""
        branches = f", {moduli!r}, {times!r}" if moduli else ""
        return f"PronySeries({self.equilibrium_modulus!r}{branches}{dashpot})"
