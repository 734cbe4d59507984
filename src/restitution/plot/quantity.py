"""Variables of a sweep in the units that suit their numbers."""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from numpy.typing import NDArray

from restitution.plot.labels import scaled_unit

if TYPE_CHECKING:
    import xarray as xr

Array = NDArray[np.float64]

RESTITUTION = "restitution_coefficient"
# Of values that span more than this the logarithm is shown; a restitution coefficient ends at 1 and stays.
_LOG_SPAN = 30.0


class Quantity(NamedTuple):
    """A variable in the unit that suits its numbers.

    Attributes
    ----------
    values : array
        Its values.
    label : str
        Words, symbol, unit.
    short : str
        Symbol, or words where it has none.
    unit : str
        The unit; empty for a plain number.
    logarithmic : bool
        Whether it is best shown by its logarithm.
    """

    values: Array
    label: str
    short: str
    unit: str
    logarithmic: bool

    def value_label(self, place: int) -> str:
        """Return one of its values in words, for a legend or a title."""
        if np.isnan(self.values[place]):
            # Axes have infinite values, as the bulk modulus of what is incompressible, and no others of this kind.
            return rf"{self.short} = $\infty$"
        number = f"{self.short} = {self.values[place]:.4g}"
        return f"{number} {self.unit}" if self.unit else number


def quantity(variable: xr.DataArray) -> Quantity:
    """Return a variable of a sweep's result in the unit that suits its numbers.

    Examples
    --------
    >>> import xarray as xr
    >>> radius = xr.DataArray([0.01, 0.02], attrs={"units": "m", "long_name": "radius", "symbol": "$R$"})
    >>> quantity(radius).label
    'radius $R$ [mm]'
    """
    values = np.asarray(variable.values, dtype=np.float64)
    values = np.where(np.isfinite(values), values, np.nan)
    given = variable.attrs.get("units", "")
    unit, factor = "", 1.0
    # A prefix before a unit with an exponent or of the temperature is not what people write.
    if given not in ("", "1") and "^" not in given and given not in ("K", "rad"):
        factor, unit = scaled_unit(values, "g" if given == "kg" else given)
        if given == "kg":
            factor, unit = scaled_unit(values * 1e3, "g")
            factor *= 1e3
            if unit in ("kg", "Mg", "Gg"):
                factor, unit = 1.0, "kg"
    elif given != "1":
        unit = given
    words = str(variable.attrs.get("long_name", variable.name))
    symbol = str(variable.attrs.get("symbol", ""))
    label = " ".join(part for part in (words, symbol, f"[{unit}]" if unit else "") if part)
    return Quantity(values * factor, label, symbol or words, unit, _is_logarithmic(variable, values))


def _is_logarithmic(variable: xr.DataArray, values: Array) -> bool:
    scale = variable.attrs.get("scale")
    if scale in ("linear", "logarithmic"):
        return scale == "logarithmic"
    finite = values[np.isfinite(values)]
    if variable.name == RESTITUTION or finite.size == 0 or finite.min() <= 0.0:
        return False
    return bool(finite.max() > _LOG_SPAN * finite.min())
