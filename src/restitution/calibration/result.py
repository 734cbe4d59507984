"""Result of a calibration: numbers to type, what they give beside the exact answer, and text to paste."""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from importlib.metadata import version
from pathlib import Path
from typing import TYPE_CHECKING, Any, ClassVar, NamedTuple

import numpy as np
from numpy.typing import NDArray

from restitution.calibration.adhesive_laws import TypedAdhesive
from restitution.calibration.collisions import Collisions, TableLaw
from restitution.calibration.laws import TypedLaw
from restitution.calibration.tangential import FEWEST, Angles
from restitution.checks import Array
from restitution.files import write_text
from restitution.quantities import INPUTS, OUTPUTS, check, check_single
from restitution.result import Result, Summary, Table, draw, nullable, plain
from restitution.units import LENGTH, MASS, REDUCED, SI, SYSTEMS, TIME, Dimension, UnitSystem, reduced

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure


LEVELS = (0.01, 0.02, 0.05)
"""Errors of e for which `Calibration.within` gives the velocities."""

_E, _TIME = "restitution_coefficient", "contact_time"
_KINDS = {"": "exact", "calibrated_": "calibrated", "naive_": "as usually typed"}
_FINE = 2000
_FORMAT = "restitution calibration"
# Velocities that a screen shows.
_ROWS = 9


class TypedParameter(NamedTuple):
    """A number that a user of a code types: value, unit (empty for a plain number) and meaning."""

    value: float
    unit: str
    words: str


@dataclass(frozen=True, eq=False, repr=False)
class Calibration(Result):
    """A contact law of another code, calibrated to the exact coefficient of restitution; `calibrate` returns it.

    Attributes
    ----------
    target, words, source : str
        Name of the target, code and model, and the pages that define it.
    units : str
        Unit system of `parameters` and `snippet`.
    parameters, naive_parameters : dict of str to TypedParameter
        What to type, by the name in the code: value, unit and meaning; and what is usually typed: the storage modulus
        at the frequency pi/T of the middle collision, with the loss tangent there, or with its e.
    snippet : str
        Text to paste.
    wall : bool
        Whether the text is for a ball and a wall, not for two balls.
    collisions : Collisions
        Velocities, radii and the exact answers.
    law, naive_law : TypedLaw or TableLaw
        The laws with their numbers in SI; of an N-body code the coefficients over the velocity.
    angles : Angles or None
        With friction e_t over the angle of incidence: exact, and by the code.

    Notes
    -----
    The contact time of a law is the time until its force ends for good.
    """

    _numbers = (
        "target", "words", "source", "units", "wall", "warnings", "parameters", "naive_parameters", "largest_error",
        "snippet",
    )  # fmt: skip

    error_words: ClassVar[str] = "relative error of the calibrated coefficient"
    # Errors of e for people: name of the column, factor, unit and form.
    error_column: ClassVar[tuple[str, float, str, str]] = ("error [%]", 100.0, " %", "+.2f")

    target: str
    words: str
    source: str
    units: str
    parameters: Mapping[str, TypedParameter]
    naive_parameters: Mapping[str, TypedParameter]
    snippet: str
    collisions: Collisions
    law: TypedLaw | TypedAdhesive | TableLaw
    naive_law: TypedLaw | TypedAdhesive | TableLaw
    angles: Angles | None = None

    @property
    def wall(self) -> bool:
        """Whether the text is for a ball and a wall, not for two balls."""
        return self.collisions.pair.wall

    @property
    def velocity(self) -> tuple[float, float]:
        """Range of velocities [m/s]."""
        return float(self.collisions.velocity[0]), float(self.collisions.velocity[-1])

    @property
    def warnings(self) -> list[str]:
        """Messages of the assumptions of the theory that are doubtful within the range."""
        doubts = [] if self.collisions.validity is None else self.collisions.validity.warnings
        return doubts if self.angles is None else [*dict.fromkeys([*doubts, *self.angles.warnings])]

    def restitution_coefficient(self, velocity: Any, radius: float | None = None) -> Any:
        """Return the coefficient of restitution [-] that the code gives, without the error of its time step.

        The velocity [m/s] is a number or an array. The radius [m] is that of the first ball, by default the middle
        one.
        """
        return self._promise(velocity, radius)[0]

    def contact_time(self, velocity: Any, radius: float | None = None) -> Any:
        """Return the contact time [s] in the code; see `restitution_coefficient`."""
        return self._promise(velocity, radius)[1]

    def _promise(self, velocity: Any, radius: float | None) -> tuple[Any, Any]:
        speeds, cases = check("velocity", velocity), self.collisions
        middle = cases.radius.size // 2
        factor = 1.0 if radius is None else check_single("radius", radius) / float(cases.radius[middle])
        mass, reduced = cases.mass[middle] * factor**3, cases.reduced_radius[middle] * factor
        e, time = self.law.rebound(speeds, mass, reduced)
        return (e, time) if np.ndim(speeds) else (float(e), float(time))

    @cached_property
    def table(self) -> xr.Dataset:
        """Exact, calibrated and naive coefficients of restitution and contact times over velocity (and radius).

        The variable `error` is calibrated e over exact e, less 1. SI units.
        """
        import xarray as xr

        cases, many = self.collisions, self.collisions.radius.size > 1
        exact = cases.restitution_coefficient, cases.contact_time
        values = [exact, self.law.rebound(*cases.grid), self.naive_law.rebound(*cases.grid)]
        dims = ("velocity", "radius") if many else ("velocity",)
        data: dict[str, Any] = {}
        for (prefix, words), pair in zip(_KINDS.items(), values, strict=True):
            for name, column in zip((_E, _TIME), pair, strict=True):
                attributes = OUTPUTS[name].attributes
                attributes["long_name"] += f", {words}"
                data[prefix + name] = (dims, column if many else np.asarray(column)[:, 0], attributes)
        dataset = xr.Dataset(data, {"velocity": ("velocity", cases.velocity, INPUTS["velocity"].attributes)})
        if many:
            dataset = dataset.assign_coords(radius=("radius", cases.radius, INPUTS["radius"].attributes))
        dataset["error"] = self._error(dataset[f"calibrated_{_E}"], dataset[_E])
        dataset["error"].attrs = {"units": "1", "long_name": self.error_words}
        return dataset.assign_attrs(target=self.target, source=self.source)

    @property
    def largest_error(self) -> float:
        """Largest relative error of e over velocity and radius."""
        return self._largest_error(f"calibrated_{_E}")

    def _error(self, values: Any, exact: Any) -> Any:
        """Return the errors of coefficients of restitution."""
        return values / exact - 1.0

    def _largest_error(self, name: str) -> float:
        """Return the largest error of a variable of the table; NaN if one of the two values is not known."""
        values, exact = self.table[name], self.table[name.partition("_")[2]]
        if name.endswith(_E):
            return float(np.abs(self._error(values, exact)).max())
        comparable = np.isfinite(exact) & (values > 0.0)
        return float(np.abs(values / exact - 1.0).max()) if comparable.any() else float("nan")

    @cached_property
    def within(self) -> dict[float, list[tuple[float, float]]]:
        """Ranges of velocity [m/s] in which e is within 1, 2 and 5 per cent of the exact one, at all radii.

        The ends are interpolated between the velocities of the table.
        """
        speeds, errors = self.collisions.velocity, np.atleast_2d(self.table["error"].to_numpy().T)
        fine = np.unique(np.concatenate([speeds, np.geomspace(speeds[0], speeds[-1], _FINE)]))
        fine = fine[(fine >= speeds[0]) & (fine <= speeds[-1])]
        worst = np.max([np.abs(np.interp(np.log(fine), np.log(speeds), error)) for error in errors], axis=0)
        return {level: _ranges(fine, worst <= level) for level in LEVELS}

    def plot(self, *, ax: Axes | None = None) -> Figure:
        """Return the figure of e, its error and the contact time over velocity; on given axes only e."""
        return draw("calibration.overview", self, ax=ax)

    def to_dict(self) -> dict[str, Any]:
        """Return all numbers as plain numbers and text, in SI unless a unit is stated."""
        table = self.table
        return super().to_dict() | {
            "format": _FORMAT,
            "version": version("restitution"),
            "within": {f"{level:g}": ranges for level, ranges in self.within.items()},
            "table": {str(name): plain(table[name].to_numpy(), nullable) for name in table.variables},
            "units_of_table": {str(name): table[name].attrs["units"] for name in table.variables},
            "angles": None if self.angles is None else {k: plain(v) for k, v in vars(self.angles).items()},
        }

    def to_json(self, path: str | Path | None = None) -> str:
        """Return the numbers as JSON, and write them to a file if a path is given, whole or not at all."""
        text = json.dumps(self.to_dict(), indent=1, allow_nan=False) + "\n"
        if path is not None:
            write_text(path, text)
        return text

    def summary(self, title: str = "") -> Summary:
        """Return the table over the velocity, the numbers to type and the text to paste, for `print` and notebooks."""
        low, high = self.velocity
        speeds = f"{low:.3g} m/s" if low == high else f"{low:.3g} to {high:.3g} m/s"
        heading = f"{self.words}: {self.collisions.pair.words} at {speeds}"
        return Summary(title or heading, self._rows, self._lines, self.snippet, self.warnings)

    @property
    def _short(self) -> str:
        typed = ", ".join(
            f"{name} = {f'{number.value:.6g} {number.unit}'.rstrip()}" for name, number in self.parameters.items()
        )
        error = f"largest error of e {self._in_words(self.largest_error)}"
        return ", ".join(filter(None, (self.target, typed, error)))

    @property
    def _rows(self) -> Table:
        """Exact and calibrated e at some velocities; of several radii at the middle one."""
        table = self.table
        if "radius" in table.dims:
            table = table.isel(radius=table.sizes["radius"] // 2)
        table = table.isel(velocity=np.unique(np.linspace(0, table.sizes["velocity"] - 1, _ROWS).astype(int)))
        title, factor, _, form = self.error_column
        columns = ("velocity [m/s]", "exact e", "calibrated", title, "as usually typed")
        values = table["velocity"], table[_E], table[f"calibrated_{_E}"], factor * table["error"], table[f"naive_{_E}"]
        formats = ".4g", ".4f", ".4f", form, ".4f"
        return Table(columns, [tuple(map(format, row, formats)) for row in np.stack(values, axis=1).tolist()])

    def _in_words(self, error: float) -> str:
        """Return an error of e for people."""
        _, factor, unit, _ = self.error_column
        return f"{factor * error:.2g}{unit}"

    @property
    def _lines(self) -> list[str]:
        """Numbers to type, largest errors, and velocities within some errors."""
        lines: list[str] = []
        wide = max((len(name) for name in self.parameters), default=0)
        for name, (value, unit, words) in self.parameters.items():
            lines.append(f"  {name:{wide}} = {f'{value:.6g} {unit}'.rstrip()}  ({words})")
        percent = "{:.2g} %".format
        for name, what in ((_E, "e"), (_TIME, "the contact time")):
            error, naive = (self._largest_error(kind + name) for kind in ("calibrated_", "naive_"))
            if np.isfinite(error):
                largest, typed = (self._in_words(x) if name == _E else percent(100.0 * x) for x in (error, naive))
                lines.append(f"  largest error of {what}: {largest}; as usually typed: {typed}")
        if self.angles is not None:
            low, high = np.degrees(self.angles.angle[[0, -1]])
            error = self.angles.largest_error
            steps = (
                f"; {FEWEST} steps in a contact change e_t by {change:.2g}" if (change := self.angles.of_steps) else ""
            )
            lines.append(f"  largest difference of e_t from {low:.3g} to {high:.3g} degrees: {error:.2g}{steps}")
        for level, ranges in self.within.items():
            where = ", ".join(f"{a:.3g} to {b:.3g} m/s" for a, b in ranges) or "nowhere"
            lines.append(f"  e within {self._in_words(level)}: {where}")
        return lines


def _ranges(x: Array, good: NDArray[np.bool_]) -> list[tuple[float, float]]:
    """Return the first and the last place of each run of true values."""
    edges = np.flatnonzero(np.diff(np.concatenate([[False], good, [False]]).astype(int)))
    return [(float(x[a]), float(x[b - 1])) for a, b in edges.reshape(-1, 2)]


# Text to paste into an input file of a code.


def snippet(
    typed: TypedLaw | TypedAdhesive,
    parameters: Mapping[str, Any],
    cases: Collisions,
    system: UnitSystem,
    style: str | None,
) -> str:
    """Return the text of a law with its numbers, after comments on what they hold for; `style` is that of friction."""
    law, numbers = typed.law, {name: f"{number.value:.8g}" for name, number in parameters.items()}
    remarks = [*heading(law.words, cases, system), *(note.format(**numbers) for note in law.notes)]
    _, times = typed.rebound(float(cases.velocity[-1]), cases.mass, cases.reduced_radius)
    remarks.append(f"time step at most {_amount(float(times.min()) / FEWEST, TIME, system)}")
    text = law.wall if cases.pair.wall else law.pair
    for smooth, rough in law.rough if style is not None else ():
        text = text.replace(smooth, rough)
    text = text.format(**numbers, style=style)
    return "\n".join([*(law.comment.format(line) for line in remarks), text, ""])


def system_of(cases: Collisions, units: str) -> UnitSystem:
    """Return a unit system by its name; the reduced one has mass, diameter and highest velocity of the first ball."""
    if units != REDUCED:
        return SYSTEMS[units]
    radius = float(cases.radius[cases.radius.size // 2])
    mass = cases.pair.ball_mass * (radius / cases.pair.ball_radius) ** 3
    return reduced(mass, 2.0 * radius, float(cases.velocity[-1]))


def heading(words: str, cases: Collisions, system: UnitSystem) -> list[str]:
    """Return lines on the code, the bodies, their velocities and the units."""
    low, high = float(cases.velocity[0]), float(cases.velocity[-1])
    speeds = f"{low:.4g} m/s" if low == high else f"{low:.4g} to {high:.4g} m/s"
    line = f"{cases.pair.words} at {speeds}"
    if cases.radius.size > 1:
        line += f", radii {cases.radius[0]:.4g} to {cases.radius[-1]:.4g} m"
    else:
        mass, radius = float(cases.mass[0]), float(cases.reduced_radius[0])
        line += f", m_eff = {_amount(mass, MASS, system)}, R_eff = {_amount(radius, LENGTH, system)}"
    units = "SI units" if system == SI else f"units {system.name}"
    if system.name == REDUCED:
        units += f", in which {system.mass:.6g} kg, {system.length:.6g} m and {system.time:.6g} s are 1"
    return [f"restitution {version('restitution')}: {words}", line, units]


def _amount(value: float, dimension: Dimension, system: UnitSystem) -> str:
    return f"{system.convert(value, dimension):.6g} {system.unit(dimension)}".rstrip()
