"""Isotropic linear-viscoelastic materials: their shear and bulk relaxation, and their reduced modulus in a contact."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, fields, replace
from functools import cached_property, reduce
from typing import TYPE_CHECKING, Any, ClassVar, Literal

import numpy as np
from numpy.typing import ArrayLike, NDArray

from restitution.axes import Axes, aligned, named, spread_array
from restitution.checks import common_shape, instance, nonnegative, pair, positive, truth
from restitution.errors import InputError, InputTypeError
from restitution.material.conversion import (
    on_common_times,
    poisson_ratio,
    reduced,
    reduced_in_shear,
    series_connection,
)
from restitution.material.prony import PronySeries, in_range, secular_roots
from restitution.material.shift import Shift
from restitution.quantities import check
from restitution.result import draw

if TYPE_CHECKING:
    from matplotlib.figure import Figure

Derivation = Literal["fit", "fractional"]
# Points in a decade, at most so many, at which the Poisson ratio is sought between its ends, and how far these are
# beyond the relaxation times; numbers of arrays that are in memory at a time.
_POINTS, _MOST_POINTS, _BEYOND, _AT_A_TIME = 4, 200, 30.0, 1_000_000
# Window of a material without one, beside others.
_ALL_TIMES = 1e-100, 1e100


@dataclass(frozen=True, init=False, repr=False, eq=False)
class Material:
    """Isotropic linear-viscoelastic material, given by its shear and bulk relaxation moduli, or an array of them.

    Parameters
    ----------
    shear
        Relaxation modulus in shear G(t) [Pa]; numbers mean elastic. Not zero throughout.
    bulk
        Relaxation modulus in bulk K(t) [Pa]; numbers mean elastic, `math.inf` incompressible, 0 a Poisson
        ratio of -1.
    density, name
        Mass density rho [kg/m^3], for the check whether an impact is quasi-static, and name of the material.
    shift, temperature
        Time-temperature shift, used by `at`. Temperature of the moduli [K], by default the reference of `shift`.
    source, assumptions
        Source of the numbers, and assumptions made beyond it.
    window
        Shortest and longest time [s] for which the moduli hold, at `temperature`; by default those of the data to
        which the series were fitted.
    undetermined
        Constants of the material that the data behind it do not determine, such as ``("equilibrium_modulus",)``;
        results warn of them. Without a `window`, the data contain no time and no force.
    derivation
        How the moduli were derived from the source, for `restitution.cite`: "fit" of a Prony series to data, a
        "fractional" model, or None.

    Raises
    ------
    InputError
        If a number is out of range.
    InputTypeError
        If a modulus is neither a number nor a `PronySeries`.

    Notes
    -----
    The shapes of moduli, density and temperature broadcast to the `shape` of an array of materials. DataArrays keep
    their dimensions and coordinates by name, in `axes`.

    Examples
    --------
    >>> rubber = Material(PronySeries(1e6, [5e6], [1e-4]), bulk=2e9, density=1100.0)
    >>> print(round(rubber.poisson_ratio, 5), round(rubber.instantaneous_poisson_ratio, 5))
    0.49975 0.4985
    """

    shear: PronySeries
    bulk: PronySeries | float
    density: Any
    name: str | None
    shift: Shift | None
    temperature: Any
    source: str | None
    window: tuple[Any, Any] | None
    assumptions: str | None
    derivation: Derivation | None
    undetermined: tuple[str, ...] | None

    def __init__(
        self,
        shear: PronySeries | ArrayLike,
        bulk: PronySeries | ArrayLike,
        *,
        density: ArrayLike | None = None,
        name: str | None = None,
        shift: Shift | None = None,
        temperature: ArrayLike | None = None,
        source: str | None = None,
        window: tuple[ArrayLike, ArrayLike] | None = None,
        assumptions: str | None = None,
        derivation: Derivation | None = None,
        undetermined: Sequence[str] | None = None,
    ) -> None:
        values, axes = aligned({"shear": shear, "bulk": bulk, "density": density, "temperature": temperature})
        shear, bulk, density, temperature = values.values()
        shear = _series("shear", shear)
        if (np.asarray(shear.equilibrium_modulus) == 0.0).any() and np.any(shear.is_zero):
            raise InputError("shear", 0.0, "must not be zero throughout", "Pa")
        bulk = _bulk(bulk)
        density = None if density is None else check("density", density)
        if shift is not None and not (hasattr(shift, "factor") and hasattr(shift, "reference_temperature")):
            raise InputTypeError("shift", shift, "must be a shift law, such as WLF(reference_temperature, c1, c2)")
        if temperature is not None:
            temperature = check("temperature", temperature)
        elif shift is not None:
            temperature = shift.reference_temperature
        series = [part for part in (shear, bulk) if isinstance(part, PronySeries)]
        times = common_window(part.window for part in series) if window is None else time_window(window)
        self.__dict__.update(shear=shear, bulk=bulk, density=density, name=name, shift=shift, temperature=temperature)
        self.__dict__.update(source=source, window=times, assumptions=assumptions, derivation=derivation)
        self.__dict__.update(undetermined=_names("undetermined", undetermined))
        shapes = {name: part.shape for name, part in zip(("shear", "bulk"), series, strict=False)}
        numbers: dict[str, Any] = {"density": density, "temperature": temperature}
        self.__dict__["shape"] = common_shape(shapes | {name: np.shape(value) for name, value in numbers.items()})
        named(self, axes)

    shape: ClassVar[tuple[int, ...]]
    """Shape of an array of materials; () for one."""
    axes: ClassVar[Axes | None] = None
    """Names of the axes of an array of materials; None where they have no names."""

    @classmethod
    def stacked(cls, materials: Sequence[Material]) -> Material:
        """Return an array of shape (n,) of single materials, which may be of unlike kinds.

        What they do not share (name, source, shift) is left out, and so is a density that one of them lacks.

        Examples
        --------
        >>> both = Material.stacked([Material(1e6, math.inf), Material(PronySeries(0.0, [1e7], [1e-3]), 1e9)])
        >>> print(both.shape, both.poisson_ratio)
        (2,) [0.5 0.5]
        """
        if not materials:
            raise InputError("materials", rule="must hold at least one Material")
        for place, material in enumerate(materials):
            single_material(f"materials[{place}]", material)
        shared: dict[str, Any] = {}
        for name in ("name", "shift", "source", "assumptions", "derivation"):
            values = [getattr(material, name) for material in materials]
            shared[name] = values[0] if values and all(value == values[0] for value in values) else None
        for name in ("density", "temperature"):
            values = [getattr(material, name) for material in materials]
            shared[name] = None if None in values else np.array(values, dtype=np.float64)
        windows = [material.window for material in materials]
        if any(window is not None for window in windows):
            ends = np.array([window or _ALL_TIMES for window in windows])
            shared["window"] = ends[:, 0], ends[:, 1]
        unknown = {name for material in materials for name in material.undetermined or ()}
        bulks = [each.bulk if isinstance(each.bulk, PronySeries) else RIGID for each in materials]
        shear = PronySeries.stacked([material.shear for material in materials])
        return cls(shear, PronySeries.stacked(bulks), undetermined=sorted(unknown) or None, **shared)

    def row(self, *index: int) -> Material:
        """Return one material of an array."""
        shape = self.shape
        return self._each(
            lambda value: float(np.broadcast_to(value, shape)[index]),
            lambda series: series.broadcast_to(shape).row(*index),
        )

    def take(self, shape: tuple[int, ...], places: NDArray[np.intp]) -> Material:
        """Return materials of an array, raveled from a larger shape, in the shape of the places."""
        if not self.shape:
            return self
        if not np.ndim(places):
            return self.broadcast_to(shape).row(*map(int, np.unravel_index(int(places), shape)))
        return self._each(
            lambda value: np.broadcast_to(value, shape).reshape(-1)[places],
            lambda series: series.broadcast_to(shape).reshaped((math.prod(shape),)).take(places),
        )

    def broadcast_to(self, shape: tuple[int, ...]) -> Material:
        """Return views of the materials in a larger array."""
        return self._each(lambda value: np.broadcast_to(value, shape), lambda series: series.broadcast_to(shape))

    def reshaped(self, shape: tuple[int, ...]) -> Material:
        """Return the same materials in an array of another shape."""
        rows = self.shape
        return self._each(
            lambda value: np.broadcast_to(value, rows).reshape(shape),
            lambda series: series.broadcast_to(rows).reshaped(shape),
        )

    def spread(self, names: tuple[Any, ...], axes: Axes | None = None) -> Material:
        """Return the materials of an array over axes of other names; their own are `axes`."""
        target, shape = axes or self.axes, self.shape
        if not shape or target is None:
            return self
        return self._each(
            lambda value: spread_array(value, target, names, shape),
            lambda series: series.broadcast_to(shape).spread(names, target),
        )

    def _each(self, number: Callable[[Any], Any], modulus: Callable[[PronySeries], PronySeries]) -> Material:
        """Return materials with a change of the shape of all numbers."""
        names = [name for name in ("density", "temperature") if np.ndim(getattr(self, name))]
        parts: dict[str, Any] = {name: number(getattr(self, name)) for name in names}
        if self.window is not None and any(map(np.ndim, self.window)):
            parts["window"] = tuple(map(number, self.window))
        series = {name: getattr(self, name) for name in ("shear", "bulk")}
        parts |= {name: modulus(each) for name, each in series.items() if isinstance(each, PronySeries)}
        return replace(self, **parts) if self.shape or parts["shear"].shape else self

    def _key(self) -> tuple[Any, ...]:
        return tuple(_plain(getattr(self, field.name)) for field in fields(self))

    def __eq__(self, other: object) -> bool:
        return self._key() == other._key() if isinstance(other, Material) else NotImplemented

    def __hash__(self) -> int:
        return hash(self._key())

    def plot(self) -> Figure:
        """Return a figure of the relaxation moduli over time, and of storage and loss moduli over frequency."""
        single_material("material", self)
        series = {"shear": self.shear} | ({"bulk": self.bulk} if isinstance(self.bulk, PronySeries) else {})
        return draw("material.overview", series, self.window)

    def at(self, temperature: ArrayLike) -> Material:
        """Return the material at another temperature [K]: every time is multiplied by the ratio of the shift factors.

        Temperatures of any shape broadcast against that of the materials.

        The moduli themselves and the density stay (thermorheologically simple, without a vertical shift).

        Raises
        ------
        InputError
            If the material has no `shift`, or the temperature is outside its range.

        Examples
        --------
        >>> from restitution.material.shift import WLF
        >>> warm = Material(PronySeries(0.0, [1e9], [1.0]), 2e9, shift=WLF(300.0, 10.0, 100.0))
        >>> print(round(warm.at(325.0).shear.relaxation_times[0], 12))
        0.01
        """
        values, axes = aligned({"material": self, "temperature": temperature})
        if axes is not None:
            return named(values["material"]._at(values["temperature"]), axes)
        return self._at(temperature)

    def _at(self, temperature: ArrayLike) -> Material:
        """Return the material at another temperature [K], whose axes have those of the material or no names."""
        factor = self.shift_factor(temperature)
        temperature = check("temperature", temperature)
        bulk, window = self.bulk, self.window
        return replace(
            self,
            shear=self.shear.scaled(1.0, time_factor=factor),
            bulk=bulk.scaled(1.0, time_factor=factor) if isinstance(bulk, PronySeries) else bulk,
            temperature=temperature,
            window=None if window is None else (window[0] * factor, window[1] * factor),
        )

    def shift_factor(self, temperature: ArrayLike) -> Any:
        """Return the factor by which all times grow from the temperature of the moduli to another one [K]."""
        if self.shift is None or self.temperature is None:
            rule = "must not be given without a time-temperature shift"
            raise InputError("temperature", temperature, rule, "K")
        return self.shift.factor(temperature) / self.shift.factor(self.temperature)

    def __repr__(self) -> str:
        named = {field.name: getattr(self, field.name) for field in fields(self)}
        arguments = ", ".join(f"{name}={value!r}" for name, value in named.items() if value is not None)
        return f"Material({arguments})"

    @property
    def is_incompressible(self) -> Any:
        """Whether the bulk modulus is infinite."""
        if not isinstance(self.bulk, PronySeries):
            return True
        rigid = np.isinf(self.bulk.equilibrium_modulus)
        return rigid if rigid.ndim else bool(rigid)

    @property
    def poisson_ratio(self) -> Any:
        """Static Poisson ratio nu = (3K - 2G)/(6K + 2G), that of the equilibrium moduli."""
        return self._poisson_ratio("equilibrium_modulus", "flow_viscosity")

    @property
    def instantaneous_poisson_ratio(self) -> Any:
        """Poisson ratio nu = (3K - 2G)/(6K + 2G) of the instantaneous moduli."""
        return self._poisson_ratio("instantaneous_modulus", "parallel_viscosity")

    def _poisson_ratio(self, modulus: str, viscosity: str) -> Any:
        """Return the Poisson ratio of the moduli; of the viscosities if both moduli are zero or infinite."""
        if not isinstance(self.bulk, PronySeries):
            return np.full(self.shear.shape, 0.5)[()] if self.shear.shape else 0.5
        rigid = np.isinf(self.bulk.equilibrium_modulus)
        shear, bulk = getattr(self.shear, modulus), getattr(self.bulk, modulus)
        shears, bulks = getattr(self.shear, viscosity), getattr(self.bulk, viscosity)
        same = (shear == bulk) & ((np.asarray(shear) == 0.0) | np.isinf(shear)) & ~rigid
        ratio = poisson_ratio(np.where(same, shears, shear), np.where(same, bulks, bulk))
        ratio = np.where(rigid, 0.5, ratio)
        return ratio if ratio.ndim else float(ratio)

    @cached_property
    def _reduced(self) -> PronySeries:
        """Reduced modulus of the contact with a rigid body."""
        return reduced(self.shear, self.bulk if isinstance(self.bulk, PronySeries) else RIGID)

    @cached_property
    def _reduced_in_shear(self) -> PronySeries:
        """Reduced shear modulus of the contact with a rigid body."""
        return reduced_in_shear(self.shear, self.bulk if isinstance(self.bulk, PronySeries) else RIGID)

    def relaxation_poisson_ratio(self, time: ArrayLike) -> Any:
        """Return the Poisson ratio nu(t) [-], the lateral contraction at times t >= 0 [s] after a step of strain.

        The Carson transform of nu is (3K - 2G)/(6K + 2G) of the transforms K(s) and G(s). It runs from
        `instantaneous_poisson_ratio` at t = 0 to `poisson_ratio`. The times have any shape.

        Notes
        -----
        With 1/2 - nu = 3G/(6K + 2G), a sum of exponentials whose rates are the roots of 6K + 2G.
        Tschoegl, Knauss and Emri, Mech. Time-Depend. Mater. 6 (2002) 3.

        Examples
        --------
        >>> polymer = Material(PronySeries(1e6, [1e9], [1e-3]), bulk=3e9)
        >>> polymer.relaxation_poisson_ratio([0.0, 1e-3, 1.0]).round(3)
        array([0.35 , 0.439, 0.5  ])
        """
        t = np.asarray(nonnegative("time", time, "s"))
        if not isinstance(self.bulk, PronySeries):
            return np.full(np.broadcast_shapes(t.shape, self.shape), 0.5)[()]
        shear, rigid = self.shear.simplified(), np.isinf(self.bulk.equilibrium_modulus)
        soft = np.where(rigid, 1.0, self.bulk.equilibrium_modulus)[()]
        bulk = replace(self.bulk, equilibrium_modulus=soft).simplified()
        n = math.prod(self.shape)
        shares, times = (np.full((n, shear.n_branches + bulk.n_branches + 1), value) for value in (0.0, 1.0))
        for rows, common, shears, bulks in on_common_times(shear, bulk):
            constant, viscosity, weights = (2.0 * g + 6.0 * k for g, k in zip(shears, bulks, strict=True))
            roots = secular_roots(constant, viscosity, weights, common)
            at_roots = shears.constant[:, None] - shears.viscosity[:, None] / roots.times
            at_roots = at_roots + (roots.terms * shears.weights[:, None, :]).sum(axis=2)
            count = roots.times.shape[1]
            shares[rows, :count], times[rows, :count] = 3.0 * at_roots / roots.slopes, roots.times
        branches = (*self.shape, shares.shape[1])
        decays = np.exp(-t[..., None] / times.reshape(branches))
        transient = (decays * shares.reshape(branches)).sum(axis=-1)
        ratio = np.where(t == 0, self.instantaneous_poisson_ratio, self.poisson_ratio + transient)
        return np.where(rigid, 0.5, ratio)[()]

    def wave_speed(self, time: ArrayLike) -> Any:
        """Return the speed sqrt(G(t)/rho) [m/s] of shear waves, the slowest ones, at the modulus of a time t [s].

        For an impact the time is that of the contact. None without a density.

        Examples
        --------
        >>> print(Material(PronySeries(0.0, [4e6], [1.0]), 2e9, density=1000.0).wave_speed(2.0 * np.log(2.0)))
        31.622776601683793
        """
        return None if self.density is None else np.sqrt(self.shear.relaxation_modulus(time) / self.density)


def poisson_ratio_range(material: Material) -> tuple[Any, Any]:
    """Return the smallest and the largest Poisson ratio (3K - 2G)/(6K + 2G) of the Carson transforms, over all times.

    Where one modulus alone relaxes the ratio is monotone. Where both do, it may leave the range between its ends.
    """
    ends = material.poisson_ratio, material.instantaneous_poisson_ratio
    low, high = np.minimum(*ends), np.maximum(*ends)
    bulk = material.bulk
    if not isinstance(bulk, PronySeries) or np.all(material.shear.is_elastic) or np.all(bulk.is_elastic):
        return low, high
    times = list[NDArray[np.float64]]()
    for series in (material.shear, bulk):
        times.append(series.relaxation_times[series.branch_moduli > 0.0])
        spring, dashpot = np.broadcast_arrays(series.equilibrium_modulus + series.branch_moduli.sum(axis=-1),
                                              series.parallel_viscosity)  # fmt: skip
        there = (dashpot > 0.0) & (spring > 0.0) & np.isfinite(spring)
        times.append(dashpot[there] / spring[there])
    all_times = np.concatenate(times)
    if not all_times.size:
        return low, high
    first, last = all_times.min() / _BEYOND, all_times.max() * _BEYOND
    count = min(math.ceil(_POINTS * math.log10(last / first)), _MOST_POINTS)
    points = np.geomspace(1.0 / last, 1.0 / first, count)
    branches = 1 + max(material.shear.n_branches, bulk.n_branches)
    for s in np.array_split(points, math.ceil(count * math.prod(material.shape) * branches / _AT_A_TIME) or 1):
        s = s.reshape(-1, *(1,) * len(material.shape))
        ratios = poisson_ratio(material.shear.carson_transform(s), bulk.carson_transform(s))
        low, high = np.minimum(low, ratios.min(axis=0)), np.maximum(high, ratios.max(axis=0))
    return low, high


def single_material(field: str, material: Any) -> Material:
    """Return a material, refusing arrays of them and everything else."""
    instance(field, material, Material, "must be a Material")
    if material.shape:
        raise InputError(field, rule=f"must be a single Material, not an array of shape {material.shape}; take a row")
    return material


def _names(field: str, names: Any) -> tuple[str, ...] | None:
    """Return names as a tuple; None if there are none."""
    if names is None:
        return None
    if isinstance(names, str) or not isinstance(names, Sequence) or not all(isinstance(name, str) for name in names):
        raise InputTypeError(field, names, "must be a list of names of constants")
    return tuple(names) or None


def time_window(window: Any) -> tuple[Any, Any]:
    """Return the shortest and longest time [s] of a window, which must ascend."""
    low, high = (positive("window", time, "s") for time in pair("window", window, "must be two times [s]"))
    if np.any(low >= np.asarray(high)):
        ends = f"({np.min(low):g}, {np.max(high):g})"
        raise InputError("window", ends, "must ascend", "s")
    return low, high


def common_window(windows: Iterable[tuple[Any, Any] | None]) -> tuple[Any, Any] | None:
    """Return times [s] within all windows; None without one."""
    finite_windows = [window for window in windows if window is not None]
    if len(finite_windows) < 2:
        return finite_windows[0] if finite_windows else None
    lows, highs = zip(*finite_windows, strict=True)
    return reduce(np.maximum, lows)[()], reduce(np.minimum, highs)[()]


def _series(name: str, value: Any) -> PronySeries:
    return value if isinstance(value, PronySeries) else PronySeries(nonnegative(name, value, "Pa"))


def bulk_series(modulus: ArrayLike, viscosity: ArrayLike = 0.0) -> PronySeries | float:
    """Return springs [Pa] beside dashpots [Pa s] in bulk; infinite springs are incompressible."""
    moduli = np.asarray(check("bulk_modulus", modulus, "bulk"))
    moduli = np.broadcast_to(moduli, np.broadcast_shapes(moduli.shape, np.shape(viscosity)))
    rigid = np.isposinf(moduli)
    if rigid.all():
        return math.inf
    soft = np.where(rigid, 1.0, moduli)
    in_range("equilibrium_modulus + sum of branch_moduli", soft, "Pa")
    springs = PronySeries.springs(np.where(rigid, math.inf, soft))
    if np.ndim(viscosity) == 0 and not viscosity:
        return springs
    dashpots = PronySeries(0.0, parallel_viscosity=np.where(rigid, 0.0, viscosity)).parallel_viscosity
    return PronySeries.from_checked(
        springs.equilibrium_modulus, springs.branch_moduli, springs.relaxation_times, dashpots
    )


def _bulk(value: Any) -> PronySeries | float:
    """Return the bulk relaxation; infinite if all materials are incompressible."""
    if isinstance(value, PronySeries):
        return math.inf if np.isinf(value.equilibrium_modulus).all() else value
    return math.inf if value is math.inf else bulk_series(value)


def _plain(value: Any) -> Any:
    """Return a value that can be compared and hashed."""
    if isinstance(value, tuple):
        return tuple(map(_plain, value))
    return (value.shape, value.tobytes()) if isinstance(value, np.ndarray) else value


RIGID = PronySeries.springs(np.float64(math.inf))
"""Bulk relaxation of an incompressible material among others."""


def reduced_modulus(material: Material, counter_material: Material | None = None) -> PronySeries:
    """Return the reduced relaxation modulus E*(t) [Pa] of a material, or of two bodies in contact, simplified.

    By the correspondence principle the Carson transforms obey

        E* = 4G(3K + G)/(3K + 4G),    1/E* = 1/E1* + 1/E2* for two bodies.

    Each is a series connection (of 4G and 4K + 4G/3, or of the two bodies) and so again a Prony series.

    Parameters
    ----------
    material, counter_material
        Materials of the half-space and of the other body; None if the latter is rigid.

    Notes
    -----
    Lee and Radok, J. Appl. Mech. 27 (1960) 438. Valid for small strains, frictionless contact, half-spaces.

    Examples
    --------
    >>> series = reduced_modulus(Material(PronySeries(1.0, [4.0], [1.0]), bulk=4.0))
    >>> print(series.relaxation_times, series.branch_moduli)
    [1. 2.] [4.    3.375]
    """
    instance("material", material, Material, "must be a Material")
    if counter_material is not None:
        instance("counter_material", counter_material, Material, "must be a Material")
        return series_connection(reduced_modulus(material), reduced_modulus(counter_material))
    return material._reduced  # pyright: ignore[reportPrivateUsage]


def reduced_shear_modulus(material: Material, counter_material: Material | None = None) -> PronySeries:
    """Return the reduced relaxation modulus in shear G*(t) [Pa] of a contact that sticks, simplified.

    A tangential displacement u of a contact of radius a that nowhere slips has the force 2 G* a u if G* is constant.
    The Carson transforms obey

        G* = (8/3)G(3K + G)/(3K + 2G) = 4G/(2 - nu),    1/G* = 1/G1* + 1/G2* for two bodies.

    Each is a series connection (of (8/3)G and (8/3)(3K + G), or of the two bodies) and so again a Prony series.

    Parameters
    ----------
    material, counter_material
        Materials of the half-space and of the other body; None if the latter is rigid.

    Notes
    -----
    Mindlin, J. Appl. Mech. 16 (1949) 259, and the correspondence principle. Normal and tangential contact are
    independent of each other where `dundurs_parameter` is 0.

    Examples
    --------
    >>> series = reduced_shear_modulus(Material(PronySeries(1.0, [4.0], [1.0]), bulk=4.0))
    >>> print(series.relaxation_times.round(6), series.branch_moduli.round(6))
    [1.       1.571429] [5.333333 2.493506]
    """
    instance("material", material, Material, "must be a Material")
    if counter_material is not None:
        instance("counter_material", counter_material, Material, "must be a Material")
        return series_connection(reduced_shear_modulus(material), reduced_shear_modulus(counter_material))
    return material._reduced_in_shear  # pyright: ignore[reportPrivateUsage]


def dundurs_parameter(material: Material, counter_material: Material | None = None, *, static: bool = False) -> Any:
    """Return Dundurs' parameter beta [-] of a contact, which couples its normal and its tangential displacements.

    ``beta = (3 E*/4) [1/(3 K1 + G1) - 1/(3 K2 + G2)]``, for a rigid counter body ``(1 - 2 nu)/(2(1 - nu))``. It is 0
    for equal bodies, for an incompressible one on a rigid one, and for two incompressible ones.

    Parameters
    ----------
    material, counter_material
        Materials of the half-space and of the other body; None if the latter is rigid.
    static : bool
        Whether the moduli are those at equilibrium, not the instantaneous ones.

    Returns
    -------
    float or array
        beta, in the shape of the materials; NaN where the ratio of the moduli of both bodies is not known.

    Notes
    -----
    J. Dundurs, J. Appl. Mech. 36 (1969) 650.

    Examples
    --------
    >>> polymer = Material(PronySeries(1.0, [4.0], [1.0]), bulk=4.0)
    >>> print(round(dundurs_parameter(polymer), 12), dundurs_parameter(polymer, polymer))
    0.46875 0.0
    """
    shares, moduli = list[Any](), list[Any]()
    bodies = {"material": material} | ({} if counter_material is None else {"counter_material": counter_material})
    static = truth("static", static)
    for field, body in bodies.items():
        instance(field, body, Material, "must be a Material")
        nu = np.asarray(body.poisson_ratio if static else body.instantaneous_poisson_ratio)
        shares.append(((1.0 - 2.0 * nu) / (2.0 * (1.0 - nu)))[()])
        series = reduced_modulus(body)
        moduli.append(np.asarray(series.equilibrium_modulus if static else series.instantaneous_modulus))
    if counter_material is None:
        return shares[0]
    with np.errstate(divide="ignore", invalid="ignore"):
        ratio = moduli[0] / moduli[1]
        # The softer body decides.
        both = (shares[0] - shares[1] * ratio) / (1.0 + ratio)
        return np.where(np.isposinf(ratio), -shares[1], both)[()]
