"""Measured oscillating indentations (dynamic nanoindentation): forces and phases over frequency and depth."""

from __future__ import annotations

import math
from functools import cached_property
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from restitution import checks
from restitution.checks import Array
from restitution.contact.geometry import Geometry
from restitution.errors import InputError
from restitution.identification.observations import (
    Curve,
    Noise,
    Observations,
    alone_of,
    contact_modulus,
    counter_of,
    mean_table,
    modulus,
    noise_of,
    number_or_none,
    profile_of,
)
from restitution.indentation.rim import Steady, steady_states
from restitution.material.fit import DynamicTable
from restitution.material.prony import PronySeries
from restitution.material.viscoelastic import Material
from restitution.quantities import MEASURED

_POLAR, _PARTS = ("force_amplitude", "phase"), ("storage_stiffness", "loss_stiffness")
# Relative noise of readings whose noise is not known; only their ratios matter.
_UNKNOWN = 0.01
# Change of the depth, over the depth, for slopes.
_NEAR = 1e-4
# Moduli [Pa] of matter.
_SOFTEST, _STIFFEST = 1e-6, 1e15


class Oscillations(Observations):
    """Small oscillations of an indenter about mean depths, in the steady state: dynamic nanoindentation.

    All columns are numbers, or arrays of one shape (n,), one entry for each oscillation.

    Parameters
    ----------
    frequency : float or array
        Frequency f [Hz].
    depth : float or array
        Mean d_0 of the depth [m], from first touch on.
    depth_amplitude : float or array
        Amplitude d_1 of the depth [m].
    force_amplitude, phase : float or array
        Amplitude F_1 of the force [N], and the phase [rad] by which it leads the depth.
    storage_stiffness, loss_stiffness : float or array
        In place of both: F_1 cos(phase)/d_1 and F_1 sin(phase)/d_1 [N/m], without those of the instrument.
    mean_force : float or array, optional
        Mean F_0 of the force [N]. It determines the modulus at rest.
    radius : float
        Radius of a parabolic tip [m].
    profile : Geometry
        Profile of the tip in place of the radius.
    counter_material : Material or "same", optional
        Material of the tip: rigid by default, "same" for that of the target.
    temperature : float, optional
        Temperature [K], for a model with a `shift`.
    noise : Noise, optional
        Standard deviations of what was measured, by the names of the columns, and of `depth`, that of each mean depth.
        A relative one of a stiffness refers to the magnitude of both parts. Without it the size of the noise is
        estimated.
    label : str
        Name of the data in messages.

    Raises
    ------
    InputError
        If a number is out of range, or an amplitude is not below the depth.

    Notes
    -----
    The model is the steady state of the exact contact (`rs.oscillate`), with the rim that leaves and touches in each
    period. The reading of the textbook, `F_1 = 2 a E*(i w) d_1`, has an error of first order in d_1/d_0.

    An error of the depth moves all columns of an oscillation together: with noise of the depth, residuals are over the
    Cholesky factor of `C = diag(s^2) + s_d^2 g g^T`, where g are the slopes of the measured columns over the depth,
    `F_1 a'/a` and `F_0 a/Pi`.

    Examples
    --------
    >>> tip = Oscillations(
    ...     [1.0, 10.0], 80e-9, 2e-9, storage_stiffness=[5e-4, 8e-4], loss_stiffness=[3e-4, 3e-4], radius=2.5e-6
    ... )
    >>> tip.size
    4
    """

    def __init__(
        self,
        frequency: Any,
        depth: Any,
        depth_amplitude: Any,
        *,
        force_amplitude: Any = None,
        phase: Any = None,
        storage_stiffness: Any = None,
        loss_stiffness: Any = None,
        mean_force: Any = None,
        radius: Any = None,
        profile: Geometry | None = None,
        counter_material: Material | Literal["same"] | None = None,
        temperature: Any = None,
        noise: Noise | None = None,
        label: str = "",
    ) -> None:
        self.label, self.profile = label, profile_of(number_or_none("radius", radius), profile)
        self.counter_material = counter_of(counter_material)
        if self.profile.rows:
            raise InputError("profile", rule="must be a single profile; give several as several sets of data")
        self.temperature = number_or_none("temperature", temperature)
        polar, parts = (force_amplitude, phase), (storage_stiffness, loss_stiffness)
        given_polar, given_parts = ([value is not None for value in pair] for pair in (polar, parts))
        names = _POLAR if any(given_polar) else _PARTS
        if not all(given_parts if names is _PARTS else given_polar) or (any(given_polar) and any(given_parts)):
            rule = "must be given, or storage_stiffness and loss_stiffness in place of both"
            raise InputError("force_amplitude, phase", rule=rule)
        numbers = {"frequency": frequency, "depth": depth, "depth_amplitude": depth_amplitude}
        numbers |= dict(zip(names, parts if names is _PARTS else polar, strict=True))
        if mean_force is not None:
            numbers["mean_force"] = mean_force
        columns = _columns(numbers)
        self.frequency, self.depth, self.depth_amplitude = (columns.pop(name) for name in tuple(numbers)[:3])
        self.measured = columns
        end = float(np.min(self.profile.max_depth))
        highest = self.depth + self.depth_amplitude
        checks.refuse("depth", self.depth, self.depth <= 0.0, "must be finite and > 0", "m")
        low = self.depth_amplitude >= self.depth
        checks.refuse("depth_amplitude", self.depth_amplitude, low, "must be below the depth", "m")
        checks.refuse("depth", highest, highest > end, f"must be <= {end:g} m, {self.profile.end}", "m")
        with np.errstate(all="ignore"):
            size = np.abs(self.apparent_modulus)
        rule = "is not that of a material: compare the units of radius, depth, amplitudes and force"
        checks.refuse("apparent_modulus", size, ~((size > _SOFTEST) & (size < _STIFFEST)), rule, "Pa")
        if names is _POLAR:
            turned = np.cos(self.measured["phase"]) <= 0.0
            rule = "must be below pi/2: the contact is a spring and a dashpot in parallel; subtract the instrument"
            checks.refuse("phase", self.measured["phase"], turned, rule, "rad")
        self._set_noise(noise)

    def _set_noise(self, noise: Noise | None) -> None:
        """Set the standard deviations of all measured values."""
        stated = noise_of(noise, tuple(self.measured), ("depth",))
        self.scaled = not stated.deviations
        missing = [name for name in self.measured if name not in stated.deviations]
        if "depth" in stated.deviations and missing:
            raise InputError(f"noise.{missing[0]}", rule="must be given, as that of the depth is")
        if isinstance(stated.deviations.get("phase"), (str, tuple)):
            rule = "must be a number: a phase has no natural scale"
            raise InputError("noise.phase", stated.deviations["phase"], rule, "rad")
        size = np.abs(self.stiffness)
        sizes: list[Array] = []
        for name, values in self.measured.items():
            scale = size if name in _PARTS else np.ones(size.shape) if name == "phase" else values
            deviation = _UNKNOWN * scale if self.scaled else stated.of(name, values, scale)
            assert deviation is not None
            sizes.append(np.broadcast_to(deviation, size.shape))
        self._deviations = np.concatenate(sizes)
        self._whitening: Array | None = None
        deviation = stated.of("depth", self.depth)
        if deviation is not None:
            moved = deviation * self._slopes
            alone = np.stack(sizes, axis=1)[:, None] ** 2 * np.eye(len(sizes))
            covariances = alone + moved.T[:, :, None] * moved.T[:, None]
            self._whitening = np.asarray(np.linalg.inv(np.linalg.cholesky(covariances)), dtype=np.float64)
            self._deviations = np.sqrt(np.diagonal(covariances, axis1=1, axis2=2)).T.ravel()

    @property
    def _slopes(self) -> Array:
        """Slopes of the measured columns over the depth, shape (columns, n), without the rim."""
        near, far = (np.asarray(self.profile.stiffness_radius(self.depth * (1.0 + part))) for part in (-_NEAR, _NEAR))
        growth = (far - near) / (_NEAR * self.depth * (far + near))
        radius = np.asarray(self.profile.stiffness_radius(self.depth))
        rest = radius / np.asarray(self.profile.force_integral_at_depth(self.depth))
        factors = {"phase": 0.0 * growth, "mean_force": rest}
        return np.stack([values * factors.get(name, growth) for name, values in self.measured.items()])

    @property
    def size(self) -> int:
        """Number of measured values."""
        return len(self.measured) * self.frequency.size

    @cached_property
    def stiffness(self) -> NDArray[np.complex128]:
        """Complex stiffness F_1/d_1 [N/m] that was measured, shape (n,)."""
        if "phase" in self.measured:
            parts = self.measured["force_amplitude"] * np.exp(1j * self.measured["phase"]) / self.depth_amplitude
        else:
            parts = self.measured["storage_stiffness"] + 1j * self.measured["loss_stiffness"]
        return np.asarray(parts, dtype=np.complex128)

    @cached_property
    def apparent_modulus(self) -> NDArray[np.complex128]:
        """Reading of the textbook, F_1/(2 a d_1) [Pa], shape (n,)."""
        return self.stiffness / (2.0 * np.asarray(self.profile.stiffness_radius(self.depth)))

    def states(self, reduced: PronySeries) -> Steady:
        """Return the steady states on m materials of shape (m, 1), m n rows, those of the first material first."""
        m, n = reduced.shape[0], self.frequency.size
        series = reduced.broadcast_to((m, n)).reshaped((m * n,))
        waves = (np.tile(values, m) for values in (self.depth, self.depth_amplitude, self.frequency))
        return steady_states(self.profile, series, *waves)

    def predicted(self, materials: Material) -> dict[str, Array]:
        """Return what was measured on each material, shape (m, n); NaN without a steady state."""
        harmonics = self.states(contact_modulus(modulus(materials, self.temperature), self.counter_material)).harmonics
        mean, stiffness = harmonics.reshape(materials.shape[0], -1, 2).transpose(2, 0, 1)
        stiffness = stiffness / self.depth_amplitude
        every = {
            "force_amplitude": np.abs(stiffness) * self.depth_amplitude,
            # About the measured phase, where the branch of the angle does not matter.
            "phase": np.angle(stiffness / self.stiffness) + np.angle(self.stiffness),
            "storage_stiffness": stiffness.real, "loss_stiffness": stiffness.imag, "mean_force": mean.real,
        }  # fmt: skip
        return {name: every[name] for name in self.measured}

    def residuals(self, materials: Material, nuisances: Array) -> Array:
        """Return residuals of the columns, one after the other."""
        predicted = np.hstack([*self.predicted(materials).values()])
        apart = predicted - np.concatenate([*self._data.values()])
        if self._whitening is None:
            return apart / self._deviations
        columns = apart.reshape(apart.shape[0], len(self.measured), -1)
        return np.einsum("nij,mjn->min", self._whitening, columns).reshape(apart.shape)

    @cached_property
    def _data(self) -> dict[str, Array]:
        return self.measured | ({"phase": np.angle(self.stiffness)} if "phase" in self.measured else {})

    def curves(self, materials: Material, nuisances: Array) -> list[Curve]:
        """Return measured and fitted columns over the frequency."""
        deviations = np.split(self._deviations, len(self.measured))
        bodies = tuple(
            (name, values) for name, values in (("depth", self.depth), ("depth_amplitude", self.depth_amplitude))
            if np.ptp(values) > 0.0
        )  # fmt: skip
        return [
            Curve(name, "frequency", self.frequency, self._data[name], fitted[0], None if self.scaled else sd, bodies)
            for (name, fitted), sd in zip(self.predicted(materials).items(), deviations, strict=True)
        ]

    def window(self) -> tuple[float, float]:
        """Return the lowest and highest angular frequency [rad/s]."""
        return 2.0 * math.pi * float(self.frequency.min()), 2.0 * math.pi * float(self.frequency.max())

    @property
    def static_modulus(self) -> Array:
        """Equilibrium modulus F_0/(2 Pi(d_0)) [Pa] of a contact at rest with the mean force, shape (n,)."""
        return self.measured["mean_force"] / (2.0 * np.asarray(self.profile.force_integral_at_depth(self.depth)))

    @property
    def modulus_noise(self) -> tuple[Array, Array]:
        """Standard errors of both parts of the reading [Pa] from the noise, NaN if it is unknown, shape (n,)."""
        n, modulus = self.frequency.size, np.abs(self.apparent_modulus)
        if self.scaled:
            return np.full(n, np.nan), np.full(n, np.nan)
        first, second = self._deviations[:n], self._deviations[n : 2 * n]
        if "phase" not in self.measured:
            factor = modulus / np.abs(self.stiffness)
            return first * factor, second * factor
        share, phase = first / self.measured["force_amplitude"], np.angle(self.stiffness)
        return (
            modulus * np.hypot(np.cos(phase) * share, np.sin(phase) * second),
            modulus * np.hypot(np.sin(phase) * share, np.cos(phase) * second),
        )

    def effective_moduli(self) -> DynamicTable | None:
        """Return the readings of the textbook, the mean where several have one frequency."""
        read = alone_of(self.apparent_modulus, 2.0 * math.pi * self.frequency, self.counter_material)
        return mean_table(
            2.0 * math.pi * self.frequency, read.real, np.maximum(read.imag, 1e-9 * np.abs(read)), None, self.label
        )

    def __repr__(self) -> str:
        return f"Oscillations({self.frequency.size} oscillations, {', '.join(self.measured)})"


def _columns(numbers: dict[str, Any]) -> dict[str, Array]:
    """Return columns in SI of one shape (n,), where numbers are repeated."""
    values = {name: np.asarray(MEASURED[name].check(value, name)) for name, value in numbers.items()}
    shapes = {name: value.shape for name, value in values.items()}
    lengths = {shape for shape in shapes.values() if shape} or {(1,)}
    if len(lengths) > 1 or len(shape := lengths.pop()) != 1 or shape == (0,):
        listed = ", ".join(f"{name} {shape}" for name, shape in shapes.items())
        raise InputError(", ".join(numbers), rule=f"must be single numbers, or arrays of one shape (n,): {listed}")
    return {name: np.broadcast_to(value, shape) for name, value in values.items()}
