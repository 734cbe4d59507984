"""Random indentations against a direct solution of Ting's equations by another method.

Run as `python validation/ting.py [--count 200] [--seed 1]`; prints a table and writes it to `ting.md` beside this
file. It takes some three minutes.

The prescribed history is a chain of straight lines and steps. E*(t) is the Prony series itself, and J*(t) its inverse
by the roots of the characteristic function (`brentq`). Integrals of sums of exponentials are closed forms, the others
Gauss quadratures on panels that shrink towards both ends. `brentq` finds the time of equal contact.
"""

from __future__ import annotations

import argparse
import math
from collections import defaultdict
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
from rich.progress import track
from scipy.optimize import brentq

import restitution as rs

TEXT = """\
## Random histories against a direct solution of the integral equations

`validation/ting.py --count {count} --seed {seed}` makes this table. A row has {count} random histories of straight
lines. A fifth of them have a step, and some begin above the surface. The materials have 1 to 8 terms with
relaxation times over eleven decades; they are solids and liquids, some with a dashpot in parallel. The profiles are
a parabola, a cone, $r^{{0.7}}$, $r^{{3.3}}$ and a sphere. The reference uses $E^*(t)$ itself, closed forms,
quadrature on graded panels and `brentq`. Errors are relative to the largest value. Right after a sudden turn, fast
terms change the force by more than $10^{{-10}}$ within the rounding of a time, so the change of either force over
the rounding of the times is subtracted from its error. The last row of a block is the residual of Ting's condition
$\\int_{{t_1}}^t E^* \\dot d\\,dt' = 0$, relative to $E^*(0)$ and the largest depth. A contact that grows again, as
behind a step or a slower retraction, does not follow this condition and is left out; `validation/histories.py`
compares such histories with elements that are followed alone.

{table}
"""

_NODES, _WEIGHTS = np.polynomial.legendre.leggauss(16)
# The widths of panels grow by no more than the root of 2, as the velocity of a force program may have a layer inside.
_ROOTS = np.concatenate([[0.0], 0.5 * 2.0 ** -np.arange(0.0, 46.0, 0.5)[::-1]])
_EDGES = np.concatenate([_ROOTS, 1.0 - _ROOTS[-2::-1]])
_HALF = 0.5 * np.diff(_EDGES)[:, None]
# The panels are symmetric, so that 1 - SHARES is SHARES reversed, without cancellation.
SHARES, QUADRATURE = (_EDGES[:-1, None] + _HALF * (1.0 + _NODES)).ravel(), (_HALF * _WEIGHTS).ravel()


class Creep:
    """Creep compliance J(t) of a series without a parallel dashpot, and its integral."""

    def __init__(self, series: rs.PronySeries) -> None:
        rates = np.sort(1.0 / series.relaxation_times)
        moduli = series.branch_moduli[np.argsort(-series.relaxation_times)]
        equilibrium, glass = series.equilibrium_modulus, series.instantaneous_modulus

        def operational(s: float) -> float:
            return equilibrium + float(np.sum(moduli * s / (s + rates)))

        # One root between each two poles, and one between the slowest and zero where the body is a solid.
        ends = np.concatenate([[0.0] if equilibrium > 0.0 else [], rates])
        self.rates = np.array(
            [
                brentq(lambda x: operational(-x), low * (1 + 1e-14) + 1e-300, high * (1 - 1e-14), xtol=1e-300)
                for low, high in pairwise(ends)
            ]
        )
        slopes = [float(np.sum(moduli * rates / (rates - s) ** 2)) for s in self.rates]
        self.amplitudes = 1.0 / (self.rates * np.array(slopes))
        self.glass, self.flow = 1.0 / glass, 0.0 if equilibrium > 0.0 else 1.0 / np.sum(moduli / rates)

    def at(self, t: Any) -> Any:
        """J(t), zero for negative times."""
        t = np.asarray(t, dtype=float)[..., None]
        value = self.glass + self.flow * t[..., 0] - np.expm1(-np.maximum(t, 0.0) * self.rates) @ self.amplitudes
        return np.where(t[..., 0] >= 0.0, value, 0.0)

    def integral(self, t: Any) -> Any:
        """Integral of J from 0 to t."""
        t = np.maximum(np.asarray(t, dtype=float), 0.0)
        x = t[..., None] * self.rates
        return self.glass * t + 0.5 * self.flow * t**2 + (x + np.expm1(-x)) @ (self.amplitudes / self.rates)


def modulus(series: rs.PronySeries, t: Any) -> Any:
    """E(t) without the dashpot."""
    decays = np.exp(-np.maximum(t, 0.0)[..., None] / series.relaxation_times)
    return series.equilibrium_modulus + decays @ series.branch_moduli


def relaxed(series: rs.PronySeries, low: float, high: float) -> float:
    """Integral of E from `low` to `high`."""
    times = series.relaxation_times
    modes = np.exp(-low / times) * -np.expm1(-(high - low) / times) * times
    return series.equilibrium_modulus * (high - low) + float(modes @ series.branch_moduli)


class UnderDepth:
    """Force and radius under a prescribed depth that rises first and then falls."""

    def __init__(self, series: rs.PronySeries, profile: Any, time: Any, depth: Any) -> None:
        self.series, self.profile, self.dashpot = series, profile, series.parallel_viscosity
        self.time, self.depth, top = time, depth, int(np.argmax(depth))
        self.turning, self.largest = time[top], depth[top]

    def pieces(self, t: float, beyond: float = 0.0) -> Any:
        """Lines and steps up to t, and from where the growing contact was deeper than `beyond`."""
        for (a, b), (x, y) in zip(pairwise(self.time), pairwise(self.depth), strict=True):
            if a > t:
                return
            if b <= self.turning and x < beyond:
                if y <= beyond:
                    continue
                a, x = a + (b - a) * (beyond - x) / (y - x), beyond
            yield (a, t, x, x + (y - x) * (t - a) / (b - a)) if b > t else (a, b, x, y)

    def rate(self, t: float) -> float:
        """Rate of the depth, at a kink the rate after it."""
        n = min(int(np.searchsorted(self.time, t, side="right")), self.time.size - 1)
        return (self.depth[n] - self.depth[n - 1]) / (self.time[n] - self.time[n - 1])

    def load(self, t: float, beyond: float = 0.0) -> float:
        """Load of an element at the depth `beyond`: int_t1^t E d' dt'."""
        total = self.dashpot * self.rate(t)
        for a, b, x, y in self.pieces(t, beyond):
            mean = relaxed(self.series, t - b, t - a) / (b - a) if b > a else modulus(self.series, np.array(t - a))
            total += (y - x) * float(mean)
        return total

    def force(self, t: float, until: float) -> float:
        """2 int_0^t1 E a d' dt', up to the depth `until`, without the dashpot."""
        total, profile = 0.0, self.profile
        for a, b, x, y in self.pieces(min(t, self.turning)):
            end = min(y, until)
            if end <= x:
                continue
            b = a + (b - a) * (end - x) / (y - x)
            weights = QUADRATURE * modulus(self.series, (t - b) + (b - a) * SHARES[::-1])
            total += float(weights @ profile.contact_radius(x + (end - x) * SHARES)) * (end - x)
        return 2.0 * total

    def end(self) -> float:
        """Time at which the load of the innermost element is zero; infinite if there is none."""
        later = self.time[self.time > self.turning]
        for a, b in pairwise([self.turning, *later]):
            if self.load(a * (1.0 + 1e-15)) <= 0.0:
                return a
            if self.load(b * (1.0 - 1e-15)) <= 0.0:
                return brentq(self.load, a * (1.0 + 1e-15), b * (1.0 - 1e-15), xtol=1e-300, rtol=1e-15)
        return later[-1] if self.load(later[-1]) <= 0.0 else math.inf

    def errors(self, result: rs.IndentationResult, touch: float) -> dict[str, float]:
        """Errors of force, radius and end of contact."""
        end, stop = self.end(), self.time[-1]
        last = min(end, stop)
        t = np.concatenate([
            self.turning * np.array([1e-3, 0.1, 0.5, 0.9]),
            self.turning + (last - self.turning) * np.array([1e-3, 0.2, 0.5, 0.9, 0.99]),
        ])  # fmt: skip
        t = t[~np.isin(t, [self.turning, end])]
        forces, depths, own_rounding = [], [], []
        ulps = 2.0 * np.spacing(abs(touch) + self.time[-1])
        for moment in t:
            depth = np.interp(moment, self.time, self.depth)
            now = 0.0
            if moment < self.turning:
                now = 2.0 * self.dashpot * float(self.profile.contact_radius(depth)) * self.rate(moment)
            elif self.load(moment, self.largest) < 0.0:
                depth = brentq(lambda x, t=moment: self.load(t, x), 0.0, self.largest, xtol=1e-300, rtol=1e-15)
            else:
                depth = self.largest
            depths.append(depth)
            forces.append(now + self.force(moment, depth))
            own_rounding.append(abs(self.force(moment + ulps, depth) - self.force(moment, depth)))
        moments = np.minimum(t + touch, result.prescribed_history.stop)
        results = result.sample(moments)
        before, behind = (result.sample(np.clip(moments + n * ulps, *result.time[[0, -1]])) for n in (-1, 1))
        rounding = np.maximum(np.abs(behind.force.values - before.force.values), own_rounding)
        radii = np.asarray(self.profile.contact_radius(np.array(depths)))
        both = math.isfinite(end) or math.isfinite(result.contact_end_time)
        return {
            "force": float((np.abs(results.force.values - forces) - rounding).max(initial=0.0)) / result.max_force,
            "contact radius": float(np.abs(results.contact_radius - radii).max()) / result.max_contact_radius,
            "end of contact": abs(result.contact_end_time - touch - end) / stop if both else 0.0,
        }


class UnderForce:
    """Depth and radius under a prescribed force."""

    def __init__(self, series: rs.PronySeries, profile: Any, time: Any, force: Any) -> None:
        self.series, self.profile, self.time, self.values = series, profile, time, force
        self.creep = Creep(series)

    def integral(self, t: Any, rate: bool = False) -> Any:
        """Pi of the growing contact, 1/2 int J dF, or its rate without the steps of the force."""
        total = np.zeros(np.shape(t))
        for (a, b), (x, y) in zip(pairwise(self.time), pairwise(self.values), strict=True):
            if b > a:
                both = self.creep.at if rate else self.creep.integral
                total += 0.5 * (y - x) / (b - a) * (both(t - a) - both(t - b))
            elif rate:
                modes = np.exp(-np.maximum(t - a, 0.0)[..., None] * self.creep.rates)
                slope = self.creep.flow + modes @ (self.creep.amplitudes * self.creep.rates)
                total += 0.5 * (y - x) * np.where(t >= a, slope, 0.0)
            else:
                total += 0.5 * (y - x) * self.creep.at(t - a)
        return total

    def force(self, t: float, t1: float) -> float:
        """2 int_0^t1 E dPi."""
        total = 0.0
        for (a, b), (x, y) in zip(pairwise(self.time), pairwise(self.values), strict=True):
            if b == a and a < t1:
                total += (y - x) * self.creep.glass * float(modulus(self.series, np.array(t - a)))
            end = min(b, t1)
            if end > a:
                rates = self.integral(a + (end - a) * SHARES, rate=True)
                weights = QUADRATURE * modulus(self.series, (t - end) + (end - a) * SHARES[::-1])
                total += 2.0 * float(weights @ rates) * (end - a)
        return total

    def depth(self, integral: float) -> float:
        """Depth at which Pi has a value."""
        profile = self.profile
        if profile.path_exponent is not None:
            p, c = float(profile.path_exponent), float(profile.path_coefficient)
            return (0.5 * (p + 2.0) * integral / c) ** (2.0 / (p + 2.0))
        logarithm = brentq(
            lambda x: float(profile.force_integral_at_depth(math.exp(x))) / integral - 1.0,
            -80.0, math.log(1e3 * profile.radius), xtol=1e-15,
        )  # fmt: skip
        return math.exp(logarithm)

    def errors(self, result: rs.IndentationResult, touch: float) -> dict[str, float]:
        """Errors of depth and radius, and the residual of Ting's condition."""
        turning, stop = result.turning_time - touch, self.time[-1]
        growing = turning * np.array([1e-3, 0.1, 0.5, 0.9])
        results = result.sample(growing + touch)
        depths = np.array([self.depth(x) for x in self.integral(growing)])
        worst = float(np.abs(results.indentation_depth - depths).max()) / result.max_indentation_depth
        radii = np.asarray(self.profile.contact_radius(depths))
        radius = float(np.abs(results.contact_radius - radii).max()) / result.max_contact_radius
        residual = 0.0

        def sampled_radius(t: float) -> float:
            return result.sample([t + touch]).contact_radius.item()

        # Kinks of the growing contact come back where the shrinking one has the same radius.
        kinks = [float(x) for x in self.time[(self.time > 0.0) & (self.time < turning)]]
        radii_there = [sampled_radius(x) for x in kinks]
        last = stop * (1.0 - 1e-9)
        kinks += [
            brentq(lambda x, a=a: sampled_radius(x) - a, turning * (1.0 + 1e-12), last, xtol=1e-300, rtol=1e-15)
            for a in radii_there
            if (sampled_radius(turning * (1.0 + 1e-12)) - a) * (sampled_radius(last) - a) < 0.0
        ]
        kinks = np.array([*kinks, *self.time, turning])
        for moment in turning + (stop - turning) * np.array([0.02, 0.3, 0.7, 0.95]):
            value = float(np.interp(moment, self.time, self.values))
            jumps = {float(a) for a, b in pairwise(self.time) if a == b and a < turning}
            places = [0.0, *sorted(jumps), turning]
            for low, high in pairwise(places):
                low, high = low * (1.0 + 1e-15), high * (1.0 - 1e-15)
                if self.force(moment, low) <= value <= self.force(moment, high):
                    t1 = brentq(lambda x, t=moment, f=value: self.force(t, x) - f, low, high, xtol=1e-300, rtol=1e-15)
                    break
            else:
                continue  # within a step
            expected = float(self.profile.contact_radius(self.depth(float(self.integral(np.array(t1))))))
            radius = max(radius, abs(sampled_radius(moment) - expected) / result.max_contact_radius)
            if any(t1 <= a <= moment for a, b in pairwise(self.time) if a == b):
                continue
            total = 0.0
            inner = kinks[(kinks > t1) & (kinks < moment)]
            for a, b in pairwise(np.unique([t1, *inner, moment])):
                rates = result.sample(
                    np.clip(a + (b - a) * SHARES + touch, a + touch, b + touch)
                ).indentation_velocity.values
                total += float((QUADRATURE * modulus(self.series, (moment - b) + (b - a) * SHARES[::-1])) @ rates) * (
                    b - a
                )
            glass = self.series.instantaneous_modulus
            residual = max(residual, abs(total) / (glass * result.max_indentation_depth))
        return {"depth": worst, "contact radius": radius, "Ting's condition": residual}


def drawn(rng: np.random.Generator, prescribed: str) -> tuple[rs.PronySeries, Any, Any, Any]:
    """A random series and profile, times and values."""
    count = int(rng.integers(1, 9))
    damped = prescribed == "depth" and rng.random() < 0.15
    series = rs.PronySeries(
        float(rng.choice([0.0, 1.0])), 10.0 ** rng.uniform(-2, 2, count), 10.0 ** rng.uniform(-7, 4, count),
        parallel_viscosity=float(10.0 ** rng.uniform(-2, 1)) if damped else 0.0,
    )  # fmt: skip
    profiles = [rs.Parabola(1.0), rs.Cone(1.2), rs.PowerLaw(3.3, 1.0), rs.PowerLaw(0.7, 1.0), rs.Sphere(1e3)]
    profile: Any = profiles[rng.integers(5)]
    up, down = rng.integers(1, 6), rng.integers(1, 5)
    rise = np.cumsum(rng.uniform(0.01, 1.0, up))
    fall = np.sort(rng.uniform(0.0, 1.0, down - 1))[::-1]
    values = np.concatenate([[0.0], rise / rise[-1], fall, [0.0]])
    time = np.concatenate([[0.0], np.cumsum(10.0 ** rng.uniform(-2.0, 0.2, up + down))])
    if prescribed == "depth" and rng.random() < 0.4:
        values = np.concatenate([[-rng.uniform(0.1, 1.0)], values[1:] - rng.uniform(0.0, 0.7)])
    if rng.random() < 0.2 and not damped:
        n = int(rng.integers(1, time.size - 1))
        step = (values[n - 1] - values[n]) * rng.uniform()
        time, values = np.insert(time, n, time[n]), np.insert(values, n, values[n] + step)
    return series, profile, time, values


def study(prescribed: str, count: int, rtol: float, seed: int) -> tuple[dict[str, list[float]], int, int]:
    """Errors over the tolerance, and how many histories were refused, and have no reference."""
    rng = np.random.default_rng(seed)
    errors: dict[str, list[float]] = defaultdict(list)
    refused = again = 0
    for _ in track(range(count), f"{prescribed}, {rtol:g}"):
        series, profile, time, values = drawn(rng, prescribed)
        shift = float(10.0 ** rng.uniform(-3.0, 1.0) * rng.choice([-1.0, 0.0, 1.0]))
        material = rs.Material(series.scaled(0.25), math.inf)
        try:
            result = rs.indent(material, profile, time=time + shift, rtol=rtol, **{prescribed: values})
        except ValueError:
            refused += 1
            continue
        # The reference is that of a contact that grows once.
        if result.turning_times.size > 1 or len(result.contact_intervals) > 1:
            again += 1
            continue
        n = int(np.argmax(values > 0.0))
        touch = time[n - 1] - values[n - 1] * (time[n] - time[n - 1]) / (values[n] - values[n - 1])
        time, values = np.append(0.0, time[n:] - touch), np.append(0.0, values[n:])
        reference = (UnderDepth if prescribed == "depth" else UnderForce)(series, profile, time, values)
        for name, error in reference.errors(result, touch + shift).items():
            errors[name].append(error / rtol)
    return errors, refused, again


def main(count: int, seed: int) -> None:
    """Print the table and write it beside this file."""
    lines = [
        "| prescribed | rtol | quantity | histories | refused | grow again | above | largest error over tolerance |",
        "|---" * 8 + "|",
    ]
    for prescribed in ("depth", "force"):
        for rtol in (1e-6, 1e-8, 1e-10):
            errors, refused, again = study(prescribed, count, rtol, seed)
            for name, result in errors.items():
                above = sum(error > 1.0 for error in result)
                lines.append(
                    f"| {prescribed} | {rtol:g} | {name} | {len(result)} | {refused} | {again} | {above} "
                    f"| {max(result):.2g} |"
                )
                print(lines[-1], flush=True)
    text = TEXT.format(count=count, seed=seed, table="\n".join(lines))
    Path(__file__).with_suffix(".md").write_text(text, encoding="utf-8")


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--count", type=int, default=200)
    parser.add_argument("--seed", type=int, default=1)
    main(**vars(parser.parse_args()))
