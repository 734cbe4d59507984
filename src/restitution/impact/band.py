"""The band of e that assumptions leave open, above all of the relaxation beyond the times of the data."""

from __future__ import annotations

import math
import warnings
from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from restitution.checks import Array, instance
from restitution.errors import InputError, RestitutionWarning
from restitution.impact.problem import Impact
from restitution.impact.solve import solve
from restitution.material.extrapolation import Beyond, continued
from restitution.material.viscoelastic import Material

# The first tenth of a contact counts, and a decade more is enough for the terms there.
_FIRST, _MORE = 0.1, 1
_FARTHEST = 12
# Growths of the loss modulus beyond the data, None for that of their last decade, and how much stiffer than the fit
# the instantaneous modulus becomes. Neither e nor its lowest value is monotone in them.
_GROWTHS = (None, 0.0, 0.25, 0.5, 0.75, 1.0)
_STIFFENING = (math.inf, 2.0, 4.0, 10.0, 40.0)
# No more digits of a band than these are of use.
_RTOL = 1e-6


@dataclass(frozen=True)
class RestitutionBand:
    """Range of the coefficient of restitution over what is assumed.

    Attributes
    ----------
    low, high : float
        Lowest and highest e [-].
    words : str
        What the range is over.
    by_assumption : dict
        e [-] by some of the assumptions; NaN where the body does not separate.
    """

    low: float
    high: float
    words: str
    by_assumption: dict[str, float]

    def __str__(self) -> str:
        each = "; ".join(f"{words} {e:.4g}" for words, e in self.by_assumption.items())
        return f"e is {self.low:.3g} to {self.high:.3g} {self.words}: {each}"

    def to_dict(self) -> dict[str, Any]:
        """Return the band as plain numbers."""
        return vars(self).copy()


def restitution_band(impact: Impact) -> RestitutionBand | None:
    """Return the band of e of an impact that is shorter or longer than the data of its materials; None if it is not.

    Series that are fitted to data end half a decade beyond them. The band has these, and materials whose loss modulus
    goes on beyond the data with each growth that it may have, the frequency to the power 0 to 1, until the modulus is
    that of a glass or a smaller multiple of the fitted one. It is no strict bound.

    Parameters
    ----------
    impact
        A single impact.

    Raises
    ------
    InputError
        If there are several impacts.

    Examples
    --------
    >>> from restitution import Parabola, PronySeries
    >>> series = PronySeries(1e6, [1e6, 1e6, 1e6], [1e-2, 1e-1, 1.0])
    >>> rubber = Material(series, math.inf, window=(1e-2, 1.0))
    >>> band = restitution_band(Impact(rubber, Parabola(0.01), mass=0.005, velocity=1.0))
    >>> print(f"{band.low:.1f} to {band.high:.1f}")
    0.2 to 1.0
    """
    if instance("impact", impact, Impact, "must be an Impact").shape:
        raise InputError("impact", rule=f"must be one, not an array of shape {impact.shape}")
    first = solve(impact, rtol=_RTOL)
    duration = float(first.contact_time)
    materials = (impact.material, impact.counter_material)
    beyond = [_beyond(each, duration) for each in materials]
    if not any(map(any, beyond)):
        return None
    impacts: list[Impact] = []
    for growth in _GROWTHS:
        for factor in _STIFFENING:
            bodies: list[Any] = [
                each if each is None or not any(reach) else continued(each, reach, growth, stiffening=factor)
                for each, reach in zip(materials, beyond, strict=True)
            ]
            impacts.append(replace(impact, material=bodies[0], counter_material=bodies[1]))
    values = np.append(float(first.restitution_coefficient), _solved(impacts))
    by_assumption = {
        "if the relaxation ends with the data,": float(values[0]),
        "if it goes on as in their last decade,": float(values[1]),
    }
    return _band(values, "over the relaxation beyond the data", by_assumption)


def band_of(impacts: Mapping[str, Impact], words: str) -> RestitutionBand:
    """Return the band of impacts by what each assumes, which `words` names."""
    values = _solved(list(impacts.values()))
    return _band(values, words, dict(zip(impacts, values.tolist(), strict=True)))


def _band(values: Array, words: str, by_assumption: dict[str, float]) -> RestitutionBand:
    return RestitutionBand(float(np.nanmin(values)), float(np.nanmax(values)), words, by_assumption)


def _solved(impacts: list[Impact]) -> Array:
    """Return e of impacts, of few digits."""
    with warnings.catch_warnings():
        # The report of the impact itself has them.
        warnings.simplefilter("ignore", RestitutionWarning)
        return np.atleast_1d(np.asarray(solve(impacts, rtol=_RTOL).restitution_coefficient, dtype=np.float64))


def _beyond(material: Material | None, duration: float) -> Beyond:
    """Return the decades that a contact of a duration [s] is beyond the data of a material."""
    if material is None or material.window is None or not 0.0 < duration < math.inf:
        return Beyond(0, 0)
    low, high = map(float, material.window)
    return Beyond(_decades(low / (_FIRST * duration)), _decades(duration / high))


def _decades(ratio: float) -> int:
    return min(math.ceil(math.log10(ratio)) + _MORE, _FARTHEST) if ratio > 1.0 else 0
