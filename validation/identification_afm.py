"""Materials found from synthetic curves of an atomic force microscope: bias, scatter, coverage, wrong contact points.

A parabolic tip of 2.5 um goes 1 um deep into a standard solid at 1 um/s and back, with 480 points and noise of 10 pN
(0.7 % of the largest force). Baseline, its slope and the contact point are unknown.

Usage: python validation/identification_afm.py [--curves 400] [--map 10000] [--workers 2]
"""

import argparse
import time

import numpy as np

import restitution as rs

TIP = rs.Parabola(2.5e-6)
FIXED = {"poisson_ratio": 0.5}
E0, E_INF, TAU, CONTACT_POINT, SD = 1000.0, 200.0, 0.3, 0.4e-6, 1e-11
GEL = rs.standard_solid(E_INF / 3.0, (E0 - E_INF) / 3.0, (E0 - E_INF) / 3.0 * TAU, **FIXED)
TIME = np.linspace(0.0, 2.8, 480)
DEPTH = np.interp(TIME, [0.0, 1.4, 2.8], [0.0, 1.4e-6, 0.0])
APPROACH, WHOLE = slice(0, 240), slice(None)
NAMES = ("equilibrium_modulus", "branch_modulus", "viscosity", "contact_point")
TRUTH = (E_INF / 3.0, (E0 - E_INF) / 3.0, (E0 - E_INF) / 3.0 * TAU, CONTACT_POINT)
HEAD = "| fit | E(0) | E(inf) | tau | contact point | chi2/n |\n|---|---|---|---|---|---|"


def hertz(shear_modulus: float) -> rs.Material:
    """Elastic half-space."""
    return rs.elastic(shear_modulus=shear_modulus, **FIXED)


def curves(count, force, part=WHOLE, depth=DEPTH, times=TIME, **options):
    """Curves with noise."""
    random = np.random.default_rng(1)
    noisy = force + random.normal(0.0, SD, (count, force.size))
    return [
        rs.IndentationCurve(times[part], depth[part], noise[part], profile=TIP, noise=rs.Noise(force=SD), **options)
        for noise in noisy
    ]


def held(items, off):
    """Curves with the contact point held at a distance from the true one."""
    place = CONTACT_POINT + off
    for curve in items:
        curve.nuisances = (curve.nuisances[0]._replace(start=place, low=place - 1e-13, high=place + 1e-13),)
    return items


def fit(items, model=rs.standard_solid, workers=2):
    """Map of the curves."""
    return rs.identify_map(items, model, fixed=FIXED if model is not hertz else None, workers=workers)


def spread(values, unit="%"):
    """Mean and standard deviation."""
    values = values[np.isfinite(values)]
    return f"{values.mean():+.1f} +- {values.std():.1f} {unit}" if values.size > 1 else f"{values.mean():+.1f} {unit}"


def row(name, table, points):
    """Errors in per cent, of the contact point in nm."""
    g, g1, eta = (table[name].values for name in NAMES[:3])
    moduli = (3.0 * (g + g1) / E0, 3.0 * g / E_INF, eta / g1 / TAU)
    cells = [spread(100.0 * (ratio - 1.0)) for ratio in moduli]
    touch = table["contact_point"].values - CONTACT_POINT
    return (
        f"| {name} | {' | '.join(cells)} | {spread(1e9 * touch, 'nm')} | {table['chi2'].values.mean() / points:.2f} |"
    )


def coverage(name, table, truth=TRUTH, names=NAMES):
    """Share of 95 % intervals that hold the truth, and the scatter over the stated error."""
    cells = []
    for parameter, value in zip(names, truth, strict=True):
        z = (table[parameter].values - value) / table[f"{parameter}_standard_error"].values
        cells.append(f"{100.0 * np.mean(np.abs(z) < 1.96):.1f} % ({np.std(z):.2f})")
    return f"| {name} | {' | '.join(cells)} |"


def soft(stiffness):
    """Force where the tip is at the height of the base less F/k."""
    tip = DEPTH.copy()
    for _ in range(60):
        force = rs.indent(GEL, TIP, depth=tip - CONTACT_POINT, time=TIME).force
        tip = tip + 0.7 * (DEPTH - force / stiffness - tip)
    return force


def power_law(count, workers):
    """Springpot with a hold: errors of V and exponent, and its data fitted by a standard solid."""
    times = np.linspace(0.0, 3.0, 300)
    depth = np.interp(times, [0.0, 0.8, 2.0, 3.0], [0.0, 1.2e-6, 1.2e-6, 0.2e-6])
    model = rs.FractionalMaterial(rs.springpot(400.0, 0.25), bulk=np.inf, rtol=1e-6).within((1e-4, 30.0))
    force = rs.indent(model, TIP, depth=depth - 0.3e-6, time=times).force
    items = curves(count, force, depth=depth, times=times)
    result = fit(items, rs.springpot, workers)
    names, truth = ("coefficient", "exponent", "contact_point"), (400.0, 0.25, 0.3e-6)
    off = [100.0 * (result[name].values / value - 1.0) for name, value in zip(names[:2], truth, strict=False)]
    touch = 1e9 * (result["contact_point"].values - truth[2])
    wrong = float(fit(items, rs.standard_solid, workers)["chi2"].mean()) / times.size
    right = result["chi2"].values.mean() / times.size
    cells = f"{spread(off[0])} | {spread(off[1])} | {spread(touch, 'nm')}"
    return f"| {cells} | {right:.2f} | {wrong:.2f} |", coverage("power law with a hold", result, truth, names)


def speed(count, workers):
    """Seconds for a map of random materials, from arrays to the fitted material."""
    random = np.random.default_rng(2)
    pool = [
        rs.indent(
            rs.standard_solid(*np.array(TRUTH[:3]) * np.exp(random.normal(0.0, 0.3, 3)), **FIXED), TIP,
            depth=DEPTH - random.uniform(0.3e-6, 0.5e-6), time=TIME,
        ).force
        for _ in range(100)
    ]  # fmt: skip
    noisy = [pool[n % 100] + random.normal(0.0, SD, TIME.size) for n in range(count)]

    def reader(force):
        return lambda: rs.IndentationCurve(TIME, DEPTH, force, profile=TIP, noise=rs.Noise(force=SD))

    fit(curves(2, pool[0]), workers=workers)
    begin, used = time.perf_counter(), time.process_time()
    result = fit([reader(force) for force in noisy], workers=workers)
    return time.perf_counter() - begin, time.process_time() - used, int((result["status"] == 0).sum())


def main() -> None:
    """Print the tables."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--curves", type=int, default=400)
    parser.add_argument("--map", type=int, default=10_000)
    parser.add_argument("--workers", type=int, default=2)
    arguments = parser.parse_args()
    count, workers = arguments.curves, arguments.workers
    force = rs.indent(GEL, TIP, depth=DEPTH - CONTACT_POINT, time=TIME).force
    whole = fit(curves(count, force), workers=workers)
    approach = fit(curves(count, force, APPROACH), workers=workers)
    print(HEAD)
    print(row("approach and retraction", whole, 480))
    print(row("approach only", approach, 240))
    for off in (5e-9, 20e-9, 50e-9):
        for sign in (-1.0, 1.0):
            name = f"contact point held {sign * off * 1e9:+.0f} nm off"
            print(row(name, fit(held(curves(count // 4, force), sign * off), workers=workers), 480))
    for name, part in (("approach", APPROACH), ("both", WHOLE)):
        result = fit(curves(count // 8, force, part), hertz, workers)
        modulus, touch = 3.0 * result["shear_modulus"].values.mean(), result["contact_point"].values - CONTACT_POINT
        size = TIME[part].size
        print(f"| Hertz, {name} | E = {modulus:.0f} Pa | | | {spread(1e9 * touch, 'nm')} | "
              f"{result['chi2'].values.mean() / size:.0f} |")  # fmt: skip
    bent, few = soft(0.01), count // 4
    print(row("soft cantilever, compliance ignored", fit(curves(few, bent), workers=workers), 480))
    print(
        row("soft cantilever, spring in the model", fit(curves(few, bent, spring_constant=0.01), workers=workers), 480)
    )
    print(
        "\n| coverage (scatter over stated error) | G(inf) | G1 | viscosity | contact point |\n|---|---|---|---|---|"
    )
    print(coverage("approach and retraction", whole))
    print(coverage("approach only", approach))
    cells, covered = power_law(count // 8, workers)
    print("\n| coefficient | exponent | contact point | chi2/n | chi2/n of a standard solid |\n|---|---|---|---|---|")
    print(cells)
    print("\n| coverage | coefficient | exponent | contact point |\n|---|---|---|---|")
    print(covered)
    wall, used, fitted = speed(arguments.map, workers)
    print(f"\n{arguments.map} curves on {workers} threads: {wall:.0f} s ({used:.0f} s of processor), {fitted} fitted")


if __name__ == "__main__":
    main()
