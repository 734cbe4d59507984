"""Summaries of impacts and of bounces: the tables that results show."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np

from restitution.display import Summary, Table, in_words, of_values, plain_symbol, scaled_unit
from restitution.impact.status import Status
from restitution.quantities import OUTPUTS

if TYPE_CHECKING:
    from restitution.impact.bounces import Bounces
    from restitution.impact.result import ImpactResult

# Bounces that a screen holds; of more, the first and the last are shown.
_SHOWN, _LAST = 24, 4


def of_impact(result: ImpactResult, title: str = "", *, dimensionless: bool = False) -> Summary:
    """Table of one impact: outputs, semi-axes, the return to the surface; method and balance below."""
    # A number below the tolerance times the largest of its kind is rounding.
    tolerance = 1e-9 if result.rtol is None else float(result.rtol)
    noise = {"m": tolerance * float(result.max_indentation_depth), "J": tolerance * float(result.energy.kinetic_in)}
    found = [(OUTPUTS[name], float(value)) for name, value in result.outputs.items() if name != "energy_residual"]
    values = [
        (one.words, plain_symbol(one.symbol), 0.0 if abs(value) < noise.get(one.unit, 0.0) else value, one.unit)
        for one, value in found
    ]
    long, short = result.max_semi_axes
    if short < long:
        words = "semi-axis of the largest contact"
        values += [(f"long {words}", "a", float(long), "m"), (f"short {words}", "b", float(short), "m")]
    values.append(("back at the undeformed surface", "t_0", float(result.zero_overlap_time), "s"))
    stated = "" if result.rtol is None else f", rtol {result.rtol:g}"
    residual = float(result.energy.residual)
    balance = f", energy residual {residual:.1e}" if math.isfinite(residual) else ""
    status = Status(int(result.status))
    return Summary(
        title or f"Impact of {in_words(float(result.mass), 'kg')} at {in_words(float(result.velocity), 'm/s')}",
        of_values(values, units=not dimensionless),
        (f"method {result.method}{stated}{balance}",),
        warnings=(*result.warnings, *([] if status == Status.SEPARATED else [status.message])),
    )


def of_impacts(result: ImpactResult, title: str = "") -> Summary:
    """Table of several impacts: the lowest and the highest of each output that is stored; their ends below."""
    statuses = np.asarray(result.status)
    rows: list[tuple[str, ...]] = []
    for name in ("velocity", *(name for name in OUTPUTS if name in result.__dataclass_fields__)):
        one = OUTPUTS.get(name)
        values = np.asarray(getattr(result, name), dtype=np.float64)
        values = values[np.isfinite(values)]
        unit = "m/s" if one is None else one.unit
        factor, prefixed = scaled_unit(values, unit)
        ends = [f"{factor * end:.6g}" for end in (values.min(), values.max())] if values.size else ["-", "-"]
        words, symbol = ("impact velocity", "v_0") if one is None else (one.words, plain_symbol(one.symbol))
        rows.append((words, symbol, *ends, prefixed))
    counts = [(one, int(np.count_nonzero(statuses == one))) for one in Status]
    shape = f"a list of {statuses.size}" if isinstance(result.impact, list) else f"shape {statuses.shape}"
    stated = "" if result.rtol is None else f", rtol {result.rtol:g}"
    return Summary(
        title or f"{statuses.size} impacts, {shape}",
        Table(("quantity", "symbol", "lowest", "highest", "unit"), rows),
        (", ".join(f"{n} {one.name}" for one, n in counts if n), f"method {result.method}{stated}"),
        warnings=result.warnings,
    )


def of_bounces(found: Bounces, title: str = "") -> Summary:
    """Table with a row for each bounce; the end below."""
    heights, times = scaled_unit(found.drop_height, "m"), scaled_unit(found.contact_time, "s")
    titles = (
        "bounce", "touch at [s]", "velocity [m/s]", "restitution e", f"contact time [{times.unit}]",
        "tan delta", f"rises to [{heights.unit}]",
    )  # fmt: skip

    def row(n: int) -> tuple[str, ...]:
        duration = found.contact_time[n] * times.factor
        touch = f"{found.touch_time[n]:.6g}", f"{found.velocity[n]:.4g}", f"{found.restitution_coefficient[n]:.6g}"
        lasts = f"{duration:.4g}" if math.isfinite(duration) else "stays"
        tangent = f"{found.loss_tangent[n]:.4g}" if math.isfinite(found.loss_tangent[n]) else "-"
        return str(n + 1), *touch, lasts, tangent, f"{found.height[n] * heights.factor:.4g}"

    count = found.n_bounces
    rows = [row(n) for n in range(count) if count <= _SHOWN or not _SHOWN - _LAST <= n < count - _LAST]
    if count > _SHOWN:
        rows.insert(_SHOWN - _LAST, ("…",) * len(titles))
    end = f"{found.touch_time[-1]:.6g} s; {found.ended}: {found.ended.message}"
    return Summary(
        f"{title or 'Bounces'}, from {found.drop_height * heights.factor:.6g} {heights.unit}",
        Table(titles, rows),
        (f"{count} bounce{'s' * (count != 1)} in {end}",),
        warnings=found.warnings,
    )
