"""The assumptions of the theory beside their limits, for which `docs/theory/limits.md` gives the reasons."""

from __future__ import annotations

import math
import warnings
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import asdict, dataclass
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from restitution.checks import Array
from restitution.contact.geometry import Contact
from restitution.contact.profiles import sphere_mass
from restitution.contact.radiation import Bodies, radiated
from restitution.errors import RestitutionWarning
from restitution.limits import (
    BALL,
    BESIDE_RIGID,
    COUPLING_LIMIT,
    DENSITY_LIMITS,
    INDENTER,
    KINDS,
    LAYER,
    OF_ADHESION,
    RADIATION_LIMIT,
    RANGE_LIMIT,
    SCALE,
    SIZE_LIMIT,
    SLOPE_LIMIT,
    SOME,
    SPEED_LIMIT,
    STRAIN_LIMIT,
    TARGET,
    TITLES,
    TRAVEL_LIMIT,
    Threshold,
    dips,
    poisson_excess,
)
from restitution.material.prony import PronySeries
from restitution.material.viscoelastic import RIGID, Material, poisson_ratio_range
from restitution.quantities import VALIDITY, choice
from restitution.result import Table

COLUMNS = (
    "max_contact_radius", "max_indentation_depth", "contact_time", "max_force",
    "restitution_coefficient", "residual_indentation_depth",
)  # fmt: skip
"""Outputs of an impact that the report takes; it also takes the velocity and the mass."""

# Two equal balls have four times their density by reduced mass and radius.
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
    kind : str
        `small_strain`, `half_space`, `waves`, `window`, `poisson_ratio`, `density`, with friction `coupling` and
        `travel`, with adhesion `attraction`, `range` and `roughness`, or if in doubt `separability` or `constants`.
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
    >>> from restitution.contact.profiles import Parabola
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
        checks = {check.kind: check for check in self.checks}
        return checks[choice("kind", kind, checks)]

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
        rows: list[dict[str, Any]] = [{**check, "kind": kind} for kind, check in checks.items()]
        for row in rows:
            row["threshold"] = tuple(row["threshold"]) if isinstance(row["threshold"], list) else row["threshold"]
        return cls(tuple(Check(**row) for row in rows))

    def __str__(self) -> str:
        """Return the report as a table, with advice on what is doubtful."""
        rows = (("assumption", "value", "limit", ""), *map(_row, self.checks))
        lines = ["{:14}{:>12}{:>14}  {}".format(*row).rstrip() for row in rows]
        notes = [f"{check.message}\n  {check.advice}" for check in self.checks if check.exceeded]
        return "\n".join([*lines, *notes])

    def _repr_html_(self) -> str:
        rows = [(*_row(check), check.message, check.advice) for check in self.checks]
        return Table(("assumption", "value", "limit", "", "numbers", "advice"), rows).html


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
    coupling_number: Array = np.full(1, math.nan)
    travel_number: Array = np.full(1, math.nan)
    maugis_number: Array = np.full(1, math.nan)
    instantaneous_maugis_number: Array = np.full(1, math.nan)
    zone_ratio: Array = np.full(1, math.nan)
    zone_slope: Array = np.full(1, math.nan)
    range_ratio: Array = np.full(1, math.nan)
    attraction_range: Array = np.full(1, math.nan)
    lowest_poisson_ratio: Array = np.full(1, math.nan)
    highest_poisson_ratio: Array = np.full(1, math.nan)


class Outputs(NamedTuple):
    """Outputs of contacts, whose worst the report compares; numbers or arrays, NaN if not known.

    The contact radius and the depth [m] are NaN if a contact was not solved. The velocity [m/s] of an indentation is
    its largest, and the contact time [s] is infinite if it has no end. `body_size` is the smallest dimension [m] of
    the target; that of the contact counts too.
    """

    max_contact_radius: Any
    max_indentation_depth: Any
    velocity: Any
    contact_time: Any
    mass: Any = math.nan
    max_force: Any = math.nan
    restitution_coefficient: Any = math.nan
    residual_indentation_depth: Any = math.nan
    body_size: Any = math.nan
    impedance: Any = math.inf
    coupling_number: Any = math.nan
    travel_number: Any = math.nan
    maugis_number: Any = math.nan
    instantaneous_maugis_number: Any = math.nan
    attraction_range: Any = math.nan
    zone_width: Any = math.nan


class _Shapes(NamedTuple):
    """Radii of the tip and of the ball, slope of the faces, confinement and thickness of a layer."""

    tip_radius: Array
    ball_radius: Array
    slope: Array
    confinement: Array
    target_thickness: Array


class _Sizes(NamedTuple):
    """Size of a half-space, then sizes and names for waves of both bodies; unknown sizes are infinite."""

    target: Array
    first: Array
    second: Array
    first_name: Array
    second_name: Array


class _Materials(NamedTuple):
    """Numbers of the materials of each kind of contact."""

    window_low: Array
    window_high: Array
    instantaneous_poisson_ratio: Array
    poisson_ratio: Array
    density_factor: Array
    density_missing: Array
    undetermined_constants: Array
    lowest_poisson_ratio: Array
    highest_poisson_ratio: Array


def validity(contact: Contact, **columns: ArrayLike) -> Validity:
    """Compare the assumptions of the theory with the worst of some contacts; the columns are those of `Outputs`."""
    return report(numbers(contact, **columns))


def numbers(contact: Contact | Sequence[Contact], **columns: ArrayLike) -> Numbers:
    """Return the numbers that the report compares, for contacts of one kind or each of its own.

    The columns are those of `Outputs`. The window must contain the times from a third of d/v0 (T/10) to T.
    """
    contacts = [contact] if isinstance(contact, Contact) else contact
    of_contacts, n = _of_contacts(contacts), len(_Shapes._fields)
    outputs, shapes = Outputs(**columns), _Shapes(*of_contacts[:n])
    arrays = np.broadcast_arrays(*outputs, *shapes, *_sizes(shapes, outputs.body_size, *of_contacts[n:]))
    flat = [np.asarray(array, dtype=np.float64).reshape(-1) for array in arrays]
    first, second = len(outputs), len(outputs) + len(shapes)
    outputs, shapes, sizes = Outputs(*flat[:first]), _Shapes(*flat[first:second]), _Sizes(*flat[second:])
    pairs, is_single, kind, of_kinds = _materials(contacts, arrays[0].shape)
    radius, depth, speed = outputs.max_contact_radius, outputs.max_indentation_depth, outputs.velocity
    places, layer = np.broadcast_to(kind, depth.shape), shapes.target_thickness
    materials = _Materials(*[column[places] for column in of_kinds])
    with np.errstate(all="ignore"):
        rise = depth / speed
        time = np.where(np.isposinf(outputs.contact_time), _HERTZ_TIME * rise, outputs.contact_time)
        shortest = np.fmin(_RISE_SHARE * rise, time)
        # The change of momentum and the last depth give the centroid of the force.
        skewness = 1.0 - outputs.residual_indentation_depth / (speed * time)
        skewness = skewness / (1.0 + outputs.restitution_coefficient) - 0.5
        wave_speed, wave_energy, place = radiated(
            pairs, is_single, kind, time, outputs.max_force, skewness, (sizes.first, sizes.second)
        )
        # The energy budget has the waves of an impedance.
        wave_energy = np.where(np.isfinite(outputs.impedance), 0.0, wave_energy)
        kinetic_energy = 0.5 * outputs.mass * speed**2
        strain, squeezed = np.fmax(np.fmax(radius / shapes.tip_radius, depth / radius), shapes.slope), depth / layer
        of_layer = layer_strain_number(squeezed, radius / layer, shapes.confinement)
        return Numbers(
            strain_number=np.fmax(strain, of_layer),
            contact_size_ratio=radius / sizes.target,
            mach_number=speed / wave_speed,
            radiated_energy_ratio=np.where(wave_energy == 0.0, 0.0, np.minimum(wave_energy / kinetic_energy, 1.0)),
            window_ratio=np.maximum(materials.window_low / shortest, time / materials.window_high),
            instantaneous_poisson_ratio=np.where(np.isnan(time), math.nan, materials.instantaneous_poisson_ratio),
            mean_density=outputs.mass / sphere_mass(1.0, shapes.ball_radius),
            round_body=np.isfinite(shapes.tip_radius).astype(np.float64),
            no_such_contact=((radius > shapes.tip_radius) | (depth > shapes.tip_radius)).astype(np.float64),
            contact_time=time,
            shortest_time=shortest,
            wave_speed=wave_speed,
            window_low=materials.window_low,
            window_high=materials.window_high,
            density_factor=materials.density_factor,
            poisson_ratio=materials.poisson_ratio,
            density_missing=materials.density_missing,
            slope=shapes.slope,
            approximate=np.broadcast_to([not each.is_exact for each in contacts], time.shape).astype(np.float64),
            layer_strain=squeezed,
            is_layer_strain=(of_layer > strain).astype(np.float64),
            wave_body=np.where(place > 0.0, sizes.second_name, sizes.first_name),
            wave_size=np.where(place > 0.0, sizes.second, sizes.first),
            undetermined_constants=materials.undetermined_constants,
            coupling_number=outputs.coupling_number,
            travel_number=outputs.travel_number,
            maugis_number=outputs.maugis_number,
            instantaneous_maugis_number=outputs.instantaneous_maugis_number,
            zone_ratio=outputs.zone_width / radius,
            zone_slope=outputs.attraction_range / outputs.zone_width,
            range_ratio=outputs.attraction_range / depth,
            attraction_range=outputs.attraction_range,
            lowest_poisson_ratio=np.where(np.isnan(time), math.nan, materials.lowest_poisson_ratio),
            highest_poisson_ratio=materials.highest_poisson_ratio,
        )


def layer_strain_number(squeezed: ArrayLike, width: ArrayLike, confinement: ArrayLike) -> Array:
    """Return the largest shear strain in a layer over 0.7, in which it is d/a on an incompressible half-space.

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


def _materials(
    contacts: Sequence[Contact], shape: tuple[int, ...]
) -> tuple[list[Bodies], NDArray[np.bool_], NDArray[np.intp], _Materials]:
    """Bodies of kinds of contacts, whether they are single, the kind of each contact, and numbers of the kinds."""
    if len(contacts) == 1:
        (contact,) = contacts
        rows = contact.shape
        kind = np.broadcast_to(np.arange(math.prod(rows)).reshape(rows), shape if rows else (1,)).reshape(-1)
        kinds = [contact]
    else:
        # Impacts of the same materials share one row of numbers.
        pairs = [(id(contact.material), id(contact.counter_material)) for contact in contacts]
        by_pair = dict(zip(pairs, contacts, strict=True))
        order = {pair: n for n, pair in enumerate(by_pair)}
        kind, kinds = np.array([order[pair] for pair in pairs]), list(by_pair.values())
    # A body without a counter-body counts twice, which changes no extreme.
    places = [[(contact.material, contact.shape) for contact in kinds]]
    if any(contact.counter_material is not None for contact in kinds):
        places.append([(contact.counter_material or contact.material, contact.shape) for contact in kinds])
    single = [np.full(math.prod(contact.shape), contact.counter_material is None) for contact in kinds]
    is_single = np.concatenate(single) if len(single) > 1 else single[0]
    columns = [_in_rows([_of_body(*body) for body in place]) for place in places]
    bodies = [
        Bodies(_stacked(place, "shear"), _stacked(place, "bulk"), of_place[_DENSITY])
        for place, of_place in zip(places, columns, strict=True)
    ]
    low, high, density, doubt, *ratios = columns[0]
    missing = np.isnan(density)
    for other in columns[1:]:
        # The Poisson ratios are those of the body that is worse by them, then with the lower static one.
        its, mine = (poisson_excess(*each) for each in (other[_RATIOS:], ratios))
        less = (its > mine) | ((its == mine) & (other[_RATIOS + 2] < ratios[2]))
        ratios = np.where(less, other[_RATIOS:], ratios)
        low, high, doubt = np.fmax(low, other[0]), np.fmin(high, other[1]), np.fmax(doubt, other[3])
        missing = missing | np.isnan(other[_DENSITY])
    factor = np.where(is_single, 1.0, _PAIR)
    lowest, instantaneous, static, highest = ratios
    numbers = low, high, instantaneous, static, factor, missing.astype(float), doubt, lowest, highest
    return bodies, is_single, kind, _Materials(*numbers)


_Place = Sequence[tuple[Material, tuple[int, ...]]]
_DENSITY, _RATIOS = 2, 4  # places of the density and of the first Poisson ratio in the numbers of a body


def _of_body(body: Material, shape: tuple[int, ...]) -> Array:
    """Return the ends of the window, density, doubt, and Poisson ratios of a body, in rows.

    The ratios are the lowest, the instantaneous, the static and the highest one.
    """
    low, high = body.window or (math.nan, math.nan)
    density = math.nan if body.density is None else body.density
    # Without a window no time and no force is known of data that do not determine all constants.
    doubt = 0.0 if not body.undetermined else SOME if body.window else SCALE
    lowest, highest = poisson_ratio_range(body)
    ratios = lowest, body.instantaneous_poisson_ratio, body.poisson_ratio, highest
    numbers = low, high, density, doubt, *ratios
    if not shape:
        return np.array(numbers, dtype=np.float64)[:, None]
    return np.stack([np.broadcast_to(number, shape).reshape(-1) for number in numbers])


def _in_rows(columns: Sequence[Array]) -> Array:
    """Join the columns of several bodies."""
    return np.concatenate(columns, axis=1) if len(columns) > 1 else columns[0]


def _stacked(place: _Place, name: str) -> PronySeries:
    """Return the relaxation moduli of each body, in rows."""
    moduli = [getattr(body, name) for body, _ in place]
    series = [modulus if isinstance(modulus, PronySeries) else RIGID for modulus in moduli]
    if len(place) == 1:
        return series[0].broadcast_to(place[0][1]).reshaped((math.prod(place[0][1]),))
    return PronySeries.stacked(series)


def _of_contacts(contacts: Sequence[Contact]) -> list[Array]:
    """Return the numbers of each contact, or the arrays that a single one has: `_Shapes`, then what `_sizes` takes."""
    rows = [
        (
            *(getattr(contact.profile, name) for name in _Shapes._fields),
            contact.body_size or math.nan,
            contact.counter_material is not None,
            *contact.diameters,
        )
        for contact in contacts
    ]
    columns = zip(*rows, strict=True) if len(rows) > 1 else rows[0]
    return [np.asarray(column, dtype=np.float64) for column in columns]


def _sizes(shapes: _Shapes, body_size: ArrayLike, known_size: Array, has_pair: Array, *ratios: Array) -> _Sizes:
    tip, layer, pair = shapes.tip_radius, shapes.target_thickness, has_pair > 0.0
    stated = np.fmin(body_size, known_size)
    flat, flat_other = map(np.isinf, ratios)
    # A stated size is that of the flat body, or else of the balls.
    any_flat = flat | (flat_other & pair)
    sizes = [np.fmin(np.where(np.isinf(ratio), ratio, ratio * tip), math.inf) for ratio in ratios]
    first, second = (
        np.where(is_flat | ~any_flat, np.fmin(size, stated), size)
        for is_flat, size in zip((flat, flat_other), sizes, strict=True)
    )
    two, ball = pair & ~any_flat, np.where(np.isnan(tip), INDENTER, BALL)
    target = np.where(np.isnan(layer), np.where(pair, TARGET, BESIDE_RIGID), LAYER)
    name = np.where(flat, target, np.where(two, BALL + 1, ball))
    other_name = np.where(flat_other, TARGET, np.where(two, BALL + 2, ball))
    # Where the thickness is part of the solution the target need not be a half-space.
    return _Sizes(np.where(np.isnan(layer), stated, math.nan), np.fmin(first, layer), second, name, other_name)


def together(parts: Iterable[Numbers]) -> Numbers:
    """Return the numbers of several contacts as those of one list."""
    return Numbers(*(np.concatenate(columns) for columns in zip(*parts, strict=True)))


def excess(numbers: Numbers) -> dict[str, Array]:
    """Return a number for each assumption and contact: above 1 where it is doubtful, NaN where it is not known."""
    low, high = DENSITY_LIMITS
    share = numbers.radiated_energy_ratio / RADIATION_LIMIT
    change = numbers.instantaneous_poisson_ratio - numbers.poisson_ratio
    ratios = numbers.lowest_poisson_ratio, numbers.instantaneous_poisson_ratio, numbers.poisson_ratio
    # A product that underflows is a density of zero, and the strain under a needle has no bound.
    with np.errstate(divide="ignore", over="ignore"):
        density = np.fmax(low / numbers.mean_density, numbers.mean_density / (high * numbers.density_factor))
        return {
            # A contact that no body of this radius has is worse than every other.
            "small_strain": np.where(numbers.no_such_contact > 0.0, 1e30, 1.0) * numbers.strain_number / STRAIN_LIMIT,
            "half_space": numbers.contact_size_ratio / SIZE_LIMIT,
            "waves": np.where(np.isnan(share), numbers.mach_number / SPEED_LIMIT, share),
            "window": numbers.window_ratio,
            "poisson_ratio": 1.0 + poisson_excess(*ratios),
            "density": density,
            "separability": np.where(numbers.approximate > 0.0, 2.0 + np.abs(change), math.nan),
            "constants": np.where(
                numbers.undetermined_constants > 0.0, 1.0 + numbers.undetermined_constants, math.nan
            ),
            "coupling": numbers.coupling_number / COUPLING_LIMIT,
            "travel": numbers.travel_number / TRAVEL_LIMIT,
            "attraction": numbers.zone_slope / SLOPE_LIMIT,
            "range": numbers.range_ratio / RANGE_LIMIT,
            # Never checked, as no height of the surface is known.
            "roughness": np.full(np.shape(numbers.attraction_range), math.nan),
        }


def report(numbers: Numbers) -> Validity:
    """Return the report on the worst of the contacts."""
    checks: list[Check] = []
    for kind, values in excess(numbers).items():
        name, limit, reason, describe = KINDS[kind]
        unknown = np.isnan(values)
        is_known = not unknown.all()
        if not is_known and (not reason or (kind in OF_ADHESION and np.isnan(numbers.attraction_range).all())):
            continue
        place = int(np.where(unknown, -np.inf, values).argmax())
        worst: Any = Numbers(*[column[place] for column in numbers])
        exceeded = bool(values[place] > 1.0)
        # A body without a density may have the slower waves.
        sure = exceeded or kind != "waves" or not numbers.density_missing.any()
        if not (is_known and sure):
            limit = float(np.nanmin(numbers.attraction_range)) if kind == "roughness" else limit
            message = f"{TITLES[kind]}: not checked, {reason}"
            checks.append(Check(kind, VALIDITY[name].words, None, limit, False, message, ""))
            continue
        if kind == "waves" and math.isnan(worst.radiated_energy_ratio):
            name, limit = "mach_number", SPEED_LIMIT
        elif kind == "density":
            limit = (DENSITY_LIMITS[0], DENSITY_LIMITS[1] * float(worst.density_factor))
        elif kind == "separability":
            limit = float(worst.poisson_ratio)
        text, advice = describe(worst, exceeded)
        message, words, value = f"{TITLES[kind]}: {text}", VALIDITY[name].words, getattr(worst, name)
        if kind == "poisson_ratio" and dips(
            worst.lowest_poisson_ratio, worst.instantaneous_poisson_ratio, worst.poisson_ratio
        ):
            words, value = "lowest Poisson ratio", worst.lowest_poisson_ratio
        checks.append(Check(kind, words, float(value), limit, exceeded, message, advice))
    return Validity(tuple(checks))


def _row(check: Check) -> tuple[str, str, str, str]:
    shown = " to ".join(f"{limit:g}" for limit in np.atleast_1d(check.threshold))
    value = "-" if check.value is None else f"{check.value:.3g}"
    state = "DOUBTFUL" if check.exceeded else "ok" if check.value is not None else "not checked"
    return TITLES[check.kind], value, shown, state


def warn(messages: Mapping[str, str], stacklevel: int) -> None:
    """Warn once for each kind of message."""
    for kind, message in messages.items():
        warnings.warn(RestitutionWarning(kind, message), stacklevel=stacklevel + 1)
