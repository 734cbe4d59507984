"""Scratch space of one element and the stored halves of an impact: few arrays, for each costs the compiler time."""

from typing import Any, NamedTuple

import numpy as np

# Columns of a stored point: s, v, t, F, then two numbers of each mode (see `approach` and `rebound`).
S_, V_, T_, F_, MODES_ = 0, 1, 2, 3, 4

# Rows of `vectors`, values at the nodes. UNKNOWN is s in the approach and u = dt/dlambda in the rebound.
UNKNOWN, RATE, SLOPE, FORCE, INTEGRAL, RADIUS, SPEED, RESIDUAL, SCRATCH, STEP = range(10)
TIME, Q, PHI, PHI_SLOPE, FORCE_SLOPE, Q_SLOPE, BASIS, LAST_TIME, N_VECTORS = (
    1, 2, 5, 10, 11, 12, 13, 14, 15,
)  # fmt: skip
# Members of `matrices`: the inverse of the Jacobian, sums over the modes, what couples them, and the dashpot's inverse.
JACOBIAN, SUM, WEIGHTED, COUPLING, DASHPOT, N_MATRICES = range(6)
# Rows of `places`: where an element starts and how long it is, in sigma and in lambda.
START, LENGTH, BACK_START, BACK_LENGTH = range(4)
# Members of `counts`: last element of the approach and of the rebound, factorisations.
N_APPROACH, N_REBOUND, N_FACTOR = range(3)


class Work(NamedTuple):
    """Scratch space and stored halves for S stages, N modes and E elements.

    Attributes
    ----------
    vectors : ndarray, shape (15, S + 1)
    matrices : ndarray, shape (5, S, S)
    inverses : ndarray, shape (N, S, S)
        Frozen inverses of the modes' matrices B_k.
    modes : ndarray, shape (2, N, S)
        Y_k or X_k, and W_k, at the nodes.
    past : ndarray, shape (S, 4 + 2 N)
        The stored approach at the nodes of a rebound element.
    approach, rebound : ndarray, shape (E, S + 1, 4 + 2 N)
        Stored points. The rebound's first column is the s of the approach with the same contact radius, its modes are X_k
        and W_k.
    places : ndarray, shape (4, E)
    slopes : ndarray, shape (E, S)
        u = dt/dlambda at the nodes of the rebound.
    turning : ndarray, shape (4 + 2 N,)
        The approach at the turning point.
    turning_place : ndarray, shape (1,)
        Its sigma.
    counts : ndarray of int, shape (3,)
    """

    vectors: Any
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


def allocate(S: int, N: int, elements: int) -> Work:
    """Scratch space for S stages, N modes and that many stored elements in each half."""
    columns = MODES_ + 2 * N
    return Work(
        np.zeros((N_VECTORS, S + 1)),
        np.zeros((N_MATRICES, S, S)),
        np.zeros((N, S, S)),
        np.zeros((2, N, S)),
        np.zeros((S, columns)),
        np.zeros((elements, S + 1, columns)),
        np.zeros((elements, S + 1, columns)),
        np.zeros((4, elements)),
        np.zeros((elements, S)),
        np.zeros(columns),
        np.zeros(1),
        np.zeros(3, dtype=np.int64),
    )
