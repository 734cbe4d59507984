"""The claims of the paper, each with the computed numbers that confirm it or do not."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass
from itertools import pairwise
from typing import TYPE_CHECKING, Any

import numpy as np

from restitution.contact.profiles import Parabola
from restitution.impact.problem import Body, Impact, collision
from restitution.impact.scaling import viscosity_unit
from restitution.impact.solve import standard_solid_restitution
from restitution.material.classical import standard_solid
from restitution.material.conversion import bulk_factor
from restitution.material.prony import PronySeries
from restitution.material.viscoelastic import Material, reduced_modulus
from restitution.paper import figures
from restitution.paper.figures import POISSON_RATIOS
from restitution.sweeps.grid import LogUniform, Samples

if TYPE_CHECKING:
    import xarray as xr

EXAMPLES = ((0.49, 1e-3, 10.0), (0.499, 4.5e-3, 6.0))
"""nu, p2, p3 of the paper's example and of one whose glass is that of a polymer, nu_0 = 0.3."""

TERMS = (1, 2, 3)
"""Numbers of relaxation times that are compared."""

E_FLOOR = 1e-3
"""Below this restitution coefficient the solver's tolerance is absolute, `rtol * E_FLOOR`."""

PAIRS = 80
"""Collisions of two spheres that are compared with impacts of one."""

_TERMS_P2 = 1e-2
_BINS = (0.0, 0.1, 0.3, 0.6, 0.9, 1.0)
_NEAR_HALF = (0.45, 0.49, 0.499, 0.4999, 0.49999)


@dataclass(frozen=True)
class Claim:
    """One claim of the paper and the verdict of the computation.

    Attributes
    ----------
    name : str
        A short name.
    statement : str
        The claim, in the words of this package.
    holds : bool
        Whether the numbers confirm it.
    finding : str
        The result, in a sentence or two.
    numbers : mapping of str to float
        The numbers, by their meaning.
    """

    name: str
    statement: str
    holds: bool
    finding: str
    numbers: Mapping[str, float]


def compute_collapse(computation: figures.Computation, n: int, draws: int) -> xr.Dataset:
    """Return e of several random bodies and materials at each of n x n points, for nu = 0.45 and 0.5.

    `spread` is the largest difference between two draws at a point, `relative_spread` the same over the tolerance.
    """
    ball = Impact(standard_solid(1e6, 1e6, 1e3, poisson_ratio=0.45), Parabola(0.01), mass=0.005, velocity=1.0)
    axes = {
        "poisson_ratio": [0.45, 0.5],
        "p2": figures.p2_axis(n),
        "p3": figures.p3_axis(n),
        "draw": Samples(draws, figures.BODIES, rng=computation.seed),
    }
    dataset = computation.sweep("Collapse of random inputs onto p1, p2 and p3", axes, ball)
    unit = viscosity_unit(*(dataset[name] for name in ("equilibrium_modulus", "mass", "velocity", "radius")))
    e = dataset["restitution_coefficient"]
    spread = e.max("draw") - e.min("draw")
    tolerance = computation.rtol * np.maximum(e.mean("draw"), E_FLOOR)
    return figures.described(
        dataset.assign(viscosity=dataset["p3"] * unit, spread=spread, relative_spread=spread / tolerance),
        spread="largest difference of e between two draws",
        relative_spread=f"largest difference of e between two draws over its tolerance, rtol max(e, {E_FLOOR:g})",
    )


def three_groups(collapse: xr.Dataset) -> Claim:
    """Judge that e depends on p1, p2, p3 alone, by the spread between random draws of all other inputs."""
    spread = float(collapse["spread"].max())
    relative = float(collapse["relative_spread"].max())
    holds = relative <= 1.0
    draws = collapse.sizes["draw"]
    points = collapse["spread"].size
    return Claim(
        "three groups",
        "The restitution coefficient depends on the inputs only through p1 = nu, p2 = Ginf/G1 and "
        "p3 = eta (v0 R/(m^2 Ginf^3))^(1/5) (eq. 11).",
        holds,
        f"At {points} points of the plane, {draws} random sets of m, R, v0 and Ginf over several decades differ in e "
        f"by at most {spread:.1e}, {'within' if holds else 'beyond'} the tolerance.",
        {
            "points": points,
            "draws at each": draws,
            "largest spread of e between two draws": spread,
            "largest spread over the tolerance of e": relative,
        },
    )


def compare(compressible: xr.Dataset, incompressible: xr.Dataset) -> xr.Dataset:
    """Return the relative error of the incompressible value over a plane, by either of the two values as the measure.

    `relative_error` = (e_inc - e)/e cannot fall below -1; `relative_excess` = (e - e_inc)/e_inc has no upper bound:
    only by this measure can an underestimate be wrong by 100 % and more.

    Examples
    --------
    >>> import xarray as xr
    >>> compressible = xr.Dataset({"restitution_coefficient": ((), 0.2)}, {"poisson_ratio": 0.45})
    >>> incompressible = xr.Dataset({"restitution_coefficient": ((), 0.1)}, {"poisson_ratio": 0.5})
    >>> result = compare(compressible, incompressible)
    >>> float(result.relative_error), float(result.relative_excess)
    (-0.5, 1.0)
    """
    e = compressible["restitution_coefficient"]
    e_inc = incompressible["restitution_coefficient"].drop_vars("poisson_ratio")
    nu = float(compressible["poisson_ratio"])
    result = compressible.drop_vars("restitution_coefficient").assign(
        compressible=e, incompressible=e_inc, relative_error=(e_inc - e) / e, relative_excess=(e - e_inc) / e_inc
    )
    return figures.described(
        result.assign_attrs(title=f"Error of the incompressible value for nu = {nu:g}"),
        compressible=f"restitution coefficient, nu = {nu:g}",
        incompressible="restitution coefficient, incompressible",
        relative_error="error of the incompressible value relative to the compressible one",
        relative_excess="excess of the compressible value relative to the incompressible one",
    )


def matters_where_small(comparison: xr.Dataset) -> Claim:
    """Judge that compressibility matters most where e is small, by the relative error within bands of e."""
    from scipy.stats import spearmanr

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
    rank = float(spearmanr(e, error).statistic)  # pyright: ignore[reportAttributeAccessIssue]
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
        f"For nu = {nu:g} the incompressible value has a median error of {100 * medians[0]:.1f} % in the lowest band "
        f"of e and of {100 * medians[-1]:.2f} % in the highest. The error is largest ({100 * error[worst]:.1f} %) at "
        f"e = {e[worst]:.4f}.",
        numbers,
    )


def usually_underestimates(comparison: xr.Dataset, curves: Mapping[int, xr.Dataset]) -> Claim:
    """Judge that the incompressible value is usually too low, by the share of points where it is."""
    nu = float(comparison["poisson_ratio"])
    rtol = float(comparison.attrs["rtol"])
    plane = comparison["incompressible"].values < (1.0 - 2.0 * rtol) * comparison["compressible"].values
    share = float(plane.mean())
    numbers: dict[str, float] = {f"share of underestimates on the plane of figures 3 and 4, nu = {nu:g}": share}
    shares: list[float] = []
    worst = 0.0
    for figure, dataset in curves.items():
        e = dataset["restitution_coefficient"].transpose("poisson_ratio", "p3").values
        worst = max(worst, float((e[-1] / e[:-1] - 1.0).max()))
        for ratio, row in zip(dataset["poisson_ratio"].values[:-1], e[:-1], strict=True):
            shares.append(float(np.mean(e[-1] < (1.0 - 2.0 * rtol) * row)))
            numbers[f"share of underestimates on the curve of figure {figure}, nu = {ratio:g}"] = shares[-1]
    error = comparison["relative_error"].values
    at = np.unravel_index(int(np.argmax(error)), error.shape)
    numbers |= {
        "largest overestimate, relative": float(error[at]),
        "log10 p2 there": float(np.log10(comparison["p2"].values[at[0]])),
        "log10 p3 there": float(np.log10(comparison["p3"].values[at[1]])),
        "largest overestimate along the curves of figures 5 and 6, relative": worst,
    }
    return Claim(
        "usually underestimates",
        "The assumption of incompressibility usually underestimates the restitution coefficient.",
        share > 0.5 and float(np.median(shares)) > 0.5,
        f"The incompressible value is too low at {100 * share:.1f} % of the plane for nu = {nu:g} and along "
        f"{100 * np.mean(shares):.1f} % of the curves of figures 5 and 6. Elsewhere it is too high, by up to "
        f"{100 * float(error[at]):.0f} % on the plane (log10 p2 = {numbers['log10 p2 there']:.3g}, "
        f"log10 p3 = {numbers['log10 p3 there']:.3g}) and up to {100 * worst:.0f} % along the curves.",
        numbers,
    )


def large_near_half(computation: figures.Computation) -> Claim:
    """Judge that errors of 100 % and more occur for nu near 0.5: the paper's example, and a plausible glass."""
    (_, p2, p3), (plausible, other_p2, other_p3) = EXAMPLES
    n = len(_NEAR_HALF) + 1
    *values, limit, second, second_limit = standard_solid_restitution(
        [*_NEAR_HALF, 0.5, plausible, 0.5], [p2] * n + [other_p2] * 2, [p3] * n + [other_p3] * 2,
        rtol=computation.rtol, errors="raise", workers=computation.workers,
    ).tolist()  # fmt: skip
    computation.advance(n + 2)
    numbers: dict[str, float] = {"e, incompressible": limit}
    for nu, e in zip(_NEAR_HALF, values, strict=True):
        numbers[f"e, nu = {nu:g}"] = e
        numbers[f"nu_0, nu = {nu:g}"] = float(figures.instantaneous_poisson_ratio(nu, p2))
        numbers[f"(e - e_inc)/e_inc, nu = {nu:g}"] = (e - limit) / limit
        numbers[f"(e_inc - e)/e, nu = {nu:g}"] = (limit - e) / e
    e = values[_NEAR_HALF.index(0.49)]
    excess, other = (e - limit) / limit, (second - second_limit) / second_limit
    glass, other_glass = (
        float(figures.instantaneous_poisson_ratio(*pair)) for pair in ((0.49, p2), (plausible, other_p2))
    )
    where = f"nu = {plausible:g}, p2 = {other_p2:g}, p3 = {other_p3:g}"
    numbers |= {
        f"e, {where}": second,
        f"e, incompressible, p2 = {other_p2:g}, p3 = {other_p3:g}": second_limit,
        f"nu_0, {where}": other_glass,
        f"(e - e_inc)/e_inc, {where}": other,
    }
    return Claim(
        "100 % and more near nu = 0.5",
        "Relative errors of 100 % and more are possible even for nu very close to 0.5, e.g. nu = 0.49 at "
        "log10 p2 = -3, p3 = 10 (Fig. 6).",
        excess >= 1.0 and other >= 1.0,
        f"There e = {e:.6f} against {limit:.6f} in the incompressible limit: {100 * excess:.0f} % above the "
        f"incompressible value, which is {100 * (e - limit) / e:.1f} % below the compressible one. The glass of that "
        f"material has the Poisson ratio nu_0 = {glass:.2f}; no polymer is known to have one. With a plausible glass, "
        f"nu_0 = {other_glass:.2f}, the claim still holds: e = {second:.4f} against {second_limit:.4f}, "
        f"{100 * other:.0f} % above, at {where}.",
        numbers,
    )


def stiffer() -> Claim:
    """Judge that the incompressible material is the stiffer one, by E*(t) of both over time."""
    numbers: dict[str, float] = {}
    smallest = np.inf
    lowest = np.inf
    time = np.concatenate([[0.0], np.logspace(-4, 6, 201)])
    for p2 in (1e-3, 1e-2):
        # Ginf = tau = 1.
        limit = reduced_modulus(standard_solid(1.0, 1.0 / p2, 1.0 / p2, poisson_ratio=0.5))
        for nu in POISSON_RATIOS:
            modulus = reduced_modulus(standard_solid(1.0, 1.0 / p2, 1.0 / p2, poisson_ratio=nu))
            ratio = limit.relaxation_modulus(time) / modulus.relaxation_modulus(time)
            smallest = min(smallest, float(ratio[0]), float(ratio[-1]))
            lowest = min(lowest, float(ratio.min()))
            if nu in (0.45, 0.49, 0.499):
                words = f"nu = {nu:g}, p2 = {p2:g}"
                numbers[f"instantaneous E*_inc/E*, {words}"] = float(ratio[0])
                numbers[f"equilibrium E*_inc/E*, {words}"] = float(ratio[-1])
                numbers[f"smallest E*_inc(t)/E*(t), {words}"] = float(ratio.min())
    numbers["smallest instantaneous or equilibrium E*_inc/E*, all Poisson ratios of figures 5 and 6"] = smallest
    numbers["smallest E*_inc(t)/E*(t), the same"] = lowest
    glass, rest, least = (
        numbers[f"{words}, nu = 0.49, p2 = 0.001"]
        for words in ("instantaneous E*_inc/E*", "equilibrium E*_inc/E*", "smallest E*_inc(t)/E*(t)")
    )
    return Claim(
        "the incompressible material is stiffer",
        "The incompressible material is stiffer, instantaneously and at equilibrium, than the compressible one of the "
        "same shear moduli.",
        smallest > 1.0,
        f"For nu = 0.49 and p2 = 0.001 its instantaneous reduced modulus is {glass:.2f} times and its equilibrium "
        f"modulus {rest:.2f} times as large. In between it is softer, down to {least:.2f} times: the compressible "
        "modulus relaxes more slowly, in the time tau (3K + 4 G0)/(3K + 4 Ginf) instead of tau.",
        numbers,
    )


def compute_terms(computation: figures.Computation, n: int) -> xr.Dataset:
    """Return e over p3 for one, two and three relaxation times, incompressible and with nu = 0.45.

    Each further relaxation time is a tenth of the one before, and the branch moduli are equal shares of Ginf/p2. The
    viscosity in p3 is the sum of the branch moduli times the longest relaxation time. The mass of the sphere
    varies p3.
    """

    def impact(terms: float, poisson_ratio: float) -> Impact:
        shear = PronySeries(1.0, [1.0 / (_TERMS_P2 * terms)] * int(terms), 10.0 ** -np.arange(terms))
        return Impact(Material(shear, bulk_factor(poisson_ratio)), Parabola(1.0), 1.0, 1.0)

    p3 = np.logspace(*figures.LOG_P3_RANGE, n)
    # eta = tau Ginf/p2 with tau = Ginf = R = v0 = 1, and p3 = eta m^(-2/5).
    axes = {"poisson_ratio": [0.45, 0.5], "terms": list(TERMS), "mass": (p3 * _TERMS_P2) ** -2.5}
    dataset = computation.sweep("Restitution coefficient over p3 for several relaxation times", axes, impact)
    dataset = dataset.assign_coords(p3=("mass", p3), p2=_TERMS_P2).swap_dims(mass="p3")
    return figures.described(dataset, terms="number of relaxation times")


def several_times(terms: xr.Dataset) -> Claim:
    """Judge that several relaxation times inhibit the return to the elastic domain, by e at large p3."""
    numbers: dict[str, float] = {}
    ends = terms["restitution_coefficient"].isel(p3=-1)
    for nu in terms["poisson_ratio"].values:
        for count in terms["terms"].values:
            at = float(ends.sel(poisson_ratio=nu, terms=count))
            numbers[f"e at p3 = 100, nu = {nu:g}, relaxation times: {count:g}"] = at
    holds = bool((ends.isel(terms=slice(1, None)) < ends.isel(terms=0)).all())
    single, *_, last = (float(ends.sel(poisson_ratio=0.5, terms=count)) for count in terms["terms"].values)
    return Claim(
        "several relaxation times",
        "With several relaxation times the return to the elastic domain, at large p3, is inhibited.",
        holds,
        f"With the branch modulus spread over relaxation times that are a factor of 10 apart, e at p3 = 100 and "
        f"p2 = {float(terms['p2']):g} falls from {single:.3f} for one time to {last:.3f} for "
        f"{int(terms['terms'].max())} (incompressible). The slow terms are frozen, but the fast ones still dissipate.",
        numbers,
    )


def two_spheres(computation: figures.Computation) -> Claim:
    """Judge that two deformable spheres show nothing qualitatively new, by the exact map onto one sphere."""

    def pair(
        poisson_ratio: float,
        p2: float,
        p3: float,
        mass: float,
        radius: float,
        velocity: float,
        equilibrium_modulus: float,
    ) -> Impact:
        viscosity = p3 * viscosity_unit(equilibrium_modulus, mass, velocity, radius)
        solid = standard_solid(equilibrium_modulus, equilibrium_modulus / p2, viscosity, poisson_ratio=poisson_ratio)
        ball = Body(solid, radius=radius, mass=mass)
        return collision(ball, ball, velocity)

    ratios = [*POISSON_RATIOS, 0.5]
    plane = {
        name: LogUniform(*(10.0**end for end in ends))
        for name, ends in (("p2", figures.LOG_P2_RANGE), ("p3", figures.LOG_P3_RANGE))
    }
    draws = Samples(PAIRS // len(ratios), plane | figures.BODIES, rng=computation.seed)
    dataset = computation.sweep("Collisions of two spheres", {"poisson_ratio": ratios, "draw": draws}, pair)
    pairs = dataset["restitution_coefficient"].values
    # E*, R and m of the pair are halves, so that p3 is 2^(-1 + 4/5) times that of one sphere.
    nu, p2, p3 = np.array(ratios)[:, None], dataset["p2"].values, 2.0**-0.2 * dataset["p3"].values
    single = standard_solid_restitution(nu, p2, p3, rtol=computation.rtol, errors="raise", workers=computation.workers)
    computation.advance(PAIRS)
    difference = float(np.abs(pairs - single).max())
    return Claim(
        "two spheres",
        "The collision of two deformable spheres shows no qualitatively different features.",
        difference <= 10.0 * computation.rtol,
        f"Two equal spheres rebound as one on a half-space with 2^(-1/5) times its p3: at {PAIRS} random points of "
        f"the plane the two differ in e by at most {difference:.1e}. For unequal spheres the compliances add, which "
        "again gives a Prony series.",
        {"points": PAIRS, "largest difference of e": difference},
    )


def number_of_solves() -> int:
    """Return how many impacts the claims solve beyond those of the figures."""
    return len(_NEAR_HALF) + 3 + 2 * PAIRS


def as_json(claims: Sequence[Claim], attributes: Mapping[str, Any]) -> str:
    """Return the claims as JSON text, numbers in full."""
    return json.dumps({**attributes, "claims": [asdict(claim) for claim in claims]}, indent=2) + "\n"


def as_markdown(claims: Sequence[Claim], attributes: Mapping[str, Any]) -> str:
    """Return the claims as a Markdown page, one section and one table each."""
    lines = [
        "# Claims of the paper",
        "",
        f"{attributes['references']}.",
        "",
        f"Computed by {attributes['source']}, method {attributes['method']}, rtol {attributes['rtol']:g}, "
        f"seed {attributes['seed']}. `e` is the restitution coefficient, `e_inc` its "
        "incompressible value, `nu_0` the instantaneous Poisson ratio.",
        "",
        f"{attributes['guessed']}",
        "",
        "| claim | confirmed |",
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
            f"**{'Confirmed' if claim.holds else 'Not confirmed'}.** {claim.finding}",
            "",
            "| quantity | value |",
            "|---|---:|",
            *(f"| {words} | {value:.6g} |" for words, value in claim.numbers.items()),
        ]
    return "\n".join(lines) + "\n"
