"""The contact radius over the square root of the depth, a(s) with d = s^2, as a table for the kernel."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from restitution.checks import positive
from restitution.contact.profile import Array, Profile, as_array

_DEGREE = 7
_FIRST_CELLS = 4
# Ranks of halving: the narrowest cell is 4e-12 of the whole.
_MOST_HALVINGS = 36
_MAX_CELLS = 4096


class PathTable(NamedTuple):
    """Piecewise polynomials of a(s) and Pi(s) = int_0^s a 2 s' ds' on cells in s, narrow where a(s) has kinks.

    In cell i, with ``w = edges[i+1] - edges[i]`` and its own coordinate ``t = (s - edges[i])/w``, ``a = sum_j
    radius[i, j] t^j``, ``da/ds = (da/dt)/w`` and ``Pi = sum_j force_integral[i, j] t^j``.

    Attributes
    ----------
    edges : array
        Ends of the cells [m^(1/2)], rising from 0, shape ``(n_cells + 1,)``.
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

    edges: Array
    radius: Array
    force_integral: Array
    errors: Array
    radius_error: float

    @property
    def s_max(self) -> float:
        """End of the table [m^(1/2)]."""
        return float(self.edges[-1])

    @property
    def error(self) -> float:
        """Error over the whole depth."""
        return float(self.errors[-1])

    def error_at(self, depth: ArrayLike) -> Array:
        """Largest of the errors up to the end of the cell that holds a depth [m], and beyond."""
        cell = self.cell(np.sqrt(as_array(depth)))
        return np.maximum.accumulate(self.errors[::-1])[::-1][cell]

    def cell(self, s: Array) -> Any:
        """Index of the cell that holds s [m^(1/2)]; the first and the last one hold what is beyond them too."""
        return np.searchsorted(self.edges[1:-1], s, side="right")


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
        `error` to aim at. Cells are halved until it is met; where 36 halvings or 4096 cells do not do, the table
        is returned as it is, and its `error` says what was reached.
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
    least = depth_max if depth_min is None else min(float(positive("depth_min", depth_min, "m")), depth_max)
    least_integral = float(profile.force_integral_at_depth(least))
    # Ends of the cells as parts of the whole, exact in binary.
    left = np.arange(_FIRST_CELLS) / _FIRST_CELLS
    width = np.full(_FIRST_CELLS, 1.0 / _FIRST_CELLS)
    done: list[tuple[Array, ...]] = []
    count = 0
    for rank in range(_MOST_HALVINGS + 1):
        radius = _fitted(profile, depth_max, left, width)
        gain, missed, largest = _missed(profile, depth_max, left, width, radius)
        allowed = rtol * np.maximum(gain, least_integral / _FIRST_CELLS**2)
        last = rank == _MOST_HALVINGS or count + 2 * left.size > _MAX_CELLS
        good = (missed <= allowed) | last
        done.append((left[good], width[good], radius[good], missed[good], largest[good]))
        count += int(np.count_nonzero(good))
        width = np.repeat(0.5 * width[~good], 2)
        left = np.repeat(left[~good], 2)
        left[1::2] += width[1::2]
        if left.size == 0:
            break
    left, width, radius, missed, largest = (np.concatenate(parts) for parts in zip(*done, strict=True))
    order = np.argsort(left)
    left, width, radius, missed = left[order], width[order], radius[order], missed[order]
    force_integral = _force_integral(depth_max, left, width, radius)
    return PathTable(
        edges=depth_max**0.5 * np.append(left, 1.0),
        radius=np.ascontiguousarray(radius),
        force_integral=force_integral,
        errors=np.cumsum(missed) / np.sum(force_integral, axis=1),
        radius_error=float(np.max(largest)) / float(profile.contact_radius(depth_max)),
    )


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
    cell = table.cell(s)
    width = np.diff(table.edges)[cell]
    t = (s - table.edges[cell]) / width
    radius = np.moveaxis(table.radius[cell], -1, 0)
    powers = np.arange(1, _DEGREE + 1).reshape((-1,) + (1,) * s.ndim)
    slope = _polynomial(radius[1:] * powers, t) / width
    force_integral = _polynomial(np.moveaxis(table.force_integral[cell], -1, 0), t)
    return _polynomial(radius, t), slope, force_integral


def scaled(table: PathTable, length: float, radius: float) -> PathTable:
    """The same table with depths in units of `length` [m] and contact radii in units of `radius` [m]."""
    return PathTable(
        edges=table.edges / length**0.5,
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


def _fitted(profile: Profile, depth_max: float, left: Array, width: Array) -> Array:
    """Coefficients of a in cells that begin at s = left s_max."""
    # Nodes at both ends of a cell make a(s) continuous and exact at s = 0.
    nodes = 0.5 - 0.5 * np.cos(np.pi * np.arange(_DEGREE + 1) / _DEGREE)
    values = profile.contact_radius(depth_max * (left[:, None] + width[:, None] * nodes) ** 2)
    solved: Any = np.linalg.solve(np.vander(nodes, increasing=True), values.T)
    return solved.T


def _missed(
    profile: Profile, depth_max: float, left: Array, width: Array, radius: Array
) -> tuple[Array, Array, Array]:
    """Int a dd of each cell, int |delta a| dd, and the largest |delta a|."""
    nodes, weights = np.polynomial.legendre.leggauss(_DEGREE + 1)
    t = 0.5 + 0.5 * nodes
    z = left[:, None] + width[:, None] * t
    polynomial = _polynomial(radius.T[:, :, None], t)
    difference = np.abs(polynomial - profile.contact_radius(depth_max * z * z))
    gain, missed = (depth_max * width * ((z * a) @ weights) for a in (polynomial, difference))
    return gain, missed, np.max(difference, axis=1)


def _force_integral(depth_max: float, left: Array, width: Array, radius: Array) -> Array:
    """Coefficients of Pi in each cell."""
    # d(s^2) = 2 s_max^2 (left + width t) width dt
    force_integral = np.zeros((left.size, _DEGREE + 3))
    force_integral[:, 1:-1] = radius * left[:, None]
    force_integral[:, 2:] += radius * width[:, None]
    force_integral[:, 1:] *= 2.0 * depth_max * width[:, None] / np.arange(1, _DEGREE + 3)
    force_integral[1:, 0] = np.cumsum(np.sum(force_integral, axis=1))[:-1]
    return force_integral
