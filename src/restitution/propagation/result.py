"""Result of an uncertainty: outputs with their standard deviations, and the shares of the inputs in them."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from restitution.axes import unnamed
from restitution.checks import Array, Numeric
from restitution.propagation.derivatives import Derivatives
from restitution.quantities import IMPACT_OUTPUTS, Quantity, choice
from restitution.result import Outcome, Result, Summary, Table, plain_symbol
from restitution.units import scaled_unit, with_error

if TYPE_CHECKING:
    import xarray

# Shares below this are not named in the table, and the most names of one line.
_SMALL, _MOST = 0.01, 3


class UncertaintyStatus(Outcome):
    """How far the linear standard deviations can be trusted; `message` explains it."""

    LINEAR = 0, "linear by derivatives; draws have not been asked for"
    CONFIRMED = 1, "draws agree with the linear deviations"
    DIFFERS = 2, "draws differ from the linear deviations; take the drawn ones"


class ErrorBar(NamedTuple):
    """A value with its standard deviation, in SI."""

    value: Any
    standard_deviation: Any


class Drawn(NamedTuple):
    """Outputs of random draws, by name; drawn bodies that stay have no contact time, and are left out of its numbers.

    Attributes
    ----------
    number, outside : int
        Number of draws, and how many more lay outside of the admissible ranges and were drawn again.
    mean, standard_deviation, low, high : dict of str to float or array
        Mean, standard deviation, and the ends of the interval that holds 95 % of the draws.
    covariance : array, shape (n_output, n_output, ...)
        Covariance of the outputs; NaN for those that some draws do not have.
    lost : dict of str to int
        Draws without a finite value.
    agrees : dict of str to bool or array
        Whether mean and standard deviation agree with the linear ones.
    """

    number: int
    outside: int
    mean: dict[str, Numeric]
    standard_deviation: dict[str, Numeric]
    low: dict[str, Numeric]
    high: dict[str, Numeric]
    covariance: Array
    lost: dict[str, int]
    agrees: dict[str, Any]


@dataclass(frozen=True, eq=False, repr=False)
class UncertaintyResult(Result):
    """Outputs of impacts with their standard deviations, in SI; see `restitution.uncertainty`.

    ``result["contact_time"]`` is the pair of a value and its linear standard deviation. `plot` shows the shares.

    Attributes
    ----------
    outputs, inputs : tuple of str
        Names.
    values, standard_deviations : dict of str to float or array
        Outputs, and their linear standard deviations, by name.
    covariance : array, shape (n_output, n_output, ...)
        Linear covariance of the outputs.
    shares : array, shape (n_output, n_input, ...)
        Share of each input in the variance of each output; their sum is 1. An input that is correlated with others
        has half of what it has in common with each; its share may be negative. NaN where the variance is 0.
    input_covariance : array, shape (n_input, n_input)
        Covariance of the inputs.
    derivatives : Derivatives
        Derivatives of the outputs by the inputs, with errors.
    drawn : Drawn or None
        Numbers of the draws, if any were asked for.
    status : UncertaintyStatus
        Whether draws agree with the linear deviations.
    warnings : tuple of str
        Doubts.
    """

    _numbers = (
        "outputs", "inputs", "values", "standard_deviations", "covariance", "shares", "input_covariance", "drawn",
        "status", "warnings",
    )  # fmt: skip
    _picture = "propagation.shares"

    outputs: tuple[str, ...]
    inputs: tuple[str, ...]
    values: dict[str, Numeric]
    standard_deviations: dict[str, Numeric]
    covariance: Array
    shares: Array
    input_covariance: Array
    derivatives: Derivatives
    drawn: Drawn | None
    status: UncertaintyStatus
    warnings: tuple[str, ...] = ()

    def __getitem__(self, output: str) -> ErrorBar:
        """Return the value and the linear standard deviation of an output."""
        name = choice("output", output, self.outputs)
        return ErrorBar(self.values[name], self.standard_deviations[name])

    def to_dataset(self) -> xarray.Dataset:
        """Return the outputs, with variables `..._deviation` and `..._share` over the inputs, and those of draws.

        Those of draws are `..._drawn_mean`, `..._drawn_deviation`, `..._drawn_low` and `..._drawn_high`.
        """
        import xarray as xr

        shape = self.covariance.shape[2:]
        axes = self.derivatives.axes or (unnamed(shape) if shape else None)

        def over(values: Any, quantity: Quantity, words: str) -> Any:
            attributes = quantity.attributes | {"long_name": f"{words} {quantity.words}".strip()}
            if axes is None:
                return xr.DataArray(np.asarray(values, dtype=np.float64), attrs=attributes)
            return axes.array(values, "", attributes)

        columns: dict[str, Any] = {}
        for name, rows in zip(self.outputs, self.shares, strict=True):
            quantity = IMPACT_OUTPUTS[name]
            columns[name] = over(self.values[name], quantity, "")
            columns[f"{name}_deviation"] = over(self.standard_deviations[name], quantity, "standard deviation of")
            parts = [over(row, quantity, "") for row in rows]
            attributes = {"units": "1", "long_name": f"share in the variance of {quantity.words}"}
            columns[f"{name}_share"] = xr.concat(parts, "input").assign_attrs(attributes)
            for part in () if self.drawn is None else ("mean", "standard_deviation", "low", "high"):
                short = part.removeprefix("standard_")
                words = f"{short} of drawn"
                columns[f"{name}_drawn_{short}"] = over(getattr(self.drawn, part)[name], quantity, words)
        return xr.Dataset(columns, coords={"input": list(self.inputs)}, attrs={"status": self.status.name})

    def summary(self, title: str = "") -> Summary:
        """Return the table of outputs with their deviations, which `print` and notebooks show; of arrays ranges."""
        if self.covariance.ndim > 2:
            return self._of_several(title)
        lines: list[tuple[str, ...]] = []
        for name in self.outputs:
            output, (value, deviation) = IMPACT_OUTPUTS[name], self[name]
            text, unit = with_error(float(value), float(deviation), output.unit)
            drawn = () if self.drawn is None else (self._interval(name),)
            lines.append((output.words, plain_symbol(output.symbol), text, unit, *drawn, self.contributions(name)))
        more = () if self.drawn is None else ("95 % of draws",)
        table = Table(("quantity", "symbol", "value", "unit", *more, "variance from"), lines, right="value")
        return Summary(title or "Outputs with standard deviations", table, self._lines, warnings=self.warnings)

    def _interval(self, name: str) -> str:
        assert self.drawn is not None
        low, high = float(self.drawn.low[name]), float(self.drawn.high[name])
        factor, unit = scaled_unit([low, high], IMPACT_OUTPUTS[name].unit)
        return f"{low * factor:.4g} to {high * factor:.4g} {unit}".rstrip()

    def _of_several(self, title: str) -> Summary:
        rows: list[tuple[str, ...]] = []
        for name in self.outputs:
            output, deviations = IMPACT_OUTPUTS[name], np.asarray(self.standard_deviations[name])
            values = np.asarray(self.values[name])
            factor, unit = scaled_unit(values, output.unit)
            ends = (f"{factor * end:.4g}" for end in (values.min(), values.max(), deviations.min(), deviations.max()))
            rows.append((output.words, plain_symbol(output.symbol), *ends, unit))
        head = ("quantity", "symbol", "lowest", "highest", "least deviation", "largest deviation", "unit")
        shape = self.covariance.shape[2:]
        return Summary(title or f"Impacts of shape {shape} with standard deviations", Table(head, rows), self._lines,
                       warnings=self.warnings)  # fmt: skip

    @property
    def lines(self) -> tuple[str, ...]:
        """The outputs of one impact in a line each: symbol, value, standard deviation, largest contributions."""
        texts: list[str] = []
        for name in self.outputs:
            output, (value, deviation) = IMPACT_OUTPUTS[name], self[name]
            text, unit = with_error(float(value), float(deviation), output.unit)
            number = f"{plain_symbol(output.symbol)} = {text} {unit}".rstrip()
            texts.append(f"{number} ({self.contributions(name)})")
        return (*texts, *self._lines)

    @property
    def _lines(self) -> tuple[str, ...]:
        drawn = "" if self.drawn is None else f" ({self.drawn.number} draws)"
        return (f"standard deviations: {self.status.message}{drawn}",)

    def contributions(self, output: str) -> str:
        """Return the inputs that contribute most to the variance of an output of one impact, in words."""
        row = self.shares[self.outputs.index(choice("output", output, self.outputs))]
        if not np.all(np.isfinite(row)):
            return "-"
        order = np.argsort(-np.abs(row), kind="stable")[:_MOST]
        return ", ".join(f"{self.inputs[k]} {100.0 * row[k]:.0f} %" for k in order if abs(row[k]) >= _SMALL)

    @property
    def _short(self) -> str:
        if self.covariance.ndim > 2:
            return f"{len(self.outputs)} outputs of impacts of shape {self.covariance.shape[2:]}"
        value, deviation = self[self.outputs[0]]
        text, unit = with_error(float(value), float(deviation), IMPACT_OUTPUTS[self.outputs[0]].unit)
        return f"{self.outputs[0]} = {text} {unit}".rstrip()
