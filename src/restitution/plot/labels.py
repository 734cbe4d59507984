"""Words, symbols and prefixed units on the axes of pictures, from the registry of quantities."""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from numpy.typing import NDArray

from restitution.display import ScaledUnit, scaled_unit
from restitution.quantities import HISTORY, INPUTS, MODULI, OUTPUTS

if TYPE_CHECKING:
    import xarray as xr

Array = NDArray[np.float64]

RESTITUTION = "restitution_coefficient"

# Values that span more than this have a logarithmic axis, except the restitution coefficient, which ends at 1.
_LOG_SPAN = 30.0

# An axis that spans more than this has no prefix: "1e-6 to 1 MPa s" would be hard to read.
_PREFIX_SPAN = 2000.0


def quantity_label(name: str, unit: str) -> str:
    """Return the label of an axis: words and symbol of the registry, and a unit.

    Examples
    --------
    >>> quantity_label("contact_radius", "mm")
    'contact radius $a$ [mm]'
    """
    known = {**INPUTS, **OUTPUTS, **HISTORY, **MODULI}[name]
    return _label(known.words, known.symbol, unit)


def _label(words: str, symbol: str, unit: str) -> str:
    return " ".join(filter(None, (words, symbol, f"[{unit}]" if unit else "")))


class Values(NamedTuple):
    """A variable in a suitable unit, NaN where it is not finite.

    The label has words, symbol and unit; the short label is the symbol, or the words if there is none.
    """

    values: Array
    label: str
    short: str
    unit: str
    logarithmic: bool

    @property
    def scale(self) -> str:
        """Matplotlib's name of the scale of its axis."""
        return "log" if self.logarithmic else "linear"

    def value_label(self, place: int) -> str:
        """Return one of its values with symbol and unit, for a legend or a title."""
        if np.isnan(self.values[place]):
            # The only value of an axis that is not finite is the bulk modulus of an incompressible material.
            return rf"{self.short} = $\infty$"
        number = f"{self.short} = {self.values[place]:.4g}"
        return f"{number} {self.unit}" if self.unit else number


def scaled(variable: xr.DataArray) -> Values:
    """Return a variable of a Dataset in a suitable unit, with the words and the symbol of its attributes.

    Examples
    --------
    >>> import xarray as xr
    >>> from restitution.quantities import INPUTS
    >>> scaled(xr.DataArray([0.01, 0.02], attrs=INPUTS["radius"].attributes)).label
    'radius $R$ [mm]'
    """
    values = np.asarray(variable.values, dtype=np.float64)
    values = np.where(np.isfinite(values), values, np.nan)
    given = variable.attrs.get("units", "1")
    given = "" if given == "1" else given
    logarithmic = _is_logarithmic(variable, values)
    positive = np.abs(values[np.isfinite(values) & (values != 0.0)])
    wide = logarithmic and positive.size > 0 and positive.max() > _PREFIX_SPAN * positive.min()
    factor, unit = ScaledUnit(1.0, given) if wide else scaled_unit(values, given)
    words = str(variable.attrs.get("long_name", variable.name))
    symbol = str(variable.attrs.get("symbol", ""))
    return Values(values * factor, _label(words, symbol, unit), symbol or words, unit, logarithmic)


def _is_logarithmic(variable: xr.DataArray, values: Array) -> bool:
    scale = variable.attrs.get("scale")
    if scale in ("linear", "logarithmic"):
        return scale == "logarithmic"
    finite = values[np.isfinite(values)]
    if variable.name == RESTITUTION or finite.size == 0 or finite.min() <= 0.0:
        return False
    return bool(finite.max() > _LOG_SPAN * finite.min())
