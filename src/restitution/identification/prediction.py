"""Predictions of impacts on identified materials, with bands; with adhesion also of bodies that may stick."""

from __future__ import annotations

import math
import warnings
from dataclasses import replace
from functools import partial
from typing import TYPE_CHECKING

import numpy as np

from restitution.checks import Array
from restitution.contact.profiles import as_profile
from restitution.errors import RestitutionWarning
from restitution.identification.adhesion import MOST, STEP, StickyMaterial, thick_stress
from restitution.identification.fit import EstimationProblem
from restitution.identification.uncertainty import Uncertainty, banded, limits
from restitution.impact.adhesive import problem_of
from restitution.impact.batch import solve_columns
from restitution.impact.dugdale import sticking
from restitution.impact.problem import Impact
from restitution.parallel import on_threads
from restitution.quantities import DEFAULT_OUTPUTS, NUMBER, OUTPUTS, Quantity
from restitution.variation import varied

if TYPE_CHECKING:
    import xarray

_RTOL = 1e-9
# With adhesion: tolerances of e and of the sticking velocity, and the multiple of the latter at which e^2 has a slope.
_ADHESIVE_RTOL, _STICKING_RTOL, _ABOVE = 1e-5, 1e-3, 1.05


def predicted(uncertainty: Uncertainty, impact: Impact, window: tuple[float, float], level: float) -> xarray.Dataset:
    """Return outputs of impacts on the material of a fit, with bands; see `Identification.predict`."""
    problem = uncertainty.estimation.problem
    velocity = np.broadcast_to(np.asarray(impact.velocity, dtype=np.float64), impact.shape).reshape(-1)
    # A row for each impact; the materials vary along another axis.
    flat = impact.take(np.arange(velocity.size))
    width = uncertainty.quantile(level)
    if problem.space.adhesion or impact.adhesion is not None:
        columns = _adhesive(uncertainty, flat, width)
    else:
        values, errors = uncertainty.linearised(partial(_outputs, problem, flat))
        low, high = limits(values, errors, width)
        high[0] = np.minimum(high[0], 1.0)
        columns = values, low, high
    axis = Quantity("impact", NUMBER, "number of the impact")
    numbers = np.arange(velocity.size, dtype=np.float64)
    described = [OUTPUTS[name] for name in DEFAULT_OUTPUTS]
    bands = banded(axis, numbers, level, dict(zip(described, zip(*columns, strict=True), strict=True)))
    _warn_outside(bands["contact_time"].to_numpy(), window)
    return bands.assign_coords(velocity=("impact", velocity))


def _warn_outside(times: Array, window: tuple[float, float]) -> None:
    """Warn of contacts that end, and are shorter or longer [s] than those of the window [rad/s]."""
    low, high = window
    frequency = math.pi / times[np.isfinite(times)]
    inside = (frequency > low * (1.0 - 1e-9)) & (frequency < high * (1.0 + 1e-9))
    if math.isfinite(low) and not np.all(inside):
        outside = int((~inside).sum())
        text = (f"{outside} of {times.size} impacts leave the window of the data, contact times from "
                f"{math.pi / high:.3g} to {math.pi / low:.3g} s")  # fmt: skip
        warnings.warn(RestitutionWarning("window", text), stacklevel=4)


def _outputs(problem: EstimationProblem, flat: Impact, coordinates: Array) -> Array:
    """Return outputs of n impacts on the materials at m coordinates, shape (m, n_output, n)."""
    trials = varied(flat, {"material": problem.materials(coordinates)})
    outcomes = solve_columns(trials, _RTOL, workers=1)
    return np.stack([outcomes[name].reshape(len(coordinates), -1) for name in DEFAULT_OUTPUTS], axis=1)


def _adhesive(uncertainty: Uncertainty, flat: Impact, width: float) -> tuple[Array, Array, Array]:
    """Return outputs of impacts with adhesion, and the ends of their bands, shape (n_output, n) each.

    e has no slope where bodies stick, so its band is that of e^2, continued below the sticking velocity.
    """
    problem = uncertainty.estimation.problem

    def functions(coordinates: Array) -> Array:
        # Rows that differ in nuisances only are solved once.
        _, first, places = np.unique(
            coordinates[:, : problem.n_parameters], axis=0, return_index=True, return_inverse=True
        )
        return _energies_and_logarithms(_trials(problem, flat, coordinates[first]))[places.ravel()]

    center, errors = uncertainty.linearised(functions, logarithms=False, least_step=STEP)
    energy, spread = center[0], np.nan_to_num(width * errors[0], nan=math.inf, posinf=math.inf)
    e, lowest, highest = (np.sqrt(np.clip(energy + move, 0.0, 1.0)) for move in (0.0 * energy, -spread, spread))
    others = np.exp(center[1:])
    low, high = limits(others, np.nan_to_num(errors[1:], nan=math.inf, posinf=math.inf), width)
    # A contact that may not end has no longest time. If it may end but does not, it has no shortest time.
    high[0] = np.where(lowest > 0.0, high[0], math.inf)
    low[0] = np.where(e > 0.0, low[0], np.where(highest > 0.0, 0.0, math.inf))
    return np.vstack([e, others]), np.vstack([lowest, low]), np.vstack([highest, high])


def _trials(problem: EstimationProblem, flat: Impact, coordinates: Array) -> Impact:
    """Return n impacts on the materials at m coordinates, shape (m, n), with the adhesion of the fit if it has one."""
    materials = problem.materials(coordinates)
    trials = varied(flat, {"material": materials})
    if not isinstance(materials, StickyMaterial):
        return trials
    stress = np.empty(trials.shape)
    for row, place in np.ndindex(trials.shape):
        adhesion = float(materials.work[row, 0]), float(materials.stress[row, 0])
        contact = trials.take(np.asarray(row * trials.shape[1] + place)).contact
        # The fit replaces thinner zones by this zone, too.
        stress[row, place] = thick_stress(
            as_profile(contact.profile, "adhesion"), contact.reduced_modulus, adhesion, MOST
        )
    return varied(replace(trials, adhesion=None), {"work": materials.work, "stress": stress})


def _energies_and_logarithms(trials: Impact) -> Array:
    """Return e^2 and logarithms of the other outputs, shape (m, n_output, n); NaN of impacts that fail.

    Below the sticking velocity v_s, e^2 goes on along the line over ln v through its zero at v_s.
    """
    shape = trials.shape
    outcomes = solve_columns(trials, _ADHESIVE_RTOL)
    e, *others = (outcomes[name].reshape(shape) for name in DEFAULT_OUTPUTS)
    energy = e**2

    def run(place: tuple[int, int]) -> None:
        single = trials.take(np.asarray(np.ravel_multi_index(place, shape)))
        threshold = sticking(problem_of(single), _STICKING_RTOL)[0]
        slope = math.nan
        if threshold > 0.0:
            above = solve_columns(replace(single, velocity=_ABOVE * threshold), _ADHESIVE_RTOL)
            slope = float(above["restitution_coefficient"][0]) ** 2 / math.log(_ABOVE)
        energy[place] = slope * math.log(float(single.velocity) / threshold)

    on_threads(run, [(int(row), int(place)) for row, place in np.argwhere(e == 0.0)], None, lambda: None)
    with np.errstate(divide="ignore"):
        return np.stack([energy, *np.log(others)], axis=1)
