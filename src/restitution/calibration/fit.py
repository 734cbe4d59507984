"""The numbers of a law with which it is nearest to given collisions."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Any

import numpy as np

from restitution.calibration import oscillator
from restitution.calibration.collisions import Collisions
from restitution.calibration.laws import Law, TypedLaw
from restitution.errors import InputError

# Losses between which the nearest one is searched; the first stands for an elastic contact.
_LOWEST, _HIGHEST = 1e-9, 1e3


def nearest(law: Law, wanted: Collisions) -> TypedLaw:
    """Return the law with the smallest largest error of e, then with that of the contact time, both by ratios.

    e depends on the loss alone, and the contact time at a given loss on the stiffness: so e determines the loss, and
    the contact time the stiffness. If the contact time is not known, that of elastic balls does.
    """
    one = TypedLaw(law, wanted.static_modulus, 1.0, law.end)
    shape = wanted.restitution_coefficient.shape
    profile = np.broadcast_to(np.asarray(one.loss(*wanted.grid)), shape)
    strength = _nearest_strength(one, profile, wanted)
    known = not np.isnan(wanted.contact_time).all()
    time = wanted.contact_time if known else wanted.elastic_time
    found = replace(one, strength=strength if known else 0.0).rebound(*wanted.grid)[1]
    ratio = np.log(found / time)
    modulus = one.modulus * math.exp(0.5 * (ratio.min() + ratio.max()) * (law.shape.spring + 1.0))
    # The strength of the same loss at this stiffness.
    strength *= float(profile.max() / np.max(replace(one, modulus=modulus).loss(*wanted.grid)))
    _refuse_out_of_reach(law, strength, wanted)
    return TypedLaw(law, modulus, strength, law.end)


def _nearest_strength(one: TypedLaw, profile: Any, wanted: Collisions) -> float:
    """Strength at which the largest ratio of e to the wanted one is smallest, from the losses at a strength of 1."""
    from scipy.optimize import minimize_scalar

    goal = np.log(wanted.restitution_coefficient)

    def error(log_strength: float) -> float:
        e, _ = oscillator.rebound(one.law.shape, one.end, math.exp(log_strength) * profile)
        return float(np.abs(np.log(e) - goal).max())

    # Each e falls with the strength, so that there is one minimum.
    bounds = math.log(_LOWEST / profile.min()), math.log(_HIGHEST / profile.max())
    found: Any = minimize_scalar(error, bounds=bounds, method="bounded", options={"xatol": 1e-10, "maxiter": 200})
    strength = math.exp(found.x)
    return strength if strength * profile.max() > 10.0 * _LOWEST else 0.0


def _refuse_out_of_reach(law: Law, strength: float, wanted: Collisions) -> None:
    """Raise if no number that can be typed gives the strength."""
    weakest, strongest = law.strengths
    if weakest * (1.0 - 1e-6) <= strength <= strongest * (1.0 + 1e-6) or (strength == 0.0 and law.elastic):
        return
    ends = oscillator.rebound(law.shape, law.end, [strongest, weakest])[0]
    e = wanted.restitution_coefficient
    given = f"{e.min():.9g} to {e.max():.9g}" if e.min() < e.max() else f"{e.max():.9g}"
    reach = f"reaches e from {ends[0]:.6g} to {ends[1]:.6g}{' and 1' if law.elastic and weakest > 0.0 else ''}"
    raise InputError("target", law.name, f"{reach}, but e is {given}")
