"""Sections of materials: every form against the same material in Python, and refused sections."""

import math
import re
from pathlib import Path

import numpy as np
import pytest

from cases import case_file, isotherms_file
from refusals import named, refuses
from restitution import Case, Impact, Isotherms, Material, PronySeries, fit_prony, read_case, read_material, solve
from restitution.case.section import CaseError
from restitution.material import classical, library
from restitution.material.conversion import shear_from_tension
from restitution.material.fractional import FractionalMaterial, springpot
from restitution.material.shift import WLF, Arrhenius, ShiftTable

pytestmark = pytest.mark.usefixtures("folder")


def case(text: str) -> Case:
    case_file("a.toml", body='mass = "1 g"\nradius = "1 mm"', impact='velocity = "1 cm/s"', material=text)
    return read_case("a.toml")


def material(text: str) -> Material:
    return case(text).impact.material


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        (
            'model = "elastic"\nyoungs_modulus = "1 GPa"\npoisson_ratio = 0.3',
            classical.elastic(youngs_modulus=1e9, poisson_ratio=0.3),
        ),
        (
            'model = "maxwell"\nshear_modulus = "1 MPa"\nviscosity = 10\nbulk_modulus = inf',
            classical.maxwell(1e6, 10, bulk_modulus=math.inf),
        ),
        (
            'model = "kelvin_voigt"\nshear_modulus = 2\nviscosity = 3\nbulk_modulus = 5\nbulk_viscosity = 7',
            classical.kelvin_voigt(2, 3, bulk_modulus=5, bulk_viscosity=7),
        ),
        (
            'model = "standard_solid"\nequilibrium_modulus = 2\nbranch_modulus = 3\nviscosity = 5\n'
            "poisson_ratio = 0.2",
            classical.standard_solid(2, 3, 5, poisson_ratio=0.2),
        ),
        (
            'model = "burgers"\nmaxwell_modulus = 2\nmaxwell_viscosity = 3\nkelvin_modulus = 5\n'
            "kelvin_viscosity = 7\nbulk_modulus = 11",
            classical.burgers(2, 3, 5, 7, bulk_modulus=11),
        ),
        (
            'model = "generalised_maxwell"\nequilibrium_modulus = 2\nbranch_moduli = [3, 5]\n'
            'relaxation_times = "[7, 11] ms"\npoisson_ratio = 0.3\nname = "x"\ndensity = 13',
            classical.generalised_maxwell(2, [3, 5], [7e-3, 11e-3], poisson_ratio=0.3, name="x", density=13),
        ),
    ],
)
def test_classical_models(text: str, expected: Material) -> None:
    assert material(text) == expected


def test_materials_of_the_library() -> None:
    assert material('library = "epoxy"') == library.get("epoxy")
    warm = material('library = "polyisobutylene"\ntemperature = "30 degC"')
    # Ferry's shift factors: log10 aT = -8.61 (T - 298)/(200.4 + T - 298).
    factor = 10 ** (-8.61 * 5.15 / 205.55)
    cold = library.get("polyisobutylene").shear.relaxation_times
    np.testing.assert_allclose(warm.shear.relaxation_times, cold * factor, rtol=1e-12)
    assert material('library = "steel"\ndensity = 1\nname = "light"').density == 1.0


@pytest.mark.parametrize(
    ("text", "law"),
    [
        ('{reference_temperature = "25 degC", c1 = 8, c2 = "100 K"}', WLF(298.15, 8, 100)),
        ('{reference_temperature = 300, activation_energy = "80 kJ/mol"}', Arrhenius(300.0, 8e4)),
        ('"shift.csv"', ShiftTable([273.15, 293.15, 313.15], [1, 0, -2])),
    ],
)
def test_laws_of_the_shift(text: str, law: WLF | Arrhenius | ShiftTable) -> None:
    Path("shift.csv").write_text("T_C,log_aT\n0,1\n20,0\n40,-2\n")
    solid = material(
        f"shear = {{equilibrium_modulus = 1, branch_moduli = [2], relaxation_times = [3]}}\nbulk = inf\n"
        f'shift = {text}\ntemperature = "30 degC"'
    )
    assert solid.shift == law
    assert solid.temperature == pytest.approx(303.15)
    assert solid.shear.relaxation_times[0] == pytest.approx(3 * law.factor(303.15), rel=1e-12)


TERMS = "# E0 = 8 MPa\nrelaxation_time_s,relative_modulus\n1e-3,0.5\n1e-2,0.25\n"


def test_terms_in_tension_become_shear() -> None:
    Path("terms.csv").write_text(TERMS)
    tension = PronySeries(2e6, [4e6, 2e6], [1e-3, 1e-2])
    solid = material('file = "terms.csv"\nbulk_modulus = "10 MPa"')
    assert solid.shear == shear_from_tension(tension, bulk_modulus=1e7)
    assert solid.bulk == PronySeries(1e7)
    solid = material('file = "terms.csv"\npoisson_ratio = 0.25')
    # At all times G = E/(2 (1 + nu)) and K = E/(3 (1 - 2 nu)).
    np.testing.assert_allclose(solid.shear.branch_moduli, np.array([4e6, 2e6]) / 2.5, rtol=1e-14)
    assert isinstance(solid.bulk, PronySeries)
    np.testing.assert_allclose(solid.bulk.branch_moduli, np.array([4e6, 2e6]) / 1.5, rtol=1e-14)


def test_measured_data_are_fitted() -> None:
    truth = PronySeries(1e6, [3e6], [1e-2])
    t = np.geomspace(1e-4, 1, 41)
    rows = "\n".join(f"{a:.17g},{b:.17g}" for a, b in zip(t, truth.relaxation_modulus(t), strict=True))
    Path("relaxation.csv").write_text(f"t [s],G [Pa]\n{rows}\n")
    solid = material('file = "relaxation.csv"\nbulk_modulus = "1 GPa"\nmisfit = 1e-3')
    inside = np.geomspace(1e-3, 0.1, 9)
    np.testing.assert_allclose(solid.shear.relaxation_modulus(inside), truth.relaxation_modulus(inside), rtol=5e-3)
    assert solid.window == pytest.approx((1e-4, 1.0))
    assert solid.assumptions is not None
    assert "1 Prony term fitted to the data" in solid.assumptions


def test_a_deck_of_a_solver() -> None:
    Path("deck.inp").write_text("*ELASTIC, MODULI=INSTANTANEOUS\n 9, 0.5\n*VISCOELASTIC, TIME=PRONY\n 0.5, 0, 2\n")
    assert material('file = "deck.inp"').shear == PronySeries(1.5, [1.5], [2.0])
    assert material('file = "deck.inp"\nyoungs_modulus = 18').shear == PronySeries(3.0, [3.0], [2.0])


def test_the_measured_polymer(shared_reference: Path) -> None:
    file = shared_reference / "materials" / "polymer_dma_master_curve.csv"
    solid = material(f"file = '{file}'\nbulk_modulus = \"10 GPa\"")
    # The library's material is this one, fitted.
    expected = library.get("dma_polymer").shear
    t = np.geomspace(1e-8, 1e8, 9)
    np.testing.assert_allclose(solid.shear.relaxation_modulus(t), expected.relaxation_modulus(t), rtol=1e-3)


FRACTIONAL = 'model = "fractional_kelvin_voigt"\nequilibrium_modulus = "1 MPa"\ncoefficient = 1e4\n'
FRACTIONAL += "exponent = 0.4\nbulk_modulus = inf\n"


def test_a_fractional_model_is_accurate_in_the_window_of_its_contact() -> None:
    problem = case(FRACTIONAL + "approximation_rtol = 1e-8")
    result = problem.solve()
    window = result.impact.material.window
    duration = result.contact_time
    # The window comes from a first solution, which is accurate to a per cent.
    assert window == pytest.approx((1e-6 * duration, 2 * duration), rel=0.01)
    series = result.impact.material.shear
    t = np.geomspace(*window, 30)
    # G(t) = G + V t^-alpha/Gamma(1 - alpha)
    exact = 1e6 + 1e4 * t**-0.4 / math.gamma(0.6)
    np.testing.assert_allclose(series.relaxation_modulus(t), exact, rtol=1e-8)
    (note,) = problem.notes(result.impact)
    assert re.fullmatch(r"material: \d+ Prony terms stand for the fractional model, relative error \d\.\de-09", note)
    # A much wider window changes nothing.
    model = springpot(1e4, 0.4)
    wide, *_ = FractionalMaterial(type(model)(1e6, 1e4, 0.4), math.inf).approximation(
        (1e-9 * duration, 1e3 * duration), 1e-8
    )
    impact = result.impact
    expected = solve(Impact(material=wide, profile=impact.profile, mass=impact.mass, velocity=impact.velocity))
    assert result.restitution_coefficient == pytest.approx(expected.restitution_coefficient, rel=1e-7)


def test_a_fractional_model_at_a_temperature() -> None:
    law = 'shift = {reference_temperature = 300, c1 = 8, c2 = "100 K"}\ntemperature = 320'
    problem = case(FRACTIONAL + law)
    factor = 10 ** (-8 * 20 / 120)
    t = np.geomspace(*problem.impact.material.window, 30)
    exact = 1e6 + 1e4 * (t / factor) ** -0.4 / math.gamma(0.6)
    np.testing.assert_allclose(problem.impact.material.shear.relaxation_modulus(t), exact, rtol=1e-6)


def test_data_that_do_not_cover_the_contact_exceed_the_limit() -> None:
    Path("terms.csv").write_text(TERMS)
    problem = case('file = "terms.csv"\nbulk_modulus = inf\nname = "gel"')
    result = problem.solve()
    result.impact.material.__dict__["window"] = (1.0, 10.0)
    assert result.contact_time < 1.0
    assert result.validity["window"].exceeded
    assert "1 s to 10 s" in result.validity["window"].message


TWO = """*MATERIAL, NAME=A
*ELASTIC, MODULI=INSTANTANEOUS
 9, 0.5
*VISCOELASTIC, TIME=PRONY
 0.5, 0, 2
*MATERIAL, NAME=B
*ELASTIC
 21, 0.25
"""


def test_one_of_the_materials_of_a_deck() -> None:
    Path("two.inp").write_text(TWO)
    # G = E/(2 (1 + nu)); half of A relaxes.
    assert material('file = "two.inp"\nmaterial_name = "A"').shear == PronySeries(1.5, [1.5], [2.0])
    assert material('file = "two.inp"\nmaterial_name = "b"').shear == PronySeries(8.4)


FILES = {
    "terms.csv": TERMS,
    "unsaid.csv": "relaxation_time_s,relative_modulus\n1,0.5\n",
    "bad.csv": "relaxation_time_s,relative_modulus\n1,-0.5\n",
    "shift.csv": "T_C,log_aT\n0,1\n20,0\n40,-2\n",
    "deck.inp": "*VISCOELASTIC, TIME=PRONY\n 0.5, 0, 2\n",
    "two.inp": TWO,
    "relaxation.csv": "t [s],G [Pa]\n1,2\n2,1\n",
}


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ('library = "steal"', '.library = "steal": is not known; did you mean steel?'),
        ("library = 3", ".library = 3: must be text"),
        ('library = "ice"\ntemperature = 300', ": temperature: the material has no law of the shift"),
        ('library = "polyisobutylene"\ntemperature = "90 K"', ": temperature = 90 K: must be in [202, 400] K"),
        (
            'library = "ice"\ntemperature = "1 m"',
            '.temperature = "1 m": is a length, not a temperature; write e.g. "20 degC", or a plain number in K',
        ),
        ('library = "ice"\nshear = 3', ": give one of library, file, model and shear; library and shear are given"),
        ('library = "ice"\nshift = {c1 = 3}', ".shift.reference_temperature: is missing\na.toml: material.shift.c2"),
        ('library = "ice"\nshift = "none.csv"', '.shift = "none.csv": no such file'),
        ('library = "ice"\nshift = "terms.csv"', '.shift = "terms.csv": must hold temperatures and shift factors'),
        (
            'model = "jelly"',
            '.model = "jelly": must be one of "elastic", "maxwell", "kelvin_voigt", "standard_solid", '
            '"burgers", "generalised_maxwell", "springpot", "fractional_kelvin_voigt", "fractional_maxwell", '
            '"fractional_zener"',
        ),
        ('model = "maxwell"\nviscosity = 1\nbulk_modulus = 1', ".shear_modulus: is missing"),
        (
            'model = "maxwell"\nviscosity = 1\nbulk_modulus = 1\nshear_modulus = 1\nbranch_modulus = 2',
            ".branch_modulus = 2: unknown key; did you mean bulk_modulus?",
        ),
        (
            'model = "elastic"\nyoungs_modulus = "9 GPa"\nbulk_modulus = "1 GPa"',
            ": bulk_modulus = 1e+09 Pa: must be > 1e+09 Pa, a ninth of the instantaneous modulus in tension",
        ),
        (
            'model = "springpot"\ncoefficient = 1\nexponent = 1\nbulk_modulus = inf',
            ".exponent = 1: must be in [0.01, 0.99]",
        ),
        ('model = "springpot"\nexponent = 0.5\nbulk_modulus = inf', ".coefficient: is missing"),
        (
            'model = "springpot"\ncoefficient = 1\nexponent = 0.5\nbulk_modulus = inf\nbranch_modulus = 3',
            ".branch_modulus = 3: unknown key; did you mean bulk_modulus?",
        ),
        (
            'model = "springpot"\ncoefficient = 1\nexponent = 0.5\npoisson_ratio = 0.3',
            ".poisson_ratio = 0.3: must be 0.5 for a liquid (its equilibrium modulus is 0 Pa)",
        ),
        ('file = "none.csv"\nbulk_modulus = 1', '.file = "none.csv": no such file'),
        ("file = 3", '.file = 3: must be the name of a file, e.g. "dma.csv"'),
        (
            'file = "bad.csv"\nbulk_modulus = 1',
            '.file = "bad.csv": line 2: relative_modulus = -0.5: must be finite and >= 0',
        ),
        ('file = "shift.csv"\nbulk_modulus = 1', '.file = "shift.csv": holds shift factors and no moduli'),
        ('file = "unsaid.csv"\nbulk_modulus = 1', '.deformation: must be "tension" or "shear"'),
        (
            'file = "terms.csv"\nbulk_modulus = inf\ndeformation = "shear"',
            '.deformation = "shear": contradicts the data, which hold moduli in "tension"',
        ),
        (
            'file = "terms.csv"\nbulk_modulus = inf\nmisfit = 1',
            ".misfit = 1: has no meaning for Prony terms; known are equilibrium_modulus, "
            "instantaneous_modulus, deformation, bulk_modulus, poisson_ratio",
        ),
        ('file = "terms.csv"', ": give exactly one of bulk_modulus and poisson_ratio; none is given"),
        (
            'file = "unsaid.csv"\nbulk_modulus = inf\ndeformation = "shear"',
            ": instantaneous_modulus or equilibrium_modulus: one must be given, as the terms are relative",
        ),
        ('file = "deck.inp"', ".youngs_modulus: must be given, as the deck lacks it"),
        (
            'file = "relaxation.csv"\nbulk_modulus = inf',
            '.file = "relaxation.csv": must be at least 4 times over half a decade or more',
        ),
        ('file = "relaxation.csv"\nmaterial_name = "A"\nbulk_modulus = inf', '.file = "relaxation.csv"'),
        ('file = "two.inp"', '.file = "two.inp": has 2 materials: choose one by its name, A or B'),
        ('file = "two.inp"\nmaterial_name = "C"', ".file = \"two.inp\": has no material 'C': choose one by its name"),
        (
            'coefficient = "1e4"\nexponent = 0.4\nbulk_modulus = inf',
            '.coefficient = "1e4": is a constant of another model than the standard solid; '
            'give model = "springpot" or "fractional_kelvin_voigt"',
        ),
        (
            "equilibrium_modulus = 1\nbranch_modulus = 1\nrelaxation_time = 1\nexponent = 0.5",
            ".relaxation_time = 1: is a constant of another model than the standard solid; "
            'give model = "fractional_zener"',
        ),
        (
            "bulk_modulus = inf\n[material.shear]\ncoefficient = 1e4\nexponent = 0.4",
            '.shear.coefficient = 10000: does not belong here; model = "springpot"\n'
            'a.toml: material.shear.exponent = 0.4: does not belong here; model = "springpot"',
        ),
        (
            'library = "steel"\nshift = {reference_temperature = 300, c1 = 8, c2 = 100, temperature_range = [300]}',
            ".shift.temperature_range = [300]: must be two temperatures, the lowest and the highest",
        ),
        (
            'library = "steel"\nshift = {reference_temperature = 300, c1 = 8, c2 = 100, temperature_range = [310, 400]}',
            ".shift: temperature_range = (310, 400) K: must ascend and hold 300 K, the reference_temperature",
        ),
        (
            'library = "epoxy"\ntemperature = "80 degC"\n'
            'shift = {reference_temperature = 300, activation_energy = 1e5, temperature_range = "[0, 70] degC"}',
            '.temperature = "80 degC": must be in [273.15, 343.15] K, the range of the law',
        ),
        (
            'shear = {terms = "terms.csv"}\nbulk = inf',
            '.shear.terms = "terms.csv": holds moduli in tension; give it as material.file, which takes them to shear',
        ),
        (
            'shear = {terms = "deck.inp"}\nbulk = inf',
            '.shear.terms = "deck.inp": must hold Prony terms; give measured data and solver decks as material.file',
        ),
    ],
)
def test_invalid_sections_are_refused_in_one_line(text: str, message: str) -> None:
    for name, content in FILES.items():
        Path(name).write_text(content)
    refuses(lambda: material(text), f"a.toml: material{message}")


def test_the_counter_material_has_the_same_forms() -> None:
    impact = case('library = "epoxy"\n[counter_material]\nlibrary = "steel"').impact
    assert impact.counter_material == library.get("steel")
    Path("terms.csv").write_text(TERMS)
    assert read_material("terms.csv").deformation == "tension"


def test_a_file_with_several_temperatures() -> None:
    isotherms_file("dma.csv")
    isotherms = read_material("dma.csv")
    assert isinstance(isotherms, Isotherms)
    curve = isotherms.superposed(reference_temperature=293.15, shift="wlf")
    text = 'file = "dma.csv"\nbulk_modulus = "3 GPa"\nreference_temperature = "20 degC"\nsuperposition = "wlf"\n'
    solid = material(text)
    assert solid.shear == fit_prony(curve.data).series
    assert (solid.shift, solid.temperature) == (curve.shift, 293.15)
    warm = material(f'{text}temperature = "30 degC"')
    assert warm.shear.relaxation_times == pytest.approx(solid.shear.relaxation_times * curve.shift.factor(303.15))
    # The third of four temperatures and free shifts by default.
    assert material('file = "dma.csv"\nbulk_modulus = "3 GPa"').temperature == 303.15


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ('superposition = "vft"', ("superposition", "vft")),
        ("reference_temperature = 400", ("reference_temperature", 400)),
        ("shift = { reference_temperature = 300, c1 = 8, c2 = 100 }", ("shift",)),
        ("equilibrium_modulus = 1", ("equilibrium_modulus", 1)),
    ],
)
def test_refused_superpositions(text: str, expected: tuple[object, ...]) -> None:
    isotherms_file("dma.csv")
    field, *value = named(lambda: material(f'file = "dma.csv"\nbulk_modulus = "3 GPa"\n{text}'))
    assert (field.removeprefix("material."), *value) == expected


def test_a_single_temperature_takes_no_superposition() -> None:
    Path("t.csv").write_text("t,G\n1,3\n10,2\n100,1\n1000,1\n")
    with pytest.raises(CaseError, match=r"superposition.*has no meaning for measured data"):
        material('file = "t.csv"\nbulk_modulus = "3 GPa"\nsuperposition = "wlf"')


def test_the_window_of_the_data_is_kept() -> None:
    text = 'equilibrium_modulus = "1 MPa"\nbranch_modulus = "1 MPa"\nviscosity = 1e3\npoisson_ratio = 0.5\n'
    assert material(text + 'window = "[0.1, 10] ms"').window == pytest.approx((1e-4, 1e-2))
    for wrong in ('"[10, 0.1] ms"', '"[1] ms"', '"[0, 1] ms"', "3"):
        refuses(lambda wrong=wrong: material(f"{text}window = {wrong}"), "a.toml: material.window")
