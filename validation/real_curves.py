"""What comes out of files of atomic force microscopes: the test data of afmformats, and records of egg cells.

Run as `python validation/real_curves.py FOLDER`, where FOLDER is the unpacked source distribution of afmformats (MIT,
version 0.18.7), which must be installed. Prints the tables and writes them into their sections of `real_data.md`
beside this file. The data are not part of this repository. Takes about a minute. With `--adhesion` it fits the whole
records that show adhesion, and makes their section alone, in about a quarter of an hour.
"""

from __future__ import annotations

import re
import sys
import time
import warnings
from itertools import groupby
from pathlib import Path

import numpy as np

import restitution as rs
from restitution.identification.curve_files import CurveReader

HEADING = "## Curves of several instruments"
TEXT = """\
{heading}

Made by `validation/real_curves.py` from the test data and the example of afmformats 0.18.7 (MIT): {count} curves of
JPK, Asylum Research, AFM Workshop, Optics11 Chiaro and NT-MDT, and exports of afmformats. Without arguments
{read} are read; the others are refused in the line of the table, which names what would help. With the arguments of
the second table {read_with} are read into their columns. Constants that no file states are guesses, so forces there
mean nothing. The rate of the file of 2021-01-15 is its speed over its steps; those of the other files of AFM Workshop
and of NT-MDT are guesses, too.

{reading}

`IndentationCurve` takes {accepted} of the {read_with} curves, {approach} of them with `segment="approach"` because
of adhesion on the way out, and `rs.identify` fits {fitted} of these. The model is that of the page on AFM, a
standard solid with a Poisson ratio of 0.5, under a sphere of 2.5 um, or of 40 um on egg cells. The true tips are
unknown, and some samples are rigid: the moduli mean nothing. The misfit is the root mean square of the residuals
over the range of the force.

{identified}
"""
PULLS = "## Pull-offs of several instruments"
PULLS_TEXT = """\
{heading}

Made by `validation/real_curves.py --adhesion` from the same files: all {count} curves that are refused as a whole
because of a pull on the way out or a jump, read with `adhesion=True` and fitted with work and stress of adhesion as
further unknowns, `profiles=False`. {fitted} have a fit. The tips are guesses as above, so that the numbers mean
nothing. The measured force of the largest pull is a number of the sample. The pull of a sphere with the work of the
fit, 1.5 to 2 pi R times it, is below half of it in {below} fits, and above three times it in {above}. Nearly all
misfits are beyond the noise: a standard solid on a half-space is not the sample, the drag of a cantilever in liquid
differs on both ways, and the tip is no sphere.

{rows}
"""
TIP, CELL = rs.Parabola(2.5e-6), rs.Parabola(40e-6)
# Arguments by the beginnings of the names of files, for what a file does not state.
GUESSES: dict[str, dict[str, float]] = {
    "fmt-afm-workshop-fd_mapping": {"sensitivity": 1e-7, "spring_constant": 0.1, "rate": 1000.0},
    "fmt-afm-workshop-fd_single_2018": {"sensitivity": 1e-7, "spring_constant": 0.1, "rate": 1000.0},
    "fmt-afm-workshop-fd_single_2020": {"spring_constant": 40.0, "rate": 1000.0},
    # 500 nm/s over steps of 0.75 nm
    "fmt-afm-workshop-fd_single_2021-01": {"sensitivity": 1e-7, "spring_constant": 0.1, "rate": 667.0},
    "fmt-afm-workshop-fd_single_2021-10": {"spring_constant": 0.05, "rate": 1000.0},
    "fmt-jpk-cl_calibration": {"sensitivity": 5e-8, "spring_constant": 0.05},
    "fmt-jpk-fd_single-modified": {"spring_constant": 0.05},
    # The constants of the tests of afmformats.
    "fmt-ntmdt": {"sensitivity": 61.0, "spring_constant": 0.055, "rate": 1000.0},
}


def table(head: tuple[str, ...], rows: list[tuple[str, ...]]) -> str:
    """Table in Markdown."""
    lines = [head, ("---",) * len(head), *rows]
    return "\n".join(f"| {' | '.join(cell.replace('|', '/') for cell in line)} |" for line in lines)


def line_of(error: rs.InputError) -> str:
    """Error without the curve and the time."""
    return re.sub(r", near time = \S+ s$", "", str(error.within(where=" ")).removeprefix(" : "))


def read(reader: CurveReader) -> tuple[rs.IndentationCurve | None, str]:
    """Curve, and what happened."""
    try:
        return reader(), "read"
    except rs.InputError as error:
        if 'segment="approach"' not in str(error):
            return None, line_of(error)
    try:
        return reader("approach"), "approach alone"
    except rs.InputError as error:
        return None, line_of(error)


def identified(curve: rs.IndentationCurve) -> tuple[bool, str]:
    """Whether a model fits, and the misfit and constants or the reason."""
    try:
        result = rs.identify(curve, rs.standard_solid, fixed={"poisson_ratio": 0.5}, profiles=False)
    except rs.InputError as error:
        return False, f"no fit: {line_of(error)}"
    (fit,) = result.curves[0][1]
    misfit = np.sqrt(np.mean((fit.measured - fit.fitted) ** 2)) / np.ptp(fit.measured)
    determined = [
        f"{name.replace('_', ' ')} {each.words}" for name, each in result.parameters.items() if each.determined
    ]
    return True, f"misfit {100.0 * misfit:.1f} %; {', '.join(determined) or 'no constant is determined'}"


def adhering(curve: rs.IndentationCurve) -> tuple[bool, tuple[str, ...]]:
    """Whether a model with adhesion fits a whole record, and the cells of its row."""
    start = time.perf_counter()
    try:
        result = rs.identify(curve, rs.standard_solid, fixed={"poisson_ratio": 0.5}, profiles=False)
    except rs.InputError as error:
        return False, ("", "", "", f"no fit: {line_of(error)}", "")
    print(f"    {time.perf_counter() - start:.0f} s")
    (fit,) = result.curves[0][1]
    misfit = np.sqrt(np.mean((fit.measured - fit.fitted) ** 2)) / np.ptp(fit.measured)
    determined = [
        f"{name.replace('_', ' ')} {each.words}" for name, each in result.parameters.items() if each.determined
    ]
    # Numbers in a doubt are those of the constants.
    doubts = [re.sub(r" \(p = .*?\)|: a stress above .*", "", line) for line in result.warnings]
    largest = float(np.median(fit.measured[:10]) - fit.measured.min())
    pull = 1.75 * np.pi * float(result.adhesion.work) * tip_radius(curve)
    return True, (
        f"{largest:.2g} N", f"{pull:.2g} N", f"{100.0 * misfit:.1f} %",
        "; ".join(determined) or "no constant is determined", "; ".join(doubts),
    )  # fmt: skip


def tip_radius(curve: rs.IndentationCurve) -> float:
    """Radius of the tip [m]."""
    return float(np.asarray((CELL if "cell" in curve.label else TIP).radius))


def arguments(name: str) -> dict[str, float]:
    """Arguments for a file."""
    return next((guess for beginning, guess in GUESSES.items() if name.startswith(beginning)), {})


def merged(rows: list[tuple[str, ...]]) -> list[tuple[str, ...]]:
    """Rows of curves that differ by their number alone, in one."""
    alike = [list(group) for _, group in groupby(rows, key=lambda row: (row[0], *row[2:]))]
    numbers = [[row[1] for row in group] for group in alike]
    words = [", ".join(many) if len(many) < 4 else f"{many[0]} to {many[-1]}" for many in numbers]
    return [(group[0][0], which, *group[0][2:]) for group, which in zip(alike, words, strict=True)]


def numbered(label: str) -> tuple[str, str]:
    """Name of the file, and the number of the curve, or of its file in an archive."""
    file, _, number = label.removesuffix("]").rpartition("[")
    archive, _, member = file.partition("/")
    digits = re.findall(r"\d+", Path(member).stem)
    return archive.removeprefix("fmt-"), digits[-1] if digits else number


def files_in(folder: Path) -> list[Path]:
    """All files of curves."""
    return [*sorted((folder / "tests" / "data").iterdir()), *sorted((folder / "examples" / "data").glob("*.zip"))]


def curves_of_instruments(folder: Path) -> str:
    """Both tables, for all files under the folder."""
    reading, fits = list[tuple[str, ...]](), list[tuple[str, ...]]()
    counts = dict.fromkeys(("count", "read", "read_with", "accepted", "approach", "fitted"), 0)
    for file in files_in(folder):
        guess, tip = arguments(file.name), CELL if "cell" in file.name else TIP
        plain, completed = rs.read_curves(file, profile=tip), rs.read_curves(file, profile=tip, **guess)
        for bare, other in zip(plain, completed, strict=True):
            sizes = bare.record().segments[0]
            place = numbered(bare.label)
            _, without = read(bare)
            curve, outcome = read(other)
            print(bare.label, without, outcome, sep="\n    ", flush=True)
            lacks = without.startswith("has no")
            counts["count"] += 1
            counts["read"] += not lacks
            counts["read_with"] += not outcome.startswith("has no")
            words = ", ".join(f"{name} {value:g}" for name, value in guess.items())
            reading.append((*place, " + ".join(map(str, sizes)), without if lacks else "read"))
            fitted, result = (False, f"refused: {outcome}") if curve is None else identified(curve)
            if outcome == "approach alone":
                result = f"approach alone: {result}"
                counts["approach"] += 1
            counts["accepted"] += curve is not None
            counts["fitted"] += fitted
            fits.append((*place, words, result))
            print("   ", result, flush=True)
    head = ("file", "curve", "samples of the segments", "without arguments")
    return TEXT.format(
        heading=HEADING, **counts, reading=table(head, merged(reading)),
        identified=table(("file", "curve", "arguments", "identification"), merged(fits)),
    )  # fmt: skip


def pull_offs(folder: Path) -> str:
    """Table of the whole records that show adhesion."""
    rows, count, shares = list[tuple[str, ...]](), 0, list[float]()
    for file in files_in(folder):
        for reader in rs.read_curves(file, profile=CELL if "cell" in file.name else TIP, **arguments(file.name)):
            try:
                reader()
            except rs.InputError as error:
                if 'segment="approach"' not in str(error):
                    continue
            else:
                continue
            print(reader.label, flush=True)
            count += 1
            try:
                result, cells = adhering(reader(adhesion=True))
            except rs.InputError as error:
                result, cells = False, ("", "", "", f"refused: {line_of(error)}", "")
            if result:
                measured, of_work = (float(cell.split()[0]) for cell in cells[:2])
                shares.append(of_work / measured)
            rows.append((*numbered(reader.label), *cells))
            print("   ", *cells, sep=" | ", flush=True)
    head = ("file", "curve", "largest pull", "work of the fit times 1.75 pi R", "misfit", "determined", "doubts")
    below, above = sum(share < 0.5 for share in shares), sum(share > 3.0 for share in shares)
    return PULLS_TEXT.format(
        heading=PULLS, count=count, fitted=len(shares), below=below, above=above, rows=table(head, merged(rows))
    )


def main() -> None:
    """Make the tables, and put them in place of the former ones."""
    warnings.simplefilter("ignore")  # of depths that are noisy
    heading, make = (PULLS, pull_offs) if "--adhesion" in sys.argv else (HEADING, curves_of_instruments)
    text = make(Path(sys.argv[1]))
    print(text)
    page = Path(__file__).with_name("real_data.md")
    before, _, rest = page.read_text(encoding="utf-8").partition(heading)
    after = re.search(r"^## .*", rest, flags=re.MULTILINE | re.DOTALL)
    parts = [before.strip(), text.strip(), after[0].strip() if after else ""]
    page.write_text("\n\n".join(part for part in parts if part) + "\n", encoding="utf-8")


if __name__ == "__main__":
    main()
