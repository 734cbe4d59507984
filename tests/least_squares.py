"""Least squares by SciPy alone, for observations without `restitution.identify`."""

from typing import NamedTuple

import numpy as np
from scipy.optimize import least_squares

from restitution.identification.parameters import column
from restitution.material.classical import standard_solid

# Equilibrium and branch modulus [Pa], relaxation time [s]: strong losses at the time scale of contact, fast, weak.
CASES = {"A": (1e6, 1e7, 1e-3), "B": (1e6, 1e7, 3e-5), "D": (1e6, 2e5, 1e-3)}
RADIUS, MASS = 0.01, 7850.0 * 4.0 / 3.0 * np.pi * 1e-6


def solid(case):
    """Incompressible standard solid of a case."""
    equilibrium, branch, time = CASES[case]
    return standard_solid(equilibrium, branch, branch * time, poisson_ratio=0.5)


def columns(logs):
    """Standard solids of the logarithms of their three constants, shape (m, 3)."""
    constants = np.exp(np.atleast_2d(logs))
    return column([standard_solid(g, b, b * t, poisson_ratio=0.5) for g, b, t in constants])


class Fit(NamedTuple):
    """Estimates of the logarithms, then the nuisances, with their covariance."""

    estimate: np.ndarray
    covariance: np.ndarray
    chi2: float

    @property
    def errors(self):
        """Standard errors."""
        return np.sqrt(np.diag(self.covariance))


def residuals(data, points):
    """Residuals at points of shape (m, 3 + q)."""
    points = np.atleast_2d(points)
    return data.residuals(columns(points[:, :3]), points[:, 3:])


def jacobian(data, point):
    """Central differences at a point."""
    steps = np.append([1e-4] * 3, [0.1 * item.step for item in data.nuisances])
    result = residuals(data, np.vstack([point + np.diag(steps), point - np.diag(steps)]))
    return ((result[: steps.size] - result[steps.size :]) / (2.0 * steps[:, None])).T


def covariance(data, point):
    """Covariance of unbiased estimates for these data: the bound of Cramer and Rao, if the point is the truth."""
    J = jacobian(data, point)
    scale = np.linalg.norm(J, axis=0)
    return np.linalg.inv((J / scale).T @ (J / scale)) / np.outer(scale, scale)


def fit(data, start):
    """Least squares from the logarithms `start`."""
    first = np.append(start, [item.start for item in data.nuisances])
    low = np.append(start - 9.0, [item.low for item in data.nuisances])
    high = np.append(start + 9.0, [item.high for item in data.nuisances])
    scale = np.append([1.0] * 3, [item.step for item in data.nuisances])
    result = least_squares(
        lambda x: residuals(data, x)[0], first, lambda x: jacobian(data, x), (low, high), x_scale=scale, xtol=1e-9
    )
    return Fit(result.x, covariance(data, result.x), 2.0 * float(result.cost))
