"""Isotropic linear-viscoelastic material: its shear and bulk relaxation, and its reduced modulus in a contact."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, fields, replace
from typing import TYPE_CHECKING, Any, Literal

import numpy as np
from numpy.typing import ArrayLike, NDArray

from restitution.checks import instance, nonnegative, pair, single_positive
from restitution.errors import InputError, InputTypeError
from restitution.material.conversion import (
    NOTHING,
    connect,
    on_common_times,
    poisson_ratio,
    series_connection,
)
from restitution.material.prony import PronySeries
from restitution.material.secular import secular_roots
from restitution.material.shift import Shift
from restitution.pictures import draw
from restitution.quantities import check_single

if TYPE_CHECKING:
    from matplotlib.figure import Figure

Array = NDArray[np.float64]
Derivation = Literal["fit", "fractional"]


@dataclass(frozen=True, init=False, repr=False)
class Material:
    """Isotropic linear-viscoelastic material, given by its shear and bulk relaxation moduli.

    Parameters
    ----------
    shear
        Relaxation modulus in shear G(t) [Pa]; a number means elastic. Not zero throughout.
    bulk
        Relaxation modulus in bulk K(t) [Pa]; a number means elastic, `math.inf` incompressible, 0 a Poisson
        ratio of -1.
    density, name
        Mass density rho [kg/m3], for the check whether an impact is quasi-static, and name of the material.
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

    Examples
    --------
    >>> rubber = Material(PronySeries(1e6, [5e6], [1e-4]), bulk=2e9, density=1100.0)
    >>> print(round(rubber.poisson_ratio, 5), round(rubber.instantaneous_poisson_ratio, 5))
    0.49975 0.4985
    """

    shear: PronySeries
    bulk: PronySeries | float
    density: float | None
    name: str | None
    shift: Shift | None
    temperature: float | None
    source: str | None
    window: tuple[float, float] | None
    assumptions: str | None
    derivation: Derivation | None
    undetermined: tuple[str, ...] | None

    def __init__(
        self,
        shear: PronySeries | float,
        bulk: PronySeries | float,
        *,
        density: float | None = None,
        name: str | None = None,
        shift: Shift | None = None,
        temperature: float | None = None,
        source: str | None = None,
        window: tuple[float, float] | None = None,
        assumptions: str | None = None,
        derivation: Derivation | None = None,
        undetermined: Sequence[str] | None = None,
    ) -> None:
        shear = _series("shear", shear)
        if shear.is_zero:
            raise InputError("shear", 0.0, "must not be zero throughout", "Pa")
        incompressible = isinstance(bulk, int | float) and bulk == math.inf
        bulk = math.inf if incompressible else _series("bulk", bulk)
        density = None if density is None else check_single("density", density)
        if shift is not None and not (hasattr(shift, "factor") and hasattr(shift, "reference_temperature")):
            raise InputTypeError("shift", shift, "must be a shift law, such as WLF(reference_temperature, c1, c2)")
        if temperature is not None:
            temperature = check_single("temperature", temperature)
        elif shift is not None:
            temperature = shift.reference_temperature
        window = _common_window(shear, bulk) if window is None else time_window(window)
        self.__dict__.update(shear=shear, bulk=bulk, density=density, name=name, shift=shift, temperature=temperature)
        self.__dict__.update(source=source, window=window, assumptions=assumptions, derivation=derivation)
        self.__dict__.update(undetermined=_names("undetermined", undetermined))

    def plot(self) -> Figure:
        """Figure of the relaxation moduli over time, and of storage and loss moduli over frequency."""
        series = {"shear": self.shear} | ({"bulk": self.bulk} if isinstance(self.bulk, PronySeries) else {})
        return draw("material.overview", series, self.window)

    def at(self, temperature: float) -> Material:
        """Material at another temperature [K]: every time is multiplied by the ratio of the shift factors.

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
        if self.shift is None or self.temperature is None:
            wanted = "must not be given without a time-temperature shift"
            raise InputError("temperature", temperature, wanted, "K")
        factor = self.shift.factor(temperature) / self.shift.factor(self.temperature)
        bulk, window = self.bulk, self.window
        return replace(
            self,
            shear=self.shear.scaled(1.0, time_factor=factor),
            bulk=bulk.scaled(1.0, time_factor=factor) if isinstance(bulk, PronySeries) else bulk,
            temperature=temperature,
            window=None if window is None else (window[0] * factor, window[1] * factor),
        )

    def __repr__(self) -> str:
        named = {field.name: getattr(self, field.name) for field in fields(self)}
        given = ", ".join(f"{name}={value!r}" for name, value in named.items() if value is not None)
        return f"Material({given})"

    @property
    def is_incompressible(self) -> bool:
        """Whether the bulk modulus is infinite."""
        return not isinstance(self.bulk, PronySeries)

    @property
    def poisson_ratio(self) -> float:
        """Static Poisson ratio nu = (3K - 2G)/(6K + 2G), that of the equilibrium moduli."""
        return self._poisson_ratio("equilibrium_modulus", "flow_viscosity")

    @property
    def instantaneous_poisson_ratio(self) -> float:
        """Poisson ratio nu = (3K - 2G)/(6K + 2G) of the instantaneous moduli."""
        return self._poisson_ratio("instantaneous_modulus", "parallel_viscosity")

    def _poisson_ratio(self, modulus: str, viscosity: str) -> float:
        """Poisson ratio of the moduli; of the viscosities if both moduli are zero or infinite."""
        if not isinstance(self.bulk, PronySeries):
            return 0.5
        shear, bulk = getattr(self.shear, modulus), getattr(self.bulk, modulus)
        if shear == bulk and shear in (0.0, math.inf):
            shear, bulk = getattr(self.shear, viscosity), getattr(self.bulk, viscosity)
        return poisson_ratio(shear, bulk)

    def relaxation_poisson_ratio(self, time: ArrayLike) -> Any:
        """Poisson ratio nu(t) [-], the lateral contraction at the times t >= 0 [s] after a unit step of axial strain.

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
            return np.full(t.shape, 0.5)[()]
        times, shear, bulk = on_common_times(self.shear.simplified(), self.bulk.simplified())
        total = shear.plus(shear, 1.0).plus(bulk, 6.0)
        roots = secular_roots(total.constant, total.viscosity, total.weights, times)
        at_roots, _ = shear.at(roots.times, roots.terms, np.abs(roots.terms))
        transient = np.exp(-t[..., None] / roots.times) @ (3.0 * at_roots / roots.slopes)
        return np.where(t == 0, self.instantaneous_poisson_ratio, self.poisson_ratio + transient)[()]

    def wave_speed(self, time: ArrayLike) -> Any:
        """Speed sqrt(G(t)/rho) [m/s] of shear waves, the slowest ones, at the modulus that acts at a time t [s].

        For an impact the time is that of the contact. None without a density.

        Examples
        --------
        >>> print(Material(PronySeries(0.0, [4e6], [1.0]), 2e9, density=1000.0).wave_speed(2.0 * np.log(2.0)))
        31.622776601683793
        """
        return None if self.density is None else np.sqrt(self.shear.relaxation_modulus(time) / self.density)


def _names(field: str, given: Any) -> tuple[str, ...] | None:
    """Names as a tuple; None if there are none."""
    if given is None:
        return None
    if isinstance(given, str) or not isinstance(given, Sequence) or not all(isinstance(one, str) for one in given):
        raise InputTypeError(field, given, "must be a list of names of constants")
    return tuple(given) or None


def time_window(window: tuple[float, float]) -> tuple[float, float]:
    """Shortest and longest time [s] of a window, which must ascend."""
    low, high = (single_positive("window", time, "s") for time in pair("window", window, "must be two times [s]"))
    if low >= high:
        raise InputError("window", f"({low:g}, {high:g})", "must ascend", "s")
    return low, high


def _common_window(*moduli: PronySeries | float) -> tuple[float, float] | None:
    """Times [s] for which all series that come from data are known; None without data."""
    windows = [one.window for one in moduli if isinstance(one, PronySeries) and one.window is not None]
    return (max(low for low, _ in windows), min(high for _, high in windows)) if windows else None


def _series(name: str, value: Any) -> PronySeries:
    if isinstance(value, PronySeries):
        return value
    modulus = nonnegative(name, value, "Pa")
    if isinstance(modulus, np.ndarray):
        raise InputTypeError(name, value, "must be a number or a PronySeries")
    return PronySeries(modulus)


def reduced_modulus(material: Material, counter_material: Material | None = None) -> PronySeries:
    """Reduced relaxation modulus E*(t) [Pa] of a material, or of two bodies in contact, simplified.

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
    shear = material.shear.simplified()
    if not isinstance(material.bulk, PronySeries):
        return shear.scaled(4.0)
    times, g, k = on_common_times(shear, material.bulk.simplified())
    first = NOTHING.plus(g, 4.0)
    second = NOTHING.plus(g, 4.0 / 3.0).plus(k, 4.0)
    # Where 4G + 4K + 4G/3 = 0, also 4G = -3K, which is exact where G itself cancels.
    return connect(times, first, second, NOTHING.plus(k, 3.0))
