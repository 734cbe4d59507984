"""What came of a prescribed indentation."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from enum import IntEnum
from functools import cached_property
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from restitution.contact.contact import Contact
from restitution.contact.profile import Profile
from restitution.indentation.quadrature import largest, loop_work
from restitution.pictures import draw
from restitution.validity import Validity, validity

if TYPE_CHECKING:
    import xarray
    from matplotlib.figure import Figure

    from restitution.indentation.exact import Solution
    from restitution.indentation.history import History
    from restitution.material.viscoelastic import Material

Array = NDArray[np.float64]

VARIABLES = {
    "indentation_depth": ("m", "indentation depth d"),
    "velocity": ("m/s", "velocity v"),
    "force": ("N", "normal force F"),
    "contact_radius": ("m", "contact radius a"),
}


class IndentationStatus(IntEnum):
    """How an indentation ended; each member's `message` says what happened."""

    SEPARATED = 0
    IN_CONTACT = 1

    @property
    def message(self) -> str:
        """What happened."""
        return _MESSAGES[self]


_MESSAGES = {
    IndentationStatus.SEPARATED: "the contact ended within the prescribed history",
    IndentationStatus.IN_CONTACT: "the bodies were still in contact when the prescribed history ended",
}


@dataclass(frozen=True, eq=False)
class IndentationResult:
    """Indentation under a prescribed depth or force; SI units.

    Attributes
    ----------
    time : array, shape (n,)
        Times t [s] at which the columns below are given.
    indentation_depth, velocity, force, contact_radius : array, shape (n,)
        Depth d of the tip below the undeformed surface [m], its rate [m/s], normal force F [N], contact radius a [m]. At a
        jump or a kink of the history: what is behind it. After the contact F = a = 0; under a prescribed force d then is the
        imprint that recovers.
    contact_end_time : float
        Time [s] at which the contact ends; infinite where it outlasts the history.
    turning_time : float
        Time [s] at which the contact radius has become largest: from there on it stays or shrinks.
    status : IndentationStatus
        Whether the contact ended.
    material, counter_material, profile, prescribed, history_given
        The problem: `prescribed` is "depth" or "force", `history_given` the `History`.
    rtol : float
        Tolerance of depth, force and contact radius, over their largest value.
    error : float
        Stated error of the same: the tolerance, and what the table of the profile leaves where one is needed.
    """

    time: Array = field(repr=False)
    indentation_depth: Array = field(repr=False)
    velocity: Array = field(repr=False)
    force: Array = field(repr=False)
    contact_radius: Array = field(repr=False)
    contact_end_time: float
    turning_time: float
    status: IndentationStatus
    material: Material
    profile: Profile
    counter_material: Material | None
    prescribed: str
    history_given: History = field(repr=False)
    rtol: float
    error: float
    _solution: Solution = field(repr=False)

    @cached_property
    def history(self) -> xarray.Dataset:
        """History over `time`: indentation depth, velocity, force, contact radius, with units."""
        columns = (self.indentation_depth, self.velocity, self.force, self.contact_radius)
        return self._dataset(self.time, columns)

    def sample(
        self, times: ArrayLike | None = None, *, n_points: int = 401, before: bool = False
    ) -> xarray.Dataset:
        """History at other times.

        Parameters
        ----------
        times : array_like, optional
            Times [s] within the prescribed history.
        n_points : int
            Number of even times where none are given; those of the prescribed knots, of the turning and of the end of the
            contact come on top.
        before : bool
            At a kink or a jump give what is before it, not what is behind.

        Returns
        -------
        xarray.Dataset
            As `history`.

        Raises
        ------
        ValueError
            If a time lies outside the prescribed history.

        Examples
        --------
        >>> import restitution as rs
        >>> gel = rs.Material(rs.PronySeries(200.0, [800.0], [0.3]), bulk=float("inf"))
        >>> result = rs.indent(gel, rs.Parabola(2.5e-6), depth=rs.triangle(1e-6, 1.0))
        >>> print(float(result.sample([0.5]).indentation_depth[0]))
        5e-07
        """
        if n_points < 2:
            raise ValueError(f"n_points = {n_points}: must be at least 2")
        moments = self._solution.times(n_points) if times is None else np.atleast_1d(np.asarray(times, float))
        return self._dataset(moments, self._solution.at(moments, before=before))

    @cached_property
    def max_force(self) -> float:
        """Largest normal force [N], which need not be at one of the times."""
        return largest(self._solution, 2)[0]

    @cached_property
    def max_indentation_depth(self) -> float:
        """Largest depth during contact [m]."""
        return largest(self._solution, 0)[0]

    @property
    def max_contact_radius(self) -> float:
        """Largest contact radius [m]."""
        return self._solution.max_contact_radius

    @cached_property
    def residual_indentation_depth(self) -> float:
        """Depth [m] at which the contact ends: the imprint that is left, and recovers; NaN where it does not end."""
        if not math.isfinite(self.contact_end_time):
            return math.nan
        return float(self._solution.at([self.contact_end_time])[0][0])

    @cached_property
    def work(self) -> float:
        """Work [J] that the indenter did until the contact, or the history, ended."""
        return loop_work(self._solution, self.rtol)

    @property
    def dissipated_work(self) -> float:
        """Area of the loop of force over depth [J], all of which is dissipated in the end; NaN where it is not closed.

        A part of it is still stored as the contact ends, and is dissipated while the imprint recovers.
        """
        return self.work if self.status == IndentationStatus.SEPARATED else math.nan

    @cached_property
    def validity(self) -> Validity:
        """Report on the assumptions of the theory, by the largest speed and the whole duration of the history."""
        speeds = np.abs(self.velocity[np.isfinite(self.velocity)])
        return validity(
            Contact(self.material, self.profile, self.counter_material),
            max_contact_radius=self.max_contact_radius,
            max_indentation_depth=self.max_indentation_depth,
            velocity=np.max(speeds, initial=0.0),
            contact_time=min(float(self.time[-1]), self.contact_end_time),
        )

    @property
    def warnings(self) -> list[str]:
        """Where the assumptions of the theory are doubtful, with the numbers."""
        return self.validity.warnings

    def plot(self) -> Figure:
        """Figure of the indentation: force, depth and contact radius over time, force over depth."""
        return draw("indentation", self)

    def to_dict(self) -> dict[str, Any]:
        """Plain numbers by name, SI."""
        names = (
            "contact_end_time", "turning_time", "max_force", "max_indentation_depth", "max_contact_radius",
            "residual_indentation_depth", "work", "dissipated_work", "status", "prescribed", "rtol", "error", "warnings",
        )  # fmt: skip
        return {name: getattr(self, name) for name in names} | {"validity": self.validity.to_dict()}

    def _dataset(self, times: Array, columns: tuple[Array, ...]) -> xarray.Dataset:
        import xarray as xr

        data = {
            name: ("time", values, {"units": unit, "long_name": long_name})
            for (name, (unit, long_name)), values in zip(VARIABLES.items(), columns, strict=True)
        }
        time = ("time", times, {"units": "s", "long_name": "time t"})
        return xr.Dataset(
            data, coords={"time": time}, attrs={"prescribed": self.prescribed, "rtol": self.rtol}
        )
