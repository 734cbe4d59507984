"""The way from a result to its picture.

Results have a method `plot`, but pictures stand at the top of the layers, and nothing below may depend on them. This
function is the only place that loads them from below, by name and when a picture is asked for.
"""

from __future__ import annotations

from importlib import import_module
from typing import Any


def draw(kind: str, *arguments: Any, **options: Any) -> Any:
    """Return the figure that `restitution.plot.KIND.overview` draws.

    Examples
    --------
    >>> import restitution as rs
    >>> rubber = rs.PronySeries(1e6, [2e6], [1.0])
    >>> len(draw("material", {"shear": rubber}, (0.01, 100.0)).axes)
    2
    """
    return import_module(f"restitution.plot.{kind}").overview(*arguments, **options)
