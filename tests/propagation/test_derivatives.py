"""Derivatives of impacts against closed forms that mpmath differentiates, and against dimensional analysis."""

import math
from typing import Any

import mpmath as mp
import numpy as np
import pytest
import xarray as xr

import restitution as rs
from cases import BALL
from refusals import named

pytestmark = pytest.mark.filterwarnings("ignore::restitution.errors.RestitutionWarning")
RNG = np.random.default_rng()
# The accuracy that the documentation states.
RTOL = 1e-7
FOUR = ("restitution_coefficient", "contact_time", "max_indentation_depth", "max_force")


def differentiated(function: Any, numbers: dict[str, float], name: str) -> float:
    """Derivative of a function of named numbers by one of them, with 40 digits."""
    with mp.workdps(40):
        exact = {key: mp.mpf(value) for key, value in numbers.items()}
        return float(mp.diff(lambda x: function(**{**exact, name: x}), exact[name]))


def hertz_depth(velocity: Any, mass: Any, radius: Any, equilibrium_modulus: Any, poisson_ratio: Any) -> Any:
    """Largest depth of an elastic sphere: 8/15 E* sqrt(R) d^2.5 = m v^2/2 with E* = 2 G/(1 - nu) (Hertz 1882)."""
    modulus = 2 * equilibrium_modulus / (1 - poisson_ratio)
    return (15 * mass * velocity**2 / (16 * modulus * mp.sqrt(radius))) ** (mp.mpf(2) / 5)


def hertz_time(**numbers: Any) -> Any:
    """Contact time 4 sqrt(pi) Gamma(2/5)/(5 Gamma(9/10)) d/v."""
    factor = 4 * mp.sqrt(mp.pi) * mp.gamma(mp.mpf(2) / 5) / (5 * mp.gamma(mp.mpf(9) / 10))
    return factor * hertz_depth(**numbers) / numbers["velocity"]


def hertz_force(**numbers: Any) -> Any:
    return mp.mpf(5) / 4 * numbers["mass"] * numbers["velocity"] ** 2 / hertz_depth(**numbers)


def test_elastic_spheres() -> None:
    numbers = {
        "velocity": float(10.0 ** RNG.uniform(-2.0, 1.0)),
        "mass": float(10.0 ** RNG.uniform(-4.0, 0.0)),
        "radius": float(10.0 ** RNG.uniform(-3.0, -1.0)),
        "equilibrium_modulus": float(10.0 ** RNG.uniform(5.0, 10.0)),
        "poisson_ratio": float(RNG.uniform(-0.5, 0.49)),
    }
    solid = rs.elastic(shear_modulus=numbers["equilibrium_modulus"], poisson_ratio=numbers["poisson_ratio"])
    ball = rs.Impact(solid, rs.Parabola(numbers["radius"]), mass=numbers["mass"], velocity=numbers["velocity"])
    result = rs.derivatives(ball, numbers, FOUR)
    forms = {"contact_time": hertz_time, "max_indentation_depth": hertz_depth, "max_force": hertz_force}
    for output, form in forms.items():
        for name in numbers:
            exact = differentiated(form, numbers, name)
            assert result[output, name] == pytest.approx(exact, rel=RTOL, abs=0.0), (output, name)
            error = result.errors[result.outputs.index(output), result.inputs.index(name)]
            # The estimate covers the error down to the rounding of the derivative itself.
            assert abs(result[output, name] - exact) < error + 1e-14 * abs(exact)
    # e is 1, whatever the numbers are.
    assert np.all(np.abs(result.elasticities[0]) < RTOL)
    assert result.warnings == ()


def punch(name: str, **numbers: float) -> rs.Impact:
    """A flat punch on an incompressible material with E* = 4 G."""
    build = getattr(rs, name)
    solid = build(numbers["modulus"], numbers["viscosity"], bulk_modulus=np.inf)
    return rs.Impact(solid, rs.FlatPunch(numbers["radius"]), mass=numbers["mass"], velocity=1.0)


def test_a_result_has_the_derivatives_of_its_impact() -> None:
    """Hertz: the contact time grows as v^(-1/5) m^(2/5)."""
    ball = rs.Impact(rs.elastic(shear_modulus=80e9, poisson_ratio=0.3), rs.Parabola(0.01), mass=0.03, velocity=0.1)
    by = rs.solve(ball).derivatives(["velocity", "mass"], ["contact_time"])
    assert by.elasticities == pytest.approx(np.array([[-0.2, 0.4]]), abs=RTOL)


def test_flat_punch_on_kelvin_voigt() -> None:
    """e = exp(-2 D acos(D)/sqrt(1 - D^2)) with D = tau sqrt(2 E* a/m)/2 (Schwager and Poeschel 2007)."""

    def restitution(mass: Any, radius: Any, equilibrium_modulus: Any) -> Any:
        damping = mp.mpf(900) / equilibrium_modulus * mp.sqrt(8 * equilibrium_modulus * radius / mass) / 2
        return mp.exp(-2 * damping * mp.acos(damping) / mp.sqrt(1 - damping**2))

    numbers = {"mass": float(RNG.uniform(0.5, 5.0)), "radius": 0.01, "equilibrium_modulus": 1e6}
    impact = punch("kelvin_voigt", modulus=1e6, viscosity=900.0, radius=0.01, mass=numbers["mass"])
    result = rs.derivatives(impact, [*numbers, "velocity"])
    for name in numbers:
        exact = differentiated(restitution, numbers, name)
        assert result["restitution_coefficient", name] == pytest.approx(exact, rel=RTOL, abs=0.0)
    assert abs(result["restitution_coefficient", "velocity"]) < RTOL


def test_flat_punch_on_maxwell() -> None:
    """e = exp(-pi D/sqrt(1 - D^2)) with D = sqrt(m/(2 E* a))/(2 tau), T half a period."""

    def rate(mass: Any, radius: Any, branch_modulus: Any, viscosity: Any) -> tuple[Any, Any]:
        natural = mp.sqrt(8 * branch_modulus * radius / mass)
        return natural, branch_modulus / viscosity / (2 * natural)

    def restitution(**numbers: Any) -> Any:
        damping = rate(**numbers)[1]
        return mp.exp(-mp.pi * damping / mp.sqrt(1 - damping**2))

    def time(**numbers: Any) -> Any:
        natural, damping = rate(**numbers)
        return mp.pi / (natural * mp.sqrt(1 - damping**2))

    numbers = {"mass": 1.0, "radius": 0.01, "branch_modulus": 1e6, "viscosity": float(RNG.uniform(2500.0, 1e4))}
    impact = punch("maxwell", modulus=1e6, viscosity=numbers["viscosity"], radius=0.01, mass=1.0)
    result = rs.derivatives(impact, numbers)
    for name in numbers:
        for output, form in (("restitution_coefficient", restitution), ("contact_time", time)):
            exact = differentiated(form, numbers, name)
            assert result[output, name] == pytest.approx(exact, rel=RTOL, abs=0.0), (output, name)


def random_ball() -> rs.Impact:
    low, high = RNG.uniform(5.0, 7.0), RNG.uniform(0.3, 2.0)
    solid = rs.standard_solid(
        10**low, 10 ** (low + high), 10 ** RNG.uniform(2.0, 4.0), poisson_ratio=RNG.uniform(0, 0.49)
    )
    mass, velocity, radius = 10 ** RNG.uniform(-3.0, -1.0), 10 ** RNG.uniform(-1.0, 0.5), 10 ** RNG.uniform(-2.5, -1.5)
    return rs.Impact(solid, rs.Parabola(radius), mass=mass, velocity=velocity)


def test_dimensional_analysis() -> None:
    """e depends on nu, Ginf/G1 and p3 = eta (v R/(m^2 Ginf^3))^(1/5) alone, so that its elasticities have ratios."""
    for _ in range(5):
        result = rs.derivatives(
            random_ball(), ["velocity", "radius", "mass", "viscosity", "equilibrium_modulus", "branch_modulus",
                            "poisson_ratio"], "restitution_coefficient",
        )  # fmt: skip
        velocity, radius, mass, viscosity, *moduli, _ = result.elasticities[0]
        errors = result.errors[0] * np.array([*result.at.values()]) / result.values["restitution_coefficient"]
        # Sums of several elasticities.
        bound = 3.0 * errors.max()
        assert bound < RTOL
        assert abs(velocity - viscosity / 5) < bound
        assert abs(radius - viscosity / 5) < bound
        assert abs(mass + 2 * viscosity / 5) < bound
        # At a constant Poisson ratio, which is among the names.
        assert abs(sum(moduli) + 3 * viscosity / 5) < bound


def test_material_without_bulk_stiffness() -> None:
    """At nu = -1, e is that of nu = 1/2 at 4^(-2/5) p3, and so is its elasticity by p3."""
    soft, hard = (
        rs.standard_solid(1.0, 3.0, eta, poisson_ratio=nu) for nu, eta in ((-1.0, 1.7), (0.5, 1.7 * 0.25**0.4))
    )
    slopes = [
        rs.derivatives(rs.Impact(solid, rs.Parabola(1.0), 1.0, 1.0), "p3", "restitution_coefficient").elasticities
        for solid in (soft, hard)
    ]
    assert slopes[0] == pytest.approx(slopes[1], rel=RTOL)


def test_end_of_a_range_is_left_to_one_side() -> None:
    """The slope at nu = 1/2 is the limit of slopes below it; e is smooth in nu."""
    at = rs.derivatives(rs.vary(BALL, {"nu": 0.5}), "nu")
    near = rs.derivatives(rs.vary(BALL, {"nu": [0.5 - 2e-4, 0.5 - 1e-4]}), "nu").matrix[:, 0]
    # The straight line through two slopes errs by the product of the two distances.
    limit = near[:, 1] + (near[:, 1] - near[:, 0])
    assert at.matrix[:, 0] == pytest.approx(limit, rel=1e-4)
    assert at.warnings == ()


def test_numbers_at_zero_take_a_step_of_the_user() -> None:
    """Energy balance of a weak force on an elastic half-space: the largest depth grows by dd = F0 d/F_max."""
    ball = rs.Impact(rs.elastic(shear_modulus=1e6, poisson_ratio=0.3), rs.Parabola(0.01), mass=0.005, velocity=1.0)
    assert named(lambda: rs.derivatives(ball, "external_force")) == ("external_force", 0.0)
    result = rs.derivatives(ball, "external_force", steps={"external_force": 0.01})
    depth, force = result.values["max_indentation_depth"], result.values["max_force"]
    assert result["max_indentation_depth", "external_force"] == pytest.approx(float(depth / force), rel=RTOL)


def test_arrays_have_the_derivatives_of_their_impacts() -> None:
    velocity = xr.DataArray([0.5, 1.0, 2.0], dims="velocity", coords={"velocity": [0.5, 1.0, 2.0]})
    radius = xr.DataArray([0.01, 0.02], dims="radius")
    several = rs.vary(BALL, {"velocity": velocity, "radius": radius})
    result = rs.derivatives(several, ["velocity", "viscosity"])
    assert result.matrix.shape == (4, 2, 3, 2)
    single = rs.derivatives(rs.vary(BALL, {"velocity": 2.0, "radius": 0.01}), ["velocity", "viscosity"])
    assert result.matrix[..., 2, 0] == pytest.approx(single.matrix, rel=1e-8)
    table = result.to_dataset()
    assert table.sizes == {"input": 2, "velocity": 3, "radius": 2}
    chosen = table["contact_time"].sel(input="viscosity", velocity=2.0).values[0]
    assert chosen == pytest.approx(single["contact_time", "viscosity"], rel=1e-8)


def test_branches_and_temperature() -> None:
    """The shift divides all times: dy/dT = sum dy/dtau_k dtau_k/dT with the law of Williams, Landel and Ferry."""
    series = rs.PronySeries(1e6, [4e6, 3e6], [1e-4, 2e-3])
    solid = rs.Material(series, 1e9, shift=rs.WLF(293.15, 9.0, 110.0), temperature=293.15)
    ball = rs.Impact(solid.at(300.0), rs.Parabola(0.01), mass=0.005, velocity=0.5)
    result = rs.derivatives(ball, ["relaxation_times[0]", "relaxation_times[1]"])
    by_temperature = rs.derivatives(ball, ["temperature"])
    # log10 a = -9 (T - 293.15)/(110 + T - 293.15)
    rate = -9.0 * 110.0 / (110.0 + 300.0 - 293.15) ** 2 * np.log(10.0)
    expected = rate * sum(result.matrix[:, k] * result.at[f"relaxation_times[{k}]"] for k in (0, 1))
    assert by_temperature.matrix[:, 0] == pytest.approx(expected, rel=RTOL)


def test_ends_that_differ_have_no_derivative() -> None:
    """A weight that holds the body within the steps of the velocity: e falls to 0."""
    kelvin = rs.standard_solid(1e4, 1e7, 1e3, poisson_ratio=0.45)
    ball = rs.Impact(kelvin, rs.Parabola(0.01), mass=0.005, velocity=1.0, external_force=0.05)
    low, high = 1e-4, 1.0
    for _ in range(40):
        middle = np.sqrt(low * high)
        captured = rs.solve(rs.vary(ball, {"velocity": middle})).status != rs.Status.SEPARATED
        low, high = (middle, high) if captured else (low, middle)
    # Eight per cent below, the weight holds the body; one per cent below, it does not.
    result = rs.derivatives(rs.vary(ball, {"velocity": 1.01 * high}), "velocity", FOUR, rtol=1e-9)
    near = rs.derivatives(rs.vary(ball, {"velocity": 1.05 * high}), "velocity", FOUR, steps={"velocity": 0.01 * high})
    assert np.isfinite(near.matrix).all()
    # A smaller step, which stays on one side, is found without help.
    assert np.isfinite(result.matrix).all()
    close = rs.derivatives(rs.vary(ball, {"velocity": 1.0001 * high}), "velocity", FOUR)
    assert np.isnan(close.matrix).all()
    assert np.isinf(close.errors).all()
    assert len(close.warnings) == 4


def test_full_sliding_has_its_closed_form():
    """e_t = -1 + (1 + 1/kappa)(1 + e) mu/tan(alpha) at an angle alpha, and v_x' = v_x - mu (1 + e) v0."""
    rubber = rs.standard_solid(1e6, 1e7, 1e3, poisson_ratio=0.5)
    friction, angle = 0.2, 1.2
    ball = rs.Impact(rubber, rs.Parabola(0.01), mass=0.005, velocity=1.0, friction=friction, angle=angle)
    outputs = ["restitution_coefficient", "tangential_restitution_coefficient", "rebound_tangential_velocity"]
    by = rs.derivatives(ball, ["friction", "angle", "velocity"], outputs)
    e, slope = rs.solve(ball).restitution_coefficient, 3.5 / math.tan(angle)
    e_t = outputs[1]
    assert by[e_t, "friction"] == pytest.approx(slope * (1.0 + e), rel=1e-6)
    assert by[e_t, "angle"] == pytest.approx(-3.5 * (1.0 + e) * friction / math.sin(angle) ** 2, rel=1e-6)
    assert by["restitution_coefficient", "friction"] == pytest.approx(0.0, abs=1e-12)
    # The angle stays as the velocity changes, as it is among the inputs; without it the tangential velocity stays.
    change = friction * (by["restitution_coefficient", "velocity"] + 1.0 + e)
    assert by["rebound_tangential_velocity", "velocity"] == pytest.approx(math.tan(angle) - change, rel=1e-5)
    by = rs.derivatives(ball, ["velocity"], outputs)
    assert by["rebound_tangential_velocity", "velocity"] == pytest.approx(-change, rel=1e-5)


def test_errors_of_partial_slip_are_stated():
    """Deviations of derivatives from those of a ten times smaller step stay below the errors of both."""
    rubber = rs.standard_solid(1e6, 1e7, 1e3, poisson_ratio=0.5)
    ball = rs.Impact(rubber, rs.Parabola(0.01), mass=0.005, velocity=1.0, friction=0.3, tangential_velocity=1.5)
    name, step = "tangential_restitution_coefficient", 0.004
    by = rs.derivatives(ball, "tangential_velocity", name)
    low, high = (
        rs.solve(rs.vary(ball, {"tangential_velocity": 1.5 + side * step})).tangential_restitution_coefficient
        for side in (-1.0, 1.0)
    )
    # Two errors of 1e-6 of e_t over the step, and the term of third order of the difference.
    assert by[name, "tangential_velocity"] == pytest.approx((high - low) / (2.0 * step), abs=1e-6 / step + 1e-4)
    assert by.errors[0, 0] < 1e-3


@pytest.mark.parametrize(
    ("names", "options", "where"),
    [
        (["pace"], {}, ("names",)),
        (["friction"], {}, ("names", "friction")),
        (["spin"], {}, ("spin", 0.0)),
        (["material"], {}, ("names", "material")),
        ([], {}, ("names",)),
        (["branch_moduli[3]"], {}, ("names", "branch_moduli[3]")),
        (["impedance"], {}, ("impedance", np.inf)),
        (["velocity"], {"outputs": ["energy_residual"]}, ("outputs", "energy_residual")),
        (["velocity"], {"steps": {"velocity": -1.0}}, ("steps.velocity", -1.0)),
        (["velocity"], {"steps": {"mass": 1.0}}, ("steps", "mass")),
        (["velocity"], {"rtol": 1.0}, ("rtol", 1.0)),
        (["viscosity", "relaxation_time"], {}, ("names",)),
    ],
)
def test_refused(names: list[str], options: dict[str, Any], where: tuple[Any, ...]) -> None:
    assert named(lambda: rs.derivatives(BALL, names, **options)) == where


def test_shows_itself() -> None:
    result = rs.derivatives(BALL, ["velocity", "viscosity"])
    assert "velocity" in str(result)
    assert result.to_dict()["inputs"] == ["velocity", "viscosity"]
    assert "restitution_coefficient" in repr(result) or "4 outputs" in repr(result)


def test_picture_has_a_bar_for_each_pair() -> None:
    result = rs.derivatives(BALL, ["velocity", "viscosity", "mass"])
    bars: Any = result.plot().axes[0].patches
    widths = [bar.get_width() for bar in bars]
    assert widths == pytest.approx(result.elasticities.T.ravel().tolist())
    several = rs.derivatives(rs.vary(BALL, {"velocity": [0.5, 1.0]}), "viscosity")
    assert named(several.plot)[0] == "impact"


SIGMA = {"restitution_coefficient": 0.004, "contact_time": 2e-6}


def fit_of_rebounds(rng: np.random.Generator, **options: Any) -> tuple[Any, rs.Impact, list[str]]:
    """A fit of eight rebounds with noise, its impacts, and the names of the constants of the true material."""
    constants = {"equilibrium_modulus": 1e6, "branch_modulus": 10 ** rng.uniform(6.5, 7.0), "viscosity": 2e3}
    velocity = np.sort(rng.uniform(0.05, 2.0, 8))
    true = rs.solve(rs.Impact(rs.standard_solid(**constants, poisson_ratio=0.45), rs.Parabola(0.01), 0.005, velocity))
    measured = {name: getattr(true, name) + SIGMA[name] * rng.standard_normal(8) for name in SIGMA}
    data = rs.Rebounds(velocity, **measured, radius=0.01, mass=0.005, noise=rs.Noise(**SIGMA))
    fit = rs.identify(data, rs.standard_solid, profiles=False, **options)
    return fit, rs.Impact(fit.material, rs.Parabola(0.01), 0.005, velocity), list(constants)


def test_the_covariance_of_a_fit_is_that_of_the_derivatives():
    # C = (J^T J)^-1 with J_ij = p_j (d y_i/d p_j)/sigma_i, as the coordinates of a fit are logarithms.
    fit, fitted, constants = fit_of_rebounds(np.random.default_rng(24), fixed={"poisson_ratio": 0.45})
    # With the Poisson ratio among the names, it is held where a modulus changes.
    by = rs.derivatives(fitted, ["poisson_ratio", *constants], SIGMA)
    columns = [
        np.concatenate([fit.parameters[name].value * by[output, name] / SIGMA[output] for output in SIGMA])
        for name in constants
    ]
    covariance = np.linalg.inv(np.array(columns) @ np.array(columns).T)
    # Central differences of a fit have steps of 1e-4: their error is some 1e-8.
    assert covariance == pytest.approx(fit.covariance, rel=1e-6)


def test_a_fit_has_these_derivatives() -> None:
    """J = (dp/dz) (dy/dp)/sigma with p = exp(z), or z the logit of a Poisson ratio in (-1, 1/2)."""
    fit, fitted, _ = fit_of_rebounds(RNG, prior={"poisson_ratio": rs.Normal(0.45, 0.01)})
    by = rs.derivatives(fitted, list(fit.parameters), SIGMA)
    scale = np.repeat(list(SIGMA.values()), 8)
    y = np.concatenate([by.values[output] for output in SIGMA])
    for k, (name, estimate) in enumerate(fit.parameters.items()):
        p = estimate.value
        assert p is not None
        slope = (p + 1.0) * (0.5 - p) / 1.5 if name == "poisson_ratio" else p
        column, error = (slope * part[:, k].reshape(-1) / scale for part in (by.matrix, by.errors))
        # Central differences with steps h of 1e-4 err by h^2 y'''/6, and errors of solves cancel, as both sides share them.
        allowed = error + 3.0 * 1e-4**2 * y / scale
        assert np.all(np.abs(fit.estimation.jacobian[:16, k] - column) < allowed), name
