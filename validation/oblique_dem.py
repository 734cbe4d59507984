"""Tests 6 to 8 of Chung and Ooi for codes of discrete elements, which give e, beside solids with this e.

Run as `python validation/oblique_dem.py`; prints the table, writes it to `oblique_dem.md` beside this file, and draws
`docs/_static/oblique_dem.png`.
"""

from __future__ import annotations

import math
import sys
import warnings
from collections.abc import Callable
from pathlib import Path
from typing import Any

import matplotlib as mpl

mpl.use("Agg")
import matplotlib.pyplot as plt
import numpy as np
from scipy.optimize import brentq

import restitution as rs
from restitution.plot import style

sys.path.append(str(Path(__file__).resolve().parent))
import pages

ROOT = Path(__file__).parent.parent
# Of all three tests, and aluminium.
RADIUS, SPEED, FRICTION, RESTITUTION = 0.1, 0.2, 0.4, 0.5
YOUNG, POISSON, DENSITY = 70e9, 0.33, 2700.0
SHEAR, BULK = 0.5 * YOUNG / (1.0 + POISSON), YOUNG / 3.0 / (1.0 - 2.0 * POISSON)
# Ball of test 8 that the first one meets: radius and density over those of the first one.
LARGER, DENSER = 5.0, 1000.0
# Angles of incidence of the contact point, and 7/2 mu (1 + e) v0/v_c0, which is 1 + e_t where all slides.
ANGLES = np.radians(np.arange(85.0, 0.0, -5.0))
SLIDING = 3.5 * FRICTION * (1.0 + RESTITUTION) / np.tan(ANGLES)
# e_t as digitised in benchmark8_graph1.dat of Kratos, which has all three; they differ in the last three points.
COMMON = [
    -0.815, -0.626, -0.439, -0.238, -0.017, 0.096, 0.111, 0.090, 0.058, 0.006, -0.049, -0.103, -0.139, -0.162,
]  # fmt: skip
PUBLISHED = {
    "published, test 6": np.array([*COMMON, -0.204, -0.259, -0.339]),
    "published, test 8, case A": np.array([*COMMON, -0.204, -0.248, -0.318]),
    "published, test 8, case B": np.array([*COMMON, -0.106, -0.108, -0.106]),
}
# Static over branch modulus, and shares of the elastic contact time between which a relaxation time gives this e.
RATIO, SHORT, LONG = 0.1, (1e-3, 0.05), (0.06, 100.0)
DASHPOT = (1e-3, 1.0)
# Points that slide throughout.
SLIDES = 5

TEXT = """\
# Oblique impacts in tests of discrete elements

Made by `validation/oblique_dem.py`.

Tests 6 to 8 of Chung and Ooi, Granular Matter 13 (2011) 643, give $e = 0.5$ and $\\mu = 0.4$, but no material with
this $e$. Balls of {radius:g} m, of aluminium (E = 70 GPa, Poisson ratio 0.33, 2700 kg/m^3), spin and meet at {speed:g}
m/s: in test 6 a rigid plane, in test 7 an equal ball with an equal spin, in test 8 a ball of five times the
radius and a thousand times the density. Kratos has the velocities and the digitised points of the paper, PySPH the
constants of aluminium. Neither names the code or the formula that made the
points.

The package needs a solid that loses energy. Four solids with the static moduli of aluminium stand here, each with the
relaxation time or the viscosity for which $e = 0.5$: a Kelvin-Voigt solid with the same Poisson ratio at all rates,
and standard solids with branches of ten times the static modulus, elastic in bulk or with the same Poisson ratio at
all rates. A standard solid has the same $e$ with a time far below the contact time, and with one near it.

```{{figure}} _static/oblique_dem.png
:alt: e_t over 7/2 mu (1 + e) v0/v_c0, as published and of four solids with the same e

$e_t$ over $\\eta$, in which $\\eta - 1$ is full sliding.
```

{table}
Here $\\eta = \\frac{{7}}{{2}}\\mu(1+e)\\,v_0/v_{{c0}}$.

* **Where all slides**, in the first {slides} rows, $e_t = \\eta - 1$ in closed form, whatever the material. The
  published points are off by up to {read:.3f}.
* **Where the contact sticks** $e$ does not fix $e_t$: among the four solids it differs by up to {spread:.2f}. The
  published points of test 6 are within {near:.2f} of the standard solid with the long time, elastic in bulk, up to
  $\\eta = {near_end:.1f}$, and are lower than all four by up to {below:.2f} at the smallest angles. This does not test
  the package, as no solid is given: each law with a loss along the surface has its own $e_t$ there.
* **Test 7**: both contact points have the same velocity, so that there is no friction and the spin stays. The points
  in Kratos are just that.
* **Test 8** has the $e_t$ of test 6 in the theory, as only the ratios of the masses and of the moduli count, and these
  are the same. Solved as two bodies of the same solid, the standard solid with the long time has the $e_t$ of its test
  6 to rounding. In the published points the large ball changes $e_t$ by up to {cases:.2f}; cases A and B differ in its
  shear modulus in PySPH.
"""


def met(material: rs.Material, *, ball: bool = False) -> rs.Impact:
    """The ball on a rigid plane, or on the larger ball of the same solid."""
    if not ball:
        return rs.collision(rs.Body(material, RADIUS), rs.Body(None), velocity=SPEED)
    other = rs.Material(material.shear, material.bulk, density=DENSER * DENSITY)
    return rs.collision(rs.Body(material, RADIUS), rs.Body(other, LARGER * RADIUS), velocity=SPEED)


def solids(time: float) -> dict[str, tuple[Callable[[float], rs.Material], tuple[float, float]]]:
    """Solids over a share of a contact time, and the range of this share."""

    def voigt(share: float) -> rs.Material:
        viscosity, volume = SHEAR * time * share, BULK * time * share
        return rs.kelvin_voigt(SHEAR, viscosity, poisson_ratio=POISSON, bulk_viscosity=volume, density=DENSITY)

    def standard(share: float) -> rs.Material:
        return rs.Material(rs.PronySeries(SHEAR, [SHEAR / RATIO], [time * share]), BULK, density=DENSITY)

    def even(share: float) -> rs.Material:
        shear, bulk = (rs.PronySeries(each, [each / RATIO], [time * share]) for each in (SHEAR, BULK))
        return rs.Material(shear, bulk, density=DENSITY)

    return {
        "Kelvin-Voigt": (voigt, DASHPOT),
        "standard, short time": (standard, SHORT),
        "standard, long time": (standard, LONG),
        "standard, long time, one Poisson ratio": (even, LONG),
    }


def fitted(make: Callable[[float], rs.Material], span: tuple[float, float], *, ball: bool = False) -> rs.Impact:
    """The impact with this e."""

    def excess(share: float) -> float:
        return float(rs.solve(met(make(math.exp(share)), ball=ball)).restitution_coefficient) - RESTITUTION

    share: Any = brentq(excess, math.log(span[0]), math.log(span[1]), xtol=1e-12)
    return met(make(math.exp(share)), ball=ball)


def rough(impact: rs.Impact) -> np.ndarray:
    """Return e_t at all angles."""
    with warnings.catch_warnings():
        # A rigid partner couples both directions.
        warnings.simplefilter("ignore", rs.RestitutionWarning)
        result: Any = rs.solve(rs.vary(impact, {"friction": FRICTION, "tangential_velocity": SPEED * np.tan(ANGLES)}))
    return np.asarray(result.tangential_restitution_coefficient)


def draw(path: Path, lines: dict[str, np.ndarray]) -> None:
    """Draw the published points, and the solids as lines between the angles."""
    with style.context():
        figure, axes = plt.subplots(figsize=(5.6, 3.4), layout="constrained")
        for (name, values), marker in zip(PUBLISHED.items(), "o^s", strict=True):
            axes.semilogx(SLIDING, values, marker, color=style.GREY, markersize=4, label=name)
        for (name, values), kind in zip(lines.items(), ("-", "--", "-.", ":"), strict=True):
            axes.semilogx(SLIDING, values, kind, color=style.BLUE, label=name)
        axes.set(xlabel=r"$\eta$ [-]", ylabel="$e_t$ [-]")
        axes.legend(fontsize=6)
        figure.savefig(path, dpi=150)
        plt.close(figure)


def main() -> None:
    """Write `oblique_dem.md` and the picture."""
    aluminium = rs.elastic(youngs_modulus=YOUNG, poisson_ratio=POISSON, density=DENSITY)
    made = solids(float(rs.solve(met(aluminium)).contact_time))
    lines = {name: rough(fitted(*solid)) for name, solid in made.items()}
    nearest = "standard, long time"
    two = rough(fitted(*made[nearest], ball=True))
    columns = [*PUBLISHED.values(), *lines.values()]
    rows = [[f"{SLIDING[n]:.3f}", *(f"{column[n]:.3f}" for column in columns)] for n in range(SLIDING.size)]
    slides, every = slice(SLIDES), np.array(list(lines.values()))
    first, *others = PUBLISHED.values()
    off = np.abs(lines[nearest] - first)
    near_end = 12
    assert np.abs(every - (SLIDING - 1.0))[:, slides].max() < 1e-9
    assert np.abs(two - lines[nearest]).max() < 1e-9
    text = TEXT.format(
        table=pages.table([r"$\eta$", *PUBLISHED, *lines], rows), radius=RADIUS, speed=SPEED, slides=SLIDES,
        read=np.abs(first - (SLIDING - 1.0))[slides].max(),
        spread=np.ptp(every, axis=0).max(), near=off[:near_end].max(), near_end=SLIDING[near_end - 1],
        below=(every.min(axis=0) - first).max(), cases=np.ptp([first, *others], axis=0).max(),
    )  # fmt: skip
    print(text)
    Path(__file__).with_suffix(".md").write_text(text, encoding="utf-8")
    draw(ROOT / "docs" / "_static" / "oblique_dem.png", lines)


if __name__ == "__main__":
    main()
