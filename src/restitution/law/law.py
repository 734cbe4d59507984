"""The contact law: normal and tangential force over the history of a contact, step by step."""

from __future__ import annotations

import math
import os
import re
from dataclasses import dataclass, field, replace
from functools import cached_property
from importlib.metadata import version
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from restitution import quantities
from restitution.checks import Array, Numeric, finite, single, single_positive, whole
from restitution.contact.table import PathTable, path_table
from restitution.errors import InputError, InputTypeError
from restitution.files import path_of, write_text
from restitution.impact.batch import Batch
from restitution.impact.problem import Body, Impact, collision, two_bodies
from restitution.impact.window import require_known
from restitution.law.slide import grip_labels, tiles_size
from restitution.law.step import DEPTH, labels, state_size
from restitution.material.prony import PronySeries
from restitution.material.viscoelastic import Material, reduced_shear_modulus, single_material

# Fewest nodes: after thinning, which keeps half and two, there is room for new ones.
_FEWEST = 8
# Nodes without and with friction: those that are dropped cost the tangential force an error of some thousandths.
_NODES = (32, 64)
# Largest depth of a table over that of the impact, and error of the table relative to the largest force.
_DEEPER, _TABLE_RTOL = 4.0, 1e-10


@dataclass(frozen=True, eq=False)
class ContactLaw:
    """Contact law with memory, made by `contact_law`.

    Attributes
    ----------
    impact : Impact
        The impact for which the law was made.
    modulus : PronySeries
        Reduced relaxation modulus E*(t) [Pa] of the law.
    max_nodes : int
        Largest number of nodes of a contact.
    max_depth : float
        Largest depth [m] that the law describes.
    restitution_error : float
        Largest change of the restitution coefficient of the impact by `reduced`; 0 for a law that is not reduced.
    friction : float or None
        Coefficient of friction [-]; None for a law without a tangential force.
    shear_modulus : PronySeries or None
        Reduced shear modulus G*(t) [Pa] of a law with friction.

    Examples
    --------
    Three contacts, each with its own depth; the first one is a gap:

    >>> import restitution as rs
    >>> rubber = rs.standard_solid(1e6, 1e7, 1e3, poisson_ratio=0.45)
    >>> law = rs.contact_law(rs.Impact(rubber, rs.Parabola(0.01), mass=0.005, velocity=1.0))
    >>> state = law.start(3)
    >>> print(law.step(state, [-1e-6, 1e-5, 2e-5], dt=1e-5).round(3))
    [0.    0.099 0.281]

    A law with friction takes the way of the contact points past each other as well:

    >>> law = rs.contact_law(law.impact, friction=0.3)
    >>> normal, tangential = law.step(law.start(), 1e-5, dt=1e-5, way=1e-6)
    >>> print(round(normal, 4), round(tangential, 4))
    0.0994 0.0094
    """

    impact: Impact
    modulus: PronySeries
    max_nodes: int
    max_depth: float
    _table: PathTable | None = field(repr=False)
    restitution_error: float = 0.0
    friction: float | None = None
    shear_modulus: PronySeries | None = None

    def start(self, contacts: int | None = None, *, depth: ArrayLike = 0.0) -> Array:
        """Return the state of contacts before first touch.

        Parameters
        ----------
        contacts : int, optional
            Number of contacts; a single one if left out.
        depth : float or array
            Depth [m] before the first step, <= 0, one or one for each contact: the gap between the bodies, with a
            minus sign. The law then finds the instant of first touch within a step. A code that notices a contact at
            its first overlap gives ``overlap - rate * dt``.

        Returns
        -------
        array
            Shape ``(state_size,)``, or ``(contacts, state_size)``. A copy of it is a copy of the contact.

        Raises
        ------
        InputError
            If `contacts` is below 1, or a depth is positive or not finite.
        """
        shape = () if contacts is None else (whole("contacts", contacts),)
        before = finite("depth", depth, "m")
        if np.any(np.asarray(before) > 0.0):
            raise InputError("depth", before, "must be <= 0 before first touch", "m")
        state = np.zeros((*shape, self.state_size))
        state[..., DEPTH] = _like("depth", before, shape)
        return state

    def step(self, state: Array, depth: ArrayLike, dt: float, way: ArrayLike | None = None) -> Any:
        """Return the force [N] after a time step; the state is changed in place.

        Parameters
        ----------
        state : array
            From `start`.
        depth : float or array
            Depth [m] at the end of the step, negative for a gap; one, or one for each contact.
        dt : float
            Length of the step [s], > 0; it may differ from step to step.
        way : float or array
            With friction: displacement [m] of the contact points past each other in the step, ``(v_x + R w) dt`` with
            the velocity and the spin in the middle of the step. One number, or one for each contact, along one line;
            or two numbers with a last axis of length 2, along two axes at right angles.

        Returns
        -------
        float or array
            Normal force on each body, >= 0, shape ``()`` or ``(contacts,)``. With friction a pair: this force, and the
            tangential force that resists the way, in the shape of the way.

        Raises
        ------
        InputError
            If a number is out of range, or `way` does not belong to the law; the state is then unchanged.
        """
        if not isinstance(state, np.ndarray) or state.dtype != np.float64 or not state.flags.c_contiguous:
            raise InputTypeError("state", rule="must be an array that `start` returned")
        if state.ndim not in (1, 2) or state.shape[-1] != self.state_size:
            rule = f"must be ({self.state_size},) or (contacts, {self.state_size}), as `start` returns"
            raise InputError("state.shape", state.shape, rule)
        depths = np.ascontiguousarray(_like("depth", finite("depth", depth, "m"), state.shape[:-1]))
        if np.any(depths > self.max_depth):
            raise InputError("depth", float(depths.max()), f"must be <= {self.max_depth:g} m", "m")
        duration, ways = single_positive("dt", dt, "s"), self._ways(way, state.shape[:-1])
        # The compiled step takes 0.5 s to import.
        from restitution.law.step import step_all

        states, forces = state.reshape(-1, self.state_size), np.empty(depths.size)
        step_all(self.constants, states, depths.ravel(), duration, forces)
        normal = forces if state.ndim > 1 else float(forces[0])
        if ways is None or way is None:
            return normal
        from restitution.law.slide import slide_all

        pulls = np.empty(ways.shape)
        slide_all(self.constants, self.grip, states, forces, ways, duration, pulls)
        if np.ndim(way) == state.ndim:
            return normal, pulls.reshape(*state.shape[:-1], 2)
        return normal, pulls[:, 0].copy() if state.ndim > 1 else float(pulls[0, 0])

    def _ways(self, way: ArrayLike | None, shape: tuple[int, ...]) -> Array | None:
        """Return the ways of all contacts along both axes; None without friction."""
        if self.friction is None:
            if way is not None:
                raise InputError("way", way, "belongs to a law with friction", "m")
            return None
        if way is None:
            raise InputError("way", rule="must be given: the law has friction")
        along = np.asarray(finite("way", way, "m"))
        ways = np.zeros((math.prod(shape), 2))
        if along.ndim > len(shape):
            ways[:] = _like("way", along, (*shape, 2)).reshape(-1, 2)
        else:
            ways[:, 0] = _like("way", along, shape).reshape(-1)
        return ways

    @property
    def state_size(self) -> int:
        """Numbers in the state of one contact."""
        normal = state_size(len(self._branches), self.max_nodes)
        return normal if self.shear_modulus is None else normal + tiles_size(len(self._modes), self.max_nodes)

    @cached_property
    def compiled(self) -> Any:
        """The step as a function of numba, ``force = compiled(state, depth, dt)``, for `njit` and `cfunc`.

        It allocates nothing and checks nothing: `state` is a contiguous array of `state_size` numbers, and beyond
        `max_depth` the force is NaN and the state stays.
        """
        import numba

        from restitution.law.step import step

        law = self.constants

        @numba.njit
        def advance(state: Any, depth: float, dt: float) -> float:
            return step(law, state, depth, dt)

        return advance

    @cached_property
    def compiled_slide(self) -> Any:
        """The tangential half of a step as a function of numba, ``compiled_slide(state, force, way, dt, pull)``.

        It follows `compiled`, whose normal force it takes, and writes the tangential force [N] along both axes into
        `pull`. `way` and `pull` are contiguous arrays of two numbers.

        Raises
        ------
        InputError
            If the law has no friction.
        """
        import numba

        from restitution.law.slide import slide

        law, grip = self.constants, self.grip

        @numba.njit
        def advance(state: Any, force: float, way: Any, dt: float, pull: Any) -> None:
            slide(law, grip, state, force, way, dt, pull)

        return advance

    def reduced(self, terms: int = 2, *, extrapolate: bool = False) -> ContactLaw:
        """Return the law with fewer terms, which takes less time and memory.

        Parameters
        ----------
        terms : int
            Largest number of terms, >= 1: Maxwell branches, and the parallel dashpot if there is one.
        extrapolate : bool
            Whether the impacts may lie beyond the times for which the material is known.

        Returns
        -------
        ContactLaw
            With the terms that come nearest to the restitution coefficient, the contact time and the largest force of
            the impact, or of all impacts if it has arrays of numbers. Its `restitution_error` is the largest error of
            e at these impacts. The same law if it has no more terms.

        Raises
        ------
        InputError
            If `terms` is below 1, the law has friction, the impacts lie outside the window of the material, or the
            body of one does not rebound.

        Notes
        -----
        A fit of the complex modulus near the frequency ``pi/T`` of the contact time T is the start, and a fit to the
        impacts follows. Terms that are much slower than the contact become part of the spring. Give the impact the
        velocities at which the law will be used.

        Examples
        --------
        >>> import restitution as rs
        >>> rubber = rs.Material(rs.PronySeries(1e6, [3e6, 3e6, 3e6], [1e-6, 1e-3, 1.0]), bulk=2e9)
        >>> impact = rs.Impact(rubber, rs.Parabola(0.01), mass=0.005, velocity=np.array([0.5, 1.0, 2.0]))
        >>> law = rs.contact_law(impact).reduced(terms=1)
        >>> law.modulus.n_branches, law.restitution_error < 0.02
        (1, True)
        """
        whole("terms", terms)
        if self.friction is not None:
            raise InputError("friction", self.friction, "must be None: a law with friction keeps all its terms")
        require_known(self.impact, extrapolate=extrapolate)
        if len(self._branches) <= terms:
            return self

        modulus, error = reduced_series(self.impact, self.modulus, terms)
        return replace(self, modulus=modulus, restitution_error=error)

    def to_c(self, path: str | os.PathLike[str], *, name: str = "contact_law") -> Path:
        """Write the law as a header in C99 that needs no other file.

        Parameters
        ----------
        path : str or path
            Name of the file, such as `law.h`; replaced if it is there.
        name : str
            Start of the names in the header. ``name_start(state, depth)`` begins a contact,
            ``force = name_step(state, depth, dt)`` advances it, and a state is an array of ``name_SIZE`` doubles, with
            the name in capitals. With friction ``name_slide(state, force, way, dt, pull)`` follows each step and
            writes the tangential force.

        Returns
        -------
        Path
            The path.

        Raises
        ------
        InputError
            If `name` is no name in C.

        Notes
        -----
        The header is a translation of the step of this package, with the same operations in the same order; both
        agree to rounding.
        """
        if not isinstance(name, str) or not re.fullmatch(r"[a-z][a-z0-9_]{0,40}", name):
            raise InputError("name", name, "must be lower-case letters, digits and underscores, a letter first")
        target = path_of(path)
        from restitution.law.c_header import header

        friction = "frictionless"
        if self.shear_modulus is not None:
            friction = f"friction coefficient {self.friction:g}, reduced shear modulus {self.shear_modulus!r}"
        paragraphs = [
            f"Contact law with memory, made by restitution {version('restitution')}. All numbers are in SI units.",
            f"Profile: {self.impact.profile!r}.",
            *dict.fromkeys(f"Material: {_provenance(material)}." for material in self.impact.contact.materials),
            f"Reduced relaxation modulus: {self.modulus!r}, with an error of e of {self.restitution_error:.2g}.",
            f"Quasi-static, {friction}, without adhesion, small strain, half-spaces. Any history on one spot. "
            "Beyond the largest depth the force is NaN.",
        ]
        values, meanings = self.constants.tolist(), labels(len(self._branches))
        meanings += ["table of the profile"] * (len(values) - len(meanings))
        grip = list(zip(self.grip.tolist(), grip_labels(len(self._modes)), strict=True)) if self.shear_modulus else []
        text = header(name, paragraphs, list(zip(values, meanings, strict=True)), self.state_size, grip)
        return write_text(target, text)

    @property
    def _branches(self) -> list[tuple[float, float]]:
        return _terms(self.modulus)

    @property
    def _modes(self) -> list[tuple[float, float]]:
        return _terms(self._spectrum)

    @property
    def _spectrum(self) -> PronySeries:
        if self.shear_modulus is None:
            raise InputError("friction", None, "must be given to `contact_law`: this law has no tangential force")
        return self.shear_modulus

    @cached_property
    def grip(self) -> Array:
        """Constants of friction in the order that the module `restitution.law.slide` describes."""
        series, modes = self._spectrum, np.array(self._modes).reshape(-1, 2).T.ravel()
        head = self.friction, len(self._modes), series.equilibrium_modulus
        constants = np.concatenate([np.array(head, dtype=np.float64), modes])
        constants.setflags(write=False)
        return constants

    @cached_property
    def constants(self) -> Array:
        """Constants of the law in the order that the module `restitution.law.step` describes."""
        table, described, exponent, coefficient, cells = self._table, np.zeros(0), -1.0, 0.0, 0
        if table is None:
            profile = self.impact.profile
            exponent, coefficient = float(profile.path_exponent or 0.0), float(profile.path_coefficient or 0.0)
        else:
            cells = len(table.origin)
            low, high = table.ends
            parts = table.edges, np.stack([table.origin, low, high - low], 1), table.radius, table.force_integral
            described = np.concatenate([part.ravel() for part in parts])
        head = len(self._branches), self.max_nodes, self.modulus.equilibrium_modulus, exponent, coefficient
        branches = np.array(self._branches).reshape(-1, 2).T.ravel()
        constants = np.concatenate([[*head, self.max_depth, cells], branches, described])
        # Numba has one type for arrays that may be written, and another one for constants.
        constants.setflags(write=False)
        return constants


def contact_law(
    problem: Impact | tuple[Body, Body],
    *,
    friction: Any = None,
    max_nodes: int | None = None,
    max_depth: float | None = None,
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
        contact radius is no power of the depth at most four times the largest depth of the impact.

    Returns
    -------
    ContactLaw
        With `start` and `step`, and with `compiled`, the step for numba.

    Raises
    ------
    InputError
        If `problem` is neither an `Impact` nor a pair of `Body`, the profile has arrays of numbers, or a number is out
        of range.

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
    """
    impact = problem if isinstance(problem, Impact) else collision(*two_bodies(problem), velocity=1.0)
    if impact.adhesion is not None:
        raise InputError("adhesion", rule="must be left out here; adhesive_contact_law has it, in Python")
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


def _terms(series: PronySeries) -> list[tuple[float, float]]:
    """Return modulus [Pa] and time [s] of each branch; of a dashpot its viscosity and 0."""
    pairs = list(zip(series.branch_moduli.tolist(), series.relaxation_times.tolist(), strict=True))
    return pairs + [(series.parallel_viscosity, 0.0)] * (series.parallel_viscosity > 0.0)


def _like(name: str, values: Numeric, shape: tuple[int, ...]) -> Array:
    """Return values as an array of a shape, refusing those that do not broadcast to it."""
    try:
        return np.broadcast_to(values, shape)
    except ValueError:
        raise InputError(f"{name}.shape", np.shape(values), f"must be () or {shape}: one for each contact") from None


def _provenance(material: Material) -> str:
    """Return the name of a material, its source and what is assumed beyond it."""
    parts = (material.name, material.source, material.assumptions)
    stated = "; ".join(part for part in parts if part) or "without name or source"
    if material.window is None:
        return stated
    return f"{stated}; known for times from {material.window[0]:.4g} to {material.window[1]:.4g} s"


# A Prony series with few terms for the impacts of a longer one: first its modulus, then the impacts themselves.

# Band of the fit over pi/T, number of frequencies, and distance in log(frequency) at which their weight falls.
_LOW, _HIGH, _COUNT, _WIDTH = 0.3, 10.0, 60, 0.7
# Times are within the band times this and its reciprocal: beyond, a term is a spring or a dashpot.
_BEYOND = 1e-2
# Ratio of the last to the first time of each start, whose middle is this share of the contact time.
_SPANS, _MIDDLE = (1.0, 10.0, 100.0, 1e4), 0.3
# Cost of a change of a constant by a factor e, beside errors of the impacts.
_STIFFNESS = 1e-3


def reduced_series(impact: Impact, series: PronySeries, terms: int) -> tuple[PronySeries, float]:
    """Return a series of at most `terms` branches, with the dashpot, and its largest error of e at the impacts."""
    # SciPy takes 0.2 s to import.
    from scipy.optimize import least_squares

    exact = Batch.from_impact(impact).solve(1e-8)
    if not np.all(np.isfinite(exact["contact_time"])):
        raise InputError("impact", rule="must separate: the contact time is the scale of the reduced terms")
    start = _of_modulus(series, exact["contact_time"], terms)
    count = start.n_branches

    def changed(logarithms: Array) -> PronySeries:
        factors = np.exp(logarithms)
        moduli, times = start.branch_moduli * factors[2 : 2 + count], start.relaxation_times * factors[2 + count :]
        viscosity = start.parallel_viscosity * factors[1]
        return PronySeries(start.equilibrium_modulus * factors[0], moduli, times, parallel_viscosity=viscosity)

    def errors(logarithms: Array) -> dict[str, Array]:
        outputs = Batch.from_impact(impact, changed(logarithms)).solve(1e-8)
        names = ("restitution_coefficient", "contact_time", "max_force")
        return {name: outputs[name] - exact[name] for name in names}

    def residuals(logarithms: Array) -> Array:
        of_impacts = errors(logarithms)
        relative = [of_impacts[name] / exact[name] for name in ("contact_time", "max_force")]
        return np.concatenate([of_impacts["restitution_coefficient"], *relative, _STIFFNESS * logarithms])

    best = least_squares(residuals, np.zeros(2 + 2 * count), diff_step=1e-4, max_nfev=20).x
    return changed(best), float(np.abs(errors(best)["restitution_coefficient"]).max())


def _of_modulus(series: PronySeries, contact_time: Array, terms: int) -> PronySeries:
    """Return the series whose complex modulus is nearest at the frequencies pi/T, and near at those around them."""
    from scipy.optimize import least_squares, nnls

    first, last = math.pi / contact_time.max(), math.pi / contact_time.min()
    omega = np.geomspace(_LOW * first, _HIGH * last, _COUNT)
    modulus = series.carson_transform(1j * omega)
    outside = np.log(omega / np.clip(omega, first, last)) / _WIDTH
    weights = 1.0 / (np.abs(modulus) * np.sqrt(1.0 + outside**2))
    fixed = [np.ones(_COUNT)] + [1j * omega / last] * (series.parallel_viscosity > 0.0)
    data = _parts(weights * modulus)

    def columns(logarithms: Array) -> Array:
        s = 1j * omega[:, None] * np.exp(logarithms)
        return _parts(weights[:, None] * np.column_stack([*fixed, s / (1.0 + s)]))

    def residuals(logarithms: Array) -> Array:
        matrix = columns(logarithms)
        return matrix @ nnls(matrix, data)[0] - data

    free, middle = terms - len(fixed) + 1, _MIDDLE * math.sqrt(contact_time.min() * contact_time.max())
    starts = [np.log(middle) + np.linspace(-0.5, 0.5, free + 2)[1:-1] * math.log(span) for span in _SPANS]
    bounds = np.log(_BEYOND / omega[-1]), -np.log(_BEYOND * omega[0])
    fits = [least_squares(residuals, start, diff_step=1e-4, bounds=bounds) for start in starts] if free else []
    logarithms = min(fits, key=lambda fit: fit.cost).x if fits else np.zeros(0)
    spring, *others = nnls(columns(logarithms), data)[0]
    viscosity = others.pop(0) / last if len(fixed) > 1 else 0.0
    return PronySeries(spring, others, np.exp(logarithms), parallel_viscosity=viscosity).simplified()


def _parts(values: NDArray[np.complex128]) -> Array:
    """Return real and imaginary parts, one below the other."""
    return np.concatenate([values.real, values.imag])
