"""Exact coefficients of restitution and contact times over velocity and radius, to which laws are calibrated."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import Any, cast

import numpy as np
from numpy.typing import NDArray

from restitution import quantities, validity
from restitution.checks import positive, within
from restitution.contact.profile import Parabola
from restitution.errors import InputError, InputTypeError
from restitution.impact.batch import Batch
from restitution.impact.closed_forms import elastic_contact_time, elastic_max_indentation_depth
from restitution.impact.problem import Body, Impact, collision
from restitution.impact.status import SolverError, Status
from restitution.validity import Validity

Array = NDArray[np.float64]

_RADII = 5


@dataclass(frozen=True, eq=False)
class Collisions:
    """Collisions of one pair of materials over velocity and radius.

    Attributes
    ----------
    impact : Impact
        One of them, of the middle velocity and radius.
    wall : bool
        Whether the second body is a wall.
    velocity, radius : array, shapes (n_velocity,), (n_radius,)
        Velocities [m/s] and radii of the first ball [m]; of an `Impact` the radii of its parabola.
    reduced_radius, mass : array, shape (n_radius,)
        R [m] and m [kg] of 1/R = 1/R1 + 1/R2 and 1/m = 1/m1 + 1/m2.
    ball_mass : float
        Mass [kg] of the first ball at the middle radius; of an `Impact` its mass.
    restitution_coefficient, contact_time : array, shape (n_velocity, n_radius)
        To be met by a law; the contact time is NaN if it is not known.
    validity : Validity or None
        The assumptions of the theory at the worst of them.
    """

    impact: Impact
    wall: bool
    velocity: Array
    radius: Array
    reduced_radius: Array
    mass: Array
    ball_mass: float
    restitution_coefficient: Array
    contact_time: Array
    validity: Validity | None

    @property
    def middle_radius(self) -> float:
        """Reduced radius [m] in the middle."""
        return float(self.reduced_radius[self.radius.size // 2])

    @property
    def middle(self) -> float:
        """Velocity [m/s] in the middle of the range, by ratios."""
        return math.sqrt(float(self.velocity[0]) * float(self.velocity[-1]))

    @property
    def middle_restitution(self) -> float:
        """Coefficient of restitution [-] at the middle velocity, for the middle radius."""
        column = self.restitution_coefficient[:, self.radius.size // 2]
        return float(np.interp(math.log(self.middle), np.log(self.velocity), column))

    @property
    def static_modulus(self) -> float:
        """Reduced modulus E* [Pa] at rest; at once, for a liquid."""
        series = self.impact.reduced_modulus
        return series.equilibrium_modulus or series.instantaneous_modulus

    @property
    def middle_modulus(self) -> tuple[float, float]:
        """Storage part [Pa] of E* and loss tangent over frequency [s], at pi/T of the middle collision."""
        series, time = (
            self.impact.reduced_modulus,
            float(self.contact_time[self.velocity.size // 2, self.radius.size // 2]),
        )
        if math.isnan(time):
            depth = elastic_max_indentation_depth(
                self.static_modulus, math.sqrt(self.middle_radius), self.impact.mass, self.middle
            )
            time = float(elastic_contact_time(depth, self.middle))
        omega = math.pi / time
        storage = float(series.storage_modulus(omega))
        return storage, float(series.loss_modulus(omega)) / (storage * omega)


def collisions(
    problem: Any, velocity: Any, radius: Any, restitution: Any, contact: str | None, points: int, rtol: float,
    workers: int | None,
) -> Collisions:  # fmt: skip
    """Return the collisions of a problem, solved or with given coefficients of restitution; see `calibrate`."""
    impact, own_radius, ball_mass, wall = _pair(problem)
    wall = wall if contact is None else contact == "wall"
    speeds, given = _given(velocity, restitution, points)
    radii = np.array([own_radius]) if radius is None else _range("radius", radius, _RADII)
    factor = radii / own_radius
    reduced_radius, mass = _radius(impact) * factor, float(impact.mass) * factor**3
    centre = radii.size // 2
    middle = replace(
        impact, velocity=math.sqrt(float(speeds[0]) * float(speeds[-1])), mass=float(mass[centre]),
        profile=Parabola(float(reduced_radius[centre])),
    )  # fmt: skip
    if given is None:
        e, time, report = _solved(impact, speeds, reduced_radius, mass, rtol, workers)
    else:
        e = np.repeat(given[:, None], radii.size, axis=1)
        time, report = np.full(e.shape, math.nan), None
    ball_mass *= float(factor[centre]) ** 3
    return Collisions(middle, wall, speeds, radii, reduced_radius, mass, ball_mass, e, time, report)


def _pair(problem: Any) -> tuple[Impact, float, float, bool]:
    """Return an impact, the radius and the mass of its first ball, and whether the other body is a wall."""
    if isinstance(problem, Impact):
        impact, wall = problem, problem.counter_material is None
        if not isinstance(impact.profile, Parabola):
            raise InputTypeError("profile", impact.profile, "must be a Parabola: the codes have spheres")
        impact = replace(impact, velocity=1.0)
        if impact.shape:
            raise InputError("impact", wanted=f"must be a single impact, but has shape {impact.shape}")
        if impact.external_force != 0.0:
            wanted = "must be 0, as the codes add the weight themselves; see with_weight of drop"
            raise InputError("external_force", impact.external_force, wanted, "N")
        return impact, _radius(impact), float(impact.mass), wall
    pair: Any = problem
    if not (isinstance(pair, (tuple, list)) and len(pair) == 2 and all(isinstance(one, Body) for one in pair)):  # pyright: ignore[reportUnknownArgumentType]
        raise InputTypeError("problem", problem, "must be an Impact or a pair of Body")
    impact, *_ = _pair(collision(pair[0], pair[1], velocity=1.0))
    ball, other = (pair[1], pair[0]) if math.isinf(pair[0].radius) else (pair[0], pair[1])
    mass = ball.mass if math.isfinite(ball.mass) else impact.mass
    return impact, float(ball.radius), float(mass), math.isinf(other.radius)


def _radius(impact: Impact) -> float:
    """Radius of the parabola [m]."""
    return float(cast("Parabola", impact.profile).radius)


def _range(name: str, value: Any, points: int) -> Array:
    """Return numbers at equal ratios over a range, or the one number."""
    ends = np.atleast_1d(quantities.check(name, value))
    if ends.size == 1:
        return ends.reshape(1)
    if ends.shape != (2,) or ends[0] >= ends[1]:
        wanted = "must be one number, or the lowest and the highest, in this order"
        raise InputError(name, value, wanted, quantities.INPUTS[name].unit)
    low, high = float(ends[0]), float(ends[1])
    return np.clip(np.geomspace(low, high, points), low, high)


def _given(velocity: Any, restitution: Any, points: int) -> tuple[Array, Array | None]:
    """Return the velocities [m/s], and the given coefficients of restitution at them, if there are any."""
    if np.iterable(restitution):
        return _measured(velocity, restitution)
    if velocity is None:
        raise InputError("velocity", wanted="must be given: one velocity, or the lowest and the highest")
    speeds = _range("velocity", velocity, points)
    return speeds, None if restitution is None else np.full(speeds.size, _coefficients("restitution", restitution))


def _measured(velocity: Any, restitution: Any) -> tuple[Array, Array]:
    """Return measured velocities [m/s] within the range, if there is one, in ascending order, and the coefficients."""
    if len(restitution) != 2:
        raise InputError("restitution", wanted="must be a number, or the velocities and the coefficients")
    speeds = np.atleast_1d(quantities.check("velocity", restitution[0], "restitution[0]"))
    values = np.atleast_1d(_coefficients("restitution[1]", restitution[1]))
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
    impact: Impact, speeds: Array, radii: Array, mass: Array, rtol: float, workers: int | None
) -> tuple[Array, Array, Validity]:
    """Coefficients of restitution and contact times [s] over velocity and radius; refuse what no code could use."""
    shape = speeds.size, radii.size
    v, r, m = (column.reshape(-1) for column in np.broadcast_arrays(speeds[:, None], radii, mass))
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
    numbers = validity.numbers(many.contact, **found, velocity=v, mass=m)
    _refuse_outside_window(many, v, numbers.window_ratio)
    e, time = (columns[name].reshape(shape) for name in ("restitution_coefficient", "contact_time"))
    return e, time, validity.report(numbers)


def _refuse_outside_window(impact: Impact, velocity: Array, ratio: Array) -> None:
    """Raise if contacts are shorter or longer than the times for which the material holds."""
    outside = np.nan_to_num(ratio) > 1.0
    window = impact.contact.window
    if window is None or not np.any(outside):
        return
    good = velocity[~outside]
    inside = f", that is from {good.min():.3g} to {good.max():.3g} m/s" if good.size else ""
    wanted = f"must give contacts within the window of the material, {window[0]:.3g} to {window[1]:.3g} s{inside}"
    raise InputError("velocity", [float(velocity.min()), float(velocity.max())], wanted, "m/s")
