"""Measured indentation curves, such as those of an atomic force microscope."""

from __future__ import annotations

import warnings
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from restitution import checks, quantities
from restitution.contact.geometry import Geometry
from restitution.errors import InputError, InputTypeError, RestitutionWarning
from restitution.identification.observations import Curve, Noise, Nuisance, Observations
from restitution.identification.touch import baseline, first_touch, rising_and_falling, straight_lines
from restitution.indentation.block import IndentationBlock
from restitution.material.columns import MaterialColumns, PronyColumns
from restitution.material.fit import DynamicTable
from restitution.material.viscoelastic import Material

Array = NDArray[np.float64]

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


class IndentationCurve(Observations):
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
    >>> curve.size, [one.name for one in curve.nuisances]
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
        self.temperature = None if temperature is None else quantities.check_single("temperature", temperature)
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
        deviations = Noise.given(noise).of("force", self.force, float(np.ptp(self.force)))
        self.scaled = deviations is None
        floor = 1e-6 * float(np.ptp(self.force))
        self.deviations = np.full(self.size, max(touch.noise, floor)) if deviations is None else deviations
        # Constant and slope, whose part of the residuals is projected out.
        share = (self.time - self.time[0]) / (self.time[-1] - self.time[0])
        columns = np.stack([np.ones(self.size), share], axis=1) / self.deviations[:, None]
        self.basis, self._triangle = np.linalg.qr(columns)

    def _set_nuisance(self, touch: float, noise: float) -> None:
        """Start, range and step of the contact point."""
        peak = float(self.lines.depth.max())
        before = int(np.argmax(self.depth > touch))
        if before < _FEWEST:
            wanted = f"must have at least {_FEWEST} points before first touch for the baseline, not {before}"
            raise InputError("depth", wanted=wanted)
        inside = int(np.count_nonzero(self.depth > touch))
        if inside < _FEWEST:
            raise InputError("depth", wanted=f"must have at least {_FEWEST} points after first touch, not {inside}")
        first = float(self.lines.depth[0])
        low = touch - 0.95 * (touch - first)
        high = peak - 0.05 * (peak - touch)
        # Mean slope of the force over the depth in the approach.
        stiffness = 1.5 * float(np.ptp(self.force)) / (peak - touch)
        step = max(noise / stiffness, 1e-6 * (peak - touch))
        self.nuisances = (Nuisance("contact_point", "m", touch, low, high, step),)

    @property
    def size(self) -> int:
        """Number of points."""
        return self.time.size

    @cached_property
    def block(self) -> IndentationBlock:
        """Forces of many materials at the times of the curve."""
        return curves_block([self])

    def residuals(self, materials: MaterialColumns, nuisances: Array) -> Array:
        """Residuals (fit - data) over their standard deviations, without the part of a baseline, shape (m, n)."""
        return self.projected(self.forces(materials, nuisances))

    def forces(self, materials: MaterialColumns, nuisances: Array) -> Array:
        """Forces of materials [N] without a baseline, shape (m, n)."""
        if self._incompressible and not np.all(np.isinf(materials.bulk.equilibria)):
            wanted = 'is a bonded layer, which depends on the Poisson ratio: give fixed={"poisson_ratio": 0.5}'
            raise InputError("profile", wanted=wanted)
        return self.block.forces(materials.at(self.temperature).reduced, nuisances[:, 0], rtol=RTOL)[0]

    def projected(self, forces: Array) -> Array:
        """Residuals of forces [N] of shape (m, n)."""
        residuals = (forces - self.force) / self.deviations
        return residuals - (residuals @ self.basis) @ self.basis.T

    def curves(self, materials: MaterialColumns, nuisances: Array) -> list[Curve]:
        """Measured and fitted force over time."""
        fitted = self.force + self.residuals(materials, nuisances)[0] * self.deviations
        return [Curve("force", "time", self.time, self.force, fitted, None if self.scaled else self.deviations)]

    def window(self) -> tuple[float, float]:
        """Angular frequencies [rad/s] from one over the duration of contact to a tenth of the rate of the points."""
        duration = self._contact_duration
        return 1.0 / duration, 0.1 * np.pi / max(float(np.median(np.diff(self.time))), 1e-3 * duration)

    @property
    def _contact_duration(self) -> float:
        """Time [s] from first touch to the return to its depth, or to the end."""
        inside = self.time[self.depth > self.nuisances[0].start]
        return float(inside[-1] - inside[0])

    def linear_estimates(self, materials: MaterialColumns, nuisances: Array) -> dict[str, tuple[float, str]]:
        """Baseline at the first time, and its slope."""
        off = (self.force - self.forces(materials, nuisances)[0]) / self.deviations
        start, rise = np.linalg.solve(self._triangle, off @ self.basis)
        slope = rise / (self.time[-1] - self.time[0])
        return {"baseline": (float(start), "N"), "baseline_slope": (float(slope), "N/s")}

    def effective_moduli(self) -> DynamicTable:
        """Moduli of the best of a few standard solids, each times the best factor."""
        shares, times = (grid.ravel() for grid in np.meshgrid(_SHARES, np.array(_TIMES) * self._contact_duration))
        series = PronyColumns(1.0 - shares, np.zeros(shares.size), shares[:, None], times[:, None])
        forces, _ = self.block.forces(series, np.full(shares.size, self.nuisances[0].start), rtol=1e-4)
        forces = np.nan_to_num(forces) / self.deviations
        forces -= (forces @ self.basis) @ self.basis.T
        measured = self.force / self.deviations
        size, share = np.einsum("mn,mn->m", forces, forces), forces @ measured
        gain = np.where(share > 0.0, share**2 / np.maximum(size, 1e-300), -np.inf)
        best = int(np.argmax(gain))
        if not np.isfinite(gain[best]):
            raise InputError("force", wanted="does not rise with the depth; is a push positive?")
        modulus = float(share[best] / size[best])
        if not _SOFTEST < modulus < _STIFFEST:
            wanted = f"means a modulus of {modulus:.2g} Pa with this depth and profile; check the units"
            raise InputError("force", wanted=wanted)
        omega = np.geomspace(*self.window(), _FREQUENCIES)
        moduli = series.scaled(modulus).complex_modulus(omega)[best]
        return DynamicTable(omega, moduli.real, np.maximum(moduli.imag, 0.01 * moduli.real), source=self.label)


def curves_block(curves: list[IndentationCurve]) -> IndentationBlock:
    """Block of the curves of one indenter."""
    deepest = max(float(one.lines.depth.max() - one.nuisances[0].low) for one in curves)
    return IndentationBlock(
        curves[0].profile, [(one.lines.time, one.lines.depth, one.time) for one in curves], 1.001 * deepest
    )


def _columns(time: Any, depth: Any, force: Any) -> tuple[Array, Array, Array]:
    """Three columns of equal length with ascending times."""
    t, d, f = (
        np.atleast_1d(checks.finite(name, column, unit))
        for name, column, unit in (("time", time, "s"), ("depth", depth, "m"), ("force", force, "N"))
    )
    if t.ndim != 1 or not t.shape == d.shape == f.shape or t.size < 3 * _FEWEST:
        wanted = f"must be columns of equal length >= {3 * _FEWEST}, not of shapes {t.shape}, {d.shape}, {f.shape}"
        raise InputError("time, depth, force", wanted=wanted)
    falls = np.flatnonzero(np.diff(t) <= 0.0)
    if falls.size:
        n = int(falls[0]) + 1
        raise InputError("time", float(t[n]), f"must be after {t[n - 1]:g} s", "s", index=(n,))
    for name, column, unit in (("time", t, "s"), ("depth", d, "m"), ("force", f, "N")):
        span = float(np.ptp(column))
        if not _NARROWEST < span < _WIDEST:
            wanted = f"must change over the curve by {_NARROWEST:g} to {_WIDEST:g} {unit}, not by {span:g} {unit}"
            raise InputError(name, wanted=wanted)
    return t, d, f


def _check_force(depth: Array, force: Array) -> None:
    """Refuse a depth or a force of the wrong sign, a force that jumps at rest, and one that is saturated."""
    lowest, highest = np.argmin(depth), np.argmax(depth)
    # The record begins without contact, far from its largest depth, and the push is largest there.
    far = np.median(depth[:_FEWEST]) > 0.5 * (depth[lowest] + depth[highest])
    if far and force[lowest] - force[highest] > 0.5 * np.ptp(force):
        raise InputError("depth", wanted="falls during the approach: give -height")
    if force[highest] <= np.median(force[:_FEWEST]):
        raise InputError("force", wanted="must be larger at the largest depth than at the start; is a push positive?")
    steps, moves = np.abs(np.diff(force)) / np.ptp(force), np.abs(np.diff(depth)) / np.ptp(depth)
    jumps = np.flatnonzero((steps > _JUMP) & (moves < 0.2 * _JUMP))
    if jumps.size:
        n = int(jumps[0]) + 1
        wanted = "jumps from the point before, which is impossible without adhesion"
        raise InputError("force", float(force[n]), wanted, "N", index=(n,))
    largest = np.flatnonzero(force == force.max())
    if largest.size >= _EQUAL and np.ptp(depth[largest]) > _MOVED * np.ptp(depth):
        n = int(largest[0])
        wanted = "stays at its largest value while the depth changes: it is saturated"
        raise InputError("force", float(force[n]), wanted, "N", index=(n,))
