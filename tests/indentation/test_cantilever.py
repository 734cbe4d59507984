"""Higher modes of a cantilever: ratios of a beam, limits, and direct integration in time."""

import math

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import restitution as rs
from independent_elements import Lever, tap_elements
from refusals import named
from restitution.indentation.tapping import TappingStatus

RATE = 0.5 / math.pi
SOLID = rs.Material(rs.PronySeries(0.25, [1.0], [1.0]), bulk=math.inf)
OPTIONS = {"spring_constant": 1.0, "quality_factor": 10.0, "frequency": RATE, "free_amplitude": 1.0}


def test_modes_of_a_beam():
    """Ratios of frequencies as in Butt and Jaschke, Nanotechnology 6 (1995): (4.694/1.875)^2 and so on."""
    modes = rs.beam_modes(spring_constant=2.0, frequency=3.0, quality_factors=[100.0] * 16)
    ratios = np.array([mode.frequency / 3.0 for mode in modes])
    assert ratios[:3] == pytest.approx([6.2669, 17.5475, 34.3861], rel=1e-5)
    stiffness = np.array([mode.spring_constant for mode in modes])
    assert np.array([mode.mass for mode in modes]) == pytest.approx(2.0 / (6.0 * math.pi) ** 2, rel=1e-12)
    # All modes together bend like the beam at rest, 1/k = L^3/(3 E I); the first has 12/b_1^4 of it.
    rest = 1.8751040687**4 / 12.0 / 2.0
    # Roots behind the 17th are at (n - 1/2) pi: their compliances are b_1^4/pi^4 times the integral of 1/x^4 from 17.
    more = 1.8751040687**4 / (3.0 * 17.0**3 * math.pi**4) / 2.0
    assert 1.0 / 2.0 + np.sum(1.0 / stiffness) + more == pytest.approx(rest, rel=1e-7)


def test_a_stiff_second_mode_is_none():
    """With k = 1e6 the second mode gives way by F/k = 2e-7."""
    curve = rs.tap(SOLID, rs.Parabola(1.0), 0.8, **OPTIONS, modes=[rs.CantileverMode(1e6, 1e3 * RATE, 10.0)])
    assert curve.status[0] == TappingStatus.PERIODIC
    # Row T1 of the design page on cycles.
    assert curve.amplitude[0] == pytest.approx(0.925092312856, abs=3e-7)
    assert math.degrees(curve.phase[0]) == pytest.approx(-70.32667892693, abs=3e-5)
    assert curve.dissipated[0] == pytest.approx(0.004591248550, abs=3e-7)
    assert curve.mode_swing[0, 1] < 2.5e-7


def elastic_taps(distance, modes, quality, periods):
    """Amplitude and phase of the tip, and half of the way of each mode, over an elastic half-space by SciPy."""
    stiffness, omega, qualities = np.array([(1.0, 1.0, quality), *modes]).T
    mass, count = stiffness / omega**2, stiffness.size
    push = np.append(1.0 / quality, np.zeros(count - 1))

    def pace(t, state):
        heights, rates = state[:count], state[count:]
        # Hertz, E* = 4/3, R = 1.
        force = 16.0 / 9.0 * max(-(distance + heights.sum()), 0.0) ** 1.5
        springs = stiffness * heights + mass * omega / qualities * rates
        return np.concatenate([rates, (push * math.cos(t) + force - springs) / mass])

    start, stop = np.zeros(2 * count), 2.0 * math.pi * periods
    times = stop - 2.0 * math.pi * np.arange(4096)[::-1] / 4096
    motion = solve_ivp(pace, (0.0, stop), start, method="DOP853", rtol=1e-10, atol=1e-12, max_step=0.05, t_eval=times)
    heights = motion.y[:count]
    harmonic = np.mean(2.0 * heights.sum(axis=0) * np.exp(-1j * times))
    return abs(harmonic), math.atan2(harmonic.imag, harmonic.real), 0.5 * np.ptp(heights, axis=1)


@pytest.mark.slow
def test_taps_on_an_elastic_surface_beside_scipy():
    """Two higher modes of random stiffness; after 30 periods exp(-30 pi/4) = 6e-11 of the transient is left."""
    rng = np.random.default_rng(7)
    modes = [(float(rng.uniform(10.0, 60.0)), float(rng.uniform(5.0, 8.0)), 15.0)]
    modes.append((float(rng.uniform(100.0, 400.0)), float(rng.uniform(14.0, 20.0)), 20.0))
    distance = float(rng.uniform(0.6, 0.9))
    amplitude, phase, ways = elastic_taps(distance, modes, 4.0, 30)
    higher = [rs.CantileverMode(k, RATE * omega, quality) for k, omega, quality in modes]
    surface = rs.elastic(youngs_modulus=1.0, poisson_ratio=0.5)
    curve = rs.tap(surface, rs.Parabola(1.0), distance, **(OPTIONS | {"quality_factor": 4.0}), modes=higher)
    assert curve.status[0] == TappingStatus.PERIODIC
    assert abs(curve.dissipated[0]) < 1e-8
    assert curve.amplitude[0] == pytest.approx(amplitude, abs=2e-8)
    assert curve.phase[0] == pytest.approx(phase, abs=2e-8)
    # The ends of the way are between 4096 times of a period: within (pi/4096)^2 (w_n)^2/2 of the way.
    assert curve.mode_swing[0] == pytest.approx(ways, rel=1e-4)


@pytest.mark.slow
@pytest.mark.parametrize("distance", [0.8, -0.2])
def test_taps_on_a_standard_solid_beside_elements(distance):
    """Equal elements and velocity Verlet, extrapolated; at the smaller distance the tip hardly leaves the surface."""
    (mode,) = rs.beam_modes(spring_constant=1.0, frequency=RATE, quality_factors=[20.0])
    curve = rs.tap(SOLID, rs.Parabola(1.0), distance, **OPTIONS, modes=[mode])
    assert curve.status[0] == TappingStatus.PERIODIC
    lever = Lever(10.0, 0.1, distance, modes=((mode.spring_constant, mode.frequency / RATE, mode.quality_factor),))
    arguments = {"equilibrium": 1.0, "moduli": np.array([4.0]), "times": np.array([1.0]), "depth": 1.0, "taps": 40}
    coarse, fine = (tap_elements(lever, **arguments, count=n * 100, steps=n * 800) for n in (1, 2))
    names = ("amplitude", "phase", "mean_force", "max_force", "dissipated")
    results = [*(getattr(curve, name)[0] for name in names), *curve.mode_amplitude[0], *curve.mode_swing[0]]
    # Largest values of 1600 a period, in which the second mode has 6.3 periods.
    assert np.all(np.abs(results - fine - (fine - coarse) / 3.0) < 2e-6 + np.abs(fine - coarse))


@pytest.mark.parametrize(
    ("call", "field"),
    [
        (lambda: rs.CantileverMode(-1.0, 1.0, 10.0), "spring_constant"),
        (lambda: rs.CantileverMode(1.0, 0.0, 10.0), "frequency"),
        (lambda: rs.CantileverMode(1.0, 1.0, 0.5), "quality_factor"),
        (lambda: rs.beam_modes(spring_constant=1.0, frequency=1.0, quality_factors=[]), "quality_factors"),
        (lambda: rs.beam_modes(spring_constant=1.0, frequency=1.0, quality_factors=3.0), "quality_factors"),
        (lambda: rs.beam_modes(spring_constant=1.0, frequency=1.0, quality_factors=[9.0] * 17), "quality_factors"),
        (lambda: rs.tap(SOLID, rs.Parabola(1.0), 0.8, **OPTIONS, modes=[10.0]), "modes[0]"),
        (lambda: rs.tap(SOLID, rs.Parabola(1.0), 0.8, **OPTIONS, modes=3.0), "modes"),
    ],
)
def test_silly_modes_are_refused(call, field):
    assert named(call)[0] == field


def test_a_result_with_modes_shows_them():
    modes = rs.beam_modes(spring_constant=1.0, frequency=RATE, quality_factors=[30.0])
    curve = rs.tap(SOLID, rs.Parabola(1.0), [1.2, 0.9], **OPTIONS, modes=modes)
    assert curve.status.tolist() == [TappingStatus.FREE, TappingStatus.PERIODIC]
    assert curve.mode_amplitude[0].tolist() == pytest.approx([1.0, 0.0])
    data = curve.to_dataset()
    assert data.mode_swing.sel(mode=2, distance=0.9) == curve.mode_swing[1, 1] > 0.0
    # All heights are those of the tip: the first harmonics add up.
    parts = curve.mode_amplitude[1] * np.exp(1j * curve.mode_phase[1])
    assert parts.sum() == pytest.approx(curve.amplitude[1] * np.exp(1j * curve.phase[1]), rel=1e-9)
    assert len(curve.plot().axes) == 5
