"""Impacts in place of many: nodes over the one number on which similar impacts depend."""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

# Nodes of a group: these, and so many for each factor of e; points of a polynomial.
_FEWEST, _DENSITY, _POINTS = 50, 200.0, 6


class ImpactColumns(NamedTuple):
    """Bodies with a power law a = c d^(p/2), shape (n,) each."""

    velocity: Array
    mass: Array
    external_force: Array
    temperature: Array | None
    coefficient: Array  # c


class ImpactNodes(NamedTuple):
    """Nodes, and the impacts that lie between them."""

    impacts: ImpactColumns
    size: int  # of the impacts that are interpolated
    groups: list[tuple[NDArray[np.intp], slice, Any]]  # places of impacts and of nodes, and the weights

    def interpolated(self, values: Array) -> Array:
        """Values at the impacts from those at the nodes, shapes (m, n_node) and (m, n)."""
        found = np.empty((values.shape[0], self.size))
        for places, nodes, weights in self.groups:
            found[:, places] = (weights @ values[:, nodes].T).T
        return found


def impact_nodes(impacts: ImpactColumns, exponent: float | None) -> ImpactNodes | None:
    """Nodes for impacts with the exponent p, or with another profile (None); None if there would be no fewer of them.

    With d = v u(t) the momentum balance of u has the single number c v^(p/2)/m where no constant force acts: such
    impacts at one temperature are one group. Under a force, or with another profile, impacts of equal bodies are. The
    outcomes e, T and F/(m v) are functions of the number, and local polynomials through the nodes give them to about
    1e-8, and to 1e-4 where the contact time rises steeply, at small e. Without groups, equal impacts are solved once.
    """
    free = (impacts.external_force == 0.0) & (exponent is not None)
    coefficient = np.nan_to_num(impacts.coefficient)
    number = coefficient * impacts.velocity ** (0.5 * (exponent or 0.0)) / impacts.mass
    heat = np.zeros(number.size) if impacts.temperature is None else impacts.temperature
    body = (np.where(free, 0.0, one) for one in (coefficient, impacts.mass, impacts.external_force))
    kinds, group = np.unique(np.stack([heat, *body], axis=1), axis=0, return_inverse=True)
    if len(kinds) * _FEWEST >= number.size:
        return _distinct(impacts)
    parts: list[ImpactColumns] = []
    groups: list[tuple[NDArray[np.intp], slice, Any]] = []
    at = 0
    for k in range(len(kinds)):
        places = np.flatnonzero(group == k)
        first, alone = places[0], free[places[0]]
        x = np.log(number[places] if alone else impacts.velocity[places])
        nodes, weights = _weights(x)
        given = np.exp(nodes)
        same = [np.full(nodes.size, column[first]) for column in (*impacts[:3], heat, impacts.coefficient)]
        velocity, mass, force, temperature, coefficient = same
        if alone:
            coefficient = given * mass / velocity ** (0.5 * (exponent or 0.0))
        else:
            velocity = given
        parts.append(ImpactColumns(velocity, mass, force, temperature, coefficient))
        groups.append((places, slice(at, at + nodes.size), weights))
        at += nodes.size
    if at >= number.size:
        return _distinct(impacts)
    whole = ImpactColumns(*(np.concatenate(one) for one in zip(*parts, strict=True)))
    return ImpactNodes(
        whole if impacts.temperature is not None else whole._replace(temperature=None), number.size, groups
    )


def _distinct(impacts: ImpactColumns) -> ImpactNodes | None:
    """Each impact once; None if no two are equal."""
    from scipy.sparse import csr_array

    size = impacts.velocity.size
    rows = np.stack([np.nan_to_num(one) for one in impacts if one is not None], axis=1)
    _, first, place = np.unique(rows, axis=0, return_index=True, return_inverse=True)
    if first.size == size:
        return None
    once = ImpactColumns(
        impacts.velocity[first], impacts.mass[first], impacts.external_force[first],
        None if impacts.temperature is None else impacts.temperature[first], impacts.coefficient[first],
    )  # fmt: skip
    weights = csr_array((np.ones(size), place.ravel(), np.arange(size + 1)), (size, first.size))
    return ImpactNodes(once, size, [(np.arange(size), slice(0, first.size), weights)])


def _weights(x: Array) -> tuple[Array, Any]:
    """Even nodes over the range of x, and the sparse weights of their values at each x, those of local polynomials."""
    from scipy.sparse import csr_array

    low, high = float(x.min()), float(x.max())
    if high - low < 1e-12:
        return np.array([low]), np.ones((x.size, 1))
    n = _FEWEST + math.ceil(_DENSITY * (high - low))
    place = (x - low) * ((n - 1) / (high - low))
    first = np.clip(np.floor(place).astype(np.intp) - _POINTS // 2 + 1, 0, n - _POINTS)
    at, k = (place - first)[:, None], np.arange(_POINTS)
    # Products of the distances to all other points of a polynomial.
    parts = [np.prod(np.delete(at - k, j, axis=1), axis=1) / np.prod(np.delete(j - k, j)) for j in k]
    columns = first[:, None] + k
    rows = np.arange(0, columns.size + 1, _POINTS)
    return np.linspace(low, high, n), csr_array((np.stack(parts, axis=1).ravel(), columns.ravel(), rows), (x.size, n))
