"""Measured tables and Prony terms of a material, in SI."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from restitution.checks import nonnegative, positive
from restitution.errors import InputError
from restitution.material.conversion import Deformation
from restitution.material.prony import PronySeries

Array = NDArray[np.float64]

# Printed relative moduli add up to one apart from rounding: four decimals, some thirty terms.
_SUM_TOLERANCE = 2e-3


@dataclass(frozen=True, eq=False)
class RelaxationTable:
    """Relaxation modulus measured over time.

    Attributes
    ----------
    time
        Times [s], strictly ascending, shape (n,).
    modulus
        Relaxation moduli [Pa], positive, shape (n,).
    deformation
        "tension", "shear", "bulk", or None where the file does not state it.
    source
        Name of the file.
    notes
        Remarks of the reader: units that were assumed, columns that are not used.
    """

    time: Array
    modulus: Array
    deformation: Deformation | None = None
    source: str = ""
    notes: tuple[str, ...] = ()


@dataclass(frozen=True, eq=False)
class DynamicTable:
    """Storage and loss modulus measured over frequency (DMA).

    Attributes
    ----------
    angular_frequency
        Angular frequencies [rad/s], strictly ascending, shape (n,).
    storage_modulus, loss_modulus
        Moduli [Pa], positive and non-negative, shape (n,).
    deformation, source, notes
        As in `RelaxationTable`.
    """

    angular_frequency: Array
    storage_modulus: Array
    loss_modulus: Array
    deformation: Deformation | None = None
    source: str = ""
    notes: tuple[str, ...] = ()


@dataclass(frozen=True, eq=False)
class PronyTerms:
    """Terms of a Prony series, absolute or relative to the instantaneous modulus.

    Attributes
    ----------
    relaxation_times
        tau_k [s], shape (n_branch,).
    moduli
        R_k [Pa], or R_k/R_0 [-] if `relative`, shape (n_branch,).
    relative
        Whether the moduli are shares of the instantaneous modulus.
    instantaneous_modulus, equilibrium_modulus
        R_0 and R_inf [Pa], None where the file does not state them.
    deformation, source, notes
        As in `RelaxationTable`.
    """

    relaxation_times: Array
    moduli: Array
    relative: bool
    deformation: Deformation | None = None
    instantaneous_modulus: float | None = None
    equilibrium_modulus: float | None = None
    source: str = ""
    notes: tuple[str, ...] = ()

    @property
    def window(self) -> tuple[float, float] | None:
        """Shortest and longest relaxation time [s], None for a single one."""
        return span(self.relaxation_times)

    @property
    def unit(self) -> str:
        """Unit of the moduli: empty where they are shares of a modulus that the file does not give."""
        known = self.instantaneous_modulus is not None or self.equilibrium_modulus is not None
        return "Pa" if known or not self.relative else ""

    def series(
        self, *, instantaneous_modulus: float | None = None, equilibrium_modulus: float | None = None
    ) -> PronySeries:
        """Prony series, with the end modulus from the file unless given here.

        Absolute terms need no end modulus; without one they are those of a liquid. Relative terms are shares of the
        instantaneous modulus, or of the difference where both end moduli are given. If they add up to one, they are
        those of a liquid.

        Parameters
        ----------
        instantaneous_modulus
            R_0 [Pa].
        equilibrium_modulus
            R_inf [Pa].

        Raises
        ------
        InputError
            If an end modulus is missing or contradicts the terms.

        Examples
        --------
        >>> terms = PronyTerms(np.array([1.0, 10.0]), np.array([0.5, 0.25]), relative=True)
        >>> terms.series(instantaneous_modulus=8.0)
        PronySeries(2.0, [4.0, 2.0], [1.0, 10.0])
        """
        if instantaneous_modulus is None and equilibrium_modulus is None:
            high, low = self.instantaneous_modulus, self.equilibrium_modulus
        else:
            high, low = instantaneous_modulus, equilibrium_modulus
        high = None if high is None else float(positive("instantaneous_modulus", high, "Pa"))
        low = None if low is None else float(nonnegative("equilibrium_modulus", low, "Pa"))
        if self.relative:
            low, moduli = self._from_shares(high, low)
            return PronySeries(low, moduli, self.relaxation_times)
        total = float(self.moduli.sum())
        if high is not None and low is not None and abs(high - low - total) > _SUM_TOLERANCE * high:
            raise _refused("instantaneous", high, f"must be {low + total:g} Pa, the sum of all")
        if low is None:
            low = 0.0 if high is None else high - total
            if low < -_SUM_TOLERANCE * total:
                raise _refused("instantaneous", high, f"must be >= {total:g} Pa, the sum of the terms")
        return PronySeries(max(low, 0.0), self.moduli, self.relaxation_times)

    def _from_shares(self, high: float | None, low: float | None) -> tuple[float, Array]:
        """Equilibrium modulus and branch moduli of relative terms."""
        total = float(self.moduli.sum())
        sum_of_terms = f"the relative moduli add up to {total:.6g}"
        if high is None and low is None:
            names = "instantaneous_modulus or equilibrium_modulus"
            raise InputError(names, wanted="one must be given, as the terms are relative")
        if total > 1.0 + _SUM_TOLERANCE:
            raise InputError("moduli", wanted=f"{sum_of_terms}: must be at most 1")
        if low is None:
            assert high is not None
            return high * max(1.0 - total, 0.0), self.moduli * high
        if high is None:
            if total >= 1.0 - 1e-12:
                raise InputError("moduli", wanted=f"{sum_of_terms}: must be below 1")
            return low, self.moduli * (low / (1.0 - total))
        if low > high:
            raise _refused("equilibrium", low, f"must be <= {high:g} Pa, the instantaneous")
        share = 1.0 - low / high
        if min(abs(total - 1.0), abs(total - share)) > _SUM_TOLERANCE:
            wanted = f"must be 1 (shares of the difference) or {share:.6g} (shares of the instantaneous modulus)"
            raise InputError("moduli", wanted=f"{sum_of_terms}: {wanted}")
        return low, self.moduli * ((high - low) / total)


def _refused(end: str, modulus: float | None, wanted: str) -> InputError:
    return InputError(f"{end}_modulus", modulus, wanted, "Pa")


def span(times: Array) -> tuple[float, float] | None:
    """Return the shortest and the longest of several times, None for fewer than two."""
    return (float(times.min()), float(times.max())) if times.size > 1 else None


def beyond_one(shares: Array) -> int | None:
    """Index of the relative modulus with which their sum passes one, None where it does not.

    Examples
    --------
    >>> beyond_one(np.array([0.75, 0.5, 0.25]))
    1
    """
    beyond = np.flatnonzero(shares.cumsum() > 1.0 + _SUM_TOLERANCE)
    return int(beyond[0]) if beyond.size else None
