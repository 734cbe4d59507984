"""Damaged input through the command line: exit code, time and messages.

Seeds are case files, sweeps, tables, decks and a saved surrogate. Each mutant is a seed with a few random changes; it
runs in this process through the commands of `restitution`. A good end has the exit code 0, 2 or 3, with
at least one line `error:` for 2 and 3. Any other end is a fault and is printed with the text that repeats it, and so
is a run beyond the limit of time, a warning of NumPy, and a growth of the memory of the process beyond 2 GB.

    python validation/fuzz.py --runs 15000 --seed 1 --processes 3 --out validation/fuzz.md
"""

from __future__ import annotations

import argparse
import contextlib
import json
import os
import random
import re
import resource
import signal
import sys
import tempfile
import time
import warnings
from collections import Counter
from collections.abc import Generator
from concurrent.futures import ProcessPoolExecutor
from functools import cache
from multiprocessing import get_context
from pathlib import Path
from typing import NamedTuple

from typer import testing
from typer.testing import CliRunner

import restitution as rs
from restitution.cli.main import app
from restitution.surrogates.velocity import content_hash

# Typer would build all commands anew for each run, which takes longer than most of them.
testing._get_command = cache(testing._get_command)

EXAMPLES = Path(__file__).resolve().parents[1] / "examples"
LIMIT = 30
# Largest growth of the memory of the process in all runs [byte].
MEMORY = 2_000_000_000
SLOW = 2.0

_SWEEP = ("sweep", "--out", "o.zarr")
_BODY = '[body]\nradius = "10 mm"\nmass = "5 g"\n[impact]\nvelocity = "1 m/s"\n'
_SOLID = (
    '[material]\nequilibrium_modulus = "1 MPa"\nbranch_modulus = "10 MPa"\nviscosity = "1 kPa s"\n'
    "poisson_ratio = 0.45\n"
)
_LIQUID = (
    '[material]\nmodel = "burgers"\nmaxwell_modulus = "1 MPa"\nmaxwell_viscosity = "1 kPa s"\nkelvin_modulus = 1e6\n'
)
_PRONY = '[material]\nbulk_modulus = "1 GPa"\n[material.shear]\nequilibrium_modulus = "1 MPa"\n'
_FRACTIONAL = '[material]\nmodel = "fractional_zener"\nequilibrium_modulus = 1e6\nbranch_modulus = 1e7\n'


class Seed(NamedTuple):
    """A file and the command that reads it.

    A saved surrogate contains a hash. If it is `sealed`, mutants get the right hash. Otherwise an accepted mutant must
    print the `output` of the seed.
    """

    command: tuple[str, ...]
    name: str
    text: str
    sealed: bool = False
    output: str = ""


def seeds() -> list[Seed]:
    """Files that work as they are."""
    results = [
        Seed(("solve",), "a.toml", _BODY + _SOLID),
        Seed(("solve",), "a.toml", _BODY + _SOLID + '[profile]\ntype = "cone"\nhalf_angle = "80 deg"\n'),
        Seed(("solve",), "a.toml", _BODY + _SOLID + '[profile]\ntype = "power_law"\nexponent = 3\ncoefficient = '
        '1e4\n'),
        Seed(("solve",), "a.toml", _BODY + _SOLID + "[profile]\nr = [0, 1e-3, 2e-3, 1e-2]\nf = [0, 1e-4, 4e-4, "
        "1e-2]\n"),
        Seed(("solve",), "a.toml", _BODY + _SOLID + '[counter_body]\nradius = "5 mm"\ndensity = 1000\n'),
        Seed(("solve",), "a.toml", _BODY + _SOLID + '[counter_material]\nlibrary = "steel"\n'),
        Seed(("solve",), "a.toml", _BODY + _LIQUID + 'kelvin_viscosity = 1e3\nbulk_modulus = "1 GPa"\n'),
        Seed(("solve",), "a.toml", _BODY + _PRONY + 'branch_moduli = ["1 MPa", 1e6]\nrelaxation_times = [1e-3, '
        '1e-2]\n'),
        Seed(("solve",), "a.toml", _BODY + _FRACTIONAL + 'relaxation_time = "1 ms"\nexponent = 0.4\n'
        'bulk_modulus = inf\n'),
        Seed(("bounce",), "a.toml", _BODY.replace('velocity = "1 m/s"', 'drop_height = "1 m"') + _SOLID),
        Seed(("material",), "r.csv", "t [s],E [MPa]\n1e-3,10\n1e-2,5\n1e-1,3\n1,2\n10,1.5\n"),
        Seed(("material",), "d.csv", "f [Hz],G' [MPa],G'' [MPa]\n0.1,1,0.1\n1,1.5,0.3\n10,3,0.5\n100,4,0.4\n"
        "1000,5,0.2\n"),
        Seed(("material",), "s.csv", "T_C,log_aT\n0,1\n20,0\n40,-2\n"),
        Seed(("material",), "m.mac", "MP,EX,1,9e6\nMP,PRXY,1,.45\nTB,PRON,1,1,2,SHEA\nTBDATA,1,.2,1e-4,.3,1e-2\n"),
        Seed(("material",), "m.inp", "*ELASTIC, MODULI=INSTANTANEOUS\n 9, 0.5\n*VISCOELASTIC, TIME=PRONY\n 0.5, "
        "0, 2\n"),
        Seed(_SWEEP, "s.toml", _BODY + _SOLID + "[axes]\nvelocity = [0.1, 1.0]\nradius = [1e-3]\n"),
        Seed(
            _SWEEP, "s.toml", _BODY + _SOLID + "[samples]\nn = 3\nmass = {normal = [5e-3, 1e-4]}\n"
        ),
        Seed(_SWEEP, "s.toml", "[axes]\nnu = 0.45\np2 = [0.1]\np3 = {logarithmic = [1, 2], n = 2}\n"),
    ]  # fmt: skip
    folder = EXAMPLES / "identification"
    results += [
        Seed(("moduli",), "balls.csv", (folder / "balls.csv").read_text()),
        Seed(("design",), "design.toml", (folder / "design.toml").read_text()),
        # In the folder of the runs, where the cases of the tables are.
        *(Seed(("identify",), f"{name}.toml", (folder / f"{name}.toml").read_text()) for name in ("balls", "sound")),
    ]
    commands = {"indent": "indent", "dropped": "bounce"}
    for file in sorted(EXAMPLES.glob("*.toml")):
        text = file.read_text()
        kind = next((command for word, command in commands.items() if word in file.name), "solve")
        command = _SWEEP if "[axes]" in text else (kind,)
        results.append(Seed(command, file.name, text.replace("n = 40", "n = 3")))
    return results + saved_surrogates()


def saved_surrogates() -> list[Seed]:
    """Two seeds of one saved surrogate; the second is sealed."""
    solid = rs.standard_solid(1e6, 1e7, 1e3, poisson_ratio=0.45)
    ball = rs.Impact(solid, rs.Parabola(0.01), mass=0.005, velocity=1.0)
    command = ("surrogate", "--at", "0.7", "--json")
    with tempfile.TemporaryDirectory() as folder:
        file = rs.surrogate(ball, (0.5, 1.0), 1e-3).save(Path(folder, "a.json"))
        output, text = CliRunner().invoke(app, [command[0], str(file), *command[1:]]).stdout, file.read_text()
    return [Seed(command, "a.json", text, output=output), Seed(command, "b.json", text, sealed=True)]


def sealed(text: str) -> str:
    """Text of a saved surrogate with the hash of its content; as it is if it is no JSON object."""
    try:
        content = json.loads(text)
        content["sha256"] = content_hash({key: value for key, value in content.items() if key != "sha256"})
    except (ValueError, TypeError, AttributeError, RecursionError):
        return text
    return json.dumps(content, indent=1)


_VALUES = (
    "0", "-1", "1e308", "1e-308", "1e-320", "nan", "inf", "-inf", "1e400", "9" * 400, "true", '""', '"1 m"',
    '"1e30 ms"', '"abc"', "[]", "{}", "[[1]]", '"' + "1" * 300 + '"', "1979-05-27", "1e103", "1e-150", "0.5", '"1 kg"',
    '"-5 %"', '"steel"', '"20 degC"', "1e20", "[1, 2, 3]", '"[1, 2] s"', "2", "1000000000", '"1 m^9^9"', "'\\u0000'",
)  # fmt: skip
_PIECES = (
    "[body]\n",
    "[material]\n",
    "[axes]\n",
    "=",
    "\n",
    '"',
    "[",
    "]",
    "{",
    ",",
    ";",
    "\t",
    "é",
    "\x00",
    "#",
    ".",
)


def mutant(seed: Seed, rng: random.Random) -> str:
    """A seed with one to three random changes."""
    text = seed.text
    for _ in range(rng.choice((1, 1, 1, 2, 3))):
        kind = rng.randrange(6)
        lines = text.splitlines(keepends=True) or ["\n"]
        n = rng.randrange(len(lines))
        places = [match.span() for match in re.finditer(r'"[^"\n]*"|-?\d[\d.]*(?:[eE][+-]?\d+)?', text)]
        if kind in (0, 1) and places:
            start, end = rng.choice(places)
            text = text[:start] + rng.choice(_VALUES) + text[end:]
        elif kind == 2:
            del lines[n]
            text = "".join(lines)
        elif kind == 3:
            lines.insert(rng.randrange(len(lines) + 1), lines[n])
            text = "".join(lines)
        elif kind == 4:
            at = rng.randrange(len(text) + 1)
            text = text[:at] + rng.choice(_PIECES) + text[at:]
        else:
            at = rng.randrange(len(text) + 1)
            text = text[:at] + text[at + rng.randint(1, 8) :]
    return sealed(text) if seed.sealed else text


class End(NamedTuple):
    """How a command ended."""

    code: int
    seconds: float
    fault: str


class _TimeUp(BaseException):
    """The limit is over. It is no error that a command could take for one of its own."""


@contextlib.contextmanager
def _limit(seconds: int) -> Generator[None]:
    def stop(*_: object) -> None:
        raise _TimeUp

    before = signal.signal(signal.SIGALRM, stop)
    signal.alarm(seconds)
    try:
        yield
    finally:
        signal.alarm(0)
        signal.signal(signal.SIGALRM, before)


def run(seed: Seed, text: str, limit: int = LIMIT) -> End:
    """Run a command on a text; the current folder is used for its files."""
    Path(seed.name).write_text(text, encoding="utf-8", errors="surrogatepass")
    start = time.perf_counter()
    command, *options = seed.command
    try:
        with _limit(limit):
            answer = CliRunner().invoke(app, [command, seed.name, *options])
        if isinstance(answer.exception, _TimeUp):
            raise answer.exception
    except _TimeUp:
        return End(-1, time.perf_counter() - start, f"no end within {LIMIT} s")
    seconds, code = time.perf_counter() - start, answer.exit_code
    fault = ""
    if answer.exception is not None and not isinstance(answer.exception, SystemExit):
        fault = f"traceback: {answer.exception!r}"
    elif code not in (0, 2, 3):
        fault = f"exit code {code}: {answer.stderr.strip()}"
    elif code and not answer.stderr.startswith("error: ") and "error: " not in answer.stderr:
        fault = "no line of error"
    elif not code and seed.output and answer.stdout != seed.output:
        fault = "another surrogate than the seed"
    elif "Traceback" in answer.stderr:
        fault = "traceback on standard error"
    elif "encountered in" in answer.stderr:
        line = next(line for line in answer.stderr.splitlines() if "encountered in" in line)
        fault = f"a warning of numpy: {line.rpartition('/src/')[2]}"
    return End(code, seconds, fault[:300])


def _peak() -> int:
    """Largest memory of this process so far [byte]."""
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss * (1 if sys.platform == "darwin" else 1024)


def fuzz(runs: int, seed: int) -> tuple[Counter[tuple[str, int]], list[tuple[Seed, str, End]], float]:
    """Counts of ends by command, the faults, and the longest time [s] of a refusal."""
    rng = random.Random(seed)
    counts: Counter[tuple[str, int]] = Counter()
    faults: list[tuple[Seed, str, End]] = []
    longest, files = 0.0, seeds()
    home = Path.cwd()
    with tempfile.TemporaryDirectory() as folder:
        for file in (*EXAMPLES.glob("*.csv"), *EXAMPLES.glob("identification/*.csv")):
            Path(folder, file.name).write_bytes(file.read_bytes())
        os.chdir(folder)
        try:
            # The kernel may have to be compiled, which the limit does not allow for.
            for command in ("solve", "indent", "bounce"):
                chosen = next(seed for seed in files if seed.command[0] == command)
                if run(chosen, chosen.text, 600).code:
                    raise RuntimeError(f"the seed {chosen.name} of {command} does not work")
            start = _peak()
            for _ in range(runs):
                chosen = rng.choice(files)
                text = mutant(chosen, rng)
                end = run(chosen, text)
                if _peak() - start > MEMORY and not end.fault:
                    end, start = end._replace(fault=f"memory: {(_peak() - start) / 1e9:.1f} GB more"), _peak()
                counts[chosen.command[0], end.code] += 1
                if end.code == 2:
                    longest = max(longest, end.seconds)
                if end.fault:
                    faults.append((chosen, text, end))
        finally:
            os.chdir(home)
    return counts, faults, longest


def _shared(
    runs: int, seed: int, processes: int
) -> tuple[Counter[tuple[str, int]], list[tuple[Seed, str, End]], float]:
    """The same over several processes, which have consecutive seeds."""
    shares = [runs // processes + (n < runs % processes) for n in range(processes)]
    with ProcessPoolExecutor(processes, get_context("spawn"), warnings.simplefilter, ("always",)) as pool:
        counts, faults, longest = zip(*pool.map(fuzz, shares, range(seed, seed + processes)), strict=True)
    return sum(counts, Counter()), [fault for some in faults for fault in some], max(longest)


def main() -> None:
    """Run and write the table."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--runs", type=int, default=1000)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--processes", type=int, default=1)
    parser.add_argument("--out", type=Path, default=Path(__file__).with_suffix(".md"))
    options = parser.parse_args()
    counts, faults, longest = _shared(options.runs, options.seed, options.processes)
    commands = sorted({command for command, _ in counts})
    codes = sorted({code for _, code in counts})
    lines = [
        "| command | " + " | ".join(f"exit {code}" for code in codes) + " |",
        "|---" * (len(codes) + 1) + "|",
    ]
    lines += [f"| {c} | " + " | ".join(str(counts[c, code]) for code in codes) + " |" for c in commands]
    lines += ["", f"{len(faults)} faults. The longest refusal (exit 2) took {longest:.1f} s."]
    for (chosen, text, end), times in _distinct(faults):
        lines += ["", f"{times} x `{chosen.command[0]} {chosen.name}`: {end.fault}"]
        print(f"{chosen.command[0]} {chosen.name}: {end.fault}\n{text}")
    head = [
        f"Made by `python validation/fuzz.py --runs {options.runs} --seed {options.seed} "
        f"--processes {options.processes}`:",
        f"{options.runs} random mutants of {len(seeds())} files, each run through the command line, at most {LIMIT} s",
        f"each, and at most {MEMORY // 1_000_000_000} GB more memory of a process. Exit code 0: done, 2: refused in",
        "one line or more, 3: the solver failed, 70: a mistake in the program, -1: stopped by the limit.",
        "",
    ]
    options.out.write_text("\n".join([*head, *lines]) + "\n", encoding="utf-8")
    sys.exit(1 if faults else 0)


def _distinct(faults: list[tuple[Seed, str, End]]) -> list[tuple[tuple[Seed, str, End], int]]:
    by_kind: dict[str, list[tuple[Seed, str, End]]] = {}
    for fault in faults:
        by_kind.setdefault(re.sub(r"[\d.e+-]+", "#", fault[2].fault)[:80], []).append(fault)
    return [(group[0], len(group)) for group in by_kind.values()]


if __name__ == "__main__":
    main()
