"""How the gallery looks: the package's fonts, colours and warnings."""

from __future__ import annotations

import warnings
from typing import Any


def look(gallery_conf: dict[str, Any], name: str) -> None:
    """Give an example the look and the warnings of the package; Sphinx-Gallery calls it before each."""
    from restitution import RestitutionWarning
    from restitution.plot import style

    style.use()
    # As on the command line: without the path of a file on the machine that builds the pages.
    warnings.formatwarning = lambda message, *_, **__: f"warning: {message}\n"
    warnings.simplefilter("default", RestitutionWarning)
