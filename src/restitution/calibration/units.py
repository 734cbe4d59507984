"""Unit systems of particle codes: factors from SI, and the names of units."""

from __future__ import annotations

from typing import NamedTuple


class Powers(NamedTuple):
    """Powers of mass, length and time in the unit of a quantity."""

    mass: int = 0
    length: int = 0
    time: int = 0


NUMBER = Powers()
PRESSURE = Powers(1, -1, -2)
SPEED = Powers(0, 1, -1)
DURATION = Powers(0, 0, 1)


class UnitSystem(NamedTuple):
    """Unit system of mechanics: its units of mass [kg], length [m] and time [s], and their names.

    Examples
    --------
    >>> round(MICRO.convert(1e6, PRESSURE), 9), MICRO.unit(PRESSURE)
    (1000.0, 'pg/(um us^2)')
    """

    name: str
    mass: float
    length: float
    time: float
    names: tuple[str, str, str]

    def convert(self, value: float, powers: Powers) -> float:
        """Return a value in SI in this system."""
        unit = self.mass**powers.mass * self.length**powers.length * self.time**powers.time
        return value / unit

    def unit(self, powers: Powers) -> str:
        """Return the name of the unit of a quantity; empty for a plain number, and in reduced units."""
        if self == SI and powers == PRESSURE:
            return "Pa"
        named = [(name, n) for name, n in zip(self.names, powers, strict=True) if name and n]
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
