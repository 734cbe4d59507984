"""Fits of many indentation curves at once, each with its own material, by Levenberg-Marquardt steps."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from restitution.identification.curve import RTOL, IndentationCurve, curves_block
from restitution.identification.descent import descend
from restitution.identification.estimation import Estimation
from restitution.identification.parameters import Parameters, penalties
from restitution.indentation.result import IndentationStatus
from restitution.quantities import MODULUS, VISCOSITY

Array = NDArray[np.float64]
Places = NDArray[np.intp]

_ROUNDS = 60
# A descent ends if the next step would lower chi2 by less than this, a thousandth of a standard error.
_ENOUGH = 1e-6
# Steps of differences in logarithms and in the contact point; largest step of a logarithm in a round.
STEP, _CONTACT_STEP, _FURTHEST = 1e-4, 1e-2, 2.0
# A coordinate within this distance of a bound counts as at it.
EDGE = 1e-3


class CurveFits(NamedTuple):
    """Fits of s curves."""

    points: Array  # coordinates as in `estimation.EstimationProblem`, shape (s, q)
    errors: Array  # their standard errors
    chi2: Array  # shape (s,); infinite without a fit
    freedom: Array  # points less unknowns, baseline included
    units: Array  # unit of the contact point [m]
    bound: NDArray[np.bool_]  # whether a coordinate is at the end of its range, shape (s, q)
    ended: NDArray[np.bool_]  # whether the descent has converged


class Descent:
    """Curves of one indenter at one temperature, fitted all at once; coordinates as in `EstimationProblem`."""

    def __init__(self, curves: list[IndentationCurve], seed: Estimation, space: Parameters) -> None:
        self.curves, self.seed, self.space = curves, seed, space
        self.block = curves_block(curves)
        self.unit = np.array([one.nuisances[0].step for one in curves])
        most = max(one.size for one in curves)
        # After the last point of a shorter curve all weights are zero.
        self.measured, self.weights = np.zeros((2, len(curves), most))
        self.basis = np.zeros((len(curves), most, 2))
        for n, one in enumerate(curves):
            self.measured[n, : one.size], self.weights[n, : one.size] = one.force, 1.0 / one.deviations
            self.basis[n, : one.size] = one.basis

    def residuals(self, points: Array, places: Places) -> Array:
        """Residuals of k points of the curves at `places`, shape (s, k, n); NaN where there are none."""
        s, k, q = points.shape
        flat, rows = points.reshape(s * k, q), np.repeat(places, k)
        materials = self.space.columns(flat[:, :-1], self.seed.problem.window).at(self.curves[0].temperature)
        touches = flat[:, -1] * self.unit[rows]
        forces, statuses = self.block.forces(materials.reduced, touches, rows.astype(np.int64), rtol=RTOL)
        forces = np.where(self.weights[rows] > 0.0, forces, 0.0).reshape(s, k, -1)
        off = (forces - self.measured[places, None]) * self.weights[places, None]
        off -= (off @ self.basis[places]) @ self.basis[places].swapaxes(1, 2)
        off[np.reshape(statuses > IndentationStatus.IN_CONTACT, (s, k))] = np.nan
        prior = penalties(self.space, flat[:, :-1]).reshape(s, k, -1)
        return np.concatenate([off, prior], axis=2)

    @property
    def steps(self) -> Array:
        """Steps of differences in the coordinates."""
        return np.append(np.full(len(self.space.free), STEP), _CONTACT_STEP)

    def starts(self) -> tuple[Array, Array, Array]:
        """Start and bounds of each curve: those of the seed, but the moduli times a factor."""
        best, problem = self.seed.fit.coordinates, self.seed.problem
        p, s = len(self.space.free), len(self.curves)
        touch = np.array([[getattr(one.nuisances[0], key) for key in ("start", "low", "high")] for one in self.curves])
        points = np.column_stack([np.tile(best[:p], (s, 1)), touch[:, 0] / self.unit])
        everywhere = np.arange(s)
        weighted = self.measured * self.weights
        weighted -= np.einsum("sj,snj->sn", np.einsum("sn,snj->sj", weighted, self.basis), self.basis)
        fitted = self.residuals(points[:, None], everywhere)[:, 0, : weighted.shape[1]] + weighted
        share, size = np.einsum("sn,sn->s", fitted, weighted), np.einsum("sn,sn->s", fitted, fitted)
        with np.errstate(invalid="ignore", divide="ignore"):
            factor = np.log(np.where(share > 0.0, share / size, 1.0))
        moduli = [
            (one.quantity.dimension in (MODULUS, VISCOSITY) or one.argument == "coefficient") and one.kind == "log"
            and not one.bounded for one in self.space.free
        ]  # fmt: skip
        shift = np.nan_to_num(factor)[:, None] * np.array(moduli)
        low = np.column_stack([problem.low[:p] + shift, touch[:, 1] / self.unit])
        high = np.column_stack([problem.high[:p] + shift, touch[:, 2] / self.unit])
        points[:, :p] += shift
        return np.clip(points, low + 1e-9, high - 1e-9), low, high

    def found(self) -> CurveFits:
        """Fit all curves: Levenberg-Marquardt steps until none would improve a fit."""
        points, low, high = self.starts()
        q, n = points.shape[1], self.measured.shape[1]
        furthest = np.append(np.full(q - 1, _FURTHEST), np.inf)
        points, costs, ended = descend(self.residuals, points, low, high, self.steps, furthest, _ENOUGH / n, _ROUNDS)
        bound = (points - low < EDGE) | (high - points < EDGE)
        freedom = np.maximum(np.array([one.size for one in self.curves]) - q - 2, 1)
        return CurveFits(points, self._errors(points, costs / freedom), costs, freedom, self.unit, bound, ended)

    def _errors(self, points: Array, reduced: Array) -> Array:
        """Standard errors of the coordinates."""
        places, step = np.arange(len(points)), np.diag(self.steps)
        ahead, behind = (self.residuals(points[:, None] + one, places) for one in (step, -step))
        slopes = np.nan_to_num((ahead - behind) / (2.0 * self.steps[:, None]))
        normal = slopes @ slopes.swapaxes(1, 2)
        scale = np.sqrt(np.maximum(np.einsum("sqq->sq", normal), 1e-300))
        relative = normal / (scale[:, :, None] * scale[:, None]) + 1e-14 * np.eye(points.shape[1])
        variance = np.einsum("sqq->sq", np.linalg.inv(relative))
        noise = np.array([one.scaled for one in self.curves])
        factor = np.where(noise, reduced, 1.0)
        return np.sqrt(np.maximum(variance, 0.0) * factor[:, None]) / scale
