"""The contact law with adhesion: force over the history of a depth, step by step."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any, NamedTuple

import numpy as np

from restitution.checks import Array, finite, single, whole
from restitution.contact.adhesion import rest
from restitution.errors import InputError
from restitution.impact.adhesive import problem_of, unresolved
from restitution.impact.dugdale import Problem, scales
from restitution.impact.problem import Impact
from restitution.impact.status import SolverError, Status
from restitution.indentation.solid import compliance_of
from restitution.law.law import ContactLaw
from restitution.law.states import states_of

# Fewest and most elements within the largest zone of the impact, their number by default, and most of all.
_FEWEST, _LARGEST, _ELEMENTS, _MOST = 10, 2000, 100, 16000
# Largest depth of the law over that of the impact, both from the first attraction on; elements beyond it.
_DEEPER, _BEYOND = 4.0, 1.1
# Elements of the march that finds the depth of the impact.
_COARSE = 64


class AdhesiveState(NamedTuple):
    """Numbers of a contact with adhesion, from `AdhesiveContactLaw.read`; single numbers or arrays.

    Attributes
    ----------
    depth : float
        Depth [m] after the last step.
    force : float
        Force [N] at the end of the last step, without the correction of `AdhesiveContactLaw.step`.
    zone_radius, contact_radius : float
        Radii [m] of the attraction and of the elements that touch.
    dissipated_energy, jump_energy : float
        Energies [J] that the material has dissipated, and that jumps have lost.
    """

    depth: Any
    force: Any
    zone_radius: Any
    contact_radius: Any
    dissipated_energy: Any
    jump_energy: Any


class _Units(NamedTuple):
    """Length [m], time [s] and force [N] of 1 in the kernel."""

    length: float
    time: float
    force: float


@dataclass(frozen=True, eq=False)
class AdhesiveContactLaw(ContactLaw):
    """Contact law with adhesion and memory; `contact_law` of an impact with adhesion returns it.

    It has the members of `ContactLaw`, and is not reduced: `max_nodes` is the number of all its elements. The depth
    changes linearly over a step, and the attraction jumps at its own instants within. A jump changes the impulse of
    the step by more than the forces at both ends know. So the force is that at the end of the step plus a correction
    of second order, with which the scheme of Verlet has the impulse of the contact.

    Attributes
    ----------
    elements : int
        Number of elements within the largest zone of the impact of the law.

    Examples
    --------
    Three contacts, each with its own depth, within the range of the attraction of 5 nm:

    >>> import restitution as rs
    >>> polymer = rs.standard_solid(1e9, 1e9, 20.0, poisson_ratio=0.35)
    >>> sticky = rs.Adhesion(0.05, stress=1e7)
    >>> grain = rs.Impact(polymer, rs.Parabola(5e-6), mass=2.5e-12, velocity=0.2, adhesion=sticky)
    >>> law = rs.contact_law(grain)
    >>> state = law.start(3)
    >>> print(law.step(state, [-4e-9, -2e-9, 1e-8], dt=1e-8) < 0.0)
    [ True  True False]
    >>> bool(law.read(state).contact_radius[2] > 0.0)
    True
    """

    elements: int = field(kw_only=True)
    _problem: Problem = field(kw_only=True, repr=False)
    _width: float = field(kw_only=True, repr=False)
    _gaps: Array = field(kw_only=True, repr=False)

    @property
    def _depth(self) -> tuple[int, float]:
        from restitution.kernel.contact_law import DEPTH

        return DEPTH, self._units.length

    def _advance(self, states: Array, depths: Array, duration: float, forces: Array) -> None:
        # The compiled step takes 0.5 s to import.
        from restitution.kernel.contact_law import FAILED, step_all
        from restitution.kernel.zone import NO_ROOM

        step_all(self.constants, states, depths, duration, forces)
        failed = states[:, FAILED]
        if np.any(failed == NO_ROOM):
            raise SolverError(Status.TOO_DEEP, "the zone is wider than the law; give a larger max_depth")
        if np.any(failed):
            raise SolverError(Status.NOT_ACCURATE, "the attraction cannot be followed")

    def read(self, state: Array) -> AdhesiveState:
        """Return depth, force, radii and energies of a contact, in the shape of its depth."""
        from restitution.kernel.contact_law import DEPTH, EDGE, LOAD, RADIATED, RADIUS, SPENT

        states_of(state, self.state_size, 0.0, math.inf)
        unit = self._units
        energy = unit.force * unit.length
        places = (
            (DEPTH, unit.length), (LOAD, unit.force), (EDGE, unit.length), (RADIUS, unit.length), (SPENT, energy),
            (RADIATED, energy),
        )  # fmt: skip
        return AdhesiveState(*((state[..., place] * scale)[()] for place, scale in places))

    @property
    def state_size(self) -> int:
        """Numbers in the state of one contact."""
        from restitution.kernel.contact_law import MODES, state_size

        return state_size(int(self.constants[MODES]), self._gaps.size)

    @property
    def _step(self) -> Any:
        from restitution.kernel.contact_law import step

        return step

    def reduced(self, terms: int = 2, *, extrapolate: bool = False) -> ContactLaw:
        """Refuse: a law with adhesion keeps all its terms."""
        whole("terms", terms)
        raise InputError("adhesion", rule="must be left out: a law with adhesion keeps all its terms")

    def _header(self, name: str) -> str:
        from restitution.kernel.contact_law import labels
        from restitution.law.c_header import adhesive_header

        values, adhesion = self.constants.tolist(), self.impact.adhesion
        described = list(zip(values, labels(int(values[1]), self.max_nodes), strict=True))
        paragraphs = self._paragraphs(f"frictionless, {adhesion!r}")
        return adhesive_header(name, paragraphs, described, self.state_size, self._reach)

    @property
    def _reach(self) -> float:
        return float(np.asarray(self._problem.body.adhesion.range))

    @cached_property
    def _units(self) -> _Units:
        """Units of the kernel: the width of the zone, its time at the velocity of the impact, the glass modulus."""
        modulus = 1.0 / compliance_of(self.modulus)[0]
        return _Units(self._width, self._width / self._problem.velocity, modulus * self._width**2)

    @cached_property
    def constants(self) -> Array:
        """Constants of the law in the order that the module `restitution.kernel.contact_law` describes."""
        compliance, weights, rates = compliance_of(self.modulus)
        unit, stress = self._units, float(np.asarray(self._problem.body.adhesion.stress))
        head = (
            self._gaps.size, rates.size, stress * compliance, self._reach / unit.length, 1.0 / self.elements,
            self.max_depth, *unit,
        )  # fmt: skip
        modes = weights / compliance * unit.time, rates * unit.time
        constants = np.concatenate([head, *modes, self._gaps / unit.length])
        # Numba has different types for arrays that may be written and for constants.
        constants.setflags(write=False)
        return constants


def adhesive_law(impact: Impact, elements: int | None, max_depth: float | None) -> AdhesiveContactLaw:
    """Return the law of an impact with adhesion; see `contact_law`."""
    if impact.shape:
        raise InputError("impact", rule=f"must be single with adhesion, but has shape {impact.shape}")
    count = _ELEMENTS if elements is None else whole("elements", elements, _FEWEST, _LARGEST)
    if cause := unresolved(impact):
        raise SolverError(Status.NOT_ACCURATE, cause=cause)
    problem = problem_of(impact)
    width, time = scales(problem)
    if not math.isfinite(width):
        raise SolverError(Status.TOO_DEEP)
    width, reached, lift = _extent(problem, width, time)
    reach = float(np.asarray(problem.body.adhesion.range))
    deepest = _DEEPER * reached - reach
    if max_depth is not None:
        deepest = float(single("max_depth", finite("max_depth", max_depth, "m")))
    if deepest <= -reach:
        raise InputError("max_depth", max_depth, f"must be > {-reach:.6g} m, where the attraction begins", "m")
    gaps = _gaps(problem, width / count, max(deepest + reach, reached) * lift)
    return AdhesiveContactLaw(
        impact, problem.body.modulus, gaps.size, deepest, None, elements=count, _problem=problem, _width=width,
        _gaps=gaps,
    )  # fmt: skip


def _extent(problem: Problem, width: float, time: float) -> tuple[float, float, float]:
    """Return the largest radius [m] of the zone, the way [m] from the first attraction to the largest depth, a lift.

    The lift is the undeformed gap at the edge over the way. It falls with the depth, as attraction lifts the surface
    less than in proportion. A body that sticks swings about the depth at which it comes to rest; its march ends
    before.
    """
    from restitution.kernel.zone import HELD

    body, march = problem.body, problem.march(width, time, _COARSE)
    reach = float(np.asarray(body.adhesion.range))
    reached = float(march.motion[:, 1].max(initial=0.0)) + reach
    lift, static = float(body.profile.transform(width)) / reached, float(body.modulus.equilibrium_modulus)
    if static > 0.0:
        held = rest(body.profile, static, body.adhesion, width)
        if held.depth + reach > reached:
            reached = held.depth + reach
            width = max(width, held.edge) if march.end == HELD else width
            lift = max(lift, float(body.profile.transform(held.edge)) / reached)
    return width, reached, lift


def _gaps(problem: Problem, cell: float, highest: float) -> Array:
    """Return the gaps [m] of elements up to the highest one, if the profile goes as far, and some more."""
    profile = problem.body.profile
    places = cell * np.arange(_MOST)
    places = places[places <= 0.99 * float(np.asarray(profile.max_contact_radius))]
    gaps = np.asarray(profile.transform(places))
    return gaps[: int(_BEYOND * np.searchsorted(gaps, highest)) + 8].copy()
