"""One look for every figure: fonts, sizes, colour-blind-safe colours, and how a figure is made and saved."""

from __future__ import annotations

from collections.abc import Generator, Iterable
from contextlib import contextmanager
from io import BytesIO
from pathlib import Path
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
    """Give every figure made inside this context the look of the package, whatever the user's own settings.

    Matplotlib's own settings return when the context ends.

    Examples
    --------
    >>> import matplotlib
    >>> before = matplotlib.rcParams["font.size"]
    >>> with context():
    ...     matplotlib.rcParams["font.size"]
    9.0
    >>> matplotlib.rcParams["font.size"] == before
    True
    """
    from matplotlib import style

    with style.context(["default", _SETTINGS]):
        yield


def use() -> None:
    """Give every figure from now on the look of the package, as `context` does for some.

    Examples
    --------
    >>> import matplotlib
    >>> with context():
    ...     use()
    ...     matplotlib.rcParams["figure.dpi"]
    100.0
    """
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


def paler(cmap: str, share: float = 0.35) -> Any:
    """Return a colormap mixed with a share of white, as a shading under black lines and text.

    It is opaque, as transparent areas show seams in PDF viewers.

    Examples
    --------
    >>> float(paler("gray", 0.5)(0.0)[0])
    0.5
    """
    from matplotlib import colormaps
    from matplotlib.colors import ListedColormap

    colors = colormaps[cmap](range(256))
    colors[:, :3] += share * (1.0 - colors[:, :3])
    return ListedColormap(colors.tolist()).with_extremes(bad="white")


def labelled(ax: Axes, x: str, y: str) -> Axes:
    """Return axes with their labels and a grid."""
    ax.set_xlabel(x)
    ax.set_ylabel(y)
    ax.grid(True)
    return ax


def panel_letters(panels: Iterable[Axes]) -> None:
    """Write (a), (b), ... above the upper left corners of several panels."""
    panels = list(panels)
    if len(panels) > 1:
        for ax, letter in zip(panels, "abcdefghijklmnopqrstuvwxyz", strict=False):
            ax.set_title(f"({letter})", loc="left", fontweight="bold")


def finish(figure: Figure, title: str = "") -> Figure:
    """Set the title, and make all texts while the fonts are those of the package."""
    if title:
        figure.suptitle(title, fontsize=11 if len(title) < 80 else 9)
    figure.draw_without_rendering()
    return figure


def save_figure(figure: Figure, path: Path | str) -> Path:
    """Save a figure whole or not at all, with embedded fonts; the suffix of `path` chooses the format.

    The bytes depend on the figure alone: no date is written.

    Parameters
    ----------
    figure : matplotlib.figure.Figure
        The figure.
    path : path-like
        Target file, e.g. `figure.pdf` or `figure.png`; replaced if it exists.

    Returns
    -------
    pathlib.Path
        The file written.

    Raises
    ------
    InputError
        If matplotlib cannot write that format.
    OSError
        If the file cannot be written; a file that was there before is then untouched.

    Examples
    --------
    >>> import tempfile
    >>> with tempfile.TemporaryDirectory() as folder, context():
    ...     save_figure(new_figure(2.0, 1.0), f"{folder}/empty.pdf").name
    'empty.pdf'
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
