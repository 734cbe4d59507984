"""The transform g(x) of a piecewise polynomial profile, by quadrature of the Abel integral to rounding."""

from __future__ import annotations

import math
from functools import cached_property
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from restitution.contact.geometry import Array
from restitution.parallel import on_threads

if TYPE_CHECKING:
    from scipy.interpolate import PPoly

# Near x a piece is integrated over the angle, where f' is a polynomial of degree <= 4 in a cosine over at most a
# quarter turn. Two of its widths away from x, eight nodes over r are at rounding level (9.9^-16).
_NEAR_RULE = 0.5 * np.array(np.polynomial.legendre.leggauss(10)) + np.array([[0.5], [0.0]])
_FAR_NODES = 8
_FAR = 2.0
# Four pieces make a group, two groups one of the next level. Two of its widths away, the nodes of a group take the
# place of those of its parts, at rounding level too. So an integral costs the logarithm of the number of pieces.
_GROUP = 4
_GROUP_NODES = 16
# Integrals that one thread computes at a time.
_BLOCK = 10_000
_DEGREE = 20
# Error of the series of g, its slope and Pi; Newton's method needs no more accurate slope.
_TAILS = np.array([1e-12, 1e-8, 1e-12])
_MAX_SPLITS = 6


class Transformed(NamedTuple):
    """Transform at some contact radii: g [m], dg/dy [-] with y = sqrt(x^2 - b^2), and Pi [m^2]."""

    depth: Array
    slope: Array
    force_integral: Array


class _Groups(NamedTuple):
    """Groups of pieces, level after level; see `restitution.contact.abel_sums.add_integrals`."""

    starts: NDArray[np.intp]
    far_from: Array
    nodes: Array
    masses: Array


class AbelTransform:
    """Transform of a profile that is flat for r < b, with a flank f(r) of degree <= 5 from b = flank.x[0] on.

    With r = x cos(psi), over each piece: ``g = x int f' dpsi``, ``g' = int (f' + r f'') dpsi + f'(b) b/sqrt(x^2 -
    b^2)``, ``Pi = int f' r^2 dpsi``; the last from the other order of integration in Pi = a g(a) - int g dx.

    All are functions of y = sqrt(x^2 - b^2), in which g is smooth at b. Beyond the first piece they are kept as
    Chebyshev series in the root of the distance to the last break before x, where g has a half-integer power.
    """

    def __init__(self, flank: PPoly) -> None:
        self._breaks: Array = np.asarray(flank.x)
        self.face = float(self._breaks[0])
        self._first: Any = flank.derivative()
        self._second: Any = self._first.derivative()
        nodes, weights = np.polynomial.legendre.leggauss(_FAR_NODES)
        widths = np.diff(self._breaks)
        self._far_from = self._breaks[1:] + _FAR * widths
        self._far_nodes = self._breaks[:-1, None] + widths[:, None] * (0.5 + 0.5 * nodes)
        first, second = self._first(self._far_nodes), self._second(self._far_nodes)
        integrands = np.stack([first, first + self._far_nodes * second, first * self._far_nodes**2], axis=1)
        self._far_masses = (0.5 * widths[:, None] * weights)[:, None] * integrands
        self._slopes = np.ascontiguousarray(self._first.c[::-1].T)
        self._groups = self._grouped()

    def _grouped(self) -> _Groups:
        """Groups of pieces: the masses of their parts at Chebyshev nodes, by Lagrange polynomials."""
        angle = np.pi * (np.arange(_GROUP_NODES) + 0.5) / _GROUP_NODES
        lagrange = np.cos(np.arange(_GROUP_NODES)[:, None] * angle) * (2.0 / _GROUP_NODES)
        lagrange[0] *= 0.5
        size, parts, nodes, masses = _GROUP, _GROUP, self._far_nodes, self._far_masses
        levels: list[tuple[Array, Array, Array]] = []
        while count := (len(self._breaks) - 1) // size:
            edges = self._breaks[: count * size + 1 : size]
            widths = np.diff(edges)[:, None]
            place = (nodes[: count * parts].reshape(count, -1) - edges[:-1, None]) / widths
            basis = np.polynomial.chebyshev.chebvander(2.0 * place - 1.0, _GROUP_NODES - 1)
            whole = np.swapaxes(masses[: count * parts].reshape(count, parts, 3, -1), 1, 2).reshape(count, 3, -1)
            masses = whole @ basis @ lagrange
            nodes = edges[:-1, None] + widths * (0.5 + 0.5 * np.cos(angle))
            levels.append((np.maximum.accumulate(edges[1:] + _FAR * widths[:, 0]), nodes, masses))
            size, parts = 2 * size, 2
        starts = np.cumsum([0, *(len(level[0]) for level in levels)])
        if not levels:
            return _Groups(starts, np.empty(0), np.empty((0, _GROUP_NODES)), np.empty((0, 3, _GROUP_NODES)))
        return _Groups(starts, *(np.concatenate(parts) for parts in zip(*levels, strict=True)))

    def __call__(self, y: Array) -> Transformed:
        """Transform at flat y [m] within the breaks."""
        # Numba takes half a second to import.
        from restitution.contact.abel_sums import evaluate_series

        x = self._radius(y)
        values = np.empty((len(y), 3))
        near = x <= self._breaks[1]
        values[near] = self._integrated(y[near])
        far = np.flatnonzero(~near)
        if far.size:
            piece, root = self._located(x[far])
            # Just before a break the sum may round up into the next piece.
            place = np.minimum(piece + root, np.nextafter(piece + 1.0, 0.0))
            cells, series = self._series
            cell = np.clip(np.searchsorted(cells[:, 0] + cells[:, 1], place, side="right") - 1, 0, len(cells) - 1)
            found = np.empty((far.size, 3))
            evaluate_series(root, cell, cells[:, 1], cells[:, 2], series, found)
            values[far] = found
        return Transformed(*values.T)

    def beyond_face(self, x: Array) -> Array:
        """Return y = sqrt(x^2 - b^2) [m], 0 under the face."""
        return np.sqrt(np.maximum((x - self.face) * (x + self.face), 0.0))

    def _radius(self, y: Array) -> Array:
        # The hypotenuse must not round beyond the last break, where the integrals would miss the root.
        return np.minimum(np.hypot(self.face, y), self._breaks[-1])

    def _located(self, x: Array) -> tuple[NDArray[np.intp], Array]:
        piece = np.clip(np.searchsorted(self._breaks, x, side="right") - 1, 1, len(self._breaks) - 2)
        start, end = self._breaks[piece], self._breaks[piece + 1]
        return piece, np.sqrt(np.clip((x - start) / (end - start), 0.0, 1.0))

    def falls(self) -> Array:
        """First y [m], among the breaks and midpoints, from which g falls to the next one; empty if g rises."""
        edges = self.beyond_face(self._breaks)
        y = np.interp(np.arange(2 * len(edges) - 1), np.arange(0, 2 * len(edges), 2), edges)
        falls = self._falling(y)
        if falls.size:
            # Search again around that place, with eight samples per piece.
            near = int(np.searchsorted(edges, falls[0], side="right"))
            ends = edges[max(near - 2, 0) : near + 2]
            closer = self._falling(np.interp(np.arange(8 * len(ends) - 7) / 8.0, np.arange(len(ends)), ends))
            falls = closer if closer.size else falls
        return falls[:1]

    def _falling(self, y: Array) -> Array:
        return y[:-1][np.diff(self._integrated(y)[:, 0]) <= 0.0]

    @cached_property
    def _series(self) -> tuple[Array, Array]:
        """Piece, start and end of each cell beyond the first piece, and its Chebyshev coefficients."""
        pending = np.array([(k, 0.0, 1.0) for k in range(1, len(self._breaks) - 1)])
        scale = self._integrated(self.beyond_face(self._breaks[-1:]))[0]
        cells: list[Array] = []
        series: list[Array] = []
        for split in range(_MAX_SPLITS + 1):
            coefficients = self._chebyshev(pending)
            tail = np.max(np.abs(coefficients[..., -2:]) / scale[:, None], axis=-1)
            good = np.all(tail <= _TAILS, axis=1) | (split == _MAX_SPLITS)
            cells.append(pending[good])
            series.append(coefficients[good])
            piece, low, high = pending[~good].T
            middle = 0.5 * (low + high)
            pending = np.concatenate([np.stack([piece, low, middle], 1), np.stack([piece, middle, high], 1)])
            if not len(pending):
                break
        found = np.concatenate(cells)
        order = np.lexsort((found[:, 1], found[:, 0]))
        return found[order], np.concatenate(series)[order]

    def _chebyshev(self, cells: Array) -> Array:
        angle = np.pi * (np.arange(_DEGREE + 1) + 0.5) / (_DEGREE + 1)
        piece, low, high = cells[:, 0].astype(np.intp), cells[:, 1:2], cells[:, 2:3]
        root = 0.5 * (low + high) + 0.5 * (high - low) * np.cos(angle)
        start, end = self._breaks[piece][:, None], self._breaks[piece + 1][:, None]
        x = start + (end - start) * root * root
        values = self._integrated(self.beyond_face(x.ravel())).reshape(len(cells), _DEGREE + 1, 3)
        basis = np.cos(np.arange(_DEGREE + 1)[:, None] * angle) * (2.0 / (_DEGREE + 1))
        basis[0] *= 0.5
        return np.swapaxes(values, 1, 2) @ basis.T

    def _integrated(self, y: Array) -> Array:
        from restitution.contact.abel_sums import add_integrals

        x, y, sums = self._radius(y), np.ascontiguousarray(y), np.empty((len(y), 3))

        def run(start: int) -> None:
            rows = slice(start, start + _BLOCK)
            add_integrals(
                x[rows], y[rows], self._breaks, self._slopes, _NEAR_RULE, self._far_from, self._far_nodes,
                self._far_masses, *self._groups, sums[rows],
            )  # fmt: skip

        if len(y) <= _BLOCK:
            run(0)
        else:
            on_threads(run, range(0, len(y), _BLOCK), None, lambda: None)
        inner = sums[:, 1]
        if self.face > 0.0:
            inner = (y * inner + self._first.c[-1, 0] * self.face) / x
        elif np.any(y == 0.0):
            inner = np.where(y == 0.0, 0.5 * math.pi * self._first.c[-1, 0], inner)
        return np.stack([x * sums[:, 0], inner, sums[:, 2]], axis=1)
