"""Laws of codes with cohesion: their motion, the numbers that are typed, and the nearest one to adhesive impacts."""

import json
import math
import pickle
from dataclasses import replace

import numpy as np
import pytest
from scipy.integrate import quad, solve_ivp
from scipy.optimize import brentq

import restitution as rs
from refusals import in_one_line, named
from restitution.calibration import adhesive
from restitution.calibration.adhesive_laws import ADHESIVE_LAWS, Contact, TypedAdhesive, mfix_strength
from restitution.calibration.collisions import bodies_of
from restitution.calibration.laws import coefficient_strength
from restitution.errors import InputError, InputTypeError

RNG = np.random.default_rng(17)
POLYMER = rs.standard_solid(1e9, 1e9, 20.0, poisson_ratio=0.35, density=1200.0)
GRAIN = rs.Body(POLYMER, radius=10e-6)
STICKY = rs.Adhesion(0.05, stress=1e7)


def random_contact():
    """A contact whose attraction and loss both matter, in SI, and the law numbers of a target for it."""
    radius, modulus, velocity = np.exp(RNG.uniform(np.log([1e-6, 1e8, 0.1]), np.log([1e-3, 1e10, 10.0])))
    mass = float(2000.0 * 4.0 / 3.0 * math.pi * radius**3)
    k = 4.0 / 3.0 * modulus * math.sqrt(radius)
    length = (mass * velocity**2 / k) ** 0.4
    reach = float(0.05 * length)
    return Contact(float(velocity), mass, float(radius), 0.3, 0.05, reach, float(modulus), 0.0, 0.7, 1e-6), length


def random_law(name):
    """A law of a target with random numbers."""
    law, (contact, length) = ADHESIVE_LAWS[name], random_contact()
    force = contact.mass * contact.velocity**2 / length
    width = math.sqrt(contact.radius * length) ** (0.5 * law.form.power)
    damping = RNG.uniform(0.05, 0.4) * force / contact.velocity / width
    return TypedAdhesive(law, contact.modulus, float(RNG.uniform(0.01, 0.1) * force), float(damping), contact)


class Code:
    """Force over overlap and velocity as a code computes it from what is typed, written from its documentation."""

    def __init__(self, law):
        self.name, self.R, self.m, self.reach = law.law.name, law.contact.radius, law.contact.mass, law.contact.reach
        self.typed = {name: number.value for name, number in law.law.typed(law).items()}
        self.E = self.typed.get("E_eff") or self.typed["E"] / (2.0 * (1.0 - self.typed["nu"] ** 2))
        self.k = 4.0 / 3.0 * self.E * math.sqrt(self.R)
        self.last = -self.pull_off_distance() if "jkr" in self.name and "liggghts" not in self.name else 0.0

    def pull_off_distance(self):
        """GranSubModNormalJKR::pulloff_distance of LAMMPS."""
        return (3.0 * math.pi**2 / 16.0 * self.R * self.typed["gamma"] ** 2 / self.E**2) ** (1.0 / 3.0)

    def jkr_radius(self, overlap):
        """Larger root a of the overlap a^2/R - 2 sqrt(pi gamma a/E)."""
        scale = (math.pi * self.typed["gamma"] * self.R**2 / self.E) ** (1.0 / 3.0)
        fold = scale * 0.25 ** (1.0 / 3.0)
        high = math.sqrt(self.R * abs(overlap)) + 3.0 * scale

        def excess(a):
            return a * a / self.R - 2.0 * math.sqrt(math.pi * self.typed["gamma"] * a / self.E) - overlap

        return brentq(excess, fold, high, xtol=1e-15 * high)

    def jkr(self, overlap):
        a = self.jkr_radius(overlap)
        pull = 2.0 * math.pi * a * a * math.sqrt(4.0 * self.typed["gamma"] * self.E / (math.pi * a))
        return 4.0 * self.E * a**3 / (3.0 * self.R) - pull

    def force(self, overlap, velocity):
        depth, typed = max(overlap, 0.0), self.typed
        hertz = self.k * depth**1.5
        if self.name.startswith("lammps"):
            jkr = "jkr" in self.name
            a = self.jkr_radius(overlap) if jkr else math.sqrt(self.R * depth)
            eta = typed["eta_n0"] * self.m * (a if "viscoelastic" in self.name else 1.0)
            elastic = self.jkr(overlap) if jkr else hertz - 4.0 * math.pi * typed["gamma"] * self.R
            return elastic + eta * velocity
        if self.name == "liggghts-sjkr":
            beta = math.log(typed["e"]) / math.hypot(math.log(typed["e"]), math.pi)
            normal = 2.0 * self.E * math.sqrt(self.R * depth)
            dashed = -2.0 * math.sqrt(5.0 / 6.0) * beta * math.sqrt(normal * self.m) * velocity
            return max(hertz + dashed, 0.0) - typed["cohesion"] * 2.0 * math.pi * self.R * depth
        if self.name == "mercury-adhesive":
            return max(hertz + 1.5 * self.k * typed["A"] * math.sqrt(depth) * velocity, 0.0) - typed["f_max"]
        if self.name == "yade-dmt":
            adhesion = 4.0 * math.pi * self.R * typed["gamma"]
            star = brentq(lambda x: rs.closed_forms.mueller_poeschel_restitution(x) - typed["en"], 0.0, 5.0)
            A = 2.0 * star**2 * typed["vn"] ** -0.2 * (self.k / self.m) ** -0.4 / 3.0
            dashed = A * 1.5 * self.k * math.sqrt(depth) * velocity
            if hertz - adhesion + dashed < 0.0 and abs(dashed) > adhesion:
                dashed = math.copysign(adhesion, dashed)
            return hertz - adhesion + dashed
        eta = 2.0 * math.sqrt(self.k * self.m) * abs(math.log(typed["e"])) / math.hypot(math.log(typed["e"]), math.pi)
        # The force at the inner cutoff, which holds up to touch and within it.
        attraction = typed["hamaker"] * 2.0 * self.R / (12.0 * typed["inner"] ** 2)
        return hertz + eta * depth**0.25 * velocity - attraction

    def outside(self):
        """Work of the attraction beyond touch, by quadrature over the gap."""
        typed = self.typed
        if self.name == "mercury-adhesive":
            reach = typed["f_max"] / typed["k_a"]
            return quad(lambda gap: typed["f_max"] - typed["k_a"] * gap, 0.0, reach)[0]
        if self.name == "mfix":
            inner, outer = typed["inner"], typed["outer"]
            within = typed["hamaker"] * 2.0 * self.R / (12.0 * inner**2) * inner
            return within + quad(lambda gap: typed["hamaker"] * 2.0 * self.R / (12.0 * gap**2), inner, outer)[0]
        return 0.0

    def rebound(self, velocity):
        """Coefficient of restitution and time in touch by SciPy, the time NaN of a body that is held."""
        length = (self.m * velocity**2 / self.k) ** 0.4
        unit, gained = length / velocity, 2.0 * self.outside() / self.m / velocity**2

        def motion(_, y):
            force = self.force(max(y[0] * length, self.last), y[1] * velocity)
            return [y[1], -force * unit / (self.m * velocity)]

        def apart(t, y):
            return y[0] - self.last / length if t > 0.0 else 1.0

        def turns(t, y):
            return y[1]

        apart.terminal, apart.direction = True, -1.0
        turns.terminal, turns.direction = True, 1.0
        start, settings = [0.0, math.sqrt(1.0 + gained)], {"rtol": 1e-9, "atol": 1e-11, "max_step": 0.02}
        path = solve_ivp(motion, (0.0, 200.0), start, events=(apart, turns), **settings)
        left = path.y[1, -1] ** 2 - gained
        if path.t_events[1].size or left <= 0.0:
            return 0.0, math.nan
        return math.sqrt(left), path.t[-1] * unit


@pytest.mark.parametrize("name", ADHESIVE_LAWS)
def test_motion_is_that_of_the_documented_force(name):
    """e and the time in touch from the typed numbers, with the force of the code's pages, by SciPy."""
    law = random_law(name)
    speeds = law.contact.velocity * np.array([0.4, 1.0, 3.0])
    e, time = law.rebound(speeds)
    code = Code(law)
    expected = np.array([code.rebound(speed) for speed in speeds])
    np.testing.assert_allclose(e, expected[:, 0], atol=1e-4)
    np.testing.assert_allclose(time, expected[:, 1], rtol=1e-3)


def test_an_elastic_pair_of_lammps_loses_the_area_of_its_force():
    """JKR over the overlap from touch to LAMMPS's distance of pull-off: sticking velocity, and e above it."""
    law = replace(random_law("lammps-jkr-viscoelastic"), damping=0.0)
    code = Code(law)
    lost = -quad(code.jkr, code.last, 0.0)[0]
    sticks = math.sqrt(2.0 * lost / law.contact.mass)
    factors = np.array([0.9999, 1.0001, 1.5, 4.0])
    e, time = law.rebound(factors * sticks)
    assert e[0] == 0.0
    assert math.isnan(time[0])
    np.testing.assert_allclose(e[2:], np.sqrt(1.0 - factors[2:] ** -2.0), atol=5e-5)
    assert 0.0 < e[1] < 0.05
    # In the units of JKR: 7.09 up to the fold, half of it up to the largest pull, where LAMMPS ends the contact.
    work = 2.0 * law.law.typed(law)["gamma"].value
    unit = (work**5 * law.contact.radius**4 / law.modulus**2) ** (1.0 / 3.0)
    assert lost / unit == pytest.approx(3.50, abs=0.01)


def test_no_law_gains_energy():
    for name in ADHESIVE_LAWS:
        law = random_law(name)
        e, _ = law.rebound(law.contact.velocity * np.geomspace(0.01, 100.0, 50))
        assert np.all((e >= 0.0) & (e < 1.0))
        # A body that is held at a velocity is held at every lower one.
        assert np.all(np.diff((e > 0.0).astype(int)) >= 0)


@pytest.fixture(scope="module")
def cases():
    """Impacts of two polymer grains from below to far above their sticking velocity."""
    return adhesive.collisions(bodies_of((GRAIN, GRAIN), None), STICKY, (0.09, 8.0), 9, 1e-3, 1)


def test_collisions_stick_below_the_velocity_of_the_solver(cases):
    impact = replace(rs.collision(GRAIN, GRAIN, 1.0), adhesion=STICKY)
    assert cases.sticking_velocity == pytest.approx(rs.sticking_velocity(impact, rtol=1e-3), rel=3e-3)
    held = cases.velocity < cases.sticking_velocity
    assert np.array_equal(cases.restitution_coefficient[:, 0] == 0.0, held)
    alone = rs.solve(replace(impact, velocity=float(cases.velocity[-1])), rtol=1e-4)
    assert cases.restitution_coefficient[-1, 0] == pytest.approx(alone.restitution_coefficient, abs=3e-4)
    assert cases.contact_time[-1, 0] == pytest.approx(alone.touching_time, rel=1e-3)


@pytest.mark.parametrize(
    "name",
    [
        "lammps-jkr-viscoelastic",
        pytest.param("liggghts-sjkr", marks=pytest.mark.slow),
        pytest.param("mercury-adhesive", marks=pytest.mark.slow),
    ],
)
def test_nearest_law_sticks_below_the_same_velocity_and_no_other_loss_is_nearer(name, cases):
    law = adhesive.nearest(ADHESIVE_LAWS[name], cases)
    e, _ = law.rebound(cases.sticking_velocity * np.array([0.999, 1.001]))
    assert e[0] == 0.0
    assert e[1] > 0.0

    def error(law):
        return float(np.abs(law.rebound(cases.velocity)[0] - cases.restitution_coefficient[:, 0]).max())

    def sticking(pull, other):
        """Whether a law with a pull holds the bodies at their sticking velocity."""
        return replace(other, pull_off_force=pull).rebound(cases.sticking_velocity)[0] == 0.0

    best = error(law)
    assert best < 0.1
    for factor in (0.9, 1.1):
        other = replace(law, damping=factor * law.damping)
        low, high = 0.2 * law.pull_off_force, 5.0 * law.pull_off_force
        assert not sticking(low, other)
        assert sticking(high, other)
        for _ in range(25):
            middle = math.sqrt(low * high)
            low, high = (low, middle) if sticking(middle, other) else (middle, high)
        assert error(replace(other, pull_off_force=low)) > best
    # The stiffness: the longest and the shortest ratio of the contact times are as far from 1.
    _, time = law.rebound(cases.velocity)
    ratio = (time / cases.contact_time[:, 0])[np.isfinite(time)]
    assert ratio.max() * ratio.min() == pytest.approx(1.0, abs=1e-3)


def test_usual_numbers_are_half_the_work_and_the_frequency_of_the_contact(cases):
    law = ADHESIVE_LAWS["lammps-dmt-viscoelastic"]
    typed = {name: number.value for name, number in law.typed(law.naive(cases.contact)).items()}
    assert typed["gamma"] == pytest.approx(0.025)
    omega, series = math.pi / cases.contact.contact_time, rs.reduced_modulus(POLYMER, POLYMER)
    modulus = typed["E"] / (2.0 * (1.0 - 0.35**2))
    assert modulus == pytest.approx(series.storage_modulus(omega))
    retardation = series.loss_modulus(omega) / series.storage_modulus(omega) / omega
    assert typed["eta_n0"] == pytest.approx(2.0 * modulus * retardation / cases.contact.mass)
    middle = adhesive.ADHESIVE_LAWS["liggghts-sjkr"].naive(cases.contact)
    e = middle.law.typed(middle)["e"].value
    assert e == pytest.approx(cases.contact.restitution_coefficient)
    assert coefficient_strength(e) < mfix_strength(e) * 1.2


def test_result_and_texts(cases):
    result = adhesive.calibrated("lammps-jkr-viscoelastic", cases, "cgs")
    numbers = result.law.law.typed(result.law)
    assert result.parameters["gamma"].value == pytest.approx(1e3 * numbers["gamma"].value)
    assert result.parameters["eta_n0"].value == pytest.approx(1e-2 * numbers["eta_n0"].value)
    table = result.table
    held = table["restitution_coefficient"].to_numpy() == 0.0
    assert held.any()
    assert np.all(table["calibrated_restitution_coefficient"].to_numpy()[held] == 0.0)
    difference = table["calibrated_restitution_coefficient"] - table["restitution_coefficient"]
    np.testing.assert_array_equal(table["error"], difference)
    assert result.largest_error == float(np.abs(difference).max())
    texts = " ".join(f"{result.parameters[name].value:.8g}" for name in ("E", "eta_n0", "nu", "gamma"))
    assert f"pair_coeff * * jkr {texts} tangential linear_nohistory 0 0 damping viscoelastic" in result.snippet
    assert "sticks below" in str(result)
    content = json.loads(result.to_json())
    assert content["sticking_velocity"] == cases.sticking_velocity
    assert content["pull_off_force"] == pytest.approx(3.0 * math.pi * numbers["gamma"].value * 5e-6)
    again = pickle.loads(pickle.dumps(result))
    assert again.restitution_coefficient(1.0) == result.restitution_coefficient(1.0)
    assert in_one_line(lambda: result.restitution_coefficient(1.0, radius=1e-5)).field == "radius"


@pytest.mark.slow
def test_door():
    """`calibrate` takes the adhesion of an impact, or one beside two bodies; a wall has its text."""
    impact = replace(rs.collision(GRAIN, GRAIN, 1.0), adhesion=STICKY)
    of_impact = rs.calibrate(impact, "yade-dmt", (0.2, 2.0), points=3)
    of_bodies = rs.calibrate((GRAIN, GRAIN), "yade-dmt", (0.2, 2.0), points=3, adhesion=STICKY)
    assert of_impact.parameters == of_bodies.parameters
    wall = rs.calibrate((GRAIN, rs.Body(None)), "lammps-dmt-mass-velocity", (0.2, 2.0), points=3, adhesion=STICKY)
    assert "fix wall all wall/gran granular dmt" in wall.snippet


@pytest.mark.parametrize(
    ("options", "field"),
    [
        ({"target": "lammps-tsuji", "adhesion": STICKY}, "target"),
        ({"target": "mfix"}, "adhesion"),
        ({"target": "mfix", "adhesion": 0.05}, "adhesion"),
        ({"target": "mfix", "adhesion": rs.Adhesion([0.05, 0.1])}, "adhesion"),
        ({"target": "mfix", "adhesion": STICKY, "radius": (1e-6, 1e-5)}, "radius"),
        ({"target": "mfix", "adhesion": STICKY, "restitution": 0.5}, "restitution"),
        ({"target": "mfix", "adhesion": STICKY, "friction": 0.5}, "friction"),
        ({"target": "yade-dmt", "adhesion": STICKY, "units": "cgs"}, "units"),
        ({"target": "yade-dmt", "adhesion": STICKY, "velocity": 0.01}, "velocity"),
    ],
)
def test_refusals(options, field):
    call = {"velocity": (0.1, 1.0)} | options
    kind = InputTypeError if options.get("adhesion") == 0.05 else InputError
    assert named(lambda: rs.calibrate((GRAIN, GRAIN), **call), kind)[0] == field


def test_a_wall_of_mfix_is_refused():
    bodies = GRAIN, rs.Body(POLYMER)
    assert named(lambda: rs.calibrate(bodies, "mfix", (0.2, 2.0), adhesion=STICKY, points=3))[0] == "contact"
