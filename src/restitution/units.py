"""Units: what quantities measure, texts such as "10 mm", prefixes, and systems of units."""

from __future__ import annotations

import math
import re
from collections.abc import Iterable
from difflib import get_close_matches
from functools import cache
from typing import Any, NamedTuple

from restitution.errors import ABSENT, InputError


class Powers(NamedTuple):
    """Powers of mass, length and time in the unit of a quantity."""

    mass: int = 0
    length: int = 0
    time: int = 0


class Dimension(NamedTuple):
    """What a quantity measures: its name, its SI unit (empty for a plain number), and how a person writes one.

    A unit system of mechanics also needs the powers of mass, length and time.
    """

    name: str
    unit: str
    example: str = ""
    powers: Powers = Powers()

    @property
    def article(self) -> str:
        """The name with its indefinite article."""
        return f"{'an' if self.name[0] in 'aeiou' else 'a'} {self.name}"

    @property
    def advice(self) -> str:
        """Advice on how to write one."""
        if not self.unit:
            return "write a plain number"
        return f'write e.g. "{self.example}", or a plain number in {self.unit}'


NUMBER = Dimension("dimensionless number", "")
LENGTH = Dimension("length", "m", "10 mm", Powers(length=1))
MASS = Dimension("mass", "kg", "5 g", Powers(mass=1))
TIME = Dimension("time", "s", "1 ms", Powers(time=1))
DENSITY = Dimension("density", "kg/m^3", "1100 kg/m^3", Powers(1, -3, 0))
VELOCITY = Dimension("velocity", "m/s", "1 m/s", Powers(0, 1, -1))
ACCELERATION = Dimension("acceleration", "m/s^2", "9.81 m/s^2", Powers(0, 1, -2))
FORCE = Dimension("force", "N", "50 mN", Powers(1, 1, -2))
IMPEDANCE = Dimension("mechanical impedance", "kg/s", "500 kg/s", Powers(1, 0, -1))
ENERGY = Dimension("energy", "J", "1 mJ", Powers(1, 2, -2))
MODULUS = Dimension("modulus", "Pa", "2 MPa", Powers(1, -1, -2))
PRESSURE = Dimension("pressure", "Pa", "2 MPa", Powers(1, -1, -2))
VISCOSITY = Dimension("viscosity", "Pa s", "1 kPa s", Powers(1, -1, -1))
ANGULAR_FREQUENCY = Dimension("angular frequency", "rad/s", "100 rad/s", Powers(time=-1))
ANGLE = Dimension("angle", "rad", "80 deg")
TEMPERATURE = Dimension("temperature", "K", "20 degC")
TEMPERATURE_DIFFERENCE = Dimension("difference of temperatures", "K", "50 K")
MOLAR_ENERGY = Dimension("energy per amount of substance", "J/mol", "80 kJ/mol")
FREQUENCY = Dimension("frequency", "1/s", "100 Hz", Powers(time=-1))
STIFFNESS = Dimension("stiffness", "N/m", "0.1 N/m", Powers(1, 0, -2))
COMPLIANCE = Dimension("compliance", "1/Pa", "1e-6 1/Pa", Powers(-1, 1, 2))
SURFACE_ENERGY = Dimension("energy per area", "J/m^2", "50 mJ/m^2", Powers(1, 0, -2))

_SHOWN = (
    NUMBER, LENGTH, MASS, TIME, DENSITY, VELOCITY, ACCELERATION, FORCE, IMPEDANCE, ENERGY, MODULUS, PRESSURE,
    VISCOSITY, ANGULAR_FREQUENCY, ANGLE, TEMPERATURE,
)  # fmt: skip
_WRITTEN = (
    # It precedes the angular frequency.
    FREQUENCY,
    # No key of a case file has these, but a person may write one by mistake.
    Dimension("area", "m^2"),
    Dimension("volume", "m^3"),
    Dimension("power", "W"),
    Dimension("kinematic viscosity", "m^2/s"),
    Dimension("electric charge", "C"),
    *_SHOWN,
    MOLAR_ENERGY,
    STIFFNESS,
)

ZERO_CELSIUS = 273.15
"""Zero of the scale of degrees Celsius [K]."""


# Prefixes.

_PREFIXES = {-18: "a", -15: "f", -12: "p", -9: "n", -6: "µ", -3: "m", 0: "", 3: "k", 6: "M", 9: "G", 12: "T"}


class ScaledUnit(NamedTuple):
    """A unit with its prefix, and the factor that takes SI values to it."""

    factor: float
    unit: str


def scaled_unit(values: Any, unit: str) -> ScaledUnit:
    """Return the prefixed unit in which the largest finite one of `values` lies in [1, 1000).

    A unit with an exponent, K, rad and the empty unit of a plain number have no prefix; masses are in g up to 1 kg.

    Examples
    --------
    >>> scaled_unit([0.0, -0.0032], "m")
    ScaledUnit(factor=1000.0, unit='mm')
    >>> scaled_unit(2.5e4, "N").unit
    'kN'
    """
    if unit in ("", "K", "rad") or "^" in unit:
        return ScaledUnit(1.0, unit)
    # The help of the command line must load nothing heavy.
    import numpy as np

    array = np.abs(np.asarray(values, dtype=np.float64))
    array = array[np.isfinite(array)]
    largest = float(array.max()) if array.size else 0.0
    if unit == "kg":
        if largest >= 1.0:
            return ScaledUnit(1.0, "kg")
        factor, prefixed = scaled_unit(largest * 1e3, "g")
        return ScaledUnit(1e3 * factor, prefixed)
    # The small addend prevents a smaller unit for 0.999999999999, a rounded one.
    power = 3 * int(np.floor((np.log10(largest) + 1e-9) / 3)) if largest > 0 else 0
    power = min(max(power, min(_PREFIXES)), max(_PREFIXES))
    return ScaledUnit(10.0**-power, _PREFIXES[power] + unit)


def in_words(value: float, unit: str) -> str:
    """Return a number with four digits and its prefixed unit.

    Examples
    --------
    >>> in_words(0.00123456, "s")
    '1.235 ms'
    """
    factor, prefixed = scaled_unit(value, unit)
    return f"{value * factor:.4g} {prefixed}".rstrip()


def with_error(value: float, deviation: float, unit: str = "") -> tuple[str, str]:
    """Return a number with its standard deviation, of two digits, as text, and the prefixed unit of both.

    Examples
    --------
    >>> with_error(0.78662, 0.01234), with_error(0.0012346, 1.24e-5, "s")
    (('0.787 +- 0.012', ''), ('1.235 +- 0.012', 'ms'))
    """
    factor, prefixed = scaled_unit([value, deviation], unit)
    number, spread = value * factor, deviation * factor
    if not (math.isfinite(number) and math.isfinite(spread)) or spread == 0.0:
        return f"{number:.6g} +- {spread:.2g}", prefixed
    digits = 1 - math.floor(math.log10(spread))
    # A deviation of 0.0996 has the digits of 0.10.
    digits = digits - 1 if round(spread, digits) >= 10.0 ** (2 - digits) else digits
    if not -6 < digits < 12:
        return f"{number:.8g} +- {spread:.2g}", prefixed
    return f"{round(number, digits):.{max(digits, 0)}f} +- {round(spread, digits):.{max(digits, 0)}f}", prefixed


def celsius(kelvin: float, digits: int = 6) -> str:
    """Return a temperature [K] as a number in °C, without the rounding of the difference.

    Examples
    --------
    >>> celsius(273.15), celsius(296.15), celsius(273.15 + 1e-13)
    ('0', '23', '0')
    """
    return f"{round(float(kelvin) - ZERO_CELSIUS, 9) + 0.0:.{digits}g}"


# Texts with a unit. Units that most files have need no pint, whose import and set-up take 0.4 s.


class Unit(NamedTuple):
    """Unit: SI value = (value + offset) factor/divisor. One of both is 1, so that the result is rounded once."""

    dimension: Dimension
    factor: float = 1.0
    divisor: float = 1.0
    offset: float = 0.0

    def si(self, values: Any) -> Any:
        """Return numbers in SI."""
        return (values + self.offset) * self.factor / self.divisor


def _powers(dimension: Dimension, **powers: int) -> dict[str, Unit]:
    """Return units that are powers of ten of the SI unit."""
    return {name: Unit(dimension, 10.0 ** max(n, 0), 10.0 ** max(-n, 0)) for name, n in powers.items()}


def _prefixed(dimension: Dimension, unit: str, high: int = 9, zero: int = 0) -> dict[str, Unit]:
    """Return a unit with each prefix up to one; `zero` is the power of ten of the unit itself."""
    prefixes = {prefix: power for power, prefix in _PREFIXES.items()} | {"u": -6}
    return _powers(dimension, **{p + unit: n + zero for p, n in prefixes.items() if -9 <= n <= high})


_UNITS = {
    **_prefixed(LENGTH, "m", high=3), **_powers(LENGTH, cm=-2),
    **_prefixed(MASS, "g", high=3, zero=-3),
    **_prefixed(TIME, "s", high=0), "min": Unit(TIME, 60.0), "h": Unit(TIME, 3600.0),
    **_prefixed(FORCE, "N"),
    **{name: unit for name, unit in _prefixed(MODULUS, "Pa").items() if name != "mPa"},
    **_prefixed(VISCOSITY, "Pa s"),
    **_powers(VELOCITY, **{"m/s": 0, "mm/s": -3, "um/s": -6, "cm/s": -2}),
    **_powers(DENSITY, **{"kg/m^3": 0, "kg/m3": 0, "g/cm^3": 3, "g/cm3": 3}),
    **_powers(ACCELERATION, **{"m/s^2": 0, "m/s2": 0}),
    **_powers(FREQUENCY, Hz=0, kHz=3, MHz=6), **_powers(ANGULAR_FREQUENCY, **{"rad/s": 0}),
    **_powers(TEMPERATURE, K=0), **dict.fromkeys(("degC", "°C"), Unit(TEMPERATURE, offset=ZERO_CELSIUS)),
    **_powers(MOLAR_ENERGY, **{"J/mol": 0, "kJ/mol": 3}),
    **_powers(COMPLIANCE, **{"1/Pa": 0, "1/kPa": -3, "1/MPa": -6, "1/GPa": -9}),
    **_powers(ANGLE, rad=0), **dict.fromkeys(("deg", "°"), Unit(ANGLE, math.pi, 180.0)),
    **_powers(NUMBER, **{"": 0, "%": -2}),
}  # fmt: skip
# Spellings of instruments, which a case file must not have. Pint would take C for coulomb.
_OF_INSTRUMENTS = {
    "sec": "s", "C": "degC", "ºC": "degC", "1/s": "Hz", "-": "", "1": "",
    **{f"{unit}{power}": f"1/{unit}" for unit in ("Pa", "kPa", "MPa", "GPa") for power in ("^-1", "-1", "⁻¹")},
}  # fmt: skip
_OF_COLUMNS = (TIME, MODULUS, FREQUENCY, ANGULAR_FREQUENCY, TEMPERATURE, NUMBER, COMPLIANCE, ANGLE)

# The expressions below take quadratic time on some texts, which must therefore be short.
_LONGEST = 200
_QUANTITY = re.compile(r"\s*([+-]?(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d+)?|[+-]?inf)(?![\d.,])\s*(.*?)\s*", re.DOTALL)
_COMMA = re.compile(r"\d,\d")
_UNIT = re.compile(r"[\w%°µμΩÅ·⋅.*/^()\s²³⁻¹⁴-]*")
# "mm2" and "s-1", as people write them, which pint reads as names.
_BARE_EXPONENT = re.compile(r"\b([kcdmuµμn]?m|[mu]?s|in|ft)(-?[1-4])\b")
# A power of a power such as m^9^9^9 would keep pint's integer arithmetic busy for ever.
_TOWER = re.compile(r"(\^|\*\*)[\s(+-]*[\d.]+[\s)]*(\^|\*\*)|\d{4}")
# What people mean, of units that differ in case alone.
_COMMON = (
    "Pa", "kPa", "MPa", "GPa", "mm", "um", "cm", "m", "kg", "g", "mg", "s", "ms", "us", "N", "mN", "kN",
)  # fmt: skip
# What may stand for a unit that was cut off, as in "5 G".
_LONE_PREFIXES = "kMGnu"
# The names of it in texts, pint, astropy and unyt. Hardly any body is that soft, and it is one capital from MPa.
_MILLIPASCAL = re.compile(r"mPa|millipascals?")


# A value with its standard deviation: 10 +- 0.5 MPa, (10 +- 0.5) MPa, 10 MPa +- 5 %.
DEVIATION = re.compile(r"\+-|\+/-|±")
"""Sign between a value and its standard deviation."""
_SIGN = rf"\s*(?:{DEVIATION.pattern})\s*"
_NUMBER = r"[+-]?(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d+)?"
_BOTH = re.compile(rf"\s*(\(?)\s*({_NUMBER}){_SIGN}({_NUMBER})\s*(\)?)\s*([^+±]*?)\s*", re.DOTALL)
_EACH = re.compile(rf"\s*({_NUMBER}[^+±]*?){_SIGN}({_NUMBER}[^+±]*?)\s*", re.DOTALL)


def split_deviation(text: str) -> tuple[str, str]:
    """Return a value with its standard deviation as two texts with units; an `InputError` refuses another form.

    >>> split_deviation("10 +- 0.5 MPa"), split_deviation("(45 ± 1) %"), split_deviation("10 MPa +- 5 %")
    (('10 MPa', '0.5 MPa'), ('45 %', '1 %'), ('10 MPa', '5 %'))
    """
    rule = 'must be a value with its standard deviation; write e.g. "10 +- 0.5 MPa" or "10 MPa +- 5 %"'
    if len(text) > _LONGEST:
        raise InputError("", rule=rule)
    both = _BOTH.fullmatch(text)
    if both is not None and bool(both[1]) == bool(both[4]):
        if both[5] == "%" and not both[1]:
            hint = f'write "({both[2]} +- {both[3]}) %", or the deviation as a number'
            raise InputError("", rule=f"has a percentage that may be one of the value or a number of its own; {hint}")
        return f"{both[2]} {both[5]}".rstrip(), f"{both[3]} {both[5]}".rstrip()
    each = _EACH.fullmatch(text)
    if each is None:
        raise InputError("", rule=rule)
    return each[1].strip(), each[2].strip()


def deviation_in_si(text: str, value: float, dimension: Dimension) -> float:
    """Return a standard deviation in SI from a text with a unit, or in per cent of a value that is no percentage.

    >>> deviation_in_si("0.5 MPa", 1e7, MODULUS), deviation_in_si("5 %", 1e7, MODULUS)
    (500000.0, 500000.0)
    >>> round(deviation_in_si("0.5 degC", 293.15, TEMPERATURE), 9)
    0.5
    """
    match = _QUANTITY.fullmatch(text) if len(text) <= _LONGEST else None
    if match is not None and match[2] == "%" and dimension not in (NUMBER, TEMPERATURE):
        size = 0.01 * float(match[1]) * abs(value)
    else:
        size = to_si(text, dimension)
        if match is not None and match[2]:
            # Zero on the scale of degrees Celsius is not zero in SI.
            size -= to_si(f"0 {match[2]}", dimension)
    if not 0.0 < size < math.inf:
        raise InputError("", rule="must have a standard deviation that is finite and > 0")
    return size


@cache
def unit_registry() -> Any:
    """Return the registry of units that all parts of the package share."""
    from pint import UnitRegistry

    return UnitRegistry()


def to_si(text: str, dimension: Dimension) -> float:
    """Return a text such as "10 mm" as a number in the SI unit of a dimension.

    The text has at most 200 characters. Percent and degrees are units of dimensionless numbers. An `InputError` names
    an unknown unit, or the dimension that the text has.

    >>> to_si("10 mm", LENGTH)
    0.01
    >>> to_si("10 s", LENGTH)
    Traceback (most recent call last):
        ...
    restitution.errors.InputError: is a time, not a length; write e.g. "10 mm", or a plain number in m
    """
    # Pages and papers have a minus of their own.
    text = text.replace("\N{MINUS SIGN}", "-")
    match = _QUANTITY.fullmatch(text) if len(text) <= _LONGEST else None
    if DEVIATION.search(text):
        rule = (
            "must have no standard deviation here: it is for the numbers of an impact that `restitution solve` takes"
        )
        raise InputError("", rule=rule)
    if match is None:
        has_comma = _COMMA.search(text[:_LONGEST])
        rule = "must have a point in place of the comma" if has_comma else "cannot be read as a number and a unit"
        raise InputError("", rule=f"{rule}; {dimension.advice}")
    number, name = float(match[1]), match[2]
    if dimension == MODULUS:
        _refuse_millipascal("", ABSENT, name)
    plain = _UNITS.get(name)
    if plain is not None and plain.dimension.unit == dimension.unit:
        return number if dimension is TEMPERATURE_DIFFERENCE else plain.si(number)
    unit, registry = _pint_unit(name, dimension), unit_registry()
    si = registry.parse_units(dimension.unit)
    if unit.dimensionality != si.dimensionality or (dimension is ANGLE and not name):
        if not name:
            raise InputError("", rule=f"has no unit; {dimension.advice}")
        sought = unit.dimensionality
        articles = (other.article for other in _WRITTEN if registry.parse_units(other.unit).dimensionality == sought)
        what = next(articles, f"a quantity of dimension {sought}")
        near = _near(name, dimension)
        hint = f"did you mean {near}? " if near else ""
        raise InputError("", rule=f"is {what}, not {dimension.article}; {hint}{dimension.advice}")
    return float(registry.Quantity(number, unit).to(si).magnitude)


def _pint_unit(text: str, dimension: Dimension) -> Any:
    refused = InputError("", rule=f"unknown unit {text!r}; {dimension.advice}")
    if not _UNIT.fullmatch(text) or _TOWER.search(text) or len(text) > 80:
        raise refused
    try:
        return unit_registry().parse_units(_BARE_EXPONENT.sub(r"\1**\2", text))
    except Exception:  # pint's parser lets errors of many unrelated types through
        near = _near(text, dimension) or " or ".join(get_close_matches(text, usual_units(dimension), 1, 0.6))
        if not near:
            raise refused from None
        raise InputError("", rule=f"unknown unit {text!r}, did you mean {near}? {dimension.advice}") from None


def usual_units(*dimensions: Dimension) -> list[str]:
    """Return the units in which people give quantities of these dimensions."""
    plain = [name for name, unit in _UNITS.items() if name and unit.dimension in dimensions]
    return [name for name in _COMMON if name in plain] or plain


def _near(text: str, dimension: Dimension) -> str:
    """Return the usual units that begin with a text if it is a prefix, or that differ from it by capitals only."""
    usual = usual_units(dimension)
    with_prefix = [name for name in usual if text in [*_LONE_PREFIXES] and name[0] == text and name[1:] in usual]
    return " or ".join(with_prefix or [name for name in usual if name.lower() == text.lower()])


def _refuse_millipascal(name: str, value: Any, unit: str) -> None:
    """Refuse a modulus in mPa, which a person writes who means MPa."""
    if _MILLIPASCAL.fullmatch(unit):
        raise InputError(name, value, "must not be in mPa, 0.001 Pa; did you mean MPa? If not, write it in Pa")


# Numbers of other libraries.


def has_unit(value: Any) -> bool:
    """Return whether a value is a quantity of pint, astropy or unyt."""
    return (hasattr(value, "magnitude") and hasattr(value, "units")) or (
        hasattr(value, "to_value") and (hasattr(value, "unit") or hasattr(value, "units"))
    )


def without_unit(name: str, value: Any, unit: str) -> Any:
    """Return the plain numbers of a value with a unit (of pint, astropy, unyt, xarray), in the unit of the field."""
    if not has_unit(value):
        attributes = getattr(value, "attrs", None)
        stated = attributes.get("units") if isinstance(attributes, dict) else None
        if stated is None or stated in (unit, unit or "1"):
            return value
        if unit == MODULUS.unit:
            _refuse_millipascal(f"{name}.attrs['units']", stated, str(stated))
        import numpy as np

        try:
            value = unit_registry().Quantity(np.asarray(value), str(stated))
        except Exception:  # pint's parser lets errors of many unrelated types through
            rule = f"must be a unit that can be converted to {unit}" if unit else "must be a plain number"
            raise InputError(f"{name}.attrs['units']", str(stated), rule) from None
    try:
        if unit == MODULUS.unit:
            _refuse_millipascal(name, str(value), str(getattr(value, "units", getattr(value, "unit", ""))))
        if hasattr(value, "magnitude"):
            return value.to(unit or "dimensionless").magnitude
        return value.to_value(unit.replace(" ", "*").replace("^", "**"))
    except InputError:
        raise
    # Each library of units has its own classes of errors.
    except Exception:
        rule = f"must be a quantity in {unit}" if unit else "must be a plain number"
        raise InputError(name, str(value), rule) from None


# Units of the columns of tables of materials.


_COMPOSED = re.compile(r"[A-Za-zµ]{1,12}(\^?[23])?([*/][A-Za-zµ]{1,12}(\^?[23])?){0,2}")


@cache
def unit(text: str) -> Unit | None:
    """Return the unit of a column; None if it is unknown or no quantity of the tables has its dimension."""
    name = text.strip().replace("²", "2").replace("μ", "µ")
    plain = _UNITS.get(_OF_INSTRUMENTS.get(name, name))
    if plain is not None:
        return plain if plain.dimension in _OF_COLUMNS else None
    if not _COMPOSED.fullmatch(name) or name in ("rpm", "deg"):
        return None
    registry = unit_registry()
    try:
        quantity = registry.Quantity(1.0, re.sub(r"(?<=[A-Za-z])([23])", r"^\1", name))
        for dimension in (TIME, MODULUS):
            if quantity.check(registry.Unit(dimension.unit).dimensionality):
                return Unit(dimension, float(quantity.to(dimension.unit).magnitude))
    except Exception:  # errors of pint's parser have no common class
        return None
    return None


# Systems of units of particle codes.


class UnitSystem(NamedTuple):
    """Unit system of mechanics: its units of mass [kg], length [m] and time [s], and their names.

    Examples
    --------
    >>> round(MICRO.convert(1e6, MODULUS), 9), MICRO.unit(MODULUS)
    (1000.0, 'pg/(um us^2)')
    """

    name: str
    mass: float
    length: float
    time: float
    names: tuple[str, str, str]

    def convert(self, value: float, dimension: Dimension) -> float:
        """Return a value in SI in this system."""
        powers = dimension.powers
        return value / (self.mass**powers.mass * self.length**powers.length * self.time**powers.time)

    def unit(self, dimension: Dimension) -> str:
        """Return the name of the unit of a quantity; empty for a plain number, and in reduced units."""
        if self == SI:
            return dimension.unit
        named = [(name, n) for name, n in zip(self.names, dimension.powers, strict=True) if name and n]
        above = " ".join(_power(name, n) for name, n in named if n > 0)
        below = [_power(name, -n) for name, n in named if n < 0]
        if not below:
            return above
        return f"{above or '1'}/" + (f"({' '.join(below)})" if len(below) > 1 else below[0])


def _power(name: str, n: int) -> str:
    return name if n == 1 else f"{name}^{n}"


SI = UnitSystem("si", 1.0, 1.0, 1.0, ("kg", "m", "s"))
CGS = UnitSystem("cgs", 1e-3, 1e-2, 1.0, ("g", "cm", "s"))
MICRO = UnitSystem("micro", 1e-15, 1e-6, 1e-6, ("pg", "um", "us"))
"""Systems of the command `units` of LAMMPS (page "units command" of its documentation)."""

REDUCED = "lj"
SYSTEMS = {system.name: system for system in (SI, CGS, MICRO)}


def reduced(mass: float, length: float, velocity: float) -> UnitSystem:
    """Return the system "lj" in which a mass [kg], a length [m] and a velocity [m/s] are 1."""
    return UnitSystem(REDUCED, mass, length, length / velocity, ("", "", ""))


# Systems of units for display, each with the units in which it differs from SI: name and factor from SI.

_DISPLAYED = {
    "SI": {},
    "mm-g-ms": {
        LENGTH: ("mm", 1e3), MASS: ("g", 1e3), TIME: ("ms", 1e3), ACCELERATION: ("mm/ms²", 1e-3), ENERGY: ("mJ", 1e3),
        MODULUS: ("MPa", 1e-6), PRESSURE: ("MPa", 1e-6), VISCOSITY: ("kPa s", 1e-3),
        ANGULAR_FREQUENCY: ("rad/ms", 1e-3),
    },
    "AFM": {
        LENGTH: ("µm", 1e6), MASS: ("g", 1e3), VELOCITY: ("µm/s", 1e6), ACCELERATION: ("µm/s²", 1e6),
        FORCE: ("nN", 1e9), ENERGY: ("fJ", 1e15), MODULUS: ("kPa", 1e-3), PRESSURE: ("kPa", 1e-3),
        VISCOSITY: ("kPa s", 1e-3),
    },
}  # fmt: skip


def display_systems(dimensions: Iterable[Dimension] = ()) -> dict[str, dict[str, dict[str, Any]]]:
    """Return the unit, factor and offset of each dimension by system: shown = factor x SI + offset.

    Further dimensions, such as those of a user's geometry, are in SI.

    >>> display_systems()["AFM"]["force"]
    {'unit': 'nN', 'factor': 1000000000.0, 'offset': 0.0}
    """
    si = {dimension: (dimension.unit, 1.0) for dimension in dimensions}
    si |= {dimension: (dimension.unit.replace("^2", "²").replace("^3", "³"), 1.0) for dimension in _SHOWN}
    si |= {ANGLE: ("°", 180.0 / math.pi), TEMPERATURE: ("°C", 1.0)}
    return {
        system: {
            dimension.name: {
                "unit": unit,
                "factor": factor,
                "offset": -ZERO_CELSIUS if dimension is TEMPERATURE else 0.0,
            }
            for dimension, (unit, factor) in (si | units).items()
        }
        for system, units in _DISPLAYED.items()
    }
