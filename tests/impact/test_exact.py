"""Arrays of impacts by the exact method: broadcasting, workers, failures, interrupts."""

import os
import signal
import subprocess
import sys
import time
import warnings
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

from refusals import warns
from restitution import Ellipsoid, Impact, Layer, Material, PronySeries, Tabulated, parallel, standard_solid, sweep
from restitution.contact.profiles import Cone, FlatPunch, Parabola, Sphere
from restitution.errors import RestitutionWarning
from restitution.impact import solution
from restitution.impact.batch import Batch
from restitution.impact.problem import dimensionless_groups
from restitution.impact.result import BUDGET
from restitution.impact.solve import solve, standard_solid_restitution
from restitution.impact.status import SolverError, Status

# Many of these bodies exceed the limits of the theory.
pytestmark = pytest.mark.filterwarnings(r"ignore:.*; exceeded in \d+ of")

RUBBER = standard_solid(1e6, 1e7, 1e4, poisson_ratio=0.45)
LAYERED = Material(PronySeries(1e6, [4e6, 2e6, 1e6], [1e-5, 1e-3, 1e-1]), 2e8)
FIELDS = (
    "restitution_coefficient", "contact_time", "max_indentation_depth", "max_force", "max_contact_radius",
    "residual_indentation_depth", "rebound_velocity", "status",
)  # fmt: skip


def balls(n: int, material: Material = RUBBER, **changes: Any) -> Impact:
    rng = np.random.default_rng(n)
    options = {"mass": 0.03, "velocity": 10.0 ** rng.uniform(-3, 1, n)} | changes
    return Impact(material, Parabola(radius=0.01), **options)


# A single impact and an impact of an array take the same path through the kernel: the results are identical.
@pytest.mark.parametrize("material", [RUBBER, LAYERED])
@pytest.mark.parametrize(
    ("profile", "field", "unit"), [(Parabola, "radius", 0.01), (FlatPunch, "radius", 0.002), (Cone, "half_angle", 1.2)]
)
def test_an_array_equals_single_impacts(material: Material, profile: Any, field: str, unit: float) -> None:
    sizes = unit * np.array([0.8, 1.1])
    masses, velocities, forces = np.array([0.02, 0.05, 0.1]), np.array([[0.1], [1.0]]), 0.02
    whole = solve(
        Impact(
            material, profile(**{field: sizes[:, None, None]}), masses, velocities[None, :, :], external_force=forces
        )
    )
    assert whole.restitution_coefficient.shape == (2, 2, 3)
    for i, j, k in np.ndindex(2, 2, 3):
        item = solve(
            Impact(material, profile(**{field: sizes[i]}), masses[k], velocities[j, 0], external_force=forces)
        )
        for name in FIELDS:
            assert np.asarray(getattr(whole, name))[i, j, k] == getattr(item, name), name
        assert whole.energy.dissipated[i, j, k] == item.energy.dissipated


def test_shapes_that_do_not_broadcast_are_refused() -> None:
    with pytest.raises(ValueError, match=r"^nu, p2, p3: have shapes that do not broadcast against each other"):
        standard_solid_restitution([0.1, 0.2], 1.0, [1.0, 2.0, 3.0])


def test_the_three_groups_broadcast() -> None:
    nu, p2, p3 = np.array([-0.5, 0.3, 0.5]), np.array([[0.01], [1.0]]), 2.0
    e = standard_solid_restitution(nu, p2, p3)
    assert e.shape == (2, 3)
    for i, j in np.ndindex(2, 3):
        assert e[i, j] == standard_solid_restitution(nu[j], p2[i, 0], p3)
    groups = dimensionless_groups(balls(4))
    assert np.shape(groups.p3) == (4,)


def test_a_point_does_not_depend_on_its_neighbours() -> None:
    """The bits of e depend neither on the other points of an array nor on their number."""
    rng = np.random.default_rng()
    nu = rng.choice([0.5, -1.0, 0.3, -0.2, 0.499], 60)
    p2, p3 = 10.0 ** rng.uniform(-3, 1, 60), 10.0 ** rng.uniform(-2, 2, 60)
    alone = np.array([standard_solid_restitution(*point) for point in zip(nu, p2, p3, strict=True)])
    for _ in range(20):
        places = rng.permutation(60)[: rng.integers(1, 20)]
        e = standard_solid_restitution(nu[places], p2[places], p3[places])
        assert [x.hex() for x in e] == [x.hex() for x in alone[places]]


def test_empty_arrays() -> None:
    assert solve(balls(3, velocity=np.empty(0))).restitution_coefficient.shape == (0,)
    assert standard_solid_restitution(np.empty((2, 0)), 1.0, 1.0).shape == (2, 0)
    for profile in (Sphere(0.01), Layer(Parabola(0.01), 0.002), Layer(Sphere(0.01), 0.002), Ellipsoid(0.01, 0.02)):
        result = solve(Impact(RUBBER, profile, mass=0.005, velocity=np.empty((2, 0))))
        assert result.restitution_coefficient.shape == result.energy.residual.shape == (2, 0)
        assert np.shape(result.max_pressure) == (2, 0)
        assert result.warnings == []


@pytest.mark.parametrize("material", [RUBBER, LAYERED])
def test_results_do_not_depend_on_the_number_of_workers(material: Material) -> None:
    impact = balls(2 * solution._CHUNK + 7, material)
    first = solve(impact, workers=1)
    for workers in (2, 3, 8):
        other = solve(impact, workers=workers)
        for name in FIELDS:
            np.testing.assert_array_equal(getattr(other, name), getattr(first, name))
        np.testing.assert_array_equal(other.energy.residual, first.energy.residual)


@pytest.mark.parametrize("workers", [1, 2])
def test_progress_counts_up_to_all(workers: int, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(solution, "_CHUNK", 16)
    seen: list[tuple[int, int]] = []
    solve(balls(100), workers=workers, progress=lambda done, total: seen.append((done, total)))
    counts = [done for done, _ in seen]
    assert len(counts) > 1
    assert counts == sorted(counts)
    assert seen[-1] == (100, 100)


@pytest.mark.parametrize(
    "work", [lambda: solve(balls(solution._CHUNK + 1)), lambda: sweep(balls(2).take(np.array(0)), {"velocity": [1.0]})]
)
def test_all_cores_are_used_by_default(work: Callable[[], Any], monkeypatch: pytest.MonkeyPatch) -> None:
    asked: list[int] = []
    pool = parallel.ThreadPoolExecutor

    def watched(workers: int) -> Any:
        asked.append(workers)
        return pool(workers)

    monkeypatch.setattr(parallel, "ThreadPoolExecutor", watched)
    monkeypatch.setattr(os, "cpu_count", lambda: 3)
    work()
    assert asked == [3]


def test_a_failed_row_is_nan_and_counted_and_affects_no_other() -> None:
    velocities = np.array(balls(5).velocity)
    # The square overflows.
    velocities[3] = 1e200
    with pytest.warns(RestitutionWarning, match=r"^1 of 5 impacts failed and are NaN: 1 [A-Z_]+$"):
        result = solve(balls(5, velocity=velocities))
    assert np.array_equal(np.isnan(result.restitution_coefficient), [False, False, False, True, False])
    assert Status(int(np.asarray(result.status)[3])).failed
    with warnings.catch_warnings():
        warnings.filterwarnings("error", "impacts failed")
        healthy = solve(balls(5))
    np.testing.assert_array_equal(
        np.delete(result.restitution_coefficient, 3), np.delete(healthy.restitution_coefficient, 3)
    )
    with pytest.raises(SolverError, match=r"\(impact 3 of 5\)$") as caught:
        solve(balls(5, velocity=velocities), errors="raise")
    assert caught.value.status.failed


def test_an_indentation_beyond_the_table_fails_alone() -> None:
    radius = np.linspace(0.0, 0.002, 50)
    tip = Tabulated(radius, radius**2 / 0.02)
    velocities = [0.01, 5.0, 0.1]
    with warns("failed"):
        result = solve(Impact(RUBBER, tip, 0.005, velocities))
    with warns("failed"):
        listed = solve([Impact(RUBBER, tip, 0.005, v) for v in velocities])
    for many in (result, listed):
        assert np.array_equal(many.status, [Status.SEPARATED, Status.TOO_DEEP, Status.SEPARATED])
        assert np.array_equal(np.isnan(many.max_force), [False, True, False])
    with pytest.raises(
        ValueError, match=r"^profile: .* depth of 0\.0004 m, where the profile ends, and the body goes d"
    ):
        solve(Impact(RUBBER, tip, 0.005, 5.0))


def test_an_impact_far_beyond_the_table_fails_alone() -> None:
    tip = Tabulated(np.array([0.0, 1e-3, 2e-3]), np.array([0.0, 50e-6, 200e-6]))
    with warns("failed"):
        result = solve(Impact(RUBBER, tip, 0.005, [0.01, 20.0]))
    assert np.array_equal(result.status, [Status.SEPARATED, Status.TOO_DEEP])


def test_columns_of_materials_equal_the_impacts() -> None:
    impact = balls(6, LAYERED, external_force=0.1)
    series, item = impact.reduced_modulus, np.ones(6)
    batch = Batch(
        series.equilibrium_modulus * item, 0.0 * item, np.tile(series.branch_moduli, (6, 1)),
        np.tile(series.relaxation_times, (6, 1)), 0.03 * item, np.asarray(impact.velocity), 0.1 * item,
        0.1 * item, 1.0,
    )  # fmt: skip
    columns, result = batch.solve(1e-9, energy=True), solve(impact)
    for name in FIELDS:
        np.testing.assert_array_equal(columns[name], getattr(result, name))
    for name, values in zip(BUDGET, result.energy, strict=True):
        np.testing.assert_array_equal(columns[name], values)


@pytest.mark.slow
@pytest.mark.parametrize("workers", [1, 2])
def test_ctrl_c_ends_a_long_call_at_once(workers: int) -> None:
    script = (
        "import signal, sys, time\n"
        # A shell that runs the tests in the background makes its children ignore the signal.
        "signal.signal(signal.SIGINT, signal.default_int_handler)\n"
        "import numpy as np\n"
        "from restitution.impact.solve import standard_solid_restitution as e\n"
        "e(0.3, 0.1, 1.0)\n"
        "start = time.monotonic()\n"
        f"e(0.3, 0.1, np.logspace(-2, 2, 30_000), workers={workers})\n"
        "print(time.monotonic() - start, flush=True)\n"
        "try:\n"
        f"    e(0.3, 0.1, np.logspace(-2, 2, 6_000_000), workers={workers})\n"
        "except KeyboardInterrupt:\n"
        "    sys.exit(130)\n"
    )
    with subprocess.Popen([sys.executable, "-c", script], stdout=subprocess.PIPE) as process:
        assert process.stdout is not None
        whole = 200.0 * float(process.stdout.readline())
        time.sleep(0.1 * whole)
        assert process.poll() is None
        start = time.monotonic()
        process.send_signal(signal.SIGINT)
        assert process.wait() == 130
    # A call that does not listen ends when all is computed.
    assert time.monotonic() - start < 0.4 * whole
