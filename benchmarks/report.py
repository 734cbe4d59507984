"""Tables and pictures of the results, for the page on benchmarks."""

from __future__ import annotations

import math
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from restitution.plot import style

MICRO = 1e6
ERRORS = (1e-3, 1e-4, 1e-6, 1e-8)
"""Errors of e at which the methods are compared."""

TARGETS = {
    ("paper's plane", 1e-8): (25.0, 60.0),
    ("wide domain", 1e-8): (27.0, None),
    ("10 to 20 terms", 1e-8): (130.0, None),
}
"""Largest mean and worst time [us] that are asked of the package."""

COLOURS = {
    "this package": style.BLACK,
    "Radau": style.BLUE,
    "LSODA": style.GREEN,
    "DOP853": style.VERMILION,
    "elements": style.PURPLE,
    "elements, compiled": style.SKY_BLUE,
    "LAMMPS, its own law": style.ORANGE,
}


def write(results: dict[str, Any], tables: Path, pictures: Path) -> None:
    """Write a table or picture for everything that was measured."""
    tables.mkdir(parents=True, exist_ok=True)
    pictures.mkdir(parents=True, exist_ok=True)
    texts = {
        "machine": (machine, ("machine",)),
        "domains": (domains, ("domains",)),
        "profiles": (profiles, ("profiles",)),
        "costs": (costs, ("terms", "tolerances", "sizes", "threads")),
        "start": (start, ("start",)),
        "equal_accuracy": (equal_accuracy, ("ours", "scipy", "elements")),
        "lammps": (lammps, ("lammps", "domains", "surrogate")),
    }
    for name, (table, needed) in texts.items():
        if all(key in results for key in needed):
            (tables / f"{name}.md").write_text(table(results) + "\n", encoding="utf-8")
    drawn = {
        "times": (draw_times, ("domains",)),
        "costs": (draw_costs, ("terms", "tolerances", "sizes", "threads")),
        "precision": (draw_precision, ("ours", "scipy", "elements")),
    }
    for name, (draw, needed) in drawn.items():
        if all(key in results for key in needed):
            style.save_figure(draw(results), pictures / f"{name}.png")


def _table(header: Sequence[str], rows: Sequence[Sequence[str]]) -> str:
    lines = [header, ["---"] * len(header), *rows]
    return "\n".join("| " + " | ".join(cells) + " |" for cells in lines)


def _us(seconds: float) -> str:
    return f"{MICRO * seconds:.1f}" if seconds < 1e-3 else f"{MICRO * seconds:.0f}"


def _power(value: float) -> str:
    return f"{value:.0e}".replace("e-0", "e-").replace("e+0", "e")


def _duration(seconds: float) -> str:
    for scale, unit in ((1.0, "s"), (1e3, "ms"), (1e6, "µs")):
        if seconds * scale >= 1.0:
            return f"{seconds * scale:.3g} {unit}"
    return f"{seconds * 1e9:.3g} ns"


def machine(results: dict[str, Any]) -> str:
    """Description of the machine and its load."""
    result = results["machine"]
    versions = dict(result["versions"])
    if "lammps" in results:
        versions["LAMMPS"] = str(results["lammps"]["version"])
    load = max(results["load"].values())
    words = ", ".join(f"{name} {number}" for name, number in versions.items())
    minutes = results["seconds"] / 60.0
    return (
        f"{result['processor']}, {result['cores']} cores, {result['system']}; {words}. "
        f"{minutes:.0f} minutes in all; at most {load:.1f} processes were running or waiting, as the mean of "
        "a minute, this one included."
    )


def domains(results: dict[str, Any]) -> str:
    """Table of mean, median and worst time and of the errors."""
    rows = []
    for row in results["domains"]:
        times = np.array(row["times"])
        mean, worst = TARGETS.get((row["domain"], row["rtol"]), (None, None))
        rows.append([
            row["domain"], _power(row["rtol"]), f"{row['impacts']:,}".replace(",", " "),
            _us(row["mean"]) + (f" (≤ {mean:g})" if mean else ""), _us(float(np.median(times))),
            _us(float(np.quantile(times, 0.99))), _us(float(times.max())) + (f" (≤ {worst:g})" if worst else ""),
            f"{row['error']:.1e}", f"{row['share']:.2f}",
        ])  # fmt: skip
    header = (
        "domain", "rtol", "impacts", "mean, µs", "median, µs", "99 %, µs", "worst, µs",
        "largest error of e", "over rtol max(e, 1e-3)",
    )  # fmt: skip
    return _table(header, rows)


def profiles(results: dict[str, Any]) -> str:
    """Table of the mean times of other profiles over that of the parabola."""
    parabola = results["profiles"][0]["seconds"]
    rows = []
    for row in results["profiles"]:
        table = _duration(row["table"]) if row["table"] else ""
        rows.append(
            [
                row["profile"],
                _us(row["seconds"]),
                f"{row['seconds'] / parabola:.2f}",
                table,
                f"{row['error']:.1e}",
            ]
        )
    return _table(("profile", "mean, µs", "over the parabola", "table, in each call", "largest error of e"), rows)


def line_through(x: Any, y: Any) -> tuple[float, float, float]:
    """Offset and slope of the line with the smallest relative deviations from positive points; largest deviation."""
    weights = 1.0 / np.asarray(y)
    design = np.stack([np.ones(len(x)), np.asarray(x)], 1) * weights[:, None]
    (offset, slope), *_ = np.linalg.lstsq(design, np.ones(len(x)), rcond=None)
    return float(offset), float(slope), float(np.abs(design @ [offset, slope] - 1.0).max())


def term_cost(results: dict[str, Any]) -> tuple[Any, Any, tuple[float, float, float]]:
    """Terms, times [us] and the line through them."""
    x = np.array([row["terms"] for row in results["terms"]])
    y = MICRO * np.array([row["seconds"] for row in results["terms"]])
    return x, y, line_through(x, y)


def tolerance_cost(results: dict[str, Any]) -> tuple[Any, Any, tuple[float, float, float]]:
    """Digits log10(1/rtol), times [us] and the line through them."""
    x = -np.log10([row["rtol"] for row in results["tolerances"]])
    y = MICRO * np.array([row["seconds"] for row in results["tolerances"]])
    return x, y, line_through(x, y)


def size_cost(results: dict[str, Any]) -> tuple[Any, Any, tuple[float, float, float]]:
    """Points, times [s] and the line through them."""
    x = np.array([float(row["points"]) for row in results["sizes"]])
    y = np.array([row["seconds"] for row in results["sizes"]])
    return x, y, line_through(x, y)


def costs(results: dict[str, Any]) -> str:
    """Four tables: over terms, tolerance, points, threads."""
    n, y, (offset, slope, off) = term_cost(results)
    terms = _table(
        ("terms", *(f"{x}" for x in n)),
        [["mean, µs", *(f"{t:.1f}" for t in y)]],
    )
    parts = [
        f"**Terms of the Prony series.** Within {100 * off:.0f} % the cost is {offset:.1f} µs + {slope:.2f} µs "
        "per term.",
        terms,
    ]
    digits, y, (offset, slope, off) = tolerance_cost(results)
    # The last tolerance is the reference for the errors of the others.
    measured = results["tolerances"][:-1]
    parts += [
        f"**Tolerance.** Within {100 * off:.0f} % the cost is {offset:.1f} µs + {slope:.2f} µs per digit of rtol.",
        _table(
            ("rtol", *(_power(10.0**-x) for x in digits)),
            [
                ["mean, µs", *(f"{t:.1f}" for t in y)],
                ["largest error of e", *(f"{row['error']:.0e}" for row in measured), "reference"],
                ["over rtol max(e, 1e-3)", *(f"{row['share']:.2f}" for row in measured), ""],
            ],
        ),
    ]
    points, y, (offset, slope, off) = size_cost(results)
    parts += [
        f"**Points of one call.** Within {100 * off:.0f} % a call costs {1e3 * offset:.2f} ms + "
        f"{MICRO * slope:.1f} µs "
        "per point.",
        _table(
            ("points", *(_power(x) for x in points)),
            [
                ["time of a call, one thread", *(_duration(t) for t in y)],
                ["µs per point", *(_us(t / x) for x, t in zip(points, y, strict=True))],
            ],
        ),
    ]
    rows = results["threads"]
    alone = rows[0]["seconds"]
    parts += [
        f"**Threads.** A call of {rows[0]['points']:,} points:".replace(",", " "),
        _table(
            ("threads", *(str(row["workers"]) for row in rows)),
            [
                ["time of a call, s", *(f"{row['seconds']:.3f}" for row in rows)],
                ["speed relative to one thread", *(f"{alone / row['seconds']:.2f}" for row in rows)],
            ],
        ),
    ]
    return "\n\n".join(parts)


def start(results: dict[str, Any]) -> str:
    """Table of the times until the first result."""
    result = results["start"]
    rows = [
        [
            row["subject"],
            f"{row['first']:.1f} (≤ 15)",
            f"{row['first_processor']:.1f}",
            f"{row['later']:.2f} (≤ 1)",
        ]
        for row in result["processes"]
    ]
    header = ("whole process", "empty cache, s", "processor time, s", "later processes, s")
    return (
        f"The import of `restitution` takes {1e3 * result['import']:.1f} ms more than that of NumPy (≤ 500 ms); "
        f"a process that imports only NumPy takes {result['numpy']:.2f} s.\n\n{_table(header, rows)}"
    )


def _fastest(runs: list[dict[str, Any]], error: float) -> Any:
    """Time of each impact with the loosest tolerance that is within an error; NaN if there is none."""
    seconds, errors = (np.array([run[key] for run in runs], float) for key in ("seconds", "errors"))
    # An error may be small by chance: all tighter tolerances must also be within it, or fail.
    stays = np.logical_and.accumulate((~(errors > error))[::-1])[::-1]
    met = stays & np.isfinite(errors)
    first = np.argmax(met, axis=0)
    times = np.take_along_axis(seconds, first[None], axis=0)[0]
    return np.where(met.any(axis=0), times, np.nan)


def _ours(results: dict[str, Any], error: float) -> Any:
    """Time of each impact with rtol = error."""
    run = min(results["ours"], key=lambda run: abs(math.log(run["rtol"] / error)))
    return np.array(run["seconds"])


def _mean(times: Any) -> float:
    return float(np.mean(times))


def equal_accuracy(results: dict[str, Any]) -> str:
    """Table of the mean times of all methods at equal errors, over those of this package on the same impacts."""
    rows = []
    for error in ERRORS:
        ours = _ours(results, error)
        rows.append([_power(error), "this package", _duration(_mean(ours)), "1", f"{ours.size}"])
        others = {method: _fastest(runs, error) for method, runs in results["scipy"].items()}
        for name, impacts in results["elements"].items():
            if str(error) in impacts[0]:
                met = [row[str(error)] for row in impacts]
                others[name] = np.array([row["seconds"] if row else np.nan for row in met])
        for name, times in others.items():
            solved = np.isfinite(times)
            label = f"the paper's {name}" if name in results["elements"] else f"SciPy {name}"
            cells = ["", label]
            if solved.any():
                ratios = times[solved] / ours[solved]
                mean = _mean(times[solved])
                numbers = (mean / _mean(ours[solved]), ratios.min(), ratios.max())
                often, least, most = (f"{number:,.0f}".replace(",", " ") for number in numbers)
                cells += [_duration(mean), f"{often} ({least} to {most})"]
            else:
                cells += ["", ""]
            rows.append([*cells, f"{int(solved.sum())}"])
    count = len(results["elements"]["elements"])
    header = (
        "error of e ≤",
        "method",
        "mean time of an impact",
        "relative to this package (range)",
        f"solved, of {count}",
    )
    return _table(header, rows)


def lammps(results: dict[str, Any]) -> str:
    """Table of the times of a collision in LAMMPS and in this package."""
    result = results["lammps"]
    rows = [
        [
            f"LAMMPS, `{run['style']}`, {run['steps']} steps", "none", _us(run["seconds"]), f"{run['error']:.1e}",
        ]
        for run in result["runs"]
    ]  # fmt: skip
    rows += [
        [f"this package, rtol {_power(run['rtol'])}", "Kelvin-Voigt", _us(run["seconds"]), f"{run['error']:.1e}"]
        for run in result["ours"]
    ]  # fmt: skip
    plane = next(row for row in results["domains"] if row["domain"] == "paper's plane" and row["rtol"] == 1e-8)
    rows.append(["this package, rtol 1e-8", "standard solids, the plane", _us(plane["mean"]), f"{plane['error']:.1e}"])
    for row in result["surrogates"]:
        words = "a surrogate with errors below 1e-8, with its construction", "the same, without its construction"
        rows += [
            [name, row["material"], f"{MICRO * row[key]:.2f}", f"{row['error']:.1e}"]
            for name, key in zip(words, ("seconds", "again"), strict=True)
        ]
    query = results["surrogate"]
    rows.append(
        [
            "the shipped interpolant",
            "standard solids, the plane",
            f"{MICRO * query['seconds']:.2f}",
            f"{query['error']:.1e}",
        ]
    )
    table = _table(("", "memory", "µs per collision", "error of e"), rows)
    return (
        f"{result['pairs']} pairs, b = {result['loss']:g}; e is {result['law']:.6f} by the law of LAMMPS and "
        f"{result['exact']:.6f} for Kelvin-Voigt bodies.\n\n{table}"
    )


def draw_times(results: dict[str, Any]) -> Any:
    """Picture of the share of the impacts that take at most a given time."""
    with style.context():
        figure = style.new_figure(style.PAGE_WIDTH, 2.9)
        axes = figure.subplots()
        dashes = {1e-8: "-", 1e-9: "--"}
        for row, colour in zip(
            results["domains"], (style.BLUE, style.SKY_BLUE, style.VERMILION, style.GREEN), strict=True
        ):
            times = np.sort(MICRO * np.array(row["times"]))
            share = 100.0 * (np.arange(times.size) + 0.5) / times.size
            axes.plot(
                times,
                share,
                dashes[row["rtol"]],
                color=colour,
                label=f"{row['domain']}, rtol {_power(row['rtol'])}",
            )
        axes.set(xscale="log", xlabel="time of an impact [µs]", ylabel="share that takes no longer [%]")
        _plain_ticks(axes.xaxis, (5, 10, 20, 50, 100, 200))
        axes.grid(visible=True)
        axes.legend(loc="center left", bbox_to_anchor=(1.0, 0.5))
        return figure


def _plain_ticks(axis: Any, ticks: Sequence[float]) -> None:
    from matplotlib.ticker import NullFormatter, NullLocator

    axis.set_ticks(ticks, [f"{tick:g}" for tick in ticks])
    axis.set_minor_locator(NullLocator())
    axis.set_minor_formatter(NullFormatter())


def draw_costs(results: dict[str, Any]) -> Any:
    """Picture of the cost over terms, digits and points with fitted lines."""
    with style.context():
        figure = style.new_figure(style.PAGE_WIDTH, 2.5)
        first, second, third = figure.subplots(1, 3)
        for axes, cost, name in (
            (first, term_cost, "terms of the Prony series"),
            (second, tolerance_cost, "digits, $\\log_{10}(1/\\mathrm{rtol})$"),
        ):
            x, y, (offset, slope, _) = cost(results)
            axes.plot(x, y, "o", markersize=4)
            ends = np.array([min(x), max(x)])
            axes.plot(ends, offset + slope * ends, "-", color=style.GREY, linewidth=1.0)
            axes.set(xlabel=name, ylabel="time of an impact [µs]", ylim=(0.0, None))
        x, y, (offset, slope, _) = size_cost(results)
        third.plot(x, y, "o", markersize=4)
        ends = np.logspace(np.log10(min(x)), np.log10(max(x)), 50)
        third.plot(ends, offset + slope * ends, "-", color=style.GREY, linewidth=1.0)
        third.set(xscale="log", yscale="log", xlabel="points of one call", ylabel="time of the call [s]")
        for axes in (first, second, third):
            axes.grid(visible=True)
        return figure


def draw_precision(results: dict[str, Any]) -> Any:
    """Picture of the largest error over the mean time of all methods on the same impacts."""
    with style.context():
        figure = style.new_figure(style.PAGE_WIDTH, 3.4)
        axes = figure.subplots()

        def plot(name: str, seconds: Sequence[float], errors: Sequence[float], marker: str) -> None:
            axes.plot(seconds, errors, marker, color=COLOURS[name], markersize=4, label=name)

        runs = [run for run in results["ours"] if max(run["errors"]) > 0.0]
        plot("this package", *_precision(runs), "o-")
        for method, granular in results["scipy"].items():
            plot(method, *_precision(granular), "s-")
        for name, impacts in results["elements"].items():
            points = [
                (np.mean([row[key]["seconds"] for row in met]), max(row[key]["error"] for row in met))
                for key in impacts[0]
                if (met := [row for row in impacts if row[key]])
            ]
            if points:
                plot(name, *map(list, zip(*points, strict=True)), "^-")
        if "lammps" in results:
            granular = [run for run in results["lammps"]["runs"] if run["style"] == "granular"]
            plot("LAMMPS, its own law", [r["seconds"] for r in granular], [r["error"] for r in granular], "D-")
        axes.set(xscale="log", yscale="log", xlabel="mean time of an impact [s]", ylabel="largest error of $e$")
        axes.grid(visible=True)
        axes.legend(loc="center left", bbox_to_anchor=(1.0, 0.5))
        return figure


def _precision(runs: list[dict[str, Any]]) -> tuple[list[float], list[float]]:
    """Mean time and largest error of each run that solved all impacts."""
    whole = [run for run in runs if np.all(np.isfinite(np.array(run["errors"], float)))]
    return [_mean(run["seconds"]) for run in whole], [max(run["errors"]) for run in whole]
