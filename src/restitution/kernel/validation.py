"""Checks of plain numbers, whose messages name the field, its value and the admissible range."""

from typing import Any

import numpy as np
from numpy.typing import NDArray

Numeric = float | NDArray[np.float64]


def _number(name: str, value: Any) -> NDArray[np.float64]:
    if isinstance(value, (bool, str, bytes)) or value is None:
        raise TypeError(f"{name} = {value!r}: must be a real number or an array of real numbers")
    try:
        array = np.array(value, dtype=np.float64)
    except (TypeError, ValueError, OverflowError):
        raise TypeError(f"{name} = {value!r}: must be a real number or an array of real numbers") from None
    return array


def _checked(
    name: str, array: NDArray[np.float64], good: NDArray[np.bool_], unit: str, wanted: str
) -> Numeric:
    if not np.all(good):
        where = np.argwhere(~np.atleast_1d(good))[0]
        bad = float(np.atleast_1d(array)[tuple(where)])
        place = f"[{', '.join(str(i) for i in where)}]" if array.ndim else ""
        raise ValueError(f"{name}{place} = {bad:g}{' ' + unit if unit else ''}: must be {wanted}")
    if array.ndim == 0:
        return float(array)
    array.setflags(write=False)
    return array


def finite(name: str, value: Any, unit: str = "") -> Numeric:
    """Return `value` as a float or array, refusing NaN and infinities."""
    array = _number(name, value)
    return _checked(name, array, np.isfinite(array), unit, "finite")


def positive(name: str, value: Any, unit: str = "") -> Numeric:
    """Return `value` as a float or array, refusing all that is not finite and above zero."""
    array = _number(name, value)
    return _checked(name, array, np.isfinite(array) & (array > 0), unit, "finite and > 0")


def nonnegative(name: str, value: Any, unit: str = "") -> Numeric:
    """Return `value` as a float or array, refusing all that is not finite and at least zero."""
    array = _number(name, value)
    return _checked(name, array, np.isfinite(array) & (array >= 0), unit, "finite and >= 0")


def within(name: str, value: Any, low: float, high: float, unit: str = "") -> Numeric:
    """Return `value` as a float or array, refusing all outside the closed interval [low, high]."""
    array = _number(name, value)
    suffix = f" {unit}" if unit else ""
    return _checked(name, array, (array >= low) & (array <= high), unit, f"in [{low:g}, {high:g}]{suffix}")
