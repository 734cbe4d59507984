"""Registry of material models: functions whose signatures state the constants, their units and their ranges."""

from __future__ import annotations

import inspect
from collections.abc import Callable, Sequence
from functools import wraps
from importlib import import_module
from operator import attrgetter
from typing import Annotated, Any, NamedTuple, ParamSpec, TypeVar, get_args, get_origin, get_type_hints

import numpy as np
from numpy.typing import ArrayLike

from restitution.axes import aligned, named
from restitution.checks import Numeric, common_shape
from restitution.checks import single as single_number
from restitution.errors import InputError
from restitution.quantities import CONSTANTS, INPUTS, Quantity

_P = ParamSpec("_P")
_T = TypeVar("_T")

EndModulus = Annotated[float, INPUTS["equilibrium_modulus"]]
BranchModulus = Annotated[float, INPUTS["branch_modulus"]]
ShearModulus = Annotated[float, CONSTANTS["shear_modulus"]]
Moduli = Annotated[ArrayLike, INPUTS["branch_moduli"]]
Time = Annotated[float, INPUTS["relaxation_time"]]
Times = Annotated[ArrayLike, INPUTS["relaxation_times"]]
Viscosity = Annotated[float, INPUTS["viscosity"]]
PoissonRatio = Annotated[float, INPUTS["poisson_ratio"]]
BulkModulus = Annotated[float, INPUTS["bulk_modulus"]]
BulkViscosity = Annotated[float, CONSTANTS["bulk_viscosity"]]
Coefficient = Annotated[float, CONSTANTS["coefficient"]]
Exponent = Annotated[float, CONSTANTS["exponent"]]
Density = Annotated[float, INPUTS["density"]]

ONE_BULK = ("poisson_ratio", "bulk_modulus")
"""Exactly one of these two gives the bulk modulus."""
_SHARED = ("density", "name")


class Constant(NamedTuple):
    """A constant of a material model."""

    name: str  # in Python and in case files
    quantity: Quantity  # its dimension, unit, words and admissible range
    is_list: bool = False  # whether it is a list of numbers
    required: bool = True  # whether it must be given


class MaterialModel(NamedTuple):
    """A material model by name."""

    name: str  # that of its function
    build: Callable[..., Any]  # makes the material from the constants in SI, and from `density` and `name`
    constants: dict[str, Constant]  # by name, without the density, which every material has
    one_of: tuple[tuple[str, ...], ...] = ()  # from each group of constants exactly one must be given
    needs_window: bool = False  # whether `build` returns a `FractionalMaterial`, which needs `within(window)`

    @property
    def build_checked(self) -> Callable[..., Any]:
        """`build` for constants that are already checked, each by its quantity; of a model without a window."""
        return inspect.unwrap(self.build)


_MODELS: dict[str, MaterialModel] = {}


def material_models() -> dict[str, MaterialModel]:
    """Return all registered models by name."""
    for module in ("classical", "fractional"):
        import_module(f"restitution.material.{module}")  # registers its models
    # In this order whichever module was imported first.
    return {model.name: model for model in sorted(_MODELS.values(), key=attrgetter("needs_window"))}


def register(
    build: Callable[..., Any],
    constants: dict[str, Constant],
    one_of: tuple[tuple[str, ...], ...],
    *,
    needs_window: bool = False,
) -> None:
    """Add a model under the name of its function."""
    particular = {name: constant for name, constant in constants.items() if name not in _SHARED}
    _MODELS[build.__name__] = MaterialModel(build.__name__, build, particular, one_of, needs_window)


def material_model(*one_of: tuple[str, ...]) -> Callable[[Callable[_P, _T]], Callable[_P, _T]]:
    """Register a function as a material model, and check its arguments before each call.

    Its parameters must be annotated as ``Annotated[float, quantity]``. From each group of names in `one_of` exactly
    one must be given.
    """

    def decorate(function: Callable[_P, _T]) -> Callable[_P, _T]:
        build = checked(function, one_of)
        register(build, constants_of(function), one_of)
        return build

    return decorate


def constants_of(function: Callable[..., Any]) -> dict[str, Constant]:
    """Return parameters of a function that are annotated with a quantity."""
    hints = get_type_hints(function, include_extras=True)
    constants: dict[str, Constant] = {}
    for name, parameter in inspect.signature(function).parameters.items():
        for hint in (hints[name], *get_args(hints[name])):
            if get_origin(hint) is Annotated:
                kind, quantity = get_args(hint)[:2]
                required = parameter.default is parameter.empty
                constants[name] = Constant(name, quantity, kind not in (float, Numeric, float | None), required)
    return constants


def checked(
    function: Callable[_P, _T], one_of: Sequence[tuple[str, ...]] = (), *, single: bool = False
) -> Callable[_P, _T]:
    """Return the function that converts its arguments to SI and checks their ranges before the call.

    Arrays must broadcast against each other; with `single`, only lists of numbers may be arrays.
    """
    signature, constants = inspect.signature(function), constants_of(function)

    @wraps(function)
    def call(*args: _P.args, **kwargs: _P.kwargs) -> _T:
        try:
            bound = signature.bind(*args, **kwargs)
        except TypeError as error:
            raise TypeError(
                f"{function.__name__}() {error}; its arguments are {', '.join(signature.parameters)}"
            ) from None
        numbers = {name: bound.arguments[name] for name in constants if name in bound.arguments}
        numbers, axes = aligned(numbers, [name for name in numbers if constants[name].is_list])
        values = bound.arguments
        values |= numbers
        for name, constant in constants.items():
            if values.get(name) is not None or (constant.required and name in values):
                number = constant.quantity.check(values[name], name)
                values[name] = number
                if single and not constant.is_list:
                    single_number(name, number, constant.quantity.unit)
        common_shape({name: np.shape(values[name]) for name in constants
                             if not constants[name].is_list and values.get(name) is not None})  # fmt: skip
        for group in one_of:
            exactly_one(**{name: values.get(name) for name in group})
        result = function(*bound.args, **bound.kwargs)
        return result if axes is None else named(result, axes)

    return call


def exactly_one(**values: Any) -> None:
    """Refuse values unless exactly one of them is given."""
    present = [name for name, value in values.items() if value is not None]
    if len(present) != 1:
        names = ", ".join(values)
        count = f"{' and '.join(present)} are given" if present else "none is given"
        raise InputError(names, rule=f"exactly one must be given; {count}")
