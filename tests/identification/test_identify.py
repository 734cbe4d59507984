"""Materials identified from rebounds of balls whose material is known."""

from __future__ import annotations

import numpy as np
import pytest
from tests.identification.balls import STANDARD_SOLIDS, rebounds, standard_solid

import restitution as rs

FIXED = {"poisson_ratio": 0.5}


@pytest.mark.parametrize("case", STANDARD_SOLIDS)
def test_exact_data_give_the_material_back(case):
    equilibrium, branch, time = STANDARD_SOLIDS[case]
    found = rs.identify(rebounds(standard_solid(equilibrium, branch, time)), rs.standard_solid, fixed=FIXED)
    truth = {"equilibrium_modulus": equilibrium, "branch_modulus": branch, "viscosity": branch * time}
    for name, value in truth.items():
        assert found.parameters[name].value == pytest.approx(value, rel=1e-5)


@pytest.mark.parametrize("seed", range(4))
@pytest.mark.parametrize("case", STANDARD_SOLIDS)
def test_estimates_from_noisy_data_lie_within_three_standard_errors(case, seed):
    equilibrium, branch, time = STANDARD_SOLIDS[case]
    balls = rebounds(standard_solid(equilibrium, branch, time), seed=seed)
    found = rs.identify(balls, rs.standard_solid, fixed=FIXED)
    truth = np.log([equilibrium, branch, branch * time])
    errors = np.sqrt(np.diag(found.covariance))
    assert np.all(np.abs(found.coordinates - truth) < 3.0 * errors + 1e-9)
