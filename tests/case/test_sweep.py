"""Sweep files: any key of a case may vary, and each point equals the case with its values."""

import copy
import pickle
import re
import tomllib
import warnings
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import cases
import refusals
import restitution as rs
from checkout import blocks
from restitution import Samples, read_case
from restitution.case.sweep import read_sweep
from restitution.sweeps.run import run

# Many of these bodies exceed the limits of the theory.
pytestmark = [pytest.mark.filterwarnings(r"ignore:.*; exceeded in \d+ of"), pytest.mark.usefixtures("folder")]

BODY = f"[body]\n{cases.BODY}"
DENSE = '[body]\ndensity = "1100 kg/m^3"\nradius = "10 mm"\n'
IMPACT = f"[impact]\n{cases.IMPACT}"
SOLID = f"\n[material]\n{cases.FAST}"
PRONY = """
[material]
bulk = "3 GPa"
shift = { reference_temperature = "20 degC", c1 = 10, c2 = 100 }
[material.shear]
equilibrium_modulus = "1 MPa"
branch_moduli = "[2, 3, 4] MPa"
relaxation_times = [1e-3, "10 ms", 0.1]
"""
# Closed forms, columns and cases add the same numbers in different orders and differ by rounding.
ROUNDING = 1e-9


def sweep(text: str) -> Any:
    Path("sweep.toml").write_text(text, encoding="utf-8")
    return run(read_sweep("sweep.toml"))


def refuses(text: str, message: str) -> None:
    Path("sweep.toml").write_text(text, encoding="utf-8")
    refusals.refuses(lambda: read_sweep("sweep.toml"), message)


def dump(table: dict[str, Any], *above: str) -> str:
    """Write TOML of plain values and tables."""
    lines = [f"{key} = {toml(value)}" for key, value in table.items() if not isinstance(value, dict)]
    head = f"[{'.'.join(above)}]\n" if above else ""
    rest = [dump(value, *above, key) for key, value in table.items() if isinstance(value, dict)]
    return head + "\n".join(lines) + "\n" + "".join(rest)


def toml(value: Any) -> str:
    if isinstance(value, bool):
        return str(value).lower()
    if isinstance(value, list):
        return f"[{', '.join(map(toml, value))}]"
    return repr(float(value)) if isinstance(value, (int, float)) else f'"{value}"'


def check(result: Any, case: str, places: dict[str, str]) -> None:
    """Compare every point with the case that contains its values."""
    dims = result.restitution_coefficient.dims
    for index in np.ndindex(*result.restitution_coefficient.shape):
        point = result.isel(dict(zip(dims, index, strict=True)))
        data = copy.deepcopy(tomllib.loads(case))
        for name, place in places.items():
            value: Any = point[name].values[()]
            *tables, key = place.split(".")
            target: Any = data
            for table in tables:
                target = target.setdefault(table, {})
            match = re.fullmatch(r"(.+)\[(\d+)\]", key)
            if match:
                target[match[1]][int(match[2])] = float(value)
            else:
                target[key] = str(value) if isinstance(value, str) else float(value)
        Path("one.toml").write_text(dump(data), encoding="utf-8")
        single = read_case("one.toml").solve()
        for name in ("restitution_coefficient", "contact_time", "max_force"):
            assert float(point[name]) == pytest.approx(getattr(single, name), rel=ROUNDING), (index, name)


@pytest.mark.parametrize(
    ("case", "axes", "places"),
    [
        (
            BODY + SOLID + '[impact]\nexternal_force = "10 mN"\n',
            'impact.velocity = { logarithmic = ["1 cm/s", 1], n = 3 }\nradius = ["5 mm", 0.02]\nmass = ["2 g"]',
            {"velocity": "impact.velocity", "radius": "body.radius", "mass": "body.mass"},
        ),
        # A mass from the density depends on the radius, and so does the weight.
        (
            DENSE + SOLID + '[impact]\nvelocity = "1 m/s"\nweight = true\n',
            'radius = ["5 mm", "20 mm"]\ndensity = { linear = [1000, 2000], n = 2 }\ngravity = [9.8, 1.6]',
            {"radius": "body.radius", "density": "body.density", "gravity": "impact.gravity"},
        ),
        (
            BODY + SOLID + '[profile]\nradius = "30 mm"\n[impact]\n',
            'drop_height = ["1 cm", "10 cm"]\ngravity = [9.8, 1.6]',
            {"drop_height": "impact.drop_height", "gravity": "impact.gravity"},
        ),
        # The mass follows from density and radius of the body; the profile has another radius.
        (
            DENSE + SOLID + IMPACT + '[profile]\nradius = "30 mm"\n',
            'body.radius = ["5 mm", "20 mm"]\nprofile.radius = ["1 cm", "4 cm"]',
            {"radius": "body.radius", "profile.radius": "profile.radius"},
        ),
        (
            BODY + SOLID + IMPACT,
            'branch_modulus = ["1 MPa", "20 MPa"]\nmaterial.viscosity = ["100 Pa s", "1 kPa s"]\nnu = [0.1, 0.5]',
            {"branch_modulus": "material.branch_modulus", "viscosity": "material.viscosity", "poisson_ratio": "material.poisson_ratio"},
        ),
        # The Poisson ratio of the file is kept constant, not the bulk modulus.
        (
            BODY + SOLID + IMPACT,
            'equilibrium_modulus = ["0.1 MPa", "4 MPa"]',
            {"equilibrium_modulus": "material.equilibrium_modulus"},
        ),
        (
            BODY + SOLID.replace("poisson_ratio = 0.45", 'bulk_modulus = "5 MPa"') + IMPACT,
            'equilibrium_modulus = ["0.1 MPa", "4 MPa"]',
            {"equilibrium_modulus": "material.equilibrium_modulus"},
        ),
        # Other forms of a material, lists within it, other profiles, the other body.
        (
            BODY + PRONY.replace('"[2, 3, 4] MPa"', "[2e6, 3e6, 4e6]") + IMPACT,
            'material.shear."relaxation_times[1]" = ["1 ms", 1e-5]\nmaterial.shear."branch_moduli[0]" = [0, "9 MPa"]',
            {
                "material.shear.relaxation_times[1]": "material.shear.relaxation_times[1]",
                "material.shear.branch_moduli[0]": "material.shear.branch_moduli[0]",
            },
        ),
        (BODY + PRONY + IMPACT, 'temperature = ["0 degC", "20 degC", "60 degC"]', {"temperature": "material.temperature"}),
        (
            BODY + PRONY + IMPACT + '[counter_material]\nshear = "1 GPa"\npoisson_ratio = 0.3\n',
            'material.temperature = ["0 degC", "60 degC"]\ncounter_material.poisson_ratio = [0.1, 0.4]',
            {"temperature": "material.temperature", "counter_material.poisson_ratio": "counter_material.poisson_ratio"},
        ),
        (
            BODY + SOLID + IMPACT + '[profile]\ntype = "cone"\n',
            'profile.half_angle = ["60 deg", 1.2]\nvelocity = [0.5, 1]',
            {"profile.half_angle": "profile.half_angle", "velocity": "impact.velocity"},
        ),
        (
            BODY + SOLID + IMPACT,
            'profile.type = ["parabola", "sphere"]\nvelocity = [0.5, 1]',
            {"profile.type": "profile.type", "velocity": "impact.velocity"},
        ),
        # Two bodies have the reduced mass and radius.
        (
            DENSE + SOLID + IMPACT + "[counter_body]\ndensity = 900\nradius = 0.01\n",
            'counter_body.radius = ["5 mm", "20 mm"]\nradius = ["10 mm", "3 mm"]\ncounter_body.density = [700, 1500]',
            {
                "counter_body.radius": "counter_body.radius",
                "radius": "body.radius",
                "counter_body.density": "counter_body.density",
            },
        ),
        # A fractional material is approximated by a series for one contact time.
        (
            BODY + IMPACT + '[material]\nmodel = "springpot"\ncoefficient = 1e6\nexponent = 0.3\nbulk_modulus = "1 GPa"\n',
            "velocity = [0.01, 1]",
            {"velocity": "impact.velocity"},
        ),
    ],
)  # fmt: skip
def test_every_point_equals_the_case_with_its_values(case: str, axes: str, places: dict[str, str]) -> None:
    check(sweep(f"{case}\n[axes]\n{axes}\n"), case, places)


@pytest.mark.parametrize("model", ["", 'model = "standard_solid"\n'])
def test_relaxation_time_of_a_standard_solid(model: str) -> None:
    # The branch modulus is kept, so that the relaxation time determines the viscosity, which may be left out.
    text = BODY + IMPACT + SOLID.replace('viscosity = "1 kPa s"\n', model)
    result = sweep(text + '[axes]\nrelaxation_time = ["0.1 ms", 1e-3]\nvelocity = [0.1, 1]\n')
    assert result.relaxation_time.attrs["units"] == "s"
    for tau in (1e-4, 1e-3):
        case = BODY + IMPACT + SOLID.replace("1 kPa s", f"{1e7 * tau} Pa s")
        check(result.sel(relaxation_time=tau), case, {"velocity": "impact.velocity"})


def test_incompressible_is_a_bulk_modulus() -> None:
    text = BODY + IMPACT + SOLID.replace("poisson_ratio = 0.45\n", "")
    result = sweep(text + '[axes]\nbulk_modulus = ["5 MPa", "incompressible"]\nvelocity = [1]\n')
    case = BODY + IMPACT + SOLID.replace("0.45", "0.5")
    check(result.sel(bulk_modulus=np.inf), case, {"velocity": "impact.velocity"})
    # The bulk modulus of the other body is a key of the case.
    counter = '[counter_material]\nshear = "10 MPa"\n'
    axes = '[axes]\ncounter_material.bulk_modulus = ["1 GPa", "incompressible"]\nvelocity = [1]\n'
    result = sweep(BODY + IMPACT + SOLID + counter + axes)
    case = BODY + IMPACT + SOLID + counter + "poisson_ratio = 0.5\n"
    check(result.isel({"counter_material.bulk_modulus": 1}), case, {"velocity": "impact.velocity"})


def test_groups_of_the_paper() -> None:
    alone = sweep("[axes]\nnu = [0.3, 0.5]\np2 = 0.1\np3 = { logarithmic = [0.1, 10], n = 3 }\n")
    expected = rs.standard_solid_restitution(np.array([[0.3], [0.5]]), 0.1, [0.1, 1.0, 10.0])
    np.testing.assert_allclose(alone.restitution_coefficient, expected, rtol=1e-12)
    # In a case file the groups set branch modulus and viscosity, which the file then leaves out.
    solid = '[material]\nequilibrium_modulus = "3 MPa"\npoisson_ratio = 0.3\n'
    within = sweep(BODY + solid + "[axes]\nvelocity = [0.2, 3]\nnu = [0.3, 0.5]\np2 = 0.1\np3 = [0.1, 1, 10]\n")
    for n in range(2):
        np.testing.assert_allclose(within.restitution_coefficient[n], expected, rtol=ROUNDING)


def test_materials_from_a_list() -> None:
    result = sweep(
        BODY
        + IMPACT
        + "[axes]\nvelocity = [0.1, 1]\n[[axes.material]]\nname = 'glass'\nshear = '30 GPa'\npoisson_ratio = 0.2\n"
        + "[[axes.material]]\nname = 'rubber'\n"
        + SOLID.replace("[material]", "")
    )
    assert result.material.values.tolist() == ["glass", "rubber"]
    np.testing.assert_allclose(result.restitution_coefficient.sel(material="glass"), 1.0, atol=1e-9)
    check(result.sel(material="rubber"), BODY + SOLID + IMPACT, {"velocity": "impact.velocity"})


def test_materials_of_a_list_are_called_by_their_source() -> None:
    tables = "[[axes.material]]\nlibrary = 'epoxy'\n[[axes.material]]\nshear = '30 GPa'\npoisson_ratio = 0.2\n"
    result = sweep(BODY + IMPACT + "[axes]\nvelocity = [1]\n" + tables)
    assert result.material.values.tolist() == ["epoxy", "material 2"]


def test_draws() -> None:
    result = sweep(
        BODY + SOLID + IMPACT + "[axes]\nvelocity = [0.5]\n[samples]\nn = 8\nseed = 3\nmethod = 'latin_hypercube'\n"
        'mass = { lognormal = ["5 g", 0.1] }\nmaterial.viscosity = { normal = ["1 kPa s", "50 Pa s"] }\n'
        'radius = { uniform = ["9 mm", "11 mm"] }\nmaterial.branch_modulus = { loguniform = ["1 MPa", 1e7] }\n'
    )
    draws = Samples(
        8,
        {
            "mass": rs.LogNormal(0.005, 0.1), "viscosity": rs.Normal(1e3, 50.0),
            "branch_modulus": rs.LogUniform(1e6, 1e7), "radius": rs.Uniform(0.009, 0.011),
        },
        "latin_hypercube",
        3,
    )  # fmt: skip
    for name, values in draws.columns("sample", 0, 8).items():
        np.testing.assert_array_equal(result[name].values, values)
        assert result[name].dims == ("sample",)
    places = {
        "mass": "body.mass", "radius": "body.radius", "viscosity": "material.viscosity",
        "branch_modulus": "material.branch_modulus", "velocity": "impact.velocity",
    }  # fmt: skip
    check(result, BODY + SOLID + IMPACT, places)


def test_options_and_attributes(tmp_path: Path) -> None:
    text = (
        'title = "Rubber"\n'
        + BODY
        + SOLID
        + '[sweep]\noutputs = ["max_force", "contact_time"]\nchunk = { velocity = 2 }\n'
        "[solver]\nrtol = 1e-7\n[axes]\nvelocity = [1, 2, 3]\n"
    )
    result = sweep(text)
    assert list(result.data_vars) == ["contact_time", "max_force", "status"]
    assert (result.attrs["title"], result.attrs["rtol"], result.attrs["case"]) == ("Rubber", 1e-7, text)
    assert '"chunk":[2]' in result.attrs["sweep"]
    # The hash does not depend on wording, order and units.
    same = sweep(text.replace('"5 g"', "0.005  # as weighed").replace("Rubber", "The same"))
    assert same.attrs["hash"] == result.attrs["hash"]
    assert sweep(text.replace('"5 g"', '"5.1 g"')).attrs["hash"] != result.attrs["hash"]


def test_a_plan_works_in_another_folder(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    Path("terms.csv").write_text("relaxation_time_s,branch_modulus_MPa\n1e-3,2\n1e-2,3\n")
    material = '[material]\nbulk = "3 GPa"\n[material.shear]\nequilibrium_modulus = "1 MPa"\nterms = "terms.csv"\n'
    Path("sweep.toml").write_text(
        BODY + material + '[axes]\nvelocity = [0.1]\nbody.radius = [0.01]\nprofile.type = ["parabola"]\n'
    )
    plan = read_sweep("sweep.toml")
    here = plan.compute((0, 0, 0))
    (tmp_path / "elsewhere").mkdir()
    monkeypatch.chdir(tmp_path / "elsewhere")
    there = pickle.loads(pickle.dumps(plan)).compute((0, 0, 0))
    assert here["contact_time"] == there["contact_time"]


AXES = "[axes]\nvelocity = [1]\n"


@pytest.mark.parametrize(
    ("text", "message"),
    [
        (BODY + SOLID + IMPACT, "axes: the section is missing; it lists what varies"),
        ("axes = 3\n", "axes = 3: must be a table"),
        (BODY + SOLID + "[axes]\nvelocity = [1, -1]\n", "velocity[1] = -1 m/s: must be finite and > 0"),
        (BODY + SOLID + "[axes]\nvelocity = ['1 m/s', '2 mm']\n", 'axes.velocity = "2 mm": is a length, not a velocity'),
        (BODY + SOLID + "[axes]\nvelocity = []\n", "axes.velocity: must hold at least one value"),
        (BODY + SOLID + "[axes]\nvelocity = { linear = [1, 2] }\n", "axes.velocity: must be a value, a list, or a table with"),
        (BODY + SOLID + "[axes]\nvelocity = { linear = [1, 2, 3], n = 3 }\n", "axes.velocity.linear = [1, 2, 3]: must be a list of two"),
        (BODY + SOLID + "[axes]\nvelocity = { linear = [1, true], n = 3 }\n", "axes.velocity = true: must be a number"),
        (BODY + SOLID + "[axes]\nvelocity = { logarithmic = [0, 1], n = 3 }\n", "axes.velocity: low = 0: must be finite and > 0"),
        (BODY + SOLID + "[axes]\nvelocity = { linear = [0, 1], n = 3 }\n", "axes.velocity = 0 m/s: must be finite and > 0"),
        (BODY + SOLID + AXES + "pace = [1]\n", "axes.pace: unknown quantity; known are velocity, "),
        (BODY + SOLID + "[axes]\nvelo = ['1 m/s']\n", "axes.velo: unknown quantity; did you mean velocity?"),
        (BODY + SOLID + "[axes]\nimpct.velocity = [1]\n", "axes.impct: unknown quantity; did you mean impact?"),
        (BODY + SOLID + "[axes]\nimpact.velo = { linear = ['1 m/s', 2], n = 2 }\n", "axes.impact.velo"),
        (BODY + SOLID + "[axes]\nvelocity = { linea = [1, 2], n = 2 }\n", "axes.velocity.linea: unknown key; did you mean linear?"),
        (BODY + SOLID + "[axes]\nimpact.velocity = { linea = [1, 2], n = 2 }\n", "axes.impact.velocity.linea: unknown key; did"),
        (
            BODY + SOLID + IMPACT + "[axes]\nbody.radius = { from = '1 mm', to = '2 mm' }\n",
            "axes.body.radius.from: radius is no table; a range is written { linear = [low, high], n = 5 }",
        ),
        (BODY + SOLID + AXES + "[samples]\nn = 4\nmas = { uniform = [1, 2] }\n", "samples.mas: unknown quantity; did you mean mass?"),
        (
            BODY + SOLID + "[axes]\nvelocity = { linear = [1, 2], n = 1000000000000000000 }\n",
            "axes.velocity: n = 1000000000000000000: must be at most 100000000, the most points along one axis",
        ),
        (BODY + SOLID + "[axes]\nvelocity = [1, true]\n", "velocity[1] = True: must be a real number"),
        (BODY + SOLID + AXES + "relaxation_time = [1]\nviscosity = [1]\n", "axes: relaxation_time and viscosity set the same"),
        (BODY + SOLID + AXES + "impact.pace = [1]\n", "impact.pace = 1: unknown key"),
        (BODY + SOLID + AXES + "impact.velocity = [1]\n", "axes: impact.velocity is there twice"),
        (BODY + SOLID + AXES + "drop_height = [1]\n", "axes: impact.velocity and impact.drop_height"),
        (BODY + SOLID + AXES + 'material.shear."relaxation_times[3]" = [1]\n', "axes.material.shear.relaxation_times[3]: there is no"),
        (BODY + SOLID + AXES + "[samples]\nmass = { uniform = [1, 2] }\n", "samples.n: is missing; it is the number of draws"),
        (BODY + SOLID + AXES + "[samples]\nn = 4\nmass = [1, 2]\n", "samples.mass: must be a table with one of uniform, "),
        (BODY + SOLID + AXES + "[samples]\nn = 4\nmass = { uniform = [2, 1] }\n", "samples.mass: low = 2, high = 1: must ascend"),
        (BODY + SOLID + AXES + "[samples]\nn = 4\nseed = 1.5\nmass = { uniform = [1, 2] }\n", "samples: seed = 1.5: must be a whole"),
        (BODY + SOLID + AXES + "[sweep]\noutputs = ['e']\n", 'sweep.outputs = ["e"]: unknown output \'e\'; known are rest'),
        (BODY + SOLID + AXES + "[sweep]\noutputs = 'max_force'\n", 'sweep.outputs = "max_force": must be a list'),
        (BODY + SOLID + AXES + "solver.rtol = [1, 2]\n", "axes.solver.rtol: unknown quantity; known are body"),
        (BODY + SOLID + AXES + "[sweep]\nchunk = 0\n", "chunk = 0: must be a whole number >= 1"),
        (BODY + SOLID + AXES + "[sweep]\nchunks = 3\n", "sweep.chunks = 3: unknown key; did you mean chunk?"),
        (BODY + SOLID + AXES + "[solver]\nmethod = 'elements'\n", 'solver.method = "elements": must be "exact" in a sweep'),
        ("[axes]\nnu = 0.3\np3 = [1]\n", "axes: p2: is missing; or give body, material and impact"),
        (BODY + AXES, "material: the section is missing"),
        (BODY + IMPACT + "[material]\nlibrary = 'epoxy'\n[axes]\np2 = [1]\n", "axes.p2: belongs to a standard solid, which"),
    ],
)  # fmt: skip
def test_invalid_files_are_refused(text: str, message: str) -> None:
    refuses(text, message)


@pytest.mark.parametrize("axis", ["'[0.5, 2] m/s'", "{ linear = '[50, 200] cm/s', n = 2 }"])
def test_an_axis_may_be_one_text_as_other_lists(axis: str) -> None:
    assert sweep(BODY + SOLID + f"[axes]\nvelocity = {axis}\n").velocity.values.tolist() == [0.5, 2.0]


def test_sweep_files_of_the_documentation_are_computed() -> None:
    texts = blocks("docs/sweeps.md", "toml")
    assert len(texts) == 2
    for text in texts:
        with warnings.catch_warnings():
            warnings.simplefilter("error")
            assert int(sweep(re.sub(r"n = \d+", "n = 4", text)).status.max()) == 0
