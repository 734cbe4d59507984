"""Draws for shares of 0 and almost 1, which the generators produce once in 2^30 draws, are finite."""

import numpy as np
import pytest
from scipy.stats import qmc

from restitution.sweeps.axes import LogNormal, Normal, Samples


@pytest.mark.parametrize("share", [0.0, 1.0 - 2.0**-53])
def test_no_draw_is_infinite(share, monkeypatch):
    monkeypatch.setattr(qmc.Sobol, "random", lambda self, n: np.full((n, self.d), share))
    draws = Samples(4, {"mass": LogNormal(1.0, 0.1), "external_force": Normal(10.0, 0.1)}, seed=1).columns(
        "draw", 0, 4
    )
    for values in draws.values():
        assert np.all(np.isfinite(values))
    # The quantile of 2^-31 is 6.2 standard deviations from the mean.
    assert abs(draws["external_force"][0] - 10.0) == pytest.approx(0.62, abs=0.01)
