"""Measured points on the curve of e over velocity: pictures and commands."""

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import restitution as rs
from cases import BALL, case_file
from commands import done, refused
from refusals import named

pytestmark = [pytest.mark.usefixtures("folder"), pytest.mark.filterwarnings("ignore:small strain")]

SPEEDS, VALUES = [0.02, 0.3, 2.0], [0.9, 0.8, 0.71]


def points_file(name: str = "points.csv", text: str = "") -> str:
    rows = "\n".join(f"{v},{e},0.01" for v, e in zip(SPEEDS, VALUES, strict=True))
    Path(name).write_text(text or f"v [m/s],e,sd_e\n{rows}\n")
    return name


def test_points_are_read_as_velocities_or_heights() -> None:
    points = rs.read_points(points_file())
    assert (points.velocity.tolist(), points.restitution_coefficient.tolist()) == (SPEEDS, VALUES)
    assert points.deviation.tolist() == [0.01] * 3
    heights = rs.read_points(points_file("h.csv", "drop height [cm];rebound height [cm];note\n100;81;1\n25;9;2\n"))
    # A fall in vacuum: v = sqrt(2 g h), e = sqrt(h2/h1).
    assert heights.velocity == pytest.approx(np.sqrt(2 * 9.80665 * np.array([1.0, 0.25])))
    assert heights.restitution_coefficient == pytest.approx([0.9, 0.6])
    assert heights.deviation is None
    camera = rs.read_points(points_file("v.csv", "v_in [m/s],v_out [m/s]\n2,1.5\n1,0.8\n"))
    assert camera.restitution_coefficient == pytest.approx([0.75, 0.8])
    stuck = rs.read_points(points_file("s.csv", "v,e\nm/s,\n0.1,0\n1,0.5\n"))
    assert stuck.restitution_coefficient.tolist() == [0.0, 0.5]


@pytest.mark.parametrize(
    "text", ["t,E\ns,Pa\n1,2\n", "v,e\nm/s,\n0,0.5\n", "v,e\nm/s,\n1,-0.5\n", "v,e\nm/s,\n1,50\n", "v,e\nm/s,\n1,x\n"]
)
def test_other_tables_are_refused_with_their_name(text: str) -> None:
    points_file("bad.csv", text)
    with pytest.raises(rs.InputError, match=r"bad\.csv") as caught:
        rs.read_points("bad.csv")
    assert "\n" not in str(caught.value)


def test_the_curve_holds_the_own_velocity_and_all_points() -> None:
    points = rs.read_points(points_file())
    (ax,) = rs.plot_restitution(BALL, points).axes
    curve, points, *_ = ax.lines
    exact = rs.solve(BALL).restitution_coefficient
    assert (points.get_xdata()[0], points.get_ydata()[0]) == (1.0, pytest.approx(float(exact), rel=1e-9))
    low, high = ax.get_xlim()
    assert low < SPEEDS[0] < SPEEDS[-1] < high
    assert curve.get_xdata()[0] < SPEEDS[0]
    measured = ax.containers[0].lines[0]
    assert measured.get_ydata().tolist() == VALUES
    some = float(curve.get_xdata()[20])
    assert curve.get_ydata()[20] == pytest.approx(
        float(rs.solve(replace(BALL, velocity=some)).restitution_coefficient), rel=1e-8
    )
    assert named(lambda: rs.plot_restitution(rs.Impact(BALL.material, BALL.profile, 0.01, [1.0, 2.0]))) == ("impact",)
    line = rs.plot_restitution(BALL, velocity=[0.5, 2.0]).axes[0].lines[0]
    assert line.get_xdata().tolist() == [0.5, 2.0]


def test_solve_draws_the_points_and_says_how_far_they_are() -> None:
    case_file("ball.toml")
    answer = done("solve", "ball.toml", "--plot", "p.svg", "--points", points_file())
    assert "measured" in Path("p.svg").read_text()
    impact = rs.read_case("ball.toml").impact
    errors = [
        float(rs.solve(replace(impact, velocity=v)).restitution_coefficient) - e
        for v, e in zip(SPEEDS, VALUES, strict=True)
    ]
    size = float(np.sqrt(np.mean(np.square(errors))))
    assert f"computed minus measured e is {size:.3g}" in answer.stderr
    assert refused("solve", "ball.toml", "--points", "points.csv") == "--points: give --plot FILE as well"
    assert "--pressure-at" in refused(
        "solve", "ball.toml", "--points", "points.csv", "--plot", "p.svg", "--pressure-at", "1 us"
    )
    assert "nothing.csv" in refused("solve", "ball.toml", "--points", "nothing.csv", "--plot", "p.svg")


def test_a_sweep_over_velocity_takes_points_and_another_one_refuses_them() -> None:
    axes = '[axes]\nvelocity = { logarithmic = ["1 cm/s", "10 m/s"], n = 9 }\n'
    Path("sweep.toml").write_text(case_file(impact=None) + axes)
    done("sweep", "sweep.toml", "--out", "v.zarr")
    done("plot", "v.zarr", "--points", points_file(), "--output", "restitution_coefficient", "--out", "p.svg")
    assert Path("p.svg").is_file()
    dataset, points = rs.open_sweep("v.zarr"), rs.read_points("points.csv")
    (ax,) = rs.plot_sweep(dataset, ["restitution_coefficient"], points=points).axes
    measured = ax.containers[0].lines[0]
    unit = {"m/s": 1.0, "mm/s": 1e3}[ax.get_xlabel().partition("[")[2].rstrip("]")]
    assert measured.get_xdata() == pytest.approx(unit * np.array(SPEEDS))
    with pytest.raises(rs.InputError, match="points"):
        rs.plot_sweep(dataset, ["contact_time"], points=points)
    answer = done("sweep", "sweep.toml", "--out", "w.csv", "--plot", "w.svg", "--points", "points.csv", "--json")
    assert json.loads(answer.stdout)["picture"] == "w.svg"
    assert "measured" in Path("w.svg").read_text()
    assert "--plot" in refused("sweep", "sweep.toml", "--out", "w.csv", "--points", "points.csv")
