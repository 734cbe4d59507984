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

from restitution.checks import Array, finite, single_positive, whole
from restitution.contact.table import PathTable
from restitution.errors import InputError
from restitution.files import path_of, write_text
from restitution.impact.batch import Batch
from restitution.impact.problem import Impact
from restitution.impact.window import require_known
from restitution.law.slide import grip_labels, tiles_size
from restitution.law.states import forces_of, like, states_of
from restitution.law.step import DEPTH, labels, state_size
from restitution.material.prony import PronySeries
from restitution.material.viscoelastic import Material


@dataclass(frozen=True, eq=False)
class ContactLaw:
    """Contact law with memory; `contact_law` returns it.

    Attributes
    ----------
    impact : Impact
        The impact of the law.
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
    Three contacts, each with its own depth; the first depth is a gap:

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

    def start(self, contacts: int | None = None, *, depth: ArrayLike | None = None) -> Array:
        """Return the state of contacts before first touch, or before the attraction.

        Parameters
        ----------
        contacts : int, optional
            Number of contacts; a single contact if left out.
        depth : float or array, optional
            Depth [m] before the first step, one or one for each contact: the gap between the bodies, with a minus
            sign. It is at most 0, the default, or -h0 with the range h0 of an attraction. The law then finds the
            instant of first touch within a step. A code that notices a contact at its first overlap gives
            ``overlap - rate * dt``.

        Returns
        -------
        array
            Shape ``(state_size,)``, or ``(contacts, state_size)``. A copy of it is a copy of the contact.

        Raises
        ------
        InputError
            If `contacts` is below 1, or a depth is larger or not finite.
        """
        shape = () if contacts is None else (whole("contacts", contacts, 1, 100_000_000),)
        first, (place, unit) = 0.0 - self._reach, self._depth
        before = first if depth is None else finite("depth", depth, "m")
        if np.any(np.asarray(before) > first):
            raise InputError("depth", before, f"must be <= {first:.6g} m, where the forces begin", "m")
        state = np.zeros((*shape, self.state_size))
        state[..., place] = like("depth", np.asarray(before) / unit, shape)
        return state

    @property
    def _reach(self) -> float:
        """Range [m] of the forces before touch."""
        return 0.0

    @property
    def _depth(self) -> tuple[int, float]:
        """Place of the depth in a state, and its unit [m]."""
        return DEPTH, 1.0

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
            Normal force on each body, shape ``()`` or ``(contacts,)``, below 0 only for a pull of an attraction. With
            friction a pair: this force, and the tangential force that resists the way, in the shape of the way.

        Raises
        ------
        InputError
            If a number is out of range, or `way` does not belong to the law; the state is then unchanged.
        SolverError
            If an attraction cannot be followed, or its zone is wider than the law has elements. The contact then stays
            where it was.
        """
        depths = states_of(state, self.state_size, depth, self.max_depth)
        duration, ways = single_positive("dt", dt, "s"), self._ways(way, state.shape[:-1])
        states, forces = state.reshape(-1, self.state_size), np.empty(depths.size)
        self._advance(states, depths.ravel(), duration, forces)
        normal = forces_of(state, forces)
        if ways is None or way is None:
            return normal
        from restitution.law.slide import slide_all

        pulls = np.empty(ways.shape)
        slide_all(self.constants, self.grip, states, forces, ways, duration, pulls)
        if np.ndim(way) == state.ndim:
            return normal, pulls.reshape(*state.shape[:-1], 2)
        return normal, pulls[:, 0].copy() if state.ndim > 1 else float(pulls[0, 0])

    def _advance(self, states: Array, depths: Array, duration: float, forces: Array) -> None:
        """Advance contacts, (n, state_size), and write their forces [N]."""
        # The compiled step takes 0.5 s to import.
        from restitution.law.step import step_all

        step_all(self.constants, states, depths, duration, forces)

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
            ways[:] = like("way", along, (*shape, 2)).reshape(-1, 2)
        else:
            ways[:, 0] = like("way", along, shape).reshape(-1)
        return ways

    @property
    def state_size(self) -> int:
        """Numbers in the state of one contact."""
        normal = state_size(len(self._branches), self.max_nodes)
        return normal if self.shear_modulus is None else normal + tiles_size(len(self._modes), self.max_nodes)

    @cached_property
    def compiled(self) -> Any:
        """The step as a function of numba, ``force = compiled(state, depth, dt)``, for `njit` and `cfunc`.

        It checks nothing: `state` is a contiguous array of `state_size` numbers. Beyond `max_depth`, and where an
        attraction cannot be followed, the force is NaN and the contact stays where it was.
        """
        import numba

        law, step = self.constants, self._step

        @numba.njit
        def advance(state: Any, depth: float, dt: float) -> float:
            return step(law, state, depth, dt)

        return advance

    @property
    def _step(self) -> Any:
        """The compiled step of all laws of this kind."""
        from restitution.law.step import step

        return step

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
        """Write the law as a header in C99, which is C++ as well, that needs no other file.

        Parameters
        ----------
        path : str or path
            Name of the file, such as `law.h`; replaced if it is there.
        name : str
            Start of the names in the header. ``name_start(state, depth)`` begins a contact,
            ``force = name_step(state, depth, dt)`` advances it, and a state is an array of ``name_SIZE`` doubles, with
            the name in capitals. With friction ``name_slide(state, force, way, dt, pull)`` follows each step and
            writes the tangential force. With adhesion ``-name_RANGE`` is the largest depth at which a contact
            begins.

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
        agree to rounding. With adhesion they do up to the error of the law, where rounding decides at which of two
        elements the edge of the attraction is.
        """
        if not isinstance(name, str) or not re.fullmatch(r"[a-z][a-z0-9_]{0,40}", name):
            raise InputError("name", name, "must be lower-case letters, digits and underscores, a letter first")
        return write_text(path_of(path), self._header(name))

    def _header(self, name: str) -> str:
        """Return the text of the header in C."""
        from restitution.law.c_header import header

        friction = "frictionless"
        if self.shear_modulus is not None:
            friction = f"friction coefficient {self.friction:g}, reduced shear modulus {self.shear_modulus!r}"
        values, meanings = self.constants.tolist(), labels(len(self._branches))
        meanings += ["table of the profile"] * (len(values) - len(meanings))
        grip = list(zip(self.grip.tolist(), grip_labels(len(self._modes)), strict=True)) if self.shear_modulus else []
        paragraphs = self._paragraphs(f"{friction}, without adhesion")
        return header(name, paragraphs, list(zip(values, meanings, strict=True)), self.state_size, grip)

    def _paragraphs(self, kind: str) -> list[str]:
        """Return what a header says about the law; `kind` is that of the surfaces."""
        return [
            f"Contact law with memory, made by restitution {version('restitution')}. All numbers are in SI units.",
            f"Profile: {self.impact.profile!r}.",
            *dict.fromkeys(f"Material: {_provenance(material)}." for material in self.impact.contact.materials),
            f"Reduced relaxation modulus: {self.modulus!r}, with an error of e of {self.restitution_error:.2g}.",
            f"Quasi-static, {kind}, small strain, half-spaces. Any history on one spot. "
            "Beyond the largest depth the force is NaN.",
        ]

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
        # Numba has different types for arrays that may be written and for constants.
        constants.setflags(write=False)
        return constants


def _terms(series: PronySeries) -> list[tuple[float, float]]:
    """Return modulus [Pa] and time [s] of each branch; of a dashpot its viscosity and 0."""
    pairs = list(zip(series.branch_moduli.tolist(), series.relaxation_times.tolist(), strict=True))
    return pairs + [(series.parallel_viscosity, 0.0)] * (series.parallel_viscosity > 0.0)


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
