"""Build the paper: `python paper/build.py` writes `paper/build/paper.pdf` and `paper.html` from `paper.md`.

Needs what `paper/requirements.txt` lists; pip brings Pandoc and Typst with it. The figures are those in
`paper/figures`, which `paper/figures.py` draws.
"""

from __future__ import annotations

import os
from pathlib import Path

import pypandoc
import typst

FOLDER = Path(__file__).parent


def main() -> None:
    """Write both files."""
    os.chdir(FOLDER)
    Path("build").mkdir(exist_ok=True)
    common = ["--citeproc", "--bibliography=paper.bib", "--standalone"]
    html = [*common, "--mathml", "--embed-resources", "--metadata=title-prefix:restitution"]
    pypandoc.convert_file("paper.md", "html", outputfile="build/paper.html", extra_args=html)
    pypandoc.convert_file("paper.md", "typst", outputfile="build/paper.typ", extra_args=common)
    # Paths of pictures are those from the folder of the paper.
    text = Path("build/paper.typ").read_text(encoding="utf-8").replace('image("figures/', 'image("/figures/')
    Path("build/paper.typ").write_text(text, encoding="utf-8")
    typst.compile("build/paper.typ", output="build/paper.pdf", root=".")
    for name in ("paper.html", "paper.pdf"):
        print(FOLDER / "build" / name, (Path("build") / name).stat().st_size, "bytes")


if __name__ == "__main__":
    main()
