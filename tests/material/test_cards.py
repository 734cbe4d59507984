"""Cards of Abaqus and ANSYS: their text, and what the readers of decks make of it."""

import math
import re
import tempfile
from pathlib import Path

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st

import restitution as rs
from refusals import in_one_line
from restitution import Material, PronySeries
from strategies import logarithmic, materials

EPS = float(np.finfo(np.float64).eps)
RUBBER = Material(PronySeries(1e6, [2e6, 1e6], [1e-1, 1e-3]), math.inf, density=1100.0, name="Soft rubber, 60°")
GLASSY = Material(PronySeries(1.0, [3.0], [2.0]), PronySeries(2.0, [6.0], [5.0]))


def lines(material, path):
    return [
        line for line in rs.write_material(material, path).read_text().splitlines() if line[:2] not in ("**", "! ")
    ]


def test_abaqus_takes_shares_of_the_glass_modulus_and_constants_of_long_times(tmp_path):
    assert lines(RUBBER, tmp_path / "a.inp") == [
        "*MATERIAL, NAME=Soft-rubber-60",
        "*DENSITY",
        "1100.0,",
        "*ELASTIC, MODULI=LONG TERM",
        "3000000.0, 0.5",
        "*VISCOELASTIC, TIME=PRONY",
        "0.25, 0.0, 0.001",
        "0.5, 0.0, 0.1",
    ]
    # nu = (3K - 2G)/(6K + 2G), E = 2(1 + nu)G at rest.
    row = f"{2.0 * (1.0 + 4.0 / 14.0)!r}, {4.0 / 14.0!r}"
    assert lines(GLASSY, tmp_path / "b.inp")[2:] == [
        row,
        "*VISCOELASTIC, TIME=PRONY",
        "0.75, 0.0, 2.0",
        "0.0, 0.75, 5.0",
    ]


def test_ansys_takes_instantaneous_constants(tmp_path):
    assert lines(RUBBER, tmp_path / "a.txt") == [
        "MP,EX,1,12000000.0",
        "MP,PRXY,1,0.5",
        "MP,DENS,1,1100.0",
        "TB,PRON,1,1,2,SHEAR ! relative modulus [-], relaxation time [s]",
        "TBDATA,1,0.25,0.001",
        "TBDATA,3,0.5,0.1",
    ]
    assert lines(GLASSY, tmp_path / "b.mac")[2:] == [
        "TB,PRON,1,1,1,SHEAR ! relative modulus [-], relaxation time [s]",
        "TBDATA,1,0.75,2.0",
        "TB,PRON,1,1,1,BULK ! relative modulus [-], relaxation time [s]",
        "TBDATA,1,0.75,5.0",
    ]


def test_comments_state_units_moduli_and_where_they_hold(tmp_path):
    material = Material(GLASSY.shear, GLASSY.bulk, window=(1e-3, 1e2), temperature=293.15, source="DMA of a beam")
    for name, moduli in (("a.inp", "those of long times"), ("a.txt", "the instantaneous ones")):
        text = rs.write_material(material, tmp_path / name).read_text()
        for remark in ("Pa, s, kg/m^3", f"E and nu are {moduli}", "from 0.001 to 100 s", "293.15 K", "DMA of a beam"):
            assert remark in text


@pytest.mark.parametrize("name", ["deck.inp", "deck.txt"])
@settings(max_examples=30)
@given(material=materials(max_branches=12, times=(1e-9, 1e6)))
def test_a_material_is_read_back_but_for_rounding(name, material):
    elastic = rs.elastic(youngs_modulus=2.1e11, poisson_ratio=0.3)
    shear, bulk = material.shear, material.bulk if isinstance(material.bulk, PronySeries) else None
    assume(bulk is None or (bulk.equilibrium_modulus > 0 and bulk.instantaneous_modulus > 0))
    series = [item for item in (shear, bulk) if item is not None]
    drops = [part.instantaneous_modulus / part.equilibrium_modulus for part in series]
    assume(max(drops) < 1e8)
    with tempfile.TemporaryDirectory() as folder:
        path = rs.write_material([material, elastic], Path(folder, name))
        result = rs.read_material(path, name="material-1" if name.endswith("inp") else "1").material()
        other = rs.read_material(path, name="material-2" if name.endswith("inp") else "2").material()
    assert other.shear.equilibrium_modulus == pytest.approx(elastic.shear.equilibrium_modulus, rel=4 * EPS)
    assert result.is_incompressible == material.is_incompressible or result.poisson_ratio == 0.5
    # Fifteen digits of a time, and a sum of shares.
    digits = 5e-15 + 4.0 * EPS * max(part.n_branches for part in series)
    if name.endswith("inp"):
        # The shares leave 1 - sum g_k = G_inf/G_0, whose error is absolute.
        assert result.shear.equilibrium_modulus == pytest.approx(shear.equilibrium_modulus, rel=8 * EPS)
        digits *= max(drops)
    t = np.geomspace(1e-12, 1e8, 60)
    expected, values = shear.relaxation_modulus(t), result.shear.relaxation_modulus(t)
    assert np.abs(values - expected).max() <= digits * shear.instantaneous_modulus
    if bulk is not None and not result.is_incompressible:
        ratio = max(
            max(x / y, y / x)
            for moduli in ("equilibrium_modulus", "instantaneous_modulus")
            for x, y in [(getattr(bulk, moduli), getattr(shear, moduli))]
        )
        # The rounding of nu: K/G = 2(1 + nu)/(3(1 - 2 nu)).
        expected, values = bulk.relaxation_modulus(t), result.bulk.relaxation_modulus(t)
        assert np.abs(values - expected).max() <= (digits + 8.0 * EPS * ratio) * bulk.instantaneous_modulus


@pytest.mark.parametrize("seed", range(4))
@pytest.mark.parametrize("name", ["deck.inp", "deck.txt"])
def test_shifts_are_read_back(name, seed, tmp_path):
    rng = np.random.default_rng(seed)
    reference, first, second = rng.uniform([200.0, 5.0, 20.0], [400.0, 30.0, 300.0])
    for shift in (
        rs.WLF(reference, first, second, temperature_range=(150.0, 450.0)),
        rs.Arrhenius(reference, 1e4 * first),
    ):
        material = Material(RUBBER.shear, 2e9, shift=shift)
        # The material is another one at another temperature, but its card is the same.
        deck = rs.write_material(
            [rs.elastic(youngs_modulus=1e9, poisson_ratio=0.3), material.at(reference + 5.0)], tmp_path / name
        )
        result = rs.read_material(deck, name=name.endswith("inp") * "material-" + "2").material()
        assert result.temperature == reference
        assert result.shift.reference_temperature == reference
        if isinstance(shift, rs.WLF):
            assert (result.shift.c1, result.shift.c2) == (first, second)
        else:
            # ANSYS takes the energy over the gas constant.
            assert result.shift.activation_energy == pytest.approx(
                1e4 * first, rel=EPS if name.endswith("txt") else 0.0
            )
        times = [np.sort(item.at(reference + 20.0).shear.relaxation_times) for item in (material, result)]
        assert times[1] == pytest.approx(times[0], rel=1e-12)


def test_cards_of_shifts(tmp_path):
    # log10 a_T = -C1 (T - T0)/(C2 + T - T0) in Abaqus; ANSYS has the same constants, as it multiplies the time.
    wlf, arrhenius = (
        Material(GLASSY.shear, GLASSY.bulk, shift=item)
        for item in (rs.WLF(293.15, 8.61, 200.4), rs.Arrhenius(300.0, 1e5))
    )
    assert lines(wlf, tmp_path / "a.inp")[-2:] == ["*TRS, DEFINITION=WLF", "293.15, 8.61, 200.4"]
    assert lines(arrhenius, tmp_path / "a.inp")[-2:] == ["*TRS, DEFINITION=ARRHENIUS", "300.0, 100000.0"]
    assert "ABSOLUTE ZERO=0 and the universal gas constant 8.31446" in (tmp_path / "a.inp").read_text()
    assert lines(wlf, tmp_path / "a.txt")[-2:] == ["TB,SHIFT,1,1,3,WLF", "TBDATA,1,293.15,8.61,200.4"]
    assert lines(arrhenius, tmp_path / "a.txt")[-2].startswith("TB,SHIFT,1,1,2,TN")
    assert float(lines(arrhenius, tmp_path / "a.txt")[-1].split(",")[-1]) == pytest.approx(1e5 / 8.31446261815324)
    # A material that does not relax has no shift, and a table of shift factors no card.
    for name in ("a.inp", "a.txt"):
        elastic = Material(1e6, 2e9, shift=rs.WLF(293.15, 8.61, 200.4))
        table = Material(RUBBER.shear, 2e9, shift=rs.ShiftTable([290.0, 300.0, 310.0], [1.0, 0.0, -0.5]))
        for element in (elastic, table.at(305.0)):
            assert not any("TRS" in line or "SHIFT" in line for line in lines(element, tmp_path / name))
        assert "the cards cannot hold a ShiftTable, and so hold at 305 K alone" in (tmp_path / name).read_text()


@pytest.mark.parametrize(
    ("name", "text", "shift"),
    [
        ("a.inp", "*Physical constants, absolute zero=-273.15\n{}*TRS\n20., 17.4, 51.6\n", rs.WLF(293.15, 17.4, 51.6)),
        ("a.inp", "{}*TRS, definition=ARRHENIUS\n300., 1e5\n", rs.Arrhenius(300.0, 1e5)),
        ("a.inp", "{}*TRS, definition=USER\n", None),
        ("a.txt", "TOFFST,273.15\n{}TB,SHIFT,1,,,wlf\nTBDATA,1,20,17.4,51.6\n", rs.WLF(293.15, 17.4, 51.6)),
        ("a.txt", "{}TB,SHIFT,1,1,2,100\nTBDATA,1,20,17.4\n", None),
        ("a.inp", "{}*TRS\n-20., 17.4, 51.6\n", "line 6: reference_temperature = -20 K"),
        ("a.inp", "{}*TRS\n300., -17.4, 51.6\n", "line 6: c1 = -17.4"),
        ("a.inp", "{}*TRS\n", "line 6: 0 constants of the shift: must be 3"),
        ("a.inp", "*PHYSICAL CONSTANTS, ABSOLUTE ZERO=x\n{}", "line 1: 'x'"),
        ("a.txt", "{}TB,SHIFT,1,1,3,WLF\nTBDATA,1,300,17.4\n", "line 5: 2 constants of the shift: must be 3"),
    ],
)
def test_shifts_of_other_decks(name, text, shift, tmp_path):
    prony = {
        "a.inp": "*MATERIAL, NAME=x\n*ELASTIC\n1e6, 0.4\n*VISCOELASTIC, TIME=PRONY\n0.5, 0.0, 1.0\n",
        "a.txt": "MP,EX,1,1e6\nMP,PRXY,1,0.4\nTB,PRON,1,1,1,SHEAR\nTBDATA,1,0.5,1.0\n",
    }[name]
    (tmp_path / name).write_text(text.format(prony))
    if isinstance(shift, str):
        with pytest.raises(ValueError, match=re.escape(shift)):
            rs.read_material(tmp_path / name)
    else:
        assert rs.read_material(tmp_path / name).material().shift == shift


def test_restitution_of_a_material_of_a_deck(tmp_path):
    material = rs.standard_solid(1e6, 1e7, 1e4, poisson_ratio=0.45)
    e = [
        rs.solve(rs.Impact(item, rs.Parabola(0.01), 0.005, 1.0)).restitution_coefficient
        for item in (material, *(rs.read_material(rs.write_material(material, tmp_path / n)).material() for n in ("a.inp", "a.mac")))
    ]  # fmt: skip
    assert e[1:] == pytest.approx([e[0]] * 2, abs=1e-9)


@given(value=logarithmic(1e-90, 1e90) | st.floats(0.0, 1.0).filter(lambda x: x > 1e-90))
def test_numbers_have_no_more_characters_than_abaqus_takes(value):
    from restitution.material.cards import _text

    text = _text(value)
    assert len(text) <= 20
    assert float(text) == pytest.approx(value, rel=5e-15, abs=0.0)
    if 1e-3 <= value < 1e15:
        assert float(text) == pytest.approx(value, rel=5e-16, abs=0.0)
    if len(repr(value)) <= 20:
        assert float(text) == value


def test_liquids_are_read_back_from_ansys(tmp_path):
    rng = np.random.default_rng(3)
    for count in (1, 3, 20):
        liquid = Material(PronySeries(0.0, rng.uniform(1.0, 2.0, count), np.arange(1.0, count + 1.0)), math.inf)
        assert rs.read_material(rs.write_material(liquid, tmp_path / "a.txt")).material().shear.is_liquid
        with pytest.raises(ValueError, match=r"shear.equilibrium_modulus = 0 Pa: must be >= 1e-10 .* holds no liquid"):
            rs.write_material(liquid, tmp_path / "a.inp")


@pytest.mark.parametrize(
    ("material", "name", "message"),
    [
        (rs.kelvin_voigt(1e6, 1e3, poisson_ratio=0.5), "a.inp", "shear.parallel_viscosity = 1000 Pa s: must be 0"),
        (rs.kelvin_voigt(1e6, 1e3, poisson_ratio=0.5), "a.txt", "shear.parallel_viscosity = 1000 Pa s: must be 0"),
        (Material(PronySeries(1.0, [1.0], [1.0]), 0.0), "a.txt", "poisson_ratio = -1: must be > -1"),
        (Material(PronySeries(1.0), PronySeries(0.0, [1.0], [1.0])), "a.inp", "bulk.equilibrium_modulus = 0 Pa"),
        (RUBBER, "a.dat", "path = .*: must end in .inp or .txt or .mac"),
        (
            rs.FractionalMaterial(rs.springpot(1e4, 0.2), 2e9),
            "a.inp",
            "must be a Material or several .of a fractional model: within",
        ),
        ([], "a.inp", "material"),
        (3.0, "a.inp", "material"),
    ],
)
def test_what_a_card_cannot_hold_is_refused(material, name, message, tmp_path):
    assert re.search(message, str(in_one_line(lambda: rs.write_material(material, tmp_path / name))))
    assert not list(tmp_path.iterdir())
