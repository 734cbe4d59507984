"""Force law: a geometry given by its elastic force over the depth, computed or measured."""

from __future__ import annotations

import warnings
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Annotated, Any, Self

import numpy as np
from numpy.typing import ArrayLike

from restitution.checks import finite, single, within
from restitution.contact.force_law.fit import ForceFit, fit_force
from restitution.contact.geometry import Array, Geometry, as_array
from restitution.errors import InputError, RestitutionWarning
from restitution.pictures import draw
from restitution.quantities import CONSTANTS, FORCE, INPUTS, LENGTH, NUMBER, Quantity

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from restitution.material.viscoelastic import Material

_EXPONENT = Quantity("exponent", NUMBER, "exponent of the force at small depth", "$p$", 1.0, 10.0)
_FEWEST = 10
# The least depth over the largest: below the least one the fit extrapolates.
_FIRST = 0.25
# A force of any depth over that of the largest depth.
_MOST_FORCE = 2.0
# Force at no depth, and misfit, over the largest force; residuals of outliers over their median.
_MOST_OFFSET, _MOST_MISFIT, _OUTLIER = 0.01, 0.01, 20.0
# Limits of the depth over the stiffness radius, beyond which a unit is wrong.
_SHALLOW, _DEEP = 1e-9, 30.0
# Difference of Poisson ratios that does not matter.
_SAME_RATIO = 0.005


@dataclass(frozen=True, eq=False)
class ForceLaw(Geometry, case_name="force_law"):
    """Elastic force over depth, from finite elements, boundary elements or a measurement on an elastic twin.

    The twin has the shape and the fixings of the real body and target, and is elastic. Any body on any target has such
    a law: a disc of finite width, a body with an edge, a layer on a layer of the same material.

    Parameters
    ----------
    depth : array
        Depths d [m] from first touch, >= 0, in any order, shape (n,) with n >= 10. The least is at most a quarter of
        the largest.
    force : array
        Forces F [N] of the twin at these depths, shape (n,).
    modulus : float
        Young's modulus E [Pa] of the twin, > 0.
    poisson_ratio : float
        Poisson ratio of the twin, in (-1, 0.5]: that of the real material.
    exponent : float, optional
        Exponent p of the force at small depth, ``F ~ d^p``, >= 1: 1 for a flat face, 1.5 for a round and 2 for a sharp
        tip. It is found from the data if left out.

    Attributes
    ----------
    fit : ForceFit
        The fit, with its `exponent`, `degree`, `residual`, `misfit` and `error`, the standard error of the force.

    Raises
    ------
    InputError
        If a value is not a finite number, the columns differ in length, few rows are given or a gap is large, the
        stiffness of the fit is not positive or falls, the data are too noisy, or a unit is likely to be wrong.

    Notes
    -----
    The stiffness radius ``a = (dF/dd)/(2 E*)`` with ``E* = E/(1 - nu^2)`` is the derivative of a smooth fit: Chebyshev
    polynomials of ``F/d^p`` in sqrt(d), whose degree follows from cross-validation. The impact of one viscoelastic
    body follows exactly if its contact area grows with the depth and its Poisson ratio is constant in time and that of
    the twin; on a half-space and on a layer with a frictionless base the Poisson ratio does not matter. Another one is
    a warning. The contact radius and the pressure are not known. An impact deeper than the data is refused; one of
    several ends with `Status.TOO_DEEP`.

    Examples
    --------
    >>> import numpy as np
    >>> d = np.linspace(1e-5, 1e-3, 40)
    >>> law = ForceLaw(d, 4 / 3 * 1e6 / 0.75 * np.sqrt(0.01) * d**1.5, modulus=1e6, poisson_ratio=0.5)
    >>> print(law.fit.exponent, law.fit.degree, float(law.stiffness_radius(1e-4).round(9)))
    1.5 0 0.001
    """

    end = "where the data end"
    obstacle = "the contact area of a force law is not known"

    depth: Annotated[Array, Quantity("depth", LENGTH, "depths of an elastic twin", "$d$", 0.0)]
    force: Annotated[Array, Quantity("force", FORCE, "elastic forces at the depths", "$F$")]
    modulus: Annotated[float, CONSTANTS["youngs_modulus"]]
    poisson_ratio: Annotated[float, INPUTS["poisson_ratio"]]
    exponent: Annotated[float | None, _EXPONENT] = None
    fit: ForceFit = field(init=False, repr=False, compare=False)

    def __post_init__(self) -> None:
        depth, force = _columns(self.depth, self.force)
        modulus = single("modulus", CONSTANTS["youngs_modulus"].check(self.modulus, "modulus"), "Pa")
        within("modulus", modulus, 1e-100, 1e100, "Pa")  # its quotients with forces do not overflow
        ratio = single("poisson_ratio", INPUTS["poisson_ratio"].check(self.poisson_ratio))
        if ratio == -1.0:
            raise InputError("poisson_ratio", ratio, "must be in (-1, 0.5]")
        given = {"depth": depth, "force": force, "modulus": modulus, "poisson_ratio": ratio}
        for name, value in given.items():
            object.__setattr__(self, name, value)
        if self.exponent is not None:
            object.__setattr__(self, "exponent", single("exponent", _EXPONENT.check(self.exponent)))
        rows = np.flatnonzero(depth > 0.0)
        fit = fit_force(depth[rows], force[rows], self.exponent)
        object.__setattr__(self, "fit", fit)
        _check_fit(fit, depth, force, rows)
        shape = fit.depth_unit / float(self.stiffness_radius(fit.depth_unit))
        if not _SHALLOW < shape < _DEEP:
            wanted = "is the depth over the stiffness radius F'/(2 E*): compare the units of depth, force and modulus"
            raise InputError("depth, force, modulus", shape, wanted)

    def between(self, material: Material, counter_material: Material | None) -> Self:
        """Return the law itself; refuse a second body that deforms, and warn of another Poisson ratio."""
        if counter_material is not None:
            raise InputError("counter_material", wanted="must be left out: a force law is that of one deformable body")
        ratios = material.poisson_ratio, material.instantaneous_poisson_ratio
        if max(abs(ratio - self.poisson_ratio) for ratio in ratios) > _SAME_RATIO:
            text = f"force law: the Poisson ratio is {self.poisson_ratio:.4g} for the twin and {ratios[0]:.4g} "
            text += f"(static) to {ratios[1]:.4g} (instantaneous) for the material; exact on a half-space or a "
            text += "frictionless layer alone"
            warnings.warn(RestitutionWarning("force_law", text), stacklevel=2)
        return self

    @property
    def reduced_modulus(self) -> float:
        """Reduced modulus E* = E/(1 - nu^2) [Pa] of the twin."""
        return self.modulus / (1.0 - self.poisson_ratio**2)

    @property
    def max_depth(self) -> float:
        """Largest depth [m] of the data."""
        return self.fit.depth_unit

    def stiffness_radius(self, depth: ArrayLike) -> Array:
        """Stiffness radius (dF/dd)/(2 E*) [m] of the fit; 0 where d < 0."""
        depth, unit = as_array(depth), self.fit.force_unit / self.fit.depth_unit / (2.0 * self.reduced_modulus)
        return np.where(depth >= 0.0, unit * self.fit.stiffness(self._place(depth)), 0.0)[()]

    def force_integral_at_depth(self, depth: ArrayLike) -> Array:
        """Force integral F/(2 E*) [m^2] of the fit."""
        return self.fit.force_unit / (2.0 * self.reduced_modulus) * self.fit.force(self._place(as_array(depth)))

    def contact_radius(self, depth: ArrayLike) -> Array:
        """NaN: the contact radius is not known."""
        return np.full_like(as_array(depth), np.nan)[()]

    def plot(self) -> Figure:
        """Return a picture of the forces with their fit, and of the residuals."""
        return draw("force_law.force_law", self)

    def _place(self, depth: Array) -> Array:
        """Return sqrt(d/d_1) for depths that the data cover."""
        if np.any(depth > self.max_depth):
            wanted = f"must be <= {self.max_depth:g} m, {self.end}"
            raise InputError("depth", float(np.max(depth)), wanted, "m")
        return np.sqrt(np.maximum(depth, 0.0) / self.max_depth)


def _columns(depth: Any, force: Any) -> tuple[Array, Array]:
    """Return checked columns of depths and forces, in the order of the rows."""
    d, f = np.asarray(finite("depth", depth, "m")), np.asarray(finite("force", force, "N"))
    if d.ndim != 1 or d.shape != f.shape:
        raise InputError(
            "depth, force", wanted=f"have shapes {d.shape}, {f.shape}: must be two columns of equal length"
        )
    if np.any(d < 0.0):
        row = int(np.argmax(d < 0.0))
        raise InputError("depth", float(d[row]), "must be >= 0: depths count from first touch", "m", index=(row,))
    distinct = np.unique(d[d > 0.0]).size
    if distinct < _FEWEST:
        raise InputError("depth", wanted=f"has {distinct} different depths > 0: must be at least {_FEWEST}")
    for name, values, unit in (("depth", d, "m"), ("force", f, "N")):
        size = float(np.max(np.abs(values)))
        if not 1e-100 <= size <= 1e100:
            raise InputError(name, size, f"is the largest: must be in [1e-100, 1e+100] {unit}", unit)
    deepest = int(np.argmax(d))
    if f[deepest] <= 0.0:
        raise InputError(
            "force",
            float(f[deepest]),
            "must be > 0 in indentation; a compression counts positive",
            "N",
            index=(deepest,),
        )
    strange = np.abs(f) > _MOST_FORCE * f[deepest]
    if np.any(strange):
        row = int(np.argmax(strange))
        wanted = f"is beyond the force at the largest depth, {f[deepest]:g} N: an elastic force rises with the depth"
        raise InputError("force", float(f[row]), wanted, "N", index=(row,))
    first = float(d[d > 0.0].min())
    if first > _FIRST * d[deepest]:
        wanted = f"is the least of the depths: must be at most {_FIRST:g} times the largest, {d[deepest]:g} m"
        raise InputError("depth", first, wanted, "m")
    offset = (d == 0.0) & (np.abs(f) > _MOST_OFFSET * f[deepest])
    if np.any(offset):
        row = int(np.argmax(offset))
        raise InputError("force", float(f[row]), "must be 0 at depth 0", "N", index=(row,))
    return d, f


def _check_fit(fit: ForceFit, depth: Array, force: Array, rows: Any) -> None:
    """Refuse data whose fit is no contact, at the row where this shows."""
    size = np.abs(fit.residual)
    worst = int(np.argmax(size))
    row = int(rows[worst])
    if fit.misfit > _MOST_MISFIT or size[worst] > max(_MOST_MISFIT, _OUTLIER * float(np.median(size))):
        place = f"at depth {depth[row]:g} m is {100.0 * size[worst]:.2g} % of the largest force off a smooth curve"
        wanted = f"{place}, all rows by {100.0 * fit.misfit:.2g} %: must be smooth; correct or leave out such rows"
        raise InputError("force", float(force[row]), wanted, "N", index=(row,))
    falls = fit.falls_at()
    if falls is not None:
        place = falls**2 * fit.depth_unit
        row = int(rows[np.argmin(np.abs(depth[rows] - place))])
        wanted = f"the stiffness dF/dd must be positive and never fall, and does not near depth {place:.3g} m; "
        wanted += "smooth the data, leave out what is not elastic, and count depths from first touch"
        raise InputError("force", float(force[row]), wanted, "N", index=(row,))
