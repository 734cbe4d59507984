"""Standard deviations of outputs against closed forms, exact draws and identified materials."""

import math
import pickle
from typing import Any

import numpy as np
import pytest
import xarray as xr

import restitution as rs
from cases import BALL, RUBBER
from refusals import named

pytestmark = pytest.mark.filterwarnings("ignore::restitution.errors.RestitutionWarning")
RNG = np.random.default_rng()
ELASTIC = rs.elastic(shear_modulus=1e6, poisson_ratio=0.3)
HERTZ = rs.Impact(ELASTIC, rs.Parabola(0.01), mass=0.005, velocity=1.0)
# T ~ (m/E*)^(2/5) R^(-1/5) v^(-1/5) and F ~ E*^(2/5) R^(1/5) m^(3/5) v^(6/5) (Hertz 1882), with E* ~ G.
POWERS = {
    "contact_time": {"velocity": -0.2, "mass": 0.4, "radius": -0.2, "equilibrium_modulus": -0.4},
    "max_force": {"velocity": 1.2, "mass": 0.6, "radius": 0.2, "equilibrium_modulus": 0.4},
}
AT = {"velocity": 1.0, "mass": 0.005, "radius": 0.01, "equilibrium_modulus": 1e6}


def test_independent_inputs_of_hertz() -> None:
    """Relative variances add with the squares of the powers."""
    relative = dict(zip(AT, RNG.uniform(0.005, 0.05, 4).tolist(), strict=True))
    result = rs.uncertainty(
        HERTZ, {name: size * AT[name] for name, size in relative.items()}, POWERS, held="poisson_ratio"
    )
    for output, powers in POWERS.items():
        parts = np.array([(powers[name] * relative[name]) ** 2 for name in AT])
        value, deviation = result[output]
        assert deviation / value == pytest.approx(math.sqrt(parts.sum()), rel=1e-7)
        row = result.shares[result.outputs.index(output)]
        assert row == pytest.approx(parts / parts.sum(), rel=1e-6)
    both = sum(POWERS["contact_time"][name] * POWERS["max_force"][name] * relative[name] ** 2 for name in AT)
    product = result.values["contact_time"] * result.values["max_force"]
    assert result.covariance[0, 1] == pytest.approx(both * product, rel=1e-6)
    assert result.status == rs.UncertaintyStatus.LINEAR
    assert result.warnings == ()


def test_correlated_inputs() -> None:
    """Mass and radius that scatter as one number: T ~ m^(2/5) R^(-1/5), so that parts of the scatter cancel."""
    relative, names = 0.02, ("mass", "radius")
    scale = np.array([AT[name] for name in names]) * relative
    whole = rs.uncertainty(HERTZ, {names: np.outer(scale, scale)}, "contact_time")
    value, deviation = whole["contact_time"]
    assert deviation / value == pytest.approx(0.2 * relative, rel=1e-7)
    # Shares J_k (C J)_k/var: 0.4 (0.4 - 0.2) and -0.2 (0.4 - 0.2) over 0.2^2.
    assert whole.shares[0] == pytest.approx([2.0, -1.0], rel=1e-6)


def test_draws_of_a_power_law_are_those_of_its_formula() -> None:
    """The same random numbers through T ~ v^(-1/5) by hand."""
    result = rs.uncertainty(HERTZ, {"velocity": 0.05}, "contact_time", draws=400, rng=7)
    velocity = 1.0 + 0.05 * np.random.default_rng(7).standard_normal((1, 400))[0]
    time = result.values["contact_time"] * velocity**-0.2
    assert result.drawn is not None
    # Draws are solved to 1e-7.
    assert result.drawn.mean["contact_time"] == pytest.approx(time.mean(), rel=1e-6)
    assert result.drawn.standard_deviation["contact_time"] == pytest.approx(time.std(ddof=1), rel=1e-4)
    assert result.drawn.covariance[0, 0] == pytest.approx(time.var(ddof=1), rel=1e-4)
    assert [result.drawn.low["contact_time"], result.drawn.high["contact_time"]] == pytest.approx(
        np.quantile(time, (0.025, 0.975)).tolist(), rel=1e-6
    )
    assert result.status == rs.UncertaintyStatus.CONFIRMED
    again = rs.uncertainty(HERTZ, {"velocity": 0.05}, "contact_time", draws=400, rng=np.random.default_rng(7))
    assert again.drawn is not None
    assert again.drawn.mean == result.drawn.mean


def test_draws_of_correlated_inputs_have_their_covariance() -> None:
    """T ~ m^(2/5) R^(-1/5) does not change where R ~ m^2, to first order in a scatter of 1 %."""
    scale = 0.01 * np.array([AT["mass"], 2.0 * AT["radius"]])
    result = rs.uncertainty(HERTZ, {("mass", "radius"): np.outer(scale, scale)}, "contact_time", draws=200, rng=RNG)
    assert result.drawn is not None
    value, deviation = result["contact_time"]
    assert deviation < 1e-7 * value
    # 0.4 ln(1 + x) - 0.2 ln(1 + 2 x) = 0.2 x^2 to second order, with the deviation 0.2 sqrt(2) x^2.
    assert result.drawn.standard_deviation["contact_time"] < 1e-4 * value
    assert result.status == rs.UncertaintyStatus.DIFFERS


def test_curvature_is_warned_of_and_found_by_draws() -> None:
    """Where e over the viscosity is largest or least, its slope is zero, and the linear deviation with it."""
    low, high = 10.0, 1e6
    for _ in range(60):
        middle = math.sqrt(low * high)
        slope = rs.derivatives(rs.vary(BALL, {"viscosity": middle}), "viscosity", "restitution_coefficient", rtol=1e-9)
        low, high = (middle, high) if slope.matrix[0, 0] < 0.0 else (low, middle)
    least = rs.vary(BALL, {"viscosity": low})
    linear = rs.uncertainty(least, {"viscosity": 0.1 * low}, "restitution_coefficient")
    assert any(line.startswith("linear: ") for line in linear.warnings)
    drawn = rs.uncertainty(least, {"viscosity": 0.1 * low}, "restitution_coefficient", draws=300, rng=1)
    assert drawn.status == rs.UncertaintyStatus.DIFFERS
    assert drawn.drawn is not None
    assert drawn.drawn.mean["restitution_coefficient"] > drawn.values["restitution_coefficient"]


def test_draws_stay_in_the_range() -> None:
    """Half of the draws about nu = 1/2 are outside; the others are half a normal distribution."""
    result = rs.uncertainty(rs.vary(HERTZ, {"nu": 0.5}), {"nu": 0.01}, "contact_time", draws=500, rng=RNG)
    assert result.drawn is not None
    assert 300 < result.drawn.outside < 800
    assert any(line.startswith("draws: ") for line in result.warnings)
    # T ~ (1 - nu)^(2/5) at a constant G: a shift of the mean by 0.8 deviations of nu, sqrt(2/pi).
    shift = result.drawn.mean["contact_time"] / result.values["contact_time"] - 1.0
    expected = 0.4 * 0.01 / 0.5 * math.sqrt(2.0 / math.pi)
    assert shift == pytest.approx(expected, rel=5.0 * math.sqrt((math.pi / 2.0 - 1.0) / 500.0))


def test_bodies_that_stay_have_no_contact_time() -> None:
    """A weight holds the slow ones of the drawn bodies: e is 0, which counts, and the contact has no end."""
    soft = rs.standard_solid(1e4, 1e7, 1e3, poisson_ratio=0.45)
    ball = rs.Impact(soft, rs.Parabola(0.01), mass=0.005, velocity=1.0, external_force=0.05)
    low, high = 1e-4, 1.0
    for _ in range(20):
        middle = math.sqrt(low * high)
        captured = rs.solve(rs.vary(ball, {"velocity": middle})).status != rs.Status.SEPARATED
        low, high = (middle, high) if captured else (low, middle)
    outputs = ("restitution_coefficient", "contact_time")
    result = rs.uncertainty(
        rs.vary(ball, {"velocity": 1.5 * high}), {"velocity": 0.4 * high}, outputs, draws=200, rng=1
    )
    velocity = 1.5 * high + 0.4 * high * np.random.default_rng(1).standard_normal((1, 200))[0]
    assert result.drawn is not None
    assert result.drawn.lost == {"restitution_coefficient": 0, "contact_time": int((velocity < high).sum())}
    assert np.isfinite(result.drawn.mean["contact_time"])
    assert np.isnan(result.drawn.covariance).tolist() == [[False, True], [True, True]]
    assert any("contact_time" in line for line in result.warnings)


def test_number_at_zero() -> None:
    result = rs.uncertainty(HERTZ, {"external_force": 0.05}, "max_indentation_depth")
    # The largest depth grows by F0 d/F_max, from the balance of energies.
    depth = result.values["max_indentation_depth"]
    force = float(rs.solve(HERTZ).max_force)
    assert result.standard_deviations["max_indentation_depth"] == pytest.approx(0.05 * float(depth) / force, rel=1e-6)


def test_arrays_have_the_deviations_of_their_impacts() -> None:
    velocity = xr.DataArray([0.5, 1.0, 2.0], dims="velocity", coords={"velocity": [0.5, 1.0, 2.0]})
    several = rs.vary(BALL, {"velocity": velocity})
    inputs = {"velocity": 0.02, "viscosity": 50.0}
    result = rs.uncertainty(several, inputs, draws=20, rng=3)
    single = rs.uncertainty(rs.vary(BALL, {"velocity": 2.0}), inputs, draws=20, rng=3)
    assert result.covariance[..., 2] == pytest.approx(single.covariance, rel=1e-6)
    assert result.shares[..., 2] == pytest.approx(single.shares, rel=1e-6)
    table = result.to_dataset()
    assert table["contact_time_deviation"].sel(velocity=2.0) == pytest.approx(single["contact_time"][1], rel=1e-6)
    assert table["contact_time_share"].sizes == {"input": 2, "velocity": 3}
    assert result.drawn is not None
    assert single.drawn is not None
    mean = table["contact_time_drawn_mean"].sel(velocity=2.0)
    assert mean == pytest.approx(single.drawn.mean["contact_time"], rel=1e-6)
    assert "largest deviation" in str(result)


def identified() -> Any:
    """A standard solid from moduli that scatter, whose covariance is not that of independent constants."""
    t = np.geomspace(1e-5, 1e-2, 40)
    modulus = (1e6 + 1e7 * np.exp(-t / 1e-4)) * np.exp(0.02 * np.random.default_rng(5).standard_normal(40))
    return rs.identify(rs.RelaxationTable(t, modulus, "shear"), rs.standard_solid, fixed={"poisson_ratio": 0.45})


def test_identified_material() -> None:
    """The error bars of an identification: predict has bands by its own differences, and SI follows from logarithms."""
    solid = identified()
    result = rs.uncertainty(BALL, solid)
    assert result.inputs == tuple(solid.parameters)
    band = solid.predict(BALL, level=0.68)
    width = solid.uncertainty.quantile(0.68)
    for name in result.outputs:
        spread = math.log(float(band[f"{name}_high"][0] / band[name][0])) / width
        value, deviation = result[name]
        assert value == pytest.approx(float(band[name][0]), rel=1e-6)
        assert deviation / value == pytest.approx(spread, rel=1e-4)
    # Of logarithms, the covariance in SI has the product of the values as a factor.
    values = np.array([solid.parameters[name].value for name in result.inputs])
    assert result.input_covariance == pytest.approx(solid.covariance * np.outer(values, values), rel=1e-9)


def test_identified_material_beside_other_inputs() -> None:
    solid = identified()
    alone, ball = (rs.uncertainty(BALL, solid), rs.vary(BALL, {"material": solid.material}))
    velocity = rs.uncertainty(ball, {"velocity": 0.02})
    both = rs.uncertainty(BALL, {"material": solid, "velocity": 0.02}, draws=300, rng=2)
    for name in both.outputs:
        expected = math.hypot(alone[name][1], velocity[name][1])
        assert both[name][1] == pytest.approx(expected, rel=1e-6)
    assert both.status == rs.UncertaintyStatus.CONFIRMED


@pytest.mark.parametrize(
    ("inputs", "options", "where"),
    [
        ({}, {}, ("inputs",)),
        ({"pace": 1.0}, {}, ("names",)),
        ({"velocity": 0.0}, {}, ("inputs.velocity", 0.0)),
        ({"velocity": -1.0}, {}, ("inputs.velocity", -1.0)),
        ({"nu": 0.1, ("poisson_ratio",): [[0.01]]}, {}, ("inputs",)),
        ({("mass", "radius"): [[1.0, 2.0], [2.0, 1.0]]}, {}, ("inputs.mass, radius",)),
        ({("mass", "radius"): [[1.0, 0.2], [0.1, 1.0]]}, {}, ("inputs.mass, radius",)),
        ({("mass", "radius"): [1.0, 2.0]}, {}, ("inputs.mass, radius",)),
        ({3: 1.0}, {}, ("inputs", "3")),
        ({"velocity": 0.1}, {"draws": 3}, ("draws", 3)),
        ({"velocity": 0.1}, {"outputs": ["speed"]}, ("outputs", "speed")),
    ],
)
def test_refused(inputs: Any, options: dict[str, Any], where: tuple[Any, ...]) -> None:
    assert named(lambda: rs.uncertainty(BALL, inputs, **options)) == where


@pytest.mark.parametrize(
    ("inputs", "options", "field"),
    [
        ([0.1], {}, "inputs"),
        ({"velocity": 0.1}, {"draws": 20, "rng": "dice"}, "rng"),
        ({"material": RUBBER}, {}, "inputs.material"),
    ],
)
def test_refused_types(inputs: Any, options: dict[str, Any], field: str) -> None:
    assert named(lambda: rs.uncertainty(BALL, inputs, **options))[0] == field


def test_shows_itself() -> None:
    result = rs.uncertainty(BALL, {"velocity": 0.02, "viscosity": 50.0}, draws=20, rng=1)
    text = str(result)
    assert "+-" in text
    assert "95 % of draws" in text
    numbers = result.to_dict()
    assert numbers["status"] in (0, 1, 2)
    assert numbers["drawn"]["number"] == 20
    bars: Any = result.plot().axes[0].patches
    widths = [bar.get_width() for bar in bars]
    assert widths == pytest.approx((100.0 * result.shares.T).ravel().tolist())


TIMES = np.geomspace(1e-5, 1.0, 60)
MODULUS = rs.PronySeries(1e6, [3e6, 5e6], [1e-4, 1e-2]).relaxation_modulus(TIMES)


def fitted(factor: float = 1.0, deformation: Any = "shear") -> Any:
    scatter = 1.0 + 0.02 * np.random.default_rng(1).standard_normal(TIMES.size)
    return rs.fit_prony(rs.RelaxationTable(TIMES, factor * MODULUS * scatter, deformation))


def test_a_fit_is_its_moduli_with_their_covariance() -> None:
    """By the terms' own names, and for the same material measured in tension, where E = 3G (incompressible)."""
    fit = fitted()
    ball = rs.Impact(fit.material(poisson_ratio=0.5), rs.Parabola(0.01), mass=0.005, velocity=1.0)
    named_ones = rs.uncertainty(ball, {fit.names: fit.covariance})
    for source in (fit, fitted(3.0, "tension")):
        whole = rs.uncertainty(ball, {"material": source.scattered(poisson_ratio=0.5)})
        for name in whole.outputs:
            assert whole[name] == pytest.approx(named_ones[name], rel=1e-9)


def test_an_error_of_the_shift_moves_all_times_together() -> None:
    """All times, contact time and velocity scale alike: e(tau c, v) = e(tau, v c^5) for a sphere (dimensions)."""
    fit, error = fitted(), 0.05
    ball = rs.Impact(fit.material(poisson_ratio=0.5), rs.Parabola(0.01), mass=0.005, velocity=1.0)
    scattered = fit.scattered(poisson_ratio=0.5, log10_factor_error=error)
    result = rs.uncertainty(ball, {"material": scattered}, "restitution_coefficient")
    place = result.inputs.index("shift_factor")
    by_velocity = rs.derivatives(ball, ["velocity"], "restitution_coefficient")["restitution_coefficient", "velocity"]
    # T ~ (m^2/(E*^2 R v))^(1/5): relaxation times that are longer by c are a contact that is shorter by c, v by c^5.
    part = abs(5.0 * by_velocity) * math.log(10.0) * error
    _, deviation = result["restitution_coefficient"]
    assert result.shares[0, place] * deviation**2 == pytest.approx(part**2, rel=1e-6)
    shifted = fit.scattered(poisson_ratio=0.5, log10_factor=0.3, log10_factor_error=error)
    moved = rs.uncertainty(ball, {"material": shifted}, "restitution_coefficient").values["restitution_coefficient"]
    assert moved == pytest.approx(rs.solve(rs.vary(ball, {"velocity": 10.0**1.5})).restitution_coefficient, rel=1e-8)


@pytest.mark.parametrize("draws", [None, 20])
def test_results_are_pickled(draws: int | None) -> None:
    """A pool of processes sends them back."""
    result = rs.uncertainty(BALL, {"velocity": 0.01, "mass": 1e-5}, draws=draws)
    for whole in (result, result.derivatives):
        assert pickle.loads(pickle.dumps(whole)).to_dataset().equals(whole.to_dataset())
