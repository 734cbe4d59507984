"""Bands: values over an axis with the ends of their intervals, and the moduli that have them."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from restitution.material.columns import PronyColumns
from restitution.quantities import Quantity, dataset

if TYPE_CHECKING:
    import xarray

Array = NDArray[np.float64]

MODULUS_NAMES = ("storage_modulus", "loss_modulus", "absolute_modulus", "loss_tangent")
"""Functions of a complex modulus, as in `restitution.quantities.MODULI`."""

FAR = math.log(1e3)
"""Distance of a logarithm from the best value beyond which nothing is known."""

# A longer band overflows.
_LONGEST = 300.0


def modulus_functions(series: PronyColumns, angular_frequency: Array) -> Array:
    """Functions `MODULUS_NAMES` of n materials at angular frequencies [rad/s] of shape (m,), shape (n, 4, m)."""
    found = series.complex_modulus(angular_frequency)
    return np.stack([found.real, found.imag, np.abs(found), found.imag / found.real], axis=1)


def quantile(level: float, freedom: float = math.inf) -> float:
    """Half width of an interval over the standard error: Student's t, or the normal distribution."""
    from scipy.special import ndtri, stdtrit

    share = 0.5 + 0.5 * level
    return float(ndtri(share) if math.isinf(freedom) else stdtrit(freedom, share))


def limits(values: Array, errors: Array, width: float) -> tuple[Array, Array]:
    """Ends of bands of positive values whose logarithms have standard errors, `width` of these to both sides."""
    factor = np.exp(np.minimum(width * errors, _LONGEST))
    return values / factor, values * factor


def banded(
    axis: Quantity, x: Array, level: float, columns: Mapping[Quantity, tuple[Array, Array, Array]]
) -> xarray.Dataset:
    """Dataset of values and of the ends of their bands, `..._low` and `..._high`, over an axis."""
    found: dict[str, tuple[Any, Quantity]] = {axis.name: (x, axis)}
    for quantity, (values, *ends) in columns.items():
        found[quantity.name] = values, quantity
        for end, numbers in zip(("low", "high"), ends, strict=True):
            words = f"{quantity.words}, {end} end of the {100.0 * level:g} % band"
            found[f"{quantity.name}_{end}"] = numbers, quantity._replace(words=words)
    return dataset(axis.name, found, {"level": level})
