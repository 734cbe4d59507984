"""What all results share: how they ended, plain numbers, a table for people in text and HTML, and a picture."""

from __future__ import annotations

import html
import math
import re
from abc import abstractmethod
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from enum import Enum, IntEnum
from importlib import import_module
from typing import TYPE_CHECKING, Any, ClassVar, NamedTuple, Self

from restitution.units import scaled_unit

if TYPE_CHECKING:
    from matplotlib.figure import Figure

_WIDTH = 100
# Above this number of rows, a table is laid out by its widest cells.
_MANY = 500


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
            text = ""
            for cell, place, right in zip(row, places, rights, strict=True):
                text = text.ljust(place + 1 - len(cell) if right else place) + cell
            return text.ljust(len(last))

        return "\n".join([*lines[:head], *map(line, self.rows), end, ""])

    def _layout(self, rows: Sequence[tuple[str, ...]], width: int) -> str:
        """Return the lines of some rows in columns of a width."""
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
        console.print(layout, highlight=False, crop=False)
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


class Outcome(IntEnum):
    """How a computation ended: a code with its message, and with a remedy for a failure."""

    message: str

    def __new__(cls, code: int, message: str) -> Self:
        """Make a member, whose value is the code."""
        member = int.__new__(cls, code)
        member._value_, member.message = code, message
        return member

    @classmethod
    def attributes(cls) -> dict[str, Any]:
        """Return the attributes of an array of codes, by which CF readers know them."""
        names = " ".join(member.name.lower() for member in cls)
        return {"flag_values": [int(member) for member in cls], "flag_meanings": names}


def plain(value: Any, leaf: Callable[[Any], Any] = lambda leaf: leaf) -> Any:
    """Return a value of a result as JSON has it: arrays are lists, named tuples, reports and results are dicts.

    Parameters
    ----------
    value : object
        Number, text, array, named tuple, or a list, tuple or dict of such.
    leaf : callable, optional
        Function that converts single numbers and texts, such as `nullable`.

    Examples
    --------
    >>> plain({"force": (1.0, math.inf)}, nullable)
    {'force': [1.0, None]}
    """
    if isinstance(value, Mapping):
        return {key: plain(item, leaf) for key, item in value.items()}
    for method in ("to_dict", "_asdict", "tolist"):
        if hasattr(value, method):
            return plain(getattr(value, method)(), leaf)
    if isinstance(value, list | tuple):
        return [plain(item, leaf) for item in value]
    return leaf(value)


def nullable(value: Any) -> Any:
    """Return the name of an outcome, None for a number that is infinite or NaN, and anything else as it is."""
    if isinstance(value, Enum):
        return value.name
    return None if isinstance(value, float) and not math.isfinite(value) else value


def of_higher_layer(place: str, *arguments: Any, **options: Any) -> Any:
    """Return what a function of a higher layer makes of a result; it is named as "package.module.function".

    It is loaded by name when a user asks for it, as results know no layer above them.
    """
    module, _, function = place.rpartition(".")
    return getattr(import_module(f"restitution.{module}"), function)(*arguments, **options)


def draw(place: str, *arguments: Any, **options: Any) -> Any:
    """Return the figure of a function of `restitution.plot`, named as "module.function"."""
    return of_higher_layer(f"plot.{place}", *arguments, **options)


class Result:
    """A result: it shows itself, with its warnings, by `print` and in notebooks; numbers and picture by name.

    A class names its numbers in `_numbers`, which `to_dict` returns, and its picture in `_picture`.
    """

    __slots__ = ()
    _numbers: ClassVar[tuple[str, ...]] = ()
    _picture: ClassVar[str] = ""

    @abstractmethod
    def summary(self, title: str = "") -> Summary:
        """Title, table and warnings, which `print` and notebooks show; the title is that of the result by default."""

    @property
    @abstractmethod
    def _short(self) -> str:
        """The most important numbers in a few words."""

    def to_dict(self) -> dict[str, Any]:
        """Return plain numbers, texts and lists by name, in SI unless a unit is stated, for JSON."""
        return plain({name: getattr(self, name) for name in self._numbers})

    def plot(self) -> Figure:
        """Return the figure of the result."""
        return draw(self._picture, self)

    def __str__(self) -> str:
        return str(self.summary())

    def __repr__(self) -> str:
        count = len(self.summary().warnings)
        doubts = f"; {count} warning{'s' * (count > 1)}" if count else ""
        return f"{type(self).__name__}({self._short}{doubts})"

    def _repr_html_(self) -> str:
        return self.summary().html
