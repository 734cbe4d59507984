"""The header in C compiles without warnings and gives the forces of the law in Python."""

import math
import shutil
import subprocess

import numpy as np
import pytest

from refusals import in_one_line
from restitution import Adhesion, Body, ContactLaw, Impact, Material, PronySeries, contact_law
from restitution.contact.profiles import Parabola, PowerLaw, TruncatedCone

PROGRAM = """\
#include <stdio.h>
#include "soft.h"
#include "hard.h"

int main(void)
{
    double soft[SOFT_SIZE], hard[HARD_SIZE], depth, dt;
    soft_start(soft, -1e-6);
    hard_start(hard, -1e-6);
    while (scanf("%lf %lf", &depth, &dt) == 2)
        printf("%.17g %.17g\\n", soft_step(soft, depth, dt), hard_step(hard, depth, dt));
    return 0;
}
"""

SOFT = Material(PronySeries(1e6, [3e6, 5e6], [1e-4, 2e-3], parallel_viscosity=20.0), 2e7, name="a */ b", source="lab")
HARD = Material(PronySeries(1e7), 2e9)
CASES = {
    "parabola": contact_law(Impact(SOFT, Parabola(0.01), 0.005, 1.0), max_nodes=12),
    "power": contact_law(Impact(SOFT, PowerLaw(3.0, 1e3), 0.005, 1.0)),
    "table": contact_law(Impact(SOFT, TruncatedCone(0.001, 1.3), 0.005, 1.0), max_depth=2e-4),
}


def history(rng) -> tuple[np.ndarray, np.ndarray]:
    """Depths [m] with loading again and flights, and steps [s] of two lengths and of random ones."""
    dt = np.concatenate([np.full(300, 1e-5), np.full(300, 4e-5), rng.uniform(1e-6, 1e-4, 300)])
    times = np.cumsum(dt)
    waves = np.sin(2.0 * math.pi * times[:, None] * [70.0, 190.0, 410.0] + rng.uniform(0.0, 6.0, 3))
    return 5e-5 * waves.sum(axis=1), dt


@pytest.mark.skipif(shutil.which("cc") is None, reason="there is no C compiler")
@pytest.mark.parametrize("case", CASES)
def test_c_and_python_agree(tmp_path, case):
    soft, hard = CASES[case], contact_law(Impact(HARD, Parabola(0.02), 1.0, 1.0))
    for law, name in ((soft, "soft"), (hard, "hard")):
        assert law.to_c(tmp_path / f"{name}.h", name=name) == tmp_path / f"{name}.h"
    (tmp_path / "main.c").write_text(PROGRAM)
    flags = ["-Wall", "-Wextra", "-Werror", "-pedantic", "-std=c99", "-O2"]
    subprocess.run(["cc", *flags, "main.c", "-o", "main", "-lm"], cwd=tmp_path, check=True)
    depths, dt = history(np.random.default_rng(1))
    lines = "".join(f"{depth!r} {step!r}\n" for depth, step in zip(depths.tolist(), dt.tolist(), strict=True))
    run = subprocess.run([tmp_path / "main"], input=lines, capture_output=True, text=True, check=True)
    printed = np.array([line.split() for line in run.stdout.splitlines()], dtype=float)
    for law, forces in ((soft, printed[:, 0]), (hard, printed[:, 1])):
        state = law.start(depth=-1e-6)
        expected = np.array([law.step(state, depth, step) for depth, step in zip(depths, dt, strict=True)])
        assert np.count_nonzero(np.diff(np.sign(expected))) > 5
        assert np.max(np.abs(forces - expected)) <= 1e-12 * expected.max()


def test_the_header_names_units_and_sources(tmp_path):
    text = CASES["table"].to_c(tmp_path / "law.h").read_text()
    assert "contact_law_step" in text
    assert "lab" in text
    assert "[Pa]" in text
    assert "Any history on one spot" in text
    assert "a */ b" not in text


def test_a_header_names_the_same_material_once(tmp_path):
    """Two equal beads are of one material, and its window stands beside it."""
    bead = Body(Material(SOFT.shear, 2e9, name="bead", window=(1e-4, 0.5)), 0.01, 0.005)
    text = contact_law((bead, bead)).to_c(tmp_path / "beads.h").read_text()
    assert text.count("Material: bead") == 1
    assert "from 0.0001 to 0.5 s" in " ".join(text.replace("*", " ").split())
    other = Body(HARD, 0.01, 0.005)
    assert contact_law((bead, other)).to_c(tmp_path / "beads.h").read_text().count("Material: ") == 2


@pytest.mark.parametrize("name", ["", "2a", "A", "a b", "a\n"])
def test_a_name_that_c_does_not_take_is_refused(tmp_path, name):
    law: ContactLaw = CASES["power"]
    assert in_one_line(lambda: law.to_c(tmp_path / "law.h", name=name)).field == "name"
    assert not list(tmp_path.iterdir())


SLIDING = """\
#include <stdio.h>
#include "rough.h"

int main(void)
{
    double state[ROUGH_SIZE], depth, dt, way[2], pull[2];
    rough_start(state, -1e-6);
    while (scanf("%lf %lf %lf %lf", &depth, &dt, way, way + 1) == 4) {
        double force = rough_step(state, depth, dt);
        rough_slide(state, force, way, dt, pull);
        printf("%.17g %.17g %.17g\\n", force, pull[0], pull[1]);
    }
    return 0;
}
"""


@pytest.mark.skipif(shutil.which("cc") is None, reason="there is no C compiler")
def test_c_and_python_agree_with_friction(tmp_path):
    law = contact_law(CASES["parabola"].impact, friction=0.4, max_nodes=12)
    assert "friction coefficient 0.4" in law.to_c(tmp_path / "rough.h", name="rough").read_text()
    (tmp_path / "main.c").write_text(SLIDING)
    flags = ["-Wall", "-Wextra", "-Werror", "-pedantic", "-std=c99", "-O2"]
    subprocess.run(["cc", *flags, "main.c", "-o", "main", "-lm"], cwd=tmp_path, check=True)
    rng = np.random.default_rng(3)
    depths, dt = history(rng)
    ways = rng.normal(size=(dt.size, 2)) * 1e-5
    table = np.column_stack([depths, dt, ways]).tolist()
    lines = "".join(" ".join(map(repr, row)) + "\n" for row in table)
    run = subprocess.run([tmp_path / "main"], input=lines, capture_output=True, text=True, check=True)
    printed = np.array([line.split() for line in run.stdout.splitlines()], dtype=float)
    state = law.start(depth=-1e-6)
    expected = np.array(
        [
            (force, *pull)
            for force, pull in (law.step(state, d, h, way=w) for d, h, w in zip(depths, dt, ways, strict=True))
        ]
    )
    assert np.count_nonzero(expected[:, 1]) > 100
    assert np.max(np.abs(printed - expected)) <= 1e-10 * expected.max()


STICKING = """\
#include <stdio.h>
#include "sticky.h"

int main(void)
{
    double state[STICKY_SIZE], depth, dt;
    sticky_start(state, -1.0);
    while (scanf("%lf %lf", &depth, &dt) == 2)
        printf("%.17g\\n", sticky_step(state, depth, dt));
    return 0;
}
"""


@pytest.mark.skipif(shutil.which("cc") is None, reason="there is no C compiler")
@pytest.mark.parametrize(("compiler", "modes"), [("cc", 0), ("cc", 2), ("c++", 1)])
def test_c_and_python_agree_with_adhesion(tmp_path, compiler, modes):
    """Depths between far and deep, with jumps of the attraction; beyond the largest depth the force is NaN."""
    if shutil.which(compiler) is None:
        pytest.skip("there is no compiler of C++")
    material = Material(PronySeries(3e8, [3e8, 5e8][:modes], [1e-8, 1e-7][:modes]), 2e9)
    attraction = Adhesion(0.05, stress=1e8)
    impact = Impact(material, Parabola(5e-6), mass=2.5e-12, velocity=0.3, adhesion=attraction)
    law = contact_law(impact, elements=20)
    text = law.to_c(tmp_path / "sticky.h", name="sticky").read_text()
    assert f"#define STICKY_RANGE {attraction.range!r}" in text
    assert "without adhesion" not in text
    (tmp_path / "main.c").write_text(STICKING)
    flags = {"cc": ["-std=c99", "-pedantic"], "c++": ["-x", "c++"]}[compiler]
    warned = ["-Wall", "-Wextra", "-Wshadow", "-Werror", "-O1"]
    subprocess.run([compiler, *flags, *warned, "main.c", "-o", "main", "-lm"], cwd=tmp_path, check=True)
    rng = np.random.default_rng(modes)
    times = np.linspace(0.0, 1.0, 301)[1:]
    waves = np.sin(2.0 * np.pi * times[:, None] * [2.0, 7.0, 3.1] + rng.uniform(0.0, 6.0, 3)).sum(axis=1)
    depths, dt = 0.3 * law.max_depth * waves, np.exp(rng.uniform(-21.0, -17.0, times.size))
    asked = np.append(depths, 2.0 * law.max_depth)
    lines = "".join(f"{depth!r} {h!r}\n" for depth, h in zip(asked.tolist(), [*dt.tolist(), 1e-9], strict=True))
    run = subprocess.run([tmp_path / "main"], input=lines, capture_output=True, text=True, check=True)
    forces, state = np.array(run.stdout.split(), dtype=float), law.start(depth=-1.0)
    expected = np.array([law.step(state, depth, h) for depth, h in zip(depths.tolist(), dt, strict=True)])
    assert math.isnan(forces[-1])
    assert expected.min() < 0.0 < expected.max()
    assert law.read(state).jump_energy > 0.0
    assert np.abs(forces[:-1] - expected).max() <= 1e-9 * expected.max()
