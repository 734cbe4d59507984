"""Geometries of one kind, one for each row of a batch of impacts, whose tables are made together."""

from __future__ import annotations

from abc import abstractmethod
from functools import cached_property
from typing import NamedTuple, Self

import numpy as np
from numpy.typing import NDArray

from restitution.contact.geometry import Array, Geometry
from restitution.contact.path import PathTable


class Samples(NamedTuple):
    """Logarithms of depths [m] and force integrals [m^2] of several geometries over a common parameter.

    Attributes
    ----------
    knots : array, shape (n,)
        Values of the parameter at equal distances.
    depth, integral : array, shape (n_geometry, n)
        Logarithms, rising.
    """

    knots: Array
    depth: Array
    integral: Array

    def at(self, x: Array, which: NDArray[np.intp]) -> tuple[Array, Array]:
        """Depth [m] and force integral [m^2] of the geometries `which` at values x."""
        if len(self.depth) == 1:
            return np.exp(np.interp(x, self.knots, self.depth[0])), np.exp(np.interp(x, self.knots, self.integral[0]))
        last = self.knots.size - 1
        place = np.clip((x - self.knots[0]) * (last / (self.knots[-1] - self.knots[0])), 0.0, last)
        cell = np.minimum(np.nan_to_num(place).astype(np.intp), last - 1)
        share = place - cell
        depth, integral = (
            np.exp((1.0 - share) * one[which, cell] + share * one[which, cell + 1])
            for one in (self.depth, self.integral)
        )
        return depth, integral


class Tables(NamedTuple):
    """Several tables in one, in units of the depth [m] and the stiffness radius [m] at their ends.

    Attributes
    ----------
    table : PathTable
        The tables.
    depth, radius : array, shape (n_table,)
        The units.
    """

    table: PathTable
    depth: Array
    radius: Array


class Rows(Geometry):
    """Geometries of the rows of a batch; depths and radii are arrays with one value for each row."""

    @property
    @abstractmethod
    def which(self) -> NDArray[np.intp]:
        """Number of the distinct geometry of each row."""

    @abstractmethod
    def raveled(self, shape: tuple[int, ...]) -> Self:
        """Return the rows broadcast to a shape and raveled."""

    @cached_property
    @abstractmethod
    def samples(self) -> Samples:
        """Depths and force integrals, at most a factor of e apart; similar geometries share them."""

    @property
    @abstractmethod
    def sampled(self) -> NDArray[np.intp]:
        """Number of the samples of each distinct geometry."""

    @abstractmethod
    def tables(self, deepest: Array, least: Array, rtol: float) -> Tables:
        """Tables of the distinct geometries.

        They reach to the depths `deepest` [m] or further; see `restitution.contact.path.path_table` for the
        smallest of the largest depths, `least` [m], and `rtol`.
        """
