"""Prony series: a relaxation modulus as a sum of decaying exponentials."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING, Any, ClassVar, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from restitution.axes import Axes, aligned, named, spread_array
from restitution.checks import Array, Numeric, finite, nonnegative, number, pair, positive, refuse, single_positive
from restitution.errors import InputError
from restitution.quantities import check
from restitution.result import draw

if TYPE_CHECKING:
    from matplotlib.figure import Figure


MAX_BRANCHES = 1000
"""Largest number of branches: conversions and contacts take memory and time with its square."""

EXTREME = 1e100
"""Moduli, times and their reciprocals beyond this are refused, as their products would overflow."""
_NEGLIGIBLE = 1e-60


class SecularRoots(NamedTuple):
    """Roots of S(-lambda) = 0 in ascending order of lambda, and the terms of the residues, free of cancellation.

    A row with fewer roots than the others ends in times of 1, infinite slopes and terms of 0.
    """

    times: Array  # 1/lambda [s], shape (..., n_root)
    slopes: Array  # lambda S'(-lambda), positive, in the unit of S, shape (..., n_root)
    terms: Array  # lambda/(lambda - lambda_k), that is s/(s + lambda_k) at s = -lambda, shape (..., n_root, n_pole)


def secular_roots(constant: Numeric, viscosity: Numeric, weights: Array, times: Array) -> SecularRoots:
    """Return the roots of a - b lambda + sum E_k lambda/(lambda - lambda_k) = 0, with tau_k = 1/lambda_k descending.

    One equation has weights and times of shape (n_pole,), many have (n, n_pole) and constants (n,); see
    `restitution.material.secular.secular_rows`. For one, roots that are not found raise an error.
    """
    # Numba takes half a second to import.
    from restitution.material.secular import scratch, secular_rows

    single = weights.ndim == 1
    # Copies, as the compiler makes a second version for arrays that are read-only.
    weights, times = (np.array(part[None] if single else part, order="C") for part in (weights, times))
    n, count = weights.shape
    a, b = (np.array(np.broadcast_to(part, (n,)), dtype=np.float64) for part in (constant, viscosity))
    roots = SecularRoots(np.ones((n, count + 1)), np.full((n, count + 1), np.inf), np.zeros((n, count + 1, count)))
    counts = np.empty(n, dtype=np.int64)
    secular_rows(a, b, weights, times, counts, *roots, scratch(count))
    most = int(counts.max(initial=0))
    if not single:
        return SecularRoots(*(part[:, :most] for part in roots))
    refuse_far_apart(roots.times[0, :most], roots.slopes[0, :most])
    return SecularRoots(*(part[0, :most] for part in roots))


def refuse_far_apart(*parts: Array) -> None:
    """Refuse a material whose roots are not found."""
    if not all(np.isfinite(part).all() for part in parts):
        raise InputError("moduli", rule="must not differ by more than a factor of about 1e200 within a material")


def in_range(name: str, value: Any, unit: str, extreme: float = EXTREME) -> None:
    """Refuse numbers >= 0 that are neither zero nor within an extreme and its reciprocal."""
    values = np.asarray(value)
    bad = (values > extreme) | ((values < 1.0 / extreme) & (values != 0.0))
    if bad.any():  # a fit makes thousands of series
        refuse(name, values, bad, f"must be in [{1.0 / extreme:g}, {extreme:g}] {unit}", unit)


class Retardation(NamedTuple):
    """Creep compliance J(t) = J_g + t/eta + sum J_k (1 - exp(-t/tau_k)) that belongs to a Prony series."""

    instantaneous_compliance: Any  # J_g [1/Pa], 0 with a dashpot in parallel
    fluidity: Any  # 1/eta [1/(Pa s)], 0 for a solid
    branch_compliances: Array  # J_k >= 0 [1/Pa], shape (..., n_term)
    retardation_times: Array  # tau_k [s], ascending, shape (..., n_term)


@dataclass(frozen=True, eq=False, repr=False, init=False)
class PronySeries:
    """Relaxation modulus R(t) = R_inf + eta delta(t) + sum R_k exp(-t/tau_k) [Pa], or an array of them.

    The spring R_inf, the Maxwell branches (R_k, tau_k) and the dashpot eta stand in parallel. Immutable.

    Parameters
    ----------
    equilibrium_modulus
        Long-time modulus R_inf >= 0 [Pa]; 0 for a liquid.
    branch_moduli, relaxation_times
        R_k >= 0 [Pa] and tau_k > 0 [s] of the branches, shape (..., n_branch) each, in any order.
    parallel_viscosity
        Viscosity eta >= 0 of a dashpot in parallel [Pa s].

    Raises
    ------
    InputError
        If a number is out of range or the shapes do not fit.

    Notes
    -----
    Ferry, *Viscoelastic Properties of Polymers*, 3rd ed. (1980), ch. 3. The last axis of `branch_moduli` and
    `relaxation_times` is that of the branches. All other axes, and those of the two numbers, broadcast to the `shape`
    of an array of series; a series of fewer branches than others has moduli of zero.

    Examples
    --------
    >>> series = PronySeries(1e6, [2e6, 3e6], [1e-3, 1.0])
    >>> series.instantaneous_modulus
    6000000.0
    >>> print(series.relaxation_modulus(0.0), series.storage_modulus(0.0))
    6000000.0 1000000.0
    >>> PronySeries([1e6, 2e6], [3e6], [1e-3]).instantaneous_modulus
    array([4000000., 5000000.])
    """

    axes: ClassVar[Axes | None] = None
    """Names of the axes of an array of series; None where they have no names."""

    # Numbers of one series, arrays of several.
    equilibrium_modulus: Any
    branch_moduli: Array
    relaxation_times: Array
    parallel_viscosity: Any

    def __init__(
        self,
        equilibrium_modulus: ArrayLike,
        branch_moduli: ArrayLike = (),
        relaxation_times: ArrayLike = (),
        *,
        parallel_viscosity: ArrayLike = 0.0,
    ) -> None:
        values: dict[str, Any] = {"equilibrium_modulus": equilibrium_modulus, "parallel_viscosity": parallel_viscosity}
        lists = {"branch_moduli": branch_moduli, "relaxation_times": relaxation_times}
        values, axes = aligned(values | lists, lists)
        equilibrium_modulus, parallel_viscosity, branch_moduli, relaxation_times = values.values()
        equilibrium = check("equilibrium_modulus", equilibrium_modulus)
        dashpot = check("parallel_viscosity", parallel_viscosity)
        moduli = np.atleast_1d(check("branch_moduli", branch_moduli))
        times = np.atleast_1d(check("relaxation_times", relaxation_times))
        self.__dict__.update(vars(PronySeries.of_positive(equilibrium, moduli, times, dashpot)))
        named(self, axes)

    @classmethod
    def of_positive(cls, equilibrium: Numeric, moduli: Array, times: Array, viscosity: Any = 0.0) -> PronySeries:
        """Return series of numbers > 0, or >= 0 of the ends and moduli, broadcast.

        Shapes that do not fit are refused, and numbers whose products would overflow.
        """
        names, shapes = "branch_moduli, relaxation_times", f"shapes {moduli.shape} and {times.shape}"
        if moduli.shape[-1] != times.shape[-1]:
            raise InputError(names, shapes, "must be of equal length along the last axis, that of the branches")
        count = moduli.shape[-1]
        if count > MAX_BRANCHES:
            raise InputError("branch_moduli", count, f"must be at most {MAX_BRANCHES} branches")
        try:
            shape = np.broadcast_shapes(
                np.shape(equilibrium), np.shape(viscosity), moduli.shape[:-1], times.shape[:-1]
            )
        except ValueError:
            shapes += f", equilibrium_modulus {np.shape(equilibrium)}, parallel_viscosity {np.shape(viscosity)}"
            raise InputError(names, shapes, "must broadcast against each other but for the last axis") from None
        with np.errstate(over="ignore"):
            glass = equilibrium + moduli.sum(axis=-1)
        in_range("equilibrium_modulus + sum of branch_moduli", glass, "Pa")
        if np.ndim(viscosity) or viscosity:  # a fit makes thousands of series without a dashpot
            in_range("parallel_viscosity", viscosity, "Pa s", EXTREME**2)
        in_range("relaxation_times", times, "s")
        if shape:
            branches = *shape, count
            equilibrium, viscosity = _view(equilibrium, shape), _view(viscosity, shape)
            moduli, times = _view(moduli, branches), _view(times, branches)
        return cls.from_checked(equilibrium, moduli, times, viscosity)

    @classmethod
    def from_checked(cls, equilibrium: Numeric, moduli: Array, times: Array, viscosity: Numeric = 0.0) -> PronySeries:
        """Return a series of admissible numbers, which are neither checked nor copied."""
        series = object.__new__(cls)
        moduli.setflags(write=False)
        times.setflags(write=False)
        if moduli.ndim == 1:
            equilibrium, viscosity = float(equilibrium), float(viscosity)
        elif np.ndim(viscosity) == 0:
            viscosity = np.full(moduli.shape[:-1], viscosity)
        series.__dict__.update(equilibrium_modulus=equilibrium, branch_moduli=moduli)
        series.__dict__.update(relaxation_times=times, parallel_viscosity=viscosity)
        return series

    @classmethod
    def springs(cls, moduli: Any) -> PronySeries:
        """Return constant moduli [Pa], which are not checked."""
        empty = np.empty((*np.shape(moduli), 0))
        return cls.from_checked(moduli, empty, empty, np.zeros(np.shape(moduli))[()])

    @classmethod
    def stacked(cls, series: Sequence[PronySeries], axis: int = 0) -> PronySeries:
        """Return series, or arrays of one shape, along a new axis; they may differ in the number of branches."""
        most, shape = max((each.n_branches for each in series), default=0), series[0].shape if series else ()
        moduli, times = np.zeros((len(series), *shape, most)), np.ones((len(series), *shape, most))
        for n, each in enumerate(series):
            place = n, ..., slice(each.n_branches)
            moduli[place], times[place] = each.branch_moduli, each.relaxation_times
        ends = (
            np.array([getattr(each, name) for each in series], dtype=np.float64).reshape(len(series), *shape)
            for name in ("equilibrium_modulus", "parallel_viscosity")
        )
        equilibria, viscosities, moduli, times = (np.moveaxis(part, 0, axis) for part in (*ends, moduli, times))
        return cls.from_checked(equilibria, moduli, times, viscosities)

    @property
    def shape(self) -> tuple[int, ...]:
        """Shape of an array of series; () for one."""
        return self.branch_moduli.shape[:-1]

    @property
    def size(self) -> int:
        """Number of series."""
        return math.prod(self.shape)

    @property
    def columns(self) -> tuple[Array, Array, Array, Array]:
        """Equilibrium moduli and viscosities of n series, shape (n,), branch moduli and times, shape (n, n_branch)."""
        equilibrium, viscosity = np.asarray(self.equilibrium_modulus), np.asarray(self.parallel_viscosity)
        moduli, times = self.branch_moduli, self.relaxation_times
        *shape, count = moduli.shape
        n = math.prod(shape)
        return equilibrium.reshape(n), viscosity.reshape(n), moduli.reshape(n, count), times.reshape(n, count)

    def reshaped(self, shape: tuple[int, ...]) -> PronySeries:
        """Return the same series in an array of another shape."""
        ends = (np.asarray(part).reshape(shape)[()] for part in (self.equilibrium_modulus, self.parallel_viscosity))
        equilibrium, viscosity = ends
        count = self.branch_moduli.shape[-1]
        moduli, times = (part.reshape(*shape, count) for part in (self.branch_moduli, self.relaxation_times))
        return PronySeries.from_checked(equilibrium, moduli, times, viscosity)

    def broadcast_to(self, shape: tuple[int, ...]) -> PronySeries:
        """Return views of the series in a larger array."""
        if shape == self.shape:
            return self
        return self._each(lambda part, more: np.broadcast_to(part, (*shape, *more)))

    def _each(self, change: Callable[[Array, tuple[int, ...]], Any]) -> PronySeries:
        """Return series with a change of the shape of all numbers, which have no further axis or that of branches."""
        ends = self.equilibrium_modulus, self.parallel_viscosity
        equilibrium, viscosity = (change(np.asarray(part), ())[()] for part in ends)
        moduli, times = (change(part, part.shape[-1:]) for part in (self.branch_moduli, self.relaxation_times))
        return PronySeries.from_checked(equilibrium, moduli, times, viscosity)

    def spread(self, names: tuple[Any, ...], axes: Axes | None = None) -> PronySeries:
        """Return the series of an array over axes of other names; their own are `axes`."""
        target = axes or self.axes
        if not self.shape or target is None:
            return self
        return self._each(lambda part, more: spread_array(part, target, names, self.shape))

    @property
    def column(self) -> PronySeries:
        """The n series as an array of shape (n, 1), which broadcasts against times or frequencies of shape (m,)."""
        return self.reshaped((self.size, 1))

    def take(self, rows: Any) -> PronySeries:
        """Return series of an array by index, slice or mask along its axes; they may repeat."""
        parts = self.equilibrium_modulus, self.branch_moduli, self.relaxation_times, self.parallel_viscosity
        return PronySeries.from_checked(*(part[rows] for part in parts))

    def row(self, *index: int) -> PronySeries:
        """Return one series of an array, without branches of zero modulus."""
        there = self.branch_moduli[index] > 0.0
        series = self._each(lambda part, more: part[index][there] if more else part[index])
        return series if self.window is None else series.known_within(self.window)

    @property
    def window(self) -> tuple[Any, Any] | None:
        """Shortest and longest time [s] of the data to which the series was fitted; None without data."""
        return self.__dict__.get("_window")

    def known_within(self, window: tuple[Any, Any] | None) -> PronySeries:
        """Return the same series, known for times [s] within a window, which a material of this series keeps."""
        series = self._each(lambda part, more: part)
        series.__dict__["_window"] = window
        return series

    @property
    def n_branches(self) -> int:
        """Number of branches as given, those with zero modulus included."""
        return self.branch_moduli.shape[-1]

    @property
    def instantaneous_modulus(self) -> Any:
        """Glass modulus R_0 = R_inf + sum R_k [Pa]; infinite with a dashpot in parallel."""
        glass = np.where(
            np.asarray(self.parallel_viscosity) > 0.0, math.inf, self.equilibrium_modulus + self.branch_moduli.sum(-1)
        )
        return glass if glass.ndim else float(glass)

    @property
    def flow_viscosity(self) -> Any:
        """Viscosity eta + sum R_k tau_k [Pa s] of the steady flow of a liquid."""
        viscosity = self.parallel_viscosity + (self.branch_moduli * self.relaxation_times).sum(-1)
        return viscosity if np.ndim(viscosity) else float(viscosity)

    @property
    def is_zero(self) -> Any:
        """Whether the function is zero at all times."""
        return (self.equilibrium_modulus == 0) & self.is_elastic

    @property
    def is_elastic(self) -> Any:
        """Whether nothing relaxes: a spring alone."""
        elastic = ~(np.asarray(self.parallel_viscosity) > 0.0) & ~self.branch_moduli.any(axis=-1)
        return elastic if self.shape else bool(elastic)

    @property
    def is_liquid(self) -> Any:
        """Whether the equilibrium modulus is zero, so that a load makes it flow for ever."""
        return self.equilibrium_modulus == 0

    def plot(self, window: tuple[float, float] | None = None) -> Figure:
        """Return a figure of the relaxation modulus over time, and of storage and loss modulus over frequency.

        The window is the shortest and the longest time [s], by default a decade beyond the relaxation times.
        """
        if self.shape:
            raise InputError("series", rule=f"must be a single one, not an array of shape {self.shape}; take a row")
        if window is not None:
            rule = "must be the shortest and the longest time"
            low, high = (single_positive("window", end, "s") for end in pair("window", window, rule))
            window = min(low, high), max(low, high)
        return draw("material.overview", {"modulus": self}, window)

    def relaxation_modulus(self, time: ArrayLike) -> Any:
        """Return the relaxation modulus R(t) [Pa] at the times t >= 0 [s]; infinite at t = 0 with a dashpot.

        The times have any shape, which broadcasts against that of an array of series.

        Examples
        --------
        >>> PronySeries(1.0, [2.0], [3.0]).relaxation_modulus([0.0, 3.0])
        array([3.        , 1.73575888])
        """
        t = np.asarray(nonnegative("time", time, "s"))
        with np.errstate(over="ignore"):
            value = self.equilibrium_modulus + self._sum(np.exp(-t[..., None] / self.relaxation_times))
        return np.where((t == 0) & (np.asarray(self.parallel_viscosity) > 0), np.inf, value)[()]

    def _sum(self, shares: NDArray[Any]) -> Any:
        """Return the sum of branch moduli times shares, in an order that other series do not change."""
        return (shares * self.branch_moduli).sum(axis=-1)

    def creep_compliance(self, time: ArrayLike) -> Any:
        """Return the creep compliance J(t) [1/Pa], the strain under a unit step of stress, at the times t >= 0 [s].

        Examples
        --------
        >>> PronySeries(0.0, [2.0], [3.0]).creep_compliance([0.0, 6.0])
        array([0.5, 1.5])
        """
        t = np.asarray(nonnegative("time", time, "s"))
        glass, fluidity, compliances, times = self.retardation
        with np.errstate(over="ignore"):
            return (glass + fluidity * t - (np.expm1(-t[..., None] / times) * compliances).sum(axis=-1))[()]

    @cached_property
    def retardation(self) -> Retardation:
        """Retardation spectrum: 1/R(s) of the Carson transform R(s), in partial fractions."""
        if np.any(self.is_zero):
            raise InputError("equilibrium_modulus", 0.0, "must be > 0, as nothing else carries a load", "Pa")
        short = self.simplified()
        compliances, times = (np.full((short.size, short.n_branches + 1), value) for value in (0.0, 1.0))
        for rows, part in short.groups():
            equilibrium, viscosity, moduli, part_times = part.columns
            roots = secular_roots(equilibrium, viscosity, moduli[:, ::-1], part_times[:, ::-1])
            count = roots.times.shape[1]
            compliances[rows, :count], times[rows, :count] = 1.0 / roots.slopes[:, ::-1], roots.times[:, ::-1]
        refuse_far_apart(compliances, times)
        times, compliances = merged(times, compliances)
        with np.errstate(divide="ignore"):
            glass, flow = 1.0 / short.instantaneous_modulus, np.divide(1.0, short.flow_viscosity)
        shape, fluidity = (*short.shape, times.shape[1]), np.where(short.is_liquid, flow, 0.0)[()]
        return Retardation(glass, fluidity, compliances.reshape(shape), times.reshape(shape))

    def storage_modulus(self, angular_frequency: ArrayLike) -> Any:
        """Return the storage modulus R'(omega) [Pa] at the angular frequencies omega >= 0 [rad/s], any shape.

        Examples
        --------
        >>> series = PronySeries(1.0, [2.0], [0.5])
        >>> print(series.storage_modulus(2.0), series.loss_modulus(2.0), series.loss_tangent(2.0))
        2.0 1.0 0.5
        """
        return self._dynamic(nonnegative("angular_frequency", angular_frequency, "rad/s"))[0]

    def loss_modulus(self, angular_frequency: ArrayLike) -> Any:
        """Return the loss modulus R''(omega) [Pa] at the angular frequencies omega >= 0 [rad/s], any shape."""
        return self._dynamic(nonnegative("angular_frequency", angular_frequency, "rad/s"))[1]

    def complex_modulus(self, angular_frequency: ArrayLike) -> Any:
        """Return the complex modulus R' + i R'' [Pa] at angular frequencies omega >= 0 [rad/s]; NaN at NaN."""
        omega = number("angular_frequency", angular_frequency, "rad/s")
        refuse("angular_frequency", omega, np.isinf(omega), "must be finite", "rad/s")
        storage, loss = self._dynamic(omega)
        return storage + 1j * loss

    def loss_tangent(self, angular_frequency: ArrayLike) -> Any:
        """Return the loss tangent R''/R' at angular frequencies omega > 0 [rad/s]; infinite for a dashpot alone."""
        storage, loss = self._dynamic(nonnegative("angular_frequency", angular_frequency, "rad/s"))
        with np.errstate(divide="ignore", invalid="ignore"):
            return np.divide(loss, storage)[()]

    def _dynamic(self, angular_frequency: ArrayLike) -> tuple[Any, Any]:
        omega = np.asarray(angular_frequency, dtype=np.float64)
        # These forms stay finite for all times from 0 to infinity.
        with np.errstate(over="ignore", divide="ignore"):
            x = omega[..., None] * self.relaxation_times
            storage = self.equilibrium_modulus + self._sum(1.0 / (1.0 + (1.0 / x) ** 2))
            loss = self.parallel_viscosity * omega + self._sum(1.0 / (x + 1.0 / x))
        return storage[()], loss[()]

    def carson_transform(self, s: ArrayLike) -> Any:
        """Return the Carson transform s int_0^inf R(t) exp(-s t) dt [Pa] at s [1/s], real or an array of complex ones.

        Equals R_inf + eta s + sum R_k s tau_k/(1 + s tau_k); at s = i omega it is the complex modulus.

        Examples
        --------
        >>> print(PronySeries(1.0, [2.0], [0.5]).carson_transform(2.0))
        2.0
        """
        is_array = isinstance(s, np.ndarray | np.generic)
        point = np.asarray(
            s if isinstance(s, complex) or (is_array and s.dtype.kind == "c") else finite("s", s, "1/s")
        )
        share = point[..., None] / (point[..., None] + 1.0 / self.relaxation_times)
        return (self.equilibrium_modulus + self.parallel_viscosity * point + self._sum(share))[()]

    def simplified(self) -> PronySeries:
        """Return the same function in its shortest form: no negligible branches, equal times merged, times ascending.

        A branch is negligible if it changes the Carson transform at no s > 0 by more than the fraction 1e-60.

        Examples
        --------
        >>> PronySeries(1.0, [2.0, 0.0, 3.0], [5.0, 1.0, 5.0]).simplified()
        PronySeries(1.0, [5.0], [5.0])
        """
        moduli, times = self.branch_moduli, self.relaxation_times
        keep = moduli > moduli.max(axis=-1, initial=0.0, keepdims=True) * _NEGLIGIBLE
        if keep.all() and (times[..., 1:] > times[..., :-1]).all():
            return self
        if not keep.all():
            # Its share of R(s) is largest at s = 1/tau_k.
            with np.errstate(over="ignore"):
                at_times = self.carson_transform(np.moveaxis(1.0 / times, -1, 0))
            keep = moduli > _NEGLIGIBLE * np.moveaxis(at_times, 0, -1)
        times, moduli = merged(times, np.where(keep, moduli, 0.0))
        short = PronySeries.from_checked(self.equilibrium_modulus, moduli, times, self.parallel_viscosity)
        return short if self.window is None else short.known_within(self.window)

    def groups(self) -> Iterator[tuple[NDArray[np.intp], PronySeries]]:
        """Yield series of equal numbers of branches, and their rows, from an array of simplified ones.

        A sum over branches of zero modulus may round otherwise, and a row must not depend on others.
        """
        rows = self.reshaped((self.size,))
        counts = (rows.branch_moduli > 0.0).sum(axis=1)
        for count in np.unique(counts).tolist():
            places = np.flatnonzero(counts == count)
            # Bound in the generator at once.
            yield places, rows._each(lambda part, more, n=count, at=places: part[at, :n] if more else part[at])

    def scaled(self, factor: ArrayLike, *, time_factor: ArrayLike = 1.0) -> PronySeries:
        """Return series with every modulus times `factor` >= 0 and every time times `time_factor` > 0.

        Arrays of factors broadcast against the shape of the series.

        Examples
        --------
        >>> PronySeries(1.0, [2.0], [3.0]).scaled(2.0, time_factor=0.1)
        PronySeries(2.0, [4.0], [0.30000000000000004])
        """
        modulus, stretch = nonnegative("factor", factor), positive("time_factor", time_factor)
        # The new series refuses numbers that overflow.
        with np.errstate(over="ignore"):
            moduli = self.branch_moduli * np.asarray(modulus)[..., None]
            times = self.relaxation_times * np.asarray(stretch)[..., None]
        viscosity = self.parallel_viscosity * modulus * stretch
        # An infinite spring stands for an incompressible material among others.
        is_rigid = np.isinf(self.equilibrium_modulus).any()
        build = PronySeries.from_checked if is_rigid else PronySeries.of_positive
        series = build(self.equilibrium_modulus * modulus, moduli, times, viscosity)
        if self.window is None:
            return series
        return series.known_within((self.window[0] * stretch, self.window[1] * stretch))

    def _key(self) -> tuple[Any, ...]:
        # Adding 0.0 makes one of the two zeros.
        parts = self.equilibrium_modulus, self.parallel_viscosity, self.branch_moduli, self.relaxation_times
        return (self.shape, *((np.asarray(part) + 0.0).tobytes() for part in parts))

    def __eq__(self, other: object) -> bool:
        return self._key() == other._key() if isinstance(other, PronySeries) else NotImplemented

    def __hash__(self) -> int:
        return hash(self._key())

    def __repr__(self) -> str:
        equilibrium, viscosity, moduli, times = (
            np.asarray(part).tolist()
            for part in (
                self.equilibrium_modulus, self.parallel_viscosity, self.branch_moduli, self.relaxation_times
            )
        )  # fmt: skip
        dashpot = f", parallel_viscosity={viscosity!r}" if np.any(self.parallel_viscosity) else ""
        branches = f", {moduli!r}, {times!r}" if self.n_branches else ""
        return f"PronySeries({equilibrium!r}{branches}{dashpot})"


def _view(values: Any, shape: tuple[int, ...]) -> Array:
    """Return an array of a shape; `np.broadcast_to` takes two microseconds also where it has nothing to do."""
    return values if np.shape(values) == shape else np.broadcast_to(values, shape)


def merged(times: Array, *moduli: Array) -> list[Array]:
    """Return ascending times of branches, shape (..., k), and the moduli of one or several series on them.

    Equal times become one branch. Branches whose moduli are all zero come last, in fewer columns.
    """
    order = np.argsort(np.where(_any(moduli), times, np.inf), axis=-1, kind="stable")
    times, *parts = (np.take_along_axis(part, order, axis=-1) for part in (times, *moduli))
    there = _any(parts)
    new = there.copy()
    new[..., 1:] &= times[..., 1:] != times[..., :-1]
    most = int(new.sum(axis=-1).max(initial=0))
    if np.array_equal(new, there):
        return [np.where(there, times, 1.0)[..., :most], *(np.where(there, part, 0.0)[..., :most] for part in parts)]
    shape = (*times.shape[:-1], most)
    places = *np.nonzero(there)[:-1], (new.cumsum(axis=-1) - 1)[there]
    all_times, sums = np.ones(shape), [np.zeros(shape) for _ in parts]
    for total, part in zip(sums, parts, strict=True):
        np.add.at(total, places, part[there])
    all_times[places] = times[there]
    return [all_times, *sums]


def _any(moduli: Sequence[Array]) -> NDArray[np.bool_]:
    """Return whether a modulus of any series is above zero."""
    there = moduli[0] > 0.0
    for part in moduli[1:]:
        there |= part > 0.0
    return there
