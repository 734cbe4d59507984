"""The window of a material on the command line: all commands refuse contacts outside of it, or warn."""

import json
import re
from pathlib import Path

import numpy as np
import pytest
from scipy.optimize import brentq

import restitution as rs
from cases import case_file, press_file
from commands import done, refused, run

# A steel-like elastic material that is known for a short time only: its contacts have closed forms.
RNG = np.random.default_rng(61)
SHEAR, RADIUS, MASS = (float(x) for x in np.exp(RNG.uniform(np.log([1e5, 2e-3, 1e-4]), np.log([1e7, 2e-2, 1e-2]))))
LOW = 1e-4
BODY = f"mass = {MASS!r}\nradius = {RADIUS!r}"
ELASTIC = f'model = "elastic"\nshear_modulus = {SHEAR!r}\npoisson_ratio = 0.5\nwindow = "[0.1, 1000] ms"'


def hertz(velocity: float) -> tuple[float, float]:
    """Largest depth [m] and duration [s] of an elastic impact (K. L. Johnson, Contact Mechanics, section 11.4)."""
    reduced = 2.0 * SHEAR / (1.0 - 0.5)
    depth = (15.0 * MASS * velocity**2 / (16.0 * np.sqrt(RADIUS) * reduced)) ** 0.4
    return depth, 2.9432751843247043 * depth / velocity


FASTEST = brentq(lambda v: hertz(v)[0] / (3.0 * v) - LOW, 1e-12, 1e12)
"""Velocity [m/s] at which the beginning of the contact, a third of depth over velocity, is the start of the window."""


@pytest.fixture(autouse=True)
def _files(folder: Path) -> None:
    ball = {"body": BODY, "material": ELASTIC, "impact": f"velocity = {3.0 * FASTEST!r}"}
    case_file("ball.toml", **ball)
    case_file("sweep.toml", **ball, axes=f"velocity = [{FASTEST / 3.0!r}, {3.0 * FASTEST!r}]")
    program = f'depth = {1e-3 * RADIUS!r}\nshape = "triangle"\nloading_time = "10 s"'
    press_file("indent.toml", profile=f"radius = {RADIUS!r}", material=ELASTIC, indentation=program)


RANGE = ("--velocity", f"{FASTEST / 3.0!r}", f"{3.0 * FASTEST!r}")
COMMANDS = {
    "solve": ("solve", "ball.toml"),
    "calibrate": ("calibrate", "ball.toml", "--target", "liggghts", *RANGE),
    "law": ("export", "ball.toml", "--to", "law.h"),
    "reduced law": ("export", "ball.toml", "--to", "law.json", "--terms", "1", *RANGE),
    "table": ("export", "ball.toml", "--to", "table.csv", *RANGE),
    "surrogate": ("surrogate", "ball.toml", "--rtol", "1e-3", *RANGE),
    "bounce": ("bounce", "ball.toml"),
}
OTHERS = {
    "map": (
        "map", "ball.toml", "--x", f"velocity={2.0 * FASTEST}:{3.0 * FASTEST}", "--y", f"radius={RADIUS}:{2.0 * RADIUS}",
        "--points", "3",
    ),
    "sweep": ("sweep", "sweep.toml", "--out", "sweep.csv"),
    "indent": ("indent", "indent.toml"),
}  # fmt: skip


@pytest.mark.parametrize("name", [*COMMANDS, *OTHERS])
def test_contacts_outside_the_window_are_refused_in_one_line(name: str) -> None:
    before = sorted(path.name for path in Path().iterdir())
    message = refused(*(COMMANDS | OTHERS)[name])
    assert message.startswith("velocity" if name in COMMANDS else "window")
    assert "the material is known from 0.0001 s to 1 s" in message
    assert "--extrapolate" in message
    assert sorted(path.name for path in Path().iterdir()) == before


@pytest.mark.parametrize("name", [*COMMANDS, *OTHERS])
def test_extrapolate_goes_beyond_and_warns(name: str) -> None:
    answer = done(*(COMMANDS | OTHERS)[name], "--extrapolate")
    assert len([line for line in answer.stderr.splitlines() if line.startswith("warning: window: ")]) == 1


@pytest.mark.parametrize("name", [name for name in COMMANDS if name != "bounce"])
def test_the_admissible_velocities_are_those_of_hertz(name: str) -> None:
    """Three digits, rounded towards the admissible side."""
    line = run(*COMMANDS[name]).stderr
    limit = float(re.search(r"must be (?:<= |in \[\S+, )([^\s\]]+)", line)[1])
    assert 0.99 * FASTEST < limit <= FASTEST * (1.0 + 1e-5)
    case = Path("ball.toml").read_text().replace(repr(3.0 * FASTEST), repr(limit))
    Path("ball.toml").write_text(case)
    assert "window" not in done("solve", "ball.toml").stderr


def test_a_velocity_that_is_too_low_has_a_lower_limit() -> None:
    """A contact of 3 ms is the longest that is known here."""
    slowest = brentq(lambda v: hertz(v)[1] - 3e-3, 1e-15, 1e12)
    material = ELASTIC.replace("1000]", "3]")
    case_file("ball.toml", body=BODY, material=material, impact=f"velocity = {0.5 * slowest!r}")
    line = run("solve", "ball.toml").stderr
    limit = float(re.search(r"must be (?:>= |in \[)([^\s,]+)", line)[1])
    assert slowest * (1.0 - 1e-5) <= limit < 1.01 * slowest


def test_no_velocity_is_admissible_in_a_narrow_window() -> None:
    case = Path("ball.toml").read_text().replace("1000] ms", "0.2] ms")
    Path("ball.toml").write_text(case)
    assert "no velocity is admissible" in run("solve", "ball.toml").stderr


def test_a_store_that_was_refused_is_whole() -> None:
    assert run("sweep", "sweep.toml", "--out", "v.zarr").exit_code == 2
    answer = run("sweep", "sweep.toml", "--out", "v.zarr", "--extrapolate", "--json")
    assert json.loads(answer.stdout)["from_before"] == 2


def test_the_same_in_python() -> None:
    material = rs.Material(SHEAR, np.inf, window=(LOW, 1.0))
    impact = rs.Impact(material, rs.Parabola(RADIUS), MASS, np.array([FASTEST / 3.0, 3.0 * FASTEST]))
    speeds = FASTEST / 3.0, 3.0 * FASTEST
    single = rs.Impact(material, rs.Parabola(RADIUS), MASS, 1.0)
    for call in (
        lambda **options: rs.calibrate(single, "mujoco-solref", speeds, **options),
        lambda **options: rs.surrogate(single, speeds, 1e-3, **options),
        lambda **options: rs.contact_law(impact).reduced(1, **options),
    ):
        with pytest.raises(rs.InputError, match=r"^velocity.* extrapolate=True"):
            call()
        result = call(extrapolate=True)
        assert any("window" in warning for warning in getattr(result, "warnings", ["window"]))


def test_a_file_does_not_widen_the_window_of_its_data() -> None:
    times = np.geomspace(1e-3, 1.0, 30)
    Path("data.csv").write_text(
        "time [s],relaxation modulus [Pa]\n" + "\n".join(f"{t},{1e6 + 2e6 * np.exp(-t / 0.03)}" for t in times)
    )
    material = 'file = "data.csv"\ndeformation = "shear"\npoisson_ratio = 0.5\n'
    ball = {"body": BODY, "impact": "velocity = 0.1"}
    case_file("ball.toml", **ball, material=material + "window = [1e-6, 10.0]")
    message = refused("solve", "ball.toml", "--extrapolate")
    assert message.startswith("ball.toml: material.window = [1e-06, 10.0]: must lie within")
    case_file("ball.toml", **ball, material=material + "window = [0.01, 0.5]")
    assert "known from 0.01 s to 0.5 s" in run("solve", "ball.toml", "--extrapolate").stderr
