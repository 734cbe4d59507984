"""Richardson's extrapolation: series of known order, and errors that cover."""

import numpy as np

from restitution.numerics.richardson import Extrapolation, Richardson


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


def test_terms_of_three_orders_are_taken_away():
    """From counts that do not double: with errors of second to fourth order nothing is left."""
    rng = np.random.default_rng(6)
    limits, *terms = rng.normal(size=(4, 40))
    series = Extrapolation()
    for level, count in enumerate((24, 48, 96, 192, 256, 384)):
        values, errors = series.add(count, limits + sum(term / count**k for k, term in enumerate(terms, 2)))
        # An error needs two changes of numbers from two counts.
        assert np.all(np.isinf(errors)) == (level < 3)
    assert np.abs(values - limits).max() < 1e-12
    assert errors[0] < 1e-10


def test_errors_that_jump_are_covered():
    """A jump of second order, of random size at each count, spoils higher orders; the stated error covers it."""
    rng = np.random.default_rng(7)
    covered = 0
    for _ in range(200):
        series = Extrapolation()
        for count in (24, 48, 96, 192, 384):
            value, error = series.add(count, [1.0 + 2.0 / count**2 + rng.uniform(-1.0, 1.0) / count**2])
        covered += abs(value[0] - 1.0) <= error[0]
    assert covered >= 190
