"""The paper's restitution coefficient by interpolation, for pictures that follow the mouse."""

from __future__ import annotations

from functools import cache
from importlib.resources import as_file, files
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike

from restitution.checks import within

if TYPE_CHECKING:
    from restitution.surrogates.plane import Grid

STATED_ERROR = 1e-6
"""What the error of e does not exceed."""

# Powers of ten at the ends of the plane may be off by rounding.
_SLACK = 1e-12


def standard_solid_surrogate(nu: ArrayLike, p2: ArrayLike, p3: ArrayLike) -> Any:
    """Restitution coefficient e(p1, p2, p3) of a rigid sphere on a compressible standard solid, by interpolation.

    The same as `standard_solid_restitution` to an absolute error of 1e-6, over the plane of the paper's figures and
    for all Poisson ratios, in some 0.1 us a point.

    Parameters
    ----------
    nu : array_like
        p1, static Poisson ratio, in [-1, 0.5]; 0.5 means incompressible.
    p2 : array_like
        Equilibrium over branch modulus, Ginf/G1, in [1e-3, 10].
    p3 : array_like
        `eta (v0 R/(m^2 Ginf^3))^(1/5)`, in [1e-2, 100].

    Returns
    -------
    float or ndarray
        e, in the common shape of the three.

    Raises
    ------
    ValueError
        If a number is out of range; nothing is extrapolated.

    Notes
    -----
    Tensor Chebyshev series in boxes, in the coordinates of `restitution.surrogates.plane`; their data come with the
    package and are made by `restitution.surrogates.make`. The error was measured at 200 000 random points.

    Examples
    --------
    >>> print(round(standard_solid_surrogate(0.49, 1e-3, 10.0), 5))
    0.21971
    """
    from restitution.surrogates.plane import P2, P3, restitution

    given = (
        within("nu", nu, -1.0, 0.5),
        within("p2", p2, P2[0] * (1.0 - _SLACK), P2[1] * (1.0 + _SLACK)),
        within("p3", p3, P3[0] * (1.0 - _SLACK), P3[1] * (1.0 + _SLACK)),
    )
    shapes = [np.shape(one) for one in given]
    try:
        shape = np.broadcast_shapes(*shapes)
    except ValueError:
        raise ValueError(f"nu, p2, p3: shapes {shapes} must broadcast against each other") from None
    columns = [np.broadcast_to(one, shape).reshape(-1) for one in given]
    e = np.empty(columns[0].size)
    restitution(*columns, *_grid(), e)
    return e.reshape(shape) if shape else float(e[0])


@cache
def _grid() -> Grid:
    from restitution.surrogates.boxes import Boxes
    from restitution.surrogates.plane import corners, ready

    with (
        as_file(files("restitution.surrogates") / "data" / "standard_solid.npz") as path,
        np.load(path) as data,
    ):
        levels, places = data["levels"].astype(np.int64), data["places"].astype(np.int64)
        return ready(Boxes(*corners(), levels, places, data["coefficients"]))
