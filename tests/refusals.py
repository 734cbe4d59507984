"""Comparison of error messages by field, value and range, whatever their wording."""

import re
from collections.abc import Callable
from typing import Any

import pytest

from restitution.errors import InputError

# Quoted text, numbers, keys and units: what a user needs. Plain words may change.
_NAMES = re.compile(r'"[^"]*"|[\w.]*[_.][\w.\[\]]*\w\]?|-?\d[\d.e+-]*')


def agrees(error: BaseException, message: str) -> bool:
    """Whether an error names the same field, value and range as a message, in as many lines."""
    if not isinstance(error, InputError):
        return False
    text = str(error)
    named = _NAMES.findall(message)
    place = re.split(r" = |: ", re.sub(r"^\S+\.(toml|json): ", "", message))[0]
    return text.count("\n") == message.count("\n") and place.split(".")[-1] in text and all(n in text for n in named)


def refusal(call: Callable[[], Any]) -> InputError:
    """The error of a call that is refused."""
    with pytest.raises(InputError) as caught:
        call()
    return caught.value


def in_one_line(call: Callable[[], Any]) -> InputError:
    """The error of a call that is refused in one line."""
    error = refusal(call)
    assert "\n" not in str(error)
    return error


def refuses(call: Callable[[], Any], message: str) -> None:
    """Check that a call is refused with the field, value and range of a message."""
    error = refusal(call)
    assert agrees(error, message), str(error)
