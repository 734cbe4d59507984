"""Results as tables for people: prefixed units, and one text and one HTML form of every result."""

from __future__ import annotations

import html
import math
import re
from abc import abstractmethod
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple

_PREFIXES = {-18: "a", -15: "f", -12: "p", -9: "n", -6: "µ", -3: "m", 0: "", 3: "k", 6: "M", 9: "G", 12: "T"}
_WIDTH = 100
# Above this number of rows, a table is laid out by its widest cells.
_MANY = 500


class ScaledUnit(NamedTuple):
    """A unit with its prefix, and the factor that takes SI values to it."""

    factor: float
    unit: str


def scaled_unit(values: Any, unit: str) -> ScaledUnit:
    """Return the prefixed unit in which the largest finite one of `values` lies in [1, 1000).

    A unit with an exponent, K, rad and the empty unit of a plain number have no prefix; masses are in g up to 1 kg.

    Examples
    --------
    >>> scaled_unit([0.0, -0.0032], "m")
    ScaledUnit(factor=1000.0, unit='mm')
    >>> scaled_unit(2.5e4, "N").unit
    'kN'
    """
    if unit in ("", "K", "rad") or "^" in unit:
        return ScaledUnit(1.0, unit)
    # The help of the command line must load nothing heavy.
    import numpy as np

    array = np.abs(np.asarray(values, dtype=np.float64))
    array = array[np.isfinite(array)]
    largest = float(array.max()) if array.size else 0.0
    if unit == "kg":
        if largest >= 1.0:
            return ScaledUnit(1.0, "kg")
        factor, prefixed = scaled_unit(largest * 1e3, "g")
        return ScaledUnit(1e3 * factor, prefixed)
    # The small addend prevents a smaller unit for 0.999999999999, a rounded one.
    power = 3 * int(np.floor((np.log10(largest) + 1e-9) / 3)) if largest > 0 else 0
    power = min(max(power, min(_PREFIXES)), max(_PREFIXES))
    return ScaledUnit(10.0**-power, _PREFIXES[power] + unit)


def in_words(value: float, unit: str) -> str:
    """Return a number with four digits and its prefixed unit.

    Examples
    --------
    >>> in_words(0.00123456, "s")
    '1.235 ms'
    """
    factor, prefixed = scaled_unit(value, unit)
    return f"{value * factor:.4g} {prefixed}".rstrip()


def celsius(kelvin: float, digits: int = 6) -> str:
    """Return a temperature [K] as a number in °C, without the rounding of the difference.

    Examples
    --------
    >>> celsius(273.15), celsius(296.15), celsius(273.15 + 1e-13)
    ('0', '23', '0')
    """
    return f"{round(float(kelvin) - 273.15, 9) + 0.0:.{digits}g}"


def plain_symbol(symbol: str) -> str:
    r"""Return a symbol of matplotlib's notation as plain text: d_max for $d_\mathrm{max}$."""
    return re.sub(r"\\mathrm|[${}\\]", "", symbol)


class Table(NamedTuple):
    """Rows of text under their headings; the column `right` is aligned to the right."""

    columns: tuple[str, ...]
    rows: Sequence[tuple[str, ...]]
    right: str = ""

    def text(self, width: int = _WIDTH) -> str:
        """Return the table as lines of a width."""
        if len(self.rows) <= _MANY or not all(self.columns):
            return self._layout(self.rows, width)
        # Rich needs a second for a thousand rows. Those with the widest cells give the places of all others.
        widest = [max(self.rows, key=lambda row, n=n: len(row[n])) for n in range(len(self.columns))]
        marks = tuple("|" for _ in self.columns)
        *lines, last, end = self._layout([*widest, marks], width).split("\n")[:-1]
        places = [n for n, letter in enumerate(last) if letter == "|"]
        head = len(lines) - len(widest)
        if head < 1 or not lines[head - 1].strip(" ").startswith("─"):  # a cell is broken over lines
            return self._layout(self.rows, width)
        rights = [name == self.right for name in self.columns]

        def line(row: tuple[str, ...]) -> str:
            found = ""
            for cell, place, right in zip(row, places, rights, strict=True):
                found = found.ljust(place + 1 - len(cell) if right else place) + cell
            return found.ljust(len(last))

        return "\n".join([*lines[:head], *map(line, self.rows), end, ""])

    def _layout(self, rows: Sequence[tuple[str, ...]], width: int) -> str:
        """Lines of some rows in columns of a width."""
        from io import StringIO

        from rich import box
        from rich.console import Console
        from rich.table import Table as Layout
        from rich.text import Text

        layout = Layout(box=box.SIMPLE_HEAD)
        for n, head in enumerate(self.columns):
            words = " ".join((head, *(row[n] for row in self.rows))).split()
            least = min(16, max(map(len, words), default=1))
            align = "right" if head == self.right else "left"
            layout.add_column(Text(head), overflow="fold", justify=align, min_width=least)
        for row in rows:
            layout.add_row(*map(Text, row))
        # A line that is too long for the terminal is better broken by it than cut off by the table.
        # In a notebook, rich would display the table in place of writing it.
        written = StringIO()
        console = Console(file=written, width=max(width, _WIDTH), color_system=None, force_jupyter=False)
        console.print(layout, highlight=False)
        return written.getvalue()

    @property
    def html(self) -> str:
        """The table in HTML."""
        aligned = [f' style="text-align:{"right" if head == self.right else "left"}"' for head in self.columns]

        def line(cells: Iterable[str], tag: str) -> str:
            inner = (f"<{tag}{style}>{html.escape(cell)}</{tag}>" for cell, style in zip(cells, aligned, strict=True))
            return f"<tr>{''.join(inner)}</tr>"

        body = "".join(line(row, "td") for row in self.rows)
        return f"<table><thead>{line(self.columns, 'th')}</thead><tbody>{body}</tbody></table>"


def of_values(values: Iterable[tuple[str, str, float, str]], *, units: bool = True) -> Table:
    """Return the table of rows of words, symbol, value in SI, and unit."""
    n = 4 if units else 3
    rows = [(words, symbol, *_shown(value, unit if units else ""))[:n] for words, symbol, value, unit in values]
    return Table(("quantity", "symbol", "value", "unit")[:n], rows, right="value")


def _shown(value: float, unit: str) -> tuple[str, str]:
    if math.isnan(value) or (unit and math.isinf(value)):
        return ("-" if math.isnan(value) else "inf"), ""
    if unit == "":
        return f"{value:.8g}", ""
    scale = scaled_unit(value, unit)
    return f"{value * scale.factor:.6g}", scale.unit


@dataclass(frozen=True)
class Summary:
    """What a person wants to see of a result: a title, a table, lines below it, a text to paste, and warnings."""

    title: str
    table: Table | None = None
    lines: Sequence[str] = ()
    paste: str = ""
    warnings: Sequence[str] = ()

    def text(self, width: int = _WIDTH) -> str:
        """Return all but the warnings as lines."""
        table = [] if self.table is None else [self.table.text(width).removesuffix("\n")]
        parts = [self.title, *table, *self.lines]
        return "\n".join([*parts, *([f"\n{self.paste}"] if self.paste else [])])

    def __str__(self) -> str:
        """Return all, the warnings last."""
        return "\n".join([self.text(), *(f"warning: {line}" for line in self.warnings)])

    @property
    def html(self) -> str:
        """All in HTML, the warnings last, with colours of their own."""
        escaped = [html.escape(line) for line in self.lines]
        parts = [f"<p><b>{html.escape(self.title)}</b></p>"]
        parts += [] if self.table is None else [self.table.html]
        parts += [f"<p>{'<br>'.join(escaped)}</p>"] if escaped else []
        parts += [f"<pre>{html.escape(self.paste)}</pre>"] if self.paste else []
        style = "border-left:4px solid #d98200;padding:2px 8px;margin:4px 0"
        parts += [f'<div style="{style}"><b>warning:</b> {html.escape(line)}</div>' for line in self.warnings]
        return f"<div>{''.join(parts)}</div>"


class Shown:
    """A result that shows itself, with its warnings, by `print` and in notebooks."""

    __slots__ = ()

    @abstractmethod
    def summary(self, title: str = "") -> Summary:
        """Title, table and warnings; the title is that of the result by default."""

    @property
    @abstractmethod
    def _short(self) -> str:
        """The most important numbers in a few words."""

    def __str__(self) -> str:
        return str(self.summary())

    def __repr__(self) -> str:
        count = len(self.summary().warnings)
        doubts = f"; {count} warning{'s' * (count > 1)}" if count else ""
        return f"{type(self).__name__}({self._short}{doubts})"

    def _repr_html_(self) -> str:
        return self.summary().html
