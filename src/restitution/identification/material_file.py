"""Case files of identified materials, which `restitution solve` reads."""

from __future__ import annotations

import json
import math
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from restitution.files import whole_file
from restitution.identification.bounce_times import BounceTimes
from restitution.identification.force_history import ForceHistory
from restitution.identification.rebounds import Rebounds
from restitution.material.prony import PronySeries

if TYPE_CHECKING:
    from restitution.identification.result import Identification


# Contact time over its beginning, a third of depth over velocity, at most; 8.8 for an elastic ball.
_BEGINNING = 14.0


def write_material(found: Identification, path: str | Path) -> Path:
    """Write the best material with its errors as comments, and the first ball of the data, if any."""
    low, high = found.window
    comments = [
        f"Identified from {', '.join(one.label or repr(one) for one in found.data)}",
        f"chi2/dof = {found.reduced_chi2:.4g}, {found.degrees_of_freedom} degrees of freedom",
        f"holds from {low:.4g} to {high:.4g} rad/s" if math.isfinite(low) else "the data contain no time",
        *(f"{name} = {one.words}" for name, one in found.parameters.items()),
        f"covariance of the logarithms of {', '.join(found.parameters)}:",
        *(" ".join(f"{value:.4e}" for value in row) for row in found.covariance),
    ]
    lines = [f"# {line}" for comment in comments for line in comment.splitlines()]
    lines += ["", "[material]"]
    if math.isfinite(low):
        shortest, longest = known_times(found)
        # The commands refuse contacts beyond it.
        lines.append(f"window = [{shortest!r}, {longest!r}]")
    if found.undetermined:
        # Results warn of them.
        lines.append(f"undetermined = {json.dumps(list(found.undetermined))}")
    lines += [f"{key} = {_value(value)}" for key, value in _section(found).items()]
    balls = next((one for one in found.data if isinstance(one, Rebounds)), None)
    if balls is not None and balls.radius is not None and balls.counter_material is None:
        radius, mass, velocity = (float(column[0]) for column in (balls.radius, balls.mass, balls.velocity))
        lines += ["", "[body]", f"radius = {radius!r}", f"mass = {mass!r}"]
        lines += ["", "[profile]", 'type = "parabola"', "", "[impact]", f"velocity = {velocity!r}"]
    with whole_file(path) as partial:
        partial.write_text("\n".join(lines) + "\n", encoding="utf-8")
    return Path(path)


def known_times(found: Identification) -> tuple[float, float]:
    """Shortest and longest time [s] for which the data determine the material.

    An impact that lasts T contributes the frequency pi/T, and determines the material from its beginning to T.
    """
    low, high = found.window
    if not all(isinstance(one, Rebounds | BounceTimes | ForceHistory) for one in found.data):
        return 1.0 / high, 1.0 / low
    return math.pi / high / _BEGINNING, math.pi / low


def _section(found: Identification) -> dict[str, Any]:
    """Keys of the material: constants of a model of the package, or else relaxation functions."""
    space = found.problem.space
    if space.entry is not None:
        arguments = space.arguments(found.coordinates[None, : found.problem.n_parameters])
        names = [name for name in space.entry.constants if name in arguments]
        return {"model": space.entry.name} | {name: np.asarray(arguments[name])[0].tolist() for name in names}
    shear, bulk = found.columns.shear.row(0), found.columns.bulk
    if math.isinf(bulk.equilibria[0]):
        return {"shear": shear, "bulk_modulus": math.inf}
    elastic = not bulk.moduli.any() and not bulk.viscosities.any()
    constant = {"bulk_modulus": float(bulk.equilibria[0])}
    return {"shear": shear} | (constant if elastic else {"bulk": bulk.row(0)})


def _value(value: Any) -> str:
    if isinstance(value, PronySeries):
        parts = {
            "equilibrium_modulus": value.equilibrium_modulus,
            "branch_moduli": value.branch_moduli.tolist(),
            "relaxation_times": value.relaxation_times.tolist(),
            "parallel_viscosity": value.parallel_viscosity,
        }
        return "{ " + ", ".join(f"{name} = {_value(part)}" for name, part in parts.items()) + " }"
    return json.dumps(value).replace("Infinity", "inf")
