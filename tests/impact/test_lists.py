"""Lists of impacts: similar impacts are solved in one block, and each has its own outcome."""

import math

import numpy as np
import pytest

from refusals import warns
from restitution import (
    Cone,
    Impact,
    Material,
    Parabola,
    PronySeries,
    RestitutionWarning,
    SolverError,
    Sphere,
    Status,
    TruncatedCone,
    solve,
)

# Many of these bodies exceed the limits of the theory.
pytestmark = pytest.mark.filterwarnings(r"ignore:.*; exceeded in \d+ of")

SOLID = Material(PronySeries(1.0, [3.0], [0.5]), math.inf)
LIQUID = Material(PronySeries(0.0, [1.0], [0.03]), math.inf)
GOOD = Impact(SOLID, Parabola(1.0), 1.0, 1.0)
# The energy overflows.
TOO_FAST = Impact(SOLID, Parabola(1.0), 1.0, 1e200)


def test_a_failure_affects_no_other_impact_of_its_block():
    alone = solve(GOOD).restitution_coefficient
    for impacts, place in (([GOOD, TOO_FAST, GOOD], 1), ([GOOD, GOOD, TOO_FAST], 2), ([TOO_FAST, GOOD], 0)):
        with warns("failed"):
            result = solve(impacts)
        failed = np.isnan(result.restitution_coefficient)
        assert np.flatnonzero(failed).tolist() == [place]
        assert set(result.restitution_coefficient[~failed]) == {alone}
        assert [Status(int(status)).failed for status in result.status] == failed.tolist()
        with pytest.raises(SolverError, match=rf"\(impact {place} of {len(impacts)}\)$"):
            solve(impacts, errors="raise")


def test_results_of_several_blocks_keep_their_order():
    impacts = [
        Impact(LIQUID, Parabola(1.0), 1.0, 1.0),
        GOOD,
        Impact(SOLID, Cone(1.2), 1.0, 1.0),
        Impact(SOLID, Parabola(1.0), 1.0, 2.0),
        Impact(SOLID, Parabola(1.0), 1.0, 1.0, external_force=30.0),
        Impact(SOLID, Sphere(3.0), 1.0, 1.0),
        Impact(Material(PronySeries(1.0, [3.0, 0.3], [0.5, 5.0]), 10.0), Parabola(2.0), 0.8, 0.1),
        Impact(SOLID, TruncatedCone(0.1, 1.2), 1.0, 1.0, external_force=0.05),
    ]
    together = solve(impacts)
    assert together.status.tolist() == [Status.SINKS_IN, 0, 0, 0, Status.CAPTURED, 0, 0, 0]
    assert together.velocity.tolist() == [impact.velocity for impact in impacts]
    for n, impact in enumerate(impacts):
        alone = solve(impact)
        for name in ("restitution_coefficient", "contact_time", "max_indentation_depth", "max_force"):
            assert getattr(together, name)[n] == getattr(alone, name), (n, name)
        dissipated = together.energy.dissipated[n]
        assert dissipated == pytest.approx(alone.energy.dissipated, rel=1e-9, nan_ok=True)


def test_one_warning_counts_the_impacts_beyond_each_limit():
    """The count of exceeded limits of small strain equals that of single results."""
    velocities = np.geomspace(1e-5, 1e-2, 12)
    many = Impact(SOLID, Parabola(1.0), 1e4, velocities)
    singles = [Impact(SOLID, Parabola(1.0), 1e4, v) for v in velocities]
    mixed = [*singles[:5], Impact(SOLID, Cone(0.05), 1.0, 1e-3), *singles[5:]]
    for impacts, size in ((many, 12), (singles, 12), (mixed, 13)):
        with pytest.warns(RestitutionWarning) as caught:
            result = solve(impacts)
        count = sum(solve(item).validity["small_strain"].exceeded for item in (singles if size == 12 else mixed))
        assert 0 < count < size
        assert [item.message.kind for item in caught] == ["small_strain"]
        assert f"; exceeded in {count} of {size} impacts. " in str(caught[0].message)
        assert result.warnings == [str(caught[0].message)]
        assert caught[0].filename == __file__


def test_doubtful_materials_among_500_different_ones_are_counted():
    """Three assumptions on the material, each exceeded by a few impacts of 500; the same numbers as one at a time."""
    rng = np.random.default_rng(3)
    sound = {"density": 1000.0, "window": (1e-9, 1e9)}

    def material(**options):
        return Material(PronySeries(rng.uniform(5e6, 6e6), [rng.uniform(4e6, 5e6)], [1e-3]), **(sound | options))

    def impact(material, counter_material=None):
        return Impact(material, Parabola(0.01), 0.005, 1e-3, counter_material=counter_material)

    impacts = [impact(material(bulk=rng.choice([2e9, math.inf]))) for _ in range(500)]
    doubtful = {
        "waves": [impact(material(bulk=2e9, density=1e9))],
        "window": [impact(material(bulk=2e9), material(bulk=2e9, window=(1e-9, 1e-6))) for _ in range(2)],
        "poisson_ratio": [impact(material(bulk=5e6), material(bulk=2e9)) for _ in range(3)],
    }
    places = rng.permutation(500)
    for item in (item for some in doubtful.values() for item in some):
        impacts[places[0]], places = item, places[1:]
    with pytest.warns(RestitutionWarning) as caught:
        result = solve(impacts)
    assert {item.message.kind for item in caught} == doubtful.keys()
    for item in caught:
        kind = item.message.kind
        assert f"; exceeded in {len(doubtful[kind])} of 500 impacts" in str(item.message)
        worst = max(abs(solve(impact).validity[kind].value) for impact in doubtful[kind])
        assert abs(result.validity[kind].value) == pytest.approx(worst, rel=1e-12)


def test_a_body_and_a_ball_of_one_material_are_not_a_body_alone():
    """Two equal balls have four times their density by reduced mass and radius: their limit is four times higher."""
    mass = 5e4 * 4.0 / 3.0 * math.pi
    impacts = [Impact(SOLID, Parabola(1.0), mass, 1e-3, counter_material=counter) for counter in (SOLID, None)]
    assert [solve(item).validity["density"].exceeded for item in impacts] == [False, True]
    assert "; exceeded in 1 of 2 impacts" in solve(impacts).validity["density"].message
