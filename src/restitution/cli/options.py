"""Options and arguments that several commands share, and how the shell completes them."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from tempfile import TemporaryFile
from typing import Annotated, Any

import typer

from restitution.cli.terminal import BadInput
from restitution.files import TABLES


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


def check_target(option: str, path: Path | None, suffixes: tuple[str, ...]) -> Path | None:
    """Refuse, before any work is done, a file that could not be written in the end."""
    if path is None:
        return None
    if path.suffix.lower() not in suffixes:
        raise BadInput(f"{option} {path}: must end in {_either(suffixes)}")
    if not path.parent.is_dir():
        raise BadInput(f"{option} {path}: no such folder: {path.parent}")
    if path.is_dir():
        raise BadInput(f"{option} {path}: is a folder")
    try:
        # Permissions alone do not show it: nobody writes to /proc.
        with TemporaryFile(dir=path.parent):
            return path
    except OSError:
        raise BadInput(f"{option} {path}: nothing can be written to the folder {path.parent}") from None


def target(words: str, name: str, *suffixes: str) -> Any:
    """Option of a file that the command writes."""
    words = f"{words}: {_either(suffixes)}."
    return option(words, name, metavar="FILE", callback=lambda path: check_target(name, path, suffixes))


def _either(choices: Sequence[str]) -> str:
    *most, last = choices
    return f"{', '.join(most)} or {last}" if most else last


Extrapolate = Annotated[
    bool,
    typer.Option("--extrapolate", help="Go beyond the times for which the material is known, with a warning."),
]
PICTURES = (".png", ".pdf", ".svg")
CaseFile = Annotated[Path, argument("CASE.toml", "Case file.")]
Json = Annotated[bool, typer.Option("--json", help="Print JSON, in SI, in place of text.")]
JsonWithoutUnits = Annotated[bool, typer.Option("--json", help="Print JSON in place of text.")]
Plot = Annotated[Path | None, target("Draw the result", "--plot", *PICTURES)]
Picture = Annotated[Path | None, target("Picture", "--out", *PICTURES)]
History = Annotated[
    Path | None, target("Write depth, velocity, force and contact radius over time", "--history", *TABLES)
]
Outputs = Annotated[
    list[str] | None, option("Output to show; may be repeated.", "--output", metavar="NAME", autocompletion=_outputs)
]
Workers = Annotated[int | None, typer.Option(min=1, help="Threads or processes; all cores if not given.")]
