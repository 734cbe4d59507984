"""The commands for other codes: `export` and `calibrate`."""

from __future__ import annotations

from dataclasses import replace
from json import dumps
from pathlib import Path
from typing import Annotated, Any, NamedTuple

from restitution.cli import tables
from restitution.cli.options import CaseFile, Extrapolate, Json, Plot, Workers, check_target, option
from restitution.cli.sweep import build_surrogate
from restitution.cli.terminal import BadInput, compilation, report, user_input
from restitution.files import TABLES, whole_file, write_table

# Ends of the names of contact laws.
_LAWS = (".h", ".json")
# Ends of the names of cards, with the time at which their elastic constants hold.
_CARDS = {".inp": "after a long time", ".txt": "at the first instant", ".mac": "at the first instant"}
_RTOL = 1e-6
# Velocities to which terms of a law are fitted.
_POINTS = 9


def export(
    case: CaseFile,
    to: Annotated[
        Path,
        option(
            "File, whose end decides: .h or .json, the contact law with memory, in C or as numbers; .csv or .nc, a "
            "table of e, contact time and largest force over the velocity; .inp, cards of Abaqus; .txt or .mac, cards "
            "of ANSYS.",
            metavar="FILE",
            callback=lambda path: check_target("--to", path, (*_LAWS, *TABLES, *_CARDS)),
        ),
    ],
    velocity: Annotated[
        tuple[str, str] | None, option("Velocities of a table, or of --terms, e.g. 1mm/s 10m/s.", metavar="LOW HIGH")
    ] = None,
    terms: Annotated[
        int | None, option("Terms of a contact law, fitted to the contacts; all if not given.", min=1)
    ] = None,
    json: Json = False,
    extrapolate: Extrapolate = False,
) -> None:
    """Write an impact, its contact law or its materials for another program.

    Example: restitution export examples/epoxy.toml --to epoxy.inp
    """
    with user_input():
        suffix = to.suffix.lower()
        if terms is not None and suffix not in _LAWS:
            raise BadInput(f"--terms {terms}: has no meaning for {to}; it belongs to a contact law, .h or .json")
        if suffix in TABLES:
            if velocity is None:
                raise BadInput(f"--to {to}: give --velocity LOW HIGH as well")
            done = _write_outcomes(case, to, velocity, extrapolate)
        elif velocity is not None and terms is None:
            given = " ".join(velocity)
            raise BadInput(f"--velocity {given}: has no meaning for {to}; it belongs to a table or --terms")
        elif suffix in _LAWS:
            done = _write_law(case, to, velocity, terms, extrapolate)
        else:
            done = _write_materials(case, to)
    if json:
        tables.write_json({"file": str(to), **done.numbers, "warnings": done.warnings, "notes": done.notes})
        return
    print(f"{to}: {done.words}")
    report("warning", *done.warnings)
    report("note", *done.notes)


class _Export(NamedTuple):
    """What a command wrote, in words and in numbers, with its warnings and notes."""

    words: str
    numbers: dict[str, Any]
    warnings: list[str]
    notes: list[str]


def _write_law(
    case: Path, to: Path, velocity: tuple[str, str] | None, terms: int | None, extrapolate: bool
) -> _Export:
    """Write the contact law with memory."""
    import numpy as np

    from restitution.case.impact import read_case
    from restitution.impact.window import require_known, validity_of
    from restitution.law.law import contact_law
    from restitution.quantities import VELOCITY
    from restitution.surrogates.velocity import velocity_range

    problem = read_case(case, any_velocity=velocity is not None)
    impact = problem.impact
    if velocity is not None:
        low, high = (tables.read_quantity("--velocity", text, VELOCITY) for text in velocity)
        impact = problem.over((low, high))
        speeds = np.geomspace(*velocity_range((low, high)), _POINTS)
        impact = replace(impact, velocity=speeds)
    require_known(impact, extrapolate=extrapolate)
    law = contact_law(impact)
    law = law if terms is None else law.reduced(terms, extrapolate=extrapolate)
    if to.suffix.lower() == ".h":
        law.to_c(to)
    else:
        series = law.modulus
        content = {
            "format": "restitution contact law", "version": tables.version(), "units": "SI",
            "profile": repr(law.impact.profile), "max_nodes": law.max_nodes,
            "equilibrium_modulus": series.equilibrium_modulus, "branch_moduli": series.branch_moduli.tolist(),
            "relaxation_times": series.relaxation_times.tolist(), "parallel_viscosity": series.parallel_viscosity,
            "restitution_error": law.restitution_error,
        }  # fmt: skip
        with whole_file(to) as partial:
            partial.write_text(dumps(content, indent=1) + "\n", encoding="utf-8")
    count = law.modulus.n_branches
    error = f", error of e {law.restitution_error:.1e}" if terms else ""
    words = f"contact law of {count} term{'s' * (count != 1)}, {law.state_size} numbers a contact{error}"
    numbers = {"terms": count, "state_size": law.state_size, "restitution_error": law.restitution_error}
    return _Export(words, numbers, validity_of(impact).warnings, problem.notes(impact))


def _write_outcomes(case: Path, to: Path, velocity: tuple[str, str], extrapolate: bool) -> _Export:
    """Write e, contact time and largest force over the velocity."""
    from restitution.quantities import VELOCITY

    low, high = (tables.read_quantity("--velocity", text, VELOCITY) for text in velocity)
    made, notes = build_surrogate(case, (low, high), _RTOL, extrapolate=extrapolate)
    write_table(made.sample(), to)
    errors = ", ".join(f"{name.replace('_', ' ')} {error:.1e}" for name, error in made.error.items())
    low, high = made.velocity
    words = f"{low:g} to {high:g} m/s; largest relative error: {errors}"
    return _Export(words, {"velocity": [low, high], "error": made.error}, made.warnings, notes)


def _write_materials(case: Path, to: Path) -> _Export:
    """Write the cards of the materials that deform."""
    from restitution.case.impact import notes_on, read_case
    from restitution.material.cards import lost_shift, write_material

    impact = read_case(case, any_velocity=True).impact
    materials = list(dict.fromkeys(one for one in (impact.material, impact.counter_material) if one is not None))
    write_material(materials, to)
    count = f"{len(materials)} material{'s' * (len(materials) > 1)}"
    notes = [*notes_on(impact.material, impact.counter_material), *filter(None, map(lost_shift, materials))]
    names = [one.name for one in materials]
    return _Export(
        f"{count} in SI units; E and nu are those {_CARDS[to.suffix.lower()]}", {"materials": names}, [], notes
    )


_TARGETS = (
    "lammps-viscoelastic, lammps-tsuji, lammps-coeff-restitution, mercury-bshp, yade-mindlin, liggghts, kratos-dem, "
    "mujoco-solref or rebound"
)


def _targets(incomplete: str) -> list[str]:
    from restitution.calibration.calibrate import TARGETS

    return [name for name in TARGETS if name.startswith(incomplete)]


def calibrate(
    case: CaseFile,
    target: Annotated[str, option(f"Law of the code: {_TARGETS}.", metavar="NAME", autocompletion=_targets)],
    velocity: Annotated[
        tuple[str, str] | None,
        option("Velocities, e.g. 1mm/s 10m/s; twice the same for one. A table has its own.", metavar="LOW HIGH"),
    ] = None,
    radius: Annotated[
        tuple[str, str] | None, option("Radii of the first ball, for one law of all sizes.", metavar="LOW HIGH")
    ] = None,
    restitution: Annotated[
        str | None,
        option(
            "Coefficient of restitution in place of that of the material, or a CSV file of measured ones, with the "
            "columns velocity and restitution_coefficient.",
            metavar="E|FILE",
        ),
    ] = None,
    contact: Annotated[
        str | None,
        option(
            "pair, two balls, or wall, a ball and a wall. The default is that of the case, and the other one is built "
            "from its ball.",
            metavar="WHAT",
        ),
    ] = None,
    units: Annotated[str, option("Unit system: si; for LAMMPS also cgs, micro or lj.", metavar="UNITS")] = "si",
    json: Json = False,
    plot: Plot = None,
    workers: Workers = None,
    extrapolate: Extrapolate = False,
) -> None:
    """Fit the contact law of another code to the exact restitution, and print the text to paste.

    The case file needs no velocity.
    Example: restitution calibrate examples/beads.toml --target lammps-viscoelastic --velocity "1 cm/s" "10 cm/s"
    """
    with user_input():
        from restitution.calibration.calibrate import calibrate as fit
        from restitution.case.impact import read_case
        from restitution.quantities import LENGTH, VELOCITY

        problem = read_case(case, any_velocity=True)
        given = None if restitution is None else _restitution(restitution)
        if velocity is not None:
            low, high = (tables.read_quantity("--velocity", text, VELOCITY) for text in velocity)
        elif isinstance(given, tuple):
            low, high = float(min(given[0])), float(max(given[0]))
        else:
            raise BadInput("Missing option '--velocity': only a table of --restitution has velocities of its own")
        sizes = None if radius is None else tuple(tables.read_quantity("--radius", text, LENGTH) for text in radius)
        impact = problem.over((low, high))
        # The bodies have no size of the target, which the report of a half-space compares.
        is_plain = problem.sections.counter_body is None and impact.counter_material is None and contact != "pair"
        bodies: Any = impact if is_plain else problem.bodies(impact) or impact
        with compilation():
            found = fit(
                bodies, target, (low, high) if low != high else low, radius=sizes,
                restitution=given, contact=contact, units=units, extrapolate=extrapolate, workers=workers,
            )  # fmt: skip
        notes = problem.notes(impact)
    if json:
        tables.write_json(found.to_dict())
    else:
        tables.show(found.summary())
        report("note", *notes)
    if plot is not None:
        tables.save_picture(found.plot(), plot)


def _restitution(text: str) -> Any:
    """Return one coefficient of restitution, or the velocities [m/s] and the coefficients of a CSV file."""
    try:
        return float(text)
    except ValueError:
        from restitution.case.observations import read_observations

        # Measured rebounds have a ball, which is that of the case here.
        table: Any = read_observations(text, kind="rebounds", radius=1.0, mass=1.0)
        return table.velocity, table.restitution_coefficient
