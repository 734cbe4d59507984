"""Merging of the panels of a free surface: few smooth panels in place of many short panels, one for each step."""

from __future__ import annotations

import numpy as np
from numpy.polynomial import chebyshev

from restitution.checks import Array
from restitution.indentation.surface import Imprint, share_of_step
from restitution.kernel.driver import HALVINGS
from restitution.kernel.merging import merge_panels
from restitution.kernel.panels import FLAT, FROZEN, NODES, scheme

# Number of panels that are not worth merging.
_FEW = 16


def merged(imprint: Imprint, count: int, recoveries: Array, tolerance: float) -> Imprint:
    """Return an imprint with fewer panels, whose displacements [m] now differ by less than a tolerance [m].

    Parameters
    ----------
    imprint : Imprint
        The free surface.
    count : int
        Number of its outermost panels to merge.
    recoveries : array
        Rates of recovery r_j [1/s].
    tolerance : float
        Largest difference of each part of the displacement [m].

    Notes
    -----
    A merged panel holds the state of its elements at one instant. A kink that is too weak to be felt goes.
    Displacements near the edge are functions of the root of the distance from it, and so is z of the outermost panel.
    """
    if count <= _FEW:
        return imprint
    rest, imprint = imprint.some(slice(count, None)), imprint.some(slice(count))
    panels = _now(imprint, recoveries)
    rows, firsts = np.empty_like(panels), np.empty(count, dtype=np.int64)
    parts, pending = np.empty(recoveries.size), np.empty((HALVINGS, 2), dtype=np.int64)
    values, room = np.empty((1 + recoveries.size, NODES)), np.empty((2, NODES))
    size = merge_panels(scheme(), panels, tolerance, rows, firsts, pending, values, parts, room)
    joints = imprint.joint[firsts[:size]]
    joints[0] = FLAT
    zeros = np.zeros(size)
    frozen = np.full(size, FROZEN, dtype=np.int64)
    outer = Imprint(rows[:size], zeros, zeros, frozen, np.ones(size), joints)
    return outer.around(rest)


def _now(imprint: Imprint, recoveries: Array) -> Array:
    """Return panels over the whole of z with the parts of the displacement as they are now, (P, 1 + J, N)."""
    rule = scheme()
    z = imprint.end[:, None] * rule.c
    basis = chebyshev.chebvander(2.0 * z - 1.0, z.shape[1] - 1)
    rows = np.einsum("pqk,pik->qpi", imprint.coefficients, basis)
    elapsed = -(imprint.start[:, None] + imprint.length[:, None] * share_of_step(imprint.kind, z))
    rows[1:] *= np.exp(-recoveries[:, None, None] * elapsed)
    return np.ascontiguousarray(np.einsum("ki,qpi->pqk", rule.coefficients, rows))
