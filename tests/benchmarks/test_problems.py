"""Problems and methods of the benchmarks; no test asserts a time."""

from itertools import pairwise

import machine
import numpy as np
import pytest
import short as summary
import timing
from problems import Impacts, StandardSolids, even_prony, of_profile, plane, random_prony, wide

from restitution import Cone, Parabola, dimensionless_groups, standard_solid_restitution


@pytest.mark.parametrize(("points", "p2", "p3"), [(plane, (-3, 1), (-2, 2)), (wide, (-5, 2), (-4, 4))])
def test_points_fill_their_domain(points, p2, p3):
    result = points(3000)
    assert np.mean(result.nu == 0.5) == pytest.approx(1 / 3)
    compressible = result.nu[result.nu < 0.5]
    for values, (low, high) in (
        (compressible, (-0.9, 0.5)), (np.log10(result.p2), p2), (np.log10(result.p3), p3),
    ):  # fmt: skip
        assert low <= values.min() < low + 0.01 * (high - low)
        assert high - 0.01 * (high - low) < values.max() <= high


def test_the_first_points_do_not_depend_on_their_number():
    few = plane(9).first(3)
    assert few.size == 3
    assert np.array_equal(few.nu, plane(9).nu[:3])


def test_copies_repeat_the_given_impact():
    points = plane(5)
    assert points.copies(3, 4).solve(1e-8) == pytest.approx(points.solve(1e-8)[3], rel=1e-12)
    impacts = random_prony(3, 4)
    result = impacts.solve(1e-8)
    assert impacts.size == result.size == 12
    for n in (0, 3, 4, 11):
        assert impacts.copies(n, 2).solve(1e-8) == pytest.approx(result[n], rel=1e-12)


def test_materials_of_random_terms():
    impacts = random_prony(60, 2)
    counts = [impact.material.shear.n_branches for impact in impacts.arrays]
    assert min(counts) == 10
    assert max(counts) == 20
    times = np.concatenate([impact.material.shear.relaxation_times for impact in impacts.arrays])
    assert 1e-5 < times.min() < 1e-4
    assert 1e4 < times.max() < 1e5


@pytest.mark.parametrize("terms", [1, 7])
def test_evenly_spaced_terms_have_one_instantaneous_modulus(terms):
    (impact,) = even_prony(terms, 3).arrays
    shear = impact.material.shear
    assert shear.n_branches == terms
    assert shear.instantaneous_modulus == pytest.approx(11.0, rel=1e-12)
    assert [b / a for a, b in pairwise(shear.relaxation_times)] == pytest.approx([10 ** (10 / 6)] * (terms - 1))


def test_parabolas_on_materials_of_the_plane_have_their_p3():
    for impact in of_profile(Parabola(2.0), 20, 3).arrays:
        groups = dimensionless_groups(impact)
        # The depth L is 0.3 to 3, so that p3 = eta/L may exceed the plane by half a decade.
        assert 1e-3 < groups.p2 < 10.0
        assert np.all((groups.p3 > 10**-2.5) & (groups.p3 < 10**2.5))


def test_masses_follow_from_the_depth_of_a_profile():
    (impact,) = of_profile(Cone(0.7), 1, 50).arrays
    depth = np.cbrt(impact.mass / impact.profile.contact_radius(1.0))
    assert np.all((depth > 10**-0.5) & (depth < 10**0.5))


def test_the_shortest_of_several_calls(monkeypatch):
    ticks = iter([0.0, 5.0, 10.0, 12.0, 20.0, 29.0])
    monkeypatch.setattr(timing, "clock", lambda: next(ticks))
    calls = []
    assert timing.best(lambda: calls.append(1), 3) == 2.0
    assert len(calls) == 3


def test_time_of_one_of_many_copies(monkeypatch):
    now = [0.0]
    monkeypatch.setattr(timing, "clock", lambda: now[0])

    class Slow:
        size = 3

        def __init__(self, cost: float = 0.0) -> None:
            self.cost = cost

        def copies(self, n: int, count: int) -> "Slow":
            return Slow((n + 1.0) * count)

        def solve(self, rtol: float, workers: int = 1) -> np.ndarray:
            now[0] += self.cost
            return np.zeros(1)

    advanced = []
    result = timing.one_by_one(Slow(), [0, 2], 1e-8, copies=8, repeats=2, advance=lambda: advanced.append(1))
    assert result.tolist() == [1.0, 3.0]
    assert len(advanced) == 2


def test_errors_are_measured_against_a_finer_solve():
    exact = np.array([0.5, 1e-5])
    off = np.array([2e-9, 3e-12])

    class Wrong:
        size = 2

        def solve(self, rtol: float, workers: int = 1) -> np.ndarray:
            return exact if rtol <= 1e-11 else exact + off

    _, error, share = timing.in_array_calls(Wrong(), 1e-8, 1)
    assert error == pytest.approx(2e-9)
    # The larger share is that of the small e, relative to 1e-3: 3e-12/1e-11.
    assert share == pytest.approx(0.4)


def test_evenly_spaced_numbers():
    points = plane(11)
    assert timing.evenly(points, 3) == [0, 5, 10]


def test_name_of_the_processor():
    text = "processor\t: 0\ncpu family\t: 25\nmodel\t\t: 17\nmodel name\t: AMD EPYC: one\n\nprocessor\t: 1\n"
    assert machine._from_cpuinfo(text) == "AMD EPYC: one (family 25, model 17)"
    with pytest.raises(KeyError):
        machine._from_cpuinfo("processor\t: 0\n")
    result = machine.describe()
    assert result.processor
    assert set(result.versions) >= {"restitution", "Python", "numba", "numpy", "scipy"}
    assert machine.Machine("x", 1, "y", {"a": "1", "b": "2"}).lines() == ("x, 1 core, y", "a 1, b 2")


def test_progress_and_table_of_a_summary():
    steps = []
    result = summary.measure(summary.Size(60, 4, 1, 1), lambda done, total: steps.append((done, total)))
    done, totals = zip(*steps, strict=True)
    assert len(set(totals)) == 1
    assert done == tuple(sorted(done))
    assert done[-1] == totals[0]
    assert list(result.speeds) == [("paper's plane", 1e-8), ("paper's plane", 1e-9), ("Prony, 20 terms", 1e-8)]
    for (_, rtol), speed in result.speeds.items():
        assert 0.0 < speed.median <= speed.worst
        assert 0.0 < speed.error < rtol
        assert speed.share < 1.0
    assert result.reference_error < 1e-6
    text = summary.table(result._replace(cores=4, parallel=result.speeds["paper's plane", 1e-8].mean / 3.0))
    assert "on 4 cores" in text
    assert "3.00 times as fast" in text
    assert [line.split()[:3] for line in text.splitlines()[1:3]] == [
        ["paper's", "plane", r] for r in ("1e-08", "1e-09")
    ]
    assert "cores" not in summary.table(result._replace(cores=1))


def test_standard_solids_go_through_the_public_call():
    points = StandardSolids(np.array([0.49]), np.array([1e-3]), np.array([10.0]))
    # The example of the paper.
    assert points.solve(1e-9)[0] == pytest.approx(0.219706, abs=5e-7)
    assert points.solve(1e-9)[0] == standard_solid_restitution(0.49, 1e-3, 10.0)


def test_impacts_keep_the_order_of_their_arrays():
    both = Impacts(even_prony(2, 3).arrays + even_prony(5, 4).arrays)
    assert np.array_equal(both.solve(1e-6)[:3], even_prony(2, 3).solve(1e-6))
    assert np.array_equal(both.solve(1e-6)[3:], even_prony(5, 4).solve(1e-6))
