"""Commands of the command line, run in this process."""

import io
from contextlib import redirect_stderr, redirect_stdout
from functools import cache
from typing import Any, NamedTuple

from typer.main import get_command

from restitution.cli.main import app


class Answer(NamedTuple):
    exit_code: Any
    stdout: str
    stderr: str


@cache
def _commands() -> Any:
    """All commands; typer takes longer to build them than most of them take to run."""
    return get_command(app)


def run(*arguments: str) -> Answer:
    exit_code = None
    with redirect_stdout(io.StringIO()) as stdout, redirect_stderr(io.StringIO()) as stderr:
        try:
            _commands().main(list(arguments), prog_name="restitution")
        except SystemExit as end:
            exit_code = end.code
    return Answer(exit_code, stdout.getvalue(), stderr.getvalue())


def done(*arguments: str) -> Answer:
    """The answer to a command that succeeds."""
    answer = run(*arguments)
    assert answer.exit_code == 0, answer.stderr
    return answer


def words(*arguments: str) -> list[list[str]]:
    """The words of each line that a command prints."""
    return [line.split() for line in done(*arguments).stdout.splitlines()]


def refused(*arguments: str, exit_code: int = 2) -> str:
    """The message, in one line, of a command that prints nothing else."""
    answer = run(*arguments)
    assert (answer.exit_code, answer.stdout, answer.stderr.count("\n")) == (exit_code, "", 1), answer.stderr
    assert answer.stderr.startswith("error: ")
    return answer.stderr.removeprefix("error: ").rstrip("\n")
