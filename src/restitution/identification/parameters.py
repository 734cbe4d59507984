"""Parameters of a model of the material: names, logarithms, bounds and priors, and the way to arrays of materials."""

from __future__ import annotations

import inspect
import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, fields, replace
from functools import cached_property
from typing import Any, Literal, NamedTuple, get_type_hints

import numpy as np

from restitution import checks
from restitution.checks import Array, instance
from restitution.errors import InputError, InputTypeError
from restitution.material import models
from restitution.material.fractional import FractionalMaterial, fractional_series
from restitution.material.shift import WLF, Arrhenius, Shift
from restitution.material.viscoelastic import Material
from restitution.quantities import (
    CONSTANTS,
    INPUTS,
    MODULUS,
    NUMBER,
    SHIFTS,
    TIME,
    VISCOSITY,
    Quantity,
    advice,
    check_single,
)
from restitution.sweeps.grid import LogNormal, LogUniform, Normal, Uniform

Kind = Literal["log", "logit", "linear"]
Model = Callable[..., Material | FractionalMaterial]

# Half the width of the range of a logit; exponents near 1 take very many terms.
_LOGIT = 12.0
_EXPONENTS = -4.0, 2.2
# Bounds a factor of 1e4 about the effective modulus and the contact time.
_WIDE = math.log(1e4)
# Starts of parameters that no formula gives from the data.
_STARTS = {"c1": 10.0, "c2": 100.0, "activation_energy": 1e5, "exponent": 0.3, "poisson_ratio": 0.4}


class Parameter(NamedTuple):
    """One unknown number of the model."""

    name: str  # such as "viscosity" or "branch_moduli[0]"
    quantity: Quantity
    kind: Kind  # how it enters the fit: its logarithm, the logit of its place in the range, or itself
    low: float  # ends of its range
    high: float
    bounded: bool = False  # whether the user gave the range

    @property
    def argument(self) -> str:
        """Name of the argument of the model."""
        return self.name.partition("[")[0]

    def inward(self, value: Any) -> Any:
        """Return the coordinate of the fit of a value."""
        x = np.asarray(value, dtype=np.float64)
        if self.kind == "log":
            return np.log(x)[()]
        if self.kind == "logit":
            low, high = self.quantity.low, self.quantity.high
            return np.log((x - low) / (high - x))[()]
        return x[()]

    def outward(self, coordinate: Any) -> Any:
        """Return the value at a coordinate of the fit."""
        z = np.asarray(coordinate, dtype=np.float64)
        if self.kind == "log":
            return np.exp(z)[()]
        if self.kind == "logit":
            low, high = self.quantity.low, self.quantity.high
            return (low + (high - low) / (1.0 + np.exp(-z)))[()]
        return z[()]

    def slope(self, coordinate: Any) -> Any:
        """Return the derivative of the value with respect to the coordinate."""
        x = self.outward(coordinate)
        if self.kind == "linear":
            return np.ones(np.shape(x))[()]
        low, high = self.quantity.low, self.quantity.high
        return x if self.kind == "log" else (x - low) * (high - x) / (high - low)


@dataclass(frozen=True, eq=False)
class Parameters:
    """Unknown constants of a model of the material, and the known ones.

    Attributes
    ----------
    model : callable
        Function that returns a `Material` or a `FractionalMaterial`.
    free : tuple of Parameter
        Unknowns, in order.
    fixed : dict
        Known arguments of the model and of the shift; an unknown entry of a list is NaN.
    start, prior : dict
        Starts and priors of the user, by the name of the parameter.
    shift : type or Shift, optional
        Law of the shift, or a shift without unknowns.
    """

    model: Model
    free: tuple[Parameter, ...]
    fixed: Mapping[str, Any]
    start: Mapping[str, float]
    prior: Mapping[str, Any]
    shift: Any = None

    @cached_property
    def names(self) -> tuple[str, ...]:
        """Names of the unknowns."""
        return tuple(parameter.name for parameter in self.free)

    @cached_property
    def entry(self) -> models.MaterialModel | None:
        """Entry of the model in the registry."""
        return next((entry for entry in models.material_models().values() if entry.build is self.model), None)

    def __getstate__(self) -> dict[str, Any]:
        state = {field.name: getattr(self, field.name) for field in fields(self)}
        # The functions of the fractional models have no name by which pickle finds them.
        return state | ({"model": self.entry.name} if self.entry is not None else {})

    def __setstate__(self, state: dict[str, Any]) -> None:
        model = state["model"]
        self.__dict__.update(
            state | {"model": models.material_models()[model].build if isinstance(model, str) else model}
        )

    def values(self, coordinates: Array) -> dict[str, Array]:
        """Return values of the unknowns at coordinates of shape (m, p), shape (m,) each."""
        if all(parameter.kind == "log" for parameter in self.free):
            # Further coordinates are constants of the data, such as the point of contact.
            return dict(zip(self.names, np.exp(coordinates.T), strict=False))
        return {parameter.name: parameter.outward(coordinates[:, k]) for k, parameter in enumerate(self.free)}

    def arguments(self, coordinates: Array) -> dict[str, Any]:
        """Return all arguments: unknown numbers as arrays (m, 1), lists with unknown entries as (m, 1, n_list)."""
        result, numbers = dict(self.fixed), np.stack([*self.values(coordinates).values()], axis=1)
        for argument, (columns, entries) in self._places.items():
            if entries is None:
                result[argument] = numbers[:, columns]
            else:
                result[argument] = np.tile(self.fixed[argument], (len(numbers), 1, 1))
                result[argument][..., entries] = numbers[:, None, columns]
        return result

    @cached_property
    def _unchecked(self) -> Any:
        """The model without the checks of its arguments."""
        return inspect.unwrap(self.model)

    @cached_property
    def _places(self) -> dict[str, tuple[list[int], list[int] | None]]:
        """Columns of the unknowns of each argument, and their entries if the argument is a list."""
        places: dict[str, tuple[list[int], list[int] | None]] = {}
        for k, parameter in enumerate(self.free):
            argument, entry = _split(parameter.name)
            columns, entries = places.setdefault(argument, ([], None if entry is None else []))
            columns.append(k)
            if entry is not None and entries is not None:
                entries.append(entry)
        return places

    def _of_model(self, arguments: dict[str, Any]) -> dict[str, Any]:
        """Return arguments without those of the shift."""
        if not isinstance(self.shift, type):
            return arguments
        return {name: value for name, value in arguments.items() if name not in _law_arguments(self.shift)}

    def constants(self, arguments: dict[str, Any], row: int = 0) -> dict[str, Any]:
        """Return arguments of the model in one row."""
        result = dict(self._of_model(arguments))
        for name in {parameter.argument for parameter in self.free} & result.keys():
            value = result[name][row, 0]
            result[name] = value if value.ndim else float(value)
        return result

    def material(self, coordinates: Array) -> Material | FractionalMaterial:
        """Return the material at coordinates of shape (p,)."""
        arguments = self.arguments(coordinates[None])
        material = self.model(**self.constants(arguments))
        law = self.shift
        if isinstance(law, type):
            law = law(**{name: float(np.squeeze(arguments[name])) for name in _law_arguments(law)})
        if isinstance(material, Material) and law is not None:
            return replace(material, shift=law, temperature=law.reference_temperature)
        return material

    def materials(self, coordinates: Array, window: tuple[float, float]) -> Material:
        """Return materials at coordinates of shape (m, p), an array of shape (m, 1).

        Fractional models are valid within a window of times [s].

        Raises
        ------
        InputError
            If the model refuses the constants of a row; see `rows_of`.
        """
        arguments, m = self.arguments(coordinates), len(coordinates)
        if self.entry is not None and not self.entry.needs_window:
            # Fixed numbers are checked, and coordinates lie in the ranges of the quantities: no check in each call.
            materials = self._unchecked(**self._of_model(arguments))
        else:
            materials = column([self.model(**self.constants(arguments, row)) for row in range(m)], window)
        law = self.shift
        if isinstance(law, type):
            trial = law.from_checked(**{name: arguments[name] for name in _law_arguments(law)})
            law = RowShifts(trial.reference_temperature, trial.factor_or_nan)
        if law is not None:
            materials = replace(materials, shift=law, temperature=law.reference_temperature)
        return materials if materials.shear.shape == (m, 1) else materials.broadcast_to((m, 1))


@dataclass(frozen=True, eq=False)
class RowShifts:
    """Shift laws of materials of shape (m, 1), one for each row."""

    reference_temperature: Any  # [K], one, or of shape (m, 1)
    factor: Callable[[Any], Array]  # of temperatures [K] that broadcast against (m, 1)

    @classmethod
    def of_laws(cls, laws: Sequence[Any]) -> RowShifts:
        """Collect the laws of materials that were made one by one."""

        def factor(temperature: Any) -> Array:
            rows = np.broadcast_to(temperature, np.broadcast_shapes((len(laws), 1), np.shape(temperature)))
            return np.array([law.factor(row) for law, row in zip(laws, rows, strict=True)])

        return cls(np.array([[law.reference_temperature] for law in laws]), factor)


def column(materials: Sequence[Material | FractionalMaterial], window: tuple[float, float] = (1e-6, 1.0)) -> Material:
    """Return the array of materials, shape (m, 1), which broadcasts against measured points (n,).

    Fractional materials hold within a window of times [s].
    """
    shape = len(materials), 1
    if all(isinstance(each, FractionalMaterial) and isinstance(each.bulk, int | float) for each in materials):
        # Differences of fits need series that are smooth functions of the constants.
        series = fractional_series([each.shear for each in materials], window)  # pyright: ignore[reportArgumentType]
        return Material(series.reshaped(shape), np.array([[each.bulk] for each in materials], dtype=np.float64))
    plain = [each.within(window) if isinstance(each, FractionalMaterial) else each for each in materials]
    stacked, laws = Material.stacked(plain).reshaped(shape), [each.shift for each in plain]
    if stacked.shift is not None or None in laws:
        return stacked
    temperature = np.array([[each.temperature] for each in plain])
    return replace(stacked, shift=RowShifts.of_laws(laws), temperature=temperature)


def rows_of(function: Callable[[Any], Array], m: int) -> Array:
    """Return the values of a function of m rows; rows that a model or a shift refuses are NaN. Halving finds them.

    If all rows are refused, the values have one column.
    """
    values: list[tuple[Any, Array]] = []

    def evaluate(first: int, last: int) -> None:
        try:
            values.append((slice(first, last), function(slice(first, last))))
        except InputError:
            if last - first > 1:
                middle = (first + last) // 2
                evaluate(first, middle)
                evaluate(middle, last)

    evaluate(0, m)
    if values and values[0][0] == slice(0, m):
        return values[0][1]
    result = np.full((m, *values[0][1].shape[1:]) if values else (m, 1), np.nan)
    for rows, part in values:
        result[rows] = part
    return result


def penalties(space: Parameters, coordinates: Array) -> Array:
    """Return residuals of the priors at coordinates of shape (m, p), shape (m, n_prior)."""
    if not space.prior:
        return np.empty((len(coordinates), 0))
    values, columns = space.values(coordinates), []
    for name, prior in space.prior.items():
        if isinstance(prior, LogNormal):
            columns.append(np.log(values[name] / prior.median) / prior.sigma)
        elif isinstance(prior, Normal):
            columns.append((values[name] - prior.mean) / prior.standard_deviation)
    return np.stack(columns, axis=1) if columns else np.empty((coordinates.shape[0], 0))


def start_and_bounds(space: Parameters, modulus: float, time: float) -> tuple[Array, Array, Array]:
    """Start, lowest and highest coordinates about an effective modulus E* [Pa] and a contact time [s]."""
    scales = {MODULUS: modulus / 4.0, TIME: time, VISCOSITY: 0.25 * modulus * time}
    rows: list[tuple[float, float, float]] = []
    for parameter in space.free:
        scale = scales.get(parameter.quantity.dimension)
        begin = space.start.get(parameter.name, _STARTS.get(parameter.argument, scale))
        if parameter.argument == "coefficient" and parameter.name not in space.start:
            begin = 0.25 * modulus * time**0.3
        if begin is None and parameter.name in space.prior:
            begin = float(space.prior[parameter.name].quantiles(np.array([0.5]), parameter.low, parameter.high)[0])
        if begin is None and parameter.bounded:
            begin = float(
                parameter.outward(0.5 * (parameter.inward(parameter.low) + parameter.inward(parameter.high)))
            )
        if begin is None:
            raise InputError(f"start.{parameter.name}", rule="must be given: the data do not give its size")
        begin = min(
            max(begin, parameter.low + 1e-9 * abs(parameter.low)),
            parameter.high * (1.0 - 1e-9) if parameter.high < math.inf else begin,
        )
        z = float(parameter.inward(begin))
        if parameter.kind == "logit":
            reach = _EXPONENTS if parameter.argument == "exponent" else (-_LOGIT, _LOGIT)
        elif parameter.kind == "log":
            wide = _WIDE * (2.0 if parameter.quantity.dimension in (VISCOSITY, NUMBER) else 1.0)
            middle = math.log(scale) if scale is not None else z
            if parameter.argument == "bulk_modulus":
                middle += 2.0
            reach = (min(middle, z) - wide, max(middle, z) + wide)
        else:
            reach = (-math.inf, math.inf)
        with np.errstate(divide="ignore"):
            limits = float(parameter.inward(parameter.low)), float(parameter.inward(parameter.high))
        if parameter.bounded:
            rows.append((z, *limits))
        else:
            rows.append((z, max(reach[0], limits[0]), min(reach[1], limits[1])))
    return tuple(np.array(rows).T)  # pyright: ignore[reportReturnType]


def _law_arguments(shift: Any) -> tuple[str, ...]:
    return "reference_temperature", *law_constants(shift)


_SHIFT = "must be WLF, Arrhenius, or a shift with its numbers"


def law_constants(shift: Any) -> tuple[str, ...]:
    if shift is WLF:
        return "c1", "c2"
    if shift is Arrhenius:
        return ("activation_energy",)
    raise InputError("shift", getattr(shift, "__name__", shift), _SHIFT)


# Arguments of a user on the parameters of a model: known values, bounds, starts and priors.

SPECTRUM = "spectrum"
"""Name of the model without constants, `restitution.identification.spectrum`."""

_SHARED = ("density", "name", "approximation_rtol")


def parameters(
    model: Any,
    *,
    fixed: Mapping[str, Any] | None = None,
    bounds: Mapping[str, Any] | None = None,
    start: Mapping[str, Any] | None = None,
    prior: Mapping[str, Any] | None = None,
    shift: Any = None,
    terms: int = 2,
    temperature: float | None = None,
) -> Parameters:
    """Return parameters of a model.

    Parameters
    ----------
    model : callable or str
        Function that returns a material, or the name of a model of the package.
    fixed, bounds, start, prior : dict
        As in `restitution.identify`, by the name of the argument; lists for an argument that is a list.
    shift : type or Shift
        `WLF` or `Arrhenius` with unknown constants, or a shift.
    terms : int
        Length of an argument that is a list.
    temperature : float
        Reference temperature [K] of a shift with unknown constants, if `fixed` has none.
    """
    fixed, bounds = _given("fixed", fixed), _given("bounds", bounds)
    start, prior = _given("start", start), _given("prior", prior)
    build, entry = _built(model)
    constants = _constants(build, entry)
    if shift is not None and not isinstance(shift, type):
        instance("shift", shift, Shift, _SHIFT)
    law = law_constants(shift) if isinstance(shift, type) else ()
    for name in (*fixed, *bounds, *start, *prior):
        names = (*constants, *law, *(["reference_temperature"] if law else []))
        if name.partition("[")[0] not in names:
            raise InputError(name, rule=f"is no parameter of {build.__name__}; {advice(name, names)}")
    named = {name.partition("[")[0] for part in (fixed, bounds, start, prior) for name in part}
    groups = entry.one_of if entry is not None else ()
    left_out = set[str]()
    for group in groups:
        chosen = [name for name in group if name in named]
        if len(chosen) > 1:
            raise InputError(", ".join(chosen), rule="must not both be given: each follows from the other")
        default = "bulk_modulus" if "bulk_modulus" in group else group[0]
        left_out |= set(group) - {chosen[0] if chosen else default}
    defaults = inspect.signature(build).parameters
    known_values: dict[str, Any] = {}
    free: list[Parameter] = []
    for name, (quantity, is_list, required) in constants.items():
        if name in left_out or (not required and name not in named and not any(name in group for group in groups)):
            default = defaults[name].default if name in defaults else None
            if isinstance(default, int | float) and not isinstance(default, bool):
                known_values[name] = default
            continue
        value = fixed.get(name)
        if not is_list:
            if value is not None:
                known_values[name] = checks.single(name, quantity.check(value, f"fixed.{name}"))
            else:
                free.append(_parameter(name, quantity, bounds.get(name)))
            continue
        entries = [] if value is None else np.atleast_1d(np.asarray(quantity.check(value, f"fixed.{name}"))).tolist()
        count = len(entries) or _length(name, (start, bounds, prior), terms)
        filled = np.array(entries or [math.nan] * count, dtype=np.float64)
        for k in range(count):
            place = f"{name}[{k}]"
            if place in fixed:
                filled[k] = checks.single(place, quantity.check(fixed[place], f"fixed.{place}"))
            elif not entries:
                free.append(_parameter(place, quantity, _of_list(bounds, name, k)))
        known_values[name] = filled
    for name in law:
        if name in fixed:
            known_values[name] = checks.single_positive(f"fixed.{name}", fixed[name], SHIFTS[name].unit)
        else:
            free.append(_parameter(name, SHIFTS[name], bounds.get(name)))
    if law:
        reference = fixed.get("reference_temperature", temperature)
        if reference is None:
            raise InputError("shift", rule="needs data with a temperature")
        known_values["reference_temperature"] = check_single("temperature", reference, "reference_temperature")
    known_values |= {name: fixed[name] for name in ("density", "name") if name in fixed}
    starts = {parameter.name: _of_list(start, *_split(parameter.name)) for parameter in free}
    begin = {name: float(value) for name, value in starts.items() if value is not None}
    for parameter in free:
        if parameter.name in begin and not parameter.low < begin[parameter.name] < parameter.high:
            raise InputError(
                f"start.{parameter.name}", begin[parameter.name], f"must be in ({parameter.low:g}, {parameter.high:g})"
            )
    priors = {parameter.name: _of_list(prior, *_split(parameter.name)) for parameter in free}
    priors = {name: value for name, value in priors.items() if value is not None}
    for name, value in priors.items():
        if not isinstance(value, Normal | LogNormal | Uniform | LogUniform):
            raise InputTypeError(f"prior.{name}", value, "must be Normal, LogNormal, Uniform or LogUniform")
    free = [_within(parameter, priors.get(parameter.name)) for parameter in free]
    if not free:
        raise InputError("fixed", rule="must leave at least one parameter unknown")
    return Parameters(build, tuple(free), known_values, begin, priors, shift)


def parameter_names(model: Any, shift: Any = None) -> tuple[str, ...]:
    """Return names of all arguments of a model that may be unknown, and those of a law of the shift."""
    if model == "spectrum":
        return ("poisson_ratio",)
    law = ("reference_temperature", *law_constants(shift)) if isinstance(shift, type) else ()
    return *_constants(*_built(model)), *law


def _given(name: str, values: Any) -> dict[str, Any]:
    return checks.mapping(name, values, "must be a dict with names of parameters as keys")


def _built(model: Any) -> tuple[Model, models.MaterialModel | None]:
    """Return the function that returns the material, and its entry in the registry."""
    entries = models.material_models()
    try:
        signed = isinstance(model, str) or bool(inspect.signature(model))
    # A foreign object may raise anything.
    except Exception:
        signed = False
    if not signed:
        raise InputTypeError("model", model, "must be a function that returns a Material, or the name of a model")
    if isinstance(model, str):
        if model not in entries:
            raise InputError("model", model, f"is not known; {advice(model, entries)}")
        return entries[model].build, entries[model]
    if not callable(model):
        raise InputTypeError("model", model, "must be a function that returns a Material, or the name of a model")
    entry = entries.get(getattr(model, "__name__", ""))
    # The public function of a fractional model returns the relaxation in shear alone.
    if entry is not None and (entry.build is model or getattr(model, "__module__", "") == entry.build.__module__):
        return entry.build, entry
    function: Any = model
    return function, None


def _constants(build: Model, entry: models.MaterialModel | None) -> dict[str, tuple[Quantity, bool, bool]]:
    """Return the quantity of each argument, whether it is a list, and whether it must be given."""
    if entry is not None:
        constants = [constant for constant in entry.constants.values() if constant.name not in _SHARED]
        return {constant.name: (constant.quantity, constant.is_list, constant.required) for constant in constants}
    try:
        noted = models.constants_of(build) if get_type_hints(build) else {}
    except (KeyError, NameError, TypeError):
        noted = {}
    quantities: dict[str, tuple[Quantity, bool, bool]] = {}
    for name, parameter in inspect.signature(build).parameters.items():
        if name in _SHARED or parameter.kind in (parameter.VAR_POSITIONAL, parameter.VAR_KEYWORD):
            continue
        required = parameter.default is parameter.empty
        if name in noted:
            quantities[name] = noted[name].quantity, noted[name].is_list, required
            continue
        quantity = INPUTS.get(name) or CONSTANTS.get(name)
        is_list = quantity is not None and name in ("branch_moduli", "relaxation_times")
        quantities[name] = (
            quantity or Quantity(name, NUMBER, name.replace("_", " "), "", 0.0, open=True),
            is_list,
            required,
        )
    return quantities


def _parameter(name: str, quantity: Quantity, bounds: Any) -> Parameter:
    low, high = quantity.low, quantity.high
    kind: Kind = (
        "log" if low >= 0.0 and high == math.inf else "logit" if high < math.inf and low > -math.inf else "linear"
    )
    if bounds is None:
        return Parameter(name, quantity, kind, low, high)
    try:
        least, most = (checks.single(name, quantity.check(end, f"bounds.{name}")) for end in bounds)
    except (TypeError, ValueError) as error:
        if isinstance(error, InputError):
            raise
        raise InputTypeError(f"bounds.{name}", bounds, "must be a pair of numbers") from None
    if not least < most or (kind == "log" and least <= 0.0):
        rule = "must be two ascending numbers > 0" if kind == "log" else "must ascend"
        raise InputError(f"bounds.{name}", f"({least:g}, {most:g})", rule, quantity.unit)
    return Parameter(name, quantity, kind, least, most, True)


def _within(parameter: Parameter, prior: Any) -> Parameter:
    """Return the parameter within the ends of a uniform prior."""
    if not isinstance(prior, Uniform | LogUniform):
        return parameter
    low, high = max(parameter.low, prior.low), min(parameter.high, prior.high)
    if not low < high:
        raise InputError(f"prior.{parameter.name}", prior, f"must overlap [{parameter.low:g}, {parameter.high:g}]")
    return parameter._replace(low=low, high=high, bounded=True)


def _split(name: str) -> tuple[str, int | None]:
    argument, _, place = name.partition("[")
    return argument, int(place.rstrip("]")) if place else None


def _of_list(values: Mapping[str, Any], name: str, place: int | None) -> Any:
    """Return the value given for one entry of a list, by the name of the entry or of the list."""
    if place is None:
        return values.get(name)
    if f"{name}[{place}]" in values:
        return values[f"{name}[{place}]"]
    whole = values.get(name)
    pair = isinstance(whole, tuple) and len(whole) == 2 and not np.ndim(whole[0])
    return whole[place] if isinstance(whole, Sequence | np.ndarray) and not pair else whole


def _length(name: str, arguments: tuple[Mapping[str, Any], ...], terms: int) -> int:
    for part in arguments:
        if isinstance(part.get(name), list | np.ndarray):
            return len(part[name])
    return terms
