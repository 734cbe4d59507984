"""Identification from data that make no sense: a set ends in a result, one line of refusal, or a failed fit.

Usage: python validation/rubbish.py [--sets 400] [--seed 1] [--out rubbish.md]

A set is a clean record of rebounds, bounce times, a force history or an indentation curve that is then spoiled in one
to three ways: values exchanged, repeated, negated, scaled by decades, rounded, replaced by noise, NaN or infinity,
sorted backwards, cut to a few rows, multiplied by jitter, hit by an outlier, or set to a constant. A traceback of
another kind than the package's own errors, a warning of NumPy, or a result with values that are not finite is a fault.
"""

from __future__ import annotations

import argparse
import time
import warnings
from collections import Counter
from pathlib import Path
from typing import Any

import numpy as np
from rich.progress import track

import restitution as rs

RADIUS, MASS, LONGEST = 0.01, 0.0327, 30.0


def rebounds(rng: np.random.Generator) -> dict[str, Any]:
    velocity = np.sort(rng.uniform(0.05, 2.0, int(rng.integers(3, 30))))
    e = 0.8 - 0.1 * np.log10(velocity) + 0.01 * rng.normal(size=velocity.size)
    columns: dict[str, Any] = {"velocity": velocity, "restitution_coefficient": np.clip(e, 0.01, 1.0)}
    return columns | ({"contact_time": 1e-3 * velocity**-0.2} if rng.random() < 0.5 else {})


def bounces(rng: np.random.Generator) -> dict[str, Any]:
    flights = 0.5 * 0.8 ** np.arange(int(rng.integers(3, 15)))
    return {"time": np.cumsum(flights) + 1e-4 * rng.normal(size=flights.size)}


def force(rng: np.random.Generator) -> dict[str, Any]:
    instants = np.linspace(0.0, 2e-3, int(rng.integers(20, 200)))
    values = np.maximum(75.0 * np.sin(np.pi * (instants - 4e-4) / 1.1e-3), 0.0) * (instants < 1.5e-3)
    return {"time": instants, "force": values + 0.1 * rng.normal(size=instants.size)}


def curve(rng: np.random.Generator) -> dict[str, Any]:
    instants = np.linspace(0.0, 2.0, int(rng.integers(40, 400)))
    depth = 1e-6 * (1.0 - np.abs(instants - 1.0)) - 5e-7
    return {
        "time": instants,
        "depth": depth,
        "force": 1e-3 * np.maximum(depth, 0.0) ** 1.5 * 1e3 + 1e-11 * rng.normal(size=instants.size),
    }


KINDS = {
    "rebounds": (rebounds, lambda columns: rs.Rebounds(**columns, radius=RADIUS, mass=MASS)),
    "bounce times": (bounces, lambda columns: rs.BounceTimes(**columns, radius=RADIUS, mass=MASS)),
    "force history": (force, lambda columns: rs.ForceHistory(**columns, radius=RADIUS, mass=MASS, velocity=1.0)),
    "indentation curve": (curve, lambda columns: rs.IndentationCurve(**columns, profile=rs.Parabola(5e-6))),
}
SPOILED = {
    "exchanged": lambda x, rng: rng.permutation(x),
    "repeated": lambda x, rng: np.repeat(x[: max(1, x.size // 2)], 2),
    "negated": lambda x, rng: -x,
    "scaled": lambda x, rng: x * 10.0 ** rng.uniform(-12.0, 12.0),
    "rounded": lambda x, rng: np.round(x, int(rng.integers(-1, 3))),
    "noise": lambda x, rng: rng.normal(size=x.size) * np.abs(x).max(),
    "hole": lambda x, rng: np.where(rng.random(x.size) < 0.2, rng.choice([np.nan, np.inf, -np.inf, 0.0]), x),
    "backwards": lambda x, rng: x[::-1].copy(),
    "cut": lambda x, rng: x[: int(rng.integers(0, 6))],
    "jitter": lambda x, rng: x * (1.0 + 10.0 ** rng.uniform(-3.0, 0.0) * rng.normal(size=x.size)),
    "outlier": lambda x, rng: np.where(np.arange(x.size) == rng.integers(x.size), 10.0, 1.0) * x,
    "constant": lambda x, rng: np.full(x.size, x[0]),
}


def finite(result: Any) -> bool:
    """Whether all estimates that have a value are finite."""
    values = [parameter.value for parameter in result.parameters.values()]
    return all(value is None or np.isfinite(value) for value in values) and np.isfinite(result.chi2)


def end(kind: str, columns: dict[str, Any], model: Any) -> str:
    """How the identification of a set ends: fitted, refused, failed, or the name of a foreign exception."""
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("error", RuntimeWarning)
            warnings.simplefilter("ignore", rs.RestitutionWarning)
            result = rs.identify(KINDS[kind][1](columns), model, fixed={"poisson_ratio": 0.45})
        return "fitted" if finite(result) else "not finite"
    except rs.InputError as error:
        return "refused" if "\n" not in str(error) else "refused in many lines"
    except rs.SolverError:
        return "failed"
    except Exception as error:  # what this script looks for
        return f"{type(error).__name__}: {error}"


def main(sets: int, seed: int) -> str:
    rng = np.random.default_rng(seed)
    counts: dict[str, Counter[str]] = {kind: Counter() for kind in KINDS}
    longest, faults = 0.0, list[str]()
    for number in track(range(sets), "Sets"):
        kind = str(rng.choice(list(KINDS)))
        columns = KINDS[kind][0](rng)
        ways = rng.choice(list(SPOILED), int(rng.choice([1, 1, 1, 2, 3])))
        for way in ways:
            name = str(rng.choice(list(columns)))
            if columns[name].size:
                columns[name] = SPOILED[str(way)](columns[name], rng)
            if way in ("repeated", "cut"):  # the rows of a table have one length
                size = columns[name].size
                columns = {key: np.resize(value, size) for key, value in columns.items()}
        start = time.process_time()
        outcome = end(kind, columns, rng.choice([rs.standard_solid, rs.kelvin_voigt, rs.maxwell]))
        spent = time.process_time() - start
        longest = max(longest, spent) if number else 0.0
        fault = outcome not in ("fitted", "refused", "failed") or spent > LONGEST
        counts[kind]["fault" if fault else outcome] += 1
        if fault:
            faults.append(f"* set {number}, {kind}, {', '.join(ways)}: {outcome} after {spent:.1f} s")
            print(faults[-1])
    heads = ("fitted", "refused", "failed", "fault")
    rows = "\n".join(f"| {kind} | " + " | ".join(str(c[head]) for head in heads) + " |" for kind, c in counts.items())
    listed = "\n".join(faults) or "No fault."
    return f"""\
# Data that make no sense

Made by `python validation/rubbish.py --sets {sets} --seed {seed}`. A set is a record that was spoiled in one to three
ways. Fits that end do so with finite numbers; a fault is a foreign exception, a warning of NumPy, a number that is not
finite, or more than {LONGEST:.0f} s of processor time.

| data | {" | ".join(heads)} |
|---|---|---|---|---|
{rows}

{listed} The longest set took {longest:.1f} s of processor time.
"""


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--sets", type=int, default=400)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--out", type=Path, default=Path(__file__).with_suffix(".md"))
    arguments = parser.parse_args()
    text = main(arguments.sets, arguments.seed)
    arguments.out.write_text(text, encoding="utf-8")
    print(text)
