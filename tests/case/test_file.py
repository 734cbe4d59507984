"""Case files of impacts: their meaning in SI, and all mistakes of a file at once."""

import math
import pickle
import re
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import cases
import refusals
import restitution as rs
from refusals import refusal
from restitution import Case, Material, Parabola, PronySeries, read_case, standard_solid
from restitution.case.section import CaseError

BODY, SOLID, IMPACT = (
    f"[{name}]\n{lines}"
    for name, lines in (
        ("body", cases.BODY), ("material", cases.FAST), ("impact", cases.IMPACT)
    )
)  # fmt: skip
PRONY = """
[material]
bulk = "3 GPa"
[material.shear]
equilibrium_modulus = "1 MPa"
branch_moduli = "[2, 3, 4] MPa"
relaxation_times = [1e-3, "10 ms", 0.1]
"""
pytestmark = pytest.mark.usefixtures("folder")


def read(text: str) -> Case:
    Path("ball.toml").write_text(text, encoding="utf-8")
    return read_case("ball.toml")


def refuses(text: str, message: str) -> None:
    refusals.refuses(lambda: read(text), message)


def material(text: str) -> Any:
    return read(BODY + IMPACT + text).impact.material


def test_the_smallest_case() -> None:
    case = read(BODY + SOLID + IMPACT)
    assert case.impact.profile == Parabola(0.01)
    assert case.impact.material == standard_solid(1e6, 1e7, 1e3, poisson_ratio=0.45)
    assert (case.impact.mass, case.impact.velocity, case.impact.external_force) == (0.005, 1.0, 0.0)
    assert case.impact.counter_material is None
    assert case.options == {"method": "exact"}
    assert case.title is None


def test_units_and_plain_numbers_are_equivalent() -> None:
    plain = cases.case_file(
        body="mass = 0.005\nradius = 0.01", impact="velocity = 1",
        material="equilibrium_modulus = 1e6\nbranch_modulus = 1e7\nviscosity = 1000\npoisson_ratio = 0.45",
    )  # fmt: skip
    first, second = read(plain).impact, read(BODY + SOLID + IMPACT).impact
    for name in ("material", "profile", "mass", "velocity", "external_force"):
        assert getattr(first, name) == getattr(second, name)


def test_a_case_with_every_kind_of_key() -> None:
    case = read(
        """
        title = "All of it"
        [body]
        density = "1000 kg/m^3"
        radius = "10 mm"
        [profile]
        type = "parabola"
        radius = "20 mm"
        [impact]
        drop_height = "20 cm"
        gravity = 10
        weight = true
        [solver]
        method = "elements"
        rtol = 1e-3
        n_elements = 200
        time_step = "1 us"
        [counter_material]
        shear = "80 GPa"
        poisson_ratio = 0.3
        """
        + SOLID
        + 'density = "1.1 g/cm^3"\nname = "rubber"\n'
    )
    impact = case.impact
    assert case.title == "All of it"
    assert impact.profile == Parabola(0.02)
    mass = 1000.0 * 4.0 / 3.0 * math.pi * 1e-6
    assert impact.mass == pytest.approx(mass, rel=1e-15)
    assert impact.velocity == pytest.approx(2.0, rel=1e-15)
    assert impact.external_force == pytest.approx(10.0 * mass, rel=1e-15)
    assert case.options == {"method": "elements", "rtol": 1e-3, "n_elements": 200, "time_step": pytest.approx(1e-6)}
    assert impact.material.name == "rubber"
    assert impact.material.density == pytest.approx(1100.0, rel=1e-15)
    # K = 2 G (1 + nu)/(3 (1 - 2 nu))
    assert impact.counter_material.bulk.equilibrium_modulus == pytest.approx(80e9 * 2.6 / 1.2, rel=1e-15)


def test_bulk_in_all_its_forms() -> None:
    solid = SOLID.replace("poisson_ratio = 0.45\n", "")
    series = PRONY.replace('bulk = "3 GPa"\n', "{}")
    for text in ("bulk_modulus = inf", 'bulk_modulus = "incompressible"', "poisson_ratio = 0.5"):
        assert material(solid + text).bulk == math.inf
        assert material(series.format(text + "\n")).bulk == math.inf
    for text in ('bulk = "3 GPa"', "bulk_modulus = 3e9"):
        assert material(series.format(text + "\n")).bulk == PronySeries(3e9)
    bulk = "[material.bulk]\nequilibrium_modulus = 2e9\nbranch_moduli = [1e9]\nrelaxation_times = [1]\n"
    assert material(series.format("") + bulk).bulk == PronySeries(2e9, [1e9], [1.0])
    # Static: K = 2 G (1 + nu)/(3 (1 - 2 nu)) with G = 1 MPa at rest.
    static = material(series.format("poisson_ratio = 0.2\n"))
    assert static.bulk.equilibrium_modulus == pytest.approx(1e6 * 2.4 / 1.8, rel=1e-15)


def test_moduli_as_numbers() -> None:
    assert material(PRONY) == Material(PronySeries(1e6, [2e6, 3e6, 4e6], [1e-3, 1e-2, 0.1]), 3e9)


@pytest.mark.parametrize(
    ("ends", "numbers"),
    [
        ("instantaneous_modulus = 10e6", "branch_moduli = [2e6, 3e6]"),
        ("instantaneous_modulus = 10e6", "relative_moduli = [0.2, 0.3]"),
        ("equilibrium_modulus = 5e6", "relative_moduli = [0.2, 0.3]"),
        # With both end moduli given, the shares refer to the instantaneous modulus or to the difference.
        ("instantaneous_modulus = 10e6\nequilibrium_modulus = 5e6", "relative_moduli = [0.2, 0.3]"),
        ("instantaneous_modulus = 10e6\nequilibrium_modulus = 5e6", "relative_moduli = [0.4, 0.6]"),
    ],
)
def test_end_moduli(ends: str, numbers: str) -> None:
    shear = material(
        f"[material]\nbulk_modulus = inf\n[material.shear]\n{ends}\n{numbers}\nrelaxation_times = [1, 2]"
    ).shear
    assert shear.equilibrium_modulus == pytest.approx(5e6, rel=1e-14)
    np.testing.assert_allclose(shear.branch_moduli, [2e6, 3e6], rtol=1e-14)


def test_terms_are_looked_for_beside_the_case(folder: Path) -> None:
    (folder / "deep").mkdir()
    (folder / "deep" / "terms.csv").write_text("relaxation_time_ms,branch_modulus_MPa\n1,2\n")
    text = '[material]\nbulk_modulus = inf\n[material.shear]\nequilibrium_modulus = 1e6\nterms = "terms.csv"\n'
    (folder / "deep" / "ball.toml").write_text(BODY + IMPACT + text)
    assert read_case("deep/ball.toml").impact.material.shear == PronySeries(1e6, [2e6], [1e-3])


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ('radius = "10 mm"', 'radius = "10 s"', 'body.radius = "10 s": is a time, not a length'),
        ('radius = "10 mm"', 'radius = "-10 mm"', 'body.radius = "-10 mm": must be finite and > 0'),
        ('radius = "10 mm"', "radius = 0", "body.radius = 0: must be finite and > 0"),
        ('radius = "10 mm"', "radius = nan", "body.radius = nan: must be finite and > 0"),
        ('radius = "10 mm"', f"radius = 1{'0' * 400}", f"body.radius = 1{'0' * 58}…: must be finite and > 0"),
        ('radius = "10 mm"', "radius = true", "body.radius = true: must be a length"),
        ('radius = "10 mm"', "radius = [1, 2]", "body.radius = [1, 2]: must be a length"),
        ('radius = "10 mm"', "radius = 1979-05-27", "body.radius = 1979-05-27: must be a length"),
        ('radius = "10 mm"', 'raduis = "10 mm"', 'body.raduis = "10 mm": unknown key; did you mean radius?'),
        ('radius = "10 mm"', "colour = 1", "body.colour = 1: unknown key; known are mass, density, radius"),
        ('radius = "10 mm"', '"a\\nb" = 1', 'body."a\\nb" = 1: unknown key; known are mass, density, radius'),
        ('radius = "10 mm"', "", "body.radius: is missing; the profile takes its radius"),
        ('mass = "5 g"', "", "body: give exactly one of mass and density; none is given"),
        ('mass = "5 g"', 'mass = "5 g"\ndensity = 1000', "body: give exactly one of mass and density"),
        (BODY, "[body]\ndensity = 1000\n[profile]\nradius = 1\n", "body.radius: is missing"),
        (BODY, "", "body: the section is missing"),
        (BODY, "body = 3\n", "body = 3: must be a table"),
        (BODY, "[[body]]\n", "body = [{}]: must be a table"),
        ("[body]", "[boody]", "boody: unknown key; did you mean body?"),
        (
            "[body]",
            "[profile]\ntype = 'parabel'\n[body]",
            'profile.type = "parabel": must be one of "parabola", "sphere", "cone", "power_law", '
            '"flat_punch", "truncated_cone", "flat_ended_parabola", "tabulated"',
        ),
        ("poisson_ratio = 0.45", "poisson_ratio = 0.6", "material.poisson_ratio = 0.6: must be in [-1, 0.5]"),
        ("poisson_ratio = 0.45", "", "material: give exactly one of poisson_ratio and bulk_modulus; none is given"),
        ("poisson_ratio = 0.45", 'bulk_modulus = "-1 GPa"', 'material.bulk_modulus = "-1 GPa": must be in [0, inf]'),
        ('viscosity = "1 kPa s"\n', "", "material.viscosity: is missing"),
        ("viscosity", "viskosity", 'material.viskosity = "1 kPa s": unknown key; did you mean viscosity?'),
        ("viscosity", "sheer", 'material.sheer = "1 kPa s": unknown key; did you mean shear?'),
        ("[impact]", "[impact]\nweight = 1", "impact.weight = 1: must be true or false"),
        ("[impact]", "[impact]\nweight = true\nexternal_force = 1", "impact: give external_force or weight = true"),
        ('velocity = "1 m/s"', "", "impact: give exactly one of velocity and drop_height; none is given"),
        (
            "[impact]",
            '[solver]\nmethod = "exakt"\n[impact]',
            'solver.method = "exakt": must be one of "exact", "elements"',
        ),
        (
            "[impact]",
            "[solver]\nn_elements = 100\n[impact]",
            'solver.n_elements = 100: is an option of method = "elements", not of method = "exact"',
        ),
        ("[impact]", '[solver]\nmethod = "elements"\nn_elements = 0\n[impact]', "solver.n_elements = 0: must be >= 1"),
        ("[impact]", '[solver]\nmethod = "elements"\nn_elements = 1.5\n[impact]', "solver.n_elements = 1.5"),
        ("[body]", "title = 3\n[body]", "title = 3: must be text"),
        (
            'radius = "10 mm"',
            "radius = -1\nmass = -1\n".replace("mass", "density"),
            "body.density = -1: must be > 0\nball.toml: body.radius = -1: must be > 0",
        ),
    ],
)
def test_invalid_cases_are_refused_in_one_line(old: str, new: str, message: str) -> None:
    text = BODY + SOLID + IMPACT
    assert old in text
    refuses(text.replace(old, new, 1), f"ball.toml: {message}")


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ("0.1]", '"0.1 m"]', 'material.shear.relaxation_times[2] = "0.1 m": is a length, not a time'),
        ("0.1]", "-0.1]", "material.shear.relaxation_times[2] = -0.1: must be finite and > 0"),
        ('"[2, 3, 4] MPa"', '"[2, 3, -4] MPa"', 'material.shear.branch_moduli[2] = "-4 MPa": must be finite and >= 0'),
        ('"[2, 3, 4] MPa"', '"[2, 3] MPa"', "material.shear: 2 branch_moduli for 3 relaxation_times"),
        ('"[2, 3, 4] MPa"', "2", "material.shear.branch_moduli = 2: must be a list"),
        (
            '"[2, 3, 4] MPa"',
            '"2 MPa"',
            'material.shear.branch_moduli = "2 MPa": must be a list; write e.g. [1, 2, 3] or "[1, 2, 3] s"',
        ),
        (
            'branch_moduli = "[2, 3, 4] MPa"',
            "",
            "material.shear: give exactly one of branch_moduli, relative_moduli and terms; none is given",
        ),
        (
            "relaxation_times",
            "relaxation_time",
            'material.shear.relaxation_time = [0.001, "10 ms", 0.1]: unknown key; did you mean relaxation_times?',
        ),
        (
            'equilibrium_modulus = "1 MPa"',
            "",
            "material.shear: give exactly one of equilibrium_modulus and instantaneous_modulus; none is given",
        ),
        (
            'equilibrium_modulus = "1 MPa"',
            "instantaneous_modulus = 8e6",
            "material.shear: instantaneous_modulus = 8e+06 Pa: must be >= 9e+06 Pa, the sum of the terms",
        ),
        (
            'branch_moduli = "[2, 3, 4] MPa"',
            "relative_moduli = [0.2, 0.3, 0.6]",
            "material.shear: the relative moduli add up to 1.1: must be at most 1",
        ),
        (
            'branch_moduli = "[2, 3, 4] MPa"',
            "relative_moduli = [0.2, 0.3, 0.4]\ninstantaneous_modulus = 4e6",
            "material.shear: the relative moduli add up to 0.9: must be 1 "
            "(shares of the difference) or 0.75 (shares of the instantaneous modulus)",
        ),
        (
            'branch_moduli = "[2, 3, 4] MPa"',
            "relative_moduli = [0.2, 0.3, 0.4]\ninstantaneous_modulus = 4e5",
            'material.shear.equilibrium_modulus = "1 MPa": must be <= 400000 Pa, the instantaneous',
        ),
        ('branch_moduli = "[2, 3, 4] MPa"', 'terms = "none.csv"', 'material.shear.terms = "none.csv": no such file'),
        (
            'branch_moduli = "[2, 3, 4] MPa"',
            "terms = 1",
            'material.shear.terms = 1: must be the name of a file, e.g. "prony.csv"',
        ),
        (
            'bulk = "3 GPa"',
            'bulk = "3 GPa"\npoisson_ratio = 0.3',
            "material: give exactly one of bulk, bulk_modulus and poisson_ratio; bulk and poisson_ratio are given",
        ),
        ('bulk = "3 GPa"', 'bulk = "3 GPa m"', 'material.bulk = "3 GPa m": is a stiffness, not a modulus'),
        (
            'bulk = "3 GPa"',
            "bulk = {instantaneous_modulus = -1}",
            "material.bulk.instantaneous_modulus = -1: must be finite and > 0",
        ),
        (
            'bulk = "3 GPa"',
            'bulk = "3 GPa"\nviscosity = 1',
            "material.viscosity = 1: unknown key; known are name, density, shift, temperature, shear, bulk, bulk_modulus, "
            "poisson_ratio",
        ),
    ],
)
def test_invalid_prony_series_are_refused(old: str, new: str, message: str) -> None:
    assert old in PRONY
    refuses(BODY + IMPACT + PRONY.replace(old, new, 1), f"ball.toml: {message}")


def test_a_poisson_ratio_is_refused_for_a_liquid() -> None:
    # K = 2 Ginf (1 + nu)/(3 (1 - 2 nu)) gives no bulk modulus if Ginf is zero.
    text = BODY + IMPACT + SOLID.replace('equilibrium_modulus = "1 MPa"', "equilibrium_modulus = 0")
    error = refusal(lambda: read(text))
    assert error.field == "material.poisson_ratio"
    assert "liquid" in str(error)


def test_terms_given_twice_and_a_faulty_file_of_terms(folder: Path) -> None:
    (folder / "terms.csv").write_text("relaxation_time_s,branch_modulus_Pa\n1,-2\n")
    text = BODY + IMPACT + PRONY.replace('branch_moduli = "[2, 3, 4] MPa"', 'terms = "terms.csv"')
    refuses(
        text, 'ball.toml: material.shear.terms = "terms.csv": line 2: branch_modulus = -2: must be finite and >= 0'
    )
    (folder / "terms.csv").write_text("relaxation_time_s,branch_modulus_Pa\n1,2\n")
    refuses(
        text,
        'ball.toml: material.shear.relaxation_times = [0.001, "10 ms", 0.1]: stands in the file of terms '
        "already; leave one of the two out",
    )


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("[body]\nmass = 5 g\n", "line 2, column 10: not valid TOML"),
        ("[body]\nmass = \n", "line 2, column 8: not valid TOML: invalid value"),
        ("[body]\nmass = 'x", 'line 2, at the end: not valid TOML: expected "\'"'),
        ("[body]\nmass = 1\nmass = 2\n", "line 3, column 9: not valid TOML: cannot overwrite a value"),
        ("", "body: is missing\nball.toml: material: is missing\nball.toml: impact: is missing"),
    ],
)
def test_malformed_toml_is_refused(text: str, message: str) -> None:
    refuses(text, f"ball.toml: {message}")


def test_unreadable_files_are_refused() -> None:
    for name, message in (("none.toml", "no such file"), (".", "is a folder, not a case file")):
        with pytest.raises(CaseError, match=rf"^{re.escape(name)}: {message}\Z"):
            read_case(name)
    Path("ball.toml").write_bytes(b"\xff\xfe")
    with pytest.raises(CaseError, match=r"^ball\.toml: cannot be read: not a text file in UTF-8\Z"):
        read_case("ball.toml")
    refuses("a = " + "[" * 100_000, "ball.toml: not valid TOML: nested too deeply")


BEAD = """
[body]
radius = "0.5 mm"
density = "1200 kg/m^3"
[impact]
velocity = "0.5 m/s"
"""
RUBBER = rs.standard_solid(1e6, 1e7, 1e3, poisson_ratio=0.45, density=1200.0)


@pytest.mark.parametrize(
    ("text", "second"),
    [
        ('radius = "0.5 mm"\ndensity = 1200\n', rs.Body(RUBBER, 5e-4)),
        ('radius = "2 mm"\nmass = "3 g"\n', rs.Body(RUBBER, 2e-3, 3e-3)),
        ('mass = "3 g"\n', rs.Body(RUBBER, mass=3e-3)),
        ('radius = "2 mm"\nmass = "3 g"\nrigid = true\n', rs.Body(None, 2e-3, 3e-3)),
        (
            'radius = "2 mm"\nmass = "3 g"\n[counter_body.material]\nlibrary = "steel"\n',
            rs.Body(rs.library.get("steel"), 2e-3, 3e-3),
        ),
        (
            'radius = "2 mm"\nmass = "3 g"\n[counter_material]\nlibrary = "steel"\n',
            rs.Body(rs.library.get("steel"), 2e-3, 3e-3),
        ),
    ],
)
def test_two_bodies_equal_a_collision_in_python(text: str, second: rs.Body) -> None:
    case = read(BEAD + SOLID + f"[counter_body]\n{text}")
    collision = rs.collision(rs.Body(RUBBER, 5e-4), second, 0.5)
    assert case.impact.mass == pytest.approx(collision.mass, rel=1e-14)
    assert case.impact.profile.radius == pytest.approx(collision.profile.radius, rel=1e-14)
    assert (case.impact.counter_material is None) == (collision.counter_material is None)
    result, expected = case.solve(), rs.solve(collision)
    assert result.restitution_coefficient == pytest.approx(expected.restitution_coefficient, rel=1e-8)
    assert case.arrangement.startswith("two free bodies")


@pytest.mark.parametrize(
    ("profile", "motion", "words"),
    [
        ("", "", "a body on a half-space, one of the two rigid"),
        ("thickness = 0.005", "", "a rigid body on a layer"),
        ("", "impedance = 5.0", "a body on a plate or rod, one of the two rigid"),
    ],
)
def test_the_target_has_its_name(profile: str, motion: str, words: str) -> None:
    assert read(BEAD + f"{motion}\n" + SOLID + f"[profile]\n{profile}\n").arrangement == words


@pytest.mark.parametrize(
    ("text", "field"),
    [
        ('[profile]\ntype = "cone"\nhalf_angle = 1.2\n', "profile.type"),
        ('[counter_material]\nlibrary = "steel"\n[counter_body.material]\nlibrary = "steel"\n', "counter_body"),
    ],
)
def test_invalid_keys_of_two_bodies_are_refused(text: str, field: str) -> None:
    assert refusal(lambda: read(BEAD + SOLID + "[counter_body]\nmass = 1\nradius = 1\n" + text)).field == field


def test_all_mistakes_of_a_file_are_listed_up_to_ten() -> None:
    keys = "".join(f"wrong{n} = 1\n" for n in range(14))
    with pytest.raises(CaseError) as caught:
        read("[body]\n" + keys + SOLID + "[impact]\nvelocity = -1\n")
    assert [mistake.field for mistake in caught.value.mistakes[:14]] == [f"body.wrong{n}" for n in range(14)]
    assert caught.value.mistakes[-1].field == "impact.velocity"
    lines = str(caught.value).split("\n")
    assert len(lines) == 11
    assert all(line.startswith("ball.toml: ") for line in lines)
    again = pickle.loads(pickle.dumps(caught.value))
    assert str(again) == str(caught.value)


@pytest.mark.parametrize(
    "text",
    [
        "a." * 20_000 + "a = 1",
        '"a".' * 20_000 + "a = 1",
        "[" + "a." * 20_000 + "a]",
        "x" * 100_000,
        "a = " + "9" * 100_000,
        "a = " + "{a=" * 25_000,
        "'" * 100_000,
        "a = " + '"' + "1" * 100_000 + ',"',
        'body = {radius = "' + "1" * 90_000 + ' "}',
        'body = {radius = "1' + " " * 90_000 + "x y" + '"}',
    ],
)  # fmt: skip
def test_long_or_deeply_nested_files_are_refused(text: str) -> None:
    with pytest.raises(CaseError):
        read(text)
