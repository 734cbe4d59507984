"""The solution by SciPy, to which others are compared, against tables of another program; its tolerance."""

import math

import numpy as np
import pytest

from checkout import DATA, rows
from restitution import Parabola, Status
from restitution.contact.table import path_table
from restitution.contact.table import scaled as scaled_table
from restitution.impact.solution import SampledSolution
from scipy_oracle import scaled, solve_scaled_by_scipy, standard_solid


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


@pytest.mark.parametrize("row", [
    pytest.param(row, id="{nu}-{p2}-{p3}".format(**row), marks=pytest.mark.slow if n % 3 else ())
    for n, row in enumerate(rows(DATA / "standard_solid.csv"))
])  # fmt: skip
def test_tabulated_values(row):
    # The default tolerance gives 1e-11; the table is rounded to 12 digits.
    assert agrees(solve_scaled_by_scipy(standard_solid(row["nu"], row["p2"], row["p3"])), row, 5e-11)


@pytest.mark.slow
def test_whole_shared_table(shared_reference):
    for row in rows(shared_reference / "standard_solid.csv"):
        assert agrees(solve_scaled_by_scipy(standard_solid(row["nu"], row["p2"], row["p3"]), rtol=1e-11), row, 1e-11)


@pytest.mark.parametrize("rtol", [1e-4, 1e-6, 1e-8])
def test_error_stays_within_tolerance(rtol):
    # nu = 0.3, p2 = 0.01, p3 = 3 of the table.
    result = solve_scaled_by_scipy(standard_solid(0.3, 0.01, 3.0), rtol=rtol)
    assert result.restitution_coefficient == pytest.approx(2.22977189502e-01, rel=rtol)


def test_history_is_the_motion():
    result = solve_scaled_by_scipy(standard_solid(0.3, 0.1, 1.0))
    assert np.all(np.diff(result.time) > 0.0)
    assert result.indentation_depth[0] == result.force[0] == result.contact_radius[0] == 0.0
    assert result.indentation_velocity[0] == 1.0
    assert result.indentation_velocity[-1] == -result.restitution_coefficient
    assert result.contact_radius[-1] == pytest.approx(0.0, abs=1e-9)
    # m dv = -F dt and dd = v dt by the trapezoidal rule on the steps of the solver (about 500).
    impulse = np.trapezoid(result.force, result.time)
    assert impulse == pytest.approx(1.0 + result.restitution_coefficient, rel=1e-4)
    assert np.trapezoid(result.indentation_velocity, result.time) == pytest.approx(
        result.indentation_depth[-1], abs=1e-4
    )


def test_radius_from_exponent_table_and_function():
    power = solve_scaled_by_scipy(scaled(1.0, [2.0], [0.5]))
    table = scaled_table(path_table(Parabola(0.02), 3e-4), 1e-4, math.sqrt(2e-6))
    tabulated = scaled(1.0, [2.0], [0.5], exponent=-1.0, table=table)
    unlike = scaled(1.0, [2.0], [0.5], exponent=-1.0)
    for result in (solve_scaled_by_scipy(tabulated), solve_scaled_by_scipy(unlike, stiffness_radius=lambda s: s)):
        assert result.restitution_coefficient == pytest.approx(power.restitution_coefficient, rel=1e-10)
        assert result.contact_time == pytest.approx(power.contact_time, rel=1e-10)


def test_a_heavy_body_is_captured():
    light, heavy = (solve_scaled_by_scipy(scaled(1.5, [3.0], [0.5], external_force=load)) for load in (0.3, 0.5))
    assert light.status is Status.SEPARATED
    assert heavy.status is Status.CAPTURED
    assert heavy.restitution_coefficient == 0.0
    assert heavy.contact_time == np.inf
    assert heavy.indentation_velocity.min() < 0.0


def test_depth_at_rest_in_a_newtonian_liquid():
    # F = c a v, a = sqrt(d): m v0 = c (2/3) d^(3/2).
    result = solve_scaled_by_scipy(scaled(viscosity=1.0))
    assert result.status is Status.SINKS_IN
    assert result.max_indentation_depth == pytest.approx(1.5 ** (2.0 / 3.0), rel=1e-9)
