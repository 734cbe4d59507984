"""Files of observations; the columns determine the kind of data."""

from __future__ import annotations

import inspect
from collections.abc import Mapping, Sequence
from importlib import import_module
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from restitution import checks
from restitution.case.quantity import in_si, open_sheet
from restitution.checks import Array
from restitution.errors import InputError
from restitution.files import path_of
from restitution.identification.observations import Noise, Observations
from restitution.impact.problem import STANDARD_GRAVITY
from restitution.material.readers import read_material
from restitution.material.sheet import FileError, Sheet
from restitution.quantities import MEASURED, RESTITUTION, advice

_DEVIATION = "sd_"
_SYMBOLS = {
    "t": "time", "d": "depth", "F": "force", "a": "acceleration", "v": "velocity", "e": "restitution_coefficient",
    "R": "radius", "m": "mass", "tc": "contact_time", "Fmax": "max_force",
    "v_in": "velocity", "v_out": "rebound_velocity",
    "d0": "depth", "d1": "depth_amplitude", "F0": "mean_force", "F1": "force_amplitude",
}  # fmt: skip


class Kind(NamedTuple):
    """Kind of observations: the class, and the columns of its files."""

    home: str  # module and name of the class
    required: tuple[str, ...]
    optional: tuple[str, ...] = ()

    @property
    def build(self) -> type[Observations]:
        """The class."""
        module, _, name = self.home.partition(".")
        return getattr(import_module(f"restitution.identification.{module}"), name)


_BODIES = ("radius", "mass", "contact_time", "max_force", "external_force", "temperature")
_READINGS = ("force_amplitude", "phase", "storage_stiffness", "loss_stiffness", "mean_force")
KINDS: Mapping[str, Kind] = {
    "indentation": Kind("curves.IndentationCurve", ("time", "depth", "force")),
    "rebounds": Kind("impacts.Rebounds", ("velocity", "restitution_coefficient"), _BODIES),
    "force_history": Kind("records.ForceHistory", ("time", "force")),
    "acceleration_history": Kind("records.ForceHistory", ("time", "acceleration")),
    "bounce_times": Kind("records.BounceTimes", ("time",)),
    "oscillations": Kind("oscillations.Oscillations", ("frequency", "depth", "depth_amplitude"), _READINGS),
    "moduli": Kind("observations.Moduli", ()),
}
"""Kinds of observations by name; a file is of the first kind with its columns."""
# Columns of rebounds in place of a velocity and a restitution coefficient.
_REBOUNDS = ("drop_height", "rebound_height"), ("velocity", "rebound_velocity")
REBOUND_COLUMNS = "velocity and restitution_coefficient, or drop_height and rebound_height, or v_in and v_out"
"""Columns from which rebounds follow, in words."""
_COLUMNS = frozenset(name for kind in KINDS.values() for name in (*kind.required, *kind.optional)).union(*_REBOUNDS)
# Standard deviations by their headers: sd_e, e_std, err_velocity, ...
_SPREADS = {
    header: _DEVIATION + _SYMBOLS.get(name, name)
    for name in (*_COLUMNS, *_SYMBOLS)
    for word in ("sd", "std", "err", "error", "sigma")
    for header in (f"{word}_{name}", f"{name}_{word}")
}
_NAMES = _COLUMNS | _SPREADS.keys() | {"v_in", "v_out"}


def read_observations(
    path: str | Path, *, kind: str | None = None, noise: Noise | Mapping[str, Any] | None = None, **arguments: Any
) -> Observations:
    r"""Read measured impacts, indentations or moduli from a CSV file.

    Parameters
    ----------
    path : path-like
        The file. Its header has the names of the columns, with the unit in brackets or after an underscore:
        ``velocity [m/s],restitution_coefficient,contact_time_ms``. Rebounds have the columns `velocity` and
        `restitution_coefficient`, or `v_in` and `v_out`, or `drop_height` and `rebound_height` (falls in vacuum with
        standard gravity), a force history `time` and `force` or `acceleration`, bounces `time` alone, an indentation
        `time`, `depth` and `force`, oscillations `frequency`, `depth`, `depth_amplitude`, two of `force_amplitude` and
        `phase` or `storage_stiffness` and `loss_stiffness`, perhaps `mean_force`. With kind="bounce_times", columns
        beside `time` are not read. Further columns are `radius`, `mass`, `contact_time`, `max_force`,
        `external_force` and `temperature` of rebounds. A column of standard deviations has the prefix `sd_`, or one
        of `std`, `err`, `error`, `sigma` before or behind its name. Other files go to `read_material`.
    kind : str, optional
        `rebounds`, `force_history`, `acceleration_history`, `bounce_times`, `indentation`, `oscillations` or
        `moduli`, to refuse a file of any other kind.
    noise : Noise or mapping, optional
        Standard deviations of quantities without such a column.
    **arguments
        Further arguments of the class, such as ``radius=0.01``.

    Returns
    -------
    Rebounds, ForceHistory, BounceTimes, IndentationCurve, Oscillations or Moduli
        In SI, with the name of the file as its label.

    Raises
    ------
    InputError
        If the file is malformed, or a value is missing or out of range; the message has the file and the line.

    Examples
    --------
    >>> import tempfile
    >>> text = "velocity [m/s],e,contact time [ms]\n0.5,0.82,2.0\n1.0,0.79,1.8\n2.0,0.76,1.6\n"
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     file = Path(folder, "ball.csv")
    ...     _ = file.write_text(text)
    ...     ball = read_observations(file, radius=0.01, mass=0.033, noise={"restitution_coefficient": 0.005,
    ...                                                                    "contact_time": "1 %"})
    >>> ball.size, ball.label
    (6, 'ball.csv')
    """
    source = path_of(path)
    try:
        deviations = dict(noise.deviations) if isinstance(noise, Noise) else checks.mapping("noise", noise)
        return _read(source, kind, deviations, arguments)
    except FileError as error:
        raise InputError(error.field, rule=error.rule, where=str(source)) from None
    except InputError as error:
        raise error.within(where=error.where or str(source)) from None


def _read(source: Path, kind: str | None, deviations: dict[str, Any], arguments: dict[str, Any]) -> Observations:
    if source.suffix.lower() == ".toml" and source.is_file():
        raise InputError("", rule="is a case file: must be a file of measured values")
    if kind is not None and checks.instance("kind", kind, str, "must be a name") not in KINDS:
        raise InputError("kind", kind, f"must be one of {', '.join(KINDS)}")

    def moduli() -> Observations:
        return _observations("moduli", [read_material(source)], deviations, arguments, source)

    if kind == "moduli":
        return moduli()
    try:
        sheet, names = open_columns(source)
    except InputError:
        if kind is not None:
            raise
        return moduli()
    pair = next((pair for pair in _REBOUNDS if set(pair) <= set(names)), ())
    present = {*names, *(KINDS["rebounds"].required if pair else ())}
    file_kind = next(name for name, entry in KINDS.items() if set(entry.required) <= present)
    entry = KINDS[file_kind]
    columns_of = (*(pair or entry.required), *entry.optional)
    if kind == "bounce_times" and "time" in names:
        return _observations(
            kind, [], *_columns(sheet, ["time", f"{_DEVIATION}time"], names, deviations, arguments), source
        )
    strange = [n for n, name in enumerate(names) if name.removeprefix(_DEVIATION) not in columns_of]
    if kind is None and (file_kind == "moduli" or (file_kind == "bounce_times" and strange)):
        # Times with an unknown quantity are not bounces, but perhaps a relaxation.
        if set(names) & _COLUMNS <= {"time", "force", "temperature", "frequency", "phase"}:
            return moduli()
        file_kind = ""
    if kind not in (None, file_kind) or not file_kind:
        likely = kind or max(KINDS, key=lambda name: len(set(KINDS[name].required) & set(names)))
        required = REBOUND_COLUMNS if likely == "rebounds" else ", ".join(KINDS[likely].required)
        rule = f"must have the columns {required}"
        raise FileError("", sheet.header_line, rule)
    if strange:
        rule = f"unknown column {sheet.labels[strange[0]]!r}; {advice(names[strange[0]], columns_of)}"
        raise FileError("", sheet.header_line, rule)
    deviations, values = _columns(sheet, names, names, deviations, arguments)
    try:
        if pair:
            deviations, values = _as_rebounds(pair, deviations, values)
        return _observations(file_kind, [], deviations, values, source)
    except InputError as error:
        if error.index and error.field.removeprefix("noise.") in names:
            # A row of the table is a line of the file.
            value = InputError(error.field, error.value, error.rule, error.unit)
            raise FileError("", sheet.line(error.index[0]), str(value)) from None
        raise


class ReboundPoints(NamedTuple):
    """Measured coefficients of restitution over velocity.

    Attributes
    ----------
    velocity : array, shape (n,)
        Velocity of the impact [m/s].
    restitution_coefficient : array, shape (n,)
        Coefficient of restitution e [-].
    deviation : array, shape (n,), optional
        Standard deviation of e [-].
    """

    velocity: Array
    restitution_coefficient: Array
    deviation: Array | None


def read_points(path: str | Path) -> ReboundPoints:
    r"""Read measured coefficients of restitution over velocity, to be drawn with a computed curve.

    Parameters
    ----------
    path : path-like
        The file, with the columns `velocity` and `restitution_coefficient`, or `v_in` and `v_out`, or `drop_height`
        and `rebound_height`, perhaps with standard deviations, as in `read_observations`. It needs no body.

    Raises
    ------
    InputError
        If the file is malformed or has other columns; the message has the file and the line.

    Examples
    --------
    >>> import tempfile
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     file = Path(folder, "ball.csv")
    ...     _ = file.write_text("drop height [cm],rebound height [cm]\n100,64\n25,16\n")
    ...     points = read_points(file)
    >>> points.restitution_coefficient
    array([0.8, 0.8])
    """
    source = path_of(path)
    try:
        sheet, names = open_columns(source)
        pair, quantities = rebounds_in(names)
        if not quantities:
            raise FileError("", sheet.header_line, f"must have the columns {REBOUND_COLUMNS}")
        both = [*quantities, *(f"{_DEVIATION}{name}" for name in quantities)]
        deviations, values = _columns(sheet, both, names, {}, {})
        if pair:
            deviations, values = _as_rebounds(pair, deviations, values)
        velocity = np.asarray(checks.positive("velocity", values["velocity"], MEASURED["velocity"].unit))
        e = np.asarray(checks.within(RESTITUTION, values[RESTITUTION], 0.0, 1.0))
    except FileError as error:
        raise InputError(error.field, rule=error.rule, where=str(source)) from None
    except InputError as error:
        raise error.within(where=error.where or str(source)) from None
    spread = deviations.get("restitution_coefficient")
    return ReboundPoints(velocity, e, None if spread is None else np.asarray(spread))


def rebounds_in(names: Sequence[str]) -> tuple[Sequence[str], Sequence[str]]:
    """Return the pair of columns from which rebounds follow, if any, and the columns of rebounds in a table."""
    pair = next((pair for pair in _REBOUNDS if set(pair) <= set(names)), ())
    required = KINDS["rebounds"].required
    return pair, pair or (required if set(required) <= set(names) else ())


def has_points(path: Path) -> bool:
    """Return whether the header of a file has the columns that `read_points` reads."""
    try:
        return bool(rebounds_in(open_columns(path)[1])[1])
    except InputError:
        return False


def open_columns(source: Path) -> tuple[Sheet, list[str]]:
    """Return the table of a file and the names of its columns; standard deviations begin with `sd_`."""
    sheet, labels = open_sheet("", str(source), _NAMES, _SYMBOLS)
    return sheet, [_SPREADS.get(name, name) for name in labels]


def _columns(
    sheet: Sheet, required: Sequence[str], names: Sequence[str], deviations: dict[str, Any], arguments: dict[str, Any]
) -> tuple[dict[str, Any], dict[str, Any]]:
    """Return standard deviations and values by name: those of the section and the required columns, in SI."""
    columns: dict[str, Any] = {}
    for index, name in enumerate(names):
        if name not in required:
            continue
        if name in columns or name in arguments or (name.startswith(_DEVIATION) and name[3:] in deviations):
            raise FileError("", sheet.header_line, f"column {name!r} is given twice: must be given once")
        columns[name] = in_si(sheet, index, name, MEASURED[name.removeprefix(_DEVIATION)].dimension)
    spread = {name[3:]: column for name, column in columns.items() if name.startswith(_DEVIATION)}
    values = {name: column for name, column in columns.items() if not name.startswith(_DEVIATION)}
    return deviations | spread, values | arguments


def _as_rebounds(
    pair: Sequence[str], deviations: dict[str, Any], values: dict[str, Any]
) -> tuple[dict[str, Any], dict[str, Any]]:
    """Return standard deviations and values of rebounds from heights, or from velocities before and after.

    With v = sqrt(2 g h), a height that is wrong by a share x makes the velocity wrong by x/2.
    """
    before, after = (checks.positive(name, values[name], MEASURED[name].unit) for name in pair)
    power = 0.5 if pair[0] == "drop_height" else 1.0
    e = (after / before) ** power
    kept = {name: column for name, column in values.items() if name not in pair}
    kept["velocity"] = np.sqrt(2.0 * STANDARD_GRAVITY * before) if power == 0.5 else before
    spread = {name: size for name, size in deviations.items() if name not in pair}
    # The noise of e is that at a known velocity; the noise of the velocity is separate.
    for name, height, key, size in zip(pair, (before, after), ("velocity", "restitution_coefficient"),
                                       (kept["velocity"], e), strict=True):  # fmt: skip
        if name in deviations:
            spread[key] = power * checks.number(f"noise.{name}", deviations[name]) / height * size
    return spread, kept | {"restitution_coefficient": e}


def _observations(
    kind: str, first: Sequence[Any], deviations: dict[str, Any], arguments: dict[str, Any], source: Path
) -> Observations:
    build = KINDS[kind].build
    parameters = inspect.signature(build).parameters
    for name in arguments:
        if name not in parameters:
            raise InputError(name, arguments[name], f"does not go with {kind}; {advice(name, parameters)}")
    missing = [name for name, parameter in list(parameters.items())[len(first) :]
               if parameter.default is parameter.empty and name not in arguments]  # fmt: skip
    if missing:
        columns = "" if missing[0] == "profile" else ": must be a column of the file, or a number for all rows"
        raise InputError(missing[0], rule=f"is missing{columns}")
    observations = build(*first, **arguments, **({"noise": Noise(**deviations)} if deviations else {}))
    observations.label = source.name
    return observations
