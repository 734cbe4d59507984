"""Conversion of elastic constants, and of Prony series by the correspondence principle, exactly."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from typing import Any, Literal, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from restitution import quantities
from restitution.checks import Array, Numeric, finite, instance, positive_or_infinite
from restitution.errors import ABSENT, InputError
from restitution.material.models import exactly_one
from restitution.material.prony import PronySeries, merged, refuse_far_apart, secular_roots

Deformation = Literal["tension", "shear", "bulk"]

_EPS = float(np.finfo(np.float64).eps)


def poisson_ratio(shear_modulus: ArrayLike, bulk_modulus: ArrayLike) -> Any:
    """Return the Poisson ratio nu = (3K - 2G)/(6K + 2G) of two elastic moduli [Pa]; one may be infinite."""
    shear, bulk = np.asarray(shear_modulus, dtype=np.float64), np.asarray(bulk_modulus, dtype=np.float64)
    stiff = bulk > shear
    with np.errstate(divide="ignore", invalid="ignore"):
        ratio = np.where(stiff, shear / bulk, bulk / shear)
    rest = np.where(stiff, 3.0 - 2.0 * ratio, 3.0 * ratio - 2.0)
    return (rest / np.where(stiff, 6.0 + 2.0 * ratio, 6.0 * ratio + 2.0))[()]


def bulk_from_poisson_ratio(shear_modulus: Numeric, ratio: ArrayLike) -> Any:
    """Return the bulk modulus K = 2G(1 + nu)/(3(1 - 2 nu)) [Pa], perhaps infinite, of G >= 0 and nu in [-1, 0.5]."""
    if isinstance(ratio, float) and ratio == 0.5:
        return math.inf
    number = quantities.check("poisson_ratio", ratio)
    liquid = (np.asarray(shear_modulus) == 0.0) & (np.asarray(number) < 0.5)
    if liquid.any():
        value = float(np.broadcast_to(number, liquid.shape)[liquid][0])
        raise InputError("poisson_ratio", value, "must be 0.5 for a liquid (its equilibrium modulus is 0 Pa)")
    with np.errstate(invalid="ignore"):
        return np.where(np.asarray(number) < 0.5, shear_modulus * bulk_factor(number), math.inf)[()]


def static_bulk_modulus(shear_modulus: Numeric, poisson_ratio: Numeric | None, bulk_modulus: Numeric | None) -> Any:
    """Return the bulk modulus [Pa] of a static Poisson ratio, or else the bulk modulus itself."""
    if poisson_ratio is not None:
        return bulk_from_poisson_ratio(shear_modulus, poisson_ratio)
    assert bulk_modulus is not None
    return bulk_modulus


def bulk_factor(ratio: ArrayLike) -> Any:
    """Return the ratio K/G = 2(1 + nu)/(3(1 - 2 nu)) [-] of Poisson ratios nu in [-1, 0.5]; infinite for 1/2."""
    nu = np.asarray(ratio)
    with np.errstate(divide="ignore"):
        return 2.0 * (1.0 + nu) / (3.0 * (1.0 - 2.0 * nu))


def tension_factor(poisson_ratio: ArrayLike) -> Any:
    """Return the ratio E/G = 2(1 + nu) [-] of a Poisson ratio nu in (-1, 0.5]."""
    number = finite("poisson_ratio", poisson_ratio)
    bad = ~((np.asarray(number) > -1.0) & (np.asarray(number) <= 0.5))
    if bad.any():
        raise InputError("poisson_ratio", float(np.asarray(number)[bad][0]), "must be in (-1, 0.5]")
    return 2.0 * (1.0 + number)


def shear_from_tension(
    tension: PronySeries, *, bulk_modulus: Numeric | None = None, poisson_ratio: Numeric | None = None
) -> PronySeries:
    """Return the relaxation modulus in shear G(t) [Pa] from that in tension E(t), simplified.

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
    bulk = np.asarray(_constant_bulk(bulk_modulus))
    simple = tension.simplified()
    if np.isinf(bulk).all():
        return simple.scaled(np.full(bulk.shape, 1.0 / 3.0)[()])
    highest = simple.instantaneous_modulus
    poor = ~(np.asarray(highest) < 9.0 * bulk) & ~np.isinf(bulk)
    if poor.any():
        least, value = (float(np.broadcast_to(part, poor.shape)[poor][0]) for part in (highest / 9.0, bulk))
        rule = f"must be > {least:g} Pa, a ninth of the instantaneous modulus in tension"
        raise InputError("bulk_modulus", value, rule, "Pa")
    return _without_bulk(simple, bulk).known_within(tension.window)


def _without_bulk(tension: PronySeries, bulk: Array) -> PronySeries:
    """Return the relaxation in shear of simplified series in tension, for constant bulk moduli, perhaps infinite."""
    shape = np.broadcast_shapes(tension.shape, bulk.shape)
    tension, bulk = tension.broadcast_to(shape), np.broadcast_to(bulk, shape).ravel()
    rigid = np.isinf(bulk)
    lowest, viscosities = np.empty(bulk.size), np.where(rigid, tension.columns[1] * (1.0 / 3.0), 0.0)
    moduli, times = np.zeros((bulk.size, tension.n_branches + 1)), np.ones((bulk.size, tension.n_branches + 1))
    for rows, part in tension.groups():
        equilibrium, _, weights, part_times = part.columns
        count, stiff = weights.shape[1], np.where(rigid[rows], equilibrium + weights.sum(axis=1), bulk[rows])
        roots = secular_roots(equilibrium - 9.0 * stiff, 0.0 * stiff, weights[:, ::-1], part_times[:, ::-1])
        soft = ~rigid[rows, None]
        more = 27.0 * stiff[:, None] * (stiff[:, None] / roots.slopes)
        moduli[rows, :count] = np.where(soft, more[:, ::-1], weights * (1.0 / 3.0))
        times[rows, :count] = np.where(soft, roots.times[:, ::-1], part_times)
        quotient = 3.0 * stiff * equilibrium / (9.0 * stiff - equilibrium)
        lowest[rows] = np.where(rigid[rows], equilibrium * (1.0 / 3.0), quotient)
    times, moduli = (part.reshape(*shape, part.shape[1]) for part in merged(times, moduli))
    series = PronySeries(lowest.reshape(shape), moduli, times, parallel_viscosity=viscosities.reshape(shape))
    return series.simplified()


def tension_from_shear(
    shear: PronySeries, *, bulk_modulus: PronySeries | Numeric | None = None, poisson_ratio: Numeric | None = None
) -> PronySeries:
    """Return the relaxation modulus in tension E(t) [Pa] from that in shear, simplified.

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
    if not isinstance(bulk_modulus, PronySeries):
        bulk_modulus = PronySeries.springs(np.asarray(_constant_bulk(bulk_modulus)))
    return connected(shear, bulk_modulus, ((3.0, 0.0), (0.0, 9.0)))


def shear_and_bulk(
    series: PronySeries,
    bulk_modulus: float | None,
    poisson_ratio: float | None,
    stated: Deformation | None,
    chosen: Deformation | None,
) -> tuple[PronySeries, PronySeries | float]:
    """Return the relaxation in shear and in bulk of a series in the stated deformation, or in the chosen one."""
    kind = chosen or stated
    if kind not in ("tension", "shear"):
        rule = 'must be "tension" or "shear", as the data do not state it'
        raise InputError("deformation", ABSENT if kind is None else kind, rule)
    if stated not in (None, kind):
        raise InputError("deformation", kind, f'contradicts the data, which hold moduli in "{stated}"')
    bulk = {"bulk_modulus": bulk_modulus, "poisson_ratio": poisson_ratio}
    exactly_one(**bulk)
    shear = shear_from_tension(series, **bulk) if kind == "tension" else series
    if poisson_ratio is None:
        return shear, _constant_bulk(bulk_modulus)
    factor = bulk_factor(quantities.check("poisson_ratio", poisson_ratio))
    return shear, math.inf if np.isinf(factor).all() else shear.scaled(factor)


def _constant_bulk(value: Any) -> Any:
    return positive_or_infinite("bulk_modulus", value, quantities.MODULUS.unit)


def series_connection(first: PronySeries, second: PronySeries) -> PronySeries:
    """Return the series connection C of Prony series A and B, simplified: 1/C = 1/A + 1/B in Carson transforms.

    Its rates are those shared by A and B, where the branch modulus is that of two springs in series, and the roots
    lambda of A + B = 0 at s = -lambda, where it is A(-lambda)^2/(lambda (A + B)'(-lambda)) > 0. A spring may be
    infinitely stiff. Arrays broadcast; a row of an array has the bits of a single connection.
    """
    return connected(first, second, ((1.0, 0.0), (0.0, 1.0)))


def reduced(shear: PronySeries, bulk: PronySeries, *, strict: bool = True) -> PronySeries:
    """Return the reduced modulus E* = 4G(3K + G)/(3K + 4G), in Carson transforms, of the contact with a rigid body."""
    # Where 4G + 4K + 4G/3 = 0, also 4G = -3K, which is exact where G itself cancels.
    return connected(shear, bulk, ((4.0, 0.0), (4.0 / 3.0, 4.0), (0.0, 3.0)), strict=strict)


def reduced_in_shear(shear: PronySeries, bulk: PronySeries) -> PronySeries:
    """Return the reduced shear modulus G* = (8/3)G(3K + G)/(3K + 2G), in Carson transforms, of one that sticks."""
    # Where (8/3)G + 8K + (8/3)G = 0, also (8/3)G = -4K.
    return connected(shear, bulk, ((8.0 / 3.0, 0.0), (8.0 / 3.0, 8.0), (0.0, 4.0)))


def reduced_standard_solid(
    poisson_ratio: Array, equilibrium_modulus: Array, branch_modulus: Array, relaxation_time: Array
) -> PronySeries:
    """Return reduced moduli of standard solids in shear whose static Poisson ratio is given; arrays (n,)."""
    # Numbers are not checked: beyond their range an impact fails with NOT_FINITE.
    with np.errstate(all="ignore"):
        factor = bulk_factor(poisson_ratio)
        bulk = equilibrium_modulus * factor
        bulk = PronySeries.springs(np.where(np.isinf(bulk) & np.isfinite(factor), math.nan, bulk))
        shear = PronySeries.from_checked(equilibrium_modulus, branch_modulus[:, None], relaxation_time[:, None])
        return reduced(shear, bulk, strict=False)


class Part(NamedTuple):
    """Rows of Prony series whose branches lie on relaxation times that they share with other series."""

    constant: Array  # shape (n,)
    viscosity: Array  # shape (n,)
    weights: Array  # shape (n, n_time)


def on_common_times(first: PronySeries, second: PronySeries) -> Iterator[tuple[NDArray[np.intp], Array, Part, Part]]:
    """Yield rows of two arrays of simplified series, their descending common times, and each series on them."""
    shape = np.broadcast_shapes(first.shape, second.shape)
    (*ends, moduli, times), (*other_ends, other_moduli, other_times) = (
        series.broadcast_to(shape).columns for series in (first, second)
    )
    absent, other_absent = np.zeros_like(other_moduli), np.zeros_like(moduli)
    if other_moduli.shape[1]:
        times = np.hstack([times, other_times])
        both = np.hstack([moduli, absent]), np.hstack([other_absent, other_moduli])
        times, moduli, other_moduli = merged(times, *both)
    else:
        other_moduli = other_absent
    sizes = ((moduli > 0.0) | (other_moduli > 0.0)).sum(axis=1)
    for size in np.unique(sizes).tolist():
        rows = np.flatnonzero(sizes == size)
        part, other = (
            Part(spring[rows], dashpot[rows], weights[rows, :size][:, ::-1])
            for (spring, dashpot), weights in ((ends, moduli), (other_ends, other_moduli))
        )
        yield rows, times[rows, :size][:, ::-1], part, other


def connected(
    first: PronySeries, second: PronySeries, sums: Sequence[tuple[float, float]], *, strict: bool = True
) -> PronySeries:
    """Return the series connection of the first two sums p A + q B of series A and B; `sums` has their (p, q).

    All further sums equal the first up to sign wherever both sums of the connection cancel. The first one has no B,
    and is the connection where B is infinitely stiff. With `strict`, roots that are not found raise an error.
    """
    shape = np.broadcast_shapes(first.shape, second.shape)
    n, factor = math.prod(shape), sums[0][0]
    is_finite, a = _is_finite(first, shape), first.simplified().broadcast_to(shape).columns
    if np.isinf(second.equilibrium_modulus).all():
        ends, moduli, times = (a[0] * factor, a[1] * factor), a[2] * factor, a[3]
    else:
        is_finite, b = is_finite & _is_finite(second, shape), second.simplified().broadcast_to(shape).columns
        # Numba takes half a second to import.
        from restitution.material.secular import connect_rows, scratch

        most = max(a[2].shape[1], b[2].shape[1])
        branches = np.zeros((2, n, most)), np.ones((2, n, most))
        for place, (_, _, moduli, times) in enumerate((a, b)):
            branches[0][place, :, : moduli.shape[1]], branches[1][place, :, : moduli.shape[1]] = moduli, times
        ends, moduli, times = np.empty((2, n)), np.zeros((n, 4 * most + 1)), np.ones((n, 4 * most + 1))
        springs, dashpots = np.stack([a[0], b[0]]), np.stack([a[1], b[1]])
        connect_rows(springs, dashpots, *branches, np.array(sums), ends, moduli, times, scratch(2 * most, len(sums)))
        if strict and not (is_finite <= np.isfinite(ends[0])).all():
            refuse_far_apart(ends)
        count = int((moduli > 0.0).sum(axis=1).max(initial=0))
        moduli, times = moduli[:, :count], times[:, :count]
    # Unknown numbers are NaN, as they must not look like absent branches.
    equilibrium = ends[0] if is_finite.all() else np.where(is_finite, ends[0], math.nan)
    moduli, times = (part.reshape(*shape, moduli.shape[1]) for part in (moduli, times))
    return PronySeries.from_checked(equilibrium.reshape(shape), moduli, times, ends[1].reshape(shape))


def _is_finite(series: PronySeries, shape: tuple[int, ...]) -> NDArray[np.bool_]:
    """Return whether the branches of the rows have finite numbers."""
    finite = (np.isfinite(series.branch_moduli) & np.isfinite(series.relaxation_times)).all(axis=-1)
    return np.broadcast_to(finite, shape).reshape(-1)
