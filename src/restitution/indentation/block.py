"""Many indentations at once: a material, a prescribed depth and a contact point in each row."""

from __future__ import annotations

from collections.abc import Sequence
from threading import local

import numpy as np
from numpy.typing import NDArray

from restitution.contact.geometry import Geometry
from restitution.contact.path import path_table, scaled
from restitution.indentation.evolution import room_for, scratch
from restitution.indentation.history import without_collinear
from restitution.kernel.indentation import Recovery
from restitution.kernel.indentation_rows import Histories, Room, Rows, indent_rows
from restitution.kernel.memory import DEPTH, TERMS, ScaledContact, allocate, quadrature
from restitution.kernel.path import power_path, table_path
from restitution.material.columns import PronyColumns
from restitution.parallel import on_threads

Array = NDArray[np.float64]

# Rows in a task of a thread: about 10 ms.
_CHUNK = 64
# Elements of a growing contact for which a thread has room, beside four in each segment.
_ELEMENTS = 1024


class IndentationBlock:
    """Prescribed depths of one profile, for which the forces of many materials and contact points are computed.

    Parameters
    ----------
    profile : Geometry
        Profile of the indenter, with scalar parameters.
    histories : sequence of (time, depth, samples)
        For each curve: times [s] and depths [m] of points joined by straight lines, and the ascending times [s] of the
        samples within them.
    deepest : float
        Largest depth [m] below a contact point that a table of the profile must cover.
    """

    def __init__(self, profile: Geometry, histories: Sequence[tuple[Array, Array, Array]], deepest: float) -> None:
        points = [without_collinear(time, depth) for time, depth, _ in histories]
        samples = [times for _, _, times in histories]
        self.n_samples = np.array([one.size for one in samples])
        self._histories = Histories(
            _offsets([time.size for time, _ in points]), np.concatenate([time for time, _ in points]),
            np.concatenate([depth for _, depth in points]), _offsets(self.n_samples), np.concatenate(samples),
        )  # fmt: skip
        self._segments = max(time.size for time, _ in points) - 1
        self._deepest = float(np.min(profile.max_depth))
        if profile.path_exponent is not None and profile.path_coefficient is not None:
            self._path, self._unit = power_path(float(profile.path_exponent)), 1.0
            self._radius = float(profile.path_coefficient)
        else:
            self._unit = min(deepest, self._deepest)
            self._deepest = self._unit
            table = path_table(profile, self._unit)
            self._radius = float(profile.stiffness_radius(self._unit))
            self._path = table_path(scaled(table, self._unit, self._radius))

    def forces(
        self, reduced: PronyColumns, contact_points: Array, curves: NDArray[np.int64] | None = None, *,
        rtol: float = 1e-6, workers: int | None = 1,
    ) -> tuple[Array, NDArray[np.int64]]:  # fmt: skip
        """Forces of rows of materials at the samples.

        Parameters
        ----------
        reduced : PronyColumns
            Reduced moduli E*(t) of n materials.
        contact_points : array, shape (n,)
            Depth readings [m] at first touch.
        curves : array of int, shape (n,)
            Index of the history of each row; the first history by default.
        rtol : float
            Error of forces over the largest one.
        workers : int, optional
            Number of threads; the number of cores for None.

        Returns
        -------
        forces : array, shape (n, n_samples)
            Forces [N]; NaN in a row without a result, and after the last sample of its curve.
        statuses : array of int, shape (n,)
            `restitution.indentation.result.IndentationStatus`.
        """
        n = contact_points.size
        places = np.zeros(n, dtype=np.int64) if curves is None else np.asarray(curves, dtype=np.int64)
        forces = np.full((n, int(self.n_samples.max())), np.nan)
        statuses = np.empty(n, dtype=np.int64)
        columns = (*map(np.ascontiguousarray, reduced), np.ascontiguousarray(contact_points, dtype=np.float64), places)
        # Arrays of each thread, for all its chunks of rows.
        kept = local()

        def run(start: int) -> None:
            if not hasattr(kept, "room"):
                kept.room = self._room(reduced.moduli.shape[1])
            part = slice(start, start + _CHUNK)
            rows = Rows(*(column[part] for column in columns))
            indent_rows(
                quadrature(), rtol, rows, self._histories, self._deepest, self._unit, self._radius, kept.room,
                _NO_RECOVERY, forces[part], statuses[part],
            )  # fmt: skip

        starts = range(0, n, _CHUNK)
        if len(starts) == 1 or workers == 1:
            for start in starts:
                run(start)
        else:
            on_threads(run, starts, workers, lambda: None)
        return forces, statuses

    def _room(self, modes: int) -> Room:
        """Arrays for the indentations of one thread."""
        m, nothing, samples = self._segments, np.empty(0), int(self.n_samples.max())
        rates, none = np.empty(modes), allocate(np.empty(0), 0)
        contact = ScaledContact(
            DEPTH, np.empty(m + 1), np.empty((m, 2)), 0.0, np.empty(modes), rates, 0.0, 1.0, 0.0, nothing, nothing,
            none, none, self._path,
        )  # fmt: skip
        segments, past = room_for(rates, m, _ELEMENTS + 4 * m)
        checks = m * (9 + 2 * modes)
        return Room(
            contact, segments, past, scratch(modes), np.empty(checks, dtype=np.int64), np.empty(checks),
            np.empty(samples), np.empty((5, samples)),
        )  # fmt: skip


_NO_RECOVERY = Recovery(np.empty(0), np.empty(0), np.empty((0, TERMS)), allocate(np.empty(0), 0))


def _offsets(sizes: Sequence[int] | NDArray[np.int64]) -> NDArray[np.int64]:
    return np.concatenate([[0], np.cumsum(sizes)]).astype(np.int64)
