"""Access from results to their pictures, which belong to a higher layer and are therefore loaded by name."""

from __future__ import annotations

from importlib import import_module
from typing import Any


def draw(place: str, *arguments: Any, **options: Any) -> Any:
    """Return the figure of a function of `restitution.plot`, named as "module.function"."""
    module, _, function = place.rpartition(".")
    return getattr(import_module(f"restitution.plot.{module}"), function)(*arguments, **options)
