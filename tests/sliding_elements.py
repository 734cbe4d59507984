"""Independent stick-slip elements: explicit in the text-book form, without layers, corrections or linear rates.

Each element has one displacement and one spring for each mode; trapezoidal rules in time and place. Second order where
the relaxation times are longer than a step.
"""

import numpy as np

from restitution import reduced_shear_modulus
from restitution.impact.batch import Batch


def normal_history(impact, rtol=1e-11):
    """Stored normal solution of an impact."""
    return Batch.from_impact(impact).solve_stored(rtol)[1]


def grid(solution, count):
    """Times, depths, memories H_k and radii at equal steps of both halves."""
    places = solution.sigma_m * np.arange(count + 1) / count
    back = solution.interpolate(solution.rebound.columns, *solution.places(solution.rebound, places[1:]))
    columns = np.concatenate([solution.approach_at(places), back])
    roots = np.maximum(columns[: count + 1, 0], 0.0)
    return columns[:, 2], columns[:, 4], columns[:, 5:], solution.radius(roots), roots**2


def tangential_restitution(impact, slope, kappa, count, solution=None):
    """e_t of a solid without a dashpot from `count` steps in each half, at v_c0/(mu v0) = slope."""
    solution = solution or normal_history(impact)
    units, modulus = solution.units, impact.reduced_modulus
    factor = units.equilibrium / modulus.equilibrium_modulus
    series = reduced_shear_modulus(impact.material, impact.counter_material)
    G_inf, G, tau = (
        series.equilibrium_modulus * factor,
        series.branch_moduli * factor,
        series.relaxation_times / units.time,
    )
    t, d, H, x, g = grid(solution, count)
    weights = 0.5 * (np.append(x[1:], x[-1]) - np.append(-x[0], x[:-1]))
    u, h, w = np.zeros(count + 1), np.zeros((count + 1, tau.size)), np.zeros((count + 1, units.times.size))
    v, force, mobility = slope, 0.0, 1.0 + 1.0 / kappa
    for n in range(2 * count):
        dt = t[n + 1] - t[n]
        here = slice(0, n + 1 if n < count else 2 * count - n - 1)
        fade = np.exp(-dt / units.times)
        w *= fade
        w[here] += H[n + 1] - fade * H[n]
        limit = np.maximum(units.equilibrium * (d[n + 1] - g[here]) + w[here] @ units.moduli, 0.0)
        e = np.exp(-dt / tau)
        f = (1.0 - e) * tau / dt
        slope_of_load = G_inf + f @ G
        trial = G_inf * u[here] + h[here] @ (G * e)

        low, high = -abs(dt * slope) * 3.0, abs(dt * slope) * 3.0
        way = dt * v
        for _ in range(60):
            load = np.clip(trial + slope_of_load * way, -limit, limit)
            value = way - dt * v + 0.25 * mobility * dt * dt * (force + weights[here] @ load)
            low, high = (low, way) if value > 0.0 else (way, high)
            stuck = np.abs(trial + slope_of_load * way) <= limit
            after = way - value / (1.0 + 0.25 * mobility * dt * dt * slope_of_load * weights[here][stuck].sum())
            after = after if low < after < high else 0.5 * (low + high)
            if after == way or abs(value) < 1e-15 * abs(dt * slope):
                break
            way = after
        moved = (load - trial) / slope_of_load
        u[here] += moved
        h[here] = h[here] * e + np.outer(moved, f)
        now = weights[here] @ load
        v -= 0.5 * dt * mobility * (force + now)
        force = now
    return -v / slope
