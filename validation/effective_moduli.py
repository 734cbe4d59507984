"""Errors of the formulas of one bounce for random materials of five families.

Run as `python validation/effective_moduli.py`; prints a table and writes it to `effective_moduli.md` beside this file.
Takes a minute. A ball of unit mass, radius and velocity strikes materials whose moduli are scaled so that the contact
lasts about one second, to which the relaxation times of the families refer.
"""

from __future__ import annotations

import sys
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

import restitution as rs
from restitution.identification.bounce_moduli import FORMULA_ERRORS
from restitution.identification.readings import effective_moduli

TEXT = """\
## Formulas of one bounce

`validation/effective_moduli.py` makes this table. The materials of each family are random, and bounces with
$0.15 \\le e \\le 0.995$ count. Errors are those of the exact impact against the complex modulus of the material at the
frequency of the formula: median and 95 % quantile of the absolute relative error, in per cent. The package states the
numbers in parentheses.

* broad spectrum: 15 terms over seven decades, log-linear with smooth random deviations of 30 %.
* power law: a springpot with an exponent from 0.01 to 0.5.
* fractional Zener: exponent from 0.3 to 0.9, branch 0.1 to 100 times the equilibrium modulus, time 0.01 to 100 contact
  times.
* one and two relaxation times: branches 0.03 to 30 times the equilibrium modulus, times 0.01 to 100 contact times.

{table}
"""

Array = NDArray[np.float64]
Generator = np.random.Generator


def broad_spectrum(rng: Generator) -> rs.PronySeries:
    times = np.geomspace(10.0**-3.5, 10.0**3.5, 15)
    deviations = np.convolve(np.pad(rng.normal(0.0, 0.3, 15), 2, "edge"), np.full(5, 0.2), "valid")
    spectrum = np.exp(rng.normal(0.0, 0.15) * np.log(times) + deviations)
    return rs.PronySeries(1.0, 10.0 ** rng.uniform(-2.3, 0.0) * spectrum, times)


def power_law(rng: Generator) -> rs.PronySeries:
    return rs.springpot(1.0, rng.uniform(0.01, 0.5)).prony((1e-5, 1e3), rtol=1e-5).series


def fractional_zener(rng: Generator) -> rs.PronySeries:
    model = rs.fractional_zener(1.0, 10.0 ** rng.uniform(-1, 2), 10.0 ** rng.uniform(-2, 2), rng.uniform(0.3, 0.9))
    return model.prony((1e-5, 1e3), rtol=1e-5).series


def terms(rng: Generator, count: int) -> rs.PronySeries:
    return rs.PronySeries(1.0, 10.0 ** rng.uniform(-1.5, 1.5, count), 10.0 ** rng.uniform(-2.0, 2.0, count))


FAMILIES = {
    "broad spectrum": broad_spectrum,
    "power law": power_law,
    "fractional Zener": fractional_zener,
    "two relaxation times": lambda rng: terms(rng, 2),
    "single relaxation time": lambda rng: terms(rng, 1),
}


def errors(family: str, count: int, rng: Generator) -> dict[str, Array]:
    """Relative errors of the effective moduli of random materials of a family."""
    reduced = rs.PronySeries.stacked([FAMILIES[family](rng) for _ in range(count)])
    # An elastic ball with E* = 14 Pa stays in contact for one second.
    reduced = reduced.scaled(14.0 / reduced.relaxation_modulus(0.5))
    materials = rs.Material(reduced.scaled(0.25), np.inf).reshaped((count, 1))
    ball = rs.Rebounds([1.0], [1.0], radius=1.0, mass=1.0)
    results = {name: values[:, 0] for name, values in ball.predicted(materials).items()}
    e = results["restitution_coefficient"]
    kept = np.flatnonzero((e >= 0.15) & (e <= 0.995))
    result: dict[str, Array] = {}
    for name, measured in (("time", "contact_time"), ("force", "max_force")):
        size = {measured: results[measured][kept]}
        # The radius is 1 m and so is the depth; a small unit of length keeps the check of the time from refusing it.
        balls = rs.Rebounds(np.ones(kept.size), e[kept], profile=rs.Parabola(1.0), mass=1.0, **size)
        moduli = effective_moduli(balls)
        exact = np.array([
            reduced.row(n).storage_modulus(w) + 1j * reduced.row(n).loss_modulus(w)
            for n, w in zip(kept, moduli.angular_frequency, strict=True)
        ])  # fmt: skip
        result[f"storage_by_{name}"] = moduli.storage_modulus / exact.real - 1.0
        if name == "time":
            result["loss_tangent"] = moduli.loss_tangent / (exact.imag / exact.real) - 1.0
    return result


def main(count: int = 1000) -> None:
    """Print the table and write it beside this file."""
    head = "| family | loss tangent | storage modulus from the contact time | storage modulus from the peak force |"
    lines = [head, "|---" * 4 + "|"]
    rng = np.random.default_rng(1)
    for family in FAMILIES:
        result, cells = errors(family, count, rng), list[str]()
        for name in ("loss_tangent", "storage_by_time", "storage_by_force"):
            size, stated = np.abs(result[name]), getattr(FORMULA_ERRORS[family], name)
            median, most = 100.0 * np.median(size), 100.0 * np.quantile(size, 0.95)
            cells.append(f"{median:.2g} / {most:.2g} ({100.0 * stated:.2g})")
        lines.append(f"| {family} | {' | '.join(cells)} |")
        print(lines[-1], flush=True)
    Path(__file__).with_suffix(".md").write_text(TEXT.format(table="\n".join(lines)), encoding="utf-8")


if __name__ == "__main__":
    main(*map(int, sys.argv[1:]))
