"""Bits of random impacts, alone and among others, and damaged stores.

Each impact of an array is solved alone, in a list, in a shorter array, in another order and on 1 or 3 threads; all
outputs must have the same bits. Then files of a store are damaged or exchanged; a reader must refuse the store or
read the same numbers, and the same sweep must restore every byte. Sweeps are killed at random moments; the same
sweep must end with the same bytes. Bits of saved surrogates are flipped; a surrogate must be refused or be the same.

Usage: python validation/bits.py [--size 20] [--stores 40] [--kills 40] [--flips 3000] [--seed 0] [--out FILE]
"""

import argparse
import random
import shutil
import signal
import subprocess
import sys
import tempfile
import time
import warnings
from collections import Counter
from pathlib import Path
from typing import Any

import numpy as np
from rich.progress import track

import restitution as rs
from restitution.errors import InputError, RestitutionWarning

NAMES = (
    "status",
    "restitution_coefficient",
    "contact_time",
    "max_indentation_depth",
    "max_force",
    "max_contact_radius",
)
ROWS = 30
SWEEP = """
import sys
import restitution as rs
ball = rs.Impact(rs.standard_solid(1e6, 1e7, 1e3, poisson_ratio=0.45), rs.Parabola(0.01), 0.005, 1.0)
axes = {"velocity": rs.Logarithmic(0.01, 0.1, 400), "mass": rs.Logarithmic(0.001, 0.01, 250)}
print("begins", flush=True)
rs.sweep(ball, axes, ["restitution_coefficient", "contact_time"], out=sys.argv[1], chunk=500)
"""


def draw_impacts(rng: np.random.Generator) -> dict[str, dict[str, Any]]:
    """Arguments of impacts but for the material and the velocity, by kind."""
    size = 10.0 ** rng.uniform(-3.0, -1.0)
    r = size * np.append(0.0, np.cumsum(rng.uniform(0.5, 1.0, 30))) / 20.0
    tip = rs.Tabulated(r, r**2 / (2.0 * size) * (1.0 + 2e-3 * np.sin(30.0 * r / size)))
    ball = rs.Parabola(size)
    shapes: dict[str, Any] = {
        "parabola": ball,
        "cone": rs.Cone(rng.uniform(1.0, 1.5)),
        "power law": rs.PowerLaw(rng.uniform(1.0, 3.0), 10.0),
        "flat punch": rs.FlatPunch(0.1 * size),
        "sphere": rs.Sphere(size),
        "truncated cone": rs.TruncatedCone(0.05 * size, rng.uniform(1.0, 1.5)),
        "flat-ended parabola": rs.FlatEndedParabola(size, size * rng.uniform(0.001, 0.1)),
        "table": tip,
        "layer": rs.Layer(ball, size * rng.uniform(0.2, 1.0)),
        "layer under a sphere": rs.Layer(rs.Sphere(size), size * rng.uniform(0.2, 1.0)),
        "ellipsoid": rs.Ellipsoid(size, size * rng.uniform(1.1, 5.0)),
        "pyramid": rs.Pyramid(rng.uniform(1.0, 1.4)),
    }
    mass = 1e4 * size**3
    options = {name: {"profile": shape, "mass": mass} for name, shape in shapes.items()}
    options["weight"] = {"profile": rs.Sphere(size), "mass": mass, "external_force": 9.81 * mass}
    impedance = 10.0 ** rng.uniform(0.0, 4.0) * mass
    options["impedance"] = {"profile": rs.Sphere(size), "mass": mass, "impedance": impedance}
    return options


def columns(arguments: dict[str, Any], material: rs.Material, velocity: Any, workers: int | None = None) -> np.ndarray:
    """Outputs of an impact, one row each."""
    if isinstance(velocity, list):
        result = rs.solve([rs.Impact(material, velocity=v, **arguments) for v in velocity], workers=workers)
    else:
        result = rs.solve(rs.Impact(material, velocity=velocity, **arguments), workers=workers)
    return np.array([getattr(result, name) for name in NAMES], dtype=float).reshape(len(NAMES), -1)


def compared(seed: int, number: int) -> tuple[Counter[str], Counter[str]]:
    """Count the impacts of each kind that were compared, and those whose bits differ."""
    rng = np.random.default_rng([seed, number])
    shear = rs.PronySeries(1e6, 10.0 ** rng.uniform(5.0, 7.5, 2), 10.0 ** rng.uniform(-6.0, 0.0, 2))
    material = rs.Material(shear, np.inf)
    tried, differ = Counter[str](), Counter[str]()
    for kind, arguments in draw_impacts(rng).items():
        v = 10.0 ** rng.uniform(-3.0, -0.5, ROWS)
        whole, order = columns(arguments, material, v), rng.permutation(ROWS)
        first, last = np.sort(rng.choice(ROWS, 2, replace=False))
        few = rng.choice(ROWS, 5, replace=False)
        others = [
            (few, np.hstack([columns(arguments, material, float(v[n])) for n in few])),
            (few, columns(arguments, material, v[few].tolist())),
            (np.arange(first, last), columns(arguments, material, v[first:last])),
            (order, columns(arguments, material, v[order], 1)),
            (order, columns(arguments, material, v[order], 3)),
        ]
        for rows, result in others:
            wrong = result.view(np.int64) != np.ascontiguousarray(whole[:, rows]).view(np.int64)
            tried[kind] += len(rows)
            differ[kind] += int(np.count_nonzero(wrong.any(axis=0)))
    return tried, differ


def tree(folder: Path) -> dict[str, bytes]:
    """Contents of all files."""
    return {str(path.relative_to(folder)): path.read_bytes() for path in folder.rglob("*") if path.is_file()}


def damaged(seed: int, count: int) -> Counter[tuple[str, str]]:
    """Count the damages by kind and by what happened."""
    rng, ends = random.Random(seed), Counter[tuple[str, str]]()
    ball = rs.Impact(rs.standard_solid(1e6, 1e7, 1e3, poisson_ratio=0.45), rs.Parabola(0.01), 0.005, 1.0)
    axes = {"velocity": rs.Logarithmic(0.01, 0.1, 5), "mass": rs.Logarithmic(0.001, 0.01, 7)}

    def run(out: Path) -> Any:
        return rs.sweep(ball, axes, ["restitution_coefficient", "contact_time"], out=out, chunk=4)

    with tempfile.TemporaryDirectory() as folder:
        store, out = Path(folder) / "made.zarr", Path(folder) / "out.zarr"
        run(store)
        intact, contents = rs.open_sweep(store).load(), tree(store)
        files = [name for name in sorted(contents) if "/c/" in name or name.startswith("validity/")]
        for kind in track(["flip", "truncate", "remove", "exchange"] * count, "stores"):
            shutil.copytree(store, out)
            name = rng.choice(files)
            content = bytearray(contents[name])
            if kind == "flip":
                content[rng.randrange(len(content))] ^= 1 << rng.randrange(8)
            elif kind == "truncate":
                del content[rng.randrange(len(content)) :]
            elif kind == "exchange":
                content = bytearray(
                    contents[rng.choice([other for other in files if contents[other] != contents[name]])]
                )
            (out / name).unlink() if kind == "remove" else (out / name).write_bytes(content)
            try:
                with warnings.catch_warnings(record=True) as caught:
                    warnings.simplefilter("always")
                    same = rs.open_sweep(out).load().identical(intact)
                ends[kind, "same numbers" if same else "a warning" if caught else "silent"] += 1
            except InputError:
                ends[kind, "refused"] += 1
            run(out)
            ends[kind, "repaired" if tree(out) == contents else "not repaired"] += 1
            shutil.rmtree(out)
    return ends


def killed(seed: int, count: int) -> Counter[tuple[str, str]]:
    """Count the sweeps that were killed in the middle, and whether the same sweep ended with the same bytes."""
    rng, ends = random.Random(seed), Counter[tuple[str, str]]()
    with tempfile.TemporaryDirectory() as folder:
        store, out = Path(folder) / "made.zarr", Path(folder) / "out.zarr"

        def start(out: Path) -> subprocess.Popen[str]:
            process = subprocess.Popen(
                [sys.executable, "-c", SWEEP, str(out)], stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True
            )
            assert process.stdout
            process.stdout.readline()
            return process

        process, begin = start(store), time.monotonic()
        process.wait()
        duration, contents = time.monotonic() - begin, tree(store)
        for kind in track(["kill -9", "Ctrl-C"] * (count // 2), "kills"):
            process = start(out)
            time.sleep(rng.uniform(0.0, 0.9 * duration))
            process.send_signal(signal.SIGKILL if kind == "kill -9" else signal.SIGINT)
            process.wait()
            early = process.returncode != 0
            process = start(out)
            process.wait()
            words = "the same bytes" if tree(out) == contents else "other bytes"
            ends[kind, words + ("" if early else ", after its end")] += 1
            shutil.rmtree(out)
    return ends


def flipped(seed: int, count: int) -> Counter[tuple[str, str]]:
    """Count the flipped bits of a saved surrogate by what happened."""
    rng, ends = random.Random(seed), Counter[tuple[str, str]]()
    ball = rs.Impact(rs.standard_solid(1e6, 1e7, 1e3, poisson_ratio=0.45), rs.Parabola(0.01), 0.005, 1.0)
    surrogate = rs.surrogate(ball, (0.01, 1.0))
    sample = surrogate.sample(100)
    with tempfile.TemporaryDirectory() as folder:
        path = surrogate.save(Path(folder) / "surrogate.json")
        content = path.read_bytes()
        for _ in track(range(count), "flips"):
            changed = bytearray(content)
            changed[rng.randrange(len(changed))] ^= 1 << rng.randrange(8)
            path.write_bytes(changed)
            try:
                result = rs.Surrogate.load(path)
                same = result.sample(100).identical(sample) and result.velocity == surrogate.velocity
                ends["flip in a surrogate", "same numbers" if same else "silent"] += 1
            except InputError:
                ends["flip in a surrogate", "refused"] += 1
    return ends


def main() -> None:
    """Write a table of the bits and one of the damages."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--size", type=int, default=20, help="draws of all kinds of impacts")
    parser.add_argument("--stores", type=int, default=40, help="damages of each kind")
    parser.add_argument("--kills", type=int, default=40, help="sweeps that are interrupted")
    parser.add_argument("--flips", type=int, default=3000, help="flipped bits of a surrogate")
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--out", type=Path, default=Path(__file__).with_suffix(".md"))
    options = parser.parse_args()
    warnings.simplefilter("ignore", RestitutionWarning)
    tried, differ = Counter[str](), Counter[str]()
    for number in track(range(options.size), "bits"):
        for total, result in zip((tried, differ), compared(options.seed, number), strict=True):
            total.update(result)
    lines = [f"Seed {options.seed}, {options.size} draws.", "", "| kind | compared | bits differ |", "|---|---|---|"]
    lines += [f"| {kind} | {tried[kind]:,} | {differ[kind]:,} |" for kind in tried]
    ends = (
        damaged(options.seed, options.stores)
        + killed(options.seed, options.kills)
        + flipped(options.seed, options.flips)
    )
    lines += ["", "| damage | what happened | count |", "|---|---|---|"]
    lines += [f"| {kind} | {end} | {n} |" for (kind, end), n in sorted(ends.items())]
    options.out.write_text("\n".join(lines) + "\n", encoding="utf-8")


if __name__ == "__main__":
    main()
