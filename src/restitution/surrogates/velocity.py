"""Surrogate of one impact: restitution coefficient, contact time and peak force over its velocity."""

from __future__ import annotations

import hashlib
import json
import math
from collections.abc import Sequence
from dataclasses import dataclass, field
from functools import cached_property
from importlib import import_module
from importlib.metadata import version
from pathlib import Path
from typing import TYPE_CHECKING, Any, ClassVar, NamedTuple

import numba
import numpy as np
from numpy.typing import NDArray

from restitution.checks import Array, finite, nonnegative, one_of, positive, whole, within
from restitution.errors import InputError
from restitution.files import path_of, write_text
from restitution.quantities import INPUTS, VELOCITY, check, dataset
from restitution.quantities import OUTPUTS as QUANTITIES
from restitution.result import Result, Summary, Table, draw
from restitution.surrogates.boxes import OF_PIECES, Pieces
from restitution.surrogates.standard_solid import compiled
from restitution.validity import Validity

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure


OUTPUTS = ("restitution_coefficient", "contact_time", "max_force")
"""Names of the outputs."""

_FORMAT = "restitution surrogate over velocity"
# Versions of files: over the velocity alone, with a sticking velocity, with friction.
PLAIN_, STICKING_, OBLIQUE_ = _VERSIONS = (2, 3, 4)
_LARGEST = 20_000_000  # characters of a file
_SERIES = "chebyshev_coefficients_of_log"
_HEADS = ("velocity [m/s]", "e", "contact time [s]", "largest force [N]")
# Velocities of the table that is shown.
_ROWS = 5
NEAR = 1e-3
"""Share of the sticking velocity above it where the series begin; in between e is a square root."""

# What a body that sticks has, and the power with which outputs begin above the sticking velocity.
_OF_STICKING = {"restitution_coefficient": (0.0, 0.5), "contact_time": (math.inf, 0.0), "max_force": (math.nan, 0.0)}
# The logarithm of another mathematical library may differ in the last bits.
ROUNDING = 1e-12


class LookupTable(NamedTuple):
    """Pieces of one function of v > s, whose logarithm is a Chebyshev series in log(v - s) on each piece.

    `cells` of equal width in log(v - s), `per_cell` for one unit, begin at `origin` and contain the piece of each
    cell. A piece has the `middle`, and `inverse` is that of half its width. The function cannot exceed `most`. At the
    velocity s and below it is `below`, and between s and the first piece a power of v - s; s = 0 if no body sticks.
    Compiled functions take it as a plain tuple, whose types numba finds three times faster.
    """

    low: float
    high: float
    origin: float
    per_cell: float
    cells: NDArray[np.int64]
    middle: Array
    inverse: Array
    coefficients: Array
    most: float
    sticking: float
    below: float
    power: float


def lookup_table(
    pieces: Pieces, function: int, low: float, high: float, most: float, *, sticking: float = 0.0,
    below: float = 0.0, power: float = 0.0,
) -> tuple[Any, ...]:  # fmt: skip
    """Prepare one function for look-up: a `LookupTable` as a plain tuple."""
    edges = pieces.edges
    whole = edges[-1] - edges[0]
    n_cell = 2 ** round(math.log2(whole / np.diff(edges).min()))
    centres = edges[0] + whole * (np.arange(n_cell) + 0.5) / n_cell
    cells = np.searchsorted(edges, centres, side="right") - 1
    coefficients = np.ascontiguousarray(pieces.coefficients[function])
    middle, inverse = 0.5 * (edges[1:] + edges[:-1]), 2.0 / np.diff(edges)
    origin, per_cell = float(edges[0]), float(n_cell / whole)
    numbers = LookupTable(
        low, high, origin, per_cell, cells, middle, inverse, coefficients, most, sticking, below, power
    )
    return tuple(numbers)


@compiled
def value(v: float, table: Any) -> float:
    """Return the value of a table at v; NaN outside its range."""
    low, high, origin, per_cell, cells, middle, inverse, coefficients, most, sticking, below, power = table
    if not (low <= v <= high):
        return math.nan
    if v <= sticking:
        return below
    x = math.log(v - sticking)
    start = 1.0
    if sticking > 0.0 and x < origin:
        start, x = math.exp(power * (x - origin)), origin
    piece = cells[min(max(int((x - origin) * per_cell), 0), cells.size - 1)]
    t = (x - middle[piece]) * inverse[piece]
    last, before = 0.0, 0.0
    for k in range(coefficients.shape[1] - 1, 0, -1):
        last, before = (coefficients[piece, k] - before) + 2.0 * t * last, last
    return min(start * math.exp((coefficients[piece, 0] - before) + t * last), most)


@compiled
def values(v: Any, out: Any, table: Any) -> None:
    """Write the values of a table at an array of v."""
    for n in range(v.size):
        out[n] = value(v[n], table)


def scalar_function(table: tuple[Any, ...]) -> Any:
    """Return a compiled function of v with the table as constants, for use in other compiled code."""

    @numba.njit(error_model="numpy")
    def of_velocity(v: float) -> float:
        return value(v, table)

    return of_velocity


@dataclass(frozen=True, eq=False, repr=False)
class Surrogate(Result):
    """Outputs of an impact as functions of its velocity, by interpolation; `surrogate` returns them.

    Called with a velocity or an array of them [m/s], it returns the restitution coefficient.

    Attributes
    ----------
    velocity : tuple of float
        Range of the impact velocity v0 [m/s].
    rtol : float
        Requested tolerance.
    error : dict of str to float
        Error of each output, relative to max(e, 1e-3) for e and relative for the others. With adhesion that of e is
        absolute, and below e = 0.1 all are 0.1/e times as large.
    validity : Validity
        The assumptions of the theory beside their limits, at the worst velocity of the range.
    problem : dict
        The impact, as plain numbers and text.
    pieces : Pieces
        Logarithms of the outputs as Chebyshev series over the logarithm of the velocity, or of its excess over the
        sticking velocity, piece by piece.
    sticking_velocity : float
        Velocity [m/s] up to which the body sticks, 0 if it rebounds in the whole range. There e is 0, the contact time
        infinite, and the force not known (NaN).

    Notes
    -----
    The error is twice the largest difference from the exact method at velocities that were not used to build it, plus
    20 times the tolerance of the solves: a measurement, not a bound (docs/surrogates.md,
    `validation/surrogate_error.md`).
    """

    _numbers = ("velocity", "sticking_velocity", "rtol", "error", "problem", "warnings", "validity")
    _names: ClassVar[tuple[str, ...]] = OUTPUTS

    velocity: tuple[float, float]
    rtol: float
    error: dict[str, float]
    validity: Validity = field(repr=False)
    problem: dict[str, Any] = field(repr=False)
    pieces: Pieces = field(repr=False)
    sticking_velocity: float = 0.0

    def __post_init__(self) -> None:
        low, high = velocity_range(self.velocity)
        check_pieces(self.pieces, len(OUTPUTS))
        ends, slow = self.pieces.edges[[0, -1]], self.sticking_velocity
        if slow and not low <= slow < high / (1.0 + NEAR):
            raise InputError("sticking_velocity", slow, "must lie in the range of velocities", VELOCITY.unit)
        expected = np.log([NEAR * slow, high - slow] if slow else [low, high])
        if np.abs(ends - expected).max() > ROUNDING * max(1.0, np.abs(ends).max()):
            with np.errstate(over="ignore", under="ignore"):
                rule = f"must be the range of log_velocity_edges, {np.exp(ends[0]):g} to {np.exp(ends[1]):g} m/s"
            raise InputError("velocity", list(self.velocity), rule, VELOCITY.unit)

    @property
    def warnings(self) -> list[str]:
        """Messages of the assumptions of the theory that are doubtful within the range."""
        return self.validity.warnings

    def summary(self, title: str = "", velocity: Any = None) -> Summary:
        """Return the table at some velocities [m/s], errors and warnings, which `print` and notebooks show."""
        low, high = self.velocity
        speeds = np.clip(np.geomspace(low, high, _ROWS), low, high) if velocity is None else np.atleast_1d(velocity)
        columns = self._columns_of(np.asarray(speeds, dtype=np.float64))
        rows = [tuple(f"{number:.8g}" for number in row) for row in zip(speeds, *columns, strict=True)]
        pieces = self.pieces.edges.size - 1
        span = f"{low:g} to {high:g} m/s in {pieces} piece{'s' * (pieces > 1)}, rtol {self.rtol:g}"
        span += f", sticks up to {self.sticking_velocity:.5g} m/s" if self.sticking_velocity else ""
        errors = ", ".join(f"{name.replace('_', ' ')} {error:.1e}" for name, error in self.error.items())
        heading = f"{title or 'Surrogate'}: {span}"
        table = Table(self._heads, rows) if rows else None
        return Summary(heading, table, (f"largest error: {errors}",), warnings=self.warnings)

    @property
    def _heads(self) -> tuple[str, ...]:
        return _HEADS

    def _columns_of(self, speeds: Array) -> list[Any]:
        """Return the columns of the table at some velocities, besides these."""
        return [self._evaluate(name, speeds) for name in OUTPUTS]

    @property
    def _short(self) -> str:
        return f"{self.velocity[0]:g} to {self.velocity[1]:g} m/s, error of e {self.error[OUTPUTS[0]]:.1e}"

    def __call__(self, velocity: Any) -> Any:
        """Return the restitution coefficient e at a velocity or an array of them [m/s]."""
        return self.restitution_coefficient(velocity)

    def restitution_coefficient(self, velocity: Any) -> Any:
        """Return the restitution coefficient e [-] at v0 [m/s], a number or an array within the range."""
        return self._evaluate("restitution_coefficient", velocity)

    def contact_time(self, velocity: Any) -> Any:
        """Return the contact time T [s]; see `restitution_coefficient`."""
        return self._evaluate("contact_time", velocity)

    def max_force(self, velocity: Any) -> Any:
        """Return the largest normal force F [N]; see `restitution_coefficient`."""
        return self._evaluate("max_force", velocity)

    def compiled(self, output: str = "restitution_coefficient") -> Any:
        """Return an output as a function compiled by numba, for one velocity [m/s], to be called in compiled code.

        It takes and returns a float64, within `numba.njit` and `numba.cfunc`. Out of range it returns NaN, because
        code called from C has no exceptions.

        Examples
        --------
        >>> import numba
        >>> import restitution as rs
        >>> solid = rs.standard_solid(1e6, 1e7, 1e3, poisson_ratio=0.45)
        >>> ball = rs.Impact(solid, rs.Parabola(0.01), mass=0.005, velocity=1.0)
        >>> e = rs.surrogate(ball, velocity=(0.1, 1.0), rtol=1e-4).compiled()
        >>> rebound = numba.cfunc("float64(float64)")(lambda v: -e(v) * v)
        >>> print(round(rebound.ctypes(0.5), 3))
        -0.171
        """
        return scalar_function(self._tables[one_of("output", output, OUTPUTS)])

    def plot(self, outputs: Sequence[str] = (), *, ax: Axes | None = None) -> Figure:
        """Return the figure of the named outputs, or of all, over the velocity.

        On given axes one output is drawn, the first if none is named.
        """
        return draw("sweep.plot_sweep", self.sample(), outputs, ax=ax)

    def sample(self, n: int = 400) -> xr.Dataset:
        """Return the outputs at n velocities at equal ratios over the range, as the Dataset of a sweep."""
        speeds = np.clip(np.geomspace(*self.velocity, whole("n", n, 1, 10_000_000)), *self.velocity)
        columns = {name: (self._evaluate(name, speeds), QUANTITIES[name]) for name in OUTPUTS}
        samples = dataset("velocity", {"velocity": (speeds, INPUTS["velocity"])} | columns, {})
        samples["velocity"].attrs["scale"] = "logarithmic"
        return samples

    def save(self, path: str | Path) -> Path:
        """Write a JSON file, whole or not at all, in place of an old one; return its path."""
        units = {"velocity": INPUTS["velocity"], **{name: QUANTITIES[name] for name in OUTPUTS}}
        content = {
            "format": _FORMAT,
            "format_version": self._version,
            "version": version("restitution"),
            "rtol": self.rtol,
            "velocity": list(self.velocity),
            "error": self.error,
            "units": {name: quantity.attributes["units"] for name, quantity in units.items()},
            "validity": self.validity.to_dict(),
            "problem": self.problem,
            "log_velocity_edges": self.pieces.edges.tolist(),
            _SERIES: {name: part.tolist() for name, part in zip(OUTPUTS, self.pieces.coefficients, strict=True)},
        }
        content |= self._content()
        content["sha256"] = content_hash(content)
        return write_text(path, json.dumps(content, indent=1, allow_nan=False) + "\n")

    @property
    def _version(self) -> int:
        return STICKING_ if self.sticking_velocity else PLAIN_

    def _content(self) -> dict[str, Any]:
        """Return what a file has besides the numbers of all surrogates."""
        return {"sticking_velocity": self.sticking_velocity} if self.sticking_velocity else {}

    @classmethod
    def load(cls, path: str | Path) -> Surrogate:
        """Return the surrogate of a file that `save` wrote, to the last bit; refuse a damaged or edited file."""
        path = path_of(path)
        try:
            with path.open(encoding="utf-8") as file:
                text = file.read(_LARGEST + 1)
            if len(text) > _LARGEST:
                raise InputError("", rule=f"is too long: must have at most {_LARGEST} characters", where=str(path))
            content = json.loads(text)
        except InputError:
            raise
        except (ValueError, RecursionError):
            raise InputError("", rule="is not a JSON file", where=str(path)) from None
        if not isinstance(content, dict) or content.get("format") != _FORMAT:
            raise InputError("", rule=f"is not a {_FORMAT}", where=str(path))
        stated = content.get("format_version")
        if stated is True or stated not in _VERSIONS:
            versions = ", ".join(map(str, _VERSIONS))
            rule = f"must be one of {versions}; version {content.get('version')} of restitution wrote the file"
            raise InputError("format_version", stated, rule, where=str(path))
        try:
            return _kind(stated)._from_content(content)
        except InputError as error:
            raise error.within(where=str(path)) from None
        except (KeyError, TypeError, ValueError, AttributeError, RecursionError):
            raise InputError("", rule="is damaged: a part is missing or of another type", where=str(path)) from None

    @classmethod
    def _from_content(cls, content: dict[str, Any]) -> Surrogate:
        if content.pop("sha256", None) != content_hash(content):
            raise InputError("sha256", rule="must be the hash of the rest; the file is damaged or was edited")
        series = content[_SERIES]
        pieces = Pieces(
            np.asarray(finite("log_velocity_edges", content["log_velocity_edges"])),
            np.stack([np.asarray(finite(f"{_SERIES}.{name}", series[name])) for name in OUTPUTS]),
        )
        error = {name: float(positive(f"error.{name}", content["error"][name])) for name in cls._names}
        velocity = velocity_range(content["velocity"])
        rtol = float(positive("rtol", content["rtol"]))
        report, problem = Validity.from_dict(content["validity"]), dict(content["problem"])
        return cls(velocity, rtol, error, report, problem, pieces, **cls._further(content))

    @classmethod
    def _further(cls, content: dict[str, Any]) -> dict[str, Any]:
        """Return the numbers of a file besides those of all surrogates."""
        return {"sticking_velocity": float(nonnegative("sticking_velocity", content.get("sticking_velocity", 0.0)))}

    @cached_property
    def _tables(self) -> dict[str, tuple[Any, ...]]:
        tables: dict[str, tuple[Any, ...]] = {}
        for n, name in enumerate(OUTPUTS):
            most, (below, power) = 1.0 if name == "restitution_coefficient" else np.inf, _OF_STICKING[name]
            options = {"sticking": self.sticking_velocity, "below": below, "power": power}
            tables[name] = lookup_table(self.pieces, n, *self.velocity, most, **options)
        return tables

    def _evaluate(self, output: str, velocity: Any) -> Any:
        checked = within("velocity", velocity, *self.velocity, VELOCITY.unit)
        table = self._tables[output]
        if not isinstance(checked, np.ndarray):
            return value(float(checked), table)
        out = np.empty(checked.shape)
        values(checked.reshape(-1), out.reshape(-1), table)
        return out


def _kind(stated: int) -> type[Surrogate]:
    """Return the class of a version of files. The module of a subclass, which imports this one, is found by name."""
    if stated != OBLIQUE_:
        return Surrogate
    return import_module("restitution.surrogates.oblique").ObliqueSurrogate


def velocity_range(velocity: Any) -> tuple[float, float]:
    """Return the ends of a range of velocities [m/s], checked, the lowest first."""
    checked = np.sort(np.atleast_1d(check("velocity", velocity)), axis=None)
    if checked.shape != (2,) or checked[0] == checked[1]:
        raise InputError("velocity", velocity, "must be the lowest and the highest, which differ")
    return float(checked[0]), float(checked[1])


def content_hash(content: dict[str, Any]) -> str:
    """Return the SHA-256 of the content of a file, whatever its layout."""
    text = json.dumps(content, sort_keys=True, separators=(",", ":"))
    return hashlib.sha256(text.encode()).hexdigest()


def check_pieces(pieces: Pieces, count: int) -> None:
    """Refuse edges that are not those of repeated halving, or that do not fit the coefficients of some functions."""
    edges, coefficients = pieces
    widths = np.diff(edges)
    if edges.ndim != 1 or edges.size < 2 or widths.min() <= 0.0:
        raise InputError("log_velocity_edges", rule="must be two or more numbers that increase")
    shape = (count, widths.size)
    if coefficients.ndim != 3 or coefficients.shape[:2] != shape or coefficients.shape[2] < 1:
        raise InputError(_SERIES, rule=f"must have a row for each of the {widths.size} pieces")
    halvings = np.log2((edges[-1] - edges[0]) / widths)
    places = (edges[:-1] - edges[0]) / widths
    if (
        any(np.abs(x - np.round(x)).max() > 1e-6 for x in (halvings, places))
        or halvings.max() > OF_PIECES.deepest + 0.5
    ):
        raise InputError("log_velocity_edges", rule="must be those of an interval halved again and again")
