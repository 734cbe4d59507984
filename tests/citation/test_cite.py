"""Citations of problems with known methods, materials and profiles."""

import math
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest

import restitution as rs
from cases import RUBBER, case_file
from refusals import in_one_line
from restitution import Bounces, ImpactResult
from restitution.citation.cite import citations, cite, entries

THEORY = {"lee1960", "ting1966", "graham1967", "popov2015"}
SERIES = rs.Material(rs.PronySeries(1e6, [1e6, 2e6], [1e-3, 1e-2]), 1e9)


def keys(*subjects: object) -> set[str]:
    return set(citations(*subjects))


def impact(material: rs.Material, profile: object, **extra: object) -> rs.Impact:
    return rs.Impact(material, profile, mass=1.0, velocity=1.0, **extra)


def test_the_sphere_of_the_paper() -> None:
    sources = citations(impact(RUBBER, rs.Parabola(1.0)))
    assert set(sources) == THEORY | {"restitution", "hertz1882", "willert"}
    assert sources["willert"] == ["impact on the compressible standard solid"]


@pytest.mark.parametrize(
    ("profile", "expected"),
    [
        (rs.Parabola(1.0), {"hertz1882"}),
        (rs.Sphere(1.0), {"segedin1957"}),
        (rs.Cone(1.0), {"love1939", "sneddon1965"}),
        (rs.PowerLaw(3.0, 1.0), {"galin1961", "sneddon1965"}),
        (rs.FlatPunch(1.0), {"boussinesq1885"}),
        (rs.TruncatedCone(1.0, 1.0), {"popov2019"}),
        (rs.FlatEndedParabola(1.0, 0.1), {"popov2019"}),
        (rs.Tabulated(np.linspace(0, 1, 9), np.linspace(0, 1, 9) ** 2), {"fritsch1980", "sneddon1965"}),
        (rs.Layer(rs.Cone(1.0), thickness=1.0), {"hayes1972", "love1939", "sneddon1965"}),
    ],
    ids=lambda value: type(value).__name__,
)
def test_every_profile_has_its_sources(profile: object, expected: set[str]) -> None:
    assert keys(profile) == expected
    assert keys(impact(SERIES, profile)) == THEORY | {"restitution"} | expected


@pytest.mark.parametrize("name", rs.library.names())
def test_every_material_of_the_library_has_its_sources(name: str) -> None:
    material = rs.library.get(name)
    sources = citations(material)
    assert sources
    assert all(uses == [f"data of {name}"] for uses in sources.values())
    for key in sources:
        author = entries()[key]
        assert key in entries()
        # The source of the material contains the authors or the number of the standard.
        words = {
            "crc": "CRC Handbook",
            "en1993": "EN 1993-1",
            "en1999": "EN 1999-1-1",
            "en572": "EN 572-1",
            "pyvisco": "pyvisco",
            "lawson1974": "fit_prony",
        }.get(key) or author.split("author = {")[1].split(",")[0]
        assert words in str(material.source)


def test_a_target_that_recedes_is_cited() -> None:
    fixed, free = (impact(SERIES, rs.Parabola(1.0), **extra) for extra in ({}, {"impedance": 2.0}))
    assert keys(free) - keys(fixed) == {"zener1941"}


def test_friction_is_cited() -> None:
    smooth, rough = (impact(SERIES, rs.Parabola(1.0), **extra) for extra in ({}, {"friction": 0.3}))
    assert keys(rough) - keys(smooth) == {"maw1976", "mindlin1953"}


def test_adhesion_is_cited() -> None:
    bare, sticky = (impact(SERIES, rs.Parabola(1.0), **extra) for extra in ({}, {"adhesion": rs.Adhesion(1e-3)}))
    assert keys(sticky) - keys(bare) == {"maugis1992"}


def test_a_shift_is_cited_where_it_is_used() -> None:
    rubber = rs.library.get("polyisobutylene")
    assert not keys(rubber) & {"williams1955", "ferry1980"}
    assert keys(rubber.at(273.15)) >= {"williams1955", "ferry1980", "catsiff1955", "brinson2008"}
    glass = rs.Material(SERIES.shear, 1e9, shift=rs.Arrhenius(300.0, 1e5))
    assert keys(glass.at(310.0)) == {"ferry1980"}


def test_two_materials() -> None:
    pair = impact(rs.library.get("epoxy"), rs.Parabola(1.0), counter_material=rs.library.get("steel"))
    assert keys(pair) >= {"simon2000", "en1993"}


@pytest.mark.parametrize(("method", "expected"), [("exact", {"hairer1996"}), ("elements", {"willert"})])
def test_results_name_their_method(method: str, expected: set[str]) -> None:
    punch = impact(SERIES, rs.FlatPunch(1.0))
    nothing = dict.fromkeys(ImpactResult.__dataclass_fields__) | {"impact": punch, "method": method}
    assert keys(ImpactResult(**nothing)) == keys(punch) | expected
    several = ImpactResult(**nothing | {"impact": [punch, impact(SERIES, rs.Cone(1.0))]})
    assert keys(several) == keys(punch) | expected | {"love1939", "sneddon1965"}
    fall = Bounces(**dict.fromkeys(Bounces.__dataclass_fields__) | {"impact": punch})
    assert keys(fall) == keys(punch) | {"hairer1996"}


def test_each_source_appears_once_with_its_use() -> None:
    text = cite(RUBBER, impact(RUBBER, rs.Cone(1.0)), rs.Cone(1.0))
    assert text.count("@article{love1939,") == 1
    assert "% contact of viscoelastic bodies while it grows\n@article{lee1960," in text
    assert text.count("% contact of a cone\n") == 1


def test_the_program_itself() -> None:
    assert keys() == {"restitution", "willert"}
    assert f"version = {{{rs.__version__}}}" in cite()


def test_anything_else_is_refused() -> None:
    with pytest.raises(TypeError, match=r"^subject = 3: must be an Impact, a result, a Case, a Material or a"):
        cite(3)
    assert in_one_line(lambda: cite(SimpleNamespace(material=RUBBER)), TypeError).field == "subject"


def test_cases_cite_fits_and_methods(tmp_path: Path) -> None:
    t = np.geomspace(1e-3, 1e3, 31)
    rows = "\n".join(f"{a:.9g},{3 + 4 * math.exp(-a):.9g}" for a in t)
    (tmp_path / "data.csv").write_text(f"t,G\ns,MPa\n{rows}\n")
    fitted = 'file = "data.csv"\ndeformation = "shear"\nbulk_modulus = "1 GPa"\n'
    case_file(tmp_path / "case.toml", material=fitted)
    assert "lawson1974" in keys(rs.read_case(tmp_path / "case.toml"))
    sections = 'library = "epoxy"\n[solver]\nmethod = "elements"\n'
    case_file(tmp_path / "case.toml", material=sections)
    assert keys(rs.read_case(tmp_path / "case.toml")) == THEORY | {"restitution", "hertz1882", "simon2000", "willert"}


def test_a_fractional_model_cites_its_source() -> None:
    gel = rs.FractionalMaterial(rs.springpot(1e4, 0.3), bulk=1e9, rtol=1e-2)
    assert keys(gel.within((1e-3, 1.0))) == {"mainardi2010"}
