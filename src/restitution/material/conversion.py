"""Conversion of elastic constants, and of Prony series by the correspondence principle, exactly."""

from __future__ import annotations

import math
from typing import Any, Literal, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from restitution import quantities
from restitution.checks import finite, instance, single, single_positive
from restitution.errors import InputError
from restitution.material.models import exactly_one
from restitution.material.prony import PronySeries
from restitution.material.secular import secular_roots

Array = NDArray[np.float64]
Deformation = Literal["tension", "shear", "bulk"]

_EPS = float(np.finfo(np.float64).eps)


def poisson_ratio(shear_modulus: float, bulk_modulus: float) -> float:
    """Poisson ratio nu = (3K - 2G)/(6K + 2G) of two elastic moduli [Pa]; one may be infinite."""
    if bulk_modulus > shear_modulus:
        ratio = shear_modulus / bulk_modulus
        return (3.0 - 2.0 * ratio) / (6.0 + 2.0 * ratio)
    ratio = bulk_modulus / shear_modulus
    return (3.0 * ratio - 2.0) / (6.0 * ratio + 2.0)


def bulk_from_poisson_ratio(shear_modulus: float, ratio: float) -> float:
    """Bulk modulus K = 2G(1 + nu)/(3(1 - 2 nu)) [Pa] of G >= 0 [Pa] and nu in [-1, 0.5]; infinite for nu = 1/2."""
    number = quantities.check_single("poisson_ratio", ratio)
    if shear_modulus == 0 and number < 0.5:
        raise InputError("poisson_ratio", number, "must be 0.5 for a liquid (its equilibrium modulus is 0 Pa)")
    return float(shear_modulus * bulk_factor(number)) if number < 0.5 else math.inf


def static_bulk_modulus(shear_modulus: float, poisson_ratio: float | None, bulk_modulus: float | None) -> float:
    """Bulk modulus [Pa] of a static Poisson ratio, or as it is given."""
    if poisson_ratio is not None:
        return bulk_from_poisson_ratio(shear_modulus, poisson_ratio)
    assert bulk_modulus is not None
    return bulk_modulus


def bulk_factor(ratio: ArrayLike) -> Any:
    """Ratio K/G = 2(1 + nu)/(3(1 - 2 nu)) [-] of Poisson ratios nu in [-1, 0.5]; infinite for 1/2."""
    nu = np.asarray(ratio)
    with np.errstate(divide="ignore"):
        return 2.0 * (1.0 + nu) / (3.0 * (1.0 - 2.0 * nu))


def tension_factor(poisson_ratio: float) -> float:
    """Ratio E/G = 2(1 + nu) [-] of a Poisson ratio nu in (-1, 0.5]."""
    number = single("poisson_ratio", finite("poisson_ratio", poisson_ratio))
    if not -1.0 < number <= 0.5:
        raise InputError("poisson_ratio", number, "must be in (-1, 0.5]")
    return 2.0 * (1.0 + number)


def shear_from_tension(
    tension: PronySeries, *, bulk_modulus: float | None = None, poisson_ratio: float | None = None
) -> PronySeries:
    """Relaxation modulus in shear G(t) [Pa] from that in tension E(t), simplified.

    With a constant bulk modulus the Carson transforms obey 1/(3G) = 1/E - 1/(9K), so G = 3KE/(9K - E). Its rates
    lambda are the roots of E(-lambda) = 9K, one above each rate of E, with branch moduli 27 K^2/(lambda E'(-lambda)).
    G is not the quotient 3KE(t)/(9K - E(t)) in time. With a constant Poisson ratio, G = E/(2(1 + nu)).

    Parameters
    ----------
    tension
        E(t) [Pa].
    bulk_modulus
        Constant K [Pa], above a ninth of the instantaneous E; may be infinite. Exactly one of this and
        `poisson_ratio`.
    poisson_ratio
        Constant nu in (-1, 0.5] [-].

    Raises
    ------
    InputError
        If E leaves no room for a positive G, or if not exactly one of the two is given.

    Examples
    --------
    >>> shear_from_tension(PronySeries(9.0, [27.0], [1.0]), bulk_modulus=5.0)
    PronySeries(3.75, [56.25], [0.25])
    """
    instance("tension", tension, PronySeries, "must be a PronySeries")
    exactly_one(bulk_modulus=bulk_modulus, poisson_ratio=poisson_ratio)
    if poisson_ratio is not None:
        return tension.scaled(1.0 / tension_factor(poisson_ratio)).simplified()
    bulk = _constant_bulk(bulk_modulus)
    if math.isinf(bulk):
        return tension.scaled(1.0 / 3.0).simplified()
    own = tension.simplified()
    highest = own.instantaneous_modulus
    if not highest < 9.0 * bulk:
        wanted = f"must be > {highest / 9.0:g} Pa, a ninth of the instantaneous modulus in tension"
        raise InputError("bulk_modulus", bulk, wanted, "Pa")
    equilibrium = own.equilibrium_modulus
    roots = secular_roots(equilibrium - 9.0 * bulk, 0.0, own.branch_moduli[::-1], own.relaxation_times[::-1])
    moduli = 27.0 * bulk * (bulk / roots.slopes)
    lowest = 3.0 * bulk * equilibrium / (9.0 * bulk - equilibrium)
    return PronySeries(lowest, moduli[::-1], roots.times[::-1]).simplified().known_within(tension.window)


def tension_from_shear(
    shear: PronySeries, *, bulk_modulus: PronySeries | float | None = None, poisson_ratio: float | None = None
) -> PronySeries:
    """Relaxation modulus in tension E(t) [Pa] from that in shear, simplified.

    The Carson transforms obey 1/E = 1/(3G) + 1/(9K).

    Parameters
    ----------
    shear
        G(t) [Pa].
    bulk_modulus
        K [Pa]: constant, infinite or relaxing. Exactly one of this and `poisson_ratio`.
    poisson_ratio
        Constant nu in (-1, 0.5] [-], then E = 2(1 + nu) G.

    Raises
    ------
    InputError
        If K or nu is out of range, or if not exactly one of the two is given.

    Examples
    --------
    >>> tension_from_shear(PronySeries(3.75, [56.25], [0.25]), bulk_modulus=5.0)
    PronySeries(9.0, [27.0], [1.0])
    """
    instance("shear", shear, PronySeries, "must be a PronySeries")
    exactly_one(bulk_modulus=bulk_modulus, poisson_ratio=poisson_ratio)
    if poisson_ratio is not None:
        return shear.scaled(tension_factor(poisson_ratio)).simplified()
    if isinstance(bulk_modulus, PronySeries):
        return series_connection(shear.scaled(3.0), bulk_modulus.scaled(9.0))
    bulk = _constant_bulk(bulk_modulus)
    if math.isinf(bulk):
        return shear.scaled(3.0).simplified()
    return series_connection(shear.scaled(3.0), PronySeries(9.0 * bulk))


def shear_and_bulk(
    series: PronySeries,
    bulk_modulus: float | None,
    poisson_ratio: float | None,
    stated: Deformation | None,
    given: Deformation | None,
) -> tuple[PronySeries, PronySeries | float]:
    """Relaxation in shear and in bulk of a series in the deformation that the data state, or that the user gives."""
    kind = given or stated
    if kind not in ("tension", "shear"):
        raise InputError("deformation", kind, 'must be "tension" or "shear", as the data do not state it')
    if stated not in (None, kind):
        raise InputError("deformation", kind, f'contradicts the data, which hold moduli in "{stated}"')
    bulk = {"bulk_modulus": bulk_modulus, "poisson_ratio": poisson_ratio}
    exactly_one(**bulk)
    shear = shear_from_tension(series, **bulk) if kind == "tension" else series
    if poisson_ratio is None:
        return shear, _constant_bulk(bulk_modulus)
    factor = bulk_factor(quantities.check("poisson_ratio", poisson_ratio))
    return shear, math.inf if math.isinf(factor) else shear.scaled(factor)


def _constant_bulk(value: float | None) -> float:
    if isinstance(value, float) and np.isposinf(value):
        return value
    return single_positive("bulk_modulus", value, quantities.MODULUS.unit)


def series_connection(first: PronySeries, second: PronySeries) -> PronySeries:
    """Series connection C of two Prony series A and B, simplified: 1/C = 1/A + 1/B in Carson transforms.

    Its rates are those shared by A and B, where the branch modulus is that of two springs in series, and the roots
    lambda of A + B = 0 at s = -lambda, where it is A(-lambda)^2/(lambda (A + B)'(-lambda)) > 0.
    """
    return connect(*on_common_times(first.simplified(), second.simplified()))


class Part(NamedTuple):
    """Prony series whose branches lie on relaxation times that it shares with other series."""

    constant: float
    viscosity: float
    weights: Array

    def plus(self, other: Part, factor: float) -> Part:
        """Parallel connection with the other part, the latter times a factor."""
        pairs: Any = zip(self, other, strict=True)
        return Part(*(own + factor * added for own, added in pairs))

    def at(self, times: Array, terms: Array, sizes: Array) -> tuple[Array, Array]:
        """Value at s = -1/times, and the sum of the magnitudes of its terms."""
        steady, flowing = self.constant, self.viscosity / times
        return steady - flowing + terms @ self.weights, steady + flowing + sizes @ self.weights


NOTHING = Part(0.0, 0.0, np.zeros(1))


def on_common_times(first: PronySeries, second: PronySeries) -> tuple[Array, Part, Part]:
    """Descending times of two simplified series, and each series on them."""
    both = np.concatenate((first.relaxation_times, second.relaxation_times))
    times, where = np.unique(both, return_inverse=True)
    where = times.size - 1 - where
    weights = np.zeros((2, times.size))
    weights[0, where[: first.n_branches]] = first.branch_moduli
    weights[1, where[first.n_branches :]] = second.branch_moduli
    one, other = (
        Part(series.equilibrium_modulus, series.parallel_viscosity, own)
        for series, own in zip((first, second), weights, strict=True)
    )
    return times[::-1], one, other


def connect(times: Array, first: Part, second: Part, *others: Part) -> PronySeries:
    """Series connection on common times; `others` equal the first up to sign wherever first + second = 0."""
    total = first.plus(second, 1.0)
    roots = secular_roots(total.constant, total.viscosity, total.weights, times)
    both = (first.weights > 0) & (second.weights > 0)
    shared = first.weights[both] * (second.weights[both] / total.weights[both])
    sizes = np.abs(roots.terms)
    at_root, size = first.at(roots.times, roots.terms, sizes)
    for part in (second, *others):
        # The part of the smallest terms has the smallest error.
        value, other = part.at(roots.times, roots.terms, sizes)
        at_root, size = np.where(other < size, value, at_root), np.minimum(size, other)
    moduli = np.concatenate((shared, at_root * (at_root / roots.slopes)))
    relaxation_times = np.concatenate((times[both], roots.times))
    order = np.argsort(relaxation_times)
    equilibrium = _in_series(first.constant, second.constant)
    viscosity = _in_series(first.viscosity, second.viscosity)
    connected = PronySeries.from_checked(equilibrium, moduli[order], relaxation_times[order], viscosity).simplified()
    # A branch that changes the series nowhere by more than rounding is dropped.
    moduli, times = connected.branch_moduli, connected.relaxation_times
    keep = moduli * moduli.size > 0.25 * _EPS * connected.carson_transform(1.0 / times)
    return PronySeries.from_checked(equilibrium, moduli[keep], times[keep], viscosity)


def _in_series(x: float, y: float) -> float:
    return x * (y / (x + y)) if x > 0 and y > 0 else 0.0
