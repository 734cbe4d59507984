"""Parameters of a model of the material: names, logarithms, bounds and priors, and the way to columns of materials."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any, Literal, NamedTuple

import numpy as np
from numpy.typing import NDArray

from restitution.errors import InputError
from restitution.material import models
from restitution.material.columns import MaterialColumns, PronyColumns
from restitution.material.conversion import bulk_factor
from restitution.material.fractional import FractionalMaterial
from restitution.material.shift import WLF, Arrhenius, Shift
from restitution.material.viscoelastic import Material
from restitution.quantities import (
    MODULUS,
    MOLAR_ENERGY,
    NUMBER,
    TEMPERATURE_DIFFERENCE,
    TIME,
    VISCOSITY,
    Quantity,
)
from restitution.sweeps.samples import LogNormal, Normal

Array = NDArray[np.float64]
Kind = Literal["log", "logit", "linear"]
Model = Callable[..., Material | FractionalMaterial]

LAWS: Mapping[str, Quantity] = {
    one.name: one
    for one in (
        Quantity("c1", NUMBER, "WLF constant", r"$C_1$", 0.0, open=True),
        Quantity("c2", TEMPERATURE_DIFFERENCE, "WLF constant", r"$C_2$", 0.0, open=True),
        Quantity("activation_energy", MOLAR_ENERGY, "activation energy", r"$Q$", 0.0, open=True),
    )
}
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

    @property
    def names(self) -> tuple[str, ...]:
        """Names of the unknowns."""
        return tuple(one.name for one in self.free)

    @cached_property
    def entry(self) -> models.MaterialModel | None:
        """Entry of the model in the registry."""
        return next((one for one in models.material_models().values() if one.build is self.model), None)

    def __getstate__(self) -> dict[str, Any]:
        state = {name: value for name, value in self.__dict__.items() if name != "entry"}
        # The functions of the fractional models have no name by which pickle finds them.
        return state | ({"model": self.entry.name} if self.entry is not None else {})

    def __setstate__(self, state: dict[str, Any]) -> None:
        model = state["model"]
        self.__dict__.update(
            state | {"model": models.material_models()[model].build if isinstance(model, str) else model}
        )

    def values(self, coordinates: Array) -> dict[str, Array]:
        """Values of the unknowns at coordinates of shape (m, p), shape (m,) each."""
        return {one.name: one.outward(coordinates[:, k]) for k, one in enumerate(self.free)}

    def arguments(self, coordinates: Array) -> dict[str, Any]:
        """All arguments, shape (m,) or (m, n_list) each; arguments that are no numbers unchanged."""
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
        """Materials at coordinates of shape (m, p); NaN if not admissible.

        Fractional models are valid within a window of times [s].
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
            if name in LAWS or name == "reference_temperature":
                continue
            one = value[row] if isinstance(value, np.ndarray) else value
            found[name] = float(one) if np.ndim(one) == 0 and isinstance(one, np.floating) else one
        return found

    def _law(self, coordinates: Array) -> Shift | None:
        if not isinstance(self.shift, type):
            return self.shift
        arguments = self.arguments(coordinates)
        names = ("reference_temperature", *law_constants(self.shift))
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
            raise InputError(f"start.{one.name}", wanted="must be given: the data do not give its size")
        begin = min(
            max(begin, one.low + 1e-9 * abs(one.low)), one.high * (1.0 - 1e-9) if one.high < math.inf else begin
        )
        z = float(one.inward(begin))
        if one.kind == "logit":
            reach = _EXPONENTS if one.argument == "exponent" else (-_LOGIT, _LOGIT)
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


def law_constants(shift: Any) -> tuple[str, ...]:
    if shift is WLF:
        return "c1", "c2"
    if shift is Arrhenius:
        return ("activation_energy",)
    raise InputError("shift", getattr(shift, "__name__", shift), "must be WLF, Arrhenius, or a shift with its numbers")
