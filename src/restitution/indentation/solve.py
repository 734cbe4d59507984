"""One indentation under a prescribed depth or force, solved."""

from __future__ import annotations

import math
from collections.abc import Callable
from functools import lru_cache
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from restitution.checks import finite, positive, within
from restitution.contact.profile import Profile
from restitution.indentation.exact import Solution
from restitution.indentation.history import History
from restitution.indentation.result import IndentationResult, IndentationStatus
from restitution.material.reduced_modulus import reduced_modulus
from restitution.material.viscoelastic import Material

Prescribed = History | ArrayLike | Callable[[Any], Any]

_POINTS = 401


def indent(
    material: Material,
    profile: Profile,
    *,
    depth: Prescribed | None = None,
    force: Prescribed | None = None,
    time: ArrayLike | None = None,
    counter_material: Material | None = None,
    rtol: float = 1e-8,
) -> IndentationResult:
    """Force under a prescribed depth, or depth under a prescribed force, of one indentation and its retraction.

    Parameters
    ----------
    material : Material
        Material of the half-space.
    profile : Profile
        Profile of the indenter, with scalar parameters.
    depth : History, array, callable or float
        Depth d of the tip below the undeformed surface [m], negative before touch: a `History` (`ramp`, `triangle`, `hold`,
        `sine_arch`), values at `time` joined by straight lines (the same time twice is a step), a smooth function
        that maps times to depths, or one number, which is held from the first time on.
    force : History, array, callable or float
        Normal force F >= 0 [N], in its place.
    time : array, optional
        Times [s] at which the result is given, ascending; for an array of values the times that belong to them, for a
        function also where it may have kinks. About 400 times where a `History` is given alone.
    counter_material : Material, optional
        Material of the indenter; rigid where left out.
    rtol : float
        Error of force, depth and contact radius over their largest value, and of times over the duration, in [1e-11, 1e-2].

    Returns
    -------
    IndentationResult
        The history, the end of contact, the largest force, the work.

    Raises
    ------
    ValueError
        If a number is out of its range, or if the contact grows again once it has shrunk: reloading is outside the
        theory. The message names the time.
    TypeError
        If a material or a profile is something else.

    Notes
    -----
    While the contact grows, `F = 2 int E*(t - t') dPi` (Lee and Radok 1960); while it shrinks, with t1 the instant at which
    the growing contact had the same radius, `int_t1^t E*(t - t') dd = 0` and `F = 2 int_0^t1 E*(t - t') dPi` (Ting 1966).
    Quasi-static, small strain, no adhesion, no friction.

    Examples
    --------
    A gel under an AFM tip, pressed in and pulled back at 1 um/s:

    >>> from restitution.contact.profile import Parabola
    >>> from restitution.indentation.history import triangle
    >>> from restitution.material.prony import PronySeries
    >>> gel = Material(PronySeries(200.0 / 3.0, [800.0 / 3.0], [0.3]), bulk=math.inf)
    >>> result = indent(gel, Parabola(2.5e-6), depth=triangle(1e-6, 1.0))
    >>> print(f"{result.max_force:.9g} N, contact ends at {result.contact_end_time:.6f} s")
    1.38541713e-09 N, contact ends at 1.407006 s
    """
    if not isinstance(material, Material):
        raise TypeError(f"material = {material!r}: must be a Material")
    if not isinstance(profile, Profile):
        raise TypeError(f"profile = {profile!r}: must be a Profile")
    if counter_material is not None and not isinstance(counter_material, Material):
        raise TypeError(f"counter_material = {counter_material!r}: must be a Material")
    if (depth is None) == (force is None):
        raise ValueError("depth, force: must be given one of the two")
    rtol = float(within("rtol", rtol, 1e-11, 1e-2))
    name = "force" if depth is None else "depth"
    prescribed = _history(name, force if depth is None else depth, time)
    solution = Solution(_reduced_modulus(material, counter_material), profile, prescribed, name, rtol)
    times = solution.times(_POINTS) if time is None else np.atleast_1d(finite("time", time, "s"))
    columns = solution.at(times)
    first = np.flatnonzero(times[1:] == times[:-1])
    if first.size:
        # A time that is given twice: before and behind the jump.
        for column, values in zip(columns, solution.at(times[first], before=True), strict=True):
            column[first] = values
    end = solution.end_time
    return IndentationResult(
        times, *columns, end, solution.turning_time,
        IndentationStatus.SEPARATED if math.isfinite(end) else IndentationStatus.IN_CONTACT,
        material, profile, counter_material, name, prescribed, rtol, rtol + solution.path_error, solution,
    )  # fmt: skip


# Many indentations of one material are the rule; its series connection takes longer than one of them.
_reduced_modulus = lru_cache(maxsize=32)(reduced_modulus)


def _history(name: str, prescribed: Any, time: ArrayLike | None) -> History:
    if isinstance(prescribed, History):
        return prescribed
    if isinstance(prescribed, (int, float)) and not isinstance(prescribed, bool):
        return _step(name, prescribed, time)
    if time is None:
        raise ValueError(f"time: must be given with {name} as an array or a function")
    if callable(prescribed):
        return History.from_function(prescribed, time, name=name)
    return History.from_points(time, prescribed, name=name)


def _step(name: str, value: float, time: ArrayLike | None) -> History:
    """One value, which prevails at once from the first time on."""
    value = float(positive(name, value, "m" if name == "depth" else "N"))
    if time is None:
        raise ValueError(
            f"time: must be given with {name} as a number; from its first to its last value it is held"
        )
    times = np.atleast_1d(finite("time", time, "s"))
    first, last = float(times.min()), float(times.max())
    return History.from_points([first, first, last], [0.0, value, value], name=name)
