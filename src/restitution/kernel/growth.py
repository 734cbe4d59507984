"""Sums of the loads of a contact that grows: what the elements bear that the front of a step reaches.

    L_k' = E_k a d' + l_k^touch a' - rho_k L_k

At a front on an imprint int a dd = Pi + int a dW with the surface W there, which is zero on virgin surface, and
a dW = d(a W) - W da (docs/development/decisions/histories.md).
"""

import math
from typing import Any

from numpy.polynomial.legendre import leggauss

from restitution.kernel.compile import compiled, inlined
from restitution.kernel.driver import FREE_PANELS, PI, A, D, Driver, F, Room, Y
from restitution.kernel.panels import FORGOTTEN, NODES, STAGES, Scheme, Solid, polynomials, share, value_of
from restitution.kernel.path import Path, radius_and_integral

# Gauss quadrature over the elements that the front touches between two nodes.
_PLACES, _WEIGHTS = 0.5 + 0.5 * leggauss(6)[0], 0.5 * leggauss(6)[1]


@inlined
def at_nodes(matrix: Any, values: Any, result: Any) -> None:
    """Write the product of a matrix with values at the nodes 1 to S."""
    for i in range(STAGES):
        total = 0.0
        for j in range(STAGES):
            total += matrix[i, j] * values[j + 1]
        result[i + 1] = total


@inlined
def differentiate(rule: Scheme, values: Any, result: Any) -> None:
    """Write the slopes over z at the nodes."""
    for i in range(NODES):
        total = 0.0
        for j in range(NODES):
            total += rule.derivative[i, j] * values[j]
        result[i] = total


@compiled
def add_swept(solid: Solid, path: Path, room: Room, i: int, p: int, top: float, bottom: float, sign: float) -> None:
    """Add `int w_j da` of the elements of a free panel between two places, as they were untouched at a node."""
    panels, basis, slopes, swept, t = room.free, room.basis[0], room.basis[1], room.swept, room.times[i]
    rows = panels.coefficients[p]
    for n in range(-2, _PLACES.size):
        z = top if n == -2 else bottom if n == -1 else top + (bottom - top) * _PLACES[n]
        polynomials(z, basis, slopes)
        passed, pace = share(panels.kind[p], z)
        elapsed, pace = t - panels.start[p] - panels.length[p] * passed, panels.length[p] * pace
        radius = sign * radius_and_integral(path, max(value_of(rows[0], basis), 0.0))[0]
        for j in range(solid.recoveries.shape[0]):
            r = solid.recoveries[j]
            decay, w = math.exp(max(-r * elapsed, FORGOTTEN)), value_of(rows[1 + j], basis)
            if n < 0:
                swept[j, i] += (-radius if n == -2 else radius) * decay * w
            else:
                # By parts, as the profile has no slope of a.
                slope = decay * (value_of(rows[1 + j], slopes) + r * pace * w)
                swept[j, i] -= (bottom - top) * _WEIGHTS[n] * radius * slope


@compiled
def write_swept(solid: Solid, path: Path, room: Room) -> None:
    """Write `int w_j da` of the elements that a growing front has touched since the start, as if untouched at a node.

    With this U_j, `int w_j da` at the front is `U_j + r_j int U_j dt`: a function of where the front is, and a small
    rest. So the force at a node where a contact has just begun has no errors from the other nodes.
    """
    swept, at, z, end = room.swept, room.at, room.z, room.free.end
    for i in range(1, NODES):
        for j in range(solid.recoveries.shape[0]):
            swept[j, i] = swept[j, i - 1] * math.exp(-solid.recoveries[j] * (room.times[i] - room.times[i - 1]))
        first, last, sign = i - 1, i, 1.0
        if at[first] < at[last]:
            # A trial of Newton's method may recede.
            first, last, sign = i, i - 1, -1.0
        for p in range(max(at[last], 0), at[first] + 1):
            top = z[first] if p == at[first] else end[p]
            add_swept(solid, path, room, i, p, top, z[last] if p == at[last] else 0.0, sign)


@compiled
def write_growing_sums(solid: Solid, driver: Driver, path: Path, rule: Scheme, room: Room) -> None:
    """Write L_k of the growing contact, and add them to the forces."""
    nodes, vectors, swept, J = room.nodes, room.vectors, room.swept, solid.recoveries.shape[0]
    source, result, growth, common = vectors[0], vectors[1], vectors[2], vectors[4]
    was_touched = room.places[FREE_PANELS] > 0
    if was_touched:
        if driver.by_depth or driver.mass > 0.0:
            differentiate(rule, nodes[A], growth)
        else:
            write_swept(solid, path, room)
        for i in range(NODES):
            common[i] = nodes[A, i] * (nodes[D, i] - nodes[Y, i] * nodes[Y, i])
        for j in range(J):
            if driver.by_depth or driver.mass > 0.0:
                for i in range(NODES):
                    source[i] = room.displacements[j, i] * growth[i]
                at_nodes(rule.A, source, swept[j])
            else:
                for i in range(NODES):
                    source[i] = solid.recoveries[j] * room.weights[i] * swept[j, i]
                at_nodes(rule.A, source, result)
                for i in range(1, NODES):
                    swept[j, i] += result[i]
            for i in range(1, NODES):
                common[i] -= swept[j, i]
    for k in range(solid.rates.shape[0]):
        for i in range(1, NODES):
            rise = nodes[PI, i] - nodes[PI, 0]
            source[i] = room.L[k, 0]
            if was_touched:
                rise += common[i] - common[0]
                for j in range(J):
                    source[i] += solid.moduli_of[k, j] * swept[j, i]
            source[i] += solid.moduli[k] * rise
        at_nodes(room.inverse[k], source, room.L[k])
        for i in range(1, NODES):
            nodes[F, i] += room.L[k, i]
