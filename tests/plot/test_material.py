"""Pictures of relaxation functions and shift factors."""

import numpy as np

from restitution.material.fit import DynamicTable, RelaxationTable
from restitution.material.prony import PronySeries
from restitution.material.shift import ShiftTable
from restitution.plot.material import overview, shift_factors

SERIES = PronySeries(1e6, [3e6], [1.0])


def test_curves_are_the_moduli_in_the_unit_of_the_label() -> None:
    left, right = overview({"shear": SERIES}, (1e-2, 1e2)).axes
    assert left.get_ylabel() == "relaxation modulus [MPa]"
    x, y = left.lines[0].get_data()
    # G(t) = 1 + 3 exp(-t) MPa
    np.testing.assert_allclose(y, 1.0 + 3.0 * np.exp(-np.asarray(x)), rtol=1e-12)
    omega, storage = right.lines[0].get_data()
    _, loss = right.lines[1].get_data()
    w = np.asarray(omega)
    np.testing.assert_allclose(storage, 1.0 + 3.0 * w**2 / (1.0 + w**2), rtol=1e-12)
    np.testing.assert_allclose(loss, 3.0 * w / (1.0 + w**2), rtol=1e-12)
    assert (w.min(), w.max()) == (np.float64(1e-2), np.float64(1e2))


def test_data_are_drawn_beside_the_curves() -> None:
    t = np.array([0.1, 1.0, 10.0])
    table = RelaxationTable(t, np.array([3e6, 2e6, 1e6]))
    left, _ = overview({"fit": SERIES}, (0.1, 10.0), table).axes
    np.testing.assert_allclose(left.lines[0].get_ydata(), [3.0, 2.0, 1.0])
    dynamic = DynamicTable(t, np.array([1e6, 2e6, 3e6]), np.array([0.5e6, 1e6, 0.5e6]))
    _, right = overview({"fit": SERIES}, (0.1, 10.0), dynamic).axes
    np.testing.assert_allclose(right.lines[0].get_ydata(), [1.0, 2.0, 3.0])
    np.testing.assert_allclose(right.lines[1].get_ydata(), [0.5, 1.0, 0.5])


def test_shift_factors_over_the_temperature_in_celsius() -> None:
    (ax,) = shift_factors(ShiftTable([273.15, 293.15], [1.0, 0.0])).axes
    np.testing.assert_allclose(ax.lines[0].get_xdata(), [0.0, 20.0], atol=1e-12)
    np.testing.assert_allclose(ax.lines[0].get_ydata(), [1.0, 0.0])
