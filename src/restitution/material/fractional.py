"""Fractional models (springpots), exact and as Prony series of verified error within a window of time."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import Annotated, Any, NamedTuple, ParamSpec

import numpy as np
from numpy.typing import ArrayLike

from restitution.checks import Array, items, nonnegative, positive, single, single_nonnegative
from restitution.errors import InputError
from restitution.material import models
from restitution.material.conversion import static_bulk_modulus
from restitution.material.prony import PronySeries, in_range
from restitution.material.viscoelastic import Material, time_window
from restitution.quantities import CONSTANTS, check

_P = ParamSpec("_P")

# ln(eps) = -37: what is smaller than exp(-37) of the whole is left out.
_LN_EPS = 37.0
# Nodes of a tail, and times that share a grid of the Mittag-Leffler function.
_TAIL_NODES, _SHARED = 3, 16
# Step of the logarithm of time between the terms of many models, and how far they reach beyond their window. The
# trapezoidal rule then errs by 3e-9, and the two terms that replace the rest by the square of the margin.
_STEP, _MARGIN = 0.5, 1e3


class Window(NamedTuple):
    """Times within which a Prony series approximates a fractional model."""

    low: float  # shortest time [s]
    high: float  # longest time [s]
    rtol: float = 0.0  # relative error that suffices; 0 for that of the material


class PronyApproximation(NamedTuple):
    """Prony series that approximates another relaxation function within a window of time."""

    series: PronySeries
    error: float  # largest relative error of R(t) and of the complex modulus, t and 1/omega in the window
    window: tuple[float, float]  # shortest and longest time [s]
    loss_error: float  # largest relative error of the loss modulus, which exceeds `error` where the loss is small


@dataclass(frozen=True)
class FractionalModel:
    """Springpot with a spring in series and a spring in parallel: G_inf + G_1 V s^alpha/(G_1 + V s^alpha) at s.

    `springpot`, `fractional_kelvin_voigt`, `fractional_maxwell` and `fractional_zener` are its usual names.

    Parameters
    ----------
    equilibrium_modulus, series_modulus
        G_inf >= 0 [Pa], and G_1 > 0 [Pa], infinite for none.
    coefficient, exponent
        V > 0 [Pa s^alpha] and alpha in [0.01, 0.99]; nearer to 0 or to 1 take a spring or a dashpot.

    Notes
    -----
    Mainardi, *Fractional Calculus and Waves in Linear Viscoelasticity* (2010), ch. 3.

    Examples
    --------
    >>> model = fractional_zener(1e6, 1e9, relaxation_time=1e-3, exponent=0.4)
    >>> model.prony((1e-6, 1e-3), rtol=1e-6).error < 1e-6
    True
    """

    equilibrium_modulus: float
    coefficient: float
    exponent: float
    series_modulus: float = math.inf

    def __post_init__(self) -> None:
        CONSTANTS["exponent"].check(self.exponent)
        in_range("equilibrium_modulus", check("equilibrium_modulus", self.equilibrium_modulus), "Pa")
        in_range("coefficient", positive("coefficient", self.coefficient, "Pa s^exponent"), "Pa s^exponent")
        if self.series_modulus != math.inf:
            in_range("series_modulus", positive("series_modulus", self.series_modulus, "Pa"), "Pa")
            digits = (math.log10(self.coefficient) - math.log10(self.series_modulus)) / self.exponent
            if not abs(digits) <= 100.0:
                raise InputError("relaxation_time", f"1e{digits:.0f}", "must be in [1e-100, 1e+100] s", "s")

    @property
    def relaxation_time(self) -> float:
        """Time tau = (V/G_1)^(1/alpha) [s]; 0 without a spring in series."""
        return (self.coefficient / self.series_modulus) ** (1.0 / self.exponent)

    @property
    def instantaneous_modulus(self) -> float:
        """Glass modulus G_inf + G_1 [Pa], infinite without a spring in series."""
        return self.equilibrium_modulus + self.series_modulus

    def relaxation_modulus(self, time: ArrayLike) -> Any:
        """Return the relaxation modulus G(t) [Pa] at the times t >= 0 [s], any shape.

        G_inf + G_1 E_alpha(-(t/tau)^alpha) with the Mittag-Leffler function to 1e-12, or
        G_inf + V t^-alpha/Gamma(1 - alpha) without a spring in series.

        Examples
        --------
        >>> print(round(fractional_maxwell(1.0, 1.0, 0.5).relaxation_modulus(1.0), 12))
        0.427583576156
        """
        t = np.asarray(nonnegative("time", time, "s"))
        if self.series_modulus == math.inf:
            with np.errstate(divide="ignore", over="ignore"):
                power = t**-self.exponent * (self.coefficient / math.gamma(1.0 - self.exponent))
            return (self.equilibrium_modulus + power)[()]
        branch = _mittag_leffler(np.minimum(t, 1e200) / self.relaxation_time, self.exponent)
        return (self.equilibrium_modulus + self.series_modulus * branch)[()]

    def carson_transform(self, s: ArrayLike) -> Any:
        """Return the Carson transform [Pa] at real or complex s [1/s], any shape; at s = i omega the complex modulus.

        Infinite where the power of a springpot without a spring in series exceeds the largest double.
        """
        spring = self.series_modulus
        with np.errstate(over="ignore", divide="ignore", invalid="ignore"):
            power = self.coefficient * np.asarray(s) ** self.exponent
            if spring == math.inf:
                return (self.equilibrium_modulus + power)[()]
            # Two forms of the same number; each keeps a small loss where the other cancels.
            stiff = np.where(np.isfinite(power), spring / (1.0 + spring / power), spring)
            branch = np.where(np.abs(power) < spring, power / (1.0 + power / spring), stiff)
        return (self.equilibrium_modulus + branch)[()]

    def storage_modulus(self, angular_frequency: ArrayLike) -> Any:
        """Return the storage modulus [Pa] at the angular frequencies omega >= 0 [rad/s], any shape."""
        return self._complex(angular_frequency).real[()]

    def loss_modulus(self, angular_frequency: ArrayLike) -> Any:
        """Return the loss modulus [Pa] at the angular frequencies omega >= 0 [rad/s], any shape."""
        return self._complex(angular_frequency).imag[()]

    def _complex(self, angular_frequency: ArrayLike) -> Any:
        omega = np.asarray(nonnegative("angular_frequency", angular_frequency, "rad/s"))
        return np.asarray(self.carson_transform(1j * omega))

    def prony(self, window: tuple[float, float], rtol: float = 1e-6) -> PronyApproximation:
        """Return a Prony series of prescribed, verified relative error within a window: shortest and longest time [s].

        The spectrum is integrated over the logarithm of time by the trapezoidal rule, and the rule refined until the
        error suffices. A few terms of the same moments replace all that is slower or faster than the window.

        The number `rtol` in [1e-10, 0.1] bounds the error of R(t) relative to R(t), and of the complex modulus
        relative to its magnitude. The error of a small loss modulus may be larger; see `loss_error`.

        Examples
        --------
        >>> springpot(1e6, 0.3).prony((1e-5, 1e-2), rtol=1e-4).series.n_branches < 20
        True
        """
        low, high = (single("window", end, "s") for end in time_window(window))
        for time in (low, high):
            in_range("window", time, "s")
        tolerance = single("rtol", CONSTANTS["approximation_rtol"].check(rtol, "rtol"))
        times = np.geomspace(low, high, 2 + math.ceil(12.0 * math.log10(high / low)))
        relaxation, dynamic = self.relaxation_modulus(times), self.carson_transform(1j / times)
        for coarseness in 1.5 * 0.93 ** np.arange(40):
            series = self._discretised(low, high, tolerance, coarseness)
            carson = series.carson_transform(1j / times)
            pairs = (series.relaxation_modulus(times), relaxation), (carson, dynamic)
            error = max(float(np.abs(series_values / exact - 1.0).max()) for series_values, exact in pairs)
            if error <= tolerance:
                loss_error = float(np.abs(carson.imag / dynamic.imag - 1.0).max())
                return PronyApproximation(series, error, (low, high), loss_error)
        raise InputError("rtol", rtol, "must be larger: no Prony series of this accuracy was found")

    def _discretised(self, low: float, high: float, tolerance: float, coarseness: float) -> PronySeries:
        """Return branches that matter between two times; the step is the safe one of the theory times `coarseness`."""
        alpha, bounded, tau = self.exponent, self.series_modulus < math.inf, self.relaxation_time
        unit = tau if bounded else low
        modulus = self.series_modulus if bounded else self.coefficient * low**-alpha
        digits = math.log(4.0 / tolerance)
        # exp(-lambda t) of a slower term is a polynomial in the window; a faster term has decayed before it.
        first = math.log(tolerance ** (0.5 / _TAIL_NODES) * (unit / high))
        last = math.log(max(digits, 4.0) * (unit / low))
        # A bounded spectrum has its peak at u = 0.
        deepest = (min(first, 0.0) if bounded else first) - _LN_EPS / alpha
        u, steps = _log_grid(alpha, bounded, coarseness * math.pi**2 / digits, deepest, last + _LN_EPS / (1.0 - alpha))
        logs = np.log(steps) + log_spectrum(alpha, bounded, u)
        slow, fast = u < first, u > last
        inside = ~(slow | fast)
        rates, shares = _gauss(np.exp(u[slow] - first), np.exp(logs[slow]))
        # A fast branch acts through its viscosity, so its weight is multiplied by its time.
        times, viscosities = _gauss(np.exp(last - u[fast]), np.exp(logs[fast] + last - u[fast]))
        weights = np.concatenate((viscosities / times, np.exp(logs[inside])[::-1], shares))
        times = np.concatenate((times * math.exp(-last), np.exp(-u[inside])[::-1], math.exp(-first) / rates))
        return PronySeries(self.equilibrium_modulus, modulus * weights, unit * times).simplified()


def fractional_series(models: Sequence[FractionalModel], window: tuple[float, float]) -> PronySeries:
    """Return series of fractional models, good within a window of times [s], on relaxation times of all rows.

    The spectrum is integrated by the trapezoidal rule at fixed times, so that the series are smooth functions of the
    constants. One branch of the same first two moments stands for all that is slower, and one for all that is faster,
    than a thousandth of the window.
    """
    alpha, spring, coefficient, equilibria = np.array(
        [[model.exponent, model.series_modulus, model.coefficient, model.equilibrium_modulus] for model in models],
        dtype=np.float64,
    ).T
    bounded = np.isfinite(spring)
    unit = np.where(bounded, 1.0, window[0])
    scale = coefficient * unit**-alpha
    unit[bounded] = (coefficient / spring)[bounded] ** (1.0 / alpha[bounded])
    scale[bounded] = spring[bounded]
    # The poles of a bounded spectrum near the real axis take smaller steps.
    delta = min((math.pi * (1.0 - a) / a for a in alpha[bounded]), default=math.pi)
    step = _STEP * 0.5 ** max(math.ceil(math.log2(0.5 * math.pi / (1.4 * delta))), 0)
    first, last = math.log(window[0] / _MARGIN), math.log(window[1] * _MARGIN)
    count = math.ceil((last - first) / step)
    before = math.ceil(_LN_EPS / (1.0 - float(alpha.max())) / step)
    after = math.ceil(_LN_EPS / float(alpha.min()) / step)
    places = np.arange(-before, count + after + 1)
    logs = first + step * places
    u: Any = np.log(unit)[:, None] - logs
    spectrum = np.where(bounded[:, None], *(log_spectrum(alpha[:, None], kind, u) for kind in (True, False)))
    weights = np.log(scale * step)[:, None] + spectrum
    inside = (places >= 0) & (places <= count)
    moduli, times = np.exp(weights[:, inside]), np.exp(logs[inside])
    # Moments of viscosity where the time is short, and of the modulus and its rate where it is long.
    fast, slow = logs[places < 0] - first, last - logs[places > count]
    viscosity, square = (np.exp(weights[:, places < 0] + power * fast).sum(axis=1) for power in (1.0, 2.0))
    modulus, rate = (np.exp(weights[:, places > count] + power * slow).sum(axis=1) for power in (0.0, 1.0))
    ends = np.stack([viscosity * (viscosity / square), modulus], axis=1)
    end_times = np.stack([math.exp(first) * square / viscosity, math.exp(last) * modulus / rate], axis=1)
    moduli = np.hstack([ends[:, :1], moduli, ends[:, 1:]])
    times = np.hstack([end_times[:, :1], np.broadcast_to(times, (alpha.size, times.size)), end_times[:, 1:]])
    return PronySeries.from_checked(equilibria, moduli, times)


def log_spectrum(exponent: Any, bounded: bool, log_rates: Array) -> Array:
    """Return the logarithm of the spectrum H, with R(t) = int H exp(-lambda t) dln(lambda), at ln(lambda).

    With x = lambda^alpha the bounded spectrum, H = sin(pi alpha)/pi x/(1 + 2x cos(pi alpha) + x^2), is that of
    E_alpha(-t^alpha) (Mainardi, appendix E), and the other, H = sin(pi alpha)/pi x, of t^-alpha/Gamma(1 - alpha).
    """
    angle = math.pi * exponent
    scale = np.log(np.sin(angle) / math.pi)
    if not bounded:
        return scale + exponent * log_rates
    # H is even in ln(lambda): 1/(4 sinh^2 + 4 cos^2), where nothing cancels as alpha nears 1.
    half = np.abs(0.5 * exponent * log_rates)
    growth = -np.expm1(-2.0 * half)
    return scale - 2.0 * half - np.log(growth * growth + 4.0 * np.cos(0.5 * angle) ** 2 * np.exp(-2.0 * half))


def _log_grid(exponent: float, bounded: bool, step: float, low: float, high: float) -> tuple[Array, Array]:
    """Return nodes u of a trapezoidal rule from u = low to u >= high, and their weights; the error is exp(-pi^2/step).

    H exp(-lambda t) is analytic and bounded for |Im u| < pi/2, save for the poles of the bounded H at
    u = +-i pi (1 - alpha)/alpha = +-i delta. If these are nearer, the rule is in the variable w = u + asinh(u/delta),
    which moves them away from the real axis and costs a few terms close to u = 0.
    """
    delta = math.pi * (1.0 - exponent) / exponent
    moved = bounded and delta < 0.5 * math.pi
    start, end = (u + math.asinh(u / delta) if moved else u for u in (low, high))
    w = start + step * np.arange(max(math.ceil((end - start) / step), 0) + 1, dtype=np.float64)
    if not moved:
        return w, np.full(w.size, step)
    size = np.abs(w)
    u = np.maximum(size - np.arcsinh(size / delta), 0.0)
    for _ in range(60):
        # Concave, so Newton's steps approach from below.
        change = (size - u - np.arcsinh(u / delta)) / (1.0 + 1.0 / np.hypot(u, delta))
        u = u + change
        if np.all(np.abs(change) <= 1e-14 * size):
            break
    return np.copysign(u, w), step / (1.0 + 1.0 / np.hypot(u, delta))


def _mittag_leffler(time: Array, exponent: float) -> Array:
    """Return the Mittag-Leffler function E_alpha(-t^alpha) at t >= 0, by the trapezoidal rule, to 1e-12."""
    times, result, reach = np.ravel(time), np.ones(np.size(time)), _LN_EPS / exponent
    order = np.argsort(times)[np.count_nonzero(times <= 0.0) :]
    # Times that lie close together share a grid.
    for start in range(0, order.size, _SHARED):
        some = order[start : start + _SHARED]
        t = times[some, None]
        top = min(reach, math.log(45.0) - math.log(t[0, 0]))
        low = min(-reach - max(math.log(t[-1, 0]), 0.0), top)
        u, steps = _log_grid(exponent, True, math.pi**2 / _LN_EPS, low, top)
        with np.errstate(over="ignore", under="ignore"):
            result[some] = np.exp(-t * np.exp(u)) @ (steps * np.exp(log_spectrum(exponent, True, u)))
    return result.reshape(np.shape(time))


def _gauss(points: Array, weights: Array) -> tuple[Array, Array]:
    """Return the Gauss rule of a discrete positive measure (Golub and Welsch, Math. Comp. 23 (1969) 221)."""
    keep = weights > weights.max() * 1e-300
    points, weights = points[keep], weights[keep]
    count = min(_TAIL_NODES, points.size)
    powers = np.sqrt(weights / weights.sum())[:, None] * points[:, None] ** np.arange(count + 1)
    triangle: Any = np.linalg.qr(powers, mode="r")
    # Multiplication by the point, in the basis of the orthogonal polynomials.
    jacobi = np.linalg.solve(triangle[:count, :count].T, triangle[:count, 1:].T)
    nodes, vectors = np.linalg.eigh(jacobi)
    return nodes, weights.sum() * vectors[0] ** 2


@dataclass(frozen=True)
class FractionalMaterial:
    """Isotropic material with a fractional model in shear, and perhaps in bulk.

    Parameters
    ----------
    shear
        Model in shear.
    bulk
        Model in bulk, or a series, or a number [Pa]; `math.inf` for incompressible.
    density, name
        Mass density [kg/m^3] and name of the material.
    rtol
        Relative error of its Prony series, in [1e-10, 0.1].

    Notes
    -----
    An impact takes a `Material`, which `within` makes for a window of time; `for_contact` finds that of an impact.

    Examples
    --------
    >>> gel = FractionalMaterial(springpot(1e4, 0.2), bulk=2e9, rtol=1e-5)
    >>> print(gel.within((1e-4, 1e-1)).assumptions)
    20 Prony terms stand for the fractional model, relative error ...e-06
    """

    shear: FractionalModel
    bulk: FractionalModel | PronySeries | float
    density: float | None = None
    name: str | None = None
    rtol: float = 1e-6

    def within(self, window: Window | tuple[float, float]) -> Material:
        """Return the material that holds within a window of time [s]; its `assumptions` contain the error."""
        rule = "must be the shortest and the longest time [s], and perhaps a tolerance"
        ends = items("window", window, rule)
        if len(ends) not in (2, 3):
            raise InputError("window", window, rule)
        low, high, rtol = Window(*ends)
        rtol = single_nonnegative("window[2]", rtol)
        material, error, _ = self.approximation((low, high), max(rtol, self.rtol))
        text = f"{material.shear.n_branches} Prony terms stand for the fractional model, relative error {error:.1e}"
        return replace(material, assumptions=text, derivation="fractional")

    def approximation(self, window: tuple[float, float], rtol: float | None = None) -> tuple[Material, float, float]:
        """Return the material of Prony series, with both errors of a `PronyApproximation` within a window of time [s].

        E* inherits the error: it is homogeneous of degree one in G and K, and grows with both.
        """
        rtol = self.rtol if rtol is None else rtol
        shear = self.shear.prony(window, rtol)
        bulk, error, loss_error = self.bulk, shear.error, shear.loss_error
        if isinstance(bulk, FractionalModel):
            bulk, bulk_error, _, bulk_loss_error = bulk.prony(window, rtol)
            error, loss_error = max(error, bulk_error), max(loss_error, bulk_loss_error)
        material = Material(shear.series, bulk, density=self.density, name=self.name, window=shear.window)
        return material, error, loss_error


def _fractional_model(function: Callable[_P, FractionalModel]) -> Callable[_P, FractionalModel]:
    """Register a function for the relaxation in shear as a material model with an elastic bulk."""
    shear, one_of = models.checked(function, single=True), (models.ONE_BULK,)

    def build(
        *,
        poisson_ratio: models.PoissonRatio | None = None,
        bulk_modulus: models.BulkModulus | None = None,
        approximation_rtol: Annotated[float, CONSTANTS["approximation_rtol"]] = 1e-6,
        density: models.Density | None = None,
        name: str | None = None,
        **constants: Any,
    ) -> FractionalMaterial:
        model: FractionalModel = shear(**constants)  # pyright: ignore[reportCallIssue]
        bulk = static_bulk_modulus(model.equilibrium_modulus, poisson_ratio, bulk_modulus)
        return FractionalMaterial(model, bulk, density, name, approximation_rtol)

    constants = models.constants_of(function) | models.constants_of(build)
    build.__name__ = function.__name__
    models.register(models.checked(build, one_of, single=True), constants, one_of, needs_window=True)
    return shear


@_fractional_model
def springpot(coefficient: models.Coefficient, exponent: models.Exponent) -> FractionalModel:
    """Return the springpot (power law), G(t) = V t^-alpha/Gamma(1 - alpha); V [Pa s^alpha], alpha in [0.01, 0.99].

    Examples
    --------
    >>> print(round(springpot(1.0, 0.5).storage_modulus(4.0), 12))
    1.414213562373
    """
    return FractionalModel(0.0, coefficient, exponent)


@_fractional_model
def fractional_kelvin_voigt(
    equilibrium_modulus: models.EndModulus, coefficient: models.Coefficient, exponent: models.Exponent
) -> FractionalModel:
    """Return the fractional Kelvin-Voigt solid: a spring G_inf [Pa] beside a springpot V [Pa s^alpha].

    Examples
    --------
    >>> print(round(fractional_kelvin_voigt(1.0, 1.0, 0.5).storage_modulus(2.0), 12))
    2.0
    """
    return FractionalModel(equilibrium_modulus, coefficient, exponent)


@_fractional_model
def fractional_maxwell(
    branch_modulus: models.BranchModulus, relaxation_time: models.Time, exponent: models.Exponent
) -> FractionalModel:
    """Return the fractional Maxwell liquid G(t) = G_1 E_alpha(-(t/tau)^alpha); G_1 [Pa], tau [s].

    Examples
    --------
    >>> print(round(fractional_maxwell(2.0, 1.0, 0.5).carson_transform(1.0), 12))
    1.0
    """
    return fractional_zener(0.0, branch_modulus, relaxation_time, exponent)


@_fractional_model
def fractional_zener(
    equilibrium_modulus: models.EndModulus,
    branch_modulus: models.BranchModulus,
    relaxation_time: models.Time,
    exponent: models.Exponent,
) -> FractionalModel:
    """Return the fractional Zener solid G(t) = G_inf + G_1 E_alpha(-(t/tau)^alpha); G_inf, G_1 [Pa], tau [s].

    Examples
    --------
    >>> fractional_zener(1.0, 3.0, 2.0, 0.5).instantaneous_modulus
    4.0
    """
    coefficient = branch_modulus * relaxation_time**exponent
    return FractionalModel(equilibrium_modulus, coefficient, exponent, branch_modulus)
