"""Draws with shares of 0 and nearly 1 are finite; the generators draw them once in 2^30 times."""

import numpy as np
import pytest
from scipy.stats import qmc

from restitution.sweeps.samples import LogNormal, Normal, Samples


@pytest.mark.parametrize("share", [0.0, 1.0 - 2.0**-53])
def test_no_draw_is_infinite(share, monkeypatch):
    monkeypatch.setattr(qmc.Sobol, "random", lambda self, n: np.full((n, self.d), share))
    draws = Samples(4, {"mass": LogNormal(1.0, 0.1), "external_force": Normal(10.0, 0.1)}, seed=1).columns(
        "draw", 0, 4
    )
    for values in draws.values():
        assert np.all(np.isfinite(values))
    # The quantile of 2^-31 lies 6.2 standard deviations out.
    assert abs(draws["external_force"][0] - 10.0) == pytest.approx(0.62, abs=0.01)
