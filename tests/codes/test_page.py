"""Code, commands and numbers of the page for users of particle codes."""

import re
import shlex
from pathlib import Path

import pytest
from typer.testing import CliRunner

from restitution.cli.main import app

ROOT = Path(__file__).parents[2]
PAGE = (ROOT / "docs" / "codes.md").read_text(encoding="utf-8")


def blocks(language):
    return re.findall(rf"^```{language}\n(.*?)^```$", PAGE, re.DOTALL | re.MULTILINE)


def test_python_of_the_page_prints_what_the_page_shows(capsys):
    names = {}
    for block in blocks("python"):
        exec(compile(block, "codes.md", "exec"), names)
    printed = capsys.readouterr().out
    assert printed
    assert printed in "".join(blocks("text"))


def test_three_commands_give_the_lines_to_paste(monkeypatch):
    monkeypatch.chdir(ROOT)
    commands = blocks("sh")[0]
    assert commands in (ROOT / "README.md").read_text(encoding="utf-8")
    for line in commands.splitlines():
        answer = CliRunner().invoke(app, shlex.split(line)[1:], catch_exceptions=False)
        assert answer.exit_code == 0
    words = blocks("text")[0].split()
    # The same lines; their numbers follow from a fit, whose last digits depend on the processor.
    pasted = answer.stdout[answer.stdout.index(f"\n{words[0]}") :].split()
    assert len(pasted) == len(words)
    for one, other in zip(pasted, words, strict=True):
        assert one == other or float(one) == pytest.approx(float(other), rel=1e-4)
