"""Assumptions of the theory over many impacts: the number that exceed each limit, and the worst."""

from __future__ import annotations

import json
import math
from collections.abc import Mapping
from dataclasses import replace
from typing import Any

import numpy as np

from restitution.validity import Check, Numbers, Validity, excess, report, together

# The assumptions on the material, and the numbers that they limit.
_OF_MATERIAL = ("waves", "window", "poisson_ratio", "separability")
_NUMBERS_OF_MATERIAL = ("mach_number", "radiated_energy_ratio", "window_ratio", "instantaneous_poisson_ratio",
                        "lowest_poisson_ratio")  # fmt: skip


class Tally:
    """Counts of the impacts that exceed each limit, by kind, and the worst impact; tallies of chunks add up.

    `sampled_out` of the `impacts` were compared without the assumptions on the material.
    """

    def __init__(self) -> None:
        self.impacts = self.sampled_out = 0
        self.counts: dict[str, int] = {}
        self._worst: dict[str, tuple[float, Numbers]] = {}

    def add(self, numbers: Numbers, *, with_material: bool = True) -> None:
        """Count some impacts; without their material only the assumptions on the shape."""
        self.impacts += numbers.contact_time.size
        if not with_material:
            self.sampled_out += numbers.contact_time.size
            unknown = np.full(numbers.contact_time.shape, math.nan)
            numbers = numbers._replace(**dict.fromkeys(_NUMBERS_OF_MATERIAL, unknown))
        for kind, values in excess(numbers).items():
            self.counts[kind] = self.counts.get(kind, 0) + int(np.count_nonzero(values > 1.0))
            if not np.isnan(values).all():
                place = int(np.nanargmax(values))
                self._keep(kind, float(values[place]), Numbers(*(column[place : place + 1] for column in numbers)))

    def merge(self, other: Tally) -> None:
        """Add the counts of another tally; the order of tallies does not matter."""
        self.impacts += other.impacts
        self.sampled_out += other.sampled_out
        for kind, count in other.counts.items():
            self.counts[kind] = self.counts.get(kind, 0) + count
        for kind, (value, row) in other._worst.items():
            self._keep(kind, value, row)

    def _keep(self, kind: str, value: float, row: Numbers) -> None:
        worst = self._worst.get(kind)
        # Between equal values the row decides, so that the result does not depend on the order.
        if worst is None or value > worst[0] or (value == worst[0] and _sorting(row) > _sorting(worst[1])):
            self._worst[kind] = value, row

    def checked(self, kind: str) -> int:
        """Return how many impacts were compared with a limit."""
        return self.impacts - (self.sampled_out if kind in _OF_MATERIAL else 0)

    def report(self, n_impacts: int | None = None) -> Validity:
        """Return the validity report of the worst of `n_impacts` impacts, with counts of those above each limit."""
        total = self.impacts if n_impacts is None else n_impacts
        rows = [row for _, row in self._worst.values()]
        checks: list[Check] = []
        for check in report(together(rows)) if rows else ():
            checked = self.checked(check.kind)
            sample = f" checked, of {total}" if checked < total else ""
            message = f"{check.message}; exceeded in {self.counts[check.kind]} of {checked} impacts{sample}"
            checks.append(replace(check, message=message) if check.exceeded else check)
        return Validity(tuple(checks))

    def to_text(self) -> str:
        """Return the content as JSON, from which `from_text` makes the same tally."""
        worst = {kind: [value, [float(number[0]) for number in row]] for kind, (value, row) in self._worst.items()}
        return json.dumps([self.impacts, self.sampled_out, self.counts, worst])

    @classmethod
    def from_text(cls, text: str) -> Tally:
        """Return the tally of a text."""
        tally = cls()
        # Stores of version 0.1 have no number of sampled impacts.
        tally.impacts, *sampled, tally.counts, worst = json.loads(text)
        tally.sampled_out = sum(sampled)
        tally._worst = {
            kind: (value, Numbers(*(np.array([number]) for number in row))) for kind, (value, row) in worst.items()
        }
        return tally

    def attributes(self, n_points: int) -> dict[str, str]:
        """Return the attribute of a dataset of `n_points` impacts: the report with the counts, as JSON."""
        checks = self.report(n_points).to_dict()
        for kind, check in checks.items():
            check |= {"exceeded_in": self.counts[kind], "checked": self.checked(kind)}
        content = {"impacts": self.impacts, "checks": checks}
        text = json.dumps(content, ensure_ascii=False, separators=(",", ":"))
        return {"validity": text} if checks else {}


def _sorting(row: Numbers) -> list[float]:
    return np.nan_to_num(np.concatenate(row)).tolist()


def checks(attributes: Mapping[str, Any]) -> dict[str, Any]:
    """Return the checks of the worst impacts from the attributes of a dataset, by kind, with counts."""
    return json.loads(attributes.get("validity", "{}")).get("checks", {})


def messages(attributes: Mapping[str, Any]) -> dict[str, str]:
    """Return a message for each doubtful assumption from the attributes of a dataset, by kind."""
    items = checks(attributes).items()
    return {kind: f"{check['message']}. {check['advice']}" for kind, check in items if check["exceeded"]}
