"""Arguments of a user on the parameters of a model: known values, bounds, starts and priors."""

from __future__ import annotations

import inspect
import math
from collections.abc import Mapping, Sequence
from typing import Any, get_type_hints

import numpy as np

from restitution import checks
from restitution.errors import InputError, InputTypeError
from restitution.identification.parameters import LAWS, Kind, Model, Parameter, Parameters, law_constants
from restitution.material import models
from restitution.quantities import CONSTANTS, INPUTS, NUMBER, Quantity, advice, check_single
from restitution.sweeps.samples import LogNormal, LogUniform, Normal, Uniform

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
        Reference temperature [K] of a shift with unknown constants, if `fixed` has none.
    """
    fixed, bounds = _given("fixed", fixed), _given("bounds", bounds)
    start, prior = _given("start", start), _given("prior", prior)
    build, entry = _built(model)
    constants = _constants(build, entry)
    law = law_constants(shift) if isinstance(shift, type) else ()
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
            known_values[name] = checks.single_positive(f"fixed.{name}", fixed[name], LAWS[name].unit)
        else:
            free.append(_parameter(name, LAWS[name], bounds.get(name)))
    if law:
        reference = fixed.get("reference_temperature", temperature)
        if reference is None:
            raise InputError("shift", wanted="needs data with a temperature")
        known_values["reference_temperature"] = check_single("temperature", reference, "reference_temperature")
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


def parameter_names(model: Any, shift: Any = None) -> tuple[str, ...]:
    """Names of all arguments of a model that may be unknown, and those of a law of the shift."""
    if model == "spectrum":
        return ("poisson_ratio",)
    law = ("reference_temperature", *law_constants(shift)) if isinstance(shift, type) else ()
    return *_constants(*_built(model)), *law


def _given(name: str, values: Any) -> dict[str, Any]:
    return checks.mapping(name, values, "must be a dict with names of parameters as keys")


def _built(model: Any) -> tuple[Model, models.MaterialModel | None]:
    """Function that returns the material, and its entry in the registry."""
    known = models.material_models()
    try:
        signed = isinstance(model, str) or bool(inspect.signature(model))
    # A foreign object may raise anything.
    except Exception:
        signed = False
    if not signed:
        raise InputTypeError("model", model, "must be a function that returns a Material, or the name of a model")
    if isinstance(model, str):
        if model not in known:
            raise InputError("model", model, f"is not known; {advice(model, known)}")
        return known[model].build, known[model]
    if not callable(model):
        raise InputTypeError("model", model, "must be a function that returns a Material, or the name of a model")
    entry = known.get(getattr(model, "__name__", ""))
    # The public function of a fractional model returns the relaxation in shear alone.
    if entry is not None and (entry.build is model or getattr(model, "__module__", "") == entry.build.__module__):
        return entry.build, entry
    own: Any = model
    return own, None


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
    """Value given for one entry of a list, by the name of the entry or of the list."""
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
