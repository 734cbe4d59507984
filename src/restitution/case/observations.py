"""Files of observations; the columns determine the kind of data."""

from __future__ import annotations

import inspect
from collections.abc import Mapping, Sequence
from importlib import import_module
from pathlib import Path
from typing import Any, NamedTuple

from restitution import checks
from restitution.case.columns import in_si, open_sheet
from restitution.errors import InputError
from restitution.files import path_of
from restitution.identification.observations import Noise, Observations
from restitution.material.readers import read_material
from restitution.material.sheet import FileError
from restitution.quantities import ACCELERATION, HISTORY, INPUTS, LENGTH, OUTPUTS, Dimension, advice

_DEVIATION = "sd_"
_SYMBOLS = {
    "t": "time", "d": "depth", "F": "force", "a": "acceleration", "v": "velocity", "e": "restitution_coefficient",
    "R": "radius", "m": "mass", "tc": "contact_time", "Fmax": "max_force",
}  # fmt: skip
DIMENSIONS: dict[str, Dimension] = {
    **{name: INPUTS[name].dimension for name in ("velocity", "radius", "mass", "external_force", "temperature")},
    **{name: OUTPUTS[name].dimension for name in ("restitution_coefficient", "contact_time", "max_force")},
    **{name: HISTORY[name].dimension for name in ("time", "force")},
    "depth": LENGTH, "acceleration": ACCELERATION,
}  # fmt: skip
"""Dimensions of measured quantities, and of what is known of each impact, by name."""
_NAMES = frozenset(name for one in DIMENSIONS for name in (one, _DEVIATION + one)) | {
    _DEVIATION + symbol for symbol in _SYMBOLS
}


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
KINDS: Mapping[str, Kind] = {
    "indentation": Kind("curve.IndentationCurve", ("time", "depth", "force")),
    "rebounds": Kind("rebounds.Rebounds", ("velocity", "restitution_coefficient"), _BODIES),
    "force_history": Kind("force_history.ForceHistory", ("time", "force")),
    "acceleration_history": Kind("force_history.ForceHistory", ("time", "acceleration")),
    "bounce_times": Kind("bounce_times.BounceTimes", ("time",)),
    "moduli": Kind("tables.Moduli", ()),
}
"""Kinds of observations by name; a file is of the first kind with its columns."""


def read_observations(
    path: str | Path, *, kind: str | None = None, noise: Noise | Mapping[str, Any] | None = None, **given: Any
) -> Observations:
    r"""Read measured impacts, indentations or moduli from a CSV file.

    Parameters
    ----------
    path : path-like
        The file. Its header has the names of the columns, with the unit in brackets or after an underscore:
        ``velocity [m/s],restitution_coefficient,contact_time_ms``. Rebounds have the columns `velocity` and
        `restitution_coefficient`, a force history `time` and `force` or `acceleration`, bounces `time` alone, an
        indentation `time`, `depth` and `force`. Further columns are `radius`, `mass`, `contact_time`, `max_force`,
        `external_force` and `temperature` of rebounds. A column of standard deviations has the prefix `sd_`. Other
        files go to `read_material`.
    kind : str, optional
        `rebounds`, `force_history`, `acceleration_history`, `bounce_times`, `indentation` or `moduli`, to refuse a
        file of any other kind.
    noise : Noise or mapping, optional
        Standard deviations of quantities without such a column.
    **given
        Further arguments of the class, such as ``radius=0.01``.

    Returns
    -------
    Rebounds, ForceHistory, BounceTimes, IndentationCurve or Moduli
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
        return _read(source, kind, deviations, given)
    except FileError as error:
        raise InputError(error.field, wanted=error.wanted, where=str(source)) from None
    except InputError as error:
        raise error.within(where=error.where or str(source)) from None


def _read(source: Path, kind: str | None, deviations: dict[str, Any], given: dict[str, Any]) -> Observations:
    if source.suffix.lower() == ".toml":
        raise InputError("", wanted="is a case file: must be a file of measured values")
    if kind is not None and checks.instance("kind", kind, str, "must be a name") not in KINDS:
        raise InputError("kind", kind, f"must be one of {', '.join(KINDS)}")

    def moduli() -> Observations:
        return _made("moduli", [read_material(source)], deviations, given, source)

    if kind == "moduli":
        return moduli()
    try:
        sheet, labels = open_sheet("", str(source), _NAMES, _SYMBOLS)
    except InputError:
        if kind is not None:
            raise
        return moduli()
    names = [_DEVIATION + _SYMBOLS.get(name[3:], name[3:]) if name.startswith(_DEVIATION) else name for name in labels]
    found = next(name for name, one in KINDS.items() if set(one.required) <= set(names))
    one = KINDS[found]
    known = (*one.required, *one.optional)
    strange = [n for n, name in enumerate(names) if name.removeprefix(_DEVIATION) not in known]
    if kind is None and (found == "moduli" or (found == "bounce_times" and strange)):
        # Times with an unknown quantity are not bounces, but perhaps a relaxation.
        if set(names) & DIMENSIONS.keys() <= {"time", "force", "temperature"}:
            return moduli()
        found = ""
    if kind not in (None, found) or not found:
        likely = kind or max(KINDS, key=lambda name: len(set(KINDS[name].required) & set(names)))
        wanted = f"must have the columns {', '.join(KINDS[likely].required)}"
        raise FileError("", sheet.header_line, wanted)
    if strange:
        wanted = f"unknown column {sheet.labels[strange[0]]!r}; {advice(labels[strange[0]], known)}"
        raise FileError("", sheet.header_line, wanted)
    columns: dict[str, Any] = {}
    for index, name in enumerate(names):
        if name in columns or name in given or (name.startswith(_DEVIATION) and name[3:] in deviations):
            raise FileError("", sheet.header_line, f"column {name!r} is given twice: must be given once")
        columns[name] = in_si(sheet, index, name, DIMENSIONS[name.removeprefix(_DEVIATION)])
    deviations |= {name[3:]: column for name, column in columns.items() if name.startswith(_DEVIATION)}
    values = {name: column for name, column in columns.items() if not name.startswith(_DEVIATION)}
    try:
        return _made(found, [], deviations, values | given, source)
    except InputError as error:
        if error.index and error.field.removeprefix("noise.") in names:
            # A row of the table is a line of the file.
            value = InputError(error.field, error.value, error.wanted, error.unit)
            raise FileError("", sheet.lines[error.index[0]], str(value)) from None
        raise


def _made(
    kind: str, first: Sequence[Any], deviations: dict[str, Any], given: dict[str, Any], source: Path
) -> Observations:
    build = KINDS[kind].build
    parameters = inspect.signature(build).parameters
    for name in given:
        if name not in parameters:
            raise InputError(name, given[name], f"does not go with {kind}; {advice(name, parameters)}")
    missing = [name for name, one in list(parameters.items())[len(first) :]
               if one.default is one.empty and name not in given]  # fmt: skip
    if missing:
        raise InputError(missing[0], wanted="is missing: must be a column of the file, or a number for all rows")
    made = build(*first, **given, **({"noise": Noise(**deviations)} if deviations else {}))
    made.label = source.name
    return made
