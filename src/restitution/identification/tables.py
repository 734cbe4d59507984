"""Relaxation and dynamic tables as observations of a material."""

from __future__ import annotations

import math
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from restitution.errors import InputError, InputTypeError
from restitution.identification.observations import Curve, Noise, Observations
from restitution.material.columns import MaterialColumns
from restitution.material.fit import DynamicTable, RelaxationTable

Array = NDArray[np.float64]


class Moduli(Observations):
    """Measured relaxation or dynamic moduli of the material.

    Parameters
    ----------
    table : RelaxationTable or DynamicTable
        Measured moduli.
    deformation : {"shear", "tension"}, optional
        Needed if the table does not state it.
    temperature : float, optional
        Temperature [K] of the measurement, for a model with a shift.
    noise : Noise, optional
        Relative standard deviations, as texts such as "2 %": of `modulus`, or of `storage_modulus` and
        `loss_modulus`, the latter relative to the magnitude of E*. Without it the size of the noise is estimated.

    Examples
    --------
    >>> table = RelaxationTable(np.array([0.1, 1.0]), np.array([3e6, 2e6]), "shear")
    >>> Moduli(table, noise=Noise(modulus="1 %")).size
    2
    """

    def __init__(
        self,
        table: RelaxationTable | DynamicTable,
        *,
        deformation: Literal["shear", "tension"] | None = None,
        temperature: float | None = None,
        noise: Noise | None = None,
    ) -> None:
        if not isinstance(table, RelaxationTable | DynamicTable):
            raise InputTypeError(
                "table", table, "must be a RelaxationTable or a DynamicTable, as read_material returns"
            )
        self.table, self.temperature, self.label = table, temperature, table.source
        kind = deformation or table.deformation
        if kind not in ("shear", "tension"):
            wanted = 'must be "shear" or "tension", as the data do not state it'
            raise InputError("deformation", kind, wanted, where=table.source)
        self.deformation: Literal["shear", "tension"] = kind
        names = ("storage_modulus", "loss_modulus") if isinstance(table, DynamicTable) else ("modulus",)
        if isinstance(table, RelaxationTable):
            # At time 0 the modulus of a dashpot is infinite.
            inside = table.time > 0.0
            self._at, values = table.time[inside], [table.modulus[inside]]
            sizes = values
        else:
            inside = table.angular_frequency > 0.0
            self._at = table.angular_frequency[inside]
            values = [table.storage_modulus[inside], table.loss_modulus[inside]]
            sizes = [np.hypot(*values)] * 2
        self._values = np.concatenate(values)
        self.scaled = noise is None or not noise.deviations
        if noise is None or self.scaled:
            deviations = [0.01 * size for size in sizes]
        else:
            deviations = []
            for name, value, size in zip(names, values, sizes, strict=True):
                found = noise.of(name, value, size)
                if found is None:
                    raise InputError(f"noise.{name}", wanted="must be given, as that of another quantity is")
                deviations.append(found)
        self._deviations = np.concatenate(deviations)
        self._names = names

    @property
    def size(self) -> int:
        """Number of measured values."""
        return self._values.size

    def _predicted(self, materials: MaterialColumns) -> Array:
        series = materials.at(self.temperature).modulus(self.deformation)
        if isinstance(self.table, RelaxationTable):
            return series.relaxation_modulus(self._at)
        found = series.complex_modulus(self._at)
        return np.hstack([found.real, found.imag])

    def residuals(self, materials: MaterialColumns, nuisances: Array) -> Array:
        """Residuals of the moduli; of the storage moduli, then of the loss moduli."""
        return (self._predicted(materials) - self._values) / self._deviations

    def curves(self, materials: MaterialColumns, nuisances: Array) -> list[Curve]:
        """Moduli over time or angular frequency."""
        x_name = "time" if isinstance(self.table, RelaxationTable) else "angular_frequency"
        fitted, n = self._predicted(materials)[0], self._at.size
        parts = (slice(k * n, (k + 1) * n) for k in range(len(self._names)))
        return [
            Curve(name, x_name, self._at, self._values[part], fitted[part],
                  None if self.scaled else self._deviations[part])
            for name, part in zip(self._names, parts, strict=True)
        ]  # fmt: skip

    def window(self) -> tuple[float, float]:
        """Lowest and highest angular frequency, or the reciprocals of the times [rad/s]."""
        ends = float(self._at.min()), float(self._at.max())
        return ends if isinstance(self.table, DynamicTable) else (1.0 / ends[1], 1.0 / ends[0])

    def effective_moduli(self) -> DynamicTable:
        """The moduli themselves; from a relaxation with delta = -(pi/2) dln G/dln t at omega = 1/t."""
        n = self._at.size
        if isinstance(self.table, DynamicTable):
            return DynamicTable(self._at, self._values[:n], self._values[n:], self.deformation, self.label)
        slope = np.gradient(np.log(self._values), np.log(self._at)) if n > 1 else np.zeros(n)
        phase = np.clip(-0.5 * math.pi * slope, 1e-3, 1.5)
        size = self._values[::-1]
        return DynamicTable(
            1.0 / self._at[::-1], size * np.cos(phase[::-1]), size * np.sin(phase[::-1]), self.deformation, self.label
        )

    def __repr__(self) -> str:
        return f"Moduli({type(self.table).__name__} of {self._at.size} in {self.deformation})"


def as_observations(data: object, place: int) -> Observations:
    """One set of data; a table of moduli becomes `Moduli`."""
    if isinstance(data, Observations):
        return data
    if isinstance(data, RelaxationTable | DynamicTable):
        return Moduli(data)
    raise InputTypeError("data", data, "must be Rebounds, a table of moduli, or another kind of data", index=(place,))
