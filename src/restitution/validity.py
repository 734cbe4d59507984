"""The assumptions of the theory, each compared with its limit: the validity report of a result.

A number for each assumption and each impact comes from `numbers`; `report` reads the worst of them, writes one line
for each and adds what to do. The limits are at the top of this file, with the reasons in `docs/theory/limits.md`.
"""

from __future__ import annotations

import html
import math
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import asdict, dataclass
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from restitution.checks import Numeric
from restitution.contact.contact import Contact
from restitution.contact.profile import Parabola
from restitution.contact.radiation import radiated
from restitution.contact.sphere import Sphere, sphere_mass
from restitution.material.conversion import bulk_factor, poisson_ratio
from restitution.quantities import VALIDITY

Array = NDArray[np.float64]
Threshold = float | tuple[float, float]
COLUMNS = ("max_contact_radius", "max_indentation_depth", "contact_time", "max_force")
"""Outputs of an impact that the report takes; it also takes the velocity and the mass."""

_TITLES = {
    "small_strain": "small strain", "half_space": "half-space", "waves": "waves",
    "window": "window", "poisson_ratio": "Poisson ratio", "density": "density",
}  # fmt: skip

# Representative strain 0.2 a/R = 4 % (Tabor 1951); an exact sphere is there 0.4 % softer than its parabola.
STRAIN_LIMIT = 0.2
# A bonded incompressible layer of thickness h is then 6 % stiffer than a half-space.
SIZE_LIMIT = 0.05
# Share of the energy that waves carry away; e falls by half of it at most.
RADIATION_LIMIT = 0.05
# Velocity over wave speed, where no mass is known.
SPEED_LIMIT = 0.01
# From below any foam to above osmium. Two equal balls have four times their density by reduced mass and radius.
DENSITY_LIMITS = (1.0, 3e4)
_PAIR = 4.0
# A contact resembles half a period, omega = pi/T: times near T/3, which is d/v0. Its beginning is three times faster.
_RISE_SHARE = 1.0 / 3.0
# Contact time of a Hertz impact over d/v0: (4/5) sqrt(pi) Gamma(2/5)/Gamma(9/10).
_HERTZ_TIME = 2.9432751843247043


@dataclass(frozen=True)
class Check:
    """An assumption beside its limit.

    Attributes
    ----------
    kind, words : str
        `small_strain`, `half_space`, `waves`, `window`, `poisson_ratio` or `density`, and the number that is compared.
    value : float or None
        Its worst value; None where it could not be checked.
    threshold : float or tuple of float
        Limit; a range for the density.
    exceeded : bool
        Whether the assumption is doubtful.
    message : str
        One line with the numbers.
    advice : str
        What to do.
    """

    kind: str
    words: str
    value: float | None
    threshold: Threshold
    exceeded: bool
    message: str
    advice: str


@dataclass(frozen=True)
class Validity:
    """Validity report: every assumption of the theory beside its limit.

    Attributes
    ----------
    checks : tuple of Check
        One for each assumption. Iterating over the report gives them too.

    Examples
    --------
    >>> from restitution.material.viscoelastic import Material
    >>> contact = Contact(Material(1e6, bulk=2e9, density=1100.0), Parabola(0.01))
    >>> columns = {"max_contact_radius": 1e-3, "max_indentation_depth": 1e-4, "velocity": 1.0, "contact_time": 3e-4}
    >>> report = validity(contact, **columns, body_size=0.03)
    >>> print(report)
    assumption           value         limit
    small strain           0.1           0.2  ok
    half-space          0.0333          0.05  ok
    waves               0.0332          0.01  DOUBTFUL
    window                   -             1  not checked
    Poisson ratio          0.5             0  ok
    density                  -    1 to 30000  not checked
    waves: velocity over shear wave speed is 0.0332 (> 0.01), c = 30.2 m/s
      Expect a lower rebound where the target is deep; take a lower velocity.
    >>> report["waves"].value > report["waves"].threshold
    True
    """

    checks: tuple[Check, ...]

    def __iter__(self) -> Iterator[Check]:
        """Iterate over the checks."""
        return iter(self.checks)

    def __getitem__(self, kind: str) -> Check:
        """Return the check of a kind."""
        for check in self.checks:
            if check.kind == kind:
                return check
        raise KeyError(kind)

    @property
    def warnings(self) -> list[str]:
        """Messages of the assumptions that are doubtful."""
        return [check.message for check in self.checks if check.exceeded]

    def to_dict(self) -> dict[str, dict[str, Any]]:
        """Return the report as plain numbers and texts, by kind."""
        return {check.kind: {k: v for k, v in asdict(check).items() if k != "kind"} for check in self.checks}

    @classmethod
    def from_dict(cls, checks: dict[str, dict[str, Any]]) -> Validity:
        """Return the report of which `to_dict` returned the content."""
        kinds: list[Any] = [{"kind": kind, **check} for kind, check in checks.items()]
        for check in kinds:
            if isinstance(check["threshold"], list):
                check["threshold"] = tuple(check["threshold"])
        return cls(tuple(Check(**check) for check in kinds))

    def __str__(self) -> str:
        """Return the report as a table, with advice on what is doubtful."""
        rows = (("assumption", "value", "limit", ""), *map(_row, self.checks))
        lines = ["{:14}{:>12}{:>14}  {}".format(*row).rstrip() for row in rows]
        notes = [f"{check.message}\n  {check.advice}" for check in self.checks if check.exceeded]
        return "\n".join([*lines, *notes])

    def _repr_html_(self) -> str:
        heads = "".join(f"<th>{word}</th>" for word in ("assumption", "value", "limit", "", "numbers", "advice"))
        rows = [[*_row(check), check.message, check.advice] for check in self.checks]
        cells = ("".join(f"<td>{html.escape(cell)}</td>" for cell in row) for row in rows)
        return f"<table><tr>{heads}</tr>{''.join(f'<tr>{row}</tr>' for row in cells)}</table>"


class Numbers(NamedTuple):
    """What the report compares, one value for each contact, NaN where it is not known.

    The first seven are the quantities `restitution.quantities.VALIDITY`. The others are for the messages: flags as 0 and
    1, times [s], the static Poisson ratio of the same body, and how much denser than its material a ball of the reduced
    mass and radius may be.
    """

    strain_number: Array
    contact_size_ratio: Array
    mach_number: Array
    radiated_energy_ratio: Array
    window_ratio: Array
    instantaneous_poisson_ratio: Array
    mean_density: Array
    round_body: Array
    no_such_contact: Array
    contact_time: Array
    shortest_time: Array
    wave_speed: Array
    window_low: Array
    window_high: Array
    density_factor: Array
    poisson_ratio: Array
    density_missing: Array


def validity(contact: Contact, **columns: ArrayLike) -> Validity:
    """Compare the assumptions of the theory with the worst of one or more contacts.

    Parameters
    ----------
    contact : Contact
        Materials and profile.
    **columns : float or array
        As in `numbers`: `max_contact_radius`, `max_indentation_depth`, `velocity`, `contact_time`, and where they are
        known `mass`, `max_force` and `body_size`.
    """
    return report(numbers(contact, **columns))


def numbers(
    contact: Contact | Sequence[Contact],
    *,
    max_contact_radius: ArrayLike,
    max_indentation_depth: ArrayLike,
    velocity: ArrayLike,
    contact_time: ArrayLike,
    mass: ArrayLike = math.nan,
    max_force: ArrayLike = math.nan,
    body_size: ArrayLike = math.nan,
) -> Numbers:
    """Return the numbers that the report compares, for each contact.

    Parameters
    ----------
    contact : Contact, or sequence of Contact
        Materials and profile of all contacts, or of each in turn.
    max_contact_radius, max_indentation_depth : float or array
        Largest contact radius a and depth d [m]; NaN where a contact was not solved.
    velocity : float or array
        Impact velocity v0 [m/s]; of an indentation its largest speed.
    contact_time : float or array
        Duration T [s] of the contact; infinite where it has no end.
    mass, max_force : float or array, optional
        Mass [kg] and largest force F [N], for the energy in waves and the density.
    body_size : float or array, optional
        Smallest dimension h [m] of the target, such as the thickness of a layer.

    Notes
    -----
    Small strain: max(a/R, d/a) (Tabor 1951). Half-space: a/h. Waves: see `restitution.contact.radiation`. Window: the
    times from a third of d/v0, some T/10, to T.
    """
    contacts = [contact] if isinstance(contact, Contact) else contact
    radius, depth, speed, time, mass, force, size, tip = (
        np.asarray(column, dtype=np.float64).reshape(-1)
        for column in np.broadcast_arrays(
            max_contact_radius, max_indentation_depth, velocity, contact_time, mass, max_force, body_size,
            _tip_radius(contact) if isinstance(contact, Contact) else [float(_tip_radius(one)) for one in contact],
        )
    )  # fmt: skip
    wave_speed, wave_energy, low, high, instantaneous, static, factor, missing = np.full((8, time.size), math.nan)
    rows: dict[tuple[int, ...], list[int]] = {}
    for n, one in enumerate(contacts):
        rows.setdefault(tuple(map(id, one.materials)), []).append(n)
    with np.errstate(all="ignore"):
        rise = depth / speed
        time = np.where(np.isposinf(time), _HERTZ_TIME * rise, time)
        shortest = np.fmin(_RISE_SHARE * rise, time)
        for own in rows.values():
            here = slice(None) if len(rows) == 1 else own
            one = contacts[own[0]]
            wave_speed[here], wave_energy[here] = radiated(one.materials, time[here], force[here])
            low[here], high[here] = one.window or (math.nan, math.nan)
            least = min(one.materials, key=lambda material: material.instantaneous_poisson_ratio)
            instantaneous[here], static[here] = least.instantaneous_poisson_ratio, least.poisson_ratio
            factor[here] = _PAIR if len(one.materials) > 1 else 1.0
            missing[here] = any(material.density is None for material in one.materials)
        return Numbers(
            strain_number=np.fmax(radius / tip, depth / radius),
            contact_size_ratio=radius / size,
            mach_number=speed / wave_speed,
            radiated_energy_ratio=np.minimum(wave_energy / (0.5 * mass * speed**2), 1.0),
            window_ratio=np.maximum(low / shortest, time / high),
            instantaneous_poisson_ratio=np.where(np.isnan(time), math.nan, instantaneous),
            mean_density=mass / sphere_mass(1.0, tip),
            round_body=np.isfinite(tip).astype(np.float64),
            no_such_contact=((radius > tip) | (depth > tip)).astype(np.float64),
            contact_time=time,
            shortest_time=shortest,
            wave_speed=wave_speed,
            window_low=low,
            window_high=high,
            density_factor=factor,
            poisson_ratio=static,
            density_missing=missing,
        )


def _tip_radius(contact: Contact) -> Numeric:
    return contact.profile.radius if isinstance(contact.profile, (Parabola, Sphere)) else math.nan


def of_standard_solid(static_poisson_ratio: Array, p2: Array) -> Numbers:
    """Return the numbers of standard solids without dimensions: both Poisson ratios."""
    unknown = np.full(p2.shape, math.nan)
    bulk = np.vectorize(bulk_factor, otypes=[float])(static_poisson_ratio)
    instantaneous = np.vectorize(poisson_ratio, otypes=[float])(1.0 + 1.0 / p2, bulk)
    numbers = Numbers(*(unknown for _ in Numbers._fields))
    return numbers._replace(poisson_ratio=static_poisson_ratio, instantaneous_poisson_ratio=instantaneous)


def columns(numbers: Numbers) -> dict[str, Array]:
    """Return the numbers of each impact as the quantities that a sweep stores."""
    return {name: getattr(numbers, name) for name in VALIDITY}


def together(parts: Iterable[Numbers]) -> Numbers:
    """Return the numbers of several contacts as those of one list."""
    return Numbers(*(np.concatenate(one) for one in zip(*parts, strict=True)))


def report(numbers: Numbers) -> Validity:
    """Return the report on the worst of the impacts."""
    checks = (_small_strain, _half_space, _waves, _window, _poisson_ratio, _density)
    return Validity(tuple(check(numbers) for check in checks))


def _small_strain(numbers: Numbers) -> Check:
    beyond = numbers.no_such_contact > 0.0
    worst = _worst(np.where(beyond, 1e30, 1.0) * numbers.strain_number)
    if worst is None:
        return _unchecked("small_strain", "strain_number", STRAIN_LIMIT, "no contact radius is known")
    value, is_round = numbers.strain_number[worst], numbers.round_body[worst] > 0.0
    text = f"{'max(a/R, d/a)' if is_round else 'd/a'} reaches {value:.3g} ({_sign(value, STRAIN_LIMIT)})"
    advice = "Take a lower velocity or a larger body, or read the numbers as a trend."
    if beyond[worst]:
        text += "; a body of this radius has no such contact"
        advice = "Discard the result: the contact radius, or the depth, exceeds the radius of the body."
    elif is_round:
        text += f", a representative strain of about {20 * value:.2g} %"
    return _check("small_strain", "strain_number", value, STRAIN_LIMIT, value > STRAIN_LIMIT, text, advice)


def _half_space(numbers: Numbers) -> Check:
    worst = _worst(numbers.contact_size_ratio)
    if worst is None:
        reason = "no size of the target is given"
        return _unchecked("half_space", "contact_size_ratio", SIZE_LIMIT, reason)
    value = numbers.contact_size_ratio[worst]
    # Expansion for a parabola on a bonded incompressible layer; the exact factor at 0.5 is 2.156.
    excess = 112.70 * value + 148.17 * value**2 + 147.0 * value**3 + 100.5 * value**4
    stiffer = f"{excess:.2g} %" if value <= 0.5 else "more than 100 %"
    text = f"contact radius over size of the target reaches {value:.3g} ({_sign(value, SIZE_LIMIT)}), "
    text += f"a bonded incompressible layer would be {stiffer} stiffer"
    advice = "Take a thicker target, or read the result as that of a thick one."
    return _check("half_space", "contact_size_ratio", value, SIZE_LIMIT, value > SIZE_LIMIT, text, advice)


def _waves(numbers: Numbers) -> Check:
    name, limit = "radiated_energy_ratio", RADIATION_LIMIT
    worst = _worst(numbers.radiated_energy_ratio)
    if worst is None:
        name, limit, worst = "mach_number", SPEED_LIMIT, _worst(numbers.mach_number)
    if worst is None:
        return _unchecked("waves", "radiated_energy_ratio", RADIATION_LIMIT, "no density is given")
    value, mach, speed = getattr(numbers, name)[worst], numbers.mach_number[worst], numbers.wave_speed[worst]
    # The other body may have the slower waves.
    if value <= limit and numbers.density_missing.any():
        return _unchecked("waves", name, limit, "the density of a material is missing")
    text = f"{VALIDITY[name].words} is {value:.3g} ({_sign(value, limit)}), "
    text += f"c = {speed:.3g} m/s" if name == "mach_number" else f"v0/c = {mach:.3g} with c = {speed:.3g} m/s"
    advice = "Expect a lower rebound where the target is deep; take a lower velocity."
    return _check("waves", name, value, limit, value > limit, text, advice)


def _window(numbers: Numbers) -> Check:
    worst = _worst(numbers.window_ratio)
    if worst is None:
        return _unchecked("window", "window_ratio", 1.0, "no material states its window")
    value = numbers.window_ratio[worst]
    columns = (numbers.contact_time, numbers.shortest_time, numbers.window_low, numbers.window_high)
    time, shortest, low, high = (column[worst] for column in columns)
    text = f"the contact lasts {time:.3g} s and its beginning {shortest:.3g} s, "
    text += f"the material is known from {low:.3g} s to {high:.3g} s"
    advice = "Measure at these times, or shift data of other temperatures; the modulus is extrapolated."
    return _check("window", "window_ratio", value, 1.0, value > 1.0, text, advice)


def _poisson_ratio(numbers: Numbers) -> Check:
    name = "instantaneous_poisson_ratio"
    worst = _worst(-numbers.instantaneous_poisson_ratio)
    if worst is None:
        return _unchecked("poisson_ratio", name, 0.0, "no contact was solved")
    value, static = numbers.instantaneous_poisson_ratio[worst], numbers.poisson_ratio[worst]
    # A negative static one is a choice.
    exceeded = value < min(static, 0.0)
    text = f"static {static:.4g}, instantaneous {value:.3g} ({'<' if exceeded else '>='} {min(static, 0.0):.3g}), "
    text += f"K/G0 = {bulk_factor(value):.3g}"
    advice = "Raise the bulk modulus or lower the instantaneous shear modulus; polymers have 0.3 to 0.4."
    return _check("poisson_ratio", name, value, 0.0, exceeded, text, advice)


def _density(numbers: Numbers) -> Check:
    low, high = DENSITY_LIMITS
    highest = high * numbers.density_factor
    with np.errstate(divide="ignore"):  # a product that underflows is a density of zero
        worst = _worst(np.maximum(low / numbers.mean_density, numbers.mean_density / highest))
    if worst is None:
        return _unchecked("density", "mean_density", DENSITY_LIMITS, "the body is no ball of a known mass")
    value, limits = numbers.mean_density[worst], (low, float(highest[worst]))
    exceeded = not low <= value <= limits[1]
    text = f"a ball of this mass and radius has {value:.3g} kg/m3 "
    text += f"({'outside' if exceeded else 'within'} {low:g} to {limits[1]:g})"
    advice = "Compare the units of mass (kg) and radius (m), unless a heavy body with a small tip is meant."
    return _check("density", "mean_density", value, limits, exceeded, text, advice)


def _check(kind: str, name: str, value: float, threshold: Threshold, exceeded: Any, text: str, advice: str) -> Check:
    message = f"{_TITLES[kind]}: {text}"
    return Check(kind, VALIDITY[name].words, float(value), threshold, bool(exceeded), message, advice)


def _unchecked(kind: str, name: str, threshold: Threshold, reason: str) -> Check:
    message = f"{_TITLES[kind]}: not checked, {reason}"
    return Check(kind, VALIDITY[name].words, None, threshold, False, message, "")


def _sign(value: float, limit: float) -> str:
    return f"{'>' if value > limit else '<='} {limit:g}"


def _worst(values: Array) -> int | None:
    """Index of the largest value; None where there is none."""
    known = ~np.isnan(values)
    return int(np.argmax(np.where(known, values, -np.inf))) if known.any() else None


def _row(check: Check) -> tuple[str, str, str, str]:
    limit = check.threshold
    shown = " to ".join(f"{one:g}" for one in limit) if isinstance(limit, tuple) else f"{limit:g}"
    value = "-" if check.value is None else f"{check.value:.3g}"
    state = "DOUBTFUL" if check.exceeded else "ok" if check.value is not None else "not checked"
    return _TITLES[check.kind], value, shown, state
