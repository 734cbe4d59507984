"""Solution of one impact by SciPy's `solve_ivp`, to check the compiled kernel, with which it shares no code.

One approach (Lee and Radok 1960) and one rebound (Graham 1967, Ting 1966) on a foundation whose reduced relaxation
modulus is a Prony series, both as ordinary differential equations along a path on which they are smooth.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from types import SimpleNamespace
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.integrate import solve_ivp
from scipy.optimize import minimize_scalar

from restitution import Impact, SolverError, Status
from restitution.contact.profiles import Profile
from restitution.contact.table import evaluate
from restitution.impact.batch import Batch
from restitution.impact.scaling import ScaledImpact
from restitution.impact.solution import SampledSolution
from restitution.kernel.outcome import LEAST_RESTITUTION

Array = NDArray[np.float64]
# A solve takes some 1e4 evaluations at rtol = 1e-11; this many are half a minute.
_MAX_EVALUATIONS = 1_000_000


def solve_by_scipy(impact: Impact, rtol: float = 1e-9) -> SampledSolution:
    """Solve one impact, without the table of its geometry; results in SI units."""
    row, profile = Batch.from_impact(impact).scaled().row(0), impact.profile

    def radius(s: Any) -> Any:
        return profile.stiffness_radius(np.asarray(s) ** 2 * row.length) / row.radius

    def edge(s: Any) -> Any:
        return profile.contact_radius(np.asarray(s) ** 2 * row.length) / row.radius

    solution = solve_scaled_by_scipy(
        row, rtol=rtol, stiffness_radius=None if row.table is None else radius,
        contact_radius=None if isinstance(profile, Profile) else edge,
    )  # fmt: skip
    velocity = float(impact.velocity)
    force = float(impact.mass) * velocity / row.time
    return solution._replace(
        time=solution.time * row.time,
        indentation_depth=solution.indentation_depth * row.length,
        indentation_velocity=solution.indentation_velocity * velocity,
        force=solution.force * force,
        contact_radius=solution.contact_radius * row.radius,
        contact_time=solution.contact_time * row.time,
        max_indentation_depth=solution.max_indentation_depth * row.length,
        max_force=solution.max_force * force,
        max_contact_radius=solution.max_contact_radius * row.radius,
        residual_indentation_depth=solution.residual_indentation_depth * row.length,
    )


def scaled(
    equilibrium: float = 0.0, moduli=(), times=(), *, viscosity=0.0, external_force=0.0, exponent=1.0, table=None
) -> SimpleNamespace:
    """A scaled impact: m = v0 = 1, and the constants of the force as given (2 E* in the closed forms' notation)."""
    return SimpleNamespace(
        equilibrium=equilibrium, moduli=np.array(moduli, float), times=np.array(times, float),
        viscosity=viscosity, external_force=external_force, exponent=exponent, table=table,
    )  # fmt: skip


def standard_solid(nu: float, p2: float, p3: float, **options) -> SimpleNamespace:
    """The paper's material with m = R = v0 = Ginf = 1, as a two-term series of E*."""
    g1, tau = 1.0 / p2, p2 * p3
    if nu == 0.5:
        return scaled(8.0, [8.0 * g1], [tau], **options)
    k = 2.0 * (1.0 + nu) / (3.0 * (1.0 - 2.0 * nu))
    soft, stiff = 3.0 * k + 4.0, 3.0 * k + 4.0 * (1.0 + g1)
    second = 27.0 * k**2 / 4.0 * (1.0 / soft - 1.0 / stiff)
    return scaled(4.0 / (1.0 - nu), [2.0 * g1, 2.0 * second], [tau, tau * stiff / soft], **options)


def solve_scaled_by_scipy(
    problem: ScaledImpact | SimpleNamespace,
    *,
    rtol: float = 1e-9,
    stiffness_radius: Callable[[Any], Any] | None = None,
    contact_radius: Callable[[Any], Any] | None = None,
) -> SampledSolution:
    """Solve approach and rebound of one impact by an implicit Runge-Kutta method of order 5 (Radau IIA).

    Parameters
    ----------
    problem : ScaledImpact
        The impact without units: force `F = E_inf Pi + viscosity a v + sum E_k Y_k`, stiffness radius `a(s)` at the
        depth `d = s^2`, motion `v' = -(F - external_force)`, `v(0) = 1`.
    rtol : float
        The error of e stays below `rtol max(e, 1e-3)`; in [1e-12, 1e-2].
    stiffness_radius : callable, optional
        Scaled stiffness radius a(s), s >= 0, instead of the one in `problem`, to bypass the table of a geometry.
    contact_radius : callable, optional
        Scaled contact radius over s >= 0 of the result, where it is not the stiffness radius.

    Returns
    -------
    SampledSolution
        A body that would leave a liquid with less than a millionth of its velocity counts as sinking in.

    Raises
    ------
    SolverError
        If the integration fails or needs more than a million evaluations.

    Notes
    -----
    The page Impact of the theory derives the equations, in sigma with `dt = 2 s dsigma` for the approach and in lambda
    for the rebound (index 1: the approach at `sigma_m - lambda`, `X_k = exp(-(t - t1)/tau_k)`)::

        dt/dlambda = -2 s1 v1 phi/q      phi = E_inf + sum E_k X_k      F = E_inf Pi1 + sum E_k X_k Y1_k
        q = E_inf v + viscosity dv/dt + sum E_k [W_k + X_k (v1 - W1_k)]

    A constant force may move the edge of contact outwards again before the body separates (`q` vanishes). This second
    loading is outside the theory, and the status is CAPTURED. Where that can happen, the end of the rebound is
    integrated along `lambda + int dt/(2 s1)`, on which it is regular.

    Sources: E. H. Lee and J. R. M. Radok, J. Appl. Mech. 27 (1960) 438; T. C. T. Ting, J. Appl. Mech. 33
    (1966) 845; G. A. C. Graham, Int. J. Eng. Sci. 5 (1967) 495.
    """
    return _Equations(problem, rtol, stiffness_radius or _stiffness_radius(problem), contact_radius).solve()


def _stiffness_radius(scaled: ScaledImpact) -> Callable[[Any], Any]:
    """Return the stiffness radius a(s) over the square root of the depth."""
    if scaled.table is None:
        return lambda s: s**scaled.exponent
    table = scaled.table
    return lambda s: evaluate(table, s)[0]


class _Equations:
    """States y = (s, t, v, Pi, Y_k, W_k) of the approach and z = (t, v, d, W_k) of the rebound."""

    def __init__(
        self, scaled: ScaledImpact, rtol: float, radius: Callable[[Any], Any], edge: Callable[[Any], Any] | None
    ) -> None:
        self.equilibrium, self.viscosity = scaled.equilibrium, scaled.viscosity
        self.external_force = scaled.external_force
        self.moduli, self.times = scaled.moduli, scaled.times
        # Inner stages of the integrator may try s < 0.
        self.radius = lambda s: radius(np.maximum(s, 0.0))
        self.edge = (lambda s: edge(np.maximum(s, 0.0))) if edge else self.radius
        self.glass = self.equilibrium + float(self.moduli.sum())
        n = self.moduli.size
        self.forces, self.lags = slice(4, 4 + n), slice(4 + n, 4 + 2 * n)
        self.evaluations, self.floor, self.rtol = 0, 1e-3 * rtol, rtol

        def arrest(s: float) -> float:
            return (self.glass * s**4 + self.viscosity * s**2) * float(radius(s))

        # Depth at which the stiffest response stops the body, to a factor of two: the scale of absolute tolerances.
        s = 1.0
        for _ in range(100):
            s *= 0.5 if arrest(s) > 2.0 else 2.0 if arrest(2.0 * s) < 2.0 else 1.0
        pi, quick = s**2 * float(radius(s)), np.minimum(1.0, self.times / s**2)
        self.atol_approach = 0.1 * self.floor * np.concatenate([[s, s**2, 1.0, pi], pi * quick, quick])
        self.atol_rebound = 0.1 * self.floor * np.concatenate([[s, s**2, 1.0, s**2], quick])

    def solve(self) -> SampledSolution:
        approach = self.integrate_approach()
        s, t, v = approach.y[:3]
        history = (t, s**2, v, self.approach_force(approach.y), self.edge(s))
        if not self.turned(approach):
            rests = Status.CAPTURED if self.equilibrium > 0.0 else Status.SINKS_IN
            return self.result(history, approach, rests)
        way, z, separated = self.integrate_rebound(approach)
        walked, (t, v, d) = approach.sol(approach.t[-1] - way), z[:3]
        later = (t, d, v, self.rebound_force(t, walked), self.edge(walked[0]))
        history = [np.concatenate(pair) for pair in zip(history, later, strict=True)]
        ended = Status.SEPARATED if separated else Status.CAPTURED
        if separated and self.equilibrium == self.external_force == 0.0 and -v[-1] < LEAST_RESTITUTION:
            ended = Status.SINKS_IN
        return self.result(history, approach, ended)

    def integrate_approach(self) -> Any:
        stiffness, drag = self.equilibrium, self.viscosity + float(self.moduli @ self.times)
        slowest = float(self.times.max(initial=0.0))

        def rates(_: float, y: Array) -> Array:
            self.count()
            dt, v = 2.0 * y[0], y[2]
            dv = -dt * (self.approach_force(y) - self.external_force)
            dpi = dt * self.radius(y[0]) * v
            decay = -dt / self.times
            return np.concatenate([[v, dt, dv, dpi], dpi + decay * y[self.forces], dv + decay * y[self.lags]])

        def turns(_: float, y: Array) -> float:
            return y[2]

        def rests(_: float, y: Array) -> float:
            """Time beyond 100 times the slowest decay, after which exp(-100) of the transients is left."""
            a = float(self.radius(y[0]))
            if a == 0.0:
                return -1.0
            if stiffness > 0.0:
                decay = (slowest * self.glass + drag) / stiffness + 1.0 / np.sqrt(stiffness * a)
            else:
                decay = slowest + 1.0 / (drag * a)
            return y[1] - 100.0 * decay

        start = np.concatenate([[0.0, 0.0, 1.0, 0.0], np.zeros_like(self.moduli), np.ones_like(self.moduli)])
        may_rest = stiffness == 0.0 or self.external_force > 0.0
        events = [(turns, -1), (rests, 1)] if may_rest else [(turns, -1)]
        return self.integrate(rates, (0.0, np.inf), start, self.atol_approach, events)

    def turned(self, approach: Any) -> bool:
        """Whether the body moves outwards with more than noise."""
        y = approach.y[:, -1]
        a, pull = float(self.radius(y[0])), float(self.approach_force(y)) - self.external_force
        recoil = pull / (np.sqrt(self.glass * a) + self.viscosity * a)
        return approach.t_events[0].size > 0 and recoil > self.floor

    def integrate_rebound(self, approach: Any) -> tuple[Array, Array, bool]:
        """Return lambda, the states (t, v, d, W_k) and whether the body separates."""
        end, sol = approach.t[-1], approach.sol

        def parts(way: float, z: Array) -> tuple[float, float, Array]:
            """Return both factors of (-q) dt = 2 s1 v1 phi dlambda, and the rates of z in time."""
            self.count()
            y1, v = sol(end - way), z[1]
            fading = self.fading(z[0], y1)
            pull = float(self.rebound_force(z[0], y1)) - self.external_force
            q = self.equilibrium * v - self.viscosity * pull
            q += float(self.moduli @ (z[3:] + fading * (y1[2] - y1[self.lags])))
            gain = float(2.0 * y1[0] * y1[2] * (self.equilibrium + self.moduli @ fading))
            return -q, gain, np.concatenate([[1.0, -pull, v], -pull - z[3:] / self.times])

        def along_path(way: float, z: Array) -> Array:
            loss, gain, rates = parts(way, z)
            return gain / loss * rates

        def along_both(_: float, x: Array) -> Array:
            loss, gain, rates = parts(x[0], x[1:])
            return np.concatenate([[loss], gain * rates]) / (loss + gain)

        def lingers(way: float, z: Array) -> float:
            loss, gain, _ = parts(way, z)
            return gain - 10.0 * loss

        def separates(_: float, x: Array) -> float:
            return x[0] - end

        def widens(_: float, x: Array) -> float:
            return -parts(x[0], x[1:])[0]

        # dt/dlambda is 0/0 at the turning point. Close to it the deceleration is constant and the response
        # instantaneous, so that the edge of contact obeys viscosity v + E_0 (d - d1) = 0; 1e-9 is close enough for
        # relaxation times down to 1e-10 of the contact time.
        y, way = sol(end), 1e-9 * end
        before, slack = 2.0 * y[0] * way, self.viscosity / self.glass
        after = before**2 / (slack + np.hypot(slack, before))
        pull = float(self.approach_force(y)) - self.external_force
        z = np.concatenate([[y[1], 0.0, y[0] ** 2], y[self.lags]])
        z += after * np.concatenate([[1.0, -pull, 0.0], -pull - y[self.lags] / self.times])
        may_rest = [(lingers, 1)] if self.external_force > 0.0 else []
        leg = self.integrate(along_path, (way, end), z, self.atol_rebound[1:], may_rest, first_step=0.1 * way)
        if leg.status == 0:
            return leg.t, leg.y, True
        start = np.concatenate([leg.t[-1:], leg.y[:, -1]])
        last = self.integrate(along_both, (0.0, np.inf), start, self.atol_rebound, [(separates, 1), (widens, 1)])
        way, z = np.append(leg.t, last.y[0, 1:]), np.hstack([leg.y, last.y[1:, 1:]])
        return way, z, last.t_events[0].size > 0

    def integrate(
        self, rates: Any, span: tuple[float, float], start: Array, atol: Array, events: list[tuple[Any, int]],
        **options: Any,
    ) -> Any:  # fmt: skip
        for event, direction in events:
            event.terminal, event.direction = True, direction
        # At each Jacobian SciPy widens the step of its finite differences tenfold for a state on which nothing depends
        # (t in the approach, d in the rebound), until it overflows; the derivative stays zero.
        with np.errstate(over="ignore"):
            solution = solve_ivp(
                rates, span, start, method="Radau", rtol=self.rtol, atol=atol, dense_output=True,
                events=[event for event, _ in events], **options,
            )  # fmt: skip
        if solution.status < 0:
            raise SolverError(Status.STEP_TOO_SMALL, solution.message)
        if not np.all(np.isfinite(solution.y)):
            raise SolverError(Status.NOT_FINITE)
        return solution

    def count(self) -> None:
        self.evaluations += 1
        if self.evaluations > _MAX_EVALUATIONS:
            raise SolverError(Status.TOO_MANY_STEPS, f"{_MAX_EVALUATIONS} evaluations")

    def approach_force(self, y: Array) -> Any:
        dashpot = self.viscosity * self.radius(y[0]) * y[2]
        return self.equilibrium * y[3] + dashpot + np.tensordot(self.moduli, y[self.forces], axes=1)

    def rebound_force(self, t: Any, y1: Array) -> Any:
        return self.equilibrium * y1[3] + np.tensordot(self.moduli, self.fading(t, y1) * y1[self.forces], axes=1)

    def fading(self, t: Any, y1: Array) -> Array:
        """X_k = exp(-(t - t1)/tau_k)."""
        return np.exp(-np.multiply.outer(1.0 / self.times, np.maximum(t - y1[1], 0.0)))

    def result(self, history: Sequence[Array], approach: Any, status: Status) -> SampledSolution:
        time, depth, velocity, force, radius = history
        # The force falls after the turning point, so its peak is in the approach.
        sigma, peak = approach.t, int(np.argmax(force[: approach.t.size]))
        bounds = (sigma[max(peak - 1, 0)], sigma[min(peak + 1, sigma.size - 1)])
        lowest: Any = minimize_scalar(lambda x: -self.approach_force(approach.sol(x)), bounds=bounds, method="bounded")
        left = status is Status.SEPARATED
        return SampledSolution(
            time, depth, velocity, force, radius,
            restitution_coefficient=-float(velocity[-1]) if left else 0.0,
            contact_time=float(time[-1]) if left else np.inf,
            max_indentation_depth=float(depth.max()),
            max_force=max(float(force.max()), -float(lowest.fun)),
            max_contact_radius=float(radius.max()),
            residual_indentation_depth=float(depth[-1]),
            status=status,
        )  # fmt: skip
