"""Merging of the panels of a free surface: few smooth ones in place of many from the steps that made them."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.polynomial import chebyshev

from restitution.checks import Array
from restitution.indentation.surface import Imprint
from restitution.kernel.panels import FLAT, FROZEN, scheme

# Places between the nodes at which a merged panel is compared, with those at the joints of the panels it replaces.
_CHECKS = np.linspace(0.02, 0.98, 25)
_ITERATIONS = 12
# Number of panels that are not worth merging.
_FEW = 16


class _Values(NamedTuple):
    """A surface now: y and the parts of the displacement as polynomials over z of each panel."""

    coefficients: Array  # (P, 1 + J, N)
    tops: Array  # (P,): y at z = 0, the outer end
    bottoms: Array  # (P,): y at z = 1
    slopes: Array  # (P, 1, N): of y over z

    def at(self, y: Array) -> Array:
        """Return the parts of the displacement at places y, shape (J, n)."""
        panel = np.clip(np.searchsorted(-self.tops, -y, side="right") - 1, 0, self.tops.size - 1)
        low, high, rows = np.zeros(y.size), np.ones(y.size), self.coefficients[panel]
        z = np.clip((self.tops[panel] - y) / (self.tops[panel] - self.bottoms[panel]), 0.0, 1.0)
        for _ in range(_ITERATIONS):
            value, slope = _values(rows[:, :1], z)[0] - y, _values(self.slopes[panel], z)[0]
            low, high = np.where(value > 0.0, z, low), np.where(value > 0.0, high, z)
            target = z - value / np.where(slope == 0.0, 1.0, slope)
            # Newton's method between brackets.
            z = np.where((target > low) & (target < high), target, 0.5 * (low + high))
            if np.abs(value).max() <= 1e-15 * self.tops[0]:
                break
        return _values(rows[:, 1:], z)


def _values(rows: Array, z: Array) -> Array:
    """Return polynomials, (n, Q, N), at one place each, shape (Q, n)."""
    basis = chebyshev.chebvander(2.0 * z - 1.0, rows.shape[-1] - 1)
    return np.einsum("nqk,nk->qn", rows, basis)


def merged(imprint: Imprint, recoveries: Array, tolerance: float) -> Imprint:
    """Return an imprint with fewer panels, whose displacements [m] now differ by less than a tolerance [m].

    Parameters
    ----------
    imprint : Imprint
        The free surface.
    recoveries : array
        Rates of recovery r_j [1/s].
    tolerance : float
        Largest difference of each part of the displacement [m].

    Notes
    -----
    A merged panel holds the state of its elements at one instant. A kink that is too weak to be felt goes.
    Displacements near the edge are functions of the root of the distance from it, and so is z of the outermost panel.
    """
    count = imprint.end.size
    if count <= _FEW:
        return imprint
    pieces = _pieces(_now(imprint, recoveries), imprint, 0, count - 1, tolerance)
    if len(pieces) == count:
        return imprint
    zeros = np.zeros(len(pieces))
    return Imprint(
        np.array([panel for panel, _ in pieces]), zeros, zeros, np.full(len(pieces), FROZEN, dtype=np.int64),
        np.ones(len(pieces)), np.array([joint for _, joint in pieces], dtype=np.int64),
    )  # fmt: skip


def _now(imprint: Imprint, recoveries: Array) -> _Values:
    """Return the panels with the parts of the displacement as they are now."""
    rule, n = scheme(), imprint.end.size
    z = imprint.end[:, None] * rule.c
    basis = chebyshev.chebvander(2.0 * z - 1.0, z.shape[1] - 1)
    rows = np.einsum("pqk,pik->qpi", imprint.coefficients, basis)
    kind = imprint.kind[:, None]
    passed = np.where(kind > 0, z ** np.maximum(kind, 1), 1.0 - (1.0 - z) ** np.maximum(-kind, 1))
    passed[imprint.kind == FROZEN] = 0.0
    elapsed = -(imprint.start[:, None] + imprint.length[:, None] * passed)
    rows[1:] *= np.exp(-recoveries[:, None, None] * elapsed)
    coefficients = np.einsum("ki,qpi->pqk", rule.coefficients, rows)
    slopes = np.zeros((n, 1, rule.c.size))
    slopes[:, 0, :-1] = chebyshev.chebder(coefficients[:, 0], scl=2.0, axis=1)
    return _Values(coefficients, rows[0, :, 0], rows[0, :, -1], slopes)


def _pieces(now: _Values, imprint: Imprint, first: int, last: int, tolerance: float) -> list[tuple[Array, int]]:
    """Return panels in place of those from first to last, each with its joint; halves where one is not enough."""
    if first == last:
        return [(now.coefficients[first], int(imprint.joint[first]))]
    panel = _one(now, first, last, tolerance)
    if panel is not None:
        return [(panel, FLAT if first == 0 else int(imprint.joint[first]))]
    middle = (first + last) // 2
    return [
        *_pieces(now, imprint, first, middle, tolerance), *_pieces(now, imprint, middle + 1, last, tolerance)
    ]  # fmt: skip


def _one(now: _Values, first: int, last: int, tolerance: float) -> Array | None:
    """Return one panel in place of several, or None if it differs by more than the tolerance."""
    rule = scheme()
    top, bottom = float(now.tops[first]), float(now.bottoms[last])
    # The outermost elements are functions of the root of the distance from the edge.
    power = 2 if first == 0 else 1

    def place(z: Array) -> Array:
        return top - (top - bottom) * z**power

    nodes = np.concatenate([place(rule.c)[None], now.at(place(rule.c))])
    coefficients: Array = nodes @ rule.coefficients.T
    basis = chebyshev.chebvander(2.0 * _CHECKS - 1.0, rule.c.size - 1)
    error = np.abs(coefficients[1:] @ basis.T - now.at(place(_CHECKS)))
    tail = np.abs(coefficients[1:, -2:]).sum(axis=1)
    return coefficients if max(error.max(initial=0.0), tail.max(initial=0.0)) <= tolerance else None
