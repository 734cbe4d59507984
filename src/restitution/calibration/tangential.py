"""Tangential laws of particle codes: what they give over the angle of incidence, and the numbers that a user types."""

from __future__ import annotations

import math
import warnings
from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any, NamedTuple

import numpy as np

from restitution.calibration.collisions import ACUSOLVE, REBOUND, Collisions
from restitution.calibration.laws import DAMPING_PER_MASS, Setting, Typed, TypedLaw, loss, scales
from restitution.checks import Array, single
from restitution.errors import InputError, RestitutionWarning
from restitution.impact.oblique import ObliqueResult
from restitution.impact.problem import Impact
from restitution.impact.solve import solve
from restitution.quantities import check
from restitution.units import MODULUS, NUMBER
from restitution.variation import vary

# Steps in a contact when the law of a code is followed. Four times as many change e_t by some 0.001, but styles with a
# way have no limit where the dashpot outweighs the friction at first touch: the way then begins with what the dashpot
# has too much, over a stiffness of zero.
_STEPS = 1500
FEWEST = 100
"""Fewest steps in a contact with a text; e by velocity Verlet then errs by 1e-4 (validation/lammps_balls.md)."""
# Angles at which e_t is compared, and those of a table.
_ANGLES, _TABLE = 17, 65
_LOWEST, _HIGHEST = math.radians(2.0), math.radians(85.0)
_RTOL = 1e-5
# Smallest coefficient of friction, by which slopes are divided.
_SMOOTHEST = 1e-6
# Rate at which a contact without a tangential spring comes to stick, times the contact time.
_STICKING = 100.0
# Bounds of the tangential over the normal stiffness where it is free.
_FREE = (0.05, 5.0)


class Rule(NamedTuple):
    """Tangential spring and dashpot of a code, with a limit of friction.

    Attributes
    ----------
    memory : str
        What the code keeps: the "way" of the spring, which is multiplied by the stiffness of the moment, or its
        "force", to which each step adds.
    rescaled : bool
        Whether the memory shrinks with the contact radius while the contact unloads.
    slip : str
        What the friction limits: the "spring", while the dashpot is off; both "together", where the spring keeps the
        limit less the dashpot; or "dashpot", which gives way before the spring does.
    dashpot : callable
        Dashpot from the normal one, the tangential stiffness, their ratio and the number that is typed; scaled such
        that the mass is 1.
    """

    memory: str
    rescaled: bool
    slip: str
    dashpot: Callable[[float, float, float, float], float] = lambda c, k, ratio, number: number * c


LAMMPS_RULES = {
    "mindlin": Rule("way", False, "together"),
    "mindlin/force": Rule("force", False, "together"),
    "mindlin_rescale": Rule("way", True, "together"),
    "mindlin_rescale/force": Rule("force", True, "together"),
}
"""Tangential styles of LAMMPS with a stiffness that grows with the contact radius."""


def rebounds(
    rule: Rule, law: TypedLaw, case: Case, ratio: float, number: float, slopes: Array, steps: int = _STEPS
) -> Array:
    """Return e_t by the law of a code over the slopes v_c0/(mu v0), by its own steps in time.

    `ratio` is the tangential over the normal stiffness of the contact.
    """
    shape, speed, mass = law.law.shape, case.velocity, case.mass
    stiffness = law.stiffness(mass, case.radius)
    damping = law.strength * law.law.dashpot(stiffness, mass, case.radius)
    b = float(loss(shape, stiffness, damping, mass, speed))
    unit = float(scales(shape, stiffness, mass, speed)[1])
    h = float(law.rebound(speed, mass, case.radius)[1]) / unit / steps
    p, q, mobility = shape.spring, shape.dashpot, 1.0 + 1.0 / case.gyration
    tangential = np.asarray(slopes, dtype=np.float64).copy()
    d, v, normal, before = 0.0, 1.0, 0.0, 0.0
    kept, pull = np.zeros_like(tangential), np.zeros_like(tangential)
    while True:
        v -= 0.5 * h * normal
        tangential -= 0.5 * h * mobility * pull
        d += h * v
        if d <= 0.0:
            break
        c = b * d**q
        normal = d**p + c * v
        if normal <= 0.0:
            if v < 0.0 and law.end == "force":
                break
            normal = 0.0
        k, size = ratio * p * d ** (p - 1.0), d ** (p - 1.0)
        if rule.rescaled and size < before:
            kept *= size / before
        before = size
        kept += (k if rule.memory == "force" else 1.0) * tangential * h
        spring = kept if rule.memory == "force" else k * kept
        dragged = rule.dashpot(c, k, ratio, number) * tangential
        dashed = spring + dragged
        trial = spring if rule.slip == "spring" else dashed
        share = np.minimum(1.0, normal / np.maximum(np.abs(trial), 1e-300))
        slips = share < 1.0
        pull = np.where(slips, share * trial, dashed)
        left = share * trial - (dragged if rule.slip == "together" else 0.0)
        if rule.slip == "dashpot":
            # A dashpot that outweighs an opposite spring slips.
            outweighs = (dragged * spring < 0.0) & (np.abs(dragged) >= np.abs(spring))
            left = np.where(outweighs, spring, np.clip(spring, -normal, normal))
        kept = np.where(slips, left if rule.memory == "force" else left / k, kept)
        v -= 0.5 * h * normal
        tangential -= 0.5 * h * mobility * pull
    return -tangential / slopes


def rigid_rebounds(e: float, gyration: float, slopes: Array) -> Array:
    """Return e_t of a contact without tangential compliance: it slides until it sticks, and never slips back."""
    return np.minimum(0.0, -1.0 + (1.0 + 1.0 / gyration) * (1.0 + e) / slopes)


class Case(NamedTuple):
    """The collision at which angles are compared: v0 [m/s], m [kg], R [m], gyration."""

    velocity: float
    mass: float
    radius: float
    gyration: float


class Model(NamedTuple):
    """Tangential law of a target.

    Attributes
    ----------
    rule : Rule or None
        None for a contact without tangential compliance.
    bounds : tuple of float
        Smallest and largest ratio of the stiffnesses that can be typed.
    free : bool
        Whether the dashpot can be typed; else the number is 1.
    typed : callable
        What a user types, from the friction, the modulus E* [Pa], the ratio and the number of the dashpot.
    """

    rule: Rule | None
    bounds: tuple[float, float]
    free: bool
    typed: Callable[[float, float, float, float], dict[str, Typed]]


def poisson_ratio(ratio: float) -> float:
    """Return the Poisson ratio of the ratio 2 (1 - nu)/(2 - nu) of tangential and normal stiffness of two bodies."""
    return (2.0 - 2.0 * ratio) / (2.0 - ratio)


_BY_POISSON = (2.0 / 3.0 + 1e-9, 1.0)


def _friction(name: str) -> Callable[[float, float, float, float], dict[str, Typed]]:
    return lambda friction, modulus, ratio, number: {name: Typed(friction, NUMBER, "coefficient of friction")}


def _lammps(friction: float, modulus: float, ratio: float, number: float) -> dict[str, Typed]:
    return {
        "k_t": Typed(2.0 * ratio * modulus, MODULUS, "tangential stiffness over the contact radius"),
        "x_gammat": Typed(number, NUMBER, "tangential over normal damping"),
        "x_mu": Typed(friction, NUMBER, "coefficient of friction"),
    }


def _mercury(friction: float, modulus: float, ratio: float, number: float) -> dict[str, Typed]:
    # F = (2/3) 8 G sqrt(R d) way, beside 2 E* sqrt(R d) of the normal stiffness.
    return {
        "G_eff": Typed(0.375 * ratio * modulus, MODULUS, "effective shear modulus"),
        "gamma_t": Typed(number, NUMBER, "sliding dissipation"),
        "mu": Typed(friction, NUMBER, "coefficient of friction"),
    }


def _mujoco(friction: float, modulus: float, ratio: float, number: float) -> dict[str, Typed]:
    return {
        "mu": Typed(friction, NUMBER, "coefficient of friction"),
        "damping_t": Typed(number, DAMPING_PER_MASS, "damping per mass of friction, typed with a minus"),
    }


def _yade(friction: float, modulus: float, ratio: float, number: float) -> dict[str, Typed]:
    return {"angle": Typed(math.atan(friction), NUMBER, "angle of friction [rad]")}


def takes_friction(target: str) -> bool:
    """Return whether the text of a target has friction."""
    return target.startswith("lammps-") or target in MODELS


def model_of(target: str, style: str | None) -> Model:
    """Return the tangential law of a target; refuse one that has none here, and a style that it does not have."""
    if target.startswith("lammps-"):
        name = style or "mindlin_rescale/force"
        if name not in LAMMPS_RULES:
            raise InputError("tangential", style, f"must be one of {', '.join(LAMMPS_RULES)}")
        return Model(LAMMPS_RULES[name], _FREE, True, _lammps)
    if style is not None:
        raise InputError("tangential", style, f"belongs to LAMMPS, not to {target}")
    if target not in MODELS:
        rule = f"has a meaning for {', '.join(('lammps-...', *MODELS))}, not for {target}"
        raise InputError("friction", rule=rule)
    return MODELS[target]


# Dashpots 2 gamma sqrt(m k) of both stiffnesses.
_ROOT = Rule("way", False, "spring", lambda c, k, ratio, number: math.sqrt(ratio) * c)
# MercuryDPM has (2/3) k with k = 8 G sqrt(R d), and the dashpot is proportional to sqrt(m k).
_MERCURY = Rule("way", False, "spring", lambda c, k, ratio, number: number * math.sqrt(1.5 * k))
_KRATOS = _ROOT._replace(memory="force", rescaled=True, slip="dashpot")
MODELS = {
    "liggghts": Model(_ROOT, _BY_POISSON, False, _friction("mu")),
    "kratos-dem": Model(_KRATOS, _BY_POISSON, False, _friction("mu")),
    "mercury-bshp": Model(_MERCURY, _FREE, True, _mercury),
    "yade-mindlin": Model(Rule("force", False, "spring"), _BY_POISSON, False, _yade),
    "mujoco-solref": Model(None, _FREE, False, _mujoco),
    REBOUND: Model(None, _FREE, False, _friction("mu")),
    ACUSOLVE: Model(None, _FREE, False, _friction("mu")),
}
"""Tangential laws by the name of the target, apart from those of LAMMPS; REBOUND and AcuSolve have tables."""


@dataclass(frozen=True, eq=False)
class Angles:
    """Tangential restitution by a code, over the angle of incidence, in the collision in the middle of the range.

    Attributes
    ----------
    friction, gyration : float
        Coefficient of friction, and moment of inertia over m R^2.
    velocity : float
        Normal velocity [m/s] of the collision.
    angle, exact, calibrated : array
        Angles [rad] from the normal of a body without spin, and e_t there: exact, and by the code.
    warnings : tuple of str
        Assumptions of the theory that are doubtful at these angles.
    ratio, number : float
        Tangential over normal stiffness of the code, and the number of its dashpot; NaN where it has none.
    kept : array or None
        v_x'/v_x at all velocities of a code with a table of it.
    spread : float
        Largest difference of v_x'/v_x from this table, over the velocities and angles.
    of_steps : float
        Largest difference of e_t by the code with 100 steps in a contact from `calibrated`, which has 1500.
    """

    friction: float
    gyration: float
    velocity: float
    angle: Array
    exact: Array
    calibrated: Array
    warnings: tuple[str, ...] = ()
    ratio: float = math.nan
    number: float = math.nan
    kept: Array | None = None
    spread: float = 0.0
    of_steps: float = 0.0

    @property
    def slope(self) -> Array:
        """v_c0/(mu v0) [-]."""
        return np.tan(self.angle) / self.friction

    @property
    def largest_error(self) -> float:
        """Largest difference of e_t over the angles."""
        return float(np.abs(self.calibrated - self.exact).max())


def over_angles(
    target: str, law: TypedLaw | None, cases: Collisions, friction: Any, angle: Any, gyration: Any, style: str | None
) -> Angles:
    """Return the tangential numbers of a target with which e_t is nearest over the angles, by its largest difference.

    `law` is None for a code of events, which has a table.
    """
    mu, kappa = (single(name, check(name, value)) for name, value in (("friction", friction), ("gyration", gyration)))
    if not _SMOOTHEST <= mu < math.inf:
        rule = f"must be finite and at least {_SMOOTHEST:g}; leave it out for a contact without friction"
        raise InputError("friction", friction, rule)
    if cases.validity is None:
        raise InputError("friction", friction, "needs the material: it has no meaning with a stated restitution")
    model, angles = model_of(target, style), _angles(angle, _TABLE if target == REBOUND else _ANGLES)
    velocity, mass, radius = cases.middle
    impact = vary(cases.pair.impact, {"radius": radius, "mass": mass, "velocity": velocity})
    with warnings.catch_warnings():
        # The result has them.
        warnings.simplefilter("ignore", RestitutionWarning)
        solved = solve(vary(impact, {"friction": mu, "gyration": kappa, "angle": angles}), rtol=_RTOL)
    assert isinstance(solved, ObliqueResult)
    doubts = tuple(solved.warnings)
    exact, slopes = np.asarray(solved.tangential_restitution_coefficient), np.tan(angles) / mu
    if target == ACUSOLVE:
        table = Angles(mu, kappa, velocity, angles, exact, exact, doubts)
        return _with_table(table, impact, cases.velocity)
    if law is None:
        return Angles(mu, kappa, velocity, angles, exact, exact, doubts)
    case = Case(velocity, mass, radius, kappa)
    if model.rule is None:
        e, time = (float(x) for x in law.rebound(velocity, mass, radius))
        rigid = rigid_rebounds(e, kappa, slopes)
        return Angles(mu, kappa, velocity, angles, exact, rigid, doubts, number=_STICKING / time)
    ratio, number = _nearest(model, model.rule, law, case, slopes, exact)
    coarse, calibrated = (rebounds(model.rule, law, case, ratio, number, slopes, n) for n in (FEWEST, _STEPS))
    of_steps = float(np.abs(coarse - calibrated).max())
    return Angles(mu, kappa, velocity, angles, exact, calibrated, doubts, ratio, number, of_steps=of_steps)


def _with_table(angles: Angles, impact: Impact, velocities: Array) -> Angles:
    """Add the table of v_x'/v_x over the normal velocity whose largest difference over the angles is least."""
    thrown = {"friction": angles.friction, "gyration": angles.gyration, "angle": angles.angle}
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", RestitutionWarning)
        solved = solve(vary(impact, {"velocity": velocities[:, None], **thrown}), rtol=_RTOL)
    assert isinstance(solved, ObliqueResult)
    mobility = 1.0 + 1.0 / angles.gyration
    kept = 1.0 - (1.0 + np.asarray(solved.tangential_restitution_coefficient)) / mobility
    low, high = kept.min(axis=1), kept.max(axis=1)
    middle, spread = 0.5 * (low + high), 0.5 * float((high - low).max())
    by_code = mobility * (1.0 - np.interp(angles.velocity, velocities, middle)) - 1.0
    return replace(angles, calibrated=np.full(angles.exact.size, by_code), kept=middle, spread=spread)


def _angles(angle: Any, count: int) -> Array:
    """Return angles [rad] over a range, or a single angle."""
    if angle is None:
        return np.linspace(_LOWEST, _HIGHEST, count)
    ends = np.atleast_1d(check("angle", angle))
    if ends.ndim != 1 or ends.size not in (1, 2) or ends.min() <= 0.0:
        raise InputError("angle", angle, "must be one angle > 0, or the smallest and the largest", "rad")
    return np.linspace(ends[0], ends[-1], count if ends.size > 1 else 1)


def _nearest(model: Model, rule: Rule, law: TypedLaw, case: Case, slopes: Array, exact: Array) -> tuple[float, float]:
    """Return ratio of the stiffnesses and number of the dashpot with the smallest largest difference of e_t."""
    from scipy.optimize import minimize, minimize_scalar

    low, high = model.bounds

    def error(ratio: float, number: float) -> float:
        return float(np.abs(rebounds(rule, law, case, ratio, number, slopes) - exact).max())

    # One ratio after the other: the error has several minima.
    tried = np.geomspace(low, high, 9)
    best = min(tried.tolist(), key=lambda ratio: error(ratio, 1.0))
    if not model.free:
        step = tried[1] / tried[0]
        minimum: Any = minimize_scalar(
            lambda ratio: error(ratio, 1.0), bounds=(max(low, best / step), min(high, best * step)), method="bounded",
            options={"xatol": 1e-3},
        )  # fmt: skip
        return float(minimum.x), 1.0
    inside: Any = minimize(
        lambda x: error(math.exp(min(max(x[0], math.log(low)), math.log(high))), abs(x[1])),
        [math.log(best), 1.0], method="Nelder-Mead", options={"xatol": 1e-3, "fatol": 1e-5, "maxfev": 120},
    )  # fmt: skip
    return math.exp(min(max(inside.x[0], math.log(low)), math.log(high))), abs(float(inside.x[1]))


def typed(target: str, angles: Angles, modulus: float, style: str | None) -> dict[str, Typed]:
    """Return what a user types for friction, by the name in the code."""
    return model_of(target, style).typed(angles.friction, modulus, angles.ratio, angles.number)


def with_poisson_ratio(target: str, angles: Angles, setting: Setting) -> Setting:
    """Return the setting with the Poisson ratio by which a code has the ratio of the stiffnesses, if it has it so."""
    if target not in MODELS or MODELS[target].bounds != _BY_POISSON:
        return setting
    return setting._replace(poisson_ratio=min(max(poisson_ratio(angles.ratio), 0.0), 0.5 - 1e-9))
