"""Damaged files of observations end in an `InputError` of one line that names the file, or in valid data."""

import random
import warnings
from pathlib import Path

import pytest

from checkout import EXAMPLES
from restitution import InputError, RestitutionWarning, read_observations

DATA = EXAMPLES / "identification"
SEEDS = {
    "balls.csv": {},
    "sound.csv": {"radius": 0.02, "mass": 0.0335},
    "afm_curve.csv": {"profile": None},
    "oscillations.csv": {"radius": 2.5e-6},
    "moduli.csv": {},
}
TEXT = "f [Hz],G' [MPa],G'' [MPa]\n0.1,1,0.1\n1,1.5,0.3\n10,3,0.5\n100,4,0.4\n"
PIECES = (
    "",
    ",",
    ";",
    "\t",
    "nan",
    "inf",
    "-1",
    "1e400",
    "0",
    "abc",
    "\n",
    "#",
    '"',
    "[m]",
    "[kg]",
    "é",
    "\x00",
    "1e-320",
)


def mutant(text: str, rng: random.Random) -> str:
    lines = text.splitlines(keepends=True)
    for _ in range(rng.choice((1, 1, 2, 3))):
        n = rng.randrange(min(len(lines), 4)) if rng.random() < 0.6 else rng.randrange(len(lines))
        kind, line = rng.randrange(5), lines[n]
        if kind == 0:
            at = rng.randrange(len(line) + 1)
            lines[n] = line[:at] + rng.choice(PIECES) + line[at + rng.randrange(4) :]
        elif kind == 1:
            cells = line.rstrip("\n").split(",")
            cells[rng.randrange(len(cells))] = rng.choice(PIECES)
            lines[n] = ",".join(cells) + "\n"
        elif kind == 2:
            del lines[n]
        elif kind == 3:
            lines.insert(rng.randrange(len(lines) + 1), line)
        else:
            other = rng.randrange(len(lines))
            lines[n], lines[other] = lines[other], line
        lines = lines or [""]
    return "".join(lines)


@pytest.mark.parametrize("runs", [60, pytest.param(1000, marks=pytest.mark.slow)])
def test_damaged_files(runs: int, folder: Path) -> None:
    from restitution.contact.profiles import Parabola

    rng, refused = random.Random(5), 0
    for _ in range(runs):
        name = rng.choice(list(SEEDS))
        options = {key: Parabola(2.5e-6) if value is None else value for key, value in SEEDS[name].items()}
        file = folder / name
        text = TEXT if name == "moduli.csv" else (DATA / name).read_text()
        file.write_text(mutant(text, rng), encoding="utf-8")
        message = ""
        try:
            with warnings.catch_warnings():
                warnings.simplefilter("ignore", RestitutionWarning)
                observations = read_observations(file, **options)
        except InputError as error:
            message = str(error)
        else:
            assert observations.size >= 1
        if message:
            refused += 1
            assert message.startswith(str(file))
            assert "\n" not in message
    assert 0 < refused < runs
