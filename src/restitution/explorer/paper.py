"""The claims of the paper for the page: computed once, on coarse grids."""

from __future__ import annotations

from functools import cache
from typing import Any

from restitution.explorer.answers import plain
from restitution.paper import claims, figures, further
from restitution.paper.computation import CITATION, GUESSED, Computation
from restitution.paper.reproduction import DEFAULT_SEED, QUICK


@cache
def _claims() -> list[claims.Claim]:
    computation = Computation(DEFAULT_SEED, workers=1)
    planes = [figures.compute_plane(computation, n, QUICK.plane) for n in figures.PLANES]
    curves = {n: figures.compute_curves(computation, n, QUICK.curve) for n in figures.CURVES}
    comparison = further.compare(*planes)
    return [
        claims.three_groups(further.compute_collapse(computation, QUICK.collapse, QUICK.draws)),
        claims.matters_where_small(comparison),
        claims.usually_underestimates(comparison, curves),
        claims.large_near_half(computation),
        claims.stiffer(),
        claims.several_times(further.compute_terms(computation, QUICK.curve)),
        claims.two_spheres(computation),
    ]


@cache
def answer() -> dict[str, Any]:
    """Return the claims, and what the page needs to draw figures 3 to 6 from the interpolant."""
    names = ("name", "statement", "holds", "finding", "numbers")
    planes = {str(n): {"nu": nu} for n, nu in figures.PLANES.items()}
    return {
        "claims": [plain({name: getattr(claim, name) for name in names}) for claim in _claims()],
        "levels": list(figures.LEVELS),
        "poisson_ratios": [*figures.POISSON_RATIOS, 0.5],
        "figures": planes | {str(n): {"p2": 10.0**power} for n, power in figures.CURVES.items()},
        "guessed": GUESSED,
        "references": CITATION,
    }
