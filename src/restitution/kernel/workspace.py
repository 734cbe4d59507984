"""Scratch space of one element and the stored halves of an impact, in few arrays, as each costs compile time."""

import math
from typing import Any, NamedTuple

import numpy as np

from restitution.kernel.compile import inlined
from restitution.kernel.lanes import WIDTH
from restitution.kernel.path import Path, path_inside

# Rows of a stored element: s, v, t, F, then two rows per mode (see `approach` and `rebound`).
S_, V_, T_, F_, MODES_ = 0, 1, 2, 3, 4

# Rows of `vectors`, values at the nodes. UNKNOWN is s in the approach and u = dt/dlambda in the rebound.
UNKNOWN, RADIUS, INTEGRAL, SPEED, FORCE, DELAY, BASIS, VALUES, N_VECTORS = 0, 1, 2, 3, 4, 5, 6, 7, 9
SLOPE, DIAGONAL = DELAY, INTEGRAL  # in the approach, which uses neither
# Members of `matrices`: inverse of the Jacobian, sums over the modes, coupling of the modes, inverse of the dashpot.
JACOBIAN, SUM, WEIGHTED, COUPLING, DASHPOT, N_MATRICES = range(6)
# Rows of `places`: start and length of an element in sigma and in lambda; whether one of the approach starts at a
# kink.
START, LENGTH, BACK_START, BACK_LENGTH, AT_KINK, N_PLACES = range(6)
# Members of `counts`: last element of the approach and of the rebound, factorisations.
N_APPROACH, N_REBOUND, N_FACTOR = range(3)


class Problem(NamedTuple):
    """One impact in units with mass and impact velocity 1, d = s^2 and a = a(s).

    F = equilibrium Pi + viscosity a v + sum moduli_k Y_k, d' = v, and v + admittance F, the velocity of the body, has
    the rate -(F - external_force).
    """

    equilibrium: float
    moduli: Any
    times: Any
    viscosity: float
    external_force: float
    admittance: float  # velocity of the target over the force; 0 for a target that does not move
    path: Path


class Problems(NamedTuple):
    """Many impacts; row n has the path which[n] of several, and the modes offsets[n] to offsets[n + 1]."""

    firsts: Any  # (n,): scale of s, for the length of the first element
    equilibria: Any  # (n,)
    viscosities: Any  # (n,)
    external_forces: Any  # (n,)
    admittances: Any  # (n,)
    offsets: Any  # (n + 1,)
    moduli: Any  # (modes of all rows,)
    times: Any
    paths: Path
    which: Any  # (n,)


@inlined
def problem_inside(problems: Problems, n: int) -> Problem:
    """Return impact n of several."""
    low, high = problems.offsets[n], problems.offsets[n + 1]
    return Problem(
        problems.equilibria[n], problems.moduli[low:high], problems.times[low:high], problems.viscosities[n],
        problems.external_forces[n], problems.admittances[n], path_inside(problems.paths, problems.which[n]),
    )  # fmt: skip


class Work(NamedTuple):
    """Scratch space and stored halves for N modes and E elements with S = 8 stages."""

    vectors: Any  # (9, 2 S): values at the nodes; the basis of an interpolation has S + 1
    basis: Any  # (S + 1, S)
    matrices: Any  # (5, S, S)
    inverses: Any  # (N, S, S): frozen inverses of the modes' matrices B_k
    modes: Any  # (2, N, S): Y_k or X_k, and W_k, at the nodes
    past: Any  # (4 + 2 N, S): the stored approach at the nodes of a rebound element
    # (E, 4 + 2 N, S + 1): stored points, a row for each quantity. The rebound's first row is the s of the approach
    # with the same contact radius, its modes are X_k and W_k
    approach: Any
    rebound: Any  # (E, 4 + 2 N, S + 1)
    places: Any  # (5, E)
    slopes: Any  # (E, S): u = dt/dlambda at the nodes of the rebound
    turning: Any  # (4 + 2 N,): the approach at the turning point
    turning_place: Any  # (1,): its sigma
    counts: Any  # (3,)


def aligned(*shape: int, room: Any = np.zeros) -> Any:
    """Zeros, or room, aligned to the processor's cache lines, so that no row of eight numbers crosses one."""
    size = math.prod(shape)
    memory = room(size + WIDTH)
    start = -(memory.ctypes.data // 8) % WIDTH
    return memory[start : start + size].reshape(shape)


def allocate(N: int, elements: int) -> Work:
    """Return scratch space for N modes and a number of stored elements in each half."""
    S, rows = WIDTH, MODES_ + 2 * N
    return Work(
        aligned(N_VECTORS, 2 * S),
        aligned(S + 1, S),
        aligned(N_MATRICES, S, S),
        aligned(N, S, S),
        aligned(2, N, S),
        aligned(rows, S),
        aligned(elements, rows, S + 1, room=np.empty),
        aligned(elements, rows, S + 1, room=np.empty),
        np.zeros((N_PLACES, elements)),
        aligned(elements, S, room=np.empty),
        np.zeros(rows),
        np.zeros(1),
        np.zeros(3, dtype=np.int64),
    )
