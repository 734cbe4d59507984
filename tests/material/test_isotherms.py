"""Superposition of isotherms whose shifts are known."""

import warnings

import numpy as np
import pytest

from refusals import in_one_line, named
from restitution import WLF, Arrhenius, InputError, Isotherms, Material, PronySeries, RestitutionWarning, ShiftTable
from restitution.material.fit import DynamicTable, RelaxationTable, fit_prony

OMEGA = np.geomspace(0.1, 100.0, 16)


def plazek(celsius):
    """Shift log10 aT of polystyrene in creep over 100 °C (Plazek)."""
    return -10.7 * (celsius - 100.0) / (29.9 + celsius - 100.0)


def polymer(rng):
    """Broad spectrum of twelve decades."""
    times = 10.0 ** (np.linspace(-6.0, 6.0, 13) + rng.normal(0.0, 0.2, 13))
    moduli = 10.0 ** (7.0 - 0.2 * np.arange(13) + rng.normal(0.0, 0.2, 13))
    return PronySeries(moduli[-1], moduli, times)


def measured(series, kelvin, shifts, rng=None, noise=0.0, kind=DynamicTable, factors=None):
    """Isotherms with a relative scatter, of the loss modulus half as much again."""
    tables = []
    for place, (temperature, shift) in enumerate(zip(kelvin, shifts, strict=True)):
        factor = 1.0 if factors is None else factors[place]
        scatter = (lambda sd: 1.0) if rng is None else (lambda sd: np.exp(sd * rng.normal(size=OMEGA.size)))
        if kind is RelaxationTable:
            modulus = series.relaxation_modulus(1.0 / OMEGA[::-1] / 10.0**shift)
            tables.append(
                RelaxationTable(1.0 / OMEGA[::-1], factor * modulus * scatter(noise), temperature=temperature)
            )
            continue
        reduced = OMEGA * 10.0**shift
        storage, loss = series.storage_modulus(reduced), series.loss_modulus(reduced)
        both = factor * storage * scatter(noise), factor * loss * scatter(1.5 * noise)
        tables.append(DynamicTable(OMEGA, *both, temperature=temperature))
    return Isotherms(tables)


@pytest.mark.parametrize("kind", [DynamicTable, RelaxationTable])
def test_exact_data_give_the_exact_shifts_of_plazek(kind):
    """Twelve temperatures of polystyrene, without scatter: the spline is off by far less than a hundredth decade."""
    celsius = np.array([100.0, 102.5, 105.0, 108.0, 112.0, 117.0, 123.0, 130.0, 140.0, 150.0])
    isotherms = measured(polymer(np.random.default_rng(1)), celsius + 273.15, plazek(celsius), kind=kind)
    curve = isotherms.superposed(reference_temperature=373.15)
    assert curve.log10_factors == pytest.approx(plazek(celsius), abs=0.02)
    law = isotherms.superposed(reference_temperature=373.15, shift="wlf")
    assert law.constants["c1"] == pytest.approx(10.7, rel=0.01)
    assert law.constants["c2"] == pytest.approx(29.9, rel=0.01)
    assert curve.misfit < 0.005
    assert curve.doubts == law.doubts == ()


@pytest.mark.parametrize("kind", [DynamicTable, RelaxationTable])
@pytest.mark.parametrize("seed", range(6))
def test_random_materials_and_temperatures_within_four_standard_errors(seed, kind):
    """Shifts, and constants of WLF, of random materials at random temperatures with random scatter."""
    rng = np.random.default_rng(seed)
    c1, c2 = rng.uniform(6.0, 14.0), rng.uniform(60.0, 200.0)
    shifts = -np.cumsum(rng.uniform(0.3, 1.8, 8))
    shifts -= shifts[3]
    kelvin = 320.0 - c2 * shifts / (c1 + shifts)
    isotherms = measured(polymer(rng), kelvin, shifts, rng, rng.choice([0.005, 0.01, 0.03]), kind)
    curve = isotherms.superposed(reference_temperature=320.0)
    others = np.delete(np.arange(8), 3)
    # By chance, one of 370 shifts is off by more than 3 standard errors, and one of 16 000 by more than 4.
    assert np.all(np.abs(curve.log10_factors - shifts)[others] < 4.0 * curve.errors[others])
    assert (curve.errors[3], curve.log10_factors[3]) == (0.0, 0.0)
    law = isotherms.superposed(reference_temperature=320.0, shift="wlf")
    for name, truth in (("c1", c1), ("c2", c2)):
        assert abs(law.constants[name] - truth) < 4.0 * law.constant_errors[name]


@pytest.mark.slow
@pytest.mark.parametrize("shift", ["free", "wlf", "arrhenius"])
@pytest.mark.parametrize("vertical", [False, True])
def test_standard_errors_are_those_of_repetition(shift, vertical):
    """Root mean square of the deviations over their standard errors between 0.8 and 1.3."""
    kelvin = np.array([280.0, 290.0, 300.0, 312.0, 325.0, 340.0])
    law = Arrhenius(300.0, 120e3) if shift == "arrhenius" else WLF(300.0, 8.0, 100.0)
    shifts = np.log10([law.factor(temperature) for temperature in kelvin])
    deviations, lifts = [], []
    for seed in range(40):
        rng = np.random.default_rng(seed)
        lift = rng.normal(0.0, 0.02, 6) * vertical
        lift[2] = 0.0
        isotherms = measured(polymer(rng), kelvin, shifts, rng, 0.02, factors=10.0**lift)
        curve = isotherms.superposed(reference_temperature=300.0, shift=shift, vertical=vertical)
        others = curve.errors > 0.0
        deviations.append((curve.log10_factors - shifts)[others] / curve.errors[others])
        if vertical:
            places = curve.vertical_errors > 0.0
            lifts.append((curve.log10_vertical_factors + lift)[places] / curve.vertical_errors[places])
    for group in filter(None, (deviations, lifts)):
        assert 0.8 < np.sqrt(np.mean(np.square(group))) < 1.3


def test_vertical_shifts():
    shifts, factors = np.array([1.5, 0.8, 0.0, -0.7, -1.2]), np.array([1.1, 1.05, 1.0, 0.97, 0.92])
    rng = np.random.default_rng(3)
    isotherms = measured(polymer(rng), np.linspace(290.0, 330.0, 5), shifts, rng, 0.003, factors=factors)
    curve = isotherms.superposed(reference_temperature=310.0, vertical=True)
    assert np.all(np.abs(curve.log10_factors - shifts) <= 4.0 * curve.errors)
    assert np.all(np.abs(curve.log10_vertical_factors + np.log10(factors)) <= 4.0 * curve.vertical_errors)
    assert curve.vertical_errors[2] == 0.0
    # The reduced data lie on one curve again.
    assert curve.misfit < 0.006 < isotherms.superposed(reference_temperature=310.0).misfit


def test_a_reference_between_two_temperatures():
    rng = np.random.default_rng(5)
    kelvin, shifts = np.array([290.0, 300.0, 320.0]), np.array([1.0, 0.0, -1.2])
    isotherms = measured(polymer(rng), kelvin, shifts, rng, 0.01)
    curve = isotherms.superposed(reference_temperature=305.0)
    # log10 aT is linear between 300 and 320 K.
    assert np.all(np.abs(curve.log10_factors - (shifts + 0.3)) < 4.0 * curve.errors)
    assert curve.shift.reference_temperature == pytest.approx(305.0)
    assert isotherms.superposed().reference_temperature == 300.0
    assert curve.data.temperature == 305.0
    wlf = isotherms.superposed(reference_temperature=305.0, shift="wlf").shift
    assert (wlf.reference_temperature, wlf.temperature_range) == (305.0, (290.0, 320.0))


def test_the_way_to_a_material():
    """Master curve to Prony series, shift to material; the moduli at another temperature are those measured there."""
    rng = np.random.default_rng(7)
    series = polymer(rng)
    kelvin = np.array([290.0, 300.0, 312.0, 325.0, 340.0])
    law = WLF(312.0, 9.0, 110.0)
    isotherms = measured(series, kelvin, np.log10([law.factor(temperature) for temperature in kelvin]), rng, 0.003)
    for shift in ("free", "wlf"):
        curve = isotherms.superposed(reference_temperature=312.0, shift=shift)
        result = fit_prony(curve.data).material(bulk_modulus=3e9, deformation="shear")
        material = Material(
            result.shear, result.bulk, shift=curve.shift, temperature=curve.reference_temperature, window=result.window
        )
        warm = material.at(340.0).shear
        assert warm.storage_modulus(OMEGA) == pytest.approx(isotherms.tables[-1].storage_modulus, rel=0.04)
        assert isinstance(curve.shift, ShiftTable if shift == "free" else WLF)


def test_doubts_are_warnings():
    rng = np.random.default_rng(2)
    kelvin, shifts = np.array([290.0, 300.0, 310.0]), np.array([9.0, 0.0, -1.0])
    apart = measured(polymer(rng), kelvin, shifts, rng, 0.01)
    with pytest.warns(RestitutionWarning) as caught:
        curve = apart.superposed(reference_temperature=300.0)
    lines = [str(warning.message) for warning in caught]
    assert any("16.9 and 26.9 °C do not overlap" in line for line in lines)
    assert curve.errors[0] == np.inf
    assert {warning.message.kind for warning in caught} == {"superposition"}


def test_two_processes_with_different_shifts_are_not_thermorheologically_simple():
    slow = PronySeries(1e6, [1e7] * 5, np.geomspace(0.01, 100.0, 5))
    fast = PronySeries(0.0, [3e7] * 3, np.geomspace(1e-4, 1e-2, 3))
    tables = []
    for shift in (2.0, 1.0, 0.0, -1.0, -2.0):
        at = OMEGA * 10.0**shift, OMEGA * 10.0 ** (0.2 * shift)
        storage = slow.storage_modulus(at[0]) + fast.storage_modulus(at[1])
        loss = slow.loss_modulus(at[0]) + fast.loss_modulus(at[1])
        tables.append(DynamicTable(OMEGA, storage, loss, temperature=300.0 - 10.0 * shift))
    with pytest.warns(RestitutionWarning, match="may not be thermorheologically simple"):
        curve = Isotherms(tables).superposed()
    assert curve.misfit > 0.1


def test_free_shifts_that_rise_with_the_temperature_are_no_table():
    rng = np.random.default_rng(4)
    rising = measured(polymer(rng), [290.0, 300.0, 310.0], [0.5, 0.0, 0.4], rng, 0.003)
    with pytest.warns(RestitutionWarning, match=r"the shifts do not fall with the temperature: 0 at 26\.9 °C"):
        curve = rising.superposed(reference_temperature=300.0)
    assert curve.log10_factors[2] == pytest.approx(0.4, abs=0.05)
    with pytest.raises(InputError, match=r"0 at 26.9 °C, 0\.4.* at 36.9 °C: must fall"):
        _ = curve.shift


def test_refusals():
    table = DynamicTable(OMEGA, OMEGA, OMEGA, temperature=300.0)
    with pytest.raises(InputError, match=r"^tables = .*: must be several DynamicTable or several RelaxationTable$"):
        Isotherms([table])
    assert in_one_line(lambda: Isotherms([table, RelaxationTable(OMEGA, OMEGA, temperature=310.0)])).field == "tables"
    with pytest.raises(InputError, match="temperature = 300 K: must differ"):
        Isotherms([table, table])
    assert named(lambda: Isotherms([table, DynamicTable(OMEGA, OMEGA, OMEGA)])) == ("tables[1].temperature", None)
    shear = DynamicTable(OMEGA, OMEGA, OMEGA, "shear", temperature=310.0)
    assert in_one_line(lambda: Isotherms([table, shear])).field == "deformation"
    both = Isotherms([table, DynamicTable(OMEGA, OMEGA, OMEGA, temperature=310.0)])
    with pytest.raises(InputError, match=r"reference_temperature = 320 K: must be in \[300, 310\] K"):
        both.superposed(reference_temperature=320.0)
    with pytest.raises(InputError, match="shift = 'vft': must be one of free, wlf, arrhenius"):
        both.superposed(shift="vft")
    point = DynamicTable(OMEGA[:1], OMEGA[:1], OMEGA[:1], temperature=310.0)
    with pytest.raises(InputError, match=r"tables\[1\]: must have at least two frequencies"):
        Isotherms([table, point]).superposed()


def test_the_order_of_the_tables_does_not_matter():
    rng = np.random.default_rng(6)
    whole = measured(polymer(rng), [290.0, 300.0, 310.0], [0.8, 0.0, -0.7], rng, 0.01)
    other = Isotherms(whole.tables[::-1])
    curve, same = (each.superposed(reference_temperature=300.0) for each in (whole, other))
    assert curve.log10_factors.tolist() == same.log10_factors.tolist()


def test_a_loss_of_zero_has_no_logarithm():
    rng = np.random.default_rng(8)
    whole = measured(polymer(rng), [290.0, 300.0, 310.0], [0.8, 0.0, -0.7], rng, 0.01)
    whole.tables[1].loss_modulus[3] = 0.0
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        curve = whole.superposed(reference_temperature=300.0)
    assert curve.log10_factors == pytest.approx([0.8, 0.0, -0.7], abs=0.05)


@pytest.mark.parametrize("options", [{}, {"shift": "wlf"}, {"shift": "arrhenius"}, {"vertical": True}])
def test_isotherms_without_sense_are_superposed_or_refused(options):
    """Moduli at random over twenty decades: refused, or shifts that are numbers."""
    rng = np.random.default_rng(0)
    for _ in range(2):
        tables = []
        for kelvin in np.sort(rng.uniform(1.0, 1000.0, rng.integers(2, 6))):
            n = int(rng.integers(2, 9))
            omega = np.sort(10.0 ** rng.uniform(-3.0, 3.0, n))
            loss = 10.0 ** rng.uniform(-8.0, 12.0, n) * (rng.random(n) < 0.8)
            tables.append(DynamicTable(omega, 10.0 ** rng.uniform(-8.0, 12.0, n), loss, temperature=float(kelvin)))
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", RestitutionWarning)
            try:
                curve = Isotherms(tables).superposed(**options)
            except InputError as error:
                assert "must overlap" in str(error)  # noqa: PT017
                continue
        assert np.isfinite(curve.log10_factors).all()
        assert not np.isnan(curve.errors).any()


def test_isotherms_that_do_not_change_determine_no_shift():
    tables = [DynamicTable(OMEGA, 0.0 * OMEGA + 1e6, 0.0 * OMEGA, temperature=kelvin) for kelvin in (300.0, 310.0)]
    with pytest.warns(RestitutionWarning, match="the standard error of the shift at"):
        curve = Isotherms(tables).superposed()
    assert curve.errors.max() > 1e3


def test_covariance_of_the_shifts_of_a_law():
    """One activation energy shifts all isotherms together: the covariance is of rank one (Arrhenius)."""
    rng, kelvin = np.random.default_rng(4), np.array([280.0, 290.0, 300.0, 312.0, 325.0])
    shifts = np.log10([Arrhenius(300.0, 120e3).factor(temperature) for temperature in kelvin])
    isotherms = measured(polymer(rng), kelvin, shifts, rng, 0.02)
    curve = isotherms.superposed(reference_temperature=300.0, shift="arrhenius")
    relative = curve.constant_errors["activation_energy"] / curve.constants["activation_energy"]
    errors = curve.log10_factors * relative
    assert curve.covariance == pytest.approx(np.outer(errors, errors), rel=1e-9, abs=1e-15)
    assert [curve.error_at(temperature) for temperature in kelvin] == pytest.approx(curve.errors, abs=1e-12)
    # Halfway, all of the scatter is of the one constant, so that standard errors are linear.
    assert curve.error_at(318.5) == pytest.approx(0.5 * (curve.errors[3] + curve.errors[4]), rel=1e-9)
    assert named(lambda: curve.error_at(326.0)) == ("temperature", 326.0)


def test_shifts_beyond_a_gap_have_no_covariance():
    rng, shifts = np.random.default_rng(6), np.array([8.0, 1.0, 0.0, -1.0])
    isotherms = measured(polymer(rng), np.array([280.0, 300.0, 310.0, 320.0]), shifts, rng, 0.01)
    with pytest.warns(RestitutionWarning):
        curve = isotherms.superposed(reference_temperature=310.0)
    assert np.isinf(curve.errors).tolist() == [True, False, False, False]
    assert np.isinf(curve.covariance).sum() == 1
    assert np.isinf(curve.error_at(290.0))
    assert curve.error_at(305.0) < curve.error_at(300.0) < 1.0
