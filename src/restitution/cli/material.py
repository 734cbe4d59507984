"""The command `restitution material`: data, fit and moduli of a material, printed, as JSON, or drawn."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from restitution.cli import tables
from restitution.cli.options import Json, Plot, argument, library_names, option
from restitution.cli.terminal import BadInput, report, user_input
from restitution.errors import InputError

# Help must load nothing heavy.
if TYPE_CHECKING:
    from restitution.material.deck import PronyTerms, ViscoelasticDeck
    from restitution.material.fit import DynamicTable, RelaxationTable
    from restitution.material.prony import PronySeries
    from restitution.material.shift import ShiftTable
    from restitution.material.viscoelastic import Material

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
    material_name: Annotated[str | None, option("Which material of a deck that has several.", metavar="NAME")] = None,
    json: Json = False,
    plot: Plot = None,
) -> None:
    """Read a material from a file or the library, and show its data, fit and moduli.

    Relaxation and DMA tables are fitted by a Prony series. Tables of Prony terms and of shift factors, the decks of
    ANSYS and Abaqus, and the materials of a case file are read too.
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
            found = _reports(source, at, shift, material_name)
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


def _is_celsius(text: str) -> bool:
    """Whether a plain number is too low for most temperatures in kelvin."""
    try:
        return float(text) < 200.0
    except ValueError:
        return False


@dataclass
class Report:
    """Facts about a material, its relaxation functions, its data, and the window of times of the pictures."""

    title: str
    facts: dict[str, Any]
    series: dict[str, PronySeries] = field(default_factory=dict[str, "PronySeries"])
    window: tuple[float, float] | None = None
    data: RelaxationTable | DynamicTable | None = None
    factors: ShiftTable | None = None
    notes: tuple[str, ...] = ()  # remarks of the reader of the file, such as units that were assumed
    relative: bool = False  # whether the moduli are shares of a modulus that the file does not give


def _reports(source: str, at: str | None, shift: Path | None, name: str | None) -> list[Report]:
    """Return one report, or for a case file one for each of its materials."""
    from restitution.material import library
    from restitution.material.deck import PronyTerms, ViscoelasticDeck
    from restitution.material.readers import read_material
    from restitution.material.shift import ShiftTable
    from restitution.quantities import TEMPERATURE

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
    if named:
        return [_of_material(library.get(source), source, "material of the library", kelvin, law)]
    if path.suffix == ".toml":
        return _of_case(source, kelvin, law)
    if not path.exists() and not path.suffix:
        raise BadInput(f"{source}: no such file, and no material of the library: {', '.join(library.names())}")
    try:
        content = read_material(source, name=name)
    except ValueError as error:
        raise BadInput(f"{error}{_other_use(source)}") from None
    if isinstance(content, ShiftTable):
        return [_of_shift(content, source, kelvin)]
    if kelvin is not None and law is None:
        raise BadInput("--at: a file of moduli has no law of the shift; give its shift factors by --shift FILE")
    if isinstance(content, ViscoelasticDeck):
        made = _of_deck(content, source)
    else:
        made = _of_terms(content, source) if isinstance(content, PronyTerms) else _of_data(content, source)
    made.notes = getattr(content, "notes", ())
    return [made if law is None or kelvin is None else _shifted(made, law, kelvin)]


def _other_use(source: str) -> str:
    """Advice on a table whose columns are those of an indentation or of bounces."""
    from restitution.case.columns import named_columns

    try:
        columns = {name.casefold() for name in named_columns(".", source)}
    except ValueError:
        return ""
    return next((f". {advice}" for names, advice in _OTHERS if columns & names), "")


def _of_case(source: str, kelvin: float | None, law: ShiftTable | None) -> list[Report]:
    from restitution.case.impact import read_case
    from restitution.case.indentation import read_indentation
    from restitution.case.section import read_toml

    pressed = "indentation" in read_toml(Path(source))
    subject = read_indentation(source) if pressed else read_case(source).impact
    made: list[Report] = []
    for name, one in (("material", subject.material), ("counter_material", subject.counter_material)):
        if one is not None:
            # An elastic material needs no law of the shift.
            elastic = all(series.is_elastic for series in _series_of(one).values())
            made.append(_of_material(one, one.name or name, f"{name} of {source}", None if elastic else kelvin, law))
    return made


def _shifted(made: Report, law: ShiftTable, kelvin: float) -> Report:
    """Return a report at the reference temperature of a law for another temperature."""
    from restitution.material.fit import DynamicTable

    factor, data = law.factor(kelvin), made.data
    if isinstance(data, DynamicTable):
        data = replace(data, angular_frequency=data.angular_frequency / factor)
    elif data is not None:
        data = replace(data, time=data.time * factor)
    window = None if made.window is None else (made.window[0] * factor, made.window[1] * factor)
    facts: dict[str, Any] = {"temperature_K": kelvin, "shift_factor": factor}
    if "window_s" in made.facts:
        facts["window_s"] = window
    series = {name: one.scaled(1.0, time_factor=factor) for name, one in made.series.items()}
    return replace(made, facts=made.facts | facts, series=series, window=window, data=data)


def _series_of(material: Material) -> dict[str, PronySeries]:
    """Relaxation functions of a material by name, without a constant bulk modulus."""
    series: dict[str, Any] = {"shear": material.shear, "bulk": material.bulk}
    return {name: one for name, one in series.items() if not isinstance(one, float)}


def _of_material(material: Material, title: str, kind: str, kelvin: float | None, law: ShiftTable | None) -> Report:
    if law is not None and kelvin is not None:
        material = replace(material, shift=law, temperature=law.reference_temperature)
    if kelvin is not None:
        material = material.at(kelvin)
    facts: dict[str, Any] = {
        "kind": kind,
        "source": material.source,
        "assumptions": material.assumptions,
        "temperature_K": material.temperature,
        "density_kg_m3": material.density,
        "window_s": material.window,
        "poisson_ratio_at_rest": material.poisson_ratio,
        "poisson_ratio_at_once": material.instantaneous_poisson_ratio,
        "incompressible": material.is_incompressible,
    }
    series = _series_of(material)
    return Report(title, facts, series, material.window or _window(series))


def _of_data(data: RelaxationTable | DynamicTable, source: str) -> Report:
    from restitution.material.fit import DynamicTable, fit_prony

    fit, dynamic = fit_prony(data), isinstance(data, DynamicTable)
    facts = {
        "kind": "storage and loss modulus over frequency" if dynamic else "relaxation modulus over time",
        "deformation": data.deformation or "not said",
        "points": int(fit.residuals.size),
        "window_s": fit.window,
        "fitted_terms": fit.n_terms,
        "relative_misfit": fit.misfit,
        "largest_relative_residual": float(abs(fit.residuals).max()),
    }
    return Report(source, facts, {data.deformation or "fit": fit.series}, fit.window, data)


def _of_terms(terms: PronyTerms, source: str) -> Report:
    ends = terms.instantaneous_modulus, terms.equilibrium_modulus
    facts: dict[str, Any] = {
        "kind": "Prony terms",
        "deformation": terms.deformation or "not said",
        "terms": int(terms.moduli.size),
        "relative": terms.relative,
        "sum": float(terms.moduli.sum()),
        "instantaneous_modulus_Pa": ends[0],
        "equilibrium_modulus_Pa": ends[1],
    }
    relative = terms.relative and ends == (None, None)
    name = "relative to the instantaneous modulus" if relative else terms.deformation or "modulus"
    # The shares of a modulus that the file does not give are those of 1 Pa.
    series = {name: terms.series(instantaneous_modulus=1.0) if relative else terms.series()}
    return Report(source, facts, series, _window(series), relative=relative)


def _of_deck(deck: ViscoelasticDeck, source: str) -> Report:
    facts: dict[str, Any] = {
        "kind": "deck of a solver",
        "name": deck.name,
        "terms_in_shear": 0 if deck.shear is None else int(deck.shear.moduli.size),
        "terms_in_bulk": 0 if deck.bulk is None else int(deck.bulk.moduli.size),
        "youngs_modulus_Pa": deck.youngs_modulus,
        "poisson_ratio": deck.poisson_ratio,
        "constants_of": "long times" if deck.long_term else "short times",
        "density_kg_m3": deck.density,
    }
    relative = deck.youngs_modulus is None or deck.poisson_ratio is None
    if relative:
        parts = {"shear, relative": deck.shear, "bulk, relative": deck.bulk}
        series = {name: one.series(instantaneous_modulus=1.0) for name, one in parts.items() if one is not None}
    else:
        series = _series_of(deck.material())
    return Report(source, facts, series, _window(series), relative=relative and bool(series))


def _of_shift(table: ShiftTable, source: str, kelvin: float | None) -> Report:
    facts: dict[str, Any] = {
        "kind": "shift factors over temperature",
        "points": int(table.temperatures.size),
        "lowest_temperature_K": float(table.temperatures[0]),
        "highest_temperature_K": float(table.temperatures[-1]),
        "reference_temperature_K": table.reference_temperature,
    }
    if kelvin is not None:
        facts |= {"temperature_K": kelvin, "shift_factor": table.factor(kelvin)}
    return Report(source, facts, factors=table)


def _window(series: Mapping[str, PronySeries]) -> tuple[float, float] | None:
    times = [float(time) for one in series.values() for time in one.relaxation_times]
    # Frequencies are inverse times, and both must be numbers that a double holds.
    return (max(min(times) / 10.0, 1e-290), min(max(times) * 10.0, 1e290)) if times else None


def _content(made: Report) -> dict[str, Any]:
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
    if made.factors is not None:
        content["temperatures_K"] = made.factors.temperatures.tolist()
        content["log10_factors"] = made.factors.log10_factors.tolist()
    return content


def _print(made: Report) -> None:
    import numpy as np

    rows = [(_words(key), _text(value)) for key, value in made.facts.items() if value is not None]
    tables.print_rows(made.title, ("what", "value"), rows)
    if made.factors is not None:
        pairs = zip(made.factors.temperatures, made.factors.log10_factors, strict=True)
        rows = [(f"{kelvin - 273.15:.6g}", f"{factor:.6g}") for kelvin, factor in pairs]
        tables.print_rows("Shift factors", ("temperature [°C]", "log10 aT"), rows)
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


def _words(key: str) -> str:
    """Return a key such as `window_s` in words, with the unit in brackets."""
    name, _, unit = key.replace("_kg_m3", "_kg/m3").rpartition("_")
    return f"{name} [{unit}]".replace("_", " ") if unit in ("K", "s", "Pa", "kg/m3") else key.replace("_", " ")


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


def _draw(reports: list[Report], path: Path) -> None:
    from restitution.plot import material as pictures

    first = reports[0]
    if first.factors is not None:
        tables.save_picture(pictures.shift_factors(first.factors), path)
        return
    several = len(reports) > 1
    series = {f"{one.title}, {k}" if several else k: v for one in reports for k, v in one.series.items()}
    windows = [one.window for one in reports if one.window is not None] or [(1e-6, 1.0)]
    window = min(low for low, _ in windows), max(high for _, high in windows)
    unit = "" if all(one.relative for one in reports) else "Pa"
    tables.save_picture(pictures.overview(series, window, first.data, unit=unit), path)
