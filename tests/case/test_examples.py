"""Example cases against their sources; the page of keys against the sections."""

import csv
import math
import re
import runpy
from pathlib import Path

import numpy as np
import pytest

import restitution as rs
from checkout import EXAMPLES, ROOT, script
from refusals import named
from restitution.case.identification import read_design, read_identification
from restitution.case.impact import read_case
from restitution.case.sweep import read_sweep
from scipy_oracle import solve_by_scipy


def test_moduli_and_times_of_the_epoxy() -> None:
    epoxy = read_case(EXAMPLES / "epoxy.toml").impact.material
    # Simon, McKenna, Sindt 2000: glassy 891 MPa, rubbery 4.9 MPa, 24 terms with relative moduli of sum 1.
    assert epoxy.shear.n_branches == 24
    assert epoxy.shear.equilibrium_modulus == 4.9e6
    assert epoxy.shear.instantaneous_modulus == pytest.approx(891e6, rel=1e-14)
    assert epoxy.shear.branch_moduli[4] == pytest.approx(0.0267 * (891e6 - 4.9e6), rel=1e-13)
    assert epoxy.shear.relaxation_times[0] == 1e-7
    assert epoxy.shear.relaxation_times[-1] == 1e5
    assert epoxy.bulk.equilibrium_modulus == 3e9


def test_the_epoxy_carries_the_coefficients_of_its_source(shared_reference: Path) -> None:
    with (shared_reference / "materials" / "epoxy_prony.csv").open() as file:
        rows = np.array(list(csv.reader(file))[1:], dtype=float)
    shear = read_case(EXAMPLES / "epoxy.toml").impact.material.shear
    np.testing.assert_array_equal(shear.relaxation_times, rows[:, 0])
    np.testing.assert_allclose(shear.branch_moduli, rows[:, 1] * (891e6 - 4.9e6), rtol=1e-13)


@pytest.mark.parametrize("name", ["rubber_ball", "dropped_ball"])
def test_a_soft_ball_on_a_rigid_plate_has_no_warning_of_waves(name: str) -> None:
    case = read_case(EXAMPLES / f"{name}.toml")
    check = case.solve().validity["waves"]
    assert (check.value, check.exceeded) == (0.0, False)
    assert "the ball is not deeper" in check.message
    assert not case.bounces().validity["waves"].exceeded
    assert "on a rigid half-space" in case.arrangement


@pytest.mark.parametrize("sections", ['[profile]\nthickness = "1 mm"\n', '[counter_body]\nmass = "1 g"\n'])
def test_a_body_that_cannot_be_soft_is_refused(tmp_path: Path, sections: str) -> None:
    text = (EXAMPLES / "rubber_ball.toml").read_text(encoding="utf-8")
    path = tmp_path / "case.toml"
    layer = sections.startswith("[profile]")
    path.write_text(text.replace("[profile]\n", sections) if layer else text + sections, encoding="utf-8")
    assert named(lambda: read_case(path)) == ("impact.material_of", "body")


def test_the_page_of_keys_is_up_to_date() -> None:
    reference = script("docs/case_reference.py")
    # `python docs/case_reference.py` and every build of the pages write it.
    text = (ROOT / "docs" / "case_files.md").read_text(encoding="utf-8")
    assert reference.page() == text
    assert not re.findall(r"^\|.*\|\s*\|$", text, flags=re.MULTILINE), "a key without an explanation"


def test_two_beads_equal_the_collision_in_python() -> None:
    result = read_case(EXAMPLES / "two_beads.toml").solve()
    # On a half-space e of the same bead is 0.6458.
    rubber = rs.standard_solid(1e6, 5e6, 500.0, poisson_ratio=0.49, density=1100.0)
    bead = rs.Body(rubber, 1e-3)
    expected = rs.solve(rs.collision(bead, bead, 0.5)).restitution_coefficient
    assert result.restitution_coefficient == pytest.approx(expected, rel=1e-8)
    assert result.restitution_coefficient == pytest.approx(0.6793, abs=5e-5)


def test_the_sweep_is_computed() -> None:
    plan = read_sweep(EXAMPLES / "velocity_sweep.toml")
    assert plan.grid.shape == (40, 3)


@pytest.mark.parametrize("name", ["rubber_ball", pytest.param("epoxy", marks=pytest.mark.slow)])
def test_cases_agree_with_scipy(name: str) -> None:
    case = read_case(EXAMPLES / f"{name}.toml")
    result = case.solve()
    # SciPy's Radau for the same equations shares no code with the kernel; both have rtol 1e-9.
    expected = solve_by_scipy(case.impact, 1e-9).restitution_coefficient
    assert result.restitution_coefficient == pytest.approx(expected, rel=2e-9)
    # The energies come from a separate quadrature, with the bound of the whole package.
    assert abs(result.energy.residual) < 10 * result.rtol


def test_the_python_example_runs(capsys: pytest.CaptureFixture[str]) -> None:
    runpy.run_path(str(EXAMPLES / "restitution_over_velocity.py"))
    rows = np.array([line.split() for line in capsys.readouterr().out.splitlines()[1:]], dtype=float)
    assert rows.shape == (9, 3)
    assert np.all((rows[:, 1] > 0) & (rows[:, 1] < 1))


@pytest.mark.parametrize(
    ("name", "truth"),
    [
        ("balls", "RUBBER"),
        ("sound", "FOAM"),
        ("afm_curve", "GEL"),
        ("oscillations", "GEL"),
        ("grains", "GRAINS"),
        ("pull_off", "STICKY_GEL"),
    ],
)
@pytest.mark.filterwarnings("ignore:drag", "ignore:straight lines replace the depth")
def test_identified_materials_are_those_of_the_data(name: str, truth: str) -> None:
    folder = EXAMPLES / "identification"
    result = read_identification(folder / f"{name}.toml").solve()
    assert isinstance(result, rs.Identification)
    source = runpy.run_path(str(folder / "make_data.py"))
    space = result.problem.space
    best = dict(zip(space.names, space.numbers(result.coordinates[None]).T, strict=True))
    for parameter, value in source[truth].items():
        low, high = result.parameters[parameter].interval
        end, middle = high if value > best[parameter][0] else low, best[parameter][0]
        # Three standard errors of the logarithm; the 95 % interval has two on each side. An open end excludes nothing.
        assert 0.0 < low < high
        assert end == math.inf or abs(math.log(value / middle)) < 1.55 * abs(math.log(end / middle))
    if name == "afm_curve":
        point = result.nuisances["contact_point"]
        assert point.value is not None
        assert point.standard_error is not None
        assert abs(point.value - source["CONTACT"]) < 3.0 * point.standard_error


def test_the_design_example_gains_from_several_radii() -> None:
    result = read_design(EXAMPLES / "identification" / "design.toml").solve()
    # Several radii beat one ball by factors of 4 to 64 over a decade of velocities.
    assert result.repeats.sum() == 12
    assert result.gains[0.003] > 4.0
