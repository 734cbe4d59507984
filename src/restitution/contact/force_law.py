"""Force law: a geometry given by its elastic force over the depth, computed or measured."""

from __future__ import annotations

import math
import warnings
from collections.abc import Iterator
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING, Annotated, Any, NamedTuple, Self

import numpy as np
from numpy.polynomial import chebyshev
from numpy.typing import ArrayLike

from restitution.checks import Array, finite, refuse, single, within
from restitution.contact.geometry import Geometry, as_array
from restitution.errors import InputError, RestitutionWarning
from restitution.material.viscoelastic import poisson_ratio_range
from restitution.quantities import CONSTANTS, FORCE, INPUTS, LENGTH, NUMBER, Quantity
from restitution.result import draw

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from restitution.material.viscoelastic import Material


# Smooth fit of an elastic force over the depth: Chebyshev polynomials of F/d^p in sqrt(d).


# Exponents of flat-ended, round and sharp bodies, whose force is a series in sqrt(d); others are fitted.
_EXPONENTS = (1.0, 1.5, 2.0)
_LOW, _HIGH = 1.0, 4.0
# Largest degree, least number of rows for each coefficient, and largest degree beside a fitted exponent.
_MOST_DEGREE, _ROWS, _FREE_DEGREE = 24, 4, 3
# Fits whose rank differs by less from the best are nearly as likely; at most so many count.
_NEARLY, _RIVALS = 6.0, 5
# Rounding of forces over the largest; smaller residuals are no reason for another degree.
_ROUNDING = 1e-14
# Gain in twice the log-likelihood that a further coefficient must bring.
_PENALTY = 3.0
# Smallest force over the largest that has a relative error: below it the error is constant.
_LEAST_FORCE = 1e-3
# Places at which the fitted stiffness is checked, and the standard errors within which it may fall.
_PLACES, _SIGMAS, _LEVEL, _MOST_FALL = 400, 3.0, 1e-3, 0.01
# Misfit of a fit that rises over that of the likeliest one, and a misfit that does not matter.
_SLACK, _SMOOTHING = 3.0, 1e-4


@dataclass(frozen=True, eq=False)
class ForceFit:
    """Force ``F = F_1 x^(2p) sum_j c_j T_j(2x - 1)``, ``x = sqrt(d/d_1)``, largest depth d_1, force F_1 there.

    Attributes
    ----------
    depth_unit, force_unit : float
        d_1 [m] and F_1 [N].
    exponent : float
        Exponent p of the force at small depth.
    coefficients : array
        Chebyshev coefficients c_j, lowest first.
    residual : array
        Measured minus fitted force of each row over F_1, in the order of the rows.
    covariance : array
        Covariance of the coefficients, then of the exponent if it was fitted, from the residuals (HC3), without any
        assumption about how the noise depends on the depth.
    spread : float
        Largest difference of the force over F_1, at any depth, from other fits that are nearly as likely.
    """

    depth_unit: float
    force_unit: float
    exponent: float
    coefficients: Array
    residual: Array
    covariance: Array
    spread: float = 0.0

    @property
    def degree(self) -> int:
        """Degree of the polynomial."""
        return self.coefficients.size - 1

    @property
    def misfit(self) -> float:
        """Root mean square of the residuals."""
        return float(np.sqrt(np.mean(self.residual**2)))

    @property
    def error(self) -> float:
        """Standard error of the fitted force over F_1, the largest at any depth, with the spread."""
        x = _places()
        return math.hypot(np.max(self._deviation(_force_columns(x, self.exponent, self.degree), x)), self.spread)

    def force(self, x: Array) -> Array:
        """Return the force over F_1 at x."""
        return x ** (2.0 * self.exponent) * chebyshev.chebval(2.0 * x - 1.0, self.coefficients)

    def stiffness(self, x: Array) -> Array:
        """Return the stiffness dF/dd over F_1/d_1 at x."""
        series = chebyshev.chebval(2.0 * x - 1.0, self.coefficients)
        slope = chebyshev.chebval(2.0 * x - 1.0, chebyshev.chebder(self.coefficients))
        return x ** (2.0 * self.exponent - 2.0) * (self.exponent * series + x * slope)

    def falls_at(self) -> float | None:
        """Place x where the stiffness falls most, by more than its error, or is negative; None if it rises."""
        x = _places()
        stiffness = self.stiffness(x)
        columns = np.stack([self._unit(j).stiffness(x) for j in range(self.degree + 1)], axis=1)
        largest = float(stiffness.max())
        allowed = np.minimum(_SIGMAS * self._deviation(columns, x), _MOST_FALL * largest) + _LEVEL * largest
        excess = np.maximum.accumulate(np.maximum(stiffness, 0.0)) - stiffness - allowed
        return float(x[np.argmax(excess)]) if np.any((excess > 0.0) | (stiffness <= 0.0)) else None

    def _unit(self, j: int) -> ForceFit:
        unit = np.zeros(j + 1)
        unit[j] = 1.0
        return ForceFit(1.0, 1.0, self.exponent, unit, self.residual, self.covariance)

    def _deviation(self, columns: Array, x: Array) -> Array:
        """Return the standard deviation of a linear function of the coefficients, given by its columns."""
        if len(self.covariance) > columns.shape[1]:
            # The derivative with respect to the exponent, to leading order for the stiffness.
            free = columns @ self.coefficients * 2.0 * np.log(x)
            columns = np.column_stack([columns, free])
        return np.sqrt(np.maximum(np.einsum("ij,jk,ik->i", columns, self.covariance, columns), 0.0))


class _Trial(NamedTuple):
    """A fit before it is chosen: minus twice its log-likelihood by cross-validation, and what defines it."""

    score: float
    size: int
    exponent: float
    degree: int
    weights: Array
    free: bool


def fit_force(depth: Array, force: Array, exponent: float | None = None) -> ForceFit:
    """Fit the force of rows in any order, whose largest depth has a positive force.

    Parameters
    ----------
    depth, force : array, shape (n,)
        Depths [m] > 0 and forces [N], n >= 10.
    exponent : float, optional
        Exponent p; found from the data if left out.

    Notes
    -----
    The exponent (1, 1.5, 2 or fitted), the degree, and whether the noise is constant or proportional to the force,
    have the largest likelihood of rows that are left out one by one; a simpler fit of nearly the same likelihood is
    preferred. Where the stiffness of the likeliest fit falls, the likeliest one that rises replaces it if it is nearly
    as close to the data.
    """
    deepest = int(np.argmax(depth))
    unit, scale = float(depth[deepest]), float(force[deepest])
    x, y = np.sqrt(depth / unit), force / scale

    def rank(trial: _Trial) -> float:
        return trial.score + _PENALTY * trial.size

    trials = sorted(_trials(x, y, exponent), key=rank)
    fits = (_solved(x, y, trial, unit, scale) for trial in trials)
    first = chosen = next(fits)
    if first.falls_at() is not None:
        rising = next((fit for fit in fits if fit.falls_at() is None), first)
        chosen = rising if rising.misfit <= max(_SLACK * first.misfit, _SMOOTHING) else first
    near = [trial for trial in trials[:_RIVALS] if rank(trial) <= rank(trials[0]) + _NEARLY]
    rivals = [_solved(x, y, trial, unit, scale) for trial in near]
    places = _places()
    spread = max(float(np.max(np.abs(chosen.force(places) - rival.force(places)))) for rival in rivals)
    return replace(chosen, spread=spread)


def _places() -> Array:
    return np.linspace(0.0, 1.0, _PLACES + 1)[1:]


def _trials(x: Array, y: Array, exponent: float | None) -> Iterator[_Trial]:
    most = max(min(_MOST_DEGREE, x.size // _ROWS - 1), 0)
    for weights in (np.ones(x.size), 1.0 / np.maximum(np.abs(y), _LEAST_FORCE)):
        for p in _EXPONENTS if exponent is None else (exponent,):
            q, _ = np.linalg.qr(weights[:, None] * _force_columns(x, p, most))
            parts = q * (q.T @ (weights * y))
            residual = (weights * y)[:, None] - np.cumsum(parts, axis=1)
            leverage = np.cumsum(q * q, axis=1)
            for degree in range(most + 1):
                score = _score(residual[:, degree], leverage[:, degree], weights)
                yield _Trial(score, degree + 1, p, degree, weights, False)
        if exponent is None:
            for degree in range(min(_FREE_DEGREE, most) + 1):
                p = _fitted_exponent(x, y, weights, degree)
                if _LOW < p < _HIGH:
                    residual, leverage = _residual(x, y, weights, p, degree, free=True)
                    yield _Trial(_score(residual, leverage, weights), degree + 2, p, degree, weights, True)


def _score(residual: Array, leverage: Array, weights: Array) -> float:
    """Return minus twice the log-likelihood of rows that are left out one by one."""
    left_out = np.mean((residual / np.maximum(1.0 - leverage, 1e-3)) ** 2)
    return residual.size * math.log(max(left_out, _ROUNDING**2)) - 2.0 * float(np.sum(np.log(weights)))


def _force_columns(x: Array, exponent: float, degree: int) -> Array:
    return x[:, None] ** (2.0 * exponent) * chebyshev.chebvander(2.0 * x - 1.0, degree)


def _with_exponent(x: Array, y: Array, weights: Array, exponent: float, degree: int) -> tuple[Array, Array, Array]:
    """Return weighted columns, the derivative with respect to the exponent as the last, coefficients, residuals."""
    columns = weights[:, None] * _force_columns(x, exponent, degree)
    coefficients = np.linalg.lstsq(columns, weights * y, rcond=None)[0]
    fitted = columns @ coefficients
    residual: Array = weights * y - fitted
    return np.column_stack([columns, 2.0 * np.log(x) * fitted]), np.asarray(coefficients, np.float64), residual


def _fitted_exponent(x: Array, y: Array, weights: Array, degree: int) -> float:
    """Return the exponent of the least squares, by Gauss-Newton; NaN where it does not converge."""
    p, step = 1.5, math.inf
    for _ in range(50):
        columns, _, residual = _with_exponent(x, y, weights, p, degree)
        step = float(np.linalg.lstsq(columns, residual, rcond=None)[0][-1])
        p = min(max(p + step, 0.5 * _LOW), 2.0 * _HIGH)
        if abs(step) < 1e-13:
            return p
    return p if abs(step) < 1e-6 else math.nan


def _residual(x: Array, y: Array, weights: Array, p: float, degree: int, *, free: bool) -> tuple[Array, Array]:
    columns, _, residual = _with_exponent(x, y, weights, p, degree)
    q, _ = np.linalg.qr(columns if free else columns[:, :-1])
    return residual, np.sum(q * q, axis=1)


def _solved(x: Array, y: Array, trial: _Trial, unit: float, scale: float) -> ForceFit:
    columns, coefficients, residual = _with_exponent(x, y, trial.weights, trial.exponent, trial.degree)
    if not trial.free:
        columns = columns[:, :-1]
    inverse = np.linalg.pinv(columns)
    leverage = np.einsum("ij,ji->i", columns, inverse)
    spread = inverse * (residual / np.maximum(1.0 - leverage, 1e-3))
    return ForceFit(unit, scale, trial.exponent, coefficients, residual / trial.weights, spread @ spread.T)


# Force law: a geometry given by its elastic force over the depth, computed or measured.

_EXPONENT = Quantity("exponent", NUMBER, "exponent of the force at small depth", "$p$", 1.0, 10.0)
_FEWEST = 10
# The least depth over the largest: below the least one the fit extrapolates.
_FIRST = 0.25
# A force of any depth over that of the largest depth.
_MOST_FORCE = 2.0
# Force at no depth, and misfit, over the largest force; residuals of outliers over their median.
_MOST_OFFSET, _MOST_MISFIT, _OUTLIER = 0.01, 0.01, 20.0
# Limits of the depth over the stiffness radius, beyond which a unit is wrong.
_SHALLOW, _DEEP = 1e-9, 30.0
# Difference of Poisson ratios that does not matter.
_SAME_RATIO = 0.005


@dataclass(frozen=True, eq=False)
class ForceLaw(Geometry, case_name="force_law"):
    """Elastic force over depth, from finite elements, boundary elements or a measurement on an elastic twin.

    The twin has the shape and the fixings of the real body and target, and is elastic. Any body on any target has such
    a law: a disc of finite width, a body with an edge, a layer on a layer of the same material.

    Parameters
    ----------
    depth : array
        Depths d [m] from first touch, >= 0, in any order, shape (n,) with n >= 10. The least is at most a quarter of
        the largest.
    force : array
        Forces F [N] of the twin at these depths, shape (n,).
    modulus : float
        Young's modulus E [Pa] of the twin, > 0.
    poisson_ratio : float
        Poisson ratio of the twin, in (-1, 0.5]: that of the real material.
    exponent : float, optional
        Exponent p of the force at small depth, ``F ~ d^p``, >= 1: 1 for a flat face, 1.5 for a round and 2 for a sharp
        tip. It is found from the data if left out.

    Attributes
    ----------
    fit : ForceFit
        The fit, with its `exponent`, `degree`, `residual`, `misfit` and `error`, the standard error of the force.

    Raises
    ------
    InputError
        If a value is not a finite number, the columns differ in length, few rows are given or a gap is large, the
        stiffness of the fit is not positive or falls, the data are too noisy, or a unit is likely to be wrong.

    Notes
    -----
    The stiffness radius ``a = (dF/dd)/(2 E*)`` with ``E* = E/(1 - nu^2)`` is the derivative of a smooth fit: Chebyshev
    polynomials of ``F/d^p`` in sqrt(d), whose degree follows from cross-validation. The impact of one viscoelastic
    body follows exactly if its contact area grows with the depth and its Poisson ratio is constant in time and that of
    the twin; on a half-space and on a layer with a frictionless base the Poisson ratio does not matter. Another one is
    a warning. The contact radius and the pressure are not known. An impact deeper than the data is refused; one of
    several ends with `Status.TOO_DEEP`.

    Examples
    --------
    >>> import numpy as np
    >>> d = np.linspace(1e-5, 1e-3, 40)
    >>> law = ForceLaw(d, 4 / 3 * 1e6 / 0.75 * np.sqrt(0.01) * d**1.5, modulus=1e6, poisson_ratio=0.5)
    >>> print(law.fit.exponent, law.fit.degree, float(law.stiffness_radius(1e-4).round(9)))
    1.5 0 0.001
    """

    end = "where the data end"
    obstacle = "the contact area of a force law is not known"

    depth: Annotated[Array, Quantity("depth", LENGTH, "depths of an elastic twin", "$d$", 0.0)]
    force: Annotated[Array, Quantity("force", FORCE, "elastic forces at the depths", "$F$")]
    modulus: Annotated[float, CONSTANTS["youngs_modulus"]]
    poisson_ratio: Annotated[float, INPUTS["poisson_ratio"]]
    exponent: Annotated[float | None, _EXPONENT] = None
    fit: ForceFit = field(init=False, repr=False, compare=False)

    def __post_init__(self) -> None:
        depth, force = _columns(self.depth, self.force)
        modulus = single("modulus", CONSTANTS["youngs_modulus"].check(self.modulus, "modulus"), "Pa")
        within("modulus", modulus, 1e-100, 1e100, "Pa")  # its quotients with forces do not overflow
        ratio = single("poisson_ratio", INPUTS["poisson_ratio"].check(self.poisson_ratio))
        if ratio == -1.0:
            raise InputError("poisson_ratio", ratio, "must be in (-1, 0.5]")
        columns = {"depth": depth, "force": force, "modulus": modulus, "poisson_ratio": ratio}
        for name, value in columns.items():
            object.__setattr__(self, name, value)
        if self.exponent is not None:
            object.__setattr__(self, "exponent", single("exponent", _EXPONENT.check(self.exponent)))
        rows = np.flatnonzero(depth > 0.0)
        fit = fit_force(depth[rows], force[rows], self.exponent)
        object.__setattr__(self, "fit", fit)
        _check_fit(fit, depth, force, rows)
        shape = fit.depth_unit / float(self.stiffness_radius(fit.depth_unit))
        if not _SHALLOW < shape < _DEEP:
            rule = "is the depth over the stiffness radius F'/(2 E*): compare the units of depth, force and modulus"
            raise InputError("depth, force, modulus", shape, rule)

    def between(self, material: Material, counter_material: Material | None) -> Self:
        """Return the law itself; refuse a second body that deforms, and warn of another Poisson ratio."""
        if counter_material is not None:
            raise InputError("counter_material", rule="must be left out: a force law is that of one deformable body")
        ends = material.poisson_ratio, material.instantaneous_poisson_ratio, *poisson_ratio_range(material)
        ratios = np.stack([np.broadcast_to(end, material.shape) for end in ends]).reshape(4, -1)
        # The material that differs most counts.
        ratios = ratios[:, np.argmax(np.max(np.abs(ratios - self.poisson_ratio), axis=0))]
        if np.max(np.abs(ratios - self.poisson_ratio)) > _SAME_RATIO:
            text = f"force law: the Poisson ratio is {self.poisson_ratio:.4g} for the twin and {ratios[0]:.4g} "
            text += f"(static) to {ratios[1]:.4g} (instantaneous) for the material"
            if ratios[2] < min(ratios[:2]) - _SAME_RATIO or ratios[3] > max(ratios[:2]) + _SAME_RATIO:
                text += f", {ratios[2]:.4g} to {ratios[3]:.4g} between"
            text += "; exact on a half-space or a "
            text += "frictionless layer alone"
            warnings.warn(RestitutionWarning("force_law", text), stacklevel=2)
        return self

    @property
    def reduced_modulus(self) -> float:
        """Reduced modulus E* = E/(1 - nu^2) [Pa] of the twin."""
        return self.modulus / (1.0 - self.poisson_ratio**2)

    @property
    def max_depth(self) -> float:
        """Largest depth [m] of the data."""
        return self.fit.depth_unit

    def stiffness_radius(self, depth: ArrayLike) -> Array:
        """Return the stiffness radius (dF/dd)/(2 E*) [m] of the fit; 0 where d < 0."""
        depth, unit = as_array(depth), self.fit.force_unit / self.fit.depth_unit / (2.0 * self.reduced_modulus)
        return np.where(depth >= 0.0, unit * self.fit.stiffness(self._place(depth)), 0.0)[()]

    def force_integral_at_depth(self, depth: ArrayLike) -> Array:
        """Return the force integral F/(2 E*) [m^2] of the fit."""
        return self.fit.force_unit / (2.0 * self.reduced_modulus) * self.fit.force(self._place(as_array(depth)))

    def contact_radius(self, depth: ArrayLike) -> Array:
        """Return NaN: the contact radius is not known."""
        return np.full_like(as_array(depth), np.nan)[()]

    def plot(self) -> Figure:
        """Return a picture of the forces with their fit, and of the residuals."""
        return draw("force_law.force_law", self)

    def _place(self, depth: Array) -> Array:
        """Return sqrt(d/d_1) for depths that the data cover."""
        if np.any(depth > self.max_depth):
            rule = f"must be <= {self.max_depth:g} m, {self.end}"
            raise InputError("depth", float(np.max(depth)), rule, "m")
        return np.sqrt(np.maximum(depth, 0.0) / self.max_depth)


def _columns(depth: Any, force: Any) -> tuple[Array, Array]:
    """Return checked columns of depths and forces, in the order of the rows."""
    d, f = np.asarray(finite("depth", depth, "m")), np.asarray(finite("force", force, "N"))
    if d.ndim != 1 or d.shape != f.shape:
        raise InputError("depth, force", rule=f"have shapes {d.shape}, {f.shape}: must be two columns of equal length")
    refuse("depth", d, d < 0.0, "must be >= 0: depths count from first touch", "m")
    distinct = np.unique(d[d > 0.0]).size
    if distinct < _FEWEST:
        raise InputError("depth", rule=f"has {distinct} different depths > 0: must be at least {_FEWEST}")
    for name, values, unit in (("depth", d, "m"), ("force", f, "N")):
        size = float(np.max(np.abs(values)))
        if not 1e-100 <= size <= 1e100:
            raise InputError(name, size, f"is the largest: must be in [1e-100, 1e+100] {unit}", unit)
    deepest = int(np.argmax(d))
    most = float(f[deepest])
    at_end = np.arange(d.size) == deepest
    refuse("force", f, at_end & (f <= 0.0), "must be > 0 in indentation; a compression counts positive", "N")
    rule = f"is beyond the force at the largest depth, {most:g} N: an elastic force rises with the depth"
    refuse("force", f, np.abs(f) > _MOST_FORCE * most, rule, "N")
    first = float(d[d > 0.0].min())
    if first > _FIRST * d[deepest]:
        rule = f"is the least of the depths: must be at most {_FIRST:g} times the largest, {d[deepest]:g} m"
        raise InputError("depth", first, rule, "m")
    refuse("force", f, (d == 0.0) & (np.abs(f) > _MOST_OFFSET * most), "must be 0 at depth 0", "N")
    return d, f


def _check_fit(fit: ForceFit, depth: Array, force: Array, rows: Any) -> None:
    """Refuse data whose fit is no contact, at the row where this shows."""
    size = np.abs(fit.residual)
    worst = int(np.argmax(size))
    row = int(rows[worst])
    if fit.misfit > _MOST_MISFIT or size[worst] > max(_MOST_MISFIT, _OUTLIER * float(np.median(size))):
        place = f"at depth {depth[row]:g} m is {100.0 * size[worst]:.2g} % of the largest force off a smooth curve"
        rule = f"{place}, all rows by {100.0 * fit.misfit:.2g} %: must be smooth; correct or leave out such rows"
        raise InputError("force", float(force[row]), rule, "N", index=(row,))
    falls = fit.falls_at()
    if falls is not None:
        place = falls**2 * fit.depth_unit
        row = int(rows[np.argmin(np.abs(depth[rows] - place))])
        rule = f"the stiffness dF/dd must be positive and never fall, and does not near depth {place:.3g} m; "
        rule += "smooth the data, leave out what is not elastic, and count depths from first touch"
        raise InputError("force", float(force[row]), rule, "N", index=(row,))
