"""Elements of a surface that a body touches once in each period of its depth: their periodic state.

Elements do not feel each other, so that each has a periodic state of its own for a given depth over the period: the
fixed point of the map that touch, contact, end of contact and recovery make of the parts w_j of its displacement at
the start of the period, where the body is free. Newton's method finds it, however slowly some parts relax. With a
small change dw_j at the start and dW of their sum an element is touched at another instant; to first order, whatever
the rates, its loads then differ by

    dl_k = E_k (sum_j theta_jk dw_j - dW),    dl_k' = -rho_k dl_k

and, as its load is zero where it leaves, dw_j = sum_k theta_jk dl_k/S_j there.

A part that relaxes in a million periods changes by a millionth of itself in one. This change comes from integrals,

    dw_j/dt = -sum_k theta_jk rho_k l_k/S_j    in contact without a parallel dashpot,    -r_j w_j    beside it,

as a difference of w_j before and after would have no correct digits.
"""

import math
from typing import Any, NamedTuple

from restitution.kernel.compile import compiled, entry_point, inlined
from restitution.kernel.driver import Room
from restitution.kernel.elimination import solve_linear
from restitution.kernel.growth import at_nodes
from restitution.kernel.panels import FORGOTTEN, NODES, Scheme, Solid, polynomials, share, to_coefficients, value_of
from restitution.kernel.references import by_reference
from restitution.kernel.stepper import write_integral, write_inverses

_MOST_ITERATIONS = 40
_MOST_HALVINGS = 30


@by_reference
class Motion(NamedTuple):
    """Depth of a body over a period, in pieces of polynomials over z."""

    start: Any  # (M,)
    length: Any  # (M,)
    kind: Any  # (M,): map of the time
    depth: Any  # (M, N): Chebyshev coefficients
    memory: Any  # (M, K, N): those of h_k
    sum: Any  # (M, K, N): those of the integral of h_k over the time
    peak: int  # Piece and place of the largest depth
    place: float
    period: float


@by_reference
class Bench(NamedTuple):
    """Scratch space for one element."""

    loads: Any  # (K,): l_k - E_k h_k at the touch
    change: Any  # (J,): of w_j in a period
    matrix: Any  # (J, J + 1)
    basis: Any  # (2, N)


@entry_point
def write_memory(solid: Solid, rule: Scheme, room: Room, motion: Motion, depths: Any) -> None:
    """Write h_k and their integrals; `depths` are those at the nodes, (M, N)."""
    source, values, total = room.vectors[0], room.vectors[1], room.vectors[2]
    for m in range(motion.start.shape[0]):
        for i in range(NODES):
            room.weights[i] = motion.length[m] * share(motion.kind[m], rule.c[i])[1]
        write_integral(rule, room)
        write_inverses(solid, room)
        for k in range(solid.rates.shape[0]):
            values[0] = room.memory[k]
            for i in range(1, NODES):
                source[i] = room.memory[k] + depths[m, i] - depths[m, 0]
            at_nodes(room.inverse[k], source, values)
            room.memory[k] = values[NODES - 1]
            to_coefficients(rule, values, motion.memory[m, k])
            total[0] = 0.0
            for n in range(NODES if m > 0 else 0):
                total[0] += motion.sum[m - 1, k, n]
            for i in range(NODES - 1):
                total[i + 1] = total[0]
                for j in range(NODES - 1):
                    total[i + 1] += rule.A[i, j] * room.weights[j + 1] * values[j + 1]
            to_coefficients(rule, total, motion.sum[m, k])


@compiled
def gap_at(solid: Solid, motion: Motion, m: int, z: float, s: float, w: Any, basis: Any) -> tuple[float, float]:
    """Return how far the body is below an element at z of a piece, and the slope over z."""
    polynomials(z, basis[0], basis[1])
    passed, pace = share(motion.kind[m], z)
    t, pace = motion.start[m] + motion.length[m] * passed, motion.length[m] * pace
    value, slope = value_of(motion.depth[m], basis[0]) - s, value_of(motion.depth[m], basis[1])
    for j in range(w.shape[0]):
        part = w[j] * math.exp(max(-solid.recoveries[j] * t, FORGOTTEN))
        value -= part
        slope += solid.recoveries[j] * pace * part
    return value, slope


@compiled
def load_at(
    solid: Solid, motion: Motion, m: int, z: float, s: float, touch: float, bench: Bench
) -> tuple[float, float]:
    """Return the load of an element at z of a piece, which changed sign, and its slope over z."""
    basis = bench.basis
    polynomials(z, basis[0], basis[1])
    passed, pace = share(motion.kind[m], z)
    t, pace = motion.start[m] + motion.length[m] * passed, motion.length[m] * pace
    value = solid.equilibrium * (value_of(motion.depth[m], basis[0]) - s)
    slope = solid.equilibrium * value_of(motion.depth[m], basis[1])
    for k in range(solid.rates.shape[0]):
        part = bench.loads[k] * math.exp(max(-solid.rates[k] * (t - touch), FORGOTTEN))
        value += part + solid.moduli[k] * value_of(motion.memory[m, k], basis[0])
        slope += solid.moduli[k] * value_of(motion.memory[m, k], basis[1]) - solid.rates[k] * pace * part
    return -value, -slope


@inlined
def value_at(
    solid: Solid, motion: Motion, m: int, z: float, s: float, w: Any, touch: float, bench: Bench
) -> tuple[float, float]:
    """Return what rises through zero: before the touch the body, and behind it the load with a changed sign."""
    if touch < 0.0:
        return gap_at(solid, motion, m, z, s, w, bench.basis)
    return load_at(solid, motion, m, z, s, touch, bench)


@compiled
def find(solid: Solid, motion: Motion, s: float, w: Any, touch: float, bench: Bench) -> tuple[int, float]:
    """Return piece and z of the touch, or, behind a touch, of the end of the contact; piece -1 without one.

    The touch is the last one before the depth is largest, the end the first one behind.
    """
    m, low, high = motion.peak, 0.0, motion.place
    if touch < 0.0:
        if not gap_at(solid, motion, m, high, s, w, bench.basis)[0] > 0.0:
            return -1, 0.0
        while gap_at(solid, motion, m, 0.0, s, w, bench.basis)[0] > 0.0:
            if m == 0:
                return -1, 0.0
            m, high = m - 1, 1.0
    else:
        low, high = motion.place, 1.0
        while not load_at(solid, motion, m, 1.0, s, touch, bench)[0] > 0.0:
            if m == motion.start.shape[0] - 1:
                return -1, 0.0
            m, low = m + 1, 0.0
    z = 0.5 * (low + high)
    for _ in range(60):
        value, slope = value_at(solid, motion, m, z, s, w, touch, bench)
        if value > 0.0:
            high = z
        else:
            low = z
        target = z - value / slope if slope > 0.0 else -1.0
        if not low <= target <= high:
            target = 0.5 * (low + high)
        if abs(target - z) <= 1e-15:
            break
        z = target
    return m, z


@inlined
def time_of(motion: Motion, m: int, z: float) -> float:
    """Return the time at z of a piece."""
    return motion.start[m] + motion.length[m] * share(motion.kind[m], z)[0]


@compiled
def pass_period(solid: Solid, motion: Motion, s: float, w: Any, bench: Bench) -> tuple[float, float]:
    """Write what a period changes of the parts of an element; return the times of touch and end, or -1."""
    J, K, basis = solid.recoveries.shape[0], solid.rates.shape[0], bench.basis
    m, z = find(solid, motion, s, w, -1.0, bench)
    if m < 0:
        return -1.0, 0.0
    touch, first, z_touch = time_of(motion, m, z), m, z
    polynomials(z, basis[0], basis[1])
    for k in range(K):
        bench.loads[k] = -solid.moduli[k] * value_of(motion.memory[m, k], basis[0])
        for j in range(J):
            part = w[j] * math.exp(max(-solid.recoveries[j] * touch, FORGOTTEN))
            bench.loads[k] += solid.moduli_of[k, j] * part
    m, z = find(solid, motion, s, w, touch, bench)
    if m < 0:
        return -1.0, 0.0
    end = time_of(motion, m, z)
    for j in range(J):
        bench.change[j] = 0.0
    for k in range(K):
        polynomials(z_touch, basis[0], basis[1])
        held = -value_of(motion.sum[first, k], basis[0])
        polynomials(z, basis[0], basis[1])
        held += value_of(motion.sum[m, k], basis[0])
        # What the branch relaxes in contact.
        relaxed = solid.moduli[k] * solid.rates[k] * held
        relaxed -= bench.loads[k] * math.expm1(max(-solid.rates[k] * (end - touch), FORGOTTEN))
        for j in range(J):
            bench.change[j] -= solid.loads[j, k] * relaxed
    for j in range(J):
        bench.change[j] *= math.exp(max(-solid.recoveries[j] * (motion.period - end), FORGOTTEN))
        free = motion.period - (end - touch)
        bench.change[j] += w[j] * math.expm1(max(-solid.recoveries[j] * free, FORGOTTEN))
    return touch, end


@compiled
def write_correction(solid: Solid, motion: Motion, touch: float, end: float, bench: Bench) -> bool:
    """Write the correction of the parts by Newton's method into the last column; return whether there is one."""
    J, K, M = solid.recoveries.shape[0], solid.rates.shape[0], bench.matrix
    for j in range(J):
        late = math.exp(max(-solid.recoveries[j] * (motion.period - end), FORGOTTEN))
        for n in range(J):
            total = 0.0
            for k in range(K):
                decay = math.exp(max(-solid.rates[k] * (end - touch), FORGOTTEN))
                total += solid.loads[j, k] * decay * (solid.moduli_of[k, n] - solid.moduli[k])
            early = math.exp(max(-solid.recoveries[n] * touch, FORGOTTEN))
            M[j, n] = (1.0 if j == n else 0.0) - late * total * early
        M[j, J] = bench.change[j]
    return solve_linear(M, J)


@entry_point
def write_periodic(
    solid: Solid, motion: Motion, depths: Any, parts: Any, guess: Any, tolerance: float, bench: Bench
) -> int:
    """Write the periodic parts w_j of elements, named by s, from the outermost to the innermost.

    Returns the number of those that were solved.
    """
    J = solid.recoveries.shape[0]
    for j in range(J):
        guess[j] = 0.0
    for e in range(depths.shape[0]):
        w, s = parts[e], depths[e]
        touch, end = pass_period(solid, motion, s, guess, bench)
        if touch < 0.0:
            return e
        for j in range(J):
            w[j] = guess[j]
        for iteration in range(_MOST_ITERATIONS):
            if not write_correction(solid, motion, touch, end, bench):
                return e
            size, part = 0.0, 1.0
            for j in range(J):
                size = max(size, abs(bench.matrix[j, J]))
            for _ in range(_MOST_HALVINGS):
                for j in range(J):
                    guess[j] = w[j] + part * bench.matrix[j, J]
                touch, end = pass_period(solid, motion, s, guess, bench)
                if not touch < 0.0:
                    break
                # Elements that are too deep are not touched.
                part *= 0.5
            if touch < 0.0:
                return e
            for j in range(J):
                w[j] = guess[j]
            if part == 1.0 and size <= tolerance:
                break
            if iteration == _MOST_ITERATIONS - 1:
                return e
    return depths.shape[0]
