"""Verdicts on the claims of the paper, for made-up and for computed numbers."""

import json

import numpy as np
import pytest
import xarray as xr

from restitution.paper import claims
from restitution.paper.figures import Computation


def plane(e, nu: float) -> xr.Dataset:
    e = np.atleast_2d(e)
    axes = {"p2": np.logspace(-3, 1, e.shape[0]), "p3": np.logspace(-2, 2, e.shape[1])}
    return xr.Dataset({"restitution_coefficient": (("p2", "p3"), e)}, {**axes, "poisson_ratio": nu}, {"rtol": 1e-9})


def comparison(e, e_inc) -> xr.Dataset:
    return claims.compare(plane(e, 0.45), plane(e_inc, 0.5))


def curves(e, e_inc) -> dict[int, xr.Dataset]:
    rows = np.array([e, e_inc])
    coordinates = {"poisson_ratio": [0.45, 0.5], "p2": 0.01, "p3": np.logspace(-2, 2, rows.shape[1])}
    return {5: xr.Dataset({"restitution_coefficient": (("poisson_ratio", "p3"), rows)}, coordinates)}


E = np.array([0.05, 0.2, 0.5, 0.8, 0.95])


def test_the_example_of_the_paper_near_one_half() -> None:
    claim = claims.large_near_half(Computation(seed=1))
    # Six digits from two independent programs.
    assert claim.numbers["e, nu = 0.49"] == pytest.approx(0.219706, abs=5e-7)
    assert claim.numbers["e, incompressible"] == pytest.approx(0.006553, abs=5e-7)
    assert claim.numbers["(e - e_inc)/e_inc, nu = 0.49"] == pytest.approx(0.219706 / 0.006553 - 1, rel=1e-4)
    assert claim.numbers["(e_inc - e)/e, nu = 0.49"] == pytest.approx(0.006553 / 0.219706 - 1, rel=1e-4)
    assert claim.holds
    assert "e = 0.219706 against 0.006553" in claim.finding


def test_the_first_claim_holds_for_a_spread_within_the_tolerance_only() -> None:
    for relative, holds in ((0.9, True), (1.1, False)):
        collapse = xr.Dataset({"spread": ("p2", [1e-12, 3e-12]), "relative_spread": ("p2", [0.1, relative])})
        claim = claims.three_groups(collapse.assign_coords(draw=[0, 1, 2]))
        assert claim.holds is holds
        assert claim.numbers["largest spread of e between two draws"] == 3e-12
        assert claim.numbers["draws at each"] == 3


def test_the_second_claim_holds_for_errors_that_fall_with_e_only() -> None:
    claim = claims.matters_where_small(comparison(E, E * (1 - 0.5 * (1 - E))))
    assert claim.holds
    assert claim.numbers["rank correlation of e and relative error"] == pytest.approx(-1.0)
    assert claim.numbers["median relative error where 0.1 <= e <= 0.3"] == pytest.approx(0.4)
    assert claim.numbers["e where the relative error is largest"] == 0.05
    assert not claims.matters_where_small(comparison(E, E * (1 - 0.5 * E))).holds
    almost = claims.matters_where_small(comparison(E, E * (1 - np.array([0.4, 0.5, 0.3, 0.2, 0.1]))))
    assert almost.numbers["rank correlation of e and relative error"] == pytest.approx(-0.9)
    assert not almost.holds


def test_the_third_claim_depends_on_the_share_of_underestimates() -> None:
    factor = np.array([0.5, 0.9, 0.99, 1.0 + 1e-12, 1.03])
    claim = claims.usually_underestimates(comparison(E, E * factor), curves(E, E * factor))
    assert claim.holds
    assert claim.numbers["share of underestimates on the plane of figures 3 and 4, nu = 0.45"] == 0.6
    assert claim.numbers["share of underestimates on the curve of figure 5, nu = 0.45"] == 0.6
    assert claim.numbers["largest overestimate, relative"] == pytest.approx(0.03)
    assert claim.numbers["log10 p3 there"] == pytest.approx(2.0)
    assert not claims.usually_underestimates(comparison(E, E / factor), curves(E, E * factor)).holds
    assert not claims.usually_underestimates(comparison(E, E * factor), curves(E, E / factor)).holds


def test_json_has_every_number_in_full_and_markdown_every_finding() -> None:
    verdicts = [
        claims.Claim("first", "One is two.", False, "It is not.", {"one": 1.0 / 3.0}),
        claims.Claim("second", "Two is two.", True, "It is.", {"two": 2.0}),
    ]
    attributes = Computation(seed=7).attributes()
    read = json.loads(claims.as_json(verdicts, attributes))
    assert read["seed"] == 7
    assert [(claim["name"], claim["holds"], claim["numbers"]) for claim in read["claims"]] == [
        ("first", False, {"one": 1.0 / 3.0}),
        ("second", True, {"two": 2.0}),
    ]
    page = claims.as_markdown(verdicts, attributes)
    assert "| first | **no** |" in page
    assert "**Confirmed.** It is." in page
    assert "| one | 0.333333 |" in page


def test_the_incompressible_material_is_stiffer_instantaneously_and_at_rest_only() -> None:
    claim = claims.stiffer()
    assert claim.holds
    # E* = 4 G (3K + G)/(3K + 4G) against 4 G, with 3K = 149 Ginf, at G0 = 1001 Ginf and at Ginf.
    for words, g in (("instantaneous", 1001.0), ("equilibrium", 1.0)):
        expected = (149.0 + 4.0 * g) / (149.0 + g)
        assert claim.numbers[f"{words} E*_inc/E*, nu = 0.49, p2 = 0.001"] == pytest.approx(expected, rel=1e-9)
    assert claim.numbers["smallest E*_inc(t)/E*(t), nu = 0.49, p2 = 0.001"] < 1.0


def test_several_relaxation_times_keep_e_low() -> None:
    terms = claims.compute_terms(Computation(seed=1), 5)
    assert claims.several_times(terms).holds
    e = terms["restitution_coefficient"]
    assert not claims.several_times(terms.assign(restitution_coefficient=1.0 - e)).holds


def test_two_equal_spheres_are_one_with_another_p3() -> None:
    claim = claims.two_spheres(Computation(seed=5))
    assert claim.holds
    # Both results have an error within the tolerance.
    assert claim.numbers["largest difference of e"] < 2e-9
