"""Least squares of an identification: starts from the data, and Levenberg-Marquardt descents of many at once."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import Any, Literal, NamedTuple

import numpy as np
from numpy.typing import NDArray

from restitution.checks import Array, Places
from restitution.contact.adhesion import maugis_number
from restitution.errors import InputError
from restitution.identification.adhesion import STEP as ADHESION_STEP
from restitution.identification.observations import Observations, modulus, nuisances_of
from restitution.identification.parameters import Parameters, penalties, rows_of, start_and_bounds
from restitution.material.fit import DynamicTable
from restitution.material.prony import PronySeries
from restitution.material.viscoelastic import RIGID, Material
from restitution.numerics.differences import CENTRAL, STEP
from restitution.numerics.least_squares import descend, squares

# Starts of a fit: materials whose complex modulus is near the effective moduli of the data.

# Descents to the effective moduli: largest change of a logarithm in a round, least gain, and rounds at most.
_SEARCH_FURTHEST, _ENOUGH, _SEARCH_ROUNDS = 2.0, 1e-2, 12
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
    """Return effective moduli of the data; of an arbitrary size if the data contain none."""
    tables = [table for record in data for table in record.moduli_by_temperature()]
    if not tables:
        moduli = [float(np.nanmax(value)) for name, value in space.fixed.items()
                 if "modul" in name and name != "bulk_modulus" and np.any(np.isfinite(value))]  # fmt: skip
        size = 4.0 * moduli[0] if moduli else _ARBITRARY
        tables = [table for record in data if (table := record.assumed_moduli(size)) is not None]
    unit = np.ones(1)
    return tables or [DynamicTable(_ARBITRARY_FREQUENCY * unit, _ARBITRARY * unit, 0.1 * _ARBITRARY * unit)]


def starts(
    space: Parameters, tables: Sequence[DynamicTable], build: Callable[[Array], Material],
    centre: Array, low: Array, high: Array,
) -> Array:  # fmt: skip
    """Return coordinates of distinct starts, shape (s, n_unknown).

    The complex modulus of the model is fitted to the effective moduli from these points. An unknown bulk modulus is
    held at three values: these moduli hardly depend on it.
    """
    n = len(space.free)
    points = scattered(space, centre, _N_STARTS)
    held = -1
    for k, parameter in enumerate(space.free):
        if parameter.name in _BULKS:
            values = np.array(_BULKS[parameter.name])
            if parameter.name == "bulk_modulus":
                values = values * float(np.hypot(tables[0].storage_modulus, tables[0].loss_modulus)[0])
            if parameter.name in (*space.start, *space.prior):
                values[0] = parameter.outward(centre[k])
            held, points[:, k] = k, parameter.inward(values)[np.arange(_N_STARTS) % values.size]
    points = np.clip(points, low + 1e-6, high - 1e-6)

    moduli = [table.storage_modulus + 1j * table.loss_modulus for table in tables]

    def misfits(coordinates: Array, plausible: NDArray[np.bool_]) -> Array:
        materials, parts = build(coordinates), list[Array]()
        for table, measured in zip(tables, moduli, strict=True):
            temperature = None if space.shift is None else table.temperature
            series = modulus(materials, temperature, table.deformation)
            ratio: Any = np.log(series.complex_modulus(table.angular_frequency) / measured)
            parts += [ratio.real / _MODULUS_ERROR, ratio.imag / (_PHASE_ERROR * np.angle(measured) + 1e-3)]
        excess = np.log(np.maximum(instantaneous_ratio(materials) / _PLAUSIBLE, 1.0)) * plausible / _MODULUS_ERROR
        return np.hstack([*parts, excess[:, None], penalties(space, coordinates[:, :n])])

    def residuals(at: Array, places: Places) -> Array:
        coordinates = at.reshape(-1, at.shape[2])
        # The other half may have a negative instantaneous Poisson ratio.
        plausible = np.repeat(places % 2 == 0, at.shape[1])
        ends = rows_of(lambda rows: misfits(coordinates[rows], plausible[rows]), len(coordinates))
        return ends.reshape(*at.shape[:2], -1)

    steps = np.where((np.arange(centre.size) < n) & (np.arange(centre.size) != held), STEP, 0.0)
    low, high = np.broadcast_to(low, points.shape), np.broadcast_to(high, points.shape)
    with np.errstate(all="ignore"):
        ends = descend(
            residuals, points, low, high, steps, np.full(centre.size, _SEARCH_FURTHEST), _ENOUGH, _SEARCH_ROUNDS
        )
    points, costs = ends.points, ends.costs
    chosen: list[int] = []
    for k in np.argsort(costs, kind="stable"):
        if math.isfinite(costs[k]) and all(np.abs(points[k] - points[other]).max() > _APART for other in chosen):
            chosen.append(int(k))
    return points[chosen] if chosen else centre[None]


def scattered(space: Parameters, centre: Array, n_points: int) -> Array:
    """Return points around a centre, within 1.5 decades of each parameter that the user gave no start."""
    n = len(space.free)
    wide = [1.0 if parameter.kind == "logit" or parameter.name in space.adhesion else _SPREAD
            for parameter in space.free]  # fmt: skip
    spread = [0.0 if parameter.name in space.start else size for parameter, size in zip(space.free, wide, strict=True)]
    points = np.tile(centre, (n_points, 1))
    points[:, :n] += (2.0 * lattice(n_points, n) - 1.0) * spread
    return points


def instantaneous_ratio(materials: Material) -> Array:
    """Return 2G/(3K) of the instantaneous moduli, shape (m,); above 1 their Poisson ratio is negative."""
    bulk = materials.bulk if isinstance(materials.bulk, PronySeries) else RIGID
    glass = (each.equilibrium_modulus + each.branch_moduli.sum(axis=-1) for each in (materials.shear, bulk))
    shear, bulk = glass
    with np.errstate(divide="ignore"):  # a material with a Poisson ratio of -1 has no bulk modulus
        return (2.0 * shear / (3.0 * bulk))[:, 0]


def lattice(n_points: int, n: int) -> Array:
    """Return points of an additive lattice, which fill the unit cube evenly, shape (n_points, n)."""
    return np.mod(0.5 + np.outer(np.arange(n_points), _lattice_root(n) ** -np.arange(1.0, n + 1.0)), 1.0)


def _lattice_root(n: int) -> float:
    """Return the positive root of x^(n + 1) = x + 1."""
    x = 1.5
    for _ in range(40):
        x = (1.0 + x) ** (1.0 / (n + 1.0))
    return x


# Least squares: starts from the data, bounds, steps with forward differences, one central Jacobian at the end.

Loss = Literal["linear", "soft_l1", "huber", "cauchy"]

# Step of nuisances in units of the noise.
_NUISANCE_STEP = 1e-2
# Values of hidden coordinates that are tried, and descents from the best of them; fewer where a trial is costly.
_TRIALS, _RESCUES, _COSTLY_TRIALS = 64, 3, 8
# Changes of the logarithms of an adhesion in search of better minima, and searches at most.
_AROUND, _SEARCHES = (-0.3, -0.1, 0.1, 0.3), 4
# Logarithms, from the middle of its bounds, at which a stress is held in this search; a range has the opposite ones.
_HELD = (-1.0, -0.4, 0.2, 0.8, 1.4, 2.0)
# Share of the sum of squares by which another minimum counts in this search, and a factor for fits with a held number.
_LITTLE, _BROAD = 0.01, 2.0
# Least tolerance where marches with few elements have kinks.
_ROUGH = 1e-4
# Further points; the best one is followed too. Of records with jumps most points have these elsewhere: with n
# unknowns, or the second number if that is less, the n best of n^2 times as many points are followed.
_SCATTERED, _MOST_FOLLOWED = 16, 4
# Starts that are followed, of an incompressible and of a compressible material.
_BEST, _COMPRESSIBLE = 2, 4
# Descents: largest change of a logarithm in a round, most rounds, and the share of its sum of squares that the next
# step of a finished one would gain, for the search and for the minimum. Minima closer than this are the same.
_FURTHEST, _ROUNDS, _COARSE, _EXACT, _SAME, _MARGIN = 2.0, 100, 1e-3, 1e-8, 0.1, 1e-9
# Most rounds of descents with adhesion, whose trials are costly, for the search and for the minimum.
_FEW_ROUNDS, _MORE_ROUNDS = 15, 40
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
        return sum(record.size for record in self.data)

    @property
    def jumps(self) -> bool:
        """Whether there are records with jumps."""
        return any(record.jumps for record in self.data)

    @property
    def unknown_sizes(self) -> list[list[int]]:
        """Places of the sets of data in each group whose noise has one unknown size."""
        groups: dict[int, list[int]] = {}
        for n, record in enumerate(self.data):
            if record.scaled:
                groups.setdefault(id(record if record.series is None else record.series), []).append(n)
        return list(groups.values())

    @property
    def steps(self) -> Array:
        """Steps of the coordinates for differences."""
        step = ADHESION_STEP if self.space.adhesion else STEP
        return np.array([step] * self.n_parameters + [_NUISANCE_STEP] * (self.low.size - self.n_parameters))

    def materials(self, coordinates: Array) -> Material:
        """Return materials at coordinates of shape (m, n_unknown), an array of shape (m, 1)."""
        return self.space.materials(coordinates[:, : self.n_parameters], self.window)

    def instantaneous_ratio(self, coordinates: Array) -> Array:
        """Ratio 2G/(3K) of the instantaneous moduli, shape (m,); NaN where the model refuses the numbers."""
        ratios = rows_of(
            lambda rows: instantaneous_ratio(self.materials(coordinates[rows]))[:, None], len(coordinates)
        )
        return ratios[:, 0]

    def nuisances(self, coordinates: Array) -> list[Array]:
        """Return nuisances of each set of data, shape (m, n_nuisance) each."""
        return nuisances_of(self.data, coordinates[:, self.n_parameters :])

    def residuals(self, coordinates: Array) -> Array:
        """Return residuals over their standard deviations, shape (m, n_data + n_prior); NaN where a material fails."""
        return rows_of(lambda rows: self.misfits(coordinates[rows]), len(coordinates))

    def misfits(self, coordinates: Array) -> Array:
        """Return the residuals; a refused material raises its error."""
        with np.errstate(over="ignore", divide="ignore", invalid="ignore"):
            materials = self.materials(coordinates)
            parts = [
                record.residuals(materials, nuisances) / factor
                for record, nuisances, factor in zip(self.data, self.nuisances(coordinates), self.factors, strict=True)
            ]
        return np.hstack([*parts, self.penalties(coordinates)])

    def penalties(self, coordinates: Array) -> Array:
        """Return further residuals, those of the priors, shape (m, n_prior)."""
        return penalties(self.space, coordinates[:, : self.n_parameters])

    def linearised(self, coordinates: Array) -> tuple[Array, Array]:
        """Return residuals at a point, shape (n,), and their central differences, shape (n, n_unknown).

        Differences are one-sided where one side fails.
        """
        values = self.residuals(CENTRAL.points(coordinates, self.steps))
        slopes = CENTRAL.slopes(values, self.steps, one_sided=True)
        return values[0], np.nan_to_num(slopes, posinf=0.0, neginf=0.0).T


class Fit(NamedTuple):
    """Minimum of the sum of squares."""

    coordinates: Array  # shape (n_unknown,)
    cost: float  # sum of the losses of all residuals, priors included
    converged: bool = True  # whether the next step gains less than the tolerance


def minimise(
    problem: EstimationProblem, start: Array, loss: Loss = "linear", held: int | None = None, tolerance: float = _EXACT
) -> Fit:
    """Return the local minimum from a start, perhaps with one coordinate held."""
    return _minima(problem, start[None], loss, tolerance, held)[0]


def rescued(
    problem: EstimationProblem, fit: Fit, near: Array, hidden: Places, loss: Loss, held: int,
    tolerance: float,
) -> Fit:  # fmt: skip
    """Return the fit, or a better one with the same held coordinate from other values of hidden coordinates.

    All other coordinates start from the fit, and from a point near it, as the fit may be a poor local minimum.
    """
    places = hidden[hidden != held]
    if not places.size:
        return fit
    n = _COSTLY_TRIALS if problem.space.adhesion else _TRIALS
    points = np.tile(np.stack([near, fit.coordinates])[:, None], (1, n + 1, 1))
    low, high = problem.low[places], problem.high[places]
    points[:, 1:, places] = low + lattice(n, places.size) * (high - low)
    points[..., held] = fit.coordinates[held]
    points = points.reshape(-1, near.size)[:-1]
    chosen = np.argsort(squares(_lossy(problem.residuals(points), loss)), kind="stable")[:_RESCUES]
    fits = _minima(problem, points[chosen], loss, tolerance, held)
    return min((fit, *fits), key=lambda fit: fit.cost)


def _minima(
    problem: EstimationProblem, starts: Array, loss: Loss, tolerance: float, held: int | None = None
) -> list[Fit]:
    """Return local minima from starts of shape (s, n_unknown); the next step gains less than the tolerance."""

    def residuals(at: Array, _: Places) -> Array:
        return _lossy(problem.residuals(at.reshape(-1, at.shape[2])), loss).reshape(*at.shape[:2], -1)

    steps = problem.steps
    if held is not None:
        steps[held] = 0.0
    low, high = (np.broadcast_to(end, starts.shape) for end in (problem.low, problem.high))
    inside = np.where(steps > 0.0, np.clip(starts, low + _MARGIN, high - _MARGIN), starts)
    furthest = np.where(np.arange(steps.size) < problem.n_parameters, _FURTHEST, np.inf)
    tolerance = max(tolerance, _ROUGH) if problem.space.adhesion else tolerance
    rounds = (_FEW_ROUNDS if tolerance >= _COARSE else _MORE_ROUNDS) if problem.space.adhesion else _ROUNDS
    ends = descend(residuals, inside, low, high, steps, furthest, tolerance, rounds)
    return [Fit(point, float(cost), bool(ended)) for point, cost, ended in zip(*ends, strict=True)]


def _lossy(residuals: Array, loss: Loss) -> Array:
    """Return numbers whose squares are the losses of the residuals, with the same signs."""
    if loss == "linear":
        return residuals
    size = np.abs(residuals)
    if loss == "soft_l1":
        size = np.sqrt(2.0 * (np.sqrt(1.0 + size * size) - 1.0))
    elif loss == "cauchy":
        size = np.sqrt(np.log1p(size * size))
    elif loss == "huber":
        size = np.where(size <= 1.0, size, np.sqrt(np.maximum(2.0 * size - 1.0, 0.0)))
    return np.copysign(size, residuals)


def efficiency(residuals: Array, loss: Loss) -> tuple[float, float]:
    """Return the variance over that of least squares, and the excess of the sum of losses at one standard error.

    mean(psi^2)/mean(psi')^2 and mean(psi^2)/mean(psi') for a loss of slope psi (Huber, Robust Statistics, 1981, 7.6).
    """
    if loss == "linear":
        return 1.0, 1.0
    h = 1e-3
    low, middle, high = (0.5 * _lossy(residuals + step, loss) ** 2 for step in (-h, 0.0, h))
    square, curvature = np.mean(((high - low) / (2.0 * h)) ** 2), np.mean((high - 2.0 * middle + low) / h**2)
    return float(square / curvature**2), float(square / curvature)


def problem_of(data: Sequence[Observations], space: Parameters) -> tuple[EstimationProblem, Array, list[DynamicTable]]:
    """Return the `EstimationProblem` with its bounds, the start without data, and the effective moduli of the data."""
    tables = effective_tables(data, space)
    sizes = [np.log(np.hypot(table.storage_modulus, table.loss_modulus)).mean() for table in tables]
    modulus = float(np.exp(np.mean(sizes)))
    ends = [end for record in data for end in record.window() if math.isfinite(end)]
    ends += [float(end) for table in tables for end in (table.angular_frequency[0], table.angular_frequency[-1])]
    low, high = min(ends), max(ends)
    sizes = _adhesion_sizes(data, modulus)
    start, least, most = start_and_bounds(space, modulus, math.pi / math.sqrt(low * high), sizes)
    nuisances = [nuisance for record in data for nuisance in record.nuisances]
    step = np.array([nuisance.step for nuisance in nuisances])
    parts = [np.array([getattr(nuisance, name) for nuisance in nuisances]) / step for name in ("start", "low", "high")]
    start, least, most = (np.append(part, more) for part, more in zip((start, least, most), parts, strict=True))
    # A shift moves the times of the data relative to those of the columns.
    wider = 1.0 if space.shift is None and any(record.fixes_time for record in data) else _SHIFTED
    window = math.pi / (high * wider), math.pi / (low / wider)
    problem = EstimationProblem(tuple(data), space, least, most, window, (1.0,) * len(data))
    if problem.n_data + len(space.prior) < start.size:
        rule = f"must hold at least as many values as there are unknowns ({start.size})"
        raise InputError("data", problem.n_data, rule)
    return problem, start, tables


def _adhesion_sizes(data: Sequence[Observations], modulus: float) -> dict[str, float]:
    """Return sizes of work [J/m^2], stress [Pa] and range [m] of adhesion at an effective modulus E* [Pa]."""
    contacts = [each for record in data if (each := record.assumed_contact(modulus)) is not None]
    if not contacts:
        return {}
    work, radius = np.exp(np.log(np.array(contacts)).mean(axis=0)).tolist()
    # Maugis' lambda is 1 there.
    stress = 1.0 / maugis_number(work, 1.0, modulus, radius)
    return {"work": work, "stress": stress, "range": work / stress}


class Estimation(NamedTuple):
    """Best fit, the other fits, and the residuals at the best with their derivatives."""

    problem: EstimationProblem
    loss: Loss
    fit: Fit
    fits: tuple[Fit, ...]
    residuals: Array  # shape (n_data + n_prior,)
    jacobian: Array  # central, shape (n_data + n_prior, n_unknown)


def estimate(data: Sequence[Observations], space: Parameters, loss: Loss = "linear") -> Estimation:
    """Fit a model to data from starts of the data."""
    problem, centre, tables = problem_of(data, space)
    points = starts(space, tables, problem.materials, centre, problem.low, problem.high)
    points = np.vstack([_chosen(problem, points), _best_scattered(problem, centre)])
    fits = _deeper(problem, _first_fits(problem, points, loss), loss)
    if not math.isfinite(fits[0].cost):
        # Rows of a refused material are NaN, which hides the reason.
        problem.misfits(centre[None])  # the error of the model or of the data, if there is one
        raise InputError("data", rule=_without_result(problem, points))
    if space.adhesion:
        # Other minima are sought with few elements, as the search takes most of the time.
        for _ in range(_SEARCHES):
            best = fits[0]
            others = [*_held(problem, best.coordinates[None], loss), *_around(problem, best, loss)]
            fits = _deeper(problem, _near(problem, [*fits, *others]), loss)
            if fits[0].cost > best.cost - _enough(problem, best):
                break
        here = fits[0].coordinates[None]
        each = zip(data, problem.nuisances(here), strict=True)
        problem = replace(problem, data=tuple(record.refined(problem.materials(here), at) for record, at in each))
        fits = _deeper(problem, fits, loss)
    # A new size of the noise moves the minimum of several sets of data, of a robust loss, or with a prior.
    for _ in range(5):
        rescaled = _rescaled(problem, fits[0], loss)
        if rescaled is None:
            break
        problem = rescaled
        if len(data) == 1 and loss == "linear" and not space.prior:  # the minimum stays where it is
            fits = [fit._replace(cost=fit.cost / rescaled.factors[0] ** 2) for fit in fits]
            break
        fits = _deeper(problem, fits, loss)
    fits = [fits[k] for k in np.argsort(ranks(problem, fits), kind="stable")]
    return moved(problem, loss, fits[0], fits)


def _first_fits(problem: EstimationProblem, points: Array, loss: Loss) -> list[Fit]:
    """Return fits from starts; the last start is far from the effective moduli."""
    if problem.jumps:
        return _near(problem, _held(problem, points, loss) or _minima(problem, points, loss, _COARSE), _BROAD)
    *fits, other = _minima(problem, points, loss, _COARSE)
    # One of many equal minima that is far from the effective moduli would only hide that there are many.
    far = other.cost < min(fit.cost for fit in fits) - _significant(problem, other)
    return [*fits, other] if far else fits


def _held(problem: EstimationProblem, points: Array, loss: Loss) -> list[Fit]:
    """Return fits from points with the stress or the range of an adhesion at a few values; none if both are known.

    The other unknowns follow a held one, whereas a descent of all ends in one of many small minima.
    """
    space, low, high = problem.space, problem.low, problem.high
    for k, parameter in enumerate(space.free):
        if parameter.name in ("stress", "range"):
            change = np.array(_HELD) * (1.0 if parameter.name == "stress" else -1.0)
            given = parameter.inward(space.start[parameter.name]) if parameter.name in space.start else []
            values = np.append(0.5 * (low[k] + high[k]) + change, given)
            values = np.unique(np.clip(values, low[k] + _MARGIN, high[k] - _MARGIN))
            there = np.repeat(points, values.size, axis=0)
            there[:, k] = np.tile(values, len(points))
            return _minima(problem, there, loss, _COARSE, k)
    return []


def _around(problem: EstimationProblem, fit: Fit, loss: Loss) -> list[Fit]:
    """Return fits from points around one with another adhesion: a jump that is a sample away makes another minimum.

    Where the adhesion is known, the points have other moduli.
    """
    n, move = problem.n_parameters, np.eye(fit.coordinates.size)
    places = [k for k in range(n) if problem.space.names[k] in problem.space.adhesion] or range(n)
    moves = [change * move[k] for k in places for change in _AROUND]
    return _minima(problem, fit.coordinates + np.array(moves), loss, _COARSE)


def _enough(problem: EstimationProblem, fit: Fit) -> float:
    """Return the difference of sums of squares by which another minimum counts in a search."""
    return max(_significant(problem, fit), _LITTLE * fit.cost)


def _near(problem: EstimationProblem, fits: Sequence[Fit], factor: float = 1.0) -> list[Fit]:
    """Return fits that are nearly as good as the best one."""
    best = min(fits, key=lambda fit: fit.cost)
    return [fit for fit in fits if fit.cost <= best.cost + factor * _enough(problem, best)]


def _without_result(problem: EstimationProblem, points: Array) -> str:
    """Return which data have no prediction at the starts."""
    with np.errstate(all="ignore"):
        materials, nuisances = problem.materials(points), problem.nuisances(points)
        solved = [np.isfinite(record.residuals(materials, at)).all(axis=1).any()
                 for record, at in zip(problem.data, nuisances, strict=True)]  # fmt: skip
    names = [record.label or f"data[{n}]" for n, record in enumerate(problem.data) if not solved[n]]
    if not names:
        return "have no material for which all of them have a prediction; give start or bounds"
    return f"have no prediction by any of {len(points)} materials near their moduli: {', '.join(names)}; give bounds"


def _chosen(problem: EstimationProblem, points: Array) -> Array:
    """Choose starts with the smallest residuals; one of four may have a negative Poisson ratio."""
    order = np.argsort(squares(problem.residuals(points)), kind="stable")
    ratio = problem.instantaneous_ratio(points)[order]
    auxetic = ratio > 1.0
    turn = np.where(auxetic, _COMPRESSIBLE * np.cumsum(auxetic) - _COMPRESSIBLE + 1.5, np.cumsum(~auxetic))
    return points[order[np.argsort(turn, kind="stable")][: _COMPRESSIBLE if np.any(ratio > 0.0) else _BEST]]


def _significant(problem: EstimationProblem, fit: Fit) -> float:
    """Return the difference of sums of squares beyond that of equally good fits."""
    freedom = max(problem.n_data - fit.coordinates.size, 1)
    return EQUALLY_GOOD * (fit.cost / freedom if problem.unknown_sizes else 1.0)


def _best_scattered(problem: EstimationProblem, centre: Array) -> Array:
    """Return the best of points around the centre; the formulas for effective moduli fail where e is small."""
    best = min(problem.n_parameters, _MOST_FOLLOWED) if problem.jumps else 1
    points = scattered(problem.space, centre, best * best * _SCATTERED)
    points = np.clip(points, problem.low + _MARGIN, problem.high - _MARGIN)
    with np.errstate(all="ignore"):
        return points[np.argsort(squares(problem.residuals(points)), kind="stable")[:best]]


def _deeper(problem: EstimationProblem, fits: Sequence[Fit], loss: Loss) -> list[Fit]:
    """Return minima near fits, best first, one of each place."""
    places: list[Fit] = []
    for fit in sorted(fits, key=lambda fit: fit.cost):
        if all(np.abs(fit.coordinates - other.coordinates).max() > _SAME for other in places):
            places.append(fit)
    ends = _minima(problem, np.stack([fit.coordinates for fit in places]), loss, _EXACT)
    return sorted(ends, key=lambda fit: fit.cost)


def ranks(problem: EstimationProblem, fits: Sequence[Fit]) -> Array:
    """Return sums of squares, with the odds against a negative instantaneous Poisson ratio without a prior."""
    bulk = [name for name in problem.space.names if name in ("bulk_modulus", "poisson_ratio")]
    odds = (0.0 if bulk[0] in problem.space.prior else _AUXETIC) if bulk else EQUALLY_GOOD
    auxetic = problem.instantaneous_ratio(np.stack([fit.coordinates for fit in fits])) > 1.0
    return np.array([fit.cost for fit in fits]) + np.where(auxetic, odds, 0.0)


def moved(problem: EstimationProblem, loss: Loss, best: Fit, fits: Sequence[Fit]) -> Estimation:
    """Return the estimation at one of several fits, with branches in ascending order of their times."""
    best = best._replace(coordinates=_ordered(problem.space, best.coordinates))
    return Estimation(problem, loss, best, tuple(fits), *problem.linearised(best.coordinates))


def _ordered(space: Parameters, coordinates: Array) -> Array:
    """Return coordinates with free branches in ascending order of their relaxation times."""
    places = {argument: [k for k, parameter in enumerate(space.free) if parameter.argument == argument]
              for argument in ("branch_moduli", "relaxation_times")}  # fmt: skip
    moduli, times = places.values()
    if len(moduli) != len(times) or any(name.partition("[")[0] in places for name in (*space.prior, *space.start)):
        return coordinates
    order, ordered = np.argsort(coordinates[times], kind="stable"), coordinates.copy()
    for group in (moduli, times):
        ordered[group] = coordinates[group][order]
    return ordered


def _rescaled(problem: EstimationProblem, fit: Fit, loss: Loss) -> EstimationProblem | None:
    """Problem with estimates of the unknown sizes of noise; None if no size changes by more than a percent."""
    groups = problem.unknown_sizes
    if not groups:
        return None
    ends = np.cumsum([record.size for record in problem.data])
    parts = np.split(problem.residuals(fit.coordinates[None])[0], ends)
    share = problem.n_data / max(problem.n_data - fit.coordinates.size, 1)
    factors = list(problem.factors)
    for group in groups:
        residuals = np.concatenate([parts[n] for n in group])
        # The median is that of a normal distribution also beside outliers.
        size = (
            float(np.mean(residuals**2)) if loss == "linear" else (float(np.median(np.abs(residuals))) / 0.6745) ** 2
        )
        for n in group:
            factors[n] *= math.sqrt(max(size * share, 1e-12))
    if all(abs(math.log(new / old)) < 0.01 for new, old in zip(factors, problem.factors, strict=True)):
        return None
    return replace(problem, factors=tuple(factors))
