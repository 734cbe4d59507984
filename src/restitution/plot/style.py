"""Style of all figures: fonts, sizes, colours for the colour-blind; creation and saving of figures."""

from __future__ import annotations

from collections.abc import Generator, Sequence
from contextlib import contextmanager
from io import BytesIO
from pathlib import Path
from string import ascii_lowercase
from typing import TYPE_CHECKING, Any

from matplotlib.figure import Figure

from restitution.errors import InputError

if TYPE_CHECKING:
    from matplotlib.axes import Axes

# Okabe and Ito (2008), https://jfly.uni-koeln.de/color: distinct under all common colour blindness.
BLACK = "#000000"
ORANGE = "#E69F00"
SKY_BLUE = "#56B4E9"
GREEN = "#009E73"
BLUE = "#0072B2"
VERMILION = "#D55E00"
PURPLE = "#CC79A7"
GREY = "#7F7F7F"

SEQUENTIAL = "YlGnBu_r"
DIVERGING = "PuOr"

COLUMN_WIDTH = 3.54
PAGE_WIDTH = 7.2
"""Widths of one and of two journal columns [inch]."""

_SETTINGS: dict[str, Any] = {
    # A concrete family, not "serif": the generic name is looked up when drawn, after the context has ended.
    "font.family": ["STIXGeneral"],
    "mathtext.fontset": "stix",
    "font.size": 9.0,
    "axes.labelsize": 10.0,
    "axes.titlesize": 10.0,
    "axes.linewidth": 0.7,
    "axes.axisbelow": True,
    "axes.formatter.use_mathtext": True,
    "axes.prop_cycle": f"cycler('color', {[BLUE, VERMILION, GREEN, ORANGE, SKY_BLUE, PURPLE, BLACK]!r})",
    "xtick.direction": "in",
    "ytick.direction": "in",
    "xtick.top": True,
    "ytick.right": True,
    "xtick.labelsize": 9.0,
    "ytick.labelsize": 9.0,
    "grid.color": "#DDDDDD",
    "grid.linewidth": 0.5,
    "lines.linewidth": 1.3,
    "legend.fontsize": 8.5,
    "legend.frameon": False,
    "figure.constrained_layout.use": True,
    "figure.dpi": 100,
    "savefig.dpi": 300,
    # Type 42 keeps glyphs as TrueType outlines, which publishers accept and programs can edit.
    "pdf.fonttype": 42,
    "ps.fonttype": 42,
    # Element names of an SVG are random without it.
    "svg.hashsalt": "restitution",
}


@contextmanager
def context() -> Generator[None]:
    """Give every figure made inside this context the style of the package; the user's settings return afterwards."""
    from matplotlib import style

    with style.context(["default", _SETTINGS]):
        yield


def use() -> None:
    """Give every further figure the style of the package, as `context` does temporarily."""
    from matplotlib import style

    style.use(_SETTINGS)


class Picture(Figure):
    """A figure that a notebook shows when it is the value of a cell, without pyplot or any setting.

    Pyplot does not hold it, so it needs no display and no closing, however many are made.
    """

    def _repr_png_(self) -> bytes:
        with context(), BytesIO() as file:
            self.savefig(file, format="png", dpi=self.dpi)
            return file.getvalue()


def new_figure(width: float = PAGE_WIDTH, height: float = 4.4, *, dpi: float = 100.0) -> Figure:
    """Return an empty figure that pyplot does not hold, and that notebooks show.

    The size is in inches, and the resolution that on a screen. Files have 300 dots per inch; a figure that has that
    resolution already is written fastest.

    Examples
    --------
    >>> with context():
    ...     new_figure(3.5, 2.5).get_size_inches().tolist()
    [3.5, 2.5]
    """
    from matplotlib.backends.backend_agg import FigureCanvasAgg

    figure = Picture(figsize=(width, height), dpi=dpi, layout="constrained")
    # Without a canvas of its own, each question for the size of a text costs a rendering of the whole figure.
    FigureCanvasAgg(figure)
    return figure


def panels(
    mosaic: Any,
    width: float = PAGE_WIDTH,
    height: float = 4.4,
    *,
    dpi: float = 100.0,
    figure: Figure | None = None,
    heights: Sequence[float] | None = None,
) -> tuple[Figure, list[Axes]]:
    """Return a new or a given empty figure and its panels, with letters above them if there are several.

    The mosaic is that of matplotlib's `subplot_mosaic`, e.g. "AA;BC": one letter or name for each panel, "." for none.

    Examples
    --------
    >>> page, axes = panels("AA;BC")
    >>> [ax.get_title("left") for ax in axes]
    ['(a)', '(b)', '(c)']
    """  # fmt: skip
    page = new_figure(width, height, dpi=dpi) if figure is None else figure
    axes = list(page.subplot_mosaic(mosaic, height_ratios=heights).values())
    for ax, letter in zip(axes if len(axes) > 1 else (), ascii_lowercase, strict=False):
        ax.set_title(f"({letter})", loc="left", fontweight="bold")
    return page, axes


def labelled(ax: Axes, x: str, y: str) -> Axes:
    """Return axes with their labels and a grid."""
    ax.set(xlabel=x, ylabel=y)
    ax.grid(True)
    return ax


def plain_ticks(ax: Axes) -> Axes:
    """Write plain numbers along logarithmic axes of at most two decades."""
    from matplotlib.ticker import LogLocator, NullFormatter

    for axis in (ax.xaxis, ax.yaxis):
        low, high = sorted(axis.get_view_interval())
        if axis.get_scale() == "log" and high <= 100.0 * low:
            axis.set_major_locator(
                LogLocator(subs=(1.0, 2.0, 5.0) if high > 10.0 * low else (1.0, 2.0, 3.0, 4.0, 6.0))
            )
            axis.set_major_formatter("{x:g}")
            axis.set_minor_formatter(NullFormatter())
    return ax


def finish(figure: Figure, title: str = "") -> Figure:
    """Set the title, and make all texts while the fonts are those of the package."""
    if title:
        figure.suptitle(title, fontsize=11 if len(title) < 80 else 9)
    figure.draw_without_rendering()
    return figure


def save_figure(figure: Figure, path: Path | str) -> Path:
    """Save a figure completely or not at all, with embedded fonts; the suffix of `path` chooses the format.

    The bytes depend only on the figure: no date is written. An existing file is replaced, unless the new one cannot
    be written (OSError). A format that matplotlib cannot write is an InputError.
    """
    from restitution.files import whole_file

    path = Path(path)
    suffix = path.suffix.lower().lstrip(".")
    known = figure.canvas.get_supported_filetypes()
    if suffix not in known:
        raise InputError("path", str(path), f"must end in one of .{', .'.join(sorted(known))}")
    options: dict[str, Any] = {"dpi": 300}
    if suffix == "png":
        options["pil_kwargs"] = {"compress_level": 4}
    elif suffix == "pdf":
        # Only smooth shadings are pixels in these formats: half the resolution looks the same, in half the bytes.
        options |= {"metadata": {"CreationDate": None}, "dpi": 150}
    elif suffix in ("svg", "svgz"):
        options |= {"metadata": {"Date": None}, "dpi": 150}
    with context(), whole_file(path) as partial:
        figure.savefig(partial, format=suffix, **options)
    return path
