"""Make the tables of flat punches that `restitution.Layer` ships.

Run as `python validation/flat_punches.py [FOLDER]`. It takes a second. The tables depend on a/h alone: those of the
frictionless layer, which has no Poisson ratio in E*, and of the bonded incompressible layer.
"""

from __future__ import annotations

import sys
from pathlib import Path

from restitution.contact.layer import punch
from restitution.contact.layer.punch import punches

DATA = Path(punch.__file__).parent / "data"


def main(arguments: list[str]) -> None:
    """Make the tables and write them."""
    folder = Path(arguments[0]) if arguments else DATA
    for poisson_ratio, name in punch.SHIPPED.items():
        punch.write(folder / name, punches(poisson_ratio))
        print(f"{folder / name}: {(folder / name).stat().st_size / 1e3:.0f} kB")


if __name__ == "__main__":
    main(sys.argv[1:])
