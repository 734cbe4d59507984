"""The sources are valid BibTeX and agree with the page of references."""

import re
import unicodedata
from pathlib import Path

import pytest

from restitution.citation.cite import entries

REFERENCES = Path(__file__).resolve().parents[2] / "docs" / "theory" / "references.md"
REQUIRED = {
    "article": {"author", "title", "journal", "volume", "pages", "year"},
    "book": {"title", "publisher"},
    "misc": {"title", "howpublished"},
    "software": {"author", "title"},
    "unpublished": {"author", "title", "note"},
}
# Standards, handbooks and programs are cited beside their numbers.
NOT_LISTED = {"crc", "en1993", "en1999", "en572", "pyvisco", "restitution"} | {
    "ballrebound", "gbt1681", "iso8307", "schob", "verticalrebound"
}  # fmt: skip
ACCENTS = {"`": "\u0300", "'": "\u0301", '"': "\u0308"}


def parse(text: str) -> tuple[str, str, dict[str, str]]:
    """Kind, key and fields of a BibTeX entry with balanced braces."""
    head = re.match(r"@(\w+)\{(\w+),\s*", text)
    assert head is not None, text
    place, fields = head.end(), {}
    while text[place] != "}":
        name = re.compile(r"(\w+)\s*=\s*\{").match(text, place)
        assert name is not None, text[place:]
        depth, end = 1, name.end()
        while depth:
            depth += {"{": 1, "}": -1}.get(text[end], 0)
            end += 1
        assert name[1] not in fields, name[1]
        fields[name[1]] = text[name.end() : end - 1]
        rest = re.compile(r",?\s*").match(text, end)
        assert rest is not None
        assert "," in rest[0] or text[rest.end()] == "}"
        place = rest.end()
    assert text[place:] == "}"
    return head[1], head[2], fields


def plain(text: str) -> str:
    """Text without accents, case and punctuation."""
    text = text.replace(r"{\ss}", "ß")
    text = re.sub(r"\{\\(.)(\w)\}", lambda m: m[2] + ACCENTS[m[1]], text)
    text = unicodedata.normalize("NFKD", text).casefold()
    return " ".join(re.findall(r"[a-z0-9]+", re.sub(r"[\u0300-\u036f{}]", "", text)))


@pytest.mark.parametrize("key", entries())
def test_entries_are_bibtex(key: str) -> None:
    kind, name, fields = parse(entries()[key])
    assert name == key
    assert set(fields) >= REQUIRED[kind]
    assert all(value.strip() for value in fields.values())
    assert "\\" not in re.sub(r"\{\\(ss|[`'\"]\w)\}", "", entries()[key])
    if "year" in fields:
        assert key.endswith(fields["year"])
        first = fields["author"].split(",")[0]
        assert key.startswith(plain(first).replace("muller", "mueller"))


def test_all_entries_are_read_and_sorted_by_key() -> None:
    import restitution.citation

    text = Path(restitution.citation.__file__).with_name("references.bib").read_text(encoding="utf-8")
    keys = re.findall(r"^@\w+\{(\w+),", text, flags=re.MULTILINE)
    assert keys == list(entries())
    assert sorted(keys) == keys


def test_every_entry_is_among_the_references_of_the_documents() -> None:
    bullets = re.findall(r"^\* (.*(?:\n  .*)*)", REFERENCES.read_text(encoding="utf-8"), flags=re.MULTILINE)
    assert len(bullets) > 20
    cited: list[str] = []
    for bullet in bullets:
        keys = [
            key
            for key, text in entries().items()
            if (fields := parse(text)[2])
            and plain(fields["title"]) in plain(bullet)
            and fields.get("year", "") in bullet
        ]
        # The page also cites works without an entry, which no problem uses.
        if not keys:
            continue
        assert len(keys) == 1, bullet
        cited += keys
        fields = parse(entries()[keys[0]])[2]
        names = [author.split(",")[0] for author in fields["author"].split(" and ")]
        assert all(plain(name) in plain(bullet) for name in names), bullet
        for number in ("year", "volume"):
            if number in fields:
                assert re.search(rf"\b{fields[number]}\b", bullet), bullet
        if "pages" in fields:
            assert re.search(rf"\b{fields['pages'].split('-')[0]}\b", bullet), bullet
    assert sorted(cited) == sorted(set(entries()) - NOT_LISTED)
