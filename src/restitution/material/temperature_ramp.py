"""Moduli over temperature at one frequency, and the master curve that an assumed law of the shift makes of them."""

from __future__ import annotations

import math
import warnings
from dataclasses import dataclass
from typing import Any, ClassVar, NamedTuple

import numpy as np

from restitution.checks import Array, single_positive
from restitution.errors import InputError, RestitutionWarning
from restitution.material.conversion import Deformation
from restitution.material.fit import Columns, DynamicTable
from restitution.material.master_curve import average
from restitution.material.shift import WLF, Arrhenius, ShiftTable
from restitution.units import celsius

C1, C2 = 17.44, 51.6
"""Universal constants of Williams, Landel and Ferry [-], [K] about the glass transition, J. Am. Chem. Soc. 77 (1955)
3701; they hold up to 100 K above it."""
_REACH = 100.0
MEASURED_CONSTANTS = {
    "polyisobutylene": (16.53, 104.4),
    "polybutadiene of 20 % vinyl": (10.2, 11.32),
    "polybutadiene of 50 % vinyl": (27.15, 64.17),
    "polybutadiene of 71 % vinyl": (14.4, 25.5),
    "polybutadiene of 83 % vinyl": (20.7, 42.1),
    "polybutadiene of 97 % vinyl": (14.6, 24.5),
}
"""C1 [-] and C2 [K] of rubbers about their glass transitions: Ferry, Viscoelastic Properties of Polymers, 3rd ed.
(1980), ch. 11, taken from 298 K to 202 K; Mark (ed.), Physical Properties of Polymers Handbook, 2nd ed. (2007), table
26.1."""
# The warning compares shift factors so far [K] above the glass transition.
_COMPARED = 50.0


class ReducedRamp(NamedTuple):
    """Moduli of a ramp over the reduced frequency, and the law of the shift that was assumed."""

    data: DynamicTable
    shift: WLF | Arrhenius | ShiftTable

    @property
    def reference_temperature(self) -> float:
        """Temperature [K] of the reduced frequencies."""
        return self.shift.reference_temperature


@dataclass(frozen=True, eq=False)
class TemperatureRamp(Columns):
    r"""Storage and loss modulus measured over temperature at one frequency.

    Attributes
    ----------
    temperatures : array, shape (n,)
        Temperatures [K], strictly ascending.
    storage_modulus, loss_modulus : array, shape (n,)
        Storage modulus > 0 and loss modulus >= 0 [Pa].
    angular_frequency : float, optional
        $\omega > 0$ [rad/s], None where the file does not state it.
    deformation, source, notes
        As in `RelaxationTable`.

    Examples
    --------
    >>> kelvin = np.linspace(222.0, 322.0, 101)
    >>> loss = 1e8 / np.cosh((kelvin - 242.0) / 8.0)
    >>> storage = 1e6 + 1e9 / (1.0 + np.exp((kelvin - 242.0) / 4.0))
    >>> TemperatureRamp(kelvin, storage, loss, 2 * np.pi).glass_transition
    242.0
    """

    temperatures: Array
    storage_modulus: Array
    loss_modulus: Array
    angular_frequency: float | None = None
    deformation: Deformation | None = None
    source: str = ""
    notes: tuple[str, ...] = ()
    _units: ClassVar[dict[str, str]] = {"temperatures": "K", "storage_modulus": "Pa", "loss_modulus": "Pa"}

    @property
    def glass_transition(self) -> float:
        """Temperature [K] of the peak of the loss modulus, which rises with the frequency by some kelvin a decade."""
        peak = int(np.argmax(self.loss_modulus))
        if peak in (0, self.temperatures.size - 1):
            rule = "has no peak of the loss modulus, which would be the glass transition; give a law of the shift"
            raise InputError("shift", rule=rule, where=self.source)
        return float(self.temperatures[peak])

    def universal_shift(self, c1: float = C1, c2: float = C2) -> WLF:
        """Return the WLF law about the glass transition, with the universal constants or others [-], [K]."""
        middle = self.glass_transition
        return WLF(middle, c1, c2, temperature_range=(middle, middle + _REACH))

    def reduced(
        self, shift: WLF | Arrhenius | ShiftTable | None = None, *, angular_frequency: float | None = None
    ) -> ReducedRamp:
        r"""Return the moduli over the reduced frequency $\omega a_T$, which a law of the shift determines.

        One frequency measures no shift. Each row becomes a frequency at the reference temperature of the law; rows at
        temperatures for which the law does not hold are left out.

        Parameters
        ----------
        shift
            Law of the shift. By default WLF with the universal constants about the glass transition.
        angular_frequency
            $\omega > 0$ [rad/s], where the ramp does not state it.

        Raises
        ------
        InputError
            If the frequency is missing, or without a law, if the loss modulus has no peak.

        Warns
        -----
        RestitutionWarning
            Of kind "ramp", always: nothing in the data confirms the law.
        """
        omega = self._frequency(angular_frequency)
        law = self.universal_shift() if shift is None else shift
        kelvin = self.temperatures
        if isinstance(law, ShiftTable):
            factors = np.full(kelvin.size, np.nan)
            inside = (kelvin >= law.temperatures[0]) & (kelvin <= law.temperatures[-1])
            factors[inside] = law.factor(kelvin[inside])
        else:
            factors = np.asarray(law.factor_or_nan(kelvin))
            low, high = law.temperature_range or (0.0, math.inf)
            factors[(kelvin < low) | (kelvin > high)] = np.nan
        used = np.isfinite(factors)
        if not used.any():
            raise InputError("shift", rule="must hold at a temperature of the ramp", where=self.source)
        notes = list(self.notes)
        if not used.all():
            ends = " to ".join(celsius(end, 4) for end in (kelvin[used][0], kelvin[used][-1]))
            notes.append(f"rows from {ends} °C are used, where the law of the shift holds")
        columns = (omega * factors[used], self.storage_modulus[used], self.loss_modulus[used])
        reference = law.reference_temperature
        table = DynamicTable(*columns, self.deformation, self.source, tuple(notes), reference)
        where, doubt = self.source or "ramp", self._doubt(law, shift is None)
        warnings.warn(RestitutionWarning("ramp", f"{where}: {doubt}"), stacklevel=2)
        return ReducedRamp(average([table]), law)

    def _frequency(self, angular_frequency: float | None) -> float:
        stated = self.angular_frequency
        if angular_frequency is None and stated is None:
            raise InputError("frequency", rule="must be given, as the data do not state it", where=self.source)
        if angular_frequency is None:
            return single_positive("angular_frequency", stated, "rad/s")
        omega = single_positive("angular_frequency", angular_frequency, "rad/s")
        if stated is not None and not math.isclose(omega, stated, rel_tol=1e-2):
            rule = f"must be that of the data, {stated / (2.0 * math.pi):.4g} Hz, or left out"
            raise InputError("frequency", omega / (2.0 * math.pi), rule, "Hz", where=self.source)
        return omega

    def _doubt(self, law: Any, universal: bool) -> str:
        if not universal:
            return "one frequency measures no shift, so that nothing in the data confirms the law that is given"
        at = law.reference_temperature + _COMPARED
        others = [-c1 * _COMPARED / (c2 + _COMPARED) for c1, c2 in MEASURED_CONSTANTS.values()]
        return (
            f"one frequency measures no shift: WLF with the universal constants {C1:g}, {C2:g} K about "
            f"{celsius(law.reference_temperature, 4)} °C, the peak of the loss modulus, is assumed. Its log10 aT at "
            f"{celsius(at, 4)} °C is {math.log10(law.factor(at)):.1f}; with constants of {len(others)} rubbers it is "
            f"{max(others):.1f} to {min(others):.1f}. Measure at several frequencies, or give the law"
        )
