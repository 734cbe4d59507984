"""Every variable of a sweep once: name, unit, words, symbol, and what an axis may take."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from difflib import get_close_matches
from typing import Any, NamedTuple

from restitution import checks as validation
from restitution.impact.status import Status
from restitution.quantities import VALIDITY


class Variable(NamedTuple):
    """A quantity of an impact; over the dimensions of a sweep it is an array.

    Attributes
    ----------
    name : str
        Its name in Python, in case files and in the result.
    unit : str
        SI unit, "1" for a plain number.
    long_name : str
        Words.
    symbol : str
        Symbol, in the mathematical notation of matplotlib.
    """

    name: str
    unit: str
    long_name: str
    symbol: str

    @property
    def attributes(self) -> dict[str, str]:
        """Attributes by which CF readers know it."""
        return {"units": self.unit, "long_name": self.long_name, "symbol": self.symbol}


class Input(NamedTuple):
    """A quantity that an axis may set, with the range that it must stay in.

    Attributes
    ----------
    variable : Variable
        What it is.
    low, high : float
        Ends of its range.
    check : callable
        Raises a ValueError that names the quantity for values out of range.
    """

    variable: Variable
    low: float
    high: float
    check: Callable[[str, Any, str], Any]

    def checked(self, values: Any) -> Any:
        """Return values as floats, refusing those out of range."""
        unit = self.variable.unit
        return self.check(self.variable.name, values, "" if unit == "1" else unit)


def _positive(name: str, unit: str, long_name: str, symbol: str) -> Input:
    return Input(Variable(name, unit, long_name, symbol), 0.0, float("inf"), validation.positive)


def _nonnegative(name: str, unit: str, long_name: str, symbol: str) -> Input:
    return Input(Variable(name, unit, long_name, symbol), 0.0, float("inf"), validation.nonnegative)


def _between(low: float, high: float, name: str, unit: str, long_name: str, symbol: str) -> Input:
    def check(name: str, values: Any, unit: str) -> Any:
        return validation.within(name, values, low, high, unit)

    return Input(Variable(name, unit, long_name, symbol), low, high, check)


INPUTS = {
    one.variable.name: one
    for one in (
        _positive("velocity", "m/s", "impact velocity", r"$v_0$"),
        _positive("drop_height", "m", "height of the fall", r"$h$"),
        _positive("gravity", "m/s^2", "acceleration of gravity", r"$g$"),
        _positive("mass", "kg", "mass", r"$m$"),
        _positive("density", "kg/m^3", "density of the body", r"$\rho$"),
        _positive("radius", "m", "radius", r"$R$"),
        _nonnegative("external_force", "N", "constant external force", r"$F_0$"),
        _positive("half_angle", "rad", "half angle of the cone", r"$\alpha$"),
        # T is the contact time, with which a picture may show it.
        _positive("temperature", "K", "temperature", r"$\theta$"),
        _between(-1.0, 0.5, "poisson_ratio", "1", "static Poisson ratio", r"$\nu$"),
        _between(0.0, float("inf"), "bulk_modulus", "Pa", "bulk modulus", r"$K$"),
        _nonnegative("equilibrium_modulus", "Pa", "shear modulus at equilibrium", r"$G_\infty$"),
        _positive("branch_modulus", "Pa", "shear modulus of the branch", r"$G_1$"),
        _positive("viscosity", "Pa s", "shear viscosity of the branch", r"$\eta$"),
        _positive("relaxation_time", "s", "relaxation time of the branch", r"$\tau$"),
        _nonnegative("branch_moduli", "Pa", "shear modulus of a branch", r"$G_k$"),
        _positive("relaxation_times", "s", "relaxation time of a branch", r"$\tau_k$"),
        _positive("p2", "1", "equilibrium over branch modulus", r"$p_2$"),
        _positive("p3", "1", "dimensionless viscosity", r"$p_3$"),
    )
}
"""What axes know by name; a builder or a case file may have further quantities."""

ALIASES = {"nu": "poisson_ratio", "p1": "poisson_ratio"}

OUTPUTS = {
    one.name: one
    for one in (
        Variable("restitution_coefficient", "1", "restitution coefficient", r"$e$"),
        Variable("contact_time", "s", "contact time", r"$T$"),
        Variable("max_indentation_depth", "m", "largest indentation depth", r"$d_\mathrm{max}$"),
        Variable("max_force", "N", "largest normal force", r"$F_\mathrm{max}$"),
        Variable("max_contact_radius", "m", "largest contact radius", r"$a_\mathrm{max}$"),
        Variable("residual_indentation_depth", "m", "indentation depth at separation", r"$d_\mathrm{end}$"),
        Variable("rebound_velocity", "m/s", "rebound velocity", r"$v_\mathrm{end}$"),
        Variable("kinetic_energy_in", "J", "kinetic energy before", r"$E_0$"),
        Variable("kinetic_energy_out", "J", "kinetic energy after", r"$E_\mathrm{end}$"),
        Variable("dissipated_energy", "J", "energy dissipated", r"$E_\mathrm{d}$"),
        Variable("stored_energy", "J", "energy still stored", r"$E_\mathrm{s}$"),
        Variable("energy_residual", "1", "residual of the energy balance", r"$r$"),
        *(Variable(one.name, one.unit or "1", one.words, one.symbol) for one in VALIDITY.values()),
    )
}
"""What a sweep can compute."""

DEFAULT_OUTPUTS = ("restitution_coefficient", "contact_time", "max_indentation_depth", "max_force")

ENERGY = ("kinetic_energy_in", "kinetic_energy_out", "dissipated_energy", "stored_energy", "energy_residual")
"""Outputs of the energy budget, which take a quadrature over the whole contact."""

STATUS = "status"
NOT_COMPUTED = -1
"""Status of impacts that are still to be computed."""


def status_attributes() -> dict[str, Any]:
    """Attributes of the variable `status`."""
    return {
        "long_name": "how the solve ended",
        "flag_values": [int(status) for status in Status],
        "flag_meanings": " ".join(status.name.lower() for status in Status),
    }


def input_variable(name: str) -> Variable:
    """Return the variable that an axis sets; of an unknown name, one without a unit."""
    key, _, place = name.partition("[")
    known = INPUTS.get(key.rpartition(".")[2])
    if known is None:
        return Variable(name, "", name.replace("_", " "), "")
    variable = known.variable
    words = f"{variable.long_name} {place.rstrip(']')}" if place else variable.long_name
    return variable._replace(name=name, long_name=words)


def checked_outputs(names: Iterable[str]) -> tuple[str, ...]:
    """Return the names of outputs in the order of the schema, refusing unknown ones."""
    if not isinstance(names, Iterable):  # pyright: ignore[reportUnnecessaryIsInstance]
        raise TypeError(f"outputs = {names!r}: must be a sequence of names")
    wanted = [names] if isinstance(names, str) else list(names)
    for name in wanted:
        if name not in OUTPUTS:
            close = get_close_matches(str(name), OUTPUTS, 1)
            advice = f"did you mean {close[0]}?" if close else f"known are {', '.join(OUTPUTS)}"
            raise ValueError(f"outputs: unknown output {name!r}; {advice}")
    if not wanted:
        raise ValueError("outputs: must name at least one output")
    return tuple(name for name in OUTPUTS if name in wanted)
