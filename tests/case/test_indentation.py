"""Case files of prescribed indentations: every form against the same call in Python, and refused files."""

import math
from pathlib import Path

import numpy as np
import pytest

from cases import TRIANGLE, press_file
from checkout import EXAMPLES
from refusals import refusal, refuses
from restitution import Adhesion, Material, Parabola, PronySeries, hold, indent, ramp, sine_arch, triangle
from restitution.case.indentation import read_indentation
from restitution.material.fractional import FractionalMaterial, fractional_zener

GEL = Material(PronySeries(60.0, [250.0], [0.3]), math.inf)


pytestmark = pytest.mark.usefixtures("folder")


def read(section, **sections):
    press_file("gel.toml", indentation=section, **sections)
    return read_indentation("gel.toml")


def test_several_loadings_and_a_spring_equal_the_same_calls_in_python():
    lists = 'depth = "[0, 1, 0.4, 1.2, 0] um"\ntime = "[0, 1, 1.5, 3, 4] s"\n'
    program = {"depth": [0.0, 1e-6, 4e-7, 1.2e-6, 0.0], "time": [0.0, 1.0, 1.5, 3.0, 4.0]}
    for line, options in (("", {}), ('spring_constant = "1 N/km"', {"spring_constant": 1e-3})):
        result, expected = read(lists + line).solve(), indent(GEL, Parabola(2.5e-6), **program, **options)
        assert result.max_force == pytest.approx(expected.max_force, rel=1e-12)
        assert result.contact_intervals == pytest.approx(expected.contact_intervals, rel=1e-12)
    assert result.prescribed == "base"


@pytest.mark.parametrize(
    ("lines", "options"),
    [
        ('depth = "[-150, 300, -1500] nm"', {"depth": [-1.5e-7, 3e-7, -1.5e-6]}),
        (
            'depth = "[-150, 300, -1500] nm"\nspring_constant = "0.5 N/km"',
            {"depth": [-1.5e-7, 3e-7, -1.5e-6], "spring_constant": 5e-4},
        ),
        ('force = "[0, 0.2, -1] nN"', {"force": [0.0, 2e-10, -1e-9]}),
    ],
)
def test_adhesion_has_a_section(lines, options):
    section = lines + '\ntime = [0, 1, 2]\n[adhesion]\nwork = "10 uJ/m2"\nrange = "100 nm"\n[solver]\nrtol = 1e-2'
    result = read(section).solve()
    expected = indent(
        GEL, Parabola(2.5e-6), time=[0.0, 1.0, 2.0], adhesion=Adhesion(1e-5, range=1e-7), rtol=1e-2, **options
    )
    # Decimal texts and binary numbers differ in the last digit.
    assert result.pull_off_force == pytest.approx(expected.pull_off_force, rel=1e-9)
    assert result.pull_off_force > 0.0
    assert result.prescribed == expected.prescribed


@pytest.mark.parametrize(
    ("section", "name", "history"),
    [
        (TRIANGLE, "depth", triangle(1e-6, 1.0)),
        (
            'force = "2 nN"\nshape = "triangle"\nloading_time = 1\nunloading_time = "500 ms"\nhold_time = "2 s"',
            "force",
            triangle(2e-9, 1.0, unloading_time=0.5, hold_time=2.0),
        ),
        ('depth = "1 um"\nshape = "ramp"\nduration = "3 s"', "depth", ramp(1e-6, 3.0)),
        ('force = 1e-9\nshape = "hold"\nduration = "3 s"', "force", hold(1e-9, 3.0)),
        (
            'depth = "1 um"\nshape = "hold"\nduration = "3 s"\nrise_time = "10 ms"',
            "depth",
            hold(1e-6, 3.0, rise_time=0.01),
        ),
        ('depth = "1 um"\nshape = "sine_arch"\nduration = "2 s"', "depth", sine_arch(1e-6, 2.0)),
        ('depth = "[0, 1, 0] um"\ntime = "[0, 1, 2] s"', "depth", triangle(1e-6, 1.0)),
        ('depth = [0, 1e-6, "0 nm"]\ntime = [0, 1, "2000 ms"]', "depth", triangle(1e-6, 1.0)),
    ],
)
def test_all_forms_equal_the_same_calls_in_python(section, name, history):
    case = read(section)
    assert (case.title, case.prescribed) == ("A gel", name)
    np.testing.assert_allclose(case.history.knots, history.knots, rtol=1e-15)
    np.testing.assert_allclose(case.history.coefficients, history.coefficients, rtol=1e-14)
    assert case.profile == Parabola(2.5e-6)
    assert case.material.shear == GEL.shear
    result, expected = case.solve(), indent(GEL, Parabola(2.5e-6), **{name: history})
    assert result.max_force == pytest.approx(expected.max_force, rel=1e-13)
    assert result.contact_end_time == pytest.approx(expected.contact_end_time, rel=1e-13)


@pytest.mark.parametrize(
    ("header", "name"), [("time_s,depth_um", "depth"), ("force [nN],time [ms]", "force"), ("depth,time", "depth")]
)
def test_a_file_names_what_it_prescribes(header, name):
    unit = {"time_s": 1.0, "depth_um": 1e6, "force [nN]": 1e9, "time [ms]": 1e3, "depth": 1.0, "time": 1.0}
    peak = 1e-6 if name == "depth" else 1e-9
    columns = [
        np.array([0.0, 1.0, 2.0]) * unit[cell] if "time" in cell else np.array([0.0, peak, 0.0]) * unit[cell]
        for cell in header.split(",")
    ]
    rows = [",".join(map(repr, row)) for row in np.array(columns).T.tolist()]
    Path("curve.csv").write_text("\n".join(["# measured", header, *rows]) + "\n", encoding="utf-8")
    case = read('file = "curve.csv"\nn_points = 11', solver="rtol = 1e-6")
    assert (case.prescribed, case.n_points, case.options) == (name, 11, {"rtol": 1e-6})
    np.testing.assert_allclose(case.history.knots, [0.0, 1.0, 2.0])
    assert case.history(1.0) == pytest.approx(peak, rel=1e-14)
    assert case.solve().rtol == 1e-6


@pytest.mark.parametrize(
    ("text", "name", "peak"),
    [
        ("t,d\ns,um\n0,0\n1,2\n2,0\n", "depth", 2e-6),
        ("t_ms;F_nN\n0;0\n1000;2,5\n2000;0\n", "force", 2.5e-9),
        ("time,force\nms,nN\n0,0\n1000,2\n2000,0\n", "force", 2e-9),
    ],
)
def test_symbols_and_a_line_of_units_head_a_file(text, name, peak):
    Path("curve.csv").write_text(text, encoding="utf-8")
    case = read('file = "curve.csv"')
    assert case.prescribed == name
    assert case.history.knots == pytest.approx([0.0, 1.0, 2.0])
    assert case.history(1.0) == pytest.approx(peak, rel=1e-14)


def test_fractional_materials_hold_for_the_history():
    springpot = 'model = "springpot"\ncoefficient = 100.0\nexponent = 0.3\nbulk_modulus = inf\n'
    section = 'force = "1 nN"\nshape = "hold"\nduration = "100 s"'
    case = read(section, material=springpot + "approximation_rtol = 1e-4\n")
    assert case.material.window[0] <= 1e-4
    assert case.material.window[1] >= 100.0
    # J(t) = t^alpha/(V Gamma(1 + alpha)) of the springpot; a^3 = (3 R/4) F J/4.
    result = case.solve()
    t = np.array([0.1, 1.0, 99.0])
    creep = t**0.3 / (100.0 * math.gamma(1.3))
    radius = result.sample(t).contact_radius.values
    assert radius**3 == pytest.approx(0.75 * 2.5e-6 * 1e-9 * creep / 4.0, rel=1e-3)


def test_assumptions_are_noted():
    assert read(TRIANGLE, material='library = "polyisobutylene"').notes()[0].startswith("polyisobutylene: ")
    assert read(TRIANGLE).notes() == []


@pytest.mark.parametrize(
    ("section", "message"),
    [
        ("", "indentation: give exactly one of depth and force; none is given"),
        (TRIANGLE + 'force = "1 nN"\n', "indentation: give exactly one of depth and force; depth and force are given"),
        ('depth = "1 um"\n', 'indentation.shape: is missing; one of "triangle", "ramp", "hold", "sine_arch", or give lists of depth and time'),
        ('depth = "1 um"\nshape = "square"', 'indentation.shape = "square": must be one of "triangle", "ramp", "hold", "sine_arch"'),
        ('depth = "1 um"\nshape = "triangle"', 'indentation.loading_time: is missing; shape = "triangle" needs it'),
        ('depth = "1 um"\nshape = "ramp"\nduration = 1\nhold_time = 1', 'indentation.hold_time = 1: does not go with shape = "ramp"; that takes duration'),
        (TRIANGLE + "time = [0, 1]", "indentation.time = [0, 1]: belongs to a list of depth; depth is one number"),
        ("depth = [0, 1e-6]", "indentation.time: is missing; it belongs to the list of depth"),
        ('depth = [0, 1e-6]\ntime = [0, 1]\nshape = "ramp"', 'indentation.shape = "ramp": belongs to one largest depth; depth is a list over time'),
        ("depth = [0, 1e-6]\ntime = [1, 0]", "time[1] = 0 s after 1 s: must ascend"),
        ("depth = [0, 1e-6]\ntime = [0]", "time, depth: must be two columns of equal length >= 2"),
        (TRIANGLE + "spring_constant = 0", "indentation.spring_constant = 0: must be finite and > 0"),
        (TRIANGLE + 'spring_constant = "1 N"', 'indentation.spring_constant = "1 N": is a force, not a stiffness'),
        ("force = [0, 1]\ntime = [0, 1]\nspring_constant = 1", "indentation.spring_constant = 1: goes with depth, that of the base of the spring"),
        ("force = [0, -1e-9]\ntime = [0, 1]", "indentation.force[1] = -1e-09: must be finite and >= 0 without [adhesion]"),
        ('depth = "1 nN"\nshape = "ramp"\nduration = 1', 'indentation.depth = "1 nN": is a force, not a length'),
        ('depth = "[0, 1] s"\ntime = [0, 1]', 'indentation.depth[0] = "0 s": is a time, not a length\ngel.toml: indentation.depth[1] = "1 s"'),
        ('depth = -1\nshape = "ramp"\nduration = 1', "indentation.depth = -1: must be finite and > 0"),
        (TRIANGLE + "n_points = 1", "indentation.n_points = 1: must be >= 2"),
        (TRIANGLE + "loadingtime = 1", "indentation.loadingtime = 1: unknown key; did you mean loading_time?"),
        ('file = "curve.csv"\ndepth = 1', "indentation.depth = 1: stands in the file already; leave one of the two out"),
        ('file = "curve.csv"', "indentation.file: no such file: curve.csv"),
        (TRIANGLE + "[solver]\nrtol = 1.0", "solver.rtol = 1: must be in [1e-11, 0.01]"),
        (TRIANGLE + "[body]\nmass = 1", "body: does not belong here; an impact is for `restitution solve`"),
        ("depth = [-1, 0]\ntime = [0, 1]\n[adhesion]\nwork = 1\nstress = 1\nrange = 1", "adhesion: give stress or range, not both"),
        ("depth = [0, 1]\ntime = [0, 1]\n[adhesion]\nwork = 1", "indentation.depth = 0 m: must begin outside of the attraction"),
        ("depth = [1e-6, 2e-6]\ntime = [0, 1]", "depth = 1e-06 m at the start: must be <= 0; a step has two points at the same time"),
    ],
)  # fmt: skip
def test_invalid_files_are_refused(section, message):
    refuses(lambda: read(section).solve(), f"gel.toml: {message}")


def test_an_indenter_has_its_own_radius():
    message = "gel.toml: profile.radius: is missing; an indenter has no body to take it from"
    assert str(refusal(lambda: read(TRIANGLE, profile='type = "sphere"'))) == message


def test_the_examples_are_solved():
    result = read_indentation(EXAMPLES / "afm_indent.toml").solve()
    # Independent quadrature, nine digits.
    assert result.max_force == pytest.approx(1.38541713e-9, rel=3.6e-9)
    creep = read_indentation(EXAMPLES / "creep_indent.toml")
    assert creep.n_points == 801
    result = creep.solve()
    assert result.contact_end_time == pytest.approx(10.01, rel=1e-12)
    assert result.max_contact_radius > 2e-4
    assert result.max_force == pytest.approx(0.02, rel=1e-12)


def test_a_fractional_material_holds_for_a_fast_ramp_before_a_long_hold():
    """The force at the end of the ramp is that of a material that holds from far shorter times on."""
    zener = (
        'model = "fractional_zener"\nequilibrium_modulus = "1 kPa"\nbranch_modulus = "10 kPa"\n'
        'relaxation_time = "1 s"\nexponent = 0.4\npoisson_ratio = 0.5\n'
    )
    ramp_time = 10.0 ** np.random.default_rng(5).uniform(-4.0, -2.0)
    section = f'depth = "0.1 um"\nshape = "hold"\nduration = "1000 s"\nrise_time = {ramp_time}'
    result = read(section, material=zener, solver="rtol = 1e-6").solve()
    assert not result.validity["window"].exceeded
    gel = FractionalMaterial(fractional_zener(1e3, 1e4, 1.0, 0.4), bulk=math.inf)
    history = hold(1e-7, 1000.0, rise_time=ramp_time)
    expected = indent(gel.within((1e-3 * ramp_time, 2e3)), Parabola(2.5e-6), depth=history, rtol=1e-6)
    # The terms and the solves are good to 1e-6 each.
    assert result.max_force == pytest.approx(expected.max_force, rel=1e-5)
