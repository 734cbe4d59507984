"""Parameters of a model of the material: names, logarithms, bounds and priors, and the way to columns of materials."""

from __future__ import annotations

import inspect
import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any, Literal, NamedTuple, get_type_hints

import numpy as np
from numpy.typing import NDArray

from restitution import checks
from restitution.errors import InputError, InputTypeError
from restitution.material import models
from restitution.material.columns import MaterialColumns, PronyColumns
from restitution.material.conversion import bulk_factor
from restitution.material.fractional import FractionalMaterial
from restitution.material.shift import WLF, Arrhenius, Shift
from restitution.material.viscoelastic import Material
from restitution.quantities import (
    CONSTANTS,
    INPUTS,
    MODULUS,
    MOLAR_ENERGY,
    NUMBER,
    TEMPERATURE_DIFFERENCE,
    TIME,
    VISCOSITY,
    Quantity,
    advice,
)
from restitution.sweeps.samples import LogNormal, LogUniform, Normal, Uniform

Array = NDArray[np.float64]
Kind = Literal["log", "logit", "linear"]
Model = Callable[..., Material | FractionalMaterial]

_LAWS: Mapping[str, Quantity] = {
    one.name: one
    for one in (
        Quantity("c1", NUMBER, "WLF constant", r"$C_1$", 0.0, open=True),
        Quantity("c2", TEMPERATURE_DIFFERENCE, "WLF constant", r"$C_2$", 0.0, open=True),
        Quantity("activation_energy", MOLAR_ENERGY, "activation energy", r"$Q$", 0.0, open=True),
    )
}
_SHARED = ("density", "name", "approximation_rtol")
# Half the width of the range of a logit.
_LOGIT = 12.0
# Bounds a factor of 1e4 about the effective modulus and the contact time.
_WIDE = math.log(1e4)
# Starts of what no datum shows by itself.
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
        """Coordinate of the fit of a value."""
        x = np.asarray(value, dtype=np.float64)
        if self.kind == "log":
            return np.log(x)[()]
        if self.kind == "logit":
            low, high = self.quantity.low, self.quantity.high
            return np.log((x - low) / (high - x))[()]
        return x[()]

    def outward(self, coordinate: Any) -> Any:
        """Value at a coordinate of the fit."""
        z = np.asarray(coordinate, dtype=np.float64)
        if self.kind == "log":
            return np.exp(z)[()]
        if self.kind == "logit":
            low, high = self.quantity.low, self.quantity.high
            return (low + (high - low) / (1.0 + np.exp(-z)))[()]
        return z[()]


@dataclass(frozen=True, eq=False)
class Parameters:
    """Unknown constants of a model of the material, and the known ones.

    Attributes
    ----------
    model : callable
        Function that returns a `Material` or a `FractionalMaterial`.
    free : tuple of Parameter
        Unknowns in their order.
    fixed : dict
        Known arguments of the model and of the shift; lists have NaN where an entry is unknown.
    start, prior : dict
        What the user gave, by the name of the parameter.
    shift : type or Shift, optional
        Law of the shift, or a shift without unknowns.
    """

    model: Model
    free: tuple[Parameter, ...]
    fixed: Mapping[str, Any]
    start: Mapping[str, float]
    prior: Mapping[str, Any]
    shift: Any = None

    @property
    def names(self) -> tuple[str, ...]:
        """Names of the unknowns."""
        return tuple(one.name for one in self.free)

    @cached_property
    def entry(self) -> models.MaterialModel | None:
        """Entry of the model in the registry."""
        return next((one for one in models.material_models().values() if one.build is self.model), None)

    def values(self, coordinates: Array) -> dict[str, Array]:
        """Values of the unknowns at coordinates of shape (m, p), shape (m,) each."""
        return {one.name: one.outward(coordinates[:, k]) for k, one in enumerate(self.free)}

    def arguments(self, coordinates: Array) -> dict[str, Any]:
        """All arguments, shape (m,) or (m, n_list) each; other things as they are given."""
        m, found = coordinates.shape[0], dict[str, Any]()
        for name, value in self.fixed.items():
            number = isinstance(value, int | float | np.ndarray) and not isinstance(value, bool)
            found[name] = np.broadcast_to(value, (m, *np.shape(value))).copy() if number else value
        for name, column in self.values(coordinates).items():
            argument, _, place = name.partition("[")
            if place:
                found[argument][:, int(place.rstrip("]"))] = column
            else:
                found[argument] = column
        return found

    def material(self, coordinates: Array) -> Material | FractionalMaterial:
        """Material at coordinates of shape (p,)."""
        made = self.model(**self._row(self.arguments(coordinates[None]), 0))
        law = self._law(coordinates[None])
        if isinstance(made, Material) and law is not None:
            return replace(made, shift=law, temperature=law.reference_temperature)
        return made

    def columns(self, coordinates: Array, window: tuple[float, float]) -> MaterialColumns:
        """Materials at coordinates of shape (m, p); those that are not admissible are NaN.

        Fractional models hold within a window of times [s].
        """
        arguments = self.arguments(coordinates)
        make = _SHEAR.get(self.entry.name) if self.entry is not None else None
        shear = make(arguments) if make is not None else None
        if shear is not None:
            if "poisson_ratio" in arguments:
                factor = bulk_factor(arguments["poisson_ratio"])
                with np.errstate(invalid="ignore"):
                    bulk = np.where(np.isinf(factor), np.inf, shear.equilibria * factor)
            else:
                bulk = arguments["bulk_modulus"]
            found = MaterialColumns.from_shear(shear, bulk)
        else:
            found = self._from_objects(arguments, coordinates.shape[0], window)
        factors = self._factors(arguments)
        return found if factors is None else replace(found, shift=factors)

    def _from_objects(self, arguments: dict[str, Any], m: int, window: tuple[float, float]) -> MaterialColumns:
        made: list[Material | FractionalMaterial | None] = []
        for row in range(m):
            try:
                made.append(self.model(**self._row(arguments, row)))
            except InputError:
                made.append(None)
        good = [one for one in made if one is not None]
        if not good:
            self.model(**self._row(arguments, 0))
        columns = MaterialColumns.from_materials([one or good[0] for one in made], window)
        bad = np.array([one is None for one in made])
        if np.any(bad):
            for series in (columns.shear, columns.reduced):
                series.equilibria[bad] = np.nan
        return columns

    def _row(self, arguments: dict[str, Any], row: int) -> dict[str, Any]:
        found: dict[str, Any] = {}
        for name, value in arguments.items():
            if name in _LAWS or name == "reference_temperature":
                continue
            one = value[row] if isinstance(value, np.ndarray) else value
            found[name] = float(one) if np.ndim(one) == 0 and isinstance(one, np.floating) else one
        return found

    def _law(self, coordinates: Array) -> Shift | None:
        if not isinstance(self.shift, type):
            return self.shift
        arguments = self.arguments(coordinates)
        names = ("reference_temperature", *_law_constants(self.shift))
        return self.shift(**{name: float(arguments[name][0]) for name in names})

    def _factors(self, arguments: dict[str, Any]) -> Callable[[float], Array] | None:
        """Factors of the relaxation times of all rows at a temperature."""
        law = self.shift
        if law is None:
            return None
        if not isinstance(law, type):
            return lambda temperature: np.asarray(law.factor(temperature))

        rest = arguments["reference_temperature"]
        if law is WLF:
            c1, c2 = arguments["c1"], arguments["c2"]

            def factors(temperature: float) -> Array:
                rise = temperature - rest
                with np.errstate(all="ignore"):
                    return np.where(c2 + rise > 0.0, 10.0 ** (-c1 * rise / (c2 + rise)), np.nan)

            return factors
        energy = arguments["activation_energy"] / 8.31446261815324
        return lambda temperature: np.exp(energy * (1.0 / temperature - 1.0 / rest))


def _shear_of_terms(equilibrium: Array, moduli: Array, times: Array) -> PronyColumns:
    return PronyColumns(equilibrium, np.zeros(equilibrium.size), moduli, times)


def _kelvin_voigt(a: dict[str, Any]) -> PronyColumns | None:
    if np.any(a.get("bulk_viscosity", 0.0)):
        return None
    none = np.empty((a["viscosity"].size, 0))
    return PronyColumns(a["shear_modulus"], a["viscosity"], none, none)


def _elastic(a: dict[str, Any]) -> PronyColumns:
    if "shear_modulus" in a:
        return PronyColumns.springs(a["shear_modulus"])
    tension = a["youngs_modulus"]
    if "poisson_ratio" in a:
        return PronyColumns.springs(tension / (2.0 * (1.0 + a["poisson_ratio"])))
    room = 9.0 - tension / a["bulk_modulus"]
    return PronyColumns.springs(np.where(room > 0.0, 3.0 * tension / room, np.nan))


_SHEAR: Mapping[str, Callable[[dict[str, Any]], PronyColumns | None]] = {
    "standard_solid": lambda a: _shear_of_terms(
        a["equilibrium_modulus"], a["branch_modulus"][:, None], (a["viscosity"] / a["branch_modulus"])[:, None]
    ),
    "kelvin_voigt": _kelvin_voigt,
    "maxwell": lambda a: _shear_of_terms(
        np.zeros(a["viscosity"].size), a["shear_modulus"][:, None], (a["viscosity"] / a["shear_modulus"])[:, None]
    ),
    "elastic": _elastic,
    "generalised_maxwell": lambda a: _shear_of_terms(
        a["equilibrium_modulus"], a["branch_moduli"], a["relaxation_times"]
    ),
}
"""Relaxation in shear from columns of arguments, for the models of the package that need no object in each row."""


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
    """Parameters of a model.

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
        Reference temperature [K] of a shift with unknown constants, where `fixed` has none.
    """
    fixed, bounds = _given("fixed", fixed), _given("bounds", bounds)
    start, prior = _given("start", start), _given("prior", prior)
    build, entry = _built(model)
    constants = _constants(build, entry)
    law = _law_constants(shift) if isinstance(shift, type) else ()
    for name in (*fixed, *bounds, *start, *prior):
        known = (*constants, *law, *(["reference_temperature"] if law else []))
        if name.partition("[")[0] not in known:
            raise InputError(name, wanted=f"is no parameter of {build.__name__}; {advice(name, known)}")
    named = {name.partition("[")[0] for part in (fixed, bounds, start, prior) for name in part}
    groups = entry.one_of if entry is not None else ()
    left_out = set[str]()
    for group in groups:
        chosen = [name for name in group if name in named]
        if len(chosen) > 1:
            raise InputError(", ".join(chosen), wanted="must not both be given: each follows from the other")
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
            known_values[name] = checks.single_positive(f"fixed.{name}", fixed[name], _LAWS[name].unit)
        else:
            free.append(_parameter(name, _LAWS[name], bounds.get(name)))
    if law:
        reference = fixed.get("reference_temperature", temperature)
        if reference is None:
            raise InputError("shift", wanted="needs data with a temperature")
        known_values["reference_temperature"] = checks.single_positive("reference_temperature", reference, "K")
    known_values |= {name: fixed[name] for name in ("density", "name") if name in fixed}
    starts = {one.name: _of_list(start, *_split(one.name)) for one in free}
    begin = {name: float(value) for name, value in starts.items() if value is not None}
    for one in free:
        if one.name in begin and not one.low < begin[one.name] < one.high:
            raise InputError(f"start.{one.name}", begin[one.name], f"must be in ({one.low:g}, {one.high:g})")
    priors = {one.name: _of_list(prior, *_split(one.name)) for one in free}
    priors = {name: value for name, value in priors.items() if value is not None}
    for name, value in priors.items():
        if not isinstance(value, Normal | LogNormal | Uniform | LogUniform):
            raise InputTypeError(f"prior.{name}", value, "must be Normal, LogNormal, Uniform or LogUniform")
    free = [_within(one, priors.get(one.name)) for one in free]
    if not free:
        raise InputError("fixed", wanted="must leave at least one parameter unknown")
    return Parameters(build, tuple(free), known_values, begin, priors, shift)


def penalties(space: Parameters, coordinates: Array) -> Array:
    """Residuals of the priors at coordinates of shape (m, p), shape (m, n_prior)."""
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
    for one in space.free:
        scale = scales.get(one.quantity.dimension)
        begin = space.start.get(one.name, _STARTS.get(one.argument, scale))
        if one.argument == "coefficient" and one.name not in space.start:
            begin = 0.25 * modulus * time**0.3
        if begin is None and one.name in space.prior:
            begin = float(space.prior[one.name].quantiles(np.array([0.5]), one.low, one.high)[0])
        if begin is None and one.bounded:
            begin = float(one.outward(0.5 * (one.inward(one.low) + one.inward(one.high))))
        if begin is None:
            raise InputError(f"start.{one.name}", wanted="must be given, as no datum shows its size")
        begin = min(
            max(begin, one.low + 1e-9 * abs(one.low)), one.high * (1.0 - 1e-9) if one.high < math.inf else begin
        )
        z = float(one.inward(begin))
        if one.kind == "logit":
            reach = (-_LOGIT, _LOGIT)
        elif one.kind == "log":
            wide = _WIDE * (2.0 if one.quantity.dimension in (VISCOSITY, NUMBER) else 1.0)
            middle = math.log(scale) if scale is not None else z
            if one.argument == "bulk_modulus":
                middle += 2.0
            reach = (min(middle, z) - wide, max(middle, z) + wide)
        else:
            reach = (-math.inf, math.inf)
        with np.errstate(divide="ignore"):
            limits = float(one.inward(one.low)), float(one.inward(one.high))
        if one.bounded:
            rows.append((z, *limits))
        else:
            rows.append((z, max(reach[0], limits[0]), min(reach[1], limits[1])))
    return tuple(np.array(rows).T)  # pyright: ignore[reportReturnType]


def _given(name: str, values: Any) -> dict[str, Any]:
    if values is None:
        return {}
    if not isinstance(values, Mapping):
        raise InputTypeError(name, values, "must be a dict by the name of the parameter")
    return dict(values)


def _built(model: Any) -> tuple[Model, models.MaterialModel | None]:
    """Function that makes the material, and its entry in the registry."""
    known = models.material_models()
    if isinstance(model, str):
        if model not in known:
            raise InputError("model", model, f"is not known; {advice(model, known)}")
        return known[model].build, known[model]
    if not callable(model):
        raise InputTypeError("model", model, "must be a function that returns a Material, or the name of a model")
    entry = known.get(getattr(model, "__name__", ""))
    # The public function of a fractional model makes the relaxation in shear alone.
    if entry is not None and (entry.build is model or getattr(model, "__module__", "") == entry.build.__module__):
        return entry.build, entry
    return model, None


def _constants(build: Model, entry: models.MaterialModel | None) -> dict[str, tuple[Quantity, bool, bool]]:
    """Quantity of each argument, whether it is a list, and whether it must be given."""
    if entry is not None:
        return {name: (one.quantity, one.is_list, one.required) for name, one in entry.constants.items()
                if name not in _SHARED}  # fmt: skip
    try:
        noted = models.constants_of(build) if get_type_hints(build) else {}
    except (KeyError, NameError, TypeError):
        noted = {}
    found: dict[str, tuple[Quantity, bool, bool]] = {}
    for name, parameter in inspect.signature(build).parameters.items():
        if name in _SHARED or parameter.kind in (parameter.VAR_POSITIONAL, parameter.VAR_KEYWORD):
            continue
        required = parameter.default is parameter.empty
        if name in noted:
            found[name] = noted[name].quantity, noted[name].is_list, required
            continue
        quantity = INPUTS.get(name) or CONSTANTS.get(name)
        is_list = quantity is not None and name in ("branch_moduli", "relaxation_times")
        found[name] = quantity or Quantity(name, NUMBER, name.replace("_", " "), "", 0.0, open=True), is_list, required
    return found


def _law_constants(shift: Any) -> tuple[str, ...]:
    if shift is WLF:
        return "c1", "c2"
    if shift is Arrhenius:
        return ("activation_energy",)
    raise InputError("shift", getattr(shift, "__name__", shift), "must be WLF, Arrhenius, or a shift with its numbers")


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
        wanted = "must be two ascending numbers > 0" if kind == "log" else "must ascend"
        raise InputError(f"bounds.{name}", f"({least:g}, {most:g})", wanted, quantity.unit)
    return Parameter(name, quantity, kind, least, most, True)


def _within(one: Parameter, prior: Any) -> Parameter:
    """Parameter within the ends of a uniform prior."""
    if not isinstance(prior, Uniform | LogUniform):
        return one
    low, high = max(one.low, prior.low), min(one.high, prior.high)
    if not low < high:
        raise InputError(f"prior.{one.name}", prior, f"must overlap [{one.low:g}, {one.high:g}]")
    return one._replace(low=low, high=high, bounded=True)


def _split(name: str) -> tuple[str, int | None]:
    argument, _, place = name.partition("[")
    return argument, int(place.rstrip("]")) if place else None


def _of_list(given: Mapping[str, Any], name: str, place: int | None) -> Any:
    """What is given for one entry of a list, by the name of the entry or of the list."""
    if place is None:
        return given.get(name)
    if f"{name}[{place}]" in given:
        return given[f"{name}[{place}]"]
    whole = given.get(name)
    pair = isinstance(whole, tuple) and len(whole) == 2 and not np.ndim(whole[0])
    return whole[place] if isinstance(whole, Sequence | np.ndarray) and not pair else whole


def _length(name: str, given: tuple[Mapping[str, Any], ...], terms: int) -> int:
    for part in given:
        if isinstance(part.get(name), list | np.ndarray):
            return len(part[name])
    return terms
