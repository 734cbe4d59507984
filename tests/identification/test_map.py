"""Maps of indentation curves: agreement with single fits, coverage, curves that fail, interrupts."""

import math

import numpy as np
import pytest

import restitution as rs
from refusals import in_one_line, warns
from restitution.identification import map as map_module
from restitution.identification.map import MapStatus
from restitution.material.prony import PronySeries

TIP = rs.Parabola(2.5e-6)
FIXED = {"poisson_ratio": 0.5}
NAMES = ("equilibrium_modulus", "branch_modulus", "viscosity", "contact_point")
TIME = np.linspace(0.0, 2.8, 200)
DEPTH = np.interp(TIME, [0.0, 1.4, 2.8], [0.0, 1.4e-6, 0.0])
SD = 1e-11


def force_of(equilibrium, branch, time, place):
    """Force over `TIME` of an incompressible standard solid with this contact point, by the solver of indentations."""
    solid = rs.Material(PronySeries(equilibrium, [branch], [time]), bulk=math.inf)
    result = rs.indent(solid, TIP, depth=np.array([0.0, 1.4e-6, 0.0]) - place, time=[0.0, 1.4, 2.8])
    return result.sample(TIME).force.values


def curves_of(count, seed, spread=0.4):
    """Curves of random standard solids and contact points, and the truth, shape (4, count)."""
    rng = np.random.default_rng(seed)
    equilibrium, branch, time = np.array([[70.0], [270.0], [0.3]]) * np.exp(rng.normal(0.0, spread, (3, count)))
    places = rng.uniform(0.3e-6, 0.5e-6, count)
    forces = np.stack([force_of(*numbers) for numbers in zip(equilibrium, branch, time, places, strict=True)])
    forces += rng.normal(0.0, SD, forces.shape)
    curves = [rs.IndentationCurve(TIME, DEPTH, force, profile=TIP, noise=rs.Noise(force=SD)) for force in forces]
    return curves, np.stack([equilibrium, branch, branch * time, places])


@pytest.mark.parametrize("workers", [1, 2])
def test_a_map_agrees_with_single_fits(workers):
    curves, _ = curves_of(6, 1)
    table = rs.identify_map(curves, rs.standard_solid, fixed=FIXED, workers=workers, shape=(2, 3))
    assert dict(table.sizes) == {"y": 2, "x": 3}
    for n, curve in enumerate(curves):
        alone = rs.identify(curve, rs.standard_solid, fixed=FIXED, profiles=False)
        estimates = alone.parameters | {"contact_point": alone.nuisances["contact_point"]}
        for name in NAMES:
            error = estimates[name].standard_error
            assert table[name].values.flat[n] == pytest.approx(estimates[name].value, abs=2e-3 * error)
            assert table[f"{name}_standard_error"].values.flat[n] == pytest.approx(error, rel=1e-3)
        assert table["chi2"].values.flat[n] == pytest.approx(alone.chi2, rel=1e-5)


@pytest.mark.parametrize("count", [120, pytest.param(1000, marks=pytest.mark.slow)])
def test_intervals_cover_the_truth(count):
    """95 % of them, also for the contact point, within 3.5 standard deviations of the count and 2 %."""
    curves, truth = curves_of(count, 2, spread=0.2)
    table = rs.identify_map(curves, rs.standard_solid, fixed=FIXED, workers=2)
    assert np.all(table["status"] == MapStatus.FITTED)
    for name, value in zip(NAMES, truth, strict=True):
        z = (table[name].values - value) / table[f"{name}_standard_error"].values
        assert np.mean(np.abs(z) < 1.96) == pytest.approx(0.95, abs=0.02 + 3.5 * math.sqrt(0.95 * 0.05 / count))
        assert np.std(z) == pytest.approx(1.0, abs=0.1 + 3.5 / math.sqrt(2.0 * count))
    assert float(table["reduced_chi2"].mean()) == pytest.approx(1.0, abs=3.5 * math.sqrt(2.0 / TIME.size / count))


def test_a_curve_that_fails_does_not_stop_the_map():
    curves, _ = curves_of(3, 3)

    def saturated():
        return rs.IndentationCurve(TIME, DEPTH, np.minimum(curves[0].force, 3e-10), profile=TIP)

    items = [saturated, curves[0], lambda: curves[1], curves[2]]
    table = rs.identify_map(items, rs.standard_solid, fixed=FIXED)
    assert table["status"].values.tolist() == [MapStatus.REFUSED, 0, 0, 0]
    assert "saturated" in str(table["message"].values[0])
    assert np.isnan(table["viscosity"].values).tolist() == [True, False, False, False]
    alone = rs.identify_map(curves, rs.standard_solid, fixed=FIXED)
    assert table["viscosity"].values[1:] == pytest.approx(alone["viscosity"].values, rel=1e-6)


def test_the_table_has_baseline_and_range_of_each_curve():
    curves, truth = curves_of(3, 8)
    for n, curve in enumerate(curves):
        force = curve.force + 5e-11 * (1 + n) - 2e-11 * (TIME - TIME[0])
        curves[n] = rs.IndentationCurve(
            TIME + 1.0, DEPTH, force, profile=TIP, noise=rs.Noise(force=SD), segment="approach" if n == 1 else None
        )
    table = rs.identify_map(curves, rs.standard_solid, fixed=FIXED)
    # 200 points of 10 pN; some 60 of them lie before the contact.
    assert table["baseline"].values == pytest.approx([5e-11, 10e-11, 15e-11], abs=1e-11)
    assert table["baseline_slope"].values[[0, 2]] == pytest.approx([-2e-11] * 2, abs=8e-12)
    assert table["start_time"].values.tolist() == [1.0, 1.0, 1.0]
    assert table["end_time"].values == pytest.approx([3.8, 2.4, 3.8], abs=0.02)
    assert table["points"].values == pytest.approx([200, 100, 200], abs=1)
    # No point lies at the top of the triangle.
    depth = DEPTH.max() - table["contact_point"].values
    assert table["indentation_depth"].values == pytest.approx(depth, rel=1e-12)
    assert table["indentation_depth"].values == pytest.approx(DEPTH.max() - truth[3], abs=20e-9)
    assert table["baseline"].attrs["units"] == "N"


def test_two_tips_and_lengths_in_one_map():
    curves, _ = curves_of(2, 4)
    half = slice(0, 120)
    short = [rs.IndentationCurve(TIME[half], DEPTH[half], curve.force[half], profile=TIP) for curve in curves]
    cone = rs.Cone(half_angle=1.2)
    gel = rs.standard_solid(70.0, 270.0, 80.0, poisson_ratio=0.5)
    force = rs.indent(gel, cone, depth=DEPTH - 0.4e-6, time=TIME).force
    force += np.random.default_rng(0).normal(0.0, 0.005 * force.max(), TIME.size)
    items = [curves[0], rs.IndentationCurve(TIME, DEPTH, force, profile=cone), short[1]]
    table = rs.identify_map(items, rs.standard_solid, fixed=FIXED)
    for n, curve in enumerate(items):
        alone = rs.identify(curve, rs.standard_solid, fixed=FIXED, profiles=False).parameters
        reference = alone["branch_modulus"]
        assert table["branch_modulus"].values[n] == pytest.approx(reference.value, abs=0.02 * reference.standard_error)


def test_finished_curves_are_kept_after_an_interrupt():
    curves, _ = curves_of(4, 5)

    def press(done, total):
        assert total == 200
        if done:
            raise KeyboardInterrupt

    with warns("interrupted"):
        table = rs.identify_map(curves * 50, rs.standard_solid, fixed=FIXED, workers=1, progress=press)
    done = table["status"].values != MapStatus.NOT_DONE
    assert 0 < done.sum() < 200
    assert np.isfinite(table["viscosity"].values[done]).all()
    assert np.isnan(table["viscosity"].values[~done]).all()


def test_parameters_that_a_curve_does_not_determine_are_nan():
    """A relaxation that ends within a point of the curve: its modulus and time have the same effect."""
    elastic = rs.elastic(shear_modulus=300.0, poisson_ratio=0.5)
    force = rs.indent(elastic, TIP, depth=DEPTH - 0.4e-6, time=TIME).force
    force += np.random.default_rng(0).normal(0.0, SD, TIME.size)
    data = rs.IndentationCurve(TIME, DEPTH, force, profile=TIP, noise=rs.Noise(force=SD))
    table = rs.identify_map([data], rs.standard_solid, fixed=FIXED)
    assert np.isnan(table["viscosity"].values[0]) or np.isnan(table["branch_modulus"].values[0])
    missing = [name for name in ("equilibrium_modulus", "branch_modulus", "viscosity") if np.isnan(table[name][0])]
    assert str(table["message"].values[0]) == f"fitted; the curve does not determine {', '.join(missing)}"
    assert np.isinf(table["viscosity_standard_error"].values[0]) or np.isinf(
        table["branch_modulus_standard_error"].values[0]
    )


@pytest.mark.parametrize(
    ("items", "options", "field"),
    [([], {}, "shape"), ([1.0], {}, "curves"), ([lambda: None], {}, "curves"), ([], {"shape": (2, 3)}, "shape")],
)
def test_wrong_arguments_are_refused(items, options, field):
    assert in_one_line(lambda: rs.identify_map(items, rs.standard_solid, fixed=FIXED, **options)).field == field


def test_every_curve_without_a_fit_has_a_message(monkeypatch):
    """Descents of one curve have no result, those of one do not end, and the fits from other starts are refused."""
    curves, _ = curves_of(4, 11)
    descend, identify = map_module.Descent.fits, map_module.estimate

    def failing(self):
        fits = descend(self)
        for n, curve in enumerate(self.curves):
            fits.chi2[n] = np.inf if curve is curves[1] else fits.chi2[n]
            fits.ended[n] &= curve not in curves[1:3]
        return fits

    def estimate(observations, space):
        if observations[0] in curves[1:3]:
            raise rs.InputError("start", rule="leads to no result")
        return identify(observations, space)

    monkeypatch.setattr(map_module.Descent, "fits", failing)
    monkeypatch.setattr(map_module, "estimate", estimate)
    table = rs.identify_map(curves, rs.standard_solid, fixed=FIXED)
    assert table["status"].values.tolist() == [0, MapStatus.NO_FIT, MapStatus.NOT_CONVERGED, 0]
    assert table["message"].values.tolist() == [
        "fitted", "start: leads to no result", "start: leads to no result", "fitted",
    ]  # fmt: skip


@pytest.mark.parametrize("seed", [0, 1, 35, *(pytest.param(n, marks=pytest.mark.slow) for n in range(2, 35))])
def test_a_first_curve_that_determines_little_spoils_no_other(seed):
    """Each row fits as well as alone, also where all rows start from an approach with the most noise."""
    rng, curves = np.random.default_rng(seed), list[rs.IndentationCurve]()
    truth = 10.0 ** rng.uniform(1.0, 4.0) * np.array([1.0, 10.0 ** rng.uniform(-0.3, 1.0), 0.0])
    truth[2] = truth[1] * 10.0 ** rng.uniform(-1.2, 0.3)
    for noise in (0.03, 0.003, 0.003, 0.003):
        time = np.linspace(0.0, 2.0, 160)[: 80 if noise == 0.03 else 160]
        depth = np.interp(time, [0.0, 1.0, 2.0], [0.0, 1e-6, 1e-6])
        force = rs.indent(rs.standard_solid(*truth, **FIXED), TIP, depth=depth - 0.3e-6, time=time).force
        deviation = noise * force.max()
        force = force + rng.normal(0.0, deviation, time.size)
        curves.append(rs.IndentationCurve(time, depth, force, profile=TIP, noise=rs.Noise(force=deviation)))
    found = rs.identify_map(curves, rs.standard_solid, fixed=FIXED, progress=False, workers=1)
    for chi2, curve in zip(found.chi2.values, curves, strict=True):
        assert chi2 < rs.identify(curve, rs.standard_solid, fixed=FIXED, profiles=False).chi2 + 3.0
