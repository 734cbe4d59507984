"""Sections of profiles: every type against the same profile in Python, and refused sections."""

import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from cases import case_file
from refusals import named, refuses
from restitution import Ellipsoid, ForceLaw, Layer, Pyramid, Tabulated, read_case
from restitution.contact.geometry import Geometry
from restitution.contact.profiles import Cone, FlatEndedParabola, FlatPunch, Parabola, PowerLaw, Sphere, TruncatedCone

CASE: dict[str, str | None] = {
    "body": 'mass = "1 g"\nradius = "1 mm"', "impact": 'velocity = "1 cm/s"',
    "material": 'shear = "1 MPa"\npoisson_ratio = 0.3',
}  # fmt: skip


@pytest.fixture(autouse=True)
def _tip(folder: Path) -> None:
    Path("tip.csv").write_text("# measured\nr [um],f_nm\n0,0\n1,10\n2,40\n\n3,90\n", encoding="utf-8")


def profile(text: str, **changes: str) -> Geometry:
    case_file("a.toml", **CASE | {"profile": text} | changes)
    return read_case("a.toml").impact.profile


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ('type = "parabola"', Parabola(1e-3)),
        ('type = "sphere"', Sphere(1e-3)),
        ('type = "sphere"\nradius = "2 mm"', Sphere(2e-3)),
        ('type = "cone"\nhalf_angle = "80 deg"', Cone(math.radians(80))),
        ('type = "cone"\nhalf_angle = 1.2', Cone(1.2)),
        ('type = "flat_punch"\nradius = "5 um"', FlatPunch(5e-6)),
        ('type = "truncated_cone"\nradius = 1e-6\nhalf_angle = "1.2 rad"', TruncatedCone(1e-6, 1.2)),
        ('type = "flat_ended_parabola"\nface_radius = 1e-6', FlatEndedParabola(1e-3, 1e-6)),
        ('type = "power_law"\nexponent = 3\ncoefficient = 7', PowerLaw(3, 7)),
        ('type = "tabulated"\nr = [0, 1, 2]\nf = [0, 1, 4]', Tabulated([0, 1, 2], [0, 1, 4])),
        ('type = "ellipsoid"\nradius_1 = "2 mm"\nradius_2 = 1e-3', Ellipsoid(2e-3, 1e-3)),
        ('type = "pyramid"\nface_angle = "75 deg"', Pyramid(math.radians(75))),
        ('type = "pyramid"\nface_angle = 1.3\nsides = 3', Pyramid(1.3, sides=3)),
        ('thickness = "2 mm"\nbase = "frictionless"', Layer(Parabola(1e-3), 2e-3, "frictionless")),
        ('type = "sphere"\nthickness = 1e-3\nbase = "frictionless"', Layer(Sphere(1e-3), 1e-3, "frictionless")),
    ],
)
def test_every_type(text: str, expected: Geometry) -> None:
    assert profile(text) == expected


@pytest.mark.parametrize(("text", "strict"), [("", False), ("strict = false", False), ("strict = true", True)])
def test_a_layer_is_bonded_by_default_and_may_be_strict(text: str, strict: bool) -> None:
    geometry: Any = profile(f'type = "cone"\nhalf_angle = 1.3\nthickness = "2 mm"\n{text}')
    assert (geometry.profile, geometry.thickness, geometry.base) == (Cone(1.3), 2e-3, "bonded")
    assert geometry.strict is strict


def test_a_strict_layer_of_a_case_refuses_the_approximation() -> None:
    relaxing = 'equilibrium_modulus = "1 MPa"\nbranch_modulus = "3 MPa"\nviscosity = "1 kPa s"\npoisson_ratio = 0.3'
    assert named(lambda: profile('thickness = "2 mm"\nstrict = true', material=relaxing)) == ("material",)


def test_two_bodies_have_no_layer() -> None:
    other = 'mass = "1 g"\nradius = "1 mm"'
    assert named(lambda: profile('thickness = "2 mm"', counter_body=other)) == ("profile.thickness",)


def test_a_force_law_in_a_file_and_inline() -> None:
    d = np.linspace(0.0, 20e-6, 41)
    force = 4.0 / 3.0 * 4e6 * math.sqrt(1e-3) * d**1.5
    rows = "\n".join(f"{1e6 * x!r},{1e3 * y!r}" for x, y in zip(d.tolist(), force.tolist(), strict=True))
    Path("twin.csv").write_text(f"depth [um],force [mN]\n{rows}\n", encoding="utf-8")
    twin = 'type = "force_law"\nmodulus = "3 MPa"\npoisson_ratio = 0.3\n'
    expected = ForceLaw(d, force, modulus=3e6, poisson_ratio=0.3)
    for text in (
        'file = "twin.csv"',
        f"depth = {d.tolist()}\nforce = {force.tolist()}",
        'file = "twin.csv"\nexponent = 1.5',
    ):
        geometry: Any = profile(twin + text)
        assert float(geometry.stiffness_radius(1e-5)) == pytest.approx(
            float(expected.stiffness_radius(1e-5)), rel=1e-9
        )


def test_a_bad_row_of_a_force_law_is_named() -> None:
    d = np.linspace(1e-6, 20e-6, 41)
    force = 100.0 * d**1.5
    force[17] *= 1.2
    rows = "\n".join(f"{x!r},{y!r}" for x, y in zip(d.tolist(), force.tolist(), strict=True))
    Path("twin.csv").write_text(f"depth,force\n{rows}\n", encoding="utf-8")
    text = 'type = "force_law"\nmodulus = 3e6\npoisson_ratio = 0.3\nfile = "twin.csv"'
    refuses(lambda: profile(text), 'a.toml: profile.file = "twin.csv": force[17]')


def test_the_coefficient_of_a_power_law_has_the_unit_of_its_exponent() -> None:
    # f = A r^n: at r = 1 mm, A = 2 mm^(1-n) gives f = 2 mm for every n.
    for n, unit in ((1, ""), (1.5, " mm^-0.5"), (3, " 1/mm^2"), (2.5, " mm^(-3/2)")):
        geometry: Any = profile(f'type = "power_law"\nexponent = {n}\ncoefficient = "2{unit}"')
        assert float(geometry.shape(1e-3)) == pytest.approx(2e-3, rel=1e-14)


@pytest.mark.parametrize(
    "text",
    [
        "# measured\nr_um,f_nm\n0,0\n1,10\n2,40\n\n3,90\n",
        "r [um],f [nm]\n0,0\n1,10\n2,40\n3,90\n",
        "r,f\num,nm\n0,0\n1,10\n2,40\n3,90\n",
        "f;r\nnm;um\n0;0\n10,0;1,0\n40;2\n90;3\n",
        "r/um,f/nm\n0,0\n1,10\n2,40\n3,90\n",
        "# r_um f_nm\n0 0\n1 10\n2 40\n3 90\n",
    ],
)
def test_units_of_tables_as_in_tables_of_materials(text: str) -> None:
    Path("tip.csv").write_text(text, encoding="utf-8")
    for where in ('file = "tip.csv"', 'r = "[0, 1, 2, 3] um"\nf = "[0, 10, 40, 90] nm"'):
        geometry: Any = profile(where)
        np.testing.assert_allclose(geometry.r, [0, 1e-6, 2e-6, 3e-6], rtol=4e-16)
        np.testing.assert_allclose(geometry.f, [0, 1e-8, 4e-8, 9e-8], rtol=4e-16)


def test_a_table_needs_no_type() -> None:
    for text in ('file = "tip.csv"', "r = [0, 1]\nf = [0, 1]"):
        assert profile(text) == profile(f'type = "tabulated"\n{text}')


@pytest.mark.parametrize(
    ("text", "message"),
    [
        (
            'type = "cone"\nhalf_angle = 80',
            '.half_angle = 80: must be > 0 and < 1.5708 rad; write "80 deg" for degrees',
        ),
        ('type = "cone"\nhalf_angle = "80"', '.half_angle = "80": has no unit; write e.g. "80 deg"'),
        ('type = "cone"\nradius = 1', ".radius = 1: unknown key; known are type, half_angle"),
        (
            'type = "power_law"\nexponent = 3\ncoefficient = "1 mm^-1"',
            '.coefficient = "1 mm^-1": is a quantity of dimension 1 / [length], not a coefficient of r^3; '
            'write e.g. "50 m^(-2)", or a plain number in m^(-2)',
        ),
        ('type = "power_law"\nexponent = 3\ncoefficient = -2', ".coefficient = -2: must be finite and > 0"),
        ('type = "power_law"\nexponent = 0\ncoefficient = 1', ".exponent = 0: must be finite and > 0"),
        ('type = "flat_punch"', ".radius: is missing"),
        ('type = "flat_punch"\nradius = "-1 mm"', '.radius = "-1 mm": must be finite and > 0'),
        ('type = "flat_punch"\nradius = "1 g"', '.radius = "1 g": is a mass, not a length'),
        ('type = "sphere"\nradius = inf', ".radius = inf: must be finite and > 0"),
        (
            'type = "truncated_cone"\nradius = 1\nhalf_angle = "100 deg"',
            '.half_angle = "100 deg": must be > 0 and < 1.5708 rad',
        ),
        ('type = "flat_ended_parabola"\nface_radius = 0', ".face_radius = 0: must be finite and > 0"),
        ('type = "tabulated"', ": give file, or r and f"),
        (
            'half_angle = "80 deg"',
            '.half_angle = "80 deg": belongs to another type; give type = "cone" or "truncated_cone"',
        ),
        ("exponent = 2", '.exponent = 2: belongs to another type; give type = "power_law" or "force_law"'),
        ('type = "pyramid"\nface_angle = 1.3\nsides = 5', ".sides = 5: must be 3, 4 or 6"),
        ('thickness = "-1 mm"', '.thickness = "-1 mm": must be finite and > 0'),
        ('thickness = "1 mm"\nbase = "glued"', '.base = "glued": must be "bonded" or "frictionless"'),
        ('base = "bonded"', '.base = "bonded": belongs to a layer; give its thickness'),
        ("strict = true", ".strict = true: belongs to a layer; give its thickness"),
        ('thickness = 1\nstrict = "yes"', '.strict = "yes": must be true or false'),
        (
            'type = "pyramid"\nface_angle = 1\nthickness = 1',
            ".thickness = 1: unknown key; known are sides, face_angle",
        ),
        ('type = "ellipsoid"\nradius_1 = 1\nradius_2 = -1', ".radius_2 = -1: must be finite and > 0"),
        ('type = "force_law"\nmodulus = 1\npoisson_ratio = 0.3', ": give file, or depth and force"),
        ("r = [0, 1]", ": give file, or r and f"),
        ('type = "tabulated"\nfile = "t.csv"', '.file = "t.csv": no such file: t.csv'),
        ('type = "tabulated"\nfile = 3', '.file = 3: must be the name of a CSV file, e.g. "tip.csv"'),
        ('type = "tabulated"\nfile = "tip.csv"\nr = [0, 1]', ".r = [0, 1]: stands in the file already"),
        ('type = "tabulated"\nr = [0, 1]\nf = [1, 2]', ": r[0], f[0] = 0, 1 m: the table must start at r = 0, f = 0"),
        (
            "type = 3",
            '.type = 3: must be one of "parabola", "sphere", "cone", "power_law", "flat_punch", '
            '"truncated_cone", "flat_ended_parabola", "tabulated", "ellipsoid", "pyramid", "force_law"',
        ),
    ],
)
def test_invalid_sections_are_refused_in_one_line(text: str, message: str) -> None:
    refuses(lambda: profile(text), f"a.toml: profile{message}")


FORMS = 'write e.g. "r_mm,f_mm", "r [mm],f [mm]", or "r,f" and the units in a second line'


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("# nothing\n", "holds no numbers"),
        ("\n", "is empty"),
        ("r,f\n", "line 1: is followed by no numbers"),
        ("1,2\n3,4\n", "line 1: the columns have no names: must begin with a line of names"),
        ("r,h\n1,2\n", f"line 1: unknown column 'h'; {FORMS}"),
        ("r\n1\n", f"line 1: must name 2 columns; {FORMS}"),
        ("r,r\n1,1\n", f"line 1: must name 2 columns; {FORMS}"),
        ("r,f [s]\n1,2\n", "line 1: unit 's' of f: is a time, not a length"),
        ("r,f\nmm,g\n1,2\n", "line 2: unit 'g' of f: is a mass, not a length"),
        ("r,f\nmm\n1,2\n", "line 2: 1 units for 2 columns"),
        ("r,f\n0,0\n\n1,2,3\n", "line 4: 3 values: must be 2, one for each column"),
        ("r,f\n0,0\n1,half\n", "line 3: f = 'half': must be a number"),
        ("r,f\n0,0\n1,nan\n", "line 3: f = nan: must be finite"),
    ],
)
def test_malformed_tables_are_refused_with_the_line(text: str, message: str) -> None:
    Path("t.csv").write_text(text, encoding="utf-8")
    refuses(lambda: profile('type = "tabulated"\nfile = "t.csv"'), f'a.toml: profile.file = "t.csv": {message}')
