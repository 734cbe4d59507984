"""Measured indentation curves and their first touch."""

from __future__ import annotations

import math
from copy import copy
from functools import cached_property
from typing import Any, Literal, NamedTuple

import numpy as np
from numpy.typing import NDArray

from restitution import checks
from restitution.checks import Array
from restitution.contact.adhesion import require_smooth
from restitution.contact.geometry import Geometry
from restitution.contact.profiles import as_profile
from restitution.errors import InputError, InputTypeError
from restitution.identification.adhesion import ERROR, MOST, StickyMaterial, doubts_of, elements_for
from restitution.identification.observations import (
    ForceRecord,
    Noise,
    Nuisance,
    columns_over_time,
    modulus,
    noise_of,
    number_or_none,
)
from restitution.identification.pull_off import PullOff, deviations_at_jumps, lines_of, work_of_pull
from restitution.indentation.records import Record, RecordBlock
from restitution.material.fit import DynamicTable
from restitution.material.prony import PronySeries
from restitution.material.viscoelastic import Material

# First touch of a measured indentation, and the noise of its columns.


# Search for first touch: smallest and largest number of points of the approach, rounds, and depths in each of them.
_FEWEST_ROWS, _MOST, _ROUNDS, _PLACES = 12, 160, 3, 40
# Powers of the force over the depth from touch, relative to an elastic contact; relaxation lowers the power.
_POWERS = (1.0, 0.9, 0.8, 0.65)
# The later rounds use this share of the approach beyond touch.
_NEAR = 0.4
# An approach ends where its depth is below the largest one by this share of its range, and this multiple of its noise;
# the later rounds end this share of the indentation below it.
_REST, _NOISE, _TOP = 1e-3, 5.0, 0.02
# A slope of the baseline counts if it exceeds this multiple of its standard error.
_DRIFT = 4.0
# The first approach reaches this share of the range of the force, and ends where the depth is below its largest value
# by this share of its range.
_REACHED, _BACK = 0.2, 0.05


class Touch(NamedTuple):
    """First touch."""

    depth: float
    noise: float  # standard deviation of the force about the fit


def first_approach(depth: Array, force: Array) -> tuple[int, int]:
    """Return the first sample of the first approach, and the first sample after it."""
    level = float(np.median(force[:_FEWEST]))
    pushed = int(np.argmax(force - level > _REACHED * (force.max() - level)))
    below = np.maximum.accumulate(depth[pushed:]) - depth[pushed:] > _BACK * np.ptp(depth)
    end = pushed + int(np.argmax(below)) if below.any() else depth.size
    return int(np.argmin(depth[: pushed + 1])), end


def first_touch(time: Array, depth: Array, force: Array, exponent: float) -> Touch:
    """Return the depth at first touch in the first approach.

    Least squares of F = b0 + b1 t + A (d - c)^q over c and q; the exponent is that of F over d of an elastic contact.
    """
    first, last = first_approach(depth, force)
    # The force relaxes while the depth rests at its largest value.
    part = depth[first:last]
    last = first + int(np.argmax(part >= part.max() - _REST * np.ptp(part) - _NOISE * white_noise(time, depth))) + 1
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
        near = near[near <= first + np.argmax(depth[first:last] >= peak - _TOP * size)]
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
    slope, error = drift(time[free], force[free])
    return force[free].mean() + (slope if abs(slope) > _DRIFT * error else 0.0) * (time - time[free].mean())


def drift(time: Array, force: Array) -> tuple[float, float]:
    """Return the slope of a force over time, and its standard error."""
    t = time - time.mean()
    spread = float(t @ t)
    slope = float(t @ force) / spread
    return slope, float(np.std(force - slope * t)) / math.sqrt(spread)


def white_noise(time: Array, values: Array) -> float:
    """Return the standard deviation of white noise from the distances of points from the lines of their neighbours."""
    share = (time[1:-1] - time[:-2]) / (time[2:] - time[:-2])
    beside = values[1:-1] - values[:-2] - share * (values[2:] - values[:-2])
    return float(np.median(np.abs(beside) / np.sqrt(1.0 + share**2 + (1.0 - share) ** 2))) / 0.6745


# Measured indentation curves, such as those of an atomic force microscope.

# Fewest points before and after first touch.
_FEWEST = 10
# So many equal largest forces show saturation if the depth changes by more than this share of its range.
_EQUAL, _MOVED = 5, 0.02
# A force jumps if it changes by more than this share of its range from one point to the next, but the depth does not.
_JUMP = 0.25
# A pull counts if the mean of so many samples is beyond this multiple of its standard error, and this share of the
# range of the force.
_PULLED, _PULL, _LEAST_PULL = 5, 6.0, 0.02
# An approach alone ends where the depth falls by this share of its range, or this multiple of its noise.
_RETURN, _RETURN_NOISE = 0.003, 5.0
# Standard solids that are tried for a start: shares of the relaxing modulus, and times over the duration.
_SHARES, _TIMES = (0.0, 0.4, 0.8, 0.97), (0.01, 0.04, 0.15, 0.6)
_FREQUENCIES = 6
# Ranges of times, depths and forces in SI whose squares are normal numbers; moduli [Pa] of matter.
_NARROWEST, _WIDEST = 1e-30, 1e30
_SOFTEST, _STIFFEST = 1e-6, 1e15
# A spring whose stiffness is below this share of that of the contact on the glass is soft.
_SOFT = 1.0 / 3.0
# Least noise over the range of the force from which elements are chosen where the fit estimates it.
_ROUGH = 0.01
# An error of the computed force counts if it exceeds this share of the noise.
_ERROR = 0.2


class IndentationCurve(ForceRecord):
    """Force over depth and time: approaches, holds, partial unloads, cycles and retractions, as they were measured.

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
        Spring constant k of a cantilever [N/m] if the depth z is that of its base: the tip is at z - F/k.
    temperature : float, optional
        Temperature [K], for a model with a shift.
    noise : Noise, optional
        Standard deviations of `force` and `depth`; a relative one refers to the range. By default that of the force is
        estimated with the fit, and that of the depth from the scatter of neighbouring points.
    segment : {"approach"}, optional
        Use the first approach alone, with its hold.
    adhesion : bool
        Whether the surfaces adhere, as a pull on the way out shows. The fit then has the unknowns `work` and
        `stress`, or `range` where one of its arguments names that, of `rs.Adhesion`.
    label : str
        Name of the data in messages.

    Raises
    ------
    InputError
        If a number is out of range, the times are not ascending, there are fewer than 10 points before first touch,
        the force is saturated, or it jumps or is a pull on the way out without `adhesion`.

    Notes
    -----
    The depth is a straight line between samples, with its noise. Independent hereditary elements, one for each
    sample or more, give the force of any history (`restitution.kernel.record`). Their error is of second order in the
    distance of the samples; `discretisation_error` estimates it.

    A depth error e changes the force by S e, with the stiffness S of the contact. Residuals are over the root of the
    sum of the squares of the noise of the force and of S e, with S of the trial material: without it the modulus
    would be too small, as in Deming's regression. With `spring_constant` the spring is part of the model, so that the
    noise of the force does not move the tip.

    With adhesion the depth of the tip, or of the base of the cantilever, is smoothed to few straight lines. A force is
    the mean over the time of its sample, and beside a jump its deviation is larger.

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
        segment: Literal["approach"] | None = None,
        adhesion: bool = False,
        label: str = "",
    ) -> None:
        self.label, self.adhesion = label, checks.truth("adhesion", adhesion)
        if not isinstance(profile, Geometry):
            raise InputTypeError("profile", profile, "must be a Geometry, such as Parabola(radius)")
        # The layer of a contact with an incompressible material; itself if its base is frictionless.
        self.profile = profile.between(Material(1.0, np.inf), None) if profile.needs_poisson_ratio else profile
        self._incompressible = self.profile is not profile
        self.spring_constant = None
        if spring_constant is not None:
            self.spring_constant = checks.single_positive("spring_constant", spring_constant, "N/m")
        self.temperature = number_or_none("temperature", temperature)
        if self.adhesion:
            require_smooth(as_profile(profile, "adhesion"))
        self.time, self.depth, self.force = _columns(time, depth, force)
        if segment is not None:
            checks.one_of("segment", segment, ("approach",))
            self._keep_approach()
        _check_force(self.depth, self.force, jumps=self.adhesion, whole=segment is None)
        touch = self._touch()
        self._set_nuisance(touch.depth, touch.noise)
        self._set_noise(noise, touch)
        if self.adhesion:
            self._set_adhesion()
        elif segment is None:
            self._refuse_pull(touch)

    def _keep_approach(self) -> None:
        """Drop all samples from the first retraction on."""
        end = first_approach(self.depth, self.force)[1]
        back = max(_RETURN * np.ptp(self.depth), _RETURN_NOISE * white_noise(self.time, self.depth))
        high = np.flatnonzero(self.depth[:end] >= self.depth[:end].max() - back)
        part = slice(int(high[-1]) + 1)
        self.time, self.depth, self.force = self.time[part], self.depth[part], self.force[part]

    def _touch(self) -> Touch:
        """Return first touch, at the reading of the depth without a force."""
        exponent = 1.5 if self.profile.path_exponent is None else 0.5 * float(self.profile.path_exponent) + 1.0
        touch = first_touch(self.time, self.depth, self.force, exponent)
        if self.spring_constant is None:
            return touch
        free = self.depth < touch.depth - 0.1 * (touch.depth - self.depth.min())
        with np.errstate(over="ignore"):
            tip = self.depth - (self.force - baseline(self.time, self.force, free)) / self.spring_constant
        if not np.ptp(tip) < _WIDEST:
            raise InputError("spring_constant", self.spring_constant, "is too small for the force", "N/m")
        try:
            return first_touch(self.time, tip, self.force, exponent)
        except InputError:
            if self.adhesion:
                # After a jump into contact the tip may hardly go deeper; the fit starts from the base.
                return touch
            raise

    def _set_nuisance(self, touch: float, noise: float) -> None:
        """Set the start, range and step of the contact point."""
        peak, first = float(self.depth.max()), float(self.depth[0])
        before = int(np.argmax(self.depth > touch))
        if before < _FEWEST:
            rule = f"must have at least {_FEWEST} points before first touch for the baseline, not {before}"
            raise InputError("depth", rule=rule)
        inside = int(np.count_nonzero(self.depth > touch))
        if inside < _FEWEST:
            raise InputError("depth", rule=f"must have at least {_FEWEST} points after first touch, not {inside}")
        low, high = touch - 0.95 * (touch - first), peak - 0.05 * (peak - touch)
        end = float(np.min(self.profile.max_depth))
        if peak - touch > end and self.spring_constant is None:
            rule = f"from first touch on must be <= {end:g} m, {self.profile.end}"
            raise InputError("depth", peak - touch, rule, "m")
        if self.spring_constant is None:
            low = max(low, peak - end)
        # Mean slope of the force over the depth in the approach.
        stiffness = 1.5 * float(np.ptp(self.force)) / (peak - touch)
        step = max(noise / stiffness, 1e-6 * (peak - touch))
        self.nuisances = (Nuisance("contact_point", "m", touch, low, high, step),)

    def _set_noise(self, noise: Noise | None, touch: Touch) -> None:
        """Set the standard deviations of force and depth, and the columns of the baseline."""
        stated, span = noise_of(noise, ["force"], ["depth"]), float(np.ptp(self.force))
        deviations = stated.of("force", self.force, span)
        self.scaled = deviations is None
        if deviations is None:
            before = self.depth < touch.depth
            estimated = white_noise(self.time[before], self.force[before]) or touch.noise
            deviations = np.full(self.force.size, max(estimated, 1e-6 * span))
        depths = stated.of("depth", self.depth, float(np.ptp(self.depth)))
        self.depth_deviations = np.full(self.size, white_noise(self.time, self.depth)) if depths is None else depths
        slope = self.time - self.time[0], "N/s"
        constant = np.ones(self.time.size), "N"
        self._set_record(self.time, self.force, deviations, baseline=constant, baseline_slope=slope)

    def _set_adhesion(self) -> None:
        """Set the contacts with adhesion; the deviations beside jumps are larger."""
        lines = lines_of(self.time, self.depth, float(np.mean(self.depth_deviations)))
        # The scatter of neighbours is less than what a model leaves.
        noise = float(np.mean(self.deviations)) / float(np.ptp(self.force))
        count = 2 * elements_for(max(noise, _ROUGH if self.scaled else 0.0))
        profile, deepest = as_profile(self.profile, "adhesion"), float(self.tip.max())
        self._pull_off, self.jumps = PullOff(profile, self.time, lines, deepest, self.spring_constant, count), True
        names = zip(self._units, self._columns, strict=True)
        columns: dict[str, Any] = {name: (column, self._units[name]) for name, column in names}
        self._set_record(self.time, self.force, deviations_at_jumps(self.force, self.deviations), **columns)

    def _retraction(self, touch: float) -> Array:
        """Return the forces [N] from the largest depth on, less the baseline."""
        free = self.depth < touch - 0.3 * (touch - self.depth.min())
        return (self.force - baseline(self.time, self.force, free))[int(np.argmax(self.depth)) :]

    def _refuse_pull(self, touch: Touch) -> None:
        """Refuse a force that is negative on the way out, over the lowest baseline that the drift may have."""
        free = self.depth < touch.depth - 0.3 * (touch.depth - self.depth.min())
        if np.count_nonzero(free) < 3:  # without a noise nothing is beyond it
            return
        slope, error = drift(self.time[free], self.force[free])
        later = self.time - self.time[free].mean()
        lowest_baseline = self.force[free].mean() + slope * later - _DRIFT * error * np.abs(later)
        force = (self.force - lowest_baseline)[int(np.argmax(self.depth)) :]
        if force.size < _PULLED:
            return
        means = np.convolve(force, np.full(_PULLED, 1.0 / _PULLED), mode="valid")
        noise = white_noise(self.time[free], self.force[free]) / math.sqrt(_PULLED)
        lowest = float(means.min())
        if -lowest > max(_PULL * noise, _LEAST_PULL * float(np.ptp(self.force))):
            rule = 'is a pull on the way out: give adhesion=True; or segment="approach", for the approach alone'
            raise InputError("force", lowest, rule, "N")

    @cached_property
    def block(self) -> RecordBlock:
        """Forces of many materials at the times of the curve."""
        return curves_block([self])

    def _responses(self, materials: Material, nuisances: Array) -> tuple[Array, Array]:
        """Return forces of materials [N] without a baseline, and their slopes over a depth [N/m], shape (m, n)."""
        if self._incompressible and not np.all(materials.is_incompressible):
            rule = 'is a bonded layer, which depends on the Poisson ratio: give fixed={"poisson_ratio": 0.5}'
            raise InputError("profile", rule=rule)
        if self.adhesion and isinstance(materials, StickyMaterial):
            forces = self._pull_off.forces(modulus(materials, self.temperature), nuisances[:, 0], materials)
            return forces, np.zeros(forces.shape)  # the lines of the depth have hardly any noise
        return self.block.forces(modulus(materials, self.temperature), nuisances[:, 0])

    def forces(self, materials: Material, nuisances: Array) -> Array:
        """Return forces of materials [N] without a baseline, shape (m, n)."""
        return self._responses(materials, nuisances)[0]

    def residuals(self, materials: Material, nuisances: Array) -> Array:
        """Return residuals over the deviations that noise of force and depth cause; NaN where a row has no result."""
        return self._fitted(materials, nuisances)[0]

    def _fitted(self, materials: Material, nuisances: Array) -> tuple[Array, Array]:
        """Return residuals, and the factors of the columns of the baseline."""
        forces, slopes = self._responses(materials, nuisances)
        weights = weights_of(self.deviations, slopes, self.depth_deviations)
        return without_baseline((forces - self.force) * weights, self._columns.T * weights[..., None])

    def baseline_factors(self, materials: Material, nuisances: Array) -> Array:
        """Return the offset [N] and the slope [N/s] of the baseline of materials, shape (m, 2)."""
        return -self._fitted(materials, nuisances)[1]

    def _linear(self, materials: Material, nuisances: Array) -> tuple[Array, Array, float]:
        """Return the fitted force, the factors of the baseline, and the gain of the first row."""
        forces, factors = self.forces(materials, nuisances)[0], self.baseline_factors(materials, nuisances)[0]
        return forces + factors @ self._columns, factors, 1.0

    def discretisation_error(self, materials: Material, nuisances: Array) -> Array:
        """Return errors of the forces [N] as computed, shape (m, n): four thirds of the change with half the steps."""
        reduced, touches = modulus(materials, self.temperature), nuisances[:, 0]
        if self.adhesion and isinstance(materials, StickyMaterial):
            finer = self._pull_off.forces(reduced, touches, materials, finer=2)
        else:
            finer, _ = self.block.refined().forces(reduced, touches)
        return 4.0 / 3.0 * np.abs(self.forces(materials, nuisances) - finer)

    def refined(self, materials: Material, nuisances: Array) -> IndentationCurve:
        """Return the same data with so many elements of the attraction as the noise needs near a fit."""
        curve = self
        while self.adhesion and curve._doubt(materials, nuisances) > ERROR and 2 * curve._pull_off.count <= MOST:
            curve = copy(curve)
            curve._pull_off = curve._pull_off.with_elements(2)
        return curve

    def _doubt(self, materials: Material, nuisances: Array) -> float:
        """Return the root mean square of the errors of the first row over their noise.

        Where the fit estimates the noise, the residuals have its size.
        """
        error = self.discretisation_error(materials, nuisances)[0]
        share = float(np.sqrt(np.mean((error / self.deviations) ** 2)))
        if self.scaled and self.adhesion:
            share /= max(float(np.sqrt(np.mean(self.residuals(materials, nuisances)[0] ** 2))), 1.0)
        return share

    def doubts(self, materials: Material, nuisances: Array) -> list[str]:
        """Return doubt about forces that are not computed well enough for their noise."""
        share = self._doubt(materials, nuisances)
        if self.adhesion and isinstance(materials, StickyMaterial):
            profile, reduced = as_profile(self.profile, "adhesion"), modulus(materials, self.temperature)
            lines = doubts_of(share, [profile], reduced, materials, self._pull_off.count)
            radius = float(profile.contact_radius(float(self.tip.max()) - float(nuisances[0, 0])))
            stiffness = 2.0 * float(reduced.row(0, 0).instantaneous_modulus) * radius
            if self.spring_constant is not None and self.spring_constant < _SOFT * stiffness:
                lines.append(
                    "the cantilever is much softer than the contact, so that most of the curve is one jump: other "
                    "materials may fit as well; give start"
                )
            return lines
        if not share > _ERROR:
            return []
        return [f"the computed force has an error of {share:.2g} of its noise: the samples are too far apart"]

    def window(self) -> tuple[float, float]:
        """Return frequencies [rad/s]: one over the duration of contact, and a tenth of the rate of the points."""
        duration = self._contact_duration
        return 1.0 / duration, 0.1 * np.pi / max(float(np.median(np.diff(self.time))), 1e-3 * duration)

    @property
    def _contact_duration(self) -> float:
        """Time [s] from first touch to the return to its depth, or to the end."""
        inside = self.time[self.depth > self.nuisances[0].start]
        return float(inside[-1] - inside[0])

    def assumed_contact(self, modulus: float) -> tuple[float, float] | None:
        """Return the work of adhesion [J/m^2] that the largest pull shows, and the radius [m] of the tip."""
        if not self.adhesion:
            return None
        touch = self.nuisances[0].start
        depth = max(float(self.tip.max()) - touch, _TOP * float(np.ptp(self.depth)))
        radius = float(np.asarray(self.profile.stiffness_radius(depth))) ** 2 / depth
        pull = max(-float(self._retraction(touch).min()), float(np.mean(self.deviations)))
        return work_of_pull(radius, pull), radius

    def effective_moduli(self) -> DynamicTable:
        """Return moduli of the best of a few standard solids, each times the best factor; with adhesion of a push."""
        if self.adhesion:
            return self._push().effective_moduli()
        shares, times = (grid.ravel() for grid in np.meshgrid(_SHARES, np.array(_TIMES) * self._contact_duration))
        series = PronySeries.from_checked(1.0 - shares, shares[:, None], times[:, None])
        block = self.block
        if self.spring_constant is not None:
            # The force is proportional to the modulus only where the depth is that of the tip.
            block = curves_block([self], rigid=True)
        forces, _ = block.forces(series, np.full(shares.size, self.nuisances[0].start))
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

    def _push(self) -> IndentationCurve:
        """Return the first approach without adhesion, and without the pulls; no datum, but a start of a fit."""
        force = np.maximum(self.force, float(np.median(self.force[:_FEWEST])))
        try:
            return IndentationCurve(
                self.time, self.depth, force, profile=self.profile, spring_constant=self.spring_constant,
                segment="approach",
            )  # fmt: skip
        except InputError:
            # A push that jumps, or has no first touch of its own, takes that of the whole record.
            push = copy(self)
        vars(push).pop("block", None)
        push.adhesion, push.force = False, force
        push._keep_approach()
        push._set_noise(None, Touch(self.nuisances[0].start, 0.0))
        return push

    @property
    def tip(self) -> Array:
        """Depth of the tip [m] from the measured force, if the depth is that of the base of a cantilever."""
        if self.spring_constant is None:
            return self.depth
        free = self.depth < self.nuisances[0].start
        return self.depth - (self.force - baseline(self.time, self.force, free)) / self.spring_constant


def weights_of(deviations: Array, slopes: Array, depths: Array) -> Array:
    """Return one over standard deviations of residuals, from those of forces and depths, and slopes of the force."""
    return 1.0 / np.sqrt(deviations**2 + (slopes * depths) ** 2)


def without_baseline(off: Array, columns: Array) -> tuple[Array, Array]:
    """Return residuals of shape (m, n) less their best combination of columns, shape (m, n, 2), and its factors."""
    size = np.sqrt(np.einsum("mnj,mnj->mj", columns, columns))[:, None]
    unit = columns / size
    normal, right = unit.swapaxes(1, 2) @ unit, np.einsum("mnj,mn->mj", unit, off)
    a, b, c = normal[:, 0, 0], normal[:, 0, 1], normal[:, 1, 1]
    factors = np.stack([c * right[:, 0] - b * right[:, 1], a * right[:, 1] - b * right[:, 0]], axis=1)
    factors /= (a * c - b * b)[:, None]
    return off - np.einsum("mnj,mj->mn", unit, factors), factors / size[:, 0]


def curves_block(curves: list[IndentationCurve], *, rigid: bool = False) -> RecordBlock:
    """Return the block of the curves of one indenter; `rigid` without springs, with depths of the tips."""
    deepest = max(float(curve.depth.max() - curve.nuisances[0].low) for curve in curves)
    records = [
        Record(curve.time, curve.depth, 1.0 / curve.spring_constant) if curve.spring_constant and not rigid
        else Record(curve.time, curve.tip, 0.0, float(curve.depth_deviations.mean()))
        for curve in curves
    ]  # fmt: skip
    return RecordBlock(curves[0].profile, records, 1.001 * deepest)


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


def _check_force(depth: Array, force: Array, *, jumps: bool, whole: bool) -> None:
    """Refuse a depth or a force of the wrong sign, a force that jumps at rest unless it may, and a saturated one."""
    lowest, highest = np.argmin(depth), np.argmax(depth)
    # The record begins without contact, far from its largest depth, and the push is largest there.
    far = np.median(depth[:_FEWEST]) > 0.5 * (depth[lowest] + depth[highest])
    if far and force[lowest] - force[highest] > 0.5 * np.ptp(force):
        raise InputError("depth", rule="falls during the approach: give -height")
    if force[highest] <= np.median(force[:_FEWEST]):
        raise InputError("force", rule="must be larger at the largest depth than at the start; is a push positive?")
    steps, moves = np.abs(np.diff(force)) / np.ptp(force), np.abs(np.diff(depth)) / np.ptp(depth)
    places = np.flatnonzero((steps > _JUMP) & (moves < 0.2 * _JUMP))
    if places.size and not jumps:
        n = int(places[0]) + 1
        rule = "jumps from the point before, as with adhesion: give adhesion=True"
        rule += '; or segment="approach", for the approach alone' * whole
        raise InputError("force", float(force[n]), rule, "N", index=(n,))
    largest = np.flatnonzero(force == force.max())
    if largest.size >= _EQUAL and np.ptp(depth[largest]) > _MOVED * np.ptp(depth):
        n = int(largest[0])
        rule = "stays at its largest value while the depth changes: it is saturated"
        raise InputError("force", float(force[n]), rule, "N", index=(n,))
