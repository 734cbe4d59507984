"""Moduli measured at several temperatures, and their master curve by time-temperature superposition."""

from __future__ import annotations

import math
import warnings
from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import pairwise
from typing import TYPE_CHECKING, Any, TypeVar, get_args

import numpy as np
from numpy.typing import NDArray

from restitution.errors import InputError, InputTypeError, RestitutionWarning
from restitution.material.conversion import Deformation
from restitution.material.fit import DynamicTable, RelaxationTable
from restitution.material.shift import WLF, Arrhenius, ShiftTable
from restitution.material.superposition import (
    Channel,
    Law,
    ShiftLaw,
    Superposition,
    constants_of,
    first_shifts,
    law_of,
    superpose,
)
from restitution.pictures import draw
from restitution.quantities import check_single

if TYPE_CHECKING:
    from matplotlib.figure import Figure

Array = NDArray[np.float64]
Curve = DynamicTable | RelaxationTable
_C = TypeVar("_C", bound=DynamicTable | RelaxationTable)

# Frequencies or times that differ by less are the same one.
_SAME = 1e-6
# A larger misfit gives a warning, and so does a larger error of a shift [decades].
_POOR = 0.05
_UNCERTAIN = 0.3
# Vertical shifts [decades] are of this order at the reference, and farther off that of twice a density times T.
_LIFT = 0.01
# Starts that differ by less [decades] lead to the same shifts.
_ALIKE = 0.3
# Largest gap [decades] between isotherms over which the shift is determined.
_BRIDGE = 0.25


def average(curves: Sequence[_C]) -> _C:
    """Curve of all data of some curves, in ascending order; data at one frequency or time are averaged."""
    first = curves[0]
    names = ("angular_frequency", "storage_modulus", "loss_modulus")
    if isinstance(first, RelaxationTable):
        names = ("time", "modulus")
    columns = [np.concatenate([getattr(curve, name) for curve in curves]) for name in names]
    order = np.argsort(columns[0], kind="stable")
    x = columns[0][order]
    starts = np.flatnonzero(np.concatenate(((True,), np.diff(x) > _SAME * x[1:])))
    counts = np.diff(np.append(starts, x.size))
    means: dict[str, Any] = {
        name: np.add.reduceat(column[order], starts) / counts for name, column in zip(names, columns, strict=True)
    }
    if first.temperature is not None:
        means["temperature"] = float(np.mean([curve.temperature or 0.0 for curve in curves]))
    return replace(first, **means)


@dataclass(frozen=True, eq=False, init=False)
class Isotherms:
    """Moduli over frequency or over time, measured at several temperatures.

    Parameters
    ----------
    tables
        A `DynamicTable` or a `RelaxationTable` with its temperature for each isotherm, at least two; all of one kind
        and in one deformation, at different temperatures.
    source, notes
        Name of the file, and remarks of its reader.

    Raises
    ------
    InputError
        If a temperature is missing or repeated, or the tables are of several kinds.

    Examples
    --------
    >>> omega = np.geomspace(0.1, 100.0, 13)
    >>> shifts = {290.0: 1.2, 300.0: 0.0, 310.0: -0.9}
    >>> tables = [
    ...     DynamicTable(omega, (omega * 10**s) ** 0.4, 0.7 * (omega * 10**s) ** 0.4, temperature=kelvin)
    ...     for kelvin, s in shifts.items()
    ... ]
    >>> curve = Isotherms(tables).superposed(reference_temperature=300.0)
    >>> print(curve.log10_factors.round(3))
    [ 1.2  0.  -0.9]
    """

    tables: tuple[Curve, ...]
    source: str
    notes: tuple[str, ...]

    def __init__(self, tables: Sequence[Curve], *, source: str = "", notes: Sequence[str] = ()) -> None:
        kinds = {type(one) for one in tables}
        if len(kinds) != 1 or not kinds <= {DynamicTable, RelaxationTable} or len(tables) < 2:
            raise InputTypeError("tables", tables, "must be several DynamicTable or several RelaxationTable")
        deformations = {one.deformation for one in tables}
        if len(deformations) > 1:
            wanted = "must be in one deformation, tension or shear, for all tables"
            raise InputError("deformation", ", ".join(map(str, deformations)), wanted, where=source)
        for place, one in enumerate(tables):
            _ = check_single("temperature", one.temperature, f"tables[{place}].temperature")
        ordered = tuple(sorted(tables, key=lambda one: one.temperature or 0.0))
        for colder, warmer in pairwise(ordered):
            if colder.temperature == warmer.temperature:
                raise InputError(
                    "temperature", colder.temperature, "must differ from table to table", "K", where=source
                )
        self.__dict__.update(tables=ordered, source=source, notes=tuple(notes))

    @property
    def temperatures(self) -> Array:
        """Temperatures [K], ascending, shape (m,)."""
        return np.array([one.temperature for one in self.tables], dtype=np.float64)

    @property
    def deformation(self) -> Deformation | None:
        """Deformation of the data, None where the file does not state it."""
        return self.tables[0].deformation

    def superposed(
        self, *, reference_temperature: Any = None, shift: ShiftLaw = "free", vertical: bool = False
    ) -> MasterCurve:
        r"""Master curve of all isotherms, by time-temperature superposition.

        The logarithm of each modulus over that of the reduced frequency $\omega a_T$, or of the reduced time
        $t/a_T$, is a cubic spline. The shifts $\log_{10} a_T$ are those of the least sum of squares of the residuals.

        Parameters
        ----------
        reference_temperature : float
            Temperature T0 [K] of the master curve, within the measured ones; the middle one by default.
        shift : str
            "free": a shift for each isotherm. "wlf", "arrhenius": the constants of `WLF` or `Arrhenius`.
        vertical : bool
            Whether each isotherm has a factor of the modulus as well, of the order of (T/T0)^2.

        Returns
        -------
        MasterCurve
            The data at the reference temperature, for `fit_prony`, and the shift, for `Material`.

        Raises
        ------
        InputError
            If the reference temperature is outside the measured ones, or there are too few data.

        Warns
        -----
        RestitutionWarning
            Of kind "superposition": isotherms do not overlap, a shift rises or is uncertain, or the misfit is above
            0.05, as for a material that is not thermorheologically simple.

        Notes
        -----
        Ferry, *Viscoelastic Properties of Polymers*, 3rd ed. (1980), ch. 11. The standard errors hold for independent
        scatter of the data about one curve. Storage and loss modulus have separate scatter.
        """
        if shift not in get_args(ShiftLaw):
            raise InputError("shift", shift, f"must be one of {', '.join(get_args(ShiftLaw))}")
        kelvin = self.temperatures
        reference = float(kelvin[kelvin.size // 2])
        if reference_temperature is not None:
            reference = check_single("temperature", reference_temperature, "reference_temperature")
        if not kelvin[0] <= reference <= kelvin[-1]:
            wanted = f"must be in [{kelvin[0]:.6g}, {kelvin[-1]:.6g}] K, the measured temperatures"
            raise InputError("reference_temperature", reference, wanted, "K", where=self.source)
        channels = self._channels()
        nearest = int(np.argmin(np.abs(kelvin - reference)))
        lifts = vertical * (_LIFT + 2.0 * np.abs(np.log10(kelvin / reference)))
        lifts[nearest] = 0.0
        # Where the loss modulus does not superpose, the storage modulus alone gives the better start.
        starts = [first_shifts(channels), first_shifts(channels[:1])]
        made: list[tuple[Superposition, Law]] = []
        for start in starts if np.ptp(starts[1] - starts[0]) > _ALIKE else starts[:1]:
            start -= np.interp(reference, kelvin, start)
            law, first, low, high = law_of(shift, kelvin, reference, nearest, start)
            made.append((superpose(channels, law, first, low, high, lifts), law))

        def doubt(one: tuple[Superposition, Law]) -> tuple[int, float]:
            sizes = [channel.ordinate.size for channel in channels]
            return int((_gaps(self.tables, one[0].shifts) > 0.0).sum()), float(np.log(one[0].scatter) @ sizes)

        return self._master_curve(*min(made, key=doubt), shift, reference, nearest)

    def _channels(self) -> list[Channel]:
        numbers = np.repeat(np.arange(len(self.tables)), [_abscissa(one).size for one in self.tables])
        x = np.concatenate([_abscissa(one) for one in self.tables])
        made: list[Channel] = []
        for name in _moduli(self.tables[0]):
            values = np.concatenate([getattr(one, name) for one in self.tables])
            # A loss of zero and the time zero have no logarithm.
            there = (values > 0.0) & np.isfinite(x)
            if there.sum() > 3:
                made.append(Channel(x[there], np.log10(values[there]), numbers[there]))
        counts = np.bincount(made[0].isotherm, minlength=len(self.tables)) if made else np.zeros(1)
        if counts.min() < 2:
            wanted = "must have at least two frequencies or times > 0"
            raise InputError(f"tables[{int(np.argmin(counts))}]", wanted=wanted, where=self.source)
        return made

    def _master_curve(
        self, found: Superposition, law: Law, shift: ShiftLaw, reference: float, nearest: int
    ) -> MasterCurve:
        kelvin = self.temperatures
        _, slopes = law(found.parameters)
        shifts = found.shifts
        if shift == "free":
            # The shift is linear between temperatures, as in `ShiftTable`, and zero at the reference.
            at_reference = np.array([np.interp(reference, kelvin, column) for column in np.eye(kelvin.size)])
            shifts = shifts - at_reference @ shifts
            slopes = slopes - at_reference @ slopes
        covariance = found.covariance
        lost = np.isinf(np.diag(covariance))
        variances = np.einsum("ij,jk,ik->i", slopes[:, ~lost], covariance[np.ix_(~lost, ~lost)], slopes[:, ~lost])
        errors = np.sqrt(np.maximum(variances, 0.0))
        errors[np.any(np.abs(slopes[:, lost]) > 0.0, axis=1)] = np.inf
        if shift == "free":
            # The smoothness of the master curve bridges small gaps alone.
            for place in np.flatnonzero(_gaps(self.tables, shifts) > _BRIDGE).tolist():
                errors[place:] = np.inf if place > nearest else errors[place:]
                errors[:place] = np.inf if place <= nearest else errors[:place]
        named, errors_of = constants_of(shift, found, reference)
        factors = 10.0 ** (-found.vertical)
        reduced = zip(self.tables, shifts, factors, strict=True)
        tables = tuple(_reduced(one, s, b, reference) for one, s, b in reduced)
        curve = MasterCurve(
            replace(average(tables), source=self.source, notes=()), tables, self, reference, shift, shifts, errors,
            -found.vertical, found.vertical_errors, named, errors_of, found.misfit,
        )  # fmt: skip
        for line in curve.doubts:
            warnings.warn(RestitutionWarning("superposition", f"{self.source or 'isotherms'}: {line}"), stacklevel=3)
        return curve

    def plot(self) -> Figure:
        """Figure of the isotherms."""
        return draw("material.isotherms", self)


@dataclass(frozen=True, eq=False)
class MasterCurve:
    """Moduli at one temperature that stand for those at all, and the shifts that lead there.

    Attributes
    ----------
    data : DynamicTable or RelaxationTable
        Moduli over the reduced frequency or time at the reference temperature, for `fit_prony`.
    reduced : tuple
        The data of each isotherm alone, over the reduced frequency or time.
    isotherms : Isotherms
        The measured data.
    reference_temperature : float
        T0 [K].
    law : str
        "free", "wlf" or "arrhenius".
    log10_factors, errors : array, shape (m,)
        log10 aT of each isotherm [-], and its standard error [-]; infinite where the data do not determine it.
    log10_vertical_factors, vertical_errors : array, shape (m,)
        log10 of the factor of the moduli of each isotherm [-], and its standard error [-]; zero without such a shift.
    constants, constant_errors : dict
        Constants of the law, `c1` [-] and `c2` [K] or `activation_energy` [J/mol], and their standard errors.
    misfit : float
        Root mean square of the relative residuals about the smooth master curve [-].
    """

    data: Curve
    reduced: tuple[Curve, ...]
    isotherms: Isotherms
    reference_temperature: float
    law: ShiftLaw
    log10_factors: Array
    errors: Array
    log10_vertical_factors: Array
    vertical_errors: Array
    constants: dict[str, float]
    constant_errors: dict[str, float]
    misfit: float

    @property
    def temperatures(self) -> Array:
        """Temperatures of the isotherms [K], ascending, shape (m,)."""
        return self.isotherms.temperatures

    @property
    def shift(self) -> ShiftTable | WLF | Arrhenius:
        """Law of the shift within the measured temperatures, for `Material`.

        Raises
        ------
        InputError
            If free shifts do not fall with the temperature.
        """
        kelvin = self.temperatures
        if self.law == "free":
            if self._rise:
                wanted = f'{self._rise}: must fall with the temperature; use shift="wlf", or fewer isotherms'
                raise InputError("log10_factors", wanted=wanted, where=self.isotherms.source)
            return ShiftTable(kelvin, self.log10_factors)
        law = WLF if self.law == "wlf" else Arrhenius
        limits = float(kelvin[0]), float(kelvin[-1])
        return law(self.reference_temperature, **self.constants, temperature_range=limits)

    @property
    def _rise(self) -> str:
        """First pair of shifts that rise with the temperature, empty if there is none."""
        kelvin, factors = self.temperatures, self.log10_factors
        rises = np.flatnonzero(np.diff(factors) >= 0.0)
        if not rises.size:
            return ""
        pairs = (f"{factors[place]:.3g} at {kelvin[place] - 273.15:.1f} °C" for place in (rises[0], rises[0] + 1))
        return ", ".join(pairs)

    @property
    def doubts(self) -> tuple[str, ...]:
        """Lines on what is doubtful: gaps between the isotherms, uncertain shifts, a large misfit."""
        kelvin, lines = self.temperatures, list[str]()
        for place in np.flatnonzero(_gaps(self.isotherms.tables, self.log10_factors) > 0.0).tolist():
            pair = f"{kelvin[place - 1] - 273.15:.1f} and {kelvin[place] - 273.15:.1f} °C"
            lines.append(f"the isotherms at {pair} do not overlap")
        # Beyond a gap the error is infinite, and the gap has its own line.
        errors = np.where(np.isinf(self.errors), 0.0, self.errors) if lines else self.errors
        if self._rise:
            lines.append(f"the shifts do not fall with the temperature: {self._rise}")
        worst = int(np.argmax(errors))
        if errors[worst] > _UNCERTAIN:
            error = f"{errors[worst]:.2g} decades" if math.isfinite(errors[worst]) else "infinite"
            lines.append(f"the standard error of the shift at {kelvin[worst] - 273.15:.1f} °C is {error}")
        if self.misfit > _POOR:
            line = f"the misfit is {self.misfit:.2g}, above {_POOR:g}: "
            lines.append(f"{line}the material may not be thermorheologically simple, or needs vertical shifts")
        return tuple(lines)

    def plot(self) -> Figure:
        """Figure of the isotherms, the master curve, and the shifts with their standard errors."""
        return draw("material.superposition", self)


def _abscissa(table: Curve) -> Array:
    """log10 of the frequency [rad/s], or of the reciprocal time."""
    if isinstance(table, DynamicTable):
        return np.log10(table.angular_frequency)
    with np.errstate(divide="ignore"):
        return -np.log10(table.time)


def _gaps(tables: Sequence[Curve], shifts: Array) -> Array:
    """Gap [decades] between each isotherm and the colder ones; negative where they overlap, shape (m,)."""
    ends = [(x.min(), x.max()) for x in (one[np.isfinite(one)] for one in map(_abscissa, tables))]
    low, high = (np.array(end) + shifts for end in zip(*ends, strict=True))
    return np.append(-np.inf, np.minimum.accumulate(low)[:-1] - high[1:])


def _moduli(table: Curve) -> tuple[str, ...]:
    return ("storage_modulus", "loss_modulus") if isinstance(table, DynamicTable) else ("modulus",)


def _reduced(table: Curve, shift: float, factor: float, reference: float) -> Curve:
    """Isotherm at the reduced frequencies or times of the reference temperature."""
    changes: dict[str, Any] = {name: getattr(table, name) * factor for name in _moduli(table)}
    if isinstance(table, DynamicTable):
        changes["angular_frequency"] = table.angular_frequency * 10.0**shift
    else:
        changes["time"] = table.time / 10.0**shift
    return replace(table, **changes, temperature=reference)
