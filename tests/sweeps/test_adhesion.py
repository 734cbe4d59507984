"""Adhesive impacts by names of numbers: arrays, sweeps, files, derivatives, error bars, and the validity report."""

import math
from dataclasses import replace

import numpy as np
import pytest
import xarray as xr
from scipy.optimize import brentq

import restitution as rs
from refusals import in_one_line
from restitution.case.sweep import read_sweep
from restitution.case.uncertainty import propagate_case
from restitution.impact.adhesion import AdhesiveResult
from restitution.limits import RANGE_LIMIT, SLOPE_LIMIT
from restitution.sweeps.run import run
from restitution.variation import numbers_by_name

# Unit balls of soft bodies exceed the limits of the theory on purpose.
pytestmark = pytest.mark.filterwarnings("ignore::restitution.errors.RestitutionWarning")
RNG = np.random.default_rng()
ELASTIC = rs.Material(rs.PronySeries(0.25, [], []), bulk=math.inf)
# Row A6 of the prototype and a standard solid: E* = 1, and 1 + 4 exp(-t).
BALL = rs.Impact(ELASTIC, rs.Parabola(1.0), 1.0, 0.1217, adhesion=rs.Adhesion(0.01, 0.157768))
SOLID = replace(BALL, material=rs.Material(rs.PronySeries(0.25, [1.0], [1.0]), bulk=math.inf), velocity=0.5)


def of(impact):
    """Work, stress and range of an impact."""
    return [getattr(impact.adhesion, name) for name in ("work", "stress", "range")]


def test_numbers_of_adhesion_by_name():
    work, stress, reach = RNG.uniform(0.005, 0.02), RNG.uniform(0.1, 0.2), RNG.uniform(0.05, 0.1)
    assert of(rs.vary(BALL, {"work": work})) == [work, 0.157768, work / 0.157768]
    assert of(rs.vary(BALL, {"stress": stress})) == [0.01, stress, 0.01 / stress]
    assert of(rs.vary(BALL, {"range": reach})) == [0.01, 0.01 / reach, reach]
    by_range = replace(BALL, adhesion=rs.Adhesion(0.01, range=0.06))
    assert of(rs.vary(by_range, {"work": work})) == [work, work / 0.06, 0.06]
    assert of(rs.vary(by_range, {"work": work, "stress": stress})) == [work, stress, work / stress]
    plain = replace(BALL, adhesion=None)
    assert of(rs.vary(plain, {"work": work})) == [work, work / 0.4e-9, 0.4e-9]
    assert numbers_by_name(by_range, ["work", "range"]) == {"work": 0.01, "range": 0.06}
    assert in_one_line(lambda: rs.vary(plain, {"stress": 1.0})).field == "axes"
    assert "set the same" in str(in_one_line(lambda: rs.vary(BALL, {"stress": 1.0, "range": 1.0})))
    assert in_one_line(lambda: rs.vary(BALL, {"work": -1.0})).field == "work"
    assert in_one_line(lambda: numbers_by_name(plain, ["work"])).field == "names"


def test_a_sweep_has_the_impacts_of_single_solves():
    axes = {"work": [0.004, 0.01], "velocity": [0.02, 0.15], "radius": 1.0}
    names = ["restitution_coefficient", "pull_off_force", "zone_width", "radiated_energy", "range_ratio"]
    swept = rs.sweep(BALL, axes, names, rtol=1e-4)
    assert swept.pull_off_force.attrs["units"] == "N"
    for work in axes["work"]:
        for velocity in axes["velocity"]:
            single = rs.solve(replace(BALL, velocity=velocity, adhesion=rs.Adhesion(work, 0.157768)), rtol=1e-4)
            at = swept.sel(work=work, velocity=velocity)
            assert int(at.status) == single.status
            for name in names[:4]:
                assert float(at[name]) == pytest.approx(single.outputs[name], rel=1e-12, nan_ok=True)
            depth = single.max_indentation_depth
            assert float(at.range_ratio) == pytest.approx(work / 0.157768 / depth, rel=1e-12)
    # The slow one sticks.
    assert swept.status.values[1, 0] == rs.Status.CAPTURED
    assert swept.restitution_coefficient.values[1, 0] == 0.0


def test_arrays_by_name_and_sweeps_of_functions_agree():
    work = xr.DataArray([0.004, 0.01], dims="work", coords={"work": [0.004, 0.01]})
    result = rs.solve(rs.vary(BALL, {"work": work, "stress": 0.2}), rtol=1e-4)
    assert isinstance(result, AdhesiveResult)
    assert result.pull_off_force.dims == ("work",)

    def ball(work):
        return replace(BALL, adhesion=rs.Adhesion(work, 0.2))

    swept = rs.sweep(ball, {"work": [0.004, 0.01]}, ["pull_off_force"], rtol=1e-4)
    assert swept.pull_off_force.values == pytest.approx(result.pull_off_force.values, rel=1e-12)


def test_a_sweep_file_has_axes_of_adhesion(tmp_path):
    text = """
    [body]
    mass = 1
    radius = 1
    [material]
    shear = {equilibrium_modulus = 0.25, branch_moduli = [1], relaxation_times = [1]}
    bulk_modulus = "incompressible"
    [adhesion]
    work = 0.01
    stress = 0.2
    [impact]
    velocity = 0.5
    [axes]
    adhesion.work = ["4 mJ/m^2", 0.02]
    velocity = [0.4, 0.8]
    [sweep]
    outputs = ["restitution_coefficient", "touching_time"]
    [solver]
    rtol = 1e-4
    """
    path = tmp_path / "ball.toml"
    path.write_text(text)
    plan = read_sweep(path)
    assert plan.template.apart == ()
    swept = run(plan)
    direct = rs.solve(rs.vary(SOLID, {"work": [[0.004], [0.02]], "stress": 0.2, "velocity": [0.4, 0.8]}), rtol=1e-4)
    assert swept.restitution_coefficient.values == pytest.approx(direct.restitution_coefficient, rel=1e-12)
    assert swept.touching_time.values == pytest.approx(direct.touching_time, rel=1e-12)
    # The short names are clear, the range keeps the work, and a file without adhesion may have a work as an axis.
    by_range = text.replace("adhesion.work = [", "range = [0.05, 0.1] #")
    path.write_text(by_range)
    assert "leave one of the two out" in str(in_one_line(lambda: read_sweep(path)))
    path.write_text(by_range.replace("stress = 0.2\n", ""))
    assert of(read_sweep(path).impact) == [0.01, 0.01 / 0.05, 0.05]
    path.write_text(text.replace("[adhesion]\n    work = 0.01\n    stress = 0.2\n", ""))
    assert read_sweep(path).impact.adhesion.work == 0.004
    path.write_text(text.replace("adhesion.work = [", "adhesion.stress = [1]\n    adhesion.range = [1] #"))
    assert "set the same" in str(in_one_line(lambda: read_sweep(path)))


def test_outputs_of_adhesion_belong_to_adhesion():
    rule = in_one_line(lambda: rs.sweep(replace(BALL, adhesion=None), {"velocity": [1.0]}, ["pull_off_force"]))
    assert rule.field == "outputs"


def test_derivatives_keep_the_dimensions():
    # e has none: it stays where the units of mass, length or time change.
    powers = {
        "mass": (1, 0, 0), "velocity": (0, 1, -1), "radius": (0, 1, 0), "equilibrium_modulus": (1, -1, -2),
        "work": (1, 0, -2), "stress": (1, -1, -2),
    }  # fmt: skip
    by = rs.derivatives(BALL, list(powers), ["restitution_coefficient", "pull_off_force"], rtol=1e-5)
    units = {"restitution_coefficient": (0, 0, 0), "pull_off_force": (1, 1, -2)}
    for output, elasticities, errors in zip(by.outputs, by.elasticities, by.errors, strict=True):
        sums = np.array(list(powers.values())).T @ elasticities
        relative = errors * np.array([by.at[name] for name in by.inputs]) / by.values[output]
        assert sums == pytest.approx(np.array(units[output]), abs=float(4.0 * relative.sum()))
        assert relative.max() < 1e-2
    # A stronger attraction loses more.
    assert by["restitution_coefficient", "work"] < 0.0


def test_deviations_follow_from_derivatives():
    bars = rs.uncertainty(BALL, {"work": 1e-3, "velocity": 1e-3}, ["restitution_coefficient"], rtol=1e-5)
    by = rs.derivatives(BALL, ["work", "velocity"], ["restitution_coefficient"], rtol=1e-5)
    expected = 1e-3 * math.hypot(*by.matrix[0])
    assert bars["restitution_coefficient"].standard_deviation == pytest.approx(expected, rel=1e-3)


def test_a_case_file_has_standard_deviations_of_adhesion(tmp_path):
    text = """
    [body]
    mass = 1
    radius = 1
    [material]
    model = "elastic"
    shear_modulus = 0.25
    bulk_modulus = "incompressible"
    [adhesion]
    work = "10 +- 1 mJ/m^2"
    stress = 0.157768
    [impact]
    velocity = 0.1217
    [solver]
    rtol = 1e-5
    """
    path = tmp_path / "ball.toml"
    path.write_text(text)
    bars = propagate_case(rs.read_case(path))
    by = rs.derivatives(BALL, ["work"], ["restitution_coefficient"], rtol=1e-5)
    e = bars["restitution_coefficient"]
    # Both derivatives are known to their stated errors, some 5e-3 of them.
    assert e.standard_deviation == pytest.approx(1e-3 * abs(by["restitution_coefficient", "work"]), rel=1e-2)


def maugis_edge(radius, work, stress):
    """The edge c of the attraction around a contact radius (Maugis 1992), with E* = R = 1."""

    def excess(m):
        root = math.sqrt(m * m - 1.0)
        first = radius**2 / math.pi * (root + (m * m - 2.0) * math.acos(1.0 / m))
        return first + 4.0 * stress * radius / math.pi * (root * math.acos(1.0 / m) - m + 1.0) - work / stress

    return radius * brentq(excess, 1.0 + 1e-12, 1e3)


def test_the_report_compares_the_attraction():
    work, stress = RNG.uniform(0.005, 0.02), RNG.uniform(0.1, 0.3)
    impact = replace(BALL, adhesion=rs.Adhesion(work, stress), velocity=0.5)
    result = rs.solve(impact, rtol=1e-5)
    width = maugis_edge(result.max_contact_radius, work, stress) - result.max_contact_radius
    assert result.zone_width == pytest.approx(width, rel=1e-3)
    report = result.validity
    assert report["attraction"].value == pytest.approx(work / stress / width, rel=1e-3)
    assert report["attraction"].exceeded is bool(work / stress / width > SLOPE_LIMIT)
    lam = stress * (9.0 / (2.0 * math.pi * work)) ** (1.0 / 3.0)
    assert f"lambda {lam:.3g} at rest and {lam:.3g} at once" in report["attraction"].message
    assert report["range"].value == pytest.approx(work / stress / result.max_indentation_depth, rel=1e-9)
    assert not report["range"].exceeded
    assert report["roughness"].value is None
    assert report["roughness"].threshold == pytest.approx(work / stress)
    # Without adhesion none of the three is there.
    plain = rs.solve(replace(impact, adhesion=None)).validity
    assert not {check.kind for check in plain} & {"attraction", "range", "roughness"}


def test_a_range_beyond_the_depth_is_doubtful():
    # Slow and light: the depth that an elastic ball reaches is below the range.
    result = rs.solve(replace(BALL, mass=0.01, adhesion=rs.Adhesion(1e-3, 0.002)), rtol=1e-3)
    assert result.max_indentation_depth < 0.5 * RANGE_LIMIT
    assert result.validity["range"].exceeded
    assert "Vary the range" in result.validity["range"].warning


def test_several_impacts_warn_as_others_do():
    with pytest.warns(rs.RestitutionWarning, match=r"attraction: .* exceeded in 2 of 2"):
        result = rs.solve(rs.vary(SOLID, {"stress": [2.0, 3.0], "velocity": 1.0}), rtol=1e-3)
    assert result.validity["attraction"].exceeded
