"""Marches of one adhesive contact with N elements: scaled for the kernel, and back to SI."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from restitution.checks import Array
from restitution.contact.adhesion import Adhesion, require_near, require_smooth
from restitution.contact.geometry import Contact
from restitution.contact.profiles import Profile, as_profile
from restitution.errors import InputError
from restitution.indentation.solid import branches_of, compliance_of
from restitution.material.prony import PronySeries
from restitution.parallel import checkpoint

# Elements of the first march that counts, and of the finest. Where the attracted ring is thin: elements within it that
# the first march needs, the number of the finest march over this need, and the largest number.
FEWEST, MOST, _RINGED, _FINEST, _LARGEST = 100, 12800, 0.25, 16, 409600
# Changes of elements in the longest march of an impact: some seconds. Elements beside the ring that change in a step.
_WORK, _BESIDE = 1.5e9, 30
# Elements in such a ring from which on all marches of a sequence have the form of the gap at the edge.
_RESOLVED = 5.0
# Cells in such a ring from which on its creep is resolved.
_COVERED = 1.0
# Width that elements are scaled by, over the largest radius of the zone in a coarse march.
SPARE = 1.02
# Room beyond the largest zone, and jumps that are kept.
ROOM, _JUMPS = 1.3, 256
# Rows of the motion for each element, and for each further element of a fine march.
_ROWS, _FINE_ROWS = 24, 6
# Changes of elements in one call of the kernel: some tenths of a second.
_PIECE = 10_000_000
# Fewest steps of a call, where most elements wait.
_SHORTEST = 50
# Share of the room that the largest zone takes at least, and factor of a zone that was too small.
FILLED, WIDER = 0.6, 1.6


class Jump(NamedTuple):
    """Jump of the attraction at a time [s]: depth and radii [m] before and after, and its energy [J].

    The depth stays, unless the body is held by a spring or a force. A force that takes the body away has a depth of
    -inf and an energy of NaN behind it.
    """

    time: float
    indentation_depth: float
    zone_radius: float
    contact_radius: float
    zone_radius_after: float
    contact_radius_after: float
    energy: float
    indentation_depth_after: float

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


class Program(NamedTuple):
    """Straight lines between knots [s]: depths [m], depths of the base of a spring [m], or forces [N].

    The stiffness [N/m] is that of the spring, 0 for a force, None for a depth.
    """

    knots: Array
    values: Array
    stiffness: float | None = None


class Load(NamedTuple):
    """Constant force [N] towards the surface, and the least energy [J] that a body may have and leave.

    The energy includes that of the force, which is 0 at the first attraction.
    """

    force: float
    floor: float


UNLOADED = Load(0.0, 0.0)


class Sticky(NamedTuple):
    """Contact of one adhesive body in SI."""

    profile: Profile
    modulus: PronySeries
    adhesion: Adhesion

    @property
    def ring(self) -> float:
        """Width [m] of a thin attracted ring around a contact on the glass: ``pi h0 E0/(8 sigma0)``."""
        reach, stress = (float(np.asarray(value)) for value in (self.adhesion.range, self.adhesion.stress))
        return math.pi * reach * float(self.modulus.instantaneous_modulus) / (8.0 * stress)

    def counts(self, width: float, time: float) -> tuple[int, int]:
        """Return the number of elements of the first march, and of the finest, for a largest zone [m] and a time [s].

        A ring thinner than a cell has the right work, but loads its material too slowly. Relaxation times below a step
        would not see this, unless the ring is resolved.
        """
        ring = _RINGED * width / self.ring
        fastest = time / float(self.modulus.relaxation_times.min(initial=math.inf))
        first, most = (2 ** math.ceil(math.log2(max(need / FEWEST, 1.0))) for need in (min(ring, fastest), ring))
        return FEWEST * first, min(max(MOST, _FINEST * FEWEST * most), _LARGEST)

    def affordable(self, width: float) -> int:
        """Return the largest number of elements whose march takes some seconds, for a largest zone [m].

        Elements outside of the ring wait. Relaxation times far below the contact time make it thinner than on the
        glass, so that it may need more elements than `counts` has.
        """
        modes, count = self.modulus.relaxation_times.size, MOST
        while 2 * count <= _LARGEST:
            touched = min(self.ring / width, 1.0) * 2 * count + _BESIDE
            if 2 * (2 * count) * touched * (modes + 2) > _WORK:
                break
            count *= 2
        return count

    def resolves(self, width: float, count: int) -> bool:
        """Return whether elements ``width/count`` apart resolve the form of the gap in the attracted ring."""
        return self.ring * count >= _RESOLVED * width

    def transit(self, width: float, time: float, count: int) -> float:
        """Return the share of its load by which a ring thinner than a cell creeps while it passes an element.

        Such a ring has no elements, so that its material is that of the glass. `time` [s] is that of the impact.
        """
        if self.ring * count >= _COVERED * width:
            return 0.0
        modulus = self.modulus
        rate = float(np.sum(modulus.branch_moduli / modulus.relaxation_times)) / float(modulus.instantaneous_modulus)
        return rate * time * self.ring / width

    def march(
        self, width: float, time: float, count: int, *, mass: float, velocity: float, load: Load = UNLOADED,
        bends: bool = False, graded: bool = False,
    ) -> March:  # fmt: skip
        """March from the first attraction on, with elements ``width/count`` apart and steps of at most ``time/count``.

        `width` [m] is the largest radius of the zone, `time` [s] the duration, `velocity` [m/s] that at the start.
        A load acts towards the surface.
        With `graded` elements they are denser where the fronts turn, which is at ``width/SPARE``.
        With `bends` gaps have a form at the edge that takes a ring of some elements.
        """
        from restitution.kernel import adhesion as kernel
        from restitution.kernel import zone

        scaled = _Scaled(self, width, time)
        bodies, room = scaled.begin(count, mass, _ROWS * min(count, MOST) + _FINE_ROWS * max(count - MOST, 0), graded)
        room.counts[zone.BENDS_] = int(bends)
        speed = velocity * time / width
        push = scaled.modulus * width**2
        bodies, floor = bodies._replace(load=load.force / push), load.floor / (push * width)
        return scaled.result(
            self._whole(room, lambda most: kernel.march(scaled.solid, bodies, speed, floor, most, room)), room
        )

    def follow(self, width: float, program: Program, count: int) -> March:
        """March along a program of straight lines, from the first attraction on."""
        from restitution.kernel import adhesion as kernel
        from restitution.kernel import zone

        knots, values, stiffness = program
        start, time = float(knots[0]), float(knots[-1] - knots[0])
        scaled = _Scaled(self, width, time)
        bodies, room = scaled.begin(count, math.inf, 12 * count * (1 + values.size))
        scaled_values = values / width
        if stiffness is not None:
            soft = stiffness / (scaled.modulus * width)
            scaled_values = scaled_values * soft if stiffness else values / (scaled.modulus * width**2)
            bodies = bodies._replace(sprung=True, stiffness=soft)
            # Each trial of a depth asks all elements for their force.
            room.counts[zone.WAITS_] = 0
        times = (knots - start) / time
        end = self._whole(room, lambda most: kernel.follow(scaled.solid, bodies, times, scaled_values, most, room))
        march = scaled.result(end, room)
        # Rounding must not end it beyond the history.
        march.motion[:, 0] = np.minimum(march.motion[:, 0] + start, knots[-1])
        return march._replace(jumps=tuple(jump._replace(time=jump.time + start) for jump in march.jumps))

    def _whole(self, room: Any, march: Callable[[int], int]) -> int:
        """March in pieces of less than a second."""
        from restitution.kernel.zone import PAUSED

        modes, elements = room.memory.shape
        most = max(_PIECE // (elements * (modes + 2)), _SHORTEST)
        while (end := march(most)) == PAUSED:
            checkpoint()
        return end


def sticky(contact: Contact, adhesion: Adhesion) -> Sticky:
    """Return the contact of a single body with adhesion; refuse what the theory does not have."""
    profile = as_profile(contact.profile, "adhesion")
    require_smooth(profile)
    require_near(profile, adhesion)
    modulus = contact.reduced_modulus
    if float(modulus.parallel_viscosity) > 0.0:
        raise InputError("material", rule="must have no parallel dashpot with adhesion, as jumps would take time")
    return Sticky(profile, modulus, adhesion)


def peak(motion: Array, values: Array, kinks: ArrayLike = ()) -> tuple[float, float]:
    """Return the largest value along a motion, from a parabola where it has no kink, and the error of the parabola.

    The parabola is over the length of the way in time and edge: near a fold all numbers are smooth over the edge, and
    like a square root over the time. Its error is the difference from a parabola through the second neighbours. Where
    bodies touch or part beside it the motion has a corner, and the value lies between the largest row and the corner.
    """
    time, n = motion[:, 0], int(np.argmax(values))
    largest = float(values[n])
    if np.any(np.abs(time[n] - kinks) <= 1e-9 * abs(time[-1])):
        return largest, 0.0
    half = 0.5 * (_corner(motion, values, n) - largest)
    if half > 0.0:
        return largest + half, half
    near, far = (_top(motion, values, n, distance) for distance in (1, 2))
    # Two parabolas may agree by chance.
    return near, max(abs(near - far) if far > largest else 0.0, 0.5 * (near - largest))


def _corner(motion: Array, values: Array, n: int) -> float:
    """Return where the lines before and behind a touch meet, beside a largest value; NaN without a touch there."""
    time, touches = motion[:, 0], motion[:, 5] > 0.0
    for k in (n - 1, n):
        if 1 <= k < values.size - 2 and touches[k] != touches[k + 1] and np.diff(time[k - 1 : k + 3]).min() > 0.0:
            rise, fall = ((values[j + 1] - values[j]) / (time[j + 1] - time[j]) for j in (k - 1, k + 1))
            length = time[k + 1] - time[k]
            if rise > fall:
                way = (values[k + 1] - values[k] - fall * length) / (rise - fall)
                return float(values[k] + rise * min(max(way, 0.0), length))
    return math.nan


def _top(motion: Array, values: Array, n: int, distance: int) -> float:
    """Return the top of the parabola through a largest value and its neighbours; the value itself beside a jump."""
    largest = float(values[n])
    if not distance <= n < values.size - distance:
        return largest
    around = slice(n - distance, n + distance + 1, distance)
    steps = np.diff(motion[n - distance : n + distance + 1, 0])
    before, after = np.hypot(np.diff(motion[around, 0]) / np.ptp(motion[:, 0]),
                             np.diff(motion[around, 4]) / motion[:, 4].max())  # fmt: skip
    rises, falls = largest - values[n - distance], largest - values[n + distance]
    # A jump takes no time, and differs by more than its neighbours do.
    if steps.min() <= 0.0 or max(rises, falls) > 0.05 * distance**2 * abs(largest):
        return largest
    bend = (rises / before + falls / after) / (before + after)
    slope = (rises / before * after - falls / after * before) / (before + after)
    return largest + 0.25 * float(slope * slope / bend) if bend > 0.0 else largest


def _places(count: int, graded: bool) -> Array:
    """Return places of elements over the width of a zone, up to `ROOM`; graded ones are denser where its fronts turn.

    Loads have the form of a root of the distance from there, which is linear in the number of a graded element.
    """
    if not graded:
        return np.arange(int(ROOM * count) + 8) / count
    beyond = SPARE * ROOM - 1.0
    steps = np.arange(int((1.0 + 0.5 * (beyond + math.sqrt(beyond))) * count / SPARE) + 8) / count
    ahead = SPARE * steps - 1.0
    root = np.sqrt(0.25 + 2.0 * np.abs(ahead)) - 0.5
    return (1.0 + np.sign(ahead) * root**2) / SPARE


class _Scaled:
    """Numbers of a contact over the width of its zone, a time, and the instantaneous modulus."""

    def __init__(self, body: Sticky, width: float, time: float) -> None:
        from restitution.kernel.zone import Solid

        self.body, self.length, self.time = body, width, time
        compliance, weights, rates = compliance_of(body.modulus)
        self.modulus = 1.0 / compliance
        self.solid = Solid(1.0, weights * (self.modulus * time), rates * time)
        self.branches, self.bridge = branches_of(body.modulus)

    def begin(self, count: int, mass: float, steps: int, graded: bool = False) -> tuple[Any, Any]:
        """Return the numbers of the bodies and the room of a march."""
        from restitution.kernel import zone

        places = _places(count, graded)
        room = zone.allocate_room(places, self.solid.rates.size, steps, _JUMPS)
        gaps = np.asarray(self.body.profile.transform(places * self.length)) / self.length
        room.nodes[zone.G_], share = gaps, room.nodes[zone.SHARE_]
        for row, part in ((zone.SUM_, share), (zone.SUM_G_, share * gaps), (zone.SUM_GG_, share * gaps**2)):
            room.nodes[row, 1:] = np.cumsum(part[:-1])
        moduli, rates, creep = self.branches
        room.branches[:, zone.MODULUS_], room.branches[:, zone.PACE_] = moduli / self.modulus, rates * self.time
        room.branches[:, zone.CREEP_], room.bridge[...] = creep / (self.modulus * self.time), self.bridge / self.time
        room.ends[zone.FIRM_] = float(self.body.modulus.equilibrium_modulus) / self.modulus
        room.counts[zone.WAITS_] = 1
        stress, reach = (float(np.asarray(value)) for value in (self.body.adhesion.stress, self.body.adhesion.range))
        largest = float(np.diff(places).max())
        inertia = mass / (self.modulus * self.length * self.time**2)
        return zone.Bodies(
            stress / self.modulus, reach / self.length, inertia, largest, 1.0 / count, False, 0.0, 0.0, 0.0
        ), room

    def result(self, end: int, room: Any) -> March:
        """Return the result of a march in SI."""
        from restitution.kernel.zone import JUMPED_, LEFT_, STEPS_

        time, length = self.time, self.length
        force = self.modulus * length**2
        energy = force * length
        motion = room.motion[: room.counts[STEPS_]] * [
            time, length, length / time, force, length, length, energy, energy
        ]  # fmt: skip
        jumps = room.jumps[: room.counts[JUMPED_]] * [time, *[length] * 5, energy, length]
        left = float(room.ends[LEFT_]) * energy
        return March(int(end), motion, tuple(Jump(*row) for row in jumps.tolist()), left)
