"""Cantilevers that tap: their modes, the drive, and the pull of the surface."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence, Sized
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from restitution.checks import Array, is_iterable, single_positive
from restitution.contact.geometry import Geometry
from restitution.contact.profiles import Parabola, Sphere
from restitution.errors import InputError

MOST_MODES = 16


@dataclass(frozen=True)
class CantileverMode:
    """Mode of a cantilever, an oscillator `m z'' + (m w0/Q) z' + k z` of the height z of the tip, m = k/w0^2.

    Parameters
    ----------
    spring_constant : float
        Modal stiffness k at the tip [N/m], > 0.
    frequency : float
        Undamped resonance w0/(2 pi) [Hz], > 0.
    quality_factor : float
        Quality factor Q [-], > 0.5.

    Raises
    ------
    InputError
        If a number is out of its range.

    Examples
    --------
    >>> import restitution as rs
    >>> rs.CantileverMode(spring_constant=80.0, frequency=400e3, quality_factor=300.0).mass
    1.266...e-11
    """

    spring_constant: float
    frequency: float
    quality_factor: float

    def __post_init__(self) -> None:
        single_positive("spring_constant", self.spring_constant, "N/m")
        single_positive("frequency", self.frequency, "Hz")
        if single_positive("quality_factor", self.quality_factor) <= 0.5:
            raise InputError("quality_factor", self.quality_factor, "must be > 0.5, an oscillator")

    @property
    def mass(self) -> float:
        """Modal mass m [kg] at the tip."""
        return self.spring_constant / (2.0 * math.pi * self.frequency) ** 2

    @property
    def damping(self) -> float:
        """Damping m w0/Q [kg/s]."""
        return self.mass * 2.0 * math.pi * self.frequency / self.quality_factor


def beam_modes(
    *, spring_constant: float, frequency: float, quality_factors: Sequence[float]
) -> tuple[CantileverMode, ...]:
    """Return the higher modes of a rectangular beam from its first one.

    Parameters
    ----------
    spring_constant : float
        Modal stiffness k_1 of the first mode at the tip [N/m], > 0; 1.03 times the static stiffness.
    frequency : float
        Resonance of the first mode [Hz], > 0.
    quality_factors : sequence of float
        Quality factor of the second mode, the third, and so on; their number is that of the modes, up to 16.

    Returns
    -------
    tuple of CantileverMode
        The second mode and the following.

    Raises
    ------
    InputError
        If a number is out of its range.

    Notes
    -----
    A uniform beam that is clamped at one end and free at the other (Euler-Bernoulli) [1]_: with the roots of
    `cos(b) cosh(b) = -1`, b_1 = 1.8751, b_2 = 4.6941, b_3 = 7.8548, ..., frequencies grow like b_n^2: 6.2669 and
    17.547 times the first. All modes have a quarter of the mass of the beam at the tip, so that stiffnesses grow like
    the squares of the frequencies. A tip with a mass of its own, a V shape or a coating changes these ratios: measured
    modes are given as `CantileverMode`.

    References
    ----------
    .. [1] H.-J. Butt, M. Jaschke, Nanotechnology 6 (1995) 1-7.

    Examples
    --------
    >>> import restitution as rs
    >>> second, third = rs.beam_modes(spring_constant=2.0, frequency=70e3, quality_factors=[300.0, 400.0])
    >>> print(f"{second.frequency / 70e3:.4f} {third.frequency / 70e3:.3f} {second.spring_constant / 2.0:.3f}")
    6.2669 17.547 39.274
    """
    stiffness = single_positive("spring_constant", spring_constant, "N/m")
    lowest = single_positive("frequency", frequency, "Hz")
    sized = is_iterable(quality_factors) and isinstance(quality_factors, Sized)
    if not sized or not 0 < len(quality_factors) <= MOST_MODES:
        rule = f"must be a list of 1 to {MOST_MODES} quality factors, from the second mode on"
        raise InputError("quality_factors", quality_factors, rule)
    ratios = [(_beam_root(n) / _beam_root(1)) ** 2 for n in range(2, len(quality_factors) + 2)]
    return tuple(
        CantileverMode(stiffness * ratio**2, lowest * ratio, quality)
        for ratio, quality in zip(ratios, quality_factors, strict=True)
    )


def _beam_root(n: int) -> float:
    """Return the n-th root of cos(b) + 1/cosh(b) by Newton's method."""
    b = (n - 0.5) * math.pi
    for _ in range(20):
        b += (math.cos(b) + 1.0 / math.cosh(b)) / (math.sin(b) + math.tanh(b) / math.cosh(b))
    return b


class Cantilever(NamedTuple):
    """Oscillator `m z'' + c z' + k z = P cos(w t) + F`, with the height z of the tip over its rest.

    Heights of the higher modes, which F alone moves, add to z.
    """

    mass: float
    damping: float
    stiffness: float
    push: float  # P
    omega: float
    modes: tuple[CantileverMode, ...] = ()

    @property
    def response(self) -> complex:
        """Complex amplitude of the free oscillation."""
        w = self.omega
        return self.push / complex(self.stiffness - self.mass * w * w, self.damping * w)

    @property
    def higher(self) -> Array:
        """Mass, damping and stiffness of the higher modes, shape (M, 3)."""
        rows = [(mode.mass, mode.damping, mode.spring_constant) for mode in self.modes]
        return np.array(rows, dtype=np.float64).reshape(-1, 3)

    @property
    def frequencies(self) -> Array:
        """Angular frequencies [1/s] of the drive and of the higher modes."""
        return np.array([self.omega, *(2.0 * math.pi * mode.frequency for mode in self.modes)])


class Pull(NamedTuple):
    """Van der Waals force `-C/(gap + cutoff)^2` of the surface on the tip, constant in contact."""

    attraction: float = 0.0  # C = H R/6 [N m^2]
    cutoff: float = 1.0  # [m]


def cantilever(
    spring_constant: float, quality_factor: float, frequency: float, resonance_frequency: float | None,
    free_amplitude: float | None, drive: float | None, modes: Iterable[CantileverMode] = (),
) -> Cantilever:  # fmt: skip
    """Return a cantilever with the force of its drive, from what a user gives."""
    rate = single_positive("frequency", frequency, "Hz")
    first = CantileverMode(
        spring_constant, rate if resonance_frequency is None else resonance_frequency, quality_factor
    )
    if not is_iterable(modes):
        raise InputError("modes", modes, "must be a list of CantileverMode, as from beam_modes")
    higher = tuple(modes)
    for n, mode in enumerate(higher):
        if not isinstance(mode, CantileverMode):
            raise InputError(f"modes[{n}]", mode, "must be a CantileverMode, as from beam_modes")
    if len(higher) > MOST_MODES:
        raise InputError("modes", len(higher), f"must be at most {MOST_MODES}")
    lever = Cantilever(first.mass, first.damping, first.spring_constant, 1.0, 2.0 * math.pi * rate, higher)
    if drive is not None:
        return lever._replace(push=single_positive("drive", drive, "N"))
    amplitude = single_positive("free_amplitude", 1.0 if free_amplitude is None else free_amplitude, "m")
    return lever._replace(push=amplitude / abs(lever.response))


def pull_of(hamaker: float | None, distance: float, profile: Geometry) -> Pull:
    """Return the pull between a round tip and the surface, from what a user gives."""
    cutoff = single_positive("intermolecular_distance", distance, "m")
    if hamaker is None:
        return Pull()
    if not isinstance(profile, Parabola | Sphere):
        raise InputError("hamaker", hamaker, "needs a parabola or a sphere, for whose radius the force holds", "J")
    return Pull(single_positive("hamaker", hamaker, "J") * float(profile.radius) / 6.0, cutoff)
