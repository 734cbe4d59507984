"""The command resilience: table, JSON, picture and refusals."""

import json
from pathlib import Path

import pytest

import restitution as rs
from checkout import EXAMPLES
from commands import done, refused

PAD = str(EXAMPLES / "rubber_pad.toml")
WARM = ("--temperature", "0 degC", "--temperature", "23 degC")


def test_table_sources_and_warnings() -> None:
    answer = done("resilience", PAD, "--standard", "ASTM D7121", *WARM, "--measured", "60")
    pad = rs.resilience(rs.read_case(PAD).impact.material, "ASTM D7121", temperature=[273.15, 296.15])
    for value in pad.rebound_resilience.ravel():
        assert f"{value:.2f}" in answer.stdout
    for text in pad.standard.sources.values():
        assert text.partition(": ")[2] in answer.stdout
    implied = rs.implied_loss_tangent(60.0)
    assert all(f"{value:.3g}" in answer.stdout for value in implied)
    assert "small strain" in answer.stderr
    assert "trend" in answer.stderr


def test_json_and_picture(tmp_path: Path) -> None:
    options = "--plot", str(tmp_path / "pad.png"), "--measured", "60", "--thickness", "25 mm"
    content = json.loads(done("resilience", PAD, "--json", *options).stdout)
    pad = rs.resilience(rs.read_case(PAD).impact.material, thickness=0.025)
    assert content["rebound_resilience"] == pytest.approx(pad.rebound_resilience.tolist(), rel=1e-9)
    assert content["implied_loss_tangent"]["low"] == rs.implied_loss_tangent(60.0).low
    assert content["standard"]["thickness"] == 0.025
    assert content["base"] == list(pad.base)
    assert (tmp_path / "pad.png").stat().st_size > 1000


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        ((PAD, "--standard", "ISO 4663"), "did you mean ISO 4662?"),
        ((PAD, "--standard", "ASTM D2632"), "tip_radius"),
        ((PAD, "--temperature", "warm"), "--temperature"),
        ((PAD, "--base", "glued"), "base = 'glued'"),
        ((PAD, "--measured", "120"), "120 %"),
        ((PAD, "--thickness", "-1 mm"), "thickness"),
        (("nowhere.toml",), "nowhere.toml"),
    ],
)
def test_silly_input_is_refused_in_one_line(arguments: tuple[str, ...], words: str) -> None:
    assert words in refused("resilience", *arguments)
