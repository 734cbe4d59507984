"""Oscillating indentation: table and row O1 of the design page on cycles, closed forms, and cycles by panels."""

import json
import math

import numpy as np
import pytest
import xarray as xr
from scipy.integrate import quad

import restitution as rs
from element_follower import pressed_elements
from refusals import named
from restitution.indentation.oscillation import OscillationStatus

# E* = 1 + 4 exp(-t): the reduced modulus of an incompressible material is four times that in shear.
SOLID = rs.Material(rs.PronySeries(0.25, [1.0], [1.0]), bulk=math.inf)
UNIT = 0.5 / math.pi  # frequency of w = 1
# Amplitude over depth, errors of E' and E'' in per cent, and smallest radius over that at the mean depth.
TABLE = [
    (0.003, -0.11, -0.21, 0.995), (0.01, -0.35, -0.69, 0.982), (0.03, -1.1, -2.1, 0.944), (0.1, -3.8, -7.3, 0.800),
    (0.3, -14.0, -27.0, 0.0),
]  # fmt: skip


@pytest.mark.parametrize(("share", "storage", "loss", "radius"), TABLE)
def test_the_reading_of_the_textbook_neglects_the_rim(share, storage, loss, radius):
    wave = rs.oscillate(SOLID, rs.Parabola(1.0), depth=1.0, amplitude=share, frequency=UNIT)
    assert 100.0 * wave.storage_error == pytest.approx(
        storage, abs=0.005 if share < 0.02 else 0.5 if share > 0.2 else 0.05
    )
    assert 100.0 * wave.loss_error == pytest.approx(loss, abs=0.005 if share < 0.02 else 0.5 if share > 0.2 else 0.05)
    assert wave.min_contact_radius == pytest.approx(radius, abs=6e-4)
    assert wave.complex_modulus == pytest.approx(3.0 + 2.0j, rel=1e-12)
    assert wave.status is OscillationStatus.STEADY


def test_the_sixth_of_six_cycles():
    """Row O1: ramp to 1 within 1, hold to 41, then d = 1 + 0.1 sin(t - 41)."""
    wave = rs.oscillate(
        SOLID, rs.Parabola(1.0), depth=1.0, amplitude=0.1, frequency=UNIT, cycles=6, rise_time=1.0, hold_time=40.0
    )
    assert wave.force_harmonics[0].real == pytest.approx(1.34301000185, abs=1e-9)
    assert wave.force_harmonics[1].real == pytest.approx(0.57746212548, abs=1e-9)
    assert wave.force_harmonics[1].imag == pytest.approx(0.37074589525, abs=1e-9)
    assert wave.min_contact_radius == pytest.approx(0.799652970, abs=1e-8)
    assert wave.status is OscillationStatus.LAST_CYCLE


@pytest.mark.parametrize(
    "profile",
    [rs.Parabola(2.0), rs.Cone(1.2), rs.Sphere(3.0), rs.TruncatedCone(0.5, 0.2), rs.Ellipsoid(1.0, 2.0)],
    ids=["parabola", "cone", "sphere", "truncated cone", "ellipsoid"],
)
def test_the_steady_state_of_elements_is_that_of_many_cycles(profile):
    """The rim by periodic elements and twenty cycles by panels share nothing but the changes of state."""
    series = rs.PronySeries(0.3, [1.0, 0.4], [1.0, 0.2])
    material = rs.Material(series, bulk=math.inf)
    options = {"depth": 0.3, "amplitude": 0.05, "frequency": 0.4}
    steady = rs.oscillate(material, profile, **options)
    many = rs.oscillate(material, profile, **options, cycles=20, hold_time=60.0, rtol=1e-9)
    scale = abs(many.force_harmonics[0])
    assert steady.force_harmonics == pytest.approx(many.force_harmonics, abs=1e-8 * scale)
    assert steady.dissipated == pytest.approx(many.dissipated, rel=1e-6)
    assert steady.min_contact_radius == pytest.approx(many.min_contact_radius, rel=1e-6)


def test_late_cycles_are_those_of_the_steady_state():
    """At any frequency and phase; times of late cycles have fewer digits, which once ended the first of these.

    The rim forgets its start within at most thirteen periods.
    """
    rng = np.random.default_rng(4)
    cases = [(30.368208334268015, 0.0867, 0.28626, 3.88742, 0.88221, 2.345)]
    cases += [
        (10.0 ** rng.uniform(-4.0, 3.0), 10.0 ** rng.uniform(-2.0, -0.5), *rng.uniform([0.1, 0.2, 0.05], [1.0, 4.0, 0.9]),
         rng.uniform(0.0, 5.0)) for _ in range(2)
    ]  # fmt: skip
    for rate, time, equilibrium, branch, amplitude, hold in cases:
        solid = rs.Material(rs.PronySeries(equilibrium, [branch], [time / rate]), math.inf)
        options = {"depth": 1.0, "amplitude": amplitude, "frequency": rate}
        steady = rs.oscillate(solid, rs.Parabola(1.0), **options)
        late = rs.oscillate(solid, rs.Parabola(1.0), **options, cycles=300, hold_time=hold)
        scale = abs(steady.force_harmonics[0])
        assert late.force_harmonics == pytest.approx(steady.force_harmonics, abs=3e-8 * scale), (solid, options)


@pytest.mark.parametrize("viscosity", [0.0, 0.3])
@pytest.mark.parametrize("power", [7.0, 9.0, 12.0, 15.0])
def test_a_part_that_relaxes_in_a_million_periods_and_more(viscosity, power):
    """Numbers are a series in the period over the slow time: its limit from times of 160 and 320 periods.

    The next term is some thousandth of the second one, which changes these numbers by 1e-4.
    """

    def numbers(time):
        series = rs.PronySeries(0.1, [1.0, 0.5], [1.0, time], parallel_viscosity=viscosity)
        wave = rs.oscillate(
            rs.Material(series, bulk=math.inf), rs.Parabola(1.0), depth=1.0, amplitude=0.3, frequency=UNIT
        )
        return np.append(wave.force_harmonics[:3], wave.dissipated)

    first, second = numbers(1e3), numbers(2e3)
    time = 10.0 ** (power + np.random.default_rng().uniform(-0.5, 0.5))
    assert np.abs(first - second).max() > 5e-5
    assert np.all(np.abs(numbers(time) - (2.0 * second - first)) < 3e-7)


def test_the_steady_state_of_a_dashpot_is_that_of_many_cycles():
    series = rs.PronySeries(0.3, [1.0, 0.4], [1.0, 0.2], parallel_viscosity=0.2)
    options = {"depth": 0.3, "amplitude": 0.05, "frequency": 0.4}
    material = rs.Material(series, bulk=math.inf)
    steady = rs.oscillate(material, rs.Parabola(2.0), **options)
    many = rs.oscillate(material, rs.Parabola(2.0), **options, cycles=20, rise_time=1.0, hold_time=60.0, rtol=1e-5)
    assert steady.force_harmonics == pytest.approx(many.force_harmonics, abs=1e-8 * abs(many.force_harmonics[0]))


def test_a_flat_punch_is_read_exactly():
    """Its radius is constant: F_1 = 2 a E*(i w) d_1."""
    wave = rs.oscillate(SOLID, rs.FlatPunch(0.3), depth=1.0, amplitude=0.1, frequency=UNIT)
    assert wave.apparent_modulus == pytest.approx(3.0 + 2.0j, rel=1e-10)


@pytest.mark.parametrize("seed", range(8))
def test_a_cone_follows_the_law_of_first_order(seed):
    """The rim's share is linear in the amplitude for a cone until contact is lost (a' = const), at any modulus."""
    rng = np.random.default_rng(seed)
    count = int(rng.integers(1, 4))
    series = rs.PronySeries(1.0, rng.uniform(0.1, 1.0, count), 10.0 ** rng.uniform(-1.0, 1.0, count))
    material, angle = rs.Material(series, bulk=math.inf), float(rng.uniform(0.3, 1.3))
    shares = np.array([0.002, 0.02, 0.04])
    waves = [rs.oscillate(material, rs.Cone(angle), depth=0.5, amplitude=0.5 * x, frequency=0.3) for x in shares]
    errors = np.array([[wave.storage_error, wave.loss_error] for wave in waves])
    assert np.all(errors < 0.0)
    assert errors[1:] / shares[1:, None] == pytest.approx(np.tile(errors[0] / shares[0], (2, 1)), rel=1e-8)


@pytest.mark.parametrize("seed", range(4))
def test_a_dashpot_against_elements_in_small_steps(seed):
    """Kelvin-Voigt, q = E u + eta u': 400 equal elements, 2000 steps a period of second order, twelve periods."""
    rng = np.random.default_rng(seed)
    modulus, viscosity, share = 4.0, float(rng.uniform(0.3, 4.0)), float(rng.uniform(0.05, 0.3))
    radii = math.sqrt(1.0 + share) * (np.arange(400) + 0.5) / 400
    steps, surface, first = 2000, np.zeros(400), 0j
    decay = math.exp(-modulus / viscosity / steps)
    for k in range(12 * steps):
        body = 1.0 + share * math.sin(2.0 * math.pi * (k + 1) / steps) - radii**2
        after = np.maximum(body, surface * decay)
        load = 0.5 * modulus * (after + surface) + viscosity * steps * (after - surface)
        load[body < surface * decay] = 0.0
        surface = after
        if k >= 11 * steps:
            first += load.sum() * np.exp(-2j * math.pi * (k + 0.5) / steps) / steps
    expected = 2.0 * first * math.sqrt(1.0 + share) / 400 * 2j
    material = rs.Material(rs.PronySeries(1.0, [], [], parallel_viscosity=0.25 * viscosity), bulk=math.inf)
    wave = rs.oscillate(material, rs.Parabola(1.0), depth=1.0, amplitude=share, frequency=1.0)
    assert wave.force_harmonics[1] == pytest.approx(expected, rel=2e-5)


def test_an_elastic_body_dissipates_nothing():
    wave = rs.oscillate(
        rs.elastic(youngs_modulus=1.0, poisson_ratio=0.5), rs.Parabola(1.0), depth=1.0, amplitude=0.4, frequency=1.0
    )
    assert abs(wave.dissipated) < 1e-12
    # F = 4/3 E* sqrt(R) d^(3/2) at once.
    expected = 4.0 / 3.0 * (1.0 / 0.75) * wave.indentation_depth**1.5
    assert wave.force == pytest.approx(expected, rel=1e-4)


def test_an_oscillating_force_is_that_of_the_depth_that_it_makes():
    wave = rs.oscillate(SOLID, rs.Parabola(1.0), force=1.3, amplitude=0.3, frequency=UNIT)
    assert wave.status is OscillationStatus.STEADY
    assert wave.force_harmonics[0] == pytest.approx(1.3, rel=1e-9)
    assert wave.force_harmonics[1] == pytest.approx(0.3, rel=1e-9)
    # Below the amplitude at which the depth is a sine, both readings agree.
    small = rs.oscillate(SOLID, rs.Parabola(1.0), force=1.3, amplitude=0.005, frequency=UNIT)
    depth = small.depth_harmonics
    again = rs.oscillate(SOLID, rs.Parabola(1.0), depth=depth[0].real, amplitude=abs(depth[1]), frequency=UNIT)
    assert small.storage_error == pytest.approx(again.storage_error, abs=2e-5)


@pytest.mark.parametrize(
    ("options", "field"),
    [
        ({"depth": 1.0, "amplitude": -1.0, "frequency": 1.0}, "amplitude"),
        ({"depth": 1.0, "amplitude": 0.1, "frequency": 0.0}, "frequency"),
        ({"amplitude": 0.1, "frequency": 1.0}, "depth, force"),
        ({"force": 1.0, "amplitude": 1.0, "frequency": 1.0}, "amplitude"),
        ({"depth": 1.0, "amplitude": 0.1, "frequency": 1.0, "cycles": 0}, "cycles"),
        ({"depth": 1.0, "amplitude": 0.1, "frequency": 1.0, "cycles": 10**6}, "cycles"),
    ],
)
def test_silly_input_is_refused(options, field):
    assert named(lambda: rs.oscillate(SOLID, rs.Parabola(1.0), **options))[0] == field


def test_a_liquid_has_no_steady_state():
    """It yields until the indenter has no load; its cycles are solved."""
    liquid = rs.Material(rs.PronySeries(0.0, [1.0], [1.0]), bulk=math.inf)
    options = {"depth": 1.0, "amplitude": 0.1, "frequency": UNIT}
    assert named(lambda: rs.oscillate(liquid, rs.Parabola(1.0), **options))[0] == "cycles"
    assert rs.oscillate(liquid, rs.Parabola(1.0), **options, cycles=2).force_harmonics[0].real > 0.0


def test_a_result_shows_itself():
    wave = rs.oscillate(SOLID, rs.Parabola(1.0), depth=1.0, amplitude=0.1, frequency=UNIT)
    assert "error of the reading" in str(wave)
    assert json.loads(json.dumps(wave.to_dict()))["loss_modulus"] == pytest.approx(2.0, rel=1e-12)
    assert wave.history.sizes["time"] == wave.time.size
    assert len(wave.plot().axes) == 3


def test_assumptions_of_an_oscillation():
    """Strain a/R, waves by a w/c with c = sqrt(|G*|/rho), and the window of the material at 1/w."""
    rubber = rs.Material(rs.PronySeries(1e6, [1e6], [1e-3]), bulk=math.inf, density=1000.0, window=(1e-5, 1.0))
    options = {"depth": 1e-4, "amplitude": 1e-6}
    slow = rs.oscillate(rubber, rs.Parabola(1e-2), frequency=10.0, **options)
    assert slow.warnings == []
    assert slow.validity["small_strain"].value == pytest.approx(math.sqrt(1.01e-4 / 1e-2), rel=1e-9)
    speed = math.sqrt(abs(rubber.shear.complex_modulus(20.0 * math.pi)) / 1000.0)
    assert slow.validity["waves"].value == pytest.approx(math.sqrt(1.01e-4 * 1e-2) * 20.0 * math.pi / speed, rel=1e-9)
    fast = rs.oscillate(rubber, rs.Parabola(1e-2), frequency=1e4, **options)
    assert {check.kind for check in fast.validity if check.exceeded} == {"waves"}
    assert "waves" in str(fast)
    # Lysmer and Richart (1966): 0.85 a w/c of loss tangent, just below and above 0.85 %.
    for frequency, exceeded in ((45.0, False), (60.0, True)):
        waves = rs.oscillate(rubber, rs.Parabola(1e-2), frequency=frequency, **options).validity["waves"]
        assert waves.exceeded == exceeded == (waves.value > 0.01)
        assert f"inertia adds {0.85 * waves.value:.2g} to the loss tangent" in waves.message
    beyond = rs.oscillate(rubber, rs.Parabola(1e-2), frequency=2e4, **options)
    assert beyond.validity["window"].value == pytest.approx(1e-5 * 4e4 * math.pi, rel=1e-9)
    deep = rs.oscillate(rubber, rs.Parabola(1e-3), frequency=10.0, **options)
    assert deep.validity["small_strain"].exceeded
    unknown = rs.oscillate(SOLID, rs.Parabola(100.0), depth=1.0, amplitude=0.1, frequency=UNIT)
    assert unknown.validity["waves"].value is None


def test_arrays_of_numbers_are_single_oscillations():
    """Means, amplitudes and frequencies broadcast; a row has the bits of a single oscillation."""
    rng = np.random.default_rng(7)
    depth, frequency = rng.uniform(0.5, 2.0, (2, 1)), 10.0 ** rng.uniform(-2.0, 1.0, 3)
    waves = rs.oscillate(SOLID, rs.Cone(1.2), depth=depth, amplitude=0.05, frequency=frequency)
    assert waves.shape == (2, 3)
    single = rs.oscillate(SOLID, rs.Cone(1.2), depth=depth[1, 0], amplitude=0.05, frequency=frequency[2])
    assert waves.loss_error[1, 2] == single.loss_error
    assert waves[1, 2].force.tobytes() == single.force.tobytes()
    assert waves.storage_modulus == pytest.approx(
        np.tile(4.0 * SOLID.shear.storage_modulus(2.0 * math.pi * frequency), (2, 1)), rel=1e-12
    )
    assert waves.to_dataset()["frequency"].shape == (2, 3)
    assert str(waves).count("\n") > 6
    content = json.loads(json.dumps(waves.to_dict()))
    assert np.shape(content["loss_error"]) == (2, 3)
    assert len(waves.plot().axes) == 2


def test_names_of_arrays_are_kept():
    frequency = xr.DataArray([0.1, 0.2], dims="frequency", coords={"frequency": [0.1, 0.2]})
    amplitude = xr.DataArray([0.1, 0.2, 0.3], dims="swing")
    table = rs.oscillate(SOLID, rs.Parabola(1.0), depth=1.0, amplitude=amplitude, frequency=frequency).to_dataset()
    assert dict(table.sizes) == {"swing": 3, "frequency": 2}
    single = rs.oscillate(SOLID, rs.Parabola(1.0), depth=1.0, amplitude=0.3, frequency=0.2)
    assert float(table["storage_error"].sel(frequency=0.2)[2]) == single.storage_error
    assert table["loss_modulus"].attrs["units"] == "Pa"


@pytest.mark.parametrize("counter", [False, True])
def test_arrays_of_materials_are_single_oscillations(counter):
    """Materials of one, two and three branches; with a second body of two materials, which broadcast against them."""
    rng = np.random.default_rng(11)
    moduli, times = rng.uniform(0.2, 2.0, (3, 3)), 10.0 ** rng.uniform(-1.0, 1.0, (3, 3))
    moduli[0, 1:], moduli[1, 2:] = 0.0, 0.0
    materials = rs.Material(rs.PronySeries(rng.uniform(0.2, 0.4, 3), moduli, times), bulk=math.inf)
    others = rs.Material(rs.PronySeries([[3.0], [5.0]], [[[4.0]], [[1.0]]], [[[0.3]], [[2.0]]]), bulk=math.inf)
    bodies = {"counter_material": others} if counter else {}
    waves = rs.oscillate(materials, rs.Cone(1.2), depth=1.0, amplitude=[0.05, 0.1, 0.2], frequency=0.3, **bodies)
    assert waves.shape == ((2, 3) if counter else (3,))
    place = (1, 2) if counter else (2,)
    single = {"counter_material": others.row(1, 0)} if counter else {}
    alone = rs.oscillate(materials.row(2), rs.Cone(1.2), depth=1.0, amplitude=0.2, frequency=0.3, **single)
    assert waves[place].force.tobytes() == alone.force.tobytes()
    assert waves.storage_error[place] == alone.storage_error
    # Few branches beside others have the bits that they have alone, without terms of no modulus.
    first = rs.Material(
        rs.PronySeries(materials.shear.equilibrium_modulus[0], moduli[0, :1], times[0, :1]), bulk=math.inf
    )
    single = {"counter_material": others.row(0, 0)} if counter else {}
    alone = rs.oscillate(first, rs.Cone(1.2), depth=1.0, amplitude=0.05, frequency=0.3, **single)
    assert waves[(0, 0) if counter else (0,)].force == pytest.approx(alone.force, rel=1e-10)
    assert len(waves.plot().axes) == 2


def test_materials_keep_the_names_of_their_constants():
    viscosity = xr.DataArray([0.5, 2.0], dims="viscosity", coords={"viscosity": [0.5, 2.0]})
    frequency = xr.DataArray([0.1, 0.2, 0.4], dims="frequency", coords={"frequency": [0.1, 0.2, 0.4]})
    material = rs.standard_solid(0.25, 1.0, viscosity, poisson_ratio=0.5)
    table = rs.oscillate(material, rs.Parabola(1.0), depth=1.0, amplitude=0.1, frequency=frequency).to_dataset()
    assert dict(table.sizes) == {"viscosity": 2, "frequency": 3}
    alone = rs.oscillate(
        rs.standard_solid(0.25, 1.0, 2.0, poisson_ratio=0.5), rs.Parabola(1.0), depth=1.0, amplitude=0.1, frequency=0.4
    )  # fmt: skip
    assert float(table["storage_error"].sel(viscosity=2.0, frequency=0.4)) == alone.storage_error


def test_arrays_of_forces():
    waves = rs.oscillate(
        SOLID, rs.Parabola(1.0), force=[1.0, 2.0], amplitude=0.05, frequency=UNIT, cycles=2, hold_time=1.0
    )
    assert [wave.force_harmonics[0].real for wave in waves.rows] == pytest.approx([1.0, 2.0], rel=1e-6)
    assert set(waves.status.tolist()) == {OscillationStatus.LAST_CYCLE}


@pytest.mark.parametrize(
    ("options", "field"),
    [
        ({"depth": [1.0, -1.0], "amplitude": 0.1, "frequency": 1.0}, "depth"),
        ({"depth": [1.0, 2.0], "amplitude": [0.1, 0.1, 0.1], "frequency": 1.0}, "depth, amplitude, frequency"),
        ({"force": [1.0, 0.1], "amplitude": 0.5, "frequency": 1.0}, "amplitude"),
        ({"depth": 1.0, "amplitude": 0.1, "frequency": []}, "depth, amplitude, frequency"),
    ],
)
def test_silly_arrays_are_refused(options, field):
    assert named(lambda: rs.oscillate(SOLID, rs.Parabola(1.0), **options))[0] == field


@pytest.mark.parametrize(
    ("profile", "radius_of"),
    [
        (rs.Parabola(1.0), lambda y: y),
        pytest.param(rs.Cone(1.1), lambda y: 2.0 * math.tan(1.1) / math.pi * y * y, marks=pytest.mark.slow),
    ],
)
def test_many_cycles_of_a_large_force(profile, radius_of):
    """Equal elements over all cycles; where each cycle leaves a trace of its own, some twenty end in a refusal."""
    series, rate, count, cycles = rs.PronySeries(1.0, [4.0], [1.0]), 0.3, 200, 40
    wave = rs.oscillate(
        rs.Material(series.scaled(0.25), math.inf), profile, force=1.0, amplitude=0.8, frequency=rate, cycles=cycles
    )
    steady = rs.oscillate(
        rs.Material(series.scaled(0.25), math.inf), profile, force=1.0, amplitude=0.8, frequency=rate
    )
    assert steady.status == OscillationStatus.STEADY
    assert wave.depth_harmonics[:2] == pytest.approx(steady.depth_harmonics[:2], abs=1e-6)
    widest, result = 1.1 * math.sqrt(abs(wave.depth_harmonics[0]) + 1.2 * abs(wave.depth_harmonics[1])), []
    for n in (1, 2):
        steps = 64 * n
        times = np.append(np.linspace(0.0, 1.0, steps // 2), 1.0 + np.arange(1, cycles * steps + 1) / steps) / rate
        forces = np.where(times * rate <= 1.0, times * rate, 1.0 + 0.8 * np.sin(2.0 * math.pi * (rate * times - 1.0)))
        last = pressed_elements(series, radius_of, times, forces, widest, n * count)[-steps:]
        result.append(
            np.array([last.mean(), 2j * np.mean(last * np.exp(-2j * math.pi * np.arange(1, steps + 1) / steps))])
        )
    # A third of the difference is left: errors are of second order.
    change = np.abs(result[1] - result[0])
    assert np.all(np.abs(wave.depth_harmonics[:2] - result[1]) <= 0.6 * change + 1e-8)
    assert np.all(change <= 1e-3)


def test_harmonics_of_a_first_cycle_are_integrals():
    """A punch has F/(2 a) = d + 4 h with h' = d' - h; the first cycle is not periodic, and its harmonics are exact."""
    mean, swing, omega = 1.0, 0.2, 3.0
    wave = rs.oscillate(
        SOLID,
        rs.FlatPunch(0.5),
        depth=mean,
        amplitude=swing,
        frequency=omega / (2.0 * math.pi),
        cycles=1,
        rise_time=1.0,
    )
    steady = swing * 1j * omega / (1.0 + 1j * omega)
    rest = mean * -math.expm1(-1.0) - steady.imag

    def force(time):
        depth = mean + swing * math.sin(omega * time)
        return depth + 4.0 * ((steady * np.exp(1j * omega * time)).imag + rest * math.exp(-time))

    period = 2.0 * math.pi / omega
    for n in range(3):
        sine, cosine = (
            quad(lambda time, shape=shape, n=n: force(time) * shape(n * omega * time), 0.0, period, epsabs=1e-13)[0]
            for shape in (math.sin, math.cos)
        )
        expected = cosine / period if n == 0 else 2.0 * (sine + 1j * cosine) / period
        assert wave.force_harmonics[n] == pytest.approx(expected, abs=1e-8)
    assert wave.force == pytest.approx([force(time) for time in wave.time], abs=1e-7)
    assert wave.depth_harmonics[:2] == pytest.approx([mean, swing], abs=1e-12)


def test_the_share_of_contact_of_a_tip_without_a_radius():
    wave = {"depth": 1.0, "amplitude": 0.9, "frequency": UNIT}
    few, steady = (rs.oscillate(SOLID, rs.Pyramid(1.2), cycles=cycles, **wave) for cycles in (40, None))
    assert few.contact_share == pytest.approx(steady.contact_share, abs=1e-5)
    assert rs.oscillate(SOLID, rs.Pyramid(1.2), force=1.0, amplitude=0.1, frequency=UNIT).contact_share == 1.0


@pytest.mark.parametrize("time", [1e8, 1e12])
def test_a_part_that_creeps_in_very_many_periods_is_not_steady(time):
    slow = rs.Material(rs.PronySeries(0.25, [0.5], [time]), bulk=math.inf)
    wave = rs.oscillate(slow, rs.Parabola(1.0), force=1.0, amplitude=0.2, frequency=1.0)
    assert wave.status is OscillationStatus.NOT_STEADY
    flows = rs.Material(rs.PronySeries(0.0, [0.5], [time]), bulk=math.inf)
    wave = rs.oscillate(flows, rs.Parabola(1.0), force=1.0, amplitude=0.2, frequency=1.0)
    assert wave.status is OscillationStatus.NOT_STEADY


def test_a_force_on_a_layer_has_the_moduli_of_its_contact():
    """A bonded layer of a material whose Poisson ratio changes: the same history by `rs.indent`."""
    body = rs.Material(rs.PronySeries(1.0, [2.0], [0.5]), bulk=30.0)
    layer, mean, swing = rs.Layer(rs.Parabola(1.0), 0.3), 1.0, 0.4
    with pytest.warns(rs.RestitutionWarning):
        wave = rs.oscillate(body, layer, force=mean, amplitude=swing, frequency=1.0, cycles=1)

    def force(time):
        return np.where(time < 1.0, mean * time, mean + swing * np.sin(2.0 * math.pi * time))

    with pytest.warns(rs.RestitutionWarning):
        result = rs.indent(body, layer, force=force, time=[0.0, 1.0, 1.25, 1.5, 1.75, 2.0])
    depths = result.sample(1.0 + wave.time).indentation_depth.values
    assert wave.indentation_depth == pytest.approx(depths, abs=1e-7 * depths.max())
    assert wave.max_contact_radius == pytest.approx(result.max_contact_radius, rel=1e-5)
