"""Rebound resilience of standard tests, and the loss tangent that a measured one means."""

from __future__ import annotations

import math
import tomllib
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cache
from importlib.resources import files
from types import MappingProxyType
from typing import TYPE_CHECKING, Any, NamedTuple, cast

import numpy as np
from numpy.typing import ArrayLike

from restitution import validity
from restitution.checks import Array, items, single, single_positive, within
from restitution.contact.geometry import Contact, Geometry
from restitution.contact.layer.layer import Base, Layer
from restitution.contact.profiles import Parabola
from restitution.errors import InputError
from restitution.impact.batch import solve_columns
from restitution.impact.problem import STANDARD_GRAVITY, Impact, fall_velocity
from restitution.impact.status import SolverError, Status
from restitution.material.prony import PronySeries
from restitution.material.viscoelastic import Material, single_material
from restitution.quantities import CONTACT_TANGENT, INPUTS, OUTPUTS, Dimension, Quantity, check, check_single, choice
from restitution.result import Result, Summary, Table, plain
from restitution.units import celsius
from restitution.validity import Validity
from restitution.variation import varied

if TYPE_CHECKING:
    import pandas
    import xarray


# Loss tangent that a measured rebound resilience means, and its range over the materials that share it.


# Resiliences [%] that the families reach.
_LOWEST, _HIGHEST = 1.0, 99.5
# Branch over equilibrium modulus of the standard solids, close where the largest loss tangent varies with it, and the
# relaxation times of each in the time unit of the impact: the range is known to 1 %.
_RATIOS = np.concatenate([np.geomspace(2e-3, 20.0, 120), np.geomspace(30.0, 1e4, 8)])
_FAST, _SLOW, _TIMES = 3e-5, 1e3, 240
# Exponents of the power laws, and their relaxation times.
_EXPONENTS = np.concatenate([np.geomspace(1e-3, 0.05, 8), np.linspace(0.1, 0.8, 15)])
_DECADES = np.arange(-8.0, 6.0, 0.3)


class ImpliedLoss(NamedTuple):
    """Loss tangent [-] at the angular frequency pi over the contact time, from a resilience.

    Attributes
    ----------
    loss_tangent : float
        That of a power-law material, G ~ t^-n, which has the same one at all frequencies near the contact.
    low, high : float
        Range over the standard solids that have this resilience, from Kelvin-Voigt to Maxwell.
    """

    loss_tangent: float
    low: float
    high: float


def implied_loss_tangent(rebound_resilience: float) -> ImpliedLoss:
    """Return the loss tangent that a rebound resilience means, on a half-space.

    Parameters
    ----------
    rebound_resilience : float
        Measured R = e^2 in per cent, from 1 to 99.5.

    Returns
    -------
    ImpliedLoss
        The loss tangent at pi over the contact time, and its range over materials that share R.

    Raises
    ------
    InputError
        If R is out of this range.

    Notes
    -----
    The coefficient of restitution depends on the loss tangent at the time of the contact, and little on the rest of
    the spectrum (Willert 2020). A rigid sphere on an incompressible half-space has the same relation for all radii,
    masses, velocities and moduli. The range is that of all standard solids ``G = G_inf + G_1 exp(-t/tau)`` with
    G_1/G_inf from 0.002 to 10^4 that have this R. Nearly all of 2600 random Prony series of one to seven times lie in
    it, and the farthest is 5 % outside.

    Examples
    --------
    >>> implied = implied_loss_tangent(64.0)
    >>> print(round(implied.loss_tangent, 3), round(implied.low, 2), round(implied.high, 2))
    0.18 0.14 0.21
    """
    measured = single("rebound_resilience", within("rebound_resilience", rebound_resilience, _LOWEST, _HIGHEST, "%"))
    e = np.sqrt(measured / 100.0)
    law_e, law_tangent = _power_laws()
    solids_e, solids_tangent = _standard_solids()
    # Each step along the relaxation times in which the restitution passes the measured one.
    share = (e - solids_e[:, :-1]) / np.diff(solids_e, axis=1)
    rows, steps = np.nonzero((share >= 0.0) & (share < 1.0))
    start, end = np.log(solids_tangent[rows, steps]), np.log(solids_tangent[rows, steps + 1])
    tangents = np.exp(start + share[rows, steps] * (end - start))
    return ImpliedLoss(_interpolated(e, law_e, law_tangent), float(tangents.min()), float(tangents.max()))


def _interpolated(e: float, restitution: Array, tangent: Array) -> float:
    from scipy.interpolate import PchipInterpolator

    # The loss tangent is nearly proportional to -ln e.
    loss = -np.log(restitution)
    return float(PchipInterpolator(loss, tangent / loss)(-np.log(e)) * -np.log(e))


@cache
def _standard_solids() -> tuple[Array, Array]:
    """Return the restitution and loss tangent, shape (n_ratio, n_time)."""
    place = np.linspace(0.0, 1.0, _TIMES)
    times = (_FAST / _RATIOS[:, None]) ** (1.0 - place) * _SLOW**place
    moduli = np.broadcast_to(_RATIOS[:, None], times.shape)
    rows = times.size
    series = PronySeries.from_checked(np.ones(rows), moduli.reshape(rows, 1), times.reshape(rows, 1))
    e, tangent = (column.reshape(times.shape) for column in _solved(series))
    return e, tangent


@cache
def _power_laws() -> tuple[Array, Array]:
    times = 10.0**_DECADES
    # The slowest term stands for all slower ones.
    moduli = times ** -_EXPONENTS[:, None]
    equilibrium = moduli[:, -1] / (10.0 ** (0.3 * _EXPONENTS) - 1.0)
    return _solved(PronySeries.from_checked(equilibrium, moduli, np.broadcast_to(times, moduli.shape)))


def _solved(series: PronySeries) -> tuple[Array, Array]:
    """Return the restitution and loss tangent of impacts of unit mass, velocity and radius, whose E* are a series."""
    # Of an incompressible material E* = 4 G.
    impacts = Impact(Material(series.scaled(0.25), math.inf), Parabola(1.0), 1.0, 1.0)
    columns = solve_columns(impacts, 1e-7)
    omega = np.pi / columns["contact_time"]
    phase = omega[:, None] * series.relaxation_times
    loss_modulus = (series.branch_moduli * phase / (1.0 + phase**2)).sum(axis=1)
    return columns["restitution_coefficient"], loss_modulus / series.storage_modulus(omega)


# Standards of rebound resilience: the indentor, its mass and velocity, the pad, and the source of each number.


@dataclass(frozen=True)
class Standard:
    """A test of rebound resilience.

    Attributes
    ----------
    name, words : str
        Name of the standard, and the test in words.
    radius, mass : float or None
        Radius [m] of the rigid spherical indentor and its mass [kg]; None without a reliable source.
    velocity : float
        Impact velocity [m/s].
    thickness : float
        Thickness of the pad [m].
    sources : dict of str
        Source of each number: a key of `citation/references.bib`, and its words there.
    falls : bool
        Whether the weight acts along the motion.
    """

    name: str
    words: str
    radius: float | None
    mass: float | None
    velocity: float
    thickness: float
    sources: Mapping[str, str]
    falls: bool = False

    @property
    def keys(self) -> list[str]:
        """Keys of the sources in `citation/references.bib`."""
        return list(dict.fromkeys(text.partition(":")[0] for text in self.sources.values()))


def _standards() -> Iterator[Standard]:
    table = tomllib.loads(files("restitution").joinpath("standards.toml").read_text(encoding="utf-8"))
    for row in table["standard"]:
        falls, names = "fall" in row, row.pop("names")
        if falls:
            row["velocity"] = float(fall_velocity(row.pop("fall"), STANDARD_GRAVITY))
        row |= {name: row.get(name) for name in ("radius", "mass")} | {"sources": MappingProxyType(row["sources"])}
        yield from (Standard(name, falls=falls, **row) for name in names)


STANDARDS = {standard.name: standard for standard in _standards()}
"""Standards by name. The tripsometer of ISO 4662 and ASTM D1054 are left out: no source had their numbers."""


# Result of a test of rebound resilience: a table over temperature and base, a picture, warnings.

COLUMNS = {
    "rebound_resilience": Quantity("rebound_resilience", Dimension("percentage", "%"), "rebound resilience", r"$R$"),
    **{name: OUTPUTS[name] for name in ("contact_time", "max_indentation_depth", "max_contact_radius", "max_force")},
    "loss_tangent": CONTACT_TANGENT,
}
"""Columns of the result."""

# Columns of the printed table: heading, factor from SI, format.
_SHOWN = {
    "rebound_resilience": ("R [%]", 1.0, "{:.2f}"),
    "contact_time": ("contact [ms]", 1e3, "{:.3g}"),
    "max_indentation_depth": ("depth [mm]", 1e3, "{:.3g}"),
    "max_contact_radius": ("radius [mm]", 1e3, "{:.3g}"),
    "max_force": ("force [N]", 1.0, "{:.4g}"),
    "loss_tangent": ("loss tangent", 1.0, "{:.3g}"),
}
_TREND = "R is a trend: rebound tests are at the edge of small strain, and the side of the pad is free."


@dataclass(frozen=True, eq=False, repr=False)
class Resilience(Result):
    """Rebound resilience of a material in a standard test; `resilience` returns it.

    `plot` shows the resilience and the contact time, over temperature if there are several.

    The arrays have the shape (n_temperature, n_base), or (n_base,) without temperatures.

    Attributes
    ----------
    standard : Standard
        The test with the numbers that were used; `sources` has the source of each number.
    material : Material
        Material of the pad.
    base : tuple of str
        How the pad is held.
    temperature : array or None
        Temperatures [K], if any were given.
    rebound_resilience : array
        R = e^2 [%]; 0 where the body stays.
    contact_time : array
        Duration of contact [s]; infinite where the body stays.
    max_indentation_depth, max_contact_radius, max_force : array
        Largest depth [m], contact radius [m] and force [N].
    loss_tangent : array
        Loss tangent [-] of the material at the angular frequency pi over the contact time.
    validity : Validity
        Report on the assumptions of the theory: the worst of each.
    notes : tuple of str
        Ways to hold the pad that were left out, with the reason.
    """

    _numbers = ("base", "temperature", *COLUMNS, "warnings", "validity")
    _picture = "rebound_resilience.overview"

    standard: Standard
    material: Material
    base: tuple[str, ...]
    temperature: Array | None
    rebound_resilience: Array
    contact_time: Array
    max_indentation_depth: Array
    max_contact_radius: Array
    max_force: Array
    loss_tangent: Array
    validity: Validity
    notes: tuple[str, ...] = ()

    def __post_init__(self) -> None:
        if self.temperature is None:
            for name in COLUMNS:
                object.__setattr__(self, name, getattr(self, name)[0])

    @property
    def frequency(self) -> Array:
        """Frequency 1/(2T) [Hz] of contacts that last T."""
        return 0.5 / self.contact_time

    @property
    def warnings(self) -> list[str]:
        """Doubtful assumptions, with numbers, and the general limit of these tests."""
        return [*self.validity.warnings, *self.notes, _TREND]

    def to_dataset(self) -> xarray.Dataset:
        """Return the dataset of all columns over `temperature` and `base`, with units."""
        import xarray as xr

        dims = ("base",) if self.temperature is None else ("temperature", "base")
        data = {name: (dims, getattr(self, name), quantity.attributes) for name, quantity in COLUMNS.items()}
        coordinates: dict[str, Any] = {"base": list(self.base)}
        if self.temperature is not None:
            coordinates["temperature"] = ("temperature", self.temperature, INPUTS["temperature"].attributes)
        return xr.Dataset(data, coordinates, {"standard": self.standard.name, "material": self.material.name or ""})

    @property
    def table(self) -> pandas.DataFrame:
        """Table as texts in mm, ms and N, a row for each temperature and base."""
        frame = self.to_dataset().to_dataframe()
        shown = {
            head: [form.format(factor * value) for value in frame[name]]
            for name, (head, factor, form) in _SHOWN.items()
        }
        return type(frame)(shown, index=frame.index)

    def to_dict(self) -> dict[str, Any]:
        """Return plain numbers and texts, in SI apart from R."""
        names = ("name", "words", "radius", "mass", "velocity", "thickness", "sources")
        standard = {name: plain(getattr(self.standard, name)) for name in names}
        units = {name: quantity.unit for name, quantity in COLUMNS.items()}
        return {"standard": standard, "units": units} | super().to_dict()

    @property
    def heading(self) -> str:
        """The test in one line."""
        test = self.standard
        return (
            f"{test.name}, {test.words}: sphere of {2e3 * (test.radius or 0.0):.4g} mm, "
            f"{1e3 * (test.mass or 0.0):.4g} g, {test.velocity:.3g} m/s, pad of {1e3 * test.thickness:.4g} mm"
        )

    def summary(self, title: str = "") -> Summary:
        """Return the table over temperature and base, sources and warnings, which `print` and notebooks show."""
        table = self.table.reset_index()
        if self.temperature is not None:
            table["temperature"] = [celsius(kelvin) for kelvin in table["temperature"]]
        rows = [tuple(map(str, row)) for row in table.itertuples(index=False)]
        heads = tuple("temperature [°C]" if name == "temperature" else str(name) for name in table.columns)
        sources = [
            f"{name}: {text.partition(': ')[2]} [{text.partition(':')[0]}]"
            for name, text in self.standard.sources.items()
        ]
        return Summary(title or self.heading, Table(heads, rows), sources, warnings=self.warnings)

    @property
    def _short(self) -> str:
        values = ", ".join(f"{value:.4g} %" for value in self.rebound_resilience.ravel()[:4])
        return f"{self.standard.name}: {values}{', ...' if self.rebound_resilience.size > 4 else ''}"


# Rebound resilience of a material in a standard test.

BASES = ("bonded", "frictionless", "half-space")
"""Ways to hold the pad. The holder of a test is between bonded and frictionless; a half-space is a thick pad."""


def resilience(
    material: Material,
    standard: str = "ISO 4662",
    *,
    temperature: ArrayLike | None = None,
    base: str | Sequence[str] | None = None,
    thickness: float | None = None,
    tip_radius: float | None = None,
    mass: float | None = None,
    rtol: float = 1e-9,
) -> Resilience:
    """Return the rebound resilience R = e^2 of a material in a standard test, at temperatures.

    Parameters
    ----------
    material : Material
        Material of the pad.
    standard : {"ISO 4662", "DIN 53512", "ASTM D7121", "ASTM D2632", "ISO 8307", "ASTM D3574"}
        The test: indentor, mass, velocity and thickness of the pad, with the source of each number in
        `result.standard.sources`.
    temperature : float or array, optional
        Temperatures [K]; the material needs a shift. By default that of the material.
    base : str or sequence of str
        How the pad is held: "bonded", "frictionless", between which the holder of a test is, or "half-space", a thick
        pad. By default all that hold for the material: a bonded pad needs a Poisson ratio that is constant in time,
        or near 1/2.
    thickness : float, optional
        Thickness of the pad [m] in place of that of the standard, from 0.1 mm to 1 m.
    tip_radius : float, optional
        Radius of the indentor [m] in place of that of the standard.
    mass : float, optional
        Mass of the indentor [kg] in place of that of the standard. ASTM D2632 needs the radius and the mass, because
        no reliable source had them.
    rtol : float
        Relative error of the coefficient of restitution, from 1e-12 to 1e-2.

    Returns
    -------
    Resilience
        R in per cent, contact time, depth, contact radius, force and loss tangent, with a table and a picture.

    Raises
    ------
    InputError
        If the standard or base is not known, a number is out of range, or a temperature is given without a shift.
    SolverError
        If a solve fails.

    Notes
    -----
    The impact is that of a rigid parabola of the radius of the indentor, without friction. The weight acts where the
    body falls. These tests are at the edge of small strain: a/R is near 1 for soft rubber. R is a trend then, not a
    certificate; `result.warnings` has the numbers.

    Examples
    --------
    >>> import math
    >>> import restitution as rs
    >>> rubber = rs.Material(rs.PronySeries(1e6, [2e5, 8e5], [1e-3, 1e-4]), math.inf)
    >>> result = rs.resilience(rubber, "ASTM D7121", base="half-space")
    >>> print(result.rebound_resilience.round(1))
    [77.5]
    """
    single_material("material", material)
    test = STANDARDS[choice("standard", standard, STANDARDS)]
    named = [base] if isinstance(base, str) else [] if base is None else items("base", base, "must be names of bases")
    bases = tuple(choice("base", name, BASES) for name in named)
    if base is not None and not bases:
        raise InputError("base", rule="must name at least one")
    single("rtol", within("rtol", rtol, 1e-12, 1e-2))
    radius = test.radius if tip_radius is None else single_positive("tip_radius", tip_radius, "m")
    weighed = test.mass if mass is None else check_single("mass", mass)
    if radius is None or weighed is None:
        name = "tip_radius" if radius is None else "mass"
        raise InputError(name, rule=f"must be given: no reliable source had that of {test.name}")
    size = test.thickness if thickness is None else check_single("thickness", thickness)
    within("thickness", size, 1e-4, 1.0, INPUTS["thickness"].unit)
    sizes = {"radius": tip_radius, "mass": mass, "thickness": thickness}
    sources = {name: source for name, source in test.sources.items() if sizes.get(name) is None}
    test = replace(test, radius=radius, mass=weighed, thickness=size, sources=sources)
    temperatures = None if temperature is None else np.atleast_1d(check("temperature", temperature))
    if temperatures is not None and (temperatures.ndim != 1 or not temperatures.size):
        raise InputError("temperature", rule="must be a number or a list of numbers", unit="K")
    for held in bases:
        _check_pad(material, held, radius, size)
    bases, notes = (bases, ()) if bases else _bases(material, radius, size)
    if not bases:
        raise InputError("base", rule=f"must be another: {'; '.join(notes)}")
    force = weighed * STANDARD_GRAVITY if test.falls else 0.0
    pads = [
        Impact(material, geometry, weighed, test.velocity, external_force=force, body_size=stated)
        for geometry, stated in (_pad(held, radius, size) for held in bases)
    ]
    materials = [material] if temperatures is None else [material.at(kelvin) for kelvin in temperatures.tolist()]
    impacts = [varied(pad, {"material": heated}, "bulk_modulus") for heated in materials for pad in pads]
    columns = solve_columns(impacts, rtol)
    for status in columns["status"]:
        if Status(int(status)).failed:
            raise SolverError(Status(int(status)))
    outputs = _columns(columns, impacts, len(bases))
    return Resilience(
        test, material, bases, temperatures, validity=_validity(columns, impacts), notes=notes, **outputs
    )


# Both make the Poisson ratio of a rubber constant; the second one is compressible.
_BONDED = '; a rubber with bulk_modulus = "incompressible" or poisson_ratio = 0.4995 instead of a bulk modulus has it'


def _bases(material: Material, radius: float, thickness: float) -> tuple[tuple[str, ...], tuple[str, ...]]:
    """Return the ways to hold a pad of a material, and why others are left out."""
    bases, notes = list[str](), list[str]()
    for base in BASES:
        try:
            _check_pad(material, base, radius, thickness)
        except InputError as error:
            notes.append(f"a {base} pad is left out: {error}")
        else:
            bases.append(base)
    return tuple(bases), tuple(notes)


def _check_pad(material: Material, base: str, radius: float, thickness: float) -> None:
    """Refuse a way to hold the pad that does not hold for the material."""
    try:
        Contact(material, _pad(base, radius, thickness)[0])
    except InputError as error:
        remedy = _BONDED if base == "bonded" else ""
        raise InputError(error.field, error.value, f"{error.rule}{remedy}", error.unit) from None


def _pad(base: str, radius: float, thickness: float) -> tuple[Geometry, float | None]:
    """Return the geometry of the contact, and the size of the pad where the geometry does not contain it."""
    if base == "half-space":
        return Parabola(radius), thickness
    return Layer(Parabola(radius), thickness, cast("Base", base), strict=True), None


def _columns(columns: dict[str, Array], impacts: list[Impact], n_bases: int) -> dict[str, Array]:
    time = columns["contact_time"]
    omega = math.pi / np.where(np.isfinite(time), time, 1.0)
    tangent = [impact.reduced_modulus.loss_tangent(rate) for impact, rate in zip(impacts, omega, strict=True)]
    values: dict[str, Any] = {
        **columns,
        "rebound_resilience": 100.0 * columns["restitution_coefficient"] ** 2,
        "loss_tangent": np.where(np.isfinite(time), tangent, np.nan),
    }
    return {name: values[name].reshape(-1, n_bases) for name in COLUMNS}


def _validity(columns: dict[str, Array], impacts: list[Impact]) -> validity.Validity:
    outputs = {name: columns[name] for name in validity.COLUMNS}
    velocity, mass = (np.array([getattr(impact, name) for impact in impacts]) for name in ("velocity", "mass"))
    measures = validity.numbers([impact.contact for impact in impacts], **outputs, velocity=velocity, mass=mass)
    # The indentor is the tip of a heavier body.
    return validity.Validity(tuple(check for check in validity.report(measures) if check.kind != "density"))
