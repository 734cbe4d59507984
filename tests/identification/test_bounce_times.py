"""Bounce times: exact predictions, recovered losses, flights in air, and instants that are refused."""

import math

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from least_squares import CASES, MASS, RADIUS, columns, covariance, fit, residuals, solid
from refusals import in_one_line, named, warns
from restitution import Cone, Noise, Parabola, Sphere, bounces, identify, reduced_modulus, solve, standard_solid
from restitution.identification.records import BounceTimes, Flight, ForceHistory
from restitution.impact.problem import STANDARD_GRAVITY, Body, Impact, drop

SD = 5e-5
# Number of touches of a ball from 0.3 m with contacts that are short against the flights.
NUMBER = {"A": 6, "B": 12, "D": 25}


def series(case, n=None, height=0.3):
    """Bounces of a steel ball of 10 mm on a material."""
    impact = drop(Body(None, RADIUS, MASS), Body(solid(case)), height)
    return bounces(impact, max_bounces=n or NUMBER[case], min_height=0.0)


def sound(time, **options):
    """Observation of data without drag, without its warning."""
    return BounceTimes(time, **{"radius": RADIUS, "mass": MASS, "drag_coefficient": 0.0} | options)


@pytest.mark.parametrize("case", ["A", "B", "D"])
def test_prediction_of_the_true_material_is_exact(case):
    result = series(case)
    data = sound(result.touch_time, noise=Noise(time=SD))
    error = data.predicted(columns(np.log(CASES[case])))[0] - data.intervals[1:]
    assert np.abs(error).max() < 0.03 * SD
    reference = sound(result.touch_time, drop_height=0.3, noise=Noise(time=SD))
    assert reference.size == data.size + 1
    error = reference.predicted(columns(np.log(CASES[case])))[0] - reference.intervals
    assert np.abs(error).max() < 0.03 * SD


@pytest.mark.parametrize(("case", "least", "most"), [("D", 0.006, 0.008), ("B", 0.08, 0.12)])
def test_ratios_of_times_are_biased_with_and_without_the_contact_time(case, least, most):
    """The last ratio of successive times between touches, and the same of these times less the contact time."""
    result = series(case)
    e, intervals = result.restitution_coefficient[1:-1], np.diff(result.touch_time)
    flights = intervals - result.contact_time[:-1]
    naive, less = (values[1:] / values[:-1] - e for values in (intervals, flights))
    assert least < naive[-1] < most
    # The body leaves from a depth, and arrives at the surface.
    assert -most < less[-1] < -0.3 * least


@pytest.mark.parametrize("case", ["A", "B"])
def test_material_is_recovered_and_its_errors_are_the_least_possible(case):
    result = series(case)
    data = sound(
        result.touch_time + 1e-5 * np.random.default_rng(5).standard_normal(result.n_bounces), noise=Noise(time=1e-5)
    )
    truth = np.log(CASES[case])
    estimated = fit(data, truth + np.array([0.3, -0.3, 0.3]))
    bound = np.sqrt(np.diag(least_covariance(result, truth, 1e-5)))
    assert np.all(np.abs(estimated.estimate - truth) < 3.0 * estimated.errors)
    assert np.all((estimated.errors > 0.8 * bound) & (estimated.errors < 1.3 * bound))


def least_covariance(result, truth, sd):
    """Bound of Cramer and Rao, by whole series of bounces from an unknown height and an unknown start of time."""
    n = result.n_bounces

    def touches(point):
        g, b, t = np.exp(point[:3])
        material = standard_solid(g, b, b * t, poisson_ratio=0.5)
        impact = drop(Body(None, RADIUS, MASS), Body(material), math.exp(point[3]))
        return bounces(impact, max_bounces=n, min_height=0.0, rtol=1e-11).touch_time

    point = np.append(truth, math.log(result.drop_height))
    steps = 1e-4 * np.eye(4)
    J = np.array([(touches(point + step) - touches(point - step)) / 2e-4 for step in steps]).T / sd
    J = np.column_stack([J, np.full(n, 1.0 / sd)])
    return np.linalg.inv(J.T @ J)[:3, :3]


def test_identify_finds_the_material_or_that_the_sound_does_not_show_it():
    random = np.random.default_rng(9)
    for case, shown in (("B", True), ("D", False)):
        result = series(case)
        time = result.touch_time + SD * random.standard_normal(result.n_bounces)
        identified = identify(sound(time, noise=Noise(time=SD)), standard_solid, fixed={"poisson_ratio": 0.5})
        modulus = identified.parameters["equilibrium_modulus"]
        assert modulus.determined == shown
        if shown:
            assert abs(modulus.value - CASES[case][0]) < 3.0 * modulus.standard_error
            low, high = identified.window
            assert low < math.pi / result.contact_time[4] < high
        else:
            assert modulus.value is None
        # The loss tangent at the time scale of the own contacts is known in both cases.
        tangent = identified.functionals["loss_tangent at pi over the contact time"]
        exact = np.sort(result.loss_tangent[1:-1])[(result.n_bounces - 2) // 2 + np.array([-1, 0, 1])]
        assert tangent.standard_error < 0.02 * tangent.value
        assert exact[0] - 3.0 * tangent.standard_error < tangent.value < exact[-1] + 3.0 * tangent.standard_error


def test_bounce_times_do_not_determine_the_modulus_of_a_material_with_small_loss():
    """Material D: the loss at the time scale of contact to a few per cent, the modulus no better than 80 %."""
    result = series("D")
    truth = np.log(CASES["D"])
    errors = np.sqrt(np.diag(covariance(sound(result.touch_time, noise=Noise(time=SD)), truth)))
    assert errors[0] > 0.8


def test_a_trial_material_that_captures_the_ball_gives_finite_residuals():
    data = sound(series("B").touch_time, noise=Noise(time=SD))
    soft = np.log(CASES["B"]) - [math.log(300.0), 0.0, 0.0]
    result = residuals(data, [soft, np.log(CASES["B"])])
    assert np.all(np.isfinite(result))
    assert np.abs(result[0]).max() > 1e3
    material = columns([soft, soft])
    reduced_modulus(material).equilibrium_modulus[0] = math.nan
    assert np.all(np.isnan(data.residuals(material, np.empty((2, 0)))[0]))


def test_residuals_are_white():
    result, rng = series("D"), np.random.default_rng(6)
    point = np.log(CASES["D"])
    rows = np.array([
        residuals(sound(result.touch_time + SD * rng.standard_normal(result.n_bounces), noise=Noise(time=SD)), point)[0]
        for _ in range(100)
    ])  # fmt: skip
    correlation = rows.T @ rows / len(rows)
    # Standard deviations of the entries are 0.14 on the diagonal and 0.1 beside it; 300 different entries.
    assert np.abs(correlation - np.eye(rows.shape[1])).max() < 0.6
    assert abs(np.mean(rows**2) - 1.0) < 4.0 * math.sqrt(2.0 / rows.size)


@pytest.mark.parametrize(("height", "mass"), [(0.3, MASS), (2.0, 2.7e-3)])
@pytest.mark.parametrize("depth", [0.0, 2e-4])
def test_flight_in_air_agrees_with_the_integrated_motion(height, mass, depth):
    g, drag = STANDARD_GRAVITY, 0.5 * 1.2 * 0.47 * math.pi * 0.02**2 / mass
    flight, up = Flight(g, drag), math.sqrt(2.0 * g * height)

    def motion(t, y):
        return [y[1], -g - drag * y[1] * abs(y[1])]

    def landing(t, y):
        return y[0] if t > 0.05 else 1.0

    landing.terminal = True
    end = solve_ivp(motion, (0.0, 10.0), [-depth, up], events=landing, rtol=1e-11, atol=1e-13, method="DOP853")
    duration, down = flight.fall(np.array(up), np.array(depth))
    assert duration == pytest.approx(end.t_events[0][0], rel=1e-9)
    assert down == pytest.approx(-end.y_events[0][0, 1], rel=1e-9)
    assert flight.launch(duration, np.array(depth)) == pytest.approx(up, rel=1e-9)
    still = Flight(g, 1e-9)
    assert still.fall(np.array(up), 0.0) == pytest.approx(Flight(g, 0.0).fall(np.array(up), 0.0), rel=1e-8)
    assert still.landing(height) == pytest.approx(up, rel=1e-8)


def bounces_in_air(case, n, drag, height=0.3):
    """Instants of touch by solves of each impact and SciPy's integration of each flight."""
    g, t, velocity = STANDARD_GRAVITY, 0.0, math.sqrt(2.0 * STANDARD_GRAVITY * height)
    instants = []
    for _ in range(n):
        instants.append(t)
        impact = Impact(solid(case), Parabola(RADIUS), MASS, velocity, external_force=MASS * g)
        result = solve(impact)
        end = solve_ivp(
            lambda t, y: [y[1], -g - drag * y[1] * abs(y[1])], (0.0, 2.0),
            [-result.residual_indentation_depth, result.rebound_velocity],
            events=[_landing], rtol=1e-10, atol=1e-12, method="DOP853", max_step=0.02,
        )  # fmt: skip
        t += result.contact_time + end.t_events[0][0]
        velocity = -end.y_events[0][0, 1]
    return np.array(instants)


def _landing(t, y):
    return y[0] if y[1] < 0.0 else -1.0


_landing.terminal, _landing.direction = True, -1.0


def test_drag_is_taken_into_account_or_warned_of():
    drag = 0.5 * 1.2 * 0.47 * math.pi * RADIUS**2 / MASS
    time = bounces_in_air("D", 15, drag)
    truth = columns(np.log(CASES["D"]))
    none = np.empty((1, 0))
    data = sound(time, air_density=1.2, drag_coefficient=0.47, noise=Noise(time=SD))
    assert np.abs(data.residuals(truth, none)).max() < 0.05
    with warns("drag"):
        still = BounceTimes(time, radius=RADIUS, mass=MASS, noise=Noise(time=SD))
    assert np.abs(still.residuals(truth, none)).max() > 2.0
    # Drag has no effect on a heavy ball in short flights.
    BounceTimes(0.2 * time, radius=RADIUS, mass=MASS, noise=Noise(time=SD))


def test_other_profiles_need_a_radius_for_the_drag():
    time = series("A").touch_time
    material = columns(np.log(CASES["A"]))
    ball, none = sound(time), np.empty((1, 0))
    parabola = sound(time, radius=None, profile=Parabola(RADIUS))
    assert np.array_equal(ball.residuals(material, none), parabola.residuals(material, none))
    sphere = sound(time, radius=None, profile=Sphere(RADIUS)).residuals(material, none)
    # Contacts are small beside the radius.
    assert sphere == pytest.approx(ball.residuals(material, none), abs=1e-3)
    assert named(lambda: sound(time, radius=None, profile=Cone(1.0), air_density=1.2)) == ("air_density", 1.2)


def test_window_and_start_come_from_the_contact_times():
    result = series("B")
    data = sound(result.touch_time, noise=Noise(time=1e-6))
    times = result.contact_time[1:-1]
    reference = data.contact_times(columns(np.log(CASES["B"])))
    assert [np.nanmin(reference), np.nanmax(reference)] == pytest.approx([times.min(), times.max()], rel=0.1)
    omega = data.effective_moduli().angular_frequency
    assert 0.5 * math.pi / times.max() < omega[0] < omega[-1] < 2.0 * math.pi / times.min()


@pytest.mark.parametrize(
    ("change", "words"),
    [
        (lambda t: {"time": t[:3]}, "at least 4"),
        (lambda t: {"time": t[::-1]}, "time[1]"),
        (lambda t: {"time": 1e3 * t}, "in s"),
        (lambda t: {"time": 1e-4 * t}, "in s"),
        (lambda t: {"time": np.delete(t, 2)}, "missing"),
        (lambda t: {"time": np.append(t, t[-1] + 0.3)}, "missing"),
        (lambda t: {"mass": 0.0}, "mass"),
        (lambda t: {"gravity": -1.0}, "gravity"),
        (lambda t: {"radius": None}, "radius"),
        (lambda t: {"noise": Noise(time="1 %")}, "noise.time"),
        (lambda t: {"noise": Noise(time=[1e-5, 1e-5])}, "noise.time"),
        (lambda t: {"noise": Noise(force=1.0)}, "noise.force"),
        (lambda t: {"noise": Noise(time=1e-5, drop_height=0.01)}, "noise.drop_height"),
        (lambda t: {"drop_height": 0.3, "noise": Noise(drop_height=0.01)}, "noise.time"),
        (lambda t: {"air_density": -1.0}, "air_density"),
    ],
)
def test_bad_instants_are_refused_in_one_line(change, words):
    time = series("D", 8).touch_time
    assert words in str(in_one_line(lambda: sound(**{"time": time} | change(time))))


def test_an_uncertain_drop_height_counts_less():
    result = series("D", 8)
    truth = np.log(CASES["D"])
    sizes = [
        np.trace(np.linalg.pinv(covariance(sound(result.touch_time, drop_height=0.3, noise=noise), truth)))
        for noise in (Noise(time=SD), Noise(time=SD, drop_height=1e-3), Noise(time=SD, drop_height=1.0))
    ]
    assert sizes[0] > sizes[1] > sizes[2]


@pytest.mark.filterwarnings("ignore:drag")
def test_an_enormous_ball_gives_no_warning_of_numpy():
    # The drag of air on it overflows.
    assert BounceTimes([0.0, 0.5, 0.9, 1.2], radius=1000000000, mass=0.03351, noise=Noise(time=5e-5)).size == 2


@pytest.mark.filterwarnings("ignore:drag")
def test_a_material_without_a_bulk_modulus_gives_no_warning_of_numpy():
    data = BounceTimes([0.0, 0.5, 0.9, 1.2, 1.4], radius=RADIUS, mass=MASS, noise=Noise(time=SD))
    assert identify(data, standard_solid, fixed={"poisson_ratio": -1.0}).chi2 >= 0.0


def test_records_say_what_they_hold():
    """The comments of a written material have it for data without a name."""
    time = np.linspace(0.0, 2e-3, 50)
    record = ForceHistory(time, 59.0 * np.sin(np.pi * time / 2e-3), radius=0.01, mass=0.033, velocity=1.0)
    assert [repr(data) for data in (sound([0.0, 0.4, 0.7, 0.95]), record)] == [
        "BounceTimes(4 touches)",
        "ForceHistory(50 samples)",
    ]
