"""The bits of an impact do not depend on its neighbours, on the shape of the array, or on the threads."""

from typing import Any

import numpy as np
import pytest

import restitution as rs
from restitution.impact.status import Status

SOLID = rs.Material(rs.PronySeries(1e6, [1e7], [1e-4]), np.inf)
NAMES = (
    "status",
    "restitution_coefficient",
    "contact_time",
    "max_indentation_depth",
    "max_force",
    "max_contact_radius",
)

# Large velocities exceed the limits of the theory on purpose.
pytestmark = pytest.mark.filterwarnings("ignore::restitution.errors.RestitutionWarning")


def profiles(rng: np.random.Generator) -> dict[str, Any]:
    size = 10.0 ** rng.uniform(-3.0, -1.0)
    r = size * np.append(0.0, np.cumsum(rng.uniform(0.5, 1.0, 30))) / 20.0
    rough = r**2 / (2.0 * size) * (1.0 + 2e-3 * np.sin(30.0 * r / size))
    tip = rs.FlatEndedParabola(size, size * rng.uniform(0.001, 0.1))
    return {
        "sphere": rs.Sphere(size),
        "flat-ended parabola": tip,
        "truncated cone": rs.TruncatedCone(0.05 * size, rng.uniform(1.0, 1.5)),
        "tabulated": rs.Tabulated(r, r**2 / (2.0 * size)),
        "rough tip": rs.Tabulated(r, rough),
        "layer": rs.Layer(rs.Parabola(size), size * rng.uniform(0.2, 1.0), base="frictionless"),
        "layer under a table": rs.Layer(tip, size * rng.uniform(0.2, 1.0)),
        "power law": rs.PowerLaw(rng.uniform(1.0, 3.0), 10.0),
    }


@pytest.mark.parametrize("kind", list(profiles(np.random.default_rng(0))))
def test_a_row_has_the_bits_of_a_single_impact(kind: str) -> None:
    rng = np.random.default_rng()
    profile: Any = profiles(rng)[kind]
    body: Any = profile.profile if isinstance(profile, rs.Layer) else None
    mass = 1e4 * body.radius**3 if body else 1e-3
    # Two decades and a half; some rows may be deeper than a table.
    velocities = 10.0 ** rng.uniform(-3.0, -0.5, 24)

    def columns(v: object, workers: int | None = None) -> np.ndarray:
        result = rs.solve(rs.Impact(SOLID, profile, mass, v), workers=workers)  # type: ignore[arg-type]
        return np.array([getattr(result, name) for name in NAMES])

    def same(first: np.ndarray, other: np.ndarray) -> bool:
        return first.tobytes() == np.ascontiguousarray(other).tobytes()

    whole = columns(velocities)
    alone = np.array([columns(float(v)) for v in velocities[:6]]).T
    assert same(alone, whole[:, :6])
    first, last = np.sort(rng.choice(24, 2, replace=False))
    assert same(columns(velocities[first : last + 1]), whole[:, first : last + 1])
    order = rng.permutation(24)
    assert same(columns(velocities[order], 3), whole[:, order])
    assert same(columns(velocities.reshape(4, 6), 1).reshape(len(NAMES), -1), whole)
    listed = rs.solve([rs.Impact(SOLID, profile, mass, float(v)) for v in velocities[order]])
    assert same(np.array([getattr(listed, name) for name in NAMES]), whole[:, order])


def test_a_row_beyond_its_table_leaves_its_neighbours_alone() -> None:
    """A liquid creeps far below the estimated depth; its row takes a longer table, and the other its own."""
    liquid = rs.Material(rs.PronySeries(0.0, [1e6], [1e-5]), np.inf)
    impacts = [rs.Impact(m, rs.Sphere(0.01), 1e-3, v) for m, v in ((SOLID, 0.1), (liquid, 0.3), (liquid, 1.0))]
    together = rs.solve(impacts)
    for n, impact in enumerate(impacts):
        assert rs.solve(impact).restitution_coefficient == np.asarray(together.restitution_coefficient)[n]


def test_a_row_that_is_too_deep_does_not_hide_a_rough_table(monkeypatch: pytest.MonkeyPatch) -> None:
    """Each row is refused for its own reason."""
    # Cells that are never halved miss the joints of the tip.
    monkeypatch.setattr("restitution.contact.table._MOST_HALVINGS", 0)
    r = np.linspace(0.0, 1e-3, 12)
    tip = rs.Tabulated(r, r**2 / 0.02 * (1.0 + 0.1 * np.sin(5e3 * r)))
    alone, both = (rs.solve(rs.Impact(SOLID, tip, 1e-6, np.array(v))).status for v in ([0.01], [0.01, 30.0]))
    assert np.asarray(alone).tolist() == [Status.NOT_ACCURATE]
    assert np.asarray(both).tolist() == [Status.NOT_ACCURATE, Status.TOO_DEEP]
