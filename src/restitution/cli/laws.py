"""The commands for other people's codes: `export`."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

from restitution.cli import tables
from restitution.cli.options import CaseFile, check_target, option
from restitution.cli.sweep import build_surrogate
from restitution.cli.terminal import BadInput, report, user_input
from restitution.files import TABLES, write_table

# Ends of the names of cards, with the time at which their elastic constants hold.
_CARDS = {".inp": "after a long time", ".txt": "at the first instant", ".mac": "at the first instant"}
_RTOL = 1e-6


def export(
    case: CaseFile,
    to: Annotated[
        Path,
        option(
            "File, whose end decides: .csv or .nc, a table of e, contact time and largest force over the velocity; "
            ".inp, cards of Abaqus; .txt or .mac, cards of ANSYS.",
            metavar="FILE",
            callback=lambda path: check_target("--to", path, (*TABLES, *_CARDS)),
        ),
    ],
    velocity: Annotated[
        tuple[str, str] | None, option("Velocities of a table, e.g. 1mm/s 10m/s.", metavar="LOW HIGH")
    ] = None,
) -> None:
    """Write an impact, or its materials, for another program."""
    with user_input():
        if to.suffix.lower() in TABLES:
            if velocity is None:
                raise BadInput(f"--to {to}: give --velocity LOW HIGH as well")
            _write_outcomes(case, to, velocity)
            return
        if velocity is not None:
            raise BadInput(f"--velocity {' '.join(velocity)}: has no meaning for {to}; it belongs to a table")
        _write_materials(case, to)


def _write_outcomes(case: Path, to: Path, velocity: tuple[str, str]) -> None:
    """Write e, contact time and largest force over the velocity."""
    from restitution.quantities import VELOCITY

    low, high = (tables.read_quantity("--velocity", text, VELOCITY) for text in velocity)
    made, notes = build_surrogate(case, (low, high), _RTOL)
    write_table(made.sample(), to)
    errors = ", ".join(f"{name.replace('_', ' ')} {error:.1e}" for name, error in made.error.items())
    print(f"{to}: {low:g} to {high:g} m/s; largest relative error: {errors}")
    report("warning", *made.warnings)
    report("note", *notes)


def _write_materials(case: Path, to: Path) -> None:
    """Write the cards of the materials that deform."""
    from restitution.case.impact import notes_on, read_case
    from restitution.material.cards import write_material

    impact = read_case(case).impact
    materials = list(dict.fromkeys(one for one in (impact.material, impact.counter_material) if one is not None))
    write_material(materials, to)
    count = f"{len(materials)} material{'s' * (len(materials) > 1)}"
    print(f"{to}: {count} in SI units; E and nu are those {_CARDS[to.suffix.lower()]}")
    report("note", *notes_on(impact.material, impact.counter_material))
