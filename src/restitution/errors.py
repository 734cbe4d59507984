"""Errors of the input as objects: the field, its value, and what it must be."""

from __future__ import annotations

import warnings
from typing import Any, Final, Self


class _Absent:
    def __repr__(self) -> str:
        return "ABSENT"


ABSENT: Final = _Absent()
"""Stands for a value that is not given."""

_LONGEST = 60


class InputError(ValueError):
    """An input that is not admissible. Code reads the attributes; the message is for people only.

    Parameters
    ----------
    field : str
        Name of the field, such as `velocity`, or of several, such as `depth, force`.
    value : object
        Its value; `ABSENT` if there is none to show.
    rule : str
        What the value must be, as the end of a sentence: "must be finite and > 0".
    unit : str
        Unit of the value.
    index : tuple of int
        Place of the value in an array.
    where : str
        Where the field stands, such as the name of a file.

    Examples
    --------
    >>> error = InputError("velocity", -1.0, "must be finite and > 0", "m/s")
    >>> print(error)
    velocity = -1 m/s: must be finite and > 0
    >>> print(error.within("impact", where="case.toml"))
    case.toml: impact.velocity = -1 m/s: must be finite and > 0
    """

    def __init__(
        self,
        field: str,
        value: Any = ABSENT,
        rule: str = "is not admissible",
        unit: str = "",
        *,
        index: tuple[int, ...] = (),
        where: str = "",
    ) -> None:
        super().__init__(field, value, rule, unit)
        self.field, self.value, self.rule, self.unit = field, value, rule, unit
        self.index, self.where = index, where

    def __str__(self) -> str:
        place = f"[{', '.join(map(str, self.index))}]" if self.index else ""
        shown = "" if self.value is ABSENT else f" = {shown_value(self.value)}"
        unit = f" {self.unit}" if self.unit and shown else ""
        name = f"{self.field}{place}{shown}{unit}"
        return ": ".join(part for part in (self.where, name, self.rule) if part)

    def within(self, section: str = "", *, where: str = "") -> Self:
        """Return the same error for a field that stands in a section, or in a file."""
        dot = "." if section and self.field and not self.field.startswith("[") else ""
        field = f"{section}{dot}{self.field}"
        return type(self)(field, self.value, self.rule, self.unit, index=self.index, where=where or self.where)

    def __reduce__(self) -> Any:
        return _rebuild, (type(self), self.field, self.value, self.rule, self.unit, self.index, self.where)


class InputTypeError(InputError, TypeError):
    """An input of another type than the field takes."""


def _rebuild(kind: type[InputError], *parts: Any) -> InputError:
    *positional, index, where = parts
    return kind(*positional, index=index, where=where)


class RestitutionWarning(UserWarning):
    """A warning of one line for people, with a kind for code, such as "window" or "density"."""

    def __init__(self, kind: str, message: str) -> None:
        super().__init__(kind, message)
        self.kind, self.message = kind, message

    def __str__(self) -> str:
        return self.message


def deprecated(name: str, instead: str, removed: str) -> None:
    """Warn the caller of a public function that a name of it will go.

    Parameters
    ----------
    name, instead : str
        What is used, such as an argument, and what takes its place.
    removed : str
        Version that no longer has it: two minor releases after the first one that warns.

    Examples
    --------
    >>> def draws(rng=0, seed=None):
    ...     if seed is not None:
    ...         deprecated("seed", "rng", "0.4")
    ...         rng = seed
    ...     return rng
    >>> with warnings.catch_warnings(record=True) as caught:
    ...     warnings.simplefilter("always")
    ...     print(draws(seed=3), caught[0].message)
    3 seed: is deprecated and will be removed in version 0.4; use rng
    """
    rule = f"is deprecated and will be removed in version {removed}; use {instead}"
    warnings.warn(RestitutionWarning("deprecated", f"{name}: {rule}"), stacklevel=3)


def shown_value(value: Any) -> str:
    """Return a value as one short line."""
    if isinstance(value, float):
        return f"{value:.6g}"
    try:
        return cut(repr(value), _LONGEST)
    # The object is of a foreign class, whose `repr` may raise anything.
    except Exception:
        return f"<{type(value).__name__}>"


def cut(text: str, longest: int = 200) -> str:
    """Return a text as one line of at most so many characters."""
    # Only the part that may be shown is searched for blanks.
    line = " ".join(text[: 20 * longest].split())
    return line if len(line) <= longest else f"{line[: longest - 1]}…"
