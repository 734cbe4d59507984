"""Pictures of energies over time and in a bar."""

from types import SimpleNamespace

import numpy as np
import pytest
import xarray as xr

from restitution.plot import history as plots
from restitution.plot import style


@pytest.fixture
def history() -> xr.Dataset:
    """The kinetic energy is 2 mJ; the force does the work 0.5 mJ and then -0.25 mJ."""
    columns = {
        "kinetic_energy": [2e-3, 0.0, 1e-3],
        "stored_energy": [0.0, 1.75e-3, 0.5e-3],
        "dissipated_energy": [0.0, 0.75e-3, 0.75e-3],
    }
    return xr.Dataset({name: ("time", values) for name, values in columns.items()}, {"time": [0.0, 1e-3, 2e-3]})


def upper_edges(ax) -> list[np.ndarray]:
    """Largest ordinate of each area at the times of the history."""
    edges = []
    for area in ax.collections:
        points = area.get_paths()[0].vertices
        edges.append(np.array([points[np.isclose(points[:, 0], t), 1].max() for t in (0.0, 1.0, 2.0)]))
    return edges


def test_energies_are_stacked_and_add_up(history) -> None:
    ax = plots.energy_area(style.new_figure().add_subplot(), history)
    lost, kept, motion = upper_edges(ax)
    assert lost == pytest.approx([0.0, 0.75, 0.75], abs=1e-12)
    assert kept == pytest.approx([0.0, 2.5, 1.25], abs=1e-12)
    assert motion == pytest.approx([2.0, 2.5, 2.25], abs=1e-12)
    assert (ax.get_xlabel(), ax.get_ylabel()) == ("time since first touch $t$ [ms]", "energy [mJ]")


def test_the_initial_energy_is_dashed_and_the_legend_has_the_order_of_the_stack(history) -> None:
    ax = plots.energy_area(style.new_figure().add_subplot(), history)
    (before,) = ax.lines
    assert set(before.get_ydata()) == {2.0}
    assert before.get_linestyle() == "--"
    assert [text.get_text() for text in ax.get_legend().get_texts()] == ["kinetic", "stored", "dissipated"]


def test_history_of_another_method_is_refused(history) -> None:
    with pytest.raises(ValueError, match="stored_energy"):
        plots.energy_area(style.new_figure().add_subplot(), history.drop_vars("stored_energy"))


def test_energy_bars_add_up_to_the_initial_kinetic_energy() -> None:
    energy = SimpleNamespace(
        kinetic_in=2e-3, kinetic_out=1e-3, dissipated=6e-4, stored=4e-4, radiated=0.0, residual=1e-12
    )
    ax = plots.energy_bar(style.new_figure().add_subplot(), energy)
    edges = [(bar.get_x(), bar.get_x() + bar.get_width()) for bar in ax.patches]
    assert np.ravel(edges) == pytest.approx([0.0, 1.0, 1.0, 1.6, 1.6, 2.0], abs=1e-12)
    assert ax.get_xlabel() == "energy [mJ] (dashed: before the impact)"
    words = [text.get_text() for text in ax.get_legend().get_texts()]
    assert words == ["rebound 50.0 %", "dissipated 30.0 %", "left in the material 20.0 %"]
