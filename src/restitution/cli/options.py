"""Options and arguments that several commands share, and how the shell completes them."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Any

import typer


def option(words: str, *names: str, **settings: Any) -> Any:
    """Option with its help, without its default."""
    return typer.Option(*names, help=words, show_default=False, **settings)


def argument(metavar: str, words: str, **settings: Any) -> Any:
    """Argument with its help, without its default."""
    return typer.Argument(metavar=metavar, help=words, show_default=False, **settings)


def library_names(incomplete: str) -> list[str]:
    """Names of materials of the library."""
    from restitution.material import library

    return [name for name in library.names() if name.startswith(incomplete)]


def _outputs(incomplete: str) -> list[str]:
    from restitution.quantities import SWEEP_OUTPUTS

    return [name for name in SWEEP_OUTPUTS if name.startswith(incomplete)]


def axes(incomplete: str) -> list[str]:
    """Names of quantities that an axis may set, with the sign that follows."""
    from restitution.quantities import ALIASES, INPUTS

    return [f"{name}=" for name in (*INPUTS, *ALIASES) if name.startswith(incomplete)]


CaseFile = Annotated[Path, argument("CASE.toml", "Case file.")]
Json = Annotated[bool, typer.Option("--json", help="Print JSON, in SI, in place of the table.")]
Plot = Annotated[Path | None, option("Draw the result: .png, .pdf or .svg.", "--plot", metavar="FILE")]
Picture = Annotated[Path | None, option("Picture: .png, .pdf or .svg.", "--out", metavar="FILE")]
History = Annotated[
    Path | None,
    option("Write depth, velocity, force and contact radius over time: .nc or .csv.", "--history", metavar="FILE"),
]
Outputs = Annotated[
    list[str] | None,
    option("Output to show; may be repeated.", "--output", metavar="NAME", autocompletion=_outputs),
]
Workers = Annotated[int | None, typer.Option(min=1, help="Threads or processes; all cores if not given.")]
