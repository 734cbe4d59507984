"""Pictures of relaxation functions and shift factors."""

from dataclasses import replace

import numpy as np
import pytest

from refusals import warns
from restitution import DynamicTable, Isotherms, PronySeries, RelaxationTable, ShiftTable
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


def isotherms(kind):
    series, omega = PronySeries(1e6, [1e7, 1e8], [1.0, 0.01]), np.geomspace(0.1, 100.0, 13)
    tables = []
    for kelvin, factor in ((290.0, 10.0), (300.0, 1.0), (310.0, 0.2)):
        if kind is DynamicTable:
            moduli = series.storage_modulus(omega * factor), series.loss_modulus(omega * factor)
            tables.append(DynamicTable(omega, *moduli, temperature=kelvin))
        else:
            time = 1.0 / omega[::-1]
            tables.append(RelaxationTable(time, series.relaxation_modulus(time / factor), temperature=kelvin))
    return Isotherms(tables)


@pytest.mark.parametrize("kind", [DynamicTable, RelaxationTable])
def test_isotherms_and_their_superposition(kind):
    measured = isotherms(kind)
    (ax,) = measured.plot().axes
    dynamic = kind is DynamicTable
    assert len(ax.lines) == (6 if dynamic else 3)
    assert [text.get_text() for text in ax.get_legend().get_texts()] == ["16.85 °C", "36.85 °C"]
    curve = measured.superposed(reference_temperature=300.0, shift="wlf", vertical=True)
    left, middle, right = curve.plot().axes
    name = "angular_frequency" if dynamic else "time"
    np.testing.assert_array_equal(left.lines[0].get_xdata(), getattr(measured.tables[0], name))
    np.testing.assert_array_equal(middle.lines[0].get_xdata(), getattr(curve.reduced[0], name))
    np.testing.assert_allclose(right.containers[0].lines[0].get_ydata(), curve.log10_factors)
    assert {text.get_text() for text in right.get_legend().get_texts()} == {"shift", "vertical"}
    words = ("modulus [MPa]", "(crosses) [MPa]")[dynamic]
    assert left.get_ylabel().endswith(words)


def test_shifts_that_are_not_determined_are_marked():
    tables = isotherms(DynamicTable).tables
    moduli = {name: 1e3 * getattr(tables[0], name) for name in ("storage_modulus", "loss_modulus")}
    with warns("superposition"):
        curve = Isotherms([replace(tables[0], **moduli, temperature=250.0), *tables[1:]]).superposed()
    assert "not determined" in [text.get_text() for text in curve.plot().axes[2].get_legend().get_texts()]


def test_shares_are_named_once() -> None:
    """The axis names shares of the instantaneous modulus; a legend would repeat it."""
    series = {"relative to the instantaneous modulus": PronySeries(0.1, [0.9], [1.0])}
    left, right = overview(series, unit="").axes
    assert left.get_legend() is None
    assert [text.get_text() for text in right.get_legend().get_texts()] == ["storage", "loss"]
    assert left.get_ylabel() == "relaxation modulus over the instantaneous one"


def test_an_axis_within_a_decade_has_plain_numbers() -> None:
    left, _ = overview({"shear": PronySeries(2e5, [5e5], [1.0])}).axes
    left.figure.canvas.draw()
    low, high = left.get_ylim()
    ticks = [tick.label1.get_text() for tick in left.yaxis.get_major_ticks() if low <= tick.get_loc() <= high]
    minor = [text.get_text() for text in left.yaxis.get_minorticklabels()]
    assert ticks == ["200", "300", "400", "600"]
    assert not any(minor)
