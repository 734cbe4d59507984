import numpy as np
import pytest

from restitution.kernel.dense import invert, lagrange
from restitution.kernel.path import power_path, radius_and_integral, radius_slope
from restitution.kernel.radau import radau


def _plain(function):
    """The Python function of a compiled piece, which has no wrapper of its own."""
    return getattr(function, "py_func", function)


@pytest.mark.plain
@pytest.mark.parametrize("z", [1e-12, 0.3, 7.0, 1e9])
def test_inverse_of_a_mode_matrix(z):
    scheme = radau(6)
    M = np.eye(6) + z * scheme.A * np.linspace(0.2, 1.0, 6)
    inverse = M.copy()
    _plain(invert)(inverse, np.zeros(7), scheme.size)
    assert inverse @ M == pytest.approx(np.eye(6), abs=1e-9)


@pytest.mark.plain
def test_lagrange_basis_reproduces_polynomials_and_its_nodes():
    scheme, basis = radau(6), np.zeros(7)
    for x in (0.123, 1.7, -0.4):
        _plain(lagrange)(scheme.c, scheme.weights, 7, x, basis)
        assert basis @ scheme.c**6 == pytest.approx(x**6, rel=1e-12)
    _plain(lagrange)(scheme.c, scheme.weights, 7, float(scheme.c[2]), basis)
    assert basis == pytest.approx(np.eye(7)[2], abs=1e-14)


@pytest.mark.parametrize("exponent", [0.0, 0.5, 1.0, 2.0])
def test_power_path(exponent):
    # Pi = int_0^s a 2 s ds = 2 s^(p + 2)/(p + 2)
    path, s = power_path(exponent), 0.7
    a, integral = _plain(radius_and_integral)(path, s)
    assert a == pytest.approx(s**exponent, rel=1e-15)
    assert integral == pytest.approx(2.0 * s ** (exponent + 2.0) / (exponent + 2.0), rel=1e-14)
    assert _plain(radius_slope)(path, s, a) == pytest.approx(exponent * s ** (exponent - 1.0), rel=1e-14)
