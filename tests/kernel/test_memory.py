"""Fading memory of polynomials against closed forms, from very slow to very fast rates."""

import math

import numpy as np
import pytest

from restitution.kernel.memory import (
    TERMS,
    allocate,
    legendre_slopes,
    legendre_values,
    quadrature,
    recall,
    recall_rate,
    remember,
)

pytestmark = pytest.mark.plain


def _plain(function):
    return getattr(function, "py_func", function)


def memory_of(function, edges, rates, begin=0.0):
    """Memory of a function over elements, from its values at their nodes."""
    rule = quadrature()
    lengths = np.diff(edges)
    nodes = edges[:-1, None] + 0.5 * lengths[:, None] * (1.0 + rule.nodes)
    coefficients = function(nodes) @ rule.coefficients.T
    memory = allocate(np.asarray(rates, float), lengths.size)
    memory.begin[0] = begin
    remember(lengths, coefficients, memory, np.empty((2, TERMS + 1)))
    return memory


def value(memory, edges, e, k, t):
    basis = np.empty(TERMS)
    _plain(legendre_values)(2.0 * (t - edges[e]) / (edges[e + 1] - edges[e]) - 1.0, basis)
    return _plain(recall)(memory, e, k, t - edges[e], basis)


def slope(memory, edges, e, k, t):
    values, slopes, length = np.empty(TERMS), np.empty(TERMS), edges[e + 1] - edges[e]
    _plain(legendre_values)(2.0 * (t - edges[e]) / length - 1.0, values)
    _plain(legendre_slopes)(length, values, slopes)
    return _plain(recall_rate)(memory, e, k, t - edges[e], slopes)


def memory_of_power(power, rate, t):
    """int_0^t exp(-r (t - u)) u^n du: a series for small r t, otherwise repeated integration by parts."""
    if rate * t >= 40.0:
        return sum((-1.0) ** j * math.perm(power, j) * t ** (power - j) / rate ** (j + 1) for j in range(power + 1))
    terms = np.arange(400)
    # sum_j (-r)^j t^(n + j + 1) n!/(n + j + 1)! is Kummer's function; Kummer's transformation avoids cancellation.
    logs = np.cumsum(np.log(np.maximum(rate * t, 1e-300) / np.maximum(terms, 1)) * (terms > 0))
    return t ** (power + 1) * math.exp(-rate * t) * np.sum(np.exp(logs) / (power + 1 + terms))


@pytest.mark.parametrize("power", [0, 1, 2, 4])
@pytest.mark.parametrize("rate", [1e-9, 1e-3, 0.5, 1.99, 2.01, 30.0, 1e4, 1e9])
def test_memory_of_a_power(power, rate):
    edges = np.array([0.0, 0.3, 1.0])
    memory = memory_of(lambda t: t**power, edges, [rate])
    for t in (0.1, 0.3, 0.7, 1.0):
        e = 0 if t < 0.3 else 1
        reference = memory_of_power(power, rate, t)
        assert value(memory, edges, e, 0, t) == pytest.approx(reference, rel=2e-12, abs=1e-15 / (1.0 + rate))
        # d/dt int_0^t exp(-r u) (t - u)^n du
        reference = power * memory_of_power(power - 1, rate, t) if power else math.exp(-rate * t)
        assert slope(memory, edges, e, 0, t) == pytest.approx(reference, rel=1e-9, abs=1e-13)


def test_initial_memory_decays_exponentially():
    edges, rates = np.array([0.0, 0.25, 1.0]), [0.2, 5.0, 300.0]
    memory = memory_of(np.zeros_like, edges, rates, begin=[2.0, 3.0, 4.0])
    for k, (rate, begin) in enumerate(zip(rates, (2.0, 3.0, 4.0), strict=True)):
        for e, t in ((0, 0.01), (0, 0.2), (1, 0.4), (1, 1.0)):
            assert value(memory, edges, e, k, t) == pytest.approx(begin * math.exp(-rate * t), rel=1e-12, abs=1e-15)
        assert memory.begin[2, k] == pytest.approx(begin * math.exp(-rate), rel=1e-12, abs=1e-15)


def test_a_jump_enters_the_memory_in_full():
    memory = allocate(np.array([1.0, 1e6]), 2)
    coefficients = np.zeros((2, TERMS))
    coefficients[0, 0] = 0.5
    remember(np.array([0.0, 1.0]), coefficients, memory, np.empty((2, TERMS + 1)))
    assert memory.begin[1] == pytest.approx([0.5, 0.5], rel=1e-15)
    assert memory.begin[2] == pytest.approx([0.5 * math.exp(-1.0), 0.0], rel=1e-12, abs=1e-15)


def test_coefficients_against_numpys_legendre_series():
    rule = quadrature()
    values = np.polynomial.legendre.legval(rule.nodes, [0.3, 0.0, -1.0, 0.2])
    result = rule.coefficients @ values
    assert result == pytest.approx([0.3, 0.0, -1.0, 0.2, *[0.0] * (TERMS - 4)], abs=1e-14)
    basis = np.empty(TERMS)
    _plain(legendre_values)(0.37, basis)
    assert basis == pytest.approx(np.polynomial.legendre.legvander(np.array([0.37]), TERMS - 1)[0], rel=1e-13)
