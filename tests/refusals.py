"""Comparison of error messages by field, value and range, whatever their wording."""

import re

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
