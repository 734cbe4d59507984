"""Measured indentation curves and their first touch."""

from __future__ import annotations

import math
import warnings
from functools import cached_property
from itertools import pairwise
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from restitution import checks
from restitution.checks import Array
from restitution.contact.geometry import Geometry
from restitution.errors import InputError, InputTypeError, RestitutionWarning
from restitution.identification.observations import (
    ForceRecord,
    Noise,
    Nuisance,
    columns_over_time,
    modulus,
    noise_of,
    number_or_none,
)
from restitution.indentation.history import without_collinear
from restitution.indentation.solve import IndentationBlock
from restitution.material.fit import DynamicTable
from restitution.material.prony import PronySeries
from restitution.material.viscoelastic import Material

# First touch of a measured indentation, and straight lines that replace its depth.


# Search for first touch: smallest and largest number of points of the approach, rounds, and depths in each of them.
_FEWEST_ROWS, _MOST, _ROUNDS, _PLACES = 12, 160, 3, 40
# Powers of the force over the depth from touch, relative to an elastic contact; relaxation lowers the power.
_POWERS = (1.0, 0.9, 0.8, 0.65)
# The later rounds use this share of the approach beyond touch.
_NEAR = 0.4
# A slope of the baseline counts if it exceeds this multiple of its standard error.
_DRIFT = 4.0
# A depth of at most so many straight lines is exact. Otherwise: number of first lines, and of rounds of halving.
_FEW, _LINES, _HALVINGS = 64, 24, 6
# A line is halved if the bend in its middle exceeds this multiple of its standard error.
_BEND = 3.0
# Harmless error of a depth over the range of the depth.
_HARMLESS = 5e-5


class Touch(NamedTuple):
    """First touch."""

    depth: float
    noise: float  # standard deviation of the force about the fit


def first_touch(time: Array, depth: Array, force: Array, exponent: float) -> Touch:
    """Return the depth at first touch in the approach: least squares of F = b0 + b1 t + A (d - c)^q over c and q.

    The exponent is that of F over d of an elastic contact.
    """
    # The force relaxes while the depth rests at its largest value.
    last = int(np.argmax(depth >= depth.max() - 0.02 * np.ptp(depth))) + 1
    first = int(np.argmin(depth[:last]))
    points = np.arange(first, last)
    if points.size < _FEWEST_ROWS:
        raise InputError("depth", points.size, f"has too few points in the approach; it needs at least {_FEWEST_ROWS}")
    powers = exponent * np.array(_POWERS)
    peak = float(depth[last - 1])
    lowest, highest = float(depth[min(first + 5, last - 1)]), peak - 0.03 * (peak - float(depth[first]))
    low, high, touch = lowest, highest, Touch(lowest, 0.0)
    for _ in range(_ROUNDS):
        used = points[:: max(1, points.size // _MOST)]
        places = np.linspace(low, high, _PLACES)
        touch = _best(time[used], depth[used], force[used], places, powers)
        # Near touch the material has hardly relaxed, and the force is a power of the depth.
        size, spacing = peak - touch.depth, float(places[1] - places[0])
        near = first + np.flatnonzero(np.abs(depth[first:last] - touch.depth + 0.5 * size) < (0.5 + _NEAR) * size)
        points = near if near.size >= _FEWEST_ROWS else points
        low = max(lowest, touch.depth - max(0.3 * size, 1.5 * spacing))
        high = min(highest, touch.depth + max(0.2 * size, 1.5 * spacing))
    return touch


def _best(t: Array, d: Array, f: Array, places: Array, powers: Array) -> Touch:
    """Return the touch with the smallest sum of squares."""
    lines, _ = np.linalg.qr(np.stack([np.ones(t.size), t - t[0]], axis=1))
    rise = np.maximum(d - places[:, None], 0.0) / (d[-1] - d[0])
    shapes = np.concatenate([rise**power for power in powers])
    within, force_within = shapes @ lines, f @ lines
    along = shapes @ f - within @ force_within
    size = np.einsum("cn,cn->c", shapes, shapes) - np.einsum("cj,cj->c", within, within)
    gain = np.where(along > 0.0, along**2 / np.maximum(size, 1e-12 * size.max()), -np.inf)
    best = int(np.argmax(gain))
    if not np.isfinite(gain[best]):
        raise InputError("force", rule="does not rise with the depth of the approach; is a push positive?")
    rest = f @ f - force_within @ force_within - gain[best]
    return Touch(float(places[best % places.size]), float(np.sqrt(max(rest, 0.0) / max(t.size - 5, 1))))


def baseline(time: Array, force: Array, free: NDArray[np.bool_]) -> Array:
    """Return the baseline of the force without contact: a constant, and a slope if it is beyond its error."""
    if np.count_nonzero(free) < 2:  # the curve is refused after its first touch is known
        return np.full(force.shape, force[0])
    t, f = time[free] - time[free].mean(), force[free]
    spread = float(t @ t)
    slope = float(t @ f) / spread
    error = float(np.std(f - slope * t)) / math.sqrt(spread)
    return f.mean() + (slope if abs(slope) > _DRIFT * error else 0.0) * (time - time[free].mean())


class Lines(NamedTuple):
    """Points joined by straight lines that stand for a measured depth."""

    time: Array
    depth: Array
    noise: float  # standard deviation of the depth about them; 0 where they are exact


def straight_lines(time: Array, depth: Array, kinks: Array) -> Lines:
    """Return straight lines for a measured depth.

    Lines between some of the points where there is hardly any noise. Else those of least squares, which are halved
    until none of them hides a bend that is larger than its standard error; `kinks` are times at which some end.
    """
    exact = without_collinear(time, depth)
    if exact[0].size <= _FEW:
        return Lines(*exact, 0.0)
    share = (time[1:-1] - time[:-2]) / (time[2:] - time[:-2])
    beside = depth[1:-1] - depth[:-2] - share * (depth[2:] - depth[:-2])
    noise = float(np.median(np.abs(beside) / np.sqrt(1.0 + share**2 + (1.0 - share) ** 2))) / 0.6745
    harmless = _HARMLESS * float(np.ptp(depth))
    if noise <= harmless:
        places = _corners(time, depth, harmless)
        return Lines(time[places], depth[places], harmless)
    smooth = np.convolve(depth, np.full(5, 0.2), mode="same")[2:-2]
    top = time[2 + int(np.argmax(smooth))]
    knots = np.unique(np.concatenate([np.linspace(time[0], time[-1], _LINES + 1), kinks, [top]]))
    knots = _occupied(knots, time)
    values = _fit(knots, time, depth)
    for _ in range(_HALVINGS):
        place = np.clip(np.searchsorted(knots, time, side="right") - 1, 0, knots.size - 2)
        share = (time - knots[place]) / (knots[place + 1] - knots[place])
        bump = 1.0 - np.abs(2.0 * share - 1.0)
        off = depth - np.interp(time, knots, values)
        bends = np.bincount(place, bump * off, knots.size - 1)
        errors = noise * np.sqrt(np.bincount(place, bump * bump, knots.size - 1))
        bent = np.flatnonzero(np.abs(bends) > _BEND * np.maximum(errors, 1e-300))
        finer = _occupied(np.sort(np.append(knots, 0.5 * (knots[bent] + knots[bent + 1]))), time)
        if finer.size == knots.size:
            break
        knots, values = finer, _fit(finer, time, depth)
    off = depth - np.interp(time, knots, values)
    return Lines(knots, values, float(np.sqrt(np.mean(off**2))))


def rising_and_falling(lines: Lines, touch: float) -> Lines:
    """Return the same lines, where the depth rises to its peak and falls from there on, without reversals by noise.

    Before touch the depth may have any course; a second approach is refused.
    """
    from scipy.optimize import isotonic_regression

    time, depth = lines.time, lines.depth
    peak = int(np.argmax(depth))
    outside = np.flatnonzero(depth[: peak + 1] < touch)
    first = int(outside[-1]) if outside.size else 0
    monotone = depth.copy()
    monotone[first : peak + 1] = isotonic_regression(depth[first : peak + 1]).x
    monotone[peak:] = isotonic_regression(depth[peak:], increasing=False).x
    allowed = max(5.0 * lines.noise, 20.0 * _HARMLESS * float(np.ptp(depth)))
    off = np.where(np.maximum(monotone, depth) > touch, np.abs(monotone - depth), 0.0)
    if off.max() > allowed:
        rule = "has more than one approach; cut the record so that it holds one approach and one retraction"
        raise InputError("depth", rule=f"{rule}, near time = {time[int(np.argmax(off))]:.6g} s")
    above = (monotone <= touch) & (depth <= touch)
    return Lines(time, np.where(above, depth, monotone), lines.noise)


def _corners(time: Array, depth: Array, allowed: float) -> NDArray[np.intp]:
    """Return places of points whose straight lines are nowhere further than this from the others."""
    places = np.array([0, time.size - 1])
    while True:
        off = np.abs(depth - np.interp(time, time[places], depth[places]))
        worst = [low + int(np.argmax(off[low : high + 1])) for low, high in pairwise(places)]
        more = [place for place in worst if off[place] > allowed]
        if not more:
            return places
        places = np.sort(np.append(places, more))


def _occupied(knots: Array, time: Array) -> Array:
    """Return knots without those that leave fewer than three points on a line."""
    kept = [0]
    places = np.searchsorted(time, knots)
    for n in range(1, knots.size - 1):
        if places[n] - places[kept[-1]] >= 3 and places[-1] - places[n] >= 3:
            kept.append(n)
    return knots[[*kept, knots.size - 1]]


def _fit(knots: Array, time: Array, depth: Array) -> Array:
    """Return values at the knots of the straight lines of least squares."""
    from scipy.linalg import solveh_banded

    place = np.clip(np.searchsorted(knots, time, side="right") - 1, 0, knots.size - 2)
    share = (time - knots[place]) / (knots[place + 1] - knots[place])
    bands = np.zeros((2, knots.size))
    right = np.zeros(knots.size)
    for offset, weight in ((0, 1.0 - share), (1, share)):
        bands[1] += np.bincount(place + offset, weight * weight, knots.size)
        right += np.bincount(place + offset, weight * depth, knots.size)
    bands[0, 1:] = np.bincount(place, share * (1.0 - share), knots.size - 1)
    bands[1] += 1e-9 * bands[1].max()
    return solveh_banded(bands, right + 1e-9 * bands[1].max() * np.interp(knots, time, depth))


# Measured indentation curves, such as those of an atomic force microscope.

# Tolerance of a force: small enough for differences of residuals.
RTOL = 1e-8
# Fewest points before and after first touch.
_FEWEST = 10
# So many equal largest forces show saturation if the depth changes by more than this share of its range.
_EQUAL, _MOVED = 5, 0.02
# A force jumps if it changes by more than this share of its range from one point to the next, but the depth does not.
_JUMP = 0.25
# Standard solids that are tried for a start: shares of the relaxing modulus, and times over the duration.
_SHARES, _TIMES = (0.0, 0.4, 0.8, 0.97), (0.01, 0.04, 0.15, 0.6)
_FREQUENCIES = 6
# Ranges of times, depths and forces in SI whose squares are normal numbers; moduli [Pa] of matter.
_NARROWEST, _WIDEST = 1e-30, 1e30
_SOFTEST, _STIFFEST = 1e-6, 1e15


class IndentationCurve(ForceRecord):
    """Force over depth and time of one approach and perhaps one retraction, with holds.

    The depth reading at first touch (contact point) and the baseline of the force, a straight line over time, are
    unknown.

    Parameters
    ----------
    time : array, shape (n,)
        Times t [s], ascending.
    depth : array, shape (n,)
        Position of the tip [m] from any origin, positive into the surface. With `spring_constant`, the position of the
        base of the cantilever (piezo height), in the same direction.
    force : array, shape (n,)
        Force F on the surface [N], positive for a push.
    profile : Geometry
        Profile of the indenter, or another geometry, such as a pyramid or a layer. A bonded `Layer` needs a model
        with a Poisson ratio of 0.5.
    spring_constant : float, optional
        Spring constant k of a cantilever [N/m] if the depth is that of its base: the tip is at depth - F/k.
    temperature : float, optional
        Temperature [K], for a model with a shift.
    noise : Noise, optional
        Standard deviation of `force`; a relative one refers to its range. Without it the noise is estimated.
    label : str
        Name of the data in messages.

    Raises
    ------
    InputError
        If a number is out of range, the times are not ascending, there are fewer than 10 points before first touch or
        more than one approach, or the force is saturated or jumps.

    Warns
    -----
    RestitutionWarning
        If the depth is noisy and straight lines through it replace it.

    Notes
    -----
    The depth is prescribed as straight lines. They are lines between data points if the data are straight or hardly
    noisy. Otherwise they are lines of least squares, halved until no bend within a line is larger than its standard
    error. Too few lines bias the moduli (by 33 % with 8 lines) without a trace in the residuals. The tip of a soft
    cantilever has the same kind of lines, at depth - F/k with the measured force. The noise of the force then also
    moves the tip: if the contact is a third as stiff as the cantilever, the scatter exceeds the stated errors by a
    fifth.

    Examples
    --------
    >>> import restitution as rs
    >>> gel = rs.standard_solid(70.0, 270.0, 80.0, poisson_ratio=0.5)
    >>> time = np.linspace(0.0, 2.8, 480)
    >>> depth = np.interp(time, [0.0, 1.4, 2.8], [0.0, 1.4e-6, 0.0])
    >>> force = rs.indent(gel, rs.Parabola(2.5e-6), depth=depth - 0.4e-6, time=time).force
    >>> curve = IndentationCurve(time, depth, force, profile=rs.Parabola(2.5e-6), noise=rs.Noise(force="1 %"))
    >>> curve.size, [nuisance.name for nuisance in curve.nuisances]
    (480, ['contact_point'])
    """

    def __init__(
        self,
        time: Any,
        depth: Any,
        force: Any,
        *,
        profile: Geometry,
        spring_constant: Any = None,
        temperature: Any = None,
        noise: Noise | None = None,
        label: str = "",
    ) -> None:
        self.label = label
        if not isinstance(profile, Geometry):
            raise InputTypeError("profile", profile, "must be a Geometry, such as Parabola(radius)")
        # The layer of a contact with an incompressible material; itself if its base is frictionless.
        self.profile = profile.between(Material(1.0, np.inf), None) if profile.needs_poisson_ratio else profile
        self._incompressible = self.profile is not profile
        self.spring_constant = None
        if spring_constant is not None:
            self.spring_constant = checks.single_positive("spring_constant", spring_constant, "N/m")
        self.temperature = number_or_none("temperature", temperature)
        self.time, self.depth, self.force = _columns(time, depth, force)
        _check_force(self.depth, self.force)
        exponent = 1.5 if profile.path_exponent is None else 0.5 * float(profile.path_exponent) + 1.0
        touch = first_touch(self.time, self.depth, self.force, exponent)
        tip, kinks = self.depth, np.empty(0)
        if self.spring_constant is not None:
            free = self.depth < touch.depth - 0.1 * (touch.depth - self.depth.min())
            with np.errstate(over="ignore"):
                tip = self.depth - (self.force - baseline(self.time, self.force, free)) / self.spring_constant
            if not np.ptp(tip) < _WIDEST:
                raise InputError("spring_constant", self.spring_constant, "is too small for the force", "N/m")
            base = straight_lines(self.time, self.depth, kinks)
            kinks = base.time if base.noise == 0.0 else kinks
            touch = first_touch(self.time, tip, self.force, exponent)
        lines = straight_lines(self.time, tip, kinks)
        if lines.noise > 0.0 and self.spring_constant is None:
            # The same text for all curves of a map, which Python's filter shows once.
            message = "straight lines replace the depth, which is noisy; see the attribute `lines` of the curve"
            warnings.warn(RestitutionWarning("smoothing", message), stacklevel=2)
        self.lines = rising_and_falling(lines, touch.depth)
        self._set_nuisance(touch.depth, touch.noise)
        span = float(np.ptp(self.force))
        deviations = noise_of(noise, ["force"]).of("force", self.force, span)
        self.scaled = deviations is None
        if deviations is None:
            deviations = np.full(self.force.size, max(touch.noise, 1e-6 * span))
        slope = self.time - self.time[0], "N/s"
        constant = np.ones(self.time.size), "N"
        self._set_record(self.time, self.force, deviations, baseline=constant, baseline_slope=slope)

    def _set_nuisance(self, touch: float, noise: float) -> None:
        """Return the start, range and step of the contact point."""
        peak = float(self.lines.depth.max())
        before = int(np.argmax(self.depth > touch))
        if before < _FEWEST:
            rule = f"must have at least {_FEWEST} points before first touch for the baseline, not {before}"
            raise InputError("depth", rule=rule)
        inside = int(np.count_nonzero(self.depth > touch))
        if inside < _FEWEST:
            raise InputError("depth", rule=f"must have at least {_FEWEST} points after first touch, not {inside}")
        first = float(self.lines.depth[0])
        low = touch - 0.95 * (touch - first)
        high = peak - 0.05 * (peak - touch)
        # Mean slope of the force over the depth in the approach.
        stiffness = 1.5 * float(np.ptp(self.force)) / (peak - touch)
        step = max(noise / stiffness, 1e-6 * (peak - touch))
        self.nuisances = (Nuisance("contact_point", "m", touch, low, high, step),)

    def projected(self, forces: Array) -> Array:
        """Return residuals of forces [N] of shape (m, n)."""
        return self._compared(forces)

    @cached_property
    def block(self) -> IndentationBlock:
        """Forces of many materials at the times of the curve."""
        return curves_block([self])

    def forces(self, materials: Material, nuisances: Array) -> Array:
        """Return forces of materials [N] without a baseline, shape (m, n)."""
        if self._incompressible and not np.all(materials.is_incompressible):
            rule = 'is a bonded layer, which depends on the Poisson ratio: give fixed={"poisson_ratio": 0.5}'
            raise InputError("profile", rule=rule)
        return self.block.forces(modulus(materials, self.temperature), nuisances[:, 0], rtol=RTOL)[0]

    def window(self) -> tuple[float, float]:
        """Return frequencies [rad/s]: one over the duration of contact, and a tenth of the rate of the points."""
        duration = self._contact_duration
        return 1.0 / duration, 0.1 * np.pi / max(float(np.median(np.diff(self.time))), 1e-3 * duration)

    @property
    def _contact_duration(self) -> float:
        """Time [s] from first touch to the return to its depth, or to the end."""
        inside = self.time[self.depth > self.nuisances[0].start]
        return float(inside[-1] - inside[0])

    def effective_moduli(self) -> DynamicTable:
        """Return moduli of the best of a few standard solids, each times the best factor."""
        shares, times = (grid.ravel() for grid in np.meshgrid(_SHARES, np.array(_TIMES) * self._contact_duration))
        series = PronySeries.from_checked(1.0 - shares, shares[:, None], times[:, None])
        forces, _ = self.block.forces(series, np.full(shares.size, self.nuisances[0].start), rtol=1e-4)
        projected = self._projected(np.nan_to_num(forces))
        size, share = np.einsum("mn,mn->m", projected, projected), projected @ self._data
        gain = np.where(share > 0.0, share**2 / np.maximum(size, 1e-300), -np.inf)
        best = int(np.argmax(gain))
        if not np.isfinite(gain[best]):
            raise InputError("force", rule="does not rise with the depth; is a push positive?")
        modulus = float(share[best] / size[best])
        if not _SOFTEST < modulus < _STIFFEST:
            rule = f"means a modulus of {modulus:.2g} Pa with this depth and profile; check the units"
            raise InputError("force", rule=rule)
        omega = np.geomspace(*self.window(), _FREQUENCIES)
        moduli = series.scaled(modulus).column.complex_modulus(omega)[best]
        return DynamicTable(omega, moduli.real, np.maximum(moduli.imag, 0.01 * moduli.real), source=self.label)


def curves_block(curves: list[IndentationCurve]) -> IndentationBlock:
    """Return the block of the curves of one indenter."""
    deepest = max(float(curve.lines.depth.max() - curve.nuisances[0].low) for curve in curves)
    return IndentationBlock(
        curves[0].profile, [(curve.lines.time, curve.lines.depth, curve.time) for curve in curves], 1.001 * deepest
    )


def _columns(time: Any, depth: Any, force: Any) -> tuple[Array, Array, Array]:
    """Return three columns of equal length with ascending times."""
    columns = {"time": (time, "s"), "depth": (depth, "m"), "force": (force, "N")}
    t, d, f = columns_over_time(columns)
    if t.size < 3 * _FEWEST:
        raise InputError(", ".join(columns), t.size, f"must be columns of equal length >= {3 * _FEWEST}")
    for (name, (_, unit)), column in zip(columns.items(), (t, d, f), strict=True):
        span = float(np.ptp(column))
        if not _NARROWEST < span < _WIDEST:
            rule = f"must change over the curve by {_NARROWEST:g} to {_WIDEST:g} {unit}, not by {span:g} {unit}"
            raise InputError(name, rule=rule)
    return t, d, f


def _check_force(depth: Array, force: Array) -> None:
    """Refuse a depth or a force of the wrong sign, a force that jumps at rest, and one that is saturated."""
    lowest, highest = np.argmin(depth), np.argmax(depth)
    # The record begins without contact, far from its largest depth, and the push is largest there.
    far = np.median(depth[:_FEWEST]) > 0.5 * (depth[lowest] + depth[highest])
    if far and force[lowest] - force[highest] > 0.5 * np.ptp(force):
        raise InputError("depth", rule="falls during the approach: give -height")
    if force[highest] <= np.median(force[:_FEWEST]):
        raise InputError("force", rule="must be larger at the largest depth than at the start; is a push positive?")
    steps, moves = np.abs(np.diff(force)) / np.ptp(force), np.abs(np.diff(depth)) / np.ptp(depth)
    jumps = np.flatnonzero((steps > _JUMP) & (moves < 0.2 * _JUMP))
    if jumps.size:
        n = int(jumps[0]) + 1
        rule = "jumps from the point before, which is impossible without adhesion"
        raise InputError("force", float(force[n]), rule, "N", index=(n,))
    largest = np.flatnonzero(force == force.max())
    if largest.size >= _EQUAL and np.ptp(depth[largest]) > _MOVED * np.ptp(depth):
        n = int(largest[0])
        rule = "stays at its largest value while the depth changes: it is saturated"
        raise InputError("force", float(force[n]), rule, "N", index=(n,))
