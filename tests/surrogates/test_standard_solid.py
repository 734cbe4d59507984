"""Interpolant of the paper's restitution coefficient against the exact method at other points."""

import math
from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest

import restitution as rs
from checkout import script
from refusals import named
from restitution.impact.closed_forms import equivalent_incompressible_p3
from restitution.surrogates import standard_solid as plane
from restitution.surrogates.standard_solid import STATED_ERROR

make = script("validation/standard_solid_surrogate.py")
TABLE = Path(__file__).parents[1] / "data" / "standard_solid.csv"
DATA = Path(plane.__file__).parent / "data" / "standard_solid.npz"


def exact(nu, p2, p3):
    return rs.standard_solid_restitution(nu, p2, p3, rtol=1e-9)


@pytest.mark.parametrize("n", [6000, pytest.param(200_000, marks=pytest.mark.slow)])
def test_error_is_below_the_stated_error(n):
    groups = make.random_groups(n, seed=n)
    assert np.abs(rs.standard_solid_surrogate(*groups) - exact(*groups)).max() <= STATED_ERROR


def test_error_at_the_edges_of_the_plane():
    rng = np.random.default_rng(8)
    n = 2000
    nu, p2, p3 = make.random_groups(n, seed=4)
    side = rng.integers(0, 3, n)
    high = rng.integers(0, 2, n)
    nu = np.where(side == 0, np.array([-1.0, 0.5])[high], nu)
    p2 = np.where(side == 1, np.array(plane.P2)[high], p2)
    p3 = np.where(side == 2, np.array(plane.P3)[high], p3)
    assert np.abs(rs.standard_solid_surrogate(nu, p2, p3) - exact(nu, p2, p3)).max() <= STATED_ERROR


def test_rows_of_the_reference_table():
    rows = np.genfromtxt(TABLE, delimiter=",", names=True)
    nu, p2, p3, e = (rows[name] for name in ("nu", "p2", "p3", "restitution"))
    inside = (p2 >= 1e-3) & (p2 <= 10.0) & (p3 >= 1e-2) & (p3 <= 100.0)
    assert inside.sum() >= 8
    interpolated = rs.standard_solid_surrogate(nu[inside], p2[inside], p3[inside])
    assert interpolated == pytest.approx(e[inside], abs=STATED_ERROR)


def test_bodies_without_bulk_stiffness_are_incompressible_ones_of_a_quarter_of_the_modulus():
    # E*/4 = G/4 for nu = -1: two opposite ends of the table agree.
    p2, p3 = np.meshgrid(np.logspace(-3, 1, 40), np.logspace(-1.5, 2, 40))
    other = equivalent_incompressible_p3(p3)
    assert rs.standard_solid_surrogate(-1.0, p2, p3) == pytest.approx(
        rs.standard_solid_surrogate(0.5, p2, other), abs=2 * STATED_ERROR
    )


def test_values_lie_between_zero_and_one_and_are_continuous():
    nu, p2, p3 = make.random_groups(200_000, seed=2)
    e = rs.standard_solid_surrogate(nu, p2, p3)
    assert e.min() > 0.0
    assert e.max() <= 1.0
    # A line across the faces of boxes, including the face between the halves with different coordinates.
    x = np.linspace(0.0, 1.0, 40_001)
    nu = plane.groups(np.column_stack([x, np.full(x.size, -2.0), np.zeros(x.size)]))[0]
    second_differences = np.diff(rs.standard_solid_surrogate(nu, 0.01, 3.0), 2)
    assert np.abs(second_differences).max() < 2 * STATED_ERROR


def test_shapes_broadcast_and_single_numbers_are_floats():
    assert isinstance(rs.standard_solid_surrogate(0.3, 0.1, 1.0), float)
    picture = rs.standard_solid_surrogate(0.45, np.logspace(-3, 1, 5)[:, None], np.logspace(-2, 2, 7))
    assert picture.shape == (5, 7)
    assert picture[2, 3] == rs.standard_solid_surrogate(0.45, np.logspace(-3, 1, 5)[2], 1.0)
    assert rs.standard_solid_surrogate([], 1.0, 1.0).shape == (0,)
    with pytest.raises(ValueError, match=r"^nu, p2, p3: have shapes that do not broadcast"):
        rs.standard_solid_surrogate([0.1, 0.2], [1.0, 2.0, 3.0], 1.0)


@pytest.mark.parametrize(
    ("arguments", "expected"),
    [
        ((0.6, 1.0, 1.0), ("nu", 0.6)),
        ((0.3, 9e-4, 1.0), ("p2", 9e-4)),
        ((0.3, [1.0, 11.0], 1.0), ("p2", 1, 11.0)),
        ((0.3, 1.0, 101.0), ("p3", 101.0)),
        ((0.3, 1.0, math.nan), ("p3", math.nan)),
    ],
)
def test_nothing_is_extrapolated(arguments, expected):
    assert named(lambda: rs.standard_solid_surrogate(*arguments)) == expected


def test_coordinates_can_be_inverted():
    nu, p2, _ = make.random_groups(200, seed=6)
    nu = np.clip(nu, -0.99, 0.49)
    q = 1.0 + 1.0 / p2
    # r is tau2/tau, which also follows from the reduced modulus of the solid.
    solids = (rs.standard_solid(1.0, 1.0 / a, 1.0, poisson_ratio=b) for a, b in zip(p2, nu, strict=True))
    times = np.array([rs.reduced_modulus(solid).relaxation_times for solid in solids])
    x = np.log(times[:, 1] / times[:, 0]) / np.log(q)
    e = plane.groups(np.column_stack([x, np.log10(p2), np.zeros(200)]))
    assert e[0] == pytest.approx(nu, abs=1e-9)
    assert e[1] == pytest.approx(p2)


def test_the_script_attains_a_given_tolerance(tmp_path):
    reports = []
    boxes = make.make_boxes(1e-2, lambda done, total: reports.append((done, total)))
    assert len(boxes.levels) < 20
    error = make.measured_error(boxes, 3000, seed=1)
    # The script tests 136 points of each box, so that the error may exceed the tolerance by a factor.
    assert 1e-4 < error < 2e-2
    assert all(before[0] <= after[0] for before, after in pairwise(reports))
    assert reports[-1] == (len(boxes.levels), len(boxes.levels))
    for name in ("one.npz", "two.npz"):
        make.write_file(tmp_path / name, boxes, error)
    assert (tmp_path / "one.npz").read_bytes() == (tmp_path / "two.npz").read_bytes()


@pytest.mark.slow
def test_the_script_makes_the_shipped_file(tmp_path, capsys):
    make.main([str(tmp_path / "new.npz")])
    assert "largest error at 200000 random points" in capsys.readouterr().out
    with np.load(DATA) as shipped, np.load(tmp_path / "new.npz") as new:
        assert sorted(shipped) == sorted(new)
        # Other processors round differently and may halve a box that is just within the tolerance here.
        assert abs(len(new["levels"]) - len(shipped["levels"])) <= 3
        assert float(new["error"]) <= STATED_ERROR


def test_the_data_file_is_small_and_part_of_the_package():
    import tomllib

    assert DATA.stat().st_size < 1_000_000
    project = tomllib.loads((Path(__file__).parents[2] / "pyproject.toml").read_text())
    (package,) = project["tool"]["hatch"]["build"]["targets"]["wheel"]["packages"]
    assert DATA.is_relative_to(Path(__file__).parents[2] / package)
    with np.load(DATA) as data:
        assert float(data["error"]) <= STATED_ERROR
