"""Memoryless laws of particle codes with cohesion and damping: motion, and the numbers that a user types for them."""

from __future__ import annotations

import math
import tomllib
from collections.abc import Callable
from dataclasses import dataclass
from importlib.resources import files
from typing import Any, Literal, NamedTuple

import numpy as np
from numpy.typing import NDArray

from restitution.calibration.laws import (
    DAMPING,
    DAMPING_PER_MASS,
    Typed,
    coefficient_strength,
    elastic,
    inverse,
    yade_restitution,
)
from restitution.checks import Array
from restitution.units import (
    ENERGY,
    FORCE,
    LENGTH,
    MODULUS,
    NUMBER,
    STIFFNESS,
    SURFACE_ENERGY,
    TIME,
    Dimension,
    Powers,
)

# Motion of a law, scaled such that mass and stiffness k of F = k d^(3/2) are 1, over y = sqrt(a/sqrt(R L)).

Kind = Literal["jkr", "dmt", "sjkr"]
"""Attraction while the bodies touch: JKR, a constant force, or a force in proportion to the overlap."""

Limit = Literal["", "spring", "pull"]
"""What bounds the dashpot: nothing, spring and dashpot together not below 0, or in a pull the constant force."""

# Share of the local time scale in a step of fourth order, and most steps.
_STEP, _MOST = 0.04, 3_000
# Halvings of a step that ends where the dashpot begins to be bounded.
_HALVINGS = 30


class Force(NamedTuple):
    """Form of a law: its attraction, the power of y in the dashpot ``c = b y^q``, and what bounds the dashpot."""

    kind: Kind
    power: int
    limit: Limit


def pull_off(kind: Kind, adhesion: Any) -> Any:
    """Return the largest pull of a law with the adhesion beta of JKR, alpha of DMT or kappa of SJKR, all scaled."""
    if kind == "jkr":
        return 2.25 * adhesion * adhesion
    return adhesion if kind == "dmt" else 4.0 / 27.0 * adhesion**3


def _adhesion(kind: Kind, pull: Any) -> Any:
    """Return the inverse of `pull_off`."""
    if kind == "jkr":
        return np.sqrt(pull / 2.25)
    return pull if kind == "dmt" else np.cbrt(27.0 / 4.0 * pull)


def _ends(kind: Kind, adhesion: Array) -> tuple[Array, Array]:
    """Return y where the bodies touch first and last; with JKR LAMMPS ends a contact at the largest pull."""
    if kind == "jkr":
        return np.cbrt(2.0 * adhesion), np.cbrt(1.5 * adhesion)
    zero = np.zeros_like(adhesion)
    return zero, zero


def _way(kind: Kind, adhesion: Array, y: Array) -> Array:
    """Return d(overlap)/dy; the overlap is y^4 - 2 beta y of JKR, else y^4."""
    return 4.0 * y**3 - (2.0 * adhesion if kind == "jkr" else 0.0)


def _pull(kind: Kind, adhesion: Array, y: Array) -> Array:
    """Return the attraction beside the spring y^6."""
    if kind == "jkr":
        return 3.0 * adhesion * y**3
    return adhesion if kind == "dmt" else adhesion * y**4


def _energy(kind: Kind, adhesion: Array, y: Array) -> Array:
    """Return the work of spring and attraction from y = 0."""
    if kind == "jkr":
        return 0.4 * y**10 - 2.0 * adhesion * y**7 + 1.5 * adhesion**2 * y**4
    return 0.4 * y**10 - (adhesion * y**4 if kind == "dmt" else 0.5 * adhesion * y**8)


def _excess(form: Force, adhesion: Array, loss: Array, y: Array, v: Array) -> Array:
    """Return a number above 0 where the dashpot is bounded."""
    spring, dashed = y**6, loss * y**form.power * v
    if form.limit == "spring":
        return -(spring + dashed)
    if form.limit == "pull":
        return np.minimum(adhesion - spring - dashed, np.abs(dashed) - adhesion)
    return np.full_like(y, -1.0)


class _Lanes(NamedTuple):
    """Moving bodies: adhesion, loss, last y, energy of escape, length of the start, whether the dashpot is bounded."""

    adhesion: Array
    loss: Array
    last: Array
    escape: Array
    start: Array
    bounded: NDArray[np.bool_]

    def take(self, places: NDArray[np.bool_]) -> _Lanes:
        """Return some of the bodies."""
        adhesion, loss, last, escape, start = (column[places] for column in self[:-1])
        return _Lanes(adhesion, loss, last, escape, start, self.bounded[places])


def rebound(form: Force, adhesion: Any, loss: Any, outside: Any, velocity: Any) -> tuple[Array, Array]:
    """Return the coefficient of restitution and the time in touch, scaled, of a law with cohesion.

    `outside` is the work of an attraction beyond touch. A body that sticks has e = 0 and the time NaN; one that does
    not leave within many steps has NaN.
    """
    A, b, out, v0 = (np.array(x, float).ravel() for x in np.broadcast_arrays(adhesion, loss, outside, velocity))
    shape = np.broadcast_shapes(*(np.shape(x) for x in (adhesion, loss, outside, velocity)))
    e, time = np.full(A.size, np.nan), np.full(A.size, np.nan)
    first, last = _ends(form.kind, A)
    state = np.stack([first, np.sqrt(v0 * v0 + 2.0 * out), np.zeros_like(v0)])
    escape, start = _energy(form.kind, A, last) + out, _first_length(form.kind, A, state[1])
    lanes = _Lanes(A, b, last, escape, start, np.zeros(A.size, bool))
    finite = np.isfinite(A)
    place, state, lanes = np.flatnonzero(finite), state[:, finite], lanes.take(finite)
    for _ in range(_MOST):
        if not place.size:
            break
        after, bounded = _stepped(form, lanes, state)
        leaves = (after[0] <= lanes.last) & (after[1] < 0.0)
        if leaves.any():
            speed, moment = _leaving(form, lanes.take(leaves), state[:, leaves])
            left = speed**2 - 2.0 * out[place[leaves]]
            e[place[leaves]] = np.sqrt(np.maximum(left, 0.0)) / v0[place[leaves]]
            time[place[leaves]] = np.where(left > 0.0, moment, np.nan)
        energy = 0.5 * after[1] ** 2 + _energy(form.kind, lanes.adhesion, after[0]) - lanes.escape
        held = ~leaves & (energy < 0.0)
        e[place[held]] = 0.0
        moves = ~(leaves | held)
        place, state = place[moves], after[:, moves]
        lanes = lanes._replace(bounded=bounded).take(moves)
    return e.reshape(shape), time.reshape(shape)


def _first_length(kind: Kind, adhesion: Array, velocity: Array) -> Array:
    """Return y at which the attraction has changed the velocity of first touch."""
    if kind == "jkr":
        return np.zeros_like(adhesion)
    with np.errstate(divide="ignore"):
        length = (velocity**2 / (2.0 * adhesion)) ** 0.25 if kind == "dmt" else (velocity**2 / adhesion) ** 0.125
    # A length of the spring alone.
    return np.minimum(length, (1.25 * velocity**2) ** 0.1)


def _rates(form: Force, lanes: _Lanes, state: Array) -> Array:
    """Return d/ds of y, velocity and time, where ds = dt dy/dx: all smooth where the overlap is not."""
    y, v = np.maximum(state[0], 0.0), state[1]
    way, spring, pull = _way(form.kind, lanes.adhesion, y), y**6, _pull(form.kind, lanes.adhesion, y)
    dashed = lanes.loss * y**form.power * v
    if form.limit == "spring":
        dashed = np.where(lanes.bounded, -spring, dashed)
    elif form.limit == "pull":
        dashed = np.where(lanes.bounded, np.copysign(lanes.adhesion, dashed), dashed)
    return np.stack([v, -(spring - pull + dashed) * way, way])


def _pace(form: Force, lanes: _Lanes, state: Array) -> Array:
    """Return a step in s from the velocity, the force and the dashpot."""
    y, v, _ = state
    length = y + lanes.start
    _, push, way = _rates(form, lanes, state)
    dashed = lanes.loss * np.maximum(y, 0.0) ** form.power * way
    return _STEP / np.sqrt((v / length) ** 2 + np.abs(push) / length + dashed**2)


def _step(form: Force, lanes: _Lanes, state: Array, step: Array) -> Array:
    """Return the state after a step by the classical method of Runge and Kutta."""
    first = _rates(form, lanes, state)
    second = _rates(form, lanes, state + 0.5 * step * first)
    third = _rates(form, lanes, state + 0.5 * step * second)
    fourth = _rates(form, lanes, state + step * third)
    return state + step / 6.0 * (first + 2.0 * second + 2.0 * third + fourth)


def _stepped(form: Force, lanes: _Lanes, state: Array) -> tuple[Array, NDArray[np.bool_]]:
    """Return the states after a step, which ends where the dashpot begins or ceases to be bounded, and which it is."""
    step = _pace(form, lanes, state)
    after = _step(form, lanes, state, step)
    if not form.limit:
        return after, lanes.bounded

    def excess(at: Array, bodies: _Lanes) -> Array:
        return _excess(form, bodies.adhesion, bodies.loss, np.maximum(at[0], 0.0), at[1])

    changes = (excess(after, lanes) > 0.0) != lanes.bounded
    changes &= after[0] > lanes.last
    if changes.any():
        few, before, longest = lanes.take(changes), state[:, changes], step[changes]
        low, high = np.zeros_like(longest), longest
        for _ in range(_HALVINGS):
            middle = 0.5 * (low + high)
            same = (excess(_step(form, few, before, middle), few) > 0.0) == few.bounded
            low, high = np.where(same, middle, low), np.where(same, high, middle)
        after[:, changes] = _step(form, few, before, high)
    return after, lanes.bounded ^ changes


def _leaving(form: Force, lanes: _Lanes, state: Array) -> tuple[Array, Array]:
    """Return the velocity and the time where y reaches its last value, by steps that end there."""
    for _ in range(4):
        ahead = (lanes.last - state[0]) / np.minimum(state[1], -1e-300)
        longest = 2.0 * _pace(form, lanes, state)
        state = _step(form, lanes, state, np.clip(ahead, -longest, longest))
    return state[1], state[2]


# Laws of codes: what is typed, from the numbers of a contact.

_ENERGY_DENSITY = Dimension("energy per volume", "J/m^3", powers=Powers(1, -1, -2))
# Outer over inner cutoff of the attraction of MFiX.
_CUTOFF = 10.0


class Contact(NamedTuple):
    """The contact for which numbers are typed, in SI, and what a user without this package has for it."""

    velocity: float  # in the middle of those that rebound
    mass: float  # reduced
    radius: float  # reduced
    poisson_ratio: float
    work: float  # of adhesion
    reach: float  # of the attraction
    modulus: float  # storage part of E*
    retardation_time: float  # loss tangent over frequency
    restitution_coefficient: float
    contact_time: float


@dataclass(frozen=True)
class TypedAdhesive:
    """Law with cohesion and its numbers.

    Attributes
    ----------
    law : AdhesiveLaw
        Its form.
    modulus, pull_off_force, damping : float
        E* [Pa] of the spring, largest pull [N], and C of the dashpot ``C a^(q/2) v`` with the contact radius a.
    contact : Contact
        The bodies.
    """

    law: AdhesiveLaw
    modulus: float
    pull_off_force: float
    damping: float
    contact: Contact

    @property
    def stiffness(self) -> float:
        """Stiffness k of k d^(3/2)."""
        return stiffness(self.modulus, self.contact.radius)

    def rebound(self, velocity: Any, mass: Any = None, radius: Any = None) -> tuple[Array, Array]:
        """Return the coefficient of restitution [-] and the time in touch [s], NaN of a body that sticks.

        The bodies are those of the contact, whatever mass and radius are given.
        """
        shape = np.broadcast_shapes(*(np.shape(x) for x in (velocity, mass, radius) if x is not None))
        speeds = np.broadcast_to(np.asarray(velocity, dtype=np.float64), shape)
        unit = float(np.max(speeds))
        adhesion, loss, length = self.scaled(unit)
        outside = self.law.outside(pull_off(self.law.form.kind, adhesion), self.contact.reach / length)
        e, time = rebound(self.law.form, adhesion, loss, outside, speeds / unit)
        return e, time * (length / unit)

    def scaled(self, velocity: float) -> tuple[float, float, float]:
        """Return adhesion and loss, scaled by a velocity [m/s], and the length [m] of 1."""
        length, force = units(self.stiffness, self.contact.mass, velocity)
        width = math.sqrt(self.contact.radius * length)
        loss = self.damping * width ** (0.5 * self.law.form.power) * velocity / force
        return float(_adhesion(self.law.form.kind, self.pull_off_force / force)), loss, length


def stiffness(modulus: float, radius: float) -> float:
    """Return k [N/m^(3/2)] of Hertz' force k d^(3/2)."""
    return 4.0 / 3.0 * modulus * math.sqrt(radius)


def units(stiffness: float, mass: float, velocity: float) -> tuple[float, float]:
    """Return the length [m] and the force [N] of 1 where stiffness, mass and velocity are 1."""
    length = (mass * velocity**2 / stiffness) ** 0.4
    return length, mass * velocity**2 / length


def typed_adhesive(law: AdhesiveLaw, numbers: tuple[float, float, float], contact: Contact) -> TypedAdhesive:
    """Return a law from the length [m] of 1 at the velocity of the contact, the adhesion and the loss, scaled."""
    length, adhesion, loss = numbers
    force = contact.mass * contact.velocity**2 / length
    k = force / length**1.5
    width = math.sqrt(contact.radius * length)
    damping = loss * force / contact.velocity / width ** (0.5 * law.form.power)
    pull = force * float(pull_off(law.form.kind, adhesion))
    return TypedAdhesive(law, 0.75 * k / math.sqrt(contact.radius), pull, damping, contact)


@dataclass(frozen=True, kw_only=True)
class AdhesiveLaw:
    """Law of a code with cohesion.

    Attributes
    ----------
    name, words, source : str
        Name of the target, code and model, and the pages that define it.
    form : Force
        Spring, attraction and dashpot.
    typed : callable
        What a user types, by the name in the code.
    usual : callable
        C of what a user without this package types.
    pair, wall : str
        Text to paste for two balls, and for a ball and a wall, which is empty if the code has no such contact.
    largest_loss : float
        Largest scaled loss that can be typed.
    outside : callable
        Scaled work of the attraction beyond touch, from the scaled pull and range.
    comment, units, notes, rough
        As of `laws.Law`.
    """

    name: str
    words: str
    source: str
    form: Force
    typed: Callable[[TypedAdhesive], dict[str, Typed]]
    usual: Callable[[Contact], float]
    pair: str
    wall: str
    largest_loss: float = 8.0
    outside: Callable[[Any, float], Any] = lambda pull, reach: 0.0 * pull
    comment: str = "# {}"
    units: tuple[str, ...] = ("si",)
    notes: tuple[str, ...] = ()
    rough: tuple[tuple[str, str], ...] = ()

    def __reduce__(self) -> Any:
        return _registered, (self.name,)

    def naive(self, contact: Contact) -> TypedAdhesive:
        """Return the storage modulus, the pull of the work of adhesion and the usual damping."""
        shape = 2.0 if self.form.kind == "dmt" else 1.5
        pull = shape * math.pi * contact.work * contact.radius
        return TypedAdhesive(self, contact.modulus, pull, self.usual(contact), contact)


def _registered(name: str) -> AdhesiveLaw:
    """Return the law of a target, for the pickle of a result."""
    return ADHESIVE_LAWS[name]


def _kelvin_voigt(contact: Contact) -> float:
    """Return C of the dashpot (3/2) A k d^(1/2) v with the retardation time A."""
    return 1.5 * contact.retardation_time * stiffness(contact.modulus, contact.radius) / math.sqrt(contact.radius)


def _halved(contact: Contact) -> float:
    """Return C of a constant dashpot with which a linear spring has e in half a period of the contact time."""
    return -2.0 * contact.mass * math.log(contact.restitution_coefficient) / contact.contact_time


def _by_restitution(strength_of: Callable[[float], float]) -> Callable[[Contact], float]:
    """Return the usual C of a dashpot s sqrt(m k) d^(1/4) v with s from the coefficient of restitution."""

    def usual(contact: Contact) -> float:
        e = min(max(contact.restitution_coefficient, 0.06), 1.0)
        k = stiffness(contact.modulus, contact.radius)
        return strength_of(e) * math.sqrt(contact.mass * k) / contact.radius**0.25

    return usual


def _strength(numbers: TypedAdhesive) -> float:
    """Return s of the dashpot s sqrt(m k) d^(1/4) v."""
    return numbers.damping * numbers.contact.radius**0.25 / math.sqrt(numbers.contact.mass * numbers.stiffness)


def _retardation(numbers: TypedAdhesive) -> float:
    """Return A [s] of the dashpot (3/2) A k d^(1/2) v."""
    return numbers.damping * math.sqrt(numbers.contact.radius) / (1.5 * numbers.stiffness)


def _surface_energy(numbers: TypedAdhesive) -> Typed:
    """Return gamma of the pulls 3 pi gamma R of JKR and 4 pi gamma R of DMT: half the work of adhesion."""
    factor = 4.0 if numbers.law.form.kind == "dmt" else 3.0
    value = numbers.pull_off_force / (factor * math.pi * numbers.contact.radius)
    return Typed(value, SURFACE_ENERGY, "surface energy, half a work of adhesion")


def _young(numbers: TypedAdhesive) -> dict[str, Typed]:
    return elastic(numbers.modulus, numbers.contact)


def _lammps(kind: Kind, damping: str) -> AdhesiveLaw:
    """Return a law of LAMMPS: the models of damping that it has with JKR and DMT."""
    power = 0 if damping == "mass_velocity" else 2
    dimension = DAMPING if power else DAMPING_PER_MASS

    def typed(numbers: TypedAdhesive) -> dict[str, Typed]:
        eta = Typed(numbers.damping / numbers.contact.mass, dimension, "damping coefficient")
        return _young(numbers) | {"eta_n0": eta, "gamma": _surface_energy(numbers)}

    model = f"{kind} {{E}} {{eta_n0}} {{nu}} {{gamma}} tangential linear_nohistory 0 0 damping {damping}"
    return AdhesiveLaw(
        name=f"lammps-{kind}-{damping.replace('_', '-')}",
        words=f"LAMMPS, pair_style granular, {kind}, damping {damping}",
        source="LAMMPS documentation (version 22Jul2025), pages pair_style granular and fix wall/gran",
        form=Force(kind, power, ""),
        # A constant dashpot above critical damping holds the bodies for ever.
        largest_loss=8.0 if power else 2.0,
        typed=typed,
        usual=_kelvin_voigt if power else _halved,
        pair=f"pair_style granular\npair_coeff * * {model}",
        wall=f"fix wall all wall/gran granular {model} zplane 0 NULL",
        units=("si", "cgs", "micro", "lj"),
        notes=("gamma and eta_n0 belong to this size",),
    )


_TEXTS: dict[str, dict[str, Any]] = tomllib.loads(
    files("restitution.calibration").joinpath("adhesive_codes.toml").read_text(encoding="utf-8")
)


def _texts(name: str) -> dict[str, Any]:
    """Return the arguments of a law that are texts."""
    text = _TEXTS[name] | {"name": name, "notes": tuple(_TEXTS[name].get("notes", ()))}
    line = text.pop("wall_line", None)
    return text | {"wall": "" if line is None else f"{text['pair']}\n{line}".rstrip("\n")}


def _liggghts(numbers: TypedAdhesive) -> dict[str, Typed]:
    e = inverse(coefficient_strength, _strength(numbers), _LEAST_LIGGGHTS, 1.0)
    # The largest pull of k d^(3/2) - p d is 4 p^3/(27 k^2), and p is 2 pi R times the density.
    slope = (6.75 * numbers.pull_off_force * numbers.stiffness**2) ** (1.0 / 3.0)
    density = slope / (2.0 * math.pi * numbers.contact.radius)
    return _young(numbers) | {
        "e": Typed(e, NUMBER, "coefficient of restitution of the contact without cohesion, as typed"),
        "cohesion": Typed(density, _ENERGY_DENSITY, "cohesion energy density"),
    }


# LIGGGHTS refuses a coefficient of restitution of 0.05 and less.
_LEAST_LIGGGHTS = 0.05 * (1.0 + 1e-9)


def _mercury(numbers: TypedAdhesive) -> dict[str, Typed]:
    pull = numbers.pull_off_force
    return {
        "E_eff": Typed(numbers.modulus, MODULUS, "effective elastic modulus"),
        "A": Typed(_retardation(numbers), TIME, "dissipation"),
        "f_max": Typed(pull, FORCE, "largest adhesion"),
        "k_a": Typed(pull / numbers.contact.reach, STIFFNESS, "adhesion stiffness: f_max over the range"),
    }


def _yade(numbers: TypedAdhesive) -> dict[str, Typed]:
    contact = numbers.contact
    # beta = (3/2) A (k/m)^(2/5).
    beta = 1.5 * _retardation(numbers) * (numbers.stiffness / contact.mass) ** 0.4
    return _young(numbers) | yade_restitution(beta, contact.velocity) | {"gamma": _surface_energy(numbers)}


def mfix_strength(e: float) -> float:
    """Return the damping of MFiX, that of a linear spring: -2 ln e/sqrt(pi^2 + ln^2 e)."""
    return -2.0 * math.log(e) / math.hypot(math.pi, math.log(e))


def _mfix(numbers: TypedAdhesive) -> dict[str, Typed]:
    reach, radius = numbers.contact.reach, numbers.contact.radius
    e = inverse(mfix_strength, _strength(numbers), 1e-3, 1.0)
    # The pull at the inner cutoff D is A R/(6 D^2) of the reduced radius R.
    hamaker = 6.0 * reach**2 * numbers.pull_off_force / radius
    return _young(numbers) | {
        "e": Typed(e, NUMBER, "coefficient of restitution, as typed"),
        "hamaker": Typed(hamaker, ENERGY, "Hamaker constant"),
        "inner": Typed(reach, LENGTH, "inner cutoff, the range of the attraction"),
        "outer": Typed(_CUTOFF * reach, LENGTH, "outer cutoff"),
    }


ADHESIVE_LAWS = {
    law.name: law
    for law in (
        *(_lammps(kind, damping) for kind in ("jkr", "dmt") for damping in ("viscoelastic", "mass_velocity")),
        AdhesiveLaw(
            **_texts("liggghts-sjkr"),
            form=Force("sjkr", 1, "spring"),
            typed=_liggghts,
            usual=_by_restitution(coefficient_strength),
            largest_loss=coefficient_strength(_LEAST_LIGGGHTS),
            units=("si", "cgs"),
        ),
        AdhesiveLaw(
            **_texts("mercury-adhesive"),
            form=Force("dmt", 2, "spring"),
            typed=_mercury,
            usual=_kelvin_voigt,
            # A pull that falls linearly to zero over the range, as that of a rigid ball with Dugdale's law.
            outside=lambda pull, reach: 0.5 * pull * reach,
        ),
        AdhesiveLaw(**_texts("yade-dmt"), form=Force("dmt", 2, "pull"), typed=_yade, usual=_kelvin_voigt),
        AdhesiveLaw(
            **_texts("mfix"),
            form=Force("dmt", 1, ""),
            typed=_mfix,
            usual=_by_restitution(mfix_strength),
            largest_loss=mfix_strength(1e-3),
            # Constant up to the inner cutoff, then as 1/d^2 up to the outer one.
            outside=lambda pull, reach: pull * reach * (2.0 - 1.0 / _CUTOFF),
        ),
    )
}
"""Laws with cohesion by the name of the target."""
