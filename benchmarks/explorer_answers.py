"""Processor time of the answers of the explorer to random inputs: `python benchmarks/explorer_answers.py [SEED ...]`.

Run it with `OPENBLAS_NUM_THREADS=1`, as waiting threads count too, and with `tests` in `PYTHONPATH`.

Half of the states are drawn over all sliders and ends of ranges, with series of up to 50 terms and inputs that are
refused; half lie within 1.5 decades of the defaults. No answer finds a result of an earlier one. A time above 60 ms is
the least one of three, as other programs disturb it. The script writes `tables/explorer_answers.md`.
"""

from __future__ import annotations

import random
import sys
import time
import warnings
from pathlib import Path
from typing import Any

import numpy as np
from machine import describe

import random_messages
from restitution.explorer import answers
from restitution.explorer.inputs import inputs
from restitution.explorer.server import Request, answer

HERE = Path(__file__).resolve().parent
TABLE = HERE / "tables" / "explorer_answers.md"
KINDS = ("impact", "velocity", "surface", "bounces", "indentation", "download")
STATES, UNMEASURED, SUSPECT = 2000, 100, 0.06


def usual(rng: random.Random) -> dict[str, Any]:
    """Random state within 1.5 decades of the defaults, with series of 1 to 50 terms."""
    state: dict[str, Any] = {}
    for key, entry in inputs().items():
        if entry.options:
            state[key] = rng.choice(entry.options).value
        elif entry.slider and entry.slider.logarithmic and entry.default > 0.0:
            value = entry.default * 10.0 ** rng.uniform(-1.5, 1.5)
            state[key] = min(max(value, entry.slider.low), entry.slider.high)
        elif entry.slider and key != "impact.external_force":
            state[key] = rng.choice((entry.default, rng.uniform(entry.slider.low, entry.slider.high)))
    for part in ("shear", "bulk"):
        terms = rng.choice((1, 3, 10, 50))
        state[f"material.{part}.branch_moduli"] = [10.0 ** rng.uniform(5.0, 8.0) for _ in range(terms)]
        state[f"material.{part}.relaxation_times"] = sorted(10.0 ** rng.uniform(-7.0, 3.0) for _ in range(terms))
    return state


def cost(kind: str, state: dict[str, Any]) -> float:
    """Processor time [s] of one answer."""
    request, least = Request(0, kind, {"state": state, "what": "case"}), np.inf
    for _ in range(3):
        answers._solved.cache_clear()
        answers._case.cache_clear()
        started = time.process_time()
        answer(request)
        least = min(least, time.process_time() - started)
        if least < SUSPECT:
            break
    return least


def main() -> None:
    """Measure and write the table."""
    warnings.simplefilter("ignore")
    rows = ["| answer | median | 99 % | longest |", "|---|---:|---:|---:|"]
    results: dict[str, list[float]] = {kind: [] for kind in KINDS}
    for seed in map(int, sys.argv[1:] or ["1", "2"]):
        rng = random.Random(seed)
        for n in range(UNMEASURED + STATES):
            state = usual(rng) if n % 2 else random_messages.state(rng)
            for kind in KINDS:
                spent = cost(kind, state)
                if n >= UNMEASURED:
                    results[kind].append(spent)
    for kind, times in results.items():
        median, high, longest = 1e3 * np.quantile(times, [0.5, 0.99, 1.0])
        rows.append(f"| {kind} | {median:.1f} ms | {high:.0f} ms | {longest:.0f} ms |")
    about = f"{len(results['impact'])} states; {describe().lines()[0]}."
    TABLE.write_text("\n".join(["", *rows, "", about, ""]), encoding="utf-8")
    print(TABLE.read_text(encoding="utf-8"))


if __name__ == "__main__":
    main()
