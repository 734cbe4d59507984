"""The commands for other codes: `export` and `calibrate`."""

from __future__ import annotations

from contextlib import suppress
from json import dumps
from pathlib import Path
from typing import Annotated, Any, NamedTuple

import restitution as rs
from restitution.cli import tables
from restitution.cli import terminal as cli
from restitution.cli.sweep import build_surrogate
from restitution.cli.terminal import completed, ends, option
from restitution.files import TABLES, write_table, write_text
from restitution.units import ANGLE, LENGTH, MASS, VELOCITY

# Ends of the names of contact laws.
_LAWS = (".h", ".json")
# Ends of the names of cards, with the time at which their elastic constants hold.
_CARDS = {".inp": "after a long time", ".txt": "at the first instant", ".mac": "at the first instant"}
# Velocities to which terms of a law are fitted.
_POINTS = 9
# Relative difference of radii or masses of one ball.
_SAME = 1e-2


def export(
    case: cli.CaseFile,
    to: Annotated[
        Path,
        option(
            "File, whose end decides: .h or .json, the contact law with memory, in C or as numbers; .csv or .nc, a "
            "table of e, contact time and largest force over the velocity; .inp, cards of Abaqus; .txt or .mac, cards "
            "of ANSYS.",
            "FILE",
            callback=lambda path: cli.check_target("--to", path, (*_LAWS, *TABLES, *_CARDS)),
        ),
    ],
    velocity: Annotated[
        tuple[str, str] | None, option("Velocities of a table, or of --terms, e.g. 1mm/s 10m/s.", "LOW HIGH")
    ] = None,
    terms: Annotated[
        int | None, option("Terms of a contact law, fitted to the contacts; all if not given.", min=1)
    ] = None,
    json: cli.Json = False,
    extrapolate: cli.Extrapolate = False,
) -> None:
    """Write an impact, its contact law or its materials for another program.

    Example: restitution export examples/epoxy.toml --to epoxy.inp
    """
    with cli.user_input():
        suffix = to.suffix.lower()
        if terms is not None and suffix not in _LAWS:
            raise cli.BadInput(f"--terms {terms}: has no meaning for {to}; it belongs to a contact law, .h or .json")
        if suffix in TABLES:
            if velocity is None:
                raise cli.BadInput(f"--to {to}: give --velocity LOW HIGH as well")
            exported = _write_outcomes(case, to, _range(velocity), extrapolate)
        elif velocity is not None and terms is None:
            text = " ".join(velocity)
            raise cli.BadInput(f"--velocity {text}: has no meaning for {to}; it belongs to a table or --terms")
        elif suffix in _LAWS:
            exported = _write_law(case, to, None if velocity is None else _range(velocity), terms, extrapolate)
        else:
            exported = _write_materials(case, to)
    if json:
        tables.write_json(
            {"file": str(to), **exported.numbers, "warnings": exported.warnings, "notes": exported.notes}
        )
        return
    print(f"{to}: {exported.words}")
    cli.report("warning", *exported.warnings)
    cli.report("note", *exported.notes)


class _Export(NamedTuple):
    """What a command wrote, in words and in numbers, with its warnings and notes."""

    words: str
    numbers: dict[str, Any]
    warnings: list[str]
    notes: list[str]


def _write_law(
    case: Path, to: Path, velocity: tuple[float, float] | None, terms: int | None, extrapolate: bool
) -> _Export:
    """Write the contact law with memory."""
    import numpy as np

    from restitution.impact.window import require_known, validity_of
    from restitution.surrogates.velocity import velocity_range
    from restitution.variation import vary

    problem = rs.read_case(case, any_velocity=velocity is not None)
    impact = problem.impact
    if terms is not None and impact.adhesion is not None:
        raise cli.BadInput(f"--terms {terms}: has no meaning with adhesion, whose law keeps all its terms")
    if velocity is not None:
        speeds = np.geomspace(*velocity_range(velocity), _POINTS)
        impact = vary(problem.over(velocity), {"velocity": speeds})
    require_known(impact, extrapolate=extrapolate)
    law = rs.contact_law(impact)
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
        if impact.adhesion is not None:
            content |= {"work": float(impact.adhesion.work), "stress": float(np.asarray(impact.adhesion.stress))}
        if law.shear_modulus is not None:
            shear = law.shear_modulus
            content |= {
                "friction": law.friction, "shear_equilibrium_modulus": shear.equilibrium_modulus,
                "shear_branch_moduli": shear.branch_moduli.tolist(),
                "shear_relaxation_times": shear.relaxation_times.tolist(),
                "shear_parallel_viscosity": shear.parallel_viscosity,
            }  # fmt: skip
        write_text(to, dumps(content, indent=1) + "\n")
    count = law.modulus.n_branches
    error = f", error of e {law.restitution_error:.1e}" if terms else ""
    words = f"contact law of {count} term{'s' * (count != 1)}, {law.state_size} numbers a contact{error}"
    numbers = {"terms": count, "state_size": law.state_size, "restitution_error": law.restitution_error}
    return _Export(words, numbers, validity_of(impact).warnings, problem.notes(impact))


def _range(velocity: tuple[str, str]) -> tuple[float, float]:
    low, high = (cli.read_quantity("--velocity", text, VELOCITY) for text in velocity)
    return low, high


def _write_outcomes(case: Path, to: Path, velocity: tuple[float, float], extrapolate: bool) -> _Export:
    """Write e, contact time and largest force over the velocity."""
    surrogate, notes = build_surrogate(case, velocity, extrapolate=extrapolate)
    write_table(surrogate.sample(), to)
    errors = ", ".join(f"{name.replace('_', ' ')} {error:.1e}" for name, error in surrogate.error.items())
    low, high = surrogate.velocity
    words = f"{low:g} to {high:g} m/s; largest relative error: {errors}"
    return _Export(words, {"velocity": [low, high], "error": surrogate.error}, surrogate.warnings, notes)


def _write_materials(case: Path, to: Path) -> _Export:
    """Write the cards of the materials that deform."""
    from restitution.material.cards import lost_shift, write_material

    problem = rs.read_case(case, any_velocity=True)
    impact = problem.impact
    materials = list(dict.fromkeys(impact.contact.materials))
    write_material(materials, to)
    count = f"{len(materials)} material{'s' * (len(materials) > 1)}"
    notes = [*problem.notes(impact), *filter(None, map(lost_shift, materials))]
    names = [material.name for material in materials]
    return _Export(
        f"{count} in SI units; E and nu are those {_CARDS[to.suffix.lower()]}", {"materials": names}, [], notes
    )


_TARGETS = (
    "lammps-viscoelastic, lammps-tsuji, lammps-coeff-restitution, mercury-bshp, yade-mindlin, liggghts, kratos-dem, "
    "mujoco-solref, drake, drake-sap, rebound, acusolve, solfec, box2d, bullet or physx; of a case with adhesion "
    "lammps-jkr-viscoelastic, lammps-jkr-mass-velocity, lammps-dmt-viscoelastic, lammps-dmt-mass-velocity, "
    "liggghts-sjkr, mercury-adhesive, yade-dmt or mfix"
)


def calibrate(
    case: cli.CaseFile,
    target: Annotated[
        str, option(f"Law of the code: {_TARGETS}.", "NAME", autocompletion=completed("calibration.calibrate.TARGETS"))
    ],
    velocity: Annotated[
        tuple[float, float] | None,
        ends("--velocity", VELOCITY, "Velocities, e.g. 1mm/s 10m/s; twice the same for one. A table has its own."),
    ] = None,
    radius: Annotated[
        tuple[float, float] | None, ends("--radius", LENGTH, "Radii of the first ball, for one law of all sizes.")
    ] = None,
    restitution: Annotated[
        str | None,
        option(
            "Coefficient of restitution in place of that of the material, or a CSV file of measured ones, with the "
            "columns velocity and restitution_coefficient.",
            "E|FILE",
        ),
    ] = None,
    contact: Annotated[
        str | None,
        option(
            "pair, two balls, or wall, a ball and a wall. The default is that of the case, and the other one is built "
            "from its ball.",
            "WHAT",
        ),
    ] = None,
    units: Annotated[str, option("Unit system: si; for LAMMPS also cgs, micro or lj.", "UNITS")] = "si",
    friction: Annotated[
        float | None,
        option("Coefficient of friction, >= 0, for a text with friction; that of the case if it has one."),
    ] = None,
    angle: Annotated[
        tuple[float, float] | None,
        ends("--angle", ANGLE, "Angles of incidence from the normal, with friction, e.g. 5deg 80deg."),
    ] = None,
    tangential: Annotated[
        str | None, option("Tangential style of LAMMPS, such as mindlin_rescale/force, the default.", "STYLE")
    ] = None,
    json: cli.Json = False,
    plot: cli.Plot = None,
    workers: cli.Workers = None,
    extrapolate: cli.Extrapolate = False,
) -> None:
    """Fit the contact law of another code to the exact restitution, and print the text to paste.

    The case file needs no velocity.
    Example: restitution calibrate examples/beads.toml --target lammps-viscoelastic --velocity "1 cm/s" "10 cm/s"
    """
    from restitution.calibration.tangential import takes_friction

    with cli.user_input():
        problem = rs.read_case(case, any_velocity=True)
        bodies: Any = problem.bodies(problem.impact)
        measured = None if restitution is None else _restitution(restitution, bodies and bodies[0])
        if velocity is None:
            if not isinstance(measured, tuple):
                rule = "only a table of --restitution has velocities of its own"
                raise cli.BadInput(f"Missing option '--velocity': {rule}")
            velocity = float(min(measured[0])), float(max(measured[0]))
        impact = problem.over(velocity)
        # The bodies have no size of the target, which the report of a half-space compares.
        is_plain = problem.sections.counter_body is None and impact.counter_material is None and contact != "pair"
        bodies = impact if is_plain else problem.bodies(impact) or impact
        rough: dict[str, Any] = {"friction": friction, "angle": angle, "tangential": tangential}
        if impact.friction is not None and takes_friction(target):
            rough |= {"friction": impact.friction if friction is None else friction, "gyration": impact.gyration}
        with cli.compilation():
            result = rs.calibrate(
                bodies, target, velocity if velocity[0] != velocity[1] else velocity[0], radius=radius,
                restitution=measured, contact=contact, units=units, adhesion=impact.adhesion, extrapolate=extrapolate,
                workers=workers, **rough,
            )  # fmt: skip
    tables.answer(result, json=json, plot=plot, notes=problem.notes(impact))


def _restitution(text: str, ball: rs.Body | None) -> Any:
    """Return one coefficient of restitution, or the velocities [m/s] and the coefficients of a CSV file.

    Columns of radii and masses must have those of the ball.
    """
    from restitution.case.observations import open_columns

    names: list[str] = []
    try:
        return float(text)
    except ValueError:
        # What is wrong with a file is said below.
        with suppress(rs.InputError):
            names = open_columns(Path(text))[1]
    body = {name: 1.0 if ball is None else getattr(ball, name) for name in ("radius", "mass")}
    absent: dict[str, Any] = {name: value for name, value in body.items() if name not in names}
    table: Any = rs.read_observations(text, kind="rebounds", **absent)
    for (name, value), unit in zip(body.items(), (LENGTH.unit, MASS.unit), strict=True):
        other = [each for each in getattr(table, name).tolist() if abs(each - value) > _SAME * value]
        if other and ball is not None:
            rule = f"must be that of the ball of the case, {value:.6g} {unit}; a law is fitted to one ball"
            raise rs.InputError(name, other[0], rule, unit, where=text)
    return table.velocity, table.restitution_coefficient
