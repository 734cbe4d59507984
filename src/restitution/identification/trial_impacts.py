"""Impacts of trial materials: rows of one batch, and nodes between which many similar impacts are interpolated."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from restitution.checks import Array
from restitution.contact.geometry import Geometry
from restitution.impact.batch import Batch, flat
from restitution.impact.problem import Impact
from restitution.material.prony import PronySeries
from restitution.material.viscoelastic import Material
from restitution.variation import varied

# Columns of a batch that a trial replaces.
_SERIES = "equilibria", "viscosities", "moduli", "times"
_BODY = "masses", "velocities", "forces", "coefficients", "ratios", "depth_units", "radius_units"
# Impedance of targets that do not move.
_STILL = np.array([math.inf])
# Nodes of a group: these, and so many for each factor of e; points of a polynomial.
_FEWEST, _DENSITY, _POINTS = 50, 200.0, 6


class ImpactNodes(NamedTuple):
    """Nodes, and the impacts that lie between them."""

    impact: Impact  # the nodes, shape (n_node,)
    temperature: Array | None
    size: int  # of the impacts that are interpolated
    groups: list[tuple[NDArray[np.intp], slice, Any]]  # places of impacts and of nodes, and the weights

    def interpolated(self, values: Array) -> Array:
        """Return values at the impacts from those at the nodes, shapes (m, n_node) and (m, n)."""
        result = np.empty((values.shape[0], self.size))
        for places, nodes, weights in self.groups:
            result[:, places] = (weights @ values[:, nodes].T).T
        return result


def impact_nodes(impact: Impact, temperature: Array | None = None) -> ImpactNodes | None:
    """Return nodes for impacts of shape (n,); None if there are no fewer of them.

    With d = v u(t) the momentum balance of u has the single number c v^(p/2)/m for a = c d^(p/2) where no constant
    force acts: such impacts at one temperature are one group. Under a force, or with another profile, impacts of equal
    bodies are. The outcomes e, T and F/(m v) are functions of the number, and local polynomials through the nodes give
    them to about 1e-8, and to 1e-4 where the contact time rises steeply, at small e. Without groups, equal impacts are
    solved once.
    """
    exponent = impact.profile.path_exponent
    half = 0.0 if exponent is None else 0.5 * float(np.asarray(exponent))
    coefficients: Any = 0.0 if exponent is None else impact.profile.path_coefficient
    columns = np.broadcast_arrays(0.0 if temperature is None else temperature, coefficients, *_body(impact))
    heat, coefficient, mass, velocity, force = columns
    free = (force == 0.0) & (exponent is not None)
    number = coefficient * velocity**half / mass
    body = (np.where(free, 0.0, values) for values in (coefficient, mass, force))
    kinds, group = np.unique(np.stack([heat, *body], axis=1), axis=0, return_inverse=True)
    if len(kinds) * _FEWEST >= number.size:
        return _distinct(impact, temperature, np.stack(columns, axis=1))
    rows, masses, velocities = list[NDArray[np.intp]](), list[Array](), list[Array]()
    groups: list[tuple[NDArray[np.intp], slice, Any]] = []
    at = 0
    for k in range(len(kinds)):
        places = np.flatnonzero(group == k)
        first = places[0]
        nodes, weights = _weights(np.log((number if free[first] else velocity)[places]))
        # A mass or a velocity gives the first impact of the group the number of each node.
        by_mass = coefficient[first] * velocity[first] ** half / np.exp(nodes)
        masses.append(by_mass if free[first] else np.full(nodes.size, mass[first]))
        velocities.append(np.full(nodes.size, velocity[first]) if free[first] else np.exp(nodes))
        rows.append(np.full(nodes.size, first))
        groups.append((places, slice(at, at + nodes.size), weights))
        at += nodes.size
    if at >= number.size:
        return _distinct(impact, temperature, np.stack(columns, axis=1))
    chosen = np.concatenate(rows)
    numbers = {"mass": np.concatenate(masses), "velocity": np.concatenate(velocities)}
    levels = None if temperature is None else temperature[chosen]
    return ImpactNodes(varied(impact.take(chosen), numbers), levels, number.size, groups)


def _distinct(impact: Impact, temperature: Array | None, rows: Array) -> ImpactNodes | None:
    """Return each impact once; None if no two are equal."""
    from scipy.sparse import csr_array

    _, first, place = np.unique(rows, axis=0, return_index=True, return_inverse=True)
    size = len(rows)
    if first.size == size:
        return None
    weights = csr_array((np.ones(size), place.ravel(), np.arange(size + 1)), (size, first.size))
    levels = None if temperature is None else temperature[first]
    return ImpactNodes(impact.take(first), levels, size, [(np.arange(size), slice(0, first.size), weights)])


def _body(impact: Impact) -> tuple[Any, Any, Any]:
    return impact.mass, impact.velocity, impact.external_force


def impacts_of(profile: Geometry, mass: Any, velocity: Any, external_force: Any) -> Impact:
    """Return impacts of bodies on a material that trials replace."""
    return Impact(Material(1.0, math.inf), profile, mass, velocity, external_force=external_force)


def bodies_of(impact: Impact) -> Batch:
    """Return impacts as rows for `trials`, checked and translated once: a fit makes thousands of trials."""
    return replace(Batch.from_impact(impact), impedances=_STILL)


def trials(bodies: Batch, reduced: PronySeries, **numbers: Any) -> Batch:
    """Return impacts of bodies on m materials, of reduced moduli of shape (m, 1) or (m, n), as rows.

    Further numbers are columns of a batch that broadcast to the shape (m, n).
    """
    shape = np.broadcast_shapes(reduced.shape, (bodies.size,), *map(np.shape, numbers.values()))
    columns: dict[str, Any] = dict(zip(_SERIES, reduced.broadcast_to(shape).columns, strict=True))
    for name in _BODY:
        values = numbers.get(name, getattr(bodies, name))
        # Numbers without a unit and coefficients of no power law are single numbers, or None.
        columns[name] = flat(values, shape) if np.ndim(values) or name in numbers else values
    return replace(bodies, **columns)


def _weights(x: Array) -> tuple[Array, Any]:
    """Return even nodes over the range of x, and the weights of local polynomials through them at each x."""
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
