"""The claims of the paper, each with the computed numbers that bear it out or not."""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import asdict, dataclass
from itertools import pairwise
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from restitution.paper.inputs import draw_inputs

if TYPE_CHECKING:
    import xarray as xr

    from restitution.paper.computation import Computation

STREAM = 9
_BINS = (0.0, 0.1, 0.3, 0.6, 0.9, 1.0)
_NEAR_HALF = (0.45, 0.49, 0.499, 0.4999, 0.49999)


@dataclass(frozen=True)
class Claim:
    """One claim of the paper and what the computation says of it.

    Parameters
    ----------
    name : str
        A short name.
    statement : str
        What the paper says.
    holds : bool
        Whether the numbers bear it out.
    finding : str
        What they show, in a sentence or two.
    numbers : mapping of str to float
        The numbers, by what they are.
    """

    name: str
    statement: str
    holds: bool
    finding: str
    numbers: Mapping[str, float]


def three_groups(collapse: xr.Dataset) -> Claim:
    """Judge that e depends on p1, p2, p3 alone, by the spread between random draws of all other inputs."""
    spread = float(collapse["spread"].max())
    relative = float(collapse["relative_spread"].max())
    holds = relative <= 1.0
    draws = collapse.sizes["draw"]
    points = collapse["spread"].size
    return Claim(
        "three groups",
        "The restitution coefficient depends on the inputs through p1 = nu, p2 = Ginf/G1 and "
        "p3 = eta (v0 R/(m^2 Ginf^3))^(1/5) alone (eq. 11).",
        holds,
        f"At {points} points of the plane, {draws} random draws each of m, R, v0 and Ginf over several "
        f"decades differ in e by at most {spread:.1e}, {'within' if holds else 'beyond'} the tolerance.",
        {
            "points": points,
            "draws at each": draws,
            "largest spread of e between two draws": spread,
            "largest spread over the tolerance of e": relative,
        },
    )


def matters_where_small(comparison: xr.Dataset) -> Claim:
    """Judge that compressibility matters most where e is small, by the relative error within bands of e."""
    nu = float(comparison["poisson_ratio"])
    e = comparison["compressible"].values.ravel()
    error = np.abs(comparison["relative_error"].values.ravel())
    numbers: dict[str, float] = {}
    medians: list[float] = []
    for low, high in pairwise(_BINS):
        inside = (e >= low) & (e <= high)
        if inside.any():
            medians.append(float(np.median(error[inside])))
            numbers[f"median relative error where {low:g} <= e <= {high:g}"] = medians[-1]
    rank = _rank_correlation(e, error)
    worst = int(np.argmax(error))
    numbers |= {
        "rank correlation of e and relative error": rank,
        "largest relative error": float(error[worst]),
        "e where the relative error is largest": float(e[worst]),
        "smallest e of the plane": float(e.min()),
    }
    holds = bool(np.all(np.diff(medians) < 0)) and rank < 0
    return Claim(
        "matters where e is small",
        "Compressibility matters most where the restitution coefficient is small.",
        holds,
        f"Taking nu = {nu:g} as incompressible misses e by a median of {100 * medians[0]:.1f} % in the "
        f"lowest band of e and by {100 * medians[-1]:.2f} % in the highest; the error is largest "
        f"({100 * error[worst]:.1f} %) where e = {e[worst]:.4f}.",
        numbers,
    )


def _rank_correlation(first: NDArray[np.float64], second: NDArray[np.float64]) -> float:
    difference = np.argsort(np.argsort(first)) - np.argsort(np.argsort(second))
    n = first.size
    return 1.0 - 6.0 * float(np.sum(difference.astype(np.float64) ** 2)) / (n * (n * n - 1.0))


def usually_underestimates(comparison: xr.Dataset, curves: Mapping[int, xr.Dataset]) -> Claim:
    """Judge that the incompressible value is usually too low, by the share of points where it is."""
    nu = float(comparison["poisson_ratio"])
    rtol = float(comparison.attrs["rtol"])
    plane = comparison["incompressible"].values < (1.0 - 2.0 * rtol) * comparison["compressible"].values
    share = float(plane.mean())
    numbers: dict[str, float] = {f"share of the plane of figures 3 and 4 where it does, nu = {nu:g}": share}
    shares: list[float] = []
    for figure, dataset in curves.items():
        e = dataset["restitution_coefficient"].isel(p2=0).transpose("poisson_ratio", "p3").values
        for ratio, row in zip(dataset["poisson_ratio"].values[:-1], e[:-1], strict=True):
            shares.append(float(np.mean(e[-1] < (1.0 - 2.0 * rtol) * row)))
            numbers[f"share of figure {figure}'s curve where it does, nu = {ratio:g}"] = shares[-1]
    error = comparison["relative_error"].values
    at = np.unravel_index(int(np.argmax(error)), error.shape)
    numbers |= {
        "largest overestimate, relative": float(error[at]),
        "log10 p2 there": float(np.log10(comparison["p2"].values[at[0]])),
        "log10 p3 there": float(np.log10(comparison["p3"].values[at[1]])),
    }
    return Claim(
        "usually underestimates",
        "Taking the material as incompressible usually underestimates the restitution coefficient.",
        share > 0.5 and float(np.median(shares)) > 0.5,
        f"It does at {100 * share:.1f} % of the plane for nu = {nu:g} and along "
        f"{100 * np.mean(shares):.1f} % of the curves of figures 5 and 6; where it overestimates, it does so "
        f"by at most {100 * float(error[at]):.2f} % for nu = {nu:g}.",
        numbers,
    )


def large_near_half(computation: Computation) -> Claim:
    """Judge that errors of 100 % and more occur for nu very close to 0.5, where the paper points."""
    p2, p3 = 1e-3, 10.0
    ratios = np.array([*_NEAR_HALF, 0.5])
    inputs = draw_inputs(np.full(ratios.size, p2), p3, np.random.default_rng([computation.seed, STREAM]))
    *values, limit = computation.solve(ratios, inputs).tolist()
    numbers: dict[str, float] = {"e, incompressible": limit}
    for nu, e in zip(_NEAR_HALF, values, strict=True):
        numbers[f"e, nu = {nu:g}"] = e
        numbers[f"(e - e_inc)/e_inc, nu = {nu:g}"] = (e - limit) / limit
        numbers[f"(e_inc - e)/e, nu = {nu:g}"] = (limit - e) / e
    e = values[_NEAR_HALF.index(0.49)]
    excess = (e - limit) / limit
    return Claim(
        "100 % and more near nu = 0.5",
        "Relative errors of 100 % and more are possible even for nu very close to 0.5, e.g. nu = 0.49 at "
        "log10 p2 = -3, p3 = 10 (Fig. 6).",
        excess >= 1.0,
        f"There e = {e:.6f} against {limit:.6f} in the incompressible limit: {100 * excess:.0f} % above the "
        f"incompressible value, which is {100 * (e - limit) / e:.1f} % below the compressible one.",
        numbers,
    )


def number_of_solves() -> int:
    """Return how many impacts the claims solve beyond those of the figures."""
    return len(_NEAR_HALF) + 1


def as_json(claims: list[Claim], attributes: Mapping[str, Any]) -> str:
    """Return the claims as JSON text, numbers in full."""
    return json.dumps({**attributes, "claims": [asdict(claim) for claim in claims]}, indent=2) + "\n"


def as_markdown(claims: list[Claim], attributes: Mapping[str, Any]) -> str:
    """Return the claims as a Markdown page, one section and one table each."""
    lines = [
        "# Claims of the paper and what the computation says",
        "",
        f"{attributes['references']}.",
        "",
        f"Computed by {attributes['source']}, method {attributes['method']}, rtol {attributes['rtol']:g}, "
        f"seed {attributes['seed']}; `e` is the restitution coefficient, `e_inc` its incompressible value.",
        "",
        "| claim | borne out |",
        "|---|---|",
        *(f"| {claim.name} | {'yes' if claim.holds else '**no**'} |" for claim in claims),
    ]
    for number, claim in enumerate(claims, start=1):
        lines += [
            "",
            f"## {number}. {claim.name.capitalize()}",
            "",
            f"> {claim.statement}",
            "",
            f"**{'Borne out' if claim.holds else 'Not borne out'}.** {claim.finding}",
            "",
            "| quantity | value |",
            "|---|---:|",
            *(f"| {words} | {value:.6g} |" for words, value in claim.numbers.items()),
        ]
    return "\n".join(lines) + "\n"
