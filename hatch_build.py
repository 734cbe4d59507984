"""Wheel for one Python and one kind of processor, with bitcode of the kernel, where `RESTITUTION_BITCODE` names it."""

import os
import sys
import sysconfig
from typing import Any

from hatchling.builders.hooks.plugin.interface import BuildHookInterface


class BitcodeHook(BuildHookInterface):
    """Put the files that `restitution warm-up` has written into the wheel; without them it is for every Python."""

    def initialize(self, version: str, build_data: dict[str, Any]) -> None:
        """Add the folder, and name the Python and the system in the name of the wheel."""
        folder = os.environ.get("RESTITUTION_BITCODE")
        if version == "editable" or not folder:
            return
        if not os.path.isdir(folder) or not os.listdir(folder):
            raise FileNotFoundError(
                f"RESTITUTION_BITCODE = {folder}: no files; run `restitution warm-up` with it first"
            )
        build_data["force_include"][folder] = "restitution/kernel/bitcode"
        build_data["pure_python"] = False
        python = f"cp{sys.version_info[0]}{sys.version_info[1]}"
        # The oldest Linux for which numba has wheels.
        system = sysconfig.get_platform().replace("linux", "manylinux_2_28").replace("-", "_").replace(".", "_")
        build_data["tag"] = f"{python}-{python}-{system}"
