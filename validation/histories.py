"""Random histories by panels: how many are solved, and how far they are from stricter solutions and single elements.

`python validation/histories.py [number of programs]` prints the table of docs/development/decisions/histories.md, and
`python validation/histories.py --followers [number of programs]` the comparison with elements followed alone,
`python validation/histories.py --returns [number of programs]` counts forces that return from zero, and
`python validation/histories.py --cycle [number of programs]` that with the kernel of one approach and one release.
"""

import math
import sys
import time
import warnings
from pathlib import Path

import numpy as np

import restitution as rs
from restitution.errors import InputError
from restitution.indentation.history import History
from restitution.indentation.panels import solve_by_panels
from restitution.indentation.solve import Reloading, Solution, contact_of

sys.path.insert(0, str(Path(__file__).parents[1] / "tests"))

from element_follower import followed_force, program

RTOL = 1e-8
PROFILES = (
    rs.Parabola(1e-2), rs.Cone(0.5), rs.Sphere(1e-2), rs.TruncatedCone(0.5, 1e-5), rs.Pyramid(1.2)
)  # fmt: skip


def larger(first, second):
    """Return the larger of two numbers; NaN where one of them is."""
    return float(np.maximum(first, second))


def draw(rng, dashpots):
    """A profile, a solid or a liquid of up to 19 terms, and times and depths of straight lines, holds and steps."""
    profile = PROFILES[rng.integers(len(PROFILES))]
    count = int(rng.integers(0, 6) if rng.random() < 0.8 else rng.integers(6, 20))
    equilibrium = float(count == 0 or rng.random() < 0.75)
    first = -3.0 if rng.random() < 0.5 else -1.0
    times = np.sort(10.0 ** rng.uniform(first, 1.5, count))
    viscosity = 0.3 * 10.0 ** rng.uniform(-2.0, 0.0) if dashpots else 0.0
    series = rs.PronySeries(
        1e6 * equilibrium, 1e6 * 10.0 ** rng.uniform(-1.0, 1.0, count), times, parallel_viscosity=1e6 * viscosity
    )
    size = int(rng.integers(2, 10))
    t = np.concatenate([[0.0], np.cumsum(rng.uniform(0.05, 1.0, size))])
    start = 0.0 if rng.random() < 0.5 else -rng.uniform(0.0, 0.5)
    d = np.concatenate([[start, rng.uniform(0.5, 1.0)], rng.uniform(-0.3, 1.0, size - 1)])
    for n in 2 + np.flatnonzero(rng.random(size - 2) < 0.2):
        d[n] = d[n - 1]
    return profile, series, t, 1e-4 * d


def history_of(kind, t, d):
    """The history of a kind, and the arguments of the solver."""
    if kind == "force":
        force = 1e6 * np.abs(d)
        force[0] = 0.0
        return History.from_points(t, force), "force", None
    stiffness = None if kind == "depth" else 1e3
    return History.from_points(t, d), "depth", stiffness


def check(kind, dashpots, count):
    """Solve random programs; return how many are solved, the largest difference, and the mean time."""
    solved, worst, spent = 0, 0.0, 0.0
    for seed in range(count):
        rng = np.random.default_rng([7, seed])
        profile, series, t, d = draw(rng, dashpots)
        history, name, stiffness = history_of(kind, t, d)
        begin = time.process_time()
        try:
            solution = solve_by_panels(profile, series, history, name, RTOL, stiffness)
        except InputError:
            continue
        spent += time.process_time() - begin
        solved += 1
        try:
            strict = solve_by_panels(profile, series, history, name, 1e-2 * RTOL, stiffness)
        except InputError:
            continue
        moments = np.sort(rng.uniform(t[0], t[-1], 50))
        column = 0 if kind == "force" else 2
        values, expected = solution.at(moments)[column], strict.at(moments)[column]
        if expected.max() > 0.0:
            worst = larger(worst, np.abs(values - expected).max() / expected.max())
        assert solution.work >= solution.elements.stored - 1e-9 * solution.units.force * solution.units.length
    return solved, worst, 1e3 * spent / max(solved, 1)


def check_followers(count):
    """Print how far the forces of random programs are from those of elements followed alone, at one time each."""
    errors, refused, least = [], 0, math.inf
    for seed in range(count):
        rng = np.random.default_rng([23, seed])
        terms = int(rng.integers(1, 5))
        series = rs.PronySeries(
            float(rng.random() < 0.7), 10.0 ** rng.uniform(-1.0, 1.0, terms), 10.0 ** rng.uniform(-1.5, 1.0, terms)
        )
        times, depths = program(rng, int(rng.integers(4, 15)))
        try:
            result = rs.indent(rs.Material(series.scaled(0.25), math.inf), rs.Parabola(1.0), depth=depths, time=times)
        except InputError as error:
            refused += 1
            print(f"refused: {seed}: {error}", file=sys.stderr)
            continue
        begin, end = result.contact_intervals[rng.integers(len(result.contact_intervals))]
        moment = float(rng.uniform(begin, min(end, times[-1])))
        error = abs(float(result.sample([moment]).force[0]) - followed_force(result, series, moment))
        errors.append(error / result.max_force / result.rtol)
        least = min(least, result.dissipated / result.work)
    worst, middle = np.max(errors), np.median(errors)
    print(f"{count} programs of 4 to 14 lines against elements followed alone: {refused} refused; error of the force "
          f"over that allowed: median {middle:.1e}, 99 % {np.quantile(errors, 0.99):.2g}, largest {worst:.2g}; "
          f"least dissipation over work {least:.1e}")  # fmt: skip


def returning_force(rng, seed, liquid, dashpot, rests):
    """A profile, a material, and a force of straight lines that is zero twice, for a while or for a moment."""
    terms = int(rng.integers(1, 4))
    viscosity = 0.3 * 10.0 ** rng.uniform(-2.0, 0.0) if dashpot else 0.0
    moduli, times = 10.0 ** rng.uniform(-1.0, 1.0, (2, terms))
    series = rs.PronySeries(0.0 if liquid else 1.0, moduli, times, parallel_viscosity=viscosity)
    size = int(rng.integers(4, 9))
    t, force = np.concatenate([[0.0], np.cumsum(rng.uniform(0.2, 1.0, size))]), rng.uniform(0.2, 1.0, size + 1)
    force[0] = 0.0
    for n in rng.choice(np.arange(2, size), 2, replace=False):
        force[n : n + (2 if rests else 1)] = 0.0
    tips = (rs.Parabola(1.0), rs.Cone(1.1), rs.Sphere(2.0), rs.TruncatedCone(1.1, 0.1), rs.Pyramid(1.2))
    return tips[seed % len(tips)], series, History.from_points(t, force)


def check_returns(count):
    """Print how many programs of a force that returns from zero are solved, and the largest difference of depths."""
    print("| material | dashpot | zero | solved | largest difference |\n|---|---|---|---|---|")
    for liquid in (False, True):
        for dashpot in (False, True):
            for rests in (False, True):
                solved, worst = 0, 0.0
                for seed in range(count):
                    rng = np.random.default_rng([seed, 8])
                    problem = *returning_force(rng, seed, liquid, dashpot, rests), "force"
                    try:
                        solution = solve_by_panels(*problem, RTOL)
                        solved += 1
                        strict = solve_by_panels(*problem, 1e-2 * RTOL)
                    except InputError:
                        continue
                    moments = np.linspace(strict.history.start, strict.history.stop, 101)
                    values, expected = solution.at(moments)[0], strict.at(moments)[0]
                    worst = larger(worst, np.abs(values - expected).max() / expected.max())
                words = "liquid" if liquid else "solid", "yes" if dashpot else "no", "a while" if rests else "a moment"
                print(f"| {' | '.join(words)} | {solved} of {count} | {worst:.1e} |", flush=True)


def single_cycle(rng, peak):
    """One approach and one release: straight lines, with a hold or without, or a smooth function."""
    up, down, rest = rng.uniform(0.1, 1.5, 3)
    shape = rng.integers(4)
    if shape == 0:
        return rs.triangle(peak, up, unloading_time=down)
    if shape == 1:
        return rs.triangle(peak, up, unloading_time=down, hold_time=rest)
    if shape == 2:
        return rs.sine_arch(peak, up)
    return History.from_function(lambda t: peak * np.sin(math.pi * t / up) ** 2, [0.0, up])


def check_cycles(kind, dashpots, count):
    """Solve cycles both ways; return the numbers of both and refused, the largest difference, and processor times."""
    refused, worst, spent = 0, 0.0, []
    for seed in range(count):
        rng = np.random.default_rng([19, seed])
        profile, series, _, _ = draw(rng, dashpots)
        history = single_cycle(rng, 1e-4 if kind == "depth" else 1.0)
        contact = contact_of(rs.Material(series.scaled(0.25), math.inf), profile, None)
        begin = time.process_time()
        try:
            cycle = Solution(contact, contact.reduced_modulus, history, kind, RTOL)
        except (InputError, Reloading):
            continue
        middle = time.process_time()
        try:
            panels = solve_by_panels(profile, contact.reduced_modulus, history, kind, RTOL)
        except InputError:
            refused += 1
            continue
        spent.append((middle - begin, time.process_time() - middle))
        moments = np.sort(rng.uniform(history.start, history.stop, 50))
        column = 0 if kind == "force" else 2
        expected = cycle.at(moments)[column]
        worst = larger(worst, np.abs(panels.at(moments)[column] - expected).max() / expected.max())
    # The first programs may compile.
    return len(spent), refused, worst, *np.sum(spent[3:], axis=0)


def compare_cycles(count):
    """Print the table of one approach and one release."""
    heads = ("driven by", "dashpot", "solved by both", "refused by panels", "largest difference", "ratio of times")
    print("| " + " | ".join(heads) + " |\n" + "|---" * 6 + "|")
    for kind in ("depth", "force"):
        for dashpots in (False, True):
            both, refused, worst, cycle, panels = check_cycles(kind, dashpots, count)
            word = "yes" if dashpots else "no"
            print(f"| {kind} | {word} | {both} | {refused} | {worst:.1e} | {panels / cycle:.2f} |", flush=True)


def main():
    warnings.simplefilter("ignore")
    if "--cycle" in sys.argv:
        compare_cycles(int(sys.argv[2]) if len(sys.argv) > 2 else 300)
        return
    if "--returns" in sys.argv:
        check_returns(int(sys.argv[2]) if len(sys.argv) > 2 else 110)
        return
    if "--followers" in sys.argv:
        check_followers(int(sys.argv[2]) if len(sys.argv) > 2 else 1000)
        return
    count = int(sys.argv[1]) if len(sys.argv) > 1 else 300
    print("| driven by | dashpot | solved | largest difference | mean time [ms] |\n|---|---|---|---|---|")
    for kind in ("depth", "force", "spring"):
        for dashpots in (False, True):
            solved, worst, mean = check(kind, dashpots, count)
            print(
                f"| {kind} | {'yes' if dashpots else 'no'} | {solved} of {count} | {worst:.1e} | {mean:.1f} |",
                flush=True,
            )
    assert math.isfinite(worst)


if __name__ == "__main__":
    main()
