"""Sections of a case file: known keys, and one-line messages that name file, key and value."""

from __future__ import annotations

import json
import re
from difflib import get_close_matches
from pathlib import Path
from typing import Any, ClassVar, cast

from pydantic import BaseModel, ConfigDict, ValidationError, ValidationInfo, model_validator

from restitution.case.quantity import refuse


class CaseError(ValueError):
    """A case file that cannot be used; one line names the file, the key, its value and what is wanted."""

    def __init__(self, message: str) -> None:
        # Keys, names and units are the user's and may hold line breaks.
        super().__init__(message.replace("\r", "\\r").replace("\n", "\\n"))


class Section(BaseModel):
    """A table of a case file, whose keys are the fields and no others."""

    model_config = ConfigDict(extra="forbid", frozen=True, arbitrary_types_allowed=True)

    # Keys of other kinds of file, and where to go with them.
    elsewhere: ClassVar[dict[str, str]] = {}

    @classmethod
    def alternatives(cls) -> set[str]:
        """Keys of the other forms which this section might have had."""
        base = cls.__mro__[1]
        siblings = base.__subclasses__() if base is not Section and issubclass(base, Section) else []
        return {key for sibling in siblings for key in sibling.model_fields}

    @model_validator(mode="before")
    @classmethod
    def _known_keys(cls, data: Any) -> Any:
        if isinstance(data, dict):
            for key in data:
                if key in cls.elsewhere:
                    refuse(f"does not belong here; {cls.elsewhere[key]}", key)
                if key not in cls.model_fields:
                    own = list(cls.model_fields)
                    close = get_close_matches(key, own, 1)
                    if not close and key not in (others := cls.alternatives()):
                        close = get_close_matches(key, others, 1)
                    advice = f"did you mean {close[0]}?" if close else f"known are {', '.join(own)}"
                    refuse(f"unknown key; {advice}", key)
        return data

    def given(self, *keys: str) -> list[str]:
        """Which of the keys have a value."""
        return [key for key in keys if getattr(self, key) is not None]

    def one_of(self, *keys: str) -> str:
        """Return which one of the keys has a value; refuse none and more than one."""
        given = self.given(*keys)
        if len(given) != 1:
            state = f"{' and '.join(given)} are given" if given else "none is given"
            refuse(f"give exactly one of {', '.join(keys[:-1])} and {keys[-1]}; {state}")
        return given[0]


def folder_of(info: ValidationInfo) -> Path:
    """Folder of the case file, which the names of other files start from."""
    return Path((info.context or {}).get("folder", "."))


def key_path(parts: list[str | int]) -> str:
    """Write a path of keys as TOML does, with list places in brackets.

    Examples
    --------
    >>> key_path(["material", "shear", "relaxation_times", 2])
    'material.shear.relaxation_times[2]'
    """
    text = ""
    for part in parts:
        if isinstance(part, int):
            text += f"[{part}]"
        else:
            bare = re.fullmatch(r"[\w-]+", part, re.ASCII)
            text += ("." if text else "") + (part if bare else json.dumps(part, ensure_ascii=False))
    return text


def toml_value(value: Any) -> str:
    """Write a value as TOML does, on one line and not too long."""
    quoted = isinstance(value, bool | str | list)
    text = json.dumps(value, ensure_ascii=False, default=str) if quoted else str(value)
    return text if len(text) <= 60 else text[:59] + "…"


def explain(path: Path, data: dict[str, Any], error: ValidationError) -> str:
    """Tell the first thing that is wrong in a case file, in one line."""
    details = error.errors(include_url=False)
    first = details[0]
    context = first.get("ctx", {})
    parts: list[str | int] = []
    value: Any = data
    keys = context.get("keys", ())
    for step, part in enumerate([*first["loc"], *keys]):
        # Pydantic also puts the tag of a union's member in the path, which is no key of the file.
        if (isinstance(value, dict) and part in value) or (isinstance(value, list) and isinstance(part, int)):
            value = cast("Any", value)[part]
            parts.append(part)
        elif isinstance(part, int) and isinstance(value, str):
            # One of a list that stands in one text with its unit.
            value = first["input"]
            parts.append(part)
        elif step >= len(first["loc"]) - (first["type"] == "missing"):
            value = None
            parts.append(part)
    place = key_path(parts)
    shown = "" if value is None or isinstance(value, dict) else f" = {toml_value(value)}"
    more = len(details) - 1
    rest = f" (and {more} more error{'s' if more > 1 else ''})" if more else ""
    why = _why(first["type"], first["msg"], context, len(parts))
    return f"{path}: {place}{shown}{': ' if place else ''}{why}{rest}"


def _why(kind: str, message: str, context: dict[str, Any], depth: int) -> str:
    match kind:
        case "case":
            return str(context["why"])
        case "value_error":
            return str(context["error"])
        case "missing":
            return "the section is missing" if depth == 1 else "is missing"
        case "model_type" | "model_attributes_type" | "dict_type":
            return "must be a table"
        case "list_type":
            return "must be a list"
        case "literal_error":
            return (
                f"must be one of {str(context['expected']).replace(chr(39), chr(34)).replace(' or ', ', ')}"
            )
        case "string_type":
            return "must be text"
        case "bool_type" | "bool_parsing":
            return "must be true or false"
        case "int_type" | "int_from_float" | "int_parsing":
            return "must be a whole number"
        case _:
            return message[:1].lower() + message[1:]
