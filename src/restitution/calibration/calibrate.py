"""Calibration of memoryless contact laws of other codes to the exact answer."""

from __future__ import annotations

from typing import Any

import numpy as np

from restitution import quantities
from restitution.calibration import events
from restitution.calibration.bodies import PAIR, WALL, pair
from restitution.calibration.codes import LAWS
from restitution.calibration.collisions import Collisions, collisions
from restitution.calibration.fit import nearest
from restitution.calibration.laws import Law, Setting, TypedLaw
from restitution.calibration.result import Calibration, TypedParameter
from restitution.calibration.snippet import heading, snippet
from restitution.calibration.units import REDUCED, SI, SYSTEMS, UnitSystem, reduced
from restitution.checks import one_of, single, whole, within
from restitution.impact.problem import Body, Impact

TARGETS = (*LAWS, events.REBOUND)
"""Names of the laws of the package; a law that is added to `LAWS` is a target too."""


def calibrate(
    problem: Impact | tuple[Body, Body],
    target: str,
    velocity: Any = None,
    *,
    radius: Any = None,
    restitution: Any = None,
    contact: str | None = None,
    units: str = "si",
    extrapolate: bool = False,
    points: int = 33,
    rtol: float = 1e-9,
    workers: int | None = None,
) -> Calibration:
    """Numbers for the contact law of another code that are nearest to the exact coefficient of restitution.

    Parameters
    ----------
    problem : Impact, or pair of Body
        The bodies; an impact with a parabola, whose own velocity does not matter.
    target : str
        "lammps-viscoelastic", "lammps-tsuji", "lammps-coeff-restitution", "mercury-bshp", "yade-mindlin", "liggghts",
        "kratos-dem", "mujoco-solref" or "rebound".
    velocity : tuple of float, or float
        Lowest and highest velocity v0 [m/s], > 0, or one velocity. With a measured table its range by default.
    radius : tuple of float, optional
        Smallest and largest radius [m] of the first ball (of an impact: of its parabola), for one law of all sizes.
        The radii of both bodies are in proportion, and the masses to their third power.
    restitution : float, or pair of arrays, optional
        A coefficient of restitution, or measured velocities [m/s] and coefficients, in place of those of the
        material. The stiffness is then the static one of the material, and the exact contact time is not known.
    contact : {"pair", "wall"}, optional
        Two balls, or a ball and a wall. By default from the bodies; of an impact a pair if both bodies deform. The
        other contact is built from the bodies: two equal balls from a ball and a wall, a ball and a wall of its
        material from two equal balls.
    units : {"si", "cgs", "micro", "lj"}
        Unit system of the numbers: for LAMMPS all, for LIGGGHTS "si" and "cgs", else "si". In "lj" the mass and the
        diameter of the first ball and the highest velocity are 1.
    extrapolate : bool
        Whether the contacts may lie beyond the times for which the material is known, with a warning in the result.
    points : int
        Number of velocities, at equal ratios.
    rtol, workers
        See `solve`.

    Returns
    -------
    Calibration
        Numbers to type, text to paste, and the error at each velocity.

    Raises
    ------
    InputError
        If a number is out of range, the bodies do not determine the other contact, the contacts lie outside the
        window of the material, the bodies do not separate, or the law cannot reach the coefficient of restitution.
    SolverError
        If a solve fails.

    Notes
    -----
    A law F = k d^p + c d^q v is integrated with the end of contact of the code. The loss minimises the largest error
    of e, by ratios, over the velocities, and the stiffness that of the contact time. No law without memory follows
    the exact answer over a wide range of velocities.

    Over a range of radii the largest error is that of two balls of one size. In all cases that were tried, balls of
    two sizes of the range have a smaller error.

    Examples
    --------
    >>> import restitution as rs
    >>> rubber = rs.kelvin_voigt(1e6, 50.0, poisson_ratio=0.5, density=1100.0)
    >>> ball = rs.Body(rubber, radius=0.005)
    >>> law = rs.calibrate((ball, ball), "lammps-viscoelastic", velocity=(0.1, 1.0))
    >>> round(law.parameters["E"].value / 1e6, 2), law.largest_error < 0.001
    (2.87, True)
    """
    quantities.known("target", target, (*LAWS, events.REBOUND))
    if contact is not None:
        one_of("contact", contact, (PAIR, WALL))
    whole("points", points, 2, 10_000)
    single("rtol", within("rtol", rtol, 1e-12, 1e-2))
    law = LAWS.get(target)
    systems = law.units if law else ("si",)
    one_of("units", units, systems, f" for {target}")
    bodies = pair(problem, contact)
    wanted = collisions(bodies, velocity, radius, restitution, points, rtol, workers, extrapolate=extrapolate)
    return _of_events(wanted) if law is None else _of_law(law, wanted, units)


def _of_law(law: Law, wanted: Collisions, units: str) -> Calibration:
    velocity, mass, _ = wanted.middle
    poisson_ratio = wanted.pair.impact.material.poisson_ratio
    setting = Setting(velocity, mass, poisson_ratio, *wanted.dynamic_modulus, wanted.middle_restitution)
    found, naive = nearest(law, wanted), TypedLaw(law, *law.naive(setting), law.naive_end)
    system = _system(wanted, units)

    def numbers(one: TypedLaw) -> dict[str, TypedParameter]:
        return {
            name: TypedParameter(system.convert(typed.value, typed.powers), system.unit(typed.powers), typed.words)
            for name, typed in law.typed(one.modulus, one.strength, setting).items()
        }

    parameters = numbers(found)
    text = snippet(found, parameters, wanted, system)
    return Calibration(law.name, law.words, law.source, units, parameters, numbers(naive), text, wanted, found, naive)


def _system(wanted: Collisions, units: str) -> UnitSystem:
    if units != REDUCED:
        return SYSTEMS[units]
    radius = float(wanted.radius[wanted.radius.size // 2])
    mass = wanted.pair.ball_mass * (radius / wanted.pair.ball_radius) ** 3
    return reduced(mass, 2.0 * radius, float(wanted.velocity[-1]))


def _of_events(wanted: Collisions) -> Calibration:
    table, middle = events.table(wanted), wanted.middle_restitution
    constant = events.TableLaw(wanted.velocity[:1], np.array([middle]))
    usual = {"e": TypedParameter(middle, "", "coefficient of restitution at all velocities")}
    text = "\n".join([*(f"# {line}" for line in heading(events.WORDS, wanted, SI)), table.text])
    return Calibration(events.REBOUND, events.WORDS, events.SOURCE, "si", {}, usual, text, wanted, table, constant)
