"""Description of the machine of a measurement."""

from __future__ import annotations

import os
import platform
import subprocess
import sys
from importlib.metadata import version
from pathlib import Path
from typing import NamedTuple

_PACKAGES = ("numpy", "numba", "llvmlite", "scipy")


class Machine(NamedTuple):
    """Processor, cores that this process may use, system, and versions of the packages."""

    processor: str
    cores: int
    system: str
    versions: dict[str, str]

    def lines(self) -> tuple[str, str]:
        """The machine and the versions, in words."""
        cores = f"{self.cores} core{'s' if self.cores > 1 else ''}"
        return (
            f"{self.processor}, {cores}, {self.system}",
            ", ".join(f"{name} {number}" for name, number in self.versions.items()),
        )


def describe() -> Machine:
    """Describe this machine."""
    versions = {"restitution": version("restitution"), "Python": platform.python_version()}
    versions |= {name: version(name) for name in _PACKAGES}
    return Machine(_processor(), os.cpu_count() or 1, f"{platform.system()} {platform.machine()}", versions)


def _processor() -> str:
    """Name of the processor, or its architecture if the system does not provide the name."""
    try:
        if sys.platform == "linux":
            return _from_cpuinfo(Path("/proc/cpuinfo").read_text(encoding="utf-8"))
        if sys.platform == "darwin":
            command = ["sysctl", "-n", "machdep.cpu.brand_string"]
            return subprocess.run(command, capture_output=True, text=True, check=True).stdout.strip()
    except (OSError, KeyError, subprocess.CalledProcessError):
        pass
    return platform.processor() or platform.machine()


def _from_cpuinfo(text: str) -> str:
    pairs = (line.partition(":") for line in text.splitlines())
    fields = {name.strip(): value.strip() for name, _, value in pairs}
    name = fields["model name"]
    # Virtual machines often hide the model but not the family, which identifies the generation.
    return f"{name} (family {fields['cpu family']}, model {fields['model']})"
