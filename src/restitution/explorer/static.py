"""The explorer as files that need no server: the paper's problem by its interpolant."""

from __future__ import annotations

import json
from pathlib import Path

from restitution.errors import InputError
from restitution.explorer import interpolant, messages, paper
from restitution.explorer.server import INDEX, INTERPOLANT, page_files
from restitution.files import whole_file

_LIVE, _STATIC = '<meta name="restitution" content="live">', '<meta name="restitution" content="static">'


def write_static(folder: str | Path) -> list[Path]:
    """Write the page and its data into a folder, which is made; return the files."""
    folder = Path(folder)
    if folder.exists() and not folder.is_dir():
        raise InputError("folder", str(folder), "must be a folder, and is a file")
    (folder / "static").mkdir(parents=True, exist_ok=True)
    served = page_files()
    index = served.pop(INDEX).decode("utf-8").replace(_LIVE, _STATIC)
    contents = {
        INDEX: index.encode("utf-8"),
        **{f"static/{name}": content for name, content in served.items()},
        f"static/{INTERPOLANT}": interpolant.as_json().encode("ascii"),
        "static/schema.json": messages.schema().encode("utf-8"),
        "static/paper.json": json.dumps(paper.answer(), allow_nan=False).encode("utf-8"),
    }
    for name, content in contents.items():
        with whole_file(folder / name) as partial:
            partial.write_bytes(content)
    return [folder / name for name in contents]
