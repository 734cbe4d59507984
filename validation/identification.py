"""Materials identified from synthetic rebounds, many times: are the stated errors right?

Each repetition draws noise of 1 % on e and contact time, fits the model, and counts how often the 95 % interval holds
the truth. The cases are those of steel balls on an incompressible solid with an equilibrium modulus of 1 MPa. In two
cases two of the 30 values of e are too small by 10 %.

Usage: python validation/identification.py [--repetitions 400] [--workers 2]
"""

import argparse
import math
import time
import warnings
from collections.abc import Mapping
from concurrent.futures import ProcessPoolExecutor
from dataclasses import replace
from pathlib import Path
from types import MappingProxyType
from typing import Any, NamedTuple

import numpy as np
import pandas as pd
from rich.progress import track

import restitution as rs

SHARE = "1 %"
SIZE = 0.01
STEEL = 7800.0
A = {"equilibrium_modulus": 1e6, "branch_modulus": 10e6, "viscosity": 10e6 * 1e-3}
B = {"equilibrium_modulus": 1e6, "branch_modulus": 10e6, "viscosity": 10e6 * 30e-6}
D = {"equilibrium_modulus": 1e6, "branch_modulus": 0.2e6, "viscosity": 0.2e6 * 1e-3}
TWO = {"equilibrium_modulus": 1e6, "branch_moduli": [5e6, 2e6], "relaxation_times": [1e-4, 5e-3]}
RADII = (0.002, 0.008, 0.03)
LAW = ("reference_temperature", "c1", "c2")


class Study(NamedTuple):
    """Truth, balls, and what is known."""

    model: Any
    truth: dict[str, Any]
    radii: tuple[float, ...]
    velocities: np.ndarray
    fixed: dict[str, float]
    temperatures: tuple[float, ...] = ()
    options: Mapping[str, Any] = MappingProxyType({})
    outliers: int = 0


STUDIES = {
    "1: A, three radii": Study(rs.standard_solid, A, RADII, np.geomspace(0.3, 3.0, 10), {"poisson_ratio": 0.5}),
    "2: B, one ball": Study(rs.standard_solid, B, (0.01,), np.geomspace(0.1, 10.0, 30), {"poisson_ratio": 0.5}),
    "3: two terms, three radii": Study(
        rs.generalised_maxwell, TWO, RADII, np.geomspace(0.3, 3.0, 14), {"poisson_ratio": 0.5}
    ),
    "4: A, three radii, K unknown": Study(
        rs.standard_solid, A | {"bulk_modulus": 2e7}, RADII, np.geomspace(0.3, 3.0, 10), {}
    ),
    "5: D, one ball": Study(rs.standard_solid, D, (0.01,), np.geomspace(0.1, 10.0, 30), {"poisson_ratio": 0.5}),
    "6: A, one ball, five temperatures, WLF unknown": Study(
        rs.standard_solid,
        A | {"c1": 8.0, "c2": 100.0},
        (0.01,),
        np.geomspace(0.3, 3.0, 6),
        {"poisson_ratio": 0.5, "reference_temperature": 300.0},
        (270.0, 285.0, 300.0, 320.0, 340.0),
        {"shift": rs.WLF},
    ),
    "7: A, three radii, two outliers, soft_l1": Study(
        rs.standard_solid, A, RADII, np.geomspace(0.3, 3.0, 10), {"poisson_ratio": 0.5}, (), {"loss": "soft_l1"}, 2
    ),
    "8: A, three radii, two outliers, cauchy": Study(
        rs.standard_solid, A, RADII, np.geomspace(0.3, 3.0, 10), {"poisson_ratio": 0.5}, (), {"loss": "cauchy"}, 2
    ),
}


def repetition(name: str, seed: int) -> list[dict[str, Any]]:
    """Rows of one fit: a parameter or a modulus each, with the error over its standard error and the interval."""
    warnings.simplefilter("ignore")
    study, random = STUDIES[name], np.random.default_rng([seed, 11])
    velocity, radius = np.tile(study.velocities, len(study.radii)), np.repeat(study.radii, study.velocities.size)
    mass = STEEL * 4.0 / 3.0 * math.pi * radius**3
    material = study.model(**{key: value for key, value in (study.truth | study.fixed).items() if key not in LAW})
    levels, temperature = [material], None
    if study.temperatures:
        law = rs.WLF(*((study.truth | study.fixed)[key] for key in LAW))
        levels = [replace(material, shift=law, temperature=law.reference_temperature).at(level)
                  for level in study.temperatures]  # fmt: skip
        temperature = np.repeat(study.temperatures, velocity.size)
        material = levels[study.temperatures.index(law.reference_temperature)]
    solved = [
        rs.solve(rs.Impact(level, rs.Parabola(radius), mass=mass, velocity=velocity), workers=1) for level in levels
    ]
    exact = [np.concatenate([getattr(level, key) for level in solved])
             for key in ("restitution_coefficient", "contact_time")]  # fmt: skip
    noisy = [value * (1.0 + SIZE * random.normal(size=value.size)) for value in exact]
    if study.outliers:
        noisy[0][random.choice(noisy[0].size, study.outliers, replace=False)] *= 0.9
    velocity, radius, mass = (np.tile(column, len(levels)) for column in (velocity, radius, mass))
    balls = rs.Rebounds(
        velocity, np.minimum(noisy[0], 1.0), radius=radius, mass=mass, contact_time=noisy[1],
        temperature=temperature, noise=rs.Noise(restitution_coefficient=SHARE, contact_time=SHARE),
    )  # fmt: skip
    begin = time.process_time()
    result = rs.identify(balls, study.model, fixed=study.fixed, profiles=False, **_terms(study), **study.options)
    fitted = time.process_time() - begin
    begin = time.process_time()
    intervals = result.interval()
    walked = time.process_time() - begin
    rows = []
    for key, estimate in result.parameters.items():
        truth = _truth(study, key)
        low, high = intervals[key]
        error = estimate.standard_error / estimate.value if estimate.determined else math.nan
        z = math.log(estimate.value / truth) / error if estimate.determined else math.nan
        rows.append({"name": key, "error": error, "z": z, "profile": low <= truth <= high})
    omega = math.pi / float(np.exp(np.mean(np.log(exact[1]))))
    truth = rs.reduced_modulus(material)
    expected = truth.storage_modulus(omega) + 1j * truth.loss_modulus(omega)
    moduli = result.moduli(omega)
    for key, value in (("absolute_modulus", abs(expected)), ("loss_modulus", expected.imag),
                       ("loss_tangent", expected.imag / expected.real)):  # fmt: skip
        low, middle, high = (float(moduli[f"{key}{end}"][0]) for end in ("_low", "", "_high"))
        error = math.log(high / low) / (2.0 * 1.959964)
        rows.append({"name": key, "error": error, "z": math.log(middle / value) / error, "profile": None})
    for row in rows:
        row |= {"case": name, "seed": seed, "chi2": result.reduced_chi2, "fit": fitted, "profiles": walked}
    return rows


def _terms(study: Study) -> dict[str, int]:
    moduli = study.truth.get("branch_moduli")
    return {} if moduli is None else {"terms": len(moduli)}


def _truth(study: Study, key: str) -> float:
    name, _, place = key.partition("[")
    value = study.truth[name]
    return float(value[int(place.rstrip("]"))] if place else value)


def table(rows: pd.DataFrame) -> list[str]:
    """Coverage, bias and scatter of each unknown."""
    lines = ["| case | unknown | stated error, % | scatter over it | mean z | covered, % | by the profile, % |",
             "|---|---|---|---|---|---|---|"]  # fmt: skip
    for (case, name), group in rows.groupby(["case", "name"], sort=False):
        good = group[np.isfinite(group.z)]
        covered = 100.0 * (good.z.abs() < 1.959964).mean()
        # The scatter of the estimates over the median of the stated errors.
        scatter = float((good.z * good.error).std() / good.error.median())
        profile = "" if group.profile.isna().all() else f"{100.0 * group.profile.astype(float).mean():.1f}"
        lines.append(f"| {case} | {name} | {100.0 * good.error.median():.2g} | {scatter:.2f} | {good.z.mean():+.2f} "
                     f"| {covered:.1f} | {profile} |")  # fmt: skip
    return lines


def main() -> None:
    """Repeat the fits and write the table."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--repetitions", type=int, default=400)
    parser.add_argument("--workers", type=int, default=2)
    options = parser.parse_args()
    tasks = [(name, seed) for seed in range(options.repetitions) for name in STUDIES]
    with ProcessPoolExecutor(options.workers) as pool:
        result = pool.map(repetition, *zip(*tasks, strict=True), chunksize=5)
        rows = pd.DataFrame([row for rows in track(result, "fits", total=len(tasks)) for row in rows])
    half = 196.0 * math.sqrt(0.95 * 0.05 / options.repetitions)
    times = rows.drop_duplicates(["case", "seed"]).groupby("case", sort=False)[["fit", "profiles", "chi2"]].median()
    head = f"{options.repetitions} repetitions. Noise of 1 % in e and contact time. A coverage of 95 % is known to "
    lines = [head + f"{half:.1f} %.", "", *table(rows), ""]
    lines += ["| case | median of chi2/dof | a fit, ms | profiles of all parameters, ms |", "|---|---|---|---|"]
    lines += [f"| {case} | {median.chi2:.2f} | {1e3 * median.fit:.0f} | {1e3 * median.profiles:.0f} |"
              for case, median in times.iterrows()]  # fmt: skip
    Path(__file__).with_suffix(".md").write_text("\n".join(lines) + "\n", encoding="utf-8")
    print("\n".join(lines))


if __name__ == "__main__":
    main()
