"""Files of sections: TOML that is read within limits, known keys, and messages that name file, key and value."""

from __future__ import annotations

import json
import re
import tomllib
from collections.abc import Callable, Generator, Iterable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from difflib import get_close_matches
from functools import partial
from pathlib import Path
from typing import Any, ClassVar, Never, TypeVar, cast

from pydantic import BaseModel, ConfigDict, ValidationError, ValidationInfo, WithJsonSchema, model_validator

from restitution.errors import ABSENT, InputError
from restitution.quantities import advice
from restitution.units import DEVIATION, split_deviation

_LIST = re.compile(r"\s*\[([^\]]*)\]([^\]]*)")
# Keys whose texts are no quantities.
_WORDS = ("name", "file", "material_name", "library", "model", "type", "terms", "shift")
# Mistakes that one message lists.
_MOST_MISTAKES = 10
# tomllib takes quadratic time and memory for keys of many parts.
_LARGEST_FILE = 20_000_000
_DEEP_KEY = re.compile(r"""(?<![\w-])(?:(?:[\w-]++|"[^"\n]*+"|'[^'\n]*+')[ \t]*+\.[ \t]*+){40}""", re.ASCII)

S = TypeVar("S", bound="Section")


FROM_FILE = WithJsonSchema({"type": "string", "format": "path"})
"""Annotation of a field whose key names a file, and whose value is the content of this file."""


@dataclass(frozen=True)
class Forms:
    """Annotation of a section that has one of several forms; the JSON schema lists them."""

    sections: Callable[[], Iterable[type[BaseModel]]]

    def __get_pydantic_json_schema__(self, schema: Any, handler: Any) -> Any:
        return {"anyOf": [handler(section.__pydantic_core_schema__) for section in self.sections()]}


IN_FILE = "stands in the file already; leave one of the two out"
"""Rule of keys beside the name of a file that has their values."""


class CaseError(InputError):
    """A file that cannot be used: one line for each mistake, with the file, the key, its value and the rule.

    The attribute `mistakes` has all of them; the attributes of an `InputError` are those of the first.
    """

    def __init__(self, *mistakes: InputError, where: str | Path = "") -> None:
        first = mistakes[0]
        where = str(where) or first.where
        super().__init__(first.field, first.value, first.rule, first.unit, index=first.index, where=where)
        self.mistakes = mistakes

    def __str__(self) -> str:
        lines = [_line(self.where, mistake) for mistake in self.mistakes[:_MOST_MISTAKES]]
        more = len(self.mistakes) - len(lines)
        return "\n".join([*lines, f"{self.where}: and {more} more"] if more > 0 else lines)

    def __reduce__(self) -> Any:
        return partial(CaseError, where=self.where), self.mistakes


def _line(where: str, error: InputError) -> str:
    place = f"[{', '.join(map(str, error.index))}]" if error.index else ""
    shown = "" if error.value is ABSENT or isinstance(error.value, dict) else f" = {toml_value(error.value)}"
    unit = f" {error.unit}" if error.unit and shown else ""
    line = ": ".join(part for part in (where, f"{error.field}{place}{shown}{unit}", error.rule) if part)
    # Keys, names and units are the user's and may hold line breaks.
    return line.replace("\r", "\\r").replace("\n", "\\n")


def refuse(rule: str, key: str = "", value: Any = ABSENT) -> Never:
    """Refuse the value of a key of the section that is checked, or the section itself."""
    raise InputError(key, value, rule)


@contextmanager
def in_file(path: str | Path, section: str = "", **sections: str) -> Generator[None]:
    """Raise each refusal of the block as a `CaseError` with the file and the section of the field.

    `sections` has the sections of some fields by name; `section` is that of all others.
    """
    try:
        yield
    except CaseError:
        raise
    except InputError as error:
        raise CaseError(error.within(sections.get(error.field, section)), where=path) from None
    except (ValueError, TypeError) as error:
        raise CaseError(InputError(section, rule=str(error)), where=path) from None


MOTIONS = {
    "indentation": "a prescribed indentation is for `restitution indent`",
    "oscillation": "an oscillating indentation is for `restitution oscillate`",
    "tapping": "tapping is for `restitution tap`",
}
"""The command for each section of a motion that is no impact."""
_TABLE = "is no case file; `restitution solve` has the option --material for the table of a material"
_OTHER_FILES = {".csv": _TABLE, ".xlsx": _TABLE, ".wav": "is no case file; a sound is for `restitution bounces`"}


class Section(BaseModel):
    """A table of a case file, whose keys are the fields and no others."""

    model_config = ConfigDict(extra="forbid", frozen=True, arbitrary_types_allowed=True)

    # Keys of other kinds of file, and where to go with them.
    elsewhere: ClassVar[dict[str, str]] = {}

    @model_validator(mode="before")
    @classmethod
    def _known_keys(cls, data: Any) -> Any:
        if isinstance(data, dict):
            unknown = [key for key in data if key in cls.elsewhere or key not in cls.model_fields]
            if unknown:
                raise CaseError(*(InputError(key_path([key]), data[key], cls._advice(key)) for key in unknown))
        return data

    @classmethod
    def _advice(cls, key: str) -> str:
        if key in cls.elsewhere:
            return f"does not belong here; {cls.elsewhere[key]}"
        keys, others = list(cls.model_fields), cls.alternatives()
        close = [] if get_close_matches(key, keys, 1) or key in others else get_close_matches(key, others, 1)
        return f"unknown key; {advice(key, close or keys)}"

    @classmethod
    def alternatives(cls) -> set[str]:
        """Return the keys of the other forms that the section may have."""
        return set()

    def present(self, *keys: str) -> list[str]:
        """Return those of the keys that have a value."""
        return [key for key in keys if getattr(self, key) is not None]

    def refuse_present(self, rule: str, *keys: str) -> None:
        """Refuse the first of the keys that has a value."""
        for key in self.present(*keys):
            refuse(rule, key)

    def values(self, keys: Iterable[str]) -> dict[str, Any]:
        """Return the values of those of the keys that have one."""
        return {key: value for key in keys if (value := getattr(self, key, None)) is not None}

    def one_of(self, *keys: str) -> str:
        """Return the key that has a value; refuse none and several."""
        present = self.present(*keys)
        if len(present) != 1:
            state = f"{' and '.join(present)} are given" if present else "none is given"
            refuse(f"give exactly one of {', '.join(keys[:-1])} and {keys[-1]}; {state}")
        return present[0]


def read_sections(kind: type[S], path: Path, data: dict[str, Any], folder: Path | None = None) -> S:
    """Check the content of a file against its sections; a `CaseError` has all mistakes."""
    try:
        return kind.model_validate(data, context={"folder": path.parent if folder is None else folder})
    except ValidationError as error:
        raise CaseError(*_mistakes(data, error), where=path) from None


def folder_of(info: ValidationInfo) -> Path:
    """Return the folder of the case file, where the names of other files start."""
    return Path((info.context or {}).get("folder", "."))


def read_toml(path: Path) -> dict[str, Any]:
    """Read a TOML file; a `CaseError` has one line."""

    def fail(rule: str) -> Never:
        raise CaseError(InputError("", rule=rule), where=path) from None

    try:
        with path.open(encoding="utf-8-sig") as file:
            text = file.read(_LARGEST_FILE + 1)
    except FileNotFoundError:
        fail("no such file")
    except IsADirectoryError:
        fail("is a folder, not a case file")
    except OSError as error:
        fail(f"cannot be read: {error.strerror}")
    except ValueError:
        fail(_OTHER_FILES.get(path.suffix.lower(), "cannot be read: not a text file in UTF-8"))
    if len(text) > _LARGEST_FILE:
        fail(f"is too long: must have at most {_LARGEST_FILE} characters; give long tables as CSV files")
    if deep := _DEEP_KEY.search(text):
        fail(f"line {text.count(chr(10), 0, deep.start()) + 1}: not valid TOML: a key of too many parts")
    try:
        return tomllib.loads(text)
    except tomllib.TOMLDecodeError as error:
        if path.suffix.lower() in _OTHER_FILES:
            fail(_OTHER_FILES[path.suffix.lower()])
        what, where = str(error), ""
        if match := re.fullmatch(r"(.*) \(at (?:line (\d+), column (\d+)|(end of document))\)", what, re.DOTALL):
            what = match[1]
            last = f"line {len(text.splitlines())}, at the end: "
            where = f"line {match[2]}, column {match[3]}: " if match[2] else last
            if twice := re.fullmatch(r"Cannot declare \((.*?),?\) twice", what):
                keys = [key.strip().strip("'") for key in twice[1].split(",")]
                what = f"the section [{key_path(keys)}] is there twice"
        fail(f"{where}not valid TOML: {what[:1].lower()}{what[1:]}")
    except RecursionError:
        fail("not valid TOML: nested too deeply")
    except ValueError as error:
        fail(f"not valid TOML: {error}")


def split_list(value: Any) -> Any:
    """Turn "[1, 2, 3] s" into a list of texts with the unit of each; return anything else as it is."""
    if not isinstance(value, str):
        return value
    match = _LIST.fullmatch(value)
    if match is None:
        raise InputError("", rule='must be a list; write e.g. [1, 2, 3] or "[1, 2, 3] s"')
    items, unit = match[1].strip(), match[2].strip()
    return [f"{item.strip()} {unit}".strip() for item in items.split(",")] if items else []


def without_deviations(content: dict[str, Any], sections: Iterable[str]) -> dict[str, str]:
    """Take the standard deviations out of the texts of some sections; return them by the places of their keys.

    >>> content = {"body": {"mass": "5 +- 0.1 g", "radius": "10 mm"}}
    >>> without_deviations(content, ["body"]), content
    ({'body.mass': '0.1 g'}, {'body': {'mass': '5 g', 'radius': '10 mm'}})
    """
    taken: dict[str, str] = {}
    places: list[tuple[Any, tuple[str | int, ...]]] = [(content, (name,)) for name in sections if name in content]
    # In the order of the file, as what stands within a place comes right after it.
    places.reverse()
    while places:
        table, path = places.pop()
        key = path[-1]
        value = table[key]
        if isinstance(value, str) and DEVIATION.search(value):
            if value.lstrip().startswith("["):
                value = table[key] = split_list(value)
            elif key not in _WORDS:
                try:
                    table[key], taken[key_path(path)] = split_deviation(value)
                except InputError as error:
                    raise InputError(key_path(path), value, error.rule) from None
        if isinstance(value, dict | list):
            keys = value if isinstance(value, dict) else range(len(value))
            places += [(value, (*path, part)) for part in reversed([*keys])]
    return taken


def key_path(parts: Sequence[str | int]) -> str:
    """Write a path of keys as TOML does, with list places in brackets.

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
    if isinstance(value, float):
        return f"{value:.6g}"
    as_json = isinstance(value, bool | str | list)
    try:
        text = json.dumps(value, ensure_ascii=False, default=str) if as_json else str(value)
    except ValueError:  # an integer of more than 4300 digits
        text = "a number of very many digits"
    return text if len(text) <= 60 else text[:59] + "…"


# What a value must be, by the kinds of pydantic's errors.
_RULES = {
    "value_error": "{error}",
    **dict.fromkeys(("model_type", "model_attributes_type", "dict_type"), "must be a table"),
    **dict.fromkeys(("list_type", "tuple_type"), "must be a list"),
    "greater_than_equal": "must be >= {ge}",
    "less_than_equal": "must be <= {le}",
    "string_type": "must be text",
    **dict.fromkeys(("bool_type", "bool_parsing"), "must be true or false"),
    **dict.fromkeys(("int_type", "int_from_float", "int_parsing"), "must be a whole number"),
}


def _mistakes(data: dict[str, Any], error: ValidationError) -> Iterator[InputError]:
    for detail in error.errors(include_url=False):
        parts, value = _place(data, detail)
        context: Any = detail.get("ctx", {})
        cause = context.get("error")
        if not isinstance(cause, InputError):
            rule = _rule(detail["type"], detail["msg"], context, len(parts))
            yield InputError(key_path(parts), _shown(value), rule)
            continue
        for mistake in cause.mistakes if isinstance(cause, CaseError) else (cause,):
            yield _of_section(parts, value, mistake)


def _of_section(parts: list[str | int], value: Any, error: InputError) -> InputError:
    """Return a mistake within a section under the path of the section, with the value that the file has."""
    if not error.field:
        return InputError(key_path(parts), _shown(value), error.rule)
    part = cast("Any", value).get(error.field, ABSENT) if isinstance(value, dict) else ABSENT
    if part is ABSENT and error.value is None:
        error = InputError(error.field, rule=error.rule)
    if part is not ABSENT and not isinstance(part, dict) and not (isinstance(part, list) and error.index):
        error = InputError(error.field, part, error.rule)
    return error.within(key_path(parts))


def _shown(value: Any) -> Any:
    return ABSENT if isinstance(value, dict) else value


def _place(data: dict[str, Any], detail: Any) -> tuple[list[str | int], Any]:
    """Return the path of keys to the value to blame, and the value as the file has it."""
    parts: list[str | int] = []
    value: Any = data
    for part in detail["loc"]:
        if (isinstance(value, dict) and part in value) or (isinstance(part, int) and isinstance(value, list)):
            value = cast("Any", value)[part]
        elif isinstance(part, int):
            # One of a list that stands in one text with its unit.
            value = detail["input"]
        elif str(part).startswith("<"):
            continue  # the tag of a union's member, which is no key of the file
        else:
            value = ABSENT
        parts.append(part)
    return parts, value


def _rule(kind: str, message: str, context: dict[str, Any], depth: int) -> str:
    if kind == "missing":
        return "the section is missing" if depth == 1 else "is missing"
    if kind == "literal_error":
        choices = str(context["expected"]).replace("'", '"').replace(" or ", ", ")
        return f"must be one of {choices}"
    return _RULES[kind].format(**context) if kind in _RULES else message[:1].lower() + message[1:]
