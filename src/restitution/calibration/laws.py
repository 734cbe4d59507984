"""Memoryless contact laws of particle and multibody codes, and the numbers that a user types for them."""

from __future__ import annotations

import math
import tomllib
from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cache
from importlib.resources import files
from typing import Any, Literal, NamedTuple, Protocol

import numpy as np

from restitution.checks import Array
from restitution.impact.closed_forms import mueller_poeschel_restitution
from restitution.units import MODULUS, NUMBER, TIME, VELOCITY, Dimension, Powers

# Rebound of a law without memory, F = k d^p + c d^q v: coefficient of restitution and contact time over its loss.

End = Literal["force", "overlap"]

DAMPING = Dimension("damping per area", "1/(m s)", powers=Powers(0, -1, -1))
_STIFFNESS_PER_MASS = Dimension("stiffness per mass", "1/s^2", powers=Powers(0, 0, -2))
_SLOWNESS = Dimension("time per length", "s/m", powers=Powers(0, -1, 1))
_FORCE_PER_LENGTH = Dimension("stiffness", "N/m", powers=Powers(1, 0, -2))
DAMPING_PER_MASS = Dimension("damping per mass", "1/s", powers=Powers(0, 0, -1))

# Losses of the table. Below them e = exp(-C b); above them the rebound is too slow to be of use.
_LOWEST = 1e-4
_NODES = 56
_DEGREE = 7
_RTOL = 1e-12


class Shape(NamedTuple):
    """Exponents of a law F = k d^p + c d^q v: of the spring (p) and of the dashpot (q)."""

    spring: float
    dashpot: float


VISCOELASTIC = Shape(1.5, 0.5)
"""Kuwabara and Kono (1987), Brilliantov and others (1996)."""

CONSTANT = Shape(1.5, 0.25)
"""Tsuji and others (1992): e is the same at every velocity."""

LINEAR = Shape(1.0, 0.0)
"""Linear spring and dashpot."""

HUNT_CROSSLEY = Shape(1.0, 1.0)
"""Linear spring, F = k d (1 + b v): the rebound velocity stays below 1/b."""

# Largest losses of the table, with e of about 1e-5. With a pull, the overlap never vanishes from the critical loss on.
_HIGHEST = {
    (VISCOELASTIC, "overlap"): 12.0, (CONSTANT, "overlap"): 0.965 * 5.0**0.5, (LINEAR, "overlap"): 0.965 * 2.0,
}  # fmt: skip
_CRITICAL = {(CONSTANT, "overlap"): 5.0**0.5, (LINEAR, "overlap"): 2.0}
_HIGHEST_BY_FORCE = 1e3


def scales(shape: Shape, stiffness: Any, mass: Any, velocity: Any) -> tuple[Any, Any]:
    """Return the length [m] and time [s] in which k, m and v0 are 1: L = (m v0^2/k)^(1/(p+1)), L/v0."""
    length = (mass * velocity**2 / stiffness) ** (1.0 / (shape.spring + 1.0))
    return length, length / velocity


def loss(shape: Shape, stiffness: Any, damping: Any, mass: Any, velocity: Any) -> Any:
    """Return the loss b = c L^(q-p) v0/k [-], the only number on which the rebound depends."""
    length, _ = scales(shape, stiffness, mass, velocity)
    return damping * length ** (shape.dashpot - shape.spring) * velocity / stiffness


def rebound(shape: Shape, end: End, losses: Any) -> tuple[Array, Array]:
    """Return the coefficient of restitution and contact time over L/v0 at losses >= 0.

    The contact ends at zero force in the rebound ("force"), or pulls until zero overlap ("overlap"). Where the overlap
    never vanishes, e is 0 and the time infinite.
    """
    table, top = _table(shape, end), _HIGHEST.get((shape, end), _HIGHEST_BY_FORCE)
    b = np.asarray(losses, dtype=np.float64)
    log_loss, log_time = np.moveaxis(table(_place(shape, end, np.clip(b, _LOWEST, top))), -1, 0)
    # Below the table both logarithms are proportional to b.
    small = np.minimum(b / _LOWEST, 1.0)
    e, time = np.exp(-np.exp(log_loss) * small), elastic_time(shape) * np.exp(log_time * small)
    return np.where(b > top, 0.0, e), np.where(b > top, np.inf, time)


@cache
def elastic_time(shape: Shape) -> float:
    """Return the contact time over L/v0 without loss."""
    return one_rebound(shape, "overlap", 0.0)[1]


def one_rebound(shape: Shape, end: End, b: float) -> tuple[float, float]:
    """Return the coefficient of restitution and contact time at one loss, by integration of the equation of motion."""
    from scipy.integrate import solve_ivp

    p, q = 4.0 * shape.spring, 4.0 * shape.dashpot

    # With d = x^4 and dt = 4 x^3 ds all terms are powers of x, so that the motion is smooth at first touch.
    def motion(_: float, y: Array) -> tuple[float, float, float]:
        x, v = max(y[0], 0.0), y[1]
        return v, -4.0 * x**3 * (x**p + b * x**q * v), 4.0 * x**3

    def force(_: float, y: Array) -> float:
        return max(y[0], 0.0) ** (p - q) + b * y[1]

    def overlap(s: float, y: Array) -> float:
        return y[0] if s > 0.0 else 1.0

    event: Any = force if end == "force" and b > 0.0 else overlap
    event.terminal, event.direction = True, -1.0
    path = solve_ivp(motion, (0.0, 1e6), (0.0, 1.0, 0.0), "DOP853", rtol=_RTOL, atol=1e-14, events=event)
    _, v, time = path.y[:, -1]
    return -float(v), float(time)


def _place(shape: Shape, end: End, b: Any) -> Any:
    """Return the variable of the table: log b, stretched towards the critical loss."""
    return np.log(b) - np.log1p(-b / _CRITICAL.get((shape, end), np.inf))


@cache
def _table(shape: Shape, end: End) -> Any:
    """Return the spline of log(-log e) and the logarithm of the time over that without loss."""
    from scipy.interpolate import make_interp_spline

    highest = _HIGHEST.get((shape, end), _HIGHEST_BY_FORCE)
    places = np.linspace(_place(shape, end, _LOWEST), _place(shape, end, highest), _NODES)
    losses = 1.0 / (np.exp(-places) + 1.0 / _CRITICAL.get((shape, end), np.inf))
    e, time = np.transpose([one_rebound(shape, end, float(b)) for b in losses])
    return make_interp_spline(
        places, np.stack([np.log(-np.log(e)), np.log(time / elastic_time(shape))], axis=-1), k=_DEGREE
    )


class Typed(NamedTuple):
    """A number that a user types: its value in SI, and its meaning."""

    value: float
    dimension: Dimension
    words: str


class Setting(NamedTuple):
    """The collision in the middle of the range, and what a user without this package has for it."""

    velocity: float  # [m/s]
    mass: float  # reduced mass [kg]
    poisson_ratio: float
    modulus: float  # storage part of E* [Pa]
    retardation_time: float  # loss tangent over frequency [s]
    restitution_coefficient: float


@dataclass(frozen=True, kw_only=True)
class Law:
    """Law F = k d^p + c d^q v of a code.

    Attributes
    ----------
    name, words, source : str
        Name of the target, code and model, and the pages that define it.
    shape : Shape
        Exponents p and q.
    dashpot : callable
        c for a strength of 1, from k, m [kg] and R [m].
    typed : callable
        What a user types, by the name in the code, from the modulus E* [Pa], the strength and the setting.
    naive : callable
        Modulus and strength of what a user without this package types.
    strengths, elastic : tuple of float, bool
        Smallest and largest strength that can be typed; whether none can be typed too.
    per_mass : bool
        Whether the stiffness of a linear spring is one per mass.
    end, naive_end : str
        End of the contact with the snippet, and with the defaults of the code: at zero "force", or "overlap".
    pair, wall : str
        Text to paste for two balls, and for a ball and a wall; the numbers are fields.
    rough : tuple of pairs of str
        Parts of the texts, and what they are with friction.
    comment, units : str, tuple of str
        Form of a comment; unit systems.
    notes : tuple of str
        Remarks in the text; numbers may be fields.
    """

    name: str
    words: str
    source: str
    shape: Shape
    dashpot: Callable[[Any, Any, Any], Any]
    typed: Callable[[float, float, Setting], dict[str, Typed]]
    naive: Callable[[Setting], tuple[float, float]]
    pair: str
    wall: str
    strengths: tuple[float, float] = (0.0, math.inf)
    elastic: bool = True
    per_mass: bool = False
    end: End = "force"
    naive_end: End = "force"
    rough: tuple[tuple[str, str], ...] = ()
    comment: str = "# {}"
    units: tuple[str, ...] = ("si",)
    notes: tuple[str, ...] = ()

    def __reduce__(self) -> Any:
        return _registered, (self.name,)


def _registered(name: str) -> Law:
    """Return the law of a target, for the pickle of a result."""
    return LAWS[name]


@dataclass(frozen=True)
class TypedLaw:
    """Law with its numbers: modulus E* [Pa] of k = (4/3) E* sqrt(R), or k [N/m] or k/m [1/s^2]; strength."""

    law: Law
    modulus: float
    strength: float
    end: End

    def loss(self, velocity: Any, mass: Any, radius: Any) -> Any:
        """Return the loss b [-] at v0 [m/s], m [kg] and R [m]."""
        stiffness = self.stiffness(mass, radius)
        damping = self.strength * self.law.dashpot(stiffness, mass, radius)
        return loss(self.law.shape, stiffness, damping, mass, velocity)

    def rebound(self, velocity: Any, mass: Any, radius: Any) -> tuple[Array, Array]:
        """Return the coefficient of restitution [-] and contact time [s] at v0 [m/s], m [kg] and R [m]."""
        e, time = rebound(self.law.shape, self.end, self.loss(velocity, mass, radius))
        _, unit = scales(self.law.shape, self.stiffness(mass, radius), mass, velocity)
        return e, time * unit

    def stiffness(self, mass: Any, radius: Any) -> Any:
        """Return the stiffness k of the law at m [kg] and R [m]."""
        if self.law.shape.spring == LINEAR.spring:
            return self.modulus * (mass if self.law.per_mass else np.ones_like(mass))
        return 4.0 / 3.0 * self.modulus * np.sqrt(radius)


class _OfMaterial(Protocol):
    @property
    def poisson_ratio(self) -> float: ...


def elastic(modulus: float, setting: _OfMaterial) -> dict[str, Typed]:
    """Return Young's modulus and Poisson ratio that give the reduced modulus E*, if both bodies have them."""
    # The ratio only matters for tangential forces; codes refuse negative ones.
    nu = max(setting.poisson_ratio, 0.0)
    return {
        "E": Typed(2.0 * (1.0 - nu**2) * modulus, MODULUS, "Young's modulus of both bodies"),
        "nu": Typed(nu, NUMBER, "Poisson ratio of both bodies"),
    }


def by_restitution(strength_of: Callable[[float], float], low: float, high: float) -> dict[str, Any]:
    """Return parts of a law whose damping is typed as a coefficient of restitution, 1 for none."""

    def typed(modulus: float, strength: float, setting: Setting) -> dict[str, Typed]:
        e = inverse(strength_of, strength, low, high) if strength > 0.0 else 1.0
        return elastic(modulus, setting) | {"e": Typed(e, NUMBER, "coefficient of restitution, as typed")}

    def naive(setting: Setting) -> tuple[float, float]:
        return setting.modulus, strength_of(min(max(setting.restitution_coefficient, low), high))

    return {
        "dashpot": lambda stiffness, mass, radius: np.sqrt(mass * stiffness),
        "typed": typed,
        "naive": naive,
        "strengths": (strength_of(high), strength_of(low)),
    }


def inverse(function: Callable[[float], float], value: float, low: float, high: float) -> float:
    """Return the argument in [low, high] at which a decreasing function has a value, or the nearer end."""
    from scipy.optimize import brentq

    if value >= function(low) or value <= function(high):
        return low if value >= function(low) else high
    root: Any = brentq(lambda x: function(x) - value, low, high, xtol=1e-15)
    return float(root)


# Laws of LAMMPS, LIGGGHTS, MercuryDPM, YADE, Kratos, MuJoCo and Drake, from their documentation and sources.


def coefficient_strength(e: float) -> float:
    """Return the damping -sqrt(5) ln e/sqrt(pi^2 + ln^2 e) with which a contact that may pull has the coefficient e.

    Exact (D. Antypov and J. A. Elliott, EPL 94 (2011) 50004).
    """
    return math.sqrt(5.0) * -math.log(e) / math.hypot(math.pi, math.log(e))


def tsuji_strength(e: float) -> float:
    """Return the damping alpha(e) by J. S. Marshall, J. Comput. Phys. 228 (2009) 1541, eq. 53.

    A fit to figure 3 of Y. Tsuji and others, Powder Technol. 71 (1992) 239. LAMMPS up to version 22Jul2025 takes it as
    it is, later ones multiply it by sqrt(2) (pull request 5113 of LAMMPS).
    """
    return float(np.polynomial.polynomial.polyval(e, (1.2728, -4.2783, 11.087, -22.348, 27.467, -18.022, 4.8218)))


def thornton_strength(e: float) -> float:
    """Return the damping sqrt(6) gamma(e) with which a contact without a pull has the coefficient e.

    A fit (C. Thornton and others, Powder Technol. 233 (2013) 30, eqs. B6 and B7).
    """
    powers = (
        -6.918798, -16.41105, 146.8049, -796.4559, 2928.711, -7206.864, 11494.29, -11342.18, 6276.757, -1489.915,
    )  # fmt: skip
    exponent = e * float(np.polynomial.polynomial.polyval(e, powers))
    return math.sqrt(6.0 * (1.0 / (1.0 - (1.0 + e) ** 2 * math.exp(exponent)) - 1.0))


def _lammps(damping: str, number: str) -> dict[str, Any]:
    """Return the parts that the models of damping of LAMMPS share; `number` is the name of theirs."""
    model = f"hertz/material {{E}} {{{number}}} {{nu}} tangential linear_nohistory 0 0 damping {damping} limit_damping"
    return {
        "name": f"lammps-{damping.replace('_', '-')}",
        "words": f"LAMMPS, pair_style granular, hertz/material, damping {damping} limit_damping",
        "source": "LAMMPS documentation (version 22Jul2025), pages pair_style granular and fix wall/gran",
        "naive_end": "overlap",
        "rough": (("linear_nohistory 0 0", "{style} {k_t} {x_gammat} {x_mu}"),),
        "units": ("si", "cgs", "micro", "lj"),
        "pair": f"pair_style granular\npair_coeff * * {model}",
        "wall": f"fix wall all wall/gran granular {model} zplane 0 NULL",
    }


CODES: dict[str, dict[str, Any]] = tomllib.loads(
    files("restitution.calibration").joinpath("codes.toml").read_text(encoding="utf-8")
)
"""Texts by the name of the target."""


def _texts(name: str) -> dict[str, Any]:
    """Return the arguments of a law that are texts."""
    pairs = tuple((smooth, rough) for smooth, rough in CODES[name].get("rough", ()))
    text = CODES[name] | {"name": name, "notes": tuple(CODES[name].get("notes", ())), "rough": pairs}
    return text | {"wall": f"{text['pair']}\n{text.pop('wall_line', '')}".rstrip("\n")}


LAMMPS_VISCOELASTIC = Law(
    **_lammps("viscoelastic", "eta_n0"),
    shape=VISCOELASTIC,
    # eta_n = eta_n0 a m_eff, a = sqrt(R d).
    dashpot=lambda stiffness, mass, radius: mass * np.sqrt(radius),
    typed=lambda modulus, strength, setting: (
        elastic(modulus, setting) | {"eta_n0": Typed(strength, DAMPING, "damping coefficient")}
    ),
    # c = (3/2) A k with the retardation time A.
    naive=lambda setting: (setting.modulus, 2.0 * setting.modulus * setting.retardation_time / setting.mass),
    notes=("eta_n0 is inversely proportional to the mass of the balls",),
)

_TSUJI = Law(
    **_lammps("tsuji", "e"),
    **by_restitution(tsuji_strength, 0.0, 1.0),
    shape=CONSTANT,
    elastic=False,
    notes=("up to version 22Jul2025; later versions, which multiply the damping by sqrt(2), need e = {e_later}",),
)


def _tsuji_typed(modulus: float, strength: float, setting: Setting) -> dict[str, Typed]:
    later = inverse(tsuji_strength, strength / math.sqrt(2.0), 0.0, 1.0)
    words = "in place of e in versions that multiply the damping by sqrt(2)"
    return _TSUJI.typed(modulus, strength, setting) | {"e_later": Typed(later, NUMBER, words)}


MERCURY_BSHP = Law(
    **_texts("mercury-bshp"),
    shape=VISCOELASTIC,
    dashpot=lambda stiffness, mass, radius: 1.5 * stiffness,
    typed=lambda modulus, strength, setting: {
        "E_eff": Typed(modulus, MODULUS, "effective elastic modulus"),
        "A": Typed(strength, TIME, "dissipation"),
    },
    # The loss tangent over the frequency is the time A.
    naive=lambda setting: (setting.modulus, setting.retardation_time),
)


def yade_restitution(beta: float, velocity: float) -> dict[str, Typed]:
    """Return en and vn of YADE for its damping beta = vstar^2 vn^(-1/5), where en is the Pade approximant at vstar."""
    en = float(mueller_poeschel_restitution(math.sqrt(beta * velocity**0.2)))
    return {
        "en": Typed(en, NUMBER, "coefficient of restitution at vn"),
        "vn": Typed(velocity, VELOCITY, "velocity of en"),
    }


def _yade_naive(setting: Setting) -> tuple[float, float]:
    root = inverse(lambda x: float(mueller_poeschel_restitution(x)), setting.restitution_coefficient, 0.0, 1e3)
    return setting.modulus, root**2 * setting.velocity**-0.2


YADE_MINDLIN = Law(
    **_texts("yade-mindlin"),
    shape=VISCOELASTIC,
    # c = (3/2) A k, A = (2/3) beta (k/m)^(-2/5): e does not depend on the size.
    dashpot=lambda stiffness, mass, radius: stiffness * (stiffness / mass) ** -0.4,
    typed=lambda modulus, strength, setting: elastic(modulus, setting) | yade_restitution(strength, setting.velocity),
    naive=_yade_naive,
)

MUJOCO_SOLREF = Law(
    **_texts("mujoco-solref"),
    shape=LINEAR,
    per_mass=True,
    dashpot=lambda stiffness, mass, radius: mass,
    typed=lambda modulus, strength, setting: {
        "stiffness": Typed(modulus, _STIFFNESS_PER_MASS, "stiffness per mass, typed with a minus"),
        "damping": Typed(strength, DAMPING_PER_MASS, "damping per mass, typed with a minus"),
    },
    # The default solref is "0.02 1": time constant [s] and damping ratio.
    naive=lambda setting: (0.02**-2, 2.0 / 0.02),
)


def _drake_stiffness(modulus: float) -> dict[str, Typed]:
    """Return the stiffness of each of two geometries, which act in series."""
    words = "stiffness of each of the two geometries, which act in series"
    return {"point_contact_stiffness": Typed(2.0 * modulus, _FORCE_PER_LENGTH, words)}


# Defaults of Drake: stiffness of each geometry [N/m], dissipation [s/m], relaxation time of each geometry [s].
_DRAKE_STIFFNESS, _DRAKE_DISSIPATION, _DRAKE_RELAXATION = 1e6, 50.0, 0.1

DRAKE = Law(
    **_texts("drake"),
    shape=HUNT_CROSSLEY,
    dashpot=lambda stiffness, mass, radius: stiffness,
    typed=lambda modulus, strength, setting: (
        _drake_stiffness(modulus)
        | {"hunt_crossley_dissipation": Typed(strength, _SLOWNESS, "dissipation of both geometries")}
    ),
    naive=lambda setting: (0.5 * _DRAKE_STIFFNESS, _DRAKE_DISSIPATION),
)

DRAKE_SAP = Law(
    **_texts("drake-sap"),
    shape=LINEAR,
    # The relaxation times of both geometries add.
    dashpot=lambda stiffness, mass, radius: stiffness,
    typed=lambda modulus, strength, setting: (
        _drake_stiffness(modulus)
        | {"relaxation_time": Typed(0.5 * strength, TIME, "relaxation time of each of the two geometries, which add")}
    ),
    naive=lambda setting: (0.5 * _DRAKE_STIFFNESS, 2.0 * _DRAKE_RELAXATION),
)

LAWS = {
    law.name: law
    for law in (
        LAMMPS_VISCOELASTIC,
        replace(_TSUJI, typed=_tsuji_typed),
        Law(**_lammps("coeff_restitution", "e"), **by_restitution(coefficient_strength, 1e-9, 1.0), shape=CONSTANT),
        MERCURY_BSHP,
        YADE_MINDLIN,
        Law(
            **_texts("liggghts"),
            **by_restitution(coefficient_strength, 0.05 * (1.0 + 1e-9), 1.0),
            shape=CONSTANT,
            naive_end="overlap",
            units=("si", "cgs"),
        ),
        Law(**_texts("kratos-dem"), **by_restitution(thornton_strength, 1e-3, 0.999), shape=CONSTANT),
        MUJOCO_SOLREF,
        DRAKE,
        DRAKE_SAP,
    )
}
"""Laws by the name of the target."""
