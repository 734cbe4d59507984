"""The contact law of a problem: its friction and adhesion, its nodes and its largest depth."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from restitution import quantities
from restitution.checks import single, single_positive, whole
from restitution.contact.profiles import as_profile
from restitution.contact.table import path_table
from restitution.errors import InputError
from restitution.impact.batch import Batch
from restitution.impact.problem import Body, Impact, collision, two_bodies
from restitution.law.adhesive import adhesive_law
from restitution.law.law import ContactLaw
from restitution.material.viscoelastic import reduced_shear_modulus, single_material

# Fewest nodes: after thinning, which keeps half and two, there is room for new ones.
_FEWEST = 8
# Nodes without and with friction: those that are dropped cost the tangential force an error of some thousandths.
_NODES = (32, 64)
# Largest depth of a table over that of the impact, and error of the table relative to the largest force.
_DEEPER, _TABLE_RTOL = 4.0, 1e-10


def contact_law(
    problem: Impact | tuple[Body, Body],
    *,
    friction: Any = None,
    max_nodes: int | None = None,
    max_depth: float | None = None,
    elements: int | None = None,
) -> ContactLaw:
    """Return the contact law with memory for codes that step in time, such as discrete-element and multibody codes.

    Parameters
    ----------
    problem : Impact, or pair of Body
        Its materials and its profile define the law. Mass, velocity and external force do not matter, except for a
        profile given by a table, whose depths end beyond the deepest of these impacts. They may be arrays.
    friction : float, optional
        Coefficient of friction [-], >= 0 and finite, for a law with a tangential force as well; by default that of the
        impact, if it has one.
    max_nodes : int, optional
        Largest number of nodes of a contact, >= 8: 32 by default, and 64 with friction. A contact gets one node for
        each step of its first approach. When there is no room, nodes that are near others in depth and time are
        dropped.
    max_depth : float, optional
        Largest depth [m] of the law. The default is the largest depth that the profile describes; for a profile whose
        contact radius is no power of the depth at most four times the largest depth of the impact. With adhesion it
        is four times that of the impact, both counted from where the attraction begins.
    elements : int, optional
        With adhesion: number of elements within the largest zone of the impact, in [10, 2000]; 100 by default.

    Returns
    -------
    ContactLaw
        With `start` and `step`, and with `compiled`, the step for numba. That of an impact with adhesion is an
        `AdhesiveContactLaw`.

    Raises
    ------
    InputError
        If `problem` is neither an `Impact` nor a pair of `Body`, the profile has arrays of numbers, or a number is out
        of range.
    SolverError
        With adhesion, if the attracted zone is too thin for elements.

    Notes
    -----
    The law follows the foundation of the method of dimensionality reduction at nodes: the places that the edge of the
    contact had at the end of each step. A node in contact moves with the body. A free node creeps back without load,
    and the body may touch it again. Over one step the velocity changes linearly, as in the Verlet scheme. The page
    Contact law of the theory derives the step.

    The force converges to that of `restitution.solve` and, for any history of the depth, to that of
    `restitution.indent`, at second order in the time step. At 50 steps per contact the error of the restitution
    coefficient is about 0.0001, and at most 0.002 in the paper's plane. Each element of the foundation is on its own,
    as in the paper of Willert et al., but the body may touch it again: such elements are the exact solution on a
    virgin surface whose modulus never rises, under a profile whose transform g rises outwards.

    The explicit scheme of a code that steps in time is stable for steps below ``2/sqrt(2 E0 a/m)``, with the glass
    modulus E0 and the largest contact radius a. With a dashpot, or branches that are faster than the step, the step
    must also be below ``m/(2 eta a)``, with eta the sum of the dashpot and of ``E_k tau_k`` of these branches. Along
    the surface the same holds with G* and ``m_t = m/(1 + 1/kappa)``, ``2 m/7`` of a solid ball.

    With friction the force along the surface is that of Coulomb's law in each point of the contact. It converges to
    that of `restitution.solve` of an impact with friction, at second order in the time step without a dashpot, where
    no nodes are dropped. A step takes the way of the contact points past each other, so that a ball that rolls without
    slip feels none.

    With adhesion the impact is single, and its velocity and mass set the largest zone, within which the elements lie.
    The law is the march of the solver along straight lines of the depth: an element carries the attraction or follows
    the body, both with memory, and the edge of the zone moves or jumps at its own instants within a step. e converges
    at second order in the time step to that of so many elements, which errs at second order in their distance.

    Examples
    --------
    >>> import restitution as rs
    >>> rubber = rs.standard_solid(1e6, 1e7, 1e3, poisson_ratio=0.45)
    >>> impact = rs.Impact(rubber, rs.Parabola(0.01), mass=0.005, velocity=1.0)
    >>> exact = rs.solve(impact)
    >>> law = rs.contact_law(impact)
    >>> dt = exact.contact_time / 100
    >>> state, depth, velocity, force = law.start(), 0.0, 1.0, 0.0
    >>> while True:  # velocity Verlet
    ...     depth += velocity * dt - 0.5 * force / impact.mass * dt**2
    ...     before, force = force, law.step(state, depth, dt)
    ...     velocity -= 0.5 * (before + force) / impact.mass * dt
    ...     if force == 0.0:
    ...         break
    >>> abs(-velocity - exact.restitution_coefficient) < 2e-4
    True

    Two balls, whose depth is the overlap:

    >>> ball = rs.Body(rubber, radius=0.02, mass=0.01)
    >>> law = rs.contact_law((ball, ball))

    A grain that its wall attracts: the contact begins with a pull.

    >>> polymer = rs.standard_solid(1e9, 1e9, 20.0, poisson_ratio=0.35)
    >>> sticky = rs.Adhesion(0.05, stress=1e7)
    >>> law = rs.contact_law(rs.Impact(polymer, rs.Parabola(5e-6), mass=2.5e-12, velocity=0.3, adhesion=sticky))
    >>> law.step(law.start(), -4e-9, dt=1e-8) < 0.0
    True
    """
    impact = problem if isinstance(problem, Impact) else collision(*two_bodies(problem), velocity=1.0)
    if impact.adhesion is not None:
        if friction is not None or max_nodes is not None:
            name = "max_nodes" if friction is None else "friction"
            raise InputError(name, max_nodes if friction is None else friction, "must be left out with adhesion")
        return adhesive_law(impact, elements, max_depth)
    if elements is not None:
        raise InputError("elements", elements, "belongs to a law with adhesion")
    for name in ("material", "counter_material"):
        if getattr(impact, name) is not None:
            single_material(name, getattr(impact, name))
    impact.contact.warn_if_approximate("contact law")
    shear, friction = None, impact.friction if friction is None else friction
    impact = impact if impact.friction is None else impact.normal
    if friction is not None:
        friction = single("friction", quantities.check("friction", friction))
        if math.isinf(friction):
            raise InputError("friction", friction, "must be finite: a contact that never slips has no law with steps")
        as_profile(impact.profile, "friction")
        shear = reduced_shear_modulus(impact.material, impact.counter_material)
    nodes = _NODES[friction is not None] if max_nodes is None else whole("max_nodes", max_nodes, _FEWEST)
    profile = impact.profile
    limit, largest = profile.max_depth, None if max_depth is None else single_positive("max_depth", max_depth, "m")
    exponent, coefficient = profile.path_exponent, profile.path_coefficient
    if np.ndim(limit) or np.ndim(profile.stiffness_radius(0.0)):
        raise InputError("profile", profile, "must have single numbers as parameters: a law describes one profile")
    if largest is not None and largest > limit:
        raise InputError("max_depth", largest, f"must be <= {limit:g} m, {profile.end}", "m")
    if exponent is not None and coefficient is not None:
        largest = float(limit if largest is None else largest)
        return ContactLaw(
            impact, impact.reduced_modulus, nodes, largest, None, friction=friction, shear_modulus=shear
        )  # fmt: skip
    if largest is None:
        deepest = np.nanmax(Batch.from_impact(impact).solve(1e-6)["max_indentation_depth"])
        largest = min(float(limit), _DEEPER * float(deepest))
    table = path_table(profile, largest, _TABLE_RTOL)
    return ContactLaw(impact, impact.reduced_modulus, nodes, largest, table, friction=friction, shear_modulus=shear)
