"""The assumptions of the theory over a sweep: how many impacts exceed each limit, and the worst impact."""

from __future__ import annotations

import json
import math
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from restitution import validity
from restitution.sweeps.fingerprint import text_of
from restitution.validity import Numbers

if TYPE_CHECKING:
    import xarray as xr

Array = NDArray[np.float64]


def excess(numbers: Numbers) -> dict[str, Array]:
    """Return a number for each assumption and impact: above 1 where it is doubtful, NaN where it is not known."""
    low, high = validity.DENSITY_LIMITS
    share = numbers.radiated_energy_ratio / validity.RADIATION_LIMIT
    speed = numbers.mach_number / validity.SPEED_LIMIT
    strain = np.where(numbers.no_such_contact > 0.0, 1e30, 1.0) * numbers.strain_number
    with np.errstate(divide="ignore"):
        density = np.fmax(low / numbers.mean_density, numbers.mean_density / (high * numbers.density_factor))
    return {
        "small_strain": strain / validity.STRAIN_LIMIT,
        "half_space": numbers.contact_size_ratio / validity.SIZE_LIMIT,
        "waves": np.where(np.isnan(share), speed, share),
        "window": numbers.window_ratio,
        "poisson_ratio": 1.0 + np.minimum(numbers.poisson_ratio, 0.0) - numbers.instantaneous_poisson_ratio,
        "density": density,
    }


def without_material(numbers: Numbers) -> Numbers:
    """Return the numbers with NaN for those that depend on the material."""
    unknown = np.full(numbers.contact_time.shape, math.nan)
    return numbers._replace(
        mach_number=unknown,
        radiated_energy_ratio=unknown,
        window_ratio=unknown,
        instantaneous_poisson_ratio=unknown,
    )


class Tally:
    """Counts of the impacts that exceed each limit, and the worst of them; tallies of chunks add up."""

    def __init__(self) -> None:
        self.impacts = 0
        self.counts: dict[str, int] = {}
        self._worst: dict[str, tuple[float, Numbers]] = {}

    def add(self, numbers: Numbers) -> None:
        """Count some impacts."""
        self.impacts += numbers.contact_time.size
        for kind, values in excess(numbers).items():
            self.counts[kind] = self.counts.get(kind, 0) + int(np.count_nonzero(values > 1.0))
            if not np.isnan(values).all():
                place = int(np.nanargmax(values))
                self._keep(kind, float(values[place]), Numbers(*(one[place : place + 1] for one in numbers)))

    def merge(self, other: Tally) -> None:
        """Count the impacts of another tally too; the order of tallies does not matter."""
        self.impacts += other.impacts
        for kind, count in other.counts.items():
            self.counts[kind] = self.counts.get(kind, 0) + count
        for kind, (value, row) in other._worst.items():
            self._keep(kind, value, row)

    def _keep(self, kind: str, value: float, row: Numbers) -> None:
        known = self._worst.get(kind)
        # Of equal values the row decides, so that the order does not.
        if known is None or (value, _sorting(row)) > (known[0], _sorting(known[1])):
            self._worst[kind] = value, row

    def to_text(self) -> str:
        """Return the content as JSON, from which `from_text` makes the same tally."""
        worst = {kind: [value, [float(one[0]) for one in row]] for kind, (value, row) in self._worst.items()}
        return json.dumps([self.impacts, self.counts, worst])

    @classmethod
    def from_text(cls, text: str) -> Tally:
        """Return the tally of a text."""
        tally = cls()
        tally.impacts, tally.counts, worst = json.loads(text)
        tally._worst = {
            kind: (value, Numbers(*(np.array([one]) for one in row))) for kind, (value, row) in worst.items()
        }
        return tally

    def attributes(self, n_points: int) -> dict[str, str]:
        """Return the attribute of the result: the validity report of the worst impacts, with counts, as JSON.

        Parameters
        ----------
        n_points : int
            Number of impacts in the sweep.
        """
        if not self._worst:
            return {}
        worst = validity.report(validity.together(row for _, row in self._worst.values()))
        some = "" if self.impacts == n_points else " checked"
        checks = worst.to_dict()
        for kind, check in checks.items():
            check["exceeded_in"] = self.counts[kind]
            if check["exceeded"]:
                check["message"] += f"; exceeded in {self.counts[kind]} of {self.impacts} impacts{some}"
        return {"validity": text_of({"impacts": self.impacts, "checks": checks})}


def _sorting(row: Numbers) -> list[float]:
    return [float(np.nan_to_num(one[0])) for one in row]


def messages(dataset: xr.Dataset) -> dict[str, str]:
    """Return a message for each doubtful assumption in the result of a sweep, by kind."""
    checks = json.loads(dataset.attrs.get("validity", "{}")).get("checks", {})
    return {kind: check["message"] for kind, check in checks.items() if check["exceeded"]}
