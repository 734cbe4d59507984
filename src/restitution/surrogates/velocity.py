"""Restitution coefficient, contact time and peak force of one impact over its velocity, as interpolants."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from importlib.metadata import version
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from restitution.checks import finite, positive, within
from restitution.pictures import draw
from restitution.surrogates.pieces import DEEPEST, Pieces
from restitution.validity import Validity

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from restitution.surrogates.lookup import Table

Array = NDArray[np.float64]

OUTPUTS = {"restitution_coefficient": "1", "contact_time": "s", "max_force": "N"}
"""What a surrogate gives, and the units."""

_FORMAT = "restitution surrogate over velocity"
_FORMAT_VERSION = 2


@dataclass(frozen=True, eq=False)
class Surrogate:
    """What comes of an impact as a function of its velocity, by interpolation; made by `surrogate`.

    Called with a velocity or an array of them [m/s], it returns the restitution coefficient.

    Attributes
    ----------
    velocity : tuple of float
        Range of the impact velocity v0 [m/s].
    rtol : float
        Tolerance that it was built for.
    error : dict of str to float
        Largest error measured of each output: of e relative to max(e, 1e-3), of the others relative.
    validity : Validity
        Report on the assumptions of the theory: the worst of each within the range.
    problem : dict
        What was solved, as plain numbers and text.
    pieces : Pieces
        Logarithms of the outputs as Chebyshev series over the logarithm of the velocity, piece by piece.

    Notes
    -----
    The errors are measured against the exact method at velocities that made no interpolant: those half-way between
    the ones that did, and 32 random ones for each piece. All were solved ten thousand times as accurately as is
    asked for here, down to 1e-12; that tolerance is added to what was measured.
    """

    velocity: tuple[float, float]
    rtol: float
    error: dict[str, float]
    validity: Validity
    problem: dict[str, Any] = field(repr=False)
    pieces: Pieces = field(repr=False)

    @property
    def warnings(self) -> list[str]:
        """Where the assumptions of the theory are doubtful within the range, with numbers."""
        return self.validity.warnings

    def __call__(self, velocity: Any) -> Any:
        """Restitution coefficient e at a velocity or an array of them [m/s]."""
        return self.restitution_coefficient(velocity)

    def restitution_coefficient(self, velocity: Any) -> Any:
        """Restitution coefficient e [-].

        Parameters
        ----------
        velocity : float or array
            v0 [m/s], within the range.

        Raises
        ------
        ValueError
            If a velocity is out of range; nothing is extrapolated.
        """
        return self._evaluate("restitution_coefficient", velocity)

    def contact_time(self, velocity: Any) -> Any:
        """Contact time T [s]; see `restitution_coefficient`."""
        return self._evaluate("contact_time", velocity)

    def max_force(self, velocity: Any) -> Any:
        """Largest normal force F [N]; see `restitution_coefficient`."""
        return self._evaluate("max_force", velocity)

    def compiled(self, output: str = "restitution_coefficient") -> Any:
        """Output as a function compiled by numba, for one velocity [m/s], to be called in other compiled code.

        Parameters
        ----------
        output : {"restitution_coefficient", "contact_time", "max_force"}
            Which.

        Returns
        -------
        function
            float64 to float64; usable within `numba.njit` and `numba.cfunc`. Out of range it returns NaN, for compiled
            code called from C has no exceptions.

        Examples
        --------
        >>> import numba
        >>> import restitution as rs
        >>> solid = rs.standard_solid(1e6, 1e7, 1e3, poisson_ratio=0.45)
        >>> ball = rs.Impact(solid, rs.Parabola(0.01), mass=0.005, velocity=1.0)
        >>> e = rs.surrogate(ball, velocity=(0.1, 1.0), rtol=1e-4).compiled()
        >>> rebound = numba.cfunc("float64(float64)")(lambda v: -e(v) * v)
        >>> print(round(rebound.ctypes(0.5), 3))
        -0.171
        """
        from restitution.surrogates.lookup import scalar_function

        return scalar_function(self._table(output))

    def plot(self, outputs: Sequence[str] = (), *, ax: Axes | None = None) -> Figure:
        """Figure of the outputs over the velocity.

        Parameters
        ----------
        outputs : sequence of str
            Which outputs, such as `["restitution_coefficient"]`; all if left out.
        ax : matplotlib.axes.Axes, optional
            Where to draw one output, the first if none is named; a new figure if left out.
        """
        return draw("sweep", self.sample(), outputs, ax=ax)

    def sample(self, n: int = 400) -> xr.Dataset:
        """Outputs at n velocities from one end of the range to the other, as the Dataset of a sweep.

        Parameters
        ----------
        n : int
            Number of velocities, spaced by ratios.

        Examples
        --------
        >>> import restitution as rs
        >>> solid = rs.standard_solid(1e6, 1e7, 1e3, poisson_ratio=0.45)
        >>> ball = rs.Impact(solid, rs.Parabola(0.01), mass=0.005, velocity=1.0)
        >>> dict(rs.surrogate(ball, velocity=(0.1, 1.0)).sample(50).sizes)
        {'velocity': 50}
        """
        import xarray as xr

        from restitution.sweeps.schema import OUTPUTS as VARIABLES
        from restitution.sweeps.schema import input_variable

        speeds = np.clip(np.geomspace(*self.velocity, n), *self.velocity)
        attributes = input_variable("velocity").attributes | {"scale": "logarithmic"}
        return xr.Dataset(
            {
                name: ("velocity", self._evaluate(name, speeds), VARIABLES[name].attributes)
                for name in OUTPUTS
            },
            {"velocity": ("velocity", speeds, attributes)},
        )

    def save(self, path: str | Path) -> Path:
        """Write a JSON file, whole or not at all.

        Parameters
        ----------
        path : path-like
            The file; replaced if it exists.

        Returns
        -------
        pathlib.Path
            `path`.
        """
        from restitution.files import whole_file

        content = {
            "format": _FORMAT,
            "format_version": _FORMAT_VERSION,
            "version": version("restitution"),
            "rtol": self.rtol,
            "velocity": list(self.velocity),
            "error": self.error,
            "units": {"velocity": "m/s", **OUTPUTS},
            "validity": self.validity.to_dict(),
            "problem": self.problem,
            "log_velocity_edges": self.pieces.edges.tolist(),
            "chebyshev_coefficients_of_log": {
                name: part.tolist() for name, part in zip(OUTPUTS, self.pieces.coefficients, strict=True)
            },
        }
        with whole_file(path) as partial:
            partial.write_text(json.dumps(content, indent=1, allow_nan=False) + "\n", encoding="utf-8")
        return Path(path)

    @classmethod
    def load(cls, path: str | Path) -> Surrogate:
        """Surrogate from a file that `save` wrote; the same to the last bit.

        Parameters
        ----------
        path : path-like
            The file.

        Raises
        ------
        ValueError
            If it holds something else: one line that says what.
        OSError
            If it cannot be read.
        """
        try:
            content = json.loads(Path(path).read_text(encoding="utf-8"))
        except ValueError:
            raise ValueError(f"{path}: is not a JSON file") from None
        if not isinstance(content, Mapping) or content.get("format") != _FORMAT:
            raise ValueError(f"{path}: is not a {_FORMAT}")
        if content.get("format_version") != _FORMAT_VERSION:
            raise ValueError(
                f"{path}: format_version = {content.get('format_version')!r}: must be {_FORMAT_VERSION}; "
                f"it was written by version {content.get('version')} of restitution"
            )
        try:
            coefficients = content["chebyshev_coefficients_of_log"]
            pieces = Pieces(
                np.asarray(finite("log_velocity_edges", content["log_velocity_edges"])),
                np.asarray(finite("coefficients", [coefficients[name] for name in OUTPUTS])),
            )
            _check(pieces)
            error = {name: float(content["error"][name]) for name in OUTPUTS}
            validity = Validity.from_dict(content["validity"])
            velocity, rtol = velocity_range(content["velocity"]), float(content["rtol"])
            return cls(velocity, rtol, error, validity, dict(content["problem"]), pieces)
        except (KeyError, TypeError, ValueError) as error:
            what = f"{error} is missing" if isinstance(error, KeyError) else str(error)
            raise ValueError(f"{path}: {what}") from None

    @cached_property
    def _tables(self) -> dict[str, Table]:
        from restitution.surrogates.lookup import table

        most = {"restitution_coefficient": 1.0}
        return {
            name: table(self.pieces, n, *self.velocity, most.get(name, np.inf))
            for n, name in enumerate(OUTPUTS)
        }

    def _table(self, output: str) -> Table:
        if output not in OUTPUTS:
            raise ValueError(f"output = {output!r}: must be one of {', '.join(OUTPUTS)}")
        return self._tables[output]

    def _evaluate(self, output: str, velocity: Any) -> Any:
        from restitution.surrogates.lookup import value, values

        checked = within("velocity", velocity, *self.velocity, "m/s")
        one = self._table(output)
        if not isinstance(checked, np.ndarray):
            return value(float(checked), *one)
        out = np.empty(checked.shape)
        values(checked.reshape(-1), out.reshape(-1), *one)
        return out


def velocity_range(velocity: Any) -> tuple[float, float]:
    """Return the ends of a range of velocities [m/s], checked."""
    checked = np.asarray(positive("velocity", velocity, "m/s"))
    if checked.shape != (2,) or checked[0] >= checked[1]:
        raise ValueError(f"velocity = {velocity!r}: must be the lowest and the highest, in this order")
    return float(checked[0]), float(checked[1])


def _check(pieces: Pieces) -> None:
    """Raise where the edges are not those of an interval that was halved again and again."""
    widths = np.diff(pieces.edges)
    if (
        pieces.coefficients.shape[:2] != (len(OUTPUTS), widths.size)
        or widths.size == 0
        or widths.min() <= 0.0
    ):
        raise ValueError("log_velocity_edges: must increase, and fit the coefficients")
    halvings = np.log2((pieces.edges[-1] - pieces.edges[0]) / widths)
    places = (pieces.edges[:-1] - pieces.edges[0]) / widths
    if (
        any(np.abs(x - np.round(x)).max() > 1e-6 for x in (halvings, places))
        or halvings.max() > DEEPEST + 0.5
    ):
        raise ValueError("log_velocity_edges: must be those of an interval halved again and again")
