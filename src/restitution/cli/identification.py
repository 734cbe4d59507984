"""The commands from data to a material: `bounces`, `identify`, `design` and `moduli`."""

from __future__ import annotations

import math
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

import restitution as rs
from restitution.cli import tables
from restitution.cli import terminal as cli
from restitution.cli.terminal import argument, option, quantity, target
from restitution.units import DENSITY, LENGTH, MASS, TIME

if TYPE_CHECKING:
    from collections.abc import Mapping

    from restitution.identification.spectrum import Spectrum
    from restitution.identification.uncertainty import Estimate

_ESTIMATE = ("quantity", "estimate", "standard error", "95 % interval")


def identify(
    case: cli.CaseFile,
    json: cli.Json = False,
    plot: cli.Plot = None,
    out: Annotated[Path | None, target("Write the material as a part of a case file", "--out", ".toml")] = None,
    profile: Annotated[
        bool, typer.Option("--profile", help="Compute all intervals from profiles; this takes longer.")
    ] = False,
) -> None:
    """Find the material from measured impacts, indentations and moduli, with errors.

    The case file contains a model and the names of the data files. The first line is how well the data determine the
    parameters. Example: restitution identify examples/identification/balls.toml --plot fit.png
    """
    with cli.user_input(), cli.collected_warnings() as warnings:
        from restitution.case.identification import SPECTRUM, read_identification

        problem = read_identification(case)
        if problem.section.model == SPECTRUM and out is not None:
            raise cli.BadInput(f"--out {out}: a spectrum has no constants; give another model")
        with cli.progress_bar("identifying", begin="identifying") as progress:
            result: Any = problem.solve(profiles=True if profile else None, progress=progress)
            content = result.to_dict()
        with cli.progress_bar("comparing models", begin="comparing models") as progress:
            compared = problem.compare(progress)
    doubts = [*dict.fromkeys((*getattr(result, "warnings", ()), *warnings))]
    if json:
        content |= {"warnings": doubts} | ({} if compared is None else {"comparison": compared.to_dict()})
        tables.write_json(content)
    else:
        show = _print_spectrum if problem.section.model == SPECTRUM else _print
        show(result, problem.title or str(case))
        if compared is not None:
            print(f"\n{compared}")
        cli.report("warning", *doubts)
    if out is not None:
        result.to_toml(out)
    if plot is not None:
        tables.save_picture(result.plot(), plot)


def _print_spectrum(spectrum: Spectrum, title: str) -> None:
    import numpy as np

    print(title, *spectrum.statements, sep="\n")
    low, high = spectrum.window
    table = spectrum.moduli(np.geomspace(0.5 * low, 2.0 * high, 9))
    tables.print_dataset("Reduced modulus", table[["storage_modulus", "loss_modulus", "loss_tangent"]])


def _print(result: rs.Identification, title: str) -> None:
    from restitution.identification.uncertainty import headline

    print(title, headline(result.parameters), sep="\n")
    for line in result.statements:
        print(line)
    print()
    for words, group in (
        ("Best determined quantities", result.functionals),
        (f"Parameters of the model {result.problem.space.model.__name__}", result.parameters),
        ("Unknowns of the measurement", result.nuisances),
    ):
        if group:
            tables.print_rows(words, _ESTIMATE, _rows(group))
    print(f"{result.goodness_of_fit}; runs test {result.runs_test:.2g}")
    print("A good chi2 does not prove the model: compare several with compare = [...] in [identification].")


def _rows(group: Mapping[str, Estimate]) -> list[tuple[str, ...]]:
    from restitution.identification.uncertainty import CLOSE
    from restitution.units import scaled_unit

    rows: list[tuple[str, ...]] = []
    for name, estimate in group.items():
        sizes = [
            abs(x) for x in (estimate.value, *estimate.interval) if x is not None and math.isfinite(x) and x != 0.0
        ]
        factor, unit = scaled_unit(abs(estimate.value) if estimate.value else max(sizes, default=1.0), estimate.unit)

        def shown(x: float | None, factor: float = factor, digits: int = 4) -> str:
            return "-" if x is None or not math.isfinite(x) else f"{x * factor:.{digits}g}"

        ends = " to ".join(
            "open" if is_open else shown(end)
            for end, is_open in zip(estimate.interval, estimate.open_ends, strict=True)
        )
        digits = 4 if estimate.factor <= CLOSE else 2
        value = f"{shown(estimate.value, digits=digits)} {unit}".strip() if estimate.determined else "not determined"
        known_ends = any(map(math.isfinite, estimate.interval)) or any(estimate.open_ends)
        rows.append((name, value, shown(estimate.standard_error, digits=2), ends if known_ends else "-"))
    return rows


def bounces(
    file: Annotated[
        Path, argument("FILE", "Sound in WAV, labels of Audacity, or a table of times, heights or speeds.")
    ],
    radius: Annotated[float | None, quantity("--radius", LENGTH, "Radius of the ball.")] = None,
    mass: Annotated[
        float | None, quantity("--mass", MASS, "Mass of the ball; with the radius, the drag of air.")
    ] = None,
    contact_time: Annotated[
        float | None, quantity("--contact-time", TIME, "Contact time of the first bounce that has an e.")
    ] = None,
    air_density: Annotated[
        float, quantity("--air-density", DENSITY, "Density of the air, 1.2 kg/m^3 by default; 0 for no drag.")
    ] = 1.2,  # kg/m^3
    json: cli.Json = False,
    plot: cli.Plot = None,
) -> None:
    """Find the bounces of a ball in a sound: e and loss tangent of each, with errors.

    With mass, radius and contact time the moduli follow too. Tables have a column time, or the columns drop_height
    and rebound_height, or v_in and v_out.
    Example: restitution bounces examples/identification/bounces.wav --plot sound.png
    """
    with cli.user_input(), cli.collected_warnings() as warnings:
        result = rs.read_bounces(file, radius=radius, mass=mass, contact_time=contact_time, air_density=air_density)
    tables.answer(result, str(file), json=json, plot=plot)
    cli.report("warning", *warnings)


def design(case: cli.CaseFile, json: cli.Json = False, plot: cli.Plot = None) -> None:
    """Choose the impacts that determine a material best, from a guess of it.

    The case file has the guess in its section material and the possible impacts in its section design.
    Example: restitution design examples/identification/design.toml
    """
    with cli.user_input():
        from restitution.case.identification import read_design

        problem = read_design(case)
        with cli.progress_bar("choosing impacts", begin="choosing impacts"):
            result = problem.solve()
    if json:
        tables.write_json(result)
    else:
        tables.print_dataset(problem.title or str(case), result.to_dataset(), *result.statements)
    if plot is not None:
        tables.save_picture(result.plot(), plot)


def moduli(
    file: Annotated[Path, argument("FILE.csv", "Measured impacts: velocity, restitution_coefficient, contact_time.")],
    radius: Annotated[float | None, quantity("--radius", LENGTH, "Radius of the ball, if no column has it.")] = None,
    mass: Annotated[float | None, quantity("--mass", MASS, "Mass of the ball, if no column has it.")] = None,
    dma: Annotated[Path | None, option("Measured moduli, to draw with the bounces.", "FILE")] = None,
    nu: Annotated[
        float, typer.Option("--nu", help="Constant Poisson ratio, in [-1, 0.5], that converts the moduli of --dma.")
    ] = 0.5,
    json: cli.Json = False,
    plot: cli.Plot = None,
) -> None:
    """Convert each bounce to one point of a table of storage and loss modulus over frequency.

    The moduli need a column contact_time or max_force; without it, only the loss tangent is known.
    Example: restitution moduli examples/identification/balls.csv --plot moduli.png
    """
    with cli.user_input(), cli.collected_warnings() as warnings:
        from restitution.checks import within

        within("nu", nu, -1.0, 0.5)
        table = None
        if dma is not None and not isinstance(table := rs.read_material(dma), rs.DynamicTable):
            raise cli.BadInput(f"--dma {dma}: must hold storage and loss moduli over frequency")
        if dma is not None and plot is None:
            raise cli.BadInput("--dma: give --plot FILE as well")
        sizes: dict[str, Any] = {"radius": radius, "mass": mass}
        sizes = {name: size for name, size in sizes.items() if size is not None}
        balls = rs.read_observations(file, kind="rebounds", **sizes)
        assert isinstance(balls, rs.Rebounds)
        result = rs.effective_moduli(balls)
    columns = result.to_dataset()
    if json:
        data = {str(name): column.values for name, column in columns.data_vars.items()}
        tables.write_json(data | {"statements": result.statements})
    else:
        tables.print_dataset(str(file), columns, *result.statements)
        cli.report("warning", *warnings)
    if plot is not None:
        tables.save_picture(result.plot(table, poisson_ratio=nu), plot)
