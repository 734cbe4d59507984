"""Least squares: starts from the data, bounds, steps with forward differences, one central Jacobian at the end."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Literal, NamedTuple

import numpy as np
from numpy.typing import NDArray

from restitution.errors import InputError
from restitution.identification.descent import descend, squares
from restitution.identification.observations import Observations
from restitution.identification.parameters import Parameters, penalties, start_and_bounds
from restitution.identification.starts import effective_tables, instantaneous_ratio, lattice, scattered, starts
from restitution.material.columns import MaterialColumns
from restitution.material.fit import DynamicTable

Array = NDArray[np.float64]
Loss = Literal["linear", "soft_l1", "huber", "cauchy"]

# Steps of the coordinates: of logarithms, and of nuisances in units of the noise.
_STEP, _NUISANCE_STEP = 1e-4, 1e-2
# Values of hidden coordinates that are tried, and descents from the best of them.
_TRIALS, _RESCUES = 64, 3
# Further points; the best one is followed too.
_SCATTERED = 16
# Starts that are followed, of an incompressible and of a compressible material.
_BEST, _COMPRESSIBLE = 2, 4
# Descents: largest change of a logarithm in a round, most rounds, and the share of its sum of squares that the next
# step of a finished one would gain, for the search and for the minimum. Minima closer than this are the same.
_FURTHEST, _ROUNDS, _COARSE, _EXACT, _SAME, _MARGIN = 2.0, 100, 1e-3, 1e-8, 0.1, 1e-9
EQUALLY_GOOD = 3.84
"""Difference of two sums of squares within which both fits lie in the region of 95 %."""
# Fewer than one in 10 000 materials has a negative instantaneous Poisson ratio: twice the logarithm of these odds.
_AUXETIC = 18.4
# Factor by which a shift, or a modulus that no datum determines, may move times, for fractional models.
_SHIFTED = 1e4


@dataclass(frozen=True, eq=False)
class EstimationProblem:
    """Data and unknowns: coordinates are the logarithms of the parameters, then the nuisances over their steps.

    Attributes
    ----------
    data : tuple of Observations
        Sets of data.
    space : Parameters
        Unknowns of the model.
    low, high : array, shape (n_unknown,)
        Bounds of the coordinates.
    window : tuple of float
        Shortest and longest time [s] at which fractional models must be valid.
    factors : tuple of float
        Factor of the noise of each set of data; 1 unless its size is unknown.
    """

    data: tuple[Observations, ...]
    space: Parameters
    low: Array
    high: Array
    window: tuple[float, float]
    factors: tuple[float, ...]

    @property
    def n_parameters(self) -> int:
        """Number of parameters of the model."""
        return len(self.space.free)

    @property
    def n_data(self) -> int:
        """Number of measured values, without priors."""
        return sum(one.size for one in self.data)

    @property
    def unknown_sizes(self) -> list[list[int]]:
        """Places of the sets of data in each group whose noise has one unknown size."""
        groups: dict[int, list[int]] = {}
        for n, one in enumerate(self.data):
            if one.scaled:
                groups.setdefault(id(one if one.series is None else one.series), []).append(n)
        return list(groups.values())

    @property
    def steps(self) -> Array:
        """Steps of the coordinates for differences."""
        return np.array([_STEP] * self.n_parameters + [_NUISANCE_STEP] * (self.low.size - self.n_parameters))

    def columns(self, coordinates: Array) -> MaterialColumns:
        """Materials at coordinates of shape (m, n_unknown)."""
        return self.space.columns(coordinates[:, : self.n_parameters], self.window)

    def nuisances(self, coordinates: Array) -> list[Array]:
        """Nuisances of each set of data, shape (m, n_nuisance) each."""
        found, at = [], self.n_parameters
        for one in self.data:
            scale = np.array([nuisance.step for nuisance in one.nuisances])
            found.append(coordinates[:, at : at + scale.size] * scale)
            at += scale.size
        return found

    def residuals(self, coordinates: Array) -> Array:
        """Residuals over their standard deviations, shape (m, n_data + n_prior); NaN where a material fails."""
        # A trial beyond the range of numbers is a row of NaN.
        with np.errstate(over="ignore", divide="ignore", invalid="ignore"):
            materials = self.columns(coordinates)
            parts = [
                one.residuals(materials, nuisances) / factor
                for one, nuisances, factor in zip(self.data, self.nuisances(coordinates), self.factors, strict=True)
            ]
        return np.hstack([*parts, penalties(self.space, coordinates[:, : self.n_parameters])])

    def jacobian(self, coordinates: Array) -> Array:
        """Derivatives of the residuals, shape (n, n_unknown): central differences, one-sided where one side fails."""
        step, n = np.diag(self.steps), self.steps.size
        found = self.residuals(np.concatenate([coordinates + step, coordinates - step, coordinates[None]]))
        up, down, here = found[:n], found[n:-1], found[-1]
        slopes = (up - down) / (2.0 * self.steps[:, None])
        one_sided = np.where(np.isfinite(up), up - here, here - down) / self.steps[:, None]
        return np.nan_to_num(np.where(np.isfinite(slopes), slopes, one_sided), posinf=0.0, neginf=0.0).T


class Fit(NamedTuple):
    """Minimum of the sum of squares."""

    coordinates: Array  # shape (n_unknown,)
    cost: float  # sum of the losses of all residuals, priors included
    converged: bool = True  # whether the next step gains less than the tolerance


def minimise(
    problem: EstimationProblem, start: Array, loss: Loss = "linear", held: int | None = None, tolerance: float = _EXACT
) -> Fit:
    """Local minimum from a start, perhaps with one coordinate held."""
    return _minima(problem, start[None], loss, tolerance, held)[0]


def rescued(
    problem: EstimationProblem, fit: Fit, near: Array, hidden: NDArray[np.intp], loss: Loss, held: int,
    tolerance: float,
) -> Fit:  # fmt: skip
    """The fit, or a better one with the same held coordinate from other values of hidden coordinates.

    All other coordinates start from the fit, and from a point near it, as the fit may be a poor local minimum.
    """
    places = hidden[hidden != held]
    if not places.size:
        return fit
    points = np.tile(np.stack([near, fit.coordinates])[:, None], (1, _TRIALS + 1, 1))
    low, high = problem.low[places], problem.high[places]
    points[:, 1:, places] = low + lattice(_TRIALS, places.size) * (high - low)
    points[..., held] = fit.coordinates[held]
    points = points.reshape(-1, near.size)[:-1]
    chosen = np.argsort(squares(_lossy(problem.residuals(points), loss)), kind="stable")[:_RESCUES]
    found = _minima(problem, points[chosen], loss, tolerance, held)
    return min((fit, *found), key=lambda one: one.cost)


def _minima(
    problem: EstimationProblem, starts: Array, loss: Loss, tolerance: float, held: int | None = None
) -> list[Fit]:
    """Local minima from starts of shape (s, n_unknown); a descent ends if its next step gains less than a share."""

    def residuals(at: Array, _: NDArray[np.intp]) -> Array:
        return _lossy(problem.residuals(at.reshape(-1, at.shape[2])), loss).reshape(*at.shape[:2], -1)

    steps = problem.steps
    if held is not None:
        steps[held] = 0.0
    low, high = (np.broadcast_to(end, starts.shape) for end in (problem.low, problem.high))
    inside = np.where(steps > 0.0, np.clip(starts, low + _MARGIN, high - _MARGIN), starts)
    furthest = np.where(np.arange(steps.size) < problem.n_parameters, _FURTHEST, np.inf)
    found = descend(residuals, inside, low, high, steps, furthest, tolerance, _ROUNDS)
    return [Fit(point, float(cost), bool(ended)) for point, cost, ended in zip(*found, strict=True)]


def _lossy(residuals: Array, loss: Loss) -> Array:
    """Numbers whose squares are the losses of the residuals, with the same signs."""
    size = np.abs(residuals)
    if loss == "soft_l1":
        size = np.sqrt(2.0 * (np.sqrt(1.0 + size * size) - 1.0))
    elif loss == "cauchy":
        size = np.sqrt(np.log1p(size * size))
    elif loss == "huber":
        size = np.where(size <= 1.0, size, np.sqrt(np.maximum(2.0 * size - 1.0, 0.0)))
    return np.copysign(size, residuals)


def efficiency(residuals: Array, loss: Loss) -> tuple[float, float]:
    """Variance of estimates over that of least squares, and the excess of the sum of losses at one standard error.

    mean(psi^2)/mean(psi')^2 and mean(psi^2)/mean(psi') for a loss of slope psi (Huber, Robust Statistics, 1981, 7.6).
    """
    if loss == "linear":
        return 1.0, 1.0
    h = 1e-3
    low, middle, high = (0.5 * _lossy(residuals + step, loss) ** 2 for step in (-h, 0.0, h))
    square, curvature = np.mean(((high - low) / (2.0 * h)) ** 2), np.mean((high - 2.0 * middle + low) / h**2)
    return float(square / curvature**2), float(square / curvature)


def problem_of(data: Sequence[Observations], space: Parameters) -> tuple[EstimationProblem, Array, list[DynamicTable]]:
    """EstimationProblem with its bounds, the start without data, and the effective moduli of the data."""
    tables = effective_tables(data, space)
    sizes = [np.log(np.hypot(one.storage_modulus, one.loss_modulus)).mean() for one in tables]
    modulus = float(np.exp(np.mean(sizes)))
    ends = [end for one in data for end in one.window() if math.isfinite(end)]
    ends += [float(end) for one in tables for end in (one.angular_frequency[0], one.angular_frequency[-1])]
    low, high = min(ends), max(ends)
    start, least, most = start_and_bounds(space, modulus, math.pi / math.sqrt(low * high))
    nuisances = [nuisance for one in data for nuisance in one.nuisances]
    step = np.array([one.step for one in nuisances])
    parts = [np.array([getattr(one, name) for one in nuisances]) / step for name in ("start", "low", "high")]
    start, least, most = (np.append(own, more) for own, more in zip((start, least, most), parts, strict=True))
    # A shift moves the times of the data relative to those of the columns.
    wider = 1.0 if space.shift is None and any(one.fixes_time for one in data) else _SHIFTED
    window = math.pi / (high * wider), math.pi / (low / wider)
    problem = EstimationProblem(tuple(data), space, least, most, window, (1.0,) * len(data))
    if problem.n_data + len(space.prior) < start.size:
        wanted = f"must hold at least as many values as there are unknowns ({start.size})"
        raise InputError("data", problem.n_data, wanted)
    return problem, start, tables


class Estimation(NamedTuple):
    """Best fit, the other fits, and the Jacobian at the best."""

    problem: EstimationProblem
    loss: Loss
    fit: Fit
    fits: tuple[Fit, ...]
    jacobian: Array  # central, shape (n_data + n_prior, n_unknown)


def estimate(data: Sequence[Observations], space: Parameters, loss: Loss = "linear") -> Estimation:
    """Fit a model to data from starts of the data."""
    problem, centre, tables = problem_of(data, space)
    points = starts(space, tables, problem.columns, centre, problem.low, problem.high)
    points = np.vstack([_chosen(problem, points), _best_scattered(problem, centre)])
    *fits, other = _minima(problem, points, loss, _COARSE)
    # One of many equal minima that is far from the effective moduli would only hide that there are many.
    if other.cost < min(one.cost for one in fits) - _significant(problem, other):
        fits.append(other)
    fits = _deeper(problem, fits, loss)
    if not math.isfinite(fits[0].cost):
        raise InputError("start", wanted="no start leads to a result for all data; give start")
    for _ in range(5):
        rescaled = _rescaled(problem, fits[0], loss)
        if rescaled is None:
            break
        problem = rescaled
        if len(data) == 1 and loss == "linear" and not space.prior:  # the minimum stays where it is
            fits = [one._replace(cost=one.cost / rescaled.factors[0] ** 2) for one in fits]
            break
        fits = _deeper(problem, fits, loss)
    fits = [fits[k] for k in np.argsort(ranks(problem, fits), kind="stable")]
    return moved(Estimation(problem, loss, fits[0], tuple(fits), np.empty((0, 0))), fits[0])


def _chosen(problem: EstimationProblem, points: Array) -> Array:
    """Starts with the smallest residuals; of a compressible material one of four may have a negative Poisson ratio."""
    order = np.argsort(squares(problem.residuals(points)), kind="stable")
    ratio = instantaneous_ratio(problem.columns(points))[order]
    auxetic = ratio > 1.0
    turn = np.where(auxetic, _COMPRESSIBLE * np.cumsum(auxetic) - _COMPRESSIBLE + 1.5, np.cumsum(~auxetic))
    return points[order[np.argsort(turn, kind="stable")][: _COMPRESSIBLE if np.any(ratio > 0.0) else _BEST]]


def _significant(problem: EstimationProblem, fit: Fit) -> float:
    """Difference of sums of squares beyond that of equally good fits, by the residuals if the noise is unknown."""
    freedom = max(problem.n_data - fit.coordinates.size, 1)
    return EQUALLY_GOOD * (fit.cost / freedom if problem.unknown_sizes else 1.0)


def _best_scattered(problem: EstimationProblem, centre: Array) -> Array:
    """The best one of points around the centre; the formulas for effective moduli fail where e is small."""
    points = np.clip(scattered(problem.space, centre, _SCATTERED), problem.low + _MARGIN, problem.high - _MARGIN)
    with np.errstate(all="ignore"):
        return points[[np.argmin(squares(problem.residuals(points)))]]


def _deeper(problem: EstimationProblem, fits: Sequence[Fit], loss: Loss) -> list[Fit]:
    """Minima near fits, best first, one of each place."""
    found: list[Fit] = []
    for one in sorted(fits, key=lambda fit: fit.cost):
        if all(np.abs(one.coordinates - other.coordinates).max() > _SAME for other in found):
            found.append(one)
    ends = _minima(problem, np.stack([one.coordinates for one in found]), loss, _EXACT)
    return sorted(ends, key=lambda fit: fit.cost)


def ranks(problem: EstimationProblem, fits: Sequence[Fit]) -> Array:
    """Sums of squares, with the odds against a negative instantaneous Poisson ratio unless a prior has its own."""
    bulk = [name for name in problem.space.names if name in ("bulk_modulus", "poisson_ratio")]
    odds = (0.0 if bulk[0] in problem.space.prior else _AUXETIC) if bulk else EQUALLY_GOOD
    auxetic = instantaneous_ratio(problem.columns(np.stack([one.coordinates for one in fits]))) > 1.0
    return np.array([one.cost for one in fits]) + np.where(auxetic, odds, 0.0)


def moved(estimation: Estimation, best: Fit) -> Estimation:
    """The estimation at another fit, with branches in ascending order of their times."""
    best = best._replace(coordinates=_ordered(estimation.problem.space, best.coordinates))
    return estimation._replace(fit=best, jacobian=estimation.problem.jacobian(best.coordinates))


def _ordered(space: Parameters, coordinates: Array) -> Array:
    """Coordinates with free branches in ascending order of their relaxation times."""
    places = {argument: [k for k, one in enumerate(space.free) if one.argument == argument]
              for argument in ("branch_moduli", "relaxation_times")}  # fmt: skip
    moduli, times = places.values()
    if len(moduli) != len(times) or any(name.partition("[")[0] in places for name in (*space.prior, *space.start)):
        return coordinates
    order, found = np.argsort(coordinates[times], kind="stable"), coordinates.copy()
    for group in (moduli, times):
        found[group] = coordinates[group][order]
    return found


def _rescaled(problem: EstimationProblem, fit: Fit, loss: Loss) -> EstimationProblem | None:
    """Problem with estimates of the unknown sizes of noise; None if no size changes by more than a percent."""
    groups = problem.unknown_sizes
    if not groups:
        return None
    ends = np.cumsum([one.size for one in problem.data])
    parts = np.split(problem.residuals(fit.coordinates[None])[0], ends)
    share = problem.n_data / max(problem.n_data - fit.coordinates.size, 1)
    factors = list(problem.factors)
    for group in groups:
        own = np.concatenate([parts[n] for n in group])
        # The median is that of a normal distribution also beside outliers.
        size = float(np.mean(own**2)) if loss == "linear" else (float(np.median(np.abs(own))) / 0.6745) ** 2
        for n in group:
            factors[n] *= math.sqrt(max(size * share, 1e-12))
    if all(abs(math.log(new / old)) < 0.01 for new, old in zip(factors, problem.factors, strict=True)):
        return None
    return replace(problem, factors=tuple(factors))
