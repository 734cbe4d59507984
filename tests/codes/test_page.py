"""Code, commands and numbers of the page for users of particle codes."""

import shlex

import pytest

from checkout import ROOT, blocks, run
from commands import done

PAGE = "docs/codes.md"


@pytest.mark.slow
def test_python_of_the_page_prints_what_the_page_shows(capsys):
    run(PAGE)
    printed = capsys.readouterr().out
    assert printed
    assert printed in "".join(blocks(PAGE, "text"))


def test_three_commands_give_the_lines_to_paste(monkeypatch):
    monkeypatch.chdir(ROOT)
    commands = blocks(PAGE, "sh")[0]
    assert commands in (ROOT / "README.md").read_text(encoding="utf-8")
    for line in commands.splitlines():
        answer = done(*shlex.split(line)[1:])
    words = blocks(PAGE, "text")[0].split()
    # The same lines; their numbers follow from a fit, whose last digits depend on the processor.
    pasted = answer.stdout[answer.stdout.index(f"\n{words[0]}") :].split()
    assert len(pasted) == len(words)
    for word, other in zip(pasted, words, strict=True):
        assert word == other or float(word) == pytest.approx(float(other), rel=1e-4)
