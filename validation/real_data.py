"""Identification from real measurements: bouncing balls, rubber at several temperatures, a polymer, egg cells, AFM.

Run as `python validation/real_data.py [POLYMER.csv] [CURVES.zip] [FOLDER]`; prints tables and writes them to
`real_data.md` beside this file. The first file is the relaxation master curve of the verification data of pyvisco
(NREL, BSD-3-Clause). The second is `examples/data/10.1002_btm2.10294_fig5d-cell1.zip` of afmformats (MIT), which must
be installed. The folder is that of `real_curves.py`. None is part of this repository; a part without its file is left
out. Takes a minute.
"""

from __future__ import annotations

import math
import re
import sys
import tempfile
import warnings
import zipfile
from collections import Counter
from pathlib import Path
from typing import Any

import numpy as np
from real_curves import curves_of_instruments

import restitution as rs
from restitution.identification.observations import Moduli

# Radius [m] and mass [kg], None if they were not published; velocities [m/s] and restitution coefficients.
BALLS: dict[str, tuple[tuple[float, float] | None, list[float], list[float]]] = {
    "blue": (None, [1.0, 1.5, 2.0, 2.5, 3.0, 3.5], [0.896, 0.882, 0.884, 0.880, 0.880, 0.882]),
    "golf": ((21e-3, 41.5e-3), [2.0, 2.5, 3.0, 3.5, 4.0, 4.5], [0.888, 0.894, 0.897, 0.897, 0.893, 0.887]),
    "tennis": ((33.5e-3, 56e-3), [1.0, 1.5, 2.0, 2.5, 3.0, 3.5], [0.737, 0.773, 0.762, 0.760, 0.755, 0.740]),
    "table tennis": ((20e-3, 2.7e-3), [1.0, 1.5, 2.0, 2.5], [0.948, 0.946, 0.935, 0.926]),
}
# Two methods of the same work differ by up to 0.03.
SCATTER = 0.015
MODELS = ("kelvin_voigt", "springpot", "standard_solid")
# Temperature [degC], storage modulus in shear [MPa] and loss tangent at 1 Hz, the same at 100 Hz.
EPDM = (
    (-10.0, 7.25, 0.110, 11.25, 0.535),
    (4.0, 5.37, 0.106, 7.06, 0.177),
    (18.0, 4.35, 0.121, 5.87, 0.134),
    (25.0, 4.26, 0.118, 5.74, 0.131),
    (39.0, 3.78, 0.122, 5.17, 0.143),
    (53.0, 3.34, 0.126, 4.72, 0.141),
)
ROOM = 298.15

BALL_TEXT = """\
## Bouncing balls

Medians of five throws of a student laboratory (`giiulia/LabI-Dynamics-Thermodynamics` on GitHub), reduced from bounce
times: v = g T/2 and e from successive times of flight T, without a correction for drag. The two methods of that work
differ by up to 0.03; the fits take a standard deviation of {scatter}.

{data}

Only e was measured, so no modulus and no time is known: every fit states this. A constant with a value is at most the
exponent of the power law, which has no unit. Almost any model fits. The last columns have e at 10 m/s with its 95 %
interval: the models disagree outside the data. Radius and mass of the blue ball are unknown. They do not matter for e:
with 10 mm and 5 g, or 40 mm and 300 g, chi2 and e at 10 m/s agree to {invariance:.0e}.

{fits}

The tennis ball and the table tennis ball are hollow. The report warns of it: "{warning}".
The rule for tennis balls, a rebound of 1.35 to 1.47 m from 2.54 m, is e = 0.729 to 0.761 at 7.06 m/s. The power law
predicts {itf}, the Kelvin-Voigt solid {itf_kv}.
Neither is evidence for a half-space.
"""

RUBBER_TEXT = """\
## Rubber at six temperatures

EPDM in shear at 1 and 100 Hz (`MarcusNi96/dma-prony-validation` on GitHub; the temperatures of the sample were
inferred there). Shifts log10 aT to 25 degC by superposition, each with its standard error:

{shifts}

The WLF law has C1 = {c1:.1f} +- {c1_error:.1f} and C2 = {c2:.0f} +- {c2_error:.0f} K. The universal constants of
Williams, Landel and Ferry (1955), 17.44 and 51.6 K at the glass transition, are {u1:.1f} and {u2:.0f} K at 25 degC for
a glass transition at -50 degC, as is typical of EPDM. Two points an isotherm overlap little: the errors of the free
shifts are large at the coldest two temperatures, and the misfit of a curve through so few points proves nothing.

Restitution of a solid ball of this rubber on a rigid floor, R = 10 mm, 1100 kg/m^3, 1 m/s: from the terms that
`fit_prony` fits to the master curve (WLF), and from fits of two models with WLF to all data. There is no measurement
of such a ball. The contact lasts {contact:.1f} ms at 25 degC, so the frequency is about {frequency:.0f} Hz, beyond the
test machine and within the shifted data. The last column is e = exp(-tan delta/0.815) of `effective_moduli` with the
loss tangent at 100 Hz, without any shift.

{balls}

"""

POLYMER_TEXT = """\
## Relaxation of a polymer

Relaxation master curve in tension (verification data of NREL pyvisco), {n} points over {decades:.0f} decades. Root
mean square of the relative deviation from the points:

{fits}

The spectrum is smooth by construction. Few terms do not describe this polymer.
"""

CELL_TEXT = """\
## Relaxation of egg cells

{count} records of stress relaxation of a mouse oocyte under a tipless cantilever (Battistella et al. 2022, Bioeng.
Transl. Med. 7, e10294, fig. 5d, cell 1; data in the examples of afmformats). Their analysis fits two exponentials and
a constant to the force of the hold. `rs.identify` with a generalised Maxwell model of two terms and constant noise
gives the same times, beside those of the analysis in the example script of afmformats (SciPy's least squares with the
starts and bounds of the script):

{times}

The largest relative difference is {difference:.0e}. The published figure shows the same ranges, 1.4 to 1.7 s and 6 to
12 s.

The two times are no properties of the cell. The residuals of two terms change sign far too seldom (p < {runs:.0e} in
the runs test), so the stated errors are too small. A third term reduces chi2 by factors of {least:.0f} to {most:.0f},
and the longest time becomes {slow_low:.0f} to {slow_high:.0f} s.

`rs.read_curves` takes {taken} of the whole records and refuses the others in one line:

{refusals}
"""


def table(head: tuple[str, ...], rows: list[tuple[str, ...]]) -> str:
    """Table in Markdown."""
    lines = [head, ("---",) * len(head), *rows]
    return "\n".join(f"| {' | '.join(line)} |" for line in lines)


def rebounds(name: str, radius: float = 20e-3, mass: float = 40e-3) -> rs.Rebounds:
    """Measured bounces of a ball; radius and mass are used where they were not published."""
    body, velocity, e = BALLS[name]
    radius, mass = body or (radius, mass)
    return rs.Rebounds(velocity, e, radius=radius, mass=mass, noise=rs.Noise(restitution_coefficient=SCATTER))


def fitted(data: Any, model: str, **options: Any) -> rs.Identification:
    """Fit of an incompressible material."""
    return rs.identify(data, model, fixed={"poisson_ratio": 0.5}, **options)


def restitution_at(fit: rs.Identification, velocity: float) -> tuple[float, float, float]:
    """Predicted e of the first ball of the data, and its band."""
    ball: Any = fit.data[0]
    solid = fit.materials.shear.row(0, 0)
    impact = rs.Impact(rs.Material(solid, math.inf), rs.Parabola(float(ball.radius[0])), float(ball.mass[0]), velocity)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        e = fit.predict(impact)
    low, value, high = (float(e[f"restitution_coefficient{end}"].item()) for end in ("_low", "", "_high"))
    return low, value, high


def shown(band: tuple[float, float, float]) -> str:
    """Value with its band."""
    low, value, high = band
    return f"{value:.3f} ({low:.3f} to {high:.3f})"


def balls() -> str:
    """Fits of the bouncing balls."""
    velocities = sorted({v for _, many, _ in BALLS.values() for v in many})
    data = [
        (name, *(f"{dict(zip(many, e, strict=True)).get(v, math.nan):.3f}".replace("nan", "") for v in velocities))
        for name, (_, many, e) in BALLS.items()
    ]
    rows: list[tuple[str, ...]] = []
    results: dict[tuple[str, str], rs.Identification] = {}
    for name in BALLS:
        data_of = rebounds(name)
        tangent = rs.effective_moduli(data_of).loss_tangent
        results |= {(name, model): fitted(data_of, model) for model in MODELS}
        fits = [results[name, model] for model in MODELS]
        determined = [key for fit in fits for key, estimate in fit.parameters.items() if estimate.determined]
        rows.append(
            (name, f"{tangent.min():.3f} to {tangent.max():.3f}", ", ".join(determined) or "none",
             *(f"{fit.chi2:.2f}" for fit in fits), *(shown(restitution_at(fit, 10.0)) for fit in fits))
        )  # fmt: skip
    sizes = [fitted(rebounds("blue", *body), "kelvin_voigt") for body in ((10e-3, 5e-3), (40e-3, 300e-3))]
    apart = max(
        abs(sizes[0].chi2 / sizes[1].chi2 - 1.0),
        abs(restitution_at(sizes[0], 10.0)[1] / restitution_at(sizes[1], 10.0)[1] - 1.0),
    )
    names = [name.replace("_", " ").replace("springpot", "power law") for name in MODELS]
    head = ("ball", "tan delta", "determined constants", *(f"chi2, {name}" for name in names),
            *(f"e at 10 m/s, {name}" for name in names))  # fmt: skip
    return BALL_TEXT.format(
        scatter=SCATTER, data=table(("ball", *(f"{v} m/s" for v in velocities)), data), invariance=apart,
        fits=table(head, rows), warning=results["table tennis", "kelvin_voigt"].warnings[-1],
        itf=shown(restitution_at(results["tennis", "springpot"], 7.06)),
        itf_kv=shown(restitution_at(results["tennis", "kelvin_voigt"], 7.06)),
    )  # fmt: skip


def isotherms() -> Any:
    """Moduli of the EPDM rubber."""
    omega = 2.0 * math.pi * np.array([1.0, 100.0])
    tables: list[rs.DynamicTable] = []
    for celsius, slow, slow_tangent, fast, fast_tangent in EPDM:
        storage = 1e6 * np.array([slow, fast])
        loss = storage * [slow_tangent, fast_tangent]
        tables.append(rs.DynamicTable(omega, storage, loss, "shear", temperature=celsius + 273.15))
    return rs.Isotherms(tables, source="EPDM")


def rubber() -> str:
    """Superposition of the rubber, and the restitution that follows."""
    measured = isotherms()
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # the table has the errors
        free, wlf, arrhenius = (
            measured.superposed(reference_temperature=ROOM, shift=law) for law in ("free", "wlf", "arrhenius")
        )
    rows = [
        (f"{isotherm[0]:.0f} degC", *(f"{curve.log10_factors[n] + 0.0:.2f} +- {curve.errors[n]:.2f}"
                                 for curve in (free, wlf, arrhenius)))
        for n, isotherm in enumerate(EPDM)
    ]  # fmt: skip
    rows.append(("misfit", *(f"{curve.misfit:.1e}" for curve in (free, wlf, arrhenius))))
    above = ROOM - (273.15 - 50.0)
    radius, density = 0.01, 1100.0
    mass = density * 4.0 / 3.0 * math.pi * radius**3
    models = ("springpot", "fractional_kelvin_voigt")
    fits = [fitted(measured, model, shift=rs.WLF) for model in models]
    master = rs.fit_prony(wlf.data).series
    predictions, contact = list[tuple[str, ...]](), math.nan
    for celsius in (4.0, 18.0, 25.0, 39.0, 53.0):
        factor = wlf.shift.factor(celsius + 273.15)
        shifted = rs.PronySeries(
            master.equilibrium_modulus, master.branch_moduli, factor * np.asarray(master.relaxation_times)
        )
        restitutions: list[str] = []
        for series in (shifted, *(fit.materials.at(celsius + 273.15).shear.row(0, 0) for fit in fits)):
            result = rs.solve(rs.Impact(rs.Material(series, math.inf), rs.Parabola(radius), mass, 1.0))
            restitutions.append(f"{float(result.restitution_coefficient):.3f}")
            contact = float(result.contact_time) if celsius == 25.0 else contact
        fast = next(isotherm[4] for isotherm in EPDM if isotherm[0] == celsius)
        predictions.append((f"{celsius:.0f} degC", *restitutions, f"{math.exp(-fast / 0.815):.3f}"))
    return RUBBER_TEXT.format(
        shifts=table(("temperature", "free", "WLF", "Arrhenius"), rows),
        c1=wlf.constants["c1"], c1_error=wlf.constant_errors["c1"],
        c2=wlf.constants["c2"], c2_error=wlf.constant_errors["c2"],
        u1=17.44 * 51.6 / (51.6 + above), u2=51.6 + above, contact=1e3 * contact, frequency=0.565 / contact,
        balls=table(("temperature", "terms of the master curve", "power law", "fractional Kelvin-Voigt",
                     "from tan delta at 100 Hz"), predictions),
    )  # fmt: skip


def polymer(file: Path) -> str:
    """Fits of the relaxation of a polymer."""
    data: Any = rs.read_material(file)

    def deviation(modulus: np.ndarray) -> str:
        return f"{100.0 * float(np.sqrt(np.mean((modulus / data.modulus - 1.0) ** 2))):.2g} %"

    rows = [("`fit_prony`, non-negative terms", deviation(rs.fit_prony(data).series.relaxation_modulus(data.time)))]

    def in_tension(shear: rs.PronySeries) -> Any:
        return rs.tension_from_shear(shear, poisson_ratio=0.5)

    smooth: Any = fitted(data, "spectrum")
    rows.append(("spectrum", deviation(in_tension(smooth.material.shear)
                                       .relaxation_modulus(data.time))))  # fmt: skip
    for model, words in (("fractional_zener", "fractional Zener"), ("generalised_maxwell", "three terms")):
        fit = fitted(data, model, terms=3, profiles=False)
        rows.append((words, deviation(in_tension(fit.materials.shear.row(0, 0)).relaxation_modulus(data.time))))
    decades = math.log10(data.time[-1] / data.time[data.time > 0.0][0])
    return POLYMER_TEXT.format(n=data.time.size, decades=decades, fits=table(("fit", "deviation"), rows))


def two_exponentials(time: np.ndarray, force: np.ndarray) -> tuple[float, float]:
    """Times of c + a exp(-t/t1) + b exp(-t/t2), from the starts and within the bounds of the example script."""
    from scipy.optimize import least_squares

    def residuals(p: np.ndarray) -> np.ndarray:
        return p[0] + p[1] * np.exp(-time / p[2]) + p[3] * np.exp(-time / p[4]) - force

    start = [force.min(), 100.0, 1.0, 50.0, 8.0]
    result = least_squares(residuals, start, bounds=([-1e4, 0.0, 0.1, 0.0, 2.0], 1e4), x_scale=start, xtol=1e-12)
    return float(result.x[2]), float(result.x[4])


def cells(file: Path) -> str:
    """Relaxation times of egg cells beside the published analysis."""
    import afmformats  # pyright: ignore[reportMissingImports]

    rows: list[tuple[str, ...]] = []
    differences, gains, slowest, chances, refusals = [], [], [], [], Counter[str]()
    with tempfile.TemporaryDirectory() as folder:
        zipfile.ZipFile(file).extractall(folder)
        for path in sorted(Path(folder).glob("*.jpk-force")):
            record: Any = afmformats.load_data(path)[0]
            time, force, segment = (np.asarray(record[name]) for name in ("time", "force", "segment"))
            hold = segment == 2
            t, f = time[hold] - time[hold][0] + 1e-3, 1e9 * (force[hold] - force[segment == 0].mean())
            theirs = two_exponentials(t, f)
            # Forces [nN] in place of moduli: the relaxation at a constant contact area has the same times.
            data = Moduli(rs.RelaxationTable(t, f, "shear"), noise=rs.Noise(modulus=0.8))
            two, three = (fitted(data, "generalised_maxwell", terms=n, profiles=False) for n in (2, 3))
            ours = [two.parameters[f"relaxation_times[{n}]"] for n in (0, 1)]
            differences += [
                abs((estimate.value or math.nan) / other - 1.0) for estimate, other in zip(ours, theirs, strict=True)
            ]
            gains.append(two.chi2 / three.chi2)
            slowest.append(three.parameters["relaxation_times[2]"].value)
            chances.append(two.runs_test)
            rows.append((path.stem[-4:], *(f"{each.value:.3f} +- {each.standard_error:.3f}" for each in ours),
                         *(f"{value:.3f}" for value in theirs)))  # fmt: skip
            try:
                rs.read_curves(path, profile=rs.Parabola(40e-6))[0]()
            except rs.InputError as error:
                # The force of a pull is another one in each record.
                refusals[re.sub(r"^.*\]: |(?<=force) = \S+ N(?=:)", "", str(error))] += 1
    head = ("record", "t1 [s], identify", "t2 [s], identify", "t1 [s], example", "t2 [s], example")
    return CELL_TEXT.format(
        count=len(rows), times=table(head, rows), difference=max(differences), runs=max(*chances, 1e-300),
        least=min(gains), most=max(gains), slow_low=min(slowest), slow_high=max(slowest),
        taken=len(rows) - refusals.total(),
        refusals="\n".join(f"* {count}: `{line}`" for line, count in sorted(refusals.items())),
    )  # fmt: skip


def main() -> None:
    """Make all tables."""
    parts = ["# Real measurements\n\nMade by `validation/real_data.py`.", balls(), rubber()]
    for name in sys.argv[1:]:
        file = Path(name)
        part = curves_of_instruments if file.is_dir() else cells if file.suffix == ".zip" else polymer
        parts.append(part(file))
    text = "\n\n".join(part.strip() for part in parts) + "\n"
    print(text)
    Path(__file__).with_suffix(".md").write_text(text, encoding="utf-8")


if __name__ == "__main__":
    main()
