"""Axes and random draws: values, exact ends, pieces, distributions, refused input."""

import pickle
import warnings
from collections.abc import Callable

import numpy as np
import pytest
import xarray as xr
from scipy.stats import qmc

from refusals import in_one_line, named
from restitution.errors import InputTypeError
from restitution.sweeps.grid import Linear, Logarithmic, LogNormal, LogUniform, Normal, Samples, Uniform, read_axis
from restitution.units import unit_registry


def whole(axis: Samples) -> dict[str, np.ndarray]:
    return axis.columns("draw", 0, axis.n)


def test_linear_and_logarithmic_axes_are_those_of_numpy() -> None:
    np.testing.assert_allclose(Linear(-1.0, 0.5, 7).values(0, 7), np.linspace(-1.0, 0.5, 7), rtol=1e-15, atol=1e-16)
    np.testing.assert_allclose(Logarithmic(1e-3, 7.0, 9).values(0, 9), np.geomspace(1e-3, 7.0, 9), rtol=4e-15)


@pytest.mark.parametrize("axis", [Linear(0.1, 0.7, 1001), Logarithmic(1e-7, 0.3, 1001), Logarithmic(5.0, 0.2, 1001)])
def test_ends_are_exact_and_pieces_join(axis: Linear) -> None:
    values = axis.values(0, 1001)
    assert (values[0], values[-1]) == (axis.low, axis.high)
    np.testing.assert_array_equal(np.concatenate([axis.values(0, 17), axis.values(17, 1001)]), values)


def test_an_axis_of_one_value_is_its_lower_end() -> None:
    assert Linear(2.0, 3.0, 1).values(0, 1).tolist() == [2.0]
    assert Logarithmic(2.0, 3.0, 1).values(0, 1).tolist() == [2.0]


# Chunks of any size must join to the Sobol sequence of SciPy.
@pytest.mark.parametrize("n", [64, 100])
def test_sobol_draws_in_pieces_are_those_of_scipy(n: int) -> None:
    axis = Samples(n, {"mass": Uniform(0.0, 1.0), "radius": Uniform(0.0, 1.0)}, rng=3)
    pieces = [axis.columns("draw", start, min(start + 13, n)) for start in range(0, n, 13)]
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", UserWarning)
        points = qmc.Sobol(2, scramble=True, seed=3).random(n)
    for place, name in enumerate(("mass", "radius")):
        np.testing.assert_array_equal(np.concatenate([piece[name] for piece in pieces]), points[:, place])


def test_latin_hypercube_has_one_draw_in_every_stratum() -> None:
    columns = whole(
        Samples(50, {"mass": Uniform(0.0, 1.0), "external_force": Uniform(0.0, 1.0)}, "latin_hypercube", rng=1)
    )
    for values in columns.values():
        assert sorted((values * 50).astype(int).tolist()) == list(range(50))


def test_a_generator_gives_a_seed_that_is_kept() -> None:
    draws = {"mass": Uniform(0.0, 1.0)}
    axis = Samples(16, draws, rng=np.random.default_rng(7))
    assert axis.rng == int(np.random.default_rng(7).integers(2**63))
    np.testing.assert_array_equal(whole(axis)["mass"], whole(Samples(16, draws, rng=axis.rng))["mass"])
    assert Samples(16, draws, rng=None).rng != Samples(16, draws, rng=None).rng


def test_the_seed_determines_the_draws() -> None:
    draws = {"mass": Normal(1.0, 0.1)}
    for method in ("sobol", "latin_hypercube"):
        first, again, other = (whole(Samples(16, draws, method, seed))["mass"] for seed in (1, 1, 2))
        np.testing.assert_array_equal(first, again)
        assert not np.array_equal(first, other)


def test_draws_survive_pickling() -> None:
    axis = Samples(16, {"mass": Normal(1.0, 0.1)}, "latin_hypercube", rng=5)
    before = whole(axis)["mass"]
    copy = pickle.loads(pickle.dumps(axis))
    np.testing.assert_array_equal(whole(copy)["mass"], before)
    assert copy == axis


# Quasi-random means converge as 1/n: for 4096 draws the bounds are ten times smaller than for random ones.
@pytest.mark.parametrize(
    ("distribution", "mean", "deviation"),
    [
        (Uniform(1.0, 3.0), 2.0, 1.0 / np.sqrt(3.0)),
        (LogUniform(1.0, np.e), np.e - 1.0, np.sqrt(0.5 * (np.e**2 - 1.0) - (np.e - 1.0) ** 2)),
        (Normal(5.0, 0.5), 5.0, 0.5),
        (LogNormal(2.0, 0.3), 2.0 * np.exp(0.045), 2.0 * np.exp(0.045) * np.sqrt(np.exp(0.09) - 1.0)),
    ],
)
def test_moments_of_the_draws(distribution: object, mean: float, deviation: float) -> None:
    values = whole(Samples(4096, {"mass": distribution}, rng=2))["mass"]  # type: ignore[dict-item]
    assert values.mean() == pytest.approx(mean, abs=1.5e-3 * deviation)
    assert values.std() == pytest.approx(deviation, rel=5e-3)


@pytest.mark.parametrize("share", [0.0, 1.0 - 2.0**-53])
def test_no_draw_is_infinite(share: float, monkeypatch: pytest.MonkeyPatch) -> None:
    """Shares of 0 and almost 1 occur once in 2^30 draws."""
    monkeypatch.setattr(qmc.Sobol, "random", lambda self, n: np.full((n, self.d), share))
    draws = Samples(4, {"mass": LogNormal(1.0, 0.1), "external_force": Normal(10.0, 0.1)}, rng=1).columns("draw", 0, 4)
    for values in draws.values():
        assert np.all(np.isfinite(values))
    # The quantile of 2^-31 is 6.2 standard deviations from the mean.
    assert abs(draws["external_force"][0] - 10.0) == pytest.approx(0.62, abs=0.01)


def test_a_normal_distribution_stays_in_the_range_of_its_quantity() -> None:
    values = whole(Samples(1024, {"mass": Normal(0.1, 0.1)}))["mass"]
    assert values.min() > 0.0
    # The distribution is truncated at zero: P(X < 0.1 | X > 0).
    assert np.mean(values < 0.1) == pytest.approx(0.3413447 / 0.8413447, abs=2e-3)
    ratios = whole(Samples(1024, {"nu": Normal(0.49, 0.05)}))["poisson_ratio"]
    assert -1.0 <= ratios.min() < ratios.max() <= 0.5


@pytest.mark.parametrize(
    ("make", "expected"),
    [
        (lambda: Linear(0.0, np.inf, 3), ("high", np.inf)),
        (lambda: Linear(0.0, 1.0, 0), ("n", 0)),
        (lambda: Linear(0.0, 1.0, 10**18), ("n", 10**18)),
        (lambda: Linear(0.0, 1.0, 2.5), ("n", 2.5)),
        (lambda: Logarithmic(0.0, 1.0, 3), ("low", 0.0)),
        (lambda: Samples(4, {"mass": Uniform(1.0, 2.0)}, "halton"), ("method", "halton")),
        (lambda: Samples(4, {"mass": Uniform(1.0, 2.0)}, rng=-1), ("rng", -1)),
        (lambda: Samples(2**31, {"mass": Uniform(1.0, 2.0)}), ("n", 2**31)),
        (lambda: Normal(1.0, 0.0), ("standard_deviation", 0.0)),
        (lambda: read_axis("mass", [1.0, -1.0]), ("mass", 1, -1.0)),
        (lambda: read_axis("mass", Linear(1.0, -1.0, 5)), ("mass", -1.0)),
        (lambda: read_axis("mass", 0.0), ("mass", 0.0)),
        (lambda: read_axis("mass", []), ("mass",)),
    ],
)
def test_invalid_numbers_are_refused(make: Callable[[], object], expected: tuple[object, ...]) -> None:
    assert named(make) == expected


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (lambda: Samples(4, {}), "distributions: must name at least one quantity"),
        (lambda: Samples(4, {"mass": 3}), "mass = 3: must be a distribution$"),
        (lambda: Samples(4, {"mass": Uniform(-1.0, 2.0)}), r"mass = Uniform\(.*\): must lie in \[0, inf\]"),
        (lambda: Samples(4, {"nu": LogNormal(0.3, 0.1)}), "poisson_ratio = LogNormal.*take all positive values"),
        (lambda: Samples(4, {"mass": Normal(-1.0, 0.1)}), r"mass = Normal\(.*\): lies mostly outside \[0, inf\]"),
        (lambda: Uniform(2.0, 1.0), "low = 2: must be < high = 1"),
        (lambda: read_axis("mass", np.ones((2, 2))), r"mass: must be one-dimensional .* \(2, 2\)"),
    ],
)
def test_invalid_axes_are_refused(make: Callable[[], object], message: str) -> None:
    with pytest.raises(ValueError, match=f"^{message}"):
        make()


@pytest.mark.parametrize(
    "entry", ["abc", None, [1.0, "2 m/s"], [True], np.ma.array([1.0, 2.0], mask=[False, True]), {"n": 3}]
)
def test_axes_that_are_no_numbers_are_refused(entry: object) -> None:
    assert in_one_line(lambda: read_axis("velocity", entry), TypeError).field == "velocity"


def test_values_with_units_are_converted() -> None:
    meters = unit_registry().Quantity
    axis = read_axis("velocity", meters([1.0, 250.0], "cm/s"))
    assert axis.items.tolist() == pytest.approx([0.01, 2.5])
    assert read_axis("mass", meters(5.0, "g")) == pytest.approx(0.005)
    labelled = xr.DataArray([1.0, 2.0], dims="x", attrs={"units": "mm"})
    assert read_axis("radius", labelled).items.tolist() == pytest.approx([1e-3, 2e-3])
    assert in_one_line(lambda: read_axis("velocity", meters([1.0], "kg"))).field == "velocity"


def test_an_argument_of_a_function_takes_objects_and_numbers() -> None:
    assert read_axis("shape", "round") == "round"
    assert read_axis("shape", ["round", "flat"]).size == 2
    assert read_axis("size", np.array([1.0, 2.0])).items.tolist() == [1.0, 2.0]
    with pytest.raises(InputTypeError):
        read_axis("size", np.ma.array([1.0, 2.0], mask=[False, True]))


def test_labels_of_objects_are_distinct() -> None:
    class Named:
        def __init__(self, name: str) -> None:
            self.name = name

    listed = read_axis("item", [Named("rubber"), Named("rubber"), {"name": "steel"}, "cone", object(), {"shear": 1.0}])
    assert listed.labels("counter_material") == [
        "rubber (1)",
        "rubber (2)",
        "steel",
        "cone",
        "counter material 5",
        "counter material 6",
    ]


def test_materials_without_a_name_are_labelled_by_their_source() -> None:
    listed = read_axis("item", [{"library": "epoxy"}, {"library": "epoxy", "name": "resin"}, {"file": "dma.csv"}])
    assert listed.labels("material") == ["epoxy", "resin", "dma.csv"]
