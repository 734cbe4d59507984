"""The command `restitution benchmark`: how fast impacts are solved on this machine."""

from __future__ import annotations

import json as json_text
import sys
from typing import TYPE_CHECKING, Annotated, Any

import typer

from restitution.cli import presentation
from restitution.cli.patience import progress_bar

if TYPE_CHECKING:
    from restitution.benchmark.machine import Machine
    from restitution.benchmark.summary import Summary

_COLUMNS = ("problem", "rtol", "mean [us]", "median [us]", "worst [us]", "error of e", "error/tolerance")


def benchmark(
    json: presentation.Json = False,
    quick: Annotated[bool, typer.Option("--quick", help="Fewer impacts, for a first look.")] = False,
) -> None:
    """Measure how long an impact takes on this machine: mean, median and worst, and beside SciPy.

    On one thread, in its own processor time, so that other programs disturb little; the errors are against rtol 1e-11.
    """
    from restitution.benchmark.machine import describe
    from restitution.benchmark.summary import FULL, QUICK, measure

    with progress_bar("measuring") as progress:
        found = measure(QUICK if quick else FULL, progress)
    if json:
        sys.stdout.write(json_text.dumps(_content(found, describe()), indent=2, allow_nan=False) + "\n")
    else:
        _print(found, describe())


def _content(found: Summary, machine: Machine) -> dict[str, Any]:
    """Times in s."""
    speeds = [
        {"problem": problem, "rtol": rtol} | one._asdict() for (problem, rtol), one in found.speeds.items()
    ]
    return {"speeds": speeds} | {
        "cores": found.cores,
        "mean_on_all_cores": found.parallel,
        "mean_by_scipy": found.reference,
        "error_by_scipy": found.reference_error,
        "mean_of_the_same": found.reference_same,
        "machine": machine._asdict(),
        "version": presentation.version(),
    }


def _print(found: Summary, machine: Machine) -> None:
    rows = [
        (
            problem, f"{rtol:g}", *(f"{1e6 * seconds:.1f}" for seconds in (one.mean, one.median, one.worst)),
            f"{one.error:.1e}", f"{one.share:.2f}",
        )
        for (problem, rtol), one in found.speeds.items()
    ]  # fmt: skip
    presentation.print_rows("\n".join(machine.lines()), _COLUMNS, rows)
    (first, *_) = found.speeds.values()
    if found.cores > 1:
        print(
            f"paper's plane on {found.cores} cores: {1e6 * found.parallel:.1f} us an impact, "
            f"{first.mean / found.parallel:.2f} times as many in a second as on one"
        )
    print(
        f"the same equations by SciPy's solve_ivp, Radau: {1e3 * found.reference:.0f} ms an impact for an error of "
        f"{found.reference_error:.1e}, {found.reference / found.reference_same:.0f} times as long"
    )
