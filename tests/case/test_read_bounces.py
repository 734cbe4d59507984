"""Bounces from sounds, labels, instants, heights and speeds."""

import math
import os
import threading
from functools import partial
from pathlib import Path

import numpy as np
import pytest

import restitution as rs
from checkout import EXAMPLES
from commands import done, refused
from refusals import in_one_line

G = 9.80665
WAV = EXAMPLES / "identification" / "bounces.wav"


@pytest.fixture
def write(tmp_path):
    def put(name: str, text: str) -> Path:
        file = tmp_path / name
        file.write_text(text, encoding="utf-8")
        return file

    return put


def test_the_sound_of_the_example_has_the_touches_of_the_ball():
    foam = rs.kelvin_voigt(2e5, 20.0, poisson_ratio=0.5, density=1000.0)
    exact = rs.bounces(rs.drop(rs.Body(foam, radius=0.02), rs.Body(None), height=0.3), max_bounces=9)
    result = rs.read_bounces(
        WAV, radius=0.02, mass=0.03351, contact_time=exact.contact_time[1], air_density=1e-9, drag_coefficient=0.0
    )
    assert np.abs((result.time - 0.5 - exact.touch_time) / result.time_error).max() < 3.0
    inner = slice(1, -1)
    deviation = result.restitution_coefficient[inner] - exact.restitution_coefficient[inner]
    # The depth at separation and the contact times of other bounces are estimates, good to 1e-3.
    assert np.all(np.abs(deviation) < 3.0 * result.restitution_coefficient_error[inner] + 1e-3)
    assert result.observations is not None
    assert result.observations.size == 7
    # The bounce with a contact time has E*' = 4 G of Kelvin and Voigt, within the error of the formula.
    assert result.storage_modulus[1] == pytest.approx(8e5, rel=0.03)
    assert np.isnan(result.storage_modulus[[0, *range(2, 9)]]).all()


@pytest.mark.skipif(not hasattr(os, "mkfifo"), reason="no pipes with a name")
@pytest.mark.parametrize("kind", ["sound", "table", "heights", "empty"])
def test_a_pipe_is_read_as_the_file_whose_content_it_has(kind, tmp_path):
    content = {
        "sound": WAV.read_bytes(), "table": b"time\n0.5\n1.0\n1.4\n1.72\n", "empty": b"",
        "heights": b"drop_height [cm],rebound_height [cm]\n100,81\n90,x\n",
    }[kind]  # fmt: skip
    pipe, file = tmp_path / "pipe", tmp_path / "file"
    os.mkfifo(pipe)
    file.write_bytes(content)
    writer = threading.Thread(target=pipe.write_bytes, args=(content,))
    writer.start()
    try:
        if kind in ("sound", "table"):
            assert np.array_equal(rs.read_bounces(pipe).time, rs.read_bounces(file).time)
        else:
            # No path of a copy is in the message.
            lines = [str(in_one_line(partial(rs.read_bounces, path))) for path in (pipe, file)]
            assert lines[0].replace(str(pipe), str(file)) == lines[1]
    finally:
        writer.join()


def test_labels_and_instants_are_the_same(write):
    time = [0.25, 0.75, 1.15, 1.47]
    labels = "".join(f"{t:.6f}\t{t + 0.01:.6f}\tn\n\\\t100.0\t200.0\n" for t in time)
    rows = "".join(f"{n};{t:.2f}\n".replace(".", ",") for n, t in enumerate(time))
    texts = {"a.txt": labels, "b.csv": "bounce;time (s)\n" + rows, "c.csv": "t [ms]\n250\n750\n1150\n1470\n"}
    for name, text in texts.items():
        result = rs.read_bounces(write(name, text), air_density=0.0)
        assert result.time == pytest.approx(time)
        assert result.restitution_coefficient[1:3] == pytest.approx(0.8)
        assert np.all(np.isnan(result.restitution_coefficient_error))
    errors = rs.read_bounces(write("d.csv", "time [s],sd_time [ms]\n0,1\n0.5,1\n0.9,1\n1.22,1\n"), air_density=0.0)
    share = math.hypot(1e-3 / 0.4, 1e-3 / 0.5, 1e-3 / 0.4 + 1e-3 / 0.5)
    assert errors.restitution_coefficient_error[1] == pytest.approx(0.8 * share)


def test_heights_and_speeds_are_rebounds(write):
    heights = write("h.csv", "drop height [cm],rebound height [cm],sd_rebound_height [mm]\n100,64,10\n50,40.5,10\n")
    speeds = write("v.csv", "v in [cm/s];v_out [m/s]\n200;1,6\n100;0,9\n")
    by_height = rs.read_observations(heights, radius=0.01, mass=0.01)
    assert by_height.velocity == pytest.approx(np.sqrt(2.0 * G * np.array([1.0, 0.5])))
    assert by_height.restitution_coefficient == pytest.approx([0.8, 0.9])
    # e = sqrt(h2/h1): a height that is wrong by a share x makes e wrong by x/2.
    sd = by_height.noise.deviations["restitution_coefficient"]
    assert sd == pytest.approx([0.8 * 0.005 / 0.64, 0.9 * 0.005 / 0.405])
    by_speed = rs.read_observations(speeds, radius=0.01, mass=0.01, kind="rebounds")
    assert by_speed.velocity == pytest.approx([2.0, 1.0])
    assert by_speed.restitution_coefficient == pytest.approx([0.8, 0.9])
    result = rs.read_bounces(heights)
    assert result.restitution_coefficient_error == pytest.approx(sd)
    # tan delta = 0.815 ln(1/e), from docs/theory/identification.md.
    assert result.loss_tangent == pytest.approx(-0.815 * np.log([0.8, 0.9]))
    assert np.all(np.isnan(result.storage_modulus))


def test_the_size_and_a_contact_time_give_moduli(write):
    file = write("m.csv", "v_in,v_out,contact_time [ms]\n1,0.8,1.1\n")
    assert np.isnan(rs.read_bounces(file).storage_modulus[0])
    result, direct = rs.read_bounces(file, radius=0.01, mass=0.03), rs.effective_moduli(
        rs.Rebounds([1.0], [0.8], radius=0.01, mass=0.03, contact_time=[1.1e-3])
    )  # fmt: skip
    assert result.storage_modulus == direct.storage_modulus
    assert result.angular_frequency == direct.angular_frequency


def test_the_command_shows_the_bounces(tmp_path, write):
    text = done("bounces", str(WAV), "--radius", "20 mm", "--plot", str(tmp_path / "a.png")).stdout
    assert len([line for line in text.splitlines() if line.strip()[:1].isdigit() and "(" in line]) == 9
    assert (tmp_path / "a.png").stat().st_size > 10_000
    assert '"restitution_coefficient"' in done("bounces", str(WAV), "--json").stdout
    assert "e" in done("bounces", str(write("h.csv", "drop_height,rebound_height\n1,0.5\n"))).stdout


def test_mistakes_have_one_line(write, tmp_path):
    assert "no such file" in refused("bounces", str(tmp_path / "none.wav"))
    assert "WAV" in refused("bounces", str(write("x.wav", "hello")))
    assert "Audacity" in refused("bounces", str(write("x.mp3", "hello")))
    assert "3 instants" in refused("bounces", str(write("two.csv", "time\n0\n1\n")))
    assert "ascending" in refused("bounces", str(write("back.csv", "time\n0\n1\n0.5\n")))
    assert "contact_time" in refused(
        "bounces", str(write("t.csv", "time\n0\n1\n1.5\n1.6\n")), "--contact-time", "0.1 s"
    )
    assert "contact_time" in refused("bounces", str(write("h.csv", "v_in,v_out\n1,0.5\n")), "--contact-time", "1 ms")
    assert "--radius" in refused("bounces", str(WAV), "--radius", "2 kg")
    for header in ("drop_height,b", "a,b"):
        message = refused("bounces", str(write("half.csv", f"{header}\n1,0.5\n")))
        assert "line 1: must have the columns time, or velocity and restitution_coefficient, or drop" in message
    error = in_one_line(lambda: rs.read_bounces(write("up.csv", "v_in,v_out\n1,1.5\n")))
    assert error.field == "restitution_coefficient"
