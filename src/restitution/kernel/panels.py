"""Memory of elements: panels of elements that follow the body, and panels of elements that are loaded.

An element is named by `s = y^2`, the depth at which the undeformed surface touches it. One that follows the body has
its displacement u = d - y^2 and the loads l_k of its branches; a free one has the displacement W = sum_j w_j, whose
parts decay at the retardation rates r_j. A panel holds what elements had when they changed state, as polynomials in
the coordinate z of the step in which they did so, and the instant of the change; what they have later follows exactly:

    following:  l_k(t) = exp(-rho_k (t - t_z)) g_k(z) + E_k h_k(t),   g_k = l_k(t_z) - E_k h_k(t_z)
                L_k(t) = exp(-rho_k (t - t_z)) G_k(z) + E_k h_k(t) a(y),   the integral of l_k da from the axis to z
    free:       w_j(t) = exp(-r_j (t - t_z)) w_j(z)

with h_k(t) = int exp(-rho_k (t - t')) dd, which is the same for all. Fast modes therefore need no fine panels. The
changes of state are those of docs/development/decisions/histories.md: with E*(-r_j) = 0, S_j = r_j E*'(-r_j) and
theta_jk = r_j/(r_j - rho_k),

    leaving:   w_j = (Einf u + sum_k theta_jk l_k)/S_j          touching:   l_k = E_k sum_j theta_jk w_j

Panels lie in two stacks, whose tops meet at the edge of the contact: following ones from the axis outwards, free ones
from the edge outwards. z runs towards the edge in both.
"""

import math
from functools import cache
from typing import Any, NamedTuple

import numpy as np
from numpy.polynomial import chebyshev

from restitution.checks import Array
from restitution.kernel.collocation import radau
from restitution.kernel.compile import compiled, inlined
from restitution.kernel.references import by_reference

STAGES = 10
NODES = STAGES + 1
# How a panel joins the next lower one: smoothly, at a kink, at a smooth turning (where dy/dz = 0), at a kink of the
# profile.
SMOOTH, KINK, FLAT, CORNER = range(4)
# Maps from z to the share of a step: z^n for n > 0, nothing passes for 0, 1 - (1 - z)^-n for n < 0.
FROZEN, BACKWARD = 0, -2
# exp of less is zero.
FORGOTTEN = -700.0


@by_reference
class Solid(NamedTuple):
    """Relaxation modulus E*(t) = equilibrium + viscosity delta(t) + sum moduli_k exp(-rates_k t), and its inverse."""

    equilibrium: float
    viscosity: float
    moduli: Any  # (K,)
    rates: Any  # (K,): rho_k
    glass: float  # equilibrium + sum moduli_k
    recoveries: Any  # (J,): r_j, 0 for flow
    displacement: Any  # (J,): share of u in w_j on leaving, equilibrium/S_j; 1 for flow
    loads: Any  # (J, K): share of l_k in w_j on leaving, theta_jk/S_j
    moduli_of: Any  # (K, J): share of w_j in l_k on touching, E_k theta_jk


@by_reference
class Scheme(NamedTuple):
    """Radau IIA collocation on the nodes of a step, and Chebyshev polynomials in z through them and z = 0."""

    c: Array  # (N,): zero and the nodes
    A: Array  # (S, S): Butcher matrix
    derivative: Array  # (N, N): values to slopes at c
    coefficients: Array  # (N, N): values at c to Chebyshev coefficients
    smooth: Array  # (N, N): values at c to those of a polynomial whose square has no higher degree than a panel


@cache
def scheme() -> Scheme:
    """Return the coefficients of a step."""
    method = radau(STAGES)
    coefficients: Array = np.linalg.inv(chebyshev.chebvander(2.0 * method.c - 1.0, STAGES)).astype(np.float64)
    # Of degree N/2, with the same values at the ends.
    c, inner = method.c, STAGES // 2 - 2
    line = np.outer(1.0 - c, np.eye(NODES)[0]) + np.outer(c, np.eye(NODES)[-1])
    rest = (c * (1.0 - c))[:, None] * chebyshev.chebvander(2.0 * c - 1.0, inner)
    smooth: Array = (line + rest @ np.linalg.pinv(rest) @ (np.eye(NODES) - line)).astype(np.float64)
    return Scheme(method.c, method.A, method.derivative, coefficients, smooth)


@by_reference
class Stack(NamedTuple):
    """Panels, the lowest first; row 0 of the coefficients is y, then g_k and G_k, or w_j."""

    coefficients: Any  # (P, Q, N): of Chebyshev polynomials
    start: Any  # (P,): time at z = 0
    length: Any  # (P,): of the step
    kind: Any  # (P,): map of the step
    end: Any  # (P,): largest z that is left
    joint: Any  # (P,): how it joins the next lower panel at z = 0


def stack(panels: int, quantities: int) -> Stack:
    """Return room for a number of panels."""
    whole = np.int64
    return Stack(
        np.zeros((panels, quantities, NODES)), np.zeros(panels), np.zeros(panels), np.zeros(panels, dtype=whole),
        np.zeros(panels), np.zeros(panels, dtype=whole),
    )  # fmt: skip


@inlined
def share(kind: int, z: float) -> tuple[float, float]:
    """Share of a step at z, and its slope."""
    if kind == 1:
        return z, 1.0
    if kind == FROZEN:
        return 0.0, 0.0
    if kind < 0:
        power = (1.0 - z) ** (-kind - 1)
        return 1.0 - power * (1.0 - z), -kind * power
    power = z ** (kind - 1)
    return power * z, kind * power


@inlined
def polynomials(z: float, basis: Any, slopes: Any) -> None:
    """Write the Chebyshev polynomials at z, and their slopes."""
    x = 2.0 * z - 1.0
    basis[0], basis[1] = 1.0, x
    slopes[0], slopes[1] = 0.0, 2.0
    for n in range(2, NODES):
        basis[n] = 2.0 * x * basis[n - 1] - basis[n - 2]
        slopes[n] = 4.0 * basis[n - 1] + 2.0 * x * slopes[n - 1] - slopes[n - 2]


@inlined
def value_of(row: Any, basis: Any) -> float:
    """Return the value of a polynomial."""
    value = 0.0
    for n in range(NODES):
        value += row[n] * basis[n]
    return value


@compiled
def load(
    solid: Solid, panels: Stack, p: int, z: float, t: float, drive: float, basis: Any, slopes: Any
) -> tuple[float, float, float, float]:
    """Line load q, its slope over z, and the same of y, at z of a following panel.

    `drive` is what all elements share: Einf d + eta d' + sum E_k h_k.
    """
    polynomials(z, basis, slopes)
    row = panels.coefficients[p]
    y, rise = value_of(row[0], basis), value_of(row[0], slopes)
    passed, pace = share(panels.kind[p], z)
    elapsed, pace = t - panels.start[p] - panels.length[p] * passed, panels.length[p] * pace
    q, slope = drive - solid.equilibrium * y * y, -2.0 * solid.equilibrium * y * rise
    for k in range(solid.rates.shape[0]):
        rho = solid.rates[k]
        if -rho * elapsed < FORGOTTEN:
            continue
        decay = math.exp(-rho * elapsed)
        g = value_of(row[1 + k], basis)
        q += decay * g
        slope += decay * (value_of(row[1 + k], slopes) + rho * pace * g)
    return q, slope, y, rise


@compiled
def gap(
    solid: Solid, panels: Stack, p: int, z: float, t: float, depth: float, basis: Any, slopes: Any
) -> tuple[float, float, float, float]:
    """Return the gap y^2 + W - d, its slope over z, and the same of y, at z of a free panel."""
    polynomials(z, basis, slopes)
    row = panels.coefficients[p]
    y, rise = value_of(row[0], basis), value_of(row[0], slopes)
    passed, pace = share(panels.kind[p], z)
    elapsed, pace = t - panels.start[p] - panels.length[p] * passed, panels.length[p] * pace
    value, slope = y * y - depth, 2.0 * y * rise
    for j in range(solid.recoveries.shape[0]):
        r = solid.recoveries[j]
        if -r * elapsed < FORGOTTEN:
            continue
        decay = math.exp(-r * elapsed)
        w = value_of(row[1 + j], basis)
        value += decay * w
        slope += decay * (value_of(row[1 + j], slopes) + r * pace * w)
    return value, slope, y, rise


@compiled
def write_loads(solid: Solid, panels: Stack, p: int, z: float, t: float, h: Any, radius: float, parts: Any,
                sums: Any, basis: Any, slopes: Any) -> None:  # fmt: skip
    """Write l_k and L_k at z of a following panel; `h` are the h_k now."""
    polynomials(z, basis, slopes)
    row = panels.coefficients[p]
    elapsed = t - panels.start[p] - panels.length[p] * share(panels.kind[p], z)[0]
    K = solid.rates.shape[0]
    for k in range(K):
        decay = math.exp(max(-solid.rates[k] * elapsed, FORGOTTEN))
        common = solid.moduli[k] * h[k]
        parts[k] = decay * value_of(row[1 + k], basis) + common
        sums[k] = decay * value_of(row[1 + K + k], basis) + common * radius


@compiled
def write_displacements(
    solid: Solid, panels: Stack, p: int, z: float, t: float, parts: Any, basis: Any, slopes: Any
) -> None:
    """Write w_j at z of a free panel."""
    polynomials(z, basis, slopes)
    row = panels.coefficients[p]
    elapsed = t - panels.start[p] - panels.length[p] * share(panels.kind[p], z)[0]
    for j in range(solid.recoveries.shape[0]):
        parts[j] = math.exp(max(-solid.recoveries[j] * elapsed, FORGOTTEN)) * value_of(row[1 + j], basis)


@compiled
def leave(solid: Solid, displacement: float, loads: Any, parts: Any) -> None:
    """Write w_j of an element that leaves the contact."""
    for j in range(solid.recoveries.shape[0]):
        value = solid.displacement[j] * displacement
        for k in range(solid.rates.shape[0]):
            value += solid.loads[j, k] * loads[k]
        parts[j] = value


@compiled
def touch(solid: Solid, parts: Any, loads: Any) -> None:
    """Write l_k of a free element that is touched."""
    for k in range(solid.rates.shape[0]):
        value = 0.0
        for j in range(solid.recoveries.shape[0]):
            value += solid.moduli_of[k, j] * parts[j]
        loads[k] = value


@inlined
def front_value(
    solid: Solid, panels: Stack, p: int, follows: bool, z: float, t: float, drive: float, basis: Any, slopes: Any
) -> tuple[float, float, float, float]:
    """Return what vanishes at the front, the load or the gap; see `load` and `gap`."""
    if follows:
        return load(solid, panels, p, z, t, drive, basis, slopes)
    return gap(solid, panels, p, z, t, drive, basis, slopes)


@compiled
def locate(
    solid: Solid, panels: Stack, count: int, follows: bool, t: float, drive: float, p: int, z: float, basis: Any,
    slopes: Any,
) -> tuple[int, float, float, float]:  # fmt: skip
    """Return the panel, z and y at which the load (`follows`) or the gap is zero, and its slope over y.

    Both fall towards the top. `drive` is the shared load, or the depth. The search starts at z of panel p. Below the
    lowest panel: panel -1. Above the top: the top, since next to a smooth turning a second root lies behind it.
    """
    low, high = 0.0, panels.end[p]
    low_known, high_known = False, False
    z = min(max(z, low), high)
    y, last, steepness = 0.0, 1.0, 0.0
    for _ in range(80):
        f, slope, y, rise = front_value(solid, panels, p, follows, z, t, drive, basis, slopes)
        steepness = abs(slope / rise) if rise != 0.0 else 0.0
        if f < 0.0:
            high, high_known = z, True
        else:
            low, low_known = z, True
        step = -f / slope if slope < 0.0 else math.copysign(math.inf, f)
        target = z + step
        if not high_known and target >= high:
            if z < high:
                # The top of the panel has to be looked at.
                z = high
                continue
            if p == count - 1:
                return p, z, y, steepness
            p, z = p + 1, 0.0
            low, high = 0.0, panels.end[p]
            low_known, last = True, 1.0
            continue
        if not low_known and target <= 0.0:
            if z > 0.0:
                z = 0.0
                continue
            if p == 0:
                return -1, 0.0, y, steepness
            p -= 1
            low, high = 0.0, panels.end[p]
            z = high
            low_known, high_known, last = False, True, 1.0
            continue
        if not low <= target <= high:
            target = 0.5 * (low + high)
            step = target - z
            last = 1.0
        elif abs(step) <= 1e-11 or abs(step * step * step) <= 1e-16 * last * last:
            # The next step of Newton's method would be step^3/last^2.
            return p, target, y + rise * step, steepness
        if abs(step) <= 1e-16 or high - low <= 1e-16:
            return p, z, y, steepness
        last, z = abs(step), target
    return p, z, y, steepness


@inlined
def to_coefficients(rule: Scheme, values: Any, row: Any) -> None:
    """Write the Chebyshev coefficients of the polynomial with these values at the nodes."""
    for n in range(NODES):
        total = 0.0
        for i in range(NODES):
            total += rule.coefficients[n, i] * values[i]
        row[n] = total


@inlined
def larger(first: float, second: float) -> float:
    """Return the larger of two numbers; NaN where one of them is."""
    return first if first > second or math.isnan(first) else second


@inlined
def tail(rule: Scheme, values: Any) -> float:
    """Return the size of the last two Chebyshev coefficients of the polynomial with these values at the nodes."""
    last, before = 0.0, 0.0
    for i in range(NODES):
        last += rule.coefficients[NODES - 1, i] * values[i]
        before += rule.coefficients[NODES - 2, i] * values[i]
    return abs(last) + abs(before)
