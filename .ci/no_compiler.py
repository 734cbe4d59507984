"""Solve what `restitution warm-up` solves with an installed wheel, and fail if a function of it is compiled."""

import os
import sys
import sysconfig
from pathlib import Path

# Single problems would run without machine code.
os.environ["NUMBA_DISABLE_JIT"] = "0"

from numba.core import event

import restitution
from restitution.cli import warm_up


class Compiled(event.Listener):
    """Names of the functions that are compiled."""

    def __init__(self) -> None:
        self.names: list[str] = []

    def on_start(self, event: event.Event) -> None:
        function = event.data["dispatcher"].py_func
        self.names.append(f"{function.__module__}.{function.__qualname__}")

    def on_end(self, event: event.Event) -> None:
        pass


compiled = Compiled()
if not Path(restitution.__file__).is_relative_to(sysconfig.get_path("purelib")):
    sys.exit(f"{restitution.__file__}: no installed wheel")
with event.install_listener("numba:compile", compiled):
    warm_up.solve(list(warm_up.PROBLEMS))
if compiled.names:
    sys.exit(f"compiled although the wheel has bitcode: {', '.join(compiled.names)}")
