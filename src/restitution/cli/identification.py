"""The commands from data to a material: `identify`, `design` and `moduli`."""

from __future__ import annotations

import math
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from restitution.cli import tables
from restitution.cli.options import CaseFile, Json, Plot, argument, option, target
from restitution.cli.terminal import BadInput, collected_warnings, progress_bar, report, user_input

if TYPE_CHECKING:
    from collections.abc import Mapping

    from restitution.identification.result import Identification
    from restitution.identification.spectrum import Spectrum
    from restitution.identification.uncertainty import Estimate

_ESTIMATE = ("quantity", "estimate", "standard error", "95 % interval")


def identify(
    case: CaseFile,
    json: Json = False,
    plot: Plot = None,
    out: Annotated[Path | None, target("Write the material as a part of a case file", "--out", ".toml")] = None,
    profile: Annotated[
        bool, typer.Option("--profile", help="Compute all intervals from profiles; this takes longer.")
    ] = False,
) -> None:
    """Find the material from measured impacts, indentations and moduli, with errors.

    The case file contains a model and the names of the data files. The first line is how well the data determine the
    parameters. Example: restitution identify examples/identification/balls.toml --plot fit.png
    """
    with user_input(), collected_warnings() as warnings:
        from restitution.case.identification import SPECTRUM, read_identification

        problem = read_identification(case)
        if problem.section.model == SPECTRUM and out is not None:
            raise BadInput(f"--out {out}: a spectrum has no constants; give another model")
        with progress_bar("identifying", begin="identifying") as progress:
            found: Any = problem.solve(profiles=True if profile else None, progress=progress)
            content = found.to_dict()
        with progress_bar("comparing models", begin="comparing models") as progress:
            compared = problem.compare(progress)
    doubts = [*dict.fromkeys((*getattr(found, "warnings", ()), *warnings))]
    if json:
        content |= {"warnings": doubts} | ({} if compared is None else {"comparison": compared.to_dict()})
        tables.write_json(content)
    else:
        show = _print_spectrum if problem.section.model == SPECTRUM else _print
        show(found, problem.title or str(case))
        if compared is not None:
            print(f"\n{compared}")
        report("warning", *doubts)
    if out is not None:
        found.to_toml(out)
    if plot is not None:
        from restitution.plot.identification import overview

        tables.save_picture(overview(found), plot)


def _print_spectrum(found: Spectrum, title: str) -> None:
    import numpy as np

    print(title, *found.statements, sep="\n")
    low, high = found.window
    table = found.moduli(np.geomspace(0.5 * low, 2.0 * high, 9))
    tables.print_dataset("Reduced modulus", table[["storage_modulus", "loss_modulus", "loss_tangent"]])


def _print(found: Identification, title: str) -> None:
    from restitution.identification.uncertainty import headline

    print(title, headline(found.parameters), sep="\n")
    for line in found.statements:
        print(line)
    print()
    for words, group in (
        ("Best determined quantities", found.functionals),
        (f"Parameters of the model {found.problem.space.model.__name__}", found.parameters),
        ("Unknowns of the measurement", found.nuisances),
    ):
        if group:
            tables.print_rows(words, _ESTIMATE, _rows(group))
    print(f"{found.goodness_of_fit}; runs test {found.runs_test:.2g}")
    print("A good chi2 does not prove the model: compare several with compare = [...] in [identification].")


def _rows(group: Mapping[str, Estimate]) -> list[tuple[str, ...]]:
    from restitution.display import scaled_unit
    from restitution.identification.uncertainty import CLOSE

    rows: list[tuple[str, ...]] = []
    for name, one in group.items():
        known = [abs(x) for x in (one.value, *one.interval) if x is not None and math.isfinite(x) and x != 0.0]
        factor, unit = scaled_unit(abs(one.value) if one.value else max(known, default=1.0), one.unit)

        def shown(x: float | None, factor: float = factor, digits: int = 4) -> str:
            return "-" if x is None or not math.isfinite(x) else f"{x * factor:.{digits}g}"

        ends = " to ".join(
            "open" if is_open else shown(end) for end, is_open in zip(one.interval, one.open_ends, strict=True)
        )
        digits = 4 if one.factor <= CLOSE else 2
        estimate = f"{shown(one.value, digits=digits)} {unit}".strip() if one.determined else "not determined"
        known_ends = any(map(math.isfinite, one.interval)) or any(one.open_ends)
        rows.append((name, estimate, shown(one.standard_error, digits=2), ends if known_ends else "-"))
    return rows


def design(case: CaseFile, json: Json = False, plot: Plot = None) -> None:
    """Choose the impacts that determine a material best, from a guess of it.

    The case file has the guess in its section material and the possible impacts in its section design.
    Example: restitution design examples/identification/design.toml
    """
    with user_input():
        from restitution.case.identification import read_design

        problem = read_design(case)
        with progress_bar("choosing impacts", begin="choosing impacts"):
            found = problem.solve()
    if json:
        tables.write_json(found.to_dict())
    else:
        tables.print_dataset(problem.title or str(case), found.to_dataset())
        print(*found.statements, sep="\n")
    if plot is not None:
        tables.save_picture(found.plot(), plot)


def moduli(
    file: Annotated[Path, argument("FILE.csv", "Measured impacts: velocity, restitution_coefficient, contact_time.")],
    radius: Annotated[str | None, option("Radius of the ball, if no column has it.", metavar="LENGTH")] = None,
    mass: Annotated[str | None, option("Mass of the ball, if no column has it.", metavar="MASS")] = None,
    dma: Annotated[Path | None, option("Measured moduli, to draw with the bounces.", metavar="FILE")] = None,
    nu: Annotated[float, typer.Option("--nu", help="Constant Poisson ratio that converts the moduli of --dma.")] = 0.5,
    json: Json = False,
    plot: Plot = None,
) -> None:
    """Convert each bounce to one point of a table of storage and loss modulus over frequency.

    The moduli need a column contact_time or max_force; without it, only the loss tangent is known.
    Example: restitution moduli examples/identification/balls.csv --plot moduli.png
    """
    with user_input(), collected_warnings() as warnings:
        from restitution.case.observations import read_observations
        from restitution.checks import within
        from restitution.identification.effective_moduli import effective_moduli
        from restitution.identification.rebounds import Rebounds
        from restitution.material.fit import DynamicTable
        from restitution.material.readers import read_material
        from restitution.quantities import LENGTH, MASS

        within("nu", nu, -1.0, 0.5)
        given: dict[str, Any] = {}
        for name, text, dimension in (("radius", radius, LENGTH), ("mass", mass, MASS)):
            if text is not None:
                given[name] = tables.read_quantity(f"--{name}", text, dimension)
        table = None
        if dma is not None and not isinstance(table := read_material(dma), DynamicTable):
            raise BadInput(f"--dma {dma}: must hold storage and loss moduli over frequency")
        if dma is not None and plot is None:
            raise BadInput("--dma: give --plot FILE as well")
        balls = read_observations(file, kind="rebounds", **given)
        assert isinstance(balls, Rebounds)
        found = effective_moduli(balls)
    if json:
        columns = {str(name): one.values.tolist() for name, one in found.to_dataset().data_vars.items()}
        tables.write_json(columns | {"statements": list(found.statements)})
    else:
        tables.print_dataset(str(file), found.to_dataset())
        print(*found.statements, sep="\n")
        report("warning", *warnings)
    if plot is not None:
        tables.save_picture(found.plot(table, poisson_ratio=nu), plot)
