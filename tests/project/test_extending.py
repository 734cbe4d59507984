"""The recipes of docs/development/extending.md work in Python, case files, sweeps and pictures."""

import sys
from types import ModuleType

import numpy as np
import pytest

import restitution as rs
from cases import case_file
from checkout import blocks
from refusals import in_one_line
from restitution import quantities, read_case
from restitution.calibration import laws
from restitution.case.sweep import read_sweep
from restitution.contact.geometry import Geometry
from restitution.material import models
from restitution.sweeps.run import run

PAGE = "docs/development/extending.md"
QUARTIC = {
    "body": 'mass = "5 g"', "profile": 'type = "quartic"\nlength = "10 mm"',
    "material": 'model = "two_decades"\nequilibrium_modulus = "1 MPa"\nbranch_modulus = "2 MPa"\n'
    'relaxation_time = "1 ms"\npoisson_ratio = 0.45',
}  # fmt: skip
AXES = """
[axes]
profile.length = ["10 mm", "20 mm"]
material.relaxation_time = { logarithmic = ["0.1 ms", "10 ms"], n = 3 }
[sweep]
outputs = ["max_force", "max_deceleration"]
"""


@pytest.fixture
def extension(monkeypatch):
    """Names that the page defines; the registries are restored afterwards."""
    models.material_models()  # fills the registry
    monkeypatch.setattr(Geometry, "registered", dict(Geometry.registered))
    monkeypatch.setattr(models, "_MODELS", dict(models._MODELS))
    before = dict(quantities.OUTPUTS)
    module = ModuleType("extension")
    monkeypatch.setitem(sys.modules, "extension", module)
    try:
        for block in blocks(PAGE, "python"):
            exec(compile(block, PAGE, "exec"), module.__dict__)
        yield module
    finally:
        quantities.OUTPUTS.clear()
        quantities.OUTPUTS.update(before)
        laws.LAWS.pop("damping-ratio", None)


def test_one_definition_serves_python_case_files_sweeps_and_pictures(extension, tmp_path):
    solid = extension.two_decades(1e6, 2e6, 1e-3, poisson_ratio=0.45)
    result = rs.solve(rs.Impact(solid, extension.Quartic(0.01), mass=0.005, velocity=1.0))
    same = rs.solve(rs.Impact(solid, rs.PowerLaw(4.0, 0.01**-3), mass=0.005, velocity=1.0))
    assert result.restitution_coefficient == pytest.approx(same.restitution_coefficient, rel=1e-7)
    assert result.outputs["max_deceleration"] == pytest.approx(result.max_force / 0.005, rel=1e-14)
    assert "max_deceleration" in result.to_dict()

    file = tmp_path / "case.toml"
    case_file(file, **QUARTIC)
    from_file = read_case(file).solve()
    assert from_file.restitution_coefficient == pytest.approx(result.restitution_coefficient, rel=1e-12)

    file.write_text(case_file(**QUARTIC) + AXES)
    swept = run(read_sweep(file))
    np.testing.assert_allclose(swept.max_deceleration, swept.max_force / 0.005, rtol=1e-14)
    assert swept.max_deceleration.attrs["units"] == "m/s^2"
    middle = swept.max_force.isel({swept.max_force.dims[0]: 0, swept.max_force.dims[1]: 1})
    assert float(middle) == pytest.approx(result.max_force, rel=1e-7)

    figure = rs.plot_sweep(swept, ["max_deceleration"])
    words = " ".join(axes.get_ylabel() + axes.get_title() for axes in figure.axes)
    assert "deceleration" in words


def test_many_impacts_have_the_output(extension):
    solid = extension.two_decades(1e6, 2e6, 1e-3, poisson_ratio=0.45)
    impact = rs.Impact(solid, rs.Parabola(0.01), mass=0.005, velocity=[0.05, 0.1])
    result = rs.solve(impact)
    np.testing.assert_allclose(result.outputs["max_deceleration"], result.max_force / 0.005, rtol=1e-14)


def test_a_contact_law_is_a_target(extension):
    ball = rs.Body(rs.kelvin_voigt(1e6, 50.0, poisson_ratio=0.5, density=1100.0), radius=0.005)
    calibration = rs.calibrate((ball, ball), "damping-ratio", 1.0)
    same = rs.calibrate((ball, ball), "lammps-coeff-restitution", 1.0)
    assert calibration.parameters["zeta"].value == pytest.approx(0.5 * same.law.strength, rel=1e-9)
    assert f"hertz {calibration.parameters['E'].value:.8g}" in calibration.snippet


@pytest.mark.parametrize(
    ("name", "derive", "field"),
    [
        ("max_force", lambda mass: mass, "name"),
        ("half_force", None, "derive"),
        ("half_force", lambda max_forse: max_forse, "derive"),
    ],
)
def test_an_output_that_cannot_be_derived_is_refused(name, derive, field):
    assert (
        in_one_line(
            lambda: quantities.register_output(quantities.Quantity(name, quantities.FORCE, "force", derive=derive))
        ).field
        == field
    )


def test_energies_need_the_quadrature():
    assert quantities.needs(["energy_residual"], quantities.ENERGIES)
    assert not quantities.needs(["kinetic_energy_out", "mach_number"], quantities.ENERGIES)
