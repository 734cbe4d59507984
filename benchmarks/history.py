"""Benchmarks of releases, one file each: `python benchmarks/history.py --keep` keeps those of `results.json`.

Without an option the script writes `tables/history.md` from the files in `history/`. A number of another machine is no
comparison: the table has a column for each file, with its processor.
"""

from __future__ import annotations

import argparse
import json
import re
from pathlib import Path
from typing import Any

FOLDER = Path(__file__).parent
MICRO = 1e6


def summary(results: dict[str, Any]) -> dict[str, Any]:
    """Return the numbers of one run that releases are compared by."""
    numbers: dict[str, float] = {}
    for row in results["domains"]:
        numbers[f"{row['domain']}, rtol {row['rtol']:.0e} [µs]"] = row["mean"] * MICRO
    for row in results["profiles"]:
        numbers[f"profile {row['profile']} [µs]"] = row["seconds"] * MICRO
    for row in results["start"]["processes"]:
        subject = row["subject"].replace("`", "")
        numbers[f"first {subject} [s]"] = row["first_processor"]
        numbers[f"later {subject} [s]"] = row["later"]
    errors = {f"{row['domain']}, rtol {row['rtol']:.0e}": row["error"] for row in results["domains"]}
    return {"machine": results["machine"], "numbers": numbers, "largest errors of e": errors}


def keep(results: dict[str, Any], folder: Path) -> Path:
    """Write the summary of a run as the file of its version."""
    folder.mkdir(exist_ok=True)
    path = folder / f"{results['machine']['versions']['restitution']}.json"
    path.write_text(json.dumps(summary(results), indent=1, ensure_ascii=False) + "\n", encoding="utf-8")
    return path


def table(folder: Path) -> str:
    """Return the numbers of all releases side by side, the newest last."""
    files = sorted(folder.glob("*.json"), key=lambda path: [int(part) for part in re.findall(r"\d+", path.stem)])
    kept = {path.stem: json.loads(path.read_text(encoding="utf-8")) for path in files}
    names = dict.fromkeys(name for release in kept.values() for name in release["numbers"])
    rows = [
        ["", *kept],
        ["---"] * (len(kept) + 1),
        ["processor", *(release["machine"]["processor"] for release in kept.values())],
        *(
            [
                name,
                *(
                    f"{release['numbers'][name]:.3g}" if name in release["numbers"] else ""
                    for release in kept.values()
                ),
            ]
            for name in names
        ),
    ]
    return "\n".join(f"| {' | '.join(row)} |" for row in rows)


def main() -> None:
    """Keep a run if asked to, and write the table."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--keep", action="store_true", help="keep the numbers of results.json as those of its version")
    if parser.parse_args().keep:
        print(keep(json.loads((FOLDER / "results.json").read_text(encoding="utf-8")), FOLDER / "history"))
    (FOLDER / "tables" / "history.md").write_text(table(FOLDER / "history") + "\n", encoding="utf-8")


if __name__ == "__main__":
    main()
