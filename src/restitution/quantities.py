"""Registry of all physical quantities: name, unit, words, symbol and admissible range; their labels."""

from __future__ import annotations

import inspect
import math
import re
from collections import ChainMap
from collections.abc import Callable, Collection, Container, Iterable, Mapping
from difflib import get_close_matches
from functools import lru_cache, partial
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from restitution import checks
from restitution.checks import Array, Numeric
from restitution.errors import InputError, InputTypeError
from restitution.units import (
    ACCELERATION,
    ANGLE,
    ANGULAR_FREQUENCY,
    DENSITY,
    ENERGY,
    FORCE,
    FREQUENCY,
    IMPEDANCE,
    LENGTH,
    MASS,
    MODULUS,
    MOLAR_ENERGY,
    NUMBER,
    PRESSURE,
    STIFFNESS,
    SURFACE_ENERGY,
    TEMPERATURE,
    TEMPERATURE_DIFFERENCE,
    TIME,
    VELOCITY,
    VISCOSITY,
    Dimension,
    ScaledUnit,
    scaled_unit,
)

if TYPE_CHECKING:
    import xarray


@lru_cache(maxsize=256)
def _parameters(function: Callable[..., Any]) -> tuple[str, ...]:
    return tuple(inspect.signature(function).parameters)


class Quantity(NamedTuple):
    """A physical quantity.

    Attributes
    ----------
    name : str
        Name in Python, in case files and in results.
    dimension : Dimension
        What it measures, with the SI unit.
    words, symbol : str
        Description, and symbol in the mathematical notation of matplotlib.
    low, high : float
        Ends of the admissible range.
    open : bool
        Whether the ends themselves are excluded. An infinite end is excluded, unless `infinite`.
    infinite : bool
        Whether the quantity may be infinite.
    derive : callable, optional
        Function that computes an output from others. The names of its parameters are those of outputs, or `mass`,
        `velocity`, `external_force` and `impedance`; their values are numbers or arrays in SI.
    """

    name: str
    dimension: Dimension
    words: str
    symbol: str = ""
    low: float = -math.inf
    high: float = math.inf
    open: bool = False
    infinite: bool = False
    derive: Callable[..., Any] | None = None

    @property
    def unit(self) -> str:
        """SI unit; empty for a plain number."""
        return self.dimension.unit

    @property
    def attributes(self) -> dict[str, str]:
        """Attributes of an array of it, by which CF readers know it."""
        return {"units": self.unit or "1", "long_name": self.words, "symbol": self.symbol}

    def label(self, unit: str) -> str:
        r"""Label of an axis: words, symbol and a unit.

        Examples
        --------
        >>> HISTORY["contact_radius"].label("mm")
        'contact radius $a$ [mm]'
        >>> print(INPUTS["density"].label("kg/m^3"))
        density $\rho$ [kg/m$^{3}$]
        """
        return _label(self.words, self.symbol, unit)

    @property
    def sources(self) -> tuple[str, ...]:
        """Names of the columns that `derive` takes."""
        return () if self.derive is None else _parameters(self.derive)

    def check(self, value: Any, field: str = "") -> Numeric:
        """Return values, perhaps with a unit, as a float or a read-only array in SI; messages name them `field`."""
        # Most values: plain numbers well within the range, zero, or infinite where that may be.
        if type(value) is float and (
            self.low < value < self.high
            or (value == self.low == 0.0 and not self.open)
            or (value == math.inf and self.infinite)
        ):
            return value
        if (
            type(value) is np.ndarray
            and value.dtype == np.float64
            and value.ndim
            and ((value > self.low) & (value < self.high)).all()
        ):
            array = value.copy()
            array.setflags(write=False)
            return array
        name, unit = field or self.name, self.unit
        return checks.in_range(name, value, unit, self.low, self.high, is_open=self.open, infinite=self.infinite)


_positive = partial(Quantity, low=0.0, open=True)
_nonnegative = partial(Quantity, low=0.0)


def _by_name(*quantities: Quantity) -> dict[str, Quantity]:
    return {quantity.name: quantity for quantity in quantities}


def _energy_residual(
    kinetic_energy_in: Any, kinetic_energy_out: Any, dissipated_energy: Any, stored_energy: Any, radiated_energy: Any,
    external_force: Any, residual_indentation_depth: Any,
) -> Any:  # fmt: skip
    work = external_force * residual_indentation_depth
    spent = kinetic_energy_out + dissipated_energy + stored_energy + radiated_energy
    return (spent - kinetic_energy_in - work) / kinetic_energy_in


ADHESION_INPUTS = _by_name(
    _positive("work", SURFACE_ENERGY, "work of adhesion", r"$w$"),
    _positive("stress", PRESSURE, "stress of the attraction", r"$\sigma_0$"),
    _positive("range", LENGTH, "range of the attraction", r"$h_0$"),
)
"""Numbers of the adhesion of two surfaces."""

INPUTS = _by_name(
    _positive("velocity", VELOCITY, "impact velocity", r"$v_0$"),
    _positive("drop_height", LENGTH, "height of the fall", r"$H$"),
    _positive("gravity", ACCELERATION, "acceleration of gravity", r"$g$"),
    _positive("mass", MASS, "mass", r"$m$"),
    _positive("density", DENSITY, "density", r"$\rho$"),
    _positive("radius", LENGTH, "radius", r"$R$"),
    *(_positive(f"radius_{n}", LENGTH, "principal radius of curvature of the gap", f"$R_{n}$") for n in (1, 2)),
    _positive("face_radius", LENGTH, "radius of the flat face", r"$b$"),
    _positive("thickness", LENGTH, "thickness of the layer", r"$h$"),
    _nonnegative("external_force", FORCE, "constant external force", r"$F_0$"),
    _positive("impedance", IMPEDANCE, "mechanical impedance of the target", r"$Z$", infinite=True),
    Quantity("half_angle", ANGLE, "half angle of the cone", r"$\alpha$", 0.0, math.pi / 2, open=True),
    Quantity("face_angle", ANGLE, "angle from the axis to a face", r"$\alpha_f$", 0.0, math.pi / 2, open=True),
    _positive("temperature", TEMPERATURE, "temperature", r"$\theta$"),  # T is the contact time
    Quantity("poisson_ratio", NUMBER, "static Poisson ratio", r"$\nu$", -1.0, 0.5),
    Quantity("bulk_modulus", MODULUS, "bulk modulus", r"$K$", 0.0, infinite=True),
    _nonnegative("equilibrium_modulus", MODULUS, "equilibrium shear modulus", r"$G_\infty$"),
    _positive("instantaneous_modulus", MODULUS, "instantaneous shear modulus", r"$G_0$"),
    _positive("branch_modulus", MODULUS, "shear modulus of the branch", r"$G_1$"),
    _positive("viscosity", VISCOSITY, "shear viscosity of the branch", r"$\eta$"),
    _positive("relaxation_time", TIME, "relaxation time of the branch", r"$\tau$"),
    _nonnegative("branch_moduli", MODULUS, "shear modulus of a branch", r"$G_k$"),
    _positive("relaxation_times", TIME, "relaxation time of a branch", r"$\tau_k$"),
    _positive("p2", NUMBER, "equilibrium over branch modulus", r"$p_2$"),
    _positive("p3", NUMBER, "dimensionless viscosity", r"$p_3$"),
    _nonnegative("friction", NUMBER, "coefficient of friction", r"$\mu$", infinite=True),
    Quantity("tangential_velocity", VELOCITY, "tangential velocity of the centre", r"$v_x$"),
    Quantity("spin", ANGULAR_FREQUENCY, "spin", r"$\omega$"),
    _positive("gyration", NUMBER, "moment of inertia over m R^2", r"$\kappa$"),
    Quantity(
        "angle", ANGLE, "angle of incidence from the normal", r"$\alpha_0$", -math.pi / 2, math.pi / 2, open=True
    ),
    _positive("speed", VELOCITY, "speed of the centre", r"$u_0$"),
    *ADHESION_INPUTS.values(),
)
"""Quantities that an axis of a sweep may set by name; a builder or a case file may have further ones."""

CONSTANTS = _by_name(
    _positive("shear_modulus", MODULUS, "shear modulus", r"$G$"),
    _positive("youngs_modulus", MODULUS, "Young's modulus", r"$E$"),
    _positive("maxwell_modulus", MODULUS, "shear modulus of the Maxwell part", r"$G_\mathrm{M}$"),
    _positive("maxwell_viscosity", VISCOSITY, "viscosity of the Maxwell part", r"$\eta_\mathrm{M}$"),
    _positive("kelvin_modulus", MODULUS, "shear modulus of the Kelvin-Voigt part", r"$G_\mathrm{K}$"),
    _positive("kelvin_viscosity", VISCOSITY, "viscosity of the Kelvin-Voigt part", r"$\eta_\mathrm{K}$"),
    _nonnegative("bulk_viscosity", VISCOSITY, "viscosity in bulk", r"$\zeta$"),
    _nonnegative("parallel_viscosity", VISCOSITY, "viscosity of a parallel dashpot", r"$\eta$"),
    _positive("coefficient", NUMBER, "coefficient of the springpot in Pa s^exponent", r"$V$"),
    Quantity("exponent", NUMBER, "exponent of the springpot", r"$\alpha$", 0.01, 0.99),
    Quantity("approximation_rtol", NUMBER, "relative error of the Prony series", "", 1e-10, 0.1),
)
"""Further constants of material models."""

SOLVER_RTOL = Quantity("rtol", NUMBER, "relative error of the restitution coefficient", "", 1e-12, 1e-2)
"""Tolerance of the exact method."""

ALIASES = {"nu": "poisson_ratio", "p1": "poisson_ratio"}

OUTPUTS = _by_name(
    _nonnegative("restitution_coefficient", NUMBER, "restitution coefficient", r"$e$"),
    _nonnegative("contact_time", TIME, "contact time", r"$T$"),
    _nonnegative("max_indentation_depth", LENGTH, "largest indentation depth", r"$d_\mathrm{max}$"),
    _nonnegative("max_force", FORCE, "largest normal force", r"$F_\mathrm{max}$"),
    _nonnegative("max_contact_radius", LENGTH, "largest contact radius", r"$a_\mathrm{max}$"),
    Quantity("max_pressure", PRESSURE, "largest contact pressure", r"$p_\mathrm{max}$", 0.0, infinite=True),
    Quantity("residual_indentation_depth", LENGTH, "indentation depth at separation", r"$d_\mathrm{end}$"),
    _nonnegative(
        "rebound_velocity", VELOCITY, "rebound velocity", r"$v_\mathrm{end}$",
        derive=lambda restitution_coefficient, velocity: restitution_coefficient * velocity,
    ),
    _nonnegative(
        "kinetic_energy_in", ENERGY, "kinetic energy before", r"$E_0$",
        derive=lambda mass, velocity: 0.5 * mass * velocity * velocity,
    ),
    _nonnegative(
        "kinetic_energy_out", ENERGY, "kinetic energy after", r"$E_\mathrm{end}$",
        derive=lambda kinetic_energy_in, restitution_coefficient: kinetic_energy_in * restitution_coefficient**2,
    ),
    _nonnegative("dissipated_energy", ENERGY, "energy dissipated", r"$E_\mathrm{d}$"),
    _nonnegative("stored_energy", ENERGY, "energy still stored", r"$E_\mathrm{s}$"),
    _nonnegative("radiated_energy", ENERGY, "energy carried away by waves", r"$E_\mathrm{r}$"),
    Quantity("energy_residual", NUMBER, "residual of the energy balance", r"$r$", derive=_energy_residual),
)  # fmt: skip
"""Outputs of an impact. An entry with `derive` follows from those before it."""

OBLIQUE = _by_name(
    Quantity("tangential_restitution_coefficient", NUMBER, "tangential restitution coefficient", r"$e_t$", -1.0, 1.0),
    Quantity("rebound_tangential_velocity", VELOCITY, "tangential velocity of the centre after", r"$v_x'$"),
    Quantity("rebound_spin", ANGULAR_FREQUENCY, "spin after", r"$\omega'$"),
    Quantity("rebound_angle", ANGLE, "angle of the rebound from the normal", r"$\alpha'$"),
    Quantity("impulse_ratio", NUMBER, "tangential over normal impulse", r"$J_x/J_z$"),
    _nonnegative("stick_time", TIME, "time in which some of the contact sticks", r"$T_\mathrm{stick}$"),
    _nonnegative("slip_time", TIME, "time in which all of the contact slides", r"$T_\mathrm{slip}$"),
    _nonnegative("tangential_energy_in", ENERGY, "energy of the contact point before", r"$E_{x0}$"),
    _nonnegative("tangential_energy_out", ENERGY, "energy of the contact point after", r"$E_x'$"),
    _nonnegative("friction_energy", ENERGY, "energy lost by friction", r"$E_\mu$"),
    _nonnegative(
        "tangential_dissipated_energy", ENERGY, "energy dissipated by tangential loads", r"$E_{x\mathrm{d}}$"
    ),
    _nonnegative("tangential_stored_energy", ENERGY, "energy stored by tangential loads", r"$E_{x\mathrm{s}}$"),
    Quantity("tangential_energy_residual", NUMBER, "residual of the tangential energy balance", r"$r_x$"),
    _nonnegative("tangential_error", NUMBER, "estimate of the error of e_t", r"$\Delta e_t$"),
    _nonnegative("tangential_split_error", NUMBER, "estimate of the error of the parts over E_x0", r"$\Delta E_x$"),
)
"""Outputs of an impact with friction, besides those that friction does not change."""

ADHESION = _by_name(
    _nonnegative("pull_off_force", FORCE, "largest pull", r"$F_\mathrm{pull}$"),
    _nonnegative("touching_time", TIME, "time from the first to the last touch", r"$T_a$"),
    _nonnegative("zone_width", LENGTH, "width of the attracted ring", r"$c - a$"),
)
"""Outputs of an adhesive impact, besides those of all impacts."""

IMPACT_OUTPUTS: Mapping[str, Quantity] = ChainMap(ADHESION, OBLIQUE, OUTPUTS)
"""All outputs of an impact."""

VALIDITY = _by_name(
    _nonnegative(
        "strain_number", NUMBER, "contact radius over R, or depth over contact radius or thickness", r"$a/R$"
    ),
    _nonnegative("contact_size_ratio", NUMBER, "contact radius over size of the target", r"$a/h$"),
    _nonnegative("mach_number", NUMBER, "velocity over shear wave speed", r"$v_0/c$"),
    Quantity("radiated_energy_ratio", NUMBER, "share of energy in waves", r"$E_\mathrm{w}/E_0$", 0.0, 1.0),
    _nonnegative("window_ratio", NUMBER, "contact beyond the window of the material", r"$w$"),
    Quantity("instantaneous_poisson_ratio", NUMBER, "instantaneous Poisson ratio", r"$\nu_0$", -1.0, 0.5),
    _nonnegative("mean_density", DENSITY, "density of a ball of this mass and radius", r"$\bar\rho$"),
    _nonnegative("layer_strain", NUMBER, "indentation depth over thickness of the layer", r"$d/h$"),
    _nonnegative("coupling_number", NUMBER, "Dundurs' parameter over friction", r"$\beta/\mu$"),
    _nonnegative("travel_number", NUMBER, "way along the surface over contact radius", r"$v_x T/a$"),
    _nonnegative("maugis_number", NUMBER, "Maugis' parameter of the body at rest", r"$\lambda_\infty$", infinite=True),
    _nonnegative("instantaneous_maugis_number", NUMBER, "Maugis' parameter at once", r"$\lambda_0$"),
    _nonnegative("zone_slope", NUMBER, "range over width of the attracted ring", r"$h_0/(c - a)$"),
    _positive("attraction_range", LENGTH, "range of the attraction", r"$h_0$"),
    _nonnegative("range_ratio", NUMBER, "range of the attraction over depth", r"$h_0/d$"),
    _nonnegative(
        "undetermined_constants", NUMBER, "constants that data do not determine: 1 some, 2 the scale", r"$n$"
    ),
)
"""Numbers of an impact for the assumptions of the theory; see `restitution.validity`."""

SWEEP_OUTPUTS: Mapping[str, Quantity] = ChainMap(VALIDITY, ADHESION, OBLIQUE, OUTPUTS)
"""Outputs that a sweep can compute: those of an impact, then those of its validity."""

DEFAULT_OUTPUTS = ("restitution_coefficient", "contact_time", "max_indentation_depth", "max_force")
"""Outputs of a sweep that names none."""

ENERGIES = ("dissipated_energy", "stored_energy", "radiated_energy")
"""Outputs that take a quadrature over the whole contact."""

BUDGET = ("kinetic_energy_in", "kinetic_energy_out", *ENERGIES, "energy_residual")
"""Outputs of the energy budget."""

BODY = ("mass", "velocity", "external_force", "impedance")
"""Inputs that a derived output may take."""

SLIDING = ("friction", "tangential_velocity", "spin", "gyration")
"""Inputs of the tangential motion of an impact."""

STATUS = "status"
NOT_COMPUTED = -1
"""Name of the variable with the status of each impact, and its value where nothing is computed yet."""

HISTORY = _by_name(
    _nonnegative("time", TIME, "time since first touch", r"$t$"),
    Quantity("indentation_depth", LENGTH, "indentation depth", r"$d$"),
    Quantity("indentation_velocity", VELOCITY, "indentation velocity", r"$v$"),
    _nonnegative("force", FORCE, "normal force", r"$F$"),
    _nonnegative("contact_radius", LENGTH, "contact radius", r"$a$"),
    _nonnegative("kinetic_energy", ENERGY, "kinetic energy of the body", r"$E_\mathrm{kin}$"),
    _nonnegative("stored_energy", ENERGY, "energy in the springs of the foundation", r"$E_\mathrm{s}$"),
    _nonnegative("dissipated_energy", ENERGY, "energy dissipated in the foundation", r"$E_\mathrm{d}$"),
    _nonnegative("radiated_energy", ENERGY, "energy that the target carries away", r"$E_\mathrm{r}$"),
    Quantity("body_velocity", VELOCITY, "velocity of the body", r"$v$"),
    Quantity("target_displacement", LENGTH, "displacement of the target", r"$w$"),
    Quantity("contact_point_velocity", VELOCITY, "tangential velocity of the contact point", r"$v_c$"),
    Quantity("tangential_force", FORCE, "tangential force", r"$F_x$"),
    _nonnegative("stick_radius", LENGTH, "radius that sticks", r"$c$"),
    _nonnegative("slip_velocity", VELOCITY, "largest velocity of slip", r"$v_\mathrm{slip}$"),
    _nonnegative("zone_radius", LENGTH, "radius of the attraction", r"$c$"),
    _nonnegative("jump_energy", ENERGY, "energy lost in jumps", r"$E_\mathrm{j}$"),
)
"""Columns of a history over time."""

ATTRACTION_TIME = HISTORY["time"]._replace(words="time since the first attraction")
"""Time of a history with adhesion."""

BOUNCES = _by_name(
    _nonnegative("touch_time", TIME, "time of touch", r"$t$"),
    _positive("interval", TIME, "time to the next touch", r"$D$"),
    _nonnegative("height", LENGTH, "height reached after the bounce", r"$h$"),
    Quantity("place", LENGTH, "place of the touch, from that of the release", r"$x$"),
)
"""Columns of a series of bounces, besides the outputs of its impacts."""

MODULI = _by_name(
    _positive("angular_frequency", ANGULAR_FREQUENCY, "angular frequency", r"$\omega$"),
    _positive("storage_modulus", MODULUS, "storage modulus", r"$E'$"),
    _nonnegative("loss_modulus", MODULUS, "loss modulus", r"$E''$"),
    _nonnegative("loss_tangent", NUMBER, "loss tangent", r"$\tan\delta$"),
    _positive("absolute_modulus", MODULUS, "magnitude of the complex modulus", r"$|E^*|$"),
)
"""Complex moduli over frequency, and the quantities that derive from them."""


CONTACT_TANGENT = MODULI["loss_tangent"]._replace(words="loss tangent at pi over the contact time")
"""Loss tangent that belongs to an impact."""

INDENTATION = _by_name(
    OUTPUTS["max_force"]._replace(words="largest force"),
    OUTPUTS["max_indentation_depth"],
    OUTPUTS["max_contact_radius"],
    _nonnegative("turning_time", TIME, "contact grows until", r"$t_\mathrm{m}$"),
    _nonnegative("contact_end_time", TIME, "contact ends at", r"$t_\mathrm{end}$"),
    OUTPUTS["residual_indentation_depth"]._replace(words="depth at the end of contact"),
    Quantity("work", ENERGY, "work of the indenter", r"$W$"),
    Quantity("dissipated", ENERGY, "energy dissipated until the end", r"$E_\mathrm{d}$"),
    _nonnegative("stored", ENERGY, "energy left in the material at the end", r"$E_\mathrm{s}$"),
)
"""Outputs of an indentation."""

SHIFTS = _by_name(
    _positive("c1", NUMBER, "first WLF constant", r"$C_1$"),
    _positive("c2", TEMPERATURE_DIFFERENCE, "second WLF constant", r"$C_2$"),
    _positive("activation_energy", MOLAR_ENERGY, "activation energy", r"$Q$"),
)
"""Constants of the laws of the time-temperature shift."""

MEASURED = MODULI | _by_name(
    *(INPUTS[name] for name in ("velocity", "radius", "mass", "external_force", "temperature")),
    *(OUTPUTS[name] for name in ("restitution_coefficient", "contact_time", "max_force", "rebound_velocity")),
    INPUTS["drop_height"],
    _positive("rebound_height", LENGTH, "height of the rebound", r"$h$"),
    *(BOUNCES[name] for name in ("touch_time", "interval")),
    Quantity("time", TIME, "time", r"$t$"),
    Quantity("force", FORCE, "normal force", r"$F$"),
    Quantity("depth", LENGTH, "depth", r"$d$"),
    Quantity("acceleration", ACCELERATION, "deceleration"),
    _positive("modulus", MODULUS, "relaxation modulus"),
    _positive("frequency", FREQUENCY, "frequency", r"$f$"),
    _positive("depth_amplitude", LENGTH, "amplitude of the depth", r"$d_1$"),
    _positive("force_amplitude", FORCE, "amplitude of the force", r"$F_1$"),
    Quantity("phase", ANGLE, "phase of the force to the depth", r"$\delta$"),
    _positive("storage_stiffness", STIFFNESS, "storage stiffness", r"$k'$"),
    Quantity("loss_stiffness", STIFFNESS, "loss stiffness", r"$k''$"),
    _positive("mean_force", FORCE, "mean force", r"$F_0$"),
)
"""Columns of measured data."""


def register_output(output: Quantity) -> None:
    """Add an output that is derived from others; results, sweeps, pictures and exports then have it.

    Parameters
    ----------
    output : Quantity
        With `derive`.

    Raises
    ------
    InputError
        If the name is taken, or `derive` takes a column that does not exist.

    Examples
    --------
    >>> deceleration = Quantity(
    ...     "max_deceleration", ACCELERATION, "largest deceleration", derive=lambda max_force, mass: max_force / mass
    ... )
    >>> register_output(deceleration)
    >>> derived({"max_force": 6.0, "mass": 2.0})["max_deceleration"]
    3.0
    >>> del OUTPUTS["max_deceleration"]
    """
    if output.name in (*SWEEP_OUTPUTS, *INPUTS, STATUS):
        raise InputError("name", output.name, "must differ from the names of other quantities")
    if output.derive is None:
        raise InputError("derive", rule="must be a function of other outputs")
    for name in output.sources:
        choice("derive", name, (*OUTPUTS, *BODY))
    OUTPUTS[output.name] = output


def derived(columns: Mapping[str, Any]) -> dict[str, Any]:
    """Return columns of outputs and of `BODY` with all outputs that follow from them and are not there yet."""
    outputs = dict(columns)
    # A row that failed is NaN, or too large to be squared.
    with np.errstate(all="ignore"):
        for name, output in OUTPUTS.items():
            if output.derive is None or name in outputs:
                continue
            if outputs.keys() >= {*(sources := _parameters(output.derive))}:
                outputs[name] = output.derive(**{source: outputs[source] for source in sources})
    return outputs


def needs(outputs: Iterable[str], names: Container[str]) -> bool:
    """Return whether outputs, or those that they derive from, are among some."""
    return any(name in names or (name in OUTPUTS and needs(OUTPUTS[name].sources, names)) for name in outputs)


def dataset(dimension: str, columns: Mapping[str, tuple[Any, Quantity]], attributes: dict[str, Any]) -> xarray.Dataset:
    """Return columns of values and their quantity as a Dataset over the column `dimension`."""
    import xarray as xr

    data = {name: (dimension, values, quantity.attributes) for name, (values, quantity) in columns.items()}
    return xr.Dataset(data, attrs=attributes).set_coords(dimension)


def key_of(name: str) -> str:
    """Return the quantity in which a name ends, such as that of a key of a case file or of an entry of a list."""
    return name.partition("[")[0].rpartition(".")[2]


def input_attributes(name: str) -> dict[str, str]:
    """Return the attributes of a quantity along an axis; one that is not known has no unit."""
    quantity, place = INPUTS.get(key_of(name)), name.partition("[")[2]
    if quantity is None:
        return {"units": "", "long_name": name.replace("_", " "), "symbol": ""}
    return quantity.attributes | {"long_name": f"{quantity.words} {place.rstrip(']')}".rstrip()}


def checked_outputs(names: Any, registry: Collection[str] = SWEEP_OUTPUTS) -> tuple[str, ...]:
    """Return names of outputs in the order of the registry, refusing those that are not known."""
    listed = [names] if isinstance(names, str) else checks.items("outputs", names, "must be a sequence of names")
    chosen = [choice("outputs", name, registry) for name in listed]
    if not chosen:
        raise InputError("outputs", rule="must name at least one output")
    return tuple(name for name in registry if name in chosen)


def check(name: str, value: Any, field: str = "") -> Numeric:
    """Return the values of an input in SI, refusing those outside its range; see `Quantity.check`.

    Examples
    --------
    >>> check("velocity", [0.5, 1.0]).tolist()
    [0.5, 1.0]
    >>> check("poisson_ratio", 0.6)
    Traceback (most recent call last):
        ...
    restitution.errors.InputError: poisson_ratio = 0.6: must be in [-1, 0.5]
    """
    return (INPUTS.get(name) or CONSTANTS[name]).check(value, field)


def check_single(name: str, value: Any, field: str = "") -> float:
    """Return one value of an input in SI, refusing arrays and values outside its range.

    Examples
    --------
    >>> check_single("gravity", 9.81)
    9.81
    """
    return checks.single(field or name, check(name, value, field), (INPUTS.get(name) or CONSTANTS[name]).unit)


# Letters of a name that stand for all names that contain them, and the most names of an advice.
_SHORTEST_PART, _MOST_ADVISED = 3, 4


def advice(name: str, choices: Iterable[str]) -> str:
    """Return the nearest of the choices as a question, or else all of them.

    Examples
    --------
    >>> advice("din53512", ["ISO 4662", "DIN 53512"])
    'did you mean DIN 53512?'
    >>> advice("lammps", ["lammps-a", "lammps-b", "yade"])
    'did you mean lammps-a or lammps-b?'
    """
    names = list(choices)
    plain = {word: _letters(word) for word in names}
    part = _letters(str(name))
    close = [word for word in names if len(part) >= _SHORTEST_PART and part in plain[word]]
    if not 0 < len(close) <= _MOST_ADVISED:
        nearest = get_close_matches(part, plain.values(), 1)
        close = [word for word in names if plain[word] in nearest][:1]
    *others, last = close or [""]
    choice = f"{', '.join(others)} or {last}" if others else last
    return f"did you mean {choice}?" if last else f"known are {', '.join(names)}"


def _letters(name: str) -> str:
    """Return a name without its spaces, signs and capitals."""
    return re.sub(r"[\W_]+", "", name).casefold()


def choice(field: str, name: Any, choices: Iterable[str]) -> str:
    """Return a name if it is one of the choices; refuse it otherwise, and advise the nearest one."""
    names = list(choices)
    if not isinstance(name, str):
        raise InputTypeError(field, name, f"must be a name; known are {', '.join(names)}")
    if name in names:
        return name
    raise InputError(field, name, f"is not known; {advice(name, names)}")


# Labels of axes and columns.

RESTITUTION = "restitution_coefficient"

# Values that span more than this have a logarithmic axis, except the restitution coefficient, which ends at 1.
_LOG_SPAN = 30.0

# An axis that spans more than this has no prefix: "1e-6 to 1 MPa s" would be hard to read.
_PREFIX_SPAN = 2000.0


def _label(words: str, symbol: str, unit: str) -> str:
    return " ".join(filter(None, (words, symbol, f"[{_raised(unit)}]" if unit else "")))


def _raised(unit: str) -> str:
    """Return a unit for a picture, with its powers as superscripts."""
    return re.sub(r"\^(-?\d+)", r"$^{\1}$", unit)


class Values(NamedTuple):
    """A variable in a suitable unit, NaN where it is not finite.

    The label has words, symbol and unit; the short label is the symbol, or the words if there is none.
    """

    values: Array
    label: str
    short: str
    unit: str
    logarithmic: bool

    @property
    def scale(self) -> str:
        """Matplotlib's name of the scale of its axis."""
        return "log" if self.logarithmic else "linear"

    def value_label(self, place: int) -> str:
        """Return one of its values with symbol and unit, for a legend or a title."""
        if np.isnan(self.values[place]):
            # The only value of an axis that is not finite is the bulk modulus of an incompressible material.
            return rf"{self.short} = $\infty$"
        number = f"{self.short} = {self.values[place]:.4g}"
        return f"{number} {_raised(self.unit)}" if self.unit else number


def scaled(variable: xarray.DataArray) -> Values:
    """Return a variable of a Dataset in a suitable unit, with the words and the symbol of its attributes.

    Examples
    --------
    >>> import xarray as xr
    >>> scaled(xr.DataArray([0.01, 0.02], attrs=INPUTS["radius"].attributes)).label
    'radius $R$ [mm]'
    """
    values = np.asarray(variable.values, dtype=np.float64)
    values = np.where(np.isfinite(values), values, np.nan)
    si = variable.attrs.get("units", "1")
    si = "" if si == "1" else si
    logarithmic = _is_logarithmic(variable, values)
    positive = np.abs(values[np.isfinite(values) & (values != 0.0)])
    wide = logarithmic and positive.size > 0 and positive.max() > _PREFIX_SPAN * positive.min()
    factor, unit = ScaledUnit(1.0, si) if wide else scaled_unit(values, si)
    words = str(variable.attrs.get("long_name", variable.name))
    symbol = str(variable.attrs.get("symbol", ""))
    return Values(values * factor, _label(words, symbol, unit), symbol or words, unit, logarithmic)


def _is_logarithmic(variable: xarray.DataArray, values: Array) -> bool:
    scale = variable.attrs.get("scale")
    if scale in ("linear", "logarithmic"):
        return scale == "logarithmic"
    finite = values[np.isfinite(values)]
    if variable.name == RESTITUTION or finite.size == 0 or finite.min() <= 0.0:
        return False
    return bool(finite.max() > _LOG_SPAN * finite.min())
