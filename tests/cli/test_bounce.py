"""The command bounce: tables, files and refusals, with made-up numbers that are easy to recognise."""

import csv
import json
import re
from pathlib import Path

import numpy as np
import pytest
import xarray as xr

from cases import case_file
from commands import done, refused, words
from restitution import Case, Validity
from restitution.impact.bounces import Bounces, Ending

SOFT = 'equilibrium_modulus = "1 MPa"\nbranch_modulus = "1 MPa"\nviscosity = "0.1 kPa s"\npoisson_ratio = 0.45\n'


@pytest.fixture(autouse=True)
def _ball(folder: Path) -> None:
    case_file("ball.toml", title="A [bold] ball", material=SOFT, impact='drop_height = "50 mm"')


def fake(monkeypatch: pytest.MonkeyPatch, count: int = 3) -> None:
    """Replace the computation by bounces that halve the height; the body stays after the last one."""
    number = np.arange(1.0, count + 1)
    height = 0.05 * 0.5**number
    stays = number == count

    def computed(case: Case) -> Bounces:
        return Bounces(
            touch_time=0.1 * number,
            velocity=1.0 / number,
            restitution_coefficient=np.where(stays, 0.0, 0.75),
            rebound_velocity=np.where(stays, 0.0, 0.75 / number),
            contact_time=np.where(stays, np.inf, 1e-3 * number),
            residual_indentation_depth=np.where(stays, np.nan, 1e-5),
            height=np.where(stays, 0.0, height),
            drop_height=0.05,
            gravity=9.80665,
            ended=Ending.CAPTURED,
            impact=case.impact,
            validity=Validity(()),
            notes=("recovery: some",),
        )

    monkeypatch.setattr(Case, "bounces", computed)


def test_the_table(monkeypatch: pytest.MonkeyPatch) -> None:
    fake(monkeypatch)
    answer, lines = done("bounce", "ball.toml"), words("bounce", "ball.toml")
    assert answer.stdout.startswith("A [bold] ball, from 50 mm\n")
    # The column before the last is the loss tangent.
    assert ["2", "0.2", "0.5", "0.75", "2", "12.5"] in [line[:-2] + line[-1:] for line in lines]
    assert ["3", "0.3", "0.3333", "0", "stays", "-", "0"] in lines
    assert answer.stdout.splitlines()[-1] == "3 bounces in 0.3 s; captured: the weight holds the body in contact"
    assert answer.stderr == "warning: recovery: some\n"


def test_a_long_table_shows_the_first_and_the_last_bounces(monkeypatch: pytest.MonkeyPatch) -> None:
    fake(monkeypatch, 100)
    shown = [line[0] for line in words("bounce", "ball.toml") if line and re.fullmatch(r"\d+|…", line[0])]
    assert shown[:-1] == [*map(str, range(1, 21)), "…", "97", "98", "99", "100"]


def test_json(monkeypatch: pytest.MonkeyPatch) -> None:
    fake(monkeypatch)
    answer = done("bounce", "ball.toml", "--json")
    content = json.loads(answer.stdout)
    assert answer.stderr == ""
    assert content["height"] == [0.025, 0.0125, 0.0]
    assert content["contact_time"] == [0.001, 0.002, None]
    assert (content["n_bounces"], content["ended"]) == (3, "captured")
    assert (content["drop_height"], content["gravity"]) == (0.05, 9.80665)
    assert content["warnings"] == ["recovery: some"]


def test_files_have_every_bounce_with_units(monkeypatch: pytest.MonkeyPatch) -> None:
    fake(monkeypatch, 100)
    done("bounce", "ball.toml", "--out", "b.csv")
    with Path("b.csv").open() as file:
        header, *lines = csv.reader(file)
    assert header[:3] == ["bounce [1]", "touch_time [s]", "velocity [m/s]"]
    assert len(lines) == 100
    assert [float(x) for x in lines[1][:3]] == [2.0, 0.2, 0.5]
    done("bounce", "ball.toml", "--out", "b.nc")
    with xr.open_dataset("b.nc") as table:
        assert table.height.attrs["units"] == "m"
        np.testing.assert_allclose(table.height[:2], [0.025, 0.0125], rtol=1e-15)
        assert table.attrs["ended"] == "captured"


def test_impossible_files_are_refused_before_the_computation() -> None:
    for arguments in ("ball.toml", "--out", "b.txt"), ("ball.toml", "--plot", "b.txt"), ("other.toml",):
        assert refused("bounce", *arguments).startswith(" ".join(arguments[-2:]))


def test_a_real_ball() -> None:
    answer = done("bounce", "ball.toml", "--json", "--plot", "b.png")
    content = json.loads(answer.stdout)
    height, e, v = (np.array(content[key]) for key in ("height", "restitution_coefficient", "velocity"))
    # v^2 = 2 g h in flight; the rebound starts at the residual depth.
    imprint = np.array(content["residual_indentation_depth"][:3])
    np.testing.assert_allclose(v[0] ** 2, 2 * 9.80665 * 0.05, rtol=1e-14)
    np.testing.assert_allclose(height[:3], ((e * v)[:3] ** 2) / (2 * 9.80665) - imprint, rtol=1e-12)
    assert content["ended"] == "captured"
    assert Path("b.png").read_bytes().startswith(b"\x89PNG")
