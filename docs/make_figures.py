"""Make the pictures of README and documentation from the package: `.venv/bin/python docs/make_figures.py`."""

import re
import sys
from contextlib import chdir
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np
from matplotlib.patches import Circle, Rectangle
from PIL import Image

from restitution.paper.reproduction import reproduce
from restitution.plot import style

sys.path.insert(0, str(Path(__file__).parents[1] / "studies"))

import further_figures

FOLDER = Path(__file__).parent / "_static"
RECORD = Path(__file__).parents[1] / "src" / "restitution" / "paper" / "claims.json"
LINE = {"color": "black", "linewidth": 1.1, "solid_capstyle": "round"}
ARROW = {"arrowstyle": "-|>", "color": "black", "linewidth": 1.1, "shrinkA": 0.0, "shrinkB": 0.0}


def main() -> None:
    """Draw the figures of the paper, the two schemes and pictures of pages; write the claims."""
    FOLDER.mkdir(exist_ok=True)
    with TemporaryDirectory() as folder:
        figures = reproduce(folder)
        for path in [*figures.files, *further_figures.write(folder)]:
            if path.suffix == ".png":
                _shrunk(path)
        (FOLDER / "claims.md").write_bytes((figures.folder / "claims.md").read_bytes())
        # The explorer shows the same record.
        RECORD.write_bytes((figures.folder / "claims.json").read_bytes())
        curve = of_page("materials.md", "curve", folder)["figure"]
        program = of_page("indentation.md", "program", folder)["program"].plot()
        for name, figure in (("superposition.png", curve), ("any_history.png", program)):
            _shrunk(style.save_figure(figure, Path(folder, name)))
    with style.context():
        style.save_figure(scheme(), FOLDER / "figure_1.svg")
        style.save_figure(element(), FOLDER / "figure_2.svg")


def _shrunk(path):
    # Half of the resolution for print, and a palette: a tenth of the bytes.
    with Image.open(path) as picture:
        small = picture.convert("RGB").resize((picture.width // 2, picture.height // 2), Image.Resampling.LANCZOS)
        small.quantize(200).save(FOLDER / path.name, optimize=True)


def of_page(page, name, folder):
    """Names that the code of a page has made, up to the block with this name."""
    text = (FOLDER.parent / page).read_text(encoding="utf-8")
    names = {}
    with chdir(folder):
        for block in re.findall(r"^```python\n(.*?)^```$", text, re.DOTALL | re.MULTILINE):
            exec(compile(block, page, "exec"), names)
            if name in names:
                return names
    raise RuntimeError(f"{page} makes no {name}")


def _blank(width, height, across, up):
    figure = style.new_figure(width, height)
    ax = figure.add_subplot()
    ax.set_xlim(*across)
    ax.set_ylim(*up)
    ax.set_aspect("equal")
    ax.axis("off")
    return figure, ax


def _arrow(ax, start, end):
    ax.annotate("", end, start, arrowprops=ARROW)


def scheme():
    """Figure 1: a rigid sphere above a viscoelastic half-space."""
    figure, ax = _blank(4.4, 2.9, (-2.6, 2.6), (-1.15, 2.35))
    ax.add_patch(Rectangle((-2.6, -1.1), 5.2, 1.1, facecolor="#E8E8E8", edgecolor="none"))
    ax.plot([-2.6, 2.6], [0.0, 0.0], **LINE)
    ax.add_patch(Circle((0.0, 1.15), 0.95, facecolor="white", edgecolor="black", linewidth=1.1))
    ax.plot([0.0], [1.15], ".", color="black", markersize=4)
    _arrow(ax, (0.0, 1.15), (0.67, 1.82))
    ax.text(0.22, 1.58, "$R$", ha="center")
    ax.text(-0.35, 1.25, "$m$", ha="center")
    _arrow(ax, (1.35, 1.7), (1.35, 0.8))
    ax.text(1.47, 1.2, "$v_0$", va="center")
    _arrow(ax, (-1.7, 0.0), (-1.7, -0.62))
    ax.text(-1.58, -0.36, "$d$", va="center")
    ax.text(0.55, -0.6, r"$G(t) = G_\infty + G_1\,e^{-G_1 t/\eta}$,  $K(t) = K_0$", ha="center", va="center")
    return figure


def _spring(ax, x, low, high, label):
    ends = 0.2 * (high - low)
    zigzag = np.linspace(low + ends, high - ends, 13)
    offset = np.where(np.arange(13) % 2, 0.11, -0.11)
    offset[[0, -1]] = 0.0
    ax.plot([x, *(x + offset), x], [low, *zigzag, high], **LINE)
    ax.text(x + 0.2, 0.5 * (low + high), label, va="center", ha="left")


def _dashpot(ax, x, low, high, label):
    middle, half = 0.5 * (low + high), 0.17
    ax.plot([x, x], [high, middle + 0.02], **LINE)
    ax.plot([x - 0.11, x + 0.11], [middle + 0.02] * 2, **LINE)
    ax.plot(
        [x - 0.16, x - 0.16, x + 0.16, x + 0.16],
        [middle + half, middle - half, middle - half, middle + half],
        **LINE,
    )
    ax.plot([x, x], [middle - half, low], **LINE)
    ax.text(x + 0.24, middle, label, va="center", ha="left")


def _node(ax, left, right, y, label):
    ax.plot([left, right], [y, y], **LINE)
    ax.plot([left], [y], "o", color="black", markersize=3.5)
    ax.text(left - 0.12, y, label, ha="right", va="center")


def element():
    """Figure 2: the rheological element; all moduli and viscosities are multiplied by 4 dx."""
    figure, ax = _blank(4.2, 4.6, (-1.9, 3.0), (-0.45, 5.15))
    ax.add_patch(Rectangle((-1.0, -0.25), 2.9, 0.25, facecolor="#E8E8E8", edgecolor="none"))
    ax.plot([-1.0, 1.9], [0.0, 0.0], **LINE)
    _node(ax, -0.6, 1.2, 4.4, "$u$")
    _node(ax, -0.6, 1.2, 2.2, "$u_2$")
    _spring(ax, -0.3, 2.2, 4.4, r"$K_0 + \frac{1}{3}G_\infty$")
    _dashpot(ax, 1.2, 3.3, 4.4, r"$\frac{1}{3}\eta$")
    _spring(ax, 1.2, 2.2, 3.3, r"$\frac{1}{3}G_1$")
    ax.plot([1.2], [3.3], "o", color="black", markersize=3.5)
    ax.text(1.05, 3.3, "$u_1$", ha="right", va="center")
    _spring(ax, -0.3, 0.0, 2.2, r"$G_\infty$")
    _dashpot(ax, 1.2, 1.1, 2.2, r"$\eta$")
    _spring(ax, 1.2, 0.0, 1.1, "$G_1$")
    ax.plot([1.2], [1.1], "o", color="black", markersize=3.5)
    ax.text(1.05, 1.1, "$u_3$", ha="right", va="center")
    _arrow(ax, (0.3, 5.1), (0.3, 4.42))
    ax.text(0.42, 4.85, r"$F_i\,/\,(4\,\Delta x)$", va="center")
    return figure


if __name__ == "__main__":
    main()
