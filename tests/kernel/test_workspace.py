"""Scratch space of the kernel."""

import numpy as np
import pytest

import restitution as rs
from restitution.kernel import workspace


@pytest.mark.parametrize("options", [{}, {"external_force": 0.05}, {"impedance": 5.0}], ids=str)
@pytest.mark.parametrize("profile", [rs.Parabola(0.01), rs.Cone(1.0), rs.TruncatedCone(0.002, 1.2)], ids=str)
@pytest.mark.parametrize("viscosity", [0.0, 10.0])
def test_stored_elements_need_no_zeros(monkeypatch, profile, options, viscosity):
    series = rs.PronySeries(1e6, [1e7, 1e6, 1e5], [1e-4, 1e-2, 1.0], parallel_viscosity=viscosity)
    impact = rs.Impact(rs.Material(series, 1e8), profile, mass=0.005, velocity=1.0, **options)
    expected = rs.solve(impact)

    def allocate(modes: int, elements: int) -> workspace.Work:
        work = allocated(modes, elements)
        for name in ("approach", "rebound", "slopes"):
            getattr(work, name)[:] = np.nan
        return work

    allocated = workspace.allocate
    monkeypatch.setattr(workspace, "allocate", allocate)
    result = rs.solve(impact)
    assert result.to_dict() == expected.to_dict()
    np.testing.assert_array_equal(result.sample(n_points=50).force, expected.sample(n_points=50).force)
