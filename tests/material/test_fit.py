import math
import pickle
import warnings
from functools import partial

import numpy as np
import pytest

from refusals import in_one_line, named
from restitution import Impact, Material, Parabola, PronySeries, fractional_zener, read_material, solve
from restitution.errors import InputError, RestitutionWarning
from restitution.material.conversion import shear_from_tension
from restitution.material.fit import CreepTable, DynamicTable, RelaxationTable, fit_prony

TRUTH = PronySeries(1.0, [5.0, 2.0, 7.0], [1e-3, 0.4, 50.0])


def relaxation(series, low=1e-5, high=1e4, count=91):
    t = np.geomspace(low, high, count)
    return RelaxationTable(t, series.relaxation_modulus(t))


def dynamic(series, low=1e-4, high=1e5, count=91):
    omega = np.geomspace(low, high, count)
    return DynamicTable(omega, series.storage_modulus(omega), series.loss_modulus(omega))


@pytest.mark.parametrize("table", [relaxation, dynamic])
def test_few_terms_approximate_a_prony_series(table):
    fit = fit_prony(table(TRUTH))
    # The relaxation times lie between those of the grid, six per decade.
    assert fit.misfit <= 3e-3
    assert fit.n_terms <= 12
    assert fit.series.equilibrium_modulus == pytest.approx(1.0, rel=5e-3)
    between = np.geomspace(2e-5, 5e3, 50)
    assert fit.series.relaxation_modulus(between) == pytest.approx(TRUTH.relaxation_modulus(between), rel=2e-2)


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
        data = DynamicTable(data.angular_frequency, data.storage_modulus * noise[0], data.loss_modulus * noise[1])
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


def test_time_zero_counts_but_does_not_extend_the_window():
    t = np.array([0.0, *np.geomspace(1e-3, 1e3, 61)])
    fit = fit_prony(RelaxationTable(t, PronySeries(1.0, [4.0], [1.0]).relaxation_modulus(t)))
    assert fit.window == (1e-3, 1e3)
    assert fit.series.instantaneous_modulus == pytest.approx(5.0, rel=1e-2)


@pytest.mark.parametrize(
    ("data", "field"),
    [
        (RelaxationTable(np.array([1.0, 10.0, 100.0]), np.ones(3), source="a.csv"), "times"),
        (RelaxationTable(np.array([1.0, 1.1, 1.2, 1.3]), np.ones(4)), "times"),
        (RelaxationTable(np.array([1e-3, 1e-2, 1.0, 1e308]), np.array([10.0, 5.0, 2.0, 2.0])), "times"),
        (DynamicTable(np.array([2.0]), np.ones(1), np.ones(1)), "frequencies"),
        (None, "data"),
        (([1, 2], [3, 4]), "data"),
    ],
)
def test_data_that_cannot_be_fitted(data, field):
    caught = in_one_line(lambda: fit_prony(data))
    assert caught.field == field
    assert caught.where == getattr(data, "source", "")


def measured_epdm(seed):
    """Synthetic DMA data of ten branches from 1e-7 to 100 s, 0.01 to 100 Hz, noise of 1 % and 2 %."""
    times = np.geomspace(1e-7, 100.0, 10)
    truth = PronySeries(3e6, 2e9 * (times / 1e-7) ** -0.35, times)
    omega = 2.0 * np.pi * np.geomspace(0.01, 100.0, 41)
    noise = 1.0 + np.array([[0.01], [0.02]]) * np.random.default_rng(seed).standard_normal((2, 41))
    storage, loss = truth.storage_modulus(omega) * noise[0], truth.loss_modulus(omega) * noise[1]
    return truth, DynamicTable(omega, storage, loss, "shear", "epdm.csv")


@pytest.mark.parametrize("seed", [0, 1, 2])
def test_the_fast_end_of_the_data_is_fitted_as_well_as_the_rest(seed):
    """Branches faster than the data matter at their fast end: without them the misfit is 0.033, the loss 17 % low."""
    truth, data = measured_epdm(seed)
    fit = fit_prony(data)
    # The noise of the complex modulus is 0.01 to 0.013.
    assert fit.misfit < 0.015
    omega = np.geomspace(data.angular_frequency[0], data.angular_frequency[-1], 200)
    assert fit.series.storage_modulus(omega) == pytest.approx(truth.storage_modulus(omega), rel=0.02)
    assert fit.series.loss_modulus(omega) == pytest.approx(truth.loss_modulus(omega), rel=0.06)


def test_the_material_of_a_fit_has_the_window_of_the_data():
    _, data = measured_epdm(0)
    fit = fit_prony(data)
    assert fit.window == pytest.approx((1.0 / data.angular_frequency[-1], 1.0 / data.angular_frequency[0]))
    material = fit.material(bulk_modulus=2e9, density=1100.0, name="EPDM")
    assert material.window == fit.window
    assert (material.shear, material.bulk) == (fit.series, PronySeries(2e9))
    assert (material.source, material.density, material.name) == ("epdm.csv", 1100.0, "EPDM")
    # K/G = 2(1 + nu)/(3(1 - 2 nu)) = 5/3 for nu = 1/4.
    assert fit.material(poisson_ratio=0.25).bulk.branch_moduli == pytest.approx(fit.series.branch_moduli * 5 / 3)
    for wrong, field in (
        ({"bulk_modulus": 2e9, "deformation": "tension"}, "deformation"),
        ({}, "bulk_modulus, poisson_ratio"),
        ({"poisson_ratio": 0.6}, "poisson_ratio"),
    ):
        assert in_one_line(partial(fit.material, **wrong)).field == field


def test_data_in_tension_become_shear():
    t = np.geomspace(1e-3, 1e3, 61)
    fit = fit_prony(RelaxationTable(t, PronySeries(3e6, [9e6], [0.1]).relaxation_modulus(t)))
    assert named(lambda: fit.material(bulk_modulus=2e9)) == ("deformation",)
    incompressible = fit.material(bulk_modulus=math.inf, deformation="tension")
    assert incompressible.shear.relaxation_modulus(t) == pytest.approx(fit.series.relaxation_modulus(t) / 3)


@pytest.mark.parametrize("noise", [0.0, 0.01])
def test_constant_data_give_no_branch_and_a_warning(noise):
    t = np.geomspace(1e-3, 1e3, 25)
    modulus = 1e6 * (1.0 + noise * np.random.default_rng(3).standard_normal(25))
    with pytest.warns(RestitutionWarning) as caught:
        fit = fit_prony(RelaxationTable(t, modulus))
    assert [warning.message.kind for warning in caught] == ["fit"]
    assert fit.n_terms == 0
    assert fit.series.equilibrium_modulus == pytest.approx(1e6, rel=0.01)


def test_a_small_loss_is_fitted():
    """The loss tangent of metals and glasses is about 0.002, and only this loss makes e smaller than one."""
    omega = np.geomspace(1.0, 1e4, 31)
    storage = 1e9 * (1.0 + 1e-3 * np.log(omega))
    fit = fit_prony(DynamicTable(omega, storage, np.full(31, np.pi / 2 * 1e6)))
    assert fit.n_terms > 0
    middle = np.geomspace(10.0, 1e3, 9)
    # E'' = (pi/2) dE'/dln(omega) if E' rises slowly.
    assert fit.series.loss_modulus(middle) == pytest.approx(np.pi / 2 * 1e6, rel=0.15)


def test_rising_relaxation_data_are_fitted_by_a_constant():
    t = np.geomspace(1.0, 100.0, 9)
    with pytest.warns(RestitutionWarning, match="^a.csv: ") as caught:
        fit = fit_prony(RelaxationTable(t, np.linspace(2.0, 2.1, 9), source="a.csv"))
    assert (fit.n_terms, len(caught)) == (0, 1)


def test_a_poor_fit_gives_a_warning():
    """Contradictory loss and storage moduli: no material with a constant E' has a loss of 0.8 E'."""
    omega = np.geomspace(1.0, 1e4, 21)
    with pytest.warns(RestitutionWarning) as caught:
        fit = fit_prony(DynamicTable(omega, np.full(21, 5.0), np.full(21, 4.0)))
    assert fit.misfit > 0.1
    assert caught[0].message.kind == "fit"
    assert f"{fit.misfit:.3g}" in str(caught[0].message)


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
    """The deck contains 27 terms from another program, relative to the highest storage modulus."""
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
    """The file contains 31 terms from another program for the same data."""
    folder = shared_reference / "materials"
    data = read_material(folder / "polymer_relaxation_master_curve.csv")
    other = read_material(folder / "polymer_relaxation_prony.csv").series()
    fit = fit_prony(data)
    theirs = rms(other.relaxation_modulus(data.time) / data.modulus - 1)
    assert theirs == pytest.approx(2.54e-3, rel=0.01)
    assert fit.misfit <= theirs
    assert fit.misfit == pytest.approx(rms(fit.series.relaxation_modulus(data.time) / data.modulus - 1), rel=1e-9)
    assert fit.n_terms <= 40


def test_the_text_of_a_fit_leaves_out_the_data():
    fit = fit_prony(RelaxationTable(np.logspace(-3, 3, 400), 1.0 + np.exp(-np.logspace(-3, 3, 400))))
    assert len(repr(fit)) < 1000
    assert "misfit=" in repr(fit)


def test_a_material_made_by_hand_from_a_fit_has_its_window():
    """The window goes with the series through conversions and shifts, and no series without data has one."""
    low, high = np.exp(np.random.default_rng(3).uniform(np.log([1e-4, 1e1]), np.log([1e-2, 1e3])))
    times = np.geomspace(low, high, 41)
    table = RelaxationTable(times, 1e6 + 3e6 * np.exp(-times / math.sqrt(low * high)), "tension")
    series = fit_prony(table).series
    window = pytest.approx((times[0], times[-1]), rel=1e-12)
    assert Material(series, 2e9).window == window
    assert Material(1e6, series).window == window
    for shear in (
        shear_from_tension(series, bulk_modulus=2e9),
        shear_from_tension(series, poisson_ratio=0.4),
        shear_from_tension(series, bulk_modulus=math.inf),
        pickle.loads(pickle.dumps(series)),
    ):
        assert Material(shear, math.inf).window == window
    assert Material(series.scaled(2.0, time_factor=0.1), 2e9).window == pytest.approx((0.1 * low, 0.1 * high))
    assert Material(series, 2e9, window=(1.0, 2.0)).window == (1.0, 2.0)
    assert Material(PronySeries(1e6, [1e6], [1.0]), 2e9).window is None
    result = solve(Impact(Material(series, 2e9), Parabola(1e-6), 1e-15, 10.0))
    assert any(line.startswith("window: ") for line in result.warnings)


def test_columns_are_any_sequences_of_one_length():
    times, moduli = [1e-3, 1e-2, 1e-1, 10.0], [1e7, 5e6, 3e6, 2e6]
    expected = fit_prony(RelaxationTable(np.array(times), np.array(moduli))).series
    assert fit_prony(RelaxationTable(times, moduli)).series == expected
    for call, message in (
        (lambda: RelaxationTable(times, moduli[:3]), "columns of one length"),
        (lambda: DynamicTable(times, moduli, "stiff"), "loss_modulus"),
        (lambda: fit_prony(RelaxationTable(np.array(times)[::-1], np.array(moduli))), "strictly ascending"),
        (lambda: fit_prony(RelaxationTable(np.array(times), -np.array(moduli))), "must be finite and > 0"),
    ):
        with pytest.raises(InputError, match=message):
            call()


def test_a_modulus_of_nearly_zero_gives_no_warning_of_numpy():
    table = RelaxationTable([1e-3, 1e-2, 1e-1, 10.0], [1e7, 5e6, 3e6, 1e-302])
    assert named(lambda: fit_prony(table)) == ("equilibrium_modulus + sum of branch_moduli", 1e-302)


def test_stated_errors_cover_the_truth():
    """Scatter of fits to simulated data over the stated one: 1 for a linear fit at given times."""
    rng = np.random.default_rng(5)
    truth = PronySeries(1e6, [3e6, 2e6, 5e6], [1e-4, 1e-3, 1e-2])
    time, places = np.geomspace(1e-5, 1.0, 80), np.geomspace(1e-4, 0.1, 7)
    exact, ratios = truth.relaxation_modulus(time), []
    for _ in range(40):
        fit = fit_prony(RelaxationTable(time, exact * (1.0 + 0.02 * rng.standard_normal(time.size)), "shear"))
        shares = np.exp(-places[:, None] / fit.series.relaxation_times)
        if fit.names[0] == "equilibrium_modulus":
            shares = np.hstack((np.ones((places.size, 1)), shares))
        stated = np.sqrt(np.einsum("ij,jk,ik->i", shares, fit.covariance, shares))
        ratios.append((fit.series.relaxation_modulus(places) - truth.relaxation_modulus(places)) / stated)
    # 280 ratios; those of one fit are correlated, so that their mean square scatters by some 15 %. The choice of times
    # and terms, which is not in the covariance, adds the rest.
    assert 0.8 < np.mean(np.square(ratios)) < 1.8


@pytest.mark.parametrize(("liquid", "first"), [(False, "equilibrium_modulus"), (True, "branch_moduli[0]")])
@pytest.mark.parametrize("table", [relaxation, dynamic])
def test_covariance_has_a_row_for_each_modulus(table, liquid, first):
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # a solid is no liquid
        fit = fit_prony(table(TRUTH), liquid=liquid)
    assert fit.names == ((first, *(f"branch_moduli[{k}]" for k in range(fit.n_terms)))[liquid:])
    sizes = np.sqrt(np.diag(fit.covariance))
    assert fit.covariance.shape == (len(fit.names),) * 2
    assert np.linalg.eigvalsh(fit.covariance / np.outer(sizes, sizes)).min() > -1e-9


def test_compliances_have_no_covariance_of_moduli():
    time = np.geomspace(1e-2, 1e2, 30)
    fit = fit_prony(CreepTable(time, TRUTH.creep_compliance(time), "shear"))
    assert fit.covariance is None
    assert named(lambda: fit.scattered(bulk_modulus=2e9))[0] == "data"


def test_the_note_on_a_fit_counts_its_terms() -> None:
    """One Maxwell branch needs one term, three over six decades more."""
    t = np.geomspace(1e-4, 1e6, 201)
    for times, words in (([1.0], "1 Prony term fitted"), ([1e-2, 1e1, 1e4], " Prony terms fitted")):
        series = PronySeries(1e6, [1e6] * len(times), times)
        data = RelaxationTable(t, series.relaxation_modulus(t), "shear")
        assert words in str(fit_prony(data).material(bulk_modulus=2e9).assumptions)
