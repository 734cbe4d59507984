"""Oscillating indentation: harmonics of force and depth, and moduli as they are read and as they are."""

from __future__ import annotations

import math
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING, Any, TypedDict, Unpack, overload

import numpy as np
from numpy.typing import ArrayLike, NDArray

from restitution.axes import Axes, aligned, unnamed
from restitution.checks import (
    Array,
    common_shape,
    is_iterable,
    positive,
    single_nonnegative,
    single_positive,
    whole,
    within,
)
from restitution.contact.geometry import Contact, Geometry, of_type
from restitution.errors import InputError
from restitution.indentation.history import MOST_CYCLES, History
from restitution.indentation.panels import PanelSolution, solve_by_panels
from restitution.indentation.rim import steady_states
from restitution.indentation.solve import contact_of
from restitution.kernel.plain import single_problem
from restitution.material.prony import PronySeries
from restitution.material.viscoelastic import Material
from restitution.quantities import CONSTANTS, HISTORY, INPUTS, MODULI, Quantity, dataset
from restitution.result import Outcome, Result, Summary, Table, of_values, plain_symbol
from restitution.units import ENERGY, FORCE, FREQUENCY, LENGTH, MODULUS, NUMBER, Dimension, in_words
from restitution.validity import Check, Validity, validity

if TYPE_CHECKING:
    import xarray

# Harmonics, those of a result, and parts of the rim; shares of a period at which there are curves.
_ORDERS, _KEPT, _PARTS = 64, 8, 6
_SHARES = np.linspace(0.0, 1.0, 257)
_COLUMNS: dict[str, Quantity] = {
    "storage_modulus": MODULI["storage_modulus"],
    "loss_modulus": MODULI["loss_modulus"],
    "apparent_storage_modulus": Quantity("apparent_storage_modulus", MODULUS, "E' as the textbook reads it"),
    "apparent_loss_modulus": Quantity("apparent_loss_modulus", MODULUS, "E'' as the textbook reads it"),
    "storage_error": Quantity("storage_error", NUMBER, "error of the reading of E'"),
    "loss_error": Quantity("loss_error", NUMBER, "error of the reading of E''"),
    "min_contact_radius": Quantity("min_contact_radius", LENGTH, "smallest contact radius"),
    "max_contact_radius": Quantity("max_contact_radius", LENGTH, "largest contact radius"),
    "contact_share": Quantity("contact_share", NUMBER, "share of the period in contact"),
    "dissipated": Quantity("dissipated", ENERGY, "energy dissipated in a period"),
}
"""Numbers of arrays of oscillations."""
# Points of a period at which the contact radius is looked at.
_SAMPLES = 2048
_MOST_CYCLES = 512
# What may be left of the creep in a steady state, of rtol.
_LEFT = 100.0


WAVE_LIMIT = 0.01
"""Largest contact radius over c/w: the inertia of the half-space then adds 0.0085 to the loss tangent."""
# Radiation of a rigid disc on a half-space, over its stiffness and a w/c, at any Poisson ratio.
_LYSMER = 0.85


class OscillationStatus(Outcome):
    """What the numbers of an oscillation are of, with a `message` for each member."""

    STEADY = 0, "the steady state"
    LAST_CYCLE = 1, "the last of the cycles that were asked for"
    NOT_STEADY = 2, "the last cycle; the steady state was not reached"


@dataclass(frozen=True, eq=False, repr=False)
class Oscillation(Result):
    """Oscillating indentation; SI units.

    `plot` shows force over depth with the reading of the textbook, and both over time.

    Attributes
    ----------
    time : array, shape (n,)
        Times t [s] of one period; the oscillation of what is prescribed is `sin(2 pi frequency t)`.
    indentation_depth, force : array, shape (n,)
        Depth d [m] and force F [N] at these times.
    depth_harmonics, force_harmonics : array of complex, shape (n_harmonics,)
        Complex amplitudes: `F = F_0 + sum_n Im(F_n exp(2 pi i n frequency t))`, and the same for the depth; the
        first is the mean.
    frequency : float
        [Hz].
    apparent_modulus : complex
        Reading of the textbook, `E' + i E'' = F_1/(2 a d_1)` [Pa], with the stiffness radius a at the mean depth.
    complex_modulus : complex
        Reduced complex modulus E*(2 pi i frequency) [Pa] of the materials, which it is meant to be.
    min_contact_radius, max_contact_radius : float
        Smallest and largest contact radius [m]; the smallest is 0 where the contact is lost in each period.
    contact_share : float
        Share of the period in contact.
    status : OscillationStatus
        Whether the numbers are those of the steady state.
    contact : Contact
        Materials and profile.
    """

    _numbers = (
        "frequency", "storage_modulus", "loss_modulus", "apparent_storage_modulus", "apparent_loss_modulus",
        "storage_error", "loss_error", "min_contact_radius", "max_contact_radius", "contact_share", "dissipated",
        "status", "warnings", "validity",
    )  # fmt: skip
    _picture = "oscillation.overview"

    time: Array = field(repr=False)
    indentation_depth: Array = field(repr=False)
    force: Array = field(repr=False)
    depth_harmonics: NDArray[Any] = field(repr=False)
    force_harmonics: NDArray[Any] = field(repr=False)
    frequency: float
    apparent_modulus: complex
    complex_modulus: complex
    min_contact_radius: float
    max_contact_radius: float
    contact_share: float
    status: OscillationStatus
    contact: Contact

    @property
    def storage_modulus(self) -> float:
        """E' [Pa] of the materials."""
        return self.complex_modulus.real

    @property
    def loss_modulus(self) -> float:
        """E'' [Pa] of the materials."""
        return self.complex_modulus.imag

    @property
    def apparent_storage_modulus(self) -> float:
        """E' [Pa] as the textbook reads it."""
        return self.apparent_modulus.real

    @property
    def apparent_loss_modulus(self) -> float:
        """E'' [Pa] as the textbook reads it."""
        return self.apparent_modulus.imag

    @property
    def storage_error(self) -> float:
        """Error of the reading of E', `apparent/true - 1`."""
        return self.apparent_modulus.real / self.complex_modulus.real - 1.0

    @property
    def loss_error(self) -> float:
        """Error of the reading of E'', `apparent/true - 1`; NaN where the material has no loss."""
        loss = self.complex_modulus.imag
        return self.apparent_modulus.imag / loss - 1.0 if loss > 0.0 else math.nan

    @property
    def dissipated(self) -> float:
        """Energy dissipated in a period [J], `pi sum_n n Im(F_n conj(d_n))`."""
        n = np.arange(self.force_harmonics.size)
        return float(math.pi * np.sum(n * np.imag(self.force_harmonics * np.conj(self.depth_harmonics))))

    @property
    def validity(self) -> Validity:
        """Assumptions of the theory, each with its number, its limit and advice.

        Waves are compared by ``a w/c`` with the shear wave speed c at the frequency: inertia of the half-space adds
        0.85 of it to the loss tangent (Lysmer and Richart, J. Soil Mech. Found. Div. ASCE 92, 1966).
        """
        omega, deepest = 2.0 * math.pi * self.frequency, float(self.indentation_depth.max())
        # The shortest time of a contact is a third of depth over velocity: here 1/w.
        report = validity(
            self.contact, max_contact_radius=self.max_contact_radius, max_indentation_depth=deepest,
            velocity=omega * deepest / 3.0, contact_time=1.0 / self.frequency,
        )  # fmt: skip
        return Validity(tuple(self._waves(check) if check.kind == "waves" else check for check in report))

    def _waves(self, check: Check) -> Check:
        """Return the check of waves, for an oscillation."""
        omega, words = 2.0 * math.pi * self.frequency, "contact radius over wave length/2 pi"
        bodies = [body for body in self.contact.materials if body.density is not None]
        numbers = [
            self.max_contact_radius * omega / math.sqrt(abs(complex(body.shear.complex_modulus(omega))) / body.density)
            for body in bodies
        ]
        is_complete = len(bodies) == len(self.contact.materials)
        worst = max(numbers, default=0.0)
        if not is_complete and worst <= WAVE_LIMIT:
            return replace(check, words=words, value=None, threshold=WAVE_LIMIT, exceeded=False)
        text = (
            f"waves: a w/c is {worst:.3g}, {'above' if worst > WAVE_LIMIT else 'not above'} the limit {WAVE_LIMIT:g}"
        )
        text += f"; inertia adds {_LYSMER * worst:.2g} to the loss tangent"
        return Check("waves", words, worst, WAVE_LIMIT, worst > WAVE_LIMIT, text, "Take a lower frequency or depth.")

    @property
    def warnings(self) -> list[str]:
        """Messages of the assumptions that are doubtful."""
        return self.validity.warnings

    @property
    def history(self) -> xarray.Dataset:
        """Depth and force over one period, with units."""
        columns = {name: (getattr(self, name), HISTORY[name]) for name in ("time", "indentation_depth", "force")}
        return dataset("time", columns, {"frequency": self.frequency})

    def summary(self, title: str = "") -> Summary:
        """Return the table of the oscillation, which `print` and notebooks show."""
        apparent, true = self.apparent_modulus, self.complex_modulus
        values = [
            ("frequency", "f", self.frequency, "Hz"),
            ("mean force", "F_0", float(self.force_harmonics[0].real), FORCE.unit),
            ("amplitude of the force", "F_1", float(abs(self.force_harmonics[1])), FORCE.unit),
            ("mean depth", "d_0", float(self.depth_harmonics[0].real), LENGTH.unit),
            ("amplitude of the depth", "d_1", float(abs(self.depth_harmonics[1])), LENGTH.unit),
            ("storage modulus", plain_symbol(MODULI["storage_modulus"].symbol), true.real, MODULUS.unit),
            ("as F_1/(2 a d_1) reads it", "", apparent.real, MODULUS.unit),
            ("error of the reading", "", self.storage_error, ""),
            ("loss modulus", plain_symbol(MODULI["loss_modulus"].symbol), true.imag, MODULUS.unit),
            ("as F_1/(2 a d_1) reads it", "", apparent.imag, MODULUS.unit),
            ("error of the reading", "", self.loss_error, ""),
            ("smallest contact radius", "a_min", self.min_contact_radius, LENGTH.unit),
            ("largest contact radius", "a_max", self.max_contact_radius, LENGTH.unit),
            ("share of the period in contact", "", self.contact_share, ""),
        ]
        lines = (self.status.message,)
        return Summary(title or "Oscillating indentation", of_values(values), lines, warnings=self.warnings)

    @property
    def _short(self) -> str:
        modulus = in_words(self.apparent_modulus.real, MODULUS.unit)
        return f"E' reads {modulus}, {100 * self.storage_error:+.2g} %, {self.status.name}"


@dataclass(frozen=True, eq=False, repr=False)
class OscillationArray(Result):
    """Many oscillating indentations; each number of `Oscillation` is an array of this shape.

    `plot` shows how far the readings of the textbook are off, over the frequency.

    Attributes
    ----------
    rows : tuple of Oscillation
        The oscillations, raveled.
    shape : tuple of int
        Shape of the arrays.
    axes : Axes
        Names of the dimensions.
    inputs : dict of str to array
        Mean, amplitude and frequency.
    """

    _numbers = ("inputs", *_COLUMNS, "status", "warnings")
    _picture = "oscillation.errors"

    rows: tuple[Oscillation, ...] = field(repr=False)
    shape: tuple[int, ...]
    axes: Axes = field(repr=False)
    inputs: dict[str, Array] = field(repr=False)

    def __getattr__(self, name: str) -> Array:
        """Return a number of all oscillations by the name that it has in `Oscillation`."""
        if name not in _COLUMNS and name != "status":
            raise AttributeError(f"{type(self).__name__} has no {name}")
        return np.array([getattr(row, name) for row in self.rows]).reshape(self.shape)

    def __getitem__(self, index: Any) -> Oscillation:
        """Return one oscillation of the array."""
        places = np.arange(len(self.rows)).reshape(self.shape)[index]
        if np.ndim(places):
            raise InputError("index", index, f"must be {len(self.shape)} whole numbers")
        return self.rows[int(places)]

    def to_dataset(self) -> xarray.Dataset:
        """Return moduli, readings, their errors and contact radii over the dimensions of the numbers, with units."""
        names = {"depth": LENGTH, "force": FORCE, "amplitude": self._swing, "frequency": FREQUENCY}
        columns = {
            name: (values, Quantity(name, names[name], name).attributes)
            for name, values in self.inputs.items() if name not in self.axes.places.coords
        }  # fmt: skip
        columns |= {name: (getattr(self, name), quantity.attributes) for name, quantity in _COLUMNS.items()}
        columns["status"] = self.status, OscillationStatus.attributes()
        data = self.axes.dataset(columns, {})
        quantities = CONSTANTS | INPUTS | {name: Quantity(name, kind, name) for name, kind in names.items()}
        for name, coordinate in data.coords.items():
            if (quantity := quantities.get(str(name))) is not None:
                coordinate.attrs |= quantity.attributes
        return data

    @property
    def _swing(self) -> Dimension:
        return LENGTH if "depth" in self.inputs else FORCE

    @property
    def warnings(self) -> list[str]:
        """Messages of the assumptions that are doubtful, each for the worst of the oscillations."""
        worst: dict[str, Check] = {}
        for check in (each for row in self.rows for each in row.validity if each.exceeded):
            before = worst.get(check.kind)
            if before is None or (check.value or 0.0) > (before.value or 0.0):
                worst[check.kind] = check
        return [check.warning for check in worst.values()]

    def summary(self, title: str = "") -> Summary:
        """Return a table of the oscillations, which `print` and notebooks show."""
        columns = {name: values.ravel() for name, values in self.inputs.items()}
        columns |= {name: getattr(self, name).ravel() for name in _COLUMNS if not name.startswith("apparent")}
        rows = [tuple(f"{value:.4g}" for value in row) for row in zip(*columns.values(), strict=True)]
        table = Table(tuple(name.replace("_", " ") for name in columns), rows)
        messages = tuple(dict.fromkeys(row.status.message for row in self.rows))
        return Summary(title or "Oscillating indentations", table, messages, warnings=self.warnings)

    @property
    def _short(self) -> str:
        return f"{len(self.rows)} oscillations"


class _Options(TypedDict, total=False):
    cycles: int | None
    rise_time: float | None
    hold_time: float
    counter_material: Material | None
    rtol: float


@overload
def oscillate(  # pyright: ignore[reportOverlappingOverload]
    material: Material, profile: Geometry, *, depth: float | None = None, force: float | None = None,
    amplitude: float, frequency: float, **options: Unpack[_Options],
) -> Oscillation: ...  # fmt: skip
@overload
def oscillate(
    material: Material, profile: Geometry, *, depth: ArrayLike | None = None, force: ArrayLike | None = None,
    amplitude: ArrayLike, frequency: ArrayLike, **options: Unpack[_Options],
) -> OscillationArray: ...  # fmt: skip
def oscillate(
    material: Material,
    profile: Geometry,
    *,
    depth: ArrayLike | None = None,
    force: ArrayLike | None = None,
    amplitude: ArrayLike,
    frequency: ArrayLike,
    cycles: int | None = None,
    rise_time: float | None = None,
    hold_time: float = 0.0,
    counter_material: Material | None = None,
    rtol: float = 1e-8,
) -> Oscillation | OscillationArray:
    """Return an oscillation about a mean depth or force, or many of them, and what the textbook reads from them.

    Parameters
    ----------
    material : Material
        Material of the target, or an array of them.
    profile : Geometry
        Profile of the indenter, or another geometry, with scalar parameters.
    depth, force : float, array or DataArray
        Mean of the prescribed depth [m] or force [N]; exactly one of the two. Arrays of this, of the amplitude, of
        the frequency and of materials broadcast against each other; DataArrays, also as constants of materials, keep
        their names and coordinates.
    amplitude : float, array or DataArray
        Amplitude of the depth [m], or of the force [N], > 0; that of a force is below its mean.
    frequency : float, array or DataArray
        Frequency f [Hz], > 0.
    cycles : int, optional
        Number of cycles, at most 10 000; the last one counts. By default the steady state.
    rise_time, hold_time : float
        Duration [s] of the ramp to the mean, a period by default, and of the hold before the first of the `cycles`.
    counter_material : Material, optional
        Material of the indenter, or an array of them; rigid by default.
    rtol : float
        Error of force and depth over their largest value; in [1e-11, 1e-2].

    Returns
    -------
    Oscillation or OscillationArray
        Harmonics, moduli as read and as they are, contact radii; for arrays, the numbers of each oscillation.

    Raises
    ------
    InputError
        If an argument is out of its range or of another type, or the bodies do not touch.

    Notes
    -----
    The reading `F_1 = 2 a E*(i w) d_1` takes the contact radius as constant. The rim of the contact leaves and
    touches in each period; the error is of first order in d_1/d_0 but for a flat punch. In the steady state of a
    depth each element repeats its own cycle: those of small s follow for ever, with E*(i w); each of the rim has one
    time at which its load vanishes and one at which its gap closes, two equations for the periodic state.

    Examples
    --------
    A tenth of the depth is too much:

    >>> import restitution as rs
    >>> solid = rs.Material(rs.PronySeries(0.25, [1.0], [1.0]), bulk=math.inf)
    >>> wave = rs.oscillate(solid, rs.Parabola(1.0), depth=1.0, amplitude=0.1, frequency=0.5 / math.pi)
    >>> print(f"{100 * wave.storage_error:.2f} %, {100 * wave.loss_error:.2f} %")
    -3.76 %, -7.31 %

    Over the frequency:

    >>> waves = rs.oscillate(solid, rs.Parabola(1.0), depth=1.0, amplitude=0.1, frequency=[0.05, 0.5])
    >>> print((100 * waves.loss_error).round(2))
    [ -2.33 -11.06]
    """
    if (depth is None) == (force is None):
        raise InputError("depth, force", rule="exactly one of the two must be given: depth= or force=")
    name = "depth" if force is None else "force"
    numbers = {name: depth if force is None else force, "amplitude": amplitude, "frequency": frequency}
    bodies: dict[str, Any] = {"material": material}
    if counter_material is not None:
        bodies["counter_material"] = counter_material
    for each, body in bodies.items():
        of_type(each, body, Material)
    numbers, axes = aligned(bodies | numbers)
    bodies = {each: numbers.pop(each) for each in bodies}
    options = {"cycles": cycles, "rise_time": rise_time, "hold_time": hold_time, "rtol": rtol}
    several = any(map(is_iterable, numbers.values())) or any(body.shape for body in bodies.values())
    if axes is None and not several:
        return _single(contact_of(material, profile, counter_material), name, *numbers.values(), **options)
    unit = "m" if name == "depth" else "N"
    checked = {each: positive(each, value, "Hz" if each == "frequency" else unit) for each, value in numbers.items()}
    shapes = {each: np.shape(value) for each, value in checked.items()}
    shape = common_shape(shapes | {each: body.shape for each, body in bodies.items() if body.shape})
    columns = {each: np.broadcast_to(value, shape) for each, value in checked.items()}
    waves = np.stack([column.ravel() for column in columns.values()], axis=1).tolist()
    if not waves:
        raise InputError(", ".join(columns), rule="must hold at least one number")
    contacts = _contacts(bodies, profile, shape)
    for contact, (mean, swing, _) in zip(contacts, waves, strict=True):
        _refuse_beyond(contact, name, mean, swing)
    rows = tuple(_single(contact, name, *wave, **options) for contact, wave in zip(contacts, waves, strict=True))
    return OscillationArray(rows, shape, axes or unnamed(shape), columns)


def _contacts(bodies: dict[str, Material], profile: Geometry, shape: tuple[int, ...]) -> list[Contact]:
    """Return the contact of each row; rows of one material share it."""
    places = np.arange(math.prod(shape))
    kinds = [
        np.broadcast_to(np.arange(math.prod(body.shape)).reshape(body.shape), shape).ravel()
        for body in bodies.values()
    ]
    _, first, which = np.unique(np.stack(kinds), axis=1, return_index=True, return_inverse=True)
    contacts: list[Contact] = []
    for place in places[first]:
        material, *counter = (body.take(shape, place) for body in bodies.values())
        contacts.append(contact_of(material, profile, counter[0] if counter else None))
    return [contacts[n] for n in which.ravel()]


def _refuse_beyond(contact: Contact, name: str, mean: float, swing: float) -> None:
    """Refuse a force that would pull, and a depth beyond the end of the profile."""
    if name == "force" and swing >= mean:
        raise InputError("amplitude", swing, f"must be < {mean:g} N, the mean, as there is no adhesion", "N")
    most = float(np.min(contact.profile.max_depth))
    if name == "depth" and mean + swing > most:
        raise InputError("depth", mean + swing, f"must be <= {most:g} m, {contact.profile.end}", "m")


def _single(
    contact: Contact, name: str, mean: Any, swing: Any, rate: Any, *, cycles: int | None, rise_time: float | None,
    hold_time: float, rtol: float,
) -> Oscillation:  # fmt: skip
    """Return one oscillation of the depth or the force."""
    within("rtol", rtol, 1e-11, 1e-2)
    unit = "m" if name == "depth" else "N"
    mean, swing = single_positive(name, mean, unit), single_positive("amplitude", swing, unit)
    rate = single_positive("frequency", rate, "Hz")
    _refuse_beyond(contact, name, mean, swing)
    rise = 1.0 / rate if rise_time is None else single_positive("rise_time", rise_time, "s")
    rest = single_nonnegative("hold_time", hold_time, "s")
    series, wave, count = contact.reduced_modulus, (mean, swing, rate), None
    if cycles is not None:
        count = whole("cycles", cycles, 1, MOST_CYCLES)

    def solved() -> tuple[PanelSolution, int, OscillationStatus]:
        if count is None:
            return _until_steady(contact, series, name, wave, (rise, rest), rtol)
        solution = _cycles(contact, series, name, wave, (rise, rest), count, rtol)
        return solution, count, OscillationStatus.LAST_CYCLE

    if not contact.profile.separable:
        contact.warn_if_approximate()
        if name == "depth":
            radius = float(np.asarray(contact.profile.contact_radius(mean + swing)))
        else:
            radius = solved()[0].max_contact_radius
        series = contact.profile.effective_moduli(contact.material, np.array(radius)).row(0)
    if count is None and name == "depth":
        return _steady(contact, series, mean, swing, rate)
    return _last_cycle(contact, series, *solved(), rate, rise + rest)


def _result(
    contact: Contact, series: PronySeries, curves: tuple[Array, Array], harmonics: NDArray[Any], rate: float,
    radii: tuple[float, float], share: float, status: OscillationStatus,
) -> Oscillation:  # fmt: skip
    """Return an oscillation of depths and forces over `_SHARES` of a period, and their harmonics, shape (2, n)."""
    depths, forces = harmonics
    a = float(np.asarray(contact.profile.stiffness_radius(depths[0].real)))
    true = complex(series.complex_modulus(2.0 * math.pi * rate))
    return Oscillation(
        _SHARES / rate, *curves, depths, forces, rate, complex(forces[1] / (2.0 * a * depths[1])), true, *radii, share,
        status, contact,
    )  # fmt: skip


@single_problem()
def _steady(contact: Contact, series: PronySeries, mean: float, swing: float, rate: float) -> Oscillation:
    """Return the steady state under a prescribed depth."""
    if series.is_liquid:
        raise InputError("cycles", rule="must be given for a liquid, which yields until the indenter has no load")
    profile, unit = contact.profile, np.ones(1)
    steady = steady_states(
        profile, series.broadcast_to((1,)), mean * unit, swing * unit, rate * unit, count=_ORDERS, parts=_PARTS
    )
    if not steady.solved[0]:
        raise InputError("cycles", rule="must be given: the steady state of this oscillation is not found")
    harmonics = np.zeros((2, _ORDERS), dtype=complex)
    harmonics[0, :2], harmonics[1] = (mean, swing), steady.harmonics[0]
    waves = np.exp(2j * math.pi * np.arange(_ORDERS)[:, None] * _SHARES)
    depths, forces = np.real(harmonics[:, :1]) + np.imag(harmonics[:, 1:] @ waves[1:])
    radii = tuple(float(np.asarray(profile.contact_radius(d))) for d in (steady.innermost[0], mean + swing))
    # The contact is lost where no element follows for ever.
    least = radii[0] if steady.innermost[0] > 0.0 else 0.0
    share = float(steady.share[0])
    curves, kept = (depths, np.maximum(forces, 0.0)), harmonics[:, :_KEPT]
    return _result(contact, series, curves, kept, rate, (least, radii[1]), share, OscillationStatus.STEADY)


def _cycles(
    contact: Contact, series: PronySeries, name: str, wave: tuple[float, float, float], before: tuple[float, float],
    count: int, rtol: float,
) -> PanelSolution:  # fmt: skip
    """Return the solution over a ramp, a hold and a number of cycles."""
    (mean, swing, rate), (rise, rest) = wave, before
    # One cycle for all: fits of late ones would have the rounding of their times.
    quarters = np.arange(5) / (4.0 * rate)
    cycle = History.from_function(lambda t: mean + swing * np.sin(2.0 * math.pi * rate * t), quarters, name=name)
    lead = np.zeros((1 + (rest > 0.0), cycle.coefficients.shape[1]))
    lead[0, 1], lead[1:, 0] = mean, mean
    starts = rise + rest + np.arange(count + 1)[:, None] / rate + cycle.knots[:-1]
    knots = np.concatenate([[0.0, rise][: len(lead)], starts.ravel()[: starts.size - cycle.knots.size + 2]])
    history = History(knots, np.concatenate([lead, np.tile(cycle.coefficients, (count, 1))]))
    return solve_by_panels(contact.profile, series, history, name, rtol)


def _until_steady(
    contact: Contact, series: PronySeries, name: str, wave: tuple[float, float, float], before: tuple[float, float],
    rtol: float,
) -> tuple[PanelSolution, int, OscillationStatus]:  # fmt: skip
    """Return a solution whose last two cycles are alike, the number of cycles, and whether they are."""
    count, period = 8, 1.0 / wave[2]
    solution = _cycles(contact, series, name, wave, before, count, rtol)
    while True:
        stop = sum(before) + count * period
        times = stop - period * np.linspace(0.02, 0.98, 33)
        depth, _, force, _ = solution.at(times)
        earlier, _, weaker, _ = solution.at(times - period)
        change = max(np.abs(depth - earlier).max() / depth.max(), np.abs(force - weaker).max() / force.max())
        if change <= rtol and _left(series, stop, change / period) <= _LEFT * rtol:
            return solution, count, OscillationStatus.STEADY
        if 2 * count > _MOST_CYCLES:
            return solution, count, OscillationStatus.NOT_STEADY
        try:
            solution, count = _cycles(contact, series, name, wave, before, 2 * count, rtol), 2 * count
        except InputError:
            return solution, count, OscillationStatus.NOT_STEADY


def _left(series: PronySeries, time: float, rate: float) -> float:
    """Return a bound of what is left of the creep, over the depth, at a time [s] at which it changes at a rate [1/s].

    A slow part changes by nearly nothing in a period, and flow never ends.
    """
    creep = series.retardation
    if creep.fluidity > 0.0:
        return math.inf
    times, parts = creep.retardation_times, creep.branch_compliances
    shares = parts / (creep.instantaneous_compliance + parts.sum())
    return float(np.sum(np.minimum(shares * np.exp(-time / times), rate * times)))


def _last_cycle(
    contact: Contact, series: PronySeries, solution: PanelSolution, count: int, status: OscillationStatus, rate: float,
    start: float,
) -> Oscillation:  # fmt: skip
    """Return the numbers of the last of the cycles, which begin at a time [s]."""
    first, stop = start + (count - 1) / rate, solution.history.stop
    depth, _, force, _ = solution.at(np.minimum(first + _SHARES / rate, stop))
    # Steps end at the start of the cycle, and need not be periodic.
    times, weights, values = solution.quadrature()
    cycle = times > first
    orders = np.arange(_KEPT)
    waves = np.exp(-2j * math.pi * rate * orders * (times[cycle, None] - first)) * np.where(orders > 0, 2j, 1.0)
    harmonics = (values[[0, 2]][:, cycle] * (rate * weights[cycle])) @ waves
    parts = np.clip(rate * (solution.contact_intervals - first), 0.0, 1.0)
    share = float(np.sum(parts[:, 1] - parts[:, 0]))
    turns = solution.turning_times[solution.turning_times >= first]
    moments = np.minimum(first + np.arange(_SAMPLES + 1) / _SAMPLES / rate, stop)
    radius = np.append(solution.at(moments)[3], solution.at(turns, before=True)[3])
    radii = float(radius.min()), float(radius.max())
    return _result(contact, series, (depth, force), harmonics, rate, radii, share, status)
