"""Reports on materials: printed, as JSON, or drawn."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

import numpy as np

from restitution.cli import tables
from restitution.cli.exit_codes import BadInput, tell, user_input
from restitution.errors import InputError
from restitution.material.deck import PronyTerms, ViscoelasticDeck
from restitution.material.fit import DynamicTable, RelaxationTable
from restitution.material.prony import PronySeries
from restitution.material.shift import ShiftTable
from restitution.material.viscoelastic import Material

# Rows of the table of moduli: enough to see each transition, few enough for a screen.
_ROWS = 9


@dataclass
class Report:
    """Facts, relaxation functions, the window of the pictures, and data of a material."""

    title: str
    facts: dict[str, Any]
    series: dict[str, PronySeries] = field(default_factory=dict[str, PronySeries])
    window: tuple[float, float] | None = None
    data: RelaxationTable | DynamicTable | ShiftTable | None = None
    content: Any = None

    @property
    def notes(self) -> tuple[str, ...]:
        """Remarks of the reader of the file, such as units that were assumed."""
        return getattr(self.content, "notes", ())

    @property
    def relative(self) -> bool:
        """Whether the moduli are shares of a modulus that the file does not give."""
        return any("relative" in name for name in self.series)


def show(
    source: str | None,
    in_list: bool,
    at: str | None,
    shift: Path | None,
    material_name: str | None,
    in_json: bool,
    plot: Path | None,
) -> None:
    """Show the material of a file or a name, or the list of the library."""
    tables.check_target("--plot", plot, tables.PICTURES)
    with user_input():
        if in_list:
            _list(in_json)
            return
        if source is None:
            raise BadInput("material: give a file or a name, or --list")
        try:
            reports = _reports(source, at, shift, material_name)
        except InputError as error:
            if error.field == "temperature" and at is not None and _is_plain_below(at, 200.0):
                raise BadInput(f'{error}; a plain number is in K: write --at "{at} degC" for Celsius') from None
            raise
    if in_json:
        contents = [_content(report) for report in reports]
        tables.write_json(contents[0] if len(contents) == 1 else contents)
    else:
        for report in reports:
            _print(report)
            for note in report.notes:
                tell("note", note, "cyan")
    if plot is not None:
        _draw(reports, plot)


def _list(in_json: bool) -> None:
    from restitution.material import library

    materials = {name: library.get(name) for name in library.names()}
    if in_json:
        tables.write_json({name: one.source for name, one in materials.items()})
    else:
        rows = [(name, one.source or "") for name, one in materials.items()]
        tables.print_rows("Materials of the library", ("name", "source"), rows)


def _reports(source: str, at: str | None, shift: Path | None, name: str | None) -> list[Report]:
    """What a source says: one report, of a case file one for each of its materials."""
    from restitution.material import library
    from restitution.material.readers import read_material
    from restitution.quantities import TEMPERATURE

    kelvin = None if at is None else tables.read_quantity("--at", at, TEMPERATURE)
    law = None if shift is None else _law(shift)
    if law is not None and kelvin is None:
        raise BadInput(f"--shift {shift}: give --at TEMPERATURE as well")
    named = source in library.names() and not Path(source).exists()
    if name is not None and (named or Path(source).suffix == ".toml"):
        raise BadInput(f"--material-name {name}: {source} is no deck of a solver, whose materials have names")
    if named:
        return [_of_material(library.get(source), source, "material of the library", kelvin, law)]
    if Path(source).suffix == ".toml":
        return _of_case(source, kelvin, law)
    if not Path(source).exists() and not Path(source).suffix:
        raise BadInput(f"{source}: no such file, and no material of the library: {', '.join(library.names())}")
    try:
        content = read_material(source, name=name)
    except ValueError as error:
        raise BadInput(f"{error}{_other_use(source)}") from None
    if isinstance(content, ShiftTable):
        return [_of_shift(content, source, kelvin)]
    if kelvin is not None and law is None:
        raise BadInput("--at: a file of moduli has no law of the shift; give its shift factors by --shift FILE")
    match content:
        case RelaxationTable() | DynamicTable():
            report = _of_data(content, source)
        case PronyTerms():
            report = _of_terms(content, source)
        case ViscoelasticDeck():
            report = _of_deck(content, source)
    report.content = content
    return [report if law is None or kelvin is None else _shifted(report, law, kelvin)]


def _is_plain_below(text: str, limit: float) -> bool:
    try:
        return float(text) < limit
    except ValueError:
        return False


def _other_use(source: str) -> str:
    """Advice on a table whose columns are those of an indentation or of bounces."""
    from restitution.case.profile import named_columns

    try:
        columns = {name.casefold() for name in named_columns(".", source)}
    except ValueError:
        return ""
    if columns & {"depth", "indentation", "force", "displacement", "deflection"}:
        return ". A curve of depth or force is no material: `restitution indent` takes it as indentation.file"
    if columns & {"bounce", "height", "rebound", "drop", "drop_height"}:
        return ". Heights or velocities of bounces are no material: `restitution bounce` computes them from one"
    return ""


def _law(path: Path) -> ShiftTable:
    from restitution.material.readers import read_material

    table = read_material(path)
    if not isinstance(table, ShiftTable):
        raise BadInput(f"--shift {path}: must hold temperatures and shift factors")
    return table


def _of_case(source: str, kelvin: float | None, law: ShiftTable | None) -> list[Report]:
    from restitution.case.impact import read_case

    impact = read_case(source).impact
    parts = {"material": impact.material, "counter_material": impact.counter_material}
    # An elastic material needs no law of the shift.
    return [
        _of_material(one, one.name or name, f"{name} of {source}", None if _is_elastic(one) else kelvin, law)
        for name, one in parts.items()
        if one is not None
    ]


def _shifted(report: Report, law: ShiftTable, kelvin: float) -> Report:
    """What was read at the reference temperature of a law, at another one."""
    factor = law.factor(kelvin)
    data = report.data
    if isinstance(data, RelaxationTable):
        data = replace(data, time=data.time * factor)
    elif isinstance(data, DynamicTable):
        data = replace(data, angular_frequency=data.angular_frequency / factor)
    window = None if report.window is None else (report.window[0] * factor, report.window[1] * factor)
    facts: dict[str, Any] = {"temperature_K": kelvin, "shift_factor": factor}
    if "window_s" in report.facts:
        facts["window_s"] = window
    series = {name: one.scaled(1.0, time_factor=factor) for name, one in report.series.items()}
    return Report(report.title, report.facts | facts, series, window, data, report.content)


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
    series = {"shear": material.shear}
    if isinstance(material.bulk, PronySeries):
        series["bulk"] = material.bulk
    return Report(title, facts, series, material.window or _window(series))


def _is_elastic(material: Material) -> bool:
    bulk = material.bulk
    return material.shear.is_elastic and (not isinstance(bulk, PronySeries) or bulk.is_elastic)


def _of_data(data: RelaxationTable | DynamicTable, source: str) -> Report:
    from restitution.material.fit import fit_prony

    fit = fit_prony(data)
    dynamic = isinstance(data, DynamicTable)
    facts = {
        "kind": "storage and loss modulus over frequency" if dynamic else "relaxation modulus over time",
        "deformation": data.deformation or "not said",
        "points": int(fit.residuals.size),
        "window_s": fit.window,
        "fitted_terms": fit.n_terms,
        "relative_misfit": fit.misfit,
        "largest_relative_residual": float(np.abs(fit.residuals).max()),
        "notes": "; ".join(data.notes) or None,
    }
    return Report(source, facts, {data.deformation or "fit": fit.series}, fit.window, data)


def _of_terms(terms: PronyTerms, source: str) -> Report:
    facts: dict[str, Any] = {
        "kind": "Prony terms",
        "deformation": terms.deformation or "not said",
        "terms": int(terms.moduli.size),
        "relative": terms.relative,
        "sum": float(terms.moduli.sum()),
        "instantaneous_modulus_Pa": terms.instantaneous_modulus,
        "equilibrium_modulus_Pa": terms.equilibrium_modulus,
        "notes": "; ".join(terms.notes) or None,
    }
    ends = terms.instantaneous_modulus, terms.equilibrium_modulus
    if terms.relative and ends == (None, None):
        # Shares of a modulus that the file does not know: of 1 Pa.
        series, name = terms.series(instantaneous_modulus=1.0), "relative to the instantaneous modulus"
    else:
        series, name = terms.series(), terms.deformation or "modulus"
    return Report(source, facts, {name: series}, _window({name: series}))


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
    series: dict[str, PronySeries] = {}
    if deck.youngs_modulus is not None and deck.poisson_ratio is not None:
        found = deck.material()
        series["shear"] = found.shear
        if isinstance(found.bulk, PronySeries):
            series["bulk"] = found.bulk
    else:
        for name, terms in (("shear", deck.shear), ("bulk", deck.bulk)):
            if terms is not None:
                series[f"{name}, relative"] = terms.series(instantaneous_modulus=1.0)
    return Report(source, facts, series, _window(series))


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
    return Report(source, facts, data=table)


def _window(series: Mapping[str, PronySeries]) -> tuple[float, float] | None:
    times = np.concatenate([one.relaxation_times for one in series.values()]) if series else np.empty(0)
    if not times.size:
        return None
    # Frequencies are inverse times, and both must be numbers that a double holds.
    return max(float(times.min()) / 10.0, 1e-290), min(float(times.max()) * 10.0, 1e290)


def _content(report: Report) -> dict[str, Any]:
    content = {key: value for key, value in report.facts.items() if value is not None}
    if report.notes:
        content["notes"] = list(report.notes)
    pascals = "" if report.relative else "_Pa"
    for name, one in report.series.items():
        content[f"prony_{name}"] = {
            f"equilibrium_modulus{pascals}": one.equilibrium_modulus,
            f"branch_moduli{pascals}": one.branch_moduli.tolist(),
            "relaxation_times_s": one.relaxation_times.tolist(),
            f"parallel_viscosity{pascals}_s": one.parallel_viscosity,
        }
    if isinstance(report.data, ShiftTable):
        content["temperatures_K"] = report.data.temperatures.tolist()
        content["log10_factors"] = report.data.log10_factors.tolist()
    return content


def _print(report: Report) -> None:
    rows = [(_words(key), _text(value)) for key, value in report.facts.items() if value is not None]
    tables.print_rows(report.title, ("what", "value"), rows)
    if isinstance(report.data, ShiftTable):
        table = report.data
        pairs = zip(table.temperatures, table.log10_factors, strict=True)
        rows = [(f"{kelvin - 273.15:.6g}", f"{factor:.6g}") for kelvin, factor in pairs]
        tables.print_rows("Shift factors", ("temperature [°C]", "log10 aT"), rows)
    for name, one in report.series.items():
        unit = "-" if report.relative else "Pa"
        if report.window is None or not one.n_branches:
            tables.print_rows(f"Modulus, {name}", ("modulus [Pa]",), [(f"{one.equilibrium_modulus:.6g}",)])
            continue
        t = np.geomspace(*report.window, _ROWS)
        values = (t, one.relaxation_modulus(t), one.storage_modulus(1.0 / t), one.loss_modulus(1.0 / t))
        columns = ("t = 1/omega [s]", *(f"{kind} [{unit}]" for kind in ("relaxation", "storage", "loss")))
        rows = [tuple(f"{value:.4g}" for value in row) for row in np.stack(values, axis=1).tolist()]
        tables.print_rows(f"Moduli, {name}", columns, rows)


def _words(key: str) -> str:
    name, _, unit = key.rpartition("_")
    if unit in ("K", "s", "Pa"):
        return f"{name.replace('_', ' ')} [{unit}]"
    return key.replace("_kg_m3", " [kg/m3]").replace("_", " ")


def _text(value: Any) -> str:
    if isinstance(value, bool):
        return "yes" if value else "no"
    if isinstance(value, float):
        return f"{value:.6g}" if math.isfinite(value) else "infinite"
    if isinstance(value, tuple):
        return " to ".join(f"{float(part):.3g}" for part in value)
    return str(value)


def _draw(reports: list[Report], path: Path) -> None:
    from restitution.plot import material as pictures
    from restitution.plot.style import save_figure

    first = reports[0]
    if isinstance(first.data, ShiftTable):
        save_figure(pictures.shift_factors(first.data), path)
        return
    series = {
        f"{report.title}, {name}" if len(reports) > 1 else name: one
        for report in reports
        for name, one in report.series.items()
    }
    windows = [report.window for report in reports if report.window is not None] or [(1e-6, 1.0)]
    window = min(low for low, _ in windows), max(high for _, high in windows)
    unit = "" if all(report.relative for report in reports) else "Pa"
    save_figure(pictures.overview(series, window, first.data, unit=unit), path)
