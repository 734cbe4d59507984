"""Forces of many materials under measured depths, sample by sample."""

from __future__ import annotations

import math
from collections.abc import Sequence
from threading import local
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from restitution.checks import Array
from restitution.contact.geometry import Geometry
from restitution.contact.table import path_table, scaled
from restitution.indentation.solid import solids_of
from restitution.kernel.path import power_path, table_path
from restitution.kernel.record import SOLVED, Records, Solids, Tip, record_forces, room
from restitution.material.prony import PronySeries
from restitution.parallel import on_threads

# Noise of a rate over the speed, and the ratio of misfits of lines from which a kink is in one of them.
_QUIET, _KINK = 0.03, 1.5
# Rows in a task of a thread.
_CHUNK = 64
# A step moves the tip by at most this share of the range of the depth, and lasts at most this share of the record.
_MOVE, _LAST = 1.0 / 200.0, 1.0 / 200.0


class Record(NamedTuple):
    """Measured depth."""

    time: Array  # [s], ascending
    depth: Array  # [m], joined by straight lines
    compliance: float = 0.0  # of the spring [m/N] if the depth is that of its base
    noise: float = 0.0  # standard deviation of the depth [m]


class RecordBlock:
    """Measured depths of one profile, for which the forces of many materials and contact points are computed.

    Parameters
    ----------
    profile : Geometry
        Profile of the indenter, with scalar parameters.
    records : sequence of Record
        Depths, any number of approaches and releases, with noise. They begin above the surface.
    deepest : float
        Largest depth [m] below a contact point that a table of the profile must cover.
    refinement : int
        Factor of the number of steps.

    Notes
    -----
    One element for each step, of second order in its length. `refined` has steps of half that length; four thirds of
    the difference of forces is their error.
    """

    def __init__(self, profile: Geometry, records: Sequence[Record], deepest: float, *, refinement: int = 1) -> None:
        self._arguments = profile, records, deepest, refinement
        sizes = np.array([record.time.size for record in records])
        parts = [_parts(record) * refinement for record in records]
        self.n_samples = sizes
        self._steps = max(int(part.sum()) for part in parts)
        rates, drags, gains = (
            np.concatenate(column) for column in zip(*(rates_of(record) for record in records), strict=True)
        )
        self._records = Records(
            np.concatenate([[0], np.cumsum(sizes)]), np.concatenate([record.time for record in records]),
            np.concatenate([record.depth for record in records]), np.concatenate(parts), rates, drags, gains,
            np.array([record.compliance for record in records]),
        )  # fmt: skip
        end = float(np.min(profile.max_depth))
        if profile.path_exponent is not None and profile.path_coefficient is not None:
            self._tip = Tip(power_path(float(profile.path_exponent)), 1.0, float(profile.path_coefficient), end)
        else:
            unit = min(deepest, end)
            table, radius = path_table(profile, unit), float(profile.stiffness_radius(unit))
            self._tip = Tip(table_path(scaled(table, unit, radius)), unit, radius, unit)

    def forces(
        self, reduced: PronySeries, contact_points: Array, places: NDArray[np.int64] | None = None, *, workers: int = 1
    ) -> tuple[Array, Array]:
        """Return the forces [N] of n materials at the samples, and their slopes over single depths [N/m].

        Parameters
        ----------
        reduced : PronySeries
            Reduced moduli E*(t) of n materials.
        contact_points : array, shape (n,)
            Depth readings [m] at first touch.
        places : array of int, shape (n,)
            Index of the record of each row; the first record by default.
        workers : int
            Number of threads.

        Returns
        -------
        forces, slopes : array, shape (n, n_samples)
            NaN in a row without a result, which begins in contact, passes the end of the profile or has a modulus that
            is not finite; and after the last sample of a record. A slope is the change of the force if the depth of
            this sample alone changes.
        """
        n = contact_points.size
        curves = np.zeros(n, dtype=np.int64) if places is None else np.asarray(places, dtype=np.int64)
        points = np.ascontiguousarray(contact_points, dtype=np.float64)
        result = np.full((2, n, int(self.n_samples.max())), np.nan)
        for rows, solids in solids_of(reduced):
            sizes, kept = (solids.rates.shape[1], solids.recoveries.shape[1]), local()

            def run(
                start: int, solids: Solids = solids, sizes: tuple[int, int] = sizes, kept: Any = kept,
                rows: NDArray[np.intp] = rows,
            ) -> None:  # fmt: skip
                if not hasattr(kept, "room"):
                    kept.room = room(self._steps, *sizes)
                part = slice(start, start + _CHUNK)
                some, at = Solids(*(column[part] for column in solids)), rows[part]
                # A part of a larger array has strides, and the compiler would make a second version for them.
                values, status = np.full((2, at.size, result.shape[2]), np.nan), np.empty(at.size, dtype=np.int64)
                record_forces(some, self._tip, self._records, curves[at], points[at], kept.room, values, status)
                values[:, status != SOLVED] = np.nan
                result[:, at] = values

            starts = range(0, rows.size, _CHUNK)
            if len(starts) == 1 or workers == 1:
                for start in starts:
                    run(start)
            else:
                on_threads(run, starts, workers, lambda: None)
        return result[0], result[1]

    def refined(self) -> RecordBlock:
        """Return the same block with steps of half the length."""
        profile, records, deepest, refinement = self._arguments
        return RecordBlock(profile, records, deepest, refinement=2 * refinement)


def _parts(record: Record) -> NDArray[np.int64]:
    """Return the number of steps from the sample before to each sample."""
    moves = np.abs(np.diff(record.depth)) / max(np.ptp(record.depth) * _MOVE, 1e-300)
    lasts = np.diff(record.time) / ((record.time[-1] - record.time[0]) * _LAST)
    parts = np.ceil(np.maximum(moves, lasts) - 1e-9).astype(np.int64)
    return np.concatenate([[0], np.maximum(parts, 1)])


def rates_of(record: Record) -> tuple[Array, Array, Array]:
    """Return rates of the depth before each sample and at each sample, and their noise over that of the depth.

    A dashpot in parallel feels the rate, in which noise of the depth would be as large as the motion. So the rate is
    that of a line through so many samples that its noise is a few per cent of the speed. Of the samples before, around
    and behind, those are taken that are closest to a line, as a kink is no noise. Without noise the rate at a sample
    is that behind it, as in `rs.indent`.
    """
    time, depth = record.time, record.depth
    rates, gains = np.diff(depth) / np.diff(time), math.sqrt(2.0) / np.diff(time)
    apart = max(time.size // 50, 1)
    speed = float(np.quantile(np.abs((depth[apart:] - depth[:-apart]) / (time[apart:] - time[:-apart])), 0.9))
    step = float(np.median(np.diff(time)))
    count = math.ceil((math.sqrt(12.0) * record.noise / max(_QUIET * speed * step, 1e-300)) ** (2.0 / 3.0)) + 1
    count = min(count, time.size // 8)
    at = np.append(rates[1:], rates[-1])
    if count > 2:
        t = np.lib.stride_tricks.sliding_window_view(time, count)
        d = np.lib.stride_tricks.sliding_window_view(depth, count)
        t, d = t - t.mean(axis=1, keepdims=True), d - d.mean(axis=1, keepdims=True)
        spread = np.einsum("ij,ij->i", t, t)
        slopes = np.einsum("ij,ij->i", t, d) / spread
        misfit = ((d - slopes[:, None] * t) ** 2).sum(axis=1)
        # The first sample of the lines before, around and behind each step.
        place = np.arange(rates.size)
        choices = np.clip(np.stack([place - count // 2 + 1, place - count + 2, place]), 0, slopes.size - 1)
        misfits = misfit[choices] * np.array([[1.0], [_KINK], [_KINK]])
        best = choices[np.argmin(misfits, axis=0), place]
        rates, gains = slopes[best], 1.0 / np.sqrt(spread[best])
        at = 0.5 * (rates + np.append(rates[1:], rates[-1]))
    return np.append(0.0, rates), np.append(rates[0], at), np.append(0.0, gains)
