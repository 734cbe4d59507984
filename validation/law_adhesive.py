"""Contact law with adhesion in random impacts, beside the solver.

Usage: python validation/law_adhesive.py [--impacts 1000] [--seed 7]

Solids of one to three terms with Maugis' parameter from 0.14 to 4.5 at rest meet a wall at 0.6 to 20 times the
sticking velocity of JKR. `rs.solve` has e to 1e-3; the law has 60 elements and velocity Verlet with 200 steps in a
contact at least. The script counts captures, and compares e and the energies. The impact of the largest error is
repeated with more elements and steps, beside a solution to 1e-5. It takes some minutes.
"""

from __future__ import annotations

import argparse
import math
from pathlib import Path

import numba
import numpy as np
from rich.progress import track

import restitution as rs
from restitution.contact.adhesion import maugis_number
from restitution.kernel.contact_law import EDGE, step

ELEMENTS, STEPS, LONGEST, HELD = 60, 200, 60, 8000


@numba.njit
def thrown(law: np.ndarray, state: np.ndarray, dt: float, body: tuple[float, float, float], most: int) -> float:
    """Restitution, 0 of a body that has not left, NaN where the law ends; of a body: depth, velocity and mass."""
    depth, start, mass = body
    velocity, force = start, 0.0
    for _ in range(most):
        depth += velocity * dt - 0.5 * force / mass * dt * dt
        before = force
        force = step(law, state, depth, dt)
        if math.isnan(force):
            return math.nan
        velocity -= 0.5 * (before + force) / mass * dt
        if force == 0.0 and velocity < 0.0 and state[EDGE] == 0.0:
            return -velocity / start
    return 0.0


def random_impact(rng: np.random.Generator) -> rs.Impact:
    """Impact of a solid of one to three terms."""
    static, radius, work = np.exp(rng.uniform(np.log([1e7, 1e-6, 3e-3]), np.log([3e9, 1e-5, 0.1])))
    terms = int(rng.integers(1, 4))
    moduli, times = static * np.exp(rng.uniform(-2.0, 3.0, terms)), np.exp(rng.uniform(-20.0, -14.0, terms))
    material = rs.Material(rs.PronySeries(static / 2.7, moduli / 2.7, times), 3.0 * static)
    modulus = float(rs.reduced_modulus(material).equilibrium_modulus)
    stress = float(np.exp(rng.uniform(-2.0, 1.5)) / maugis_number(work, 1.0, modulus, radius))
    mass = 4e3 * radius**3
    sticks = math.sqrt(2.0 * 7.09 * (work**5 * radius**4 / modulus**2) ** (1.0 / 3.0) / mass)
    speed = sticks * math.exp(rng.uniform(-0.5, 3.0))
    return rs.Impact(material, rs.Parabola(radius), mass, speed, adhesion=rs.Adhesion(work, stress=stress))


def repeated(impact: rs.Impact) -> str:
    """Table of an impact with more elements and steps."""
    exact = rs.solve(impact, rtol=1e-5)
    e, duration = float(exact.restitution_coefficient), float(exact.contact_time)
    body = float(impact.velocity), float(impact.mass)
    rows = ["| elements | steps in a contact | e | error of $e^2$ |", "|---|---|---|---|"]
    for elements, steps in ((60, 200), (60, 800), (120, 200), (120, 800), (240, 800)):
        law = rs.contact_law(impact, elements=elements)
        state = law.start()
        depth = float(law.read(state).depth)
        result = thrown(law.constants, state, duration / steps, (depth, *body), LONGEST * steps)
        rows.append(f"| {elements} | {steps} | {result:.5f} | {result * result - e * e:.1e} |")
    times = ", ".join(f"{time / duration:.2g}" for time in np.ravel(impact.material.shear.relaxation_times))
    static, glass = (float(np.asarray(number)) for number in exact.maugis_numbers)
    return f"""\
The largest error belongs to an impact with $e = {e:.5f}$, relaxation times of {times} of the contact time, and
$\\lambda = {static:.2g}$ at rest and {glass:.2g} at once. More elements mend it, more steps do not:

{chr(10).join(rows)}
"""


def main(impacts: int, seed: int) -> str:
    """Return the page."""
    rng = np.random.default_rng(seed)
    errors, squares, above, gains = list[float](), list[float](), list[float](), list[float]()
    held, other, ended, worst = 0, 0, 0, None
    for _ in track(range(impacts), description="Impacts"):
        impact = random_impact(rng)
        exact, law = rs.solve(impact, rtol=1e-3), rs.contact_law(impact, elements=ELEMENTS)
        mass, speed, e = float(impact.mass), float(impact.velocity), float(exact.restitution_coefficient)
        # A tenth of the step at which the scheme of Verlet is no longer stable.
        stiffness = float(impact.reduced_modulus.instantaneous_modulus) * float(exact.max_contact_radius)
        dt = 0.2 * math.sqrt(mass / (2.0 * stiffness))
        if e > 0.0:
            dt = min(dt, float(exact.contact_time) / STEPS)
        state, most = law.start(), LONGEST * STEPS if e > 0.0 else HELD
        depth = float(law.read(state).depth)
        result = thrown(law.constants, state, dt, (depth, speed, mass), most)
        if math.isnan(result):
            ended += 1
        elif e == 0.0 or result == 0.0:
            held, other = held + (e == result), other + (e != result)
        else:
            now, kinetic = law.read(state), 0.5 * mass * speed * speed
            if not errors or abs(result - e) > max(errors):
                worst = impact
            errors.append(abs(result - e))
            squares.append(abs(result * result - e * e))
            above.append(result - e)
            gains.append((now.dissipated_energy + now.jump_energy) / kinetic - 1.0 + result * result)
    shares, energies = (
        ", ".join(f"{value:.1e}" for value in np.quantile(column, [0.5, 0.9, 0.99, 1.0]))
        for column in (errors, squares)
    )
    return f"""\
# Contact law with adhesion in random impacts

Made by `python validation/law_adhesive.py --impacts {impacts} --seed {seed}`; its docstring has how they are drawn.

| rebound | both stick | one of both sticks | the law ends |
|---|---|---|---|
| {len(errors)} | {held} | {other} | {ended} |

Errors of $e$: half, 90 %, 99 % and all are at most {shares}.
Those of $e^2$, the energy: {energies}.
What the material and the jumps took exceeds what the body lost by at most {max(gains):.1e} of its energy; no e is
above that of the solver by more than {max(above):.1e}.

{repeated(worst) if worst is not None else ""}"""


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--impacts", type=int, default=1000)
    parser.add_argument("--seed", type=int, default=7)
    parser.add_argument("--out", type=Path, default=Path(__file__).with_suffix(".md"))
    arguments = parser.parse_args()
    text = main(arguments.impacts, arguments.seed)
    arguments.out.write_text(text, encoding="utf-8")
    print(text)
