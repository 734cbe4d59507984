"""Commands of the command line, run in this process."""

from functools import cache

from typer import testing
from typer.testing import CliRunner, Result

from restitution.cli.main import app

# Typer would build all commands anew for each call, which takes longer than most commands.
testing._get_command = cache(testing._get_command)


def run(*arguments: str) -> Result:
    return CliRunner().invoke(app, arguments, catch_exceptions=False)


def done(*arguments: str) -> Result:
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
