"""The window of time in which fractional materials have to hold for an impact: that of its own contact."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from restitution.checks import nonnegative
from restitution.impact.problem import Impact
from restitution.material.fractional import Window

# Any contact lasts less than a year and more than a picosecond; only its duration is wanted.
_WIDE = Window(1e-12, 1e7, 1e-2)
# The first window is that of a solution to a per cent; a second one is all that was ever needed.
_ROUNDS = 5
# What is shorter than this share of a contact acts as a spring or a dashpot in it.
_SHORTEST = 1e-6
# A window is good for contacts as short as this share of the one that it was made for.
_MARGIN = 1e-2


def window_around(contact_time: ArrayLike, longest: float = 0.0) -> Window:
    """Times that matter to impacts: from a millionth of the contact time [s] to twice that, or to the longest.

    Examples
    --------
    >>> window_around([1e-3, 5e-3])
    Window(low=1e-09, high=0.01, rtol=0.0)
    """
    times = np.atleast_1d(np.asarray(contact_time, dtype=np.float64))
    finite = times[np.isfinite(times)]
    if not finite.size:
        # A body that never leaves has no contact time.
        return _WIDE._replace(rtol=0.0)
    high = 2.0 * float(finite.max()) if finite.size == times.size else _WIDE.high
    return Window(_SHORTEST * float(finite.min()), max(high, longest))


def for_contact(build: Callable[[Window], Impact], *, longest: float = 0.0) -> Impact:
    """Impact whose fractional materials hold over its own contact.

    Parameters
    ----------
    build : callable
        Takes a window of time and returns the impact, single or an array, of materials that hold there:
        `FractionalMaterial.within(window)`.
    longest : float
        A time [s] that has to be covered as well, such as that between two bounces.

    Returns
    -------
    Impact
        Its materials say the `window`, and in their `assumptions` the number of terms and the error.

    Raises
    ------
    TypeError
        If `build` returns something else.

    Notes
    -----
    A first solution, of materials good to a per cent at all times, tells the contact time. The window then
    reaches from a millionth of it to its double; what is slower or faster is kept by its moments.

    Examples
    --------
    >>> import restitution as rs
    >>> gel = rs.FractionalMaterial(rs.springpot(1e4, 0.2), bulk=2e9)
    >>> impact = rs.for_contact(
    ...     lambda window: rs.Impact(gel.within(window), rs.Parabola(0.01), mass=0.005, velocity=1.0)
    ... )
    >>> result = rs.solve(impact)
    >>> low, high = result.impact.material.window
    >>> print(low < 1e-5 * result.contact_time, high > result.contact_time)
    True True
    >>> print(result.impact.material.assumptions)
    34 Prony terms stand for the fractional model, relative error ...e-07
    """
    longest = float(nonnegative("longest", longest, "s"))
    touches = _contact_times(_built(build, _WIDE))
    impact: Impact | None = None
    for _ in range(_ROUNDS):
        window = window_around(touches, longest)
        impact = _built(build, window)
        touches = _contact_times(impact)
        wanted = window_around(touches)
        if window.low <= wanted.low / _MARGIN and window.high >= 0.5 * wanted.high:
            break
    assert impact is not None
    return impact


def _built(build: Callable[[Window], Impact], window: Window) -> Impact:
    impact: Any = build(window)
    if not isinstance(impact, Impact):
        raise TypeError(f"build: returned {impact!r}; must return an Impact")
    return impact


def _contact_times(impact: Impact) -> NDArray[np.float64]:
    # The solver takes 0.3 s to import.
    from restitution.impact.batch import Batch

    return Batch.from_impact(impact).solve(1e-6)["contact_time"]
