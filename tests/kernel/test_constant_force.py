"""Flat punch under a constant force: its linear equations of motion have an independent solution."""

import math

import numpy as np
import pytest
from scipy.optimize import brentq

import restitution as rs
from restitution.impact.status import Status

RTOL = 1e-9


def _restitution(stiffness: float, branch: float, time: float, mass: float, velocity: float, force: float) -> float:
    """Restitution coefficient from the eigenvalues of the motion; 0 if the contact force never returns to zero.

    m v' = w - k d - k1 q, d' = v, q' = v - q/tau.
    """
    matrix = np.array([[0.0, 1.0, 0.0], [-stiffness / mass, 0.0, -branch / mass], [0.0, 1.0, -1.0 / time]])
    rest = np.array([force / stiffness, 0.0, 0.0])
    rates, vectors = np.linalg.eig(matrix.astype(complex))
    weights = np.linalg.solve(vectors, np.array([0.0, velocity, 0.0]) - rest)

    def state(t: float) -> np.ndarray:
        return (vectors @ (weights * np.exp(rates * t))).real + rest

    def load(t: float) -> float:
        d, _, q = state(t)
        return stiffness * d + branch * q

    period = 2.0 * math.pi * math.sqrt(mass / stiffness)
    moments = np.r_[0.0, np.geomspace(1e-3 * time, period, 20_000)]
    values = np.array([load(t) for t in moments])
    crossings = np.flatnonzero((values[1:-1] > 0.0) & (values[2:] <= 0.0)) + 1
    if not crossings.size:
        return 0.0
    end = brentq(load, moments[crossings[0]], moments[crossings[0] + 1], xtol=1e-300, rtol=1e-15)
    return -float(state(end)[1]) / velocity


def _impact(modulus, branch, time, radius, mass, velocity, force):
    material = rs.Material(rs.PronySeries(modulus, [branch], [time]), math.inf)
    return rs.Impact(material, rs.FlatPunch(radius), mass, velocity, external_force=force)


@pytest.mark.parametrize("seed", range(12))
def test_fast_branch_under_a_flat_face(seed):
    # An incompressible half-space carries F = 8 a G d. The branch is 10 to 10^6 times as fast as the impact.
    random = np.random.default_rng(seed)
    modulus, radius, mass, velocity = 10.0 ** random.uniform(-2.0, 2.0, 4)
    stiffness = 8.0 * radius * modulus
    period = math.sqrt(mass / stiffness)
    time = period * 10.0 ** random.uniform(-6.0, -1.0)
    branch = modulus * random.uniform(0.0, 0.4) * period / time
    force = 10.0 ** random.uniform(-2.0, -0.5) * velocity * math.sqrt(mass * stiffness)
    reference = _restitution(stiffness, 8.0 * radius * branch, time, mass, velocity, force)
    result = rs.solve(_impact(modulus, branch, time, radius, mass, velocity, force), rtol=RTOL)
    assert result.restitution_coefficient == pytest.approx(reference, rel=RTOL)


def test_fast_branch_after_the_second_solve():
    # The worst of 12 000 random punches under a constant force: an earlier kernel had 2.2 times the tolerance here.
    numbers = (
        0.001556852752311833, 0.8212005023270991, 0.019697193551225286, 0.5412430576613148, 14.199474074749526,
        21.178982741276485, 1.571980663793192,
    )  # fmt: skip
    modulus, branch, time, radius, mass, velocity, force = numbers
    reference = _restitution(8.0 * radius * modulus, 8.0 * radius * branch, time, mass, velocity, force)
    result = rs.solve(_impact(*numbers), rtol=RTOL)
    assert result.restitution_coefficient == pytest.approx(reference, rel=RTOL)


@pytest.mark.plain
@pytest.mark.parametrize("ratio", [1e-12, 1e-9])
def test_a_branch_as_short_as_a_dashpot_is_no_capture(ratio):
    """The first elements of the rebound are as short as those that end at an instant when the contact grows again.

    The branch acts as its dashpot but for this ratio of times: k d + c v = m g ends at a zero of a damped oscillation.
    """
    k, c, force = 8.0, 1.6, 0.4
    result = rs.solve(_impact(1.0, 0.2 / ratio, ratio, 1.0, 1.0, 1.0, force), rtol=RTOL)
    damping, rest = 0.5 * c, force / k
    frequency = math.sqrt(k - damping**2)

    def motion(t):
        # d'' + c d' + k d = w from d = 0 and d' = 1.
        sine = (1.0 - damping * rest) / frequency
        wave = complex(-rest, -sine) * np.exp(complex(-damping, frequency) * t)
        return rest + wave.real, (complex(-damping, frequency) * wave).real

    end = brentq(lambda t: k * motion(t)[0] + c * motion(t)[1], 0.4 * math.pi / frequency, 1.2 * math.pi / frequency)
    assert result.restitution_coefficient == pytest.approx(-motion(end)[1], rel=RTOL + 10.0 * ratio)
    assert result.contact_time == pytest.approx(end, rel=RTOL + 10.0 * ratio)


@pytest.mark.parametrize("rtol", [1e-4, 1e-9, 1e-11])
def test_a_contact_that_grows_again_is_captured(rtol):
    # dt/dlambda diverges at the instant when the contact grows again. Newton's method must not fail before it.
    numbers = (
        0.013078634178708498, 242.91915135390502, 1.0259556653932853e-05, 46.53409623260881, 0.5369286060106576,
        68.12244438327023, 54.712738655064896,
    )  # fmt: skip
    modulus, branch, time, radius, mass, velocity, force = numbers
    assert _restitution(8.0 * radius * modulus, 8.0 * radius * branch, time, mass, velocity, force) == 0.0
    result = rs.solve(_impact(*numbers), rtol=rtol)
    assert result.status is Status.CAPTURED
    assert result.restitution_coefficient == 0.0


@pytest.mark.parametrize("rtol", [1e-4, 1e-9, 1e-11])
def test_a_body_that_creeps_to_rest_is_captured(rtol):
    # A Maxwell element in parallel with a spring of a millionth of its stiffness. The body creeps after a few relaxation
    # times, and rounding of the force would stop the elements long before it rests at the static depth w/k.
    result = rs.solve(_impact(1e-6, 1.0, 0.05, 1.0, 1.0, 1.0, 1.0), rtol=rtol)
    assert result.status is Status.CAPTURED
    assert result.max_indentation_depth == pytest.approx(1.0 / 8e-6, rel=1e-9)


@pytest.mark.plain
@pytest.mark.parametrize(
    ("exponent", "series", "poisson_ratio", "length", "mass", "velocity"),
    [
        # Shares of the relaxation that leave the range of a double in an iteration of Newton's method.
        (
            4.361883662192044,
            (38951.67480376345, [30987.45060261, 6675.64553519, 122839.295881],
             [3.64909638e-05, 3.85512421e-05, 5.36992144e-05]),
            0.048857828792195024, 0.005066665884615501, 0.00028745695165017143, 0.004220720557227245,
        ),
        # A matrix of such an iteration that is singular.
        (
            13.86676378703381,
            (93016.77090852945, [258648.21710544225, 398545.0037858031, 98942.40151614256],
             [0.029251933380710065, 0.0015738348374162458, 0.7055809343743669]),
            0.42674803152469365, 5.629667126829458e-06, 8.468163267815366e-09, 0.26972592418415264,
        ),
    ],
)  # fmt: skip
@pytest.mark.filterwarnings("ignore::restitution.errors.RestitutionWarning")
def test_iterations_that_diverge_are_given_up(exponent, series, poisson_ratio, length, mass, velocity):
    """The shorter elements that follow agree with those of a tolerance at which nothing diverges."""
    material = rs.generalised_maxwell(*series, poisson_ratio=poisson_ratio)
    tip = rs.PowerLaw(exponent, length ** (1.0 - exponent))
    impact = rs.Impact(material, tip, mass=mass, velocity=velocity, external_force=1e-3)
    loose, strict = (rs.solve(impact, rtol=rtol) for rtol in (1e-6, 1e-9))
    assert loose.restitution_coefficient == pytest.approx(strict.restitution_coefficient, abs=1e-6)
    assert loose.status == rs.Status.CAPTURED
