"""The interpolant in JavaScript against that in Python, by node where there is one."""

import json
import shutil
import subprocess
from importlib.resources import files

import numpy as np
import pytest

import restitution as rs
from restitution.explorer import answers
from restitution.paper.figures import instantaneous_poisson_ratio

NODE = shutil.which("node")
SCRIPT = """
import { readFileSync } from "node:fs";
import { interpolant, instantaneousPoissonRatio, groups } from "./interpolant.mjs";
const paper = interpolant(JSON.parse(readFileSync("interpolant.json", "utf8")));
const { points, solid } = JSON.parse(readFileSync("points.json", "utf8"));
const map = paper.map(0.45, [1e-3, 0.1, 10], [1e-2, 1]);
console.log(JSON.stringify({
  e: points.map((p) => paper.restitution(...p)),
  glass: points.map(([nu, p2]) => instantaneousPoissonRatio(nu, p2)),
  outside: [paper.restitution(0.6, 1, 1), paper.restitution(0.4, 1e-4, 1), paper.restitution(0.4, 1, 200)].map(Number.isNaN),
  map: Array.from(map), groups: groups(solid),
}));
"""


@pytest.mark.skipif(
    NODE is None, reason="node is not installed; the tests of the page in a browser use the interpolant too"
)
def test_javascript_agrees_with_python(tmp_path):
    rng = np.random.default_rng(7)
    n = 5000
    nu, p2, p3 = rng.uniform(-1, 0.5, n), 10 ** rng.uniform(-3, 1, n), 10 ** rng.uniform(-2, 2, n)
    # Corners and faces of the plane too.
    nu[:8], p2[:8], p3[:8] = [-1, 0.5] * 4, [1e-3, 1e-3, 10, 10] * 2, [1e-2] * 4 + [100] * 4
    solid = {
        "equilibrium_modulus": 1e6, "branch_modulus": 1e7, "viscosity": 1e3, "poisson_ratio": 0.45, "mass": 0.005,
        "radius": 0.01, "velocity": 1.3,
    }  # fmt: skip
    page = files("restitution.explorer") / "page"
    (tmp_path / "interpolant.mjs").write_text((page / "interpolant.js").read_text())
    (tmp_path / "interpolant.json").write_text(answers.interpolant())
    points = np.column_stack([nu, p2, p3]).tolist()
    (tmp_path / "points.json").write_text(json.dumps({"points": points, "solid": solid}))
    (tmp_path / "script.mjs").write_text(SCRIPT)
    done = subprocess.run(
        [str(NODE), "script.mjs"], cwd=tmp_path, capture_output=True, text=True, check=True, timeout=60
    )
    printed = json.loads(done.stdout)
    np.testing.assert_allclose(printed["e"], rs.standard_solid_surrogate(nu, p2, p3), rtol=0, atol=1e-9)
    np.testing.assert_allclose(printed["glass"], instantaneous_poisson_ratio(nu, p2), rtol=1e-9)
    assert printed["outside"] == [True, True, True]
    expected = rs.standard_solid_surrogate(0.45, [[1e-3, 0.1, 10]], [[1e-2], [1]])
    np.testing.assert_allclose(np.reshape(printed["map"], (2, 3)), expected, rtol=0, atol=1e-9)
    constants = {key: value for key, value in solid.items() if key not in ("mass", "radius", "velocity")}
    impact = rs.Impact(rs.standard_solid(**constants), rs.Parabola(0.01), mass=0.005, velocity=1.3)
    assert list(printed["groups"].values()) == pytest.approx(list(rs.dimensionless_groups(impact)), rel=1e-12)
