"""The command `restitution material`: data, fit and moduli of a material, printed, as JSON, or drawn."""

from __future__ import annotations

import math
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, NamedTuple

import typer

from restitution.cli import facts, tables
from restitution.cli.options import Json, Plot, argument, library_names, option
from restitution.cli.terminal import BadInput, progress_bar, report, user_input
from restitution.display import celsius
from restitution.errors import InputError

# Help must load nothing heavy.
if TYPE_CHECKING:
    from restitution.material.isotherms import Isotherms, MasterCurve
    from restitution.material.shift import ShiftTable

# Rows of the table of moduli: enough to see each transition, few enough for a screen.
_ROWS = 9
# Columns of tables that belong to another command, and advice on it.
_OTHERS = (
    (
        {"depth", "indentation", "force", "displacement", "deflection"},
        "A curve of depth or force is no material: `restitution indent` takes it as indentation.file",
    ),
    (
        {"bounce", "height", "rebound", "drop", "drop_height"},
        "Heights or velocities of bounces are no material: `restitution bounce` computes them from one",
    ),
)


def material(
    source: Annotated[
        str | None, argument("FILE|NAME", "File, or material of the library.", autocompletion=library_names)
    ] = None,
    list_: Annotated[bool, typer.Option("--list", help="List the materials of the library.")] = False,
    at: Annotated[
        str | None, option('Temperature of the moduli, e.g. "20 degC" or 293.', metavar="TEMPERATURE")
    ] = None,
    shift: Annotated[
        Path | None, option("Shift factors over temperature, for a file of moduli.", metavar="FILE")
    ] = None,
    reference_temperature: Annotated[
        str | None, option("Temperature of the master curve of a file with several.", metavar="TEMPERATURE")
    ] = None,
    superposition: Annotated[
        str | None, option("Shifts of such a file: free, wlf or arrhenius.", metavar="LAW")
    ] = None,
    material_name: Annotated[str | None, option("Which material of a deck that has several.", metavar="NAME")] = None,
    json: Json = False,
    plot: Plot = None,
) -> None:
    """Read a material from a file or the library, and show its data, fit and moduli.

    Relaxation and DMA data are fitted by a Prony series. Several temperatures become one master curve first. Tables of
    Prony terms and of shift factors, the decks of ANSYS and Abaqus, and the materials of a case file are read too.
    Example: restitution material examples/beads_dma.csv --plot moduli.png
    """
    with user_input():
        if list_:
            from restitution.material import library

            sources = {name: library.get(name).source or "" for name in library.names()}
            if json:
                tables.write_json(sources)
            else:
                tables.print_rows("Materials of the library", ("name", "source"), list(sources.items()))
            return
        if source is None:
            raise BadInput("material: give a file or a name, or --list")
        try:
            with progress_bar("reading", begin="reading and fitting"):
                found = _reports(
                    source, at, shift, material_name, _Superposition(reference_temperature, superposition)
                )
        except InputError as error:
            if error.field == "temperature" and at is not None and _is_celsius(at):
                raise BadInput(f'{error}; a plain number is in K: write --at "{at} degC" for Celsius') from None
            raise
    if json:
        contents = [_content(one) for one in found]
        tables.write_json(contents[0] if len(contents) == 1 else contents)
    else:
        for one in found:
            _print(one)
            report("note", *one.notes)
    if plot is not None:
        _draw(found, plot)


class _Superposition(NamedTuple):
    """Options of a file with several temperatures, as they are written."""

    reference_temperature: str | None
    law: str | None

    def curve(self, isotherms: Isotherms) -> MasterCurve:
        """Master curve of such a file."""
        from restitution.quantities import TEMPERATURE

        if self.law not in (None, "free", "wlf", "arrhenius"):
            raise BadInput(f"--superposition {self.law}: must be free, wlf or arrhenius")
        given, kelvin = self.reference_temperature, None
        if given is not None:
            kelvin = tables.read_quantity("--reference-temperature", given, TEMPERATURE)
        law: Any = self.law or "free"
        return isotherms.superposed(reference_temperature=kelvin, shift=law)

    def refuse(self, source: str) -> None:
        """Refuse options that are given for other files."""
        for name, value in (("--reference-temperature", self.reference_temperature), ("--superposition", self.law)):
            if value is not None:
                raise BadInput(f"{name} {value}: {source} must have moduli at several temperatures")


def _is_celsius(text: str) -> bool:
    """Whether a plain number is too low for most temperatures in kelvin."""
    try:
        return float(text) < 200.0
    except ValueError:
        return False


def _reports(
    source: str, at: str | None, shift: Path | None, name: str | None, superposition: _Superposition
) -> list[facts.Report]:
    """Return one report, or for a case file one for each of its materials."""
    from restitution.material import library
    from restitution.material.deck import PronyTerms, ViscoelasticDeck
    from restitution.material.isotherms import Isotherms
    from restitution.material.readers import read_material
    from restitution.material.shift import ShiftTable
    from restitution.quantities import TEMPERATURE, advice

    kelvin = None if at is None else tables.read_quantity("--at", at, TEMPERATURE)
    law = None if shift is None else read_material(shift)
    if law is not None and not isinstance(law, ShiftTable):
        raise BadInput(f"--shift {shift}: must hold temperatures and shift factors")
    if law is not None and kelvin is None:
        raise BadInput(f"--shift {shift}: give --at TEMPERATURE as well")
    path = Path(source)
    named = source in library.names() and not path.exists()
    if name is not None and (named or path.suffix == ".toml"):
        raise BadInput(f"--material-name {name}: {source} is no deck of a solver, whose materials have names")
    if named or path.suffix == ".toml":
        superposition.refuse(source)
    if named:
        return [facts.of_material(library.get(source), source, "material of the library", kelvin, law)]
    if path.suffix == ".toml":
        return _of_case(source, kelvin, law)
    if not path.exists() and not path.suffix:
        raise BadInput(f"{source}: no such file, and no material of the library; {advice(source, library.names())}")
    try:
        content = read_material(source, name=name)
    except ValueError as error:
        raise BadInput(f"{error}{_other_use(source)}") from None
    if isinstance(content, Isotherms):
        made = facts.of_isotherms(superposition.curve(content), source)
        own = made.curve.shift if law is None and kelvin is not None and made.curve is not None else law
        return [made if own is None or kelvin is None else facts.shifted(made, own, kelvin)]
    superposition.refuse(source)
    if isinstance(content, ShiftTable):
        return [facts.of_shift(content, source, kelvin)]
    if kelvin is not None and law is None:
        raise BadInput("--at: a file of moduli has no law of the shift; give its shift factors by --shift FILE")
    if isinstance(content, ViscoelasticDeck):
        made = facts.of_deck(content, source)
    else:
        made = facts.of_terms(content, source) if isinstance(content, PronyTerms) else facts.of_data(content, source)
    made.notes = getattr(content, "notes", ())
    return [made if law is None or kelvin is None else facts.shifted(made, law, kelvin)]


def _other_use(source: str) -> str:
    """Advice on a table whose columns are those of an indentation or of bounces."""
    from restitution.case.columns import named_columns

    try:
        columns = {name.casefold() for name in named_columns(".", source)}
    except ValueError:
        return ""
    return next((f". {advice}" for names, advice in _OTHERS if columns & names), "")


def _of_case(source: str, kelvin: float | None, law: ShiftTable | None) -> list[facts.Report]:
    from restitution.case.impact import read_case
    from restitution.case.indentation import read_indentation
    from restitution.case.section import read_toml

    pressed = "indentation" in read_toml(Path(source))
    subject = read_indentation(source) if pressed else read_case(source).impact
    made: list[facts.Report] = []
    for name, one in (("material", subject.material), ("counter_material", subject.counter_material)):
        if one is not None:
            # An elastic material needs no law of the shift.
            elastic = all(series.is_elastic for series in facts.series_of(one).values())
            made.append(
                facts.of_material(one, one.name or name, f"{name} of {source}", None if elastic else kelvin, law)
            )
    return made


def _content(made: facts.Report) -> dict[str, Any]:
    content = {key: value for key, value in made.facts.items() if value is not None}
    if made.notes:
        content["notes"] = list(made.notes)
    pascals = "" if made.relative else "_Pa"
    for name, one in made.series.items():
        content[f"prony_{name}"] = {
            f"equilibrium_modulus{pascals}": one.equilibrium_modulus,
            f"branch_moduli{pascals}": one.branch_moduli.tolist(),
            "relaxation_times_s": one.relaxation_times.tolist(),
            f"parallel_viscosity{pascals}_s": one.parallel_viscosity,
        }
    if made.curve is not None:
        content["temperatures_K"] = made.curve.temperatures.tolist()
        content["log10_factors"] = made.curve.log10_factors.tolist()
        content["standard_errors"] = [error if math.isfinite(error) else None for error in made.curve.errors.tolist()]
    if made.factors is not None:
        content["temperatures_K"] = made.factors.temperatures.tolist()
        content["log10_factors"] = made.factors.log10_factors.tolist()
    return content


def _print(made: facts.Report) -> None:
    import numpy as np

    rows = [_row(key, value) for key, value in made.facts.items() if value is not None]
    tables.print_rows(made.title, ("what", "value"), rows)
    if made.factors is not None:
        pairs = zip(made.factors.temperatures, made.factors.log10_factors, strict=True)
        rows = [(celsius(kelvin), f"{factor:.6g}") for kelvin, factor in pairs]
        tables.print_rows("Shift factors", ("temperature [°C]", "log10 aT"), rows)
    if made.curve is not None:
        columns = made.curve.temperatures, made.curve.log10_factors, made.curve.errors
        rows = [
            (celsius(kelvin, 5), f"{factor:.4g}", f"{error:.2g}")
            for kelvin, factor, error in zip(*columns, strict=True)
        ]
        tables.print_rows("Shifts", ("temperature [°C]", "log10 aT", "standard error"), rows)
    unit = "-" if made.relative else "Pa"
    for name, one in made.series.items():
        if made.window is None or not one.n_branches:
            tables.print_rows(f"Modulus, {name}", (f"modulus [{unit}]",), [(f"{one.equilibrium_modulus:.6g}",)])
            continue
        t = np.geomspace(*made.window, _ROWS)
        values = (t, one.relaxation_modulus(t), one.storage_modulus(1.0 / t), one.loss_modulus(1.0 / t))
        columns = ("t = 1/omega [s]", *(f"{kind} [{unit}]" for kind in ("relaxation", "storage", "loss")))
        rows = [tuple(f"{value:.4g}" for value in row) for row in np.stack(values, axis=1).tolist()]
        tables.print_rows(f"Moduli, {name}", columns, rows)


def _row(key: str, value: Any) -> tuple[str, str]:
    """Words and value of a fact; temperatures are in °C, as in the tables of shifts."""
    if key.endswith("temperature_K"):
        return f"{key.removesuffix('_K').replace('_', ' ')} [°C]", celsius(value)
    return _words(key), _text(value)


def _words(key: str) -> str:
    """Return a key such as `window_s` in words, with the unit in brackets."""
    name, _, unit = key.replace("_kg_m3", "_kg/m3").rpartition("_")
    return (
        f"{name} [{unit}]".replace("_", " ") if unit in ("K", "s", "Pa", "kg/m3", "J/mol") else key.replace("_", " ")
    )


def _text(value: Any) -> str:
    match value:
        case bool():
            return "yes" if value else "no"
        case float():
            return f"{value:.6g}" if math.isfinite(value) else "infinite"
        case tuple():
            return " to ".join(f"{float(part):.3g}" for part in value)
        case _:
            return str(value)


def _draw(reports: list[facts.Report], path: Path) -> None:
    from restitution.plot import material as pictures

    first = reports[0]
    if first.curve is not None:
        tables.save_picture(pictures.superposition(first.curve), path)
        return
    if first.factors is not None:
        tables.save_picture(pictures.shift_factors(first.factors), path)
        return
    several = len(reports) > 1
    series = {f"{one.title}, {k}" if several else k: v for one in reports for k, v in one.series.items()}
    windows = [one.window for one in reports if one.window is not None] or [(1e-6, 1.0)]
    window = min(low for low, _ in windows), max(high for _, high in windows)
    unit = "" if all(one.relative for one in reports) else "Pa"
    tables.save_picture(pictures.overview(series, window, first.data, unit=unit), path)
