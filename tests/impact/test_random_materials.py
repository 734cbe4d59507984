"""Random materials on every profile: invariance under equivalent inputs, and admissible results."""

import math
from collections.abc import Callable

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from restitution import Impact, ImpactResult, InputError, Material, PronySeries, Status, Tabulated, solve
from restitution.contact.profiles import (
    Cone,
    FlatEndedParabola,
    FlatPunch,
    Parabola,
    PowerLaw,
    Profile,
    Sphere,
    TruncatedCone,
)
from strategies import logarithmic, materials

RTOL = 1e-9
ANGLE = st.floats(0.2, 1.5)
SIZE = logarithmic(1e-2, 1e2)
KNOTS = np.array([0.0, 0.1, 0.25, 0.3, 0.5, 0.8, 1.0, 1.4, 1.7, 2.0])

# Each builds a profile for a given unit of length.
Build = Callable[[float], Profile]
BUILDS: dict[str, st.SearchStrategy[Build]] = {
    "parabola": SIZE.map(lambda r: lambda unit: Parabola(r * unit)),
    "sphere": SIZE.map(lambda r: lambda unit: Sphere(r * unit)),
    "cone": ANGLE.map(lambda angle: lambda unit: Cone(angle)),
    "power law": st.tuples(st.sampled_from([0.7, 1.0, 1.5, 2.0, 3.0, 4.0, 6.0]), SIZE).map(
        lambda pair: lambda unit: PowerLaw(pair[0], pair[1] * unit ** (1.0 - pair[0]))
    ),
    "flat punch": SIZE.map(lambda r: lambda unit: FlatPunch(r * unit)),
    "truncated cone": st.tuples(SIZE, ANGLE).map(lambda pair: lambda unit: TruncatedCone(pair[0] * unit, pair[1])),
    "flat-ended parabola": st.tuples(SIZE, SIZE).map(
        lambda pair: lambda unit: FlatEndedParabola(pair[0] * unit, pair[1] * unit)
    ),
    "table": st.tuples(SIZE, st.floats(0.0, 0.5)).map(
        lambda pair: (
            lambda unit: Tabulated(
                100.0 * pair[0] * unit * KNOTS, 100.0 * pair[0] * unit * (KNOTS**2 + pair[1] * KNOTS)
            )
        )
    ),
}
PROFILES = st.sampled_from(sorted(BUILDS)).flatmap(BUILDS.__getitem__)


def solved(impact: Impact) -> ImpactResult | None:
    """Return the result, or None if the indentation is deeper than the table."""
    try:
        return solve(impact, rtol=RTOL)
    except InputError as refusal:
        if refusal.field != "profile":
            raise
        return None


def reordered(series: PronySeries, share: float, k: int, seed: int) -> PronySeries:
    """Return the same function with branch k split, a branch of zero modulus, and another order."""
    if series.n_branches == 0:
        return series
    moduli, times = series.branch_moduli, series.relaxation_times
    k %= series.n_branches
    moduli = np.append(moduli, [share * moduli[k], 0.0])
    moduli[k] *= 1.0 - share
    order = np.random.default_rng(seed).permutation(moduli.size)
    return PronySeries(
        series.equilibrium_modulus,
        moduli[order],
        np.append(times, [times[k], 0.3])[order],
        parallel_viscosity=series.parallel_viscosity,
    )


def in_units(series: PronySeries | float, pressure: float, time: float) -> PronySeries | float:
    return series.scaled(pressure, time_factor=time) if isinstance(series, PronySeries) else series


def check_outcome(result: ImpactResult, impact: Impact) -> None:
    if result.status is Status.SINKS_IN:
        assert impact.reduced_modulus.is_liquid
        assert result.restitution_coefficient == 0.0
        assert result.contact_time == math.inf
        assert 0.0 < result.max_indentation_depth < math.inf
        return
    assert result.status is Status.SEPARATED
    assert 0.0 < result.restitution_coefficient <= 1.0 + RTOL
    assert 0.0 < result.contact_time < math.inf
    assert 0.0 < result.max_force < math.inf
    depth = result.max_indentation_depth
    assert -1e-8 * depth <= result.residual_indentation_depth <= depth < math.inf
    assert result.energy.dissipated >= 0.0
    assert result.energy.stored >= 0.0
    # Far beyond its equator a sphere is a cylinder, and the energy there is less accurate than e.
    if not isinstance(impact.profile, Sphere) or depth < 100.0 * impact.profile.radius:
        assert abs(result.energy.residual) < 10.0 * RTOL


def check_same(impact: Impact, expected: ImpactResult, units: tuple[float, float, float]) -> None:
    mass, length, time = units
    result = solve(impact, rtol=RTOL)
    assert result.status is expected.status
    # Both results are within the tolerance.
    bound = 2.0 * RTOL * max(expected.restitution_coefficient, 1e-3)
    assert abs(result.restitution_coefficient - expected.restitution_coefficient) <= bound
    # The contact time is undetermined if the rebound velocity is below the tolerance.
    if expected.status is Status.SEPARATED and expected.restitution_coefficient > 1e-3 * RTOL:
        # A slow rebound ends as late as its velocity is small: its share of error is that of e.
        share = max(1e-7, bound / float(expected.restitution_coefficient))
        assert result.contact_time == pytest.approx(expected.contact_time * time, rel=share)
        assert result.max_indentation_depth == pytest.approx(expected.max_indentation_depth * length, rel=1e-8)
        assert result.max_force == pytest.approx(expected.max_force * mass * length / time**2, rel=1e-7)


def check(
    material: Material,
    build: Build,
    mass: float,
    velocity: float,
    units: tuple[float, float, float],
    split: tuple[float, int, int],
) -> None:
    impact = Impact(material, build(1.0), mass, velocity)
    result = solved(impact)
    if result is None:
        return
    check_outcome(result, impact)

    bulk = reordered(material.bulk, *split) if isinstance(material.bulk, PronySeries) else material.bulk
    other = Impact(Material(reordered(material.shear, *split), bulk), build(1.0), mass, velocity)
    check_same(other, result, (1.0, 1.0, 1.0))

    unit_mass, length, time = units
    pressure = unit_mass / (length * time**2)
    shear, bulk = (in_units(series, pressure, time) for series in (material.shear, material.bulk))
    scaled = Impact(Material(shear, bulk), build(length), mass * unit_mass, velocity * length / time)
    check_same(scaled, result, units)


DRAWN = {
    "material": st.one_of(materials(liquid=None), materials(viscosity=True)),
    "build": PROFILES,
    "mass": logarithmic(1e-3, 1e3),
    "velocity": logarithmic(1e-3, 1e3),
    "units": st.tuples(logarithmic(1e-6, 1e6), logarithmic(1e-6, 1e6), logarithmic(1e-6, 1e6)),
    "split": st.tuples(st.floats(0.05, 0.95), st.integers(0, 24), st.integers(0, 2**32 - 1)),
}


@pytest.mark.parametrize("count", [25, pytest.param(600, marks=pytest.mark.slow)])
def test_any_material_on_any_profile(count):
    """1 to 25 branches in shear and bulk over twelve decades, dashpots and liquids among them."""
    settings(max_examples=count, deadline=None, derandomize=True)(given(**DRAWN)(check))()
