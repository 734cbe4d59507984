"""Parameters of a model of the material: names, logarithms, bounds and priors, and the way to arrays of materials."""

from __future__ import annotations

import inspect
import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, fields, replace
from functools import cached_property
from typing import Any, NamedTuple, get_type_hints

import numpy as np

from restitution import checks
from restitution.checks import Array, instance
from restitution.contact.adhesion import Adhesion
from restitution.errors import InputError, InputTypeError
from restitution.identification.adhesion import StickyMaterial
from restitution.material import models
from restitution.material.fractional import FractionalMaterial, fractional_series
from restitution.material.shift import WLF, Arrhenius, Shift
from restitution.material.viscoelastic import Material
from restitution.numerics.coordinates import Coordinate, Kind
from restitution.quantities import (
    ADHESION_INPUTS,
    CONSTANTS,
    INPUTS,
    MODULUS,
    NUMBER,
    SHIFTS,
    TIME,
    VISCOSITY,
    Quantity,
    advice,
)
from restitution.sweeps.grid import LogNormal, LogUniform, Normal, Uniform

Model = Callable[..., Material | FractionalMaterial]

# Half the width of the range of a logit; exponents near 1 take very many terms.
_LOGIT = 12.0
# Terms of a series that a fit may have.
MOST_TERMS = 1000
_EXPONENTS = -4.0, 2.2
# Bounds a factor of 1e4 about the effective modulus and the contact time.
_WIDE = math.log(1e4)
# The same of the numbers of an adhesion about their size.
_STICKY = math.log(300.0)
# Starts of parameters that no formula gives from the data.
_STARTS = {"c1": 10.0, "c2": 100.0, "activation_energy": 1e5, "exponent": 0.3, "poisson_ratio": 0.4}


@dataclass(frozen=True)
class Parameter(Coordinate):
    """One unknown number of the model, with its range."""

    low: float
    high: float
    bounded: bool = False  # whether the user gave the range

    @property
    def argument(self) -> str:
        """Name of the argument of the model."""
        return self.name.partition("[")[0]


@dataclass(frozen=True, eq=False)
class Parameters:
    """Unknown and known constants of a model of the material.

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
    adhesion : tuple of str
        Names of the numbers of the adhesion; none without it.
    """

    model: Model
    free: tuple[Parameter, ...]
    fixed: Mapping[str, Any]
    start: Mapping[str, float]
    prior: Mapping[str, Any]
    shift: Any = None
    adhesion: tuple[str, ...] = ()

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

    def numbers(self, coordinates: Array) -> Array:
        """Return values of the unknowns at coordinates of shape (m, p), shape (m, p)."""
        # Further coordinates are constants of the data, such as the point of contact.
        coordinates = coordinates[:, : len(self.free)]
        if all(parameter.kind == "log" for parameter in self.free):
            return np.exp(coordinates)
        columns = zip(self.free, coordinates.T, strict=True)
        return np.stack([parameter.outward(column) for parameter, column in columns], axis=1)

    def arguments(self, coordinates: Array) -> dict[str, Any]:
        """Return all arguments: unknown numbers as arrays (m, 1), lists with unknown entries as (m, 1, n_list)."""
        result, numbers = dict(self.fixed), self.numbers(coordinates)
        for argument, (columns, entries) in self._places.items():
            if entries is None:
                result[argument] = numbers[:, columns]
            else:
                result[argument] = np.empty((len(numbers), 1, len(self.fixed[argument])))
                result[argument][:] = self.fixed[argument]
                result[argument][..., entries] = numbers[:, None, columns]
        return result

    @cached_property
    def _places(self) -> dict[str, tuple[list[int], list[int] | None]]:
        """Columns of the unknowns of each argument, and their entries if the argument is a list."""
        places: dict[str, tuple[list[int], list[int] | None]] = {}
        for k, parameter in enumerate(self.free):
            argument, entry = _split(parameter.name)
            columns, entries = places.setdefault(argument, ([], None if entry is None else []))
            columns.append(k)
            if entries is not None and entry is not None:
                entries.append(entry)
        return places

    def _of_model(self, arguments: dict[str, Any]) -> dict[str, Any]:
        """Return arguments without those of the shift and of the adhesion."""
        other = *_law_arguments(self.shift), *self.adhesion
        return {name: value for name, value in arguments.items() if name not in other} if other else arguments

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
            materials = self.entry.build_checked(**self._of_model(arguments))
        else:
            materials = column([self.model(**self.constants(arguments, row)) for row in range(m)], window)
        law = self.shift
        if isinstance(law, type):
            trial = law.from_checked(**{name: arguments[name] for name in _law_arguments(law)})
            law = RowShifts(trial.reference_temperature, trial.factor_or_nan)
        if law is not None:
            materials = replace(materials, shift=law, temperature=law.reference_temperature)
        materials = materials if materials.shear.shape == (m, 1) else materials.broadcast_to((m, 1))
        if not self.adhesion:
            return materials
        work, other = (np.broadcast_to(arguments[name], (m, 1)) for name in self.adhesion)
        options = {"shift": materials.shift, "temperature": materials.temperature}
        stress = other if "stress" in self.adhesion else work / other
        return StickyMaterial(materials.shear, materials.bulk, work=work, stress=stress, **options)

    def surfaces(self, coordinates: Array) -> Adhesion | None:
        """Return the adhesion at coordinates of shape (p,); None without it."""
        arguments = self.arguments(coordinates[None])
        numbers = {name: float(np.squeeze(arguments[name])) for name in self.adhesion}
        return Adhesion(**numbers) if numbers else None


@dataclass(frozen=True, eq=False)
class RowShifts:
    """Shift laws of materials of shape (m, 1), one for each row."""

    reference_temperature: Any  # [K], one, or of shape (m, 1)
    factor: Callable[[Any], Array]  # of temperatures [K] that broadcast against (m, 1)

    @classmethod
    def of_laws(cls, laws: Sequence[Any]) -> RowShifts:
        """Collect the laws of single materials."""

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
    values, columns = dict(zip(space.names, space.numbers(coordinates).T, strict=True)), []
    for name, prior in space.prior.items():
        if isinstance(prior, LogNormal):
            columns.append(np.log(values[name] / prior.median) / prior.sigma)
        elif isinstance(prior, Normal):
            columns.append((values[name] - prior.mean) / prior.standard_deviation)
    # Uniform priors are bounds.
    return np.stack(columns, axis=1) if columns else np.empty((len(coordinates), 0))


def start_and_bounds(
    space: Parameters, modulus: float, time: float, adhesion: Mapping[str, float]
) -> tuple[Array, Array, Array]:
    """Return the start, lowest and highest coordinates about an effective modulus E* [Pa] and a contact time [s].

    `adhesion` has the sizes of its numbers.
    """
    scales = {MODULUS: modulus / 4.0, TIME: time, VISCOSITY: 0.25 * modulus * time}
    rows: list[tuple[float, float, float]] = []
    for parameter in space.free:
        scale = adhesion.get(parameter.name, scales.get(parameter.quantity.dimension))
        begin = _begin(space, parameter, 0.25 * modulus * time**0.3 if parameter.argument == "coefficient" else scale)
        z = float(parameter.inward(begin))
        with np.errstate(divide="ignore"):
            low, high = float(parameter.inward(parameter.low)), float(parameter.inward(parameter.high))
        reach = -math.inf, math.inf
        if parameter.kind == "logit":
            reach = _EXPONENTS if parameter.argument == "exponent" else (-_LOGIT, _LOGIT)
        elif parameter.kind == "log":
            wide = _WIDE * (2.0 if parameter.quantity.dimension in (VISCOSITY, NUMBER) else 1.0)
            wide = _STICKY if parameter.name in space.adhesion else wide
            # A bulk modulus is usually above the effective modulus.
            middle = z if scale is None else math.log(scale) + 2.0 * (parameter.argument == "bulk_modulus")
            reach = min(middle, z) - wide, max(middle, z) + wide
        rows.append((z, low, high) if parameter.bounded else (z, max(reach[0], low), min(reach[1], high)))
    return tuple(np.array(rows).T)  # pyright: ignore[reportReturnType]


def _begin(space: Parameters, parameter: Parameter, scale: float | None) -> float:
    """Return a start within the range: of the user, a usual one, or that of the data, the prior or the bounds."""
    low, high = parameter.low, parameter.high
    begin = space.start.get(parameter.name, _STARTS.get(parameter.argument, scale))
    if begin is None and parameter.name in space.prior:
        begin = float(space.prior[parameter.name].quantiles(np.array([0.5]), low, high)[0])
    if begin is None and parameter.bounded:
        begin = float(parameter.outward(0.5 * (parameter.inward(low) + parameter.inward(high))))
    if begin is None:
        raise InputError(f"start.{parameter.name}", rule="must be given: the data do not give its size")
    begin = max(begin, low + 1e-9 * abs(low))
    return min(begin, high * (1.0 - 1e-9)) if high < math.inf else begin


_SHIFT = "must be WLF, Arrhenius, or a shift with its numbers"


def _law_arguments(shift: Any) -> tuple[str, ...]:
    """Return names of the unknowns of a law of the shift, after the reference temperature; none for a shift."""
    if not isinstance(shift, type):
        return ()
    if shift not in (WLF, Arrhenius):
        raise InputError("shift", shift.__name__, _SHIFT)
    return "reference_temperature", *(("c1", "c2") if shift is WLF else ("activation_energy",))


# Arguments of a user on the parameters of a model: known values, bounds, starts and priors.

SPECTRUM = "spectrum"
"""Name of the model without constants, `restitution.identification.spectrum`."""

_SHARED = ("density", "name", "approximation_rtol")


class _Argument(NamedTuple):
    """Argument of a model, or of a law of the shift."""

    quantity: Quantity
    is_list: bool = False
    required: bool = True
    default: Any = None


class OfData(NamedTuple):
    """What data say about the unknowns."""

    temperature: float | None = None  # [K], the reference of a shift with unknown constants, if `fixed` has none
    adhesion: bool = False  # whether surfaces adhere


def parameters(
    model: Any,
    *,
    fixed: Mapping[str, Any] | None = None,
    bounds: Mapping[str, Any] | None = None,
    start: Mapping[str, Any] | None = None,
    prior: Mapping[str, Any] | None = None,
    shift: Any = None,
    terms: int = 2,
    of_data: OfData | None = None,
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
    of_data : OfData, optional
        What the data say about the unknowns.
    """
    of_data = of_data or OfData()
    rule = "must be a dict with names of parameters as keys"
    named = {"fixed": fixed, "bounds": bounds, "start": start, "prior": prior}
    fixed, bounds, start, prior = (checks.mapping(key, values, rule) for key, values in named.items())
    if shift is not None and not isinstance(shift, type):
        instance("shift", shift, Shift, _SHIFT)
    build, entry = _built(model)
    arguments = _constants(build, entry)
    laws = {name: _Argument(SHIFTS.get(name, INPUTS["temperature"])) for name in _law_arguments(shift)}
    arguments |= laws
    stated = {name.partition("[")[0]: name for part in (fixed, bounds, start, prior) for name in part}
    sticky = _of_adhesion(stated) if of_data.adhesion else ()
    arguments |= {name: _Argument(ADHESION_INPUTS[name]) for name in sticky}
    for name, place in stated.items():
        if name not in arguments:
            key = next(key for key, part in named.items() if place in (part or ()))
            raise InputError(
                f"{key}.{place}", rule=f"is no parameter of {build.__name__}; {advice(place, [*arguments])}"
            )
    if laws and "reference_temperature" not in fixed:
        if of_data.temperature is None:
            raise InputError("shift", rule="needs data with a temperature")
        fixed["reference_temperature"] = of_data.temperature
    for name in (name for name, argument in arguments.items() if argument.is_list and name in fixed):
        fixed[name] = np.atleast_1d(np.asarray(arguments[name].quantity.check(fixed[name], f"fixed.{name}")))
    parts = {"fixed": fixed, "bounds": bounds, "start": start, "prior": prior}
    entries = _entries(arguments, parts, terms)
    fixed, bounds, start, prior = (_by_entry(key, part, entries) for key, part in parts.items())
    values, free = dict[str, Any](), list[Parameter]()
    chosen = _chosen(entry, arguments, stated)
    for name, argument in arguments.items():
        if name not in chosen:
            # Nothing is stated about the argument, and the model has a default.
            if isinstance(argument.default, int | float) and not isinstance(argument.default, bool):
                values[name] = argument.default
            continue
        numbers = np.full(len(entries[name]), math.nan)
        for k, place in enumerate(entries[name]):
            if fixed.get(place) is not None:
                for key, part in (("bounds", bounds), ("start", start), ("prior", prior)):
                    if part.get(place) is not None:
                        raise InputError(f"{key}.{place}", rule="is that of a parameter that is fixed; leave one out")
                numbers[k] = checks.single(f"fixed.{place}", argument.quantity.check(fixed[place], f"fixed.{place}"))
                continue
            if start.get(place) is not None:
                start[place] = checks.single(
                    place, checks.finite(f"start.{place}", start[place], argument.quantity.unit)
                )
            free.append(_parameter(place, argument.quantity, bounds, start, prior))
        if argument.is_list or not np.isnan(numbers[0]):
            values[name] = numbers if argument.is_list else float(numbers[0])
    if not free:
        raise InputError("fixed", rule="must leave at least one parameter unknown")
    starts, priors = (
        {each.name: part[each.name] for each in free if part.get(each.name) is not None} for part in (start, prior)
    )
    return Parameters(build, tuple(free), values, starts, priors, shift, sticky)


def _of_adhesion(stated: Mapping[str, str]) -> tuple[str, str]:
    """Return the names of the numbers of an adhesion: its work, and the range if that is stated, else the stress."""
    both = [name for name in ("stress", "range") if name in stated]
    if len(both) > 1:
        raise InputError("stress, range", rule="must be one of them, as work = stress range")
    return "work", *(both or ["stress"])  # pyright: ignore[reportReturnType]


def _chosen(
    entry: models.MaterialModel | None, arguments: Mapping[str, _Argument], stated: Mapping[str, str]
) -> set[str]:
    """Return the arguments that are known or unknown; a group of alternatives has one of them."""
    groups = () if entry is None else entry.one_of
    chosen = {name for name, argument in arguments.items() if argument.required or name in stated}
    for group in groups:
        several = [name for name in group if name in stated]
        if len(several) > 1:
            raise InputError(", ".join(several), rule="must not both be given: each follows from the other")
        chosen |= {"bulk_modulus" if "bulk_modulus" in group else group[0]} if not several else set()
    return chosen


def parameter_names(model: Any, shift: Any = None, *, adhesion: bool = False) -> tuple[str, ...]:
    """Return names of all arguments of a model that may be unknown, of a law of the shift, and of adhesion."""
    if model == "spectrum":
        return ("poisson_ratio",)
    return *_constants(*_built(model)), *_law_arguments(shift), *(ADHESION_INPUTS if adhesion else ())


def _built(model: Any) -> tuple[Model, models.MaterialModel | None]:
    """Return the function that returns the material, and its entry in the registry."""
    entries = models.material_models()
    if isinstance(model, str):
        if model not in entries:
            raise InputError("model", model, f"is not known; {advice(model, entries)}")
        return entries[model].build, entries[model]
    try:
        signed = callable(model) and bool(inspect.signature(model))
    # A foreign object may raise anything.
    except Exception:
        signed = False
    if not signed:
        raise InputTypeError("model", model, "must be a function that returns a Material, or the name of a model")
    entry = entries.get(getattr(model, "__name__", ""))
    # The public function of a fractional model returns the relaxation in shear alone.
    if entry is not None and (entry.build is model or getattr(model, "__module__", "") == entry.build.__module__):
        return entry.build, entry
    function: Any = model
    return function, None


def _constants(build: Model, entry: models.MaterialModel | None) -> dict[str, _Argument]:
    """Return the arguments of a model that may be unknown."""
    signature = inspect.signature(build).parameters
    if entry is not None:
        return {
            name: _Argument(
                each.quantity, each.is_list, each.required, signature[name].default if name in signature else None
            )
            for name, each in entry.constants.items()
            if name not in _SHARED
        }
    try:
        noted = models.constants_of(build) if get_type_hints(build) else {}
    except (KeyError, NameError, TypeError):
        noted = {}
    arguments: dict[str, _Argument] = {}
    for name, parameter in signature.items():
        if name in _SHARED or parameter.kind in (parameter.VAR_POSITIONAL, parameter.VAR_KEYWORD):
            continue
        # An argument that is no quantity of the package counts as a positive number.
        plain = Quantity(name, NUMBER, name.replace("_", " "), "", 0.0, open=True)
        quantity = noted[name].quantity if name in noted else INPUTS.get(name) or CONSTANTS.get(name) or plain
        is_list = noted[name].is_list if name in noted else name in ("branch_moduli", "relaxation_times")
        arguments[name] = _Argument(quantity, is_list, parameter.default is parameter.empty, parameter.default)
    return arguments


def _parameter(
    name: str, quantity: Quantity, bounds: Mapping[str, Any], start: Mapping[str, Any], prior: Mapping[str, Any]
) -> Parameter:
    """Return an unknown within its bounds and the ends of a uniform prior; refuse a start beyond them."""
    low, high = quantity.low, quantity.high
    kind: Kind = "linear" if low == -math.inf else "logit" if high < math.inf else "log" if low >= 0.0 else "linear"
    parameter = Parameter(name, quantity, kind, low, high)
    if (ends := bounds.get(name)) is not None:
        parameter = replace(parameter, bounded=True, **_ends(parameter, ends))
    if (begin := start.get(name)) is not None and not parameter.low < begin < parameter.high:
        raise InputError(f"start.{name}", begin, f"must be in ({parameter.low:g}, {parameter.high:g})")
    distribution = prior.get(name)
    if not isinstance(distribution, Normal | LogNormal | Uniform | LogUniform | None):
        raise InputTypeError(f"prior.{name}", distribution, "must be Normal, LogNormal, Uniform or LogUniform")
    if isinstance(distribution, Uniform | LogUniform):
        low, high = max(parameter.low, distribution.low), min(parameter.high, distribution.high)
        if not low < high:
            rule = f"must overlap [{parameter.low:g}, {parameter.high:g}]"
            raise InputError(f"prior.{name}", distribution, rule)
        parameter = replace(parameter, low=low, high=high, bounded=True)
    return parameter


def _ends(parameter: Parameter, bounds: Any) -> dict[str, float]:
    """Return bounds that are two ascending numbers in the range of the parameter."""
    field, quantity = f"bounds.{parameter.name}", parameter.quantity
    try:
        low, high = (checks.single(parameter.name, quantity.check(end, field)) for end in bounds)
    except (TypeError, ValueError) as error:
        if isinstance(error, InputError):
            raise
        raise InputTypeError(field, bounds, "must be a pair of numbers") from None
    if not low < high or (parameter.kind == "log" and low <= 0.0):
        rule = "must be two ascending numbers > 0" if parameter.kind == "log" else "must ascend"
        raise InputError(field, f"({low:g}, {high:g})", rule, quantity.unit)
    return {"low": low, "high": high}


def _split(name: str) -> tuple[str, int | None]:
    argument, _, place = name.partition("[")
    return argument, int(place.rstrip("]")) if place else None


def _entries(
    arguments: Mapping[str, _Argument], parts: Mapping[str, Mapping[str, Any]], terms: int
) -> dict[str, list[str]]:
    """Return the names of the entries of each argument; a list has as many as its value."""
    entries: dict[str, list[str]] = {}
    for name, argument in arguments.items():
        lists = (part[name] for key, part in parts.items() if _is_listed(key, part.get(name)))
        count = len(next(lists, [None] * terms))
        entries[name] = [f"{name}[{k}]" for k in range(count)] if argument.is_list else [name]
    return entries


def _is_listed(part: str, value: Any) -> bool:
    """Return whether an argument has a value for each entry of a list, and not one, or a pair of bounds, for all."""
    if not isinstance(value, Sequence | np.ndarray) or isinstance(value, str):
        return False
    return part != "bounds" or len(value) == 0 or np.ndim(value[0]) > 0


def _by_entry(part: str, values: Mapping[str, Any], entries: Mapping[str, list[str]]) -> dict[str, Any]:
    """Return values by the names of entries; a value for a list is that of all entries, or a list of their values."""
    every = [entry for names in entries.values() for entry in names]
    result: dict[str, Any] = {}
    for name, value in values.items():
        names = entries.get(name, [name])
        if names == [name]:
            if name not in every:
                raise InputError(f"{part}.{name}", rule=f"is no parameter; {advice(name, every)}")
            result[name] = value
            continue
        each = value if _is_listed(part, value) else [value] * len(names)
        if len(each) != len(names):
            raise InputError(f"{part}.{name}", rule=f"must have {len(names)} entries, not {len(each)}")
        result = dict(zip(names, each, strict=True)) | result
    return result
