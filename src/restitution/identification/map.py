"""Maps of indentation curves: the material at many places, from one Levenberg-Marquardt descent for all curves."""

from __future__ import annotations

import math
import sys
import time
import warnings
from collections.abc import Callable, Iterable, Mapping
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from restitution import checks
from restitution.checks import Array, Places, whole
from restitution.errors import InputError, InputTypeError, RestitutionWarning
from restitution.identification.curves import IndentationCurve, curves_block, weights_of, without_baseline
from restitution.identification.fit import Estimation, estimate
from restitution.identification.observations import modulus
from restitution.identification.parameters import MOST_TERMS, OfData, Parameters, parameters, penalties, rows_of
from restitution.identification.uncertainty import FAR, Uncertainty, quantile, settled
from restitution.numerics.differences import CENTRAL, STEP
from restitution.numerics.least_squares import descend
from restitution.parallel import on_threads
from restitution.quantities import MODULUS, VISCOSITY
from restitution.result import Outcome

if TYPE_CHECKING:
    import xarray


# Fits of many indentation curves at once, each with its own material, by Levenberg-Marquardt steps.


_ROUNDS = 60
# A descent ends if the next step would lower chi2 by less than this, a thousandth of a standard error.
_ENOUGH = 1e-6
# Step of differences in the contact point; largest step of a logarithm in a round.
_CONTACT_STEP, _FURTHEST = 1e-2, 2.0
# A coordinate within this distance of a bound counts as at it.
EDGE = 1e-3


class CurveFits(NamedTuple):
    """Fits of s curves."""

    points: Array  # coordinates as in `estimation.EstimationProblem`, shape (s, q)
    errors: Array  # their standard errors
    chi2: Array  # shape (s,); infinite without a fit
    freedom: Array  # points less unknowns, baseline included
    units: Array  # unit of the contact point [m]
    bound: NDArray[np.bool_]  # whether a coordinate is at the end of its range, shape (s, q)
    ended: NDArray[np.bool_]  # whether the descent has converged


class Descent:
    """Curves of one indenter at one temperature, fitted all at once; coordinates as in `EstimationProblem`."""

    def __init__(self, curves: list[IndentationCurve], seed: Estimation, space: Parameters) -> None:
        self.curves, self.seed, self.space = curves, seed, space
        self.block = curves_block(curves)
        self.unit = np.array([curve.nuisances[0].step for curve in curves])
        most = max(curve.size for curve in curves)
        # After the last point of a shorter curve all weights are zero.
        self.measured, self.depths, self.time = np.zeros((3, len(curves), most))
        self.deviations = np.full((len(curves), most), np.inf)
        for n, curve in enumerate(curves):
            part = slice(curve.size)
            self.measured[n, part], self.time[n, part] = curve.force, curve.time - curve.time[0]
            self.deviations[n, part], self.depths[n, part] = curve.deviations, curve.depth_deviations

    def residuals(self, points: Array, places: Places) -> Array:
        """Return residuals of k points of the curves at `places`, shape (s, k, n); NaN where there are none."""
        s, k, q = points.shape
        flat, rows = points.reshape(s * k, q), np.repeat(places, k)
        off = rows_of(lambda part: self.fitted(flat[part], rows[part])[0], s * k).reshape(s, k, -1)
        prior = penalties(self.space, flat[:, :-1]).reshape(s, k, -1)
        return np.concatenate([off, prior], axis=2)

    def fitted(self, points: Array, places: Places) -> tuple[Array, Array]:
        """Return residuals of curves at some places, shape (m, n), and their baselines with slopes, shape (m, 2)."""
        materials = self.space.materials(points[:, :-1], self.seed.problem.window)
        series, touches = modulus(materials, self.curves[0].temperature), points[:, -1] * self.unit[places]
        forces, slopes = self.block.forces(series, touches, places.astype(np.int64))
        beyond = np.isinf(self.deviations[places])
        forces, slopes = np.where(beyond, 0.0, forces), np.where(beyond, 0.0, slopes)
        weights = weights_of(self.deviations[places], slopes, self.depths[places])
        columns = np.stack([weights, self.time[places] * weights], axis=2)
        off, factors = without_baseline((forces - self.measured[places]) * weights, columns)
        return off, -factors

    @property
    def steps(self) -> Array:
        """Steps of differences in the coordinates."""
        return np.append(np.full(len(self.space.free), STEP), _CONTACT_STEP)

    def starts(self) -> tuple[Array, Array, Array]:
        """Start and bounds of each curve: those of the seed, but the moduli times a factor."""
        best, problem = self.seed.fit.coordinates, self.seed.problem
        p, s = len(self.space.free), len(self.curves)
        touch = np.array(
            [[getattr(curve.nuisances[0], key) for key in ("start", "low", "high")] for curve in self.curves]
        )
        points = np.column_stack([np.tile(best[:p], (s, 1)), touch[:, 0] / self.unit])
        everywhere = np.arange(s)
        weights = 1.0 / self.deviations
        columns = np.stack([weights, self.time * weights], axis=2)
        measured = without_baseline(self.measured * weights, columns)[0]
        n_data = measured.shape[1]
        fitted = self.residuals(points[:, None], everywhere)[:, 0, :n_data] + measured
        share, size = np.einsum("sn,sn->s", fitted, measured), np.einsum("sn,sn->s", fitted, fitted)
        with np.errstate(invalid="ignore", divide="ignore"):
            factor = np.log(np.where(share > 0.0, share / size, 1.0))
        moduli = [
            parameter.kind == "log" and not parameter.bounded
            and (parameter.quantity.dimension in (MODULUS, VISCOSITY) or parameter.argument == "coefficient")
            for parameter in self.space.free
        ]  # fmt: skip
        shift = np.nan_to_num(factor)[:, None] * np.array(moduli)
        low = np.column_stack([problem.low[:p] + shift, touch[:, 1] / self.unit])
        high = np.column_stack([problem.high[:p] + shift, touch[:, 2] / self.unit])
        points[:, :p] += shift
        return np.clip(points, low + 1e-9, high - 1e-9), low, high

    def fits(self) -> CurveFits:
        """Fit all curves: Levenberg-Marquardt steps until none would improve a fit."""
        points, low, high = self.starts()
        q, n = points.shape[1], self.measured.shape[1]
        furthest = np.append(np.full(q - 1, _FURTHEST), np.inf)
        points, costs, ended = descend(self.residuals, points, low, high, self.steps, furthest, _ENOUGH / n, _ROUNDS)
        bound = (points - low < EDGE) | (high - points < EDGE)
        freedom = np.maximum(np.array([curve.size for curve in self.curves]) - q - 2, 1)
        return CurveFits(points, self._errors(points, costs / freedom), costs, freedom, self.unit, bound, ended)

    def _errors(self, points: Array, reduced: Array) -> Array:
        """Return standard errors of the coordinates."""
        values = self.residuals(CENTRAL.points(points, self.steps), np.arange(len(points)))
        slopes = np.nan_to_num(CENTRAL.slopes(values.swapaxes(0, 1), self.steps)).swapaxes(0, 1)
        normal = slopes @ slopes.swapaxes(1, 2)
        scale = np.sqrt(np.maximum(np.einsum("sqq->sq", normal), 1e-300))
        relative = normal / (scale[:, :, None] * scale[:, None]) + 1e-14 * np.eye(points.shape[1])
        variance = np.einsum("sqq->sq", np.linalg.inv(relative))
        noise = np.array([curve.scaled for curve in self.curves])
        factor = np.where(noise, reduced, 1.0)
        return np.sqrt(np.maximum(variance, 0.0) * factor[:, None]) / scale


Curves = Iterable[IndentationCurve | Callable[[], IndentationCurve]]

# Curves in a task of a thread: a few tenths of a second.
_CHUNK = 64
# Number of the first curves that are tried as the start of all others.
_SEEDS = 5
# What else a table has of each curve: name, unit, and what it is.
_ABOUT = (
    ("baseline", "N", "force without contact at the first point"),
    ("baseline_slope", "N/s", "slope of the force without contact"),
    ("start_time", "s", "time of the first point of the fit"),
    ("end_time", "s", "time of the last point of the fit"),
    ("points", "", "number of points of the fit"),
    ("indentation_depth", "m", "largest depth below the contact point"),
)
# A curve with this multiple of the median of chi2 is fitted again, from its own starts.
_POOR = 2.0


class MapStatus(Outcome):
    """How the fit of one curve of a map ended."""

    FITTED = 0, "fitted"
    NOT_CONVERGED = 1, "the descent finds no minimum; give start or bounds"
    NO_FIT = 2, "the descent finds no minimum; give start or bounds"
    REFUSED = 3, "the curve is refused"
    NOT_DONE = 4, "interrupted before this curve"


def identify_map(
    curves: Curves,
    model: Any,
    *,
    fixed: Mapping[str, Any] | None = None,
    bounds: Mapping[str, Any] | None = None,
    start: Mapping[str, Any] | None = None,
    prior: Mapping[str, Any] | None = None,
    terms: int = 2,
    shape: tuple[int, ...] | None = None,
    workers: int = 2,
    progress: bool | Callable[[int, int], None] = True,
) -> xarray.Dataset:
    """Return the material at each place of a map of indentation curves.

    Parameters
    ----------
    curves : iterable of IndentationCurve or callable
        Curves, or functions without arguments that return one. A function may raise an error, which does not stop the
        map. All or none of them have adhesion.
    model, fixed, bounds, start, prior, terms
        See `identify`. Each curve has its own unknowns.
    shape : tuple of int, optional
        Shape of the grid of places, whose last dimension runs fastest; one dimension by default.
    workers : int
        Number of threads.
    progress : bool or callable
        Whether to show progress on stderr if it is a terminal; or a function of the number of curves done and of the
        number of all.

    Returns
    -------
    xarray.Dataset
        Each parameter and `contact_point` with their `..._standard_error`, `baseline`, `baseline_slope`, the range of
        the fit (`start_time`, `end_time`, `points`, `indentation_depth`), `chi2`, `reduced_chi2`, `status`
        (`MapStatus`) and `message`, which is never empty. A parameter is NaN if its curve does not determine it, as
        the message says. After Ctrl-C the other curves have the status NOT_DONE.

    Raises
    ------
    InputError
        If an argument is wrong, or none of the first curves can be fitted, or read with adhesion.

    Notes
    -----
    The first curve that can be fitted is the start of all others, with one factor on all moduli. Curves that do not
    determine all parameters, or have twice the stated noise, are fitted again from the best of their neighbours, and
    those that fit much worse than the others as in `identify`. Standard errors are those of the linearised problem.

    Curves with adhesion are fitted one by one as in `identify` with ``profiles=False``, which takes seconds for each.
    Work and stress of the attraction, or its range, are columns then.

    Examples
    --------
    >>> import restitution as rs
    >>> time, rng = np.linspace(0.0, 2.8, 200), np.random.default_rng(1)
    >>> depth, tip = np.interp(time, [0.0, 1.4, 2.8], [0.0, 1.4e-6, 0.0]), rs.Parabola(2.5e-6)
    >>> curves = []
    >>> for equilibrium_modulus in (50.0, 100.0):
    ...     gel = rs.standard_solid(equilibrium_modulus, 270.0, 80.0, poisson_ratio=0.5)
    ...     force = rs.indent(gel, tip, depth=depth - 0.4e-6, time=time).force + rng.normal(0.0, 5e-12, 200)
    ...     curves.append(rs.IndentationCurve(time, depth, force, profile=tip))
    >>> maps = identify_map(curves, rs.standard_solid, fixed={"poisson_ratio": 0.5})
    >>> print(maps["equilibrium_modulus"].values.round(-1))
    [ 50. 100.]
    """
    items = checks.items("curves", curves, "must be curves, or functions that return one")
    grid = (
        [len(items)]
        if shape is None
        else checks.items("shape", shape, "must be the numbers of places along each axis")
    )
    dimensions = tuple(whole("shape", n) for n in grid) if items else ()
    whole("workers", workers)
    if not isinstance(progress, bool):
        checks.function("progress", progress, "must be True, False, or a function of the curves done and of all", 2)
    if not items or math.prod(dimensions) != len(items):
        raise InputError("shape", dimensions, f"must be that of {len(items)} curves")
    space = parameters(
        model, fixed=fixed, bounds=bounds, start=start, prior=prior, shift=None,
        terms=whole("terms", terms, 1, MOST_TERMS), of_data=OfData(adhesion=(adhesive := _adhesive(items))),
    )  # fmt: skip
    table = _Table(space, len(items))
    seed = None if adhesive else _seed(items, space)
    report = _progress(progress, len(items))

    def run(first: int) -> None:
        places, ready = list[int](), list[IndentationCurve]()
        for place in range(first, min(first + chunk, len(items))):
            try:
                ready.append(_curve(items[place], adhesive))
                places.append(place)
            except InputError as error:
                table.refuse(place, str(error))
        if seed is None:
            for place, curve in zip(places, ready, strict=True):
                table.enter(np.array([place]), *_alone(curve, space))
            return
        for alike in _alike(ready):
            group = [ready[n] for n in alike]
            descent = Descent(group, seed, space)
            fits = descent.fits()
            _restart(fits, group, space)
            reasons = _improved(fits, group, space)
            baselines = descent.fitted(fits.points, np.arange(len(group)))[1]
            table.enter(np.array(places)[alike], fits, reasons, group, baselines)

    chunk = 1 if adhesive else _CHUNK
    try:
        on_threads(run, range(0, len(items), chunk), workers, lambda: report(table.done))
    except KeyboardInterrupt:
        text = f"interrupted: {len(items) - table.done} of {len(items)} curves are not done"
        warnings.warn(RestitutionWarning("interrupted", text), stacklevel=2)
    return table.dataset(dimensions)


class _Table:
    """Results of all curves."""

    def __init__(self, space: Parameters, size: int) -> None:
        self._space = space
        self._values, self._errors = np.full((2, size, len(space.free) + 1), np.nan)
        self._chi2, self._reduced = np.full((2, size), np.nan)
        self._about = np.full((len(_ABOUT), size), np.nan)
        self._status = np.full(size, MapStatus.NOT_DONE, dtype=np.int8)
        self._message = np.full(size, MapStatus.NOT_DONE.message, dtype=object)

    @property
    def done(self) -> int:
        """Number of curves that are done."""
        return int(np.sum(self._status != MapStatus.NOT_DONE))

    def refuse(self, place: int, message: str) -> None:
        """Enter a curve that was refused."""
        self._status[place], self._message[place] = MapStatus.REFUSED, message

    def enter(
        self, places: Places, fits: CurveFits, reasons: Mapping[int, str], curves: list[IndentationCurve],
        baselines: Array,
    ) -> None:  # fmt: skip
        """Enter the fits of curves at these places, the reasons why some failed, and their baselines with slopes."""
        fitted = np.isfinite(fits.chi2)
        missing, certain = [[] for _ in curves], _determined(fits)
        status = np.where(fits.ended, MapStatus.FITTED, MapStatus.NOT_CONVERGED)
        for k, parameter in enumerate(self._space.free):
            z, error = fits.points[:, k], fits.errors[:, k]
            determined = certain[:, k]
            for n in np.flatnonzero(~determined):
                missing[n].append(parameter.name)
            self._values[places, k] = np.where(determined, parameter.outward(z), np.nan)
            self._errors[places, k] = np.where(
                determined, parameter.slope(parameter.outward(z)) * error, np.where(fitted, np.inf, np.nan)
            )
        for column, numbers in ((self._values, fits.points), (self._errors, fits.errors)):
            column[places, -1] = np.where(fitted, numbers[:, -1] * fits.units, np.nan)
        self._chi2[places] = np.where(fitted, fits.chi2, np.nan)
        self._reduced[places] = np.where(fitted, fits.chi2 / fits.freedom, np.nan)
        status = np.where(fitted, status, MapStatus.NO_FIT)
        self._status[places] = status
        self._message[places] = [
            reasons.get(n, MapStatus(number).message)
            if number != MapStatus.FITTED
            else f"fitted; the curve does not determine {', '.join(missing[n])}" * bool(missing[n]) or "fitted"
            for n, number in enumerate(status)
        ]
        ends = [(curve.time[0], curve.time[-1], curve.size, curve.tip.max()) for curve in curves]
        start, stop, size, deepest = np.array(ends).T
        deepest = deepest - fits.points[:, -1] * fits.units
        self._about[:, places] = np.where(fitted, [*baselines.T, start, stop, size, deepest], np.nan)

    def dataset(self, shape: tuple[int, ...]) -> xarray.Dataset:
        """Return all results over the grid of places."""
        import xarray as xr

        names = {1: ("curve",), 2: ("y", "x")}.get(len(shape), tuple(f"axis_{n}" for n in range(len(shape))))
        columns: dict[str, Any] = {}
        units = [(parameter.name, parameter.quantity.attributes) for parameter in self._space.free]
        units.append(("contact_point", {"units": "m", "long_name": "depth reading at first touch"}))
        for k, (name, attributes) in enumerate(units):
            words = {"units": attributes["units"], "long_name": f"standard error of the {attributes['long_name']}"}
            columns[name] = self._values[:, k], attributes
            columns[f"{name}_standard_error"] = self._errors[:, k], words
        for (name, unit, words), values in zip(_ABOUT, self._about, strict=True):
            columns[name] = values, {"units": unit, "long_name": words}
        columns["chi2"] = self._chi2, {"units": "", "long_name": "sum of the squares of the residuals"}
        columns["reduced_chi2"] = self._reduced, {"units": "", "long_name": "chi2 over the degrees of freedom"}
        columns["status"] = self._status, {"long_name": "status of the fit", **MapStatus.attributes()}
        columns["message"] = (
            self._message.astype(str),
            {"long_name": "what the curve determines, or why it has no fit"},
        )
        return xr.Dataset({name: (names, data.reshape(shape), about) for name, (data, about) in columns.items()})


def _curve(item: IndentationCurve | Callable[[], IndentationCurve], adhesive: bool | None = None) -> IndentationCurve:
    """Return a curve, with adhesion or without it as those before."""
    curve = item() if callable(item) else item
    if not isinstance(curve, IndentationCurve):
        raise InputTypeError("curves", curve, "must be an IndentationCurve, or a function that returns one")
    if adhesive not in (None, curve.adhesion):
        raise InputError("adhesion", curve.adhesion, f"must be {adhesive} as that of the first curve of the map")
    return curve


def _adhesive(items: list[Any]) -> bool:
    """Return whether the first of the curves that can be read has adhesion."""
    for item in items[:_SEEDS]:
        try:
            return _curve(item).adhesion
        except InputTypeError:
            raise
        except InputError:
            continue
    return False


def _alone(
    curve: IndentationCurve, space: Parameters
) -> tuple[CurveFits, dict[int, str], list[IndentationCurve], Array]:
    """Return the fit of one curve as in `identify`, the reason if there is none, the curve and its baseline."""
    q, unit = len(space.free) + 1, np.array([curve.nuisances[0].step])
    nothing, never = np.full((1, q), np.nan), np.zeros((1, q), dtype=np.bool_)
    freedom = np.array([max(curve.size - q - 2, 1)])
    fits = CurveFits(nothing, nothing.copy(), np.full(1, np.inf), freedom, unit, never, np.zeros(1, dtype=np.bool_))
    try:
        uncertainty, estimates = settled(
            Uncertainty(estimate([curve], space)),
            lambda uncertainty: [uncertainty.estimate(k, profiled=False) for k in range(len(space.free))],
        )
    except InputError as error:
        return fits, {0: str(error)}, [curve], np.full((1, 2), np.nan)
    _replace_fit(fits, 0, uncertainty)
    for k, (parameter, result) in enumerate(zip(space.free, estimates, strict=True)):
        ends = parameter.inward(np.array(result.interval)) if result.determined else np.array([0.0, np.inf])
        fits.errors[0, k] = 0.5 * np.ptp(ends) / uncertainty.quantile()
    problem, here = uncertainty.estimation.problem, uncertainty.estimation.fit.coordinates[None]
    return fits, {}, [curve], curve.baseline_factors(problem.materials(here), problem.nuisances(here)[0])


def _replace_fit(fits: CurveFits, n: int, uncertainty: Uncertainty) -> None:
    """Replace the fit of a curve in the table."""
    problem, fit = uncertainty.estimation.problem, uncertainty.estimation.fit
    z = fit.coordinates
    fits.points[n], fits.errors[n] = z, uncertainty.standard_errors
    fits.chi2[n] = fit.cost * problem.factors[0] ** 2
    fits.bound[n] = (z - problem.low < EDGE) | (problem.high - z < EDGE)
    fits.ended[n] = True


def _seed(items: list[Any], space: Parameters) -> Estimation:
    """Fit of the first of the curves that can be fitted."""
    for n, item in enumerate(items):
        try:
            return estimate([_curve(item)], space)
        except InputTypeError:
            raise
        except InputError:
            if n + 1 >= min(_SEEDS, len(items)):
                raise
    raise AssertionError


def _alike(curves: list[IndentationCurve]) -> list[list[int]]:
    """Return indices of the curves, in groups of the same indenter and temperature."""
    groups: list[list[int]] = []
    for n, curve in enumerate(curves):
        for group in groups:
            first = curves[group[0]]
            if (
                first.profile is curve.profile or first.profile == curve.profile
            ) and first.temperature == curve.temperature:
                group.append(n)
                break
        else:
            groups.append([n])
    return groups


def _restart(fits: CurveFits, curves: list[IndentationCurve], space: Parameters) -> None:
    """Fit doubtful curves again, from a better start than the first curve, which may be one that determines little.

    The start is the own fit of the curve that determines all parameters best, or else of that with the least noise.
    """
    p = len(space.free)
    stated = np.array([not curve.scaled for curve in curves])
    clear = fits.ended & _determined(fits)[:, :p].all(axis=1) & ~(stated & (fits.chi2 > _POOR * fits.freedom))
    if clear.all():
        return
    noise = np.array([float(np.mean(curve.deviations)) / float(np.ptp(curve.force)) for curve in curves])
    best = np.argmin(np.where(clear, fits.errors[:, :p].max(axis=1), np.inf)) if clear.any() else np.argmin(noise)
    places = np.flatnonzero(~clear)
    try:
        seed = estimate([curves[int(best)]], space)
    except InputError:
        return
    again = Descent([curves[n] for n in places], seed, space).fits()
    better = again.chi2 < fits.chi2[places]
    for old, new in zip(fits, again, strict=True):
        old[places[better]] = new[better]


def _determined(fits: CurveFits) -> NDArray[np.bool_]:
    """Return whether curves determine their coordinates, shape (s, q)."""
    return np.isfinite(fits.chi2)[:, None] & (quantile(0.95) * fits.errors < FAR) & ~fits.bound


def _improved(fits: CurveFits, curves: list[IndentationCurve], space: Parameters) -> dict[int, str]:
    """Fit curves whose chi2 is far above that of the others again, from their own starts; the reasons of failures."""
    reasons: dict[int, str] = {}
    reduced = fits.chi2 / fits.freedom
    usual = np.median(reduced[np.isfinite(reduced)]) if np.isfinite(reduced).any() else 0.0
    for n in np.flatnonzero(~fits.ended | ~(reduced < _POOR * usual)):
        try:
            uncertainty = Uncertainty(estimate([curves[n]], space))
        except InputError as error:
            reasons[int(n)] = str(error)
            continue
        problem, fit = uncertainty.estimation.problem, uncertainty.estimation.fit
        if fit.cost * problem.factors[0] ** 2 < fits.chi2[n] or not fits.ended[n]:
            _replace_fit(fits, int(n), uncertainty)
    return reasons


def _progress(progress: bool | Callable[[int, int], None], total: int) -> Callable[[int], None]:
    """Return the function that shows the number of curves done."""
    if callable(progress):
        return lambda done: progress(done, total)
    if not progress or not sys.stderr.isatty():
        return lambda done: None
    begin = time.monotonic()

    def show(done: int) -> None:
        left = (time.monotonic() - begin) * (total - done) / max(done, 1)
        end = "\n" if done == total else ""
        sys.stderr.write(f"\r{done} of {total} curves, {left:.0f} s left \033[K{end}")
        sys.stderr.flush()

    return show
