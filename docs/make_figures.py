"""Make the pictures of README and documentation from the package: `.venv/bin/python docs/make_figures.py`."""

from pathlib import Path

from restitution.paper import curves
from restitution.paper.computation import Computation
from restitution.paper.reproduction import DEFAULT_SEED, FULL
from restitution.plot.style import save_figure

FOLDER = Path(__file__).parent / "_static"


def main() -> None:
    """Draw Figure 6 of the paper."""
    FOLDER.mkdir(exist_ok=True)
    dataset = curves.compute(Computation(DEFAULT_SEED), 6, FULL.curve)
    save_figure(curves.draw(dataset), FOLDER / "figure_6.png")


if __name__ == "__main__":
    main()
