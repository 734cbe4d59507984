"""Named tuples that compiled functions pass by reference have the numbers of the tuples in Python."""

from typing import Any, NamedTuple

import numpy as np
import pytest

from restitution.kernel.compile import compiled, entry_point
from restitution.kernel.references import by_reference


@by_reference
class Inner(NamedTuple):
    rises: bool
    matrix: Any
    times: int


@by_reference
class Outer(NamedTuple):
    vector: Any
    inner: Inner
    whole: Any
    factor: float


@compiled
def weighed(inner: Inner, n: int) -> float:
    return inner.matrix[n, 1] * inner.times if inner.rises else -1.0


@compiled
def chosen(outer: Outer, other: Inner, n: int) -> Inner:
    return outer.inner if n % 2 == 0 else other


@entry_point
def total(outer: Outer, other: Inner) -> float:
    result = 0.0
    for n in range(outer.vector.shape[0]):
        result += outer.factor * outer.vector[n] * weighed(chosen(outer, other, n), n) + outer.whole[n]
    outer.vector[0] = result
    return result


@entry_point
def total_of_new(outer: Outer) -> float:
    inner = Inner(True, outer.inner.matrix, 5)
    return weighed(inner, 1)


def tuples(rng, order):
    def inner():
        return Inner(bool(rng.integers(2)), np.array(rng.normal(size=(6, 4)), order=order), int(rng.integers(1, 9)))

    return Outer(rng.normal(size=12)[::2], inner(), rng.integers(0, 99, 6), float(rng.normal())), inner()


@pytest.mark.parametrize("order", ["C", "F"])
def test_members_of_all_kinds_are_those_of_the_tuple(order):
    for _ in range(8):
        outer, other = tuples(np.random.default_rng(), order)
        inners = [outer.inner if n % 2 == 0 else other for n in range(6)]
        values = [part.matrix[n, 1] * part.times if part.rises else -1.0 for n, part in enumerate(inners)]
        expected = float(outer.factor * outer.vector @ np.array(values) + outer.whole.sum())
        assert total(outer, other) == pytest.approx(expected, rel=1e-12, abs=1e-12)
        # The arrays are those of the caller.
        assert outer.vector[0] == pytest.approx(expected, rel=1e-12, abs=1e-12)


def test_a_tuple_that_a_compiled_function_makes_goes_through_the_same_functions():
    outer, _ = tuples(np.random.default_rng(), "C")
    assert total_of_new(outer) == pytest.approx(5.0 * outer.inner.matrix[1, 1], rel=1e-15)
