"""The contact law with adhesion: force over the history of a depth, step by step."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any, NamedTuple

import numpy as np

from restitution.checks import Array, finite, single, single_positive, whole
from restitution.errors import InputError
from restitution.impact.adhesive import problem_of, too_thin
from restitution.impact.dugdale import scales
from restitution.impact.problem import Impact
from restitution.impact.status import SolverError, Status
from restitution.indentation.attraction import ROOM, Sticky
from restitution.indentation.solid import compliance_of

# Fewest and most elements of the law, rows of one call of the kernel, and room beyond the largest zone.
_FEWEST, _LARGEST, _ROWS, _WIDER = 10, 2000, 512, 1.6
_MOST = 8 * _LARGEST


class _Units(NamedTuple):
    """Length [m], time [s] and force [N] of 1 in the kernel."""

    length: float
    time: float
    force: float


@dataclass(eq=False)
class AdhesiveState:
    """State of one contact with adhesion; made by `AdhesiveContactLaw.start`.

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
    law : AdhesiveContactLaw
        The law that started the contact.
    room : object
        Elements and their memory; None before the attraction.
    """

    law: AdhesiveContactLaw = field(repr=False)
    depth: float
    force: float = 0.0
    zone_radius: float = 0.0
    contact_radius: float = 0.0
    dissipated_energy: float = 0.0
    jump_energy: float = 0.0
    room: Any = field(default=None, repr=False)

    def copy(self) -> AdhesiveState:
        """Return a copy of the contact."""
        room = None if self.room is None else type(self.room)(*(np.copy(part) for part in self.room))
        numbers = (self.depth, self.force, self.zone_radius, self.contact_radius)
        return AdhesiveState(self.law, *numbers, self.dissipated_energy, self.jump_energy, room)


@dataclass(frozen=True, eq=False)
class AdhesiveContactLaw:
    """Contact law with adhesion and memory, made by `adhesive_contact_law`.

    Attributes
    ----------
    impact : Impact
        The impact for which the law was made.
    elements : int
        Number of elements within the largest zone of that impact.

    Examples
    --------
    >>> import restitution as rs
    >>> polymer = rs.standard_solid(1e9, 1e9, 20.0, poisson_ratio=0.35)
    >>> sticky = rs.Adhesion(0.05, stress=1e7)
    >>> grain = rs.Impact(polymer, rs.Parabola(5e-6), mass=2.5e-12, velocity=0.2, adhesion=sticky)
    >>> law = rs.adhesive_contact_law(grain)
    >>> state = law.start()
    >>> [law.step(state, depth, dt=1e-8) < 0.0 for depth in (-4e-9, -2e-9)]
    [True, True]
    """

    impact: Impact
    elements: int
    _body: Sticky = field(repr=False)
    _width: float = field(repr=False)

    def start(self, *, depth: float | None = None) -> AdhesiveState:
        """Return the state of a contact before the attraction, at a depth [m] <= -h0; by default -h0, its range."""
        reach = self._reach
        if depth is None:
            return AdhesiveState(self, -reach)
        value = float(single("depth", finite("depth", depth, "m")))
        if value > -reach:
            raise InputError("depth", depth, f"must be <= {-reach:.6g} m, where the attraction begins", "m")
        return AdhesiveState(self, value)

    def step(self, state: AdhesiveState, depth: float, dt: float) -> float:
        """Take a contact to a depth [m] after a time step [s]; return the force [N], a pull below 0.

        The depth changes linearly over the step, and the attraction jumps at its own instants within. A jump changes
        the impulse of the step by more than the forces at both ends know. So the force is that at the end of the step
        plus a correction of second order, with which the scheme of Verlet has the impulse of the contact.

        Raises
        ------
        InputError
            If the depth is not finite, the step not positive, or the state that of another law.
        SolverError
            If the attraction cannot be followed.
        """
        if not isinstance(state, AdhesiveState) or state.law is not self:
            raise InputError("state", rule="must be one that this law has started")
        end = float(single("depth", finite("depth", depth, "m")))
        step = float(single_positive("dt", dt, "s"))
        begins, before, unit = 0.0, state.force, self._units
        if state.room is None:
            reach = self._reach
            if end <= -reach:
                state.depth = end
                return 0.0
            begins = step * (-reach - state.depth) / (end - state.depth)
            state.depth, state.room = -reach, self._room(int(ROOM * self.elements) + 8)
        lines = np.array([begins, step]) / unit.time, np.array([state.depth, end]) / unit.length
        impulse = self._followed(state, *lines) * unit.force * unit.time
        state.depth = end
        self._read(state)
        return state.force + impulse / step - 0.5 * (before + state.force)

    def _read(self, state: AdhesiveState) -> None:
        """Write the numbers of a contact in SI."""
        from restitution.kernel.zone import A_, C_, F_, JUMPS_, VISCOUS_

        now, unit = state.room.now, self._units
        state.force = float(now[F_]) * unit.force
        state.zone_radius, state.contact_radius = float(now[C_]) * unit.length, float(now[A_]) * unit.length
        energy = unit.force * unit.length
        state.dissipated_energy, state.jump_energy = float(now[VISCOUS_]) * energy, float(now[JUMPS_]) * energy

    @property
    def _reach(self) -> float:
        return float(np.asarray(self._body.adhesion.range))

    @cached_property
    def _units(self) -> _Units:
        """Units of the kernel: the width of the zone, its time at the velocity of the impact, the glass modulus."""
        modulus = 1.0 / compliance_of(self._body.modulus)[0]
        return _Units(self._width, self._width / float(self.impact.velocity), modulus * self._width**2)

    @cached_property
    def _scaled(self) -> tuple[Any, Any]:
        """Return solid and bodies of the kernel."""
        from restitution.kernel.zone import Bodies, Solid

        compliance, weights, rates = compliance_of(self._body.modulus)
        unit, stress = self._units, float(np.asarray(self._body.adhesion.stress))
        solid = Solid(1.0, weights / compliance * unit.time, rates * unit.time)
        reach, cell = self._reach / unit.length, 1.0 / self.elements
        return solid, Bodies(stress * compliance, reach, math.inf, cell, math.inf, False, 0.0, 0.0, 0.0)

    def _room(self, size: int) -> Any:
        """Return room for a number of elements that no attraction has reached."""
        from restitution.kernel.zone import G_, H_, WEIGHED_, allocate_room

        solid, bodies = self._scaled
        room = allocate_room(size, bodies.cell, solid.rates.size, _ROWS, 1)
        places = bodies.cell * np.arange(size) * self._width
        room.nodes[G_] = np.asarray(self._body.profile.transform(places)) / self._width
        room.nodes[H_] = room.nodes[G_] + bodies.reach
        room.counts[WEIGHED_] = size
        return room

    def _followed(self, state: AdhesiveState, knots: Array, values: Array) -> float:
        """Follow a line of the depth; return its impulse, scaled."""
        from restitution.kernel import zone as kernel
        from restitution.kernel.adhesion import follow

        (solid, bodies), room, impulse = self._scaled, state.room, 0.0
        if room.counts[kernel.STEPS_]:
            room.now[kernel.T_], room.counts[kernel.LINE_] = knots[0], 0
            room.motion[0] = room.now
        while True:
            end = follow(solid, bodies, knots, values, _ROWS // 2, room)
            rows = room.motion[: room.counts[kernel.STEPS_]]
            impulse += float(np.trapezoid(rows[:, kernel.F_], rows[:, kernel.T_]))
            # The last row is the first of the next line.
            room.motion[0], room.counts[kernel.STEPS_], room.counts[kernel.JUMPED_] = room.now, 1, 0
            if end == kernel.NO_ROOM:
                state.room = room = self._wider(room)
            elif end in (kernel.STUCK, kernel.NOT_DISC, kernel.TOO_LONG):
                raise SolverError(Status.NOT_ACCURATE, "the attraction cannot be followed")
            elif end != kernel.PAUSED:
                return impulse

    def _wider(self, room: Any) -> Any:
        """Return the room of a wider zone."""
        from restitution.kernel.zone import WEIGHED_

        old = room.nodes.shape[1]
        wider = self._room(int(_WIDER * old))
        if wider.nodes.shape[1] > _MOST or not np.isfinite(wider.nodes).all():
            raise SolverError(Status.TOO_DEEP, "the zone is too wide for the profile or the law")
        wider.nodes[:, :old], wider.memory[:, :old] = room.nodes, room.memory
        for name in ("factors", "now", "counts", "ends", "motion", "jumps"):
            getattr(wider, name)[...] = getattr(room, name)
        wider.counts[WEIGHED_] = wider.nodes.shape[1]
        return wider


def adhesive_contact_law(impact: Impact, *, elements: int = 100) -> AdhesiveContactLaw:
    """Return the contact law with adhesion and memory, for codes that step in time.

    Parameters
    ----------
    impact : Impact
        A single impact with adhesion: its materials, profile and attraction define the law. Its velocity and mass set
        the largest zone, within which the elements lie; a wider zone of another history gets more of them.
    elements : int
        Number of elements, in [10, 2000].

    Returns
    -------
    AdhesiveContactLaw
        With `start` and `step`.

    Raises
    ------
    InputError
        If the impact has no adhesion or is an array, or the number of elements is out of range.
    SolverError
        If the attracted zone is too thin for elements.

    Notes
    -----
    The law is the march of the solver along straight lines of the depth: an element carries the attraction or follows
    the body, both with memory, and the edge of the zone moves or jumps at its own instants within a step. A step has a
    cost of some changes of all elements. e converges at second order in the time step to that of so many elements,
    which errs at second order in their distance.

    Examples
    --------
    >>> import restitution as rs
    >>> polymer = rs.standard_solid(1e9, 1e9, 20.0, poisson_ratio=0.35)
    >>> sticky = rs.Adhesion(0.05, stress=1e7)
    >>> grain = rs.Impact(polymer, rs.Parabola(5e-6), mass=2.5e-12, velocity=0.3, adhesion=sticky)
    >>> exact, law = rs.solve(grain, rtol=1e-4), rs.adhesive_contact_law(grain)
    >>> dt = exact.contact_time / 200
    >>> state = law.start()
    >>> depth, velocity, force = state.depth, 0.3, 0.0
    >>> while True:  # velocity Verlet
    ...     depth += velocity * dt - 0.5 * force / grain.mass * dt**2
    ...     before, force = force, law.step(state, depth, dt)
    ...     velocity -= 0.5 * (before + force) / grain.mass * dt
    ...     if force == 0.0:
    ...         break
    >>> abs(-velocity / 0.3 - exact.restitution_coefficient) < 2e-4
    True
    """
    if not isinstance(impact, Impact) or impact.adhesion is None:
        raise InputError("impact", rule="must be an Impact with adhesion")
    if impact.shape:
        raise InputError("impact", rule=f"must be single, but has shape {impact.shape}")
    count = whole("elements", elements, _FEWEST, _LARGEST)
    if thin := too_thin(impact):
        raise SolverError(Status.NOT_ACCURATE, thin)
    problem = problem_of(impact)
    width, _ = scales(problem)
    if not math.isfinite(width):
        raise SolverError(Status.TOO_DEEP)
    return AdhesiveContactLaw(impact, count, problem.body, width)
