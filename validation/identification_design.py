"""Standard errors of designs of experiments for six materials: velocities alone against several radii.

Run as `python validation/identification_design.py`; prints a table and writes it to `identification_design.md` beside
this file. Takes half a minute.
"""

from __future__ import annotations

from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

import restitution as rs

TEXT = """\
## Designs of experiments

`validation/identification_design.py` makes this table: the largest standard error of a parameter, in per cent, of 20
impacts of steel balls whose restitution coefficient and contact time are measured to 1 %. The parameters are
$G_\\infty$, the branch moduli and the relaxation times. Without a design the velocities are evenly spaced in their
logarithm, from 0.316 to 3.16 m/s (one decade) or from 0.03 to 10 m/s, with balls of 10 mm, or of 3, 10 and 30 mm. The
E-optimal designs choose from 12 velocities from 0.03 to 10 m/s, and from the radii in mm. "Wrong guess" is the design
for a material whose parameters are three times as large, evaluated for the true one. The materials are incompressible
solids with $G_\\infty = 1$ MPa:

* A, B, C: $G_1 = 10$ MPa with $\\tau = 1$ ms, 30 µs, 30 ms; D: 0.2 MPa with 1 ms.
* A, K free: material A with an unknown bulk modulus of {bulk:.3g} MPa.
* two terms: 5 MPa with 0.1 ms and 2 MPa with 5 ms.

{table}
"""

STEEL = 7800.0
VELOCITIES = np.geomspace(0.03, 10.0, 12)
ONE_DECADE = (0.316, 3.16)
BULK = 8.2e6
Array = NDArray[np.float64]


def solid(equilibrium: float, branch: float, time: float) -> rs.Material:
    return rs.standard_solid(equilibrium, branch, branch * time, poisson_ratio=0.5)


def compressible(equilibrium: float, branch: float, time: float, bulk: float) -> rs.Material:
    return rs.standard_solid(equilibrium, branch, branch * time, bulk_modulus=bulk)


def two_terms(equilibrium: float, first: float, time: float, second: float, longer: float) -> rs.Material:
    return rs.generalised_maxwell(equilibrium, [first, second], [time, longer], poisson_ratio=0.5)


CASES: dict[str, partial[Any]] = {
    "A": partial(solid, 1e6, 1e7, 1e-3),
    "B": partial(solid, 1e6, 1e7, 3e-5),
    "C": partial(solid, 1e6, 1e7, 3e-2),
    "D": partial(solid, 1e6, 2e5, 1e-3),
    "A, K free": partial(compressible, 1e6, 1e7, 1e-3, BULK),
    "two terms": partial(two_terms, 1e6, 5e6, 1e-4, 2e6, 5e-3),
}


def largest_error(model: partial[Any], velocity: Array, radius: Array) -> float:
    """Largest standard error of a parameter from given impacts, from derivatives of the exact solver."""
    guess = np.array(model.args)
    mass = STEEL * 4.0 / 3.0 * np.pi * radius**3

    def logs(factors: Array) -> Array:
        impact = rs.Impact(model.func(*(guess * factors)), rs.Parabola(radius), mass, velocity)
        result = rs.solve(impact, rtol=1e-11)
        return np.log(np.concatenate([result.restitution_coefficient, result.contact_time])) / 0.01

    step, unit = 1e-3, np.eye(guess.size)
    slopes = [(logs(np.exp(step * direction)) - logs(np.exp(-step * direction))) / (2.0 * step) for direction in unit]
    jacobian = np.stack(slopes, axis=1)
    return float(np.sqrt(np.diag(np.linalg.inv(jacobian.T @ jacobian))).max())


def evenly(model: partial[Any], low: float, high: float, radii: list[float]) -> float:
    """Largest error of 20 impacts at even velocities with each ball in turn."""
    count = len(radii)
    velocity = np.geomspace(low, high, 20 // count)
    error = largest_error(model, np.tile(velocity, count), np.repeat(radii, velocity.size))
    return error * (velocity.size * count / 20.0) ** 0.5


def designed(model: partial[Any], radii: list[float], wrong: float = 1.0) -> float:
    """Largest error of the E-optimal 20 impacts, chosen for a guess that is wrong by a factor."""
    guess = partial(model.func, *(wrong * value for value in model.args))
    candidates = {"velocity": VELOCITIES, "radius": radii, "density": STEEL}
    result = rs.design(guess, candidates, fixed=())
    return largest_error(model, np.repeat(result.velocity, result.repeats), np.repeat(result.radius, result.repeats))


def main() -> None:
    """Print the table and write it beside this file."""
    heads = (
        "1 ball, 1 decade", "1 ball, 2.5 decades", "E-optimal, 10", "3 balls, 1 decade", "E-optimal, 3 to 30",
        "wrong guess", "E-optimal, 1 to 100",
    )  # fmt: skip
    lines = [f"| material | {' | '.join(heads)} |", "|---" * 8 + "|"]
    three, five = [0.003, 0.01, 0.03], [0.001, 0.003, 0.01, 0.03, 0.1]
    for name, model in CASES.items():
        row = (
            evenly(model, *ONE_DECADE, [0.01]), evenly(model, 0.03, 10.0, [0.01]), designed(model, [0.01]),
            evenly(model, *ONE_DECADE, three), designed(model, three), designed(model, three, 3.0),
            designed(model, five),
        )  # fmt: skip
        # Two digits, without an exponent.
        cells = [f"{float(format(100.0 * error, '.2g')):g}" for error in row]
        lines.append(f"| {name} | {' | '.join(cells)} |")
        print(lines[-1], flush=True)
    text = TEXT.format(table="\n".join(lines), bulk=BULK / 1e6)
    Path(__file__).with_suffix(".md").write_text(text, encoding="utf-8")


if __name__ == "__main__":
    main()
