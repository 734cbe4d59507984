"""The command `restitution material`: its arguments alone, so that help loads nothing heavy."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from restitution.cli.options import Json, Plot, argument, library_names, option


def material(
    source: Annotated[
        str | None,
        argument("FILE|NAME", "File, or material of the library.", autocompletion=library_names),
    ] = None,
    list_: Annotated[bool, typer.Option("--list", help="List the materials of the library.")] = False,
    at: Annotated[
        str | None, option('Temperature of the moduli, e.g. "20 degC" or 293.', metavar="TEMPERATURE")
    ] = None,
    shift: Annotated[
        Path | None, option("Shift factors over temperature, for a file of moduli.", metavar="FILE")
    ] = None,
    material_name: Annotated[str | None, option("Which material of a deck that has several.", metavar="NAME")] = None,
    json: Json = False,
    plot: Plot = None,
) -> None:
    """Read a material from a file or the library, and show its data, fit and moduli.

    Relaxation and DMA tables are fitted by a Prony series. Tables of Prony terms and of shift factors, the decks of
    ANSYS and Abaqus, and the materials of a case file are read too.
    """
    from restitution.cli import material_report

    material_report.show(source, list_, at, shift, material_name, json, plot)
