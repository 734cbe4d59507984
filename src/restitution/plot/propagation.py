"""Pictures of error bars: elasticities of outputs, and the shares of inputs in the variance of each output."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from restitution.checks import Array
from restitution.errors import InputError
from restitution.plot import style
from restitution.quantities import OUTPUTS
from restitution.units import with_error

if TYPE_CHECKING:
    from restitution.propagation.derivatives import Derivatives
    from restitution.propagation.result import UncertaintyResult

# Height of a bar and of the page around the bars [inches].
_BAR, _FRAME = 0.16, 0.9


def elasticities(result: Derivatives) -> Figure:
    """Return a picture of the relative changes of the outputs of one impact over those of its inputs."""
    words = "change of the output over that of the input, both relative"
    labels = [OUTPUTS[name].symbol or name for name in result.outputs]
    return _bars(_single(result.elasticities), labels, result.inputs, words)


def shares(result: UncertaintyResult) -> Figure:
    """Return a picture of the shares of the inputs in the variance of each output of one impact."""
    labels: list[str] = []
    for name in result.outputs:
        output, (value, deviation) = OUTPUTS[name], result[name]
        text, unit = with_error(float(value), float(deviation), output.unit)
        number = text.replace("+-", "±")
        labels.append(f"{output.symbol} = {number} {unit}".rstrip())
    return _bars(100.0 * _single(result.shares), labels, result.inputs, "share of the variance [%]")


def _single(matrix: Array) -> Array:
    if matrix.ndim > 2:
        raise InputError("impact", matrix.shape[2:], "must be a single one for a picture; take one by its place")
    return matrix


def _bars(matrix: Array, rows: Sequence[str], names: Sequence[str], words: str) -> Figure:
    """Draw a group of bars for each row, with a colour for each name."""
    count = len(names)
    colors: list[Any] = list(style.family_colors(count)) if count > 1 else [style.BLUE]
    height = _FRAME + _BAR * (count + 1) * len(rows)
    with style.page("A", height=max(2.0, height)) as (figure, (ax,)):
        for k, (name, color) in enumerate(zip(names, colors, strict=True)):
            places = np.arange(len(rows)) + (k + 0.5) / (count + 1) - 0.5 * count / (count + 1)
            ax.barh(places, np.nan_to_num(matrix[:, k]), 0.9 / (count + 1), color=color, label=_plain(name))
        _finish(ax, rows, words)
    return figure


def _finish(ax: Axes, rows: Sequence[str], words: str) -> None:
    ax.axvline(0.0, color="black", linewidth=0.8)
    ax.set_yticks(np.arange(len(rows)), rows)
    ax.invert_yaxis()
    ax.grid(False, axis="y")
    ax.set_xlabel(words)
    ax.legend(fontsize=7.5, loc="center left", bbox_to_anchor=(1.0, 0.5))


def _plain(name: str) -> str:
    return name.replace("_", " ")
