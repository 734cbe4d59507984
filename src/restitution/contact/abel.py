"""The transform g(x) of a piecewise polynomial profile, by quadrature of the Abel integral to rounding."""

from __future__ import annotations

import math
from functools import cached_property
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from restitution.contact.geometry import Array
from restitution.contact.matrix import product

if TYPE_CHECKING:
    from scipy.interpolate import PPoly

# Near x a piece is integrated over the angle, where f' is a polynomial of degree <= 4 in a cosine over at most a
# quarter turn. Two of its widths away from x, eight nodes over r are at rounding level (9.9^-16).
_NEAR_NODES = 10
_NEAR_RULE = np.polynomial.legendre.leggauss(_NEAR_NODES)
_FAR_NODES = 8
_FAR = 2.0
# Pieces of a group. Two of its widths away, its nodes take the place of theirs, at rounding level too.
_GROUP = 32
_GROUP_NODES = 16
# Largest number of values in memory at a time, some tens of megabytes.
_BLOCK = 500_000
_DEGREE = 20
# Error of the series of g, its slope and Pi; Newton's method needs no more accurate slope.
_TAILS = np.array([1e-12, 1e-8, 1e-12])
_MAX_SPLITS = 6


class Transformed(NamedTuple):
    """Transform at some contact radii: g [m], dg/dy [-] with y = sqrt(x^2 - b^2), and Pi [m^2]."""

    depth: Array
    slope: Array
    force_integral: Array


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
        integrands = np.stack([first, first + self._far_nodes * second, first * self._far_nodes**2], axis=-1)
        self._far_integrands = (0.5 * widths[:, None] * weights)[..., None] * integrands
        self._group()

    def _group(self) -> None:
        """Move the integrands of each full group of pieces to its Chebyshev nodes, by their Lagrange polynomials."""
        edges = self._breaks[::_GROUP]
        count, widths = len(edges) - 1, np.diff(edges)[:, None]
        angle = np.pi * (np.arange(_GROUP_NODES) + 0.5) / _GROUP_NODES
        self._group_nodes = edges[:-1, None] + widths * (0.5 + 0.5 * np.cos(angle))
        place = (self._far_nodes[: count * _GROUP].reshape(count, _GROUP * _FAR_NODES) - edges[:-1, None]) / widths
        basis = np.polynomial.chebyshev.chebvander(2.0 * place - 1.0, _GROUP_NODES - 1)
        lagrange = np.cos(np.arange(_GROUP_NODES)[:, None] * angle) * (2.0 / _GROUP_NODES)
        lagrange[0] *= 0.5
        integrands = self._far_integrands[: count * _GROUP].reshape(count, _GROUP * _FAR_NODES, 3)
        moved: Any = np.einsum("gik,kj,giq->gjq", basis, lagrange, integrands, optimize=True)
        self._group_integrands: Array = moved
        # Number of leading groups that are far from any x beyond each edge.
        far_from = np.maximum.accumulate(edges[1:] + _FAR * widths[:, 0])
        self._group_edges, self._far_groups = edges, np.searchsorted(far_from, edges, side="left")

    def __call__(self, y: Array) -> Transformed:
        """Transform at flat y [m] within the breaks."""
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
            low, high = cells[cell, 1], cells[cell, 2]
            values[far] = np.polynomial.chebyshev.chebval(
                ((2.0 * root - low - high) / (high - low))[:, None], series[:, cell], tensor=False
            )
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
            tail = np.max(np.abs(coefficients[-2:]) / scale, axis=0)
            good = np.all(tail <= _TAILS, axis=1) | (split == _MAX_SPLITS)
            cells.append(pending[good])
            series.append(coefficients[:, good])
            piece, low, high = pending[~good].T
            middle = 0.5 * (low + high)
            pending = np.concatenate([np.stack([piece, low, middle], 1), np.stack([piece, middle, high], 1)])
            if not len(pending):
                break
        found = np.concatenate(cells)
        order = np.lexsort((found[:, 1], found[:, 0]))
        return found[order], np.concatenate(series, axis=1)[:, order]

    def _chebyshev(self, cells: Array) -> Array:
        angle = np.pi * (np.arange(_DEGREE + 1) + 0.5) / (_DEGREE + 1)
        piece, low, high = cells[:, 0].astype(np.intp), cells[:, 1:2], cells[:, 2:3]
        root = 0.5 * (low + high) + 0.5 * (high - low) * np.cos(angle)
        start, end = self._breaks[piece][:, None], self._breaks[piece + 1][:, None]
        x = start + (end - start) * root * root
        values = self._integrated(self.beyond_face(x.ravel())).reshape(len(cells), _DEGREE + 1, 3)
        basis = np.cos(np.arange(_DEGREE + 1)[:, None] * angle) * (2.0 / (_DEGREE + 1))
        basis[0] *= 0.5
        return np.einsum("jn,cnq->jcq", basis, values)

    def _integrated(self, y: Array) -> Array:
        edge = np.searchsorted(self._group_edges, self._radius(y), side="right") - 1
        groups = self._far_groups[np.maximum(edge, 0)]
        values = np.empty((len(y), 3))
        for count in np.unique(groups):
            rows = np.flatnonzero(groups == count)
            step = max(1, _BLOCK // (self._far_nodes.size - count * (_GROUP * _FAR_NODES - _GROUP_NODES)))
            for part in (rows[i : i + step] for i in range(0, len(rows), step)):
                values[part] = self._integrated_block(y[part], int(count))
        return values

    def _integrated_block(self, y: Array, groups: int) -> Array:
        """Integrals at some y; the first `groups` groups of points are far from all of them."""
        face = self.face
        x = self._radius(y)
        first = _GROUP * groups
        last = int(np.searchsorted(self._breaks[:-1], np.max(x), side="right"))
        far = x[:, None] > self._far_from[first:last]
        row, piece = np.nonzero(~far & (x[:, None] > self._breaks[first:last]))
        sums = self._near(x, y, row, first + piece)
        r = self._far_nodes[first:last]
        squared = np.where(far[..., None], (x[:, None, None] - r) * (x[:, None, None] + r), np.inf)
        sums += product((1.0 / np.sqrt(squared)).reshape(len(x), -1), self._far_integrands[first:last].reshape(-1, 3))
        r = self._group_nodes[:groups]
        inverse = 1.0 / np.sqrt((x[:, None, None] - r) * (x[:, None, None] + r))
        sums += product(inverse.reshape(len(x), -1), self._group_integrands[:groups].reshape(-1, 3))
        depth, inner, force_integral = x * sums[:, 0], sums[:, 1], sums[:, 2]
        if face > 0.0:
            inner = (y * inner + self._first.c[-1, 0] * face) / x
        elif np.any(y == 0.0):
            inner = np.where(y == 0.0, 0.5 * math.pi * self._first.c[-1, 0], inner)
        return np.stack([depth, inner, force_integral], axis=1)

    def _near(self, x: Array, y: Array, row: NDArray[np.intp], piece: NDArray[np.intp]) -> Array:
        nodes, weights = _NEAR_RULE
        start, end = self._breaks[piece], self._breaks[piece + 1]
        here = x[row]
        # Near the edge b of a face, y has digits that are lost in x - b.
        opposite = np.where(piece == 0, y[row], np.sqrt((here - start) * (here + start)))
        upper = np.arctan2(opposite, start)
        beyond = np.maximum(here, end)
        lower = np.arctan2(np.sqrt((beyond - end) * (beyond + end)), end)
        half = 0.5 * (upper - lower)[:, None]
        cosine = np.cos(lower[:, None] + half * (1.0 + nodes))
        r = here[:, None] * cosine
        offset = np.maximum(r - start[:, None], 0.0)
        # The piece is given, because rounding could lead a search for r into its neighbour.
        first, second = (
            np.polynomial.polynomial.polyval(offset, slopes.c[::-1, piece, None], tensor=False)
            for slopes in (self._first, self._second)
        )
        sums = np.zeros((len(x), 3))
        for i, integrand in enumerate((first, first + r * second, first * r * r)):
            sums[:, i] = np.bincount(row, np.sum(half * weights * integrand, axis=1), minlength=len(x))
        return sums
