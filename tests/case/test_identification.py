"""Case files of identifications and designs."""

from pathlib import Path

import numpy as np
import pytest

import restitution as rs
from cases import fit_file
from refusals import named, refusal
from restitution import LogNormal, read_case
from restitution.case.identification import read_design, read_identification
from restitution.case.section import CaseError

CASE = fit_file(
    identification="""
model = "standard_solid"
fixed = { poisson_ratio = 0.5 }
bounds = { viscosity = ["1 Pa s", "1 MPa s"] }
""",
    data='noise = { restitution_coefficient = ["0.5 %", 0.001], contact_time = "20 us" }',
)
TRUTH = {"equilibrium_modulus": 1e6, "branch_modulus": 1e7, "viscosity": 1e4}
MASS = 0.033


@pytest.fixture
def case(tmp_path: Path) -> Path:
    """Exact impacts of two masses over two decades of velocity."""
    solid = rs.standard_solid(**TRUTH, poisson_ratio=0.5)
    lines = ["velocity [m/s],mass [g],restitution_coefficient,contact_time [ms]"]
    for mass in (MASS, 30 * MASS):
        for v in np.geomspace(0.01, 1.0, 5):
            impact = rs.solve(rs.Impact(solid, rs.Parabola(0.01), mass, float(v)))
            lines.append(f"{v},{1e3 * mass},{impact.restitution_coefficient},{1e3 * impact.contact_time}")
    (tmp_path / "balls.csv").write_text("\n".join(lines))
    (tmp_path / "case.toml").write_text(CASE)
    return tmp_path / "case.toml"


def test_units_and_noise(case: Path) -> None:
    read = read_identification(case)
    assert read.section.fixed == {"poisson_ratio": 0.5}
    assert read.section.bounds == {"viscosity": (1.0, 1e6)}
    (balls,) = read.data
    assert balls.noise.deviations == {"restitution_coefficient": ("0.5 %", 0.001), "contact_time": 20e-6}
    assert balls.size == 20


def test_the_material_is_found_and_read_back_by_solve(case: Path) -> None:
    fit = read_identification(case).solve()
    for name, value in TRUTH.items():
        assert fit.parameters[name].value == pytest.approx(value, rel=1e-5)
    again = read_case(fit.to_toml(case.with_name("material.toml")))
    assert "balls.csv" in again.path.read_text()
    assert again.impact.material.window == pytest.approx(fit.material.window, rel=1e-12)
    # The data determine the material for their own impacts.
    (balls,) = read_identification(case).data
    for velocity in (balls.velocity.min(), balls.velocity.max()):
        impact = rs.Impact(fit.material, rs.Parabola(0.01), MASS, float(velocity))
        assert not rs.solve(impact).validity["window"].exceeded
    # The first ball of the data.
    reference = rs.solve(rs.Impact(fit.material, rs.Parabola(0.01), MASS, 0.01)).restitution_coefficient
    assert again.solve().restitution_coefficient == pytest.approx(reference, rel=1e-12)


def test_several_terms_are_read_back_too(case: Path) -> None:
    case.write_text(
        CASE.replace('"standard_solid"', '"generalised_maxwell"\nterms = 1').replace("\nbounds", "\n# bounds")
    )
    fit = read_identification(case).solve()
    series = read_case(fit.to_toml(case.with_name("material.toml"))).impact.material.shear
    np.testing.assert_allclose(series.branch_moduli, [1e7], rtol=1e-4)
    np.testing.assert_allclose(series.relaxation_times, [1e-3], rtol=1e-4)


def test_models_are_compared(case: Path) -> None:
    assert read_identification(case).compare() is None
    case.write_text(CASE.replace("fixed =", 'compare = ["elastic"]\nfixed ='))
    compared = read_identification(case).compare()
    assert compared is not None
    assert list(compared.results) == ["standard_solid", "elastic"]
    case.write_text(CASE.replace("fixed =", 'compare = ["elastik"]\nfixed ='))
    assert named(lambda: read_identification(case)) == ("identification.compare", ["elastik"])


def test_priors_and_shifts(case: Path) -> None:
    text = CASE.replace("fixed = { poisson_ratio = 0.5 }", 'prior = { bulk_modulus = { lognormal = ["2 GPa", 0.2] } }')
    case.write_text(text)
    assert read_identification(case).section.prior == {"bulk_modulus": LogNormal(2e9, 0.2)}
    case.write_text(CASE.replace("fixed", 'shift = "wlf"\nfixed'))
    assert read_identification(case).section.options["shift"] is rs.WLF


@pytest.mark.parametrize(
    ("old", "new", "expected"),
    [
        ('"standard_solid"', '"standard_sold"', ("identification.model", "standard_sold")),
        (
            '"standard_solid"',
            '"standard_solid"\nstart = { poisson_ratio = 0.4 }',
            ("identification.start.poisson_ratio",),
        ),
        ("poisson_ratio = 0.5", "poisson = 0.5", ("identification.fixed.poisson",)),
        ("0.5 }", '"1 kg" }', ("identification.fixed.poisson_ratio", "1 kg")),
        ('"rebounds"', '"bounces"', ("data[0].kind", "bounces")),
        ('"balls.csv"', '"ball.csv"', ("data[0].file", "ball.csv")),
        ("radius =", "radios =", ("data[0].radios", "10 mm")),
        ('radius = "10 mm"', 'profile = { type = "sphere" }', ("data[0].profile.radius",)),
        ('"20 us"', '"20 N"', ("data[0].noise.contact_time", "20 N")),
        ("viscosity =", "viscous =", ("identification.bounds.viscous", ["1 Pa s", "1 MPa s"])),
        ("[[data]]", "[body]\nmass = 1\n[[data]]", ("body", {"mass": 1})),
        ('radius = "10 mm"', 'radius = "-10 mm"', ("data[0].radius", "-10 mm")),
        ("radius =", 'counter_material = "alike"\nradius =', ("data[0].counter_material", "alike")),
        ("radius =", "counter_material = { shear = -1 }\nradius =", ("data[0].counter_material.shear", -1)),
        (
            "radius =",
            'counter_material = { model = "springpot", coefficient = 1, exponent = 0.3, poisson_ratio = 0.5 }\nradius =',
            ("data[0].counter_material",),
        ),
    ],
)
def test_wrong_files_are_refused(case: Path, old: str, new: str, expected: tuple[object, ...]) -> None:
    case.write_text(CASE.replace(old, new))
    assert named(lambda: read_identification(case).solve()) == expected


def test_the_message_of_a_wrong_value_has_the_line_of_the_file(case: Path) -> None:
    table = case.with_name("balls.csv")
    table.write_text(table.read_text().replace("0.01,33.0,", "-0.01,33.0,", 1))
    with pytest.raises(CaseError, match=r'data\[0\]\.file = "balls\.csv": line 2: velocity = -0\.01'):
        read_identification(case)


DESIGN = """
[material]
equilibrium_modulus = "1 MPa"
branch_modulus = "10 MPa"
viscosity = "10 kPa s"
poisson_ratio = 0.5

[design]
velocity = { logarithmic = ["10 cm/s", "10 m/s"], n = 3 }
radius = "[3, 30] mm"
density = 7800
n = 6
"""


def test_the_design_of_a_file_is_that_of_the_function(tmp_path: Path) -> None:
    from functools import partial

    file = tmp_path / "design.toml"
    file.write_text(DESIGN)
    read = read_design(file)
    np.testing.assert_allclose(read.section.velocity, [0.1, 1.0, 10.0])
    np.testing.assert_allclose(read.section.radius, [3e-3, 30e-3])
    guess = partial(rs.standard_solid, 1e6, 1e7, 1e4, poisson_ratio=0.5)
    reference = rs.design(guess, {"velocity": [0.1, 1.0, 10.0], "radius": [3e-3, 30e-3], "density": 7800.0}, n=6)
    fit = read.solve()
    np.testing.assert_allclose(fit.velocity, reference.velocity)
    np.testing.assert_array_equal(fit.repeats, reference.repeats)


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ("density = 7800\n", "", "give exactly one of density and mass; none is given"),
        ('radius = "[3, 30] mm"', 'radius = "[3, 30] g"', "design.radius"),
        ('equilibrium_modulus = "1 MPa"', "", "material.equilibrium_modulus: is missing"),
        ("n = 6", "n = 0", "design.n = 0: must be >= 1"),
        ('radius = "[3, 30] mm"', "radius = []", "design.radius = []: must hold at least one value"),
        ('radius = "[3, 30] mm"', 'radius = ["3 mm", "-3 mm"]', "design.radius[1] = -0.003 m: must be finite and > 0"),
    ],
)
def test_a_wrong_design_is_refused(tmp_path: Path, old: str, new: str, message: str) -> None:
    file = tmp_path / "design.toml"
    file.write_text(DESIGN.replace(old, new))
    assert message in str(refusal(lambda: read_design(file)))


@pytest.mark.parametrize(
    ("kind", "table", "expected"),
    [
        # A shape is no number of a row.
        ("indentation", "time [s],depth [nm],force [nN]\n" + "1,1,1\n" * 40, "data[0].profile: is missing"),
        (
            "moduli",
            "time [s],relaxation modulus [MPa]\n0.1,2\n1,1.5\n10,1.2\n100,1.1\n",
            'data[0].deformation: must be "shear" or "tension", as the data do not state it',
        ),
    ],
)
def test_what_is_missing_has_no_value(tmp_path: Path, kind: str, table: str, expected: str) -> None:
    (tmp_path / "t.csv").write_text(table)
    file = tmp_path / "fit.toml"
    file.write_text(f'[identification]\nmodel = "kelvin_voigt"\n[[data]]\nkind = "{kind}"\nfile = "t.csv"\n')
    assert str(refusal(lambda: read_identification(file).solve())).endswith(expected)
