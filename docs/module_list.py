"""The page that lists every module of the package with its first line. It is made from the sources at each build."""

import ast
from pathlib import Path

DOCS = Path(__file__).parent
PACKAGE = DOCS.parent / "src" / "restitution"


def first_line(module: Path) -> str:
    """Return the first line of the docstring of a module."""
    return (ast.get_docstring(ast.parse(module.read_text(encoding="utf-8"))) or "").partition("\n")[0]


def module_list() -> str:
    """Return the page as MyST Markdown."""
    lines = ["# Modules", "", "Each module with the first line of its docstring.", ""]
    folders = [PACKAGE, *sorted(path for path in PACKAGE.iterdir() if (path / "__init__.py").exists())]
    for folder in folders:
        modules = sorted(folder.glob("*.py")) if folder == PACKAGE else sorted(folder.rglob("*.py"))
        lines += [f"## `{folder.relative_to(PACKAGE.parent)}`", "", first_line(folder / "__init__.py"), ""]
        lines += ["| module | purpose |", "|---|---|"]
        for module in modules:
            if module.name != "__init__.py":
                name = module.relative_to(folder)
                lines.append(f"| `{name}` | {first_line(module).replace('|', chr(92) + '|')} |")
        lines.append("")
    return "\n".join(lines)


def write() -> None:
    """Write the page, if it is not the same already."""
    page, text = DOCS / "development" / "modules.md", module_list()
    if not page.exists() or page.read_text(encoding="utf-8") != text:
        page.write_text(text, encoding="utf-8")
