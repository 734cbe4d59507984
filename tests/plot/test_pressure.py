"""Pictures of the pressure of artificial contacts."""

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
import xarray as xr

from restitution.plot import impact as plots
from restitution.plot import style


def contact(pressure: Any) -> Any:
    """Contact of 3 ms with the largest depth at 1 ms and the radius sqrt(d R) of a parabola."""
    t = np.linspace(0.0, 3e-3, 301)
    depth = np.where(t < 1e-3, 1.0 - (1.0 - t / 1e-3) ** 2, 1.0 - ((t - 1e-3) / 2e-3) ** 2) * 1e-4
    motion = xr.Dataset(
        {
            "indentation_depth": ("time", depth),
            "indentation_velocity": ("time", np.gradient(depth, t)),
            "contact_radius": ("time", np.sqrt(0.0144 * depth)),
        },
        {"time": t},
    )

    def sample(times: Any) -> xr.Dataset:
        return motion.interp(time=np.asarray(times))

    def at(r: Any, time: float) -> Any:
        return pressure(np.asarray(r), float(sample([time]).contact_radius.values[0]))

    return SimpleNamespace(contact_time=3e-3, turning_time=1e-3, sample=sample, pressure=at)


def hertz(r: Any, a: float) -> Any:
    return 2e9 * np.sqrt(np.maximum(a * a - r * r, 0.0))


def test_four_instants_of_approach_and_rebound() -> None:
    impact = contact(hertz)
    assert plots.instants(impact) == pytest.approx([0.5e-3, 1e-3, 1e-3 + 2e-3 / 3, 1e-3 + 4e-3 / 3], rel=1e-12)
    ax = plots.pressure_radius(style.new_figure().add_subplot(), impact)
    assert [line.get_linestyle() for line in ax.lines] == ["-", "-", "--", "--"]
    assert (ax.get_xlabel(), ax.get_ylabel()) == ("radius $r$ [mm]", "pressure $p$ [MPa]")


def test_curves_have_the_pressure_in_the_units_of_the_labels() -> None:
    impact = contact(hertz)
    ax = plots.pressure_radius(style.new_figure().add_subplot(), impact, [1e-3])
    r, p = ax.lines[0].get_data()
    assert r[-1] == pytest.approx(1.2, rel=2e-6)
    assert p == pytest.approx(2.0 * np.sqrt(np.maximum(1.44 - r**2, 0.0)), abs=1e-12)
    assert ax.get_legend().get_texts()[0].get_text() == "1 ms"


def test_infinite_pressure_at_the_edge_does_not_set_the_scale() -> None:
    def punch(r: Any, a: float) -> Any:
        with np.errstate(divide="ignore"):
            return 1e3 / np.sqrt(np.maximum(1.0 - (r / a) ** 2, 0.0))

    ax = plots.pressure_radius(style.new_figure().add_subplot(), contact(punch), [1e-3, 2e-3])
    # At 0.97 a the pressure is 1/sqrt(1 - 0.97^2) = 4.1 times that on the axis.
    assert 4.0 < ax.get_ylim()[1] < 5.5
    assert ax.get_ylabel() == "pressure $p$ [kPa]"


@pytest.mark.parametrize("time", [0.0, 3e-3, 0.1])
def test_times_outside_the_contact_are_refused(time: float) -> None:
    with pytest.raises(ValueError, match=r"times.*within the contact"):
        plots.pressure_radius(style.new_figure().add_subplot(), contact(hertz), [1e-3, time])


def test_too_many_curves_are_refused() -> None:
    with pytest.raises(ValueError, match=r"times = 8.*1 to 7"):
        plots.pressure_radius(style.new_figure().add_subplot(), contact(hertz), np.linspace(1e-4, 2e-3, 8))
