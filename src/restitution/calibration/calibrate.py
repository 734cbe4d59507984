"""Calibration of memoryless contact laws of other codes to the exact answer."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Any

import numpy as np

from restitution import quantities
from restitution.calibration import adhesive
from restitution.calibration import collisions as exact
from restitution.calibration import tangential as tangential_laws
from restitution.calibration.adhesive_laws import ADHESIVE_LAWS
from restitution.calibration.collisions import EVENTS, Collisions
from restitution.calibration.laws import CODES, LAWS, Law, Setting, TypedLaw, rebound
from restitution.calibration.result import Calibration, TypedParameter, heading, snippet, system_of
from restitution.checks import instance, one_of, single, whole, within
from restitution.contact.adhesion import Adhesion
from restitution.errors import InputError
from restitution.impact.oblique import SOLID_BALL
from restitution.impact.problem import Body, Impact
from restitution.units import SI, VELOCITY

# Style of friction in LAMMPS if none is stated.
_STYLE = "mindlin_rescale/force"

# The numbers of a law with which it is nearest to given cases.

# Losses between which the nearest one is searched; the first stands for an elastic contact.
_LOWEST, _HIGHEST = 1e-9, 1e3


def nearest(law: Law, cases: Collisions) -> TypedLaw:
    """Return the law with the smallest largest error of e, then with that of the contact time, both by ratios.

    e depends on the loss alone, and the contact time at a given loss on the stiffness: so e determines the loss, and
    the contact time the stiffness. If the contact time is not known, that of elastic balls does.
    """
    unit_law = TypedLaw(law, cases.static_modulus, 1.0, law.end)
    shape = cases.restitution_coefficient.shape
    profile = np.broadcast_to(np.asarray(unit_law.loss(*cases.grid)), shape)
    strength = _nearest_strength(unit_law, profile, cases)
    timed = not np.isnan(cases.contact_time).all()
    time = cases.contact_time if timed else cases.elastic_time
    law_time = replace(unit_law, strength=strength if timed else 0.0).rebound(*cases.grid)[1]
    ratio = np.log(law_time / time)
    modulus = unit_law.modulus * math.exp(0.5 * (ratio.min() + ratio.max()) * (law.shape.spring + 1.0))
    # The strength of the same loss at this stiffness.
    strength *= float(profile.max() / np.max(replace(unit_law, modulus=modulus).loss(*cases.grid)))
    _refuse_out_of_reach(law, strength, cases)
    return TypedLaw(law, modulus, strength, law.end)


def _nearest_strength(law: TypedLaw, profile: Any, cases: Collisions) -> float:
    """Return the strength at which e is nearest to the exact one by ratios, from the losses at a strength of 1."""
    from scipy.optimize import minimize_scalar

    goal = np.log(cases.restitution_coefficient)

    def error(log_strength: float) -> float:
        e, _ = rebound(law.law.shape, law.end, math.exp(log_strength) * profile)
        return float(np.abs(np.log(e) - goal).max())

    # Each e falls with the strength, so that there is one minimum.
    bounds = math.log(_LOWEST / profile.min()), math.log(_HIGHEST / profile.max())
    minimum: Any = minimize_scalar(error, bounds=bounds, method="bounded", options={"xatol": 1e-10, "maxiter": 200})
    strength = math.exp(minimum.x)
    return strength if strength * profile.max() > 10.0 * _LOWEST else 0.0


def _refuse_out_of_reach(law: Law, strength: float, cases: Collisions) -> None:
    """Raise if no number that can be typed gives the strength."""
    weakest, strongest = law.strengths
    if weakest * (1.0 - 1e-6) <= strength <= strongest * (1.0 + 1e-6) or (strength == 0.0 and law.elastic):
        return
    ends = rebound(law.shape, law.end, [strongest, weakest])[0]
    e = cases.restitution_coefficient
    span = f"{e.min():.9g} to {e.max():.9g}" if e.min() < e.max() else f"{e.max():.9g}"
    reach = f"reaches e from {ends[0]:.6g} to {ends[1]:.6g}{' and 1' if law.elastic and weakest > 0.0 else ''}"
    raise InputError("target", law.name, f"{reach}, but e is {span}")


TARGETS = (*LAWS, *EVENTS, *ADHESIVE_LAWS)
"""Names of the laws of the package."""


def calibrate(
    problem: Impact | tuple[Body, Body],
    target: str,
    velocity: Any = None,
    *,
    radius: Any = None,
    restitution: Any = None,
    contact: str | None = None,
    units: str = "si",
    friction: Any = None,
    angle: Any = None,
    gyration: Any = SOLID_BALL,
    tangential: str | None = None,
    adhesion: Adhesion | None = None,
    extrapolate: bool = False,
    points: int = 33,
    rtol: float = 1e-9,
    workers: int | None = None,
) -> Calibration:
    """Return the numbers for the contact law of another code that are nearest to the exact coefficient of restitution.

    Parameters
    ----------
    problem : Impact, or pair of Body
        The bodies; an impact with a parabola, whose own velocity does not matter.
    target : str
        "lammps-viscoelastic", "lammps-tsuji", "lammps-coeff-restitution", "mercury-bshp", "yade-mindlin", "liggghts",
        "kratos-dem", "mujoco-solref", "drake" or "drake-sap"; with e over velocity "rebound", "acusolve" or "solfec";
        with one e and the velocity below which the code swallows a bounce "box2d", "bullet" or "physx". With adhesion
        "lammps-jkr-viscoelastic", "lammps-jkr-mass-velocity", "lammps-dmt-viscoelastic", "lammps-dmt-mass-velocity",
        "liggghts-sjkr", "mercury-adhesive", "yade-dmt" or "mfix".
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
    friction : float, optional
        Coefficient of friction [-], > 0, by default that of the impact, if it has one: the text then has friction too,
        and `angles` e_t over the angle of incidence. For LAMMPS, LIGGGHTS, MercuryDPM, YADE, Kratos, MuJoCo, REBOUND
        and AcuSolve.
    angle : tuple of float, or float, optional
        Smallest and largest angle of incidence [rad] from the normal, or one angle, of bodies without spin. The
        default is from 2 to 85 degrees.
    gyration : float
        Moment of inertia over m R^2 [-], 2/5 for a solid ball.
    tangential : str, optional
        Tangential style of LAMMPS: "mindlin", "mindlin/force", "mindlin_rescale" or "mindlin_rescale/force", the
        default.
    adhesion : Adhesion, optional
        Adhesion of the bodies, by default that of the impact, for one radius, without friction.
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

    With friction the law of the code is followed in the collision in the middle of the range, with its own rules for
    spring, dashpot and slip. Its tangential stiffness (where only E and nu are typed by nu, which leaves the normal
    force) and, in LAMMPS, the tangential damping minimise the largest difference of e_t over the angles. The
    coefficient of friction is that of the contact, which alone counts where all slides.

    With adhesion the law sticks below the same velocity as the bodies, `sticking_velocity` of the result, and its loss
    minimises the largest difference of e above it; errors are differences then. Its surface energy follows from this,
    and may differ from half the work of adhesion, as a law without memory has no larger pull at a fast separation.
    The e that some of these codes take is that of their contact without cohesion.

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
    if not isinstance(target, str) or target not in ADHESIVE_LAWS:
        # A law that is added to `LAWS` later is a target too.
        quantities.choice("target", target, (*LAWS, *EVENTS))
    if contact is not None:
        one_of("contact", contact, (exact.PAIR, exact.WALL))
    whole("points", points, 2, 10_000)
    single("rtol", within("rtol", rtol, 1e-12, 1e-2))
    law = LAWS.get(target)
    named = law or ADHESIVE_LAWS.get(target)
    one_of("units", units, named.units if named else ("si",), f" for {target}")
    if isinstance(problem, Impact) and problem.adhesion is not None:
        adhesion, problem = adhesion or problem.adhesion, replace(problem, adhesion=None)
    _check_cohesion(target, adhesion)
    if isinstance(problem, Impact) and problem.friction is not None:
        if friction is None and tangential_laws.takes_friction(target):
            friction, gyration = problem.friction, problem.gyration
        problem = problem.normal
    bodies = exact.bodies_of(problem, contact)
    if adhesion is not None:
        options = {
            "radius": radius, "restitution": restitution, "friction": friction, "angle": angle,
            "tangential": tangential,
        }  # fmt: skip
        for name, value in options.items():
            if value is not None:
                raise InputError(name, value, "must be left out with adhesion")
        if bodies.wall and not ADHESIVE_LAWS[target].wall:
            raise InputError("contact", rule=f"must be {exact.PAIR!r} for {target}: its walls have another attraction")
        adhesive_cases = adhesive.collisions(
            bodies, adhesion, velocity, points, rtol, workers, extrapolate=extrapolate
        )
        return adhesive.calibrated(target, adhesive_cases, units)
    cases = exact.collisions(bodies, velocity, radius, restitution, points, rtol, workers, extrapolate=extrapolate)
    rough = None if friction is None else (friction, angle, gyration, tangential)
    if rough is None:
        for name, value in (("angle", angle), ("tangential", tangential)):
            if value is not None:
                raise InputError(name, value, "belongs to friction, which is not given")
    return _of_events(target, cases, rough) if law is None else _of_law(law, cases, units, rough)


def _check_cohesion(target: str, adhesion: Any) -> None:
    """Refuse a target with cohesion for bodies without adhesion, and one without for bodies with it."""
    instance("adhesion", adhesion, (Adhesion, type(None)), "must be an Adhesion or None")
    if adhesion is None and target in ADHESIVE_LAWS:
        raise InputError("adhesion", rule=f"must be given for {target}")
    if adhesion is not None:
        if target not in ADHESIVE_LAWS:
            raise InputError("target", target, f"must be {', '.join(ADHESIVE_LAWS)} with adhesion")
        if adhesion.shape:
            raise InputError("adhesion", rule=f"must be single, but has shape {adhesion.shape}")


def _of_law(law: Law, cases: Collisions, units: str, rough: tuple[Any, ...] | None) -> Calibration:
    velocity, mass, _ = cases.middle
    poisson_ratio = cases.pair.impact.material.poisson_ratio
    setting = Setting(velocity, mass, poisson_ratio, *cases.dynamic_modulus, cases.middle_restitution)
    best, naive = nearest(law, cases), TypedLaw(law, *law.naive(setting), law.naive_end)
    system, angles, style = system_of(cases, units), None, None
    numbers_of_code = setting
    if rough is not None:
        angles, style = tangential_laws.over_angles(law.name, best, cases, *rough), rough[-1] or _STYLE
        numbers_of_code = tangential_laws.with_poisson_ratio(law.name, angles, setting)

    def numbers(numbered: TypedLaw, within: Setting) -> dict[str, TypedParameter]:
        typed = law.typed(numbered.modulus, numbered.strength, within)
        if angles is not None and within is numbers_of_code:
            typed |= tangential_laws.typed(law.name, angles, numbered.modulus, rough[-1] if rough else None)
        return {
            name: TypedParameter(system.convert(value, dimension), system.unit(dimension), words)
            for name, (value, dimension, words) in typed.items()
        }

    parameters = numbers(best, numbers_of_code)
    text = snippet(best, parameters, cases, system, style)
    usual = numbers(naive, setting._replace())
    return Calibration(law.name, law.words, law.source, units, parameters, usual, text, cases, best, naive, angles)


def _of_events(name: str, cases: Collisions, rough: tuple[Any, ...] | None) -> Calibration:
    angles = None if rough is None else tangential_laws.over_angles(name, None, cases, *rough)
    table, middle, code = exact.event_table(cases, name), cases.middle_restitution, CODES[name]
    constant = exact.TableLaw(cases.velocity[:1], np.array([middle]))
    naive = {"e": TypedParameter(middle, "", "coefficient of restitution at all velocities")}
    threshold, parameters = exact.THRESHOLD * float(cases.velocity[0]), dict[str, TypedParameter]()
    if "row" not in code:
        words = "velocity below which a bounce is swallowed, half of the lowest one here"
        e = float(table.restitution_coefficient[0])
        parameters = {
            "restitution": TypedParameter(e, "", "coefficient of restitution at all velocities"),
            "threshold": TypedParameter(threshold, VELOCITY.unit, words),
        }
    remarks = [*heading(code["words"], cases, SI), *code.get("notes", ())]
    comment = code.get("comment", "# {}")
    text = "\n".join([*map(comment.format, remarks), exact.event_text(table, name, threshold, angles)])
    return Calibration(
        name, code["words"], code["source"], "si", parameters, naive, text, cases, table, constant, angles
    )  # fmt: skip
