"""Built pages that load something from another host: a script, a style, a font, a picture."""

import re
from html.parser import HTMLParser
from pathlib import Path

# What a browser loads by itself. `href` of a link to a page is loaded by a click alone.
_LOADED = {"src", "srcset", "data", "poster", "action"}
_LOADING_LINKS = {
    "stylesheet", "icon", "preload", "modulepreload", "prefetch", "preconnect", "dns-prefetch", "manifest",
}  # fmt: skip
_HOST = re.compile(r"(?:https?:)?//[\w.-]+\.\w+", re.IGNORECASE)
_OF_STYLE = re.compile(r"""(?:url\(|@import)\s*["']?((?:https?:)?//[^"')\s]+)""", re.IGNORECASE)


class _Loads(HTMLParser):
    def __init__(self) -> None:
        super().__init__()
        self.found: list[str] = []

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        values = {name: value or "" for name, value in attrs}
        loads = [values[name] for name in _LOADED & values.keys()]
        if tag == "link" and _LOADING_LINKS & {*values.get("rel", "").lower().split()}:
            loads.append(values.get("href", ""))
        self.found += [one for one in loads if _HOST.match(one.strip())]
        self.found += _OF_STYLE.findall(values.get("style", ""))


def loads(name: str, text: str) -> list[str]:
    """Addresses at other hosts from which a browser loads something for a page or a style sheet."""
    if name.endswith(".css"):
        return _OF_STYLE.findall(text)
    parser = _Loads()
    parser.feed(text)
    inline = re.findall(r"<style.*?</style>", text, re.DOTALL | re.IGNORECASE)
    return parser.found + [address for style in inline for address in _OF_STYLE.findall(style)]


def found(folder: Path) -> list[str]:
    """One line for each built file that loads something from another host."""
    files = sorted(one for one in folder.rglob("*") if one.suffix in (".html", ".css"))
    what = {one: sorted({*loads(one.name, one.read_text("utf-8", "replace"))}) for one in files}
    return [f"{one.relative_to(folder)}: {', '.join(addresses)}" for one, addresses in what.items() if addresses]
