"""Marches of one adhesive contact with N elements: scaled for the kernel, and back to SI."""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np

from restitution.checks import Array
from restitution.contact.adhesion import Adhesion, require_smooth
from restitution.contact.geometry import Contact
from restitution.contact.profiles import Profile, as_profile
from restitution.errors import InputError
from restitution.indentation.solid import compliance_of
from restitution.material.prony import PronySeries

# Elements of the first march that counts, and of the finest.
FEWEST, MOST = 100, 6400
# Room beyond the largest zone, and jumps that are kept.
ROOM, _JUMPS = 1.3, 256
# Share of the room that the largest zone takes at least, and factor of a zone that was too small.
FILLED, WIDER = 0.6, 1.6


class Jump(NamedTuple):
    """Jump of the attraction at a fixed depth [m] and time [s]: radii [m] before and after, and its energy [J]."""

    time: float
    indentation_depth: float
    zone_radius: float
    contact_radius: float
    zone_radius_after: float
    contact_radius_after: float
    energy: float

    @property
    def inward(self) -> bool:
        """Whether the attraction grows: a jump into contact."""
        return self.zone_radius_after > self.zone_radius


class March(NamedTuple):
    """Result of one march in SI.

    `end` is that of the kernel. `motion` has the columns time, depth, velocity, force, edge of the zone, contact
    radius, energy dissipated, energy lost in jumps. `left` is the energy of surface, attraction and body at the end
    over that far apart.
    """

    end: int
    motion: Array
    jumps: tuple[Jump, ...]
    left: float

    @property
    def widest(self) -> float:
        """Largest radius [m] of the zone."""
        return float(self.motion[:, 4].max(initial=0.0))

    @property
    def duration(self) -> float:
        """Time [s] of the last step."""
        return float(self.motion[-1, 0]) if self.motion.size else 0.0


class Sticky(NamedTuple):
    """Contact of one adhesive body in SI."""

    profile: Profile
    modulus: PronySeries
    adhesion: Adhesion

    def march(self, width: float, time: float, count: int, *, mass: float, velocity: float) -> March:
        """March from the first attraction on, with elements ``width/count`` apart and steps of at most ``time/count``.

        `width` [m] is the largest radius of the zone, `time` [s] the duration, `velocity` [m/s] that at the start.
        """
        from restitution.kernel import adhesion as kernel

        scaled = _Scaled(self, width, time)
        bodies, room = scaled.begin(count, mass, 24 * count)
        end = kernel.march(scaled.solid, bodies, velocity * time / width, room)
        return scaled.result(end, room)

    def follow(self, width: float, knots: Array, rates: Array, count: int) -> March:
        """March with constant rates [m/s] between knots [s], the first of them that of the first attraction."""
        from restitution.kernel import adhesion as kernel

        start, time = float(knots[0]), float(knots[-1] - knots[0])
        scaled = _Scaled(self, width, time)
        bodies, room = scaled.begin(count, math.inf, 12 * count * (1 + rates.size))
        end = kernel.follow(scaled.solid, bodies, (knots - start) / time, rates * (time / width), room)
        march = scaled.result(end, room)
        march.motion[:, 0] += start
        return march._replace(jumps=tuple(jump._replace(time=jump.time + start) for jump in march.jumps))


def sticky(contact: Contact, adhesion: Adhesion) -> Sticky:
    """Return the contact of a single body with adhesion; refuse what the theory does not have."""
    profile = as_profile(contact.profile, "adhesion")
    require_smooth(profile)
    modulus = contact.reduced_modulus
    if float(modulus.parallel_viscosity) > 0.0:
        raise InputError("material", rule="must have no parallel dashpot with adhesion, as jumps would take time")
    return Sticky(profile, modulus, adhesion)


class _Scaled:
    """Numbers of a contact over the width of its zone, a time, and the instantaneous modulus."""

    def __init__(self, body: Sticky, width: float, time: float) -> None:
        from restitution.kernel.adhesion import Solid

        self.body, self.length, self.time = body, width, time
        compliance, weights, rates = compliance_of(body.modulus)
        self.modulus = 1.0 / compliance
        self.solid = Solid(1.0, weights * (self.modulus * time), rates * time)

    def begin(self, count: int, mass: float, steps: int) -> tuple[Any, Any]:
        """Return the numbers of the bodies and the room of a march."""
        from restitution.kernel.adhesion import G_, Bodies, allocate_room

        cell = 1.0 / count
        places = cell * np.arange(int(ROOM * count) + 8)
        room = allocate_room(places.size, self.solid.rates.size, steps, _JUMPS)
        room.nodes[G_] = np.asarray(self.body.profile.transform(places * self.length)) / self.length
        stress, reach = (float(np.asarray(value)) for value in (self.body.adhesion.stress, self.body.adhesion.range))
        inertia = mass / (self.modulus * self.length * self.time**2)
        return Bodies(stress / self.modulus, reach / self.length, inertia, cell, cell), room

    def result(self, end: int, room: Any) -> March:
        """Return the result of a march in SI."""
        from restitution.kernel.adhesion import JUMPED_, LEFT_, STEPS_

        time, length = self.time, self.length
        force = self.modulus * length**2
        energy = force * length
        motion = room.motion[: room.counts[STEPS_]] * [
            time, length, length / time, force, length, length, energy, energy
        ]  # fmt: skip
        jumps = room.jumps[: room.counts[JUMPED_]] * [time, *[length] * 5, energy]
        left = float(room.ends[LEFT_]) * energy
        return March(int(end), motion, tuple(Jump(*row) for row in jumps.tolist()), left)
