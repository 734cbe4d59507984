"""How the gallery looks: the package's fonts and colours, and the examples in the order of their names."""

from __future__ import annotations

from typing import Any


def look(gallery_conf: dict[str, Any], name: str) -> None:
    """Give an example the look of the package; Sphinx-Gallery calls it before each."""
    from restitution.plot import style

    style.use()
