"""Scratch space of one element and the stored halves of an impact: few arrays, for each costs the compiler time."""

from typing import Any, NamedTuple

import numpy as np

from restitution.kernel.lanes import WIDTH

# Rows of a stored element: s, v, t, F, then two numbers of each mode (see `approach` and `rebound`).
S_, V_, T_, F_, MODES_ = 0, 1, 2, 3, 4

# Rows of `vectors`, values at the nodes. UNKNOWN is s in the approach and u = dt/dlambda in the rebound.
UNKNOWN, RADIUS, INTEGRAL, SPEED, FORCE, DELAY, BASIS, VALUES, N_VECTORS = 0, 1, 2, 3, 4, 5, 6, 7, 9
# Members of `matrices`: the inverse of the Jacobian, sums over the modes, what couples them, and the dashpot's inverse.
JACOBIAN, SUM, WEIGHTED, COUPLING, DASHPOT, N_MATRICES = range(6)
# Rows of `places`: where an element starts and how long it is, in sigma and in lambda; whether one of the approach starts
# at a kink.
START, LENGTH, BACK_START, BACK_LENGTH, AT_KINK, N_PLACES = range(6)
# Members of `counts`: last element of the approach and of the rebound, factorisations.
N_APPROACH, N_REBOUND, N_FACTOR = range(3)


class Work(NamedTuple):
    """Scratch space and stored halves for N modes and E elements of S = 8 stages.

    Attributes
    ----------
    vectors : ndarray, shape (9, 2 S)
        Values at the nodes; the basis of an interpolation has S + 1.
    basis : ndarray, shape (S + 1, S)
    matrices : ndarray, shape (5, S, S)
    inverses : ndarray, shape (N, S, S)
        Frozen inverses of the modes' matrices B_k.
    modes : ndarray, shape (2, N, S)
        Y_k or X_k, and W_k, at the nodes.
    past : ndarray, shape (4 + 2 N, S)
        The stored approach at the nodes of a rebound element.
    approach, rebound : ndarray, shape (E, 4 + 2 N, S + 1)
        Stored points, a row for each quantity. The rebound's first row is the s of the approach with the same contact
        radius, its modes are X_k and W_k.
    places : ndarray, shape (5, E)
    slopes : ndarray, shape (E, S)
        u = dt/dlambda at the nodes of the rebound.
    turning : ndarray, shape (4 + 2 N,)
        The approach at the turning point.
    turning_place : ndarray, shape (1,)
        Its sigma.
    counts : ndarray of int, shape (3,)
    """

    vectors: Any
    basis: Any
    matrices: Any
    inverses: Any
    modes: Any
    past: Any
    approach: Any
    rebound: Any
    places: Any
    slopes: Any
    turning: Any
    turning_place: Any
    counts: Any


def aligned(*shape: int) -> Any:
    """Zeros that begin on a line of the processor's cache, so that no row of eight is torn between two."""
    size = int(np.prod(shape))
    memory = np.zeros(size + WIDTH)
    start = -(memory.ctypes.data // 8) % WIDTH
    return memory[start : start + size].reshape(shape)


def allocate(N: int, elements: int) -> Work:
    """Scratch space for N modes and that many stored elements in each half."""
    S, rows = WIDTH, MODES_ + 2 * N
    return Work(
        aligned(N_VECTORS, 2 * S),
        aligned(S + 1, S),
        aligned(N_MATRICES, S, S),
        aligned(N, S, S),
        aligned(2, N, S),
        aligned(rows, S),
        aligned(elements, rows, S + 1),
        aligned(elements, rows, S + 1),
        np.zeros((N_PLACES, elements)),
        aligned(elements, S),
        np.zeros(rows),
        np.zeros(1),
        np.zeros(3, dtype=np.int64),
    )
