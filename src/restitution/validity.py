"""The assumptions of the theory beside their limits, for which `docs/theory/limits.md` gives the reasons."""

from __future__ import annotations

import html
import math
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import asdict, dataclass
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from restitution.contact.analytic import sphere_mass
from restitution.contact.contact import Contact, approximation
from restitution.contact.radiation import radiated
from restitution.quantities import VALIDITY

Array = NDArray[np.float64]
Threshold = float | tuple[float, float]
COLUMNS = (
    "max_contact_radius", "max_indentation_depth", "contact_time", "max_force",
    "restitution_coefficient", "residual_indentation_depth",
)  # fmt: skip
"""Outputs of an impact that the report takes; it also takes the velocity and the mass."""

# Bodies that deform; `Numbers.wave_body` is a place here. The first is a target under a rigid body.
_BODIES = "target", "target", "layer", "ball", "first ball", "second ball", "indenter"
_BESIDE_RIGID, _TARGET, _LAYER, _BALL, _, _, _INDENTER = range(len(_BODIES))
_TITLES = {
    "small_strain": "small strain", "half_space": "half-space", "waves": "waves",
    "window": "window", "poisson_ratio": "Poisson ratio", "density": "density", "separability": "separability",
    "constants": "constants",
}  # fmt: skip

# Representative strain 0.2 a/R = 4 % (Tabor 1951); an exact sphere is there 0.4 % softer than its parabola.
STRAIN_LIMIT = 0.2
# Largest shear strain over a/R = d/a, in an incompressible half-space under a parabola.
_SHEAR = 0.7
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
# Constants that are not determined: some, or all moduli and times but for a common scale.
_SOME, _SCALE = 1.0, 2.0
# Contact time of a Hertz impact over d/v0: (4/5) sqrt(pi) Gamma(2/5)/Gamma(9/10).
_HERTZ_TIME = 2.9432751843247043


@dataclass(frozen=True)
class Check:
    """An assumption beside its limit.

    Attributes
    ----------
    kind : str
        `small_strain`, `half_space`, `waves`, `window`, `poisson_ratio`, `density`, or if in doubt `separability` or
        `constants`.
    words, value, threshold : str, float or None, float or tuple of float
        The number that is compared, its worst value (None if it is not known), and its limit, a range for the density.
    exceeded : bool
        Whether the assumption is doubtful.
    message, advice : str
        One line with the numbers, and what to do.
    """

    kind: str
    words: str
    value: float | None
    threshold: Threshold
    exceeded: bool
    message: str
    advice: str

    @property
    def warning(self) -> str:
        """The message and the advice in one line."""
        return f"{self.message}. {self.advice}"


@dataclass(frozen=True)
class Validity:
    """Validity report: every assumption of the theory beside its limit.

    Attributes
    ----------
    checks : tuple of Check
        One for each assumption; iterating over the report gives them too.

    Examples
    --------
    >>> from restitution.contact.profile import Parabola
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
    waves: velocity over shear wave speed is 0.0332, above the limit 0.01, in the target; c = 30.2 m/s
      Expect a lower rebound; take a lower velocity.
    >>> report["waves"].value > report["waves"].threshold
    True
    """

    checks: tuple[Check, ...]

    def __iter__(self) -> Iterator[Check]:
        """Iterate over the checks."""
        return iter(self.checks)

    def __getitem__(self, kind: str) -> Check:
        """Return the check of a kind."""
        return {check.kind: check for check in self.checks}[kind]

    @property
    def warnings(self) -> list[str]:
        """Messages of the assumptions that are doubtful, each with what to do."""
        return [check.warning for check in self.checks if check.exceeded]

    def to_dict(self) -> dict[str, dict[str, Any]]:
        """Return the report as plain numbers and texts, by kind."""
        return {check.kind: {k: v for k, v in asdict(check).items() if k != "kind"} for check in self.checks}

    @classmethod
    def from_dict(cls, checks: dict[str, dict[str, Any]]) -> Validity:
        """Return the report that `to_dict` turned into these numbers and texts, perhaps by way of JSON."""
        made: list[dict[str, Any]] = [{**check, "kind": kind} for kind, check in checks.items()]
        for one in made:
            one["threshold"] = tuple(one["threshold"]) if isinstance(one["threshold"], list) else one["threshold"]
        return cls(tuple(Check(**one) for one in made))

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
    """Numbers of each contact, NaN if not known: the quantities `VALIDITY`, and what the messages show."""

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
    slope: Array
    # Stores of version 0.1 do not have those below.
    approximate: Array = np.zeros(1)
    layer_strain: Array = np.full(1, math.nan)
    is_layer_strain: Array = np.zeros(1)
    wave_body: Array = np.zeros(1)
    wave_size: Array = np.full(1, math.nan)
    undetermined_constants: Array = np.zeros(1)


def validity(contact: Contact, **columns: ArrayLike) -> Validity:
    """Compare the assumptions of the theory with the worst of some contacts; arguments as for `numbers`."""
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
    restitution_coefficient: ArrayLike = math.nan,
    residual_indentation_depth: ArrayLike = math.nan,
    body_size: ArrayLike = math.nan,
    impedance: ArrayLike = math.inf,
) -> Numbers:
    """Return the numbers that the report compares, for contacts of one kind or each of its own.

    The contact radius and the depth [m] are NaN if a contact was not solved. The velocity [m/s] of an indentation is
    its largest, and the contact time [s] is infinite if it has no end. `body_size` is the smallest dimension [m] of
    the target; that of the contact counts too. The window must contain the times from a third of d/v0 (T/10) to T.
    """
    contacts = [contact] if isinstance(contact, Contact) else contact
    columns = (
        max_contact_radius, max_indentation_depth, velocity, contact_time, mass, max_force, restitution_coefficient,
        residual_indentation_depth, impedance, *_shapes(contacts), *_sizes(contacts, body_size),
    )  # fmt: skip
    radius, depth, speed, time, mass, force, e, residual, Z, *shape, size, own, other, own_name, other_name = (
        np.asarray(column, dtype=np.float64).reshape(-1) for column in np.broadcast_arrays(*columns)
    )
    tip, ball, slope, confinement, layer = shape
    # Impacts of the same materials share one row of numbers.
    pairs = [(id(one.material), id(one.counter_material)) for one in contacts]
    kinds = dict(zip(pairs, contacts, strict=True))
    order = {pair: n for n, pair in enumerate(kinds)}
    kind = np.array([order[pair] for pair in pairs])
    found = np.array([_of_materials(one) for one in kinds.values()])
    low, high, instantaneous, static, factor, missing, undetermined = found[np.broadcast_to(kind, time.shape)].T
    with np.errstate(all="ignore"):
        rise = depth / speed
        time = np.where(np.isposinf(time), _HERTZ_TIME * rise, time)
        shortest = np.fmin(_RISE_SHARE * rise, time)
        # The change of momentum and the last depth give the centroid of the force.
        skewness = (1.0 - residual / (speed * time)) / (1.0 + e) - 0.5
        bodies = [one.materials for one in kinds.values()]
        wave_speed, wave_energy, place = radiated(bodies, kind, time, force, skewness, (own, other))
        # The energy budget has the waves of an impedance.
        wave_energy = np.where(np.isfinite(Z), 0.0, wave_energy)
        strain, squeezed = np.fmax(np.fmax(radius / tip, depth / radius), slope), depth / layer
        of_layer = layer_strain_number(squeezed, radius / layer, confinement)
        return Numbers(
            strain_number=np.fmax(strain, of_layer),
            contact_size_ratio=radius / size,
            mach_number=speed / wave_speed,
            radiated_energy_ratio=np.where(
                wave_energy == 0.0, 0.0, np.minimum(wave_energy / (0.5 * mass * speed**2), 1.0)
            ),
            window_ratio=np.maximum(low / shortest, time / high),
            instantaneous_poisson_ratio=np.where(np.isnan(time), math.nan, instantaneous),
            mean_density=mass / sphere_mass(1.0, ball),
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
            slope=slope,
            approximate=np.broadcast_to([not one.is_exact for one in contacts], time.shape).astype(np.float64),
            layer_strain=squeezed,
            is_layer_strain=(of_layer > strain).astype(np.float64),
            wave_body=np.where(place > 0.0, other_name, own_name),
            wave_size=np.where(place > 0.0, other, own),
            undetermined_constants=undetermined,
        )


def layer_strain_number(squeezed: ArrayLike, width: ArrayLike, confinement: ArrayLike) -> Array:
    """Largest shear strain in a layer over 0.7, in which it is d/a on an incompressible half-space.

    Parameters
    ----------
    squeezed, width : float or array
        Depth and contact radius over the thickness, d/h and a/h.
    confinement : float or array
        4 nu/(1 - 2 nu) of a bonded layer, infinite if incompressible; 0 on a frictionless base.

    Notes
    -----
    ``sqrt((d/a)^2 + (2 d/h)^2 + s^2)`` with ``s = (d a/h^2)/(1 + (1 - 2 nu)/(4 nu) (a/h)^2)``: the contact itself, the
    compression of the layer, and the shear of a bonded layer that flows sideways (`docs/theory/limits.md`).
    """
    d, a = np.asarray(squeezed, dtype=np.float64), np.asarray(width, dtype=np.float64)
    with np.errstate(all="ignore"):
        flow = d * a / (1.0 + a * a / np.asarray(confinement, dtype=np.float64))
        return np.sqrt((d / a) ** 2 + (2.0 * d) ** 2 + flow**2)


def _of_materials(contact: Contact) -> tuple[float, ...]:
    """Window, Poisson ratios, factor of the largest density, whether a density is missing, undetermined constants."""
    low, high = contact.window or (math.nan, math.nan)
    instantaneous, static = min((one.instantaneous_poisson_ratio, one.poisson_ratio) for one in contact.materials)
    missing = any(material.density is None for material in contact.materials)
    doubtful = [one for one in contact.materials if one.undetermined]
    # A material without a window is known from data without a time or a force.
    level = max((_SOME if one.window else _SCALE for one in doubtful), default=0.0)
    return low, high, instantaneous, static, _PAIR if contact.counter_material is not None else 1.0, missing, level


def _each(contacts: Sequence[Contact], number: Callable[[Contact], Any]) -> Array:
    """A number of each contact, or the array that a single one has."""
    found = [number(one) for one in contacts]
    return np.asarray(found if len(found) > 1 else found[0], dtype=np.float64)


def _shapes(contacts: Sequence[Contact]) -> list[Array]:
    """Radii of the tip and of the ball, slope of the faces, confinement and thickness of a layer."""
    names = "tip_radius", "ball_radius", "slope", "confinement", "target_thickness"
    return [_each(contacts, lambda one, name=name: getattr(one.profile, name)) for name in names]


def _sizes(contacts: Sequence[Contact], body_size: ArrayLike) -> list[Array]:
    """Size of a half-space, then sizes and names for waves of both bodies; unknown sizes are infinite."""
    tip, *_, layer = _shapes(contacts)
    stated = np.fmin(body_size, _each(contacts, lambda one: one.body_size or math.nan))
    ratios = [_each(contacts, lambda one, place=place: one.diameters[place]) for place in (0, 1)]
    pair = _each(contacts, lambda one: one.counter_material is not None) > 0.0
    flat, flat_other = map(np.isinf, ratios)
    # A stated size is that of the flat body, or else of the balls.
    any_flat = flat | (flat_other & pair)
    sizes = [np.fmin(np.where(np.isinf(one), one, one * tip), math.inf) for one in ratios]
    own, other = (
        np.where(one | ~any_flat, np.fmin(size, stated), size)
        for one, size in zip((flat, flat_other), sizes, strict=True)
    )
    two, ball = pair & ~any_flat, np.where(np.isnan(tip), _INDENTER, _BALL)
    target = np.where(np.isnan(layer), np.where(pair, _TARGET, _BESIDE_RIGID), _LAYER)
    name = np.where(flat, target, np.where(two, _BALL + 1, ball))
    other_name = np.where(flat_other, _TARGET, np.where(two, _BALL + 2, ball))
    # Where the thickness is part of the solution the target need not be a half-space.
    return [np.where(np.isnan(layer), stated, math.nan), np.fmin(own, layer), other, name, other_name]


def together(parts: Iterable[Numbers]) -> Numbers:
    """Return the numbers of several contacts as those of one list."""
    return Numbers(*(np.concatenate(one) for one in zip(*parts, strict=True)))


def excess(numbers: Numbers) -> dict[str, Array]:
    """Return a number for each assumption and contact: above 1 where it is doubtful, NaN where it is not known."""
    low, high = DENSITY_LIMITS
    share = numbers.radiated_energy_ratio / RADIATION_LIMIT
    change = numbers.instantaneous_poisson_ratio - numbers.poisson_ratio
    # A product that underflows is a density of zero, and the strain under a needle has no bound.
    with np.errstate(divide="ignore", over="ignore"):
        density = np.fmax(low / numbers.mean_density, numbers.mean_density / (high * numbers.density_factor))
        return {
            # A contact that no body of this radius has is worse than every other.
            "small_strain": np.where(numbers.no_such_contact > 0.0, 1e30, 1.0) * numbers.strain_number / STRAIN_LIMIT,
            "half_space": numbers.contact_size_ratio / SIZE_LIMIT,
            "waves": np.where(np.isnan(share), numbers.mach_number / SPEED_LIMIT, share),
            "window": numbers.window_ratio,
            # A negative static one is a choice.
            "poisson_ratio": 1.0 + np.minimum(numbers.poisson_ratio, 0.0) - numbers.instantaneous_poisson_ratio,
            "density": density,
            "separability": np.where(numbers.approximate > 0.0, 2.0 + np.abs(change), math.nan),
            "constants": np.where(
                numbers.undetermined_constants > 0.0, 1.0 + numbers.undetermined_constants, math.nan
            ),
        }


def report(numbers: Numbers) -> Validity:
    """Return the report on the worst of the contacts."""
    checks: list[Check] = []
    for kind, values in excess(numbers).items():
        name, limit, reason, describe = _KINDS[kind]
        known = ~np.isnan(values)
        if kind in ("separability", "constants") and not known.any():
            continue
        worst = int(np.argmax(np.where(known, values, -np.inf)))
        one: Any = Numbers(*(column[worst] for column in numbers))
        exceeded = bool(values[worst] > 1.0)
        # A body without a density may have the slower waves.
        sure = exceeded or kind != "waves" or not numbers.density_missing.any()
        if not (known.any() and sure):
            message = f"{_TITLES[kind]}: not checked, {reason}"
            checks.append(Check(kind, VALIDITY[name].words, None, limit, False, message, ""))
            continue
        if kind == "waves" and math.isnan(one.radiated_energy_ratio):
            name, limit = "mach_number", SPEED_LIMIT
        elif kind == "density":
            limit = (DENSITY_LIMITS[0], DENSITY_LIMITS[1] * float(one.density_factor))
        elif kind == "separability":
            limit = float(one.poisson_ratio)
        text, advice = describe(one, exceeded)
        message = f"{_TITLES[kind]}: {text}"
        checks.append(Check(kind, VALIDITY[name].words, float(getattr(one, name)), limit, exceeded, message, advice))
    return Validity(tuple(checks))


def _small_strain(one: Any, exceeded: bool) -> tuple[str, str]:
    number = "max(a/R, d/a)" if one.round_body else "d/a" if math.isnan(one.slope) else "the slope of the faces"
    text = f"{number} is {_beside(one.strain_number, STRAIN_LIMIT)}"
    if one.no_such_contact > 0.0:
        text += "; a body of this radius has no such contact"
        return text, "Discard the result: the contact radius, or the depth, exceeds the radius of the body."
    if one.is_layer_strain > 0.0:
        text = f"the strain number of the layer is {_beside(one.strain_number, STRAIN_LIMIT)}; the body is pressed in "
        text += f"by {100 * one.layer_strain:.2g} % of the thickness, with shear strains of some "
        text += f"{100 * _SHEAR * one.strain_number:.2g} %"
        return text, "Take a lower velocity or depth, or a thicker layer, or read the numbers as a trend."
    if one.round_body:
        text += f"; the representative strain is about {20 * one.strain_number:.2g} %"
    return text, "Take a lower velocity or depth, or a larger or blunter body, or read the numbers as a trend."


def _half_space(one: Any, exceeded: bool) -> tuple[str, str]:
    x = one.contact_size_ratio
    # Expansion for a parabola on a bonded incompressible layer; the exact factor at 0.5 is 2.156.
    more = f"{np.polynomial.Polynomial([0, 112.7, 148.17, 147.0, 100.5])(x):.0f} %" if x <= 0.5 else "more than 100 %"
    text = f"contact radius over size of the target is {_beside(x, SIZE_LIMIT)}; "
    text += f"a bonded incompressible layer would be {more} stiffer"
    return text, "Solve the layer (rs.Layer), take a thicker target, or read the result as that of a thick one."


def _waves(one: Any, exceeded: bool) -> tuple[str, str]:
    share, deep = one.radiated_energy_ratio, f"{0.5 * one.wave_speed * one.contact_time:.3g} m"
    place = int(np.nan_to_num(one.wave_body))
    body = _BODIES[place]
    if share == 0.0:
        return f"they return in contact, as the {body} is not deeper than {deep}, or count by its impedance", ""
    known = math.isfinite(one.wave_size)
    text = f"{VALIDITY['radiated_energy_ratio'].words} is {_beside(share, RADIATION_LIMIT)}, in the {body}"
    text += f"{', which is' if known else ' if it is'} deeper than c T/2 = {deep}; v0/c = {one.mach_number:.3g}"
    if math.isnan(share):
        text = f"{VALIDITY['mach_number'].words} is {_beside(one.mach_number, SPEED_LIMIT)}, in the {body}"
    advice = (
        "Expect a lower rebound" if known else f"Expect a lower rebound where the {body} is deep, or state its size"
    )
    if place == _BESIDE_RIGID and one.round_body and not known:
        advice += ", or that the ball is the soft body"
    return f"{text}; c = {one.wave_speed:.3g} m/s", f"{advice}; take a lower velocity."


def _window(one: Any, exceeded: bool) -> tuple[str, str]:
    text = f"the contact lasts {one.contact_time:.3g} s and its beginning {one.shortest_time:.3g} s, "
    text += f"the material is known from {one.window_low:.3g} s to {one.window_high:.3g} s"
    text += f", which is short by a factor of {one.window_ratio:.3g}" if exceeded else ""
    return text, "Measure at these times, or shift data of other temperatures; the modulus is extrapolated."


def _poisson_ratio(one: Any, exceeded: bool) -> tuple[str, str]:
    value, limit = one.instantaneous_poisson_ratio, min(one.poisson_ratio, 0.0)
    ratio = 2.0 * (1.0 + value) / (3.0 * (1.0 - 2.0 * value)) if value < 0.5 else math.inf
    text = f"the instantaneous one is {value:.3g}, {'below' if exceeded else 'not below'} the limit {limit:.3g}; "
    text += f"the static one is {one.poisson_ratio:.4g}, K/G0 = {ratio:.3g}"
    return text, "Raise the bulk modulus or lower the instantaneous shear modulus; polymers have 0.3 to 0.4."


def _density(one: Any, exceeded: bool) -> tuple[str, str]:
    low, high = DENSITY_LIMITS
    limits = f"{'outside' if exceeded else 'within'} {low:g} to {high * one.density_factor:g} kg/m3"
    text = f"a ball of this mass and radius has {one.mean_density:.3g} kg/m3, {limits}"
    return text, "Compare the units of mass (kg) and radius (m), unless a heavy body with a small tip is meant."


def _separability(one: Any, exceeded: bool) -> tuple[str, str]:
    return approximation(one.instantaneous_poisson_ratio, one.poisson_ratio)


def _constants(one: Any, exceeded: bool) -> tuple[str, str]:
    text = "data behind the material do not determine all of its constants; "
    if one.undetermined_constants >= _SCALE:
        text += "contact time, depth, force, pressure and radius are not determined, only the restitution coefficient"
        return text, "Measure a contact time, a force or a modulus, and identify the material again."
    text += "outputs are determined only for contacts like those of the data"
    return text, "Stay near those contacts, or add the measurement that `restitution identify` names."


# The quantity that is compared, its limit, the reason if it is not known, and the text with advice if it is.
_KINDS: dict[str, tuple[str, Threshold, str, Callable[[Any, bool], tuple[str, str]]]] = {
    "small_strain": ("strain_number", STRAIN_LIMIT, "no contact radius is known", _small_strain),
    "half_space": ("contact_size_ratio", SIZE_LIMIT, "no size of the target is given", _half_space),
    "waves": ("radiated_energy_ratio", RADIATION_LIMIT, "the density of a material is missing", _waves),
    "window": ("window_ratio", 1.0, "no material states its window", _window),
    "poisson_ratio": ("instantaneous_poisson_ratio", 0.0, "no contact was solved", _poisson_ratio),
    "density": ("mean_density", DENSITY_LIMITS, "the body is no ball of a known mass", _density),
    "separability": ("instantaneous_poisson_ratio", math.nan, "", _separability),
    "constants": ("undetermined_constants", 0.0, "", _constants),
}


def _beside(value: float, limit: float) -> str:
    return f"{value:.3g}, {'above' if value > limit else 'not above'} the limit {limit:g}"


def _row(check: Check) -> tuple[str, str, str, str]:
    shown = " to ".join(f"{one:g}" for one in np.atleast_1d(check.threshold))
    value = "-" if check.value is None else f"{check.value:.3g}"
    state = "DOUBTFUL" if check.exceeded else "ok" if check.value is not None else "not checked"
    return _TITLES[check.kind], value, shown, state
