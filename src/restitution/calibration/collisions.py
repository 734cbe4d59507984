"""Exact coefficients of restitution and contact times over velocity and radius, to which laws are calibrated."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from restitution import quantities, validity
from restitution.calibration.bodies import Pair, reduced_radius
from restitution.checks import is_iterable, pair, positive, within
from restitution.contact.profile import Parabola
from restitution.errors import InputError
from restitution.impact.batch import Batch
from restitution.impact.closed_forms import elastic_contact_time, elastic_max_indentation_depth
from restitution.impact.problem import Impact
from restitution.impact.status import SolverError, Status
from restitution.impact.window import require_known
from restitution.validity import Validity

Array = NDArray[np.float64]

_RADII = 5


@dataclass(frozen=True, eq=False)
class Collisions:
    """Collisions of one pair of materials over velocity and radius.

    Attributes
    ----------
    pair : Pair
        The two bodies.
    velocity, radius : array, shapes (n_velocity,), (n_radius,)
        Velocities [m/s] and radii of the first ball [m].
    mass, reduced_radius : array, shape (n_radius,)
        m [kg] and R [m] of 1/m = 1/m1 + 1/m2 and 1/R = 1/R1 + 1/R2.
    restitution_coefficient, contact_time : array, shape (n_velocity, n_radius)
        e [-] and T [s]; the contact time is NaN if only e is given.
    validity : Validity or None
        The assumptions of the theory at the worst of the collisions; None if e is given.
    """

    pair: Pair
    velocity: Array
    radius: Array
    mass: Array
    reduced_radius: Array
    restitution_coefficient: Array
    contact_time: Array
    validity: Validity | None

    @property
    def grid(self) -> tuple[Array, Array, Array]:
        """Velocity [m/s], mass [kg] and reduced radius [m], which broadcast to shape (n_velocity, n_radius)."""
        return self.velocity[:, None], self.mass, self.reduced_radius

    @property
    def middle(self) -> tuple[float, float, float]:
        """Velocity [m/s], mass [kg] and reduced radius [m] in the middle, by ratios."""
        centre = self.radius.size // 2
        speed = math.sqrt(float(self.velocity[0]) * float(self.velocity[-1]))
        return speed, float(self.mass[centre]), float(self.reduced_radius[centre])

    @property
    def middle_restitution(self) -> float:
        """Coefficient of restitution [-] in the middle."""
        column = self.restitution_coefficient[:, self.radius.size // 2]
        return float(np.interp(math.log(self.middle[0]), np.log(self.velocity), column))

    @property
    def static_modulus(self) -> float:
        """Reduced modulus E* [Pa] at rest; of a liquid that of its branches."""
        series = self.pair.impact.reduced_modulus
        return series.equilibrium_modulus or float(series.branch_moduli.sum())

    @property
    def elastic_time(self) -> Array:
        """Contact times [s] of elastic balls with the static modulus."""
        speed, mass, radius = self.grid
        depth = elastic_max_indentation_depth(self.static_modulus, np.sqrt(radius), mass, speed)
        return np.asarray(elastic_contact_time(depth, speed))

    @property
    def dynamic_modulus(self) -> tuple[float, float]:
        """Storage part of E* [Pa], and loss tangent over frequency [s], at the frequency pi/T in the middle."""
        series, times = self.pair.impact.reduced_modulus, self.contact_time
        times = self.elastic_time if np.isnan(times).all() else times
        omega = math.pi / float(times[self.velocity.size // 2, self.radius.size // 2])
        storage = float(series.storage_modulus(omega))
        return storage, float(series.loss_modulus(omega)) / (storage * omega)


def collisions(
    pair: Pair,
    velocity: Any,
    radius: Any,
    restitution: Any,
    points: int,
    rtol: float,
    workers: int | None,
    *,
    extrapolate: bool = False,
) -> Collisions:
    """Return the collisions of a pair of bodies, solved or with given coefficients of restitution."""
    speeds, given = _given(velocity, restitution, points)
    radii = np.array([pair.ball_radius]) if radius is None else _range("radius", radius, _RADII)
    with np.errstate(over="ignore", under="ignore"):
        factor = radii / pair.ball_radius
        mass, reduced = float(pair.impact.mass) * factor**3, reduced_radius(pair.impact) * factor
    if not np.all((mass > 0) & np.isfinite(mass)):
        raise InputError("radius", radius, f"must not be that far from {pair.ball_radius:g} m, the ball's", "m")
    if given is None:
        balls = replace(pair.impact, profile=Parabola(reduced), mass=mass)
        require_known(balls, speeds[[0, -1]], extrapolate=extrapolate)
        e, time, report = _solved(pair.impact, speeds, mass, reduced, rtol, workers)
    else:
        e = np.repeat(given[:, None], radii.size, axis=1)
        time, report = np.full(e.shape, math.nan), None
    found = Collisions(pair, speeds, radii, mass, reduced, e, time, report)
    if found.static_modulus == 0.0:
        raise InputError("material", wanted="must have a spring, as the laws have one")
    return found


def _range(name: str, value: Any, points: int) -> Array:
    """Return numbers at equal ratios over a range, or the one number."""
    ends = np.atleast_1d(quantities.check(name, value))
    if ends.size == 1:
        return ends.reshape(1)
    if ends.shape != (2,) or ends[0] == ends[1]:
        wanted = "must be one number, or the lowest and the highest, which differ"
        raise InputError(name, value, wanted, quantities.INPUTS[name].unit)
    low, high = float(ends.min()), float(ends.max())
    return np.clip(np.geomspace(low, high, points), low, high)


def _given(velocity: Any, restitution: Any, points: int) -> tuple[Array, Array | None]:
    """Return the velocities [m/s], and the given coefficients of restitution at them, if there are any."""
    if is_iterable(restitution):
        return _measured(velocity, restitution)
    if velocity is None:
        raise InputError("velocity", wanted="must be given: one velocity, or the lowest and the highest")
    speeds = _range("velocity", velocity, points)
    return speeds, None if restitution is None else np.full(speeds.size, _coefficients("restitution", restitution))


def _measured(velocity: Any, restitution: Any) -> tuple[Array, Array]:
    """Return measured velocities [m/s] within the range, if there is one, in ascending order, and the coefficients."""
    columns = pair("restitution", restitution, "must be a number, or the velocities and the coefficients")
    speeds = np.atleast_1d(quantities.check("velocity", columns[0], "restitution[0]"))
    values = np.atleast_1d(_coefficients("restitution[1]", columns[1]))
    if speeds.shape != values.shape or speeds.ndim != 1 or np.unique(speeds).size < speeds.size:
        wanted = "must have two columns of one length, the velocities all different"
        raise InputError("restitution", wanted=wanted)
    order = np.argsort(speeds)
    if velocity is not None:
        ends = _range("velocity", velocity, 2)
        order = order[(speeds[order] >= ends[0]) & (speeds[order] <= ends[-1])]
        if order.size == 0:
            raise InputError("velocity", velocity, "must contain a velocity of restitution", "m/s")
    return speeds[order], values[order]


def _coefficients(name: str, value: Any) -> Array:
    return np.asarray(positive(name, within(name, value, 0.0, 1.0)))


def _solved(
    impact: Impact, speeds: Array, mass: Array, radii: Array, rtol: float, workers: int | None
) -> tuple[Array, Array, Validity]:
    """Coefficients of restitution and contact times [s] over velocity and radius; refuse what no code could use."""
    shape = speeds.size, radii.size
    v, m, r = (column.reshape(-1) for column in np.broadcast_arrays(speeds[:, None], mass, radii))
    many = replace(impact, profile=Parabola(r), mass=m, velocity=v)
    columns = Batch.from_impact(many).solve(rtol, workers=workers)
    status = columns["status"]
    for place in np.flatnonzero(status != Status.SEPARATED)[:1]:
        one = Status(int(status[place]))
        if one.failed:
            raise SolverError(one, f"at velocity = {v[place]:.6g} m/s")
        wanted = f"must be a range in which the bodies separate; at {v[place]:.4g} m/s: {one.message}"
        raise InputError("velocity", [float(speeds[0]), float(speeds[-1])], wanted, "m/s")
    found = {name: columns[name] for name in validity.COLUMNS}
    e, time = (columns[name].reshape(shape) for name in ("restitution_coefficient", "contact_time"))
    return e, time, validity.validity(many.contact, **found, velocity=v, mass=m)
