"""Tapping of a cantilever on a viscoelastic surface: amplitude, phase, forces and loss over the distance."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from restitution.checks import Array, finite, function, whole, within
from restitution.contact.geometry import Contact, Geometry
from restitution.errors import InputError
from restitution.indentation.cantilever import Cantilever, CantileverMode, Pull, cantilever, pull_of
from restitution.indentation.drive import Drive
from restitution.indentation.history import History
from restitution.indentation.panels import Grip, PanelSolution
from restitution.indentation.solid import solid_of
from restitution.indentation.solve import contact_of
from restitution.indentation.steady import Mixture, Past, Recovery, Trial
from restitution.indentation.surface import Imprint
from restitution.material.viscoelastic import Material
from restitution.parallel import checkpoint
from restitution.quantities import NUMBER, Quantity, dataset
from restitution.result import Outcome, Result, Summary, Table
from restitution.units import ANGLE, ENERGY, FORCE, LENGTH, in_words

if TYPE_CHECKING:
    import xarray

# Change of amplitude from tap to tap over the free amplitude, at which taps are periodic: of rtol.
_PERIODIC = 0.1
_CONFIRMED = 3
# Past taps from which the next start is extrapolated.
_MEMORY = 8
# Least and largest number of first taps on the surface as it is, and their change at which that of a steady motion is
# put in its place.
_PLAIN, _MOST_PLAIN, _BEGIN = 4, 60, 1e-3
# Depths in contact that are extrapolated.
_SAMPLES = 8
# Distance over the free amplitude from which on a first oscillation is as large.
_LEAST_TOUCHING = 0.05
# Distances between two taps to which a third one is extrapolated, over that of the first two.
_AHEAD = 1.5
# Error of a surface that is not yet steady, over the change of the tap before.
_SURFACE = 1e-3
# Tolerance of taps that are not yet periodic, over the change of the one before, and the largest one.
_EARLY, _COARSE = 1e-2, 1e-5
# Tolerance of taps that are not yet periodic, over the gap between the tip and an imprint of nearly its own shape.
_OF_GAP = 1e-4
# Panels under load are not merged, and each tap on a liquid that sinks leaves a ring: a tap costs more and more.
_MOST_PANELS = 1000
_LEAST_SCALE = 1e-3

COLUMNS = {
    "distance": Quantity("distance", LENGTH, "distance of the resting tip", "$D$"),
    "amplitude": Quantity("amplitude", LENGTH, "amplitude", "$A$"),
    "phase": Quantity("phase", ANGLE, "phase to the drive", r"$\phi$"),
    "contact_share": Quantity("contact_share", NUMBER, "share of the period in contact", ""),
    "max_force": Quantity("max_force", FORCE, "largest force", r"$F_\mathrm{max}$"),
    "mean_force": Quantity("mean_force", FORCE, "mean force", r"$\bar F$"),
    "max_indentation_depth": Quantity("max_indentation_depth", LENGTH, "largest indentation", r"$d_\mathrm{max}$"),
    "dissipated": Quantity("dissipated", ENERGY, "loss per tap", r"$E_\mathrm{tap}$"),
}

MODES = {
    "mode_amplitude": Quantity("mode_amplitude", LENGTH, "amplitude of a mode", "$A_n$"),
    "mode_phase": Quantity("mode_phase", ANGLE, "phase of a mode to the drive", r"$\phi_n$"),
    "mode_swing": Quantity("mode_swing", LENGTH, "half of the way of a mode", ""),
}
"""Numbers of each mode of the cantilever."""


class TappingStatus(Outcome):
    """How the taps at one distance ended, with a `message` for each member."""

    PERIODIC = 0, "one tap is like the other"
    FREE = 1, "the tip does not reach the surface"
    NOT_PERIODIC = 2, "the taps had not become periodic; the numbers are those of the last one"
    NOT_SOLVED = 3, "a tap could not be solved; the numbers are NaN"
    CROWDED = 4, "the surface keeps too many traces of earlier taps; the numbers are those of the last one"

    @property
    def failed(self) -> bool:
        """Whether there are no numbers."""
        return self == TappingStatus.NOT_SOLVED


@dataclass(frozen=True, eq=False, repr=False)
class Tapping(Result):
    """Tapping over the distance, arrays of shape (n,), in SI.

    `plot` shows amplitude, phase, force and loss over the distance.

    Attributes
    ----------
    distance : array
        Distance D [m] of the resting tip from the undeformed surface.
    amplitude : array
        Amplitude A [m] of the first harmonic of the tip, `z = A cos(w t + phase)` with the drive `cos(w t)`.
    phase : array
        [rad]; -pi/2 for free oscillation in resonance.
    contact_share : array
        Share of the period in contact [-].
    max_force, mean_force : array
        Largest and mean contact force [N].
    max_indentation_depth : array
        Largest depth of the tip below the undeformed surface [m].
    dissipated : array
        Work [J] that the tip does on the surface in a period.
    mode_amplitude, mode_phase : array, shape (n, modes)
        Amplitude [m] and phase [rad] of the first harmonic of each mode of the cantilever, the first mode first.
    mode_swing : array, shape (n, modes)
        Half of the way [m] between the highest and the lowest place of each mode in a period.
    status : array of int
        `TappingStatus` of each distance.
    taps : array of int
        Number of taps that were computed.
    free_amplitude : float
        Amplitude [m] without a surface.
    contact : Contact
        Materials and profile.
    """

    _numbers = (*COLUMNS, *MODES, "status", "taps", "free_amplitude")
    _picture = "oscillation.tapping_curves"

    distance: Array
    amplitude: Array
    phase: Array
    contact_share: Array
    max_force: Array
    mean_force: Array
    max_indentation_depth: Array
    dissipated: Array
    mode_amplitude: Array
    mode_phase: Array
    mode_swing: Array
    status: NDArray[np.int64]
    taps: NDArray[np.int64]
    free_amplitude: float
    contact: Contact

    def to_dataset(self) -> xarray.Dataset:
        """Return all columns over `distance`, and those of several modes over `mode` too, with units."""
        columns = {name: (getattr(self, name), quantity) for name, quantity in COLUMNS.items()}
        data = dataset("distance", columns, {"free_amplitude": self.free_amplitude})
        if self.mode_amplitude.shape[1] == 1:
            return data
        data = data.assign_coords(mode=np.arange(1, self.mode_amplitude.shape[1] + 1))
        parts = {name: (("distance", "mode"), getattr(self, name), each.attributes) for name, each in MODES.items()}
        return data.assign(parts)

    def summary(self, title: str = "") -> Summary:
        """Return the table of the distances, which `print` and notebooks show."""
        rows = [
            (
                in_words(self.distance[n], LENGTH.unit), in_words(self.amplitude[n], LENGTH.unit),
                f"{math.degrees(self.phase[n]):.3f}", f"{self.contact_share[n]:.4f}",
                in_words(self.max_force[n], FORCE.unit), in_words(self.dissipated[n], ENERGY.unit),
                TappingStatus(int(self.status[n])).name,
            )
            for n in range(self.distance.size)
        ]  # fmt: skip
        heads = ("distance", "amplitude", "phase [deg]", "in contact", "largest force", "loss per tap", "status")
        note = f"free amplitude {in_words(self.free_amplitude, 'm')}"
        return Summary(title or "Tapping", Table(heads, rows), (note,), warnings=self.warnings)

    @property
    def warnings(self) -> list[str]:
        """What keeps numbers from being those of a steady motion, each with its distances."""
        doubtful = [status for status in TappingStatus if status > TappingStatus.FREE]
        places = {status: self.distance[self.status == status] for status in doubtful}
        return [
            f"at {in_words(some[0], LENGTH.unit)}{f' and {some.size - 1} more' * (some.size > 1)}: "
            f"{status.message}"
            for status, some in places.items() if some.size
        ]  # fmt: skip

    @property
    def _short(self) -> str:
        return f"{self.distance.size} distances, free amplitude {in_words(self.free_amplitude, 'm')}"


class Start(NamedTuple):
    """State at the beginning of a period: depth, velocity, the free surface, and the contact if there is one."""

    depth: float
    velocity: float
    imprint: Imprint | None = None
    grip: Grip | None = None
    level: float = 0.0  # depth of the surface at the axis
    gap: float = 1.0  # least gap to a tip that meets the surface there, over the gap to a flat one, away from the axis
    swing: Array = np.zeros((0, 2))  # depths and velocities of higher modes, (M, 2)
    depths: Array | None = None  # depths in contact of the steady motion that has left the surface, if there is one


class Tapper:
    """Taps of one cantilever on one material."""

    def __init__(self, contact: Contact, lever: Cantilever, pull: Pull, rtol: float) -> None:
        self.contact, self.lever, self.pull, self.rtol = contact, lever, pull, rtol
        free = lever.response
        self.amplitude, self.phase = abs(free), math.atan2(free.imag, free.real)
        self.period = 2.0 * math.pi / lever.omega
        solid = solid_of(contact.reduced_modulus)
        self.recoveries = solid.recoveries
        # A liquid sinks for ever.
        self.relaxes = _MEMORY > 1 and solid.viscosity == 0.0 and solid.rates.size > 0 and solid.equilibrium > 0.0
        self.past = Past(max(_MEMORY, 2 * self._scales.size + 1) if _MEMORY > 1 else 1)
        self.recovery = Recovery(rtol)
        self._times: Array | None = None
        self._steady: list[tuple[float, Array, PanelSolution]] = []
        self.count = 0

    def run(self, distance: float, start: Start, periods: int = 1, rtol: float = 0.0) -> PanelSolution:
        """Return the motion over a number of periods, which begin where a free tip is highest."""
        lever, profile = self.lever, self.contact.profile
        time = self.period * periods
        history = History(np.array([0.0, time]), np.array([[-lever.stiffness * distance, 0.0]]))
        peak = min(self.amplitude, float(profile.max_depth))
        reach = max(self.amplitude - distance, 0.1 * self.amplitude)
        self.count += periods
        drive = Drive(
            history, False, peak, mass=lever.mass, damping=lever.damping, stiffness=lever.stiffness,
            amplitude=-lever.push, frequency=lever.omega, phase=-self.phase, depth=start.depth,
            velocity=start.velocity, first=0.1 * self.period, scale=min(max(reach / peak, _LEAST_SCALE), 1.0),
            attraction=self.pull.attraction, cutoff=self.pull.cutoff, modes=lever.higher, swing=start.swing,
        )  # fmt: skip
        return PanelSolution(
            profile, self.contact.reduced_modulus, drive, max(rtol, self.rtol), start.imprint, start.grip
        )

    def free(self, distance: float) -> Start:
        """Return a first start: that of an oscillation which nearly touches the surface.

        Of a free one where the surface pulls, and at rest on the surface where that would begin below it. A contact
        that is elastic and short makes the cantilever stiffer, so that its amplitude is the distance.
        """
        lever, swing = self.lever, np.zeros((len(self.lever.modes), 2))
        if self.pull.attraction > 0.0 or not _LEAST_TOUCHING * self.amplitude < distance < self.amplitude:
            return Start(min(-distance - self.amplitude, 0.0), 0.0, swing=swing)
        loss = lever.damping * lever.omega
        stiffness = math.sqrt(max((lever.push / distance) ** 2 - loss * loss, 0.0))
        angle = -math.atan2(loss, stiffness) - self.phase
        height, rate = distance * math.cos(angle), -lever.omega * distance * math.sin(angle)
        return Start(min(-distance - height, 0.0), -rate, swing=swing)

    def end(self, solution: PanelSolution) -> Start:
        """Return the state at the end."""
        depth, rate = solution.end_state
        if not math.isfinite(depth + rate):
            raise InputError("distance", rule="leads to a tap that has no end")
        imprint, grip = solution.imprint, solution.grip
        level = imprint.axis_depth(self.recoveries)
        gap = imprint.gap(self.recoveries) if grip is None else 1.0
        return Start(depth, rate, imprint, grip, level, gap, solution.swing)

    def coordinates(self, state: Start) -> Array:
        """Return depths and velocities of all modes over those of the free oscillation, at their frequencies."""
        first = np.array([[state.depth, state.velocity]]) - state.swing.sum(axis=0)
        return (np.concatenate([first, state.swing]) / self._scales).ravel()

    def moved(self, state: Start, coordinates: Array) -> Start:
        """Return a state with other depths and velocities."""
        modes = coordinates.reshape(-1, 2) * self._scales
        depth, velocity = modes.sum(axis=0).tolist()
        return state._replace(depth=depth, velocity=velocity, swing=modes[1:])

    @property
    def _scales(self) -> Array:
        return self.amplitude * np.column_stack([np.ones_like(self.lever.frequencies), self.lever.frequencies])

    def steady(self, distance: float, start: Start, most: int) -> tuple[PanelSolution, Start, TappingStatus]:
        """Return the last tap, its end, and whether taps have become periodic.

        The start of the next tap is extrapolated from the changes in the last ones (Anderson's method), while the
        surface relaxes. Where each tap has one contact, the surface is the one that a motion leaves if it goes on for
        ever, and depths of this motion in contact are extrapolated too. Plain taps confirm.
        """
        tolerance, first = _PERIODIC * self.rtol, self.count
        confirmed, change = 0, 0.0
        plain, start = start, self._predicted(distance, start)
        while True:
            checkpoint()
            try:
                solution = self.run(distance, start, rtol=min(_COARSE, _EARLY * change, _OF_GAP * start.gap))
                after = self.end(solution)
            except InputError:
                if start is plain or self.count - first >= most:
                    raise
                self.past.forget()
                start = plain
                continue
            x, y = self.coordinates(start), self.coordinates(after)
            depths = self._depths_in_contact(solution, start, after)
            if depths is not None and start.depths is not None:
                x, y = np.append(x, start.depths), np.append(y, depths)
            change = float(np.abs(y - x).max())
            if solution.contact_intervals.size == 0:
                # The surface recovers until the tip touches it.
                change = max(change, abs(after.level - start.level) / self.amplitude)
            confirmed = confirmed + 1 if change <= tolerance else 0
            if confirmed >= _CONFIRMED:
                self._keep(distance, solution, start, after)
                return solution, after, TappingStatus.PERIODIC
            if self.count - first >= most:
                return solution, after, TappingStatus.NOT_PERIODIC
            following = 0 if after.grip is None else after.grip.following.end.size
            if after.imprint is not None and after.imprint.end.size + following > _MOST_PANELS:
                return solution, after, TappingStatus.CROWDED
            settled = self.count - first > _PLAIN and (change < _BEGIN or self.count - first > _MOST_PLAIN)
            if depths is not None and start.depths is None and settled:
                x, y = np.append(x, depths), np.append(y, depths)
            plain = start = after
            # A body in contact has no other depth than this.
            if confirmed > 0 or after.grip is not None:
                continue
            self.past.add(Trial(x, y - x, solution))
            start = self._extrapolated(solution, after, y, _SURFACE * change)

    def _depths_in_contact(self, solution: PanelSolution, start: Start, after: Start) -> Array | None:
        """Return depths over the free amplitude at fixed times in contact; None where a tap has several contacts."""
        if not self.relaxes or start.grip is not None or after.grip is not None:
            return None
        intervals, times = solution.contact_intervals / self.period, self._times
        if intervals.shape[0] == 1 and solution.turning_times.size == 1:
            begin, end = intervals[0]
            if times is None or not begin < times.mean() < end:
                times = self._times = begin + (end - begin) * (np.arange(_SAMPLES) + 0.5) / _SAMPLES
                self.past.forget()
        elif intervals.size > 0 or times is None:
            return None
        depths = solution.scaled_depth(times) * solution.units.length / self.amplitude
        # A tip that does not touch a surface that has sunk so far may be below the undeformed one.
        return depths if depths.max() > 0.0 else None

    def _extrapolated(self, solution: PanelSolution, after: Start, y: Array, error: float) -> Start:
        """Return the start of the next tap."""
        following = self.past.next_start()
        if following is None and y.size == self._scales.size:
            return after
        target, mixture = following or (y, [(1.0, solution)])
        return self._begun(after, target, mixture, solution, error)

    def _begun(self, after: Start, target: Array, mixture: Mixture, solution: PanelSolution, error: float) -> Start:
        """Return a start at extrapolated coordinates, and on the surface that a mixture of motions leaves."""
        here = self.coordinates(after)
        # At most a tenth of the amplitude at once.
        guess = self.moved(after, here + np.clip(target[: here.size] - here, -0.1, 0.1))
        if target.size > here.size:
            imprint = self.recovery.surface(solution, mixture, error)
            if imprint is None:
                self.past.forget()
                return after
            level = imprint.axis_depth(self.recoveries)
            guess = guess._replace(imprint=imprint, level=level, depths=target[here.size :])
        return guess if guess.depth < guess.level else after

    def _keep(self, distance: float, solution: PanelSolution, start: Start, after: Start) -> None:
        """Keep a steady motion, from which that at the next distance is extrapolated."""
        self.past.part()
        depths = self._depths_in_contact(solution, start, after)
        x = self.coordinates(after) if depths is None else np.append(self.coordinates(after), depths)
        self._steady = [*self._steady[-1:], (distance, x, solution)]

    def _predicted(self, distance: float, start: Start) -> Start:
        """Return the start at a distance on the straight line through the last two."""
        if len(self._steady) < 2 or start.grip is not None:
            return start
        (first, x, before), (second, y, solution) = self._steady
        share = (distance - second) / (second - first) if second != first else math.inf
        if x.size != y.size or not 0.0 < share < _AHEAD:
            return start
        return self._begun(start, y + share * (y - x), [(1.0 + share, solution), (-share, before)], solution, _COARSE)


def tap(
    material: Material,
    profile: Geometry,
    distance: ArrayLike,
    *,
    spring_constant: float,
    quality_factor: float,
    frequency: float,
    free_amplitude: float | None = None,
    drive: float | None = None,
    resonance_frequency: float | None = None,
    modes: Sequence[CantileverMode] = (),
    hamaker: float | None = None,
    intermolecular_distance: float = 1.65e-10,
    counter_material: Material | None = None,
    max_taps: int = 1000,
    progress: Callable[[int, int], None] | None = None,
    rtol: float = 1e-8,
) -> Tapping:
    """Return the steady tapping of a cantilever on a viscoelastic surface over the distance.

    Parameters
    ----------
    material : Material
        Material of the surface.
    profile : Geometry
        Profile of the tip, with scalar parameters.
    distance : float or array
        Distances D [m] of the resting tip from the undeformed surface; each begins with the motion and the surface of
        the one before, as in an approach.
    spring_constant : float
        Spring constant k of the cantilever [N/m], > 0.
    quality_factor : float
        Quality factor Q [-], > 0.5.
    frequency : float
        Frequency of the drive [Hz], > 0.
    free_amplitude, drive : float
        Amplitude [m] without a surface, or the force [N] of the drive; exactly one of the two.
    resonance_frequency : float, optional
        Undamped resonance of the cantilever [Hz]; that of the drive by default.
    modes : sequence of CantileverMode
        Higher modes of the cantilever, as from `beam_modes`; none by default. The numbers above are those of the
        first mode.
    hamaker : float, optional
        Hamaker constant H [J] of the van der Waals force between a round tip and the surface; none by default.
    intermolecular_distance : float
        Distance a0 [m] of the atoms in contact.
    counter_material : Material, optional
        Material of the tip; rigid by default.
    max_taps : int
        Largest number of taps at a distance.
    progress : callable, optional
        Called with (distances done, all distances).
    rtol : float
        Error of a tap over its largest depth and force; in [1e-11, 1e-2]. Taps are periodic where the motion changes
        by less than rtol/10 of the free amplitude.

    Returns
    -------
    Tapping
        Amplitude, phase, contact share, forces and loss, with a status for each distance.

    Raises
    ------
    InputError
        If an argument is out of its range or of another type.

    Notes
    -----
    `m z'' + (m w0/Q) z' + k z = P cos(w t) + F(d)` with the depth d = -(D + z) of the tip, m = k/w0^2, and the exact
    contact force of `indent` with all that the surface keeps from the taps before.

    With `modes` the height of the tip is the sum of the heights of all modes, each an oscillator under the same force
    F on the tip; the drive moves the first mode alone, as it is far from the resonances of the others. Amplitude and
    phase are those of the tip; `mode_amplitude` and `mode_phase` those of each mode at the frequency of the drive, and
    `mode_swing` is half of the way of each mode in a period, with all harmonics.

    With `hamaker` the force on the tip is, in the usual form of tapping mode [1]_, `-H R/(6 (g + a0)^2)` at a gap g
    between the tip and the surface, as it then is, and less by `H R/(6 a0^2)` in contact. It acts on the tip alone:
    adhesion that deforms the surface is not modelled, and is small for a stiff surface and a sharp tip (Tabor's number
    below 0.1). Forces and loss are those of both. Where several motions are steady, the curve is on the branch that an
    approach reaches.

    References
    ----------
    .. [1] R. Garcia, R. Perez, Surf. Sci. Rep. 47 (2002) 197-301, equations of the DMT model in section 3.

    Examples
    --------
    >>> import restitution as rs
    >>> solid = rs.Material(rs.PronySeries(0.25, [1.0], [1.0]), bulk=math.inf)
    >>> curve = rs.tap(
    ...     solid, rs.Parabola(1.0), 0.8, spring_constant=1.0, quality_factor=10.0, frequency=0.5 / math.pi,
    ...     free_amplitude=1.0,
    ... )
    >>> print(f"{curve.amplitude[0]:.6f} m, {math.degrees(curve.phase[0]):.4f} deg")
    0.925092 m, -70.3267 deg
    """
    contact = contact_of(material, profile, counter_material)
    if not contact.profile.separable:
        raise InputError("profile", profile, "must have the reduced modulus of the material, for all contact sizes")
    places = np.atleast_1d(np.asarray(finite("distance", distance, "m"), dtype=np.float64)).ravel()
    if (free_amplitude is None) == (drive is None):
        raise InputError("free_amplitude, drive", rule="exactly one of the two must be given")
    if not places.size:
        raise InputError("distance", rule="must have at least one distance")
    within("rtol", rtol, 1e-11, 1e-2)
    most = whole("max_taps", max_taps, 4)
    if progress is not None:
        function("progress", progress, "must be callable with (distances done, all distances)", 2)
    lever = cantilever(spring_constant, quality_factor, frequency, resonance_frequency, free_amplitude, drive, modes)
    pull = pull_of(hamaker, intermolecular_distance, contact.profile)
    tapper = Tapper(contact, lever, pull, rtol)
    columns = {name: np.full(places.size, np.nan) for name in COLUMNS if name != "distance"}
    columns |= {name: np.full((places.size, lever.frequencies.size), np.nan) for name in MODES}
    status, taps = np.zeros(places.size, dtype=np.int64), np.zeros(places.size, dtype=np.int64)
    start: Start | None = None
    for n, place in enumerate(places):
        before = tapper.count
        if place >= tapper.amplitude and not pull.attraction:
            status[n], start = TappingStatus.FREE, None
            numbers = _free_numbers(tapper, float(place))
        else:
            numbers, start, status[n] = _at_distance(tapper, float(place), start, most)
        for name, value in numbers.items():
            columns[name][n] = value
        taps[n] = tapper.count - before
        if progress is not None:
            progress(n + 1, places.size)
    return Tapping(places, **columns, status=status, taps=taps, free_amplitude=tapper.amplitude, contact=contact)


def _at_distance(
    tapper: Tapper, distance: float, start: Start | None, most: int
) -> tuple[dict[str, Any], Start | None, TappingStatus]:
    """Return the numbers at a distance, the state for the next one, and the status."""
    begin = tapper.free(distance) if start is None else start
    try:
        solution, after, status = tapper.steady(distance, begin, most)
    except InputError:
        return {}, None, TappingStatus.NOT_SOLVED
    numbers = numbers_of_tap(tapper, distance, solution)
    return numbers, None if status == TappingStatus.CROWDED else after, status


def _free_numbers(tapper: Tapper, distance: float) -> dict[str, Any]:
    """Return the numbers of a tip that does not reach the surface."""
    numbers: dict[str, Any] = dict.fromkeys(COLUMNS, 0.0)
    del numbers["distance"]
    numbers |= {
        "amplitude": tapper.amplitude,
        "phase": tapper.phase,
        "max_indentation_depth": tapper.amplitude - distance,
    }
    first = np.arange(tapper.lever.frequencies.size) == 0
    of_first = {"mode_amplitude": tapper.amplitude, "mode_phase": tapper.phase, "mode_swing": tapper.amplitude}
    return numbers | {name: np.where(first, value, 0.0) for name, value in of_first.items()}


def numbers_of_tap(tapper: Tapper, distance: float, solution: PanelSolution) -> dict[str, Any]:
    """Return the numbers of a tap."""
    times, weights, (depth, _, force, *swings) = solution.quadrature()
    higher = -np.array(swings).reshape(-1, times.size)
    heights = np.concatenate([-(depth + distance)[None], higher])
    # The drive is cos(w t - free phase) here.
    waves = weights * np.exp(1j * (tapper.phase - tapper.lever.omega * times))
    tip, *parts = 2.0 / tapper.period * heights @ waves
    harmonics = np.array([tip - sum(parts), *parts])
    intervals = np.minimum(solution.contact_intervals, solution.history.stop)
    return {
        "amplitude": abs(tip),
        "phase": math.atan2(tip.imag, tip.real),
        "contact_share": float(np.sum(intervals[:, 1] - intervals[:, 0])) / tapper.period,
        "max_force": solution.largest(2),
        "mean_force": float(np.sum(weights * force)) / tapper.period,
        "max_indentation_depth": solution.largest(0),
        "dissipated": solution.work,
        "mode_amplitude": np.abs(harmonics),
        "mode_phase": np.angle(harmonics),
        "mode_swing": solution.swings,
    }
