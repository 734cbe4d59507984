"""Every measured data set of the project beside a prediction that did not see it: `python validation/bench.py`.

Writes `bench.md`. Balls, rubber, polymer and oblique impacts are computed here, in a minute. The records of egg cells
and the taps need files that are no part of this repository, or ten minutes; their numbers are taken from the pages of
`real_data.py` and `tapping.py`, which computed them.
"""

from __future__ import annotations

import argparse
import math
import re
import warnings
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import oblique
import real_data

import restitution as rs

FOLDER = Path(__file__).parent
POLYMER = FOLDER.parent / "examples" / "measured" / "polymer_relaxation.csv"
# Numbers read from a printed figure [-], [rad/s].
READ, READ_SPIN = 0.015, 15.0
# A prediction is good if its residuals are within so many error bars, as root mean square.
GOOD = 2.0


@dataclass(frozen=True)
class Row:
    """One prediction.

    Attributes
    ----------
    data, source, licence, inputs : str
        What was measured, by whom, under which licence, and what the prediction was given.
    quantity : str
        What is predicted, with its unit.
    residual : float
        Root mean square of prediction minus measurement.
    error : float
        Standard deviation of this difference, from the measurement and from the prediction.
    basis : str
        Where the error bar comes from.
    """

    data: str
    source: str
    licence: str
    inputs: str
    quantity: str
    residual: float
    error: float
    basis: str

    @property
    def verdict(self) -> str:
        """Whether the residuals are within the error bars."""
        return "good" if self.residual <= GOOD * self.error else "bad"


def rms(values: object) -> float:
    """Return the root of the mean square."""
    return float(np.sqrt(np.mean(np.square(values))))


def thrown() -> list[Row]:
    """Oblique impacts, from elastic constants and friction alone."""
    source = "Kharaz, Gorham and Salman, Powder Technology 120 (2001) 281"
    common = (source, "numbers read from figures", "E, nu, density of both bodies, friction 0.092, 3.9 m/s")
    rolls = oblique.ANGLES < oblique.SLIDES
    tangential = (oblique.ratio(oblique.thrown(oblique.ANGLES)) - oblique.MEASURED)[rolls]
    spin = np.abs(oblique.thrown(oblique.SPIN_ANGLES).rebound_spin) - oblique.SPINS
    name = "alumina balls on glass, oblique"
    return [
        Row(name, *common, "v_x'/v_x below 30 degrees", rms(tangential), READ, "reading of the figure"),
        Row(name, *common, "spin [rad/s]", rms(spin), READ_SPIN, "reading of the figure"),
        Row(name, *common, "e, of elastic bodies", abs(1.0 - 0.98), 0.005, "last digit of the paper's 0.98"),
    ]


def balls() -> list[Row]:
    """Fastest two bounces of each ball, from a power law fitted to the slower ones."""
    rows: list[Row] = []
    for name, (body, velocity, e) in real_data.BALLS.items():
        radius, mass = body or (20e-3, 40e-3)
        noise = rs.Noise(restitution_coefficient=real_data.SCATTER)
        slower = rs.Rebounds(velocity[:-2], e[:-2], radius=radius, mass=mass, noise=noise)
        result = real_data.fitted(slower, "springpot")
        bands = [real_data.restitution_at(result, v) for v in velocity[-2:]]
        spread = (bands[0][2] - bands[0][0]) / (2.0 * 1.96)
        rows.append(
            Row(
                f"{name} ball", "student laboratory, github.com/giiulia/LabI-Dynamics-Thermodynamics", "none stated",
                f"e at {velocity[0]} to {velocity[-3]} m/s",
                f"e at {velocity[-2]} and {velocity[-1]} m/s",
                rms([band[1] - value for band, value in zip(bands, e[-2:], strict=True)]),
                math.hypot(spread, real_data.SCATTER), "0.015 of each e, and of the fit",
            )
        )  # fmt: skip
    return rows


def rubber() -> list[Row]:
    """Moduli of EPDM at 25 degC, from the five other temperatures."""
    measured = real_data.isotherms()
    others = [table for table in measured.tables if abs(table.temperature - real_data.ROOM) > 1.0]
    (reference,) = (table for table in measured.tables if table not in others)
    result = real_data.fitted(rs.Isotherms(others, source="EPDM"), "fractional_kelvin_voigt", shift=rs.WLF)
    series = result.materials.at(real_data.ROOM).shear.row(0, 0)
    omega = reference.angular_frequency
    storage = np.log(series.storage_modulus(omega) / reference.storage_modulus)
    tangent = np.log(series.loss_tangent(omega) * reference.storage_modulus / reference.loss_modulus)
    # The misfit of the other temperatures, of the same model: what it does not describe there it will not here.
    parts: list[tuple[np.ndarray, np.ndarray]] = []
    for table in others:
        at = result.materials.at(table.temperature).shear.row(0, 0)
        ratio = at.loss_tangent(omega) * table.storage_modulus / table.loss_modulus
        parts.append((np.log(at.storage_modulus(omega) / table.storage_modulus), np.log(ratio)))
    common = (
        "EPDM rubber in shear", "github.com/MarcusNi96/dma-prony-validation", "GPL-3.0 (numbers alone are used)",
        "G', G'' at five other temperatures, 1 and 100 Hz; fractional Kelvin-Voigt solid with WLF",
    )  # fmt: skip
    basis = "misfit of the other temperatures"
    misfits = [rms([part[place] for part in parts]) for place in (0, 1)]
    return [
        Row(*common, "G' at 25 degC, relative", rms(storage), misfits[0], basis),
        Row(*common, "tan delta at 25 degC, relative", rms(tangent), misfits[1], basis),
    ]


def polymer() -> Row:
    """Every second point of a relaxation curve, from the others."""
    data = rs.read_material(POLYMER)
    some = rs.RelaxationTable(data.time[::2], data.modulus[::2], data.deformation)
    fit = rs.fit_prony(some)
    unseen = fit.series.relaxation_modulus(data.time[1::2]) / data.modulus[1::2] - 1.0
    return Row(
        "relaxation of a polymer", "verification data of pyvisco, NREL", "BSD-3-Clause (`examples/measured`)",
        "every second of 481 points over 31 decades; `rs.fit_prony`", "E(t) at the other points, relative",
        rms(unseen), fit.misfit, "misfit of the fitted points",
    )  # fmt: skip


def cells() -> Row:
    """Relaxation times of egg cells, from the page of `real_data.py`."""
    text = (FOLDER / "real_data.md").read_text(encoding="utf-8")
    number = r"([\d.]+)"
    result = re.findall(
        rf"^\| \d{{4}} \| {number} \+- {number} \| {number} \+- {number} \| {number} \| {number} \|$", text, re.M
    )
    values = np.array(result, dtype=float)
    residuals = values[:, [0, 2]] - values[:, 4:]
    return Row(
        "egg cells under a cantilever, 15 records", "Battistella et al., Bioeng. Transl. Med. 7 (2022) e10294",
        "examples of afmformats, MIT", "force of the hold; two terms",
        "both times [s], beside the published analysis", rms(residuals), rms(values[:, [1, 3]]),
        "stated by the fit; too small, for two terms miss the curve",
    )  # fmt: skip


def taps() -> Row:
    """Peak forces of a published simulation of tapping, from the page of `tapping.py`."""
    text = (FOLDER / "tapping.md").read_text(encoding="utf-8")

    def column(words: str) -> np.ndarray:
        lines = [line.split("|") for line in text.splitlines() if f"| {words} |" in line]
        return np.array([float(line[5]) for line in lines])

    residual = rms(column("exact, with the pull") / column("published") - 1.0)
    return Row(
        "taps on polyisobutylene, four distances", "github.com/ealopez/TappingMode_Simulations: a simulation", "MIT",
        "Prony terms, tip, cantilever, van der Waals force", "peak force, relative", residual,
        0.03, "one mode of the cantilever in place of three: an estimate",
    )  # fmt: skip


def rows() -> list[Row]:
    """Return all predictions."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        return [*thrown(), *balls(), *rubber(), polymer(), cells(), taps()]


def page(rows: list[Row]) -> str:
    """Return the rows as two tables: the predictions, and where the data come from."""
    head = "| data | prediction | residual | error bar | from | verdict |"
    lines = [head, "|---|---|---|---|---|---|"]
    lines += [
        f"| {row.data} | {row.quantity} | {row.residual:.2g} | {row.error:.2g} | {row.basis} | **{row.verdict}** |"
        for row in rows
    ]
    lines += ["", "| data | source | licence | inputs of the prediction |", "|---|---|---|---|"]
    lines += dict.fromkeys(f"| {row.data} | {row.source} | {row.licence} | {row.inputs} |" for row in rows)
    good = sum(row.verdict == "good" for row in rows)
    return "\n".join(["Made by `validation/bench.py`.", "", *lines, "", f"{good} of {len(rows)} are good.", ""])


def main() -> None:
    """Write the page."""
    text = page(rows())
    print(text)
    Path(__file__).with_suffix(".md").write_text(text, encoding="utf-8")


if __name__ == "__main__":
    argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter).parse_args()
    main()
