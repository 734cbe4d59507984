"""Reference solution by SciPy against tables of other programs and closed forms; its tolerance."""

import csv
import math
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest

from restitution.contact import path
from restitution.contact.path import path_table
from restitution.contact.profile import Parabola
from restitution.impact.reference import solve_reference
from restitution.impact.solution import SampledSolution
from restitution.impact.status import Status

DATA = Path(__file__).resolve().parents[1] / "data"


def scaled(
    equilibrium: float = 0.0,
    moduli=(),
    times=(),
    *,
    viscosity=0.0,
    external_force=0.0,
    exponent=1.0,
    table=None,
) -> SimpleNamespace:
    return SimpleNamespace(
        equilibrium=equilibrium, moduli=np.array(moduli, float), times=np.array(times, float),
        viscosity=viscosity, external_force=external_force, exponent=exponent, table=table,
    )  # fmt: skip


def standard_solid(nu: float, p2: float, p3: float, **options) -> SimpleNamespace:
    """The paper's material with m = R = v0 = Ginf = 1, as a two-term series of E*."""
    g1, tau = 1.0 / p2, p2 * p3
    if nu == 0.5:
        return scaled(8.0, [8.0 * g1], [tau], **options)
    k = 2.0 * (1.0 + nu) / (3.0 * (1.0 - 2.0 * nu))
    soft, stiff = 3.0 * k + 4.0, 3.0 * k + 4.0 * (1.0 + g1)
    second = 27.0 * k**2 / 4.0 * (1.0 / soft - 1.0 / stiff)
    return scaled(4.0 / (1.0 - nu), [2.0 * g1, 2.0 * second], [tau, tau * stiff / soft], **options)


def rows(path: Path) -> list[dict[str, float]]:
    with path.open() as file:
        return [{key: float(value) for key, value in row.items()} for row in csv.DictReader(file)]


def agrees(solution: SampledSolution, row: dict[str, float], tolerance: float) -> bool:
    assert solution.status is Status.SEPARATED
    assert solution.restitution_coefficient == pytest.approx(row["restitution"], rel=tolerance)
    assert solution.contact_time == pytest.approx(row["contact_time"], rel=tolerance)
    assert solution.max_indentation_depth == pytest.approx(row["max_indentation"], rel=tolerance)
    # The error is that of v times E_k tau_k/E_inf, which is 100 at p3 = 100.
    assert solution.residual_indentation_depth == pytest.approx(
        row["residual_indentation"], abs=1.5e-10 * row["max_indentation"]
    )
    assert solution.max_force == pytest.approx(row["max_force"], rel=max(1e-9, tolerance))
    return True


@pytest.mark.parametrize("row", rows(DATA / "standard_solid.csv"), ids=lambda r: "{nu}-{p2}-{p3}".format(**r))
def test_tabulated_values(row):
    # The default tolerance gives 1e-11; the table is rounded to 12 digits.
    assert agrees(solve_reference(standard_solid(row["nu"], row["p2"], row["p3"])), row, 5e-11)


@pytest.mark.slow
def test_whole_shared_table(shared_reference):
    for row in rows(shared_reference / "standard_solid.csv"):
        assert agrees(solve_reference(standard_solid(row["nu"], row["p2"], row["p3"]), rtol=1e-11), row, 1e-11)


@pytest.mark.parametrize("row", rows(DATA / "finite_element.csv"), ids=lambda r: "{nu}-{p2}-{p3}".format(**r))
def test_finite_elements(row):
    found = solve_reference(standard_solid(row["nu"], row["p2"], row["p3"]), rtol=1e-7)
    assert found.restitution_coefficient == pytest.approx(row["restitution"], abs=row["restitution_error"])
    assert found.contact_time == pytest.approx(row["contact_time"], abs=row["contact_time_error"])
    assert found.max_indentation_depth == pytest.approx(row["max_indentation"], abs=row["max_indentation_error"])
    assert found.max_force == pytest.approx(row["max_force"], abs=row["max_force_error"])


@pytest.mark.parametrize("rtol", [1e-4, 1e-6, 1e-8])
def test_error_stays_within_tolerance(rtol):
    # nu = 0.3, p2 = 0.01, p3 = 3 of the table.
    found = solve_reference(standard_solid(0.3, 0.01, 3.0), rtol=rtol)
    assert found.restitution_coefficient == pytest.approx(2.22977189502e-01, rel=rtol)


def test_history_is_the_motion():
    found = solve_reference(standard_solid(0.3, 0.1, 1.0))
    assert np.all(np.diff(found.time) > 0.0)
    assert found.indentation_depth[0] == found.force[0] == found.contact_radius[0] == 0.0
    assert found.indentation_velocity[0] == 1.0
    assert found.indentation_velocity[-1] == -found.restitution_coefficient
    assert found.contact_radius[-1] == pytest.approx(0.0, abs=1e-9)
    # m dv = -F dt and dd = v dt by the trapezoidal rule on the steps of the solver (about 500).
    impulse = np.trapezoid(found.force, found.time)
    assert impulse == pytest.approx(1.0 + found.restitution_coefficient, rel=1e-4)
    assert np.trapezoid(found.indentation_velocity, found.time) == pytest.approx(found.indentation_depth[-1], abs=1e-4)


def test_splitting_a_branch_changes_nothing():
    whole = solve_reference(scaled(1.0, [3.0], [0.4]))
    split = solve_reference(scaled(1.0, [1.0, 0.0, 2.0], [0.4, 0.1, 0.4]))
    assert split.restitution_coefficient == pytest.approx(whole.restitution_coefficient, rel=1e-10)


def test_fast_branch_is_a_dashpot():
    dashpot = solve_reference(scaled(1.0, [2.0], [0.5], viscosity=0.3))
    branch = solve_reference(scaled(1.0, [2.0, 0.3e8], [0.5, 1e-8]))
    # The deviation of the branch from its limit is tau_k over the contact time.
    assert branch.restitution_coefficient == pytest.approx(dashpot.restitution_coefficient, rel=1e-6)
    assert branch.residual_indentation_depth == pytest.approx(dashpot.residual_indentation_depth, rel=1e-6)


def test_a_vanishing_dashpot_changes_nothing():
    without = solve_reference(scaled(1.0, [2.0], [0.5]))
    tiny = solve_reference(scaled(1.0, [2.0], [0.5], viscosity=1e-13))
    assert tiny.restitution_coefficient == pytest.approx(without.restitution_coefficient, rel=1e-10)


def test_radius_from_exponent_table_and_function():
    power = solve_reference(scaled(1.0, [2.0], [0.5]))
    table = path.scaled(path_table(Parabola(0.02), 3e-4), 1e-4, math.sqrt(2e-6))
    tabulated = scaled(1.0, [2.0], [0.5], exponent=-1.0, table=table)
    given = scaled(1.0, [2.0], [0.5], exponent=-1.0)
    for found in (solve_reference(tabulated), solve_reference(given, stiffness_radius=lambda s: s)):
        assert found.restitution_coefficient == pytest.approx(power.restitution_coefficient, rel=1e-10)
        assert found.contact_time == pytest.approx(power.contact_time, rel=1e-10)


@pytest.mark.parametrize("load", [0.05, 10.0])
def test_weight_on_an_elastic_half_space_leaves_e_at_one(load):
    # Touch and separation have the same depth, so that the weight does no net work.
    found = solve_reference(scaled(1.5, external_force=load))
    assert found.restitution_coefficient == pytest.approx(1.0, rel=1e-9)
    # 1/2 + load d = (2/5) d^(5/2) at the turning point
    d = found.max_indentation_depth
    assert 0.4 * d**2.5 == pytest.approx(0.5 + load * d, rel=1e-9)


def test_a_heavy_body_is_captured():
    light, heavy = (solve_reference(scaled(1.5, [3.0], [0.5], external_force=load)) for load in (0.3, 0.5))
    assert light.status is Status.SEPARATED
    assert heavy.status is Status.CAPTURED
    assert heavy.restitution_coefficient == 0.0
    assert heavy.contact_time == np.inf
    assert heavy.indentation_velocity.min() < 0.0


def test_overdamped_solid_under_weight_is_captured_without_turning():
    # k = load = 1, D = 25: the depth creeps towards load/k and never exceeds it.
    found = solve_reference(scaled(1.0, viscosity=50.0, external_force=1.0, exponent=0.0))
    assert found.status is Status.CAPTURED
    assert found.max_indentation_depth == pytest.approx(1.0, rel=1e-9)


def test_depth_at_rest_in_a_newtonian_liquid():
    # F = c a v, a = sqrt(d): m v0 = c (2/3) d^(3/2).
    found = solve_reference(scaled(viscosity=1.0))
    assert found.status is Status.SINKS_IN
    assert found.max_indentation_depth == pytest.approx(1.5 ** (2.0 / 3.0), rel=1e-9)


@pytest.mark.parametrize(
    ("ratio", "status"), [(0.9, Status.SEPARATED), (0.999, Status.SINKS_IN), (1.2, Status.SINKS_IN)]
)
def test_liquid_turns_only_if_underdamped(ratio, status):
    # Flat punch, k = m = 1, tau = 1/(2 D): an oscillator of damping ratio D. For D = 0.999 it turns with v = 5e-31.
    assert solve_reference(scaled(0.0, [1.0], [0.5 / ratio], exponent=0.0)).status is status


@pytest.mark.parametrize("rtol", [0.0, 1e-13, 0.1, float("nan")])
def test_bad_tolerance(rtol):
    with pytest.raises(ValueError, match=r"^rtol = .*: must be in \[1e-12, 0.01\]$"):
        solve_reference(scaled(1.0), rtol=rtol)
