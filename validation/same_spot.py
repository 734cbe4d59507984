"""Random series of impacts on one spot: how many of them end unsolved.

`python validation/same_spot.py [COUNT] [RTOL]` draws series of up to 124 bounces: one to four terms over four decades,
a quarter liquids; parabola, cone and sphere; with and without weight.
"""

import math
import sys
import warnings
from collections import Counter

import numpy as np

import restitution as rs

PROFILES = rs.Parabola(1.0), rs.Cone(0.8), rs.Sphere(20.0)


def draw(seed):
    """Return an impact and the options of its bounces."""
    rng = np.random.default_rng([21, seed])
    terms = int(rng.integers(1, 5))
    equilibrium = 0.0 if rng.random() < 0.25 else 1.0
    series = rs.PronySeries(equilibrium, 10.0 ** rng.uniform(-1.0, 1.0, terms), 10.0 ** rng.uniform(-2.0, 2.0, terms))
    profile = PROFILES[rng.integers(len(PROFILES))]
    impact = rs.Impact(rs.Material(series, math.inf), profile, mass=1.0, velocity=10.0 ** rng.uniform(-1.0, 0.5))
    gravity, weight, height = 10.0 ** rng.uniform(-3.0, 0.0), bool(rng.random() < 0.5), rng.random() < 0.5
    return impact, {"gravity": gravity, "with_weight": weight, "min_height": 0.0 if height else None}


def main():
    warnings.simplefilter("ignore")
    count = int(sys.argv[1]) if len(sys.argv) > 1 else 120
    rtol = float(sys.argv[2]) if len(sys.argv) > 2 else 1e-9
    ends = Counter()
    for seed in range(count):
        impact, options = draw(seed)
        series = rs.bounces(impact, same_spot=True, rtol=rtol, max_bounces=124, **options)
        ends[str(series.ended)] += 1
        if series.ended == "unsolved":
            print(f"seed {seed}: {series.n_bounces} bounces, {series.warnings[-1]}", flush=True)
    print(f"{count} series at rtol = {rtol:g}: {dict(ends)}")


if __name__ == "__main__":
    main()
