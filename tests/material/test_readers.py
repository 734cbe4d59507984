import math
import re
from functools import partial

import numpy as np
import pytest

import restitution as rs
from refusals import in_one_line, named
from restitution import DynamicTable, InputError, PronySeries, RelaxationTable, ShiftTable
from restitution.material.cards import PronyTerms, ViscoelasticDeck
from restitution.material.readers import parse, read_material

pytestmark = pytest.mark.plain

PSI = 0.45359237 * 9.80665 / 0.0254**2


@pytest.mark.parametrize(
    "text",
    [
        "t,E_relax\ns,MPa\n1,30\n10,20\n",
        "t, E_relax\r\ns, MPa\r\n1, 30\r\n10, 20\r\n",
        "t [s];E [MPa]\n1;30\n10;20\n",
        "time_s;tensile_modulus_MPa\n1,0;30,0\n1,0E1;20\n",
        "time (ms)\trelaxation_modulus (kPa)\n1000\t30000\n10000\t20000",
        "# some\n# t_s E_Pa\n1 30e6\n10 20e6\n",
        '"t","E"\n"s","N/mm2"\n1,30\n\n10,20\n# end\n',
        "t,E(t)\nmin,GPa\n0.016666666666666666,0.03\n0.16666666666666666,0.02\n",
    ],
)
def test_relaxation_table_in_many_spellings(text):
    data = parse(text)
    assert isinstance(data, RelaxationTable)
    assert data.time == pytest.approx([1.0, 10.0], rel=1e-12)
    assert data.modulus == pytest.approx([30e6, 20e6], rel=1e-12)
    assert data.deformation == (None if "relaxation_modulus" in text else "tension")


@pytest.mark.parametrize(
    "text",
    [
        "f,E_stor,E_loss\nHz, MPa, MPa\n1,3,2\n10,4,1\n",
        f"omega,E',E''\nrad/s,MPa,MPa\n{2 * math.pi},3,2\n{20 * math.pi},4,1\n",
        "E_loss [MPa],E_storage [kPa],frequency [kHz]\n2,3000,1e-3\n1,4000,1e-2\n",
        "f [Hz],E_stor [MPa],tan_del [-]\n1,3,0.66666666666666667\n10,4,0.25\n",
    ],
)
def test_dma_table_in_many_spellings(text):
    data = parse(text)
    assert isinstance(data, DynamicTable)
    assert data.angular_frequency == pytest.approx([2 * math.pi, 20 * math.pi], rel=1e-14)
    assert data.storage_modulus == pytest.approx([3e6, 4e6], rel=1e-14)
    assert data.loss_modulus == pytest.approx([2e6, 1e6], rel=1e-14)
    assert data.deformation == "tension"


def test_deformation_follows_from_the_names_of_the_columns():
    assert parse("f,G_stor,G_loss\nHz,Pa,Pa\n1,3,2\n").deformation == "shear"
    assert parse("t,G\n1,3\n").deformation == "shear"
    assert parse("tau,G_i\ns,Pa\n1,3\n").deformation == "shear"


def test_si_without_units():
    data = parse("f,storage,loss\n1,3,2\n")
    assert data.angular_frequency == pytest.approx([2 * math.pi])
    assert data.storage_modulus.tolist() == [3.0]
    assert parse("omega,storage,loss\n1,3,2\n").angular_frequency.tolist() == [1.0]


def test_shift_factors_falling_or_rising_in_celsius_or_kelvin():
    table = parse("\ufeffT,log_aT\nC, -\n20,-1\n10,0\n0,2\n".lstrip("\ufeff"))
    assert isinstance(table, ShiftTable)
    assert table == parse("temperature [K],aT\n273.15,100\n283.15,1\n293.15,0.1\n")
    assert table.reference_temperature == pytest.approx(283.15)


def test_absolute_and_relative_prony_terms():
    terms = parse("relaxation_time_s,tensile_modulus_MPa\n1,3\n10,0\n")
    assert (terms.relative, terms.deformation) == (False, "tension")
    assert terms.series() == PronySeries(0.0, [3e6, 0.0], [1.0, 10.0])
    assert terms.series(equilibrium_modulus=1e6).equilibrium_modulus == 1e6
    assert terms.series(instantaneous_modulus=5e6).equilibrium_modulus == pytest.approx(2e6)
    shares = parse("# E0 = 8 MPa\n# rel_mod, rel_time\n0.5,1\n0.25,10\n")
    assert shares.series() == PronySeries(2e6, [4e6, 2e6], [1.0, 10.0])
    assert shares.series(equilibrium_modulus=1.0) == PronySeries(1.0, [2.0, 1.0], [1.0, 10.0])


def test_shares_of_the_difference_of_both_end_moduli():
    """The published terms of the epoxy have the sum 1: they are shares of G_0 - G_inf."""
    terms = PronyTerms(np.array([1.0, 2.0]), np.array([0.75, 0.25]), relative=True)
    series = terms.series(instantaneous_modulus=9.0, equilibrium_modulus=1.0)
    assert series == PronySeries(1.0, [6.0, 2.0], [1.0, 2.0])
    assert terms.series(instantaneous_modulus=8.0).is_liquid


@pytest.mark.parametrize(
    ("moduli", "relative", "ends", "message"),
    [
        ([0.5], True, {}, "one must be given"),
        ([1.5], True, {"instantaneous_modulus": 1.0}, r"add up to 1\.5"),
        ([1.0], True, {"equilibrium_modulus": 1.0}, "must be below 1"),
        ([0.5], True, {"instantaneous_modulus": 4.0, "equilibrium_modulus": 1.0}, r"must be 1 .* or 0\.75"),
        ([0.5], True, {"instantaneous_modulus": 1.0, "equilibrium_modulus": 2.0}, "must be <= 1 Pa"),
        ([5.0], False, {"instantaneous_modulus": 4.0}, "must be >= 5 Pa"),
        ([5.0], False, {"instantaneous_modulus": 8.0, "equilibrium_modulus": 1.0}, "must be 6 Pa"),
        ([5.0], False, {"equilibrium_modulus": -1.0}, "equilibrium_modulus = -1 Pa"),
    ],
)
def test_terms_that_contradict_their_end_moduli(moduli, relative, ends, message):
    with pytest.raises(ValueError, match=message):
        PronyTerms(np.ones(1), np.array(moduli), relative).series(**ends)


ANSYS = """/COM,ANSYS
MP,EX,1,9e6
MP,NUXY,1,0.25
MP,DENS,1,1100. ! kg/m3
TB,PRON,1, 1, 3,SHEA
TBDATA,1,0.1,1.0,0.2
TBDATA,4,10.0,0.3,100.0
TB,PRON,1,1,1,BULK
TBDATA,,0.5,2.0
/GO
"""


def test_ansys_deck():
    deck = parse(ANSYS, "a.mpl")
    assert isinstance(deck, ViscoelasticDeck)
    assert deck.shear.relaxation_times.tolist() == [1.0, 10.0, 100.0]
    assert deck.shear.moduli.tolist() == [0.1, 0.2, 0.3]
    material = deck.material()
    # ANSYS: G_0 = E/(2(1 + nu)), K_0 = E/(3(1 - 2 nu)) are instantaneous.
    assert material.shear.instantaneous_modulus == pytest.approx(3.6e6)
    assert material.shear.equilibrium_modulus == pytest.approx(0.4 * 3.6e6)
    assert material.bulk.instantaneous_modulus == pytest.approx(6e6)
    assert material.bulk.branch_moduli == pytest.approx([3e6])
    assert (material.density, material.name, material.source) == (1100.0, "1", "a.mpl")
    assert deck.material(poisson_ratio=0.5).is_incompressible


ABAQUS = """*HEADING
** a comment
*MATERIAL, NAME=rubber
*DENSITY
 1100.,
*ELASTIC, MODULI=LONG TERM
 9.0, 0.25
*Viscoelastic, time=PRONY
 0.25, 0.5, 1.0D-3
 0.35,    , 2.0
*STEP
"""


def test_abaqus_deck():
    deck = parse(ABAQUS, "a.inp")
    material = deck.material()
    # g_i are shares of G_0 = G_inf/(1 - sum g_i).
    assert material.shear.equilibrium_modulus == pytest.approx(3.6)
    assert material.shear.instantaneous_modulus == pytest.approx(9.0)
    assert material.shear.branch_moduli == pytest.approx([2.25, 3.15])
    assert material.shear.relaxation_times.tolist() == [1e-3, 2.0]
    assert material.bulk.equilibrium_modulus == pytest.approx(6.0)
    assert material.bulk.instantaneous_modulus == pytest.approx(12.0)
    assert (material.density, material.name) == (1100.0, "rubber")
    instantaneous = parse(ABAQUS.replace("LONG TERM", "INSTANTANEOUS")).material()
    assert instantaneous.shear.instantaneous_modulus == pytest.approx(3.6)


TWO = (
    ABAQUS
    + """*MATERIAL, NAME="Hard part"
*ELASTIC
 7e9, 0.25
"""
)


def test_one_of_several_materials_of_a_deck_by_its_name():
    assert parse(TWO, name="Rubber").material() == parse(ABAQUS).material()
    hard = parse(TWO, name="hard part")
    # G = E/(2 (1 + nu)); no constant of the other material is taken.
    assert (hard.material().shear, hard.density, hard.name) == (PronySeries(2.8e9), None, "Hard part")
    with pytest.raises(ValueError, match="text: has no material 'soft': choose one by its name, rubber or Hard"):
        parse(TWO, name="soft")
    with pytest.raises(ValueError, match=r"^text: has no material 'a': is no deck of a solver"):
        parse("t,E\n1,2\n", name="a")
    second = ANSYS.replace("PRON,1", "PRON,2").replace("MP,EX,1,9e6", "MP,EX,2,18e6").replace("NUXY,1", "NUXY,2")
    second = second.replace("TBDATA,1,0.1", "TBDATA,1,0.4")
    both = parse(ANSYS + second, name="2")
    assert both.shear.moduli.tolist() == [0.4, 0.2, 0.3]
    assert (both.youngs_modulus, both.density, both.name) == (18e6, None, "2")
    assert parse(ANSYS + second, name="1").material() == parse(ANSYS).material()


def test_scatter_of_relaxation_data_is_accepted():
    """Data may exceed the lowest earlier value by up to a half."""
    assert parse("t,E\n1,3\n2,2\n3,2.9\n").modulus.tolist() == [3.0, 2.0, 2.9]


def test_abaqus_without_bulk_terms_is_elastic_in_bulk():
    deck = parse(ABAQUS.replace("0.25, 0.5, 1.0D-3", "0.25, 0., 1.0D-3"))
    assert deck.material().bulk == PronySeries(6.0)


def test_a_deck_without_constants_is_refused():
    deck = parse("\n".join(line for line in ANSYS.splitlines() if not line.startswith("MP")))
    with pytest.raises(ValueError, match="youngs_modulus: must be given"):
        deck.material()
    assert named(lambda: deck.material(youngs_modulus=1.0)) == ("poisson_ratio",)
    assert named(lambda: deck.material(youngs_modulus=1.0, poisson_ratio=0.6)) == ("poisson_ratio", 0.6)
    assert deck.material(youngs_modulus=3.0, poisson_ratio=0.5).shear.instantaneous_modulus == pytest.approx(1.0)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("", "x: is empty"),
        ("\n  \n", "x: is empty"),
        ("# only a comment\n", "x: holds no numbers"),
        ("t,E\n", "x: line 1: is followed by no numbers"),
        ("t,E\ns,MPa\n", "x: line 1: is followed by no numbers"),
        ("1,2\n3,4\n", "x: line 1: the columns have no names"),
        ("t,E\ns,MPa\n1,3\n1,2\n", "x: line 4: t repeats that of line 3"),
        ("t,E\ns,MPa\n1,3\n3,2\n\n2,2\n", "x: line 6: t is less than that of line 4"),
        ("f,E_stor,E_loss\n2,3,1\n1,2,1\n3,2,1\n", "x: line 4: f is less|x: line 3: f is less than that of line 2"),
        ("t,E\n1,nan\n", "x: line 2: E = nan: must be finite and > 0"),
        ("t,E\n1,3\n2,inf\n", "x: line 3: E = inf"),
        ("t,E\n1,-3\n", "x: line 2: E = -3: must be finite and > 0"),
        ("t,E\n1,0\n", "x: line 2: E = 0: must be finite and > 0"),
        ("t,E\n-1,3\n", "x: line 2: t = -1: must be finite and >= 0"),
        ("f,E_stor,E_loss\n1,3,-1\n", "x: line 2: E_loss = -1: must be finite and >= 0"),
        ("t,E\n1,3,4\n", "x: line 2: 3 values: must be 2"),
        ("t,E\n1,3\n2\n", "x: line 3: 1 values: must be 2"),
        ("t,E\n1,3\n2,x\n", "x: line 3: E = 'x': must be a number"),
        ("t,E\nHz,MPa\n1,3\n", "x: line 2: column 't': unit 'Hz': must be a unit of time, such as s"),
        (
            "t,E\ns,furlong\n1,3\n",
            "x: line 2: column 'E': unit 'furlong': must be a unit of modulus, such as Pa, kPa, MPa",
        ),
        ("t [s],E [mm]\n1,3\n", "x: line 1: column 'E': unit 'mm'"),
        ("t,E\ns\n1,3\n", "x: line 2: 1 units for 2 columns"),
        ("t,mass\n1,3\n", "x: line 1: columns t, mass: must be"),
        ("t,f\n1,3\n", "x: line 1: columns t, f: must be time and relaxation modulus"),
        ("t,time,E\n1,3,4\n", "x: line 1: two columns hold a time"),
        ("f,E_stor,G_loss\n1,3,1\n", "x: one modulus is in tension, the other in shear"),
        ("tau,g_i\n0,0.5\n", "x: line 2: tau = 0: must be finite and > 0"),
        ("# E0 = 8 pounds\n# rel_mod,rel_time\n0.5,1\n", "x: line 1: 'E0 = 8 pounds': must end in a unit of modulus"),
        ("T,log_aT\nC,-\n1,0\n1,-1\n", r"x: line 3: temperatures\[1\] = 274.15 K: must be strictly ascending"),
        ("TB,PRON,1,1,2,SHEA\nTBDATA,1,0.1,1.0,0.2\n", "x: line 2: 3 constants .* must be 4, .*line 1"),
        ("TB,PRON,1,1,1,SHEA\n", "x: line 1: 0 constants in TBDATA: must be 2"),
        ("TB,PRON,1,1,1,SHEA\nTBDATA,0,0.1,1.0\n", "x: line 2: TBDATA from place 0: must be a whole number >= 1"),
        ("TB,PRON,1,1,1,SHEA\nTBDATA,1,0.1,zero\n", "x: line 2: 'zero': must be a number"),
        ("TB,PRON,1,1,1,SHEA\nTBDATA,1,0.1,-1\n", "x: line 2: relaxation time in shear = -1: must be > 0"),
        ("TB,PRON,1,1,1,SHEA\nTBDATA,1,1.1,1\n", r"x: line 2: relative moduli in shear add up to 1\.1"),
        ("TB,PRON,1,2,1,SHEA\nTBDATA,1,0.1,1\n", "x: line 1: 2 temperatures: must be 1"),
        ("TB,PRON,1,1,1,BEND\n", "x: line 1: TB,PRON for 'BEND'"),
        ("TB,PRON,1,1,1,SHEA\nTB,PRON,1,1,1,SHEA\n", "x: line 2: second TB,PRON table"),
        (
            "TB,PRON,1,1,0,SHEA\nTBDATA,1,.1,1\nTB,PRON,2,1,0,BULK\nTBDATA,1,.1,1\n",
            "x: has 2 materials: choose one by its name, 1 or 2",
        ),
        ("*VISCOELASTIC, TIME=CREEP TEST DATA\n1,2,3\n", "x: line 1: .*: must have TIME=PRONY"),
        ("*VISCOELASTIC, TIME=PRONY\n", "x: line 1: .* is followed by no terms"),
        ("*VISCOELASTIC, TIME=PRONY\n0.1,0.2\n", "x: line 2: 2 values: must be 3"),
        ("*VISCOELASTIC, TIME=PRONY\n0.1,0.2,a\n", "x: line 2: 'a': must be a number"),
        ("0.1\n*VISCOELASTIC, TIME=PRONY\n0.1,0.2,1\n", "x: line 1: '0.1': must stand below a keyword"),
        ("*ELASTIC\n*VISCOELASTIC, TIME=PRONY\n0.1,0.2,1\n", "x: line 1: 0 lines of data: must be 1"),
        ("*MATERIAL\n*MATERIAL\n*VISCOELASTIC, TIME=PRONY\n0.1,0.2,1\n", "x: line 2: second"),
        (
            "*MATERIAL, NAME=A\n*VISCOELASTIC, TIME=PRONY\n.1,.2,1\n*MATERIAL, NAME=B\n*ELASTIC\n1,.3\n",
            "x: has 2 materials: choose one by its name, A or B",
        ),
        ("*MATERIAL, NAME=A\n*MATERIAL, NAME=A\n*VISCOELASTIC\n", "x: line 2: second .* of the name A"),
        ("*VISCOELASTIC, TIME=PRONY\n0.1,0.2,1\n0.1,0,-2\n", "x: line 3: relaxation time in shear = -2"),
        ("*VISCOELASTIC, TIME=PRONY\n0.1,0.2,1\n0.1,-.5,2\n", r"x: line 3: relative .* bulk = -0\.5: .* >= 0"),
        ("*VISCOELASTIC, TIME=PRONY\n.7,0,1\n.7,0,2\n0,0,3\n", r"x: line 3: .* in shear add up to 1\.4"),
        (
            "*ELASTIC\n-1,.3\n*VISCOELASTIC, TIME=PRONY\n.1,0,1\n",
            "x: line 2: youngs_modulus = -1 Pa",
        ),
        ("MP,PRXY,1,.6\nTB,PRON,1,1,1\nTBDATA,1,.1,1\n", r"x: line 1: poisson_ratio = 0\.6: must be in \(-1"),
        ("relaxation_time_s,relative_modulus\n1,.5\n2,.9\n3,0\n", r"x: line 3: .*_modulus add up to 1\.4: .* 1"),
        ("# E0 = 4 Pa\n# tau, E_i\n1,5\n", "x: line 1: instantaneous_modulus = 4 Pa: must be >= 5 Pa"),
        ("t,E\ns,MPa\n1,1\n2,1.4\n3,30\n4,500\n", r"x: line 5: E is 3e\+07 Pa, and 1e\+06 Pa in line 3: must fall"),
        ("f,G_stor,G_loss\n1,9,1\n2,8,1\n3,5,1\n", "x: line 4: G_stor is 5 Pa, and 9 Pa in line 2: must rise"),
        ("f,|G*|,delta\n1,9,20\n2,9,95\n", r"x: line 3: \|G\*\|, delta: must give a storage modulus > 0 and a finite"),
        ("t,E\0\n1,2\n", "x: cannot be read: must be text"),
    ],
)
def test_malformed_text_is_refused_with_its_line_number(text, message):
    assert re.search(message, str(in_one_line(lambda: parse(text, "x"))))


def test_files_with_byte_order_mark_and_windows_line_ends(tmp_path):
    path = tmp_path / "relaxation.csv"
    path.write_bytes(b"\xef\xbb\xbft,E\r\ns,MPa\r\n1,3\r\n2,1\r\n")
    assert read_material(path).modulus.tolist() == [3e6, 1e6]
    assert read_material(str(path)).source == str(path)
    path.write_text("t,E\n1,x\n")
    for wrong in (path, tmp_path / "absent.csv", tmp_path):
        assert str(in_one_line(partial(read_material, wrong))).startswith(f"{wrong}: ")


def test_the_measured_materials(shared_reference):
    """Numbers of rows and end values of the files."""
    folder = shared_reference / "materials"
    dma = read_material(folder / "polymer_dma_master_curve.csv")
    assert isinstance(dma, DynamicTable)
    assert dma.angular_frequency.size == 206
    assert dma.angular_frequency[[0, -1]] == pytest.approx([2e-12 * math.pi, 2e14 * math.pi])
    assert dma.storage_modulus[-1] == pytest.approx(9.5805012940722e9)
    relaxation = read_material(folder / "polymer_relaxation_master_curve.csv")
    assert isinstance(relaxation, RelaxationTable)
    assert (relaxation.time.size, relaxation.modulus[0]) == (481, pytest.approx(1714.266e6))
    shift = read_material(folder / "polymer_dma_shift_factors.csv")
    assert isinstance(shift, ShiftTable)
    assert shift.reference_temperature == pytest.approx(268.15)
    assert shift.factor(223.15) == pytest.approx(10**12.75)
    epoxy = read_material(folder / "epoxy_prony.csv")
    assert isinstance(epoxy, PronyTerms)
    assert epoxy.moduli.sum() == pytest.approx(1.0, abs=1e-12)
    assert (epoxy.relative, epoxy.relaxation_times.size) == (True, 24)
    rubber = read_material(folder / "polyisobutylene_prony.csv")
    assert (rubber.relative, rubber.deformation) == (False, "tension")
    assert rubber.moduli.sum() == pytest.approx(2.96895091e9)
    deck = read_material(folder / "polymer_ansys_prony.MPL")
    assert isinstance(deck, ViscoelasticDeck)
    assert deck.shear.moduli[[0, 2]] == pytest.approx([4.017567e-2, 3.561656e-2])
    assert deck.shear.relaxation_times[26] == 1e12
    other = read_material(folder / "polymer_relaxation_prony.csv")
    assert other.instantaneous_modulus == pytest.approx(1739.03e6)
    assert other.series().instantaneous_modulus == pytest.approx(1739.03e6)


DMA = {
    "descending": "f [Hz];E' [MPa];E'' [MPa]\n10;4;1\n1;3;2\n",
    "units in brackets in a second row": "Frequency;Storage Modulus;Loss Modulus\n[Hz];[MPa];[MPa]\n1;3;2\n10;4;1\n",
    "decimal commas": "f\tE'\tE''\nHz\tMPa\tMPa\n1,0\t3,0\t2,0\n10,0\t4,0\t1,0\n",
    "blanks and decimal commas": "f E' E''\nHz MPa MPa\n1,0 3,0 2,0\n10,0 4,0 1,0\n",
    "more columns": "Point No.,Temperature [°C],f [Hz],E' [MPa],E'' [MPa],tan(delta),Status\n"
    "1,25,1,3,2,0.667,ok\n2,25,10,4,1,0.25,\n",
    "loss tangent": "Freq. (Hz),E’ (MPa),Tan(delta)\n1,3,0.6666666666666667\n10,4,0.25\n",
    "magnitude and loss tangent": "f_Hz,E*_MPa,tand\n"
    f"1,{math.hypot(3, 2)!r},0.6666666666666667\n10,{math.hypot(4, 1)!r},0.25\n",
    "magnitude and loss angle": "f [Hz],|E*| [MPa],delta [deg]\n"
    f"1,{math.hypot(3, 2)!r},{math.degrees(math.atan2(2, 3))!r}\n10,{math.hypot(4, 1)!r},{math.degrees(math.atan2(1, 4))!r}\n",
    "loss angle": f"f [Hz],E' [MPa],phase [rad]\n1,3,{math.atan2(2, 3)!r}\n10,4,{math.atan2(1, 4)!r}\n",
    "psi": f"f [Hz],E' [psi],E'' [psi]\n1,{3e6 / PSI!r},{2e6 / PSI!r}\n10,{4e6 / PSI!r},{1e6 / PSI!r}\n",
    "a block above": "Sample: rubber\nOperator;N. N.\nStart 12:00\n\nf;E';E''\n[Hz];[MPa];[MPa]\n1;3;2\n10;4;1\n",
    "empty cells before, between and behind tabs": "Interval data:\tPoint No.\tFrequency\tStorage Modulus\t"
    "Loss Modulus\tStatus\n\t\t[Hz]\t[MPa]\t[MPa]\t\n\t1\t1\t3\t2\t\n\t2\t10\t4\t1\tok\n",
    "tabs at some ends": "\tf\tE'\tE''\t\nHz\tMPa\tMPa\n1\t3\t2\n\t10\t4\t1\n",
    "trailing commas": "f,E',E'',\nHz,MPa,MPa,\n1,3,2,\n10,4,1,\n",
    "German": "Frequenz [Hz];Speichermodul [MPa];Verlustmodul [MPa]\n1;3;2\n10;4;1\n",
    "angular": f"Angular frequency (rad/s),E' (MPa),E'' (MPa)\n{2 * math.pi!r},3,2\n{20 * math.pi!r},4,1\n",
}


@pytest.mark.parametrize("text", DMA.values(), ids=DMA)
@pytest.mark.parametrize("encoding", ["utf-8", "utf-16", "cp1252"])
def test_laboratory_tables(tmp_path, text, encoding):
    path = tmp_path / "dma.csv"
    path.write_bytes(text.replace("\n", "\r\n").encode(encoding))
    data = read_material(path)
    assert isinstance(data, DynamicTable)
    assert data.angular_frequency == pytest.approx([2 * math.pi, 20 * math.pi], rel=1e-14)
    assert data.storage_modulus == pytest.approx([3e6, 4e6], rel=1e-6)
    assert data.loss_modulus == pytest.approx([2e6, 1e6], rel=1e-6)


def test_assumed_units_and_unused_columns_are_noted():
    data = parse("Point No.,freq,G' [Pa],G'',tan(delta)\n1,1,3,2,0.667\n2,10,4,1,0.25\n")
    assert data.notes == (
        "unit of freq not given: Hz assumed",
        "unit of G'' not given: Pa assumed",
        "columns not used: Point No., tan(delta)",
    )
    assert parse(DMA["descending"]).notes == ()
    assert parse("f [Hz],|G*| [Pa],delta\n1,3,20\n2,4,10\n").notes == ("unit of delta not given: deg assumed",)
    assert parse("T,log_aT\n290,1\n310,-1\n").notes == ("unit of T not given: K assumed",)


def test_a_workbook_is_refused_with_advice(tmp_path):
    for start in (b"PK\x03\x04", b"\xd0\xcf\x11\xe0"):
        (tmp_path / "dma.xlsx").write_bytes(start + bytes(100))
        with pytest.raises(InputError, match="CSV"):
            read_material(tmp_path / "dma.xlsx")
    (tmp_path / "picture.dat").write_bytes(bytes(range(256)) * 4)
    assert "picture.dat" in str(in_one_line(lambda: read_material(tmp_path / "picture.dat")))
    assert in_one_line(lambda: read_material({"time": [1.0]})).field == "path"


@pytest.mark.parametrize(
    "text",
    [
        "t" + " " * 30_000 + "x\n1\n",
        "t" + " [" * 20_000 + ",E\n1,2\n",
        "t" + "(" * 50_000 + ")" * 50_000 + ",E\n1,2\n",
        "\n" * 100_000,
        " \n" * 50_000 + "t,E\n1,x\n",
        "TB" + " " * 100_000,
        "# E0 =" + " " * 50_000 + "1" * 50_000 + "\ntau,g_i\n1,0.5\n2,x\n",
        "a_" * 50_000 + ",E\n1,2\n",
        "MP,EX,1,9e6\nTB,PRON,1,1,1e20,SHEA\nTBDATA,1,.2,1e-4\n",
        "TB,PRON,1,1,1e9,SHEA\nTBDATA,1,.2,1e-4\n",
        "TB,PRON,1,1,-1,SHEA\nTBDATA,1,.2,1e-4\n",
        "TB,PRON,1,1,1,SHEA\nTBDATA,1e300,.2,1e-4\n",
        "tau,g_i\n" + "".join(f"{i + 1},1e-6\n" for i in range(8000)),
    ],
    ids=range(13),
)
def test_hostile_texts_are_refused_in_one_line(text):
    """A parser with quadratic time or memory would exceed the limits of the test run."""

    def series():
        return parse(text, "x").series(instantaneous_modulus=1.0)

    assert len(str(in_one_line(series))) < 500


def test_a_file_is_refused_by_its_size_before_it_is_parsed(tmp_path, monkeypatch):
    """Of a longer file only so much is read as is allowed."""
    file = tmp_path / "long.csv"
    file.write_text("t,E\ns,Pa\n" + "1.5,2\n" * 200)
    monkeypatch.setattr("restitution.material.sheet._LARGEST", 1000)
    for read in (rs.read_material, rs.read_observations):
        assert f"{file.name}: is too long" in str(in_one_line(partial(read, file)))


def test_a_line_is_refused_by_its_length(tmp_path):
    file = tmp_path / "wide.csv"
    file.write_text("t,E\n" + "1.510," * 400_000)
    with pytest.raises(rs.InputError, match="line 2: has 2400000 characters: must have at most 1000000"):
        rs.read_material(file)


def test_a_saved_surrogate_is_refused_by_its_size(tmp_path):
    file = tmp_path / "s.json"
    file.write_text(" " * 20_000_001)
    with pytest.raises(rs.InputError, match="must have at most"):
        rs.Surrogate.load(file)
