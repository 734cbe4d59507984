"""Exact coefficients of restitution and contact times over velocity and radius, to which laws are calibrated."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import Any, NamedTuple, cast

import numpy as np

from restitution import quantities, validity
from restitution.calibration.laws import CODES, LAWS
from restitution.checks import Array, is_iterable, number, pair, refuse
from restitution.contact.profiles import Parabola
from restitution.errors import InputError, InputTypeError
from restitution.impact.batch import solve_columns
from restitution.impact.closed_forms import elastic_contact_time, elastic_max_indentation_depth
from restitution.impact.problem import Body, Impact, collision, two_bodies
from restitution.impact.window import compared, require_known, require_separation
from restitution.units import VELOCITY
from restitution.validity import Validity
from restitution.variation import vary

# The two bodies of a problem: a ball of a radius and a mass, and another ball or a wall.

PAIR, WALL = "pair", "wall"
"""Kinds of contact: two balls, or a ball and a wall."""

_WORDS = {PAIR: "two balls", WALL: "a ball and a wall"}


class Pair(NamedTuple):
    """A single impact, the radius [m] and the mass [kg] of its first ball, whether it is on a wall, and in words."""

    impact: Impact
    ball_radius: float
    ball_mass: float
    wall: bool
    words: str


def bodies_of(problem: Any, contact: str | None) -> Pair:
    """Return the bodies of an impact, whose parabola counts as the ball, or of a pair of bodies.

    A `contact` of the other kind than that of the bodies is built from them where they determine it.
    """
    if isinstance(problem, Impact):
        impact = _single(problem)
        kind = WALL if impact.counter_material is None else PAIR
        if contact not in (None, kind):
            rule = f"must be {kind!r} for this impact; the other contact needs both bodies: give a pair of Body"
            raise InputError("contact", contact, rule)
        return Pair(impact, reduced_radius(impact), float(impact.mass), kind == WALL, _WORDS[kind])
    first, second = two_bodies(problem)
    _single(collision(first, second, velocity=1.0))
    ball, other = (second, first) if math.isinf(float(first.radius)) else (first, second)
    kind = WALL if math.isinf(float(other.radius)) else PAIR
    words = _WORDS[kind]
    if contact == PAIR != kind:
        (ball, other), words = _two_equal(ball), "two equal balls"
    elif contact == WALL != kind:
        (ball, other), words = _on_wall(ball, other), "a ball and a wall of its material"
    impact, mass = _single(collision(ball, other, velocity=1.0)), float(cast("float", ball.mass))
    # A ball that is held has no mass.
    mass = mass if math.isfinite(mass) else float(impact.mass)
    return Pair(impact, float(ball.radius), mass, (contact or kind) == WALL, words)


def _two_equal(ball: Body) -> tuple[Body, Body]:
    """Return a ball of a wall twice."""
    if ball.material is None:
        raise InputError("contact", PAIR, "must be 'wall' for a rigid ball, as two of them would both be rigid")
    if not math.isfinite(float(cast("float", ball.mass))):
        raise InputError("contact", PAIR, "must be 'wall' for a ball that is held, as two of them would not move")
    return ball, ball


def _on_wall(ball: Body, other: Body) -> tuple[Body, Body]:
    """Return one of two equal balls, and a wall of its material."""
    numbers = [(float(body.radius), float(cast("float", body.mass))) for body in (ball, other)]
    # Masses of one density and one radius may differ by rounding.
    if ball.material != other.material or not np.allclose(*numbers, rtol=1e-9, atol=0.0):
        raise InputError("contact", WALL, "must be 'pair' for two balls that differ; give one of them and the wall")
    return ball, Body(ball.material)


def reduced_radius(impact: Impact) -> float:
    """Return the radius [m] of the parabola of an impact."""
    return float(cast("Parabola", impact.profile).radius)


def _single(impact: Impact) -> Impact:
    """Return an impact at 1 m/s, refusing those that no code of spheres could have."""
    if not isinstance(impact.profile, Parabola):
        raise InputTypeError("profile", impact.profile, "must be a Parabola: the codes have spheres")
    impact.refuse_adhesion()
    impact = replace(impact, velocity=1.0)
    if impact.shape:
        raise InputError("impact", rule=f"must be single, but has shape {impact.shape} beside its velocity")
    if impact.external_force != 0.0:
        rule = "must be 0, as the codes add the weight themselves; see with_weight of drop"
        raise InputError("external_force", impact.external_force, rule, "N")
    if impact.impedance != math.inf:
        rule = "must be infinite, as the codes move the bodies themselves"
        raise InputError("impedance", impact.impedance, rule, "kg/s")
    return impact


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
    """Return the collisions of a pair of bodies, solved or with stated coefficients of restitution."""
    speeds, coefficients = _stated(velocity, restitution, points)
    radii = np.array([pair.ball_radius]) if radius is None else _range("radius", radius, _RADII)
    with np.errstate(over="ignore", under="ignore"):
        factor = radii / pair.ball_radius
        mass, reduced = float(pair.impact.mass) * factor**3, reduced_radius(pair.impact) * factor
    if not np.all((mass > 0) & np.isfinite(mass)):
        raise InputError("radius", radius, f"must not be that far from {pair.ball_radius:g} m, the ball's", "m")
    if coefficients is None:
        balls = vary(pair.impact, {"radius": reduced, "mass": mass})
        require_known(balls, speeds[[0, -1]], extrapolate=extrapolate)
        balls = vary(balls, {"velocity": speeds[:, None]})
        columns = solve_columns(balls, rtol, workers=workers)
        require_separation(columns["status"], np.repeat(speeds, radii.size), (float(speeds[0]), float(speeds[-1])))
        report = validity.report(compared(balls, columns))
        e, time = (columns[name].reshape(balls.shape) for name in ("restitution_coefficient", "contact_time"))
    else:
        e = np.repeat(coefficients[:, None], radii.size, axis=1)
        time, report = np.full(e.shape, math.nan), None
    result = Collisions(pair, speeds, radii, mass, reduced, e, time, report)
    if result.static_modulus == 0.0:
        raise InputError("material", rule="must have a spring, as the laws have one")
    return result


def _range(name: str, value: Any, points: int) -> Array:
    """Return numbers at equal ratios over a range, or a single number."""
    ends = np.atleast_1d(quantities.check(name, value))
    if ends.size == 1:
        return ends.reshape(1)
    if ends.shape != (2,) or ends[0] == ends[1]:
        rule = "must be one number, or the lowest and the highest, which differ"
        raise InputError(name, value, rule, quantities.INPUTS[name].unit)
    low, high = float(ends.min()), float(ends.max())
    return np.clip(np.geomspace(low, high, points), low, high)


def speeds_of(velocity: Any, points: int) -> Array:
    """Return velocities [m/s] at equal ratios over a range, or a single velocity."""
    if velocity is None:
        raise InputError("velocity", rule="must be given: one velocity, or the lowest and the highest")
    return _range("velocity", velocity, points)


def _stated(velocity: Any, restitution: Any, points: int) -> tuple[Array, Array | None]:
    """Return the velocities [m/s], and the coefficients of restitution at them if they are stated."""
    if is_iterable(restitution):
        return _measured(velocity, restitution)
    speeds = speeds_of(velocity, points)
    return speeds, None if restitution is None else np.full(speeds.size, _coefficients("restitution", restitution))


def _measured(velocity: Any, restitution: Any) -> tuple[Array, Array]:
    """Return measured velocities [m/s] within the range, if there is one, in ascending order, and the coefficients."""
    columns = pair("restitution", restitution, "must be a number, or the velocities and the coefficients")
    speeds = np.atleast_1d(quantities.check("velocity", columns[0], "restitution[0]"))
    values = np.atleast_1d(_coefficients("restitution[1]", columns[1]))
    if speeds.shape != values.shape or speeds.ndim != 1 or np.unique(speeds).size < speeds.size:
        rule = "must have two columns of one length, the velocities all different"
        raise InputError("restitution", rule=rule)
    order = np.argsort(speeds)
    if velocity is not None:
        ends = _range("velocity", velocity, 2)
        order = order[(speeds[order] >= ends[0]) & (speeds[order] <= ends[-1])]
        if order.size == 0:
            raise InputError("velocity", velocity, "must contain a velocity of restitution", VELOCITY.unit)
    return speeds[order], values[order]


def _coefficients(name: str, value: Any) -> Array:
    values = number(name, value)
    refuse(name, values, ~((values > 0.0) & (values <= 1.0)), "must be in (0, 1]")
    return values


# Laws of codes that take the coefficient of restitution itself, over velocity or one for all velocities.

REBOUND, ACUSOLVE = "rebound", "acusolve"
EVENTS = tuple(name for name in CODES if name not in LAWS)
"""Names of the codes of events."""
THRESHOLD = 0.5
"""Velocity [-] below which a code of one coefficient may swallow a bounce, over the lowest velocity."""


@dataclass(frozen=True, eq=False)
class TableLaw:
    """Coefficients of restitution over velocity [m/s]; the code interpolates over v, or its logarithm."""

    velocity: Array
    restitution_coefficient: Array
    logarithmic: bool = True

    def rebound(self, velocity: Any, mass: Any, radius: Any) -> tuple[Array, Array]:
        """Return the coefficient of restitution [-] and contact time [s], which is zero, at v0 [m/s]."""
        shape = np.broadcast_shapes(np.shape(velocity), np.shape(mass), np.shape(radius))
        places, table = (np.log(velocity), np.log(self.velocity)) if self.logarithmic else (velocity, self.velocity)
        e = np.interp(places, table, self.restitution_coefficient)
        return np.broadcast_to(e, shape), np.zeros(shape)


def event_table(cases: Collisions, name: str) -> TableLaw:
    """Return the coefficients nearest to collisions: for several radii the middle, by ratios.

    Codes of one coefficient have the middle of all velocities.
    """
    e = cases.restitution_coefficient
    if "row" in CODES[name]:
        return TableLaw(cases.velocity, np.sqrt(e.min(axis=1) * e.max(axis=1)), name == REBOUND)
    return TableLaw(cases.velocity[:1], np.sqrt(e.min() * e.max()).reshape(1))


def event_text(law: TableLaw, name: str, threshold: float, angles: Any = None) -> str:
    """Return the snippet of a code of events; `angles` are those of `tangential` with friction."""
    code, numbers = CODES[name], dict[str, str]()
    text = code["pair"]
    if angles is not None:
        for smooth, rough in code["rough"]:
            text = text.replace(smooth, rough)
        for key, column in (("slope", angles.slope), ("tangential", angles.exact)):
            numbers[key] = ", ".join(f"{x:.8g}" for x in column)
        numbers |= {"mu": f"{angles.friction:.8g}", "gyration": f"{angles.gyration:.8g}"}
        if angles.kept is not None:
            low, high = np.degrees(angles.angle[[0, -1]])
            rows = (code["row"][0].format(v=v, e=x) for v, x in zip(law.velocity, angles.kept, strict=True))
            numbers |= {"low": f"{low:.3g}", "high": f"{high:.3g}", "spread": f"{angles.spread:.2g}"}
            numbers["wall"] = code["between"].join(rows)
    if "row" not in code:
        return text.format(restitution=f"{law.restitution_coefficient[0]:.8g}", threshold=f"{threshold:.8g}")
    pairs = list(zip(law.velocity, law.restitution_coefficient, strict=True))
    columns = [code.get("between", ", ").join(row.format(v=v, e=e) for v, e in pairs) for row in code["row"]]
    return text.format(*columns, **numbers)
