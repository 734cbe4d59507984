"""Checks of numbers: an invalid one raises an `InputError` with the field, its value and the admissible range."""

from __future__ import annotations

import inspect
import math
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from restitution.errors import InputError, InputTypeError
from restitution.units import has_unit, without_unit

Array = NDArray[np.float64]
Places = NDArray[np.intp]
Numeric = float | Array

_NUMBER = "must be a real number or an array of real numbers"


def number(name: str, value: Any, unit: str = "") -> Array:
    """Return `value` as an array of floats in the SI unit of the field, refusing everything but real numbers."""
    # Most values: numbers of the package, which need no search for units, masks and booleans.
    if type(value) is np.ndarray and value.dtype == np.float64:
        return value.copy()
    if type(value) is float:
        return np.array(value)
    if isinstance(value, str):
        raise InputTypeError(name, value, f"{_NUMBER}{f' in {unit}' * bool(unit)}; text with a unit is for case files")
    if isinstance(value, (bool, bytes)) or value is None:
        raise InputTypeError(name, value, _NUMBER)
    value = without_unit(name, value, unit)
    if isinstance(value, Sequence):
        # NumPy takes a boolean among numbers for one of them.
        for place, item in enumerate(value):
            if isinstance(item, bool):
                raise InputTypeError(name, item, _NUMBER, index=(place,))
    if isinstance(value, Sequence) and any(map(has_unit, value)):
        value = [without_unit(name, item, unit) for item in value]
    if isinstance(value, np.ma.MaskedArray):
        mask = np.ma.getmaskarray(value)
        if mask.any():
            index = tuple(int(i) for i in np.argwhere(np.atleast_1d(mask))[0]) if value.ndim else ()
            raise InputTypeError(name, "masked", _NUMBER, index=index)
        value = value.data
    try:
        plain = np.asarray(value)
        mixed = plain.dtype.kind == "O" and any(isinstance(item, (str, bytes, bool)) for item in plain.flat)
        if mixed or plain.dtype.kind not in "iufO":
            raise InputTypeError(name, value, _NUMBER)
        return np.array(plain, dtype=np.float64)
    except OverflowError:
        raise InputError(name, value, "must be a number that a double can hold") from None
    except InputTypeError:
        raise
    # The conversion of a foreign object may raise anything.
    except Exception:
        raise InputTypeError(name, value, _NUMBER) from None


def plain(value: Any) -> Numeric:
    """Return a 0-d value as a float, an array as it is."""
    return float(value) if np.ndim(value) == 0 else value


def in_range(
    name: str, value: Any, unit: str = "", low: float = -math.inf, high: float = math.inf, *,
    is_open: bool = False, infinite: bool = False,
) -> Numeric:  # fmt: skip
    """Return `value` as a float or a read-only array, refusing numbers outside a range.

    The ends belong to the range unless it `is_open`. Infinite numbers do not, unless `infinite`.
    """
    array = number(name, value, unit)
    good = (array > low if is_open else array >= low) & (array < high if is_open and not infinite else array <= high)
    if not infinite:
        good = good & np.isfinite(array)
    if not good.all():
        refuse(name, array, ~good, _rule(low, high, unit, is_open, infinite), unit)
    if array.ndim == 0:
        return float(array)
    array.setflags(write=False)
    return array


def _rule(low: float, high: float, unit: str, is_open: bool, infinite: bool) -> str:
    """Return the words for a range."""
    if low == -math.inf and high == math.inf:
        return "must be finite"
    if low == 0.0 and high == math.inf and (is_open or not infinite):
        return f"must be {'' if infinite else 'finite and '}{'>' if is_open else '>='} 0"
    ends = f"> {low:g} and < {high:g}" if is_open else f"in [{low:g}, {high:g}]"
    return f"must be {ends} {unit}".rstrip()


def refuse(name: str, values: Array, bad: NDArray[np.bool_], rule: str, unit: str = "") -> None:
    """Refuse bad values; the error has the first of them and its index."""
    if bad.any():
        index = tuple(int(i) for i in np.argwhere(bad)[0])
        raise InputError(name, float(values[index]), rule, unit, index=index)


def finite(name: str, value: Any, unit: str = "") -> Numeric:
    """Return `value` as a float or array, refusing NaN and infinities."""
    return in_range(name, value, unit)


def positive(name: str, value: Any, unit: str = "") -> Numeric:
    """Return `value` as a float or array, refusing numbers that are not finite and above zero."""
    return in_range(name, value, unit, 0.0, is_open=True)


def positive_or_infinite(name: str, value: Any, unit: str = "") -> Numeric:
    """Return `value` as a float or array, refusing numbers that are not above zero."""
    return in_range(name, value, unit, 0.0, is_open=True, infinite=True)


def nonnegative(name: str, value: Any, unit: str = "") -> Numeric:
    """Return `value` as a float or array, refusing numbers that are not finite and at least zero."""
    return in_range(name, value, unit, 0.0)


def single(name: str, value: Numeric, unit: str = "") -> float:
    """Return a checked value as a float, refusing an array."""
    if isinstance(value, np.ndarray):
        raise InputTypeError(name, value, "must be a single number", unit)
    return value


def single_positive(name: str, value: Any, unit: str = "") -> float:
    """Return `value` as a float, refusing arrays and numbers that are not finite and above zero."""
    return single(name, positive(name, value, unit), unit)


def single_nonnegative(name: str, value: Any, unit: str = "") -> float:
    """Return `value` as a float, refusing arrays and numbers that are not finite and at least zero."""
    return single(name, nonnegative(name, value, unit), unit)


def within(name: str, value: Any, low: float, high: float, unit: str = "") -> Numeric:
    """Return `value` as a float or array, refusing numbers outside the closed interval [low, high]."""
    return in_range(name, value, unit, low, high, infinite=True)


def between(name: str, value: Any, low: float, high: float, unit: str = "") -> Numeric:
    """Return `value` as a float or array, refusing numbers outside the open interval (low, high)."""
    return in_range(name, value, unit, low, high, is_open=True)


def whole(name: str, value: Any, low: int = 1, high: int | None = None) -> int:
    """Return `value` as an int, refusing everything but whole numbers in [low, high]."""
    rule = f"must be a whole number >= {low}" if high is None else f"must be a whole number in [{low}, {high}]"
    # NumPy counts spans of time among its integers.
    if isinstance(value, (bool, np.timedelta64)) or not isinstance(value, (int, np.integer)):
        raise InputTypeError(name, value, rule)
    if value < low or (high is not None and value > high):
        raise InputError(name, int(value), rule)
    return int(value)


def one_of(name: str, value: Any, choices: Sequence[str], reason: str = "") -> str:
    """Return `value` if it is one of the choices; a reason stands behind them in the error."""
    # The comparison of another object, such as an array, need not be true or false.
    if isinstance(value, str) and value in choices:
        return str(value)
    *most, last = (f"'{choice}'" for choice in choices)
    rule = f"must be {', '.join(most)} or {last}" if most else f"must be {last}"
    raise (InputError if isinstance(value, str) else InputTypeError)(name, value, rule + reason)


def items(name: str, value: Any, rule: str) -> list[Any]:
    """Return the items of a sequence, refusing everything that is none, such as a number."""
    if isinstance(value, (str, bytes, bytearray)):
        raise InputTypeError(name, value, rule)
    try:
        return list(value)
    # The iteration of a foreign object may raise anything.
    except Exception:
        raise InputTypeError(name, value, rule) from None


def is_iterable(value: Any) -> bool:
    """Return whether a value has items, or an iteration that fails."""
    try:
        iter(value)
    except TypeError:  # also that of an array without a dimension
        return False
    # The iteration of a foreign object may raise anything.
    except Exception:
        return True
    return True


def pair(name: str, value: Any, rule: str) -> tuple[Any, Any]:
    """Return the two items of a pair."""
    both = items(name, value, rule)
    if len(both) != 2:
        raise InputError(name, value, rule)
    return both[0], both[1]


def instance(name: str, value: Any, kind: type[Any] | tuple[type[Any], ...], rule: str) -> Any:
    """Return `value` if it is of the type, or one of the types."""
    if not isinstance(value, kind):
        raise InputTypeError(name, value, rule)
    return value


def truth(name: str, value: Any) -> bool:
    """Return `value` as True or False, refusing everything else."""
    return bool(instance(name, value, (bool, np.bool_), "must be True or False"))


def function(name: str, value: Any, rule: str, n: int) -> Any:
    """Return `value` if it can be called with `n` arguments."""
    if not callable(value) or isinstance(value, type):
        raise InputTypeError(name, value, rule)
    try:
        inspect.signature(value).bind(*range(n))
    except ValueError:  # some functions in C have no signature
        pass
    except TypeError:
        raise InputTypeError(name, value, rule) from None
    return value


def mapping(name: str, value: Any, rule: str = "must be a mapping of names to values") -> dict[str, Any]:
    """Return a mapping whose keys are names, empty for None."""
    names = dict(instance(name, {} if value is None else value, Mapping, rule))
    for key in names:
        instance(name, key, str, "must have names as keys")
    return names


def common_shape(shapes: Mapping[str, tuple[int, ...]]) -> tuple[int, ...]:
    """Return the shape to which arrays of these names broadcast."""
    try:
        return np.broadcast_shapes(*shapes.values())
    except ValueError:
        listed = ", ".join(f"{name} {shape}" for name, shape in shapes.items())
        rule = f"have shapes that do not broadcast against each other: {listed}"
        raise InputError(", ".join(shapes), rule=rule) from None
