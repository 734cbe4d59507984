"""Facts about a material of a file, of the library or of a case file: what the command `material` shows."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING, Any

# Help must load nothing heavy.
if TYPE_CHECKING:
    from restitution.material.deck import PronyTerms, ViscoelasticDeck
    from restitution.material.fit import DynamicTable, RelaxationTable
    from restitution.material.isotherms import MasterCurve
    from restitution.material.prony import PronySeries
    from restitution.material.shift import Shift, ShiftTable
    from restitution.material.viscoelastic import Material


@dataclass
class Report:
    """Facts about a material, its relaxation functions, its data, and the window of times of the pictures."""

    title: str
    facts: dict[str, Any]
    series: dict[str, PronySeries] = field(default_factory=dict[str, "PronySeries"])
    window: tuple[float, float] | None = None
    data: RelaxationTable | DynamicTable | None = None
    factors: ShiftTable | None = None
    curve: MasterCurve | None = None
    notes: tuple[str, ...] = ()  # remarks of the reader of the file, such as units that were assumed
    relative: bool = False  # whether the moduli are shares of a modulus that the file does not give


def shifted(made: Report, law: Shift, kelvin: float) -> Report:
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


def series_of(material: Material) -> dict[str, PronySeries]:
    """Relaxation functions of a material by name, without a constant bulk modulus."""
    series: dict[str, Any] = {"shear": material.shear, "bulk": material.bulk}
    return {name: one for name, one in series.items() if not isinstance(one, float)}


def of_material(material: Material, title: str, kind: str, kelvin: float | None, law: ShiftTable | None) -> Report:
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


def of_data(data: RelaxationTable | DynamicTable, source: str) -> Report:
    """Report on measured moduli and their fit."""
    from restitution.material.fit import DynamicTable, fit_prony

    fit, dynamic = fit_prony(data), isinstance(data, DynamicTable)
    facts = {
        "kind": "storage and loss modulus over frequency" if dynamic else "relaxation modulus over time",
        "deformation": data.deformation or "not stated",
        "points": int(fit.residuals.size),
        "window_s": fit.window,
        "fitted_terms": fit.n_terms,
        "relative_misfit": fit.misfit,
        "largest_relative_residual": float(abs(fit.residuals).max()),
    }
    return Report(source, facts, {data.deformation or "fit": fit.series}, fit.window, data)


def of_isotherms(curve: MasterCurve, source: str) -> Report:
    """Report on several temperatures and their master curve."""
    made = of_data(curve.data, source)
    kelvin, errors = curve.temperatures, curve.constant_errors
    facts: dict[str, Any] = {
        "kind": f"{made.facts['kind']}, at {kelvin.size} temperatures",
        "lowest_temperature_K": float(kelvin[0]),
        "highest_temperature_K": float(kelvin[-1]),
        "reference_temperature_K": curve.reference_temperature,
        "superposition": curve.law,
        "misfit_of_superposition": curve.misfit,
    }
    for name, value in curve.constants.items():
        unit = {"c2": "_K", "activation_energy": "_J/mol"}.get(name, "")
        facts |= {f"{name}{unit}": value, f"standard_error_of_{name}{unit}": errors[name]}
    made.facts = facts | {key: value for key, value in made.facts.items() if key != "kind"}
    made.curve, made.notes = curve, curve.isotherms.notes
    return made


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
        series = {name: one.series(instantaneous_modulus=1.0) for name, one in parts.items() if one is not None}
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
    return Report(source, facts, factors=table)


def _window(series: Mapping[str, PronySeries]) -> tuple[float, float] | None:
    times = [float(time) for one in series.values() for time in one.relaxation_times]
    # Frequencies are inverse times, and both must be numbers that a double holds.
    return (max(min(times) / 10.0, 1e-290), min(max(times) * 10.0, 1e290)) if times else None
