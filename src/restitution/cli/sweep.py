"""The commands for many impacts: `sweep`, `plot`, `map` and `surrogate`."""

from __future__ import annotations

import re
import time
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

import restitution as rs
from restitution.cli import tables
from restitution.cli import terminal as cli
from restitution.cli.terminal import argument, completed, option, quantity, target
from restitution.files import TABLES, write_table
from restitution.units import VELOCITY

if TYPE_CHECKING:
    import xarray as xr


_RESULTS = (".zarr", *TABLES)
# Quantities of the paper's problem, and their options.
_GROUPS = {"poisson_ratio": "nu", "p2": "p2", "p3": "p3"}
_POINTS = 80
# Tolerance of a map of adhesive impacts whose file has none.
_RTOL_OF_ADHESION = 1e-3
# A map is held in memory, and no picture shows more.
_MOST_POINTS = 2000
# A number and its unit.
_UNIT = re.compile(r"[-+]?[\d.]+(?:[eE][-+]?\d+)?\s*(\D.*)")
# An axis is logarithmic where the ratio of its ends is at least this.
_LOG_RATIO = 10.0
_AXES = completed("quantities.INPUTS", "quantities.ALIASES", sign="=")
# Suffix, default range and tolerance, and columns of a surrogate.
_SAVED = ".json"
_RANGE = (1e-3, 10.0)


def sweep(
    file: Annotated[Path, argument("SWEEP.toml", "Case file with axes.")],
    out: Annotated[Path, target("Store for the results, or a table, which is held in memory", "--out", *_RESULTS)],
    dask: Annotated[str | None, option("Dask: 'local', or a scheduler such as tcp://host:8786.", "ADDRESS")] = None,
    workers: cli.Workers = None,
    plot: cli.Plot = None,
    points: cli.Points = None,
    json: cli.Json = False,
    extrapolate: cli.Extrapolate = False,
) -> None:
    """Compute the impacts of a case file with axes, into a store that can be resumed.

    After Ctrl-C or a crash, the same command continues; at most the unfinished chunks are computed again.
    Example: restitution sweep examples/velocity_sweep.toml --out v.zarr
    """
    from restitution.case.sweep import read_sweep
    from restitution.sweeps.run import run

    if points is not None and plot is None:
        raise cli.BadInput("--points: give --plot FILE as well")
    measured = None if points is None else rs.read_points(points)
    plan = read_sweep(file)
    is_table = out.suffix.lower() in TABLES
    engine, store = "threads" if dask is None else "dask", None if is_table else out
    # Points done and time: when imports and the store are ready, and at the last report.
    marks: list[tuple[int, float]] = []
    with cli.collected_warnings() as warnings, cli.progress_bar("sweeping", rate="impacts/s") as bar:

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
                cli.report("note", f"{out}: the same command resumes")
            raise
    if plot is not None:
        tables.save_picture(rs.plot_sweep(dataset, points=measured), plot)
    (before, start), (_, end) = marks[0], marks[-1]
    total, seconds = plan.grid.n_points, end - start
    resumed = f", {before} of them from before" if before else ""
    # No speed: the start takes most of the time of a short sweep.
    lasted = f"; took {seconds:.1f} s" if total > before else ""
    line = f"{total} impact{'s' if total > 1 else ''} in {out}{resumed}{lasted}"
    content: dict[str, Any] = {"result": str(out), "impacts": total, "from_before": before, "seconds": seconds}
    if plot is not None:
        content["picture"] = str(plot)
    _answer(line, content, dataset, warnings, json)


def plot(
    result: Annotated[Path, argument("RESULT.zarr", "Result of a sweep.")],
    out: cli.Picture = None,
    output: cli.Outputs = None,
    x: Annotated[str | None, option("Axis along the abscissa.", "AXIS")] = None,
    y: Annotated[str | None, option("Axis along the ordinate of a map.", "AXIS")] = None,
    at: Annotated[
        list[str] | None, option("Nearest value of an axis to show, e.g. radius=5mm; may be repeated.", "AXIS=VALUE")
    ] = None,
    points: cli.Points = None,
    json: cli.Json = False,
) -> None:
    """Draw the result of a sweep: curves, contour maps, slices, or distributions of random draws.

    Example: restitution plot v.zarr --output restitution_coefficient
    """
    # The path of the current folder has no name.
    named = result if result.name not in ("", "..") else result.resolve()
    picture = out or (named.with_suffix(".png") if named.name else Path("sweep.png"))
    cli.check_target("--out", picture, cli.PICTURES)
    from restitution.tally import messages

    dataset = rs.open_sweep(result)
    choice: dict[str, Any] = {"at": dict(_slice(dataset, text) for text in at or ())}
    if points is not None:
        choice["points"] = rs.read_points(points)
    _draw(dataset, picture, output or [], list(messages(dataset.attrs).values()), json, x=x, y=y, **choice)


def map_(
    x: Annotated[str, option("Abscissa, e.g. velocity=1cm/s:10m/s.", "NAME=LOW:HIGH", autocompletion=_AXES)],
    y: Annotated[str, option("Ordinate.", "NAME=LOW:HIGH", autocompletion=_AXES)],
    case: Annotated[Path | None, argument("CASE.toml", "Case file; the paper's problem if not given.")] = None,
    output: cli.Outputs = None,
    fixed: Annotated[
        list[str] | None,
        option("Set another quantity, e.g. nu=0.45; may be repeated.", "NAME=VALUE", "--set", autocompletion=_AXES),
    ] = None,
    points: Annotated[int, typer.Option(min=2, max=_MOST_POINTS, help="Points along each axis.")] = _POINTS,
    out: cli.Picture = None,
    workers: cli.Workers = None,
    json: cli.Json = False,
    extrapolate: cli.Extrapolate = False,
) -> None:
    """Draw contours of an output over two quantities of a case.

    NAME is a key of the case file, such as velocity or material.density; without a file nu, p2 and p3.
    Example: restitution map examples/epoxy.toml --x velocity=1cm/s:1m/s --y radius=5:20mm
    """
    picture = out or Path("map.png" if case is None else f"{case.stem}-map.png")
    cli.check_target("--out", picture, cli.PICTURES)
    from restitution.case.axes import quantity_name, read_axis
    from restitution.case.section import read_toml
    from restitution.case.sweep import plan_case
    from restitution.quantities import SWEEP_OUTPUTS, choice
    from restitution.sweeps.run import run

    outputs = [choice("--output", name, SWEEP_OUTPUTS) for name in output or ["restitution_coefficient"]]
    path = Path("standard solid") if case is None else case
    data = {} if case is None else read_toml(case)
    read: dict[str, Any] = {}
    for flag, text in (("--x", x), ("--y", y), *(("--set", text) for text in fixed or ())):
        key, value = _assignment(flag, text)
        where = f"{flag} {key}"
        name = quantity_name(where, tuple(key.split(".")))
        if name in read:
            raise cli.BadInput(f"{flag} {text}: {key} is given twice")
        if flag == "--set":
            read[name] = read_axis(where, name, _plain(value))
        else:
            axis = read_axis(where, name, _range(flag, text, value, points))
            if axis.low == axis.high:
                raise cli.BadInput(f"{flag} {text}: low and high must differ")
            low, high = sorted((axis.low, axis.high))
            apart = low > 0.0 and high >= _LOG_RATIO * low
            read[name] = rs.Logarithmic(axis.low, axis.high, axis.n) if apart else axis
    if case is None and (missing := [key for name, key in _GROUPS.items() if name not in read]):
        advice = "must be given, e.g. --set nu=0.45; without a case file, nu, p2 and p3 are needed"
        raise cli.BadInput(f"map: {', '.join(missing)}: {advice}")
    if "adhesion" in data or "work" in read:
        # A picture needs no more, and the time of an impact grows with the digits.
        data = data | {"solver": {"rtol": _RTOL_OF_ADHESION} | data.get("solver", {})}
    plan = plan_case(path, data | {"sweep": {"outputs": outputs}}, read, replace=True)
    with cli.collected_warnings() as warnings, cli.progress_bar("computing", rate="impacts/s") as progress:
        dataset = run(plan, workers=workers, progress=progress)
    _require_known(dataset, picture, extrapolate)
    names = list(plan.grid.axes)
    _draw(dataset, picture, outputs, warnings, json, x=names[0], y=names[1])


def _require_known(dataset: xr.Dataset, out: Path, extrapolate: bool) -> None:
    """Refuse a result with impacts beyond the times for which the material is known."""
    from restitution.impact.window import WAY_OUT
    from restitution.tally import checks

    check = checks(dataset.attrs).get("window", {})
    if check.get("exceeded") and not extrapolate:
        stored = f"; {out} is whole, and the same command with it computes nothing again" if out.is_dir() else ""
        raise cli.BadInput(f"{check['message']}; {WAY_OUT}{stored}")


def _answer(line: str, content: dict[str, Any], dataset: xr.Dataset, warnings: list[str], in_json: bool) -> None:
    """Print a line and the warnings, or the content with the validity of the impacts as JSON."""
    from restitution.tally import checks

    if in_json:
        tables.write_json(content | {"warnings": warnings, "validity": checks(dataset.attrs)})
    else:
        print(line)
        cli.report("warning", *warnings)


def _draw(
    dataset: xr.Dataset, path: Path, outputs: list[str], warnings: list[str], in_json: bool, **choice: Any
) -> None:
    tables.save_picture(rs.plot_sweep(dataset, outputs, **choice), path)
    shown = outputs or [str(name) for name in dataset.data_vars if name != "status"]
    content = {"picture": str(path), "outputs": shown, "impacts": dataset["status"].size}
    _answer(str(path), content, dataset, warnings, in_json)


def _assignment(option: str, text: str) -> tuple[str, str]:
    name, sign, value = text.partition("=")
    if not sign or not name.strip() or not value.strip():
        raise cli.BadInput(f"{option} {text}: must be a name, = and what it is")
    return name.strip(), value.strip()


def _slice(dataset: xr.Dataset, text: str) -> tuple[str, Any]:
    """Return the axis and its value from a text AXIS=VALUE; numbers have units as in case files."""
    from restitution.case.axes import value_in_si
    from restitution.quantities import ALIASES

    axis, value = _assignment("--at", text)
    name = ALIASES.get(axis, axis)
    if name in dataset.coords and dataset[name].dtype.kind == "f":
        number = value_in_si(f"--at {axis}", name, _plain(value))
        if not isinstance(number, float):
            raise cli.BadInput(f"--at {text}: must be a number in SI")
        return name, number
    return name, value


def _range(option: str, text: str, value: str, points: int) -> dict[str, Any]:
    ends = [end.strip() for end in value.split(":")]
    if len(ends) != 2 or not all(ends):
        raise cli.BadInput(f"{option} {text}: must be LOW:HIGH")
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
        tuple[float, float] | None,
        quantity("--velocity", VELOCITY, "Range of velocities. Default: 1mm/s 10m/s.", "LOW HIGH"),
    ] = None,
    rtol: Annotated[
        float | None,
        option("Largest relative error, 1e-10 to 1e-2. Default: 1e-6, with friction 1e-5, with adhesion 1e-4."),
    ] = None,
    out: Annotated[Path | None, target("Save it, or a table of it", "--out", _SAVED, *TABLES)] = None,
    at: Annotated[
        list[float] | None, quantity("--at", VELOCITY, "Evaluate it at a velocity; may be repeated.")
    ] = None,
    plot: cli.Plot = None,
    json: cli.Json = False,
    workers: cli.Workers = None,
    extrapolate: cli.Extrapolate = False,
) -> None:
    """Replace an impact by an interpolant over its velocity: restitution, contact time and peak force, with an error.

    The case file needs no velocity. Example: restitution surrogate examples/epoxy.toml --velocity 0.1 1 --out e.json
    """
    if source.suffix.lower() == _SAVED:
        for name, value in (("--velocity", velocity), ("--rtol", rtol), ("--out", out)):
            if value is not None:
                raise cli.BadInput(f"{name}: belongs to a case file; {source} is a surrogate already")
        result, notes = rs.Surrogate.load(source), []
    else:
        result, notes = build_surrogate(source, velocity or _RANGE, rtol, workers, extrapolate=extrapolate)
    rows = [(v, result(v), result.contact_time(v), result.max_force(v)) for v in at or ()]
    if out is not None:
        if out.suffix.lower() == _SAVED:
            result.save(out)
        else:
            write_table(result.sample(), out)
    if json:
        from restitution.surrogates.velocity import OUTPUTS

        values = [dict(zip(("velocity", *OUTPUTS), row, strict=True)) for row in rows]
        tables.write_json(result.to_dict() | {"pieces": result.pieces.edges.size - 1, "values": values})
    else:
        tables.show(result.summary(str(out or source), at or []))
        cli.report("note", *notes)
    if plot is not None:
        tables.save_picture(result.plot(), plot)


def build_surrogate(
    path: Path, velocity: tuple[float, float], rtol: float | None = None, workers: int | None = None, *,
    extrapolate: bool = False,
) -> tuple[rs.Surrogate, list[str]]:  # fmt: skip
    """Return the surrogate of a case, and notes on its materials."""
    with cli.progress_bar("building") as progress:
        problem = rs.read_case(path, any_velocity=True)
        impact = problem.over(velocity)
        result = rs.surrogate(impact, velocity, rtol, extrapolate=extrapolate, workers=workers, progress=progress)
    return result, problem.notes(impact)
