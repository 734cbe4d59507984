"""Result of a test of rebound resilience: a table over temperature and base, a picture, warnings."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from restitution.display import Shown, Summary, Table, celsius
from restitution.material.viscoelastic import Material
from restitution.pictures import draw
from restitution.quantities import INPUTS, MODULI, OUTPUTS, Dimension, Quantity
from restitution.rebound_resilience.standards import Standard
from restitution.validity import Validity

if TYPE_CHECKING:
    import pandas
    import xarray
    from matplotlib.figure import Figure

Array = NDArray[np.float64]

COLUMNS = {
    "rebound_resilience": Quantity("rebound_resilience", Dimension("percentage", "%"), "rebound resilience", r"$R$"),
    **{name: OUTPUTS[name] for name in ("contact_time", "max_indentation_depth", "max_contact_radius", "max_force")},
    "loss_tangent": MODULI["loss_tangent"]._replace(words="loss tangent at pi over the contact time"),
}
"""Columns of the result."""

# Columns of the printed table: heading, factor from SI, format.
_SHOWN = {
    "rebound_resilience": ("R [%]", 1.0, "{:.2f}"),
    "contact_time": ("contact [ms]", 1e3, "{:.3g}"),
    "max_indentation_depth": ("depth [mm]", 1e3, "{:.3g}"),
    "max_contact_radius": ("radius [mm]", 1e3, "{:.3g}"),
    "max_force": ("force [N]", 1.0, "{:.4g}"),
    "loss_tangent": ("loss tangent", 1.0, "{:.3g}"),
}
_TREND = "R is a trend: rebound tests are at the edge of small strain, and the side of the pad is free."


@dataclass(frozen=True, eq=False, repr=False)
class Resilience(Shown):
    """Rebound resilience of a material in a standard test; made by `resilience`.

    The arrays have the shape (n_temperature, n_base), or (n_base,) without temperatures.

    Attributes
    ----------
    standard : Standard
        The test with the numbers that were used; `sources` has the source of each number.
    material : Material
        Material of the pad.
    base : tuple of str
        How the pad is held.
    temperature : array or None
        Temperatures [K], if any were given.
    rebound_resilience : array
        R = e^2 [%]; 0 where the body stays.
    contact_time : array
        Duration of contact [s]; infinite where the body stays.
    max_indentation_depth, max_contact_radius, max_force : array
        Largest depth [m], contact radius [m] and force [N].
    loss_tangent : array
        Loss tangent [-] of the material at the angular frequency pi over the contact time.
    validity : Validity
        Report on the assumptions of the theory: the worst of each.
    notes : tuple of str
        Ways to hold the pad that were left out, with the reason.
    """

    standard: Standard
    material: Material
    base: tuple[str, ...]
    temperature: Array | None
    rebound_resilience: Array
    contact_time: Array
    max_indentation_depth: Array
    max_contact_radius: Array
    max_force: Array
    loss_tangent: Array
    validity: Validity
    notes: tuple[str, ...] = ()

    def __post_init__(self) -> None:
        if self.temperature is None:
            for name in COLUMNS:
                object.__setattr__(self, name, getattr(self, name)[0])

    @property
    def frequency(self) -> Array:
        """Frequency 1/(2T) [Hz] of contacts that last T."""
        return 0.5 / self.contact_time

    @property
    def warnings(self) -> list[str]:
        """Doubtful assumptions, with numbers, and the general limit of these tests."""
        return [*self.validity.warnings, *self.notes, _TREND]

    def to_dataset(self) -> xarray.Dataset:
        """Dataset of all columns over `temperature` and `base`, with units."""
        import xarray as xr

        dims = ("base",) if self.temperature is None else ("temperature", "base")
        data = {name: (dims, getattr(self, name), quantity.attributes) for name, quantity in COLUMNS.items()}
        coordinates: dict[str, Any] = {"base": list(self.base)}
        if self.temperature is not None:
            coordinates["temperature"] = ("temperature", self.temperature, INPUTS["temperature"].attributes)
        return xr.Dataset(data, coordinates, {"standard": self.standard.name, "material": self.material.name or ""})

    @property
    def table(self) -> pandas.DataFrame:
        """Table as texts in mm, ms and N, a row for each temperature and base."""
        frame = self.to_dataset().to_dataframe()
        shown = {
            head: [form.format(factor * value) for value in frame[name]]
            for name, (head, factor, form) in _SHOWN.items()
        }
        return type(frame)(shown, index=frame.index)

    def plot(self) -> Figure:
        """Figure of the resilience and the contact time, over temperature if there are several."""
        return draw("rebound_resilience.overview", self)

    def to_dict(self) -> dict[str, Any]:
        """Return plain numbers and texts, in SI apart from R."""
        test = self.standard
        return {
            "standard": {
                **{name: getattr(test, name) for name in ("name", "words", "radius", "mass", "velocity", "thickness")},
                "sources": dict(test.sources),
            },
            "base": list(self.base),
            "temperature": None if self.temperature is None else self.temperature.tolist(),
            **{name: getattr(self, name).tolist() for name in COLUMNS},
            "units": {name: quantity.unit for name, quantity in COLUMNS.items()},
            "warnings": self.warnings,
            "validity": self.validity.to_dict(),
        }

    @property
    def heading(self) -> str:
        """The test in one line."""
        one = self.standard
        return (
            f"{one.name}, {one.words}: sphere of {2e3 * (one.radius or 0.0):.4g} mm, {1e3 * (one.mass or 0.0):.4g} g, "
            f"{one.velocity:.3g} m/s, pad of {1e3 * one.thickness:.4g} mm"
        )

    def summary(self, title: str = "") -> Summary:
        """Table over temperature and base, sources and warnings, which `print` and notebooks show."""
        table = self.table.reset_index()
        if self.temperature is not None:
            table["temperature"] = [celsius(kelvin) for kelvin in table["temperature"]]
        rows = [tuple(map(str, row)) for row in table.itertuples(index=False)]
        heads = tuple("temperature [°C]" if name == "temperature" else str(name) for name in table.columns)
        sources = [
            f"{name}: {text.partition(': ')[2]} [{text.partition(':')[0]}]"
            for name, text in self.standard.sources.items()
        ]
        return Summary(title or self.heading, Table(heads, rows), sources, warnings=self.warnings)

    @property
    def _short(self) -> str:
        values = ", ".join(f"{value:.4g} %" for value in self.rebound_resilience.ravel()[:4])
        return f"{self.standard.name}: {values}{', ...' if self.rebound_resilience.size > 4 else ''}"
