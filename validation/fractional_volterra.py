"""Fractional materials by direct quadrature of the hereditary contact equations, without Prony series.

Run as `python validation/fractional_volterra.py`; prints a table and writes it to `fractional_volterra.md` beside
this file. It takes half a minute. `impact_by_quadrature`, which the tests also use, needs only NumPy and SciPy.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from scipy.special import erfcx, gamma

INTRODUCTION = """\
# Fractional materials by direct quadrature

Made by `validation/fractional_volterra.py`. The integrals

    approach  F = 2 int_0^t E*(t - t') dPi(t')
    rebound   int_t1^t E*(t - t') d'(t') dt' = 0,    F = 2 int_0^t1 E*(t - t') dPi(t')

are evaluated by product integration: d and Pi are linear between the time steps, the integral of the kernel is
exact (a power of time, or the Mittag-Leffler function of order 1/2, erfcx), and the motion follows by velocity
Verlet. Parabola and cone are incompressible with m = v0 = R = 1. The rows "quadrature" hold e for each number of
steps in the contact, extrapolated from half the number by the order 2 - alpha of the power-law kernel (2 for the
bounded one). The rows "Prony" hold e by `rs.solve` with a series of the given error over a window of 1e-4 to 10
contact times. In the row "chosen", `rs.for_contact` chooses the window. The last columns are differences relative
to the finest quadrature.

| material | profile | by | e | contact time | difference of e | of contact time |
|---|---|---|---|---|---|---|
"""


class Kernel(NamedTuple):
    """Reduced relaxation modulus E*(t), its integral from 0, and the order of the quadrature."""

    modulus: Callable[[Any], Any]
    integral: Callable[[Any], Any]
    order: float


def springpot_kernel(coefficient: float, exponent: float, equilibrium: float = 0.0) -> Kernel:
    """E* = 4 (G_inf + V t^-alpha/Gamma(1 - alpha))."""
    v, alpha, g = coefficient, exponent, equilibrium
    return Kernel(
        lambda t: 4.0 * (g + v * t**-alpha / gamma(1.0 - alpha)),
        lambda t: 4.0 * (g * t + v * t ** (1.0 - alpha) / gamma(2.0 - alpha)),
        2.0 - alpha,
    )


def zener_kernel(equilibrium: float, branch: float, time: float) -> Kernel:
    """E* = 4 (G_inf + G_1 E_1/2(-(t/tau)^1/2)), E_1/2(-x) = exp(x^2) erfc(x) = erfcx(x)."""

    def integral(t: Any) -> Any:
        x = np.sqrt(t / time)
        return 4.0 * (equilibrium * t + branch * time * (erfcx(x) + 2.0 * x / math.sqrt(math.pi) - 1.0))

    return Kernel(lambda t: 4.0 * (equilibrium + branch * erfcx(np.sqrt(t / time))), integral, 2.0)


def parabola(depth: float) -> float:
    """Pi = int_0^d a dd for a parabola with R = 1."""
    return 2.0 / 3.0 * depth**1.5


def cone(depth: float) -> float:
    """Pi for a cone with the contact radius a = d."""
    return 0.5 * depth**2


def impact_by_quadrature(kernel: Kernel, force_integral: Callable[[float], float], step: float) -> tuple[float, float]:
    """Restitution coefficient and contact time for m = v0 = 1 with a constant time step."""
    size, n, turn = 1024, 0, -1
    whole = kernel.integral(step * np.arange(size))
    d, pi = np.zeros(size), np.zeros(size)
    velocity, acceleration, before = 1.0, 0.0, math.inf
    while True:
        n += 1
        if n == size:
            size *= 2
            whole = kernel.integral(step * np.arange(size))
            d, pi = np.resize(d, size), np.resize(pi, size)
        d[n] = d[n - 1] + step * (velocity + 0.5 * step * acceleration)
        if turn < 0 and d[n] < d[n - 1]:
            turn = n - 1
        # Cell j lies between t_j and t_j+1; its weight is the integral of the kernel over it.
        weights = whole[n:0:-1] - whole[n - 1 :: -1] if n > 1 else whole[1:2]
        if turn < 0:
            pi[n] = force_integral(float(d[n]))
            force = 2.0 * float(weights @ np.diff(pi[: n + 1])) / step
        else:
            # since[j] = int_t_j^t E*(t - t') d' dt'
            rates = np.diff(d[: n + 1]) / step
            since = np.append(np.cumsum((weights * rates)[::-1])[::-1], 0.0)
            if since[0] < 0.0:
                return -velocity, step * (n - 1 + before / (before - since[0]))
            before = since[0]
            j = int(np.flatnonzero(since[: turn + 1] >= 0.0)[-1])
            force = 2.0 * float(weights[:j] @ np.diff(pi[: j + 1])) / step
            if j < turn:
                target = whole[n - j - 1] - since[j + 1] / rates[j]
                rest = _inverse(kernel, target, step * (n - j - 1), step * (n - j))
                force += 2.0 * (pi[j + 1] - pi[j]) / step * (whole[n - j] - kernel.integral(rest))
        velocity += 0.5 * step * (acceleration - force)
        acceleration = -force


def extrapolated(kernel: Kernel, force_integral: Callable[[float], float], step: float) -> tuple[float, float]:
    """Restitution coefficient and contact time, extrapolated from a step and its half."""
    coarse = impact_by_quadrature(kernel, force_integral, step)
    fine = impact_by_quadrature(kernel, force_integral, 0.5 * step)
    ratio = 2.0**kernel.order
    e, time = ((ratio * b - a) / (ratio - 1.0) for a, b in zip(coarse, fine, strict=True))
    return e, time


def _inverse(kernel: Kernel, value: float, low: float, high: float) -> float:
    """Time between two times at which the integral of the kernel has a given value."""
    time = 0.5 * (low + high)
    for _ in range(60):
        excess = float(kernel.integral(time)) - value
        low, high = (low, time) if excess > 0.0 else (time, high)
        trial = time - excess / float(kernel.modulus(time))
        trial = trial if low <= trial <= high else 0.5 * (low + high)
        if abs(trial - time) <= 1e-15 * high:
            return trial
        time = trial
    return time


def main() -> None:
    """Write `fractional_volterra.md`."""
    import restitution as rs

    cases = [
        ("springpot(1, 0.3)", springpot_kernel(1.0, 0.3), rs.springpot(1.0, 0.3), "parabola"),
        ("springpot(1, 0.3)", springpot_kernel(1.0, 0.3), rs.springpot(1.0, 0.3), "cone"),
        (
            "fractional_kelvin_voigt(1, 0.5, 0.7)",
            springpot_kernel(0.5, 0.7, 1.0), rs.fractional_kelvin_voigt(1.0, 0.5, 0.7), "parabola",
        ),
        (
            "fractional_zener(1, 5, 0.5, 0.5)",
            zener_kernel(1.0, 5.0, 0.5), rs.fractional_zener(1.0, 5.0, 0.5, 0.5), "parabola",
        ),
        (
            "fractional_maxwell(5, 0.5, 0.5)",
            zener_kernel(0.0, 5.0, 0.5), rs.fractional_maxwell(5.0, 0.5, 0.5), "cone",
        ),
    ]  # fmt: skip
    bodies = {
        "parabola": (parabola, rs.Parabola(1.0)), "cone": (cone, rs.Cone(math.atan(0.5 * math.pi))),
    }  # fmt: skip
    lines: list[str] = []
    for name, kernel, model, body in cases:
        force_integral, profile = bodies[body]
        duration = impact_by_quadrature(kernel, force_integral, 0.01)[1]
        rows = {
            f"quadrature, {n} steps": extrapolated(kernel, force_integral, 2.0 * duration / n)
            for n in (400, 1600, 6400)
        }
        expected = rows["quadrature, 6400 steps"]
        for rtol in (1e-2, 1e-3, 1e-5, 1e-7):
            window = (1e-4 * duration, 10.0 * duration)
            material, error, _ = rs.FractionalMaterial(model, math.inf).approximation(window, rtol)
            result = rs.solve(rs.Impact(material, profile, 1.0, 1.0))
            count = material.shear.n_branches
            rows[f"Prony, {count} terms, error {error:.0e}"] = (
                result.restitution_coefficient, result.contact_time,
            )  # fmt: skip
        fractional = rs.FractionalMaterial(model, math.inf)
        chosen = rs.for_contact(lambda w, f=fractional, p=profile: rs.Impact(f.within(w), p, 1.0, 1.0))
        result = rs.solve(chosen)
        way = f"chosen, {chosen.material.shear.n_branches} terms"
        rows[way] = result.restitution_coefficient, result.contact_time
        for way, (e, time) in rows.items():
            off = " | ".join(f"{a / b - 1.0:.0e}" for a, b in zip((e, time), expected, strict=True))
            lines.append(f"| `{name}` | {body} | {way} | {e:.8f} | {time:.7f} | {off} |")
            print(lines[-1], flush=True)
    Path(__file__).with_suffix(".md").write_text(INTRODUCTION + "\n".join(lines) + "\n", encoding="utf-8")


if __name__ == "__main__":
    main()
