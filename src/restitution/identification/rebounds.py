"""Measured rebounds: restitution coefficients, contact times and peak forces of impacts."""

from __future__ import annotations

import math
from dataclasses import replace
from functools import cached_property
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from restitution import checks, quantities
from restitution.contact.geometry import Geometry
from restitution.contact.profile import Parabola
from restitution.errors import InputError, InputTypeError
from restitution.identification.effective_moduli import moduli_of_bounces
from restitution.identification.impact_nodes import ImpactColumns, ImpactNodes, impact_nodes
from restitution.identification.observations import Curve, Noise, Observations
from restitution.impact.batch import Batch
from restitution.impact.status import Status
from restitution.material.columns import MaterialColumns, PronyColumns
from restitution.material.fit import DynamicTable
from restitution.material.prony import PronySeries
from restitution.material.viscoelastic import Material, reduced_modulus

Array = NDArray[np.float64]

_RTOL = 1e-9
# Above this number of impacts their outcomes are interpolated.
_MANY = 400
# Relative change of the velocity for slopes over the velocity.
_STEP = 1e-3
# Moduli [Pa] of anything that bounces, with room to spare.
_MODULI = 1e-30, 1e30
_NAMES = ("restitution_coefficient", "contact_time", "max_force")
# Noise of unknown size has these ratios.
_UNKNOWN = Noise(restitution_coefficient=0.01, contact_time="1 %", max_force="1 %")


class Rebounds(Observations):
    """Rebounds of rigid bodies from a viscoelastic half-space, or of two bodies from each other.

    Parameters
    ----------
    velocity : array_like
        Impact velocities v [m/s], > 0, shape (n,).
    restitution_coefficient : array_like
        Measured e [-] in (0, 1].
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
    noise : Noise, optional
        Standard deviations of `restitution_coefficient`, `contact_time`, `max_force` and `velocity`: absolute ones of
        the value, relative ones of its logarithm. Without them the size of the noise is estimated. With noise of the
        velocity, e is taken as v'/v, and the noise of e is that of v'/v at a known v.
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
    they are models of the same kind.

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
        noise: Noise | None = None,
        label: str = "",
    ) -> None:
        self.label, self.noise = label, Noise.given(noise)
        named = isinstance(counter_material, str) and counter_material == "same"
        if not (counter_material is None or named or isinstance(counter_material, Material)):
            raise InputTypeError("counter_material", counter_material, 'must be a Material or "same"')
        self.counter_material = counter_material
        given: dict[str, Any] = {
            name: quantities.check(name, value)
            for name, value in (("velocity", velocity), ("mass", mass), ("external_force", external_force))
        }
        e = checks.number("restitution_coefficient", restitution_coefficient)
        measured = {"restitution_coefficient": _refused_unless("restitution_coefficient", e, (e > 0.0) & (e <= 1.0))}
        for name, values, unit in (("contact_time", contact_time, "s"), ("max_force", max_force, "N")):
            if values is not None:
                measured[name] = _measured(name, values, unit)
        if (radius is None) == (profile is None):
            raise InputError("radius, profile", wanted="exactly one must be given")
        if profile is None:
            given["radius"] = quantities.check("radius", radius)
        elif not isinstance(profile, Geometry) or profile.needs_poisson_ratio:
            raise InputTypeError("profile", profile, "must be a Geometry that needs no Poisson ratio, no bonded layer")
        elif np.ndim(profile.path_exponent if profile.path_exponent is not None else profile.stiffness_radius(0.0)):
            raise InputError("profile", wanted="must be a single profile; give several as several sets of data")
        if temperature is not None:
            given["temperature"] = quantities.check("temperature", temperature)
        columns = _broadcast(given | measured)
        self.velocity, self.mass = columns["velocity"], columns["mass"]
        self.external_force, self.temperature = columns["external_force"], columns.get("temperature")
        self.radius = columns.get("radius")
        self.profile = Parabola(self.radius) if profile is None else profile  # pyright: ignore[reportArgumentType]
        self.measured = {name: columns[name] for name in _NAMES if name in measured}
        self.restitution_coefficient = self.measured["restitution_coefficient"]
        self.contact_time, self.max_force = self.measured.get("contact_time"), self.measured.get("max_force")
        if "radius" in columns and "contact_time" in columns:
            with np.errstate(over="ignore"):
                strain = columns["contact_time"] * self.velocity / columns["radius"]
            if np.any(strain > 3.0):  # an elastic body sinks in by a third of that
                worst = int(np.nanargmax(strain))
                wanted = "must be in s: the body would move by more than its radius during contact"
                raise InputError("contact_time", float(columns["contact_time"][worst]), wanted, "s", index=(worst,))
        self._set_noise()

    def _set_noise(self) -> None:
        known = [name in self.noise.deviations for name in self.measured]
        for name in self.noise.deviations:
            if name not in (*self.measured, "velocity"):
                raise InputError(f"noise.{name}", wanted=f"was not measured; measured are {', '.join(self.measured)}")
        if any(known) and not all(known):
            missing = list(self.measured)[known.index(False)]
            raise InputError(f"noise.{missing}", wanted="must be given, as that of another quantity is")
        self.scaled = not any(known)
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
        self._there = np.isfinite(np.array(list(self.measured.values())))

    @property
    def size(self) -> int:
        """Number of measured values."""
        return int(self._there.sum())

    def predicted(
        self, materials: MaterialColumns, velocity_factor: float = 1.0, external_force: Array | None = None
    ) -> dict[str, Array]:
        """Restitution coefficients, contact times and peak forces by name, shape (m, n); NaN without separation."""
        if (nodes := self._nodes) is None:
            return self._solved(materials, self._impacts, velocity_factor, external_force)
        found = self._solved(materials, nodes.impacts, velocity_factor, external_force)
        # The momentum is the scale of the force.
        scale = {"max_force": nodes.impacts.mass * nodes.impacts.velocity}
        own = {"max_force": self.mass * self.velocity}
        rows = {name: np.log(values / scale.get(name, 1.0)) for name, values in found.items()}
        return {name: np.exp(nodes.interpolated(values)) * own.get(name, 1.0) for name, values in rows.items()}

    @cached_property
    def _nodes(self) -> ImpactNodes | None:
        """Few impacts in place of many, if the outcomes are smooth functions of one number."""
        exponent = self.profile.path_exponent
        if self.velocity.size <= _MANY:
            return None
        return impact_nodes(self._impacts, None if exponent is None else float(np.asarray(exponent)))

    @cached_property
    def _impacts(self) -> ImpactColumns:
        """The measured impacts; without a coefficient (NaN) where the profile is no power law."""
        given: Any = self.profile.path_coefficient if self.profile.path_exponent is not None else math.nan
        coefficient = np.broadcast_to(np.asarray(given, dtype=np.float64), self.velocity.shape)
        return ImpactColumns(self.velocity, self.mass, self.external_force, self.temperature, coefficient)

    def _solved(
        self, materials: MaterialColumns, impacts: ImpactColumns, velocity_factor: float, external_force: Array | None
    ) -> dict[str, Array]:
        """Outcomes of impacts with the profile or its exponent, shape (m, n)."""
        m, n = materials.size, impacts.velocity.size
        if impacts.temperature is None:
            # Shape (m, n, n_branch) and (m, n) without a copy.
            contact = self._contact(materials.reduced)
            series = [np.broadcast_to(part[:, None], (m, n, *part.shape[1:])) for part in contact]
        else:
            levels, where = np.unique(impacts.temperature, return_inverse=True)
            each = [self._contact(materials.at(float(level)).reduced) for level in levels]
            series = [np.stack(parts, axis=1)[:, where] for parts in zip(*each, strict=True)]
        equilibria, viscosities, moduli, times = series
        force = impacts.external_force if external_force is None else external_force
        bodies = impacts.mass, velocity_factor * impacts.velocity, force
        flat = [np.broadcast_to(one, (m, n)).ravel() for one in bodies]
        exponent, power = self.profile.path_exponent, self.profile.path_exponent is not None
        batch = Batch(
            equilibria.ravel(), viscosities.ravel(), moduli.reshape(m * n, -1), times.reshape(m * n, -1), *flat,
            coefficients=np.broadcast_to(impacts.coefficient, (m, n)).ravel() if power else None,
            exponent=float(np.asarray(exponent)) if power else None, profile=None if power else self.profile,
        )  # fmt: skip
        found = batch.solve(_RTOL, workers=1)
        good = found["status"] == Status.SEPARATED
        return {name: np.where(good, found[name], np.nan).reshape(m, n) for name in _NAMES}

    def _contact(self, reduced: PronyColumns) -> PronyColumns:
        """Reduced moduli of the contacts of both bodies."""
        if self.counter_material is None:
            return reduced
        if isinstance(self.counter_material, str):
            return reduced.scaled(0.5)
        return reduced.in_series(self._counter)

    @cached_property
    def _counter(self) -> PronySeries:
        """Reduced modulus of the other body."""
        assert isinstance(self.counter_material, Material)
        return reduced_modulus(self.counter_material)

    def residuals(self, materials: MaterialColumns, nuisances: Array) -> Array:
        """Residuals of e, then of the contact times, then of the peak forces."""
        predicted = self._in_metric(self.predicted(materials))
        data = self._in_metric(self.measured)
        residuals = (predicted - data) / self._deviations
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

    def _in_metric(self, columns: dict[str, Array]) -> Array:
        """Values, or their logarithms if the noise is relative, shape (..., n_measured, n)."""
        pairs = zip(self.measured, self._relative, strict=True)
        with np.errstate(divide="ignore", invalid="ignore"):
            return np.stack([np.log(columns[name]) if log else columns[name] for name, log in pairs], axis=-2)

    def curves(self, materials: MaterialColumns, nuisances: Array) -> list[Curve]:
        """Measured and fitted values over the velocity."""
        found = self.predicted(materials)
        curves: list[Curve] = []
        for name, values, sd, log in zip(self.measured, self.measured.values(), self._deviations, self._relative,
                                         strict=True):  # fmt: skip
            deviation = None if self.scaled else sd * values if log else sd
            curves.append(Curve(name, "velocity", self.velocity, values, found[name][0], deviation, self._bodies()))
        return curves

    def _bodies(self) -> tuple[tuple[str, Array], ...]:
        """Quantities that distinguish the bodies; none that only follows an earlier one."""
        found: list[tuple[str, Array]] = []
        count = 1
        for name in ("radius", "mass", "temperature"):
            if (values := getattr(self, name)) is not None:
                columns = np.column_stack([*(one for _, one in found), values])
                if (more := len(np.unique(columns, axis=0))) > count:
                    found.append((name, values))
                    count = more
        return tuple(found)

    def window(self) -> tuple[float, float]:
        """Lowest and highest pi/(contact time) [rad/s]; NaN if neither time nor force was measured."""
        times = self._times()
        known = times[np.isfinite(times)]
        return (math.pi / float(known.max()), math.pi / float(known.min())) if known.size else (math.nan, math.nan)

    def _times(self) -> Array:
        """Contact times [s], measured or from the peak force on an elastic material, shape (n,)."""
        times = np.full(self.velocity.size, np.nan) if self.contact_time is None else self.contact_time
        if self.max_force is None:
            return times
        # Both time and force follow from the depth, for any modulus.
        elastic_time, elastic_force = self._elastic
        return np.where(np.isnan(times), elastic_time * elastic_force / self.max_force, times)

    def contact_times(self, materials: MaterialColumns) -> Array:
        """Contact times [s] on each material, shape (m, n)."""
        return self.predicted(materials)["contact_time"]

    def effective_moduli(self) -> DynamicTable | None:
        """E* by the formulas of single bounces; None if neither time nor force was measured."""
        times = self._times()
        return self._moduli(times) if np.any(np.isfinite(times)) else None

    def moduli_by_temperature(self) -> list[DynamicTable]:
        """The effective moduli, a table for each temperature."""
        if self.temperature is None:
            return super().moduli_by_temperature()
        times = self._times()
        each = {float(one): np.where(self.temperature == one, times, np.nan) for one in np.unique(self.temperature)}
        return [replace(self._moduli(own), temperature=one) for one, own in each.items() if np.any(np.isfinite(own))]

    def assumed_moduli(self, modulus: float) -> DynamicTable:
        """E* of an assumed size [Pa], by the same formulas."""
        return self._moduli(self._elastic[0] * modulus ** (-1.0 / self._power))

    @property
    def _power(self) -> float:
        """Power of the depth, and of the contact time, in an elastic contact: E*^(-1/power), 5/2 for a parabola."""
        return 2.0 + 0.5 * float(self.profile.path_exponent if self.profile.path_exponent is not None else 1.0)

    def _moduli(self, times: Array) -> DynamicTable:
        known = _thinned(np.isfinite(times), times)
        loss = -np.log(self.restitution_coefficient[known])
        with np.errstate(over="ignore", under="ignore"):
            elastic = (self._elastic[0][known] / times[known]) ** self._power
            omega, storage, tangent = moduli_of_bounces(loss, elastic, times[known])
        bad = np.flatnonzero(~((storage > _MODULI[0]) & (storage < _MODULI[1])))
        if bad.size:
            wanted = "is not that of a material: compare the units of mass, radius, velocity, contact time and force"
            raise InputError(
                "storage_modulus", float(storage[bad[0]]), wanted, "Pa", index=(int(np.flatnonzero(known)[bad[0]]),)
            )
        order = np.argsort(omega)
        omega, storage, loss = omega[order], storage[order], (tangent * storage)[order]
        if self.counter_material == "same":
            storage, loss = 2.0 * storage, 2.0 * loss
        elif self.counter_material is not None:
            pair = 1.0 / (storage + 1j * loss)
            own = pair - 1.0 / (self._counter.storage_modulus(omega) + 1j * self._counter.loss_modulus(omega))
            # By noise, the contact may be as stiff as the other body alone.
            own = np.where(own.real > 0.1 * pair.real, own, 0.1 * pair)
            storage, loss = np.real(1.0 / own), np.maximum(np.imag(1.0 / own), 0.0)
        return DynamicTable(omega, storage, loss, source=self.label)

    @cached_property
    def _elastic(self) -> tuple[Array, Array]:
        """Contact times [s] and peak forces [N] on an elastic material of E* = 1 Pa without weight, shape (n,)."""
        # Two bodies of 2 Pa are in contact like one of 1 Pa; any known one is much stiffer.
        one = PronyColumns.springs(np.full(1, 2.0 if self.counter_material == "same" else 1.0))
        material = MaterialColumns(one, one, one, lambda temperature: np.ones(1))
        found = self.predicted(material, external_force=np.zeros(1))
        return found["contact_time"][0], found["max_force"][0]

    def __repr__(self) -> str:
        return f"Rebounds({self.velocity.size} impacts, {', '.join(self.measured)})"


def _thinned(known: NDArray[np.bool_], times: Array) -> NDArray[np.bool_]:
    """At most some hundred of the known impacts, evenly over their times; the moduli of so many are a start."""
    places = np.flatnonzero(known)
    if places.size <= _MANY:
        return known
    order = places[np.argsort(times[places], kind="stable")]
    found = np.zeros_like(known)
    found[order[np.linspace(0, order.size - 1, _MANY).astype(int)]] = True
    return found


def _refused_unless(name: str, values: Array, good: NDArray[np.bool_]) -> Array:
    if not np.all(good):
        place = tuple(int(i) for i in np.argwhere(~np.atleast_1d(good))[0])
        bad = float(np.atleast_1d(values)[place])
        raise InputError(name, bad, "must be in (0, 1]", index=place if values.ndim else ())
    return values


def _measured(name: str, values: Any, unit: str) -> Array:
    """Values > 0, or NaN where nothing was measured."""
    numbers = checks.number(name, values, unit)
    checks.positive(name, np.where(np.isnan(numbers), 1.0, numbers), unit)
    if np.all(np.isnan(numbers)):
        raise InputError(name, math.nan, "must hold at least one number", unit)
    return numbers


def _broadcast(columns: dict[str, Any]) -> dict[str, Array]:
    """Columns of one shape (n,), where numbers are repeated."""
    shapes = {name: np.shape(values) for name, values in columns.items()}
    lengths = {shape for shape in shapes.values() if shape}
    shape = lengths.pop() if lengths else (1,)
    if lengths or len(shape) != 1:
        listed = ", ".join(f"{name} {shape}" for name, shape in shapes.items())
        raise InputError(", ".join(columns), wanted=f"must be single numbers, or arrays of one shape (n,): {listed}")
    if shape == (0,):
        raise InputError(", ".join(columns), wanted="must hold at least one impact")
    return {name: np.broadcast_to(np.asarray(values, dtype=np.float64), shape) for name, values in columns.items()}
