"""Layers and other bodies: stiffness and impacts against published and independent numbers.

Run as `python validation/layers.py`; writes the tables to `layers.md` beside this file, and the picture of the page to
`docs/_static/layers.png`. Takes some seconds.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
from PIL import Image

import restitution as rs
from restitution.contact.geometry import Contact
from restitution.material.conversion import bulk_from_poisson_ratio
from restitution.plot import style

Array = NDArray[np.float64]
PICTURE = Path(__file__).parents[1] / "docs" / "_static" / "layers.png"

# Two discretisations that share no code with the package, Nystrom's and a Galerkin one, agree in these digits.
COLUMNS = (0.5, 0.45, 0.3, 0.0, -0.5, None)
KAPPA = {
    0.1: (1.125987267, 1.114550623, 1.095440693, 1.083075318, 1.081590211, 1.079910078),
    0.5: (1.932934371, 1.806259937, 1.624025413, 1.525080197, 1.520286761, 1.506087868),
    1.0: (3.618735849, 3.091408067, 2.483524629, 2.226114776, 2.248926527, 2.198621366),
    5.0: (50.13973797, 19.1556764, 10.09979076, 8.441004026, 9.190706191, 8.421085036),
    10.0: (252.8981415, 42.51492738, 19.71566922, 16.28882919, 18.0210618, 16.26956147),
}
# d R/a^2 and 3 Pi R/(2 a^3) of a parabola on three layers.
PARABOLA = {
    0.2: (0.8563144173, 1.006178869, 0.8875776972, 1.004057516, 0.9037637672, 1.002583658),
    1.0: (0.5594154856, 1.410500174, 0.6476223199, 1.258968453, 0.673980645, 1.18359206),
    2.0: (0.4549028216, 2.598120924, 0.5730033556, 1.878954203, 0.5902305426, 1.67240213),
    10.0: (0.3122602044, 41.11013613, 0.5129365901, 7.577548265, 0.5178514885, 6.319813344),
}
# Coefficients of F/F_Hertz in sqrt(R d)/h, as two open programs for force microscopy have them.
DIMITRIADIS = (1.0, 1.133, 1.283, 0.769, 0.0975)
DIMITRIADIS_FREE = (1.0, 0.884, 0.781, 0.386, 0.0048)
GARCIA = (1.0, 1.133, 1.497, 1.469, 0.755)
# kappa of Hayes and others, as three programs for cartilage have it; a/h and kappa by Poisson ratio.
HAYES = {
    0.3: ((0.2, 0.4, 0.6, 0.8, 1.0, 1.2, 1.4, 1.6, 1.8, 2.0),
          (1.207, 1.472, 1.784, 2.124, 2.480, 2.845, 3.214, 3.586, 3.960, 4.336)),
    0.45: ((0.2, 0.4, 0.6, 0.8, 1.0, 1.5, 2.0, 2.5, 3.0, 3.5, 4.0, 5.0, 6.0, 7.0, 8.0),
           (1.252, 1.599, 2.031, 2.532, 3.085, 4.638, 6.38, 8.265, 10.26, 12.32, 14.45, 18.8, 23.23, 27.69, 32.15)),
    0.5: ((0.2, 0.4, 0.6, 0.8, 1.0, 1.2, 1.4, 1.6, 1.8, 2.0),
          (1.281, 1.683, 2.211, 2.855, 3.609, 4.469, 5.441, 6.528, 7.735, 9.069)),
}  # fmt: skip
# name, Poisson ratio, base, thickness, terms g and tau, then e, contact time, largest depth and force of the reduced
# equations by SciPy, and the differences of e and of the force by finite elements.
LAYERS = (
    ("A", 0.3, "bonded", 0.9, (10.0,), (0.1,),
     (0.22750397264, 0.7599293506, 0.2592011702, 3.5985416053), "7e-8, 1.5e-5"),
    ("C", 0.5, "bonded", 0.5, (10.0,), (0.1,),
     (0.32909417918, 0.3936216017, 0.1627347681, 7.1091143807), ""),
    ("D", 0.4999, "bonded", 0.45, (4.0, 6.0), (0.4, 0.05),
     (0.48114742782, 0.4184126490, 0.1559095230, 7.8270967378), "-1.3e-6, 7e-5"),
)  # fmt: skip
FRICTIONLESS = ("G", (0.37055953408, 0.7557382849, 0.2744582671, 3.6689888432), "1.4e-6, -8e-6")
ELLIPSES = {
    2.0: (0.630595701428, 1.02008645732, 1.25517347877, 0.791507000262),
    5.0: (0.345999086637, 1.10998599938, 1.67259479367, 0.578716270926),
    100.0: (0.0549840180571, 2.05938814149, 3.91882110611, 0.215472530461),
}
# Zener's elastic plate: e, contact time and largest depth in his units, by Taylor series with 40 digits.
ZENER = {
    0.01: (0.98287612985597, 3.2236804780998, 1.0858585910041),
    0.1: (0.84333941092488, 3.2784949882176, 1.0235590926326),
    0.5: (0.43689530094234, 3.6244414510222, 0.82565162203285),
    1.0: (0.18412287416505, 4.3876120180101, 0.67629101615599),
}
PLATES = {
    10.0: (0.235828058286, 1.7626429743, 1.6573514156),
    3.0: (0.138127992284, 2.4881299297, 1.1538294787),
}

TEXT = """\
`validation/layers.py` makes this section. Reference values of layers come from two discretisations, Nystrom's and a
Galerkin one with spherical Bessel functions. They share no code with the package and agree to $10^{{-11}}$. Impacts
are in units of $m = v_0 = R = 1$.

### Stiffness of a layer

Relative difference of $\\kappa$, the stiffness of a flat punch over that on the half-space, from the reference,
whose values have ten digits.

{kappa}

Relative differences of $dR/a^2$ and $3\\Pi R/(2a^3)$ of a parabola.

{parabola}

### Published corrections

Coefficients of $F/F_{{\\mathrm{{Hertz}}}}$ as open programs for force microscopy have them, and $\\kappa$ of Hayes
and others as programs for cartilage have it, against the exact curves. One more of these programs has
$\\kappa = 3.359$ at $a/h = 1$ for $\\nu = \\tfrac12$, which is 7.2 % low.

```{{figure}} {picture}
:alt: Errors of published corrections for bonded layers over the ratio of contact size and thickness

Errors of the force of a ball (left) and of the stiffness of a punch (right) on bonded layers. The polynomials
are for $\\nu = \\tfrac12$.
```

{published}

### Impacts on a layer

Relative differences of $e$, $T$, $d_{{\\max}}$ and $F_{{\\max}}$ from the reduced equations, solved with SciPy to
$10^{{-12}}$. The last column has the relative differences of $e$ and $F_{{\\max}}$ between finite elements, which
use no theory of layers, and the reduced equations. In case G the bulk modulus is elastic and the base is
frictionless; in the others the Poisson ratio is constant.

{impacts}

### Ellipses and pyramids

Relative differences from Hertz's solution with 40 digits: the ratio $b/a$, the radius $R_{{\\mathrm{{eff}}}}/R_g$,
and the semi-axes in units of $\\sqrt{{R_gd}}$.

{ellipses}

Impacts with $E^* = 4 + 40\\,e^{{-10t}}$ against boundary elements in three dimensions and in time. The difference
for the pyramid falls with the size of the cells.

{bodies}

### Plates

Elastic: relative differences from Taylor series with 40 digits in Zener's units. With memory,
$E^* = 3 + 20\\,e^{{-10t}}$: differences from the reduced equations by two SciPy methods.

{plates}
"""


def table(head: Sequence[str], rows: Iterable[Sequence[Any]]) -> str:
    """A table in Markdown."""
    cells = [head, ["---"] * len(head), *rows]
    return "\n".join("| " + " | ".join(map(str, row)) + " |" for row in cells)


def short(*values: float | None) -> list[str]:
    """Small numbers with two digits."""
    return ["" if value is None else f"{value:.1e}" for value in values]


def steady(poisson_ratio: float | None, g: Sequence[float] = (), tau: Sequence[float] = ()) -> rs.Material:
    """A material of constant Poisson ratio, with a shear modulus of 1 + sum g exp(-t/tau)."""
    shear = rs.PronySeries(1.0, list(g), list(tau))
    nu = 0.3 if poisson_ratio is None else poisson_ratio
    if nu == 0.5:
        return rs.Material(shear, math.inf)
    return rs.Material(shear, shear.scaled(2.0 * (1.0 + nu) / (3.0 * (1.0 - 2.0 * nu))))


def layer(poisson_ratio: float | None, thickness: float, profile: Any) -> Any:
    """The geometry of a body on a layer; the base is frictionless for None."""
    base = "frictionless" if poisson_ratio is None else "bonded"
    return Contact(steady(poisson_ratio), rs.Layer(profile, thickness=thickness, base=base)).profile


def kappa(poisson_ratio: float | None, chi: float) -> float:
    """Stiffness of a punch on a layer over that on the half-space."""
    return float(layer(poisson_ratio, 1.0 / chi, rs.FlatPunch(1.0)).stiffness_radius(0.0))


def depth_at(geometry: Any, radius: float) -> float:
    """Depth at which the contact radius is given."""
    from scipy.optimize import brentq

    return brentq(lambda d: float(geometry.contact_radius(d)) - radius, 0.1 * radius**2, radius**2, xtol=1e-15)


def stiffness() -> dict[str, str]:
    """Tables of the static solution."""
    heads = [f"bonded, {nu:g}" if nu is not None else "frictionless" for nu in COLUMNS]
    rows = [
        [f"{chi:g}", *short(*(kappa(nu, chi) / expected - 1.0 for nu, expected in zip(COLUMNS, values, strict=True)))]
        for chi, values in KAPPA.items()
    ]
    results = []
    for chi, values in PARABOLA.items():
        cells: list[float] = []
        for n, nu in enumerate((0.5, 0.3, None)):
            body = layer(nu, 1.0 / chi, rs.Parabola(1.0))
            d = depth_at(body, 1.0)
            cells += [
                d / values[2 * n] - 1.0,
                1.5 * float(body.force_integral_at_depth(d)) / values[2 * n + 1] - 1.0,
            ]
        results.append([f"{chi:g}", *short(*cells)])
    three = [
        f"{name}: {what}" for name in ("bonded, 0.5", "bonded, 0.3", "frictionless") for what in ("$d$", "$\\Pi$")
    ]
    return {"kappa": table(["$a/h$", *heads], rows), "parabola": table(["$a/h$", *three], results)}


def polynomial(coefficients: Sequence[float], chi: Array) -> Array:
    """Value of a correction."""
    return np.polynomial.polynomial.polyval(chi, np.array(coefficients))


def force_ratio(poisson_ratio: float | None, chi: Array) -> Array:
    """Force of a parabola of radius 1 on a layer of thickness 1 over that on the half-space, at sqrt(R d)/h."""
    layered, ball = layer(poisson_ratio, 1.0, rs.Parabola(1.0)), rs.Parabola(1.0)
    return layered.force_integral_at_depth(chi**2) / ball.force_integral_at_depth(chi**2)


def published() -> str:
    """Table and picture of the errors of published corrections."""
    chi = np.array([0.1, 0.2, 0.3, 0.5, 1.0, 2.0])
    bonded, free = force_ratio(0.5, chi), force_ratio(None, chi)
    rows = [
        ["exact, bonded, $\\nu = \\tfrac12$", *(f"{x:.6f}" for x in bonded)],
        ["Dimitriadis and others 2002, bonded", *(f"{x:+.1%}" for x in polynomial(DIMITRIADIS, chi) / bonded - 1.0)],
        ["Garcia and Garcia 2018", *(f"{x:+.1%}" for x in polynomial(GARCIA, chi) / bonded - 1.0)],
        ["exact, frictionless", *(f"{x:.6f}" for x in free)],
        [
            "Dimitriadis and others, not bonded, against frictionless",
            *(f"{x:+.1%}" for x in polynomial(DIMITRIADIS_FREE, chi) / free - 1.0),
        ],
    ]
    fine = np.geomspace(0.02, 2.0, 120)
    exact = force_ratio(0.5, fine)
    with style.context():
        figure = style.new_figure(style.PAGE_WIDTH, 2.9)
        left, right = figure.subplots(1, 2)
        for name, values, colour, line in (
            ("Dimitriadis 2002", DIMITRIADIS, style.VERMILION, "-."),
            ("Garcia 2018", GARCIA, style.BLUE, "-"),
            ("Hertz, no correction", [1.0], style.GREY, "--"),
        ):
            left.plot(fine, 100.0 * (polynomial(values, fine) / exact - 1.0), line, color=colour, label=name)
        left.set_ylim(-40.0, 20.0)
        style.labelled(left, r"$\sqrt{Rd}/h$", "error of the force [%]")
        looks = ((style.BLUE, "o-"), (style.GREEN, "s-"), (style.VERMILION, "^-"))
        for (nu, (ratio, values)), (colour, look) in zip(HAYES.items(), looks, strict=True):
            errors = [100.0 * (value / kappa(nu, x) - 1.0) for x, value in zip(ratio, values, strict=True)]
            right.plot(ratio, errors, look, color=colour, markersize=3, label=rf"$\nu = {nu:g}$")
        style.labelled(right, "$a/h$", r"error of Hayes' $\kappa$ [%]")
        for ax in (left, right):
            ax.axhline(0.0, color=style.BLACK, linewidth=0.6)
            ax.legend(frameon=False)
        saved = style.save_figure(style.finish(figure), PICTURE)
    with Image.open(saved) as picture:
        small = picture.convert("RGB").resize((picture.width // 2, picture.height // 2), Image.Resampling.LANCZOS)
    small.quantize(200).save(PICTURE, optimize=True)
    return table(["$\\sqrt{Rd}/h$", *(f"{x:g}" for x in chi)], rows)


def differences(result: rs.ImpactResult, expected: Sequence[float | None]) -> list[str]:
    """Relative differences of e, contact time, largest depth and force."""
    results = (
        result.restitution_coefficient, result.contact_time, result.max_indentation_depth, result.max_force,
    )  # fmt: skip
    return short(*(None if y is None else x / y - 1.0 for x, y in zip(results, expected, strict=True)))


def impacts() -> str:
    """Impacts on layers."""
    rows: list[list[str]] = []
    for name, nu, base, thickness, g, tau, expected, elements in LAYERS:
        geometry = rs.Layer(rs.Parabola(1.0), thickness=thickness, base=base)
        result = rs.solve(rs.Impact(steady(nu, g, tau), geometry, mass=1.0, velocity=1.0), rtol=1e-11)
        ratio = f"{result.max_contact_radius / thickness:.3f}"
        e = f"{result.restitution_coefficient:.9f}"
        rows.append([name, f"{nu:g}, {base}", f"{thickness:g}", ratio, e, *differences(result, expected), elements])
    name, expected, elements = FRICTIONLESS
    solid = rs.Material(rs.PronySeries(1.0, [10.0], [0.1]), bulk_from_poisson_ratio(1.0, 0.45))
    geometry = rs.Layer(rs.Parabola(1.0), thickness=0.9, base="frictionless")
    result = rs.solve(rs.Impact(solid, geometry, mass=1.0, velocity=1.0), rtol=1e-11)
    ratio, e = f"{result.max_contact_radius / 0.9:.3f}", f"{result.restitution_coefficient:.9f}"
    rows.append([name, "0.45 static, frictionless", "0.9", ratio, e, *differences(result, expected), elements])
    head = ["case", "$\\nu$, base", "$h$", "$a_{\\max}/h$", "$e$", "$e$", "$T$", "$d_{\\max}$", "$F_{\\max}$",
            "finite elements"]  # fmt: skip
    return table(head, rows)


def series(equilibrium: float, branch: float) -> rs.Material:
    """An incompressible material with E* = equilibrium + branch exp(-10 t)."""
    return rs.Material(rs.PronySeries(equilibrium / 4.0, [branch / 4.0], [0.1]), math.inf)


def ellipses() -> dict[str, str]:
    """Hertz's ellipse, and impacts of an ellipse and a pyramid."""
    rows = []
    for ratio, (axis_ratio, effective, longer, shorter) in ELLIPSES.items():
        body = rs.Ellipsoid(math.sqrt(ratio), 1.0 / math.sqrt(ratio))
        a, b = (float(x) for x in body.semi_axes(body.contact_radius(1.0)))
        radius = float(body.stiffness_radius(1.0)) ** 2
        pairs = ((b / a, axis_ratio), (radius, effective), (a, longer), (b, shorter))
        rows.append([f"{ratio:g}", *short(*(x / y - 1.0 for x, y in pairs))])
    solid = series(4.0, 40.0)
    bodies = []
    for name, body, expected, elements in (
        ("ellipse, $R_1/R_2 = 5$", rs.Ellipsoid(math.sqrt(5.0), 1.0 / math.sqrt(5.0)), 0.2172055364, "5.5e-6"),
        ("pyramid, 4 sides, $\\tan\\alpha = 1$", rs.Pyramid(face_angle=math.pi / 4, sides=4), 0.2555678197, "5.4e-5"),
    ):
        e = rs.solve(rs.Impact(solid, body, mass=1.0, velocity=1.0), rtol=1e-11).restitution_coefficient
        bodies.append([name, f"{e:.9f}", *short(e / expected - 1.0), elements])
    head = ["$R_1/R_2$", "$b/a$", "$R_{\\mathrm{eff}}$", "$a$", "$b$"]
    return {
        "ellipses": table(head, rows),
        "bodies": table(["body", "$e$", "difference", "boundary elements"], bodies),
    }


def plates() -> str:
    """Impacts on plates."""
    rows = []
    hard, ball = rs.Material(0.25 * 0.75, math.inf), rs.Parabola(1.0)
    for group, (e, time, depth) in ZENER.items():
        # k = (4/3) E* sqrt(R) = 1 in these units, so that lambda = 1/Z.
        result = rs.solve(rs.Impact(hard, ball, mass=1.0, velocity=1.0, impedance=1.0 / group), rtol=1e-11)
        rows.append([f"elastic, $\\lambda = {group:g}$", f"{result.restitution_coefficient:.9f}",
                     *differences(result, (e, time, depth, None))])  # fmt: skip
    for impedance, (e, time, force) in PLATES.items():
        result = rs.solve(rs.Impact(series(3.0, 20.0), ball, mass=1.0, velocity=1.0, impedance=impedance), rtol=1e-11)
        name = f"memory, $Z = {impedance:g}$"
        rows.append([name, f"{result.restitution_coefficient:.9f}", *differences(result, (e, time, None, force))])
    return table(["target", "$e$", "$e$", "$T$", "$d_{\\max}$", "$F_{\\max}$"], rows)


def main() -> None:
    """Write the tables and the picture."""
    text = TEXT.format(
        picture="_static/layers.png", published=published(), impacts=impacts(), plates=plates(),
        **stiffness(), **ellipses(),
    )  # fmt: skip
    Path(__file__).with_suffix(".md").write_text(text, encoding="utf-8")
    print(text)


if __name__ == "__main__":
    main()
