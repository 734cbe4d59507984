"""Axis labels: words, symbol and unit, the unit with the prefix that suits the numbers."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

_PREFIXES = {-18: "a", -15: "f", -12: "p", -9: "n", -6: "µ", -3: "m", 0: "", 3: "k", 6: "M", 9: "G", 12: "T"}

SYMBOLS = {
    "time": r"$t$",
    "indentation_depth": r"$d$",
    "indentation_velocity": r"$v$",
    "force": r"$F$",
    "contact_radius": r"$a$",
    "restitution_coefficient": r"$e$",
}

P1 = r"$\nu$"
LOG_P2 = r"$\log_{10}\,p_2,\quad p_2 = G_\infty\,/\,G_1$"
P3 = r"$p_3 = \eta\,\left[v_0 R\,/\,(m^2 G_\infty^3)\right]^{1/5}$"
LOG_P3 = r"$\log_{10}\,p_3,\quad p_3 = \eta\,[v_0 R\,/\,(m^2 G_\infty^3)]^{1/5}$"
RESTITUTION = r"restitution coefficient $e$"


class ScaledUnit(NamedTuple):
    """A unit with its prefix, and the factor that takes SI values to it."""

    factor: float
    unit: str


def scaled_unit(values: Any, unit: str) -> ScaledUnit:
    """Return the prefixed unit in which the largest of `values` lies in [1, 1000).

    Parameters
    ----------
    values : array-like
        Values in SI; those that are not finite are left out.
    unit : str
        The unit without prefix, e.g. `N`; empty for plain numbers, which get no prefix.

    Returns
    -------
    ScaledUnit
        `values * factor` are in `unit`.

    Examples
    --------
    >>> scaled_unit([0.0, -0.0032], "m")
    ScaledUnit(factor=1000.0, unit='mm')
    >>> scaled_unit(2.5e4, "N").unit
    'kN'
    """
    if not unit:
        return ScaledUnit(1.0, "-")
    array = np.abs(np.asarray(values, dtype=np.float64))
    array = array[np.isfinite(array)]
    largest = float(array.max()) if array.size else 0.0
    # The tiny addend keeps 0.999999999999 of a unit, a rounded one, out of the next smaller unit.
    power = 3 * int(np.floor((np.log10(largest) + 1e-9) / 3)) if largest > 0 else 0
    power = min(max(power, min(_PREFIXES)), max(_PREFIXES))
    return ScaledUnit(10.0**-power, _PREFIXES[power] + unit)


def quantity_label(name: str, unit: str) -> str:
    """Return the label of an axis: the quantity's words, its symbol and its unit.

    Examples
    --------
    >>> quantity_label("contact_radius", "mm")
    'contact radius $a$ [mm]'
    """
    words = name.replace("_", " ")
    symbol = SYMBOLS.get(name)
    return f"{words} {symbol} [{unit}]" if symbol else f"{words} [{unit}]"
