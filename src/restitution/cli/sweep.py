"""The commands for many impacts: `sweep`, `plot`, `map` and `surrogate`."""

from __future__ import annotations

import re
import time
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from restitution.cli import tables
from restitution.cli.options import (
    PICTURES,
    Extrapolate,
    Json,
    Outputs,
    Picture,
    Plot,
    Workers,
    argument,
    axes,
    check_target,
    option,
    target,
)  # fmt: skip
from restitution.cli.terminal import BadInput, collected_warnings, progress_bar, report, user_input
from restitution.files import TABLES, write_table

if TYPE_CHECKING:
    import xarray as xr

    from restitution.surrogates.velocity import Surrogate

_RESULTS = (".zarr", *TABLES)
# Places of the quantities of the paper's problem, and their options.
_GROUPS = {"material.poisson_ratio": "nu", "p2": "p2", "p3": "p3"}
_POINTS = 80
# A map is held in memory, and no picture shows more.
_MOST_POINTS = 2000
# A number and its unit.
_UNIT = re.compile(r"[-+]?[\d.]+(?:[eE][-+]?\d+)?\s*(\D.*)")
# An axis is logarithmic where the ratio of its ends is at least this.
_LOG_RATIO = 10.0
# Suffix, default range and tolerance, and columns of a surrogate.
_SAVED = ".json"
_RANGE = ("1e-3", "10")
_RTOL = 1e-6


def sweep(
    file: Annotated[Path, argument("SWEEP.toml", "Case file with axes.")],
    out: Annotated[
        Path,
        option(
            "Zarr store for the results; or a table, .csv or .nc, held in memory.",
            metavar="RESULT.zarr",
            # A store may exist already.
            callback=lambda path: path if path.suffix.lower() == ".zarr" else check_target("--out", path, _RESULTS),
        ),
    ],
    dask: Annotated[
        str | None, option("Dask: 'local', or a scheduler such as tcp://host:8786.", metavar="ADDRESS")
    ] = None,
    workers: Workers = None,
    json: Json = False,
    extrapolate: Extrapolate = False,
) -> None:
    """Compute the impacts of a case file with axes, into a store that can be resumed.

    After Ctrl-C or a crash, the same command continues; at most the unfinished chunks are computed again.
    Example: restitution sweep examples/velocity_sweep.toml --out v.zarr
    """
    with user_input():
        from restitution.case.sweep import read_sweep
        from restitution.doubts import checks
        from restitution.sweeps.run import run

        plan = read_sweep(file)
        is_table = out.suffix.lower() in TABLES
        engine, store = "threads" if dask is None else "dask", None if is_table else out
        # Points done and time: when imports and the store are ready, and at the last report.
        marks: list[tuple[int, float]] = []
        with collected_warnings() as warnings, progress_bar("sweeping", rate="impacts/s") as bar:

            def progress(done: int, total: int) -> None:
                marks[1:] = [(done, time.monotonic())]
                bar(done, total)

            try:
                dataset = run(plan, out=store, engine=engine, cluster=dask, workers=workers, progress=progress)
                _require_known(dataset, out, extrapolate)
                if is_table:
                    write_table(dataset, out)
            except KeyboardInterrupt:
                if not is_table:
                    report("note", f"{out}: the same command resumes")
                raise
    (before, start), (_, end) = marks[0], marks[-1]
    total, seconds = plan.grid.n_points, end - start
    if json:
        content = {"result": str(out), "impacts": total, "from_before": before, "seconds": seconds}
        tables.write_json(content | {"warnings": warnings, "validity": checks(dataset.attrs)})
        return
    resumed = f", {before} of them from before" if before else ""
    # No speed: the start takes most of the time of a short sweep.
    lasted = f"; took {seconds:.1f} s" if total > before else ""
    print(f"{total} impact{'s' if total > 1 else ''} in {out}{resumed}{lasted}")
    report("warning", *warnings)


def plot(
    result: Annotated[Path, argument("RESULT.zarr", "Result of a sweep.")],
    out: Picture = None,
    output: Outputs = None,
    x: Annotated[str | None, option("Axis along the abscissa.", metavar="AXIS")] = None,
    y: Annotated[str | None, option("Axis along the ordinate of a map.", metavar="AXIS")] = None,
    at: Annotated[
        list[str] | None,
        option("Nearest value of an axis to show, e.g. radius=5mm; may be repeated.", metavar="AXIS=VALUE"),
    ] = None,
    json: Json = False,
) -> None:
    """Draw the result of a sweep: curves, contour maps, slices, or distributions of random draws.

    Example: restitution plot v.zarr --output restitution_coefficient
    """
    # The path of the current folder has no name.
    named = result if result.name not in ("", "..") else result.resolve()
    target = out or (named.with_suffix(".png") if named.name else Path("sweep.png"))
    check_target("--out", target, PICTURES)
    with user_input():
        from restitution.doubts import messages
        from restitution.sweeps.store import open_sweep

        dataset = open_sweep(result)
        chosen = dict(_slice(dataset, text) for text in at or ())
        _draw(dataset, target, output or [], list(messages(dataset.attrs).values()), json, x=x, y=y, at=chosen)


def map_(
    x: Annotated[str, option("Abscissa, e.g. velocity=1cm/s:10m/s.", metavar="NAME=LOW:HIGH", autocompletion=axes)],
    y: Annotated[str, option("Ordinate.", metavar="NAME=LOW:HIGH", autocompletion=axes)],
    case: Annotated[Path | None, argument("CASE.toml", "Case file; the paper's problem if not given.")] = None,
    output: Outputs = None,
    fixed: Annotated[
        list[str] | None,
        option(
            "Set another quantity, e.g. nu=0.45; may be repeated.", "--set", metavar="NAME=VALUE", autocompletion=axes
        ),
    ] = None,
    points: Annotated[int, typer.Option(min=2, max=_MOST_POINTS, help="Points along each axis.")] = _POINTS,
    out: Picture = None,
    workers: Workers = None,
    json: Json = False,
    extrapolate: Extrapolate = False,
) -> None:
    """Draw contours of an output over two quantities of a case.

    NAME is a key of the case file, such as velocity or material.density; without a file nu, p2 and p3.
    Example: restitution map examples/epoxy.toml --x velocity=1cm/s:1m/s --y radius=5:20mm
    """
    target = Path("map.png" if case is None else f"{case.stem}-map.png") if out is None else out
    check_target("--out", target, PICTURES)
    with user_input():
        from restitution.case.axes import known_place, read_axis
        from restitution.case.section import read_toml
        from restitution.case.sweep import plan_case
        from restitution.sweeps.grid import Logarithmic
        from restitution.sweeps.run import run

        path = Path("standard solid") if case is None else case
        data = {} if case is None else read_toml(case)
        read: dict[str, Any] = {}
        for option, text in (("--x", x), ("--y", y), *(("--set", text) for text in fixed or ())):
            name, value = _assignment(option, text)
            where = f"{option} {name}"
            place = known_place(where, tuple(name.split(".")))
            if place in read:
                raise BadInput(f"{option} {text}: {name} is given twice")
            if option == "--set":
                read[place] = read_axis(where, place, _plain(value))
            else:
                axis = read_axis(where, place, _range(option, text, value, points))
                if axis.low == axis.high:
                    raise BadInput(f"{option} {text}: low and high must differ")
                low, high = sorted((axis.low, axis.high))
                apart = low > 0.0 and high >= _LOG_RATIO * low
                read[place] = Logarithmic(axis.low, axis.high, axis.n) if apart else axis
        if case is None and (missing := [name for place, name in _GROUPS.items() if place not in read]):
            advice = "must be given, e.g. --set nu=0.45; without a case file, nu, p2 and p3 are needed"
            raise BadInput(f"map: {', '.join(missing)}: {advice}")
        outputs = output or ["restitution_coefficient"]
        plan = plan_case(path, data | {"sweep": {"outputs": outputs}}, read, replace=True)
        with collected_warnings() as warnings, progress_bar("computing", rate="impacts/s") as progress:
            dataset = run(plan, workers=workers, progress=progress)
        _require_known(dataset, target, extrapolate)
        names = list(plan.grid.axes)
        _draw(dataset, target, outputs, warnings, json, x=names[0], y=names[1])


def _require_known(dataset: xr.Dataset, out: Path, extrapolate: bool) -> None:
    """Refuse a result with impacts beyond the times for which the material is known."""
    from restitution.doubts import checks
    from restitution.impact.window import WAY_OUT

    check = checks(dataset.attrs).get("window", {})
    if check.get("exceeded") and not extrapolate:
        stored = f"; {out} is whole, and the same command with it computes nothing again" if out.is_dir() else ""
        raise BadInput(f"{check['message']}; {WAY_OUT}{stored}")


def _draw(
    dataset: xr.Dataset, target: Path, outputs: list[str], warnings: list[str], in_json: bool, **choice: Any
) -> None:
    from restitution.doubts import checks
    from restitution.plot.sweep import plot_sweep

    tables.save_picture(plot_sweep(dataset, outputs, **choice), target)
    if in_json:
        shown = outputs or [str(name) for name in dataset.data_vars if name != "status"]
        content = {"picture": str(target), "outputs": shown, "impacts": dataset["status"].size}
        tables.write_json(content | {"warnings": warnings, "validity": checks(dataset.attrs)})
        return
    print(target)
    report("warning", *warnings)


def _assignment(option: str, text: str) -> tuple[str, str]:
    name, sign, value = text.partition("=")
    if not sign or not name.strip() or not value.strip():
        raise BadInput(f"{option} {text}: must be a name, = and what it is")
    return name.strip(), value.strip()


def _slice(dataset: xr.Dataset, text: str) -> tuple[str, Any]:
    """Return the axis and its value from a text AXIS=VALUE; numbers have units as in case files."""
    from restitution.case.axes import value_in_si
    from restitution.quantities import ALIASES

    given, value = _assignment("--at", text)
    name = ALIASES.get(given, given)
    if name in dataset.coords and dataset[name].dtype.kind == "f":
        number = value_in_si(f"--at {given}", name, _plain(value))
        if not isinstance(number, float):
            raise BadInput(f"--at {text}: must be a number in SI")
        return name, number
    return name, value


def _range(option: str, text: str, value: str, points: int) -> dict[str, Any]:
    ends = [end.strip() for end in value.split(":")]
    if len(ends) != 2 or not all(ends):
        raise BadInput(f"{option} {text}: must be LOW:HIGH")
    low, high = map(_plain, ends)
    if isinstance(low, float) and isinstance(high, str) and (unit := _UNIT.fullmatch(high)):
        # One unit after both ends, as in 0:60degC.
        low = f"{low!r} {unit[1]}"
    return {"linear": [low, high], "n": points}


def _plain(text: str) -> Any:
    try:
        return float(text)
    except ValueError:
        return text


def surrogate(
    source: Annotated[Path, argument("CASE.toml|FILE.json", "Case file, or a saved surrogate.")],
    velocity: Annotated[
        tuple[str, str] | None,
        option("Range of velocities, e.g. 1mm/s 10m/s. Default: 1e-3 10, in m/s.", metavar="LOW HIGH"),
    ] = None,
    rtol: Annotated[float | None, option(f"Largest relative error. Default: {_RTOL:g}.")] = None,
    out: Annotated[Path | None, target("Save it, or a table of it", "--out", _SAVED, *TABLES)] = None,
    at: Annotated[list[str] | None, option("Evaluate it at a velocity; may be repeated.", metavar="VELOCITY")] = None,
    plot: Plot = None,
    json: Json = False,
    workers: Workers = None,
    extrapolate: Extrapolate = False,
) -> None:
    """Replace an impact by an interpolant over its velocity: restitution, contact time and peak force, with an error.

    The case file needs no velocity. Example: restitution surrogate examples/epoxy.toml --velocity 0.1 1 --out e.json
    """
    with user_input():
        from restitution.quantities import VELOCITY
        from restitution.surrogates.velocity import Surrogate

        speeds = [tables.read_quantity("--at", text, VELOCITY) for text in at or ()]
        if source.suffix.lower() == _SAVED:
            for name, value in (("--velocity", velocity), ("--rtol", rtol), ("--out", out)):
                if value is not None:
                    raise BadInput(f"{name}: belongs to a case file; {source} is a surrogate already")
            made, notes = Surrogate.load(source), []
        else:
            low, high = (tables.read_quantity("--velocity", text, VELOCITY) for text in velocity or _RANGE)
            made, notes = build_surrogate(
                source, (low, high), _RTOL if rtol is None else rtol, workers, extrapolate=extrapolate
            )
        rows = [(v, made(v), made.contact_time(v), made.max_force(v)) for v in speeds]
    if out is not None:
        if out.suffix.lower() == _SAVED:
            made.save(out)
        else:
            write_table(made.sample(), out)
    pieces = made.pieces.edges.size - 1
    if json:
        names = ("velocity", *made.error)
        content = {"velocity": list(made.velocity), "rtol": made.rtol, "error": made.error, "pieces": pieces}
        content |= {"values": [dict(zip(names, row, strict=True)) for row in rows], "warnings": made.warnings}
        tables.write_json(content | {"validity": made.validity.to_dict()})
    else:
        tables.show(made.summary(str(out or source), speeds))
        report("note", *notes)
    if plot is not None:
        tables.save_picture(made.plot(), plot)


def build_surrogate(
    path: Path, velocity: tuple[float, float], rtol: float, workers: int | None = None, *, extrapolate: bool = False
) -> tuple[Surrogate, list[str]]:
    """Return the surrogate of a case, and notes on its materials."""
    from restitution.case.impact import notes_on, read_case
    from restitution.surrogates.build import surrogate

    with progress_bar("building") as progress:
        impact = read_case(path, any_velocity=True).over(velocity)
        made = surrogate(impact, velocity, rtol, extrapolate=extrapolate, workers=workers, progress=progress)
    return made, notes_on(impact.material, impact.counter_material)
