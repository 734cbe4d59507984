"""Relaxation beyond the times of the data: what it may be, if the loss goes on as at their ends."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from restitution.checks import Array
from restitution.material.prony import PronySeries
from restitution.material.viscoelastic import Material

# Shear modulus [Pa] of a glass: hardly any polymer is stiffer, so that its spectrum ends there.
_GLASS = 1.5e9
# Terms per decade. The loss modulus of a constant spectrum ripples by a thousandth then.
_DENSITY = 2
# Share of the modulus of the longest times that stays, as that of a solid does not fall to zero.
_LEFT = 0.01


class Beyond(NamedTuple):
    """Decades of time beyond the data that contacts reach, at their short and at their long end."""

    shorter: int
    longer: int


def continued(material: Material, beyond: Beyond, growth: float | None, *, stiffening: float = math.inf) -> Material:
    """Return a material whose relaxation goes on beyond the window of its data; it has no window.

    The spectrum at the ends of the data is H = (2/pi) R''(1/tau), its first approximation by the loss modulus (Ferry,
    *Viscoelastic Properties of Polymers*, 3rd ed. (1980), ch. 4). Terms of this strength take the place of those
    outside of the window. H grows with this power of the distance in time from the data, 1 at most, as the loss
    modulus of no Prony series changes faster than the frequency or its reciprocal. By default the power is that of
    the last decade of the data. The shear modulus grows by no more than the factor `stiffening`, and no further than
    that of a glass.
    """
    assert material.window is not None
    low, high = map(float, material.window)
    faster = _faster(material.shear, low, beyond.shorter, growth)
    present = float(material.shear.instantaneous_modulus)
    room = min(_GLASS, stiffening * present) - present
    count = int(np.searchsorted(np.cumsum(faster), room))

    def change(part: PronySeries) -> PronySeries:
        if part.is_elastic:
            return part
        return _slower(_quickened(part, low, beyond.shorter, count, growth), high, beyond.longer, growth)

    bulk = change(material.bulk) if isinstance(material.bulk, PronySeries) else material.bulk
    return replace(material, shear=change(material.shear), bulk=bulk, window=None)


def _power(series: PronySeries, omega: float, inward: float) -> float:
    """Return the power with which the loss modulus grows out of the data, from the decade inside of their end."""
    ratio = float(series.loss_modulus(omega)) / max(float(series.loss_modulus(omega * inward)), 1e-300)
    return min(max(math.log10(max(ratio, 1e-300)), -1.0), 1.0)


def _faster(series: PronySeries, low: float, decades: int, growth: float | None) -> Array:
    """Return the moduli of terms before the data, the slowest first."""
    steps = (np.arange(_DENSITY * decades) + 0.5) / _DENSITY
    power = _power(series, 1.0 / low, 0.1) if growth is None else growth
    height = 2.0 / math.pi * float(series.loss_modulus(1.0 / low))
    return height * math.log(10.0) / _DENSITY * 10.0 ** (power * steps)


def _quickened(series: PronySeries, low: float, decades: int, count: int, growth: float | None) -> PronySeries:
    if not decades or not count:
        return series
    moduli = _faster(series, low, decades, growth)[:count]
    times = low * 10.0 ** (-(np.arange(count) + 0.5) / _DENSITY)
    kept = series.relaxation_times >= low
    branches = np.append(series.branch_moduli[kept], moduli)
    return PronySeries(
        series.equilibrium_modulus, branches, np.append(series.relaxation_times[kept], times),
        parallel_viscosity=series.parallel_viscosity,
    )  # fmt: skip


def _slower(series: PronySeries, high: float, decades: int, growth: float | None) -> PronySeries:
    if not decades:
        return series
    steps = (np.arange(_DENSITY * decades) + 0.5) / _DENSITY
    power = _power(series, 1.0 / high, 10.0) if growth is None else growth
    height = 2.0 / math.pi * float(series.loss_modulus(1.0 / high))
    moduli = height * math.log(10.0) / _DENSITY * 10.0 ** (power * steps)
    kept = series.relaxation_times <= high
    rest = float(series.equilibrium_modulus) + float(series.branch_moduli[~kept].sum())
    count = int(np.searchsorted(np.cumsum(moduli), (1.0 - _LEFT) * rest))
    times = high * 10.0 ** steps[:count]
    return PronySeries(
        rest - float(moduli[:count].sum()), np.append(series.branch_moduli[kept], moduli[:count]),
        np.append(series.relaxation_times[kept], times), parallel_viscosity=series.parallel_viscosity,
    )  # fmt: skip
