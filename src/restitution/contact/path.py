"""The contact radius over the square root of the depth, a(s) with d = s^2, as a table for the kernel."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from restitution.contact.profile import Array, Profile, as_array
from restitution.kernel.validation import positive

_DEGREE = 7
_FIRST_CELLS = 4
_MAX_CELLS = 2048


class PathTable(NamedTuple):
    """Piecewise polynomials of a(s) and Pi(s) = int_0^s a 2 s' ds' on equal cells in s.

    With ``y = s n_cells/s_max``, the cell is ``i = min(int(y), n_cells - 1)`` and its local coordinate ``t =
    y - i``; ``a = sum_j radius[i, j] t^j``, ``da/ds = (da/dt) n_cells/s_max`` and ``Pi = sum_j
    force_integral[i, j] t^j``.

    Attributes
    ----------
    s_max : float
        End of the table [m^(1/2)].
    radius : array
        Coefficients of a [m], shape ``(n_cells, 8)``, lowest power first.
    force_integral : array
        Coefficients of Pi [m^2], shape ``(n_cells, 10)``: the exact integral of the polynomials of a.
    errors : array
        Verified ``int |delta a| dd / Pi`` up to the end of each cell, shape ``(n_cells,)``; it bounds the error of
        every force up to there relative to the largest elastic one, as forces depend on a(s) through its
        integral over depth alone.
    radius_error : float
        Largest error of a found, relative to the largest a.
    """

    s_max: float
    radius: Array
    force_integral: Array
    errors: Array
    radius_error: float

    @property
    def error(self) -> float:
        """Error over the whole depth."""
        return float(self.errors[-1])

    def error_at(self, depth: ArrayLike) -> Array:
        """Largest of the errors up to the end of the cell that holds a depth [m], and beyond."""
        cells = len(self.errors)
        cell = np.clip(np.sqrt(as_array(depth)) * (cells / self.s_max), 0, cells - 1).astype(np.intp)
        return np.maximum.accumulate(self.errors[::-1])[::-1][cell]


def path_table(
    profile: Profile, depth_max: float, rtol: float = 1e-12, *, depth_min: float | None = None
) -> PathTable:
    """Table of the contact radius a(s) over s = sqrt(depth) of a profile, up to a largest depth.

    Parameters
    ----------
    profile : Profile
        Profile with scalar parameters.
    depth_max : float
        Largest indentation depth [m], > 0, that the table has to cover.
    rtol : float
        `error` to aim at. The cells are doubled until it is met; at 2048 cells the table is returned as it
        is, and its `error` says what was reached.
    depth_min : float, optional
        Smallest depth [m] of an impact that uses the table, at which `error_at` has to meet `rtol` too; `depth_max`
        where left out.

    Returns
    -------
    PathTable

    Raises
    ------
    ValueError
        If `depth_max` is not finite and > 0, exceeds what the profile describes, or the profile has arrays
        for parameters.

    Examples
    --------
    >>> from restitution.contact.sphere import Sphere
    >>> table = path_table(Sphere(radius=0.01), depth_max=0.005)
    >>> table.radius.shape, table.error < 1e-12
    ((4, 8), True)
    """
    depth_max = float(positive("depth_max", depth_max, "m"))
    rtol = float(positive("rtol", rtol))
    if depth_max > profile.max_depth:
        raise ValueError(
            f"depth_max = {depth_max:g} m: must be <= {profile.max_depth:g} m, where the profile ends"
        )
    if np.ndim(profile.contact_radius(depth_max)):
        raise ValueError("profile with arrays for parameters: a path table describes one profile")
    least = depth_max if depth_min is None else float(positive("depth_min", depth_min, "m"))
    cells = _FIRST_CELLS
    best = _fitted(profile, depth_max, cells)
    while best.error_at(least) > rtol and cells < _MAX_CELLS:
        cells *= 2
        finer = _fitted(profile, depth_max, cells)
        if finer.error_at(least) < best.error_at(least):
            best = finer
    return best


def evaluate(table: PathTable, s: ArrayLike) -> tuple[Array, Array, Array]:
    """Contact radius a [m], its slope da/ds [m^(1/2)] and force integral Pi [m^2] at s [m^(1/2)].

    The plain counterpart of the compiled evaluation, for post-processing and tests.

    Parameters
    ----------
    table : PathTable
        Table of the profile.
    s : array
        Square root of the depth [m^(1/2)], in [0, s_max].

    Examples
    --------
    >>> from restitution.contact.profile import Parabola
    >>> table = path_table(Parabola(radius=0.01), depth_max=1e-4)
    >>> a, slope, force_integral = evaluate(table, 0.005)
    >>> round(float(a), 12), round(float(slope), 12), round(float(force_integral), 15)
    (0.0005, 0.1, 8.333333e-09)
    """
    s = as_array(s)
    cells = len(table.radius)
    y = s * (cells / table.s_max)
    cell = np.clip(y.astype(np.intp), 0, cells - 1)
    t = y - cell
    radius = np.moveaxis(table.radius[cell], -1, 0)
    powers = np.arange(1, _DEGREE + 1).reshape((-1,) + (1,) * s.ndim)
    slope = _polynomial(radius[1:] * powers, t) * (cells / table.s_max)
    force_integral = _polynomial(np.moveaxis(table.force_integral[cell], -1, 0), t)
    return _polynomial(radius, t), slope, force_integral


def scaled(table: PathTable, length: float, radius: float) -> PathTable:
    """The same table with depths in units of `length` [m] and contact radii in units of `radius` [m]."""
    return PathTable(
        s_max=table.s_max / length**0.5,
        radius=table.radius / radius,
        force_integral=table.force_integral / (radius * length),
        errors=table.errors,
        radius_error=table.radius_error,
    )


def _polynomial(coefficients: Array, t: Array) -> Array:
    value = coefficients[-1]
    for coefficient in coefficients[-2::-1]:
        value = value * t + coefficient
    return value


def _fitted(profile: Profile, depth_max: float, cells: int) -> PathTable:
    s_max = depth_max**0.5
    first = np.arange(cells)[:, None]
    # Nodes at both ends of a cell make a(s) continuous and exact at s = 0.
    nodes = 0.5 - 0.5 * np.cos(np.pi * np.arange(_DEGREE + 1) / _DEGREE)
    values = profile.contact_radius(depth_max * ((first + nodes) / cells) ** 2)
    solved = np.linalg.solve(np.vander(nodes, increasing=True), values.T)
    radius = np.ascontiguousarray(solved.T, dtype=np.float64)

    # d(s^2) = (2 s_max^2/n_cells^2) (i + t) dt
    force_integral = np.zeros((cells, _DEGREE + 3))
    force_integral[:, 1:-1] = radius * first
    force_integral[:, 2:] += radius
    force_integral[:, 1:] *= 2.0 * depth_max / cells**2 / np.arange(1, _DEGREE + 3)
    force_integral[1:, 0] = np.cumsum(np.sum(force_integral, axis=1))[:-1]
    table = PathTable(s_max, radius, force_integral, np.zeros(cells), 0.0)
    errors, radius_error = _errors(profile, table, depth_max)
    return table._replace(errors=errors, radius_error=radius_error)


def _errors(profile: Profile, table: PathTable, depth_max: float) -> tuple[Array, float]:
    cells = len(table.radius)
    nodes, weights = np.polynomial.legendre.leggauss(_DEGREE + 1)
    z = (np.arange(cells)[:, None] + 0.5 + 0.5 * nodes) / cells
    depth = depth_max * z * z
    difference = np.abs(evaluate(table, np.sqrt(depth))[0] - profile.contact_radius(depth))
    missed = depth_max / cells * np.cumsum(np.sum(weights * z * difference, axis=1))
    ends = depth_max * (np.arange(1, cells + 1) / cells) ** 2
    largest = float(profile.contact_radius(depth_max))
    return missed / profile.force_integral_at_depth(ends), float(np.max(difference)) / largest
