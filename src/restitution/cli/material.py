"""The command `restitution material`: data, fit and moduli of a material, printed, as JSON, or drawn."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Literal

import typer

import restitution as rs
from restitution.cli import tables
from restitution.cli import terminal as cli
from restitution.cli.terminal import argument, completed, option, quantity
from restitution.errors import InputError
from restitution.units import DENSITY, MODULUS, MOLAR_ENERGY, TEMPERATURE, TIME, celsius

if TYPE_CHECKING:
    from restitution.material.cards import PronyTerms, ViscoelasticDeck
    from restitution.material.fit import Measured
    from restitution.material.shift import Shift, ShiftTable


# Help must load nothing heavy.

# Rows of the table of moduli: enough to see each transition, few enough for a screen.
_ROWS = 9
# Units at the end of the names of facts.
_UNITS = ["Hz", *(dimension.unit for dimension in (TIME, MODULUS, TEMPERATURE, DENSITY, MOLAR_ENERGY))]
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


@dataclass
class Report:
    """Facts about a material, its relaxation functions, its data, and the window of times of the pictures."""

    title: str
    facts: dict[str, Any]
    series: dict[str, rs.PronySeries] = field(default_factory=dict[str, Any])
    window: tuple[float, float] | None = None
    data: Measured | None = None
    shifts: ShiftTable | rs.MasterCurve | None = None
    notes: tuple[str, ...] = ()  # remarks of the reader of the file, such as units that were assumed
    relative: bool = False  # whether the moduli are shares of a modulus that the file does not give

    @property
    def curve(self) -> Any:
        """Master curve of several temperatures."""
        return self.shifts if hasattr(self.shifts, "isotherms") else None

    def shifted(self, law: Shift | None, kelvin: float | None) -> Report:
        """Return the report at another temperature than the reference temperature of a law."""
        if law is None or kelvin is None:
            return self
        factor, data = law.factor(kelvin), self.data
        if isinstance(data, rs.DynamicTable):
            data = replace(data, angular_frequency=data.angular_frequency / factor)
        elif data is not None:
            data = replace(data, time=data.time * factor)
        window = None if self.window is None else (self.window[0] * factor, self.window[1] * factor)
        facts = self.facts | {"temperature_K": kelvin, "shift_factor": factor}
        if "window_s" in facts:
            facts["window_s"] = window
        series = {name: part.scaled(1.0, time_factor=factor) for name, part in self.series.items()}
        return replace(self, facts=facts, series=series, window=window, data=data)


_KINDS = {
    "DynamicTable": "storage and loss modulus over frequency",
    "RelaxationTable": "relaxation modulus over time",
    "CreepTable": "creep compliance over time",
}


def series_of(material: rs.Material) -> dict[str, rs.PronySeries]:
    """Return the relaxation functions of a material by name, without a constant bulk modulus."""
    series: dict[str, Any] = {"shear": material.shear, "bulk": material.bulk}
    return {name: part for name, part in series.items() if not isinstance(part, float)}


def of_material(material: rs.Material, title: str, kind: str, kelvin: float | None, law: ShiftTable | None) -> Report:
    """Report on a material."""
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
    series = series_of(material)
    return Report(title, facts, series, material.window or _window(series))


def of_data(data: Measured, source: str) -> Report:
    """Report on measured moduli or compliances and their fit."""
    fit = rs.fit_prony(data)
    facts = {
        "kind": _KINDS[type(data).__name__],
        "deformation": data.deformation or "not stated",
        "points": int(fit.residuals.size),
        "window_s": fit.window,
        "fitted_terms": fit.n_terms,
        "relative_misfit": fit.misfit,
        "largest_relative_residual": float(abs(fit.residuals).max()),
    }
    return Report(source, facts, {data.deformation or "fit": fit.series}, fit.window, data)


def of_isotherms(curve: rs.MasterCurve, source: str) -> Report:
    """Report on several temperatures and their master curve."""
    report, kelvin = of_data(curve.data, source), curve.temperatures
    facts: dict[str, Any] = {
        "kind": f"{report.facts.pop('kind')}, at {kelvin.size} temperatures",
        "lowest_temperature_K": float(kelvin[0]),
        "highest_temperature_K": float(kelvin[-1]),
        "reference_temperature_K": curve.reference_temperature,
        "superposition": curve.law,
        "misfit_of_superposition": curve.misfit,
    }
    for name, value in curve.constants.items():
        unit = {"c2": "_K", "activation_energy": "_J/mol"}.get(name, "")
        facts |= {f"{name}{unit}": value, f"standard_error_of_{name}{unit}": curve.constant_errors[name]}
    return replace(report, facts=facts | report.facts, shifts=curve, notes=curve.isotherms.notes)


def of_ramp(ramp: rs.TemperatureRamp, source: str, law: ShiftTable | None, kelvin: float | None) -> Report:
    """Report on a temperature ramp and the master curve that a law of the shift makes of it."""
    import numpy as np

    # The shape needs no frequency.
    data, shift = ramp.reduced(law, angular_frequency=None if ramp.angular_frequency else 2.0 * np.pi)
    report = of_data(data, source)
    facts: dict[str, Any] = {
        "kind": "storage and loss modulus over temperature",
        "deformation": ramp.deformation or "not stated",
        "points": int(ramp.temperatures.size),
        "lowest_temperature_K": float(ramp.temperatures[0]),
        "highest_temperature_K": float(ramp.temperatures[-1]),
        "frequency_Hz": None if ramp.angular_frequency is None else ramp.angular_frequency / (2.0 * np.pi),
        "reference_temperature_K": shift.reference_temperature,
    }
    notes = data.notes if ramp.angular_frequency else (*data.notes, "frequency not given: 1 Hz assumed")
    others = {key: value for key, value in report.facts.items() if key not in facts}
    return replace(report, facts=facts | others, notes=notes).shifted(shift, kelvin)


def of_terms(terms: PronyTerms, source: str) -> Report:
    """Report on Prony terms."""
    ends = terms.instantaneous_modulus, terms.equilibrium_modulus
    facts: dict[str, Any] = {
        "kind": "Prony terms",
        "deformation": terms.deformation or "not stated",
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


def of_hardness(hardness: float, scale: str, source: str) -> Report:
    """Report on Young's modulus from a Shore hardness."""
    from restitution.material.hardness import SOURCES

    young = rs.shore_modulus(hardness, scale)
    shear = young.shear_modulus
    facts: dict[str, Any] = {
        "kind": f"Shore {scale} hardness",
        "youngs_modulus_Pa": young.youngs_modulus,
        "lowest_youngs_modulus_Pa": young.low,
        "highest_youngs_modulus_Pa": young.high,
        "shear_modulus_Pa": shear,
        **{f"{name}_Pa": modulus for name, modulus in young.by_source.items()},
    }
    prior = f'{{ equilibrium_modulus = {{ lognormal = ["{shear / 1e6:.3g} MPa", {young.log_deviation:.2g}] }} }}'
    notes = (
        "a hardness has no loss, so that it gives no e; take it as a start for measured rebounds, in the section "
        f"[identification] as prior = {prior}",
        *(f"{name}: {SOURCES[name]}" for name in young.by_source),
        "the range is that of the sources, for a reading that is 5 points lower or higher",
    )
    return Report(source, facts, notes=notes)


def of_deck(deck: ViscoelasticDeck, source: str) -> Report:
    """Report on the deck of a solver."""
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
        series = {name: part.series(instantaneous_modulus=1.0) for name, part in parts.items() if part is not None}
    else:
        series = series_of(deck.material())
    return Report(source, facts, series, _window(series), relative=relative and bool(series))


def of_shift(table: ShiftTable, source: str, kelvin: float | None) -> Report:
    """Report on a table of shift factors."""
    facts: dict[str, Any] = {
        "kind": "shift factors over temperature",
        "points": int(table.temperatures.size),
        "lowest_temperature_K": float(table.temperatures[0]),
        "highest_temperature_K": float(table.temperatures[-1]),
        "reference_temperature_K": table.reference_temperature,
    }
    if kelvin is not None:
        facts |= {"temperature_K": kelvin, "shift_factor": table.factor(kelvin)}
    return Report(source, facts, shifts=table)


def _window(series: Mapping[str, rs.PronySeries]) -> tuple[float, float] | None:
    times = [float(time) for part in series.values() for time in part.relaxation_times]
    # Frequencies are inverse times, and both must be numbers that a double holds.
    return (max(min(times) / 10.0, 1e-290), min(max(times) * 10.0, 1e290)) if times else None


def material(
    source: Annotated[
        str | None,
        argument("FILE|NAME", "File, or material of the library.", autocompletion=completed("material.library.names")),
    ] = None,
    list_: Annotated[bool, typer.Option("--list", help="List the materials of the library.")] = False,
    at: Annotated[str | None, option('Temperature of the moduli, e.g. "20 degC" or 293.', "TEMPERATURE")] = None,
    shift: Annotated[Path | None, option("Shift factors over temperature, for a file of moduli.", "FILE")] = None,
    reference_temperature: Annotated[
        float | None,
        quantity("--reference-temperature", TEMPERATURE, "Temperature of the master curve of a file with several."),
    ] = None,
    superposition: Annotated[Literal["free", "wlf", "arrhenius"] | None, option("Shifts of such a file.")] = None,
    material_name: Annotated[str | None, option("Which material of a deck that has several.", "NAME")] = None,
    json: cli.Json = False,
    plot: cli.Plot = None,
) -> None:
    """Read a material from a file or the library, and show its data, fit and moduli.

    Relaxation, DMA and creep data are fitted by a Prony series. Several temperatures become one master curve first.
    Tables of Prony terms and of shift factors, decks of ANSYS and Abaqus, and materials of a case file are read too.
    A Shore hardness such as "60 Shore A" gives Young's modulus with its scatter.
    Example: restitution material examples/beads_dma.csv --plot moduli.png
    """
    if list_:
        sources = {name: rs.library.get(name).source or "" for name in rs.library.names()}
        if json:
            tables.write_json(sources)
        else:
            tables.print_rows("Materials of the library", ("name", "source"), list(sources.items()))
        return
    if source is None:
        raise cli.BadInput("material: give a file or a name, or --list")
    try:
        with cli.progress_bar("reading", begin="reading and fitting"):
            options = {"--reference-temperature": reference_temperature, "--superposition": superposition}
            reports = _reports(source, at, shift, material_name, options)
    except InputError as error:
        if error.field == "temperature" and at is not None and _is_celsius(at):
            raise cli.BadInput(f'{error}; a plain number is in K: write --at "{at} degC" for Celsius') from None
        raise
    if json:
        contents = [_content(report) for report in reports]
        tables.write_json(contents[0] if len(contents) == 1 else contents)
    else:
        for report in reports:
            _print(report)
            cli.report("note", *report.notes)
    if plot is not None:
        tables.save_picture(_picture(reports), plot)


def _is_celsius(text: str) -> bool:
    """Return whether a plain number is too low for most temperatures in kelvin."""
    try:
        return float(text) < 200.0
    except ValueError:
        return False


def _reports(
    source: str, at: str | None, shift: Path | None, name: str | None, options: dict[str, Any]
) -> list[Report]:
    """Return one report, or for a case file one for each of its materials."""
    from restitution.material.cards import PronyTerms, ViscoelasticDeck

    kelvin = None if at is None else cli.read_quantity("--at", at, TEMPERATURE)
    law = None if shift is None else rs.read_material(shift)
    if law is not None and not isinstance(law, rs.ShiftTable):
        raise cli.BadInput(f"--shift {shift}: must hold temperatures and shift factors")
    if law is not None and kelvin is None:
        raise cli.BadInput(f"--shift {shift}: give --at TEMPERATURE as well")
    if (hardness := _hardness(source)) is not None:
        return [of_hardness(*hardness, source)]
    content = _read(source, name)
    if isinstance(content, rs.Isotherms):
        curve = content.superposed(
            reference_temperature=options["--reference-temperature"], shift=options["--superposition"] or "free"
        )
        return [of_isotherms(curve, source).shifted(law or curve.shift, kelvin)]
    if isinstance(content, rs.TemperatureRamp):
        return [of_ramp(content, source, law, kelvin)]
    if unused := [option for option, value in options.items() if value is not None]:
        raise cli.BadInput(f"{unused[0]}: {source} must have moduli at several temperatures")
    match content:
        case list():
            # An elastic material needs no law of the shift.
            return [
                of_material(each, each.name or role, f"{role} of {source}", kelvin if _relaxes(each) else None, law)
                for role, each in content
            ]
        case rs.Material():
            return [of_material(content, source, "material of the library", kelvin, law)]
        case rs.ShiftTable():
            return [of_shift(content, source, kelvin)]
        case _ if kelvin is not None and law is None:
            rule = "a file of moduli has no law of the shift; give its shift factors by --shift FILE"
            raise cli.BadInput(f"--at: {rule}")
        case ViscoelasticDeck():
            report = of_deck(content, source)
        case PronyTerms():
            report = of_terms(content, source)
        case _:
            report = of_data(content, source)
    return [replace(report, notes=getattr(content, "notes", ())).shifted(law, kelvin)]


def _read(source: str, name: str | None) -> Any:
    """Return a material of the library, the roles and materials of a case, or the content of a file."""
    from restitution.quantities import advice

    path = Path(source)
    of_library = source in rs.library.names() and not path.exists()
    if not of_library and path.suffix != ".toml":
        if not path.exists() and not path.suffix:
            unknown = f"no such file, and no material of the library; {advice(source, rs.library.names())}"
            raise cli.BadInput(f"{source}: {unknown}")
        try:
            return rs.read_material(source, name=name)
        except ValueError as error:
            raise cli.BadInput(f"{error}{_other_use(source)}") from None
    if name is not None:
        raise cli.BadInput(f"--material-name {name}: {source} is no deck of a solver, whose materials have names")
    if of_library:
        return rs.library.get(source)
    from restitution.case.indentation import read_indentation
    from restitution.case.section import read_toml

    subject = read_indentation(source) if "indentation" in read_toml(path) else rs.read_case(source).impact
    materials = ((role, getattr(subject, role)) for role in ("material", "counter_material"))
    return [(role, each) for role, each in materials if each is not None]


def _hardness(source: str) -> tuple[float, str] | None:
    """Return number and scale of a Shore hardness; None for a file, a name and anything else."""
    from restitution.material.hardness import read_hardness

    return None if Path(source).exists() else read_hardness(source)


def _relaxes(material: rs.Material) -> bool:
    return not all(series.is_elastic for series in series_of(material).values())


def _other_use(source: str) -> str:
    """Return the advice on a table whose columns are those of an indentation or of bounces."""
    from restitution.case.quantity import named_columns

    try:
        columns = {name.casefold() for name in named_columns(".", source)}
    except ValueError:
        return ""
    return next((f". {advice}" for names, advice in _OTHERS if columns & names), "")


def _content(report: Report) -> dict[str, Any]:
    content = {key: value for key, value in report.facts.items() if value is not None}
    if report.notes:
        content["notes"] = report.notes
    pascals = "" if report.relative else "_Pa"
    for name, series in report.series.items():
        content[f"prony_{name}"] = {
            f"equilibrium_modulus{pascals}": series.equilibrium_modulus,
            f"branch_moduli{pascals}": series.branch_moduli,
            "relaxation_times_s": series.relaxation_times,
            f"parallel_viscosity{pascals}_s": series.parallel_viscosity,
        }
    if report.shifts is not None:
        content |= {"temperatures_K": report.shifts.temperatures, "log10_factors": report.shifts.log10_factors}
    if report.curve is not None:
        content["standard_errors"] = report.curve.errors
    return content


def _print(report: Report) -> None:
    import numpy as np

    facts = [_row(key, value) for key, value in report.facts.items() if value is not None]
    tables.print_rows(report.title, ("what", "value"), facts)
    if report.shifts is not None:
        columns, curve = ("temperature [°C]", "log10 aT"), report.curve
        pairs = zip(report.shifts.temperatures, report.shifts.log10_factors, strict=True)
        if curve is None:
            rows = [(celsius(kelvin), f"{factor:.6g}") for kelvin, factor in pairs]
            tables.print_rows("Shift factors", columns, rows)
        else:
            columns, triples = (*columns, "standard error"), zip(pairs, curve.errors, strict=True)
            rows = [(celsius(kelvin, 5), f"{factor:.4g}", f"{error:.2g}") for (kelvin, factor), error in triples]
            tables.print_rows("Shifts", columns, rows)
    unit = "-" if report.relative else MODULUS.unit
    for name, series in report.series.items():
        if report.window is None or not series.n_branches:
            modulus = f"{series.equilibrium_modulus:.6g}"
            tables.print_rows(f"Modulus, {name}", (f"modulus [{unit}]",), [(modulus,)])
            continue
        t = np.geomspace(*report.window, _ROWS)
        values = t, series.relaxation_modulus(t), series.storage_modulus(1.0 / t), series.loss_modulus(1.0 / t)
        columns = ("t = 1/omega [s]", *(f"{kind} [{unit}]" for kind in ("relaxation", "storage", "loss")))
        rows = [tuple(f"{value:.4g}" for value in row) for row in np.stack(values, axis=1).tolist()]
        tables.print_rows(f"Moduli, {name}", columns, rows)


def _row(key: str, value: Any) -> tuple[str, str]:
    """Return the words with the unit, and value, of a fact; temperatures are in °C, as in the tables of shifts."""
    if key.endswith("temperature_K"):
        return f"{key.removesuffix('_K').replace('_', ' ')} [°C]", celsius(value)
    name, _, unit = key.replace("_kg_m3", f"_{DENSITY.unit}").rpartition("_")
    words = f"{name} [{unit}]" if unit in _UNITS else key
    return words.replace("_", " "), _text(value)


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


def _picture(reports: list[Report]) -> Any:
    from restitution.plot import material as pictures

    first, several = reports[0], len(reports) > 1
    if first.shifts is not None:
        draw: Any = pictures.shift_factors if first.curve is None else pictures.superposition
        return draw(first.shifts)
    series = {f"{item.title}, {k}" if several else k: v for item in reports for k, v in item.series.items()}
    windows = [report.window for report in reports if report.window is not None] or [(1e-6, 1.0)]
    window = min(low for low, _ in windows), max(high for _, high in windows)
    unit = "" if all(report.relative for report in reports) else MODULUS.unit
    return pictures.overview(series, window, first.data, unit=unit)
