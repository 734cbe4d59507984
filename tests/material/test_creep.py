"""Creep compliances: the relaxation that belongs to them has a closed form, which is not that of the fit."""

import json
from pathlib import Path

import numpy as np
import pytest

from cases import case_file
from commands import done
from refusals import in_one_line, warns
from restitution import CreepTable, PronySeries, fit_prony, read_case
from restitution.material.readers import parse

# Misfit that a fit may have, and what it lets a relaxation modulus differ by: it falls twice as fast as J rises where
# both change most, and terms of the fit are close to each other.
MISFIT = 2e-3
CLOSE = 10.0 * MISFIT
TIME = np.geomspace(1e-3, 1e3, 91)


@pytest.fixture
def rng() -> np.random.Generator:
    return np.random.default_rng(2024)


def test_a_standard_solid(rng: np.random.Generator) -> None:
    """J(t) = 1/G - (1/G - 1/G0) exp(-t G/(tau G0)) belongs to R(t) = G + (G0 - G) exp(-t/tau)."""
    for _ in range(5):
        low, branch, tau = 10.0 ** rng.uniform([5.5, 5.5, -2], [6.5, 6.5, 1])
        high = low + branch
        compliance = 1.0 / low - (1.0 / low - 1.0 / high) * np.exp(-TIME * low / (tau * high))
        fit = fit_prony(CreepTable(TIME, compliance))
        assert fit.misfit <= 1.1 * MISFIT  # or a hundredth above that of the densest grid
        np.testing.assert_allclose(fit.series.relaxation_modulus(TIME), low + branch * np.exp(-TIME / tau), rtol=CLOSE)
        assert fit.window == (TIME[0], TIME[-1])


def test_a_maxwell_element_flows(rng: np.random.Generator) -> None:
    """J(t) = 1/G + t/eta belongs to R(t) = G exp(-t G/eta)."""
    modulus, viscosity = 10.0 ** rng.uniform([4, 4], [7, 7])
    fit = fit_prony(CreepTable(TIME, 1.0 / modulus + TIME / viscosity), liquid=True)
    assert fit.series.is_liquid
    # The fit is exact: both are numbers of the unknowns.
    assert fit.series.branch_moduli == pytest.approx([modulus], rel=1e-9)
    assert fit.series.relaxation_times == pytest.approx([viscosity / modulus], rel=1e-9)


def test_a_dashpot_in_parallel_has_no_instantaneous_compliance() -> None:
    """J(t) = (1 - exp(-t G/eta))/G belongs to G and a dashpot eta."""
    modulus, viscosity = 5e5, 5e5
    time = np.geomspace(1e-2, 10.0, 20)
    fit = fit_prony(CreepTable(time, -np.expm1(-time * modulus / viscosity) / modulus))
    assert fit.series.equilibrium_modulus == pytest.approx(modulus, rel=MISFIT)
    assert fit.series.parallel_viscosity == pytest.approx(viscosity, rel=2.0 * CLOSE)


def test_scatter_is_that_of_the_data(rng: np.random.Generator) -> None:
    series = PronySeries(1e6, [2e6, 8e6], [1.0, 0.03])
    scattered = series.creep_compliance(TIME) * (1.0 + 0.01 * rng.standard_normal(TIME.size))
    fit = fit_prony(CreepTable(TIME, scattered))
    assert 0.007 < fit.misfit < 0.013
    with warns("fit"):
        fit_prony(CreepTable(TIME, np.full(TIME.size, 2e-6)))


@pytest.mark.parametrize(
    ("text", "deformation"),
    [
        ("t,J\ns,1/MPa\n1,2\n10,3\n", "shear"),
        ("time [s];J(t) [1/MPa]\n10;3,0\n1;2,0\n", "shear"),
        ("t/s,D(t)/MPa^-1\n1,2\n10,3\n", "tension"),
        ("t_ms,compliance_1/MPa\n1000,2\n10000,3\n", None),
        ("[step]\nCreep - 1\nStep time\tTime\tCreep compliance\ns\ts\t1/MPa\n1\t1\t2\n1\t10\t3\n"
         "[step]\nRecovery\nStep time\tTime\tCreep compliance\ns\ts\t1/MPa\n1\t1\t3\n1\t10\t2\n", None),
    ],
)  # fmt: skip
def test_tables_are_read(text: str, deformation: str | None) -> None:
    table = parse(text)
    assert isinstance(table, CreepTable)
    assert (table.time.tolist(), table.deformation) == ([1.0, 10.0], deformation)
    assert table.compliance == pytest.approx([2e-6, 3e-6], rel=1e-15)


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("t,J\ns,Pa\n1,2\n", "unit 'Pa': must be a unit of compliance, such as 1/Pa"),
        ("t,J\ns,1/Pa\n1,2\n2,1\n", "line 4: J is 1 1/Pa, and 2 1/Pa in line 3: must rise over time"),
        ("t,J\ns,1/Pa\n1,2\n2,0\n", "line 4: J = 0: must be finite and > 0"),
        ("t,J,T\ns,1/Pa,°C\n1,2,20\n2,3,20\n1,3,40\n2,4,40\n", "holds several creep tests"),
    ],
)
def test_tables_that_are_no_creep_are_refused(text: str, words: str) -> None:
    assert words in str(in_one_line(lambda: parse(text, "x")))


@pytest.mark.usefixtures("folder")
def test_creep_gives_the_rebound_of_its_relaxation() -> None:
    """A standard solid by its constants, and by a file of its compliance."""
    low, high, tau = 1e6, 11e6, 1e-3
    time = np.geomspace(1e-6, 1.0, 121)
    compliance = 1.0 / low - (1.0 / low - 1.0 / high) * np.exp(-time * low / (tau * high))
    rows = "\n".join(f"{t!r},{j!r}" for t, j in zip(time.tolist(), compliance.tolist(), strict=True))
    Path("creep.csv").write_text(f"t,J\ns,1/Pa\n{rows}\n")
    case_file("creep.toml", material='file = "creep.csv"\npoisson_ratio = 0.5')
    solid = 'equilibrium_modulus = "1 MPa"\nbranch_modulus = "10 MPa"\nviscosity = "10 kPa s"\npoisson_ratio = 0.5'
    case_file("solid.toml", material=solid)
    measured, exact = (read_case(name).solve().restitution_coefficient for name in ("creep.toml", "solid.toml"))
    assert measured == pytest.approx(exact, abs=CLOSE)
    content = json.loads(done("material", "creep.csv", "--json", "--plot", "p.svg").stdout)
    assert content["kind"] == "creep compliance over time"
    assert "creep compliance" in Path("p.svg").read_text()
