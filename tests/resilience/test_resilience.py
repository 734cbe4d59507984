"""Rebound resilience of standard tests: against printed numbers, against `rs.solve`, and silly inputs."""

import json
import math

import numpy as np
import pytest

import restitution as rs
from refusals import in_one_line, named
from restitution.citation.cite import citations, entries
from restitution.errors import ABSENT
from restitution.rebound_resilience import STANDARDS

TIMES = [1.0, 0.1, 1e-2, 1e-3, 1e-4, 1e-5]
RUBBER = rs.Material(
    rs.PronySeries(0.6e6, [0.06e6, 0.08e6, 0.12e6, 0.25e6, 0.8e6, 3e6], TIMES),
    math.inf,
    shift=rs.WLF(293.0, 6.0, 100.0),
)
NUMBERS = ("rebound_resilience", "contact_time", "max_indentation_depth", "max_contact_radius", "max_force")


def test_half_space_under_the_schob_pendulum():
    # Five numbers of this rubber from independent programs, to four digits.
    pad = rs.resilience(RUBBER, "ASTM D7121", base="half-space")
    expected = 63.16, 8.94e-3, 5.83e-3, 6.61e-3, 181.0
    assert [float(getattr(pad, name)[0]) for name in NUMBERS] == pytest.approx(expected, rel=1e-3)
    assert pad.rebound_resilience[0] == pytest.approx(63.16, abs=6e-3)


# Pad in mm and its base; R, contact time [ms], depth and contact radius [mm], force [N]: an independent integration.
PADS = {
    (12.5, "bonded"): (59.86, 6.75, 4.53, 7.13, 263.0),
    (12.5, "frictionless"): (61.13, 7.51, 4.98, 6.97, 228.0),
    (25.0, "bonded"): (61.61, 7.82, 5.17, 6.93, 216.0),
    (6.0, "bonded"): (56.73, 5.11, 3.50, 7.02, 371.0),
}


@pytest.mark.parametrize(("thickness", "base"), PADS)
def test_pads_under_the_schob_pendulum(thickness, base):
    pad = rs.resilience(RUBBER, "ASTM D7121", thickness=1e-3 * thickness, base=base)
    numbers = [float(getattr(pad, name)[0]) for name in NUMBERS]
    resilience, *others = PADS[thickness, base]
    assert numbers[0] == pytest.approx(resilience, abs=6e-3)
    assert numbers[1:] == pytest.approx(np.array(others) * [1e-3, 1e-3, 1e-3, 1.0], rel=1.5e-3)


def test_the_base_brackets_the_pad_and_a_thick_one_is_a_half_space():
    thin, thick = (rs.resilience(RUBBER, "ISO 4662", thickness=h) for h in (0.008, 1.0))
    assert thin.base == ("bonded", "frictionless", "half-space")
    assert thin.contact_time[0] < thin.contact_time[1] < thin.contact_time[2]
    # F/F_Hertz = 1 + 2 m0 a/h: 6e-3 of the force at a/h = 6e-3.
    assert thick.rebound_resilience == pytest.approx(thick.rebound_resilience[2], rel=3e-3)
    assert thick.max_force == pytest.approx(thick.max_force[2], rel=1e-2)


def test_what_the_warning_of_a_bonded_pad_names_brings_it_back():
    series = rs.PronySeries(1e6, [4e6, 3e7], [1e-3, 1e-5])
    pad = rs.resilience(rs.Material(series, 2e9), "ISO 4662")
    assert "bonded" not in pad.base
    (warning,) = (line for line in pad.warnings if line.startswith("a bonded pad"))
    assert 'bulk_modulus = "incompressible"' in warning
    assert "poisson_ratio = 0.4995" in warning
    with pytest.raises(rs.InputError, match='bulk_modulus = "incompressible"'):
        rs.resilience(rs.Material(series, 2e9), "ISO 4662", base="bonded")
    for remedy in (math.inf, rs.PronySeries(1e6, [4e6, 3e7], [1e-3, 1e-5]).scaled(2.0 * 1.4995 / (3.0 * 0.001))):
        assert "bonded" in rs.resilience(rs.Material(series, remedy), "ISO 4662").base


def test_a_bonded_pad_is_left_out_where_it_does_not_hold():
    # The Poisson ratio of this foam changes in time.
    foam = rs.Material(rs.PronySeries(2e4, [2e4, 5e4], [1e-3, 1e-4]), 6e4)
    pad = rs.resilience(foam, "ISO 8307")
    assert pad.base == ("frictionless", "half-space")
    assert any("bonded" in warning and "Poisson ratio" in warning for warning in pad.warnings)
    assert named(lambda: rs.resilience(foam, "ISO 8307", base="bonded")) == ("material",)


@pytest.mark.parametrize("name", STANDARDS)
def test_numbers_of_each_standard(name):
    test, radius = STANDARDS[name], 0.009
    further: dict[str, float] = {} if test.mass else {"mass": 0.03}
    mass = test.mass or further["mass"]
    pad = rs.resilience(RUBBER, name, base="half-space", tip_radius=radius, temperature=[270.0, 310.0], **further)
    assert pad.rebound_resilience.shape == (2, 1)
    for row, kelvin in enumerate([270.0, 310.0]):
        weight = mass * 9.80665 if test.falls else 0.0
        impact = rs.Impact(RUBBER.at(kelvin), rs.Parabola(radius), mass, test.velocity, external_force=weight)
        result = rs.solve(impact)
        assert pad.rebound_resilience[row, 0] == pytest.approx(100.0 * result.restitution_coefficient**2, rel=1e-6)
        for other in NUMBERS[1:]:
            assert getattr(pad, other)[row, 0] == pytest.approx(getattr(result, other), rel=1e-6)
        rate = math.pi / result.contact_time
        assert pad.loss_tangent[row, 0] == pytest.approx(RUBBER.at(kelvin).shear.loss_tangent(rate))
    assert pad.frequency == pytest.approx(0.5 / pad.contact_time)


@pytest.mark.parametrize("name", STANDARDS)
def test_every_number_has_a_source(name):
    test = STANDARDS[name]
    numbers = {name for name in ("radius", "mass", "velocity", "thickness") if getattr(test, name) is not None}
    assert set(test.sources) == numbers
    assert set(test.keys) <= set(entries())
    assert all(text.partition(": ")[2] for text in test.sources.values())


def test_nominal_numbers_of_iso_4662_and_of_schob():
    # GB/T 1681: m v^2/(D d^2) = 351 (+181/-100) kJ/m3.
    for name, density in (("ISO 4662", pytest.approx(351e3, rel=2e-3)), ("DIN 53512", None)):
        test = STANDARDS[name]
        assert test.radius is not None
        assert test.mass is not None
        pad = test.mass * test.velocity**2 / (2.0 * test.radius * test.thickness**2)
        assert 251e3 < pad < 532e3
        assert density is None or pad == density
    assert pytest.approx(0.5, abs=0.05) == 0.5 * 0.25 * 1.98**2
    assert STANDARDS["ISO 8307"].velocity ** 2 / (2.0 * 9.80665) == pytest.approx(0.5)


def test_given_numbers_replace_those_of_the_standard():
    pad = rs.resilience(RUBBER, "ASTM D2632", tip_radius=0.004, mass=0.028, thickness=0.02)
    assert (pad.standard.radius, pad.standard.mass, pad.standard.thickness) == (0.004, 0.028, 0.02)
    assert set(pad.standard.sources) == {"velocity"}
    assert set(rs.resilience(RUBBER, "ISO 4662").standard.sources) == {"radius", "mass", "velocity", "thickness"}


def test_table_dataset_and_json():
    pad = rs.resilience(RUBBER, temperature=[280.0, 300.0, 320.0])
    data = pad.to_dataset()
    assert data.rebound_resilience.dims == ("temperature", "base")
    assert data.rebound_resilience.attrs["units"] == "%"
    assert data.temperature.attrs["units"] == "K"
    assert len(pad.table) == 3 * len(pad.base)
    for head, values in {
        "contact [ms]": 1e3 * pad.contact_time,
        "depth [mm]": 1e3 * pad.max_indentation_depth,
    }.items():
        assert pad.table[head].astype(float).to_numpy() == pytest.approx(values.ravel(), rel=5e-3)
    assert all(word in str(pad) for word in ("ISO 4662", "R [%]", "6.85", pad.base[0]))
    assert "<table" in pad._repr_html_()  # pyright: ignore[reportPrivateUsage]
    content = json.loads(json.dumps(pad.to_dict(), allow_nan=False))
    assert content["rebound_resilience"] == pad.rebound_resilience.tolist()
    assert content["standard"]["sources"].keys() == {"radius", "mass", "velocity", "thickness"}
    single = rs.resilience(RUBBER)
    assert single.rebound_resilience.shape == (len(single.base),)
    assert single.to_dataset().rebound_resilience.dims == ("base",)
    assert {"gbt1681", "ting1966"} <= citations(single).keys()


def test_resilience_rises_far_above_the_glass_transition():
    pad = rs.resilience(RUBBER, temperature=[300.0, 350.0, 450.0], base="half-space")
    assert np.all(np.diff(pad.rebound_resilience[:, 0]) > 0.0)


def test_warnings_have_the_numbers_of_strain_and_pad():
    pad = rs.resilience(RUBBER, "ASTM D7121", base="half-space")
    text = "\n".join(pad.warnings)
    assert f"{pad.max_contact_radius[0] / 0.0075:.3g}" in text
    assert f"{pad.max_contact_radius[0] / 0.0125:.3g}" in text
    assert "trend" in text
    # The heavy indentor is no ball.
    assert "density" not in text


def test_a_body_that_stays_has_no_resilience():
    liquid = rs.maxwell(1e4, 1.0, bulk_modulus=math.inf)
    pad = rs.resilience(liquid, "ISO 8307", base="half-space")
    assert pad.rebound_resilience[0] < 1.0
    stays = rs.resilience(rs.kelvin_voigt(1e3, 1e3, poisson_ratio=0.5), "ISO 8307", base="half-space")
    assert stays.rebound_resilience[0] < 1.0
    assert stays.plot().axes
    assert stays.warnings


@pytest.mark.parametrize("temperature", [None, [280.0, 300.0]])
def test_pictures(temperature):
    figure = rs.resilience(RUBBER, temperature=temperature).plot()
    heights = [line.get_ydata() for line in figure.axes[0].lines]
    assert all(0.0 <= value <= 100.0 for line in heights for value in np.atleast_1d(line))


@pytest.mark.parametrize(
    ("arguments", "field", "words"),
    [
        ({"standard": "ISO 466"}, "standard", ""),
        ({"standard": "ASTM D2632"}, "tip_radius", "must be given"),
        ({"standard": "ASTM D2632", "tip_radius": 0.004}, "mass", ""),
        ({"mass": -1.0}, "mass", ""),
        ({"temperature": -5.0}, "temperature", ""),
        ({"temperature": []}, "temperature", "must be a number or a list"),
        ({"temperature": [[280.0]]}, "temperature", ""),
        ({"temperature": math.nan}, "temperature", ""),
        ({"base": "glued"}, "base", ""),
        ({"base": ()}, "base", "must name"),
        ({"thickness": 0.0}, "thickness", ""),
        ({"thickness": 12.5}, "thickness", ""),
        ({"tip_radius": -1.0}, "tip_radius", ""),
        ({"rtol": 1.0}, "rtol", ""),
    ],
)
def test_silly_inputs_are_refused_in_one_line(arguments, field, words):
    error = in_one_line(lambda: rs.resilience(RUBBER, **arguments))
    assert error.field == field
    assert error.value is ABSENT or error.value == pytest.approx(arguments[field], nan_ok=True)
    assert words in error.rule


def test_a_temperature_needs_a_shift_and_a_material_its_type():
    assert named(lambda: rs.resilience(rs.Material(1e6, 1e9), temperature=300.0)) == ("temperature", 300.0)
    assert named(lambda: rs.resilience(1e6)) == ("material", 1000000.0)
    gel = rs.FractionalMaterial(rs.springpot(1e4, 0.2), bulk=2e9)
    assert in_one_line(lambda: rs.resilience(gel)).field == "material"
