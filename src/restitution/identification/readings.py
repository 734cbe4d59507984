"""Moduli that single measurements read: each bounce or oscillation is one point of a table over frequency."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from typing import TYPE_CHECKING, Any, ClassVar, overload

import numpy as np
from numpy.typing import NDArray

from restitution.checks import Array, Places, instance
from restitution.errors import InputError
from restitution.identification.bounce_moduli import EffectiveModuli, PointModuli, moduli_of_rebounds
from restitution.identification.impacts import Rebounds
from restitution.identification.oscillations import Oscillations
from restitution.indentation.rim import steady_states
from restitution.material.prony import PronySeries
from restitution.numerics.least_squares import descend
from restitution.quantities import MODULI, NUMBER, Quantity, dataset
from restitution.result import Summary, Table
from restitution.units import MODULUS

if TYPE_CHECKING:
    import xarray as xr

# Shares of the storage modulus that the equilibrium modulus may be where no mean force was measured.
_SHARES = (0.2, 0.5, 0.8)
# Where the mean force makes the equilibrium modulus nearly the storage modulus, or more, it is this share of it: the
# rest is beyond the accuracy of any data.
_NEARLY, _MOST = 0.95, 0.995
# Least loss of a material over the magnitude, that to which a residual refers, and the residual below which the
# material explains the readings.
_LEAST_LOSS, _SMALL_LOSS, _SOLVED = 1e-4, 1e-2, 1e-6
# Share of the correction that counts to its error, beside the range of the models; and where only one explains it.
_DOUBT, _ALONE = 0.1, 0.3
# Descents to the readings: step of differences, share of the sum of squares, rounds.
_STEP, _ENOUGH, _ROUNDS, _FURTHEST = 1e-5, 1e-3, 60, 2.0
# Logarithms of the equilibrium modulus, of the rest of E' and of E'' over the magnitude of the reading.
_LOW, _HIGH = np.log([1e-6, 1e-4, 1e-9]), np.log(1e4)
# Relaxation times of a power law over that of the frequency, and exponents at which its ratio E'/E'' is tabulated.
_TIMES = 10.0 ** np.arange(-3.0, 4.0)
_EXPONENTS = np.linspace(-1.0, 0.95, 196)


@dataclass(frozen=True, eq=False, repr=False)
class OscillationModuli(PointModuli):
    """Complex reduced modulus from each oscillation, with the rim of the contact; arrays of shape (n,).

    Attributes
    ----------
    angular_frequency : array
        [rad/s].
    storage_modulus, loss_modulus, loss_tangent : array
        E*' and E*'' [Pa] and their ratio; NaN where no material explains the readings.
    storage_model_error, loss_model_error : array
        Error of the correction [Pa]: the range of the models of the spectrum, and a tenth of the correction.
    storage_modulus_error, loss_modulus_error, loss_tangent_error : array
        Standard errors from the noise of the stiffness, NaN if it is unknown.
    apparent_storage_modulus, apparent_loss_modulus : array
        Readings of the textbook, F_1/(2 a d_1) [Pa].
    equilibrium_modulus : array
        Modulus at rest [Pa] by the mean force; NaN without.
    statements : tuple of str
        What the correction assumes, in words.
    """

    _numbers = (
        "angular_frequency", "storage_modulus", "loss_modulus", "loss_tangent", "storage_model_error",
        "loss_model_error", "storage_modulus_error", "loss_modulus_error", "loss_tangent_error",
        "apparent_storage_modulus", "apparent_loss_modulus", "equilibrium_modulus", "statements",
    )  # fmt: skip
    points: ClassVar[str] = "oscillations"

    storage_model_error: Array
    loss_model_error: Array
    apparent_storage_modulus: Array
    apparent_loss_modulus: Array
    equilibrium_modulus: Array

    def to_dataset(self) -> xr.Dataset:
        """Table of the oscillations over the dimension `oscillation`, with units, without columns without a number."""
        columns: dict[str, tuple[Any, Quantity]] = {
            "oscillation": (np.arange(self.storage_modulus.size), Quantity("oscillation", NUMBER, "number"))
        }
        columns |= {name: (getattr(self, name), quantity) for name, quantity in _QUANTITIES.items()}
        kept = {name: column for name, column in columns.items() if not np.all(np.isnan(column[0]))}
        return dataset("oscillation", kept, {"statements": "\n".join(self.statements)})

    def summary(self, title: str = "") -> Summary:
        """Return a table of the oscillations, which `print` and notebooks show."""
        columns = {name: getattr(self, name) for name in _SHOWN}
        heads = tuple(f"{_QUANTITIES[name].words} [{_QUANTITIES[name].unit or '-'}]" for name in columns)
        rows = [tuple(f"{value:.5g}" for value in row) for row in zip(*columns.values(), strict=True)]
        return Summary(title or "Moduli of oscillations", Table(heads, rows), self.statements)


def _further(name: str, words: str) -> dict[str, Quantity]:
    return {name: Quantity(name, MODULUS, words)}


_QUANTITIES: dict[str, Quantity] = (
    {name: MODULI[name] for name in ("angular_frequency", "storage_modulus", "loss_modulus", "loss_tangent")}
    | _further("storage_model_error", "error of the correction of E'")
    | _further("loss_model_error", "error of the correction of E''")
    | _further("storage_modulus_error", "standard error of E'")
    | _further("loss_modulus_error", "standard error of E''")
    | {"loss_tangent_error": Quantity("loss_tangent_error", NUMBER, "standard error of the loss tangent")}
    | _further("apparent_storage_modulus", "E' as the textbook reads it")
    | _further("apparent_loss_modulus", "E'' as the textbook reads it")
    | _further("equilibrium_modulus", "equilibrium modulus")
)


_SHOWN = (
    "angular_frequency", "apparent_storage_modulus", "apparent_loss_modulus", "storage_modulus", "storage_model_error",
    "loss_modulus", "loss_model_error",
)  # fmt: skip
"""Columns of the printed table."""


@overload
def effective_moduli(data: Rebounds) -> EffectiveModuli: ...
@overload
def effective_moduli(data: Oscillations) -> OscillationModuli: ...
def effective_moduli(data: Rebounds | Oscillations) -> EffectiveModuli | OscillationModuli:
    """Return the storage and loss part of the reduced modulus E* from each bounce, or from each oscillation.

    Parameters
    ----------
    data : Rebounds or Oscillations
        Measured bounces of a parabolic or spherical body: with a contact time or a peak force, each is one point of a
        DMA table; without, only the loss tangent is known, at an unknown frequency. Or oscillating indentations,
        whose readings are corrected for the rim of the contact.

    Returns
    -------
    EffectiveModuli or OscillationModuli
        One row for each bounce or oscillation, with standard errors from the noise.

    Raises
    ------
    InputError
        If the profile of bounces is not a parabola, or the other body is not rigid.

    Notes
    -----
    **Bounces.** With L = -ln e, the contact time T, and d = v T/2.94328, the depth of an elastic body of this contact
    time::

        tan delta(1.13 pi/T) = 0.815 L
        E*'(1.3 pi/T) = E_H exp(-0.213 L - 0.061 L^2),  E_H = (15/16) m v^2 R^(-1/2) d^(-5/2)

    The storage modulus is moved to 1.13 pi/T by its local slope, (2/pi) delta. From the peak force F, with
    d = 1.25 m v^2/F, E*'(1.13 pi/T) = E_H exp(1.038 L - 0.484 L^2) and T = 2.94328 (d/v) exp(-0.53 L + 0.175 L^2).
    The constants are fits to the exact solver. For smooth spectra the loss tangent is right to a few per cent, for a
    single relaxation time to 30 %; `FORMULA_ERRORS` lists the families. Valid for 0.15 <= e <= 0.995, without weight.

    **Oscillations.** The reading F_1 = 2 a E*(i w) d_1 neglects the rim of the contact, which leaves and touches in
    each period. How wide the rim is depends on the equilibrium modulus, which the mean force determines, and hardly on
    the rest of the spectrum. For each oscillation there are two materials whose exact steady state has the measured
    F_1 and F_0: one with a single relaxation time, one with a power law. The result is the middle of their moduli at
    the frequency. Without a mean force, the equilibrium modulus is taken as 20, 50 and 80 % of the storage modulus:
    the error is then nearly as large as the correction.

    Examples
    --------
    >>> import restitution as rs
    >>> balls = rs.Rebounds([0.5, 1.0], [0.80, 0.78], radius=0.01, mass=0.03, contact_time=[1.1e-3, 0.96e-3])
    >>> rs.effective_moduli(balls).loss_tangent.round(3)
    array([0.182, 0.202])

    E* = 1 + 4 exp(-t) Pa at 1 rad/s, exactly 3 + 2i Pa, with an amplitude of a tenth of the depth:

    >>> solid = rs.Material(rs.PronySeries(0.25, [1.0], [1.0]), bulk=math.inf)
    >>> wave = rs.oscillate(solid, rs.Parabola(1.0), depth=1.0, amplitude=0.1, frequency=0.5 / math.pi)
    >>> force = wave.force_harmonics
    >>> tip = rs.Oscillations(
    ...     wave.frequency, 1.0, 0.1, storage_stiffness=force[1].real / 0.1, loss_stiffness=force[1].imag / 0.1,
    ...     mean_force=force[0].real, radius=1.0,
    ... )
    >>> found = rs.effective_moduli(tip)
    >>> print(f"read {found.apparent_loss_modulus[0]:.3f}, corrected {found.loss_modulus[0]:.3f} Pa")
    read 1.854, corrected 1.993 Pa
    """
    instance("data", data, (Rebounds, Oscillations), "must be Rebounds or Oscillations")
    if isinstance(data, Oscillations) and data.counter_material is not None:
        rule = "must be left out: the moduli are those of the contact of both bodies; rs.identify fits one of them"
        raise InputError("counter_material", rule=rule)
    return moduli_of_rebounds(data) if isinstance(data, Rebounds) else _moduli_of_oscillations(data)


# Materials whose steady state has the readings of an oscillation: models of the spectrum beside its frequency.

_Model = Callable[[Array, Array, Array, Array], PronySeries]
"""Maps equilibrium modulus, rest of the storage modulus and loss modulus [Pa], shape (n,), at w [rad/s] to series."""


def _one_time(equilibrium: Array, rest: Array, loss: Array, omega: Array) -> PronySeries:
    """Return standard solids."""
    x = rest / loss
    moduli, times = loss * (1.0 + x * x) / x, x / omega
    return PronySeries.from_checked(equilibrium, moduli[:, None], times[:, None], np.zeros(x.size))


def _of_unit(exponents: Array) -> tuple[NDArray[np.complex128], Array]:
    """Return the complex modulus of power laws of unit weight, and the part of the loss by their fastest modes."""
    z, spacing = 1j * _TIMES, math.log(_TIMES[1] / _TIMES[0])
    # All modes faster than the first, as a dashpot.
    fast = _TIMES[0] ** (1.0 - exponents) * np.exp(-0.5 * spacing * (1.0 - exponents)) / ((1.0 - exponents) * spacing)
    return (_TIMES ** -exponents[:, None] * (z / (1.0 + z))).sum(axis=1) + 1j * fast, fast


def _power_law(equilibrium: Array, rest: Array, loss: Array, omega: Array) -> PronySeries:
    """Return power laws over six decades, one mode each; the ratio of both moduli determines the exponent."""
    table = _of_unit(_EXPONENTS)[0]
    # The ratio falls with the exponent.
    exponents = np.interp(-np.log(rest / loss), -np.log(table.real / table.imag), _EXPONENTS)
    unit, fast = _of_unit(exponents)
    weight = loss / unit.imag
    return PronySeries.from_checked(
        equilibrium, weight[:, None] * _TIMES ** -exponents[:, None], _TIMES / omega[:, None], weight * fast / omega
    )


def _by_mean_force(data: Oscillations, model: _Model) -> tuple[NDArray[np.complex128], Array]:
    """Return complex and equilibrium moduli of the model that has the readings, NaN where there is none."""
    moduli, equilibria = _explained(data, model, None)
    shares = data.static_modulus / data.apparent_modulus.real
    if np.any(hard := np.isnan(moduli) & (shares > _NEARLY)):
        again = _explained(data, model, np.minimum(shares, _MOST))
        moduli, equilibria = (np.where(hard, *pair) for pair in zip(again, (moduli, equilibria), strict=True))
    return moduli, equilibria


def _explained(data: Oscillations, model: _Model, share: Array | float | None) -> tuple[NDArray[np.complex128], Array]:
    """Return the same with the equilibrium modulus by the mean force, or as a share of the storage modulus."""
    read, omega = _positive_loss(data.apparent_modulus), 2.0 * math.pi * data.frequency
    size, mean = np.abs(read), data.measured.get("mean_force", np.ones(read.size))
    radius = np.asarray(data.profile.stiffness_radius(data.depth))
    equilibrium = np.minimum(data.static_modulus, read.real) if share is None else share * read.real
    starts = np.stack([equilibrium, np.maximum(read.real - equilibrium, 0.01 * size), read.imag], axis=1)
    low, high = np.tile(_LOW, (size.size, 1)), np.full((size.size, 3), _HIGH)

    def residuals(at: Array, places: Places) -> Array:
        rows = np.repeat(places, at.shape[1])
        values = np.exp(at.reshape(-1, 3)) * size[rows, None]
        waves = data.depth[rows], data.depth_amplitude[rows], data.frequency[rows]
        harmonics = steady_states(
            data.profile, model(values[:, 0], values[:, 1], values[:, 2], omega[rows]), *waves
        ).harmonics
        apart = harmonics[:, 1] / (2.0 * data.depth_amplitude[rows] * radius[rows]) - read[rows]
        parts = [apart.real / read.real[rows], apart.imag / np.maximum(read.imag, _SMALL_LOSS * size)[rows]]
        if share is None:
            parts.append(harmonics[:, 0].real / mean[rows] - 1.0)
        return np.stack(parts, axis=1).reshape(*at.shape[:2], -1)

    steps = np.full(3, _STEP) if share is None else np.array([0.0, _STEP, _STEP])
    starts = np.clip(np.log(starts / size[:, None]), low + 1e-6, high - 1e-6)
    with np.errstate(all="ignore"):
        ends = descend(residuals, starts, low, high, steps, np.full(3, _FURTHEST), _ENOUGH, _ROUNDS)
        values = np.exp(ends.points) * size[:, None]
        moduli = model(values[:, 0], values[:, 1], values[:, 2], omega).complex_modulus(omega)
    unsolved = ~(np.sqrt(ends.costs) <= _SOLVED)
    moduli[unsolved] = complex(np.nan, np.nan)
    return moduli, np.where(unsolved, np.nan, values[:, 0])


def _positive_loss(moduli: NDArray[np.complex128]) -> NDArray[np.complex128]:
    """Return moduli whose loss, which noise may make negative, is above zero."""
    return moduli.real + 1j * np.maximum(moduli.imag, _LEAST_LOSS * np.abs(moduli))


def _moduli_of_oscillations(data: Oscillations) -> OscillationModuli:
    """Return the moduli of oscillations, the middle of those of the models."""
    has_force = "mean_force" in data.measured
    models = [partial(_by_mean_force, data, model) for model in (_one_time, _power_law)]
    if not has_force:
        models = [partial(_explained, data, _one_time, share) for share in _SHARES]
    modelled = [model() for model in models]
    moduli, equilibria = np.array([each for each, _ in modelled]), np.array([each for _, each in modelled])
    read: NDArray[np.complex128] = data.apparent_modulus
    lost = read.imag - _positive_loss(read).imag
    parts = moduli.real, moduli.imag + lost
    ends = [(np.fmin.reduce(part), np.fmax.reduce(part)) for part in parts]
    storage, loss = (0.5 * (low + high) for low, high in ends)
    doubt = np.where(np.isnan(moduli.real).any(axis=0), _ALONE, _DOUBT) * np.hypot(
        storage - read.real, loss - read.imag
    )
    storage_doubt, loss_doubt = (high - low + doubt for low, high in ends)
    storage_noise, loss_noise = (np.hypot(storage, loss) / np.abs(read) * each for each in data.modulus_noise)
    tangent = loss / storage
    tangent_noise = np.hypot(loss_noise, tangent * storage_noise) / storage
    unknown = np.full(storage.shape, np.nan)
    return OscillationModuli(
        2.0 * math.pi * data.frequency, storage, loss, tangent, storage_noise, loss_noise, tangent_noise,
        _statements(data, storage, has_force), storage_doubt, loss_doubt, read.real, read.imag,
        np.fmax.reduce(equilibria) if has_force else unknown,
    )  # fmt: skip


def _statements(data: Oscillations, storage: Array, has_force: bool) -> tuple[str, ...]:
    """Return what the correction assumes, and oscillations without a result, in words."""
    lines = [
        "The mean force determines the equilibrium modulus; the model error is the range of a single relaxation time "
        "and a power law, and a tenth of the correction."
        if has_force
        else "No mean force is known: the correction is for equilibrium moduli of 20 to 80 % of the storage modulus. "
        "Give mean_force."
    ]
    missing = int(np.isnan(storage).sum())
    if missing:
        lines.append(f"{missing} of {storage.size} oscillations: no material has these readings.")
    if has_force:
        heavy = int(np.sum(data.static_modulus > (2.0 - _MOST) * data.apparent_modulus.real))
        if heavy:
            lines.append(
                f"{heavy} of {storage.size} mean forces are larger than the storage modulus allows: the depth, the "
                "force or the calibration is wrong, or the material does not relax."
            )
    return tuple(lines)
