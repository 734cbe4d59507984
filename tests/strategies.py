"""Hypothesis strategies for Prony series and materials, over everything that the package admits."""

import math
import os

import numpy as np
from hypothesis import HealthCheck, settings
from hypothesis import strategies as st

from restitution import Material, PronySeries

# A machine under load takes its time. The complete checks draw more examples.
settings.register_profile(
    "restitution", deadline=None, suppress_health_check=[HealthCheck.too_slow],
    max_examples=100 if "CI" in os.environ else 40,
)  # fmt: skip
settings.load_profile("restitution")

_GAPS = (0.0, 2.3e-16, 1e-15, 1e-12, 1e-8, 1e-3)


def logarithmic(low: float, high: float) -> st.SearchStrategy[float]:
    """Numbers between low > 0 and high, spread over their orders of magnitude."""
    return st.floats(math.log10(low), math.log10(high)).map(lambda exponent: min(max(10.0**exponent, low), high))


@st.composite
def prony_series(
    draw: st.DrawFn,
    *,
    min_branches: int = 0,
    max_branches: int = 25,
    times: tuple[float, float] = (1e-6, 1e6),
    moduli: tuple[float, float] = (1e-4, 1e4),
    liquid: bool | None = None,
    viscosity: bool | None = False,
    near_equal: bool = True,
) -> PronySeries:
    """Prony series, some with equal or nearly equal times; None means either."""
    count = draw(st.integers(min_branches, max_branches))
    tau = draw(st.lists(logarithmic(*times), min_size=count, max_size=count))
    if near_equal:
        for i in range(1, count):
            if draw(st.integers(0, 9)) == 0:
                tau[i] = tau[i - 1] * (1.0 + draw(st.sampled_from(_GAPS)))
    weights = draw(st.lists(logarithmic(*moduli), min_size=count, max_size=count))
    if liquid is None:
        liquid = draw(st.booleans())
    if viscosity is None:
        viscosity = draw(st.booleans())
    dashpot = draw(logarithmic(moduli[0] * times[0], moduli[1] * times[1])) if viscosity else 0.0
    needs_spring = count == 0 and not viscosity
    equilibrium = 0.0 if liquid and not needs_spring else draw(logarithmic(*moduli))
    return PronySeries(equilibrium, np.array(weights), np.array(tau), parallel_viscosity=dashpot)


@st.composite
def materials(
    draw: st.DrawFn,
    *,
    max_branches: int = 25,
    times: tuple[float, float] = (1e-6, 1e6),
    moduli: tuple[float, float] = (1e-4, 1e4),
    liquid: bool | None = False,
    viscosity: bool | None = False,
) -> Material:
    """Materials with Prony shear and with an infinite, constant, zero, proportional or Prony bulk modulus."""
    options = {"max_branches": max_branches, "times": times, "moduli": moduli}
    shear = draw(prony_series(liquid=liquid, viscosity=viscosity, **options))
    kind = draw(st.sampled_from(("infinite", "constant", "zero", "proportional", "prony", "same times")))
    bulk: PronySeries | float
    if kind == "infinite":
        bulk = math.inf
    elif kind == "constant":
        bulk = draw(logarithmic(*moduli))
    elif kind == "zero":
        bulk = 0.0
    elif kind == "proportional":
        bulk = shear.scaled(draw(logarithmic(1e-6, 1e6)))
    else:
        bulk = draw(prony_series(liquid=liquid, viscosity=viscosity, **options))
        if kind == "same times" and shear.n_branches:
            count = min(shear.n_branches, bulk.n_branches)
            shift = 1.0 + draw(st.sampled_from(_GAPS))
            bulk = PronySeries(
                bulk.equilibrium_modulus or (1.0 if count == 0 else 0.0),
                bulk.branch_moduli[:count],
                shear.relaxation_times[:count] * shift,
                parallel_viscosity=bulk.parallel_viscosity,
            )
    return Material(shear, bulk)
