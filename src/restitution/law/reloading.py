"""Independent elements under a prescribed depth, which the body may touch again: what the contact law converges to."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

from restitution.checks import finite, whole
from restitution.contact.profile import as_profile
from restitution.errors import InputError
from restitution.impact.elements import element_law
from restitution.impact.problem import Impact


def element_forces(impact: Impact, time: ArrayLike, depth: ArrayLike, *, n_elements: int = 800) -> NDArray[np.float64]:
    """Force of the elements of `method="elements"` under a prescribed depth.

    Parameters
    ----------
    impact : Impact
        Its materials and its profile define the elements, as in `contact_law`.
    time : array
        Times [s] after 0, ascending, shape ``(n,)``.
    depth : array
        Depths [m] at these times, negative for a gap, shape ``(n,)``; the depth at time 0 is 0.
    n_elements : int
        Number of elements across the contact at the largest depth.

    Returns
    -------
    array
        Normal force [N] at the times, shape ``(n,)``.

    Raises
    ------
    InputError
        If the body is no profile on a half-space, the times do not ascend, a number is out of range, or a step is
        longer than the shortest relaxation time, as explicit Euler is then unstable.

    Notes
    -----
    An element that would pull is free: its surface creeps back without load, and the body may touch it again. It then
    has the memory of all that it went through. This is an MDR approximation: in a half-space the elements are not
    independent once the contact grows again. The error is of first order in the step and in `n_elements`.

    Examples
    --------
    >>> import restitution as rs
    >>> rubber = rs.standard_solid(1e6, 1e7, 1e3, poisson_ratio=0.45)
    >>> impact = rs.Impact(rubber, rs.Parabola(0.01), mass=0.005, velocity=1.0)
    >>> time = np.linspace(0.0, 4e-3, 4001)[1:]
    >>> force = element_forces(impact, time, 1e-4 * np.sin(np.pi * time / 2e-3) ** 2)
    >>> first, second = (float(half.max()) for half in np.split(force, 2))
    >>> second < first
    True
    """
    times, depths = (np.atleast_1d(finite(name, one)) for name, one in (("time", time), ("depth", depth)))
    steps = np.diff(times, prepend=0.0)
    if times.ndim != 1 or times.shape != depths.shape or not np.all(steps > 0.0):
        raise InputError("time, depth", wanted="must be of one length, with times that ascend from above 0")
    series, profile = impact.reduced_modulus, as_profile(impact.profile, "element_forces")
    longest = float(series.relaxation_times.min(initial=np.inf))
    if steps.max() > longest:
        raise InputError("time", float(steps.max()), f"must have steps of at most {longest:g} s", "s")
    count = (whole("n_elements", n_elements, 2) + 1) // 2
    spacing = float(profile.contact_radius(max(float(depths.max()), 0.0))) / count
    g, u = profile.transform((np.arange(count) + 0.5) * spacing), np.zeros(count)
    law = element_law(impact.material, impact.counter_material, series)
    law.grow(count)
    force, before = np.empty(times.size), 0.0
    for n, (d, step) in enumerate(zip(depths.tolist(), steps.tolist(), strict=True)):
        growth = d - g - u
        u += growth
        law.advance(u, growth, step)
        load = law.line_load(u, growth / step)
        u += law.release(load, step)
        # A dashpot that was touched within the step has the velocity of the body at its end.
        later = series.parallel_viscosity * (d - before - growth) / step
        force[n] = 2.0 * spacing * float((load + later)[load > 0.0].sum())
        before = d
    return force
