"""Measured rebounds: restitution coefficients, contact times and peak forces of impacts."""

from __future__ import annotations

import math
from copy import copy
from dataclasses import replace
from functools import cached_property
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from restitution import checks, quantities
from restitution.checks import Array
from restitution.contact.adhesion import Adhesion
from restitution.contact.geometry import Geometry
from restitution.contact.profiles import as_profile
from restitution.errors import InputError
from restitution.identification.adhesion import (
    ERROR,
    MOST,
    Bodies,
    Outcomes,
    StickyMaterial,
    collide,
    count_of_surprises,
    doubts_of,
    elements_for,
    slopes_over,
    surprise,
    work_of_sticking,
)
from restitution.identification.bounce_moduli import moduli_of_bounces
from restitution.identification.observations import (
    Curve,
    Noise,
    Observations,
    alone_of,
    contact_modulus,
    counter_of,
    modulus,
    noise_of,
    profile_of,
)
from restitution.identification.trial_impacts import ImpactNodes, bodies_of, impact_nodes, impacts_of, trials
from restitution.impact.batch import Batch
from restitution.impact.closed_forms import HERTZ_TIME_FACTOR
from restitution.impact.status import Status
from restitution.material.fit import DynamicTable
from restitution.material.prony import PronySeries
from restitution.material.shift import Arrhenius
from restitution.material.viscoelastic import Material

_RTOL = 1e-9
# Above this number of impacts their outcomes are interpolated.
_MANY = 400
# Relative change of the velocity for slopes over the velocity.
_STEP = 1e-3
# Moduli [Pa] of anything that bounces, with room to spare.
_MODULUS_RANGE = 1e-30, 1e30
_NAMES = ("restitution_coefficient", "contact_time", "max_force")
# e for a start where none was measured.
_UNSEEN = 0.8
# Sticking velocity over the smallest velocity of bodies that all rebound, for a start.
_BELOW = 0.3
# Noise of unknown size has these ratios.
_UNKNOWN = Noise(restitution_coefficient=0.01, contact_time="1 %", max_force="1 %")


class Rebounds(Observations):
    """Rebounds of rigid bodies from a viscoelastic half-space, or of two bodies from each other.

    Parameters
    ----------
    velocity : array_like
        Impact velocities v [m/s], > 0, shape (n,).
    restitution_coefficient : array_like
        Measured e [-] in (0, 1]; with `adhesion` also 0, a body that stuck, and NaN, one that rebounded with an e
        that was not measured. Both at one velocity are a measured sticking velocity, with the noise of the velocity.
    radius : float or array_like, optional
        Radius R [m] of a ball; or give a `profile`.
    mass : float or array_like
        Mass m [kg].
    profile : Geometry, optional
        Profile of all bodies, instead of the radius.
    contact_time, max_force : array_like, optional
        Measured contact times [s] and peak forces [N], NaN if not measured. At least one value is needed for moduli
        and times; see Notes.
    counter_material : Material or "same", optional
        Known material of the other body, or "same" if both are of the unknown material; rigid by default. As in
        `Impact`, two balls have the radius R1 R2/(R1 + R2), their reduced mass and their relative velocity.
    temperature : float or array_like, optional
        Temperatures [K], for a model with a `shift`.
    external_force : float or array_like
        Constant force [N] during contact, such as the weight.
    adhesion : bool
        Whether the surfaces adhere. The fit then has the unknowns `work` and `stress`, or `range` where one of
        its arguments names that, of `rs.Adhesion`.
    noise : Noise, optional
        Standard deviations of `restitution_coefficient`, `contact_time`, `max_force` and `velocity`: absolute ones of
        the value, relative ones of its logarithm. Without them the size of the noise is estimated. With noise of the
        velocity, e is taken as v'/v, and the noise of e is that of v'/v at a known v. Adhesion needs both.
    label : str
        Name of the data in messages.

    Raises
    ------
    InputError
        If a number is out of range, or the arrays differ in length.

    Notes
    -----
    Single numbers hold for all n impacts. For balls on a material at one temperature, without weight, e stays the
    same if all moduli grow by L^(5/2) and all times shrink by L: e alone determines no modulus and no time. A known
    elastic `counter_material` does not change this for models with an instantaneous modulus: with a spring in series
    they are models of the same kind. With adhesion the work grows by L besides, the stress by L^2, and the range
    shrinks by L.

    With adhesion each impact is one march of few elements (`rs.solve` extrapolates several). Residuals are those of
    e^2, which hardly bends just above the sticking velocity v_s; the noise of the velocity enters by the slopes of a
    first fit. What sticks is compared with v_s: a velocity v that is known to s sticks with the probability
    Phi((v_s - v)/s).

    Examples
    --------
    >>> balls = Rebounds([0.5, 1.0], [0.82, 0.79], radius=0.01, mass=0.033, contact_time=[2e-3, 1.8e-3])
    >>> balls.size
    4
    """

    def __init__(
        self,
        velocity: Any,
        restitution_coefficient: Any,
        *,
        radius: Any = None,
        mass: Any,
        profile: Geometry | None = None,
        contact_time: Any = None,
        max_force: Any = None,
        counter_material: Material | Literal["same"] | None = None,
        temperature: Any = None,
        external_force: Any = 0.0,
        adhesion: bool = False,
        noise: Noise | None = None,
        label: str = "",
    ) -> None:
        self.label, self.adhesion = label, checks.truth("adhesion", adhesion)
        self.counter_material = counter_of(counter_material)
        numbers: dict[str, Any] = {
            name: quantities.check(name, value)
            for name, value in (("velocity", velocity), ("mass", mass), ("external_force", external_force))
        }
        e = checks.number("restitution_coefficient", restitution_coefficient)
        measured: dict[str, Any] = {"restitution_coefficient": _shares(e, sticking=self.adhesion)}
        for name, values, unit in (("contact_time", contact_time, "s"), ("max_force", max_force, "N")):
            if values is not None:
                measured[name] = _measured(name, values, unit)
        profile_of(radius, profile)
        optional = {"radius": radius, "temperature": temperature}
        numbers |= {name: quantities.check(name, value) for name, value in optional.items() if value is not None}
        columns = _broadcast(numbers | measured)
        self.velocity, self.mass = columns["velocity"], columns["mass"]
        self.external_force, self.temperature = columns["external_force"], columns.get("temperature")
        self.radius = columns.get("radius")
        self.profile = profile_of(self.radius, profile)
        self._impact = impacts_of(self.profile, self.mass, self.velocity, self.external_force)
        if self.adhesion:
            replace(self._impact, adhesion=Adhesion(1.0))  # which refuses bodies without a theory
            if np.any(self.external_force):
                raise InputError("external_force", self.external_force, "must be 0 with adhesion", "N")
        self.measured = {name: columns[name] for name in _NAMES if name in measured}
        self.restitution_coefficient = self.measured["restitution_coefficient"]
        self.contact_time, self.max_force = self.measured.get("contact_time"), self.measured.get("max_force")
        if "radius" in columns and "contact_time" in columns:
            with np.errstate(over="ignore"):
                strain = columns["contact_time"] * self.velocity / columns["radius"]
            if np.any(strain > 3.0):  # an elastic body sinks in by a third of that
                worst = int(np.nanargmax(strain))
                rule = "must be in s: the body would move by more than its radius during contact"
                raise InputError("contact_time", float(columns["contact_time"][worst]), rule, "s", index=(worst,))
        self.noise = noise_of(noise, [*self.measured], ["velocity"])
        if self.adhesion and not {"restitution_coefficient", "velocity"} <= self.noise.deviations.keys():
            rule = "must be given with adhesion, and that of restitution_coefficient: they say what sticks by chance"
            raise InputError("noise.velocity", rule=rule)
        self._set_noise()

    def _set_noise(self) -> None:
        self.scaled = "restitution_coefficient" not in self.noise.deviations
        noise = _UNKNOWN if self.scaled else self.noise
        self._relative = [isinstance(noise.deviations[name], str) for name in self.measured]
        sizes: list[Array] = []
        for (name, values), relative in zip(self.measured.items(), self._relative, strict=True):
            size = noise.of(name, np.ones(values.size) if relative else values)
            assert size is not None
            sizes.append(_broadcast({f"noise.{name}": size, name: values})[f"noise.{name}"])
        self._deviations = np.array(sizes)
        blur = self.noise.of("velocity", self.velocity)
        self._blur = None if blur is None else np.broadcast_to(blur, self.velocity.shape) / self.velocity
        self.fixes_time = len(self.measured) > 1
        # A body that sticks has no numbers but its velocity.
        self._there = np.isfinite(np.array(list(self.measured.values()))) & (self.restitution_coefficient > 0.0)

    @property
    def size(self) -> int:
        """Number of measured values; with adhesion what stuck, and what did not, of equal bodies count as one each."""
        return int(self._there.sum()) + (count_of_surprises(self._groups) if self.adhesion else 0)

    def predicted(
        self, materials: Material, velocity_factor: float = 1.0, external_force: Array | None = None
    ) -> dict[str, Array]:
        """Return restitution coefficients, contact times and peak forces, shape (m, n); NaN without separation.

        With adhesion e is 0 where bodies stick.
        """
        if self.adhesion and isinstance(materials, StickyMaterial):
            collisions = self._collisions(materials)
            rows = dict(zip(_NAMES, np.where(collisions.sticks, np.nan, collisions.values), strict=True))
            return rows | {"restitution_coefficient": np.where(collisions.sticks, 0.0, collisions.values[0])}
        nodes = self._nodes
        reduced = self._moduli_at(materials, self.temperature if nodes is None else nodes.temperature)
        bodies = self._rows
        numbers = {} if external_force is None else {"forces": external_force}
        batch = trials(bodies, reduced, velocities=velocity_factor * bodies.velocities, **numbers)
        outcomes = batch.solve(_RTOL, workers=1)
        good = outcomes["status"] == Status.SEPARATED
        shape = materials.shape[0], bodies.size
        rows = {name: np.where(good, outcomes[name], np.nan).reshape(shape) for name in _NAMES}
        if nodes is None:
            return rows
        # The momentum is the scale of the force.
        rows["max_force"] /= bodies.masses * bodies.velocities
        rows = {name: np.exp(nodes.interpolated(np.log(values))) for name, values in rows.items()}
        rows["max_force"] *= self.mass * self.velocity
        return rows

    def _moduli_at(self, materials: Material, temperature: Array | None) -> PronySeries:
        """Return reduced moduli of the contacts at the temperature of each impact, shape (m, n) or (m, 1)."""
        if temperature is None:
            return self._contact(modulus(materials))
        levels, where = np.unique(temperature, return_inverse=True)
        reduced = modulus(materials, levels).broadcast_to((materials.shape[0], levels.size))
        return self._contact(reduced.take((slice(None), where)))

    @cached_property
    def _groups(self) -> list[Bodies]:
        """Impacts of equal bodies at one temperature."""
        columns = [values for values in (self.radius, self.mass, self.temperature) if values is not None]
        _, which = np.unique(np.stack(columns, axis=1), axis=0, return_inverse=True)
        groups = list[Bodies]()
        for n in range(int(which.max()) + 1):
            places = np.flatnonzero(which.ravel() == n)
            impact = self._impact.take(places[0])
            profile = as_profile(impact.profile, "adhesion")
            velocity, blur = self.velocity[places], np.asarray(self._blur)[places]
            stuck = self.restitution_coefficient[places] == 0.0
            groups.append(Bodies(profile, float(impact.mass), places, velocity, velocity * blur, stuck))
        return groups

    @cached_property
    def _squares(self) -> tuple[Array, Array]:
        """Measured e^2 without the bias by noise, and its standard deviations by noise of e and of the velocity."""
        e = self.restitution_coefficient
        slopes = np.empty(e.size)
        for bodies in self._groups:
            slopes[bodies.places] = slopes_over(bodies, e[bodies.places] ** 2)
        return self._squares_by(e, slopes)

    def _squares_by(self, e: Array, slopes: Array) -> tuple[Array, Array]:
        """Return the same with the noise at these e, and by slopes of e^2 over the logarithm of the velocity."""
        spread = self._deviations[0] * np.where(self._relative[0], e, 1.0)
        # If the velocity is too high by a share x, (v'/v)^2 is too low by twice this share.
        blur = (slopes + 2.0 * e * e) * np.asarray(self._blur)
        return self.restitution_coefficient**2 - spread**2, np.hypot(2.0 * np.maximum(e, spread) * spread, blur)

    def refined(self, materials: Material, nuisances: Array) -> Rebounds:
        """Return the same data with elements, and the noise of the velocity by slopes, for a fit, the first row."""
        if not (self.adhesion and isinstance(materials, StickyMaterial)):
            return self
        better = copy(self)
        while better._doubt(materials) > ERROR and 2 * better._count <= MOST:
            better._count *= 2
        share = np.asarray(self._blur)
        ahead, here, behind = (better._collisions(materials, 1.0 + n * share).values[0, 0] ** 2 for n in (1, 0, -1))
        # What sticks has the e of the sticking velocity, below which a measured one is no rebound.
        better._squares = self._squares_by(np.sqrt(here), (ahead - behind) / (2.0 * share))
        return better

    def _collisions(self, materials: StickyMaterial, factors: Any = 1.0, finer: int = 1) -> Outcomes:
        """Return the impacts with adhesion, perhaps at velocities times factors or with so many times the elements."""
        shape = materials.shape[0], self.velocity.size
        reduced = self._moduli_at(materials, self.temperature).broadcast_to(shape)
        each = np.broadcast_to(factors, self.velocity.shape)
        groups = [group._replace(velocities=group.velocities * each[group.places]) for group in self._groups]
        return collide(groups, reduced, materials, finer * self._count)

    @cached_property
    def _count(self) -> int:
        """Number of elements for the smallest noise of e."""
        sizes = self._deviations[0] * np.where(self._relative[0], self.restitution_coefficient, 1.0)
        return elements_for(float(sizes[self._there[0]].min(initial=1.0)))

    @cached_property
    def _nodes(self) -> ImpactNodes | None:
        """Few impacts in place of many, if the outcomes are smooth functions of one number."""
        return impact_nodes(self._impact, self.temperature) if self.velocity.size > _MANY else None

    @cached_property
    def _rows(self) -> Batch:
        """The impacts, or those in their place, as rows without a material."""
        return bodies_of(self._impact if self._nodes is None else self._nodes.impact)

    def _contact(self, reduced: PronySeries) -> PronySeries:
        """Return reduced moduli of the contacts of both bodies."""
        return contact_modulus(reduced, self.counter_material)

    def residuals(self, materials: Material, nuisances: Array) -> Array:
        """Return residuals of e, then of the contact times, then of the peak forces, then of what stuck."""
        if self.adhesion and isinstance(materials, StickyMaterial):
            collisions = self._collisions(materials)
            residuals = self._in_metric(dict(zip(_NAMES, collisions.values, strict=True))) - self._data
            residuals /= self._deviations
            # Just above the sticking velocity e^2 is nearly linear in the velocity, and e has a steep slope.
            square, deviation = self._squares
            residuals[:, 0] = (collisions.values[0] ** 2 - square) / deviation
            return np.hstack([residuals[:, self._there], surprise(self._groups, collisions.thresholds)])
        predicted = self._in_metric(self.predicted(materials))
        residuals = (predicted - self._data) / self._deviations
        if self._blur is not None:
            shifted = self._in_metric(self.predicted(materials, 1.0 + _STEP))
            slopes = (shifted - predicted) / _STEP
            # If the velocity is too high by a share x, e = v'/v is too low by the same share.
            slopes[:, 0] += 1.0 if self._relative[0] else self.measured["restitution_coefficient"]
            shares = np.where(self._there, slopes * self._blur / self._deviations, 0.0)
            # Inverse root of the covariance 1 + h h^T of one impact.
            square = (shares * shares).sum(axis=1, keepdims=True)
            along = (shares * np.where(self._there, residuals, 0.0)).sum(axis=1, keepdims=True)
            factor = (1.0 - 1.0 / np.sqrt(1.0 + square)) / np.maximum(square, 1e-300)
            residuals = residuals - np.where(square > 0.0, factor * along, 0.0) * shares
        return residuals[:, self._there]

    @cached_property
    def _data(self) -> Array:
        return self._in_metric(self.measured)

    def _in_metric(self, columns: dict[str, Array]) -> Array:
        """Return values, or their logarithms if the noise is relative, shape (..., n_measured, n)."""
        pairs = zip(self.measured, self._relative, strict=True)
        with np.errstate(divide="ignore", invalid="ignore"):
            return np.stack([np.log(columns[name]) if log else columns[name] for name, log in pairs], axis=-2)

    def curves(self, materials: Material, nuisances: Array) -> list[Curve]:
        """Return measured and fitted values over the velocity."""
        predicted = self.predicted(materials)
        curves: list[Curve] = []
        for name, values, sd, log in zip(self.measured, self.measured.values(), self._deviations, self._relative,
                                         strict=True):  # fmt: skip
            deviation = None if self.scaled else sd * values if log else sd
            curves.append(
                Curve(name, "velocity", self.velocity, values, predicted[name][0], deviation, self._bodies())
            )
        return curves

    def _bodies(self) -> tuple[tuple[str, Array], ...]:
        """Return quantities that distinguish the bodies; none that only follows an earlier one."""
        columns_of: list[tuple[str, Array]] = []
        count = 1
        for name in ("radius", "mass", "temperature"):
            if (values := getattr(self, name)) is not None:
                columns = np.column_stack([*(values for _, values in columns_of), values])
                if (more := len(np.unique(columns, axis=0))) > count:
                    columns_of.append((name, values))
                    count = more
        return tuple(columns_of)

    def window(self) -> tuple[float, float]:
        """Return the lowest and highest pi/(contact time) [rad/s]; NaN if neither time nor force was measured."""
        times = self._times()
        finite = times[np.isfinite(times)]
        return (math.pi / float(finite.max()), math.pi / float(finite.min())) if finite.size else (math.nan, math.nan)

    def _times(self) -> Array:
        """Return contact times [s], measured or from the peak force on an elastic material, shape (n,)."""
        times = np.full(self.velocity.size, np.nan) if self.contact_time is None else self.contact_time
        if self.max_force is None:
            return times
        # Both time and force follow from the depth, for any modulus.
        elastic_time, elastic_force = self._elastic
        return np.where(np.isnan(times), elastic_time * elastic_force / self.max_force, times)

    def contact_times(self, materials: Material) -> Array:
        """Return contact times [s] on each material, shape (m, n)."""
        return self.predicted(materials)["contact_time"]

    def effective_moduli(self) -> DynamicTable | None:
        """Return E* by the formulas of single bounces; None if neither time nor force was measured."""
        times = self._times()
        return self._moduli(times) if np.any(np.isfinite(times)) else None

    def moduli_by_temperature(self) -> list[DynamicTable]:
        """Return the effective moduli, a table for each temperature."""
        if self.temperature is None:
            return super().moduli_by_temperature()
        times = self._times()
        each = {
            float(level): np.where(self.temperature == level, times, np.nan) for level in np.unique(self.temperature)
        }
        return [
            replace(self._moduli(times_there), temperature=level)
            for level, times_there in each.items()
            if np.any(np.isfinite(times_there))
        ]

    def assumed_moduli(self, modulus: float) -> DynamicTable:
        """Return E* of an assumed size [Pa], by the same formulas."""
        return self._moduli(self._elastic[0] * modulus ** (-1.0 / self._power))

    @property
    def _power(self) -> float:
        """Power of the depth, and of the contact time, in an elastic contact: E*^(-1/power), 5/2 for a parabola."""
        return 2.0 + 0.5 * float(self.profile.path_exponent if self.profile.path_exponent is not None else 1.0)

    def _moduli(self, times: Array) -> DynamicTable:
        # A body that sticks shows no loss of the material.
        rebounded = self.restitution_coefficient > 0.0
        there = _thinned(np.isfinite(times) & (rebounded if rebounded.any() else True), times)
        loss = -np.log(self.restitution_coefficient[there] if rebounded.any() else np.full(int(there.sum()), _UNSEEN))
        with np.errstate(over="ignore", under="ignore"):
            elastic = (self._elastic[0][there] / times[there]) ** self._power
            omega, storage, tangent = moduli_of_bounces(loss, elastic, times[there])
        bad = np.flatnonzero(~((storage > _MODULUS_RANGE[0]) & (storage < _MODULUS_RANGE[1])))
        if bad.size:
            rule = "is not that of a material: compare the units of mass, radius, velocity, contact time and force"
            raise InputError(
                "storage_modulus", float(storage[bad[0]]), rule, "Pa", index=(int(np.flatnonzero(there)[bad[0]]),)
            )
        order = np.argsort(omega)
        omega, storage, loss = omega[order], storage[order], (tangent * storage)[order]
        if self.counter_material is not None:
            alone = alone_of(storage + 1j * loss, omega, self.counter_material)
            storage, loss = alone.real, np.maximum(alone.imag, 0.0)
        return DynamicTable(omega, storage, loss, source=self.label)

    def assumed_contact(self, modulus: float) -> tuple[float, float] | None:
        """Return the work of adhesion [J/m^2] of an elastic body that sticks like these, and its radius [m]."""
        if not self.adhesion:
            return None
        stuck = self.restitution_coefficient == 0.0
        place = int(np.argmax(np.where(stuck, self.velocity, 0.0)) if stuck.any() else np.argmin(self.velocity))
        velocity = float(self.velocity[place]) * (1.0 if stuck.any() else _BELOW)
        bodies = next(bodies for bodies in self._groups if place in bodies.places)
        # The radius of curvature where the elastic contact is largest.
        depth = velocity * float(self._elastic[0][place]) * modulus ** (-1.0 / self._power) / HERTZ_TIME_FACTOR
        radius = float(bodies.profile.contact_radius(depth)) ** 2 / depth
        return work_of_sticking(radius, bodies.mass, velocity, modulus), radius

    @cached_property
    def _elastic(self) -> tuple[Array, Array]:
        """Contact times [s] and peak forces [N] on an elastic material of E* = 1 Pa without weight, shape (n,)."""
        # Two bodies of 2 Pa are in contact like one body of 1 Pa; all known bodies are much stiffer.
        shear = PronySeries.springs(np.full((1, 1), 0.5 if self.counter_material == "same" else 0.25))
        # Temperatures need a shift; a spring has no times.
        material = Material(shear, math.inf, shift=Arrhenius(300.0, 1.0))
        outcomes = self.predicted(material, external_force=np.zeros(1))
        return outcomes["contact_time"][0], outcomes["max_force"][0]

    def _doubt(self, materials: StickyMaterial) -> float:
        """Return the largest error of e of the first row by few elements, over its noise."""
        e, finer = (self._collisions(materials, finer=n).values[0, 0] for n in (1, 2))
        sizes = np.abs(self._deviations[0] * np.where(self._relative[0], e, 1.0))
        return float(np.where(self._there[0], np.abs(finer - e) / sizes, 0.0).max())

    def doubts(self, materials: Material, nuisances: Array) -> list[str]:
        """Return doubts about the elements and the zone of the adhesion, in words."""
        if not (self.adhesion and isinstance(materials, StickyMaterial)):
            return []
        profiles = [bodies.profile for bodies in self._groups]
        reduced = self._moduli_at(materials, self.temperature).broadcast_to((1, self.velocity.size))
        reduced = reduced.take((slice(None), np.array([bodies.places[0] for bodies in self._groups])))
        return doubts_of(self._doubt(materials), profiles, reduced, materials, self._count)

    def __repr__(self) -> str:
        return f"Rebounds({self.velocity.size} impacts, {', '.join(self.measured)})"


def _thinned(there: NDArray[np.bool_], times: Array) -> NDArray[np.bool_]:
    """Return at most some hundred of the known impacts, evenly over their times; the moduli of so many are a start."""
    places = np.flatnonzero(there)
    if places.size <= _MANY:
        return there
    order = places[np.argsort(times[places], kind="stable")]
    thinned = np.zeros_like(there)
    thinned[order[np.linspace(0, order.size - 1, _MANY).astype(int)]] = True
    return thinned


def _shares(e: Array, *, sticking: bool) -> Array:
    """Return coefficients of restitution; 0, and NaN of a rebound that was not measured, only with adhesion."""
    good = ((e >= 0.0) & (e <= 1.0)) | np.isnan(e) if sticking else (e > 0.0) & (e <= 1.0)
    if not np.all(good):
        place = tuple(int(i) for i in np.argwhere(~np.atleast_1d(good))[0])
        bad = float(np.atleast_1d(e)[place])
        rule = "must be in [0, 1]" if sticking else "must be in (0, 1]"
        rule += "; give adhesion=True if the bodies stick" * (bad == 0.0)
        raise InputError("restitution_coefficient", bad, rule, index=place if e.ndim else ())
    return e


def _measured(name: str, values: Any, unit: str) -> Array:
    """Return values > 0, or NaN where nothing was measured."""
    numbers = checks.number(name, values, unit)
    checks.positive(name, np.where(np.isnan(numbers), 1.0, numbers), unit)
    if np.all(np.isnan(numbers)):
        raise InputError(name, math.nan, "must hold at least one number", unit)
    return numbers


def _broadcast(columns: dict[str, Any]) -> dict[str, Array]:
    """Return columns of one shape (n,), where numbers are repeated."""
    shapes = {name: np.shape(values) for name, values in columns.items()}
    lengths = {shape for shape in shapes.values() if shape}
    shape = lengths.pop() if lengths else (1,)
    if lengths or len(shape) != 1:
        listed = ", ".join(f"{name} {shape}" for name, shape in shapes.items())
        raise InputError(", ".join(columns), rule=f"must be single numbers, or arrays of one shape (n,): {listed}")
    if shape == (0,):
        raise InputError(", ".join(columns), rule="must hold at least one impact")
    return {name: np.broadcast_to(np.asarray(values, dtype=np.float64), shape) for name, values in columns.items()}
