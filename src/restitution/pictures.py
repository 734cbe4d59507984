"""The way from a result to its picture.

Results have a method `plot`, but pictures stand at the top of the layers, and nothing below may depend on them. This
function is the only place that loads them from below, by name and when a picture is asked for.
"""

from __future__ import annotations

from importlib import import_module
from typing import Any


def draw(place: str, *arguments: Any, **options: Any) -> Any:
    """Return the figure of a function of `restitution.plot`, named as "module.function".

    Examples
    --------
    >>> import restitution as rs
    >>> rubber = rs.PronySeries(1e6, [2e6], [1.0])
    >>> len(draw("material.overview", {"shear": rubber}, (0.01, 100.0)).axes)
    2
    """
    module, _, function = place.rpartition(".")
    return getattr(import_module(f"restitution.plot.{module}"), function)(*arguments, **options)
