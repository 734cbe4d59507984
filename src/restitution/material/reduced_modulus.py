"""Reduced relaxation modulus E*(t): all that a contact sees of a material or of a pair."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from restitution.material.prony import PronySeries
from restitution.material.secular import secular_roots
from restitution.material.viscoelastic import Material

Array = NDArray[np.float64]

_EPS = float(np.finfo(np.float64).eps)


def reduced_modulus(material: Material, counter_material: Material | None = None) -> PronySeries:
    """Reduced relaxation modulus E*(t) [Pa] of a material, or of two bodies in contact.

    By the correspondence principle the Carson transforms obey

        E* = 4G(3K + G)/(3K + 4G),    1/E* = 1/E1* + 1/E2* for two bodies.

    Each is a series connection (of 4G and 4K + 4G/3, or of the two bodies) and so again a Prony series.

    Parameters
    ----------
    material
        Material of the half-space.
    counter_material
        Material of the other body; None if that one is rigid.

    Returns
    -------
    PronySeries
        Simplified: no zero branches, times ascending.

    Notes
    -----
    Lee and Radok, J. Appl. Mech. 27 (1960) 438. Valid for small strains, frictionless contact, half-spaces.

    Examples
    --------
    A standard solid with a constant bulk modulus has two branches in E*, the first one that of G:

    >>> material = Material(PronySeries(1.0, [4.0], [1.0]), bulk=4.0)
    >>> series = reduced_modulus(material)
    >>> print(series.relaxation_times, series.branch_moduli)
    [1. 2.] [4.    3.375]
    """
    own = _single(material)
    if counter_material is None:
        return own
    return series_connection(own, _single(counter_material))


def _single(material: Material) -> PronySeries:
    shear = material.shear.simplified()
    if not isinstance(material.bulk, PronySeries):
        return shear.scaled(4.0)
    times, g, k = _common(shear, material.bulk.simplified())
    first = _NOTHING.plus(g, 4.0)
    second = _NOTHING.plus(g, 4.0 / 3.0).plus(k, 4.0)
    # Where 4G + 4K + 4G/3 = 0, 4G equals -3K too, which is exact where G itself cancels.
    third = _NOTHING.plus(k, 3.0)
    return _connect(times, first, second, third)


def series_connection(first: PronySeries, second: PronySeries) -> PronySeries:
    """Series connection C of two Prony series, 1/C = 1/A + 1/B in Carson transforms: their compliances add.

    Parameters
    ----------
    first, second
        A and B [Pa].

    Returns
    -------
    PronySeries
        Simplified. Its rates are those shared by A and B and the roots lambda of A + B = 0 at s = -lambda.

    Notes
    -----
    At a rate shared by both, the branch modulus is that of two springs in series; at a root lambda it is
    A(-lambda)^2/(lambda (A + B)'(-lambda)). Both are positive by construction.

    Examples
    --------
    A spring and a dashpot in series are a Maxwell body:

    >>> series_connection(PronySeries(2.0), PronySeries(0.0, viscosity=6.0))
    PronySeries(0.0, [2.0], [3.0])
    """
    return _connect(*_common(first.simplified(), second.simplified()))


class _Part(NamedTuple):
    constant: float
    viscosity: float
    weights: Array

    def plus(self, other: _Part, factor: float) -> _Part:
        """Parallel connection with the other part, the latter times a factor."""
        return _Part(
            self.constant + factor * other.constant,
            self.viscosity + factor * other.viscosity,
            self.weights + factor * other.weights,
        )

    def at(self, times: Array, terms: Array, sizes: Array) -> tuple[Array, Array]:
        """Value at s = -1/times and the size of what is summed."""
        steady, flowing = self.constant, self.viscosity / times
        return steady - flowing + terms @ self.weights, steady + flowing + sizes @ self.weights


_NOTHING = _Part(0.0, 0.0, np.zeros(1))


def _common(first: PronySeries, second: PronySeries) -> tuple[Array, _Part, _Part]:
    """Descending times of two simplified series, and each series on them."""
    n_first = first.n_branches
    times, where = np.unique(
        np.concatenate((first.relaxation_times, second.relaxation_times)), return_inverse=True
    )
    where = times.size - 1 - where
    weights = np.zeros((2, times.size))
    weights[0, where[:n_first]] = first.branch_moduli
    weights[1, where[n_first:]] = second.branch_moduli
    return (
        times[::-1],
        _Part(first.equilibrium_modulus, first.viscosity, weights[0]),
        _Part(second.equilibrium_modulus, second.viscosity, weights[1]),
    )


def _connect(times: Array, first: _Part, second: _Part, *others: _Part) -> PronySeries:
    """Series connection on common times; `others` equal the first up to sign wherever first + second = 0."""
    total = first.plus(second, 1.0)
    roots = secular_roots(total.constant, total.viscosity, total.weights, times)
    both = (first.weights > 0) & (second.weights > 0)
    shared = first.weights[both] * (second.weights[both] / total.weights[both])
    sizes = np.abs(roots.terms)
    candidates = [part.at(roots.times, roots.terms, sizes) for part in (first, second, *others)]
    at_root, size = candidates[0]
    for value, other in candidates[1:]:
        at_root, size = np.where(other < size, value, at_root), np.minimum(size, other)
    moduli = np.concatenate((shared, at_root * (at_root / roots.slopes)))
    relaxation_times = np.concatenate((times[both], roots.times))
    order = np.argsort(relaxation_times)
    equilibrium = _in_series(first.constant, second.constant)
    viscosity = _in_series(first.viscosity, second.viscosity)
    connected = PronySeries.from_checked(
        equilibrium, moduli[order], relaxation_times[order], viscosity
    ).simplified()
    return _without_rounding(connected)


def _in_series(x: float, y: float) -> float:
    return x * (y / (x + y)) if x > 0 and y > 0 else 0.0


def _without_rounding(series: PronySeries) -> PronySeries:
    """Series without the branches that change it nowhere by more than rounding.

    A branch of modulus R_k changes the Carson transform R(s) at any s > 0 by at most
    the fraction R_k/R(1/tau_k).
    """
    moduli, times = series.branch_moduli, series.relaxation_times
    if moduli.size < 2:
        return series
    ratio = times[None, :] / times[:, None]
    level = series.equilibrium_modulus + series.viscosity / times + (ratio / (1.0 + ratio)) @ moduli
    keep = moduli * moduli.size > 0.25 * _EPS * level
    if keep.all():
        return series
    return PronySeries.from_checked(series.equilibrium_modulus, moduli[keep], times[keep], series.viscosity)
