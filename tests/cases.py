"""Case files: the ball of the README, whose sections a test replaces."""

import os
from pathlib import Path

BODY = 'mass = "5 g"\nradius = "10 mm"\n'
SOLID = 'equilibrium_modulus = "1 MPa"\nbranch_modulus = "10 MPa"\nviscosity = "10 kPa s"\npoisson_ratio = 0.45\n'
IMPACT = 'velocity = "1 m/s"\n'


def case_file(
    path: str | os.PathLike[str] | None = None, /, *, title: str | None = None, **sections: str | None
) -> str:
    """Text of a case, written to `path`; a section is the text of its lines, None leaves one of the ball out."""
    named = {"body": BODY, "material": SOLID, "impact": IMPACT} | sections
    head = "" if title is None else f'title = "{title}"\n'
    text = head + "".join(f"[{name}]\n{lines.strip()}\n" for name, lines in named.items() if lines is not None)
    if path is not None:
        Path(path).write_text(text, encoding="utf-8")
    return text
