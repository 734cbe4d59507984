"""Force laws made from contacts with known impacts, with and without noise."""

import math
import warnings
from pathlib import Path

import numpy as np
import pytest

import restitution as rs
from refusals import in_one_line, named
from restitution.contact.force_law import fit_force
from restitution.errors import RestitutionWarning

SOLID = rs.Material(rs.PronySeries(1.0, [10.0], [0.1]), math.inf)
MODULUS = 3.0  # E* = 4 for an incompressible twin
DISC = Path(__file__).parents[1] / "data" / "rubber_disc.csv"
SHAPES = {
    "parabola": rs.Parabola(1.0),
    "cone": rs.Cone(1.2),
    "sphere": rs.Sphere(1.0),
    "flat": rs.FlatPunch(0.5),
    "flat-ended": rs.TruncatedCone(0.05, 1.4),
    "ellipse": rs.Ellipsoid(3.0, 0.5),
}


def impact_of(geometry, velocity=1.0):
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        return rs.solve(rs.Impact(SOLID, geometry, mass=1.0, velocity=velocity), rtol=1e-11)


def rows(shape, random, n, depth, noise=0.0, proportional=False):
    """Forces at random depths, with noise that is constant or proportional to the force."""
    d = random.uniform(0.0, 1.0, n) * depth
    d[random.integers(n)] = depth
    force = 8.0 * SHAPES[shape].force_integral_at_depth(d)
    return d, force + noise * random.standard_normal(n) * (force if proportional else force.max())


def law_of(d, force, **options):
    return rs.ForceLaw(d, force, modulus=MODULUS, poisson_ratio=0.5, **options)


@pytest.mark.parametrize(("shape", "rtol"), [(shape, 1e-5 if shape == "flat-ended" else 1e-9) for shape in SHAPES])
def test_forces_without_noise_give_the_impact_of_the_body(shape, rtol):
    # The contact radius of the flat-ended tip bends within a depth of b cot(alpha): 40 rows resolve it to 1e-5.
    random, exact = np.random.default_rng(7), impact_of(SHAPES[shape])
    for n in (40, 400):
        law = law_of(*rows(shape, random, n, 1.3 * exact.max_indentation_depth))
        result = impact_of(law)
        assert result.restitution_coefficient == pytest.approx(exact.restitution_coefficient, rel=rtol)
        assert result.max_force == pytest.approx(exact.max_force, rel=10 * rtol)


@pytest.mark.parametrize(
    "shape", [pytest.param(shape, marks=pytest.mark.slow if n % 2 else ()) for n, shape in enumerate(SHAPES)]
)
def test_noise_changes_the_impact_by_the_error_that_the_fit_states(shape):
    random, exact = np.random.default_rng(11), impact_of(SHAPES[shape])
    shares, errors = [], []
    for proportional in (False, True) * 2:
        n = int(random.integers(40, 401))
        depth = exact.max_indentation_depth * random.uniform(1.1, 2.0)
        law = law_of(*rows(shape, random, n, depth, 1e-4, proportional))
        off = abs(impact_of(law).restitution_coefficient / exact.restitution_coefficient - 1)
        shares.append(off / law.fit.error)
        errors.append(law.fit.error)
        # Most of the noise averages out; a flat-ended tip needs more coefficients.
        assert 1e-4 / math.sqrt(n) / 5 < law.fit.error < 3e-4
        assert law.fit.misfit == pytest.approx(1e-4, rel=0.8)
    # The error is one standard error of the force where it is largest, and e is less sensitive than the force.
    assert np.median(shares) < 1.0
    assert max(shares) < 3.0


def test_covariance_is_that_of_least_squares():
    random, ratios = np.random.default_rng(12), []
    for _ in range(20):
        depth = np.sort(random.uniform(0.01, 1.0, 200))
        depth[-1] = 1.0
        force = depth**1.5 + 1e-3 * random.standard_normal(200)
        fit = fit_force(depth, force, 1.5)
        if fit.degree == 0:
            # One coefficient of x^3, x = sqrt(d): its variance is that of the noise over the sum of x^6.
            ratios.append(float(fit.covariance[0, 0]) * float(np.sum(depth**3)) / 1e-6)
    assert len(ratios) > 10
    # Each has a standard deviation of about 0.15; leverages add a per cent.
    assert np.mean(ratios) == pytest.approx(1.0, abs=0.15)


def test_error_covers_other_fits_that_are_nearly_as_likely():
    spreads = []
    for seed in range(6):
        law = law_of(*rows("sphere", np.random.default_rng(seed), 60, 0.5, 1e-3))
        spreads.append(law.fit.spread)
        assert law.fit.error >= law.fit.spread
    # Sixty rows with this noise do not decide between degrees.
    assert np.median(spreads) > 0.0


@pytest.mark.parametrize("shape", SHAPES)
def test_force_and_stiffness_of_the_fit(shape):
    body, depth = SHAPES[shape], 0.4
    d, force = rows(shape, np.random.default_rng(5), 200, depth)
    law = law_of(d, force)
    inside = np.linspace(0.01, 1.0, 50) * depth
    rtol = 1e-3 if shape == "flat-ended" else 1e-9
    assert law.stiffness_radius(inside) == pytest.approx(
        body.stiffness_radius(inside), abs=rtol * float(body.stiffness_radius(depth))
    )
    expected = body.force_integral_at_depth(inside)
    assert law.force_integral_at_depth(inside) == pytest.approx(expected, abs=1e-2 * rtol * float(expected[-1]))
    assert np.diff(law.stiffness_radius(inside)).min() > -1e-6 * float(body.stiffness_radius(depth))
    assert law.stiffness_radius(-1.0) == law.force_integral_at_depth(-1.0) == 0.0
    assert law.fit.residual.shape == d.shape


def test_stiffness_is_the_derivative_of_the_force():
    law = law_of(*rows("sphere", np.random.default_rng(1), 60, 0.4, 1e-4))
    d, step = np.linspace(0.05, 0.35, 7), 1e-5
    slope = (law.force_integral_at_depth(d + step) - law.force_integral_at_depth(d - step)) / (2 * step)
    assert law.stiffness_radius(d) == pytest.approx(slope, rel=1e-7)


@pytest.mark.parametrize(
    ("shape", "exponent"), [("parabola", 1.5), ("cone", 2.0), ("flat", 1.0), ("sphere", 1.5), ("ellipse", 1.5)]
)
def test_exponent_is_found(shape, exponent):
    for noise in (0.0, 1e-4):
        law = law_of(*rows(shape, np.random.default_rng(2), 200, 0.3, noise))
        assert law.fit.exponent == pytest.approx(exponent, abs=0.01)


def test_other_exponents_are_fitted_or_given():
    d = np.random.default_rng(3).uniform(0.0, 0.5, 100)
    quartic = rs.PowerLaw(4, 1.0)
    law = law_of(d, 8 * quartic.force_integral_at_depth(d))
    assert law.fit.exponent == pytest.approx(1.25, rel=1e-10)
    assert law.fit.degree == 0
    other = law_of(d, 8 * quartic.force_integral_at_depth(d), exponent=1.25)
    assert other.fit.degree == 0
    assert other.fit.misfit < 1e-14
    assert other.fit.covariance.shape == (1, 1)


def test_rows_in_any_order_and_at_depth_0():
    random = np.random.default_rng(4)
    d, force = rows("sphere", random, 80, 0.3, 1e-4)
    order = random.permutation(80)
    law, same = law_of(d, force), law_of(np.append(0.0, d[order]), np.append(0.0, force[order]))
    assert same.fit.degree == law.fit.degree
    assert same.fit.coefficients == pytest.approx(law.fit.coefficients, rel=1e-9)
    assert law == law_of(d.tolist(), force)
    assert hash(law) == hash(law_of(d, force))
    assert law != same


def test_units_and_tables():
    pandas, pint = pytest.importorskip("pandas"), pytest.importorskip("pint")
    unit = pint.UnitRegistry()
    d, force = rows("parabola", np.random.default_rng(6), 50, 0.3)
    table = pandas.DataFrame({"depth": d, "force": force})
    assert law_of(table.depth, table["force"]) == law_of(d, force)
    scaled = rs.ForceLaw(
        1e3 * d * unit.mm, 1e-3 * force * unit.kN, modulus=1e-3 * MODULUS * unit.kPa, poisson_ratio=0.5
    )
    assert scaled.stiffness_radius(0.1) == pytest.approx(float(law_of(d, force).stiffness_radius(0.1)), rel=1e-9)


def test_depths_beyond_the_data():
    exact = impact_of(SHAPES["parabola"])
    law = law_of(*rows("parabola", np.random.default_rng(8), 40, 0.5 * exact.max_indentation_depth))
    assert named(lambda: impact_of(law)) == ("profile",)
    with pytest.raises(rs.InputError, match="where the data end"):
        law.stiffness_radius(exact.max_indentation_depth)
    many = impact_of(law, [0.1, 1.0])
    assert many.status.tolist() == [rs.Status.SEPARATED, rs.Status.TOO_DEEP]


def test_materials():
    law = law_of(*rows("parabola", np.random.default_rng(10), 40, 0.5))
    assert in_one_line(lambda: rs.Impact(SOLID, law, 1.0, 0.1, counter_material=SOLID)).field == "counter_material"
    with pytest.warns(RestitutionWarning, match="0.5 for the twin and 0.3"):
        rs.Impact(rs.standard_solid(1.0, 1.0, 1.0, poisson_ratio=0.3), law, 1.0, 0.1)


@pytest.mark.parametrize(("ratio", "warns"), [(0.4955, False), (0.4945, True)])
def test_a_poisson_ratio_within_0_005_of_the_twin_is_the_same(ratio, warns):
    law = law_of(*rows("parabola", np.random.default_rng(10), 40, 0.5))
    shear = rs.PronySeries(1.0, [2.0], [0.1])
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        rs.Impact(rs.Material(shear, shear.scaled(2 * (1 + ratio) / (3 * (1 - 2 * ratio)))), law, 1.0, 0.1)
    assert bool(caught) == warns


def test_the_instantaneous_poisson_ratio_counts_too():
    law = law_of(*rows("parabola", np.random.default_rng(10), 40, 0.5))
    with pytest.warns(RestitutionWarning, match=r"\(static\) to 0\.4945 \(instantaneous\)"):
        # G/K = 3 (1 - 2 nu)/(2 (1 + nu)) at each end.
        rs.Impact(rs.Material(rs.PronySeries(1.0, [9.0], [0.1]), 10.0 * 2 * 1.4945 / (3 * 0.011)), law, 1.0, 0.1)


def test_a_poisson_ratio_between_equal_ends_counts_too():
    # (3K - 2G)/(6K + 2G) is 0.35 at both ends, where K = 3 G, and 0.2273 for G = 2 and K = 3.
    law = law_of(*rows("parabola", np.random.default_rng(10), 40, 0.5))
    material = rs.Material(rs.PronySeries(1.0, [1.0], [1e2]), rs.PronySeries(3.0, [3.0], [1e-4]))
    with pytest.warns(
        RestitutionWarning, match=r"0\.35 \(instantaneous\) for the material, 0\.227\d to 0\.35 between"
    ):
        rs.Impact(material, law, 1.0, 0.1)


def test_picture():
    law = law_of(*rows("sphere", np.random.default_rng(12), 60, 0.5, 1e-4))
    left, right = law.plot().axes
    assert [line.get_label() for line in left.lines] == ["data", "$d^{1.5}$, degree 2"]
    assert right.lines[0].get_ydata() == pytest.approx(law.fit.residual)


def spoiled(name, place, value):
    def change(columns):
        columns[name] = np.array(columns[name])
        columns[name][place] = value(columns[name][place])

    return change


@pytest.mark.parametrize(
    ("change", "field", "index", "text"),
    [
        (spoiled("force", 17, lambda f: 100 * f), "force", (17,), "beyond the force at the largest depth"),
        (spoiled("force", 47, lambda f: 2.3 * f), "force", (47,), "beyond"),
        (spoiled("force", 47, lambda f: 1.9 * f), "force", (47,), "off a smooth curve"),
        (spoiled("force", 17, lambda f: 1.1 * f), "force", (17,), "smooth"),
        (spoiled("force", 5, lambda f: math.nan), "force", (5,), ""),
        (spoiled("depth", 5, lambda d: math.inf), "depth", (5,), ""),
        (spoiled("depth", 5, lambda d: -d), "depth", (5,), "from first touch"),
        (spoiled("depth", 5, lambda d: 1e-3 * d), "force", (5,), ""),
        (lambda c: c.update(force=np.sin(4.5 * c["depth"])), "force", (49,), "never fall"),
        (lambda c: c.update(force=np.sqrt(c["depth"])), "force", None, "never fall"),
        (lambda c: c.update(force=c["depth"] - 0.1 * c["depth"] ** 2), "force", None, "never fall"),
        (lambda c: c.update(force=-c["force"]), "force", (49,), "must be > 0 in indentation"),
        (lambda c: c.update(depth=np.append(0, c["depth"]), force=np.append(0.4, c["force"])), "force", (0,),
         "must be 0 at depth 0"),
        (lambda c: c.update(depth=c["depth"] + 0.6), "depth", (), "at most 0.25 times the largest"),
        (lambda c: c.update(depth=1e3 * c["depth"]), "depth, force, modulus", (), "compare the units"),
        (lambda c: c.update(modulus=1e12), "depth, force, modulus", (), "compare the units"),
        (lambda c: c.update(depth=c["depth"][:9], force=c["force"][:9]), "depth", (), "at least 10"),
        (lambda c: c.update(depth=np.repeat(c["depth"][::10], 10)), "depth", (), "at least 10"),
        (lambda c: c.update(depth=c["depth"][1:]), "depth, force", (), "equal length"),
        (lambda c: c.update(depth=np.ma.masked_greater(c["depth"], 0.49)), "depth", (49,), ""),
        (lambda c: c.update(depth=["1 mm"] * 50), "depth", (), ""),
        (lambda c: c.update(modulus=0.0), "modulus", (), ""),
        (lambda c: c.update(modulus=[1.0, 2.0]), "modulus", (), ""),
        (lambda c: c.update(poisson_ratio=0.6), "poisson_ratio", (), ""),
        (lambda c: c.update(poisson_ratio=-1.0), "poisson_ratio", (), ""),
        (lambda c: c.update(exponent=0.9), "exponent", (), ""),
    ],
)  # fmt: skip
def test_bad_input_is_refused(change, field, index, text):
    d = np.linspace(0.01, 0.5, 50)
    columns = {"depth": d, "force": 8 * SHAPES["sphere"].force_integral_at_depth(d), "modulus": 3.0,
               "poisson_ratio": 0.5}  # fmt: skip
    assert rs.ForceLaw(**columns).fit.misfit < 1e-13
    change(columns)
    caught = in_one_line(lambda: rs.ForceLaw(**columns))
    assert caught.field == field
    assert index is None or caught.index == index
    assert text in str(caught)


def test_noise_of_three_per_cent_is_refused():
    with pytest.raises(rs.InputError, match="must be smooth") as caught:
        law_of(*rows("parabola", np.random.default_rng(13), 100, 0.5, 0.03))
    assert caught.value.index


def test_rubber_disc_of_finite_elements():
    # Static forces (validation/force_law.py) for E = 1, nu = 0.45, radius 1.16, height 1, on a frictionless base, and e
    # of the impact by finite elements in time (layers.md, section 3): 0.221920 + 1e-6, each to half a digit.
    table = np.loadtxt(DISC, delimiter=",", skiprows=1)
    law = rs.ForceLaw(*table.T, modulus=1.0, poisson_ratio=0.45)
    series = rs.PronySeries(1.0, [10.0], [0.1])
    rubber = rs.Material(series, series.scaled(2 * 1.45 / (3 * 0.1)))
    assert rubber.instantaneous_poisson_ratio == pytest.approx(0.45)
    result = rs.solve(rs.Impact(rubber, law, mass=1.0, velocity=1.0))
    assert result.restitution_coefficient == pytest.approx(0.221921, abs=1.5e-6)
