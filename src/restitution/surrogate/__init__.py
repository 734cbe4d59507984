"""Interpolants of a stated error in place of solves.

The package is also the function: `restitution.surrogate(...)` is `restitution.surrogate.build.surrogate(...)`.
"""

import sys
from inspect import Signature
from types import ModuleType
from typing import Any


class _Package(ModuleType):
    # One name for the layer and for the function: to import a module of the layer must not hide the function.
    def __call__(self, *args: Any, **options: Any) -> Any:
        """Build a surrogate; see `restitution.surrogate.build.surrogate`."""
        from restitution.surrogate.build import surrogate

        return surrogate(*args, **options)

    @property
    def __signature__(self) -> Signature:
        from inspect import signature

        from restitution.surrogate.build import surrogate

        return signature(surrogate)


sys.modules[__name__].__class__ = _Package
