"""The command `restitution surrogate`: an interpolant over the velocity is built, saved, evaluated."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

from restitution.cli import tables
from restitution.cli.options import Json, Plot, Workers, argument, option, target
from restitution.cli.terminal import BadInput, progress_bar, report, user_input
from restitution.files import TABLES, write_table

if TYPE_CHECKING:
    from restitution.case.impact import Case
    from restitution.impact.problem import Impact
    from restitution.surrogates.velocity import Surrogate

_SAVED = ".json"
_RANGE = ("1e-3", "10")
_RTOL = 1e-6
_COLUMNS = ("velocity [m/s]", "e", "contact time [s]", "largest force [N]")


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
) -> None:
    """Replace an impact by an interpolant over its velocity: restitution, contact time and peak force, with an error.

    The velocity of the case file does not matter.
    """
    with user_input():
        from restitution.quantities import VELOCITY

        speeds = [tables.read_quantity("--at", text, VELOCITY) for text in at or ()]
        if source.suffix.lower() == _SAVED:
            made, notes = _saved(source, {"--velocity": velocity, "--rtol": rtol, "--out": out}), []
        else:
            low, high = (tables.read_quantity("--velocity", text, VELOCITY) for text in velocity or _RANGE)
            made, notes = _build(source, (low, high), _RTOL if rtol is None else rtol, workers)
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
        span = f"{made.velocity[0]:g} to {made.velocity[1]:g} m/s in {pieces} piece{'s' * (pieces > 1)}"
        print(f"{out or source}: {span}, rtol {made.rtol:g}")
        errors = ", ".join(f"{name.replace('_', ' ')} {error:.1e}" for name, error in made.error.items())
        print(f"largest error: {errors}")
        if rows:
            tables.print_rows("", _COLUMNS, [tuple(f"{value:.8g}" for value in row) for row in rows])
        report("warning", *made.warnings)
        report("note", *notes)
    if plot is not None:
        tables.save_picture(made.plot(), plot)


def _saved(path: Path, options: dict[str, Any]) -> Surrogate:
    from restitution.surrogates.velocity import Surrogate

    for name, value in options.items():
        if value is not None:
            raise BadInput(f"{name}: belongs to a case file; {path} is a surrogate already")
    return Surrogate.load(path)


def _build(path: Path, velocity: tuple[float, float], rtol: float, workers: int | None) -> tuple[Surrogate, list[str]]:
    """Return the surrogate of a case, and notes on its materials."""
    from restitution.case.impact import notes_on, read_case
    from restitution.surrogates.build import surrogate

    case = read_case(path)
    with progress_bar("building") as progress:
        impact = _impact(case, velocity)
        made = surrogate(impact, velocity, rtol, workers=workers, progress=progress)
    return made, notes_on(impact.material, impact.counter_material)


def _impact(case: Case, velocity: tuple[float, float]) -> Impact:
    """Impact of a case, whose fractional models hold for the contact times of all velocities."""
    if not case.sections.needs_window:
        return case.impact
    from restitution.impact.problem import for_contact

    return for_contact(lambda window: replace(case.sections.build(window), velocity=list(velocity)))
