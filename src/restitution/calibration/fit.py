"""The numbers of a law with which it is nearest to given collisions."""

from __future__ import annotations

import math
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

    The coefficient of restitution depends on the loss alone, and the contact time at a given loss on the stiffness.
    So the first determines the one, and the second the other. The largest error of e has one minimum over the
    loss, as each e falls with it.
    """
    from scipy.optimize import minimize_scalar

    grid = wanted.velocity[:, None], wanted.mass, wanted.reduced_radius
    unit = TypedLaw(law, wanted.static_modulus, 1.0, law.end)
    profile = np.broadcast_to(np.asarray(unit.loss(*grid)), wanted.restitution_coefficient.shape)
    goal = np.log(wanted.restitution_coefficient)

    def error(log_strength: float) -> float:
        e, _ = oscillator.rebound(law.shape, law.end, math.exp(log_strength) * profile)
        return float(np.abs(np.log(e) - goal).max())

    low, high = math.log(_LOWEST / profile.min()), math.log(_HIGHEST / profile.max())
    found: Any = minimize_scalar(error, bounds=(low, high), method="bounded", options={"xatol": 1e-10, "maxiter": 200})
    strength = math.exp(found.x)
    if strength * profile.max() < 10.0 * _LOWEST:
        strength = 0.0
    if np.isnan(wanted.contact_time).all():
        modulus = wanted.static_modulus
    else:
        _, time = oscillator.rebound(law.shape, law.end, strength * profile)
        _, scale = oscillator.scales(law.shape, unit.stiffness(*grid[1:]), grid[1], grid[0])
        ratio = np.log(time * scale / wanted.contact_time)
        modulus = wanted.static_modulus * math.exp(0.5 * (ratio.min() + ratio.max()) * (law.shape.spring + 1.0))
    stiffer = TypedLaw(law, modulus, 1.0, law.end).loss(*grid)
    strength *= float(profile.flat[0] / np.broadcast_to(np.asarray(stiffer), profile.shape).flat[0])
    _refuse_out_of_reach(law, strength, wanted)
    return TypedLaw(law, modulus, strength, law.end)


def _refuse_out_of_reach(law: Law, strength: float, wanted: Collisions) -> None:
    """Raise if no number that can be typed gives the strength."""
    weakest, strongest = law.strengths
    if weakest * (1.0 - 1e-6) <= strength <= strongest * (1.0 + 1e-6):
        return
    ends = oscillator.rebound(law.shape, law.end, [strongest, weakest])[0]
    e = wanted.restitution_coefficient
    given = f"{e.min():.6g} to {e.max():.6g}" if e.min() < e.max() else f"{e.max():.6g}"
    raise InputError("target", law.name, f"reaches e from {ends[0]:.6g} to {ends[1]:.6g}, but e is {given}")
