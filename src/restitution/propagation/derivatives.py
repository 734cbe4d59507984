"""Derivatives of the outputs of impacts by their inputs, from one array of changed impacts."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

import numpy as np

from restitution import checks
from restitution.axes import Axes, unnamed
from restitution.checks import Array, Numeric, items
from restitution.errors import InputError
from restitution.impact.adhesive import LEAST_RTOL
from restitution.impact.batch import shaped, solve_columns
from restitution.impact.oblique import TANGENTIAL_RTOL, join_sliding, normal_rtol
from restitution.impact.problem import Impact, require_outputs
from restitution.impact.status import SolverError, Status
from restitution.numerics.differences import LONG_STEP, NINE, Slopes, slopes
from restitution.propagation.inputs import Input, Model, model_of
from restitution.quantities import (
    DEFAULT_OUTPUTS,
    ENERGIES,
    IMPACT_OUTPUTS,
    OBLIQUE,
    SOLVER_RTOL,
    STATUS,
    checked_outputs,
    choice,
    needs,
)
from restitution.result import Result, Summary, Table, plain_symbol
from restitution.variation import HeldElastic

if TYPE_CHECKING:
    import xarray

DERIVATIVE_RTOL = 1e-11
"""Tolerance of the solves whose differences are taken."""

# Errors of outputs over the tolerance, which is that of e; the largest of the surrogates is 14.
_OF_OUTPUTS = 20.0
# Shares of the usual steps that are tried in turn, and the relative error below which no further one is; with adhesion
# smaller steps help only where a larger step meets capture.
_SHARES, _GOOD, _GOOD_ADHESIVE = (1.0, 0.25, 0.0625), 1e-9, 1e-3
# Relative error of a derivative above which the result has a warning; e_t, and all with adhesion, are known to 1e-6.
_DOUBTFUL, _DOUBTFUL_SOLVES = 1e-4, 1e-2


@dataclass(frozen=True, eq=False, repr=False)
class Derivatives(Result):
    """Derivatives of outputs by inputs, in SI; see `restitution.derivatives`.

    ``derivatives["contact_time", "velocity"]`` is one of them.

    Attributes
    ----------
    outputs, inputs : tuple of str
        Names.
    values, at : dict of str to float or array
        The outputs and the inputs themselves, by name.
    matrix : array, shape (n_output, n_input, ...)
        Derivatives dy/dx, for arrays of impacts with their shape behind.
    errors : array, shape (n_output, n_input, ...)
        Estimates of their errors; infinite where an impact beside this one failed or ended in another way.
    second : array, shape (n_output, n_input, ...)
        Second derivatives by each input alone, of low accuracy.
    rtol : float
        Tolerance of the solves.
    axes
        Names of the axes of an array of impacts.
    warnings : tuple of str
        Derivatives that are doubtful.
    """

    _numbers = ("outputs", "inputs", "values", "at", "matrix", "errors", "elasticities", "rtol", "warnings")
    _picture = "propagation.elasticities"

    outputs: tuple[str, ...]
    inputs: tuple[str, ...]
    values: dict[str, Numeric]
    at: dict[str, Numeric]
    matrix: Array
    errors: Array
    second: Array
    rtol: float
    axes: Axes | None = field(default=None, repr=False)
    warnings: tuple[str, ...] = ()

    def __getitem__(self, pair: tuple[str, str]) -> Any:
        """Return the derivative of an output by an input, a number or an array."""
        output, name = checks.pair("derivatives", pair, "take a pair of an output and an input")
        place = self.outputs.index(choice("output", output, self.outputs))
        return self.matrix[place, self.inputs.index(choice("input", name, self.inputs))][()]

    @property
    def elasticities(self) -> Array:
        """Relative change of an output over that of an input, (x/y) dy/dx; NaN where an output is 0."""
        with np.errstate(divide="ignore", invalid="ignore"):
            share = self._column(self.at, self.inputs)[None] / self._column(self.values, self.outputs)[:, None]
            return np.where(np.isfinite(share), self.matrix * share, np.nan)

    def _column(self, numbers: Mapping[str, Numeric], names: Sequence[str]) -> Array:
        shape = self.matrix.shape[2:]
        return np.stack([np.broadcast_to(np.asarray(numbers[name]), shape) for name in names])

    def to_dataset(self) -> xarray.Dataset:
        """Return the derivatives over the inputs, with a variable `..._error` for each output."""
        import xarray as xr

        shape = self.matrix.shape[2:]
        places = None if not shape else (self.axes or unnamed(shape)).array(np.zeros(shape))
        columns: dict[str, Any] = {}
        for output, rows, errors in zip(self.outputs, self.matrix, self.errors, strict=True):
            words = f"derivative of {IMPACT_OUTPUTS[output].words}"
            for name, numbers, text in ((output, rows, words), (f"{output}_error", errors, f"error of the {words}")):
                if places is None:
                    columns[name] = xr.DataArray(numbers, dims="input", attrs={"long_name": text})
                    continue
                parts = [places.copy(data=row.reshape(places.shape)) for row in numbers]
                columns[name] = xr.concat(parts, "input").assign_attrs(long_name=text)
        return xr.Dataset(columns, coords={"input": list(self.inputs)}, attrs={"rtol": self.rtol})

    def summary(self, title: str = "") -> Summary:
        """Return the table of relative changes, which `print` and notebooks show; of arrays the largest changes."""
        relative = np.where(np.abs(self.matrix) < self.errors, 0.0, self.elasticities)
        if relative.ndim > 2:
            flat = relative.reshape(*relative.shape[:2], -1)
            pick = np.argmax(np.nan_to_num(np.abs(flat)), axis=-1)
            relative = np.take_along_axis(flat, pick[..., None], axis=-1)[..., 0]
        head = ("input", *(plain_symbol(IMPACT_OUTPUTS[name].symbol) or name for name in self.outputs))
        rows = [
            (name, *("-" if math.isnan(x) else f"{x + 0.0:.6g}" for x in column))
            for name, column in zip(self.inputs, relative.T, strict=True)
        ]
        words = "change of an output in per cent for one per cent of an input"
        words += "; of several impacts the largest" if self.matrix.ndim > 2 else ""
        return Summary(title or f"Derivatives: {words}", Table(head, rows), (self._accuracy,), warnings=self.warnings)

    @property
    def _accuracy(self) -> str:
        with np.errstate(divide="ignore", invalid="ignore"):
            relative = np.where(np.abs(self.matrix) < self.errors, 0.0, self.errors / np.abs(self.matrix))
        return f"errors of the derivatives are estimated as at most {np.nanmax(relative, initial=0.0):.1e} of each"

    @property
    def _short(self) -> str:
        return f"{len(self.outputs)} outputs by {', '.join(self.inputs)}"


def derivatives(
    impact: Impact,
    names: Iterable[str],
    outputs: Iterable[str] = DEFAULT_OUTPUTS,
    *,
    held: HeldElastic = "bulk_modulus",
    steps: Mapping[str, float] | None = None,
    rtol: float = DERIVATIVE_RTOL,
    workers: int | None = None,
) -> Derivatives:
    """Return the derivatives of the outputs of an impact by its numbers.

    Parameters
    ----------
    impact : Impact
        The impact, single or an array.
    names : sequence of str
        Names of the inputs, as in `restitution.vary`: `velocity`, `mass`, `radius`, `equilibrium_modulus`,
        `branch_modulus`, `viscosity`, `poisson_ratio`, `temperature`, `branch_moduli[0]`, `relaxation_times[0]` and
        so on.
    outputs : sequence of str
        Names of the outputs of `restitution.quantities.IMPACT_OUTPUTS`; the default are restitution coefficient,
        contact time, largest depth and largest force.
    held : {"bulk_modulus", "poisson_ratio"}
        Which of the two stays constant where `equilibrium_modulus` changes and neither of them is among the names.
    steps : dict of str to float, optional
        Steps in SI by name, in place of the usual ones; needed for a number that is 0 at the end of its range.
    rtol : float
        Tolerance of the solves.
    workers : int, optional
        Number of threads; by default the number of cores.

    Returns
    -------
    Derivatives
        The matrix dy/dx with an estimate of its errors.

    Raises
    ------
    InputError
        If a name is not known, or a number has no derivative or no step.
    SolverError
        If the impact itself is not solved.

    Notes
    -----
    Partial derivatives: the other names keep their values, and what no name sets is held as in `vary`.

    For each input, eight impacts beside `impact` are solved, all in one array: at steps of 2 % of a positive
    number, of 0.02 in the logit of a number between two ends, of 0.5 K, or to one side at an end of a range. The
    derivative is that of the polynomial through the nine values, of order 8; see
    `restitution.numerics.differences.slopes` for the estimate of its error, to which 20 times the tolerance of the
    solves is added. Where the estimate is above 1e-9, smaller steps are tried and the best is taken.

    Examples
    --------
    >>> import restitution as rs
    >>> steel = rs.elastic(shear_modulus=80e9, poisson_ratio=0.3)
    >>> ball = rs.Impact(steel, rs.Parabola(0.01), mass=0.03, velocity=0.1)
    >>> by = rs.derivatives(ball, ["velocity", "mass"])
    >>> print(by.elasticities[1].round(9))  # Hertz: the contact time grows as v^(-1/5) m^(2/5)
    [-0.2  0.4]
    """
    checks.instance("impact", impact, Impact, "must be an Impact")
    listed = [names] if isinstance(names, str) else items("names", names, "must be a sequence of names")
    for name in listed:
        checks.instance("names", name, str, "must be a sequence of names")
    if not listed:
        raise InputError("names", rule="must name at least one input")
    widths = None if steps is None else checks.mapping("steps", steps)
    for name in widths or ():
        choice("steps", name, listed)
    checks.one_of("held", held, ("bulk_modulus", "poisson_ratio"))
    return differentiate(model_of(impact, listed, held, widths), output_names(outputs), rtol, workers)


def output_names(outputs: Any) -> tuple[str, ...]:
    """Return names of outputs of impacts in the order of the registry."""
    # Residuals and errors are rounding.
    return checked_outputs(outputs, [name for name in IMPACT_OUTPUTS if not name.endswith(("_residual", "_error"))])


def solved(model: Model, values: Mapping[str, Array], outputs: Sequence[str], rtol: float, workers: int | None) -> Any:
    """Return outputs and statuses of n impacts by name, each of shape (n, *shape)."""
    wide = {name: column[:, None] if model.shape and column.ndim == 1 else column for name, column in values.items()}
    impacts = model.build(wide)
    energy = needs(outputs, ENERGIES)
    require_outputs(impacts, outputs)
    slides = not set(OBLIQUE).isdisjoint(outputs)
    least = normal_rtol(rtol) if slides else rtol
    columns = solve_columns(impacts, least, workers=workers, energy=energy, pressure="max_pressure" in outputs)
    if slides:
        join_sliding(impacts, columns, rtol, workers)
    n = len(next(iter(values.values())))
    noise = {"m": columns["max_indentation_depth"], "J": columns["kinetic_energy_in"]}
    result = {STATUS: columns[STATUS].reshape(n, *model.shape)}
    for name in outputs:
        # A number below the tolerance times the largest of its kind is rounding, as the imprint of an elastic body.
        least = rtol * noise.get(IMPACT_OUTPUTS[name].unit, 0.0)
        result[name] = np.where(np.abs(columns[name]) < least, 0.0, columns[name]).reshape(n, *model.shape)
    return result


def differentiate(model: Model, outputs: tuple[str, ...], rtol: float, workers: int | None = None) -> Derivatives:
    """Return the derivatives of the impacts of a model at the values of its inputs."""
    tolerance = float(checks.single("rtol", SOLVER_RTOL.check(rtol)))
    shape, count = model.shape, len(model.inputs)
    if model.adhesive:
        tolerance = max(tolerance, LEAST_RTOL)
    errors = [max(tolerance, TANGENTIAL_RTOL) if name in OBLIQUE else tolerance for name in outputs]
    best = Slopes(*(np.full((len(outputs), count, *shape), start) for start in (np.nan, np.inf, np.nan)))
    values: dict[str, Numeric] = {}
    rough, scale = list(range(count)), np.empty(0)
    for share in _SHARES:
        columns = solved(model, _points(model, rough, share), outputs, tolerance, workers)
        if not values:
            values = {name: shaped(columns[name][0], shape) for name in outputs}
            _refuse_failed(columns[STATUS][0])
            scale = _scales(model, values, outputs)
        for n, k in enumerate(rough):
            places = NINE[0].rows(n)
            same = (columns[STATUS][places] == columns[STATUS][0]).all(axis=0)
            for output, name in enumerate(outputs):
                line = columns[name][0], columns[name][places]
                new = _slopes(model.inputs[k], share, line, same, errors[output])
                better = new.error < best.error[output, k]
                for target, part in zip(best, new, strict=True):
                    target[output, k] = np.where(better, part, target[output, k])
        allowed = np.array(errors).reshape(-1, *(1,) * (best.error.ndim - 1))
        enough = _GOOD_ADHESIVE if model.adhesive else _GOOD
        good = best.error <= enough * np.abs(best.first) + 2.0 * _OF_OUTPUTS * allowed * scale
        # NaN and infinity count as rough.
        rough = [k for k in rough if not good[:, k].all()]
        if not rough:
            break
    at = {each.name: shaped(np.broadcast_to(each.value.reshape(-1), (math.prod(shape),)), shape)
          for each in model.inputs}  # fmt: skip
    doubtful = [_DOUBTFUL_SOLVES if model.adhesive or name in OBLIQUE else _DOUBTFUL for name in outputs]
    doubts = _doubts(outputs, tuple(at), best, scale, doubtful)
    return Derivatives(
        outputs, tuple(at), values, at, best.first, best.error, best.second, tolerance, model.axes, doubts
    )


def _points(model: Model, inputs: Sequence[int], share: float) -> dict[str, Array]:
    """Return values of all inputs: those of the impact itself, then those beside it of each of the `inputs`."""
    n = NINE[0].rows(len(inputs)).start
    values: dict[str, Array] = {}
    for each in model.inputs:
        flat = each.value.reshape(-1) if model.shape and each.value.ndim else each.value
        values[each.name] = np.repeat(np.asarray(flat)[None], n, axis=0)
    for place, k in enumerate(inputs):
        column = values[model.inputs[k].name]
        points = model.inputs[k].points(share)
        column[NINE[0].rows(place)] = points.reshape(len(points), *column.shape[1:])
    return values


def _slopes(each: Input, share: float, line: tuple[Array, Array], same: Array, rtol: float) -> Slopes:
    """Return derivatives in SI by one input from values at its points; infinite errors where impacts end otherwise."""
    shape = line[0].shape
    sides, pace = (np.broadcast_to(part.reshape(shape if part.ndim else ()), shape)
                   for part in (each.sides(share), each.pace(share)))  # fmt: skip
    slope = slopes(*line, sides)
    # Errors that all solves share change the slope of the logarithm by themselves.
    error = slope.error + _OF_OUTPUTS * rtol * share * LONG_STEP * np.abs(line[0])
    good = same & np.isfinite(slope.first) & np.isfinite(error)
    return Slopes(slope.first / pace, np.where(good, error / np.abs(pace), np.inf), slope.second / pace**2)


def _scales(model: Model, values: Mapping[str, Numeric], outputs: Sequence[str]) -> Array:
    """Return the derivatives with which outputs would change as much as the inputs, relative to their values."""
    y = np.stack([np.abs(np.asarray(values[name])) for name in outputs])[:, None]
    paces = [np.broadcast_to(np.abs(each.pace()).reshape(model.shape if each.value.ndim else ()), model.shape)
             for each in model.inputs]  # fmt: skip
    return y * LONG_STEP / np.stack(paces)[None]


def _refuse_failed(statuses: Array) -> None:
    """Raise if an impact itself failed."""
    kinds = np.atleast_1d(statuses).reshape(-1).astype(int)
    failed = np.flatnonzero(kinds >= Status.TOO_MANY_STEPS)
    if failed.size:
        where = f"impact {failed[0]} of {kinds.size}" if kinds.size > 1 else ""
        raise SolverError(Status(int(kinds[failed[0]])), where)


def _doubts(
    outputs: Sequence[str], names: Sequence[str], best: Slopes, scale: Array, doubtful: Sequence[float]
) -> tuple[str, ...]:
    """Return warnings of derivatives that do not exist or are not accurate."""
    lines: list[str] = []
    shares = np.array(doubtful).reshape(-1, *(1,) * (best.error.ndim - 1))
    excess = best.error - shares * (np.abs(best.first) + 1e-3 * scale)
    for n, output in enumerate(outputs):
        for k, name in enumerate(names):
            if np.isnan(best.first[n, k]).any():
                lines.append(f"derivative: {output} has none by {name}, as impacts beside it fail or end otherwise")
            elif np.any(excess[n, k] > 0.0):
                worst = int(np.argmax(excess[n, k]))
                size, error = (float(part[n, k].reshape(-1)[worst]) for part in (best.first, best.error))
                lines.append(f"derivative: that of {output} by {name}, {size:.3g}, has an error of some {error:.1g}")
    return tuple(lines)
