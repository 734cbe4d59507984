"""Starts of a fit: materials whose complex modulus is near the effective moduli of the data."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from restitution.identification.descent import descend
from restitution.identification.observations import Observations
from restitution.identification.parameters import Parameters, penalties
from restitution.material.columns import MaterialColumns
from restitution.material.fit import DynamicTable

Array = NDArray[np.float64]

_STEP = 1e-4
# Descents to the effective moduli: largest change of a logarithm in a round, least gain, and rounds at most.
_FURTHEST, _ENOUGH, _ROUNDS = 2.0, 1e-2, 12
_N_STARTS = 9
# Starts lie within this factor above and below the effective modulus and time.
_SPREAD = 1.5 * math.log(10.0)
# Two starts differ if the logarithm of some parameter differs by more than this.
_APART = 0.5
# Starts of an unknown bulk modulus, over the effective modulus, and of an unknown Poisson ratio.
_BULKS = {"bulk_modulus": (0.3, 1.0, 10.0), "poisson_ratio": (0.2, 0.42, 0.49)}
# Error of the formulas for effective moduli: of the logarithm, and of the phase.
_MODULUS_ERROR, _PHASE_ERROR = 0.03, 0.1
# Largest instantaneous 2G/(3K) of half of the starts: a Poisson ratio of 0.3.
_PLAUSIBLE = 0.3
# The modulus [Pa] and the angular frequency [rad/s] of data without any.
_ARBITRARY, _ARBITRARY_FREQUENCY = 1e6, 1e3


def effective_tables(data: Sequence[Observations], space: Parameters) -> list[DynamicTable]:
    """Effective moduli of the data; of an arbitrary size if the data contain none."""
    found = [table for one in data for table in one.moduli_by_temperature()]
    if not found:
        known = [float(np.nanmax(value)) for name, value in space.fixed.items()
                 if "modul" in name and name != "bulk_modulus" and np.any(np.isfinite(value))]  # fmt: skip
        size = 4.0 * known[0] if known else _ARBITRARY
        found = [table for one in data if (table := one.assumed_moduli(size)) is not None]
    one = np.ones(1)
    return found or [DynamicTable(_ARBITRARY_FREQUENCY * one, _ARBITRARY * one, 0.1 * _ARBITRARY * one)]


def starts(
    space: Parameters, tables: Sequence[DynamicTable], columns: Callable[[Array], MaterialColumns],
    centre: Array, low: Array, high: Array,
) -> Array:  # fmt: skip
    """Coordinates of distinct starts, shape (s, n_unknown).

    The complex modulus of the model is fitted to the effective moduli from these points. An unknown bulk modulus is
    held at three values: these moduli hardly depend on it.
    """
    n = len(space.free)
    points = scattered(space, centre, _N_STARTS)
    held = -1
    for k, one in enumerate(space.free):
        if one.name in _BULKS:
            values = np.array(_BULKS[one.name])
            if one.name == "bulk_modulus":
                values = values * float(np.hypot(tables[0].storage_modulus, tables[0].loss_modulus)[0])
            if one.name in (*space.start, *space.prior):
                values[0] = one.outward(centre[k])
            held, points[:, k] = k, one.inward(values)[np.arange(_N_STARTS) % values.size]
    points = np.clip(points, low + 1e-6, high - 1e-6)

    def residuals(at: Array, places: NDArray[np.intp]) -> Array:
        coordinates, parts = at.reshape(-1, at.shape[2]), list[Array]()
        materials = columns(coordinates)
        for table in tables:
            kind: Any = table.deformation
            own = materials if space.shift is None else materials.at(table.temperature)
            series = own.reduced if kind is None else own.modulus(kind)
            model: Any = series.complex_modulus(table.angular_frequency)
            ratio: Any = np.log(model / (table.storage_modulus + 1j * table.loss_modulus))
            phase = np.arctan2(table.loss_modulus, table.storage_modulus)
            parts += [ratio.real / _MODULUS_ERROR, ratio.imag / (_PHASE_ERROR * phase + 1e-3)]
        # The other half may have a negative instantaneous Poisson ratio.
        plausible = np.repeat(places % 2 == 0, at.shape[1])
        excess = np.log(np.maximum(instantaneous_ratio(materials) / _PLAUSIBLE, 1.0)) * plausible / _MODULUS_ERROR
        parts += [excess[:, None], penalties(space, coordinates[:, :n])]
        return np.hstack(parts).reshape(*at.shape[:2], -1)

    steps = np.where((np.arange(centre.size) < n) & (np.arange(centre.size) != held), _STEP, 0.0)
    low, high = np.broadcast_to(low, points.shape), np.broadcast_to(high, points.shape)
    with np.errstate(all="ignore"):
        found = descend(residuals, points, low, high, steps, np.full(centre.size, _FURTHEST), _ENOUGH, _ROUNDS)
    points, costs = found.points, found.costs
    chosen: list[int] = []
    for k in np.argsort(costs, kind="stable"):
        if math.isfinite(costs[k]) and all(np.abs(points[k] - points[other]).max() > _APART for other in chosen):
            chosen.append(int(k))
    return points[chosen] if chosen else centre[None]


def scattered(space: Parameters, centre: Array, n_points: int) -> Array:
    """Points around a centre, within 1.5 decades of each parameter without a start of its own."""
    n = len(space.free)
    wide = [1.0 if one.kind == "logit" else _SPREAD for one in space.free]
    spread = [0.0 if one.name in space.start else size for one, size in zip(space.free, wide, strict=True)]
    points = np.tile(centre, (n_points, 1))
    points[:, :n] += (2.0 * lattice(n_points, n) - 1.0) * spread
    return points


def instantaneous_ratio(materials: MaterialColumns) -> Array:
    """Ratio 2G/(3K) of the instantaneous moduli, shape (n,); above 1 the instantaneous Poisson ratio is negative."""
    shear, bulk = (one.equilibria + one.moduli.sum(axis=1) for one in (materials.shear, materials.bulk))
    with np.errstate(divide="ignore"):  # a material with a Poisson ratio of -1 has no bulk modulus
        return 2.0 * shear / (3.0 * bulk)


def lattice(n_points: int, n: int) -> Array:
    """Points of an additive lattice, which fill the unit cube evenly, shape (n_points, n)."""
    return np.mod(0.5 + np.outer(np.arange(n_points), _lattice_root(n) ** -np.arange(1.0, n + 1.0)), 1.0)


def _lattice_root(n: int) -> float:
    """Positive root of x^(n + 1) = x + 1."""
    x = 1.5
    for _ in range(40):
        x = (1.0 + x) ** (1.0 / (n + 1.0))
    return x
