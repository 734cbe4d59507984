"""Comparison of errors by field, value and range, whatever their wording."""

import math
import re
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Any

import pytest

from restitution.errors import ABSENT, InputError, RestitutionWarning

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


def refusal(call: Callable[[], Any], kind: type[Exception] = InputError) -> Any:
    """The error of a call that is refused."""
    with pytest.raises(kind) as caught:
        call()
    assert isinstance(caught.value, InputError)
    return caught.value


def in_one_line(call: Callable[[], Any], kind: type[Exception] = InputError) -> Any:
    """The error of a call that is refused in one line."""
    error = refusal(call, kind)
    assert "\n" not in str(error)
    return error


def named(call: Callable[[], Any], kind: type[Exception] = InputError) -> tuple[Any, ...]:
    """Field, index and value, as far as given, that the error of a call names in one line."""
    error = in_one_line(call, kind)
    # A number that is none differs from itself, unless it is the same object.
    value = math.nan if isinstance(error.value, float) and math.isnan(error.value) else error.value
    return (error.field, *error.index, *(() if value is ABSENT else (value,)))


def refuses(call: Callable[[], Any], message: str) -> None:
    """Check that a call is refused with the field, value and range of a message."""
    error = refusal(call)
    assert agrees(error, message), str(error)


@contextmanager
def warns(kind: str) -> Iterator[None]:
    """Check that a block gives a warning of a kind, alone or among others."""
    with pytest.warns(RestitutionWarning) as caught:
        yield
    assert kind in {warning.message.kind for warning in caught}
