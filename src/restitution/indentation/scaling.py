"""From SI to dimensionless numbers and back, for prescribed histories: the only place that knows how."""

from __future__ import annotations

import math
from itertools import pairwise
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from restitution.contact.contact import Contact
from restitution.contact.path import path_table, scaled
from restitution.contact.profile import Profile
from restitution.errors import InputError
from restitution.indentation.history import UNITS, History, restricted
from restitution.kernel.memory import allocate
from restitution.kernel.path import Path, power_path, table_path
from restitution.kernel.prescribed import DEPTH, FORCE
from restitution.kernel.prescribed import Contact as ScaledContact
from restitution.material.prony import PronySeries, Retardation

Array = NDArray[np.float64]

# Negative forces of less than this share of the largest are rounding of a return to zero.
_NO_FORCE = 1e-13
# Squares of depths, radii and forces must be normal numbers.
_SMALLEST, _LARGEST = 1e-150, 1e150


class Units(NamedTuple):
    """What one dimensionless unit is in SI.

    Attributes
    ----------
    touch : float
        Time of first touch [s].
    time, length, radius, force : float
        Duration of the history from then on [s], largest depth [m] or a bound of it, contact radius there [m], and
        `2 E radius length` [N] with a modulus E typical of the duration.
    error : float
        Error of forces, over the largest, that the table of the profile leaves; 0 for power laws.
    """

    touch: float
    time: float
    length: float
    radius: float
    force: float
    error: float


def contact_part(history: History, name: str) -> History:
    """History from first touch on; one that starts in contact or never touches is refused."""
    history = history.cut()
    ends = history.coefficients.sum(axis=1)
    # A piece does not change its sign within, and its middle is far from the rounding of its ends.
    middles = history.coefficients @ 0.5 ** np.arange(history.coefficients.shape[1])
    touching = np.flatnonzero(np.where(np.diff(history.knots) > 0.0, middles, ends) > 0.0)
    first = float(history.coefficients[0, 0])
    if first > 0.0:
        advice = "a curve that begins in contact needs its contact point: " if name == "depth" else ""
        wanted = f"must be <= 0 at the start; {advice}subtract an offset, or begin with a step, two points at one time"
        raise InputError(name, first, wanted, UNITS[name])
    if not touching.size:
        raise InputError(name, float(ends.max()), "must rise above 0; the bodies do not touch", UNITS[name])
    start = int(touching[0])
    if name == "force":
        least = np.minimum(ends, history.coefficients[:, 0])
        negative = least < -_NO_FORCE * ends.max()
        if np.any(negative):
            n = int(np.argmax(negative))
            wanted = f"must be >= 0, as there is no adhesion; it is not at time = {history.knots[n + 1]:g} s"
            raise InputError("force", float(least[n]), wanted, "N")
    coefficients = history.coefficients[start:].copy()
    coefficients[0, 1] += coefficients[0, 0] if history.knots[start + 1] == history.knots[start] else 0.0
    coefficients[0, 0] = 0.0
    return History(history.knots[start:], coefficients)


def largest_depth(series: PronySeries, profile: Profile, force: float, duration: float) -> float:
    """Bound of the depth [m] that a force [N] held for a time [s] reaches: that of the creep compliance."""
    integral = 0.5 * force * float(series.creep_compliance(duration))
    exponent, coefficient = profile.path_exponent, profile.path_coefficient
    if exponent is not None and coefficient is not None:
        p, c = float(exponent), float(coefficient)
        return (0.5 * (p + 2.0) * integral / c) ** (2.0 / (p + 2.0))
    most = float(profile.max_depth)
    low, high = -300.0, math.log(min(most, 1e100))
    if float(profile.force_integral_at_depth(min(math.exp(high), most))) < integral:
        return most
    for _ in range(60):
        middle = 0.5 * (low + high)
        if float(profile.force_integral_at_depth(min(math.exp(middle), most))) < integral:
            low = middle
        else:
            high = middle
    return min(math.exp(high), most)


def scaled_contact(bodies: Contact, history: History, name: str) -> tuple[ScaledContact, Units]:
    """Dimensionless contact, and its units; the history is prescribed from first touch on."""
    series, profile = bodies.reduced_modulus, bodies.profile
    by_depth = name == "depth"
    touch, duration = history.start, history.stop - history.start
    peak = float(history.coefficients.sum(axis=1).max())
    depth = peak if by_depth else largest_depth(series, profile, peak, duration)
    path, radius, error = _path(profile, depth)
    moduli, times = series.branch_moduli, series.relaxation_times
    typical = (
        series.equilibrium_modulus
        + float(moduli @ np.minimum(1.0, times / duration))
        + series.parallel_viscosity / duration
    )
    with np.errstate(over="ignore", under="ignore"):
        force = 2.0 * typical * radius * depth
    if not all(_SMALLEST < value < _LARGEST for value in (depth, radius, force)):
        wanted = (
            f"leads to a depth of {depth:.3g} m, a contact radius of {radius:.3g} m and a force of {force:.3g} N; "
        )
        wanted += f"each must be in [{_SMALLEST:g}, {_LARGEST:g}]"
        raise InputError(name, peak, wanted, UNITS[name])
    units = Units(touch, duration, depth, radius, force, error)
    rates = duration / times
    glass, compliances, recoveries = 0.0, np.empty(0), np.empty(0)
    if not by_depth:
        creep = scaled_retardation(series, units)
        glass = creep.instantaneous_compliance
        recoveries = 1.0 / creep.retardation_times
        compliances = creep.branch_compliances * recoveries
        if creep.fluidity > 0.0:
            recoveries = np.append(recoveries, 0.0)
            compliances = np.append(compliances, creep.fluidity)
        history = _graded(history)
    knots = (history.knots - touch) / duration
    segments = 0 if by_depth else knots.size - 1
    contact = ScaledContact(
        DEPTH if by_depth else FORCE, knots, history.coefficients / (depth if by_depth else units.force),
        series.equilibrium_modulus / typical, moduli / typical, rates, series.parallel_viscosity / typical / duration,
        float(np.min(1.0 / rates, initial=1.0)), glass, compliances, recoveries,
        allocate(recoveries, segments), allocate(recoveries, segments), path,
    )  # fmt: skip
    return contact, units


def _graded(history: History) -> History:
    """History whose first rise is cut towards first touch, so that what creeps there keeps its relative accuracy."""
    n = 0 if history.knots[1] > history.knots[0] else 1
    low, high = history.knots[n], history.knots[n + 1]
    fractions = np.concatenate([[0.0], 10.0 ** np.arange(-18, 1)])
    pieces = [restricted(history.coefficients[n], *ends) for ends in pairwise(fractions)]
    return History(
        np.concatenate([history.knots[:n], low + (high - low) * fractions[:-1], history.knots[n + 1 :]]),
        np.concatenate([history.coefficients[:n], pieces, history.coefficients[n + 1 :]]),
    )


def scaled_retardation(series: PronySeries, units: Units) -> Retardation:
    """Creep compliance in units of length radius/force and of the duration."""
    creep = series.retardation
    modulus = 0.5 * units.force / (units.radius * units.length)
    return Retardation(
        creep.instantaneous_compliance * modulus,
        creep.fluidity * modulus * units.time,
        creep.branch_compliances * modulus,
        creep.retardation_times / units.time,
    )


def _path(profile: Profile, depth: float) -> tuple[Path, float, float]:
    """Profile in units of the depth, the contact radius there [m], and the error of the table."""
    exponent: Any = profile.path_exponent
    radius: Any = profile.contact_radius(depth)
    if np.ndim(radius):
        raise InputError("profile", wanted="has arrays for parameters; an indentation has one profile")
    if exponent is not None:
        return power_path(float(exponent)), float(radius), 0.0
    table = path_table(profile, depth)
    return table_path(scaled(table, depth, radius)), float(radius), table.error
