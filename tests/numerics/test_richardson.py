"""Richardson's extrapolation: series of known order, and errors that cover."""

import numpy as np

from restitution.numerics.richardson import Richardson


def test_errors_of_fourth_order_remain_and_are_covered():
    rng = np.random.default_rng(5)
    limits, second, fourth = rng.normal(size=(3, 40))
    series = Richardson()
    counts = int(rng.integers(3, 20)) * 2.0 ** np.arange(6)
    reached = []
    for level, count in enumerate(counts):
        values, errors = series.add(limits + second / count**2 + fourth / count**4)
        assert np.all(np.isinf(errors)) if level < 2 else np.all(abs(values - limits) <= errors + 1e-13)
        reached.append(abs(values - limits).max())
    # The extrapolation removes the second order: each doubling divides by 16 what is left.
    assert reached[2] < reached[1] / 15.0
    assert reached[3] < reached[2] / 15.0


def test_a_change_that_is_small_by_chance_is_not_trusted():
    # Values whose extrapolations are 1, 2, 2: the last change is zero, the one before is not.
    series = Richardson()
    for value in (1.0, 1.0, 1.75, 1.9375):
        _, error = series.add(value)
    assert error > 0.1
