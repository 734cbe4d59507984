"""Laws for other codes, run by these codes, against the promise and the exact e.

Install the codes beside this package with `pip install -r .ci/codes.txt`, and LIGGGHTS and YADE from the distribution.
The environment variable MERCURYDPM names the folder of MercuryDPM, which is built in its folder `build`. Run as
`python validation/codes.py`; prints tables and writes them to `codes.md` beside this file. Takes two minutes. A code
that is absent is left out. `python validation/codes.py MercuryDPM YADE` runs these codes alone, and leaves the other
tables as they are in the file. `tests/codes` runs the fast parts.
"""

from __future__ import annotations

import ctypes
import json
import math
import os
import re
import shutil
import subprocess
import sys
import tempfile
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np

import restitution as rs

sys.path.append(str(Path(__file__).resolve().parent))
import lammps_engine
from pages import table


def by_lammps(snippet: str, units: str, radius: float, mass: float, velocity: float, step: float, wall: bool) -> float:
    """Coefficient of restitution of two equal balls, or of a ball and a wall at z = 0, with a snippet as it is.

    All numbers are in the unit system of the snippet; `velocity` is the relative one.
    """
    places, speeds = ([radius], [-velocity]) if wall else ([-radius, radius], [0.5 * velocity, -0.5 * velocity])
    along = np.array([0.0, 0.0, 1.0])
    engine = lammps_engine.balls(
        np.outer(places, along), np.outer(speeds, along), radius, mass,
        (lammps_engine.NO_PAIRS if wall else "") + snippet, step, (-4.0 * radius, 4.0 * radius), units,
    )  # fmt: skip

    def heights(name: str) -> Any:
        return lammps_engine.column(engine, name, 2, len(places))

    def is_over() -> bool:
        z = heights("x")
        return bool(z[0] > radius if wall else z[1] - z[0] > 2.0 * radius)

    lammps_engine.run_until(engine, is_over, 200_000)
    rebounds = heights("v")
    rebound = float(rebounds[0] if wall else rebounds[1] - rebounds[0])
    engine.close()
    return rebound / velocity


def by_mujoco(snippet: str, radius: float, mass: float, velocity: float, step: float) -> tuple[float, float]:
    """Coefficient of restitution and contact time [s] of a ball on a floor without weight, with a snippet as it is."""
    import mujoco

    model = mujoco.MjModel.from_xml_string(f"""
        <mujoco>
          <option timestep="{step!r}" gravity="0 0 0"/>
          <worldbody>
            <geom name="other" type="plane" size="1 1 1"/>
            <body pos="0 0 {radius!r}">
              <joint name="up" type="slide" axis="0 0 1"/>
              <geom name="ball" type="sphere" size="{radius!r}" mass="{mass!r}"/>
            </body>
          </worldbody>
          <contact>{snippet}</contact>
        </mujoco>
    """)
    data = mujoco.MjData(model)
    data.qvel[0] = -velocity
    loaded = 0
    for _ in range(1_000_000):
        mujoco.mj_step(model, data)
        loaded += bool(data.qfrc_constraint[0] > 0.0)
        if data.qvel[0] > 0.0 and data.ncon == 0:
            return float(data.qvel[0] / velocity), loaded * step
    raise RuntimeError("the ball stays on the floor")


def by_drake(snippet: str, radius: float, mass: float, velocity: float, step: float, end: float) -> float:
    """Coefficient of restitution of a ball on a floor without weight, with the properties of a snippet."""
    from pydrake.geometry import Box, ProximityProperties, Sphere
    from pydrake.math import RigidTransform
    from pydrake.multibody import math as motion
    from pydrake.multibody import plant as plants
    from pydrake.multibody.tree import SpatialInertia
    from pydrake.systems.analysis import Simulator
    from pydrake.systems.framework import DiagramBuilder

    builder = DiagramBuilder()
    plant, _ = plants.AddMultibodyPlantSceneGraph(builder, step)
    typed = dict(re.findall(r'<drake:(\w+) value="([^"]+)"', snippet))
    kind = plants.DiscreteContactApproximation
    plant.set_discrete_contact_approximation(kind.kSap if "relaxation_time" in typed else kind.kLagged)
    plant.set_contact_model(plants.ContactModel.kPoint)
    plant.mutable_gravity_field().set_gravity_vector([0.0, 0.0, 0.0])
    properties = ProximityProperties()
    for name, value in typed.items():
        properties.AddProperty("material", name, float(value))
    properties.AddProperty("material", "coulomb_friction", plants.CoulombFriction(0.0, 0.0))
    floor = RigidTransform([0.0, 0.0, -1.0])
    plant.RegisterCollisionGeometry(plant.world_body(), floor, Box(4.0, 4.0, 2.0), "floor", properties)
    ball = plant.AddRigidBody("ball", SpatialInertia.SolidSphereWithMass(mass, radius))
    plant.RegisterCollisionGeometry(ball, RigidTransform(), Sphere(radius), "ball", properties)
    plant.Finalize()
    simulator = Simulator(builder.Build())
    context = plant.GetMyMutableContextFromRoot(simulator.get_mutable_context())
    plant.SetFreeBodyPose(context, ball, RigidTransform([0.0, 0.0, radius]))
    falling = motion.SpatialVelocity([0.0, 0.0, 0.0], [0.0, 0.0, -velocity])
    plant.SetFreeBodySpatialVelocity(context=context, body=ball, V_JpJc=falling)
    simulator.AdvanceTo(end)
    return float(plant.EvalBodySpatialVelocityInWorld(context, ball).translational()[2] / velocity)


def by_rebound(coefficient: Any, radius: float, velocity: float) -> float:
    """Coefficient of restitution of two hard spheres with e(v), a Python function or the address of a compiled one."""
    import rebound

    sim = rebound.Simulation()
    sim.integrator, sim.gravity = "leapfrog", "none"
    sim.collision, sim.collision_resolve = "direct", "hardsphere"
    sim.coefficient_of_restitution = coefficient
    for side in (-1.0, 1.0):
        sim.add(m=1.0, r=radius, x=1.01 * side * radius, vx=-0.5 * side * velocity)
    sim.dt = 1e-2 * radius / velocity
    sim.integrate(0.5 * radius / velocity)
    return float((sim.particles[1].vx - sim.particles[0].vx) / velocity)


def by_rebound_with_memory(law: Any, radius: float, mass: float, velocity: float, step: float) -> float:
    """Coefficient of restitution of two equal balls under a `ContactLaw`, as additional force."""
    import numba
    import rebound

    sim = rebound.Simulation()
    sim.integrator, sim.gravity = "leapfrog", "none"
    for side in (-1.0, 1.0):
        sim.add(m=mass, r=radius, x=(1.0 + 1e-9) * side * radius, vx=-0.5 * side * velocity)
    particles = np.lib.stride_tricks.as_strided(
        np.ctypeslib.as_array(ctypes.cast(sim._particles, ctypes.POINTER(ctypes.c_double)), (2,)),
        # x, y, z, vx, vy, vz, ax, ay, az are the first numbers of a particle.
        (2, 9),
        (ctypes.sizeof(rebound.Particle), 8),
    )
    contact, state = law.compiled, law.start(depth=-2e-9 * radius)

    @numba.njit
    def push(particles: Any, state: Any, dt: float) -> float:
        force = contact(state, 2.0 * radius - (particles[1, 0] - particles[0, 0]), dt)
        particles[0, 6] -= force / mass
        particles[1, 6] += force / mass
        return force

    sim.dt, forces = step, [0.0]
    sim.additional_forces = lambda _: forces.append(push(particles, state, step))
    for _ in range(1_000_000):
        sim.steps(1)
        if forces[-1] == 0.0 and max(forces) > 0.0 and particles[1, 3] > particles[0, 3]:
            return float((particles[1, 3] - particles[0, 3]) / velocity)
    raise RuntimeError("the balls do not part")


def by_kratos(
    snippet: str, radius: float, density: float, velocity: float, step: float, end: float, along: float = math.nan
) -> tuple[float, float]:
    """Coefficients e and e_t of a ball on a wall of the same material, with the materials of a snippet.

    The run lasts until `end` [s], after the ball has left the wall. `along` [m/s] is the velocity along the wall.
    """
    import KratosMultiphysics as kratos
    from KratosMultiphysics import DEMApplication as dem
    from KratosMultiphysics.DEMApplication.DEM_analysis_stage import DEMAnalysisStage

    # It ignores comments, which are not JSON.
    materials = json.loads(kratos.Parameters(f"{{{snippet}}}").WriteJsonString())
    (ball,), (relation,) = materials["materials"], materials["material_relations"]
    wall = {"material_name": "wall", "material_id": 2, "Variables": {**ball["Variables"], "COMPUTE_WEAR": False}}
    ball["Variables"]["PARTICLE_DENSITY"] = density
    relation |= {"material_names_list": ["ball", "wall"], "material_ids_list": [1, 2]}
    relation["Variables"] |= {
        "ROLLING_FRICTION": 0.0,
        "ROLLING_FRICTION_WITH_WALLS": 0.0,
        "DEM_CONTINUUM_CONSTITUTIVE_LAW_NAME": "DEM_KDEM",
        "DEM_ROLLING_FRICTION_MODEL_NAME": "DEMRollingFrictionModelConstantTorque",
    }
    materials["materials"].append(wall)
    materials["material_assignation_table"] = [["SpheresPart", "ball"], ["RigidFacePart", "wall"]]
    parameters = {
        "Dimension": 3, "BoundingBoxOption": False, "GravityX": 0.0, "GravityY": 0.0, "GravityZ": 0.0,
        "solver_settings": {
            "strategy": "sphere_strategy", "RemoveBallsInitiallyTouchingWalls": False,
            "material_import_settings": {"materials_filename": "materials.json"},
        },
        "TranslationalIntegrationScheme": "Velocity_Verlet", "AutomaticTimestep": False, "MaxTimeStep": step,
        "FinalTime": end, "NeighbourSearchFrequency": 1, "ElementType": "SphericPartDEMElement3D",
        "OutputTimeStep": 1e9, "GraphExportFreq": 1e9, "VelTrapGraphExportFreq": 1e9, "problem_name": "ball",
    }  # fmt: skip
    after: list[float] = []

    class Drop(DEMAnalysisStage):
        def GetMainPath(self) -> str:
            return folder

        def GetProblemNameWithPath(self) -> str:
            return os.path.join(folder, "ball")

        def ReadModelParts(self, *_: Any) -> None:
            of_ball, of_walls = kratos.Properties(0), kratos.Properties(0)
            self.spheres_model_part.AddProperties(of_ball)
            self.rigid_face_model_part.AddProperties(of_walls)
            scheme = dem.VelocityVerletScheme()
            scheme.SetTranslationalIntegrationSchemeInProperties(of_ball, True)
            scheme.SetRotationalIntegrationSchemeInProperties(of_ball, True)
            dem.PropertiesProxiesManager().CreatePropertiesProxies(self.spheres_model_part)
            place = kratos.Array3()
            # Kratos forgets the tangential force where a contact moves from one triangle of a wall to the next one.
            place[0], place[1], place[2] = 3.0 * radius, 2.5 * radius, radius
            self.creator_destructor.CreateSphericParticle(
                self.spheres_model_part, place, of_ball, radius, "SphericParticle3D"
            )
            for node in self.spheres_model_part.Nodes:
                node.SetSolutionStepValue(kratos.VELOCITY_Z, -velocity)
                node.SetSolutionStepValue(kratos.VELOCITY_X, np.nan_to_num(along))
            far = 10.0 * radius
            for n, (x, y) in enumerate([(-far, far), (far, far), (-far, -far), (far, -far)], 3):
                self.rigid_face_model_part.CreateNewNode(n, x, y, 0.0)
            for n, corners in ((7, [5, 6, 3]), (8, [3, 6, 4])):
                self.rigid_face_model_part.CreateNewCondition("RigidFace3D3N", n, corners, of_walls)

        def OutputSolutionStep(self) -> None:
            pass

        def Finalize(self) -> None:
            numbers = kratos.VELOCITY_Z, kratos.VELOCITY_X, kratos.ANGULAR_VELOCITY_Y
            for node in self.spheres_model_part.Nodes:
                after.extend(node.GetSolutionStepValue(number) for number in numbers)
            super().Finalize()

    before, printed = os.getcwd(), os.dup(1)
    with tempfile.TemporaryDirectory() as folder:
        Path(folder, "materials.json").write_text(json.dumps(materials))
        # It writes folders of results where it runs, and prints warnings of properties that the law does not use.
        os.chdir(folder)
        sys.stdout.flush()
        os.dup2(os.open(os.devnull, os.O_WRONLY), 1)
        try:
            Drop(kratos.Model(), kratos.Parameters(json.dumps(parameters))).Run()
        finally:
            os.dup2(printed, 1)
            os.chdir(before)
    rise, speed, spin = after
    return rise / velocity, (radius * spin - speed) / along


LIGGGHTS = """
{particles} yes
atom_style granular
atom_modify map array
boundary f f f
newton off
communicate single vel yes
units si
region box block {low!r} {high!r} {low!r} {high!r} {low!r} {high!r} units box
create_box 1 box
neighbor {radius!r} bin
neigh_modify delay 0
{snippet}
{balls}
set group all diameter {diameter!r} density {density!r}
timestep {step!r}
fix motion all nve/sphere
run {count}
variable rebound equal {rebound}
print "e v = ${{rebound}}"
"""


def by_liggghts(
    snippet: str, radius: float, density: float, velocity: float, step: float, end: float, wall: bool
) -> tuple[float, str]:
    """Coefficient of restitution of two equal balls, or of a ball and a wall at z = 0, and the version of LIGGGHTS.

    The snippet runs as it is. The run lasts until `end` [s], after the contact.
    """
    if shutil.which("liggghts") is None:
        raise ImportError("LIGGGHTS is not installed")
    balls = [(radius, -velocity)] if wall else [(-radius, 0.5 * velocity), (radius, -0.5 * velocity)]
    young = re.search(r"youngsModulus peratomtype (\S+)", snippet)
    assert young is not None
    script = LIGGGHTS.format(
        particles="hard_particles" if float(young[1]) > 1e9 else "soft_particles",
        snippet=snippet, radius=radius, diameter=2.0 * radius, density=density, step=step, count=round(end / step),
        low=-4.0 * radius, high=4.0 * radius, rebound="vz[1]" if wall else "vz[2]-vz[1]",
        balls="\n".join(
            f"create_atoms 1 single 0 0 {z!r} units box\nset atom {n} vz {speed!r}"
            for n, (z, speed) in enumerate(balls, 1)
        ),
    )  # fmt: skip
    with tempfile.TemporaryDirectory() as folder:
        Path(folder, "balls.txt").write_text(script)
        done = subprocess.run(["liggghts", "-in", "balls.txt"], cwd=folder, capture_output=True, text=True)
    result = re.search(r"^e v = (\S+)$", done.stdout, re.MULTILINE)
    if result is None:
        last = (done.stdout + done.stderr).strip().splitlines()[-1].rstrip(".")
        raise ImportError(f"LIGGGHTS: {last}")
    return float(result[1]) / velocity, re.findall(r"LIGGGHTS-\w+ ([\d.]+)", done.stdout)[0]


MERCURY = """
#include <cstdio>
#include <cstdlib>
#include "CMakeDefinitions.h"
#include "Mercury3D.h"
#include "Walls/InfiniteWall.h"
#include "Species/HertzianBSHPViscoelasticSpecies.h"

int main(int, char** numbers) {
    const double radius = atof(numbers[1]), density = atof(numbers[2]), velocity = atof(numbers[3]);
    const bool wall = atoi(numbers[6]);
%s
    species.setDensity(density);
    Mercury3D balls;
    balls.setName("balls");
    balls.setFileType(FileType::NO_FILE);
    balls.setDomain({-1.0, -1.0, -1.0}, {1.0, 1.0, 1.0});
    balls.speciesHandler.copyAndAddObject(species);
    for (int side = wall ? 1 : -1; side <= 1; side += 2) {
        SphericalParticle ball(balls.speciesHandler.getObject(0));
        ball.setRadius(radius);
        ball.setPosition({0.0, 0.0, side * radius});
        ball.setVelocity({0.0, 0.0, -(wall ? 1.0 : 0.5) * side * velocity});
        balls.particleHandler.copyAndAddObject(ball);
    }
    if (wall) {
        InfiniteWall ground(balls.speciesHandler.getObject(0));
        ground.set({0.0, 0.0, -1.0}, {0.0, 0.0, 0.0});
        balls.wallHandler.copyAndAddObject(ground);
    }
    balls.setTimeStep(atof(numbers[4]));
    balls.setTimeMax(atof(numbers[5]));
    balls.solve();
    const auto& all = balls.particleHandler;
    const double first = wall ? 0.0 : all.getObject(0)->getVelocity().Z;
    std::printf("MercuryDPM %%s\\n", getVersion().c_str());
    std::printf("e = %%.17g\\n", (all.getLastObject()->getVelocity().Z - first) / velocity);
}
"""


@cache
def mercury_program(snippet: str) -> Path:
    """Program of two balls, or of a ball and a wall, with a snippet as it is."""
    place = os.environ.get("MERCURYDPM", "")
    libraries = sorted(map(str, Path(place, "build").rglob("*.a"))) if place else []
    if not libraries:
        raise ImportError("MercuryDPM is not installed")
    folder = Path(tempfile.mkdtemp())
    (folder / "balls.cc").write_text(MERCURY % snippet)
    headers = [f"-I{place}/Kernel", f"-I{place}/build/Kernel"]
    command = ["g++", "-std=c++17", "-O1", *headers, "balls.cc", "-Wl,--start-group", *libraries, "-Wl,--end-group"]
    subprocess.run([*command, "-o", "balls"], cwd=folder, check=True)
    return folder / "balls"


def by_mercury(snippet: str, *numbers: float) -> tuple[float, str]:
    """Coefficient of restitution with a snippet as it is, and the version of MercuryDPM.

    The numbers are the radius [m], density [kg/m^3], velocity [m/s], time step and end [s], and 1 for a wall or 0 for
    two equal balls.
    """
    program = mercury_program(snippet)
    done = subprocess.run([program, *map(repr, numbers)], cwd=program.parent, capture_output=True, text=True)
    version, e = re.findall(r"^(?:MercuryDPM|e =) (\S+)$", done.stdout, re.MULTILINE)
    return float(e), version


YADE = """
{snippet}
material.density = {density!r}
O.materials.append(material)
for side in (-1, 1):
    n = O.bodies.append(sphere((0, 0, side * {radius!r}), {radius!r}, material=material))
    O.bodies[n].state.vel = (0, 0, -0.5 * side * {velocity!r})
O.engines = [
    ForceResetter(),
    InsertionSortCollider([Bo1_Sphere_Aabb()], verletDist={radius!r}),
    InteractionLoop([Ig2_Sphere_Sphere_ScGeom()], [physics], [law]),
    NewtonIntegrator(damping=0),
]
O.dt = {step!r}
O.run({count}, True)
print("e =", (O.bodies[1].state.vel[2] - O.bodies[0].state.vel[2]) / {velocity!r})
"""


def yade_version() -> str:
    """Version of YADE."""
    done = subprocess.run(["yade", "--version"], capture_output=True, text=True)
    return (done.stdout + done.stderr).strip().splitlines()[-1].removeprefix("Yade ").replace(":", "").strip()


def by_yade(snippet: str, radius: float, density: float, velocity: float, step: float, end: float) -> float:
    """Coefficient of restitution of two equal balls, with a snippet as it is, after the time `end` [s]."""
    script = YADE.format(
        snippet=snippet, radius=radius, density=density, velocity=velocity, step=step, count=round(end / step)
    )
    with tempfile.TemporaryDirectory() as folder:
        Path(folder, "pair.py").write_text(script)
        done = subprocess.run(["yade", "-n", "-x", "-j1", "pair.py"], cwd=folder, capture_output=True, text=True)
    results = [line.removeprefix("e = ") for line in done.stdout.splitlines() if line.startswith("e = ")]
    if not results:
        last = (done.stdout + done.stderr).strip().splitlines()[-1].rstrip(".")
        raise ImportError(f"YADE: {last}")
    return float(results[0])


BALL = rs.Body(rs.kelvin_voigt(1e6, 60.0, poisson_ratio=0.5, density=1100.0, name="soft rubber"), radius=0.005)
VELOCITIES = np.geomspace(0.1, 3.0, 10)
STEPS = (25, 50, 100, 200, 400)

TEXT = """\
# Laws for other codes, run by these codes

Made by `validation/codes.py`.

<!-- table -->

Two equal balls of a soft Kelvin-Voigt rubber (R = 5 mm, 1100 kg/m^3, G = 1 MPa,
eta = 60 Pa s, nu = 0.5), or a ball and a wall, collide head on. `rs.calibrate` writes the text to paste for
{low:g} to {high:g} m/s, and the code runs it as it is. "Promised" is the e that `rs.calibrate` states for the law of
the code, without the error of its time step. "Exact" is `rs.solve`.
"""


def calibrated(target: str, wall: bool = False, **options: Any) -> rs.Calibration:
    """The law of a code for the balls of this script."""
    other = rs.Body(BALL.material) if wall else BALL
    return rs.calibrate((BALL, other), target, (VELOCITIES[0], VELOCITIES[-1]), **options)


def exact(velocity: float, wall: bool = False) -> tuple[float, float]:
    """Coefficient of restitution and contact time [s] of two balls, or of a ball and a wall."""
    other = rs.Body(BALL.material) if wall else BALL
    result = rs.solve(rs.collision(BALL, other, velocity))
    return float(result.restitution_coefficient), float(result.contact_time)


def lammps_section() -> str:
    """Tables of LAMMPS."""
    text = [f"\n### LAMMPS (version {lammps_engine.version()})\n"]
    for target in ("lammps-viscoelastic", "lammps-tsuji", "lammps-coeff-restitution"):
        for wall in (False, True):
            law = calibrated(target, wall)
            rows = []
            for v in map(float, VELOCITIES):
                promise, (e, time) = law.restitution_coefficient(v), exact(v, wall)
                results = [by_lammps(law.snippet, "si", BALL.radius, BALL.mass, v, time / n, wall) for n in STEPS]
                rows.append([f"{v:.3g}", e, promise, results[-1], *(f"{value - promise:+.1e}" for value in results)])
            if wall:
                worst = max(abs(float(cells[-1])) for cells in rows)
                text.append(f"\nA ball and a wall: at most {worst:.1e} from the promise at {STEPS[-1]} steps.\n")
                continue
            text.append(f"\n`{target}`, two balls:\n\n```text\n{law.snippet.strip()}\n```\n\n")
            errors = [f"error at {n} steps" for n in STEPS]
            text.append(table(["v0 [m/s]", "exact", "promised", f"LAMMPS, {STEPS[-1]} steps", *errors], rows))
    text.append("\nThe error is that from the promise; the steps are those in a contact. It shrinks with the step.\n")
    return "".join(text)


def liggghts_section() -> str:
    """Tables of LIGGGHTS."""
    text, version = [], ""
    for wall in (False, True):
        law, rows = calibrated("liggghts", wall), []
        for v in map(float, VELOCITIES[::3]):
            promise, (e, time) = law.restitution_coefficient(v), exact(v, wall)
            results = []
            for n in (50, 200, 800):
                value, version = by_liggghts(law.snippet, BALL.radius, 1100.0, v, time / n, 3.0 * time, wall)
                results.append(value)
            rows.append([f"{v:.3g}", e, promise, results[-1], *(f"{value - promise:+.1e}" for value in results)])
        titles = [
            "v0 [m/s]",
            "exact",
            "promised",
            "LIGGGHTS, 800 steps",
            *(f"error at {n} steps" for n in (50, 200, 800)),
        ]
        text.append(f"\n{'A ball and a wall' if wall else 'Two balls'}:\n\n" + table(titles, rows))
    return f"\n### LIGGGHTS (version {version})\n" + "".join(text)


def rebound_section() -> str:
    """Table of REBOUND: the function of the snippet, and a compiled surrogate."""
    import numba
    import rebound

    law = calibrated("rebound")

    class Simulation:
        coefficient_of_restitution: Any = None

    exec(law.snippet, {"sim": Simulation})
    low, high = float(VELOCITIES[0]), float(VELOCITIES[-1])
    curve = rs.surrogate(rs.collision(BALL, BALL, 1.0), (low, high), rtol=1e-8).compiled()
    compiled = numba.cfunc("float64(voidptr, float64)")(lambda _, v: curve(abs(v)))
    rows = []
    for v in (low, *map(float, np.geomspace(low, high, 6)[1:-1] * 1.03), high):
        e, _ = exact(v)
        pasted = by_rebound(Simulation.coefficient_of_restitution, BALL.radius, v)
        fast = by_rebound(compiled.address, BALL.radius, v)
        rows.append([f"{v:.3g}", e, pasted, f"{pasted - e:+.1e}", f"{fast - e:+.1e}"])
    text = (
        f"\n### REBOUND (version {rebound.__version__})\n\nThey take e(v) itself, as the table of the snippet or "
        "as\n`rs.surrogate(...).compiled()` in a `numba.cfunc`.\n\n"
    )
    return text + table(["v0 [m/s]", "exact", "REBOUND, snippet", "error", "error of the compiled surrogate"], rows)


def ring_section() -> str:
    """Table of a patch of a planetary ring in REBOUND: a shearing sheet of hard spheres."""
    solid = rs.kelvin_voigt(1e6, 4e4, poisson_ratio=0.5, density=900.0)
    boulder = rs.Body(solid, radius=1.0)
    slow, fast = 1e-8, 1.0
    curve = rs.surrogate(rs.collision(boulder, boulder, 1e-3), (slow, fast), rtol=1e-6)
    compiled, seen, rows = curve.compiled(), [], []
    for words, e in (
        ("exact e(v)", lambda v: compiled(min(max(v, slow), fast))),
        (f"e = {curve(1e-3):.2f}, that of 1 mm/s", lambda v: float(curve(1e-3))),
        ("e = 0.5", lambda v: 0.5),
    ):
        cells = []
        for orbits in (3.0, 12.0):
            spread, speeds = ring_patch(e, boulder.radius, orbits)
            cells += [f"{spread:.1f}", str(len(speeds))]
            seen += speeds[::200] if words.startswith("exact") else []
        rows.append([words, *cells])
    used = np.clip(seen, slow, fast)
    expected = rs.solve(rs.collision(boulder, boulder, used)).restitution_coefficient
    text = (
        "\n### A patch of a planetary ring, in REBOUND\n\nA shearing sheet of 150 boulders (R = 1 m, Kelvin-Voigt, "
        "G = 1 MPa, eta = 40 kPa s, 900 kg/m^3) in the orbit\nof Saturn's rings. The spread of the velocities is in "
        f"units of R and the angular velocity of the orbit. The e of\n{used.size} collisions is within "
        f"{np.abs(curve(used) - expected).max():.0e} of the exact one. The table is one draw: "
        "with other random orders of the collisions the\nspreads of the first two laws change, by up to a third "
        "in three draws.\n\n"
    )
    titles = ["law", "spread after 3 orbits", "collisions", "spread after 12 orbits", "collisions"]
    return text + table(titles, rows)


def ring_patch(e: Any, radius: float, orbits: float) -> tuple[float, list[float]]:
    """Spread of the velocities over radius and angular velocity, and the impact velocities [m/s]."""
    import rebound

    sim, speeds, rng = rebound.Simulation(), list[float](), np.random.default_rng(1)
    sim.OMEGA = omega = 1.3143527e-4
    sim.integrator, sim.boundary, sim.gravity = "sei", "shear", "none"
    # REBOUND resolves the collisions of a step in random order.
    sim.collision, sim.collision_resolve, sim.rand_seed = "direct", "hardsphere", 1
    sim.dt, sim.root_size, sim.N_ghost_x, sim.N_ghost_y = 2e-3 * np.pi / omega, 30.0 * radius, 1, 1
    for _ in range(150):
        x, y = rng.uniform(-15.0, 15.0, 2) * radius
        sim.add(m=1.0, r=radius, x=x, y=y, z=rng.normal(0.0, radius), vy=-1.5 * x * omega)

    def coefficient(_: Any, v: float) -> float:
        speeds.append(abs(v))
        return e(abs(v))

    sim.coefficient_of_restitution = coefficient
    sim.integrate(orbits * 2.0 * np.pi / omega)
    velocities = np.array([(p.vx, p.vy + 1.5 * p.x * omega, p.vz) for p in sim.particles])
    return float(np.sqrt(np.mean(np.sum(velocities**2, axis=1))) / (radius * omega)), speeds


def memory_section() -> str:
    """Table of the contact law with memory in REBOUND."""
    solid = rs.standard_solid(1e6, 5e6, 500.0, poisson_ratio=0.49, density=1100.0, name="standard solid")
    rows = []
    for material in (BALL.material, solid):
        ball = rs.Body(material, BALL.radius)
        for v in map(float, VELOCITIES[::3]):
            hit = rs.collision(ball, ball, v)
            result, law = rs.solve(hit), rs.contact_law(hit)
            e, time = float(result.restitution_coefficient), float(result.contact_time)
            results = [by_rebound_with_memory(law, ball.radius, ball.mass, v, time / n) for n in (25, 50, 100, 200)]
            rows.append([str(material.name), f"{v:.3g}", e, *(f"{value - e:+.1e}" for value in results)])
    titles = ["material", "v0 [m/s]", "exact", *(f"error at {n} steps" for n in (25, 50, 100, 200))]
    text = "\n### The contact law with memory, in REBOUND\n\n`rs.contact_law` as `additional_forces`, leapfrog.\n\n"
    return text + table(titles, rows)


def mujoco_section() -> str:
    """Table of MuJoCo."""
    import mujoco

    law = calibrated("mujoco-solref", wall=True)
    rows = []
    for v in map(float, VELOCITIES[::3]):
        e, time = exact(v, wall=True)
        results = [by_mujoco(law.snippet, BALL.radius, BALL.mass, v, time / n) for n in (25, 100, 400)]
        promise, span = law.restitution_coefficient(v), law.contact_time(v)
        errors = [f"{value - promise:+.1e}" for value, _ in results]
        rows.append(
            [
                f"{v:.3g}",
                e,
                promise,
                results[-1][0],
                *errors,
                *(f"{1e3 * t:.3f}" for t in (time, span, results[-1][1])),
            ]
        )
    titles = ["v0 [m/s]", "exact", "promised", "MuJoCo, 400 steps", *(f"error at {n} steps" for n in (25, 100, 400))]
    times = [f"contact time [ms], {words}" for words in ("exact", "promised", "MuJoCo")]
    return (
        f"\n### MuJoCo (version {mujoco.__version__})\n\nA ball on a floor:\n\n```xml\n{law.snippet.strip()}\n```\n\n"
        + table([*titles, *times], rows)
    )


def drake_section() -> str:
    """Tables of Drake."""
    from importlib.metadata import version

    text = f"\n### Drake (version {version('drake')})\n"
    for target, words in (("drake", "Hunt-Crossley, `kLagged`"), ("drake-sap", "relaxation time, `kSap`")):
        law, rows = calibrated(target, wall=True), []
        for v in map(float, VELOCITIES[::3]):
            e, _ = exact(v, wall=True)
            promise, span = law.restitution_coefficient(v), law.contact_time(v)
            results = [by_drake(law.snippet, BALL.radius, BALL.mass, v, span / n, 3.0 * span) for n in (50, 200, 800)]
            rows.append([f"{v:.3g}", e, promise, results[-1], *(f"{value - promise:+.1e}" for value in results)])
        errors = [f"error at {n} steps" for n in (50, 200, 800)]
        text += f"\nA ball on a floor, {words}:\n\n"
        text += table(["v0 [m/s]", "exact", "promised", "Drake, 800 steps", *errors], rows)
    return text


def kratos_section() -> str:
    """Table of Kratos."""
    law = calibrated("kratos-dem", wall=True)
    rows = []
    for v in map(float, VELOCITIES[::3]):
        e, time = exact(v, wall=True)
        promise = law.restitution_coefficient(v)
        results = [by_kratos(law.snippet, BALL.radius, 1100.0, v, time / n, 3.0 * time)[0] for n in (50, 200, 800)]
        rows.append([f"{v:.3g}", e, promise, results[-1], *(f"{value - promise:+.1e}" for value in results)])
    titles = ["v0 [m/s]", "exact", "promised", "Kratos, 800 steps", *(f"error at {n} steps" for n in (50, 200, 800))]
    return "\n### Kratos DEM\n\nA ball on a wall.\n\n" + table(titles, rows)


def mercury_section() -> str:
    """Table of MercuryDPM."""
    rows, version = [], ""
    for wall in (False, True):
        law = calibrated("mercury-bshp", wall=wall)
        for v in map(float, VELOCITIES[::3]):
            e, time = exact(v, wall=wall)
            promise = law.restitution_coefficient(v)
            results = []
            for n in (50, 200, 800):
                numbers = BALL.radius, 1100.0, v, time / n, 3.0 * time, int(wall)
                value, version = by_mercury(law.snippet, *numbers)
                results.append(value)
            bodies = "ball and wall" if wall else "two balls"
            rows.append(
                [bodies, f"{v:.3g}", e, promise, results[-1], *(f"{value - promise:+.1e}" for value in results)]
            )
    titles = ["", "v0 [m/s]", "exact", "promised", "MercuryDPM, 800 steps"]
    titles += [f"error at {n} steps" for n in (50, 200, 800)]
    text = (
        f"\n### MercuryDPM (version {version})\n\nThe lines of the snippet, compiled in a program of two bodies.\n\n"
    )
    return text + table(titles, rows)


def yade_section() -> str:
    """Table of YADE, without the velocity `vn` of the snippet where the version has none."""
    if shutil.which("yade") is None:
        raise ImportError("YADE is not installed")
    law = calibrated("yade-mindlin")
    snippet, typed = law.snippet, None
    try:
        by_yade(snippet, BALL.radius, 1100.0, 1.0, 1e-5, 1e-5)
        text = "Two balls."
    except ImportError:
        snippet, typed = re.sub(r", vn=[^)]*", "", snippet), law.parameters["en"].value
        text = (
            "Two balls. This version has no `vn`, so the snippet runs without it: e is `en` at all velocities, and\n"
            "does not fall as `rs.calibrate` promises for later versions. The error of 7e-5 that remains at small\n"
            "steps is that of the polynomial (Thornton, 2013) by which YADE computes the damping from `en`."
        )
    rows = []
    for v in map(float, VELOCITIES[::3]):
        e, time = exact(v)
        promise = law.restitution_coefficient(v) if typed is None else typed
        results = [by_yade(snippet, BALL.radius, 1100.0, v, time / n, 3.0 * time)[0] for n in (50, 200, 800)]
        rows.append([f"{v:.3g}", e, promise, results[-1], *(f"{value - promise:+.1e}" for value in results)])
    titles = ["v0 [m/s]", "exact", "promised", "YADE, 800 steps", *(f"error at {n} steps" for n in (50, 200, 800))]
    return f"\n### YADE ({yade_version()})\n\n{text}\n\n" + table(titles, rows)


SECTIONS = {
    "LAMMPS": lammps_section, "LIGGGHTS": liggghts_section, "REBOUND": rebound_section, "A patch": ring_section,
    "The contact law": memory_section, "MuJoCo": mujoco_section, "Drake": drake_section, "Kratos": kratos_section,
    "MercuryDPM": mercury_section, "YADE": yade_section,
}  # fmt: skip
"""Sections of the table by the start of their headings."""


def main() -> None:
    """Write `codes.md`, with all sections made anew, or those that the arguments name."""
    path, chosen = Path(__file__).with_suffix(".md"), sys.argv[1:] or list(SECTIONS)
    before = re.split(r"(?m)^(?=\n### )", path.read_text(encoding="utf-8")) if sys.argv[1:] else []
    text = [TEXT.format(low=VELOCITIES[0], high=VELOCITIES[-1])]
    for name, section in SECTIONS.items():
        if name not in chosen:
            text += [part for part in before if part.startswith(f"\n### {name}")]
            continue
        try:
            text.append(section())
        except ImportError as error:
            text.append(f"\nLeft out: {error}.\n")
        print(text[-1], flush=True)
    path.write_text("".join(text), encoding="utf-8")


if __name__ == "__main__":
    main()
