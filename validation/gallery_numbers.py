"""Reference values of the gallery, from SciPy alone.

The reduced modulus comes from partial fractions with zeros by Brent's method, the impact from SciPy's implicit Radau
integration of the equations of docs/theory/impact.md at rtol 1e-11. Only the data files of the package are
used. It takes half a minute.
"""

from __future__ import annotations

import csv
import math
from collections.abc import Callable
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from scipy.integrate import solve_ivp
from scipy.optimize import brentq

ROOT = Path(__file__).resolve().parents[1]
Array = NDArray[np.float64]
Series = tuple[float, Array, Array]
"""End modulus, moduli, times."""


def carson(series: Series, s: float) -> float:
    """E_inf + sum E_k s/(s + 1/tau_k)."""
    end, moduli, times = series
    return end + float(np.sum(moduli * s * times / (s * times + 1.0)))


def slope(series: Series, s: float) -> float:
    """Derivative of the Carson transform."""
    _, moduli, times = series
    return float(np.sum(moduli * times / (s * times + 1.0) ** 2))


def times_where(function: Callable[[float], float], poles: Array) -> list[float]:
    """Times theta with function(-1/theta) = 0; the function rises between neighbouring poles (times)."""
    results: list[float] = []
    edges = np.log(np.sort(poles))
    for n in range(edges.size + 1):
        low = edges[n - 1] if n else edges[0] - 60.0
        high = edges[n] if n < edges.size else edges[-1] + 60.0

        def value(x: float, low: float = low, high: float = high, n: int = n) -> float:
            # At the pole itself the sign would depend on rounding.
            if n and x - low < 1e-14 * (1.0 + abs(low)):
                return -1e300
            if n < edges.size and high - x < 1e-14 * (1.0 + abs(high)):
                return 1e300
            return function(-math.exp(-x))

        if value(low) * value(high) < 0.0:
            results.append(math.exp(brentq(value, low, high, xtol=1e-15, rtol=1e-15)))
    return results


def from_shear(shear: Series, bulk: float) -> Series:
    """E* = G + 9K/4 - (27 K^2/4)/(3K + 4G)."""
    thetas = times_where(lambda s: 3.0 * bulk + 4.0 * carson(shear, s), shear[2])
    moduli = [6.75 * bulk**2 * t / (4.0 * slope(shear, -1.0 / t)) for t in thetas]
    end = 4.0 * shear[0] * (3.0 * bulk + shear[0]) / (3.0 * bulk + 4.0 * shear[0])
    return end, np.array([*shear[1], *moduli]), np.array([*shear[2], *thetas])


def from_tension(tension: Series, bulk: float) -> Series:
    """E* = 27 K^2/(9K - E) - 9 K^2/(3K + E), with E(t) in tension."""
    moduli: list[float] = []
    thetas: list[float] = []
    for value, factor in ((9.0 * bulk, 27.0), (-3.0 * bulk, 9.0)):
        for t in times_where(lambda s, value=value: carson(tension, s) - value, tension[2]):
            thetas.append(t)
            moduli.append(factor * bulk**2 * t / slope(tension, -1.0 / t))
    end = 36.0 * bulk**2 * tension[0] / ((9.0 * bulk - tension[0]) * (3.0 * bulk + tension[0]))
    return end, np.array(moduli), np.array(thetas)


def in_line(first: Series, second: Series) -> Series:
    """1/E* = 1/E1 + 1/E2."""
    thetas = times_where(lambda s: carson(first, s) + carson(second, s), np.concatenate([first[2], second[2]]))
    moduli = [carson(first, -1.0 / t) ** 2 * t / (slope(first, -1.0 / t) + slope(second, -1.0 / t)) for t in thetas]
    return first[0] * second[0] / (first[0] + second[0]), np.array(moduli), np.array(thetas)


def restitution(series: Series, radius: float, mass: float, velocity: float, weight: float = 0.0) -> float:
    """Restitution coefficient of a paraboloid."""
    end, moduli, times = series
    kept = moduli > 1e-13 * moduli.max()
    moduli, times = moduli[kept], times[kept]
    n, root = len(times), math.sqrt(radius)
    # In units of the elastic impact all numbers are of order one.
    depth = (15.0 * mass * velocity**2 / (16.0 * (end + moduli.sum()) * root)) ** 0.4
    unit = depth / velocity
    taus, scale = times / unit, root * depth**1.5 / (mass * velocity / unit)
    end, moduli, weight = end * scale, moduli * scale, weight * unit / (mass * velocity)

    def force(s: float, y: Array) -> float:
        return 2.0 * (end * 2.0 / 3.0 * s**3 + float(moduli @ y))

    def approach(_: float, state: Array) -> Array:
        s, v = state[:2]
        y, w = state[3 : 3 + n], state[3 + n :]
        dv = -2.0 * s * (force(s, y) - weight)
        return np.concatenate([[v, dv, 2.0 * s], -2.0 * s * y / taus + 2.0 * s * s * v, -2.0 * s * w / taus + dv])

    def turned(_: float, state: Array) -> float:
        return float(state[1])

    turned.terminal = True  # pyright: ignore[reportFunctionMemberAccess]
    options = {"method": "Radau", "rtol": 1e-11, "atol": 1e-13}
    start = np.concatenate([[0.0, 1.0, 0.0], np.zeros(n), np.ones(n)])
    coming = solve_ivp(approach, (0.0, 50.0), start, events=turned, dense_output=True, **options)
    last = float(coming.t_events[0][0])

    def rebound(path: float, state: Array) -> Array:
        t, v, w = state[0], state[1], state[2:]
        then = coming.sol(last - path)
        s, v_then, t_then = then[:3]
        y, w_then = then[3 : 3 + n], then[3 + n :]
        decay = np.exp(-np.maximum(t - t_then, 0.0) / taus)
        spread = end + float(moduli @ decay)
        pull = end * v + float(moduli @ (w + decay * (v_then - w_then)))
        dt = -2.0 * s * v_then * spread / pull
        dv = -(2.0 * (end * 2.0 / 3.0 * s**3 + float(moduli @ (decay * y))) - weight) * dt
        return np.concatenate([[dt, dv], -w / taus * dt + dv])

    # At the turning point the pace is 0/0 with the limit 2 s.
    at = 1e-9 * last
    turning = coming.sol(last)
    dt = 2.0 * turning[0]
    dv = -dt * (force(turning[0], turning[3 : 3 + n]) - weight)
    w = turning[3 + n :]
    begin = np.concatenate([[turning[2] + at * dt, at * dv], w + at * (dv - w / taus * dt)])
    going = solve_ivp(rebound, (at, last), begin, **options)
    return float(-going.y[1, -1])


def rows(path: Path) -> Array:
    """Numbers of a CSV file without its header."""
    lines = [line for line in path.read_text().splitlines() if not line.startswith("#")]
    return np.array(list(csv.reader(lines))[1:], dtype=float)


def main() -> None:
    """Write `gallery_numbers.md`."""
    epoxy = rows(ROOT / "examples" / "epoxy_prony.csv")
    shear = (4.9e6, (891e6 - 4.9e6) * epoxy[:, 1], epoxy[:, 0])
    block = from_shear(shear, 3e9)
    ball = 7800.0 * 4.0 / 3.0 * math.pi * 0.005**3
    results = {"steel ball, R = 5 mm, on epoxy, 1 m/s": restitution(block, 0.005, ball, 1.0)}

    rubber = rows(ROOT / "src" / "restitution" / "material" / "data" / "polyisobutylene.csv")
    tension: Series = (0.0, rubber[:, 1], rubber[:, 0])
    for celsius in (-20.0, 20.0):
        kelvin = celsius + 273.15 - 298.0
        shift = 10.0 ** (-8.61 * kelvin / (200.4 + kelvin))
        tension = (0.0, rubber[:, 1], rubber[:, 0] * shift)
        results[f"steel ball, R = 5 mm, on polyisobutylene at {celsius:g} °C, 1 m/s"] = restitution(
            from_tension(tension, 3e9), 0.005, ball, 1.0
        )

    soft = from_shear((2e6, np.array([20e6]), np.array([50e-6])), 2e9)
    # polyisobutylene at 20 °C
    pair = in_line(soft, from_tension(tension, 3e9))
    radius = 1.0 / (1.0 / 0.01 + 1.0 / 0.02)
    masses = 1100.0 * 4.0 / 3.0 * math.pi * 0.01**3, 920.0 * 4.0 / 3.0 * math.pi * 0.02**3
    mass = masses[0] * masses[1] / (masses[0] + masses[1])
    results["rubber sphere, R = 10 mm, on polyisobutylene sphere, R = 20 mm, at 20 °C, 1 m/s"] = restitution(
        pair, radius, mass, 1.0
    )

    ratio = 0.48
    bulk = 2.0 * 25e6 * (1.0 + ratio) / (3.0 * (1.0 - 2.0 * ratio))
    hard = from_shear((25e6, np.array([25e6]), np.array([100e-6])), bulk)
    mass = 1100.0 * 4.0 / 3.0 * math.pi * 0.02**3
    results["rubber ball, R = 20 mm, dropped from 100 mm, with its weight"] = restitution(
        hard, 0.02, mass, math.sqrt(2.0 * 9.81 * 0.1), mass * 9.81
    )
    lines = ["| impact | e |", "|---|---|", *(f"| {name} | {e:.10f} |" for name, e in results.items())]
    Path(__file__).with_suffix(".md").write_text("\n".join(lines) + "\n", encoding="utf-8")


if __name__ == "__main__":
    main()
