"""Many impacts over named axes.

The package is also the function: `restitution.sweep(...)` is `restitution.sweep.run.sweep(...)`.
"""

import sys
from inspect import Signature
from types import ModuleType
from typing import Any


class _Package(ModuleType):
    # One name for the layer and for the function: to import a module of the layer must not hide the function.
    def __call__(self, *args: Any, **options: Any) -> Any:
        """Sweep; see `restitution.sweep.run.sweep`."""
        from restitution.sweep.run import sweep

        return sweep(*args, **options)

    @property
    def __signature__(self) -> Signature:
        from inspect import signature

        from restitution.sweep.run import sweep

        return signature(sweep)


sys.modules[__name__].__class__ = _Package
