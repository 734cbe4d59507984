"""Tapping: row T1 of the design page on cycles, free oscillation, energy, and plain taps."""

import math
from types import SimpleNamespace

import numpy as np
import pytest

import restitution as rs
from independent_elements import Lever, tap_elements
from refusals import named
from restitution.indentation.panels import PanelSolution
from restitution.indentation.surface import Imprint
from restitution.indentation.tapping import TappingStatus
from restitution.kernel.panels import FROZEN, NODES

SOLID = rs.Material(rs.PronySeries(0.25, [1.0], [1.0]), bulk=math.inf)
OPTIONS = {"spring_constant": 1.0, "quality_factor": 10.0, "frequency": 0.5 / math.pi, "free_amplitude": 1.0}


@pytest.mark.parametrize("rtol", [1e-6, 1e-8, 1e-10])
def test_the_row_of_a_standard_solid(rtol):
    """m = k = 1, Q = 10, drive cos(t)/10, D = 0.8; 12 digits from panels of two orders and 69 plain taps."""
    curve = rs.tap(SOLID, rs.Parabola(1.0), 0.8, **OPTIONS, rtol=rtol)
    assert curve.status[0] == TappingStatus.PERIODIC
    assert curve.amplitude[0] == pytest.approx(0.925092312856, abs=rtol)
    assert math.degrees(curve.phase[0]) == pytest.approx(-70.32667892693, abs=100.0 * rtol)
    assert curve.dissipated[0] == pytest.approx(0.004591248550, abs=rtol)
    assert curve.contact_share[0] == pytest.approx(0.1330560150, abs=10.0 * rtol)
    assert curve.mean_force[0] == pytest.approx(0.0170985472, abs=max(rtol, 1e-10))


def beside_elements(lever, count, steps, taps):
    """Return the numbers of equal elements, extrapolated from two sizes, and their difference."""
    arguments = {"equilibrium": 1.0, "moduli": np.array([4.0]), "times": np.array([1.0]), "depth": 1.0, "taps": taps}
    coarse, fine = (tap_elements(lever, **arguments, count=n * count, steps=n * steps) for n in (1, 2))
    return fine + (fine - coarse) / 3.0, np.abs(fine - coarse)


def numbers_of(curve, n=0):
    """Return what `tap_elements` does."""
    return np.array([getattr(curve, k)[n] for k in ("amplitude", "phase", "mean_force", "max_force", "dissipated")])


@pytest.mark.slow
@pytest.mark.parametrize(("distance", "share"), [(-0.2, 0.789), (-0.3, 1.0)])
def test_a_tip_that_hardly_leaves_or_stays_in_contact(distance, share):
    """Equal elements with a second-order step, which start from rest; each tap starts in contact."""
    curve = rs.tap(SOLID, rs.Parabola(1.0), distance, **OPTIONS)
    assert curve.status[0] == TappingStatus.PERIODIC
    assert curve.contact_share[0] == pytest.approx(share, abs=2e-3)
    expected, change = beside_elements(Lever(10.0, 0.1, distance), 100, 400, 40)
    # Elements change state within a step, and the largest force is one of 800 values: 1/800^2 remains, and less.
    assert np.all(np.abs(numbers_of(curve) - expected) < np.array([1e-6, 1e-5, 1e-6, 1e-5, 1e-6]) + 0.5 * change)


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(4))
def test_most_distances_of_a_solid_are_solved(seed):
    """From free taps to a tip that stays in contact: what the drive gives is lost in air and in the surface.

    The power of the drive is P w A sin(-phase)/2 exactly; the lever takes c w^2 A^2/2 and more in higher harmonics.
    """
    rng = np.random.default_rng(seed)
    count = int(rng.integers(1, 4))
    series = rs.PronySeries(0.25, rng.uniform(0.2, 2.0, count), 10.0 ** rng.uniform(-1.0, 1.0, count))
    material = rs.Material(series, bulk=math.inf)
    quality, profile = float(10.0 ** rng.uniform(0.5, 1.5)), (rs.Parabola(1.0), rs.Cone(0.8))[seed % 2]
    places = np.sort(rng.uniform(-1.5, 1.0, 6))[::-1]
    curve = rs.tap(material, profile, places, **(OPTIONS | {"quality_factor": quality}))
    solved = curve.status == TappingStatus.PERIODIC
    assert solved.sum() >= 3
    left = math.pi / quality * curve.amplitude * (np.sin(-curve.phase) - curve.amplitude)
    assert np.all((curve.dissipated > -1e-8)[solved] & (curve.dissipated < left + 1e-8)[solved])


def test_a_distance_where_a_free_tip_would_begin_below_the_surface():
    """The mean force holds the mean deflection of the lever, and for a small swing it is that of the relaxed solid.

    F = 4/3 sqrt(R) d^(3/2) with the equilibrium modulus 1 at the mean depth, within the square of the swing.
    """
    curve = rs.tap(SOLID, rs.Parabola(1.0), -2.0, **(OPTIONS | {"free_amplitude": 0.01}))
    assert curve.status[0] == TappingStatus.PERIODIC
    assert curve.contact_share[0] == 1.0
    # k (2 - d) = F(d)
    depth = 2.0 - curve.mean_force[0]
    assert curve.mean_force[0] == pytest.approx(4.0 / 3.0 * depth**1.5, rel=1e-4)


@pytest.mark.slow
@pytest.mark.parametrize("distance", [1.01, 0.8, -0.2])
def test_a_van_der_waals_force(distance):
    """C = H R/6 = 6e-4, a0 = 0.05: equal elements feel C/(gap + a0)^2 over the surface as it is, C/a0^2 in contact."""
    curve = rs.tap(
        SOLID, rs.Parabola(1.0), distance, **OPTIONS, hamaker=36e-4, intermolecular_distance=0.05, rtol=1e-7
    )  # fmt: skip
    assert curve.status[0] == TappingStatus.PERIODIC
    expected, change = beside_elements(Lever(10.0, 0.1, distance, 6e-4, 0.05), 100, 800, 50)
    # The force has a kink within a step of 0.004, a tenth of a0: 1e-3 of what the pull changes, 0.07 m and 0.4 rad.
    assert np.all(np.abs(numbers_of(curve) - expected) < np.array([7e-5, 4e-4, 2e-5, 2e-4, 2e-5]) + change)


@pytest.mark.parametrize("profile", [rs.Cone(0.8), rs.FlatPunch(1.0)])
def test_a_van_der_waals_force_needs_a_radius(profile):
    assert named(lambda: rs.tap(SOLID, profile, 0.8, **OPTIONS, hamaker=1e-19))[0] == "hamaker"


def test_a_weak_pull_beyond_reach_detunes_the_lever():
    """Without contact the pull softens the lever by its mean slope: phase and amplitude of a linear oscillator.

    For D >> A the force C/(D + a0 + z)^2 has the slope -2 C/(D + a0)^3, within (A/D)^2.
    """
    curve = rs.tap(SOLID, rs.Parabola(1.0), 30.0, **OPTIONS, hamaker=600.0, intermolecular_distance=0.1)
    # The mean pull brings the tip closer.
    mean = -curve.mean_force[0]
    softer = 2.0 * 100.0 / (30.1 - mean) ** 3
    response = 0.1 / complex(-softer, 0.1)
    assert curve.contact_share[0] == 0.0
    assert curve.amplitude[0] == pytest.approx(abs(response), rel=3e-3 * softer / 0.1)
    assert curve.phase[0] == pytest.approx(math.atan2(response.imag, response.real), abs=3e-3 * softer / 0.1)
    assert abs(curve.dissipated[0]) < 1e-8


def test_units_scale():
    """The same row for a tip of 10 nm on a material of 1 MPa: all lengths, forces and times scale."""
    length, modulus, time = 1e-8, 1e6, 1e-6
    material = rs.Material(rs.PronySeries(0.25 * modulus, [modulus], [time]), bulk=math.inf)
    curve = rs.tap(
        material, rs.Parabola(length), 0.8 * length, spring_constant=modulus * length, quality_factor=10.0,
        frequency=0.5 / math.pi / time, drive=0.1 * modulus * length**2,
    )  # fmt: skip
    assert curve.free_amplitude == pytest.approx(length, rel=1e-12)
    assert curve.amplitude[0] == pytest.approx(0.925092312856 * length, rel=1e-8)
    assert curve.dissipated[0] == pytest.approx(0.004591248550 * modulus * length**3, rel=1e-7)


def test_what_the_drive_gives_is_lost():
    """A period takes pi P A sin(-phase) from the drive; air takes pi c w A^2 of it, and a little by higher harmonics."""
    curve = rs.tap(SOLID, rs.Parabola(1.0), np.array([0.95, 0.9, 0.8, 0.7]), **OPTIONS)
    left = math.pi * 0.1 * curve.amplitude * (np.sin(-curve.phase) - curve.amplitude)
    assert np.all(curve.dissipated < left)
    assert curve.dissipated == pytest.approx(left, rel=0.1)
    assert np.all(np.diff(curve.dissipated) > 0.0)
    assert np.all(np.diff(curve.amplitude) < 0.0)


def test_an_elastic_surface_takes_no_energy():
    curve = rs.tap(rs.elastic(youngs_modulus=1.0, poisson_ratio=0.5), rs.Parabola(1.0), [0.9, 0.8], **OPTIONS)
    assert np.all(curve.status == TappingStatus.PERIODIC)
    assert np.abs(curve.dissipated).max() < 1e-8


def test_a_distance_beyond_the_free_amplitude():
    curve = rs.tap(SOLID, rs.Parabola(1.0), [1.2, 0.9], **OPTIONS, resonance_frequency=0.17)
    assert curve.status.tolist() == [TappingStatus.FREE, TappingStatus.PERIODIC]
    assert curve.amplitude[0] == pytest.approx(1.0, rel=1e-12)
    # Below the resonance: tan(phase) = -(r/Q)/(1 - r^2).
    r = 0.5 / math.pi / 0.17
    assert curve.phase[0] == pytest.approx(-math.atan2(r / 10.0, 1.0 - r * r), rel=1e-12)


def test_too_few_taps_are_a_status():
    curve = rs.tap(SOLID, rs.Parabola(1.0), 0.8, **OPTIONS, max_taps=5)
    assert curve.status[0] == TappingStatus.NOT_PERIODIC
    assert curve.taps[0] == 5
    assert 0.5 < curve.amplitude[0] < 1.0


def test_too_many_panels_are_a_status(monkeypatch):
    """A contact under load keeps its panels; the numbers are those of the last tap, not NaN."""
    import restitution.indentation.tapping as tapping

    monkeypatch.setattr(tapping, "_MOST_PANELS", 40)
    slow = rs.Material(rs.PronySeries(0.05, [1.0, 0.3], [1.0, 10.0]), bulk=math.inf)
    curve = rs.tap(slow, rs.Parabola(1.0), [-1.0, 0.9], **OPTIONS, max_taps=10)
    assert curve.status[0] == TappingStatus.CROWDED
    assert not TappingStatus.CROWDED.failed
    assert 0.0 < curve.amplitude[0] < 1.0
    # The next distance begins anew.
    assert curve.status[1] == TappingStatus.NOT_PERIODIC


@pytest.mark.slow
def test_a_liquid_that_sinks_keeps_few_panels(monkeypatch):
    """Each tap leaves traces, which are merged: after 50 taps a third of them is gone, and ever more of them later."""
    import restitution.indentation.panels as panels
    import restitution.indentation.tapping as tapping

    sizes = []
    end = tapping.Tapper.end

    def counted(self, solution):
        after = end(self, solution)
        sizes.append(after.imprint.end.size)
        return after

    monkeypatch.setattr(tapping.Tapper, "end", counted)
    monkeypatch.setattr(tapping, "_COARSE", 1e-8)
    liquid = rs.Material(rs.PronySeries(0.0, [1.0, 0.5], [1.0, 20.0]), bulk=math.inf)
    curve = rs.tap(liquid, rs.Parabola(1.0), 0.3, **OPTIONS, max_taps=50)
    assert curve.status[0] == TappingStatus.NOT_PERIODIC
    merged = max(sizes)
    sizes.clear()
    monkeypatch.setattr(panels, "merged", lambda imprint, *_: imprint)
    rs.tap(liquid, rs.Parabola(1.0), 0.3, **OPTIONS, max_taps=50)
    assert merged < 0.8 * max(sizes)


def test_gap_between_a_tip_and_an_imprint_of_nearly_its_shape():
    """u_j = a_j - s_j y^2 at an instant 0.7 s ago, so that the gap is (1 - sum s_j exp(-0.7 r_j)) y^2 now."""
    y = np.array([3.0, 2.0, 1.0, 0.5, 0.0])
    rates, depths, slopes = np.array([0.0, 2.0]), np.array([0.4, 0.2]), np.array([0.5, 0.3])
    outer, inner = y[:-1], y[1:]
    rows = np.zeros((4, 3, NODES))
    rows[:, 0, 0], rows[:, 0, 1] = 0.5 * (outer + inner), 0.5 * (inner - outer)
    # y^2 = (b + c x)^2 = b^2 + c^2/2 + 2 b c T1 + c^2/2 T2.
    b, c = rows[:, 0, 0], rows[:, 0, 1]
    square = np.column_stack([b * b + 0.5 * c * c, 2.0 * b * c, 0.5 * c * c])
    rows[:, 1:, :3] = -slopes[:, None] * square[:, None]
    rows[:, 1:, 0] += depths
    zeros = np.zeros(4)
    imprint = Imprint(rows, zeros - 0.7, zeros, np.full(4, FROZEN), zeros + 1.0, np.zeros(4, dtype=np.int64))
    assert imprint.gap(rates) == pytest.approx(1.0 - slopes @ np.exp(-0.7 * rates), rel=1e-12)
    assert imprint.axis_depth(rates) == pytest.approx(depths @ np.exp(-0.7 * rates), rel=1e-12)
    assert imprint.some(slice(0)).gap(rates) == 1.0


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(12))
def test_extrapolated_taps_end_where_plain_taps_do(seed, monkeypatch):
    """Random solids and distances; plain taps run through the whole transient."""
    import restitution.indentation.tapping as tapping

    rng = np.random.default_rng(seed)
    count = int(rng.integers(1, 3))
    series = rs.PronySeries(0.25, rng.uniform(0.2, 2.0, count), 10.0 ** rng.uniform(-1.0, 0.5, count))
    material = rs.Material(series, bulk=math.inf)
    options = OPTIONS | {"quality_factor": float(rng.uniform(3.0, 8.0))}
    distance = float(rng.uniform(0.7, 0.95))
    quick = rs.tap(material, rs.Parabola(1.0), distance, **options)
    monkeypatch.setattr(tapping, "_MEMORY", 1)
    plain = rs.tap(material, rs.Parabola(1.0), distance, **options)
    assert quick.status[0] == plain.status[0] == TappingStatus.PERIODIC
    assert quick.amplitude[0] == pytest.approx(plain.amplitude[0], abs=3e-8)
    assert quick.phase[0] == pytest.approx(plain.phase[0], abs=1e-7)


@pytest.mark.slow
def test_a_surface_that_relaxes_slowly_is_that_of_many_plain_taps(monkeypatch):
    """Relaxation over 10 periods, and creep over 30: plain taps go on until nothing changes."""
    import restitution.indentation.tapping as tapping

    slow = rs.Material(rs.PronySeries(0.25, [1.0, 0.5], [1.0, 63.0]), bulk=math.inf)
    options = OPTIONS | {"quality_factor": 5.0, "max_taps": 900}
    quick = rs.tap(slow, rs.Parabola(1.0), 0.8, **options)
    monkeypatch.setattr(tapping, "_MEMORY", 1)
    plain = rs.tap(slow, rs.Parabola(1.0), 0.8, **options)
    assert quick.status[0] == plain.status[0] == TappingStatus.PERIODIC
    assert quick.taps[0] < 60 < 300 < plain.taps[0]
    # Taps are periodic where they change by 1e-9: some 30 of them are left.
    assert numbers_of(quick) == pytest.approx(numbers_of(plain), abs=1e-7)


def test_a_slow_polymer_is_steady():
    """Relaxation over up to 50 periods and creep over 150: thirty more taps change nothing."""
    import restitution.indentation.tapping as tapping
    from restitution.indentation.solve import contact_of

    polymer = rs.Material(rs.PronySeries(0.1, [1.0, 0.3, 0.3, 0.2], [0.5, 5.0, 50.0, 300.0]), bulk=math.inf)
    lever = tapping.cantilever(1.0, 10.0, 0.5 / math.pi, None, 1.0, None)
    tapper = tapping.Tapper(contact_of(polymer, rs.Parabola(1.0), None), lever, tapping.Pull(), 1e-8)
    solution, after, status = tapper.steady(0.7, tapper.free(0.7), 100)
    assert status == TappingStatus.PERIODIC
    before, level = tapping.numbers_of_tap(tapper, 0.7, solution), after.level
    for _ in range(30):
        solution = tapper.run(0.7, after)
        after = tapper.end(solution)
    numbers = tapping.numbers_of_tap(tapper, 0.7, solution)
    # A distance e from the steady surface would change by about e (1 - exp(-30/150)).
    assert after.level == pytest.approx(level, abs=1e-9)
    assert level > 0.05
    for name in ("amplitude", "phase", "dissipated", "mean_force"):
        assert numbers[name] == pytest.approx(before[name], abs=1e-8)


@pytest.mark.parametrize("top", [0.4, 0.995, 0.9999, 1.0, 1.0001, 1.005, 1.7])
def test_the_largest_force_lies_anywhere_beside_a_joint_of_two_steps(top):
    """F = 3 - (t - top)^2 over the steps [0, 1] and [1, 2]; a value between the joint and the next place is larger."""
    rows = np.zeros((2, 4, NODES))
    for n, row in enumerate(rows):
        # t = n + (1 + x)/2, so that (t - top)^2 = (b + x/2)^2.
        b = n + 0.5 - top
        row[2, :3] = 3.0 - b * b - 0.125, -b, -0.125
    solution = object.__new__(PanelSolution)
    solution._room = SimpleNamespace(records=SimpleNamespace(columns=rows))
    solution._records = None, None, None, np.arange(2)
    solution.units = SimpleNamespace(force=2.0)
    assert solution.largest(2) == pytest.approx(6.0, rel=1e-15)


@pytest.mark.parametrize("power", [6.0, 9.0, 12.0])
def test_a_part_that_relaxes_in_a_million_taps_and_more(power):
    """A part far slower than a period feels the mean load alone: the numbers are a series in the period over its time.

    The limit is extrapolated from times of 160 and 320 periods; the next term is their square.
    """

    def numbers(time):
        polymer = rs.Material(rs.PronySeries(0.1, [1.0, 0.5], [1.0, time]), bulk=math.inf)
        curve = rs.tap(polymer, rs.Parabola(1.0), 0.7, **OPTIONS)
        assert curve.status[0] == TappingStatus.PERIODIC
        return numbers_of(curve)

    first, second = numbers(1e3), numbers(2e3)
    time = 10.0 ** (power + np.random.default_rng(int(power)).uniform(-0.5, 0.5))
    assert np.all(np.abs(first - second) > 1e-7)
    assert numbers(time) == pytest.approx(2.0 * second - first, abs=1e-7)


@pytest.mark.parametrize("seed", range(3))
def test_a_steady_tip_within_the_free_amplitude_touches(seed):
    """A surface that has sunk too far recovers until the tip touches it, however slowly that is."""
    rng = np.random.default_rng(seed)
    series = rs.PronySeries(0.02, rng.uniform(0.1, 1.0, 3), 10.0 ** rng.uniform(0.0, 4.0, 3))
    material = rs.Material(series, bulk=math.inf)
    curve = rs.tap(material, rs.Parabola(1.0), [0.95, 0.7, 0.5], **OPTIONS, max_taps=60)
    solved = curve.status == TappingStatus.PERIODIC
    assert np.all(curve.contact_share[solved] > 0.0)
    assert solved.sum() >= 1


@pytest.mark.parametrize(
    ("change", "field"),
    [
        ({"quality_factor": 0.4}, "quality_factor"),
        ({"free_amplitude": None}, "free_amplitude, drive"),
        ({"spring_constant": -1.0}, "spring_constant"),
        ({"max_taps": 1}, "max_taps"),
        ({"rtol": 1.0}, "rtol"),
        ({"hamaker": 0.0}, "hamaker"),
        ({"hamaker": 1.0, "intermolecular_distance": -1.0}, "intermolecular_distance"),
    ],
)
def test_silly_input_is_refused(change, field):
    assert named(lambda: rs.tap(SOLID, rs.Parabola(1.0), 0.8, **(OPTIONS | change)))[0] == field


def test_a_result_shows_itself():
    curve = rs.tap(SOLID, rs.Parabola(1.0), [1.1, 0.9], **OPTIONS)
    assert "PERIODIC" in str(curve)
    assert curve.to_dataset().sizes["distance"] == 2
    assert len(curve.plot().axes) == 4
