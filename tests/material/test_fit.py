import math

import numpy as np
import pytest

from restitution.material.fit import fit_prony
from restitution.material.fractional import fractional_zener
from restitution.material.measurement import DynamicTable, RelaxationTable
from restitution.material.prony import PronySeries
from restitution.material.readers import read_material

TRUTH = PronySeries(1.0, [5.0, 2.0, 7.0], [1e-3, 0.4, 50.0])


def relaxation(series, low=1e-5, high=1e4, count=91):
    t = np.geomspace(low, high, count)
    return RelaxationTable(t, series.relaxation_modulus(t))


def dynamic(series, low=1e-4, high=1e5, count=91):
    omega = np.geomspace(low, high, count)
    return DynamicTable(omega, series.storage_modulus(omega), series.loss_modulus(omega))


@pytest.mark.parametrize("table", [relaxation, dynamic])
def test_few_terms_stand_for_a_prony_series(table):
    fit = fit_prony(table(TRUTH))
    # Lines of the spectrum that lie between the times of the grid, six a decade.
    assert fit.misfit <= 3e-3
    assert fit.n_terms <= 12
    assert fit.series.equilibrium_modulus == pytest.approx(1.0, rel=5e-3)
    between = np.geomspace(2e-5, 5e3, 50)
    assert fit.series.relaxation_modulus(between) == pytest.approx(
        TRUTH.relaxation_modulus(between), rel=2e-2
    )


def test_misfit_is_that_of_the_residuals():
    data = dynamic(TRUTH)
    fit = fit_prony(data)
    omega = data.angular_frequency
    measured = data.storage_modulus + 1j * data.loss_modulus
    relative = (fit.series.carson_transform(1j * omega) - measured) / np.abs(measured)
    assert fit.residuals == pytest.approx(relative, abs=1e-12)
    assert fit.misfit == pytest.approx(math.sqrt(np.mean(np.abs(relative) ** 2)), rel=1e-10)
    assert fit.window == pytest.approx((1e-5, 1e4))
    assert fit.data is data


def test_more_misfit_takes_fewer_terms():
    data = relaxation(fractional_zener(1.0, 1e3, 1e-2, 0.4), 1e-6, 1e4)
    counts = [fit_prony(data, misfit=misfit).n_terms for misfit in (1e-3, 1e-2, 5e-2)]
    assert counts[0] > counts[1] > counts[2]
    assert fit_prony(data, misfit=1e-2).misfit <= 1e-2


@pytest.mark.parametrize("table", [relaxation, dynamic])
def test_noise_is_not_fitted(table):
    data = table(TRUTH)
    rng = np.random.default_rng(0)
    noise = 1.0 + 0.03 * rng.standard_normal((2, 91))
    if isinstance(data, RelaxationTable):
        data = RelaxationTable(data.time, data.modulus * noise[0])
    else:
        data = DynamicTable(
            data.angular_frequency, data.storage_modulus * noise[0], data.loss_modulus * noise[1]
        )
    fit = fit_prony(data)
    assert 0.02 < fit.misfit < 0.035
    assert fit.n_terms <= 20
    t = np.geomspace(1e-5, 1e4, 50)
    assert fit.series.relaxation_modulus(t) == pytest.approx(TRUTH.relaxation_modulus(t), rel=0.06)


def test_liquid_has_no_equilibrium_modulus():
    liquid = PronySeries(0.0, [5.0, 2.0], [1e-3, 0.4])
    omega = np.geomspace(1e-3, 1e5, 61)
    data = DynamicTable(omega, liquid.storage_modulus(omega), liquid.loss_modulus(omega))
    fit = fit_prony(data, liquid=True)
    assert fit.series.is_liquid
    assert fit.misfit < 6e-3


def test_time_zero_counts_but_does_not_stretch_the_window():
    t = np.array([0.0, *np.geomspace(1e-3, 1e3, 61)])
    fit = fit_prony(RelaxationTable(t, PronySeries(1.0, [4.0], [1.0]).relaxation_modulus(t)))
    assert fit.window == (1e-3, 1e3)
    assert fit.series.instantaneous_modulus == pytest.approx(5.0, rel=1e-2)


@pytest.mark.parametrize(
    ("data", "message"),
    [
        (
            RelaxationTable(np.array([1.0, 10.0, 100.0]), np.ones(3), source="a.csv"),
            "^a.csv: number of times = 3, up to 100 s: must be >= 4, over half a decade or more$",
        ),
        (
            RelaxationTable(np.array([1.0, 1.1, 1.2, 1.3]), np.ones(4)),
            "^number of times = 4, up to 1.3 s: must .* half a decade",
        ),
        (
            DynamicTable(np.array([2.0]), np.ones(1), np.ones(1)),
            "^number of frequencies = 1, up to 2 rad/s: must",
        ),
    ],
)
def test_too_few_data(data, message):
    with pytest.raises(ValueError, match=message):
        fit_prony(data)


def test_data_that_do_not_relax_are_told_of():
    t = np.geomspace(1.0, 100.0, 9)
    with pytest.warns(UserWarning, match="^a.csv: no relaxation is seen in the data") as told:
        fit = fit_prony(RelaxationTable(t, np.linspace(2.0, 2.1, 9), source="a.csv"))
    assert (fit.n_terms, len(told)) == (0, 1)


def test_a_poor_fit_is_told_of():
    """Loss and storage modulus that contradict each other: the loss of no material is flat at a fifth of E'."""
    omega = np.geomspace(1.0, 1e4, 21)
    with pytest.warns(UserWarning, match=r"^data: relative misfit 0\.\d+ of the fit: above 0\.1") as told:
        fit = fit_prony(DynamicTable(omega, np.full(21, 5.0), np.full(21, 4.0)))
    assert fit.misfit > 0.1
    assert f"misfit {fit.misfit:.3g} of" in str(told[0].message)


@pytest.mark.parametrize("table", [relaxation, dynamic])
def test_the_picture_of_a_fit_shows_its_data_and_its_curve(table):
    data = table(TRUTH)
    fit = fit_prony(data)
    time, frequency = fit.plot().axes
    ax = frequency if isinstance(data, DynamicTable) else time
    dots = next(line for line in ax.lines if line.get_linestyle() == "None")
    assert dots.get_xdata().size == 91
    curve = next(line for line in time.lines if line.get_label() == "fit")
    assert curve.get_xdata()[[0, -1]] == pytest.approx(fit.window)
    assert curve.get_ydata()[0] == pytest.approx(fit.series.relaxation_modulus(fit.window[0]), rel=1e-12)


def rms(values):
    return float(np.sqrt(np.mean(np.abs(values) ** 2)))


def test_measured_dma_polymer_no_worse_than_the_other_fit(shared_reference):
    """The deck holds another program's 27 terms for these data, relative to the highest storage modulus."""
    folder = shared_reference / "materials"
    data = read_material(folder / "polymer_dma_master_curve.csv")
    other = read_material(folder / "polymer_ansys_prony.MPL").shear.series(
        instantaneous_modulus=data.storage_modulus.max()
    )
    fit = fit_prony(data)
    omega = data.angular_frequency
    measured = data.storage_modulus + 1j * data.loss_modulus
    mine, theirs = fit.series.carson_transform(1j * omega), other.carson_transform(1j * omega)
    assert rms((mine - measured) / np.abs(measured)) <= rms((theirs - measured) / np.abs(measured))
    assert rms(mine.real / measured.real - 1) <= rms(theirs.real / measured.real - 1)
    assert rms(mine.imag / measured.imag - 1) <= rms(theirs.imag / measured.imag - 1)
    assert fit.n_terms <= 35


def test_measured_relaxation_polymer_no_worse_than_the_other_fit(shared_reference):
    """Another program's 31 terms of the same data."""
    folder = shared_reference / "materials"
    data = read_material(folder / "polymer_relaxation_master_curve.csv")
    other = read_material(folder / "polymer_relaxation_prony.csv").series()
    fit = fit_prony(data)
    theirs = rms(other.relaxation_modulus(data.time) / data.modulus - 1)
    assert theirs == pytest.approx(2.54e-3, rel=0.01)
    assert fit.misfit <= theirs
    assert fit.misfit == pytest.approx(
        rms(fit.series.relaxation_modulus(data.time) / data.modulus - 1), rel=1e-9
    )
    assert fit.n_terms <= 40
