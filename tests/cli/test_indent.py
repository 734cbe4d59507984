"""The command indent: tables, files and refusals."""

import csv
import json
import math
from pathlib import Path

import numpy as np
import pytest
import xarray as xr

from cases import TRIANGLE, press_file
from commands import done, refused

GEL = """
name = "gel"
bulk_modulus = "incompressible"
shear = { equilibrium_modulus = 66.66666666666667, branch_moduli = [266.6666666666667], relaxation_times = [0.3] }
"""


def gel(path: str, motion: str) -> None:
    press_file(path, title="A [bold] gel", material=GEL, indentation=f"{motion}\nn_points = 21")


@pytest.fixture(autouse=True)
def _files(folder: Path) -> None:
    gel("gel.toml", TRIANGLE)
    gel("held.toml", 'depth = "1 um"\nshape = "hold"\nduration = "1 s"')


def test_the_table() -> None:
    answer = done("indent", "gel.toml")
    lines = [" ".join(line.split()) for line in answer.stdout.splitlines()]
    assert lines[0] == "A [bold] gel"
    # Forces to nine digits by an independent quadrature: 1.38541713e-9 N.
    assert "largest force F_max 1.38542 nN" in lines
    assert "largest indentation depth d_max 1 µm" in lines
    # sqrt(2.5) um
    assert "largest contact radius a_max 1.58114 µm" in lines
    assert "contact grows until t_m 1 s" in lines
    assert "contact ends at t_end 1.40701 s" in lines
    assert "depth at the end of contact d_end 592.994 nm" in lines
    assert lines[-1] == "prescribed depth, the contact ended within the prescribed history, rtol 1e-08"
    assert answer.stderr.startswith("warning: small strain: max(a/R, d/a) is 0.632, above the limit 0.2")


def test_a_contact_without_an_end() -> None:
    lines = [" ".join(line.split()) for line in done("indent", "held.toml").stdout.splitlines()]
    assert "contact ends at t_end -" in lines
    assert "the bodies were still in contact when the prescribed history ended" in lines[-1]
    content = json.loads(done("indent", "held.toml", "--json").stdout)
    assert content["contact_end_time"] is None
    assert content["status"] == "IN_CONTACT"


def test_json() -> None:
    answer = done("indent", "gel.toml", "--json")
    content = json.loads(answer.stdout)
    assert answer.stderr == ""
    assert content["max_force"] == pytest.approx(1.38541713e-9, rel=3.6e-9)
    assert content["max_contact_radius"] == pytest.approx(math.sqrt(2.5) * 1e-6, rel=1e-12)
    assert (content["status"], content["prescribed"], content["rtol"]) == ("SEPARATED", "depth", 1e-8)
    assert len(content["warnings"]) == 1


def test_histories_have_every_column_with_units() -> None:
    done("indent", "gel.toml", "--history", "h.csv")
    with Path("h.csv").open() as file:
        header, *rows = csv.reader(file)
    columns = "time [s],indentation_depth [m],indentation_velocity [m/s],force [N],contact_radius [m]"
    assert header == columns.split(",")
    numbers = np.array(rows, dtype=float)
    # 21 evenly spaced times, which include the turning point, and the end of the contact.
    assert numbers.shape == (22, 5)
    assert numbers[:, 1] == pytest.approx(1e-6 * (1.0 - np.abs(numbers[:, 0] - 1.0)), abs=1e-20)
    assert numbers[numbers[:, 0] == 1.0, 3] == pytest.approx(1.38541713e-9, rel=3.6e-9)
    done("indent", "gel.toml", "--history", "h.nc")
    with xr.open_dataset("h.nc") as table:
        assert table.force.attrs["units"] == "N"
        np.testing.assert_array_equal(table.force, numbers[:, 3])


def test_a_picture_is_written() -> None:
    done("indent", "gel.toml", "--plot", "gel.png")
    assert Path("gel.png").read_bytes().startswith(b"\x89PNG")


def test_bad_input_ends_with_one_line_and_code_2() -> None:
    gel("again.toml", 'depth = "[0, 3, 2.7, 3] um"\ntime = [0, 1, 1.1, 2]')
    for arguments, message in (
        (("gel.toml", "--plot", "g.txt"), "--plot g.txt: "),
        (("gel.toml", "--history", "g.txt"), "--history g.txt: must end in .csv or .nc"),
        (("other.toml",), "other.toml: "),
        (("again.toml",), "again.toml: indentation.time = 1.1 s: "),
    ):
        assert refused("indent", *arguments).startswith(message)
