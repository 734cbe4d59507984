"""The command `restitution material`: its arguments alone, so that help loads nothing heavy."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from restitution.cli import completion, tables


def material(
    source: Annotated[
        str | None,
        typer.Argument(
            metavar="FILE|NAME",
            help="File, or material of the library.",
            show_default=False,
            autocompletion=completion.library_names,
        ),
    ] = None,
    list_: Annotated[bool, typer.Option("--list", help="List the materials of the library.")] = False,
    at: Annotated[
        str | None,
        typer.Option(
            metavar="TEMPERATURE",
            help='Temperature of the moduli, e.g. "20 degC" or 293.',
            show_default=False,
        ),
    ] = None,
    shift: Annotated[
        Path | None,
        typer.Option(
            metavar="FILE", help="Shift factors over temperature, for a file of moduli.", show_default=False
        ),
    ] = None,
    material_name: Annotated[
        str | None,
        typer.Option(metavar="NAME", help="Which material of a deck that has several.", show_default=False),
    ] = None,
    json: tables.Json = False,
    plot: Annotated[
        Path | None,
        typer.Option(metavar="FILE", help="Draw the moduli: .png, .pdf or .svg.", show_default=False),
    ] = None,
) -> None:
    """Read a material, whatever the kind of its file, and say what it is.

    Relaxation and DMA tables are fitted by a Prony series. Tables of Prony terms and of shift factors and the
    decks of ANSYS and Abaqus are read too. Of a case file, its materials.
    """
    from restitution.cli import material_report

    material_report.show(source, list_, at, shift, material_name, json, plot)
