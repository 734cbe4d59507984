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
        self.addresses: list[str] = []

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        values = {name: value or "" for name, value in attrs}
        loads = [values[name] for name in _LOADED & values.keys()]
        if tag == "link" and _LOADING_LINKS & {*values.get("rel", "").lower().split()}:
            loads.append(values.get("href", ""))
        self.addresses += [address for address in loads if _HOST.match(address.strip())]
        self.addresses += _OF_STYLE.findall(values.get("style", ""))


def loads(name: str, text: str) -> list[str]:
    """Addresses at other hosts from which a browser loads something for a page or a style sheet."""
    if name.endswith(".css"):
        return _OF_STYLE.findall(text)
    parser = _Loads()
    parser.feed(text)
    inline = re.findall(r"<style.*?</style>", text, re.DOTALL | re.IGNORECASE)
    return parser.addresses + [address for style in inline for address in _OF_STYLE.findall(style)]


def loading_lines(folder: Path) -> list[str]:
    """One line for each built file that loads something from another host."""
    files = sorted(path for path in folder.rglob("*") if path.suffix in (".html", ".css"))
    what = {path: sorted({*loads(path.name, path.read_text("utf-8", "replace"))}) for path in files}
    return [f"{path.relative_to(folder)}: {', '.join(addresses)}" for path, addresses in what.items() if addresses]
