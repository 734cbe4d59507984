"""The claims of the paper for the page, as `restitution reproduce` has judged them."""

from __future__ import annotations

import json
from functools import cache
from importlib.resources import files
from typing import Any

from restitution.paper import figures


@cache
def answer() -> dict[str, Any]:
    """Return the claims, and what the page needs to draw figures 3 to 6 from the interpolant."""
    record = json.loads((files("restitution.paper") / "claims.json").read_text(encoding="utf-8"))
    planes = {str(n): {"nu": nu} for n, nu in figures.PLANES.items()}
    return {
        "claims": record["claims"],
        "levels": list(figures.LEVELS),
        "poisson_ratios": [*figures.POISSON_RATIOS, 0.5],
        "figures": planes | {str(n): {"p2": 10.0**power} for n, power in figures.CURVES.items()},
        "guessed": record["guessed"],
        "references": record["references"],
    }
