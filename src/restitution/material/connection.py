"""Series connection of Prony series, in which the compliances add."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from restitution.material.prony import PronySeries
from restitution.material.secular import secular_roots

Array = NDArray[np.float64]

_EPS = float(np.finfo(np.float64).eps)


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

    >>> series_connection(PronySeries(2.0), PronySeries(0.0, parallel_viscosity=6.0))
    PronySeries(0.0, [2.0], [3.0])
    """
    return connect(*on_common_times(first.simplified(), second.simplified()))


class Part(NamedTuple):
    """Prony series whose branches lie on a grid of times that it shares with others."""

    constant: float
    viscosity: float
    weights: Array

    def plus(self, other: Part, factor: float) -> Part:
        """Parallel connection with the other part, the latter times a factor."""
        return Part(
            self.constant + factor * other.constant,
            self.viscosity + factor * other.viscosity,
            self.weights + factor * other.weights,
        )

    def at(self, times: Array, terms: Array, sizes: Array) -> tuple[Array, Array]:
        """Value at s = -1/times and the size of what is summed."""
        steady, flowing = self.constant, self.viscosity / times
        return steady - flowing + terms @ self.weights, steady + flowing + sizes @ self.weights


NOTHING = Part(0.0, 0.0, np.zeros(1))


def on_common_times(first: PronySeries, second: PronySeries) -> tuple[Array, Part, Part]:
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
        Part(first.equilibrium_modulus, first.parallel_viscosity, weights[0]),
        Part(second.equilibrium_modulus, second.parallel_viscosity, weights[1]),
    )


def connect(times: Array, first: Part, second: Part, *others: Part) -> PronySeries:
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
    ratio = times[None, :] / times[:, None]
    level = series.equilibrium_modulus + series.parallel_viscosity / times + (ratio / (1.0 + ratio)) @ moduli
    keep = moduli * moduli.size > 0.25 * _EPS * level
    if keep.all():
        return series
    return PronySeries.from_checked(
        series.equilibrium_modulus, moduli[keep], times[keep], series.parallel_viscosity
    )
