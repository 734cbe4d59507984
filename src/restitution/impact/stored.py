"""Both halves of a solved impact, finer than reported, with what every branch of the foundation remembers."""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from numpy.typing import NDArray

from restitution.impact.batch import Batch
from restitution.impact.exact import STAGES, solve_stored
from restitution.impact.history import contact_radius
from restitution.impact.problem import Impact
from restitution.impact.scaling import ScaledBlock
from restitution.impact.status import SolverError, Status

if TYPE_CHECKING:
    from restitution.kernel.radau import Scheme

Array = NDArray[np.float64]

# Tolerances to solve with, until one succeeds. At the finest, which very wide spectra do not reach, the
# polynomials between the nodes and the energy balance are good to 1e-12.
_TOLERANCES = (1e-14, 1e-13, 1e-12, 1e-11, 1e-10)


class Half(NamedTuple):
    """Elements of the approach or of the rebound, scaled; E elements, S + 1 points, N rates.

    Attributes
    ----------
    starts, lengths : array, shape (E,)
        Elements in sigma or in lambda.
    columns : array, shape (E, S + 1, n)
        What was stored: s, v, t, d, then `H_k = int_0^t exp(-(t - t')/tau_k) d' dt'` of each rate. In the
        rebound s is that of the approach with the same contact radius.
    pace : array, shape (E, S)
        dt/dsigma or dt/dlambda at the nodes.
    share : float
        What of the last element belongs to the half: that of the approach reaches past the turning point.
    """

    starts: Array
    lengths: Array
    columns: Array
    pace: Array
    share: float


# Columns of a half.
S_, V_, T_, D_, H_ = 0, 1, 2, 3, 4


class StoredImpact:
    """One impact that ended in separation: its motion and its branches as polynomials over the elements.

    Rate 0 stands for the spring in parallel, whose H is d itself. All is scaled as in `ScaledImpact`.

    Parameters
    ----------
    impact : Impact
        A single impact.
    max_depth : float
        Its largest depth [m]: as far as the table of a profile has to reach.
    rtol : float
        A tolerance at which it was solved before.

    Raises
    ------
    ValueError
        If the body stays in contact.
    """

    def __init__(self, impact: Impact, max_depth: float, rtol: float) -> None:
        from restitution.kernel.radau import radau

        block = _block(impact, max_depth)
        outcome, problem, work = solve_stored(block, _TOLERANCES[0])
        for tolerance in (*_TOLERANCES[1:], rtol):
            if outcome[7] == Status.SEPARATED:
                break
            outcome, problem, work = solve_stored(block, tolerance)
        status = Status(int(outcome[7]))
        if status.failed:
            raise SolverError(status)
        if status != Status.SEPARATED:
            raise ValueError(f"history: the contact has no end ({status.message})")
        self.units = block.row(0)
        self.problem = problem
        self.scheme: Scheme = radau(STAGES)
        self.rates = np.append(0.0, 1.0 / problem.times)
        self.moduli = np.append(problem.equilibrium, problem.moduli)
        self.sigma_m = float(work.turning_place[0])
        self.turning_time = float(work.turning[2])
        n_approach, n_rebound = int(work.counts[0]) + 1, int(work.counts[1]) + 1
        stored = np.moveaxis(work.approach[:n_approach, :3], 1, 2).copy()
        pace = 2.0 * stored[:, 1:, S_]
        starts, lengths = work.places[0, :n_approach].copy(), work.places[1, :n_approach].copy()
        memory = self.propagate(
            lengths, pace, self.rates, pace * stored[:, 1:, V_], np.zeros(self.rates.size)
        )
        share = (self.sigma_m - float(starts[-1])) / float(lengths[-1])
        self.approach = Half(starts, lengths, np.dstack([stored, stored[..., :1] ** 2, memory]), pace, share)
        turning = self.approach_at(np.array([self.sigma_m]))[0]
        stored = np.moveaxis(work.rebound[:n_rebound, :3], 1, 2).copy()
        pace = work.slopes[:n_rebound].copy()
        starts, lengths = work.places[2, :n_rebound].copy(), work.places[3, :n_rebound].copy()
        memory = self.propagate(lengths, pace, self.rates, pace * stored[:, 1:, V_], turning[H_:])
        self.rebound = Half(starts, lengths, np.dstack([stored, memory[..., :1], memory]), pace, 1.0)
        self.end = float(stored[-1, -1, T_])

    def propagate(self, lengths: Array, pace: Array, rates: Array, source: Array, start: Array) -> Array:
        """Points of y' = -rate pace y + source over elements one after the other, in sigma or lambda.

        Parameters
        ----------
        lengths : array, shape (E,)
            Lengths of the elements.
        pace : array, shape (E, S)
            dt over the path at the nodes.
        rates : array, shape (N,)
            Rates of decay over time.
        source : array, shape (E, S) or (E, S, N)
            Source over the path at the nodes.
        start : array, shape (N,)
            First values.

        Returns
        -------
        array, shape (E, S + 1, N)
            Values at the ends and the nodes: the collocation that the kernel itself uses.
        """
        A = self.scheme.A
        stages = len(A)
        step = lengths[:, None, None] * A
        matrix = np.eye(stages) + rates[:, None, None] * (step * pace[:, None, :])[:, None]
        wide = np.broadcast_to(source.reshape(*source.shape[:2], -1), (*source.shape[:2], rates.size))
        particular = np.linalg.solve(matrix, np.moveaxis(step @ wide, 2, 1)[..., None])[..., 0]
        homogeneous = np.linalg.solve(matrix, np.ones((stages, 1)))[..., 0]
        points = np.empty((lengths.size, stages + 1, rates.size))
        for element in range(lengths.size):
            points[element, 0] = start
            points[element, 1:] = (particular[element] + homogeneous[element] * start[:, None]).T
            start = points[element, -1]
        return points

    def basis(self, x: Array) -> Array:
        """Lagrange basis on the points of an element at x in [0, 1], shape (n, S + 1)."""
        c = self.scheme.c
        below, above = np.ones((c.size, x.size)), np.ones((c.size, x.size))
        for j in range(1, c.size):
            below[j] = below[j - 1] * (x - c[j - 1])
            above[-1 - j] = above[-j] * (x - c[-j])
        return (below * above).T * self.scheme.weights

    def interpolate(self, columns: Array, element: NDArray[np.intp], x: Array) -> Array:
        """Values of columns, shape (E, S + 1, n), at the places x in elements."""
        return np.einsum("pj,pjn->pn", self.basis(x), columns[element])

    def find(self, half: Half, column: int, values: Array) -> tuple[NDArray[np.intp], Array]:
        """Elements, and places in them, at which a rising column takes the given values."""
        table = half.columns[..., column]
        element = np.clip(np.searchsorted(table[:, 0], values, side="right") - 1, 0, len(table) - 1)
        rows = table[element]
        end = np.where(element == len(table) - 1, half.share, 1.0)
        low, high = np.zeros(values.size), end
        for _ in range(54):
            middle = 0.5 * (low + high)
            late = np.einsum("pj,pj->p", self.basis(middle), rows) > values
            high = np.where(late, middle, high)
            low = np.where(late, low, middle)
        place = np.where(low == 0.0, low, np.where(high == end, end, 0.5 * (low + high)))
        return element, place

    def approach_at(self, sigma: Array) -> Array:
        """All columns of the approach at sigma, shape (n, 4 + N)."""
        element, x = self.places(self.approach, sigma)
        return self.interpolate(self.approach.columns, element, x)

    def places(self, half: Half, position: Array) -> tuple[NDArray[np.intp], Array]:
        """Elements that hold a position in sigma or lambda, and the places in them."""
        element = np.clip(np.searchsorted(half.starts, position, side="right") - 1, 0, half.starts.size - 1)
        return element, (position - half.starts[element]) / half.lengths[element]

    def position(self, half: Half, element: NDArray[np.intp], x: Array) -> Array:
        """Position in sigma or lambda of places in elements."""
        return half.starts[element] + x * half.lengths[element]

    def radius(self, s: Array) -> Array:
        """Contact radius a at s, any shape."""
        return contact_radius(self.units, s)


def _block(impact: Impact, max_depth: float) -> ScaledBlock:
    """Scale an impact, with a table of its profile that reaches to the known depth."""
    block = Batch.from_impact(impact).scaled()
    if block.table is None or block.length[0] > max_depth:
        return block
    return Batch.from_impact(impact).scaled(1.1 * 4.0 * max_depth / float(block.length[0]))
